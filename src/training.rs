//! Learning how a person resolves redundancy, from recorded movements.
//!
//! ```text
//! Recording (segment poses) ─ fit ─► JointMotion (q, qdot of one body, near its limits) ───┐
//! joint-motion CSV ─ read_motion ──────────────────────────────────────────────────► Trial ┴► Dataset
//! Dataset ─ methods (z and W) ─ evaluate (held out) ─ train (all) ─► PostureModel
//! ```
//! [`fit()`] solves one bounded least-squares problem per frame; its parts are the recorded targets,
//! the chain with its residuals, and an active set that keeps every posture inside all limits.
//! [`read_person`] reads and fits all recordings of one person. [`train()`] learns the chosen method on everything after all methods have been judged on movement
//! that they had not seen. [`toy5r`] is the paper's problem with a known truth, for judging methods;
//! [`toy5r_paper`] holds the paper's own figures for it. [`size_experiment`] shows how cost and quality
//! grow with the number of frames, on movements of the simulated operator. [`weight_spread`] and
//! [`held_out_curves`] are what the pictures of a training show. [`paper`] repeats the paper's experiments
//! with people.

mod active_set;
mod adapt;
mod calibration;
mod calibration_experiment;
mod chain;
mod data_file;
mod dataset;
mod evaluate;
mod export;
mod filled;
mod fit;

mod fit_remarks;
mod fit_report;
#[cfg(test)]
mod fit_tests;
#[cfg(test)]
mod head_tests;
mod held_out_curves;
mod import;
#[cfg(test)]
mod map_tests;
mod measurer;
mod methods;
mod modes;
mod motion_file;
mod noise_fit;
mod over_feet;
pub mod paper;
pub mod people;
mod rollout_check;
mod settings;
mod sharing;
#[cfg(test)]
mod shipped_map_tests;
mod simulated_movements;
mod size_experiment;
mod source;
mod spread;
mod standing;
mod strangers;
mod targets;
pub mod toy5r;
mod toy5r_experiment;
pub mod toy5r_paper;
mod train;
mod upright;
mod way;
mod weight_spread;

pub use adapt::{SHORTEST_S, adapt, recorded_s};
pub use calibration_experiment::{CalibrationCell, run_calibration};
pub use data_file::{DataFile, read_data, task_of_rows};
pub use dataset::{DataRow, Dataset, Fold, Frame, Trial};
pub use evaluate::{
    Evaluation, GroupScore, Judging, MethodScore, Percentiles, evaluate, learn_with_noise,
};
pub use export::data_csv;
pub use fit::{FitSettings, JointMotion, fit};
pub use fit_report::{Beyond, FitReport, SegmentLength, Spread};
pub use held_out_curves::{BAND_LEVELS, HeldOutCurves, JointCurves, held_out_curves};
pub use import::{
    Drift, Import, ImportRequest, ImportedFile, ImportedRun, MotionLook, PartSize, QUALITY_FILE,
    QualityRow, Residuals, SegmentQuality, Sizes, drift, import, read_quality,
};
pub use methods::{Law, WeightUncertainty, learn_laws};
#[doc(hidden)]
pub use methods::{with_kernel_search, with_weight_search};
pub use motion_file::{
    FITTED_MARK, MotionFile, SIMULATED_MARK, motion_text, read_motion, trial_of,
};
pub use noise_fit::learn_noise;
pub use rollout_check::{
    Bands, LearnedRepetitions, RolloutScore, TrialWalk, check_rollouts, learn_repetitions,
    path_error_deg,
};
pub use settings::{Lengths, Objective, Optimiser, PullRule, TrainSettings};
pub use simulated_movements::{Reach, SimulatedMovements};
pub use size_experiment::{SizeExperiment, SizeQuestion, SizeRow, size_experiment};
pub use source::{
    Angles, Source, Whom, provenance, read_person, read_source, refuse_twice, remarks_of,
};
pub use spread::{Residual, learn_attraction, learn_postures, pull, unseen_residuals};
pub use toy5r_experiment::{
    InSampleCheck, ToyMethod, ToyResult, ToyScore, run_toy, toy_dataset, toy_methods,
};
pub use train::{learn, train};
pub use weight_spread::{JointWeight, WeightSpread, weight_spread};

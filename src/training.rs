//! Learning how a person resolves redundancy, from recorded movements.
//!
//! ```text
//! Recording (segment poses) ─ fit ─► JointMotion (q, qdot of one body, near its limits) ───┐
//! joint-motion CSV ─ read_motion ──────────────────────────────────────────────────► Trial ┴► Dataset
//! Dataset ─ methods (z and W) ─ evaluate (held out) ─ train (all) ─► PostureModel
//! ```
//! [`fit()`] solves one bounded least-squares problem per frame; its parts are the recorded targets,
//! the chain with its residuals, and an active set that keeps every posture inside all limits.
//! [`train()`] learns the chosen method on everything after all methods have been judged on movement
//! that they had not seen.

mod active_set;
mod calibration;
mod chain;
mod dataset;
mod evaluate;
mod export;
mod fit;
mod fit_notes;
mod fit_report;
#[cfg(test)]
mod fit_tests;
mod methods;
mod motion_file;
mod settings;
mod sharing;
mod spread;
mod targets;
mod train;

pub use dataset::{Dataset, Fold, Frame, Trial};
pub use evaluate::{evaluate, path_error_deg};
pub use export::data_csv;
pub use fit::{FitSettings, JointMotion, fit};
pub use fit_report::{Beyond, FitReport, SegmentLength, Spread};
pub use methods::{Law, learn_laws};
pub use motion_file::{MotionFile, SIMULATED_MARK, motion_text, read_motion};
pub use settings::TrainSettings;
pub use spread::{
    Residual, covariance, learn_attraction, learn_noise, learn_postures, pull, unseen_residuals,
};
pub use train::train;

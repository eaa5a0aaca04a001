//! How a person resolves the redundancy of the body: the learned model and its rollouts.
//!
//! One formula carries every method. A joint velocity is Gaussian with preferred mean `z(q, xdot)`
//! and covariance `W`, conditioned on meeting the task `J qdot = xdot`:
//!
//! ```text
//! mean        z + J_W^+ (xdot - J z)            J_W^+ = W J^T (J W J^T)^-1
//! covariance  W - W J^T (J W J^T)^-1 J W
//! ```
//! The plain pseudo-inverse, a diagonal or a full `W`, the paper's control law (eq. 3), its Gaussian
//! process in the null space, and the pull towards the person's own postures are choices of `z` and
//! `W`.
//!
//! ```text
//! PostureModel ─ start ─► start postures ─ rollout (closed loop, limits, noise) ─► Rollouts
//! ```

mod adapt;
mod attraction;
mod behaviour;
mod conditional;
mod coupling;
mod file;
mod fill;
mod grips;
mod hand_path;
mod inducing;
mod kernel;
mod law;
mod lowness;
mod model;
mod modes;
mod noise;
mod pair;
mod population;
mod primitive;
mod process;
mod proof;
mod rollout;
mod simulated;
mod standing;
mod start;
mod step;

pub use adapt::Unsuitable;
pub use attraction::{Attraction, HandFeatures, Origin, Pull, UsualPosture};
pub use behaviour::{Behaviour, Certain, Modelled, PERSONS, Repeated};
pub use conditional::{Conditional, condition};
pub use coupling::{Coupling, Hold, Observation};
pub use file::{MODEL_SCHEMA, load_model, model_text, save_model};
pub use fill::{Filling, Unrecorded};
pub use grips::Grips;
pub use hand_path::{HandPath, postures_at};
pub use kernel::{GpHyper, InputScale, cross_kernel, lower_kernel, reduced};
pub use law::{Draw, Floors, PostureLaw, Prediction, Query, Sampler, Sampling};
pub use lowness::Lowness;
pub(crate) use model::gaussian_99;
pub use model::{
    LowPostures, Method, MethodQuality, PostureDistribution, PostureModel, Provenance, joint_group,
};
pub use modes::{LowMovement, Mixture, Mode, Modes, low_place};
pub use noise::{
    Clock, Drift, DriftPath, LowNoise, Noise, NoisePath, NoiseShares, gain, speed_squared,
};
pub use pair::Pair;
pub use population::Population;
pub use primitive::{Primitive, basis};
pub use process::{FunctionDraw, Posterior, Process};
pub use rollout::{Rollout, roll_out};
pub use simulated::{
    natural_grip, simulated_operator, simulated_person, simulated_whole_operator,
    simulated_whole_person,
};
pub use standing::{Feet, Footing, STEP_S, StandingDraw, StandingPlace, Stepper};
pub use start::{Start, StartRule, start_postures};
pub use step::{Allowed, Bounds, ReachExceeded, StepSolver};

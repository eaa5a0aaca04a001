//! The robot's TCP path: which paths are tried, what they may not exceed, how a path is brought
//! within its limits, and the independent check that it is.
//!
//! [`candidates`] makes via-points, [`reference_path`] turns them into a timed path that knows no
//! limits, [`project`] finds the nearest path that keeps all limits or says why there is none, and
//! [`verify`] and [`verify_samples`] measure any path against the limits by other code.
//! Positions are those of the TCP in the world, m.

mod arm;
mod bounds;
mod candidate;
mod change;
mod hull;
mod keepout;
mod limits;
mod nearest;
mod pace;
mod project;
mod refusal;
mod remedy;
mod scene;
mod smooth;
mod spline;
mod stencil;
mod transcription;
mod turning;
mod verify;

pub use arm::{Arm, Followed, project_for_arm};
pub use candidate::{
    Candidate, CandidateSettings, Family, ViaSpace, candidates, drawn, reference_path,
};
pub use change::{Change, Mover};
pub use limits::{Box3, Face, PathLimits};
pub use pace::Pace;
pub use project::{Projection, ProjectionSettings, project, project_within, shortest_duration_s};
pub use refusal::{Cause, End, InputFault, LimitName, NoAnswer, NoPath};
pub use remedy::smallest_changes;
pub use scene::{Condition, Order, Reach, Scene};
pub use smooth::SmoothPath;
pub use spline::ClampedSpline;
pub use turning::{Turning, sway};
pub use verify::{
    Check, Quantity, Verification, verify, verify_motion, verify_optimality, verify_samples,
    verify_samples_within, verify_scene,
};

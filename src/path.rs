//! The robot's TCP path: which paths are tried, what they may not exceed, how a path is brought
//! within its limits, and the independent check that it is.
//!
//! [`candidates`] makes via-points, [`reference_path`] turns them into a timed path that knows no
//! limits, [`project`] finds the nearest path that keeps all limits or says why there is none, and
//! [`verify`] and [`verify_samples`] measure any path against the limits by other code.
//! Positions are those of the TCP in the world, m.

mod bounds;
mod candidate;
mod limits;
mod project;
mod smooth;
mod spline;
mod transcription;
mod verify;

pub use candidate::{
    Candidate, CandidateSettings, Family, ViaSpace, candidates, drawn, reference_path,
};
pub use limits::{Box3, PathLimits};
pub use project::{Cause, Projection, ProjectionSettings, project, shortest_duration_s};
pub use smooth::SmoothPath;
pub use spline::ClampedSpline;
pub use verify::{Check, Quantity, Verification, verify, verify_samples};

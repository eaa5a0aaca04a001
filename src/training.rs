//! Learning how a person resolves redundancy, from recorded movements.
//!
//! ```text
//! Recording (segment poses) ─ fit ─► JointMotion (q, qdot of one body, inside its limits)
//! ```
//! [`fit()`] solves one bounded least-squares problem per frame; its parts are the recorded targets,
//! the chain with its residuals, and an active set that keeps every posture inside all limits.

mod active_set;
mod chain;
mod fit;
mod fit_report;
#[cfg(test)]
mod fit_tests;
mod targets;

pub use fit::{FitSettings, JointMotion, fit};
pub use fit_report::{FitReport, SegmentLength, Spread};

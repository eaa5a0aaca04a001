//! Mathematics that is true of any robot, body or cost: poses, weighted pseudo-inverses, statistics,
//! random streams and filters.

pub mod cma;
pub mod dense;
pub mod pose;
pub mod redundancy;
pub mod segment;
pub mod signal;
pub mod simd;
pub mod stats;
pub mod stream;

pub use pose::{Pose, Rotation, Vec3, Vec6};

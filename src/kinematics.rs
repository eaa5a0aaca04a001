//! Articulated bodies: an immutable model read from URDF, forward kinematics and Jacobians.
//!
//! ```text
//! URDF file ─ urdf ─► Model (links, joints, shapes) ─ linkage ─► Linkage (base link, tip frames)
//! Linkage + q ─ forward ─► Frames ─ tip_pose, jacobian ─► X_BT, J (6 x n)
//! ```
//! Poses are those of a tip frame T in the base link's frame B; Jacobian rows are linear x y z, then
//! angular x y z, in base axes, at the tip.

mod linkage;
mod model;
mod urdf;

pub use linkage::{Frames, JointLimit, Linkage, LinkageError, Tip};
pub use model::{Joint, JointKind, Link, LinkMesh, Mimic, Model, ModelError, Shape};
pub use urdf::{parse_urdf, read_urdf};

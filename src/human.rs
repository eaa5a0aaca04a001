//! The worker's body: a parametric digital human of 66 joints, its limits and its skeleton.
//!
//! 23 segments and 22 spherical joints with Xsens names, each joint three revolutes in the order
//! Z, X, Y about ISB axes (x forward, y up, z right, for both sides). At zero all segment frames are
//! parallel: standing upright, arms hanging, **palms forward** (full supination). The zero of
//! pronation (`jRightElbow_Y`) is therefore full supination; mid-prone, the thumb forward, is +90
//! deg on the right and -90 deg on the left.
//!
//! Signs on the right side: flexion of shoulder, elbow, wrist and hip is +Z, flexion of spine, neck
//! and knee is -Z; abduction of shoulder and hip is -X, ulnar deviation +X; pronation and internal
//! rotation are +Y. The left side mirrors X and Y.

mod balance;
mod body;
mod envelope;
mod generate;
mod legs;
mod limits;
mod mirror;
mod named_grip;
mod pelvis;
mod proportions;
mod reach;
mod shape;
mod side;
mod skeleton;
mod workforce;

pub use balance::{Balance, BalanceRow};
pub use body::{Body, PRESETS, Stance};
pub use envelope::{BodyPart, Envelope, EnvelopeScratch};
pub use generate::{BodyFiles, generate};
pub use legs::{Bending, LegPosture, Legs, PelvisRow};
pub use limits::{PostureLimits, SPINE_SHARES, SumLimit, SumRow};
pub use mirror::{mirror_sign, mirrored_pose, other_side_joint};
pub use named_grip::{NamedGrip, palm};
pub use pelvis::{
    FEET_COLUMNS, PELVIS_JOINTS, column_of, column_unit, pelvis_coordinates, pelvis_in_rest,
};
pub use proportions::{BodySize, Sex};
pub use reach::{reach_ball, reach_gap};
pub use shape::{Mannequin, MannequinPiece, SegmentKind, WideSection};
pub use side::{Coupled, Hands, Pelvis, Side};
pub use skeleton::{Head, PosedSkeleton, Segment, Skeleton};
pub use workforce::{POPULATION, workforce};

//! Robot arms: can this arm follow that path of its tool, within its limits, and how near does it
//! come to obstacles?
//!
//! ```text
//! preset | URDF ─ description ─► Robot (linkage, limits, home, base, capsules)
//! TCP poses in the world ─ follow (ik) ─► joint path ─ check, collide ─► RobotMotion | why not
//!   several motions: the least cost (grade); poor ones once more in the null space (ease);
//!   where that fails, on request, branch and redundancy by dynamic programming (resolve)
//! motion ─ moves | stream ─► what controllers take, and its limits checked again
//! user's joint path ─ check_joint_path ─► limits broken;  tcp_poses ─► TCP poses in the world
//! q ─ body ─► capsules, stick figure ─ clearance ─► distance to obstacles
//! ```
//! Joint values are in rad (m for sliding joints), in the order of the joints from base to TCP.

mod between;
mod body;
mod check;
mod clearance;
mod collide;
mod description;
mod ease;
mod follow;
mod grade;
mod ik;
mod joint_trajectory;
mod link_shapes;
mod mesh_files;
mod moves;
mod odd_rates;
mod preset;
mod refusal;
mod resolve;
mod room;
mod stream;
mod track;

pub use between::{Between, between};
pub use body::{
    ArmPart, Capsule, Nearest, arm_parts, arm_places, capsules, joint_rates, min_clearance,
    min_singular_value, stick, tcp_pose, tcp_poses,
};
pub use check::{
    Extreme, LimitKind, PathCheck, PathError, RobotMotion, Violation, check_joint_path,
};
pub use clearance::Obstacle;
pub use collide::{SelfNearest, measure_room, self_clearance};
pub use description::{Assumed, Brake, Limits, Robot, RobotNote};
pub use follow::{Follow, FollowSettings, Starts, follow, follow_from, start_postures};
pub use joint_trajectory::{
    Duration, Header, JointMargin, JointTrajectory, Point, TrajectoryFault,
};
pub use link_shapes::{AssumedShapes, MeshFault, MissingMesh};
pub use moves::{Move, Moves, NoMoves, TICK_S};
pub use odd_rates::OddRate;
pub use preset::PRESETS;
pub use refusal::{AtLimit, NoMotion};
pub use room::{NotChecked, ObstacleClearance, RobotFacts, RobotMargins, SelfCheck, SelfClearance};
pub use stream::Stream;
pub use track::trace;

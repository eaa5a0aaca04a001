//! What would have to change for a path to exist.

use super::limits::Face;
use super::refusal::End;
use super::verify::Quantity;
use crate::math::Vec3;
use crate::robot::LimitKind;
use serde::{Deserialize, Serialize};

/// Who moves away from the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mover {
    /// The robot's base.
    Robot,
    /// The worker.
    Worker,
}

/// One thing to change, everything else as it is. Lengths in m, times in s, angles in rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "change", rename_all = "snake_case")]
pub enum Change {
    /// More time.
    Duration {
        /// Given, s.
        from_s: f64,
        /// Needed, s.
        to_s: f64,
    },
    /// A higher limit of the TCP.
    Limit {
        /// Of what.
        of: Quantity,
        /// Given.
        from: f64,
        /// Needed.
        to: f64,
    },
    /// Another start or goal.
    MoveEnd {
        /// Which.
        end: End,
        /// How far, m.
        by_m: f64,
        /// To where, world, m.
        to_m: Vec3,
    },
    /// A face of the workspace box farther out.
    MoveFace {
        /// The face.
        face: Face,
        /// How far, m.
        by_m: f64,
    },
    /// An obstacle that is smaller all round, or a tool that is slimmer.
    ShrinkObstacle {
        /// Its name.
        name: String,
        /// By how much, m.
        by_m: f64,
    },
    /// A wider corridor.
    WidenCorridor {
        /// Given, m.
        from_m: f64,
        /// Needed, m.
        to_m: f64,
    },
    /// A longer reach, or a worker who stands nearer.
    ExtendReach {
        /// Whose.
        body: String,
        /// By how much, m.
        by_m: f64,
    },
    /// A higher limit of a joint of the robot.
    JointLimit {
        /// The joint.
        joint: String,
        /// Which limit.
        of: LimitKind,
        /// True for a joint that slides.
        is_prismatic: bool,
        /// Given.
        from: f64,
        /// Needed.
        to: f64,
    },
    /// Robot or person farther from the other.
    MoveApart {
        /// Which of the two moves.
        what: Mover,
        /// By how much, m.
        by_m: f64,
    },
    /// A path, or a robot base, that is nearer.
    RobotReach {
        /// By how much the path leaves what the arm reaches, m.
        by_m: f64,
        /// When it is farthest out, s.
        at_s: f64,
    },
}

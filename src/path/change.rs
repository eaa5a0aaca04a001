//! What would have to change for a path to exist, in the user's words.

use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

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
        /// Which: "speed", "acceleration", "jerk", "angular speed" or "angular acceleration".
        name: Cow<'static, str>,
        /// Its unit.
        unit: Cow<'static, str>,
        /// Given.
        from: f64,
        /// Needed.
        to: f64,
    },
    /// Another start or goal.
    MoveEnd {
        /// "start" or "goal".
        end: Cow<'static, str>,
        /// How far, m.
        by_m: f64,
        /// To where, world, m.
        to_m: Vec3,
    },
    /// A face of the workspace box farther out.
    MoveFace {
        /// The face in words.
        face: String,
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
        /// "position", "speed" or "acceleration".
        of: Cow<'static, str>,
        /// Its unit.
        unit: Cow<'static, str>,
        /// Given.
        from: f64,
        /// Needed.
        to: f64,
    },
    /// Robot or person farther from the other.
    MoveApart {
        /// "robot's base" or "worker".
        what: Cow<'static, str>,
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

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Upward, so that what is printed is enough.
        let up = |x: f64| (x * 100.0 - 1e-9).ceil() / 100.0;
        let mm = |x: &f64| (x * 1e3 - 1e-6).ceil().max(1.0);
        match self {
            Self::Duration { from_s, to_s } => {
                write!(f, "{:.2} s instead of {from_s:.2} s", up(*to_s))
            }
            Self::Limit { name, unit, from, to } => {
                write!(
                    f,
                    "a limit of {:.2} {unit} instead of {from:.2} {unit} on the {name}",
                    up(*to)
                )
            }
            Self::MoveEnd { end, by_m, to_m } => write!(
                f,
                "the {end} {:.0} mm away, at ({:.3}, {:.3}, {:.3}) m",
                mm(by_m),
                to_m.x,
                to_m.y,
                to_m.z
            ),
            Self::MoveFace { face, by_m } => {
                write!(f, "the face {face} of the workspace box {:.0} mm farther out", mm(by_m))
            }
            Self::ShrinkObstacle { name, by_m } => {
                write!(f, "obstacle `{name}` (or the clearance) {:.0} mm smaller", mm(by_m))
            }
            Self::WidenCorridor { from_m, to_m } => {
                write!(f, "a corridor of {:.0} mm instead of {:.0} mm", mm(to_m), from_m * 1e3)
            }
            Self::ExtendReach { body, by_m } => {
                write!(f, "body `{body}` {:.0} mm nearer", mm(by_m))
            }
            Self::JointLimit { joint, of, unit, from, to } => write!(
                f,
                "a limit of {:.2} {unit} instead of {from:.2} {unit} on the {of} of joint `{joint}`",
                up(*to)
            ),
            Self::MoveApart { what, by_m } if what == "worker" => {
                write!(f, "the worker {:.0} mm farther from the robot", mm(by_m))
            }
            Self::MoveApart { what, by_m } => {
                write!(f, "the {what} {:.0} mm farther from the worker", mm(by_m))
            }
            Self::RobotReach { by_m, at_s } => {
                write!(f, "a path or a robot base that is {:.0} mm nearer at {at_s:.2} s", mm(by_m))
            }
        }
    }
}

/// "; one of these would do: A, or B"; empty without changes.
pub fn or_list(changes: &[Change]) -> String {
    if changes.is_empty() {
        return String::new();
    }
    let all: Vec<String> = changes.iter().map(ToString::to_string).collect();
    let lead = if all.len() == 1 { "what would help" } else { "what would help, each alone" };
    format!("; {lead}: {}", all.join(", or "))
}

//! Why a robot cannot follow a path: facts, to be put into words where they are shown.

use super::check::{LimitKind, PathError, Violation};
use super::collide::SelfNearest;
use crate::files::null_as_nan;
use serde::{Deserialize, Serialize};

/// A joint that stands at one of its limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AtLimit {
    /// Name of the joint.
    pub joint: String,
    /// The limit, rad or m.
    pub limit: f64,
    /// True for a joint that slides.
    pub is_prismatic: bool,
}

/// Why there is no motion along a path. Times in s, lengths in m, angles in rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum NoMotion {
    /// The path is malformed.
    Malformed {
        /// What is wrong with it.
        fault: PathError,
    },
    /// No posture is known in which the arm could start.
    NoStart,
    /// A pose that no posture reaches.
    OutOfReach {
        /// When.
        time_s: f64,
        /// Distance of the nearest posture found; infinite if none was.
        #[serde(deserialize_with = "null_as_nan")]
        residual_m: f64,
        /// Its angle from the wanted orientation.
        #[serde(deserialize_with = "null_as_nan")]
        residual_rad: f64,
        /// Joints of that posture that stand at a limit.
        at_limits: Vec<AtLimit>,
    },
    /// A pose that can be reached, but not from the posture before it.
    Jump {
        /// When.
        time_s: f64,
        /// Joints at a limit where the motion stopped.
        at_limits: Vec<AtLimit>,
    },
    /// A joint breaks a limit.
    OverLimit {
        /// The worst.
        violation: Violation,
        /// Whether the arm is nearly singular there.
        is_nearly_singular: bool,
    },
    /// The arm touches itself.
    TouchesItself {
        /// Where it is worst.
        nearest: SelfNearest,
    },
    /// A limit is kept at the knots and broken between them.
    BetweenKnots {
        /// The joint.
        joint: String,
        /// Which limit.
        of: LimitKind,
        /// Largest share of the limit; for positions how far the joint is beyond it, rad or m.
        value: f64,
        /// When.
        time_s: f64,
    },
}

impl NoMotion {
    /// When the robot fails, s; 0 if the path is malformed as a whole or no start is known.
    pub fn time_s(&self) -> f64 {
        match self {
            Self::Malformed { fault } => fault.time_s(),
            Self::NoStart => 0.0,
            Self::OutOfReach { time_s, .. }
            | Self::Jump { time_s, .. }
            | Self::BetweenKnots { time_s, .. } => *time_s,
            Self::OverLimit { violation, .. } => violation.time_s,
            Self::TouchesItself { nearest } => nearest.time_s,
        }
    }
}

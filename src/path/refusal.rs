//! Why there is no path: facts, to be put into words where they are shown.

use super::limits::Face;
use crate::files::null_as_nan;
use crate::robot::NoMotion;
use crate::trajectory::TrajectoryError;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use thiserror::Error;

/// What kind of reason stands against a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The input is malformed.
    Input,
    /// Start, goal or the way between them leave the workspace box.
    Workspace,
    /// There is too little time for the way.
    Duration,
    /// There is too little time for the turn.
    Turn,
    /// Start, goal or the way between them come too near to an obstacle.
    Obstacle,
    /// The corridor about the reference is too narrow.
    Corridor,
    /// A hand cannot follow.
    Reach,
    /// The robot's joints cannot follow.
    Robot,
    /// The solver gave no answer.
    Solver,
}

/// An end of the movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// Where it starts.
    Start,
    /// Where it ends.
    Goal,
}

/// A limit that can contradict others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "limit", rename_all = "snake_case")]
pub enum LimitName {
    /// Speed of the TCP.
    Speed,
    /// Its acceleration.
    Acceleration,
    /// Its jerk.
    Jerk,
    /// A face of the workspace box.
    Face(Face),
}

/// Why a projection cannot begin.
#[derive(Debug, Clone, PartialEq, Error, Serialize, Deserialize)]
#[serde(tag = "input", rename_all = "snake_case")]
pub enum InputFault {
    /// The reference is no path.
    #[error("{error}")]
    Samples {
        /// What is wrong with it.
        error: TrajectoryError,
    },
    /// A number of steps that is not sensible.
    #[error("the number of steps must be 4 to 2000 and is {steps}")]
    Steps {
        /// As given.
        steps: usize,
    },
    /// The weight of the jerk.
    #[error("the weight of the jerk must be a positive number and is {value}")]
    JerkWeight {
        /// As given.
        #[serde(deserialize_with = "null_as_nan")]
        value: f64,
    },
    /// A limit that must be positive.
    #[error("the limit {name} must be a positive number and is {value}")]
    Limit {
        /// Its key.
        name: Cow<'static, str>,
        /// As given.
        #[serde(deserialize_with = "null_as_nan")]
        value: f64,
    },
    /// A clearance below zero.
    #[error("the limit clearance_m must be a number of 0 or more and is {value}")]
    Clearance {
        /// As given, m.
        #[serde(deserialize_with = "null_as_nan")]
        value: f64,
    },
    /// A box without a point.
    #[error("the workspace box has a least coordinate above its greatest")]
    Box,
}

/// Why a solver gave no path.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "solver", rename_all = "snake_case")]
pub enum NoAnswer {
    /// The program has no least value.
    Unbounded,
    /// The solution does not keep its limits closely enough.
    Inaccurate,
    /// The path went on changing.
    NotSettled,
    /// It stopped.
    Stopped {
        /// By the solver's own name for it.
        status: String,
    },
}

/// Why there is no path. Lengths in m, times in s, angles in rad, limits in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum NoPath {
    /// The input is malformed.
    Input {
        /// What is wrong with it.
        fault: InputFault,
    },
    /// An end is outside the workspace box.
    OutsideBox {
        /// Which end.
        end: End,
        /// The face that it is beyond.
        face: Face,
        /// Its coordinate along that axis.
        at_m: f64,
    },
    /// An end is in an obstacle.
    InsideObstacle {
        /// Which end.
        end: End,
        /// The obstacle.
        obstacle: String,
        /// How deep.
        depth_m: f64,
    },
    /// An end is where no posture brings the hand.
    BeyondReach {
        /// Which end.
        end: End,
        /// Whose hand.
        body: String,
        /// How much too far.
        by_m: f64,
    },
    /// Too little time for the turn.
    TooShortToTurn {
        /// Given.
        duration_s: f64,
        /// Needed.
        needed_s: f64,
        /// The turn.
        angle_rad: f64,
        /// Limit of the angular speed.
        angular_speed_rad_s: f64,
        /// Limit of the angular acceleration.
        angular_acceleration_rad_s2: f64,
    },
    /// Too little time for the way.
    TooShort {
        /// Given.
        duration_s: f64,
        /// Needed.
        needed_s: f64,
        /// From start to goal.
        distance_m: f64,
        /// Limit of the speed.
        speed_m_s: f64,
        /// Limit of the acceleration.
        acceleration_m_s2: f64,
        /// Limit of the jerk.
        jerk_m_s3: f64,
    },
    /// The robot's joints cannot follow any path near the reference in time.
    JointsTooSlow,
    /// Limits contradict each other.
    Contradiction {
        /// Which, the most important first.
        limits: Vec<LimitName>,
    },
    /// An obstacle leaves no way on the side of the reference.
    Blocked {
        /// The obstacle.
        obstacle: String,
        /// When it is worst.
        at_s: f64,
        /// How much nearer than the clearance.
        by_m: f64,
        /// The clearance.
        clearance_m: f64,
    },
    /// The corridor about the reference is too narrow.
    Corridor {
        /// When it is worst.
        at_s: f64,
        /// How far outside.
        by_m: f64,
    },
    /// The way leaves what a hand reaches.
    LeavesReach {
        /// Whose hand.
        body: String,
        /// When it is worst.
        at_s: f64,
        /// How much too far.
        by_m: f64,
    },
    /// The solver gave no answer.
    Unsolved {
        /// Why.
        answer: NoAnswer,
    },
    /// There is a path, but the robot cannot follow it.
    NoMotion {
        /// Why not.
        motion: NoMotion,
    },
}

impl NoPath {
    /// The kind of reason.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Input { .. } => Cause::Input,
            Self::OutsideBox { .. } => Cause::Workspace,
            Self::InsideObstacle { .. } | Self::Blocked { .. } => Cause::Obstacle,
            Self::BeyondReach { .. } | Self::LeavesReach { .. } => Cause::Reach,
            Self::TooShortToTurn { .. } => Cause::Turn,
            Self::TooShort { .. } => Cause::Duration,
            Self::JointsTooSlow | Self::NoMotion { .. } => Cause::Robot,
            Self::Contradiction { limits } => match limits.first() {
                Some(LimitName::Face(_)) => Cause::Workspace,
                _ => Cause::Duration,
            },
            Self::Corridor { .. } => Cause::Corridor,
            Self::Unsolved { .. } => Cause::Solver,
        }
    }
}

impl From<TrajectoryError> for NoPath {
    fn from(error: TrajectoryError) -> Self {
        Self::Input { fault: InputFault::Samples { error } }
    }
}

impl From<NoMotion> for NoPath {
    fn from(motion: NoMotion) -> Self {
        Self::NoMotion { motion }
    }
}

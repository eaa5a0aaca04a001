//! What a path is checked for, and the three ways in which a check comes out.

use crate::path::Quantity;
use crate::robot::NotChecked;
use serde::{Deserialize, Serialize};

/// Something that a path is checked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// The speed of the tool.
    Speed,
    /// The acceleration of the tool.
    Acceleration,
    /// The jerk of the tool.
    Jerk,
    /// The angular speed of the tool.
    AngularSpeed,
    /// The angular acceleration of the tool.
    AngularAcceleration,
    /// The tool at rest at start and goal.
    Rest,
    /// A path without jumps, of a planned one.
    Continuity,
    /// The tool in the workspace box, where there is one.
    Workspace,
    /// The tool clear of the obstacles, where there are any.
    ToolClearance,
    /// The tool in the corridor of a planned path, where there is one.
    Corridor,
    /// The tool in the ball that a body's hand can reach.
    ReachBall,
    /// The robot's joints: range, speed, acceleration, and the tool on the path.
    Joints,
    /// The robot's links against the obstacles, where there are any.
    Obstacles,
    /// The robot's links against each other.
    Itself,
    /// The robot's links against a person.
    Person,
    /// The hand of a person on the path in every repetition.
    Hand,
}

impl Subject {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 16] = [
        Self::Speed,
        Self::Acceleration,
        Self::Jerk,
        Self::AngularSpeed,
        Self::AngularAcceleration,
        Self::Rest,
        Self::Continuity,
        Self::Workspace,
        Self::ToolClearance,
        Self::Corridor,
        Self::ReachBall,
        Self::Joints,
        Self::Obstacles,
        Self::Itself,
        Self::Person,
        Self::Hand,
    ];

    /// What a measured quantity belongs to; none for what tells how near a path is to the best one.
    pub fn of(quantity: Quantity) -> Option<Self> {
        match quantity {
            Quantity::Speed => Some(Self::Speed),
            Quantity::Acceleration => Some(Self::Acceleration),
            Quantity::Jerk => Some(Self::Jerk),
            Quantity::AngularSpeed => Some(Self::AngularSpeed),
            Quantity::AngularAcceleration => Some(Self::AngularAcceleration),
            Quantity::Rest => Some(Self::Rest),
            Quantity::Continuity => Some(Self::Continuity),
            Quantity::Workspace => Some(Self::Workspace),
            Quantity::KeepOut => Some(Self::ToolClearance),
            Quantity::Corridor => Some(Self::Corridor),
            Quantity::Reach => Some(Self::ReachBall),
            Quantity::JointSpeed
            | Quantity::JointAcceleration
            | Quantity::JointRange
            | Quantity::Tracking => Some(Self::Joints),
            Quantity::Equality
            | Quantity::Cone
            | Quantity::Stationarity
            | Quantity::Complementarity => None,
        }
    }
}

/// Why something could not be checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// For what is known of the robot or its motion.
    Robot(NotChecked),
    /// The path has too few rows.
    TooFewRows,
    /// The path was refused before.
    Refused,
    /// No repetition of the worker follows the path.
    NobodyFollows,
}

/// How a check came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum CheckState {
    /// Looked at, and within the limit.
    Kept,
    /// Looked at, and beyond the limit.
    Broken,
    /// Not looked at: neither kept nor broken.
    NotChecked {
        /// Why.
        why: Why,
    },
}

/// One check of one path.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checked {
    /// What was to be checked.
    pub subject: Subject,
    /// Whose body, where it is about one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// How it came out.
    #[serde(flatten)]
    pub state: CheckState,
}

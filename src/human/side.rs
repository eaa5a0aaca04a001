//! Right and left.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The coupled side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Right hand on the robot.
    Right,
    /// Left hand on the robot.
    Left,
}

impl Side {
    /// Name of the grip link.
    pub fn grip(self) -> &'static str {
        match self {
            Self::Right => "RightGrip",
            Self::Left => "LeftGrip",
        }
    }

    /// "Right" or "Left", as Xsens names begin.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Right => "Right",
            Self::Left => "Left",
        }
    }

    /// The other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
        }
    }
}

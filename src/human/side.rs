//! Right and left, and which hands hold on.

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

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
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

/// Which hands hold on to the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Hands {
    /// The right hand.
    Right,
    /// The left hand.
    Left,
    /// Both hands.
    Both,
}

impl Hands {
    /// The sides, the leading one first: of both hands the right one.
    pub fn sides(self) -> &'static [Side] {
        match self {
            Self::Right => &[Side::Right],
            Self::Left => &[Side::Left],
            Self::Both => &[Side::Right, Side::Left],
        }
    }

    /// The leading side.
    pub fn lead(self) -> Side {
        self.sides()[0]
    }

    /// Whether a side holds on.
    pub fn hold(self, side: Side) -> bool {
        self.sides().contains(&side)
    }
}

impl From<Side> for Hands {
    fn from(side: Side) -> Self {
        match side {
            Side::Right => Self::Right,
            Side::Left => Self::Left,
        }
    }
}

/// How the pelvis takes part in a movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pelvis {
    /// It stays at rest.
    Rests,
    /// It turns about the middle between the hips, as on a seat.
    Turns,
    /// It moves and turns, over legs that stand.
    Moves,
}

impl Pelvis {
    /// How many of its six coordinates are free: the last ones.
    pub fn free(self) -> usize {
        match self {
            Self::Rests => 0,
            Self::Turns => 3,
            Self::Moves => 6,
        }
    }
}

/// Which joints of a body are predicted together: spine, arms and the pelvis' free coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coupled {
    /// The hands on the robot.
    pub hands: Hands,
    /// The pelvis.
    pub pelvis: Pelvis,
}

impl Coupled {
    /// One arm on a pelvis that rests.
    pub fn arm(side: Side) -> Self {
        Self { hands: side.into(), pelvis: Pelvis::Rests }
    }
}

//! Whole postures over time from a file: a recording, joint angles, or sampled postures of a plan.
//!
//! ```text
//! recording  ─ fit of each arm's chain (training) ─► chain angles ┐
//! CSV        ─ time_s, <joint>_rad, [trial|rollout] ─► joint angles ┴ survey ─► Track
//! ```
//! The two chains of a recording are fitted apart and share no angle; the trunk of the sheets is that
//! of the right chain where it was recorded, and each arm is measured against its own chain's trunk.
//! Neck and knees of a recording come from its own segments. Joint angles are used as they are.

mod angles;
mod recorded;

pub use angles::read_angles;
pub use recorded::read_recorded;

use crate::human::Side;
use crate::scenario::Origin;
use crate::survey::WholePosture;
use serde::Serialize;

/// What kind of file a motion was read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionKind {
    /// Segment poses of a person.
    Recording,
    /// Joint angles over time.
    JointAngles,
    /// Joint angles of many sampled people along one path.
    Rollouts,
}

impl MotionKind {
    /// What one track is called, as a column of a table.
    pub fn track_word(self) -> &'static str {
        match self {
            Self::Rollouts => "rollout",
            _ => "trial",
        }
    }
}

/// One uninterrupted account of a movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Number of the trial or rollout, as in the file.
    pub name: String,
    /// Times, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// A posture for each time.
    pub postures: Vec<WholePosture>,
    /// Further frames in which the hand could not follow (rollouts only).
    pub exceeded: usize,
}

/// A motion, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// File name without its path.
    pub source: String,
    /// SHA-256 of what was read.
    pub sha256: String,
    /// Name of the body.
    pub body: String,
    /// What was read.
    pub kind: MotionKind,
    /// Trials or rollouts.
    pub tracks: Vec<Track>,
    /// Where trunk and present arms come from.
    pub origin: Origin,
    /// What was done to the data and what looks suspicious.
    pub notes: Vec<String>,
}

impl Motion {
    fn first(&self) -> Option<&WholePosture> {
        self.tracks.iter().find_map(|t| t.postures.first())
    }

    /// Whether the arm of a side is known.
    pub fn has_arm(&self, side: Side) -> bool {
        self.first().is_some_and(|p| p.arm(side).is_some())
    }

    /// Whether the neck is known.
    pub fn has_neck(&self) -> bool {
        self.first().is_some_and(|p| p.neck.is_some())
    }

    /// Whether the knees are known.
    pub fn has_knees(&self) -> bool {
        self.first().is_some_and(|p| p.knees_deg.is_some())
    }

    /// Whether the rise of the heels are known.
    pub fn has_heels(&self) -> bool {
        self.first().is_some_and(|p| p.heels_deg.is_some())
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.tracks.iter().map(|t| t.postures.len()).sum()
    }
}

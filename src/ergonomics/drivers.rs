//! Which step of RULA drives the grand score.

use super::profile::Profile;
use super::rula::{RulaScores, rula, rula_from_scores};
use super::worksheet::Worksheet;
use serde::Serialize;

/// A step of RULA that can be changed on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RulaStep {
    /// Upper arm with its shoulder.
    UpperArm,
    /// Lower arm.
    LowerArm,
    /// Wrist.
    Wrist,
    /// Wrist twist.
    WristTwist,
    /// Neck.
    Neck,
    /// Trunk.
    Trunk,
    /// Legs.
    Legs,
    /// Muscle use.
    Muscle,
    /// Force or load.
    Force,
}

impl RulaStep {
    /// All steps in the order of the sheet.
    pub const ALL: [Self; 9] = [
        Self::UpperArm,
        Self::LowerArm,
        Self::Wrist,
        Self::WristTwist,
        Self::Neck,
        Self::Trunk,
        Self::Legs,
        Self::Muscle,
        Self::Force,
    ];

    /// Name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::UpperArm => "upper arm",
            Self::LowerArm => "lower arm",
            Self::Wrist => "wrist",
            Self::WristTwist => "wrist twist",
            Self::Neck => "neck",
            Self::Trunk => "trunk",
            Self::Legs => "legs",
            Self::Muscle => "muscle use",
            Self::Force => "force or load",
        }
    }

    /// The same step scores with this one at its lowest.
    fn relieved(self, scores: RulaScores) -> RulaScores {
        match self {
            Self::UpperArm => RulaScores { upper_arm: 1, ..scores },
            Self::LowerArm => RulaScores { lower_arm: 1, ..scores },
            Self::Wrist => RulaScores { wrist: 1, ..scores },
            Self::WristTwist => RulaScores { wrist_twist: 1, ..scores },
            Self::Neck => RulaScores { neck: 1, ..scores },
            Self::Trunk => RulaScores { trunk: 1, ..scores },
            Self::Legs => RulaScores { legs: 1, ..scores },
            Self::Muscle => RulaScores { muscle: 0, ..scores },
            Self::Force => RulaScores { force: 0, ..scores },
        }
    }
}

/// What relieving one step would gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Driver {
    /// The step.
    pub step: RulaStep,
    /// Drop of the grand score when the step alone goes to its lowest value, 0-6.
    pub drop: u8,
}

/// Drop of the RULA grand score for each step on its own, in the order of the sheet.
///
/// Table C saturates: at a grand score of 7 every drop can be 0 although several steps are high, as
/// no single one would be enough.
pub fn drivers(sheet: &Worksheet, profile: &Profile) -> [Driver; 9] {
    let now = rula(sheet, profile);
    RulaStep::ALL.map(|step| {
        let relieved = rula_from_scores(&step.relieved(now.scores()), profile.rula_table_a);
        Driver { step, drop: now.grand.saturating_sub(relieved.grand) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bent_trunk_drives_a_bent_posture() {
        let sheet =
            Worksheet { elbow_flex_deg: 80.0, trunk_flex_deg: 70.0, ..Worksheet::default() };
        let found = drivers(&sheet, &Profile::default());
        for Driver { step, drop } in found {
            assert_eq!(drop > 0, step == RulaStep::Trunk, "{}", step.name());
        }
    }

    #[test]
    fn every_step_can_drive() {
        // From a calm sheet, one step raised as far as it goes is the only driver, if it moves at all.
        let calm = RulaScores {
            upper_arm: 1,
            lower_arm: 1,
            wrist: 1,
            wrist_twist: 1,
            muscle: 0,
            force: 0,
            neck: 1,
            trunk: 1,
            legs: 1,
        };
        for step in RulaStep::ALL {
            let high = RulaScores {
                upper_arm: 6,
                lower_arm: 3,
                wrist: 4,
                wrist_twist: 2,
                muscle: 1,
                force: 3,
                neck: 6,
                trunk: 6,
                legs: 2,
            };
            let others = RulaStep::ALL.iter().filter(|s| **s != step);
            let only = others.fold(high, |scores, other| other.relieved(scores));
            assert_ne!(only, calm, "{}", step.name());
            assert_eq!(step.relieved(only), calm, "{}", step.name());
        }
    }
}

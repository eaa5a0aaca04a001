//! The steps of REBA that can be changed on their own, and what each drives.

use crate::ergonomics::profile::Profile;
use crate::ergonomics::reba::{RebaScores, RebaSteps, reba, reba_from_scores};
use crate::ergonomics::worksheet::Worksheet;
use serde::Serialize;

/// A step of REBA that can be changed on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RebaStep {
    /// Neck.
    Neck,
    /// Trunk.
    Trunk,
    /// Legs.
    Legs,
    /// Load or force.
    Load,
    /// Upper arm with its shoulder.
    UpperArm,
    /// Lower arm.
    LowerArm,
    /// Wrist.
    Wrist,
    /// Coupling.
    Coupling,
    /// Activity.
    Activity,
}

impl RebaStep {
    /// All steps in the order of the sheet.
    pub const ALL: [Self; 9] = [
        Self::Neck,
        Self::Trunk,
        Self::Legs,
        Self::Load,
        Self::UpperArm,
        Self::LowerArm,
        Self::Wrist,
        Self::Coupling,
        Self::Activity,
    ];

    /// Name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neck => "neck",
            Self::Trunk => "trunk",
            Self::Legs => "legs",
            Self::Load => "load or force",
            Self::UpperArm => "upper arm",
            Self::LowerArm => "lower arm",
            Self::Wrist => "wrist",
            Self::Coupling => "coupling",
            Self::Activity => "activity",
        }
    }

    /// Its score on a filled-in sheet.
    pub fn value(self, steps: &RebaSteps) -> u8 {
        match self {
            Self::Neck => steps.neck,
            Self::Trunk => steps.trunk,
            Self::Legs => steps.legs,
            Self::Load => steps.load,
            Self::UpperArm => steps.upper_arm,
            Self::LowerArm => steps.lower_arm,
            Self::Wrist => steps.wrist,
            Self::Coupling => steps.coupling,
            Self::Activity => steps.activity,
        }
    }

    /// The same step scores with this one at its lowest.
    fn relieved(self, scores: RebaScores) -> RebaScores {
        match self {
            Self::Neck => RebaScores { neck: 1, ..scores },
            Self::Trunk => RebaScores { trunk: 1, ..scores },
            Self::Legs => RebaScores { legs: 1, ..scores },
            Self::Load => RebaScores { load: 0, ..scores },
            Self::UpperArm => RebaScores { upper_arm: 1, ..scores },
            Self::LowerArm => RebaScores { lower_arm: 1, ..scores },
            Self::Wrist => RebaScores { wrist: 1, ..scores },
            Self::Coupling => RebaScores { coupling: 0, ..scores },
            Self::Activity => RebaScores { activity: 0, ..scores },
        }
    }

    /// Drop of the final score when this step alone goes to its lowest value.
    pub(super) fn drop_of(self, now: &RebaSteps) -> u8 {
        now.total.saturating_sub(reba_from_scores(&self.relieved(scores(now))).total)
    }
}

fn scores(steps: &RebaSteps) -> RebaScores {
    RebaScores {
        neck: steps.neck,
        trunk: steps.trunk,
        legs: steps.legs,
        load: steps.load,
        upper_arm: steps.upper_arm,
        lower_arm: steps.lower_arm,
        wrist: steps.wrist,
        coupling: steps.coupling,
        activity: steps.activity,
    }
}

/// What relieving one step of REBA would gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RebaDriver {
    /// The step.
    pub step: RebaStep,
    /// Drop of the final score when the step alone goes to its lowest value, 0-14.
    pub drop: u8,
}

/// Drop of the REBA final score for each step on its own, in the order of the sheet.
///
/// Table C saturates as RULA's does: where both sides of the sheet are high, one step alone may gain
/// nothing.
pub fn reba_drivers(sheet: &Worksheet, profile: &Profile) -> [RebaDriver; 9] {
    let now = reba(sheet, profile);
    RebaStep::ALL.map(|step| RebaDriver { step, drop: step.drop_of(&now) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bent_trunk_drives_a_bent_posture() {
        let sheet =
            Worksheet { elbow_flex_deg: 80.0, trunk_flex_deg: 70.0, ..Worksheet::default() };
        for RebaDriver { step, drop } in reba_drivers(&sheet, &Profile::default()) {
            assert_eq!(drop > 0, step == RebaStep::Trunk, "{}", step.name());
        }
    }

    #[test]
    fn activity_drives_point_by_point() {
        let sheet = Worksheet {
            elbow_flex_deg: 80.0,
            static_gt_1min: true,
            repeated_gt_4min: true,
            ..Worksheet::default()
        };
        assert_eq!(reba_drivers(&sheet, &Profile::default())[8].drop, 2);
    }

    #[test]
    fn each_step_is_read_and_relieved_in_its_own_place() {
        let high = RebaScores {
            neck: 3,
            trunk: 5,
            legs: 4,
            load: 3,
            upper_arm: 6,
            lower_arm: 2,
            wrist: 3,
            coupling: 3,
            activity: 3,
        };
        let before = reba_from_scores(&high);
        for step in RebaStep::ALL {
            let after = reba_from_scores(&step.relieved(high));
            for other in RebaStep::ALL {
                let changed = other.value(&after) != other.value(&before);
                assert_eq!(changed, other == step, "{} {}", step.name(), other.name());
            }
        }
    }
}

//! Which step drives the score: of one sheet, and on average over rollouts and time.
//!
//! Each step in turn is put at its lowest value while the others stay (leave one step out); what the
//! score falls by is what that step drives.

mod reba_step;

pub use reba_step::{RebaDriver, RebaStep, reba_drivers};

use super::profile::Profile;
use super::reba::RebaSteps;
use super::rula::{RulaScores, RulaSteps, rula, rula_from_scores};
use super::tables::RulaTableA;
use super::worksheet::Worksheet;
use crate::math::stats::{mean, standard_error};
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

    /// Its score on a filled-in sheet.
    pub fn value(self, steps: &RulaSteps) -> u8 {
        match self {
            Self::UpperArm => steps.upper_arm,
            Self::LowerArm => steps.lower_arm,
            Self::Wrist => steps.wrist,
            Self::WristTwist => steps.wrist_twist,
            Self::Neck => steps.neck,
            Self::Trunk => steps.trunk,
            Self::Legs => steps.legs,
            Self::Muscle => steps.muscle,
            Self::Force => steps.force,
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
    RulaStep::ALL.map(|step| Driver { step, drop: rula_drop(&now, step, profile.rula_table_a) })
}

fn rula_drop(now: &RulaSteps, step: RulaStep, printing: RulaTableA) -> u8 {
    now.grand.saturating_sub(rula_from_scores(&step.relieved(now.scores()), printing).grand)
}

/// One step's part in the expected score of many rollouts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepShare {
    /// Name of the step.
    pub step: &'static str,
    /// Mean step score over the samples that were scored.
    pub mean: f64,
    /// Drop of the expected score if this step alone were at its lowest all the time.
    pub drop: f64,
    /// Monte Carlo standard error of `drop` over rollouts; `None` for a single rollout.
    pub drop_se: Option<f64>,
    /// Share of the time at which the step drives: at its lowest, the score would be lower.
    pub drives_share: f64,
}

/// The steps of RULA in the expected grand score, in the order of the sheet.
///
/// `rollouts[r][i]` is the sheet of rollout `r` at time `i`; `None` once its reach is exceeded. Such
/// a sample counts as the worst score, which no step relieves: it adds 0 to `drop` and
/// `drives_share`. Each rollout counts alike, as in [`super::score_distribution`], so that `drop` is
/// the expected score minus the expected score of the relieved sheets. Drops of several steps do not
/// add up: Table C saturates. Empty when there is no sample.
pub fn rula_step_shares(
    rollouts: &[Vec<Option<RulaSteps>>],
    printing: RulaTableA,
) -> Vec<StepShare> {
    let look = |s: &RulaSteps, i: usize| {
        let step = RulaStep::ALL[i];
        (step.value(s), rula_drop(s, step, printing))
    };
    step_shares(rollouts, &RulaStep::ALL.map(RulaStep::name), look)
}

/// The steps of REBA in the expected final score; otherwise as [`rula_step_shares`].
pub fn reba_step_shares(rollouts: &[Vec<Option<RebaSteps>>]) -> Vec<StepShare> {
    let look = |s: &RebaSteps, i: usize| {
        let step = RebaStep::ALL[i];
        (step.value(s), step.drop_of(s))
    };
    step_shares(rollouts, &RebaStep::ALL.map(RebaStep::name), look)
}

/// Mean score of each step of RULA at each time, over the rollouts that have not exceeded their reach;
/// in the order of [`rula_step_shares`]. A time that nobody reaches repeats the one before.
pub fn rula_step_courses(rollouts: &[Vec<Option<RulaSteps>>]) -> Vec<Vec<f64>> {
    courses(rollouts, RulaStep::ALL.len(), |s, i| RulaStep::ALL[i].value(s))
}

/// The same for the steps of REBA.
pub fn reba_step_courses(rollouts: &[Vec<Option<RebaSteps>>]) -> Vec<Vec<f64>> {
    courses(rollouts, RebaStep::ALL.len(), |s, i| RebaStep::ALL[i].value(s))
}

fn courses<S>(
    rollouts: &[Vec<Option<S>>],
    count: usize,
    value: impl Fn(&S, usize) -> u8,
) -> Vec<Vec<f64>> {
    let frames = rollouts.iter().map(Vec::len).max().unwrap_or(0);
    let course = |step: usize| {
        let mut before = 0.0;
        let mut at = |k: usize| {
            let there: Vec<f64> = rollouts
                .iter()
                .filter_map(|r| r.get(k)?.as_ref())
                .map(|s| f64::from(value(s, step)))
                .collect();
            if !there.is_empty() {
                before = mean(&there);
            }
            before
        };
        (0..frames).map(&mut at).collect()
    };
    (0..count).map(course).collect()
}

/// `look(sheet, step)`: the step's score and the drop of the total.
fn step_shares<S>(
    rollouts: &[Vec<Option<S>>],
    names: &[&'static str],
    look: impl Fn(&S, usize) -> (u8, u8),
) -> Vec<StepShare> {
    if rollouts.iter().all(Vec::is_empty) {
        return Vec::new();
    }
    names.iter().enumerate().map(|(i, name)| share(rollouts, name, |s| look(s, i))).collect()
}

fn share<S>(
    rollouts: &[Vec<Option<S>>],
    step: &'static str,
    look: impl Fn(&S) -> (u8, u8),
) -> StepShare {
    let (mut scored, mut sum) = (0usize, 0.0);
    let (mut drops, mut driving) = (Vec::new(), Vec::new());
    for rollout in rollouts.iter().filter(|r| !r.is_empty()) {
        let (mut drop, mut drives) = (0.0, 0usize);
        for (value, by) in rollout.iter().flatten().map(&look) {
            scored += 1;
            sum += f64::from(value);
            drop += f64::from(by);
            drives += usize::from(by > 0);
        }
        drops.push(drop / rollout.len() as f64);
        driving.push(drives as f64 / rollout.len() as f64);
    }
    StepShare {
        step,
        mean: sum / scored.max(1) as f64,
        drop: mean(&drops),
        drop_se: standard_error(&drops),
        drives_share: mean(&driving),
    }
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

    #[test]
    fn the_mean_drop_is_the_difference_of_expected_scores() {
        let profile = Profile::default();
        let sheet = |trunk: f64, neck: f64| Worksheet {
            elbow_flex_deg: 80.0,
            trunk_flex_deg: trunk,
            neck_flex_deg: neck,
            ..Worksheet::default()
        };
        let sheets = [vec![sheet(70.0, 0.0), sheet(0.0, 0.0)], vec![sheet(30.0, 25.0); 2]];
        let steps = |relieve: bool| -> Vec<Vec<Option<RulaSteps>>> {
            let trunk = |s: &Worksheet| if relieve { 0.0 } else { s.trunk_flex_deg };
            let change = |s: &Worksheet| Worksheet { trunk_flex_deg: trunk(s), ..*s };
            let one = |s: &Worksheet| Some(rula(&change(s), &profile));
            sheets.iter().map(|r| r.iter().map(one).collect()).collect()
        };
        let expected = |all: &[Vec<Option<RulaSteps>>]| {
            let scores: Vec<Vec<u8>> =
                all.iter().map(|r| r.iter().flatten().map(|s| s.grand).collect()).collect();
            super::super::score_distribution(&scores, 1.0, 7, 0.5, None).unwrap().expected
        };
        let shares = rula_step_shares(&steps(false), profile.rula_table_a);
        let trunk = shares[5];
        assert_eq!(trunk.step, "trunk");
        let by_hand = expected(&steps(false)) - expected(&steps(true));
        assert!((trunk.drop - by_hand).abs() < 1e-12 && by_hand > 0.0, "{trunk:?} {by_hand}");
        assert!(trunk.drop_se.is_some_and(|se| se > 0.0));
        // The mean over time is the mean, as every sample was reached.
        for (share, course) in shares.iter().zip(rula_step_courses(&steps(false))) {
            assert!((mean(&course) - share.mean).abs() < 1e-12 && course.len() == 2);
        }
        assert!((0.25..=0.75).contains(&trunk.drives_share), "{trunk:?}");
        assert_eq!(shares[1].drop, 0.0);
    }

    #[test]
    fn an_exceeded_reach_drives_nothing_but_takes_its_time() {
        let bent = Worksheet { elbow_flex_deg: 80.0, trunk_flex_deg: 70.0, ..Worksheet::default() };
        let profile = Profile::default();
        let one = Some(rula(&bent, &profile));
        let whole = rula_step_shares(&[vec![one; 4]], profile.rula_table_a)[5];
        let half = rula_step_shares(&[vec![one, one, None, None]], profile.rula_table_a)[5];
        assert_eq!((half.mean, half.drop_se), (whole.mean, None));
        assert_eq!((half.drop, half.drives_share), (whole.drop / 2.0, 0.5));
        assert!(rula_step_shares(&[], profile.rula_table_a).is_empty());
        assert!(reba_step_shares(&[Vec::new()]).is_empty());
    }
}

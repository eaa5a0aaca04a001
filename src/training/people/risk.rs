//! RULA and REBA of recorded people, and of the prediction from the path of their hand alone.
//!
//! ```text
//! S        mean over time of the score of the recorded posture
//! S_r      the same of repetition r of a stranger; the worst there is once the hand is lost, as in a plan
//! error    mean over movements of |mean over r of S_r - S|;   rank correlation over movements (Spearman)
//! ```
//! Both sides are scored by one profile with free hands, no load, no muscle use and legs that carry evenly, unless
//! both heels are up. Trunk and leading arm of the recorded person are those of the fitted body, on which the
//! prediction stands too; head, knees and heels are those that were recorded. A head that was not recorded is in line
//! with the trunk on both sides.

use super::super::rollout_check::band_end;
use super::seen::Seen;
use crate::ergonomics::{
    BodyPart, PerMethod, Profile, ScoringMethod, Sheet, TaskInputs, Worksheet, time_means,
    worksheet,
};
use crate::files::InputError;
use crate::human::{Body, Coupled, Pelvis, Side, Stance};
use crate::math::stats::{mean, rank_correlation};
use crate::posture::Rollout;
use crate::survey::{HeadDraw, LegAngles, Lens, NeckRule, PostureAngles, Surveyor};
use nalgebra::DVector;
use rayon::prelude::*;
use serde::Serialize;

/// The score of one movement by one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RiskScore {
    /// Of the recorded person, mean over time.
    pub recorded: f64,
    /// Of strangers, mean over repetitions.
    pub predicted: f64,
    /// Between which half of the repetitions are.
    pub band_50: [f64; 2],
    /// Between which nine tenths of them are.
    pub band_90: [f64; 2],
    /// What would be predicted if one part of the body were known.
    pub with_recorded: Vec<PartKnown>,
}

/// The prediction with a part of the body as it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PartKnown {
    /// Which.
    pub part: BodyPart,
    /// Mean over repetitions.
    pub predicted: f64,
}

/// What is entered in a column of the sheets: an angle (deg), or the share of the time for which a box is ticked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SheetMean {
    /// Name of the column.
    pub column: &'static str,
    /// Of the recorded person, mean over time.
    pub recorded: f64,
    /// Of repetitions, mean over those and time; NaN where none follows the hand.
    pub predicted: f64,
}

impl SheetMean {
    /// Whether the column holds an angle; the others are boxes.
    pub fn is_angle(&self) -> bool {
        ANGLES.contains(&self.column)
    }
}

/// Columns of a sheet that hold an angle, deg.
const ANGLES: [&str; 6] =
    ["upper_arm_flex", "elbow_flex", "wrist_flex", "neck_flex", "trunk_flex", "knee_flex"];
/// Columns of a sheet that the task fills in and no posture.
const OF_TASK: [&str; 10] = [
    "arm_supported",
    "trunk_seated_supported",
    "sitting",
    "load_kg",
    "load_static_or_repeated",
    "load_shock",
    "static_gt_1min",
    "repeated_gt_4min",
    "rapid_large_changes",
    "coupling",
];

impl RiskScore {
    /// Whether the recorded score is in a band.
    pub fn is_inside(&self, [low, high]: [f64; 2]) -> bool {
        (low..=high).contains(&self.recorded)
    }
}

/// How predicted scores go with recorded ones, over movements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Mean absolute error.
    pub mae: f64,
    /// Mean of predicted less recorded.
    pub bias: f64,
    /// Spearman's, with ranks that are tied shared; none where all are alike.
    pub rank_correlation: Option<f64>,
}

/// Of pairs of a recorded and a predicted score.
pub fn agreement(pairs: &[[f64; 2]]) -> Agreement {
    let over = |of: fn(&[f64; 2]) -> f64| pairs.iter().map(of).collect::<Vec<f64>>();
    Agreement {
        mae: mean(&over(|[recorded, predicted]| (predicted - recorded).abs())),
        bias: mean(&over(|[recorded, predicted]| predicted - recorded)),
        rank_correlation: rank_correlation(&over(|p| p[0]), &over(|p| p[1])),
    }
}

/// Scores postures of one person, recorded and predicted ones alike.
pub(super) struct Assessor {
    surveyor: Surveyor,
    head: HeadDraw,
    lens: Lens,
}

/// The scores of repetitions over time (R x T), and their sheets.
pub(super) struct Repeated {
    sheets: Vec<Vec<Option<Worksheet>>>,
}

impl Assessor {
    /// For a person of whom the head was recorded, or was not.
    pub(super) fn new(body: &Body, side: Side, knows_head: bool) -> Result<Self, InputError> {
        let standing = Stance::Standing { shoe_m: 0.0 };
        let coupled = Coupled { hands: side.into(), pelvis: Pelvis::Moves };
        let rest = body.pelvis_pose([0.0; 2], 0.0, standing);
        let lens = Lens {
            task: TaskInputs::default(),
            neck: if knows_head { NeckRule::Predicted } else { NeckRule::Neutral },
            both_hands: false,
            profile: Profile::default(),
        };
        let head = HeadDraw::mean(Some(side));
        Ok(Self { surveyor: Surveyor::new(body, coupled, rest, (standing, 0.0))?, head, lens })
    }

    /// The sheet of a posture of the fitted body with what else was recorded of it.
    pub(super) fn recorded(&self, q: &DVector<f64>, seen: &Seen) -> Worksheet {
        let mut angles = self.surveyor.measure(q, &self.head);
        angles.legs = LegAngles::recorded(seen.knees_deg, seen.lower_heel_deg());
        let head = seen.head.unwrap_or_default();
        worksheet(
            &angles.with_head(head),
            &angles.arm,
            &angles.task(&self.lens),
            &self.lens.profile,
        )
    }

    fn predicted(&self, q: &DVector<f64>, head: &HeadDraw) -> Worksheet {
        self.sheet(&self.surveyor.measure(q, head))
    }

    fn sheet(&self, angles: &PostureAngles) -> Worksheet {
        let body = angles.trunk_neck(self.lens.neck);
        worksheet(body, &angles.arm, &angles.task(&self.lens), &self.lens.profile)
    }

    /// A sheet's score.
    pub(super) fn total(&self, sheet: &Worksheet, method: ScoringMethod) -> u8 {
        Sheet::of(sheet, &self.lens.profile).total(method)
    }

    /// Scores, mean over time, of postures without chance (T): the head is held as on average.
    pub(super) fn of_postures(&self, postures: &[DVector<f64>]) -> PerMethod<f64> {
        let sheets: Vec<Worksheet> =
            postures.iter().map(|q| self.predicted(q, &self.head)).collect();
        PerMethod::of(|method| {
            mean(&sheets.iter().map(|s| f64::from(self.total(s, method))).collect::<Vec<_>>())
        })
    }

    /// Fills in the sheets of repetitions; `block`: whose heads.
    pub(super) fn repeated(&self, walks: &[Rollout], block: (u64, u32)) -> Repeated {
        let one = |(r, walk): (usize, &Rollout)| {
            let head = self.head.of_repetition(block, r, None);
            let end = walk.reach_exceeded_at.unwrap_or(usize::MAX);
            let sheet = |(k, q)| (k < end).then(|| self.predicted(q, &head));
            walk.q.iter().enumerate().map(sheet).collect()
        };
        Repeated { sheets: walks.par_iter().enumerate().map(one).collect() }
    }

    /// Scores of repetitions over time, R x T, where `known` of each sheet is as it was recorded.
    pub(super) fn over_time(
        &self,
        repeated: &Repeated,
        recorded: &[Worksheet],
        (method, known): (ScoringMethod, Option<BodyPart>),
    ) -> Vec<Vec<u8>> {
        let total = |(sheet, recorded): (&Option<Worksheet>, &Worksheet)| {
            let Some(sheet) = sheet else { return method.worst() };
            let known = known.map_or(*sheet, |part| with_part(sheet, recorded, part));
            self.total(&known, method)
        };
        let one = |walk: &Vec<Option<Worksheet>>| walk.iter().zip(recorded).map(total).collect();
        repeated.sheets.par_iter().map(one).collect()
    }

    /// What is entered in the sheets of a recorded movement and of repetitions that follow the hand.
    pub(super) fn entered(repeated: &Repeated, recorded: &[Worksheet]) -> Vec<SheetMean> {
        let all: Vec<&Worksheet> = repeated.sheets.iter().flatten().flatten().collect();
        let recorded: Vec<&Worksheet> = recorded.iter().collect();
        let mean_of = |sheets: &[&Worksheet]| -> Vec<f64> {
            let mut sum = vec![0.0; Worksheet::COLUMNS.len()];
            for sheet in sheets {
                sum.iter_mut().zip(sheet.values()).for_each(|(s, v)| *s += v);
            }
            sum.iter().map(|s| s / sheets.len() as f64).collect()
        };
        let columns =
            Worksheet::COLUMNS.into_iter().zip(mean_of(&recorded).into_iter().zip(mean_of(&all)));
        columns
            .filter(|(column, _)| !OF_TASK.contains(column))
            .map(|(column, (recorded, predicted))| SheetMean { column, recorded, predicted })
            .collect()
    }

    /// What repetitions say of a recorded movement; none for fewer than two.
    pub(super) fn compared(
        &self,
        repeated: &Repeated,
        recorded: &[Worksheet],
    ) -> Option<PerMethod<RiskScore>> {
        PerMethod::all(|method| {
            let means = |known: Option<BodyPart>| {
                time_means(&self.over_time(repeated, recorded, (method, known)))
            };
            let mut own = means(None);
            if own.len() < 2 {
                return None;
            }
            own.sort_by(f64::total_cmp);
            let at = |p: f64| band_end(&own, p);
            let known = |part: BodyPart| PartKnown { part, predicted: mean(&means(Some(part))) };
            let score = |s: &Worksheet| f64::from(self.total(s, method));
            Some(RiskScore {
                recorded: mean(&recorded.iter().map(score).collect::<Vec<_>>()),
                predicted: mean(&own),
                band_50: [at(0.25), at(0.75)],
                band_90: [at(0.05), at(0.95)],
                with_recorded: BodyPart::ALL.map(known).to_vec(),
            })
        })
    }
}

/// A sheet with one part of the body as on another.
fn with_part(sheet: &Worksheet, from: &Worksheet, part: BodyPart) -> Worksheet {
    let (own, from) = (*sheet, *from);
    match part {
        BodyPart::UpperArm => Worksheet {
            upper_arm_flex_deg: from.upper_arm_flex_deg,
            shoulder_raised: from.shoulder_raised,
            upper_arm_abducted: from.upper_arm_abducted,
            ..own
        },
        BodyPart::LowerArm => Worksheet {
            elbow_flex_deg: from.elbow_flex_deg,
            forearm_across_or_out: from.forearm_across_or_out,
            ..own
        },
        BodyPart::Wrist => Worksheet {
            wrist_flex_deg: from.wrist_flex_deg,
            wrist_deviated: from.wrist_deviated,
            wrist_twist_end: from.wrist_twist_end,
            ..own
        },
        BodyPart::Neck => Worksheet {
            neck_flex_deg: from.neck_flex_deg,
            neck_twisted: from.neck_twisted,
            neck_side: from.neck_side,
            ..own
        },
        BodyPart::Trunk => Worksheet {
            trunk_flex_deg: from.trunk_flex_deg,
            trunk_twisted: from.trunk_twisted,
            trunk_side: from.trunk_side,
            ..own
        },
        BodyPart::Legs => Worksheet {
            legs_unbalanced: from.legs_unbalanced,
            knee_flex_deg: from.knee_flex_deg,
            ..own
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::Head;
    use std::path::Path;

    #[test]
    fn agreement_is_that_of_a_naive_loop() {
        let pairs = [[3.0, 3.5], [4.0, 3.0], [5.0, 6.0], [5.0, 5.5]];
        let found = agreement(&pairs);
        assert!((found.mae - (0.5 + 1.0 + 1.0 + 0.5) / 4.0).abs() < 1e-12);
        assert!((found.bias - (0.5 - 1.0 + 1.0 + 0.5) / 4.0).abs() < 1e-12);
        // Ranks 1, 2, 3.5, 3.5 and 2, 1, 4, 3.
        let expected = (0.75 + 0.75 + 1.5 + 0.5) / (4.5f64 * 5.0).sqrt();
        assert!((found.rank_correlation.unwrap() - expected).abs() < 1e-12);
        assert!(agreement(&[[3.0, 4.0], [4.0, 4.0]]).rank_correlation.is_none());
    }

    #[test]
    fn a_band_holds_its_ends() {
        let score = RiskScore {
            recorded: 3.0,
            predicted: 3.5,
            band_50: [3.2, 3.8],
            band_90: [3.0, 4.0],
            with_recorded: Vec::new(),
        };
        assert!(score.is_inside(score.band_90) && !score.is_inside(score.band_50));
    }

    #[test]
    fn parts_of_a_sheet_make_up_all_that_a_posture_tells() {
        // Everything that a posture fills in differs.
        let (mut own, mut other) = ([0.0; 26], [0.0; 26]);
        for (i, column) in Worksheet::COLUMNS.iter().enumerate() {
            if !OF_TASK.contains(column) {
                other[i] = 1.0;
            }
            own[i] = 0.0;
        }
        let (own, other) = (Worksheet::from_values(&own), Worksheet::from_values(&other));
        let all = BodyPart::ALL.iter().fold(own, |sheet, part| with_part(&sheet, &other, *part));
        assert_eq!(all, other);
        for part in BodyPart::ALL {
            assert_ne!(with_part(&own, &other, part), own, "{part:?}");
        }
    }

    fn assessor(knows_head: bool) -> (Assessor, DVector<f64>) {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let assessor = Assessor::new(&body, Side::Right, knows_head).unwrap();
        (assessor, DVector::from_fn(30, |i, _| if i < 6 { 0.0 } else { 0.01 * i as f64 - 0.15 }))
    }

    fn seen(head: Option<Head>, knees_deg: [f64; 2]) -> Seen {
        Seen { features: [0.0; 5], head, knees_deg, heels_deg: None }
    }

    #[test]
    fn a_recorded_posture_that_is_as_predicted_has_the_same_sheet() {
        for knows_head in [false, true] {
            let (assessor, q) = assessor(knows_head);
            let angles = assessor.surveyor.measure(&q, &assessor.head);
            let head = knows_head.then(|| angles.head(NeckRule::Predicted));
            let mine = assessor.recorded(&q, &seen(head, angles.legs.knees_deg));
            let theirs = assessor.predicted(&q, &assessor.head);
            for (mine, theirs) in mine.values().iter().zip(theirs.values()) {
                assert!((mine - theirs).abs() < 1e-9, "{mine} {theirs}");
            }
            let scores = assessor.of_postures(&[q.clone(), q.clone()]);
            assert_eq!(
                scores[ScoringMethod::Rula],
                f64::from(assessor.total(&mine, ScoringMethod::Rula))
            );
        }
        // A head that was thrown back costs three points of the neck, and bent knees show in REBA.
        let (assessor, q) = assessor(true);
        let sheet = |head: f64, knees: f64| {
            let head = Head { flexion: head, ..Head::default() };
            Sheet::of(&assessor.recorded(&q, &seen(Some(head), [0.0, knees])), &Profile::default())
        };
        assert_eq!((sheet(0.0, 0.0).rula.neck, sheet(-0.4, 0.0).rula.neck), (1, 4));
        assert_eq!(sheet(0.0, 70.0).reba.legs, sheet(0.0, 0.0).reba.legs + 2);
    }

    #[test]
    fn repetitions_that_lose_the_hand_are_at_the_worst_from_there_on() {
        let (assessor, q) = assessor(false);
        let walk = |end: Option<usize>| Rollout {
            q: vec![q.clone(); 4],
            reach_exceeded_at: end,
            max_residual_m: 0.0,
            rms_residual_m: 0.0,
            max_residual_rad: 0.0,
        };
        let walks = [walk(None), walk(Some(1))];
        let repeated = assessor.repeated(&walks, (1, 0));
        let recorded = vec![assessor.recorded(&q, &seen(None, [0.0; 2])); 4];
        let own = assessor.total(&recorded[0], ScoringMethod::Rula);
        let found = assessor.over_time(&repeated, &recorded, (ScoringMethod::Rula, None));
        assert_eq!(found, [vec![own; 4], vec![own, 7, 7, 7]]);
        let scores = assessor.compared(&repeated, &recorded).unwrap();
        let rula = &scores[ScoringMethod::Rula];
        let [recorded_score, lost] = [f64::from(own), 0.25 * (f64::from(own) + 21.0)];
        assert_eq!(
            (rula.recorded, rula.predicted),
            (recorded_score, 0.5 * (recorded_score + lost))
        );
        assert_eq!(rula.with_recorded.len(), BodyPart::ALL.len());
        assert!(assessor.compared(&assessor.repeated(&walks[..1], (1, 0)), &recorded).is_none());
        // Of the five postures that follow the hand, all alike.
        let entered = Assessor::entered(&repeated, &recorded);
        assert_eq!(entered.len(), Worksheet::COLUMNS.len() - OF_TASK.len());
        let arm = entered.iter().find(|e| e.column == "upper_arm_flex").unwrap();
        assert!((arm.recorded - recorded[0].upper_arm_flex_deg).abs() < 1e-9);
        assert_eq!(entered.iter().filter(|e| e.is_angle()).count(), ANGLES.len());
        assert!((arm.predicted - arm.recorded).abs() < 1e-9 && arm.recorded != 0.0);
    }
}

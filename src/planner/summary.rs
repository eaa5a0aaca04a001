//! What the report shows of one body along a path.

use super::person::Person;
use super::repetitions::{Repetition, Repetitions};
use super::result::{BodyScores, PartScore};
use super::scored::{Scored, Sheets};
use crate::ergonomics::{
    P_AT_LEAST_S, PerMethod, ScoringMethod, StepOverTime, THRESHOLD_MOVE_DEG, ThresholdSensitivity,
    ThresholdShift, score_distribution, steps_over_time, threshold_sensitivity,
};
use crate::math::stats::mean;
use crate::posture::Rollout;
use crate::scenario::OtherArm;
use crate::survey::{Lens, PostureAngles, Scorable};

impl Repetitions {
    /// Expected scores under a lens.
    pub(super) fn expected(&self, lens: &Lens) -> PerMethod<f64> {
        Sheets::of(self, |a| a.score(lens)).expected()
    }

    /// Expected scores with the angle thresholds moved.
    pub(super) fn sensitivity(&self, lens: &Lens) -> ThresholdSensitivity {
        threshold_sensitivity(THRESHOLD_MOVE_DEG, |shift: &ThresholdShift| {
            let scored = |a: &PostureAngles| {
                a.score_by(lens, |body, arm, task| shift.worksheet(body, arm, task, &lens.profile))
            };
            Sheets::of(self, scored).expected()
        })
    }

    /// Everything the report shows of one body.
    pub(super) fn summary(
        &self,
        person: &Person,
        lens: &Lens,
        other_arm: OtherArm,
    ) -> Option<BodyScores> {
        let sheets = Sheets::of(self, |a| a.score(lens));
        let scored = Scored::from_sheets(self, &sheets);
        let scores = PerMethod::all(|m| {
            let steps = steps_over_time(m, &sheets.0, &lens.profile);
            scored.report(m, steps.iter().map(part).collect())
        })?;
        let exceeded: Vec<usize> =
            self.all.iter().filter_map(|w| w.rollout.reach_exceeded_at).collect();
        let count = self.all.len() as f64;
        let of = |f: fn(&Rollout) -> f64| -> Vec<f64> {
            self.all.iter().map(|w| f(&w.rollout)).collect()
        };
        let largest = |v: Vec<f64>| v.into_iter().fold(0.0, f64::max);
        let squares: Vec<f64> = of(|r| r.rms_residual_m.powi(2));
        let starts: Vec<f64> =
            self.all.iter().map(|w| w.start.distance).filter(|d| d.is_finite()).collect();
        Some(BodyScores {
            body: person.name.clone(),
            objective: 0.0,
            person_clearance: None,
            worst_off: scores[ScoringMethod::Rula]
                .people
                .as_ref()
                .map(|spread| self.worst_off(lens, spread, person)),
            of_size: scores[ScoringMethod::Rula]
                .people
                .as_ref()
                .and_then(|spread| self.of_size(spread, person)),
            strain: None,
            rollouts: self.all.len(),
            scores,
            other_side_rula: if other_arm == OtherArm::Unknown && !lens.both_hands {
                None
            } else {
                score_distribution(
                    &self.other_scores(lens),
                    self.dt,
                    ScoringMethod::Rula.worst(),
                    P_AT_LEAST_S,
                    self.persons,
                )
            },
            reach_exceeded: exceeded.len() as f64 / count,
            reach_exceeded_from_s: exceeded.iter().min().map(|&k| k as f64 * self.dt),
            hand_residual_max_mm: 1e3 * largest(of(|r| r.max_residual_m)),
            hand_residual_rms_mm: 1e3 * mean(&squares).sqrt(),
            hand_residual_max_deg: largest(of(|r| r.max_residual_rad)).to_degrees(),
            extrapolation_share: self.extrapolation_share,
            unusual_starts: self.all.iter().filter(|w| w.start.is_unusual).count() as f64 / count,
            start_distance: if starts.is_empty() { 0.0 } else { mean(&starts) },
        })
    }

    fn other_scores(&self, lens: &Lens) -> Vec<Vec<u8>> {
        let score = |w: &Repetition| w.angles.iter().map(|a| a.other_rula(lens).grand).collect();
        self.all.iter().map(score).collect()
    }
}

fn part(step: &StepOverTime) -> PartScore {
    let s = &step.share;
    PartScore {
        part: s.step.into(),
        mean: s.mean,
        drives: s.drop,
        drives_se: s.drop_se,
        drives_share: s.drives_share,
        over_time: step.course.iter().map(|v| (1e3 * v).round() / 1e3).collect(),
    }
}

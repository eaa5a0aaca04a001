//! The scores of the repetitions of one body along a path, for ranking and report alike.
//!
//! ```text
//! s_r(t)                                   official score of repetition r, whole numbers
//! time mean    S_r = mean over t           counts a slow part of the path more than a quick one
//! per metre    M_r = sum s_r ds / sum ds   ds: hand travel; the same whatever the timing
//! peak         P_r = 95th percentile over t; over r the median, interpolated within whole scores
//! ```

use super::repetitions::{Repetition, Repetitions};
use super::result::{MethodScores, PartScore};
use crate::ergonomics::{
    P_AT_LEAST_S, PairedDifference, PeopleSpread, PerMethod, ScoringMethod, Sheet, by_person,
    exposure_by_rollout, paired_difference, score_distribution, time_means,
};
use crate::math::stats::{grouped_median, mean, quantile};
use crate::survey::{Lens, Scorable};
use rayon::prelude::*;

/// Quantile over time that counts as a repetition's peak.
const PEAK: f64 = 0.95;
/// Figures by one method, one entry for each repetition.
#[derive(Debug, Clone, Default)]
pub struct MethodFigures {
    /// Mean over time.
    pub time_mean: Vec<f64>,
    /// Mean over hand travel.
    pub per_metre: Vec<f64>,
    /// 95th percentile over time.
    pub peak: Vec<f64>,
    /// Share of time at action level 3 or above.
    pub high: Vec<f64>,
    /// 1 where action level 3 or above lasts for at least half a second in total.
    pub lasts_high: Vec<f64>,
    /// How many people repeat in turn; none where every repetition counts alone.
    pub persons: Option<usize>,
}

impl MethodFigures {
    /// Less those of another path on the same repetitions, by what is picked.
    pub(super) fn less(&self, other: &Self, pick: fn(&Self) -> &Vec<f64>) -> PairedDifference {
        let of = |f: &Self| by_person(pick(f), self.persons);
        paired_difference(&of(self), &of(other))
    }

    /// Appends further repetitions.
    pub(super) fn extend(&mut self, more: Self) {
        self.time_mean.extend(more.time_mean);
        self.per_metre.extend(more.per_metre);
        self.peak.extend(more.peak);
        self.high.extend(more.high);
        self.lasts_high.extend(more.lasts_high);
        self.persons = more.persons;
    }
}

/// Scores of every repetition at every sample; the worst there is once the reach is exceeded.
pub(super) struct Scored<'a> {
    by_method: PerMethod<Vec<Vec<u8>>>,
    dt: f64,
    travel: &'a [f64],
    persons: Option<usize>,
}

impl<'a> Scored<'a> {
    pub(super) fn of<A: Scorable>(repetitions: &'a Repetitions<A>, lens: &Lens) -> Self {
        Self::from_sheets(repetitions, &Sheets::of(repetitions, |a| a.score(lens)))
    }

    pub(super) fn from_sheets<A>(repetitions: &'a Repetitions<A>, sheets: &Sheets) -> Self {
        let by_method = PerMethod::of(|m| sheets.totals(m));
        let Repetitions { dt, travel, persons, .. } = repetitions;
        Self { by_method, dt: *dt, travel, persons: *persons }
    }

    /// By one method.
    pub(super) fn figures(&self, method: ScoringMethod) -> MethodFigures {
        let scores = &self.by_method[method];
        let along = |s: &Vec<u8>| s.iter().zip(self.travel).map(|(s, w)| f64::from(*s) * w).sum();
        let peak = |s: &Vec<u8>| {
            let s: Vec<f64> = s.iter().map(|s| f64::from(*s)).collect();
            quantile(&s, PEAK)
        };
        let lasts = |s: &Vec<u8>| {
            let high = s.iter().filter(|s| **s >= method.high()).count();
            let lasts = high > 0 && high as f64 * self.dt >= P_AT_LEAST_S - 1e-9;
            f64::from(u8::from(lasts))
        };
        MethodFigures {
            time_mean: time_means(scores),
            per_metre: scores.iter().map(along).collect(),
            peak: scores.iter().map(peak).collect(),
            high: exposure_by_rollout(scores, method.high()),
            lasts_high: scores.iter().map(lasts).collect(),
            persons: self.persons,
        }
    }

    /// For the report; `None` without repetitions.
    pub(super) fn report(
        &self,
        method: ScoringMethod,
        parts: Vec<PartScore>,
    ) -> Option<MethodScores> {
        let scores = &self.by_method[method];
        let distribution =
            score_distribution(scores, self.dt, method.worst(), P_AT_LEAST_S, self.persons)?;
        let figures = self.figures(method);
        let band = |v: &[f64]| [mean(v), quantile(v, 0.05), quantile(v, 0.95)];
        let mut levels = method.levels(&distribution);
        for level in levels.iter_mut().skip(1) {
            level.by_rollout = exposure_by_rollout(scores, level.from_score);
        }
        Some(MethodScores {
            people: PeopleSpread::of(&figures.time_mean, &figures.lasts_high, self.persons),
            levels,
            distribution,
            high_band: band(&figures.high),
            per_metre: mean(&figures.per_metre),
            peak: grouped_median(&figures.peak),
            by_rollout: figures.time_mean,
            per_metre_by_rollout: figures.per_metre,
            peak_by_rollout: figures.peak,
            parts,
        })
    }
}

/// The sheets of every repetition and frame; nothing once the reach is exceeded.
pub(super) struct Sheets(pub Vec<Vec<Option<Sheet>>>);

impl Sheets {
    pub(super) fn of<A: Sync>(
        repetitions: &Repetitions<A>,
        score: impl Fn(&A) -> Sheet + Sync,
    ) -> Self {
        let one = |w: &Repetition<A>| {
            let end = w.rollout.reach_exceeded_at.unwrap_or(usize::MAX);
            let scored = |(k, a): (usize, &A)| (k < end).then(|| score(a));
            w.angles.iter().enumerate().map(scored).collect()
        };
        Self(repetitions.all.par_iter().map(one).collect())
    }

    fn totals(&self, method: ScoringMethod) -> Vec<Vec<u8>> {
        let total = |s: &Option<Sheet>| s.map_or(method.worst(), |s| s.total(method));
        self.0.iter().map(|r| r.iter().map(total).collect()).collect()
    }

    /// Means over repetitions and time.
    pub(super) fn expected(&self) -> PerMethod<f64> {
        PerMethod::of(|m| mean(&time_means(&self.totals(m))))
    }
}

#[cfg(test)]
mod tests {
    use super::super::repetitions::travel_shares;
    use super::*;
    use crate::math::Pose;

    #[test]
    fn the_mean_over_travel_does_not_know_the_timing() {
        let at = |x: f64| Pose::translation(x, 0.0, 0.0);
        // The same way, lingering at the end of it.
        let even: Vec<Pose> = (0..=100).map(|k| at(f64::from(k) / 100.0)).collect();
        let late: Vec<Pose> = (0..=100).map(|k| at((f64::from(k) / 50.0).min(1.0))).collect();
        for (poses, resting) in [(even, 1), (late, 51)] {
            let scores: Vec<u8> =
                poses.iter().map(|p| if p.translation.x < 0.5 { 2 } else { 6 }).collect();
            let scored = Scored {
                by_method: PerMethod::of(|_| vec![scores.clone()]),
                dt: 0.04,
                travel: &travel_shares(&poses),
                persons: None,
            };
            let figures = scored.figures(ScoringMethod::Rula);
            assert!((figures.per_metre[0] - 4.0).abs() < 0.05, "{}", figures.per_metre[0]);
            let slow = figures.time_mean[0] > 4.5;
            assert_eq!(slow, resting > 1, "{}", figures.time_mean[0]);
            assert_eq!((figures.peak[0], figures.lasts_high[0]), (6.0, 1.0));
        }
    }
}

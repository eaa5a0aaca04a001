//! The objective, from the figures of every rollout.

use super::preset::Objective;
use super::repetitions::Repetitions;
use super::scored::{MethodFigures, Scored};
use crate::ergonomics::{PerMethod, ScoringMethod};
use crate::math::stats::{cvar_upper, mean, normal_quantile, std_dev};
use crate::scenario::PersonMargin;
use crate::survey::{Lens, Scorable};

/// Least margin by which a shortfall is measured, m.
const LEAST_MARGIN_M: f64 = 0.01;
/// Weight of a whole missing margin, in units of the objective; about what paths differ by.
const CROWDED: f64 = 0.5;

/// Figures of one body along one path, one entry for each repetition.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Scores by method.
    pub scores: PerMethod<MethodFigures>,
    /// 1 where the reach is exceeded.
    pub lost: Vec<f64>,
    /// Earliest time at which a reach was exceeded, s.
    pub lost_from_s: Option<f64>,
    /// Root mean square joint speed, rad/s.
    pub effort: Vec<f64>,
    /// Least distance to the robot, m, of the repetitions that were looked at.
    pub near_m: Vec<f64>,
    /// The least of these with link of the robot and body part there; not in a search.
    pub nearest: Option<(f64, [String; 2])>,
}

impl Figures {
    /// Of the repetitions of one body.
    pub(super) fn of<A: Scorable>(repetitions: &Repetitions<A>, lens: &Lens) -> Self {
        let scored = Scored::of(repetitions, lens);
        let lost: Vec<Option<usize>> =
            repetitions.all.iter().map(|w| w.rollout.reach_exceeded_at).collect();
        Self {
            scores: PerMethod::of(|m| scored.figures(m)),
            lost: lost.iter().map(|l| f64::from(u8::from(l.is_some()))).collect(),
            lost_from_s: lost.into_iter().flatten().min().map(|k| k as f64 * repetitions.dt),
            effort: repetitions.all.iter().map(|w| effort(&w.rollout.q, repetitions.dt)).collect(),
            near_m: Vec::new(),
            nearest: None,
        }
    }

    /// By the method that leads the verdict.
    pub fn rula(&self) -> &MethodFigures {
        &self.scores[ScoringMethod::Rula]
    }

    /// By REBA.
    pub fn reba(&self) -> &MethodFigures {
        &self.scores[ScoringMethod::Reba]
    }

    /// Appends further repetitions.
    pub(super) fn extend(&mut self, mut more: Self) {
        for method in ScoringMethod::ALL {
            self.scores[method].extend(std::mem::take(&mut more.scores[method]));
        }
        self.lost.extend(more.lost);
        self.lost_from_s = match (self.lost_from_s, more.lost_from_s) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        self.effort.extend(more.effort);
        self.near_m.extend(more.near_m);
        let both = self.nearest.take().into_iter().chain(more.nearest);
        self.nearest = both.min_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// The part of the objective that is this body's; `time`: the duration over the scenario's where it
    /// is free.
    pub(super) fn value(&self, o: &Objective, time: Option<f64>) -> f64 {
        // With a free duration the score-time over the cycle counts, never the time mean, which
        // dwelling at the good end would lower.
        let over_cycle = |score: f64| match time {
            Some(share) => 1.0 + (score - 1.0) * share,
            None => score,
        };
        let of_method = |(method, figures): (ScoringMethod, &MethodFigures)| {
            let w = o.weights(method);
            w.expected * over_cycle(mean(&figures.time_mean))
                + w.cvar90 * over_cycle(cvar_upper(&figures.time_mean, 0.1))
                + w.exposure * mean(&figures.high) * time.unwrap_or(1.0)
                + w.p_high * mean(&figures.lasts_high)
        };
        self.scores.iter().map(of_method).sum::<f64>() + o.effort * mean(&self.effort)
    }
}

/// Root mean square joint speed, rad/s.
fn effort(q: &[nalgebra::DVector<f64>], dt: f64) -> f64 {
    let squares = q.windows(2).map(|w| (&w[1] - &w[0]).norm_squared()).sum::<f64>();
    let count = q.first().map_or(1, nalgebra::Matrix::len) * q.len().saturating_sub(1).max(1);
    (squares / count as f64).sqrt() / dt
}

/// What else enters, of the path itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathTerms {
    /// Duration over the scenario's; none when it is not free.
    pub time_share: Option<f64>,
    /// Smallest clearance of the robot, m.
    pub clearance_m: Option<f64>,
    /// The margin between robot and person, in a search; the selection refuses instead.
    pub person: Option<PersonMargin>,
}

/// The objective for the worst body.
pub(super) fn objective(o: &Objective, bodies: &[Figures], path: PathTerms) -> f64 {
    let short = o.clearance_wanted_m - path.clearance_m.unwrap_or(f64::INFINITY);
    let terms = o.duration * path.time_share.unwrap_or(1.0)
        + if o.clearance > 0.0 {
            o.clearance * (short / o.clearance_wanted_m).max(0.0)
        } else {
            0.0
        };
    let worst =
        bodies.iter().map(|b| b.value(o, path.time_share)).fold(f64::NEG_INFINITY, f64::max);
    let crowded = path
        .person
        .map_or(0.0, |margin| bodies.iter().map(|b| crowding(b, &margin)).fold(0.0, f64::max));
    worst + terms + crowded
}

/// What too little distance adds to the objective in the search: for a body, its figures. The few
/// repetitions there are too few to count those below the margin, so that the distance which the allowed
/// share undercuts is estimated as that of a normal distribution.
fn crowding(figures: &Figures, margin: &PersonMargin) -> f64 {
    let d = &figures.near_m;
    if d.is_empty() || margin.share >= 1.0 {
        return 0.0;
    }
    let spread = if d.len() > 1 { std_dev(d) } else { 0.0 };
    let undercut = mean(d) + normal_quantile(margin.share) * spread;
    let missing = (margin.margin_m - undercut) / margin.margin_m.max(LEAST_MARGIN_M);
    CROWDED * missing.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_repetitions_cost_what_is_missing_of_the_margin() {
        let margin = PersonMargin { margin_m: 0.05, share: 0.05 };
        let of = |near_m: Vec<f64>| Figures { near_m, ..Figures::default() };
        assert_eq!(crowding(&of(vec![0.2, 0.21, 0.22, 0.23]), &margin), 0.0);
        // Mean 0.06, standard deviation 0.01: one in twenty is below 0.0436, 13 % of the margin short.
        let near = vec![0.05, 0.06, 0.07];
        assert!((crowding(&of(near.clone()), &margin) - 0.5 * 0.1290).abs() < 1e-4);
        assert_eq!(crowding(&of(vec![0.06]), &margin), 0.0);
        assert_eq!(crowding(&of(Vec::new()), &margin), 0.0);
        assert_eq!(crowding(&of(near), &PersonMargin { share: 1.0, ..margin }), 0.0);
    }
}

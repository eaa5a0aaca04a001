//! What a lower mean may not be bought with: along the best path neither the peak nor the score per
//! metre of hand travel is worse than along the straight one, beyond the Monte Carlo error; and unless
//! the timing is free, it is that of the straight path. (A path far too long for its duration would
//! otherwise be squeezed by its limits until it lingers where posture is good.)

use super::along::timing_between;
use super::environment::Environment;
use super::objective::Figures;
use super::prepare::Prepared;
use super::preset::Objective;
use super::result::{BodyScores, Bought, Price, TimingDifference};
use crate::ergonomics::{
    PairedDifference, ScoringMethod, by_person, paired_difference, paired_median_difference,
};
use crate::math::stats::mean;
use crate::scenario::Freedom;

/// Least difference that counts: half of the last digit that is shown.
const LEAST: f64 = 0.005;
/// What a search adds for a point of score by which a path is worse than the straight one.
const PENALTY: f64 = 1.0;

/// The prices of a path, from its figures and the straight one's on the same repetitions, body by body.
pub(super) fn prices(o: &Objective, this: &[Figures], straight: &[Figures]) -> Vec<Bought> {
    let of = |f: &Figures, m: ScoringMethod| {
        let s = &f.scores[m];
        let figures = [s.time_mean.clone(), s.peak.clone(), s.per_metre.clone()];
        Compared { figures, persons: s.persons }
    };
    let pairs = this.iter().zip(straight);
    pairs.flat_map(|(a, b)| of_body(o, |m| [of(a, m), of(b, m)])).collect()
}

/// The same from reported scores.
pub(super) fn reported_prices(
    o: &Objective,
    this: &[BodyScores],
    straight: &[BodyScores],
) -> Vec<Bought> {
    let of = |b: &BodyScores, m: ScoringMethod| {
        let s = &b.scores[m];
        let figures =
            [s.by_rollout.clone(), s.peak_by_rollout.clone(), s.per_metre_by_rollout.clone()];
        Compared { figures, persons: s.persons() }
    };
    let pairs = this.iter().zip(straight);
    pairs.flat_map(|(a, b)| of_body(o, |m| [of(a, m), of(b, m)])).collect()
}

/// Means over time, peaks and scores per metre, one for each repetition, of people who repeat in turn.
struct Compared {
    figures: [Vec<f64>; 3],
    persons: Option<usize>,
}

/// Of the methods whose mean the objective lowers, and which is lower here: where it is not, nothing
/// was bought.
fn of_body(o: &Objective, of: impl Fn(ScoringMethod) -> [Compared; 2]) -> Vec<Bought> {
    let lowered = ScoringMethod::ALL.into_iter().filter(|m| o.weights(*m).all() != [0.0; 4]);
    let both = |method: ScoringMethod| {
        let [a, b] = of(method);
        let persons = a.persons;
        let ([mean_a, peak_a, metre_a], [mean_b, peak_b, metre_b]) = (a.figures, b.figures);
        let is_lower = mean(&mean_a) < mean(&mean_b);
        let [metre_a, metre_b] = [metre_a, metre_b].map(|m| by_person(&m, persons));
        let prices = [
            (Price::Peak, paired_median_difference(&peak_a, &peak_b, persons)),
            (Price::PerMetre, paired_difference(&metre_a, &metre_b)),
        ];
        prices
            .map(|(with, difference)| Bought { with, method, difference })
            .into_iter()
            .filter(move |b| is_lower && is_clearly_worse(&b.difference))
    };
    lowered.flat_map(both).collect()
}

fn is_clearly_worse(d: &PairedDifference) -> bool {
    d.low95 > 0.0 && d.mean > LEAST
}

/// What a search adds to the objective, so that it does not spend its paths on what cannot be the best.
pub(super) fn penalty(o: &Objective, this: &[Figures], straight: &[Figures]) -> f64 {
    let excess = |a: &[f64], b: &[f64]| (mean(a) - mean(&b[..a.len().min(b.len())])).max(0.0);
    let of_method = |a: &Figures, b: &Figures, m: ScoringMethod| {
        let (a, b) = (&a.scores[m], &b.scores[m]);
        let is_lowered = o.weights(m).all() != [0.0; 4];
        let is_lower =
            mean(&a.time_mean) < mean(&b.time_mean[..a.time_mean.len().min(b.time_mean.len())]);
        f64::from(u8::from(is_lowered && is_lower))
            * (excess(&a.peak, &b.peak) + excess(&a.per_metre, &b.per_metre))
    };
    let of_body = |(a, b)| ScoringMethod::ALL.into_iter().map(|m| of_method(a, b, m)).sum::<f64>();
    PENALTY * this.iter().zip(straight).map(of_body).fold(0.0, f64::max)
}

/// What a search adds for a share of the way by which a path's progress leaves the straight one's, beyond
/// most of what still counts as the same timing.
const TIMING_PENALTY: f64 = 20.0;
const TIMING_ROOM: f64 = 0.8;

/// Whether paths have to keep the straight one's timing.
pub(super) fn holds_timing(environment: &Environment) -> bool {
    let free = &environment.scenario.free;
    free.pace_spread.is_none() && free.range(Freedom::Dwell).is_none()
}

/// Largest difference of progress from the straight path; 0 where the timing need not be held.
fn progress_apart(environment: &Environment, p: &Prepared) -> f64 {
    let paths = p.path.as_ref().zip(environment.straight.as_ref().and_then(|s| s.path.as_ref()));
    let apart = paths.filter(|_| holds_timing(environment)).and_then(|(a, b)| timing_between(a, b));
    apart.map_or(0.0, |t| t.progress)
}

/// What a search adds for another timing than the straight path's.
pub(super) fn timing_penalty(environment: &Environment, p: &Prepared) -> f64 {
    let room = TIMING_ROOM * TimingDifference::PROGRESS;
    TIMING_PENALTY * (progress_apart(environment, p) - room).max(0.0)
}

/// Whether a path's timing allows it to be the best.
pub(super) fn keeps_timing(environment: &Environment, p: &Prepared) -> bool {
    progress_apart(environment, p) <= TimingDifference::PROGRESS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::PerMethod;
    use crate::planner::{MethodFigures, load_preset};

    fn figures(mean: f64, peak: &[f64], per_metre: &[f64]) -> Figures {
        let of = MethodFigures {
            time_mean: vec![mean; 4],
            peak: peak.to_vec(),
            per_metre: per_metre.to_vec(),
            ..MethodFigures::default()
        };
        Figures { scores: PerMethod::of(|_| of.clone()), ..Figures::default() }
    }

    #[test]
    fn a_lower_mean_may_not_cost_a_clearly_higher_peak() {
        let o = load_preset("default").unwrap().objective;
        let straight = [figures(3.5, &[4.0, 5.0, 4.0, 5.0], &[3.0, 3.2, 3.1, 3.3])];
        let higher = [figures(3.2, &[5.0, 6.0, 5.0, 6.0], &[2.9, 3.1, 3.0, 3.2])];
        let found = prices(&o, &higher, &straight);
        assert_eq!(
            found.iter().map(|b| (b.with, b.method)).collect::<Vec<_>>(),
            [(Price::Peak, ScoringMethod::Rula)]
        );
        assert!((found[0].difference.mean - 1.0).abs() < 1e-12);
        assert!((penalty(&o, &higher, &straight) - 1.0).abs() < 1e-12);
        // Nothing was bought where the mean is no lower: another body's may be.
        let dearer = [figures(3.6, &[5.0, 6.0, 5.0, 6.0], &[3.5, 3.7, 3.6, 3.8])];
        assert!(prices(&o, &dearer, &straight).is_empty());
        // Better in both, and worse by no more than chance.
        let lower = [figures(3.2, &[4.0, 4.0, 4.0, 4.0], &[3.2, 3.1, 3.2, 3.2])];
        assert!(prices(&o, &lower, &straight).is_empty());
    }
}

//! What a lower mean may not be bought with: along the best path neither the peak nor the score per
//! metre of hand travel is worse than along the straight one, beyond the Monte Carlo error.

use super::objective::Figures;
use super::preset::Objective;
use super::result::{BodyScores, Bought, Price};
use super::scored::MethodFigures;
use crate::ergonomics::{PairedDifference, ScoringMethod, paired_difference};
use crate::math::stats::mean;

/// What a search adds for a point of score by which a path is worse than the straight one.
const PENALTY: f64 = 1.0;

/// The prices of a path, from its figures and the straight one's on the same repetitions, body by body.
pub(super) fn prices(o: &Objective, this: &[Figures], straight: &[Figures]) -> Vec<Bought> {
    let of = |f: &MethodFigures| (f.peak.clone(), f.per_metre.clone());
    let pairs = this.iter().zip(straight);
    pairs.flat_map(|(a, b)| of_body(o, |m| [of(&a.scores[m]), of(&b.scores[m])])).collect()
}

/// The same from reported scores.
pub(super) fn reported_prices(
    o: &Objective,
    this: &[BodyScores],
    straight: &[BodyScores],
) -> Vec<Bought> {
    let of = |b: &BodyScores, m: ScoringMethod| {
        let s = &b.scores[m];
        (s.peak_by_rollout.clone(), s.per_metre_by_rollout.clone())
    };
    let pairs = this.iter().zip(straight);
    pairs.flat_map(|(a, b)| of_body(o, |m| [of(a, m), of(b, m)])).collect()
}

/// Peaks and scores per metre, one for each repetition.
type PeakAndMetre = (Vec<f64>, Vec<f64>);

/// Of the methods whose mean the objective lowers.
fn of_body(o: &Objective, of: impl Fn(ScoringMethod) -> [PeakAndMetre; 2]) -> Vec<Bought> {
    let lowered = ScoringMethod::ALL.into_iter().filter(|m| o.weights(*m).all() != [0.0; 4]);
    let both = |method: ScoringMethod| {
        let [this, straight] = of(method);
        [
            (Price::Peak, paired_difference(&this.0, &straight.0)),
            (Price::PerMetre, paired_difference(&this.1, &straight.1)),
        ]
        .map(|(with, difference)| Bought { with, method, difference })
    };
    lowered.flat_map(both).filter(|b| is_clearly_worse(&b.difference)).collect()
}

fn is_clearly_worse(d: &PairedDifference) -> bool {
    d.low95 > 0.0
}

/// What a search adds to the objective, so that it does not spend its paths on what cannot be the best.
pub(super) fn penalty(o: &Objective, this: &[Figures], straight: &[Figures]) -> f64 {
    let excess = |a: &[f64], b: &[f64]| (mean(a) - mean(&b[..a.len().min(b.len())])).max(0.0);
    let of_method = |a: &Figures, b: &Figures, m: ScoringMethod| {
        let (a, b) = (&a.scores[m], &b.scores[m]);
        let is_lowered = o.weights(m).all() != [0.0; 4];
        f64::from(u8::from(is_lowered))
            * (excess(&a.peak, &b.peak) + excess(&a.per_metre, &b.per_metre))
    };
    let of_body = |(a, b)| ScoringMethod::ALL.into_iter().map(|m| of_method(a, b, m)).sum::<f64>();
    PENALTY * this.iter().zip(straight).map(of_body).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::PerMethod;
    use crate::planner::load_preset;

    fn figures(peak: &[f64], per_metre: &[f64]) -> Figures {
        let of = MethodFigures {
            peak: peak.to_vec(),
            per_metre: per_metre.to_vec(),
            ..MethodFigures::default()
        };
        Figures { scores: PerMethod::of(|_| of.clone()), ..Figures::default() }
    }

    #[test]
    fn a_lower_mean_may_not_cost_a_clearly_higher_peak() {
        let o = load_preset("default").unwrap().objective;
        let straight = [figures(&[4.0, 5.0, 4.0, 5.0], &[3.0, 3.2, 3.1, 3.3])];
        let higher = [figures(&[5.0, 6.0, 5.0, 6.0], &[2.9, 3.1, 3.0, 3.2])];
        let found = prices(&o, &higher, &straight);
        assert_eq!(
            found.iter().map(|b| (b.with, b.method)).collect::<Vec<_>>(),
            [(Price::Peak, ScoringMethod::Rula)]
        );
        assert!((found[0].difference.mean - 1.0).abs() < 1e-12);
        assert!((penalty(&o, &higher, &straight) - 1.0).abs() < 1e-12);
        // Better in both, and worse by no more than chance.
        let lower = [figures(&[4.0, 4.0, 4.0, 4.0], &[3.2, 3.1, 3.2, 3.2])];
        assert!(prices(&o, &lower, &straight).is_empty());
    }
}

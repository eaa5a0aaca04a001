//! A movement over time: what was recorded, and where repetitions of strangers are.

use super::super::rollout_check::band_end;
use super::Features;
use crate::math::stats::mean;

/// Shares of the repetitions that are below the curves of a band: the 90 %, the 50 % band and the median.
const LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// One quantity over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// As recorded, T.
    pub recorded: Vec<f64>,
    /// Below which 5, 25, 50, 75 and 95 % of the repetitions are, each T.
    pub quantiles: [Vec<f64>; 5],
    /// Mean over repetitions, T.
    pub mean: Vec<f64>,
}

/// One movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// In the order of [`super::FEATURES`]: leg lengths, then deg.
    pub features: Vec<Curve>,
    /// RULA.
    pub rula: Curve,
}

impl Curve {
    /// Of what was recorded (T) and of repetitions (R x T, two or more).
    pub(in crate::training) fn of(recorded: Vec<f64>, walks: &[Vec<f64>]) -> Self {
        let at = |t: usize| {
            let mut values: Vec<f64> = walks.iter().map(|w| w[t]).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let sorted: Vec<Vec<f64>> = (0..recorded.len()).map(at).collect();
        Self {
            quantiles: LEVELS.map(|p| sorted.iter().map(|v| band_end(v, p)).collect()),
            mean: sorted.iter().map(|v| mean(v)).collect(),
            recorded,
        }
    }

    /// Of one of the features.
    pub(super) fn of_feature(seen: &[Features], walks: &[Vec<Features>], feature: usize) -> Self {
        let of = |all: &[Features]| all.iter().map(|f| f[feature]).collect::<Vec<f64>>();
        Self::of(of(seen), &walks.iter().map(|w| of(w)).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_repetitions_at_each_time() {
        let walks: Vec<Vec<f64>> = (1..=19).map(|r| vec![f64::from(r), -f64::from(r)]).collect();
        let curve = Curve::of(vec![3.0, 4.0], &walks);
        // The p (R + 1)-th of them.
        let first: Vec<f64> = curve.quantiles.iter().map(|q| q[0]).collect();
        for (found, expected) in first.iter().zip([1.0, 5.0, 10.0, 15.0, 19.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert!((curve.quantiles[0][1] + 19.0).abs() < 1e-12);
        assert_eq!(curve.mean, [10.0, -10.0]);
        let features = vec![vec![[0.0, 2.0, 0.0, 0.0, 0.0]]; 2];
        let curve = Curve::of_feature(&[[9.0, 1.0, 9.0, 9.0, 9.0]], &features, 1);
        assert_eq!((curve.recorded[0], curve.mean[0]), (1.0, 2.0));
    }
}

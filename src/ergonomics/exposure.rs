//! What many sampled postures say together: expected score, its spread, the time spent at high
//! scores, and whether one path is better than another.

use crate::math::stats::{cvar_upper, mean, quantile, quantile_of_sorted, std_dev};
use serde::Serialize;

/// Usual duration for [`ScoreDistribution::p_at_least`], s.
pub const P_AT_LEAST_S: f64 = 0.5;

/// Scores over time across rollouts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BandOverTime {
    /// Mean over rollouts at each time.
    pub mean: Vec<f64>,
    /// 5th percentile over rollouts at each time.
    pub p05: Vec<f64>,
    /// 95th percentile over rollouts at each time.
    pub p95: Vec<f64>,
}

/// Distribution of one score over rollouts `r` and times `t`; `S_r` is the time mean of rollout `r`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScoreDistribution {
    /// Mean of `S_r`. A mean of an ordinal score: it ranks, it does not measure.
    pub expected: f64,
    /// Standard error of `expected` over rollouts; `None` for a single rollout.
    pub standard_error: Option<f64>,
    /// Median of `S_r`.
    pub median: f64,
    /// 5th percentile of `S_r`.
    pub p05: f64,
    /// 95th percentile of `S_r`.
    pub p95: f64,
    /// Mean of the worst tenth of `S_r`.
    pub cvar90: f64,
    /// Share of the time at score `k` or above, mean over rollouts; index `k` from 0.
    pub exposure: Vec<f64>,
    /// Share of rollouts at score `k` or above for at least the named duration in total; index `k`
    /// from 0.
    pub p_at_least: Vec<f64>,
    /// Spread over rollouts at each time.
    pub band: BandOverTime,
}

/// Summarises the scores of rollouts on one uniform time grid.
///
/// `scores[r][i]` is the score at time `i dt` (s), with the worst score filled in by the caller
/// after a rollout's reach is exceeded. Each sample stands for `dt` of time. `worst` is the highest
/// score of the method (7 for RULA, 15 for REBA) and sets how far the lists by `k` go; `at_least_s`
/// is the duration for `p_at_least` (usually [`P_AT_LEAST_S`]). Rollouts may differ in length; each
/// then counts alike, and the band at a time covers those that reach it. `None` when there is no
/// rollout or one has no sample.
pub fn score_distribution(
    scores: &[Vec<u8>],
    dt: f64,
    worst: u8,
    at_least_s: f64,
) -> Option<ScoreDistribution> {
    if scores.is_empty() || scores.iter().any(Vec::is_empty) {
        return None;
    }
    let n = scores.len() as f64;
    let time_means: Vec<f64> = scores
        .iter()
        .map(|s| s.iter().map(|v| f64::from(*v)).sum::<f64>() / s.len() as f64)
        .collect();
    let size = usize::from(worst) + 1;
    let (mut exposure, mut p_at_least) = (vec![0.0; size], vec![0.0; size]);
    for rollout in scores {
        for (k, count) in counts_at_least(rollout, worst).into_iter().enumerate() {
            exposure[k] += count as f64 / rollout.len() as f64 / n;
            // Room for rounding in the product: 0.5 s is 25 samples of 0.02 s.
            if count > 0 && count as f64 * dt >= at_least_s - 1e-9 {
                p_at_least[k] += 1.0 / n;
            }
        }
    }
    Some(ScoreDistribution {
        expected: mean(&time_means),
        standard_error: (scores.len() > 1).then(|| std_dev(&time_means) / n.sqrt()),
        median: quantile(&time_means, 0.5),
        p05: quantile(&time_means, 0.05),
        p95: quantile(&time_means, 0.95),
        cvar90: cvar_upper(&time_means, 0.1),
        exposure,
        p_at_least,
        band: band_over_time(scores),
    })
}

/// Number of samples at score `k` or above, for `k` from 0 to `worst`.
fn counts_at_least(rollout: &[u8], worst: u8) -> Vec<usize> {
    let mut counts = vec![0usize; usize::from(worst) + 1];
    for score in rollout {
        counts[usize::from(*score.min(&worst))] += 1;
    }
    for k in (0..usize::from(worst)).rev() {
        counts[k] += counts[k + 1];
    }
    counts
}

fn band_over_time(scores: &[Vec<u8>]) -> BandOverTime {
    let length = scores.iter().map(Vec::len).max().unwrap_or(0);
    let mut band = BandOverTime {
        mean: Vec::with_capacity(length),
        p05: Vec::with_capacity(length),
        p95: Vec::with_capacity(length),
    };
    let mut column = Vec::with_capacity(scores.len());
    for i in 0..length {
        column.clear();
        column.extend(scores.iter().filter_map(|s| s.get(i)).map(|v| f64::from(*v)));
        column.sort_by(f64::total_cmp);
        band.mean.push(mean(&column));
        band.p05.push(quantile_of_sorted(&column, 0.05));
        band.p95.push(quantile_of_sorted(&column, 0.95));
    }
    band
}

/// Difference of two paths on the same rollouts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairedDifference {
    /// Number of pairs.
    pub n: usize,
    /// Mean of `a - b`.
    pub mean: f64,
    /// Lower end of the 95 % confidence interval.
    pub low95: f64,
    /// Upper end of the 95 % confidence interval.
    pub high95: f64,
    /// Whether the interval leaves 0 out: the paths do differ.
    pub clear: bool,
}

/// Mean of `a - b` over pairs with its 95 % confidence interval by Student's t with `n - 1` degrees
/// of freedom.
///
/// `a[r]` and `b[r]` belong to the same draw of the same person; the pairing removes what the draws
/// have in common. Values beyond the shorter list have no pair and are left out. The interval is
/// infinite for one pair and not a number for none; neither is clear.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::paired_difference;
/// let today = [3.4, 4.0, 3.1, 3.8];
/// let planned = [2.9, 3.6, 2.8, 3.2];
/// assert!(paired_difference(&today, &planned).clear);
/// assert!(!paired_difference(&today, &today).clear);
/// ```
pub fn paired_difference(a: &[f64], b: &[f64]) -> PairedDifference {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let n = differences.len();
    let mean = mean(&differences);
    let half = match n {
        0 => f64::NAN,
        1 => f64::INFINITY,
        _ => t_critical_975(n - 1) * std_dev(&differences) / (n as f64).sqrt(),
    };
    let (low95, high95) = (mean - half, mean + half);
    PairedDifference { n, mean, low95, high95, clear: low95 > 0.0 || high95 < 0.0 }
}

/// 97.5 % quantile of Student's t: tabulated up to 4 degrees of freedom, then the Cornish-Fisher
/// series about the normal quantile (Abramowitz and Stegun 26.7.5), good to 1e-3.
fn t_critical_975(degrees: usize) -> f64 {
    const FEW: [f64; 4] = [12.706_205, 4.302_653, 3.182_446, 2.776_445];
    const Z: f64 = 1.959_963_985;
    if let Some(t) = degrees.checked_sub(1).and_then(|i| FEW.get(i)) {
        return *t;
    }
    let v = degrees.max(1) as f64;
    let g1 = (Z.powi(3) + Z) / 4.0;
    let g2 = (5.0 * Z.powi(5) + 16.0 * Z.powi(3) + 3.0 * Z) / 96.0;
    let g3 = (3.0 * Z.powi(7) + 19.0 * Z.powi(5) + 17.0 * Z.powi(3) - 15.0 * Z) / 384.0;
    let g4 = (79.0 * Z.powi(9) + 776.0 * Z.powi(7) + 1482.0 * Z.powi(5)
        - 1920.0 * Z.powi(3)
        - 945.0 * Z)
        / 92_160.0;
    Z + g1 / v + g2 / v.powi(2) + g3 / v.powi(3) + g4 / v.powi(4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn figures_of_a_small_case() {
        let scores = vec![vec![3, 3, 5, 5], vec![3, 7, 7, 7]];
        let d = score_distribution(&scores, 0.2, 7, 0.5).unwrap();
        assert_relative_eq!(d.expected, 5.0);
        assert_relative_eq!(d.standard_error.unwrap(), 1.0);
        assert_relative_eq!(d.median, 5.0);
        assert_relative_eq!(d.cvar90, 6.0);
        assert_eq!(d.exposure.len(), 8);
        assert_relative_eq!(d.exposure[0], 1.0);
        assert_relative_eq!(d.exposure[5], 5.0 / 8.0);
        assert_relative_eq!(d.exposure[7], 3.0 / 8.0);
        // 0.4 s of the first rollout are too short, 0.6 s of the second are not.
        assert_eq!(d.p_at_least, [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5]);
        assert_eq!(d.band.mean, [3.0, 5.0, 6.0, 6.0]);
        assert_relative_eq!(d.band.p95[1], 6.8, epsilon = 1e-12);
        assert_relative_eq!(d.band.p05[1], 3.2, epsilon = 1e-12);
    }

    #[test]
    fn exactly_the_named_duration_counts() {
        let scores = vec![[vec![7; 25], vec![1; 25]].concat()];
        let d = score_distribution(&scores, 0.02, 7, P_AT_LEAST_S).unwrap();
        assert_relative_eq!(d.p_at_least[7], 1.0);
        assert_eq!(d.standard_error, None);
    }

    #[test]
    fn expected_score_is_the_sum_of_exposures() {
        let scores: Vec<Vec<u8>> =
            (0..9u8).map(|r| (0..40u8).map(|i| 1 + (r * 7 + i * 3) % 15).collect()).collect();
        let d = score_distribution(&scores, 0.1, 15, 0.5).unwrap();
        assert_relative_eq!(d.exposure[1..].iter().sum::<f64>(), d.expected, epsilon = 1e-12);
        assert!(d.p05 <= d.median && d.median <= d.p95 && d.expected <= d.cvar90);
    }

    #[test]
    fn nothing_to_summarise_is_none() {
        assert_eq!(score_distribution(&[], 0.1, 7, 0.5), None);
        assert_eq!(score_distribution(&[vec![1], vec![]], 0.1, 7, 0.5), None);
    }

    #[test]
    fn critical_values_of_student() {
        for (degrees, t) in
            [(1, 12.706), (4, 2.776), (5, 2.571), (9, 2.262), (29, 2.045), (200, 1.972)]
        {
            assert_relative_eq!(t_critical_975(degrees), t, epsilon = 1.5e-3);
        }
    }

    #[test]
    fn paired_intervals() {
        let d = paired_difference(&[2.0, 4.0, 6.0], &[1.0, 2.0, 3.0]);
        assert_relative_eq!(d.mean, 2.0);
        assert_relative_eq!(d.high95 - d.mean, 4.302_653 / 3.0f64.sqrt(), epsilon = 1e-6);
        assert!(!d.clear);
        // The same drop in every pair is clear; one pair or none never is.
        assert!(paired_difference(&[2.0, 3.0], &[1.5, 2.5]).clear);
        assert!(!paired_difference(&[2.0], &[1.0]).clear);
        assert!(!paired_difference(&[], &[]).clear);
    }
}

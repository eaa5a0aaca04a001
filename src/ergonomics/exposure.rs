//! What many sampled postures say together: expected score, its spread, the time spent at high
//! scores.

use super::people::by_person;
use crate::math::stats::{cvar_upper, mean, quantile, quantile_of_sorted, standard_error};
use serde::{Deserialize, Serialize};

/// Usual duration for [`ScoreDistribution::p_at_least`], s.
pub const P_AT_LEAST_S: f64 = 0.5;

/// Scores over time across rollouts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BandOverTime {
    /// Mean over rollouts at each time.
    pub mean: Vec<f64>,
    /// 5th percentile over rollouts at each time.
    pub p05: Vec<f64>,
    /// 95th percentile over rollouts at each time.
    pub p95: Vec<f64>,
}

/// Distribution of one score over rollouts `r` and times `t`; `S_r` is the time mean of rollout `r`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Monte Carlo standard error of each `exposure` over rollouts; `None` for a single rollout.
    pub exposure_se: Option<Vec<f64>>,
    /// Share of rollouts at score `k` or above for at least the named duration in total; index `k`
    /// from 0.
    pub p_at_least: Vec<f64>,
    /// Monte Carlo standard error of each `p_at_least`; `None` for a single rollout. It is 0 where no
    /// or every rollout counts: with none of `n`, up to about `3 / n` is compatible (95 %).
    pub p_at_least_se: Option<Vec<f64>>,
    /// Spread over rollouts at each time.
    pub band: BandOverTime,
}

/// Summarises the scores of rollouts on one uniform time grid.
///
/// `scores[r][i]` is the score at time `i dt` (s), with the worst score filled in by the caller
/// after a rollout's reach is exceeded. Each sample stands for `dt` of time. `worst` is the highest
/// score of the method (7 for RULA, 15 for REBA) and sets how far the lists by `k` go; `at_least_s`
/// is the duration for `p_at_least` (usually [`P_AT_LEAST_S`]). Where people repeat in turn, rollout `r` is of
/// person `r` modulo their number, and standard errors are those of means of people. Rollouts may differ in length; each
/// then counts alike, and the band at a time covers those that reach it. `None` when there is no
/// rollout or one has no sample.
pub fn score_distribution(
    scores: &[Vec<u8>],
    dt: f64,
    worst: u8,
    at_least_s: f64,
    persons: Option<usize>,
) -> Option<ScoreDistribution> {
    if scores.is_empty() || scores.iter().any(Vec::is_empty) {
        return None;
    }
    let time_means = time_means(scores);
    let size = usize::from(worst) + 1;
    // By score `k`, one figure for each rollout.
    let mut shares = vec![Vec::with_capacity(scores.len()); size];
    let mut reached = shares.clone();
    for rollout in scores {
        for (k, count) in counts_at_least(rollout, worst).into_iter().enumerate() {
            shares[k].push(count as f64 / rollout.len() as f64);
            // Room for rounding in the product: 0.5 s is 25 samples of 0.02 s.
            let is_long = count > 0 && count as f64 * dt >= at_least_s - 1e-9;
            reached[k].push(f64::from(u8::from(is_long)));
        }
    }
    let means = |by_k: &[Vec<f64>]| by_k.iter().map(|v| mean(v)).collect();
    let error = |values: &[f64]| standard_error(&by_person(values, persons));
    let errors = |by_k: &[Vec<f64>]| by_k.iter().map(|v| error(v)).collect();
    Some(ScoreDistribution {
        expected: mean(&time_means),
        standard_error: error(&time_means),
        median: quantile(&time_means, 0.5),
        p05: quantile(&time_means, 0.05),
        p95: quantile(&time_means, 0.95),
        cvar90: cvar_upper(&time_means, 0.1),
        exposure: means(&shares),
        exposure_se: errors(&shares),
        p_at_least: means(&reached),
        p_at_least_se: errors(&reached),
        band: band_over_time(scores),
    })
}

/// `S_r`: the time mean of each rollout; not a number for one without samples.
pub fn time_means(scores: &[Vec<u8>]) -> Vec<f64> {
    let one = |s: &Vec<u8>| s.iter().map(|v| f64::from(*v)).sum::<f64>() / s.len() as f64;
    scores.iter().map(one).collect()
}

/// Share of its time that each rollout spends at score `k` or above; not a number for one without
/// samples.
pub fn exposure_by_rollout(scores: &[Vec<u8>], k: u8) -> Vec<f64> {
    let one = |s: &Vec<u8>| s.iter().filter(|v| **v >= k).count() as f64 / s.len() as f64;
    scores.iter().map(one).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn figures_of_a_small_case() {
        let scores = vec![vec![3, 3, 5, 5], vec![3, 7, 7, 7]];
        let d = score_distribution(&scores, 0.2, 7, 0.5, None).unwrap();
        assert_relative_eq!(d.expected, 5.0);
        assert_relative_eq!(d.standard_error.unwrap(), 1.0);
        assert_relative_eq!(d.median, 5.0);
        assert_relative_eq!(d.cvar90, 6.0);
        assert_eq!(d.exposure.len(), 8);
        assert_relative_eq!(d.exposure[0], 1.0);
        assert_relative_eq!(d.exposure[5], 5.0 / 8.0);
        assert_relative_eq!(d.exposure[7], 3.0 / 8.0);
        assert_relative_eq!(d.exposure_se.unwrap()[7], 3.0 / 8.0);
        assert_eq!(d.p_at_least_se.as_ref().unwrap()[..5], [0.0, 0.0, 0.0, 0.0, 0.5]);
        assert_eq!(exposure_by_rollout(&scores, 7), [0.0, 0.75]);
        // 0.4 s of the first rollout are too short, 0.6 s of the second are not.
        assert_eq!(d.p_at_least, [1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5]);
        assert_eq!(d.band.mean, [3.0, 5.0, 6.0, 6.0]);
        assert_relative_eq!(d.band.p95[1], 6.8, epsilon = 1e-12);
        assert_relative_eq!(d.band.p05[1], 3.2, epsilon = 1e-12);
    }

    #[test]
    fn exactly_the_named_duration_counts() {
        let scores = vec![[vec![7; 25], vec![1; 25]].concat()];
        let d = score_distribution(&scores, 0.02, 7, P_AT_LEAST_S, None).unwrap();
        assert_relative_eq!(d.p_at_least[7], 1.0);
        assert_eq!((d.standard_error, d.exposure_se), (None, None));
    }

    #[test]
    fn expected_score_is_the_sum_of_exposures() {
        let scores: Vec<Vec<u8>> =
            (0..9u8).map(|r| (0..40u8).map(|i| 1 + (r * 7 + i * 3) % 15).collect()).collect();
        let d = score_distribution(&scores, 0.1, 15, 0.5, None).unwrap();
        assert_relative_eq!(d.exposure[1..].iter().sum::<f64>(), d.expected, epsilon = 1e-12);
        assert!(d.p05 <= d.median && d.median <= d.p95 && d.expected <= d.cvar90);
    }

    #[test]
    fn nothing_to_summarise_is_none() {
        assert_eq!(score_distribution(&[], 0.1, 7, 0.5, None), None);
        assert_eq!(score_distribution(&[vec![1], vec![]], 0.1, 7, 0.5, None), None);
    }
}

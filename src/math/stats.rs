//! Order statistics of samples.

/// Mean; NaN for no samples.
pub fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Unbiased standard deviation; 0 for fewer than two samples.
pub fn std_dev(x: &[f64]) -> f64 {
    if x.len() < 2 {
        return 0.0;
    }
    let m = mean(x);
    (x.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (x.len() - 1) as f64).sqrt()
}

/// Standard error of the mean; `None` for fewer than two samples, which say nothing on it.
pub fn standard_error(x: &[f64]) -> Option<f64> {
    (x.len() > 1).then(|| std_dev(x) / (x.len() as f64).sqrt())
}

/// Quantile by linear interpolation between order statistics (Hyndman and Fan's type 7, the default
/// of R and numpy); NaN for no samples. `p` in [0, 1].
pub fn quantile(x: &[f64], p: f64) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, p)
}

/// [`quantile`] of samples that are already in ascending order.
pub fn quantile_of_sorted(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    let low = at.floor() as usize;
    let high = (low + 1).min(last);
    sorted[low] + (at - low as f64) * (sorted[high] - sorted[low])
}

/// Conditional value at risk: mean of the worst (largest) `share` of the samples.
///
/// The sample at the border counts with the fraction of it that belongs to the tail, so that the
/// figure does not jump with the number of samples (Rockafellar and Uryasev 2002).
pub fn cvar_upper(x: &[f64], share: f64) -> f64 {
    if x.is_empty() {
        return f64::NAN;
    }
    let mut sorted = x.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let count = (share.clamp(0.0, 1.0) * x.len() as f64).max(f64::MIN_POSITIVE);
    let whole = (count.floor() as usize).min(x.len());
    let mut sum: f64 = sorted[..whole].iter().sum();
    if whole < x.len() {
        sum += (count - whole as f64) * sorted[whole];
    }
    sum / count
}

/// Distribution function of the standard normal.
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Its inverse, by halving; shares beyond those of -6 and 6 count as these.
pub fn normal_quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-6.0, 6.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if normal_cdf(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Median of ordinal values, interpolated within the whole number that it falls into, whose values are
/// taken to be spread evenly over one unit (the median of grouped data). It does not jump by one when
/// half of the values are about to change. Not a number without values.
pub fn grouped_median(values: &[f64]) -> f64 {
    let mut whole: Vec<f64> = values.iter().map(|v| v.round()).collect();
    whole.sort_by(f64::total_cmp);
    let Some(&middle) = whole.get(whole.len().saturating_sub(1) / 2) else { return f64::NAN };
    let below = whole.iter().filter(|v| **v < middle).count() as f64;
    let same = whole.iter().filter(|v| **v == middle).count() as f64;
    middle - 0.5 + (0.5 * whole.len() as f64 - below) / same
}

/// Spearman's rank correlation of pairs; those that are equal share the mean of their ranks. None where
/// there are fewer than two pairs, or one of the two is the same everywhere.
pub fn rank_correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    let (x, y) = (ranks(x), ranks(y));
    let middle = 0.5 * (x.len() as f64 + 1.0);
    let sum = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - middle) * (b - middle)).sum()
    };
    let spread = (sum(&x, &x) * sum(&y, &y)).sqrt();
    (spread > 0.0).then(|| sum(&x, &y) / spread)
}

/// Place of each value among all, from 1; equal ones share the mean of their places.
fn ranks(x: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
    let (mut ranks, mut before) = (vec![0.0; x.len()], 0);
    for tied in order.chunk_by(|a, b| x[*a].total_cmp(&x[*b]).is_eq()) {
        for i in tied {
            ranks[*i] = before as f64 + 0.5 * (tied.len() as f64 + 1.0);
        }
        before += tied.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_grouped_median_moves_with_the_shares() {
        assert_eq!(grouped_median(&[5.0; 7]), 5.0);
        assert_eq!(grouped_median(&[5.0, 6.0, 6.0, 5.0]), 5.5);
        // A quarter lies below 5, so the middle is a third of the unit about 5.
        let of = grouped_median(&[4.0, 5.0, 5.0, 5.0]);
        assert!((of - (4.5 + 0.25 / 0.75)).abs() < 1e-12, "{of}");
        assert_eq!(grouped_median(&[6.0, 5.0, 6.0]), 6.0 - 0.5 + (1.5 - 1.0) / 2.0);
        assert!(grouped_median(&[]).is_nan());
    }

    #[test]
    fn quantiles_interpolate() {
        let x = [3.0, 1.0, 2.0, 4.0];
        assert_relative_eq!(quantile(&x, 0.5), 2.5);
        assert_relative_eq!(quantile(&x, 0.0), 1.0);
        assert_relative_eq!(quantile(&x, 1.0), 4.0);
        assert_relative_eq!(quantile(&x, 0.25), 1.75);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn quantiles_of_the_normal_are_those_of_the_tables() {
        for (share, x) in [(0.5, 0.0), (0.975, 1.959_963_985), (0.05, -1.644_853_627)] {
            assert!((normal_quantile(share) - x).abs() < 1e-8);
        }
        for x in [-5.0, -1.0, 0.3, 2.0] {
            assert!((normal_quantile(normal_cdf(x)) - x).abs() < 1e-6);
        }
        assert!((normal_quantile(0.0) + 6.0).abs() < 1e-9);
    }

    #[test]
    fn cvar_is_the_mean_of_the_tail() {
        let x: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_relative_eq!(cvar_upper(&x, 0.1), 19.5);
        assert_relative_eq!(cvar_upper(&x, 1.0), 10.5);
        // Worst quarter of two samples: half of the larger one.
        assert_relative_eq!(cvar_upper(&[1.0, 5.0], 0.25), 5.0);
        assert_relative_eq!(cvar_upper(&[1.0, 5.0], 0.75), (5.0 + 0.5) / 1.5);
    }

    #[test]
    fn ranks_that_are_tied_are_shared() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0, 3.0]), [4.0, 1.0, 4.0, 2.0, 4.0]);
        let of = |x: &[f64], y: &[f64]| rank_correlation(x, y).unwrap();
        assert_relative_eq!(of(&[1.0, 2.0, 9.0], &[0.1, 0.2, 0.3]), 1.0);
        assert_relative_eq!(of(&[1.0, 2.0, 9.0], &[5.0, 4.0, -1.0]), -1.0);
        // Without ties: 1 - 6 sum d^2 / (n (n^2 - 1)), d = 1, 1, 1, 1, 0.
        let found = of(&[1.0, 2.0, 3.0, 4.0, 5.0], &[2.0, 1.0, 4.0, 3.0, 5.0]);
        assert_relative_eq!(found, 1.0 - 6.0 * 4.0 / 120.0);
        // With a tie it is the correlation of the ranks 1, 2.5, 2.5, 4 and 1, 3, 2, 4.
        assert_relative_eq!(
            of(&[1.0, 2.0, 2.0, 3.0], &[1.0, 5.0, 3.0, 8.0]),
            4.5 / (4.5f64 * 5.0).sqrt()
        );
        assert!(rank_correlation(&[1.0, 1.0], &[1.0, 2.0]).is_none());
        assert!(rank_correlation(&[], &[]).is_none());
    }

    #[test]
    fn spread_of_a_known_sample() {
        assert_relative_eq!(
            std_dev(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]),
            (32.0f64 / 7.0).sqrt()
        );
        assert_relative_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
    }
}

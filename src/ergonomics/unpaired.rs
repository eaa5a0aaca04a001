//! Whether two groups of people who have nothing to do with each other differ in the mean.

use super::paired::t_critical_975;
use crate::math::stats::{mean, std_dev};
use serde::Serialize;

/// Difference of two means over different people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnpairedDifference {
    /// People of `a` and of `b`.
    pub n: [usize; 2],
    /// Mean of `a` minus mean of `b`.
    pub mean: f64,
    /// Lower end of the 95 % confidence interval.
    pub low95: f64,
    /// Upper end of the 95 % confidence interval.
    pub high95: f64,
    /// Whether the interval leaves 0 out.
    pub clear: bool,
}

/// Difference of the means of `a` and `b` with its 95 % confidence interval by Welch's t: the spreads
/// may differ, and the degrees of freedom are Welch's and Satterthwaite's, rounded down. The interval is
/// infinite where a group has fewer than two values, and not a number where it has none.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::unpaired_difference;
/// let d = unpaired_difference(&[3.4, 4.0, 3.1, 3.8], &[2.9, 3.6, 2.8, 3.2]);
/// assert!((d.mean - 0.45).abs() < 1e-12 && !d.clear);
/// ```
pub fn unpaired_difference(a: &[f64], b: &[f64]) -> UnpairedDifference {
    let difference = mean(a) - mean(b);
    let share = |x: &[f64]| std_dev(x).powi(2) / x.len() as f64;
    let half = if a.is_empty() || b.is_empty() {
        f64::NAN
    } else if a.len() < 2 || b.len() < 2 {
        f64::INFINITY
    } else {
        let (va, vb) = (share(a), share(b));
        let sum = va + vb;
        let spread = va * va / (a.len() - 1) as f64 + vb * vb / (b.len() - 1) as f64;
        let degrees = if spread > 0.0 { sum * sum / spread } else { f64::INFINITY };
        t_critical_975(degrees.clamp(1.0, 1e9) as usize) * sum.sqrt()
    };
    let (low95, high95) = (difference - half, difference + half);
    let clear = low95 > 0.0 || high95 < 0.0;
    UnpairedDifference { n: [a.len(), b.len()], mean: difference, low95, high95, clear }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::paired_difference;
    use approx::assert_relative_eq;

    /// Welch's interval by hand: variances 2.5 and 10 of five values each, so that the degrees of
    /// freedom are 2.5^2 / (0.5^2 / 4 + 2^2 / 4) = 5.88, rounded down 5 with t = 2.5706.
    #[test]
    fn welchs_interval_by_hand() {
        let d = unpaired_difference(&[1.0, 2.0, 3.0, 4.0, 5.0], &[2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_relative_eq!(d.mean, -3.0);
        assert_relative_eq!(d.high95 - d.mean, 2.5706 * 2.5f64.sqrt(), epsilon = 2e-3);
        assert!(!d.clear);
    }

    #[test]
    fn pairs_that_go_together_give_the_narrower_interval() {
        let a: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.1).collect();
        let b: Vec<f64> = a.iter().map(|x| x + 0.05).collect();
        let (paired, unpaired) = (paired_difference(&a, &b), unpaired_difference(&a, &b));
        assert_relative_eq!(paired.mean, unpaired.mean, epsilon = 1e-12);
        assert!(paired.clear && !unpaired.clear);
    }

    #[test]
    fn too_few_people_are_never_clear() {
        assert!(unpaired_difference(&[1.0], &[5.0, 5.0]).high95.is_infinite());
        assert!(!unpaired_difference(&[1.0], &[5.0, 5.0]).clear);
        assert!(!unpaired_difference(&[], &[5.0]).clear);
    }
}

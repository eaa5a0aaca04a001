//! Whether one path is better than another for the same people, and that in words.

use crate::files::null_as_nan;
use crate::math::stats::{grouped_median, mean, quantile, std_dev};
use crate::math::stream::{Purpose, stream};
use rand::RngExt as _;
use serde::{Deserialize, Serialize};

/// Pairs below which a comparison carries a warning. A choice of this project: means of fewer scores
/// in steps of one are too far from the normal law for Student's interval.
pub const FEW_PAIRS: usize = 10;

/// Difference of two paths on the same rollouts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairedDifference {
    /// Number of pairs.
    pub n: usize,
    /// Mean of `a - b`, or the difference of their medians.
    #[serde(deserialize_with = "null_as_nan")]
    pub mean: f64,
    /// Lower end of the 95 % confidence interval.
    #[serde(deserialize_with = "null_as_nan")]
    pub low95: f64,
    /// Upper end of the 95 % confidence interval.
    #[serde(deserialize_with = "null_as_nan")]
    pub high95: f64,
    /// Whether the interval leaves 0 out: the paths do differ.
    pub clear: bool,
}

impl PairedDifference {
    /// One sentence: which of the two is better, by how much, and how sure that is.
    ///
    /// `quantity` is what was compared (lower is better), `a` and `b` name the two as in
    /// [`paired_difference`]. The sentence says "no clear difference" where the interval holds 0, and
    /// warns where the pairs are fewer than [`FEW_PAIRS`].
    ///
    /// # Examples
    /// ```
    /// use ergopath::ergonomics::paired_difference;
    /// let today = [3.4, 4.0, 3.1, 3.8];
    /// let planned = [2.9, 3.6, 2.8, 3.2];
    /// let sentence = paired_difference(&planned, &today).sentence("RULA", "planned", "today");
    /// assert!(sentence.starts_with("For planned, RULA is lower than for today by 0.45"));
    /// ```
    pub fn sentence(&self, quantity: &str, a: &str, b: &str) -> String {
        if self.n < 2 || !self.mean.is_finite() {
            let pairs = match self.n {
                0 => "no pair",
                1 => "one pair",
                _ => "no figure",
            };
            return format!("No comparison of {quantity} for {a} and {b}: {pairs} to judge by.");
        }
        let few = if self.n < FEW_PAIRS { "; few pairs, draw more before deciding" } else { "" };
        if !self.clear {
            return format!(
                "No clear difference in {quantity} between {a} and {b} ({:+.2}, 95 % interval {:+.2} \
                 to {:+.2}, {} pairs{few}).",
                self.mean, self.low95, self.high95, self.n
            );
        }
        let (better, worse) = if self.mean < 0.0 { (a, b) } else { (b, a) };
        let ends = [self.low95.abs(), self.high95.abs()];
        format!(
            "For {better}, {quantity} is lower than for {worse} by {:.2} (95 % interval {:.2} to {:.2}, \
             {} pairs{few}).",
            self.mean.abs(),
            ends[0].min(ends[1]),
            ends[0].max(ends[1]),
            self.n
        )
    }
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

/// Resamples behind the interval of a difference of medians.
const RESAMPLES: usize = 500;

/// Difference of the [`grouped_median`]s of `a` and `b`, with the 95 % percentile interval of a
/// bootstrap over pairs, or over people with all their pairs (pair `r` is of person `r` modulo their number).
/// Pairs as in [`paired_difference`]; the resampling is always the same, so that the same values give the same
/// interval.
pub fn paired_median_difference(a: &[f64], b: &[f64], persons: Option<usize>) -> PairedDifference {
    let count = a.len().min(b.len());
    let n = persons.map_or(count, |p| p.min(count));
    let of = |pairs: &mut dyn Iterator<Item = usize>| {
        let (a, b): (Vec<f64>, Vec<f64>) = pairs.map(|i| (a[i], b[i])).unzip();
        grouped_median(&a) - grouped_median(&b)
    };
    let mean = of(&mut (0..count));
    if n < 2 {
        let half = if n == 0 { f64::NAN } else { f64::INFINITY };
        return PairedDifference { n, mean, low95: mean - half, high95: mean + half, clear: false };
    }
    let mut rng = stream(0, Purpose::Bootstrap, 0, 0);
    let drawn: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn: Vec<usize> = (0..n).map(|_| rng.random_range(0..n)).collect();
            of(&mut drawn.into_iter().flat_map(|p| (p..count).step_by(n)))
        })
        .collect();
    let (low95, high95) = (quantile(&drawn, 0.025), quantile(&drawn, 0.975));
    PairedDifference { n, mean, low95, high95, clear: low95 > 0.0 || high95 < 0.0 }
}

/// 97.5 % quantile of Student's t: tabulated up to 4 degrees of freedom, then the Cornish-Fisher
/// series about the normal quantile (Abramowitz and Stegun 26.7.5), good to 1e-3.
pub(crate) fn t_critical_975(degrees: usize) -> f64 {
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
    fn the_interval_of_medians_holds_their_difference_as_often_as_it_says() {
        // Whole scores: 5 with a share of one half, 6 else; b the same with a share of 0.7.
        let (mut held, count) = (0, 200);
        for r in 0..count {
            let mut rng = stream(9, Purpose::Simulation, 0, r);
            let mut draw = |p: f64| -> Vec<f64> {
                (0..100).map(|_| if rng.random_bool(p) { 5.0 } else { 6.0 }).collect()
            };
            let (a, b) = (draw(0.5), draw(0.7));
            let d = paired_median_difference(&a, &b, None);
            // The medians of endless lists: 5.5, and 4.5 + 0.5 / 0.7.
            let truth = 5.5 - (4.5 + 0.5 / 0.7);
            held += usize::from((d.low95..=d.high95).contains(&truth));
        }
        assert!((180..=198).contains(&held), "{held} of {count}");
        let same = paired_median_difference(&[5.0, 6.0, 5.0], &[5.0, 6.0, 5.0], None);
        assert!(!same.clear && same.mean == 0.0);
        assert!(paired_median_difference(&[], &[], None).mean.is_nan());
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

    #[test]
    fn sentences_name_the_better_one_and_how_sure_it_is() {
        let low = [2.0, 2.1, 2.2, 2.0, 2.1, 2.2, 2.0, 2.1, 2.2, 2.0];
        let high = low.map(|v| v + 0.5);
        let clear =
            "For `a`, RULA is lower than for `b` by 0.50 (95 % interval 0.50 to 0.50, 10 pairs).";
        assert_eq!(paired_difference(&low, &high).sentence("RULA", "`a`", "`b`"), clear);
        assert_eq!(paired_difference(&high, &low).sentence("RULA", "`b`", "`a`"), clear);
        let same = paired_difference(&low, &low).sentence("RULA", "`a`", "`b`");
        assert!(
            same.starts_with("No clear difference in RULA between `a` and `b` (+0.00"),
            "{same}"
        );
        let few = paired_difference(&low[..3], &high[..3]).sentence("REBA", "a", "b");
        assert!(few.contains("3 pairs; few pairs, draw more before deciding"), "{few}");
        for n in [0, 1] {
            let none = paired_difference(&low[..n], &high[..n]).sentence("REBA", "a", "b");
            assert!(none.starts_with("No comparison of REBA"), "{none}");
        }
    }
}

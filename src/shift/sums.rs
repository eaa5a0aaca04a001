//! Sums over tasks whose people are the same, and over tasks whose people have nothing to do with each other.
//!
//! ```text
//! group      tasks with the same people: unit i of the sum is the sum of unit i over the tasks
//! mean       sum of the groups' means; variance of the mean: sum of var(g) / n(g); Welch's degrees of freedom
//! quantiles  of a + b for every a of one group and every b of the next (their convolution)
//! ```

use super::result::Dose;
use crate::ergonomics::t_critical_975;
use crate::math::stats::{mean, quantile_of_sorted, std_dev};

/// Sums above which a distribution is thinned to so many of its quantiles.
const MOST: usize = 20_000;
const KEPT: usize = 400;

/// The sum of independent groups, each a list of equally likely values. A group of one value has no known
/// spread and adds none.
pub(super) fn dose(groups: &[Vec<f64>]) -> Dose {
    let expected: f64 = groups.iter().map(|g| mean(g)).sum();
    let share = |g: &Vec<f64>| std_dev(g).powi(2) / g.len() as f64;
    let spread: Vec<(f64, usize)> =
        groups.iter().filter(|g| g.len() > 1).map(|g| (share(g), g.len())).collect();
    let variance: f64 = spread.iter().map(|(v, _)| v).sum();
    let below: f64 = spread.iter().map(|(v, n)| v * v / (*n as f64 - 1.0)).sum();
    let degrees = if below > 0.0 { variance * variance / below } else { 1e9 };
    let half = t_critical_975(degrees.clamp(1.0, 1e9) as usize) * variance.sqrt();
    let known = !spread.is_empty();
    let all = groups.iter().fold(vec![0.0], |sum, group| convolved(&sum, group));
    Dose {
        mean_min: expected,
        interval95_min: known.then(|| [(expected - half).max(0.0), expected + half]),
        band90_min: known.then(|| [quantile_of_sorted(&all, 0.05), quantile_of_sorted(&all, 0.95)]),
    }
}

/// Every sum of one of each, sorted, thinned where there are too many.
fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sums: Vec<f64> = a.iter().flat_map(|x| b.iter().map(move |y| x + y)).collect();
    sums.sort_by(f64::total_cmp);
    if sums.len() <= MOST {
        return sums;
    }
    let at = |k: usize| quantile_of_sorted(&sums, (k as f64 + 0.5) / KEPT as f64);
    (0..KEPT).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::{paired_difference, unpaired_difference};
    use approx::assert_relative_eq;

    #[test]
    fn one_group_has_the_interval_of_its_mean() {
        let group = vec![10.0, 12.0, 15.0, 11.0, 30.0];
        let d = dose(std::slice::from_ref(&group));
        let zeros = vec![0.0; group.len()];
        let paired = paired_difference(&group, &zeros);
        let [low, high] = d.interval95_min.unwrap();
        assert_relative_eq!(d.mean_min, paired.mean);
        assert_relative_eq!(high, paired.high95, epsilon = 1e-9);
        assert_relative_eq!(low, paired.low95.max(0.0), epsilon = 1e-9);
        let [from, to] = d.band90_min.unwrap();
        assert_relative_eq!(from, 10.2, epsilon = 1e-12);
        assert_relative_eq!(to, 27.0, epsilon = 1e-12);
    }

    /// The sum of two independent groups is one minus the other's negative: Welch's interval.
    #[test]
    fn two_groups_have_welchs_interval() {
        let (a, b) = (vec![31.0, 34.0, 39.0, 30.0], vec![2.0, 9.0, 4.0, 7.0, 5.0, 6.0]);
        let minus: Vec<f64> = b.iter().map(|v| -v).collect();
        let welch = unpaired_difference(&a, &minus);
        let d = dose(&[a, b]);
        let [low, high] = d.interval95_min.unwrap();
        assert_relative_eq!(d.mean_min, welch.mean, epsilon = 1e-12);
        assert_relative_eq!(low, welch.low95, epsilon = 1e-9);
        assert_relative_eq!(high, welch.high95, epsilon = 1e-9);
    }

    #[test]
    fn people_who_are_the_same_spread_more_than_people_who_are_not() {
        let one: Vec<f64> = (0..32).map(f64::from).collect();
        let both: Vec<f64> = one.iter().map(|v| 2.0 * v).collect();
        let width = |d: &Dose| d.band90_min.map_or(0.0, |[low, high]| high - low);
        let (same, other) = (dose(&[both]), dose(&[one.clone(), one]));
        assert_relative_eq!(same.mean_min, other.mean_min);
        assert!(width(&same) > 1.2 * width(&other), "{same:?} {other:?}");
    }

    /// Thinning keeps the quantiles: of four uniform groups those of a plain sum over a grid.
    #[test]
    fn many_groups_are_thinned_without_harm() {
        let group: Vec<f64> = (0..96).map(|k| (f64::from(k) + 0.5) / 96.0).collect();
        let groups = vec![group; 4];
        let d = dose(&groups);
        let [low, high] = d.band90_min.unwrap();
        // Irwin-Hall of four: the 5 % quantile solves x^4 / 24 - 4 (x - 1)^4 / 24 = 0.05.
        let mut x: f64 = 1.0;
        for _ in 0..50 {
            let f = (x.powi(4) - 4.0 * (x - 1.0).max(0.0).powi(4)) / 24.0 - 0.05;
            let slope = (4.0 * x.powi(3) - 16.0 * (x - 1.0).max(0.0).powi(3)) / 24.0;
            x -= f / slope;
        }
        assert!((low - x).abs() < 0.005 && (high - (4.0 - x)).abs() < 0.005, "{low} {high} {x}");
        assert_relative_eq!(d.mean_min, 2.0, epsilon = 1e-12);
    }

    #[test]
    fn what_was_measured_once_has_no_spread() {
        let d = dose(&[vec![7.0], vec![3.0]]);
        assert_eq!((d.mean_min, d.interval95_min, d.band90_min), (10.0, None, None));
        let with = dose(&[vec![7.0], vec![1.0, 2.0, 3.0]]);
        assert_relative_eq!(with.mean_min, 9.0);
        assert!(with.interval95_min.is_some());
        assert_eq!(dose(&[]).mean_min, 0.0);
    }
}

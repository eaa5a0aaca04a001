//! Scores of people who repeat: how far people differ, and how far the repetitions of one person do.
//!
//! ```text
//! S_pr = mu + a_p + e_pr       person p = r mod P of repetition r
//! sd of a_p, sd of e_pr        method of moments: mean squares between and within people
//! ```
//! Repetitions of one person are alike in part, so that intervals rest on the means of people.

use crate::math::stats::{mean, std_dev};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// How people differ in a score, where the repetitions are made by people in turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PeopleSpread {
    /// Number of people; repetition `r` is of person `r` modulo it.
    pub persons: usize,
    /// Mean over time and repetitions of each person.
    pub by_person: Vec<f64>,
    /// Standard deviation of people's own expected scores.
    pub between_sd: f64,
    /// Upper end of its 90 % confidence interval: so few people may differ by more than the estimate.
    pub between_sd_high: f64,
    /// Standard deviation of the repetitions of one person.
    pub within_sd: f64,
    /// Share of people who are at action level 3 or above for half a second in at least half of their
    /// repetitions.
    pub at_high: f64,
}

/// The spread between people in two parts, standard deviations of their own expected scores.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SizeSplit {
    /// What goes with the size of their bodies.
    pub size_sd: f64,
    /// What remains: their ways of moving.
    pub way_sd: f64,
}

impl PeopleSpread {
    /// From the figure of each repetition and 1 where it lasts at a high level; none where no person repeats.
    pub fn of(values: &[f64], lasts_high: &[f64], persons: Option<usize>) -> Option<Self> {
        let persons = persons.filter(|p| (2..values.len()).contains(p))?;
        let by_person = by_person(values, Some(persons));
        let all = mean(values);
        let (mut between, mut within, mut squares) = (0.0, 0.0, 0.0);
        for (p, own) in by_person.iter().enumerate() {
            let count = values.iter().skip(p).step_by(persons).count() as f64;
            squares += count * count;
            between += count * (own - all).powi(2);
            within +=
                values.iter().skip(p).step_by(persons).map(|v| (v - own).powi(2)).sum::<f64>();
        }
        let (n, p) = (values.len() as f64, persons as f64);
        let within = within / (n - p);
        let repeated = (n - squares / n) / (p - 1.0);
        let sd = |between: f64| ((between - within) / repeated).max(0.0).sqrt();
        let between = between / (p - 1.0);
        // The mean square over its expectation is chi-squared over its degrees of freedom.
        let high = between / chi_squared_05(p - 1.0);
        let often = by_person_of(lasts_high, persons).into_iter().filter(|share| *share >= 0.5);
        Some(Self {
            persons,
            between_sd: sd(between),
            between_sd_high: sd(high),
            within_sd: within.sqrt(),
            at_high: often.count() as f64 / p,
            by_person,
        })
    }

    /// What of the spread between people goes with the columns of `sizes` (a value for each person in each), in
    /// standard deviations; none where the columns do not tell all people apart from each other.
    ///
    /// ```text
    /// m_p = b0 + b' x_p + g_p + e_p    mean of person p, sizes x_p, way of moving g_p, repetitions e_p
    /// var of size: var(m) - s^2        s^2: residual mean square, so that chance explains nothing on average
    /// var of way:  s^2 - within^2 / repetitions of a person
    /// ```
    pub fn split(&self, sizes: &[Vec<f64>], repetitions: usize) -> Option<SizeSplit> {
        let (n, k) = (self.persons, sizes.len());
        if n <= k + 2 || sizes.iter().any(|x| x.len() != n) {
            return None;
        }
        let column = |j: usize| -> Vec<f64> {
            let Some(x) = j.checked_sub(1).and_then(|j| sizes.get(j)) else { return vec![1.0; n] };
            let (middle, spread) = (mean(x), std_dev(x));
            x.iter().map(|v| (v - middle) / spread.max(1e-12)).collect()
        };
        let columns: Vec<DVector<f64>> = (0..=k).map(|j| column(j).into()).collect();
        let x = DMatrix::from_columns(&columns);
        let m = DVector::from_column_slice(&self.by_person);
        let fitted = &x * x.clone().svd(true, true).solve(&m, 1e-9).ok()?;
        let left = (&m - fitted).norm_squared() / (n - k - 1) as f64;
        let all = std_dev(&self.by_person).powi(2);
        let chance = self.within_sd.powi(2) * n as f64 / repetitions.max(n) as f64;
        // Together they are no more than people differ, which chance may leave at nothing.
        let most = self.between_sd.powi(2);
        let size = (all - left).min(most).max(0.0);
        let way = (left - chance).min(most - size).max(0.0);
        Some(SizeSplit { size_sd: size.sqrt(), way_sd: way.sqrt() })
    }

    /// Who has the highest mean.
    pub fn worst(&self) -> usize {
        let all = 0..self.by_person.len();
        all.max_by(|a, b| self.by_person[*a].total_cmp(&self.by_person[*b])).unwrap_or(0)
    }
}

/// 5 % quantile of chi-squared over its degrees of freedom (Wilson and Hilferty 1931, within 1 % from 10 on).
fn chi_squared_05(degrees: f64) -> f64 {
    let c = 2.0 / (9.0 * degrees);
    (1.0 - c - 1.644_853_6 * c.sqrt()).max(1e-3).powi(3)
}

/// Means over the repetitions of each person; the values themselves where nobody repeats.
pub fn by_person(values: &[f64], persons: Option<usize>) -> Vec<f64> {
    match persons {
        Some(persons) if (1..values.len()).contains(&persons) => by_person_of(values, persons),
        _ => values.to_vec(),
    }
}

fn by_person_of(values: &[f64], persons: usize) -> Vec<f64> {
    let own = |p: usize| values.iter().skip(p).step_by(persons).copied().collect::<Vec<f64>>();
    (0..persons).map(|p| mean(&own(p))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn people_and_their_repetitions_are_told_apart() {
        let persons = 400;
        let mut rng = stream(3, Purpose::Simulation, 0, 0);
        let own = normals(&mut rng, persons);
        // 4 repetitions of each and one more of the first hundred.
        let values: Vec<f64> = (0..1700)
            .map(|r| 4.0 + 0.5 * own[r % persons] + 0.8 * normals(&mut rng, 1)[0])
            .collect();
        let spread = PeopleSpread::of(&values, &vec![0.0; 1700], Some(persons)).unwrap();
        assert!((spread.between_sd - 0.5).abs() < 0.05, "{}", spread.between_sd);
        assert!((spread.within_sd - 0.8).abs() < 0.03, "{}", spread.within_sd);
        assert!((spread.between_sd..0.6).contains(&spread.between_sd_high));
        // 5 % of chi-squared with 31 degrees of freedom: 19.28.
        assert!((31.0 * chi_squared_05(31.0) - 19.28).abs() < 0.05);
        let worst = spread.worst();
        assert!(spread.by_person.iter().all(|s| *s <= spread.by_person[worst]));
    }

    #[test]
    fn figures_of_a_small_case() {
        // Two people, three repetitions each: 1, 3, 5 and 2, 2, 8.
        let values = [1.0, 2.0, 3.0, 2.0, 5.0, 8.0];
        assert_eq!(by_person(&values, Some(2)), [3.0, 4.0]);
        assert_eq!(by_person(&values, None), values);
        assert_eq!(by_person(&values, Some(9)), values);
        let lasts = [1.0, 0.0, 1.0, 0.0, 0.0, 1.0];
        let spread = PeopleSpread::of(&values, &lasts, Some(2)).unwrap();
        // Within: (8 + 24) / 4 = 8. Between: 3 (0.25 + 0.25) = 1.5 is less than that.
        assert!((spread.within_sd - 8.0f64.sqrt()).abs() < 1e-12);
        assert_eq!((spread.between_sd, spread.at_high, spread.worst()), (0.0, 0.5, 1));
        assert!(PeopleSpread::of(&values, &lasts, None).is_none());
        assert!(PeopleSpread::of(&values, &lasts, Some(6)).is_none());
    }

    #[test]
    fn size_and_way_of_moving_are_told_apart() {
        let persons = 600;
        let mut rng = stream(4, Purpose::Simulation, 0, 0);
        let [stature, mass, way] = [0, 1, 2].map(|_| normals(&mut rng, persons));
        // Sizes in units and with means of their own; four repetitions each.
        let sizes = [
            stature.iter().map(|v| 1.7 + 0.07 * v).collect::<Vec<f64>>(),
            mass.iter().map(|v| 75.0 + 12.0 * v).collect(),
        ];
        let values: Vec<f64> = (0..4 * persons)
            .map(|r| {
                let p = r % persons;
                let size = 0.4 * stature[p] + 0.3 * mass[p];
                4.0 + size + 0.2 * way[p] + 0.6 * normals(&mut rng, 1)[0]
            })
            .collect();
        let spread = PeopleSpread::of(&values, &vec![0.0; values.len()], Some(persons)).unwrap();
        let split = spread.split(&sizes, values.len()).unwrap();
        assert!((split.size_sd - 0.5).abs() < 0.05, "{split:?}");
        assert!((split.way_sd - 0.2).abs() < 0.05, "{split:?}");
        // The parts make the whole.
        let whole = split.size_sd.hypot(split.way_sd);
        assert!((whole - spread.between_sd).abs() < 0.01, "{whole} {}", spread.between_sd);
        // Sizes that have nothing to do with it explain nothing, and equal ones are no columns.
        let other = spread.split(&[normals(&mut rng, persons)], values.len()).unwrap();
        assert!(
            other.size_sd < 0.1 && (other.way_sd - spread.between_sd).abs() < 0.02,
            "{other:?}"
        );
        assert!(spread.split(&[vec![1.7; persons]], values.len()).unwrap().size_sd < 1e-6);
        assert_eq!(spread.split(&[vec![1.7; 3]], values.len()), None);
    }
}

//! Scores of people who repeat: how far people differ, and how far the repetitions of one person do.
//!
//! ```text
//! S_pr = mu + a_p + e_pr       person p = r mod P of repetition r
//! sd of a_p, sd of e_pr        method of moments: mean squares between and within people
//! ```
//! Repetitions of one person are alike in part, so that intervals rest on the means of people.

use crate::math::stats::mean;
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
}

//! How people differ from one another, and how a repetition differs from the next one of the same person.
//!
//! ```text
//! q = m(x) + L(x) (p + b)      L L^T: covariance about the usual posture m(x), x the place of the hand
//! p = sqrt(s) t                a person's own, t ~ Student's t with P - 1 degrees of freedom
//! b ~ N(0, (1 - s) I)          of one repetition
//! ```
//! s is the share of the variance that movements of one person have in common. How people differ is known from
//! P people only: with the variance of a Gaussian estimated from P values the next one is Student's, so that
//! few people widen what is said of others.

use crate::math::stream::{Purpose, normals, stream};
use nalgebra::DVector;
use rand_distr::{ChiSquared, Distribution};
use serde::{Deserialize, Serialize};

/// Of a model of several people: what is a person's own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// s: share of the variance about the usual posture that is common to the movements of a person, in [0, 1).
    pub own_share: f64,
    /// P: how many people it was learned from.
    pub people: usize,
}

impl Population {
    /// p of a person (n): the same for all of their repetitions in a block.
    pub fn person(&self, (seed, block): (u64, u32), person: usize, n: usize) -> DVector<f64> {
        let mut rng = stream(seed, Purpose::Person, block, person as u32);
        let z = DVector::from_vec(normals(&mut rng, n));
        let degrees = self.people.saturating_sub(1).max(1) as f64;
        let square: f64 = ChiSquared::new(degrees).map_or(degrees, |chi| chi.sample(&mut rng));
        z * (self.own_share * degrees / square).sqrt()
    }

    /// By how much what a repetition has of its own is smaller than a standard deviation of all.
    pub fn of_repetition(&self) -> f64 {
        (1.0 - self.own_share).sqrt()
    }

    /// Share of the variance that stays unknown of a person of whom some movements were seen: the rest of p, and b.
    pub fn unknown_after(&self, movements: usize) -> f64 {
        let (s, n) = (self.own_share, movements as f64);
        (1.0 - s) * (1.0 + s / (n * s + 1.0 - s))
    }

    /// Why a model with it cannot be used; none where it can.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let is_fine = (0.0..1.0).contains(&self.own_share) && self.people > 1;
        (!is_fine).then_some("the share of a person's own must be in [0, 1), of two people or more")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::{mean, std_dev};

    #[test]
    fn repetitions_of_a_person_have_their_share_in_common() {
        // Many people: Student's t is then a Gaussian.
        let population = Population { own_share: 0.3, people: 4001 };
        let all: Vec<[f64; 2]> = (0..6000u32)
            .map(|p| {
                let own = population.person((1, 2), p as usize, 1)[0];
                let of = |k: u32| {
                    let mut rng = stream(1, Purpose::Posture, 2, 2 * p + k);
                    own + population.of_repetition() * normals(&mut rng, 1)[0]
                };
                [of(0), of(1)]
            })
            .collect();
        let product = mean(&all.iter().map(|[a, b]| a * b).collect::<Vec<f64>>());
        let sd = std_dev(&all.iter().map(|[a, _]| *a).collect::<Vec<f64>>());
        assert!((product - 0.3).abs() < 0.04, "{product}");
        assert!((sd - 1.0).abs() < 0.03, "{sd}");
    }

    #[test]
    fn few_people_widen_what_is_said_of_others() {
        let sizes = |people: usize| -> Vec<f64> {
            let population = Population { own_share: 0.5, people };
            (0..40_000).map(|p| population.person((3, 0), p, 1)[0].abs()).collect()
        };
        // 90 % of Student's t with four degrees of freedom is within 2.132, of a Gaussian within 1.645.
        for (people, within) in [(5, 2.132), (4001, 1.645)] {
            let mut sizes = sizes(people);
            sizes.sort_by(f64::total_cmp);
            let found = sizes[36_000] / 0.5f64.sqrt();
            assert!((found - within).abs() < 0.05, "{people}: {found}");
        }
    }
}

//! How people differ from one another, and how a repetition differs from the next one of the same person.
//!
//! ```text
//! q = m(x) + L(x) (p + b)      L L^T: covariance about the usual posture m(x), x the place of the hand
//! p ~ N(0, s (P + 1) / (P - 1) I)    a person's own
//! b ~ N(0, (1 - s) I)                of one repetition
//! ```
//! The factor is what P people leave unknown of how people differ: of their mean, and of their variance.
//!
//! A person has a habit among the modes too: repetition r of person p is of the mode at the level
//! ```text
//! u = Phi(sqrt(s) z_p + sqrt(1 - s) e_r),      z_p, e_r ~ N(0, 1)
//! ```
//! with the same s, as the recorded people changed modes when they were told to, so that nothing tells how often
//! they would have. s is the share of the variance that movements of one person have in common. The spread of all together stays
//! what left-out people had. Student's t in place of the Gaussian of p, as the variance between few people is
//! itself uncertain, held 89 instead of 88 % of left-out people (73 instead of 70 % of the worst), but predicted
//! them worse (energy score 17.7 instead of 17.5 deg), and in the shipped low bin more starts were rarer than one in
//! a hundred recorded postures (25 to 28 % instead of 15 to 19 %).

use crate::math::stream::{Purpose, normals, stream};
use nalgebra::DVector;
use rand::RngExt;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use std::ops::Range;

/// Of a model of several people: what is a person's own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// s: share of the variance about the usual posture that is common to the movements of a person, in [0, 1).
    pub own_share: f64,
    /// P: how many people it was learned from.
    pub people: usize,
    /// How many times as far as those of a Gaussian the farthest hundredth of postures of people who were left out
    /// lie from what the others say, at least 1: few people tell a covariance too narrow.
    #[serde(default = "one")]
    pub tail: f64,
}

fn one() -> f64 {
    1.0
}

impl Population {
    /// p of a person (n): the same for all of their repetitions in a block.
    pub fn person(&self, (seed, block): (u64, u32), person: usize, n: usize) -> DVector<f64> {
        let mut rng = stream(seed, Purpose::Person, block, person as u32);
        DVector::from_vec(normals(&mut rng, n)) * (self.own_share * self.widened()).sqrt()
    }

    /// (P + 1) / (P - 1).
    fn widened(&self) -> f64 {
        (self.people as f64 + 1.0) / (self.people as f64 - 1.0)
    }

    /// By how much what a repetition has of its own is smaller than a standard deviation of all.
    pub fn of_repetition(&self) -> f64 {
        (1.0 - self.own_share).sqrt()
    }

    /// u of repetitions with these numbers, of `persons` who repeat in turn: uniform on [0, 1), more alike for
    /// the same person. In every turn z and e are spread evenly over the people, in an order of its own.
    pub fn levels(&self, block: (u64, u32), persons: usize, numbers: Range<usize>) -> Vec<f64> {
        let own = even_normals(block, HABITS, persons);
        let mut turn = (HABITS, Vec::new());
        let of = |r: usize| {
            let of_turn = (r / persons) as u32;
            if turn.0 != of_turn {
                turn = (of_turn, even_normals(block, of_turn, persons));
            }
            let (z, e) = (own[r % persons], turn.1[r % persons]);
            Normal::standard().cdf(self.own_share.sqrt() * z + self.of_repetition() * e)
        };
        numbers.map(of).collect()
    }

    /// Share of the variance that stays unknown of a person of whom some movements were seen: the rest of p, and b.
    pub fn unknown_after(&self, movements: usize) -> f64 {
        let (s, n) = (self.own_share, movements as f64);
        (1.0 - s) * (1.0 + s / (n * s + 1.0 - s))
    }

    /// Why a model with it cannot be used; none where it can.
    pub(super) fn fault(&self) -> Option<&'static str> {
        if !(1.0..=1e3).contains(&self.tail) {
            return Some("the tail of left-out people must be from 1 to 1000");
        }
        let is_fine = (0.0..1.0).contains(&self.own_share) && self.people > 1;
        (!is_fine).then_some("the share of a person's own must be in [0, 1), of two people or more")
    }
}

/// The number of the turn that stands for what people keep.
const HABITS: u32 = u32::MAX;

/// Standard normal values of `count` people: one from each of as many equally likely ranges.
fn even_normals((seed, block): (u64, u32), turn: u32, count: usize) -> Vec<f64> {
    let mut rng = stream(seed, Purpose::Habit, block, turn);
    let mut ranges: Vec<f64> = (0..count).map(|i| i as f64).collect();
    ranges.shuffle(&mut rng);
    let mut at = |range: f64| {
        let level = (range + rng.random::<f64>()) / count as f64;
        Normal::standard().inverse_cdf(level.clamp(f64::EPSILON, 1.0 - f64::EPSILON))
    };
    ranges.into_iter().map(&mut at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::{mean, std_dev};

    #[test]
    fn repetitions_of_a_person_have_their_share_in_common() {
        let population = Population { own_share: 0.3, people: 5, tail: 1.0 };
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
        // Five people: half as much again between them.
        assert!((product - 0.45).abs() < 0.05, "{product}");
        assert!((sd - 1.15f64.sqrt()).abs() < 0.03, "{sd}");
    }

    #[test]
    fn habits_are_spread_evenly_over_people_who_differ_by_their_share() {
        let (persons, turns) = (32, 4);
        // Of an event with probability 1/2 on levels with correlation s, both of two happen with 1/4 + asin(s) / 2 pi.
        let both = |own_share: f64| {
            let population = Population { own_share, people: 5, tail: 1.0 };
            let count = |seed: u64| {
                let all = population.levels((seed, 3), persons, 0..persons * turns);
                assert_eq!(population.levels((seed, 3), persons, 40..99), all[40..99]);
                let low = |k: usize, p: usize| all[k * persons + p] < 0.5;
                let low = &low;
                let share = all.iter().filter(|u| **u < 0.5).count() as f64 / all.len() as f64;
                let pairs = (0..turns).flat_map(|a| {
                    (0..a).flat_map(move |b| (0..persons).filter(move |p| low(a, *p) && low(b, *p)))
                });
                (share, pairs.count() as f64 / (persons * turns * (turns - 1) / 2) as f64)
            };
            let all: Vec<(f64, f64)> = (0..200).map(count).collect();
            let shares: Vec<f64> = all.iter().map(|a| a.0).collect();
            assert!((mean(&shares) - 0.5).abs() < 0.005 && std_dev(&shares) < 0.03, "{shares:?}");
            mean(&all.iter().map(|a| a.1).collect::<Vec<f64>>())
        };
        for s in [0.0, 0.3, 0.8] {
            let expected = 0.25 + f64::asin(s) / std::f64::consts::TAU;
            assert!((both(s) - expected).abs() < 0.01, "{s}: {} {expected}", both(s));
        }
    }
}

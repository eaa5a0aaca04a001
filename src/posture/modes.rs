//! Modes: different ways in which people do the same, such as to stoop and to squat. Each is a law of its own.
//!
//! How often each occurs goes by where the hand is lowest, seen from the feet (horizontal place x, over
//! stature); far from every recorded place it is as often as everywhere. Where the hand stays higher than in
//! the movements that tell modes apart there is one law of all.
//!
//! ```text
//! share_k(x) = (a p_k + sum_i K(x - x_i) r_ik) / (a + sum_i K(x - x_i))       K(d) = exp(-|d|^2 / 2 w^2)
//! ```
//! `r_ik` says whether the recorded low movement i was of mode k, `p_k` is its mean, and `a` counts as so many
//! movements. With a Dirichlet prior the denominator is what a share rests on, and its quantiles are those of
//! a beta distribution. The recorded people chose a mode by task and habit; the formula only reads off where.

use super::law::PostureLaw;
use super::model::PostureDistribution;
use crate::math::{Pose, Vec3};
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

/// Movements that the shares of all places together count as.
const PRIOR: f64 = 4.0;
/// Width of the kernel over stature: a tenth of a leg.
const WIDTH: f64 = 0.05;
/// Share of the samples that count as lowest.
const LOWEST: f64 = 0.1;

/// Where a recorded low movement was, and of which modes it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowMovement {
    /// Place of the hand where it is lowest (rest frame: ahead, up, to the right), over stature.
    pub place: [f64; 3],
    /// Probability of each mode; sums to 1.
    pub memberships: Vec<f64>,
}

/// One way of doing it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Mean inclination of the trunk where the hand is lowest, deg.
    pub trunk_deg: f64,
    /// Mean flexion of the knees there, deg.
    pub knees_deg: f64,
    /// How people of this mode move.
    pub law: PostureLaw,
    /// Their postures.
    pub postures: PostureDistribution,
}

/// All modes, and when each is used.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Modes {
    /// At least two.
    pub all: Vec<Mode>,
    /// The recorded movements that tell them apart.
    pub low: Vec<LowMovement>,
    /// How many people these are of.
    pub people: usize,
    /// Height of the hand (rest frame, over stature) below which they are told apart.
    pub below: f64,
}

/// How often each mode occurs at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixture {
    /// Share of each mode; sums to 1.
    pub shares: Vec<f64>,
    /// How many recorded movements count there, the prior left out.
    pub near: f64,
}

impl Modes {
    /// How often each mode occurs where the hand is lowest at a place (see [`low_place`]); none where it
    /// stays too high for them to be told apart.
    pub fn at(&self, place: [f64; 3]) -> Option<Mixture> {
        (place[1] < self.below).then(|| mixture(&self.low, self.all.len(), place))
    }
}

/// The same of movements; `count` modes.
fn mixture(low: &[LowMovement], count: usize, place: [f64; 3]) -> Mixture {
    let everywhere =
        |k: usize| low.iter().map(|m| m.memberships[k]).sum::<f64>() / low.len().max(1) as f64;
    let kernel = |m: &LowMovement| {
        let away = (m.place[0] - place[0]).hypot(m.place[2] - place[2]);
        (-0.5 * (away / WIDTH).powi(2)).exp()
    };
    let near: f64 = low.iter().map(kernel).sum();
    let share = |k: usize| {
        let here: f64 = low.iter().map(|m| kernel(m) * m.memberships[k]).sum();
        (PRIOR * everywhere(k) + here) / (PRIOR + near)
    };
    Mixture { shares: (0..count).map(share).collect(), near }
}

impl Mixture {
    /// The mode at a level between 0 and 1: levels spread evenly give each mode its share.
    pub fn mode_at(&self, level: f64) -> usize {
        let mut sum = 0.0;
        let ends = self.shares.iter().map(|s| {
            sum += s;
            sum
        });
        ends.take(self.shares.len() - 1).filter(|end| level >= *end).count()
    }

    /// Quantile of a mode's share, by what is known of it.
    pub fn quantile(&self, mode: usize, p: f64) -> f64 {
        let total = PRIOR + self.near;
        let own = total * self.shares[mode];
        match Beta::new(own, total - own) {
            Ok(beta) => beta.inverse_cdf(p),
            // Nobody or everybody.
            Err(_) => self.shares[mode],
        }
    }
}

/// Place over stature (rest frame: ahead, up, to the right) where a hand is lowest: mean over the lowest tenth
/// of the samples.
pub fn low_place<'a>(hands: impl IntoIterator<Item = &'a Pose>, stature_m: f64) -> [f64; 3] {
    let mut places: Vec<Vec3> = hands.into_iter().map(|h| h.translation.vector).collect();
    places.sort_by(|a, b| a.y.total_cmp(&b.y));
    let count = ((LOWEST * places.len() as f64).ceil() as usize).max(1);
    let sum: Vec3 = places.iter().take(count).sum();
    (sum / (count as f64 * stature_m)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn low(x: f64, z: f64, first: f64) -> LowMovement {
        LowMovement { place: [x, -0.4, z], memberships: vec![first, 1.0 - first] }
    }

    #[test]
    fn shares_are_those_of_the_movements_near_and_far_away_of_all() {
        let all: Vec<LowMovement> =
            (0..8).map(|_| low(0.3, 0.0, 1.0)).chain((0..4).map(|_| low(0.3, 0.4, 0.0))).collect();
        let here = mixture(&all, 2, [0.3, -0.1, 0.0]);
        // Eight of the first mode, and four that are two thirds of it.
        assert!((here.near - 8.0).abs() < 1e-6);
        assert!((here.shares[0] - (8.0 + 8.0 / 3.0) / 12.0).abs() < 1e-9);
        assert!((here.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let there = mixture(&all, 2, [0.3, -0.4, 0.4]);
        assert!((there.shares[1] - (4.0 + 4.0 / 3.0) / 8.0).abs() < 1e-6);
        let away = mixture(&all, 2, [3.0, -0.4, 0.0]);
        assert!((away.shares[0] - 2.0 / 3.0).abs() < 1e-12 && away.near < 1e-12);
        // Less is known there.
        let width = |m: &Mixture| m.quantile(0, 0.95) - m.quantile(0, 0.05);
        assert!(width(&away) > 1.5 * width(&here), "{} {}", width(&away), width(&here));
        // Of a beta distribution with both parameters 2 the 5 % quantile is 0.1354 (tables).
        let even = Mixture { shares: vec![0.5, 0.5], near: 0.0 };
        assert!((even.quantile(0, 0.05) - 0.135_35).abs() < 1e-4, "{}", even.quantile(0, 0.05));
    }

    #[test]
    fn even_levels_give_each_mode_its_share() {
        let mixture = Mixture { shares: vec![0.3, 0.0, 0.7], near: 0.0 };
        let modes: Vec<usize> =
            (0..10).map(|i| mixture.mode_at(0.05 + 0.1 * f64::from(i))).collect();
        assert_eq!(modes, [0, 0, 0, 2, 2, 2, 2, 2, 2, 2]);
        assert_eq!((mixture.mode_at(0.0), mixture.mode_at(1.0)), (0, 2));
    }

    #[test]
    fn the_lowest_tenth_tells_where_a_hand_is_low() {
        let hands: Vec<Pose> =
            (0..20).map(|i| Pose::translation(f64::from(i), f64::from(i) * 0.1, 1.0)).collect();
        let place = low_place(&hands, 2.0);
        assert!((place[0] - 0.25).abs() < 1e-12 && (place[1] - 0.025).abs() < 1e-12);
        assert_eq!(place[2], 0.5);
    }
}

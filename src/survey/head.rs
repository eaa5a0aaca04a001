//! How the head is held: a distribution given trunk and hand, or one of two rules.
//!
//! Learned from five people (HDM05: deposits on the floor and grabs overhead, actors without a visual
//! task; each person and task counts alike; angles from each person's upright neutral, deg):
//!
//! ```text
//! flexion =  2 + 0.11 aim_flexion - 0.22 trunk inclination     sd 13.5
//! turn    = 12 + 0.67 aim_turn                                  sd 13.2     bend = 3    sd 7
//! ```
//! `aim` is the rotation from straight ahead of the thorax to the hand, 90 deg at most. People do not face
//! the hand, and bent to the floor they extend the neck. The standard deviations are those of people who
//! were left out, between and within people; a repetition keeps its own departure.
//!
//! Their squats are left out: no hand leads there, and eyes stay on the horizon while the trunk bends. A
//! law of all three tasks extends the neck at the height of a bench, where these people bend it by 6.5
//! deg; this one says 7.1.

use super::NeckRule;
use crate::human::{Head, Side};
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Rotation, Vec3};
use nalgebra::UnitQuaternion;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, PI};

const DEG: f64 = PI / 180.0;
/// Constant, by aim, by inclination of the trunk.
const FLEXION: [f64; 3] = [2.0 * DEG, 0.11, -0.22];
/// Constant and by aim, to the left, of people who used the right hand.
const TURN: [f64; 2] = [12.0 * DEG, 0.67];
const BEND: f64 = 3.0 * DEG;
/// Standard deviations of flexion, turn and bend: between people and within.
const SPREAD: [f64; 3] = [13.5 * DEG, 13.2 * DEG, 7.0 * DEG];
/// Shares of the variance that are a person's own: 5.4 of 12.9 deg and 3.6 of 13.1 deg; of the bend assumed.
const OWN_SHARE: [f64; 3] = [0.18, 0.08, 0.1];
/// How far eyes turn in the head before it follows (assumed).
const EYES: f64 = 20.0 * DEG;
/// Range of the neck to which a head is held: flexion, extension, twist, bend.
const RANGE: [f64; 4] = [50.0 * DEG, 60.0 * DEG, 80.0 * DEG, 45.0 * DEG];

/// Offset of the block number for the heads, so that they draw from other streams than the postures.
const HEAD_BLOCK: u32 = 1 << 18;

/// How one repetition holds its head: departures from the mean in standard deviations, and the hand that
/// works.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadDraw {
    departures: [f64; 3],
    /// 1 for the right hand, -1 for the left one, 0 for both.
    side: f64,
}

impl HeadDraw {
    /// The mean of people who work with a hand; both for none.
    pub fn mean(side: Option<Side>) -> Self {
        let side = match side {
            Some(Side::Right) => 1.0,
            Some(Side::Left) => -1.0,
            None => 0.0,
        };
        Self { departures: [0.0; 3], side }
    }

    /// That of repetition `r` of a block: the same on every path. Where people repeat in turn, a part of it is
    /// of person `r` modulo their number.
    #[must_use]
    pub fn of_repetition(
        self,
        (seed, block): (u64, u32),
        r: usize,
        persons: Option<usize>,
    ) -> Self {
        let block = HEAD_BLOCK.wrapping_add(block);
        let drawn = self.drawn(&mut stream(seed, Purpose::Posture, block, r as u32));
        let Some(persons) = persons else { return drawn };
        let person = (r % persons) as u32;
        let own = self.drawn(&mut stream(seed, Purpose::Person, block, person)).departures;
        let both = |i: usize| {
            OWN_SHARE[i].sqrt() * own[i] + (1.0 - OWN_SHARE[i]).sqrt() * drawn.departures[i]
        };
        Self { departures: std::array::from_fn(both), ..drawn }
    }

    /// One of them.
    #[must_use]
    pub fn drawn(self, rng: &mut ChaCha8Rng) -> Self {
        let z = normals(rng, 3);
        // Left is right in the mirror image.
        let mirror = if self.side < 0.0 { -1.0 } else { 1.0 };
        Self { departures: [z[0], mirror * z[1], mirror * z[2]], ..self }
    }
}

/// What a head may be turned to: the trunk's axes, its inclination (rad), and the hand seen from the head.
pub(crate) struct Sight {
    /// Unit vector to the hand, thorax axes.
    to: Vec3,
    inclination: f64,
}

impl Sight {
    pub(crate) fn new(thorax: &Rotation, head_at: &Vec3, hand: &Vec3, inclination: f64) -> Self {
        let to = thorax.inverse() * (hand - head_at);
        Self { to: to.try_normalize(1e-9).unwrap_or_else(Vec3::x), inclination }
    }

    /// Its rotation in the axes of the thorax, by a rule.
    pub(crate) fn turned(&self, rule: NeckRule, draw: &HeadDraw) -> Rotation {
        let head = self.head(rule, draw);
        let turned = if rule == NeckRule::Gaze { head.about_axes() } else { head.rotation() };
        turned.to_rotation_matrix()
    }

    /// The head by a rule.
    pub(crate) fn head(&self, rule: NeckRule, draw: &HeadDraw) -> Head {
        match rule {
            NeckRule::Neutral => Head::default(),
            NeckRule::Gaze => self.facing(),
            NeckRule::Predicted => self.predicted(draw),
            NeckRule::Looking => self.looking(draw),
        }
    }

    /// Turned about the trunk's long axis, then nodded so that it faces the hand.
    fn facing(&self) -> Head {
        let to = &self.to;
        let (turn, nod) = ((-to.z).atan2(to.x), to.y.atan2(to.x.hypot(to.z)));
        held(-nod, turn, 0.0)
    }

    fn predicted(&self, draw: &HeadDraw) -> Head {
        let across = Vec3::x().cross(&self.to);
        let angle = across.norm().atan2(self.to.x).min(FRAC_PI_2);
        let aim = across.try_normalize(1e-9).map_or_else(Vec3::zeros, |a| a * angle);
        let [f, t, b] = draw.departures;
        held(
            FLEXION[0] - FLEXION[1] * aim.z + FLEXION[2] * self.inclination + SPREAD[0] * f,
            TURN[0] * draw.side + TURN[1] * aim.y + SPREAD[1] * t,
            BEND * draw.side + SPREAD[2] * b,
        )
    }

    /// As predicted, and turned on so far that the eyes find the part.
    fn looking(&self, draw: &HeadDraw) -> Head {
        let predicted = self.predicted(draw);
        let turned = predicted.rotation();
        let ahead = turned * Vec3::x();
        let missing = ahead.angle(&self.to) - EYES;
        if missing <= 0.0 {
            return predicted;
        }
        let Some(axis) = ahead.cross(&self.to).try_normalize(1e-9) else { return predicted };
        Head::of(&(UnitQuaternion::from_scaled_axis(axis * missing) * turned))
    }
}

/// Within the range of the neck.
fn held(flexion: f64, turn: f64, bend: f64) -> Head {
    let [f, e, t, b] = RANGE;
    Head { flexion: flexion.clamp(-e, f), turn: turn.clamp(-t, t), bend: bend.clamp(-b, b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight(hand: Vec3, inclination_deg: f64) -> Sight {
        Sight::new(&Rotation::identity(), &Vec3::zeros(), &hand, inclination_deg * DEG)
    }

    #[test]
    fn people_turn_a_part_of_the_way_and_extend_the_neck_at_the_floor() {
        let mean = HeadDraw::mean(Some(Side::Right));
        // Hand 40 deg below straight ahead.
        let low = sight(Vec3::new(40f64.to_radians().cos(), -(40f64.to_radians().sin()), 0.0), 5.0);
        let head = low.head(NeckRule::Predicted, &mean);
        assert!((head.flexion / DEG - (2.0 + 0.11 * 40.0 - 0.22 * 5.0)).abs() < 1e-9);
        assert!((low.head(NeckRule::Gaze, &mean).flexion / DEG - 40.0).abs() < 1e-9);
        let floor = sight(Vec3::new(0.1, -1.0, 0.0), 100.0);
        assert!(floor.head(NeckRule::Predicted, &mean).flexion < -10.0 * DEG);
        // The left hand is the mirror image.
        let hand = Vec3::new(0.6, -0.5, 0.4);
        let right = sight(hand, 10.0).head(NeckRule::Predicted, &mean);
        let left = HeadDraw::mean(Some(Side::Left));
        let left = sight(Vec3::new(0.6, -0.5, -0.4), 10.0).head(NeckRule::Predicted, &left);
        assert!((right.turn + left.turn).abs() < 1e-12 && (right.bend + left.bend).abs() < 1e-12);
    }

    #[test]
    fn who_looks_at_the_part_has_it_before_the_eyes() {
        let mean = HeadDraw::mean(Some(Side::Right));
        for hand in [Vec3::new(0.5, -0.6, 0.3), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.2, 0.5, -0.3)]
        {
            let s = sight(hand, 20.0);
            let head = s.head(NeckRule::Looking, &mean);
            let off = (head.rotation() * Vec3::x()).angle(&s.to);
            assert!(off < EYES + 1e-9, "{}", off / DEG);
            // No further than needed.
            let plain = s.head(NeckRule::Predicted, &mean);
            let before = (plain.rotation() * Vec3::x()).angle(&s.to);
            assert!((before.min(EYES) - off).abs() < 1e-6);
        }
    }
}

//! How fast body angles change where segments turn and joint centres move.
//!
//! A direction fixed in a segment changes by `omega x direction`, a direction between two points by the
//! part of their relative velocity across it; the angles of [`super::angles`] follow by the chain rule.
//! Fed with what one joint moves at unit speed, the rates are partial derivatives with respect to
//! that joint.
//!
//! World axes, rad/s and m/s in; deg/s (and m/s) out. Where an angle has no derivative the rate is 0:
//! an elbow that is exactly straight, the elevation of an arm that hangs exactly along the trunk (the
//! two sides' rates are opposite there), any swing of exactly 180 deg, the flexion of a trunk that
//! lies exactly sideways. Flexion and abduction of a hanging arm do have one, and it is met.

use super::angles::{ArmAngles, ArmPose, BodyPose, TINY, TrunkNeckAngles};
use crate::math::{Rotation, Vec3};

/// Velocities of pelvis, trunk and head.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyRates {
    /// Angular velocity of the pelvis, rad/s; the heading of the body turns with it.
    pub pelvis: Vec3,
    /// Angular velocity of the thorax, rad/s.
    pub thorax: Vec3,
    /// Angular velocity of the head, rad/s.
    pub head: Vec3,
    /// Velocity of L5/S1, m/s.
    pub l5s1: Vec3,
    /// Velocity of C7/T1, m/s.
    pub c7t1: Vec3,
}

/// Velocities of one arm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ArmRates {
    /// Angular velocity of the upper arm, rad/s.
    pub upper_arm: Vec3,
    /// Angular velocity of the forearm, rad/s.
    pub forearm: Vec3,
    /// Angular velocity of the hand, rad/s.
    pub hand: Vec3,
    /// Velocity of the shoulder joint, m/s.
    pub shoulder: Vec3,
    /// Velocity of the elbow, m/s.
    pub elbow: Vec3,
    /// Velocity of the wrist, m/s.
    pub wrist: Vec3,
    /// Velocity of the inner end of the girdle, m/s.
    pub sternoclavicular: Vec3,
    /// Rate of [`ArmPose::shoulder_lateral_m`], m/s; 0 where that is a number of the body, other where
    /// it is measured anew in each posture.
    pub shoulder_lateral_m: f64,
}

/// Rates of [`super::trunk_neck_angles`]: each field is the rate of the angle of its name, deg/s.
pub fn trunk_neck_rates(body: &BodyPose, rates: &BodyRates) -> TrunkNeckAngles {
    let up = Vec3::z();
    let axis = Moving::between((&body.l5s1, &rates.l5s1), (&body.c7t1, &rates.c7t1))
        .unwrap_or_else(|| Moving::fixed_in(body.thorax * Vec3::y(), &rates.thorax));
    let forward = heading(body, rates);
    let right = Moving { at: forward.at.cross(&up), rate: forward.rate.cross(&up) };
    let (ahead, ahead_rate) = axis.dot(&forward);
    let (above, above_rate) = (axis.at.z, axis.rate.z);
    let (_, aside_rate) = axis.dot(&right);
    let upright = ahead.hypot(above); // cosine of the side bend
    let head = Moving::fixed_in(body.head * Vec3::y(), &rates.head);
    let [_, nod, tilt] = swing_rates(&head.seen_from(&body.thorax, &rates.thorax), [1, 0, 2]);
    let twist = |lower: &Rotation, upper: &Rotation, spin: Vec3| {
        twist_rate(&(lower.inverse() * upper), &(lower.inverse() * spin)).to_degrees()
    };
    TrunkNeckAngles {
        trunk_flex_deg: ratio(above * ahead_rate - ahead * above_rate, upright * upright)
            .to_degrees(),
        trunk_side_deg: ratio(aside_rate, upright).to_degrees(),
        trunk_twist_deg: twist(&body.pelvis, &body.thorax, rates.thorax - rates.pelvis),
        neck_flex_deg: nod.to_degrees(),
        neck_side_deg: tilt.to_degrees(),
        neck_twist_deg: twist(&body.thorax, &body.head, rates.head - rates.thorax),
    }
}

/// Rates of [`super::arm_angles`]: each field is the rate of the angle of its name, deg/s or m/s.
pub fn arm_rates(
    body: &BodyPose,
    arm: &ArmPose,
    body_rates: &BodyRates,
    rates: &ArmRates,
) -> ArmAngles {
    let outward = arm.side.outward();
    let (thorax, turn) = (&body.thorax, &body_rates.thorax);
    let upper = Moving::between((&arm.shoulder, &rates.shoulder), (&arm.elbow, &rates.elbow))
        .unwrap_or_else(|| Moving::fixed_in(arm.upper_arm * -Vec3::y(), &rates.upper_arm));
    let fore = Moving::between((&arm.elbow, &rates.elbow), (&arm.wrist, &rates.wrist))
        .unwrap_or_else(|| Moving::fixed_in(arm.forearm * -Vec3::y(), &rates.forearm));
    let [elevation, flexion, abduction] =
        swing_rates(&upper.seen_from(thorax, turn).mirrored([1.0, -1.0, outward]), [1, 0, 2]);
    let fore_axis = Moving::fixed_in(arm.forearm * Vec3::y(), &rates.forearm);
    let by_hand = fore_axis.seen_from(&arm.hand, &rates.hand).mirrored([1.0, 1.0, outward]);
    let [_, wrist_flexion, deviation] = swing_rates(&by_hand, [1, 0, 2]);
    let twist = |lower: &Rotation, upper: &Rotation, spin: Vec3| {
        outward * twist_rate(&(lower.inverse() * upper), &(lower.inverse() * spin))
    };
    let pronation = twist(&arm.upper_arm, &arm.forearm, rates.forearm - rates.upper_arm)
        + twist(&arm.forearm, &arm.hand, rates.hand - rates.forearm);
    let reach = Moving { at: arm.wrist - body.c7t1, rate: rates.wrist - body_rates.c7t1 };
    let lateral = outward * reach.seen_from(thorax, turn).rate.z;
    ArmAngles {
        upper_arm_flex_deg: flexion.to_degrees(),
        upper_arm_abduction_deg: abduction.to_degrees(),
        upper_arm_elevation_deg: elevation.to_degrees(),
        girdle_elevation_deg: girdle_rate(body, arm, body_rates, rates).to_degrees(),
        elbow_flex_deg: angle_rate(&upper, &fore).to_degrees(),
        wrist_flex_deg: wrist_flexion.to_degrees(),
        wrist_deviation_deg: deviation.to_degrees(),
        wrist_twist_deg: pronation.to_degrees(),
        wrist_lateral_m: lateral,
        wrist_beyond_shoulder_m: lateral - rates.shoulder_lateral_m,
    }
}

/// A vector and its rate; directions have length 1.
#[derive(Debug, Clone, Copy)]
struct Moving {
    at: Vec3,
    rate: Vec3,
}

impl Moving {
    /// A direction fixed in a segment that turns.
    fn fixed_in(at: Vec3, spin: &Vec3) -> Self {
        Self { at, rate: spin.cross(&at) }
    }

    /// The direction from one point to another, both given with their velocities.
    fn between(from: (&Vec3, &Vec3), to: (&Vec3, &Vec3)) -> Option<Self> {
        Self { at: to.0 - from.0, rate: to.1 - from.1 }.unit(TINY)
    }

    /// Its direction; `None` where it is no longer than `least`.
    fn unit(&self, least: f64) -> Option<Self> {
        let length = self.at.norm();
        if length <= least {
            return None;
        }
        let at = self.at / length;
        Some(Self { at, rate: (self.rate - at * at.dot(&self.rate)) / length })
    }

    /// The same vector in the axes of a frame that turns.
    fn seen_from(&self, frame: &Rotation, spin: &Vec3) -> Self {
        let to = frame.inverse();
        Self { at: to * self.at, rate: to * (self.rate - spin.cross(&self.at)) }
    }

    /// With some components negated.
    fn mirrored(&self, signs: [f64; 3]) -> Self {
        let signs = Vec3::from(signs);
        Self { at: self.at.component_mul(&signs), rate: self.rate.component_mul(&signs) }
    }

    /// Scalar product with another, and its rate.
    fn dot(&self, other: &Self) -> (f64, f64) {
        (self.at.dot(&other.at), self.rate.dot(&other.at) + self.at.dot(&other.rate))
    }
}

/// Quotient, or 0 where the divisor vanishes and with it the derivative.
fn ratio(over: f64, under: f64) -> f64 {
    if under > TINY { over / under } else { 0.0 }
}

/// Heading of the body, by the same cases as the angles.
fn heading(body: &BodyPose, rates: &BodyRates) -> Moving {
    let level = |v: Moving| {
        let flat = |v: Vec3| Vec3::new(v.x, v.y, 0.0);
        Moving { at: flat(v.at), rate: flat(v.rate) }.unit(1e-6)
    };
    let across = Moving::fixed_in(body.pelvis * Vec3::z(), &rates.pelvis);
    level(Moving::fixed_in(body.pelvis * Vec3::x(), &rates.pelvis))
        .or_else(|| level(Moving::fixed_in(body.thorax * Vec3::x(), &rates.thorax)))
        .or_else(|| {
            level(Moving { at: Vec3::z().cross(&across.at), rate: Vec3::z().cross(&across.rate) })
        })
        .unwrap_or(Moving { at: Vec3::x(), rate: Vec3::zeros() })
}

/// Rates of a swing's angle and of its two components, rad/s; `[along, first, second]` are the places
/// of the neutral axis and of the two axes across it.
///
/// With e the angle, a component is `k f`, where f is the direction's part across and `k = e / sin e`.
/// As `d(cos e) = -sin e de`, it changes by `k df - m f d(along)` with `m = dk/de / sin e`, which is
/// finite at e = 0: no case is needed there.
fn swing_rates(direction: &Moving, [along, first, second]: [usize; 3]) -> [f64; 3] {
    let (at, rate) = (&direction.at, &direction.rate);
    let across = at[first].hypot(at[second]);
    let angle = across.atan2(at[along]);
    if across <= TINY && at[along] < 0.0 {
        return [0.0; 3];
    }
    let sinc = if across > TINY { across / angle } else { 1.0 };
    let m = sine_excess(angle) / (sinc * sinc * sinc);
    let part = |axis: usize| rate[axis] / sinc - m * at[axis] * rate[along];
    let outward = ratio(at[first] * rate[first] + at[second] * rate[second], across);
    [at[along] * outward - across * rate[along], part(first), part(second)]
}

/// `(sin e - e cos e) / e^3`; 1/3 at 0.
fn sine_excess(e: f64) -> f64 {
    if e > 0.3 {
        return (e.sin() - e * e.cos()) / (e * e * e);
    }
    // The difference of two nearly equal numbers, by its series: sum of (-1)^k (2k+2)/(2k+3)! e^2k.
    let s = e * e;
    1.0 / 3.0 - s * (1.0 / 30.0 - s * (1.0 / 840.0 - s * (1.0 / 45360.0 - s / 3_991_680.0)))
}

/// Rate of the twist about y of a relative rotation whose angular velocity, in the lower segment's
/// axes, is `spin`; rad/s. See the entries used by the angle itself.
fn twist_rate(relative: &Rotation, spin: &Vec3) -> f64 {
    let m = relative.matrix();
    let (x, z) = (m.column(0), m.column(2));
    let (x_rate, z_rate) = (spin.cross(&x), spin.cross(&z));
    let (sine, cosine) = (z.x - x.z, x.x + z.z);
    let (sine_rate, cosine_rate) = (z_rate.x - x_rate.z, x_rate.x + z_rate.z);
    ratio(cosine * sine_rate - sine * cosine_rate, sine * sine + cosine * cosine)
}

/// Rate of the angle between two directions, rad/s.
fn angle_rate(a: &Moving, b: &Moving) -> f64 {
    let (cosine, cosine_rate) = a.dot(b);
    let normal = a.at.cross(&b.at);
    let sine = normal.norm();
    let sine_rate = ratio(normal.dot(&(a.rate.cross(&b.at) + a.at.cross(&b.rate))), sine);
    cosine * sine_rate - sine * cosine_rate
}

fn girdle_rate(body: &BodyPose, arm: &ArmPose, body_rates: &BodyRates, rates: &ArmRates) -> f64 {
    let girdle = Moving::between(
        (&arm.sternoclavicular, &rates.sternoclavicular),
        (&arm.shoulder, &rates.shoulder),
    );
    girdle.map_or(0.0, |d| {
        let seen = d.seen_from(&body.thorax, &body_rates.thorax);
        ratio(seen.rate.y, seen.at.x.hypot(seen.at.z))
    })
}

#[cfg(test)]
mod tests;

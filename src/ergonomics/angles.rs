//! Body angles from rotation matrices and joint centres, by vectors and swing-twist, never by Euler
//! angles: those jump where the arm is raised sideways.
//!
//! World: right-handed, z up, m. Segment axes follow the ISB: x forward, y up, z right in the neutral
//! standing pose; the arm's segments are parallel to the thorax with the arm hanging and the palm
//! forward (anatomical zero). All results are finite for finite input.

use crate::math::{Rotation, Vec3};
use serde::Serialize;

/// Length (of a unit vector's part) below which a direction counts as undefined.
pub(super) const TINY: f64 = 1e-9;

/// Side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The person's left.
    Left,
    /// The person's right.
    Right,
}

impl Side {
    /// Factor that makes "to the right" into "outward".
    pub(super) fn outward(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

/// Pose of pelvis, trunk and head in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPose {
    /// Pelvis axes.
    pub pelvis: Rotation,
    /// Thorax axes (T8).
    pub thorax: Rotation,
    /// Head axes.
    pub head: Rotation,
    /// Centre of L5/S1, m.
    pub l5s1: Vec3,
    /// Centre of C7/T1, m.
    pub c7t1: Vec3,
}

/// Pose of one arm in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmPose {
    /// Which arm.
    pub side: Side,
    /// Upper arm axes.
    pub upper_arm: Rotation,
    /// Forearm axes.
    pub forearm: Rotation,
    /// Hand axes.
    pub hand: Rotation,
    /// Centre of the shoulder (glenohumeral) joint, m.
    pub shoulder: Vec3,
    /// Centre of the elbow, m.
    pub elbow: Vec3,
    /// Centre of the wrist, m.
    pub wrist: Vec3,
    /// Inner end of the shoulder girdle (sternoclavicular joint), m.
    pub sternoclavicular: Vec3,
    /// Angle of the girdle above the thorax's transverse plane in the body's neutral pose, deg.
    pub girdle_neutral_deg: f64,
    /// Distance of the shoulder joint from the mid-sagittal plane in the neutral pose, m.
    pub shoulder_lateral_m: f64,
}

/// Angles of trunk and neck, deg. Side bends are positive to the right, twists to the left (ISB).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct TrunkNeckAngles {
    /// Trunk flexion to the vertical, forward positive, up to 180.
    pub trunk_flex_deg: f64,
    /// Trunk side bend to the vertical, -90 to 90.
    pub trunk_side_deg: f64,
    /// Trunk twist to the pelvis.
    pub trunk_twist_deg: f64,
    /// Neck flexion to the thorax, forward positive.
    pub neck_flex_deg: f64,
    /// Neck side bend to the thorax.
    pub neck_side_deg: f64,
    /// Neck twist to the thorax.
    pub neck_twist_deg: f64,
}

/// Angles of one arm, deg; the same for mirrored postures of the left and the right arm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ArmAngles {
    /// Forward component of the arm's elevation to the trunk; backward negative.
    pub upper_arm_flex_deg: f64,
    /// Outward component of the arm's elevation to the trunk; across the body negative.
    pub upper_arm_abduction_deg: f64,
    /// Elevation of the arm from hanging along the trunk, 0 to 180.
    pub upper_arm_elevation_deg: f64,
    /// Elevation of the shoulder girdle above the body's neutral.
    pub girdle_elevation_deg: f64,
    /// Elbow flexion, 0 (straight) to 180.
    pub elbow_flex_deg: f64,
    /// Wrist flexion, to the palm positive.
    pub wrist_flex_deg: f64,
    /// Wrist deviation, radial (to the thumb) positive.
    pub wrist_deviation_deg: f64,
    /// Pronation from mid-prone (thumb forward with the arm hanging); supination negative.
    pub wrist_twist_deg: f64,
    /// Wrist from the mid-sagittal plane of the trunk, m; to the arm's own side positive.
    pub wrist_lateral_m: f64,
    /// How far the wrist is outside the neutral shoulder joint, m.
    pub wrist_beyond_shoulder_m: f64,
}

/// Angles of trunk and neck.
///
/// - Trunk flexion `atan2(t.h, t.g)` and side bend `asin(t.r)`: `t` from L5/S1 to C7/T1, `g` up, `h`
///   the pelvis's heading, `r` its right. To the vertical, not to the pelvis, as RULA's figures show,
///   so that leaning from the hips counts. Flexion is undefined, but finite, when the trunk lies
///   exactly sideways.
/// - Twists: rotation about the lower segment's y in the swing-twist split of the relative rotation.
///   Undefined, but finite, when the upper segment is exactly upside down to the lower.
/// - Neck flexion and side: components of the swing of the head's y axis in thorax axes.
pub fn trunk_neck_angles(body: &BodyPose) -> TrunkNeckAngles {
    let up = Vec3::z();
    let axis = direction(&body.l5s1, &body.c7t1).unwrap_or_else(|| body.thorax * Vec3::y());
    let forward = heading(body);
    let right = forward.cross(&up);
    let pelvis_thorax = body.pelvis.inverse() * body.thorax;
    let trunk = TrunkNeckAngles {
        trunk_flex_deg: axis.dot(&forward).atan2(axis.dot(&up)).to_degrees(),
        trunk_side_deg: axis.dot(&right).clamp(-1.0, 1.0).asin().to_degrees(),
        trunk_twist_deg: twist(&pelvis_thorax, 1.0).to_degrees(),
        ..TrunkNeckAngles::default()
    };
    trunk.with_head(&(body.thorax.inverse() * body.head))
}

impl TrunkNeckAngles {
    /// The same trunk with a head that is turned so in the axes of the thorax.
    #[must_use]
    pub fn with_head(&self, thorax_head: &Rotation) -> Self {
        let head_up = thorax_head * Vec3::y();
        let (_, neck_flex, neck_side) = swing(head_up.y, head_up.x, head_up.z);
        Self {
            neck_flex_deg: neck_flex.to_degrees(),
            neck_side_deg: neck_side.to_degrees(),
            neck_twist_deg: twist(thorax_head, 1.0).to_degrees(),
            ..*self
        }
    }
}

/// Angles of one arm against the trunk of `body`.
///
/// - Upper arm: elevation `e` of the direction from shoulder to elbow, split by its azimuth `a` (0
///   forward, 90 deg outward) into flexion `e cos a` and abduction `e sin a`. Smooth but at `e` = 180
///   deg, which counts as flexion.
/// - Elbow: angle between the directions of upper arm and forearm.
/// - Wrist: components of the forearm's axis as the *hand* sees it, so that pro-supination, wherever
///   the model puts it, does not mix into them.
/// - Wrist twist: sum of the axial twists at elbow and wrist. From full supination at the anatomical
///   zero, mid-prone is 90 deg of pronation for both sides.
/// - Lateral place of the wrist: from the plane through C7/T1 across the thorax's z axis.
///
/// Where two joint centres coincide, the segment's own axes give its direction; the girdle's angle is
/// then 0.
pub fn arm_angles(body: &BodyPose, arm: &ArmPose) -> ArmAngles {
    let outward = arm.side.outward();
    let to_trunk = body.thorax.inverse();

    let upper = direction(&arm.shoulder, &arm.elbow).unwrap_or_else(|| arm.upper_arm * -Vec3::y());
    let fore = direction(&arm.elbow, &arm.wrist).unwrap_or_else(|| arm.forearm * -Vec3::y());
    let u = to_trunk * upper;
    let (elevation, flexion, abduction) = swing(-u.y, u.x, outward * u.z);

    let girdle = direction(&arm.sternoclavicular, &arm.shoulder)
        .map_or(0.0, |d| (to_trunk * d).y.clamp(-1.0, 1.0).asin().to_degrees());

    let elbow_joint = arm.upper_arm.inverse() * arm.forearm;
    let wrist_joint = arm.forearm.inverse() * arm.hand;
    let seen_by_hand = wrist_joint.inverse() * Vec3::y();
    let (_, wrist_flexion, deviation) =
        swing(seen_by_hand.y, seen_by_hand.x, outward * seen_by_hand.z);
    let pronation = (twist(&elbow_joint, outward) + twist(&wrist_joint, outward)).to_degrees();

    let lateral = outward * (to_trunk * (arm.wrist - body.c7t1)).z;
    ArmAngles {
        upper_arm_flex_deg: flexion.to_degrees(),
        upper_arm_abduction_deg: abduction.to_degrees(),
        upper_arm_elevation_deg: elevation.to_degrees(),
        girdle_elevation_deg: girdle - arm.girdle_neutral_deg,
        elbow_flex_deg: upper.cross(&fore).norm().atan2(upper.dot(&fore)).to_degrees(),
        wrist_flex_deg: wrist_flexion.to_degrees(),
        wrist_deviation_deg: deviation.to_degrees(),
        wrist_twist_deg: wrap_deg(pronation - 90.0),
        wrist_lateral_m: lateral,
        wrist_beyond_shoulder_m: lateral - arm.shoulder_lateral_m,
    }
}

/// Unit vector from one point to another; `None` where they coincide.
fn direction(from: &Vec3, to: &Vec3) -> Option<Vec3> {
    (to - from).try_normalize(TINY)
}

/// Horizontal forward direction of the body: the pelvis's x axis, or the thorax's where that is
/// vertical (lying), or what the pelvis's z axis says.
fn heading(body: &BodyPose) -> Vec3 {
    let level = |v: Vec3| Vec3::new(v.x, v.y, 0.0).try_normalize(1e-6);
    level(body.pelvis * Vec3::x())
        .or_else(|| level(body.thorax * Vec3::x()))
        .or_else(|| level(Vec3::z().cross(&(body.pelvis * Vec3::z()))))
        .unwrap_or_else(Vec3::x)
}

/// Angle of a unit vector from its neutral axis, and the two components of the rotation vector that
/// brings it there (rad): `along` the neutral axis, `first` and `second` across it.
///
/// At exactly 180 deg the split is undefined and all of it goes to the first component.
fn swing(along: f64, first: f64, second: f64) -> (f64, f64, f64) {
    let across = first.hypot(second);
    let angle = across.atan2(along);
    if across > TINY {
        (angle, angle * (first / across), angle * (second / across))
    } else if along > 0.0 {
        (angle, first, second)
    } else {
        (angle, angle, 0.0)
    }
}

/// Rotation about y in the swing-twist split, rad in (-pi, pi], with `sign` 1 or -1.
///
/// With the quaternion (w, x, y, z) it is `2 atan2(y, w)`; the two sums of entries are `4 w y` and
/// `2 (w^2 - y^2)`, so no square root or case of quaternion extraction is needed.
fn twist(rotation: &Rotation, sign: f64) -> f64 {
    let m = rotation.matrix();
    // Adding 0 turns -0 into 0: half a turn is +pi for both signs.
    (sign * (m[(0, 2)] - m[(2, 0)]) + 0.0).atan2(m[(0, 0)] + m[(2, 2)])
}

/// Wraps an angle to (-180, 180] deg.
fn wrap_deg(angle: f64) -> f64 {
    let turned = angle.rem_euclid(360.0);
    if turned > 180.0 { turned - 360.0 } else { turned }
}

#[cfg(test)]
mod tests;

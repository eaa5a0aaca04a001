//! A pose in which a person stands upright with limbs that were swung out of hanging, as in a T-pose.
//!
//! The axes of segments follow from it:
//!
//! | segments | y | x or z |
//! |---|---|---|
//! | pelvis, spine, neck, head, collar bones | upwards | z from the left to the right |
//! | upper arms, thighs and shanks | against the bone | z of the trunk, swung along with the bone |
//! | forearms, hands | against the bone | z forwards (right), backwards (left): to the thumb or away |
//! | feet, toes | upwards, swung along with the shank | x along the foot |
//!
//! Thumbs point forwards at rest, in a T-pose with palms down as in arms that hang with palms inwards,
//! unless a thumb of the skeleton is nearer to another quarter turn about the forearm.

use super::names::{Joints, Limbs, Side, is_thumb};
use super::skeleton::{Placed, Skeleton};
use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use crate::recording::axes::{along_limb, square};
use crate::recording::lines::{Fault, shown};
use nalgebra::UnitQuaternion;

/// Cosine of the angle to an axis of the world within which trunk and legs stand upright.
const UPRIGHT: f64 = 0.9;
/// Cosine of the angle to the vertical within which an arm points up.
const OVERHEAD: f64 = 0.7;
/// Cosine of the bend of an elbow within which an arm is straight.
const STRAIGHT: f64 = 0.85;
/// Lengths, as shares of the trunk, below which a bone tells no direction.
const SHORT: f64 = 1e-3;

const REST: &str = "the skeleton's zero pose, or else the first frame, must be a T-pose or stand upright with \
                    arms hanging";

/// A rest pose and the directions in it.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    /// Every joint in this pose, in the file's unit.
    pub placed: Vec<Placed>,
    /// Which axis of the file points upwards in it: 0, 1, 2 are x, y, z.
    pub vertical: usize,
    up: Vec3,
    right: Vec3,
    forward: Vec3,
    /// Length below which a bone tells no direction, in the file's unit.
    short: f64,
}

impl Rest {
    /// # Errors
    /// Where nobody could stand so.
    pub(super) fn new(
        skeleton: &Skeleton,
        joints: &Joints,
        placed: Vec<Placed>,
    ) -> Result<Self, Fault> {
        let at = |joint: usize| placed[joint].start;
        let no = |what: &str| Fault::whole(format!("{what} in its zero pose"), REST);
        let tall = at(joints.top()) - at(joints.pelvis);
        let vertical = tall.iamax();
        let mut up = Vec3::zeros();
        up[vertical] = 1.0;
        if tall[vertical] <= UPRIGHT * tall.norm() {
            return Err(no("does not stand upright"));
        }
        let (right, left) = (&joints.right, &joints.left);
        let across = match (right.upper_leg, left.upper_leg) {
            (Some(right), Some(left)) => at(right) - at(left),
            _ => at(right.upper_arm) - at(left.upper_arm),
        };
        let short = SHORT * tall.norm();
        let Some(right) = square(&across, &up).filter(|_| across.norm() > short) else {
            return Err(no("has its right and its left side in one place"));
        };
        let rest = Self { vertical, up, right, forward: up.cross(&right), short, placed };
        for side in [Side::Right, Side::Left] {
            rest.check(skeleton, joints.limbs(side), side)?;
        }
        Ok(rest)
    }

    fn check(&self, skeleton: &Skeleton, limbs: &Limbs, side: Side) -> Result<(), Fault> {
        let no = |what: &str| {
            let side = side.prefix().to_lowercase();
            Fault::whole(format!("the {side} {what} in its zero pose"), REST)
        };
        let bones = [(limbs.upper_leg, limbs.lower_leg), (limbs.lower_leg, limbs.foot)];
        for (from, to) in bones.into_iter().filter_map(|(from, to)| from.zip(to)) {
            let bone = self.placed[to].start - self.placed[from].start;
            if bone.dot(&self.up) >= -UPRIGHT * bone.norm() {
                return Err(no("leg does not stand upright"));
            }
        }
        let arm = self.along(skeleton, limbs.upper_arm, limbs.fore_arm);
        if arm.is_none_or(|arm| arm.dot(&self.up) > OVERHEAD) {
            return Err(no("arm has no length, or points up,"));
        }
        // A mirrored skeleton cannot be told in another way.
        let foot = limbs.foot.and_then(|foot| self.along(skeleton, foot, limbs.toe));
        if foot.is_some_and(|foot| foot.dot(&self.forward) < -0.5) {
            return Err(no("foot points backwards"));
        }
        Ok(())
    }

    /// Whether the bones of each arm lie along one line, so that the turn of a forearm is known.
    pub(super) fn has_straight_arms(&self, joints: &Joints) -> bool {
        [Side::Right, Side::Left].into_iter().all(|side| {
            let limbs = joints.limbs(side);
            let Some((elbow, wrist)) = limbs.fore_arm.zip(limbs.hand) else { return true };
            let [upper, fore] = [(limbs.upper_arm, elbow), (elbow, wrist)]
                .map(|(from, to)| self.placed[to].start - self.placed[from].start);
            upper.dot(&fore) > STRAIGHT * upper.norm() * fore.norm()
        })
    }

    /// How far the arms point down, 0 in a T-pose to 1 where they hang.
    pub(super) fn hanging(&self, joints: &Joints) -> f64 {
        let one = |side: Side| {
            let limbs = joints.limbs(side);
            let end = limbs.hand.or(limbs.fore_arm);
            let bone = end.map(|end| self.placed[end].start - self.placed[limbs.upper_arm].start);
            bone.and_then(|bone| bone.try_normalize(0.0)).map_or(0.0, |bone| -bone.dot(&self.up))
        };
        0.5 * (one(Side::Right) + one(Side::Left))
    }

    /// Unit vector from a joint to the next one, or else to what hangs on it.
    fn along(&self, skeleton: &Skeleton, joint: usize, next: Option<usize>) -> Option<Vec3> {
        let start = self.placed[joint].start;
        let is_end = |c: &usize| !is_thumb(&skeleton.joints[*c].name);
        let ends: Vec<usize> =
            next.map_or_else(|| skeleton.children(joint).filter(is_end).collect(), |n| vec![n]);
        let bone: Vec3 = ends.iter().map(|end| self.placed[*end].start - start).sum();
        bone.try_normalize(self.short)
    }

    /// Axes of the trunk (ISB) in the world of the file.
    pub(super) fn trunk(&self) -> UnitQuaternion<f64> {
        rotation_from_axes(self.forward, self.up, self.right)
    }

    /// Axes of a bone that bends forwards or backwards: its z is swung along.
    pub(super) fn swung(
        &self,
        skeleton: &Skeleton,
        joint: usize,
        next: Option<usize>,
    ) -> Result<UnitQuaternion<f64>, Fault> {
        let along = self.bone(skeleton, joint, next)?;
        let swing = UnitQuaternion::rotation_between(&-self.up, &along);
        let axes = swing.and_then(|swing| along_limb(&along, &(swing * self.right)));
        axes.ok_or_else(|| turned(skeleton, joint))
    }

    /// Axes of a forearm or a hand, and by how many quarter turns about itself its thumb is not ahead.
    pub(super) fn by_thumb(
        &self,
        skeleton: &Skeleton,
        limbs: &Limbs,
        side: Side,
        joint: usize,
        next: Option<usize>,
    ) -> Result<(UnitQuaternion<f64>, u8), Fault> {
        let fore_arm = limbs.fore_arm.unwrap_or(limbs.upper_arm);
        let arm = self.bone(skeleton, fore_arm, limbs.hand)?;
        // The hand lies along the forearm where nothing tells otherwise.
        let along = self.along(skeleton, joint, next).unwrap_or(arm);
        let ahead = square(&self.forward, &arm).ok_or_else(|| turned(skeleton, joint))?;
        let quarter = UnitQuaternion::from_scaled_axis(arm * std::f64::consts::FRAC_PI_2);
        let (mut thumb, mut quarters) = (ahead, 0);
        if let Some(seen) = self.thumb(skeleton, limbs, &arm) {
            let mut turned = ahead;
            for turns in 1..4 {
                turned = quarter * turned;
                if turned.dot(&seen) > thumb.dot(&seen) {
                    (thumb, quarters) = (turned, turns);
                }
            }
        }
        let outwards = if side == Side::Right { 1.0 } else { -1.0 };
        let axes =
            along_limb(&along, &(outwards * thumb)).ok_or_else(|| turned(skeleton, joint))?;
        Ok((axes, quarters))
    }

    /// The side of a forearm on which the thumb of its hand is, where the skeleton has one.
    fn thumb(&self, skeleton: &Skeleton, limbs: &Limbs, arm: &Vec3) -> Option<Vec3> {
        let hand = limbs.hand?;
        let of_hand = (hand + 1..skeleton.joints.len()).rev();
        let mut thumbs = of_hand.filter(|j| is_thumb(&skeleton.joints[*j].name));
        let last = thumbs.find(|j| skeleton.hangs_on(*j, hand))?;
        let out = self.placed[last].start - self.placed[hand].start;
        square(&out, arm).filter(|_| out.norm() > self.short)
    }

    /// Axes of a foot and its toes: level where the shank hangs, and swung along with it; x along the foot.
    pub(super) fn level(
        &self,
        skeleton: &Skeleton,
        shank: &UnitQuaternion<f64>,
        foot: usize,
        toe: Option<usize>,
    ) -> UnitQuaternion<f64> {
        let swing = shank * self.trunk().inverse();
        let along = self.along(skeleton, foot, toe).map(|along| swing.inverse() * along);
        let x = along.and_then(|along| square(&along, &self.up)).unwrap_or(self.forward);
        swing * rotation_from_axes(x, self.up, x.cross(&self.up))
    }

    fn bone(&self, skeleton: &Skeleton, joint: usize, next: Option<usize>) -> Result<Vec3, Fault> {
        self.along(skeleton, joint, next).ok_or_else(|| {
            let name = shown(&skeleton.joints[joint].name);
            let message = format!("the bone of the joint `{name}` has no length");
            Fault::whole(message, "export the skeleton with the lengths of its bones")
        })
    }
}

fn turned(skeleton: &Skeleton, joint: usize) -> Fault {
    let name = shown(&skeleton.joints[joint].name);
    Fault::whole(format!("nothing tells how the bone of `{name}` is turned about itself"), REST)
}

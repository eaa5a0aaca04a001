//! Which bones a segment is made of, and its anatomical axes in the rest pose.
//!
//! Everything follows from the rest pose itself, whose trunk is upright:
//!
//! | segments | y | x or z |
//! |---|---|---|
//! | pelvis, spine, neck, head, collar bones | upwards | z from the left hip to the right |
//! | thighs and shanks | against the bone | z the hinge of the knee |
//! | feet, toes | square to x | x along the toes, z nearest to that of the shank |
//! | upper arms | against the bone | z the hinge of the elbow |
//! | forearms, hands | against the bone | z to the side of the thumb (right), away from it (left) |
//!
//! A bone that hangs askew at rest is one that was swung out of the hanging pose the shortest way.
//! This swing gives z where a knee or an elbow is no hinge, and tells the sign of a hinge.
//!
//! The joints of the spine lie 21, 47 and 74 % of the way from the hips to the neck; those of MVNX
//! lie at 19, 39, 57 and 74 %. So `lowerback` is L5 and `thorax` T8, and the joint between
//! `lowerback` and `upperback` is shared out: L3 takes half its turn and begins at two thirds of
//! `lowerback`, T12 is `upperback` from its first third on.

use super::skeleton::{Channel, Placed, Skeleton};
use crate::math::Vec3;
use crate::math::pose::{rotation_between, rotation_from_axes};
use crate::recording::axes::{along_limb, square, upright};
use crate::recording::lines::{Fault, shown};
use nalgebra::{UnitQuaternion, UnitVector3};

/// Segment, the bones between whose turns its own lies halfway, the bone on which it begins and the
/// share of that bone's length that lies before. The pelvis begins midway between the hips.
const PARTS: [(&str, [&str; 2], &str, f64); 23] = [
    ("Pelvis", ["root", "root"], "root", 0.0),
    ("L5", ["lowerback", "lowerback"], "lowerback", 0.0),
    ("L3", ["lowerback", "upperback"], "lowerback", 2.0 / 3.0),
    ("T12", ["upperback", "upperback"], "upperback", 1.0 / 3.0),
    ("T8", ["thorax", "thorax"], "thorax", 0.0),
    ("Neck", ["lowerneck", "upperneck"], "lowerneck", 0.0),
    ("Head", ["head", "head"], "head", 0.0),
    ("RightShoulder", ["rclavicle", "rclavicle"], "rclavicle", 0.0),
    ("RightUpperArm", ["rhumerus", "rhumerus"], "rhumerus", 0.0),
    ("RightForeArm", ["rwrist", "rwrist"], "rradius", 0.0),
    ("RightHand", ["rhand", "rhand"], "rhand", 0.0),
    ("LeftShoulder", ["lclavicle", "lclavicle"], "lclavicle", 0.0),
    ("LeftUpperArm", ["lhumerus", "lhumerus"], "lhumerus", 0.0),
    ("LeftForeArm", ["lwrist", "lwrist"], "lradius", 0.0),
    ("LeftHand", ["lhand", "lhand"], "lhand", 0.0),
    ("RightUpperLeg", ["rfemur", "rfemur"], "rfemur", 0.0),
    ("RightLowerLeg", ["rtibia", "rtibia"], "rtibia", 0.0),
    ("RightFoot", ["rfoot", "rfoot"], "rfoot", 0.0),
    ("RightToe", ["rtoes", "rtoes"], "rtoes", 0.0),
    ("LeftUpperLeg", ["lfemur", "lfemur"], "lfemur", 0.0),
    ("LeftLowerLeg", ["ltibia", "ltibia"], "ltibia", 0.0),
    ("LeftFoot", ["lfoot", "lfoot"], "lfoot", 0.0),
    ("LeftToe", ["ltoes", "ltoes"], "ltoes", 0.0),
];

/// Cosine of the angle to an axis of the world within which the rest pose is upright along it.
const UPRIGHT: f64 = 0.9;
/// Cosine of the angle to the swung z beyond which a hinge is not believed.
const NEAR: f64 = 0.5;

const BONES: &str =
    "a recording needs the bones of the usual skeleton, from root to head, hands, thumbs and toes";
const REST: &str = "the skeleton's rest pose must stand upright, with arms away from overhead";

/// A segment of a person on the bones of a skeleton.
#[derive(Debug)]
pub(super) struct Part {
    pub name: &'static str,
    turns: [usize; 2],
    begin: usize,
    share: f64,
    /// Segment axes (ISB) in the rest pose, in the file's world axes.
    axes: UnitQuaternion<f64>,
}

/// All segments of a person on a skeleton.
#[derive(Debug)]
pub(super) struct Anatomy {
    pub parts: Vec<Part>,
    hips: [usize; 2],
    /// From the file's world axes to those of a recording (z up).
    pub to_world: UnitQuaternion<f64>,
}

impl Anatomy {
    /// # Errors
    /// Where a bone is missing or has no length, or the rest pose does not stand upright.
    pub(super) fn new(skeleton: &Skeleton) -> Result<Self, Fault> {
        let rest = Rest::new(skeleton)?;
        let mut parts = Vec::with_capacity(PARTS.len());
        for (name, turns, begin, share) in PARTS {
            let turns = [rest.find(turns[0])?, rest.find(turns[1])?];
            let (begin, axes) = (rest.find(begin)?, rest.axes(name)?);
            parts.push(Part { name, turns, begin, share, axes });
        }
        let hips = [rest.find("rfemur")?, rest.find("lfemur")?];
        Ok(Self { parts, hips, to_world: upright(rest.vertical) })
    }

    /// The pose of a segment: its proximal joint centre (m) and the rotation of its axes, in the
    /// world of a recording.
    pub(super) fn pose(
        &self,
        part: &Part,
        skeleton: &Skeleton,
        placed: &[Placed],
    ) -> (Vec3, UnitQuaternion<f64>) {
        let [from, to] = part.turns.map(|i| placed[i].turn);
        let turn = UnitQuaternion::from_scaled_axis(0.5 * rotation_between(&from, &to)) * from;
        let start = if part.name == "Pelvis" {
            let [right, left] = self.hips.map(|i| placed[i].start);
            0.5 * (right + left)
        } else {
            let on = &placed[part.begin];
            on.start + on.turn * (part.share * skeleton.bones[part.begin].along)
        };
        (self.to_world * start, self.to_world * turn * part.axes)
    }
}

/// The rest pose.
struct Rest<'a> {
    skeleton: &'a Skeleton,
    placed: Vec<Placed>,
    /// Which axis of the file points upwards.
    vertical: usize,
    up: Vec3,
    right: Vec3,
}

impl<'a> Rest<'a> {
    fn new(skeleton: &'a Skeleton) -> Result<Self, Fault> {
        let placed = skeleton.place(&vec![0.0; skeleton.dof()]);
        let mut rest =
            Self { skeleton, placed, vertical: 0, up: Vec3::zeros(), right: Vec3::zeros() };
        let feet = 0.5 * (rest.start("rfoot")? + rest.start("lfoot")?);
        let tall = rest.start("head")? - feet;
        rest.vertical = tall.imax();
        rest.up[rest.vertical] = 1.0;
        let across = rest.start("rfemur")? - rest.start("lfemur")?;
        let right = square(&across, &rest.up);
        match right.filter(|_| tall[rest.vertical] > UPRIGHT * tall.norm()) {
            Some(right) => rest.right = right,
            None => return Err(Fault::whole("does not stand upright in its rest pose", REST)),
        }
        Ok(rest)
    }

    fn find(&self, name: &str) -> Result<usize, Fault> {
        self.skeleton.find(name).ok_or_else(|| Fault::whole(format!("has no bone `{name}`"), BONES))
    }

    fn start(&self, name: &str) -> Result<Vec3, Fault> {
        Ok(self.placed[self.find(name)?].start)
    }

    /// Direction of a bone.
    fn along(&self, name: &str) -> Result<Vec3, Fault> {
        let along = self.skeleton.bones[self.find(name)?].along;
        along
            .try_normalize(1e-6)
            .ok_or_else(|| Fault::whole(format!("the bone `{name}` has no length"), BONES))
    }

    /// Segment axes (ISB) in the rest pose.
    fn axes(&self, segment: &str) -> Result<UnitQuaternion<f64>, Fault> {
        let (side, part, outwards) = match segment.strip_prefix("Right") {
            Some(part) => ("r", part, 1.0),
            None => ("l", segment.strip_prefix("Left").unwrap_or_default(), -1.0),
        };
        let bone = |name: &str| format!("{side}{name}");
        match part {
            "UpperLeg" | "LowerLeg" => {
                let name = if part == "UpperLeg" { "femur" } else { "tibia" };
                self.limb(&bone(name), &bone("tibia"))
            }
            "UpperArm" => self.limb(&bone("humerus"), &bone("radius")),
            "ForeArm" | "Hand" => {
                let name = if part == "ForeArm" { bone("wrist") } else { bone("hand") };
                let thumb = self.along(&bone("thumb"))?;
                self.hanging(&name, &(outwards * thumb))
            }
            "Foot" | "Toe" => {
                let x = self.along(&bone("toes"))?;
                let shank = self.limb(&bone("tibia"), &bone("tibia"))?;
                let z = square(&(shank * Vec3::z()), &x).ok_or_else(|| {
                    let message = format!("`{}` points sideways in the rest pose", bone("toes"));
                    Fault::whole(message, REST)
                })?;
                Ok(rotation_from_axes(x, z.cross(&x), z))
            }
            _ => Ok(self.trunk()),
        }
    }

    fn trunk(&self) -> UnitQuaternion<f64> {
        rotation_from_axes(self.up.cross(&self.right), self.up, self.right)
    }

    /// Axes of a limb that bends at the joint of the bone `joint`.
    fn limb(&self, bone: &str, joint: &str) -> Result<UnitQuaternion<f64>, Fault> {
        let along = self.along(bone)?;
        let swing = UnitQuaternion::rotation_between(&-self.up, &along).ok_or_else(|| {
            Fault::whole(format!("`{bone}` points upwards in the rest pose"), REST)
        })?;
        let swung = swing * self.right;
        let z = match self.hinge(joint)?.map(|h| (h, h.dot(&swung))) {
            Some((hinge, near)) if near.abs() > NEAR => near.signum() * hinge.into_inner(),
            _ => swung,
        };
        self.hanging(bone, &z)
    }

    /// The axis of a joint that has only one.
    fn hinge(&self, bone: &str) -> Result<Option<UnitVector3<f64>>, Fault> {
        let bone = &self.skeleton.bones[self.find(bone)?];
        let axes = [Vec3::x_axis(), Vec3::y_axis(), Vec3::z_axis()];
        Ok(match bone.channels.as_slice() {
            [Channel::Turn(axis)] => Some(bone.axes * axes[*axis]),
            _ => None,
        })
    }

    /// Axes of a limb: y against the bone, z as near as can be to the one given.
    fn hanging(&self, bone: &str, near_z: &Vec3) -> Result<UnitQuaternion<f64>, Fault> {
        along_limb(&self.along(bone)?, near_z).ok_or_else(|| {
            let message = format!("nothing tells how `{}` is turned about itself", shown(bone));
            Fault::whole(message, REST)
        })
    }
}

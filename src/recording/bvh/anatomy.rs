//! The segments of a person on a skeleton of joints.
//!
//! A segment turns with the last joint before the next segment: a forearm with a joint for its own turn
//! between elbow and wrist pronates with that one.

use super::names::{Joints, Limbs, Side};
use super::rest::Rest;
use super::skeleton::{Placed, Skeleton};
use crate::math::Vec3;
use crate::math::pose::rotation_between;
use crate::recording::axes::upright;
use crate::recording::lines::Fault;
use nalgebra::UnitQuaternion;

/// Where the joints of the spine lie on the way from the hips to the neck, as in MVNX.
const LEVELS: [(&str, f64); 3] = [("L5", 0.19), ("L3", 0.39), ("T12", 0.57)];

/// The joints from which the place and the turn of a segment follow.
#[derive(Debug, Clone, Copy)]
struct Between {
    /// It begins on the way from the first to the second,
    begin: [usize; 2],
    /// at this share of it,
    share: f64,
    /// and turns halfway from the first of these to the second.
    turns: [usize; 2],
}

impl Between {
    /// A segment that begins at a joint and turns with the same or a further one.
    fn joints(begin: usize, turn: usize) -> Self {
        Self { begin: [begin; 2], share: 0.0, turns: [turn; 2] }
    }

    /// Place in the file's unit, and turn since the zero pose.
    fn at(&self, placed: &[Placed]) -> (Vec3, UnitQuaternion<f64>) {
        let [from, to] = self.turns.map(|i| placed[i].turn);
        let turn = UnitQuaternion::from_scaled_axis(0.5 * rotation_between(&from, &to)) * from;
        let [from, to] = self.begin.map(|i| placed[i].start);
        (from + self.share * (to - from), turn)
    }
}

/// A segment of a person on the joints of a skeleton.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub name: String,
    between: Between,
    /// Segment axes (ISB) in the axes of a joint, which are those of the file at zero.
    axes: UnitQuaternion<f64>,
}

/// All segments of a person on a skeleton.
#[derive(Debug, Clone)]
pub(super) struct Anatomy {
    pub parts: Vec<Part>,
    /// Quarter turns by which the thumbs are not ahead at rest, right and left.
    pub quarters: [u8; 2],
    /// Length of the file's unit, m.
    pub unit_m: f64,
    /// From the file's world axes to those of a recording (z up).
    to_world: UnitQuaternion<f64>,
}

impl Anatomy {
    /// # Errors
    /// Where a bone has no length, or nothing tells how it is turned about itself.
    pub(super) fn new(
        skeleton: &Skeleton,
        joints: &Joints,
        rest: &Rest,
        vertical: usize,
    ) -> Result<Self, Fault> {
        let mut builder = Builder { skeleton, rest, parts: Vec::new() };
        builder.trunk(joints);
        let right = builder.arm(joints, Side::Right)?;
        let left = builder.arm(joints, Side::Left)?;
        builder.leg(&joints.right, Side::Right)?;
        builder.leg(&joints.left, Side::Left)?;
        let to_world = upright(vertical);
        Ok(Self { parts: builder.parts, quarters: [right, left], unit_m: 1.0, to_world })
    }

    /// The pose of a segment: its proximal joint centre (m) and the rotation of its axes, in the
    /// world of a recording.
    pub(super) fn pose(&self, part: &Part, placed: &[Placed]) -> (Vec3, UnitQuaternion<f64>) {
        let (start, turn) = part.between.at(placed);
        (self.to_world * (self.unit_m * start), self.to_world * turn * part.axes)
    }

    /// Turns of all segments in the first one, the pelvis.
    pub(super) fn in_pelvis(&self, placed: &[Placed]) -> Vec<UnitQuaternion<f64>> {
        let turns: Vec<_> = self.parts.iter().map(|part| self.pose(part, placed).1).collect();
        let pelvis = turns.first().copied().unwrap_or_default().inverse();
        turns.into_iter().map(|turn| pelvis * turn).collect()
    }
}

struct Builder<'a> {
    skeleton: &'a Skeleton,
    rest: &'a Rest,
    parts: Vec<Part>,
}

impl Builder<'_> {
    /// Adds a segment of the given axes at rest, in the world of the file.
    fn add(&mut self, name: String, between: Between, axes: UnitQuaternion<f64>) {
        let (_, turn) = between.at(&self.rest.placed);
        self.parts.push(Part { name, between, axes: turn.inverse() * axes });
    }

    fn trunk(&mut self, joints: &Joints) {
        let axes = self.rest.trunk();
        let hips = match (joints.right.upper_leg, joints.left.upper_leg) {
            (Some(right), Some(left)) => [right, left],
            _ => [joints.pelvis; 2],
        };
        let pelvis = Between { begin: hips, share: 0.5, turns: [joints.pelvis; 2] };
        self.add("Pelvis".to_owned(), pelvis, axes);
        for (name, between) in self.spine(joints) {
            self.add(name.to_owned(), between, axes);
        }
        if let Some([first, last]) = joints.neck {
            let neck = Between { turns: [first, last], ..Between::joints(first, first) };
            self.add("Neck".to_owned(), neck, axes);
        }
        if let Some(head) = joints.head {
            self.add("Head".to_owned(), Between::joints(head, head), axes);
        }
    }

    /// The segments of the spine and their joints.
    ///
    /// Three joints are taken as those of an Acclaim skeleton; two have the whole lumbar spine between
    /// them, which is called L3, as in the rigid bodies.
    fn spine(&self, joints: &Joints) -> Vec<(&'static str, Between)> {
        let own = |joint: usize| Between::joints(joint, joint);
        match *joints.spine.as_slice() {
            [thorax] => vec![("T8", own(thorax))],
            [lumbar, thorax] => vec![("L3", own(lumbar)), ("T8", own(thorax))],
            [low, mid, thorax] => vec![
                ("L5", own(low)),
                ("L3", Between { begin: [low, mid], share: 2.0 / 3.0, turns: [low, mid] }),
                ("T12", Between { begin: [mid, thorax], share: 1.0 / 3.0, turns: [mid; 2] }),
                ("T8", own(thorax)),
            ],
            [l5, l3, t12, t8] => {
                vec![("L5", own(l5)), ("L3", own(l3)), ("T12", own(t12)), ("T8", own(t8))]
            }
            ref more => self.levels(joints, more),
        }
    }

    /// The joints of a spine of more than four that lie nearest to where segments begin.
    fn levels(&self, joints: &Joints, spine: &[usize]) -> Vec<(&'static str, Between)> {
        let height = |joint: usize| {
            (self.rest.placed[joint].start - self.rest.placed[joints.pelvis].start).norm()
        };
        let whole = height(joints.neck.map_or(joints.trunk(), |[neck, _]| neck));
        let mut found = Vec::new();
        let mut rest = spine;
        for (i, (name, level)) in LEVELS.into_iter().enumerate() {
            // Enough joints stay over for the segments above.
            let choice = rest.len().saturating_sub(LEVELS.len() - i);
            let off = |k: &usize| (height(rest[*k]) - level * whole).abs();
            let nearest = (0..choice).min_by(|a, b| off(a).total_cmp(&off(b)));
            if let Some(k) = nearest {
                found.push((name, Between::joints(rest[k], rest[k])));
                rest = &rest[k + 1..];
            }
        }
        let trunk = joints.trunk();
        found.push(("T8", Between::joints(trunk, trunk)));
        found
    }

    /// Whether anything follows a joint.
    fn has_bone(&self, joint: usize) -> bool {
        self.skeleton.children(joint).next().is_some()
    }

    /// From a joint on, with the turn of the last one before the next segment.
    fn until(&self, joint: usize, next: Option<usize>) -> Between {
        let last = next.and_then(|next| self.skeleton.joints[next].parent);
        Between::joints(joint, last.unwrap_or(joint))
    }

    /// Adds collar bone, upper arm, forearm and hand, as far as there are joints; by how many quarter
    /// turns the thumb is not ahead at rest.
    fn arm(&mut self, joints: &Joints, side: Side) -> Result<u8, Fault> {
        let limbs = joints.limbs(side);
        let name = |part: &str| format!("{}{part}", side.prefix());
        let mut quarters = 0;
        if let Some(shoulder) = limbs.shoulder {
            let between = self.until(shoulder, Some(limbs.upper_arm));
            self.add(name("Shoulder"), between, self.rest.trunk());
        }
        let (upper_arm, next) = (limbs.upper_arm, limbs.fore_arm);
        let axes = self.rest.swung(self.skeleton, upper_arm, next)?;
        self.add(name("UpperArm"), self.until(upper_arm, next), axes);
        for (part, joint, next) in
            [("ForeArm", limbs.fore_arm, limbs.hand), ("Hand", limbs.hand, None)]
        {
            let Some(joint) = joint.filter(|j| self.has_bone(*j)) else { break };
            let (axes, turns) = self.rest.by_thumb(self.skeleton, limbs, side, joint, next)?;
            self.add(name(part), self.until(joint, next), axes);
            quarters = turns;
        }
        Ok(quarters)
    }

    /// Adds thigh, shank, foot and toes, as far as there are joints.
    fn leg(&mut self, limbs: &Limbs, side: Side) -> Result<(), Fault> {
        let name = |part: &str| format!("{}{part}", side.prefix());
        let mut shank = self.rest.trunk();
        for (part, joint, next) in [
            ("UpperLeg", limbs.upper_leg, limbs.lower_leg),
            ("LowerLeg", limbs.lower_leg, limbs.foot),
        ] {
            let Some(joint) = joint.filter(|j| self.has_bone(*j)) else { return Ok(()) };
            shank = self.rest.swung(self.skeleton, joint, next)?;
            self.add(name(part), self.until(joint, next), shank);
        }
        let Some(foot) = limbs.foot else { return Ok(()) };
        let axes = self.rest.level(self.skeleton, &shank, foot, limbs.toe);
        self.add(name("Foot"), self.until(foot, limbs.toe), axes);
        if let Some(toe) = limbs.toe {
            self.add(name("Toe"), self.until(toe, None), axes);
        }
        Ok(())
    }
}

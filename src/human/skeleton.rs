//! Where the segments of a posed body are, for scores and drawings: the joints that are predicted, and what
//! follows from them.
//!
//! ```text
//! coupled chain   as given: pelvis (if it moves), spine, arms of the coupled hands
//! legs            from the pelvis, on feet that stay where they are
//! other arm       hangs under its shoulder, the thumb forward
//! head            as given, relative to the trunk
//! ```

use super::body::{Body, Stance};
use super::legs::{LegPosture, Legs};
use super::pelvis::{PELVIS, pelvis_in_rest};
use super::side::{Coupled, Side};
use crate::files::{InputError, suggest};
use crate::kinematics::{Frames, Linkage};
use crate::math::pose::zxy;
use crate::math::{Pose, Vec3};
use nalgebra::{Matrix6xX, UnitQuaternion};
use std::f64::consts::FRAC_PI_2;

/// Links whose origins are joint centres, in the order of a drawing.
const TRUNK: &[&str] = &["L5", "L3", "T12", "T8", "Neck", "Head"];
const ARM: &[&str] = &["Shoulder", "UpperArm", "ForeArm", "Hand", "Grip"];
const LEG: &[&str] = &["UpperLeg", "LowerLeg", "Foot", "Toe"];
/// An arm that hangs: how far out from the body, and how bent the elbow is, rad.
const HANGS_OUT: f64 = 6.0 * std::f64::consts::PI / 180.0;
const HANGS_BENT: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// How the head is held relative to the trunk (T8), rad: half of each in the lower and the upper neck.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Head {
    /// Forward.
    pub flexion: f64,
    /// To the left.
    pub turn: f64,
    /// To the right.
    pub bend: f64,
}

impl Head {
    /// The rotation of the head in the axes of the thorax.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        let half = |axis: Vec3, angle: f64| UnitQuaternion::from_scaled_axis(axis * (0.5 * angle));
        let neck = half(Vec3::z(), -self.flexion)
            * half(Vec3::x(), self.bend)
            * half(Vec3::y(), self.turn);
        neck * neck
    }

    /// The rotation of a head that is turned about the trunk's long axis and then nodded.
    pub fn about_axes(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(Vec3::y() * self.turn)
            * UnitQuaternion::from_scaled_axis(Vec3::z() * -self.flexion)
    }

    /// The head with a rotation in the axes of the thorax.
    pub fn of(rotation: &UnitQuaternion<f64>) -> Self {
        let half = UnitQuaternion::from_scaled_axis(rotation.scaled_axis() * 0.5);
        let [z, x, y] = zxy(half.to_rotation_matrix().matrix());
        Self { flexion: -2.0 * z, turn: 2.0 * y, bend: 2.0 * x }
    }
}

/// All segments of a body as tips of one linkage from the rest frame.
#[derive(Debug, Clone)]
pub struct Skeleton {
    linkage: Linkage,
    names: Vec<String>,
    legs: Legs,
    leg_m: f64,
    coupled: Coupled,
    /// Columns of the coupled chain: from here, and as many.
    chain: (usize, usize),
    /// Columns of both necks about Z, X and Y.
    neck: [usize; 6],
    /// The arm that hangs, if any.
    hanging: Option<Hanging>,
    /// Of each leg hip Z, X, Y, knee, ankle Z, X and ball of the foot; none without legs.
    leg_columns: Option<[[usize; 7]; 2]>,
}

/// Columns of an arm that hangs, and its ranges.
#[derive(Debug, Clone)]
struct Hanging {
    side: Side,
    shoulder: [usize; 3],
    elbow: usize,
    pronation: usize,
    ranges: [(f64, f64); 3],
}

/// A segment of one skeleton, by its place among the tips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment(usize);

/// Segment poses of one posture, in the rest frame.
#[derive(Debug, Clone)]
pub struct PosedSkeleton<'a> {
    skeleton: &'a Skeleton,
    frames: Frames,
}

impl Skeleton {
    /// The skeleton for a coupled chain; `with_legs` for drawings, without for scores.
    pub fn new(
        body: &Body,
        coupled: Coupled,
        stance: Stance,
        with_legs: bool,
    ) -> Result<Self, InputError> {
        let limb = |parts: &[&str], s: Side| -> Vec<String> {
            parts.iter().map(|p| format!("{}{p}", s.prefix())).collect()
        };
        let lead = coupled.hands.lead();
        // The coupled grips first: they fix the order of the leading columns.
        let mut names: Vec<String> =
            coupled.hands.sides().iter().map(|s| s.grip().to_owned()).collect();
        names.push(PELVIS.to_owned());
        names.extend(TRUNK.iter().map(|&s| s.to_owned()));
        for s in [lead, lead.other()] {
            names.extend(limb(ARM, s));
            if with_legs {
                names.extend(limb(LEG, s));
            }
        }
        let linkage = body.whole_linkage(&names)?;
        let column = |joint: String| {
            let found = linkage.joints().iter().position(|j| j.name == joint);
            found.ok_or_else(|| InputError::new(&body.name, format!("has no joint `{joint}`")))
        };
        let from = 6 - coupled.pelvis.free();
        let count = body.chain(coupled, &[])?.dof();
        let of = |joint: &str| column(format!("j{joint}"));
        let neck = [
            of("T1C7_Z")?,
            of("T1C7_X")?,
            of("T1C7_Y")?,
            of("C1Head_Z")?,
            of("C1Head_X")?,
            of("C1Head_Y")?,
        ];
        let other = [Side::Right, Side::Left].into_iter().find(|s| !coupled.hands.hold(*s));
        let hanging = match other {
            None => None,
            Some(side) => {
                let of = |joint: &str| column(format!("j{}{joint}", side.prefix()));
                let shoulder = [of("Shoulder_Z")?, of("Shoulder_X")?, of("Shoulder_Y")?];
                let ranges = shoulder.map(|c| {
                    let joint = &linkage.joints()[c];
                    (joint.lower, joint.upper)
                });
                let (elbow, pronation) = (of("Elbow_Z")?, of("Elbow_Y")?);
                Some(Hanging { side, shoulder, elbow, pronation, ranges })
            }
        };
        let leg = |side: Side| {
            let of = |joint: &str| column(format!("j{}{joint}", side.prefix()));
            Ok::<_, InputError>([
                of("Hip_Z")?,
                of("Hip_X")?,
                of("Hip_Y")?,
                of("Knee_Z")?,
                of("Ankle_Z")?,
                of("Ankle_X")?,
                of("BallFoot_Z")?,
            ])
        };
        let leg_columns =
            if with_legs { Some([leg(Side::Right)?, leg(Side::Left)?]) } else { None };
        Ok(Self {
            legs: Legs::new(body, stance)?,
            leg_m: body.leg_m(),
            coupled,
            chain: (from, count),
            linkage,
            names,
            neck,
            hanging,
            leg_columns,
        })
    }

    /// Which joints are predicted together.
    pub fn coupled(&self) -> Coupled {
        self.coupled
    }

    /// The legs on their feet.
    pub fn legs(&self) -> &Legs {
        &self.legs
    }

    /// Number of coordinates of the whole body: pelvis and joints.
    pub fn dof(&self) -> usize {
        self.linkage.dof()
    }

    /// Names of the pelvis' coordinates and the joints, in the order of the columns.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.linkage.joints().iter().map(|j| j.name.as_str())
    }

    /// Column of a joint.
    pub fn column(&self, joint: &str) -> Option<usize> {
        self.joints().position(|j| j == joint)
    }

    /// The segment of a name; an error that suggests another for one that this skeleton lacks.
    pub fn segment(&self, name: &str) -> Result<Segment, InputError> {
        match self.names.iter().position(|n| n == name) {
            Some(i) => Ok(Segment(i)),
            None => Err(self.unknown(name)),
        }
    }

    fn unknown(&self, name: &str) -> InputError {
        let error = InputError::new(name, "is no segment of this skeleton");
        match suggest(name, self.names.iter().map(String::as_str)) {
            Some(remedy) => error.remedy(remedy),
            None => error,
        }
    }

    /// The bones to draw, as pairs of segments whose origins they join; for a skeleton with legs.
    pub fn bones(&self) -> Result<Vec<[Segment; 2]>, InputError> {
        let pair = |(a, b): &(String, String)| Ok([self.segment(a)?, self.segment(b)?]);
        bones().iter().map(pair).collect()
    }

    /// Pelvis in the rest frame, for the coupled chain's posture `q` (rad, leg lengths).
    pub fn pelvis(&self, q: &[f64]) -> Pose {
        let mut six = [0.0; 6];
        let free = self.coupled.pelvis.free();
        six[6 - free..].copy_from_slice(&q[..free]);
        pelvis_in_rest(&six, self.leg_m)
    }

    /// Both legs, right first, for the coupled chain's posture.
    pub fn leg_postures(&self, q: &[f64]) -> [LegPosture; 2] {
        self.legs.postures(&self.pelvis(q))
    }

    /// All columns (rad, leg lengths) from the coupled chain's posture and the head.
    ///
    /// # Panics
    /// When `q` has not as many values as the coupled chain has joints.
    pub fn whole(&self, q: &[f64], head: Head) -> Vec<f64> {
        let mut all = vec![0.0; self.dof()];
        self.whole_into(q, head, &mut all);
        all
    }

    /// The same written over the columns of another posture.
    pub(super) fn whole_into(&self, q: &[f64], head: Head, all: &mut [f64]) {
        let (from, count) = self.chain;
        all[from..from + count].copy_from_slice(q);
        let halves = [-head.flexion, head.bend, head.turn].map(|a| 0.5 * a);
        for (i, c) in self.neck.iter().enumerate() {
            all[*c] = halves[i % 3];
        }
        if let Some(arm) = &self.hanging {
            arm.hang(all);
        }
        if let Some(columns) = &self.leg_columns {
            for (leg, columns) in self.leg_postures(q).iter().zip(columns) {
                let [z, x, y] = leg.hip;
                let [bend, roll] = leg.ankle;
                for (c, v) in columns.iter().zip([z, x, y, leg.knee, bend, roll, leg.heel]) {
                    all[*c] = v;
                }
            }
        }
    }

    /// Poses all segments; `all` holds all columns (rad, leg lengths).
    pub fn pose(&self, all: &[f64]) -> PosedSkeleton<'_> {
        let mut frames = Frames::default();
        self.linkage.forward(all, &mut frames);
        PosedSkeleton { skeleton: self, frames }
    }

    /// The same for capsules: scratch that is kept.
    pub(super) fn forward(&self, all: &[f64], frames: &mut Frames) {
        self.linkage.forward(all, frames);
    }

    /// Place (m) and axes of a segment, rest frame.
    pub(super) fn frame(
        &self,
        frames: &Frames,
        segment: Segment,
    ) -> (Vec3, nalgebra::Matrix3<f64>) {
        self.linkage.tip_frame(frames, segment.0)
    }
}

impl Hanging {
    /// Sets the arm's columns so that it hangs, for a trunk that is set.
    fn hang(&self, all: &mut [f64]) {
        // Pelvis and spine: turns about Z, X and Y one after the other, from the fourth column on.
        let axes = [Vec3::z(), Vec3::x(), Vec3::y()];
        let turn =
            |q, (i, a): (usize, &f64)| q * UnitQuaternion::from_scaled_axis(axes[i % 3] * *a);
        let thorax = all[3..18].iter().enumerate().fold(UnitQuaternion::identity(), turn);
        let down = thorax.inverse() * -Vec3::y();
        let (out, thumb) = match self.side {
            Side::Right => (-HANGS_OUT, FRAC_PI_2),
            Side::Left => (HANGS_OUT, -FRAC_PI_2),
        };
        let hangs = UnitQuaternion::rotation_between(&-Vec3::y(), &down)
            .unwrap_or_else(UnitQuaternion::identity);
        let arm = UnitQuaternion::from_scaled_axis(Vec3::x() * out) * hangs;
        let angles = zxy(arm.to_rotation_matrix().matrix());
        for ((c, angle), (low, high)) in self.shoulder.iter().zip(angles).zip(self.ranges) {
            all[*c] = angle.clamp(low, high);
        }
        all[self.elbow] = HANGS_BENT;
        all[self.pronation] = thumb;
    }
}

impl PosedSkeleton<'_> {
    /// Pose of a segment's frame in the rest frame, by [`Skeleton::segment`].
    pub fn at(&self, segment: Segment) -> Pose {
        self.skeleton.linkage.tip_pose(&self.frames, segment.0)
    }

    /// Geometric Jacobian of a segment's frame in rest axes, 6 x all columns: velocity of its origin
    /// over angular velocity.
    pub fn jacobian(&self, segment: Segment) -> Matrix6xX<f64> {
        self.skeleton.linkage.jacobian(&self.frames, segment.0)
    }
}

/// The same by name.
fn bones() -> Vec<(String, String)> {
    let chain = |names: Vec<String>| -> Vec<(String, String)> {
        names.windows(2).map(|p| (p[0].clone(), p[1].clone())).collect()
    };
    let mut all = Vec::new();
    let mut spine = vec![PELVIS.to_owned()];
    spine.extend(TRUNK.iter().map(|&s| s.to_owned()));
    all.extend(chain(spine));
    for side in ["Right", "Left"] {
        let mut arm = vec!["T8".to_owned()];
        arm.extend(ARM.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(arm));
        let mut leg = vec![PELVIS.to_owned()];
        leg.extend(LEG.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(leg));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Hands, Pelvis};
    use approx::assert_relative_eq;

    const STANDING: Stance = Stance::Standing { shoe_m: 0.03 };
    const WHOLE: Coupled = Coupled { hands: Hands::Right, pelvis: Pelvis::Moves };

    fn body() -> Body {
        Body::load("female_p50", std::path::Path::new(".")).unwrap()
    }

    #[test]
    fn a_misspelt_segment_is_refused_and_the_pelvis_is_where_it_is() {
        let coupled = Coupled::arm(Side::Right);
        let skeleton = Skeleton::new(&body(), coupled, STANDING, true).unwrap();
        let posed = skeleton.pose(&vec![0.0; skeleton.dof()]);
        assert_eq!(posed.at(skeleton.segment("Pelvis").unwrap()), Pose::identity());
        let head = posed.at(skeleton.segment("Head").unwrap()).translation.vector;
        assert!(head.y > 0.4, "{head}");
        let error = skeleton.segment("Haed").unwrap_err();
        let shown = format!("{:?}", miette::Report::new(error));
        assert!(shown.contains("Haed") && shown.contains("did you mean `Head`?"), "{shown}");
        // One without legs has no bones of legs.
        assert_eq!(skeleton.bones().unwrap().len(), 24);
        let upper = Skeleton::new(&body(), coupled, STANDING, false).unwrap();
        assert!(upper.segment("RightFoot").is_err() && upper.bones().is_err());
    }

    /// Poses of feet and toes, and the right leg, for some coordinates of the pelvis.
    fn feet(skeleton: &Skeleton, pelvis: [f64; 6]) -> ([Pose; 4], LegPosture) {
        let mut q = vec![0.0; skeleton.chain.1];
        q[..6].copy_from_slice(&pelvis);
        q[6] = 0.6 * pelvis[3];
        let posed = skeleton.pose(&skeleton.whole(&q, Head::default()));
        let at = |name: &str| posed.at(skeleton.segment(name).unwrap());
        let arm = at("LeftForeArm").translation.vector - at("LeftUpperArm").translation.vector;
        assert!(arm.normalize().y < -0.98, "the other arm hangs: {arm}");
        let [right, left] = skeleton.leg_postures(&q);
        assert!(right.short_m == 0.0 && left.short_m == 0.0);
        (["RightFoot", "LeftFoot", "RightToe", "LeftToe"].map(at), right)
    }

    #[test]
    fn feet_stay_where_they_are_and_the_other_arm_hangs() {
        let skeleton = Skeleton::new(&body(), WHOLE, STANDING, true).unwrap();
        let (upright, _) = feet(&skeleton, [0.0; 6]);
        let same = |a: &Pose, b: &Pose| {
            assert_relative_eq!(a.translation.vector, b.translation.vector, epsilon = 1e-7);
            assert!(a.rotation.angle_to(&b.rotation) < 1e-6);
        };
        let (bent, leg) = feet(&skeleton, [-0.22, -0.14, 0.03, -0.7, 0.1, 0.15]);
        assert!(leg.heel == 0.0 && -leg.knee > 0.6, "{leg:?}");
        upright.iter().zip(&bent).for_each(|(a, b)| same(a, b));
        // A deep squat: the shin is at its limit, the heels rise and the toes stay.
        let (deep, leg) = feet(&skeleton, [-0.1, -0.45, 0.0, -0.6, 0.0, 0.0]);
        assert!(leg.heel > 0.1 && -leg.knee > 1.5, "{leg:?}");
        assert_relative_eq!(leg.ankle[0], 20f64.to_radians(), epsilon = 1e-5);
        upright[2..].iter().zip(&deep[2..]).for_each(|(a, b)| same(a, b));
        assert!(deep[0].translation.y > upright[0].translation.y + 0.01);
    }

    #[test]
    fn the_head_is_where_its_angles_say() {
        let skeleton = Skeleton::new(&body(), Coupled::arm(Side::Right), STANDING, true).unwrap();
        let forward = |head: Head| {
            let posed = skeleton.pose(&skeleton.whole(&[0.0; 24], head));
            let turn = posed.at(skeleton.segment("Head").unwrap()).rotation;
            (turn * Vec3::x(), turn * Vec3::y())
        };
        let (nodding, _) = forward(Head { flexion: 0.3, ..Head::default() });
        assert_relative_eq!(nodding.y, -0.3f64.sin(), epsilon = 1e-12);
        let (left, _) = forward(Head { turn: 0.3, ..Head::default() });
        assert_relative_eq!(left.z, -0.3f64.sin(), epsilon = 1e-12);
        let (_, bent) = forward(Head { bend: 0.3, ..Head::default() });
        assert_relative_eq!(bent.z, 0.3f64.sin(), epsilon = 1e-12);
    }
}

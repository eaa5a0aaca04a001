//! From joint angles to body angles and their scores: fills the worksheets from forward kinematics.

mod whole;

pub use whole::{WholePosture, WholeSurveyor};

use crate::ergonomics::Side as ScoreSide;
use crate::ergonomics::{
    ArmAngles, ArmPose, BodyPose, Profile, RulaSteps, Sheet, TaskInputs, TrunkNeckAngles,
    Worksheet, arm_angles, rula, trunk_neck_angles, worksheet,
};
use crate::files::InputError;
use crate::human::{Body, PosedSkeleton, SEATED_LEGS, Segment, Side, Skeleton, Stance};
use crate::math::{Pose, Rotation, Vec3};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// How the head is held, which nobody predicts.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum NeckRule {
    /// In line with the trunk.
    #[default]
    Neutral,
    /// Turned to the hand, within the joint limits.
    Gaze,
}

/// Range of the neck to which a gaze is held, deg: flexion, extension, twist.
const NECK_RANGE_DEG: [f64; 3] = [50.0, 60.0, 80.0];

/// What varies between one look at the scores and another.
#[derive(Debug, Clone)]
pub struct Lens {
    /// Load, repetition, support, legs.
    pub task: TaskInputs,
    /// How the head is held.
    pub neck: NeckRule,
    /// The convention.
    pub profile: Profile,
}

/// The angles of one posture, before any rule about task or neck.
#[derive(Debug, Clone, Copy)]
pub struct PostureAngles {
    /// Trunk, and neck in line with it.
    pub neutral: TrunkNeckAngles,
    /// Trunk, and head turned to the hand.
    pub gaze: TrunkNeckAngles,
    /// The arm that holds on to the robot.
    pub arm: ArmAngles,
    /// The other arm, hanging.
    pub other: ArmAngles,
}

impl PostureAngles {
    /// Trunk and neck under a rule for the head.
    pub fn trunk_neck(&self, rule: NeckRule) -> &TrunkNeckAngles {
        match rule {
            NeckRule::Neutral => &self.neutral,
            NeckRule::Gaze => &self.gaze,
        }
    }

    /// The filled-in worksheet.
    pub fn sheet(&self, lens: &Lens) -> Worksheet {
        worksheet(self.trunk_neck(lens.neck), &self.arm, &lens.task, &lens.profile)
    }

    /// By all scoring methods.
    pub fn score(&self, lens: &Lens) -> Sheet {
        Sheet::of(&self.sheet(lens), &lens.profile)
    }

    /// RULA of the other arm: no load, no coupling.
    pub fn other_rula(&self, lens: &Lens) -> RulaSteps {
        let task =
            TaskInputs { load_kg: 0.0, load_shock: false, arm_supported: false, ..lens.task };
        let sheet = worksheet(self.trunk_neck(lens.neck), &self.other, &task, &lens.profile);
        rula(&sheet, &lens.profile)
    }
}

/// Poses a body in the world and measures it.
#[derive(Debug, Clone)]
pub struct Surveyor {
    /// Trunk, head and arms, for scores.
    upper: Measured,
    /// All segments, for drawings.
    whole: Skeleton,
    bones: Vec<[Segment; 2]>,
    head: Segment,
    pelvis: Pose,
    side: Side,
    is_seated: bool,
}

/// The segments that scores need, found once.
#[derive(Debug, Clone)]
struct Measured {
    skeleton: Skeleton,
    l5: Segment,
    t8: Segment,
    neck: Segment,
    head: Segment,
    grip: Segment,
    arms: [ArmSegments; 2],
}

#[derive(Debug, Clone, Copy)]
struct ArmSegments {
    side: Side,
    girdle: Segment,
    upper: Segment,
    fore: Segment,
    hand: Segment,
    /// Distance of the shoulder joint from the mid-sagittal plane at zero angles, m.
    shoulder_lateral_m: f64,
}

impl Measured {
    fn new(body: &Body, side: Side, with_legs: bool) -> Result<Self, InputError> {
        let skeleton = Skeleton::new(body, side, with_legs)?;
        let still = skeleton.pose(&vec![0.0; skeleton.dof()]);
        let of = |name: &str| skeleton.segment(name);
        let (l5, t8, neck, head) = (of("L5")?, of("T8")?, of("Neck")?, of("Head")?);
        let grip = of(side.grip())?;
        let arm = |side: Side| {
            let of = |part: &str| skeleton.segment(&format!("{}{part}", side.prefix()));
            let upper = of("UpperArm")?;
            let [from, to] = [neck, upper].map(|s| still.at(s).translation.vector);
            Ok::<_, InputError>(ArmSegments {
                side,
                girdle: of("Shoulder")?,
                upper,
                fore: of("ForeArm")?,
                hand: of("Hand")?,
                shoulder_lateral_m: (to - from).z.abs(),
            })
        };
        let arms = [arm(side)?, arm(side.other())?];
        Ok(Self { skeleton, l5, t8, neck, head, grip, arms })
    }
}

/// All joint angles of a skeleton: the coupled chain as given, the other arm hanging with the thumb
/// forward, the rest at zero.
fn whole_posture(skeleton: &Skeleton, side: Side, q: &DVector<f64>) -> Vec<f64> {
    let mut all = vec![0.0; skeleton.dof()];
    all[..q.len()].copy_from_slice(q.as_slice());
    let (pronation, sign) = match side {
        Side::Right => ("jLeftElbow_Y", -1.0),
        Side::Left => ("jRightElbow_Y", 1.0),
    };
    if let Some(c) = skeleton.column(pronation) {
        all[c] = sign * std::f64::consts::FRAC_PI_2;
    }
    all
}

impl Surveyor {
    /// For a body whose pelvis is at `pelvis` in the world.
    pub fn new(body: &Body, side: Side, pelvis: Pose, stance: Stance) -> Result<Self, InputError> {
        let whole = Skeleton::new(body, side, true)?;
        let is_seated = matches!(stance, Stance::Seated { .. });
        let (bones, head) = (whole.bones()?, whole.segment("Head")?);
        let upper = Measured::new(body, side, false)?;
        Ok(Self { upper, whole, bones, head, pelvis, side, is_seated })
    }

    /// Body angles of the posture `q` (n joints of the coupled chain, rad).
    pub fn measure(&self, q: &DVector<f64>) -> PostureAngles {
        let parts = &self.upper;
        let posed = parts.skeleton.pose(&whole_posture(&parts.skeleton, self.side, q));
        let mut body = self.body_pose(&posed);
        let neutral = trunk_neck_angles(&body);
        let [arm, other] = parts.arms.map(|a| measure_arm(&posed, &self.pelvis, a, &body));
        body.head = self.sight(&posed).head();
        PostureAngles { neutral, gaze: trunk_neck_angles(&body), arm, other }
    }

    /// Trunk, and head in line with it.
    fn body_pose(&self, posed: &PosedSkeleton) -> BodyPose {
        let at = |segment: Segment| self.pelvis * posed.at(segment);
        let thorax = rotation(&at(self.upper.t8));
        BodyPose {
            pelvis: rotation(&self.pelvis),
            thorax,
            head: thorax,
            l5s1: at(self.upper.l5).translation.vector,
            c7t1: at(self.upper.neck).translation.vector,
        }
    }

    fn sight(&self, posed: &PosedSkeleton) -> Sight {
        let at = |segment: Segment| self.pelvis * posed.at(segment);
        let (head, hand) = (at(self.upper.head), at(self.upper.grip));
        Sight::new(&at(self.upper.t8), &head.translation.vector, &hand.translation.vector)
    }

    /// Bones as segments in the world, for drawings.
    pub fn bones(&self, q: &DVector<f64>) -> Vec<[[f64; 3]; 2]> {
        self.bones_at(&self.pelvis, q)
    }

    /// The same with the pelvis elsewhere.
    pub fn bones_at(&self, pelvis: &Pose, q: &DVector<f64>) -> Vec<[[f64; 3]; 2]> {
        let mut all = whole_posture(&self.whole, self.side, q);
        if self.is_seated {
            // Thighs level, shanks upright: legs are not predicted, only drawn.
            for (joint, angle) in SEATED_LEGS {
                if let Some(c) = self.whole.column(joint) {
                    all[c] = angle;
                }
            }
        }
        let posed = self.whole.pose(&all);
        let at = |s: Segment| -> [f64; 3] { (pelvis * posed.at(s)).translation.vector.into() };
        let mut bones: Vec<[[f64; 3]; 2]> = self.bones.iter().map(|pair| pair.map(at)).collect();
        let head = pelvis * posed.at(self.head);
        let crown = head * nalgebra::Point3::new(0.0, 0.14, 0.0);
        bones.push([head.translation.vector.into(), crown.coords.into()]);
        bones
    }
}

/// Angles of one arm of a posed skeleton whose pelvis is at `pelvis` in the world.
fn measure_arm(
    posed: &PosedSkeleton,
    pelvis: &Pose,
    segments: ArmSegments,
    body: &BodyPose,
) -> ArmAngles {
    arm_angles(body, &arm_pose(posed, pelvis, segments))
}

fn arm_pose(posed: &PosedSkeleton, pelvis: &Pose, segments: ArmSegments) -> ArmPose {
    let at = |segment: Segment| pelvis * posed.at(segment);
    let (girdle, upper) = (at(segments.girdle), at(segments.upper));
    let (fore, hand) = (at(segments.fore), at(segments.hand));
    ArmPose {
        side: match segments.side {
            Side::Right => ScoreSide::Right,
            Side::Left => ScoreSide::Left,
        },
        upper_arm: rotation(&upper),
        forearm: rotation(&fore),
        hand: rotation(&hand),
        shoulder: upper.translation.vector,
        elbow: fore.translation.vector,
        wrist: hand.translation.vector,
        sternoclavicular: girdle.translation.vector,
        // The clavicle of our bodies is level at zero.
        girdle_neutral_deg: 0.0,
        shoulder_lateral_m: segments.shoulder_lateral_m,
    }
}

/// Head that faces a hand.
fn gaze(thorax: &Pose, head_at: &Vec3, hand: &Vec3) -> Rotation {
    Sight::new(thorax, head_at, hand).head()
}

fn rotation(pose: &Pose) -> Rotation {
    pose.rotation.to_rotation_matrix()
}

/// Head turned about the trunk's long axis and then nodded so that it faces the hand.
struct Sight {
    thorax: nalgebra::UnitQuaternion<f64>,
    /// Turn to the left, rad, before it is held to the neck's range.
    turn: f64,
    /// Nod upward, rad, before it is held to the neck's range.
    nod: f64,
}

impl Sight {
    fn new(thorax: &Pose, head_at: &Vec3, hand: &Vec3) -> Self {
        let to = thorax.rotation.inverse() * (hand - head_at);
        let (turn, nod) = ((-to.z).atan2(to.x), to.y.atan2(to.x.hypot(to.z)));
        Self { thorax: thorax.rotation, turn, nod }
    }

    /// Turn and nod within the neck's range, rad.
    fn held(&self) -> (f64, f64) {
        let [flexion, extension, twist] = NECK_RANGE_DEG.map(f64::to_radians);
        (self.turn.clamp(-twist, twist), self.nod.clamp(-flexion, extension))
    }

    fn head(&self) -> Rotation {
        let (turn, nod) = self.held();
        let within = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::y() * turn)
            * nalgebra::UnitQuaternion::from_scaled_axis(Vec3::z() * nod);
        (self.thorax * within).to_rotation_matrix()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surveyor(side: Side) -> (Body, Surveyor) {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let stance = Stance::Standing { shoe_m: 0.03 };
        let pelvis = body.pelvis_pose([1.0, -2.0], 0.7, stance);
        let surveyor = Surveyor::new(&body, side, pelvis, stance).unwrap();
        (body, surveyor)
    }

    fn angles(side: Side, set: &[(&str, f64)]) -> PostureAngles {
        let (body, surveyor) = surveyor(side);
        let arm = body.arm(side).unwrap();
        let mut q = DVector::zeros(arm.dof());
        for (name, deg) in set {
            let column = arm.joints().iter().position(|j| j.name == *name).unwrap();
            q[column] = deg.to_radians();
        }
        surveyor.measure(&q)
    }

    #[test]
    fn a_neutral_posture_measures_zero() {
        let a = angles(Side::Right, &[("jRightElbow_Y", 90.0)]);
        for value in [
            a.neutral.trunk_flex_deg,
            a.neutral.trunk_side_deg,
            a.neutral.trunk_twist_deg,
            a.neutral.neck_flex_deg,
            a.arm.upper_arm_flex_deg,
            a.arm.upper_arm_abduction_deg,
            a.arm.girdle_elevation_deg,
            a.arm.elbow_flex_deg,
            a.arm.wrist_flex_deg,
            a.arm.wrist_deviation_deg,
            a.arm.wrist_twist_deg,
        ] {
            assert!(value.abs() < 1e-6, "{a:?}");
        }
    }

    #[test]
    fn single_joints_move_the_angle_that_bears_their_name() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        near(angles(Side::Right, &[("jRightShoulder_Z", 50.0)]).arm.upper_arm_flex_deg, 50.0);
        near(angles(Side::Right, &[("jRightShoulder_X", -40.0)]).arm.upper_arm_abduction_deg, 40.0);
        near(angles(Side::Right, &[("jRightElbow_Z", 80.0)]).arm.elbow_flex_deg, 80.0);
        near(angles(Side::Right, &[("jRightElbow_Y", 130.0)]).arm.wrist_twist_deg, 40.0);
        near(angles(Side::Right, &[("jRightWrist_Z", 20.0)]).arm.wrist_flex_deg, 20.0);
        near(angles(Side::Right, &[("jRightWrist_X", -15.0)]).arm.wrist_deviation_deg, 15.0);
        near(angles(Side::Right, &[("jRightC7Shoulder_X", -10.0)]).arm.girdle_elevation_deg, 10.0);
        let bent = angles(Side::Right, &[("jL5S1_Z", -25.0)]);
        near(bent.neutral.trunk_flex_deg, 25.0);
        near(bent.neutral.neck_flex_deg, 0.0);
        near(angles(Side::Right, &[("jT9T8_Y", 20.0)]).neutral.trunk_twist_deg, 20.0);
        // The left side counts the same way.
        near(angles(Side::Left, &[("jLeftElbow_Y", -130.0)]).arm.wrist_twist_deg, 40.0);
        near(angles(Side::Left, &[("jLeftShoulder_X", 40.0)]).arm.upper_arm_abduction_deg, 40.0);
    }

    #[test]
    fn the_gaze_follows_a_low_hand() {
        let a = angles(Side::Right, &[("jRightShoulder_Z", 45.0), ("jRightElbow_Y", 90.0)]);
        assert!(a.gaze.neck_flex_deg > 20.0, "{:?}", a.gaze);
        assert!(a.gaze.neck_twist_deg < -5.0, "to the right: {:?}", a.gaze);
    }

    #[test]
    fn nobody_is_drawn_through_the_floor() {
        let body = Body::load("male_p95", std::path::Path::new(".")).unwrap();
        for stance in [Stance::Standing { shoe_m: 0.03 }, Stance::Seated { seat_height_m: 0.46 }] {
            let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
            let surveyor = Surveyor::new(&body, Side::Right, pelvis, stance).unwrap();
            let bones = surveyor.bones(&DVector::zeros(body.arm(Side::Right).unwrap().dof()));
            let lowest = bones.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min);
            assert!((0.0..0.15).contains(&lowest), "{stance:?}: {lowest}");
        }
    }
}

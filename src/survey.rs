//! From joint angles to body angles and their scores: fills the worksheets from forward kinematics.

mod head;
mod whole;

pub use head::HeadDraw;
pub use whole::{WholePosture, WholeSurveyor, heel_joint};

use crate::ergonomics::Side as ScoreSide;
use crate::ergonomics::{
    ArmAngles, ArmPose, BackAngle, BodyPose, Profile, RulaSteps, Sheet, TaskInputs,
    TrunkNeckAngles, Worksheet, arm_angles, back_angle, rula, trunk_neck_angles, worksheet,
};
use crate::files::InputError;
use crate::human::{
    Balance, Body, Coupled, Head, LegPosture, PosedSkeleton, Segment, Side, Skeleton, Stance,
};
use crate::kinematics::{Frames, Linkage};
use crate::math::{Pose, Rotation, Vec3};
pub(crate) use head::Sight;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// How the head is held.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum NeckRule {
    /// As recorded people hold it, given trunk and hand.
    #[default]
    Predicted,
    /// As predicted, and turned on so far that the eyes find the part.
    #[schemars(skip)]
    Looking,
    /// In line with the trunk.
    Neutral,
    /// Turned to the hand, within the joint limits.
    Gaze,
}

impl NeckRule {
    /// All rules, in the order of [`PostureAngles`].
    const ALL: [Self; 4] = [Self::Predicted, Self::Looking, Self::Neutral, Self::Gaze];
}

/// What varies between one look at the scores and another.
#[derive(Debug, Clone)]
pub struct Lens {
    /// Load, repetition, support, legs.
    pub task: TaskInputs,
    /// How the head is held.
    pub neck: NeckRule,
    /// The other hand holds on too: both share the load, and the worse side counts.
    pub both_hands: bool,
    /// The convention.
    pub profile: Profile,
}

/// The angles of one posture, before any rule about task or neck.
#[derive(Debug, Clone, Copy)]
pub struct PostureAngles {
    /// Trunk and neck by each rule.
    necks: [TrunkNeckAngles; 4],
    /// The arm that holds on to the robot; of both the leading one.
    pub arm: ArmAngles,
    /// The other arm.
    pub other: ArmAngles,
    /// The legs.
    pub legs: LegAngles,
    /// The head as predicted and as it is held to see the part.
    heads: [Head; 2],
    /// How far the centre of mass of somebody who stands is inside the feet, m; negative outside.
    pub margin_m: Option<f64>,
    /// Static moment of everything above L5/S1, and of the load, about L5/S1, N m.
    pub l5s1_nm: f64,
}

/// Of one posture what the scores look at, the head held by one rule.
#[derive(Debug, Clone, Copy)]
pub struct ScoredAngles {
    body: TrunkNeckAngles,
    arm: ArmAngles,
    /// Where it holds on as well.
    other: Option<ArmAngles>,
    legs: LegAngles,
}

impl ScoredAngles {
    fn score_by(
        &self,
        lens: &Lens,
        fill: impl Fn(&TrunkNeckAngles, &ArmAngles, &TaskInputs) -> Worksheet,
    ) -> Sheet {
        let task = self.legs.task(lens);
        let own = Sheet::of(&fill(&self.body, &self.arm, &task), &lens.profile);
        let Some(other) = &self.other else { return own };
        let other = Sheet::of(&fill(&self.body, other, &task), &lens.profile);
        Sheet {
            rula: if other.rula.grand > own.rula.grand { other.rula } else { own.rula },
            reba: if other.reba.total > own.reba.total { other.reba } else { own.reba },
        }
    }
}

/// What can be scored.
pub trait Scorable: Send + Sync {
    /// By all scoring methods.
    fn score(&self, lens: &Lens) -> Sheet;
}

impl Scorable for ScoredAngles {
    fn score(&self, lens: &Lens) -> Sheet {
        self.score_by(lens, |body, arm, task| worksheet(body, arm, task, &lens.profile))
    }
}

impl Scorable for PostureAngles {
    fn score(&self, lens: &Lens) -> Sheet {
        self.scored(lens).score(lens)
    }
}

/// The legs of one posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegAngles {
    /// Knee flexion, right and left, deg.
    pub knees_deg: [f64; 2],
    /// Rise of the heels, the lower one, deg.
    pub heels_deg: f64,
    /// Feet that carry nothing: they hang from a seat, or the heels are up.
    pub is_unstable: bool,
    /// By how much a leg is too short for its foot, m.
    pub short_m: f64,
}

impl LegAngles {
    fn of(legs: &[LegPosture; 2], hang: bool) -> Self {
        let heels_deg = legs[0].heel.min(legs[1].heel).to_degrees();
        Self {
            knees_deg: legs.map(|l| -l.knee.to_degrees()),
            heels_deg,
            is_unstable: hang || heels_deg > ON_TOES_DEG,
            short_m: legs[0].short_m.max(legs[1].short_m),
        }
    }

    /// The task with what the legs do.
    fn task(&self, lens: &Lens) -> TaskInputs {
        let [right, left] = self.knees_deg;
        TaskInputs {
            knee_flex_deg: right.max(left),
            legs_unbalanced: lens.task.legs_unbalanced || self.is_unstable,
            ..lens.task
        }
    }

    /// Of somebody who stands and was recorded: knees, and the lower heel where it is known (deg).
    pub fn recorded(knees_deg: [f64; 2], heels_deg: Option<f64>) -> Self {
        let heels_deg = heels_deg.unwrap_or(0.0);
        Self { knees_deg, heels_deg, is_unstable: heels_deg > ON_TOES_DEG, short_m: 0.0 }
    }
}

/// Rise of both heels from which the person stands on the fore-feet, deg.
const ON_TOES_DEG: f64 = 10.0;
/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.81;

impl PostureAngles {
    /// Trunk and neck under a rule for the head.
    pub fn trunk_neck(&self, rule: NeckRule) -> &TrunkNeckAngles {
        let place = NeckRule::ALL.iter().position(|r| *r == rule).unwrap_or(0);
        &self.necks[place]
    }

    /// Trunk, and the neck of a head that is held otherwise.
    pub fn with_head(&self, head: Head) -> TrunkNeckAngles {
        self.trunk_neck(NeckRule::Neutral).with_head(&head.rotation().to_rotation_matrix())
    }

    /// The head as it is drawn: predicted, or looking at the part; by the old rules as predicted too.
    pub fn head(&self, rule: NeckRule) -> Head {
        self.heads[usize::from(rule == NeckRule::Looking)]
    }

    /// The task with what the legs do.
    pub fn task(&self, lens: &Lens) -> TaskInputs {
        self.legs.task(lens)
    }

    /// What the scores look at.
    pub fn scored(&self, lens: &Lens) -> ScoredAngles {
        let other = lens.both_hands.then_some(self.other);
        ScoredAngles { body: *self.trunk_neck(lens.neck), arm: self.arm, other, legs: self.legs }
    }

    /// By all scoring methods, the sheets filled in by `fill`; of two hands the worse side counts.
    pub fn score_by(
        &self,
        lens: &Lens,
        fill: impl Fn(&TrunkNeckAngles, &ArmAngles, &TaskInputs) -> Worksheet,
    ) -> Sheet {
        self.scored(lens).score_by(lens, fill)
    }

    /// RULA of the other arm: no load, no coupling, unless it holds on too.
    pub fn other_rula(&self, lens: &Lens) -> RulaSteps {
        let task = self.task(lens);
        let task = if lens.both_hands {
            task
        } else {
            TaskInputs { load_kg: 0.0, load_shock: false, arm_supported: false, ..task }
        };
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
    rest: Pose,
    /// The coupled chain with its masses.
    chain: Linkage,
    balance: Balance,
    load_kg: f64,
    coupled: Coupled,
    /// Centres of C7/T1 and of a straight head in the axes of the thorax, m.
    on_thorax: [Vec3; 2],
    /// Legs of a pelvis that rests; none where it moves.
    resting_legs: Option<LegAngles>,
}

/// The segments that scores need, found once.
#[derive(Debug, Clone)]
struct Measured {
    skeleton: Skeleton,
    pelvis: Segment,
    l5: Segment,
    t8: Segment,
    neck: Segment,
    head: Segment,
    grip: Segment,
    /// L3 and T12.
    spine: [Segment; 2],
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
    fn new(
        body: &Body,
        coupled: Coupled,
        stance: Stance,
        with_legs: bool,
    ) -> Result<Self, InputError> {
        let skeleton = Skeleton::new(body, coupled, stance, with_legs)?;
        let still = skeleton.pose(&vec![0.0; skeleton.dof()]);
        let of = |name: &str| skeleton.segment(name);
        let (l5, t8, neck, head) = (of("L5")?, of("T8")?, of("Neck")?, of("Head")?);
        let side = coupled.hands.lead();
        let (pelvis, grip) = (of("Pelvis")?, of(side.grip())?);
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
        let spine = [of("L3")?, of("T12")?];
        Ok(Self { skeleton, pelvis, l5, t8, neck, head, grip, spine, arms })
    }
}

impl Surveyor {
    /// For a body whose rest frame is at `rest` in the world, with a load (kg) in its coupled hands.
    pub fn new(
        body: &Body,
        coupled: Coupled,
        rest: Pose,
        (stance, load_kg): (Stance, f64),
    ) -> Result<Self, InputError> {
        let whole = Skeleton::new(body, coupled, stance, true)?;
        let (bones, head) = (whole.bones()?, whole.segment("Head")?);
        let upper = Measured::new(body, coupled, stance, false)?;
        let links = Balance::links(coupled);
        let names: Vec<&str> = links.iter().map(String::as_str).collect();
        let chain = body.chain(coupled, &names)?;
        let balance = Balance::new(body, coupled, (&chain, whole.legs()), load_kg)?;
        let still = upper.skeleton.pose(&vec![0.0; upper.skeleton.dof()]);
        let on_thorax = [upper.neck, upper.head]
            .map(|s| (still.at(upper.t8).inverse() * still.at(s)).translation.vector);
        let resting_legs = (coupled.pelvis.free() == 0).then(|| {
            let legs = whole.legs();
            LegAngles::of(&legs.postures(&Pose::identity()), legs.hang())
        });
        Ok(Self {
            upper,
            whole,
            bones,
            head,
            rest,
            chain,
            balance,
            load_kg,
            coupled,
            on_thorax,
            resting_legs,
        })
    }

    /// All joints and the pelvis' coordinates by name, in the order of [`Surveyor::whole`].
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.whole.joints()
    }

    /// All coordinates of the body (rad, leg lengths) from those of the coupled chain and the head.
    pub fn whole(&self, q: &DVector<f64>, head: Head) -> Vec<f64> {
        self.whole.whole(q.as_slice(), head)
    }

    /// The load in the coupled hands, kg.
    pub fn load_kg(&self) -> f64 {
        self.load_kg
    }

    /// Body angles of the posture `q` (n coordinates of the coupled chain, rad, leg lengths), the head held
    /// as drawn.
    pub fn measure(&self, q: &DVector<f64>, draw: &HeadDraw) -> PostureAngles {
        let parts = &self.upper;
        let posed = parts.skeleton.pose(&parts.skeleton.whole(q.as_slice(), Head::default()));
        let body = self.body_pose(&posed);
        let neutral = trunk_neck_angles(&body);
        let [arm, other] = parts.arms.map(|a| measure_arm(&posed, &self.rest, a, &body));
        let sight = self.sight(&posed, neutral.trunk_flex_deg.to_radians());
        let heads = [NeckRule::Predicted, NeckRule::Looking].map(|rule| sight.head(rule, draw));
        let necks = NeckRule::ALL.map(|rule| neutral.with_head(&sight.turned(rule, draw)));
        let legs = parts.skeleton.legs();
        let angles = LegAngles::of(&parts.skeleton.leg_postures(q.as_slice()), legs.hang());
        let mut frames = Frames::default();
        self.chain.forward(q.as_slice(), &mut frames);
        let margin_m = legs.is_standing().then(|| {
            let pelvis = parts.skeleton.pelvis(q.as_slice());
            let turn = *pelvis.rotation.to_rotation_matrix().matrix();
            let bending = legs.bending(&pelvis.translation.vector, &turn);
            let centre = self.balance.centre((&self.chain, &frames), (legs, &bending));
            self.balance.margin_m(&centre, angles.heels_deg.to_radians())
        });
        let l5s1_nm = GRAVITY * self.balance.lever_kg_m(&self.chain, &frames);
        PostureAngles { necks, arm, other, legs: angles, heads, margin_m, l5s1_nm }
    }

    /// Of the same posture only what the scores look at; `frames`: scratch.
    pub fn scored(
        &self,
        q: &DVector<f64>,
        draw: &HeadDraw,
        lens: &Lens,
        frames: &mut Frames,
    ) -> ScoredAngles {
        self.chain.forward(q.as_slice(), frames);
        let turn = self.rest.rotation.to_rotation_matrix();
        let at = |tip: usize| {
            let (p, r) = self.chain.tip_frame(frames, tip);
            let place = turn * p + self.rest.translation.vector;
            (place, turn * Rotation::from_matrix_unchecked(r))
        };
        // As `Balance::links` has them.
        let grips = self.coupled.hands.sides().len();
        let [pelvis, l5, t8] = [grips, grips + 1, grips + 4];
        let ((chest, thorax), (l5s1, _)) = (at(t8), at(l5));
        let [neck, head] = self.on_thorax.map(|on_thorax| chest + thorax * on_thorax);
        let body = BodyPose { pelvis: at(pelvis).1, thorax, head: thorax, l5s1, c7t1: neck };
        let neutral = trunk_neck_angles(&body);
        let arm = |i: usize| {
            let first = t8 + 1 + 4 * i;
            let [girdle, upper, fore, hand] = [0, 1, 2, 3].map(|k| at(first + k));
            arm_angles(&body, &self.upper.arms[i].pose(girdle.0, &[upper, fore, hand]))
        };
        let (grip, _) = at(0);
        let sight = Sight::new(&thorax, &head, &grip, neutral.trunk_flex_deg.to_radians());
        let legs = self.resting_legs.unwrap_or_else(|| {
            let skeleton = &self.upper.skeleton;
            LegAngles::of(&skeleton.leg_postures(q.as_slice()), skeleton.legs().hang())
        });
        ScoredAngles {
            body: neutral.with_head(&sight.turned(lens.neck, draw)),
            arm: arm(0),
            other: lens.both_hands.then(|| arm(1)),
            legs,
        }
    }

    /// Rotations of the spine's joints added up in the posture `q` (n, rad, leg lengths).
    pub fn back(&self, q: &DVector<f64>) -> BackAngle {
        let parts = &self.upper;
        let posed = parts.skeleton.pose(&parts.skeleton.whole(q.as_slice(), Head::default()));
        let [l3, t12] = parts.spine;
        let spine = [parts.pelvis, parts.l5, l3, t12, parts.t8].map(|s| rotation(&posed.at(s)));
        back_angle(&std::array::from_fn(|i| spine[i].inverse() * spine[i + 1]))
    }

    /// Trunk, and head in line with it.
    fn body_pose(&self, posed: &PosedSkeleton) -> BodyPose {
        let at = |segment: Segment| self.rest * posed.at(segment);
        let thorax = rotation(&at(self.upper.t8));
        BodyPose {
            pelvis: rotation(&at(self.upper.pelvis)),
            thorax,
            head: thorax,
            l5s1: at(self.upper.l5).translation.vector,
            c7t1: at(self.upper.neck).translation.vector,
        }
    }

    fn sight(&self, posed: &PosedSkeleton, inclination: f64) -> Sight {
        let at = |segment: Segment| self.rest * posed.at(segment);
        let (head, hand) = (at(self.upper.head), at(self.upper.grip));
        let (head, hand) = (head.translation.vector, hand.translation.vector);
        Sight::new(&rotation(&at(self.upper.t8)), &head, &hand, inclination)
    }

    /// Bones as segments in the world, for drawings.
    pub fn bones(&self, q: &DVector<f64>) -> Vec<[[f64; 3]; 2]> {
        self.bones_at(&self.rest, q, Head::default())
    }

    /// The same with the rest frame elsewhere and the head held somehow.
    pub fn bones_at(&self, rest: &Pose, q: &DVector<f64>, head: Head) -> Vec<[[f64; 3]; 2]> {
        let posed = self.whole.pose(&self.whole.whole(q.as_slice(), head));
        let at = |s: Segment| -> [f64; 3] { (rest * posed.at(s)).translation.vector.into() };
        let mut bones: Vec<[[f64; 3]; 2]> = self.bones.iter().map(|pair| pair.map(at)).collect();
        let head = rest * posed.at(self.head);
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
    let at = |segment: Segment| {
        let pose = pelvis * posed.at(segment);
        (pose.translation.vector, rotation(&pose))
    };
    let limb = [segments.upper, segments.fore, segments.hand].map(at);
    segments.pose(at(segments.girdle).0, &limb)
}

impl ArmSegments {
    /// The arm with the inner end of its girdle somewhere, and its limb: upper arm, forearm and hand.
    fn pose(&self, girdle: Vec3, limb: &[(Vec3, Rotation); 3]) -> ArmPose {
        let [(shoulder, upper_arm), (elbow, forearm), (wrist, hand)] = *limb;
        ArmPose {
            side: match self.side {
                Side::Right => ScoreSide::Right,
                Side::Left => ScoreSide::Left,
            },
            upper_arm,
            forearm,
            hand,
            shoulder,
            elbow,
            wrist,
            sternoclavicular: girdle,
            // The clavicle of our bodies is level at zero.
            girdle_neutral_deg: 0.0,
            shoulder_lateral_m: self.shoulder_lateral_m,
        }
    }
}

/// Head that faces a hand.
fn gaze(thorax: &Pose, head_at: &Vec3, hand: &Vec3) -> Rotation {
    let thorax = rotation(thorax);
    let sight = Sight::new(&thorax, head_at, hand, 0.0);
    thorax * sight.turned(NeckRule::Gaze, &HeadDraw::default())
}

fn rotation(pose: &Pose) -> Rotation {
    pose.rotation.to_rotation_matrix()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surveyor(side: Side) -> (Body, Surveyor) {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let stance = Stance::Standing { shoe_m: 0.03 };
        let pelvis = body.pelvis_pose([1.0, -2.0], 0.7, stance);
        let arm = Coupled::arm(side);
        let surveyor = Surveyor::new(&body, arm, pelvis, (stance, 0.0)).unwrap();
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
        surveyor.measure(&q, &HeadDraw::default())
    }

    #[test]
    fn a_neutral_posture_measures_zero() {
        let a = angles(Side::Right, &[("jRightElbow_Y", 90.0)]);
        for value in [
            a.trunk_neck(NeckRule::Neutral).trunk_flex_deg,
            a.trunk_neck(NeckRule::Neutral).trunk_side_deg,
            a.trunk_neck(NeckRule::Neutral).trunk_twist_deg,
            a.trunk_neck(NeckRule::Neutral).neck_flex_deg,
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
        near(bent.trunk_neck(NeckRule::Neutral).trunk_flex_deg, 25.0);
        near(bent.trunk_neck(NeckRule::Neutral).neck_flex_deg, 0.0);
        near(
            angles(Side::Right, &[("jT9T8_Y", 20.0)]).trunk_neck(NeckRule::Neutral).trunk_twist_deg,
            20.0,
        );
        // The left side counts the same way.
        near(angles(Side::Left, &[("jLeftElbow_Y", -130.0)]).arm.wrist_twist_deg, 40.0);
        near(angles(Side::Left, &[("jLeftShoulder_X", 40.0)]).arm.upper_arm_abduction_deg, 40.0);
    }

    #[test]
    fn a_head_that_is_held_otherwise_turns_the_neck_only() {
        let (_, surveyor) = surveyor(Side::Right);
        let q = DVector::from_fn(24, |i, _| 0.02 * (i as f64 - 12.0));
        let a = surveyor.measure(&q, &HeadDraw::mean(Some(Side::Right)));
        let again = a.with_head(a.head(NeckRule::Predicted));
        let own = a.trunk_neck(NeckRule::Predicted);
        for (again, own) in [
            (again.neck_flex_deg, own.neck_flex_deg),
            (again.neck_side_deg, own.neck_side_deg),
            (again.neck_twist_deg, own.neck_twist_deg),
            (again.trunk_flex_deg, own.trunk_flex_deg),
            (again.trunk_twist_deg, own.trunk_twist_deg),
        ] {
            assert!((again - own).abs() < 1e-9, "{again} {own}");
        }
        let straight = a.with_head(Head::default());
        assert!(straight.neck_flex_deg.abs() < 1e-9 && straight.neck_twist_deg.abs() < 1e-9);
        assert!(own.neck_flex_deg.abs() > 0.1 && own.neck_twist_deg.abs() > 0.1);
    }

    #[test]
    fn what_is_scored_is_a_part_of_what_is_measured() {
        use crate::human::{Hands, Pelvis};
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        let standing = Stance::Standing { shoe_m: 0.03 };
        let seated = Stance::Seated { seat_height_m: 0.6, footrest_m: 0.0 };
        for (hands, pelvis, stance) in [
            (Hands::Right, Pelvis::Rests, standing),
            (Hands::Left, Pelvis::Turns, seated),
            (Hands::Both, Pelvis::Moves, standing),
        ] {
            let rest = body.pelvis_pose([0.4, -0.2], 0.9, stance);
            let coupled = Coupled { hands, pelvis };
            let surveyor = Surveyor::new(&body, coupled, rest, (stance, 2.0)).unwrap();
            let dof = body.chain(coupled, &[]).unwrap().dof();
            let draw = HeadDraw::mean((hands != Hands::Both).then(|| hands.lead()));
            for (rule, k) in NeckRule::ALL.into_iter().zip(0..) {
                let profile = Profile::default();
                let task = TaskInputs::default();
                let lens = Lens { task, neck: rule, both_hands: hands == Hands::Both, profile };
                let q = DVector::from_fn(dof, |i, _| 0.3 * f64::sin((7 * i + k) as f64));
                let whole = surveyor.measure(&q, &draw).scored(&lens);
                let part = surveyor.scored(&q, &draw, &lens, &mut Frames::default());
                let all = |a: &ScoredAngles| {
                    let (t, l) = (a.body, a.legs);
                    let arms = [Some(a.arm), a.other].into_iter().flatten().flat_map(|a| {
                        [
                            a.upper_arm_flex_deg,
                            a.upper_arm_abduction_deg,
                            a.upper_arm_elevation_deg,
                            a.girdle_elevation_deg,
                            a.elbow_flex_deg,
                            a.wrist_flex_deg,
                            a.wrist_deviation_deg,
                            a.wrist_twist_deg,
                            a.wrist_lateral_m,
                            a.wrist_beyond_shoulder_m,
                        ]
                    });
                    [
                        t.trunk_flex_deg,
                        t.trunk_side_deg,
                        t.trunk_twist_deg,
                        t.neck_flex_deg,
                        t.neck_side_deg,
                        t.neck_twist_deg,
                        l.knees_deg[0],
                        l.knees_deg[1],
                        l.heels_deg,
                    ]
                    .into_iter()
                    .chain(arms)
                    .collect::<Vec<f64>>()
                };
                let (whole, part) = (all(&whole), all(&part));
                assert_eq!(whole.len(), if hands == Hands::Both { 29 } else { 19 });
                for (a, b) in whole.iter().zip(&part) {
                    assert!((a - b).abs() < 1e-7, "{hands:?} {rule:?}: {whole:?} {part:?}");
                }
            }
        }
    }

    #[test]
    fn recorded_feet_carry_unless_both_heels_are_up() {
        let legs = |heels| LegAngles::recorded([20.0, 40.0], heels);
        assert!(!legs(None).is_unstable && !legs(Some(9.0)).is_unstable);
        assert!(legs(Some(11.0)).is_unstable);
    }

    #[test]
    fn the_gaze_follows_a_low_hand() {
        let a = angles(Side::Right, &[("jRightShoulder_Z", 45.0), ("jRightElbow_Y", 90.0)]);
        let gaze = a.trunk_neck(NeckRule::Gaze);
        assert!(gaze.neck_flex_deg > 20.0, "{gaze:?}");
        assert!(gaze.neck_twist_deg < -5.0, "to the right: {gaze:?}");
    }

    #[test]
    fn nobody_is_drawn_through_the_floor() {
        let body = Body::load("male_p95", std::path::Path::new(".")).unwrap();
        let seated = Stance::Seated { seat_height_m: 0.46, footrest_m: 0.0 };
        for stance in [Stance::Standing { shoe_m: 0.03 }, seated] {
            let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
            let arm = Coupled::arm(Side::Right);
            let surveyor = Surveyor::new(&body, arm, pelvis, (stance, 0.0)).unwrap();
            let bones = surveyor.bones(&DVector::zeros(body.arm(Side::Right).unwrap().dof()));
            let lowest = bones.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min);
            assert!((0.0..0.15).contains(&lowest), "{stance:?}: {lowest}");
        }
    }
}

//! A whole posture: trunk, neck, both arms and knees from all joint angles of a body.

use super::{Measured, ON_TOES_DEG, gaze, measure_arm, rotation};
use crate::ergonomics::{
    ArmAngles, BackAngle, BodyPose, TrunkNeckAngles, back_angle, trunk_neck_angles,
};
use crate::files::InputError;
use crate::human::{Body, Coupled, Segment, Side, Stance};
use crate::math::{Pose, Rotation, Vec3};

/// Body angles of one posture with both arms. What nobody measured or predicted is `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WholePosture {
    /// Trunk, and neck in line with it.
    pub neutral: TrunkNeckAngles,
    /// Trunk, and head turned to the right and to the left hand.
    pub gaze: [TrunkNeckAngles; 2],
    /// Trunk, and neck as it is.
    pub neck: Option<TrunkNeckAngles>,
    /// Right and left arm.
    pub arms: [Option<ArmAngles>; 2],
    /// Knee flexion, right and left, deg.
    pub knees_deg: Option<[f64; 2]>,
    /// Rise of the heels over the balls of the feet, the lower one, deg.
    pub heels_deg: Option<f64>,
    /// Horizontal distance of the right and the left wrist from L5/S1, m.
    pub reach_m: [f64; 2],
    /// Right and left wrist in the world, m.
    pub hands_m: [Vec3; 2],
    /// Point midway between the ankles in the world, m.
    pub ankles_m: Vec3,
    /// Forward direction of the pelvis in the world.
    pub facing: Vec3,
    /// The spine's joints added up.
    pub back: BackAngle,
}

/// Place of a side in the pairs of a [`WholePosture`].
fn place(side: Side) -> usize {
    match side {
        Side::Right => 0,
        Side::Left => 1,
    }
}

impl WholePosture {
    /// The arm of a side.
    pub fn arm(&self, side: Side) -> Option<&ArmAngles> {
        self.arms[place(side)].as_ref()
    }

    /// Horizontal distance of a side's wrist from L5/S1, m.
    pub fn reach_m(&self, side: Side) -> f64 {
        self.reach_m[place(side)]
    }

    /// The wrist of a side in the world, m.
    pub fn hand_m(&self, side: Side) -> Vec3 {
        self.hands_m[place(side)]
    }

    /// Trunk, and head turned to the hand of a side.
    pub fn gaze(&self, side: Side) -> &TrunkNeckAngles {
        &self.gaze[place(side)]
    }
}

/// Poses all joints of a body and measures it.
#[derive(Debug, Clone)]
pub struct WholeSurveyor {
    parts: Measured,
    /// Hip, knee and ankle of the right and the left leg.
    legs: [[Segment; 3]; 2],
    /// Right and left arm chain: columns of all joints in the order of the chain.
    chains: [Vec<usize>; 2],
    /// Columns of the balls' joints.
    heels: Option<[usize; 2]>,
    /// L3 and T12, between L5 and T8.
    spine: [Segment; 2],
    chain_names: [Vec<String>; 2],
}

impl WholeSurveyor {
    /// For a body.
    pub fn new(body: &Body) -> Result<Self, InputError> {
        let standing = Stance::Standing { shoe_m: 0.0 };
        let parts = Measured::new(body, Coupled::arm(Side::Right), standing, true)?;
        let leg = |side: Side| {
            let of = |part: &str| parts.skeleton.segment(&format!("{}{part}", side.prefix()));
            Ok::<_, InputError>([of("UpperLeg")?, of("LowerLeg")?, of("Foot")?])
        };
        let spine = [parts.skeleton.segment("L3")?, parts.skeleton.segment("T12")?];
        let legs = [leg(Side::Right)?, leg(Side::Left)?];
        let names = |side: Side| -> Result<Vec<String>, InputError> {
            Ok(body.arm(side)?.joints().iter().map(|j| j.name.clone()).collect())
        };
        let chain_names = [names(Side::Right)?, names(Side::Left)?];
        let columns = |names: &Vec<String>| -> Vec<usize> {
            names.iter().filter_map(|n| parts.skeleton.column(n)).collect()
        };
        let chains = [columns(&chain_names[0]), columns(&chain_names[1])];
        let ball = |side: Side| parts.skeleton.column(&heel_joint(side));
        let heels = ball(Side::Right).zip(ball(Side::Left)).map(|(right, left)| [right, left]);
        Ok(Self { parts, legs, chains, heels, spine, chain_names })
    }

    /// Number of joint angles.
    pub fn dof(&self) -> usize {
        self.parts.skeleton.dof()
    }

    /// Names of the pelvis' coordinates and the joints, in the order of the columns.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.parts.skeleton.joints()
    }

    /// Column of a joint.
    pub fn column(&self, joint: &str) -> Option<usize> {
        self.parts.skeleton.column(joint)
    }

    /// Columns of the joints from the pelvis to the grip of a side, in the order of the chain.
    pub fn chain(&self, side: Side) -> &[usize] {
        &self.chains[place(side)]
    }

    /// Names of those joints.
    pub fn chain_joints(&self, side: Side) -> impl Iterator<Item = &str> {
        self.chain_names[place(side)].iter().map(String::as_str)
    }

    /// Measures a posture: all coordinates (rad, leg lengths) and the rest frame in the world. Everything
    /// is filled in; the caller takes out what its angles do not know. `head_in_thorax` replaces the
    /// neck of the body by a measured one.
    pub fn measure(
        &self,
        q: &[f64],
        rest: &Pose,
        head_in_thorax: Option<&Rotation>,
    ) -> WholePosture {
        let parts = &self.parts;
        let posed = parts.skeleton.pose(q);
        let at = |segment: Segment| rest * posed.at(segment);
        let pelvis = at(parts.pelvis);
        let thorax = at(parts.t8);
        let mut body = BodyPose {
            pelvis: rotation(&pelvis),
            thorax: rotation(&thorax),
            head: rotation(&thorax),
            l5s1: at(parts.l5).translation.vector,
            c7t1: at(parts.neck).translation.vector,
        };
        let neutral = trunk_neck_angles(&body).with_head(&Rotation::identity());
        let arms = parts.arms.map(|a| Some(measure_arm(&posed, rest, a, &body)));
        let wrists = parts.arms.map(|a| at(a.hand).translation.vector);
        let head_at = at(parts.head).translation.vector;
        let seen = wrists.map(|hand| {
            body.head = gaze(&thorax, &head_at, &hand);
            trunk_neck_angles(&body)
        });
        body.head =
            head_in_thorax.map_or_else(|| rotation(&at(parts.head)), |turned| body.thorax * turned);
        let neck = trunk_neck_angles(&body);
        let reach_m = wrists.map(|w| (w - body.l5s1).xy().norm());
        let knees = self.legs.map(|leg| bend_deg(leg.map(|s| at(s).translation.vector)));
        let ankles = self.legs.map(|leg| at(leg[2]).translation.vector);
        let spine: [Rotation; 5] = [
            rotation(&pelvis),
            rotation(&at(parts.l5)),
            rotation(&at(self.spine[0])),
            rotation(&at(self.spine[1])),
            body.thorax,
        ];
        WholePosture {
            hands_m: wrists,
            ankles_m: (ankles[0] + ankles[1]) * 0.5,
            facing: pelvis.rotation * Vec3::x(),
            back: back_angle(&std::array::from_fn(|i| spine[i].inverse() * spine[i + 1])),
            neutral,
            gaze: seen,
            neck: Some(neck),
            arms,
            knees_deg: Some(knees),
            heels_deg: self.heels.map(|[right, left]| q[right].min(q[left]).to_degrees()),
            reach_m,
        }
    }
}

/// The joint about which a heel rises.
pub fn heel_joint(side: Side) -> String {
    format!("j{}BallFoot_Z", side.prefix())
}

impl WholePosture {
    /// Whether both heels are up, so that the fore-feet alone carry.
    pub fn is_on_toes(&self) -> bool {
        self.heels_deg.is_some_and(|h| h > ON_TOES_DEG)
    }
}

/// Angle at the middle of three points, 0 for a straight line, deg.
fn bend_deg([a, b, c]: [Vec3; 3]) -> f64 {
    let (u, v) = (b - a, c - b);
    u.cross(&v).norm().atan2(u.dot(&v)).to_degrees()
}

impl WholePosture {
    /// Takes over the arm of a side, with its reach and the gaze to its hand.
    pub fn take_arm(&mut self, side: Side, from: &Self) {
        let i = place(side);
        self.arms[i] = from.arms[i];
        self.reach_m[i] = from.reach_m[i];
        self.hands_m[i] = from.hands_m[i];
        self.gaze[i] = from.gaze[i];
    }

    /// Knee flexion by the joint centres of hip, knee and ankle, deg.
    pub fn knee_from_points(hip: &Vec3, knee: &Vec3, ankle: &Vec3) -> f64 {
        bend_deg([*hip, *knee, *ankle])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{HeadDraw, NeckRule, Surveyor};
    use nalgebra::DVector;
    use std::path::Path;

    #[test]
    fn both_arms_neck_and_knees_are_measured() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let surveyor = WholeSurveyor::new(&body).unwrap();
        let pelvis = body.pelvis_pose([1.0, -2.0], 0.7, Stance::Standing { shoe_m: 0.03 });
        let mut q = vec![0.0; surveyor.dof()];
        assert_eq!(q.len(), 72);
        for (joint, deg) in [
            ("jRightShoulder_Z", 50.0),
            ("jLeftElbow_Z", 70.0),
            ("jT1C7_Z", -10.0),
            ("jC1Head_Z", -15.0),
            ("jLeftKnee_Z", -40.0),
        ] {
            q[surveyor.column(joint).unwrap()] = f64::to_radians(deg);
        }
        let p = surveyor.measure(&q, &pelvis, None);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        near(p.arms[0].unwrap().upper_arm_flex_deg, 50.0);
        near(p.arm(Side::Left).unwrap().elbow_flex_deg, 70.0);
        near(p.arm(Side::Left).unwrap().upper_arm_flex_deg, 0.0);
        near(p.neck.unwrap().neck_flex_deg, 25.0);
        near(p.neutral.neck_flex_deg, 0.0);
        near(p.knees_deg.unwrap()[0], 0.0);
        near(p.knees_deg.unwrap()[1], 40.0);
        let turned = Rotation::from_axis_angle(&Vec3::y_axis(), 0.5);
        let p = surveyor.measure(&q, &pelvis, Some(&turned));
        near(p.neck.unwrap().neck_twist_deg, 0.5f64.to_degrees());
    }

    #[test]
    fn the_coupled_arm_measures_as_in_a_plan() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let stance = Stance::Seated { seat_height_m: 0.45, footrest_m: 0.0 };
        let pelvis = body.pelvis_pose([0.3, 0.1], -1.0, stance);
        for side in [Side::Right, Side::Left] {
            let arm = Coupled::arm(side);
            let plan = Surveyor::new(&body, arm, pelvis, (stance, 0.0)).unwrap();
            let whole = WholeSurveyor::new(&body).unwrap();
            let chain = DVector::from_fn(24, |i, _| 0.1 * ((i * 7 % 11) as f64 - 5.0) / 5.0);
            let mut q = vec![0.0; whole.dof()];
            for (c, v) in whole.chain(side).iter().zip(&chain) {
                q[*c] = *v;
            }
            let a = plan.measure(&chain, &HeadDraw::default());
            let b = whole.measure(&q, &pelvis, None);
            assert_eq!(*a.trunk_neck(NeckRule::Neutral), b.neutral);
            assert_eq!(a.arm, *b.arm(side).unwrap());
        }
    }
}

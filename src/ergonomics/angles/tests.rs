//! Tests of the body angles: known postures, mirror symmetry, and no posture without an answer.

#![allow(clippy::float_cmp, reason = "mirrored postures must agree to the last bit")]

use super::*;
use approx::assert_relative_eq;
use nalgebra::{Matrix3, UnitQuaternion};
use proptest::prelude::*;

/// ISB axes of a person who stands upright and faces world x.
fn standing() -> Rotation {
    let axes = [Vec3::x(), Vec3::z(), -Vec3::y()];
    Rotation::from_matrix_unchecked(Matrix3::from_columns(&axes))
}

fn about(axis: Vec3, deg: f64) -> Rotation {
    Rotation::from_axis_angle(&nalgebra::Unit::new_normalize(axis), deg.to_radians())
}

/// A body whose segments are turned from standing by rotations in their parent's axes.
fn body(pelvis: Rotation, trunk: Rotation, neck: Rotation) -> BodyPose {
    let pelvis = standing() * pelvis;
    let thorax = pelvis * trunk;
    let l5s1 = Vec3::new(0.1, -0.2, 1.0);
    BodyPose { pelvis, thorax, head: thorax * neck, l5s1, c7t1: l5s1 + thorax * Vec3::y() * 0.5 }
}

/// An arm whose joints turn in their parent's axes from the anatomical zero.
fn arm(body: &BodyPose, side: Side, joints: [Rotation; 3]) -> ArmPose {
    let s = side.outward();
    let upper_arm = body.thorax * joints[0];
    let forearm = upper_arm * joints[1];
    let shoulder = body.c7t1 + body.thorax * Vec3::new(0.0, -0.05, s * 0.18);
    let elbow = shoulder + upper_arm * Vec3::new(0.0, -0.3, 0.0);
    ArmPose {
        side,
        upper_arm,
        forearm,
        hand: forearm * joints[2],
        shoulder,
        elbow,
        wrist: elbow + forearm * Vec3::new(0.0, -0.25, 0.0),
        sternoclavicular: body.c7t1 + body.thorax * Vec3::new(0.06, -0.05, s * 0.02),
        girdle_neutral_deg: 0.0,
        shoulder_lateral_m: 0.18,
    }
}

fn still() -> Rotation {
    Rotation::identity()
}

/// Reflects a rotation of a segment in the sagittal plane of world and body.
fn mirrored(r: &Rotation) -> Rotation {
    let world = Matrix3::from_diagonal(&Vec3::new(1.0, -1.0, 1.0));
    let segment = Matrix3::from_diagonal(&Vec3::new(1.0, 1.0, -1.0));
    Rotation::from_matrix_unchecked(world * r.matrix() * segment)
}

fn mirrored_point(p: &Vec3) -> Vec3 {
    Vec3::new(p.x, -p.y, p.z)
}

fn mirrored_body(b: &BodyPose) -> BodyPose {
    BodyPose {
        pelvis: mirrored(&b.pelvis),
        thorax: mirrored(&b.thorax),
        head: mirrored(&b.head),
        l5s1: mirrored_point(&b.l5s1),
        c7t1: mirrored_point(&b.c7t1),
    }
}

fn mirrored_arm(a: &ArmPose) -> ArmPose {
    ArmPose {
        side: if a.side == Side::Left { Side::Right } else { Side::Left },
        upper_arm: mirrored(&a.upper_arm),
        forearm: mirrored(&a.forearm),
        hand: mirrored(&a.hand),
        shoulder: mirrored_point(&a.shoulder),
        elbow: mirrored_point(&a.elbow),
        wrist: mirrored_point(&a.wrist),
        sternoclavicular: mirrored_point(&a.sternoclavicular),
        ..a.clone()
    }
}

fn trunk_values(t: &TrunkNeckAngles) -> [f64; 6] {
    [
        t.trunk_flex_deg,
        t.neck_flex_deg,
        t.trunk_side_deg,
        t.trunk_twist_deg,
        t.neck_side_deg,
        t.neck_twist_deg,
    ]
}

fn arm_values(a: &ArmAngles) -> [f64; 10] {
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
}

#[test]
fn standing_still_is_zero_but_for_the_palm() {
    let b = body(still(), still(), still());
    for v in trunk_values(&trunk_neck_angles(&b)) {
        assert_relative_eq!(v, 0.0, epsilon = 1e-9);
    }
    for side in [Side::Left, Side::Right] {
        let a = arm_angles(&b, &arm(&b, side, [still(); 3]));
        let expected = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -90.0, 0.18, 0.0];
        for (v, e) in arm_values(&a).iter().zip(expected) {
            assert_relative_eq!(*v, e, epsilon = 1e-6);
        }
    }
}

#[test]
fn trunk_and_neck_of_known_postures() {
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    // ISB: flexion turns about -z, right bend about +x, left twist about +y.
    let t = |p, s, n| trunk_neck_angles(&body(p, s, n));
    assert_relative_eq!(t(still(), about(z, -40.0), still()).trunk_flex_deg, 40.0, epsilon = 1e-9);
    assert_relative_eq!(t(still(), about(x, 15.0), still()).trunk_side_deg, 15.0, epsilon = 1e-9);
    assert_relative_eq!(t(still(), about(y, 30.0), still()).trunk_twist_deg, 30.0, epsilon = 1e-9);
    // Leaning from the hips counts as trunk flexion, beyond the horizontal too.
    let hips = t(about(z, -50.0), about(z, -60.0), still());
    assert_relative_eq!(hips.trunk_flex_deg, 110.0, epsilon = 1e-9);
    // Facing another way changes nothing.
    let turned = t(about(y, 70.0), about(z, -25.0), about(z, 12.0));
    assert_relative_eq!(turned.trunk_flex_deg, 25.0, epsilon = 1e-9);
    assert_relative_eq!(turned.trunk_side_deg, 0.0, epsilon = 1e-9);
    assert_relative_eq!(turned.neck_flex_deg, -12.0, epsilon = 1e-9);
    // The neck is measured to the thorax, and its twist apart from its bend.
    let neck = t(still(), about(z, -30.0), about(x, 8.0) * about(y, 20.0));
    assert_relative_eq!(neck.neck_side_deg, 8.0, epsilon = 1e-9);
    assert_relative_eq!(neck.neck_twist_deg, 20.0, epsilon = 1e-9);
}

#[test]
fn arm_raised_sideways_does_not_jump_to_flexion() {
    let b = body(still(), still(), still());
    let mut last = None;
    for deg in 60..=120 {
        // 3 deg forward of the frontal plane: about a horizontal axis 3 deg off x.
        let axis = Vec3::new(3.0f64.to_radians().cos(), 0.0, 3.0f64.to_radians().sin());
        let joint = about(axis, -f64::from(deg));
        let a = arm_angles(&b, &arm(&b, Side::Right, [joint, still(), still()]));
        assert_relative_eq!(a.upper_arm_elevation_deg, f64::from(deg), epsilon = 1e-9);
        assert!(a.upper_arm_flex_deg.abs() < 8.0, "{a:?}");
        assert!(a.upper_arm_flex_deg.abs() < 6.0 || deg > 110, "{a:?}");
        assert!((a.upper_arm_abduction_deg - f64::from(deg)).abs() < 0.2, "{a:?}");
        let step =
            last.replace(a.upper_arm_flex_deg).map_or(0.0, |l: f64| l - a.upper_arm_flex_deg);
        assert!(step.abs() < 0.1);
    }
}

#[test]
fn arm_of_known_postures() {
    let z = Vec3::z();
    let b = body(about(z, -30.0), about(Vec3::y(), 20.0), still());
    for side in [Side::Left, Side::Right] {
        let s = side.outward();
        let pronate = |deg: f64| about(Vec3::y(), s * deg);
        // Flexion of shoulder, elbow and wrist; half the pronation at the elbow, half at the wrist.
        let joints =
            [about(z, 70.0), about(z, 85.0) * pronate(50.0), pronate(40.0) * about(z, 25.0)];
        let a = arm_angles(&b, &arm(&b, side, joints));
        assert_relative_eq!(a.upper_arm_flex_deg, 70.0, epsilon = 1e-9);
        assert_relative_eq!(a.upper_arm_abduction_deg, 0.0, epsilon = 1e-9);
        assert_relative_eq!(a.elbow_flex_deg, 85.0, epsilon = 1e-9);
        assert_relative_eq!(a.wrist_flex_deg, 25.0, epsilon = 1e-9);
        assert_relative_eq!(a.wrist_deviation_deg, 0.0, epsilon = 1e-9);
        assert_relative_eq!(a.wrist_twist_deg, 0.0, epsilon = 1e-9);
        // The thumb is outward at the anatomical zero: towards it is radial.
        let radial = [about(z, -35.0), still(), about(Vec3::x(), -s * 12.0)];
        let a = arm_angles(&b, &arm(&b, side, radial));
        assert_relative_eq!(a.upper_arm_flex_deg, -35.0, epsilon = 1e-9);
        assert_relative_eq!(a.wrist_deviation_deg, 12.0, epsilon = 1e-9);
        // Full pronation, a little past the wrap of the axial angle.
        let palm_back = [still(), pronate(100.0), pronate(85.0)];
        let twist = arm_angles(&b, &arm(&b, side, palm_back)).wrist_twist_deg;
        assert_relative_eq!(twist, 95.0, epsilon = 1e-9);
    }
}

#[test]
fn a_lifted_girdle_and_a_hand_across_are_seen() {
    let b = body(still(), still(), still());
    let mut a = arm(&b, Side::Right, [about(Vec3::y(), 60.0), about(Vec3::z(), 90.0), still()]);
    a.girdle_neutral_deg = 4.0;
    a.shoulder += b.thorax * Vec3::new(0.0, 0.16, 0.0);
    a.sternoclavicular.x = a.shoulder.x;
    let angles = arm_angles(&b, &a);
    assert_relative_eq!(angles.girdle_elevation_deg, 41.0, epsilon = 1e-9);
    assert!(angles.wrist_lateral_m < 0.0, "{angles:?}");
}

#[test]
fn degenerate_postures_have_an_answer() {
    let b = body(still(), still(), about(Vec3::z(), 180.0));
    let t = trunk_neck_angles(&b);
    assert_relative_eq!(t.neck_flex_deg.abs(), 180.0, epsilon = 1e-6);
    // Arm straight up: counts as flexion.
    let up = arm_angles(&b, &arm(&b, Side::Left, [about(Vec3::z(), 180.0), still(), still()]));
    assert_relative_eq!(up.upper_arm_elevation_deg, 180.0, epsilon = 1e-6);
    assert_relative_eq!(up.upper_arm_flex_deg, 180.0, epsilon = 1e-6);
    // All points in one place, and a person lying on the back: finite all the same.
    let mut lying = body(about(Vec3::z(), 90.0), still(), still());
    lying.c7t1 = lying.l5s1;
    let mut folded = arm(&lying, Side::Right, [still(); 3]);
    (folded.elbow, folded.wrist) = (folded.shoulder, folded.shoulder);
    folded.sternoclavicular = folded.shoulder;
    assert!(trunk_values(&trunk_neck_angles(&lying)).iter().all(|v| v.is_finite()));
    let a = arm_angles(&lying, &folded);
    assert!(arm_values(&a).iter().all(|v| v.is_finite()));
    assert_relative_eq!(a.elbow_flex_deg, 0.0, epsilon = 1e-9);
}

fn rotation() -> impl Strategy<Value = Rotation> {
    // Right angles come often: that is where formulas break.
    let angle = || prop_oneof![-180.0..180.0, Just(0.0), Just(90.0), Just(-90.0), Just(180.0)];
    (angle(), angle(), angle()).prop_map(|(a, b, c)| {
        let radians = [a, b, c].map(f64::to_radians);
        UnitQuaternion::from_euler_angles(radians[0], radians[1], radians[2]).to_rotation_matrix()
    })
}

proptest! {
    #[test]
    fn every_posture_has_finite_angles_and_mirrors_exactly(
        r in prop::array::uniform6(rotation()),
        offset in prop::array::uniform3(-0.2..0.2f64),
        left in any::<bool>(),
    ) {
        let mut b = body(r[0], r[1], r[2]);
        b.c7t1 += Vec3::from(offset);
        let side = if left { Side::Left } else { Side::Right };
        let a = arm(&b, side, [r[3], r[4], r[5]]);
        let trunk = trunk_values(&trunk_neck_angles(&b));
        let angles = arm_values(&arm_angles(&b, &a));
        prop_assert!(trunk.iter().chain(&angles).all(|v| v.is_finite()));
        prop_assert!((0.0..=180.0).contains(&angles[2]) && (0.0..=180.0).contains(&angles[4]));
        prop_assert!(angles[0].hypot(angles[1]) <= angles[2] + 1e-9);
        prop_assert!(angles[7] > -180.0 && angles[7] <= 180.0);

        let (mb, ma) = (mirrored_body(&b), mirrored_arm(&a));
        let other = trunk_values(&trunk_neck_angles(&mb));
        prop_assert_eq!(arm_values(&arm_angles(&mb, &ma)), angles);
        for i in 0..6 {
            let sign = if i < 2 { 1.0 } else { -1.0 };
            // Half a turn to the left is half a turn to the right.
            let same = other[i] == sign * trunk[i] || (i > 2 && trunk[i].abs() == 180.0);
            prop_assert!(same, "{} {:?} {:?}", i, trunk, other);
        }
    }
}

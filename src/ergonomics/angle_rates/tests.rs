//! Tests of the rates: against central differences, and at the postures where formulas break.

use super::*;
use crate::ergonomics::{Side, arm_angles, trunk_neck_angles};
use nalgebra::UnitQuaternion;
use proptest::prelude::*;

/// The pose after a time of constant velocities.
fn moved(
    body: &BodyPose,
    arm: &ArmPose,
    rates: &(BodyRates, ArmRates),
    t: f64,
) -> (BodyPose, ArmPose) {
    let turn = |r: &Rotation, spin: &Vec3| Rotation::from_scaled_axis(spin * t) * r;
    let (b, a) = rates;
    (
        BodyPose {
            pelvis: turn(&body.pelvis, &b.pelvis),
            thorax: turn(&body.thorax, &b.thorax),
            head: turn(&body.head, &b.head),
            l5s1: body.l5s1 + b.l5s1 * t,
            c7t1: body.c7t1 + b.c7t1 * t,
        },
        ArmPose {
            upper_arm: turn(&arm.upper_arm, &a.upper_arm),
            forearm: turn(&arm.forearm, &a.forearm),
            hand: turn(&arm.hand, &a.hand),
            shoulder: arm.shoulder + a.shoulder * t,
            elbow: arm.elbow + a.elbow * t,
            wrist: arm.wrist + a.wrist * t,
            sternoclavicular: arm.sternoclavicular + a.sternoclavicular * t,
            shoulder_lateral_m: arm.shoulder_lateral_m + a.shoulder_lateral_m * t,
            ..arm.clone()
        },
    )
}

fn values(b: &TrunkNeckAngles, a: &ArmAngles) -> [f64; 16] {
    [
        b.trunk_flex_deg,
        b.trunk_side_deg,
        b.trunk_twist_deg,
        b.neck_flex_deg,
        b.neck_side_deg,
        b.neck_twist_deg,
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

fn angles(body: &BodyPose, arm: &ArmPose) -> [f64; 16] {
    values(&trunk_neck_angles(body), &arm_angles(body, arm))
}

fn rates_of(body: &BodyPose, arm: &ArmPose, rates: &(BodyRates, ArmRates)) -> [f64; 16] {
    values(&trunk_neck_rates(body, &rates.0), &arm_rates(body, arm, &rates.0, &rates.1))
}

/// Central differences of fourth order; half a turn may wrap. `None` where the step is too wide for
/// the angle's curvature, next to a posture in which it has no derivative.
fn differences(body: &BodyPose, arm: &ArmPose, rates: &(BodyRates, ArmRates)) -> [Option<f64>; 16] {
    let slopes = |h: f64| -> [f64; 16] {
        let at = |t: f64| {
            let (b, a) = moved(body, arm, rates, t);
            angles(&b, &a)
        };
        let (before, after) = (at(-h), at(h));
        std::array::from_fn(|i| {
            let step = after[i] - before[i];
            (if step.abs() > 180.0 { step - step.signum() * 360.0 } else { step }) / (2.0 * h)
        })
    };
    let (near, wide) = (slopes(1e-5), slopes(2e-5));
    std::array::from_fn(|i| {
        let converged = (near[i] - wide[i]).abs() < 1e-5 * near[i].abs().max(100.0);
        converged.then_some((4.0 * near[i] - wide[i]) / 3.0)
    })
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from)
}

fn rotation() -> impl Strategy<Value = Rotation> {
    prop::array::uniform3(-3.0..3.0f64)
        .prop_map(|v| UnitQuaternion::from_euler_angles(v[0], v[1], v[2]).to_rotation_matrix())
}

fn rates() -> impl Strategy<Value = (BodyRates, ArmRates)> {
    (prop::array::uniform5(vector()), prop::array::uniform7(vector())).prop_map(|(b, a)| {
        let body = BodyRates { pelvis: b[0], thorax: b[1], head: b[2], l5s1: b[3], c7t1: b[4] };
        let arm = ArmRates {
            upper_arm: a[0],
            forearm: a[1],
            hand: a[2],
            shoulder: a[3],
            elbow: a[4],
            wrist: a[5],
            sternoclavicular: a[6],
            shoulder_lateral_m: a[0].x,
        };
        (body, arm)
    })
}

fn pose() -> impl Strategy<Value = (BodyPose, ArmPose)> {
    (prop::array::uniform6(rotation()), prop::array::uniform6(vector()), any::<bool>()).prop_map(
        |(r, p, left)| {
            let body = BodyPose { pelvis: r[0], thorax: r[1], head: r[2], l5s1: p[0], c7t1: p[1] };
            let arm = ArmPose {
                side: if left { Side::Left } else { Side::Right },
                upper_arm: r[3],
                forearm: r[4],
                hand: r[5],
                shoulder: p[2],
                elbow: p[3],
                wrist: p[4],
                sternoclavicular: p[5],
                girdle_neutral_deg: 3.0,
                shoulder_lateral_m: 0.18,
            };
            (body, arm)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn rates_are_the_slopes_of_the_angles((body, arm) in pose(), rates in rates()) {
        let (ours, expected) = (rates_of(&body, &arm, &rates), differences(&body, &arm, &rates));
        prop_assert!(expected.iter().flatten().count() >= 12);
        for i in 0..16 {
            let Some(slope) = expected[i] else { continue };
            let error = (ours[i] - slope).abs() / slope.abs().max(100.0);
            prop_assert!(error < 1e-7, "{}: {} {}", i, ours[i], slope);
        }
    }

    #[test]
    fn rates_are_linear_in_the_velocities((body, arm) in pose(), a in rates(), b in rates()) {
        let sum = (
            BodyRates {
                pelvis: a.0.pelvis + b.0.pelvis,
                thorax: a.0.thorax + b.0.thorax,
                head: a.0.head + b.0.head,
                l5s1: a.0.l5s1 + b.0.l5s1,
                c7t1: a.0.c7t1 + b.0.c7t1,
            },
            ArmRates {
                upper_arm: a.1.upper_arm + b.1.upper_arm,
                forearm: a.1.forearm + b.1.forearm,
                hand: a.1.hand + b.1.hand,
                shoulder: a.1.shoulder + b.1.shoulder,
                elbow: a.1.elbow + b.1.elbow,
                wrist: a.1.wrist + b.1.wrist,
                sternoclavicular: a.1.sternoclavicular + b.1.sternoclavicular,
                shoulder_lateral_m: a.1.shoulder_lateral_m + b.1.shoulder_lateral_m,
            },
        );
        let [first, second, both] = [a, b, sum].map(|r| rates_of(&body, &arm, &r));
        for i in 0..16 {
            let scale = first[i].abs() + second[i].abs() + 1.0;
            prop_assert!((first[i] + second[i] - both[i]).abs() < 1e-9 * scale);
        }
    }
}

/// A person who stands upright, arm hanging straight, palm and head forward.
fn standing() -> (BodyPose, ArmPose) {
    let upright = Rotation::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[
        Vec3::x(),
        Vec3::z(),
        -Vec3::y(),
    ]));
    let at = |z: f64| Vec3::new(0.0, -0.18, z);
    let body = BodyPose {
        pelvis: upright,
        thorax: upright,
        head: upright,
        l5s1: Vec3::new(0.0, 0.0, 1.0),
        c7t1: Vec3::new(0.0, 0.0, 1.5),
    };
    let arm = ArmPose {
        side: Side::Right,
        upper_arm: upright,
        forearm: upright,
        hand: upright,
        shoulder: at(1.4),
        elbow: at(1.1),
        wrist: at(0.85),
        sternoclavicular: Vec3::new(0.0, -0.02, 1.4),
        girdle_neutral_deg: 0.0,
        shoulder_lateral_m: 0.18,
    };
    (body, arm)
}

#[test]
fn a_hanging_arm_has_rates_of_flexion_and_abduction() {
    let (body, arm) = standing();
    // Forward 0.3 m/s and outward 0.15 m/s of an elbow 0.3 m below the shoulder: 1 and 0.5 rad/s.
    let elbow = Vec3::new(0.3, -0.15, 0.0);
    let moving =
        ArmRates { elbow, wrist: elbow, hand: Vec3::new(0.2, 0.1, -0.3), ..ArmRates::default() };
    let still = BodyRates::default();
    let a = arm_rates(&body, &arm, &still, &moving);
    assert!((a.upper_arm_flex_deg.to_radians() - 1.0).abs() < 1e-12, "{a:?}");
    assert!((a.upper_arm_abduction_deg.to_radians() - 0.5).abs() < 1e-12, "{a:?}");
    // Kinks: the elevation's, and the straight elbow's.
    assert_eq!((a.upper_arm_elevation_deg, a.elbow_flex_deg), (0.0, 0.0));
    let expected = differences(&body, &arm, &(still, moving));
    for (i, rate) in values(&TrunkNeckAngles::default(), &a).iter().enumerate() {
        if i >= 6 && i != 8 && i != 10 {
            assert!((rate - expected[i].unwrap()).abs() < 1e-6, "{i}: {rate} {:?}", expected[i]);
        }
    }
    // Nodding and tilting the head from its neutral.
    let head = Vec3::new(0.4, 0.7, 0.0);
    let nod = BodyRates { head, ..still };
    let t = trunk_neck_rates(&body, &nod);
    assert!((t.neck_flex_deg.to_radians() - 0.7).abs() < 1e-12, "{t:?}");
    assert!((t.neck_side_deg.to_radians() - 0.4).abs() < 1e-12, "{t:?}");
}

#[test]
fn rates_near_the_neutral_posture_go_over_into_the_limit() {
    let (body, arm) = standing();
    let rates = (
        BodyRates { head: Vec3::new(0.4, 0.7, 0.2), ..BodyRates::default() },
        ArmRates { elbow: Vec3::new(0.3, -0.15, 0.1), ..ArmRates::default() },
    );
    let limit = rates_of(&body, &arm, &rates);
    for exponent in 2..14 {
        let t = 10.0f64.powi(-exponent);
        let (b, a) = moved(&body, &arm, &rates, t);
        let near = rates_of(&b, &a, &rates);
        for i in [3, 4, 6, 7] {
            assert!(
                (near[i] - limit[i]).abs() < 200.0 * t + 1e-9,
                "{t} {i}: {} {}",
                near[i],
                limit[i]
            );
        }
    }
}

#[test]
fn the_whole_body_turning_changes_no_angle() {
    let (body, arm) = standing();
    let spin = Vec3::new(0.0, 0.0, 0.8);
    let bend = (
        BodyRates { thorax: Vec3::new(0.1, 0.5, 0.3), ..BodyRates::default() },
        ArmRates { elbow: Vec3::new(0.4, 0.2, 0.1), ..ArmRates::default() },
    );
    let (body, arm) = moved(&body, &arm, &bend, 0.5);
    let about = |p: &Vec3| spin.cross(p);
    let turning = (
        BodyRates {
            pelvis: spin,
            thorax: spin,
            head: spin,
            l5s1: about(&body.l5s1),
            c7t1: about(&body.c7t1),
        },
        ArmRates {
            upper_arm: spin,
            forearm: spin,
            hand: spin,
            shoulder: about(&arm.shoulder),
            elbow: about(&arm.elbow),
            wrist: about(&arm.wrist),
            sternoclavicular: about(&arm.sternoclavicular),
            shoulder_lateral_m: 0.0,
        },
    );
    for (i, rate) in rates_of(&body, &arm, &turning).iter().enumerate() {
        assert!(rate.abs() < 1e-9, "{i}: {rate}");
    }
}

#[test]
fn singular_postures_have_finite_rates() {
    let (mut body, mut arm) = standing();
    let rates = (
        BodyRates {
            pelvis: Vec3::new(0.3, 0.2, 0.5),
            thorax: Vec3::new(0.1, 0.5, 0.3),
            ..BodyRates::default()
        },
        ArmRates {
            elbow: Vec3::new(0.4, 0.2, 0.1),
            hand: Vec3::new(0.4, 0.2, 0.1),
            ..ArmRates::default()
        },
    );
    // Arm straight up, head upside down, trunk lying exactly sideways, points in one place.
    arm.elbow = arm.shoulder + Vec3::new(0.0, 0.0, 0.3);
    body.head = Rotation::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI) * body.head;
    body.c7t1 = body.l5s1 + Vec3::new(0.0, 0.5, 0.0);
    assert!(rates_of(&body, &arm, &rates).iter().all(|r| r.is_finite()));
    body.c7t1 = body.l5s1;
    (arm.elbow, arm.wrist, arm.sternoclavicular) = (arm.shoulder, arm.shoulder, arm.shoulder);
    // Lying on the back: the pelvis's x axis points up.
    body.pelvis =
        Rotation::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2) * body.pelvis;
    assert!(rates_of(&body, &arm, &rates).iter().all(|r| r.is_finite()));
}

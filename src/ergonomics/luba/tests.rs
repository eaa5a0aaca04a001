//! LUBA: the handbook's classes, sums over motions, what is not assessed.

use super::*;

fn scored(posture: LubaPosture, edit: impl Fn(&mut TrunkNeckAngles, &mut ArmAngles)) -> LubaScore {
    let (mut body, mut arm) = (TrunkNeckAngles::default(), ArmAngles::default());
    edit(&mut body, &mut arm);
    luba(&body, &arm, posture)
}

/// The authors' handbook chapter, table 43.2.
#[test]
fn wrist_classes_of_the_handbook() {
    use LubaMotion as M;
    for posture in [LubaPosture::Sitting, LubaPosture::Standing] {
        let of = |m: M, angles: [f64; 3]| angles.map(|a| m.points(a, posture).unwrap());
        assert_eq!(of(M::WristFlexion, [10.0, 40.0, 61.0]), [1, 2, 5]);
        assert_eq!(of(M::WristExtension, [10.0, 40.0, 46.0]), [1, 2, 7]);
        assert_eq!(of(M::WristRadial, [5.0, 20.0, 31.0]), [1, 3, 7]);
        assert_eq!(of(M::WristUlnar, [5.0, 15.0, 21.0]), [1, 3, 6]);
    }
    assert_eq!(M::BackExtension.points(31.0, LubaPosture::Standing), Some(15));
}

#[test]
fn points_never_fall_with_the_angle() {
    let neutral = scored(LubaPosture::Standing, |_, _| ());
    let motions = neutral.parts.iter().map(|p| p.motion).chain(neutral.not_assessed);
    for motion in motions {
        for posture in [LubaPosture::Sitting, LubaPosture::Standing] {
            let points: Vec<u8> =
                (0..200).filter_map(|a| motion.points(f64::from(a), posture)).collect();
            assert!(points.windows(2).all(|w| w[0] <= w[1]), "{motion:?}");
            assert!(points.first().is_none_or(|p| *p <= 2), "{motion:?}");
        }
    }
}

#[test]
fn motions_of_a_joint_add_up() {
    let s = scored(LubaPosture::Sitting, |b, a| {
        (a.wrist_flex_deg, a.wrist_deviation_deg) = (-30.0, -15.0);
        (b.trunk_flex_deg, b.trunk_twist_deg) = (30.0, 35.0);
    });
    // Wrist 2 + 3, back 3 + 7, elbow, shoulder and neck at rest 1 each.
    assert_eq!((s.index, s.category), (18, 4));
}

#[test]
fn sitting_back_extension_has_no_classes() {
    let s = scored(LubaPosture::Sitting, |b, _| b.trunk_flex_deg = -15.0);
    assert!(s.not_assessed.contains(&LubaMotion::BackExtension));
    assert_eq!(s.index, 5);
    let s = scored(LubaPosture::Standing, |b, _| b.trunk_flex_deg = -15.0);
    assert!(!s.not_assessed.contains(&LubaMotion::BackExtension));
    assert_eq!(s.index, 8);
}

#[test]
fn rotation_of_the_upper_arm_is_always_named_as_missing() {
    let s = scored(LubaPosture::Standing, |_, _| ());
    assert_eq!(
        s.not_assessed,
        [LubaMotion::ShoulderMedialRotation, LubaMotion::ShoulderLateralRotation]
    );
}

#[test]
fn signs_choose_the_motion() {
    let has = |s: &LubaScore, m: LubaMotion| s.parts.iter().any(|p| p.motion == m && p.points > 0);
    let s = scored(LubaPosture::Standing, |b, a| {
        (a.upper_arm_flex_deg, a.upper_arm_abduction_deg) = (-30.0, -20.0);
        (a.wrist_twist_deg, b.neck_flex_deg) = (-60.0, -40.0);
    });
    for m in [
        LubaMotion::ShoulderExtension,
        LubaMotion::ShoulderAdduction,
        LubaMotion::Supination,
        LubaMotion::NeckExtension,
    ] {
        assert!(has(&s, m), "{m:?}");
    }
}

#[test]
fn what_is_not_a_number_scores_worst() {
    let s = scored(LubaPosture::Standing, |_, a| a.wrist_flex_deg = f64::NAN);
    assert_eq!(s.parts[0].points, 5);
}

#[test]
fn categories() {
    assert_eq!([5, 6, 10, 11, 15, 16].map(luba_category), [1, 2, 2, 3, 3, 4]);
    assert_eq!(luba_category_words(4), "change now");
}

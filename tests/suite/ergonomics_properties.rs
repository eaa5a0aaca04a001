//! Laws of the posture scores: a posture that worsens in one factor never scores better.

use ergopath::ergonomics::{
    ArmAngles, Profile, TaskInputs, TrunkNeckAngles, Worksheet, drivers, reba, rula,
    worksheet as fill_in,
};
use ergopath::human::{Body, Pelvis, Side, Stance, mirror_sign};
use ergopath::math::stream::{Purpose, stream};
use ergopath::survey::{HeadDraw, Lens, NeckRule, PostureAngles, Scorable, Surveyor};
use nalgebra::DVector;
use proptest::prelude::*;
use std::path::Path;
use std::sync::LazyLock;

fn worksheet() -> impl Strategy<Value = Worksheet> {
    prop::array::uniform26(0.0..1.0f64).prop_map(|u| {
        // Boxes are ticked half the time; angles and loads go a little beyond what occurs.
        let mut values = u.map(|v| if v < 0.5 { 0.0 } else { 1.0 });
        let ranges = [
            (0, -90.0, 170.0),
            (4, -5.0, 160.0),
            (6, -80.0, 80.0),
            (9, -50.0, 70.0),
            (12, -40.0, 110.0),
            (17, 0.0, 120.0),
            (19, 0.0, 15.0),
            (25, 0.0, 3.99),
        ];
        for (i, low, high) in ranges {
            values[i] = low + u[i] * (high - low);
        }
        Worksheet::from_values(&values)
    })
}

/// Each factor in turn made worse by `by` (deg or kg), where both methods are monotone in it.
///
/// Not monotone, and left out or taken from the side on which they are: the neck (from extension to
/// flexion the score falls), the elbow (best from 60 to 100 deg), and upper arm, wrist and trunk through
/// zero (bent either way is worse, so "worse" is away from zero).
fn worsened(s: &Worksheet, by: f64) -> Vec<(&'static str, Worksheet)> {
    let away = |angle: f64| if angle < 0.0 { angle - by } else { angle + by };
    let elbow = if s.elbow_flex_deg > 100.0 { by } else { -by };
    let mut all = vec![
        ("upper arm", Worksheet { upper_arm_flex_deg: away(s.upper_arm_flex_deg), ..*s }),
        ("wrist", Worksheet { wrist_flex_deg: away(s.wrist_flex_deg), ..*s }),
        ("trunk", Worksheet { trunk_flex_deg: away(s.trunk_flex_deg), ..*s }),
        ("knee", Worksheet { knee_flex_deg: s.knee_flex_deg + by, ..*s }),
        ("load", Worksheet { load_kg: s.load_kg + by, ..*s }),
        ("raised", Worksheet { shoulder_raised: true, ..*s }),
        ("abducted", Worksheet { upper_arm_abducted: true, ..*s }),
        ("unsupported", Worksheet { arm_supported: false, ..*s }),
        ("across", Worksheet { forearm_across_or_out: true, ..*s }),
        ("deviated", Worksheet { wrist_deviated: true, ..*s }),
        ("twist end", Worksheet { wrist_twist_end: true, ..*s }),
        ("neck twisted", Worksheet { neck_twisted: true, ..*s }),
        ("neck side", Worksheet { neck_side: true, ..*s }),
        ("trunk twisted", Worksheet { trunk_twisted: true, ..*s }),
        ("trunk side", Worksheet { trunk_side: true, ..*s }),
        ("no backrest", Worksheet { trunk_seated_supported: false, ..*s }),
        ("legs", Worksheet { legs_unbalanced: true, ..*s }),
        ("standing", Worksheet { sitting: false, ..*s }),
        ("static load", Worksheet { load_static_or_repeated: true, ..*s }),
        ("shock", Worksheet { load_shock: true, ..*s }),
        ("static", Worksheet { static_gt_1min: true, ..*s }),
        ("repeated", Worksheet { repeated_gt_4min: true, ..*s }),
        ("rapid", Worksheet { rapid_large_changes: true, ..*s }),
        ("coupling", Worksheet { coupling: s.coupling + 1, ..*s }),
    ];
    if s.neck_flex_deg >= 0.0 {
        all.push(("neck", Worksheet { neck_flex_deg: s.neck_flex_deg + by, ..*s }));
    }
    if !(60.0..=100.0).contains(&s.elbow_flex_deg) {
        all.push(("elbow", Worksheet { elbow_flex_deg: s.elbow_flex_deg + elbow, ..*s }));
    }
    all
}

proptest! {
    #[test]
    fn scores_never_fall_when_one_factor_worsens(sheet in worksheet(), by in 0.0..60.0f64) {
        for name in Profile::names() {
            let profile = Profile::by_name(name).unwrap();
            let (before_rula, before_reba) = (rula(&sheet, &profile), reba(&sheet, &profile));
            prop_assert!((1..=7).contains(&before_rula.grand));
            prop_assert!((1..=15).contains(&before_reba.total));
            for (factor, worse) in worsened(&sheet, by) {
                let (after_rula, after_reba) = (rula(&worse, &profile), reba(&worse, &profile));
                prop_assert!(after_rula.grand >= before_rula.grand, "RULA {} {}", name, factor);
                prop_assert!(after_reba.total >= before_reba.total, "REBA {} {}", name, factor);
            }
        }
    }

    #[test]
    fn the_cornell_table_never_scores_above_the_paper(sheet in worksheet()) {
        let paper = Profile::by_name("vignais2017").unwrap();
        let cornell = Profile { rula_force_over_10kg: 2, ..Profile::by_name("cornell2001").unwrap() };
        prop_assert!(rula(&sheet, &cornell).grand <= rula(&sheet, &paper).grand);
    }

    #[test]
    fn no_step_gains_more_than_the_grand_score_has(sheet in worksheet()) {
        let profile = Profile::default();
        let grand = rula(&sheet, &profile).grand;
        prop_assert!(drivers(&sheet, &profile).iter().all(|d| d.drop < grand));
    }

    #[test]
    fn scores_never_fall_when_an_angle_that_ticks_a_box_grows(
        u in prop::array::uniform8(0.0..60.0f64),
        by in 0.0..60.0f64,
    ) {
        let body = TrunkNeckAngles {
            trunk_side_deg: u[0],
            trunk_twist_deg: -u[1],
            neck_side_deg: -u[2],
            neck_twist_deg: u[3],
            ..TrunkNeckAngles::default()
        };
        let arm = ArmAngles {
            girdle_elevation_deg: u[4] - 20.0,
            upper_arm_abduction_deg: u[5],
            upper_arm_elevation_deg: u[5],
            wrist_deviation_deg: -u[6],
            wrist_twist_deg: u[7],
            elbow_flex_deg: 80.0,
            wrist_lateral_m: 0.2,
            wrist_beyond_shoulder_m: 0.01 * (u[4] - 30.0),
            ..ArmAngles::default()
        };
        let task = TaskInputs::default();
        let worse = [
            (TrunkNeckAngles { trunk_side_deg: u[0] + by, ..body }, arm),
            (TrunkNeckAngles { trunk_twist_deg: -u[1] - by, ..body }, arm),
            (TrunkNeckAngles { neck_side_deg: -u[2] - by, ..body }, arm),
            (TrunkNeckAngles { neck_twist_deg: u[3] + by, ..body }, arm),
            (body, ArmAngles { girdle_elevation_deg: u[4] - 20.0 + by, ..arm }),
            (body, ArmAngles { wrist_deviation_deg: -u[6] - by, ..arm }),
            (body, ArmAngles { wrist_twist_deg: u[7] + by, ..arm }),
            (body, ArmAngles { wrist_lateral_m: 0.2 - 0.01 * by, ..arm }),
            (body, ArmAngles {
                wrist_beyond_shoulder_m: arm.wrist_beyond_shoulder_m + 0.01 * by,
                ..arm
            }),
            (body, ArmAngles {
                upper_arm_abduction_deg: u[5] + by,
                upper_arm_elevation_deg: u[5] + by,
                ..arm
            }),
        ];
        for name in Profile::names() {
            let profile = Profile::by_name(name).unwrap();
            let score = |body: &TrunkNeckAngles, arm: &ArmAngles| {
                let sheet = fill_in(body, arm, &task, &profile);
                (rula(&sheet, &profile).grand, reba(&sheet, &profile).total)
            };
            let before = score(&body, &arm);
            for (i, (body, arm)) in worse.iter().enumerate() {
                let after = score(body, arm);
                prop_assert!(after.0 >= before.0 && after.1 >= before.1, "{} {}", name, i);
            }
        }
    }

    #[test]
    fn the_mirrored_posture_of_the_other_arm_scores_the_same(u in prop::array::uniform32(0.0..1.0f64)) {
        let [(right, limits), (left, _)] = &*SURVEYORS;
        let q = DVector::from_iterator(
            limits.len(),
            limits.iter().zip(u).map(|((_, low, high), u)| low + u * (high - low)),
        );
        let signs = limits.iter().map(|(name, _, _)| mirror_sign(name));
        let mirrored = q.component_mul(&DVector::from_iterator(q.len(), signs));
        let draw = |side: Side| HeadDraw::mean(Some(side)).drawn(&mut stream(1, Purpose::Posture, 0, 0));
        let (own, other) = (draw(Side::Right), draw(Side::Left));
        for neck in [NeckRule::Predicted, NeckRule::Looking, NeckRule::Neutral, NeckRule::Gaze] {
            let task = TaskInputs { load_kg: 3.0, ..TaskInputs::default() };
            let lens = Lens { task, neck, both_hands: false, profile: Profile::default() };
            let (a, b) = (right.measure(&q, &own), left.measure(&mirrored, &other));
            for (ours, theirs) in angles_of(&a.arm).iter().zip(angles_of(&b.arm)) {
                prop_assert!((ours - theirs).abs() < 1e-9, "{:?} {:?}", a.arm, b.arm);
            }
            let twist = |x: &PostureAngles| x.trunk_neck(neck).neck_twist_deg;
            prop_assert!((twist(&a) + twist(&b)).abs() < 1e-6);
            prop_assert!((a.l5s1_nm - b.l5s1_nm).abs() < 1e-9);
            for i in 0..2 {
                prop_assert!((a.legs.knees_deg[i] - b.legs.knees_deg[1 - i]).abs() < 1e-6);
            }
            prop_assert_eq!(a.score(&lens), b.score(&lens));
        }
    }
}

/// A surveyor with the names and limits (rad) of its coupled joints.
type Measuring = (Surveyor, Vec<(String, f64, f64)>);

/// A body coupled by its right and by its left hand.
static SURVEYORS: LazyLock<[Measuring; 2]> = LazyLock::new(|| {
    let body = Body::load("male_p50", Path::new(".")).unwrap();
    let stance = Stance::Standing { shoe_m: 0.03 };
    [Side::Right, Side::Left].map(|side| {
        let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
        let coupled = ergopath::human::Coupled { hands: side.into(), pelvis: Pelvis::Moves };
        let chain = body.chain(coupled, &[]).unwrap();
        let joints = chain.joints().iter().map(|j| (j.name.clone(), j.lower, j.upper)).collect();
        (Surveyor::new(&body, coupled, pelvis, (stance, 3.0)).unwrap(), joints)
    })
});

fn angles_of(arm: &ArmAngles) -> [f64; 10] {
    [
        arm.upper_arm_flex_deg,
        arm.upper_arm_abduction_deg,
        arm.upper_arm_elevation_deg,
        arm.girdle_elevation_deg,
        arm.elbow_flex_deg,
        arm.wrist_flex_deg,
        arm.wrist_deviation_deg,
        arm.wrist_twist_deg,
        arm.wrist_lateral_m,
        arm.wrist_beyond_shoulder_m,
    ]
}

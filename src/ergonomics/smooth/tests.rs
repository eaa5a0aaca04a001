//! Tests of the smooth scores: their limit, their gradients, their edges.

use super::*;
use crate::ergonomics::{reba, rula};
use proptest::prelude::*;

/// A posture as plain numbers: 6 body angles, 10 arm angles, and the knee.
type Numbers = [f64; 17];

fn angles(v: &Numbers) -> (TrunkNeckAngles, ArmAngles) {
    let body = TrunkNeckAngles {
        trunk_flex_deg: v[0],
        trunk_side_deg: v[1],
        trunk_twist_deg: v[2],
        neck_flex_deg: v[3],
        neck_side_deg: v[4],
        neck_twist_deg: v[5],
    };
    let arm = ArmAngles {
        upper_arm_flex_deg: v[6],
        upper_arm_abduction_deg: v[7],
        upper_arm_elevation_deg: v[8],
        girdle_elevation_deg: v[9],
        elbow_flex_deg: v[10],
        wrist_flex_deg: v[11],
        wrist_deviation_deg: v[12],
        wrist_twist_deg: v[13],
        wrist_lateral_m: v[14],
        wrist_beyond_shoulder_m: v[15],
    };
    (body, arm)
}

fn numbers(g: &AngleGradient) -> Numbers {
    let (b, a) = (&g.body, &g.arm);
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
        g.knee_flex_deg,
    ]
}

const RANGES: [(f64, f64); 17] = [
    (-40.0, 110.0),
    (-30.0, 30.0),
    (-30.0, 30.0),
    (-50.0, 60.0),
    (-30.0, 30.0),
    (-40.0, 40.0),
    (-90.0, 170.0),
    (-90.0, 120.0),
    (0.0, 180.0),
    (-10.0, 40.0),
    (0.0, 150.0),
    (-60.0, 60.0),
    (-30.0, 30.0),
    (-90.0, 90.0),
    (-0.2, 0.5),
    (-0.4, 0.3),
    (0.0, 120.0),
];

fn posture() -> impl Strategy<Value = Numbers> {
    prop::array::uniform17(0.0..1.0f64).prop_map(|u| {
        let mut v: Numbers =
            std::array::from_fn(|i| RANGES[i].0 + u[i] * (RANGES[i].1 - RANGES[i].0));
        // The elevation is at least the length of its components, as for measured arms.
        v[8] = v[8].max(v[6].hypot(v[7]));
        v
    })
}

fn task() -> impl Strategy<Value = TaskInputs> {
    (0.0..15.0f64, prop::array::uniform9(any::<bool>()), 0u8..5).prop_map(
        |(load_kg, b, coupling)| TaskInputs {
            load_kg,
            load_static_or_repeated: b[0],
            load_shock: b[1] && b[2],
            static_gt_1min: b[3],
            repeated_gt_4min: b[4],
            rapid_large_changes: b[5],
            coupling,
            sitting: b[6],
            trunk_supported: b[7],
            legs_unbalanced: b[8],
            knee_flex_deg: 0.0,
            arm_supported: b[2],
        },
    )
}

/// The four profiles, and two that set what these leave alone.
fn profiles() -> Vec<Profile> {
    let named = Profile::names().map(|n| Profile::by_name(n).unwrap());
    let strict = Profile { upper_arm_rule: crate::ergonomics::UpperArmRule::Elevation, ..named[0] };
    let rhythm = Profile { girdle_rhythm: 0.3, ..named[0] };
    named.into_iter().chain([strict, rhythm]).collect()
}

/// Whether every number is far enough from every threshold that any profile may hold.
fn clear(v: &Numbers, by_deg: f64) -> bool {
    let thresholds: [&[f64]; 17] = [
        &[-20.0, -5.0, 0.0, 5.0, 20.0, 60.0],
        &[-10.0, 10.0],
        &[-10.0, 10.0],
        &[-5.0, 0.0, 10.0, 20.0],
        &[-10.0, 10.0],
        &[-10.0, 10.0],
        &[-20.0, 20.0, 45.0, 90.0],
        &[45.0],
        &[20.0, 30.0, 45.0, 90.0],
        &[5.0],
        &[60.0, 100.0],
        &[-15.0, -5.0, 0.0, 5.0, 15.0],
        &[-10.0, 10.0],
        &[-45.0, 45.0],
        &[-0.02, 0.0],
        &[0.05],
        &[30.0, 60.0],
    ];
    let unit = |i: usize| if i == 14 || i == 15 { METRES_PER_DEG } else { 1.0 };
    let far = |i: usize, t: &f64| (v[i] - t).abs() > by_deg * unit(i);
    let rhythm = v[9] - 0.3 * (v[8] - 30.0).max(0.0) - 5.0;
    let azimuth = v[6] + 0.5 * v[8];
    (0..17).all(|i| thresholds[i].iter().all(|t| far(i, t)))
        && rhythm.abs() > by_deg
        && azimuth.abs() > by_deg
}

/// Central difference of a score in one number; `None` where the score has a kink nearby.
fn slope(f: &dyn Fn(f64) -> f64, x: f64, h: f64) -> Option<f64> {
    let (before, here, after) = (f(x - h), f(x), f(x + h));
    let (left, right) = ((here - before) / h, (after - here) / h);
    let central = (after - before) / (2.0 * h);
    ((left - right).abs() < 1e-3 * central.abs().max(1.0)).then_some(central)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn narrow_steps_give_the_official_scores(v in posture(), task in task()) {
        prop_assume!(clear(&v, 1e-3));
        let (body, arm) = angles(&v);
        let task = TaskInputs { knee_flex_deg: v[16], ..task };
        for profile in profiles() {
            let sheet = worksheet(&body, &arm, &task, &profile);
            let (hard_rula, hard_reba) = (rula(&sheet, &profile), reba(&sheet, &profile));
            let s = smooth_rula(&body, &arm, &task, &profile, 1e-5).steps;
            let ours = [s.upper_arm, s.lower_arm, s.wrist, s.wrist_twist, s.posture_a, s.muscle,
                s.force, s.score_c, s.neck, s.trunk, s.legs, s.posture_b, s.score_d, s.grand];
            for ((column, hard), soft) in
                crate::ergonomics::RulaSteps::COLUMNS.iter().zip(hard_rula.values()).zip(ours)
            {
                prop_assert!((soft - f64::from(hard)).abs() < 1e-12, "{} {}", profile.name, column);
            }
            let s = smooth_reba(&body, &arm, &task, &profile, 1e-5).steps;
            let ours = [s.neck, s.trunk, s.legs, s.table_a, s.load, s.score_a, s.upper_arm,
                s.lower_arm, s.wrist, s.table_b, s.score_b, s.score_c, s.activity, s.total];
            for ((column, hard), soft) in
                crate::ergonomics::RebaSteps::COLUMNS.iter().zip(hard_reba.values()).zip(ours)
            {
                prop_assert!((soft - f64::from(hard)).abs() < 1e-12, "{} {}", profile.name, column);
            }
        }
    }

    #[test]
    fn gradients_are_the_slopes(v in posture(), task in task(), width in 0.5..30.0f64) {
        for profile in profiles() {
            let at = |v: &Numbers| {
                let (body, arm) = angles(v);
                let task = TaskInputs { knee_flex_deg: v[16], ..task };
                (
                    smooth_rula(&body, &arm, &task, &profile, width),
                    smooth_reba(&body, &arm, &task, &profile, width),
                )
            };
            let (r, e) = at(&v);
            let ours = [numbers(&r.gradient), numbers(&e.gradient)];
            for i in 0..17 {
                let with = |x: f64| { let mut w = v; w[i] = x; w };
                let h = if i == 14 || i == 15 { 1e-7 } else { 1e-5 };
                let scores: [&dyn Fn(f64) -> f64; 2] =
                    [&|x| at(&with(x)).0.steps.grand, &|x| at(&with(x)).1.steps.total];
                for (score, ours) in scores.iter().zip(ours) {
                    if let Some(expected) = slope(score, v[i], h) {
                        let error = (ours[i] - expected).abs() / expected.abs().max(1.0);
                        prop_assert!(error < 1e-6, "{} {}: {} {}", profile.name, i, ours[i], expected);
                    }
                }
            }
        }
    }

    #[test]
    fn a_sheet_with_clear_boxes_scores_as_its_angles(v in posture(), task in task()) {
        prop_assume!(clear(&v, 1e-3));
        let (body, arm) = angles(&v);
        let (task, profile) = (TaskInputs { knee_flex_deg: v[16], ..task }, Profile::default());
        let sheet = worksheet(&body, &arm, &task, &profile);
        let width = 1e-5;
        let (a, b) = (
            smooth_rula(&body, &arm, &task, &profile, width),
            smooth_rula_sheet(&sheet, &profile, width),
        );
        prop_assert!((a.steps.grand - b.steps.grand).abs() < 1e-12);
        let (a, b) = (
            smooth_reba(&body, &arm, &task, &profile, width),
            smooth_reba_sheet(&sheet, &profile, width),
        );
        prop_assert!((a.steps.total - b.steps.total).abs() < 1e-12);
    }
}

#[test]
fn the_width_is_from_10_to_90_percent() {
    for width in [0.3, 1.0, 7.0] {
        let blur = Blur::new(width);
        assert!((blur.above(20.0 + width / 2.0, 20.0).value - 0.9).abs() < 1e-12);
        assert!((blur.above(20.0 - width / 2.0, 20.0).value - 0.1).abs() < 1e-12);
        assert!((blur.below(20.0 - width / 2.0, 20.0).value - 0.9).abs() < 1e-12);
        let metres = blur.in_metres();
        let half = width / 2.0 * METRES_PER_DEG;
        assert!((metres.above(0.05 + half, 0.05).value - 0.9).abs() < 1e-12);
    }
    // A width that makes no sense counts as the narrowest.
    for width in [0.0, -1.0, f64::NAN] {
        let step = Blur::new(width).above(20.1, 20.0);
        assert_eq!((step.value, step.slope), (1.0, 0.0));
        assert!(Blur::new(width).above(20.0, 20.0).slope.is_finite());
    }
}

#[test]
fn sheet_gradients_are_the_slopes() {
    let profile = Profile::default();
    let sheet = Worksheet {
        upper_arm_flex_deg: 44.8,
        elbow_flex_deg: 60.3,
        wrist_flex_deg: -15.2,
        neck_flex_deg: 19.8,
        trunk_flex_deg: 20.2,
        knee_flex_deg: 59.9,
        load_kg: 6.0,
        coupling: 2,
        ..Worksheet::default()
    };
    let set = |i: usize, x: f64| {
        let mut s = sheet;
        *[
            &mut s.upper_arm_flex_deg,
            &mut s.elbow_flex_deg,
            &mut s.wrist_flex_deg,
            &mut s.neck_flex_deg,
            &mut s.trunk_flex_deg,
            &mut s.knee_flex_deg,
        ][i] = x;
        s
    };
    let at = [44.8, 60.3, -15.2, 19.8, 20.2, 59.9];
    let list = |g: SheetGradient| {
        [
            g.upper_arm_flex_deg,
            g.elbow_flex_deg,
            g.wrist_flex_deg,
            g.neck_flex_deg,
            g.trunk_flex_deg,
            g.knee_flex_deg,
        ]
    };
    let rula = |s: &Worksheet| smooth_rula_sheet(s, &profile, 1.0);
    let reba = |s: &Worksheet| smooth_reba_sheet(s, &profile, 1.0);
    let (by_rula, by_reba) = (list(rula(&sheet).gradient), list(reba(&sheet).gradient));
    for i in 0..6 {
        let expected = slope(&|x| rula(&set(i, x)).steps.grand, at[i], 1e-5).unwrap();
        assert!((by_rula[i] - expected).abs() < 1e-6, "{i}: {} {expected}", by_rula[i]);
        let expected = slope(&|x| reba(&set(i, x)).steps.total, at[i], 1e-5).unwrap();
        assert!((by_reba[i] - expected).abs() < 1e-6, "{i}: {} {expected}", by_reba[i]);
    }
    assert!(by_reba.iter().filter(|g| **g != 0.0).count() >= 4, "{by_reba:?}");
}

#[test]
fn an_arm_raised_past_90_deg_changes_its_class_without_a_jump() {
    let profile = Profile::default();
    let (body, task) = (TrunkNeckAngles::default(), TaskInputs::default());
    let score = |elevation: f64| {
        let arm = ArmAngles {
            upper_arm_abduction_deg: elevation,
            upper_arm_elevation_deg: elevation,
            elbow_flex_deg: 80.0,
            wrist_lateral_m: 0.2,
            ..ArmAngles::default()
        };
        smooth_rula(&body, &arm, &task, &profile, 1.0).steps.upper_arm
    };
    let mut last = score(80.0);
    for k in 1..=2000 {
        let next = score(80.0 + 0.01 * f64::from(k));
        assert!((-1e-12..0.1).contains(&(next - last)), "{k}: {last} {next}");
        last = next;
    }
    assert!((score(80.0) - 2.0).abs() < 1e-6 && (last - 5.0).abs() < 1e-6);
}

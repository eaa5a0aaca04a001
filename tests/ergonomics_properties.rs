//! Laws of the posture scores: a posture that worsens in one factor never scores better.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use ergopath::ergonomics::{Profile, Worksheet, drivers, reba, rula};
use proptest::prelude::*;

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
/// Neck extension is left out: from 5 deg back to 5 deg forward the score falls.
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
}

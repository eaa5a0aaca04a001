//! Smooth scores against the official ones on independently scored postures, where their table is at
//! hand.

use crate::skips::shared;
use ergopath::ergonomics::{
    DEFAULT_WIDTH_DEG, Profile, Worksheet, reba, rula, smooth_reba_sheet, smooth_rula_sheet,
};
use std::collections::HashMap;

/// Sheets of the kinds that do not sit on thresholds; `None` where there is no such table.
fn sheets() -> Option<Vec<Worksheet>> {
    let mut reader = csv::Reader::from_path(shared("ergonomics/postures.csv")?).unwrap();
    let rows = reader.deserialize().map(|row| row.unwrap());
    let hard = rows.filter(|row: &HashMap<String, String>| {
        ["random", "mild", "single"].contains(&row["kind"].as_str())
    });
    let sheet = |row: HashMap<String, String>| {
        Worksheet::from_values(&Worksheet::COLUMNS.map(|c| row[c].parse().unwrap()))
    };
    Some(hard.map(sheet).collect())
}

/// Whether every angle is at least `by` deg from every threshold of the profile that either method
/// has for it.
fn clear_of_thresholds(sheet: &Worksheet, p: &Profile, by: f64) -> bool {
    let far = p.rula_trunk_far_extension_deg.unwrap_or(20.0);
    let checks: [(f64, &[f64]); 6] = [
        (sheet.upper_arm_flex_deg, &[-20.0, 20.0, 45.0, 90.0]),
        (sheet.elbow_flex_deg, &[60.0, 100.0]),
        (sheet.wrist_flex_deg.abs(), &[p.wrist_neutral_deg, 15.0]),
        (sheet.neck_flex_deg, &[-p.neck_extension_deg, 10.0, 20.0]),
        (
            sheet.trunk_flex_deg,
            &[-far, -20.0, -p.trunk_upright_deg, p.trunk_upright_deg, 20.0, 60.0],
        ),
        (sheet.knee_flex_deg, &[30.0, 60.0]),
    ];
    // Rounding of decimal cells: 46.0 - 45.0 must count as 1.
    checks.iter().all(|(angle, at)| at.iter().all(|t| (angle - t).abs() >= by - 1e-9))
}

/// Largest and mean distance of the smooth scores from the official ones.
fn distance(pairs: &[(f64, f64)]) -> (f64, f64) {
    let errors = pairs.iter().map(|(soft, hard)| (soft - hard).abs());
    let most = errors.clone().fold(0.0, f64::max);
    (most, errors.sum::<f64>() / pairs.len() as f64)
}

#[test]
fn smooth_scores_round_to_the_official_ones_a_degree_from_thresholds() {
    let Some(sheets) = sheets() else { return };
    for name in Profile::names() {
        let profile = Profile::by_name(name).unwrap();
        let clear: Vec<Worksheet> =
            sheets.iter().copied().filter(|s| clear_of_thresholds(s, &profile, 1.0)).collect();
        // Where the neutral bands are 0 deg wide, every row with an angle of 0 sits on a threshold.
        assert!(clear.len() >= 100, "{name}: only {} rows are clear of thresholds", clear.len());
        let by_rula: Vec<(f64, f64)> = clear
            .iter()
            .map(|s| {
                let smooth = smooth_rula_sheet(s, &profile, DEFAULT_WIDTH_DEG);
                (smooth.steps.grand, f64::from(rula(s, &profile).grand))
            })
            .collect();
        let by_reba: Vec<(f64, f64)> = clear
            .iter()
            .map(|s| {
                let smooth = smooth_reba_sheet(s, &profile, DEFAULT_WIDTH_DEG);
                (smooth.steps.total, f64::from(reba(s, &profile).total))
            })
            .collect();
        for (method, pairs) in [("RULA", by_rula), ("REBA", by_reba)] {
            let (most, mean) = distance(&pairs);
            eprintln!("{name} {method}: {} rows, max {most:.4}, mean {mean:.4}", pairs.len());
            assert!(most < 0.5, "{name} {method}: {most}");
        }
    }
}

#[test]
fn narrower_steps_are_nearer() {
    let Some(sheets) = sheets() else { return };
    let profile = Profile::default();
    let clear = sheets.iter().filter(|s| clear_of_thresholds(s, &profile, 1.0));
    let clear: Vec<&Worksheet> = clear.collect();
    let mean = |width: f64| {
        let grand = |s: &&Worksheet| {
            let smooth = smooth_rula_sheet(s, &profile, width).steps.grand;
            (smooth, f64::from(rula(s, &profile).grand))
        };
        distance(&clear.iter().map(grand).collect::<Vec<_>>()).1
    };
    let means = [5.0, 3.0, 1.0, 0.3, 0.1].map(mean);
    assert!(means.windows(2).all(|w| w[1] <= w[0]), "{means:?}");
    assert!(means[4] < 1e-12, "{means:?}");
}

//! Training on real recordings, where they are at hand: the ranking of the methods.

use crate::skips::shared;
use ergopath::human::{Body, BodySize, Sex, Side};
use ergopath::posture::Method;
use ergopath::recording::read;
use ergopath::training::{
    Dataset, FitSettings, Judging, RolloutScore, TrainSettings, Trial, evaluate, fit,
};

/// One person of the shared hand-over as a data set.
fn handover(person: &str, sex: Sex) -> Option<Dataset> {
    let path = shared("recordings/kth_handover")?;
    let size = BodySize { sex, stature_m: 1.55, mass_kg: 60.0 };
    let body = Body::of_size(person, size).unwrap();
    let recording = read(&path, Some(person)).unwrap();
    let motion = fit(&recording, &body, Side::Right, &FitSettings::default()).unwrap();
    println!("{person}: hand {:.2?} mm", motion.report.hand_residual_mm);
    Some(Dataset::new(&[Trial::from(&motion)], &body, Side::Right).unwrap())
}

/// Person, sex, and what a prototype reached: relative RMSE, path error with the pull (deg).
const PEOPLE: [(&str, Sex, f64, f64); 2] =
    [("giver", Sex::Male, 0.33, 1.6), ("taker", Sex::Female, 0.43, 1.7)];

#[test]
fn a_full_weight_predicts_real_people_and_its_bands_hold() {
    for (person, sex, rmse, path) in PEOPLE {
        let Some(data) = handover(person, sex) else { return };
        // The prototype's six folds: the last 40 % of the time, and five blocks.
        let mut folds = vec![data.split_in_time(0.6, 0.0)];
        folds.extend(data.blocks());
        let judging = Judging {
            methods: vec![Method::FullW, Method::PlainIk],
            task_sd: None,
            has_rollouts: true,
        };
        let found = evaluate(&data, &folds, &judging, &TrainSettings::default()).unwrap();
        let relative = |i: usize| {
            let groups = &found.methods[i].groups;
            groups.iter().map(|g| g.relative_rmse_q).sum::<f64>() / groups.len() as f64
        };
        let walks = &found.methods[0].rollouts;
        let mean = |pick: fn(&RolloutScore) -> f64| {
            walks.iter().map(pick).sum::<f64>() / walks.len() as f64
        };
        let (free, pulled) = (mean(|r| r.path_error_deg), mean(|r| r.pulled_path_error_deg));
        let (coverage, width) = (mean(|r| r.bands.coverage_90), mean(|r| r.bands.width_90_deg));
        println!(
            "{person}: relative RMSE {:.3} (plain {:.3}), path {free:.2} deg, with pull {pulled:.2} deg, \
             90 % band holds {coverage:.3}, width {width:.1} deg",
            relative(0),
            relative(1)
        );
        // The giver's fast reach in the last 40 % keeps its RMSE 16 % above the prototype's.
        let allowed = if person == "giver" { 1.2 } else { 1.1 };
        assert!(relative(0) < allowed * rmse, "{person}: {}", relative(0));
        assert!(relative(0) < 0.6 * relative(1));
        assert!(pulled < 1.1 * path && pulled < free, "{person}: {free} {pulled}");
        assert!((0.83..=0.96).contains(&coverage), "{person}: {coverage}");
    }
}

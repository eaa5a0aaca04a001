//! Training on real recordings, where they are at hand: the ranking of the methods.

#![allow(clippy::unwrap_used, reason = "tests may panic")]
#![allow(clippy::print_stdout, reason = "says when it skips, and the figures it judges")]

use ergopath::human::{Body, BodySize, Sex, Side};
use ergopath::posture::{Method, MethodQuality};
use ergopath::recording::read;
use ergopath::training::{
    Dataset, FitSettings, Fold, TrainSettings, Trial, evaluate, fit, learn_laws, learn_noise,
    unseen_residuals,
};
use std::path::Path;

/// One person of the shared hand-over as a data set; `None`, and a word about it, where it is absent.
fn handover(person: &str, sex: Sex) -> Option<Dataset> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/recordings").join("kth_handover");
    if !path.exists() {
        println!("skipped: kth_handover is not here");
        return None;
    }
    let size = BodySize { sex, stature_m: 1.55, mass_kg: 60.0 };
    let body = Body::of_size(person, size).unwrap();
    let recording = read(&path, Some(person)).unwrap();
    let motion = fit(&recording, &body, Side::Right, &FitSettings::default()).unwrap();
    println!("{person}: hand {:.2?} mm", motion.report.hand_residual_mm);
    Some(Dataset::new(&[Trial::from(&motion)], &body, Side::Right).unwrap())
}

const PEOPLE: [(&str, Sex); 2] = [("giver", Sex::Male), ("taker", Sex::Female)];

fn show(label: &str, quality: &[MethodQuality]) {
    println!("{label}");
    for q in quality {
        let (free, pulled) = q.path_error_deg.unwrap();
        println!(
            "  {:9} relative RMSE {:.3}  LL_null {:7.2}  LL_q {:7.2}  path {free:.2} / {pulled:.2} deg",
            q.method.name(),
            q.relative_rmse,
            q.log_likelihood_null,
            q.log_likelihood
        );
    }
}

#[test]
fn a_full_weight_beats_the_plain_pseudo_inverse() {
    for (person, sex) in PEOPLE {
        let Some(data) = handover(person, sex) else { return };
        let quality = evaluate(&data, &data.held_out(), &TrainSettings::default()).unwrap();
        show(person, &quality);
        let of = |m: Method| quality.iter().find(|q| q.method == m).unwrap();
        let (full, plain) = (of(Method::FullW), of(Method::PlainIk));
        assert!(full.relative_rmse < 0.7 * plain.relative_rmse);
        assert!(full.log_likelihood_null > plain.log_likelihood_null);
    }
}

/// Splits, length-scales and noise: `cargo test --test train_real -- --ignored --nocapture`.
#[test]
#[ignore = "prints tables for people"]
fn survey() {
    for (person, sex) in PEOPLE {
        let Some(data) = handover(person, sex) else { return };
        let splits: [(&str, Vec<Fold>); 3] = [
            ("70/30 with a gap of 0.5 s", data.held_out()),
            ("60/40 without a gap", vec![data.split_in_time(0.6, 0.0)]),
            ("five blocks", data.blocks()),
        ];
        for (label, folds) in &splits {
            for length in [0.5, 1.0, 2.0, 3.0] {
                let settings =
                    TrainSettings { attraction_length: length, ..TrainSettings::default() };
                let quality = evaluate(&data, folds, &settings).unwrap();
                show(&format!("{person}, {label}, length-scale {length}"), &quality);
            }
        }
        let settings = TrainSettings::default();
        let all: Vec<_> = data.frames.iter().collect();
        let laws = learn_laws(&[Method::FullW], &all, &settings, None).unwrap();
        for is_pulled in [false, true] {
            let found =
                unseen_residuals(&data, &data.blocks(), &laws, &settings, is_pulled).unwrap();
            let noise = learn_noise(&found[0]);
            let size = (found[0].iter().map(|r| r.value.norm_squared()).sum::<f64>()
                / (24.0 * found[0].len() as f64))
                .sqrt();
            println!(
                "{person}, attraction {is_pulled}: residual {size:.4} rad/s, rank {}, tau {:.3} s, \
                 v0 {} m/s, |F| {:.3}",
                noise.factor.ncols(),
                noise.correlation_time_s,
                noise.speed_floor_m_s,
                noise.factor.norm()
            );
        }
    }
}

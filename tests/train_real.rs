//! Training on real recordings, where they are at hand: the ranking of the methods.

#![allow(clippy::unwrap_used, reason = "tests may panic")]
#![allow(clippy::print_stdout, reason = "says when it skips, and the figures it judges")]

use ergopath::human::{Body, BodySize, Sex, Side};
use ergopath::posture::{Method, MethodQuality};
use ergopath::recording::read;
use ergopath::training::{Dataset, FitSettings, TrainSettings, Trial, evaluate, fit};
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

//! Compares the methods on one recording under three ways of holding out, as a researcher would.
//!
//! ```text
//! cargo run --release --example method_survey -- RECORDING BODY [PERSON]
//! ```
//! RECORDING is an MVNX file or a folder of rigid bodies, BODY a shipped body or a URDF.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program shows what it finds")]

use ergopath::files::InputError;
use ergopath::human::{Body, Side};
use ergopath::recording::read;
use ergopath::training::{Dataset, FitSettings, TrainSettings, Trial, evaluate, fit};
use std::path::Path;
use std::process::ExitCode;

fn survey(recording: &str, body: &str, person: Option<&str>) -> Result<(), InputError> {
    let body = Body::load(body, Path::new("."))?;
    let recording = read(Path::new(recording), person)?;
    let motion = fit(&recording, &body, Side::Right, &FitSettings::default())?;
    let report = &motion.report;
    println!("hand residual {:.2?} mm", report.hand_residual_mm);
    println!(
        "calibration {:.1?} deg, beyond range {:.1?}",
        report.calibration_deg, report.beyond_range
    );
    let data = Dataset::new(&[Trial::from(&motion)], &body, Side::Right)?;
    // Of a single trial these are six folds. The defaults of fit and training were compared on them,
    // so that their figures are a little better than those of a movement nobody has looked at.
    let mut all = vec![data.split_in_time(0.6, 0.0)];
    all.extend(data.blocks());
    for (label, folds) in [
        ("first 70 % trains, gap of 0.5 s", data.held_out()),
        ("first 60 % trains, no gap", vec![data.split_in_time(0.6, 0.0)]),
        ("five contiguous blocks", data.blocks()),
        ("mean of the 60 % split and the blocks", all),
    ] {
        println!("{label}");
        for q in evaluate(&data, &folds, &TrainSettings::default())? {
            let (free, pulled) = q.path_error_deg.unwrap_or((f64::NAN, f64::NAN));
            println!(
                "  {:9} relative RMSE {:.3}  LL null {:7.2}  LL_q {:7.2}  path {free:.2} deg, with pull {pulled:.2} deg",
                q.method.name(),
                q.relative_rmse,
                q.log_likelihood_null,
                q.log_likelihood
            );
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [recording, body, rest @ ..] = arguments.as_slice() else {
        eprintln!("usage: method_survey RECORDING BODY [PERSON]");
        return ExitCode::from(2);
    };
    match survey(recording, body, rest.first().map(String::as_str)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{:?}", miette::Report::new(e));
            ExitCode::from(2)
        }
    }
}

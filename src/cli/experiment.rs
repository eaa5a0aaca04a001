//! `ergopath experiment`: the paper's experiments and our own, from made-up data to table and figure.

use super::experiment_paper::{PaperArgs, paper};
use super::experiment_size::{SizeArgs, size};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, parse_toml, read_text};
use crate::math::stats::mean;
use crate::report::{BoxPanel, box_plots};
use crate::training::paper::PaperExperiment;
use crate::training::toy5r::ToyConstants;
use crate::training::toy5r_paper::{PAPER_5R, open_constants};
use crate::training::{
    Objective, Percentiles, PullRule, ToyResult, ToyScore, TrainSettings, run_calibration, run_toy,
    toy_methods,
};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Arguments of `experiment`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    which: Which,
}

#[derive(Debug, clap::Subcommand)]
enum Which {
    /// The paper's 5R problem: all methods on repeated problems, beside the paper's table.
    #[command(name = "toy-5r")]
    Toy5r(ToyArgs),
    /// Whether the bands of rollouts hold what they promise, whatever makes people differ: six cells.
    Calibration(CalibrationArgs),
    /// The paper's first experiment with people: the same movement, its first repetitions teach, its last test.
    Exp1(PaperArgs),
    /// The second: other movements teach, and the movement tests.
    Exp2(PaperArgs),
    /// The third: another body; simulated people sit, and recorded ones are predicted from all others.
    Exp3(PaperArgs),
    /// How cost and held-out likelihood grow with the number of samples (a simulated operator).
    Size(SizeArgs),
}

/// Arguments of `experiment calibration`.
#[derive(Debug, clap::Args)]
struct CalibrationArgs {
    /// Seed of chain, weights and noise.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How postures are pulled towards those of the training trajectories: per-second (the default: the
    /// chain moves by time), per-metre or none.
    #[arg(long, value_parser = super::evaluate::parse_pull, value_name = "RULE")]
    pull: Option<PullRule>,
    /// What the search for weights and kernel parameters maximises; by default leave-trial-out.
    #[arg(long, value_parser = super::evaluate::parse_objective)]
    objective: Option<Objective>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Arguments of `experiment toy-5r`.
#[derive(Debug, clap::Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
struct ToyArgs {
    /// Number of repeats, each with its own start posture, weights and noise.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=200))]
    repeats: u64,
    /// Constants of the problem (TOML, see --print-constants); by default set A.
    #[arg(long, value_name = "FILE")]
    constants: Option<PathBuf>,
    /// Print the constants of set A as TOML and end.
    #[arg(long)]
    print_constants: bool,
    /// Also search as published: in-sample, BIPOP-CMA-ES, kernel fitted anew to each W (slow).
    #[arg(long)]
    published: bool,
    /// Leave out the setting with ten times less noise.
    #[arg(long)]
    no_low_noise: bool,
    /// Folder to write: figure (PNG), scores (CSV) and everything (JSON).
    #[arg(short, long, value_name = "DIR", default_value = "out/toy-5r")]
    output: PathBuf,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Runs an experiment.
pub(super) fn run(args: &Args, outputs: Outputs) -> Result<Outcome, Failure> {
    match &args.which {
        Which::Toy5r(args) => toy(args, outputs),
        Which::Calibration(args) => calibration(args),
        Which::Size(args) => size(args, outputs),
        Which::Exp1(args) => paper(PaperExperiment::Exp1, args, outputs),
        Which::Exp2(args) => paper(PaperExperiment::Exp2, args, outputs),
        Which::Exp3(args) => paper(PaperExperiment::Exp3, args, outputs),
    }
}

fn toy(args: &ToyArgs, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let constants = match &args.constants {
        Some(path) => parse_toml(path, &read_text(path)?)?,
        None => ToyConstants::default(),
    };
    if args.print_constants {
        let text =
            toml::to_string(&constants).map_err(|e| InputError::new("constants", e.to_string()))?;
        say!("{}", text.trim_end());
        return Ok(Outcome::Done);
    }
    outputs.expect_folder(&args.output)?;
    let methods = toy_methods(args.published);
    let progress = Progress::new();
    let one = |constants: &ToyConstants, stage: &'static str| -> Result<ToyResult, InputError> {
        let tell = |done: usize| progress.tell(stage, done, args.repeats as usize);
        run_toy(constants, args.repeats, &methods, &tell)?
            .ok_or_else(|| interrupted("nothing was written"))
    };
    let result = one(&constants, "5R problems")?;
    let quiet = ToyConstants {
        sigma_z: constants.sigma_z / 10.0,
        sigma_a: constants.sigma_a / 10.0,
        ..constants.clone()
    };
    let low = if args.no_low_noise { None } else { Some(one(&quiet, "with low noise")?) };
    let everything = json!({"set": result, "low_noise": low});
    let picture = |r: &ToyResult| box_plots(&panels(r)).map_err(|e| drawn(&e));
    let mut files = vec![
        ("toy-5r.png".to_owned(), picture(&result)?),
        ("toy-5r.csv".to_owned(), csv(&result).into_bytes()),
        ("toy-5r.json".to_owned(), format!("{everything:#}\n").into_bytes()),
    ];
    if let Some(low) = &low {
        files.push(("toy-5r-low-noise.png".to_owned(), picture(low)?));
    }
    outputs.folder(&args.output, files)?;
    outputs.write()?;
    if args.json {
        say!("{everything}");
    } else {
        print_toy(&result, low.as_ref(), &args.output, args.constants.is_some());
    }
    Ok(Outcome::Done)
}

fn drawn(error: &crate::report::ReportError) -> InputError {
    InputError::fault("figure", error.to_string())
}

/// An experiment that was stopped.
pub(super) fn interrupted(what: &str) -> InputError {
    InputError::new("experiment", format!("interrupted; {what}"))
}

/// The four panels of the paper's figure.
fn panels(result: &ToyResult) -> Vec<BoxPanel> {
    let panel = |title: &str, unit: &str, is_error: bool, pick: fn(&ToyScore) -> f64| BoxPanel {
        title: title.to_owned(),
        unit: unit.to_owned(),
        is_error,
        methods: result
            .methods
            .iter()
            .zip(&result.scores)
            .map(|(m, s)| (m.label.clone(), s.iter().map(pick).collect()))
            .collect(),
    };
    vec![
        panel("Mean log-likelihood of the joint velocity", "nats per row", false, |s| s.ll_q),
        panel("RMSE of the joint velocity", "rad/s", true, |s| s.rmse_q),
        panel("Mean log-likelihood of the task velocity", "nats per row", false, |s| s.ll_x),
        panel("RMSE of the task velocity", "m/s", true, |s| s.rmse_x),
    ]
}

fn csv(result: &ToyResult) -> String {
    let mut text = "method,seed,ll_q,rmse_q_rad_s,ll_x,rmse_x_m_s,weight_error\n".to_owned();
    for (method, scores) in result.methods.iter().zip(&result.scores) {
        for s in scores {
            let error = s.weight_error.map_or_else(String::new, |e| e.to_string());
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{error}",
                method.label, s.seed, s.ll_q, s.rmse_q, s.ll_x, s.rmse_x
            );
        }
    }
    text
}

fn spread(scores: &[ToyScore], pick: fn(&ToyScore) -> f64) -> Percentiles {
    Percentiles::of(&scores.iter().map(pick).collect::<Vec<_>>())
}

fn shown(s: Percentiles, digits: usize, scale: f64) -> String {
    let one = |v: f64| {
        let v = v * scale;
        if v != 0.0 && v.abs() < 1e-3 { format!("{v:.0e}") } else { format!("{v:.digits$}") }
    };
    format!("{} [{}, {}]", one(s.median), one(s.p05), one(s.p95))
}

fn table(result: &ToyResult) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "method",
        "LL qdot",
        "RMSE qdot e-3",
        "LL xdot",
        "RMSE xdot e-3",
        "W error",
        "training",
        "paper: LL qdot",
        "paper: sqrt(RMSE) e-3",
    ]);
    for (method, scores) in result.methods.iter().zip(&result.scores) {
        let errors: Vec<f64> = scores.iter().filter_map(|s| s.weight_error).collect();
        let paper = PAPER_5R.iter().find(|p| p.method == method.label);
        let of = |v: [f64; 3]| Percentiles { median: v[0], p05: v[1], p95: v[2] };
        table.add_row([
            method.label.clone(),
            shown(spread(scores, |s| s.ll_q), 2, 1.0),
            shown(spread(scores, |s| s.rmse_q), 1, 1e3),
            shown(spread(scores, |s| s.ll_x), 2, 1.0),
            shown(spread(scores, |s| s.rmse_x), 2, 1e3),
            if errors.is_empty() {
                "-".to_owned()
            } else {
                format!(
                    "{:.3} (max {:.3})",
                    Percentiles::of(&errors).median,
                    errors.iter().fold(0.0f64, |m, e| m.max(*e))
                )
            },
            format!("{:.2} s", mean(&scores.iter().map(|s| s.train_s).collect::<Vec<_>>())),
            paper.map_or_else(|| "-".to_owned(), |p| shown(of(p.ll_q), 2, 1.0)),
            paper.map_or_else(|| "-".to_owned(), |p| shown(of(p.rmse_q_if_squared()), 1, 1e3)),
        ]);
    }
    for column in 1..9 {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn print_toy(result: &ToyResult, low: Option<&ToyResult>, folder: &Path, is_own: bool) {
    let repeats = result.identity_error.len();
    let set = if is_own { "constants of the user" } else { "set A" };
    say!("5R problem, {repeats} repeats, {set} (median [5th, 95th percentile] over repeats)\n");
    say!("{}", table(result));
    say!(
        "  LL in nats per row, natural logarithm; RMSE in rad/s and m/s. W error: rms of log w about the \
         truth, both\n  centred; W = I has {:.2}. ProMP is judged on whole stretches of 50 rows, which are \
         other rows.\n  The paper's columns: its LL has a scale that no calibrated 5-D density has, and \
         its RMSE behaves like a\n  mean of squares, so the root is shown: compare order and ratios, not \
         digits.",
        Percentiles::of(&result.identity_error).median
    );
    for line in verdicts(result) {
        say!("{line}");
    }
    if let Some(low) = low {
        say!("\nThe same with ten times less noise (sigma_z, sigma_a):\n");
        say!("{}", table(low));
        for line in verdicts(low) {
            say!("{line}");
        }
    }
    say!(
        "\nConstants that the paper leaves open, and what was chosen (change them with --constants):"
    );
    for (what, choice) in open_constants() {
        say!("  {what}: {choice}");
    }
    say!("\nWrote {}/toy-5r.png, toy-5r.csv, toy-5r.json", folder.display());
}

/// What the figures say, counted and not judged.
fn verdicts(result: &ToyResult) -> Vec<String> {
    let index = |label: &str| result.methods.iter().position(|m| m.label == label);
    let Some(own) = index("MI-NsGP") else { return Vec::new() };
    let repeats = result.scores[own].len();
    let mut lines = vec![String::new()];
    for other in ["NsGP", "W-IK", "Sb-M", "GP", "ProMP"] {
        let Some(i) = index(other) else { continue };
        let count = |better: fn(&ToyScore, &ToyScore) -> bool| {
            let pairs = result.scores[own].iter().zip(&result.scores[i]);
            pairs.filter(|(a, b)| better(a, b)).count()
        };
        lines.push(format!(
            "  MI-NsGP (marginal) against {other}: LL better in {} of {repeats}, RMSE in {} of {repeats}",
            count(|a, b| a.ll_q > b.ll_q),
            count(|a, b| a.rmse_q < b.rmse_q)
        ));
    }
    let higher = result.in_sample.iter().filter(|c| c.found > c.truth).count();
    lines.push(format!(
        "  The paper's in-sample objective scores its own W above the true one in {higher} of {repeats}"
    ));
    for label in ["MI in-sample", "MI as published"] {
        let Some(i) = index(label) else { continue };
        let errors = result.scores[i].iter().filter_map(|s| s.weight_error);
        let worse = errors.zip(&result.identity_error).filter(|(e, own)| e > *own).count();
        let plain = index("NsGP").map_or(0, |n| {
            let pairs = result.scores[i].iter().zip(&result.scores[n]);
            pairs.filter(|(a, b)| a.rmse_q > b.rmse_q).count()
        });
        let how = if label == "MI in-sample" {
            "searched by L-BFGS from least squares, kernel fitted in turn"
        } else {
            "BIPOP-CMA-ES, kernel fitted to each W that is tried"
        };
        lines.push(format!(
            "  {label} ({how}):\n    its W is further from the truth than W = I in {worse} of {repeats}; it \
             predicts worse than not learning W (NsGP) in {plain} of {repeats}"
        ));
    }
    lines
}

fn calibration(args: &CalibrationArgs) -> Result<Outcome, Failure> {
    let settings =
        TrainSettings { pull: args.pull, objective: args.objective, ..TrainSettings::default() };
    let progress = Progress::new();
    let tell = |done: usize| progress.tell("cells", done, 6);
    let cells = run_calibration(args.seed, &settings, &tell)?
        .ok_or_else(|| interrupted("nothing was printed"))?;
    progress.tell("cells", 6, 6);
    if args.json {
        say!("{}", json!({"seed": args.seed, "cells": cells}));
        return Ok(Outcome::Done);
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "people differ by",
        "dt",
        "in 90 %",
        "in 50 %",
        "width/oracle",
        "oracle in 90 %",
        "published in 90 %",
        "white",
        "correlated",
        "lasting",
        "tau",
        "calibration",
        "pull",
    ]);
    for c in &cells {
        table.add_row([
            c.truth.to_owned(),
            format!("{} s", c.dt_s),
            format!("{:.2}", c.own.coverage_90),
            format!("{:.2}", c.own.coverage_50),
            format!("{:.2}", c.own.width_90_deg / c.oracle.width_90_deg),
            format!("{:.2}", c.oracle.coverage_90),
            format!("{:.2}", c.independent.coverage_90),
            format!("{:.2}", c.shares.white),
            format!("{:.2}", c.shares.correlated),
            format!("{:.2}", c.shares.lasting),
            format!("{:.2} s", c.correlation_time_s),
            format!("{:.2}", c.calibration),
            if c.is_pulled { "yes" } else { "no" }.to_owned(),
        ]);
    }
    for column in 1..13 {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    say!(
        "5R chain, 20 trajectories train, 50 others test, 200 rollouts each; seed {}\n",
        args.seed
    );
    say!("{table}");
    say!(
        "  One sampler for all cells, not told which. In 90 %: share of joint angles of the test \
         trajectories inside the\n  90 % band, over all times. Oracle: samples of the truth itself. \
         Published: independent at each step."
    );
    Ok(Outcome::Done)
}

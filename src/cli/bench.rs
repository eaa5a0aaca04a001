//! `ergopath bench`: `ErgoBench`, every planner judged by people whose true behaviour is known.

use super::bench_files::{cells_csv, figures, gains_csv};
use super::bench_print::print;
use super::plan::{failure, with_threads};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::ergobench::{Cell, Family, Kind, Question, TABLE_SEED, run, table};
use crate::files::{InputError, Outputs, suggest};
use crate::planner::{Step, load_preset};
use std::path::PathBuf;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder to write: result.json, cells.csv, gains.csv and two pictures; only files
    /// that ergopath wrote there are replaced.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seed: 0 to 99 for tuning, 1000 and up for tables.
    #[arg(long, default_value_t = TABLE_SEED)]
    seed: u64,
    /// A subset: two of the five kinds of people, and the planner `quick`.
    #[arg(long)]
    quick: bool,
    /// Families, separated by commas: bench, overhead, low-bin, lateral, seated, shelf; with whole people
    /// deep-bin, floor-lift, two-handed.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    families: Vec<String>,
    /// Also plan with the pace of the path free, which costs half as much again.
    #[arg(long)]
    pace: bool,
    /// Workstations of each family for each kind of person.
    #[arg(long, default_value_t = 1)]
    instances: usize,
    /// Movements (of about 2 s) from which the planner learns each person.
    #[arg(long, default_value_t = 16)]
    demonstrations: usize,
    /// Repetitions by which a path is judged.
    #[arg(long, default_value_t = 256)]
    repetitions: usize,
    /// Planner: default, quick, careful, or a TOML file.
    #[arg(long, value_name = "NAME|FILE")]
    planner: Option<String>,
    /// Number of threads; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print result.json instead of the table.
    #[arg(long)]
    json: bool,
}

/// Runs the benchmark.
pub(super) fn bench(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let question = question(args)?;
    if let Some(folder) = &args.output {
        outputs.expect_folder(folder)?;
    }
    let work = tempfile::tempdir().map_err(|e| {
        InputError::fault("temporary folder", e.to_string())
            .remedy("set TMPDIR to a folder with room")
    })?;
    let cells = with_threads(args.threads, || {
        let progress = Progress::new();
        let stage = |_: Step| !Progress::is_interrupted();
        let told = |done: usize, total: usize, _: &Cell| {
            progress.tell("cells", done + 1, total);
        };
        run(&question, work.path(), &stage, told)
    })?
    .map_err(failure)?;
    let table = table(&cells);
    let result = serde_json::json!({
        "schema": "ergopath/ergobench/2",
        "seed": question.seed,
        "planner": question.preset,
        "demonstrations": question.demonstrations,
        "repetitions": question.repetitions,
        "pace": question.pace,
        "simulated": true,
        "table": table,
        "cells": cells,
    });
    let text = serde_json::to_string_pretty(&result)
        .map_err(|e| InputError::fault("result", e.to_string()))?;
    if let Some(folder) = &args.output {
        let mut files = vec![
            ("result.json".to_owned(), text.clone().into_bytes()),
            ("cells.csv".to_owned(), cells_csv(&cells)?),
            ("gains.csv".to_owned(), gains_csv(&table)?),
        ];
        files.extend(figures(&table)?.into_iter().map(|(name, png)| (name.to_owned(), png)));
        outputs.folder(folder, files)?;
        outputs.write()?;
    }
    if args.json {
        say!("{text}");
    } else {
        print(&question, &cells, &table);
    }
    Ok(Outcome::Done)
}

fn question(args: &Args) -> Result<Question, Failure> {
    let planner = args.planner.as_deref().unwrap_or(if args.quick { "quick" } else { "default" });
    let families = if args.families.is_empty() {
        Family::ALL.to_vec()
    } else {
        let known: Result<Vec<Family>, InputError> =
            args.families.iter().map(|n| family(n)).collect();
        known?
    };
    if !(1..=1000).contains(&args.instances) || !(2..=100_000).contains(&args.repetitions) {
        return Err(InputError::new("bench", "instances or repetitions are out of range")
            .remedy("give 1 to 1000 instances and 2 to 100000 repetitions")
            .into());
    }
    if !(4..=400).contains(&args.demonstrations) {
        return Err(InputError::new(
            "--demonstrations",
            format!("{} is out of range", args.demonstrations),
        )
        .remedy("give 4 to 400")
        .into());
    }
    let kinds = if args.quick { vec![Kind::InClass, Kind::AsRecorded] } else { Kind::ALL.to_vec() };
    Ok(Question {
        seed: args.seed,
        families,
        instances: args.instances,
        kinds,
        demonstrations: args.demonstrations,
        repetitions: args.repetitions,
        preset: load_preset(planner)?,
        pace: args.pace,
    })
}

const NAMES: [(&str, Family); 9] = [
    ("bench", Family::Bench),
    ("overhead", Family::Overhead),
    ("low-bin", Family::LowBin),
    ("lateral", Family::LateralHandOver),
    ("seated", Family::SeatedTable),
    ("shelf", Family::ShelfLift),
    ("deep-bin", Family::DeepBin),
    ("floor-lift", Family::FloorLift),
    ("two-handed", Family::TwoHandedLift),
];

fn family(name: &str) -> Result<Family, InputError> {
    let found = NAMES.iter().find(|(n, _)| *n == name).map(|(_, f)| *f);
    found.ok_or_else(|| {
        let known: Vec<&str> = NAMES.iter().map(|(n, _)| *n).collect();
        let help = suggest(name, known.iter().copied())
            .unwrap_or_else(|| format!("families: {}", known.join(", ")));
        InputError::new("--families", format!("there is no family `{name}`")).remedy(help)
    })
}

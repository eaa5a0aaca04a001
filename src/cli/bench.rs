//! `ergopath bench`: `ErgoBench`, every planner judged by people whose true behaviour is known.

use super::plan::{failure, with_threads};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::ergobench::{Cell, Family, Kind, Question, Row, TABLE_SEED, Table, run, table};
use crate::files::{InputError, OutputFolder, suggest};
use crate::planner::{Step, load_preset};
use comfy_table::{CellAlignment, presets};
use std::path::PathBuf;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder to write: table.csv, cells.csv, result.json; replaced only if ergopath made it.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Seed: 0 to 99 for tuning, 1000 and up for tables.
    #[arg(long, default_value_t = TABLE_SEED)]
    seed: u64,
    /// A subset: one workstation of each family, two kinds of people, the planner `quick`.
    #[arg(long)]
    quick: bool,
    /// Families, separated by commas: bench, overhead, low-bin, lateral, seated, shelf.
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    families: Vec<String>,
    /// Workstations of each family.
    #[arg(long, default_value_t = 1)]
    instances: usize,
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
pub(super) fn bench(args: &Args) -> Result<Outcome, Failure> {
    let question = question(args)?;
    if let Some(folder) = &args.output {
        drop(OutputFolder::create(folder)?);
    }
    let work = tempfile::tempdir().map_err(|e| {
        InputError::new("temporary folder", e.to_string())
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
        "schema": "ergopath/ergobench/1",
        "seed": question.seed,
        "planner": question.preset,
        "repetitions": question.repetitions,
        "simulated": true,
        "table": table,
        "cells": cells,
    });
    let text = serde_json::to_string_pretty(&result)
        .map_err(|e| InputError::new("result", e.to_string()))?;
    if let Some(folder) = &args.output {
        let folder = OutputFolder::create(folder)?;
        folder.write("result.json", text.as_bytes())?;
        folder.write("cells.csv", &cells_csv(&cells)?)?;
        folder.publish()?;
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
    let kinds =
        if args.quick { vec![Kind::InClass, Kind::HeightAndHistory] } else { Kind::ALL.to_vec() };
    Ok(Question {
        seed: args.seed,
        families,
        instances: args.instances,
        kinds,
        repetitions: args.repetitions,
        preset: load_preset(planner)?,
    })
}

const NAMES: [(&str, Family); 6] = [
    ("bench", Family::Bench),
    ("overhead", Family::Overhead),
    ("low-bin", Family::LowBin),
    ("lateral", Family::LateralHandOver),
    ("seated", Family::SeatedTable),
    ("shelf", Family::ShelfLift),
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

fn cells_csv(cells: &[Cell]) -> Result<Vec<u8>, InputError> {
    let fault = |e: String| InputError::new("cells.csv", e);
    let mut table = csv::Writer::from_writer(Vec::new());
    let header = [
        "station",
        "family",
        "body",
        "person",
        "planner",
        "expected_rula",
        "cvar90_rula",
        "exposure_rula_5",
        "expected_reba",
        "reach_exceeded",
        "predicted_rula",
    ];
    table.write_record(header).map_err(|e| fault(e.to_string()))?;
    for c in cells {
        for o in &c.outcomes {
            let row = [
                c.station.clone(),
                c.family.name().to_owned(),
                c.body.clone(),
                c.kind.name().to_owned(),
                o.planner.clone(),
                o.expected_rula.to_string(),
                o.cvar90_rula.to_string(),
                o.exposure_rula_5.to_string(),
                o.expected_reba.to_string(),
                o.reach_exceeded.to_string(),
                o.predicted_rula.map_or_else(String::new, |p| p.to_string()),
            ];
            table.write_record(row).map_err(|e| fault(e.to_string()))?;
        }
    }
    table.into_inner().map_err(|e| fault(e.to_string()))
}

fn print(question: &Question, cells: &[Cell], table: &Table) {
    say!(
        "ErgoBench, seed {}: {} cells, planner `{}`, each path walked {} times by a simulated person whose\n\
         true behaviour the planner knows from 16 other movements only. Nobody was recorded.",
        question.seed,
        cells.len(),
        question.preset.name,
        question.repetitions
    );
    say!("\nExpected RULA under the truth (means over cells)");
    let planners: Vec<&str> = table
        .rows
        .last()
        .map_or_else(Vec::new, |r| r.expected.iter().map(|e| e.0.as_str()).collect());
    let mut shown = comfy_table::Table::new();
    shown.load_style(presets::NOTHING);
    let header = ["family", "cells"].into_iter().map(str::to_owned);
    shown.set_header(header.chain(planners.iter().map(|p| short(p))));
    for row in &table.rows {
        let mut line = vec![name(row), count(row)];
        line.extend(planners.iter().map(|p| value(&row.expected, p)));
        shown.add_row(line);
    }
    right(&mut shown, 1);
    say!("{}", shown.trim_fmt());

    say!(
        "\nGain of ergopath over the others, points of expected RULA [95 % interval over repetitions]"
    );
    let mut gains = comfy_table::Table::new();
    gains.load_style(presets::NOTHING);
    let others = planners.iter().filter(|p| !["ergopath", "oracle"].contains(*p));
    let header = [String::from("family")].into_iter().chain(others.clone().map(|p| short(p)));
    gains.set_header(header.chain(["of oracle's gain".to_owned(), "oracle gains".to_owned()]));
    for row in &table.rows {
        let mut line = vec![name(row)];
        for p in others.clone() {
            let found = row.gains.iter().find(|g| g.0 == *p);
            line.push(found.map_or_else(String::new, |(_, g)| {
                format!("{:+.2} [{:+.2}, {:+.2}]", g.mean, g.low95, g.high95)
            }));
        }
        line.push(row.share_of_oracle.map_or_else(String::new, |s| {
            format!("{:.0} % [{:.0}, {:.0}]", 100.0 * s.mean, 100.0 * s.low95, 100.0 * s.high95)
        }));
        line.push(row.oracle_gain.map_or_else(String::new, |g| format!("{:.1} %", 100.0 * g)));
        gains.add_row(line);
    }
    right(&mut gains, 1);
    say!("{}", gains.trim_fmt());
    if let Some(all) = table.rows.last() {
        if let Some(gap) = all.calibration_gap {
            say!("\nTruth minus prediction of our paths' expected RULA: {gap:+.2} on average.");
        }
        say!("The intervals take workstations and people as they are; other draws may differ.");
    }
    for c in cells.iter().filter(|c| c.failure.is_some()) {
        let why = c.failure.as_deref().unwrap_or_default();
        say!("  no path: {} ({}, {}): {why}", c.station, c.body, c.kind.name());
    }
}

fn short(planner: &str) -> String {
    match planner {
        "expert_arc" => "expert".to_owned(),
        "best_random" => "random".to_owned(),
        "single_posture_plain" => "one plain".to_owned(),
        "single_posture_learned" => "one learned".to_owned(),
        other => other.to_owned(),
    }
}

fn name(row: &Row) -> String {
    row.family.map_or("all", Family::name).to_owned()
}

fn count(row: &Row) -> String {
    match row.cells {
        (done, 0) => done.to_string(),
        (done, failed) => format!("{done} + {failed} failed"),
    }
}

fn value(all: &[(String, f64)], planner: &str) -> String {
    all.iter().find(|v| v.0 == planner).map_or_else(String::new, |v| format!("{:.2}", v.1))
}

fn right(table: &mut comfy_table::Table, from: usize) {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

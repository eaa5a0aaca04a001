//! `ergopath batch` and `ergopath compare`: many scenarios, one table.

use super::plan::{canonical, failure, with_threads};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, OutputFolder, read_text, write_whole};
use crate::planner::{Preset, Request, Step, load_preset, plan};
use crate::report::{self, ComparisonRow, RowState};
use crate::scenario::read_scenario;
use comfy_table::{Table, presets};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Arguments of `batch`.
#[derive(Debug, clap::Args)]
pub(super) struct BatchArgs {
    /// Scenario files (TOML).
    #[arg(required = true)]
    scenarios: Vec<PathBuf>,
    /// Folder to write: a folder for each run, comparison.csv and comparison.html.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Planners to run each scenario with, separated by commas.
    #[arg(long, default_value = "default", value_delimiter = ',', value_name = "NAME|FILE,...")]
    planner: Vec<String>,
    /// Seed of all randomness; without it each scenario's, else 0.
    #[arg(long)]
    seed: Option<u64>,
    /// Number of threads; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub(super) struct CompareArgs {
    /// Folders that `plan`, `assess` or `batch` have written.
    #[arg(required = true)]
    folders: Vec<PathBuf>,
    /// Folder to write comparison.csv and comparison.html to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// One scenario with one planner.
struct Run {
    name: String,
    scenario: PathBuf,
    planner: String,
    preset: Preset,
}

/// Plans all scenarios; a failure of one is a row of the table.
pub(super) fn batch(args: &BatchArgs) -> Result<Outcome, Failure> {
    let runs = runs(args)?;
    std::fs::create_dir_all(&args.output)
        .map_err(|e| InputError::new(&args.output, format!("cannot be written: {e}")))?;
    let progress = Progress::new();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let rows: Vec<ComparisonRow> = with_threads(args.threads, || {
        runs.par_iter()
            .map(|run| {
                let row = one(run, args).unwrap_or_else(|e| {
                    ComparisonRow::failed(&run.name, &reason(&e, &run.scenario))
                });
                let n = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                progress.tell("planning", n, runs.len());
                row
            })
            .collect()
    })?;
    publish(&args.output, &rows)
}

fn runs(args: &BatchArgs) -> Result<Vec<Run>, Failure> {
    let mut runs: Vec<Run> = Vec::new();
    for planner in &args.planner {
        let preset = load_preset(planner)?;
        for scenario in &args.scenarios {
            let stem = scenario.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let name =
                if args.planner.len() > 1 { format!("{stem}-{}", preset.name) } else { stem };
            if runs.iter().any(|r| r.name == name) {
                return Err(InputError::new(
                    scenario,
                    format!("there are two runs named `{name}`"),
                )
                .remedy("rename one of the scenario files or planners")
                .into());
            }
            let (scenario, planner, preset) = (scenario.clone(), planner.clone(), preset.clone());
            runs.push(Run { name, scenario, planner, preset });
        }
    }
    Ok(runs)
}

fn one(run: &Run, args: &BatchArgs) -> Result<ComparisonRow, Failure> {
    let scenario = read_scenario(&run.scenario)?;
    let seed = args.seed.unwrap_or(scenario.seed);
    let command = canonical("plan", &scenario, &run.planner, seed);
    let preset = run.preset.clone();
    let request = Request { command, seed, preset, keeps_rollouts: false, resume: None };
    let silent = |_: Step| !Progress::is_interrupted();
    let result = plan(&scenario, &request, &silent).map_err(failure)?;
    let folder = OutputFolder::create(&args.output.join(&run.name))?;
    for (name, bytes) in
        report::files(&result).map_err(|e| InputError::new("report", e.to_string()))?
    {
        folder.write(&name, &bytes)?;
    }
    folder.publish()?;
    row_of(&run.name, &args.output.join(&run.name))
}

/// A failure in one line, without the folder: files of results hold no place of a machine.
fn reason(failure: &Failure, scenario: &Path) -> String {
    let text = failure.help().map_or_else(|| failure.to_string(), |h| format!("{failure} ({h})"));
    match scenario.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => {
            text.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")
        }
        _ => text,
    }
}

fn row_of(name: &str, folder: &Path) -> Result<ComparisonRow, Failure> {
    let path = folder.join("result.json");
    let text = read_text(&path)?;
    let broken = |e: String| {
        InputError::new(&path, format!("is not a result of ergopath: {e}"))
            .remedy("name folders that `ergopath plan`, `assess` or `batch` have written")
    };
    let value = serde_json::from_str(&text).map_err(|e| broken(e.to_string()))?;
    Ok(ComparisonRow::from_result_json(name, &value).map_err(broken)?)
}

/// Compares finished runs; a folder of a batch stands for its runs.
pub(super) fn compare(args: &CompareArgs) -> Result<Outcome, Failure> {
    let mut rows = Vec::new();
    for folder in &args.folders {
        let name = |f: &Path| f.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if folder.join("result.json").is_file() || !folder.is_dir() {
            rows.push(row_of(&name(folder), folder)?);
            continue;
        }
        let io = |e: std::io::Error| InputError::new(folder, format!("cannot be read: {e}"));
        let mut runs: Vec<PathBuf> = folder
            .read_dir()
            .map_err(io)?
            .filter_map(|e| Some(e.ok()?.path()))
            .filter(|p| p.join("result.json").is_file())
            .collect();
        runs.sort();
        if runs.is_empty() {
            rows.push(row_of(&name(folder), folder)?);
        }
        for run in runs {
            rows.push(row_of(&name(&run), &run)?);
        }
    }
    publish(&args.output, &rows)
}

fn publish(output: &Path, rows: &[ComparisonRow]) -> Result<Outcome, Failure> {
    let files = report::comparison(rows).map_err(|e| InputError::new("report", e.to_string()))?;
    for (name, bytes) in files {
        write_whole(&output.join(&name), &bytes)?;
    }
    print(rows);
    say!("\n{}", output.join("comparison.html").display());
    let none = rows.iter().all(|r| r.state != RowState::Ok);
    Ok(if none { Outcome::NothingFeasible } else { Outcome::Done })
}

/// The runs, aligned, in the order in which they were named.
fn print(rows: &[ComparisonRow]) {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "run",
        "best path",
        "body",
        "time at 3+",
        "RULA",
        "90 % band",
        "against straight",
        "out of reach",
    ]);
    let mut notes = Vec::new();
    for r in rows {
        let percent =
            |v: Option<f64>| v.map_or_else(String::new, |v| format!("{:.0} %", 100.0 * v));
        let best = match &r.state {
            RowState::Ok => r.best.clone().unwrap_or_default(),
            RowState::NoFeasiblePath(why) => {
                notes.push(format!("{}: no path keeps all limits; {why}", r.name));
                "none".to_owned()
            }
            RowState::Failed(why) => {
                notes.push(format!("{}: {why}", r.name));
                "failed".to_owned()
            }
        };
        let band = match (r.p05_rula, r.p95_rula) {
            (Some(low), Some(high)) => format!("{low:.2} to {high:.2}"),
            _ => String::new(),
        };
        let difference = r.difference.map_or_else(String::new, |d| {
            let clear = if d.clear { "" } else { " (no clear difference)" };
            format!("{:+.2}{clear}", d.mean)
        });
        table.add_row([
            r.name.clone(),
            best,
            r.worst_body.clone().unwrap_or_default(),
            percent(r.exposure_rula_5),
            r.expected_rula.map_or_else(String::new, |v| format!("{v:.2}")),
            band,
            difference,
            percent(r.reach_exceeded),
        ]);
    }
    say!("{}", table.trim_fmt());
    for note in notes {
        say!("  {note}");
    }
}

//! `ergopath batch`: many scenarios, one table.

use super::compare::{Shown, compared, pages, show};
use super::plan::{canonical, failure, with_threads};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::planner::{Preset, Request, RunResult, Step, load_preset, plan};
use crate::report::{self, NamedRun};
use crate::scenario::read_scenario;
use miette::Diagnostic as _;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

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

/// One scenario with one planner.
struct Run {
    name: String,
    scenario: PathBuf,
    planner: String,
    preset: Preset,
}

/// Plans all scenarios; a failure of one is a row of the table.
pub(super) fn batch(args: &BatchArgs, outputs: &Outputs) -> Result<Outcome, Failure> {
    let runs = runs(args)?;
    // The folder is marked as ours before the first run stands in it, so that a batch that was killed
    // can be made again.
    outputs.expect_folder(&args.output)?;
    let mut folder = outputs.another();
    folder.add_to_folder(&args.output, [])?;
    folder.write()?;
    for run in &runs {
        outputs.expect_folder(&args.output.join(&run.name))?;
    }
    let has_fault = AtomicBool::new(false);
    let progress = Progress::new();
    let done = AtomicUsize::new(0);
    let finished: Vec<NamedRun> = with_threads(args.threads, || {
        runs.par_iter()
            .map(|run| {
                let result = one(run, args, outputs.another()).map_err(|e| {
                    has_fault.fetch_or(e.0.is_fault(), Ordering::Relaxed);
                    reason(&e, &run.scenario)
                });
                let n = done.fetch_add(1, Ordering::Relaxed) + 1;
                progress.tell("planning", n, runs.len());
                (run.name.clone(), result)
            })
            .collect()
    })?;
    let compared = compared(&finished, None);
    let named = |(ending, bytes)| (format!("comparison.{ending}"), bytes);
    let mut table = outputs.another();
    table.add_to_folder(&args.output, pages(&compared, &finished)?.into_iter().map(named))?;
    table.write()?;
    let outcome = show(&compared, &args.output.join("comparison.html"), Shown::Table)?;
    if has_fault.into_inner() {
        return Err(InputError::fault("batch", "some runs could not be written").into());
    }
    Ok(outcome)
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

fn one(run: &Run, args: &BatchArgs, mut outputs: Outputs) -> Result<RunResult, Failure> {
    let scenario = read_scenario(&run.scenario)?;
    let seed = args.seed.unwrap_or(scenario.seed);
    let command = canonical("plan", &scenario, &run.planner, seed);
    let preset = run.preset.clone();
    let request = Request { command, seed, preset, keeps_rollouts: false, resume: None };
    let silent = |_: Step| !Progress::is_interrupted();
    let result = plan(&scenario, &request, &silent).map_err(failure)?;
    let files = report::files(&result).map_err(|e| InputError::fault("report", e.to_string()))?;
    outputs.folder(&args.output.join(&run.name), files)?;
    outputs.write()?;
    Ok(result)
}

/// A failure in one line, without the folder: files of results hold no place of a machine.
fn reason(failure: &Failure, scenario: &Path) -> String {
    let error = &failure.0;
    let text = error.help().map_or_else(|| error.to_string(), |h| format!("{error} ({h})"));
    match scenario.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => {
            text.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "")
        }
        _ => text,
    }
}

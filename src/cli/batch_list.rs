//! A list of scenarios: a folder for each, one table.

use super::batch::BatchArgs;
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

/// One scenario with one planner.
struct Run {
    name: String,
    scenario: PathBuf,
    planner: String,
    preset: Preset,
}

/// Plans all scenarios; a failure of one is a row of the table.
pub(super) fn batch(
    args: &BatchArgs,
    output: &Path,
    outputs: &Outputs,
) -> Result<Outcome, Failure> {
    let runs = runs(args)?;
    // The folder is marked as ours before the first run stands in it, so that a batch that was killed
    // can be made again.
    outputs.expect_folder(output)?;
    let mut folder = outputs.another();
    folder.add_to_folder(output, [])?;
    folder.write()?;
    for run in &runs {
        outputs.expect_folder(&output.join(&run.name))?;
    }
    let has_fault = AtomicBool::new(false);
    let progress = Progress::new();
    let done = AtomicUsize::new(0);
    let finished: Vec<NamedRun> = with_threads(args.threads, || {
        runs.par_iter()
            .map(|run| {
                let result = one(run, (args, output), outputs.another()).map_err(|e| {
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
    table.add_to_folder(output, pages(&compared, &finished)?.into_iter().map(named))?;
    table.write()?;
    let outcome = show(&compared, &output.join("comparison.html"), Shown::Table)?;
    if has_fault.into_inner() {
        return Err(InputError::fault("batch", "some runs could not be written").into());
    }
    Ok(outcome)
}

fn runs(args: &BatchArgs) -> Result<Vec<Run>, Failure> {
    let mut runs: Vec<Run> = Vec::new();
    let planners =
        if args.planner.is_empty() { vec!["default".to_owned()] } else { args.planner.clone() };
    for planner in &planners {
        let preset = load_preset(planner)?;
        for scenario in &args.files {
            let stem = scenario.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let name = if planners.len() > 1 { format!("{stem}-{}", preset.name) } else { stem };
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

fn one(
    run: &Run,
    (args, output): (&BatchArgs, &Path),
    mut outputs: Outputs,
) -> Result<RunResult, Failure> {
    let scenario = read_scenario(&run.scenario)?;
    let seed = args.seed.unwrap_or(scenario.seed);
    let command = canonical("plan", &scenario, &run.planner, seed);
    let preset = run.preset.clone();
    let request = Request { command, seed, preset, keeps_rollouts: false, resume: None };
    let silent = |_: Step| !Progress::is_interrupted();
    let result = plan(&scenario, &request, &silent).map_err(failure)?;
    let files = report::files(&result).map_err(|e| InputError::fault("report", e.to_string()))?;
    outputs.folder(&output.join(&run.name), files)?;
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

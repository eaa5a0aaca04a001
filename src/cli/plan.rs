//! `ergopath plan` and `ergopath assess`: from a scenario file to a folder of results.

use super::plan_print::print;
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, remove_state};
use crate::planner::{
    self, Checkpoint, Decision, PlanError, Request, RunResult, Step, load_preset,
};
use crate::report;
use crate::scenario::{Scenario, read_scenario};
use crate::words;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// More threads than any machine has cores; starting them alone would take minutes.
const MOST_THREADS: usize = 1024;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub(super) struct PlanArgs {
    /// Scenario file (TOML).
    scenario: PathBuf,
    /// Go on with a run that was interrupted: same scenario, planner, seed and folder.
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    common: Common,
}

/// Arguments of `assess`.
#[derive(Debug, clap::Args)]
pub(super) struct AssessArgs {
    /// Scenario file (TOML).
    scenario: PathBuf,
    /// A path to score: CSV of times with the TCP's poses or the robot's joints. May be repeated.
    #[arg(long, value_name = "FILE.csv")]
    path: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Options of both commands.
#[derive(Debug, Clone, clap::Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub(super) struct Common {
    /// Folder to write; only files that ergopath wrote there are replaced.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Seed of all randomness; without it the scenario's, else 0.
    #[arg(long)]
    seed: Option<u64>,
    /// Planner: default, quick, careful, tail, `whole_body`, or a TOML file.
    #[arg(long, default_value = "default", value_name = "NAME|FILE")]
    planner: String,
    /// Number of threads; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Also write the sampled postures of every reported path to rollouts/.
    #[arg(long)]
    rollouts: bool,
    /// Also write `one_page.html`: the decision on one sheet of A4, to print or to keep as PDF.
    #[arg(long)]
    one_page: bool,
    /// Also write the time of each stage to a file.
    #[arg(long, value_name = "FILE")]
    timings: Option<PathBuf>,
    /// Print result.json instead of the table.
    #[arg(long)]
    json: bool,
    /// Print the verdict only.
    #[arg(short, long)]
    quiet: bool,
}

/// Header of the file of --timings.
const TIMINGS: &str = "stage,seconds\n";

/// Plans a scenario.
pub(super) fn plan(args: &PlanArgs, outputs: Outputs) -> Result<Outcome, Failure> {
    let scenario = read_scenario(&args.scenario)?;
    let resume =
        if args.resume { Some(Checkpoint::read(&unfinished(&args.common.output))?) } else { None };
    run("plan", &scenario, &args.common, resume, planner::plan, outputs)
}

/// Assesses paths.
pub(super) fn assess(args: &AssessArgs, outputs: Outputs) -> Result<Outcome, Failure> {
    let mut scenario = read_scenario(&args.scenario)?;
    for file in &args.path {
        scenario.add_path(file)?;
    }
    run("assess", &scenario, &args.common, None, planner::assess, outputs)
}

type Planner = fn(&Scenario, &Request, planner::Stage) -> Result<RunResult, PlanError>;

fn run(
    verb: &str,
    scenario: &Scenario,
    common: &Common,
    resume: Option<Checkpoint>,
    planner: Planner,
    mut outputs: Outputs,
) -> Result<Outcome, Failure> {
    let started = Instant::now();
    let preset = load_preset(&common.planner)?;
    // What cannot be written fails now, not after the work.
    outputs.expect_folder(&common.output)?;
    if let Some(file) = &common.timings {
        outputs.expect_file(file, TIMINGS.as_bytes())?;
    }
    for warning in &scenario.warnings {
        complain!("warning: {}", words::setting::warning(warning));
    }
    let seed = common.seed.unwrap_or(scenario.seed);
    let command = canonical(verb, scenario, &common.planner, seed);
    let request = Request { command, seed, preset, keeps_rollouts: common.rollouts, resume };
    let result = with_threads(common.threads, || {
        let progress = Progress::new();
        let tell = |s: Step| progress.tell_best(s.stage, s.done, s.total, s.best);
        planner(scenario, &request, &tell)
    })?
    .map_err(|e| stopped(e, &common.output, outputs.another()))?;
    let planned_s = started.elapsed().as_secs_f64();
    let fault = |e: report::ReportError| InputError::fault("report", e.to_string());
    let mut files = report::files(&result).map_err(fault)?;
    if common.one_page {
        files.push(report::one_page(&result, None).map_err(fault)?);
    }
    outputs.folder(&common.output, files)?;
    let report_s = started.elapsed().as_secs_f64() - planned_s;
    if let Some(file) = &common.timings {
        outputs.file(file, format!("{TIMINGS}plan,{planned_s:.3}\nreport,{report_s:.3}\n"))?;
    }
    outputs.write()?;
    // A run that came to its end needs no way back.
    remove_state(&unfinished(&common.output));
    if common.json {
        say!("{}", report::result_json(&result).map_err(fault)?);
    } else {
        print(&result, common.quiet);
        if !common.quiet {
            let shown = common.output.join("report.html");
            say!("\n{}  ({planned_s:.1} s planning, {report_s:.1} s report)", shown.display());
        }
    }
    Ok(match result.verdict.outcome {
        Decision::Best | Decision::Assessed | Decision::NotSupported => Outcome::Done,
        Decision::NothingFeasible => Outcome::NothingFeasible,
    })
}

/// Runs on a pool of the asked size.
pub(super) fn with_threads<R: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> R + Send,
) -> Result<R, Failure> {
    let Some(threads) = threads else { return Ok(work()) };
    if !(1..=MOST_THREADS).contains(&threads) {
        let message = format!("{threads} threads are not possible");
        return Err(InputError::new("--threads", message)
            .remedy(format!("use 1 to {MOST_THREADS}; the number of cores is best"))
            .into());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| InputError::fault("--threads", e.to_string()))?;
    Ok(pool.install(work))
}

pub(super) fn failure(error: PlanError) -> Failure {
    match error {
        PlanError::Input(e) => e.into(),
        PlanError::Interrupted(_) => {
            InputError::new("run", "interrupted; nothing was written").into()
        }
    }
}

/// Where an interrupted run keeps what it found: beside the folder that it would have written.
fn unfinished(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_os_string();
    name.push(".unfinished.json");
    output.with_file_name(name)
}

/// What an interrupted run keeps, in words.
pub(super) fn unfinished_words(kept: &Checkpoint) -> String {
    format!("{} paths are kept; the same command with --resume goes on with them", kept.tried())
}

/// The failure of a run; an interrupted search is kept, so that it can go on.
fn stopped(error: PlanError, output: &Path, mut outputs: Outputs) -> Failure {
    let PlanError::Interrupted(Some(checkpoint)) = error else { return failure(error) };
    let file = unfinished(output);
    let kept = checkpoint.text().and_then(|text| {
        outputs.state(&file, text)?;
        outputs.write()
    });
    match kept {
        Ok(()) => InputError::new("run", "interrupted; no result was written")
            .remedy(format!(
                "{} paths are kept in {}: run the same command with --resume to go on",
                checkpoint.tried(),
                file.display()
            ))
            .into(),
        Err(e) => e.into(),
    }
}

/// The command without what does not change the result.
pub(super) fn canonical(verb: &str, scenario: &Scenario, planner: &str, seed: u64) -> String {
    let planner = Path::new(planner).file_name().unwrap_or_default().to_string_lossy();
    let mut command = format!("ergopath {verb} {}", scenario.file);
    if verb == "assess" {
        for path in &scenario.paths {
            let _ = write!(command, " --path {}.csv", path.name);
        }
    }
    format!("{command} --seed {seed} --planner {planner}")
}

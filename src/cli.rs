//! The command line: the only place that prints, shows progress and sets exit codes.
//!
//! Exit codes: 0 done; 1 the program itself failed (a full disk, say); 2 the input or the call is wrong
//! (nothing is written); 3 finished, but no path is feasible (the report says why); 4 a batch finished,
//! but some of its cells failed; 5 a batch finished, but not every cell keeps its gate; 130 interrupted.

/// Prints a line to standard output.
macro_rules! say {
    () => { $crate::cli::stdout::print(format_args!("\n")) };
    ($($text:tt)+) => { $crate::cli::stdout::print(format_args!("{}\n", format_args!($($text)+))) };
}

/// Prints a line to standard error.
macro_rules! complain {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

mod adapt;
mod bars;
mod batch;
mod batch_file;
mod batch_list;
mod batch_print;
mod batch_slurm;
mod batch_slurm_print;
mod bench;
mod bench_files;
mod bench_print;
mod body;
mod check;
mod check_batch;
mod check_file;
mod check_scenario;
mod check_table;
mod compare;
mod evaluate;
mod evaluate_data;
mod evaluate_print;
mod experiment;
mod experiment_paper;
mod experiment_paper_print;
mod experiment_size;
mod import;
mod import_print;
mod inspect;
mod inspect_motion;
mod new;
mod plan;
mod plan_print;
mod program;
mod progress;
mod questions;
mod report;
mod schema;
mod score;
mod score_motion;
mod score_print;
mod shell;
mod shift;
mod stdout;
mod train;
mod train_print;
mod validate;
mod validate_print;
mod watch;
mod watch_desk;
mod watch_files;
mod watch_server;

use crate::files::{InputError, Outputs, Seal};
use crate::planner::RunResult;
use crate::posture::PostureModel;
use crate::scenario::Warning;
use clap::{Parser, Subcommand};
use progress::Progress;
use std::process::ExitCode;

/// Plans a collaborative robot's path so that the person holding on to it works in a healthy
/// posture.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Replace files that ergopath did not write; inputs of the same call never.
    #[arg(long, global = true)]
    overwrite: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Writes a commented scenario from a handful of answers, asked on the terminal or given as options.
    New(new::Args),
    /// Explains a file that ergopath reads or writes; of a scenario, what is in reach and what is assumed.
    Check(check::Args),
    /// Shows a chain of a URDF: joints, limits, and pose and Jacobian for given postures.
    Inspect(inspect::Args),
    /// Makes a digital human of given sex, stature and mass.
    Body(body::Args),
    /// Plans paths for a scenario: ranks them by the postures they would cause, and reports.
    Plan(plan::PlanArgs),
    /// Checks, draws and plans a scenario again on every save, and shows it in a browser.
    Watch(watch::Args),
    /// Scores the paths that you have now, as they are, without planning.
    Assess(plan::AssessArgs),
    /// Scores a motion, sampled postures or filled-in worksheets by RULA and REBA.
    Score(Box<score::Args>),
    /// Runs a matrix of scenarios, fields, planners and seeds, or a list of scenarios, into one table.
    Batch(batch::BatchArgs),
    /// Makes the report of a finished run again, without planning.
    Report(report::Args),
    /// Writes a path of a finished run as a program for the robot's controller.
    Program(program::Args),
    /// Puts finished runs side by side: paths, layouts, robots or body sizes.
    Compare(compare::Args),
    /// Adds runs and scored motions up to a worker's shift: minutes at each action level, lifting, hands.
    Shift(shift::Args),
    /// Makes recordings motions of a body of the person's size, and says how good they are.
    Import(import::Args),
    /// Learns from recordings how a person resolves the redundancy of the body.
    Train(train::Args),
    /// Makes a model of several people that of one worker who was recorded for some seconds.
    Adapt(adapt::Args),
    /// Judge all methods on held-out rows of a data file or a recording.
    Evaluate(Box<evaluate::Args>),
    /// Predict recorded people whom no law has seen: errors, and what bands of strangers hold.
    Validate(validate::Args),
    /// `ErgoBench`: judge the planner and its baselines by simulated people whose behaviour is known.
    Bench(bench::Args),
    /// Repeat the paper's experiments and our own on made-up data.
    Experiment(experiment::Args),
    /// JSON Schemas of scenario and planner files, for editors.
    Schema(schema::Args),
    /// Completions for a shell.
    Completions(shell::CompletionArgs),
    /// Writes man pages.
    Man(shell::ManArgs),
}

/// How a command ended when it did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Done,
    NothingFeasible,
    /// Of several runs.
    SomeFailed,
    /// By a signal, which is how a command ends that would go on for ever.
    Interrupted,
    /// Of several runs: not each keeps the bounds that were asked for.
    GateFailed,
}

impl Outcome {
    fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NothingFeasible => 3,
            Self::SomeFailed => 4,
            Self::Interrupted => INTERRUPTED,
            Self::GateFailed => 5,
        }
    }
}

/// Exit code after Ctrl-C, SIGTERM or SIGHUP, as shells have it.
const INTERRUPTED: u8 = 130;

/// Says of files without a checksum that edits of them cannot be seen.
fn warn_of_unsealed(result: &RunResult) {
    for warning in result.warnings.iter().filter(|w| matches!(w, Warning::NoChecksum { .. })) {
        complain!("warning: {}", crate::words::setting::warning(warning));
    }
}

/// The same of a posture model.
fn warn_of_unsealed_model(name: &str, model: &PostureModel) {
    if model.seal == Seal::Missing {
        let warning = Warning::NoChecksum { file: name.to_owned() };
        complain!("warning: {}", crate::words::setting::warning(&warning));
    }
}

/// What stops a command, shown to the user.
#[derive(Debug)]
struct Failure(Box<InputError>);

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self(Box::new(error))
    }
}

impl Failure {
    fn code(&self) -> u8 {
        if self.0.is_fault() { 1 } else { 2 }
    }
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // Help and version are printed the same way.
        Err(shown) => {
            let is_lost = shown.print().is_err_and(|e| e.kind() != std::io::ErrorKind::BrokenPipe);
            return ExitCode::from(if is_lost { 1 } else { shown.exit_code() as u8 });
        }
    };
    let outputs = Outputs::new(cli.overwrite);
    let result = match cli.command {
        Command::New(args) => new::run(&args, outputs),
        Command::Check(args) => check::run(&args, outputs),
        Command::Inspect(args) => inspect::run(&args, outputs),
        Command::Body(args) => body::run(&args, outputs),
        Command::Plan(args) => plan::plan(&args, outputs),
        Command::Watch(args) => watch::run(&args, &outputs),
        Command::Assess(args) => plan::assess(&args, outputs),
        Command::Score(args) => score::run(&args, outputs),
        Command::Batch(args) => batch::batch(&args, &outputs),
        Command::Report(args) => report::run(&args, outputs),
        Command::Program(args) => program::run(&args, outputs),
        Command::Compare(args) => compare::run(&args, outputs),
        Command::Shift(args) => shift::run(&args, outputs),
        Command::Import(args) => import::run(&args, outputs),
        Command::Train(args) => train::run(&args, outputs),
        Command::Adapt(args) => adapt::run(&args, outputs),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Validate(args) => validate::run(&args, outputs),
        Command::Bench(args) => bench::bench(&args, outputs),
        Command::Experiment(args) => experiment::run(&args, outputs),
        Command::Schema(args) => schema::run(&args, outputs),
        Command::Completions(args) => Ok(shell::completions(&args)),
        Command::Man(args) => shell::man(&args, outputs),
    };
    let code = match result {
        Ok(outcome) => outcome.code(),
        Err(failure) => {
            let code = failure.code();
            complain!("{:?}", miette::Report::new(*failure.0));
            code
        }
    };
    // A command that did not come to its end after a signal was stopped by it.
    let code = if matches!(code, 2 | 4) && Progress::is_interrupted() { INTERRUPTED } else { code };
    match stdout::lost() {
        Some(why) if code == 0 => {
            complain!("standard output could not be written: {why}");
            ExitCode::from(1)
        }
        _ => ExitCode::from(code),
    }
}

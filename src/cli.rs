//! The command line: the only place that prints, shows progress and sets exit codes.
//!
//! Exit codes: 0 done; 1 the program itself failed; 2 the input or the call is wrong (nothing is
//! written); 3 finished, but no path is feasible (the report says why).

/// Prints a line to standard output. A reader that has gone (`| head`) is no reason to fail.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

/// Prints a line to standard error.
macro_rules! complain {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}

mod bars;
mod batch;
mod bench;
mod bench_print;
mod body;
mod check;
mod check_cell;
mod check_file;
mod check_scenario;
mod check_table;
mod compare;
mod evaluate;
mod evaluate_print;
mod experiment;
mod experiment_size;
mod inspect;
mod plan;
mod plan_print;
mod progress;
mod report;
mod schema;
mod score;
mod score_motion;
mod score_print;
mod shell;
mod train;
mod train_print;

use clap::{Parser, Subcommand};
use miette::Diagnostic;
use std::process::ExitCode;

/// Plans a collaborative robot's path so that the person holding on to it works in a healthy
/// posture.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Explains a file that ergopath reads or writes; of a scenario, what is in reach and what is assumed.
    Check(check::Args),
    /// Shows a chain of a URDF: joints, limits, and pose and Jacobian for given postures.
    Inspect(inspect::Args),
    /// Makes a digital human of given sex, stature and mass.
    Body(body::Args),
    /// Plans paths for a scenario: ranks them by the postures they would cause, and reports.
    Plan(plan::PlanArgs),
    /// Scores the paths that you have now, as they are, without planning.
    Assess(plan::AssessArgs),
    /// Scores a motion, sampled postures or filled-in worksheets by RULA and REBA.
    Score(Box<score::Args>),
    /// Plans several scenarios and puts them into one table; one failure does not stop the others.
    Batch(batch::BatchArgs),
    /// Makes the report of a finished run again, without planning.
    Report(report::Args),
    /// Puts finished runs side by side: paths, layouts, robots or body sizes.
    Compare(compare::Args),
    /// Learns from recordings how a person resolves the redundancy of the body.
    Train(train::Args),
    /// Judge all methods on held-out rows of a data file or a recording.
    Evaluate(Box<evaluate::Args>),
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
}

/// Anything that stops a command, shown to the user.
type Failure = Box<dyn Diagnostic + Send + Sync>;

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Check(args) => check::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Body(args) => body::run(&args),
        Command::Plan(args) => plan::plan(&args),
        Command::Assess(args) => plan::assess(&args),
        Command::Score(args) => score::run(&args),
        Command::Batch(args) => batch::batch(&args),
        Command::Report(args) => report::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Train(args) => train::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Bench(args) => bench::bench(&args),
        Command::Experiment(args) => experiment::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Completions(args) => Ok(shell::completions(&args)),
        Command::Man(args) => shell::man(&args),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::NothingFeasible) => ExitCode::from(3),
        Err(failure) => {
            complain!("{:?}", miette::Report::new_boxed(failure));
            ExitCode::from(2)
        }
    }
}

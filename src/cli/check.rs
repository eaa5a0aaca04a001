//! `ergopath check`: what a file is, what it says, what is assumed, and whether it is fine.

use super::check_file::explain;
use super::check_scenario;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::recording::read_map;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Any file (or folder) that ergopath reads or writes.
    pub file: PathBuf,
    /// Of a scenario: draw the cell with robot and person at start and goal.
    #[arg(long, value_name = "CELL.png")]
    pub figure: Option<PathBuf>,
    /// Of a scenario: what 2 cm, 5 deg or 10 % of error in each measured quantity would change.
    #[arg(long)]
    pub sensitivity: bool,
    /// With --sensitivity: a finished run whose best path is assessed; without it, the straight path.
    #[arg(long, value_name = "RESULT", requires = "sensitivity")]
    pub result: Option<PathBuf>,
    /// With --sensitivity: repetitions along each path.
    #[arg(long, value_name = "N", default_value_t = 64, requires = "sensitivity", value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub repetitions: u16,
    /// Of a file of markers or a table of points: what makes them the segments of a person.
    #[arg(long, value_name = "MAP.toml")]
    pub map: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// A file in words.
#[derive(Debug, Default, Serialize)]
pub(super) struct Explained {
    /// What it is.
    pub kind: String,
    /// What it says.
    pub says: Vec<String>,
    /// What holds because it does not say.
    pub defaults: Vec<String>,
    /// What a reader should know, without being a fault.
    pub notes: Vec<String>,
    /// What a reader should look at.
    pub warnings: Vec<String>,
    /// What keeps it from being of use.
    pub errors: Vec<String>,
}

impl Explained {
    pub(super) fn new(kind: impl Into<String>) -> Self {
        Self { kind: kind.into(), ..Self::default() }
    }

    #[must_use]
    pub(super) fn saying(mut self, line: impl Into<String>) -> Self {
        self.says.push(line.into());
        self
    }
}

/// Explains a file.
pub(super) fn run(args: &Args, outputs: Outputs) -> Result<Outcome, Failure> {
    let scenario = check_scenario::is_scenario(&args.file)?;
    if !scenario && (args.figure.is_some() || args.sensitivity) {
        let message = "is no scenario, so there is no cell to draw or to measure";
        return Err(InputError::new(&args.file, message)
            .remedy("name a scenario with --figure and --sensitivity")
            .into());
    }
    if scenario {
        return check_scenario::run(args, outputs);
    }
    let map = args.map.as_deref().map(read_map).transpose()?;
    let explained = explain(&args.file, map.as_ref())?;
    if args.json {
        print_json(&explained)?;
    } else {
        print(args, &explained);
    }
    Ok(outcome(&explained))
}

/// Errors are what `plan` would find too: nothing is feasible.
pub(super) fn outcome(explained: &Explained) -> Outcome {
    if explained.errors.is_empty() { Outcome::Done } else { Outcome::NothingFeasible }
}

pub(super) fn print_json(value: &impl Serialize) -> Result<(), InputError> {
    let text = serde_json::to_string_pretty(value);
    say!("{}", text.map_err(|e| InputError::fault("check", e.to_string()))?);
    Ok(())
}

pub(super) fn print(args: &Args, explained: &Explained) {
    say!("{}: {}", args.file.display(), explained.kind);
    for line in &explained.says {
        say!("  {line}");
    }
    for (heading, lines) in [
        ("Defaults used", &explained.defaults),
        ("Notes", &explained.notes),
        ("Warnings", &explained.warnings),
        ("Errors", &explained.errors),
    ] {
        if !lines.is_empty() {
            say!("\n{heading}");
            for line in lines {
                say!("  {line}");
            }
        }
    }
    if explained.errors.is_empty() && explained.warnings.is_empty() {
        say!("\nNo problems found.");
    }
}

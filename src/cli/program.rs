//! `ergopath program`: a path of a finished run as a program for the robot's controller.

use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, suggest};
use crate::planner::{CandidateResult, Freshness, RunResult, Status, freshness, read_result};
use crate::report::{Language, ProgramError, program};
use crate::scenario::read_scenario;
use crate::words;
use std::path::{Path, PathBuf};

/// Arguments of `program`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of a finished run, or its result.json.
    result: PathBuf,
    /// The controller's language.
    #[arg(long = "for", value_name = "LANGUAGE")]
    language: Controller,
    /// File to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Name or rank of the path; without it, the best one.
    #[arg(long, value_name = "ID|RANK")]
    path: Option<String>,
    /// How far the moves may be from the planned path, mm.
    #[arg(long, value_name = "MM", default_value_t = 0.5)]
    deviation_mm: f64,
    /// The run's scenario, which holds the robot's limits; without it, one of the recorded name is looked
    /// for as `report` does.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
}

/// Languages on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Controller {
    /// Universal Robots.
    Urscript,
    /// KUKA.
    Krl,
    /// ABB.
    Rapid,
    /// Franka: joint values for every millisecond, as CSV.
    Franka,
    /// ROS `JointTrajectory`, as YAML.
    Ros,
}

/// Least and largest deviation that makes sense, mm.
const DEVIATION_MM: [f64; 2] = [0.01, 10.0];

/// Writes the program.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let [least, most] = DEVIATION_MM;
    if !(least..=most).contains(&args.deviation_mm) {
        let message = format!("{} mm is not possible", args.deviation_mm);
        let remedy = format!("give {least} to {most} mm");
        return Err(InputError::new("--deviation-mm", message).remedy(remedy).into());
    }
    let result = read_result(&args.result)?;
    super::warn_of_unsealed(&result);
    let robot = robot_of(&result, args)?;
    let chosen = chosen(&result, args)?;
    let Some(path) = &chosen.path else {
        let message = format!("path `{}` was not kept as a path over time", chosen.id);
        return Err(InputError::new(&args.result, message)
            .remedy("name one of the ranked paths")
            .into());
    };
    let language = match args.language {
        Controller::Urscript => Language::UrScript,
        Controller::Krl => Language::Krl,
        Controller::Rapid => Language::Rapid,
        Controller::Franka => Language::Franka,
        Controller::Ros => Language::Ros,
    };
    let title = format!(
        "{}, {}, robot {}",
        result.setting.name,
        words::paths::path_and_id(chosen),
        robot.name
    );
    let made = program(language, &title, path, &robot, args.deviation_mm / 1e3).map_err(|e| {
        let error = InputError::new(&args.result, e.to_string());
        match e {
            ProgramError::OtherRobot { .. } => error.remedy("choose the language of this robot's controller"),
            ProgramError::BreaksLimits(_) => error.remedy(
                "plan with tighter [[robot.limit]] or a longer duration, or write smaller moves with --deviation-mm",
            ),
            ProgramError::NoMotion => error.remedy("name another path with --path"),
            ProgramError::Yaml(_) => InputError::fault(&args.output, e.to_string()),
        }
    })?;
    outputs.file(&args.output, made.text)?;
    outputs.write()?;
    for line in &made.says {
        say!("{line}");
    }
    say!("\n{}", args.output.display());
    Ok(Outcome::Done)
}

/// The robot with its limits, if they are still those of the run.
fn robot_of(result: &RunResult, args: &Args) -> Result<crate::robot::Robot, Failure> {
    let error = |message: String| {
        InputError::new(&args.result, message).remedy(
            "the limits of the joints are checked again on what is written: name the scenario of the run \
             with --scenario, or plan again",
        )
    };
    let scenario = match freshness(result, &args.result, args.scenario.as_deref())? {
        Freshness::Current(scenario) => scenario,
        Freshness::OutOfDate { changed, .. } => {
            return Err(
                error(format!("is out of date: {} changed since", changed.join(", "))).into()
            );
        }
        Freshness::NotFound(name) => {
            return Err(error(format!("its scenario `{name}` is not found")).into());
        }
    };
    Ok(read_scenario(&scenario)?.robot)
}

/// The path that was asked for: of those that keep all limits.
fn chosen<'a>(result: &'a RunResult, args: &Args) -> Result<&'a CandidateResult, Failure> {
    let place: &Path = &args.result;
    let refuse = |message: String, remedy: String| {
        Err(InputError::new(place, message).remedy(remedy).into())
    };
    let ranked = || result.candidates.iter().filter(|c| c.rank.is_some());
    let found = match &args.path {
        None => words::verdict::lead(result).filter(|_| result.verdict.is_decided()),
        Some(name) => {
            let rank = name.parse::<usize>().ok();
            let by_rank = rank.and_then(|r| ranked().find(|c| c.rank == Some(r)));
            result.candidates.iter().find(|c| c.id == *name).or(by_rank)
        }
    };
    let Some(found) = found else {
        let known: Vec<&str> = ranked().map(|c| c.id.as_str()).collect();
        return match &args.path {
            None => refuse(
                "names no best path".to_owned(),
                "its report.html says why; name a path that keeps all limits with --path"
                    .to_owned(),
            ),
            Some(name) => {
                let help = suggest(name, known.iter().copied());
                let help =
                    help.unwrap_or_else(|| format!("its ranked paths are: {}", known.join(", ")));
                refuse(format!("has no path `{name}`"), help)
            }
        };
    };
    if found.status != Status::Feasible {
        let why = words::refusal::reason(&found.status, &found.changes);
        let message = format!("path `{}` does not keep all limits: {why}", found.id);
        return refuse(
            message,
            "only paths that keep all limits are written as programs".to_owned(),
        );
    }
    Ok(found)
}

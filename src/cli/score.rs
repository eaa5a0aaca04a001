//! `ergopath score`: RULA and REBA of worksheets, of recorded motions and of sampled postures.

use super::score_motion;
use super::stdout::print_bytes;
use super::train::parse_side;
use super::{Failure, Outcome};
use crate::ergonomics::Profile;
use crate::files::{InputError, Outputs, read_bytes, suggest};
use crate::human::Side;
use crate::scoring::{Neck, score_table};
use std::path::{Path, PathBuf};

/// Arguments of `score`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A recording (MVNX, BVH, AMC with its ASF, MOT or STO file of coordinates, folder of rigid-body CSV files, or with --map C3D, TRC and
    /// tables), a CSV of joint angles, or a rollouts/<rank>.csv of `ergopath plan --rollouts`; two of the latter with --paired.
    #[arg(
        required_unless_present = "worksheet",
        conflicts_with = "worksheet",
        value_name = "MOTION"
    )]
    pub motions: Vec<PathBuf>,
    /// A CSV table of worksheets, a row for each posture and side: scores every row.
    #[arg(long, value_name = "IN.csv")]
    pub worksheet: Option<PathBuf>,
    /// Folder to write for a motion; only files that ergopath wrote there are replaced. File to write for worksheets;
    /// `-` or nothing prints the table.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Convention of scoring: `vignais2017`, `paper_strict`, `cornell2001` or `reference`.
    #[arg(long, value_parser = parse_profile, default_value = "vignais2017", value_name = "NAME")]
    pub profile: Profile,
    /// Body: a shipped one by name, or a URDF made by `ergopath body`.
    #[arg(long, value_name = "NAME|URDF")]
    pub body: Option<String>,
    /// Scenario that says body, side, stance, task and how the head is held.
    #[arg(long, value_name = "FILE.toml")]
    pub scenario: Option<PathBuf>,
    /// Which person of a folder with several.
    #[arg(long)]
    pub person: Option<String>,
    /// What makes the markers of C3D and TRC files, or the points of tables, the segments of a person.
    #[arg(long, value_name = "MAP.toml")]
    pub map: Option<PathBuf>,
    /// Arms to score: right, left or both; without it every arm that the motion knows.
    #[arg(long, value_parser = parse_sides, value_name = "right|left|both")]
    pub side: Option<Sides>,
    #[command(flatten)]
    pub task: TaskArgs,
    /// How the head is held: neutral, gaze (turned to the hand) or measured; by default measured where
    /// the motion holds it, else neutral.
    #[arg(long, value_parser = parse_neck, value_name = "neutral|gaze|measured")]
    pub neck: Option<Neck>,
    /// Also fill in worksheets of single frames, as HTML and CSV: times in s, or `worst`.
    #[arg(long, value_name = "TIME_S,..|worst", requires = "output")]
    pub sheet: Option<String>,
    /// Compare two files of the same repetitions.
    #[arg(long)]
    pub paired: bool,
    /// Print summary.json instead of the tables.
    #[arg(long)]
    pub json: bool,
}

/// What no motion shows.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Task")]
#[allow(clippy::struct_excessive_bools, reason = "a worksheet is a list of boxes to tick")]
pub(super) struct TaskArgs {
    /// Load on each scored hand, kg.
    #[arg(long, value_name = "KG", value_parser = not_negative, allow_negative_numbers = true, conflicts_with = "scenario")]
    pub load_kg: Option<f64>,
    /// Hold on the load (REBA): good, fair, poor or unacceptable.
    #[arg(long, value_name = "CLASS", value_parser = parse_coupling, conflicts_with = "scenario")]
    pub coupling: Option<u8>,
    /// How often the movement is repeated.
    #[arg(long, value_name = "N", value_parser = not_negative, allow_negative_numbers = true, conflicts_with = "scenario")]
    pub cycles_per_min: Option<f64>,
    /// Longest time for which a posture is held, s.
    #[arg(long, value_name = "S", value_parser = not_negative, allow_negative_numbers = true, conflicts_with = "scenario")]
    pub hold_s: Option<f64>,
    /// Shock, or force that builds up rapidly.
    #[arg(long, conflicts_with = "scenario")]
    pub shock: bool,
    /// The weight of the arm is supported, or the person leans.
    #[arg(long, conflicts_with = "scenario")]
    pub arm_supported: bool,
    /// The person sits.
    #[arg(long, conflicts_with = "scenario")]
    pub seated: bool,
    /// Height of the seat, m; implies --seated.
    #[arg(long, value_name = "M", value_parser = seat_height, conflicts_with = "scenario")]
    pub seat_height_m: Option<f64>,
    /// A backrest supports the trunk; needs --seated.
    #[arg(long, conflicts_with = "scenario")]
    pub trunk_supported: bool,
    /// Hours of lifting a day: the motion is a lift from its first to its last frame, to be judged by
    /// the NIOSH equation too (two hands, load and rate as given).
    #[arg(long, value_name = "H", value_parser = not_negative, allow_negative_numbers = true)]
    pub lift_hours: Option<f64>,
    /// Legs or feet are not evenly loaded.
    #[arg(long, conflicts_with = "scenario")]
    pub legs_unbalanced: bool,
}

/// Arms that were asked for.
#[derive(Debug, Clone)]
pub(super) struct Sides(pub Vec<Side>);

fn parse_sides(text: &str) -> Result<Sides, String> {
    if text.eq_ignore_ascii_case("both") {
        return Ok(Sides(vec![Side::Right, Side::Left]));
    }
    parse_side(text).map(|s| Sides(vec![s])).map_err(|_| "use right, left or both".to_owned())
}

fn parse_profile(text: &str) -> Result<Profile, String> {
    let names = Profile::names();
    Profile::by_name(text).ok_or_else(|| {
        suggest(text, names).unwrap_or_else(|| format!("known are: {}", names.join(", ")))
    })
}

fn parse_neck(text: &str) -> Result<Neck, String> {
    match text {
        "neutral" => Ok(Neck::Neutral),
        "gaze" => Ok(Neck::Gaze),
        "measured" => Ok(Neck::Measured),
        _ => Err(suggest(text, ["neutral", "gaze", "measured"])
            .unwrap_or_else(|| "use neutral, gaze or measured".to_owned())),
    }
}

fn parse_coupling(text: &str) -> Result<u8, String> {
    let classes = ["good", "fair", "poor", "unacceptable"];
    classes.iter().position(|c| *c == text).map(|i| i as u8).ok_or_else(|| {
        suggest(text, classes).unwrap_or_else(|| format!("use {}", classes.join(", ")))
    })
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
        _ => Err("give a number, 0 or more".to_owned()),
    }
}

fn seat_height(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if (0.1..=1.2).contains(&v) => Ok(v),
        _ => Err("give the height of the seat in m, 0.1 to 1.2".to_owned()),
    }
}

/// Scores and writes or prints.
pub(super) fn run(args: &Args, outputs: Outputs) -> Result<Outcome, Failure> {
    if let Some(table) = &args.worksheet {
        return worksheet(table, args, outputs);
    }
    if args.task.trunk_supported && !args.task.seated && args.task.seat_height_m.is_none() {
        return Err(InputError::new("--trunk-supported", "only a seat has a backrest")
            .remedy("add --seated, or leave it out")
            .into());
    }
    match (&args.motions[..], args.paired) {
        ([motion], false) => score_motion::single(motion, args, outputs),
        ([a, b], true) => score_motion::paired(a, b, args),
        (_, true) => Err(InputError::new("--paired", "compares exactly two files of rollouts")
            .remedy("ergopath score A.csv B.csv --paired --scenario FILE.toml")
            .into()),
        _ => Err(InputError::new("score", "scores one motion at a time")
            .remedy("run it once for each, or compare two files of rollouts with --paired")
            .into()),
    }
}

/// The output, unless it is standard output.
pub(super) fn file(output: Option<&PathBuf>) -> Option<&Path> {
    output.map(PathBuf::as_path).filter(|p| *p != Path::new("-"))
}

fn worksheet(table: &Path, args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let scored = score_table(table, &read_bytes(table)?, &args.profile)?;
    match file(args.output.as_ref()) {
        Some(path) => {
            outputs.file(path, scored.csv)?;
            outputs.write()?;
            let name = args.profile.name;
            say!("{}: {} rows scored, profile {name}", path.display(), scored.rows);
        }
        None => print_bytes(&scored.csv),
    }
    Ok(Outcome::Done)
}

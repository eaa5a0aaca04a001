//! `ergopath new`: writes a commented scenario from a handful of answers.

use super::questions::{Answers, Asker, names, number, place, terminal};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, suggest};
use crate::human::{Hands, NamedGrip};
use crate::planner::{Wanted, lay_out};
use crate::robot::PRESETS;
use crate::scenario::{Sketch, SketchRobot, ToolWay, parse_scenario};
use crate::words;
use clap::ValueEnum;
use std::path::{Path, PathBuf};

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario to write; nothing is ever overwritten. What is not given by options is asked on a terminal,
    /// and takes its default elsewhere.
    #[arg(value_name = "CELL.toml")]
    file: PathBuf,
    /// Name of the cell in reports; without it that of the file.
    #[arg(long)]
    name: Option<String>,
    /// Robot: a preset.
    #[arg(long, value_name = "PRESET", value_parser = robot, conflicts_with = "urdf")]
    robot: Option<&'static str>,
    /// Robot: a URDF file instead.
    #[arg(long, value_name = "FILE", requires_all = ["base_link", "tcp"])]
    urdf: Option<PathBuf>,
    /// With --urdf: the link on the mount.
    #[arg(long, value_name = "LINK", requires = "urdf")]
    base_link: Option<String>,
    /// With --urdf: the link of the tool's centre point.
    #[arg(long, value_name = "LINK", requires = "urdf")]
    tcp: Option<String>,
    /// Hands on the robot: right, left or both.
    #[arg(long, value_name = "HANDS", value_parser = hands)]
    hands: Option<Hands>,
    /// The worker sits on a seat of this height, m.
    #[arg(long, value_name = "M", value_parser = number, conflicts_with = "standing")]
    seat_height_m: Option<f64>,
    /// The worker stands.
    #[arg(long)]
    standing: bool,
    /// How the hand holds on.
    #[arg(long, value_name = "GRIP", value_parser = grip)]
    grip: Option<NamedGrip>,
    /// Place of the hand at the start, seen by the worker: metres ahead, to the left, above the floor.
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    from: Option<[f64; 3]>,
    /// The same at the goal.
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true)]
    to: Option<[f64; 3]>,
    /// Mass of the part, kg.
    #[arg(long, value_name = "KG", value_parser = number)]
    part_mass_kg: Option<f64>,
    /// Share of the part's weight that the worker carries, 0 to 1; without it a half.
    #[arg(long, value_name = "SHARE", value_parser = number)]
    load_share: Option<f64>,
    /// Bodies, as in a scenario; without it a woman and a man of medium height.
    #[arg(long = "body", value_name = "BODY")]
    bodies: Vec<String>,
    /// Where the tool points; without it what is usual at these heights.
    #[arg(long, value_name = "WAY")]
    tool: Option<Tool>,
    /// Floor point below the robot's mount: metres ahead of the worker, to the left; without it the first
    /// usual place from which the robot serves.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    robot_at: Option<[f64; 2]>,
    /// Height of the robot's mount, m; without it as the place.
    #[arg(long, value_name = "M", value_parser = number)]
    mount_height_m: Option<f64>,
}

/// Height of the hands below which two of them usually hold a box by its sides, m.
const LOW_M: f64 = 0.95;

/// Where the tool points.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Tool {
    /// The robot comes from above.
    Down,
    /// The robot stands on the far side.
    AtWorker,
}

fn robot(text: &str) -> Result<&'static str, String> {
    let known = PRESETS.into_iter().find(|p| *p == text);
    known.ok_or_else(|| no_such(text, &PRESETS))
}

fn grip(text: &str) -> Result<NamedGrip, String> {
    NamedGrip::by_name(text).ok_or_else(|| no_such(text, &NamedGrip::names()))
}

fn hands(text: &str) -> Result<Hands, String> {
    match text {
        "right" => Ok(Hands::Right),
        "left" => Ok(Hands::Left),
        "both" => Ok(Hands::Both),
        _ => Err(no_such(text, &["right", "left", "both"])),
    }
}

fn no_such(text: &str, known: &[&str]) -> String {
    suggest(text, known.iter().copied()).unwrap_or_else(|| format!("use one of: {}", names(known)))
}

fn point(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(|t| number(t.trim())).collect();
    numbers?.try_into().map_err(|_| "give two numbers, such as 0.9,0".to_owned())
}

/// A seat, or none.
fn seat(text: &str) -> Result<Option<f64>, String> {
    if text == "standing" { Ok(None) } else { number(text).map(Some) }
}

/// Asks, writes, and says what `check` would.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    refuse_place(&args.file)?;
    let (sketch, taken) = sketch(args, terminal())?;
    let wanted = Wanted {
        tool: args.tool.map(|t| match t {
            Tool::Down => ToolWay::Down,
            Tool::AtWorker => ToolWay::AtWorker,
        }),
        robot_at_m: args.robot_at,
        mount_height_m: args.mount_height_m,
    };
    let (sketch, look) = lay_out(&args.file, &sketch, &wanted)?;
    let text = sketch.text();
    // Asked for once more: questions take their time.
    refuse_place(&args.file)?;
    outputs.file(&args.file, text.as_str())?;
    outputs.write()?;

    let file = args.file.display();
    say!("{file}: a scenario, \"{}\"", sketch.name);
    for line in taken {
        say!("  taken, as nothing else was said: {line}");
    }
    let scenario = parse_scenario(&args.file, &text)?;
    say!(
        "  robot {} at ({}, {}) m, {} m high",
        scenario.robot.name,
        sketch.robot_at_m[0],
        sketch.robot_at_m[1],
        sketch.mount_height_m
    );
    for line in words::hand::at_the_start(&scenario) {
        say!("  {line}");
    }
    let findings = look.findings();
    for finding in &findings {
        let kind = if finding.is_error() { "error" } else { "warning" };
        say!("  {kind}: {}", words::look::sentence(finding));
    }
    say!("\nNext: ergopath check {file} --figure cell.png");
    say!("      ergopath plan {file} --planner quick -o out");
    let is_broken = findings.iter().any(crate::planner::CellFinding::is_error);
    Ok(if is_broken { Outcome::NothingFeasible } else { Outcome::Done })
}

/// Refuses what is there already, whatever it is, and what `check` would not take for a scenario.
fn refuse_place(file: &Path) -> Result<(), InputError> {
    if !file.extension().is_some_and(|x| x.eq_ignore_ascii_case("toml")) {
        let error = InputError::new(file, "the name of a scenario ends in .toml");
        return Err(error.remedy("for example cell.toml"));
    }
    if file.symlink_metadata().is_ok() {
        let error = InputError::new(file, "is there already, and `new` overwrites nothing");
        return Err(error.remedy("choose another name"));
    }
    Ok(())
}

/// From options, answers and defaults; the defaults that were taken without asking in words.
fn sketch(args: &Args, asker: Option<Asker>) -> Result<(Sketch, Vec<String>), InputError> {
    let mut answers = Answers::new(asker);
    let own_urdf = args.urdf.as_deref().map(|urdf| SketchRobot::Urdf {
        file: beside(urdf, &args.file),
        base_link: args.base_link.clone().unwrap_or_default(),
        tcp: args.tcp.clone().unwrap_or_default(),
    });
    let robot = if let Some(urdf) = own_urdf {
        urdf
    } else {
        let words = format!("Robot ({})", names(&PRESETS));
        let name = answers.of(args.robot, ("robot", &words), "ur10e", robot)?;
        SketchRobot::Preset(name.to_owned())
    };
    let hands_words = ("hands", "Hands on the robot (right, left, both)");
    let hands = answers.of(args.hands, hands_words, "right", hands)?;
    let given_seat = args.seat_height_m.map(Some).or(args.standing.then_some(None));
    let seat_words = ("seat_height_m", "Seat height in metres, or standing");
    let seat_height_m = answers.of(given_seat, seat_words, "standing", seat)?;
    let [start, goal] = usual_places(hands, seat_height_m);
    let how = "in metres ahead of the worker, to the left, above the floor";
    let words = format!("Place of the hand at the start, {how}");
    let start_m = answers.of(args.from, ("from", &words), &start, place)?;
    let words = format!("Place of the hand at the goal, {how}");
    let goal_m = answers.of(args.to, ("to", &words), &goal, place)?;
    // Two hands lift a low box by its sides; higher up recorded people hold upright handles more easily.
    let is_low = seat_height_m.is_none() && start_m[2].min(goal_m[2]) < LOW_M;
    let usual = if hands == Hands::Both && is_low { "box_side" } else { "vertical_handle" };
    let words = format!("Grip ({})", names(&NamedGrip::names()));
    let grip = answers.of(args.grip, ("grip", &words), usual, grip)?;
    let words = ("part_mass_kg", "Mass of the part in kilograms");
    let part_mass_kg = answers.of(args.part_mass_kg, words, "1", number)?;
    let stem = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let bodies = if args.bodies.is_empty() {
        vec!["female_p50".to_owned(), "male_p50".to_owned()]
    } else {
        args.bodies.clone()
    };
    let sketch = Sketch {
        name: args.name.clone().unwrap_or_else(|| stem.into_owned()),
        robot,
        bodies,
        hands,
        seat_height_m,
        grip,
        start_m,
        goal_m,
        part_mass_kg,
        load_share: args.load_share.unwrap_or(0.5),
        tool: ToolWay::Down,
        robot_at_m: [0.0; 2],
        mount_height_m: 0.0,
    };
    Ok((sketch, answers.taken))
}

/// Where a hand usually starts and ends, on its own side of the worker.
fn usual_places(hands: Hands, seat_height_m: Option<f64>) -> [String; 2] {
    let (side, inner) = match hands {
        Hands::Right => (-0.25, -0.05),
        Hands::Left => (0.25, 0.05),
        Hands::Both => (0.0, 0.0),
    };
    let heights = match seat_height_m {
        None => [1.0, 1.15],
        Some(seat) => [seat + 0.35, seat + 0.45],
    };
    [(0.4, side, heights[0]), (0.45, inner, heights[1])]
        .map(|(x, y, z)| format!("{x}, {y}, {z:.2}"))
}

/// A file as a scenario names it: relative where it lies beside the scenario or below.
fn beside(file: &Path, scenario: &Path) -> String {
    let whole = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_path_buf());
    let file = whole(file);
    let folder = whole(scenario);
    let shown = folder.parent().and_then(|f| file.strip_prefix(f).ok()).unwrap_or(&file);
    shown.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn line(words: &[&str]) -> Args {
        let words = ["new", "cell.toml"].iter().chain(words);
        Line::try_parse_from(words).unwrap_or_else(|e| panic!("{e}")).args
    }

    #[test]
    fn questions_are_asked_for_what_is_not_given() {
        let mut asked = Vec::new();
        let answer = |words: &str, default: &str| {
            asked.push(words.to_owned());
            Ok(if words.starts_with("Grip") { "palm_down_bar" } else { default }.to_owned())
        };
        let args = line(&["--hands", "left", "--seat-height-m", "0.5", "--to", "0.4,-0.1,0.9"]);
        let (sketch, taken) = sketch(&args, Some(Box::new(answer))).unwrap();
        assert!(taken.is_empty());
        assert_eq!(sketch.grip, NamedGrip::PalmDownBar);
        assert_eq!((sketch.hands, sketch.seat_height_m), (Hands::Left, Some(0.5)));
        assert_eq!((sketch.start_m, sketch.goal_m), ([0.4, 0.25, 0.85], [0.4, -0.1, 0.9]));
        let first: Vec<&str> = asked.iter().map(|a| &a[..4]).collect();
        assert_eq!(first, ["Robo", "Plac", "Grip", "Mass"]);
    }

    #[test]
    fn without_a_terminal_defaults_are_taken_and_said() {
        let (sketch, taken) = sketch(&line(&["--robot", "fr3"]), None).unwrap();
        assert_eq!(sketch.robot, SketchRobot::Preset("fr3".to_owned()));
        assert!(taken.contains(&"hands = right".to_owned()), "{taken:?}");
        assert_eq!(taken.len(), 6);
    }

    #[test]
    fn wrong_options_are_refused_with_a_suggestion() {
        for (words, remedy) in [
            (["--robot", "ur10"], "did you mean `ur10e`?"),
            (["--grip", "palm_down"], "did you mean `palm_down_bar`?"),
            (["--hands", "three"], "use one of: right, left, both"),
            (["--from", "1,2"], "three numbers"),
            (["--robot-at", "1"], "two numbers"),
            (["--part-mass-kg", "heavy"], "is no number"),
        ] {
            let words = ["new", "cell.toml"].iter().chain(&words);
            let Err(error) = Line::try_parse_from(words) else { panic!("{remedy}") };
            assert!(error.to_string().contains(remedy), "{error}");
        }
    }
}

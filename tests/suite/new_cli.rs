//! `ergopath new`: scenarios from a handful of answers, which check clean whatever the answers are.

use crate::common::{assert_refused, ergopath};
use crate::schema_cli::{as_json, schema};
use assert_cmd::Command;
use ergopath::human::NamedGrip;
use ergopath::planner::{CellLook, look_at_cell};
use ergopath::robot::PRESETS;
use ergopath::scenario::{Warning, read_scenario};
use predicates::prelude::*;
use predicates::str::contains;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

fn new(file: &Path) -> Command {
    let mut command = ergopath();
    command.arg("new").arg(file);
    command
}

/// The look of a scenario that says nothing but how the posture model was adapted.
fn clean(file: &Path, words: &[String]) -> CellLook {
    let scenario = read_scenario(file).unwrap();
    let odd = scenario.warnings.iter().find(|w| !matches!(w, Warning::Adapted(_)));
    assert!(odd.is_none(), "{words:?}: {odd:?}");
    let look = look_at_cell(&scenario).unwrap();
    assert!(look.findings().is_empty(), "{words:?}: {:?}", look.findings());
    look
}

/// Hands, side of the start, and heights of start and goal that they are used at, above the floor or the seat.
const STANDING: [[f64; 2]; 3] = [[1.0, 1.15], [0.8, 1.3], [1.2, 1.55]];
const SEATED: [[f64; 2]; 2] = [[0.35, 0.45], [0.3, 0.55]];

#[test]
fn every_combination_of_answers_checks_clean() {
    let room = tempfile::tempdir().unwrap();
    let mut all: Vec<Vec<String>> = Vec::new();
    for robot in PRESETS {
        for (hands, left) in [("right", -0.25), ("left", 0.25), ("both", 0.0)] {
            let mut ends: Vec<(Option<f64>, [f64; 2])> = STANDING.map(|h| (None, h)).to_vec();
            for seat in [0.42, 0.6] {
                ends.extend(SEATED.map(|h| (Some(seat), h.map(|above| seat + above))));
            }
            if hands == "both" {
                ends.push((None, [0.4, 1.0]));
            }
            for (seat, [low, high]) in ends {
                let mut words: Vec<String> =
                    ["--robot", robot, "--hands", hands].map(Into::into).to_vec();
                words.extend([
                    format!("--from=0.4,{left},{low}"),
                    format!("--to=0.45,{},{high}", 0.4 * left),
                ]);
                words.extend(seat.map_or_else(
                    || vec!["--standing".to_owned()],
                    |seat| vec![format!("--seat-height-m={seat}")],
                ));
                all.push(words);
            }
        }
    }
    assert_eq!(all.len(), PRESETS.len() * (3 * 7 + 1));
    let validator = schema("scenario");
    all.par_iter().enumerate().for_each(|(i, words)| {
        let file = room.path().join(format!("{i}.toml"));
        new(&file).args(words).assert().success();
        clean(&file, words);
        assert!(validator.is_valid(&as_json(&file)), "{words:?}");
    });
}

/// Every start posture that the recorded people suggest gets there, and most of them are usual ones; of the
/// left hand as of the right.
#[test]
fn named_grips_are_held_in_natural_postures() {
    let room = tempfile::tempdir().unwrap();
    let places = |grip| match grip {
        NamedGrip::SuitcaseHandle => ([0.25, 0.25, 0.75], [0.3, 0.25, 0.85]),
        NamedGrip::OverheadBar => ([0.45, 0.2, 1.6], [0.45, 0.1, 1.75]),
        NamedGrip::BoxSide | NamedGrip::PinchFromAbove => ([0.4, 0.2, 0.9], [0.45, 0.1, 1.05]),
        _ => ([0.4, 0.2, 1.0], [0.45, 0.05, 1.15]),
    };
    for grip in NamedGrip::ALL {
        let [right, left] = [("right", -1.0), ("left", 1.0)].map(|(hands, side)| {
            let file = room.path().join(format!("{}_{hands}.toml", grip.name()));
            let (from, to) = places(grip);
            let at = |[x, y, z]: [f64; 3]| format!("{x},{},{z}", side * y);
            let words = [
                format!("--hands={hands}"),
                format!("--grip={}", grip.name()),
                format!("--from={}", at(from)),
                format!("--to={}", at(to)),
                "--tool=at-worker".to_owned(),
            ];
            new(&file).args(&words).assert().success();
            let look = clean(&file, &words);
            for hand in &look.hands {
                assert_eq!(hand.reached, hand.tries, "{words:?}");
            }
            for along in &look.along {
                assert!(
                    along.unusual_starts < 0.25 && along.unsupported < 0.2,
                    "{words:?} {along:?}"
                );
            }
            look.along.iter().map(|a| a.unsupported).fold(0.0, f64::max)
        });
        assert!((right - left).abs() < 1e-6, "{grip:?}: {right} {left}");
    }
}

#[test]
fn a_written_cell_is_said_checked_and_planned() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("cell.toml");
    // Not on a terminal: defaults, said.
    let said = contains("taken, as nothing else was said: robot = ur10e")
        .and(contains("taken, as nothing else was said: grip = vertical_handle"))
        .and(contains("right hand at the start: at (0.400, -0.250, 1.000) m"))
        .and(contains("the palm faces left, the thumb is above, the wrist behind"));
    new(&file).assert().success().stdout(said);
    ergopath().arg("check").arg(&file).assert().success().stdout(contains("No problems found."));
    let text = std::fs::read_to_string(&file).unwrap();
    for words in ["# Grips: palm_down_bar", "# [[obstacle]]", "hold = \"free_roll\"   ", "# [free]"]
    {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    assert!(text.lines().all(|l| l.chars().count() <= 120), "{text}");
    // What it shows as comments can be used.
    let used = room.path().join("used.toml");
    let with: Vec<&str> = text
        .lines()
        .map(|l| {
            if l.starts_with("# [") || l.contains("_m = ") { l.trim_start_matches("# ") } else { l }
        })
        .collect();
    let with = with
        .join("\n")
        .replace("# name = \"bench\"", "name = \"bench\"")
        .replace("# shape", "shape");
    std::fs::write(&used, with).unwrap();
    assert_eq!(read_scenario(&used).unwrap().obstacles.len(), 1);
    let out = room.path().join("out");
    let mut plan = ergopath();
    plan.arg("plan").arg(&file).args(["--planner", "quick", "-o"]).arg(&out).assert().success();
    assert!(out.join("report.html").is_file());
}

#[test]
fn nothing_is_ever_overwritten() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("cell.toml");
    std::fs::write(&file, "mine").unwrap();
    assert_refused(&mut new(&file), "is there already");
    assert_refused(new(&file).arg("--overwrite"), "choose another name");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    // Not what ergopath wrote itself, either.
    let own = room.path().join("own.toml");
    new(&own).assert().success();
    let before = std::fs::read(&own).unwrap();
    assert_refused(new(&own).args(["--hands", "left"]), "overwrites nothing");
    assert_eq!(std::fs::read(&own).unwrap(), before);
    let folder = room.path().join("folder.toml");
    std::fs::create_dir(&folder).unwrap();
    assert_refused(&mut new(&folder), "is there already");
    #[cfg(unix)]
    {
        let link = room.path().join("link.toml");
        std::os::unix::fs::symlink(room.path().join("nowhere.toml"), &link).unwrap();
        assert_refused(&mut new(&link), "is there already");
        assert!(!room.path().join("nowhere.toml").exists());
    }
    assert_refused(&mut new(&room.path().join("cell.txt")), "ends in .toml");
}

#[test]
fn what_cannot_be_is_told() {
    let room = tempfile::tempdir().unwrap();
    let at = |name: &str| -> PathBuf { room.path().join(name) };
    // Written all the same, so that it can be mended.
    let far = contains("error: the hand of `female_p50` does not reach the start");
    new(&at("far.toml")).arg("--from=2.5,0,1").assert().code(3).stdout(far);
    assert!(at("far.toml").is_file());
    assert_refused(new(&at("mm.toml")).arg("--from=400,-250,1000"), "Is it in millimetres?");
    assert_refused(new(&at("share.toml")).arg("--load-share=30"), "outside 0 to 1");
    assert_refused(
        new(&at("body.toml")).args(["--body", "female_p5"]),
        "did you mean `female_p05`?",
    );
    assert_refused(
        new(&at("urdf.toml")).args(["--urdf", "none.urdf", "--base-link", "a", "--tcp", "b"]),
        "no such file",
    );
    for broken in ["mm.toml", "share.toml", "body.toml", "urdf.toml"] {
        assert!(!at(broken).exists(), "{broken}");
    }
    new(&at("a.toml")).args(["--urdf", "a.urdf"]).assert().code(2).stderr(contains("--base-link"));
}

#[test]
fn a_robot_of_ones_own_is_named_relative_to_the_scenario() {
    let room = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/robot/ur5e.urdf");
    std::fs::create_dir(room.path().join("robots")).unwrap();
    std::fs::copy(shipped, room.path().join("robots/arm.urdf")).unwrap();
    let mut command = ergopath();
    command.current_dir(room.path()).args(["new", "cell.toml", "--urdf", "robots/arm.urdf"]);
    command.args(["--base-link", "base_link", "--tcp", "tool0", "--name", "a \"cell\""]);
    command.assert().success();
    let text = std::fs::read_to_string(room.path().join("cell.toml")).unwrap();
    assert!(text.contains("urdf = \"robots/arm.urdf\""), "{text}");
    assert_eq!(read_scenario(&room.path().join("cell.toml")).unwrap().name, "a \"cell\"");
}

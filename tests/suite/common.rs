//! What tests of the whole program share: a small workplace, the program, and files as bytes.

#![allow(dead_code, unreachable_pub, reason = "each test file uses some of these")]

use crate::skips::shared;
use assert_cmd::Command;
use ergopath::posture::{load_model, save_model};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder with a scenario that plans fast, and the shipped posture model as a file of its own.
pub fn workplace() -> (TempDir, PathBuf) {
    let room = tempfile::tempdir().unwrap();
    let (model, _) = load_model("demo_operator", Path::new(".")).unwrap();
    save_model(&model, &room.path().join("operator.json")).unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bench_pick_and_place.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let text = text.replace("\"demo_operator\"", "\"operator.json\"");
    let planner = "schema = \"ergopath/planner/1\"\nname = \"tiny\"\nvias = 1\nnamed_offset_m = 0.1\n\
                   sampled_offset_m = 0.1\npopulation = 4\ngenerations = 2\nruns = 1\n\
                   baseline_generations = 1\nsteps = 30\nrollouts_first = 2\nrollouts_most = 3\n\
                   shortlist = 2\nreported = 2\n\
                   rollouts_final = 6\n[objective]\nexpected_rula = 1.0\nexpected_reba = 0.0\n\
                   cvar90_rula = 0.0\nexposure_rula_5 = 0.0\n";
    std::fs::write(room.path().join("tiny.toml"), planner).unwrap();
    let scenario = room.path().join("bench.toml");
    std::fs::write(&scenario, text).unwrap();
    (room, scenario)
}

pub fn ergopath() -> Command {
    Command::new(env!("CARGO_BIN_EXE_ergopath"))
}

pub fn plan(room: &TempDir, scenario: &Path, output: &str) -> Command {
    let mut command = ergopath();
    command.arg("plan").arg(scenario).arg("-o").arg(room.path().join(output));
    command.arg("--planner").arg(room.path().join("tiny.toml"));
    command
}

/// The first three movements of the shipped demonstration, as a file of its own in the folder.
pub fn short_demonstration(room: &Path) -> PathBuf {
    part_of_demonstration(room, "three.csv", 1..=3)
}

/// Some movements of the shipped demonstration (from 1), as a file of its own in the folder.
pub fn part_of_demonstration(
    room: &Path,
    name: &str,
    movements: std::ops::RangeInclusive<u32>,
) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios/demonstrations/simulated_operator.csv");
    let text = std::fs::read_to_string(shipped).unwrap();
    let is_kept = |line: &&str| {
        let trial = line.split(',').next().and_then(|t| t.parse::<u32>().ok());
        trial.is_none_or(|t| movements.contains(&t))
    };
    let path = room.join(name);
    std::fs::write(&path, text.lines().filter(is_kept).collect::<Vec<_>>().join("\n")).unwrap();
    path
}

/// All files below a folder with their bytes.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in at.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                all.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    all
}

/// How many cells of a batch are done, while it may be at work.
pub fn cells_done(folder: &Path) -> usize {
    let all = folder.join("cells").read_dir().into_iter().flatten().flatten();
    all.filter(|cell| cell.path().join("cell.json").is_file()).count()
}

/// Refused as wrong input with these words, however the message is wrapped on the screen.
pub fn assert_refused(command: &mut Command, words: &str) {
    let output = command.assert().code(2).get_output().clone();
    let shown = String::from_utf8(output.stderr).unwrap();
    let flat = shown.replace(['\n', '│'], " ");
    let flat = flat.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains(words), "`{words}` is missing in:\n{shown}");
}

/// A people file of some people of the shared recordings, with so many deposits and high grabs of each; none without
/// the recordings.
pub fn people_file(names: &[&str], takes: [usize; 2], folder: &Path) -> Option<PathBuf> {
    let recordings = shared("recordings/hdm05")?;
    let first = |name: &str, task: &str, count: usize| {
        let mut found: Vec<String> = std::fs::read_dir(&recordings)
            .unwrap()
            .map(|e| e.unwrap().path().display().to_string())
            .filter(|p| p.contains(&format!("HDM_{name}_{task}")))
            .collect();
        found.sort();
        found.truncate(count);
        found
    };
    let mut text = String::from("schema = \"ergopath/people/1\"\n");
    for name in names {
        let [deposits, grabs] = takes;
        let own =
            [first(name, "depositFloorR", deposits), first(name, "grabHighR", grabs)].concat();
        write!(text, "[[person]]\nname = \"{name}\"\nrecordings = {own:?}\n").unwrap();
    }
    let path = folder.join("people.toml");
    std::fs::write(&path, text).unwrap();
    Some(path)
}

/// The text of a file of ours that was edited, without the checksum that no longer fits.
pub fn unsealed(edited: &serde_json::Value) -> String {
    let mut edited = edited.clone();
    edited.as_object_mut().unwrap().remove(ergopath::files::CHECKSUM);
    edited.to_string()
}

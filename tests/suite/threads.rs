//! Same bytes from every command that computes, with one, two and three threads. (`evaluate` tells how long it took;
//! its figures are compared beside its other tests, those of `bench` too.)

use crate::common::{ergopath, files, people_file, short_demonstration, workplace};
use crate::skips::shared;
use std::collections::BTreeMap;
use std::path::Path;

/// All files that commands write in a folder, and what they print. `{}` in a word is the folder of inputs.
fn made(
    threads: &str,
    inputs: &Path,
    commands: &[(&str, Vec<String>)],
) -> BTreeMap<String, Vec<u8>> {
    let room = tempfile::tempdir().unwrap();
    let mut all = BTreeMap::new();
    for (name, words) in commands {
        let mut command = ergopath();
        command.env("RAYON_NUM_THREADS", threads).current_dir(room.path());
        let words = words.iter().map(|w| w.replace("{}", &inputs.display().to_string()));
        let output = command.args(words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!([Some(0), Some(3)].contains(&output.status.code()), "{name}: {said}");
        if name.ends_with(" --json") {
            all.insert((*name).to_owned(), output.stdout);
        }
    }
    all.extend(files(room.path()));
    all
}

fn same_with_any_number_of_threads(inputs: &Path, commands: &[(&str, Vec<String>)]) {
    let one = made("1", inputs, commands);
    assert!(one.len() >= commands.len());
    for threads in ["2", "3"] {
        let other = made(threads, inputs, commands);
        assert!(one.keys().eq(other.keys()), "other files with {threads} threads");
        for (name, bytes) in &one {
            assert!(*bytes == other[name], "{name} differs with {threads} threads");
        }
    }
}

fn words(line: &str) -> Vec<String> {
    line.split(' ').map(str::to_owned).collect()
}

#[test]
fn training_planning_and_reporting_give_the_same_bytes_with_any_number_of_threads() {
    let (room, scenario) = workplace();
    short_demonstration(room.path());
    let text = std::fs::read_to_string(&scenario).unwrap();
    std::fs::write(room.path().join("own.toml"), text.replace("operator.json", "own.json"))
        .unwrap();
    let batch = "schema = \"ergopath/batch/1\"\nname = \"two\"\nscenarios = [\"bench.toml\"]\n\
                 planners = [\"tiny.toml\"]\n[matrix]\nmotion.duration_s = [4.0, 5.0]\n";
    std::fs::write(room.path().join("batch.toml"), batch).unwrap();
    let commands = [
        ("train", words("train {}/three.csv --body female_p50 -o model.json")),
        ("plan", words("plan {}/bench.toml --planner {}/tiny.toml --rollouts -o planned")),
        (
            "assess",
            words("assess {}/bench.toml --planner {}/tiny.toml --path planned/paths/2.csv -o own"),
        ),
        ("report", words("report planned --scenario {}/bench.toml --one-page -o again")),
        ("batch", words("batch {}/batch.toml -o cells")),
        ("score", words("score planned/rollouts/1.csv --scenario {}/bench.toml -o scored")),
        ("compare", words("compare planned own -o side.html")),
    ];
    same_with_any_number_of_threads(room.path(), &commands);
}

#[test]
fn models_of_people_are_the_same_with_any_number_of_threads() {
    let room = tempfile::tempdir().unwrap();
    if people_file(&["bk", "tr"], [1, 1], room.path()).is_none() {
        return;
    }
    let Some(recordings) = shared("recordings/hdm05") else { return };
    let clip = recordings.join("HDM_bd_depositFloorR_001_120.amc").display().to_string();
    let commands = [
        ("train", words("train {}/people.toml --body male_p50 -o two.json")),
        ("adapt", words(&format!("adapt people {clip} -o anna.json"))),
        ("validate --json", words("validate {}/people.toml --json")),
        ("import", words(&format!("import {clip} -o imported"))),
    ];
    same_with_any_number_of_threads(room.path(), &commands);
}

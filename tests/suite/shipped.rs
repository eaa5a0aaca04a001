//! What ships works: every scenario plans, and the example in `reports/` is what the program makes.

use crate::common::ergopath;
use assert_cmd::Command;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn plan(scenario: &Path, output: &Path, planner: &str) -> Command {
    let mut command = ergopath();
    command.arg("plan").arg(scenario).arg("-o").arg(output).args(["--planner", planner]);
    command
}

#[test]
fn every_shipped_scenario_ends_in_a_report() {
    let room = tempfile::tempdir().unwrap();
    let mut count = 0;
    for entry in project("scenarios").read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|x| x == "toml") {
            let output = room.path().join(path.file_stem().unwrap());
            plan(&path, &output, "quick").assert().success();
            assert!(output.join("report.html").is_file());
            assert_possible(&output.join("result.json"));
            count += 1;
        }
    }
    assert!(count >= 3);
}

/// Hands on their paths and people in balance, in every repetition of every path that is reported.
fn assert_possible(place: &Path) {
    let result = ergopath::planner::read_result(place).unwrap();
    let mut seen = 0;
    for (path, body) in result.candidates.iter().flat_map(|c| c.bodies.iter().map(move |b| (c, b)))
    {
        let name = format!("{}, {} of {}", place.display(), body.body, path.id);
        seen += body.rollouts;
        assert!(body.hand_residual_max_mm < 1.0, "{name}: {} mm", body.hand_residual_max_mm);
        if let Some(margin) = body.strain.as_ref().and_then(|s| s.balance_margin_m) {
            assert!(margin.p05 > 0.0, "{name}: {margin:?}");
        }
    }
    assert!(seen > 0);
}

#[test]
fn the_kept_example_is_what_the_command_makes() {
    let room = tempfile::tempdir().unwrap();
    let output = room.path().join("out");
    plan(&project("scenarios/bench_pick_and_place.toml"), &output, "default").assert().success();
    let rows = |path: PathBuf| -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(path).unwrap();
        reader.deserialize().map(Result::unwrap).collect()
    };
    let kept = rows(project("reports/example/candidates.csv"));
    let made = rows(output.join("candidates.csv"));
    assert_eq!(kept.len(), made.len());
    for old in kept.iter().filter(|r| r["evaluated"] == "reported") {
        let new = made
            .iter()
            .find(|r| r["id"] == old["id"])
            .unwrap_or_else(|| panic!("{} is gone", old["id"]));
        // Another processor may round differently, which can move a frame over a threshold.
        let (a, b): (f64, f64) =
            (old["expected_rula"].parse().unwrap(), new["expected_rula"].parse().unwrap());
        assert!((a - b).abs() < 0.02, "{}: expected RULA {a} became {b}", old["id"]);
    }
}

#[test]
fn shipped_models_are_of_the_shipped_movements() {
    for (model, movements) in
        [("demo_operator", "simulated_operator"), ("whole_operator", "whole_operator")]
    {
        let (model, _) = ergopath::posture::load_model(model, Path::new(".")).unwrap();
        let file = project(&format!("scenarios/demonstrations/{movements}.csv"));
        let sha256 = ergopath::files::sha256_hex(&std::fs::read(file).unwrap());
        assert_eq!(model.provenance.recordings, [(format!("{movements}.csv"), sha256)]);
        assert!(model.provenance.simulated);
    }
}

#[test]
fn the_model_of_recorded_people_is_of_the_recordings_that_it_names() {
    let (model, _) = ergopath::posture::load_model("people", Path::new(".")).unwrap();
    let made_from = &model.provenance;
    assert!(!made_from.simulated && made_from.people == 5);
    assert_eq!(model.modes.as_ref().map(|modes| modes.low.len()), Some(32));
    // Whoever passes the model on says whose data it is derived from, and under which licence.
    let card = std::fs::read_to_string(project("models/posture/people.md")).unwrap();
    for text in [&made_from.notes[0], &card] {
        assert!(text.contains("The data used in this project was obtained from HDM05"), "{text}");
        assert!(text.contains("CC BY-SA 3.0"), "{text}");
    }
    assert_eq!(made_from.recordings.len(), 61);
    let check = ergopath().arg("check").arg(project("models/posture/people.json")).assert().code(0);
    let said = String::from_utf8_lossy(&check.get_output().stdout).into_owned();
    assert!(said.contains("from 61 recordings of 5 people, HDM_bd_depositFloorR_001"), "{said}");
    let Some(folder) = crate::skips::shared("recordings/hdm05") else { return };
    for (name, sha256) in &made_from.recordings {
        let (motion, person) = name.split_once(" of ").unwrap();
        let mut bytes = std::fs::read(folder.join(format!("HDM_{person}.asf"))).unwrap();
        bytes.extend(std::fs::read(folder.join(motion)).unwrap());
        assert_eq!(&ergopath::files::sha256_hex(&bytes), sha256, "{name}");
    }
}

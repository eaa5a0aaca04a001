//! `ergopath check`: files of every kind in words, the cell before planning, and what to measure well.

use crate::common::{assert_refused, ergopath, plan, workplace};
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use std::path::Path;

fn check(path: &Path) -> assert_cmd::assert::Assert {
    ergopath().arg("check").arg(path).assert()
}

fn repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn every_file_of_a_run_and_every_shipped_file_is_explained() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").arg("--rollouts").assert().success();
    let out = room.path().join("out");
    let kinds = [
        ("result.json", "a finished run"),
        ("candidates.csv", "all paths of a run"),
        ("paths/1.csv", "a path of the TCP"),
        ("paths/1.joint_trajectory.yaml", "those of the preset `panda`"),
        ("paths/1.joint_trajectory.json", "those of the preset `panda`"),
        ("rollouts/1.csv", "6 repetitions"),
    ];
    for (file, words) in kinds {
        check(&out.join(file))
            .success()
            .stdout(contains(words).and(contains("No problems found.")));
    }
    check(&out).success().stdout(contains("a finished run"));
    check(&room.path().join("operator.json")).success().stdout(contains("a posture model"));
    check(&room.path().join("tiny.toml"))
        .success()
        .stdout(contains("objective: 1 x expected RULA"));
    let demonstration = repository("scenarios/demonstrations/simulated_operator.csv");
    check(&demonstration).success().stdout(contains("simulated operator").and(contains("trials")));
    for (folder, ending) in
        [("scenarios", ".toml"), ("planners", ".toml"), ("models/human", ".urdf")]
    {
        let all = repository(folder).read_dir().unwrap().map(|e| e.unwrap().path());
        let mut seen = 0;
        for file in all.filter(|p| p.display().to_string().ends_with(ending)) {
            check(&file).success();
            seen += 1;
        }
        assert!(seen > 2, "{folder}");
    }
    check(&repository("models/human/male_p95.body.toml")).success().stdout(contains("a body"));
    check(&repository("models/robot/ur5e.urdf")).success().stdout(contains("a chain of links"));
}

#[test]
fn what_is_broken_or_unknown_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: &str, words: &str| {
        let path = room.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert_refused(ergopath().arg("check").arg(&path), words);
    };
    refused("a.txt", "hello", "is no kind of file");
    refused("a.toml", "x = 1\n", "has no schema");
    refused("a.json", "{\"schema\": \"ergopath/result/2\", ", "ends in the middle");
    refused("b.json", "{\"schema\": \"other/1\"}", "does not know");
    refused("a.csv", "colour,size\nred,1\n", "does not know: colour, size");
    refused("b.csv", "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,0,2,0,0,0\n", "norm 2.0000");
    refused("c.toml", "schema = \"ergopath/scenario/1\"\nworker = [", "c.toml");
    refused("a.yaml", "points: 3\n", "is no JointTrajectory");
    refused("p_chest_pose_saved.csv", "a,b\n1,2\n", "one body of a rigid-body recording");
    let none = room.path().join("none.toml");
    assert_refused(ergopath().arg("check").arg(none), "no such file");
    let figure = room.path().join("cell.png");
    let mut command = ergopath();
    command.arg("check").arg(repository("planners/quick.toml")).arg("--figure").arg(&figure);
    assert_refused(&mut command, "is no scenario");
    assert!(!figure.exists());
}

#[test]
fn a_scenario_is_looked_at_without_planning() {
    let (room, scenario) = workplace();
    let figure = room.path().join("cell.png");
    let mut command = ergopath();
    command.arg("check").arg(&scenario).arg("--figure").arg(&figure);
    let words = contains("start: 16 of 16 start postures of `female_p50` reach it")
        .and(contains("goal: the robot reaches it"))
        .and(contains("worker.other_arm: predicted: it hangs under its shoulder"))
        .and(contains("limits.").and(contains("\nErrors").not()));
    command.assert().success().stdout(words);
    assert!(std::fs::read(&figure).unwrap().starts_with(b"\x89PNG"));
    // A goal that nobody reaches.
    let text = std::fs::read_to_string(&scenario).unwrap();
    let far = room.path().join("far.toml");
    std::fs::write(&far, text.replace("[0.45, 0.25, 1.25]", "[2.45, 0.25, 1.25]")).unwrap();
    let words = contains("the robot does not reach the goal").and(contains("mm nearer"));
    check(&far).code(3).stdout(words.and(contains("No problems found.").not()));
}

#[test]
fn what_to_measure_well_is_told_for_the_same_people() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let json = |extra: &[&str]| -> Value {
        let mut command = ergopath();
        command.arg("check").arg(&scenario).args(["--sensitivity", "--repetitions", "6", "--json"]);
        let output = command.args(extra).assert().success().get_output().stdout.clone();
        serde_json::from_slice(&output).unwrap()
    };
    let straight = json(&[]);
    let s = &straight["sensitivity"];
    assert_eq!(s["path"], "straight");
    assert!(s["nominal"]["against_straight"].is_null());
    let all = s["quantities"].as_array().unwrap();
    let keys: Vec<&str> = all.iter().map(|q| q["key"].as_str().unwrap()).collect();
    for key in ["start.position_m z", "goal.position_m x", "worker.at_m y", "worker.facing_deg"] {
        assert!(keys.contains(&key), "{keys:?}");
    }
    // Largest first, and moving the robot (with its path) is moving the worker the other way.
    let change = |q: &Value| q["rula_change"].as_f64().unwrap().abs();
    assert!(all.windows(2).all(|w| change(&w[0]) >= change(&w[1])));
    let of = |key: &str, side: &str| {
        let q = all.iter().find(|q| q["key"] == key).unwrap();
        q[side]["expected_rula"].as_f64().unwrap()
    };
    for axis in ["x", "y"] {
        let robot = of(&format!("robot.base.position_m {axis}"), "more");
        let worker = of(&format!("worker.at_m {axis}"), "less");
        assert!((robot - worker).abs() < 1e-6, "{axis}: {robot} {worker}");
    }
    assert!(of("goal.position_m z", "less") != of("goal.position_m z", "more"));
    assert_eq!(json(&[]), straight);

    let out = room.path().join("out").display().to_string();
    let best = json(&["--result", &out]);
    let nominal = &best["sensitivity"]["nominal"];
    assert!(best["sensitivity"]["path"] == "straight" || nominal["against_straight"]["n"] == 6);
}

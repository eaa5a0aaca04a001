//! The program as its user meets it: planning, assessing, and what it refuses.

use crate::common::{ergopath, files, plan, workplace};
use predicates::prelude::*;
use std::path::Path;

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let (room, scenario) = workplace();
    for (folder, threads) in [("one", "1"), ("two", "2"), ("again", "2")] {
        plan(&room, &scenario, folder).args(["--threads", threads]).assert().success();
    }
    let one = files(&room.path().join("one"));
    assert!(one.contains_key("result.json") && one.contains_key("report.html"));
    assert!(one.contains_key("candidates.csv") && one.contains_key("paths/1.csv"));
    for other in ["two", "again"] {
        let other = files(&room.path().join(other));
        assert!(one.keys().eq(other.keys()));
        for (name, bytes) in &one {
            assert!(bytes == &other[name], "{name} differs");
        }
    }
    // Nothing in them depends on where or when they were made.
    let place = room.path().display().to_string();
    for (name, bytes) in &one {
        let text = String::from_utf8_lossy(bytes);
        assert!(!text.contains(&place), "{name} holds an absolute path");
    }
    plan(&room, &scenario, "other").args(["--seed", "9"]).assert().success();
    assert_ne!(one["result.json"], files(&room.path().join("other"))["result.json"]);
}

#[test]
fn numbers_hang_together() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let text = std::fs::read_to_string(room.path().join("out/result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(result["schema"], "ergopath/result/2");
    assert_eq!(result["verdict"]["caveat"], "demonstration_model");
    for candidate in result["candidates"].as_array().unwrap() {
        for body in candidate["bodies"].as_array().unwrap() {
            let rula = &body["rula"];
            let by_rollout: Vec<f64> = rula["by_rollout"]
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap())
                .collect();
            let mean = by_rollout.iter().sum::<f64>() / by_rollout.len() as f64;
            assert!((mean - rula["expected"].as_f64().unwrap()).abs() < 1e-9);
            // E[s] = sum over k of P[s >= k].
            let exposure: f64 = rula["exposure"]
                .as_array()
                .unwrap()
                .iter()
                .skip(1)
                .map(|v| v.as_f64().unwrap())
                .sum();
            assert!((exposure - mean).abs() < 1e-9);
            assert!(body["hand_residual_max_mm"].as_f64().unwrap() < 1.0);
        }
    }
}

#[test]
fn a_planned_path_can_be_assessed_and_is_found_in_order() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let own = room.path().join("today.csv");
    std::fs::copy(room.path().join("out/paths/1.csv"), &own).unwrap();
    let assess = |path: &Path, folder: &str| {
        let mut command = ergopath();
        command.arg("assess").arg(&scenario).arg("--path").arg(path);
        command.arg("-o").arg(room.path().join(folder));
        command.arg("--planner").arg(room.path().join("tiny.toml"));
        command
    };
    assess(&own, "assessed").assert().success().stdout(predicate::str::contains("today"));
    let text = std::fs::read_to_string(room.path().join("assessed/result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&text).unwrap();
    let today = |r: &serde_json::Value| -> serde_json::Value {
        let all = r["candidates"].as_array().unwrap();
        all.iter().find(|c| c["id"] == "today").unwrap().clone()
    };
    assert_eq!(today(&result)["status"]["state"], "feasible");

    // Twice as fast: over the limits, scored all the same.
    let text = std::fs::read_to_string(&own).unwrap();
    let fast: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(i, line)| match line.split_once(',') {
            Some((t, rest)) if i > 0 => format!("{},{rest}", t.parse::<f64>().unwrap() / 4.0),
            _ => line.to_owned(),
        })
        .collect();
    std::fs::write(&own, fast.join("\n")).unwrap();
    assess(&own, "fast").assert().stdout(predicate::str::contains("exceeds limits"));
    let text = std::fs::read_to_string(room.path().join("fast/result.json")).unwrap();
    let marked = today(&serde_json::from_str(&text).unwrap());
    assert_eq!(marked["status"]["state"], "marked");
    assert!(marked["bodies"][0]["rula"]["expected"].as_f64().unwrap() >= 1.0);
}

/// Replaces text in the scenario, expects refusal with these words and that nothing is written.
fn refused(from: &str, to: &str, code: i32, words: &[&str]) {
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(&scenario, text.replacen(from, to, 1)).unwrap();
    let before = files(room.path()).len();
    let output = plan(&room, &scenario, "out").assert().code(code).get_output().clone();
    let shown =
        String::from_utf8(output.stderr).unwrap() + &String::from_utf8(output.stdout).unwrap();
    // Long messages are wrapped on the screen.
    let flat = shown.replace(['\n', '│'], " ");
    let flat = flat.split_whitespace().collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(flat.contains(word), "`{word}` is missing in:\n{shown}");
    }
    if code == 2 {
        assert_eq!(files(room.path()).len(), before, "something was written");
    }
}

#[test]
fn a_misspelt_key_gets_line_caret_and_suggestion() {
    refused(
        "facing_deg",
        "facing_degree",
        2,
        &["bench.toml:14", "unknown field", "did you mean `facing_deg`?"],
    );
}

#[test]
fn bad_values_are_named() {
    refused("duration_s = 4.0", "duration_s = nan", 2, &["motion.duration_s", "NaN"]);
    refused("[0.45, 0.25, 1.25]", "[0.45, inf, 1.25]", 2, &["goal.position_m", "metres"]);
    refused(
        "human_load_share = 0.3",
        "human_load_share = 30",
        2,
        &["task.human_load_share", "0 to 1"],
    );
    refused(
        "size_m = [0.8, 1.6, 0.72]",
        "size_m = [0.8, -1.6, 0.72]",
        2,
        &["bench", "sizes must be 0.001 to 100"],
    );
    refused("ergopath/scenario/1", "ergopath/scenario/2", 2, &["schema"]);
    let limits = "speed_m_s = 0.5";
    let with = |key: &str| format!("{limits}\n{key}");
    let (far, share) = ("limits.person_clearance_m", "limits.person_clearance_share");
    refused(limits, &with("person_clearance_m = 50"), 2, &[far, "0 to 1", "metres"]);
    refused(limits, &with("person_clearance_share = 5"), 2, &[share, "0 to 1"]);
    refused(limits, &with("person_clearence_m = 0.05"), 2, &["did you mean `person_clearance_m`?"]);
}

#[test]
fn missing_things_are_named() {
    refused("operator.json", "operater.json", 2, &["operater.json", "no such file"]);
    refused("\"female_p50\"", "\"female_50\"", 2, &["did you mean `female_p50`?"]);
    refused("\"panda\"", "\"pandda\"", 2, &["did you mean `panda`?"]);
    refused("stance = \"standing\"", "stance = \"seated\"", 2, &["seat_height_m is missing"]);
    let (room, _) = workplace();
    plan(&room, Path::new("nowhere.toml"), "out")
        .assert()
        .code(2)
        .stderr(predicate::str::contains("no such file"));
}

#[test]
fn what_cannot_be_done_is_explained() {
    let goal = "[0.45, 0.25, 1.25]";
    refused(goal, "[0.45, 0.90, 1.25]", 3, &["goal is outside the workspace box", "0.900 m"]);
    refused("duration_s = 4.0", "duration_s = 1.0", 3, &["too short", "needs at least"]);
    let nearer = &["start is out of reach of body `female_p50`", "What would help", "nearer"];
    refused("at_m = [0.0, 0.0]", "at_m = [-1.5, 0.0]", 3, nearer);
    // Within the ball that no posture leaves, but out of reach of the hand as it is led.
    refused("at_m = [0.0, 0.0]", "at_m = [-0.6, 0.0]", 3, &["cannot follow", "reach is exceeded"]);
    let inside =
        &["start is inside obstacle `bench`, 60 mm deep", "What would help", "60 mm smaller"];
    refused("size_m = [0.8, 1.6, 0.72]", "size_m = [0.8, 1.6, 1.30]", 3, inside);
    let slow = "preset = \"panda\"\nlimit = [{ joint = \"panda_joint1\", velocity_rad_s = 0.05 }]";
    let longer = &["joint `panda_joint1`", "instead of 4.00 s", "instead of 0.05 rad/s"];
    refused("preset = \"panda\"", slow, 3, longer);
    let wide = "speed_m_s = 0.5\nperson_clearance_m = 0.5";
    let near = &["comes nearer than 500 mm to body `female_p50`", "Nearest to feasible is"];
    refused("speed_m_s = 0.5", wide, 3, near);
    refused("max_m = [0.80, 0.60, 1.60]", "max_m = [2.80, 0.60, 1.60]", 0, &[]);
}

#[test]
fn a_folder_of_somebody_else_is_left_alone() {
    let (room, scenario) = workplace();
    let theirs = room.path().join("thesis");
    std::fs::create_dir(&theirs).unwrap();
    std::fs::write(theirs.join("chapter.tex"), "x").unwrap();
    plan(&room, &scenario, "thesis")
        .assert()
        .code(2)
        .stderr(predicate::str::contains("not an ergopath output folder"));
    assert_eq!(files(&theirs).len(), 1);
}

#[test]
fn turning_and_moving_the_whole_cell_changes_nothing() {
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let here = format!("{text}\n[[path]]\nname = \"drawn\"\nvia_m = [[0.42, -0.05, 1.20]]\n");
    // A quarter turn about z, then (1, 2, 0).
    let mut there = here.clone();
    for (from, to) in [
        ("at_m = [0.0, 0.0]", "at_m = [1.0, 2.0]"),
        ("facing_deg = 0", "facing_deg = 90"),
        ("[0.95, 0.0, 0.75], rpy_deg = [0, 0, 180]", "[1.0, 2.95, 0.75], rpy_deg = [0, 0, 270]"),
        (
            "[0.42, -0.35, 0.95]\nrpy_deg = [180, 0, 0]",
            "[1.35, 2.42, 0.95]\nrpy_deg = [180, 0, 90]",
        ),
        ("[0.45, 0.25, 1.25]\nrpy_deg = [180, 0, 0]", "[0.75, 2.45, 1.25]\nrpy_deg = [180, 0, 90]"),
        ("min_m = [0.25, -0.60, 0.80]", "min_m = [0.40, 2.25, 0.80]"),
        ("max_m = [0.80, 0.60, 1.60]", "max_m = [1.60, 2.80, 1.60]"),
        ("position_m = [0.75, 0.0, 0.36]", "position_m = [1.0, 2.75, 0.36]"),
        ("size_m = [0.8, 1.6, 0.72]", "size_m = [1.6, 0.8, 0.72]"),
        ("[[0.42, -0.05, 1.20]]", "[[1.05, 2.42, 1.20]]"),
    ] {
        assert!(there.contains(from), "{from}");
        there = there.replacen(from, to, 1);
    }
    let mut scores = Vec::new();
    for (name, text) in [("here", here), ("there", there)] {
        std::fs::write(&scenario, text).unwrap();
        let mut command = ergopath();
        command.arg("assess").arg(&scenario).arg("-o").arg(room.path().join(name));
        command.arg("--planner").arg(room.path().join("tiny.toml")).assert().success();
        let result = std::fs::read_to_string(room.path().join(name).join("result.json")).unwrap();
        let result: serde_json::Value = serde_json::from_str(&result).unwrap();
        let all = result["candidates"].as_array().unwrap();
        let drawn = all.iter().find(|c| c["id"] == "drawn").unwrap();
        scores.push(drawn["bodies"][0]["rula"]["by_rollout"].clone());
    }
    let values = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    for (a, b) in values(&scores[0]).iter().zip(values(&scores[1])) {
        // One frame of 31 may sit on a threshold and turn with the last bit.
        assert!((a - b).abs() < 1.5 / 31.0, "{a} {b}");
    }
}

#[test]
fn a_batch_survives_a_broken_scenario() {
    let (room, scenario) = workplace();
    let broken = room.path().join("broken.toml");
    let text = std::fs::read_to_string(&scenario).unwrap();
    std::fs::write(&broken, text.replace("facing_deg", "facing_degree")).unwrap();
    let out = room.path().join("batch");
    let mut batch = ergopath();
    batch.arg("batch").arg(&scenario).arg(&broken).arg("-o").arg(&out);
    batch.arg("--planner").arg(room.path().join("tiny.toml")).assert().code(4);
    let table = std::fs::read_to_string(out.join("comparison.csv")).unwrap();
    assert!(table.contains("did you mean `facing_deg`?"), "{table}");
    assert!(!table.contains(&room.path().display().to_string()), "{table}");
    assert!(out.join("bench/report.html").is_file() && !out.join("broken").exists());

    // The same bytes as a plan of its own, but for nothing.
    plan(&room, &scenario, "alone").assert().success();
    assert!(files(&out.join("bench")) == files(&room.path().join("alone")));
}

#[test]
fn assessing_nothing_and_unreadable_paths_are_refused() {
    let (room, scenario) = workplace();
    let assess = |path: Option<&Path>| {
        let mut command = ergopath();
        command.arg("assess").arg(&scenario).arg("-o").arg(room.path().join("out"));
        command.args(path.map(|p| [Path::new("--path"), p]).into_iter().flatten());
        command
    };
    assess(None).assert().code(2).stderr(predicate::str::contains("names no path"));
    for (text, word) in [
        ("time_s,x_m\n0,1\n1,2\n", "neither"),
        ("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,1,1,1,0,1,0,0\n0,1,1,1,0,1,0,0\n", "must rise"),
        ("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,1,1,nan,0,1,0,0\n1,1,1,1,0,1,0,0\n", "`nan`"),
        ("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,1,1,1,0,5,0,0\n1,1,1,1,0,1,0,0\n", "quaternion"),
    ] {
        let own = room.path().join("own.csv");
        std::fs::write(&own, text).unwrap();
        assess(Some(&own)).assert().code(2).stderr(predicate::str::contains(word));
    }
    assert!(!room.path().join("out").exists());
}

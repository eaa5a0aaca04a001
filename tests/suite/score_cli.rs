//! `ergopath score` from outside: worksheets, motions, sampled postures, and what it refuses.

use crate::common::ergopath;
use crate::skips::shared;
use assert_cmd::Command;
use std::fmt::Write as _;
use std::path::Path;

fn score() -> Command {
    let mut command = ergopath();
    command.arg("score");
    command
}

/// Header and rows of a CSV file.
fn read(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|r| r.unwrap().iter().map(str::to_owned).collect()).collect();
    (header, rows)
}

/// Standard error without line breaks and margins, for comparing messages that are wrapped.
fn complaint(command: &mut Command) -> String {
    let run = command.assert().code(2);
    assert!(run.get_output().stdout.is_empty());
    let shown = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    let flat: Vec<&str> = shown.split(['\n', '│', ' ']).filter(|w| !w.is_empty()).collect();
    flat.join(" ")
}

#[test]
fn a_table_of_known_postures_is_scored_as_expected() {
    let Some(postures) = shared("ergonomics/postures.csv") else { return };
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("scored.csv");
    let mut command = score();
    command.arg("--worksheet").arg(&postures).arg("-o").arg(&out).args(["--profile", "reference"]);
    command.assert().success();
    let (expected_header, expected) = read(&postures);
    let (header, rows) = read(&out);
    assert_eq!((rows.len(), expected.len()), (266, 266));
    let mut compared = 0;
    for (own, theirs) in rows.iter().zip(&expected) {
        let kind = &theirs[expected_header.iter().position(|c| c == "kind").unwrap()];
        for (column, cell) in header.iter().zip(own) {
            let at = expected_header.iter().position(|c| c == column).unwrap();
            if kind != "convention" || !column.contains('_') {
                assert_eq!(cell, &theirs[at], "row {} {column}", own[0]);
                compared += 1;
            }
        }
    }
    assert!(compared > 250 * 50, "{compared}");
    // Without -o the same table is printed.
    let mut command = score();
    command.arg("--worksheet").arg(&postures).args(["--profile", "reference"]);
    let printed = command.assert().success().get_output().stdout.clone();
    assert_eq!(printed, std::fs::read(&out).unwrap());
}

#[test]
fn a_faulty_table_ends_with_one_message_and_no_file() {
    let room = tempfile::tempdir().unwrap();
    let columns = ergopath::ergonomics::Worksheet::COLUMNS;
    let good = format!("{}\n{}\n", columns.join(","), ["0"; 26].join(","));
    let table = room.path().join("t.csv");
    let out = room.path().join("out.csv");
    let cases = [
        (good.replacen("\n0,", "\nNaN,", 1), "line 2, column `upper_arm_flex`: `NaN` is not"),
        (good.replace("knee_flex,", ""), "input column `knee_flex` is missing"),
        (good.replace("knee_flex,", "knee_flx,"), "input column `knee_flex` is missing"),
        (good[..good.len() - 9].to_owned(), "cells, but the header has 26"),
        (good.replace(",0\n", ",7\n"), "`7` is no coupling class"),
    ];
    for (text, expected) in cases {
        std::fs::write(&table, text).unwrap();
        let shown = complaint(score().arg("--worksheet").arg(&table).arg("-o").arg(&out));
        assert!(shown.contains(expected), "{expected}: {shown}");
        assert!(!out.exists());
    }
    let shown = complaint(score().args(["--worksheet", "none.csv"]));
    assert!(shown.contains("no such file"), "{shown}");
    let shown = complaint(score().args(["--worksheet", "t.csv", "--profile", "referense"]));
    assert!(shown.contains("did you mean `reference`?"), "{shown}");
}

/// Columns of a right arm's motion: sine of the shoulder, bent elbow, thumb forward.
pub(crate) fn motion(rows: usize, rate_hz: f64, per_min: f64) -> String {
    let body = ergopath::human::Body::load("female_p50", Path::new(".")).unwrap();
    let arm = body.arm(ergopath::human::Side::Right).unwrap();
    let names: Vec<String> = arm.joints().iter().map(|j| format!("{}_rad", j.name)).collect();
    let mut text = format!("time_s,{}\n", names.join(","));
    for i in 0..rows {
        let t = i as f64 / rate_hz;
        let wave = 0.6 + 0.4 * (std::f64::consts::TAU * per_min * t / 60.0).sin();
        let value = |name: &String| match name.as_str() {
            "jRightShoulder_Z_rad" => wave,
            "jRightElbow_Z_rad" => 1.4,
            "jRightElbow_Y_rad" => std::f64::consts::FRAC_PI_2,
            _ => 0.0,
        };
        let cells: Vec<String> = names.iter().map(|n| value(n).to_string()).collect();
        writeln!(text, "{t},{}", cells.join(",")).unwrap();
    }
    text
}

fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn joint_angles_become_frames_summary_and_worksheets() {
    let room = tempfile::tempdir().unwrap();
    let csv = room.path().join("arm.csv");
    std::fs::write(&csv, motion(2401, 20.0, 6.0)).unwrap();
    let out = room.path().join("out");
    let run = |extra: &[&str]| {
        let mut command = score();
        command.arg(&csv).args(["--body", "female_p50", "-o"]).arg(&out).args(extra);
        command.assert().success().get_output().stdout.clone()
    };
    let shown = String::from_utf8(run(&["--sheet", "0,2.5,worst", "--load-kg", "6"])).unwrap();
    for word in ["RIGHT SIDE", "upper arm", "what drives RULA", "assumed", "not scored"] {
        assert!(shown.contains(word), "{word}: {shown}");
    }
    assert!(!shown.contains("LEFT SIDE") && !shown.contains("with muscle use 1"), "{shown}");
    let s = summary(&out);
    assert_eq!(s["schema"], "ergopath/score/1");
    let side = &s["sides"][0];
    // Six movements a minute for two minutes: muscle use is found in the motion.
    assert_eq!(side["muscle"]["repeated"]["is"], true);
    assert_eq!(side["muscle"]["repeated"]["origin"], "measured");
    let upper = &side["parts"][0];
    assert!((upper["movements_per_min"].as_f64().unwrap() - 6.0).abs() < 0.1, "{upper}");
    let peak = upper["angles"][0]["peak"].as_f64().unwrap();
    assert!((peak - 1f64.to_degrees()).abs() < 0.01, "{peak}");
    // The frames carry the same worksheets that the table command scores.
    let (header, rows) = read(&out.join("frames.csv"));
    assert_eq!(rows.len(), 2401);
    let again = room.path().join("again.csv");
    let mut command = score();
    command.arg("--worksheet").arg(out.join("frames.csv")).arg("-o").arg(&again);
    command.assert().success();
    assert_eq!(read(&again), (header.clone(), rows.clone()));
    let grand = header.iter().position(|c| c == "rula_grand").unwrap();
    let mean =
        rows.iter().map(|r| r[grand].parse::<f64>().unwrap()).sum::<f64>() / rows.len() as f64;
    let said = side["over_time"]["rula"]["mean"].as_f64().unwrap();
    assert!((mean - said).abs() < 1e-9, "{mean} {said}");
    // A worksheet's lines end in the scores of its frame.
    let sheet = std::fs::read_to_string(out.join("worksheets/right-2.500s.csv")).unwrap();
    let frame = rows.iter().find(|r| r[2] == "2.5").unwrap();
    assert!(sheet.contains(&format!("output,rula_grand,,,{}", frame[grand])), "{sheet}");
    assert!(sheet.contains("6 kg, static or repeated"), "{sheet}");
    let html = std::fs::read_to_string(out.join("worksheets/right-0.000s.html")).unwrap();
    assert!(html.contains("Where every input comes from") && !html.contains("http"), "external");
    // The same call gives the same bytes; a shorter look is possible without -o.
    let before = std::fs::read(out.join("summary.json")).unwrap();
    run(&["--load-kg", "6"]);
    assert_eq!(before, std::fs::read(out.join("summary.json")).unwrap());
}

#[test]
fn a_short_motion_shows_both_totals_unless_the_task_settles_them() {
    let room = tempfile::tempdir().unwrap();
    let csv = room.path().join("arm.csv");
    std::fs::write(&csv, motion(81, 20.0, 6.0)).unwrap();
    let json = |extra: &[&str]| -> serde_json::Value {
        let mut command = score();
        command.arg(&csv).args(["--body", "female_p50", "--json"]).args(extra);
        serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
    };
    let open = json(&[]);
    let side = &open["sides"][0];
    assert!(side["if_muscle_use"][0].as_f64() > side["over_time"]["rula"]["mean"].as_f64());
    assert_eq!(side["muscle"]["held"]["origin"], "assumed");
    let settled = json(&["--hold-s", "5", "--cycles-per-min", "2"]);
    assert!(settled["sides"][0]["if_muscle_use"].is_null());
    assert_eq!(settled["sides"][0]["muscle"]["held"]["origin"], "from-the-task");
}

#[test]
fn rollouts_of_a_plan_give_the_figures_of_the_plan() {
    // One arm on a pelvis that rests, and a whole person who steps and rises on the toes.
    for name in ["bench_pick_and_place", "along_the_bench"] {
        rollouts_give_the_figures(name);
    }
}

fn rollouts_give_the_figures(name: &str) {
    let room = tempfile::tempdir().unwrap();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
    let planner = "schema = \"ergopath/planner/1\"\nname = \"tiny\"\nvias = 1\nnamed_offset_m = 0.1\n\
                   sampled_offset_m = 0.1\npopulation = 4\ngenerations = 2\nruns = 1\n\
                   baseline_generations = 1\nsteps = 30\nrollouts_first = 2\nrollouts_most = 3\n\
                   shortlist = 2\nreported = 2\n\
                   rollouts_final = 6\n[objective]\nexpected_rula = 1.0\nexpected_reba = 0.0\n\
                   cvar90_rula = 0.0\nexposure_rula_5 = 0.0\n";
    std::fs::write(room.path().join("tiny.toml"), planner).unwrap();
    let plan = room.path().join("plan");
    let mut command = ergopath();
    command.arg("plan").arg(&scenario).arg("-o").arg(&plan).arg("--rollouts").arg("--planner");
    command.arg(room.path().join("tiny.toml")).assert().success();
    let result: serde_json::Value =
        serde_json::from_slice(&std::fs::read(plan.join("result.json")).unwrap()).unwrap();
    let best = result["candidates"].as_array().unwrap().iter().find(|c| c["rank"] == 1).unwrap();
    let expected = &best["bodies"][0];
    let out = room.path().join("out");
    let rollouts = plan.join("rollouts/1.csv");
    let mut command = score();
    command.arg(&rollouts).arg("--scenario").arg(&scenario).arg("-o").arg(&out);
    command.args(["--sheet", "worst"]).assert().success();
    let side = &summary(&out)["sides"][0];
    for score in ["rula", "reba"] {
        for figure in ["expected", "p05", "p95", "cvar90", "standard_error"] {
            let own = side["over_rollouts"][score][figure].as_f64().unwrap();
            let theirs = expected[score][figure].as_f64().unwrap();
            assert!((own - theirs).abs() < 1e-9, "{name}: {score} {figure}: {own} {theirs}");
        }
    }
    assert!(side["over_time"].is_null());
    // A path against itself.
    let mut command = score();
    command.arg(&rollouts).arg(&rollouts).args(["--paired", "--scenario"]).arg(&scenario);
    let shown = String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap();
    assert!(shown.contains("no clear difference"), "{shown}");
}

#[test]
fn a_recorded_person_is_scored_on_both_sides() {
    let Some(folder) = shared("recordings/kth_handover") else { return };
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    let mut command = score();
    command.arg(&folder).args(["--person", "giver", "--body", "male_p50", "-o"]).arg(&out);
    command.assert().success();
    let s = summary(&out);
    assert_eq!(s["sides"].as_array().unwrap().len(), 2);
    assert_eq!(s["kind"], "recording");
    let neck = s["sides"][0]["inputs"].as_array().unwrap().iter().find(|i| i["input"] == "neck");
    assert_eq!(neck.unwrap()["origin"], "measured");
    let rows = read(&out.join("frames.csv")).1;
    assert_eq!(rows.len() as u64, 2 * s["frames"].as_u64().unwrap());
}

#[test]
fn faulty_motions_end_with_one_message_and_no_folder() {
    let room = tempfile::tempdir().unwrap();
    let good = motion(81, 20.0, 6.0);
    let csv = room.path().join("arm.csv");
    let out = room.path().join("out");
    let row = good.lines().nth(40).unwrap();
    let cases = [
        ("nan", good.replacen(row, &row.replacen("1.4", "NaN", 1), 1), "not a finite number"),
        ("degrees", good.replacen(row, &row.replacen("1.4", "80", 1), 1), "no joint angle in rad"),
        ("joint", good.replacen("jL5S1_Z_rad", "jL5S1_Q_rad", 1), "jL5S1_Q_rad"),
        ("arm", good.replacen("jRightWrist_X_rad", "jLeftWrist_X_rad", 1), "no whole arm"),
        ("time", good.replacen(row, good.lines().nth(10).unwrap(), 1), "time goes from"),
        ("cut", good[..good.len() / 2 + 7].to_owned(), "is not a table"),
        ("empty", String::new(), "`time_s`"),
    ];
    for (name, text, expected) in cases {
        std::fs::write(&csv, text).unwrap();
        let shown = complaint(score().arg(&csv).args(["--body", "female_p50", "-o"]).arg(&out));
        assert!(shown.contains(expected) || name == "empty", "{name}: {shown}");
        assert!(!out.exists(), "{name}");
    }
    std::fs::write(&csv, &good).unwrap();
    for (extra, expected) in [
        (&["--body", "female_50"][..], "female_p50"),
        (&[][..], "--body"),
        (&["--body", "female_p50", "--side", "left"], "nobody measured or predicted the left arm"),
        (&["--body", "female_p50", "--coupling", "god"], "did you mean `good`?"),
        (&["--body", "female_p50", "--load-kg", "-2"], "0 or more"),
        (&["--body", "female_p50", "--neck", "measured"], "does not hold the neck"),
        (&["--body", "female_p50", "--sheet", "99", "-o", "x"], "outside the motion"),
        (&["--body", "female_p50", "--trunk-supported"], "only a seat has a backrest"),
        (&["--body", "female_p50", "--person", "ann"], "cannot be picked"),
    ] {
        let shown = complaint(score().current_dir(room.path()).arg("arm.csv").args(extra));
        assert!(shown.contains(expected), "{expected}: {shown}");
    }
    let shown = complaint(score().args(["none.mvnx", "--body", "female_p50"]));
    assert!(shown.contains("no such file"), "{shown}");
    assert_eq!(room.path().read_dir().unwrap().count(), 1);
}

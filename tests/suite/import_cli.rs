//! `ergopath import`, and maps wherever a recording may be given.

use crate::common::{assert_refused, ergopath};
use crate::skips::shared;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const MAP: &str = r#"schema = "ergopath/map/1"

[segment.Pelvis]
joint = ["RASI", "LASI"]
offset_mm = [-50, -60, 0]
right = ["LASI", "RASI"]
ahead = ["SACR", ["RASI", "LASI"]]

[segment.T8]
joint = "T10"
up = ["T10", "C7"]
right = "as Pelvis"

[segment.RightUpperArm]
joint = "RSHO"
end = "joint of RightForeArm"
right = "as RightForeArm"

[segment.RightForeArm]
joint = "RELB"
end = "RWRI"
right = { hinge = ["RSHO", "RELB", "RWRI"] }

[segment.RightHand]
joint = "RWRI"
up = "as RightForeArm"
right = "as RightForeArm"
"#;

/// A Qualisys export of a person who stands and raises the right forearm three times, 6 s at 50 Hz; in
/// `gap` the wrist is not seen.
fn places(folder: &Path, gap: std::ops::Range<usize>) -> (PathBuf, PathBuf) {
    let mut text = String::from(
        "NO_OF_FRAMES\t300\nFREQUENCY\t50\n\
         MARKER_NAMES\tRASI\tLASI\tSACR\tT10\tC7\tRSHO\tRELB\tRWRI\n",
    );
    for i in 0..300 {
        let phase = std::f64::consts::TAU * f64::from(i) / 100.0;
        let (lift, bend) = (0.3 - 0.3 * phase.cos(), 1.2 - 0.8 * phase.cos());
        let elbow = [300.0 * lift.sin(), -200.0, 1400.0 - 300.0 * lift.cos()];
        let wrist = [
            elbow[0] + 260.0 * (lift + bend).sin(),
            -200.0,
            elbow[2] - 260.0 * (lift + bend).cos(),
        ];
        let still =
            "100\t-120\t1000\t100\t120\t1000\t-100\t0\t1000\t0\t0\t1300\t0\t0\t1500\t0\t-200\t1400";
        let [x, y, z] = elbow;
        let _ = write!(text, "{i}\t{}\t{still}\t{x}\t{y}\t{z}", f64::from(i) / 50.0);
        let [x, y, z] = wrist;
        let _ = if gap.contains(&(i as usize)) {
            writeln!(text, "\t\t\t")
        } else {
            writeln!(text, "\t{x}\t{y}\t{z}")
        };
    }
    let (file, map) = (folder.join("lift.tsv"), folder.join("map.toml"));
    std::fs::write(&file, text).unwrap();
    std::fs::write(&map, MAP).unwrap();
    (file, map)
}

fn import(files: &[&Path], room: &Path, more: &[&str]) -> Value {
    let done = ergopath()
        .arg("import")
        .args(files)
        .args(["--json", "-o"])
        .arg(room.join("out"))
        .args(more)
        .assert()
        .success();
    serde_json::from_slice(&done.get_output().stdout).unwrap()
}

/// Largest hand residual of all runs (95th percentile, mm) after the constant offset.
fn hand_mm(done: &Value) -> f64 {
    let files = done["files"].as_array().unwrap().iter();
    let runs = files.flat_map(|f| f["runs"].as_array().unwrap());
    runs.map(|r| r["fit"]["hand_residual_mm"]["p95"].as_f64().unwrap()).fold(0.0, f64::max)
}

#[test]
fn markers_are_learned_from_judged_scored_and_explained_with_a_map() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 40..48);
    let map = map.to_str().unwrap();
    let file = file.to_str().unwrap();
    let told = contains("1 gaps of up to 0.16 s filled").and(contains("z is taken as up"));
    ergopath().args(["check", file, "--map", map]).assert().success().stdout(told);
    ergopath().args(["check", map]).assert().success().stdout(contains("5 segments: "));
    let score = ["score", file, "--map", map, "--body", "male_p50", "--json"];
    ergopath().args(score).assert().success().stdout(contains("rula"));
    let evaluate = ["evaluate", file, "--map", map, "--body", "male_p50", "--methods", "plain-ik"];
    ergopath().args(evaluate).assert().success().stdout(contains("plain-ik"));
    let model = room.path().join("m.json");
    ergopath()
        .args(["train", file, "--map", map, "--body", "male_p50", "--method", "plain-ik", "-o"])
        .arg(&model)
        .assert()
        .success()
        .stdout(contains("table of points"));
    let text = std::fs::read_to_string(&model).unwrap();
    assert!(text.contains("map.toml"), "the model says by which map");
    // Without a map, each says what is missing.
    assert_refused(ergopath().args(["check", file]), "say with --map");
    assert_refused(
        ergopath().args(["train", file, "--body", "male_p50", "-o"]).arg(&model),
        "say with --map",
    );
}

#[test]
fn a_recording_without_legs_is_made_whole_where_that_is_asked_for() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 0..0);
    let model = room.path().join("m.json");
    let train = |more: &[&str]| {
        let mut command = ergopath();
        command.arg("train").arg(&file).arg("--map").arg(&map).arg("-o").arg(&model);
        command.args(["--body", "male_p50", "--method", "full-w"]).args(more);
        command
    };
    let read = || -> Value { serde_json::from_slice(&std::fs::read(&model).unwrap()).unwrap() };
    train(&[]).assert().success();
    let resting = read();
    let told =
        contains("holds no legs").and(contains("`people` (5 recorded people, not your workers)"));
    train(&["--pelvis", "moves"]).assert().success().stderr(told);
    let whole = read();
    let of = |model: &Value, key: &str| model[key].as_array().unwrap().len();
    assert_eq!((of(&resting, "joints"), of(&whole, "joints")), (24, 30));
    assert!(resting["provenance"]["filled_from"].is_null());
    assert_eq!(whole["provenance"]["filled_from"], serde_json::json!(["people", 5]));
    assert!(whole["provenance"]["notes"].to_string().contains("holds no legs"));
    ergopath().arg("check").arg(&model).assert().success().stdout(contains("holds no legs"));
    // Where legs must be recorded, nothing is filled in.
    let evaluate = || {
        let mut command = ergopath();
        command.arg("evaluate").arg(&file).arg("--map").arg(&map);
        command.args(["--body", "male_p50", "--pelvis", "moves"]);
        command
    };
    assert_refused(&mut evaluate(), "does not hold both legs");
    // A simulated operator is not made whole of people.
    let simulated = crate::common::short_demonstration(room.path());
    assert_refused(
        ergopath()
            .arg("train")
            .arg(&simulated)
            .args(["--body", "female_p50", "-o"])
            .arg(&model)
            .args(["--pelvis", "moves"]),
        "is of a simulated operator",
    );
}

#[test]
fn a_people_file_names_a_map_for_each_person() {
    let room = tempfile::tempdir().unwrap();
    places(room.path(), 0..0);
    let people = room.path().join("people.toml");
    let text =
        "schema = \"ergopath/people/1\"\n[[person]]\nname = \"p1\"\nrecordings = [\"*.tsv\"]\n";
    std::fs::write(&people, format!("{text}map = \"map.toml\"\n")).unwrap();
    // The map is read, and then legs are missed.
    assert_refused(ergopath().arg("validate").arg(&people), "does not hold both legs");
    std::fs::write(&people, format!("{text}map = \"mop.toml\"\n")).unwrap();
    assert_refused(ergopath().arg("validate").arg(&people), "map:");
    std::fs::write(&people, text).unwrap();
    assert_refused(ergopath().arg("validate").arg(&people), "say with --map");
}

#[test]
fn an_import_is_read_again_and_long_gaps_are_borders() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 100..130);
    let done = import(&[&file], room.path(), &["--map", map.to_str().unwrap()]);
    let runs = done["files"][0]["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    assert_eq!((&runs[1]["first_frame"], &runs[1]["frames_left_out"]), (&130.into(), &30.into()));
    assert!(done["warnings"].to_string().contains("2 runs between long gaps"), "{done}");
    assert!(hand_mm(&done) < 10.0, "{}", hand_mm(&done));
    let out = room.path().join("out");
    let text = std::fs::read_to_string(out.join("lift.csv")).unwrap();
    assert!(text.starts_with("# fitted recording\n"), "{}", &text[..60]);
    assert_eq!(text.lines().filter(|l| l.starts_with("2,")).count(), 170);
    let body = out.join("body.urdf");
    let body = body.to_str().unwrap();
    ergopath().arg("check").arg(out.join("lift.csv")).assert().success();
    let score = ergopath().arg("score").arg(out.join("lift.csv")).args(["--body", body]).assert();
    score.success();
    ergopath()
        .arg("train")
        .arg(out.join("lift.csv"))
        .args(["--body", body, "--method", "plain-ik", "-o"])
        .arg(room.path().join("m.json"))
        .assert()
        .success()
        .stdout(contains("2 trials"));
    // The same where the markers are judged as they are: nothing goes across the gap.
    let judged = ergopath()
        .arg("evaluate")
        .arg(&file)
        .arg("--map")
        .arg(&map)
        .args(["--body", body, "--methods", "plain-ik", "--json"])
        .assert()
        .success()
        .stderr(contains("frames 0 to 99, 130 to 299"));
    let judged: Value = serde_json::from_slice(&judged.get_output().stdout).unwrap();
    assert_eq!(judged["data"][0]["trajectories"], 2);
    let trials = judged["methods"][0]["trials"].as_array().unwrap();
    // 50 Hz, of which every second frame is kept.
    let rows: Vec<_> = trials.iter().map(|t| t["rows"].as_u64().unwrap()).collect();
    assert_eq!(rows, [50, 85]);
    let quality = std::fs::read_to_string(out.join("quality.csv")).unwrap();
    assert_eq!(quality.lines().count(), 1 + 2 * 4, "{quality}");
}

#[test]
fn the_same_angles_are_learned_from_a_file_and_from_its_import() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 0..0);
    let map = map.to_str().unwrap();
    import(&[&file], room.path(), &["--map", map, "--body", "male_p50"]);
    let export = |input: &Path, more: &[&str], name: &str| {
        let data = room.path().join(name);
        ergopath()
            .arg("train")
            .arg(input)
            .args(["--body", "male_p50", "--method", "plain-ik", "--export"])
            .arg(&data)
            .args(more)
            .arg("-o")
            .arg(room.path().join(format!("{name}.json")))
            .assert()
            .success();
        let text = std::fs::read_to_string(&data).unwrap();
        let row = |line: &str| line.split(',').map(|v| v.parse::<f64>().unwrap()).collect();
        text.lines().skip(1).map(row).collect::<Vec<Vec<f64>>>()
    };
    let own = export(&file, &["--map", map], "own.csv");
    let again = export(&room.path().join("out/lift.csv"), &[], "again.csv");
    assert_eq!(own.len(), again.len());
    for (a, b) in own.iter().zip(&again) {
        // Angles are rounded to 1e-5 rad, and rates are their differences over two frames.
        assert!((0..24).all(|c| (a[c] - b[c]).abs() < 1.1e-5));
        assert!((30..54).all(|c| (a[c] - b[c]).abs() < 6e-4));
    }
}

#[test]
fn what_ergopath_did_not_write_stays_and_faults_write_nothing() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 0..0);
    let out = room.path().join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("lift.csv"), "mine").unwrap();
    let call = |file: &Path| {
        let mut command = ergopath();
        command.arg("import").arg(file).arg("--map").arg(&map).arg("-o").arg(&out);
        command
    };
    call(&file).assert().code(2);
    assert_eq!(std::fs::read_to_string(out.join("lift.csv")).unwrap(), "mine");
    std::fs::remove_file(out.join("lift.csv")).unwrap();
    call(&file).assert().success();
    call(&file).assert().success();
    assert_refused(
        ergopath().arg("import").args([&file, &file]).arg("--map").arg(&map).arg("-o").arg(&out),
        "is given twice",
    );
    let other = room.path().join("other.txt");
    std::fs::write(&other, "1 2 3\n").unwrap();
    assert_refused(&mut call(&other), "without names");
}

#[test]
fn real_markers_of_a_box_lift_are_imported() {
    let Some(file) = shared("recordings/pyomeca_boxlift/box_lift.c3d") else { return };
    let room = tempfile::tempdir().unwrap();
    let map = room.path().join("box_lift.toml");
    std::fs::write(&map, include_str!("maps/box_lift.toml")).unwrap();
    let done = import(&[&file], room.path(), &["--map", map.to_str().unwrap()]);
    assert!(hand_mm(&done) < 10.0, "{}", hand_mm(&done));
    assert_eq!(done["files"][0]["runs"].as_array().unwrap().len(), 1);
    let arm =
        done["files"][0]["sizes"].as_array().unwrap().iter().find(|p| p["part"] == "arm").unwrap();
    assert!((arm["length_m"].as_f64().unwrap() - 0.56).abs() < 0.02, "{arm}");
    assert_refused(
        ergopath().arg("import").arg(&file).arg("-o").arg(room.path().join("out")),
        "say with --map which markers",
    );
}

#[test]
fn arms_alone_are_explained_and_not_fitted() {
    let Some(folder) = shared("recordings/lego_assembly") else { return };
    let room = tempfile::tempdir().unwrap();
    let map = room.path().join("lego.toml");
    std::fs::write(&map, include_str!("maps/lego.toml")).unwrap();
    let check = |name: &str| {
        let output = ergopath()
            .arg("check")
            .arg(folder.join(name))
            .arg("--map")
            .arg(&map)
            .assert()
            .success();
        String::from_utf8(output.get_output().stdout.clone()).unwrap()
    };
    assert!(check("Task3_Human2_trial2.txt").contains("gaps of up to"), "NaN is told");
    assert!(check("Task5_Human2_trial2.txt").contains("jumps"), "tracking errors are told");
    for entry in folder.read_dir().unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|x| x == "txt") {
            let mut command = ergopath();
            command
                .arg("import")
                .arg(&file)
                .arg("--map")
                .arg(&map)
                .arg("-o")
                .arg(room.path().join("o"));
            assert_refused(&mut command, "has no segment `Pelvis`");
        }
    }
}

#[test]
fn real_recordings_of_every_kind_are_imported() {
    let kick = "recordings/xsens_mvnx/v3_kick_240hz.mvnx";
    for (file, more) in [
        (kick, vec![]),
        ("recordings/xsens_mvnx/v4_upper_body_60hz.mvnx", vec!["--pelvis", "rests"]),
        ("recordings/xsens_mvnx/v4_upper_body_60hz.bvh", vec!["--pelvis", "rests"]),
        ("recordings/hdm05/HDM_bd_depositFloorR_001_120.amc", vec![]),
        ("recordings/kth_handover", vec!["--person", "giver"]),
    ] {
        let Some(path) = shared(file) else { continue };
        let room = tempfile::tempdir().unwrap();
        let done = import(&[&path], room.path(), &more);
        assert!(hand_mm(&done) < 30.0, "{file}: {}", hand_mm(&done));
        let out = room.path().join("out");
        let motion = out.join(done["files"][0]["motion"].as_str().unwrap());
        // The files of a person are read again together.
        ergopath()
            .arg("score")
            .arg(motion)
            .arg("--body")
            .arg(out.join("body.urdf"))
            .assert()
            .success();
    }
}

#[test]
fn the_idle_hand_is_a_question() {
    let Some(file) = shared("recordings/xsens_mvnx/v4_upper_body_60hz.mvnx") else { return };
    let room = tempfile::tempdir().unwrap();
    let done = import(&[&file], room.path(), &["--pelvis", "rests"]);
    assert!(done["warnings"].to_string().contains("did you mean --side left?"), "{done}");
    let done = import(&[&file], room.path(), &["--pelvis", "rests", "--side", "left"]);
    assert!(!done["warnings"].to_string().contains("did you mean"), "{done}");
}

/// Coordinates of a person who stoops, bends the knees and lifts both forearms three times, 6 s at 50 Hz; without
/// arms as gait2392 has them.
fn coordinates(folder: &Path, has_arms: bool) -> PathBuf {
    let mut columns: Vec<(&str, f64, f64)> = vec![
        ("pelvis_tilt", -10.0, 10.0),
        ("pelvis_list", 0.0, 0.0),
        ("pelvis_rotation", 0.0, 0.0),
        ("pelvis_tx", 0.1, 0.02),
        ("pelvis_ty", 0.93, -0.04),
        ("pelvis_tz", 0.0, 0.0),
        ("lumbar_extension", -15.0, -10.0),
        ("lumbar_bending", 1.0, 2.0),
        ("lumbar_rotation", 0.0, 3.0),
    ];
    for (name, middle, by) in [
        ("hip_flexion_r", 25.0, 15.0),
        ("hip_flexion_l", 25.0, 15.0),
        ("knee_angle_r", -25.0, -15.0),
        ("knee_angle_l", -25.0, -15.0),
        ("ankle_angle_r", 5.0, 3.0),
        ("ankle_angle_l", 5.0, 3.0),
    ] {
        columns.push((name, middle, by));
    }
    if has_arms {
        columns.extend([
            ("arm_flex_r", 30.0, 20.0),
            ("arm_add_r", -15.0, 5.0),
            ("arm_rot_r", 5.0, 5.0),
            ("elbow_flex_r", 60.0, 30.0),
            ("pro_sup_r", 60.0, 10.0),
        ]);
    }
    let mut text =
        String::from("Coordinates\nversion=1\nnRows=300\ninDegrees=yes\nendheader\ntime");
    for (name, ..) in &columns {
        let _ = write!(text, "\t{name}");
    }
    for i in 0..300 {
        let phase = std::f64::consts::TAU * f64::from(i) / 100.0;
        let _ = write!(text, "\n{}", f64::from(i) / 50.0);
        for (_, middle, by) in &columns {
            let _ = write!(text, "\t{}", middle + by * phase.sin());
        }
    }
    let file = folder.join("lift.mot");
    std::fs::write(&file, text + "\n").unwrap();
    file
}

#[test]
fn coordinates_of_opensim_go_the_whole_way() {
    let room = tempfile::tempdir().unwrap();
    let file = coordinates(room.path(), true);
    let told = contains("OpenSim")
        .and(contains("wrist_flex_r, wrist_dev_r (RightHand: taken as in line"))
        .and(contains("put on the body `male_p50`"))
        .and(contains("bending is counted negative"));
    ergopath().arg("check").arg(&file).assert().success().stdout(told);
    let done = import(&[&file], room.path(), &["--body", "female_p50"]);
    assert!(hand_mm(&done) < 10.0, "{}", hand_mm(&done));
    let run = &done["files"][0]["runs"][0];
    for segment in run["segments"].as_array().unwrap() {
        let off = segment["turn_deg"]["p95"].as_f64().unwrap();
        assert!(off < 3.0, "{segment}");
    }
    // The whole person, as both legs are there.
    let motion = std::fs::read_to_string(room.path().join("out/lift.csv")).unwrap();
    assert!(motion.contains("pelvis_up_m") && motion.contains(",stepping"), "{}", &motion[..300]);
    ergopath().arg("score").arg(&file).args(["--body", "female_p50"]).assert().success();
    let model = room.path().join("m.json");
    ergopath()
        .arg("train")
        .arg(&file)
        .args(["--body", "female_p50", "--method", "plain-ik", "-o"])
        .arg(&model)
        .assert()
        .success();
    let text = std::fs::read_to_string(&model).unwrap();
    assert!(text.contains("put on the body `female_p50`"), "a model says on which body");
    let people = room.path().join("people.toml");
    let entry = "[[person]]\nname = \"p1\"\nrecordings = [\"*.mot\"]\n";
    std::fs::write(&people, format!("schema = \"ergopath/people/1\"\n{entry}")).unwrap();
    ergopath().arg("check").arg(&people).assert().success().stdout(contains("1 recordings"));
}

#[test]
fn coordinates_without_arms_are_explained_and_not_fitted() {
    let room = tempfile::tempdir().unwrap();
    let file = coordinates(room.path(), false);
    let told = contains("RightUpperLeg").and(contains("left out: RightUpperArm"));
    ergopath().arg("check").arg(&file).assert().success().stdout(told);
    let mut command = ergopath();
    command.arg("import").arg(&file).arg("-o").arg(room.path().join("o"));
    assert_refused(&mut command, "has no segment `RightHand`");
    // A map of another kind, and a name that is nearly one of a map.
    command.args(["--map", "plug_in_gait"]);
    assert_refused(&mut command, "holds no markers");
    let mut command = ergopath();
    command.arg("check").arg(&file).args(["--map", "open_sim"]);
    assert_refused(&mut command, "did you mean `opensim`?");
}

#[test]
fn an_import_is_drawn_and_inspected_again() {
    let room = tempfile::tempdir().unwrap();
    let (file, map) = places(room.path(), 100..130);
    let out = room.path().join("out");
    let first = room.path().join("first.png");
    let mut command = ergopath();
    command.arg("import").arg(&file).arg("--map").arg(&map).arg("-o").arg(&out);
    let mut wrong = ergopath();
    wrong.arg("import").arg(&file).arg("--map").arg(&map).arg("-o").arg(&out);
    assert_refused(wrong.args(["--figure", "a.jpg"]), "PNG");
    assert!(!out.exists(), "nothing is written beside an error");
    let printed = command.arg("--figure").arg(&first).assert().success();
    let printed = String::from_utf8(printed.get_output().stdout.clone()).unwrap();
    let again = room.path().join("again.png");
    let motion = out.join("lift.csv");
    let shown =
        ergopath().arg("inspect").arg(&motion).arg("--figure").arg(&again).assert().success();
    let shown = String::from_utf8(shown.get_output().stdout.clone()).unwrap();
    // The same rows of the same table.
    let rows = |text: &str| -> Vec<String> {
        let of = |l: &&str| l.trim_start().starts_with("Right") && l.contains(" deg");
        text.lines()
            .filter(of)
            .map(|l| l.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect()
    };
    assert!(rows(&shown).len() >= 6, "{shown}");
    assert_eq!(rows(&shown), rows(&printed));
    for picture in [&first, &again] {
        assert!(std::fs::read(picture).unwrap().starts_with(b"\x89PNG"));
    }
    let json = ergopath().arg("inspect").arg(&motion).arg("--json").assert().success();
    let json: Value = serde_json::from_slice(&json.get_output().stdout).unwrap();
    assert_eq!(json["runs"].as_array().unwrap().len(), 2);
    assert_eq!(json["runs"][0]["segments"].as_array().unwrap().len(), 4);
    // What else may be there.
    std::fs::write(out.join("quality.csv"), "a,b\n1,2\n").unwrap();
    assert_refused(ergopath().arg("inspect").arg(&motion), "no row of the quality");
    std::fs::remove_file(out.join("quality.csv")).unwrap();
    ergopath().arg("inspect").arg(&motion).assert().success().stdout(contains("no residuals"));
    std::fs::remove_file(out.join("body.urdf")).unwrap();
    assert_refused(ergopath().arg("inspect").arg(&motion), "say with --body");
    assert_refused(ergopath().args(["inspect", "a.urdf"]), "add --chain BASE:TIP");
    assert_refused(ergopath().arg("inspect").arg(&file), "add --chain BASE:TIP");
}

#[test]
fn shipped_maps_are_explained() {
    for (name, kind) in [
        ("opensim", "columns"),
        ("rigid_bodies", "columns"),
        ("plug_in_gait", "markers"),
        ("qualisys_sports", "markers"),
    ] {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("models/maps/{name}.toml"));
        let told = contains(format!("a map from {kind} to segments"));
        ergopath().arg("check").arg(file).assert().success().stdout(told);
    }
}

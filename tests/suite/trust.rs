//! No number of an input is believed because it can be read: files of ours, scenarios and robots with one value
//! changed are refused or told, and nothing panics.

use crate::common::{ergopath, plan, workplace};
use ergopath::files::{CHECKSUM, Seal, sealed};
use ergopath::kinematics::parse_urdf;
use ergopath::math::stream::{Purpose, stream};
use ergopath::planner::parse_result;
use ergopath::posture::load_model;
use ergopath::scenario::{Warning, read_scenario};
use rand::RngExt;
use serde_json::{Value, json};
use std::path::Path;

fn project(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(path).unwrap()
}

/// Pointers to members of a JSON value: to all that are no containers, and to all lists; of a long list some.
fn places(value: &Value, at: &str, leaves: &mut Vec<String>, lists: &mut Vec<String>) {
    const OF_A_LIST: usize = 5;
    match value {
        Value::Object(members) => {
            for (key, inner) in members {
                let key = key.replace('~', "~0").replace('/', "~1");
                places(inner, &format!("{at}/{key}"), leaves, lists);
            }
        }
        Value::Array(items) => {
            if !items.is_empty() {
                lists.push(at.to_owned());
            }
            let step = items.len().div_ceil(OF_A_LIST).max(1);
            for (i, inner) in items.iter().enumerate().step_by(step) {
                places(inner, &format!("{at}/{i}"), leaves, lists);
            }
        }
        _ => leaves.push(at.to_owned()),
    }
}

/// Some of many, the same each time.
fn some(mut all: Vec<String>, count: usize, seed: u64) -> Vec<String> {
    let mut rng = stream(seed, Purpose::Simulation, 0, 0);
    while all.len() > count {
        let i = rng.random_range(0..all.len());
        all.swap_remove(i);
    }
    all
}

fn with(value: &Value, at: &str, new: Value) -> Value {
    let mut changed = value.clone();
    *changed.pointer_mut(at).unwrap() = new;
    changed
}

/// Changes members one by one: with the checksum every change is refused, without it every number that cannot be.
/// `read` says why a text is refused.
fn changed_one_by_one(text: &str, count: usize, read: &dyn Fn(&str) -> Result<(), String>) {
    read(text).unwrap();
    let whole: Value = serde_json::from_str(text).unwrap();
    let mut open = whole.clone();
    open.as_object_mut().unwrap().remove(CHECKSUM).unwrap();
    read(&open.to_string()).unwrap();
    let (mut leaves, mut lists) = (Vec::new(), Vec::new());
    places(&open, "", &mut leaves, &mut lists);
    for (k, at) in some(leaves, count, 1).iter().enumerate() {
        let old = whole.pointer(at).unwrap();
        for new in [json!(1e308), json!(-1e9), json!(-1), json!(null), json!("x"), json!(7)] {
            // 7 and 7.0 are one number.
            let is_same = new.as_f64().map_or(*old == new, |n| old.as_f64() == Some(n));
            if is_same || (at == "/seed" && new == json!(7)) {
                continue;
            }
            let is_huge = new.as_f64().is_some_and(|v| v.abs() > 1e8);
            // Two of the six each, to be done in seconds.
            if is_huge || k % 3 == 0 {
                let error = read(&with(&whole, at, new.clone()).to_string()).unwrap_err();
                let is_told = error.contains("was changed since")
                    || error.contains("schema")
                    || error.contains("as this version")
                    || error.contains("is not a");
                assert!(is_told, "{at} = {new}: {error}");
                let without = read(&with(&open, at, new.clone()).to_string());
                assert!(without.is_err() || !is_huge || at.ends_with("seed"), "{at} = {new}");
            }
        }
    }
    for at in some(lists, count / 2, 2) {
        let items = whole.pointer(&at).unwrap().as_array().unwrap();
        let shorter = json!(items[..items.len() - 1]);
        let mut longer = items.clone();
        longer.push(items[items.len() - 1].clone());
        for new in [shorter, json!(longer), json!([]), json!([[[]]])] {
            assert!(read(&with(&whole, &at, new.clone()).to_string()).is_err(), "{at}");
            // Some lists may be of any length; none may bring the program down.
            let _ = read(&with(&open, &at, new).to_string());
        }
    }
}

#[test]
fn a_model_with_one_member_changed_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let read = |text: &str| {
        std::fs::write(room.path().join("m.json"), text).unwrap();
        load_model("m.json", room.path()).map(|_| ()).map_err(|e| e.to_string())
    };
    for model in ["demo_operator", "whole_operator", "people"] {
        let (shipped, _) = load_model(model, Path::new(".")).unwrap();
        assert_eq!(shipped.seal, Seal::Whole, "{model}");
    }
    for (model, count) in [("demo_operator", 60), ("whole_operator", 40), ("people", 12)] {
        changed_one_by_one(&project(&format!("models/posture/{model}.json")), count, &read);
    }
}

#[test]
fn what_no_person_is_or_does_is_refused_in_a_model_without_a_checksum() {
    let room = tempfile::tempdir().unwrap();
    let refused = |model: &str, at: &str, new: Value| {
        let mut value: Value =
            serde_json::from_str(&project(&format!("models/posture/{model}.json"))).unwrap();
        value.as_object_mut().unwrap().remove(CHECKSUM);
        std::fs::write(room.path().join("m.json"), with(&value, at, new).to_string()).unwrap();
        load_model("m.json", room.path()).unwrap_err().to_string()
    };
    for (at, new, words) in [
        ("/size/stature_m", json!(-1), "stature -1 m is outside 1.2 to 2.3"),
        ("/size/stature_m", json!(0), "stature 0 m is outside"),
        ("/law/stature_m", json!(1e308), "law.stature_m"),
        ("/joints/3", json!("jL4L3_Q"), "joints[3]: `jL4L3_Q` stands where a body has `jL4L3_Z`"),
        ("/law/weight/0/0", json!(-1.0), "law.weight is not symmetric positive definite"),
        ("/law/weight/0/1", json!(1e308), "law.weight is not symmetric positive definite"),
        ("/law/noise/factor/0/5", json!(1e9), "law.noise: factor: 1e9 is outside"),
        ("/law/noise/shares/white", json!(0.9), "shares sum to 1"),
        ("/law/attraction/features/mean", json!([]), "features.mean has 0 values, not 6"),
        ("/law/attraction/features/mean", json!([0, 0, 0, 0, 0]), "features.mean has 5 values"),
        ("/law/attraction/inputs", json!([]), "has no inputs"),
        ("/law/attraction/postures_rad/0/7", json!(1e308), "postures_rad"),
        ("/law/attraction/features/reference/0", json!(2.0), "no unit quaternion"),
        ("/postures/mean/0/14", json!(9.0), "postures: mean of `jRightC7Shoulder_Y`: 9 is outside"),
        ("/quality/0/coverage", json!([0.5, 1e308]), "quality[0]: coverage"),
        ("/provenance/body/1", json!("x"), "SHA-256 that is none"),
        ("/name", json!(""), "name is empty"),
    ] {
        let error = refused("demo_operator", at, new);
        assert!(error.contains(words), "{at}: {error}");
    }
    for (at, new, words) in [
        ("/modes/low/0/memberships/0", json!(0.5), "told apart by movements that each are of one"),
        ("/modes/all/0/knees_deg", json!(1e9), "modes.all[0]: knees_deg"),
        ("/standing/of_people/0/1", json!(0.5), "standing: the standing place holds"),
        ("/law/attraction/origins", json!([{"person": 0, "movement": 0}]), "origins has 1 values"),
    ] {
        let error = refused("people", at, new);
        assert!(error.contains(words), "{at}: {error}");
    }
}

#[test]
fn a_result_with_one_member_changed_is_refused_and_one_without_checksum_is_told() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let file = room.path().join("out/result.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let path = Path::new("result.json");
    let read = |text: &str| parse_result(path, text).map(|_| ()).map_err(|e| e.to_string());
    changed_one_by_one(&text, 80, &read);
    // Sealed anew it is the same.
    let again: Value = serde_json::from_str(&sealed(&text).unwrap()).unwrap();
    assert_eq!(again, serde_json::from_str::<Value>(&text).unwrap());
    // A figure that somebody made nicer.
    let mut value: Value = serde_json::from_str(&text).unwrap();
    let expected = value.pointer_mut("/candidates/0/bodies/0/rula/expected").unwrap();
    *expected = json!(expected.as_f64().unwrap() - 1.0);
    std::fs::write(&file, value.to_string()).unwrap();
    let report = || {
        let mut command = ergopath();
        command.arg("report").arg(room.path().join("out")).arg("-o").arg(room.path().join("again"));
        command
    };
    let said = report().assert().code(2);
    let said = String::from_utf8_lossy(&said.get_output().stderr).replace(['\n', '│'], " ");
    let said: String = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("was changed since it was written"), "{said}");
    assert!(said.contains("make the run again") && said.contains("remove the member"), "{said}");
    value.as_object_mut().unwrap().remove(CHECKSUM);
    std::fs::write(&file, value.to_string()).unwrap();
    let said = report().assert().code(0);
    let said = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
    assert!(said.contains("warning: result.json carries no checksum"), "{said}");
    let page = std::fs::read_to_string(room.path().join("again/report.html")).unwrap();
    assert!(page.contains("result.json carries no checksum"));
}

#[test]
fn a_plan_with_a_model_without_checksum_says_so() {
    let (room, scenario) = workplace();
    let file = room.path().join("operator.json");
    let mut value: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let untouched = read_scenario(&scenario).unwrap();
    let of_checksum = |w: &Warning| matches!(w, Warning::NoChecksum { .. });
    assert!(!untouched.warnings.iter().any(of_checksum));
    value.as_object_mut().unwrap().remove(CHECKSUM);
    std::fs::write(&file, value.to_string()).unwrap();
    let told = read_scenario(&scenario).unwrap().warnings;
    assert!(told.contains(&Warning::NoChecksum { file: "operator.json".to_owned() }));
}

/// Numbers of a text by their places, those in comments left out.
fn numbers(
    text: &str,
    is_comment: fn(&str) -> bool,
    needs_point: bool,
) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let bytes = line.as_bytes();
        let mut i = 0;
        while i < bytes.len() && !is_comment(line) {
            let is_start = bytes[i].is_ascii_digit();
            if !is_start {
                i += 1;
                continue;
            }
            let mut end = i;
            while end < bytes.len() && (bytes[end].is_ascii_digit() || bytes[end] == b'.') {
                end += 1;
            }
            let from = if i > 0 && bytes[i - 1] == b'-' { i - 1 } else { i };
            if !needs_point || line[i..end].contains('.') {
                found.push(start + from..start + end);
            }
            i = end;
        }
        start += line.len();
    }
    found
}

#[test]
fn a_scenario_with_one_number_that_cannot_be_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("s.toml");
    let mut tried = 0;
    for name in ["bench_pick_and_place", "low_bin", "seated_left"] {
        let text = project(&format!("scenarios/{name}.toml"));
        for at in numbers(&text, |line| line.trim_start().starts_with('#'), false) {
            // Behind the value of a line a comment may follow.
            let line = text[..at.start].rsplit('\n').next().unwrap_or_default();
            if line.contains('#') {
                continue;
            }
            for new in ["nan", "1e308", "-1e9", "1e9", "\"x\"", "[1, 2]", "0x10", "1_0"] {
                let changed = format!("{}{new}{}", &text[..at.start], &text[at.end..]);
                std::fs::write(&file, changed).unwrap();
                let is_refused = read_scenario(&file).is_err();
                // In words, any is a word.
                let is_word = line.contains("description") || line.contains("name =");
                assert!(is_refused || is_word, "{name}: {line}{new}");
                tried += 1;
            }
        }
    }
    assert!(tried > 500, "{tried}");
}

#[test]
fn what_contradicts_itself_or_is_far_off_in_a_scenario_is_refused() {
    let text = project("scenarios/bench_pick_and_place.toml");
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("s.toml");
    let said = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        read_scenario(&file).unwrap_err().to_string()
    };
    let before = |more: &str| format!("{more}\n[task]");
    let limit = |more: &str| format!("[[robot.limit]]\njoint = \"panda_joint1\"\n{more}\n[start]");
    for (from, to, words) in [
        ("[grip]", "[grip]\nposition_m = [5.0, 0, 0]".to_owned(), "no hand is held so far"),
        ("max_m = [0.80", "max_m = [90.0".to_owned(), "far outside any cell"),
        ("[start]", limit("velocity_rad_s = 1e308"), "is outside 0 to 100 rad/s or m/s"),
        ("[start]", limit("acceleration_rad_s2 = 1e9"), "is outside 0 to 10000 rad/s^2"),
        ("[start]", limit("lower_rad = -100\nupper_rad = 100"), "limit -100 is outside"),
        ("[task]", before("[[path]]\nname = \"mine\"\nvia_m = [[0.4, 0.0, 19.0]]"), "a place 17.7"),
        (
            "rpy_deg = [180, 0, 0]",
            "pointing = [0, 0, -1e9]\nx_along = [1, 0, 0]".to_owned(),
            "no direction",
        ),
        ("seed = 1", "seed = 0x10".to_owned(), "`0x10` is a number as programs write it"),
        (
            "duration_s = 4.0",
            "duration_s = 1_0".to_owned(),
            "`1_0` is a number as programs write it",
        ),
    ] {
        let error = said(from, &to);
        assert!(error.contains(words), "{to}: {error}");
    }
}

#[test]
fn a_robot_with_one_number_that_cannot_be_is_refused() {
    let mut tried = 0;
    for name in ["panda", "ur5e", "crx10ial"] {
        let text = project(&format!("models/robot/{name}.urdf"));
        let all = numbers(&text, |_| false, true);
        for at in all.iter().step_by(3) {
            if text[..at.start].ends_with("<?xml version=\"") || in_comment(&text, at.start) {
                continue;
            }
            for new in ["nan", "1e308", "-1e9", "1e9", "x"] {
                let changed = format!("{}{new}{}", &text[..at.start], &text[at.end..]);
                let found = parse_urdf(Path::new("r.urdf"), &changed);
                let line = text[..at.start].rsplit('\n').next().unwrap_or_default();
                assert!(found.is_err(), "{name}: {line}{new}");
                tried += 1;
            }
        }
    }
    assert!(tried > 300, "{tried}");
}

fn in_comment(text: &str, at: usize) -> bool {
    let open = text[..at].rfind("<!--");
    open.is_some_and(|open| !text[open..at].contains("-->"))
}

#[test]
fn a_body_that_nobody_has_is_refused_and_an_edited_one_is_told() {
    let room = tempfile::tempdir().unwrap();
    let (urdf, sheet) = (room.path().join("anna.urdf"), room.path().join("anna.body.toml"));
    let make = || {
        let mut command = ergopath();
        command.args(["body", "--sex", "f", "--stature-m", "1.63", "--mass-kg", "66", "-o"]);
        command.arg(&urdf).assert().success();
    };
    make();
    let load = || ergopath::human::Body::load("anna.urdf", room.path());
    assert!(!load().unwrap().is_other());
    let text = std::fs::read_to_string(&sheet).unwrap();
    let changed = |key: &str, new: &str| {
        let old = text.lines().find(|l| l.starts_with(key)).unwrap();
        std::fs::write(&sheet, text.replacen(old, &format!("{key} = {new}"), 1)).unwrap();
    };
    for (key, new, words) in [
        ("hand_length_m", "0", "hand_length_m 0 is outside 0.1 to 0.3 m"),
        ("seat_to_hip_m", "1e-320", "seat_to_hip_m"),
        ("standing_pelvis_height_m", "1.5", "is outside 0.4 to 0.65 statures"),
        ("stature_m", "1e308", "is outside 1.2 to 2.3 m"),
        ("mass_kg", "160", "its links are 66.0 kg together"),
        ("lower_deg", "25", "is no range about upright"),
        ("upper_deg", "80", "is more than -140 to 60, which no trunk does"),
    ] {
        changed(key, new);
        let error = load().unwrap_err().to_string();
        assert!(error.contains("anna.body.toml") && error.contains(words), "{key}: {error}");
    }
    changed("hand_length_m", "0.19");
    assert!(load().unwrap().is_other());
    let said = ergopath().arg("check").arg(&urdf).assert();
    let said = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
    assert!(said.contains("is not what `ergopath body` makes of its size"), "{said}");
}

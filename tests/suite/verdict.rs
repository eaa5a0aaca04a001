//! What the verdict claims and what it does not: equal timing, split gains, support by the recordings.

use crate::common::{ergopath, plan, workplace};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The straight path of the shared workplace at constant speed, in two rows.
const TWO_ROWS: &str =
    "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0.42,-0.35,0.95,0,1,0,0\n4,0.45,0.25,1.25,0,1,0,0\n";

fn result(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("result.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn candidate<'a>(result: &'a Value, id: &str) -> &'a Value {
    let all = result["candidates"].as_array().unwrap();
    all.iter().find(|c| c["id"] == id).unwrap_or_else(|| panic!("{id} is not listed"))
}

/// Assesses the two rows in a scenario: what the terminal says, and the result.
fn assessed(room: &TempDir, scenario: &Path, output: &str) -> (String, Value) {
    let path = room.path().join("today.csv");
    std::fs::write(&path, TWO_ROWS).unwrap();
    let folder = room.path().join(output);
    let mut command = ergopath();
    command.arg("assess").arg(scenario).arg("--path").arg(&path).arg("-o").arg(&folder);
    let ran = command.arg("--planner").arg(room.path().join("tiny.toml")).assert().success();
    (String::from_utf8(ran.get_output().stdout.clone()).unwrap(), result(&folder))
}

/// The scenario with pieces of its text replaced, under another name.
fn edited(room: &TempDir, scenario: &Path, name: &str, changes: &[(&str, &str)]) -> PathBuf {
    let mut text = std::fs::read_to_string(scenario).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    let path = room.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_straight_route_at_another_timing_gains_nothing() {
    let (room, scenario) = workplace();
    let (shown, result) = assessed(&room, &scenario, "out");
    assert!(shown.contains("Same route as the straight path; timing differs."), "{shown}");
    assert!(!shown.contains("Against the straight path"), "{shown}");
    assert!(result["verdict"]["gain"].is_null() && result["verdict"]["outcome"] == "assessed");
}

#[test]
fn a_path_scores_the_same_whatever_the_scenario_says_of_the_duration() {
    let (room, scenario) = workplace();
    let of = |seconds: &str| {
        let to = format!("duration_s = {seconds}");
        let name = format!("s{seconds}.toml");
        let scenario = edited(&room, &scenario, &name, &[("duration_s = 4.0", &to)]);
        let (_, result) = assessed(&room, &scenario, &format!("out{seconds}"));
        candidate(&result, "today")["bodies"][0]["rula"].clone()
    };
    let [short, long] = ["4", "300"].map(of);
    assert!(short["expected"].as_f64().unwrap() > 1.0);
    assert_eq!(short["by_rollout"], long["by_rollout"]);
    assert_eq!(short["peak_by_rollout"], long["peak_by_rollout"]);
}

/// The straight path of the shared workplace from rest to rest, in so many seconds.
fn straight_in(seconds: f64) -> String {
    let mut text = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n".to_owned();
    for i in 0..=40 {
        let s = f64::from(i) / 40.0;
        let u = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        let (t, x, y, z) = (s * seconds, 0.42 + 0.03 * u, -0.35 + 0.6 * u, 0.95 + 0.3 * u);
        let _ = writeln!(text, "{t},{x:.6},{y:.6},{z:.6},0,1,0,0");
    }
    text
}

#[test]
fn the_same_postures_score_the_same_from_four_seconds_to_ten_minutes() {
    let (room, scenario) = workplace();
    // So rarely that no duration changes the points for muscle use.
    let seldom = [("cycles_per_min = 5", "cycles_per_min = 0.09")];
    let scenario = edited(&room, &scenario, "seldom.toml", &seldom);
    let of = |seconds: f64| {
        let name = format!("in_{seconds}");
        let path = room.path().join(format!("{name}.csv"));
        std::fs::write(&path, straight_in(seconds)).unwrap();
        let folder = room.path().join(&name);
        let mut command = ergopath();
        command.arg("assess").arg(&scenario).arg("--path").arg(&path).arg("-o").arg(&folder);
        command.arg("--planner").arg(room.path().join("tiny.toml")).assert().success();
        let result = result(&folder);
        let body = &candidate(&result, &name)["bodies"][0];
        assert_eq!(body["reach_exceeded"], 0.0);
        ["rula", "reba"].map(|m| body[m]["expected"].as_f64().unwrap())
    };
    let first = of(4.0);
    for seconds in [20.0, 60.0, 300.0, 600.0] {
        let other = of(seconds);
        for (a, b) in first.iter().zip(other) {
            assert!((a - b).abs() < 0.1, "{seconds} s: {other:?} instead of {first:?}");
        }
    }
}

#[test]
fn a_gain_is_split_where_the_timing_is_free_and_the_timing_is_kept_where_it_is_not() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "fixed").assert().success();
    let fixed = result(&room.path().join("fixed"));
    assert!(!fixed.to_string().contains("straight_retimed"));
    let ranked = fixed["candidates"].as_array().unwrap().iter().filter(|c| c["rank"].is_number());
    for c in ranked {
        let progress = c["timing"]["progress"].as_f64().unwrap_or(0.0);
        assert!(progress < 0.12 || c["other_timing"] == true, "{}: {progress}", c["id"]);
    }
    let free = [("[motion]", "[free]\npace = true\n[motion]")];
    let scenario = edited(&room, &scenario, "free.toml", &free);
    let ran = plan(&room, &scenario, "free").assert().success();
    let shown = String::from_utf8(ran.get_output().stdout.clone()).unwrap();
    let free = result(&room.path().join("free"));
    assert_eq!(candidate(&free, "straight_retimed")["evaluated"], "reported");
    let gain = &free["verdict"]["gain"]["rula"];
    if gain.is_object() {
        assert!(gain["route"].is_object() && gain["timing"].is_object(), "{gain}");
        assert!(shown.contains("The route alone: ") && shown.contains("The timing alone: "));
    }
}

#[test]
fn what_the_recordings_do_not_support_is_not_called_the_best() {
    let (room, scenario) = workplace();
    let overhead = [
        ("[0.42, -0.35, 0.95]", "[0.35, -0.15, 1.75]"),
        ("[0.45, 0.25, 1.25]", "[0.35, 0.15, 1.75]"),
        ("max_m = [0.80, 0.60, 1.60]", "max_m = [0.80, 0.60, 1.90]"),
        ("[0.95, 0.0, 0.75]", "[0.95, 0.0, 1.35]"),
    ];
    let scenario = edited(&room, &scenario, "overhead.toml", &overhead);
    let ran = plan(&room, &scenario, "out").assert().success();
    let shown = String::from_utf8(ran.get_output().stdout.clone()).unwrap();
    assert!(shown.starts_with("Not supported by the recordings"), "{shown}");
    assert!(!shown.contains("Best path"), "{shown}");
    let verdict = result(&room.path().join("out"))["verdict"].clone();
    assert!(verdict["outcome"] == "not_supported" && verdict["best"].is_null(), "{verdict}");
}

#[test]
fn the_best_path_buys_its_mean_with_no_worse_peak_or_score_per_metre() {
    let (room, scenario) = workplace();
    let output = room.path().join("quick");
    let mut command = ergopath();
    command.arg("plan").arg(&scenario).arg("-o").arg(&output).args(["--planner", "quick"]);
    command.assert().success();
    let result = result(&output);
    let best = candidate(&result, result["verdict"]["best"].as_str().unwrap());
    let straight = candidate(&result, "straight");
    let of = |c: &Value, key: &str| -> Vec<f64> {
        let all = c["bodies"][0]["rula"][key].as_array().unwrap();
        all.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    for key in ["by_rollout", "per_metre_by_rollout", "peak_by_rollout"] {
        // A plain paired t interval at 95 % of what the best path is worse by.
        let d: Vec<f64> = of(best, key).iter().zip(of(straight, key)).map(|(a, b)| a - b).collect();
        let n = d.len() as f64;
        let mean = d.iter().sum::<f64>() / n;
        let variance = d.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let low = mean - 2.1 * (variance / n).sqrt();
        assert!(low <= 0.0, "{key}: worse by {mean}, at least {low}");
    }
}

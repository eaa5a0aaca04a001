//! Finished runs side by side, as their user calls it.

use crate::common::{assert_refused, ergopath, plan, workplace};
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

#[test]
fn runs_of_the_same_people_are_paired_and_others_are_not() {
    let (room, scenario) = workplace();
    let at = |name: &str| room.path().join(name);
    // The same cell with the goal lower, and with other people.
    let text = std::fs::read_to_string(&scenario).unwrap();
    let lower = at("lower.toml");
    assert!(text.contains("[0.45, 0.25, 1.25]"));
    std::fs::write(&lower, text.replace("[0.45, 0.25, 1.25]", "[0.45, 0.25, 1.15]")).unwrap();
    plan(&room, &scenario, "high").assert().success();
    plan(&room, &lower, "low").assert().success();
    plan(&room, &scenario, "others").args(["--seed", "5"]).assert().success();

    let page = at("compare.html");
    let mut compare = ergopath();
    compare.arg("compare").args([at("high"), at("low"), at("others").join("result.json")]);
    compare.arg("-o").arg(&page).args(["--against", "high", "--json"]);
    let output = compare.assert().success().get_output().stdout.clone();
    let compared: Value = serde_json::from_slice(&output).unwrap();
    assert_eq!(compared["against"], "high");
    let runs = compared["runs"].as_array().unwrap();
    let against = |i: usize| &runs[i]["bodies"][0]["against"];
    assert!(against(0).is_null());
    assert!(against(1)["unpaired_because"].is_null());
    assert_eq!(against(2)["unpaired_because"], "seeds 5 and 1");
    // The paired difference by hand, from the people of both runs.
    let people = |run: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(at(run).join("result.json")).unwrap();
        let result: Value = serde_json::from_str(&text).unwrap();
        let all = result["candidates"].as_array().unwrap();
        let best = all.iter().find(|c| c["id"] == result["verdict"]["best"]).unwrap();
        let by_rollout = best["bodies"][0]["rula"]["by_rollout"].as_array().unwrap();
        by_rollout.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let (high, low) = (people("high"), people("low"));
    let mean = low.iter().zip(&high).map(|(l, h)| l - h).sum::<f64>() / high.len() as f64;
    assert!((against(1)["mean"].as_f64().unwrap() - mean).abs() < 1e-12);

    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("Comparison of 3 runs"));
    // One file that needs nothing else.
    for word in ["<script src", "http:", "https:", "<link"] {
        assert!(!html.contains(word), "{word}");
    }
    let table = std::fs::read_to_string(at("compare.csv")).unwrap();
    for words in [",paired,", ",unpaired: seeds 5 and 1,"] {
        assert!(table.contains(words), "{words}: {table}");
    }
}

#[test]
fn a_folder_of_runs_stands_for_its_runs_and_wrong_calls_are_refused() {
    let (room, scenario) = workplace();
    let both = room.path().join("both");
    for run in ["one", "two"] {
        plan(&room, &scenario, &format!("runs/{run}")).assert().success();
    }
    let compare = |arguments: &[&str]| {
        let mut command = ergopath();
        command.current_dir(room.path()).arg("compare").args(arguments).arg("-o").arg(&both);
        command.assert()
    };
    compare(&["runs"]).success().stdout(contains("paired, 6 repetitions").and(contains("two")));
    assert!(both.join("comparison.html").is_file() && both.join("comparison.csv").is_file());
    compare(&["runs", "--quiet"]).success().stdout("");
    let refused = |arguments: &[&str], words: &str| {
        let mut command = ergopath();
        command.current_dir(room.path()).arg("compare").args(arguments).arg("-o").arg(&both);
        assert_refused(&mut command, words);
    };
    refused(&["runs", "--against", "tow"], "did you mean `two`?");
    refused(&["runs/one", "runs/one"], "is named twice");
    refused(&["nowhere"], "no such file");
    refused(&["."], "is a folder without result.json");
}

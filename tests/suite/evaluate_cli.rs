//! `ergopath evaluate` and `experiment` from outside: the reference data set, and what is refused.

use crate::common;
use crate::skips::shared;
use predicates::prelude::*;
use predicates::str::contains;

fn ergopath(arguments: &[&str]) -> assert_cmd::assert::Assert {
    common::ergopath().args(arguments).assert()
}

fn json(text: &[u8]) -> serde_json::Value {
    serde_json::from_slice(text).unwrap()
}

/// Median of a figure of a method.
fn median(found: &serde_json::Value, method: &str, figure: &str) -> f64 {
    let methods = found["methods"].as_array().unwrap();
    let own = methods.iter().find(|m| m["method"] == method).unwrap();
    own[figure]["median"].as_f64().unwrap()
}

/// Rms of log w - log true weights, both centred.
fn weight_error(found: &serde_json::Value, truth: &serde_json::Value) -> f64 {
    let methods = found["methods"].as_array().unwrap();
    let own = methods.iter().find(|m| m["method"] == "mi-nsgp").unwrap();
    let logs = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|w| w.as_f64().unwrap().ln()).collect()
    };
    let (a, b) = (logs(&own["w"]), logs(&truth["w_true"]));
    let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
    let mean = difference.iter().sum::<f64>() / difference.len() as f64;
    let square = difference.iter().map(|d| (d - mean).powi(2)).sum::<f64>();
    (square / difference.len() as f64).sqrt()
}

#[test]
fn the_reference_data_set_is_predicted_as_well_as_by_the_reference() {
    let Some(folder) = shared("toy5r") else { return };
    let data = folder.join("seed0.csv");
    let chain = format!("{}:base:tip", folder.join("planar5r.urdf").display());
    let run = |threads: &str| {
        let mut command = common::ergopath();
        command.env("RAYON_NUM_THREADS", threads);
        command.args(["evaluate", data.to_str().unwrap(), "--chain", &chain, "--json"]);
        command.args(["--task", "planar", "--task-noise", "0.00118"]);
        json(&command.assert().success().get_output().stdout)
    };
    let found = run("2");
    let reference = json(&std::fs::read(folder.join("reference.json")).unwrap());
    let own = &reference["seeds"]["0"]["methods"]["MI lbfgs ml aligned"];
    let (ll, rmse) = (own["ll_q"].as_f64().unwrap(), own["rmse_q"].as_f64().unwrap());
    assert!(median(&found, "mi-nsgp", "ll_q") >= ll - 0.05);
    assert!(median(&found, "mi-nsgp", "rmse_q") <= 1.02 * rmse);
    for other in ["gp", "w-ik", "nsgp", "sb-m", "promp"] {
        assert!(median(&found, "mi-nsgp", "ll_q") > median(&found, other, "ll_q"), "{other}");
        assert!(median(&found, "mi-nsgp", "rmse_q") < median(&found, other, "rmse_q"), "{other}");
    }
    for exact in ["mi-nsgp", "w-ik", "nsgp", "sb-m", "full-w", "full-w-gp"] {
        assert!(median(&found, exact, "rmse_x") < 1e-9, "{exact}");
    }
    let truth = json(&std::fs::read(folder.join("seed0.json")).unwrap());
    let error = weight_error(&found, &truth);
    assert!(error <= 0.06, "W is off by {error}");
    // The simple methods agree with the reference's own: the same data, another program.
    let peer = &reference["seeds"]["0"]["methods"]["W-IK"];
    let ratio = median(&found, "w-ik", "rmse_q") / peer["rmse_q"].as_f64().unwrap();
    assert!((ratio - 1.0).abs() < 0.01, "W-IK RMSE is {ratio} times the reference's");
    // The same figures with one thread; only times differ.
    let again = run("1");
    for (a, b) in
        found["methods"].as_array().unwrap().iter().zip(again["methods"].as_array().unwrap())
    {
        for figure in ["ll_q", "rmse_q", "w", "w_uncertainty"] {
            assert_eq!(a[figure], b[figure], "{} {figure}", a["method"]);
        }
    }
}

#[test]
fn faults_are_named_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.csv");
    let body = "models/human/female_p50.urdf";
    let chain = format!("{body}:Pelvis:RightGrip");
    ergopath(&["evaluate", missing.to_str().unwrap(), "--chain", &chain])
        .code(2)
        .stderr(contains("none.csv"));
    ergopath(&["evaluate", "x.csv"]).code(2).stderr(contains("--chain"));
    ergopath(&["evaluate", "x.csv", "--chain", "nonsense"])
        .code(2)
        .stderr(contains("FILE:BASE:TIP"));
    ergopath(&["evaluate", "x.csv", "--chain", &chain, "--split", "block:5"])
        .code(2)
        .stderr(contains("blocks:5"));
    ergopath(&["evaluate", "x.csv", "--chain", &chain, "--methods", "mi-nsg"])
        .code(2)
        .stderr(contains("mi-nsgp"));
    ergopath(&["evaluate", "x.csv", "--chain", &chain, "--task-noise", "-1"]).code(2);
    let data = folder.path().join("d.csv");
    std::fs::write(&data, "q0,q1\n1,2\n").unwrap();
    ergopath(&["evaluate", data.to_str().unwrap(), "--chain", &chain])
        .code(2)
        .stderr(contains("xdot"));
}

#[test]
fn exported_data_and_recordings_are_judged_with_rollouts() {
    let folder = tempfile::tempdir().unwrap();
    let demo = "scenarios/demonstrations/simulated_operator.csv";
    let out = ergopath(&[
        "evaluate",
        demo,
        "--body",
        "female_p50",
        "--methods",
        "full-w",
        "--rollout",
        "--json",
    ])
    .success();
    let found = json(&out.get_output().stdout);
    let walk = &found["methods"][0]["rollout"];
    let coverage = walk["coverage_90"]["median"].as_f64().unwrap();
    assert!((0.75..=1.0).contains(&coverage), "{coverage}");
    assert!(walk["pulled_path_error_deg"]["median"].as_f64().unwrap() < 5.0);
    // What train exports is what evaluate reads.
    let (model, data) = (folder.path().join("m.json"), folder.path().join("d.csv"));
    let (model, data) = (model.to_str().unwrap(), data.to_str().unwrap());
    let three = common::short_demonstration(folder.path());
    let three = three.to_str().unwrap();
    ergopath(&["train", three, "--body", "female_p50", "-o", model, "--export", data]).success();
    ergopath(&[
        "evaluate",
        data,
        "--chain",
        "models/human/female_p50.urdf:Pelvis:RightGrip",
        "--methods",
        "w-ik,full-w",
    ])
    .success()
    .stdout(contains("full-w").and(contains("rows with train = 0")));
}

#[test]
fn what_trains_and_what_tests_may_be_named_and_each_trial_is_judged() {
    let room = tempfile::tempdir().unwrap();
    let part = |name: &str, movements| {
        let path = common::part_of_demonstration(room.path(), name, movements);
        path.to_str().unwrap().to_owned()
    };
    let (a, b, c) = (part("a.csv", 1..=8), part("b.csv", 9..=10), part("c.csv", 11..=11));
    let judged = |files: &[&str], more: &[&str]| {
        let mut all = vec!["evaluate"];
        all.extend(files);
        all.extend(["--body", "female_p50", "--methods", "plain-ik,full-w", "--json"]);
        all.extend(more);
        json(&ergopath(&all).success().get_output().stdout)
    };
    let both = judged(&[&a, "--test", &b, &c], &["--rollout"]);
    assert_eq!(both["data"][0]["split"], "b.csv, c.csv");
    let trials = |found: &serde_json::Value, method: usize| {
        found["methods"][method]["trials"].as_array().unwrap().clone()
    };
    let names: Vec<String> =
        trials(&both, 1).iter().map(|t| t["trial"].as_str().unwrap().to_owned()).collect();
    assert_eq!(names, ["b.csv trial 9", "b.csv trial 10", "c.csv trial 11"]);
    // What tests beside it teaches nothing: the figures of c are those where it tests alone.
    let alone = judged(&[&a, "--test", &c], &["--rollout"]);
    for method in [0, 1] {
        let (own, among) = (&trials(&alone, method)[0], &trials(&both, method)[2]);
        for figure in ["rows", "ll_q", "rmse_q", "relative_rmse_q"] {
            assert_eq!(own[figure], among[figure], "{figure}");
        }
        assert_eq!(own["walk"]["pulled_path_error_deg"], among["walk"]["pulled_path_error_deg"]);
    }
    // The whole is what its trials make: a walk counts by its frames.
    let of = |figure: &str| {
        let all = trials(&both, 1);
        let rows = |t: &serde_json::Value| t["rows"].as_f64().unwrap();
        let sum: f64 = all.iter().map(|t| rows(t) * t["walk"][figure].as_f64().unwrap()).sum();
        sum / all.iter().map(rows).sum::<f64>()
    };
    let whole = &both["methods"][1]["rollout"];
    let error = whole["pulled_path_error_deg"]["median"].as_f64().unwrap();
    assert!((of("pulled_path_error_deg") - error).abs() < 1e-9);
    let coverage = whole["coverage_90"]["median"].as_f64().unwrap();
    assert!((of("coverage_90") - coverage).abs() < 0.005, "{coverage}");
    // And a law that learned from more is another.
    let more = judged(&[&a, &b, "--test", &c], &[]);
    assert_ne!(trials(&more, 1)[0]["rmse_q"], trials(&alone, 1)[0]["rmse_q"]);

    ergopath(&["evaluate", &a, "--test", &a, "--body", "female_p50"])
        .code(2)
        .stderr(contains("is given twice"));
    ergopath(&["evaluate", &a, "--test", &c, "--split", "trials", "--body", "female_p50"])
        .code(2)
        .stderr(contains("cannot be used with"));
    ergopath(&["evaluate", &a, "--test", &b, "--body", "female_p50", "--methods", "full-w"])
        .success()
        .stdout(contains("By held-out trial").and(contains("b.csv trial 10")));
}

#[test]
fn the_toy_experiment_writes_its_figure_and_scores() {
    let folder = tempfile::tempdir().unwrap();
    let constants = folder.path().join("c.toml");
    std::fs::write(&constants, "samples = 300\n").unwrap();
    let out = folder.path().join("toy");
    ergopath(&[
        "experiment",
        "toy-5r",
        "--repeats",
        "1",
        "--no-low-noise",
        "--constants",
        constants.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
    ])
    .success()
    .stdout(contains("MI-NsGP (marginal) against NsGP").and(contains("paper")));
    let png = std::fs::read(out.join("toy-5r.png")).unwrap();
    assert_eq!(&png[1..4], b"PNG");
    assert!(out.join("toy-5r.csv").is_file() && out.join("toy-5r.json").is_file());
    std::fs::write(&constants, "sample = 300\n").unwrap();
    ergopath(&["experiment", "toy-5r", "--constants", constants.to_str().unwrap()])
        .code(2)
        .stderr(contains("samples"));
}

//! `ergopath bench` from outside: one family of the quick subset, and the same bytes again.

use crate::common::ergopath;
use assert_cmd::Command;
use serde_json::Value;

fn bench(threads: &str, output: &std::path::Path) -> Command {
    let mut command = ergopath();
    command.args([
        "bench",
        "--quick",
        "--families",
        "low-bin",
        "--seed",
        "7",
        "--repetitions",
        "64",
    ]);
    command.arg("--pace");
    command.args(["--threads", threads, "-o"]).arg(output);
    command
}

#[test]
fn our_path_is_better_than_the_straight_one_under_the_truth() {
    let room = tempfile::tempdir().unwrap();
    let folders = ["1", "2"].map(|threads| {
        let folder = room.path().join(threads);
        bench(threads, &folder).assert().success();
        folder
    });
    let [one, two] = folders.map(|f| std::fs::read_to_string(f.join("result.json")).unwrap());
    assert!(one == two, "the result depends on the number of threads");
    let result: Value = serde_json::from_str(&one).unwrap();
    assert_eq!(result["simulated"], true);
    let rows = result["table"]["rows"].as_array().unwrap();
    let all = rows.iter().find(|r| r["family"].is_null() && r["kind"].is_null()).unwrap();
    for picture in ["gains.png", "oracle_share.png"] {
        let png = std::fs::read(room.path().join("1").join(picture)).unwrap();
        assert!(png.starts_with(b"\x89PNG"), "{picture}");
    }
    let gain = all["gains"].as_array().unwrap().iter().find(|g| g[0] == "straight").unwrap();
    let of = |key: &str| gain[1][key].as_f64().unwrap();
    assert!(of("mean") > 0.0, "{gain}");
    assert!(of("low95") < of("mean") && of("mean") < of("high95"), "{gain}");
    assert!(all["gains"].as_array().unwrap().iter().any(|g| g[0] == "ergopath_paced"), "{all}");
    let gains = std::fs::read_to_string(room.path().join("1").join("gains.csv")).unwrap();
    assert!(gains.contains("all,gain_expected_rula,straight,2,"), "{gains}");
    // The oracle knows more than we do.
    let share = all["share_of_oracle"]["mean"].as_f64().unwrap();
    assert!((0.3..1.1).contains(&share), "{share}");
}

#[test]
fn a_misspelt_family_is_refused() {
    ergopath()
        .args(["bench", "--families", "bnech"])
        .assert()
        .code(2)
        .stderr(predicates::str::contains("bench"));
}

/// Two hands and a whole body, with a planner that hardly searches.
#[test]
fn a_crate_is_lifted_with_both_hands_whatever_the_number_of_threads() {
    let room = tempfile::tempdir().unwrap();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/planners/quick.toml");
    let mut planner = std::fs::read_to_string(shipped).unwrap();
    for (from, to) in [
        ("population = 12", "population = 6"),
        ("generations = 8", "generations = 2"),
        ("baseline_generations = 2", "baseline_generations = 1"),
        ("steps = 50", "steps = 30"),
        ("rollouts_most = 8", "rollouts_most = 4"),
        ("rollouts_final = 32", "rollouts_final = 12"),
    ] {
        let changed = planner.replacen(from, to, 1);
        assert_ne!(changed, planner, "{from}");
        planner = changed;
    }
    let file = room.path().join("tiny.toml");
    std::fs::write(&file, planner).unwrap();
    let results = ["1", "2"].map(|threads| {
        let folder = room.path().join(threads);
        ergopath()
            .args(["bench", "--quick", "--families", "two-handed,deep-bin", "--seed", "7"])
            .args(["--repetitions", "24", "--threads", threads, "--planner"])
            .arg(&file)
            .arg("-o")
            .arg(&folder)
            .assert()
            .success()
            .stdout(predicates::str::contains("two-handed lift"));
        std::fs::read_to_string(folder.join("result.json")).unwrap()
    });
    assert!(results[0] == results[1], "the result depends on the number of threads");
    let result: Value = serde_json::from_str(&results[0]).unwrap();
    let cells = result["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 4);
    for cell in cells {
        assert!(cell["failure"].is_null(), "{cell}");
        let outcomes = cell["outcomes"].as_array().unwrap();
        for planner in ["ergopath", "straight", "oracle"] {
            let own = outcomes.iter().find(|o| o["planner"] == planner);
            let own = own.unwrap_or_else(|| panic!("{planner}: {cell}"));
            assert!(own["reach_exceeded"].as_f64().unwrap() < 0.5, "{own}");
        }
    }
}

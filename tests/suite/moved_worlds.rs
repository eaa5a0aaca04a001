//! Scenarios that are the same in another place, or in a mirror, have the same result.

use ergopath::planner::{CandidateResult, Preset, Request, RunResult, Step, load_preset, plan};
use ergopath::scenario::read_scenario;
use std::path::Path;

fn small() -> Preset {
    let mut preset = load_preset("quick").unwrap();
    (preset.population, preset.generations) = (4, 1);
    (preset.rollouts_first, preset.rollouts_most, preset.rollouts_final) = (2, 2, 8);
    (preset.shortlist, preset.reported, preset.baseline_generations) = (1, 1, 1);
    preset
}

fn shipped(name: &str) -> toml::Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

fn planned(scenario: &toml::Table, preset: Preset, seed: u64) -> RunResult {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("scenario.toml");
    std::fs::write(&file, toml::to_string(scenario).unwrap()).unwrap();
    let scenario = read_scenario(&file).unwrap();
    let command = "ergopath plan scenario.toml".to_owned();
    let request = Request { command, seed, preset, keeps_rollouts: false, resume: None };
    plan(&scenario, &request, &|_: Step| true).unwrap()
}

fn straight(result: &RunResult) -> &CandidateResult {
    result.candidates.iter().find(|c| c.id == "straight").unwrap()
}

/// Every number under keys of places, where they are.
fn places(value: &mut toml::Value, change: &dyn Fn(&str, &mut Vec<toml::Value>)) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                match value {
                    toml::Value::Array(list) if !list[0].is_table() => change(key, list),
                    other => places(other, change),
                }
            }
        }
        toml::Value::Array(list) => list.iter_mut().for_each(|v| places(v, change)),
        _ => {}
    }
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).unwrap()
}

/// The scenario in a mirror: left is right.
fn mirrored(scenario: &toml::Table) -> toml::Table {
    let mut all = toml::Value::Table(scenario.clone());
    places(&mut all, &|key, list| match key {
        "position_m" | "at_m" => list[1] = (-number(&list[1])).into(),
        "rpy_deg" => [0, 2].iter().for_each(|i| list[*i] = (-number(&list[*i])).into()),
        "min_m" | "max_m" => panic!("boxes swap their sides"),
        _ => {}
    });
    let toml::Value::Table(mut all) = all else { unreachable!() };
    let worker = all["worker"].as_table_mut().unwrap();
    let other = match worker["hands"].as_str().unwrap() {
        "right" => "left",
        "left" => "right",
        both => both,
    };
    worker.insert("hands".into(), other.into());
    let grip = all["grip"].as_table_mut().unwrap();
    if let (Some(right), Some(left)) = (grip.remove("right"), grip.remove("left")) {
        grip.insert("right".into(), left);
        grip.insert("left".into(), right);
    }
    all
}

/// The scenario moved in the hall and turned by a quarter, to the left.
fn moved(scenario: &toml::Table) -> toml::Table {
    let turned = |list: &mut Vec<toml::Value>| {
        let (x, y) = (number(&list[0]), number(&list[1]));
        (list[0], list[1]) = ((4.5 - y).into(), (x - 2.25).into());
    };
    let mut all = scenario.clone();
    for name in ["robot", "start", "goal", "worker"] {
        let table = all[name].as_table_mut().unwrap();
        let table = if name == "robot" { table["base"].as_table_mut().unwrap() } else { table };
        let key = if name == "worker" { "at_m" } else { "position_m" };
        turned(table[key].as_array_mut().unwrap());
        match table.get_mut("rpy_deg").and_then(|v| v.as_array_mut()) {
            Some(rpy) => rpy[2] = (number(&rpy[2]) + 90.0).into(),
            None => {
                table.insert("facing_deg".into(), (number(&table["facing_deg"]) + 90.0).into());
            }
        }
    }
    all
}

/// Scores, repetition by repetition, and what the body does.
fn assert_alike(a: &RunResult, b: &RunResult, what: &str) {
    for (a, b) in straight(a).bodies.iter().zip(&straight(b).bodies) {
        assert!(a.rollouts > 0 && a.rollouts == b.rollouts, "{what}");
        for (a, b) in [(a.rula(), b.rula()), (a.reba(), b.reba())] {
            assert_eq!(a.by_rollout.len(), b.by_rollout.len(), "{what}");
            for (a, b) in a.by_rollout.iter().zip(&b.by_rollout) {
                assert!((a - b).abs() < 1e-9, "{what}: {a} and {b}");
            }
        }
        let [a, b] = [a, b].map(|s| s.strain.as_ref().unwrap());
        for (a, b) in [(a.l5s1_peak_nm, b.l5s1_peak_nm), (a.trunk_flexion_deg, b.trunk_flexion_deg)]
        {
            // The path's solver stops at its own tolerance, which is not the same number elsewhere.
            let off = (a.median - b.median).abs();
            // Nor is a small angle told better than a large one.
            assert!(off < 1e-7 * a.median.abs().max(1.0), "{what}: {a:?} and {b:?}");
        }
    }
}

#[test]
fn a_mirrored_scenario_has_the_mirrored_result() {
    for name in ["overhead_handle", "low_bin", "along_the_bench"] {
        let scenario = shipped(name);
        let [a, b] = [&scenario, &mirrored(&scenario)].map(|s| planned(s, small(), 3));
        assert_alike(&a, &b, &format!("{name} mirrored"));
    }
}

#[test]
fn a_cell_that_stands_elsewhere_has_the_same_result() {
    for name in ["overhead_handle", "low_bin", "along_the_bench"] {
        let scenario = shipped(name);
        let [a, b] = [&scenario, &moved(&scenario)].map(|s| planned(s, small(), 3));
        assert_alike(&a, &b, &format!("{name} elsewhere"));
    }
}

/// One arm on a fixed pelvis, the head in line, the other arm unscored: the figures from before
/// pelvis, head and other arm were predicted. The demonstration model was trained again since, when steps
/// began to bend: by the model before, they are 3.90 and 4.02 with these steps too (standard error 0.03).
#[test]
fn the_arm_on_a_fixed_pelvis_scores_as_it_did() {
    let mut scenario = shipped("bench_pick_and_place");
    let worker = scenario["worker"].as_table_mut().unwrap();
    worker.insert("neck".into(), "neutral".into());
    worker.insert("other_arm".into(), "unknown".into());
    let result = planned(&scenario, load_preset("quick").unwrap(), 1);
    let expected = |c: &CandidateResult| c.bodies[0].rula().distribution.expected;
    let best = result.candidates.iter().find(|c| c.rank == Some(1)).unwrap();
    let found = [expected(best), expected(straight(&result))];
    for (found, wanted) in found.iter().zip([3.87, 4.02]) {
        assert!((found - wanted).abs() < 0.006, "{found}, not {wanted}");
    }
}

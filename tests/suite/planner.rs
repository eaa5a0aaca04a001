//! The planner as a library: interruption, freedoms, stations that straight legs cannot serve.

use ergopath::ergobench::{Family, draw};
use ergopath::math::stream::{Purpose, stream};
use ergopath::planner::{
    Evaluated, Finding, Hint, PlanError, Preset, Request, RunResult, Step, load_preset, plan,
};
use ergopath::report::result_json;
use ergopath::scenario::{Scenario, read_scenario};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

fn tiny() -> Preset {
    let mut preset = load_preset("quick").unwrap();
    (preset.population, preset.generations, preset.steps) = (6, 3, 30);
    (preset.rollouts_first, preset.rollouts_most, preset.rollouts_final) = (2, 4, 12);
    (preset.shortlist, preset.reported, preset.baseline_generations) = (3, 2, 1);
    preset
}

fn request(preset: Preset) -> Request {
    Request {
        command: "ergopath plan scenario.toml".to_owned(),
        seed: 3,
        preset,
        keeps_rollouts: false,
        resume: None,
    }
}

fn bench(more: &str) -> Scenario {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bench_pick_and_place.toml");
    let text = std::fs::read_to_string(shipped).unwrap() + more;
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("scenario.toml");
    std::fs::write(&file, text).unwrap();
    read_scenario(&file).unwrap()
}

fn run(scenario: &Scenario, request: &Request) -> RunResult {
    plan(scenario, request, &|_: Step| true).unwrap()
}

#[test]
fn an_interrupted_search_goes_on_as_if_nothing_had_happened() {
    let scenario = bench("");
    let whole = result_json(&run(&scenario, &request(tiny()))).unwrap();
    for stop_at in [1, 20, 45] {
        let count = AtomicUsize::new(0);
        let told = |_: Step| count.fetch_add(1, Ordering::Relaxed) < stop_at;
        let Err(PlanError::Interrupted(Some(kept))) = plan(&scenario, &request(tiny()), &told)
        else {
            panic!("not interrupted at {stop_at}");
        };
        // By way of the file, as a user's would.
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("kept.json");
        std::fs::write(&file, kept.text().unwrap()).unwrap();
        let kept = ergopath::planner::Checkpoint::read(&file).unwrap();
        let again = Request { resume: Some(kept.clone()), ..request(tiny()) };
        assert_eq!(result_json(&run(&scenario, &again)).unwrap(), whole, "stopped at {stop_at}");
        let other = Request { resume: Some(kept), seed: 4, ..request(tiny()) };
        let refused = plan(&scenario, &other, &|_: Step| true).unwrap_err();
        assert!(refused.to_string().contains("another seed"), "{refused}");
    }
}

#[test]
fn the_goal_may_be_chosen_within_its_box_and_its_worth_is_told() {
    let scenario = bench("\n[free]\ngoal_box_m = [0.06, 0.0, 0.05]\ngoal_yaw_deg = [-20, 20]\n");
    assert_eq!(scenario.free.names(), ["goal position", "goal yaw"]);
    let result = run(&scenario, &request(tiny()));
    let reported: Vec<_> =
        result.candidates.iter().filter(|c| c.evaluated == Evaluated::Reported).collect();
    let end = |id: &str| {
        let c = reported.iter().find(|c| c.id == id).unwrap();
        *c.path.as_ref().unwrap().tcp.last().unwrap()
    };
    let goal = scenario.goal.translation.vector;
    for c in &reported {
        let at = end(&c.id);
        assert!((at[0] - goal.x).abs() <= 0.06 + 1e-9, "{}: {at:?}", c.id);
        assert!((at[1] - goal.y).abs() <= 1e-9, "{}: {at:?}", c.id);
        assert!((at[2] - goal.z).abs() <= 0.05 + 1e-9, "{}: {at:?}", c.id);
    }
    // Baselines that are drawn keep the scenario's goal; without the freedom so does the search.
    for id in ["straight", "expert_arc", "without goal position"] {
        assert!((end(id)[0] - goal.x).abs() < 1e-9, "{id}");
    }
    let worth: Vec<Option<String>> = result
        .verdict
        .findings
        .iter()
        .filter_map(|f| match f {
            Finding::Worth { freedom, .. } => Some(freedom.clone()),
            _ => None,
        })
        .collect();
    assert!(worth.contains(&Some("goal position".into())), "{worth:?}");
    assert!(worth.contains(&Some("goal yaw".into())), "{worth:?}");
}

#[test]
fn heights_for_bent_legs_are_refused_in_words() {
    for family in [Family::DeepBin, Family::FloorLift] {
        let mut rng = stream(1, Purpose::Simulation, 0, 0);
        let mut station = draw(family, 0, &mut rng);
        // From a little higher up a tall man gets there on straight legs, far beyond what was recorded.
        station.ends[0].z = 0.32;
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("scenario.toml");
        std::fs::write(&file, station.scenario("male_p95", "demo_operator", 1)).unwrap();
        let result = run(&read_scenario(&file).unwrap(), &request(tiny()));
        assert!(result.verdict.best.is_none(), "{family:?}: {:?}", result.verdict.best);
        let hints = &result.verdict.hints;
        assert!(hints.contains(&Hint::NeedsBentLegs), "{family:?}: {hints:?}");
    }
}

#[test]
fn a_whole_person_is_planned_at_a_height_for_bent_legs() {
    let mut rng = stream(1, Purpose::Simulation, 0, 0);
    let station = draw(Family::DeepBin, 0, &mut rng);
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("scenario.toml");
    std::fs::write(&file, station.scenario("male_p95", "whole_operator", 1)).unwrap();
    let result = run(&read_scenario(&file).unwrap(), &request(tiny()));
    let best = result.candidates.iter().find(|c| c.rank == Some(1));
    let body = &best.unwrap_or_else(|| panic!("{:?}", result.verdict.hints)).bodies[0];
    let knee = body.strain.as_ref().unwrap().knee_flexion_deg.unwrap().median;
    assert!(body.reach_exceeded < 0.1 && knee > 20.0, "{knee} deg, {}", body.reach_exceeded);
}

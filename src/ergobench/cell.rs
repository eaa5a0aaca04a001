//! One cell of the benchmark: a workstation, a body, a person.
//!
//! ```text
//! person ─ demonstrations on other paths ─ training ─► posture model ─ plan ─► our path, baselines
//!        ─ plan knowing the person                                          ─► the oracle's path
//! all paths ─ the person walks each of them          ─► figures under the truth
//! ```

use super::demonstrate::Demonstrator;
use super::families::{Station, draw};
use super::people::{Kind, TruePerson};
use super::statistics::Statistics;
use super::{Family, OURS, PACED, Question};
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::math::stats::{cvar_upper, mean};
use crate::math::stream::{Purpose, stream};
use crate::math::{Pose, Vec3};
use crate::path;
use crate::planner::{
    BodyScores, CandidateResult, Decision, Evaluated, PlanError, Request, RunResult, Stage, Status,
    judge_truly, plan, plan_knowing,
};
use crate::posture::{Method, Provenance, save_model};
use crate::scenario::{PACE_SPREAD, Scenario, read_scenario};
use crate::training::{Dataset, TrainSettings, learn};
use crate::trajectory::TimedPath;
use crate::words::refused;
use nalgebra::UnitQuaternion;
use serde::Serialize;
use std::path::Path;

/// Workstations that are drawn before one within reach must have been found.
const MOST_DRAWS: u32 = 60;
/// Block of chance of the final judgement.
const JUDGE_BLOCK: u32 = 200_000;
/// Posture model beside the scenario.
const MODEL_FILE: &str = "model.json";

/// Figures of one planner's path under the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The planner: `ergopath`, `ergopath_paced` (the pace of the path is free), `oracle`, or the id of a
    /// baseline.
    pub planner: String,
    /// Expected RULA.
    pub expected_rula: f64,
    /// Mean of the worst tenth of repetitions.
    pub cvar90_rula: f64,
    /// Share of time at RULA 5 or more.
    pub exposure_rula_5: f64,
    /// Expected REBA.
    pub expected_reba: f64,
    /// Share of repetitions whose reach was exceeded.
    pub reach_exceeded: f64,
    /// Expected RULA that the planner's own model predicted, where it reported one.
    pub predicted_rula: Option<f64>,
    /// Share of time at RULA 5 or more that it predicted, likewise.
    pub predicted_exposure_rula_5: Option<f64>,
    /// Time means of RULA by repetition, for pairs.
    #[serde(skip)]
    pub rula: Vec<f64>,
    /// Shares of time at RULA 5 or more by repetition.
    #[serde(skip)]
    pub high: Vec<f64>,
}

/// One cell.
#[derive(Debug, Clone, Serialize)]
pub struct Cell {
    /// Name of the workstation.
    pub station: String,
    /// Its family.
    pub family: Family,
    /// Name of the body.
    pub body: String,
    /// Kind of the person.
    pub kind: Kind,
    /// Workstations that were out of reach before this one.
    pub redrawn: u32,
    /// How the joints moved in the person's demonstrations.
    pub demonstrated: Option<Statistics>,
    /// What each planner's path causes; empty when none is feasible.
    pub outcomes: Vec<Outcome>,
    /// Why there is no outcome.
    pub failure: Option<String>,
}

/// What a cell is made of.
pub(super) struct Draft<'a> {
    pub family: Family,
    pub number: u64,
    pub body: &'a Body,
    pub kind: Kind,
    pub person_number: u64,
}

/// Runs one cell in `folder`, where its scenario and model stay.
pub(super) fn run_cell(
    draft: &Draft,
    question: &Question,
    folder: &Path,
    stage: Stage,
) -> Result<Cell, PlanError> {
    let contacts = draft.family.contacts();
    let person = TruePerson::new(draft.body, contacts, draft.kind, draft.person_number)?;
    let Found { station, redrawn, scenario, demonstrated } =
        station(draft, &person, question, folder)?;
    let mut cell = Cell {
        station: station.name.clone(),
        family: draft.family,
        body: draft.body.name.clone(),
        kind: draft.kind,
        redrawn,
        demonstrated: Some(demonstrated),
        outcomes: Vec::new(),
        failure: None,
    };
    let request = Request {
        command: String::new(),
        seed: question.seed,
        preset: question.preset.clone(),
        keeps_rollouts: false,
        resume: None,
    };
    let ours = plan(&scenario, &request, stage)?;
    let oracle = plan_knowing(&scenario, &request, stage, &person)?;
    let mut paths = named_paths(&ours, &oracle);
    if question.pace {
        let mut paced = scenario.clone();
        paced.free.pace_spread = Some(PACE_SPREAD);
        let paced = plan(&paced, &request, stage)?;
        paths.extend(best_of_search(&paced).and_then(|c| named(PACED, c)));
    }
    if ours.verdict.outcome == Decision::NothingFeasible {
        cell.failure = Some(refused::lines(&ours).join(" "));
        return Ok(cell);
    }
    let timed: Vec<TimedPath> = paths.iter().map(|p| p.1.clone()).collect();
    let block = (question.seed, JUDGE_BLOCK);
    let figures = judge_truly(&scenario, &person, &timed, block, question.repetitions)?;
    for ((planner, _, predicted), bodies) in paths.into_iter().zip(figures) {
        let Some(f) = bodies.into_iter().next() else { continue };
        cell.outcomes.push(Outcome {
            planner,
            expected_rula: mean(&f.rula().time_mean),
            cvar90_rula: cvar_upper(&f.rula().time_mean, 0.1),
            exposure_rula_5: mean(&f.rula().high),
            expected_reba: mean(&f.reba().time_mean),
            reach_exceeded: mean(&f.lost),
            predicted_rula: predicted.map(|p| p[0]),
            predicted_exposure_rula_5: predicted.map(|p| p[1]),
            rula: f.rula().time_mean.clone(),
            high: f.rula().high.clone(),
        });
    }
    Ok(cell)
}

/// Name, path, and predicted expected RULA and share of time at RULA 5 or more of a planner's answer.
type Answer = (String, TimedPath, Option<[f64; 2]>);

const BASELINES: [&str; 6] = [
    "straight",
    "shortest",
    "expert_arc",
    "best_random",
    "single_posture_plain",
    "single_posture_learned",
];

fn named_paths(ours: &RunResult, oracle: &RunResult) -> Vec<Answer> {
    let baseline = |id: &&str| {
        let found = reported(ours).find(|c| c.id == *id)?;
        named(id, found)
    };
    let own = best_of_search(ours).and_then(|c| named(OURS, c));
    let knowing = best_of_search(oracle).and_then(|c| named("oracle", c));
    own.into_iter().chain(BASELINES.iter().filter_map(baseline)).chain(knowing).collect()
}

fn reported(run: &RunResult) -> impl Iterator<Item = &CandidateResult> {
    run.candidates
        .iter()
        .filter(|c| c.evaluated == Evaluated::Reported && c.status == Status::Feasible)
}

/// The best of a search itself, even where the model thinks a baseline as good.
fn best_of_search(run: &RunResult) -> Option<&CandidateResult> {
    reported(run).find(|c| c.family == path::Family::Sampled && c.bought.is_empty())
}

fn named(name: &str, c: &CandidateResult) -> Option<Answer> {
    let path = c.path.as_ref()?;
    let poses = path.tcp.iter().map(pose).collect();
    let path = TimedPath::new(path.time_s.clone(), poses).ok()?;
    let predicted = |b: &BodyScores| [b.rula().distribution.expected, b.rula().high_band[0]];
    Some((name.to_owned(), path, c.bodies.first().map(predicted)))
}

fn pose(p: &[f64; 7]) -> Pose {
    let q = nalgebra::Quaternion::new(p[3], p[4], p[5], p[6]);
    Pose::from_parts(Vec3::new(p[0], p[1], p[2]).into(), UnitQuaternion::new_normalize(q))
}

/// A workstation that a person reaches, with the model learned for it in the scenario.
struct Found {
    station: Station,
    redrawn: u32,
    scenario: Scenario,
    demonstrated: Statistics,
}

/// The first workstation that the person reaches at both ends.
fn station(
    draft: &Draft,
    person: &TruePerson,
    question: &Question,
    folder: &Path,
) -> Result<Found, InputError> {
    for redrawn in 0..MOST_DRAWS {
        let name = (draft.number * 10_000) as u32 + draft.family as u32 * 1000 + redrawn;
        let mut rng = stream(question.seed, Purpose::Simulation, 20, name);
        let station = draw(draft.family, draft.number, &mut rng);
        // A first look needs no model of this person: the shipped one stands in.
        let stand_in = draft.family.stand_in();
        let text = station.scenario(&draft.body.name, stand_in, question.seed);
        let scenario = written(folder, &text)?;
        let reach = Demonstrator::new(&scenario, draft.body, person)?;
        if !reach.reaches(&scenario.start) || !reach.reaches(&scenario.goal) {
            continue;
        }
        let trials = reach.demonstrate(
            &station,
            question.seed + 7919 * draft.person_number,
            question.demonstrations,
        );
        if trials.len() < question.demonstrations {
            continue;
        }
        let dataset = Dataset::new(&trials, draft.body, Side::Right)?;
        let provenance = Provenance {
            filled_from: None,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            simulated: true,
            adapted_s: None,
            people: 1,
            recordings: Vec::new(),
            body: (draft.body.name.clone(), draft.body.sha256()),
            settings: Vec::new(),
            notes: vec!["learned from a simulated person by ErgoBench".to_owned()],
        };
        let settings = TrainSettings::default();
        let model = learn(&dataset, "ErgoBench person", Method::FullW, &settings, provenance)?;
        save_model(&model, &folder.join(MODEL_FILE))?;
        let text = station.scenario(&draft.body.name, MODEL_FILE, question.seed);
        let scenario = written(folder, &text)?;
        let demonstrated = Statistics::of(&trials);
        return Ok(Found { station, redrawn, scenario, demonstrated });
    }
    Err(InputError::new(
        draft.family.name(),
        format!("no workstation within reach of {} in {MOST_DRAWS} draws", draft.body.name),
    ))
}

fn written(folder: &Path, text: &str) -> Result<Scenario, InputError> {
    let file = folder.join("scenario.toml");
    crate::files::write_whole(&file, text.as_bytes())?;
    read_scenario(&file)
}

//! One cell of the benchmark: a workstation, a body, a person.
//!
//! ```text
//! person ─ demonstrations on other paths ─ training ─► posture model ─ plan ─► our path, baselines
//!        ─ plan knowing the person                                          ─► the oracle's path
//! all paths ─ the person walks each of them          ─► figures under the truth
//! ```

use super::families::{Station, draw};
use super::people::{Kind, TruePerson};
use super::{Family, Question};
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::math::pose::interpolate;
use crate::math::stats::{cvar_upper, mean};
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use crate::planner::{
    Evaluated, PlanError, Request, RunResult, Stage, Status, judge_truly, plan, plan_knowing,
};
use crate::posture::{
    Behaviour, Coupling, Method, Provenance, StartRule, save_model, start_postures,
};
use crate::scenario::{Scenario, read_scenario};
use crate::training::{Dataset, TrainSettings, Trial, learn, trial_of};
use crate::trajectory::TimedPath;
use crate::words::refused;
use nalgebra::UnitQuaternion;
use rand::RngExt as _;
use serde::Serialize;
use std::path::Path;

/// Samples per second of a demonstration.
const RATE_HZ: f64 = 30.0;
/// Tilt of the grip in demonstrations, rad.
const TILT_RAD: f64 = 0.05;
/// Workstations that are drawn before one within reach must have been found.
const MOST_DRAWS: u32 = 60;
/// Blocks of chance: demonstrations, and the final judgement.
const DEMONSTRATION_BLOCK: u32 = 100_000;
const JUDGE_BLOCK: u32 = 200_000;
/// Posture model beside the scenario.
const MODEL_FILE: &str = "model.json";

/// Figures of one planner's path under the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The planner: `ergopath`, `oracle`, or the id of a baseline.
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
    /// Time means of RULA by repetition, for pairs.
    #[serde(skip)]
    pub rula: Vec<f64>,
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
    let person = TruePerson::new(draft.body, Side::Right, draft.kind, draft.person_number)?;
    let (station, redrawn, scenario) = station(draft, &person, question, folder)?;
    let mut cell = Cell {
        station: station.name.clone(),
        family: draft.family,
        body: draft.body.name.clone(),
        kind: draft.kind,
        redrawn,
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
    let paths = named_paths(&ours, &oracle);
    if ours.verdict.best.is_none() {
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
            predicted_rula: predicted,
            rula: f.rula().time_mean.clone(),
        });
    }
    Ok(cell)
}

/// Name, path and predicted expected RULA of every planner's answer.
fn named_paths(ours: &RunResult, oracle: &RunResult) -> Vec<(String, TimedPath, Option<f64>)> {
    let baselines = [
        "straight",
        "shortest",
        "expert_arc",
        "best_random",
        "single_posture_plain",
        "single_posture_learned",
    ];
    let mut all = Vec::new();
    let reported = |r: &RunResult| -> Vec<crate::planner::CandidateResult> {
        let is = |c: &&crate::planner::CandidateResult| {
            c.evaluated == Evaluated::Reported && c.status == Status::Feasible
        };
        r.candidates.iter().filter(is).cloned().collect()
    };
    let mut add = |name: &str, c: &crate::planner::CandidateResult| {
        let path = c.path.as_ref().and_then(|p| {
            let poses = p.tcp.iter().map(pose).collect();
            TimedPath::new(p.time_s.clone(), poses).ok()
        });
        let predicted = c.bodies.first().map(|b| b.rula().distribution.expected);
        all.extend(path.map(|p| (name.to_owned(), p, predicted)));
    };
    let own = reported(ours);
    // Ours is the best of our search, even where the model thinks a baseline as good.
    if let Some(best) = own.iter().find(|c| !baselines.contains(&c.id.as_str())) {
        add("ergopath", best);
    }
    for id in baselines {
        if let Some(c) = own.iter().find(|c| c.id == id) {
            add(id, c);
        }
    }
    if let Some(best) = reported(oracle).iter().find(|c| !baselines.contains(&c.id.as_str())) {
        add("oracle", best);
    }
    all
}

fn pose(p: &[f64; 7]) -> Pose {
    let q = nalgebra::Quaternion::new(p[3], p[4], p[5], p[6]);
    Pose::from_parts(Vec3::new(p[0], p[1], p[2]).into(), UnitQuaternion::new_normalize(q))
}

/// The first workstation that the person reaches at both ends, with the model learned for it.
fn station(
    draft: &Draft,
    person: &TruePerson,
    question: &Question,
    folder: &Path,
) -> Result<(Station, u32, Scenario), InputError> {
    for redrawn in 0..MOST_DRAWS {
        let name = draft.family as u32 * 1000 + redrawn;
        let mut rng = stream(question.seed + draft.number, Purpose::Simulation, 20, name);
        let station = draw(draft.family, draft.number, false, &mut rng);
        // A first look needs no model of this person: the shipped one stands in.
        let text = station.scenario(&draft.body.name, "demo_operator", question.seed);
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
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            simulated: true,
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
        return Ok((station, redrawn, scenario));
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

/// A person at a workstation, showing movements.
struct Demonstrator<'a> {
    scenario: &'a Scenario,
    coupling: Coupling,
    person: &'a TruePerson,
    world_to_pelvis: Pose,
}

impl<'a> Demonstrator<'a> {
    fn new(
        scenario: &'a Scenario,
        body: &Body,
        person: &'a TruePerson,
    ) -> Result<Self, InputError> {
        let w = &scenario.worker;
        let pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance);
        let coupling = Coupling::new(body, w.side, scenario.hold)?;
        Ok(Self { scenario, coupling, person, world_to_pelvis: pelvis.inverse() })
    }

    fn grip(&self, tcp: &Pose) -> Pose {
        self.world_to_pelvis * tcp * self.scenario.grip
    }

    fn reaches(&self, tcp: &Pose) -> bool {
        let hand = self.grip(tcp);
        let postures = self.person.postures();
        let starts =
            start_postures(&self.coupling, postures, &StartRule::Sampled, &hand, (0, 0), 0..8);
        starts.iter().filter(|s| s.q.is_some()).count() >= 7
    }

    /// Movements between random places about the workstation's: never the path that is planned.
    fn demonstrate(&self, station: &Station, seed: u64, count: usize) -> Vec<Trial> {
        let mut trials = Vec::new();
        for draw in 0..40 * count as u32 {
            if trials.len() == count {
                break;
            }
            trials.extend(self.movement(station, seed, draw));
        }
        trials
    }

    fn movement(&self, station: &Station, seed: u64, number: u32) -> Option<Trial> {
        let mut rng = stream(seed, Purpose::Simulation, 21, number);
        let [low, high] = station.demonstrated;
        let mut place = || {
            let at = Vec3::from_fn(|i, _| low[i] + (high[i] - low[i]) * rng.random::<f64>());
            let tilt = Vec3::from_vec(normals(&mut rng, 3)) * TILT_RAD;
            let turned = UnitQuaternion::from_scaled_axis(tilt) * self.scenario.start.rotation;
            Pose::from_parts(at.into(), turned)
        };
        let (from, to) = (place(), place());
        let distance = (from.translation.vector - to.translation.vector).norm();
        if distance < 0.2 {
            return None;
        }
        // A bend across the way: not all of life is straight.
        let bend = Vec3::from_vec(normals(&mut rng, 3)) * (0.12 * distance);
        let duration = 1.6 + rng.random::<f64>();
        let count = (duration * RATE_HZ).round() as usize;
        let times: Vec<f64> = (0..=count).map(|i| i as f64 / RATE_HZ).collect();
        let hands: Vec<Pose> = (0..=count)
            .map(|i| {
                let [s, ..] = crate::trajectory::minimum_jerk(i as f64 / count as f64);
                let mut tcp = interpolate(&from, &to, s);
                tcp.translation.vector += bend * (4.0 * s * (1.0 - s));
                self.grip(&tcp)
            })
            .collect();
        let block = (seed, DEMONSTRATION_BLOCK + number);
        let postures = self.person.postures();
        let rule = StartRule::Sampled;
        let starts = start_postures(&self.coupling, postures, &rule, &hands[0], block, 0..1);
        if starts.iter().any(|s| s.q.is_none() || s.is_unusual) {
            return None;
        }
        // The repetition's number decides between habits.
        let rollouts =
            self.person.walk(&self.coupling, (&times, &hands), &starts, block, number as usize);
        let rollout = rollouts.into_iter().next().filter(|r| r.reach_exceeded_at.is_none())?;
        let n = self.coupling.dof();
        let angles: Vec<Vec<f64>> =
            (0..n).map(|c| rollout.q.iter().map(|q| q[c]).collect()).collect();
        Some(trial_of(format!("demonstration {number}"), RATE_HZ, &angles))
    }
}

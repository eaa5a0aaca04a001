//! The stages in order: prepare, search, select, report.

use super::evaluate::{Person, Walks};
use super::explain::{
    comparisons, inputs, model_summary, not_modelled, setting, verdict, worst_index,
};
use super::lens::lens;
use super::prepare::{Prepared, Workshop};
use super::preset::Preset;
use super::result::{
    BodyScores, CandidateResult, Evaluated, RESULT_SCHEMA, RolloutTable, RunProvenance, RunResult,
    Status,
};
use crate::files::InputError;
use crate::path::{CandidateSettings, candidates};
use crate::scenario::Scenario;
use crate::survey::Lens;
use nalgebra::Vector3;
use rayon::prelude::*;
use thiserror::Error;

/// Blocks of people: one for the search, one fresh for the selection, one more for the report.
const SEARCH_BLOCK: u32 = 0;
const SELECTION_BLOCK: u32 = 1;
const REPORT_BLOCK: u32 = 2;
/// Moments at which postures are drawn.
const PICTURE_MOMENTS: usize = 7;

/// What to run.
#[derive(Debug, Clone)]
pub struct Request {
    /// The canonical command, for the record.
    pub command: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// The planner's settings.
    pub preset: Preset,
    /// Keep the sampled postures of the reported paths.
    pub keeps_rollouts: bool,
}

/// Told where a run stands (stage, done, total); answers whether to go on.
pub type Stage<'a> = &'a (dyn Fn(&'static str, usize, usize) -> bool + Sync);

/// Why a run could not be made at all. A run whose paths are all infeasible is a result, not an error.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The input does not fit together.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The user interrupted.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Plans paths for a scenario and ranks them, the user's own among them.
pub fn plan(scenario: &Scenario, request: &Request, stage: Stage) -> Result<RunResult, PlanError> {
    let preset = &request.preset;
    let settings = CandidateSettings {
        vias: preset.vias,
        named_offset_m: preset.named_offset_m,
        sampled_offset_m: preset.sampled_offset_m,
        samples: preset.samples,
        generation: 0,
    };
    let toward_body = toward_body(scenario);
    let mut all =
        candidates(&settings, &scenario.start, &scenario.goal, &toward_body, request.seed);
    all.extend(scenario.drawn.iter().cloned());
    let workshop = Workshop::new(scenario, preset, request.seed);
    let prepared = counted(stage, "checking paths", &all, |c| workshop.candidate(c))?;
    run(scenario, request, stage, &workshop, prepared)
}

/// Scores the user's own paths as they are, with the straight path beside them.
pub fn assess(
    scenario: &Scenario,
    request: &Request,
    stage: Stage,
) -> Result<RunResult, PlanError> {
    if scenario.paths.is_empty() && scenario.drawn.is_empty() {
        return Err(InputError::new(&scenario.file, "names no path to assess")
            .remedy("give --path FILE, or a [[path]] with name and file in the scenario")
            .into());
    }
    let settings = CandidateSettings { samples: 0, ..CandidateSettings::default() };
    let toward_body = toward_body(scenario);
    let mut all: Vec<_> =
        candidates(&settings, &scenario.start, &scenario.goal, &toward_body, request.seed)
            .into_iter()
            .filter(|c| c.id == "straight")
            .collect();
    all.extend(scenario.drawn.iter().cloned());
    let workshop = Workshop::new(scenario, &request.preset, request.seed);
    let prepared = all.iter().map(|c| workshop.candidate(c)).collect();
    run(scenario, request, stage, &workshop, prepared)
}

fn run(
    scenario: &Scenario,
    request: &Request,
    stage: Stage,
    workshop: &Workshop,
    mut prepared: Vec<Prepared>,
) -> Result<RunResult, PlanError> {
    let Request { seed, preset, .. } = request;
    prepared.extend(scenario.paths.iter().map(|p| workshop.users(p)));
    let people = Person::all(scenario)?;
    let lens = lens(scenario);
    let evaluator = Evaluator { people: &people, lens: &lens, scenario, seed: *seed };

    // Search: few people on every path.
    let walkable: Vec<usize> = (0..prepared.len()).filter(|&i| prepared[i].is_walkable()).collect();
    let searched = counted(stage, "searching", &walkable, |&i| {
        evaluator.scores(&prepared[i], SEARCH_BLOCK, preset.rollouts_search)
    })?;
    for (&i, scores) in walkable.iter().zip(&searched) {
        prepared[i].refuse_if_nobody_reaches(scores);
    }
    let mut order: Vec<(usize, f64)> = walkable
        .iter()
        .zip(&searched)
        .filter(|(i, _)| prepared[**i].is_walkable())
        .map(|(&i, s)| (i, objective(preset, s)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));

    // Selection: the shortlist, the straight path and the user's own, on fresh people.
    let is_kept = |i: usize| {
        let p = &prepared[i];
        p.is_users || p.id == "straight" || scenario.drawn.iter().any(|d| d.id == p.id)
    };
    let shortlist: Vec<usize> = order
        .iter()
        .enumerate()
        .filter(|(n, (i, _))| *n < preset.shortlist || is_kept(*i))
        .map(|(_, (i, _))| *i)
        .collect();
    let selected = counted(stage, "selecting", &shortlist, |&i| {
        evaluator.scores(&prepared[i], SELECTION_BLOCK, preset.rollouts_final)
    })?;
    let mut ranked: Vec<(usize, f64)> =
        shortlist.iter().zip(&selected).map(|(&i, s)| (i, objective(preset, s))).collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));

    // Report: one more block of people, which has chosen nothing.
    let finalists: Vec<usize> = ranked.iter().map(|(i, _)| *i).collect();
    let reported = counted(stage, "reporting", &finalists, |&i| {
        evaluator.report(&prepared[i], preset.rollouts_final)
    })?;
    let mut results: Vec<CandidateResult> = Vec::new();
    // The best path's walks of the body that scores worst: the one of the verdict.
    let mut best_walks: Option<Walks> = None;
    let mut rollouts = Vec::new();
    for ((&(i, value), (mut result, walks)), rank) in ranked.iter().zip(reported).zip(1..) {
        result.rank = Some(rank);
        result.objective = Some(value);
        if request.keeps_rollouts {
            rollouts.extend(evaluator.tables(&prepared[i], &walks, rank));
        }
        if best_walks.is_none() && result.status == Status::Feasible {
            let worst = worst_index(&result.bodies);
            best_walks = worst.and_then(|i| walks.into_iter().nth(i));
        }
        results.push(result);
    }
    // The others keep the order of the search.
    let rest = order.iter().filter(|(i, _)| !finalists.contains(i));
    for ((i, value), rank) in rest.zip(results.len() + 1..) {
        let at = walkable.iter().position(|w| w == i).unwrap_or_default();
        let mut result = bare(&prepared[*i], Evaluated::Search);
        result.bodies.clone_from(&searched[at]);
        result.rank = Some(rank);
        result.objective = Some(*value);
        results.push(result);
    }
    for p in prepared.iter().filter(|p| !p.is_walkable()) {
        results.push(bare(p, Evaluated::None));
    }
    let mut result = assemble(scenario, request, &lens, results, best_walks.as_ref());
    result.rollouts = rollouts;
    if result.verdict.best.is_none() {
        workshop.explain(&prepared, &mut result.verdict);
    }
    Ok(result)
}

fn assemble(
    scenario: &Scenario,
    request: &Request,
    lens: &Lens,
    candidates: Vec<CandidateResult>,
    best_walks: Option<&Walks>,
) -> RunResult {
    let comparisons = comparisons(&candidates);
    let inputs = inputs(scenario, lens, best_walks);
    RunResult {
        schema: RESULT_SCHEMA,
        provenance: provenance(scenario, request, lens),
        verdict: verdict(scenario, &candidates, &comparisons, &inputs),
        comparisons,
        inputs,
        setting: setting(scenario),
        posture_model: model_summary(scenario),
        warnings: scenario.warnings.clone(),
        not_modelled: not_modelled(scenario),
        planner: request.preset.clone(),
        rollouts: Vec::new(),
        candidates,
    }
}

fn provenance(scenario: &Scenario, request: &Request, lens: &Lens) -> RunProvenance {
    let mut inputs = vec![(scenario.file.clone(), scenario.sha256.clone())];
    inputs.push((scenario.worker.model.name.clone(), scenario.worker.model_sha256.clone()));
    inputs.extend(scenario.worker.bodies.iter().map(|b| (b.name.clone(), b.sha256())));
    inputs.extend(scenario.paths.iter().map(|p| (p.name.clone(), p.sha256.clone())));
    RunProvenance {
        program_version: env!("CARGO_PKG_VERSION"),
        command: request.command.clone(),
        seed: request.seed,
        inputs,
        score_profile: lens.profile.name.to_owned(),
    }
}

/// Evaluates paths for all bodies.
struct Evaluator<'a> {
    people: &'a [Person<'a>],
    lens: &'a Lens,
    scenario: &'a Scenario,
    seed: u64,
}

impl Evaluator<'_> {
    fn scores(&self, prepared: &Prepared, block: u32, count: usize) -> Vec<BodyScores> {
        let Some(path) = &prepared.path else { return Vec::new() };
        let of = |p: &Person| {
            let walks = p.walk(path, (self.seed, block), count);
            walks.summary(&p.name, self.lens, self.scenario.worker.other_arm)
        };
        self.people.iter().filter_map(of).collect()
    }

    /// The sampled postures of all bodies along a path.
    fn tables(&self, prepared: &Prepared, walks: &[Walks], rank: usize) -> Vec<RolloutTable> {
        let Some(path) = &prepared.path else { return Vec::new() };
        let of = |(k, (person, walks)): (usize, (&Person, &Walks))| {
            person.table(walks, path, rank, k == 0)
        };
        self.people.iter().zip(walks).enumerate().map(of).collect()
    }

    fn report(&self, prepared: &Prepared, count: usize) -> (CandidateResult, Vec<Walks>) {
        let mut result = bare(prepared, Evaluated::Reported);
        let mut all = Vec::new();
        if let Some(path) = &prepared.path {
            result.path = prepared.data(self.scenario);
            let robot_q = result.path.as_ref().map(|p| p.robot_q.clone()).unwrap_or_default();
            for person in self.people {
                let walks = person.walk(path, (self.seed, REPORT_BLOCK), count);
                let other_arm = self.scenario.worker.other_arm;
                result.bodies.extend(walks.summary(&person.name, self.lens, other_arm));
                result.poses.extend(person.pictures(&walks, path, &robot_q, PICTURE_MOMENTS));
                all.push(walks);
            }
        }
        (result, all)
    }
}

/// A path without scores.
fn bare(prepared: &Prepared, evaluated: Evaluated) -> CandidateResult {
    CandidateResult {
        rank: None,
        id: prepared.id.clone(),
        family: prepared.family,
        status: prepared.status.clone(),
        evaluated,
        changes: prepared.changes.clone(),
        vias_m: prepared.vias_m.clone(),
        objective: None,
        bodies: Vec::new(),
        path: None,
        poses: Vec::new(),
    }
}

/// The preset's objective for the worst body.
fn objective(preset: &Preset, bodies: &[BodyScores]) -> f64 {
    let o = &preset.objective;
    let of = |b: &BodyScores| {
        o.expected_rula * b.rula.expected
            + o.expected_reba * b.reba.expected
            + o.cvar90_rula * b.rula.cvar90
            + o.exposure_rula_5 * b.rula.exposure.get(5).copied().unwrap_or(0.0)
    };
    bodies.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

/// Horizontal direction from the middle of the task to the worker.
fn toward_body(scenario: &Scenario) -> Vector3<f64> {
    let middle = (scenario.start.translation.vector + scenario.goal.translation.vector) * 0.5;
    let [x, y] = scenario.worker.at_m;
    let to = Vector3::new(x - middle.x, y - middle.y, 0.0);
    // Standing on top of the task: backwards is towards the body.
    let back = Vector3::new(-scenario.worker.facing.cos(), -scenario.worker.facing.sin(), 0.0);
    if to.norm() > 1e-3 { to.normalize() } else { back }
}

/// Parallel map in order, with progress; ends early when the user interrupts.
fn counted<T: Sync, R: Send>(
    stage: Stage,
    name: &'static str,
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Result<Vec<R>, PlanError> {
    let done = std::sync::atomic::AtomicUsize::new(0);
    let go_on = |n: usize| stage(name, n, items.len()).then_some(()).ok_or(PlanError::Interrupted);
    go_on(0)?;
    items
        .par_iter()
        .map(|item| {
            go_on(done.load(std::sync::atomic::Ordering::Relaxed))?;
            let result = work(item);
            go_on(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1)?;
            Ok(result)
        })
        .collect()
}

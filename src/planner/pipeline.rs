//! The stages in order: search, baselines, selection, report.

use super::along::{bend, timing_difference};
use super::causes::unreached_ends;
use super::evaluate::{Person, Walks};
use super::explain::{inputs, model_summary, not_modelled, setting};
use super::filming;
use super::finalists::{Finalist, finalists, rest, select};
use super::guard::reported_prices;
use super::lens::lens;
use super::moments::moments;
use super::near::Care;
use super::objective::Figures;
use super::prepare::{Prepared, Workshop};
use super::preset::Preset;
use super::result::{
    BodyScores, Bought, CandidateResult, Decision, Evaluated, RESULT_SCHEMA, RolloutTable,
    RunProvenance, RunResult, SearchSummary, Status,
};
use super::resume::Checkpoint;
use super::searches::{OURS, Searches, run_all};
use super::space::{Space, toward_body};
use super::verdict::{comparisons, is_eligible, lead, verdict, worst_index};
use crate::files::InputError;
use crate::path::Family;
use crate::posture::Behaviour;
use crate::scenario::Scenario;
use crate::survey::Lens;
use crate::trajectory::TimedPath;
use rayon::prelude::*;
use thiserror::Error;

/// Blocks of people: fresh ones for the selection, and more for the report. The searches take theirs
/// from 16 on.
pub(super) const SELECTION_BLOCK: u32 = 1;
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
    /// A run that was interrupted, to go on with.
    pub resume: Option<Checkpoint>,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// What is being done.
    pub stage: &'static str,
    /// Items done.
    pub done: usize,
    /// Items in all.
    pub total: usize,
    /// The best objective so far, in a search.
    pub best: Option<f64>,
}

/// Told where a run stands; answers whether to go on.
pub type Stage<'a> = &'a (dyn Fn(Step) -> bool + Sync);

/// Why a run could not be made at all. A run whose paths are all infeasible is a result, not an error.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The input does not fit together.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The user interrupted; with what it takes to go on.
    #[error("interrupted; nothing was written")]
    Interrupted(Option<Box<Checkpoint>>),
}

/// What all stages of a run share.
pub(super) struct Environment<'a> {
    pub scenario: &'a Scenario,
    pub preset: &'a Preset,
    pub workshop: &'a Workshop<'a>,
    pub people: &'a [Person<'a>],
    pub lens: &'a Lens,
    /// The straight path, against which others are guarded; none where it is not feasible.
    pub straight: Option<Prepared>,
    pub seed: u64,
    pub stage: Stage<'a>,
}

/// Plans paths for a scenario and ranks them, the user's own and the baselines among them.
pub fn plan(scenario: &Scenario, request: &Request, stage: Stage) -> Result<RunResult, PlanError> {
    run(scenario, request, stage, Scope::Plan)
}

/// Plans with the person's true behaviour in the place of the posture model: what a planner that knew
/// everything would find, searching as long as one that does not.
pub fn plan_knowing(
    scenario: &Scenario,
    request: &Request,
    stage: Stage,
    truth: &dyn Behaviour,
) -> Result<RunResult, PlanError> {
    run(scenario, request, stage, Scope::Oracle(truth))
}

/// What paths cause in somebody whose behaviour is known: figures of `count` repetitions of each, the
/// same ones for all, for each body.
pub fn judge_truly(
    scenario: &Scenario,
    truth: &dyn Behaviour,
    paths: &[TimedPath],
    block: (u64, u32),
    count: usize,
) -> Result<Vec<Vec<Figures>>, InputError> {
    let people = Person::all(scenario, Some(truth))?;
    let (lens, nominal) = (lens(scenario), scenario.nominal());
    let of = |path: &TimedPath| {
        let walks = |p: &Person| Figures::of(&p.walk(path, &nominal, block, 0..count), &lens);
        people.iter().map(walks).collect()
    };
    Ok(paths.par_iter().map(of).collect())
}

/// What is asked of a run.
#[derive(Debug, Clone, Copy)]
enum Scope<'a> {
    /// Search and baselines.
    Plan,
    /// The same, knowing the person.
    Oracle(&'a dyn Behaviour),
    /// The user's own paths only.
    Assess,
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
    run(scenario, request, stage, Scope::Assess)
}

fn run(
    scenario: &Scenario,
    request: &Request,
    stage: Stage,
    scope: Scope,
) -> Result<RunResult, PlanError> {
    let Request { seed, preset, .. } = request;
    let truth = match scope {
        Scope::Oracle(truth) => Some(truth),
        Scope::Plan | Scope::Assess => None,
    };
    let people = Person::all(scenario, truth)?;
    let lens = lens(scenario);
    let workshop = Workshop::new(scenario, preset, *seed);
    let space = Space::new(scenario, preset);
    let straight = space.named().into_iter().find(|c| c.candidate.family == Family::Straight);
    let straight = straight.map(|c| workshop.candidate_thoroughly(&c.candidate, &c.variant));
    let environment = Environment {
        scenario,
        preset,
        workshop: &workshop,
        people: &people,
        lens: &lens,
        straight: straight.filter(Prepared::is_walkable),
        seed: *seed,
        stage,
    };
    let searches = match scope {
        Scope::Plan | Scope::Oracle(_) => run_all(&environment, &space, request)?,
        Scope::Assess => Searches::default(),
    };
    let pool = finalists(&environment, &space, &searches)?;
    let chosen = select(&environment, pool)?;
    let mut candidates = Vec::new();
    // The best path's walks of the body that scores worst: the one of the verdict.
    let mut best: Option<(Walks, &Finalist, &Person)> = None;
    let (mut rollouts, mut motions) = (Vec::new(), Vec::new());
    let walkable: Vec<&Finalist> = chosen.iter().filter(|f| f.value.is_some()).collect();
    let reported = counted(&environment, "reporting", (0, walkable.len(), None), &walkable, |f| {
        environment.report(&f.prepared, preset.rollouts_final)
    })?;
    // Too near among the fresh people of the report, though not among those of the selection.
    let mut too_near = Vec::new();
    let mut ranked = 0;
    let straight = reported.iter().find(|(c, _)| c.family == Family::Straight);
    let straight_path = straight.and_then(|(c, _)| c.path.clone());
    let straight: Vec<BodyScores> = straight.map(|(c, _)| c.bodies.clone()).unwrap_or_default();
    let is_assessment = matches!(scope, Scope::Assess);
    let leads = |c: &CandidateResult| {
        if is_assessment { c.family == Family::Drawn } else { is_eligible(c) }
    };
    for (finalist, (mut result, walks)) in walkable.into_iter().zip(reported) {
        result.objective = finalist.value;
        // On the selection's repetitions, and on the fresh ones of the report.
        result.bought.clone_from(&finalist.bought);
        let both = result.path.as_ref().zip(straight_path.as_ref());
        result.timing = both.and_then(|(a, b)| timing_difference(a, b));
        result.other_timing = match result.family {
            Family::Drawn => result.timing.is_some_and(|t| !t.is_same()),
            _ => !finalist.keeps_timing,
        };
        for price in reported_prices(&preset.objective, &result.bodies, &straight) {
            let is_known = |b: &Bought| (b.with, b.method) == (price.with, price.method);
            if !result.bought.iter().any(is_known) {
                result.bought.push(price);
            }
        }
        result.mark_if_too_near(finalist.prepared.is_users, &scenario.person_margin);
        if matches!(result.status, Status::Infeasible { .. }) {
            too_near.push(result);
            continue;
        }
        // What joins other ends is compared with nothing.
        let rank = ranked + 1;
        if result.ends.is_none() {
            ranked = rank;
            result.rank = Some(rank);
        }
        if request.keeps_rollouts && result.rank.is_some() {
            rollouts.extend(environment.tables(&finalist.prepared, &walks, rank));
        }
        motions.extend(environment.film(&finalist.prepared, &result, &walks));
        if best.is_none() && leads(&result) {
            let worst = worst_index(&result.bodies);
            best = worst.and_then(|i| Some((walks.into_iter().nth(i)?, finalist, people.get(i)?)));
        }
        candidates.push(result);
    }
    candidates.extend(too_near);
    candidates.extend(
        chosen.iter().filter(|f| f.value.is_none()).map(|f| bare(&f.prepared, Evaluated::None)),
    );
    let ids: Vec<String> = candidates.iter().map(|c| c.id.clone()).collect();
    candidates.extend(rest(&searches, &space, &ids));
    let shown =
        best.as_ref().map(|(walks, f, person)| moments(person, walks, &f.prepared.variant, &lens));
    let inputs = inputs(scenario, &lens, best.as_ref().map(|b| &b.0));
    let compared = comparisons(&candidates, lead(&candidates, is_assessment));
    let mut verdict = verdict(scenario, &candidates, &compared, &inputs, is_assessment);
    if verdict.outcome == Decision::NothingFeasible {
        let refused: Vec<&Prepared> = chosen.iter().map(|f| &f.prepared).collect();
        workshop.explain(&refused, &mut verdict);
        environment.explain_nearness(&refused, &space, &mut verdict);
        verdict.hints.extend(unreached_ends(scenario, &people));
    }
    Ok(RunResult {
        schema: RESULT_SCHEMA.into(),
        provenance: provenance(scenario, request, &lens),
        verdict,
        comparisons: compared,
        inputs,
        threshold_sensitivity: best.as_ref().map(|(w, ..)| w.sensitivity(&lens)),
        moments: shown.unwrap_or_default(),
        recommendations: best.as_ref().map(|(_, f, p)| environment.recommend(&f.prepared, p)),
        setting: setting(scenario),
        posture_model: model_summary(scenario),
        warnings: scenario.warnings.clone(),
        not_modelled: not_modelled(scenario),
        planner: preset.clone(),
        search: searches.summary(),
        scene: filming::scene(scenario, motions),
        rollouts,
        candidates,
    })
}

impl Searches {
    /// What was searched, for the record.
    fn summary(&self) -> Vec<SearchSummary> {
        let of = |(name, state): &(String, super::search::SearchState)| {
            let refused = state.tried.iter().filter(|t| t.refused.is_some()).count();
            SearchSummary { name: name.clone(), paths: state.tried.len(), infeasible: refused }
        };
        let (ours, others): (Vec<_>, Vec<_>) = self.done.iter().partition(|(n, _)| n == OURS);
        ours.into_iter().chain(others).map(of).collect()
    }
}

fn provenance(scenario: &Scenario, request: &Request, lens: &Lens) -> RunProvenance {
    RunProvenance {
        program_version: env!("CARGO_PKG_VERSION").into(),
        command: request.command.clone(),
        seed: request.seed,
        inputs: inputs_of(scenario),
        score_profile: lens.profile.name.to_owned(),
    }
}

/// (name, SHA-256) of every input of a run.
pub(super) fn inputs_of(scenario: &Scenario) -> Vec<(String, String)> {
    let mut inputs = vec![(scenario.file.clone(), scenario.sha256.clone())];
    inputs.push((scenario.worker.model.name.clone(), scenario.worker.model_sha256.clone()));
    inputs.extend(scenario.worker.bodies.iter().map(|b| (b.name.clone(), b.sha256())));
    inputs.extend(scenario.paths.iter().map(|p| (p.name.clone(), p.sha256.clone())));
    inputs
}

impl Environment<'_> {
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
        result.chosen = self.scenario.chosen(&prepared.variant);
        result.bend = prepared
            .path
            .as_ref()
            .and_then(|p| bend(&p.poses, &toward_body(self.scenario, &prepared.variant)));
        let mut all = Vec::new();
        if let Some(path) = &prepared.path {
            result.path = prepared.data(self.scenario);
            let robot_q = result.path.as_ref().map(|p| p.robot_q.clone()).unwrap_or_default();
            let robot = self.workshop.robot_of(&prepared.variant);
            let arm = prepared.arm(&robot, Care::Report);
            let at = (path, &prepared.variant);
            for person in self.people {
                let walks =
                    person.walk(path, &prepared.variant, (self.seed, REPORT_BLOCK), 0..count);
                let other_arm = self.scenario.worker.other_arm;
                let mut scores = walks.summary(&person.name, self.lens, other_arm);
                if let Some(scores) = &mut scores {
                    let figures = Figures::of(&walks, self.lens);
                    let time = self.terms(prepared).time_share;
                    scores.objective = figures.value(&self.preset.objective, time);
                }
                if let (Some(scores), Some(arm)) = (&mut scores, &arm) {
                    let closest = person.closest(&walks, &(0..count), (arm, &prepared.variant));
                    let body = (person.parts(), &path.time_s[..]);
                    let margin = &self.scenario.person_margin;
                    scores.person_clearance = arm.summary(&closest, body, margin);
                }
                result.bodies.extend(scores);
                result.poses.extend(person.pictures(
                    &walks,
                    at,
                    (&robot, &robot_q),
                    PICTURE_MOMENTS,
                ));
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
        chosen: Vec::new(),
        bend: None,
        timing: None,
        other_timing: false,
        bought: Vec::new(),
        objective: None,
        bodies: Vec::new(),
        path: None,
        poses: Vec::new(),
        ends: prepared.ends,
    }
}

/// Parallel map in order, with progress; ends early when the user interrupts.
pub(super) fn counted<T: Sync, R: Send>(
    environment: &Environment,
    stage: &'static str,
    (before, total, best): (usize, usize, Option<f64>),
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Result<Vec<R>, PlanError> {
    let done = std::sync::atomic::AtomicUsize::new(before);
    let go_on = |done: usize| {
        let step = Step { stage, done, total, best };
        (environment.stage)(step).then_some(()).ok_or(PlanError::Interrupted(None))
    };
    go_on(before)?;
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

//! The stages in order: search, baselines, selection, report.

use super::apart::explain_nearness;
use super::causes::unreached_ends;
use super::cell_look::cell_pictures;
use super::environment::{Environment, StraightKnown};
use super::explain::{inputs, model_summary, not_modelled, setting};
use super::filming;
use super::finalists::{finalists, rest, select};
use super::lens::lens;
use super::moments::moments;
use super::objective::Figures;
use super::person::{Person, modelled};
use super::prepare::{Prepared, Workshop};
use super::recommend::recommend;
use super::reporting::{refused, reported};
use super::request::{PlanError, Request, Stage, inputs_of};
use super::result::{Decision, RESULT_SCHEMA, RunProvenance, RunResult, SearchSummary};
use super::searches::{OURS, Searches, run_all};
use super::space::Space;
use super::verdict::{comparisons, lead, verdict};
use crate::files::InputError;
use crate::path::Family;
use crate::posture::Behaviour;
use crate::scenario::Scenario;
use crate::survey::Lens;
use crate::trajectory::TimedPath;
use rayon::prelude::*;

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
    let people = Person::all(scenario, truth)?;
    let (lens, nominal) = (lens(scenario), scenario.nominal());
    let of = |path: &TimedPath| {
        let which = (block, 0..count);
        let figures =
            |p: &Person| Figures::of(&p.scored(path, &nominal, which.clone(), &lens), &lens);
        people.iter().map(figures).collect()
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
    let modelled = modelled(scenario)?;
    let people = match scope {
        Scope::Oracle(truth) => Person::all(scenario, truth)?,
        Scope::Plan | Scope::Assess => Person::all(scenario, &modelled)?,
    };
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
        straight: straight.filter(Prepared::is_feasible),
        straight_known: StraightKnown::default(),
        seed: *seed,
        stage,
    };
    let searches = match scope {
        Scope::Plan | Scope::Oracle(_) => run_all(&environment, &space, request)?,
        Scope::Assess => Searches::default(),
    };
    let pool = finalists(&environment, &space, &searches)?;
    let chosen = select(&environment, pool)?;
    let is_assessment = matches!(scope, Scope::Assess);
    let report = reported(&environment, &chosen, (is_assessment, request.keeps_rollouts))?;
    let best = report.best.as_ref();
    let rejected: Vec<&Prepared> =
        chosen.iter().filter(|f| f.value.is_none()).map(|f| &f.prepared).collect();
    let mut candidates = report.candidates;
    candidates.extend(rejected.iter().map(|p| refused(&environment, p)));
    let ids: Vec<String> = candidates.iter().map(|c| c.id.clone()).collect();
    candidates.extend(rest(&searches, &space, &ids));
    let inputs = inputs(scenario, &lens, best.map(|b| &b.repetitions));
    let compared = comparisons(&candidates, lead(&candidates, is_assessment));
    let mut verdict = verdict(scenario, &candidates, &compared, &inputs, is_assessment);
    if verdict.outcome == Decision::NothingFeasible {
        let all: Vec<&Prepared> = chosen.iter().map(|f| &f.prepared).collect();
        workshop.explain(&all, &mut verdict);
        explain_nearness(&environment, &all, &space, &mut verdict);
        verdict.hints.extend(unreached_ends(scenario, &people));
    }
    let shown = best.map(|b| moments(b.person, &b.repetitions, &b.prepared.variant, &lens));
    Ok(RunResult {
        schema: RESULT_SCHEMA.into(),
        provenance: provenance(scenario, request, &lens),
        verdict,
        comparisons: compared,
        inputs,
        threshold_sensitivity: best.map(|b| b.repetitions.sensitivity(&lens)),
        moments: shown.unwrap_or_default(),
        recommendations: best.map(|b| recommend(&environment, b.prepared, b.person)),
        setting: setting(scenario),
        posture_model: model_summary(scenario),
        warnings: scenario.warnings.clone(),
        not_modelled: not_modelled(scenario),
        planner: preset.clone(),
        search: searches.summary(),
        scene: filming::scene(scenario, report.motions),
        ends: if best.is_some() { Vec::new() } else { cell_pictures(scenario, &people).into() },
        rollouts: report.rollouts,
        candidates,
    })
}

impl Searches {
    /// What was searched, for the record.
    fn summary(&self) -> Vec<SearchSummary> {
        let of = |(name, state): &(String, super::tried::SearchState)| {
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

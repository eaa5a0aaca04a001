//! The figures that are reported.

use super::along::{bend, timing_difference};
use super::checklist::checklist;
use super::environment::{Environment, counted};
use super::filming::film;
use super::finalists::Finalist;
use super::guard::reported_prices;
use super::near::Care;
use super::objective::Figures;
use super::person::Person;
use super::prepare::Prepared;
use super::preset::Objective;
use super::refusal::Status;
use super::repetitions::Repetitions;
use super::request::PlanError;
use super::result::{Bought, CandidateResult, Evaluated, RolloutTable};
use super::scene::SceneMotion;
use super::space::toward_body;
use super::verdict::{is_eligible, worst_index};
use crate::path::Family;

/// Block of repetitions of the report: others than those that chose.
const REPORT_BLOCK: u32 = 2;

/// Moments at which postures are drawn.
const PICTURE_MOMENTS: usize = 7;

/// What is reported of the paths that were chosen.
pub(super) struct Reported<'a> {
    /// Ranked, then those that are not.
    pub candidates: Vec<CandidateResult>,
    /// The leading path with the body of the verdict.
    pub best: Option<Best<'a>>,
    /// The sampled postures, where they are kept.
    pub rollouts: Vec<RolloutTable>,
    pub motions: Vec<SceneMotion>,
}

/// The leading path, and the repetitions of the body that scores worst on it.
pub(super) struct Best<'a> {
    pub prepared: &'a Prepared,
    pub person: &'a Person<'a>,
    pub repetitions: Repetitions,
}

/// Scores the chosen paths on fresh repetitions, in their order; those that cannot be simulated are
/// left out.
pub(super) fn reported<'a>(
    environment: &Environment<'a>,
    chosen: &'a [Finalist],
    (is_assessment, keeps_rollouts): (bool, bool),
) -> Result<Reported<'a>, PlanError> {
    let preset = environment.preset;
    let feasible: Vec<&Finalist> = chosen.iter().filter(|f| f.value.is_some()).collect();
    let all = counted(environment, "reporting", (0, feasible.len(), None), &feasible, |f| {
        report(environment, &f.prepared, preset.rollouts_final)
    })?;
    let straight = all.iter().find(|(c, _)| c.family == Family::Straight);
    let straight = straight.map(|(c, _)| c.clone());
    let leads = |c: &CandidateResult| {
        if is_assessment { c.family == Family::Drawn } else { is_eligible(c) }
    };
    let (mut candidates, mut best) = (Vec::new(), None);
    let (mut rollouts, mut motions) = (Vec::new(), Vec::new());
    // Too near among the fresh repetitions of the report, though not among those of the selection.
    let mut too_near = Vec::new();
    let mut ranked = 0;
    for (finalist, (mut result, repetitions)) in feasible.into_iter().zip(all) {
        result.objective = finalist.value;
        price(&mut result, finalist, straight.as_ref(), &preset.objective);
        let margin = &environment.scenario.person_margin;
        result.mark_if_too_near(finalist.prepared.is_users, margin);
        result.checklist = checklist(environment.scenario, &finalist.prepared, &result);
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
        if keeps_rollouts && result.rank.is_some() {
            rollouts.extend(tables(environment, &finalist.prepared, &repetitions, rank));
        }
        motions.extend(film(environment, &finalist.prepared, &result, &repetitions));
        if best.is_none() && leads(&result) {
            let worst = worst_index(&result.bodies);
            best = worst.and_then(|i| {
                let person = environment.people.get(i)?;
                let repetitions = repetitions.into_iter().nth(i)?;
                Some(Best { prepared: &finalist.prepared, person, repetitions })
            });
        }
        candidates.push(result);
    }
    candidates.extend(too_near);
    Ok(Reported { candidates, best, rollouts, motions })
}

/// What a path's figures were bought with: on the selection's repetitions, and on those of the report.
fn price(
    result: &mut CandidateResult,
    finalist: &Finalist,
    straight: Option<&CandidateResult>,
    objective: &Objective,
) {
    result.bought.clone_from(&finalist.bought);
    let both = result.path.as_ref().zip(straight.and_then(|s| s.path.as_ref()));
    result.timing = both.and_then(|(a, b)| timing_difference(a, b));
    result.other_timing = match result.family {
        Family::Drawn => result.timing.is_some_and(|t| !t.is_same()),
        _ => !finalist.keeps_timing,
    };
    let bodies = straight.map_or(&[][..], |s| &s.bodies);
    for price in reported_prices(objective, &result.bodies, bodies) {
        let is_known = |b: &Bought| (b.with, b.method) == (price.with, price.method);
        if !result.bought.iter().any(is_known) {
            result.bought.push(price);
        }
    }
}

/// The sampled postures of all bodies along a path.
fn tables(
    environment: &Environment,
    prepared: &Prepared,
    repetitions: &[Repetitions],
    rank: usize,
) -> Vec<RolloutTable> {
    let Some(path) = &prepared.path else { return Vec::new() };
    let of = |(k, (person, repetitions)): (usize, (&Person, &Repetitions))| {
        person.table(repetitions, path, rank, k == 0)
    };
    environment.people.iter().zip(repetitions).enumerate().map(of).collect()
}

fn report(
    environment: &Environment,
    prepared: &Prepared,
    count: usize,
) -> (CandidateResult, Vec<Repetitions>) {
    let mut result = bare(prepared, Evaluated::Reported);
    result.chosen = environment.scenario.chosen(&prepared.variant);
    result.bend = prepared
        .path
        .as_ref()
        .and_then(|p| bend(&p.poses, &toward_body(environment.scenario, &prepared.variant)));
    let mut all = Vec::new();
    if let Some(path) = &prepared.path {
        result.path = prepared.data(environment.scenario);
        let robot_q = result.path.as_ref().map(|p| p.robot_q.clone()).unwrap_or_default();
        let robot = environment.workshop.robot_of(&prepared.variant);
        let arm = prepared.arm(&robot, Care::Report);
        let at = (path, &prepared.variant);
        for person in environment.people {
            let repetitions =
                person.repeat(path, &prepared.variant, (environment.seed, REPORT_BLOCK), 0..count);
            let other_arm = environment.scenario.worker.other_arm;
            let mut scores = repetitions.summary(person, environment.lens, other_arm);
            if let Some(scores) = &mut scores {
                let figures = Figures::of(&repetitions, environment.lens);
                let time = environment.terms(prepared).time_share;
                scores.objective = figures.value(&environment.preset.objective, time);
                scores.strain =
                    repetitions.strain(environment.scenario, environment.lens, at, person);
            }
            if let (Some(scores), Some(arm)) = (&mut scores, &arm) {
                let closest = person.closest(&repetitions, &(0..count), (arm, &prepared.variant));
                let body = (person.parts(), &path.time_s[..]);
                let margin = &environment.scenario.person_margin;
                scores.person_clearance = arm.summary(&closest, body, margin);
            }
            result.bodies.extend(scores);
            result.poses.extend(person.pictures(
                &repetitions,
                at,
                (&robot, &robot_q),
                PICTURE_MOMENTS,
            ));
            all.push(repetitions);
        }
    }
    (result, all)
}

/// A refused path of the selection, with what it was checked for.
pub(super) fn refused(environment: &Environment, prepared: &Prepared) -> CandidateResult {
    let mut result = bare(prepared, Evaluated::None);
    result.checklist = checklist(environment.scenario, prepared, &result);
    result
}

/// A path without scores.
pub(super) fn bare(prepared: &Prepared, evaluated: Evaluated) -> CandidateResult {
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
        checklist: Vec::new(),
        path: None,
        poses: Vec::new(),
        ends: prepared.ends,
    }
}

//! From the searches to the paths that are reported: ours, the baselines and the user's own.

use super::environment::{Environment, SELECTION_BLOCK, counted};
use super::guard::{keeps_timing, prices};
use super::near::Care;
use super::objective::{Figures, objective};
use super::prepare::Prepared;
use super::refusal::Status;
use super::request::PlanError;
use super::result::{Bought, CandidateResult, Evaluated};
use super::searches::{LEARNED, OURS, PLAIN, RANDOM, RETIMED, Searches};
use super::space::{Space, WITHOUT, held};
use super::tried::{SearchState, Tried};
use crate::path::{Candidate, Family};
use rayon::prelude::*;

/// Distance (white units) within which two points are the same path.
const SAME_PATH: f64 = 0.05;
/// Paths of a baseline's search that are looked at.
const STAND_INS: usize = 12;
/// People in the first round of the selection; each round has twice as many for half the paths.
const FIRST_ROUND: usize = 32;

/// A path that stands for selection.
#[derive(Debug, Clone)]
pub(super) struct Finalist {
    pub prepared: Prepared,
    /// Not one of ours: reported whatever its figures are.
    pub is_kept: bool,
    /// The objective on the selection's repetitions; none when it cannot be simulated.
    pub value: Option<f64>,
    /// In which figures it is clearly worse than the straight path on these repetitions.
    pub bought: Vec<Bought>,
    /// Whether its timing allows it to be the best.
    pub keeps_timing: bool,
}

impl Finalist {
    /// Not judged yet.
    fn new(prepared: Prepared, is_kept: bool) -> Self {
        Self { prepared, is_kept, value: None, bought: Vec::new(), keeps_timing: true }
    }
}

/// The pool: the best of our search, every baseline, the user's own paths.
pub(super) fn finalists(
    environment: &Environment,
    space: &Space,
    searches: &Searches,
) -> Result<Vec<Finalist>, PlanError> {
    let preset = environment.preset;
    let workshop = environment.workshop;
    let kept = |mut prepared: Prepared, id: &str, family: Family| {
        (prepared.id, prepared.family) = (id.to_owned(), family);
        Finalist::new(prepared, true)
    };
    let mut pool = Vec::new();
    if let Some(state) = searches.of(OURS) {
        pool.extend(ours(environment, space, state, preset.shortlist)?);
    }
    for choice in space.named() {
        let is_ours = matches!(choice.candidate.family, Family::Straight | Family::ExpertArc);
        if is_ours && (choice.candidate.family == Family::Straight || !searches.done.is_empty()) {
            let prepared = workshop.candidate_thoroughly(&choice.candidate, &choice.variant);
            pool.push(Finalist::new(prepared, true));
        }
    }
    for (name, id, family) in [
        (RANDOM, "best_random", Family::BestRandom),
        (PLAIN, "single_posture_plain", Family::SinglePosturePlain),
        (LEARNED, "single_posture_learned", Family::SinglePostureLearned),
    ] {
        let best = searches.of(name).and_then(|state| stand_in(environment, space, state));
        pool.extend(best.map(|p| kept(p, id, family)));
    }
    if let (Some(narrow), Some(state)) = (space.retimed(), searches.of(RETIMED))
        && let Some(best) = best_of(environment, &narrow, state)?
    {
        pool.push(kept(best, "straight_retimed", Family::StraightRetimed));
    }
    for name in held(&environment.scenario.free) {
        let id = format!("{WITHOUT}{name}");
        let narrow = space.narrowed(Some(name));
        if let Some(state) = searches.of(&id)
            && let Some(best) = best_of(environment, &narrow, state)?
        {
            pool.push(kept(best, &id, Family::Held));
        }
    }
    pool.extend(shortest(environment, space, searches, &pool));
    let drawn = environment.scenario.drawn.iter();
    let nominal = environment.scenario.nominal();
    pool.extend(drawn.map(|d| {
        let candidate = Candidate { dwell_s: nominal.dwell_s, ..d.clone() };
        Finalist::new(workshop.candidate_thoroughly(&candidate, &nominal), true)
    }));
    let users = environment.scenario.paths.iter();
    pool.extend(users.map(|p| Finalist::new(workshop.users(p), true)));
    Ok(pool)
}

/// What a baseline's search found: its best path from which the robot keeps its distance to the worker, or
/// its best one if it found none such. A plan with a single posture cannot see how others come near.
fn stand_in(environment: &Environment, space: &Space, state: &SearchState) -> Option<Prepared> {
    let mut best = None;
    for tried in state.best(STAND_INS, environment.preset.rollouts_most, SAME_PATH) {
        let Some(mut prepared) = decoded(environment, space, tried) else { continue };
        if prepared.is_feasible() {
            let repetitions = 0..FIRST_ROUND.min(environment.preset.rollouts_final);
            let block = (environment.seed, SELECTION_BLOCK);
            let figures = environment.figures(&prepared, block, repetitions, Care::Selection);
            let (names, margin) =
                (environment.scenario.body_names(), &environment.scenario.person_margin);
            prepared.refuse_if_too_near(&names, &figures, (margin, true));
            if prepared.is_feasible() {
                return Some(prepared);
            }
        }
        best.get_or_insert(prepared);
    }
    best
}

/// The best path of a search on the selection's repetitions.
fn best_of(
    environment: &Environment,
    space: &Space,
    state: &SearchState,
) -> Result<Option<Prepared>, PlanError> {
    let pool = ours(environment, space, state, environment.preset.shortlist)?;
    let best = select(environment, pool)?.into_iter().find(|f| f.value.is_some());
    Ok(best.map(|f| f.prepared))
}

/// The best points of a search and its last centre.
fn ours(
    environment: &Environment,
    space: &Space,
    state: &SearchState,
    count: usize,
) -> Result<Vec<Finalist>, PlanError> {
    let centre = Tried::at("centre", state.centre());
    let best = state.best(count.saturating_sub(1), environment.preset.rollouts_most / 2, SAME_PATH);
    let points: Vec<&Tried> = best.into_iter().chain([&centre]).collect();
    let total = points.len();
    let prepared = counted(environment, "preparing", (0, total, None), &points, |t| {
        decoded(environment, space, t)
    })?;
    let feasible = prepared.into_iter().flatten().filter(Prepared::is_feasible);
    Ok(feasible.map(|prepared| Finalist::new(prepared, false)).collect())
}

fn decoded(environment: &Environment, space: &Space, tried: &Tried) -> Option<Prepared> {
    let choice = space.decode(&tried.id, &tried.x)?;
    Some(environment.workshop.candidate_thoroughly(&choice.candidate, &choice.variant))
}

/// The shortest feasible path of all searches, where the straight one is not feasible.
fn shortest(
    environment: &Environment,
    space: &Space,
    searches: &Searches,
    pool: &[Finalist],
) -> Option<Finalist> {
    let is_straight = |f: &&Finalist| f.prepared.family == Family::Straight;
    if pool.iter().find(is_straight).is_none_or(|f| f.prepared.is_feasible()) {
        return None;
    }
    let with_all_freedoms = |n: &str| !n.starts_with(WITHOUT);
    let tried = searches.done.iter().filter(|(n, _)| with_all_freedoms(n)).flat_map(|s| &s.1.tried);
    let found =
        tried.filter(|t| t.repetitions > 0).min_by(|a, b| a.length_m.total_cmp(&b.length_m))?;
    let mut prepared = decoded(environment, space, found)?;
    (prepared.id, prepared.family) = ("shortest".to_owned(), Family::Shortest);
    Some(Finalist::new(prepared, true))
}

/// Successive halving of our own on fresh repetitions, with all that is kept beside them. Best first; what
/// nobody can be sent along comes last, without a value.
pub(super) fn select(
    environment: &Environment,
    mut pool: Vec<Finalist>,
) -> Result<Vec<Finalist>, PlanError> {
    let preset = environment.preset;
    let mut figures: Vec<Vec<Figures>> =
        vec![vec![Figures::default(); environment.people.len()]; pool.len()];
    let mut ours: Vec<usize> = (0..pool.len()).filter(|&i| !pool[i].is_kept).collect();
    let kept: Vec<usize> = (0..pool.len()).filter(|&i| pool[i].is_kept).collect();
    let (mut known, mut wanted) = (0, FIRST_ROUND.min(preset.rollouts_final));
    loop {
        measure(environment, &mut pool, &mut figures, &ours, known..wanted)?;
        ours.sort_by(|&a, &b| by_worth(&pool[a], &pool[b]).then(a.cmp(&b)));
        if wanted >= preset.rollouts_final {
            break;
        }
        ours.truncate((ours.len() / 2).max(preset.reported));
        (known, wanted) = (wanted, (2 * wanted).min(preset.rollouts_final));
    }
    ours.truncate(preset.reported);
    measure(environment, &mut pool, &mut figures, &kept, 0..preset.rollouts_final)?;
    let mut order: Vec<usize> = ours.into_iter().chain(kept).collect();
    order.sort_by(|&a, &b| by_value(&pool[a], &pool[b]).then(a.cmp(&b)));
    Ok(order.into_iter().map(|i| pool[i].clone()).collect())
}

/// By the objective; paths that begin or end elsewhere come after those that they cannot be compared
/// with.
fn by_value(a: &Finalist, b: &Finalist) -> std::cmp::Ordering {
    let of = |f: &Finalist| f.value.unwrap_or(f64::INFINITY);
    let is_elsewhere = |f: &Finalist| f.prepared.ends.is_some();
    is_elsewhere(a).cmp(&is_elsewhere(b)).then(of(a).total_cmp(&of(b)))
}

/// The same, those that cannot be the best last.
fn by_worth(a: &Finalist, b: &Finalist) -> std::cmp::Ordering {
    let is_worthy = |f: &Finalist| f.bought.is_empty() && f.keeps_timing;
    is_worthy(a).cmp(&is_worthy(b)).reverse().then(by_value(a, b))
}

/// Simulates some of the pool and sets their values.
fn measure(
    environment: &Environment,
    pool: &mut [Finalist],
    figures: &mut [Vec<Figures>],
    which: &[usize],
    repetitions: std::ops::Range<usize>,
) -> Result<(), PlanError> {
    let feasible: Vec<usize> =
        which.iter().copied().filter(|&i| pool[i].prepared.is_feasible()).collect();
    let block = (environment.seed, SELECTION_BLOCK);
    let total = feasible.len();
    let straight = environment.straight_figures(block, repetitions.end);
    let found = counted(environment, "selecting", (0, total, None), &feasible, |&i| {
        environment.figures(&pool[i].prepared, block, repetitions.clone(), Care::Selection)
    })?;
    for (&i, more) in feasible.iter().zip(found) {
        figures[i].iter_mut().zip(more).for_each(|(f, m)| f.extend(m));
        pool[i].prepared.refuse_if_nobody_reaches(&environment.scenario.body_names(), &figures[i]);
        let is_all = repetitions.end >= environment.preset.rollouts_final;
        pool[i].prepared.refuse_if_too_near(
            &environment.scenario.body_names(),
            &figures[i],
            (&environment.scenario.person_margin, is_all),
        );
        let is_usable = pool[i].prepared.is_feasible();
        let terms = environment.terms(&pool[i].prepared);
        let value = objective(&environment.preset.objective, &figures[i], terms);
        pool[i].value = is_usable.then_some(value);
        pool[i].keeps_timing = keeps_timing(environment, &pool[i].prepared);
        pool[i].bought = prices(&environment.preset.objective, &figures[i], &straight);
    }
    Ok(())
}

/// All that our search tried and that is not reported, in its order of value.
pub(super) fn rest(searches: &Searches, space: &Space, ids: &[String]) -> Vec<CandidateResult> {
    let Some(state) = searches.of(OURS) else { return Vec::new() };
    let mut tried: Vec<&Tried> = state.tried.iter().filter(|t| !ids.contains(&t.id)).collect();
    tried.sort_by(|a, b| a.value.total_cmp(&b.value).then(a.id.cmp(&b.id)));
    let result = |t: &&Tried| {
        let choice = space.decode(&t.id, &t.x);
        let chosen = choice.as_ref().map(|c| space.chosen(&c.variant)).unwrap_or_default();
        let vias = choice.map(|c| c.candidate.vias).unwrap_or_default();
        let (status, evaluated) = match &t.refused {
            None => (Status::Feasible, Evaluated::Search),
            Some(refusal) => (Status::Infeasible { refusal: refusal.clone() }, Evaluated::None),
        };
        CandidateResult {
            rank: None,
            id: t.id.clone(),
            family: Family::Sampled,
            status,
            changes: t.changes.clone(),
            evaluated,
            vias_m: vias.into_iter().map(Into::into).collect(),
            chosen,
            bend: None,
            timing: None,
            other_timing: false,
            bought: Vec::new(),
            objective: (t.repetitions > 0).then_some(t.value),
            bodies: Vec::new(),
            checklist: Vec::new(),
            path: None,
            poses: Vec::new(),
            ends: None,
        }
    };
    tried.par_iter().map(result).collect()
}

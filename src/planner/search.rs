//! The search: CMA-ES over white decision numbers, each generation judged together.
//!
//! ```text
//! ask      population points x        (generation 0 holds the named families and what is known)
//! prepare  QP, robot, obstacles                      (what is not feasible ranks last, by how far)
//! halve    all on `first` repetitions, the better half on twice as many, ... , at least two on `most`
//! tell     the order: those that came farther first
//! ```
//! All of a generation meet the same repetitions, every generation others: the search can neither be lucky
//! with one draw nor learn one block by heart. Only the order enters, so that figures on few and on
//! many repetitions need not be compared.

use super::environment::{Environment, counted, near};
use super::guard::{penalty, timing_penalty};
use super::near::Care;
use super::objective::{Figures, PathTerms, objective};
use super::person::Person;
use super::prepare::Prepared;
use super::refusal::{RefusedBy, Status};
use super::request::PlanError;

use super::space::Space;
use super::tried::{INFEASIBLE, SearchState, Tried};
use crate::math::cma::Cma;
use crate::math::stream::{Purpose, stream};
use crate::posture::PostureLaw;
use rayon::prelude::*;

/// First standard deviation of the white numbers, and the largest.
const SPREAD: f64 = 0.7;
const WIDEST: f64 = 1.0;
/// Who judges a path.
#[derive(Debug, Clone, Copy)]
pub(super) enum Gauge<'a> {
    /// People drawn from the model: few for all, up to `most` for the best.
    Repetitions { first: usize, most: usize },
    /// One repetition without chance, under the model's law or another one.
    Sure(&'a PostureLaw),
}

/// What one search is asked to do.
#[derive(Debug, Clone)]
pub(super) struct Task<'a> {
    /// Name for progress and identifiers.
    pub name: &'static str,
    /// Prefix of the identifiers of its points.
    pub prefix: String,
    pub space: Space<'a>,
    pub gauge: Gauge<'a>,
    pub population: usize,
    pub generations: usize,
    /// Fresh starts within the generations.
    pub runs: usize,
    /// False: points are drawn at random and nothing is learned.
    pub is_adaptive: bool,
    /// First block of repetitions; each generation takes the next.
    pub block: u32,
    /// Points of the first generation besides the named families, the best first.
    pub starts: Vec<Vec<f64>>,
}

/// Runs a search to its end, from where it stands.
pub(super) fn search(
    environment: &Environment,
    task: &Task,
    state: &mut Option<SearchState>,
) -> Result<(), PlanError> {
    let n = task.space.dimension();
    let fresh = |mean: Vec<f64>| {
        let spread = if task.is_adaptive { SPREAD } else { 1.0 };
        Cma::new(mean, spread, task.population).map(|cma| cma.not_wider_than(WIDEST))
    };
    if state.is_none() {
        let Some(cma) = fresh(vec![0.0; n]) else { return Ok(()) };
        *state = Some(SearchState { cma, generation: 0, tried: Vec::new() });
    }
    let Some(state) = state else { return Ok(()) };
    let per_run = task.generations.div_ceil(task.runs.max(1)).max(1);
    while state.generation < task.generations {
        let g = state.generation;
        if task.is_adaptive && g > 0 && g % per_run == 0 {
            // Another basin: from the next of the named families.
            let seeds = task.space.seeds();
            let from = seeds.get((g / per_run) % seeds.len().max(1)).cloned();
            if let Some(cma) = fresh(from.unwrap_or_else(|| vec![0.0; n])) {
                state.cma = cma;
            }
        }
        let ordered = generation(environment, task, state)?;
        if task.is_adaptive {
            state.cma.tell(&ordered);
        }
        state.generation += 1;
    }
    Ok(())
}

/// One generation; its points, best first.
fn generation(
    environment: &Environment,
    task: &Task,
    state: &mut SearchState,
) -> Result<Vec<Vec<f64>>, PlanError> {
    let g = state.generation;
    let mut rng = stream(environment.seed, Purpose::Search, task.block, g as u32);
    let mut points = state.cma.ask(&mut rng);
    if g == 0 && task.is_adaptive {
        let known = task.space.seeds().into_iter().chain(task.starts.iter().cloned());
        for (point, known) in points.iter_mut().zip(known) {
            *point = known;
        }
    }
    let best = state.tried.iter().map(|t| t.value).filter(|v| *v < INFEASIBLE);
    let best = best.min_by(f64::total_cmp);
    let done = g * task.population;
    let total = task.generations * task.population;
    let named: Vec<(String, &Vec<f64>)> = points
        .iter()
        .enumerate()
        .map(|(i, x)| (format!("{}{:03}", task.prefix, done + i), x))
        .collect();
    let mut prepared = counted(environment, task.name, (done, total, best), &named, |(id, x)| {
        task.space.decode(id, x).map(|c| environment.workshop.candidate(&c.candidate, &c.variant))
    })?;
    if needs_care(&prepared, state) {
        prepared = counted(environment, task.name, (done, total, best), &named, |(id, x)| {
            let choice = task.space.decode(id, x)?;
            let workshop = environment.workshop;
            Some(workshop.candidate_thoroughly(&choice.candidate, &choice.variant))
        })?;
    }
    let judged = judge(environment, task, g as u32, &prepared);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        judged[b].1.cmp(&judged[a].1).then(judged[a].0.total_cmp(&judged[b].0)).then(a.cmp(&b))
    });
    for (((id, x), (value, repetitions)), p) in named.iter().zip(&judged).zip(prepared) {
        let mut tried =
            Tried { value: *value, repetitions: *repetitions, ..Tried::at(id, (*x).clone()) };
        if let Some(p) = p {
            tried.length_m = p.length_m().unwrap_or(f64::MAX);
            if let Status::Infeasible { refusal } = p.status {
                (tried.refused, tried.changes) = (Some(refusal), p.changes);
            }
        }
        state.tried.push(tried);
    }
    Ok(order.into_iter().map(|i| points[i].clone()).collect())
}

/// Whether a generation of which the arm can follow nothing is worth the global choice of its motion:
/// the first one, and later ones if that has ever led to something.
fn needs_care(prepared: &[Option<Prepared>], state: &SearchState) -> bool {
    let is_the_arm = |p: &Prepared| p.status.refused_by() == Some(RefusedBy::Robot);
    let all = || prepared.iter().flatten();
    let is_stuck = !all().any(Prepared::is_feasible) && all().any(is_the_arm);
    is_stuck && (state.generation == 0 || state.tried.iter().any(|t| t.repetitions > 0))
}

/// Value of each point and the number of repetitions behind it.
fn judge(
    environment: &Environment,
    task: &Task,
    g: u32,
    prepared: &[Option<Prepared>],
) -> Vec<(f64, usize)> {
    let mut judged: Vec<(f64, usize)> = prepared.iter().map(|p| (refusal(p.as_ref()), 0)).collect();
    let feasible = |i: &usize| prepared[*i].as_ref().is_some_and(Prepared::is_feasible);
    let mut alive: Vec<usize> = (0..prepared.len()).filter(feasible).collect();
    let at = |i: usize| prepared[i].as_ref();
    match task.gauge {
        Gauge::Sure(law) => {
            let values: Vec<f64> = alive
                .par_iter()
                .map(|&i| {
                    at(i).map_or(INFEASIBLE, |p| {
                        surely(environment, p, law) + timing_penalty(environment, p)
                    })
                })
                .collect();
            for (i, value) in alive.into_iter().zip(values) {
                judged[i] = (value, 1);
            }
        }
        Gauge::Repetitions { first, most } => {
            let mut figures: Vec<Vec<Figures>> =
                vec![vec![Figures::default(); environment.people.len()]; prepared.len()];
            let mut known = 0;
            let mut wanted = first.min(most).max(1);
            let block = task.block + g;
            let straight = environment.straight_figures((environment.seed, block), most);
            while !alive.is_empty() {
                let more: Vec<Vec<Figures>> = alive
                    .par_iter()
                    .map(|&i| {
                        at(i).map_or_else(Vec::new, |p| {
                            let block = (environment.seed, block);
                            environment.figures(p, block, known..wanted, Care::Search)
                        })
                    })
                    .collect();
                for (&i, more) in alive.iter().zip(more) {
                    figures[i].iter_mut().zip(more).for_each(|(f, m)| f.extend(m));
                    let nothing = PathTerms { time_share: None, clearance_m: None, person: None };
                    let terms = at(i).map_or(nothing, |p| environment.terms_in_search(p));
                    let o = &environment.preset.objective;
                    let value = objective(o, &figures[i], terms)
                        + penalty(o, &figures[i], &straight)
                        + at(i).map_or(0.0, |p| timing_penalty(environment, p));
                    judged[i] = (value, wanted);
                }
                if wanted >= most || alive.len() <= 1 {
                    break;
                }
                alive.sort_by(|&a, &b| judged[a].0.total_cmp(&judged[b].0).then(a.cmp(&b)));
                alive.truncate((alive.len() / 2).max(2));
                alive.sort_unstable();
                (known, wanted) = (wanted, (2 * wanted).min(most));
            }
        }
    }
    judged
}

/// Where an infeasible point ranks among its like: by how far it is from being feasible.
fn refusal(prepared: Option<&Prepared>) -> f64 {
    INFEASIBLE * (1.0 + prepared.map_or(10.0, |p| p.severity))
}

/// The objective of one repetition without chance.
fn surely(environment: &Environment, p: &Prepared, law: &PostureLaw) -> f64 {
    let Some(path) = &p.path else { return INFEASIBLE };
    let robot = environment.workshop.robot_of(&p.variant);
    let arm = p.arm(&robot, Care::Search);
    let of = |person: &Person| {
        let repetitions = person.scored_surely(path, &p.variant, law, environment.lens);
        let (near_m, _) = near(person, &repetitions, &(0..1), (arm.as_ref(), p));
        Figures { near_m, ..Figures::of(&repetitions, environment.lens) }
    };
    let figures: Vec<Figures> = environment.people.iter().map(of).collect();
    objective(&environment.preset.objective, &figures, environment.terms_in_search(p))
}

//! The search: CMA-ES over white decision numbers, each generation judged together.
//!
//! ```text
//! ask      population points x        (generation 0 holds the named families and what is known)
//! prepare  QP, robot, obstacles                      (what is not feasible ranks last, by how far)
//! halve    all on `first` people, the better half on twice as many, ... , at least two on `most`
//! tell     the order: those that came farther first
//! ```
//! All of a generation meet the same people, every generation others: the search can neither be lucky
//! with one draw nor learn one block by heart. Only the order enters, so that figures on few and on
//! many people need not be compared.

use super::evaluate::{Person, Walks};
use super::guard::penalty;
use super::near::{ArmAlong, Care};
use super::objective::{Figures, PathTerms, objective};
use super::pipeline::{Environment, PlanError, counted};
use super::prepare::Prepared;
use super::refusal::{Refusal, RefusedBy};
use super::result::Status;
use super::space::Space;
use crate::math::cma::Cma;
use crate::math::stream::{Purpose, stream};
use crate::path::Change;
use crate::posture::PostureLaw;
use crate::scenario::Freedom;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// First standard deviation of the white numbers, and the largest.
const SPREAD: f64 = 0.7;
const WIDEST: f64 = 1.0;
/// Value from which infeasible points are counted; no objective of feasible ones comes near it.
const INFEASIBLE: f64 = 1e9;

/// Who judges a path.
#[derive(Debug, Clone, Copy)]
pub(super) enum Gauge<'a> {
    /// People drawn from the model: few for all, up to `most` for the best.
    People { first: usize, most: usize },
    /// One walk without chance, under the model's law or another one.
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
    /// First block of people; each generation takes the next.
    pub block: u32,
    /// Points of the first generation besides the named families, the best first.
    pub starts: Vec<Vec<f64>>,
}

/// A point that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// Its name.
    pub id: String,
    /// Search variables.
    pub x: Vec<f64>,
    /// The objective in the search; of an infeasible point a large number.
    pub value: f64,
    /// People behind the value; 0 for an infeasible point.
    pub people: usize,
    /// Length of the way, m; of an infeasible point maybe infinite.
    pub length_m: f64,
    /// Why it was refused.
    pub refused: Option<Refusal>,
    /// What would make it feasible, each alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
}

impl Tried {
    /// A point that nobody has judged yet.
    pub(super) fn at(id: &str, x: Vec<f64>) -> Self {
        let (id, value) = (id.to_owned(), INFEASIBLE);
        let (refused, changes) = (None, Vec::new());
        Self { id, x, value, people: 0, length_m: f64::MAX, refused, changes }
    }
}

/// A search that can go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchState {
    cma: Cma,
    /// Generations done.
    generation: usize,
    /// All points, in order.
    pub tried: Vec<Tried>,
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
    for (((id, x), (value, people)), p) in named.iter().zip(&judged).zip(prepared) {
        let mut tried = Tried { value: *value, people: *people, ..Tried::at(id, (*x).clone()) };
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
    let is_stuck = !all().any(Prepared::is_walkable) && all().any(is_the_arm);
    is_stuck && (state.generation == 0 || state.tried.iter().any(|t| t.people > 0))
}

/// Value of each point and the number of people behind it.
fn judge(
    environment: &Environment,
    task: &Task,
    g: u32,
    prepared: &[Option<Prepared>],
) -> Vec<(f64, usize)> {
    let mut judged: Vec<(f64, usize)> = prepared.iter().map(|p| (refusal(p.as_ref()), 0)).collect();
    let walkable = |i: &usize| prepared[*i].as_ref().is_some_and(Prepared::is_walkable);
    let mut alive: Vec<usize> = (0..prepared.len()).filter(walkable).collect();
    let at = |i: usize| prepared[i].as_ref();
    match task.gauge {
        Gauge::Sure(law) => {
            let values: Vec<f64> = alive
                .par_iter()
                .map(|&i| {
                    at(i).map_or(INFEASIBLE, |p| {
                        environment.surely(p, law) + environment.timing_penalty(p)
                    })
                })
                .collect();
            for (i, value) in alive.into_iter().zip(values) {
                judged[i] = (value, 1);
            }
        }
        Gauge::People { first, most } => {
            let mut figures: Vec<Vec<Figures>> =
                vec![vec![Figures::default(); environment.people.len()]; prepared.len()];
            let mut known = 0;
            let mut wanted = first.min(most).max(1);
            let block = task.block + g;
            while !alive.is_empty() {
                let straight = environment.straight.as_ref().map(|s| {
                    environment.figures(s, (environment.seed, block), 0..wanted, Care::Blind)
                });
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
                    let straight = straight.as_deref().unwrap_or_default();
                    let value = objective(o, &figures[i], terms)
                        + penalty(o, &figures[i], straight)
                        + at(i).map_or(0.0, |p| environment.timing_penalty(p));
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

impl SearchState {
    /// The centre of the last generation, as a point.
    pub(super) fn centre(&self) -> Vec<f64> {
        self.cma.mean().to_vec()
    }

    /// The best distinct points, at most `count`, each farther than `apart` (white units) from those
    /// before it. Points on at least `people` people come first.
    pub(super) fn best(&self, count: usize, people: usize, apart: f64) -> Vec<&Tried> {
        let mut order: Vec<&Tried> = self.tried.iter().filter(|t| t.people > 0).collect();
        order.sort_by(|a, b| {
            (b.people >= people)
                .cmp(&(a.people >= people))
                .then(a.value.total_cmp(&b.value))
                .then(a.id.cmp(&b.id))
        });
        let mut kept: Vec<&Tried> = Vec::new();
        for point in order {
            let is_new = |k: &&&Tried| distance(&k.x, &point.x) < apart;
            if kept.len() < count && !kept.iter().any(|k| is_new(&k)) {
                kept.push(point);
            }
        }
        kept
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

impl Environment<'_> {
    /// Figures of people `range` of a block along a path, for each body.
    pub(super) fn figures(
        &self,
        p: &Prepared,
        block: (u64, u32),
        range: std::ops::Range<usize>,
        care: Care,
    ) -> Vec<Figures> {
        let Some(path) = &p.path else { return Vec::new() };
        let robot = self.workshop.robot_of(&p.variant);
        let arm = (range.start < care.people()).then(|| p.arm(&robot, care)).flatten();
        let of = |person: &Person| {
            let walks = person.walk(path, &p.variant, block, range.clone());
            let (near_m, nearest) = near(person, &walks, &range, (arm.as_ref(), p));
            let nearest = nearest.filter(|_| care != Care::Search);
            Figures { near_m, nearest, ..Figures::of(&walks, self.lens) }
        };
        self.people.iter().map(of).collect()
    }

    /// The objective of one walk without chance.
    fn surely(&self, p: &Prepared, law: &PostureLaw) -> f64 {
        let Some(path) = &p.path else { return INFEASIBLE };
        let robot = self.workshop.robot_of(&p.variant);
        let arm = p.arm(&robot, Care::Search);
        let of = |person: &Person| {
            let walks = person.walk_surely(path, &p.variant, law);
            let (near_m, _) = near(person, &walks, &(0..1), (arm.as_ref(), p));
            Figures { near_m, ..Figures::of(&walks, self.lens) }
        };
        let figures: Vec<Figures> = self.people.iter().map(of).collect();
        objective(&self.preset.objective, &figures, self.terms_in_search(p))
    }

    /// What of the path itself enters the objective.
    pub(super) fn terms(&self, p: &Prepared) -> PathTerms {
        let free = &self.scenario.free;
        let is_free = [Freedom::Duration, Freedom::Dwell].iter().any(|f| free.range(*f).is_some());
        let nominal_s = self.scenario.nominal().whole_s();
        PathTerms {
            time_share: is_free.then_some(p.variant.whole_s() / nominal_s),
            clearance_m: p.clearance().map(|c| c.distance_m),
            person: None,
        }
    }

    /// The same with the margin to the person, which a search only weighs.
    fn terms_in_search(&self, p: &Prepared) -> PathTerms {
        PathTerms { person: Some(self.scenario.person_margin), ..self.terms(p) }
    }
}

/// Least distances of one person's walks to the arm, m, and the least of all with what is there.
pub(super) fn near(
    person: &Person,
    walks: &Walks,
    people: &std::ops::Range<usize>,
    (arm, p): (Option<&ArmAlong>, &Prepared),
) -> (Vec<f64>, Option<(f64, [String; 2])>) {
    let Some(arm) = arm else { return (Vec::new(), None) };
    let closest = person.closest(walks, people, (arm, &p.variant));
    let least = closest.iter().flatten().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let nearest = least.map(|c| (c.distance_m, arm.between(c, person.parts())));
    (closest.into_iter().flatten().map(|c| c.distance_m).collect(), nearest)
}

//! Which searches a plan runs: the baselines that search, ours with one freedom less each and with
//! none, and ours last, which starts from the best of those before it: several searches from different
//! starts rarely miss the same basin.

use super::environment::Environment;
use super::request::{Checkpoint, PlanError, Request};
use super::search::{Gauge, Task, search};
use super::space::{Space, WITHOUT, held};
use super::tried::SearchState;
use crate::posture::PostureLaw;
use nalgebra::DMatrix;

/// First block of repetitions of each search; generations take the following ones.
const FIRST_BLOCK: u32 = 16;
const BLOCKS_PER_SEARCH: u32 = 4096;

/// Points that a search takes over from each of those before it.
const TAKEN_OVER: usize = 3;
/// Distance (white units) from which on points are different starts.
const APART: f64 = 0.3;

/// Name of our own search.
pub(super) const OURS: &str = "search";
/// Names of the baselines that search.
pub(super) const RANDOM: &str = "random";
pub(super) const PLAIN: &str = "single posture, plain";
pub(super) const LEARNED: &str = "single posture, learned";
/// The straight path with its timing chosen by the same search; where the timing is free.
pub(super) const RETIMED: &str = "straight, retimed";

/// Finished searches by name, in order.
#[derive(Debug, Clone, Default)]
pub(super) struct Searches {
    pub done: Vec<(String, SearchState)>,
}

impl Searches {
    /// The best points of the searches so far as points of `of`, the best of each first.
    fn starts(&self, of: &Space, whole: &Space) -> Vec<Vec<f64>> {
        let best = |(name, state): &(String, SearchState)| -> Vec<Vec<f64>> {
            let there = if name == RETIMED {
                whole.retimed().unwrap_or_else(|| whole.clone())
            } else {
                whole.narrowed(name.strip_prefix(WITHOUT))
            };
            let best = state.best(TAKEN_OVER, 1, APART);
            best.into_iter().filter_map(|t| of.carried(&there, &t.x)).collect()
        };
        let all: Vec<Vec<Vec<f64>>> = self.done.iter().map(best).collect();
        let nth = |k: usize| all.iter().filter_map(move |a| a.get(k).cloned());
        (0..TAKEN_OVER).flat_map(nth).collect()
    }

    /// A search by name.
    pub(super) fn of(&self, name: &str) -> Option<&SearchState> {
        self.done.iter().find(|(n, _)| n == name).map(|(_, s)| s)
    }
}

/// Runs all searches of a plan. Interrupted, the error holds what it takes to go on.
pub(super) fn run_all(
    environment: &Environment,
    space: &Space,
    request: &Request,
) -> Result<Searches, PlanError> {
    let plain = plain_law(&environment.scenario.worker.model.law);
    let tasks = tasks(environment, space, &plain);
    let mut before: Vec<(String, SearchState)> = match &request.resume {
        Some(checkpoint) => checkpoint.searches_for(environment.scenario, request)?,
        None => Vec::new(),
    };
    let mut searches = Searches::default();
    for (name, mut task) in tasks {
        // A baseline that took over from others would be none.
        if name == OURS || name.starts_with(WITHOUT) {
            task.starts = searches.starts(&task.space, space);
        }
        let known = before.iter().position(|(n, _)| *n == name);
        let mut state = known.map(|i| before.swap_remove(i).1);
        let end = search(environment, &task, &mut state);
        searches.done.extend(state.map(|s| (name, s)));
        match end {
            Ok(()) => {}
            Err(PlanError::Interrupted(_)) => {
                let checkpoint = Checkpoint::new(environment.scenario, request, searches.done);
                return Err(PlanError::Interrupted(Some(Box::new(checkpoint))));
            }
            Err(other) => return Err(other),
        }
    }
    Ok(searches)
}

fn tasks<'a>(
    environment: &'a Environment,
    space: &Space<'a>,
    plain: &'a PostureLaw,
) -> Vec<(String, Task<'a>)> {
    let preset = environment.preset;
    let repetitions =
        Gauge::Repetitions { first: preset.rollouts_first, most: preset.rollouts_most };
    let ours = Task {
        name: "searching",
        prefix: "s".to_owned(),
        space: space.clone(),
        gauge: repetitions,
        population: preset.population,
        generations: preset.generations,
        runs: preset.runs,
        is_adaptive: true,
        block: FIRST_BLOCK,
        starts: Vec::new(),
    };
    let baseline = |prefix: &str, gauge: Gauge<'a>, is_adaptive: bool, number: u32| Task {
        name: "baselines",
        prefix: prefix.to_owned(),
        gauge,
        generations: preset.baseline_generations,
        runs: 1,
        is_adaptive,
        block: FIRST_BLOCK + number * BLOCKS_PER_SEARCH,
        ..ours.clone()
    };
    let learned = &environment.scenario.worker.model.law;
    let mut all = vec![
        (RANDOM.to_owned(), baseline("r", repetitions, false, 1)),
        (PLAIN.to_owned(), baseline("p", Gauge::Sure(plain), true, 2)),
        (LEARNED.to_owned(), baseline("m", Gauge::Sure(learned), true, 3)),
    ];
    if let Some(space) = space.retimed() {
        let task = Task {
            name: "baselines",
            prefix: "t".to_owned(),
            space,
            block: FIRST_BLOCK + 4 * BLOCKS_PER_SEARCH,
            ..ours.clone()
        };
        all.push((RETIMED.to_owned(), task));
    }
    for (k, name) in held(&environment.scenario.free).into_iter().enumerate() {
        let task = Task {
            name: "worth of freedoms",
            prefix: format!("w{k}-"),
            space: space.narrowed(Some(name)),
            ..ours.clone()
        };
        all.push((format!("{WITHOUT}{name}"), task));
    }
    all.push((OURS.to_owned(), ours));
    all
}

/// The plain pseudo-inverse: every joint alike, no pull, no chance.
fn plain_law(learned: &PostureLaw) -> PostureLaw {
    let n = learned.dof();
    PostureLaw::of_weight(DMatrix::identity(n, n), learned.stature_m, learned.task_rows)
}

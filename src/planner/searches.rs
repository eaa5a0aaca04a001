//! Which searches a plan runs: ours, the baselines that search, and ours with one freedom less each.

use super::pipeline::{Environment, PlanError, Request};
use super::resume::Checkpoint;
use super::search::{Gauge, SearchState, Task, search};
use super::space::Space;
use crate::posture::PostureLaw;
use nalgebra::DMatrix;

/// First block of people of each search; generations take the following ones.
const FIRST_BLOCK: u32 = 16;
const BLOCKS_PER_SEARCH: u32 = 4096;

/// Name of our own search.
pub(super) const OURS: &str = "search";
/// Names of the baselines that search.
pub(super) const RANDOM: &str = "random";
pub(super) const PLAIN: &str = "single posture, plain";
pub(super) const LEARNED: &str = "single posture, learned";
/// How the search without a freedom is called.
pub(super) const WITHOUT: &str = "without ";

/// Finished searches by name, in order.
#[derive(Debug, Clone, Default)]
pub(super) struct Searches {
    pub done: Vec<(String, SearchState)>,
}

impl Searches {
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
    has_baselines: bool,
) -> Result<Searches, PlanError> {
    let plain = plain_law(&environment.scenario.worker.model.law);
    let mut tasks = tasks(environment, space, &plain);
    if !has_baselines {
        tasks.truncate(1);
    }
    let mut before: Vec<(String, SearchState)> = match &request.resume {
        Some(checkpoint) => checkpoint.searches_for(environment.scenario, request)?,
        None => Vec::new(),
    };
    let mut searches = Searches::default();
    for (name, task) in tasks {
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
    let people = Gauge::People { first: preset.rollouts_first, most: preset.rollouts_most };
    let ours = Task {
        name: "searching",
        prefix: "s".to_owned(),
        space: space.clone(),
        gauge: people,
        population: preset.population,
        generations: preset.generations,
        runs: preset.runs,
        is_adaptive: true,
        block: FIRST_BLOCK,
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
        (RANDOM.to_owned(), baseline("r", people, false, 1)),
        (PLAIN.to_owned(), baseline("p", Gauge::Sure(plain), true, 2)),
        (LEARNED.to_owned(), baseline("m", Gauge::Sure(learned), true, 3)),
    ];
    for (k, name) in environment.scenario.free.names().into_iter().enumerate() {
        let task = Task {
            name: "worth of freedoms",
            prefix: format!("w{k}-"),
            space: space.without(name),
            ..ours.clone()
        };
        all.push((format!("{WITHOUT}{name}"), task));
    }
    all.insert(0, (OURS.to_owned(), ours));
    all
}

/// The plain pseudo-inverse: every joint alike, no pull, no chance.
fn plain_law(learned: &PostureLaw) -> PostureLaw {
    let n = learned.dof();
    PostureLaw::of_weight(DMatrix::identity(n, n), learned.stature_m, learned.task_rows)
}

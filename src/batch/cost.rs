//! How long a cell takes on one core: a rough figure from its planner and its worker, for the size of jobs.
//!
//! The constants were fitted to runs of the planners `quick`, `default` and `careful` on `bench_pick_and_place` (one
//! arm over a pelvis at rest) and `low_bin` (the whole body): these lay within a factor of two of the figure
//! (`docs/batches.md`). Nothing but the size of jobs depends on it.

use super::cell::Job;
use super::file::Mode;
use crate::human::Pelvis;

/// Of every cell: search for the robot's postures, small changes that are tried, and what is checked.
const EACH_S: f64 = 0.28;
/// Of a step of a repetition of a path that is reported; most of it are changes that are tried.
const REPORTED_S: f64 = 6.2e-5;
/// Of a step of a repetition in the search.
const SEARCHED_S: f64 = 1.3e-5;
/// A model of the whole body against that of one arm.
const WHOLE_BODY: f64 = 6.5;
/// Baselines that search.
const BASELINES: f64 = 3.0;

/// Seconds on one core.
pub fn core_seconds(job: &Job, mode: Mode) -> f64 {
    let (p, scenario) = (&job.preset, &job.scenario);
    let count = |n: usize| n as f64;
    let own = count((scenario.paths.len() + scenario.drawn.len()).max(1));
    let reported = count(p.steps) * count(p.rollouts_final);
    let mut seconds = EACH_S + own * REPORTED_S * reported;
    if !mode.is_assess() {
        let generations = count(p.generations) + BASELINES * count(p.baseline_generations);
        // About half of a generation meets as many people as the best of it do.
        let met = f64::midpoint(count(p.rollouts_first), count(p.rollouts_most));
        let in_search =
            generations * count(p.population) * met + count(p.shortlist * p.rollouts_final);
        seconds += SEARCHED_S * in_search * count(p.steps);
    }
    let each = if scenario.worker.pelvis == Pelvis::Moves { WHOLE_BODY } else { 1.0 };
    seconds * each * count(scenario.worker.bodies.len())
}

//! What would lower the score of the best path: small changes of where the worker stands, of the
//! handle and of the load, each tried on the same repetitions.
//!
//! Path and robot stay as they are, so that a change needs no new plan. The hand's reach is part of
//! the figures, and a change that brings the worker too near to the robot is left out.

use super::environment::{Environment, near};
use super::near::Care;
use super::objective::Figures;
use super::person::Person;
use super::prepare::Prepared;
use super::result::{CellChange, Effect, Recommendation, Recommendations, Way};
use crate::ergonomics::{PerMethod, ScoringMethod, paired_difference};
use crate::human::Stance;
use crate::math::stats::mean;
use crate::math::{Pose, Vec3};
use crate::scenario::Variant;
use crate::survey::Lens;
use nalgebra::UnitQuaternion;

/// Steps that are tried, m and deg.
const LENGTHS_M: [f64; 2] = [0.05, 0.10];
const ANGLES_DEG: [f64; 2] = [10.0, 20.0];
/// Least gain in expected RULA that is worth a sentence.
const LEAST_GAIN: f64 = 0.02;
/// Most repetitions behind an effect.
const REPETITIONS: usize = 32;
/// Block of repetitions: others than those that chose and reported a path.
const BLOCK: u32 = 4;

/// One change, and the cell with it.
struct Tried {
    what: CellChange,
    variant: Variant,
    load_share: f64,
}

/// Changes that clearly lower the expected RULA of a path for one person, best first.
pub(super) fn recommend(
    environment: &Environment,
    prepared: &Prepared,
    person: &Person,
) -> Recommendations {
    let nothing = Recommendations { tried: 0, repetitions: 0, clear: Vec::new() };
    let Some(path) = &prepared.path else { return nothing };
    let count = REPETITIONS.min(environment.preset.rollouts_final);
    let robot = environment.workshop.robot_of(&prepared.variant);
    let arm = prepared.arm(&robot, Care::Selection);
    let figures = |variant: &Variant, load_share: f64| {
        let mut lens: Lens = environment.lens.clone();
        lens.task.load_kg *= load_share;
        let repetitions = person.repeat(path, variant, (environment.seed, BLOCK), 0..count);
        let there = Prepared { variant: variant.clone(), ..prepared.clone() };
        let (near_m, _) = near(person, &repetitions, &(0..count), (arm.as_ref(), &there));
        Figures { near_m, ..Figures::of(&repetitions, &lens) }
    };
    let margin = &environment.scenario.person_margin;
    let is_too_near = |f: &Figures| {
        let below = f.near_m.iter().filter(|d| **d < margin.margin_m).count() as f64;
        below > margin.share * f.near_m.len() as f64
    };
    let now = figures(&prepared.variant, 1.0);
    let all = changes(environment, &prepared.variant);
    let mut clear: Vec<Recommendation> = Vec::new();
    for t in &all {
        let then = figures(&t.variant, t.load_share);
        let effect = PerMethod::of(|m| {
            let (a, b) = (&then.scores[m], &now.scores[m]);
            Effect {
                change: paired_difference(&a.time_mean, &b.time_mean),
                expected: [mean(&b.time_mean), mean(&a.time_mean)],
                high: [mean(&b.high), mean(&a.high)],
            }
        });
        let lead = &effect[ScoringMethod::Rula].change;
        // What one method gains may not be another's clear loss.
        let is_loss = effect.iter().any(|(_, e)| e.change.low95 > 0.0);
        let is_worse = mean(&then.lost) > mean(&now.lost) || is_too_near(&then) || is_loss;
        if !lead.clear || lead.mean > -LEAST_GAIN || is_worse {
            continue;
        }
        let found = Recommendation { what: t.what, effect };
        match clear.iter_mut().find(|r| is_one_direction(&r.what, &t.what)) {
            Some(known) if gained(known) <= gained(&found) => {}
            Some(known) => *known = found,
            None => clear.push(found),
        }
    }
    clear.sort_by(|a, b| gained(a).total_cmp(&gained(b)));
    Recommendations { tried: all.len(), repetitions: count, clear }
}

fn changes(environment: &Environment, from: &Variant) -> Vec<Tried> {
    let mut all = Vec::new();
    let mut push =
        |what: CellChange, variant: Variant| all.push(Tried { what, variant, load_share: 1.0 });
    let forward = Vec3::new(from.facing.cos(), from.facing.sin(), 0.0);
    let left = Vec3::z().cross(&forward);
    let seated = matches!(environment.scenario.worker.stance, Stance::Seated { .. });
    for by_m in LENGTHS_M {
        for (way, along) in [
            (Way::Nearer, forward),
            (Way::Farther, -forward),
            (Way::Left, left),
            (Way::Right, -left),
        ] {
            let at_m = [from.at_m[0] + by_m * along.x, from.at_m[1] + by_m * along.y];
            let what = CellChange::MoveWorker { way, by_m, seated };
            push(what, Variant { at_m, ..from.clone() });
        }
        for by_m in [by_m, -by_m] {
            let floor_m = from.floor_m + by_m;
            let what = CellChange::RaiseWorker { by_m, seated };
            push(what, Variant { floor_m, ..from.clone() });
        }
    }
    for by in ANGLES_DEG.into_iter().flat_map(|d| [d, -d]).map(f64::to_radians) {
        let facing = from.facing + by;
        push(CellChange::TurnWorker { by_rad: by }, Variant { facing, ..from.clone() });
        let about = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), by);
        let grip = from.grip * Pose::from_parts(Vec3::zeros().into(), about);
        push(CellChange::TurnHandle { by_rad: by }, Variant { grip, ..from.clone() });
    }
    let load_kg = environment.lens.task.load_kg;
    if load_kg > 0.0 {
        let (what, variant) = (CellChange::HalveLoad { load_kg }, from.clone());
        all.push(Tried { what, variant, load_share: 0.5 });
    }
    all
}

/// Change of the leading score.
fn gained(r: &Recommendation) -> f64 {
    r.effect[ScoringMethod::Rula].change.mean
}

/// Whether two changes are steps of one direction; the best of them is told.
fn is_one_direction(a: &CellChange, b: &CellChange) -> bool {
    use CellChange::{HalveLoad, MoveWorker, RaiseWorker, TurnHandle, TurnWorker};
    match (a, b) {
        (MoveWorker { way: a, .. }, MoveWorker { way: b, .. }) => a == b,
        (RaiseWorker { by_m: a, .. }, RaiseWorker { by_m: b, .. })
        | (TurnWorker { by_rad: a }, TurnWorker { by_rad: b })
        | (TurnHandle { by_rad: a }, TurnHandle { by_rad: b }) => a.signum() == b.signum(),
        (HalveLoad { .. }, HalveLoad { .. }) => true,
        _ => false,
    }
}

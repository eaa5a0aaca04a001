//! What would lower the score of the best path: small changes of where the worker stands, of the
//! heights of start and goal, of the handle and of the load, each tried on the same repetitions.
//!
//! Path and robot stay as they are, so that a change needs no new plan; where an end is raised, the path is
//! bent with it and the robot is not looked at again. The hand's reach is part of
//! the figures, and a change that brings the worker too near to the robot is left out.

use super::environment::{Environment, near};
use super::near::Care;
use super::objective::Figures;
use super::person::Person;
use super::prepare::Prepared;
use super::repetitions::Repetitions;
use super::result::{CellChange, Effect, Recommendation, Recommendations, StandingPlace, Way};
use crate::ergonomics::{PerMethod, ScoringMethod};
use crate::human::Stance;
use crate::math::stats::{mean, std_dev};
use crate::math::{Pose, Vec3};
use crate::path::End;
use crate::scenario::Variant;
use crate::survey::Lens;
use crate::trajectory::TimedPath;
use nalgebra::UnitQuaternion;
use std::ops::Range;

/// Steps that are tried, m and deg.
const LENGTHS_M: [f64; 2] = [0.05, 0.10];
const ANGLES_DEG: [f64; 2] = [10.0, 20.0];
const HEIGHTS_M: [f64; 2] = [0.10, 0.20];
/// Steps of somebody who would stand elsewhere, m, and share of repetitions from which it is looked for.
const STEPS_M: [f64; 3] = [0.10, 0.20, 0.30];
const WOULD_STEP: f64 = 0.05;
/// Least gain in expected RULA that is worth a sentence.
const LEAST_GAIN: f64 = 0.02;
/// Most repetitions behind an effect, and those after which a change that promises nothing is left.
const REPETITIONS: usize = 32;
const FIRST_REPETITIONS: usize = 8;
/// Block of repetitions: others than those that chose and reported a path.
const BLOCK: u32 = 4;

/// One change, and the cell with it.
#[derive(Clone)]
struct Tried {
    what: CellChange,
    variant: Variant,
    load_share: f64,
    /// An end that is raised, m.
    raised: Option<(End, f64)>,
}

/// Changes that clearly lower the expected RULA of a path for one person, best first.
pub(super) fn recommend(
    environment: &Environment,
    prepared: &Prepared,
    person: &Person,
) -> Recommendations {
    let nothing = Recommendations { tried: 0, repetitions: 0, clear: Vec::new(), standing: None };
    let Some(path) = &prepared.path else { return nothing };
    // There are two dozen changes for one path: half of what a report of it costs each is enough.
    let count = REPETITIONS.min(environment.preset.rollouts_final.div_ceil(2));
    let robot = environment.workshop.robot_of(&prepared.variant);
    let arm = prepared.arm(&robot, Care::Selection);
    let block = (environment.seed, BLOCK);
    let bent = |t: &Tried| t.raised.map(|(end, by_m)| raised(path, end, by_m));
    let figures = |t: &Tried, numbers: Range<usize>| {
        let mut lens: Lens = environment.lens.clone();
        lens.task.load_kg *= t.load_share;
        let bent = bent(t);
        let path = bent.as_ref().unwrap_or(path);
        let repetitions = person.scored(path, &t.variant, (block, numbers.clone()), &lens);
        let there = Prepared { variant: t.variant.clone(), ..prepared.clone() };
        let (near_m, _) = near(person, &repetitions, &numbers, (arm.as_ref(), &there));
        Figures { near_m, ..Figures::of(&repetitions, &lens) }
    };
    let repeated = |t: &Tried| {
        let bent = bent(t);
        person.repeat(bent.as_ref().unwrap_or(path), &t.variant, block, 0..count)
    };
    let l5s1_peak_nm = |r: &Repetitions| mean(&r.l5s1_peaks_nm());
    let stretched_share = |r: &Repetitions| r.stretched_share(&environment.scenario.worker);
    let margin = &environment.scenario.person_margin;
    let is_too_near = |f: &Figures| {
        let below = f.near_m.iter().filter(|d| **d < margin.margin_m).count() as f64;
        below > margin.share * f.near_m.len() as f64
    };
    let as_it_is = Tried {
        what: CellChange::HalveLoad { load_kg: 0.0 },
        variant: prepared.variant.clone(),
        load_share: 1.0,
        raised: None,
    };
    let before = figures(&as_it_is, 0..count);
    let now = repeated(&as_it_is);
    let now_peak_nm = l5s1_peak_nm(&now);
    let all = changes(environment, &prepared.variant);
    let mut clear: Vec<Recommendation> = Vec::new();
    for t in &all {
        // In full only what still promises something after a few repetitions.
        let mut then = Figures::default();
        let mut known = 0;
        for wanted in rounds(count) {
            then.extend(figures(t, known..wanted));
            known = wanted;
            if !promises(&then, &before) {
                break;
            }
        }
        if known < count || !promises(&then, &before) {
            continue;
        }
        let effect = PerMethod::of(|m| {
            let (a, b) = (&then.scores[m], &before.scores[m]);
            Effect {
                change: a.less(b, |f| &f.time_mean),
                expected: [mean(&b.time_mean), mean(&a.time_mean)],
                high: [mean(&b.high), mean(&a.high)],
            }
        });
        let lead = &effect[ScoringMethod::Rula].change;
        // What one method gains may not be another's clear loss.
        let is_loss = effect.iter().any(|(_, e)| e.change.low95 > 0.0);
        let is_worse = mean(&then.lost) > mean(&before.lost) || is_too_near(&then) || is_loss;
        if !lead.clear || lead.mean > -LEAST_GAIN || is_worse {
            continue;
        }
        let is_load = t.load_share < 1.0;
        let l5s1_peak_nm = (!is_load).then(|| [now_peak_nm, l5s1_peak_nm(&repeated(t))]);
        let found = Recommendation { what: t.what, effect, l5s1_peak_nm };
        match clear.iter_mut().find(|r| is_one_direction(&r.what, &t.what)) {
            Some(known) if gained(known) <= gained(&found) => {}
            Some(known) => *known = found,
            None => clear.push(found),
        }
    }
    clear.sort_by(|a, b| gained(a).total_cmp(&gained(b)));
    let standing = stretched_share(&now).filter(|s| *s > WOULD_STEP).and_then(|share| {
        let place = |(way, by_m, at_m): (Way, f64, [f64; 2])| {
            let variant = Variant { at_m, ..prepared.variant.clone() };
            let there = Tried { variant, ..as_it_is.clone() };
            let then = stretched_share(&repeated(&there)).filter(|s| *s < share)?;
            if is_too_near(&figures(&there, 0..count)) {
                return None;
            }
            Some(StandingPlace { way, by_m, stretched_share: [share, then] })
        };
        let tried = STEPS_M.into_iter().flat_map(|by_m| places(&prepared.variant, by_m));
        let found: Vec<StandingPlace> = tried.filter_map(place).collect();
        let is_enough = |p: &&StandingPlace| p.stretched_share[1] <= WOULD_STEP;
        let least = |a: &&StandingPlace, b: &&StandingPlace| {
            a.stretched_share[1].total_cmp(&b.stretched_share[1])
        };
        found.iter().find(is_enough).or_else(|| found.iter().min_by(least)).copied()
    });
    Recommendations { tried: all.len(), repetitions: count, clear, standing }
}

/// Numbers of repetitions after which a change is looked at.
fn rounds(count: usize) -> impl Iterator<Item = usize> {
    let doubled = |n: &usize| Some(2 * n);
    let before = std::iter::successors(Some(FIRST_REPETITIONS), doubled);
    before.take_while(move |n| *n < count).chain([count])
}

/// Whether the expected RULA may still fall by as much as is worth a sentence: no more than a standard error above
/// what was found so far on the same repetitions.
fn promises(then: &Figures, before: &Figures) -> bool {
    let (then, before) = (&then.rula().time_mean, &before.rula().time_mean);
    let differences: Vec<f64> = then.iter().zip(before).map(|(a, b)| a - b).collect();
    let error = std_dev(&differences) / (differences.len() as f64).sqrt();
    differences.len() < 2 || mean(&differences) - error <= -LEAST_GAIN
}

/// A path one of whose ends is raised: the other end stays, between them it is bent evenly along its length.
fn raised(path: &TimedPath, end: End, by_m: f64) -> TimedPath {
    let at = |p: &Pose| p.translation.vector;
    let mut way = vec![0.0];
    for pair in path.poses.windows(2) {
        way.push(way[way.len() - 1] + (at(&pair[1]) - at(&pair[0])).norm());
    }
    let whole = way[way.len() - 1].max(f64::MIN_POSITIVE);
    let mut bent = path.clone();
    for (pose, way) in bent.poses.iter_mut().zip(way) {
        let toward_goal = way / whole;
        let share = if end == End::Start { 1.0 - toward_goal } else { toward_goal };
        pose.translation.vector.z += by_m * share;
    }
    bent
}

/// Where the worker would stand after a step each way.
fn places(from: &Variant, by_m: f64) -> [(Way, f64, [f64; 2]); 4] {
    let forward = Vec3::new(from.facing.cos(), from.facing.sin(), 0.0);
    let left = Vec3::z().cross(&forward);
    [(Way::Nearer, forward), (Way::Farther, -forward), (Way::Left, left), (Way::Right, -left)].map(
        |(way, along)| (way, by_m, [from.at_m[0] + by_m * along.x, from.at_m[1] + by_m * along.y]),
    )
}

fn changes(environment: &Environment, from: &Variant) -> Vec<Tried> {
    let mut all = Vec::new();
    let mut push = |what: CellChange, variant: Variant| {
        all.push(Tried { what, variant, load_share: 1.0, raised: None });
    };
    let seated = matches!(environment.scenario.worker.stance, Stance::Seated { .. });
    for by_m in LENGTHS_M {
        for (way, by_m, at_m) in places(from, by_m) {
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
    for end in [End::Start, End::Goal] {
        for by_m in HEIGHTS_M.into_iter().flat_map(|d| [d, -d]) {
            let (what, variant) = (CellChange::RaiseEnd { end, by_m }, from.clone());
            all.push(Tried { what, variant, load_share: 1.0, raised: Some((end, by_m)) });
        }
    }
    let load_kg = environment.lens.task.load_kg;
    if load_kg > 0.0 {
        let (what, variant) = (CellChange::HalveLoad { load_kg }, from.clone());
        all.push(Tried { what, variant, load_share: 0.5, raised: None });
    }
    all
}

/// Change of the leading score.
fn gained(r: &Recommendation) -> f64 {
    r.effect[ScoringMethod::Rula].change.mean
}

/// Whether two changes are steps of one direction; the best of them is told.
fn is_one_direction(a: &CellChange, b: &CellChange) -> bool {
    use CellChange::{HalveLoad, MoveWorker, RaiseEnd, RaiseWorker, TurnHandle, TurnWorker};
    match (a, b) {
        (MoveWorker { way: a, .. }, MoveWorker { way: b, .. }) => a == b,
        (RaiseEnd { end: x, by_m: a }, RaiseEnd { end: y, by_m: b }) => {
            x == y && a.signum() == b.signum()
        }
        (RaiseWorker { by_m: a, .. }, RaiseWorker { by_m: b, .. })
        | (TurnWorker { by_rad: a }, TurnWorker { by_rad: b })
        | (TurnHandle { by_rad: a }, TurnHandle { by_rad: b }) => a.signum() == b.signum(),
        (HalveLoad { .. }, HalveLoad { .. }) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::minimum_jerk_line;

    #[test]
    fn a_change_is_left_only_where_it_promises_nothing() {
        assert_eq!(rounds(32).collect::<Vec<_>>(), [8, 16, 32]);
        assert_eq!(rounds(6).collect::<Vec<_>>(), [6]);
        let of = |time_mean: Vec<f64>| {
            let mut figures = Figures::default();
            figures.scores[ScoringMethod::Rula].time_mean = time_mean;
            figures
        };
        let before = of(vec![3.0; 8]);
        // Mean -0.01 with a standard error of 0.006: not yet 0.02. With one of 0.02 it may be.
        let near = [2.97, 3.01, 2.97, 3.01, 2.99, 2.99, 3.0, 2.98].to_vec();
        assert!(!promises(&of(near.clone()), &before));
        let far = near.iter().map(|x| 2.99 + 4.0 * (x - 2.99)).collect();
        assert!(promises(&of(far), &before));
        assert!(!promises(&of(vec![3.1; 8]), &before) && promises(&of(vec![2.9; 8]), &before));
    }

    #[test]
    fn a_raised_end_bends_the_path_and_leaves_the_other_end() {
        let ends = [Pose::translation(0.4, -0.3, 0.9), Pose::translation(0.4, 0.5, 0.9)];
        let path = minimum_jerk_line(&ends[0], &ends[1], 4.0, 20).unwrap();
        for (end, [first, middle, last]) in
            [(End::Start, [1.1, 1.0, 0.9]), (End::Goal, [0.9, 1.0, 1.1])]
        {
            let bent = raised(&path, end, 0.2);
            let z = |i: usize| bent.poses[i].translation.vector.z;
            for (found, wanted) in [(z(0), first), (z(10), middle), (z(20), last)] {
                assert!((found - wanted).abs() < 1e-9, "{end:?} {found} {wanted}");
            }
            assert_eq!(bent.time_s, path.time_s);
        }
    }
}

//! The nearest path that keeps all limits, or the reason why there is none and what would help.
//!
//! The cheap and exact questions come first: do start and goal lie in the box, outside the obstacles
//! and within reach, is there time for the turn, is there time for the straight move? Then the
//! programs of [`super::nearest`] are solved.

use super::bounds::{outside, refuse_at_once, shortest_straight_s, shortest_turn_s, too_short};
use super::change::Change;
use super::limits::{Box3, PathLimits};
use super::nearest::{Elastic, Question, Refusal, Shortfall, solve_within};
use super::refusal::{InputFault, LimitName, NoAnswer, NoPath};
use super::scene::{Condition, Order, Scene};
use super::smooth::SmoothPath;
use super::transcription::{ACCELERATION, JERK, ROBOT, SPEED, face_label};
use crate::math::{Pose, Vec3};
use crate::qp::{Culprit, Residuals};
use crate::trajectory::{Pause, TimedPath};
use serde::{Deserialize, Serialize};

/// How a path is projected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ProjectionSettings {
    /// Number of steps T of constant jerk, 4 to 2000.
    pub steps: usize,
    /// Weight of the integral of squared jerk against that of squared distance, s^6.
    pub jerk_weight: f64,
}

impl Default for ProjectionSettings {
    fn default() -> Self {
        Self { steps: 100, jerk_weight: 1e-4 }
    }
}

/// What came of a projection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Projection {
    /// A path that keeps every limit at every time.
    Feasible {
        /// The path.
        path: SmoothPath,
        /// Largest distance from the reference at equal times, at the knots, m.
        moved_m: f64,
        /// Iterations of the solver, over all solves.
        iterations: u32,
        /// How well the last program met its conditions of optimality; dual cone, stationarity and
        /// complementarity as shares of the largest multiplier.
        optimality: Residuals,
    },
    /// No such path.
    Infeasible {
        /// The reason.
        why: NoPath,
        /// What would help, each alone, as far as it is known without further search (see
        /// [`super::smallest_changes`]).
        changes: Vec<Change>,
    },
}

pub(super) fn infeasible(why: NoPath, changes: Vec<Change>) -> Projection {
    Projection::Infeasible { why, changes }
}

/// Projects `reference` onto the limits. Position: nearest in the mean square, at rest at both ends.
/// Orientation: from the reference's first to its last by the minimum-jerk law; those between are
/// not looked at.
pub fn project(
    reference: &TimedPath,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Projection {
    project_within(reference, limits, &Scene::default(), settings)
}

/// Like [`project`], among obstacles, within reach, and under what the robot asks for.
pub fn project_within(
    reference: &TimedPath,
    limits: &PathLimits,
    scene: &Scene,
    settings: &ProjectionSettings,
) -> Projection {
    if let Some(fault) = input_fault(reference, limits, settings) {
        return infeasible(NoPath::Input { fault }, Vec::new());
    }
    let (positions, start, goal) = sampled(reference, settings.steps);
    let duration = reference.duration_s();
    if let Some(refusal) = refuse_at_once(&start, &goal, duration, limits, scene) {
        return refusal;
    }
    let step_s = duration / settings.steps as f64;
    let pause = scene.turning.and_then(|t| t.pause);
    let conditions: Vec<Condition> =
        scene.conditions.iter().cloned().chain(resting(pause, duration, settings.steps)).collect();
    let with = Scene { conditions: &conditions, ..*scene };
    let question =
        Question { reference: &positions, step_s, limits, scene: &with, settings, relaxed: None };
    match solve_within(&question) {
        Ok(answer) => {
            let path = SmoothPath::integrate(&start, &goal, step_s, answer.jerk)
                .gone(scene.turning, limits);
            let moved = path.position.iter().zip(&positions).map(|(p, r)| (p - r).norm());
            let moved_m = moved.fold(0.0, f64::max);
            let found = answer.optimality;
            let optimality = Residuals {
                dual_cone: found.dual_cone / answer.multipliers,
                stationarity: found.stationarity / answer.multipliers,
                complementarity: found.complementarity / answer.multipliers,
                ..found
            };
            Projection::Feasible { path, moved_m, iterations: answer.iterations, optimality }
        }
        Err(Refusal::Contradiction(culprits)) => {
            explain(&culprits, &start, &goal, duration, limits, settings)
        }
        Err(Refusal::Elastic(shortfalls)) => give_way(&question, &shortfalls),
        Err(Refusal::NoAnswer(answer)) => infeasible(NoPath::Unsolved { answer }, Vec::new()),
    }
}

/// Speed along each axis below which the hand is at rest on its way, m/s. Not zero: a program needs
/// some room to be solved from inside.
const AT_REST_M_S: f64 = 1e-3;

/// The conditions that hold the path at rest over a pause.
fn resting(pause: Option<Pause>, duration_s: f64, steps: usize) -> Vec<Condition> {
    let Some(pause) = pause else { return Vec::new() };
    let from_s = pause.phase * (duration_s - pause.dwell_s);
    let at = |k: &usize| {
        let t = *k as f64 * duration_s / steps as f64;
        t >= from_s && t <= from_s + pause.dwell_s
    };
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().flat_map(|a| [a, -a]);
    let of = |knot: usize| {
        axes.clone().map(move |normal| Condition {
            knot,
            order: Order::Velocity,
            normal,
            bound: AT_REST_M_S,
        })
    };
    (1..steps).filter(at).flat_map(of).collect()
}

/// Positions at the knots, first and last pose.
pub(super) fn sampled(reference: &TimedPath, steps: usize) -> (Vec<Vec3>, Pose, Pose) {
    let step = reference.duration_s() / steps as f64;
    let at = |k: usize| reference.pose_at(reference.start_s() + step * k as f64);
    let positions = (0..=steps).map(|k| at(k).translation.vector).collect();
    (positions, at(0), at(steps))
}

/// The shortest duration (s) of a rest-to-rest move from start to goal that the projection can
/// carry out, at most 2 % too long; `None` if start or goal is outside the box or input malformed.
pub fn shortest_duration_s(
    start: &Pose,
    goal: &Pose,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Option<f64> {
    let ends = TimedPath::new(vec![0.0, 1.0], vec![*start, *goal]).ok()?;
    if input_fault(&ends, limits, settings).is_some() || outside(start, goal, limits).is_some() {
        return None;
    }
    let turn = shortest_turn_s(start, goal, limits);
    let line = |k: usize| {
        let s = k as f64 / settings.steps as f64;
        start.translation.vector.lerp(&goal.translation.vector, s)
    };
    let positions: Vec<Vec3> = (0..=settings.steps).map(line).collect();
    let scene = Scene::default();
    let is_enough = |duration: f64| {
        let step_s = duration / settings.steps as f64;
        let reference = &positions;
        solve_within(&Question {
            reference,
            step_s,
            limits,
            scene: &scene,
            settings,
            relaxed: None,
        })
        .is_ok()
    };
    // Outward in growing strides from the exact bound, then inward by halving.
    let mut low = shortest_straight_s(start, goal, limits).max(turn).max(1e-3);
    let mut high = low;
    let mut stride = 1.02;
    while !is_enough(high) {
        if stride > 100.0 {
            return None;
        }
        (low, high) = (high, high * stride);
        stride *= stride;
    }
    while high > 1.02 * low {
        let middle = (low * high).sqrt();
        if is_enough(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

pub(super) fn input_fault(
    reference: &TimedPath,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Option<InputFault> {
    if let Some(error) = reference.fault() {
        return Some(InputFault::Samples { error });
    }
    if !(4..=2000).contains(&settings.steps) {
        return Some(InputFault::Steps { steps: settings.steps });
    }
    if !(settings.jerk_weight > 0.0 && settings.jerk_weight.is_finite()) {
        return Some(InputFault::JerkWeight { value: settings.jerk_weight });
    }
    limits.fault()
}

/// The refusal for a contradiction. The box is convex and holds start and goal, so that the straight
/// way is in it: what is missing is time, by less than the discretisation costs, or else the limits
/// of the certificate are named as they are.
fn explain(
    culprits: &[Culprit],
    start: &Pose,
    goal: &Pose,
    duration: f64,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Projection {
    if let Some(needed) = shortest_duration_s(start, goal, limits, settings)
        && needed > duration
    {
        return too_short(start, goal, duration, limits, needed);
    }
    if culprits.iter().any(|c| c.label == ROBOT) {
        return infeasible(NoPath::JointsTooSlow, Vec::new());
    }
    let limits = culprits.iter().filter_map(|c| limit_of(&c.label, limits)).collect();
    infeasible(NoPath::Contradiction { limits }, Vec::new())
}

/// The limit whose rows have this label; none for rows that are no limit of the path.
fn limit_of(label: &str, limits: &PathLimits) -> Option<LimitName> {
    match label {
        SPEED => Some(LimitName::Speed),
        ACCELERATION => Some(LimitName::Acceleration),
        JERK => Some(LimitName::Jerk),
        _ => {
            let inner = limits.workspace.as_ref()?;
            let face = Box3::faces().find(|f| face_label(inner, *f) == label)?;
            Some(LimitName::Face(inner.face(face.0, face.1)))
        }
    }
}

/// The refusal when elastic things would have to give way: the largest is named, with the least by
/// which it alone would have to change.
fn give_way(question: &Question, shortfalls: &[Shortfall]) -> Projection {
    let by_size = |a: &&Shortfall, b: &&Shortfall| a.by_m.total_cmp(&b.by_m);
    let Some(worst) = shortfalls.iter().max_by(by_size) else {
        return infeasible(NoPath::Unsolved { answer: NoAnswer::NotSettled }, Vec::new());
    };
    let mut blamed: Vec<Elastic> = shortfalls.iter().map(|s| s.of).collect();
    blamed.sort_unstable();
    blamed.dedup();
    let changes: Vec<Change> = blamed.iter().filter_map(|of| alone(question, *of)).collect();
    let at_s = (worst.step as f64 + 0.5) * question.step_s;
    let (scene, limits) = (question.scene, question.limits);
    let by_m = worst.by_m;
    let why = match worst.of {
        Elastic::Obstacle(i) => {
            let (obstacle, clearance_m) = (scene.obstacles[i].0.clone(), limits.clearance_m);
            NoPath::Blocked { obstacle, at_s, by_m, clearance_m }
        }
        Elastic::Corridor => NoPath::Corridor { at_s, by_m },
        Elastic::Reach(i) => {
            NoPath::LeavesReach { body: scene.reaches[i].body.clone(), at_s, by_m }
        }
    };
    infeasible(why, changes)
}

/// The least by which one elastic thing alone would have to give way, if that is enough.
pub(super) fn alone(question: &Question, of: Elastic) -> Option<Change> {
    let Err(Refusal::Elastic(given)) = solve_within(&Question { relaxed: Some(of), ..*question })
    else {
        return None;
    };
    let by_m = given.iter().find(|s| s.of == of)?.by_m;
    if given.iter().any(|s| s.of != of) {
        return None;
    }
    Some(match of {
        Elastic::Obstacle(i) => {
            Change::ShrinkObstacle { name: question.scene.obstacles[i].0.clone(), by_m }
        }
        Elastic::Corridor => {
            let from_m = question.limits.corridor_m?;
            Change::WidenCorridor { from_m, to_m: from_m + by_m }
        }
        Elastic::Reach(i) => {
            Change::ExtendReach { body: question.scene.reaches[i].body.clone(), by_m }
        }
    })
}

#[cfg(test)]
mod scene_tests;
#[cfg(test)]
mod tests;

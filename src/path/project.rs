//! The nearest path that keeps all limits, or the reason why there is none and what would help.
//!
//! The cheap and exact questions come first: do start and goal lie in the box, outside the obstacles
//! and within reach, is there time for the turn, is there time for the straight move? Then the
//! programs of [`super::nearest`] are solved.

use super::bounds::{outside, refuse_at_once, shortest_straight_s, shortest_turn_s, too_short};
use super::change::{Change, or_list};
use super::limits::PathLimits;
use super::nearest::{Elastic, Question, Refusal, Shortfall, solve_within};
use super::scene::{Condition, Order, Scene};
use super::smooth::SmoothPath;
use super::transcription::{ACCELERATION, JERK, ROBOT, SPEED};
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

/// What kind of reason stands against a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The input is malformed.
    Input,
    /// Start, goal or the way between them leave the workspace box.
    Workspace,
    /// There is too little time for the way.
    Duration,
    /// There is too little time for the turn.
    Turn,
    /// Start, goal or the way between them come too near to an obstacle.
    Obstacle,
    /// The corridor about the reference is too narrow.
    Corridor,
    /// A hand cannot follow.
    Reach,
    /// The robot's joints cannot follow.
    Robot,
    /// The solver gave no answer.
    Solver,
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
        /// The kind of reason, for counting.
        cause: Cause,
        /// The reason in a sentence, with the changes.
        reason: String,
        /// What would help, each alone, as far as it is known without further search (see
        /// [`super::smallest_changes`]).
        changes: Vec<Change>,
    },
}

pub(super) fn infeasible(cause: Cause, reason: &str, changes: Vec<Change>) -> Projection {
    Projection::Infeasible { cause, reason: format!("{reason}{}", or_list(&changes)), changes }
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
    if let Some(reason) = input_fault(reference, limits, settings) {
        return infeasible(Cause::Input, &reason, Vec::new());
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
        Err(Refusal::NoAnswer(status)) => infeasible(
            Cause::Solver,
            &format!("the solver stopped without an answer ({status}); the path is left out"),
            Vec::new(),
        ),
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
) -> Option<String> {
    if let Some(fault) = reference.fault() {
        return Some(fault.to_string());
    }
    if !(4..=2000).contains(&settings.steps) {
        return Some(format!("the number of steps must be 4 to 2000 and is {}", settings.steps));
    }
    if !(settings.jerk_weight > 0.0 && settings.jerk_weight.is_finite()) {
        return Some("the weight of the jerk must be a positive number".to_owned());
    }
    limits.fault()
}

/// The sentence for a contradiction. The box is convex and holds start and goal, so that the straight
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
        let reason = "the robot's joints cannot follow any path near this one in time";
        return infeasible(Cause::Robot, reason, Vec::new());
    }
    let is_limit = |c: &&Culprit| {
        [SPEED, ACCELERATION, JERK].contains(&c.label.as_str()) || c.label.starts_with("workspace")
    };
    let labels: Vec<&str> = culprits.iter().filter(is_limit).map(|c| c.label.as_str()).collect();
    let cause = if labels.first().is_some_and(|l| l.starts_with("workspace")) {
        Cause::Workspace
    } else {
        Cause::Duration
    };
    let reason = format!("these limits contradict each other: {}", labels.join(", "));
    infeasible(cause, &reason, Vec::new())
}

/// The refusal when elastic things would have to give way: the largest is named, with the least by
/// which it alone would have to change.
fn give_way(question: &Question, shortfalls: &[Shortfall]) -> Projection {
    let by_size = |a: &&Shortfall, b: &&Shortfall| a.by_m.total_cmp(&b.by_m);
    let Some(worst) = shortfalls.iter().max_by(by_size) else {
        return infeasible(Cause::Solver, "the path did not settle", Vec::new());
    };
    let mut blamed: Vec<Elastic> = shortfalls.iter().map(|s| s.of).collect();
    blamed.sort_unstable();
    blamed.dedup();
    let changes: Vec<Change> = blamed.iter().filter_map(|of| alone(question, *of)).collect();
    let at_s = (worst.step as f64 + 0.5) * question.step_s;
    let (scene, limits) = (question.scene, question.limits);
    let mm = worst.by_m * 1e3;
    let (cause, reason) = match worst.of {
        Elastic::Obstacle(i) => {
            let name = &scene.obstacles[i].0;
            let reason = format!(
                "obstacle `{name}` leaves no way on this side: at {at_s:.2} s the TCP comes {mm:.0} mm \
                 nearer than its clearance of {:.0} mm",
                limits.clearance_m * 1e3
            );
            (Cause::Obstacle, reason)
        }
        Elastic::Corridor => (
            Cause::Corridor,
            format!("the corridor is too narrow: at {at_s:.2} s the path is {mm:.0} mm outside"),
        ),
        Elastic::Reach(i) => (
            Cause::Reach,
            format!(
                "the path leaves the reach of body `{}`: at {at_s:.2} s by {mm:.0} mm",
                scene.reaches[i].body
            ),
        ),
    };
    infeasible(cause, &reason, changes)
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

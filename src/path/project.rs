//! The nearest path that keeps all limits, or the reason why there is none.
//!
//! The cheap and exact questions come first: do start and goal lie in the box, is there time for the
//! turn, is there time for the straight move? Then the quadratic program of [`super::transcription`]
//! is solved and its jerks are integrated exactly. The end of that integral misses the goal by the
//! solver's rounding; the least change of the jerks that closes the gap is added (it is of the same
//! size, hence the margin below the limits), and the result is measured before it is handed out.

use super::bounds::{outside, refuse_at_once, shortest_straight_s, shortest_turn_s, too_short};
use super::limits::{Box3, PathLimits};
use super::smooth::SmoothPath;
use super::transcription::{ACCELERATION, JERK, SPEED, Task};
use crate::math::{Pose, Vec3};
use crate::qp::{Culprit, Outcome, solve};
use crate::trajectory::TimedPath;
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// Shares below the limits that are tried; the second only if rounding ate the first.
const MARGINS: [f64; 2] = [1e-6, 1e-4];
/// Largest excess over a limit that counts as rounding, relative (m for the box).
pub(super) const TOLERANCE: f64 = 1e-9;

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
    },
    /// No such path.
    Infeasible {
        /// The kind of reason, for counting.
        cause: Cause,
        /// The reason in a sentence.
        reason: String,
    },
}

pub(super) fn infeasible(cause: Cause, reason: impl Into<String>) -> Projection {
    Projection::Infeasible { cause, reason: reason.into() }
}

/// Projects `reference` onto the limits. Position: nearest in the mean square, at rest at both ends.
/// Orientation: from the reference's first to its last by the minimum-jerk law; those between are
/// not looked at.
pub fn project(
    reference: &TimedPath,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Projection {
    if let Some(reason) = input_fault(reference, limits, settings) {
        return infeasible(Cause::Input, reason);
    }
    let duration = reference.duration_s();
    let step = duration / settings.steps as f64;
    let at = |k: usize| reference.pose_at(reference.start_s() + step * k as f64);
    let (start, goal) = (at(0), at(settings.steps));
    if let Some(refusal) = refuse_at_once(&start, &goal, duration, limits) {
        return refusal;
    }
    let positions: Vec<Vec3> = (0..=settings.steps).map(|k| at(k).translation.vector).collect();
    match solve_within(&positions, step, limits, settings) {
        Ok((jerk, iterations)) => {
            let path = SmoothPath::integrate(&start, &goal, step, jerk);
            let moved = path.position.iter().zip(&positions).map(|(p, r)| (p - r).norm());
            let moved_m = moved.fold(0.0, f64::max);
            Projection::Feasible { path, moved_m, iterations }
        }
        Err(Refusal::Contradiction(culprits)) => {
            explain(&culprits, &start, &goal, duration, limits, settings)
        }
        Err(Refusal::NoAnswer(status)) => infeasible(
            Cause::Solver,
            format!("the solver stopped without an answer ({status}); the path is left out"),
        ),
    }
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
    let is_enough = |duration: f64| {
        solve_within(&positions, duration / settings.steps as f64, limits, settings).is_ok()
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

fn input_fault(
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

/// Why the program gave no path.
enum Refusal {
    Contradiction(Vec<Culprit>),
    NoAnswer(String),
}

/// Solves for the jerks. Only those faces of the box enter that the reference crosses, or else a
/// solution has crossed: the others hold anyway, and each costs as many rows as the speed.
fn solve_within(
    reference: &[Vec3],
    step_s: f64,
    limits: &PathLimits,
    settings: &ProjectionSettings,
) -> Result<(Vec<Vec3>, u32), Refusal> {
    let is_outside = |&(axis, is_upper): &(usize, bool)| {
        let inner = limits.workspace.as_ref();
        inner.is_some_and(|b| reference.iter().any(|p| b.excess(p, axis, is_upper) > 0.0))
    };
    let mut faces: Vec<(usize, bool)> = Box3::faces().filter(is_outside).collect();
    let mut spent = 0;
    for margin in MARGINS {
        // Each round but the last adds a face, and there are six.
        for _ in 0..=6 {
            let task = Task {
                reference,
                step_s,
                limits,
                jerk_weight: settings.jerk_weight,
                margin,
                faces: &faces,
            };
            let x = match solve(&task.problem()) {
                Outcome::Solved { x, iterations, .. } => {
                    spent += iterations;
                    x
                }
                Outcome::PrimalInfeasible { culprits } => {
                    return Err(Refusal::Contradiction(culprits));
                }
                Outcome::DualInfeasible => return Err(Refusal::NoAnswer("unbounded".to_owned())),
                Outcome::NotConverged { status } => {
                    return Err(Refusal::NoAnswer(format!("{status:?}")));
                }
            };
            let (first, last) = (reference[0], reference[reference.len() - 1]);
            let jerk = closing(&first, &last, step_s, task.jerks(&x));
            let path = integrated(&first, step_s, jerk);
            let crossed = crossed_faces(&path, limits);
            let before = faces.len();
            faces
                .extend(crossed.iter().filter(|f| !faces.contains(f)).copied().collect::<Vec<_>>());
            if crossed.is_empty() && is_within(&path, limits) {
                return Ok((path.jerk, spent));
            }
            if faces.len() == before {
                break;
            }
        }
    }
    Err(Refusal::NoAnswer("the solution is not accurate enough".to_owned()))
}

/// Positions and derivatives of a jerk profile; the orientation plays no part here.
fn integrated(first: &Vec3, step_s: f64, jerk: Vec<Vec3>) -> SmoothPath {
    let still = Pose::translation(first.x, first.y, first.z);
    SmoothPath::integrate(&still, &still, step_s, jerk)
}

/// The jerks nearest to `jerk` whose path ends at rest at `last`.
///
/// The end state is linear in the jerks: jerk k moves it by `c_k` per axis, so the least change is
/// `c_k . G^-1 (wanted - reached)` with `G = sum c_k c_k^T`. In units of the whole duration, for the
/// conditioning of G. The second round removes the rounding of the first.
fn closing(first: &Vec3, last: &Vec3, step_s: f64, mut jerk: Vec<Vec3>) -> Vec<Vec3> {
    let steps = jerk.len();
    let h = 1.0 / steps as f64;
    let effect = |k: usize| {
        // Time left after step k, in units of the duration.
        let e = (steps - k - 1) as f64 * h;
        Vec3::new(h * (h * h / 6.0 + h * e / 2.0 + e * e / 2.0), h * (h / 2.0 + e), h)
    };
    let gram: Matrix3<f64> = (0..steps).map(|k| effect(k) * effect(k).transpose()).sum();
    let Some(inverse) = gram.try_inverse() else { return jerk };
    let duration = step_s * steps as f64;
    for _ in 0..2 {
        let path = integrated(first, step_s, jerk);
        let (p, v, a) = (path.position[steps], path.velocity[steps], path.acceleration[steps]);
        jerk = path.jerk;
        for axis in 0..3 {
            let gap = Vec3::new(
                (last[axis] - p[axis]) / duration.powi(3),
                -v[axis] / duration.powi(2),
                -a[axis] / duration,
            );
            let weights = inverse * gap;
            for (k, j) in jerk.iter_mut().enumerate() {
                j[axis] += effect(k).dot(&weights);
            }
        }
    }
    jerk
}

/// Bezier points of the position in step `k`.
fn position_hull(path: &SmoothPath, k: usize) -> [Vec3; 4] {
    let h = path.step_s;
    let (p, v, a) = (path.position[k], path.velocity[k], path.acceleration[k]);
    [p, p + v * (h / 3.0), p + v * (h * 2.0 / 3.0) + a * (h * h / 6.0), path.position[k + 1]]
}

/// Faces of the box that the hull of some step crosses.
fn crossed_faces(path: &SmoothPath, limits: &PathLimits) -> Vec<(usize, bool)> {
    let Some(inner) = &limits.workspace else { return Vec::new() };
    let is_crossed = |&(axis, is_upper): &(usize, bool)| {
        (0..path.steps()).any(|k| {
            let hull = position_hull(path, k);
            hull.iter().any(|p| inner.excess(p, axis, is_upper) > TOLERANCE / 2.0)
        })
    };
    Box3::faces().filter(is_crossed).collect()
}

/// Whether the hulls of speed, acceleration and jerk keep their limits.
fn is_within(path: &SmoothPath, limits: &PathLimits) -> bool {
    let room = 1.0 + TOLERANCE / 2.0;
    let (v, a) = (limits.speed_m_s * room, limits.acceleration_m_s2 * room);
    let j = limits.jerk_m_s3 * room;
    let half = path.step_s / 2.0;
    (0..path.steps()).all(|k| {
        path.velocity[k].norm() <= v
            && (path.velocity[k] + path.acceleration[k] * half).norm() <= v
            && path.acceleration[k].norm() <= a
            && path.jerk[k].amax() <= j
    })
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
    let is_limit = |c: &&Culprit| {
        [SPEED, ACCELERATION, JERK].contains(&c.label.as_str()) || c.label.starts_with("workspace")
    };
    let labels: Vec<&str> = culprits.iter().filter(is_limit).map(|c| c.label.as_str()).collect();
    let cause = if labels.first().is_some_and(|l| l.starts_with("workspace")) {
        Cause::Workspace
    } else {
        Cause::Duration
    };
    infeasible(cause, format!("these limits contradict each other: {}", labels.join(", ")))
}

#[cfg(test)]
mod tests;

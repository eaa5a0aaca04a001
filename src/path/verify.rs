//! Measures a path against its limits, without the code that made it.
//!
//! A [`SmoothPath`] is evaluated from its own polynomials on a grid ten times finer than its knots.
//! Of sampled paths only the samples are known: derivative `n` is `n!` times the divided difference
//! of `n + 1` neighbours, which is a weighted mean of the true derivative between them, so that a
//! limit is never reported as broken by a path that keeps it (up to the rounding of the numbers).

use super::limits::{Box3, PathLimits};
use super::smooth::SmoothPath;
use crate::files::null_as_nan;
use crate::math::Vec3;
use crate::math::pose::rotation_between;
use crate::trajectory::TimedPath;
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

mod around;

pub use around::{verify_motion, verify_optimality, verify_samples_within, verify_scene};

/// Points of the fine grid in one step.
const FINER: usize = 10;
/// Relative tolerance of every comparison, and the absolute one where the limit is zero.
const TOLERANCE: f64 = 1e-9;
/// Least time between samples that are differenced twice or more: the rounding of recorded positions
/// to 1e-6 m would otherwise look like jerk.
const LEAST_STEP_S: f64 = 0.02;

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Speed, m/s.
    Speed,
    /// Acceleration, m/s^2.
    Acceleration,
    /// Largest component of the jerk, m/s^3.
    Jerk,
    /// Distance outside the workspace box, m; negative inside.
    Workspace,
    /// Angular speed, rad/s.
    AngularSpeed,
    /// Angular acceleration, rad/s^2.
    AngularAcceleration,
    /// Speed at the first and the last moment, m/s (with the acceleration, m/s^2, if it is known).
    Rest,
    /// Largest jump of position, velocity or acceleration between steps, SI.
    Continuity,
    /// How far the TCP is inside the clearance of an obstacle, m; negative outside.
    KeepOut,
    /// How far the TCP is outside the corridor about the reference, m; negative inside.
    Corridor,
    /// How far the TCP is outside the ball that some hand reaches, m; negative inside.
    Reach,
    /// Largest speed of a joint of the robot, as a share of its limit, between the knots too.
    JointSpeed,
    /// Largest acceleration of a joint of the robot, as a share of its limit.
    JointAcceleration,
    /// How far a joint of the robot is beyond its range, rad (m for sliding joints); negative inside.
    JointRange,
    /// Distance between the TCP by the robot's joints and the path, between the knots too, m.
    Tracking,
    /// Projection: largest residual of the equalities, unit-free.
    Equality,
    /// Projection: largest distance of a slack or a multiplier from its cone, unit-free; multipliers
    /// as shares of the largest.
    Cone,
    /// Projection: largest component of the gradient of the Lagrangian, as a share of the largest
    /// multiplier.
    Stationarity,
    /// Projection: the duality gap, as a share of the largest multiplier.
    Complementarity,
}

impl Quantity {
    /// Whether this tells how near a path is to the best one, not whether it keeps its limits.
    pub fn is_optimality(self) -> bool {
        matches!(self, Self::Equality | Self::Cone | Self::Stationarity | Self::Complementarity)
    }

    /// Whether the limit is zero and the value a signed distance from it.
    fn is_distance(self) -> bool {
        matches!(
            self,
            Self::Workspace | Self::KeepOut | Self::Corridor | Self::Reach | Self::JointRange
        )
    }
}

/// The worst value of one quantity along a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What was measured.
    pub quantity: Quantity,
    /// Its largest value; infinite if it was no number anywhere.
    #[serde(deserialize_with = "null_as_nan")]
    pub value: f64,
    /// What it may be.
    pub limit: f64,
    /// When it was largest, s on the clock of the path.
    pub at_s: f64,
}

impl Check {
    /// Room left below the limit, in the unit of the quantity; negative beyond it.
    pub fn margin(&self) -> f64 {
        self.limit - self.value
    }

    /// Whether the limit is kept, within 1e-9 of it (1e-9 m or rad for distances).
    pub fn is_met(&self) -> bool {
        let room = if self.quantity.is_distance() { 1.0 } else { self.limit };
        self.value <= self.limit + TOLERANCE * room
    }
}

/// One check for each quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    /// The checks.
    pub checks: Vec<Check>,
}

impl Verification {
    /// Whether every limit is kept.
    pub fn is_ok(&self) -> bool {
        self.checks.iter().all(Check::is_met)
    }

    /// The checks that are not met.
    pub fn violations(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|c| !c.is_met())
    }

    /// The check of one quantity, if it was measured.
    pub fn of(&self, quantity: Quantity) -> Option<&Check> {
        self.checks.iter().find(|c| c.quantity == quantity)
    }
}

/// The largest of (time, value) pairs; a value that is no number counts as infinite.
fn worst(quantity: Quantity, limit: f64, pairs: impl IntoIterator<Item = (f64, f64)>) -> Check {
    let mut check = Check { quantity, value: f64::NEG_INFINITY, limit, at_s: 0.0 };
    for (at_s, value) in pairs {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if value > check.value {
            (check.value, check.at_s) = (value, at_s);
        }
    }
    check
}

/// Time, then [p, v, a, j], on the fine grid, by Horner's rule from the knot before; none for a path
/// with no steps, or with numbers of knots that do not fit.
fn fine_states(path: &SmoothPath) -> Option<Vec<(f64, [Vec3; 4])>> {
    let knots = path.jerk.len() + 1;
    let counts = [path.position.len(), path.velocity.len(), path.acceleration.len()];
    if knots < 2 || counts != [knots; 3] {
        return None;
    }
    let h = path.step_s;
    let fine = (0..knots - 1)
        .flat_map(|k| (0..=FINER).map(move |i| (k, h * i as f64 / FINER as f64)))
        .map(|(k, e)| (k as f64 * h + e, piece(path, k, e)));
    Some(fine.collect())
}

fn piece(path: &SmoothPath, k: usize, e: f64) -> [Vec3; 4] {
    let (p, v, a, j) = (path.position[k], path.velocity[k], path.acceleration[k], path.jerk[k]);
    let acceleration = j * e + a;
    let velocity = (j * (e / 2.0) + a) * e + v;
    [((j * (e / 3.0) + a) * (e / 2.0) + v) * e + p, velocity, acceleration, j]
}

/// Measures a projected path exactly. A path with no steps, or with numbers of knots that do not fit,
/// fails the check of its continuity.
pub fn verify(path: &SmoothPath, limits: &PathLimits) -> Verification {
    let Some(fine) = fine_states(path) else {
        let nothing = [(0.0, f64::INFINITY)];
        return Verification { checks: vec![worst(Quantity::Continuity, TOLERANCE, nothing)] };
    };
    let (h, knots) = (path.step_s, path.jerk.len() + 1);
    let norms = |order: usize| fine.iter().map(move |(t, state)| (*t, state[order].norm()));
    let jerks = fine.iter().map(|(t, state)| (*t, state[3].amax()));
    let jumps = (0..knots - 1).map(|k| {
        let end = piece(path, k, h);
        let next = [path.position[k + 1], path.velocity[k + 1], path.acceleration[k + 1]];
        let jump = end.iter().zip(next).map(|(a, b)| size(&(a - b))).fold(0.0, f64::max);
        ((k + 1) as f64 * h, jump)
    });
    let ends = [(0.0, 0), (h * (knots - 1) as f64, knots - 1)]
        .map(|(t, k)| (t, size(&path.velocity[k]).max(size(&path.acceleration[k]))));
    let turned = |t: f64| (t, path.pose_at(t).rotation);
    let grid = (knots - 1) * FINER;
    let rotations: Vec<_> = (0..=grid).map(|i| turned(h * i as f64 / FINER as f64)).collect();
    let mut checks = vec![
        worst(Quantity::Speed, limits.speed_m_s, norms(1)),
        worst(Quantity::Acceleration, limits.acceleration_m_s2, norms(2)),
        worst(Quantity::Jerk, limits.jerk_m_s3, jerks),
        worst(Quantity::Rest, TOLERANCE, ends),
        worst(Quantity::Continuity, TOLERANCE, jumps),
    ];
    checks.extend(angular(&rotations, &rotations, limits));
    let positions = fine.iter().map(|(t, state)| (*t, state[0]));
    checks.extend(workspace(positions, limits));
    Verification { checks }
}

/// Measures a sampled path from its samples: speed, box and angular speed at all of them, higher
/// derivatives at samples at least 20 ms apart. At rest means: no faster over the first and the last
/// step than by speeding up from rest within the limit.
pub fn verify_samples(path: &TimedPath, limits: &PathLimits) -> Verification {
    if path.fault().is_some() {
        let nothing = [(0.0, f64::INFINITY)];
        return Verification { checks: vec![worst(Quantity::Continuity, TOLERANCE, nothing)] };
    }
    let all: Vec<usize> = (0..path.time_s.len()).collect();
    let apart = apart(&path.time_s);
    let points = |indices: &[usize]| -> Vec<(f64, Vec3)> {
        indices.iter().map(|i| (path.time_s[*i], path.poses[*i].translation.vector)).collect()
    };
    let rotations = |indices: &[usize]| -> Vec<(f64, UnitQuaternion<f64>)> {
        indices.iter().map(|i| (path.time_s[*i], path.poses[*i].rotation)).collect()
    };
    let coarse = points(&apart);
    let higher = |order: usize| differences(&coarse, order);
    let norms = |d: Vec<(f64, Vec3)>| d.into_iter().map(|(t, x)| (t, size(&x)));
    let jerks = higher(3).into_iter().map(|(t, x)| (t, x.amax()));
    let end = coarse.len() - 1;
    let first_s = coarse[1].0 - coarse[0].0;
    let last_s = coarse[end].0 - coarse[end - 1].0;
    let allowed = limits.acceleration_m_s2 * first_s.min(last_s) / 2.0;
    let speeds = higher(1);
    // Both ends against the shorter step: each speed is scaled to it.
    let ends = [(coarse[0].0, first_s, speeds[0].1), (coarse[end].0, last_s, speeds[end - 1].1)]
        .map(|(t, step, v)| (t, size(&v) * first_s.min(last_s) / step));
    let mut checks = vec![
        worst(Quantity::Speed, limits.speed_m_s, norms(differences(&points(&all), 1))),
        worst(Quantity::Acceleration, limits.acceleration_m_s2, norms(higher(2))),
        worst(Quantity::Jerk, limits.jerk_m_s3, jerks),
        worst(Quantity::Rest, allowed, ends),
    ];
    // Too few samples for a derivative: nothing was measured.
    checks.retain(|c| c.value > f64::NEG_INFINITY);
    checks.extend(angular(&rotations(&all), &rotations(&apart), limits));
    checks.extend(workspace(points(&all), limits));
    Verification { checks }
}

/// Norm; infinite if it is no number, which `f64::max` would otherwise drop.
fn size(x: &Vec3) -> f64 {
    let norm = x.norm();
    if norm.is_nan() { f64::INFINITY } else { norm }
}

/// Indices of samples at least [`LEAST_STEP_S`] apart, both ends among them.
fn apart(time_s: &[f64]) -> Vec<usize> {
    let last = time_s.len() - 1;
    let mut kept = vec![0];
    let mut latest = time_s[0];
    for (i, t) in time_s.iter().enumerate().skip(1) {
        // The rounding of the times themselves must not cost a sample.
        if t - latest > LEAST_STEP_S * (1.0 - 1e-6) {
            kept.push(i);
            latest = *t;
        }
    }
    if kept.len() > 1 {
        kept.pop();
    }
    kept.push(last);
    kept
}

/// Derivatives of the given order from divided differences, at the mean time of their samples.
fn differences(points: &[(f64, Vec3)], order: usize) -> Vec<(f64, Vec3)> {
    let mut values: Vec<Vec3> = points.iter().map(|p| p.1).collect();
    for n in 1..=order {
        values = (1..values.len())
            .map(|i| {
                let span = points[i - 1 + n].0 - points[i - 1].0;
                (values[i] - values[i - 1]) * (n as f64 / span)
            })
            .collect();
    }
    let mean =
        |i: usize| points[i..=i + order].iter().map(|p| p.0).sum::<f64>() / (order + 1) as f64;
    values.into_iter().enumerate().map(|(i, x)| (mean(i), x)).collect()
}

/// Angular speed from one list of timed orientations, angular acceleration from another.
fn angular(
    for_speed: &[(f64, UnitQuaternion<f64>)],
    for_acceleration: &[(f64, UnitQuaternion<f64>)],
    limits: &PathLimits,
) -> Vec<Check> {
    let velocities = |list: &[(f64, UnitQuaternion<f64>)]| -> Vec<(f64, Vec3)> {
        list.windows(2)
            .map(|w| {
                let turn = rotation_between(&w[0].1, &w[1].1);
                (f64::midpoint(w[0].0, w[1].0), turn / (w[1].0 - w[0].0))
            })
            .collect()
    };
    let speeds = velocities(for_speed);
    let accelerations = differences(&velocities(for_acceleration), 1);
    let norms = |list: Vec<(f64, Vec3)>| list.into_iter().map(|(t, x)| (t, size(&x)));
    let mut checks = vec![
        worst(Quantity::AngularSpeed, limits.angular_speed_rad_s, norms(speeds)),
        worst(
            Quantity::AngularAcceleration,
            limits.angular_acceleration_rad_s2,
            norms(accelerations),
        ),
    ];
    checks.retain(|c| c.value > f64::NEG_INFINITY);
    checks
}

/// Distance outside the box, if there is one.
fn workspace(
    positions: impl IntoIterator<Item = (f64, Vec3)>,
    limits: &PathLimits,
) -> Option<Check> {
    let inner = limits.workspace.as_ref()?;
    let outside = |(t, p): (f64, Vec3)| {
        let excesses = Box3::faces().map(|(axis, is_upper)| inner.excess(&p, axis, is_upper));
        let worst = excesses.map(|e| if e.is_nan() { f64::INFINITY } else { e });
        (t, worst.fold(f64::NEG_INFINITY, f64::max))
    };
    Some(worst(Quantity::Workspace, 0.0, positions.into_iter().map(outside)))
}

#[cfg(test)]
mod tests;

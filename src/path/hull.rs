//! From jerks to a path that ends where it should, and whether its hulls keep the limits.

use super::limits::{Box3, PathLimits};
use super::smooth::SmoothPath;
use crate::math::{Pose, Vec3};
use nalgebra::Matrix3;

/// Largest excess over a limit that counts as rounding, relative (m for the box).
pub(super) const TOLERANCE: f64 = 1e-9;

/// Positions and derivatives of a jerk profile; the orientation plays no part here.
pub(super) fn integrated(first: &Vec3, step_s: f64, jerk: Vec<Vec3>) -> SmoothPath {
    let still = Pose::translation(first.x, first.y, first.z);
    SmoothPath::integrate(&still, &still, step_s, jerk)
}

/// The jerks nearest to `jerk` whose path ends at rest at `last`.
///
/// The end state is linear in the jerks: jerk k moves it by `c_k` per axis, so the least change is
/// `c_k . G^-1 (wanted - reached)` with `G = sum c_k c_k^T`. In units of the whole duration, for the
/// conditioning of G. The second round removes the rounding of the first.
pub(super) fn closing(first: &Vec3, last: &Vec3, step_s: f64, mut jerk: Vec<Vec3>) -> Vec<Vec3> {
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
pub(super) fn crossed_faces(path: &SmoothPath, limits: &PathLimits) -> Vec<(usize, bool)> {
    let Some(inner) = &limits.workspace else { return Vec::new() };
    let is_crossed = |&(axis, is_upper): &(usize, bool)| {
        (0..path.steps()).any(|k| {
            let hull = position_hull(path, k);
            hull.iter().any(|p| inner.excess(p, axis, is_upper) > TOLERANCE / 2.0)
        })
    };
    Box3::faces().filter(is_crossed).collect()
}

/// Steps in which the hull of the speed exceeds its limit; the knots are means of the middle points.
pub(super) fn too_fast(path: &SmoothPath, limits: &PathLimits) -> Vec<usize> {
    let limit = limits.speed_m_s * (1.0 + TOLERANCE / 2.0);
    let half = path.step_s / 2.0;
    let middle = |k: usize| path.velocity[k] + path.acceleration[k] * half;
    let is_fast = |k: &usize| path.velocity[*k].norm() > limit || middle(*k).norm() > limit;
    (0..path.steps()).filter(is_fast).collect()
}

/// Whether the acceleration exceeds its limit.
pub(super) fn breaks_acceleration(path: &SmoothPath, limits: &PathLimits) -> bool {
    let limit = limits.acceleration_m_s2 * (1.0 + TOLERANCE / 2.0);
    !path.acceleration.iter().all(|a| a.norm() <= limit)
}

/// Whether the jerk exceeds its limit.
pub(super) fn breaks_jerk(path: &SmoothPath, limits: &PathLimits) -> bool {
    let limit = limits.jerk_m_s3 * (1.0 + TOLERANCE / 2.0);
    !path.jerk.iter().all(|j| j.amax() <= limit)
}

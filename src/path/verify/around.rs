//! Margins of a projected path beyond its own limits: surroundings, robot, optimality.

use super::{Check, Quantity, Verification, fine_states, size, worst};
use crate::math::Vec3;
use crate::path::limits::PathLimits;
use crate::path::scene::{Reach, Scene};
use crate::path::smooth::SmoothPath;
use crate::qp::Residuals;
use crate::robot::Between;
use crate::trajectory::TimedPath;

/// What the residuals of the conditions of optimality may be.
const OPTIMALITY: f64 = 1e-6;
/// How far the robot may be beside the path between knots, m.
const TRACKING_M: f64 = 1e-3;

/// Measures a projected path against its surroundings: obstacles, the corridor about `reference`
/// (which starts when the path does) and reaches. Only what there is is measured.
pub fn verify_scene(
    path: &SmoothPath,
    limits: &PathLimits,
    scene: &Scene,
    reference: &TimedPath,
) -> Verification {
    let fine = fine_states(path).unwrap_or_default();
    let positions: Vec<(f64, Vec3)> = fine.iter().map(|(t, state)| (*t, state[0])).collect();
    let mut checks = surroundings(&positions, limits, scene);
    if let Some(radius) = limits.corridor_m {
        let middle = |t: f64| reference.pose_at(reference.start_s() + t).translation.vector;
        let beyond = positions.iter().map(|(t, p)| (*t, size(&(p - middle(*t))) - radius));
        checks.push(worst(Quantity::Corridor, 0.0, beyond));
        checks.retain(|c| c.value > f64::NEG_INFINITY);
    }
    Verification { checks }
}

/// Measures the samples of a path against obstacles and reaches.
pub fn verify_samples_within(path: &TimedPath, limits: &PathLimits, scene: &Scene) -> Verification {
    let positions: Vec<(f64, Vec3)> =
        path.time_s.iter().zip(&path.poses).map(|(t, p)| (*t, p.translation.vector)).collect();
    Verification { checks: surroundings(&positions, limits, scene) }
}

fn surroundings(positions: &[(f64, Vec3)], limits: &PathLimits, scene: &Scene) -> Vec<Check> {
    let mut checks = Vec::new();
    let largest = |quantity, of: &dyn Fn(&Vec3) -> f64| {
        worst(quantity, 0.0, positions.iter().map(|(t, p)| (*t, of(p))))
    };
    if let (Some((_, first)), Some((_, last))) = (positions.first(), positions.last()) {
        let depth = |p: &Vec3| {
            let of = |i: usize| {
                let clearance = scene.clearance_m(i, limits, [first, last]);
                clearance - scene.obstacles[i].1.signed_distance(p)
            };
            (0..scene.obstacles.len()).map(of).fold(f64::NEG_INFINITY, f64::max)
        };
        checks.push(largest(Quantity::KeepOut, &depth));
    }
    let beyond = |p: &Vec3| {
        let of = |r: &Reach| size(&(p - r.center)) - r.radius_m;
        scene.reaches.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    };
    checks.push(largest(Quantity::Reach, &beyond));
    checks.retain(|c| c.value > f64::NEG_INFINITY);
    checks
}

/// The conditions of optimality of a projection, against 1e-6.
pub fn verify_optimality(found: &Residuals) -> Verification {
    let limit = OPTIMALITY;
    let check = |quantity, value: f64| worst(quantity, limit, [(0.0, value)]);
    Verification {
        checks: vec![
            check(Quantity::Equality, found.equality),
            check(Quantity::Cone, found.cone.max(found.dual_cone)),
            check(Quantity::Stationarity, found.stationarity),
            check(Quantity::Complementarity, found.complementarity),
        ],
    }
}

/// The robot's motion between its knots: joints against their limits, the TCP against the path.
pub fn verify_motion(found: &Between) -> Verification {
    let check = |quantity, limit, value, at_s| worst(quantity, limit, [(at_s, value)]);
    let (speed, acceleration, range) = (&found.speed, &found.acceleration, &found.range);
    let (distance, distance_s) = found.distance_m;
    Verification {
        checks: vec![
            check(Quantity::JointSpeed, 1.0, speed.value, speed.time_s),
            check(Quantity::JointAcceleration, 1.0, acceleration.value, acceleration.time_s),
            check(Quantity::JointRange, 0.0, range.value, range.time_s),
            check(Quantity::Tracking, TRACKING_M, distance, distance_s),
        ],
    }
}

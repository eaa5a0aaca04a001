//! Keep-out around convex obstacles as half-spaces, one for each step that comes near.
//!
//! Where a step passes outside, the half-space is the one that the gradient of the distance bounds: an
//! inner approximation of the exterior, so that whatever keeps it is clear, not only at first order.
//! Where a run of steps passes *through* an obstacle, one half-space serves the whole run, chosen so
//! that the run has the least way to go and the way out is not along the travel: gradients inside
//! would send the first half of the run back and the second half on. So the reference, not the
//! program, decides on which side an obstacle is passed.

use super::scene::{Order, Scene};
use super::stencil::position_hull;
use super::transcription::Plane;
use crate::math::Vec3;
use crate::robot::Obstacle;
use std::f64::consts::TAU;

/// Distance beyond the clearance within which steps get a half-space, m.
const BAND_M: f64 = 0.02;
/// By how much a half-space is farther out than asked, for the rounding of the solution, m.
const HAIR_M: f64 = 1e-6;
/// Directions across the travel that are tried for a run.
const SPOKES: usize = 16;
/// Points at which a step is measured.
const POINTS: usize = 10;

/// A curve as the Bezier points of its steps.
pub(super) struct Hulls(Vec<[Vec3; 4]>);

impl Hulls {
    /// Of spline coefficients, m; `T + 3` of them.
    pub(super) fn of(coefficients: &[Vec3]) -> Self {
        let steps = coefficients.len() - 3;
        Self((0..steps).map(|k| position_hull(k).map(|at| at.of(coefficients))).collect())
    }

    pub(super) fn steps(&self) -> usize {
        self.0.len()
    }

    /// The point at a share of step `k`.
    pub(super) fn point(&self, k: usize, s: f64) -> Vec3 {
        let (r, [a, b, c, d]) = (1.0 - s, &self.0[k]);
        a * (r * r * r) + b * (3.0 * r * r * s) + c * (3.0 * r * s * s) + d * (s * s * s)
    }

    pub(super) fn hull(&self, k: usize) -> &[Vec3; 4] {
        &self.0[k]
    }

    /// Radius about the middle of step `k` that holds the step.
    fn radius(&self, k: usize, middle: &Vec3) -> f64 {
        self.0[k].iter().map(|p| (p - middle).norm()).fold(0.0, f64::max)
    }

    /// Least distance of step `k` from an obstacle, measured only where it may be below `below`.
    fn distance(&self, k: usize, obstacle: &Obstacle, below: f64) -> f64 {
        let middle = self.point(k, 0.5);
        let least = obstacle.signed_distance(&middle) - self.radius(k, &middle);
        if least >= below {
            return least;
        }
        let at = |i: usize| obstacle.signed_distance(&self.point(k, i as f64 / POINTS as f64));
        (0..=POINTS).map(at).fold(f64::INFINITY, f64::min)
    }

    /// By how much the curve is nearer than `clearance` to an obstacle, m, and in which step;
    /// negative or zero when clear.
    pub(super) fn intrusion(&self, obstacle: &Obstacle, clearance: f64) -> (f64, usize) {
        let worst = |a: (f64, usize), b: (f64, usize)| if b.0 > a.0 { b } else { a };
        (0..self.steps())
            .map(|k| (clearance - self.distance(k, obstacle, clearance), k))
            .fold((f64::NEG_INFINITY, 0), worst)
    }
}

/// Half-spaces against one obstacle for a curve, by step; the slack is left open.
pub(super) fn planes(
    scene: &Scene,
    i: usize,
    clearance: f64,
    curve: &Hulls,
) -> Vec<(usize, Plane)> {
    let (name, obstacle) = &scene.obstacles[i];
    let room = clearance + HAIR_M;
    let mut found = Vec::new();
    let mut k = 0;
    while k < curve.steps() {
        let middle = curve.point(k, 0.5);
        let (distance, normal) = obstacle.surface(&middle);
        if distance < 0.0 {
            let end = (k..curve.steps())
                .find(|n| obstacle.signed_distance(&curve.point(*n, 0.5)) >= 0.0)
                .unwrap_or(curve.steps());
            let normal = way_out(obstacle, curve, k..end);
            // `normal . p >= support + room`, as `-normal . p <= -(support + room)`.
            let bound = -(obstacle.support(&normal) + room);
            found.extend((k..end).flat_map(|n| step_planes(name, n, -normal, bound)));
            k = end;
            continue;
        }
        if distance - curve.radius(k, &middle) < room + BAND_M {
            let bound = -(normal.dot(&middle) - distance + room);
            found.extend(step_planes(name, k, -normal, bound));
        }
        k += 1;
    }
    found
}

/// The label of an obstacle's rows.
pub(super) fn obstacle_label(name: &str) -> String {
    format!("obstacle `{name}`")
}

fn step_planes(name: &str, k: usize, normal: Vec3, bound: f64) -> [(usize, Plane); 4] {
    let label = obstacle_label(name);
    position_hull(k).map(|at| {
        let order = Order::Position;
        (k, Plane { label: label.clone(), at, order, normal, bound, slack: None })
    })
}

/// The direction across the travel in which a run of steps has the least way to go out of an
/// obstacle.
fn way_out(obstacle: &Obstacle, curve: &Hulls, run: std::ops::Range<usize>) -> Vec3 {
    let (first, last) = (curve.hull(run.start)[0], curve.hull(run.end - 1)[3]);
    let middle = curve.point(usize::midpoint(run.start, run.end - 1), 0.5);
    let nearest = obstacle.surface(&middle).1;
    let Some(travel) = (last - first).try_normalize(1e-9) else { return nearest };
    let mut aside = Vec3::zeros();
    aside[travel.iamin()] = 1.0;
    let across = travel.cross(&aside).normalize();
    let other = travel.cross(&across);
    let spokes = (0..SPOKES).map(|i| {
        let (sin, cos) = (i as f64 * TAU / SPOKES as f64).sin_cos();
        across * cos + other * sin
    });
    let own = run.clone().map(|k| obstacle.surface(&curve.point(k, 0.5)).1);
    let faces = own.filter(|n| n.dot(&travel).abs() < 0.5);
    let push = |n: &Vec3| {
        let least = run.clone().map(|k| n.dot(&curve.point(k, 0.5))).fold(f64::INFINITY, f64::min);
        obstacle.support(n) - least
    };
    // Faces first: of equal ways the one along a face wins.
    let all = faces.chain(spokes).map(|n| (push(&n), n));
    let better = |a: (f64, Vec3), b: (f64, Vec3)| if b.0 < a.0 - 1e-9 { b } else { a };
    all.fold((f64::INFINITY, nearest), better).1
}

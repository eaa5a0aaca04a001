//! What stands around a path besides its own limits: obstacles, and how far people reach.

use super::limits::PathLimits;
use super::turning::Turning;
use crate::math::Vec3;
use crate::robot::Obstacle;
use serde::Serialize;

/// A ball that holds every point that the TCP can be led to by one person's hand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reach {
    /// Whose reach.
    pub body: String,
    /// Middle, world, m: the nominal shoulder.
    pub center: Vec3,
    /// Radius, m.
    pub radius_m: f64,
}

/// Whether a linear condition is on position (m), velocity (m/s) or acceleration (m/s^2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Order {
    /// On the position.
    Position,
    /// On the velocity.
    Velocity,
    /// On the acceleration.
    Acceleration,
}

/// A condition `normal . x <= bound` on the motion at one knot, SI, world axes; never elastic. The
/// robot's limits, linearised, are such conditions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Condition {
    /// Number of the knot, 0 to T. At the first and the last knot the motion is fixed, and
    /// conditions there are left out.
    pub knot: usize,
    /// On what.
    pub order: Order,
    /// Left side.
    pub normal: Vec3,
    /// Right side.
    pub bound: f64,
}

/// The surroundings of a path. Empty by default.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scene<'a> {
    /// What the TCP must stay away from, with names.
    pub obstacles: &'a [(String, Obstacle)],
    /// Where hands can follow; every ball must be kept.
    pub reaches: &'a [Reach],
    /// What the robot asks for.
    pub conditions: &'a [Condition],
    /// How the path is gone along; none where it neither rests nor turns besides.
    pub turning: Option<&'a Turning>,
}

impl Scene<'_> {
    /// The distance (m) that a path between two points keeps from obstacle `i`: the asked one, or
    /// that of the nearer end, if that is less.
    pub fn clearance_m(&self, i: usize, limits: &PathLimits, ends: [&Vec3; 2]) -> f64 {
        let of = |p: &Vec3| self.obstacles[i].1.signed_distance(p);
        limits.clearance_m.min(of(ends[0])).min(of(ends[1])).max(0.0)
    }
}

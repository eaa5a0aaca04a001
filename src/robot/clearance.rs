//! Obstacles, and their distance to the capsules of a robot.
//!
//! The signed distance to a convex shape is a convex function of the point, so along a segment it
//! has no minimum but the least one, and a golden-section search finds that. Parts of a mesh bring their
//! own search, by tangents, as a look at them costs more.

use crate::math::{Pose, Vec3};
use crate::mesh::Polytope;
use nalgebra::Point3;
use std::sync::Arc;

/// Halvings of the golden-section search: 0.618^60 is below the precision of the numbers.
const GOLDEN_STEPS: usize = 60;

/// A convex thing in the world that the robot must not touch; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub enum Obstacle {
    /// A box about the pose's origin, edges along its axes.
    Box {
        /// World from box.
        pose: Pose,
        /// Full edge lengths.
        size: Vec3,
    },
    /// A ball.
    Sphere {
        /// Middle in the world.
        center: Vec3,
        /// Radius.
        radius: f64,
    },
    /// All points within `radius` of a segment.
    Capsule {
        /// One end of the axis in the world.
        a: Vec3,
        /// The other end.
        b: Vec3,
        /// Radius.
        radius: f64,
    },
    /// A cylinder about the pose's origin, axis along its z.
    Cylinder {
        /// World from cylinder.
        pose: Pose,
        /// Radius.
        radius: f64,
        /// Full length.
        length: f64,
    },
    /// A convex part of a mesh, in the world.
    Hull(Arc<Polytope>),
}

impl Obstacle {
    /// Distance (m) of a point in the world; inside it is minus the depth.
    pub fn signed_distance(&self, point: &Vec3) -> f64 {
        let local = |pose: &Pose| pose.inverse_transform_point(&Point3::from(*point)).coords;
        match self {
            Self::Box { pose, size } => {
                let d = local(pose).abs() - 0.5 * size;
                outside(&d) + d.max().min(0.0)
            }
            Self::Sphere { center, radius } => (point - center).norm() - radius,
            Self::Capsule { a, b, radius } => {
                let axis = b - a;
                let length = axis.norm_squared();
                let s = if length > 0.0 { (point - a).dot(&axis) / length } else { 0.0 };
                (point - a - axis * s.clamp(0.0, 1.0)).norm() - radius
            }
            Self::Cylinder { pose, radius, length } => {
                let p = local(pose);
                let (side, end) = (p.x.hypot(p.y) - radius, p.z.abs() - 0.5 * length);
                outside(&Vec3::new(side, end, 0.0)) + side.max(end).min(0.0)
            }
            Self::Hull(hull) => hull.surface(point).0,
        }
    }

    /// Not more than the signed distance (m) of a point in the world; the same where that is cheap.
    pub fn least_distance(&self, point: &Vec3) -> f64 {
        match self {
            Self::Hull(hull) => hull.least_distance(point),
            other => other.signed_distance(point),
        }
    }

    /// Signed distance (m) of a point in the world and its gradient there, a unit vector. Where the
    /// gradient has several values (on an axis, in a corner's bisector) one of them is given.
    ///
    /// The signed distance `d` to a convex shape is convex, so that `d(x) >= d(p) + n . (x - p)` for
    /// every `x`: the half-space `n . (x - p) >= r - d(p)` keeps a distance of `r`.
    pub fn surface(&self, point: &Vec3) -> (f64, Vec3) {
        let distance = match self {
            Self::Hull(hull) => return hull.surface(point),
            other => other.signed_distance(point),
        };
        let normal = match self {
            Self::Hull(hull) => hull.surface(point).1,
            Self::Box { pose, size } => {
                let p = pose.inverse_transform_point(&Point3::from(*point)).coords;
                pose.rotation * box_normal(&p, &(0.5 * size))
            }
            Self::Sphere { center, .. } => unit_or(point - center, Vec3::z()),
            Self::Capsule { a, b, .. } => {
                let axis = b - a;
                let length = axis.norm_squared();
                let s = if length > 0.0 { (point - a).dot(&axis) / length } else { 0.0 };
                unit_or(point - a - axis * s.clamp(0.0, 1.0), across(&axis))
            }
            Self::Cylinder { pose, radius, length } => {
                let p = pose.inverse_transform_point(&Point3::from(*point)).coords;
                let (side, end) = (p.x.hypot(p.y) - radius, p.z.abs() - 0.5 * length);
                let outward = unit_or(Vec3::new(p.x, p.y, 0.0), Vec3::x());
                let upward = Vec3::z() * if p.z < 0.0 { -1.0 } else { 1.0 };
                pose.rotation
                    * if side <= 0.0 && end <= 0.0 {
                        if side >= end { outward } else { upward }
                    } else {
                        (outward * side.max(0.0) + upward * end.max(0.0)).normalize()
                    }
            }
        };
        (distance, normal)
    }

    /// How far the shape reaches along a unit vector: the largest `n . x` over its points, m.
    pub fn support(&self, direction: &Vec3) -> f64 {
        match self {
            Self::Box { pose, size } => {
                let local = pose.rotation.inverse() * direction;
                direction.dot(&pose.translation.vector) + 0.5 * local.abs().dot(size)
            }
            Self::Sphere { center, radius } => direction.dot(center) + radius,
            Self::Capsule { a, b, radius } => direction.dot(a).max(direction.dot(b)) + radius,
            Self::Cylinder { pose, radius, length } => {
                let local = pose.rotation.inverse() * direction;
                let reach = 0.5 * length * local.z.abs() + radius * local.x.hypot(local.y);
                direction.dot(&pose.translation.vector) + reach
            }
            Self::Hull(hull) => hull.support(direction),
        }
    }

    /// Smallest signed distance (m) to the capsule of `radius` about the segment from `a` to `b` in
    /// the world; zero or below when touching. Deep inside it is minus the depth of the capsule's
    /// deepest point.
    pub fn distance_to_capsule(&self, a: &Vec3, b: &Vec3, radius: f64) -> f64 {
        if let Self::Hull(hull) = self {
            return hull.distance_to_segment(a, b) - radius;
        }
        let at = |s: f64| self.signed_distance(&a.lerp(b, s));
        if a == b {
            return at(0.0) - radius;
        }
        let ratio = 0.5 * (5.0f64.sqrt() - 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        let (mut left, mut right) = (1.0 - ratio, ratio);
        let (mut at_left, mut at_right) = (at(left), at(right));
        // The ends are candidates of their own: the search only nears them.
        let mut least = at(0.0).min(at(1.0));
        for _ in 0..GOLDEN_STEPS {
            least = least.min(at_left).min(at_right);
            if at_left <= at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - ratio * (high - low);
                at_left = at(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + ratio * (high - low);
                at_right = at(right);
            }
        }
        least - radius
    }
}

/// Outward normal of a box of the given half edges, in its own frame, nearest to `p`.
fn box_normal(p: &Vec3, half: &Vec3) -> Vec3 {
    let sign = p.map(|v| if v < 0.0 { -1.0 } else { 1.0 });
    let excess = p.abs() - half;
    if excess.max() > 0.0 {
        return excess.map(|v| v.max(0.0)).component_mul(&sign).normalize();
    }
    let mut normal = Vec3::zeros();
    normal[excess.imax()] = sign[excess.imax()];
    normal
}

/// A unit vector along `v`, or `other` where `v` has no direction.
fn unit_or(v: Vec3, other: Vec3) -> Vec3 {
    v.try_normalize(1e-12).unwrap_or(other)
}

/// A unit vector across an axis.
fn across(axis: &Vec3) -> Vec3 {
    let mut other = Vec3::zeros();
    other[axis.iamin()] = 1.0;
    unit_or(axis.cross(&other), Vec3::z())
}

/// Length of the part of the excess `d` that lies outside.
fn outside(d: &Vec3) -> f64 {
    d.map(|v| v.max(0.0)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    fn obstacles(r: &[f64]) -> [Obstacle; 5] {
        let v = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]);
        let pose = Pose::new(v(0), v(3));
        [
            Obstacle::Box { pose, size: v(6).abs() },
            Obstacle::Sphere { center: v(0), radius: 0.3 },
            Obstacle::Capsule { a: v(0), b: v(3), radius: 0.2 },
            Obstacle::Cylinder { pose, radius: r[6].abs(), length: r[7].abs() },
            Obstacle::Hull(Arc::new(Polytope::around(&[[v(0), v(3), v(6)]]).grown(0.1))),
        ]
    }

    #[test]
    fn agrees_with_brute_force() {
        for index in 0..60 {
            let r = normals(&mut stream(3, Purpose::Simulation, 0, index), 15);
            let (a, b) = (Vec3::new(r[9], r[10], r[11]), Vec3::new(r[12], r[13], r[14]));
            for obstacle in obstacles(&r) {
                let own = obstacle.distance_to_capsule(&a, &b, 0.1);
                let n = 4000;
                let brute = (0..=n)
                    .map(|i| obstacle.signed_distance(&a.lerp(&b, f64::from(i) / f64::from(n))))
                    .fold(f64::INFINITY, f64::min)
                    - 0.1;
                // The grid misses the minimum by at most half a step; the search never does.
                assert!(own <= brute + 1e-10, "{obstacle:?}: {own} > {brute}");
                assert!(brute - own <= 0.5 * (b - a).norm() / f64::from(n), "{obstacle:?}");
            }
        }
    }

    #[test]
    fn signed_distance_is_the_distance_to_the_surface() {
        // Walking along the gradient by the distance ends on the surface, from either side.
        for index in 0..60 {
            let r = normals(&mut stream(4, Purpose::Simulation, 0, index), 15);
            let p = Vec3::new(r[9], r[10], r[11]);
            for obstacle in obstacles(&r) {
                let d = obstacle.signed_distance(&p);
                let h = 1e-6;
                let slope = Vec3::from_fn(|i, _| {
                    let mut e = Vec3::zeros();
                    e[i] = h;
                    (obstacle.signed_distance(&(p + e)) - obstacle.signed_distance(&(p - e)))
                        / (2.0 * h)
                });
                let (distance, normal) = obstacle.surface(&p);
                assert!((distance - d).abs() < 1e-12 && (normal - slope).norm() < 1e-5);
                // The half-space that the gradient bounds holds the whole shape.
                assert!(obstacle.support(&normal) >= normal.dot(&p) - d - 1e-9);
                assert!(d < 0.0 || obstacle.support(&normal) <= normal.dot(&p) - d + 1e-9);
                let end = obstacle.signed_distance(&(p - slope.normalize() * d));
                assert!(end.abs() < 1e-6, "{obstacle:?} at {p}: {d} then {end}");
            }
        }
    }

    #[test]
    fn touching_is_zero_and_overlap_negative() {
        let wall = Obstacle::Box { pose: Pose::identity(), size: Vec3::new(0.2, 2.0, 2.0) };
        let (a, b) = (Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.6, 0.0, 0.5));
        assert!((wall.distance_to_capsule(&a, &b, 0.05) - 0.15).abs() < 1e-12);
        assert!(wall.distance_to_capsule(&a, &b, 0.2).abs() < 1e-12);
        assert!(wall.distance_to_capsule(&-a, &b, 0.05) <= -0.14);
    }
}

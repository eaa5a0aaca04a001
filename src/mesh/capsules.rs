//! Capsules that hold a mesh, for the links of a robot.
//!
//! ```text
//! axis     of least volume among the principal directions and those of the frame
//! radius   of the smallest circle about the corners as seen along the axis
//! ends     as near to each other as their half balls allow
//! pieces   cut where that saves most volume, at most a few
//! ```

use super::split::{Rule, directions, split};
use super::triangles::{Mesh, Triangle, cut};
use crate::math::Vec3;
use nalgebra::{Matrix3, Vector2};

/// Most capsules of one link.
const MOST_CAPSULES: usize = 4;
/// Part of the whole's volume that a cut has to save.
const WORTH: f64 = 0.06;
/// Triangles with which the search for cuts works.
const MOST_TRIANGLES: usize = 1500;
/// Times an axis is tilted to make its capsule smaller.
const TILTS: usize = 4;

/// All points within `radius` of the segment from `a` to `b`; m, in the frame of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedCapsule {
    /// One end of the axis.
    pub a: Vec3,
    /// The other.
    pub b: Vec3,
    /// Radius.
    pub radius: f64,
}

impl FittedCapsule {
    fn volume(&self) -> f64 {
        let round = std::f64::consts::PI * self.radius.powi(2);
        round * ((self.b - self.a).norm() + 4.0 / 3.0 * self.radius)
    }

    /// Distance of a point from the surface, m; negative inside.
    pub fn signed_distance(&self, point: &Vec3) -> f64 {
        let axis = self.b - self.a;
        let square = axis.norm_squared();
        let s = if square > 0.0 { (point - self.a).dot(&axis) / square } else { 0.0 };
        (point - self.a - axis * s.clamp(0.0, 1.0)).norm() - self.radius
    }
}

/// A few capsules that hold all triangles of a mesh (m). Empty without triangles.
pub fn fit_capsules(mesh: &Mesh) -> Vec<FittedCapsule> {
    let (few, _) = mesh.thinned(MOST_TRIANGLES);
    let cost = |t: &[Triangle]| around(&corners(t), 0).map_or(0.0, |c| c.volume());
    let apart = |_: &[Triangle]| Vec::new();
    let directions = directions(&few.triangles);
    let rule = Rule { cost: &cost, apart: &apart, directions, most: MOST_CAPSULES, worth: WORTH };
    // What the search left out of a fine mesh counts again here.
    let whole = |planes: &[(Vec3, f64)]| {
        let mut triangles = mesh.triangles.clone();
        for (normal, at) in planes {
            triangles = cut(&triangles, normal, *at).0;
        }
        around(&corners(&triangles), TILTS)
    };
    split(&few.triangles, &rule).iter().filter_map(|p| whole(&p.planes)).collect()
}

fn corners(triangles: &[Triangle]) -> Vec<Vec3> {
    Mesh { triangles: triangles.to_vec() }.indexed().0
}

/// A small capsule that holds some points; none without points.
fn around(points: &[Vec3], tilts: usize) -> Option<FittedCapsule> {
    let mut best: Option<(FittedCapsule, Vec3)> = None;
    let offer = |axis: Vec3, best: &mut Option<(FittedCapsule, Vec3)>| {
        let Some(capsule) = along(points, &axis) else { return false };
        let is_better = best.as_ref().is_none_or(|(b, _)| capsule.volume() < b.volume());
        if is_better {
            *best = Some((capsule, axis));
        }
        is_better
    };
    for axis in principal(points).into_iter().chain([Vec3::x(), Vec3::y(), Vec3::z()]) {
        offer(axis, &mut best);
    }
    let mut step = 0.12;
    for _ in 0..tilts {
        let Some((_, axis)) = best else { break };
        let mut aside = Vec3::zeros();
        aside[axis.iamin()] = 1.0;
        let u = axis.cross(&aside).normalize();
        let v = axis.cross(&u);
        let mut is_better = false;
        for tilt in [u, -u, v, -v] {
            is_better |= offer((axis + tilt * step).normalize(), &mut best);
        }
        step *= if is_better { 1.0 } else { 0.4 };
    }
    best.map(|(capsule, _)| capsule)
}

/// Principal directions of a cloud of points.
fn principal(points: &[Vec3]) -> [Vec3; 3] {
    let n = points.len().max(1) as f64;
    let mean = points.iter().sum::<Vec3>() / n;
    let spread =
        points.iter().fold(Matrix3::zeros(), |m, p| m + (p - mean) * (p - mean).transpose());
    let vectors = spread.symmetric_eigen().eigenvectors;
    [0, 1, 2].map(|i| {
        let v: Vec3 = vectors.column(i).into_owned();
        v.try_normalize(1e-9).unwrap_or(Vec3::z())
    })
}

/// The capsule about points with its axis in a direction.
fn along(points: &[Vec3], axis: &Vec3) -> Option<FittedCapsule> {
    let mut aside = Vec3::zeros();
    aside[axis.iamin()] = 1.0;
    let u = axis.cross(&aside).normalize();
    let v = axis.cross(&u);
    let flat: Vec<Vector2<f64>> =
        points.iter().map(|p| Vector2::new(p.dot(&u), p.dot(&v))).collect();
    let (center, radius) = circle(&flat)?;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (p, f) in points.iter().zip(&flat) {
        let at = p.dot(axis);
        // Beyond an end, the half ball reaches this far at that distance from the axis.
        let ball = (radius * radius - (f - center).norm_squared()).max(0.0).sqrt();
        low = low.min(at + ball);
        high = high.max(at - ball);
    }
    if low > high {
        let middle = 0.5 * (low + high);
        (low, high) = (middle, middle);
    }
    let foot = u * center.x + v * center.y;
    let mut capsule = FittedCapsule { a: foot + axis * low, b: foot + axis * high, radius };
    // Rounding, and a ball whose ends met in the middle.
    let out = points.iter().map(|p| capsule.signed_distance(p)).fold(0.0, f64::max);
    capsule.radius += out;
    Some(capsule)
}

/// The smallest circle about points, by taking in one after the other what lies outside.
fn circle(points: &[Vector2<f64>]) -> Option<(Vector2<f64>, f64)> {
    let holds = |(c, r): &(Vector2<f64>, f64), p: &Vector2<f64>| {
        (p - c).norm() <= r * (1.0 + 1e-12) + 1e-12
    };
    let mut best = (*points.first()?, 0.0);
    // Points in an order that no file has: in that of a file, each may lie outside of all before.
    let shuffled: Vec<&Vector2<f64>> = {
        let n = points.len();
        let step = [7919, 6007, 4001, 2003, 1009, 503, 101, 13, 1]
            .into_iter()
            .find(|s: &usize| !n.is_multiple_of(*s));
        (0..n).map(|i| &points[i * step.unwrap_or(1) % n]).collect()
    };
    for (i, p) in shuffled.iter().enumerate() {
        if holds(&best, p) {
            continue;
        }
        best = (**p, 0.0);
        for (j, q) in shuffled[..i].iter().enumerate() {
            if holds(&best, q) {
                continue;
            }
            best = ((*p + *q) * 0.5, (*p - *q).norm() * 0.5);
            for r in &shuffled[..j] {
                if !holds(&best, r) {
                    best = through(p, q, r);
                }
            }
        }
    }
    Some(best)
}

/// The circle through three points, or that about the two farthest where they are in line.
fn through(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> (Vector2<f64>, f64) {
    let (u, v) = (b - a, c - a);
    let turn = 2.0 * (u.x * v.y - u.y * v.x);
    if turn.abs() < 1e-18 {
        let pairs = [(a, b), (b, c), (c, a)].map(|(p, q)| ((p + q) * 0.5, (p - q).norm() * 0.5));
        return pairs.into_iter().max_by(|p, q| p.1.total_cmp(&q.1)).unwrap_or((*a, 0.0));
    }
    let (uu, vv) = (u.norm_squared(), v.norm_squared());
    let offset = Vector2::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu) / turn;
    (a + offset, offset.norm())
}

#[cfg(test)]
mod tests {
    use super::super::triangles::tests::cuboid;
    use super::*;
    use crate::math::Pose;
    use crate::math::stream::{Purpose, normals, stream};

    /// A tube of flat sides about z.
    fn tube(radius: f64, from: f64, to: f64) -> Mesh {
        let at = |i: usize, z: f64| {
            let (sin, cos) = (i as f64 * std::f64::consts::TAU / 24.0).sin_cos();
            Vec3::new(radius * cos, radius * sin, z)
        };
        let mut triangles = Vec::new();
        for i in 0..24 {
            triangles.push([at(i, from), at(i + 1, from), at(i + 1, to)]);
            triangles.push([at(i, from), at(i + 1, to), at(i, to)]);
            for z in [from, to] {
                triangles.push([Vec3::new(0.0, 0.0, z), at(i, z), at(i + 1, z)]);
            }
        }
        Mesh { triangles }
    }

    fn depth(all: &[FittedCapsule], point: &Vec3) -> f64 {
        all.iter().map(|c| c.signed_distance(point)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_tube_is_one_capsule_along_it() {
        let all = fit_capsules(&tube(0.05, 0.0, 0.5));
        let [one] = &all[..] else { panic!("{all:?}") };
        assert!((one.b - one.a).normalize().z.abs() > 0.999);
        assert!((0.05..0.056).contains(&one.radius), "{one:?}");
    }

    #[test]
    fn a_link_with_two_joints_is_more_than_one() {
        // A long tube with a wider joint across at each end.
        let across = |z: f64| {
            let turn = Pose::new(Vec3::new(0.0, 0.0, z), Vec3::y() * std::f64::consts::FRAC_PI_2);
            tube(0.07, -0.1, 0.1).placed(&turn)
        };
        let parts = [tube(0.045, 0.0, 0.6), across(0.0), across(0.6)];
        let mesh = Mesh { triangles: parts.iter().flat_map(|m| m.triangles.clone()).collect() };
        let all = fit_capsules(&mesh);
        assert!((2..=4).contains(&all.len()), "{all:?}");
        assert!(mesh.triangles.iter().flatten().all(|c| depth(&all, c) <= 1e-9));
        assert!(depth(&all, &Vec3::new(0.1, 0.0, 0.3)) > 0.02, "slim between the joints: {all:?}");
    }

    #[test]
    fn every_mesh_is_held() {
        for index in 0..30 {
            let r = normals(&mut stream(12, Purpose::Simulation, 0, index), 72);
            let at = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]) * 0.2;
            let odd = (0..8).map(|i| [at(9 * i), at(9 * i + 3), at(9 * i + 6)]).collect();
            for mesh in [Mesh { triangles: odd }, cuboid([0.0; 3], [0.3, 0.1, 0.2])] {
                let all = fit_capsules(&mesh);
                assert!(!all.is_empty() && all.len() <= MOST_CAPSULES);
                for [a, b, c] in &mesh.triangles {
                    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.3, 0.3), (0.5, 0.5)] {
                        let p = a + (b - a) * u + (c - a) * v;
                        assert!(depth(&all, &p) <= 1e-9, "{p}");
                    }
                }
            }
        }
        assert!(fit_capsules(&Mesh::default()).is_empty());
        let point = fit_capsules(&Mesh { triangles: vec![[Vec3::x(); 3]] });
        assert!(point[0].radius < 1e-6 && point[0].a == point[0].b);
    }
}

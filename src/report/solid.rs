//! Shapes of a scene as triangles, world, m.

use super::mannequin::Outline;
use crate::math::Vec3;
use crate::planner::{SceneCapsule, SceneShape};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::{PI, TAU};

/// Corners around a section, and sections from pole to pole.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    around: usize,
    up: usize,
}

/// Of bodies and obstacles.
const FINE: Fineness = Fineness { around: 28, up: 16 };
/// Of bodies that are seen through.
const VEILED: Fineness = Fineness { around: 16, up: 10 };
/// Of what is a few millimetres thick.
const COARSE: Fineness = Fineness { around: 8, up: 4 };
/// Sides of a cylinder.
const SIDES: usize = 48;

/// A surface of triangles.
#[derive(Debug, Clone, Default)]
pub(super) struct Solid {
    /// Place and outward unit normal of each corner.
    pub corners: Vec<[Vec3; 2]>,
    /// Indices of the corners.
    pub triangles: Vec<[usize; 3]>,
    /// All around something, the triangles counter-clockwise as seen from outside.
    pub is_closed: bool,
}

impl Solid {
    /// The surface of a convex shape, from the point that is farthest in each direction.
    fn convex(fineness: Fineness, farthest: impl Fn(&Vec3) -> Vec3) -> Self {
        let Fineness { around, up } = fineness;
        let direction = |i: usize, j: usize| {
            let (sin, cos) = (PI * i as f64 / up as f64).sin_cos();
            let (s, c) = (TAU * j as f64 / around as f64).sin_cos();
            Vec3::new(sin * c, sin * s, cos)
        };
        let all = (0..=up).flat_map(|i| (0..around).map(move |j| direction(i, j)));
        let corners = all.map(|d| [farthest(&d), d]).collect();
        let at = |i: usize, j: usize| i * around + j % around;
        let cells = (0..up).flat_map(|i| (0..around).map(move |j| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        Self { corners, triangles: triangles.collect(), is_closed: true }
    }

    /// A piece of a person or a robot, between its points.
    pub(super) fn piece(piece: &SceneCapsule, points: &[Vec3]) -> Self {
        let outline = Outline::of(piece, points);
        Self::convex(FINE, |d| outline.farthest(d))
    }

    /// The same less finely.
    pub(super) fn veil(piece: &SceneCapsule, points: &[Vec3]) -> Self {
        let outline = Outline::of(piece, points);
        Self::convex(VEILED, |d| outline.farthest(d))
    }

    /// All points within a radius of a segment.
    pub(super) fn capsule(ends: [Vec3; 2], radius: f64) -> Self {
        Self::along(FINE, ends, radius)
    }

    /// The same of a thin line.
    pub(super) fn wire(ends: [Vec3; 2], radius: f64) -> Self {
        Self::along(COARSE, ends, radius)
    }

    fn along(fineness: Fineness, ends: [Vec3; 2], radius: f64) -> Self {
        let farther = |d: &Vec3| ends[usize::from((ends[1] - ends[0]).dot(d) > 0.0)];
        Self::convex(fineness, |d| farther(d) + d * radius)
    }

    /// Flat triangles, whatever way round they are; normals of corners are those of their triangle.
    fn flat(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Self {
        let mut solid = Self::default();
        for corners in triangles {
            let [a, b, c] = corners;
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-15) else { continue };
            let first = solid.corners.len();
            solid.corners.extend(corners.map(|p| [p, normal]));
            solid.triangles.push([first, first + 1, first + 2]);
        }
        solid
    }

    /// An obstacle.
    pub(super) fn obstacle(shape: &SceneShape) -> Self {
        match shape {
            SceneShape::Box { center_m, quaternion_wxyz, size_m } => {
                let (turn, middle) = (rotation(quaternion_wxyz), Vec3::from(*center_m));
                let half = 0.5 * Vec3::from(*size_m);
                let corner = |i: usize| {
                    let sign = |axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
                    middle + turn * half.component_mul(&Vec3::new(sign(0), sign(1), sign(2)))
                };
                // Counter-clockwise as seen from outside.
                let faces = [
                    [0, 4, 6, 2],
                    [1, 3, 7, 5],
                    [0, 1, 5, 4],
                    [2, 6, 7, 3],
                    [0, 2, 3, 1],
                    [4, 5, 7, 6],
                ];
                Self::flat(
                    faces
                        .into_iter()
                        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| t.map(corner))),
                )
            }
            SceneShape::Sphere { center_m, radius_m } => {
                Self::capsule([Vec3::from(*center_m); 2], *radius_m)
            }
            SceneShape::Capsule { ends_m, radius_m } => {
                Self::capsule(ends_m.map(Vec3::from), *radius_m)
            }
            SceneShape::Cylinder { center_m, quaternion_wxyz, radius_m, length_m } => {
                let (turn, middle) = (rotation(quaternion_wxyz), Vec3::from(*center_m));
                let rim = |j: usize, up: f64| {
                    let (sin, cos) = (TAU * j as f64 / SIDES as f64).sin_cos();
                    middle + turn * Vec3::new(radius_m * cos, radius_m * sin, 0.5 * up * length_m)
                };
                let cap = |up: f64| middle + turn * Vec3::new(0.0, 0.0, 0.5 * up * length_m);
                Self::flat((0..SIDES).flat_map(|j| {
                    let [a, b, c, d] =
                        [rim(j, -1.0), rim(j + 1, -1.0), rim(j + 1, 1.0), rim(j, 1.0)];
                    [[a, b, c], [a, c, d], [cap(1.0), d, c], [cap(-1.0), b, a]]
                }))
            }
            SceneShape::Mesh { points_mm, triangles } => {
                let at = |i: u32| {
                    points_mm.get(i as usize).map(|p| Vec3::from(p.map(|v| 1e-3 * f64::from(v))))
                };
                Self::flat(
                    triangles.iter().filter_map(|[a, b, c]| Some([at(*a)?, at(*b)?, at(*c)?])),
                )
            }
        }
    }
}

fn rotation([w, x, y, z]: &[f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::try_new(Quaternion::new(*w, *x, *y, *z), 1e-12)
        .unwrap_or_else(UnitQuaternion::identity)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume by the divergence theorem; positive where all triangles face outwards.
    fn volume(solid: &Solid) -> f64 {
        let at = |i: usize| solid.corners[i][0];
        solid.triangles.iter().map(|t| at(t[0]).dot(&at(t[1]).cross(&at(t[2]))) / 6.0).sum()
    }

    #[test]
    fn shapes_have_their_volume_and_face_outwards() {
        let turned = [0.8, 0.0, 0.6, 0.0];
        let cuboid = SceneShape::Box {
            center_m: [1.0, 2.0, 3.0],
            quaternion_wxyz: turned,
            size_m: [0.2, 0.3, 0.5],
        };
        assert!((volume(&Solid::obstacle(&cuboid)) - 0.03).abs() < 1e-12);
        let pole = SceneShape::Cylinder {
            center_m: [1.0, 0.0, 3.0],
            quaternion_wxyz: turned,
            radius_m: 0.1,
            length_m: 2.0,
        };
        let share = volume(&Solid::obstacle(&pole)) / (0.02 * PI);
        assert!(share > 0.99 && share < 1.0, "{share}");
        let ball = SceneShape::Sphere { center_m: [0.0, 5.0, 0.0], radius_m: 0.5 };
        let share = volume(&Solid::obstacle(&ball)) / (PI / 6.0);
        assert!(share > 0.94 && share < 1.0, "{share}");
        let ends_m = [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]];
        let share = volume(&Solid::obstacle(&SceneShape::Capsule { ends_m, radius_m: 0.1 }))
            / (0.01 * PI + 0.004 / 3.0 * PI);
        assert!(share > 0.94 && share < 1.0, "{share}");
        // A corner that is not there costs its triangle, not the picture.
        let points_mm = vec![[0, 0, 0], [1000, 0, 0], [0, 1000, 0]];
        let mesh = SceneShape::Mesh { points_mm, triangles: vec![[0, 1, 2], [0, 1, 9]] };
        assert_eq!(Solid::obstacle(&mesh).triangles.len(), 1);
    }
}

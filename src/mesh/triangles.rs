//! Triangles: bounds, cuts, and fewer of them.

use crate::math::{Pose, Vec3};
use nalgebra::Point3;
use std::collections::BTreeMap;

/// Corners of a triangle.
pub type Triangle = [Vec3; 3];

/// Cells of the grid along the longest side from which thinning starts, for the root of the wanted number of
/// triangles; and by how much it gets coarser.
const FINEST_CELLS: f64 = 2.0;
const COARSER: f64 = 0.7;

/// A bag of triangles, in the frame and unit that its owner says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// All of them, in the order of the file.
    pub triangles: Vec<Triangle>,
}

impl Mesh {
    /// Lowest and highest coordinates; zero without triangles.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let mut corners = self.triangles.iter().flatten();
        let Some(first) = corners.next() else { return (Vec3::zeros(), Vec3::zeros()) };
        corners.fold((*first, *first), |(low, high), c| (low.inf(c), high.sup(c)))
    }

    /// Edge lengths of the box about it.
    pub fn size(&self) -> Vec3 {
        let (low, high) = self.bounds();
        high - low
    }

    /// With coordinates multiplied by factors along its axes.
    #[must_use]
    pub fn scaled(&self, by: &Vec3) -> Self {
        self.mapped(|c| c.component_mul(by))
    }

    /// Placed by a pose.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        self.mapped(|c| pose.transform_point(&Point3::from(*c)).coords)
    }

    /// With every corner mapped.
    #[must_use]
    pub fn mapped(&self, to: impl Fn(&Vec3) -> Vec3) -> Self {
        Self { triangles: self.triangles.iter().map(|t| t.each_ref().map(&to)).collect() }
    }

    /// At most `most` triangles, by drawing corners of one cell of a grid together, and the farthest
    /// that a corner was moved. What shrinks to a line is left out: another triangle has its corners.
    pub fn thinned(&self, most: usize) -> (Self, f64) {
        if self.triangles.len() <= most {
            return (self.clone(), 0.0);
        }
        let (low, high) = self.bounds();
        let mut cells = (FINEST_CELLS * (most as f64).sqrt()).max(2.0);
        loop {
            let cell = (high - low).max().max(f64::MIN_POSITIVE) / cells;
            // In eight cells there is no end of flat triangles.
            let enough = if cells < 2.0 { usize::MAX } else { most };
            if let Some(thinned) = self.on_grid(&low, cell, enough) {
                return thinned;
            }
            cells *= COARSER;
        }
    }

    /// On a grid of cells of that size; none if that leaves more than `most` triangles.
    fn on_grid(&self, low: &Vec3, cell: f64, most: usize) -> Option<(Self, f64)> {
        // The first corner in a cell stands for it, so that flat faces stay flat.
        let mut stands: BTreeMap<[i64; 3], Vec3> = BTreeMap::new();
        let mut moved = 0.0f64;
        let mut kept: BTreeMap<[[i64; 3]; 3], Triangle> = BTreeMap::new();
        for triangle in &self.triangles {
            let keys = triangle.each_ref().map(|c| key(&(c - low), cell));
            let mut corners = *triangle;
            for (corner, k) in corners.iter_mut().zip(keys) {
                let first = *stands.entry(k).or_insert(*corner);
                moved = moved.max((first - *corner).norm());
                *corner = first;
            }
            if keys[0] != keys[1] && keys[1] != keys[2] && keys[2] != keys[0] {
                let mut sorted = keys;
                sorted.sort_unstable();
                kept.entry(sorted).or_insert(corners);
            }
            if kept.len() > most {
                return None;
            }
        }
        let mut triangles: Vec<Triangle> = kept.into_values().collect();
        // Of what is thinner than a cell everywhere nothing would be left.
        let used: std::collections::BTreeSet<[i64; 3]> =
            triangles.iter().flatten().map(|c| key(&(c - low), cell)).collect();
        triangles.extend(stands.iter().filter(|(k, _)| !used.contains(*k)).map(|(_, c)| [*c; 3]));
        (triangles.len() <= most).then_some((Self { triangles }, moved))
    }

    /// The corners, each once, and the triangles by their indices.
    pub fn indexed(&self) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let mut corners = Vec::new();
        let mut index = |c: &Vec3| {
            // 0 and -0 are one place.
            let bits = [c.x + 0.0, c.y + 0.0, c.z + 0.0].map(f64::to_bits);
            *known.entry(bits).or_insert_with(|| {
                corners.push(*c);
                corners.len() as u32 - 1
            })
        };
        let triangles = self.triangles.iter().map(|t| t.each_ref().map(&mut index)).collect();
        (corners, triangles)
    }
}

fn key(offset: &Vec3, cell: f64) -> [i64; 3] {
    [0, 1, 2].map(|i| (offset[i] / cell).floor() as i64)
}

/// The parts of triangles below and above the plane `normal . x = at`.
pub(super) fn cut(
    triangles: &[Triangle],
    normal: &Vec3,
    at: f64,
) -> (Vec<Triangle>, Vec<Triangle>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for triangle in triangles {
        let heights = triangle.each_ref().map(|c| normal.dot(c) - at);
        if heights.iter().all(|h| *h <= 0.0) {
            below.push(*triangle);
        } else if heights.iter().all(|h| *h >= 0.0) {
            above.push(*triangle);
        } else {
            let (mut low, mut high) = (Vec::with_capacity(4), Vec::with_capacity(4));
            for i in 0..3 {
                let (a, b) = (&triangle[i], &triangle[(i + 1) % 3]);
                let (from, to) = (heights[i], heights[(i + 1) % 3]);
                if from <= 0.0 {
                    low.push(*a);
                }
                if from >= 0.0 {
                    high.push(*a);
                }
                if from * to < 0.0 {
                    let between = crossing((a, from), (b, to));
                    low.push(between);
                    high.push(between);
                }
            }
            fan(&low, &mut below);
            fan(&high, &mut above);
        }
    }
    (below, above)
}

/// Where an edge crosses; the same point whichever way the edge is gone, as neighbours go it both ways.
fn crossing(a: (&Vec3, f64), b: (&Vec3, f64)) -> Vec3 {
    let ((low, from), (high, to)) = if a.1 < b.1 { (a, b) } else { (b, a) };
    low + (high - low) * (from / (from - to))
}

fn fan(polygon: &[Vec3], out: &mut Vec<Triangle>) {
    out.extend((2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]));
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A box with twelve triangles, outward.
    pub(in super::super) fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
        let corner =
            |i: usize| Vec3::from_fn(|a, _| if i >> a & 1 == 0 { low[a] } else { high[a] });
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let two = |f: [usize; 4]| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]];
        let triangles = faces.into_iter().flat_map(two).map(|t| t.map(corner)).collect();
        Mesh { triangles }
    }

    fn area(triangles: &[Triangle]) -> f64 {
        triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
    }

    #[test]
    fn a_cut_loses_nothing() {
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
        let normal = Vec3::new(1.0, 0.3, -0.2).normalize();
        let (below, above) = cut(&mesh.triangles, &normal, 0.7);
        assert!((area(&below) + area(&above) - area(&mesh.triangles)).abs() < 1e-12);
        assert!(below.iter().flatten().all(|c| normal.dot(c) <= 0.7 + 1e-12));
        assert!(above.iter().flatten().all(|c| normal.dot(c) >= 0.7 - 1e-12));
    }

    #[test]
    fn thinning_says_how_far_it_moved_corners() {
        let mut mesh = Mesh::default();
        let at = |i: usize, j: usize| {
            let v = j as f64 / 40.0 * std::f64::consts::PI;
            let u = 2.0 * (i as f64 / 40.0 * std::f64::consts::PI);
            Vec3::new(u.cos() * v.sin(), u.sin() * v.sin(), v.cos())
        };
        for (i, j) in (0..40).flat_map(|i| (0..40).map(move |j| (i, j))) {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        let (few, moved) = mesh.thinned(500);
        assert!(few.triangles.len() <= 500 && few.triangles.len() > 100);
        assert!(moved > 0.0 && moved < 0.5, "{moved}");
        for corner in mesh.triangles.iter().flatten() {
            let near = few.triangles.iter().flatten().map(|c| (c - corner).norm());
            assert!(near.fold(f64::INFINITY, f64::min) <= moved + 1e-12);
        }
        assert_eq!(mesh.thinned(5000), (mesh.clone(), 0.0));
    }
}

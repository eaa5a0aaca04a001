//! Convex parts that together hold a mesh.
//!
//! Cutting a closed surface by a plane and taking what is convex around each side loses nothing of the
//! solid: what sticks out farthest of a side is on its surface. Bodies that do not touch are parts of
//! their own, if their surfaces are closed and at most one cut has opened them; what lies within
//! another is left to that.

use super::polytope::Polytope;
use super::split::{Rule, directions, split};
use super::triangles::{Mesh, Triangle};
use crate::math::Vec3;
use std::collections::BTreeMap;

/// Most convex parts of one mesh.
pub const MOST_PARTS: usize = 16;
/// Part of the whole's volume that a cut has to save.
const WORTH: f64 = 0.02;
/// Triangles with which the search for cuts works.
const MOST_TRIANGLES: usize = 12_000;
/// Bodies of which one is looked at as several.
const MOST_BODIES: usize = 12;
/// Grid on which corners count as one, of the largest size.
const WELD: f64 = 1e-6;

/// At most [`MOST_PARTS`] convex parts that hold all triangles, in the frame of the mesh (m), and how
/// far they were grown for what was left out of a very fine mesh, m.
pub fn convex_parts(mesh: &Mesh) -> (Vec<Polytope>, f64) {
    let (few, moved) = mesh.thinned(MOST_TRIANGLES);
    let is_closed = moved == 0.0 && is_closed(&few.triangles);
    let cost = |t: &[Triangle]| Polytope::roughly(t).volume();
    let apart = |t: &[Triangle]| if is_closed { bodies(t) } else { Vec::new() };
    let directions = directions(&few.triangles);
    let rule = Rule { cost: &cost, apart: &apart, directions, most: MOST_PARTS, worth: WORTH };
    let pieces = split(&few.triangles, &rule);
    let around = |p: &super::split::Piece| Polytope::around(&p.triangles).grown(moved);
    (pieces.iter().map(around).collect(), moved)
}

/// Corners by the cell of a fine grid.
fn welded(triangles: &[Triangle]) -> Vec<[usize; 3]> {
    let size = Mesh { triangles: triangles.to_vec() }.size().max().max(f64::MIN_POSITIVE);
    let mut known: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let mut index = |c: &Vec3| {
        let key = [0, 1, 2].map(|i| (c[i] / (WELD * size)).round() as i64);
        let next = known.len();
        *known.entry(key).or_insert(next)
    };
    triangles.iter().map(|t| t.each_ref().map(&mut index)).collect()
}

/// Whether every edge joins triangles in pairs.
fn is_closed(triangles: &[Triangle]) -> bool {
    let mut edges: BTreeMap<(usize, usize), u32> = BTreeMap::new();
    for t in welded(triangles) {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if a != b {
                *edges.entry((a.min(b), a.max(b))).or_default() += 1;
            }
        }
    }
    edges.values().all(|n| n % 2 == 0)
}

/// The first of those that hang together with `i`.
fn root(above: &mut [usize], mut i: usize) -> usize {
    while above[i] != i {
        above[i] = above[above[i]];
        i = above[i];
    }
    i
}

/// Triangles by bodies that share no corner, the largest first; those that lie within another are left
/// out. Empty where there are too many to be parts.
fn bodies(triangles: &[Triangle]) -> Vec<Vec<Triangle>> {
    let corners = welded(triangles);
    let count = corners.iter().flatten().max().map_or(0, |m| m + 1);
    let mut above: Vec<usize> = (0..count).collect();
    for t in &corners {
        let first = root(&mut above, t[0]);
        for c in &t[1..] {
            let other = root(&mut above, *c);
            above[other] = first;
        }
    }
    let mut groups: BTreeMap<usize, Vec<Triangle>> = BTreeMap::new();
    for (t, triangle) in corners.iter().zip(triangles) {
        groups.entry(root(&mut above, t[0])).or_default().push(*triangle);
    }
    let mut all: Vec<(Polytope, Vec<Triangle>)> =
        groups.into_values().take(64).map(|g| (Polytope::around(&g), g)).collect();
    all.sort_by(|a, b| b.0.volume().total_cmp(&a.0.volume()));
    let mut kept: Vec<(Polytope, Vec<Triangle>)> = Vec::new();
    for (body, group) in all {
        let is_within = |(other, _): &(Polytope, Vec<Triangle>)| {
            group.iter().flatten().all(|c| other.surface(c).0 <= 0.0)
        };
        if !kept.iter().any(is_within) {
            kept.push((body, group));
        }
    }
    if kept.len() > MOST_BODIES || count > 0 && kept.is_empty() {
        return Vec::new();
    }
    kept.into_iter().map(|(_, g)| g).collect()
}

#[cfg(test)]
mod tests {
    use super::super::triangles::tests::cuboid;
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    fn joined(all: &[Mesh]) -> Mesh {
        Mesh { triangles: all.iter().flat_map(|m| m.triangles.clone()).collect() }
    }

    fn depth(parts: &[Polytope], at: [f64; 3]) -> f64 {
        let point = Vec3::from(at);
        parts.iter().map(|p| p.surface(&point).0).fold(f64::INFINITY, f64::min)
    }

    /// A bench with four legs, as bodies of their own.
    fn bench() -> Mesh {
        let leg = |x: f64, y: f64| cuboid([x, y, 0.0], [x + 0.06, y + 0.06, 0.7]);
        joined(&[
            cuboid([0.0, 0.0, 0.7], [1.2, 0.7, 0.74]),
            leg(0.0, 0.0),
            leg(1.14, 0.0),
            leg(0.0, 0.64),
            leg(1.14, 0.64),
        ])
    }

    #[test]
    fn under_a_bench_there_is_room() {
        let (parts, grown) = convex_parts(&bench());
        assert_eq!((parts.len(), grown), (5, 0.0));
        assert!(depth(&parts, [0.6, 0.35, 0.3]) > 0.3, "between the legs");
        assert!(depth(&parts, [0.6, 0.35, 0.72]) < 0.0, "in the top");
        assert!(depth(&parts, [0.03, 0.03, 0.3]) < -0.02, "in a leg");
    }

    /// The outline of an L, drawn out along z: one closed surface.
    fn angle() -> Mesh {
        let outline = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.1], [0.1, 0.1], [0.1, 1.0], [0.0, 1.0]];
        let at = |i: usize, z: f64| Vec3::new(outline[i % 6][0], outline[i % 6][1], z);
        let mut triangles = Vec::new();
        for i in 0..6 {
            triangles.push([at(i, 0.0), at(i + 1, 0.0), at(i + 1, 0.5)]);
            triangles.push([at(i, 0.0), at(i + 1, 0.5), at(i, 0.5)]);
        }
        for z in [0.0, 0.5] {
            for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
                triangles.push([at(a, z), at(b, z), at(c, z)]);
            }
        }
        Mesh { triangles }
    }

    #[test]
    fn an_angle_is_two_plates_and_its_notch_is_free() {
        let (parts, _) = convex_parts(&angle());
        assert!((2..=3).contains(&parts.len()), "{}", parts.len());
        assert!(depth(&parts, [0.5, 0.5, 0.25]) > 0.35, "the notch");
        assert!(depth(&parts, [0.5, 0.05, 0.25]) < -0.04, "inside, not hollow");
        assert!(depth(&parts, [0.05, 0.05, 0.25]) < -0.04, "in the corner");
    }

    #[test]
    fn no_part_of_a_mesh_is_left_out() {
        for index in 0..12 {
            let r = normals(&mut stream(11, Purpose::Simulation, 0, index), 90);
            let at = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]);
            let odd = (0..10).map(|i| [at(9 * i), at(9 * i + 3), at(9 * i + 6)]).collect();
            for mesh in [Mesh { triangles: odd }, bench(), angle()] {
                let (parts, _) = convex_parts(&mesh);
                assert!(!parts.is_empty() && parts.len() <= MOST_PARTS);
                for (n, [a, b, c]) in mesh.triangles.iter().enumerate() {
                    // Random places on the triangle.
                    let (u, v) = (r[n % 90].abs().fract(), r[(n + 7) % 90].abs().fract());
                    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                    let p = a + (b - a) * u + (c - a) * v;
                    assert!(depth(&parts, p.into()) <= 1e-9, "{p}");
                }
            }
        }
    }

    #[test]
    fn an_open_surface_is_not_taken_apart() {
        // Six faces of a box that share no corner: apart they would be hollow.
        let mut triangles = cuboid([0.0; 3], [1.0; 3]).triangles;
        for (i, t) in triangles.iter_mut().enumerate() {
            let middle = Vec3::repeat(0.5);
            *t = t.map(|c| middle + (c - middle) * (1.0 + 1e-3 * (i / 2) as f64));
        }
        let (parts, _) = convex_parts(&Mesh { triangles });
        assert!(depth(&parts, [0.5; 3]) < -0.1);
    }
}

//! Convex bodies with flat faces that hold a cloud of points.
//!
//! ```text
//! half-spaces  n_i . x <= max over the points of n_i . x,  for directions chosen by the mesh
//! inside       signed distance = max_i (n_i . x - d_i)            exact
//! outside      distance to the nearest of the faces that x sees   exact
//! ```
//! The body is bounded from outside, by supporting planes, so that no point of the mesh can be left
//! out, however flat or odd the mesh is; a convex hull is never larger than this.

use super::triangles::Triangle;
use crate::math::{Pose, Vec3};
use nalgebra::Point3;

/// Room about the points, m: gives flat things a thickness, and covers rounding.
const PAD_M: f64 = 1e-4;
/// Directions that are taken from the mesh besides the 26 of a cube's faces, edges and corners.
const MOST_NORMALS: usize = 32;
/// Cosine above which two directions are one.
const SAME: f64 = 0.998;
/// Corners nearer than this are one, m.
const ONE_CORNER_M: f64 = 1e-9;

/// A convex body that is the intersection of half-spaces; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub struct Polytope {
    faces: Vec<Face>,
    middle: Vec3,
    /// Radius of the ball about the middle that holds it.
    reach: f64,
}

/// A face: its outward unit normal, `normal . x` on it, and its corners in order.
#[derive(Debug, Clone, PartialEq)]
struct Face {
    normal: Vec3,
    at: f64,
    corners: Vec<Vec3>,
}

/// The 26 directions of a cube's faces, edges and corners, one of each pair of opposites.
fn cube_directions() -> Vec<Vec3> {
    let sign = |digit: usize| (digit % 3) as f64 - 1.0;
    // Number 13 is the middle, and the thirteen before it are the opposites of those behind.
    let of = |i: usize| Vec3::new(sign(i / 9), sign(i / 3), sign(i)).normalize();
    (14..27).map(of).collect()
}

/// The directions of triangles, by the area that has them; similar ones are one.
pub(super) fn normals(triangles: &[Triangle]) -> Vec<(Vec3, f64)> {
    let mut found: Vec<(Vec3, f64)> = Vec::new();
    for [a, b, c] in triangles {
        let across = (b - a).cross(&(c - a));
        let area = 0.5 * across.norm();
        let Some(normal) = across.try_normalize(1e-15) else { continue };
        // Curved things have no end of directions.
        let has_room = found.len() < 8 * MOST_NORMALS;
        match found.iter_mut().find(|(n, _)| n.dot(&normal) > SAME) {
            Some((_, sum)) => *sum += area,
            None if has_room => found.push((normal, area)),
            None => {}
        }
    }
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found
}

impl Polytope {
    /// Around triangles: between their planes and those of a cube, a bevelled one.
    pub fn around(triangles: &[Triangle]) -> Self {
        let mut directions: Vec<Vec3> =
            cube_directions().into_iter().flat_map(|d| [d, -d]).collect();
        for (normal, _) in normals(triangles).into_iter().take(MOST_NORMALS) {
            if directions.iter().all(|d| d.dot(&normal) < 1.0 - 1e-9) {
                directions.push(normal);
            }
        }
        Self::between(triangles, &directions)
    }

    /// The same between the planes of a bevelled cube only: quicker, for comparing.
    pub(super) fn roughly(triangles: &[Triangle]) -> Self {
        let directions: Vec<Vec3> = cube_directions().into_iter().flat_map(|d| [d, -d]).collect();
        Self::between(triangles, &directions)
    }

    fn between(triangles: &[Triangle], directions: &[Vec3]) -> Self {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let mut most = vec![f64::NEG_INFINITY; directions.len()];
        for corner in triangles.iter().flatten() {
            (low, high) = (low.inf(corner), high.sup(corner));
            for (most, d) in most.iter_mut().zip(directions) {
                *most = most.max(d.dot(corner));
            }
        }
        if triangles.is_empty() {
            (low, high) = (Vec3::zeros(), Vec3::zeros());
            most.fill(0.0);
        }
        let pad = Vec3::repeat(PAD_M);
        let mut faces = cuboid(&(low - pad), &(high + pad));
        for (normal, at) in directions.iter().zip(most) {
            clip(&mut faces, *normal, at + PAD_M);
        }
        Self::of(faces)
    }

    fn of(faces: Vec<Face>) -> Self {
        let corners = || faces.iter().flat_map(|f| &f.corners);
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        let (low, high) = corners().fold(start, |(low, high), c| (low.inf(c), high.sup(c)));
        let middle = 0.5 * (low + high);
        let reach = corners().map(|c| (c - middle).norm()).fold(0.0, f64::max);
        Self { faces, middle, reach }
    }

    /// Moved by a pose.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        let face = |f: &Face| {
            let place = |c: &Vec3| pose.transform_point(&Point3::from(*c)).coords;
            let normal = pose.rotation * f.normal;
            let at = f.at + normal.dot(&pose.translation.vector);
            Face { normal, at, corners: f.corners.iter().map(place).collect() }
        };
        Self::of(self.faces.iter().map(face).collect())
    }

    /// Grown by a length in all directions of its faces.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        let (low, high) = self.bounds();
        let wide = Vec3::repeat(by);
        let mut faces = cuboid(&(low - wide), &(high + wide));
        for face in &self.faces {
            clip(&mut faces, face.normal, face.at + by);
        }
        Self::of(faces)
    }

    /// Volume, m^3.
    pub fn volume(&self) -> f64 {
        let of = |f: &Face| -> f64 {
            let o = self.middle;
            let triple = |i: usize| {
                let [a, b, c] = [f.corners[0] - o, f.corners[i - 1] - o, f.corners[i] - o];
                a.dot(&b.cross(&c)).abs() / 6.0
            };
            (2..f.corners.len()).map(triple).sum()
        };
        self.faces.iter().map(of).sum()
    }

    /// Lowest and highest coordinates.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let start = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        self.corners().fold(start, |(low, high), c| (low.inf(c), high.sup(c)))
    }

    /// Its corners, those of several faces several times.
    pub fn corners(&self) -> impl Iterator<Item = &Vec3> {
        self.faces.iter().flat_map(|f| &f.corners)
    }

    /// The largest `direction . x` over its points.
    pub fn support(&self, direction: &Vec3) -> f64 {
        self.corners().map(|c| direction.dot(c)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Not more than the signed distance of a point; cheap.
    pub fn least_distance(&self, point: &Vec3) -> f64 {
        (point - self.middle).norm() - self.reach
    }

    /// Signed distance of a point, and its gradient there.
    pub fn surface(&self, point: &Vec3) -> (f64, Vec3) {
        let mut deepest = (f64::NEG_INFINITY, Vec3::z());
        let mut nearest: Option<(f64, Vec3)> = None;
        for face in &self.faces {
            let height = face.normal.dot(point) - face.at;
            if height > deepest.0 {
                deepest = (height, face.normal);
            }
            if height <= 0.0 {
                continue;
            }
            let offset = point - face.nearest(point, height);
            let square = offset.norm_squared();
            if nearest.is_none_or(|(least, _)| square < least) {
                nearest = Some((square, offset));
            }
        }
        let Some((square, offset)) = nearest else { return deepest };
        let distance = square.sqrt();
        // So near that the direction is lost, the face's own will do.
        (distance, offset.try_normalize(1e-12).unwrap_or(deepest.1))
    }

    /// Least signed distance of the points of a segment: a convex function along it, so that its
    /// tangents bound it from below.
    pub fn distance_to_segment(&self, a: &Vec3, b: &Vec3) -> f64 {
        const CLOSE_M: f64 = 1e-11;
        const MOST_LOOKS: usize = 60;
        let axis = b - a;
        let look = |s: f64| {
            let (distance, normal) = self.surface(&a.lerp(b, s));
            (s, distance, normal.dot(&axis))
        };
        let (mut low, mut high) = (look(0.0), look(1.0));
        if low.2 >= 0.0 {
            return low.1;
        }
        if high.2 <= 0.0 {
            return high.1;
        }
        let mut least = low.1.min(high.1);
        for _ in 0..MOST_LOOKS {
            let crossing = (high.1 - high.2 * high.0 - low.1 + low.2 * low.0) / (low.2 - high.2);
            if least - (low.1 + low.2 * (crossing - low.0)) < CLOSE_M {
                break;
            }
            let room = 0.02 * (high.0 - low.0);
            let next = look(crossing.clamp(low.0 + room, high.0 - room));
            least = least.min(next.1);
            if next.2 < 0.0 { low = next } else { high = next }
        }
        least
    }
}

impl Face {
    /// The point of the face nearest to one that is `height` above its plane.
    fn nearest(&self, point: &Vec3, height: f64) -> Vec3 {
        let foot = point - self.normal * height;
        let mut best: Option<(f64, Vec3)> = None;
        let count = self.corners.len();
        for i in 0..count {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % count]);
            let edge = b - a;
            // Corners run round the normal, so that the inside is on the left of an edge.
            if self.normal.cross(&edge).dot(&(foot - a)) >= 0.0 {
                continue;
            }
            let length = edge.norm_squared();
            let s =
                if length > 0.0 { ((foot - a).dot(&edge) / length).clamp(0.0, 1.0) } else { 0.0 };
            let there = a + edge * s;
            let square = (there - foot).norm_squared();
            if best.is_none_or(|(least, _)| square < least) {
                best = Some((square, there));
            }
        }
        best.map_or(foot, |(_, there)| there)
    }
}

/// The six faces of a box.
fn cuboid(low: &Vec3, high: &Vec3) -> Vec<Face> {
    let mut faces = Vec::with_capacity(6);
    for axis in 0..3 {
        for is_high in [false, true] {
            let mut normal = Vec3::zeros();
            normal[axis] = if is_high { 1.0 } else { -1.0 };
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |(on_u, on_v): (bool, bool)| {
                let mut c = if is_high { *high } else { *low };
                c[u] = if on_u { high[u] } else { low[u] };
                c[v] = if on_v { high[v] } else { low[v] };
                c
            };
            let mut corners =
                [(false, false), (true, false), (true, true), (false, true)].map(corner).to_vec();
            if !is_high {
                corners.reverse();
            }
            faces.push(Face { normal, at: normal.dot(&corners[0]), corners });
        }
    }
    faces
}

/// Cuts away what is above the plane `normal . x = at`.
fn clip(faces: &mut Vec<Face>, normal: Vec3, at: f64) {
    let is_cut = faces.iter().flat_map(|f| &f.corners).any(|c| normal.dot(c) > at + ONE_CORNER_M);
    if !is_cut {
        return;
    }
    let mut rim: Vec<Vec3> = Vec::new();
    let mut kept = Vec::with_capacity(faces.len() + 1);
    for face in faces.drain(..) {
        let count = face.corners.len();
        let mut corners: Vec<Vec3> = Vec::with_capacity(count + 1);
        let mut push = |c: Vec3, is_rim: bool| {
            if corners.last().is_none_or(|l: &Vec3| (l - c).norm() > ONE_CORNER_M) {
                corners.push(c);
            }
            if is_rim {
                rim.push(c);
            }
        };
        for i in 0..count {
            let (a, b) = (face.corners[i], face.corners[(i + 1) % count]);
            let (from, to) = (normal.dot(&a) - at, normal.dot(&b) - at);
            if from <= 0.0 {
                push(a, from == 0.0);
            }
            if from * to < 0.0 {
                push(a + (b - a) * (from / (from - to)), true);
            }
        }
        if corners.len() > 1 && (corners[0] - corners[corners.len() - 1]).norm() <= ONE_CORNER_M {
            corners.pop();
        }
        if corners.len() >= 3 {
            kept.push(Face { corners, ..face });
        }
    }
    let rim = around_normal(&rim, &normal);
    if rim.len() >= 3 {
        kept.push(Face { normal, at, corners: rim });
    }
    *faces = kept;
}

/// Points of a convex rim in the order in which they run round a normal, each once.
fn around_normal(rim: &[Vec3], normal: &Vec3) -> Vec<Vec3> {
    let Some(first) = rim.first() else { return Vec::new() };
    let middle = rim.iter().sum::<Vec3>() / rim.len() as f64;
    let Some(u) = (first - middle).try_normalize(1e-12) else { return Vec::new() };
    let v = normal.cross(&u);
    let angle = |c: &Vec3| (c - middle).dot(&v).atan2((c - middle).dot(&u));
    let mut sorted: Vec<(f64, Vec3)> = rim.iter().map(|c| (angle(c), *c)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut corners: Vec<Vec3> = Vec::with_capacity(sorted.len());
    for (_, c) in sorted {
        if corners.last().is_none_or(|l| (l - c).norm() > ONE_CORNER_M) {
            corners.push(c);
        }
    }
    if corners.len() > 1 && (corners[0] - corners[corners.len() - 1]).norm() <= ONE_CORNER_M {
        corners.pop();
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::super::triangles::tests::cuboid as mesh_box;
    use super::*;
    use crate::math::stream::{Purpose, normals as random, stream};
    use proptest::prelude::*;

    #[test]
    fn a_box_is_itself() {
        let mesh = mesh_box([-0.5, 0.0, 1.0], [0.5, 0.3, 1.2]);
        let body = Polytope::around(&mesh.triangles);
        assert!((body.volume() - 0.06).abs() < 3e-4, "{}", body.volume());
        let far = |x, y, z| body.surface(&Vec3::new(x, y, z)).0;
        assert!((far(0.0, 0.15, 2.0) - 0.8).abs() < 2e-4);
        assert!((far(1.5, 0.15, 1.1) - 1.0).abs() < 2e-4);
        assert!((far(0.0, 0.15, 1.1) + 0.1).abs() < 2e-4, "half as deep as it is high");
        // From a corner, the way over the diagonal.
        assert!((far(1.5, 1.3, 2.2) - 3.0f64.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn it_holds_all_points_and_a_flat_thing_has_a_thickness() {
        for index in 0..40 {
            let r = random(&mut stream(8, Purpose::Simulation, 0, index), 45);
            let at = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]);
            let triangles: Vec<Triangle> =
                (0..5).map(|i| [at(9 * i), at(9 * i + 3), at(9 * i + 6)]).collect();
            let body = Polytope::around(&triangles);
            assert!(triangles.iter().flatten().all(|c| body.surface(c).0 < 0.0));
            assert!(body.volume() > 0.0);
        }
        let flat = Polytope::around(&[[Vec3::zeros(), Vec3::x(), Vec3::y()]]);
        assert!((flat.surface(&Vec3::new(0.2, 0.2, 0.5)).0 - 0.5).abs() < 2e-4);
        let point = Polytope::around(&[[Vec3::x(); 3]]);
        assert!((point.surface(&Vec3::zeros()).0 - 1.0).abs() < 1e-3);
        assert!(Polytope::around(&[]).volume() < 1e-9);
    }

    #[test]
    fn the_gradient_leads_to_the_surface_and_half_spaces_hold_the_body() {
        for index in 0..60 {
            let r = random(&mut stream(9, Purpose::Simulation, 0, index), 30);
            let at = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]);
            let body = Polytope::around(&[
                [at(0), at(3), at(6)],
                [at(9), at(12), at(15)],
                [at(18), at(21), at(24)],
            ]);
            let p = 1.5 * at(27);
            let (d, normal) = body.surface(&p);
            assert!((normal.norm() - 1.0).abs() < 1e-9);
            assert!(body.surface(&(p - normal * d)).0.abs() < 1e-6, "{d}");
            assert!(body.support(&normal) >= normal.dot(&p) - d - 1e-9);
            assert!(d < 0.0 || body.support(&normal) <= normal.dot(&p) - d + 1e-9);
            assert!(body.least_distance(&p) <= d + 1e-12);
        }
    }

    proptest! {
        #[test]
        fn the_nearest_of_a_segment_is_found(v in prop::collection::vec(-1.0..1.0f64, 21), grown in 0.0..0.1f64) {
            let at = |i: usize| Vec3::new(v[i], v[i + 1], v[i + 2]);
            let body = Polytope::around(&[[at(0), at(3), at(6)], [at(9), at(12), at(0)]]).grown(grown);
            let (a, b) = (2.0 * at(15), 2.0 * at(18));
            let own = body.distance_to_segment(&a, &b);
            let brute = (0..=2000).map(|i| body.surface(&a.lerp(&b, f64::from(i) / 2000.0)).0).fold(f64::INFINITY, f64::min);
            prop_assert!(own <= brute + 1e-7, "{own} {brute}");
            prop_assert!(brute - own <= (b - a).norm() / 4000.0 + 1e-7);
        }

        #[test]
        fn it_moves_with_its_pose(v in prop::collection::vec(-1.0..1.0f64, 18)) {
            let at = |i: usize| Vec3::new(v[i], v[i + 1], v[i + 2]);
            let body = Polytope::around(&[[at(0), at(3), at(6)]]);
            let pose = Pose::new(at(9), at(12));
            let p = at(15);
            let there = pose.transform_point(&Point3::from(p)).coords;
            let (d, n) = body.surface(&p);
            let (moved, turned) = body.placed(&pose).surface(&there);
            prop_assert!((d - moved).abs() < 1e-9);
            // On the bisector between two faces either is right.
            prop_assert!((pose.rotation * n - turned).norm() < 1e-5 || d < 0.0);
        }
    }
}

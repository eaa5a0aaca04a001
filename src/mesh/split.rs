//! Cutting a bag of triangles by planes until its pieces are well held by simple shapes.

use super::polytope::normals;
use super::triangles::{Triangle, cut};
use crate::math::Vec3;

/// Even cuts along each direction.
const EVEN: usize = 6;
/// Cuts along each direction where the mesh has a face across it.
const AT_FACES: usize = 5;
/// Part of the width from its ends where no cut is tried.
const RIM: f64 = 0.02;
/// Cosine above which a face counts as across a direction.
const ACROSS: f64 = 0.999;

/// A piece: its triangles, and the half-spaces `sign * (normal . x - at) <= 0` that it was cut by.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub triangles: Vec<Triangle>,
    pub planes: Vec<(Vec3, f64)>,
    cost: f64,
}

/// How pieces are judged, and when it is enough.
pub(super) struct Rule<'a> {
    /// What a piece costs: the volume of the shape that holds it.
    pub cost: &'a dyn Fn(&[Triangle]) -> f64,
    /// Pieces of a piece that need no cut, such as bodies that do not touch; tried on what has been
    /// cut once at most.
    pub apart: &'a dyn Fn(&[Triangle]) -> Vec<Vec<Triangle>>,
    /// Directions across which cuts are made.
    pub directions: Vec<Vec3>,
    /// Most pieces.
    pub most: usize,
    /// Part of the whole's cost that a cut has to save.
    pub worth: f64,
}

/// A piece with the best way found to make several of it.
struct Open {
    piece: Piece,
    saved: f64,
    into: Vec<Piece>,
}

/// Cuts where it saves most, until nothing saves enough or there are enough pieces.
pub(super) fn split(triangles: &[Triangle], rule: &Rule) -> Vec<Piece> {
    let cost = (rule.cost)(triangles);
    let whole = Piece { triangles: triangles.to_vec(), planes: Vec::new(), cost };
    let enough = rule.worth * cost;
    let mut open = vec![rule.opened(whole)];
    loop {
        let room = rule.most + 1 - open.len();
        let best = (0..open.len())
            .filter(|&i| open[i].saved > enough && (2..=room).contains(&open[i].into.len()))
            .max_by(|&a, &b| open[a].saved.total_cmp(&open[b].saved));
        let Some(best) = best else { break };
        let into = open.swap_remove(best).into;
        open.extend(into.into_iter().map(|p| rule.opened(p)));
    }
    open.into_iter().map(|o| o.piece).collect()
}

impl Rule<'_> {
    fn piece(&self, triangles: Vec<Triangle>, planes: Vec<(Vec3, f64)>) -> Piece {
        let cost = (self.cost)(&triangles);
        Piece { triangles, planes, cost }
    }

    /// A side of a cut: one piece, or what of it does not touch.
    fn side(&self, triangles: Vec<Triangle>, planes: Vec<(Vec3, f64)>) -> Vec<Piece> {
        if planes.len() > 1 {
            return vec![self.piece(triangles, planes)];
        }
        let apart = (self.apart)(&triangles);
        if apart.len() < 2 {
            return vec![self.piece(triangles, planes)];
        }
        apart.into_iter().map(|t| self.piece(t, planes.clone())).collect()
    }

    fn opened(&self, piece: Piece) -> Open {
        let mut best = Open { saved: 0.0, into: Vec::new(), piece };
        let piece = best.piece.clone();
        let mut offer = |into: Vec<Piece>| {
            let saved = piece.cost - into.iter().map(|p| p.cost).sum::<f64>();
            if into.len() > 1 && saved > best.saved {
                (best.saved, best.into) = (saved, into);
            }
        };
        if piece.planes.is_empty() {
            offer(self.side(piece.triangles.clone(), Vec::new()));
        }
        for direction in &self.directions {
            for at in places(&piece.triangles, direction) {
                let (below, above) = cut(&piece.triangles, direction, at);
                if below.is_empty() || above.is_empty() {
                    continue;
                }
                let with = |normal: Vec3, at: f64| {
                    let mut planes = piece.planes.clone();
                    planes.push((normal, at));
                    planes
                };
                let mut into = self.side(below, with(*direction, at));
                into.extend(self.side(above, with(-direction, -at)));
                offer(into);
            }
        }
        best
    }
}

/// Where cuts across a direction are tried: evenly, and where the mesh has faces across it.
fn places(triangles: &[Triangle], direction: &Vec3) -> Vec<f64> {
    let heights = || triangles.iter().flatten().map(|c| direction.dot(c));
    let (low, high) =
        heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let width = high - low;
    if width.is_nan() || width <= 1e-6 {
        return Vec::new();
    }
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle;
        let across = (b - a).cross(&(c - a));
        let Some(normal) = across.try_normalize(1e-15) else { continue };
        if normal.dot(direction).abs() < ACROSS {
            continue;
        }
        let at = direction.dot(a);
        let has_room = steps.len() < 256;
        match steps.iter_mut().find(|(s, _)| (s - at).abs() < 2e-3 * width) {
            Some((_, area)) => *area += across.norm(),
            None if has_room => steps.push((at, across.norm())),
            None => {}
        }
    }
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let is_inside = |at: &f64| *at > low + RIM * width && *at < high - RIM * width;
    let at_faces = steps.into_iter().map(|s| s.0).filter(is_inside).take(AT_FACES);
    let even = (1..=EVEN).map(|i| low + width * i as f64 / (EVEN + 1) as f64);
    at_faces.chain(even).collect()
}

/// The world's axes, and the most frequent directions of the faces that are not along them.
pub(super) fn directions(triangles: &[Triangle]) -> Vec<Vec3> {
    let mut all = vec![Vec3::x(), Vec3::y(), Vec3::z()];
    for (normal, _) in normals(triangles).into_iter().take(12) {
        if all.len() < 6 && all.iter().all(|d| d.dot(&normal).abs() < ACROSS) {
            all.push(normal);
        }
    }
    all
}

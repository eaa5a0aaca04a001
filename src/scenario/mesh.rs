//! Obstacles that are meshes from CAD: read, in metres, placed, and in convex parts.

use super::file::{MeshUnits, ObstacleFile};
use super::source::Source;
use crate::files::InputError;
use crate::math::{Pose, Vec3};
use crate::mesh::{Mesh, MeshFile, Polytope, convex_parts, read_mesh};
use crate::physical::SHAPE_M;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Longest side below which a mesh is too small to be in a robot's way, m.
const SMALLEST_M: f64 = 0.005;

/// What is known of an obstacle that is a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshFacts {
    /// Name of the obstacle.
    pub name: String,
    /// Its file, as the scenario names it.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Triangles of the file.
    pub triangles: usize,
    /// Unit of its numbers.
    pub units: MeshUnits,
    /// Edge lengths of the box about it before it is turned, m.
    pub size_m: [f64; 3],
    /// Number of convex parts that stand for it.
    pub parts: usize,
    /// Farthest that a corner of a part is from the mesh, m.
    pub stands_out_m: f64,
}

/// An obstacle that is a mesh.
#[derive(Debug, Clone)]
pub struct ObstacleMesh {
    /// What is known of it.
    pub facts: MeshFacts,
    /// Convex parts that hold it, world, m.
    pub parts: Vec<Polytope>,
    /// The mesh in the world, m, for drawings: at most some ten thousand triangles.
    pub drawn: Mesh,
}

/// Triangles that are kept for drawings.
const MOST_DRAWN: usize = 16_000;
/// Triangles by which it is told how far parts stand out.
const MOST_COMPARED: usize = 4000;

impl MeshUnits {
    /// One of it, m.
    fn metres(self) -> f64 {
        match self {
            Self::Millimetres => 1e-3,
            Self::Centimetres => 1e-2,
            Self::Metres => 1.0,
            Self::Inches => 0.0254,
        }
    }

    /// As the scenario says it.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Millimetres => "mm",
            Self::Centimetres => "cm",
            Self::Metres => "m",
            Self::Inches => "in",
        }
    }

    const ALL: [Self; 4] = [Self::Millimetres, Self::Metres, Self::Inches, Self::Centimetres];
}

impl ObstacleMesh {
    /// Reads the file of an obstacle, and places it.
    pub(super) fn read(
        source: &Source,
        at: &Spanned<ObstacleFile>,
        (name, file): (&str, &str),
        (units, pose): (Option<MeshUnits>, &Pose),
    ) -> Result<Self, InputError> {
        let key = format!("obstacle `{name}`");
        let read = read_mesh(&source.folder.join(file)).map_err(|e| source.named(at, &key, e))?;
        let units = match units {
            Some(units) => units,
            None if read.is_in_metres => MeshUnits::Metres,
            None => return Err(source.error(at, needs_units(&key, file, &read)).remedy(UNITS)),
        };
        let MeshFile { mesh, is_y_up, sha256, .. } = read;
        let count = mesh.triangles.len();
        let mesh = upright(&mesh, is_y_up).scaled(&Vec3::repeat(units.metres()));
        let size = mesh.size();
        if let Some(doubt) = implausible(&size, units) {
            let error = source.error(at, format!("{key}: {file} {doubt}"));
            return Err(error.remedy(UNITS));
        }
        let placed = mesh.placed(pose);
        let (low, high) = placed.bounds();
        source
            .refuse_far(&format!("{key}: the lowest corner"), low.as_slice())
            .map_err(|e| source.at(at, e))?;
        source
            .refuse_far(&format!("{key}: the highest corner"), high.as_slice())
            .map_err(|e| source.at(at, e))?;
        // In its own frame, so that the parts do not depend on where the cell is.
        let (parts, _) = convex_parts(&mesh);
        let facts = MeshFacts {
            name: name.to_owned(),
            file: file.to_owned(),
            sha256,
            triangles: count,
            units,
            size_m: size.into(),
            parts: parts.len(),
            stands_out_m: stands_out(&parts, &mesh),
        };
        let parts = parts.iter().map(|p| p.placed(pose)).collect();
        Ok(Self { facts, parts, drawn: placed.thinned(MOST_DRAWN).0 })
    }
}

const UNITS: &str =
    "give units = \"mm\", \"cm\", \"m\" or \"in\": the unit of the program that wrote the file";

/// A mesh with z up.
fn upright(mesh: &Mesh, is_y_up: bool) -> Mesh {
    if is_y_up { mesh.mapped(|c| Vec3::new(c.x, -c.z, c.y)) } else { mesh.clone() }
}

fn sides(size: &Vec3) -> String {
    format!("{} x {} x {} m", rounded(size.x), rounded(size.y), rounded(size.z))
}

/// With three figures or so, as a length of a cell is read.
fn rounded(length: f64) -> String {
    match length {
        l if l >= 100.0 => format!("{l:.0}"),
        l if l >= 0.01 => format!("{l:.2}"),
        l => format!("{l:.5}"),
    }
}

fn is_plausible(size: &Vec3) -> bool {
    (SMALLEST_M..=SHAPE_M.high).contains(&size.max())
}

/// That the unit is not said, with what each would make of it.
fn needs_units(key: &str, file: &str, read: &MeshFile) -> String {
    let size = read.mesh.size();
    let as_units = |u: MeshUnits| (u, size * u.metres());
    let fitting = MeshUnits::ALL.map(as_units).into_iter().filter(|(_, s)| is_plausible(s));
    let all: Vec<String> =
        fitting.map(|(u, s)| format!("in {} it is {}", u.symbol(), sides(&s))).collect();
    format!("{key}: {file} does not say its unit: {}", all.join(", "))
}

/// That a mesh has a size that nothing in a cell has.
fn implausible(size: &Vec3, units: MeshUnits) -> Option<String> {
    if is_plausible(size) {
        return None;
    }
    let in_file = size / units.metres();
    let better = MeshUnits::ALL.into_iter().find(|u| is_plausible(&(in_file * u.metres())));
    let asks = better.map_or_else(
        || "is it the right file?".to_owned(),
        |u| {
            let size = sides(&(in_file * u.metres()));
            format!("is it in {}? That would be {size}", u.symbol())
        },
    );
    let longest = rounded(size.max());
    Some(format!("is {longest} m long with units = \"{}\": {asks}", units.symbol()))
}

/// Farthest that a corner of a part is from the mesh.
fn stands_out(parts: &[Polytope], mesh: &Mesh) -> f64 {
    let (few, moved) = mesh.thinned(MOST_COMPARED);
    let distance = |c: &Vec3| {
        let of = few.triangles.iter().map(|t| to_triangle(c, t));
        of.fold(f64::INFINITY, f64::min)
    };
    let mut corners: Vec<Vec3> = parts.iter().flat_map(Polytope::corners).copied().collect();
    corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    corners.dedup();
    corners.iter().map(distance).fold(0.0, f64::max) + moved
}

/// Distance of a point from a triangle, m.
fn to_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> f64 {
    let to_edge = |a: &Vec3, b: &Vec3| {
        let edge = b - a;
        let square = edge.norm_squared();
        let s = if square > 0.0 { ((p - a).dot(&edge) / square).clamp(0.0, 1.0) } else { 0.0 };
        (p - a - edge * s).norm()
    };
    let normal = (b - a).cross(&(c - a));
    if let Some(unit) = normal.try_normalize(1e-15) {
        let is_left = |a: &Vec3, b: &Vec3| (b - a).cross(&(p - a)).dot(&normal) >= 0.0;
        if is_left(a, b) && is_left(b, c) && is_left(c, a) {
            return (p - a).dot(&unit).abs();
        }
    }
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

//! The capsules of a robot's links: from the simple shapes of its description, fitted to its meshes, or
//! assumed where a mesh is missing.
//!
//! Assumed: capsules of one radius along the lines from the link's frame through its centre of mass to
//! the joints that hang on it. That is where a link roughly is; how thick it is, nobody said.

use super::description::RobotNote;
use super::mesh_files::find;
use crate::files::InputError;
use crate::kinematics::{JointKind, Link, LinkMesh, Linkage, Model};
use crate::math::Vec3;
use crate::mesh::{FittedCapsule, Mesh, MeshFile, fit_capsules, read_mesh};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Assumed radius of a link as a share of the stretched arm, and its bounds, m.
const RADIUS_SHARE: f64 = 0.05;
const RADIUS_M: (f64, f64) = (0.04, 0.12);
/// Lines shorter than this are a point, m.
const SHORT_M: f64 = 0.01;
/// Farthest that a centre of mass is taken for one, beyond the farthest joint on the link, m.
const CENTER_BEYOND_M: f64 = 0.3;
/// Largest link of a robot arm, m: what is larger has another unit.
const LARGEST_LINK_M: f64 = 5.0;

/// Why the shape of a mesh is not known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum MeshFault {
    /// There is no such file where the description could mean.
    NotFound,
    /// The file cannot be read.
    Unreadable {
        /// What its reader says.
        message: String,
    },
    /// It is so large that its unit is not the metre.
    TooLarge {
        /// Longest side, whole m.
        longest_m: u64,
    },
}

/// A mesh whose shape is not known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MissingMesh {
    /// As the description names it.
    pub file: String,
    /// Why.
    #[serde(flatten)]
    pub fault: MeshFault,
}

/// Links that stand as capsules of an assumed radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AssumedShapes {
    /// Names of the links.
    pub links: Vec<String>,
    /// The radius, m.
    pub radius_m: f64,
}

/// A capsule in the frame of its link: ends of the axis and radius, m.
pub(super) type LinkCapsule = (Vec3, Vec3, f64);

/// How well the capsules of a link are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    /// They stand in the description.
    Given,
    /// They were fitted to a mesh, and are somewhat thicker.
    Fitted,
    /// They are assumed.
    Assumed,
}

/// Where the shapes of a robot come from.
#[derive(Debug, Default)]
pub(super) struct LinkShapes {
    /// By link of the model; capsules that are not simple shapes of the description.
    pub capsules: Vec<Vec<(LinkCapsule, Known)>>,
    pub assumed: Option<AssumedShapes>,
    /// (address, SHA-256) of the meshes that were read.
    pub files: Vec<(String, String)>,
    pub notes: Vec<RobotNote>,
}

impl LinkShapes {
    /// Of the links below `base` of a model that was read from `path`.
    pub(super) fn of(path: &Path, model: &Model, base: &str, chain: &Linkage) -> Self {
        let is_below = |l: &&Link| Linkage::chain(model, base, &l.name).is_ok();
        let links: Vec<&Link> = model.links.iter().filter(is_below).collect();
        let read: Vec<Read> = links.par_iter().map(|link| Read::of(path, link)).collect();
        let mut shapes = Self { capsules: vec![Vec::new(); model.links.len()], ..Self::default() };
        let mut fitted = Fitted::default();
        let (mut assumed, mut missing) = (Vec::new(), Vec::new());
        let radius_m = assumed_radius(model, chain);
        for (link, found) in links.iter().zip(read) {
            let Some(index) = model.link_index(&link.name) else { continue };
            let own = &mut shapes.capsules[index];
            fitted.add(&link.name, &found);
            own.extend(found.capsules.iter().map(|c| ((c.a, c.b, c.radius), Known::Fitted)));
            let is_bare = own.is_empty() && link.shapes.is_empty();
            // A link without mass and without a mesh is a frame, and needs no shape.
            if !found.missing.is_empty() || (is_bare && link.mass_kg > 0.0) {
                let capsules = assumed_capsules(model, index, radius_m).into_iter();
                own.extend(capsules.map(|c| (c, Known::Assumed)));
                assumed.push(link.name.clone());
            }
            missing.extend(found.missing);
            shapes.files.extend(found.files);
        }
        shapes.notes.extend(fitted.note());
        if !assumed.is_empty() {
            let links = assumed.clone();
            shapes.notes.push(RobotNote::AssumedCapsules { links, radius_m, missing });
            shapes.assumed = Some(AssumedShapes { links: assumed, radius_m });
        }
        shapes
    }
}

/// What the meshes of one link give.
#[derive(Debug, Default)]
struct Read {
    capsules: Vec<FittedCapsule>,
    files: Vec<(String, String)>,
    missing: Vec<MissingMesh>,
}

impl Read {
    fn of(path: &Path, link: &Link) -> Self {
        let mut all = Self::default();
        for mesh in &link.meshes {
            match read(path, mesh) {
                Ok((read, sha256)) => {
                    all.capsules.extend(fit_capsules(&read));
                    all.files.push((mesh.file.clone(), sha256));
                }
                Err(fault) => {
                    all.missing.push(MissingMesh { file: mesh.file.clone(), fault });
                }
            }
        }
        all
    }
}

/// A mesh in the frame of its link, m, and the SHA-256 of its file.
fn read(urdf: &Path, mesh: &LinkMesh) -> Result<(Mesh, String), MeshFault> {
    let file = find(urdf, &mesh.file).ok_or(MeshFault::NotFound)?;
    let unreadable = |e: InputError| MeshFault::Unreadable { message: e.message().to_owned() };
    let MeshFile { mesh: read, sha256, .. } = read_mesh(&file).map_err(unreadable)?;
    let read = read.scaled(&mesh.scale);
    let longest = read.size().max();
    if longest.is_nan() || longest > LARGEST_LINK_M {
        return Err(MeshFault::TooLarge { longest_m: longest.min(1e15) as u64 });
    }
    Ok((read.placed(&mesh.pose), sha256))
}

/// Links whose meshes were read.
#[derive(Debug, Default)]
struct Fitted {
    links: Vec<String>,
    meshes: usize,
    capsules: usize,
}

impl Fitted {
    fn add(&mut self, link: &str, read: &Read) {
        if !read.files.is_empty() {
            self.links.push(link.to_owned());
            self.meshes += read.files.len();
            self.capsules += read.capsules.len();
        }
    }

    fn note(self) -> Option<RobotNote> {
        let Self { links, meshes, capsules } = self;
        (meshes > 0).then_some(RobotNote::FittedCapsules { links, meshes, capsules })
    }
}

/// Radius of links that nobody measured, m: in whole millimetres, from the length of the stretched arm.
fn assumed_radius(model: &Model, chain: &Linkage) -> f64 {
    let of = |name: &str| model.joints.iter().find(|j| j.name == name);
    let joints = chain.joints().iter().filter_map(|j| of(&j.name));
    let length: f64 = joints.map(|j| j.origin.translation.vector.norm()).sum();
    let radius = (RADIUS_SHARE * length).clamp(RADIUS_M.0, RADIUS_M.1);
    (1e3 * radius).round() / 1e3
}

/// From the link's frame through its centre of mass to the joints that hang on it.
fn assumed_capsules(model: &Model, link: usize, radius: f64) -> Vec<LinkCapsule> {
    let hanging = model.joints.iter().filter(|j| j.parent == link);
    // What slides begins somewhere along its way.
    let places: Vec<Vec3> = hanging
        .filter(|j| j.kind != JointKind::Unsupported)
        .map(|j| j.origin.translation.vector)
        .collect();
    let farthest = places.iter().map(Vec3::norm).fold(0.0, f64::max);
    let own = &model.links[link];
    let is_center = own.mass_kg > 0.0 && own.mass_center.norm() <= farthest + CENTER_BEYOND_M;
    let middle = if is_center { own.mass_center } else { Vec3::zeros() };
    let mut all = vec![(Vec3::zeros(), middle, radius)];
    all.extend(places.iter().map(|p| (middle, *p, radius)));
    all.retain(|(a, b, _)| (b - a).norm() > SHORT_M);
    if all.is_empty() {
        all.push((Vec3::zeros(), Vec3::zeros(), radius));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::body::{capsules, min_clearance};
    use super::super::clearance::Obstacle;
    use super::super::collide::random_posture;
    use super::super::{NotChecked, Robot};
    use super::*;
    use crate::math::Pose;
    use std::fmt::Write as _;

    /// A capsule as triangles, binary STL, in millimetres.
    fn stl((a, b, radius): LinkCapsule) -> Vec<u8> {
        let axis = (b - a).try_normalize(1e-9).unwrap_or(Vec3::z());
        let mut aside = Vec3::zeros();
        aside[axis.iamin()] = 1.0;
        let u = axis.cross(&aside).normalize();
        let v = axis.cross(&u);
        let rings: Vec<(Vec3, f64)> = (0..=16)
            .map(|i| {
                let angle = std::f64::consts::PI * f64::from(i) / 16.0;
                let end = if i < 8 { a } else { b };
                (end - axis * (radius * angle.cos()), radius * angle.sin())
            })
            .collect();
        let at = |ring: usize, side: u32| {
            let (middle, wide) = rings[ring];
            let (sin, cos) = (f64::from(side) / 20.0 * std::f64::consts::TAU).sin_cos();
            1e3 * (middle + (u * cos + v * sin) * wide)
        };
        let mut bytes = vec![b' '; 80];
        bytes.extend((16u32 * 20 * 2).to_le_bytes());
        for (ring, side) in (0..16).flat_map(|r| (0..20).map(move |s| (r, s))) {
            let [p, q] = [at(ring, side), at(ring, side + 1)];
            let [r, s] = [at(ring + 1, side), at(ring + 1, side + 1)];
            for t in [[p, q, s], [p, s, r]] {
                bytes.extend([0u8; 12]);
                t.iter().flatten().for_each(|c| bytes.extend((*c as f32).to_le_bytes()));
                bytes.extend([0u8; 2]);
            }
        }
        bytes
    }

    /// The shipped `ur10e` with its capsules as meshes in a package, of which `missing` are not there.
    fn mesh_robot(room: &Path, missing: &[&str]) -> Robot {
        let text = include_str!("../../models/robot/ur10e.urdf");
        let model = crate::kinematics::parse_urdf(Path::new("ur10e.urdf"), text).unwrap();
        let simple = Robot::preset("ur10e").unwrap();
        let folder = room.join("arm/meshes");
        std::fs::create_dir_all(&folder).unwrap();
        let mut out = "<robot name=\"meshes\">".to_owned();
        for link in &model.links {
            let own = simple.parts.iter().filter(|p| p.link == link.name);
            let mut shapes = String::new();
            for (i, part) in own.enumerate() {
                let file = format!("{}_{i}.stl", link.name);
                if !missing.contains(&link.name.as_str()) {
                    std::fs::write(folder.join(&file), stl(part.ends())).unwrap();
                }
                let _ = write!(
                    shapes,
                    "<collision><geometry><mesh filename=\"package://arm/meshes/{file}\" \
                     scale=\"0.001 0.001 0.001\"/></geometry></collision>"
                );
            }
            let _ = write!(out, "<link name=\"{}\">{shapes}</link>", link.name);
        }
        let joints = &text[text.find("<joint").unwrap()..];
        out += joints;
        let urdf = room.join("arm/arm.urdf");
        std::fs::write(&urdf, out).unwrap();
        Robot::from_urdf(&urdf, simple.linkage.base(), "tool0").unwrap()
    }

    fn wall(x: f64) -> [(String, Obstacle); 1] {
        let size = Vec3::new(0.1, 3.0, 3.0);
        [("wall".to_owned(), Obstacle::Box { pose: Pose::translation(x, 0.0, 1.0), size })]
    }

    #[test]
    fn fitted_capsules_hold_what_the_meshes_were_made_of() {
        let room = tempfile::tempdir().unwrap();
        let (fitted, simple) = (mesh_robot(room.path(), &[]), Robot::preset("ur10e").unwrap());
        assert_eq!(fitted.not_checked(), None);
        assert_eq!(fitted.assumed_shapes(), None);
        let is_fitted = |n: &RobotNote| matches!(n, RobotNote::FittedCapsules { links, .. } if links.len() == 7);
        assert!(fitted.notes.iter().any(is_fitted), "{:?}", fitted.notes);
        assert_eq!(fitted.meshes.len(), simple.parts.len());
        for sample in 0..60 {
            let q = random_posture(&simple.limits, 5, 0, sample);
            let wall = wall(0.2 + 0.02 * f64::from(sample));
            let own = min_clearance(&fitted, &q, &wall).unwrap().distance_m;
            let meant = min_clearance(&simple, &q, &wall).unwrap().distance_m;
            // The meshes lie within the capsules by a millimetre or so.
            assert!((own - meant).abs() < 0.012, "{sample}: {own} instead of {meant}");
        }
        // Home touches nothing, and the arm can be judged against itself.
        assert!(
            matches!(fitted.self_check(), crate::robot::SelfCheck::Checked { pairs, .. } if pairs > 3)
        );
        let near =
            super::super::self_clearance(&fitted, &[0.0], std::slice::from_ref(&fitted.home));
        assert!(near.unwrap().distance_m > 0.0);
    }

    #[test]
    fn missing_meshes_are_assumed_and_a_wall_across_the_arm_is_found() {
        let room = tempfile::tempdir().unwrap();
        let all: Vec<String> =
            Robot::preset("ur10e").unwrap().parts.iter().map(|p| p.link.clone()).collect();
        let missing: Vec<&str> = all.iter().map(String::as_str).collect();
        let robot = mesh_robot(room.path(), &missing);
        let shapes = robot.assumed_shapes().unwrap();
        assert_eq!(shapes.links.len(), 7);
        assert!((0.06..0.12).contains(&shapes.radius_m), "{shapes:?}");
        let near = min_clearance(&robot, &[0.0; 6], &wall(0.6)).unwrap();
        assert!(near.distance_m < 0.0, "{near:?}");
        assert!(robot.meshes.is_empty());
    }

    #[test]
    fn the_shared_robots_are_never_blind() {
        for (file, base, tcp) in [
            ("panda", "panda_link0", "panda_hand_tcp"),
            ("ur5_robot", "base_link", "tool0"),
            ("ur10_robot", "base_link", "tool0"),
            ("xarm7", "link_base", "link7"),
            ("kinova", "j2s6s200_link_base", "j2s6s200_end_effector"),
            ("tiago", "torso_lift_link", "arm_7_link"),
        ] {
            let name = format!("models/robots/{file}.urdf");
            let Some(path) = crate::skips::shared(&name) else { return };
            let robot = Robot::from_urdf(&path, base, tcp).unwrap();
            assert_eq!(robot.not_checked(), None::<NotChecked>, "{file}");
            assert!(robot.assumed_shapes().is_some(), "{file}: its meshes are not there");
            // A wall through the middle of the stretched arm touches it wherever it reaches.
            let q = vec![0.0; robot.dof()];
            let ends: Vec<Vec3> = capsules(&robot, &q).iter().flat_map(|c| [c.a, c.b]).collect();
            let mid = 0.5
                * (ends.iter().map(|e| e.z).fold(f64::NEG_INFINITY, f64::max)
                    + ends.iter().map(|e| e.z).fold(f64::INFINITY, f64::min));
            let slab = Obstacle::Box {
                pose: Pose::translation(0.0, 0.0, mid),
                size: Vec3::new(9.0, 9.0, 0.02),
            };
            let touched = min_clearance(&robot, &q, &[("slab".to_owned(), slab)]).unwrap();
            assert!(touched.distance_m < 0.0, "{file}: {touched:?}");
            let own =
                super::super::self_clearance(&robot, &[0.0], std::slice::from_ref(&robot.home));
            assert!(own.is_none_or(|o| o.distance_m > 0.0), "{file}: home touches itself");
        }
    }
}

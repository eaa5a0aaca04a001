//! The immutable description of an articulated body: a tree of links and joints.

use crate::math::{Pose, Vec3};
use thiserror::Error;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis (rad).
    Revolute,
    /// Slides along its axis (m).
    Prismatic,
    /// Does not move.
    Fixed,
    /// A kind that chains cannot use (floating, planar, spherical).
    Unsupported,
}

/// A joint whose position follows another: `multiplier * source + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that leads.
    pub source: String,
    /// Factor, rad/rad or m/rad.
    pub multiplier: f64,
    /// Position when the source is at zero, rad or m.
    pub offset: f64,
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Pose of the joint frame in the parent link's frame at position zero.
    pub origin: Pose,
    /// Axis in the joint frame: a unit vector, or of a sliding joint the metres of a coordinate of one.
    pub axis: Vec3,
    /// Lower limit, rad or m; minus infinity for continuous joints.
    pub lower: f64,
    /// Upper limit, rad or m; infinity for continuous joints.
    pub upper: f64,
    /// Velocity limit, rad/s or m/s; infinity if the file gives none.
    pub velocity: f64,
    /// Acceleration limit, rad/s^2 or m/s^2; infinity if the file gives none.
    pub acceleration: f64,
    /// Set for a joint that follows another.
    pub mimic: Option<Mimic>,
}

/// A collision shape, fixed to its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// All points within `radius` (m) of the segment of `length` (m) along z about the origin. A
    /// cylinder becomes the capsule around its axis, which holds it except for the rims.
    Capsule {
        /// Radius, m.
        radius: f64,
        /// Length of the axis, m.
        length: f64,
    },
    /// A ball of `radius` (m).
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// A box with these full edge lengths (m).
    Cuboid {
        /// Edge lengths, m.
        size: Vec3,
    },
}

/// A mesh file that gives a link its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMesh {
    /// The file as the description names it: a path, or an address such as `package://..`.
    pub file: String,
    /// Pose of the mesh in the link's frame.
    pub pose: Pose,
    /// Factors along the axes of the mesh, from its numbers to metres.
    pub scale: Vec3,
}

/// A rigid segment.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Unique name; may hold spaces.
    pub name: String,
    /// Mass, kg; 0 for a link that is only a frame.
    pub mass_kg: f64,
    /// Centre of mass in the link's frame, m.
    pub mass_center: Vec3,
    /// Simple collision shapes with their poses in the link's frame.
    pub shapes: Vec<(Pose, Shape)>,
    /// Collision meshes; where a link has no collision shape at all, the meshes that it is drawn by.
    pub meshes: Vec<LinkMesh>,
    /// Index of the joint whose child this link is; none for the root.
    pub parent_joint: Option<usize>,
}

/// A tree of links. Made by [`crate::kinematics::read_urdf`]; never changes afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The name in the file.
    pub name: String,
    /// All links, in file order.
    pub links: Vec<Link>,
    /// All joints, in file order.
    pub joints: Vec<Joint>,
    /// What was odd about the file but could be handled, one sentence each.
    pub warnings: Vec<String>,
}

/// Why links and joints do not make a model.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ModelError {
    /// Two links or two joints share a name.
    #[error("{what} `{name}` is defined twice")]
    Duplicate {
        /// "link" or "joint".
        what: &'static str,
        /// The shared name.
        name: String,
    },
    /// A link is the child of two joints.
    #[error("link `{link}` is the child of two joints, `{first}` and `{second}`")]
    TwoParents {
        /// The child.
        link: String,
        /// One joint.
        first: String,
        /// The other.
        second: String,
    },
    /// The links form a loop or several trees.
    #[error("{0}")]
    NotATree(String),
    /// A mimic joint names a joint that does not exist.
    #[error("joint `{joint}` mimics `{source_joint}`, which does not exist")]
    UnknownMimic {
        /// The follower.
        joint: String,
        /// The missing leader.
        source_joint: String,
    },
}

impl Model {
    /// Checks that links and joints form one tree with unique names, and sets each link's
    /// `parent_joint`.
    pub fn new(
        name: String,
        mut links: Vec<Link>,
        joints: Vec<Joint>,
        warnings: Vec<String>,
    ) -> Result<Self, ModelError> {
        unique("link", links.iter().map(|l| l.name.as_str()))?;
        unique("joint", joints.iter().map(|j| j.name.as_str()))?;
        for (i, joint) in joints.iter().enumerate() {
            if let Some(first) = links[joint.child].parent_joint.replace(i) {
                return Err(ModelError::TwoParents {
                    link: links[joint.child].name.clone(),
                    first: joints[first].name.clone(),
                    second: joint.name.clone(),
                });
            }
            if let Some(mimic) = &joint.mimic
                && !joints.iter().any(|j| j.name == mimic.source)
            {
                return Err(ModelError::UnknownMimic {
                    joint: joint.name.clone(),
                    source_joint: mimic.source.clone(),
                });
            }
        }
        let model = Self { name, links, joints, warnings };
        model.check_tree()?;
        Ok(model)
    }

    fn check_tree(&self) -> Result<(), ModelError> {
        let not_a_tree = |text: String| Err(ModelError::NotATree(text));
        let roots: Vec<&str> = self
            .links
            .iter()
            .filter(|l| l.parent_joint.is_none())
            .map(|l| l.name.as_str())
            .collect();
        for start in 0..self.links.len() {
            let mut at = start;
            let mut steps = 0;
            while let Some(j) = self.links[at].parent_joint {
                at = self.joints[j].parent;
                steps += 1;
                if steps > self.links.len() {
                    let name = &self.links[start].name;
                    return not_a_tree(format!("the joints above link `{name}` form a loop"));
                }
            }
        }
        match roots.as_slice() {
            [_] => Ok(()),
            [] => not_a_tree("there is no link".to_owned()),
            many => not_a_tree(format!(
                "{} links have no parent joint, one is allowed: {}",
                many.len(),
                many.join(", ")
            )),
        }
    }

    /// Index of the link with this name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l.name == name)
    }

    /// Name of the root link.
    pub fn root(&self) -> &str {
        self.links.iter().find(|l| l.parent_joint.is_none()).map_or("", |l| &l.name)
    }
}

fn unique<'a>(what: &'static str, names: impl Iterator<Item = &'a str>) -> Result<(), ModelError> {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(ModelError::Duplicate { what, name: name.to_owned() });
        }
    }
    Ok(())
}

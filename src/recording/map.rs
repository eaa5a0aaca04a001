//! A map: which markers of a file, or points or columns of a table, make the segments of a person.
//!
//! ```text
//! C3D, TRC, table ─► places of points over time ─ gaps filled, runs ─ joints and directions ─► Recording
//! OpenSim, table ─► columns over time ─ poses, or turns of one segment in another (on a body) ─► Recording
//! ```
//! Of markers a segment is placed by its proximal joint centre, and turned by two directions: one that is kept
//! as it is, and one that only says how the segment is turned about the first.

mod columns;
mod file;
mod fill;
mod parts;
mod remarks;
mod runs;
#[cfg(test)]
mod tests;
mod vertical;

pub(super) use columns::{BODY, ByColumns, ColumnPart};
pub use file::{MAP_SCHEMA, Map, read_map};
pub(super) use file::{PERSON, TableMap};
pub use runs::Run;
pub(super) use runs::{Origin, runs};
pub(super) use vertical::vertical;

/// Axes of a segment by what a map calls them: x, y and z.
const AXES: [&str; 3] = ["ahead", "up", "right"];
/// What makes a name that of a joint centre, not of a marker.
const JOINT_OF: &str = "joint of ";
/// What makes a direction that of another segment.
const AS: &str = "as ";

/// A point of a map.
#[derive(Debug, Clone, PartialEq)]
enum Point {
    Marker(String),
    /// The joint centre of a segment.
    Joint(String),
}

/// The mean of some points.
type Mean = Vec<Point>;

/// Where a direction comes from.
#[derive(Debug, Clone, PartialEq)]
enum Source {
    /// From the first place to the second.
    Between([Mean; 2]),
    /// Square to the plane of three places, such that a limb along them bends forwards about it.
    Hinge([Mean; 3]),
    /// The same axis of another segment.
    As(String),
}

/// A direction that is an axis of a segment.
#[derive(Debug, Clone, PartialEq)]
struct Direction {
    /// 0, 1, 2: ahead, up, right.
    axis: usize,
    source: Source,
}

/// How a segment is made of points.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    name: String,
    joint: Mean,
    /// From the mean of the points to the joint centre, m.
    offset_m: crate::math::Vec3,
    /// The segment whose axes the offset is told in; none: its own.
    offset_in: Option<String>,
    /// A direction along which the joint centre lies besides, and how far, m.
    offset_along: Option<(Source, f64)>,
    /// Turn from the axes of the directions to those of the segment, about its own axes.
    turn: nalgebra::UnitQuaternion<f64>,
    /// The axis that is kept.
    exact: Direction,
    /// The axis that is nearly that direction.
    near: Direction,
    /// Whether it is left out where a file lacks its points.
    optional: bool,
}

impl Source {
    fn means(&self) -> &[Mean] {
        match self {
            Self::Between(means) => means,
            Self::Hinge(means) => means,
            Self::As(_) => &[],
        }
    }
}

impl Part {
    fn sources(&self) -> impl Iterator<Item = &Source> {
        let along = self.offset_along.as_ref().map(|(source, _)| source);
        [&self.exact.source, &self.near.source].into_iter().chain(along)
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        self.joint.iter().chain(self.sources().flat_map(Source::means).flatten())
    }

    /// Names of the markers that it is made of.
    fn markers(&self) -> impl Iterator<Item = &str> {
        self.points().filter_map(|point| match point {
            Point::Marker(name) => Some(name.as_str()),
            Point::Joint(_) => None,
        })
    }

    /// Names of the segments that must be known before.
    fn needs(&self) -> impl Iterator<Item = &str> {
        let joints = self.points().filter_map(|point| match point {
            Point::Joint(name) => Some(name.as_str()),
            Point::Marker(_) => None,
        });
        let alike = self.sources().filter_map(|source| match source {
            Source::As(name) => Some(name.as_str()),
            _ => None,
        });
        joints.chain(alike).chain(self.offset_in.as_deref())
    }
}

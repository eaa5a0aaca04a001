//! The moving scene of a run: the cell, the robot and the worker over time, small enough for a page.

use crate::human::{Head, Mannequin, MannequinPiece, SegmentKind};
use crate::math::{Pose, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What stands still, and the motions along the reported paths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Corners of the box that the TCP may not leave, world, m.
    pub workspace_m: Option<[[f64; 3]; 2]>,
    /// Obstacles with their true shapes.
    pub obstacles: Vec<SceneObstacle>,
    /// One motion for each reported path, by rank.
    pub motions: Vec<SceneMotion>,
}

/// An obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneObstacle {
    /// Its name.
    pub name: String,
    /// Its shape.
    #[serde(flatten)]
    pub shape: SceneShape,
}

/// A shape in the world, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case")]
pub enum SceneShape {
    /// Edges along the axes of its own frame.
    Box {
        /// Middle.
        center_m: [f64; 3],
        /// World from box: w, x, y, z.
        quaternion_wxyz: [f64; 4],
        /// Full edge lengths.
        size_m: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Middle.
        center_m: [f64; 3],
        /// Radius.
        radius_m: f64,
    },
    /// All points within the radius of a segment.
    Capsule {
        /// Ends of the segment.
        ends_m: [[f64; 3]; 2],
        /// Radius.
        radius_m: f64,
    },
    /// Axis along z of its own frame.
    Cylinder {
        /// Middle.
        center_m: [f64; 3],
        /// World from cylinder: w, x, y, z.
        quaternion_wxyz: [f64; 4],
        /// Radius.
        radius_m: f64,
        /// Full length.
        length_m: f64,
    },
    /// Triangles, fewer than the mesh has that they are drawn for.
    Mesh {
        /// Corners in whole millimetres.
        points_mm: Vec<[i32; 3]>,
        /// Indices of the corners.
        triangles: Vec<[u32; 3]>,
    },
}

/// Robot and worker along one path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneMotion {
    /// Id of the path.
    pub candidate: String,
    /// The moments, as indices into the times of the path.
    pub samples: Vec<usize>,
    /// Capsules around the robot's links; none when the robot cannot follow.
    pub robot: Option<SceneRobot>,
    /// People of each body size.
    pub people: Vec<ScenePeople>,
}

/// A robot as capsules.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneRobot {
    /// The capsules, with points of `track`.
    pub capsules: Vec<SceneCapsule>,
    /// The points over time.
    pub track: Track,
}

/// The repetitions of one body size along one path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenePeople {
    /// Name of the body.
    pub body: String,
    /// The pieces of the mannequin, with points of the tracks.
    pub capsules: Vec<SceneCapsule>,
    /// The repetition whose joint angles are nearest to the mean of all at all moments: the one with
    /// the least sum of squared distances to the others. None when no repetition reaches the start.
    pub typical: Option<Walker>,
    /// Up to eight repetitions, spread evenly over their ranking by time mean of RULA, lowest first.
    pub ghosts: Vec<Walker>,
}

/// One repetition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Walker {
    /// Number of the repetition, from 0.
    pub rollout: usize,
    /// RULA of the coupled side at each moment that the hand reached; nothing is drawn later.
    pub rula: Vec<u8>,
    /// REBA at the same moments.
    pub reba: Vec<u8>,
    /// The points at the same moments.
    pub track: Track,
}

/// A capsule between two points, which may taper and be wider in one direction.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneCapsule {
    /// Indices of the points.
    pub ends: [usize; 2],
    /// Radius at each end, mm.
    pub radii_mm: [u32; 2],
    /// The other radii of a section that is no circle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wide: Option<SceneWidth>,
    /// What of a person it is; none for a robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<SegmentKind>,
}

impl SceneCapsule {
    /// Whether all its points are among so many.
    pub fn fits(&self, points: usize) -> bool {
        let toward = self.wide.iter().flat_map(|w| &w.toward);
        self.ends.iter().chain(toward).all(|&i| i < points)
    }
}

/// Radii in the direction of a point.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneWidth {
    /// Index of the point towards which it is measured, for each end.
    pub toward: [usize; 2],
    /// Radius in that direction at each end, mm.
    pub radii_mm: [u32; 2],
}

/// A person as a mannequin in one posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosedMannequin {
    /// Points in the world, m.
    pub points_m: Vec<[f64; 3]>,
    /// The pieces between them.
    pub capsules: Vec<SceneCapsule>,
}

impl PosedMannequin {
    /// A mannequin in the posture of its coupled chain, for the rest frame in the world.
    pub fn of(mannequin: &Mannequin, rest: &Pose, q: &[f64], head: Head) -> Self {
        let points = mannequin.place(rest, q, head);
        Self {
            // Whole millimetres are enough for a picture.
            points_m: points
                .into_iter()
                .map(|p| p.map(|c| (1e3 * c).round() / 1e3).into())
                .collect(),
            capsules: mannequin.pieces().iter().map(Into::into).collect(),
        }
    }
}

fn whole_mm(radii_m: [f64; 2]) -> [u32; 2] {
    radii_m.map(|r| (1e3 * r).round() as u32)
}

impl From<&MannequinPiece> for SceneCapsule {
    fn from(piece: &MannequinPiece) -> Self {
        let wide = piece.wide.as_ref();
        Self {
            ends: piece.ends,
            radii_mm: whole_mm(piece.radii_m),
            wide: wide.map(|w| SceneWidth { toward: w.toward, radii_mm: whole_mm(w.radii_m) }),
            kind: Some(piece.kind),
        }
    }
}

/// Points over time in whole millimetres, world, as text: for each point its x, y and z, each ended by
/// `;`. A coordinate is its first value and then its changes from moment to moment, separated by
/// spaces; changes of zero at the end are left out.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Track(String);

/// A point at every moment, mm.
type Series = [Vec<i64>; 3];

/// Points over time before they are written.
#[derive(Debug, Clone)]
pub(super) struct Points(Vec<Series>);

impl Points {
    /// From the points (m, world) of each moment; all moments have the same number of them.
    pub(super) fn of(moments: &[Vec<Vec3>]) -> Self {
        let count = moments.first().map_or(0, Vec::len);
        let axis = |p: usize, a: usize| -> Vec<i64> {
            moments.iter().map(|m| (1e3 * m[p][a]).round() as i64).collect()
        };
        Self((0..count).map(|p| [0, 1, 2].map(|a| axis(p, a))).collect())
    }

    /// The track of all points.
    pub(super) fn whole(&self) -> Track {
        self.track(&(0..self.0.len()).collect::<Vec<_>>())
    }

    fn track(&self, kept: &[usize]) -> Track {
        let mut text = String::new();
        for axis in kept.iter().flat_map(|&p| &self.0[p]) {
            let mut before = 0;
            let end = axis.windows(2).rposition(|w| w[0] != w[1]).map_or(1, |i| i + 2);
            for (i, value) in axis.iter().take(end).enumerate() {
                let space = if i == 0 { "" } else { " " };
                // Writing to a string cannot fail.
                let _ = write!(text, "{space}{}", value - before);
                before = *value;
            }
            text.push(';');
        }
        Track(text)
    }
}

/// Capsules and tracks of several motions of one thing whose points are pairs of capsule ends (m).
/// Ends that lie together in all motions, as at a joint, become one point.
pub(super) fn joined(motions: &[Points], radii_m: &[f64]) -> (Vec<SceneCapsule>, Vec<Track>) {
    let mut known: BTreeMap<Vec<&Series>, usize> = BTreeMap::new();
    let mut kept = Vec::new();
    let mut place = |end: usize| {
        let key = motions.iter().filter_map(|m| m.0.get(end)).collect();
        *known.entry(key).or_insert_with(|| {
            kept.push(end);
            kept.len() - 1
        })
    };
    let capsules = (radii_m.iter().enumerate())
        .map(|(i, radius)| SceneCapsule {
            ends: [place(2 * i), place(2 * i + 1)],
            radii_mm: whole_mm([*radius; 2]),
            wide: None,
            kind: None,
        })
        .collect();
    (capsules, motions.iter().map(|m| m.track(&kept)).collect())
}

impl Track {
    /// The points (mm) at each of `moments` moments.
    pub fn points_mm(&self, moments: usize) -> Vec<Vec<[i64; 3]>> {
        let axis = |text: &str| -> Vec<i64> {
            let mut changes = text.split(' ').map(|v| v.parse().unwrap_or(0));
            let add = |sum: &mut i64, _| {
                *sum = sum.saturating_add(changes.next().unwrap_or(0));
                Some(*sum)
            };
            (0..moments).scan(0, add).collect()
        };
        let axes: Vec<Vec<i64>> = self.0.split_terminator(';').map(axis).collect();
        (0..moments)
            .map(|k| axes.chunks_exact(3).map(|p| [p[0][k], p[1][k], p[2][k]]).collect())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn a_track_gives_the_points_back() {
        let moments: Vec<Vec<Vec3>> = (0..7)
            .map(|k| {
                let r = normals(&mut stream(1, Purpose::Simulation, 0, k), 9);
                // The last point stands still.
                vec![
                    Vec3::new(r[0], r[1], r[2]),
                    Vec3::new(r[3], 0.5, r[4]),
                    Vec3::new(1.0, -2.0, 0.0),
                ]
            })
            .collect();
        let points = Points::of(&moments);
        let track = points.track(&[0, 1, 2]);
        assert!(track.0.ends_with("1000;-2000;0;"), "{}", track.0);
        for (read, meant) in track.points_mm(7).iter().zip(&moments) {
            for (a, b) in read.iter().zip(meant) {
                let far = (0..3).map(|i| (a[i] as f64 / 1e3 - b[i]).abs()).fold(0.0, f64::max);
                assert!(far <= 0.5e-3 + 1e-12);
            }
        }
    }

    #[test]
    fn ends_at_a_joint_become_one_point() {
        let at = |x: f64| Vec3::new(x, 0.0, 0.0);
        // Two bones in a row; a third whose end lies on the joint in the first motion only.
        let one = Points::of(&[vec![at(0.0), at(1.0), at(1.0), at(2.0), at(1.0), at(3.0)]]);
        let two = Points::of(&[vec![at(0.1), at(1.0), at(1.0), at(2.0), at(1.5), at(3.0)]]);
        let (capsules, tracks) = joined(&[one, two], &[0.05, 0.04, 0.03]);
        let ends: Vec<[usize; 2]> = capsules.iter().map(|c| c.ends).collect();
        assert_eq!(ends, [[0, 1], [1, 2], [3, 4]]);
        assert_eq!(capsules[1].radii_mm, [40; 2]);
        assert_eq!(tracks[1].points_mm(1)[0][3], [1500, 0, 0]);
    }
}

//! How near an arm comes to itself and to obstacles along a motion, or why that is not known.

use super::body::Nearest;
use super::check::{Extreme, RobotMotion};
use super::collide::{SelfNearest, SelfPairs};
use super::description::{Assumed, Robot, RobotNote};
use super::link_shapes::AssumedShapes;
use serde::{Deserialize, Serialize};

/// Why a distance from the robot's links was not checked. Neither kept nor broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "because", rename_all = "snake_case")]
pub enum NotChecked {
    /// No link has a collision shape.
    NoShapes,
    /// Too few links have one.
    TooFewShapes,
    /// The shapes of links are assumed, too coarsely for this.
    AssumedShapes,
    /// The robot does not follow the path.
    NoMotion,
}

impl Default for SelfClearance {
    fn default() -> Self {
        Self::NotChecked { why: NotChecked::NoMotion }
    }
}

impl Default for ObstacleClearance {
    fn default() -> Self {
        Self::NotChecked { why: NotChecked::NoMotion }
    }
}

/// How near the arm comes to itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "self_clearance", rename_all = "snake_case")]
pub enum SelfClearance {
    /// The least distance.
    Least {
        /// How near, and which links.
        nearest: SelfNearest,
        /// Whether links of the robot stand as capsules of an assumed radius.
        #[serde(default)]
        is_assumed: bool,
    },
    /// Nobody looked.
    NotChecked {
        /// Why.
        why: NotChecked,
    },
}

/// How near the arm comes to obstacles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "obstacle_clearance", rename_all = "snake_case")]
pub enum ObstacleClearance {
    /// The least distance.
    Least {
        /// How near, and what meets what.
        nearest: Nearest,
        /// Whether links of the robot stand as capsules of an assumed radius.
        #[serde(default)]
        is_assumed: bool,
    },
    /// No obstacle was given.
    NoObstacle,
    /// Nobody looked.
    NotChecked {
        /// Why.
        why: NotChecked,
    },
}

/// What of the arm's collision with itself can be checked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "self_check", rename_all = "snake_case")]
pub enum SelfCheck {
    /// Some pairs of links.
    Checked {
        /// Number of pairs of links.
        pairs: usize,
        /// Pairs that are left out because their capsules touch in nearly every posture.
        left_out: Vec<[String; 2]>,
    },
    /// Nothing.
    NotChecked {
        /// Why.
        why: NotChecked,
    },
}

/// How near a motion comes to the limits of the joints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotMargins {
    /// Largest speed as a share of its limit.
    pub speed: Extreme,
    /// Largest acceleration as a share of its limit.
    pub acceleration: Extreme,
    /// Smallest distance to a position limit, rad or m.
    pub range: Extreme,
    /// Smallest singular value of the TCP Jacobian, rotation scaled by 0.3 m; m/rad.
    pub min_singular_value: f64,
}

/// A robot as the reader of a result should know it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotFacts {
    /// Its name.
    pub name: String,
    /// What is a stand-in or from memory.
    pub assumed: Vec<Assumed>,
    /// Remarks about its description.
    pub notes: Vec<RobotNote>,
    /// What of its collision with itself is checked.
    pub self_check: SelfCheck,
    /// Why distances from its links to obstacles and people cannot be checked; none where they can.
    pub not_checked: Option<NotChecked>,
    /// Links that are checked as capsules of an assumed radius; none where all shapes are known.
    #[serde(default)]
    pub assumed_shapes: Option<AssumedShapes>,
}

impl RobotMotion {
    /// How near it comes to the limits of the joints.
    pub fn margins(&self) -> RobotMargins {
        RobotMargins {
            speed: self.qd_share.clone(),
            acceleration: self.qdd_share.clone(),
            range: self.position_margin.clone(),
            min_singular_value: self.min_singular_value,
        }
    }
}

impl Robot {
    /// Why distances from its links cannot be checked; none where a link that moves has a shape.
    pub fn not_checked(&self) -> Option<NotChecked> {
        if self.parts.iter().any(|p| p.is_moving) {
            return None;
        }
        let is_empty = self.parts.is_empty();
        Some(if is_empty { NotChecked::NoShapes } else { NotChecked::TooFewShapes })
    }

    /// Links whose shapes are not known, and which are checked as capsules of an assumed radius.
    pub fn assumed_shapes(&self) -> Option<&AssumedShapes> {
        self.assumed_shapes.as_ref()
    }

    /// Name and SHA-256 of every file that the robot was read from, unless it ships with ergopath: its description,
    /// then the meshes to which capsules were fitted.
    pub fn files(&self) -> impl Iterator<Item = &(String, String)> {
        self.own_file.iter().chain(&self.meshes)
    }

    /// What of the arm's collision with itself is checked.
    pub fn self_check(&self) -> SelfCheck {
        let SelfPairs { checked, left_out } = &self.self_pairs;
        if checked.is_empty() {
            let few = match self.assumed_shapes {
                Some(_) => NotChecked::AssumedShapes,
                None => NotChecked::TooFewShapes,
            };
            let why = self.not_checked().unwrap_or(few);
            return SelfCheck::NotChecked { why };
        }
        let mut links: Vec<(&str, &str)> = Vec::new();
        for &(i, j) in checked {
            let pair = (self.parts[i].link.as_str(), self.parts[j].link.as_str());
            if !links.contains(&pair) {
                links.push(pair);
            }
        }
        let left_out = left_out.iter().map(|(a, b)| [a.clone(), b.clone()]).collect();
        SelfCheck::Checked { pairs: links.len(), left_out }
    }

    /// How near the arm comes to itself along a motion that has been graded.
    pub fn self_clearance(&self, motion: Option<&RobotMotion>) -> SelfClearance {
        if let SelfCheck::NotChecked { why } = self.self_check() {
            return SelfClearance::NotChecked { why };
        }
        match motion.and_then(|m| m.self_nearest.as_deref()) {
            Some(nearest) => SelfClearance::Least {
                nearest: nearest.clone(),
                is_assumed: self.assumed_shapes.is_some(),
            },
            None => SelfClearance::NotChecked { why: NotChecked::NoMotion },
        }
    }

    /// How near the arm comes to obstacles along a motion that has been graded among `obstacles`.
    pub fn obstacle_clearance(
        &self,
        motion: Option<&RobotMotion>,
        obstacles: usize,
    ) -> ObstacleClearance {
        if obstacles == 0 {
            return ObstacleClearance::NoObstacle;
        }
        match motion.and_then(|m| m.obstacle_nearest.as_deref()) {
            Some(nearest) => ObstacleClearance::Least {
                nearest: nearest.clone(),
                is_assumed: self.assumed_shapes.is_some(),
            },
            None => ObstacleClearance::NotChecked {
                why: self.not_checked().unwrap_or(NotChecked::NoMotion),
            },
        }
    }

    /// What the reader of a result should know of it.
    pub fn facts(&self) -> RobotFacts {
        RobotFacts {
            name: self.name.clone(),
            assumed: self.assumed(),
            notes: self.notes.clone(),
            self_check: self.self_check(),
            not_checked: self.not_checked(),
            assumed_shapes: self.assumed_shapes.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::link_shapes::MeshFault;
    use super::*;
    use std::path::Path;

    /// Two links with these collision elements.
    fn two_links(arm: &str) -> Robot {
        let text = format!(
            r#"<robot name="two"><link name="base"/><link name="arm">{arm}</link>
            <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
            <origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint></robot>"#
        );
        Robot::from_text(Path::new("two.urdf"), &text, "base", "arm").unwrap()
    }

    #[test]
    fn the_file_of_a_robot_of_ones_own_is_known() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("arm.urdf");
        let text = include_str!("../../models/robot/ur5e.urdf");
        let files = |text: &str| -> Vec<(String, String)> {
            std::fs::write(&file, text).unwrap();
            Robot::from_urdf(&file, "base_link", "tool0").unwrap().files().cloned().collect()
        };
        let before = files(text);
        assert_eq!(before, [("arm.urdf".to_owned(), crate::files::sha256_hex(text.as_bytes()))]);
        assert_ne!(files(&text.replace("0.1333", "0.1334")), before);
        assert_eq!(Robot::preset("ur5e").unwrap().files().count(), 0);
    }

    #[test]
    fn meshes_are_told_from_no_shapes_at_all() {
        let mesh = r#"<collision><geometry><mesh filename="a.stl"/></geometry></collision>"#;
        let ball = r#"<collision><geometry><sphere radius="0.1"/></geometry></collision>"#;
        let why = |arm: &str| match two_links(arm).self_check() {
            SelfCheck::NotChecked { why } => why,
            checked @ SelfCheck::Checked { .. } => panic!("{checked:?}"),
        };
        assert_eq!(why(""), NotChecked::NoShapes);
        assert_eq!(why(ball), NotChecked::TooFewShapes);
        // A link that moves has a shape: obstacles can be checked, the arm with itself cannot.
        assert_eq!(two_links(ball).not_checked(), None);
        assert_eq!(two_links(ball).assumed_shapes(), None);
        let none = two_links("").obstacle_clearance(None, 2);
        assert_eq!(none, ObstacleClearance::NotChecked { why: NotChecked::NoShapes });
        assert_eq!(two_links("").obstacle_clearance(None, 0), ObstacleClearance::NoObstacle);
        // A mesh that is not there is assumed, and said to be.
        let blind = two_links(&mesh.repeat(8));
        assert_eq!(blind.not_checked(), None);
        assert_eq!(blind.assumed_shapes().unwrap().links, ["arm"]);
        let [RobotNote::AssumedCapsules { missing, .. }] = &blind.notes[1..] else {
            panic!("{:?}", blind.notes)
        };
        assert_eq!((missing.len(), &missing[0].fault), (8, &MeshFault::NotFound));
    }
}

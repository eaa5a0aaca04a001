//! Which messages of ROS hold a trajectory, and how they are written to files.

use super::{Header, JointTrajectory, Point, TrajectoryFault};
use serde::Deserialize;

impl TrajectoryFault {
    fn of(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

/// The messages of ROS that hold one trajectory, by the fields that they have.
#[derive(Debug, Deserialize)]
struct Message {
    #[serde(default)]
    header: Header,
    joint_names: Option<Vec<String>>,
    points: Option<Vec<Point>>,
    /// `moveit_msgs/RobotTrajectory`.
    joint_trajectory: Option<Box<Message>>,
    /// `moveit_msgs/DisplayTrajectory` (several parts), or a goal of `FollowJointTrajectory`.
    trajectory: Option<OneOrMore>,
    /// The action's own message around that goal.
    goal: Option<Box<Message>>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    More(Vec<Message>),
    One(Box<Message>),
}

impl Message {
    fn trajectory(self) -> Result<JointTrajectory, TrajectoryFault> {
        if let (Some(joint_names), Some(points)) = (self.joint_names, self.points) {
            return Ok(JointTrajectory { header: self.header, joint_names, points });
        }
        match (self.joint_trajectory.or(self.goal), self.trajectory) {
            (Some(inner), _) | (None, Some(OneOrMore::One(inner))) => inner.trajectory(),
            (None, Some(OneOrMore::More(mut parts))) if parts.len() == 1 => {
                parts.remove(0).trajectory()
            }
            (None, Some(OneOrMore::More(parts))) => Err(TrajectoryFault::of(format!(
                "is a DisplayTrajectory of {} parts; save the one that the robot follows",
                parts.len()
            ))),
            (None, None) => Err(TrajectoryFault::of(
                "is no JointTrajectory: it has no `joint_names` with `points`",
            )),
        }
    }
}

impl JointTrajectory {
    /// Reads JSON or YAML as ROS writes it: a `JointTrajectory`, or a message around one
    /// (`RobotTrajectory`, `DisplayTrajectory` with one part, `FollowJointTrajectory` goal). The `---` that
    /// `ros2 topic echo` puts after a message is left out.
    ///
    /// # Errors
    /// Where the text is no such message, or holds several.
    pub fn from_text(text: &str, is_json: bool) -> Result<Self, TrajectoryFault> {
        let fault = |e: String| {
            // The parser's own drawing of the place is for a terminal of its own.
            let first = e.lines().next().unwrap_or_default();
            TrajectoryFault::of(format!("is no JointTrajectory: {first}"))
        };
        if is_json {
            let message: Message = serde_json::from_str(text).map_err(|e| fault(e.to_string()))?;
            return message.trajectory();
        }
        let mut documents = vec![String::new()];
        for line in text.lines() {
            if line.trim_end() == "---" {
                documents.push(String::new());
            } else if let Some(last) = documents.last_mut() {
                last.push_str(line);
                last.push('\n');
            }
        }
        documents.retain(|d| d.lines().any(|l| !l.trim().is_empty() && !l.starts_with('#')));
        match &documents[..] {
            [] => Err(TrajectoryFault::of("is no JointTrajectory: the file is empty")),
            [only] => serde_saphyr::from_str::<Message>(only)
                .map_err(|e| fault(e.to_string()))?
                .trajectory(),
            all => Err(TrajectoryFault::of(format!(
                "holds {} messages; save one of them (ros2 topic echo --once)",
                all.len()
            ))),
        }
    }
}

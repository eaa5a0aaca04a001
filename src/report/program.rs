//! A path as a program for the robot's controller: `URScript`, KRL, RAPID, rows for a Franka robot, or the
//! ROS message. All moves are in the joints, so that no tool, base or configuration has to be the same.

mod dialects;

use crate::planner::PathData;
use crate::robot::{JointMargin, Moves, Robot, Stream};
use crate::words::program as words;
use thiserror::Error;

/// A controller's language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// Universal Robots.
    UrScript,
    /// KUKA.
    Krl,
    /// ABB.
    Rapid,
    /// Rows of joint values for the 1 kHz interface of Franka robots.
    Franka,
    /// `trajectory_msgs/JointTrajectory` as YAML.
    Ros,
}

/// Period of the rows for Franka robots, s.
const FRANKA_PERIOD_S: f64 = 1e-3;
/// Values are rounded to these: rad, and a ten thousandth of a degree in rad.
const RAD: f64 = 1e-6;
const FINE_RAD: f64 = 1e-9;
const DEG: f64 = std::f64::consts::PI / 180.0 * 1e-4;

/// A program.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Its text.
    pub text: String,
    /// What it is and what of it was checked, in sentences; they stand in the text, too.
    pub says: Vec<String>,
}

/// Why there is no program.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramError {
    /// The robot has no motion along the path.
    #[error("the robot has no motion along this path")]
    NoMotion,
    /// The language is for robots of another kind.
    #[error("{} is written for robots of {wants} turning joints; `{robot}` has {has}", language.name())]
    OtherRobot {
        /// The language.
        language: Language,
        /// The robot.
        robot: String,
        /// Joints that it wants.
        wants: usize,
        /// Joints that turn.
        has: usize,
    },
    /// The message could not be written as YAML.
    #[error("joint trajectory: {0}")]
    Yaml(String),
    /// What would be written breaks limits.
    #[error("what would be written breaks limits: {}", .0.iter().map(words::broken).collect::<Vec<_>>().join("; "))]
    BreaksLimits(Vec<JointMargin>),
}

impl Language {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::UrScript => "URScript",
            Self::Krl => "KRL",
            Self::Rapid => "RAPID",
            Self::Franka => "a table for Franka robots",
            Self::Ros => "a JointTrajectory for ROS",
        }
    }

    fn joints(self) -> Option<usize> {
        match self {
            Self::UrScript | Self::Krl | Self::Rapid => Some(6),
            Self::Franka => Some(7),
            Self::Ros => None,
        }
    }
}

/// Writes a path of a run, named `title`, for a robot; moves stay within `tolerance_m` of the plan.
///
/// # Errors
/// Where the robot has no motion along it, is of another kind, or would break its limits.
pub fn program(
    language: Language,
    title: &str,
    path: &PathData,
    robot: &Robot,
    tolerance_m: f64,
) -> Result<Program, ProgramError> {
    let motion = path.joint_trajectory.as_ref().ok_or(ProgramError::NoMotion)?;
    let joints = robot.linkage.joints();
    let has = joints.iter().filter(|j| !j.is_prismatic).count();
    if let Some(wants) = language.joints().filter(|n| *n != has || *n != joints.len()) {
        let robot = robot.name.clone();
        return Err(ProgramError::OtherRobot { language, robot, wants, has });
    }
    let about = |more: Vec<String>, margins: &[JointMargin]| {
        let mut says = vec![
            format!("ergopath {}: {title}", env!("CARGO_PKG_VERSION")),
            words::NOT_RUN.to_owned(),
        ];
        says.extend(more);
        says.extend(words::limits(margins));
        if language != Language::Ros {
            says.push(
                "joint values are those of the robot's description: compare zero and sense of each axis with the controller"
                    .to_owned(),
            );
        }
        says.push(START.to_owned());
        says.iter().map(|s| ascii(s)).collect::<Vec<String>>()
    };
    match language {
        Language::UrScript | Language::Krl | Language::Rapid => {
            let unit = if language == Language::UrScript { RAD } else { DEG };
            let moves =
                Moves::of(robot, motion, tolerance_m, unit).map_err(|_| ProgramError::NoMotion)?;
            kept(&moves.margins)?;
            let thinned = words::Thinned {
                moves: moves.count(),
                points: moves.points,
                deviation_m: moves.deviation_m,
                duration_off_s: moves.duration_off_s,
            };
            let corners = dialects::corners(language);
            let says = about(vec![words::thinned(&thinned), corners.to_owned()], &moves.margins);
            let text = dialects::moves(language, &says, &moves);
            Ok(Program { text, says })
        }
        Language::Franka => {
            let stream = Stream::of(robot, motion, FRANKA_PERIOD_S, FINE_RAD)
                .ok_or(ProgramError::NoMotion)?;
            kept(&stream.margins)?;
            let line = words::stream(stream.rows.len(), stream.period_s, stream.deviation_m);
            let says = about(vec![line], &stream.margins);
            Ok(Program { text: dialects::rows(&says, &stream), says })
        }
        Language::Ros => {
            let margins = motion.check(robot);
            kept(&margins)?;
            let says =
                about(vec![format!("{} points: all of the plan", motion.points.len())], &margins);
            let text =
                dialects::ros(&says, motion).map_err(|e| ProgramError::Yaml(e.to_string()))?;
            Ok(Program { text, says })
        }
    }
}

const START: &str = "the way to the start of the path is not planned and was not checked";

fn kept(margins: &[JointMargin]) -> Result<(), ProgramError> {
    let broken: Vec<JointMargin> = margins.iter().filter(|m| !m.is_kept()).cloned().collect();
    if broken.is_empty() { Ok(()) } else { Err(ProgramError::BreaksLimits(broken)) }
}

/// Controllers read no other letters, not even in comments.
fn ascii(words: &str) -> String {
    let plain = |c: char| match c {
        ' '..='~' => c,
        '\u{a0}' | '\u{202f}' | '\t' => ' ',
        '\u{2010}'..='\u{2015}' | '\u{2212}' => '-',
        _ => '?',
    };
    words.chars().map(plain).collect()
}

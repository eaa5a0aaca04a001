//! The designer's own paths: TCP poses or joint angles over time, from CSV, or a ROS `JointTrajectory`.
//!
//! Columns `time_s, x_m, y_m, z_m, qw, qx, qy, qz` (TCP in the world), or `time_s` and the robot's
//! joint names, with or without the ending `_rad`. Other columns are ignored when the TCP columns are
//! complete (a path written by ergopath holds both). What looks like another unit is refused with a
//! question (see [`super::plausible`]).

use super::check::Scenario;
use super::plausible::{self, Doubt, LONGEST_S};
use super::warning::Warning;
use crate::files::{InputError, NumericTable, read_bytes, sha256_hex};
use crate::math::{Pose, Vec3};
use crate::robot::{JointTrajectory, OddRate, Robot, tcp_poses};
use crate::trajectory::{TimedPath, TrajectoryError};
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;

const POSE_COLUMNS: [&str; 7] = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];
/// How far from 1 the norm of a quaternion may be.
const NORM_TOLERANCE: f64 = 1e-2;

/// A path that was given, not planned.
#[derive(Debug, Clone)]
pub struct UserPath {
    /// Its name in the scenario.
    pub name: String,
    /// TCP in the world.
    pub path: TimedPath,
    /// Joint angles at the same times, rad, if the file gives the robot's motion.
    pub joints: Option<Vec<Vec<f64>>>,
    /// What looks odd in the file and may be meant.
    pub doubts: Vec<Doubt>,
    /// SHA-256 of the file.
    pub sha256: String,
}

impl UserPath {
    /// What the reader should know of it.
    pub fn warnings(&self) -> Vec<Warning> {
        let path = || self.name.clone();
        let of_file = |d: &Doubt| Warning::Doubtful { path: Some(path()), doubt: d.clone() };
        let mut all: Vec<Warning> = self.doubts.iter().map(of_file).collect();
        if self.joints.is_none() {
            all.push(Warning::OnlyTcp { path: path() });
        }
        all
    }
}

impl Scenario {
    /// Adds a path from a file, named like the file.
    ///
    /// # Errors
    /// Where the file is no path, or its name cannot be used or is taken.
    pub fn add_path(&mut self, file: &Path) -> Result<(), InputError> {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        if let Some(fault) = plausible::path_name_fault(&name) {
            return Err(InputError::new(file, format!("as a name of a path, `{name}` {fault}"))
                .remedy("rename the file"));
        }
        let taken = self.paths.iter().map(|p| &p.name).chain(self.drawn.iter().map(|d| &d.id));
        if taken.into_iter().any(|n| *n == name) {
            let message = format!("there are two paths named `{name}`");
            return Err(InputError::new(file, message).remedy("rename one of the files"));
        }
        let path = read_user_path(&name, file, &self.robot, Some([&self.start, &self.goal]))?;
        self.warnings.extend(path.warnings());
        self.paths.push(path);
        Ok(())
    }
}

/// Reads a path for a robot; with start and goal of the scenario, if there is one, the order of its
/// quaternions is judged by them.
///
/// # Errors
/// Where the file is no path for the robot, or is one in other units.
pub fn read_user_path(
    name: &str,
    file: &Path,
    robot: &Robot,
    ends: Option<[&Pose; 2]>,
) -> Result<UserPath, InputError> {
    let bytes = read_bytes(file)?;
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ["json", "yaml", "yml"].contains(&ending.as_str()) {
        read_trajectory(name, file, &bytes, robot, &ending)
    } else {
        read_table(name, file, &bytes, robot, ends)
    }
}

fn read_table(
    name: &str,
    file: &Path,
    bytes: &[u8],
    robot: &Robot,
    ends: Option<[&Pose; 2]>,
) -> Result<UserPath, InputError> {
    let table = NumericTable::parse(file, bytes)?;
    let time_s = table.column("time_s")?;
    let place = |name: &str| table.columns.iter().position(|k| k == name);
    let columns: Option<Vec<usize>> =
        robot.joint_names().map(|j| place(j).or_else(|| place(&format!("{j}_rad")))).collect();
    let has_poses = POSE_COLUMNS.iter().all(|c| place(c).is_some());
    let positions = if has_poses { &POSE_COLUMNS[..3] } else { &[] };
    let of_joints = columns.as_deref().unwrap_or_default();
    if let Some(doubt) = plausible::of_table(&table, positions, of_joints, robot) {
        return Err(doubt.question(file));
    }
    let joints: Option<Vec<Vec<f64>>> =
        columns.map(|c| table.rows.iter().map(|r| c.iter().map(|&i| r[i]).collect()).collect());
    let poses = if has_poses {
        let poses = read_poses(file, &table)?;
        if let (Some(ends), [first, .., last]) = (ends, &poses[..])
            && let Some(doubt) = plausible::order("columns `qw` to `qz`", [first, last], ends)
        {
            return Err(doubt.question(file));
        }
        poses
    } else if let Some(q) = &joints {
        tcp_poses(robot, q)
    } else {
        let joint_names: Vec<&str> = robot.joint_names().collect();
        return Err(InputError::new(file, "holds neither TCP poses nor the robot's joints")
            .remedy(format!(
                "columns: time_s, {}; or time_s, {}",
                POSE_COLUMNS.join(", "),
                joint_names.join(", ")
            )));
    };
    let path = TimedPath::new(time_s, poses).map_err(|e| {
        let message = match e {
            TrajectoryError::Time(row) => {
                let (line, t) = (table.line(row), place("time_s").map(|c| table.rows[row][c]));
                let before = place("time_s").map(|c| table.rows[row.saturating_sub(1)][c]);
                let [t, before] = [t, before].map(Option::unwrap_or_default);
                format!("line {line}, column `time_s`: {t} is not later than {before} before it")
            }
            other => other.to_string(),
        };
        InputError::new(file, message).remedy("time_s must rise from row to row")
    })?;
    let sha256 = sha256_hex(bytes);
    Ok(UserPath { name: name.to_owned(), path, joints, doubts: Vec::new(), sha256 })
}

/// A ROS `JointTrajectory`, as JSON or YAML.
fn read_trajectory(
    name: &str,
    file: &Path,
    bytes: &[u8],
    robot: &Robot,
    ending: &str,
) -> Result<UserPath, InputError> {
    let fault = |message: String| {
        InputError::new(file, message)
            .remedy("expected a ROS JointTrajectory: joint_names, and points with positions and time_from_start")
    };
    let text = std::str::from_utf8(bytes).map_err(|e| fault(format!("is not text: {e}")))?;
    let trajectory =
        JointTrajectory::from_text(text, ending == "json").map_err(|e| fault(e.to_string()))?;
    let (time_s, q) = trajectory.postures(robot).map_err(|e| fault(e.to_string()))?;
    if let (Some(first), Some(last)) = (time_s.first(), time_s.last())
        && last - first > LONGEST_S
    {
        let place = format!("point {}, `time_from_start`", time_s.len());
        return Err(Doubt::Milliseconds { place, value: last - first }.question(file));
    }
    for (k, row) in q.iter().enumerate() {
        for (j, (value, joint)) in row.iter().zip(robot.joint_names()).enumerate() {
            let place = || format!("point {}, joint `{joint}`", k + 1);
            if let Some(doubt) = plausible::of_joint(robot, j, *value, place) {
                return Err(doubt.question(file));
            }
        }
    }
    let path = TimedPath::new(time_s, tcp_poses(robot, &q))
        .map_err(|e| fault(format!("{e}; time_from_start must rise from point to point")))?;
    let place = |odd: &OddRate| format!("point {}, joint `{}`", odd.point + 1, odd.joint);
    let velocity = trajectory.odd_velocity().map(|odd| Doubt::Velocities {
        place: place(&odd),
        given: odd.given,
        moved: odd.moved,
    });
    let acceleration = trajectory.odd_acceleration().map(|odd| Doubt::Accelerations {
        place: place(&odd),
        given: odd.given,
        moved: odd.moved,
    });
    let doubts = velocity.into_iter().chain(acceleration).collect();
    let sha256 = sha256_hex(bytes);
    Ok(UserPath { name: name.to_owned(), path, joints: Some(q), doubts, sha256 })
}

fn read_poses(file: &Path, table: &NumericTable) -> Result<Vec<Pose>, InputError> {
    let mut columns = [0; 7];
    for (slot, name) in columns.iter_mut().zip(POSE_COLUMNS) {
        *slot = table.index(name)?;
    }
    table
        .rows
        .iter()
        .enumerate()
        .map(|(row, r)| {
            let [x, y, z, qw, qx, qy, qz] = columns.map(|c| r[c]);
            let q = Quaternion::new(qw, qx, qy, qz);
            if (q.norm() - 1.0).abs() > NORM_TOLERANCE {
                let line = table.line(row);
                let message = format!("line {line}: quaternion has norm {:.4}, not 1", q.norm());
                return Err(InputError::new(file, message)
                    .remedy("qw is the scalar part; normalise the quaternion"));
            }
            Ok(Pose::from_parts(Vec3::new(x, y, z).into(), UnitQuaternion::new_normalize(q)))
        })
        .collect()
}

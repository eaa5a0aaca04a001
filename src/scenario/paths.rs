//! The designer's own paths: TCP poses or joint angles over time, from CSV, or a ROS `JointTrajectory`.
//!
//! Columns `time_s, x_m, y_m, z_m, qw, qx, qy, qz` (TCP in the world), or `time_s` and the robot's
//! joint names, with or without the ending `_rad`. Other columns are ignored when the TCP columns are
//! complete (a path written by ergopath holds both).

use crate::files::{InputError, NumericTable};
use crate::math::{Pose, Vec3};
use crate::robot::{JointTrajectory, Robot, tcp_poses};
use crate::trajectory::TimedPath;
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;

const POSE_COLUMNS: [&str; 7] = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"];

/// A path that was given, not planned.
#[derive(Debug, Clone)]
pub struct UserPath {
    /// Its name in the scenario.
    pub name: String,
    /// TCP in the world.
    pub path: TimedPath,
    /// Joint angles at the same times, rad, if the file gives the robot's motion.
    pub joints: Option<Vec<Vec<f64>>>,
    /// SHA-256 of the file.
    pub sha256: String,
}

impl UserPath {
    /// What the reader should know of it.
    pub fn warning(&self) -> Option<String> {
        self.joints.is_none().then(|| {
            format!(
                "path `{}` gives only the TCP: the postures of the arm along it are chosen here, and its \
                 distances to people and things may differ from those under your controller; columns with \
                 the robot's joints would fix them",
                self.name
            )
        })
    }
}

/// Reads a path for a robot.
pub fn read_user_path(name: &str, file: &Path, robot: &Robot) -> Result<UserPath, InputError> {
    let bytes = crate::files::read_bytes(file)?;
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ["json", "yaml", "yml"].contains(&ending.as_str()) {
        return read_trajectory(name, file, &bytes, robot, &ending);
    }
    let table = NumericTable::parse(file, &bytes)?;
    let time_s = table.column("time_s")?;
    let has = |c: &str| table.columns.iter().any(|k| k == c);
    let joint_columns: Option<Vec<String>> = robot
        .joint_names()
        .map(|j| [j.to_owned(), format!("{j}_rad")].into_iter().find(|c| has(c)))
        .collect();
    let joints: Option<Vec<Vec<f64>>> = match &joint_columns {
        Some(columns) => {
            let indices: Result<Vec<usize>, InputError> =
                columns.iter().map(|c| table.index(c)).collect();
            let indices = indices?;
            Some(table.rows.iter().map(|r| indices.iter().map(|&i| r[i]).collect()).collect())
        }
        None => None,
    };
    let poses = if POSE_COLUMNS.iter().all(|c| has(c)) {
        read_poses(file, &table)?
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
        InputError::new(file, e.to_string()).remedy("time_s must rise from row to row")
    })?;
    let sha256 = crate::files::sha256_hex(&bytes);
    Ok(UserPath { name: name.to_owned(), path, joints, sha256 })
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
    let trajectory: JointTrajectory = if ending == "json" {
        serde_json::from_str(text).map_err(|e| fault(e.to_string()))?
    } else {
        serde_saphyr::from_str(text).map_err(|e| fault(e.to_string()))?
    };
    let (time_s, q) = trajectory.postures(robot).map_err(|e| fault(e.to_string()))?;
    let path = TimedPath::new(time_s, tcp_poses(robot, &q))
        .map_err(|e| fault(format!("{e}; time_from_start must rise from point to point")))?;
    let sha256 = crate::files::sha256_hex(bytes);
    Ok(UserPath { name: name.to_owned(), path, joints: Some(q), sha256 })
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
            if (q.norm() - 1.0).abs() > 1e-2 {
                let message =
                    format!("row {}: quaternion has norm {:.4}, not 1", row + 1, q.norm());
                return Err(InputError::new(file, message)
                    .remedy("qw is the scalar part; normalise the quaternion"));
            }
            Ok(Pose::from_parts(Vec3::new(x, y, z).into(), UnitQuaternion::new_normalize(q)))
        })
        .collect()
}

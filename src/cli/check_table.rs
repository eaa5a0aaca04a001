//! CSV tables in words, told apart by their columns.

use super::check::Explained;
use crate::ergonomics::{Profile, Worksheet};
use crate::files::{CsvText, InputError, NumericTable, read_bytes};
use crate::human::{Body, Side};
use crate::robot::{PRESETS, Robot};
use crate::scenario::read_user_path;
use crate::scoring::score_table;
use crate::training::{SIMULATED_MARK, read_motion};
use std::path::Path;

/// A body whose joints have the names that all bodies of ergopath share.
const ANY_BODY: &str = "male_p50";

/// A table in words.
pub(super) fn table(path: &Path) -> Result<Explained, InputError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if name.ends_with("_pose_saved.csv") {
        return Err(InputError::new(path, "is one body of a rigid-body recording")
            .remedy("give the folder that holds the CSV files of all bodies"));
    }
    let bytes = read_bytes(path)?;
    let text = CsvText::of(path, &bytes)?;
    let mut reader = text.reader();
    let header = reader.headers().map_err(|e| text.broken(path, &e))?;
    let columns: Vec<String> = header.iter().map(str::to_owned).collect();
    let rows = reader.records().count();
    let has = |c: &str| columns.iter().any(|k| k == c);
    let has_all = |names: &[&str]| names.iter().all(|n| has(n));
    let of_sheet = Worksheet::COLUMNS.iter().filter(|c| has(c)).count();
    if has_all(&["time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]) {
        return path_of(path, "panda", "a path of the TCP (position and quaternion, world)");
    }
    if has_all(&["rank", "id", "family"]) {
        return Ok(
            Explained::new("all paths of a run (candidates.csv)").saying(format!("{rows} paths"))
        );
    }
    if has_all(&["name", "scenario", "state"]) {
        return Ok(Explained::new("a comparison of runs").saying(format!("{rows} rows")));
    }
    if 2 * of_sheet > Worksheet::COLUMNS.len() {
        let scored = score_table(path, &bytes, &Profile::default())?;
        let explained = Explained::new("filled-in worksheets, a row for each posture and side");
        return Ok(explained.saying(format!("{} rows, all can be scored", scored.rows)));
    }
    if has("rollout") && has("time_s") {
        return rollouts(path);
    }
    if has("q0") && has("qdot0") {
        return Ok(data(path, &columns, rows));
    }
    let is_robot = |name: &&&str| {
        Robot::preset(name)
            .is_ok_and(|r| r.joint_names().all(|j| has(j) || has(&format!("{j}_rad"))))
    };
    if let Some(robot) = PRESETS.iter().find(is_robot).filter(|_| has("time_s")) {
        return path_of(path, robot, &format!("a motion of the robot `{robot}` (joint angles)"));
    }
    if has("time_s") && columns.iter().any(|c| c.ends_with("_rad")) {
        return motion(path);
    }
    let message = format!("has columns that ergopath does not know: {}", few(&columns));
    Err(InputError::new(path, message).remedy(
        "known are paths (time_s, x_m ... qz), joint angles (time_s, <joint>_rad), worksheets, data files \
         (q0.., xdot0.., qdot0..) and the tables that ergopath writes",
    ))
}

fn few(columns: &[String]) -> String {
    let more = if columns.len() > 8 { ", ..." } else { "" };
    columns.iter().take(8).cloned().collect::<Vec<_>>().join(", ") + more
}

fn path_of(path: &Path, robot: &str, kind: &str) -> Result<Explained, InputError> {
    let user = read_user_path("path", path, &Robot::preset(robot)?, None)?;
    let (p, ends) = (&user.path, [user.path.poses.first(), user.path.poses.last()]);
    let mut explained = Explained::new(kind).saying(format!(
        "{} samples over {:.2} s, {:.3} m of travel",
        p.time_s.len(),
        p.duration_s(),
        p.length_m()
    ));
    if user.joints.is_none() || kind.contains("TCP") {
        for (name, pose) in ["from", "to"].into_iter().zip(ends) {
            if let Some(v) = pose.map(|p| p.translation.vector) {
                explained =
                    explained.saying(format!("{name} ({:.3}, {:.3}, {:.3}) m", v.x, v.y, v.z));
            }
        }
        let fastest =
            p.velocities().iter().map(|v| v.fixed_rows::<3>(0).norm()).fold(0.0, f64::max);
        explained = explained.saying(format!("fastest {fastest:.3} m/s between samples"));
    }
    explained.notes.push(
        "whether it keeps the limits of a cell is seen with a scenario: ergopath assess SCENARIO --path FILE".into(),
    );
    Ok(explained)
}

fn rollouts(path: &Path) -> Result<Explained, InputError> {
    let table = NumericTable::read(path)?;
    let mut people: Vec<f64> = table.column("rollout")?;
    people.dedup();
    let last = table.column("time_s")?.into_iter().fold(0.0, f64::max);
    Ok(Explained::new("sampled postures along a path, as `plan --rollouts` writes them")
        .saying(format!(
            "{} repetitions, {} rows, up to {last:.2} s",
            people.len(),
            table.rows.len()
        ))
        .saying(format!("{} joints", table.columns.len() - 2)))
}

fn motion(path: &Path) -> Result<Explained, InputError> {
    let body = Body::load(ANY_BODY, Path::new("."))?;
    let table = NumericTable::read(path)?;
    let of_arm = |side: Side| -> Result<bool, InputError> {
        let arm = body.arm(side)?;
        let names: Vec<String> = arm.joints().iter().map(|j| format!("{}_rad", j.name)).collect();
        Ok(names.iter().all(|n| table.columns.contains(n)))
    };
    let side = if of_arm(Side::Right)? { Side::Right } else { Side::Left };
    let motion = read_motion(path, &body, side)?;
    let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
    let mut explained =
        Explained::new("a movement as joint angles of a body of ergopath").saying(format!(
            "{} trials, {} rows, {} arm",
            motion.trials.len(),
            table.rows.len(),
            side.prefix().to_lowercase()
        ));
    if text.starts_with(SIMULATED_MARK) {
        explained.notes.push("the movements are those of a simulated operator".into());
    }
    Ok(explained)
}

fn data(path: &Path, columns: &[String], rows: usize) -> Explained {
    let count = |start: &str| {
        let is_one = |c: &&String| {
            c.strip_prefix(start)
                .is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
        };
        columns.iter().filter(is_one).count()
    };
    let mut explained = Explained::new("a data file of a chain (rows of what joints and task did)")
        .saying(format!("{rows} rows, {} joints, {} rows of the task", count("q"), count("xdot")));
    explained.notes.push(format!(
        "whether it fits a chain is seen with it: ergopath evaluate {} --chain URDF:BASE:TIP",
        path.display()
    ));
    explained
}

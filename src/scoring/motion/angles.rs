//! Joint angles from a CSV: `[trial|rollout], time_s, <joint>_rad...`, any joints of the body.

use super::{Motion, MotionKind, Track};
use crate::files::{InputError, NumericTable, read_bytes, sha256_hex, suggest};
use crate::human::{Body, FEET_COLUMNS, Side, Stance, column_of, column_unit};
use crate::math::Pose;
use crate::scenario::Origin;
use crate::survey::{WholePosture, WholeSurveyor, heel_joint};
use crate::training::SIMULATED_MARK;
use std::path::Path;

/// Angles beyond this are degrees by mistake, rad.
const LARGEST_RAD: f64 = 7.0;
/// Angles beyond a joint's range by more than this are worth a note, rad.
const BEYOND_RAD: f64 = 1e-4;

/// Reads joint angles of a body that stands or sits upright on its pelvis.
///
/// An arm is known where all joints from the pelvis to its grip are columns, the neck where jT1C7 and
/// jC1Head are, the knees where both are. `duration_s` is that of the path of rollouts, if known: a
/// rollout that ends before it, or before the longest, could not follow from there on.
///
/// # Errors
/// Where the file is no table of finite numbers, a column is no joint of the body, neither arm is
/// whole, times do not increase within a track, or an angle cannot be in rad.
pub fn read_angles(
    path: &Path,
    body: &Body,
    stance: Stance,
    duration_s: Option<f64>,
) -> Result<Motion, InputError> {
    let bytes = read_bytes(path)?;
    let table = NumericTable::parse(path, &bytes)?;
    let surveyor = WholeSurveyor::new(body)?;
    let columns = Columns::find(path, &table, (&surveyor, body))?;
    let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
    let kind = if columns.rollout { MotionKind::Rollouts } else { MotionKind::JointAngles };
    let mut tracks: Vec<Track> = Vec::new();
    for (row, values) in table.rows.iter().enumerate() {
        columns.refuse_degrees(path, &table, row)?;
        let name = columns.track.map_or_else(|| "1".to_owned(), |c| values[c].to_string());
        let posture = columns.posture(values, &surveyor, &pelvis);
        push(path, &mut tracks, (row, name), values[columns.time], &posture)?;
    }
    let mut notes = Vec::new();
    notes.extend(columns.beyond_ranges(&table, body));
    if kind == MotionKind::Rollouts {
        count_exceeded(&mut tracks, duration_s);
    }
    let is_simulated = bytes.starts_with(SIMULATED_MARK.as_bytes());
    if is_simulated {
        notes.push("the movements are those of a simulated operator".to_owned());
    }
    let is_predicted = is_simulated || kind == MotionKind::Rollouts;
    Ok(Motion {
        source: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        sha256: sha256_hex(&bytes),
        body: body.name.clone(),
        kind,
        tracks,
        origin: if is_predicted { Origin::Predicted } else { Origin::Measured },
        notes,
    })
}

fn push(
    path: &Path,
    tracks: &mut Vec<Track>,
    (row, name): (usize, String),
    time: f64,
    posture: &WholePosture,
) -> Result<(), InputError> {
    let is_next = tracks.last().is_some_and(|t| t.name == name);
    if !is_next {
        if tracks.iter().any(|t| t.name == name) {
            let message = format!("row {}: `{name}` appears again after another", row + 1);
            return Err(InputError::new(path, message)
                .remedy("keep the rows of each trial or rollout together"));
        }
        tracks.push(Track { name, time_s: Vec::new(), postures: Vec::new(), exceeded: 0 });
    }
    let Some(track) = tracks.last_mut() else { return Ok(()) };
    if let Some(before) = track.time_s.last().filter(|b| **b >= time) {
        let message = format!("row {}: time goes from {before} to {time} s", row + 1);
        return Err(InputError::new(path, message)
            .remedy("times must increase; mark several movements in a column `trial`"));
    }
    track.time_s.push(time);
    track.postures.push(*posture);
    Ok(())
}

/// Frames by which each rollout is shorter than the longest, or than the path.
fn count_exceeded(tracks: &mut [Track], duration_s: Option<f64>) {
    let mut longest = tracks.iter().map(|t| t.time_s.len()).max().unwrap_or(0);
    let all = tracks.iter().flat_map(|t| t.time_s.windows(2).map(|w| w[1] - w[0]));
    let step = all.fold(f64::INFINITY, f64::min);
    if let Some(duration) = duration_s.filter(|_| step.is_finite()) {
        longest = longest.max((duration / step).round() as usize + 1);
    }
    for track in tracks {
        track.exceeded = longest - track.time_s.len();
    }
}

/// Which column holds what.
struct Columns {
    time: usize,
    track: Option<usize>,
    rollout: bool,
    /// Column of the table and of the body.
    joints: Vec<(usize, usize)>,
    /// Metres or radians of a coordinate of one, by columns of the body.
    units: Vec<f64>,
    arms: [bool; 2],
    has_neck: bool,
    /// Whether the knees are there, and the joints about which heels rise.
    legs: [bool; 2],
}

impl Columns {
    fn find(
        path: &Path,
        table: &NumericTable,
        (surveyor, body): (&WholeSurveyor, &Body),
    ) -> Result<Self, InputError> {
        let time = table.index("time_s")?;
        let place = |name: &str| table.columns.iter().position(|c| c == name);
        let rollout = place("rollout");
        let track = rollout.or_else(|| place("trial"));
        let mut joints = Vec::new();
        for (i, name) in table.columns.iter().enumerate() {
            // No angle depends on where the feet are.
            let aside = [&["trial", "rollout", "stepping"][..], &FEET_COLUMNS].concat();
            if i == time || aside.contains(&name.as_str()) {
                continue;
            }
            let joint = surveyor.joints().position(|j| column_of(j) == *name);
            joints.push((i, joint.ok_or_else(|| unknown(path, name, surveyor))?));
        }
        let has = |c: usize| joints.iter().any(|(_, j)| *j == c);
        let has_joint = |name: &str| surveyor.column(name).is_some_and(has);
        let arms = [Side::Right, Side::Left].map(|s| surveyor.chain(s).iter().all(|c| has(*c)));
        if !arms[0] && !arms[1] {
            return Err(incomplete(path, surveyor, &has));
        }
        let axes = |joint: &str| ["Z", "X", "Y"].iter().all(|a| has_joint(&format!("{joint}_{a}")));
        Ok(Self {
            time,
            track,
            rollout: rollout.is_some(),
            arms,
            has_neck: axes("jT1C7") && axes("jC1Head"),
            legs: [
                has_joint("jRightKnee_Z") && has_joint("jLeftKnee_Z"),
                [Side::Right, Side::Left].iter().all(|s| has_joint(&heel_joint(*s))),
            ],
            joints,
            units: surveyor.joints().map(|j| column_unit(j, body)).collect(),
        })
    }

    fn posture(&self, row: &[f64], surveyor: &WholeSurveyor, pelvis: &Pose) -> WholePosture {
        let mut q = vec![0.0; surveyor.dof()];
        for (from, to) in &self.joints {
            q[*to] = row[*from] / self.units[*to];
        }
        let mut posture = surveyor.measure(&q, pelvis, None);
        for (arm, known) in posture.arms.iter_mut().zip(self.arms) {
            *arm = arm.filter(|_| known);
        }
        posture.neck = posture.neck.filter(|_| self.has_neck);
        posture.knees_deg = posture.knees_deg.filter(|_| self.legs[0]);
        posture.heels_deg = posture.heels_deg.filter(|_| self.legs[1]);
        posture
    }

    fn refuse_degrees(
        &self,
        path: &Path,
        table: &NumericTable,
        row: usize,
    ) -> Result<(), InputError> {
        let far = self.joints.iter().find(|(c, _)| table.rows[row][*c].abs() > LARGEST_RAD);
        far.map_or(Ok(()), |(c, _)| {
            let message = format!(
                "row {}, column `{}`: {} is no joint angle in rad",
                row + 1,
                table.columns[*c],
                table.rows[row][*c]
            );
            Err(InputError::new(path, message).remedy("angles are in rad, one column per joint"))
        })
    }

    /// A word on angles outside the body's ranges.
    fn beyond_ranges(&self, table: &NumericTable, body: &Body) -> Option<String> {
        let mut worst: Option<(f64, &str)> = None;
        let mut rows = vec![false; table.rows.len()];
        for (column, _) in &self.joints {
            let name = table.columns[*column].trim_end_matches("_rad");
            let Some(joint) = body.model.joints.iter().find(|j| j.name == name) else { continue };
            for (row, values) in table.rows.iter().enumerate() {
                let v = values[*column];
                let beyond = (v - joint.upper).max(joint.lower - v);
                if beyond > BEYOND_RAD {
                    rows[row] = true;
                    if worst.is_none_or(|w| w.0 < beyond) {
                        worst = Some((beyond, name));
                    }
                }
            }
        }
        let count = rows.iter().filter(|r| **r).count();
        worst.map(|(by, joint)| {
            format!(
                "{count} of {} rows hold angles outside the body's joint ranges (most: {joint} by {:.1} \
                 deg); they are scored as they are",
                rows.len(),
                by.to_degrees()
            )
        })
    }
}

fn unknown(path: &Path, name: &str, surveyor: &WholeSurveyor) -> InputError {
    let known: Vec<String> = [Side::Right, Side::Left]
        .iter()
        .flat_map(|s| chain_names(*s, surveyor))
        .chain(["time_s", "trial", "rollout"].map(str::to_owned))
        .collect();
    let help = suggest(name, known.iter().map(String::as_str));
    InputError::new(path, format!("column `{name}` is no joint of the body")).remedy(
        help.unwrap_or_else(|| {
            "columns are trial or rollout (optional), time_s and <joint>_rad".to_owned()
        }),
    )
}

/// Column names of the joints of an arm chain.
fn chain_names(side: Side, surveyor: &WholeSurveyor) -> Vec<String> {
    surveyor.chain_joints(side).map(|j| format!("{j}_rad")).collect()
}

fn incomplete(path: &Path, surveyor: &WholeSurveyor, has: &dyn Fn(usize) -> bool) -> InputError {
    let lacks = |side: Side| -> Vec<String> {
        let names = chain_names(side, surveyor);
        let pairs = names.into_iter().zip(surveyor.chain(side));
        pairs.filter(|(_, c)| !has(**c)).map(|(n, _)| n).collect()
    };
    let (right, left) = (lacks(Side::Right), lacks(Side::Left));
    let (side, missing) = if right.len() <= left.len() { ("right", right) } else { ("left", left) };
    let shown: Vec<&str> = missing.iter().take(4).map(String::as_str).collect();
    let more = if missing.len() > 4 { ", ..." } else { "" };
    let count = missing.len();
    InputError::new(path, "holds no whole arm: trunk, shoulder, elbow and wrist of one side")
        .remedy(format!(
            "for the {side} arm {count} columns are missing: {}{more}",
            shown.join(", ")
        ))
}

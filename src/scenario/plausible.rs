//! Values that can be read but look like a mistake: another unit, another order, a slip of the pen.
//!
//! Each is a [`Doubt`] with its words in one place. Most are questions: the input is refused and the
//! message asks. Some are warnings, where the value may be meant. A path is doubted where it is read, a
//! scenario where it is resolved, so that `plan`, `assess` and `check` see the same.

use crate::files::{InputError, NumericTable, is_formula};
use crate::math::Pose;
use crate::physical::{COORDINATE_M, DURATION_S, SAME_CELL_M, shown};
use crate::robot::Robot;
use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::path::Path;

/// Longest duration that is taken for seconds.
pub(super) const LONGEST_S: f64 = DURATION_S.high;
/// Load on one hand above which a unit is doubted, kg.
const HEAVIEST_KG: f64 = 50.0;
/// Angle of a joint without ends from which it is taken for degrees, rad.
const MOST_TURNED_RAD: f64 = 4.0 * TAU;
/// A sliding joint that far beyond its ends is doubted, m.
const SLID_BEYOND_M: f64 = 2.0;
/// Orientations of a path's ends: off by more than the first as read, and by less than the second in
/// another order of the quaternion, deg.
const ORDER_OFF_DEG: f64 = 30.0;
const ORDER_FITS_DEG: f64 = 10.0;
/// Angles below this in a key of degrees may be radians.
const MOST_RADIANS: f64 = 7.0;
/// Longest name, characters.
const LONGEST_NAME: usize = 100;
/// Names that the planner gives to its own paths.
const OUR_NAMES: [&str; 11] = [
    "straight",
    "lifted",
    "lowered",
    "toward_body",
    "away",
    "expert_arc",
    "shortest",
    "centre",
    "best_random",
    "single_posture_plain",
    "single_posture_learned",
];

/// Something in an input that looks like a mistake.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Doubt {
    /// A turning joint far beyond its limits.
    Degrees {
        /// Where in the file.
        place: String,
        /// The value, read as rad.
        value: f64,
        /// How far beyond the joint's limits, rad; none for a joint without ends.
        beyond: Option<f64>,
    },
    /// A position far from any cell.
    Millimetres {
        /// Where.
        place: String,
        /// The value, read as m.
        value: f64,
    },
    /// A very long movement.
    Milliseconds {
        /// Where.
        place: String,
        /// The duration, read as s.
        value: f64,
    },
    /// A quaternion that fits start and goal in another order only.
    QuaternionOrder {
        /// Where.
        place: String,
        /// Larger angle to the scenario's start and goal as read, deg.
        off_deg: f64,
        /// The same in the other order, deg.
        other_deg: f64,
        /// In the other order the scalar is last, else first.
        is_last: bool,
    },
    /// A load that no hand carries.
    Grams {
        /// Which key.
        place: String,
        /// The value, read as kg.
        value: f64,
    },
    /// An equivalent place far from the first.
    FarPlace {
        /// Which key.
        place: String,
        /// Distance, m.
        value: f64,
    },
    /// Angles in a key of degrees that are round in radians.
    Radians {
        /// Which key.
        place: String,
        /// The values, read as deg.
        values: Vec<f64>,
    },
    /// A part too heavy for one hand, of which the robot is said to carry most.
    HeavyPart {
        /// Mass, kg.
        mass_kg: f64,
    },
    /// The duration is outside the range that is free.
    DurationOutsideRange {
        /// As given, s.
        given_s: f64,
        /// As taken, s.
        taken_s: f64,
    },
    /// More cycles a minute than fit.
    Cycles {
        /// As given, 1/min.
        cycles_per_min: f64,
        /// The key of what takes longer than one cycle.
        place: String,
        /// How long it takes, s.
        needed_s: f64,
    },
    /// A file's velocities do not belong to its positions.
    Velocities {
        /// Where.
        place: String,
        /// As given, rad/s or m/s.
        given: f64,
        /// As the positions before and after say, rad/s or m/s.
        moved: f64,
    },
    /// A file's accelerations do not belong to its velocities.
    Accelerations {
        /// Where.
        place: String,
        /// As given, rad/s^2 or m/s^2.
        given: f64,
        /// As the velocities before and after say, rad/s^2 or m/s^2.
        moved: f64,
    },
}

impl Doubt {
    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Self::Degrees { value, .. } => {
                format!(
                    "give joint angles in radians: {value} deg are {:.4} rad",
                    value.to_radians()
                )
            }
            Self::Millimetres { value, .. } => {
                format!("give positions in metres: {value} mm are {} m", value / 1e3)
            }
            Self::Milliseconds { value, .. } => {
                format!(
                    "give times in seconds, at most {LONGEST_S} s: {value} ms are {} s",
                    value / 1e3
                )
            }
            Self::QuaternionOrder { .. } => {
                "the columns go by their names: qw is the scalar part, qx, qy, qz the vector".into()
            }
            Self::Grams { value, .. } => {
                format!("give masses in kilograms: {value} g are {} kg", value / 1e3)
            }
            Self::FarPlace { .. } => {
                format!(
                    "places are in metres in the world, at most {} m from the first",
                    SAME_CELL_M.high
                )
            }
            Self::Radians { values, .. } => {
                let degrees: Vec<String> =
                    values.iter().map(|v| format!("{:.1}", v.to_degrees())).collect();
                format!("in degrees that would be {}", degrees.join(", "))
            }
            Self::HeavyPart { .. } => "check task.part_mass_kg and task.human_load_share".into(),
            Self::DurationOutsideRange { .. } => {
                "put motion.duration_s inside free.duration_s".into()
            }
            Self::Cycles { needed_s, .. } => {
                format!("at most {:.2} cycles a minute fit", 60.0 / needed_s)
            }
            Self::Velocities { .. } | Self::Accelerations { .. } => {
                "the positions count; remove the other values or make them those of the positions"
                    .into()
            }
        }
    }

    /// A warning: what looks odd and what it would mean.
    pub fn warning(&self) -> String {
        format!("{self}; {}", self.remedy())
    }

    /// A refusal that asks.
    pub(super) fn question(&self, file: &Path) -> InputError {
        InputError::new(file, self.to_string()).remedy(self.remedy())
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Degrees { place, value, beyond: Some(beyond) } => write!(
                f,
                "{place}: {value} rad is {beyond:.2} rad beyond the joint's limit. Is it in degrees?"
            ),
            Self::Degrees { place, value, beyond: None } => {
                write!(f, "{place}: {value} rad is {:.1} turns. Is it in degrees?", value / TAU)
            }
            Self::Millimetres { place, value } => {
                write!(
                    f,
                    "{place}: {} m is far outside any cell. Is it in millimetres?",
                    shown(*value)
                )
            }
            Self::Milliseconds { place, value } => write!(
                f,
                "{place}: {value} s is longer than any movement here ({LONGEST_S} s). Is it in \
                 milliseconds?"
            ),
            Self::QuaternionOrder { place, off_deg, other_deg, is_last } => write!(
                f,
                "{place}: the orientation is {off_deg:.0} deg off the scenario's start or goal, but \
                 {other_deg:.0} deg with the scalar part {}. Is the quaternion written with its scalar \
                 {}?",
                if *is_last { "last" } else { "first" },
                if *is_last { "last (x, y, z, w)" } else { "first (w, x, y, z)" }
            ),
            Self::Grams { place, value } => {
                write!(f, "{place} = {value} kg is no load for a hand. Is it in grams?")
            }
            Self::FarPlace { place, value } => {
                write!(f, "{place}: a place {value:.2} m from the first one is not at this cell")
            }
            Self::Radians { place, values } => {
                let given = match values[..] {
                    [one] => one.to_string(),
                    _ => format!("{values:?}"),
                };
                write!(f, "{place} = {given} is read as degrees, but is round in radians")
            }
            Self::HeavyPart { mass_kg } => {
                write!(f, "a part of {mass_kg} kg is more than one hand leads")
            }
            Self::DurationOutsideRange { given_s, taken_s } => write!(
                f,
                "motion.duration_s = {given_s} is outside free.duration_s: {taken_s} s is taken in its \
                 place"
            ),
            Self::Cycles { cycles_per_min, place, needed_s } => write!(
                f,
                "task.cycles_per_min = {cycles_per_min} leaves {:.2} s for a cycle, but {place} alone \
                 takes {needed_s} s",
                60.0 / cycles_per_min
            ),
            Self::Velocities { place, given, moved } => write!(
                f,
                "{place}: the file gives a velocity of {given:.3}, but the positions move at {moved:.3}; \
                 the velocities were not checked"
            ),
            Self::Accelerations { place, given, moved } => write!(
                f,
                "{place}: the file gives an acceleration of {given:.3}, but the velocities change by \
                 {moved:.3} a second; the accelerations were not checked"
            ),
        }
    }
}

/// Angles in degrees that look like radians: all small, and one of them a rounding of a multiple of
/// 45 deg in radians.
pub(super) fn radians(place: &str, values_deg: &[f64]) -> Option<Doubt> {
    let is_small = values_deg.iter().all(|v| v.abs() < MOST_RADIANS);
    (is_small && values_deg.iter().any(|v| is_round_in_radians(*v)))
        .then(|| Doubt::Radians { place: place.to_owned(), values: values_deg.to_vec() })
}

/// Whether a value is, to the digits that it is written with (two or more), a multiple of pi / 4.
fn is_round_in_radians(value: f64) -> bool {
    let written = value.abs().to_string();
    let digits = written.split_once('.').map_or(0, |(_, d)| d.len().min(12) as u8);
    let eighths = (value.abs() / (PI / 4.0)).round();
    let half_digit = 0.5 * 10f64.powi(-i32::from(digits));
    // Written by hand, the last digit may be cut instead of rounded.
    digits >= 2 && eighths >= 1.0 && (value.abs() - eighths * PI / 4.0).abs() <= 2.0 * half_digit
}

/// Load on the hand and mass of the part: grams, or more than a hand leads.
pub(super) fn load(part_kg: f64, load_kg: f64, extra_kg: f64) -> Option<Doubt> {
    let grams = |place: &str, value| Some(Doubt::Grams { place: place.to_owned(), value });
    if extra_kg > HEAVIEST_KG {
        return grams("task.extra_load_kg", extra_kg);
    }
    if load_kg > HEAVIEST_KG {
        return grams("task.part_mass_kg", part_kg);
    }
    (part_kg > HEAVIEST_KG).then_some(Doubt::HeavyPart { mass_kg: part_kg })
}

/// Why a name cannot be used in files, reports and on terminals.
pub(super) fn name_fault(name: &str) -> Option<String> {
    let long = name.chars().count();
    if name.trim().is_empty() {
        Some("is empty".to_owned())
    } else if name.chars().any(char::is_control) {
        Some("holds a control character, such as a line break".to_owned())
    } else if long > LONGEST_NAME {
        Some(format!("has {long} characters; at most {LONGEST_NAME} are shown anywhere"))
    } else if is_formula(name) {
        Some("begins as a formula does, which a spreadsheet would run".to_owned())
    } else {
        None
    }
}

/// Why a path cannot have a name, beyond [`name_fault`].
pub(super) fn path_name_fault(name: &str) -> Option<String> {
    let is_numbered = |rest: &str| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit());
    if let Some(fault) = name_fault(name) {
        return Some(fault);
    }
    if name.contains(['/', '\\']) {
        return Some("holds a slash, as no file name can".to_owned());
    }
    let is_ours = OUR_NAMES.contains(&name)
        || name.starts_with("without ")
        || name.strip_prefix('s').is_some_and(is_numbered);
    is_ours.then(|| "is what the planner calls one of its own paths".to_owned())
}

/// Doubts about a table of a path: `joints` are the columns of the robot's joints in their order.
pub(super) fn of_table(
    table: &NumericTable,
    positions: &[&str],
    joints: &[usize],
    robot: &Robot,
) -> Option<Doubt> {
    let place = |row: usize, column: usize| {
        format!("line {}, column `{}`", table.line(row), table.columns[column])
    };
    let column = |name: &str| table.columns.iter().position(|c| c == name);
    if let Some(t) = column("time_s")
        && let (Some(first), Some(last)) = (table.rows.first(), table.rows.last())
        && last[t] - first[t] > LONGEST_S
    {
        let place = place(table.rows.len() - 1, t);
        return Some(Doubt::Milliseconds { place, value: last[t] - first[t] });
    }
    for (row, values) in table.rows.iter().enumerate() {
        for c in positions.iter().filter_map(|name| column(name)) {
            if !COORDINATE_M.holds(values[c]) {
                return Some(Doubt::Millimetres { place: place(row, c), value: values[c] });
            }
        }
        for (joint, &c) in joints.iter().enumerate() {
            if let Some(doubt) = of_joint(robot, joint, values[c], || place(row, c)) {
                return Some(doubt);
            }
        }
    }
    None
}

/// Doubts about a position of a joint.
pub(super) fn of_joint(
    robot: &Robot,
    joint: usize,
    value: f64,
    place: impl FnOnce() -> String,
) -> Option<Doubt> {
    let (lower, upper) = (robot.limits.lower[joint], robot.limits.upper[joint]);
    let beyond = (lower - value).max(value - upper);
    if robot.linkage.joints()[joint].is_prismatic {
        let is_far = beyond > SLID_BEYOND_M || !COORDINATE_M.holds(value);
        return is_far.then(|| Doubt::Millimetres { place: place(), value });
    }
    if beyond > TAU {
        return Some(Doubt::Degrees { place: place(), value, beyond: Some(beyond) });
    }
    let is_endless = lower.is_infinite() || upper.is_infinite();
    (is_endless && value.abs() > MOST_TURNED_RAD).then(|| Doubt::Degrees {
        place: place(),
        value,
        beyond: None,
    })
}

/// Whether first and last orientation of a path fit start and goal only with the quaternion read in
/// another order. (How smooth a path is tells nothing: a change of the order keeps all angles between
/// its poses.)
pub(super) fn order(place: &str, path: [&Pose; 2], ends: [&Pose; 2]) -> Option<Doubt> {
    let off = |turned: &dyn Fn(&UnitQuaternion<f64>) -> UnitQuaternion<f64>| {
        let angles = path.iter().zip(ends).map(|(p, e)| turned(&p.rotation).angle_to(&e.rotation));
        angles.fold(0.0, f64::max).to_degrees()
    };
    let as_read = off(&|q| *q);
    // What was read as w, x, y, z is x, y, z, w; or the other way round.
    let last = off(&|q| UnitQuaternion::new_normalize(Quaternion::new(q.k, q.w, q.i, q.j)));
    let first = off(&|q| UnitQuaternion::new_normalize(Quaternion::new(q.i, q.j, q.k, q.w)));
    let (other_deg, is_last) = if last <= first { (last, true) } else { (first, false) };
    let is_better = as_read > ORDER_OFF_DEG && other_deg < ORDER_FITS_DEG;
    is_better.then(|| Doubt::QuaternionOrder {
        place: place.to_owned(),
        off_deg: as_read,
        other_deg,
        is_last,
    })
}

#[cfg(test)]
mod tests;

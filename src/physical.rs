//! The ranges that numbers about people, robots and cells lie in, each with its reason.
//!
//! Whatever a file says beyond its range is refused where it is read; what is only unusual is asked about or
//! warned of there. Ranges are wide: they part what is possible from what is a slip of the pen, another unit or
//! a broken file, and no more. A number that is none (NaN) is in no range.

use std::f64::consts::{PI, TAU};
use std::fmt;

/// From the least to the greatest value that is possible, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least.
    pub low: f64,
    /// Greatest.
    pub high: f64,
    /// Unit of both, as it is shown; empty for a bare number.
    pub unit: &'static str,
}

impl Range {
    const fn new(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, high, unit }
    }

    /// As far to either side of zero.
    const fn within(most: f64, unit: &'static str) -> Self {
        Self::new(-most, most, unit)
    }

    /// Whether a number lies in it.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// The first number that does not lie in it.
    pub fn outside(&self, values: impl IntoIterator<Item = f64>) -> Option<f64> {
        values.into_iter().find(|v| !self.holds(*v))
    }

    /// Why a named number cannot be; none where it lies in the range.
    pub fn fault(&self, what: &str, value: f64) -> Option<String> {
        (!self.holds(value)).then(|| format!("{what} {} is outside {self}", shown(value)))
    }
}

/// A number as it is shown in errors: powers of ten instead of rows of zeros, and no more digits than anybody
/// reads.
pub fn shown(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        ((value * 1e4).round() / 1e4).to_string()
    } else if value.is_finite() {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} to {}", shown(self.low), shown(self.high))?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

// The cell.

/// A coordinate in the world: one person and one robot share a few metres; a robot on a track may travel ten.
pub const COORDINATE_M: Range = Range::within(20.0, "m");
/// Where the handle or a hand is from the tool centre point: farther than an arm, nobody holds it.
pub const GRIP_M: Range = Range::within(1.5, "m");
/// Size of an obstacle: from a wire to the floor of a hall.
pub const OBSTACLE_M: Range = Range::new(1e-3, 100.0, "m");
/// How far an equivalent place, or a point of a path, may be from the first: what a person and one robot share.
pub const SAME_CELL_M: Range = Range::new(0.0, 3.0, "m");
/// How far the place of worker, robot, start or goal may be moved by the planner, either way.
pub const MOVED_M: Range = Range::new(0.0, 2.0, "m");
/// A number of a direction, whose length does not count.
pub const DIRECTION: Range = Range::within(1e3, "");
/// Duration of one movement: shorter ones no hand follows, longer ones are in milliseconds.
pub const DURATION_S: Range = Range::new(0.05, 600.0, "s");
/// An angle about a fixed axis, in degrees: two turns either way.
pub const ANGLE_DEG: Range = Range::within(720.0, "deg");

// People.

/// Stature of adults: beyond 1.2 to 2.3 m the proportions of the survey (1.4 to 2.0 m) say nothing.
pub const STATURE_M: Range = Range::new(1.2, 2.3, "m");
/// Mass of adults.
pub const BODY_MASS_KG: Range = Range::new(30.0, 250.0, "kg");
/// Angle of a joint of a person: none turns farther than one turn, whatever its zero is.
pub const JOINT_RAD: Range = Range::within(TAU, "rad");
/// The same in degrees.
pub const JOINT_DEG: Range = Range::within(360.0, "deg");
/// A coordinate of a pelvis over the length of the leg: within some steps of where the person stands.
pub const PELVIS_LEGS: Range = Range::within(10.0, "leg lengths");
/// Speed of a joint of a person. The quickest that was measured, the inward turn of a pitcher's upper arm, is
/// some 130 rad/s (7,500 deg/s; Fleisig et al. 1999).
pub const JOINT_SPEED_RAD_S: Range = Range::within(150.0, "rad/s");
/// Speed of a hand: a pitcher's reaches some 40 m/s.
pub const HAND_SPEED_M_S: Range = Range::new(1e-4, 50.0, "m/s");
/// A place in a person's rest frame over the stature: no hand is farther than that from the pelvis.
pub const OVER_STATURE: Range = Range::within(2.0, "statures");
/// Length of a hand: adults' are 0.15 to 0.24 m.
pub const HAND_M: Range = Range::new(0.1, 0.3, "m");
/// Hip joints above the seat: thighs and buttocks of adults.
pub const SEAT_TO_HIP_M: Range = Range::new(0.02, 0.2, "m");
/// Hip joints above the floor, over the stature: 0.52 on the average of either sex.
pub const LEG_OVER_STATURE: Range = Range::new(0.4, 0.65, "statures");
/// Share of something.
pub const SHARE: Range = Range::new(0.0, 1.0, "");

// Robots, as a URDF describes them. Nothing but what says "no limit" in files that are in use is larger.

/// A place in the frame of a link, m.
pub const LINK_M: Range = Range::within(20.0, "m");
/// A turn in the frame of a link: files have up to one turn; 45, 90 and 180 are degrees.
pub const LINK_RAD: Range = Range::within(4.0 * PI, "rad");
/// Size of a shape.
pub const SHAPE_M: Range = Range::new(0.0, 20.0, "m");
/// Limit of a joint that turns: four turns either way, cables allow no more.
pub const TURN_RAD: Range = Range::within(4.0 * TAU, "rad");
/// Limit of a joint that slides: the longest tracks.
pub const SLIDE_M: Range = Range::within(50.0, "m");
/// Limit of a joint in the file itself: wide enough for degrees and millimetres, which are asked about where a
/// robot is made of it, and for how some files write a turn without end.
pub const JOINT_LIMIT: Range = Range::within(1e4, "rad or m");
/// Speed of a joint: the quickest axes of industrial robots turn at some 60 rad/s.
pub const ROBOT_SPEED: Range = Range::new(0.0, 100.0, "rad/s or m/s");
/// Acceleration of a joint that somebody gives: the quickest small arms reach some 1,000 rad/s^2.
pub const ROBOT_ACCELERATION: Range = Range::new(0.0, 1e4, "rad/s^2");
/// Speed and acceleration of a joint in the file itself, for the same reason; below zero is told by its reader.
pub const RATE: Range = Range::within(1e7, "rad/s or rad/s^2");
/// What files write for "as strong as you like"; not used.
pub const EFFORT: Range = Range::new(0.0, 1e12, "N m");
/// Length of the vector of an axis before it is normalised.
pub const AXIS: Range = Range::within(1e3, "");
/// Mass of a link: the heaviest robots are some 10 t.
pub const LINK_KG: Range = Range::new(0.0, 1e5, "kg");
/// Inertia of a link; not used.
pub const INERTIA: Range = Range::within(1e6, "kg m^2");
/// Factor of a mesh: from nanometres to kilometres.
pub const MESH_SCALE: Range = Range::within(1e3, "");
/// A colour: shares, or bytes in files that do not keep to the format; not used.
pub const COLOUR: Range = Range::new(0.0, 255.0, "");
/// Gains, damping, friction and ratios of gears; not used but for a joint that follows another.
pub const GAIN: Range = Range::within(1e9, "");
/// Ratio and offset of a joint that follows another.
pub const MIMIC: Range = Range::within(1e3, "");

// Recordings.

/// Where a recorded person may be: a capture volume is some metres wide; without one, inertial suits drift by
/// hundreds.
pub const RECORDED_M: Range = Range::within(1e4, "m");
/// Speed of a joint centre between two frames: beyond it is no movement but another place. What is above 25 m/s is
/// noted as a jump.
pub const RECORDED_SPEED_M_S: Range = Range::new(0.0, 1e3, "m/s");

// Results, models and figures of quality.

/// A number of no unit that is positive, such as a length-scale or a spread; 1e6 stands for "does not count".
pub const POSITIVE: Range = Range::new(1e-9, 1e7, "");

/// Anything else that is reported: beyond it no figure of a run can be.
pub const FIGURE: Range = Range::within(1e8, "");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_count_and_what_is_no_number_does_not() {
        assert!(STATURE_M.holds(1.2) && STATURE_M.holds(2.3));
        for value in [1.19, 2.31, -1.7, 0.0, 1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!STATURE_M.holds(value), "{value}");
        }
        assert_eq!(SHARE.outside([0.0, 0.5, 1.0]), None);
        assert_eq!(SHARE.outside([0.0, 1.5, -1.0]), Some(1.5));
        assert_eq!(
            STATURE_M.fault("stature", 170.0).as_deref(),
            Some("stature 170 is outside 1.2 to 2.3 m")
        );
        assert_eq!(
            STATURE_M.fault("stature", 1e308).as_deref(),
            Some("stature 1e308 is outside 1.2 to 2.3 m")
        );
        assert_eq!(RATE.to_string(), "-1e7 to 1e7 rad/s or rad/s^2");
        assert_eq!(TURN_RAD.to_string(), "-25.1327 to 25.1327 rad");
        assert_eq!(POSITIVE.to_string(), "1e-9 to 1e7");
        assert_eq!(SHARE.to_string(), "0 to 1");
    }
}

//! Paths in words: why there is none, checks of limits, and what would have to change.

use super::{end, robot};
use crate::path::{Change, Check, Face, LimitName, Mover, NoAnswer, NoPath, Quantity};
use crate::robot::LimitKind;

/// Why there is no path, as the end of a sentence.
pub fn no_path(why: &NoPath) -> String {
    match why {
        NoPath::Input { fault } => fault.to_string(),
        NoPath::OutsideBox { end: which, face: beyond, at_m } => format!(
            "the {} is outside the workspace box ({}; its {} is {at_m:.3} m)",
            end(*which),
            face(beyond),
            axis(beyond)
        ),
        NoPath::InsideObstacle { end: which, obstacle, depth_m } => {
            format!(
                "the {} is inside obstacle `{obstacle}`, {:.0} mm deep",
                end(*which),
                1e3 * depth_m
            )
        }
        NoPath::BeyondReach { end: which, body, by_m } => format!(
            "the {} is out of reach of body `{body}`: {:.0} mm farther than any posture brings the hand",
            end(*which),
            1e3 * by_m
        ),
        NoPath::TooShortToTurn {
            duration_s,
            needed_s,
            angle_rad,
            angular_speed_rad_s,
            angular_acceleration_rad_s2,
        } => format!(
            "{duration_s:.2} s is too short: at {angular_speed_rad_s} rad/s and \
             {angular_acceleration_rad_s2} rad/s^2 the turn of {:.0} deg needs at least {:.2} s",
            angle_rad.to_degrees(),
            up(*needed_s)
        ),
        NoPath::TooShort {
            duration_s,
            needed_s,
            distance_m,
            speed_m_s,
            acceleration_m_s2,
            jerk_m_s3,
        } => format!(
            "{duration_s:.2} s is too short: at {speed_m_s} m/s, {acceleration_m_s2} m/s^2 and \
             {jerk_m_s3} m/s^3 a path over {distance_m:.2} m needs at least {:.2} s",
            up(*needed_s)
        ),
        NoPath::JointsTooSlow => {
            "the robot's joints cannot follow any path near this one in time".to_owned()
        }
        NoPath::Contradiction { limits } => {
            let all: Vec<String> = limits.iter().map(limit).collect();
            format!("these limits contradict each other: {}", all.join(", "))
        }
        NoPath::Blocked { obstacle, at_s, by_m, clearance_m } => format!(
            "obstacle `{obstacle}` leaves no way on this side: at {at_s:.2} s the TCP comes {:.0} mm \
             nearer than its clearance of {:.0} mm",
            1e3 * by_m,
            1e3 * clearance_m
        ),
        NoPath::Corridor { at_s, by_m } => format!(
            "the corridor is too narrow: at {at_s:.2} s the path is {:.0} mm outside",
            1e3 * by_m
        ),
        NoPath::LeavesReach { body, at_s, by_m } => format!(
            "the path leaves the reach of body `{body}`: at {at_s:.2} s by {:.0} mm",
            1e3 * by_m
        ),
        NoPath::Unsolved { answer } => {
            format!("the solver found no path and no reason against one: {}", no_answer(answer))
        }
        NoPath::NoMotion { motion } => robot::no_motion(motion),
    }
}

fn no_answer(answer: &NoAnswer) -> String {
    match answer {
        NoAnswer::Unbounded => "the program is unbounded".to_owned(),
        NoAnswer::Inaccurate => "its solution is not accurate enough".to_owned(),
        NoAnswer::NotSettled => "the path did not settle".to_owned(),
        NoAnswer::Stopped { status } => format!("it stopped ({status})"),
    }
}

fn limit(limit: &LimitName) -> String {
    match limit {
        LimitName::Speed => "speed".to_owned(),
        LimitName::Acceleration => "acceleration".to_owned(),
        LimitName::Jerk => "jerk".to_owned(),
        LimitName::Face(of) => format!("workspace box ({})", face(of)),
    }
}

fn axis(face: &Face) -> &'static str {
    ["x", "y", "z"].get(face.axis).copied().unwrap_or("coordinate")
}

/// A face of a box, such as `x <= 0.80 m`.
pub fn face(face: &Face) -> String {
    let sign = if face.is_upper { "<=" } else { ">=" };
    format!("{} {sign} {:.2} m", axis(face), face.at_m)
}

/// Hundredths, upward, so that what is printed is enough.
fn up(x: f64) -> f64 {
    (x * 100.0 - 1e-9).ceil() / 100.0
}

/// One thing to change, such as "3.15 s instead of 1.20 s".
pub fn change(change: &Change) -> String {
    let mm = |x: &f64| (x * 1e3 - 1e-6).ceil().max(1.0);
    match change {
        Change::Duration { from_s, to_s } => format!("{:.2} s instead of {from_s:.2} s", up(*to_s)),
        Change::Limit { of, from, to } => {
            let (name, unit) = quantity(*of);
            format!("a limit of {:.2} {unit} instead of {from:.2} {unit} on the {name}", up(*to))
        }
        Change::MoveEnd { end: which, by_m, to_m } => format!(
            "the {} {:.0} mm away, at ({:.3}, {:.3}, {:.3}) m",
            end(*which),
            mm(by_m),
            to_m.x,
            to_m.y,
            to_m.z
        ),
        Change::MoveFace { face: of, by_m } => {
            let (of, by) = (face(of), mm(by_m));
            format!("the face {of} of the workspace box {by:.0} mm farther out")
        }
        Change::ShrinkObstacle { name, by_m } => {
            format!("obstacle `{name}` (or the clearance) {:.0} mm smaller", mm(by_m))
        }
        Change::WidenCorridor { from_m, to_m } => {
            format!("a corridor of {:.0} mm instead of {:.0} mm", mm(to_m), from_m * 1e3)
        }
        Change::ExtendReach { body, by_m } => format!("body `{body}` {:.0} mm nearer", mm(by_m)),
        Change::JointLimit { joint, of, is_prismatic, from, to } => {
            let (name, unit) = joint_limit(*of, *is_prismatic);
            let to = up(*to);
            format!(
                "a limit of {to:.2} {unit} instead of {from:.2} {unit} on the {name} of joint `{joint}`"
            )
        }
        Change::MoveApart { what: Mover::Worker, by_m } => {
            format!("the worker {:.0} mm farther from the robot", mm(by_m))
        }
        Change::MoveApart { what: Mover::Robot, by_m } => {
            format!("the robot's base {:.0} mm farther from the worker", mm(by_m))
        }
        Change::RobotReach { by_m, at_s } => {
            format!("a path or a robot base that is {:.0} mm nearer at {at_s:.2} s", mm(by_m))
        }
    }
}

/// What a joint's limit is of, and its unit.
pub fn joint_limit(of: LimitKind, is_prismatic: bool) -> (&'static str, &'static str) {
    match (of, is_prismatic) {
        (LimitKind::Position, false) => ("position", "rad"),
        (LimitKind::Position, true) => ("position", "m"),
        (LimitKind::Velocity, false) => ("speed", "rad/s"),
        (LimitKind::Velocity, true) => ("speed", "m/s"),
        (LimitKind::Acceleration, false) => ("acceleration", "rad/s^2"),
        (LimitKind::Acceleration, true) => ("acceleration", "m/s^2"),
    }
}

/// What would help: "; what would help, each alone: A, or B"; empty without changes.
pub fn or_list(changes: &[Change]) -> String {
    let all: Vec<String> = changes.iter().map(change).collect();
    match all.len() {
        0 => String::new(),
        1 => format!("; what would help: {}", all[0]),
        _ => format!("; what would help, each alone: {}", all.join(", or ")),
    }
}

/// Value, time and limit of a check.
pub fn check(check: &Check) -> String {
    let (name, unit) = quantity(check.quantity);
    let relation = if check.is_met() { "within" } else { "over" };
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let Check { value, at_s, limit, .. } = check;
    format!("{name} {value:.4}{unit} at {at_s:.2} s is {relation} the limit of {limit:.4}{unit}")
}

/// Name and unit of a quantity within a sentence.
pub fn quantity(quantity: Quantity) -> (&'static str, &'static str) {
    match quantity {
        Quantity::Speed => ("speed", "m/s"),
        Quantity::Acceleration => ("acceleration", "m/s^2"),
        Quantity::Jerk => ("jerk", "m/s^3"),
        Quantity::Workspace => ("distance outside the workspace box", "m"),
        Quantity::AngularSpeed => ("angular speed", "rad/s"),
        Quantity::AngularAcceleration => ("angular acceleration", "rad/s^2"),
        Quantity::Rest => ("speed at an end of the path", "m/s"),
        Quantity::Continuity => ("jump between steps", ""),
        Quantity::KeepOut => ("depth inside the clearance of an obstacle", "m"),
        Quantity::Corridor => ("distance outside the corridor", "m"),
        Quantity::Reach => ("distance outside a hand's reach", "m"),
        Quantity::JointSpeed => ("share of a joint's speed limit", ""),
        Quantity::JointAcceleration => ("share of a joint's acceleration limit", ""),
        Quantity::JointRange => ("distance of a joint beyond its range", "rad"),
        Quantity::Tracking => ("distance of the robot from the path", "m"),
        Quantity::Equality => ("optimality: equalities", ""),
        Quantity::Cone => ("optimality: cones", ""),
        Quantity::Stationarity => ("optimality: gradient", ""),
        Quantity::Complementarity => ("optimality: duality gap", ""),
    }
}

/// Name and unit of a quantity as the head of a row.
pub fn quantity_heading(quantity: Quantity) -> (&'static str, &'static str) {
    match quantity {
        Quantity::Speed => ("speed of the tool", "m/s"),
        Quantity::Acceleration => ("acceleration", "m/s²"),
        Quantity::Jerk => ("jerk, largest component", "m/s³"),
        Quantity::Workspace => ("distance outside the workspace box (negative: inside)", "m"),
        Quantity::AngularSpeed => ("angular speed", "rad/s"),
        Quantity::AngularAcceleration => ("angular acceleration", "rad/s²"),
        Quantity::Rest => ("speed at start and goal (at rest)", "m/s"),
        Quantity::Continuity => ("largest jump between steps", "SI"),
        Quantity::KeepOut => ("depth inside an obstacle's clearance (negative: clear)", "m"),
        Quantity::Corridor => ("distance outside the corridor (negative: inside)", "m"),
        Quantity::Reach => ("distance outside a hand's reach (negative: inside)", "m"),
        Quantity::JointSpeed => ("robot joint speed, share of its limit", ""),
        Quantity::JointAcceleration => ("robot joint acceleration, share of its limit", ""),
        Quantity::JointRange => ("robot joint beyond its range (negative: inside)", "rad"),
        Quantity::Tracking => ("robot beside the path, between knots too", "m"),
        Quantity::Equality => ("projection: residual of the equalities", ""),
        Quantity::Cone => ("projection: distance from the cones", ""),
        Quantity::Stationarity => ("projection: gradient at the optimum", ""),
        Quantity::Complementarity => ("projection: duality gap", ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::path::End;

    #[test]
    fn refusals_name_value_limit_and_need() {
        let short = NoPath::TooShort {
            duration_s: 1.2,
            needed_s: 3.1501,
            distance_m: 0.7,
            speed_m_s: 0.25,
            acceleration_m_s2: 1.0,
            jerk_m_s3: 10.0,
        };
        assert_eq!(
            no_path(&short),
            "1.20 s is too short: at 0.25 m/s, 1 m/s^2 and 10 m/s^3 a path over 0.70 m needs at least \
             3.16 s"
        );
        let face = Face { axis: 1, is_upper: true, at_m: 0.3 };
        assert_eq!(
            no_path(&NoPath::OutsideBox { end: End::Goal, face, at_m: 0.5 }),
            "the goal is outside the workspace box (y <= 0.30 m; its y is 0.500 m)"
        );
        let limits = vec![LimitName::Jerk, LimitName::Face(face)];
        assert_eq!(
            no_path(&NoPath::Contradiction { limits }),
            "these limits contradict each other: jerk, workspace box (y <= 0.30 m)"
        );
    }

    #[test]
    fn changes_are_rounded_so_that_they_are_enough() {
        let duration = Change::Duration { from_s: 1.2, to_s: 3.1501 };
        assert_eq!(change(&duration), "3.16 s instead of 1.20 s");
        let to_m = Vec3::new(0.5, 0.15, 1.0);
        let goal = Change::MoveEnd { end: End::Goal, by_m: 0.0491, to_m };
        assert_eq!(change(&goal), "the goal 50 mm away, at (0.500, 0.150, 1.000) m");
        assert_eq!(or_list(&[]), "");
        assert_eq!(or_list(&[duration]), "; what would help: 3.16 s instead of 1.20 s");
        let joint = "j1".to_owned();
        let (of, is_prismatic) = (LimitKind::Velocity, false);
        let faster = Change::JointLimit { joint, of, is_prismatic, from: 1.0, to: 1.234 };
        assert_eq!(
            change(&faster),
            "a limit of 1.24 rad/s instead of 1.00 rad/s on the speed of joint `j1`"
        );
    }

    #[test]
    fn a_broken_check_says_by_what() {
        let outside = Check { quantity: Quantity::Workspace, value: 0.01, limit: 0.0, at_s: 2.0 };
        assert_eq!(
            check(&outside),
            "distance outside the workspace box 0.0100 m at 2.00 s is over the limit of 0.0000 m"
        );
    }
}

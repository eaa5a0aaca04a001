//! Robots in words: why one cannot follow, how near it comes to its limits and to what is around it.

use super::number::percent;
use super::path::joint_limit;
use crate::planner::PersonClearance;
use crate::robot::{
    Assumed, AssumedShapes, AtLimit, JointMargin, LimitKind, MeshFault, MissingMesh, NoMotion,
    NotChecked, ObstacleClearance, RobotFacts, RobotMargins, RobotNote, SelfCheck, SelfClearance,
    Violation,
};

/// Links named in a note before it says "and more".
const MOST_NAMED: usize = 8;

/// Why the robot cannot follow a path, as the end of a sentence.
pub fn no_motion(why: &NoMotion) -> String {
    match why {
        NoMotion::Malformed { fault } => fault.to_string(),
        NoMotion::NoStart => "no start posture with one number per joint is given".to_owned(),
        NoMotion::OutOfReach { time_s, residual_m, residual_rad, at_limits: joints } => format!(
            "the TCP pose at t = {time_s:.2} s is out of reach (nearest {residual_m:.3} m and {:.1} deg \
             off{})",
            residual_rad.to_degrees(),
            at_limits(joints)
        ),
        NoMotion::Jump { time_s, at_limits: joints } => format!(
            "the TCP pose at t = {time_s:.2} s cannot be reached without a jump from the posture before \
             it{}",
            at_limits(joints)
        ),
        NoMotion::OverLimit { violation: over, is_nearly_singular } => {
            let singular =
                if *is_nearly_singular { "; the arm is nearly singular there" } else { "" };
            violation(over) + singular
        }
        NoMotion::TouchesItself { nearest } => format!(
            "the arm would touch itself at t = {:.2} s: link `{}` and link `{}` overlap by {:.0} mm",
            nearest.time_s,
            nearest.links[0],
            nearest.links[1],
            -1e3 * nearest.distance_m
        ),
        NoMotion::BetweenKnots { joint, of, value, time_s } => {
            let what = match of {
                LimitKind::Position => "leave its range".to_owned(),
                LimitKind::Velocity => format!("move at {:.1} % of its limit", 100.0 * value),
                LimitKind::Acceleration => {
                    format!("accelerate at {:.1} % of its limit", 100.0 * value)
                }
            };
            format!("joint `{joint}` would {what} at t = {time_s:.2} s, between the knots")
        }
    }
}

/// ", joint `x` at its limit 1.7600 rad" for each joint.
fn at_limits(joints: &[AtLimit]) -> String {
    let of = |l: &AtLimit| {
        let unit = joint_limit(LimitKind::Position, l.is_prismatic).1;
        format!(", joint `{}` at its limit {:.4} {unit}", l.joint, l.limit)
    };
    joints.iter().map(of).collect()
}

/// A broken limit of a joint.
pub fn violation(over: &Violation) -> String {
    let does = match over.kind {
        LimitKind::Position => "would stand at",
        LimitKind::Velocity => "would move at",
        LimitKind::Acceleration => "would accelerate at",
    };
    let unit = joint_limit(over.kind, over.is_prismatic).1;
    let assumed = if over.is_assumed { " (assumed)" } else { "" };
    let Violation { joint, value, time_s, limit, .. } = over;
    format!(
        "joint `{joint}` {does} {value:.4} {unit} at t = {time_s:.2} s; its limit is {limit:.4} \
         {unit}{assumed}"
    )
}

/// A joint whose limits are broken between the points of a trajectory.
pub fn between_points(margin: &JointMargin) -> String {
    let share = |s: Option<f64>| format!("{:.1} %", 100.0 * s.unwrap_or(0.0));
    format!(
        "joint `{}` between the points: {} of its speed, {} of its acceleration",
        margin.joint,
        share(margin.velocity_share),
        share(margin.acceleration_share)
    )
}

/// How near a motion comes to the limits of the joints, a line each.
pub fn margins(found: &RobotMargins) -> Vec<String> {
    let RobotMargins { speed, acceleration, range, min_singular_value } = found;
    let share = |name: &str, of: &crate::robot::Extreme| {
        format!(
            "joint {name}: at most {} of its limit ({} at {:.2} s)",
            percent(of.value),
            of.joint,
            of.time_s
        )
    };
    vec![
        share("speed", speed),
        share("acceleration", acceleration),
        if range.value.is_finite() {
            format!(
                "joint range: {:.1} deg left ({} at {:.2} s)",
                range.value.to_degrees(),
                range.joint,
                range.time_s
            )
        } else {
            "joint range: no joint has an end".to_owned()
        },
        format!("smallest singular value {min_singular_value:.3} (rotation scaled by 0.3 m)"),
    ]
}

/// Why nothing was checked.
pub fn not_checked(why: NotChecked) -> String {
    match why {
        NotChecked::NoShapes => "the robot has no collision shapes".to_owned(),
        NotChecked::TooFewShapes => "too few of the robot's links have collision shapes".to_owned(),
        NotChecked::AssumedShapes => {
            "the shapes of the robot's links are assumed, too coarsely for that".to_owned()
        }
        NotChecked::NoMotion => "the robot does not follow the path".to_owned(),
    }
}

/// Behind a distance: what stood for the links.
fn against(is_assumed: bool) -> &'static str {
    if is_assumed { ", against assumed capsules" } else { "" }
}

/// Links whose shapes are not known, and what stands for them.
pub fn assumed_shapes(shapes: &AssumedShapes) -> String {
    let AssumedShapes { links, radius_m } = shapes;
    let what = match &links[..] {
        [one] => format!("the shape of link `{one}` is not known"),
        many => format!("the shapes of {} links are not known", many.len()),
    };
    format!(
        "{what}; assumed capsules, {:.0} mm about the lines from joint to joint, were checked instead",
        1e3 * radius_m
    )
}

/// How near the arm comes to itself.
pub fn self_clearance(found: &SelfClearance) -> String {
    match found {
        SelfClearance::Least { nearest, is_assumed } => format!(
            "smallest distance of the arm to itself {:.0} mm (links `{}` and `{}` at {:.2} s{})",
            1e3 * nearest.distance_m,
            nearest.links[0],
            nearest.links[1],
            nearest.time_s,
            against(*is_assumed)
        ),
        SelfClearance::NotChecked { why } => {
            format!("collision of the arm with itself: not checked: {}", not_checked(*why))
        }
    }
}

/// How near the arm comes to obstacles.
pub fn obstacle_clearance(found: &ObstacleClearance) -> String {
    match found {
        ObstacleClearance::Least { nearest, is_assumed } => format!(
            "smallest clearance to an obstacle {:.0} mm (link `{}` and obstacle `{}`{})",
            1e3 * nearest.distance_m,
            nearest.link,
            nearest.obstacle,
            against(*is_assumed)
        ),
        ObstacleClearance::NoObstacle => {
            "no obstacle was given, so no clearance was checked".to_owned()
        }
        ObstacleClearance::NotChecked { why } => {
            format!("clearance of the arm to obstacles: not checked: {}", not_checked(*why))
        }
    }
}

/// How near the robot comes to a person.
pub fn person_clearance(near: &PersonClearance) -> String {
    format!(
        "nearest {:.0} mm (link `{}` and the {} at {:.2} s), 5th percentile {:.0} mm; {} of {} \
         repetitions nearer than {:.0} mm, {} allowed",
        1e3 * near.min_m,
        near.link,
        near.body_part,
        near.time_s,
        1e3 * near.p05_m,
        percent(near.share_below),
        near.repetitions,
        1e3 * near.margin_m,
        percent(near.share_allowed)
    )
}

/// What of the arm's collision with itself is checked.
pub fn self_check(check: &SelfCheck) -> String {
    match check {
        SelfCheck::Checked { pairs, left_out } => {
            let names: Vec<String> = left_out.iter().map(|[a, b]| format!("{a} and {b}")).collect();
            let rest = if names.is_empty() {
                String::new()
            } else {
                let names = names.join(", ");
                format!(
                    "; left out because their capsules touch in nearly every posture or at home: {names}"
                )
            };
            format!("collision of the arm with itself: {pairs} pairs of links checked{rest}")
        }
        SelfCheck::NotChecked { why } => {
            format!("collision of the arm with itself: not checked: {}", not_checked(*why))
        }
    }
}

/// Something that is a stand-in or from memory.
pub fn assumed(what: &Assumed) -> String {
    match what {
        Assumed::Declared { text } => text.clone(),
        Assumed::Limits { robot, of, joints } => {
            let (of, joints) = (joint_limit(*of, false).0, joints.join(", "));
            format!("{robot}: the {of} limits of {joints} are stand-ins")
        }
    }
}

/// A remark about a robot's description.
pub fn note(note: &RobotNote) -> String {
    match note {
        RobotNote::File { text } => text.clone(),
        RobotNote::FittedCapsules { links, meshes, capsules } => format!(
            "{} fitted to {}, which they hold, for the links {}",
            counted(*capsules, "capsule"),
            counted(*meshes, "mesh"),
            some(links)
        ),
        RobotNote::AssumedCapsules { links, radius_m, missing } => {
            let why = match &missing[..] {
                [] => "no shape is given".to_owned(),
                [first, ..] => {
                    let count = counted(missing.len(), "mesh");
                    format!("{count} cannot be used ({})", mesh_fault(first))
                }
            };
            format!(
                "assumed capsules, {:.0} mm about the lines from joint to joint, for the links {}: {why}",
                1e3 * radius_m,
                some(links)
            )
        }
    }
}

/// Why a mesh cannot be used.
fn mesh_fault(mesh: &MissingMesh) -> String {
    let file = &mesh.file;
    match &mesh.fault {
        MeshFault::NotFound => {
            format!("`{file}` is not found; put its package beside the URDF or in a folder above")
        }
        MeshFault::Unreadable { message } => format!("`{file}` {message}"),
        MeshFault::TooLarge { longest_m } => format!(
            "`{file}` would be {longest_m} m long; in millimetres it needs scale=\"0.001 0.001 0.001\""
        ),
    }
}

fn counted(count: usize, what: &str) -> String {
    match (count, what) {
        (1, _) => format!("1 {what}"),
        (_, "mesh") => format!("{count} meshes"),
        _ => format!("{count} {what}s"),
    }
}

/// The first of some names.
fn some(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A robot as the reader of a result should know it, a line each.
pub fn facts(robot: &RobotFacts) -> Vec<String> {
    let mut lines = vec![robot.name.clone()];
    lines.extend(robot.assumed.iter().map(|a| format!("assumed: {}", assumed(a))));
    lines.extend(robot.notes.iter().map(note));
    lines.extend(robot.assumed_shapes.iter().map(assumed_shapes));
    lines.push(self_check(&robot.self_check));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::SelfNearest;

    #[test]
    fn what_was_not_checked_says_why() {
        let why = NotChecked::TooFewShapes;
        assert_eq!(
            self_clearance(&SelfClearance::NotChecked { why }),
            "collision of the arm with itself: not checked: too few of the robot's links have collision shapes"
        );
        let none = obstacle_clearance(&ObstacleClearance::NotChecked { why: NotChecked::NoShapes });
        assert_eq!(
            none,
            "clearance of the arm to obstacles: not checked: the robot has no collision shapes"
        );
        let links = ["one", "two"].map(str::to_owned);
        let nearest = SelfNearest { distance_m: 0.0312, links, time_s: 1.5 };
        assert_eq!(
            self_clearance(&SelfClearance::Least { nearest: nearest.clone(), is_assumed: false }),
            "smallest distance of the arm to itself 31 mm (links `one` and `two` at 1.50 s)"
        );
        assert_eq!(
            self_clearance(&SelfClearance::Least { nearest, is_assumed: true }),
            "smallest distance of the arm to itself 31 mm (links `one` and `two` at 1.50 s, against assumed \
             capsules)"
        );
    }

    #[test]
    fn refusals_name_joint_value_time_and_limit() {
        let over = Violation {
            kind: LimitKind::Velocity,
            joint: "j1".to_owned(),
            is_prismatic: false,
            time_s: 1.25,
            value: 4.0,
            limit: 2.175,
            is_assumed: true,
        };
        assert_eq!(
            no_motion(&NoMotion::OverLimit { violation: over, is_nearly_singular: true }),
            "joint `j1` would move at 4.0000 rad/s at t = 1.25 s; its limit is 2.1750 rad/s (assumed); \
             the arm is nearly singular there"
        );
        let at_limits = vec![AtLimit { joint: "slide".to_owned(), limit: 0.5, is_prismatic: true }];
        let far =
            NoMotion::OutOfReach { time_s: 2.0, residual_m: 0.0123, residual_rad: 0.0, at_limits };
        assert_eq!(
            no_motion(&far),
            "the TCP pose at t = 2.00 s is out of reach (nearest 0.012 m and 0.0 deg off, joint `slide` \
             at its limit 0.5000 m)"
        );
    }
}

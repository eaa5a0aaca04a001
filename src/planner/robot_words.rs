//! The robot's motion in words: margins, and why it cannot start or follow.

use crate::robot::{JointTrajectory, Robot, RobotMotion, Starts};
use crate::trajectory::TimedPath;

/// How near the arm comes to itself, or why that is not known.
pub(super) fn self_clearance_words(robot: &Robot, motion: Option<&RobotMotion>) -> String {
    let Some(near) = motion.and_then(|m| m.self_nearest.as_ref()) else {
        return robot.self_collision_note();
    };
    let [a, b] = &near.links;
    format!(
        "smallest distance of the arm to itself {:.0} mm (links `{a}` and `{b}` at {:.2} s)",
        1e3 * near.distance_m,
        near.time_s
    )
}

/// Why the robot cannot even start.
pub(super) fn out_of_reach(starts: &Starts) -> String {
    format!(
        "the start is out of the robot's reach (nearest {:.0} mm and {:.1} deg off); what would help: \
         another place of the start or of the robot's base",
        1e3 * starts.residual_m,
        starts.residual_rad.to_degrees()
    )
}

/// A joint whose limit is broken between the knots, as a controller would run them.
pub(super) fn between_knots(
    robot: &Robot,
    path: &TimedPath,
    motion: &RobotMotion,
) -> Option<String> {
    if motion.q.len() != path.time_s.len() {
        return None;
    }
    let names = robot.joint_names().map(str::to_owned).collect();
    let margins = JointTrajectory::through(names, &path.time_s, &motion.q).check(robot);
    let broken = margins.into_iter().find(|m| !m.is_kept())?;
    let percent = |s: Option<f64>| format!("{:.0} %", 100.0 * s.unwrap_or(0.0));
    Some(format!(
        "joint `{}` between the points: {} of its speed, {} of its acceleration",
        broken.joint,
        percent(broken.velocity_share),
        percent(broken.acceleration_share)
    ))
}

/// How near the robot comes to its own limits, a sentence each.
pub(super) fn robot_sentences(motion: &RobotMotion) -> Vec<String> {
    let (v, a, m) = (&motion.qd_share, &motion.qdd_share, &motion.position_margin);
    vec![
        format!(
            "joint speed: at most {:.0} % of its limit ({} at {:.2} s)",
            100.0 * v.value,
            v.joint,
            v.time_s
        ),
        format!(
            "joint acceleration: at most {:.0} % of its limit ({} at {:.2} s)",
            100.0 * a.value,
            a.joint,
            a.time_s
        ),
        format!(
            "joint range: {:.1} deg left ({} at {:.2} s)",
            m.value.to_degrees(),
            m.joint,
            m.time_s
        ),
        format!(
            "smallest singular value {:.3} (rotation scaled by 0.3 m)",
            motion.min_singular_value
        ),
    ]
}

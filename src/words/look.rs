//! The words of `check` for what was found in a cell.

use super::number::percent;
use super::path::face;
use super::robot::{self, no_motion};
use crate::planner::{CellFinding, CellLook};

/// A finding in one sentence.
pub fn sentence(finding: &CellFinding) -> String {
    match finding {
        CellFinding::Outside(o) => {
            format!(
                "the {} is {:.0} mm outside the workspace ({})",
                o.end,
                1e3 * o.by_m,
                face(&o.face)
            )
        }
        CellFinding::TooQuick { duration_s, shortest_s } => format!(
            "{duration_s} s is too short for this movement: with these limits of the TCP the straight path \
             alone takes at least {shortest_s:.2} s"
        ),
        CellFinding::RobotOutOfReach(r) => format!(
            "the robot does not reach the {}: the nearest posture is {:.0} mm and {:.1} deg off",
            r.end,
            1e3 * r.residual_m,
            r.residual_rad.to_degrees()
        ),
        CellFinding::RobotTouches(r) => format!(
            "at the {} {} touch in every posture found",
            r.end,
            r.nearest.as_deref().unwrap_or("robot and obstacle")
        ),
        CellFinding::ObstaclesUnchecked => {
            "distances between robot and obstacles are not checked: the robot's description has no \
             collision shapes"
                .to_owned()
        }
        CellFinding::AssumedShapes(shapes) => {
            format!("the robot's real shape is not checked: {}", robot::assumed_shapes(shapes))
        }
        CellFinding::RobotStopped(why, at) => {
            format!(
                "the robot cannot follow the straight path beyond {}: {}",
                percent(*at),
                no_motion(why)
            )
        }
        CellFinding::RobotTouchesOnTheWay(what) => format!("on the straight path {what} touch"),
        CellFinding::HandOutOfReach(h) => {
            let nearer = if h.gap_m > 1e-3 {
                format!("it would have to be {:.0} mm nearer", 1e3 * h.gap_m)
            } else {
                "the place is within reach, but not with the grip turned like that".to_owned()
            };
            format!("the hand of `{}` does not reach the {}: {nearer}", h.body, h.end)
        }
        CellFinding::HandAtItsEnd(h) => format!(
            "only {} of {} start postures of `{}` reach the {}: it is near the limit of reach in this orientation",
            h.reached, h.tries, h.body, h.end
        ),
        CellFinding::HandLeftBehind(h) => {
            let from = h.lost_from.filter(|at| *at > 0.0).map_or_else(String::new, |at| {
                format!(", the first of the others is lost after {} of the time", percent(at))
            });
            format!(
                "only {} of {} repetitions of `{}` follow the straight path to the goal{from}",
                h.followed, h.tries, h.body
            )
        }
        CellFinding::Unsupported(h) => format!(
            "{} of the straight path is beyond what the posture model of `{}` was trained on: its postures \
             there are guesses",
            percent(h.unsupported),
            h.body
        ),
        CellFinding::UnusualStarts(h) => format!(
            "{} of the start postures of `{}` are rarer than 1 in 100 of the training postures",
            percent(h.unusual_starts),
            h.body
        ),
        CellFinding::Intrusion(i) => format!(
            "obstacle `{}` stands {:.0} mm deep in the {} of `{}`: move worker.at_m or the obstacle",
            i.obstacle,
            1e3 * i.depth_m,
            i.part,
            i.body
        ),
        CellFinding::LowHand(low) => super::finding::low_hand(low),
        CellFinding::HangingFeet(f) => format!(
            "the feet of `{}` hang {:.0} mm above the floor: give a lower worker.seat_height_m, or mind that \
             scores count the feet as supported",
            f.body,
            1e3 * f.above_m
        ),
    }
}

/// What was looked at, a line each.
pub fn lines(look: &CellLook) -> Vec<String> {
    let mut all = Vec::new();
    for h in &look.hands {
        all.push(format!(
            "{}: {} of {} start postures of `{}` reach it",
            h.end, h.reached, h.tries, h.body
        ));
    }
    for r in look.robot.iter().filter(|r| r.postures > 0) {
        let room = match (r.clearance_m, &r.nearest) {
            (Some(clearance), Some(what)) => format!("; {:.0} mm of room: {what}", 1e3 * clearance),
            _ if look.setting.obstacles.is_empty() => "; no obstacle to run into".to_owned(),
            _ => "; distances to obstacles not checked".to_owned(),
        };
        all.push(format!(
            "{}: the robot reaches it in at least {} postures{room}",
            r.end, r.postures
        ));
    }
    if let Some(shortest_s) = look.shortest_s {
        all.push(format!(
            "straight path: takes at least {shortest_s:.2} s under the limits of the TCP; the scenario gives {} s",
            look.duration_s
        ));
    }
    for h in &look.along {
        all.push(format!(
            "straight path: {} of {} repetitions of `{}` follow it to the goal; {} of it is beyond the training \
             data, {} of the start postures are unusual",
            h.followed,
            h.tries,
            h.body,
            percent(h.unsupported),
            percent(h.unusual_starts)
        ));
    }
    if let Some(robot) = look.robot_along.as_ref().filter(|r| r.stopped.is_none()) {
        let room = match (robot.clearance_m, &robot.nearest) {
            (Some(clearance), Some(what)) => format!("; {:.0} mm of room: {what}", 1e3 * clearance),
            _ => String::new(),
        };
        all.push(format!("straight path: the robot follows it{room}"));
    }
    all
}

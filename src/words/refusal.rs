//! Why a path is refused or marked, in words.

use super::number::percent;
use super::path::{check, no_path, or_list};
use super::robot::{between_points, no_motion, violation};
use crate::path::Change;
use crate::planner::{Refusal, RefusedBy, Status};

/// Why a path is refused, as the end of a sentence.
pub fn refusal(why: &Refusal) -> String {
    match why {
        Refusal::Path(why) => no_path(why),
        Refusal::Limit(broken) => check(broken),
        Refusal::Robot(why) => no_motion(why),
        Refusal::Start { residual_m: Some(m), residual_rad: Some(rad) } => format!(
            "the start is out of the robot's reach (nearest {:.0} mm and {:.1} deg off); what would \
             help: a start or a robot base in another place",
            1e3 * m,
            rad.to_degrees()
        ),
        Refusal::Start { .. } => "the start is out of the robot's reach".to_owned(),
        Refusal::BetweenKnots(margin) => between_points(margin),
        Refusal::JointLimit(over) => violation(over),
        Refusal::Obstacle { link, obstacle, depth_m } if *depth_m > 0.0 => {
            format!("link `{link}` and obstacle `{obstacle}` overlap by {:.0} mm", 1e3 * depth_m)
        }
        Refusal::Obstacle { link, obstacle, .. } => {
            format!("link `{link}` and obstacle `{obstacle}` touch")
        }
        Refusal::Worker { body, from_s } => format!(
            "body `{body}` cannot follow: the reach is exceeded from {from_s:.2} s on in every repetition"
        ),
        Refusal::Person { body, link, body_part, share_below, share_allowed, margin_m, p05_m } => {
            format!(
                "the robot comes nearer than {:.0} mm to body `{body}` in {} of the repetitions, {} are \
             allowed (nearest: link `{link}` and the {body_part}; 5th percentile of the distance {:.0} mm)",
                1e3 * margin_m,
                percent(*share_below),
                percent(*share_allowed),
                1e3 * p05_m
            )
        }
    }
}

/// What refuses a path, as a short name.
pub fn refused_by(by: RefusedBy) -> &'static str {
    match by {
        RefusedBy::Path => "limits of the path",
        RefusedBy::Robot => "the robot",
        RefusedBy::Obstacle => "an obstacle",
        RefusedBy::Worker => "the worker's reach",
        RefusedBy::Person => "the distance to the person",
    }
}

/// The same as a key, for tables.
pub fn key(by: RefusedBy) -> &'static str {
    match by {
        RefusedBy::Path => "path",
        RefusedBy::Robot => "robot",
        RefusedBy::Obstacle => "obstacle",
        RefusedBy::Worker => "worker",
        RefusedBy::Person => "person",
    }
}

/// The reason against a path with its key and what would help; empty for a feasible one.
pub fn reason(status: &Status, changes: &[Change]) -> String {
    match status {
        Status::Feasible => String::new(),
        Status::Marked { violations } => all(violations),
        Status::Infeasible { refusal: why } => {
            format!("{}: {}{}", key(why.by()), refusal(why), or_list(changes))
        }
    }
}

/// Several refusals in one line.
pub fn all(refusals: &[Refusal]) -> String {
    refusals.iter().map(refusal).collect::<Vec<_>>().join("; ")
}

/// A path's state.
pub fn state(status: &Status) -> &'static str {
    match status {
        Status::Feasible => "kept",
        Status::Marked { .. } => "over a limit",
        Status::Infeasible { .. } => "not feasible",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::NoPath;

    #[test]
    fn a_refusal_has_its_key_and_what_would_help() {
        let why = Refusal::Path(NoPath::Corridor { at_s: 1.0, by_m: 0.02 });
        let status = Status::Infeasible { refusal: why };
        let changes = [Change::WidenCorridor { from_m: 0.05, to_m: 0.0701 }];
        assert_eq!(
            reason(&status, &changes),
            "path: the corridor is too narrow: at 1.00 s the path is 20 mm outside; what would help: a \
             corridor of 71 mm instead of 50 mm"
        );
        let near = Refusal::Person {
            body: "male_p50".to_owned(),
            link: "hand".to_owned(),
            body_part: "trunk".to_owned(),
            share_below: 0.071,
            share_allowed: 0.05,
            margin_m: 0.05,
            p05_m: 0.043,
        };
        assert_eq!(
            refusal(&near).replace('\u{a0}', " "),
            "the robot comes nearer than 50 mm to body `male_p50` in 7.1 % of the repetitions, 5.0 % are \
             allowed (nearest: link `hand` and the trunk; 5th percentile of the distance 43 mm)"
        );
        let touching =
            |depth_m| Refusal::Obstacle { link: "a".into(), obstacle: "b".into(), depth_m };
        assert_eq!(refusal(&touching(0.0)), "link `a` and obstacle `b` touch");
        assert_eq!(refusal(&touching(0.012)), "link `a` and obstacle `b` overlap by 12 mm");
    }
}

//! What a program for a controller is, and what of it was checked. ASCII only: controllers read it.

use crate::robot::JointMargin;
use crate::words::number::percent;

/// What stands in every program and below every report of one.
pub const NOT_RUN: &str = "NOT RUN ON A CONTROLLER: try it at reduced speed, with nobody near, before anybody holds on to it";

/// Of a program of moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinned {
    /// Moves, and the points of the plan that they stand for.
    pub moves: usize,
    /// Points of the plan.
    pub points: usize,
    /// Largest distance of the TCP from the plan at equal times, m.
    pub deviation_m: f64,
    /// By how much the duration differs, s.
    pub duration_off_s: f64,
}

/// How many moves there are, and how near they stay to the plan.
pub fn thinned(t: &Thinned) -> String {
    let off = if t.duration_off_s.abs() < 5e-5 {
        "the duration is that of the plan".to_owned()
    } else {
        format!("the duration differs by {:.1} ms", 1e3 * t.duration_off_s)
    };
    format!(
        "{} moves for the {} points of the plan: at most {:.2} mm from the planned path at equal times where the \
         joints move evenly between two points; {off}",
        t.moves,
        t.points,
        1e3 * t.deviation_m
    )
}

/// How many rows there are, and how near they stay to the plan.
pub fn stream(rows: usize, period_s: f64, deviation_m: f64) -> String {
    format!(
        "{rows} rows, one for every {:.0} ms: at most {:.3} mm from the planned path",
        1e3 * period_s,
        1e3 * deviation_m
    )
}

/// The limits of the joints in what is written. Only what was looked at is called kept.
pub fn limits(margins: &[JointMargin]) -> Vec<String> {
    let nearest = |pick: fn(&JointMargin) -> Option<f64>| {
        margins.iter().filter_map(move |m| pick(m).map(|v| (v, m.joint.as_str())))
    };
    let mut lines = Vec::new();
    let position = nearest(|m| m.position_margin).min_by(|a, b| a.0.total_cmp(&b.0));
    lines.push(match position {
        Some((margin, joint)) => {
            format!(
                "limits of joint positions: kept; nearest `{joint}`, {:.1} deg from its limit",
                margin.to_degrees()
            )
        }
        None => "limits of joint positions: not checked, none are known".to_owned(),
    });
    let shares = [
        ("speeds", nearest(|m| m.velocity_share).max_by(|a, b| a.0.total_cmp(&b.0))),
        ("accelerations", nearest(|m| m.acceleration_share).max_by(|a, b| a.0.total_cmp(&b.0))),
    ];
    for (what, found) in shares {
        lines.push(match found {
            Some((share, joint)) => {
                format!("limits of joint {what}: kept; highest `{joint}`, {} of its limit", percent(share))
            }
            None => format!("limits of joint {what}: not checked; how the joints get up to speed is up to the controller"),
        });
    }
    lines
}

/// A joint that breaks a limit.
pub fn broken(m: &JointMargin) -> String {
    let share = |s: Option<f64>, what| {
        s.filter(|s| *s > 1.0).map(|s| format!("{} of its limit of {what}", percent(s)))
    };
    let beyond = m
        .position_margin
        .filter(|v| *v < 0.0)
        .map(|v| format!("{:.2} deg beyond its limit of position", -v.to_degrees()));
    let all: Vec<String> =
        [beyond, share(m.velocity_share, "speed"), share(m.acceleration_share, "acceleration")]
            .into_iter()
            .flatten()
            .collect();
    format!("joint `{}` reaches {}", m.joint, all.join(" and "))
}

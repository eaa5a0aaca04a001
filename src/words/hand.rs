//! Where a hand is and how it is turned, as the worker sees it.

use crate::human::{Side, palm};
use crate::math::{Pose, Vec3};
use crate::scenario::Scenario;
use nalgebra::UnitQuaternion;

/// Least share of a direction that is told: the sine of half of 45 deg.
const TOLD: f64 = 0.3827;

/// The hands at the start, and how the tool is turned there, a line each.
pub fn at_the_start(scenario: &Scenario) -> Vec<String> {
    let place = ["ahead", "behind", "left", "right", "above", "below"];
    let way = ["ahead", "back", "left", "right", "up", "down"];
    let facing = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), scenario.worker.facing);
    let as_seen = |v: Vec3, words| direction(&(facing.inverse() * v), words);
    let hand = |(side, grip): (Side, Pose)| {
        let (at, turn) = (grip.translation.vector, grip.rotation);
        format!(
            "{} hand at the start: at ({:.3}, {:.3}, {:.3}) m; seen by the worker the palm faces {}, the thumb \
             is {}, the wrist {}",
            side.name(),
            at.x,
            at.y,
            at.z,
            as_seen(palm(side, &turn), way),
            as_seen(turn * Vec3::z(), place),
            as_seen(turn * Vec3::y(), place)
        )
    };
    let mut all: Vec<String> = scenario.hands_at(&scenario.start).into_iter().map(hand).collect();
    let tool = as_seen(scenario.start.rotation * Vec3::z(), way);
    all.push(format!("tool at the start: points {tool}"));
    all
}

/// A direction in the worker's frame (x ahead, y left, z up) in words for either way along each axis, the
/// largest part first.
fn direction(v: &Vec3, [ahead, back, left, right, up, down]: [&str; 6]) -> String {
    let mut parts = [(v.x, [ahead, back]), (v.y, [left, right]), (v.z, [up, down])];
    // Of equal parts the first stays first.
    let size = |share: f64| (1e6 * share.abs()).round();
    parts.sort_by(|a, b| size(b.0).total_cmp(&size(a.0)));
    let words = parts.iter().filter(|(share, _)| share.abs() > TOLD);
    let words: Vec<&str> =
        words.map(|(share, [more, less])| if *share > 0.0 { *more } else { less }).collect();
    words.join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_told_by_their_largest_parts() {
        let words = ["ahead", "back", "left", "right", "up", "down"];
        let said = |x, y, z| direction(&Vec3::new(x, y, z).normalize(), words);
        assert_eq!(said(0.0, 0.0, -1.0), "down");
        assert_eq!(said(1.0, 0.1, 0.2), "ahead");
        assert_eq!(said(-1.0, 0.0, 0.6), "back and up");
        assert_eq!(said(0.6, -1.0, 0.7), "right and up and ahead");
    }
}

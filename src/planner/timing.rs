//! Where a path lingers, in words: with a free pace the time law is part of the plan.

use super::result::PathData;
use crate::math::Vec3;

/// Share of the highest speed below which the TCP counts as slow.
const SLOW: f64 = 0.25;
/// Least shares of the duration of a slow part that is told: between others, and from the start or to
/// the goal, where the minimum-jerk law is slow for 0.15 of it.
const LEAST_SHARE: f64 = 0.1;
const LEAST_SHARE_AT_END: f64 = 0.22;

/// The longest slow part in a sentence; none where there is none to speak of.
pub(super) fn lingering(path: &PathData) -> Option<String> {
    let at = |k: usize| Vec3::new(path.tcp[k][0], path.tcp[k][1], path.tcp[k][2]);
    let steps = path.tcp.len().min(path.time_s.len()).checked_sub(1)?;
    let speed: Vec<f64> = (0..steps)
        .map(|k| (at(k + 1) - at(k)).norm() / (path.time_s[k + 1] - path.time_s[k]))
        .collect();
    let highest = speed.iter().copied().fold(0.0, f64::max);
    let duration = path.time_s[steps] - path.time_s[0];
    let mut longest: Option<(usize, usize)> = None;
    let mut from = 0;
    for part in speed.chunk_by(|a, b| (*a < SLOW * highest) == (*b < SLOW * highest)) {
        let to = from + part.len();
        let share = (path.time_s[to] - path.time_s[from]) / duration;
        let is_end = from == 0 || to == steps;
        let least = if is_end { LEAST_SHARE_AT_END } else { LEAST_SHARE };
        let is_longer = longest.is_none_or(|(a, b)| to - from > b - a);
        if part[0] < SLOW * highest && share >= least && is_longer {
            longest = Some((from, to));
        }
        from = to;
    }
    let (from, to) = longest?;
    let middle = at(usize::midpoint(from, to));
    Some(format!(
        "Its timing is part of the plan: slow (below {:.2} m/s) from {:.1} to {:.1} s near ({:.2}, {:.2}, \
         {:.2}) m, and up to {highest:.2} m/s elsewhere.",
        SLOW * highest,
        path.time_s[from],
        path.time_s[to],
        middle.x,
        middle.y,
        middle.z,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{NotChecked, ObstacleClearance, SelfClearance};

    fn along(x: impl Fn(f64) -> f64) -> PathData {
        let time_s: Vec<f64> = (0..=100).map(|k| f64::from(k) / 25.0).collect();
        let tcp = time_s.iter().map(|t| [x(*t), 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]).collect();
        PathData {
            time_s,
            tcp,
            robot_joints: Vec::new(),
            robot_q: Vec::new(),
            checks: Vec::new(),
            robot_margins: None,
            joint_margins: Vec::new(),
            joint_trajectory: None,
            clearance: ObstacleClearance::NoObstacle,
            self_clearance: SelfClearance::NotChecked { why: NotChecked::NoMotion },
            moved_m: 0.0,
        }
    }

    #[test]
    fn the_usual_law_does_not_linger_and_a_rest_does() {
        let ease = |u: f64| u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        assert_eq!(lingering(&along(|t| ease(t / 4.0))), None);
        let rests = |t: f64| {
            if t < 2.0 { 0.5 * ease(t.min(1.0)) } else { 0.5 + 0.5 * ease((t - 2.0) / 2.0) }
        };
        let words = lingering(&along(rests)).unwrap();
        assert!(words.contains("near (0.50, 0.00, 1.00) m"), "{words}");
        assert!(words.contains("from 0.8") || words.contains("from 0.9"), "{words}");
    }
}

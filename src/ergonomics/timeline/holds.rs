//! Stretches of time during which all angles of a body part stay where they are.

use super::line::Line;
use super::{Hold, TimeRules};
use std::ops::Range;

/// All holds, in order.
pub(super) fn holds(
    time: &[f64],
    lines: &[Line],
    runs: &[Range<usize>],
    rules: &TimeRules,
) -> Vec<Hold> {
    let norm = |part: &dyn Fn(&Line) -> f64| -> f64 {
        lines.iter().map(|l| part(l).powi(2)).sum::<f64>().sqrt()
    };
    let mut found = Vec::new();
    for run in runs {
        let mut i = run.start;
        while i < run.end {
            if norm(&|l| l.speed[i]) >= rules.still_deg_s {
                i += 1;
                continue;
            }
            let mut end = i;
            while end + 1 < run.end
                && norm(&|l| l.speed[end + 1]) < rules.moving_deg_s
                && norm(&|l| l.angle[end + 1] - l.angle[i]) <= rules.travel_deg
            {
                end += 1;
            }
            if end > i {
                found.push(Hold { from_s: time[i], to_s: time[end] });
            }
            i = end + 1;
        }
    }
    found
}

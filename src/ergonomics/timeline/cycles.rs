//! Movements away and back, and large changes in short time.

use super::TimeRules;
use std::ops::Range;

/// Full movements: pairs of ways, there and back, between turning points that lie at least the
/// least movement apart. Half a movement at an end of a run does not count.
pub(super) fn movements(angle: &[f64], runs: &[Range<usize>], rules: &TimeRules) -> usize {
    runs.iter().map(|run| ways(&angle[run.clone()], rules.movement_deg) / 2).sum()
}

/// Ways from one turning point to the next, the first from the start.
fn ways(angle: &[f64], least: f64) -> usize {
    let Some(&first) = angle.first() else { return 0 };
    let (mut low, mut high) = (first, first);
    // Which way it goes; unknown until the first way is long enough.
    let mut rising = None;
    let mut count = 0;
    for &a in angle {
        low = low.min(a);
        high = high.max(a);
        match rising {
            None | Some(false) if a - low >= least => {
                rising = Some(true);
                high = a;
                count += 1;
            }
            None | Some(true) if high - a >= least => {
                rising = Some(false);
                low = a;
                count += 1;
            }
            _ => {}
        }
    }
    count
}

/// Times at which the angle changes by a large angle within a short time; each counts once.
pub(super) fn rapid_changes(
    time: &[f64],
    angle: &[f64],
    runs: &[Range<usize>],
    rules: &TimeRules,
) -> usize {
    let mut count = 0;
    for run in runs {
        let mut from = run.start;
        let mut i = run.start;
        while i < run.end {
            while time[i] - time[from] > rules.rapid_s {
                from += 1;
            }
            if angle[from..i].iter().any(|a| (a - angle[i]).abs() >= rules.large_deg) {
                count += 1;
                from = i;
            }
            i += 1;
        }
    }
    count
}

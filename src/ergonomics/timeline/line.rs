//! Angle and speed of a series at every frame, by a straight line fitted over a short window.

use super::TimeRules;
use std::ops::Range;

/// A series and its speed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    /// deg.
    pub angle: Vec<f64>,
    /// deg/s.
    pub speed: Vec<f64>,
}

/// Least-squares line over the frames of the same run within half a window on either side, and at
/// least over the next frames.
pub(super) fn fit(time: &[f64], series: &[f64], runs: &[Range<usize>], rules: &TimeRules) -> Line {
    let mut line = Line { angle: series.to_vec(), speed: vec![0.0; series.len()] };
    // Room for rounding, so that a window of 0.5 s is symmetric at round frame rates.
    let half = 0.5 * rules.window_s + 1e-9;
    for run in runs {
        let (mut low, mut high) = (run.start, run.start);
        for i in run.clone() {
            while time[low] < time[i] - half {
                low += 1;
            }
            while high < run.end && time[high] <= time[i] + half {
                high += 1;
            }
            let from = low.min(i.saturating_sub(1)).max(run.start);
            let to = high.max(i + 2).min(run.end);
            let (angle, speed) = at(&time[from..to], &series[from..to], time[i]);
            line.angle[i] = angle;
            line.speed[i] = speed;
        }
    }
    line
}

/// Value and slope of the line at a time.
fn at(time: &[f64], values: &[f64], when: f64) -> (f64, f64) {
    let n = time.len() as f64;
    let mean_t = time.iter().sum::<f64>() / n;
    let mean_v = values.iter().sum::<f64>() / n;
    let spread: f64 = time.iter().map(|t| (t - mean_t).powi(2)).sum();
    if spread <= 0.0 {
        return (mean_v, 0.0);
    }
    let slope =
        time.iter().zip(values).map(|(t, v)| (t - mean_t) * (v - mean_v)).sum::<f64>() / spread;
    (mean_v + slope * (when - mean_t), slope)
}

//! What a motion itself shows about time: static holds, repeated movements, rapid large changes.
//!
//! RULA and REBA ask for postures held longer than 1 min, actions repeated more than 4 times a
//! minute and rapid large changes, but not how to see them in angles over time. The rules here:
//!
//! ```text
//! hold     begins where the speed is below 5 deg/s, ends at 10 deg/s or 7.5 deg away from its begin
//! movement away and back by 10 deg or more (turning points with hysteresis)
//! rapid    a change of 45 deg or more within 1 s
//! ```
//! The rule of a hold is that of Maurer-Grubinger et al. (Sensors 21:4077, 2021), there for the
//! shoulder, here for every body part; its angles are taken together (Euclidean norm). The other two
//! are choices of this project. Angles and speeds are those of a line fitted over 0.5 s, so that the
//! noise of a sensor does not break a hold. Nothing is known inside a gap: a hold ends there, and its
//! time does not count. Times in s, strictly increasing, not necessarily uniform; angles in deg.
//!
//! A claim needs a motion that is long enough: one of 4 s cannot show a hold of a minute, so that the
//! answer then is [`Shown::TooShort`], neither yes nor no.

mod cycles;
mod holds;
mod line;
#[cfg(test)]
mod tests;

use crate::math::stats::quantile;
use serde::Serialize;
use std::ops::Range;

/// The numbers of the rules.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TimeRules {
    /// Speed below which a hold begins, deg/s.
    pub still_deg_s: f64,
    /// Speed at which it ends, deg/s.
    pub moving_deg_s: f64,
    /// Distance from its begin at which it ends, deg.
    pub travel_deg: f64,
    /// Shortest hold that is listed, s. 10 in Maurer-Grubinger et al. (2021).
    pub shortest_hold_s: f64,
    /// A hold longer than this is static (RULA, REBA), s.
    pub static_s: f64,
    /// Least angle away and back that counts as a movement, deg. More than the travel of a hold.
    pub movement_deg: f64,
    /// More movements a minute than this are repeated (RULA, REBA).
    pub repeated_per_min: f64,
    /// A change that is large, deg.
    pub large_deg: f64,
    /// Time within which a large change is rapid, s.
    pub rapid_s: f64,
    /// Window of the fitted line, s.
    pub window_s: f64,
    /// A step longer than this, and longer than five usual steps, is a gap, s.
    pub gap_s: f64,
}

impl Default for TimeRules {
    fn default() -> Self {
        Self {
            still_deg_s: 5.0,
            moving_deg_s: 10.0,
            travel_deg: 7.5,
            shortest_hold_s: 10.0,
            static_s: 60.0,
            movement_deg: 10.0,
            repeated_per_min: 4.0,
            large_deg: 45.0,
            rapid_s: 1.0,
            window_s: 0.5,
            gap_s: 0.5,
        }
    }
}

/// What a motion shows on a question that needs time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shown {
    /// The motion shows it.
    Yes,
    /// The motion is long enough to show it and does not.
    No,
    /// The motion is too short to tell.
    TooShort,
}

/// A posture held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hold {
    /// Begin, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
}

impl Hold {
    /// Duration, s.
    pub fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// One body part over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartTimeline {
    /// Holds of at least [`TimeRules::shortest_hold_s`], in order.
    pub holds: Vec<Hold>,
    /// The longest hold of any length, if there is one.
    pub longest_hold: Option<Hold>,
    /// Full movements, away and back, of the angle that has most of them.
    pub movements: usize,
    /// Movements per minute of observed time; over less than a minute this extrapolates.
    pub movements_per_min: f64,
    /// Rapid large changes of any one angle.
    pub rapid_changes: usize,
    /// Whether a hold is longer than a minute.
    pub held: Shown,
    /// Whether movements repeat more than four times a minute.
    pub repeated: Shown,
}

/// The times of a motion, cut at gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    time_s: Vec<f64>,
    /// Frames between gaps.
    runs: Vec<Range<usize>>,
    /// Time that each frame stands for, s.
    pub weights_s: Vec<f64>,
    /// Sum of the weights, s.
    pub observed_s: f64,
    rules: TimeRules,
}

impl Clock {
    /// From strictly increasing times (s). A frame stands for half the steps to its neighbours; at an
    /// end the one step counts for both halves, so that uniform frames weigh alike. A single frame
    /// weighs 1.
    pub fn new(time_s: &[f64], rules: TimeRules) -> Self {
        let steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
        let usual = if steps.is_empty() { 0.0 } else { quantile(&steps, 0.5) };
        let gap = rules.gap_s.max(5.0 * usual) + 1e-9;
        let mut runs = Vec::new();
        let mut from = 0;
        for (i, step) in steps.iter().enumerate() {
            if *step > gap {
                runs.push(from..i + 1);
                from = i + 1;
            }
        }
        if !time_s.is_empty() {
            runs.push(from..time_s.len());
        }
        let mut weights_s = vec![0.0; time_s.len()];
        for run in &runs {
            for i in run.clone() {
                let before = (i > run.start).then(|| time_s[i] - time_s[i - 1]);
                let after = (i + 1 < run.end).then(|| time_s[i + 1] - time_s[i]);
                weights_s[i] = match (before, after) {
                    (Some(b), Some(a)) => 0.5 * (a + b),
                    (Some(one), None) | (None, Some(one)) => one,
                    // A lone frame between gaps stands for one usual step.
                    (None, None) if usual > 0.0 => usual.min(gap),
                    (None, None) => 1.0,
                };
            }
        }
        let observed_s = weights_s.iter().sum();
        Self { time_s: time_s.to_vec(), runs, weights_s, observed_s, rules }
    }

    /// Number of gaps.
    pub fn gaps(&self) -> usize {
        self.runs.len().saturating_sub(1)
    }

    /// Longest stretch without a gap, s.
    pub fn longest_run_s(&self) -> f64 {
        self.runs.iter().map(|r| self.span(r)).fold(0.0, f64::max)
    }

    fn span(&self, run: &Range<usize>) -> f64 {
        self.time_s[run.end - 1] - self.time_s[run.start]
    }

    /// Holds and movements of a body part by its angles (deg), each as long as the times.
    pub fn part(&self, angles: &[&[f64]]) -> PartTimeline {
        let lines: Vec<line::Line> =
            angles.iter().map(|a| line::fit(&self.time_s, a, &self.runs, &self.rules)).collect();
        let all = holds::holds(&self.time_s, &lines, &self.runs, &self.rules);
        let longest = all.iter().copied().max_by(|a, b| a.duration_s().total_cmp(&b.duration_s()));
        let count = |l: &line::Line| cycles::movements(&l.angle, &self.runs, &self.rules);
        let movements = lines.iter().map(count).max().unwrap_or(0);
        let rapid =
            |l: &line::Line| cycles::rapid_changes(&self.time_s, &l.angle, &self.runs, &self.rules);
        let minutes = self.observed_s / 60.0;
        PartTimeline {
            longest_hold: longest,
            movements,
            movements_per_min: movements as f64 / minutes.max(f64::MIN_POSITIVE),
            rapid_changes: lines.iter().map(rapid).max().unwrap_or(0),
            held: self.held(longest.map_or(0.0, |h| h.duration_s())),
            repeated: self.repeated(movements, minutes),
            holds: all
                .into_iter()
                .filter(|h| h.duration_s() >= self.rules.shortest_hold_s)
                .collect(),
        }
    }

    fn held(&self, longest_s: f64) -> Shown {
        if longest_s > self.rules.static_s {
            Shown::Yes
        } else if self.longest_run_s() > self.rules.static_s {
            Shown::No
        } else {
            Shown::TooShort
        }
    }

    /// Five movements within less than a minute already are more than four a minute.
    fn repeated(&self, movements: usize, minutes: f64) -> Shown {
        if movements as f64 > self.rules.repeated_per_min * minutes.max(1.0) {
            Shown::Yes
        } else if minutes >= 1.0 {
            Shown::No
        } else {
            Shown::TooShort
        }
    }
}

//! Timed pose paths and the minimum-jerk time law `s(tau) = 10 tau^3 - 15 tau^4 + 6 tau^5`.
//!
//! A [`TimedPath`] is a list of poses (of one frame, in the world) at strictly increasing times (s).
//! Between samples the position is linear in time and the orientation follows the shortest rotation
//! at constant angular velocity. `tau = t / D` in [0, 1] for a move of duration `D` (s).

use crate::math::Pose;
use crate::math::Vec6;
use crate::math::pose::{interpolate, pose_error};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Largest `ds/dtau` of the minimum-jerk law, reached at `tau = 1/2`.
pub const MINIMUM_JERK_PEAK_SPEED: f64 = 1.875;
/// Largest `|d2s/dtau2|` of the minimum-jerk law, `10 / sqrt(3)`.
pub const MINIMUM_JERK_PEAK_ACCELERATION: f64 = 5.773_502_691_896_258;

/// Why a list of samples is no path.
#[derive(Debug, Clone, PartialEq, Error, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrajectoryError {
    /// Fewer than two samples, or unequal numbers of times and poses.
    #[error("a path needs at least two samples, each with a time and a pose ({times} and {poses})")]
    Length {
        /// Number of times given.
        times: usize,
        /// Number of poses given.
        poses: usize,
    },
    /// The time does not grow from one sample to the next, or is no finite number.
    #[error("the time of sample {0} is not finite or not later than that of the sample before")]
    Time(usize),
    /// A pose holds a number that is not finite.
    #[error("the pose of sample {0} holds a number that is not finite")]
    Pose(usize),
    /// A duration, step or count that is not positive and finite.
    #[error("the duration and the time step of a path must be positive and finite")]
    Step,
}

/// Poses over time; times strictly increasing (s), uniform or not, at least two samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TimedPath {
    /// Times of the samples, s.
    pub time_s: Vec<f64>,
    /// Poses in the world, one for each time.
    pub poses: Vec<Pose>,
}

impl TimedPath {
    /// Checks the samples and keeps them.
    pub fn new(time_s: Vec<f64>, poses: Vec<Pose>) -> Result<Self, TrajectoryError> {
        let path = Self { time_s, poses };
        match path.fault() {
            Some(fault) => Err(fault),
            None => Ok(path),
        }
    }

    /// The first thing that is wrong with the samples; the constructors leave nothing.
    pub fn fault(&self) -> Option<TrajectoryError> {
        let (times, poses) = (self.time_s.len(), self.poses.len());
        if times < 2 || times != poses {
            return Some(TrajectoryError::Length { times, poses });
        }
        let is_bad = |i: usize| {
            !self.time_s[i].is_finite() || (i > 0 && self.time_s[i] <= self.time_s[i - 1])
        };
        if let Some(i) = (0..times).find(|i| is_bad(*i)) {
            return Some(TrajectoryError::Time(i));
        }
        self.poses.iter().position(|p| !is_finite(p)).map(TrajectoryError::Pose)
    }

    /// Samples `pose(t)` at `steps + 1` equidistant times from 0 to `duration_s`.
    pub fn sample(
        duration_s: f64,
        steps: usize,
        pose: impl Fn(f64) -> Pose,
    ) -> Result<Self, TrajectoryError> {
        if !(duration_s > 0.0 && duration_s.is_finite()) || steps == 0 {
            return Err(TrajectoryError::Step);
        }
        let time_s: Vec<f64> = (0..=steps).map(|i| duration_s * i as f64 / steps as f64).collect();
        let poses = time_s.iter().map(|t| pose(*t)).collect();
        Self::new(time_s, poses)
    }

    /// Time of the first sample, s.
    pub fn start_s(&self) -> f64 {
        self.time_s.first().copied().unwrap_or_default()
    }

    /// Time from the first sample to the last, s.
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().copied().unwrap_or_default() - self.start_s()
    }

    /// Pose at time `t` (s, on the clock of `time_s`); held beyond both ends.
    pub fn pose_at(&self, t: f64) -> Pose {
        let last = self.time_s.len() - 1;
        let after = self.time_s.partition_point(|time| *time <= t).clamp(1, last);
        let (t0, t1) = (self.time_s[after - 1], self.time_s[after]);
        let s = ((t - t0) / (t1 - t0)).clamp(0.0, 1.0);
        interpolate(&self.poses[after - 1], &self.poses[after], s)
    }

    /// The path at equidistant times: the number of steps nearest to `duration / dt`, so that both
    /// ends are kept and the step differs from `dt` (s) by less than the rounding to whole steps.
    pub fn resample(&self, dt: f64) -> Result<Self, TrajectoryError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(TrajectoryError::Step);
        }
        let (start, duration) = (self.start_s(), self.duration_s());
        let steps = (duration / dt).round().max(1.0) as usize;
        let at = |i: usize| start + duration * i as f64 / steps as f64;
        let time_s: Vec<f64> = (0..=steps).map(at).collect();
        let poses = time_s.iter().map(|t| self.pose_at(*t)).collect();
        Self::new(time_s, poses)
    }

    /// Distance covered from the first sample to each, m; as many values as samples.
    pub fn arc_length_m(&self) -> Vec<f64> {
        let mut covered = 0.0;
        let steps = self.poses.windows(2).map(|p| {
            covered += (p[1].translation.vector - p[0].translation.vector).norm();
            covered
        });
        std::iter::once(0.0).chain(steps).collect()
    }

    /// Distance covered by the position, m.
    pub fn length_m(&self) -> f64 {
        self.arc_length_m().last().copied().unwrap_or_default()
    }

    /// Twists at the samples in world axes, linear (m/s) then angular (rad/s).
    ///
    /// Inside: the derivative at the middle sample of the parabola through three neighbours, exact
    /// for constant acceleration on any grid. At the ends: the difference to the neighbour.
    pub fn velocities(&self) -> Vec<Vec6> {
        let between: Vec<Vec6> = (1..self.poses.len())
            .map(|i| {
                let dt = self.time_s[i] - self.time_s[i - 1];
                pose_error(&self.poses[i - 1], &self.poses[i]) / dt
            })
            .collect();
        (0..self.poses.len())
            .map(|i| match (i.checked_sub(1).and_then(|b| between.get(b)), between.get(i)) {
                (Some(before), Some(after)) => {
                    let h0 = self.time_s[i] - self.time_s[i - 1];
                    let h1 = self.time_s[i + 1] - self.time_s[i];
                    (before * h1 + after * h0) / (h0 + h1)
                }
                (Some(only), None) | (None, Some(only)) => *only,
                (None, None) => Vec6::zeros(),
            })
            .collect()
    }
}

/// Whether every number of a pose is finite.
pub fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
}

/// The minimum-jerk law and its first three derivatives with respect to `tau`, which is clamped to
/// [0, 1]: `[s, s', s'', s''']`.
pub fn minimum_jerk(tau: f64) -> [f64; 4] {
    let t = tau.clamp(0.0, 1.0);
    [
        t * t * t * (10.0 + t * (-15.0 + 6.0 * t)),
        30.0 * t * t * (1.0 - t) * (1.0 - t),
        60.0 * t * (1.0 + t * (-3.0 + 2.0 * t)),
        60.0 * (1.0 + t * (-6.0 + 6.0 * t)),
    ]
}

/// A rest on the way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pause {
    /// The share of the way, in (0, 1), at which it rests.
    pub phase: f64,
    /// How long, s.
    pub dwell_s: f64,
}

/// The share of the way at time `t` (s) of a move of `duration_s` in all, and its first derivative
/// over time (1/s): minimum jerk, or from rest to rest on both sides of a pause, with the time in
/// proportion to the way, so that the peak speed is that of the unbroken move.
pub fn phase(t: f64, duration_s: f64, pause: Option<Pause>) -> [f64; 2] {
    let whole = |t: f64, duration: f64| {
        let [s, rate, ..] = minimum_jerk(t / duration);
        [s, rate / duration]
    };
    let Some(Pause { phase, dwell_s }) = pause else { return whole(t, duration_s) };
    let moving = duration_s - dwell_s;
    let before = phase * moving;
    if t <= before {
        whole(t, before).map(|x| phase * x)
    } else if t <= before + dwell_s {
        [phase, 0.0]
    } else {
        let [s, rate] = whole(t - before - dwell_s, moving - before);
        [phase + (1.0 - phase) * s, (1.0 - phase) * rate]
    }
}

/// The straight rest-to-rest move under the minimum-jerk law, position and orientation together;
/// `steps + 1` samples from time 0 to `duration_s`.
pub fn minimum_jerk_line(
    start: &Pose,
    goal: &Pose,
    duration_s: f64,
    steps: usize,
) -> Result<TimedPath, TrajectoryError> {
    TimedPath::sample(duration_s, steps, |t| {
        interpolate(start, goal, minimum_jerk(t / duration_s)[0])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use approx::assert_relative_eq;

    fn poses() -> (Pose, Pose) {
        let a = Pose::new(Vec3::new(0.4, 0.1, 1.0), Vec3::new(0.2, 0.0, 0.1));
        let b = Pose::new(Vec3::new(0.4, 0.5, 1.3), Vec3::new(0.2, 0.9, 0.1));
        (a, b)
    }

    #[test]
    fn law_starts_and_ends_at_rest_and_its_derivatives_are_consistent() {
        assert_eq!(minimum_jerk(0.0)[..3], [0.0; 3]);
        assert_relative_eq!(minimum_jerk(1.0)[0], 1.0);
        assert_eq!(minimum_jerk(1.0)[1..3], [0.0; 2]);
        assert_eq!(minimum_jerk(-3.0)[..3], [0.0; 3]);
        let h = 1e-5;
        for tau in [0.1, 0.37, 0.5, 0.81] {
            let (low, mid, high) =
                (minimum_jerk(tau - h), minimum_jerk(tau), minimum_jerk(tau + h));
            for k in 0..3 {
                let slope = (high[k] - low[k]) / (2.0 * h);
                assert_relative_eq!(slope, mid[k + 1], epsilon = 1e-7, max_relative = 1e-7);
            }
        }
        let fine = |k: usize| (0..=20_000).map(move |i| minimum_jerk(f64::from(i) / 2e4)[k].abs());
        assert_relative_eq!(fine(1).fold(0.0, f64::max), MINIMUM_JERK_PEAK_SPEED, epsilon = 1e-8);
        let peak = fine(2).fold(0.0, f64::max);
        assert_relative_eq!(peak, MINIMUM_JERK_PEAK_ACCELERATION, epsilon = 1e-6);
    }

    #[test]
    fn a_pause_rests_and_leaves_the_peak_speed() {
        let pause = Some(Pause { phase: 0.3, dwell_s: 2.0 });
        let grid = || (0..=6000).map(|i| f64::from(i) * 1e-3);
        let speeds = grid().map(|t| phase(t, 6.0, pause)[1]).fold(0.0, f64::max);
        assert_relative_eq!(speeds, MINIMUM_JERK_PEAK_SPEED / 4.0, epsilon = 1e-6);
        assert_eq!(phase(6.0, 6.0, pause)[0], 1.0);
        assert_eq!(phase(2.2, 6.0, pause), [0.3, 0.0]);
        let slope =
            |t: f64| (phase(t + 1e-5, 6.0, pause)[0] - phase(t - 1e-5, 6.0, pause)[0]) / 2e-5;
        for t in [0.4, 1.1, 3.3, 4.0, 5.9] {
            assert_relative_eq!(slope(t), phase(t, 6.0, pause)[1], epsilon = 1e-7);
        }
    }

    #[test]
    fn line_keeps_its_ends_length_and_peak_speed() {
        let (a, b) = poses();
        let path = minimum_jerk_line(&a, &b, 4.0, 400).unwrap();
        assert_relative_eq!(path.poses[0], a, epsilon = 1e-12);
        assert_relative_eq!(path.poses[400], b, epsilon = 1e-12);
        assert_relative_eq!(path.length_m(), 0.5, epsilon = 1e-12);
        assert_relative_eq!(path.duration_s(), 4.0);
        let speeds = path.velocities();
        let peak = speeds.iter().map(|v| v.fixed_rows::<3>(0).norm()).fold(0.0, f64::max);
        assert_relative_eq!(peak, 1.875 * 0.5 / 4.0, max_relative = 1e-3);
        let turn = a.rotation.angle_to(&b.rotation);
        let peak = speeds.iter().map(|v| v.fixed_rows::<3>(3).norm()).fold(0.0, f64::max);
        assert_relative_eq!(peak, 1.875 * turn / 4.0, max_relative = 1e-3);
    }

    #[test]
    fn interpolation_and_resampling_agree_on_any_grid() {
        let (a, b) = poses();
        let time = vec![1.0, 1.1, 1.7, 3.0];
        let at = |t: f64| interpolate(&a, &b, (t - 1.0) / 2.0);
        let path = TimedPath::new(time.clone(), time.iter().map(|t| at(*t)).collect()).unwrap();
        for t in [1.05, 1.69, 2.5, 3.0] {
            assert_relative_eq!(path.pose_at(t), at(t), epsilon = 1e-12);
        }
        assert_relative_eq!(path.pose_at(0.0), a, epsilon = 1e-12);
        assert_relative_eq!(path.pose_at(9.0), b, epsilon = 1e-12);
        let even = path.resample(0.3).unwrap();
        assert_eq!(even.time_s.len(), 8);
        assert_relative_eq!(even.poses[7], b, epsilon = 1e-12);
        assert_relative_eq!(even.velocities()[3], even.velocities()[0], epsilon = 1e-10);
    }

    #[test]
    fn what_is_no_path_is_refused() {
        let (a, b) = poses();
        let refuse = |time: &[f64], poses: &[Pose]| {
            TimedPath::new(time.to_vec(), poses.to_vec()).unwrap_err()
        };
        assert!(matches!(refuse(&[0.0], &[a]), TrajectoryError::Length { .. }));
        assert!(matches!(refuse(&[0.0, 1.0], &[a]), TrajectoryError::Length { .. }));
        assert_eq!(refuse(&[0.0, 0.0], &[a, b]), TrajectoryError::Time(1));
        assert_eq!(refuse(&[0.0, f64::NAN], &[a, b]), TrajectoryError::Time(1));
        let broken = Pose::translation(f64::NAN, 0.0, 0.0);
        assert_eq!(refuse(&[0.0, 1.0], &[a, broken]), TrajectoryError::Pose(1));
        assert!(minimum_jerk_line(&a, &b, 0.0, 10).is_err());
        assert!(minimum_jerk_line(&a, &b, f64::NAN, 10).is_err());
        assert!(minimum_jerk_line(&a, &broken, 1.0, 10).is_err());
        assert!(TimedPath::new(vec![0.0, 1.0], vec![a, b]).unwrap().resample(-1.0).is_err());
    }
}

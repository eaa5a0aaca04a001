//! How a path is gone along: where it rests on its way, and how the tool turns besides.
//!
//! ```text
//! R(t) = exp(turn s) R_start exp(w(s)),   s = phase(t),   w(0) = w(1) = 0,  w'(0) = w'(1) = 0
//! ```
//! `turn` is the shortest turn from start to goal; `w` is the sway, a spline of rotation vectors (rad)
//! in the axes of the TCP.

use super::limits::PathLimits;
use super::smooth::SmoothPath;
use super::spline::ClampedSpline;
use crate::math::Vec3;
use crate::math::pose::rotation_between;
use crate::trajectory::Pause;
use serde::Serialize;

/// Parts of the phase at which the size of a sway is measured.
const PARTS: usize = 200;
/// Halvings in the search for the largest sway within the limits.
const HALVINGS: usize = 10;

/// Where a path rests, and its sway. Neither by default.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Turning {
    /// The rest on the way.
    pub pause: Option<Pause>,
    /// The turn besides that from start to goal.
    #[serde(skip)]
    pub sway: Option<ClampedSpline>,
}

/// The sway through rotation vectors (rad) at equal parts of the phase, made smaller as a whole where
/// it would turn by more than `most` (rad); none without vectors.
pub fn sway(turns: &[Vec3], most: f64) -> Option<ClampedSpline> {
    if turns.is_empty() {
        return None;
    }
    let count = turns.len() + 1;
    let knots: Vec<f64> = (0..=count).map(|k| k as f64 / count as f64).collect();
    let ends = || std::iter::once(Vec3::zeros());
    let points: Vec<Vec3> = ends().chain(turns.iter().copied()).chain(ends()).collect();
    let spline = ClampedSpline::new(knots.clone(), points.clone())?;
    let size = |k: usize| spline.position(k as f64 / PARTS as f64).norm();
    let largest = (0..=PARTS).map(size).fold(0.0, f64::max);
    if largest <= most {
        return Some(spline);
    }
    ClampedSpline::new(knots, points.into_iter().map(|p| p * (most / largest)).collect())
}

impl SmoothPath {
    /// The path gone along in this way; the sway is made smaller until it keeps the angular limits.
    /// Position and orientation have limits of their own, so that this is apart from the program for
    /// the positions.
    pub(super) fn gone(mut self, turning: Option<&Turning>, limits: &PathLimits) -> Self {
        let Some(turning) = turning else { return self };
        let of = |factor: f64| {
            let sway = turning.sway.as_ref().filter(|_| factor > 0.0).map(|s| s.scaled(factor));
            Some(Box::new(Turning { pause: turning.pause, sway }))
        };
        self.turning = of(1.0);
        if turning.sway.is_none() || self.keeps_angular(limits) {
            return self;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            self.turning = of(middle);
            if self.keeps_angular(limits) { low = middle } else { high = middle }
        }
        self.turning = of(low);
        self
    }

    fn keeps_angular(&self, limits: &PathLimits) -> bool {
        let finer = 4 * self.steps();
        let h = self.duration_s() / finer as f64;
        let turned: Vec<_> = (0..=finer).map(|k| self.pose_at(k as f64 * h).rotation).collect();
        let speeds: Vec<Vec3> =
            turned.windows(2).map(|w| rotation_between(&w[0], &w[1]) / h).collect();
        // A hundredth of room, because the check afterwards looks more closely.
        let (speed, acceleration) =
            (0.99 * limits.angular_speed_rad_s, 0.99 * limits.angular_acceleration_rad_s2);
        speeds.iter().all(|w| w.norm() <= speed)
            && speeds.windows(2).all(|w| (w[1] - w[0]).norm() <= acceleration * h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::path::{Candidate, Family, Projection, ProjectionSettings, Scene, project_within};
    use crate::path::{reference_path, verify};
    use approx::assert_relative_eq;

    fn limits() -> PathLimits {
        PathLimits::default()
    }

    fn still() -> SmoothPath {
        let start = Pose::translation(0.4, 0.0, 1.0);
        let goal = Pose::new(Vec3::new(0.4, 0.0, 1.0), Vec3::new(0.0, 0.0, 0.5));
        SmoothPath::integrate(&start, &goal, 0.04, vec![Vec3::zeros(); 100])
    }

    #[test]
    fn a_sway_is_bounded_and_keeps_the_angular_limits() {
        let turns = [Vec3::x() * 0.9, Vec3::y() * -0.7, Vec3::z() * 0.8];
        let bounded = sway(&turns, 0.3).unwrap();
        let largest = (0..=1000).map(|k| bounded.position(f64::from(k) / 1e3).norm());
        assert_relative_eq!(largest.fold(0.0, f64::max), 0.3, epsilon = 1e-3);
        let turning = Turning { pause: None, sway: Some(bounded) };
        let wide = PathLimits {
            angular_speed_rad_s: 50.0,
            angular_acceleration_rad_s2: 500.0,
            ..limits()
        };
        let kept = still().gone(Some(&turning), &wide);
        assert_eq!(kept.turning.as_deref(), Some(&turning));
        // The ends are the asked ones, whatever is between.
        let (a, b) = (still().pose_at(0.0), still().pose_at(4.0));
        assert!(kept.pose_at(0.0).rotation.angle_to(&a.rotation) < 1e-9);
        assert!(kept.pose_at(4.0).rotation.angle_to(&b.rotation) < 1e-9);
        assert!(kept.pose_at(1.5).rotation.angle_to(&still().pose_at(1.5).rotation) > 0.1);

        let tight =
            PathLimits { angular_speed_rad_s: 0.4, angular_acceleration_rad_s2: 0.8, ..limits() };
        let smaller = still().gone(Some(&turning), &tight);
        assert!(verify(&smaller, &tight).is_ok(), "{:?}", verify(&smaller, &tight));
        let at = smaller.turning.as_ref().unwrap().sway.as_ref().unwrap().position(0.3).norm();
        let full = turning.sway.as_ref().unwrap().position(0.3).norm();
        assert!(at > 0.05 * full && at < full, "{at} {full}");
    }

    #[test]
    fn the_twist_is_the_derivative_of_the_pose() {
        let turns = [Vec3::x() * 0.4, Vec3::new(0.1, -0.3, 0.2), Vec3::z() * 0.3];
        let pause = Some(Pause { phase: 0.4, dwell_s: 0.8 });
        let turning = Turning { pause, sway: sway(&turns, 1.0) };
        let wide = PathLimits {
            angular_speed_rad_s: 50.0,
            angular_acceleration_rad_s2: 500.0,
            ..limits()
        };
        let path = still().gone(Some(&turning), &wide);
        for t in [0.3, 0.9, 1.5, 2.6, 3.4] {
            let h = 1e-5;
            let (a, b) = (path.pose_at(t - h).rotation, path.pose_at(t + h).rotation);
            let numeric = rotation_between(&a, &b) / (2.0 * h);
            let own = path.twist_at(t).fixed_rows::<3>(3).into_owned();
            assert_relative_eq!(numeric, own, epsilon = 1e-6);
        }
        // It rests in the middle of its pause.
        assert!(path.twist_at(1.6).norm() < 1e-12);
    }

    #[test]
    fn a_reference_rests_where_it_is_asked_to() {
        let (a, b) = (Pose::translation(0.0, 0.0, 1.0), Pose::translation(0.4, 0.0, 1.0));
        let candidate = Candidate {
            id: "rests".to_owned(),
            family: Family::Sampled,
            vias: vec![
                Vec3::new(0.1, 0.0, 1.1),
                Vec3::new(0.2, 0.0, 1.2),
                Vec3::new(0.3, 0.0, 1.1),
            ],
            parameters: vec![0.25, 0.5, 0.75],
            turns: Vec::new(),
            dwell_s: 1.0,
            pace: None,
        };
        let path = reference_path(&candidate, &a, &b, 3.0, 300).unwrap();
        let middle = candidate.vias[1];
        let resting: Vec<usize> = (0..=300)
            .filter(|k| (path.poses[*k].translation.vector - middle).norm() < 1e-4)
            .collect();
        let rest = path.time_s[resting[resting.len() - 1]] - path.time_s[resting[0]];
        assert!((0.98..1.2).contains(&rest), "{rest}");
        // So does what the limits leave of it.
        let settings = ProjectionSettings::default();
        let turning = candidate.turning(&a, &b, f64::INFINITY).unwrap();
        let scene = Scene { turning: Some(&turning), ..Scene::default() };
        let slow = reference_path(&candidate, &a, &b, 5.0, 100).unwrap();
        let fast = PathLimits { speed_m_s: 0.5, ..limits() };
        let projected = project_within(&slow, &fast, &scene, &settings);
        let Projection::Feasible { path, .. } = projected else { panic!("{projected:?}") };
        assert!(verify(&path, &fast).is_ok());
        let rest = (0..=500).map(|k| f64::from(k) * 0.01);
        let rest = rest.filter(|t| path.state_at(*t)[1].norm() < 2e-3 && *t > 0.5 && *t < 4.5);
        assert!((85..=110).contains(&rest.count()));
        assert_relative_eq!(turning.pause.unwrap().phase, 0.5, epsilon = 1e-3);
    }
}

//! A path with piecewise constant jerk, known exactly at every time.
//!
//! ```text
//! p(t_k + e) = p_k + v_k e + a_k e^2 / 2 + j_k e^3 / 6,   0 <= e <= dt,   t_k = k dt
//! ```
//! The orientation turns from start to goal about one fixed axis by the minimum-jerk law, with what
//! [`Turning`] adds.

use super::spline::ClampedSpline;
use super::turning::Turning;
use crate::math::pose::rotation_between;
use crate::math::{Pose, Vec3, Vec6};
use crate::trajectory::{TimedPath, TrajectoryError, phase};
use nalgebra::UnitQuaternion;
use serde::Serialize;

/// Positions with their derivatives at the knots, and the turn from the first orientation to the
/// last. World axes; T steps, so T + 1 knots.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmoothPath {
    /// Time between knots, s.
    pub step_s: f64,
    /// Positions, T + 1, m.
    pub position: Vec<Vec3>,
    /// Velocities, T + 1, m/s.
    pub velocity: Vec<Vec3>,
    /// Accelerations, T + 1, m/s^2.
    pub acceleration: Vec<Vec3>,
    /// Jerks, one for each of the T steps, m/s^3.
    pub jerk: Vec<Vec3>,
    /// Orientation at the start.
    pub rotation: UnitQuaternion<f64>,
    /// Rotation vector from the start to the goal, rad.
    pub turn: Vec3,
    /// Where it rests on its way and how the tool turns besides, if it does.
    pub turning: Option<Box<Turning>>,
}

impl SmoothPath {
    /// Integrates jerks (T vectors, m/s^3) exactly from rest at the position of `start`, turning to
    /// the orientation of `goal`.
    pub fn integrate(start: &Pose, goal: &Pose, step_s: f64, jerk: Vec<Vec3>) -> Self {
        let h = step_s;
        let (mut p, mut v, mut a) = (start.translation.vector, Vec3::zeros(), Vec3::zeros());
        let mut path = Self {
            step_s,
            position: vec![p],
            velocity: vec![v],
            acceleration: vec![a],
            jerk,
            rotation: start.rotation,
            turn: rotation_between(&start.rotation, &goal.rotation),
            turning: None,
        };
        for j in &path.jerk {
            p += (v + (a / 2.0 + j * (h / 6.0)) * h) * h;
            v += (a + j * (h / 2.0)) * h;
            a += j * h;
            path.position.push(p);
            path.velocity.push(v);
            path.acceleration.push(a);
        }
        path
    }

    /// Number of steps T.
    pub fn steps(&self) -> usize {
        self.jerk.len()
    }

    /// Duration, s.
    pub fn duration_s(&self) -> f64 {
        self.step_s * self.steps() as f64
    }

    /// Position (m), velocity, acceleration and jerk at time `t` (s), clamped to the path.
    pub fn state_at(&self, t: f64) -> [Vec3; 4] {
        let k = ((t / self.step_s).max(0.0) as usize).min(self.steps().saturating_sub(1));
        let e = (t - k as f64 * self.step_s).clamp(0.0, self.step_s);
        let (v, a, j) = (self.velocity[k], self.acceleration[k], self.jerk[k]);
        [
            self.position[k] + v * e + a * (e * e / 2.0) + j * (e * e * e / 6.0),
            v + a * e + j * (e * e / 2.0),
            a + j * e,
            j,
        ]
    }

    /// Share of the way and its rate (1/s) at time `t` (s).
    fn phase_at(&self, t: f64) -> [f64; 2] {
        phase(t, self.duration_s(), self.turning.as_ref().and_then(|t| t.pause))
    }

    fn sway(&self) -> Option<&ClampedSpline> {
        self.turning.as_ref().and_then(|t| t.sway.as_ref())
    }

    /// Pose at time `t` (s), clamped to the path.
    pub fn pose_at(&self, t: f64) -> Pose {
        let [s, _] = self.phase_at(t);
        let mut rotation = UnitQuaternion::from_scaled_axis(self.turn * s) * self.rotation;
        if let Some(sway) = self.sway() {
            rotation *= UnitQuaternion::from_scaled_axis(sway.position(s));
        }
        Pose::from_parts(self.state_at(t)[0].into(), rotation)
    }

    /// Twist at time `t` (s), clamped to the path: linear (m/s), angular (rad/s), world axes.
    pub fn twist_at(&self, t: f64) -> Vec6 {
        let v = self.state_at(t)[1];
        let w = self.angular_at(t);
        Vec6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// Angular velocity (rad/s) at time `t` (s), world axes.
    fn angular_at(&self, t: f64) -> Vec3 {
        let [s, rate] = self.phase_at(t);
        let mut angular = self.turn * rate;
        if let Some(sway) = self.sway() {
            let before = UnitQuaternion::from_scaled_axis(self.turn * s) * self.rotation;
            angular += before * left_jacobian(&sway.position(s), &(sway.slope(s) * rate));
        }
        angular
    }

    /// The path at `steps + 1` equidistant times.
    pub fn timed(&self, steps: usize) -> Result<TimedPath, TrajectoryError> {
        TimedPath::sample(self.duration_s(), steps, |t| self.pose_at(t))
    }
}

/// Angular velocity of `exp(w)` when `w` changes at `rate`, in the axes before the turn.
fn left_jacobian(w: &Vec3, rate: &Vec3) -> Vec3 {
    let angle = w.norm();
    // Series below: 1 - cos and 1 - sin / angle lose their digits.
    let (a, b) = if angle < 1e-4 {
        (0.5, 1.0 / 6.0)
    } else {
        ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3))
    };
    let cross = w.cross(rate);
    rate + cross * a + w.cross(&cross) * b
}

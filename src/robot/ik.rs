//! Inverse kinematics: from a pose of the TCP to a posture near a given one.
//!
//! Damped least squares on the error `e` (angular part scaled to m), with a pull `z` towards the
//! middle of the joint ranges in the null space:
//!
//! ```text
//! dq = z + J^T (J J^T + lambda I)^-1 (e - J z)    lambda = 1e-6 + 1e-2 |e|^2,  z = |e| (mid - q)
//! ```
//! Damping and pull both vanish with the error. A pull that did not would push the posture on after
//! the pose is reached, and the iteration would never settle. Near the target the damping is left
//! out (Newton). A joint that would leave its range is held at the limit and the step is solved
//! again without it. A slide is held a little before its stop: it gets there at speed, and a controller
//! that joins the knots smoothly swings on.

use super::body::ROTATION_SCALE_M;
use super::description::Robot;
use crate::kinematics::Frames;
use crate::math::pose::pose_error;
use crate::math::{Pose, Vec6};
use nalgebra::{DVector, Matrix6, Matrix6xX};

/// Error (m) below which the damping is left out.
const NEWTON_BELOW: f64 = 1e-3;
/// Keeps the factorisation alive in singular postures, m^2.
const LEAST_DAMPING: f64 = 1e-12;
/// Largest move of a joint in one step, rad or m.
const LONGEST_STEP: f64 = 0.5;
/// Largest weight of the pull in one step.
const STRONGEST_PULL: f64 = 0.5;
/// Way before its stop at which a slide is held: a share of its range, and at most this, m.
const STOP_SHARE: f64 = 0.01;
pub(super) const BEFORE_STOP_M: f64 = 0.005;
/// Steps without progress after which the search gives up.
const PATIENCE: usize = 12;

/// How far a posture is from the wanted pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residual {
    /// Distance, m.
    pub(super) m: f64,
    /// Angle, rad.
    pub(super) rad: f64,
}

impl Residual {
    /// One number for comparison, m.
    pub(super) fn size(&self) -> f64 {
        self.m.hypot(ROTATION_SCALE_M * self.rad)
    }

    /// True when within both tolerances; never for NaN.
    pub(super) fn is_within(&self, tolerance_m: f64, tolerance_rad: f64) -> bool {
        self.m <= tolerance_m && self.rad <= tolerance_rad
    }
}

/// Scratch for repeated solving with one robot.
#[derive(Debug)]
pub(super) struct Solver<'r> {
    robot: &'r Robot,
    tolerance: (f64, f64),
    /// Weight of the pull to the middle of the ranges: 1, or 0 for the smallest joint moves.
    pub(super) centring: f64,
    /// Ranges within which joints are moved, rad or m.
    lower: Vec<f64>,
    upper: Vec<f64>,
    frames: Frames,
    jacobian: Matrix6xX<f64>,
    pull: DVector<f64>,
    step: DVector<f64>,
    held: Vec<bool>,
}

impl<'r> Solver<'r> {
    pub(super) fn new(robot: &'r Robot, tolerance_m: f64, tolerance_rad: f64) -> Self {
        let n = robot.dof();
        let limits = &robot.limits;
        let before_stop = |i: usize| {
            let is_slide = robot.linkage.joints()[i].is_prismatic;
            let range = limits.upper[i] - limits.lower[i];
            if is_slide { (STOP_SHARE * range).min(BEFORE_STOP_M) } else { 0.0 }
        };
        Self {
            robot,
            tolerance: (tolerance_m, tolerance_rad),
            centring: 1.0,
            lower: (0..n).map(|i| limits.lower[i] + before_stop(i)).collect(),
            upper: (0..n).map(|i| limits.upper[i] - before_stop(i)).collect(),
            frames: Frames::default(),
            jacobian: Matrix6xX::zeros(n),
            pull: DVector::zeros(n),
            step: DVector::zeros(n),
            held: vec![false; n],
        }
    }

    /// Moves `q` to the pose `target` of the TCP in the base link's frame, in at most `most` steps.
    /// Whether it arrived is in the residual; `q` is within the limits either way.
    pub(super) fn solve(&mut self, target: &Pose, q: &mut [f64], most: usize) -> Residual {
        let mut least = f64::INFINITY;
        let mut idle = 0;
        let mut is_polished = false;
        for taken in 0.. {
            self.robot.linkage.forward(q, &mut self.frames);
            let error = pose_error(&self.robot.linkage.tip_pose(&self.frames, 0), target);
            let residual = Residual {
                m: error.fixed_rows::<3>(0).norm(),
                rad: error.fixed_rows::<3>(3).norm(),
            };
            let size = residual.size();
            idle = if size < 0.99 * least { 0 } else { idle + 1 };
            least = least.min(size);
            let is_there = residual.is_within(self.tolerance.0, self.tolerance.1);
            if taken >= most || idle > PATIENCE || !size.is_finite() {
                return residual;
            }
            if is_there {
                // One Newton step more costs little and leaves rounding only. A posture that was
                // there from the start is left as it is.
                if is_polished || taken == 0 {
                    return residual;
                }
                is_polished = true;
            }
            if !self.advance(error, size, q) {
                return residual;
            }
        }
        Residual { m: f64::INFINITY, rad: f64::INFINITY }
    }

    /// One step; false when no step can be computed.
    fn advance(&mut self, mut error: Vec6, size: f64, q: &mut [f64]) -> bool {
        let limits = &self.robot.limits;
        self.robot.linkage.jacobian_into(&self.frames, 0, &mut self.jacobian);
        self.jacobian.rows_mut(3, 3).scale_mut(ROTATION_SCALE_M);
        error.fixed_rows_mut::<3>(3).scale_mut(ROTATION_SCALE_M);
        for (i, &at) in q.iter().enumerate() {
            let way = limits.middle(i).map_or(0.0, |middle| middle - at);
            self.pull[i] = self.centring * way * size.min(STRONGEST_PULL);
        }
        self.held.fill(false);
        let damping = if size < NEWTON_BELOW { LEAST_DAMPING } else { 1e-6 + 1e-2 * size * size };
        for _ in 0..=q.len() {
            if !self.least_squares(&error, damping) {
                return false;
            }
            let mut is_new = false;
            for (i, &at) in q.iter().enumerate() {
                let out = (at <= self.lower[i] && self.step[i] < 0.0)
                    || (at >= self.upper[i] && self.step[i] > 0.0);
                if out && !self.held[i] {
                    self.held[i] = true;
                    self.pull[i] = 0.0;
                    self.jacobian.column_mut(i).fill(0.0);
                    is_new = true;
                }
            }
            if !is_new {
                break;
            }
        }
        let shrink = (LONGEST_STEP / self.step.amax()).min(1.0);
        for (i, at) in q.iter_mut().enumerate() {
            *at = (*at + shrink * self.step[i]).max(self.lower[i]).min(self.upper[i]);
        }
        true
    }

    /// The step for the present Jacobian and pull; held joints have empty columns and no pull.
    fn least_squares(&mut self, error: &Vec6, damping: f64) -> bool {
        let mut square = Matrix6::from_diagonal_element(damping);
        let mut rest = *error;
        for (column, &z) in self.jacobian.column_iter().zip(self.pull.iter()) {
            square.syger(1.0, &column, &column, 1.0);
            rest -= column * z;
        }
        let Some(factor) = square.cholesky() else { return false };
        let force = factor.solve(&rest);
        for (i, column) in self.jacobian.column_iter().enumerate() {
            self.step[i] = self.pull[i] + column.dot(&force);
        }
        self.step.iter().all(|s| s.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use rand::RngExt;

    #[test]
    fn tracking_settles_in_few_steps() {
        // The trap: a pull that does not vanish with the error stops convergence.
        let robot = Robot::preset("panda").unwrap();
        let mut solver = Solver::new(&robot, 1e-8, 1e-8);
        let mut q = robot.home.clone();
        let start = super::super::tcp_pose(&robot, &q);
        for k in 1..=50 {
            let mut target = start;
            target.translation.vector.y += 0.005 * f64::from(k);
            let residual = solver.solve(&target, &mut q, 5);
            assert!(residual.is_within(1e-8, 1e-8), "knot {k}: {residual:?}");
        }
        // Nothing moves once the pose is reached.
        let (mut target, before) = (start, q.clone());
        target.translation.vector.y += 0.25;
        solver.solve(&target, &mut q, 50);
        assert_eq!(q, before);
    }

    #[test]
    fn a_single_try_from_nearby_recovers_random_postures() {
        for name in super::super::PRESETS {
            let robot = Robot::preset(name).unwrap();
            let mut solver = Solver::new(&robot, 1e-8, 1e-8);
            let mut found = 0;
            for index in 0..300 {
                let mut rng = stream(8, Purpose::Simulation, 0, index);
                let mut draw = || rng.random::<f64>();
                let range = robot.limits.lower.iter().zip(&robot.limits.upper);
                let truth: Vec<f64> = range.map(|(l, u)| l + (u - l) * draw()).collect();
                let mut q: Vec<f64> = truth.iter().map(|q| q + 0.4 * (draw() - 0.5)).collect();
                let target = super::super::tcp_pose(&robot, &truth);
                let residual = solver.solve(&target, &mut q, 100);
                found += usize::from(residual.is_within(1e-8, 1e-8));
                let limits = robot.limits.lower.iter().zip(&robot.limits.upper);
                assert!(q.iter().zip(limits).all(|(q, (l, u))| (l..=u).contains(&q)));
            }
            assert!(found >= 285, "{name}: {found} of 300");
        }
    }
}

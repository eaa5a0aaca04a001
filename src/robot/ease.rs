//! The null space while tracking: away from limits, singular postures, obstacles and the arm itself.
//!
//! Before each knot is solved, the posture is moved within the null space of the Jacobian, down the
//! slope of a field that is zero where there is room; the pose is then solved from there. The field
//! only chooses where the iteration starts, so that it cannot keep it from settling.

use super::body::ROTATION_SCALE_M;
use super::clearance::Obstacle;
use super::description::Robot;
use super::grade::Judge;
use crate::kinematics::Frames;
use nalgebra::{DVector, Matrix6, Matrix6xX};

/// Step of the finite differences, rad or m.
const PROBE: f64 = 1e-3;
/// Joint speed per unit of slope, rad/s.
const GAIN: f64 = 0.5;
/// Share of the joints' speed limits that moving in the null space may take.
const SHARE: f64 = 0.25;

/// Moves postures within the null space.
#[derive(Debug)]
pub(super) struct Ease<'r> {
    judge: Judge<'r>,
    frames: Frames,
    jacobian: Matrix6xX<f64>,
}

impl<'r> Ease<'r> {
    /// `None` for an arm without redundancy.
    pub(super) fn new(robot: &'r Robot, obstacles: &'r [(String, Obstacle)]) -> Option<Self> {
        (robot.dof() > 6).then(|| Self {
            judge: Judge::new(robot, obstacles),
            frames: Frames::default(),
            jacobian: Matrix6xX::zeros(robot.dof()),
        })
    }

    /// Unit vectors that span the null space of the TCP's Jacobian, n each.
    pub(super) fn null_space(&mut self, q: &[f64]) -> Vec<DVector<f64>> {
        let robot = self.judge.placer.robot;
        robot.linkage.forward(q, &mut self.frames);
        robot.linkage.jacobian_into(&self.frames, 0, &mut self.jacobian);
        self.jacobian.rows_mut(3, 3).scale_mut(ROTATION_SCALE_M);
        let square: Matrix6<f64> =
            &self.jacobian * self.jacobian.transpose() + Matrix6::from_diagonal_element(1e-9);
        let Some(factor) = square.cholesky() else { return Vec::new() };
        let n = robot.dof();
        let mut basis: Vec<DVector<f64>> = Vec::with_capacity(n - 6);
        for _ in 6..n {
            // The unit joint motion of which most is left after projection.
            let mut longest = DVector::zeros(n);
            for i in 0..n {
                let column = self.jacobian.column(i).into_owned();
                let mut left = -(self.jacobian.transpose() * factor.solve(&column));
                left[i] += 1.0;
                for known in &basis {
                    let along = known.dot(&left);
                    left.axpy(-along, known, 1.0);
                }
                if left.norm() > longest.norm() + 1e-12 {
                    longest = left;
                }
            }
            if let Some(unit) = longest.try_normalize(1e-6) {
                basis.push(unit);
            }
        }
        basis
    }

    /// Moves `q` down the field's slope, as far as a step of `h` seconds allows.
    pub(super) fn push(&mut self, q: &mut [f64], h: f64) {
        let mut step = DVector::zeros(q.len());
        let mut probe = q.to_vec();
        for direction in self.null_space(q) {
            let mut at = |way: f64| {
                for (p, (q, d)) in probe.iter_mut().zip(q.iter().zip(&direction)) {
                    *p = q + way * d;
                }
                self.judge.slope_field(&probe)
            };
            let slope = (at(PROBE) - at(-PROBE)) / (2.0 * PROBE);
            step.axpy(-GAIN * slope * h.min(1.0), &direction, 1.0);
        }
        let limits = &self.judge.placer.robot.limits;
        let share = step.iter().zip(&limits.velocity).map(|(s, v)| s.abs() / (SHARE * v * h));
        let shrink = share.fold(1.0, f64::max);
        for (i, at) in q.iter_mut().enumerate() {
            *at = (*at + step[i] / shrink).max(limits.lower[i]).min(limits.upper[i]);
        }
    }
}

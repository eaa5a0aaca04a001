//! A probabilistic movement primitive of the joint velocities over the phase of a movement.
//!
//! ```text
//! qdot(s) = sum_b psi_b(s) w_b + noise        w ~ N(mean, R R^T) over demonstrations
//! psi     normalised Gaussians, evenly spread over the phase s in [0, 1]
//! ```
//! Conditioned on the hand's velocity it is Bayesian task prioritisation (the paper's method 6).

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A fitted primitive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Primitive {
    /// Mean weights, B x n, rad/s.
    pub mean: DMatrix<f64>,
    /// Root R of their covariance, one n x r block for each of B basis functions, rad/s.
    pub root: Vec<DMatrix<f64>>,
    /// Covariance of the noise, n x n, (rad/s)^2.
    pub noise: DMatrix<f64>,
}

impl Primitive {
    /// Mean (n, rad/s) and covariance (n x n) of the joint velocity at a phase.
    pub fn at(&self, phase: f64) -> (DVector<f64>, DMatrix<f64>) {
        let psi = basis(self.root.len(), phase);
        let mean = self.mean.tr_mul(&psi);
        let mut root =
            DMatrix::zeros(self.noise.nrows(), self.root.first().map_or(0, DMatrix::ncols));
        for (p, block) in psi.iter().zip(&self.root) {
            root += block * *p;
        }
        (mean, &root * root.transpose() + &self.noise)
    }
}

/// Values of `count` normalised Gaussians at a phase.
pub fn basis(count: usize, phase: f64) -> DVector<f64> {
    let spacing = 1.0 / (count.max(2) - 1) as f64;
    let at = |b: usize| (-0.5 * ((phase - b as f64 * spacing) / spacing).powi(2)).exp();
    let psi = DVector::from_fn(count, |b, _| at(b));
    let sum = psi.sum();
    psi / sum
}

//! Gaussian process for what the weighted pseudo-inverse leaves unexplained (MI-NsGP, paper eq. 5
//! to 8, in the form that needs no null-space basis).
//!
//! ```text
//! s = qdot - J_W^+ xdot                 targets, n components that lie in null(J)
//! k((q,v),(q',v')) = exp(-|dq|^2 / (2 n l_q^2) - |dv|^2 / (2 m l_v^2)),  inputs standardised
//! z(q, xdot) = k (K + rho I)^-1 S       posterior mean; zero prior mean, noise ratio rho
//! ```
//! The mean is then conditioned on the task like any other `z`. The kernel does not depend on `W`.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Kernel parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GpHyper {
    /// Length-scale of the posture group, standard deviations per dimension.
    pub length_posture: f64,
    /// Length-scale of the velocity group.
    pub length_velocity: f64,
    /// Noise variance over signal variance.
    pub noise_ratio: f64,
}

/// A fitted process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NullSpaceGp {
    /// Kernel parameters.
    pub hyper: GpHyper,
    posture_count: usize,
    mean: Vec<f64>,
    spread: Vec<f64>,
    /// N x (n + m), standardised.
    inputs: DMatrix<f64>,
    /// (K + rho I)^-1 S, N x n, rad/s.
    coefficients: DMatrix<f64>,
}

/// Standardised inputs and their scale, before any targets are known.
#[derive(Debug, Clone)]
pub struct GpInputs {
    posture_count: usize,
    mean: Vec<f64>,
    spread: Vec<f64>,
    /// N x (n + m), standardised.
    pub rows: DMatrix<f64>,
}

impl GpInputs {
    /// Standardises postures (N x n, rad) and task velocities (N x m, m/s and rad/s).
    pub fn new(postures: &DMatrix<f64>, velocities: &DMatrix<f64>) -> Self {
        let (n, m) = (postures.ncols(), velocities.ncols());
        let mut rows = DMatrix::zeros(postures.nrows(), n + m);
        rows.columns_mut(0, n).copy_from(postures);
        rows.columns_mut(n, m).copy_from(velocities);
        let (mut mean, mut spread) = (Vec::new(), Vec::new());
        for mut column in rows.column_iter_mut() {
            let centre = column.mean();
            let scale = column.variance().sqrt().max(1e-6);
            column.iter_mut().for_each(|v| *v = (*v - centre) / scale);
            mean.push(centre);
            spread.push(scale);
        }
        Self { posture_count: n, mean, spread, rows }
    }

    /// Kernel matrix with the noise ratio on its diagonal, N x N.
    pub fn kernel(&self, hyper: &GpHyper) -> DMatrix<f64> {
        let count = self.rows.nrows();
        let rows: Vec<Vec<f64>> =
            self.rows.row_iter().map(|r| r.iter().copied().collect()).collect();
        DMatrix::from_fn(count, count, |i, j| {
            let k = kernel(&rows[i], &rows[j], self.posture_count, hyper);
            if i == j { k + hyper.noise_ratio } else { k }
        })
    }

    /// Finishes the process for targets S (N x n, rad/s); `None` when the kernel matrix is not
    /// positive definite.
    pub fn fit(self, hyper: GpHyper, targets: &DMatrix<f64>) -> Option<NullSpaceGp> {
        let coefficients = self.kernel(&hyper).cholesky()?.solve(targets);
        let Self { posture_count, mean, spread, rows } = self;
        Some(NullSpaceGp { hyper, posture_count, mean, spread, inputs: rows, coefficients })
    }
}

impl NullSpaceGp {
    /// Posterior mean of z at a posture (n, rad) and task velocity (m), rad/s.
    pub fn mean(&self, q: &[f64], task_velocity: &[f64]) -> DVector<f64> {
        let x: Vec<f64> = q
            .iter()
            .chain(task_velocity)
            .zip(self.mean.iter().zip(&self.spread))
            .map(|(v, (m, s))| (v - m) / s)
            .collect();
        let k = DVector::from_fn(self.inputs.nrows(), |i, _| {
            let row: Vec<f64> = self.inputs.row(i).iter().copied().collect();
            kernel(&row, &x, self.posture_count, &self.hyper)
        });
        self.coefficients.tr_mul(&k)
    }
}

fn kernel(a: &[f64], b: &[f64], posture_count: usize, hyper: &GpHyper) -> f64 {
    let squared = |range: std::ops::Range<usize>, length: f64| -> f64 {
        let sum: f64 = range.clone().map(|i| (a[i] - b[i]).powi(2)).sum();
        sum / (range.len().max(1) as f64 * length * length)
    };
    let posture = squared(0..posture_count, hyper.length_posture);
    let velocity = squared(posture_count..a.len(), hyper.length_velocity);
    (-0.5 * (posture + velocity)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};
    use approx::assert_relative_eq;

    #[test]
    fn equals_a_naive_posterior() {
        let mut rng = stream(3, Purpose::Simulation, 0, 0);
        let mut random = |r: usize, c: usize| DMatrix::from_vec(r, c, normals(&mut rng, r * c));
        let (q, v, s) = (random(12, 4), random(12, 2), random(12, 4));
        let hyper = GpHyper { length_posture: 0.8, length_velocity: 1.5, noise_ratio: 0.2 };
        let gp = GpInputs::new(&q, &v).fit(hyper, &s).unwrap();
        let (at_q, at_v) = ([0.1, -0.3, 0.2, 0.5], [0.4, -0.2]);
        // Naive: explicit inverse and double loop in raw units.
        let scale = |m: &DMatrix<f64>, c: usize| m.column(c).variance().sqrt();
        let k = |qa: &[f64], va: &[f64], qb: &[f64], vb: &[f64]| {
            let dq: f64 = (0..4).map(|c| ((qa[c] - qb[c]) / scale(&q, c)).powi(2)).sum();
            let dv: f64 = (0..2).map(|c| ((va[c] - vb[c]) / scale(&v, c)).powi(2)).sum();
            (-dq / (2.0 * 4.0 * 0.64) - dv / (2.0 * 2.0 * 2.25)).exp()
        };
        let row = |m: &DMatrix<f64>, i: usize| m.row(i).iter().copied().collect::<Vec<f64>>();
        let gram = DMatrix::from_fn(12, 12, |i, j| {
            k(&row(&q, i), &row(&v, i), &row(&q, j), &row(&v, j)) + if i == j { 0.2 } else { 0.0 }
        });
        let inverse = gram.try_inverse().unwrap();
        let cross = DVector::from_fn(12, |i, _| k(&row(&q, i), &row(&v, i), &at_q, &at_v));
        let naive = (inverse * s).tr_mul(&cross);
        assert_relative_eq!(gp.mean(&at_q, &at_v), naive, epsilon = 1e-10);
    }
}

//! What the search for weights minimises: quadratic forms in the residuals, one for each way of
//! judging a process on the data that trained it.
//!
//! ```text
//! R = S(w) diag(1/c)                 residuals under weights w, N x n, scales c fixed beforehand
//! Q(w) = tr(R^T M R)                 M depends on the kernel, never on w
//! min  N k / 2 log(Q / (N k)) + |log w|^2 / (2 sd^2)
//!
//! marginal           M = K^-1
//! leave-one-out      M = K^-1 D^-1 K^-1                  D = diag(K^-1)
//! leave-block-out    M = K^-1 B D^-1 B K^-1              B_b = ((K^-1)_bb)^-1, D = diag(B)
//! in-sample (paper)  N k / 2 log v + Q_s / (2 v)         M_s = K^-1 (rho^2 / D) K^-1,
//!                    D_t = 2 rho - rho^2 (K^-1)_tt,      v = Q_marginal / (N k)
//! ```
//! One factorisation of `K` serves a whole search; the gradient is that of a least-squares problem
//! with `2 M R` in the place of the residuals. The likelihood counts k = n - m of n components, and
//! is multiplied by `temper` where neighbouring samples are copies of each other.

use super::optimiser::ValueAndGradient;
use super::samples::Samples;
use crate::math::dense::{product, transposed_product};
use crate::training::settings::Objective;
use nalgebra::DMatrix;

/// A problem ready for a search over log w.
pub(super) struct WeightProblem<'a> {
    pub samples: &'a Samples,
    /// M of the quadratic form, N x N.
    pub form: DMatrix<f64>,
    /// Of the in-sample objective: `K^-1`, for the variance v.
    pub variance_form: Option<DMatrix<f64>>,
    /// c, n, rad/s.
    pub scales: Vec<f64>,
    /// In (0, 1].
    pub temper: f64,
    /// Standard deviation of the prior on log w.
    pub prior_sd: f64,
}

impl WeightProblem<'_> {
    /// Value (nats, without constants) and gradient at log w.
    pub(super) fn at(&self, log_w: &[f64]) -> ValueAndGradient {
        let weights: Vec<f64> = log_w.iter().map(|l| l.exp()).collect();
        let failed = (f64::INFINITY, vec![0.0; log_w.len()]);
        let Some(resolved) = self.samples.resolve(&weights) else { return failed };
        let scaled = divided(resolved.residuals(&weights), &self.scales);
        let terms = (self.samples.len() * self.samples.redundancy()) as f64;
        let along = product(&self.form, &scaled);
        let q = along.dot(&scaled).max(f64::MIN_POSITIVE);
        let (value, slope) = if let Some(form) = &self.variance_form {
            let prior = product(form, &scaled);
            let v = prior.dot(&scaled).max(f64::MIN_POSITIVE) / terms;
            let by_v = (0.5 * terms / v - 0.5 * q / (v * v)) * 2.0 / terms;
            (0.5 * terms * v.ln() + 0.5 * q / v, along / v + prior * by_v)
        } else {
            (0.5 * terms * (q / terms).ln(), along * (terms / q))
        };
        let mut gradient = resolved.gradient(&weights, &divided(slope, &self.scales));
        let precision = 1.0 / (self.prior_sd * self.prior_sd);
        for (g, l) in gradient.iter_mut().zip(log_w) {
            *g = self.temper * *g + precision * l;
        }
        let prior: f64 = log_w.iter().map(|l| 0.5 * precision * l * l).sum();
        (self.temper * value + prior, gradient)
    }
}

/// Each column divided by its scale.
pub(super) fn divided(mut rows: DMatrix<f64>, scales: &[f64]) -> DMatrix<f64> {
    for (mut column, scale) in rows.column_iter_mut().zip(scales) {
        column /= *scale;
    }
    rows
}

/// The matrix M of an objective from `K^-1`, the noise ratio and the block of each sample; and the
/// sum of log variances that goes with it (zero where log det K stands for it).
pub(super) fn quadratic_form(
    objective: Objective,
    inverse: &DMatrix<f64>,
    noise_ratio: f64,
    blocks: &[usize],
) -> Option<(DMatrix<f64>, f64)> {
    let scaled_gram = |factor: &dyn Fn(usize) -> f64, root: &DMatrix<f64>| {
        let mut root = root.clone();
        for (t, mut row) in root.row_iter_mut().enumerate() {
            row *= factor(t);
        }
        transposed_product(&root, &root)
    };
    match objective {
        Objective::Marginal => Some((inverse.clone(), 0.0)),
        Objective::LeaveOneOut => {
            let form = scaled_gram(&|t| 1.0 / inverse[(t, t)].sqrt(), inverse);
            Some((form, -inverse.diagonal().iter().map(|d| d.ln()).sum::<f64>()))
        }
        Objective::InSample => {
            let variance =
                |t: usize| (2.0 * noise_ratio - noise_ratio.powi(2) * inverse[(t, t)]).max(1e-300);
            let form = scaled_gram(&|t| noise_ratio / variance(t).sqrt(), inverse);
            Some((form, (0..inverse.nrows()).map(|t| variance(t).ln()).sum()))
        }
        Objective::LeaveTrialOut => {
            let count = inverse.nrows();
            let mut root = DMatrix::zeros(count, count);
            let mut logs = 0.0;
            let last = blocks.iter().max().copied().unwrap_or(0);
            for b in 0..=last {
                let members: Vec<usize> = (0..count).filter(|&t| blocks[t] == b).collect();
                if members.is_empty() {
                    continue;
                }
                let own = inverse.select_rows(&members);
                let inner = own.select_columns(&members).cholesky()?.inverse();
                let mut rows = product(&inner, &own);
                for (i, mut row) in rows.row_iter_mut().enumerate() {
                    row /= inner[(i, i)].sqrt();
                    logs += inner[(i, i)].ln();
                }
                for (i, &t) in members.iter().enumerate() {
                    root.row_mut(t).copy_from(&rows.row(i));
                }
            }
            Some((transposed_product(&root, &root), logs))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    /// K, a noise ratio and a target column.
    fn problem() -> (DMatrix<f64>, f64, DMatrix<f64>) {
        let count = 24;
        let mut rng = stream(6, Purpose::Simulation, 0, 0);
        let x = normals(&mut rng, count);
        let rho = 0.3;
        let k = DMatrix::from_fn(count, count, |i, j| {
            (-0.5 * (x[i] - x[j]).powi(2)).exp() + if i == j { rho } else { 0.0 }
        });
        (k, rho, DMatrix::from_vec(count, 1, normals(&mut rng, count)))
    }

    /// Squared standardised errors and log variances of predictions of `left` from `kept`.
    fn predicted(k: &DMatrix<f64>, r: &DMatrix<f64>, left: &[usize], kept: &[usize]) -> (f64, f64) {
        let inner = k.select_rows(kept).select_columns(kept).try_inverse().unwrap();
        let cross = k.select_rows(left).select_columns(kept);
        let mean = &cross * &inner * r.select_rows(kept);
        let covariance =
            k.select_rows(left).select_columns(left) - &cross * &inner * cross.transpose();
        let (mut square, mut logs) = (0.0, 0.0);
        for (i, &t) in left.iter().enumerate() {
            square += (r[(t, 0)] - mean[(i, 0)]).powi(2) / covariance[(i, i)];
            logs += covariance[(i, i)].ln();
        }
        (square, logs)
    }

    #[test]
    fn forms_equal_the_naive_predictions() {
        let (k, rho, r) = problem();
        let count = k.nrows();
        let inverse = k.clone().try_inverse().unwrap();
        let blocks: Vec<usize> = (0..count).map(|t| t / 6).collect();
        for objective in [Objective::LeaveOneOut, Objective::LeaveTrialOut] {
            let (form, logs) = quadratic_form(objective, &inverse, rho, &blocks).unwrap();
            let of = |t: usize| if objective == Objective::LeaveOneOut { t } else { blocks[t] };
            let (mut square, mut expected_logs) = (0.0, 0.0);
            for b in 0..=of(count - 1) {
                let pick = |own: bool| -> Vec<usize> {
                    (0..count).filter(|&t| (of(t) == b) == own).collect()
                };
                let (s, l) = predicted(&k, &r, &pick(true), &pick(false));
                square += s;
                expected_logs += l;
            }
            let q = (r.transpose() * &form * &r)[(0, 0)];
            assert!((q / square - 1.0).abs() < 1e-8, "{objective:?}: {q} {square}");
            assert!((logs - expected_logs).abs() < 1e-8);
        }
        // In-sample: training targets under the process that was trained on them.
        let signal = &k - DMatrix::identity(count, count) * rho;
        let mean = &signal * &inverse * &r;
        let covariance = &k - &signal * &inverse * &signal;
        let square: f64 =
            (0..count).map(|t| (r[(t, 0)] - mean[(t, 0)]).powi(2) / covariance[(t, t)]).sum();
        let (form, logs) = quadratic_form(Objective::InSample, &inverse, rho, &blocks).unwrap();
        let q = (r.transpose() * &form * &r)[(0, 0)];
        assert!((q / square - 1.0).abs() < 1e-8, "{q} {square}");
        let expected: f64 = (0..count).map(|t| covariance[(t, t)].ln()).sum();
        assert!((logs - expected).abs() < 1e-8);
    }
}

//! How well the data determine the weights: the curvature of the objective at its minimum.
//!
//! ```text
//! H = d^2 objective / d(log w)^2      the likelihood tempered by the correlation of its frames
//! sd_i = sqrt((P H^-1 P)_ii)          of log w about its mean, given the prior (sd 1 by default)
//! ```
//! A direction of log w is undetermined where the data leave more than half of the prior's variance.

use super::objective::WeightProblem;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Step of the central differences of the gradient.
const STEP: f64 = 1e-4;
/// Share of the prior's variance beyond which a direction or a joint counts as undetermined.
const OPEN_SHARE: f64 = 0.5;

/// What is known about log w.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightUncertainty {
    /// Standard deviation of each log weight, n.
    pub log_sd: Vec<f64>,
    /// Number of directions of log w, of n - 1 (their common scale changes nothing), that the data do
    /// not determine.
    pub undetermined_directions: usize,
    /// Joints whose weight is mostly the prior's.
    pub undetermined_joints: Vec<usize>,
    /// The factor of the log-likelihood for frames that are not independent, in (0, 1].
    pub temper: f64,
}

/// The curvature at log w.
pub(super) fn uncertainty(problem: &WeightProblem, log_w: &[f64]) -> WeightUncertainty {
    let n = log_w.len();
    let mut hessian = DMatrix::zeros(n, n);
    for i in 0..n {
        let shifted = |d: f64| {
            let mut x = log_w.to_vec();
            x[i] += d;
            problem.at(&x).1
        };
        let (up, down) = (shifted(STEP), shifted(-STEP));
        for j in 0..n {
            hessian[(i, j)] = (up[j] - down[j]) / (2.0 * STEP);
        }
    }
    let hessian = (&hessian + hessian.transpose()) * 0.5;
    let eigen = hessian.symmetric_eigen();
    let prior = 1.0 / (problem.prior_sd * problem.prior_sd);
    // Away from the exact minimum a flat direction may bend down by a little: the prior holds it.
    let precision = eigen.eigenvalues.map(|v| v.max(prior));
    let inverse = DMatrix::from_diagonal(&precision.map(|p| 1.0 / p));
    let covariance = &eigen.eigenvectors * inverse * eigen.eigenvectors.transpose();
    // The common scale of all weights changes nothing: only ratios count.
    let centre = DMatrix::identity(n, n) - DMatrix::from_element(n, n, 1.0 / n as f64);
    let ratios = &centre * covariance * &centre;
    let open = |variance: f64| variance * prior > OPEN_SHARE;
    let directions = ratios.clone().symmetric_eigen().eigenvalues;
    let variances = ratios.diagonal();
    WeightUncertainty {
        log_sd: variances.iter().map(|v| v.sqrt()).collect(),
        undetermined_directions: directions.iter().filter(|v| open(**v)).count(),
        undetermined_joints: (0..n).filter(|&i| open(variances[i])).collect(),
        temper: problem.temper,
    }
}

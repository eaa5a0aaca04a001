//! How well the data determine the weights: the curvature of the objective at its minimum.
//!
//! ```text
//! H = d^2 objective / d(log w)^2      the likelihood tempered by the correlation of its frames
//! sd_i = sqrt((H^-1)_ii)              of log w, given the prior (sd 1 by default)
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
    /// Number of directions of log w, of n, that the data do not determine (the common scale of all
    /// weights, which changes nothing, is one of them).
    pub undetermined_directions: usize,
    /// Joints whose weight is mostly the prior's.
    pub undetermined_joints: Vec<usize>,
    /// The factor of the log-likelihood for frames that are not independent, in (0, 1].
    pub temper: f64,
}

/// The curvature at log w.
pub(super) fn uncertainty(problem: &WeightProblem, log_w: &[f64]) -> Option<WeightUncertainty> {
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
    let open = |variance: f64| variance * prior > OPEN_SHARE;
    let variances: Vec<f64> = (0..n)
        .map(|i| (0..n).map(|k| eigen.eigenvectors[(i, k)].powi(2) / precision[k]).sum())
        .collect();
    Some(WeightUncertainty {
        log_sd: variances.iter().map(|v| v.sqrt()).collect(),
        undetermined_directions: precision.iter().filter(|p| open(1.0 / **p)).count(),
        undetermined_joints: (0..n).filter(|&i| open(variances[i])).collect(),
        temper: problem.temper,
    })
}

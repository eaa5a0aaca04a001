//! A diagonal W by least squares (W-IK), and the derivative of the pseudo-inverse that it needs.
//!
//! ```text
//! s(w) = qdot - J_W^+ xdot       W = diag(w)
//! min over log w of   N k / 2 log(sum |s|^2 / (N k)) + |log w|^2 / 2
//! d(c^T s)/d log w_i = -w_i u_i [c - J^T A^-1 J W c]_i     A = J W J^T,  u = J^T A^-1 xdot
//! ```
//! The noise variance is profiled out, so that the prior log w ~ N(0, 1) means the same for fast and
//! slow people. Samples whose `A` cannot be factored make the objective infinite.

use super::optimiser::{ValueAndGradient, descend};
use super::samples::Samples;
use super::tidy;
use crate::training::dataset::Frame;
use nalgebra::DMatrix;

/// Iterations of L-BFGS from a cold start.
const ITERATIONS: u64 = 150;
/// Iterations when nearly the same data have been fitted before.
const WARM_ITERATIONS: u64 = 40;
/// Gain of an iteration, nats, below which the search ends.
const TOLERANCE: f64 = 1e-6;
/// Smallest second moment, relative to the mean, in the start value.
const SMALLEST_START: f64 = 1e-3;

/// Profiled negative log-likelihood of the least-squares problem with the prior, nats.
pub(super) fn objective(samples: &Samples, log_w: &[f64]) -> ValueAndGradient {
    let weights: Vec<f64> = log_w.iter().map(|l| l.exp()).collect();
    let Some(resolved) = samples.resolve(&weights) else {
        return (f64::INFINITY, vec![0.0; log_w.len()]);
    };
    let residuals = resolved.residuals(&weights);
    let sum = residuals.norm_squared().max(f64::MIN_POSITIVE);
    let terms = (samples.len() * samples.redundancy()) as f64;
    let mut gradient = resolved.gradient(&weights, &residuals);
    for (g, l) in gradient.iter_mut().zip(log_w) {
        *g = terms * *g / sum + l;
    }
    let prior: f64 = log_w.iter().map(|l| 0.5 * l * l).sum();
    (0.5 * terms * (sum / terms).ln() + prior, gradient)
}

/// log w of W-IK, n, with mean zero. Starts at W = I and at the diagonal of the second moment, or
/// only at `warm`.
pub(super) fn least_squares(
    frames: &[&Frame],
    second_moment: &DMatrix<f64>,
    warm: Option<&[f64]>,
) -> Vec<f64> {
    let n = second_moment.nrows();
    let mean = second_moment.trace() / n as f64;
    let by_moment = second_moment.diagonal().map(|v| (v / mean).max(SMALLEST_START).ln());
    let (starts, iterations) = if let Some(log_w) = warm {
        (vec![log_w.to_vec()], WARM_ITERATIONS)
    } else {
        let moment = by_moment.add_scalar(-by_moment.mean()).as_slice().to_vec();
        (vec![vec![0.0; n], moment], ITERATIONS)
    };
    let samples = Samples::new(frames);
    let found = starts
        .iter()
        .map(|s| descend(&|x: &[f64]| objective(&samples, x), s, iterations, TOLERANCE));
    let best = found.min_by(|a, b| a.1.total_cmp(&b.1));
    tidy(best.map_or_else(|| vec![0.0; n], |(x, _)| x))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::redundancy::{resolve, weighted_pseudo_inverse};
    use crate::math::stream::{Purpose, normals, stream};
    use crate::training::dataset::Dataset;
    use crate::training::dataset::tests::made_up;
    use nalgebra::DVector;

    /// Frames of a person with known weights and preferred velocity z(q, draw).
    pub(in crate::training::methods) fn planted(
        z: impl Fn(&Frame, &[f64]) -> DVector<f64>,
    ) -> (Dataset, Vec<f64>) {
        let mut data = made_up(3, 8.0, 30.0);
        let n = data.joints.len();
        let mut rng = stream(11, Purpose::Simulation, 0, 0);
        let log_w = tidy(normals(&mut rng, n).iter().map(|v| 0.6 * v).collect());
        let weight =
            DMatrix::from_diagonal(&DVector::from_iterator(n, log_w.iter().map(|l| l.exp())));
        for f in &mut data.frames {
            let pinv = weighted_pseudo_inverse(&f.jacobian, &weight).unwrap();
            let preferred = z(f, &normals(&mut rng, n));
            f.qdot = resolve(&f.jacobian, &pinv, &f.xdot, &preferred);
        }
        (data, log_w)
    }

    pub(in crate::training::methods) fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
        let sum: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
        (sum / a.len() as f64).sqrt()
    }

    /// Largest relative error of a gradient against central differences.
    pub(in crate::training::methods) fn gradient_error(
        f: impl Fn(&[f64]) -> ValueAndGradient,
        x: &[f64],
    ) -> f64 {
        let (_, gradient) = f(x);
        let largest = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
        (0..x.len())
            .map(|i| {
                let shifted = |d: f64| {
                    let mut y = x.to_vec();
                    y[i] += d;
                    f(&y).0
                };
                let numeric = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                (numeric - gradient[i]).abs() / largest
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn gradient_agrees_with_finite_differences() {
        let data = made_up(1, 3.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let mut rng = stream(2, Purpose::Simulation, 0, 0);
        let x: Vec<f64> = normals(&mut rng, 24).iter().map(|v| 0.8 * v).collect();
        let samples = Samples::new(&frames);
        let error = gradient_error(|x| objective(&samples, x), &x);
        assert!(error < 1e-6, "{error}");
    }

    #[test]
    fn planted_weights_are_found() {
        let (data, truth) =
            planted(|_, draw| DVector::from_iterator(24, draw.iter().map(|v| 0.05 * v)));
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let found = least_squares(&frames, &DMatrix::identity(24, 24), None);
        let error = rms_difference(&found, &truth);
        assert!(error < 0.03, "rms error of log w {error}");
    }
}

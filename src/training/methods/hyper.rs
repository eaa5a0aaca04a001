//! Kernel parameters by marginal likelihood with its analytic gradient, or by leaving trials out.
//!
//! ```text
//! min  N k / 2 log(tr(R^T K^-1 R) / (N k)) + k / 2 log det K + priors       (signal variance profiled)
//! d/dtheta = tr(G dK/dtheta),   G = k/2 K^-1 - (N k / 2 Q) A A^T,   A = K^-1 R
//! ```
//! Parameters: log length-scale of the posture group, of the velocity group (or one for both), and
//! log(noise ratio - floor). Consecutive frames of people are nearly copies, so the noise ratio is
//! bounded from below: without that bound the process learns trials by heart.

use super::objective::quadratic_form;
use super::optimiser::{ValueAndGradient, descend};
use crate::math::dense::{Factor, product};
use crate::posture::{GpHyper, InputScale, cross_kernel, reduced};
use crate::training::settings::{Lengths, Objective};
use nalgebra::DMatrix;

/// Median and standard deviation of the prior on the log noise ratio.
const NOISE_PRIOR: (f64, f64) = (0.1, 1.5);
const ITERATIONS: u64 = 40;
/// Gain of an iteration, nats, below which the search ends.
const TOLERANCE: f64 = 0.02;
/// Step of the central differences of objectives without an analytic gradient.
const STEP: f64 = 1e-4;

/// Standardised inputs and scaled targets of a search for kernel parameters.
pub(super) struct HyperProblem<'a> {
    pub scale: &'a InputScale,
    /// N x D, standardised.
    pub rows: &'a DMatrix<f64>,
    /// R, N x p.
    pub targets: &'a DMatrix<f64>,
    /// k / n: the part of the components that is free.
    pub free_share: f64,
    pub floor: f64,
    pub lengths: Lengths,
    pub objective: Objective,
    /// Block of each sample.
    pub blocks: &'a [usize],
    /// In (0, 1].
    pub temper: f64,
}

impl HyperProblem<'_> {
    /// Kernel parameters from unbounded numbers.
    pub(super) fn hyper(&self, x: &[f64]) -> GpHyper {
        // Beyond these bounds a length-scale is zero or infinity for any data.
        let length = |v: f64| v.clamp(-4.0, 4.0).exp();
        let velocity = if self.lengths == Lengths::Isotropic { x[0] } else { x[1] };
        GpHyper {
            length_posture: length(x[0]),
            length_velocity: length(velocity),
            noise_ratio: self.floor + x[x.len() - 1].clamp(-14.0, 6.0).exp(),
        }
    }

    /// The unbounded numbers of kernel parameters.
    pub(super) fn point(&self, hyper: &GpHyper) -> Vec<f64> {
        let noise = (hyper.noise_ratio - self.floor).max(1e-6).ln();
        let (q, v) = (hyper.length_posture.ln(), hyper.length_velocity.ln());
        match self.lengths {
            Lengths::Isotropic => vec![0.5 * (q + v), noise],
            Lengths::Groups => vec![q, v, noise],
        }
    }

    /// The best parameters from a start.
    pub(super) fn search(&self, start: &GpHyper) -> GpHyper {
        let function = |x: &[f64]| self.at(x);
        self.hyper(&descend(&function, &self.point(start), ITERATIONS, TOLERANCE).0)
    }

    /// Value (nats) and gradient.
    pub(super) fn at(&self, x: &[f64]) -> ValueAndGradient {
        // In-sample likelihood prefers a process that learns by heart; the paper, too, fits its
        // kernels by marginal likelihood.
        match self.objective {
            Objective::Marginal | Objective::InSample => self.marginal(x),
            Objective::LeaveOneOut | Objective::LeaveTrialOut => {
                let shifted = |i: usize, d: f64| {
                    let mut y = x.to_vec();
                    y[i] += d;
                    self.left_out(&y)
                };
                let slope = |i: usize| (shifted(i, STEP) - shifted(i, -STEP)) / (2.0 * STEP);
                (self.left_out(x), (0..x.len()).map(slope).collect())
            }
        }
    }

    /// Kernel without noise, and K's parameters.
    fn kernel(&self, x: &[f64]) -> (GpHyper, DMatrix<f64>) {
        let hyper = self.hyper(x);
        let z = reduced(self.rows, &self.scale.reduction(&hyper));
        (hyper, cross_kernel(&z, &z))
    }

    fn factor(kernel: &DMatrix<f64>, noise_ratio: f64) -> Option<Factor> {
        let mut k = kernel.clone();
        for i in 0..k.nrows() {
            k[(i, i)] += noise_ratio;
        }
        Factor::new(&k)
    }

    fn prior(x: &[f64], hyper: &GpHyper) -> f64 {
        let ratio = (hyper.noise_ratio / NOISE_PRIOR.0).ln() / NOISE_PRIOR.1;
        let lengths: f64 = x[..x.len() - 1].iter().map(|v| v * v).sum();
        0.5 * (lengths + ratio * ratio)
    }

    fn marginal(&self, x: &[f64]) -> ValueAndGradient {
        let failed = (f64::INFINITY, vec![0.0; x.len()]);
        let (count, p) = self.targets.shape();
        let free = p as f64 * self.free_share;
        let (hyper, kernel) = self.kernel(x);
        let Some(factor) = Self::factor(&kernel, hyper.noise_ratio) else { return failed };
        let inverse = factor.inverse();
        let along = product(&inverse, self.targets);
        let q = along.dot(self.targets).max(f64::MIN_POSITIVE);
        let terms = count as f64 * free;
        let likelihood = 0.5 * terms * (q / terms).ln() + 0.5 * free * factor.log_det();
        let value = self.temper * likelihood + Self::prior(x, &hyper);

        let outer = product(&along, &along.transpose());
        let g = inverse * (0.5 * free) - outer * (0.5 * terms / q);
        // dK / dlog l of a group: K o (squared reduced distance within the group).
        let n = self.scale.posture_count;
        let z = reduced(self.rows, &self.scale.reduction(&hyper));
        let weighted = g.component_mul(&kernel);
        let ones = DMatrix::from_element(count, 1, 1.0);
        let sums = &weighted * &ones;
        let of_group = |from: usize, to: usize| -> f64 {
            // sum_ij H_ij |z_i - z_j|^2 = 2 sum_i h_i |z_i|^2 - 2 tr(Z^T H Z), H symmetric.
            let part = z.columns(from, to - from).into_owned();
            let moved = product(&weighted, &part);
            let squares: f64 =
                (0..count).map(|i| sums[i] * part.row(i).norm_squared()).sum();
            2.0 * squares - 2.0 * moved.dot(&part)
        };
        let (by_q, by_v) = (of_group(0, n), of_group(n, z.ncols()));
        let noise = x[x.len() - 1].clamp(-14.0, 6.0).exp();
        let by_noise = g.trace() * noise;
        let ratio = (hyper.noise_ratio / NOISE_PRIOR.0).ln() / NOISE_PRIOR.1.powi(2);
        let mut gradient = match self.lengths {
            Lengths::Isotropic => vec![by_q + by_v, by_noise],
            Lengths::Groups => vec![by_q, by_v, by_noise],
        };
        let last = gradient.len() - 1;
        for (i, g) in gradient.iter_mut().enumerate() {
            let prior = if i == last { ratio * noise / hyper.noise_ratio } else { x[i] };
            *g = self.temper * *g + prior;
        }
        (value, gradient)
    }

    fn left_out(&self, x: &[f64]) -> f64 {
        let (count, p) = self.targets.shape();
        let free = p as f64 * self.free_share;
        let (hyper, kernel) = self.kernel(x);
        let Some(factor) = Self::factor(&kernel, hyper.noise_ratio) else { return f64::INFINITY };
        let inverse = factor.inverse();
        let Some((form, logs)) =
            quadratic_form(self.objective, &inverse, hyper.noise_ratio, self.blocks)
        else {
            return f64::INFINITY;
        };
        let q = product(&form, self.targets).dot(self.targets).max(f64::MIN_POSITIVE);
        let terms = count as f64 * free;
        let likelihood = 0.5 * terms * (q / terms).ln() + 0.5 * free * logs;
        self.temper * likelihood + Self::prior(x, &hyper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};
    use crate::training::methods::diagonal::tests::gradient_error;

    #[test]
    fn gradient_agrees_with_finite_differences() {
        let mut rng = stream(8, Purpose::Simulation, 0, 0);
        let raw = DMatrix::from_vec(50, 6, normals(&mut rng, 300));
        let (scale, rows) = InputScale::fit(&raw, 4);
        let noise = DMatrix::from_vec(50, 3, normals(&mut rng, 150));
        let targets = DMatrix::from_fn(50, 3, |i, j| raw[(i, j)].sin() + 0.3 * noise[(i, j)]);
        for lengths in [Lengths::Groups, Lengths::Isotropic] {
            let problem = HyperProblem {
                scale: &scale,
                rows: &rows,
                targets: &targets,
                free_share: 0.75,
                floor: 0.02,
                lengths,
                objective: Objective::Marginal,
                blocks: &[],
                temper: 0.7,
            };
            let start = GpHyper { length_posture: 0.7, length_velocity: 1.4, noise_ratio: 0.2 };
            let x = problem.point(&start);
            let error = gradient_error(|x| problem.at(x), &x);
            assert!(error < 1e-5, "{error}");
            assert!((problem.hyper(&x).noise_ratio - 0.2).abs() < 1e-12);
        }
    }
}

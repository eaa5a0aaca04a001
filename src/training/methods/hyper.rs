//! Kernel parameters by marginal likelihood with its analytic gradient, or by leaving trials out.
//!
//! ```text
//! min  N k / 2 log(tr(R^T K^-1 R) / (N k)) + k / 2 log det K + priors       (signal variance profiled)
//! d/dtheta = k/2 tr(G dK/dtheta),   G = K^-1 - (N / Q) A A^T,   A = K^-1 R
//! ```
//! Parameters: log length-scale of the posture group, of the velocity group (or one for both), and
//! log(noise ratio - floor). Consecutive frames of people are nearly copies, so the noise ratio is
//! bounded from below: without that bound the process learns trials by heart.

use super::objective::quadratic_form;
use super::optimiser::{ValueAndGradient, descend};
use crate::math::dense::{Factor, add_lower_square, lower_product, product};
use crate::posture::{GpHyper, InputScale, lower_kernel, reduced};
use crate::training::settings::{Lengths, Objective};
use nalgebra::{DMatrix, DMatrixView};

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

    /// Kernel parameters, reduced inputs (N x D), and the lower triangle of K with its noise.
    fn kernel(&self, x: &[f64]) -> (GpHyper, DMatrix<f64>, DMatrix<f64>) {
        let hyper = self.hyper(x);
        let z = reduced(self.rows, &self.scale.reduction(&hyper));
        let mut kernel = lower_kernel(&z);
        for i in 0..kernel.nrows() {
            kernel[(i, i)] += hyper.noise_ratio;
        }
        (hyper, z, kernel)
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
        let (hyper, z, kernel) = self.kernel(x);
        let Some(factor) = Factor::new(&kernel) else { return failed };
        let along = factor.solve(self.targets);
        let q = along.dot(self.targets).max(f64::MIN_POSITIVE);
        let terms = count as f64 * free;
        let likelihood = 0.5 * terms * (q / terms).ln() + 0.5 * free * factor.log_det();
        let value = self.temper * likelihood + Self::prior(x, &hyper);

        // Only lower triangles: everything here is symmetric.
        let mut g = factor.lower_inverse();
        add_lower_square(&mut g, &along, -(count as f64) / q);
        let trace = g.trace();
        let sums = weigh(&mut g, &kernel);
        let moved = lower_product(&g, &z);
        // dK / dlog l of a group: K o (squared reduced distance within the group).
        let n = self.scale.posture_count;
        let of_group = |from: usize, size: usize| -> f64 {
            // sum_ij H_ij |z_i - z_j|^2 = 2 sum_i h_i |z_i|^2 - 4 tr(Z^T L Z) for H of zero diagonal,
            // its row sums h, and its lower triangle L.
            let part = z.columns(from, size);
            let squares = |z: DMatrixView<f64>| -> f64 {
                z.column_iter()
                    .map(|c| c.iter().zip(&sums).map(|(v, h)| h * v * v).sum::<f64>())
                    .sum()
            };
            0.5 * free * (2.0 * squares(part) - 4.0 * moved.columns(from, size).dot(&part))
        };
        let (by_q, by_v) = (of_group(0, n), of_group(n, z.ncols() - n));
        let noise = x[x.len() - 1].clamp(-14.0, 6.0).exp();
        let by_noise = 0.5 * free * trace * noise;
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
        let (hyper, _, kernel) = self.kernel(x);
        let Some(factor) = Factor::new(&kernel) else { return f64::INFINITY };
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

/// Multiplies the lower triangle of `g` by that of the kernel, N x N, and clears the diagonal; the row
/// sums of the symmetric product, N.
fn weigh(g: &mut DMatrix<f64>, kernel: &DMatrix<f64>) -> Vec<f64> {
    let mut sums = vec![0.0; g.nrows()];
    for (j, (mut g, k)) in g.column_iter_mut().zip(kernel.column_iter()).enumerate() {
        let (g, k) = (&mut g.as_mut_slice()[j..], &k.as_slice()[j..]);
        g[0] = 0.0;
        for ((g, k), sum) in g.iter_mut().zip(k).zip(&mut sums[j..]) {
            *g *= k;
            *sum += *g;
        }
        sums[j] += g.iter().sum::<f64>();
    }
    sums
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

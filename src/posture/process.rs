//! Gaussian process for what the weighted pseudo-inverse leaves unexplained (MI-NsGP, paper eq. 5 to
//! 8, in the form that needs no null-space basis), and functions drawn from its posterior.
//!
//! ```text
//! s = qdot - J_W^+ xdot                 targets, n components that lie in null(J), rad/s
//! S ~ N(0, (K / rho + I) (x) C)         one kernel for all outputs; C = F F^T the noise covariance
//! mean   z(x) = k(x, X) (K + rho I)^-1 S
//! share  v(x) = 1 - k(x, X) (K + rho I)^-1 k(X, x)        covariance of the function: C v(x) / rho
//! draw   f(x) = p(x) + k(x, X) (K + rho I)^-1 (S - p(X) - e),  p a prior draw, e ~ N(0, C)
//! ```
//! The draw is pathwise conditioning (Wilson et al. 2020): one function per rollout. Its prior draw
//! uses pairs of Fourier features with fresh frequencies, so its variance is exact far from the data.
//! With many samples the process rests on inducing centres Z (M of them):
//!
//! ```text
//! A = K_zz + K_zx K_xz / rho    z(x) = k(x, Z) A^-1 K_zx S / rho    v = 1 - k (K_zz^-1 - A^-1) k^T
//! ```
//! The kernel does not depend on `W`. The mean is then conditioned on the task like any other `z`.

use super::inducing::sums;
use super::kernel::{GpHyper, InputScale, Panels, lower_kernel, reduced};
use crate::math::dense::{Factor, product};
use crate::math::simd::{sin_cos, wide};
use crate::math::stream::normals;
use crate::physical::{FIGURE, JOINT_SPEED_RAD_S, POSITIVE, Range, shown};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Pairs of Fourier features of a prior draw.
const FEATURES: usize = 128;
/// Added to the diagonal of `K_zz`.
const JITTER: f64 = 1e-6;

/// A fitted process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Process {
    hyper: GpHyper,
    scale: InputScale,
    reduction: Vec<f64>,
    outputs: Vec<usize>,
    /// Standardised, M x D.
    centres: DMatrix<f64>,
    /// M x p, rad/s.
    coefficients: DMatrix<f64>,
    /// `K_zx K_xz / rho` of inducing centres, M x M.
    gram: Option<DMatrix<f64>>,
    panels: Panels,
    rows: Vec<f64>,
}

/// What the model file holds; the rest is recomputed.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    hyper: GpHyper,
    scale: InputScale,
    outputs: Vec<usize>,
    centres: DMatrix<f64>,
    coefficients_rad_s: DMatrix<f64>,
    gram: Option<DMatrix<f64>>,
}

impl TryFrom<Stored> for Process {
    type Error = String;
    fn try_from(s: Stored) -> Result<Self, String> {
        let (count, dimensions) = s.centres.shape();
        let fits = s.coefficients_rad_s.shape() == (count, s.outputs.len())
            && s.scale.mean.len() == dimensions
            && s.scale.spread.len() == dimensions
            && s.scale.posture_count <= dimensions
            && s.gram.as_ref().is_none_or(|g| g.shape() == (count, count));
        if !fits {
            return Err("the sizes of a process do not agree".to_owned());
        }
        s.prove().map_err(|e| format!("process: {e}"))?;
        Ok(Self::assemble(s.hyper, s.scale, s.outputs, s.centres, s.coefficients_rad_s, s.gram))
    }
}

impl Stored {
    /// Whether every number is one that it can be, and the gram matrix one.
    fn prove(&self) -> Result<(), String> {
        let h = &self.hyper;
        let checks: [(&str, Range, Vec<f64>); 5] = [
            ("hyper", POSITIVE, vec![h.length_posture, h.length_velocity, h.noise_ratio]),
            ("scale.mean", JOINT_SPEED_RAD_S, self.scale.mean.clone()),
            ("scale.spread", POSITIVE, self.scale.spread.clone()),
            ("centres", FIGURE, self.centres.iter().copied().collect()),
            ("coefficients_rad_s", FIGURE, self.coefficients_rad_s.iter().copied().collect()),
        ];
        for (what, range, values) in checks {
            if let Some(value) = range.outside(values) {
                return Err(format!("{what}: {} is outside {range}", shown(value)));
            }
        }
        let Some(gram) = &self.gram else { return Ok(()) };
        let is_sound = gram.iter().all(|v| v.is_finite())
            && (gram - gram.transpose()).amax() <= 1e-9 * gram.amax();
        if is_sound { Ok(()) } else { Err("gram is not symmetric".to_owned()) }
    }
}

impl From<Process> for Stored {
    fn from(p: Process) -> Self {
        Self {
            hyper: p.hyper,
            scale: p.scale,
            outputs: p.outputs,
            centres: p.centres,
            coefficients_rad_s: p.coefficients,
            gram: p.gram,
        }
    }
}

impl Process {
    /// An exact process on standardised `rows` (N x D) with targets of the joints `outputs` (N x p,
    /// rad/s); `None` when the kernel matrix is not positive definite.
    pub fn exact(
        hyper: GpHyper,
        scale: InputScale,
        rows: DMatrix<f64>,
        outputs: Vec<usize>,
        targets: &DMatrix<f64>,
    ) -> Option<Self> {
        let coefficients = noisy_kernel(&rows, &scale, &hyper)?.solve(targets);
        Some(Self::assemble(hyper, scale, outputs, rows, coefficients, None))
    }

    /// The same with inducing `centres` (standardised, M x D).
    pub fn inducing(
        hyper: GpHyper,
        scale: InputScale,
        rows: &DMatrix<f64>,
        outputs: Vec<usize>,
        targets: &DMatrix<f64>,
        centres: DMatrix<f64>,
    ) -> Option<Self> {
        let (gram, moment) = sums(&hyper, &scale, rows, targets, &centres);
        let z = reduced(&centres, &scale.reduction(&hyper));
        let a = inner_kernel(&z) + &gram;
        let coefficients = Factor::new(&a)?.solve(&moment);
        Some(Self::assemble(hyper, scale, outputs, centres, coefficients, Some(gram)))
    }

    fn assemble(
        hyper: GpHyper,
        scale: InputScale,
        outputs: Vec<usize>,
        centres: DMatrix<f64>,
        coefficients: DMatrix<f64>,
        gram: Option<DMatrix<f64>>,
    ) -> Self {
        let reduction = scale.reduction(&hyper);
        let panels = Panels::new(&centres, &reduction);
        let rows = row_major(&coefficients);
        Self { hyper, scale, reduction, outputs, centres, coefficients, gram, panels, rows }
    }

    /// The same process for other joints, as many as before.
    #[must_use]
    pub fn serving(mut self, outputs: Vec<usize>) -> Self {
        if outputs.len() == self.outputs.len() {
            self.outputs = outputs;
        }
        self
    }

    /// Kernel parameters.
    pub fn hyper(&self) -> &GpHyper {
        &self.hyper
    }

    /// Number of centres, M (of samples where it is exact).
    pub fn centre_count(&self) -> usize {
        self.centres.nrows()
    }

    /// Whether it rests on inducing centres.
    pub fn is_inducing(&self) -> bool {
        self.gram.is_some()
    }

    /// Numbers of postures and of task velocities among its inputs.
    pub(super) fn inputs(&self) -> (usize, usize) {
        (self.scale.posture_count, self.scale.mean.len() - self.scale.posture_count)
    }

    /// The joints whose velocity it predicts.
    pub fn outputs(&self) -> &[usize] {
        &self.outputs
    }

    /// Reduced input for a posture (n, rad) and a task velocity (m; m/s, rad/s).
    pub fn reduce(&self, q: &[f64], task_velocity: &[f64]) -> Vec<f64> {
        let mut x = Vec::with_capacity(q.len() + task_velocity.len());
        x.extend(
            q.iter()
                .chain(task_velocity)
                .zip(self.scale.mean.iter().zip(&self.scale.spread))
                .zip(&self.reduction)
                .map(|((v, (m, s)), r)| (v - m) / s * r),
        );
        x
    }

    /// Posterior mean of z for its joints at a reduced input, p, rad/s.
    pub fn mean(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.outputs.len()];
        self.panels.apply(x, &self.rows, &mut out);
        out
    }

    /// What variances and draws need; `None` when a kernel matrix is not positive definite.
    pub fn posterior(&self) -> Option<Posterior<'_>> {
        let z = reduced(&self.centres, &self.reduction);
        let factors = if let Some(gram) = &self.gram {
            let inner = inner_kernel(&z);
            Factors::Inducing(Factor::new(&inner)?, Factor::new(&(inner + gram))?)
        } else {
            Factors::Exact(noisy_kernel(&self.centres, &self.scale, &self.hyper)?)
        };
        Some(Posterior { process: self, z, factors })
    }

    /// Adds the value of a drawn function at a reduced input to `out` (p, rad/s).
    pub fn add_draw(&self, draw: &FunctionDraw, x: &[f64], out: &mut [f64]) {
        draw.add_prior(x, out);
        self.panels.apply(x, &draw.update, out);
    }
}

fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// Lower triangle of `K_zz`.
fn inner_kernel(z: &DMatrix<f64>) -> DMatrix<f64> {
    let mut k = lower_kernel(z);
    for i in 0..k.nrows() {
        k[(i, i)] += JITTER;
    }
    k
}

fn noisy_kernel(rows: &DMatrix<f64>, scale: &InputScale, hyper: &GpHyper) -> Option<Factor> {
    let x = reduced(rows, &scale.reduction(hyper));
    let mut k = lower_kernel(&x);
    for i in 0..k.nrows() {
        k[(i, i)] += hyper.noise_ratio;
    }
    Factor::new(&k)
}

#[derive(Debug, Clone)]
enum Factors {
    /// Of `K + rho I`.
    Exact(Factor),
    /// Of `K_zz` and of `A`.
    Inducing(Factor, Factor),
}

/// A process with the factors of its kernel matrices.
#[derive(Debug, Clone)]
pub struct Posterior<'a> {
    process: &'a Process,
    z: DMatrix<f64>,
    factors: Factors,
}

impl Posterior<'_> {
    /// v(x): the share of the prior variance that the data leave open, in [0, 1], at reduced inputs.
    pub fn open_shares(&self, inputs: &[Vec<f64>]) -> Vec<f64> {
        // Batches, so that no matrix grows with the number of inputs.
        const BATCH: usize = 512;
        if inputs.len() <= BATCH {
            return self.open_shares_at_once(inputs);
        }
        let batches: Vec<Vec<f64>> =
            inputs.par_chunks(BATCH).map(|batch| self.open_shares_at_once(batch)).collect();
        batches.concat()
    }

    fn open_shares_at_once(&self, inputs: &[Vec<f64>]) -> Vec<f64> {
        let count = self.process.centre_count();
        let mut k = DMatrix::zeros(count, inputs.len());
        for (mut column, x) in k.column_iter_mut().zip(inputs) {
            column.copy_from_slice(&self.process.panels.row(x));
        }
        let squares = |factor: &Factor| -> Vec<f64> {
            factor.solve_lower(&k).column_iter().map(|c| c.norm_squared()).collect()
        };
        let open: Vec<f64> = match &self.factors {
            Factors::Exact(factor) => squares(factor).iter().map(|s| 1.0 - s).collect(),
            Factors::Inducing(inner, outer) => squares(inner)
                .iter()
                .zip(squares(outer))
                .map(|(inner, outer)| 1.0 - inner + outer)
                .collect(),
        };
        open.into_iter().map(|o| o.clamp(0.0, 1.0)).collect()
    }

    /// Variance of an observation over the variance of the noise alone, `1 + v(x) / rho`.
    pub fn inflations(&self, inputs: &[Vec<f64>]) -> Vec<f64> {
        let ratio = self.process.hyper.noise_ratio;
        self.open_shares(inputs).into_iter().map(|o| 1.0 + o / ratio).collect()
    }

    /// One function of the posterior. `factor` is F, n x r, of all n joints.
    pub fn draw(&self, factor: &DMatrix<f64>, rng: &mut ChaCha8Rng) -> FunctionDraw {
        let p = self.process;
        let dimensions = p.panels.dimensions();
        let own = factor.select_rows(p.outputs.iter());
        let r = own.ncols();
        let signal = (1.0 / p.hyper.noise_ratio).sqrt();
        let frequencies = normals(rng, dimensions * FEATURES);
        let latent = DMatrix::from_vec(2 * FEATURES, r, normals(rng, 2 * FEATURES * r))
            * (signal / (FEATURES as f64).sqrt());
        let mut draw = FunctionDraw {
            frequencies,
            weights: row_major(&(&latent * own.transpose())),
            update: Vec::new(),
        };
        let count = self.z.nrows();
        let phi = draw.features(&self.z);
        let prior = product(&phi, &latent);
        let fresh = DMatrix::from_vec(count, r, normals(rng, count * r));
        let change = match &self.factors {
            Factors::Exact(factor) => -factor.solve(&(prior + fresh)),
            Factors::Inducing(inner, outer) => {
                outer.solve_lower_transposed(&(fresh * signal)) - inner.solve(&prior)
            }
        };
        draw.update = row_major(&(&p.coefficients + product(&change, &own.transpose())));
        draw
    }
}

/// One function of the posterior of a process.
#[derive(Debug, Clone)]
pub struct FunctionDraw {
    /// Input by input, FEATURES each.
    frequencies: Vec<f64>,
    /// Cosine weights, then sine weights, row by row of p.
    weights: Vec<f64>,
    /// In the place of the mean's coefficients, row by row.
    update: Vec<f64>,
}

impl FunctionDraw {
    /// Cosines and sines at a reduced input.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
    fn waves(&self, x: &[f64]) -> [f64; 2 * FEATURES] {
        let mut angle = [0.0; FEATURES];
        for (row, x) in self.frequencies.chunks_exact(FEATURES).zip(x) {
            for (a, f) in angle.iter_mut().zip(row) {
                *a = f.mul_add(*x, *a);
            }
        }
        let mut waves = [0.0; 2 * FEATURES];
        let (cosines, sines) = waves.split_at_mut(FEATURES);
        for ((a, c), s) in angle.iter().zip(cosines).zip(sines) {
            (*s, *c) = sin_cos(*a);
        }
        waves
    }

    fn add_prior(&self, x: &[f64], out: &mut [f64]) {
        let n = out.len();
        wide(
            #[inline(always)]
            || {
                let waves = self.waves(x);
                for (rows, w) in self.weights.chunks_exact(4 * n).zip(waves.chunks_exact(4)) {
                    let (a, b) = rows.split_at(2 * n);
                    let ((a, b), (c, d)) = (a.split_at(n), b.split_at(n));
                    let terms = a.iter().zip(b).zip(c.iter().zip(d));
                    for (o, ((a, b), (c, d))) in out.iter_mut().zip(terms) {
                        *o += w[0].mul_add(*a, w[1] * b) + w[2].mul_add(*c, w[3] * d);
                    }
                }
            },
        );
    }

    /// Features at reduced rows, N x 2 FEATURES.
    fn features(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(2 * FEATURES, rows.nrows());
        let mut x = vec![0.0; rows.ncols()];
        for (i, mut column) in out.column_iter_mut().enumerate() {
            x.iter_mut().zip(rows.row(i).iter()).for_each(|(x, v)| *x = *v);
            column.copy_from_slice(&wide(
                #[inline(always)]
                || self.waves(&x),
            ));
        }
        out.transpose()
    }
}

/// `z` of several processes that share out the joints, added to `out` (n, rad/s).
pub(super) fn add_means(
    processes: &[Process],
    q: &[f64],
    task_velocity: &[f64],
    out: &mut DVector<f64>,
) {
    for p in processes {
        let x = p.reduce(q, task_velocity);
        for (o, v) in p.outputs.iter().zip(p.mean(&x)) {
            out[*o] += v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use approx::assert_relative_eq;

    fn data(count: usize) -> (InputScale, DMatrix<f64>, DMatrix<f64>) {
        let mut rng = stream(3, Purpose::Simulation, 0, 0);
        let raw = DMatrix::from_vec(count, 6, normals(&mut rng, count * 6));
        let s = DMatrix::from_fn(count, 4, |i, j| (raw[(i, j)] + raw[(i, j + 1)]).sin());
        let (scale, rows) = InputScale::fit(&raw, 4);
        (scale, rows, s)
    }

    const HYPER: GpHyper = GpHyper { length_posture: 0.8, length_velocity: 1.5, noise_ratio: 0.2 };

    /// Means and open share at a reduced input by an explicit inverse.
    fn naive(
        scale: &InputScale,
        rows: &DMatrix<f64>,
        s: &DMatrix<f64>,
        x: &[f64],
    ) -> (Vec<f64>, f64) {
        let r = reduced(rows, &scale.reduction(&HYPER));
        let k = |a: &[f64], b: &[f64]| -> f64 {
            (-0.5 * a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>()).exp()
        };
        let row = |i: usize| r.row(i).iter().copied().collect::<Vec<f64>>();
        let n = rows.nrows();
        let gram = DMatrix::from_fn(n, n, |i, j| {
            k(&row(i), &row(j)) + if i == j { HYPER.noise_ratio } else { 0.0 }
        });
        let inverse = gram.try_inverse().unwrap();
        let cross = DVector::from_fn(n, |i, _| k(&row(i), x));
        let mean = (&inverse * s).tr_mul(&cross);
        (mean.as_slice().to_vec(), 1.0 - cross.dot(&(&inverse * &cross)))
    }

    #[test]
    fn equals_a_naive_posterior() {
        let (scale, rows, s) = data(29);
        let gp = Process::exact(HYPER, scale.clone(), rows.clone(), vec![0, 1, 2, 3], &s).unwrap();
        let x = gp.reduce(&[0.1, -0.3, 0.2, 0.5], &[0.4, -0.2]);
        let (mean, open) = naive(&scale, &rows, &s, &x);
        assert_relative_eq!(gp.mean(&x).as_slice(), mean.as_slice(), epsilon = 1e-10);
        assert_relative_eq!(gp.posterior().unwrap().open_shares(&[x])[0], open, epsilon = 1e-10);
        let text = serde_json::to_string(&gp).unwrap();
        assert_eq!(serde_json::from_str::<Process>(&text).unwrap(), gp);
    }

    #[test]
    fn inducing_centres_at_every_sample_are_exact() {
        let (scale, rows, s) = data(29);
        let outputs = vec![0, 1, 2, 3];
        let gp = Process::inducing(HYPER, scale.clone(), &rows, outputs, &s, rows.clone()).unwrap();
        let x = gp.reduce(&[0.1, -0.3, 0.2, 0.5], &[0.4, -0.2]);
        let (mean, open) = naive(&scale, &rows, &s, &x);
        assert_relative_eq!(gp.mean(&x).as_slice(), mean.as_slice(), epsilon = 1e-4);
        assert_relative_eq!(gp.posterior().unwrap().open_shares(&[x])[0], open, epsilon = 1e-4);
    }

    #[test]
    fn draws_have_the_posterior_mean_and_covariance() {
        const DRAWS: u32 = 3000;
        // At a sample, between samples, and far away; exact and inducing.
        let (scale, rows, s) = data(40);
        let outputs = vec![0, 1, 2, 3];
        let factor =
            DMatrix::from_fn(4, 2, |i, j| 0.1 * (1.0 + i as f64) * if j == 0 { 1.0 } else { -0.5 });
        let noise = &factor * factor.transpose();
        let exact =
            Process::exact(HYPER, scale.clone(), rows.clone(), outputs.clone(), &s).unwrap();
        let half = rows.rows(0, 20).into_owned();
        let inducing = Process::inducing(HYPER, scale, &rows, outputs, &s, half).unwrap();
        for gp in [exact, inducing] {
            let posterior = gp.posterior().unwrap();
            let at_sample: Vec<f64> =
                reduced(&gp.centres, &gp.reduction).row(5).iter().copied().collect();
            let near = gp.reduce(&[0.1, -0.3, 0.2, 0.5], &[0.4, -0.2]);
            let points = [at_sample, near, vec![30.0; 6]];
            let mut values = vec![Vec::new(); points.len()];
            for i in 0..DRAWS {
                let draw = posterior.draw(&factor, &mut stream(4, Purpose::Posture, 0, i));
                for (x, list) in points.iter().zip(&mut values) {
                    let mut out = vec![0.0; 4];
                    gp.add_draw(&draw, x, &mut out);
                    list.push(DVector::from_vec(out));
                }
            }
            for (x, list) in points.iter().zip(&values) {
                let mean = list.iter().fold(DVector::zeros(4), |a, b| a + b) / f64::from(DRAWS);
                let cov = list
                    .iter()
                    .fold(DMatrix::zeros(4, 4), |a, v| a + (v - &mean) * (v - &mean).transpose())
                    / f64::from(DRAWS);
                let expected = &noise
                    * (posterior.open_shares(std::slice::from_ref(x))[0] / HYPER.noise_ratio);
                let sd = (expected[(3, 3)] / f64::from(DRAWS)).sqrt();
                assert!((mean[3] - gp.mean(x)[3]).abs() < 4.0 * sd + 1e-9, "mean {mean}");
                let error = (&cov - &expected).norm() / expected.norm();
                assert!(error < 0.1, "covariance off by {error} at {x:?}");
            }
        }
    }
}

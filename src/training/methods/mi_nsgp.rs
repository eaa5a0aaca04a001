//! The paper's method in its exact and fast form: a diagonal W and a Gaussian process in the null
//! space, by marginal likelihood (n-component form).
//!
//! ```text
//! s_t(w) = qdot_t - J_W^+ xdot_t,  R = S diag(1/c),   R ~ N(0, v K),  K = k((q,xdot),.) + rho I
//! min   N k / 2 log(tr(R^T K^-1 R) / (N k)) + k / 2 log det K + priors      (v profiled out)
//! ```
//! `K` does not contain `w`: one factorisation serves a whole search over `w`, and the gradient is
//! that of the least squares with `K^-1 R` in the place of the residuals. Scales `c` are fixed before
//! `w` is searched. The likelihood counts k of n components. Consecutive frames are nearly copies, so
//! the noise ratio is at least 0.1: without that bound the process learns trials by heart.

use super::descent::{ValueAndGradient, descend, wander};
use super::diagonal::{Resolved, profiled, tidy};
use crate::training::dataset::{Frame, at_most};
use nalgebra::{DMatrix, DVector};

use crate::posture::{GpHyper, GpInputs, NullSpaceGp};

/// Smallest noise ratio.
const NOISE_RATIO_FLOOR: f64 = 0.1;
/// Median and standard deviation of the prior on the log noise ratio.
const NOISE_PRIOR: (f64, f64) = (0.1, 1.5);
/// Frames on which hyper-parameters are searched: each trial costs a factorisation.
const HYPER_SAMPLES: usize = 150;
const ALTERNATIONS: usize = 2;
const HYPER_ITERATIONS: u64 = 50;
/// Edge of the first simplex, in logarithms.
const FIRST_EDGE: f64 = 0.7;
const WEIGHT_ITERATIONS: u64 = 80;
/// Smallest scale of a component of the residuals, rad/s.
const SMALLEST_SCALE: f64 = 0.01;

/// Weights and process.
pub(super) struct MiNsGp {
    pub log_w: Vec<f64>,
    pub gp: NullSpaceGp,
}

/// Learns weights and process from at most `samples` of the frames, from weights of W-IK.
///
/// `None` where a kernel matrix or a posture is singular.
pub(super) fn learn(frames: &[&Frame], start: &[f64], samples: usize) -> Option<MiNsGp> {
    let frames = at_most(frames, samples);
    let few = at_most(&frames, HYPER_SAMPLES);
    let mut log_w = start.to_vec();
    let scales = scales(&residuals(&frames, &log_w)?);
    let (all_inputs, few_inputs) = (inputs(&frames), inputs(&few));
    let mut found = vec![0.0, 0.0, 0.0];
    for _ in 0..ALTERNATIONS {
        let targets = scaled(residuals(&few, &log_w)?, &scales);
        let of_hyper = |x: &[f64]| hyper_objective(&few_inputs, &targets, x);
        found = wander(&of_hyper, &found, FIRST_EDGE, HYPER_ITERATIONS).0;
        let inverse = all_inputs.kernel(&hyper(&found)).cholesky()?.inverse();
        let function = |x: &[f64]| weight_objective(&frames, &inverse, &scales, x);
        log_w = tidy(descend(&function, &log_w, WEIGHT_ITERATIONS).0);
    }
    let gp = process(&frames, &log_w, hyper(&found))?;
    Some(MiNsGp { log_w, gp })
}

/// The process for given weights and kernel parameters.
pub(super) fn process(frames: &[&Frame], log_w: &[f64], hyper: GpHyper) -> Option<NullSpaceGp> {
    inputs(frames).fit(hyper, &residuals(frames, log_w)?)
}

fn inputs(frames: &[&Frame]) -> GpInputs {
    let stack = |pick: fn(&Frame) -> &DVector<f64>| {
        DMatrix::from_rows(&frames.iter().map(|f| pick(f).transpose()).collect::<Vec<_>>())
    };
    GpInputs::new(&stack(|f| &f.q), &stack(|f| &f.xdot))
}

/// S, N x n, rad/s.
fn residuals(frames: &[&Frame], log_w: &[f64]) -> Option<DMatrix<f64>> {
    let weights: Vec<f64> = log_w.iter().map(|l| l.exp()).collect();
    let rows: Option<Vec<_>> = frames
        .iter()
        .map(|f| Some(Resolved::new(f, &weights)?.residual(f, &weights).transpose()))
        .collect();
    Some(DMatrix::from_rows(&rows?))
}

fn scales(targets: &DMatrix<f64>) -> Vec<f64> {
    let rms = |c: nalgebra::DVectorView<f64>| (c.norm_squared() / c.len() as f64).sqrt();
    targets.column_iter().map(|c| rms(c.as_view()).max(SMALLEST_SCALE)).collect()
}

fn scaled(mut targets: DMatrix<f64>, scales: &[f64]) -> DMatrix<f64> {
    for (mut column, scale) in targets.column_iter_mut().zip(scales) {
        column /= *scale;
    }
    targets
}

/// Kernel parameters from three unbounded numbers.
fn hyper(x: &[f64]) -> GpHyper {
    // Beyond these bounds a length-scale is zero or infinity for any data.
    let length = |v: f64| v.clamp(-4.0, 4.0).exp();
    GpHyper {
        length_posture: length(x[0]),
        length_velocity: length(x[1]),
        noise_ratio: NOISE_RATIO_FLOOR + x[2].clamp(-12.0, 6.0).exp(),
    }
}

/// Negative log marginal likelihood of the kernel parameters with their priors, nats.
fn hyper_objective(inputs: &GpInputs, targets: &DMatrix<f64>, x: &[f64]) -> f64 {
    let (count, n) = targets.shape();
    let k = (n - 6) as f64;
    let hyper = hyper(x);
    let Some(factor) = inputs.kernel(&hyper).cholesky() else { return f64::INFINITY };
    let log_det: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let quadratic = factor.solve(targets).dot(targets).max(f64::MIN_POSITIVE);
    let terms = count as f64 * k;
    let ratio = (hyper.noise_ratio / NOISE_PRIOR.0).ln() / NOISE_PRIOR.1;
    let prior = 0.5 * (x[0] * x[0] + x[1] * x[1] + ratio * ratio);
    0.5 * terms * (quadratic / terms).ln() + 0.5 * k * log_det + prior
}

/// Negative log marginal likelihood of the weights with their prior, without constants, nats.
fn weight_objective(
    frames: &[&Frame],
    inverse: &DMatrix<f64>,
    scales: &[f64],
    log_w: &[f64],
) -> ValueAndGradient {
    let weights: Vec<f64> = log_w.iter().map(|l| l.exp()).collect();
    let mut gradient = vec![0.0; log_w.len()];
    let resolved: Option<Vec<Resolved>> =
        frames.iter().map(|f| Resolved::new(f, &weights)).collect();
    let Some(resolved) = resolved else { return (f64::INFINITY, gradient) };
    let rows: Vec<_> =
        frames.iter().zip(&resolved).map(|(f, r)| r.residual(f, &weights).transpose()).collect();
    let targets = scaled(DMatrix::from_rows(&rows), scales);
    let alpha = inverse * &targets;
    let quadratic = alpha.dot(&targets);
    for (t, (frame, r)) in frames.iter().zip(&resolved).enumerate() {
        let c = DVector::from_fn(scales.len(), |i, _| alpha[(t, i)] / scales[i]);
        r.add_gradient(frame, &weights, &c, &mut gradient);
    }
    profiled(quadratic, frames.len(), log_w, gradient)
}

#[cfg(test)]
mod tests {
    use super::super::diagonal::least_squares;
    use super::super::diagonal::tests::{gradient_error, planted, rms_difference};
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    /// A smooth preferred velocity with a little noise.
    fn smooth(frame: &Frame, draw: &[f64]) -> DVector<f64> {
        DVector::from_fn(24, |i, _| {
            let from = (7 * i + 3) % 24;
            0.5 * (3.0 * frame.q[from] + i as f64).sin() + 0.02 * draw[i]
        })
    }

    #[test]
    fn gradient_agrees_with_finite_differences() {
        let (data, _) = planted(smooth);
        let frames: Vec<&Frame> = data.frames.iter().step_by(9).collect();
        let mut rng = stream(3, Purpose::Simulation, 0, 0);
        let x: Vec<f64> = normals(&mut rng, 24).iter().map(|v| 0.5 * v).collect();
        let scales = scales(&residuals(&frames, &x).unwrap());
        let hyper = GpHyper { length_posture: 0.7, length_velocity: 1.5, noise_ratio: 0.15 };
        let inverse = inputs(&frames).kernel(&hyper).cholesky().unwrap().inverse();
        let error = gradient_error(|x| weight_objective(&frames, &inverse, &scales, x), &x);
        assert!(error < 1e-6, "{error}");
    }

    #[test]
    fn planted_weights_are_found_where_least_squares_is_misled() {
        let (data, truth) = planted(smooth);
        let frames: Vec<&Frame> = data.frames.iter().filter(|f| f.is_sparse).collect();
        let start = least_squares(&frames, &DMatrix::identity(24, 24), None);
        let found = learn(&frames, &start, 400).unwrap();
        let (own, simple) = (rms_difference(&found.log_w, &truth), rms_difference(&start, &truth));
        assert!(own < 0.3 && own < 0.5 * simple, "mi-nsgp {own}, w-ik {simple}");
    }
}

//! The two functions that training evaluates again and again, for the benches.

use super::hyper::HyperProblem;
use super::objective::divided;
use super::process::{Identified, Inputs, null_targets, scales, weight_problem};
use super::samples::Samples;
use crate::posture::GpHyper;
use crate::training::dataset::{Frame, block_numbers};
use crate::training::settings::TrainSettings;

/// Kernel parameters of the order that people have.
const HYPER: GpHyper = GpHyper { length_posture: 1.0, length_velocity: 1.5, noise_ratio: 0.2 };

/// Value (nats) and gradient at a point.
type Function<'a> = &'a dyn Fn(&[f64]) -> (f64, Vec<f64>);

/// Hands the marginal likelihood of the kernel parameters of `frames`, under W = I, and a point of it
/// to `run`; `None` where a posture is singular.
#[doc(hidden)]
pub fn with_kernel_search<R>(
    frames: &[&Frame],
    settings: &TrainSettings,
    run: impl FnOnce(Function, &[f64]) -> R,
) -> Option<R> {
    let n = frames.first()?.qdot.len();
    let m = frames.first()?.xdot.len();
    let targets = null_targets(frames, &vec![0.0; n])?;
    let inputs = Inputs::new(frames);
    let problem = HyperProblem {
        scale: &inputs.scale,
        rows: &inputs.rows,
        targets: &divided(targets.clone(), &scales(&targets)),
        free_share: (n - m) as f64 / n as f64,
        floor: settings.noise_ratio_floor,
        lengths: settings.lengths,
        objective: settings.objective_for(1),
        blocks: &block_numbers(frames),
        temper: 1.0,
    };
    Some(run(&|x| problem.at(x), &problem.point(&HYPER)))
}

/// The same for the objective of the weights, at W = I.
#[doc(hidden)]
pub fn with_weight_search<R>(
    frames: &[&Frame],
    settings: &TrainSettings,
    run: impl FnOnce(Function, &[f64]) -> R,
) -> Option<R> {
    let samples = Samples::new(frames);
    let found = Identified { log_w: vec![0.0; samples.n], hyper: HYPER };
    let problem = weight_problem(&samples, frames, &found, settings, 1.0)?;
    Some(run(&|x| problem.at(x), &found.log_w))
}

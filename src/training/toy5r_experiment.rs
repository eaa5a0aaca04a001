//! The paper's toy experiment: all methods on repeated 5R problems, with the objectives side by side.
//!
//! Each repeat has its own start posture, weights and noise ([`toy5r::generate`](super::toy5r)); 70 % of
//! the rows train. The null-space processes use all n components of `qdot - J_W^+ xdot`.

use super::dataset::{DataRow, Dataset, Fold};
use super::evaluate::{GroupScore, Judging, evaluate};
use super::methods::objective_at;
use super::settings::{Lengths, Objective, TrainSettings};
use super::toy5r::{BASE, TIP, ToyConstants, ToyProblem, generate, planar_urdf};
use crate::files::InputError;
use crate::kinematics::{Linkage, parse_urdf};
use crate::posture::{Coupling, Hold, Method};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// One way to learn, as a line of the table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ToyMethod {
    /// Name in tables and figures.
    pub label: String,
    /// The method.
    #[serde(skip)]
    pub method: Method,
    /// What the search for weights maximises.
    #[serde(skip)]
    pub objective: Objective,
    /// Whether the search is the published one.
    #[serde(skip)]
    pub is_published: bool,
}

/// What one line achieved on one repeat.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToyScore {
    /// Seed of the repeat.
    pub seed: u64,
    /// Mean log-likelihood of the joint velocity, nats.
    pub ll_q: f64,
    /// RMSE of the joint velocity, rad/s.
    pub rmse_q: f64,
    /// Mean log-likelihood of the task velocity, nats.
    pub ll_x: f64,
    /// RMSE of the task velocity, m/s.
    pub rmse_x: f64,
    /// Rms over joints of log w about that of the truth, both centred; of methods with weights.
    pub weight_error: Option<f64>,
    /// Time of the training, s.
    pub train_s: f64,
}

/// The published objective at the weights that it found and at the true ones, nats per row (kernel
/// parameters fitted anew to each).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InSampleCheck {
    /// At the found weights.
    pub found: f64,
    /// At the true weights.
    pub truth: f64,
}

/// All lines of one setting.
#[derive(Debug, Clone, Serialize)]
pub struct ToyResult {
    /// The constants.
    pub constants: ToyConstants,
    /// The lines: the paper's six in its order, then ours and the other objectives.
    pub methods: Vec<ToyMethod>,
    /// Scores, line by line, one for each repeat.
    pub scores: Vec<Vec<ToyScore>>,
    /// The in-sample objective, one for each repeat.
    pub in_sample: Vec<InSampleCheck>,
    /// Rms of the centred true log weights of each repeat: the weight error of W = I.
    pub identity_error: Vec<f64>,
}

/// The lines of the experiment; with `is_published` also the paper's search as it was published:
/// in-sample objective, BIPOP-CMA-ES, kernel parameters fitted anew to each weight, one length-scale.
pub fn toy_methods(is_published: bool) -> Vec<ToyMethod> {
    let line = |label: &str, method, objective| ToyMethod {
        label: label.to_owned(),
        method,
        objective,
        is_published: false,
    };
    let ours = Objective::Marginal;
    let mut lines = vec![
        line("GP", Method::Gp, ours),
        line("W-IK", Method::WIk, ours),
        line("Sb-M", Method::SbM, ours),
        line("NsGP", Method::Nsgp, ours),
        line("ProMP", Method::Promp, ours),
        line("MI-NsGP", Method::MiNsgp, ours),
        line("MI in-sample", Method::MiNsgp, Objective::InSample),
        line("MI leave-one-out", Method::MiNsgp, Objective::LeaveOneOut),
        line("full-W", Method::FullW, ours),
        line("full-W GP", Method::FullWGp, ours),
    ];
    if is_published {
        let own = line("MI as published", Method::MiNsgp, Objective::InSample);
        lines.insert(7, ToyMethod { is_published: true, ..own });
    }
    lines
}

/// The data set of a 5R problem and its split.
///
/// # Errors
/// Where the constants make no chain.
pub fn toy_dataset(problem: &ToyProblem) -> Result<(Dataset, Fold), InputError> {
    let model = parse_urdf(Path::new("5R"), &planar_urdf(&problem.constants))?;
    let chain =
        Linkage::chain(&model, BASE, TIP).map_err(|e| InputError::new("5R", e.to_string()))?;
    let rows: Vec<DataRow> = (0..problem.q.len())
        .map(|i| DataRow {
            q: problem.q[i].to_vec(),
            xdot: problem.xdot[i].to_vec(),
            qdot: problem.qdot[i].to_vec(),
            trial: 0,
            time_s: i as f64 * problem.constants.dt_s,
        })
        .collect();
    let dataset = Dataset::of_rows("5R", &rows, Coupling::of_chain(chain, Hold::Planar))?;
    let pick =
        |wanted: bool| (0..rows.len()).filter(|&i| problem.train[i] == wanted).collect::<Vec<_>>();
    Ok((dataset, Fold { train: pick(true), test: pick(false) }))
}

/// Runs all lines on `repeats` problems (seeds 0, 1, ...). `tell` hears how many repeats are done and
/// returns false to stop; then nothing is returned.
///
/// # Errors
/// Where the constants are out of range or a problem is singular.
pub fn run_toy(
    constants: &ToyConstants,
    repeats: u64,
    methods: &[ToyMethod],
    tell: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Option<ToyResult>, InputError> {
    constants.check()?;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let all: Result<Vec<Option<Repeat>>, InputError> = (0..repeats)
        .into_par_iter()
        .map(|seed| {
            if !tell(done.load(std::sync::atomic::Ordering::Relaxed)) {
                return Ok(None);
            }
            let found = repeat(seed, constants, methods)?;
            done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Ok(Some(found))
        })
        .collect();
    let Some(all) = all?.into_iter().collect::<Option<Vec<Repeat>>>() else { return Ok(None) };
    let scores =
        (0..methods.len()).map(|m| all.iter().map(|r| r.scores[m].clone()).collect()).collect();
    Ok(Some(ToyResult {
        constants: constants.clone(),
        methods: methods.to_vec(),
        scores,
        in_sample: all.iter().filter_map(|r| r.in_sample).collect(),
        identity_error: all.iter().map(|r| r.identity_error).collect(),
    }))
}

struct Repeat {
    scores: Vec<ToyScore>,
    in_sample: Option<InSampleCheck>,
    identity_error: f64,
}

fn repeat(
    seed: u64,
    constants: &ToyConstants,
    methods: &[ToyMethod],
) -> Result<Repeat, InputError> {
    let problem = generate(seed, constants)?;
    let (dataset, fold) = toy_dataset(&problem)?;
    let truth: Vec<f64> = problem.w_true.iter().map(|w| w.ln()).collect();
    let mut repeat = Repeat {
        scores: Vec::new(),
        in_sample: None,
        identity_error: weight_error(&[1.0; 5], &truth),
    };
    for line in methods {
        let settings = TrainSettings {
            objective: Some(line.objective),
            refits_kernel: line.is_published,
            lengths: if line.is_published { Lengths::Isotropic } else { Lengths::Groups },
            // The published pipeline bounds no noise.
            noise_ratio_floor: if line.objective == Objective::InSample { 1e-4 } else { 0.1 },
            seed,
            ..TrainSettings::default()
        };
        let judging = Judging {
            methods: vec![line.method],
            task_sd: Some(constants.sigma_xdot_m_s),
            has_rollouts: false,
        };
        let found = evaluate(&dataset, std::slice::from_ref(&fold), &judging, &settings)?;
        let Some(score) = found.methods.into_iter().next() else { continue };
        let median = |pick: fn(&GroupScore) -> f64| score.spread(pick).median;
        let weights = score.weights.first();
        if line.label == "MI in-sample" {
            let train = dataset.select(&fold.train);
            let value = |log_w: &[f64]| objective_at(&train, log_w, &settings);
            let own: Option<Vec<f64>> = weights.map(|w| w.iter().map(|w| w.ln()).collect());
            repeat.in_sample = own
                .and_then(|own| Some(InSampleCheck { found: value(&own)?, truth: value(&truth)? }));
        }
        repeat.scores.push(ToyScore {
            seed,
            ll_q: median(|g| g.ll_q),
            rmse_q: median(|g| g.rmse_q),
            ll_x: median(|g| g.ll_x),
            rmse_x: median(|g| g.rmse_x),
            weight_error: weights.map(|w| weight_error(w, &truth)),
            train_s: score.train_s,
        });
    }
    Ok(repeat)
}

/// Rms over joints of log w about that of the truth, both centred.
fn weight_error(weights: &[f64], log_truth: &[f64]) -> f64 {
    let n = weights.len() as f64;
    let difference: Vec<f64> =
        weights.iter().zip(log_truth).map(|(w, t)| w.max(1e-300).ln() - t).collect();
    let mean = difference.iter().sum::<f64>() / n;
    (difference.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marginal_likelihood_finds_the_weights_and_predicts_best() {
        let constants = ToyConstants { samples: 400, ..ToyConstants::default() };
        let methods: Vec<ToyMethod> =
            toy_methods(false).into_iter().filter(|m| m.label != "MI leave-one-out").collect();
        let found = run_toy(&constants, 1, &methods, &|_| true).unwrap().unwrap();
        let of = |label: &str| {
            let i = found.methods.iter().position(|m| m.label == label).unwrap();
            found.scores[i][0].clone()
        };
        let own = of("MI-NsGP");
        assert!(own.weight_error.unwrap() < 0.15, "{:?}", own.weight_error);
        for other in ["GP", "W-IK", "Sb-M", "NsGP", "ProMP"] {
            let other = of(other);
            assert!(own.ll_q > other.ll_q && own.rmse_q < other.rmse_q, "{other:?}");
        }
        assert!(own.rmse_x < 1e-9);
        // The published objective prefers its own weights to the true ones.
        assert!(found.in_sample[0].found > found.in_sample[0].truth);
        assert!(run_toy(&constants, 2, &methods, &|_| false).unwrap().is_none());
    }
}

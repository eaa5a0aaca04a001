//! How well each method predicts movement that it has not seen.
//!
//! ```text
//! LL_q     mean log N(qdot; mu, S), natural log, all n joints, in (rad/s)       S as in the law
//! RMSE_q   sqrt(mean over rows and joints of (qdot - mu)^2), rad/s; relative: over the rms of qdot
//! LL_x     the same of the task velocity: log N(xdot; J mu, J S J^T);  RMSE_x of J mu
//! LL_null  mean log N(V^T qdot; V^T mu, V^T S V): LL_q without the part that S_x decides
//! ```
//! The noise of each law is that of residuals within the training part, each from a law that had not
//! seen its block. `S_x` is given, or the variance of the training residual `xdot - J qdot` with a floor of
//! (1e-4)^2 (m/s, rad/s). Likelihoods depend on `S_x` and on the floor of the null directions.

use super::dataset::{Dataset, Fold, Frame};
use super::methods::{Law, WeightUncertainty, learn_laws, singular, weight_uncertainty};
use super::noise_fit::learn_noise;
use super::rollout_check::{RolloutScore, TrialWalk, check_rollouts};
use super::settings::TrainSettings;
use super::spread::unseen_residuals;
use crate::files::InputError;
use crate::math::redundancy::null_space_basis;
use crate::math::stats::quantile;
use crate::posture::{Floors, Method, Prediction};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// Smallest standard deviation of the task velocity, m/s and rad/s.
pub(super) const TASK_FLOOR: f64 = 1e-4;

/// What is judged, and how.
#[derive(Debug, Clone)]
pub struct Judging {
    /// The methods.
    pub methods: Vec<Method>,
    /// Standard deviation of every row of the task velocity, m/s and rad/s; by default from the data.
    pub task_sd: Option<f64>,
    /// Whether to walk along held-out paths as well.
    pub has_rollouts: bool,
}

/// Median and 5th to 95th percentile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percentiles {
    /// Median.
    pub median: f64,
    /// 5th percentile.
    pub p05: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl Percentiles {
    /// Of some values; NaN where there are none.
    pub fn of(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self { median: f64::NAN, p05: f64::NAN, p95: f64::NAN };
        }
        let at = |p| quantile(values, p);
        Self { median: at(0.5), p05: at(0.05), p95: at(0.95) }
    }
}

/// Figures of one method on one group of held-out rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupScore {
    /// Index of the trial that they are of.
    pub trial: usize,
    /// Number of rows.
    pub rows: usize,
    /// Mean log-likelihood of the joint velocity, nats.
    pub ll_q: f64,
    /// The same within the null space, nats.
    pub ll_null: f64,
    /// RMSE of the joint velocity, rad/s.
    pub rmse_q: f64,
    /// RMSE over the rms of the joint velocity.
    pub relative_rmse_q: f64,
    /// Mean log-likelihood of the task velocity, nats.
    pub ll_x: f64,
    /// RMSE of the task velocity, m/s and rad/s.
    pub rmse_x: f64,
    /// The walk along it, where one was asked for.
    pub walk: Option<TrialWalk>,
}

/// What one method achieved.
#[derive(Debug, Clone)]
pub struct MethodScore {
    /// The method.
    pub method: Method,
    /// One entry for each held-out trajectory of each split.
    pub groups: Vec<GroupScore>,
    /// Diagonal of W scaled to mean 1, of each split.
    pub weights: Vec<Vec<f64>>,
    /// How well the data determine them, of each split.
    pub uncertainty: Vec<WeightUncertainty>,
    /// Rollouts along held-out paths, of each split.
    pub rollouts: Vec<RolloutScore>,
    /// Time of the training and of one prediction (mean and covariance), s.
    pub train_s: f64,
    /// Time of one prediction, s.
    pub predict_s: f64,
    /// What has to be said with the figures.
    pub note: Option<String>,
}

impl MethodScore {
    /// Percentiles of one figure over groups.
    pub fn spread(&self, pick: impl Fn(&GroupScore) -> f64) -> Percentiles {
        Percentiles::of(&self.groups.iter().map(pick).collect::<Vec<_>>())
    }
}

/// The judgement of all methods.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// In the order asked for.
    pub methods: Vec<MethodScore>,
    /// Standard deviation of each row of the task velocity, of the first split.
    pub task_sd: Vec<f64>,
    /// Standard deviation claimed at least in every null direction, rad/s.
    pub null_floor_rad_s: f64,
}

/// Judges methods on the test parts of `folds`, each learned on the training part.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn evaluate(
    dataset: &Dataset,
    folds: &[Fold],
    judging: &Judging,
    settings: &TrainSettings,
) -> Result<Evaluation, InputError> {
    let mut scores: Vec<MethodScore> = judging.methods.iter().map(|&m| empty(m)).collect();
    let mut task_sd = Vec::new();
    for fold in folds {
        let floors = floors(dataset, fold, judging, settings);
        if task_sd.is_empty() {
            task_sd = floors.task.iter().map(|v| v.sqrt()).collect();
        }
        for score in &mut scores {
            judge(dataset, fold, score, judging, settings, &floors)?;
        }
    }
    for score in &mut scores {
        score.train_s /= folds.len().max(1) as f64;
        score.predict_s /= folds.len().max(1) as f64;
    }
    Ok(Evaluation { methods: scores, task_sd, null_floor_rad_s: settings.null_floor_rad_s })
}

fn empty(method: Method) -> MethodScore {
    MethodScore {
        method,
        groups: Vec::new(),
        weights: Vec::new(),
        uncertainty: Vec::new(),
        rollouts: Vec::new(),
        train_s: 0.0,
        predict_s: 0.0,
        note: None,
    }
}

fn floors(dataset: &Dataset, fold: &Fold, judging: &Judging, settings: &TrainSettings) -> Floors {
    let m = dataset.task_rows();
    let task = if let Some(sd) = judging.task_sd {
        DVector::from_element(m, sd * sd)
    } else {
        let mut sum = DVector::zeros(m);
        for f in dataset.select(&fold.train) {
            let left = &f.xdot - &f.jacobian * &f.qdot;
            sum += left.component_mul(&left);
        }
        (sum / fold.train.len() as f64).map(|v: f64| v.max(TASK_FLOOR * TASK_FLOOR))
    };
    Floors { task, null_rad_s: settings.null_floor_rad_s }
}

fn judge(
    dataset: &Dataset,
    fold: &Fold,
    score: &mut MethodScore,
    judging: &Judging,
    settings: &TrainSettings,
    floors: &Floors,
) -> Result<(), InputError> {
    let own =
        if score.method == Method::Promp { whole_demonstrations(dataset, fold) } else { None };
    if own.is_some() {
        score.note = Some(
            "rows of a single trajectory train and test in turn: promp is judged on whole stretches \
             of it, which are other rows"
                .to_owned(),
        );
    }
    let fold = own.as_ref().unwrap_or(fold);
    let train = dataset.select(&fold.train);
    let test = dataset.select(&fold.test);
    let begun = Instant::now();
    let stature_m = dataset.coupling.stature_m();
    let mut laws = learn_laws(&[score.method], &train, stature_m, settings, None)?;
    let inner = dataset.blocks_of(&fold.train);
    let unseen = unseen_residuals(dataset, &inner, &laws, settings, false)?;
    let Some(mut law) = laws.pop() else { return Ok(()) };
    law.law.noise = learn_noise(&law.law, &unseen[0], (false, None));
    score.train_s += begun.elapsed().as_secs_f64();

    let begun = Instant::now();
    let predictions = predictions(dataset, &test, &law, floors)?;
    score.predict_s += begun.elapsed().as_secs_f64() / test.len().max(1) as f64;

    let walks = if judging.has_rollouts {
        let (whole, trials) = check_rollouts(dataset, fold, &law, settings, floors)?;
        score.rollouts.push(whole);
        trials
    } else {
        BTreeMap::new()
    };
    let trials: BTreeSet<usize> = test.iter().map(|f| f.trial).collect();
    for trial in trials {
        let rows = test.iter().copied().zip(&predictions).filter(|(f, _)| f.trial == trial);
        let walk = walks.get(&trial).copied();
        score.groups.push(GroupScore { trial, walk, ..group(rows.collect(), floors) });
    }
    if score.method.identifies_weights() {
        score.weights.push(law.diagonal());
        if matches!(score.method, Method::MiNsgp | Method::WIk) {
            score.uncertainty.extend(weight_uncertainty(&law, &train, settings));
        }
    }
    Ok(())
}

/// What a law (with its noise) predicts of frames, one by one.
///
/// # Errors
/// Where the chain is singular there.
pub(super) fn predictions(
    dataset: &Dataset,
    frames: &[&Frame],
    law: &Law,
    floors: &Floors,
) -> Result<Vec<Prediction>, InputError> {
    let posteriors = law.law.posteriors().ok_or_else(singular)?;
    let queries: Vec<_> = frames.iter().map(|f| f.query()).collect();
    let growth = law.law.growth(&posteriors, &queries);
    let still = DVector::zeros(dataset.joints.len());
    let all: Option<Vec<Prediction>> = queries
        .iter()
        .zip(&growth)
        .map(|(q, growth)| law.law.predict(q, &still, growth, floors))
        .collect();
    all.ok_or_else(singular)
}

/// A split into whole demonstrations where the given one cuts them to pieces.
fn whole_demonstrations(dataset: &Dataset, fold: &Fold) -> Option<Fold> {
    let of = |i: &usize| dataset.frames[*i].demonstration;
    let test: BTreeSet<usize> = fold.test.iter().map(of).collect();
    let mixed = fold.train.iter().filter(|i| test.contains(&of(i))).count();
    if mixed * 4 < fold.train.len() {
        return None;
    }
    let mut rows: Vec<usize> = fold.train.iter().chain(&fold.test).copied().collect();
    rows.sort_unstable();
    let mut order: Vec<usize> = rows.iter().map(of).collect();
    order.dedup();
    // Seven of ten train.
    let tests = |i: &usize| {
        order.iter().position(|d| *d == of(i)).is_some_and(|p| matches!(p % 10, 2 | 5 | 8))
    };
    let (test, train) = rows.into_iter().partition(tests);
    Some(Fold { train, test })
}

pub(super) fn group(rows: Vec<(&Frame, &Prediction)>, floors: &Floors) -> GroupScore {
    let mut sum = GroupScore { rows: rows.len(), ..GroupScore::default() };
    let (mut size, mut n, mut m) = (0.0, 0, 0);
    for (frame, p) in rows {
        (n, m) = (frame.q.len(), frame.xdot.len());
        let residual = &frame.qdot - &p.mean;
        sum.ll_q += log_normal(&residual, p.covariance.clone());
        let v = null_space_basis(&frame.jacobian);
        sum.ll_null += log_normal(&v.tr_mul(&residual), v.tr_mul(&(&p.covariance * &v)));
        sum.rmse_q += residual.norm_squared();
        size += frame.qdot.norm_squared();
        let missed = &frame.xdot - &frame.jacobian * &p.mean;
        sum.rmse_x += missed.norm_squared();
        let mut covariance = &frame.jacobian * &p.covariance * frame.jacobian.transpose();
        // Rounding only: J J_W^+ = I.
        covariance += DMatrix::from_diagonal(&(&floors.task * 1e-12));
        sum.ll_x += log_normal(&missed, covariance);
    }
    let count = sum.rows.max(1) as f64;
    GroupScore {
        rows: sum.rows,
        ll_q: sum.ll_q / count,
        ll_null: sum.ll_null / count,
        relative_rmse_q: (sum.rmse_q / size.max(f64::MIN_POSITIVE)).sqrt(),
        rmse_q: (sum.rmse_q / (count * n.max(1) as f64)).sqrt(),
        ll_x: sum.ll_x / count,
        rmse_x: (sum.rmse_x / (count * m.max(1) as f64)).sqrt(),
        ..sum
    }
}

/// log N(y; 0, S), nats; NaN where S is not positive definite.
pub(super) fn log_normal(y: &DVector<f64>, covariance: DMatrix<f64>) -> f64 {
    let Some(factor) = covariance.cholesky() else { return f64::NAN };
    let log_det = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let constant = y.len() as f64 * (2.0 * std::f64::consts::PI).ln();
    -0.5 * (factor.solve(y).dot(y) + log_det + constant)
}

/// Learns one method on the training part, with its noise.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn learn_with_noise(
    dataset: &Dataset,
    train: &[usize],
    method: Method,
    settings: &TrainSettings,
    is_pulled: bool,
) -> Result<Law, InputError> {
    let frames = dataset.select(train);
    let stature_m = dataset.coupling.stature_m();
    let laws = learn_laws(&[method], &frames, stature_m, settings, None)?;
    let inner = dataset.blocks_of(train);
    let unseen = unseen_residuals(dataset, &inner, &laws, settings, is_pulled)?;
    let mut law = laws.into_iter().next().ok_or_else(singular)?;
    law.law.noise = learn_noise(&law.law, &unseen[0], (false, None));
    Ok(law)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;
    use approx::assert_relative_eq;

    fn judging(methods: &[Method]) -> Judging {
        Judging { methods: methods.to_vec(), task_sd: None, has_rollouts: false }
    }

    #[test]
    fn likelihood_splits_into_null_space_and_task() {
        // log N(r; 0, V S V^T + J^+ S_x J^+^T) = log N(y; 0, S) + 1/2 log det(J J^T) + log N(0; 0, S_x)
        let data = made_up(1, 3.0, 30.0);
        let frame = &data.frames[10];
        let a = DMatrix::from_fn(24, 24, |i, j| 0.1 * ((i * 5 + j * 3) as f64).sin());
        let spread = &a * a.transpose() + DMatrix::identity(24, 24) * 0.02;
        let v = null_space_basis(&frame.jacobian);
        let residual = &v * DVector::from_fn(18, |i, _| 0.2 * (i as f64).cos());
        let inside = v.tr_mul(&(&spread * &v));
        let pinv = frame.jacobian.clone().pseudo_inverse(1e-12).unwrap();
        let full = &v * &inside * v.transpose() + &pinv * pinv.transpose() * 1e-8;
        let jjt = &frame.jacobian * frame.jacobian.transpose();
        let task = log_normal(&DVector::zeros(6), DMatrix::identity(6, 6) * 1e-8);
        let split =
            log_normal(&v.tr_mul(&residual), inside.clone()) + 0.5 * jjt.determinant().ln() + task;
        assert_relative_eq!(log_normal(&residual, full.clone()), split, epsilon = 1e-4);
        // With a mismatch J r = d the left side gains log N(d; 0, S_x) - log N(0; 0, S_x).
        let d = DVector::from_element(6, 2e-4);
        let off = &residual + &pinv * &d;
        let gain = log_normal(&d, DMatrix::identity(6, 6) * 1e-8) - task;
        assert_relative_eq!(log_normal(&off, full), split + gain, epsilon = 1e-3);
    }

    #[test]
    fn a_law_that_made_the_data_is_judged_best() {
        // Velocities by a full W of rank two: only a full W can follow them.
        let mut data = made_up(2, 4.0, 30.0);
        for f in &mut data.frames {
            let t = f.time_s;
            let pattern = |i: usize, j: usize| ((i * (j + 3)) as f64).sin();
            f.qdot = DVector::from_fn(24, |i, _| {
                pattern(i, 1) * (2.0 * t).sin() + pattern(i, 2) * (3.0 * t).cos()
            });
            f.xdot = &f.jacobian * &f.qdot;
        }
        let methods = [Method::PlainIk, Method::WIk, Method::FullW];
        let settings = TrainSettings::default();
        let found = evaluate(&data, &data.held_out(), &judging(&methods), &settings).unwrap();
        let of = |i: usize| found.methods[i].spread(|g| g.relative_rmse_q).median;
        assert!(of(2) < 0.35, "{}", of(2));
        assert!(of(2) < 0.6 * of(0).min(of(1)));
        assert!(found.methods[2].spread(|g| g.rmse_x).p95 < 1e-9);
    }
}

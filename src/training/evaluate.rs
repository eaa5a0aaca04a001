//! How well each method predicts movement that it has not seen.
//!
//! ```text
//! relative RMSE  sqrt(mean |qdot - mean|^2) / sqrt(mean |qdot|^2)
//! LL_null        mean log N(V^T (qdot - mean); 0, V^T C V + (0.01 rad/s)^2 I)
//! LL_q           LL_null + 1/2 log det(J J^T) + log N(0; 0, S_x),   S_x = (1e-4)^2 I (m/s, rad/s)
//! path error     mean over time of the rms over joints of q_rollout - q_recorded, deg
//! ```
//! `C` is the full covariance of residuals within the training part, each from a law that had not
//! seen its block. The path is the held-out hand path, followed in closed loop from the person's own
//! first posture without noise. Figures of several folds are averaged.

use super::dataset::{Dataset, Fold, Frame, runs};
use super::methods::{Law, learn_laws};
use super::settings::TrainSettings;
use super::spread::{covariance, learn_attraction, unseen_residuals};
use super::train::bare_model;
use crate::files::InputError;
use crate::math::Pose;
use crate::math::redundancy::null_space_basis;
use crate::posture::{Attraction, HandPath, Method, MethodQuality, Start, roll_out};
use nalgebra::{DMatrix, DVector};

/// Floor of the residual standard deviation in every null direction, rad/s.
const NULL_FLOOR_RAD_S: f64 = 0.01;
/// Standard deviation of the task velocity in `LL_q`, m/s and rad/s.
const TASK_SD: f64 = 1e-4;

/// Figures of one method, summed over folds.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    relative: f64,
    square: f64,
    null: f64,
    all: f64,
    free: f64,
    pulled: f64,
}

/// Judges all methods on the test parts of `folds`, each learned on the training part.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn evaluate(
    dataset: &Dataset,
    folds: &[Fold],
    settings: &TrainSettings,
) -> Result<Vec<MethodQuality>, InputError> {
    let mut sums = [Sums::default(); Method::ALL.len()];
    for fold in folds {
        let train = dataset.select(&fold.train);
        let test = dataset.select(&fold.test);
        let laws = learn_laws(&Method::ALL, &train, settings, None)?;
        let pulled = TrainSettings { has_attraction: true, ..settings.clone() };
        let attraction = learn_attraction(dataset, &train, &pulled);
        let inner = dataset.blocks_of(&fold.train);
        let unseen = unseen_residuals(dataset, &inner, &laws, settings, false)?;
        for ((law, residuals), sum) in laws.iter().zip(&unseen).zip(&mut sums) {
            let spread = covariance(residuals.iter().map(|r| &r.value));
            score(law, &spread, &test, sum)?;
            sum.free += path_error_deg(dataset, law, None, &test);
            sum.pulled += path_error_deg(dataset, law, attraction.as_ref(), &test);
        }
    }
    let count = folds.len() as f64;
    let quality = |(method, s): (Method, &Sums)| MethodQuality {
        method,
        relative_rmse: s.relative / count,
        rmse_rad_s: (s.square / count).sqrt(),
        log_likelihood_null: s.null / count,
        log_likelihood: s.all / count,
        path_error_deg: Some((s.free / count, s.pulled / count)),
    };
    Ok(Method::ALL.into_iter().zip(&sums).map(quality).collect())
}

fn score(
    law: &Law,
    spread: &DMatrix<f64>,
    test: &[&Frame],
    sum: &mut Sums,
) -> Result<(), InputError> {
    let (mut error, mut size, mut null, mut all) = (0.0, 0.0, 0.0, 0.0);
    for frame in test {
        let still = DVector::zeros(frame.q.len());
        let residual = &frame.qdot - law.expected(frame, &still)?.mean;
        error += residual.norm_squared();
        size += frame.qdot.norm_squared();
        let (inside, joint) = log_likelihoods(frame, &residual, spread);
        null += inside;
        all += joint;
    }
    let count = test.len() as f64;
    sum.relative += (error / size.max(f64::MIN_POSITIVE)).sqrt();
    sum.square += error / (count * spread.nrows() as f64);
    sum.null += null / count;
    sum.all += all / count;
    Ok(())
}

/// Log-likelihood of a residual within the null space, and in all joints, nats.
fn log_likelihoods(frame: &Frame, residual: &DVector<f64>, spread: &DMatrix<f64>) -> (f64, f64) {
    let v = null_space_basis(&frame.jacobian);
    let k = v.ncols();
    let cov =
        v.tr_mul(&(spread * &v)) + DMatrix::identity(k, k) * (NULL_FLOOR_RAD_S * NULL_FLOOR_RAD_S);
    let null = log_normal(&v.tr_mul(residual), cov);
    let jjt = &frame.jacobian * frame.jacobian.transpose();
    let m = jjt.nrows();
    let task = log_normal(&DVector::zeros(m), DMatrix::identity(m, m) * (TASK_SD * TASK_SD));
    let volume =
        jjt.cholesky().map_or(f64::NAN, |f| f.l_dirty().diagonal().iter().map(|d| d.ln()).sum());
    (null, null + volume + task)
}

/// log N(y; 0, S), nats; NaN where S is not positive definite.
fn log_normal(y: &DVector<f64>, covariance: DMatrix<f64>) -> f64 {
    let Some(factor) = covariance.cholesky() else { return f64::NAN };
    let log_det = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let constant = y.len() as f64 * (2.0 * std::f64::consts::PI).ln();
    -0.5 * (factor.solve(y).dot(y) + log_det + constant)
}

/// Mean joint error (deg) along the hand paths of the test frames, in closed loop without noise.
/// Where the rollout ends early its last posture counts for the rest of the path.
pub fn path_error_deg(
    dataset: &Dataset,
    law: &Law,
    attraction: Option<&Attraction>,
    test: &[&Frame],
) -> f64 {
    let model = bare_model(dataset, law.clone(), attraction.cloned());
    let (mut sum, mut count) = (0.0, 0);
    for run in runs(test) {
        let time: Vec<f64> = run.iter().map(|f| f.time_s).collect();
        let hands: Vec<Pose> = run.iter().map(|f| f.hand).collect();
        let path = HandPath::new(&dataset.coupling, &model, time, hands);
        let start = Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false };
        let rollout = roll_out(&dataset.coupling, &model, &path, &start, None);
        for (q, frame) in rollout.q.iter().zip(&run) {
            let square = (q - &frame.q).norm_squared() / q.len() as f64;
            sum += square.sqrt().to_degrees();
        }
        count += run.len();
    }
    sum / f64::from(u32::try_from(count.max(1)).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;
    use approx::assert_relative_eq;

    #[test]
    fn likelihood_in_all_joints_is_that_of_the_full_gaussian() {
        // N(J^+ x, V S V^T + J^+ S_x J^+^T) of the residual in n dimensions, the long way.
        let data = made_up(1, 3.0, 30.0);
        let frame = &data.frames[10];
        let a = DMatrix::from_fn(24, 24, |i, j| 0.1 * ((i * 5 + j * 3) as f64).sin());
        let spread = &a * a.transpose() + DMatrix::identity(24, 24) * 0.02;
        let v = null_space_basis(&frame.jacobian);
        let residual = &v * DVector::from_fn(18, |i, _| 0.2 * (i as f64).cos());
        let (null, all) = log_likelihoods(frame, &residual, &spread);
        let inside = v.tr_mul(&(&spread * &v)) + DMatrix::identity(18, 18) * 1e-4;
        let pinv = frame.jacobian.clone().pseudo_inverse(1e-12).unwrap();
        let full = &v * inside * v.transpose() + &pinv * pinv.transpose() * 1e-8;
        assert_relative_eq!(all, log_normal(&residual, full), epsilon = 1e-4);
        assert!(all > null);
    }

    #[test]
    fn a_law_that_made_the_data_is_judged_best() {
        // Velocities by a full W of rank two: only full-w can follow them.
        let mut data = made_up(2, 4.0, 30.0);
        for f in &mut data.frames {
            let t = f.time_s;
            let pattern = |i: usize, j: usize| ((i * (j + 3)) as f64).sin();
            f.qdot = DVector::from_fn(24, |i, _| {
                pattern(i, 1) * (2.0 * t).sin() + pattern(i, 2) * (3.0 * t).cos()
            });
            f.xdot = &f.jacobian * &f.qdot;
        }
        let quality = evaluate(&data, &data.held_out(), &TrainSettings::default()).unwrap();
        let of = |m: Method| quality.iter().find(|q| q.method == m).unwrap().relative_rmse;
        assert!(of(Method::FullW) < 0.35, "{}", of(Method::FullW));
        assert!(of(Method::FullW) < 0.6 * of(Method::WIk).min(of(Method::PlainIk)));
    }
}

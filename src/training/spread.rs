//! What differs between repetitions: residuals of laws that have not seen the frame, the noise that
//! they make, the person's postures and the pull towards them.
//!
//! ```text
//! r = qdot - mean          mean by the law (and pull) learned without the frame's trial or block
//! r = e sqrt(|v|^2 + v0^2),  cov e = F F^T,  v0 by maximum likelihood, tau by autocorrelation of e
//! ```
//!
//! The mean includes the pull, as in rollouts. On held-out blocks of a real hand-over (two people) the
//! central 90 % band of rollouts then covers 82 and 88 % of the joint angles; with residuals of the law
//! alone 69 and 72 %.
//!
//! ```text
//! postures: mean, (1 - a) C + a diag C + (1 deg)^2 I,  a = 0.1
//! ```

use super::dataset::{Dataset, Fold, Frame, at_most, runs, sparse};
use super::methods::{Law, learn_laws};
use super::settings::TrainSettings;
use crate::files::InputError;
use crate::math::Pose;
use crate::math::signal::correlation_time;
use crate::posture::{Attraction, Method, Noise, PostureDistribution, effective_speed};
use nalgebra::{DMatrix, DVector};

/// Hand speeds (m/s) tried as the floor v0 below which the noise no longer shrinks. The likelihood
/// often prefers the last one, because the pull errs at rest too; larger ones cover no better.
const SPEED_FLOORS_M_S: [f64; 9] = [0.01, 0.015, 0.02, 0.03, 0.05, 0.07, 0.10, 0.14, 0.20];
/// Directions with less than this part of the largest variance are left out of the noise.
const SMALLEST_VARIANCE: f64 = 1e-3;
/// Share of the diagonal in the posture covariance, and its floor, rad.
const POSTURE_SHRINKAGE: f64 = 0.1;
const POSTURE_FLOOR_RAD: f64 = std::f64::consts::PI / 180.0;

/// What is left of a frame's joint velocity.
#[derive(Debug, Clone)]
pub struct Residual<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// qdot minus the expected joint velocity, n, rad/s.
    pub value: DVector<f64>,
}

/// The pull of the settings towards the postures of these frames; none when it is switched off.
pub fn learn_attraction(
    dataset: &Dataset,
    frames: &[&Frame],
    settings: &TrainSettings,
) -> Option<Attraction> {
    if !settings.has_attraction {
        return None;
    }
    let kept = at_most(&sparse(frames), settings.attraction_postures);
    let hands: Vec<Pose> = kept.iter().map(|f| f.hand).collect();
    let rows: Vec<_> = kept.iter().map(|f| f.q.transpose()).collect();
    Some(Attraction::fit(
        &hands,
        DMatrix::from_rows(&rows),
        dataset.size.stature_m,
        settings.attraction_rate_per_s,
        settings.attraction_length,
        settings.attraction_noise,
    ))
}

/// The preferred velocity by which an attraction pulls at a frame, n, rad/s.
pub fn pull(attraction: Option<&Attraction>, frame: &Frame, stature_m: f64) -> DVector<f64> {
    attraction.map_or_else(
        || DVector::zeros(frame.q.len()),
        |a| {
            let usual = a.usual_posture(&frame.hand, stature_m);
            (usual.posture - &frame.q) * (a.rate() * usual.confidence)
        },
    )
}

/// Residuals of each law (outer index as in `laws`) on every test frame of `folds`, relearned
/// without it. With `is_pulled` the attraction is part of the law, also relearned.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn unseen_residuals<'a>(
    dataset: &'a Dataset,
    folds: &[Fold],
    laws: &[Law],
    settings: &TrainSettings,
    is_pulled: bool,
) -> Result<Vec<Vec<Residual<'a>>>, InputError> {
    let methods: Vec<Method> = laws.iter().map(|l| l.method).collect();
    let mut found: Vec<Vec<Residual>> = vec![Vec::new(); laws.len()];
    for fold in folds {
        let train = dataset.select(&fold.train);
        let relearned = learn_laws(&methods, &train, settings, Some(laws))?;
        let attraction = if is_pulled { learn_attraction(dataset, &train, settings) } else { None };
        for frame in dataset.select(&fold.test) {
            let pulled = pull(attraction.as_ref(), frame, dataset.size.stature_m);
            for (residuals, law) in found.iter_mut().zip(&relearned) {
                let value = &frame.qdot - law.expected(frame, &pulled)?.mean;
                residuals.push(Residual { frame, value });
            }
        }
    }
    Ok(found)
}

/// `mean r r^T`, n x n.
pub fn covariance<'a>(residuals: impl IntoIterator<Item = &'a DVector<f64>>) -> DMatrix<f64> {
    let (mut sum, mut count) = (DMatrix::zeros(0, 0), 0);
    for r in residuals {
        if count == 0 {
            sum = DMatrix::zeros(r.len(), r.len());
        }
        sum.ger(1.0, r, r, 1.0);
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// The noise that explains unseen residuals.
pub fn learn_noise(residuals: &[Residual]) -> Noise {
    let likelihood = |floor: f64| {
        let logs: f64 = residuals.iter().map(|r| speed(r, floor).ln()).sum();
        let sum: f64 =
            residuals.iter().map(|r| r.value.norm_squared() / speed(r, floor).powi(2)).sum();
        -logs - 0.5 * residuals.len() as f64 * sum.max(f64::MIN_POSITIVE).ln()
    };
    let best =
        SPEED_FLOORS_M_S.into_iter().max_by(|a, b| likelihood(*a).total_cmp(&likelihood(*b)));
    let floor = best.unwrap_or(SPEED_FLOORS_M_S[0]);
    let unit: Vec<DVector<f64>> = residuals.iter().map(|r| &r.value / speed(r, floor)).collect();
    Noise {
        factor: factor(&covariance(&unit)),
        correlation_time_s: pooled_correlation_time(residuals, &unit),
        speed_floor_m_s: floor,
    }
}

fn speed(residual: &Residual, floor: f64) -> f64 {
    effective_speed(residual.frame.xdot.as_slice(), floor)
}

/// F with `F F^T` the covariance without its smallest directions; columns by falling variance, the
/// largest entry of each positive.
fn factor(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len())
        .filter(|&i| eigen.eigenvalues[i] > SMALLEST_VARIANCE * largest)
        .collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let columns: Vec<DVector<f64>> = order
        .iter()
        .map(|&i| {
            let v = eigen.eigenvectors.column(i);
            let sign = v[v.icamax()].signum();
            v * (sign * eigen.eigenvalues[i].sqrt())
        })
        .collect();
    if columns.is_empty() {
        return DMatrix::zeros(covariance.nrows(), 0);
    }
    DMatrix::from_columns(&columns)
}

/// Correlation time (s) pooled over joints and over runs of consecutive frames; runs of different
/// rates are pooled by their numbers of frames.
fn pooled_correlation_time(residuals: &[Residual], unit: &[DVector<f64>]) -> f64 {
    let order: Vec<usize> = {
        let mut order: Vec<usize> = (0..residuals.len()).collect();
        order.sort_by_key(|&i| (residuals[i].frame.trial, residuals[i].frame.index));
        order
    };
    let frames: Vec<&Frame> = order.iter().map(|&i| residuals[i].frame).collect();
    // Series by time step (ns, so that equal steps compare equal).
    let mut by_step: std::collections::BTreeMap<u64, Vec<Vec<f64>>> =
        std::collections::BTreeMap::new();
    let mut at = 0;
    for run in runs(&frames) {
        let rows = &order[at..at + run.len()];
        at += run.len();
        let [first, second, ..] = run[..] else { continue };
        let step = ((second.time_s - first.time_s) * 1e9).round() as u64;
        let joints = 0..unit[rows[0]].len();
        let series = joints.map(|c| rows.iter().map(|&i| unit[i][c]).collect());
        by_step.entry(step).or_default().extend(series);
    }
    let (mut sum, mut weight) = (0.0, 0.0);
    for (step, series) in by_step {
        let count: usize = series.iter().map(Vec::len).sum();
        sum += count as f64 * correlation_time(&series, step as f64 * 1e-9);
        weight += count as f64;
    }
    if weight > 0.0 { sum / weight } else { 0.1 }
}

/// The person's postures as a shrunk Gaussian.
pub fn learn_postures(frames: &[&Frame]) -> PostureDistribution {
    let n = frames.first().map_or(0, |f| f.q.len());
    let mean = frames.iter().fold(DVector::zeros(n), |sum, f| sum + &f.q) / frames.len() as f64;
    let centred: Vec<DVector<f64>> = frames.iter().map(|f| &f.q - &mean).collect();
    let full = covariance(&centred);
    let diagonal = DMatrix::from_diagonal(&full.diagonal());
    let floor = DMatrix::identity(n, n) * POSTURE_FLOOR_RAD.powi(2);
    let covariance = full * (1.0 - POSTURE_SHRINKAGE) + diagonal * POSTURE_SHRINKAGE + floor;
    PostureDistribution { mean, covariance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use crate::training::dataset::tests::made_up;
    use approx::assert_relative_eq;

    #[test]
    fn known_noise_is_found_again() {
        let data = made_up(6, 60.0, 30.0);
        let truth = Noise {
            factor: DMatrix::from_fn(24, 3, |i, j| ((i * (j + 2)) as f64).sin() / (1.0 + j as f64)),
            correlation_time_s: 0.3,
            speed_floor_m_s: 0.05,
        };
        let mut residuals = Vec::new();
        for (r, run) in runs(&data.frames.iter().collect::<Vec<_>>()).iter().enumerate() {
            let mut rng = stream(5, Purpose::Simulation, 0, r as u32);
            let path = truth.path(&mut rng, run.len(), 1.0 / 30.0);
            residuals.extend(run.iter().enumerate().map(|(k, &frame)| Residual {
                frame,
                value: path.at(k, 0.0) * truth.speed(frame.xdot.as_slice()),
            }));
        }
        let found = learn_noise(&residuals);
        assert_eq!(found.factor.ncols(), 3);
        assert_relative_eq!(found.correlation_time_s, 0.3, max_relative = 0.15);
        // The hand moves far faster than the floors, so v0 itself is not determined here.
        let (own, planted) =
            (&found.factor * found.factor.transpose(), &truth.factor * truth.factor.transpose());
        assert!((&own - &planted).norm() < 0.2 * planted.norm());
    }

    #[test]
    fn postures_of_a_flat_set_are_still_positive_definite() {
        let data = made_up(1, 2.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().take(5).collect();
        let postures = learn_postures(&frames);
        assert!(postures.covariance.clone().cholesky().is_some());
        assert!(postures.mahalanobis(&frames[2].q) < 3.0);
    }

    #[test]
    fn unseen_residuals_are_those_of_laws_without_the_block() {
        let data = made_up(1, 6.0, 30.0);
        let settings = TrainSettings::default();
        let all: Vec<&Frame> = data.frames.iter().collect();
        let laws = learn_laws(&[Method::FullW], &all, &settings, None).unwrap();
        let folds = data.blocks();
        let found = unseen_residuals(&data, &folds, &laws, &settings, true).unwrap();
        assert_eq!(found[0].len(), data.frames.len());
        assert!(found[0].iter().all(|r| (&r.frame.jacobian * &r.value).norm() < 1e-9));
    }
}

//! Residuals of laws that have not seen the frame, the person's postures and the pull towards them.
//!
//! ```text
//! r = qdot - mean          mean by the law (and pull) learned without the frame's trial or block
//! ```
//! For rollouts the mean includes the pull.
//!
//! ```text
//! postures: mean, (1 - a) C + a diag C + (1 deg)^2 I,  a = 0.1
//! ```

use super::dataset::{Dataset, Fold, Frame, at_most, sparse};
use super::methods::{Law, learn_laws, singular};
use super::settings::{PullRule, TrainSettings};
use crate::files::InputError;
use crate::math::Pose;
use crate::posture::{Attraction, Method, Origin, PostureDistribution, Pull};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

pub(super) use super::noise_fit::autocorrelation_time;

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
    /// Factor by which the spread there exceeds the noise, for what a process does not know, n.
    pub growth: DVector<f64>,
}

/// The pull of the settings towards the postures of these frames; none when it is switched off.
pub fn learn_attraction(
    dataset: &Dataset,
    frames: &[&Frame],
    settings: &TrainSettings,
) -> Option<Attraction> {
    let pull = match settings.pull_for(dataset.person.is_some()) {
        PullRule::PerMetre => Pull::Metre { length_m: settings.attraction_length_m },
        PullRule::PerSecond => Pull::Second { rate_per_s: settings.attraction_rate_per_s },
        PullRule::None => return None,
    };
    let people: BTreeSet<usize> = frames.iter().map(|f| f.person).collect();
    let kept = at_most(&sparse(frames), settings.attraction_postures * people.len().max(1));
    let hands: Vec<Pose> = kept.iter().map(|f| f.hand).collect();
    let rows: Vec<_> = kept.iter().map(|f| f.q.transpose()).collect();
    if dataset.is_of_people() {
        let origins = kept.iter().map(|f| Origin { person: f.person, movement: f.trial }).collect();
        return Some(Attraction::of_people(
            &hands,
            DMatrix::from_rows(&rows),
            origins,
            dataset.coupling.stature_m(),
            (pull, settings.place_length, settings.attraction_noise),
        ));
    }
    Some(Attraction::fit(
        &hands,
        DMatrix::from_rows(&rows),
        dataset.coupling.stature_m(),
        pull,
        settings.attraction_length,
        settings.attraction_noise,
    ))
}

/// The preferred velocity by which an attraction pulls at a frame, n, rad/s.
pub fn pull(attraction: Option<&Attraction>, frame: &Frame, stature_m: f64) -> DVector<f64> {
    attraction.map_or_else(
        || DVector::zeros(frame.q.len()),
        |a| a.pull_velocity(&frame.hand, frame.xdot.as_slice(), &frame.q, stature_m),
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
    let stature_m = dataset.coupling.stature_m();
    let mut found: Vec<Vec<Residual>> = vec![Vec::new(); laws.len()];
    for fold in folds {
        let train = dataset.select(&fold.train);
        let relearned = learn_laws(&methods, &train, stature_m, settings, Some(laws))?;
        let attraction = if is_pulled { learn_attraction(dataset, &train, settings) } else { None };
        let test = dataset.select(&fold.test);
        let queries: Vec<_> = test.iter().map(|f| f.query()).collect();
        for (residuals, law) in found.iter_mut().zip(&relearned) {
            let posteriors = law.law.posteriors().ok_or_else(singular)?;
            let growth = law.law.growth(&posteriors, &queries);
            for (frame, growth) in test.iter().copied().zip(growth) {
                let pulled = pull(attraction.as_ref(), frame, stature_m);
                let value = &frame.qdot - law.expected(frame, &pulled)?;
                residuals.push(Residual { frame, value, growth });
            }
        }
    }
    Ok(found)
}

/// `mean r r^T`, n x n.
fn covariance<'a>(residuals: impl IntoIterator<Item = &'a DVector<f64>>) -> DMatrix<f64> {
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

/// The person's postures as a shrunk Gaussian.
pub fn learn_postures(frames: &[&Frame]) -> PostureDistribution {
    let n = frames.first().map_or(0, |f| f.q.len());
    let mean = frames.iter().fold(DVector::zeros(n), |sum, f| sum + &f.q) / frames.len() as f64;
    let centred: Vec<DVector<f64>> = frames.iter().map(|f| &f.q - &mean).collect();
    PostureDistribution::anywhere(mean, shrunk(covariance(&centred)))
}

fn shrunk(full: DMatrix<f64>) -> DMatrix<f64> {
    let diagonal = DMatrix::from_diagonal(&full.diagonal());
    let floor = DMatrix::identity(full.nrows(), full.nrows()) * POSTURE_FLOOR_RAD.powi(2);
    full * (1.0 - POSTURE_SHRINKAGE) + diagonal * POSTURE_SHRINKAGE + floor
}

/// Shrunk covariance about the usual posture at the hand's place, learned without the frame's trial: each
/// frame counts as far as the usual posture is known there. None without a pull or without other trials.
pub(super) fn learn_about_usual(
    dataset: &Dataset,
    settings: &TrainSettings,
) -> Option<DMatrix<f64>> {
    let stature_m = dataset.coupling.stature_m();
    let (mut sum, mut known) = (None, 0.0);
    for fold in dataset.held_out() {
        let attraction = learn_attraction(dataset, &dataset.select(&fold.train), settings)?;
        for frame in sparse(&dataset.select(&fold.test)) {
            let usual = attraction.usual_posture(&frame.hand, stature_m);
            let (weight, off) = (usual.trust(), &frame.q - usual.posture);
            let n = off.len();
            let sum = sum.get_or_insert_with(|| DMatrix::zeros(n, n));
            sum.ger(weight, &off, &off, 1.0);
            known += weight;
        }
    }
    sum.filter(|_| known > 0.0).map(|sum| shrunk(sum / known))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;

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
        let laws = learn_laws(&[Method::FullW], &all, 1.6, &settings, None).unwrap();
        let folds = data.blocks();
        let found = unseen_residuals(&data, &folds, &laws, &settings, true).unwrap();
        assert_eq!(found[0].len(), data.frames.len());
        assert!(found[0].iter().all(|r| (&r.frame.jacobian * &r.value).norm() < 1e-9));
    }
}

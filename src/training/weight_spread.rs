//! How firmly the data hold the weights: the law learned again without each block, as a jackknife.
//!
//! ```text
//! l      logarithm of the diagonal of W, its mean over the joints taken off
//! l_k    the same of the law learned without block k of K
//! se^2 = (K - 1)/K  sum over k of (l_k - mean of l_k)^2        (Efron and Stein 1981)
//! 95 %:  exp(l - 1.96 se) to exp(l + 1.96 se)
//! ```

use super::dataset::{Dataset, Frame};
use super::methods::{default_shrinkage, learn_laws, singular};
use super::settings::TrainSettings;
use crate::files::InputError;
use crate::math::stats::{mean, normal_quantile};
use crate::posture::{Method, PostureModel, joint_group};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// The learned weight of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointWeight {
    /// Name of the joint.
    pub joint: String,
    /// Group of joints to which it belongs.
    pub group: &'static str,
    /// Its entry on the diagonal of W over the geometric mean of the diagonal.
    pub weight: f64,
    /// Ends of the jackknife's 95 % interval; none without two blocks.
    pub interval: Option<(f64, f64)>,
}

/// The weights of all joints, in the order of the chain.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightSpread {
    /// Method of the model.
    pub method: Method,
    /// A row for each joint.
    pub joints: Vec<JointWeight>,
    /// Number of blocks that were left out in turn.
    pub blocks: usize,
    /// Number of movements in the data.
    pub trials: usize,
}

/// The weights of a model with how much they change when blocks of its data are left out; none for
/// methods that do not identify weights.
///
/// # Errors
/// Where the chain is singular in a part of the data.
pub fn weight_spread(
    dataset: &Dataset,
    model: &PostureModel,
    settings: &TrainSettings,
) -> Result<Option<WeightSpread>, InputError> {
    if !model.method.identifies_weights() {
        return Ok(None);
    }
    // The process on top of full-w has no part in its W.
    let method = if model.method == Method::FullWGp { Method::FullW } else { model.method };
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    // What is chosen by the amount of data is that of all data: one law, not several, is tried.
    let settings = TrainSettings {
        shrinkage: settings.shrinkage.or_else(|| Some(default_shrinkage(&all))),
        objective: Some(settings.objective_for(dataset.trials)),
        ..settings.clone()
    };
    let folds = dataset.blocks();
    let without: Result<Vec<Vec<f64>>, InputError> = folds
        .par_iter()
        .map(|fold| {
            let frames = dataset.select(&fold.train);
            let stature_m = dataset.coupling.stature_m();
            // From nothing: a law that starts from the one of all data would keep some of it.
            let laws = learn_laws(&[method], &frames, stature_m, &settings, None)?;
            laws.first().map(|law| relative_logs(&law.law.weight)).ok_or_else(singular)
        })
        .collect();
    let logs = relative_logs(&model.law.weight);
    let errors = jackknife_errors(&without?);
    let joints = model.joints.iter().enumerate().map(|(j, joint)| JointWeight {
        joint: joint.clone(),
        group: joint_group(joint),
        weight: logs[j].exp(),
        interval: errors.as_ref().map(|se| interval(logs[j], se[j])),
    });
    Ok(Some(WeightSpread {
        method: model.method,
        joints: joints.collect(),
        blocks: folds.len(),
        trials: dataset.trials,
    }))
}

/// Logarithms of the diagonal, mean zero: the weights over their geometric mean.
fn relative_logs(weight: &DMatrix<f64>) -> Vec<f64> {
    let logs: Vec<f64> = weight.diagonal().iter().map(|w| w.ln()).collect();
    let middle = mean(&logs);
    logs.iter().map(|l| l - middle).collect()
}

/// Jackknife standard errors of the columns of `without` (K x n); none for fewer than two rows.
fn jackknife_errors(without: &[Vec<f64>]) -> Option<Vec<f64>> {
    let count = without.len() as f64;
    let columns = without.first().filter(|_| without.len() > 1)?.len();
    let error = |j: usize| {
        let own: Vec<f64> = without.iter().map(|row| row[j]).collect();
        let middle = mean(&own);
        let sum: f64 = own.iter().map(|l| (l - middle).powi(2)).sum();
        ((count - 1.0) / count * sum).sqrt()
    };
    Some((0..columns).map(error).collect())
}

fn interval(log: f64, error: f64) -> (f64, f64) {
    let half = normal_quantile(0.975) * error;
    ((log - half).exp(), (log + half).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::standard_error;
    use crate::posture::Provenance;
    use crate::training::dataset::tests::made_up;
    use crate::training::learn;
    use approx::assert_relative_eq;

    #[test]
    fn of_a_mean_the_jackknife_is_its_standard_error() {
        // Closed form: s / sqrt(K) for the mean of K numbers.
        let (a, b) = ([3.0, 5.0, 10.0, 4.5], [1.0, 1.0, 1.0, 1.0]);
        let left_out = |x: &[f64], k: usize| (x.iter().sum::<f64>() - x[k]) / 3.0;
        let without: Vec<Vec<f64>> =
            (0..4).map(|k| vec![left_out(&a, k), left_out(&b, k)]).collect();
        let errors = jackknife_errors(&without).unwrap();
        assert_relative_eq!(errors[0], standard_error(&a).unwrap(), max_relative = 1e-12);
        assert!(errors[1].abs() < 1e-12);
        assert!(jackknife_errors(&without[..1]).is_none() && jackknife_errors(&[]).is_none());
        let (low, high) = interval(0.5, 0.2);
        assert_relative_eq!(low, (0.5_f64 - 1.959_964 * 0.2).exp(), max_relative = 1e-6);
        assert_relative_eq!(low * high, 1.0_f64.exp(), max_relative = 1e-12);
    }

    fn model(data: &Dataset, method: Method) -> PostureModel {
        let provenance = Provenance {
            filled_from: None,
            program_version: String::new(),
            simulated: true,
            adapted_s: None,
            people: 1,
            recordings: Vec::new(),
            body: (String::new(), String::new()),
            settings: Vec::new(),
            notes: Vec::new(),
        };
        learn(data, "made up", method, &TrainSettings::default(), provenance).unwrap()
    }

    #[test]
    fn a_second_moment_is_left_out_by_hand() {
        // With a share of W_LS of nearly nothing W is the second moment of the frames that are left.
        let data = made_up(3, 2.0, 30.0);
        let settings = TrainSettings { shrinkage: Some(0.0), ..TrainSettings::default() };
        let model = model(&data, Method::FullW);
        let spread = weight_spread(&data, &model, &settings).unwrap().unwrap();
        assert_eq!((spread.joints.len(), spread.blocks, spread.trials), (24, 3, 3));
        let logs: f64 = spread.joints.iter().map(|j| j.weight.ln()).sum();
        assert!(logs.abs() < 1e-9);
        let own = |k: usize| -> Vec<f64> {
            let left: Vec<&Frame> = data.frames.iter().filter(|f| f.trial != k).collect();
            let square = |j: usize| left.iter().map(|f| f.qdot[j].powi(2)).sum::<f64>();
            let floor = 1e-2 * (0..24).map(square).sum::<f64>() / 24.0;
            let logs: Vec<f64> = (0..24).map(|j| (square(j) + floor).ln()).collect();
            logs.iter().map(|l| l - logs.iter().sum::<f64>() / 24.0).collect()
        };
        let rows = [own(0), own(1), own(2)];
        for (j, joint) in spread.joints.iter().enumerate() {
            let m = (rows[0][j] + rows[1][j] + rows[2][j]) / 3.0;
            let se = (2.0 / 3.0 * rows.iter().map(|r| (r[j] - m).powi(2)).sum::<f64>()).sqrt();
            let (low, high) = joint.interval.unwrap();
            assert_relative_eq!((high / low).ln(), 2.0 * 1.959_964 * se, max_relative = 1e-5);
            assert!(low <= joint.weight && joint.weight <= high);
        }
        assert_eq!((spread.joints[0].group, spread.joints[23].group), ("spine", "wrist"));
    }

    #[test]
    fn searched_weights_are_searched_again_and_given_ones_have_no_spread() {
        let data = made_up(3, 2.0, 30.0);
        let settings = TrainSettings { search_samples: 40, ..TrainSettings::default() };
        for method in [Method::PlainIk, Method::Nsgp, Method::Gp, Method::SbM, Method::Promp] {
            let model = model(&data, Method::PlainIk);
            let model = PostureModel { method, ..model };
            assert!(weight_spread(&data, &model, &settings).unwrap().is_none());
        }
        let model = model(&data, Method::WIk);
        for method in [Method::WIk, Method::MiNsgp, Method::FullWGp] {
            let model = PostureModel { method, ..model.clone() };
            let spread = weight_spread(&data, &model, &settings).unwrap().unwrap();
            // No block leaves the weights as they were.
            let wide = |j: &JointWeight| j.interval.is_some_and(|(low, high)| high / low > 1.001);
            assert!(spread.joints.iter().filter(|j| wide(j)).count() > 20, "{method:?}");
        }
    }
}

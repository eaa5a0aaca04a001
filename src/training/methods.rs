//! The methods: each is a choice of z and W in the one conditioned Gaussian of [`crate::posture`].
//!
//! ```text
//! plain-ik   W = I
//! w-ik       W = diag(w) by least squares
//! full-w     W = (1 - a) S + a W_LS + d I     S = mean qdot qdot^T,  W_LS: w-ik scaled to trace S
//! mi-nsgp    W = diag(w) and z = GP(q, xdot), by marginal likelihood
//! ```
//! `W` is scaled to the trace of `S`, so that it reads as a joint-velocity covariance, (rad/s)^2.

mod descent;
mod diagonal;
mod mi_nsgp;

use super::dataset::{Frame, sparse};
use super::settings::TrainSettings;
use crate::files::InputError;
use crate::posture::{Conditional, Method, NullSpaceGp, condition};
use nalgebra::{DMatrix, DVector};

/// Span of a single trial, s, below which little is known and more weight is put on `W_LS`.
const SHORT_SPAN_S: f64 = 4.0;

/// What a method learned: z and W.
#[derive(Debug, Clone)]
pub struct Law {
    /// The method.
    pub method: Method,
    /// W, n x n, (rad/s)^2.
    pub weight: DMatrix<f64>,
    /// The process of MI-NsGP.
    pub gp: Option<NullSpaceGp>,
    /// log w of the diagonal part, n, mean zero; of full-w: that of its `W_LS`.
    pub log_weights: Option<Vec<f64>>,
    /// Share a of `W_LS` in full-w.
    pub shrinkage: Option<f64>,
}

impl Law {
    /// Preferred velocity z at a frame, n, rad/s.
    pub fn preferred(&self, frame: &Frame) -> DVector<f64> {
        self.gp.as_ref().map_or_else(
            || DVector::zeros(frame.q.len()),
            |gp| gp.mean(frame.q.as_slice(), frame.xdot.as_slice()),
        )
    }

    /// The joint velocity that the law expects with an additional preferred velocity `pull`.
    ///
    /// # Errors
    /// Where the chain is singular.
    pub fn expected(&self, frame: &Frame, pull: &DVector<f64>) -> Result<Conditional, InputError> {
        condition(&frame.jacobian, &self.weight, &(self.preferred(frame) + pull), &frame.xdot)
            .ok_or_else(singular)
    }
}

/// Learns the laws of several methods from frames at 30 Hz.
///
/// `before` holds laws of the same methods from nearly the same data (all but a block): weights
/// start there, and MI-NsGP keeps its weights and kernel and only learns its values anew.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn learn_laws(
    methods: &[Method],
    frames: &[&Frame],
    settings: &TrainSettings,
    before: Option<&[Law]>,
) -> Result<Vec<Law>, InputError> {
    let moment = second_moment(frames);
    let few = sparse(frames);
    let warm = before.and_then(|laws| {
        laws.iter().filter(|l| l.method != Method::MiNsgp).find_map(|l| l.log_weights.as_deref())
    });
    let old = |method| before.and_then(|laws| laws.iter().find(|l| l.method == method));
    let needs_weights = |m: &Method| match m {
        Method::PlainIk => false,
        Method::MiNsgp => old(*m).is_none(),
        Method::WIk | Method::FullW => true,
    };
    let log_w = if methods.iter().any(needs_weights) {
        diagonal::least_squares(&few, &moment, warm)
    } else {
        vec![0.0; moment.nrows()]
    };
    methods
        .iter()
        .map(|&method| match method {
            Method::PlainIk => Ok(plain(&moment)),
            Method::WIk => Ok(weighted(method, &moment, &log_w)),
            Method::FullW => Ok(full(frames, &moment, &log_w, settings)),
            Method::MiNsgp => {
                mi_nsgp(&few, &moment, &log_w, settings, old(method)).ok_or_else(singular)
            }
        })
        .collect()
}

fn singular() -> InputError {
    InputError::new("recordings", "hold a posture in which the hand cannot move in every direction")
        .remedy(
            "check the fit: an arm that is stretched to its end for long cannot be learned from",
        )
}

/// `mean qdot qdot^T`, n x n, (rad/s)^2; not centred, so that moving there and back counts.
fn second_moment(frames: &[&Frame]) -> DMatrix<f64> {
    let n = frames.first().map_or(0, |f| f.qdot.len());
    let mut sum = DMatrix::zeros(n, n);
    for f in frames {
        sum.ger(1.0, &f.qdot, &f.qdot, 1.0);
    }
    sum / frames.len().max(1) as f64
}

fn diagonal_weight(moment: &DMatrix<f64>, log_w: &[f64]) -> DMatrix<f64> {
    let w = DVector::from_iterator(log_w.len(), log_w.iter().map(|l| l.exp()));
    let scale = moment.trace() / w.sum();
    DMatrix::from_diagonal(&(w * scale))
}

fn plain(moment: &DMatrix<f64>) -> Law {
    let n = moment.nrows();
    let weight = DMatrix::identity(n, n) * (moment.trace() / n as f64);
    Law { method: Method::PlainIk, weight, gp: None, log_weights: None, shrinkage: None }
}

fn weighted(method: Method, moment: &DMatrix<f64>, log_w: &[f64]) -> Law {
    let weight = diagonal_weight(moment, log_w);
    Law { method, weight, gp: None, log_weights: Some(log_w.to_vec()), shrinkage: None }
}

fn full(frames: &[&Frame], moment: &DMatrix<f64>, log_w: &[f64], settings: &TrainSettings) -> Law {
    let a = settings.shrinkage.unwrap_or_else(|| default_shrinkage(frames));
    let n = moment.nrows();
    let floor = settings.diagonal_share * moment.trace() / n as f64;
    let weight =
        moment * (1.0 - a) + diagonal_weight(moment, log_w) * a + DMatrix::identity(n, n) * floor;
    let log_weights = Some(log_w.to_vec());
    Law { method: Method::FullW, weight, gp: None, log_weights, shrinkage: Some(a) }
}

/// 0.3, or 0.5 for a single trial shorter than 4 s.
fn default_shrinkage(frames: &[&Frame]) -> f64 {
    let is_single = frames.iter().all(|f| f.trial == frames[0].trial);
    let span = match (frames.first(), frames.last()) {
        (Some(a), Some(b)) => b.time_s - a.time_s,
        _ => 0.0,
    };
    if is_single && span < SHORT_SPAN_S { 0.5 } else { 0.3 }
}

fn mi_nsgp(
    few: &[&Frame],
    moment: &DMatrix<f64>,
    log_w: &[f64],
    settings: &TrainSettings,
    old: Option<&Law>,
) -> Option<Law> {
    let known = old.and_then(|l| Some((l.log_weights.clone()?, l.gp.as_ref()?.hyper)));
    let (log_w, gp) = if let Some((log_w, hyper)) = known {
        let few = super::dataset::at_most(few, settings.gp_samples);
        let gp = mi_nsgp::process(&few, &log_w, hyper)?;
        (log_w, gp)
    } else {
        let found = mi_nsgp::learn(few, log_w, settings.gp_samples)?;
        (found.log_w, found.gp)
    };
    Some(Law { gp: Some(gp), ..weighted(Method::MiNsgp, moment, &log_w) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;
    use approx::assert_relative_eq;

    #[test]
    fn every_method_meets_the_task_with_a_positive_weight_of_the_same_size() {
        let data = made_up(1, 6.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let settings = TrainSettings::default();
        let laws = learn_laws(&Method::ALL, &frames, &settings, None).unwrap();
        let trace = second_moment(&frames).trace();
        for law in &laws {
            assert!(law.weight.clone().cholesky().is_some());
            let extra =
                if law.method == Method::FullW { 1.0 + settings.diagonal_share } else { 1.0 };
            assert_relative_eq!(law.weight.trace(), trace * extra, max_relative = 1e-9);
            let f = frames[17];
            let mean = law.expected(f, &DVector::zeros(24)).unwrap().mean;
            assert!((&f.jacobian * mean - &f.xdot).norm() < 1e-9);
        }
        assert_eq!(laws[2].shrinkage, Some(0.3));
        let short = learn_laws(&[Method::FullW], &frames[..90], &settings, None).unwrap();
        assert_eq!(short[0].shrinkage, Some(0.5));
    }
}

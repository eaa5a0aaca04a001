//! The methods: each is a choice of z and W in the one conditioned Gaussian of [`crate::posture`].
//!
//! ```text
//! plain-ik   W = I
//! w-ik       W = diag(w) by least squares
//! full-w     W = (1 - a) S + a W_LS + d I     S = mean qdot qdot^T,  W_LS: w-ik scaled to trace S
//! sb-m       W = I,        z constant: the mean of what W leaves unexplained
//! nsgp       W = I,        z = GP(q, xdot)
//! mi-nsgp    W = diag(w),  z = GP(q, xdot), both by the objective of the settings
//! full-w-gp  W of full-w,  z = GP(q, xdot)
//! promp      W and z of each phase from a movement primitive
//! gp         no W: qdot = GP(q, xdot), the task is not met
//! ```
//! `W` is scaled to the trace of `S`, so that it reads as a joint-velocity covariance, (rad/s)^2.

mod diagonal;
mod hyper;
mod inducing;
mod measured;
mod objective;
mod optimiser;
mod primitive;
mod process;
mod samples;
mod uncertainty;

#[doc(hidden)]
pub use measured::{with_kernel_search, with_weight_search};
pub use uncertainty::WeightUncertainty;

use super::dataset::{Frame, at_most, sparse};
use super::settings::TrainSettings;
use super::spread::autocorrelation_time;
use crate::files::InputError;
use crate::posture::{GpHyper, Method, PostureLaw, Process};
use nalgebra::{DMatrix, DVector};

/// Span of a single trial, s, below which little is known and more weight is put on `W_LS`.
const SHORT_SPAN_S: f64 = 4.0;
/// Weights are kept to this step of log w: the rest is noise of the optimiser.
const LOG_STEP: f64 = 1e-6;
/// Most frames behind a process that is relearned without a block, over those of an exact process.
const RELEARNED: usize = 8;

/// What a method learned.
#[derive(Debug, Clone)]
pub struct Law {
    /// The method.
    pub method: Method,
    /// z and W; without pull and noise.
    pub law: PostureLaw,
    /// log w of the diagonal part, n, mean zero; of full-w: that of its `W_LS`.
    pub log_weights: Option<Vec<f64>>,
    /// Share a of `W_LS` in full-w.
    pub shrinkage: Option<f64>,
    /// Kernel parameters, one for all joints or one for each.
    pub hypers: Vec<GpHyper>,
}

impl Law {
    /// The joint velocity that the law expects with an additional preferred velocity `pull`, rad/s.
    ///
    /// # Errors
    /// Where the chain is singular.
    pub fn expected(&self, frame: &Frame, pull: &DVector<f64>) -> Result<DVector<f64>, InputError> {
        self.law.expected(&frame.query(), pull).ok_or_else(singular)
    }

    /// The identified weights: the diagonal of W, scaled to mean 1.
    pub fn diagonal(&self) -> Vec<f64> {
        let d = self.law.weight.diagonal();
        let mean = d.mean();
        d.iter().map(|w| w / mean).collect()
    }
}

/// Mean zero, and no digits that only the optimiser believes in.
fn tidy(log_w: Vec<f64>) -> Vec<f64> {
    let mean = log_w.iter().sum::<f64>() / log_w.len() as f64;
    log_w.into_iter().map(|l| ((l - mean) / LOG_STEP).round() * LOG_STEP).collect()
}

/// Learns the laws of several methods from frames at 30 Hz.
///
/// `before` holds laws of the same methods from nearly the same data (all but a block): weights
/// start there, and processes keep weights, kernels and the number of inducing centres and only learn
/// their values anew; an exact one from no more frames than it takes.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn learn_laws(
    methods: &[Method],
    frames: &[&Frame],
    stature_m: f64,
    settings: &TrainSettings,
    before: Option<&[Law]>,
) -> Result<Vec<Law>, InputError> {
    let few = sparse(frames);
    // Relearned for their residuals only: enough frames to be nearly as good as with all of them.
    let most = before.map_or(usize::MAX, |laws| {
        let is_inducing = laws.iter().flat_map(|l| &l.law.processes).any(Process::is_inducing);
        settings.exact_samples * if is_inducing { RELEARNED } else { 1 }
    });
    let school = School {
        frames,
        few: at_most(&few, most),
        moment: second_moment(frames),
        stature_m,
        settings,
        before,
    };
    let searched = |m: &&Method| {
        m.identifies_weights() && (school.old(**m).is_none() || **m != Method::MiNsgp)
    };
    let log_w = if methods.iter().any(|m| searched(&m)) {
        let warm = before.and_then(|laws| {
            let mut simple = laws.iter().filter(|l| l.method != Method::MiNsgp);
            simple.find_map(|l| l.log_weights.as_deref())
        });
        let few = at_most(&school.few, settings.exact_samples);
        diagonal::least_squares(&few, &school.moment, warm)
    } else {
        vec![0.0; school.moment.nrows()]
    };
    methods.iter().map(|&method| school.learn(method, &log_w).ok_or_else(singular)).collect()
}

pub(super) fn singular() -> InputError {
    InputError::new("recordings", "hold a posture in which the hand cannot move in every direction")
        .remedy(
            "check the fit: an arm that is stretched to its end for long cannot be learned from",
        )
}

/// What all methods learn from.
struct School<'a> {
    frames: &'a [&'a Frame],
    /// At about 15 Hz.
    few: Vec<&'a Frame>,
    moment: DMatrix<f64>,
    stature_m: f64,
    settings: &'a TrainSettings,
    before: Option<&'a [Law]>,
}

impl School<'_> {
    fn old(&self, method: Method) -> Option<&Law> {
        self.before?.iter().find(|l| l.method == method)
    }

    fn law(&self, method: Method, weight: DMatrix<f64>) -> Law {
        let m = self.frames.first().map_or(0, |f| f.xdot.len());
        Law {
            method,
            law: PostureLaw::of_weight(weight, self.stature_m, m),
            log_weights: None,
            shrinkage: None,
            hypers: Vec::new(),
        }
    }

    fn learn(&self, method: Method, log_w: &[f64]) -> Option<Law> {
        Some(match method {
            Method::PlainIk => self.law(method, self.identity()),
            Method::WIk => self.weighted(method, log_w),
            Method::FullW => self.full(method, log_w),
            Method::SbM => {
                let mut law = self.law(method, self.identity());
                let targets = process::null_targets(&self.few, &vec![0.0; self.moment.nrows()])?;
                law.law.offset = Some(targets.row_mean().transpose());
                law
            }
            Method::Nsgp => {
                let targets = process::null_targets(&self.few, &vec![0.0; self.moment.nrows()])?;
                self.with_process(self.law(method, self.identity()), &targets)?
            }
            Method::FullWGp => {
                let law = self.full(method, log_w);
                let targets = self.unexplained(&law)?;
                self.with_process(law, &targets)?
            }
            Method::Gp => {
                let mut law = self.law(method, self.identity());
                law.law.is_direct = true;
                let n = self.moment.nrows();
                let mut targets = DMatrix::from_fn(self.few.len(), n, |i, c| self.few[i].qdot[c]);
                // A constant mean, as published.
                let mean = targets.row_mean();
                targets.row_iter_mut().for_each(|mut row| row -= &mean);
                law.law.offset = Some(mean.transpose());
                self.with_process(law, &targets)?
            }
            Method::MiNsgp => self.identified(log_w)?,
            Method::Promp => {
                let mut law = self.law(method, self.identity());
                law.law.primitive = Some(primitive::primitive(self.frames));
                law
            }
        })
    }

    fn identity(&self) -> DMatrix<f64> {
        let n = self.moment.nrows();
        DMatrix::identity(n, n) * (self.moment.trace() / n as f64)
    }

    fn weighted(&self, method: Method, log_w: &[f64]) -> Law {
        let law = self.law(method, diagonal_weight(&self.moment, log_w));
        Law { log_weights: Some(log_w.to_vec()), ..law }
    }

    fn full(&self, method: Method, log_w: &[f64]) -> Law {
        let a = self.settings.shrinkage.unwrap_or_else(|| default_shrinkage(self.frames));
        let n = self.moment.nrows();
        let floor = self.settings.diagonal_share * self.moment.trace() / n as f64;
        let weight = &self.moment * (1.0 - a)
            + diagonal_weight(&self.moment, log_w) * a
            + DMatrix::identity(n, n) * floor;
        Law { shrinkage: Some(a), log_weights: Some(log_w.to_vec()), ..self.law(method, weight) }
    }

    /// MI-NsGP: weights and kernel searched together, or those known before.
    fn identified(&self, log_w: &[f64]) -> Option<Law> {
        let method = Method::MiNsgp;
        let known = self.old(method).and_then(|l| Some((l.log_weights.clone()?, l.hypers.clone())));
        let (log_w, hypers) = if let Some(known) = known {
            known
        } else {
            let found = process::identify(&self.few, log_w, self.settings)?;
            (found.log_w, vec![found.hyper])
        };
        let targets = process::null_targets(&self.few, &log_w)?;
        let law = Law { hypers, ..self.weighted(method, &log_w) };
        self.with_process(law, &targets)
    }

    /// What W leaves unexplained of the few frames, N x n, rad/s.
    fn unexplained(&self, law: &Law) -> Option<DMatrix<f64>> {
        let still = DVector::zeros(self.moment.nrows());
        let rows: Option<Vec<_>> = self
            .few
            .iter()
            .map(|f| Some((&f.qdot - law.law.expected(&f.query(), &still)?).transpose()))
            .collect();
        Some(DMatrix::from_rows(&rows?))
    }

    /// Adds the process for targets (N x n, rad/s) of the few frames.
    fn with_process(&self, mut law: Law, targets: &DMatrix<f64>) -> Option<Law> {
        let n = targets.ncols();
        let settings = self.settings;
        if law.hypers.is_empty() {
            law.hypers = self.old(law.method).map_or_else(Vec::new, |l| l.hypers.clone());
        }
        let m = self.frames.first().map_or(0, |f| f.xdot.len());
        let free = if law.law.is_direct { 1.0 } else { (n - m) as f64 / n as f64 };
        let is_separate = settings.separate_kernels;
        if law.hypers.is_empty() || (is_separate && law.hypers.len() == 1) {
            let of = |t: &DMatrix<f64>| process::kernel_parameters(&self.few, t, free, settings);
            law.hypers = if is_separate {
                (0..n).map(|c| of(&targets.columns(c, 1).into_owned())).collect()
            } else {
                vec![of(targets)]
            };
        }
        let settings = &self.like_before(law.method);
        let processes: Option<Vec<Process>> = if law.hypers.len() == 1 {
            process::process(&self.few, targets, law.hypers[0], settings).map(|p| vec![p])
        } else {
            let one = |(c, hyper): (usize, &GpHyper)| {
                let own = targets.columns(c, 1).into_owned();
                Some(process::process(&self.few, &own, *hyper, settings)?.serving(vec![c]))
            };
            law.hypers.iter().enumerate().map(one).collect()
        };
        law.law.processes = processes?;
        Some(law)
    }

    /// The settings, or those that give a process as the one before: noise is what a law leaves of
    /// frames that it has not seen, and a coarser law would leave too much. The centres are chosen anew,
    /// because a process is surer than it should be about inputs that it knows as centres.
    fn like_before(&self, method: Method) -> TrainSettings {
        let settings = self.settings.clone();
        match self.old(method).and_then(|l| l.law.processes.first()) {
            Some(p) if p.is_inducing() => {
                TrainSettings { exact_samples: 1, inducing: Some(p.centre_count()), ..settings }
            }
            _ => settings,
        }
    }
}

/// The objective of the settings at log weights (n), nats per frame, kernel parameters fitted to them.
pub(super) fn objective_at(
    frames: &[&Frame],
    log_w: &[f64],
    settings: &TrainSettings,
) -> Option<f64> {
    process::objective_at(&at_most(frames, settings.search_samples), log_w, settings)
}

/// How well the frames determine the weights of MI-NsGP or of W-IK.
pub(super) fn weight_uncertainty(
    law: &Law,
    frames: &[&Frame],
    settings: &TrainSettings,
) -> Option<WeightUncertainty> {
    let log_w = law.log_weights.as_ref()?;
    let few = at_most(&sparse(frames), settings.search_samples);
    let samples = samples::Samples::new(&few);
    let targets = process::null_targets(&few, log_w)?;
    let rows: Vec<DVector<f64>> = targets.row_iter().map(|r| r.transpose()).collect();
    let temper = autocorrelation_time(&few, &rows)
        .map_or(1.0, |(time, step)| (step / (2.0 * time)).clamp(0.02, 1.0));
    // Without a process the kernel is that of white noise.
    let white = GpHyper { length_posture: 1e-3, length_velocity: 1e-3, noise_ratio: 1.0 };
    let hyper = law.hypers.first().copied().unwrap_or(white);
    let found = process::Identified { log_w: log_w.clone(), hyper };
    let problem = process::weight_problem(&samples, &few, &found, settings, temper)?;
    Some(uncertainty::uncertainty(&problem, log_w))
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

/// 0.3, or 0.5 for a single trial shorter than 4 s.
pub(super) fn default_shrinkage(frames: &[&Frame]) -> f64 {
    let is_single = frames.iter().all(|f| f.trial == frames[0].trial);
    let span = match (frames.first(), frames.last()) {
        (Some(a), Some(b)) => b.time_s - a.time_s,
        _ => 0.0,
    };
    if is_single && span < SHORT_SPAN_S { 0.5 } else { 0.3 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;
    use approx::assert_relative_eq;

    #[test]
    fn every_method_but_the_direct_one_meets_the_task() {
        let data = made_up(4, 6.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let settings = TrainSettings::default();
        let laws = learn_laws(&Method::ALL, &frames, 1.6, &settings, None).unwrap();
        let trace = second_moment(&frames).trace();
        for law in &laws {
            assert!(law.law.weight.clone().cholesky().is_some());
            let is_full = matches!(law.method, Method::FullW | Method::FullWGp);
            let extra = if is_full { 1.0 + settings.diagonal_share } else { 1.0 };
            assert_relative_eq!(law.law.weight.trace(), trace * extra, max_relative = 1e-9);
            let f = frames[17];
            let mean = law.expected(f, &DVector::zeros(24)).unwrap();
            let missed = (&f.jacobian * mean - &f.xdot).norm();
            assert_eq!(missed < 1e-9, law.method != Method::Gp, "{:?} {missed}", law.method);
            assert_eq!(law.law.processes.len(), usize::from(law.method.has_process()));
        }
        let short = learn_laws(&[Method::FullW], &frames[..90], 1.6, &settings, None).unwrap();
        assert_eq!(short[0].shrinkage, Some(0.5));
        // A kernel for each joint.
        let separate = TrainSettings { separate_kernels: true, ..settings };
        let own = learn_laws(&[Method::Nsgp], &frames[..200], 1.6, &separate, None).unwrap();
        assert_eq!(own[0].law.processes.len(), 24);
        let mean = own[0].expected(frames[17], &DVector::zeros(24)).unwrap();
        assert!((&frames[17].jacobian * mean - &frames[17].xdot).norm() < 1e-9);
    }
}

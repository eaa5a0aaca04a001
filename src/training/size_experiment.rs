//! How cost and quality grow with the number of frames: one simulated operator, more and more of the
//! same kind of movement, always judged on the same reaches that no law has seen.
//!
//! No recording is as long as that, so the movements are made up, and every result has to say so. They
//! come at 15 Hz, where each frame serves everything that is learned: N counts the samples of a process.

use super::dataset::{Dataset, Trial};
use super::evaluate::{GroupScore, TASK_FLOOR, group, learn_with_noise};
use super::methods::{Law, singular};
use super::settings::TrainSettings;
use super::simulated_movements::SimulatedMovements;
use crate::files::{InputError, peak_memory_mib, restart_peak_memory};
use crate::human::{Body, Side};
use crate::posture::{Floors, Method, Prediction, Process, Query};
use nalgebra::DVector;
use serde::Serialize;
use std::time::Instant;

/// Fewest frames that train: of fewer than two reaches nothing can be held out.
const FEWEST: usize = 100;

/// What is asked.
#[derive(Debug, Clone)]
pub struct SizeQuestion {
    /// Numbers of frames that train, N.
    pub counts: Vec<usize>,
    /// The methods.
    pub methods: Vec<Method>,
    /// Frames that test, at least; whole reaches.
    pub test_frames: usize,
    /// Seed of the movements.
    pub seed: u64,
}

impl Default for SizeQuestion {
    fn default() -> Self {
        Self {
            counts: vec![250, 500, 1000, 2000, 4000, 8000, 16_000, 32_000, 100_000],
            methods: vec![Method::MiNsgp, Method::FullW, Method::FullWGp],
            test_frames: 1500,
            seed: 20,
        }
    }
}

/// What one method reached with some number of frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeRow {
    /// Name of the method.
    pub method: &'static str,
    /// Frames that trained, N.
    pub samples: usize,
    /// Inducing centres of the process; 0 where it is exact, none without a process.
    pub centres: Option<usize>,
    /// Time of the training (weights, kernel, process and noise), s.
    pub train_s: f64,
    /// Time of one prediction with its covariance, s.
    pub predict_s: f64,
    /// Mean held-out log-likelihood of the joint velocity, nats per row.
    pub ll_q: f64,
    /// RMSE of the held-out joint velocity, rad/s.
    pub rmse_q: f64,
    /// The same over the rms of the joint velocity.
    pub relative_rmse_q: f64,
    /// Most memory of the program during the training, its frames included, MiB; none where the
    /// system does not tell.
    pub peak_mib: Option<f64>,
}

/// Cost and quality over the number of frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizeExperiment {
    /// Always true: nobody was recorded.
    pub simulated: bool,
    /// Name of the body.
    pub body: String,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Frames and reaches that test.
    pub test_frames: usize,
    /// Reaches among them.
    pub test_reaches: usize,
    /// Most samples behind an exact process.
    pub exact_samples: usize,
    /// Standard deviation of the task velocity that likelihoods assume, m/s and rad/s.
    pub task_sd: f64,
    /// Seed of the movements.
    pub seed: u64,
    /// By N, then by method.
    pub rows: Vec<SizeRow>,
}

/// Told where the experiment stands (stage, done, total); answers whether to go on.
pub(super) type Told<'a> = &'a (dyn Fn(&'static str, usize, usize) -> bool + Sync);

/// Trains each method on more and more frames; none when told to stop.
///
/// # Errors
/// Where a number of frames or a setting is out of range, or the operator cannot reach its workplace.
pub fn size_experiment(
    body: &Body,
    question: &SizeQuestion,
    settings: &TrainSettings,
    told: Told,
) -> Result<Option<SizeExperiment>, InputError> {
    settings.check()?;
    let mut counts = question.counts.clone();
    counts.sort_unstable();
    counts.dedup();
    if let Some(few) = counts.iter().find(|c| **c < FEWEST) {
        return Err(InputError::new("counts", format!("{few} frames are too few to learn from"))
            .remedy(format!("give numbers of at least {FEWEST}")));
    }
    let most = counts.last().copied().unwrap_or(0);
    let Some((test, train)) = movements(body, question, most, told)? else { return Ok(None) };
    let mut result = SizeExperiment {
        simulated: true,
        body: body.name.clone(),
        rate_hz: test.first().map_or(0.0, |t| t.rate_hz),
        test_frames: test.iter().map(|t| t.q.len()).sum(),
        test_reaches: test.len(),
        exact_samples: settings.exact_samples,
        task_sd: TASK_FLOOR,
        seed: question.seed,
        rows: Vec::new(),
    };
    let total = counts.len() * question.methods.len();
    for count in counts {
        let mut trials = test.clone();
        trials.extend(first_frames(&train, count));
        let dataset = Dataset::new(&trials, body, Side::Right)?;
        drop(trials);
        for &method in &question.methods {
            if !told("training", result.rows.len(), total) {
                return Ok(None);
            }
            result.rows.push(row(&dataset, result.test_frames, method, settings)?);
        }
    }
    told("training", total, total);
    Ok(Some(result))
}

type Split = (Vec<Trial>, Vec<Trial>);

/// Reaches that test, and those that train with at least `most` frames.
fn movements(
    body: &Body,
    question: &SizeQuestion,
    most: usize,
    told: Told,
) -> Result<Option<Split>, InputError> {
    let mut source = SimulatedMovements::new(body, Side::Right, false, question.seed)?;
    let (mut test, mut train) = (Vec::new(), Vec::new());
    let (mut tests, mut trains) = (0, 0);
    let total = question.test_frames + most;
    while tests < question.test_frames || trains < most {
        if !told("simulating", (tests + trains).min(total), total) {
            return Ok(None);
        }
        for reach in source.more()? {
            let trial = reach.sparse_trial("simulated operator".to_owned());
            if tests < question.test_frames {
                tests += trial.q.len();
                test.push(trial);
            } else {
                trains += trial.q.len();
                train.push(trial);
            }
        }
    }
    told("simulating", total, total);
    Ok(Some((test, train)))
}

/// The first `count` frames; the last trial is cut.
fn first_frames(trials: &[Trial], count: usize) -> Vec<Trial> {
    let mut left = count;
    let mut first = Vec::new();
    for trial in trials {
        let size = trial.q.len().min(left);
        if size == 0 {
            break;
        }
        left -= size;
        first.push(Trial {
            stepping: Vec::new(),
            turn: Vec::new(),
            source: trial.source.clone(),
            rate_hz: trial.rate_hz,
            q: trial.q[..size].to_vec(),
            qdot: trial.qdot[..size].to_vec(),
        });
    }
    first
}

/// Trains on all frames after the first `test_frames`, and judges on those.
fn row(
    dataset: &Dataset,
    test_frames: usize,
    method: Method,
    settings: &TrainSettings,
) -> Result<SizeRow, InputError> {
    let train: Vec<usize> = (test_frames..dataset.frames.len()).collect();
    restart_peak_memory();
    let begun = Instant::now();
    let law = learn_with_noise(dataset, &train, method, settings, false)?;
    let train_s = begun.elapsed().as_secs_f64();
    let peak_mib = peak_memory_mib();
    let begun = Instant::now();
    let score = score(dataset, test_frames, &law, settings)?;
    let predict_s = begun.elapsed().as_secs_f64() / test_frames.max(1) as f64;
    let centres = |p: &Process| if p.is_inducing() { p.centre_count() } else { 0 };
    Ok(SizeRow {
        method: method.name(),
        samples: train.len(),
        centres: law.law.processes.first().map(centres),
        train_s,
        predict_s,
        ll_q: score.ll_q,
        rmse_q: score.rmse_q,
        relative_rmse_q: score.relative_rmse_q,
        peak_mib,
    })
}

/// Figures over all of the first `test_frames`.
fn score(
    dataset: &Dataset,
    test_frames: usize,
    law: &Law,
    settings: &TrainSettings,
) -> Result<GroupScore, InputError> {
    let test = &dataset.frames[..test_frames];
    let floors = Floors {
        task: DVector::from_element(dataset.task_rows(), TASK_FLOOR * TASK_FLOOR),
        null_rad_s: settings.null_floor_rad_s,
    };
    let posteriors = law.law.posteriors().ok_or_else(singular)?;
    let queries: Vec<Query> = test.iter().map(super::dataset::Frame::query).collect();
    let growth = law.law.growth(&posteriors, &queries);
    let still = DVector::zeros(dataset.joints.len());
    let predictions: Option<Vec<Prediction>> =
        queries.iter().zip(&growth).map(|(q, g)| law.law.predict(q, &still, g, &floors)).collect();
    let predictions = predictions.ok_or_else(singular)?;
    Ok(group(test.iter().zip(&predictions).collect(), &floors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn more_frames_predict_better() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let question = SizeQuestion {
            counts: vec![1200, 150],
            methods: vec![Method::FullW, Method::FullWGp],
            test_frames: 300,
            seed: 3,
        };
        // A small limit, so that the larger number rests on inducing centres.
        let settings = TrainSettings { exact_samples: 600, ..TrainSettings::default() };
        let go = |_: &'static str, _: usize, _: usize| true;
        let found = size_experiment(&body, &question, &settings, &go).unwrap().unwrap();
        assert!(found.simulated && found.test_frames >= 300);
        assert_eq!(
            found.rows.iter().map(|r| r.samples).collect::<Vec<_>>(),
            [150, 150, 1200, 1200]
        );
        assert_eq!(found.rows[1].centres, Some(0));
        assert!(found.rows[3].centres.is_some_and(|c| c > 0));
        assert!(found.rows[3].ll_q > found.rows[1].ll_q);
        let stop = |_: &'static str, _: usize, _: usize| false;
        assert!(size_experiment(&body, &question, &settings, &stop).unwrap().is_none());
        let few = SizeQuestion { counts: vec![10], ..question };
        assert!(size_experiment(&body, &few, &settings, &go).is_err());
    }
}

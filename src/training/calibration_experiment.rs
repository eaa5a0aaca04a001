//! The calibration experiment: do the bands of the default sampler hold what they promise, whatever
//! makes people differ?
//!
//! ```text
//! truth {law + white noise, law + correlated noise (0.4 s), law + a lasting personal offset}
//!   x dt {0.2 s, 0.04 s} = six cells, 20 trajectories train, 50 others test, 5R chain, law unknown
//! ```
//! One sampler for all cells, not told which: MI-NsGP with the pull, shares of the noise and
//! calibration from the 20 trajectories. Beside it the published sampler, independent at each step, and
//! an oracle that knows the truth.

use super::dataset::{DataRow, Dataset, Fold};
use super::methods::learn_laws;
use super::rollout_check::{Bands, band_end, bands, learn_repetitions, pieces};
use super::settings::TrainSettings;
use super::spread::learn_attraction;
use super::toy5r::{
    BASE, TIP, ToyConstants, ToyNoise, ToyTrajectory, TrajectoryTruth, oracle_rollouts,
    planar_urdf, trajectories,
};
use crate::files::InputError;
use crate::kinematics::{Linkage, parse_urdf};
use crate::posture::{Coupling, Hold, Method, Noise, NoiseShares, PostureLaw, Sampling};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Trajectories that train; the others of the truth test.
const TRAIN: usize = 20;
/// Rollouts of a band.
const ROLLOUTS: u32 = 200;
/// The cells: name, noise, time step (s).
const CELLS: [(&str, ToyNoise, f64); 6] = [
    ("white noise", ToyNoise::White, 0.2),
    ("white noise", ToyNoise::White, 0.04),
    ("correlated, 0.4 s", ToyNoise::Correlated { tau_s: 0.4 }, 0.2),
    ("correlated, 0.4 s", ToyNoise::Correlated { tau_s: 0.4 }, 0.04),
    ("personal offset", ToyNoise::PersonalOffset, 0.2),
    ("personal offset", ToyNoise::PersonalOffset, 0.04),
];

/// What one cell showed.
#[derive(Debug, Clone, Serialize)]
pub struct CalibrationCell {
    /// What makes people differ.
    pub truth: &'static str,
    /// Time step, s.
    pub dt_s: f64,
    /// The default sampler.
    pub own: Bands,
    /// The published sampler: independent at each step.
    pub independent: Bands,
    /// The sampler that knows the truth.
    pub oracle: Bands,
    /// Shares of the noise that the default sampler found.
    pub shares: NoiseShares,
    /// Correlation time that it found, s.
    pub correlation_time_s: f64,
    /// Factor by which it was calibrated.
    pub calibration: f64,
    /// Whether it pulls towards the postures of the training trajectories.
    pub is_pulled: bool,
}

/// Runs the six cells. `tell` hears how many are done and returns false to stop.
///
/// # Errors
/// Where a cell is singular.
pub fn run_calibration(
    seed: u64,
    settings: &TrainSettings,
    tell: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Option<Vec<CalibrationCell>>, InputError> {
    let mut cells = Vec::new();
    for (i, (name, noise, dt)) in CELLS.into_iter().enumerate() {
        if !tell(i) {
            return Ok(None);
        }
        cells.push(cell(name, noise, dt, seed, settings)?);
    }
    Ok(Some(cells))
}

fn cell(
    name: &'static str,
    noise: ToyNoise,
    dt: f64,
    seed: u64,
    settings: &TrainSettings,
) -> Result<CalibrationCell, InputError> {
    let truth = TrajectoryTruth::draw(seed, &ToyConstants::default(), noise, dt)?;
    let movements = trajectories(seed, &truth)?;
    let dataset = dataset(&truth.constants, &movements)?;
    let pick = |trains: bool| {
        let wanted = |i: &usize| (dataset.frames[*i].trial < TRAIN) == trains;
        (0..dataset.frames.len()).filter(wanted).collect::<Vec<_>>()
    };
    let fold = Fold { train: pick(true), test: pick(false) };
    let train = dataset.select(&fold.train);
    let laws = learn_laws(&[Method::MiNsgp], &train, 1.0, settings, None)?;
    let Some(law) = laws.into_iter().next() else {
        return Err(InputError::new("experiment", "has no law"));
    };
    let repetitions = learn_repetitions(&dataset, &fold.train, &law, settings)?;
    let (found, calibration) = (repetitions.noise, repetitions.calibration);
    let attraction =
        if repetitions.is_pulled { learn_attraction(&dataset, &train, settings) } else { None };
    let sampled = PostureLaw { attraction, noise: found.clone(), ..law.law.clone() };
    // The published sampler has no pull, and noise that is not calibrated.
    let plain = Noise { factor: &found.factor / calibration, ..found.clone() };
    let published = PostureLaw { noise: plain, ..law.law };
    let test = dataset.select(&fold.test);
    let paths = pieces(&test);
    let seed = settings.seed;
    let (own, _) = bands(&dataset, &sampled, &paths, ROLLOUTS, (seed, Sampling::Pathwise))?;
    let (independent, _) =
        bands(&dataset, &published, &paths, ROLLOUTS, (seed, Sampling::Independent))?;
    Ok(CalibrationCell {
        truth: name,
        dt_s: dt,
        own,
        independent,
        oracle: oracle(&truth, &movements[TRAIN..])?,
        shares: found.shares,
        correlation_time_s: found.correlation_time_s,
        calibration,
        is_pulled: repetitions.is_pulled,
    })
}

fn dataset(constants: &ToyConstants, movements: &[ToyTrajectory]) -> Result<Dataset, InputError> {
    let model = parse_urdf(Path::new("5R"), &planar_urdf(constants))?;
    let chain =
        Linkage::chain(&model, BASE, TIP).map_err(|e| InputError::new("5R", e.to_string()))?;
    let rows: Vec<DataRow> = movements
        .iter()
        .enumerate()
        .flat_map(|(trial, m)| {
            (0..m.qdot.len()).map(move |k| DataRow {
                q: m.q[k].to_vec(),
                xdot: m.xdot[k].to_vec(),
                qdot: m.qdot[k].to_vec(),
                trial,
                time_s: m.time_s[k],
            })
        })
        .collect();
    Dataset::of_rows("5R", &rows, Coupling::of_chain(chain, Hold::Planar))
}

/// Bands of samples of the truth itself.
fn oracle(truth: &TrajectoryTruth, movements: &[ToyTrajectory]) -> Result<Bands, InputError> {
    let each: Result<Vec<(Bands, f64)>, InputError> = movements
        .par_iter()
        .enumerate()
        .map(|(i, m)| {
            let samples = oracle_rollouts(m, truth, ROLLOUTS, i as u64)?;
            let mut sum = Bands::default();
            let mut count = 0.0;
            // The last row of q is beyond the last row of the data.
            for k in 1..m.qdot.len() {
                for j in 0..m.q[k].len() {
                    let mut values: Vec<f64> = samples.iter().map(|s| s[k][j]).collect();
                    values.sort_by(f64::total_cmp);
                    let at = |p: f64| band_end(&values, p);
                    let inside =
                        |a: f64, b: f64| f64::from(u8::from(m.q[k][j] >= a && m.q[k][j] <= b));
                    sum.coverage_90 += inside(at(0.05), at(0.95));
                    sum.coverage_50 += inside(at(0.25), at(0.75));
                    sum.width_90_deg += (at(0.95) - at(0.05)).to_degrees();
                    if k + 1 == m.qdot.len() {
                        sum.end_coverage_90 += inside(at(0.05), at(0.95)) / m.q[k].len() as f64;
                    }
                    count += 1.0;
                }
            }
            Ok((sum, count))
        })
        .collect();
    let each = each?;
    let count: f64 = each.iter().map(|e| e.1).sum();
    let of = |pick: fn(&Bands) -> f64| each.iter().map(|e| pick(&e.0)).sum::<f64>();
    Ok(Bands {
        coverage_50: of(|b| b.coverage_50) / count,
        coverage_90: of(|b| b.coverage_90) / count,
        end_coverage_90: of(|b| b.end_coverage_90) / each.len().max(1) as f64,
        width_90_deg: of(|b| b.width_90_deg) / count,
    })
}

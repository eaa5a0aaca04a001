//! Rollouts along held-out paths: how far from the truth, how they drift, and whether their bands
//! hold what they promise.
//!
//! ```text
//! path error   mean over time of the rms over joints of q_rollout - q_recorded, without noise, deg
//! drift        rms over joints of the change of posture after three trips there and back, deg
//! coverage     share of recorded joint angles inside the central 50 and 90 % band of rollouts
//! LL           log-likelihood of a whole held-out trajectory of joint velocities, nats per frame
//! ```
//! Every walk starts from the person's own first posture. Where one ends early, its last posture counts.
//!
//! Before it is judged the noise is *calibrated*: multiplied by the factor at which the 90 % band of
//! rollouts on blocks of the training part, by laws that had not seen them, covers 90 % there.

use super::dataset::{Dataset, Fold, Frame, runs};
use super::evaluate::log_normal;
use super::methods::{Law, learn_laws, singular};
use super::noise_fit::learn_noise;
use super::settings::TrainSettings;
use super::spread::{learn_attraction, pull, unseen_residuals};
use crate::files::InputError;
use crate::math::Pose;
use crate::math::redundancy::{null_space_basis, weighted_pseudo_inverse};
use crate::math::stats::quantile_of_sorted;
use crate::math::stream::{Purpose, stream};
use crate::posture::{
    Floors, HandPath, Noise, PostureLaw, Rollout, Sampler, Sampling, Start, roll_out,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Rollouts of a band, and while the noise is calibrated.
pub(super) const ROLLOUTS: u32 = 100;
const CALIBRATION_ROLLOUTS: u32 = 40;
/// Coverage at which the noise is calibrated. The quantiles of 40 rollouts lie inside those of the
/// distribution, so that a perfect sampler would show 0.856; a little more is asked, because movements
/// nobody has seen differ more than blocks of the training part do.
const TARGET: f64 = 0.88;
/// Range of the calibration factor, and halvings of it.
const FACTORS: (f64, f64) = (0.4, 3.0);
const HALVINGS: usize = 6;
/// Longest path of a walk, frames: bands over minutes would say nothing about a movement.
const LONGEST_RUN: usize = 300;
/// Dimensions of the largest Gaussian of a whole trajectory.
const LARGEST_GAUSSIAN: usize = 1500;

/// Figures of rollouts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RolloutScore {
    /// Mean joint error along held-out paths without the pull, deg.
    pub path_error_deg: f64,
    /// The same with the pull.
    pub pulled_path_error_deg: f64,
    /// Change of posture after three trips there and back, without and with the pull, deg.
    pub drift_deg: (f64, f64),
    /// What the bands held.
    pub bands: Bands,
    /// Log-likelihood of whole trajectories, nats per frame.
    pub trajectory_ll: f64,
    /// The factor by which calibration multiplied the noise.
    pub calibration: f64,
    /// Whether people were drawn with the pull: blocks of the training part decide.
    pub is_pulled: bool,
    /// Share of the walks that could not continue.
    pub reach_exceeded_share: f64,
}

/// What bands of rollouts held.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bands {
    /// Share of joint angles inside the 50 % band, over all times.
    pub coverage_50: f64,
    /// Inside the 90 % band.
    pub coverage_90: f64,
    /// Inside the 90 % band at the end of each path.
    pub end_coverage_90: f64,
    /// Mean width of the 90 % band, deg.
    pub width_90_deg: f64,
}

/// Judges a law (with its noise) on the test part of a fold.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn check_rollouts(
    dataset: &Dataset,
    fold: &Fold,
    law: &Law,
    settings: &TrainSettings,
    floors: &Floors,
) -> Result<RolloutScore, InputError> {
    let train = dataset.select(&fold.train);
    let pulled_settings = TrainSettings { has_attraction: true, ..settings.clone() };
    // The direct process has no task to be pulled along.
    let attraction = learn_attraction(dataset, &train, &pulled_settings);
    let test = dataset.select(&fold.test);
    let paths = pieces(&test);
    let free = law.law.clone();
    let pulled = PostureLaw { attraction: attraction.clone(), ..law.law.clone() };
    let (sampled, walking) = sampled_law(dataset, &fold.train, law, settings)?;
    let (bands, reach_exceeded_share) =
        bands(dataset, &sampled, &paths, ROLLOUTS, (settings.seed, settings.sampling))?;
    Ok(RolloutScore {
        path_error_deg: path_error_deg(dataset, &free, &test),
        pulled_path_error_deg: path_error_deg(dataset, &pulled, &test),
        drift_deg: (drift_deg(dataset, &free, &paths), drift_deg(dataset, &pulled, &paths)),
        bands,
        trajectory_ll: trajectory_ll(dataset, &sampled, &paths, floors)?,
        calibration: walking.calibration,
        is_pulled: walking.is_pulled,
        reach_exceeded_share,
    })
}

/// The law by which people are drawn who walk what `train` does not hold: with its pull where that
/// helps and its noise, calibrated but for the published sampler.
pub(super) fn sampled_law(
    dataset: &Dataset,
    train: &[usize],
    law: &Law,
    settings: &TrainSettings,
) -> Result<(PostureLaw, Walking), InputError> {
    let mut walking = learn_walking(dataset, train, law, settings)?;
    if settings.sampling == Sampling::Independent {
        // The published sampler as it is.
        walking.noise.factor /= walking.calibration;
        walking.calibration = 1.0;
    }
    let frames = dataset.select(train);
    let attraction =
        if walking.is_pulled { learn_attraction(dataset, &frames, settings) } else { None };
    let noise = walking.noise.clone();
    Ok((PostureLaw { attraction, noise, ..law.law.clone() }, walking))
}

/// Uninterrupted paths of a length that a band makes sense for.
pub(super) fn pieces<'a>(frames: &[&'a Frame]) -> Vec<Vec<&'a Frame>> {
    let all = runs(frames);
    all.iter()
        .flat_map(|run| run.chunks(LONGEST_RUN))
        .filter(|p| p.len() > 2)
        .map(<[_]>::to_vec)
        .collect()
}

/// How a law walks: its noise, calibrated, and whether the pull helps it.
#[derive(Debug, Clone)]
pub struct Walking {
    /// The noise, multiplied by `calibration`.
    pub noise: Noise,
    /// The factor at which the 90 % band covers 90 % on blocks of the training part.
    pub calibration: f64,
    /// Whether to pull towards the person's own postures: asked for, and the path error on blocks of
    /// the training part is smaller with it.
    pub is_pulled: bool,
    /// Mean path error on those blocks without and with the pull, deg; none where it was not asked for.
    pub pull_error_deg: Option<(f64, f64)>,
}

/// Learns how a law walks from blocks of `train`, each walked by a law that has not seen it.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn learn_walking(
    dataset: &Dataset,
    train: &[usize],
    law: &Law,
    settings: &TrainSettings,
) -> Result<Walking, InputError> {
    let inner = dataset.blocks_of(train);
    let laws = std::slice::from_ref(law);
    let stature_m = dataset.coupling.stature_m();
    let mut blocks: Vec<(PostureLaw, Vec<&Frame>)> = Vec::new();
    for fold in &inner {
        let frames = dataset.select(&fold.train);
        let own = learn_laws(&[law.method], &frames, stature_m, settings, Some(laws))?;
        let attraction = learn_attraction(dataset, &frames, settings);
        if let Some(own) = own.into_iter().next() {
            blocks.push((PostureLaw { attraction, ..own.law }, dataset.select(&fold.test)));
        }
    }
    let pull_error_deg = settings.has_attraction.then(|| {
        let mean_error = |is_pulled: bool| {
            let (mut sum, mut count) = (0.0, 0.0);
            for (law, test) in &blocks {
                let free = PostureLaw { attraction: None, ..law.clone() };
                let used = if is_pulled { law } else { &free };
                sum += test.len() as f64 * path_error_deg(dataset, used, test);
                count += test.len() as f64;
            }
            sum / f64::max(count, 1.0)
        };
        (mean_error(false), mean_error(true))
    });
    let is_pulled = pull_error_deg.is_some_and(|(free, pulled)| pulled < free);
    if !is_pulled {
        for (law, _) in &mut blocks {
            law.attraction = None;
        }
    }
    let unseen = unseen_residuals(dataset, &inner, laws, settings, is_pulled)?;
    let noise = learn_noise(&law.law, &unseen[0]);
    let coverage = |factor: f64| -> Result<f64, InputError> {
        let (mut sum, mut count) = (0.0, 0.0);
        for (own, test) in &blocks {
            let scaled = Noise { factor: &noise.factor * factor, ..noise.clone() };
            let own = PostureLaw { noise: scaled, ..own.clone() };
            let how = (settings.seed, Sampling::Pathwise);
            let (b, _) = bands(dataset, &own, &pieces(test), CALIBRATION_ROLLOUTS, how)?;
            sum += test.len() as f64 * b.coverage_90;
            count += test.len() as f64;
        }
        Ok(sum / f64::max(count, 1.0))
    };
    // More noise covers more: halve the interval in the logarithm.
    let (mut low, mut high) = (FACTORS.0.ln(), FACTORS.1.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if coverage(middle.exp())? < TARGET { low = middle } else { high = middle }
    }
    let calibration = (0.5 * (low + high)).exp();
    let noise = Noise { factor: &noise.factor * calibration, ..noise };
    Ok(Walking { noise, calibration, is_pulled, pull_error_deg })
}

fn walk_path(dataset: &Dataset, law: &PostureLaw, run: &[&Frame]) -> (HandPath, Start) {
    // Times from zero, and exactly even: a piece may start anywhere in its recording.
    let step = (run[run.len() - 1].time_s - run[0].time_s) / (run.len() - 1) as f64;
    let time: Vec<f64> = (0..run.len()).map(|i| step * i as f64).collect();
    let hands: Vec<Pose> = run.iter().map(|f| f.hand).collect();
    let path = HandPath::new(&dataset.coupling, law, time, hands);
    (path, Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false })
}

/// Mean joint error (deg) along the hand paths of the frames, in closed loop without noise.
pub fn path_error_deg(dataset: &Dataset, law: &PostureLaw, test: &[&Frame]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for run in runs(test).iter().filter(|r| r.len() > 1) {
        let (path, start) = walk_path(dataset, law, run);
        let rollout = roll_out(&dataset.coupling, law, &path, &start, None);
        for (q, frame) in rollout.q.iter().zip(run) {
            sum += rms_deg(&(q - &frame.q));
        }
        count += run.len();
    }
    sum / f64::from(u32::try_from(count.max(1)).unwrap_or(u32::MAX))
}

fn rms_deg(difference: &DVector<f64>) -> f64 {
    (difference.norm_squared() / difference.len() as f64).sqrt().to_degrees()
}

/// Mean change of posture (rms over joints, deg) after three trips there and back.
fn drift_deg(dataset: &Dataset, law: &PostureLaw, paths: &[Vec<&Frame>]) -> f64 {
    let drifts: Vec<f64> = paths
        .iter()
        .map(|run| {
            let there: Vec<&Frame> = run.clone();
            let back: Vec<&Frame> = run.iter().rev().skip(1).copied().collect();
            let trips: Vec<&Frame> = (0..3)
                .flat_map(|trip| {
                    let skip = usize::from(trip > 0);
                    there.iter().skip(skip).chain(&back).copied().collect::<Vec<_>>()
                })
                .collect();
            let step = (run[run.len() - 1].time_s - run[0].time_s) / (run.len() - 1) as f64;
            let time: Vec<f64> = (0..trips.len()).map(|i| step * i as f64).collect();
            let hands: Vec<Pose> = trips.iter().map(|f| f.hand).collect();
            let path = HandPath::new(&dataset.coupling, law, time, hands);
            let start = Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false };
            let rollout = roll_out(&dataset.coupling, law, &path, &start, None);
            rollout.q.last().map_or(0.0, |q| rms_deg(&(q - &run[0].q)))
        })
        .collect();
    crate::math::stats::mean(&drifts)
}

/// People drawn by a sampler, who walk along the hand path of the p-th piece.
pub(super) fn walks(
    dataset: &Dataset,
    law: &PostureLaw,
    sampler: &Sampler,
    (p, run): (usize, &[&Frame]),
    (rollouts, seed): (u32, u64),
) -> Vec<Rollout> {
    let (path, start) = walk_path(dataset, law, run);
    let dt = (run[run.len() - 1].time_s - run[0].time_s) / (run.len() - 1) as f64;
    (0..rollouts)
        .into_par_iter()
        .map(|r| {
            let mut rng = stream(seed, Purpose::Posture, p as u32, r);
            let person = sampler.draw(&mut rng, run.len(), dt);
            roll_out(&dataset.coupling, law, &path, &start, Some(&person))
        })
        .collect()
}

/// Bands of sampled rollouts along paths, and the share of walks that could not continue.
pub(super) fn bands(
    dataset: &Dataset,
    law: &PostureLaw,
    paths: &[Vec<&Frame>],
    rollouts: u32,
    (seed, sampling): (u64, Sampling),
) -> Result<(Bands, f64), InputError> {
    let sampler = Sampler::new(law, sampling).ok_or_else(singular)?;
    let (mut sum, mut count, mut ended) = (Bands::default(), 0.0, 0);
    let mut ends = 0.0;
    for (p, run) in paths.iter().enumerate() {
        let walks = walks(dataset, law, &sampler, (p, run), (rollouts, seed));
        ended += walks.iter().filter(|w| w.reach_exceeded_at.is_some()).count();
        let n = run[0].q.len();
        let mut values = vec![0.0; walks.len()];
        for (k, frame) in run.iter().enumerate().skip(1) {
            for j in 0..n {
                values.iter_mut().zip(&walks).for_each(|(v, w)| *v = w.q[k][j]);
                values.sort_by(f64::total_cmp);
                let at = |p: f64| quantile_of_sorted(&values, p);
                let inside = |low: f64, high: f64| {
                    f64::from(u8::from(frame.q[j] >= low && frame.q[j] <= high))
                };
                let (low, high) = (at(0.05), at(0.95));
                let within = inside(low, high);
                sum.coverage_90 += within;
                sum.coverage_50 += inside(at(0.25), at(0.75));
                sum.width_90_deg += (high - low).to_degrees();
                count += 1.0;
                if k + 1 == run.len() {
                    sum.end_coverage_90 += within;
                    ends += 1.0;
                }
            }
        }
    }
    let of = |v: f64, c: f64| v / f64::max(c, 1.0);
    let bands = Bands {
        coverage_50: of(sum.coverage_50, count),
        coverage_90: of(sum.coverage_90, count),
        end_coverage_90: of(sum.end_coverage_90, ends),
        width_90_deg: of(sum.width_90_deg, count),
    };
    let walks = f64::from(rollouts) * paths.len().max(1) as f64;
    Ok((bands, ended as f64 / walks))
}

/// Log-likelihood of trajectories of joint velocities under noise that is correlated in time, nats per
/// frame: the residuals in the null space as one Gaussian.
fn trajectory_ll(
    dataset: &Dataset,
    law: &PostureLaw,
    paths: &[Vec<&Frame>],
    floors: &Floors,
) -> Result<f64, InputError> {
    let posteriors = law.posteriors().ok_or_else(singular)?;
    let (mut sum, mut count) = (0.0, 0.0);
    let n = dataset.joints.len();
    let k = if law.is_direct { n } else { n - dataset.task_rows() };
    for run in paths.iter().flat_map(|p| p.chunks((LARGEST_GAUSSIAN / k).max(2))) {
        let queries: Vec<_> = run.iter().map(|f| f.query()).collect();
        let growth = law.growth(&posteriors, &queries);
        let mut residuals = DVector::zeros(k * run.len());
        let mut roots = Vec::with_capacity(run.len());
        for (t, (frame, growth)) in run.iter().zip(&growth).enumerate() {
            let pulled = pull(law.attraction.as_ref(), frame, dataset.coupling.stature_m());
            let mean = law.expected(&frame.query(), &pulled).ok_or_else(singular)?;
            let mut root = law.noise.factor.clone() * law.noise.gain(frame.xdot.as_slice());
            for (mut row, g) in root.row_iter_mut().zip(growth.iter()) {
                row *= *g;
            }
            let left = &frame.qdot - mean;
            if law.is_direct {
                residuals.rows_mut(t * k, k).copy_from(&left);
                roots.push(root);
                continue;
            }
            let weight =
                law.primitive.as_ref().map_or_else(|| law.weight.clone(), |p| p.at(frame.phase).1);
            let pinv = weighted_pseudo_inverse(&frame.jacobian, &weight).ok_or_else(singular)?;
            let vt = null_space_basis(&frame.jacobian).transpose();
            residuals.rows_mut(t * k, k).copy_from(&(&vt * left));
            roots.push(&vt * (&root - pinv * (&frame.jacobian * &root)));
        }
        let mut covariance = DMatrix::zeros(k * run.len(), k * run.len());
        for (a, ra) in roots.iter().enumerate() {
            for (b, rb) in roots.iter().enumerate().take(a + 1) {
                let lag = run[a].time_s - run[b].time_s;
                let block = ra * rb.transpose() * law.noise.correlation(lag);
                covariance.view_mut((a * k, b * k), (k, k)).copy_from(&block);
                covariance.view_mut((b * k, a * k), (k, k)).copy_from(&block.transpose());
            }
        }
        for i in 0..covariance.nrows() {
            covariance[(i, i)] += floors.null_rad_s.powi(2);
        }
        sum += log_normal(&residuals, covariance);
        count += run.len() as f64;
    }
    Ok(sum / f64::max(count, 1.0))
}

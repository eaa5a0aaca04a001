//! Rollouts along held-out paths: how far from the truth, how they drift, and whether their bands
//! hold what they promise.
//!
//! ```text
//! path error   mean over time of the rms over joints of q_rollout - q_recorded, without noise, deg
//! rest         rms joint speed while the hand rests: of repetitions drawn by the law, and recorded, deg/s
//! drift        rms over joints of the change of posture after three trips there and back, deg
//! coverage     share of recorded joint angles inside the central 50 and 90 % band of rollouts
//! LL           log-likelihood of a whole held-out trajectory of joint velocities, nats per frame
//! ```
//! Every repetition starts from the person's own first posture. Where one ends early, its last posture counts.
//!
//! Before it is judged the noise is *calibrated*: multiplied by the factor at which the 90 % band of
//! rollouts on held-out parts of the training part, by laws that had not seen them, covers 90 % there.
//! Of several trials whole ones are held out. A single trial does not show how repetitions differ: beside
//! blocks of it, its later parts are held out after the earlier ones.
//!
//! A band from R rollouts ends at the p (R + 1)-th of them, in order: there another draw of the same
//! sampler lies inside as often as promised, whatever R.

use super::dataset::{Dataset, Fold, Frame, runs};
use super::evaluate::log_normal;
use super::methods::{Law, learn_laws, singular};
use super::noise_fit::{at_rest, hand_times, learn_noise, no_noise};
use super::settings::{PullRule, TrainSettings};
use super::spread::{learn_attraction, pull, unseen_residuals};
use crate::files::InputError;
use crate::math::Pose;
use crate::math::redundancy::{null_space_basis, weighted_pseudo_inverse};
use crate::math::stats::quantile_of_sorted;
use crate::math::stream::{Purpose, stream};
use crate::posture::{
    Clock, Floors, HandPath, Noise, PostureLaw, Rollout, Sampler, Sampling, Start, roll_out,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Rollouts of a band, and while the noise is calibrated.
pub(super) const ROLLOUTS: u32 = 100;
const CALIBRATION_ROLLOUTS: u32 = 40;
/// Of several people, whose many movements say more than many rollouts of each.
const CALIBRATION_ROLLOUTS_OF_PEOPLE: u32 = 20;
/// Coverage at which the noise is calibrated.
const TARGET: f64 = 0.9;
/// Fewest frames from which a law is learned for that.
const FEWEST_FRAMES: usize = 20;
/// Shares of a single trial after which its later part is held out.
const EARLIER: [f64; 2] = [0.5, 0.7];
/// Range of the calibration factor, and halvings of it.
const FACTORS: (f64, f64) = (0.4, 3.0);
const HALVINGS: usize = 6;
/// A rest: people, samples and the time between them, s.
const REST_PEOPLE: u32 = 20;
const REST_SAMPLES: u32 = 30;
const REST_STEP_S: f64 = 1.0 / 30.0;
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
    /// The same with the pull of the settings; per metre where they have none.
    pub pulled_path_error_deg: f64,
    /// The same with the pull per metre, and per second.
    pub rule_error_deg: (f64, f64),
    /// Rms joint speed while the hand rests for a second: of repetitions drawn, and where the recorded hand
    /// rests in the test part, deg/s.
    pub rest_deg_s: (f64, Option<f64>),
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

/// What a walk along one held-out trial was like.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrialWalk {
    /// Mean joint error along the path without the pull, deg.
    pub path_error_deg: f64,
    /// The same with the pull of the settings; per metre where they have none.
    pub pulled_path_error_deg: f64,
    /// Share of joint angles inside the 90 % band, over all times.
    pub coverage_90: f64,
}

/// Judges a law (with its noise) on the test part of a fold: all of it, and each of its trials by index.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn check_rollouts(
    dataset: &Dataset,
    fold: &Fold,
    law: &Law,
    settings: &TrainSettings,
    floors: &Floors,
) -> Result<(RolloutScore, BTreeMap<usize, TrialWalk>), InputError> {
    let train = dataset.select(&fold.train);
    let test = dataset.select(&fold.test);
    let paths = pieces(&test);
    let by_rule = |rule: PullRule| {
        let settings = TrainSettings { pull: Some(rule), ..settings.clone() };
        pulled_law(dataset, &train, &law.law, &settings, true)
    };
    let [free, per_metre, per_second] =
        [PullRule::None, PullRule::PerMetre, PullRule::PerSecond].map(by_rule);
    let pulled =
        if settings.goes_with_hand(dataset.person.is_some()) { &per_metre } else { &per_second };
    let error = |law: &PostureLaw| path_error_deg(dataset, law, &test);
    let (sampled, repetitions) = sampled_law(dataset, &fold.train, law, settings)?;
    let how = (settings.seed, settings.sampling);
    let (each, reach_exceeded_share) = insides(dataset, &sampled, &paths, ROLLOUTS, how)?;
    let trial = |trial: usize| {
        let frames: Vec<&Frame> = test.iter().copied().filter(|f| f.trial == trial).collect();
        let own = each.iter().zip(&paths).filter(|(_, path)| path[0].trial == trial);
        TrialWalk {
            path_error_deg: path_error_deg(dataset, &free, &frames),
            pulled_path_error_deg: path_error_deg(dataset, pulled, &frames),
            coverage_90: Inside::total(own.map(|(inside, _)| inside)).coverage_90,
        }
    };
    let trials: BTreeSet<usize> = test.iter().map(|f| f.trial).collect();
    let trials = trials.into_iter().map(|t| (t, trial(t))).collect();
    let (pull_metre, pull_second) = (error(&per_metre), error(&per_second));
    let by_hand = std::ptr::eq(pulled, &raw const per_metre);
    let score = RolloutScore {
        path_error_deg: error(&free),
        pulled_path_error_deg: if by_hand { pull_metre } else { pull_second },
        rule_error_deg: (pull_metre, pull_second),
        rest_deg_s: (rest_deg_s(dataset, &sampled, &paths, settings)?, recorded_rest_deg_s(&test)),
        drift_deg: (drift_deg(dataset, &free, &paths), drift_deg(dataset, pulled, &paths)),
        bands: Inside::total(&each),
        trajectory_ll: trajectory_ll(dataset, &sampled, &paths, floors)?,
        calibration: repetitions.calibration,
        is_pulled: repetitions.is_pulled,
        reach_exceeded_share,
    };
    Ok((score, trials))
}

/// The law by which repetitions are drawn along what `train` does not hold: with its pull where that
/// helps and its noise, calibrated but for the published sampler.
pub(super) fn sampled_law(
    dataset: &Dataset,
    train: &[usize],
    law: &Law,
    settings: &TrainSettings,
) -> Result<(PostureLaw, LearnedRepetitions), InputError> {
    let mut repetitions = learn_repetitions(dataset, train, law, settings)?;
    if settings.sampling == Sampling::Independent {
        // The published sampler as it is.
        repetitions.noise.factor /= repetitions.calibration;
        repetitions.calibration = 1.0;
    }
    let frames = dataset.select(train);
    let own = pulled_law(dataset, &frames, &law.law, settings, repetitions.is_pulled);
    let noise = repetitions.noise.clone();
    Ok((PostureLaw { noise, ..own }, repetitions))
}

/// A law with its clock, and with the pull of the settings where `is_pulled`; it has no noise yet.
fn pulled_law(
    dataset: &Dataset,
    train: &[&Frame],
    law: &PostureLaw,
    settings: &TrainSettings,
    is_pulled: bool,
) -> PostureLaw {
    let goes_with_hand = settings.goes_with_hand(dataset.person.is_some());
    let attraction = if is_pulled { learn_attraction(dataset, train, settings) } else { None };
    PostureLaw { attraction, noise: no_noise(train, law.dof(), goes_with_hand), ..law.clone() }
}

/// Rms joint speed of people whose hand rests at the first place of each path for a second, deg/s.
fn rest_deg_s(
    dataset: &Dataset,
    law: &PostureLaw,
    paths: &[Vec<&Frame>],
    settings: &TrainSettings,
) -> Result<f64, InputError> {
    let sampler = Sampler::new(law, settings.sampling).ok_or_else(singular)?;
    let (mut sum, mut count) = (0.0, 0.0);
    for (p, run) in paths.iter().enumerate() {
        let time: Vec<f64> = (0..=REST_SAMPLES).map(|i| REST_STEP_S * f64::from(i)).collect();
        let hands = vec![run[0].hand; time.len()];
        let path = HandPath::new(&dataset.coupling, law, time, hands);
        let start =
            Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false, mode: None };
        for r in 0..REST_PEOPLE {
            let mut rng = stream(settings.seed, Purpose::Posture, p as u32, r);
            let person = sampler.draw(&mut rng, &path);
            let walk = roll_out(&dataset.coupling, law, &path, &start, Some(&person));
            for pair in walk.q.windows(2) {
                sum += rms_deg(&((&pair[1] - &pair[0]) / REST_STEP_S)).powi(2);
                count += 1.0;
            }
        }
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

/// Rms joint speed of the frames in which the recorded hand rests, deg/s.
fn recorded_rest_deg_s(frames: &[&Frame]) -> Option<f64> {
    let rests = frames.iter().zip(at_rest(frames)).filter(|(_, rests)| *rests);
    let squares: Vec<f64> = rests.map(|(f, _)| rms_deg(&f.qdot).powi(2)).collect();
    (!squares.is_empty()).then(|| crate::math::stats::mean(&squares).sqrt())
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

/// What repetitions by a law need besides: its noise, calibrated, and whether the pull helps.
#[derive(Debug, Clone)]
pub struct LearnedRepetitions {
    /// The noise, multiplied by `calibration`.
    pub noise: Noise,
    /// The factor at which the 90 % band covers 90 % on what was held out of the training part.
    pub calibration: f64,
    /// Whether to pull towards the person's own postures: asked for, and the path error on blocks of
    /// the training part is smaller with it.
    pub is_pulled: bool,
    /// Mean path error on those blocks without and with the pull, deg; none where it was not asked for.
    pub pull_error_deg: Option<(f64, f64)>,
}

/// Learns it from blocks of `train`, each repeated by a law that has not seen it.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn learn_repetitions(
    dataset: &Dataset,
    train: &[usize],
    law: &Law,
    settings: &TrainSettings,
) -> Result<LearnedRepetitions, InputError> {
    let is_person = dataset.person.is_some();
    let inner = dataset.blocks_of(train);
    let mut blocks = held_out_laws(dataset, &inner, law, settings)?;
    let is_asked = settings.pull_for(is_person) != PullRule::None;
    let pull_error_deg =
        is_asked.then(|| (mean_error(dataset, &blocks, false), mean_error(dataset, &blocks, true)));
    let is_pulled = pull_error_deg.is_some_and(|(free, pulled)| pulled < free);
    let mut later = held_out_laws(dataset, &later_parts(dataset, train), law, settings)?;
    if !is_pulled {
        blocks.iter_mut().chain(&mut later).for_each(|(law, _)| law.attraction = None);
    }
    let laws = std::slice::from_ref(law);
    let unseen = unseen_residuals(dataset, &inner, laws, settings, is_pulled)?;
    let noise =
        learn_noise(&law.law, &unseen[0], (settings.goes_with_hand(is_person), dataset.lowness()));
    let held_out: Vec<HeldOut> = blocks.into_iter().chain(later).collect();
    let calibration = calibrate(dataset, &held_out, &noise, settings.seed)?;
    let noise = Noise { factor: &noise.factor * calibration, ..noise };
    Ok(LearnedRepetitions { noise, calibration, is_pulled, pull_error_deg })
}

/// The same for a part of the data with what was found on all of it: only the noise is learned anew.
///
/// # Errors
/// Where the chain is singular in the data.
pub(super) fn repetitions_of_part(
    part: &Dataset,
    law: &Law,
    whole: &LearnedRepetitions,
    settings: &TrainSettings,
) -> Result<LearnedRepetitions, InputError> {
    let laws = std::slice::from_ref(law);
    let unseen = unseen_residuals(part, &part.blocks(), laws, settings, whole.is_pulled)?;
    let goes_with_hand = settings.goes_with_hand(part.person.is_some());
    let noise = learn_noise(&law.law, &unseen[0], (goes_with_hand, part.lowness()));
    let noise = Noise { factor: &noise.factor * whole.calibration, ..noise };
    Ok(LearnedRepetitions { noise, ..whole.clone() })
}

/// A law that has not seen some frames, and the frames.
type HeldOut<'a> = (PostureLaw, Vec<&'a Frame>);

/// Relearns a law for each fold, with its clock and the pull of the settings.
fn held_out_laws<'a>(
    dataset: &'a Dataset,
    folds: &[Fold],
    law: &Law,
    settings: &TrainSettings,
) -> Result<Vec<HeldOut<'a>>, InputError> {
    let stature_m = dataset.coupling.stature_m();
    let known = Some(std::slice::from_ref(law));
    let mut found = Vec::new();
    for fold in folds {
        let frames = dataset.select(&fold.train);
        let own = learn_laws(&[law.method], &frames, stature_m, settings, known)?;
        if let Some(own) = own.into_iter().next() {
            let own = pulled_law(dataset, &frames, &own.law, settings, true);
            found.push((own, dataset.select(&fold.test)));
        }
    }
    Ok(found)
}

/// The later parts of a single trial, each after an earlier one; none of several trials.
fn later_parts(dataset: &Dataset, train: &[usize]) -> Vec<Fold> {
    let first = train.first().map(|&i| dataset.frames[i].trial);
    if train.iter().any(|&i| Some(dataset.frames[i].trial) != first) {
        return Vec::new();
    }
    let folds = EARLIER.iter().map(|share| {
        let (earlier, later) = train.split_at((share * train.len() as f64).round() as usize);
        Fold { train: earlier.to_vec(), test: later.to_vec() }
    });
    folds.filter(|f| f.train.len() >= FEWEST_FRAMES && !f.test.is_empty()).collect()
}

/// Mean path error over what was held out, weighted by frames, deg.
fn mean_error(dataset: &Dataset, held_out: &[HeldOut], is_pulled: bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (law, test) in held_out {
        let free = PostureLaw { attraction: None, ..law.clone() };
        let used = if is_pulled { law } else { &free };
        sum += test.len() as f64 * path_error_deg(dataset, used, test);
        count += test.len() as f64;
    }
    sum / f64::max(count, 1.0)
}

/// The factor of the noise at which the 90 % band covers 90 % of what was held out.
fn calibrate(
    dataset: &Dataset,
    held_out: &[HeldOut],
    noise: &Noise,
    seed: u64,
) -> Result<f64, InputError> {
    let paths: Vec<Vec<Vec<&Frame>>> = held_out.iter().map(|(_, test)| pieces(test)).collect();
    let rollouts =
        if dataset.is_of_people() { CALIBRATION_ROLLOUTS_OF_PEOPLE } else { CALIBRATION_ROLLOUTS };
    let coverage = |factor: f64| -> Result<f64, InputError> {
        let (mut sum, mut count) = (0.0, 0.0);
        for ((own, _), paths) in held_out.iter().zip(&paths) {
            let scaled = Noise { factor: &noise.factor * factor, ..noise.clone() };
            let own = PostureLaw { noise: scaled, ..own.clone() };
            let how = (seed, Sampling::Pathwise);
            let (b, _) = bands(dataset, &own, paths, rollouts, how)?;
            let frames = paths.iter().map(Vec::len).sum::<usize>() as f64;
            sum += frames * b.coverage_90;
            count += frames;
        }
        Ok(sum / f64::max(count, 1.0))
    };
    // More noise covers more: halve the interval in the logarithm.
    let (mut low, mut high) = (FACTORS.0.ln(), FACTORS.1.ln());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if coverage(middle.exp())? < TARGET { low = middle } else { high = middle }
    }
    Ok((0.5 * (low + high)).exp())
}

pub(super) fn walk_path(dataset: &Dataset, law: &PostureLaw, run: &[&Frame]) -> (HandPath, Start) {
    let (time, hands) = timed_hands(run);
    let path = HandPath::new(&dataset.coupling, law, time, hands);
    (path, Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false, mode: None })
}

/// Times (s) and hands of a run. Times are from zero, and exactly even: a piece may start anywhere in its
/// recording.
pub(super) fn timed_hands(run: &[&Frame]) -> (Vec<f64>, Vec<Pose>) {
    let step = (run[run.len() - 1].time_s - run[0].time_s) / (run.len() - 1) as f64;
    let time = (0..run.len()).map(|i| step * i as f64).collect();
    (time, run.iter().map(|f| f.hand).collect())
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
            let start =
                Start { q: Some(run[0].q.clone()), distance: 0.0, is_unusual: false, mode: None };
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
    (0..rollouts)
        .into_par_iter()
        .map(|r| {
            let mut rng = stream(seed, Purpose::Posture, p as u32, r);
            let person = sampler.draw(&mut rng, &path);
            roll_out(&dataset.coupling, law, &path, &start, Some(&person))
        })
        .collect()
}

/// The value (of sorted ones, R) below which another draw lies with probability p: the p (R + 1)-th.
pub(super) fn band_end(sorted: &[f64], p: f64) -> f64 {
    let count = sorted.len() as f64;
    quantile_of_sorted(sorted, ((p * (count + 1.0) - 1.0) / (count - 1.0)).clamp(0.0, 1.0))
}

/// What the bands of one path held, added up over joint angles.
#[derive(Debug, Clone, Default)]
struct Inside {
    sum: Bands,
    /// Joint angles, and those at the end of the path.
    count: f64,
    ends: f64,
}

impl Inside {
    fn of(run: &[&Frame], walks: &[Rollout]) -> Self {
        let mut own = Self::default();
        let mut values = vec![0.0; walks.len()];
        for (k, frame) in run.iter().enumerate().skip(1) {
            for j in 0..frame.q.len() {
                values.iter_mut().zip(walks).for_each(|(v, w)| *v = w.q[k][j]);
                values.sort_by(f64::total_cmp);
                let at = |p: f64| band_end(&values, p);
                let inside = |low: f64, high: f64| {
                    f64::from(u8::from(frame.q[j] >= low && frame.q[j] <= high))
                };
                let (low, high) = (at(0.05), at(0.95));
                let within = inside(low, high);
                own.sum.coverage_90 += within;
                own.sum.coverage_50 += inside(at(0.25), at(0.75));
                own.sum.width_90_deg += (high - low).to_degrees();
                own.count += 1.0;
                if k + 1 == run.len() {
                    own.sum.end_coverage_90 += within;
                    own.ends += 1.0;
                }
            }
        }
        own
    }

    /// Shares and mean over all angles of some paths.
    fn total<'a>(paths: impl IntoIterator<Item = &'a Self>) -> Bands {
        let mut all = Self::default();
        for own in paths {
            all.sum.coverage_50 += own.sum.coverage_50;
            all.sum.coverage_90 += own.sum.coverage_90;
            all.sum.end_coverage_90 += own.sum.end_coverage_90;
            all.sum.width_90_deg += own.sum.width_90_deg;
            all.count += own.count;
            all.ends += own.ends;
        }
        let of = |v: f64, c: f64| v / f64::max(c, 1.0);
        Bands {
            coverage_50: of(all.sum.coverage_50, all.count),
            coverage_90: of(all.sum.coverage_90, all.count),
            end_coverage_90: of(all.sum.end_coverage_90, all.ends),
            width_90_deg: of(all.sum.width_90_deg, all.count),
        }
    }
}

/// Bands of sampled rollouts along paths, and the share of walks that could not continue.
pub(super) fn bands(
    dataset: &Dataset,
    law: &PostureLaw,
    paths: &[Vec<&Frame>],
    rollouts: u32,
    how: (u64, Sampling),
) -> Result<(Bands, f64), InputError> {
    let (each, ended) = insides(dataset, law, paths, rollouts, how)?;
    Ok((Inside::total(&each), ended))
}

/// The same of each path.
fn insides(
    dataset: &Dataset,
    law: &PostureLaw,
    paths: &[Vec<&Frame>],
    rollouts: u32,
    (seed, sampling): (u64, Sampling),
) -> Result<(Vec<Inside>, f64), InputError> {
    let sampler = Sampler::new(law, sampling).ok_or_else(singular)?;
    let mut ended = 0;
    let mut each = Vec::with_capacity(paths.len());
    for (p, run) in paths.iter().enumerate() {
        let walks = walks(dataset, law, &sampler, (p, run), (rollouts, seed));
        ended += walks.iter().filter(|w| w.reach_exceeded_at.is_some()).count();
        each.push(Inside::of(run, &walks));
    }
    let walks = f64::from(rollouts) * paths.len().max(1) as f64;
    Ok((each, ended as f64 / walks))
}

/// Time by the clock of the noise at each frame of a run, s; no two frames share it.
fn clock_times(run: &[&Frame], noise: &Noise) -> Vec<f64> {
    match noise.clock {
        Clock::Hand { speed_m_s, .. } => hand_times(run, speed_m_s)
            .into_iter()
            .enumerate()
            // White noise is of one frame only, even where the hand rests.
            .map(|(i, t)| t + 1e-9 * i as f64)
            .collect(),
        Clock::Seconds { .. } => run.iter().map(|f| f.time_s).collect(),
    }
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
        let by_clock = clock_times(run, &law.noise);
        let mut residuals = DVector::zeros(k * run.len());
        let mut roots = Vec::with_capacity(run.len());
        for (t, (frame, growth)) in run.iter().zip(&growth).enumerate() {
            let pulled = pull(law.attraction.as_ref(), frame, dataset.coupling.stature_m());
            let mean = law.expected(&frame.query(), &pulled).ok_or_else(singular)?;
            let mut root = law.noise.factor.clone();
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
        let gains: Vec<f64> = run.iter().map(|f| law.noise.gain(f.xdot.as_slice())).collect();
        for (a, ra) in roots.iter().enumerate() {
            for (b, rb) in roots.iter().enumerate().take(a + 1) {
                let own = if a == b { 0.0 } else { by_clock[a] - by_clock[b] };
                let moving = gains[a] * gains[b] * law.noise.correlation(own);
                let drifting = law.noise.drift_correlation(run[a].time_s - run[b].time_s);
                let block = ra * rb.transpose() * (moving + drifting);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::normals;
    use crate::training::dataset::tests::made_up;

    #[test]
    fn a_band_holds_what_it_promises_whatever_the_number_of_rollouts() {
        for rollouts in [20, 40, 100] {
            let mut rng = stream(1, Purpose::Simulation, 2, rollouts);
            let mut inside = 0;
            for _ in 0..20_000 {
                let fresh = normals(&mut rng, 1)[0];
                let mut values = normals(&mut rng, rollouts as usize);
                values.sort_by(f64::total_cmp);
                let within = fresh >= band_end(&values, 0.05) && fresh <= band_end(&values, 0.95);
                inside += u32::from(within);
            }
            let share = f64::from(inside) / 20_000.0;
            assert!((share - 0.9).abs() < 0.01, "{rollouts}: {share}");
        }
    }

    #[test]
    fn later_parts_are_held_out_of_a_single_trial_only() {
        let one = made_up(1, 4.0, 30.0);
        let every: Vec<usize> = (0..one.frames.len()).collect();
        let parts = later_parts(&one, &every);
        let sizes: Vec<_> = parts.iter().map(|f| (f.train.len(), f.test.len())).collect();
        assert_eq!(sizes, [(60, 60), (84, 36)]);
        assert!(parts.iter().all(|f| f.train.iter().max() < f.test.iter().min()));
        let two = made_up(2, 4.0, 30.0);
        let every: Vec<usize> = (0..two.frames.len()).collect();
        assert!(later_parts(&two, &every).is_empty());
    }
}

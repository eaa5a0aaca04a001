//! Frames from which a posture model is learned: what the joints did and what the hand did by it.
//!
//! ```text
//! xdot := J(q) qdot       (6 rows: m/s, rad/s; pelvis axes; the grip)
//! ```
//! The task velocity is that of the fitted joints, so that every frame meets `J qdot = xdot` exactly.
//! Frames are thinned to about 30 Hz for second moments and scores; every other one of them (about
//! 15 Hz) serves everything fitted by likelihood, because neighbouring frames are nearly copies.

use super::filled::Filled;
use super::fit::JointMotion;
use super::measurer::Measurer;
use crate::files::InputError;
use crate::human::{Body, BodySize, Coupled, PELVIS_JOINTS, Pelvis, Side, Stance};
use crate::kinematics::{Frames, JointLimit, Linkage};
use crate::math::Pose;
use crate::math::signal::differentiate;
use crate::posture::{Coupling, Hold, Lowness, Query};
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Rate for second moments and scores, Hz.
const DENSE_RATE_HZ: f64 = 30.0;
/// Rate for what is fitted by likelihood, Hz.
const SPARSE_RATE_HZ: f64 = 15.0;
/// Fewest frames (about 30 Hz) that can be split and learned from: two seconds.
const FEWEST_FRAMES: usize = 60;
/// Fewest rows of a data file.
const FEWEST_ROWS: usize = 20;
/// Fewest trials that count as demonstrations of one movement, and the length of a stretch of a
/// single trial that stands in for one.
const FEWEST_DEMONSTRATIONS: usize = 4;
const STRETCH: usize = 50;
/// Joint speed (rms over joints and time, rad/s) below which nobody moves.
const STILL_RAD_S: f64 = 1e-3;
/// Blocks of contiguous time when there is a single trial; also the most groups of trials.
const BLOCKS: usize = 5;
/// Departures from the body's range up to this (half a degree) are left to filters, rad.
const HAIR_RAD: f64 = std::f64::consts::PI / 360.0;
/// Height of the hand above the ankles, in leg lengths, that is low.
pub(super) const LOW_LEGS: f64 = 0.5;
/// Share of frames that must be low, and that must not be, for low hands to be a case of their own.
const FEWEST_LOW: f64 = 0.05;
/// Trials up to this number are held out one by one.
const MOST_SINGLE_TRIALS: usize = 6;

/// One movement without interruption.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Name of the recording.
    pub source: String,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Joint angles, T x n, rad.
    pub q: Vec<Vec<f64>>,
    /// Joint velocities, T x n, rad/s.
    pub qdot: Vec<Vec<f64>>,
    /// Whether a foot steps, T; empty where nobody does or nothing is known of it.
    pub stepping: Vec<bool>,
    /// How the pelvis is turned from where it faces (Z, X, Y), T, rad; empty where `q` holds it or it is not known.
    pub turn: Vec<[f64; 3]>,
}

impl From<&JointMotion> for Trial {
    fn from(motion: &JointMotion) -> Self {
        Self {
            source: motion.source.clone(),
            rate_hz: motion.rate_hz,
            q: motion.q.clone(),
            qdot: motion.qdot.clone(),
            stepping: Vec::new(),
            turn: Vec::new(),
        }
    }
}

impl Trial {
    /// The same joints on a pelvis that moves: its six coordinates (T x 6, leg lengths and rad) go first.
    #[must_use]
    pub(super) fn on_pelvis(self, pelvis: &[[f64; 6]]) -> Self {
        let columns: Vec<Vec<f64>> = (0..6)
            .map(|c| {
                let column: Vec<f64> = pelvis.iter().map(|row| row[c]).collect();
                differentiate(&column, 1.0 / self.rate_hz)
            })
            .collect();
        let led = |lead: Vec<f64>, joints: Vec<f64>| [lead, joints].concat();
        let place = self.q.into_iter().zip(pelvis).map(|(q, p)| led(p.to_vec(), q));
        let speed = |(i, q): (usize, Vec<f64>)| led(columns.iter().map(|c| c[i]).collect(), q);
        let qdot = self.qdot.into_iter().enumerate().map(speed).collect();
        Self {
            source: self.source,
            rate_hz: self.rate_hz,
            q: place.collect(),
            qdot,
            stepping: self.stepping,
            turn: Vec::new(),
        }
    }

    /// The rows in a range, as a trial of their own.
    #[must_use]
    pub(super) fn rows(&self, range: std::ops::Range<usize>) -> Self {
        Self {
            source: self.source.clone(),
            rate_hz: self.rate_hz,
            q: self.q[range.clone()].to_vec(),
            qdot: self.qdot[range.clone()].to_vec(),
            stepping: self.stepping.get(range.clone()).map_or_else(Vec::new, <[_]>::to_vec),
            turn: self.turn.get(range).map_or_else(Vec::new, <[_]>::to_vec),
        }
    }

    /// Takes the coordinates of the pelvis away.
    pub(super) fn leave_pelvis(&mut self) {
        for row in self.q.iter_mut().chain(&mut self.qdot) {
            row.drain(..PELVIS_JOINTS.len());
        }
    }
}

/// One instant of one trial.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Joint angles, n, rad.
    pub q: DVector<f64>,
    /// Joint velocity, n, rad/s.
    pub qdot: DVector<f64>,
    /// Jacobian of the task, m x n (of a body: of the grip, six rows, pelvis axes).
    pub jacobian: DMatrix<f64>,
    /// Task velocity, m: m/s, rad/s; of a body `J qdot`.
    pub xdot: DVector<f64>,
    /// Grip in the pelvis frame.
    pub hand: Pose,
    /// Index of the trial.
    pub trial: usize,
    /// Index of the person.
    pub person: usize,
    /// Index within the thinned trial.
    pub index: usize,
    /// Time since the start of the trial, s.
    pub time_s: f64,
    /// Whether it is one of the frames at about 15 Hz.
    pub is_sparse: bool,
    /// Whether a foot steps.
    pub is_stepping: bool,
    /// Movement to which a primitive counts it: its trial, or a stretch of a single trial.
    pub demonstration: usize,
    /// Phase within that movement, in [0, 1].
    pub phase: f64,
}

impl Frame {
    /// What a law is asked at this frame.
    pub fn query(&self) -> Query<'_> {
        Query { q: &self.q, xdot: &self.xdot, jacobian: &self.jacobian, phase: self.phase }
    }
}

/// All frames (about 30 Hz) of all trials of one person in one body.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The frames, trial by trial, in order of time.
    pub frames: Vec<Frame>,
    /// The chain, coupled to the task.
    pub coupling: Coupling,
    /// Side and size of the body; none for a chain of another kind.
    pub person: Option<(Side, BodySize)>,
    /// Names of the joints, n.
    pub joints: Vec<String>,
    /// Number of trials.
    pub trials: usize,
    /// Tells what a whole person does; none where the pelvis rests.
    pub(super) measurer: Option<Measurer>,
    is_of_people: bool,
    /// What of the pelvis was filled in; none where it was recorded, or rests.
    pub(super) filled: Option<Arc<Filled>>,
}

/// What trains and what tests, as indices of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// Frames that train.
    pub train: Vec<usize>,
    /// Frames that test.
    pub test: Vec<usize>,
}

impl Dataset {
    /// Thins the trials and adds the kinematics of the body.
    ///
    /// Rollouts that are compared with the trials may go where the trials go: a joint that was
    /// recorded beyond the body's range has its recorded range, of the test part too. Nothing that is
    /// learned knows that range, and plans keep the body's own.
    ///
    /// # Errors
    /// Where a trial has another number of joints than the chain, all trials together are shorter
    /// than two seconds, or nothing moves.
    pub fn new(trials: &[Trial], body: &Body, side: Side) -> Result<Self, InputError> {
        let dataset = Self::of_seconds(trials, body, side)?;
        if dataset.frames.len() < FEWEST_FRAMES {
            let source = trials.first().map_or("recordings", |t| t.source.as_str());
            let message =
                format!("holds only {} frames at {DENSE_RATE_HZ} Hz", dataset.frames.len());
            return Err(InputError::new(source, message)
                .remedy("give at least two seconds of movement, better ten or several trials"));
        }
        dataset.refuse_still(trials.first().map_or("recordings", |t| t.source.as_str()))?;
        Ok(dataset)
    }

    /// # Errors
    /// Where nothing moves.
    pub(super) fn refuse_still(&self, source: &str) -> Result<(), InputError> {
        let square: f64 = self.frames.iter().map(|f| f.qdot.norm_squared()).sum();
        let values = self.frames.len() * self.joints.len();
        if (square / values as f64).sqrt() >= STILL_RAD_S {
            return Ok(());
        }
        Err(InputError::new(source, "holds a person who does not move")
            .remedy("give movements of the kind that is to be planned"))
    }

    /// The same of any length: not enough to learn from, but to tell how one more person moves.
    ///
    /// # Errors
    /// Where a trial has another number of joints than the chain.
    pub(super) fn of_seconds(
        trials: &[Trial],
        body: &Body,
        side: Side,
    ) -> Result<Self, InputError> {
        let arm = body.arm(side)?;
        let width = trials.iter().flat_map(|t| &t.q).map(Vec::len).next();
        let is_whole = width == Some(arm.dof() + PELVIS_JOINTS.len());
        let pelvis = if is_whole { Pelvis::Moves } else { Pelvis::Rests };
        let coupled = Coupled { hands: side.into(), pelvis };
        let chain = body.chain(coupled, &[])?;
        let body = body.admitting(ranges(trials, &chain));
        let standing = (Stance::Standing { shoe_m: 0.0 }, 0.0);
        let coupling = Coupling::of_person(&body, coupled, &[Hold::Rigid], standing)?;
        let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
        let mut frames = Vec::new();
        for (index, trial) in trials.iter().enumerate() {
            if trial.q.iter().chain(&trial.qdot).any(|row| row.len() != joints.len()) {
                let message = format!("does not have the {} joints of the chain", joints.len());
                return Err(InputError::new(&trial.source, message));
            }
            frames.extend(thinned(trial, index, &coupling));
        }
        set_demonstrations(&mut frames);
        let person = Some((side, body.size));
        let measurer = if is_whole { Some(Measurer::new(&body, side)?) } else { None };
        Ok(Self {
            frames,
            coupling,
            person,
            joints,
            trials: trials.len(),
            measurer,
            is_of_people: false,
            filled: None,
        })
    }

    /// Trials of several people, of whom whole ones are held out, in a body in which all their postures
    /// meet.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn of_people(people: &[Vec<Trial>], body: &Body, side: Side) -> Result<Self, InputError> {
        let mut dataset = Self::new(&people.concat(), body, side)?;
        let whose = people.iter().enumerate().flat_map(|(p, own)| own.iter().map(move |_| p));
        let whose: Vec<usize> = whose.collect();
        for frame in &mut dataset.frames {
            frame.person = whose[frame.trial];
        }
        dataset.is_of_people = people.len() > 1;
        Ok(dataset)
    }

    /// Rows of a data file of any chain, as they are: `q` and `qdot` (n each), `xdot` (m), the trial
    /// and the time (s) of each row, in order of time within a trial.
    ///
    /// # Errors
    /// Where there are too few rows, or nothing moves.
    pub fn of_rows(source: &str, rows: &[DataRow], coupling: Coupling) -> Result<Self, InputError> {
        let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
        if rows.len() < FEWEST_ROWS {
            let message = format!("holds only {} rows", rows.len());
            let remedy = format!("give at least {FEWEST_ROWS} rows that train or test");
            return Err(InputError::new(source, message).remedy(remedy));
        }
        let mut scratch = Frames::default();
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        let step = typical_step(rows);
        let every_second = (1.0 / (SPARSE_RATE_HZ * step)).round().max(1.0) as usize;
        let mut frames: Vec<Frame> = rows
            .iter()
            .map(|row| {
                let q = DVector::from_column_slice(&row.q);
                let seen = coupling.observe(&q, &mut scratch);
                let index = counts.entry(row.trial).or_default();
                *index += 1;
                Frame {
                    q,
                    qdot: DVector::from_column_slice(&row.qdot),
                    xdot: DVector::from_column_slice(&row.xdot),
                    jacobian: seen.jacobian,
                    hand: seen.grips.first,
                    trial: row.trial,
                    person: 0,
                    index: *index - 1,
                    time_s: row.time_s,
                    is_sparse: (*index - 1).is_multiple_of(every_second),
                    is_stepping: false,
                    demonstration: 0,
                    phase: 0.0,
                }
            })
            .collect();
        let square: f64 = frames.iter().map(|f| f.qdot.norm_squared()).sum();
        if (square / (frames.len() * joints.len()) as f64).sqrt() < STILL_RAD_S {
            return Err(InputError::new(source, "holds a chain that does not move")
                .remedy("check the units of the qdot columns: rad/s"));
        }
        set_demonstrations(&mut frames);
        Ok(Self {
            frames,
            coupling,
            person: None,
            joints,
            trials: counts.len(),
            measurer: None,
            is_of_people: false,
            filled: None,
        })
    }

    /// Where the hand of whole people is low: from the hips down to half a leg. None where too few frames
    /// are, or too few are not, and of one person, whose few low movements would be taken for what people do.
    pub(super) fn lowness(&self) -> Option<Lowness> {
        let lowness = self.low_places()?;
        let h = self.coupling.stature_m();
        let lows = self.frames.iter().map(|f| lowness.of(f.hand.translation.y / h));
        let share = lows.sum::<f64>() / self.frames.len() as f64;
        (FEWEST_LOW..=1.0 - FEWEST_LOW).contains(&share).then_some(lowness)
    }

    /// The same however many frames are low.
    pub(super) fn low_places(&self) -> Option<Lowness> {
        let measurer = self.measurer.as_ref().filter(|_| self.is_of_people)?;
        let h = self.coupling.stature_m();
        Some(Lowness::linear(measurer.height(1.0) / h, measurer.height(LOW_LEGS) / h))
    }

    /// Whether it is of several people, also where only one of them is looked at.
    pub fn is_of_people(&self) -> bool {
        self.is_of_people
    }

    /// Number of rows of the task, m.
    pub fn task_rows(&self) -> usize {
        self.frames.first().map_or(0, |f| f.xdot.len())
    }

    /// The frames with these indices.
    pub fn select(&self, indices: &[usize]) -> Vec<&Frame> {
        indices.iter().map(|&i| &self.frames[i]).collect()
    }

    /// A data set of the frames with these indices only.
    #[must_use]
    pub(super) fn part(&self, indices: &[usize]) -> Self {
        let frames: Vec<Frame> = indices.iter().map(|&i| self.frames[i].clone()).collect();
        let trials = frames.iter().map(|f| f.trial).collect::<BTreeSet<_>>().len();
        Self {
            frames,
            coupling: self.coupling.clone(),
            person: self.person,
            joints: self.joints.clone(),
            trials,
            measurer: self.measurer.clone(),
            is_of_people: self.is_of_people,
            filled: self.filled.clone(),
        }
    }

    /// How the methods are judged: of several trials whole ones are held out; of a single one the
    /// first 70 % of the time trains, 0.5 s are left out, and the rest tests.
    pub fn held_out(&self) -> Vec<Fold> {
        if self.trials > 1 { self.blocks() } else { vec![self.split_in_time(0.7, 0.5)] }
    }

    /// The first `share` of the frames trains, a gap of `gap_s` follows, and the rest tests.
    pub fn split_in_time(&self, share: f64, gap_s: f64) -> Fold {
        let count = self.frames.len();
        let cut = ((share * count as f64).round() as usize).clamp(1, count - 1);
        let border = &self.frames[cut - 1];
        let is_test = |f: &Frame| f.trial != border.trial || f.time_s > border.time_s + gap_s;
        let test = (cut..count).filter(|&i| is_test(&self.frames[i])).collect();
        Fold { train: (0..cut).collect(), test }
    }

    /// Several data sets of one chain as trials of one.
    ///
    /// # Errors
    /// Where the chains differ.
    pub fn joined(parts: Vec<Self>) -> Result<Self, InputError> {
        let mut parts = parts.into_iter();
        let Some(mut whole) = parts.next() else {
            return Err(InputError::new("data", "holds no file"));
        };
        for part in parts {
            if part.joints != whole.joints || part.task_rows() != whole.task_rows() {
                return Err(InputError::new("data", "holds files of different chains")
                    .remedy("judge them one by one"));
            }
            let shift = whole.trials;
            whole
                .frames
                .extend(part.frames.into_iter().map(|f| Frame { trial: f.trial + shift, ..f }));
            whole.trials += part.trials;
        }
        set_demonstrations(&mut whole.frames);
        Ok(whole)
    }

    /// Every frame tests once in `count` contiguous blocks of time.
    pub fn blocks_in_time(&self, count: usize) -> Vec<Fold> {
        let total = self.frames.len();
        let of = |i: usize| i * count / total;
        (0..count)
            .map(|b| {
                let pick = |own: bool| (0..total).filter(|&i| (of(i) == b) == own).collect();
                Fold { train: pick(false), test: pick(true) }
            })
            .collect()
    }

    /// Every frame tests once: person by person; of one person trial by trial (in five groups when there are
    /// more than six), or, for a single trial, in five contiguous blocks of time.
    pub fn blocks(&self) -> Vec<Fold> {
        self.blocks_of(&(0..self.frames.len()).collect::<Vec<_>>())
    }

    /// [`Self::blocks`] within a subset of the frames.
    pub fn blocks_of(&self, subset: &[usize]) -> Vec<Fold> {
        let groups = block_numbers(&self.select(subset));
        let count = groups.iter().max().map_or(0, |g| g + 1);
        (0..count)
            .map(|g| {
                let pick = |is_test: bool| {
                    let wanted = subset.iter().zip(&groups).filter(|(_, o)| (**o == g) == is_test);
                    wanted.map(|(&i, _)| i).collect()
                };
                Fold { train: pick(false), test: pick(true) }
            })
            .filter(|fold| !fold.train.is_empty() && !fold.test.is_empty())
            .collect()
    }
}

/// One row of a data file.
#[derive(Debug, Clone, PartialEq)]
pub struct DataRow {
    /// Joint angles, n, rad.
    pub q: Vec<f64>,
    /// Task velocity, m: m/s, rad/s.
    pub xdot: Vec<f64>,
    /// Joint velocities, n, rad/s.
    pub qdot: Vec<f64>,
    /// Trial.
    pub trial: usize,
    /// Time within the trial, s.
    pub time_s: f64,
}

/// Median time step within trials, s.
fn typical_step(rows: &[DataRow]) -> f64 {
    let steps = rows.windows(2).filter(|w| w[0].trial == w[1].trial);
    let mut steps: Vec<f64> = steps.map(|w| w[1].time_s - w[0].time_s).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().filter(|s| *s > 0.0).unwrap_or(1.0)
}

/// Trials are demonstrations where there are several; a single one is cut into stretches.
fn set_demonstrations(frames: &mut [Frame]) {
    let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
    for f in frames.iter() {
        let size = sizes.entry(f.trial).or_default();
        *size = (*size).max(f.index + 1);
    }
    let is_single = sizes.len() < FEWEST_DEMONSTRATIONS;
    for f in frames {
        let size = sizes.get(&f.trial).copied().unwrap_or(1);
        let (part, length) = if is_single {
            let length = STRETCH.min(size.div_ceil(FEWEST_DEMONSTRATIONS)).max(2);
            (f.index / length, length)
        } else {
            (0, size)
        };
        f.demonstration = f.trial * 100_000 + part;
        f.phase = (f.index % length) as f64 / (length - 1).max(1) as f64;
        f.phase = f.phase.min(1.0);
    }
}

/// The block of each frame for leaving blocks out: its person; of one person its trial (of more than six,
/// one of five groups), or a fifth of the time of a single trial.
pub(super) fn block_numbers(frames: &[&Frame]) -> Vec<usize> {
    let numbered = |of: fn(&Frame) -> usize| {
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        for f in frames {
            let next = places.len();
            places.entry(of(f)).or_insert(next);
        }
        places
    };
    let people = numbered(|f| f.person);
    if people.len() > 1 {
        return frames.iter().map(|f| people[&f.person]).collect();
    }
    let places = numbered(|f| f.trial);
    frames
        .iter()
        .enumerate()
        .map(|(at, f)| match places.len() {
            0 | 1 => at * BLOCKS / frames.len(),
            count => {
                let place = places.get(&f.trial).copied().unwrap_or(0);
                if count > MOST_SINGLE_TRIALS { place % BLOCKS } else { place }
            }
        })
        .collect()
}

/// Ranges (rad) of the joints that leave the body's by more than a hair in any trial.
fn ranges<'a>(trials: &[Trial], arm: &'a Linkage) -> Vec<(&'a str, f64, f64)> {
    let range = |(c, joint): (usize, &'a JointLimit)| {
        let angles = || trials.iter().flat_map(|t| &t.q).filter_map(move |q| q.get(c).copied());
        let lower = angles().fold(joint.lower, f64::min);
        let upper = angles().fold(joint.upper, f64::max);
        let is_beyond = joint.lower - lower > HAIR_RAD || upper - joint.upper > HAIR_RAD;
        is_beyond.then_some((joint.name.as_str(), lower, upper))
    };
    arm.joints().iter().enumerate().filter_map(range).collect()
}

/// The frames at about 15 Hz among the given ones.
pub(super) fn sparse<'a>(frames: &[&'a Frame]) -> Vec<&'a Frame> {
    frames.iter().copied().filter(|f| f.is_sparse).collect()
}

/// At most `count` of the items, evenly spread.
pub(super) fn at_most<T: Copy>(items: &[T], count: usize) -> Vec<T> {
    if items.len() <= count {
        return items.to_vec();
    }
    (0..count).map(|i| items[i * items.len() / count]).collect()
}

/// Splits frames where the trial changes or time jumps: runs of uniformly spaced frames.
pub(super) fn runs<'a>(frames: &[&'a Frame]) -> Vec<Vec<&'a Frame>> {
    let mut runs: Vec<Vec<&Frame>> = Vec::new();
    for &frame in frames {
        match runs.last_mut() {
            Some(run)
                if run
                    .last()
                    .is_some_and(|l| l.trial == frame.trial && l.index + 1 == frame.index) =>
            {
                run.push(frame);
            }
            _ => runs.push(vec![frame]),
        }
    }
    runs
}

fn thinned(trial: &Trial, index: usize, coupling: &Coupling) -> Vec<Frame> {
    let every = |rate: f64| ((trial.rate_hz / rate).round() as usize).max(1);
    let (dense, sparse) = (every(DENSE_RATE_HZ), every(SPARSE_RATE_HZ));
    // Of the dense frames every second at most: 100 Hz gives 33 and 17 Hz, not 33 and 14.
    let every_second = (sparse as f64 / dense as f64).round().max(1.0) as usize;
    let mut scratch = Frames::default();
    (0..trial.q.len())
        .step_by(dense)
        .enumerate()
        .map(|(k, i)| {
            let q = DVector::from_column_slice(&trial.q[i]);
            let qdot = DVector::from_column_slice(&trial.qdot[i]);
            let seen = coupling.observe(&q, &mut scratch);
            Frame {
                xdot: &seen.jacobian * &qdot,
                q,
                qdot,
                jacobian: seen.jacobian,
                hand: seen.grips.first,
                trial: index,
                person: 0,
                index: k,
                time_s: i as f64 / trial.rate_hz,
                is_sparse: k % every_second == 0,
                is_stepping: trial.stepping.get(i).copied().unwrap_or(false),
                demonstration: 0,
                phase: 0.0,
            }
        })
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::path::Path;

    /// Trials of smooth made-up angles inside the limits of a shipped body.
    pub(in crate::training) fn made_up(trials: usize, seconds: f64, rate_hz: f64) -> Dataset {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
        let limits = coupling.limits();
        let n = coupling.dof();
        let trial = |t: usize| {
            let at = |time: f64, c: usize| {
                let (low, high) = (limits.lower[c], limits.upper[c]);
                let speed = 1.0 + 0.37 * c as f64 % 2.3 + 0.3 * t as f64;
                let (phase, reach) = (1.3 * c as f64 + t as f64, 0.12 * (high - low));
                let (s, c) = (speed * time + phase).sin_cos();
                (0.5 * (low + high) + reach * s, reach * speed * c)
            };
            let rows = |pick: fn((f64, f64)) -> f64| -> Vec<Vec<f64>> {
                let count = (seconds * rate_hz) as usize;
                let row = |i: usize| (0..n).map(|c| pick(at(i as f64 / rate_hz, c))).collect();
                (0..count).map(row).collect()
            };
            Trial {
                source: format!("trial {t}"),
                rate_hz,
                q: rows(|p| p.0),
                qdot: rows(|p| p.1),
                stepping: Vec::new(),
                turn: Vec::new(),
            }
        };
        let trials: Vec<Trial> = (0..trials).map(trial).collect();
        Dataset::new(&trials, &body, Side::Right).unwrap()
    }

    #[test]
    fn frames_are_thinned_and_meet_their_task() {
        let data = made_up(2, 4.0, 120.0);
        assert_eq!(data.frames.len(), 240);
        assert_eq!(data.frames.iter().filter(|f| f.is_sparse).count(), 120);
        for f in &data.frames {
            assert!((&f.jacobian * &f.qdot - &f.xdot).norm() < 1e-12);
        }
        assert!((data.frames[1].time_s - 1.0 / 30.0).abs() < 1e-12);
        let all: Vec<&Frame> = data.frames.iter().collect();
        assert_eq!(runs(&all).iter().map(Vec::len).collect::<Vec<_>>(), [120, 120]);
        assert_eq!(at_most(&all, 50).len(), 50);
    }

    #[test]
    fn whole_trials_are_held_out() {
        let trials_of = |data: &Dataset, indices: &[usize]| {
            let mut t: Vec<usize> = indices.iter().map(|&i| data.frames[i].trial).collect();
            t.dedup();
            t
        };
        let data = made_up(3, 2.0, 30.0);
        let folds = data.held_out();
        assert_eq!(folds.len(), 3);
        assert_eq!(trials_of(&data, &folds[1].test), [1]);
        assert_eq!(trials_of(&data, &folds[1].train), [0, 2]);
        let many = made_up(8, 2.0, 30.0);
        assert_eq!(many.held_out().len(), 5);
        assert_eq!(trials_of(&many, &many.held_out()[0].test), [0, 5]);
    }

    #[test]
    fn a_single_trial_is_split_in_time_with_a_gap() {
        let data = made_up(1, 10.0, 30.0);
        let folds = data.held_out();
        assert_eq!(folds.len(), 1);
        assert_eq!((folds[0].train.len(), folds[0].test[0]), (210, 225));
        let blocks = data.blocks();
        assert_eq!(blocks.len(), 5);
        assert!(blocks.iter().all(|b| b.test.len() == 60 && b.train.len() == 240));
    }

    #[test]
    fn too_little_and_too_still_is_refused() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let still = |count| Trial {
            stepping: Vec::new(),
            turn: Vec::new(),
            source: "still".into(),
            rate_hz: 30.0,
            q: vec![vec![0.1; 24]; count],
            qdot: vec![vec![0.0; 24]; count],
        };
        let error = |t| Dataset::new(&[t], &body, Side::Right).unwrap_err().to_string();
        assert!(error(still(20)).contains("only 20"));
        assert!(error(still(100)).contains("does not move"));
    }
}

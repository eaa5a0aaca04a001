//! Movements of the simulated operator, as many as wanted: reaches within a work volume in front; of a
//! whole person who stands, from the floor to overhead.
//!
//! ```text
//! draw (seed, index) ─► start and goal ─► straight minimum-jerk hand path, 30 Hz
//!                    ─► rollout of posture::simulated_operator with sampled start and noise
//! ```
//! Each draw has random streams of its own, so the movements are the same with any number of threads.
//! Nobody was recorded: whatever is made from these movements has to say so.

use super::dataset::Trial;
use super::motion_file::trial_of;
use crate::files::InputError;
use crate::human::{Body, Coupled, Pelvis, Side, Stance};
use crate::math::pose::interpolate;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{
    Coupling, HandPath, Hold, PostureModel, Sampler, Sampling, StartRule, natural_grip,
    postures_at, roll_out, simulated_operator, simulated_whole_operator, start_postures,
};
use nalgebra::UnitQuaternion;
use rand::RngExt as _;
use rayon::prelude::*;

/// Samples per second of a movement, Hz.
const RATE_HZ: f64 = 30.0;
/// Shortest distance from start to goal, m.
const SHORTEST_M: f64 = 0.25;
/// Standard deviation of the grip's orientation about each axis, rad: of an operator whose pelvis rests
/// small, because that posture law knows upright bars only.
const TILT_RAD: [f64; 2] = [0.05, 0.15];
/// Heights of the hand over the hips, over stature: of a third of all places anything within reach, of the
/// others those of a bench.
const HEIGHTS: [[f64; 2]; 2] = [[-0.36, 0.52], [-0.10, 0.28]];
/// Draws that are made together, and draws without any movement before the workplace counts as out of
/// reach.
const BATCH: u32 = 256;
const MOST_FAILURES: u32 = 2048;

/// One reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// Time of each sample, T, s.
    pub times_s: Vec<f64>,
    /// Coordinates of pelvis, spine and arm, T x n, leg lengths and rad.
    pub postures: Vec<Vec<f64>>,
}

impl Reach {
    /// The reach as a recording would give it: angles filtered and differentiated at 30 Hz, of which
    /// every second sample is kept (15 Hz: each of them serves what is fitted by likelihood).
    pub fn sparse_trial(&self, name: String) -> Trial {
        let n = self.postures.first().map_or(0, Vec::len);
        let angles: Vec<Vec<f64>> =
            (0..n).map(|c| self.postures.iter().map(|q| q[c]).collect()).collect();
        let dense = trial_of(name, RATE_HZ, &angles);
        let every_second = |rows: Vec<Vec<f64>>| rows.into_iter().step_by(2).collect();
        Trial {
            stepping: Vec::new(),
            turn: Vec::new(),
            source: dense.source,
            rate_hz: 0.5 * dense.rate_hz,
            q: every_second(dense.q),
            qdot: every_second(dense.qdot),
        }
    }
}

/// A source of reaches of one simulated operator.
#[derive(Debug)]
pub struct SimulatedMovements {
    coupling: Coupling,
    operator: PostureModel,
    side: Side,
    is_whole: bool,
    seed: u64,
    next_draw: u32,
    failures: u32,
}

impl SimulatedMovements {
    /// The operator in a body, holding a bar with one hand, on a pelvis that rests or as a whole person.
    ///
    /// # Errors
    /// Where the body has no such arm or cannot reach the workplace.
    pub fn new(body: &Body, side: Side, is_whole: bool, seed: u64) -> Result<Self, InputError> {
        let pelvis = if is_whole { Pelvis::Moves } else { Pelvis::Rests };
        let coupled = Coupled { hands: side.into(), pelvis };
        let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
        let coupling = Coupling::of_person(body, coupled, &[Hold::Rigid], standing)?;
        let operator = if is_whole {
            simulated_whole_operator(body, side)?
        } else {
            simulated_operator(body, side)?
        };
        Ok(Self { coupling, operator, side, is_whole, seed, next_draw: 0, failures: 0 })
    }

    /// Names of the joints, n.
    pub fn joints(&self) -> Vec<String> {
        self.coupling.joints().map(str::to_owned).collect()
    }

    /// Some more reaches, in the order of their draws.
    ///
    /// # Errors
    /// Where the operator cannot reach the workplace.
    pub fn more(&mut self) -> Result<Vec<Reach>, InputError> {
        let draws = self.next_draw..self.next_draw + BATCH;
        self.next_draw += BATCH;
        let found: Vec<Reach> = draws.into_par_iter().filter_map(|draw| self.reach(draw)).collect();
        self.failures = if found.is_empty() { self.failures + BATCH } else { 0 };
        if self.failures >= MOST_FAILURES {
            let name = &self.operator.provenance.body.0;
            return Err(InputError::new(name, "the simulated operator cannot reach its workplace"));
        }
        Ok(found)
    }

    /// The first `count` reaches.
    ///
    /// # Errors
    /// Where the operator cannot reach the workplace.
    pub fn first(mut self, count: usize) -> Result<Vec<Reach>, InputError> {
        let mut reaches = Vec::new();
        while reaches.len() < count {
            reaches.extend(self.more()?);
        }
        reaches.truncate(count);
        Ok(reaches)
    }

    /// None where start and goal are too near, or out of reach.
    fn reach(&self, draw: u32) -> Option<Reach> {
        let Self { coupling, operator, seed, .. } = self;
        let mut rng = stream(*seed, Purpose::Simulation, 0, draw);
        let h = coupling.stature_m();
        let out = if self.side == Side::Right { 1.0 } else { -1.0 };
        let mut hand = || {
            let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
            let (x, y) = if self.is_whole {
                let [low, high] = HEIGHTS[usize::from(between(0.0, 1.0) > 1.0 / 3.0)];
                (between(0.18, 0.32), between(low, high))
            } else {
                (between(0.18, 0.32), between(-0.08, 0.28))
            };
            let at = Vec3::new(x, y, out * between(-0.06, 0.22)) * h;
            let tilt = Vec3::from_vec(normals(&mut rng, 3)) * TILT_RAD[usize::from(self.is_whole)];
            Pose::from_parts(at.into(), UnitQuaternion::from_scaled_axis(tilt) * natural_grip(y))
        };
        let (from, to) = (hand(), hand());
        if (from.translation.vector - to.translation.vector).norm() < SHORTEST_M {
            return None;
        }
        let duration = 1.6 + rng.random::<f64>();
        let count = (duration * RATE_HZ).round() as usize;
        let times: Vec<f64> = (0..=count).map(|i| i as f64 / RATE_HZ).collect();
        let hands: Vec<Pose> = (0..=count)
            .map(|i| {
                let s = i as f64 / count as f64;
                interpolate(&from, &to, s * s * s * (10.0 - 15.0 * s + 6.0 * s * s))
            })
            .collect();
        let rule = StartRule::Sampled;
        let all = (&operator.law, &operator.postures);
        let postures = postures_at(all, coupling, &from.into());
        let starts = start_postures(coupling, &postures, &rule, from, (*seed, draw), 0..1);
        let start = starts.first().filter(|s| s.q.is_some() && !s.is_unusual)?;
        let sampler = Sampler::new(&operator.law, Sampling::Pathwise)?;
        let path = HandPath::new(coupling, &operator.law, times.clone(), hands);
        let person = sampler.draw(&mut rng, &path);
        let rollout = roll_out(coupling, &operator.law, &path, start, Some(&person));
        if rollout.reach_exceeded_at.is_some() {
            return None;
        }
        let postures = rollout.q.iter().map(|q| q.as_slice().to_vec()).collect();
        Some(Reach { times_s: times, postures })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn movements_do_not_depend_on_threads() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let reaches = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let source = SimulatedMovements::new(&body, Side::Right, false, 3).unwrap();
            pool.install(|| source.first(5).unwrap())
        };
        let (one, three) = (reaches(1), reaches(3));
        assert_eq!(one, three);
        let trial = one[0].sparse_trial("x".to_owned());
        assert_eq!(trial.q.len(), one[0].postures.len().div_ceil(2));
        assert!((trial.rate_hz - 15.0).abs() < 1e-12);
    }
}

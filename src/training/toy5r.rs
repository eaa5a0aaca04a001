//! The paper's toy problem: a planar chain of five joints that resolves its redundancy by a known law.
//!
//! ```text
//! qdot = J_W^+ xdot + (I - J_W^+ J) z        (eq. 3)
//! z    = -gain dC/dq_deg + N(0, sigma_z^2)   (eq. 9; C of supplementary Table 1, q in degrees)
//! q'   = q + qdot dt + omega_a dt^2,         omega_a ~ N(0, sigma_a^2)
//! ```
//! Vianello, Mouret, Dalin, Aubry, Ivaldi, "Human posture prediction during physical human-robot
//! interaction", section VI-A. `xdot` is drawn anew at each step, uniform in `[-u_max, u_max]`
//! per component; the diagonal of `W` is uniform in [eps, 2 - eps]. Where the smallest singular value of
//! `J` falls below a threshold the collection starts again at `q0`.
//!
//! [`generate`] makes the data set on which the methods are compared; [`trajectories()`] lets the same
//! person follow smooth hand paths, for judging the spread of predicted postures.

mod constants;
mod hand_path;
mod planar;
#[cfg(test)]
mod tests;
mod trajectories;

pub use constants::ToyConstants;
pub use planar::{BASE, JOINTS, TIP, planar_hand, planar_jacobian, planar_urdf};
pub use trajectories::{ToyNoise, ToyTrajectory, TrajectoryTruth, oracle_rollouts, trajectories};

use crate::ergonomics::rula_continuous;
use crate::files::InputError;
use crate::math::redundancy::{resolve, weighted_pseudo_inverse};
use crate::math::stream::{Purpose, normals, stream};
use nalgebra::{DMatrix, DVector};
use planar::smallest_singular_value;
use rand::RngExt as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Streams of random numbers, by what they are for.
mod block {
    pub(super) const WEIGHT: u32 = 500;
    pub(super) const START: u32 = 501;
    pub(super) const SAMPLES: u32 = 502;
    pub(super) const SPLIT: u32 = 503;
    pub(super) const HAND_PATH: u32 = 504;
    pub(super) const FIRST_POSTURE: u32 = 505;
    pub(super) const NOISE: u32 = 506;
    pub(super) const ORACLE: u32 = 507;
}

/// Draws of a start posture before the constants count as impossible.
const MOST_DRAWS: usize = 1000;

/// One data set with the truth behind it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToyProblem {
    /// What it was made with.
    pub constants: ToyConstants,
    /// Joint angles, N x 5, rad.
    pub q: Vec<[f64; JOINTS]>,
    /// Task velocity, N x 2, m/s; equals `J qdot`.
    pub xdot: Vec<[f64; 2]>,
    /// Joint velocity, N x 5, rad/s.
    pub qdot: Vec<[f64; JOINTS]>,
    /// Whether the row trains; the others are held out.
    pub train: Vec<bool>,
    /// The diagonal of W.
    pub w_true: [f64; JOINTS],
    /// Where the collection starts, rad.
    pub q0: [f64; JOINTS],
    /// How often it started again at `q0`.
    pub restarts: usize,
}

/// The part of z without noise, rad/s.
pub fn preferred_velocity(constants: &ToyConstants, q: &[f64; JOINTS]) -> [f64; JOINTS] {
    let (_, gradient) = rula_continuous(&q.map(f64::to_degrees));
    gradient.map(|slope| -constants.z_gain * slope)
}

/// Makes a data set; the same seed gives the same numbers.
///
/// # Errors
/// Where the constants are out of range, or allow hardly any posture that is not singular.
pub fn generate(seed: u64, constants: &ToyConstants) -> Result<ToyProblem, InputError> {
    constants.check()?;
    let w_true = draw_weight(seed, constants);
    let law = Law::new(constants, &w_true);
    let q0 = draw_start(seed, constants, |q| law.is_regular(q))?;
    let mut rng = stream(seed, Purpose::Simulation, block::SAMPLES, 0);
    let count = constants.samples;
    let mut problem = ToyProblem {
        constants: constants.clone(),
        q: Vec::with_capacity(count),
        xdot: Vec::with_capacity(count),
        qdot: Vec::with_capacity(count),
        train: split(seed, constants),
        w_true,
        q0,
        restarts: 0,
    };
    let (u, dt) = (constants.u_max_m_s, constants.dt_s);
    let mut q = q0;
    while problem.q.len() < count {
        let xdot = [rng.random_range(-u..=u), rng.random_range(-u..=u)];
        let noise = normals(&mut rng, 2 * JOINTS);
        let (white, push) = noise.split_at(JOINTS);
        let z = std::array::from_fn(|i| constants.sigma_z * white[i]);
        let qdot = if law.is_regular(&q) { law.velocity(&q, xdot, &z) } else { None };
        let Some(qdot) = qdot else {
            q = q0;
            problem.restarts += 1;
            continue;
        };
        problem.q.push(q);
        problem.xdot.push(xdot);
        problem.qdot.push(qdot);
        q = std::array::from_fn(|i| q[i] + qdot[i] * dt + constants.sigma_a * push[i] * dt * dt);
    }
    Ok(problem)
}

/// The diagonal of W for a seed.
fn draw_weight(seed: u64, constants: &ToyConstants) -> [f64; JOINTS] {
    let mut rng = stream(seed, Purpose::Simulation, block::WEIGHT, 0);
    let eps = constants.w_eps;
    std::array::from_fn(|_| rng.random_range(eps..=2.0 - eps))
}

/// The first posture for a seed that is good enough, rad.
fn draw_start(
    seed: u64,
    constants: &ToyConstants,
    is_good: impl Fn(&[f64; JOINTS]) -> bool,
) -> Result<[f64; JOINTS], InputError> {
    let mut rng = stream(seed, Purpose::Simulation, block::START, 0);
    let most = constants.q0_range_deg.to_radians();
    (0..MOST_DRAWS)
        .map(|_| std::array::from_fn(|_| rng.random_range(0.0..=most)))
        .find(is_good)
        .ok_or_else(|| {
            InputError::new("5R constants", "no start posture is far enough from singular ones")
                .remedy("raise q0_range_deg or lower singular_threshold")
        })
}

/// Which rows train: a random choice of exactly the share asked for.
fn split(seed: u64, constants: &ToyConstants) -> Vec<bool> {
    let count = constants.samples;
    let trained = (constants.train_share * count as f64).round() as usize;
    let mut train: Vec<bool> = (0..count).map(|i| i < trained.clamp(1, count - 1)).collect();
    let mut rng: ChaCha8Rng = stream(seed, Purpose::Simulation, block::SPLIT, 0);
    train.shuffle(&mut rng);
    train
}

/// The control law (3) with its weights.
struct Law<'a> {
    constants: &'a ToyConstants,
    weight: DMatrix<f64>,
}

impl<'a> Law<'a> {
    fn new(constants: &'a ToyConstants, weight: &[f64; JOINTS]) -> Self {
        let weight = DMatrix::from_diagonal(&DVector::from_row_slice(weight));
        Self { constants, weight }
    }

    /// Whether a posture is far enough from singular ones.
    fn is_regular(&self, q: &[f64; JOINTS]) -> bool {
        let jacobian = planar_jacobian(&self.constants.links, q);
        smallest_singular_value(&jacobian) >= self.constants.singular_threshold
    }

    /// The joint velocity (rad/s) for a task velocity (m/s) and the noise in z (rad/s); none where
    /// the posture is singular.
    fn velocity(
        &self,
        q: &[f64; JOINTS],
        xdot: [f64; 2],
        noise: &[f64; JOINTS],
    ) -> Option<[f64; JOINTS]> {
        let jacobian = planar_jacobian(&self.constants.links, q);
        let inverse = weighted_pseudo_inverse(&jacobian, &self.weight)?;
        let pull = preferred_velocity(self.constants, q);
        let z = DVector::from_fn(JOINTS, |i, _| pull[i] + noise[i]);
        let qdot = resolve(&jacobian, &inverse, &DVector::from_row_slice(&xdot), &z);
        Some(std::array::from_fn(|i| qdot[i]))
    }
}

//! Trajectories of the 5R person on smooth hand paths, and what the best possible prediction of them
//! would sample.
//!
//! ```text
//! xdot_t = (x_d(t+1) - f(q_t)) / dt        closed loop on the path
//! qdot_t = J_W^+ xdot_t + (I - J_W^+ J) (z(q_t) + noise_t)
//! ```
//! The three kinds of noise have the same standard deviation at every instant and differ only in how
//! long they last, which decides how far postures spread.

use super::constants::ToyConstants;
use super::hand_path::SmoothPath;
use super::planar::{JOINTS, planar_hand, planar_jacobian, smallest_singular_value};
use super::{Law, block, draw_start, draw_weight};
use crate::files::InputError;
use crate::math::redundancy::{oblique_projector, weighted_pseudo_inverse};
use crate::math::stream::{Purpose, normals, stream};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// How the noise in z hangs together over time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToyNoise {
    /// Independent at each step, whatever the step.
    White,
    /// Ornstein-Uhlenbeck, stationary from the start.
    Correlated {
        /// Correlation time, s.
        tau_s: f64,
    },
    /// One vector for the whole trajectory.
    PersonalOffset,
}

/// The truth behind a set of trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrajectoryTruth {
    /// Links, gain and speeds; its time step and its noises are not used here.
    pub constants: ToyConstants,
    /// The diagonal of W.
    pub w_true: [f64; JOINTS],
    /// The posture near which every trajectory begins, rad.
    pub q0: [f64; JOINTS],
    /// How the noise in z hangs together.
    pub noise: ToyNoise,
    /// Standard deviation of each component of the noise in z, rad/s.
    pub sigma_z: f64,
    /// Standard deviation of the first posture within the null space, rad.
    pub start_sd_rad: f64,
    /// Time step, s.
    pub dt_s: f64,
    /// Duration of a trajectory, s.
    pub duration_s: f64,
    /// How many trajectories.
    pub count: u32,
}

/// One movement along a hand path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ToyTrajectory {
    /// Times of the postures, T + 1, s.
    pub time_s: Vec<f64>,
    /// Joint angles, (T + 1) x 5, rad.
    pub q: Vec<[f64; JOINTS]>,
    /// Task velocity that the step asked for, T x 2, m/s; equals `J qdot`.
    pub xdot: Vec<[f64; 2]>,
    /// Joint velocity of the step, T x 5, rad/s.
    pub qdot: Vec<[f64; JOINTS]>,
    /// The path that the hand was to follow, (T + 1) x 2, m.
    pub hand_path: Vec<[f64; 2]>,
}

/// Hand's distance from the base at `q0`, in lengths of the stretched chain: room on all sides.
const MIDDLE: (f64, f64) = (0.5, 0.68);
/// Smallest singular value at `q0`, in lengths of the stretched chain.
const WELL_BENT: f64 = 0.2;
/// Standard deviation of the path's first point about the hand at `q0`, in lengths of the chain.
const FIRST_POINT: f64 = 0.01;
/// Newton steps that put a posture on the path.
const NEWTON_STEPS: usize = 20;

impl TrajectoryTruth {
    /// A truth for a seed: the same weights as [`super::generate`] draws, a start posture with room
    /// around the hand, 70 trajectories of 4 s with `sigma_z` of the constants.
    ///
    /// # Errors
    /// Where the constants are out of range or leave no such posture.
    pub fn draw(
        seed: u64,
        constants: &ToyConstants,
        noise: ToyNoise,
        dt_s: f64,
    ) -> Result<Self, InputError> {
        constants.check()?;
        let reach = constants.reach_m();
        let q0 = draw_start(seed, constants, |q| {
            let hand = planar_hand(&constants.links, q);
            let singular = smallest_singular_value(&planar_jacobian(&constants.links, q));
            (MIDDLE.0 * reach..MIDDLE.1 * reach).contains(&hand[0].hypot(hand[1]))
                && singular > WELL_BENT * reach
        })?;
        Ok(Self {
            constants: constants.clone(),
            w_true: draw_weight(seed, constants),
            q0,
            noise,
            sigma_z: constants.sigma_z,
            start_sd_rad: 0.05,
            dt_s,
            duration_s: 4.0,
            count: 70,
        })
    }

    /// # Errors
    /// Where a value is out of range.
    pub fn check(&self) -> Result<(), InputError> {
        self.constants.check()?;
        let tau_s = if let ToyNoise::Correlated { tau_s } = self.noise { tau_s } else { 1.0 };
        let smallest_weight = self.w_true.iter().copied().fold(f64::INFINITY, f64::min);
        let positive = [
            ("dt_s", self.dt_s),
            ("duration_s", self.duration_s),
            ("tau_s", tau_s),
            ("w_true", smallest_weight),
        ];
        let not_negative = [("sigma_z", self.sigma_z), ("start_sd_rad", self.start_sd_rad)];
        let wrong = positive
            .iter()
            .find(|(_, v)| !(v.is_finite() && *v > 0.0))
            .or_else(|| not_negative.iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)));
        if let Some((name, value)) = wrong {
            return Err(InputError::new("5R trajectories", format!("{name} = {value}"))
                .remedy(format!("{name} is out of range")));
        }
        if self.steps() == 0 {
            return Err(InputError::new("5R trajectories", "no trajectory has a step")
                .remedy("duration_s must be several times dt_s"));
        }
        Ok(())
    }

    /// Steps of a trajectory, T.
    fn steps(&self) -> usize {
        (self.duration_s / self.dt_s).round() as usize
    }

    /// The noise in z over the steps, rad/s.
    fn noise(&self, rng: &mut ChaCha8Rng, steps: usize) -> Vec<[f64; JOINTS]> {
        let mut fresh = || -> [f64; JOINTS] {
            let draw = normals(rng, JOINTS);
            std::array::from_fn(|i| self.sigma_z * draw[i])
        };
        let mut now = fresh();
        let keep = match self.noise {
            ToyNoise::White => 0.0,
            ToyNoise::Correlated { tau_s } => (-self.dt_s / tau_s).exp(),
            ToyNoise::PersonalOffset => 1.0,
        };
        let renew = (1.0 - keep * keep).sqrt();
        (0..steps)
            .map(|_| {
                let next = fresh();
                let was = now;
                now = std::array::from_fn(|i| keep * was[i] + renew * next[i]);
                was
            })
            .collect()
    }

    /// The first posture: `q0` with a small deviation in the null space, moved onto the path.
    fn first_posture(
        &self,
        rng: &mut ChaCha8Rng,
        law: &Law,
        hand: [f64; 2],
    ) -> Option<[f64; JOINTS]> {
        let links = &self.constants.links;
        let away = DVector::from_vec(normals(rng, JOINTS)) * self.start_sd_rad;
        let jacobian = planar_jacobian(links, &self.q0);
        let inverse = weighted_pseudo_inverse(&jacobian, &DMatrix::identity(JOINTS, JOINTS))?;
        let away = oblique_projector(&jacobian, &inverse) * away;
        let mut q: [f64; JOINTS] = std::array::from_fn(|i| self.q0[i] + away[i]);
        for _ in 0..NEWTON_STEPS {
            let at = planar_hand(links, &q);
            let miss = DVector::from_row_slice(&[hand[0] - at[0], hand[1] - at[1]]);
            let by = weighted_pseudo_inverse(&planar_jacobian(links, &q), &law.weight)? * miss;
            q = std::array::from_fn(|i| q[i] + by[i]);
        }
        let at = planar_hand(links, &q);
        ((at[0] - hand[0]).hypot(at[1] - hand[1]) < 1e-9).then_some(q)
    }

    /// Follows a hand path from a posture; none where a posture is singular.
    fn follow(
        &self,
        law: &Law,
        first: [f64; JOINTS],
        hand_path: &[[f64; 2]],
        noise: &[[f64; JOINTS]],
    ) -> Option<ToyTrajectory> {
        let mut done = ToyTrajectory {
            time_s: (0..hand_path.len()).map(|k| self.dt_s * k as f64).collect(),
            q: vec![first],
            xdot: Vec::with_capacity(noise.len()),
            qdot: Vec::with_capacity(noise.len()),
            hand_path: hand_path.to_vec(),
        };
        let mut q = first;
        for (goal, noise) in hand_path.iter().skip(1).zip(noise) {
            let at = planar_hand(&self.constants.links, &q);
            let xdot = [0, 1].map(|k| (goal[k] - at[k]) / self.dt_s);
            let qdot = law.is_regular(&q).then(|| law.velocity(&q, xdot, noise))??;
            q = std::array::from_fn(|i| q[i] + qdot[i] * self.dt_s);
            done.xdot.push(xdot);
            done.qdot.push(qdot);
            done.q.push(q);
        }
        Some(done)
    }
}

/// Trajectories of the person behind `truth`. A trajectory depends on the seed and its own number
/// alone; hand paths and first postures are the same for every kind of noise and every time step.
///
/// # Errors
/// Where values are out of range, the hand has no room, or a trajectory meets a singular posture.
pub fn trajectories(seed: u64, truth: &TrajectoryTruth) -> Result<Vec<ToyTrajectory>, InputError> {
    truth.check()?;
    let law = Law::new(&truth.constants, &truth.w_true);
    let middle = planar_hand(&truth.constants.links, &truth.q0);
    let one = |index: u32| {
        let named = |block: u32| stream(seed, Purpose::Simulation, block, index);
        let mut rng = named(block::HAND_PATH);
        let off = normals(&mut rng, 2);
        let off = [0, 1].map(|k| FIRST_POINT * truth.constants.reach_m() * off[k]);
        let start = [middle[0] + off[0], middle[1] + off[1]];
        let path = SmoothPath::draw(&mut rng, &truth.constants, (start, middle), truth.duration_s)?;
        let points: Vec<[f64; 2]> =
            (0..=truth.steps()).map(|k| path.at(truth.dt_s * k as f64)).collect();
        let noise = truth.noise(&mut named(block::NOISE), truth.steps());
        truth
            .first_posture(&mut named(block::FIRST_POSTURE), &law, start)
            .and_then(|first| truth.follow(&law, first, &points, &noise))
            .ok_or_else(singular)
    };
    (0..truth.count).map(one).collect()
}

/// Postures over time, (T + 1) x 5, rad, that the truth itself could have taken from a known first
/// posture along a known hand path: the width of the best possible band.
///
/// # Errors
/// Where values are out of range or a sample meets a singular posture.
pub fn oracle_rollouts(
    trajectory: &ToyTrajectory,
    truth: &TrajectoryTruth,
    count: u32,
    seed: u64,
) -> Result<Vec<Vec<[f64; JOINTS]>>, InputError> {
    truth.check()?;
    let law = Law::new(&truth.constants, &truth.w_true);
    let first = trajectory.q.first().copied().ok_or_else(singular)?;
    let steps = trajectory.hand_path.len().saturating_sub(1);
    (0..count)
        .map(|index| {
            let mut rng = stream(seed, Purpose::Simulation, block::ORACLE, index);
            let noise = truth.noise(&mut rng, steps);
            let done = truth.follow(&law, first, &trajectory.hand_path, &noise);
            done.map(|t| t.q).ok_or_else(singular)
        })
        .collect()
}

fn singular() -> InputError {
    InputError::new("5R trajectories", "a trajectory meets a singular posture")
        .remedy("choose a q0 with bent joints, or shorter and slower movements")
}

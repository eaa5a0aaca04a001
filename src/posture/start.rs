//! Start postures: drawn from the person's own postures, then moved on to the start pose.
//!
//! ```text
//! q* ~ N(mu, S)      q = argmin (q - q*)^T S^-1 (q - q*)  with the hand at the start pose, in limits
//! ```
//! Each iteration is one step of [`StepSolver`] with weight `S`, preferred velocity `q* - q` and unit
//! time: the Gauss-Newton step of that problem, with its bounds.

use super::model::PostureDistribution;
use super::rollout::Coupling;
use super::step::StepSolver;
use crate::kinematics::Frames;
use crate::math::Pose;
use crate::math::stream::{Purpose, normals, stream};
use nalgebra::DVector;

/// Residual of the hand (m and rad) at which a start posture is accepted.
const TOLERANCE: f64 = 1e-8;
const MOST_ITERATIONS: usize = 200;
/// Largest change of a joint in one iteration, rad.
const LARGEST_STEP: f64 = 0.3;

/// How the worker stands before the movement.
#[derive(Debug, Clone, PartialEq)]
pub enum StartRule {
    /// Drawn from the person's postures (the default).
    Sampled,
    /// The person's mean posture.
    Mean,
    /// A given posture of the coupled chain, n, rad.
    Given(Vec<f64>),
}

/// One start posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// Joint angles, n, rad; none when the hand cannot reach the start pose.
    pub q: Option<DVector<f64>>,
    /// Mahalanobis distance to the training postures.
    pub distance: f64,
    /// Beyond the 99 % quantile of that distance.
    pub is_unusual: bool,
}

/// `count` start postures for a hand pose (pelvis frame). Draw r depends on (seed, block, r) and on
/// the start pose only, so every path from the same start meets the same people.
pub fn start_postures(
    coupling: &Coupling,
    postures: &PostureDistribution,
    rule: &StartRule,
    hand: &Pose,
    (seed, block): (u64, u32),
    count: usize,
) -> Vec<Start> {
    let factor = postures.covariance.clone().cholesky();
    let n = postures.mean.len();
    (0..count)
        .map(|r| {
            let wish = match (rule, &factor) {
                (StartRule::Given(q), _) => DVector::from_vec(q.clone()),
                (StartRule::Sampled, Some(f)) => {
                    let mut rng = stream(seed, Purpose::Posture, block, r as u32);
                    &postures.mean + f.l() * DVector::from_vec(normals(&mut rng, n))
                }
                _ => postures.mean.clone(),
            };
            let q = reach(coupling, postures, &wish, hand);
            let distance = q.as_ref().map_or(f64::INFINITY, |q| postures.mahalanobis(q));
            Start { q, distance, is_unusual: distance > postures.unusual_distance() }
        })
        .collect()
}

/// The posture nearest to `wish` that has the hand at `hand` within the limits.
fn reach(
    coupling: &Coupling,
    postures: &PostureDistribution,
    wish: &DVector<f64>,
    hand: &Pose,
) -> Option<DVector<f64>> {
    let limits = coupling.limits();
    let mut solver = StepSolver::new(postures.covariance.clone());
    let mut frames = Frames::default();
    let clamp = |i: usize, v: f64| v.clamp(limits.lower[i], limits.upper[i]);
    let mut q = DVector::from_fn(wish.len(), |i, _| clamp(i, wish[i]));
    let mut largest_before = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        let now = coupling.observe(&q, &mut frames);
        let error = coupling.task_error(&now.pose, hand);
        let step = solver.solve(&q, &now.jacobian, &error, &(wish - &q), limits, 1.0).ok()?;
        let largest = step.amax();
        if error.amax() < TOLERANCE && (largest < 1e-6 || largest >= 0.5 * largest_before) {
            return Some(q);
        }
        if error.amax() < TOLERANCE {
            largest_before = largest;
        }
        q += &step * (LARGEST_STEP / largest).min(1.0);
    }
    None
}

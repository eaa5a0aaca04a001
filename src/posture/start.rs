//! Start postures: drawn from the person's own postures, then moved on to the start pose.
//!
//! ```text
//! q* ~ N(mu, S)      q = argmin (q - q*)^T S^-1 (q - q*)  with the hand at the start pose, in limits
//! ```
//! Each iteration is one step of [`StepSolver`] with weight `S`, preferred velocity `q* - q` and unit
//! time: the Gauss-Newton step of that problem, with its bounds.

use super::coupling::Coupling;
use super::model::PostureDistribution;
use super::step::StepSolver;
use crate::kinematics::Frames;
use crate::math::Pose;
use crate::math::stream::{Purpose, normals, stream};
use nalgebra::DVector;
use std::ops::Range;

/// Residual of the hand (m and rad) at which a start posture is accepted.
const TOLERANCE: f64 = 1e-8;
const SEARCH_ITERATIONS: usize = 60;
const MOST_ITERATIONS: usize = 80;
/// Change of a joint (rad) below which the nearest posture is found.
const SETTLED: f64 = 1e-6;
/// Largest error of the hand that one iteration tries to close, m.
const LARGEST_ERROR_M: f64 = 0.1;
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

/// Start postures of some people for a hand pose (pelvis frame). Draw r depends on (seed, block, r) and on
/// the start pose only, so every path from the same start meets the same people.
pub fn start_postures(
    coupling: &Coupling,
    postures: &PostureDistribution,
    rule: &StartRule,
    hand: &Pose,
    (seed, block): (u64, u32),
    people: Range<usize>,
) -> Vec<Start> {
    let factor = postures.covariance.clone().cholesky();
    let n = postures.mean.len();
    people
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
    // From the wish itself; where that fails (limits in the way), from the mean posture.
    [wish, &postures.mean]
        .into_iter()
        .find_map(|from| reach_from(coupling, postures, wish, hand, from))
}

fn reach_from(
    coupling: &Coupling,
    postures: &PostureDistribution,
    wish: &DVector<f64>,
    hand: &Pose,
    from: &DVector<f64>,
) -> Option<DVector<f64>> {
    let limits = coupling.limits();
    let mut solver = StepSolver::new(postures.covariance.clone());
    let mut frames = Frames::default();
    let clamp = |i: usize, v: f64| v.clamp(limits.lower[i], limits.upper[i]);
    let mut q = DVector::from_fn(from.len(), |i, _| clamp(i, from[i]));
    for iteration in 0..MOST_ITERATIONS {
        let now = coupling.observe(&q, &mut frames);
        let error = coupling.task_error(&now.pose, hand);
        let linear = coupling.hold().linear_rows();
        let turned = error.rows_range(linear..).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let size = error.rows(0, linear).amax().max(0.4 * turned);
        let is_polish = iteration >= SEARCH_ITERATIONS;
        // Short steps keep the linearised limits meaningful while the hand is far away; shorter ones
        // later end any switching of bounds. The polish only closes the rest of the error.
        let calm = if iteration < SEARCH_ITERATIONS / 2 { 1.0 } else { 0.5 };
        let part = (LARGEST_ERROR_M / size).min(1.0) * if is_polish { 1.0 } else { calm };
        let wanted = if is_polish { DVector::zeros(q.len()) } else { (wish - &q) * part };
        let step = solver.solve(&q, &now.jacobian, &(&error * part), &wanted, limits, 1.0).ok()?;
        let largest = step.amax();
        if error.amax() < TOLERANCE && (is_polish || largest < SETTLED) {
            return Some(q);
        }
        q += &step * (LARGEST_STEP / largest).min(1.0);
    }
    None
}

//! Start postures: drawn from the person's own postures, then moved on to the start pose.
//!
//! ```text
//! q* ~ N(mu, S)      q = argmin (q - q*)^T S^-1 (q - q*)  with the hand at the start pose, in limits
//! ```
//! Each iteration is one step of [`StepSolver`] with weight `S`, preferred velocity `q* - q` and unit
//! time: the Gauss-Newton step of that problem, with its bounds.

use super::coupling::Coupling;
use super::grips::Grips;
use super::model::PostureDistribution;
use super::step::{Allowed, Bounds, StepSolver};
use crate::kinematics::Frames;
use crate::math::stream::{Purpose, normals, stream};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Residual of the hand (m and rad) at which a start posture is accepted.
const TOLERANCE: f64 = 1e-8;
const SEARCH_ITERATIONS: usize = 60;
const MOST_ITERATIONS: usize = 80;
/// Change of a joint (rad) below which the nearest posture is found.
const SETTLED: f64 = 1e-9;
/// Largest error of the hand that one iteration tries to close, m.
const LARGEST_ERROR_M: f64 = 0.1;
/// Largest change of a joint in one iteration, rad.
const LARGEST_STEP: f64 = 0.3;

/// Share of its range by which any joint may stray where the person's own postures are too stiff.
const STRAY_SHARE: f64 = 0.03;

/// Bounds of legs and balance within this count, m or rad: one iteration goes far.
const NEAR: f64 = 0.3;

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
    /// The mode of the movement; none where there is one law of all.
    pub mode: Option<usize>,
}

impl Start {
    /// The same start among other postures, such as those of all places.
    #[must_use]
    pub fn among(self, postures: &PostureDistribution) -> Self {
        let distance = self.q.as_ref().map_or(f64::INFINITY, |q| postures.mahalanobis(q));
        Self { distance, is_unusual: distance > postures.unusual_distance(), ..self }
    }
}

/// Start postures of some people for grips in the rest frame.
pub fn start_postures(
    coupling: &Coupling,
    postures: &PostureDistribution,
    rule: &StartRule,
    hand: impl Into<Grips>,
    block: (u64, u32),
    people: Range<usize>,
) -> Vec<Start> {
    let hand = hand.into();
    people.map(|r| start_posture(coupling, postures, rule, &hand, (block, r, r))).collect()
}

/// Start posture of repetition r, by a person, of a (seed, block). It depends on these and on the start pose only, so every path from the
/// same start meets the same people.
pub(super) fn start_posture(
    coupling: &Coupling,
    postures: &PostureDistribution,
    rule: &StartRule,
    hand: &Grips,
    ((seed, block), r, person): ((u64, u32), usize, usize),
) -> Start {
    let factor = || postures.covariance.clone().cholesky();
    let wish = match rule {
        StartRule::Given(q) => DVector::from_vec(q.clone()),
        StartRule::Sampled => factor().map_or_else(
            || postures.mean.clone(),
            |f| {
                let n = postures.mean.len();
                let mut rng = stream(seed, Purpose::Posture, block, r as u32);
                let mut z = DVector::from_vec(normals(&mut rng, n));
                if let Some(population) = &postures.population {
                    z *= population.of_repetition();
                    z += population.person((seed, block), person, n);
                }
                &postures.mean + f.l() * z
            },
        ),
        StartRule::Mean => postures.mean.clone(),
    };
    let q = reach(coupling, postures, &wish, hand);
    Start { q, distance: 0.0, is_unusual: false, mode: None }.among(postures)
}

/// The posture nearest to `wish` that has the hand at `hand` within the limits.
///
/// Where limits lock what the person's postures mostly vary in, the rest of their covariance can be so
/// stiff that no step gets there although the hand can be held. Then every joint may also stray by a
/// small share of its range: whether a place is in reach depends on the body, not on the person's habits.
fn reach(
    coupling: &Coupling,
    postures: &PostureDistribution,
    wish: &DVector<f64>,
    hand: &Grips,
) -> Option<DVector<f64>> {
    // From the wish itself; where that fails (limits in the way), from the mean posture.
    let by = |metric: &DMatrix<f64>| {
        let mut froms = [wish, &postures.mean].into_iter();
        froms.find_map(|from| reach_from(coupling, metric, wish, hand, from))
    };
    by(&postures.covariance).or_else(|| {
        let limits = coupling.limits();
        let stray = |i: usize| (STRAY_SHARE * (limits.upper[i] - limits.lower[i])).powi(2);
        let stray = DVector::from_fn(wish.len(), |i, _| stray(i));
        by(&(&postures.covariance + DMatrix::from_diagonal(&stray)))
    })
}

fn reach_from(
    coupling: &Coupling,
    metric: &DMatrix<f64>,
    wish: &DVector<f64>,
    hand: &Grips,
    from: &DVector<f64>,
) -> Option<DVector<f64>> {
    let limits = coupling.limits();
    let mut solver = StepSolver::new(metric.clone());
    let mut bounds = Bounds::default();
    let mut frames = Frames::default();
    let clamp = |i: usize, v: f64| v.clamp(limits.lower[i], limits.upper[i]);
    let mut q = DVector::from_fn(from.len(), |i, _| clamp(i, from[i]));
    for iteration in 0..MOST_ITERATIONS {
        let now = coupling.observe(&q, &mut frames);
        let error = coupling.task_error(&now.grips, hand);
        let linear = coupling.linear_rows();
        let turned = error.rows_range(linear..).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let size = error.rows(0, linear).amax().max(0.4 * turned);
        let is_polish = iteration >= SEARCH_ITERATIONS;
        // Short steps keep the linearised limits meaningful while the hand is far away; shorter ones
        // later end any switching of bounds. The polish only closes the rest of the error.
        let calm = if iteration < SEARCH_ITERATIONS / 2 { 1.0 } else { 0.5 };
        let part = (LARGEST_ERROR_M / size).min(1.0) * if is_polish { 1.0 } else { calm };
        let wanted = if is_polish { DVector::zeros(q.len()) } else { (wish - &q) * part };
        coupling.bounds(&frames, NEAR, &mut bounds);
        let allowed = Allowed { limits, bounds: &bounds };
        let step = solver.solve(&q, &now.jacobian, &(&error * part), &wanted, allowed, 1.0).ok()?;
        let largest = step.amax();
        if error.amax() < TOLERANCE && (is_polish || largest < SETTLED) {
            return coupling.is_balanced(&frames).then_some(q);
        }
        q += &step * (LARGEST_STEP / largest).min(1.0);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Side, Stance};
    use crate::math::{Pose, Vec3};
    use crate::posture::{Hold, simulated_person};

    #[test]
    fn whether_a_low_place_is_in_reach_does_not_depend_on_the_draw() {
        // A tall man's hand low before him: the trunk's bounds lock what these people's postures mostly
        // vary in. The same place counted as in reach for some draws and out of reach for others.
        let body = Body::load("male_p95", std::path::Path::new(".")).unwrap();
        let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
        let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, Stance::Standing { shoe_m: 0.03 });
        let grip = crate::math::pose::rotation_from_axes(-Vec3::z(), -Vec3::x(), Vec3::y());
        let hand = |x: f64, y: f64, z: f64| {
            let at = pelvis.inverse() * nalgebra::Point3::new(x, y, z);
            Pose::from_parts(at.into(), grip)
        };
        let reached = |number: u64, hand: &Pose| {
            let postures = simulated_person(&body, Side::Right, Some(number)).unwrap().postures;
            let rule = StartRule::Sampled;
            let starts = start_postures(&coupling, &postures, &rule, hand, (1, 1), 0..24);
            let limits = coupling.limits();
            for q in starts.iter().filter_map(|s| s.q.as_ref()) {
                assert!(limits.violation(q.as_slice()) < 1e-9);
            }
            starts.iter().filter(|s| s.q.is_some()).count()
        };
        for number in [6, 10, 64, 70] {
            assert_eq!(reached(number, &hand(0.41, -0.21, 0.65)), 24, "person {number}");
        }
        assert_eq!(reached(6, &hand(1.3, -0.21, 0.65)), 0);
    }
}

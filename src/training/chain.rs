//! Inverse kinematics of one frame: the posture inside all limits that is nearest to what was seen.
//!
//! ```text
//! min over q   sum over segments |W_s log(R_s(q)^T R_target)|^2 + |p_hand(q) + offset - p_target|^2 / sd^2
//!            + |spine - shares * its total|^2 / sd^2 + |q - q_before|^2 / sd^2
//!            + |q beyond the body's limits|^2 / sd^2    (while calibrating)
//! ```
//! Gauss-Newton steps with Levenberg's damping where a step fails; each step is a quadratic programme
//! under the limits ([`ActiveSet`]). The Jacobian of the rotation vector is exact:
//! `d log(R^T R_target) = -J_left^-1 R^T J_angular dq`.

use super::active_set::ActiveSet;
use super::fit::FitSettings;
use super::sharing::sharing;
use super::targets::{Target, segment_names};
use crate::files::InputError;
use crate::human::{Body, PostureLimits, Side};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::Vec3;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Matrix6xX, Rotation3, UnitQuaternion};

const MAX_STEPS: usize = 60;
/// Largest change of a joint (rad) below which a posture counts as found.
const CONVERGED: f64 = 1e-9;

/// A recorded segment, as a tip of the linkage.
#[derive(Debug, Clone)]
struct Segment {
    tip: usize,
    /// 1 / sd about the segment's x, y, z axes, 1/rad.
    weight: Vec3,
}

/// The chain from the pelvis to a grip with everything that a fit weighs.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    pub linkage: Linkage,
    /// Limits within which postures are sought.
    pub limits: PostureLimits,
    /// Limits of the body.
    pub body_limits: PostureLimits,
    /// 1 / sd^2 of a joint beyond the body's limits, 1/rad^2; 0 where that costs nothing.
    excess: f64,
    /// Stature of the body, m.
    pub stature_m: f64,
    /// Shoulder to elbow of the body, m.
    pub upper_arm_m: f64,
    /// Elbow to wrist of the body, m.
    pub forearm_m: f64,
    active_set: ActiveSet,
    segments: Vec<Segment>,
    hand_tip: usize,
    /// 1 / sd of the hand, 1/m.
    hand_weight: f64,
    /// Hessian of the pull towards the spine's sharing, n x n.
    sharing: DMatrix<f64>,
    /// 1 / sd^2 of the pull towards the frame before.
    memory: f64,
}

/// What pulls on a posture besides orientations.
#[derive(Debug, Clone, Copy)]
pub(super) enum HandPull {
    /// Orientations alone.
    Free,
    /// The wrist, with the constant offset (m) from the model's to the recorded position.
    At(Vec3),
}

/// Cost, gradient and Gauss-Newton Hessian at a posture.
pub(super) struct Normal {
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

/// A recorded segment's residual in units of its standard deviations, and its slopes.
pub(super) struct Turn {
    pub residual: Vec3,
    /// By the joints, 3 x n.
    pub rows: Matrix3xX<f64>,
    /// By a further turn of the record about its own axes.
    pub own: Matrix3<f64>,
}

/// A posture and its cost.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub q: DVector<f64>,
    pub cost: f64,
}

impl Chain {
    /// The chain of `body` whose recorded segments are `recorded`.
    pub(super) fn new(
        body: &Body,
        side: Side,
        recorded: &[String],
        settings: &FitSettings,
    ) -> Result<Self, InputError> {
        let names = segment_names(side);
        // The grip first: its chain has the leading columns, and all others lie on it.
        let mut tips = vec![Tip::link(side.grip())];
        tips.extend(names.iter().map(|n| Tip::link(n)));
        let linkage = Linkage::new(&body.model, "Pelvis", &tips)
            .map_err(|e| InputError::new(&body.name, format!("is no ergopath body: {e}")))?;
        let limits = body.limits(&linkage);
        let sd = settings.orientation_sd_deg.to_radians();
        let segments = names.iter().enumerate().filter(|(_, n)| recorded.contains(n));
        let segments = segments.map(|(i, name)| {
            let axial =
                if name.ends_with("UpperArm") { settings.axial_sd_deg.to_radians() } else { sd };
            Segment { tip: i + 1, weight: Vec3::new(1.0 / sd, 1.0 / axial, 1.0 / sd) }
        });
        let sharing = sharing(&linkage, &limits, side, recorded)
            / settings.sharing_sd_deg.to_radians().powi(2);
        let mut frames = Frames::default();
        linkage.forward(&vec![0.0; linkage.dof()], &mut frames);
        // Tips are the grip, the trunk, then girdle, upper arm, forearm and hand.
        let [upper, fore, hand] = [3, 2, 1].map(|k| names.len() + 1 - k);
        let between = |a: usize, b: usize| {
            (linkage.tip_frame(&frames, a).0 - linkage.tip_frame(&frames, b).0).norm()
        };
        Ok(Self {
            stature_m: body.size.stature_m,
            upper_arm_m: between(upper, fore),
            forearm_m: between(fore, hand),
            segments: segments.collect(),
            hand_tip: names.len(),
            hand_weight: 1e3 / settings.hand_sd_mm,
            sharing,
            memory: settings.previous_sd_deg.to_radians().powi(-2),
            active_set: ActiveSet::new(&limits),
            linkage,
            body_limits: limits.clone(),
            excess: 0.0,
            limits,
        })
    }

    /// The chain with another standard deviation of the wrist, mm.
    pub(super) fn trusting_hand(self, sd_mm: f64) -> Self {
        Self { hand_weight: 1e3 / sd_mm, ..self }
    }

    /// The chain whose joints may go beyond the body's limits by `slack` (rad), at the cost of an
    /// observation with the standard deviation `sd` (rad; infinite: at none). Sums keep their limits.
    pub(super) fn loosened(&self, slack: f64, sd: f64) -> Self {
        let limits = self.body_limits.widened(slack);
        Self { active_set: ActiveSet::new(&limits), limits, excess: sd.powi(-2), ..self.clone() }
    }

    /// Position (m) of the wrist joint centre in the pelvis frame.
    pub(super) fn hand(&self, frames: &Frames) -> Vec3 {
        self.linkage.tip_frame(frames, self.hand_tip).0
    }

    /// Jacobian of the wrist joint centre, 6 x n.
    pub(super) fn hand_jacobian(&self, frames: &Frames) -> Matrix6xX<f64> {
        self.linkage.jacobian(frames, self.hand_tip)
    }

    /// Rotation vectors (rad, segment axes) from the model's to the recorded segments.
    pub(super) fn turns(&self, frames: &Frames, target: &Target) -> Vec<Vec3> {
        let turn = |(s, r): (&Segment, &UnitQuaternion<f64>)| {
            turn_to(&self.linkage.tip_frame(frames, s.tip).1, r)
        };
        self.segments.iter().zip(&target.rotations).map(turn).collect()
    }

    /// The point within all limits that is nearest to `wanted`, sought from the feasible `from`.
    pub(super) fn nearest_feasible(&self, wanted: &[f64], from: &DVector<f64>) -> DVector<f64> {
        let n = from.len();
        let slope = from - DVector::from_column_slice(wanted);
        self.active_set
            .minimise(&DMatrix::identity(n, n), &slope, from)
            .unwrap_or_else(|| from.clone())
    }

    /// A posture inside all limits from which [`Chain::nearest_feasible`] can start: zero, moved to
    /// the nearest limit where zero is outside.
    pub(super) fn rest(&self) -> DVector<f64> {
        let bounds = self.limits.lower.iter().zip(&self.limits.upper);
        DVector::from_iterator(self.limits.lower.len(), bounds.map(|(lo, hi)| 0f64.clamp(*lo, *hi)))
    }

    /// The best posture for a frame from a feasible `start`; `before` is the frame before.
    pub(super) fn solve(
        &self,
        target: &Target,
        pull: HandPull,
        start: &DVector<f64>,
        before: Option<&DVector<f64>>,
        frames: &mut Frames,
    ) -> Solution {
        let mut q = start.clone();
        let mut now = self.normal(&q, target, pull, before, frames);
        let mut damping = 0.0;
        for _ in 0..MAX_STEPS {
            let mut hessian = now.hessian.clone();
            for i in 0..q.len() {
                // A floor keeps directions that nothing determines where they are.
                hessian[(i, i)] += damping + 1e-9;
            }
            let Some(next) = self.active_set.minimise(&hessian, &now.gradient, &q) else { break };
            if (&next - &q).amax() < CONVERGED {
                break;
            }
            let then = self.normal(&next, target, pull, before, frames);
            if then.cost <= now.cost {
                (q, now) = (next, then);
                damping = if damping < 1e-3 { 0.0 } else { damping * 0.1 };
            } else {
                damping = (damping * 10.0).max(1e-2);
            }
        }
        Solution { q, cost: now.cost }
    }

    /// What the recorded segment `i` asks of the joints, at the posture of `frames`.
    pub(super) fn turn(
        &self,
        i: usize,
        wanted: &UnitQuaternion<f64>,
        frames: &Frames,
        jacobian: &mut Matrix6xX<f64>,
    ) -> Turn {
        let segment = &self.segments[i];
        self.linkage.jacobian_into(frames, segment.tip, jacobian);
        let (_, rotation) = self.linkage.tip_frame(frames, segment.tip);
        let turn = turn_to(&rotation, wanted);
        let weight = Matrix3::from_diagonal(&segment.weight);
        let rows =
            -weight * left_inverse(&turn) * rotation.transpose() * jacobian.fixed_rows::<3>(3);
        // A further turn of the record by its own axes adds to the rotation vector by the inverse
        // of the right Jacobian, which is the left one of the opposite rotation.
        Turn { residual: weight * turn, rows, own: weight * left_inverse(&-turn) }
    }

    pub(super) fn normal(
        &self,
        q: &DVector<f64>,
        target: &Target,
        pull: HandPull,
        before: Option<&DVector<f64>>,
        frames: &mut Frames,
    ) -> Normal {
        let n = q.len();
        self.linkage.forward(q.as_slice(), frames);
        let mut jacobian = Matrix6xX::zeros(n);
        let mut gradient = &self.sharing * q;
        let mut cost = 0.5 * q.dot(&gradient);
        let mut hessian = self.sharing.clone();
        for (i, wanted) in target.rotations.iter().enumerate() {
            let Turn { residual, rows, .. } = self.turn(i, wanted, frames, &mut jacobian);
            cost += 0.5 * residual.norm_squared();
            gradient.gemv_tr(1.0, &rows, &residual, 1.0);
            hessian.gemm_tr(1.0, &rows, &rows, 1.0);
        }
        let bounds = self.body_limits.lower.iter().zip(&self.body_limits.upper);
        for (i, (lower, upper)) in bounds.enumerate() {
            let beyond = q[i] - q[i].clamp(*lower, *upper);
            if self.excess > 0.0 && beyond != 0.0 {
                cost += 0.5 * self.excess * beyond * beyond;
                gradient[i] += self.excess * beyond;
                hessian[(i, i)] += self.excess;
            }
        }
        if let HandPull::At(offset) = pull {
            self.linkage.jacobian_into(frames, self.hand_tip, &mut jacobian);
            let residual = (self.hand(frames) + offset - target.hand) * self.hand_weight;
            let rows = jacobian.fixed_rows::<3>(0) * self.hand_weight;
            cost += 0.5 * residual.norm_squared();
            gradient.gemv_tr(1.0, &rows, &residual, 1.0);
            hessian.gemm_tr(1.0, &rows, &rows, 1.0);
        }
        if let Some(before) = before {
            let away = q - before;
            cost += 0.5 * self.memory * away.norm_squared();
            gradient.axpy(self.memory, &away, 1.0);
            for i in 0..n {
                hessian[(i, i)] += self.memory;
            }
        }
        Normal { cost, gradient, hessian }
    }
}

/// Rotation vector of `R^T R_wanted`, in the axes of `R`.
fn turn_to(rotation: &Matrix3<f64>, wanted: &UnitQuaternion<f64>) -> Vec3 {
    let now = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    (now.inverse() * wanted).scaled_axis()
}

/// Inverse of the left Jacobian of the exponential map at a rotation vector.
fn left_inverse(turn: &Vec3) -> Matrix3<f64> {
    let angle = turn.norm();
    let cross = turn.cross_matrix();
    let second = if angle < 1e-4 {
        1.0 / 12.0
    } else {
        1.0 / (angle * angle) - 0.5 / (angle * (0.5 * angle).tan())
    };
    Matrix3::identity() - cross * 0.5 + cross * cross * second
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{BodySize, Sex};
    use approx::assert_relative_eq;
    use std::path::Path;

    fn chain(settings: &FitSettings) -> Chain {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        Chain::new(&body, Side::Left, &segment_names(Side::Left), settings).unwrap()
    }

    #[test]
    fn gradient_is_the_slope_of_the_cost() {
        let chain = chain(&FitSettings::default());
        let mut frames = Frames::default();
        let n = chain.linkage.dof();
        assert_eq!(n, 24);
        let q = DVector::from_fn(n, |i, _| 0.3 * (i as f64 * 1.7).sin());
        let before = DVector::from_element(n, 0.05);
        let target = Target {
            rotations: (0..8)
                .map(|i| UnitQuaternion::from_scaled_axis(Vec3::new(0.2, -0.1 * f64::from(i), 0.4)))
                .collect(),
            hand: Vec3::new(0.3, 0.2, -0.2),
        };
        let pull = HandPull::At(Vec3::new(0.01, 0.02, 0.03));
        let mut at = |q: &DVector<f64>| chain.normal(q, &target, pull, Some(&before), &mut frames);
        let gradient = at(&q).gradient;
        for i in 0..n {
            let (mut plus, mut minus) = (q.clone(), q.clone());
            plus[i] += 1e-6;
            minus[i] -= 1e-6;
            let slope = (at(&plus).cost - at(&minus).cost) / 2e-6;
            assert_relative_eq!(gradient[i], slope, max_relative = 1e-5, epsilon = 1e-4);
        }
    }

    #[test]
    fn rest_is_feasible_for_any_size() {
        for (sex, stature_m) in [(Sex::Female, 1.4), (Sex::Male, 2.0)] {
            let size = BodySize { sex, stature_m, mass_kg: 70.0 };
            let body = Body::of_size("x", size).unwrap();
            let chain = Chain::new(
                &body,
                Side::Right,
                &segment_names(Side::Right),
                &FitSettings::default(),
            )
            .unwrap();
            assert_relative_eq!(chain.limits.violation(chain.rest().as_slice()), 0.0);
        }
    }
}

//! How the recorded axes of the arm's segments are turned against the model's: constants of one
//! recording.
//!
//! ```text
//! R_model(q_t) = R_recorded,t C
//! min over C, q_t   N / T * sum over t of cost(q_t; C) + |W log C|^2 / 2      N = 30 postures' worth
//! ```
//! Marker clusters and sensors sit a little turned on the limbs, and a solved skeleton has its own
//! idea of the elbow's axis. Joints that would have to leave their range show that most clearly; so
//! the cost of a posture holds what lies beyond the body's limits, and the prior keeps every `C` as
//! small as they allow: where no limit is in question `C` is zero. Of the hand-over's taker the upper
//! arm turns by 14 deg about its axis, and the elbow's sideways angle, once at its limit in 36 % of
//! the frames, reaches 26 deg instead of 36.

use super::chain::{Chain, HandPull};
use super::dataset::at_most;
use super::fit::FitSettings;
use super::targets::{Target, Targets};
use crate::kinematics::Frames;
use crate::math::Vec3;
use nalgebra::{DMatrix, DVector, Matrix6xX, UnitQuaternion};
use std::f64::consts::PI;

/// Segments that are calibrated, without the side's prefix. Not the trunk: where it is upright is
/// known well, and turning it would move the whole arm.
const CALIBRATED: [&str; 3] = ["UpperArm", "ForeArm", "Hand"];
/// Most frames that are looked at.
const MOST_FRAMES: usize = 80;
/// Frames of a recording resemble each other: together they count as much as so many.
const POSTURES: f64 = 30.0;
/// Standard deviation of a joint beyond the body's limits, rad (3 deg).
const LIMIT_SD: f64 = PI / 60.0;
/// Largest departure from the limits while calibrating, rad: none that matters is excluded.
const ROOM: f64 = 1.5;
const MAX_ROUNDS: usize = 30;
/// Change of a calibration (rad) below which it counts as found.
const CONVERGED: f64 = 1e-5;
/// Keeps the joints determined that no segment tells, 1/rad^2.
const FLOOR: f64 = 1e-6;

/// Whether a segment is one that is calibrated.
pub(super) fn is_calibrated(segment: &str) -> bool {
    CALIBRATED.iter().any(|part| segment.ends_with(part))
}

/// The turns `C` of all recorded segments, in the order of [`Targets::segments`]. `tracked` holds a
/// posture inside the limits for every frame: from there the search stays in the same branch of the
/// angles.
pub(super) fn calibrate(
    chain: &Chain,
    targets: &Targets,
    tracked: &[DVector<f64>],
    settings: &FitSettings,
) -> Vec<UnitQuaternion<f64>> {
    let segments = targets.segments.iter().enumerate();
    let free: Vec<usize> = segments.filter(|(_, s)| is_calibrated(s)).map(|(i, _)| i).collect();
    let chain = chain.loosened(ROOM, LIMIT_SD);
    let frames: Vec<&Target> = at_most(&targets.frames.iter().collect::<Vec<_>>(), MOST_FRAMES);
    let mut turns = vec![UnitQuaternion::identity(); targets.segments.len()];
    let mut postures = at_most(&tracked.iter().collect::<Vec<_>>(), MOST_FRAMES)
        .into_iter()
        .cloned()
        .collect::<Vec<_>>();
    let weight = |sd_deg: f64| sd_deg.to_radians().powi(-2);
    let tilt = weight(settings.tilt_sd_deg);
    let prior = Vec3::new(tilt, weight(settings.axial_sd_deg), tilt);
    let diagonal = DVector::from_fn(3 * free.len(), |i, _| prior[i % 3]);
    let mut scratch = Frames::default();
    let share = POSTURES / frames.len() as f64;
    for _ in 0..MAX_ROUNDS {
        for (q, target) in postures.iter_mut().zip(&frames) {
            let target = target.turned(&turns);
            *q = chain.solve(&target, HandPull::Free, q, None, &mut scratch).q;
        }
        let mut gradient = DVector::zeros(3 * free.len());
        let mut hessian = DMatrix::from_diagonal(&diagonal);
        for (k, &i) in free.iter().enumerate() {
            gradient
                .fixed_rows_mut::<3>(3 * k)
                .copy_from(&turns[i].scaled_axis().component_mul(&prior));
        }
        for (q, target) in postures.iter().zip(&frames) {
            let (slope, curvature) = reduced(&chain, &target.turned(&turns), q, &free);
            gradient.axpy(share, &slope, 1.0);
            hessian += curvature * share;
        }
        let Some(factor) = hessian.cholesky() else { break };
        let step = -factor.solve(&gradient);
        for (k, &i) in free.iter().enumerate() {
            let by: Vec3 = step.fixed_rows::<3>(3 * k).into();
            turns[i] *= UnitQuaternion::from_scaled_axis(by);
        }
        if step.amax() < CONVERGED {
            break;
        }
    }
    turns
}

/// Gradient and Gauss-Newton Hessian of a frame's lowest cost by the turns of the segments `free`:
/// the posture follows them.
fn reduced(
    chain: &Chain,
    target: &Target,
    q: &DVector<f64>,
    free: &[usize],
) -> (DVector<f64>, DMatrix<f64>) {
    let (n, m) = (q.len(), 3 * free.len());
    let mut frames = Frames::default();
    let mut normal = chain.normal(q, target, HandPull::Free, None, &mut frames).hessian;
    for i in 0..n {
        normal[(i, i)] += FLOOR;
    }
    let mut jacobian = Matrix6xX::zeros(n);
    let (mut gradient, mut own) = (DVector::zeros(m), DMatrix::zeros(m, m));
    let mut across = DMatrix::zeros(n, m);
    for (k, &i) in free.iter().enumerate() {
        let turn = chain.turn(i, &target.rotations[i], &frames, &mut jacobian);
        let at = 3 * k;
        gradient.fixed_rows_mut::<3>(at).copy_from(&(turn.own.transpose() * turn.residual));
        own.fixed_view_mut::<3, 3>(at, at).copy_from(&(turn.own.transpose() * turn.own));
        across.fixed_columns_mut::<3>(at).copy_from(&(turn.rows.transpose() * turn.own));
    }
    let Some(factor) = normal.cholesky() else { return (gradient, own) };
    let curvature = own - across.tr_mul(&factor.solve(&across));
    (gradient, curvature)
}

//! Following a sequence of poses from one start posture, knot by knot.

use super::description::Robot;
use super::ease::Ease;
use super::ik::{Residual, Solver};
use crate::math::Pose;
use crate::math::pose::interpolate;

/// Steps of inverse kinematics per knot.
const STEPS: usize = 40;
/// Tolerance of a traced pose, m and rad.
const TRACE_TOLERANCE: f64 = 1e-8;
/// How often the start posture is moved in its null space, as if for so long each, s.
const START_PUSHES: usize = 40;
const START_STEP_S: f64 = 0.1;
/// Into how many pieces a knot that fails is divided, one try each.
const PIECES: [u32; 2] = [4, 16];

/// How far one attempt came.
#[derive(Debug)]
pub(super) struct Track {
    /// Postures at the knots that were reached.
    pub(super) q: Vec<Vec<f64>>,
    /// Largest residuals at them.
    pub(super) worst: Residual,
    /// Where the attempt stopped: nearest posture to the next knot, and what is left.
    pub(super) stop: Option<(Vec<f64>, Residual)>,
}

/// Tracks `targets` (poses of the TCP in the base link's frame) from `start`.
pub(super) fn track(
    solver: &mut Solver,
    targets: &[Pose],
    start: &[f64],
    tolerance: (f64, f64),
) -> Track {
    track_moving(solver, targets, start, tolerance, |_, _| ())
}

/// The same in the null space of `ease`, at times (s).
pub(super) fn track_eased(
    solver: &mut Solver,
    (time_s, targets): (&[f64], &[Pose]),
    start: &[f64],
    tolerance: (f64, f64),
    ease: &mut Ease,
) -> Track {
    let mut q = start.to_vec();
    for _ in 0..START_PUSHES {
        let before = q.clone();
        ease.push(&mut q, START_STEP_S);
        if !solver.solve(&targets[0], &mut q, STEPS).is_within(tolerance.0, tolerance.1) {
            q = before;
            break;
        }
    }
    let push = |k: usize, q: &mut [f64]| {
        if k > 0 {
            ease.push(q, time_s[k] - time_s[k - 1]);
        }
    };
    track_moving(solver, targets, &q, tolerance, push)
}

fn track_moving(
    solver: &mut Solver,
    targets: &[Pose],
    start: &[f64],
    tolerance: (f64, f64),
    mut push: impl FnMut(usize, &mut [f64]),
) -> Track {
    let mut track = Track {
        q: Vec::with_capacity(targets.len()),
        worst: Residual { m: 0.0, rad: 0.0 },
        stop: None,
    };
    let mut q = start.to_vec();
    let is_there = |r: &Residual| r.is_within(tolerance.0, tolerance.1);
    for (k, target) in targets.iter().enumerate() {
        push(k, &mut q);
        let from = q.clone();
        let mut residual = solver.solve(target, &mut q, STEPS);
        let mut nearest = q.clone();
        for pieces in PIECES {
            if is_there(&residual) || k == 0 {
                break;
            }
            q.clone_from(&from);
            let mut last = residual;
            for piece in 1..=pieces {
                let s = f64::from(piece) / f64::from(pieces);
                last = solver.solve(&interpolate(&targets[k - 1], target, s), &mut q, STEPS);
            }
            if last.size() < residual.size() {
                residual = last;
                nearest.clone_from(&q);
            }
        }
        if !is_there(&residual) {
            track.stop = Some((nearest, residual));
            return track;
        }
        q = nearest;
        track.worst.m = track.worst.m.max(residual.m);
        track.worst.rad = track.worst.rad.max(residual.rad);
        track.q.push(q.clone());
    }
    track
}

/// Follows as far as it goes: where a pose is out of reach, the nearest posture stands in and the
/// following goes on from there. Without the pull to the middle of the ranges: the least joint motion.
/// Poses in the world, K; `start` one value per joint.
pub fn trace(robot: &Robot, poses: &[Pose], start: &[f64]) -> Vec<Vec<f64>> {
    let mut solver = Solver::new(robot, TRACE_TOLERANCE, TRACE_TOLERANCE);
    solver.centring = 0.0;
    let mut q = start.to_vec();
    let mut all = Vec::with_capacity(poses.len());
    for pose in poses {
        let before = q.clone();
        solver.solve(&robot.base.inv_mul(pose), &mut q, STEPS);
        if !q.iter().all(|v| v.is_finite()) {
            q = before;
        }
        all.push(q.clone());
    }
    all
}

//! Following a sequence of poses from one start posture, knot by knot.

use super::ik::{Residual, Solver};
use crate::math::Pose;
use crate::math::pose::interpolate;

/// Steps of inverse kinematics per knot.
const STEPS: usize = 40;
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
    let mut track = Track {
        q: Vec::with_capacity(targets.len()),
        worst: Residual { m: 0.0, rad: 0.0 },
        stop: None,
    };
    let mut q = start.to_vec();
    let is_there = |r: &Residual| r.is_within(tolerance.0, tolerance.1);
    for (k, target) in targets.iter().enumerate() {
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

//! How far hand and posture are off as the horizon of a prediction grows (the paper's Fig. 6b).
//!
//! ```text
//! xdot_t  = (x_(t+1) - f(q_t)) / dt        x: the recorded hand, f: that of the predicted posture
//! q_(t+1) = q_t + dt mu(q_t, xdot_t)       from the recorded posture at t = 0, without noise
//! ```
//! This is the paper's own step (section V-C), with nothing that brings a lost hand back or keeps a limit: a
//! law that does not meet the task shows it here. Plans walk by [`roll_out`](crate::posture::roll_out).

use crate::kinematics::Frames;
use crate::math::stats::mean;
use crate::posture::{Coupling, Grips, PostureLaw, Query};
use crate::training::Frame;
use nalgebra::DVector;
use serde::Serialize;

/// Horizons at which errors are told, s.
pub const HORIZONS_S: [f64; 16] =
    [0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0];
/// Share of the movements that must be as long as a horizon for it to be told.
const LEAST_SHARE: f64 = 0.25;
/// A posture further off than this (rad, any joint) is lost, and stays as it is.
const LOST_RAD: f64 = 50.0;

/// Errors of one prediction along one movement, at [`HORIZONS_S`] up to its end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Walk {
    /// Distance of the hand from the recorded one, m.
    pub hand_m: Vec<f64>,
    /// Rms over joints of the error, rad.
    pub joints_rad: Vec<f64>,
}

/// Errors at one horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HorizonPoint {
    /// The horizon, s.
    pub horizon_s: f64,
    /// Movements that are as long.
    pub movements: usize,
    /// Root mean square over them of the hand's distance from the recorded one, mm.
    pub hand_mm: f64,
    /// The same of the joint angles (rms over joints), deg.
    pub joints_deg: f64,
}

/// Errors of a method over the horizon.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HorizonCurve {
    /// Name of the method.
    pub method: &'static str,
    /// By horizon.
    pub points: Vec<HorizonPoint>,
}

/// Walks along a run of frames; none of fewer than two.
pub(super) fn walk(coupling: &Coupling, law: &PostureLaw, run: &[&Frame]) -> Option<Walk> {
    let (first, last) = (run.first()?, run.last()?);
    let dt = (last.time_s - first.time_s) / (run.len() - 1).max(1) as f64;
    let mut frames = Frames::default();
    let mut q = first.q.clone();
    let mut is_lost = false;
    let mut errors = vec![(0.0, 0.0)];
    let still = DVector::zeros(q.len());
    for pair in run.windows(2) {
        let seen = coupling.observe(&q, &mut frames);
        let xdot = coupling.task_error(&seen.grips, &Grips::from(&pair[1].hand)) / dt;
        let at = Query { q: &q, xdot: &xdot, jacobian: &seen.jacobian, phase: pair[0].phase };
        let next = law.expected(&at, &still).map(|v| &q + v * dt);
        // Who is lost once does not come back.
        let near = next.filter(|n| !is_lost && (n - &pair[1].q).amax() < LOST_RAD);
        is_lost = near.is_none();
        q = near.unwrap_or(q);
        let hand = coupling.observe(&q, &mut frames).grips.first.translation.vector;
        let hand_m = (hand - pair[1].hand.translation.vector).norm();
        let off = &q - &pair[1].q;
        errors.push((hand_m, (off.norm_squared() / off.len() as f64).sqrt()));
    }
    let at = |h: &f64| Some((h / dt).round() as usize).filter(|k| *k < errors.len());
    let told: Vec<(f64, f64)> = HORIZONS_S.iter().map_while(at).map(|k| errors[k]).collect();
    Some(Walk {
        hand_m: told.iter().map(|e| e.0).collect(),
        joints_rad: told.iter().map(|e| e.1).collect(),
    })
}

/// Root mean squares over walks, as far as enough of them go.
pub(super) fn curve(method: &'static str, walks: &[&Walk]) -> HorizonCurve {
    let rms = |values: Vec<f64>| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt();
    let point = |(k, horizon_s): (usize, &f64)| {
        let of = |pick: fn(&Walk) -> &Vec<f64>| -> Vec<f64> {
            walks.iter().filter_map(|w| pick(w).get(k).copied()).collect()
        };
        let hands = of(|w| &w.hand_m);
        let movements = hands.len();
        (movements > 0 && movements as f64 >= LEAST_SHARE * walks.len() as f64).then(|| {
            HorizonPoint {
                horizon_s: *horizon_s,
                movements,
                hand_mm: 1e3 * rms(hands),
                joints_deg: rms(of(|w| &w.joints_rad)).to_degrees(),
            }
        })
    };
    HorizonCurve { method, points: HORIZONS_S.iter().enumerate().map_while(point).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::dataset::tests::made_up;
    use nalgebra::DMatrix;

    #[test]
    fn a_law_that_meets_the_task_keeps_the_hand_and_one_that_rests_does_not() {
        let data = made_up(1, 3.0, 30.0);
        let run: Vec<&Frame> = data.frames.iter().collect();
        let plain = PostureLaw::of_weight(DMatrix::identity(24, 24), 1.6, 6);
        let kept = walk(&data.coupling, &plain, &run).unwrap();
        // 3 s: horizons up to 2.5 s.
        assert_eq!(kept.hand_m.len(), 9);
        assert!(kept.hand_m.iter().all(|e| *e < 0.01), "{:?}", kept.hand_m);
        let rests = PostureLaw { is_direct: true, ..plain };
        let left = walk(&data.coupling, &rests, &run).unwrap();
        for (k, h) in HORIZONS_S.iter().enumerate().take(9) {
            let there = &run[(30.0 * h).round() as usize];
            let hand = (there.hand.translation.vector - run[0].hand.translation.vector).norm();
            let joints = (&there.q - &run[0].q).norm() / 24f64.sqrt();
            assert!((left.hand_m[k] - hand).abs() < 1e-9);
            assert!((left.joints_rad[k] - joints).abs() < 1e-9);
        }
        let curve = curve("x", &[&kept, &left]);
        assert_eq!((curve.points.len(), curve.points[0].movements), (9, 2));
        let expected = (0.5 * (kept.hand_m[3].powi(2) + left.hand_m[3].powi(2))).sqrt();
        assert!((curve.points[3].hand_mm - 1e3 * expected).abs() < 1e-9);
    }

    #[test]
    fn horizons_that_few_reach_are_not_told() {
        let of = |count: usize| Walk { hand_m: vec![0.1; count], joints_rad: vec![0.1; count] };
        let all: Vec<Walk> = [3, 2, 2, 2, 2].map(of).to_vec();
        assert_eq!(curve("x", &all.iter().collect::<Vec<_>>()).points.len(), 2);
        assert_eq!(curve("x", &all[..4].iter().collect::<Vec<_>>()).points.len(), 3);
        assert!(curve("x", &[]).points.is_empty());
    }
}

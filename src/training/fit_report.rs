//! How well a fitted movement matches its recording, in figures and in words.
//!
//! ```text
//! hand residual = |p_hand(q) + offset - p_recorded|     coupling error = rms |J(q) qdot - d/dt p_recorded|
//! ```

use super::calibration::is_calibrated;
use super::chain::Chain;
use super::fit::{FitSettings, Found, Offset, Smooth};
use super::fit_remarks::remarks;
use super::targets::Targets;
use crate::human::Side;
use crate::kinematics::Frames;
use crate::math::signal::{differentiate, low_pass_zero_phase};
use crate::math::{Vec3, stats};
use crate::recording::{Recording, Remark};
use nalgebra::{DVector, UnitQuaternion};
use serde::Serialize;

/// A joint this near to a bound presses on it, deg.
const AT_LIMIT_DEG: f64 = 0.1;

/// Root mean square and quantiles of a residual.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// Length of a segment in the recording and in the body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SegmentLength {
    /// Name of the segment.
    pub segment: String,
    /// Between the recorded joint centres, m.
    pub recorded_m: f64,
    /// Of the body, m.
    pub body_m: f64,
}

/// A joint that was recorded beyond the range of the body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// Name of the joint.
    pub joint: String,
    /// How far beyond, at most, deg.
    pub largest_deg: f64,
    /// Share of the frames.
    pub frames_share: f64,
}

/// The quality of a fit; all figures are those of the final (filtered) posture against the recording
/// as it was read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitReport {
    /// Number of frames.
    pub frames: usize,
    /// Distance of the model's wrist joint centre, offset added, from the recorded one, mm.
    pub hand_residual_mm: Spread,
    /// Angle between model and record of each recorded segment, rms, deg.
    pub orientation_residual_deg: Vec<(String, f64)>,
    /// Constant turns of the recorded arm segments about their own axes (x forward, y up, z right of
    /// an arm that hangs with the palm forward) that bring them to the model's, deg.
    pub calibration_deg: Vec<(String, [f64; 3])>,
    /// How far the recorded arm stretches, standard deviation, mm.
    pub stretch_mm: f64,
    /// Joints beyond the body's range, widest first.
    pub beyond_range: Vec<Beyond>,
    /// Share of frames with at least one joint or sum within 0.1 deg of a bound of the fit: the
    /// body's range with the slack of the settings.
    pub frames_at_limit_share: f64,
    /// Joints and sums that were there, with their share of frames, most frequent first.
    pub joints_at_limit: Vec<(String, f64)>,
    /// Constant offset added to the model's wrist, pelvis axes (x forward, y up, z right), mm.
    pub pelvis_offset_mm: [f64; 3],
    /// What that constant leaves under a fit of the orientations alone, rms, mm.
    pub offset_spread_mm: f64,
    /// `J(q) qdot` against the derivative of the (equally filtered) recorded wrist, rms, m/s.
    pub coupling_error_m_s: f64,
    /// Speed of that wrist in the pelvis frame, rms, m/s: what the coupling error is to be compared with.
    pub hand_speed_m_s: f64,
    /// Upper arm and forearm, where the recording tells them.
    pub lengths: Vec<SegmentLength>,
    /// Stature at which the body's arm would be as long as the recorded one, m.
    pub stature_hint_m: Option<f64>,
    /// Frames that the filter had carried outside a limit and that were put back.
    pub frames_projected: usize,
    /// How far it had carried them, at most, deg.
    pub largest_overshoot_deg: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff_hz: f64,
    /// Settings of the fit.
    pub settings: FitSettings,
    /// What a person should know, one sentence each.
    #[serde(rename = "notes")]
    pub remarks: Vec<Remark>,
}

/// Compares the final postures with the recording.
pub(super) fn describe(
    recording: &Recording,
    side: Side,
    chain: &Chain,
    targets: &Targets,
    smooth: &Smooth,
    qdot: &[Vec<f64>],
    Found { offset, turns: calibration, settings }: &Found,
) -> FitReport {
    let (hand, turns) = residuals(chain, targets, smooth, offset);
    let (frames_at_limit_share, joints_at_limit) = at_limits(chain, &smooth.q);
    let lengths = lengths(recording, side, chain);
    let (recorded, own) =
        lengths.iter().fold((0.0, 0.0), |sum, l| (sum.0 + l.recorded_m, sum.1 + l.body_m));
    let (coupling_error_m_s, hand_speed_m_s) =
        coupling_error(recording, chain, targets, smooth, qdot, settings);
    let mut report = FitReport {
        frames: smooth.q.len(),
        hand_residual_mm: spread(&hand),
        orientation_residual_deg: turns,
        calibration_deg: calibrated(&targets.segments, calibration),
        stretch_mm: targets.stretch_m * 1e3,
        beyond_range: beyond(chain, &smooth.q),
        frames_at_limit_share,
        joints_at_limit,
        pelvis_offset_mm: (offset.mean * 1e3).into(),
        offset_spread_mm: offset.spread * 1e3,
        coupling_error_m_s,
        hand_speed_m_s,
        stature_hint_m: (lengths.len() == 2).then(|| chain.stature_m * recorded / own),
        lengths,
        frames_projected: smooth.frames_projected,
        largest_overshoot_deg: smooth.largest_overshoot.to_degrees(),
        cutoff_hz: settings.cutoff_hz,
        settings: *settings,
        remarks: Vec::new(),
    };
    report.remarks = remarks(&report, recording, chain, side, targets, &smooth.q);
    report
}

fn spread(x: &[f64]) -> Spread {
    let squares: Vec<f64> = x.iter().map(|v| v * v).collect();
    let at = |p: f64| stats::quantile(x, p);
    Spread { rms: stats::mean(&squares).sqrt(), p50: at(0.5), p95: at(0.95), max: at(1.0) }
}

/// Hand residuals (mm) per frame, and rms angles (deg) per segment.
fn residuals(
    chain: &Chain,
    targets: &Targets,
    smooth: &Smooth,
    offset: &Offset,
) -> (Vec<f64>, Vec<(String, f64)>) {
    let mut frames = Frames::default();
    let mut hand = Vec::with_capacity(smooth.q.len());
    let mut squares = vec![0.0; targets.segments.len()];
    for (q, target) in smooth.q.iter().zip(&targets.frames) {
        chain.linkage.forward(q.as_slice(), &mut frames);
        hand.push((chain.hand(&frames) + offset.mean - target.hand).norm() * 1e3);
        for (sum, turn) in squares.iter_mut().zip(chain.turns(&frames, target)) {
            *sum += turn.norm_squared();
        }
    }
    let rms = |sum: &f64| (sum / hand.len() as f64).sqrt().to_degrees();
    let turns = targets.segments.iter().cloned().zip(squares.iter().map(rms)).collect();
    (hand, turns)
}

/// The turns of the segments that were calibrated, deg.
fn calibrated(segments: &[String], turns: &[UnitQuaternion<f64>]) -> Vec<(String, [f64; 3])> {
    let all = segments.iter().zip(turns).filter(|(name, _)| is_calibrated(name));
    all.map(|(name, c)| (name.clone(), c.scaled_axis().map(f64::to_degrees).into())).collect()
}

/// Joints beyond the range of the body in any posture, widest first.
fn beyond(chain: &Chain, postures: &[DVector<f64>]) -> Vec<Beyond> {
    let limits = &chain.body_limits;
    let joints = chain.linkage.joints().iter().enumerate();
    let mut found: Vec<Beyond> = joints
        .filter_map(|(i, joint)| {
            let out = |q: &DVector<f64>| (limits.lower[i] - q[i]).max(q[i] - limits.upper[i]);
            let all: Vec<f64> = postures.iter().map(out).filter(|o| *o > 1e-9).collect();
            Some(Beyond {
                joint: joint.name.clone(),
                largest_deg: all.iter().copied().reduce(f64::max)?.to_degrees(),
                frames_share: all.len() as f64 / postures.len() as f64,
            })
        })
        .collect();
    found.sort_by(|a, b| b.largest_deg.total_cmp(&a.largest_deg));
    found
}

/// Share of frames with anything at a limit, and what, with its share.
fn at_limits(chain: &Chain, postures: &[DVector<f64>]) -> (f64, Vec<(String, f64)>) {
    let near = |value: f64, lower: f64, upper: f64| {
        (value - lower).min(upper - value) < AT_LIMIT_DEG.to_radians()
    };
    let limits = &chain.limits;
    let joints = chain.linkage.joints();
    let mut counts = vec![0usize; joints.len() + limits.sums.len()];
    let mut frames = 0;
    for q in postures {
        let single = (0..joints.len()).filter(|&i| near(q[i], limits.lower[i], limits.upper[i]));
        let sums = limits
            .sums
            .iter()
            .enumerate()
            .filter(|(_, s)| near(s.columns.iter().map(|&c| q[c]).sum(), s.lower, s.upper));
        let pressed: Vec<usize> = single.chain(sums.map(|(k, _)| joints.len() + k)).collect();
        frames += usize::from(!pressed.is_empty());
        for i in pressed {
            counts[i] += 1;
        }
    }
    let share = |count: usize| count as f64 / postures.len() as f64;
    let names = joints.iter().map(|j| &j.name).chain(limits.sums.iter().map(|s| &s.name));
    let mut found: Vec<(String, f64)> = names
        .zip(&counts)
        .filter(|(_, count)| **count > 0)
        .map(|(name, &count)| (name.clone(), share(count)))
        .collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    (share(frames), found)
}

/// Upper arm and forearm, where recorded.
fn lengths(recording: &Recording, side: Side, chain: &Chain) -> Vec<SegmentLength> {
    let own = [("UpperArm", chain.upper_arm_m), ("ForeArm", chain.forearm_m)];
    own.iter()
        .filter_map(|&(part, body_m)| {
            let segment = format!("{}{part}", side.prefix());
            let recorded_m = recording.length_m(&segment).filter(|l| l.is_finite() && *l > 0.0)?;
            Some(SegmentLength { segment, recorded_m, body_m })
        })
        .collect()
}

/// Rms of `J(q) qdot` minus the velocity of the recorded wrist, filtered like the angles, and rms of
/// that velocity, m/s.
fn coupling_error(
    recording: &Recording,
    chain: &Chain,
    targets: &Targets,
    smooth: &Smooth,
    qdot: &[Vec<f64>],
    settings: &FitSettings,
) -> (f64, f64) {
    let velocity = [0, 1, 2].map(|axis| {
        let path: Vec<f64> = targets.frames.iter().map(|t| t.hand[axis]).collect();
        let path = low_pass_zero_phase(&path, recording.rate_hz, settings.cutoff_hz);
        differentiate(&path, 1.0 / recording.rate_hz)
    });
    let mut frames = Frames::default();
    let (mut error, mut speed) = (0.0, 0.0);
    for (i, (q, rates)) in smooth.q.iter().zip(qdot).enumerate() {
        chain.linkage.forward(q.as_slice(), &mut frames);
        let twist = chain.hand_jacobian(&frames) * DVector::from_column_slice(rates);
        let measured = Vec3::new(velocity[0][i], velocity[1][i], velocity[2][i]);
        error += (twist.fixed_rows::<3>(0) - measured).norm_squared();
        speed += measured.norm_squared();
    }
    let rms = |sum: f64| (sum / smooth.q.len() as f64).sqrt();
    (rms(error), rms(speed))
}

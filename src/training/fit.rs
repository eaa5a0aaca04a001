//! Joint angles of one body from recorded segment poses: a bounded least-squares fit per frame.
//!
//! ```text
//! orientations, limits ─► C: constant turns of the recorded axes (see the calibration)
//! orientations alone ─► offset = mean(p_recorded - p_model)   (the recorded trunk is not the body's)
//! orientations and hand + offset ─► q(t) ─ low-pass ─► q ─ central differences ─► qdot
//! ```
//! Everything is relative to the recorded pelvis. Angles of the file are never copied: they belong
//! to another chain, and may break this body's limits.

use super::calibration::calibrate;
use super::chain::{Chain, HandPull};
use super::fit_report::{FitReport, describe};
use super::targets::{Target, Targets};
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::kinematics::Frames;
use crate::math::signal::{differentiate, low_pass_zero_phase};
use crate::math::{Vec3, stats};
use crate::recording::Recording;
use nalgebra::{DVector, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// How much each observation and each prior is trusted, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitSettings {
    /// Orientation of a segment about each axis, deg.
    pub orientation_sd_deg: f64,
    /// Axial rotation of the upper arm, deg: skin and marker clusters know it badly. Also how far a
    /// recorded segment of the arm may be turned about its long axis for the whole recording.
    pub axial_sd_deg: f64,
    /// Wrist joint centre, mm, of a recording with rigid bones; where the recorded arm stretches, its
    /// stretch is added in quadrature.
    pub hand_sd_mm: f64,
    /// Departure of a spine joint from its usual share of the trunk's turn, deg. Larger than that of
    /// an orientation, so that recorded segments decide where there are any. Much larger, and joints
    /// between recorded segments bend against each other to carry the shoulder towards the hand: of
    /// the hand-over's giver the spine then moves at 0.29 rad/s (rms) instead of 0.05 for the same
    /// hand, and the velocities of unseen movement are predicted worse by a half.
    pub sharing_sd_deg: f64,
    /// Departure of a joint from the frame before, deg. Large: it only steadies undetermined joints.
    pub previous_sd_deg: f64,
    /// How far a constant misalignment of a recorded segment may tilt its long axis, deg. Small:
    /// joint centres show where that axis points. About the axis it is `axial_sd_deg`. The folds of
    /// two people's hand-over and of a kick, on which this was compared, are predicted no better
    /// with 10.
    pub tilt_sd_deg: f64,
    /// How far a joint may go beyond the body's range where the recording does so even when
    /// calibrated, deg. People do, and skeletons do at a nearly straight elbow, whose axis they know
    /// badly. A joint held at a limit stands still while others move in its stead: the relative RMSE
    /// of unseen joint velocities (full-w, mean over six folds of each of three people) is 0.47,
    /// 0.44, 0.42 and 0.42 for 0, 5, 10 and 15 deg. More than 15 changes nothing.
    pub limit_slack_deg: f64,
    /// Cut-off of the zero-phase low-pass filter, Hz; nothing is filtered at or above a quarter of
    /// the frame rate.
    pub cutoff_hz: f64,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            orientation_sd_deg: 5.0,
            axial_sd_deg: 15.0,
            hand_sd_mm: 5.0,
            sharing_sd_deg: 10.0,
            previous_sd_deg: 60.0,
            tilt_sd_deg: 5.0,
            limit_slack_deg: 15.0,
            cutoff_hz: 6.0,
        }
    }
}

/// A movement of one body: what a recording becomes before anything is learned from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointMotion {
    /// Name of the recording.
    pub source: String,
    /// The 24 joints from the pelvis to the grip, in column order.
    pub joints: Vec<String>,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Joint angles, T x 24, rad: filtered, inside all sums of the body, and beyond its joint limits
    /// by no more than the slack of the settings.
    pub q: Vec<Vec<f64>>,
    /// Joint velocities, T x 24, rad/s: central differences of `q`.
    pub qdot: Vec<Vec<f64>>,
    /// How good the fit is.
    pub report: FitReport,
}

/// The constant offset between recorded and model wrist, and how constant it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Offset {
    /// Recorded minus model, pelvis axes, m.
    pub mean: Vec3,
    /// Root mean square of what the mean leaves under orientations alone, m.
    pub spread: f64,
}

/// What a fit took as constant, and how.
pub(super) struct Found {
    pub offset: Offset,
    /// Turns of the recorded segments about their own axes.
    pub turns: Vec<UnitQuaternion<f64>>,
    pub settings: FitSettings,
}

/// Filtered postures.
pub(super) struct Smooth {
    pub q: Vec<DVector<f64>>,
    /// Frames that the filter had carried outside the limits and that were put back.
    pub frames_projected: usize,
    /// Largest excursion outside the limits, rad.
    pub largest_overshoot: f64,
}

/// Fits the chain from the pelvis to the grip of `side` to a recording.
///
/// Each frame is solved inside the body's limits, joints with the slack of the settings, started at
/// the frame before; the angles are then filtered and differentiated. Frames that the filter carries
/// further are put back to the nearest posture inside, and the report counts them.
///
/// # Errors
/// Where the recording lacks the pelvis, T8, the upper arm, the forearm or the hand of the side,
/// has fewer than four frames or values that are not finite; where a setting is not positive.
pub fn fit(
    recording: &Recording,
    body: &Body,
    side: Side,
    settings: &FitSettings,
) -> Result<JointMotion, InputError> {
    settings.check()?;
    if !(recording.rate_hz.is_finite() && recording.rate_hz > 0.0) {
        let message = format!("has a frame rate of {} Hz", recording.rate_hz);
        return Err(InputError::new(&recording.source, message).remedy("state a positive rate"));
    }
    let mut targets = Targets::new(recording, side)?;
    let chain = Chain::new(body, side, &targets.segments, settings)?;
    let mut starts = starts(&chain, side);
    let uncalibrated = track(&chain, &targets.frames, HandPull::Free, &starts);
    let turns = calibrate(&chain, &targets, &uncalibrated, settings);
    targets.turn(&turns);
    let chain = chain
        .trusting_hand(settings.hand_sd_mm.hypot(1e3 * targets.stretch_m))
        .loosened(settings.limit_slack_deg.to_radians(), f64::INFINITY);
    starts.extend(uncalibrated.into_iter().take(1));
    let by_orientation = track(&chain, &targets.frames, HandPull::Free, &starts);
    let offset = pelvis_offset(&chain, &targets.frames, &by_orientation);
    starts.extend(by_orientation.into_iter().take(1));
    let fitted = track(&chain, &targets.frames, HandPull::At(offset.mean), &starts);
    let smooth = smooth(&chain, &fitted, recording.rate_hz, settings.cutoff_hz);
    let qdot = columns_to_rows(
        &rows_to_columns(&smooth.q)
            .iter()
            .map(|angle| differentiate(angle, 1.0 / recording.rate_hz))
            .collect::<Vec<_>>(),
    );
    let found = Found { offset, turns, settings: *settings };
    let report = describe(recording, side, &chain, &targets, &smooth, &qdot, &found);
    Ok(JointMotion {
        source: recording.source.clone(),
        joints: chain.linkage.joints().iter().map(|j| j.name.clone()).collect(),
        rate_hz: recording.rate_hz,
        q: smooth.q.iter().map(|q| q.as_slice().to_vec()).collect(),
        qdot,
        report,
    })
}

impl FitSettings {
    fn check(&self) -> Result<(), InputError> {
        for (name, value) in [
            ("orientation_sd_deg", self.orientation_sd_deg),
            ("axial_sd_deg", self.axial_sd_deg),
            ("tilt_sd_deg", self.tilt_sd_deg),
            ("hand_sd_mm", self.hand_sd_mm),
            ("sharing_sd_deg", self.sharing_sd_deg),
            ("previous_sd_deg", self.previous_sd_deg),
            ("cutoff_hz", self.cutoff_hz),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(InputError::new("fit settings", format!("{name} = {value}"))
                    .remedy(format!("{name} must be a positive number")));
            }
        }
        if !(self.limit_slack_deg.is_finite() && self.limit_slack_deg >= 0.0) {
            let message = format!("limit_slack_deg = {}", self.limit_slack_deg);
            return Err(InputError::new("fit settings", message)
                .remedy("limit_slack_deg must be zero or a positive number"));
        }
        Ok(())
    }
}

/// Postures to try for the first frame, all inside the limits.
fn starts(chain: &Chain, side: Side) -> Vec<DVector<f64>> {
    // Shoulder flexion, adduction, elbow flexion, pronation, deg: hanging, before the chest, high,
    // sideways, behind.
    let arms = [
        [0.0, -5.0, 20.0, 90.0],
        [45.0, -30.0, 90.0, 90.0],
        [150.0, -20.0, 30.0, 90.0],
        [0.0, -85.0, 20.0, 90.0],
        [-30.0, -10.0, 90.0, 60.0],
    ];
    let mirror = if side == Side::Left { -1.0 } else { 1.0 };
    let rest = chain.rest();
    let posture = |arm: &[f64; 4]| {
        let mut wanted = rest.clone();
        let joints = ["Shoulder_Z", "Shoulder_X", "Elbow_Z", "Elbow_Y"];
        for (joint, (value, sign)) in joints.iter().zip(arm.iter().zip([1.0, mirror, 1.0, mirror]))
        {
            let name = format!("j{}{joint}", side.prefix());
            if let Some(c) = chain.linkage.joints().iter().position(|j| j.name == name) {
                wanted[c] = (sign * value).to_radians();
            }
        }
        chain.nearest_feasible(wanted.as_slice(), &rest)
    };
    arms.iter().map(posture).collect()
}

/// One posture per frame, each started at the one before; the first at the best of `starts`.
fn track(
    chain: &Chain,
    targets: &[Target],
    pull: HandPull,
    starts: &[DVector<f64>],
) -> Vec<DVector<f64>> {
    let mut frames = Frames::default();
    let mut found: Vec<DVector<f64>> = Vec::with_capacity(targets.len());
    for target in targets {
        let q = if let Some(before) = found.last() {
            chain.solve(target, pull, before, Some(before), &mut frames).q
        } else {
            let tried = starts.iter().map(|s| chain.solve(target, pull, s, None, &mut frames));
            let best = tried.min_by(|a, b| a.cost.total_cmp(&b.cost));
            best.map_or_else(|| chain.rest(), |s| s.q)
        };
        found.push(q);
    }
    found
}

/// Mean of recorded minus model wrist over the frames, without the outer tenth on either side.
fn pelvis_offset(chain: &Chain, targets: &[Target], postures: &[DVector<f64>]) -> Offset {
    let mut frames = Frames::default();
    let gaps: Vec<Vec3> = targets
        .iter()
        .zip(postures)
        .map(|(t, q)| {
            chain.linkage.forward(q.as_slice(), &mut frames);
            t.hand - chain.hand(&frames)
        })
        .collect();
    let trimmed = |axis: usize| {
        let mut values: Vec<f64> = gaps.iter().map(|g| g[axis]).collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len() / 10;
        stats::mean(&values[cut..values.len() - cut])
    };
    let mean = Vec3::new(trimmed(0), trimmed(1), trimmed(2));
    let squares: Vec<f64> = gaps.iter().map(|g| (g - mean).norm_squared()).collect();
    Offset { mean, spread: stats::mean(&squares).sqrt() }
}

/// Filters every joint, then puts back what the filter carried outside the limits.
fn smooth(chain: &Chain, fitted: &[DVector<f64>], rate_hz: f64, cutoff_hz: f64) -> Smooth {
    let filtered: Vec<Vec<f64>> = rows_to_columns(fitted)
        .iter()
        .map(|angle| low_pass_zero_phase(angle, rate_hz, cutoff_hz))
        .collect();
    let mut result = Smooth { q: Vec::new(), frames_projected: 0, largest_overshoot: 0.0 };
    for (wanted, inside) in columns_to_rows(&filtered).into_iter().zip(fitted) {
        let overshoot = chain.limits.violation(&wanted);
        // Rounding is put back too, but not worth a word.
        if overshoot > 1e-6 {
            result.frames_projected += 1;
        }
        result.largest_overshoot = result.largest_overshoot.max(overshoot);
        result.q.push(if overshoot > 0.0 {
            chain.nearest_feasible(&wanted, inside)
        } else {
            DVector::from_vec(wanted)
        });
    }
    result
}

fn rows_to_columns(rows: &[DVector<f64>]) -> Vec<Vec<f64>> {
    let n = rows.first().map_or(0, DVector::len);
    (0..n).map(|c| rows.iter().map(|r| r[c]).collect()).collect()
}

fn columns_to_rows(columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let count = columns.first().map_or(0, Vec::len);
    (0..count).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
}

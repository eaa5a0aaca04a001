//! How near a fitted body comes to each recorded segment, and how planted feet slide.
//!
//! ```text
//! d_t = R_pelvis^T (p_recorded - p_model)        constant |mean d|      scatter |d_t - mean d|
//! r_t = log(R_model^T R_recorded)                constant |mean r|      scatter |r_t - mean r|
//! ```
//! A constant part is a joint centre or an axis that lies elsewhere in the two skeletons; only the scatter is
//! an error of the movement.

use crate::files::InputError;
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::{Vec3, stats};
use crate::recording::{Recording, SegmentTrack};
use crate::training::source::{Source, Whom};
use crate::training::targets::segment_names;
use nalgebra::{Rotation3, UnitQuaternion};
use serde::Serialize;

/// A foot whose ball goes slower than this is planted, m/s.
const PLANTED_M_S: f64 = 0.15;
/// Shortest time that counts as standing, s.
const STANDS_S: f64 = 0.3;

/// Size of a residual: what is constant, and what it leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residuals {
    /// Length of the mean.
    pub constant: f64,
    /// Median of what the mean leaves.
    pub median: f64,
    /// 95th percentile of what the mean leaves.
    pub p95: f64,
}

/// One segment of the chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SegmentQuality {
    /// Name of the segment.
    pub segment: String,
    /// Of its proximal joint centre, mm.
    pub place_mm: Residuals,
    /// Of its turn, deg.
    pub turn_deg: Residuals,
}

/// Way of a planted foot while it stands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drift {
    /// Times for which a foot stands.
    pub stands: usize,
    /// Median over these of the largest way from where the foot stands, mm.
    pub median_mm: f64,
    /// Largest of them, mm.
    pub largest_mm: f64,
}

impl Residuals {
    fn of(all: &[Vec3], unit: f64) -> Self {
        let mean = all.iter().sum::<Vec3>() / all.len().max(1) as f64;
        let scatter: Vec<f64> = all.iter().map(|v| unit * (v - mean).norm()).collect();
        Self {
            constant: unit * mean.norm(),
            median: stats::quantile(&scatter, 0.5),
            p95: stats::quantile(&scatter, 0.95),
        }
    }
}

/// The residuals of all recorded segments between pelvis and hand.
pub(super) fn segments(
    recording: &Recording,
    whom: &Whom,
    source: &Source,
) -> Result<Vec<SegmentQuality>, InputError> {
    let (Some(pelvis), Some(trial)) = (recording.segment("Pelvis"), source.trials.first()) else {
        return Ok(Vec::new());
    };
    let tracks: Vec<&SegmentTrack> =
        segment_names(whom.side).iter().filter_map(|n| recording.segment(n)).collect();
    // The grip first: its chain has the leading columns.
    let mut tips = vec![Tip::link(whom.side.grip())];
    tips.extend(tracks.iter().map(|t| Tip::link(&t.name)));
    let chain = Linkage::new(&whom.body.model, "Pelvis", &tips)
        .map_err(|e| InputError::fault(&whom.body.name, e.to_string()))?;
    let mut frames = Frames::default();
    let mut found = vec![(Vec::new(), Vec::new()); tracks.len()];
    for (i, q) in trial.q.iter().enumerate() {
        chain.forward(&q[q.len() - chain.dof()..], &mut frames);
        let inverse = pelvis.rotation[i].inverse();
        for (k, track) in tracks.iter().enumerate() {
            let (place, turn) = chain.tip_frame(&frames, k + 1);
            let turn =
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
            let recorded = inverse * track.rotation[i];
            found[k].0.push(inverse * (track.position[i] - pelvis.position[i]) - place);
            found[k].1.push((turn.inverse() * recorded).scaled_axis());
        }
    }
    let quality =
        |(track, (places, turns)): (&&SegmentTrack, (Vec<Vec3>, Vec<Vec3>))| SegmentQuality {
            segment: track.name.clone(),
            place_mm: Residuals::of(&places, 1e3),
            turn_deg: Residuals::of(&turns, 1f64.to_degrees()),
        };
    Ok(tracks.iter().zip(found).map(quality).collect())
}

/// How far planted feet slide over the floor; none where nothing is known of feet, or none ever stands.
pub fn drift(recording: &Recording) -> Option<Drift> {
    let mut slides = Vec::new();
    for side in ["Right", "Left"] {
        let ball = recording.segment(&format!("{side}Toe"));
        let Some(foot) = ball.or_else(|| recording.segment(&format!("{side}Foot"))) else {
            continue;
        };
        slides.extend(slides_of(&foot.position, recording.rate_hz));
    }
    (!slides.is_empty()).then(|| Drift {
        stands: slides.len(),
        median_mm: 1e3 * stats::quantile(&slides, 0.5),
        largest_mm: 1e3 * stats::quantile(&slides, 1.0),
    })
}

/// The largest way from its middle place of each time for which a foot stands, m.
fn slides_of(places: &[Vec3], rate_hz: f64) -> Vec<f64> {
    let slow = |i: usize| {
        i > 0
            && i + 1 < places.len()
            && 0.5 * rate_hz * (places[i + 1] - places[i - 1]).norm() < PLANTED_M_S
    };
    let fewest = (STANDS_S * rate_hz).ceil() as usize;
    let mut slides = Vec::new();
    let mut from = 0;
    for i in 0..=places.len() {
        if i < places.len() && slow(i) {
            continue;
        }
        if i - from >= fewest.max(2) {
            let middle = |axis: usize| {
                stats::quantile(&places[from..i].iter().map(|p| p[axis]).collect::<Vec<_>>(), 0.5)
            };
            let (x, y) = (middle(0), middle(1));
            let away = places[from..i].iter().map(|p| (p.x - x).hypot(p.y - y));
            slides.push(away.fold(0.0, f64::max));
        }
        from = i + 1;
    }
    slides
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_constant_is_told_from_scatter() {
        let around = |v: f64| Vec3::new(0.03 + v, 0.04, 0.0);
        let found = Residuals::of(&[around(0.01), around(-0.01), around(0.01), around(-0.01)], 1e3);
        assert_relative_eq!(found.constant, 50.0, epsilon = 1e-9);
        assert_relative_eq!(found.median, 10.0, epsilon = 1e-9);
        assert_relative_eq!(found.p95, 10.0, epsilon = 1e-9);
    }

    #[test]
    fn a_planted_foot_slides_and_a_stepping_one_does_not_count() {
        // Creeps by 40 mm in 2 s, steps by 0.5 m, and stands still.
        let place = |i: usize| match i {
            0..=200 => 0.0002 * i as f64,
            201..=240 => 0.04 + 0.0125 * (i - 200) as f64,
            _ => 0.54,
        };
        let places: Vec<Vec3> = (0..400).map(|i| Vec3::new(0.0, place(i), 0.1)).collect();
        let found = slides_of(&places, 100.0);
        assert_eq!(found.len(), 2);
        assert_relative_eq!(found[0], 0.02, epsilon = 5e-4);
        assert!(found[1] < 1e-9);
    }
}

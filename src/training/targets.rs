//! What a recording says about one arm chain, relative to the recorded pelvis.
//!
//! ```text
//! R_target = R_pelvis^T R_segment      p_target = R_pelvis^T (p_hand - p_pelvis)
//! ```

use crate::files::InputError;
use crate::human::Side;
use crate::math::Vec3;
use crate::recording::{Recording, SegmentTrack};
use nalgebra::UnitQuaternion;

/// Segments that a fit can use, base to tip; the last four carry the side's prefix.
const TRUNK: [&str; 4] = ["L5", "L3", "T12", "T8"];
const ARM: [&str; 4] = ["Shoulder", "UpperArm", "ForeArm", "Hand"];
/// Frames below which there is no motion to speak of.
const MIN_FRAMES: usize = 4;

/// Names of all segments between the pelvis and the hand, base to tip.
pub(super) fn segment_names(side: Side) -> Vec<String> {
    let arm = ARM.iter().map(|s| format!("{}{s}", side.prefix()));
    TRUNK.iter().map(|s| (*s).to_owned()).chain(arm).collect()
}

/// One frame in pelvis axes.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// Orientation of each recorded segment, in the order of [`Targets::segments`].
    pub rotations: Vec<UnitQuaternion<f64>>,
    /// Wrist joint centre from the pelvis origin, m.
    pub hand: Vec3,
}

impl Target {
    /// The same frame with every recorded segment turned by a rotation about its own axes.
    pub(super) fn turned(&self, turns: &[UnitQuaternion<f64>]) -> Self {
        let rotations = self.rotations.iter().zip(turns).map(|(r, c)| r * c).collect();
        Self { rotations, hand: self.hand }
    }
}

/// All frames.
#[derive(Debug, Clone)]
pub(super) struct Targets {
    /// The chain's segments that were recorded.
    pub segments: Vec<String>,
    pub frames: Vec<Target>,
    /// How far the recorded upper arm and forearm stretch, standard deviation, m: zero of rigid bones,
    /// some centimetres of a solved skeleton that gives way between its joints.
    pub stretch_m: f64,
}

impl Targets {
    /// Turns every recorded segment about its own axes, in all frames.
    pub(super) fn turn(&mut self, turns: &[UnitQuaternion<f64>]) {
        for frame in &mut self.frames {
            *frame = frame.turned(turns);
        }
    }

    /// # Errors
    /// Where the pelvis, the thorax, the upper arm, the forearm or the hand is missing, where there
    /// are fewer than four frames, or a number is not finite.
    pub(super) fn new(recording: &Recording, side: Side) -> Result<Self, InputError> {
        let pelvis = required(recording, "Pelvis")?;
        let hand = required(recording, &format!("{}Hand", side.prefix()))?;
        required(recording, "T8")?;
        let upper_arm = required(recording, &format!("{}UpperArm", side.prefix()))?;
        let forearm = required(recording, &format!("{}ForeArm", side.prefix()))?;
        let tracks: Vec<&SegmentTrack> =
            segment_names(side).iter().filter_map(|n| recording.segment(n)).collect();
        let count = recording.frames();
        if count < MIN_FRAMES {
            let message = format!("holds {count} frames, too few for a movement");
            return Err(InputError::new(&recording.source, message)
                .remedy(format!("record at least {MIN_FRAMES} frames")));
        }
        let frame = |i: usize| {
            let inverse = pelvis.rotation[i].inverse();
            Target {
                rotations: tracks.iter().map(|t| inverse * t.rotation[i]).collect(),
                hand: inverse * (hand.position[i] - pelvis.position[i]),
            }
        };
        let frames: Vec<Target> = (0..count).map(frame).collect();
        let finite = |t: &Target| {
            t.hand
                .iter()
                .chain(t.rotations.iter().flat_map(|r| r.coords.iter()))
                .all(|v| v.is_finite())
        };
        if let Some(i) = frames.iter().position(|t| !finite(t)) {
            let message = format!("frame {i} holds a value that is not a finite number");
            return Err(InputError::new(&recording.source, message)
                .remedy("cut the recording where tracking was lost"));
        }
        let stretch_m = (wander(upper_arm, forearm) + wander(forearm, hand)).sqrt();
        let segments = tracks.iter().map(|t| t.name.clone()).collect();
        Ok(Self { segments, frames, stretch_m })
    }
}

/// Variance of the place of `to` in the axes of `from`, all three directions together, m^2.
fn wander(from: &SegmentTrack, to: &SegmentTrack) -> f64 {
    let places: Vec<Vec3> = (0..from.position.len())
        .map(|i| from.rotation[i].inverse() * (to.position[i] - from.position[i]))
        .collect();
    let count = places.len() as f64;
    let mean = places.iter().sum::<Vec3>() / count;
    places.iter().map(|p| (p - mean).norm_squared()).sum::<f64>() / count
}

fn required<'a>(recording: &'a Recording, name: &str) -> Result<&'a SegmentTrack, InputError> {
    recording.segment(name).ok_or_else(|| {
        let present: Vec<&str> = recording.segments.iter().map(|s| s.name.as_str()).collect();
        InputError::new(&recording.source, format!("has no segment `{name}`, which a fit needs"))
            .remedy(format!(
                "present are: {}; joint angles of an arm are told against the trunk, and that against the pelvis",
                present.join(", ")
            ))
    })
}

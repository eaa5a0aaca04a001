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

/// All frames.
#[derive(Debug, Clone)]
pub(super) struct Targets {
    /// The chain's segments that were recorded.
    pub segments: Vec<String>,
    pub frames: Vec<Target>,
}

impl Targets {
    /// # Errors
    /// Where the pelvis, the thorax, the upper arm, the forearm or the hand is missing, where there
    /// are fewer than four frames, or a number is not finite.
    pub(super) fn new(recording: &Recording, side: Side) -> Result<Self, InputError> {
        let pelvis = required(recording, "Pelvis")?;
        let hand = required(recording, &format!("{}Hand", side.prefix()))?;
        required(recording, "T8")?;
        for part in ["UpperArm", "ForeArm"] {
            required(recording, &format!("{}{part}", side.prefix()))?;
        }
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
        Ok(Self { segments: tracks.iter().map(|t| t.name.clone()).collect(), frames })
    }
}

fn required<'a>(recording: &'a Recording, name: &str) -> Result<&'a SegmentTrack, InputError> {
    recording.segment(name).ok_or_else(|| {
        let present: Vec<&str> = recording.segments.iter().map(|s| s.name.as_str()).collect();
        InputError::new(&recording.source, format!("has no segment `{name}`, which a fit needs"))
            .remedy(format!("present are: {}", present.join(", ")))
    })
}

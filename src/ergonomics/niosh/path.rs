//! The two ends of a lift from a hand path.

use super::{LiftCondition, LiftNote, LiftPoint};
use crate::math::Vec3;
use serde::Serialize;

/// Mean speed above which a lift is a high-speed motion, m/s (30 in/s; manual, section 1.2).
const HIGH_SPEED_M_S: f64 = 0.762;
/// How far the hand may pass beyond the heights of the two ends before it is worth a note, cm. A
/// choice of this project.
const BEYOND_CM: f64 = 5.0;

/// A lift as a hand path shows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PathLift {
    /// The first sample.
    pub origin: LiftPoint,
    /// The last sample.
    pub destination: LiftPoint,
    /// How far the path rises above the higher end or falls below the lower one, cm.
    pub beyond_ends_cm: f64,
    /// Mean speed of the hand along the path, m/s; 0 for a path without duration.
    pub mean_speed_m_s: f64,
}

impl PathLift {
    /// The condition that the path itself violates, if any.
    pub fn condition(&self) -> Option<LiftCondition> {
        (self.mean_speed_m_s > HIGH_SPEED_M_S).then_some(LiftCondition::HighSpeed)
    }

    /// A note where the path between the ends is higher or lower than both.
    pub fn note(&self) -> Option<LiftNote> {
        (self.beyond_ends_cm > BEYOND_CM).then_some(LiftNote::PassesBeyondEnds(self.beyond_ends_cm))
    }
}

/// Reads `H`, `V` and `A` off a hand path.
///
/// World: z up, origin on the floor, m, s. `hand` is the middle of the grasp (the middle knuckle) at
/// `time_s`; with two hands the point midway between them. `ankles` is the point midway between the
/// ankles, of which only x and y count; `facing` is the direction of the mid-sagittal plane forward,
/// of which only the horizontal part counts. Where the hand is straight above the ankles, or `facing`
/// is vertical, the asymmetry is 0. `None` for an empty path or lists of different lengths.
pub fn lift_from_path(
    time_s: &[f64],
    hand: &[Vec3],
    ankles: &Vec3,
    facing: &Vec3,
) -> Option<PathLift> {
    if time_s.len() != hand.len() {
        return None;
    }
    let (first, last) = (hand.first()?, hand.last()?);
    let (low, high) = (first.z.min(last.z), first.z.max(last.z));
    let beyond = hand.iter().map(|p| (p.z - high).max(low - p.z)).fold(0.0, f64::max);
    let length: f64 = hand.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let duration = time_s.last()? - time_s.first()?;
    Some(PathLift {
        origin: point(first, ankles, facing),
        destination: point(last, ankles, facing),
        beyond_ends_cm: 100.0 * beyond,
        mean_speed_m_s: if duration > 0.0 { length / duration } else { 0.0 },
    })
}

fn point(hand: &Vec3, ankles: &Vec3, facing: &Vec3) -> LiftPoint {
    let to = (hand - ankles).xy();
    let forward = facing.xy();
    LiftPoint {
        horizontal_cm: 100.0 * to.norm(),
        vertical_cm: 100.0 * hand.z,
        asymmetry_deg: forward.perp(&to).atan2(forward.dot(&to)).abs().to_degrees(),
    }
}

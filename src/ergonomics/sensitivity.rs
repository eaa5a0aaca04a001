//! How much a score hangs on the exact place of the angle thresholds.
//!
//! The thresholds of RULA and REBA (20, 45, 90 deg ...) are round numbers, and angles are measured to
//! a few degrees. So all of them, or those of one body part, are moved by the same amount:
//! *stricter*, towards the neutral posture, or *laxer*, away from it.
//!
//! The thresholds of the papers stand in the ladders of `rula.rs` and `reba.rs`. Moving a threshold
//! `T` by `-d` is the same as asking for the angle `a` whether `|a| + d > T`: the angle is moved away
//! from neutral before it is classed, for the elbow away from 80 deg, the middle of its band. The
//! flags (abducted, twisted ...) have their thresholds in the [`Profile`]; there the threshold itself
//! is moved. None passes neutral: a threshold is never below 0, and an angle of exactly 0 stays
//! neutral.

use super::angles::{ArmAngles, TrunkNeckAngles};
use super::assess::{TaskInputs, worksheet};
use super::method::PerMethod;
use super::profile::Profile;
use super::worksheet::Worksheet;
use serde::{Deserialize, Serialize};

/// Middle of the elbow's band of 60 to 100 deg, deg.
const ELBOW_NEUTRAL_DEG: f64 = 80.0;

/// A part of the body with thresholds of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyPart {
    /// Upper arm: flexion, abduction, raised shoulder.
    UpperArm,
    /// Elbow flexion.
    LowerArm,
    /// Wrist: flexion, deviation, twist.
    Wrist,
    /// Neck: flexion, twist, side bend.
    Neck,
    /// Trunk: flexion, twist, side bend.
    Trunk,
    /// Knee flexion (REBA, standing).
    Legs,
}

impl BodyPart {
    /// All parts.
    pub const ALL: [Self; 6] =
        [Self::UpperArm, Self::LowerArm, Self::Wrist, Self::Neck, Self::Trunk, Self::Legs];

    /// Name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::UpperArm => "upper arm",
            Self::LowerArm => "lower arm",
            Self::Wrist => "wrist",
            Self::Neck => "neck",
            Self::Trunk => "trunk",
            Self::Legs => "legs",
        }
    }
}

/// Thresholds moved by a number of degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ThresholdShift {
    /// How far towards neutral, deg: positive is stricter, negative laxer.
    pub stricter_deg: f64,
    /// The part whose thresholds move; `None` for all parts.
    pub part: Option<BodyPart>,
}

impl ThresholdShift {
    /// The thresholds where they are.
    pub const NONE: Self = Self { stricter_deg: 0.0, part: None };

    /// The worksheet under the moved thresholds, to be scored with the *unmoved* `profile`.
    pub fn worksheet(
        &self,
        body: &TrunkNeckAngles,
        arm: &ArmAngles,
        task: &TaskInputs,
        profile: &Profile,
    ) -> Worksheet {
        self.classed(&worksheet(body, arm, task, &self.flagged(profile)))
    }

    fn by(&self, part: BodyPart) -> f64 {
        if self.part.is_none_or(|p| p == part) { self.stricter_deg } else { 0.0 }
    }

    /// The profile with the thresholds moved that the worksheet's boxes are ticked by.
    fn flagged(&self, profile: &Profile) -> Profile {
        let moved = |threshold: f64, part| (threshold - self.by(part)).max(0.0);
        Profile {
            shoulder_raised_deg: moved(profile.shoulder_raised_deg, BodyPart::UpperArm),
            abducted_deg: moved(profile.abducted_deg, BodyPart::UpperArm),
            wrist_deviated_deg: moved(profile.wrist_deviated_deg, BodyPart::Wrist),
            wrist_twist_deg: moved(profile.wrist_twist_deg, BodyPart::Wrist),
            neck_twist_deg: moved(profile.neck_twist_deg, BodyPart::Neck),
            neck_side_deg: moved(profile.neck_side_deg, BodyPart::Neck),
            trunk_upright_deg: moved(profile.trunk_upright_deg, BodyPart::Trunk),
            trunk_twist_deg: moved(profile.trunk_twist_deg, BodyPart::Trunk),
            trunk_side_deg: moved(profile.trunk_side_deg, BodyPart::Trunk),
            ..*profile
        }
    }

    /// The worksheet with the angles moved that are classed by the ladders.
    fn classed(&self, sheet: &Worksheet) -> Worksheet {
        let moved = |angle: f64, part| away(angle, self.by(part));
        let elbow = sheet.elbow_flex_deg - ELBOW_NEUTRAL_DEG;
        Worksheet {
            upper_arm_flex_deg: moved(sheet.upper_arm_flex_deg, BodyPart::UpperArm),
            // The move is added, not the sum rebuilt: no move leaves the angle as it is, to the bit.
            elbow_flex_deg: sheet.elbow_flex_deg + (moved(elbow, BodyPart::LowerArm) - elbow),
            wrist_flex_deg: moved(sheet.wrist_flex_deg, BodyPart::Wrist),
            neck_flex_deg: moved(sheet.neck_flex_deg, BodyPart::Neck),
            trunk_flex_deg: moved(sheet.trunk_flex_deg, BodyPart::Trunk),
            knee_flex_deg: moved(sheet.knee_flex_deg, BodyPart::Legs),
            ..*sheet
        }
    }
}

/// An angle moved away from 0 by `by` deg, or towards it but not beyond.
fn away(angle: f64, by: f64) -> f64 {
    if angle > 0.0 {
        (angle + by).max(0.0)
    } else if angle < 0.0 {
        (angle - by).min(0.0)
    } else {
        // Exactly neutral, or not a number: both stay.
        angle
    }
}

/// Expected scores with laxer, official and stricter thresholds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ThresholdBand {
    /// The part whose thresholds move; `None` for all parts together.
    pub part: Option<BodyPart>,
    /// Scores with the thresholds farther from neutral: the lower end.
    pub laxer: PerMethod<f64>,
    /// Scores with the thresholds nearer to neutral: the upper end.
    pub stricter: PerMethod<f64>,
}

/// Sensitivity of the expected scores to the place of the thresholds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ThresholdSensitivity {
    /// How far the thresholds were moved either way, deg.
    pub by_deg: f64,
    /// With the thresholds where they are.
    pub official: PerMethod<f64>,
    /// All thresholds together first, then one part at a time.
    pub bands: Vec<ThresholdBand>,
}

/// Usual move of the thresholds, deg.
pub const THRESHOLD_MOVE_DEG: f64 = 5.0;

/// Scores the same postures under moved thresholds: all together, then one body part at a time.
///
/// `expected` scores the postures (rollouts, times) under a shift; it makes each worksheet by
/// [`ThresholdShift::worksheet`]. It is called 15 times. Thresholds in metres (forearm across or out)
/// and in kilograms do not move.
pub fn threshold_sensitivity(
    by_deg: f64,
    expected: impl Fn(&ThresholdShift) -> PerMethod<f64>,
) -> ThresholdSensitivity {
    let band = |part| ThresholdBand {
        part,
        laxer: expected(&ThresholdShift { stricter_deg: -by_deg, part }),
        stricter: expected(&ThresholdShift { stricter_deg: by_deg, part }),
    };
    let parts = std::iter::once(None).chain(BodyPart::ALL.map(Some));
    ThresholdSensitivity {
        by_deg,
        official: expected(&ThresholdShift::NONE),
        bands: parts.map(band).collect(),
    }
}

#[cfg(test)]
mod tests;

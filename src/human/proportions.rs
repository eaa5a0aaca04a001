//! Sizes of a body from sex, stature and mass.
//!
//! Landmark heights and segment lengths are mean fractions of stature by sex from the ANSUR II
//! survey (2012, 4,082 men and 1,986 women of the US Army; computed from its public tables).
//! Where a joint centre is not a landmark, the offset is stated at the constant. Masses are
//! fractions of body mass after Dumas et al. 2007 as used in public scaling tools for Xsens-like
//! models.

use crate::physical::{BODY_MASS_KG, STATURE_M};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Sex, as far as published proportions distinguish it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sex {
    /// Woman.
    Female,
    /// Man.
    Male,
}

impl fmt::Display for Sex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Female => "female",
            Self::Male => "male",
        })
    }
}

/// What sizes a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySize {
    /// Sex.
    pub sex: Sex,
    /// Stature (body height, ISO 7250-1), m.
    pub stature_m: f64,
    /// Body mass, kg.
    pub mass_kg: f64,
}

impl BodySize {
    /// Checks the plausible range of adults: 1.2 to 2.3 m, 30 to 250 kg.
    pub fn check(self) -> Result<Self, String> {
        let Self { stature_m, mass_kg, .. } = self;
        if !STATURE_M.holds(stature_m) {
            return Err(format!(
                "stature {stature_m} m is outside {STATURE_M} (is it in metres, not centimetres?)"
            ));
        }
        if !BODY_MASS_KG.holds(mass_kg) {
            return Err(format!("mass {mass_kg} kg is outside {BODY_MASS_KG}"));
        }
        Ok(self)
    }
}

/// Fractions of stature.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proportions {
    /// Height of the hip joint centres (trochanterion).
    pub hip_height: f64,
    /// Height of the knee (lateral femoral epicondyle).
    pub knee_height: f64,
    /// Height of the glenohumeral centre: acromial height less [`BELOW_ACROMION`].
    pub shoulder_height: f64,
    /// Height of the joint between C7 and T1: cervicale less [`BELOW_CERVICALE`].
    pub c7_height: f64,
    /// Distance of each glenohumeral centre from the midline: half the biacromial breadth less
    /// [`INSIDE_ACROMION`].
    pub shoulder_half_breadth: f64,
    /// Glenohumeral centre to elbow: acromion-radiale less [`BELOW_ACROMION`].
    pub upper_arm: f64,
    /// Elbow to wrist (radiale-stylion).
    pub forearm: f64,
    /// Wrist to tip of the middle finger.
    pub hand: f64,
    /// Heel to toe.
    pub foot: f64,
    /// Seat surface to top of head.
    pub sitting_height: f64,
}

/// The glenohumeral centre lies about 35 mm below the acromion of a person of 1.75 m. With it the
/// upper arm is 0.171 of stature; eight Xsens-sized subjects (human-gazebo) have 0.156 to 0.181.
const BELOW_ACROMION: f64 = 0.020;
/// The disc between C7 and T1 lies below and before the tip of the spinous process (cervicale).
const BELOW_CERVICALE: f64 = 0.020;
/// The glenohumeral centre lies about 20 mm inside the acromion.
const INSIDE_ACROMION: f64 = 0.012;

/// Height of the ankle joint (Drillis and Contini 1966).
pub(super) const ANKLE_HEIGHT: f64 = 0.039;
/// Distance of each hip joint centre from the midline (Xsens-sized models).
pub(super) const HIP_HALF_BREADTH: f64 = 0.0525;
/// Heights of jL5S1, jL4L3, jL1T12, jT9T8 above the hip joint centres: the mean of Xsens-sized
/// models (0.061, then steps of 0.053, 0.049 and 0.05 of stature), rounded.
pub(super) const SPINE_ABOVE_HIP: [f64; 4] = [0.060, 0.114, 0.165, 0.220];
/// jT1C7 to jC1Head.
pub(super) const NECK: f64 = 0.055;
/// Distance of jRightC7Shoulder (the sternoclavicular joint) from the midline.
pub(super) const CLAVICLE_ROOT: f64 = 0.0158;

pub(super) fn proportions(sex: Sex) -> Proportions {
    let (trochanterion, knee, acromial, cervicale, biacromial) = match sex {
        Sex::Male => (0.5128, 0.2780, 0.8203, 0.8639, 0.2368),
        Sex::Female => (0.5190, 0.2756, 0.8198, 0.8570, 0.2244),
    };
    let (acromion_radiale, forearm, hand, foot, sitting_height) = match sex {
        Sex::Male => (0.1909, 0.1525, 0.1101, 0.1544, 0.5231),
        Sex::Female => (0.1911, 0.1482, 0.1112, 0.1513, 0.5262),
    };
    Proportions {
        hip_height: trochanterion,
        knee_height: knee,
        shoulder_height: acromial - BELOW_ACROMION,
        c7_height: cervicale - BELOW_CERVICALE,
        shoulder_half_breadth: 0.5 * biacromial - INSIDE_ACROMION,
        upper_arm: acromion_radiale - BELOW_ACROMION,
        forearm,
        hand,
        foot,
        sitting_height,
    }
}

/// Fractions of body mass by segment; limbs count twice. They sum to 1.
pub(super) const MASS_FRACTIONS: &[(&str, f64)] = &[
    ("Pelvis", 0.1183),
    ("L5", 0.0291),
    ("L3", 0.0444),
    ("T12", 0.0519),
    ("T8", 0.0818),
    ("Neck", 0.0194),
    ("Head", 0.0487),
    ("Shoulder", 0.0523),
    ("UpperArm", 0.0263),
    ("ForeArm", 0.0150),
    ("Hand", 0.0059),
    ("UpperLeg", 0.1447),
    ("LowerLeg", 0.0457),
    ("Foot", 0.0118),
    ("Toe", 0.0015),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_sum_to_the_body() {
        let total: f64 = MASS_FRACTIONS
            .iter()
            .map(|(name, f)| {
                let pairs = [
                    "Shoulder", "UpperArm", "ForeArm", "Hand", "UpperLeg", "LowerLeg", "Foot",
                    "Toe",
                ];
                if pairs.contains(name) { 2.0 * f } else { *f }
            })
            .sum();
        assert!((total - 1.0).abs() < 1e-12, "{total}");
    }

    #[test]
    fn implausible_sizes_are_refused() {
        let size = |stature_m, mass_kg| BodySize { sex: Sex::Male, stature_m, mass_kg }.check();
        assert!(size(1.75, 80.0).is_ok());
        assert!(size(175.0, 80.0).unwrap_err().contains("centimetres"));
        assert!(size(1.75, f64::NAN).is_err());
        assert!(size(f64::NAN, 80.0).is_err());
    }
}

//! Named conventions for everything that RULA and REBA leave open.

use super::tables::RulaTableA;
use serde::Serialize;

/// How the direction of the upper arm becomes the one flexion angle of the worksheets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum UpperArmRule {
    /// The forward component of the elevation, as the papers read: pure abduction of 90 deg scores
    /// 1 + 1. Above 90 deg of elevation the elevation itself counts, whatever its direction.
    Literal,
    /// The elevation itself, forward or sideways (pure abduction of 90 deg scores 3 + 1); backward,
    /// the extension. Stricter than the papers.
    Elevation,
}

/// One convention: the numbers and readings that the papers do not fix.
///
/// A flag is raised when the angle *exceeds* its threshold. What the papers do fix (20, 45, 90 deg
/// for the upper arm, 2 and 10 kg, ...) is no setting and stands with the steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Profile {
    /// Name under which the profile is asked for and reported.
    pub name: &'static str,
    /// Printing of RULA table A.
    pub rula_table_a: RulaTableA,
    /// Whether an angle exactly on a RULA threshold that the paper words "or more" (upper arm 90,
    /// wrist 15, neck 20, trunk 60 deg) is in the higher class. Immaterial for measured angles.
    pub or_more_is_higher: bool,
    /// RULA force score of more than 10 kg held intermittently: 2 by the paper's text (p. 96), 3 on
    /// the common worksheets.
    pub rula_force_over_10kg: u8,
    /// How the arm's direction is classed; a reading of this project.
    pub upper_arm_rule: UpperArmRule,
    /// Girdle elevation above neutral from which the shoulder is raised, deg. 5 in Maurer-Grubinger
    /// et al. (Sensors 21:4077, 2021).
    pub shoulder_raised_deg: f64,
    /// Girdle elevation that goes with each degree of arm elevation above 30 deg and is not counted
    /// as raising (scapulohumeral rhythm), deg/deg. 0 counts all of it, as published code does; then
    /// the shoulder is nearly always raised above 60 deg of arm elevation.
    pub girdle_rhythm: f64,
    /// Abduction component from which the upper arm is abducted, deg. 45 in Vignais et al. (2017).
    pub abducted_deg: f64,
    /// How far the wrist may pass the midline before the forearm works across it, m. A dead band of
    /// this project against flicker.
    pub midline_tolerance_m: f64,
    /// How far outside the shoulder joint the wrist must be to be "out to the side", m. A choice of
    /// this project, near half the shoulder width of Maurer-Grubinger et al. (2021).
    pub out_margin_m: f64,
    /// Flexion or extension up to which RULA's wrist is neutral, deg. 0 by the paper.
    pub wrist_neutral_deg: f64,
    /// Radial or ulnar deviation that counts, deg. 10 in Vignais et al. (2017).
    pub wrist_deviated_deg: f64,
    /// Pro- or supination from mid-prone that is "near the end of range", deg. 45 of 90 in
    /// Maurer-Grubinger et al. (2021).
    pub wrist_twist_deg: f64,
    /// Extension up to which the neck still is in its lowest class, deg. 0 by the paper, where one
    /// degree of extension moves RULA's neck from 1 to 4.
    pub neck_extension_deg: f64,
    /// Twist of the neck that counts, deg. 10 in Vignais et al. (2017).
    pub neck_twist_deg: f64,
    /// Side bend of the neck that counts, deg. 10 in Vignais et al. (2017).
    pub neck_side_deg: f64,
    /// Flexion or extension up to which the trunk is upright, deg. 0 by the papers, 5 in most code.
    pub trunk_upright_deg: f64,
    /// Extension beyond which RULA's trunk is in class 3 rather than 2, deg; `None`: never. RULA says
    /// nothing on extension; 20 is REBA's rule.
    pub rula_trunk_far_extension_deg: Option<f64>,
    /// Twist of the trunk that counts, deg. 10 in Vignais et al. (2017).
    pub trunk_twist_deg: f64,
    /// Side bend of the trunk that counts, deg. 10 in Vignais et al. (2017).
    pub trunk_side_deg: f64,
}

const VIGNAIS_2017: Profile = Profile {
    name: "vignais2017",
    rula_table_a: RulaTableA::Paper1993,
    or_more_is_higher: false,
    rula_force_over_10kg: 2,
    upper_arm_rule: UpperArmRule::Literal,
    shoulder_raised_deg: 5.0,
    girdle_rhythm: 0.0,
    abducted_deg: 45.0,
    midline_tolerance_m: 0.02,
    out_margin_m: 0.05,
    wrist_neutral_deg: 5.0,
    wrist_deviated_deg: 10.0,
    wrist_twist_deg: 45.0,
    neck_extension_deg: 5.0,
    neck_twist_deg: 10.0,
    neck_side_deg: 10.0,
    trunk_upright_deg: 5.0,
    rula_trunk_far_extension_deg: Some(20.0),
    trunk_twist_deg: 10.0,
    trunk_side_deg: 10.0,
};

/// Numbers of the papers to the letter (zero bands of 0 deg, "or more"); what they leave open is as
/// in `vignais2017`.
const PAPER_STRICT: Profile = Profile {
    name: "paper_strict",
    or_more_is_higher: true,
    midline_tolerance_m: 0.0,
    wrist_neutral_deg: 0.0,
    neck_extension_deg: 0.0,
    trunk_upright_deg: 0.0,
    ..VIGNAIS_2017
};

/// The Cornell worksheet's table A and force box with the thresholds of `vignais2017`.
const CORNELL_2001: Profile = Profile {
    name: "cornell2001",
    rula_table_a: RulaTableA::Cornell2001,
    rula_force_over_10kg: 3,
    ..VIGNAIS_2017
};

/// The convention of common public code: a value on a threshold is in the lower class, zero bands
/// are exactly 0, any trunk extension is class 2 in RULA.
const REFERENCE: Profile = Profile {
    name: "reference",
    midline_tolerance_m: 0.0,
    wrist_neutral_deg: 0.0,
    neck_extension_deg: 0.0,
    trunk_upright_deg: 0.0,
    rula_trunk_far_extension_deg: None,
    ..VIGNAIS_2017
};

const ALL: [Profile; 4] = [VIGNAIS_2017, PAPER_STRICT, CORNELL_2001, REFERENCE];

impl Profile {
    /// The profile of that name; `None` for a name that is not in [`Profile::names`].
    pub fn by_name(name: &str) -> Option<Self> {
        ALL.into_iter().find(|p| p.name == name)
    }

    /// Names of all profiles, the default first.
    pub fn names() -> [&'static str; 4] {
        ALL.map(|p| p.name)
    }
}

impl Default for Profile {
    /// `vignais2017`.
    fn default() -> Self {
        VIGNAIS_2017
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_finds_its_profile() {
        for name in Profile::names() {
            assert_eq!(Profile::by_name(name).unwrap().name, name);
        }
        assert_eq!(Profile::by_name("vignais"), None);
        assert_eq!(Profile::default().name, Profile::names()[0]);
    }
}

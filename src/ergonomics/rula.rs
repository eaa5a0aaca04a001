//! RULA: rapid upper limb assessment of one side (Applied Ergonomics 24(2):91-99, 1993).

use super::profile::Profile;
use super::tables::{RulaTableA, rula_table_a, rula_table_b, rula_table_c};
use super::worksheet::Worksheet;
use serde::Serialize;

/// The highest grand score.
pub const RULA_WORST: u8 = 7;

/// The step scores before any table is entered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RulaScores {
    /// Upper arm, 1-6.
    pub upper_arm: u8,
    /// Lower arm, 1-3.
    pub lower_arm: u8,
    /// Wrist, 1-4.
    pub wrist: u8,
    /// Wrist twist, 1-2.
    pub wrist_twist: u8,
    /// Muscle use, 0-1; counts in both groups.
    pub muscle: u8,
    /// Force or load, 0-3; counts in both groups.
    pub force: u8,
    /// Neck, 1-6.
    pub neck: u8,
    /// Trunk, 1-6.
    pub trunk: u8,
    /// Legs, 1-2.
    pub legs: u8,
}

/// Every number of a filled-in RULA sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RulaSteps {
    /// Upper arm, 1-6.
    pub upper_arm: u8,
    /// Lower arm, 1-3.
    pub lower_arm: u8,
    /// Wrist, 1-4.
    pub wrist: u8,
    /// Wrist twist, 1-2.
    pub wrist_twist: u8,
    /// Posture score A: table A, 1-9.
    pub posture_a: u8,
    /// Muscle use, 0-1.
    pub muscle: u8,
    /// Force or load, 0-3.
    pub force: u8,
    /// Score C: posture score A, muscle use and force, 1-13.
    pub score_c: u8,
    /// Neck, 1-6.
    pub neck: u8,
    /// Trunk, 1-6.
    pub trunk: u8,
    /// Legs, 1-2.
    pub legs: u8,
    /// Posture score B: table B, 1-9.
    pub posture_b: u8,
    /// Score D: posture score B, muscle use and force, 1-13.
    pub score_d: u8,
    /// Grand score, 1-7.
    pub grand: u8,
    /// Action level, 1-4.
    pub action_level: u8,
}

impl RulaSteps {
    /// Names of the numbers as columns of a table, in the order of [`RulaSteps::values`].
    pub const COLUMNS: [&str; 15] = [
        "rula_upper_arm",
        "rula_lower_arm",
        "rula_wrist",
        "rula_wrist_twist",
        "rula_posture_a",
        "rula_muscle",
        "rula_force",
        "rula_score_c",
        "rula_neck",
        "rula_trunk",
        "rula_legs",
        "rula_posture_b",
        "rula_score_d",
        "rula_grand",
        "rula_action_level",
    ];

    /// The numbers in the order of [`RulaSteps::COLUMNS`].
    pub fn values(&self) -> [u8; 15] {
        [
            self.upper_arm,
            self.lower_arm,
            self.wrist,
            self.wrist_twist,
            self.posture_a,
            self.muscle,
            self.force,
            self.score_c,
            self.neck,
            self.trunk,
            self.legs,
            self.posture_b,
            self.score_d,
            self.grand,
            self.action_level,
        ]
    }

    /// The step scores alone.
    pub fn scores(&self) -> RulaScores {
        RulaScores {
            upper_arm: self.upper_arm,
            lower_arm: self.lower_arm,
            wrist: self.wrist,
            wrist_twist: self.wrist_twist,
            muscle: self.muscle,
            force: self.force,
            neck: self.neck,
            trunk: self.trunk,
            legs: self.legs,
        }
    }
}

/// Scores one posture of one side by RULA.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{rula, Profile, Worksheet};
/// let upright = Worksheet { elbow_flex_deg: 80.0, ..Worksheet::default() };
/// assert_eq!(rula(&upright, &Profile::default()).grand, 1);
/// let overhead = Worksheet { upper_arm_flex_deg: 110.0, ..upright };
/// assert_eq!(rula(&overhead, &Profile::default()).upper_arm, 4);
/// ```
pub fn rula(sheet: &Worksheet, profile: &Profile) -> RulaSteps {
    let scores = RulaScores {
        upper_arm: upper_arm(sheet, profile),
        lower_arm: lower_arm(sheet),
        wrist: wrist(sheet, profile),
        wrist_twist: 1 + u8::from(sheet.wrist_twist_end),
        muscle: muscle(sheet),
        force: force(sheet, profile),
        neck: neck(sheet, profile),
        trunk: trunk(sheet, profile),
        legs: 1 + u8::from(sheet.legs_unbalanced),
    };
    rula_from_scores(&scores, profile.rula_table_a)
}

/// Takes step scores through the tables.
pub fn rula_from_scores(scores: &RulaScores, printing: RulaTableA) -> RulaSteps {
    let &RulaScores { upper_arm, lower_arm, wrist, wrist_twist, muscle, force, .. } = scores;
    let &RulaScores { neck, trunk, legs, .. } = scores;
    let posture_a = rula_table_a(printing, upper_arm, lower_arm, wrist, wrist_twist);
    let posture_b = rula_table_b(neck, trunk, legs);
    let extra = muscle.saturating_add(force);
    let score_c = posture_a.saturating_add(extra);
    let score_d = posture_b.saturating_add(extra);
    let grand = rula_table_c(score_c, score_d);
    RulaSteps {
        upper_arm,
        lower_arm,
        wrist,
        wrist_twist,
        posture_a,
        muscle,
        force,
        score_c,
        neck,
        trunk,
        legs,
        posture_b,
        score_d,
        grand,
        action_level: rula_action_level(grand),
    }
}

/// Action level 1-4 of a grand score.
pub fn rula_action_level(grand: u8) -> u8 {
    match grand {
        0..=2 => 1,
        3 | 4 => 2,
        5 | 6 => 3,
        _ => 4,
    }
}

/// What an action level 1-4 asks for.
pub fn rula_action_words(level: u8) -> &'static str {
    match level {
        0 | 1 => "acceptable unless held or repeated for long",
        2 => "look further, change may be needed",
        3 => "look further and change soon",
        _ => "look further and change now",
    }
}

/// The same in a word or two.
pub(super) fn rula_action_short(level: u8) -> &'static str {
    match level {
        0 | 1 => "acceptable",
        2 => "look further",
        3 => "change soon",
        _ => "change now",
    }
}

/// Whether an angle is below a threshold that the paper words "or more".
fn below(angle_deg: f64, threshold_deg: f64, profile: &Profile) -> bool {
    if profile.or_more_is_higher { angle_deg < threshold_deg } else { angle_deg <= threshold_deg }
}

// In the ladders below the worst class stands last, where a value that is not a number ends up.

fn upper_arm(sheet: &Worksheet, profile: &Profile) -> u8 {
    let flexion = sheet.upper_arm_flex_deg;
    let class = if (-20.0..=20.0).contains(&flexion) {
        1
    } else if flexion <= 45.0 {
        2
    } else if below(flexion, 90.0, profile) {
        3
    } else {
        4
    };
    let raised = class + u8::from(sheet.shoulder_raised) + u8::from(sheet.upper_arm_abducted);
    (raised - u8::from(sheet.arm_supported)).max(1)
}

fn lower_arm(sheet: &Worksheet) -> u8 {
    let class = if (60.0..=100.0).contains(&sheet.elbow_flex_deg) { 1 } else { 2 };
    class + u8::from(sheet.forearm_across_or_out)
}

fn wrist(sheet: &Worksheet, profile: &Profile) -> u8 {
    let bend = sheet.wrist_flex_deg.abs();
    let class = if bend <= profile.wrist_neutral_deg {
        1
    } else if below(bend, 15.0, profile) {
        2
    } else {
        3
    };
    class + u8::from(sheet.wrist_deviated)
}

/// Muscle use, 0-1.
pub(super) fn muscle(sheet: &Worksheet) -> u8 {
    u8::from(sheet.static_gt_1min || sheet.repeated_gt_4min)
}

/// Force or load, 0-3.
pub(super) fn force(sheet: &Worksheet, profile: &Profile) -> u8 {
    let load = sheet.load_kg;
    if sheet.load_shock {
        3
    } else if load <= 2.0 {
        0
    } else if load <= 10.0 {
        1 + u8::from(sheet.load_static_or_repeated)
    } else if sheet.load_static_or_repeated {
        3
    } else {
        profile.rula_force_over_10kg
    }
}

fn neck(sheet: &Worksheet, profile: &Profile) -> u8 {
    let flexion = sheet.neck_flex_deg;
    let class = if (-profile.neck_extension_deg..=10.0).contains(&flexion) {
        1
    } else if flexion > 10.0 && below(flexion, 20.0, profile) {
        2
    } else if flexion > 10.0 {
        3
    } else {
        4
    };
    class + u8::from(sheet.neck_twisted) + u8::from(sheet.neck_side)
}

fn trunk(sheet: &Worksheet, profile: &Profile) -> u8 {
    let (flexion, upright) = (sheet.trunk_flex_deg, profile.trunk_upright_deg);
    let far_extension = profile.rula_trunk_far_extension_deg.is_some_and(|far| flexion < -far);
    let class = if sheet.trunk_seated_supported || (-upright..=upright).contains(&flexion) {
        1
    } else if flexion <= 20.0 && !far_extension {
        2
    } else if below(flexion, 60.0, profile) {
        3
    } else {
        4
    };
    class + u8::from(sheet.trunk_twisted) + u8::from(sheet.trunk_side)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(profile: &str, edit: impl Fn(&mut Worksheet)) -> RulaSteps {
        let mut sheet = Worksheet { elbow_flex_deg: 80.0, ..Worksheet::default() };
        edit(&mut sheet);
        rula(&sheet, &Profile::by_name(profile).unwrap())
    }

    #[test]
    fn support_never_takes_the_upper_arm_below_one() {
        assert_eq!(with("vignais2017", |s| s.arm_supported = true).upper_arm, 1);
    }

    #[test]
    fn or_more_matters_only_on_the_threshold() {
        for (angle, lower, strict) in [(89.9, 3, 3), (90.0, 3, 4), (90.1, 4, 4)] {
            let at = |p| with(p, |s| s.upper_arm_flex_deg = angle).upper_arm;
            assert_eq!((at("reference"), at("paper_strict")), (lower, strict));
        }
        assert_eq!(with("paper_strict", |s| s.neck_flex_deg = 20.0).neck, 3);
        assert_eq!(with("paper_strict", |s| s.trunk_flex_deg = 60.0).trunk, 4);
        assert_eq!(with("paper_strict", |s| s.wrist_flex_deg = -15.0).wrist, 3);
    }

    #[test]
    fn bands_about_zero_follow_the_profile() {
        for (profile, neck, trunk, wrist) in
            [("vignais2017", 1, 1, 1), ("paper_strict", 4, 2, 2), ("reference", 4, 2, 2)]
        {
            let s = with(profile, |s| {
                (s.neck_flex_deg, s.trunk_flex_deg, s.wrist_flex_deg) = (-3.0, -3.0, -3.0);
            });
            assert_eq!((s.neck, s.trunk, s.wrist), (neck, trunk, wrist), "{profile}");
        }
        let far = |p| with(p, |s| s.trunk_flex_deg = -25.0).trunk;
        assert_eq!((far("vignais2017"), far("reference")), (3, 2));
    }

    #[test]
    fn heavy_intermittent_loads_differ_between_paper_and_cornell_sheet() {
        let force = |p| with(p, |s| s.load_kg = 12.0).force;
        assert_eq!((force("vignais2017"), force("cornell2001")), (2, 3));
    }

    #[test]
    fn what_is_not_a_number_scores_worst() {
        let s = with("vignais2017", |s| {
            (s.upper_arm_flex_deg, s.elbow_flex_deg) = (f64::NAN, f64::NAN);
            (s.neck_flex_deg, s.trunk_flex_deg) = (f64::NAN, f64::NAN);
            (s.wrist_flex_deg, s.load_kg) = (f64::NAN, f64::NAN);
        });
        assert_eq!((s.upper_arm, s.lower_arm, s.wrist, s.neck, s.trunk), (4, 2, 3, 4, 4));
        assert_eq!(s.force, 2);
    }

    #[test]
    fn words_follow_the_grand_score() {
        let levels: Vec<u8> = (1..=7).map(rula_action_level).collect();
        assert_eq!(levels, [1, 1, 2, 2, 3, 3, 4]);
        assert!(rula_action_words(4).ends_with("now"));
    }
}

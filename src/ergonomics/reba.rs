//! REBA: rapid entire body assessment of one side (Applied Ergonomics 31:201-205, 2000).

use super::profile::Profile;
use super::tables::{reba_table_a, reba_table_b, reba_table_c};
use super::worksheet::Worksheet;
use serde::Serialize;

/// The highest total.
pub const REBA_WORST: u8 = 15;

/// The step scores before any table is entered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RebaScores {
    /// Neck, 1-3.
    pub neck: u8,
    /// Trunk, 1-5.
    pub trunk: u8,
    /// Legs, 1-4.
    pub legs: u8,
    /// Load or force, 0-3.
    pub load: u8,
    /// Upper arm, 1-6.
    pub upper_arm: u8,
    /// Lower arm, 1-2.
    pub lower_arm: u8,
    /// Wrist, 1-3.
    pub wrist: u8,
    /// Coupling, 0-3.
    pub coupling: u8,
    /// Activity, 0-3.
    pub activity: u8,
}

/// Every number of a filled-in REBA sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RebaSteps {
    /// Neck, 1-3.
    pub neck: u8,
    /// Trunk, 1-5.
    pub trunk: u8,
    /// Legs, 1-4.
    pub legs: u8,
    /// Table A, 1-9.
    pub table_a: u8,
    /// Load or force, 0-3.
    pub load: u8,
    /// Score A: table A and load, 1-12.
    pub score_a: u8,
    /// Upper arm, 1-6.
    pub upper_arm: u8,
    /// Lower arm, 1-2.
    pub lower_arm: u8,
    /// Wrist, 1-3.
    pub wrist: u8,
    /// Table B, 1-9.
    pub table_b: u8,
    /// Coupling, 0-3; an input, so not among the columns.
    pub coupling: u8,
    /// Score B: table B and coupling, 1-12.
    pub score_b: u8,
    /// Score C: table C, 1-12.
    pub score_c: u8,
    /// Activity, 0-3.
    pub activity: u8,
    /// Final score, 1-15.
    #[serde(rename = "final")]
    pub total: u8,
    /// Action level, 0-4.
    pub action_level: u8,
}

impl RebaSteps {
    /// Names of the numbers as columns of a table, in the order of [`RebaSteps::values`].
    pub const COLUMNS: [&str; 15] = [
        "reba_neck",
        "reba_trunk",
        "reba_legs",
        "reba_table_a",
        "reba_load",
        "reba_score_a",
        "reba_upper_arm",
        "reba_lower_arm",
        "reba_wrist",
        "reba_table_b",
        "reba_score_b",
        "reba_score_c",
        "reba_activity",
        "reba_final",
        "reba_action_level",
    ];

    /// The numbers in the order of [`RebaSteps::COLUMNS`].
    pub fn values(&self) -> [u8; 15] {
        [
            self.neck,
            self.trunk,
            self.legs,
            self.table_a,
            self.load,
            self.score_a,
            self.upper_arm,
            self.lower_arm,
            self.wrist,
            self.table_b,
            self.score_b,
            self.score_c,
            self.activity,
            self.total,
            self.action_level,
        ]
    }
}

/// Scores one posture of one side by REBA.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{reba, Profile, Worksheet};
/// let upright = Worksheet { elbow_flex_deg: 80.0, ..Worksheet::default() };
/// assert_eq!(reba(&upright, &Profile::default()).total, 1);
/// let bent = Worksheet { trunk_flex_deg: 70.0, ..upright };
/// assert_eq!(reba(&bent, &Profile::default()).trunk, 4);
/// ```
pub fn reba(sheet: &Worksheet, profile: &Profile) -> RebaSteps {
    reba_from_scores(&RebaScores {
        neck: neck(sheet, profile),
        trunk: trunk(sheet, profile),
        legs: legs(sheet),
        load: load(sheet),
        upper_arm: upper_arm(sheet),
        lower_arm: if (60.0..=100.0).contains(&sheet.elbow_flex_deg) { 1 } else { 2 },
        wrist: wrist(sheet),
        coupling: sheet.coupling.min(3),
        activity: activity(sheet),
    })
}

/// Takes step scores through the tables.
pub fn reba_from_scores(scores: &RebaScores) -> RebaSteps {
    let &RebaScores { neck, trunk, legs, load, upper_arm, lower_arm, wrist, .. } = scores;
    let &RebaScores { coupling, activity, .. } = scores;
    let table_a = reba_table_a(neck, trunk, legs);
    let table_b = reba_table_b(upper_arm, lower_arm, wrist);
    let score_a = table_a.saturating_add(load).min(12);
    let score_b = table_b.saturating_add(coupling).min(12);
    let score_c = reba_table_c(score_a, score_b);
    let total = score_c.saturating_add(activity).min(REBA_WORST);
    RebaSteps {
        neck,
        trunk,
        legs,
        table_a,
        load,
        score_a,
        upper_arm,
        lower_arm,
        wrist,
        table_b,
        coupling,
        score_b,
        score_c,
        activity,
        total,
        action_level: reba_action_level(total),
    }
}

/// Action level 0-4 of a final score.
pub fn reba_action_level(total: u8) -> u8 {
    match total {
        0 | 1 => 0,
        2 | 3 => 1,
        4..=7 => 2,
        8..=10 => 3,
        _ => 4,
    }
}

/// What an action level 0-4 asks for.
pub fn reba_action_words(level: u8) -> &'static str {
    match level {
        0 => "negligible risk, nothing to do",
        1 => "low risk, action may be needed",
        2 => "medium risk, action needed",
        3 => "high risk, action needed soon",
        _ => "very high risk, action needed now",
    }
}

/// The same in a word or two.
pub(super) fn reba_action_short(level: u8) -> &'static str {
    match level {
        0 => "negligible risk",
        1 => "low risk",
        2 => "medium risk",
        3 => "high risk",
        _ => "very high risk",
    }
}

// In the ladders below the worst class stands last, where a value that is not a number ends up.

/// Twist and side bend share one point: the tables end at neck 3 and trunk 5.
fn neck(sheet: &Worksheet, profile: &Profile) -> u8 {
    let low = (-profile.neck_extension_deg..=20.0).contains(&sheet.neck_flex_deg);
    (if low { 1 } else { 2 }) + u8::from(sheet.neck_twisted || sheet.neck_side)
}

fn trunk(sheet: &Worksheet, profile: &Profile) -> u8 {
    let (flexion, upright) = (sheet.trunk_flex_deg, profile.trunk_upright_deg);
    let class = if (-upright..=upright).contains(&flexion) {
        1
    } else if (-20.0..=20.0).contains(&flexion) {
        2
    } else if flexion <= 60.0 {
        3
    } else {
        4
    };
    class + u8::from(sheet.trunk_twisted || sheet.trunk_side)
}

fn legs(sheet: &Worksheet) -> u8 {
    let knee = if sheet.sitting || sheet.knee_flex_deg <= 30.0 {
        0
    } else if sheet.knee_flex_deg <= 60.0 {
        1
    } else {
        2
    };
    1 + u8::from(sheet.legs_unbalanced) + knee
}

/// Activity, 0-3.
pub(super) fn activity(sheet: &Worksheet) -> u8 {
    u8::from(sheet.static_gt_1min)
        + u8::from(sheet.repeated_gt_4min)
        + u8::from(sheet.rapid_large_changes)
}

/// Load or force, 0-3.
pub(super) fn load(sheet: &Worksheet) -> u8 {
    let class = if sheet.load_kg < 5.0 {
        0
    } else if sheet.load_kg <= 10.0 {
        1
    } else {
        2
    };
    class + u8::from(sheet.load_shock)
}

fn upper_arm(sheet: &Worksheet) -> u8 {
    let flexion = sheet.upper_arm_flex_deg;
    let class = if (-20.0..=20.0).contains(&flexion) {
        1
    } else if flexion <= 45.0 {
        2
    } else if flexion <= 90.0 {
        3
    } else {
        4
    };
    let raised = class + u8::from(sheet.shoulder_raised) + u8::from(sheet.upper_arm_abducted);
    (raised - u8::from(sheet.arm_supported)).max(1)
}

fn wrist(sheet: &Worksheet) -> u8 {
    let class = if sheet.wrist_flex_deg.abs() <= 15.0 { 1 } else { 2 };
    class + u8::from(sheet.wrist_deviated || sheet.wrist_twist_end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(edit: impl Fn(&mut Worksheet)) -> RebaSteps {
        let mut sheet = Worksheet { elbow_flex_deg: 80.0, ..Worksheet::default() };
        edit(&mut sheet);
        reba(&sheet, &Profile::default())
    }

    #[test]
    fn bent_knees_count_only_when_standing() {
        assert_eq!(with(|s| s.knee_flex_deg = 90.0).legs, 3);
        assert_eq!(with(|s| (s.knee_flex_deg, s.sitting) = (90.0, true)).legs, 1);
    }

    #[test]
    fn extension_beyond_20_deg_is_class_3() {
        let trunk = |deg: f64| with(|s| s.trunk_flex_deg = deg).trunk;
        assert_eq!([-25.0, -20.0, -5.0, 5.0, 20.0, 60.0, 61.0].map(trunk), [3, 2, 1, 1, 2, 3, 4]);
    }

    #[test]
    fn the_worst_sheet_scores_15() {
        let worst = with(|s| {
            *s = Worksheet::from_values(&[1.0; 26]);
            (s.upper_arm_flex_deg, s.trunk_flex_deg, s.neck_flex_deg) = (120.0, 90.0, -30.0);
            (s.sitting, s.knee_flex_deg, s.load_kg, s.coupling) = (false, 90.0, 20.0, 9);
            (s.arm_supported, s.wrist_flex_deg) = (false, 40.0);
        });
        assert_eq!((worst.total, worst.action_level), (REBA_WORST, 4));
        assert_eq!((worst.score_a, worst.score_b, worst.activity), (12, 12, 3));
    }

    #[test]
    fn words_follow_the_final_score() {
        let levels: Vec<u8> = (1..=15).map(reba_action_level).collect();
        assert_eq!(levels, [0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4]);
        assert!(reba_action_words(4).ends_with("now"));
    }
}

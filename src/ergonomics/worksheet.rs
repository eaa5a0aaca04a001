//! The filled-in worksheet: everything RULA and REBA ask about one posture of one side.

use serde::Serialize;

/// Inputs of both methods for one side of the body. Angles in deg, flexion positive.
///
/// An angle or load that is not a number scores in the worst class, never in the best.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[allow(clippy::struct_excessive_bools, reason = "a worksheet is a list of boxes to tick")]
pub struct Worksheet {
    /// Upper arm flexion to the trunk, deg; extension negative.
    pub upper_arm_flex_deg: f64,
    /// Shoulder raised.
    pub shoulder_raised: bool,
    /// Upper arm abducted (REBA: or rotated).
    pub upper_arm_abducted: bool,
    /// Weight of the arm supported, or the person leaning.
    pub arm_supported: bool,
    /// Elbow flexion, deg; 0 is straight.
    pub elbow_flex_deg: f64,
    /// Forearm across the midline or out to the side (RULA only).
    pub forearm_across_or_out: bool,
    /// Wrist flexion, deg; extension negative.
    pub wrist_flex_deg: f64,
    /// Wrist in radial or ulnar deviation.
    pub wrist_deviated: bool,
    /// Forearm at or near the end of pro- or supination (REBA: wrist twisted).
    pub wrist_twist_end: bool,
    /// Neck flexion to the trunk, deg; extension negative.
    pub neck_flex_deg: f64,
    /// Neck twisted.
    pub neck_twisted: bool,
    /// Neck bent to the side.
    pub neck_side: bool,
    /// Trunk flexion to the vertical, deg; extension negative.
    pub trunk_flex_deg: f64,
    /// Trunk twisted.
    pub trunk_twisted: bool,
    /// Trunk bent to the side.
    pub trunk_side: bool,
    /// Seated with the trunk well supported at a hip-trunk angle of 90 deg or more (RULA trunk 1).
    pub trunk_seated_supported: bool,
    /// Legs or feet not evenly loaded (RULA legs 2; REBA unilateral or unstable).
    pub legs_unbalanced: bool,
    /// Knee flexion, deg; ignored when sitting.
    pub knee_flex_deg: f64,
    /// Sitting.
    pub sitting: bool,
    /// Load on the hand, kg.
    pub load_kg: f64,
    /// The load is held still or handled repeatedly (RULA).
    pub load_static_or_repeated: bool,
    /// Shock, or force that builds up rapidly.
    pub load_shock: bool,
    /// Posture held for longer than 1 min.
    pub static_gt_1min: bool,
    /// Action repeated more than 4 times a minute.
    pub repeated_gt_4min: bool,
    /// Rapid large changes of posture, or an unstable base (REBA).
    pub rapid_large_changes: bool,
    /// REBA coupling: 0 good, 1 fair, 2 poor, 3 unacceptable; above 3 counts as 3.
    pub coupling: u8,
}

impl Worksheet {
    /// Names of the inputs as columns of a table, in the order of [`Worksheet::from_values`].
    pub const COLUMNS: [&str; 26] = [
        "upper_arm_flex",
        "shoulder_raised",
        "upper_arm_abducted",
        "arm_supported",
        "elbow_flex",
        "forearm_across_or_out",
        "wrist_flex",
        "wrist_deviated",
        "wrist_twist_end",
        "neck_flex",
        "neck_twisted",
        "neck_side",
        "trunk_flex",
        "trunk_twisted",
        "trunk_side",
        "trunk_seated_supported",
        "legs_unbalanced",
        "knee_flex",
        "sitting",
        "load_kg",
        "load_static_or_repeated",
        "load_shock",
        "static_gt_1min",
        "repeated_gt_4min",
        "rapid_large_changes",
        "coupling",
    ];

    /// The worksheet of one table row: angles in deg, loads in kg, a box is ticked by any number
    /// but 0.
    pub fn from_values(values: &[f64; 26]) -> Self {
        let ticked = |i: usize| values[i] != 0.0;
        Self {
            upper_arm_flex_deg: values[0],
            shoulder_raised: ticked(1),
            upper_arm_abducted: ticked(2),
            arm_supported: ticked(3),
            elbow_flex_deg: values[4],
            forearm_across_or_out: ticked(5),
            wrist_flex_deg: values[6],
            wrist_deviated: ticked(7),
            wrist_twist_end: ticked(8),
            neck_flex_deg: values[9],
            neck_twisted: ticked(10),
            neck_side: ticked(11),
            trunk_flex_deg: values[12],
            trunk_twisted: ticked(13),
            trunk_side: ticked(14),
            trunk_seated_supported: ticked(15),
            legs_unbalanced: ticked(16),
            knee_flex_deg: values[17],
            sitting: ticked(18),
            load_kg: values[19],
            load_static_or_repeated: ticked(20),
            load_shock: ticked(21),
            static_gt_1min: ticked(22),
            repeated_gt_4min: ticked(23),
            rapid_large_changes: ticked(24),
            coupling: values[25] as u8,
        }
    }

    /// The row of the sheet, in the order of [`Worksheet::COLUMNS`]; a ticked box is 1.
    pub fn values(&self) -> [f64; 26] {
        let tick = |b: bool| f64::from(u8::from(b));
        [
            self.upper_arm_flex_deg,
            tick(self.shoulder_raised),
            tick(self.upper_arm_abducted),
            tick(self.arm_supported),
            self.elbow_flex_deg,
            tick(self.forearm_across_or_out),
            self.wrist_flex_deg,
            tick(self.wrist_deviated),
            tick(self.wrist_twist_end),
            self.neck_flex_deg,
            tick(self.neck_twisted),
            tick(self.neck_side),
            self.trunk_flex_deg,
            tick(self.trunk_twisted),
            tick(self.trunk_side),
            tick(self.trunk_seated_supported),
            tick(self.legs_unbalanced),
            self.knee_flex_deg,
            tick(self.sitting),
            self.load_kg,
            tick(self.load_static_or_repeated),
            tick(self.load_shock),
            tick(self.static_gt_1min),
            tick(self.repeated_gt_4min),
            tick(self.rapid_large_changes),
            f64::from(self.coupling),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_column_sets_one_field() {
        let base = Worksheet::default();
        let sheets: Vec<Worksheet> = (0..26)
            .map(|i| {
                let mut values = [0.0; 26];
                values[i] = 1.0;
                assert_eq!(Worksheet::from_values(&values).values(), values);
                Worksheet::from_values(&values)
            })
            .collect();
        for (i, sheet) in sheets.iter().enumerate() {
            assert_ne!(*sheet, base, "{}", Worksheet::COLUMNS[i]);
            assert!(!sheets[..i].contains(sheet), "{}", Worksheet::COLUMNS[i]);
        }
    }

    #[test]
    fn columns_are_the_field_names_without_units() {
        let json = serde_json::to_string(&Worksheet::default()).unwrap();
        let fields: Vec<&str> =
            json.trim_matches(['{', '}']).split(',').filter_map(|f| f.split('"').nth(1)).collect();
        let plain: Vec<&str> = fields.iter().map(|f| f.trim_end_matches("_deg")).collect();
        assert_eq!(plain, Worksheet::COLUMNS);
    }
}

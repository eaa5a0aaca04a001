//! From body angles and the task to a filled-in worksheet and its scores.

use super::angles::{ArmAngles, TrunkNeckAngles};
use super::profile::{Profile, UpperArmRule};
use super::reba::{RebaSteps, reba};
use super::rula::{RulaSteps, rula};
use super::worksheet::Worksheet;
use serde::Serialize;

/// What no posture can show: load, repetition, support, legs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[allow(clippy::struct_excessive_bools, reason = "a worksheet is a list of boxes to tick")]
pub struct TaskInputs {
    /// Load on the hand, kg.
    pub load_kg: f64,
    /// The load is held still or handled repeatedly.
    pub load_static_or_repeated: bool,
    /// Shock, or force that builds up rapidly.
    pub load_shock: bool,
    /// Posture held for longer than 1 min.
    pub static_gt_1min: bool,
    /// Action repeated more than 4 times a minute.
    pub repeated_gt_4min: bool,
    /// Rapid large changes of posture, or an unstable base.
    pub rapid_large_changes: bool,
    /// Coupling: 0 good, 1 fair, 2 poor, 3 unacceptable.
    pub coupling: u8,
    /// Sitting.
    pub sitting: bool,
    /// A backrest supports the trunk while it is not bent forward.
    pub trunk_supported: bool,
    /// Legs or feet not evenly loaded.
    pub legs_unbalanced: bool,
    /// Knee flexion, deg.
    pub knee_flex_deg: f64,
    /// Weight of the arm supported, or the person leaning.
    pub arm_supported: bool,
}

/// One posture of one side, scored.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Assessment {
    /// What was entered.
    pub worksheet: Worksheet,
    /// RULA, step by step.
    pub rula: RulaSteps,
    /// REBA, step by step.
    pub reba: RebaSteps,
}

/// Fills in the worksheet and scores it.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{assess, ArmAngles, Profile, TaskInputs, TrunkNeckAngles};
/// let arm = ArmAngles { elbow_flex_deg: 80.0, wrist_lateral_m: 0.2, ..ArmAngles::default() };
/// let task = TaskInputs { load_kg: 6.0, ..TaskInputs::default() };
/// let scored = assess(&TrunkNeckAngles::default(), &arm, &task, &Profile::default());
/// assert_eq!((scored.rula.force, scored.reba.load), (1, 1));
/// ```
pub fn assess(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    task: &TaskInputs,
    profile: &Profile,
) -> Assessment {
    let worksheet = worksheet(body, arm, task, profile);
    Assessment { worksheet, rula: rula(&worksheet, profile), reba: reba(&worksheet, profile) }
}

/// Fills in the worksheet with the thresholds of the profile.
pub fn worksheet(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    task: &TaskInputs,
    profile: &Profile,
) -> Worksheet {
    let across = arm.wrist_lateral_m < -profile.midline_tolerance_m;
    let out = arm.wrist_beyond_shoulder_m > profile.out_margin_m;
    // Horizontal thighs: the hip-trunk angle is 90 deg or more as long as the trunk is not bent
    // forward. Once the person leaves the backrest, its support is gone too.
    let reclined = body.trunk_flex_deg <= profile.trunk_upright_deg;
    let rhythm = profile.girdle_rhythm * (arm.upper_arm_elevation_deg - 30.0).max(0.0);
    Worksheet {
        upper_arm_flex_deg: upper_arm_flexion(arm, profile.upper_arm_rule),
        shoulder_raised: arm.girdle_elevation_deg - rhythm > profile.shoulder_raised_deg,
        upper_arm_abducted: arm.upper_arm_abduction_deg > profile.abducted_deg,
        arm_supported: task.arm_supported,
        elbow_flex_deg: arm.elbow_flex_deg,
        forearm_across_or_out: across || out,
        wrist_flex_deg: arm.wrist_flex_deg,
        wrist_deviated: arm.wrist_deviation_deg.abs() > profile.wrist_deviated_deg,
        wrist_twist_end: arm.wrist_twist_deg.abs() > profile.wrist_twist_deg,
        neck_flex_deg: body.neck_flex_deg,
        neck_twisted: body.neck_twist_deg.abs() > profile.neck_twist_deg,
        neck_side: body.neck_side_deg.abs() > profile.neck_side_deg,
        trunk_flex_deg: body.trunk_flex_deg,
        trunk_twisted: body.trunk_twist_deg.abs() > profile.trunk_twist_deg,
        trunk_side: body.trunk_side_deg.abs() > profile.trunk_side_deg,
        trunk_seated_supported: task.sitting && task.trunk_supported && reclined,
        legs_unbalanced: task.legs_unbalanced,
        knee_flex_deg: task.knee_flex_deg,
        sitting: task.sitting,
        load_kg: task.load_kg,
        load_static_or_repeated: task.load_static_or_repeated,
        load_shock: task.load_shock,
        static_gt_1min: task.static_gt_1min,
        repeated_gt_4min: task.repeated_gt_4min,
        rapid_large_changes: task.rapid_large_changes,
        coupling: task.coupling,
    }
}

/// The one angle by which the upper arm is classed, deg.
///
/// Above 90 deg of elevation it is the elevation: that class is never lower than the flexion's.
fn upper_arm_flexion(arm: &ArmAngles, rule: UpperArmRule) -> f64 {
    let (flexion, elevation) = (arm.upper_arm_flex_deg, arm.upper_arm_elevation_deg);
    // The backward third of all azimuths: cos a < -1/2.
    let backward = flexion < -0.5 * elevation;
    match rule {
        _ if elevation > 90.0 => elevation,
        UpperArmRule::Literal => flexion,
        UpperArmRule::Elevation if backward => -elevation,
        UpperArmRule::Elevation => elevation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raised(flexion: f64, abduction: f64) -> ArmAngles {
        ArmAngles {
            upper_arm_flex_deg: flexion,
            upper_arm_abduction_deg: abduction,
            upper_arm_elevation_deg: flexion.hypot(abduction),
            elbow_flex_deg: 80.0,
            wrist_lateral_m: 0.2,
            ..ArmAngles::default()
        }
    }

    fn upper_arm(arm: &ArmAngles, rule: UpperArmRule) -> u8 {
        let profile = Profile { upper_arm_rule: rule, ..Profile::default() };
        let (body, task) = (TrunkNeckAngles::default(), TaskInputs::default());
        assess(&body, arm, &task, &profile).rula.upper_arm
    }

    #[test]
    fn the_two_rules_of_the_upper_arm() {
        for (flexion, abduction, literal, elevation) in [
            (0.0, 90.0, 2, 4),
            (0.0, 91.0, 5, 5),
            (70.0, 0.0, 3, 3),
            (100.0, 0.0, 4, 4),
            (-50.0, 0.0, 2, 2),
            (-50.0, 40.0, 2, 2),
            (10.0, 44.0, 1, 3),
        ] {
            let arm = raised(flexion, abduction);
            assert_eq!(upper_arm(&arm, UpperArmRule::Literal), literal, "{flexion} {abduction}");
            assert_eq!(
                upper_arm(&arm, UpperArmRule::Elevation),
                elevation,
                "{flexion} {abduction}"
            );
        }
    }

    #[test]
    fn each_threshold_ticks_its_box() {
        let (body, task, profile) =
            (TrunkNeckAngles::default(), TaskInputs::default(), Profile::default());
        let sheet = |b: &TrunkNeckAngles, a: &ArmAngles| worksheet(b, a, &task, &profile);
        let calm = raised(0.0, 0.0);
        let none = sheet(&body, &calm);
        assert!(!none.shoulder_raised && !none.forearm_across_or_out && !none.wrist_deviated);
        assert!(!none.upper_arm_abducted && !none.wrist_twist_end);
        assert!(sheet(&body, &raised(0.0, 46.0)).upper_arm_abducted);
        assert!(!sheet(&body, &raised(0.0, -46.0)).upper_arm_abducted);
        assert!(sheet(&body, &ArmAngles { girdle_elevation_deg: 6.0, ..calm }).shoulder_raised);
        assert!(sheet(&body, &ArmAngles { wrist_lateral_m: -0.03, ..calm }).forearm_across_or_out);
        assert!(!sheet(&body, &ArmAngles { wrist_lateral_m: -0.01, ..calm }).forearm_across_or_out);
        let out = ArmAngles { wrist_beyond_shoulder_m: 0.06, ..calm };
        assert!(sheet(&body, &out).forearm_across_or_out);
        assert!(sheet(&body, &ArmAngles { wrist_deviation_deg: -11.0, ..calm }).wrist_deviated);
        assert!(sheet(&body, &ArmAngles { wrist_twist_deg: -46.0, ..calm }).wrist_twist_end);
        let bent = TrunkNeckAngles {
            trunk_side_deg: -11.0,
            trunk_twist_deg: 11.0,
            neck_side_deg: 9.0,
            neck_twist_deg: -11.0,
            ..body
        };
        let s = sheet(&bent, &calm);
        assert!(s.trunk_side && s.trunk_twisted && !s.neck_side && s.neck_twisted);
    }

    #[test]
    fn a_backrest_helps_only_while_one_leans_on_it() {
        let task = TaskInputs { sitting: true, trunk_supported: true, ..TaskInputs::default() };
        for (flexion, trunk) in [(-15.0, 1), (0.0, 1), (15.0, 2), (40.0, 3)] {
            let body = TrunkNeckAngles { trunk_flex_deg: flexion, ..TrunkNeckAngles::default() };
            let scored = assess(&body, &raised(0.0, 0.0), &task, &Profile::default());
            assert_eq!(scored.rula.trunk, trunk, "{flexion}");
        }
    }

    #[test]
    fn the_girdle_rhythm_can_be_allowed_for() {
        let profile = Profile { girdle_rhythm: 0.3, ..Profile::default() };
        let (body, task) = (TrunkNeckAngles::default(), TaskInputs::default());
        let arm = ArmAngles { girdle_elevation_deg: 20.0, ..raised(90.0, 0.0) };
        assert!(worksheet(&body, &arm, &task, &Profile::default()).shoulder_raised);
        assert!(!worksheet(&body, &arm, &task, &profile).shoulder_raised);
    }
}

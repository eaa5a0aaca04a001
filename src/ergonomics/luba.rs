//! LUBA: postural loading on the upper body by perceived discomfort.
//!
//! Kee and Karwowski, Applied Ergonomics 32:357-366, 2001. Each joint motion has classes of angle with
//! discomfort points relative to the calmest motion (elbow flexion, 1). The points are summed over the
//! motions of wrist, elbow, shoulder and neck of one side and the back; the sum falls in one of four
//! categories. LUBA knows neither load nor time.
//!
//! See [`LUBA_PROVENANCE`] for what was checked, and [`luba`] for what is a reading of this project.

use super::angles::{ArmAngles, TrunkNeckAngles};
use serde::Serialize;

/// Where the tables were checked; for reports.
pub const LUBA_PROVENANCE: &str = "LUBA classes, not verified against the 2001 paper. Wrist (all four motions, sitting and \
     standing) and 15 points for back extension beyond 30 deg standing agree with the authors' \
     handbook chapter (Kee and Karwowski, in: Fundamentals and Assessment Tools for Occupational \
     Ergonomics, 2006, table 43.2), which also says that sitting and standing are almost the same but \
     for the back. Elbow, shoulder, neck, the other back classes and the category bounds are from \
     memory.";

/// Angle up to which a motion counts as not taking place, deg. A reading of this project: the method
/// was made for observers, who note the motions they see.
pub const LUBA_REST_DEG: f64 = 5.0;

/// How the person works; the classes of the back differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LubaPosture {
    /// Sitting.
    Sitting,
    /// Standing.
    Standing,
}

/// A joint of LUBA.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LubaJoint {
    /// Wrist.
    Wrist,
    /// Elbow with the forearm's rotation.
    Elbow,
    /// Shoulder.
    Shoulder,
    /// Neck.
    Neck,
    /// Back.
    Back,
}

/// A joint motion with classes of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the names say it: joint and motion")]
pub enum LubaMotion {
    WristFlexion,
    WristExtension,
    WristRadial,
    WristUlnar,
    ElbowFlexion,
    Supination,
    Pronation,
    ShoulderFlexion,
    ShoulderExtension,
    ShoulderAdduction,
    ShoulderAbduction,
    ShoulderMedialRotation,
    ShoulderLateralRotation,
    NeckFlexion,
    NeckExtension,
    NeckSideBend,
    NeckRotation,
    BackFlexion,
    BackExtension,
    BackSideBend,
    BackRotation,
}

/// Classes of a motion: (up to this angle, deg; points).
type Classes = &'static [(f64, u8)];

const MAX: f64 = f64::INFINITY;

impl LubaMotion {
    /// The joint it belongs to.
    pub fn joint(self) -> LubaJoint {
        use LubaMotion as M;
        match self {
            M::WristFlexion | M::WristExtension | M::WristRadial | M::WristUlnar => {
                LubaJoint::Wrist
            }
            M::ElbowFlexion | M::Supination | M::Pronation => LubaJoint::Elbow,
            M::ShoulderFlexion
            | M::ShoulderExtension
            | M::ShoulderAdduction
            | M::ShoulderAbduction
            | M::ShoulderMedialRotation
            | M::ShoulderLateralRotation => LubaJoint::Shoulder,
            M::NeckFlexion | M::NeckExtension | M::NeckSideBend | M::NeckRotation => {
                LubaJoint::Neck
            }
            M::BackFlexion | M::BackExtension | M::BackSideBend | M::BackRotation => {
                LubaJoint::Back
            }
        }
    }

    /// Discomfort points of an angle, deg (its magnitude); `None` where the method has no classes:
    /// back extension was not measured sitting. What is not a number is in the highest class.
    pub fn points(self, angle_deg: f64, posture: LubaPosture) -> Option<u8> {
        let classes = self.classes(posture);
        let class = classes.iter().find(|(up_to, _)| angle_deg.abs() <= *up_to);
        class.or(classes.last()).map(|(_, points)| *points)
    }

    #[allow(clippy::match_same_arms, reason = "rows of a table, equal by chance")]
    fn classes(self, posture: LubaPosture) -> Classes {
        use LubaMotion as M;
        let is_sitting = posture == LubaPosture::Sitting;
        match self {
            M::WristFlexion => &[(20.0, 1), (60.0, 2), (MAX, 5)],
            M::WristExtension => &[(20.0, 1), (45.0, 2), (MAX, 7)],
            M::WristRadial => &[(10.0, 1), (30.0, 3), (MAX, 7)],
            M::WristUlnar => &[(10.0, 1), (20.0, 3), (MAX, 6)],
            M::ElbowFlexion => &[(45.0, 1), (120.0, 3), (MAX, 5)],
            M::Supination => &[(90.0, 2), (MAX, 7)],
            M::Pronation => &[(70.0, 2), (MAX, 7)],
            M::ShoulderFlexion => &[(45.0, 1), (90.0, 3), (150.0, 6), (MAX, 11)],
            M::ShoulderExtension => &[(20.0, 1), (45.0, 4), (60.0, 9), (MAX, 13)],
            M::ShoulderAdduction => &[(10.0, 1), (30.0, 2), (MAX, 8)],
            M::ShoulderAbduction => &[(30.0, 1), (90.0, 3), (MAX, 10)],
            M::ShoulderMedialRotation => &[(30.0, 1), (90.0, 2), (MAX, 5)],
            M::ShoulderLateralRotation => &[(10.0, 1), (30.0, 3), (MAX, 7)],
            M::NeckFlexion => &[(20.0, 1), (45.0, 3), (MAX, 5)],
            M::NeckExtension => &[(30.0, 1), (60.0, 6), (MAX, 12)],
            M::NeckSideBend => &[(30.0, 1), (45.0, 3), (MAX, 10)],
            M::NeckRotation => &[(30.0, 1), (60.0, 2), (MAX, 8)],
            M::BackFlexion if is_sitting => &[(20.0, 1), (60.0, 3), (MAX, 10)],
            M::BackFlexion => &[(30.0, 1), (60.0, 3), (90.0, 6), (MAX, 12)],
            M::BackExtension if is_sitting => &[],
            M::BackExtension => &[(10.0, 1), (20.0, 4), (30.0, 8), (MAX, 15)],
            M::BackSideBend if is_sitting => &[(10.0, 1), (20.0, 3), (30.0, 9), (MAX, 13)],
            M::BackSideBend => &[(10.0, 1), (20.0, 4), (30.0, 9), (MAX, 13)],
            M::BackRotation if is_sitting => &[(20.0, 1), (30.0, 2), (45.0, 7), (MAX, 11)],
            M::BackRotation => &[(20.0, 1), (60.0, 3), (MAX, 10)],
        }
    }
}

/// One joint motion of a posture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LubaPart {
    /// The motion.
    pub motion: LubaMotion,
    /// Its angle, deg, 0 or more.
    pub angle_deg: f64,
    /// Its points; 0 where the motion does not take place.
    pub points: u8,
}

/// One posture of one side by LUBA.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LubaScore {
    /// The motions with classes.
    pub parts: Vec<LubaPart>,
    /// Postural load index: the sum over the joints.
    pub index: u8,
    /// Category 1-4.
    pub category: u8,
    /// Motions without angle or without classes.
    pub not_assessed: Vec<LubaMotion>,
}

/// Scores one posture of one side.
///
/// Readings of this project where the published categories leave a choice: a motion of
/// [`LUBA_REST_DEG`] or less does not take place and has no points; a joint in which no motion takes
/// place counts its lowest score, 1. So the neutral posture has 1 for each of the five joints, 5, the
/// upper bound of category 1. Shoulder flexion and abduction are the components of the arm's
/// elevation; pro- and supination are counted from mid-prone. Rotation of the upper arm is not among
/// the angles and never assessed: the index is a lower bound in that respect.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{ArmAngles, LubaPosture, TrunkNeckAngles, luba};
/// let neutral = luba(&TrunkNeckAngles::default(), &ArmAngles::default(), LubaPosture::Standing);
/// assert_eq!((neutral.index, neutral.category), (5, 1));
/// let arm = ArmAngles { upper_arm_flex_deg: 100.0, ..ArmAngles::default() };
/// let raised = luba(&TrunkNeckAngles::default(), &arm, LubaPosture::Standing);
/// assert_eq!((raised.index, raised.category), (10, 2));
/// ```
pub fn luba(body: &TrunkNeckAngles, arm: &ArmAngles, posture: LubaPosture) -> LubaScore {
    let mut parts = Vec::new();
    let mut not_assessed =
        vec![LubaMotion::ShoulderMedialRotation, LubaMotion::ShoulderLateralRotation];
    for (motion, angle_deg) in motions(body, arm) {
        let takes_place = angle_deg > LUBA_REST_DEG || angle_deg.is_nan();
        match motion.points(angle_deg, posture) {
            Some(points) => {
                let points = if takes_place { points } else { 0 };
                parts.push(LubaPart { motion, angle_deg, points });
            }
            None if takes_place => not_assessed.push(motion),
            None => {}
        }
    }
    let index = index(&parts);
    LubaScore { parts, index, category: luba_category(index), not_assessed }
}

/// The motion that takes place about each axis, with its angle, deg.
fn motions(body: &TrunkNeckAngles, arm: &ArmAngles) -> [(LubaMotion, f64); 12] {
    use LubaMotion as M;
    let either = |angle: f64, positive: M, negative: M| {
        (if angle < 0.0 { negative } else { positive }, angle.abs())
    };
    [
        either(arm.wrist_flex_deg, M::WristFlexion, M::WristExtension),
        either(arm.wrist_deviation_deg, M::WristRadial, M::WristUlnar),
        (M::ElbowFlexion, arm.elbow_flex_deg.abs()),
        either(arm.wrist_twist_deg, M::Pronation, M::Supination),
        either(arm.upper_arm_flex_deg, M::ShoulderFlexion, M::ShoulderExtension),
        either(arm.upper_arm_abduction_deg, M::ShoulderAbduction, M::ShoulderAdduction),
        either(body.neck_flex_deg, M::NeckFlexion, M::NeckExtension),
        (M::NeckSideBend, body.neck_side_deg.abs()),
        (M::NeckRotation, body.neck_twist_deg.abs()),
        either(body.trunk_flex_deg, M::BackFlexion, M::BackExtension),
        (M::BackSideBend, body.trunk_side_deg.abs()),
        (M::BackRotation, body.trunk_twist_deg.abs()),
    ]
}

fn index(parts: &[LubaPart]) -> u8 {
    use LubaJoint as J;
    let of = |joint| {
        let points = parts.iter().filter(|p| p.motion.joint() == joint).map(|p| p.points);
        points.fold(0, u8::saturating_add).max(1)
    };
    [J::Wrist, J::Elbow, J::Shoulder, J::Neck, J::Back].map(of).into_iter().sum()
}

/// Category of a postural load index.
pub fn luba_category(index: u8) -> u8 {
    match index {
        0..=5 => 1,
        6..=10 => 2,
        11..=15 => 3,
        _ => 4,
    }
}

/// What a category 1-4 asks for.
pub fn luba_category_words(category: u8) -> &'static str {
    match category {
        0 | 1 => "acceptable unless repeated or held for long",
        2 => "look further, change at the next occasion",
        3 => "change soon",
        _ => "change now",
    }
}

#[cfg(test)]
mod tests;

//! Smooth RULA: steps, tables, and the way back to the partial derivatives.

use super::boxes::Boxes;
use super::grid::interpolate;
use super::logistic::{Blur, Soft};
use super::steps::{LOWEST, lower_arm, upper_arm};
use crate::ergonomics::profile::Profile;
use crate::ergonomics::rula::{force, muscle};
use crate::ergonomics::tables::{rula_table_a, rula_table_b, rula_table_c};
use crate::ergonomics::worksheet::Worksheet;
use serde::Serialize;

/// Every number of a smooth RULA sheet, in the ranges of [`crate::ergonomics::RulaSteps`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SmoothRulaSteps {
    /// Upper arm, 1-6.
    pub upper_arm: f64,
    /// Lower arm, 1-3.
    pub lower_arm: f64,
    /// Wrist, 1-4.
    pub wrist: f64,
    /// Wrist twist, 1-2.
    pub wrist_twist: f64,
    /// Posture score A, 1-9.
    pub posture_a: f64,
    /// Muscle use, 0 or 1.
    pub muscle: f64,
    /// Force or load, 0-3, whole numbers.
    pub force: f64,
    /// Score C, 1-13.
    pub score_c: f64,
    /// Neck, 1-6.
    pub neck: f64,
    /// Trunk, 1-6.
    pub trunk: f64,
    /// Legs, 1 or 2.
    pub legs: f64,
    /// Posture score B, 1-9.
    pub posture_b: f64,
    /// Score D, 1-13.
    pub score_d: f64,
    /// Grand score, 1-7.
    pub grand: f64,
}

/// Smooth RULA, and the partial derivatives of the grand score with respect to the boxes.
pub(super) fn rula_steps(
    boxes: &Boxes,
    sheet: &Worksheet,
    profile: &Profile,
    blur: Blur,
) -> (SmoothRulaSteps, Boxes) {
    let mut s = SmoothRulaSteps::default();
    let by_arm = arm(boxes, sheet, profile, blur, &mut s);
    let by_body = body(boxes, sheet, profile, blur, &mut s);
    (s.muscle, s.force) = (f64::from(muscle(sheet)), f64::from(force(sheet, profile)));
    s.score_c = s.posture_a + s.muscle + s.force;
    s.score_d = s.posture_b + s.muscle + s.force;
    let (grand, [by_c, by_d]) =
        interpolate::<2, 4>([8, 7], [s.score_c, s.score_d], |[c, d]| rula_table_c(c, d));
    s.grand = grand;
    (s, by_arm.scaled(by_c).plus(&by_body.scaled(by_d)))
}

/// Group A; returns the derivatives of posture score A.
fn arm(
    boxes: &Boxes,
    sheet: &Worksheet,
    profile: &Profile,
    blur: Blur,
    s: &mut SmoothRulaSteps,
) -> Boxes {
    let (upper_arm, moves) = upper_arm(boxes, sheet);
    let (elbow, bend) = (lower_arm(boxes, blur), wrist(boxes, profile, blur));
    s.upper_arm = upper_arm;
    s.lower_arm = elbow.value + boxes.across_or_out;
    s.wrist = bend.value + boxes.deviated;
    s.wrist_twist = 1.0 + boxes.twist_end;
    let scores = [s.upper_arm, s.lower_arm, s.wrist, s.wrist_twist];
    let (posture_a, [by_upper, by_lower, by_wrist, by_twist]) =
        interpolate::<4, 16>([6, 3, 4, 2], scores, |[u, l, w, t]| {
            rula_table_a(profile.rula_table_a, u, l, w, t)
        });
    s.posture_a = posture_a;
    Boxes {
        upper_arm_class: by_upper * moves,
        raised: by_upper * moves,
        abducted: by_upper * moves,
        elbow_flex_deg: by_lower * elbow.slope,
        across_or_out: by_lower,
        wrist_flex_deg: by_wrist * bend.slope,
        deviated: by_wrist,
        twist_end: by_twist,
        ..Boxes::default()
    }
}

/// Group B; returns the derivatives of posture score B.
fn body(
    boxes: &Boxes,
    sheet: &Worksheet,
    profile: &Profile,
    blur: Blur,
    s: &mut SmoothRulaSteps,
) -> Boxes {
    let (nod, stoop) = (neck(boxes, profile, blur), trunk(boxes, profile, blur));
    // A backrest takes the class back to 1.
    let free = 1.0 - boxes.seated_supported;
    s.neck = nod.value + boxes.neck_twisted + boxes.neck_side;
    s.trunk = 1.0 + free * (stoop.value - 1.0) + boxes.trunk_twisted + boxes.trunk_side;
    s.legs = 1.0 + f64::from(sheet.legs_unbalanced);
    let (posture_b, [by_neck, by_trunk, _]) =
        interpolate::<3, 8>([6, 6, 2], [s.neck, s.trunk, s.legs], |[n, t, l]| {
            rula_table_b(n, t, l)
        });
    s.posture_b = posture_b;
    Boxes {
        neck_flex_deg: by_neck * nod.slope,
        neck_twisted: by_neck,
        neck_side: by_neck,
        trunk_flex_deg: by_trunk * free * stoop.slope,
        trunk_twisted: by_trunk,
        trunk_side: by_trunk,
        seated_supported: by_trunk * (1.0 - stoop.value),
        ..Boxes::default()
    }
}

fn wrist(boxes: &Boxes, profile: &Profile, blur: Blur) -> Soft {
    let bend = boxes.wrist_flex_deg;
    LOWEST + blur.outside(bend, profile.wrist_neutral_deg) + blur.outside(bend, 15.0)
}

fn neck(boxes: &Boxes, profile: &Profile, blur: Blur) -> Soft {
    let flexion = boxes.neck_flex_deg;
    LOWEST
        + blur.above(flexion, 10.0)
        + blur.above(flexion, 20.0)
        + blur.below(flexion, -profile.neck_extension_deg).times(3.0)
}

/// Trunk class without a backrest.
fn trunk(boxes: &Boxes, profile: &Profile, blur: Blur) -> Soft {
    let flexion = boxes.trunk_flex_deg;
    let far = profile
        .rula_trunk_far_extension_deg
        .map_or_else(Soft::default, |far| blur.below(flexion, -far));
    LOWEST
        + blur.outside(flexion, profile.trunk_upright_deg)
        + blur.above(flexion, 20.0)
        + far
        + blur.above(flexion, 60.0)
}

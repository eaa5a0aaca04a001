//! Smooth REBA: steps, tables, and the way back to the partial derivatives.

use super::boxes::Boxes;
use super::grid::interpolate;
use super::logistic::{Blur, Soft, either};
use super::steps::{LOWEST, lower_arm, upper_arm};
use crate::ergonomics::profile::Profile;
use crate::ergonomics::reba::{activity, load};
use crate::ergonomics::tables::{reba_table_a, reba_table_b, reba_table_c};
use crate::ergonomics::worksheet::Worksheet;
use serde::Serialize;

/// Every number of a smooth REBA sheet, in the ranges of [`crate::ergonomics::RebaSteps`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SmoothRebaSteps {
    /// Neck, 1-3.
    pub neck: f64,
    /// Trunk, 1-5.
    pub trunk: f64,
    /// Legs, 1-4.
    pub legs: f64,
    /// Table A, 1-9.
    pub table_a: f64,
    /// Load or force, 0-3, whole numbers.
    pub load: f64,
    /// Score A, 1-12.
    pub score_a: f64,
    /// Upper arm, 1-6.
    pub upper_arm: f64,
    /// Lower arm, 1-2.
    pub lower_arm: f64,
    /// Wrist, 1-3.
    pub wrist: f64,
    /// Table B, 1-9.
    pub table_b: f64,
    /// Coupling, 0-3, whole numbers.
    pub coupling: f64,
    /// Score B, 1-12.
    pub score_b: f64,
    /// Score C, 1-12.
    pub score_c: f64,
    /// Activity, 0-3, whole numbers.
    pub activity: f64,
    /// Final score, 1-15.
    #[serde(rename = "final")]
    pub total: f64,
}

/// Smooth REBA, and the partial derivatives of the final score with respect to the boxes.
pub(super) fn reba_steps(
    boxes: &Boxes,
    sheet: &Worksheet,
    profile: &Profile,
    blur: Blur,
) -> (SmoothRebaSteps, Boxes) {
    let mut s = SmoothRebaSteps::default();
    let by_body = body(boxes, sheet, profile, blur, &mut s);
    let by_arm = arm(boxes, sheet, blur, &mut s);
    (s.load, s.coupling) = (f64::from(load(sheet)), f64::from(sheet.coupling.min(3)));
    s.activity = f64::from(activity(sheet));
    let scores = [s.table_a + s.load, s.table_b + s.coupling];
    let (score_c, [by_a, by_b]) =
        interpolate::<2, 4>([12, 12], scores, |[a, b]| reba_table_c(a, b));
    [s.score_a, s.score_b] = scores.map(|score| score.min(12.0));
    s.score_c = score_c;
    s.total = score_c + s.activity;
    (s, by_body.scaled(by_a).plus(&by_arm.scaled(by_b)))
}

/// Group A; returns the derivatives of table A's score.
fn body(
    boxes: &Boxes,
    sheet: &Worksheet,
    profile: &Profile,
    blur: Blur,
    s: &mut SmoothRebaSteps,
) -> Boxes {
    let (nod, stoop) = (neck(boxes, profile, blur), trunk(boxes, profile, blur));
    let knees = knees(boxes, sheet, blur);
    s.neck = nod.value + either(boxes.neck_twisted, boxes.neck_side);
    s.trunk = stoop.value + either(boxes.trunk_twisted, boxes.trunk_side);
    s.legs = 1.0 + f64::from(sheet.legs_unbalanced) + knees.value;
    let (table_a, [by_neck, by_trunk, by_legs]) =
        interpolate::<3, 8>([3, 5, 4], [s.neck, s.trunk, s.legs], |[n, t, l]| {
            reba_table_a(n, t, l)
        });
    s.table_a = table_a;
    Boxes {
        neck_flex_deg: by_neck * nod.slope,
        neck_twisted: by_neck * (1.0 - boxes.neck_side),
        neck_side: by_neck * (1.0 - boxes.neck_twisted),
        trunk_flex_deg: by_trunk * stoop.slope,
        trunk_twisted: by_trunk * (1.0 - boxes.trunk_side),
        trunk_side: by_trunk * (1.0 - boxes.trunk_twisted),
        knee_flex_deg: by_legs * knees.slope,
        ..Boxes::default()
    }
}

/// Group B; returns the derivatives of table B's score.
fn arm(boxes: &Boxes, sheet: &Worksheet, blur: Blur, s: &mut SmoothRebaSteps) -> Boxes {
    let (upper_arm, moves) = upper_arm(boxes, sheet);
    let elbow = lower_arm(boxes, blur);
    let bend = LOWEST + blur.outside(boxes.wrist_flex_deg, 15.0);
    s.upper_arm = upper_arm;
    s.lower_arm = elbow.value;
    s.wrist = bend.value + either(boxes.deviated, boxes.twist_end);
    let (table_b, [by_upper, by_lower, by_wrist]) =
        interpolate::<3, 8>([6, 2, 3], [s.upper_arm, s.lower_arm, s.wrist], |[u, l, w]| {
            reba_table_b(u, l, w)
        });
    s.table_b = table_b;
    Boxes {
        upper_arm_class: by_upper * moves,
        raised: by_upper * moves,
        abducted: by_upper * moves,
        elbow_flex_deg: by_lower * elbow.slope,
        wrist_flex_deg: by_wrist * bend.slope,
        deviated: by_wrist * (1.0 - boxes.twist_end),
        twist_end: by_wrist * (1.0 - boxes.deviated),
        ..Boxes::default()
    }
}

fn neck(boxes: &Boxes, profile: &Profile, blur: Blur) -> Soft {
    let flexion = boxes.neck_flex_deg;
    LOWEST + blur.above(flexion, 20.0) + blur.below(flexion, -profile.neck_extension_deg)
}

fn trunk(boxes: &Boxes, profile: &Profile, blur: Blur) -> Soft {
    let flexion = boxes.trunk_flex_deg;
    LOWEST
        + blur.outside(flexion, profile.trunk_upright_deg)
        + blur.outside(flexion, 20.0)
        + blur.above(flexion, 60.0)
}

/// What bent knees add, 0-2.
fn knees(boxes: &Boxes, sheet: &Worksheet, blur: Blur) -> Soft {
    if sheet.sitting {
        return Soft::default();
    }
    blur.above(boxes.knee_flex_deg, 30.0) + blur.above(boxes.knee_flex_deg, 60.0)
}

//! What a worksheet asks of the posture, with boxes that are ticked by degrees.

use super::logistic::{Blur, Soft, either};
use crate::ergonomics::angles::{ArmAngles, TrunkNeckAngles};
use crate::ergonomics::assess::TaskInputs;
use crate::ergonomics::profile::{Profile, UpperArmRule};
use crate::ergonomics::worksheet::Worksheet;

/// The entries of a sheet that a posture changes: angles in deg, boxes from 0 to 1. Also used for the
/// partial derivatives of a score with respect to them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Boxes {
    /// Class of the upper arm by its direction, 1-4.
    pub(super) upper_arm_class: f64,
    pub(super) raised: f64,
    pub(super) abducted: f64,
    pub(super) elbow_flex_deg: f64,
    pub(super) across_or_out: f64,
    pub(super) wrist_flex_deg: f64,
    pub(super) deviated: f64,
    pub(super) twist_end: f64,
    pub(super) neck_flex_deg: f64,
    pub(super) neck_twisted: f64,
    pub(super) neck_side: f64,
    pub(super) trunk_flex_deg: f64,
    pub(super) trunk_twisted: f64,
    pub(super) trunk_side: f64,
    pub(super) seated_supported: f64,
    pub(super) knee_flex_deg: f64,
}

impl Boxes {
    /// Every entry by a factor.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self::default().combined(self, |_, x| factor * x)
    }

    /// Entry by entry sum.
    pub(super) fn plus(&self, other: &Self) -> Self {
        self.combined(other, |a, b| a + b)
    }

    fn combined(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            upper_arm_class: f(self.upper_arm_class, other.upper_arm_class),
            raised: f(self.raised, other.raised),
            abducted: f(self.abducted, other.abducted),
            elbow_flex_deg: f(self.elbow_flex_deg, other.elbow_flex_deg),
            across_or_out: f(self.across_or_out, other.across_or_out),
            wrist_flex_deg: f(self.wrist_flex_deg, other.wrist_flex_deg),
            deviated: f(self.deviated, other.deviated),
            twist_end: f(self.twist_end, other.twist_end),
            neck_flex_deg: f(self.neck_flex_deg, other.neck_flex_deg),
            neck_twisted: f(self.neck_twisted, other.neck_twisted),
            neck_side: f(self.neck_side, other.neck_side),
            trunk_flex_deg: f(self.trunk_flex_deg, other.trunk_flex_deg),
            trunk_twisted: f(self.trunk_twisted, other.trunk_twisted),
            trunk_side: f(self.trunk_side, other.trunk_side),
            seated_supported: f(self.seated_supported, other.seated_supported),
            knee_flex_deg: f(self.knee_flex_deg, other.knee_flex_deg),
        }
    }
}

/// Derivatives of the boxes with respect to the body angles that move them, per deg or per m.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slopes {
    pub(super) class_flex: f64,
    pub(super) class_elevation: f64,
    pub(super) raised_girdle: f64,
    pub(super) raised_elevation: f64,
    pub(super) abducted: f64,
    pub(super) across_lateral: f64,
    pub(super) out_beyond: f64,
    pub(super) deviation: f64,
    pub(super) wrist_twist: f64,
    pub(super) neck_twist: f64,
    pub(super) neck_side: f64,
    pub(super) trunk_twist: f64,
    pub(super) trunk_side: f64,
    pub(super) seated_trunk_flex: f64,
}

/// The boxes of a filled-in sheet, and the slope of the upper arm's class with its flexion.
pub(super) fn from_sheet(sheet: &Worksheet, blur: Blur) -> (Boxes, f64) {
    let class = class_of(sheet.upper_arm_flex_deg, blur);
    let boxes = Boxes {
        upper_arm_class: class.value,
        raised: f64::from(sheet.shoulder_raised),
        abducted: f64::from(sheet.upper_arm_abducted),
        elbow_flex_deg: sheet.elbow_flex_deg,
        across_or_out: f64::from(sheet.forearm_across_or_out),
        wrist_flex_deg: sheet.wrist_flex_deg,
        deviated: f64::from(sheet.wrist_deviated),
        twist_end: f64::from(sheet.wrist_twist_end),
        neck_flex_deg: sheet.neck_flex_deg,
        neck_twisted: f64::from(sheet.neck_twisted),
        neck_side: f64::from(sheet.neck_side),
        trunk_flex_deg: sheet.trunk_flex_deg,
        trunk_twisted: f64::from(sheet.trunk_twisted),
        trunk_side: f64::from(sheet.trunk_side),
        seated_supported: f64::from(sheet.trunk_seated_supported),
        knee_flex_deg: sheet.knee_flex_deg,
    };
    (boxes, class.slope)
}

/// The boxes of measured angles: the smooth image of [`crate::ergonomics::worksheet`].
pub(super) fn from_angles(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    task: &TaskInputs,
    profile: &Profile,
    blur: Blur,
) -> (Boxes, Slopes) {
    let mut slopes = Slopes::default();
    let boxes = Boxes {
        upper_arm_class: upper_arm_class(arm, profile.upper_arm_rule, blur, &mut slopes),
        raised: raised(arm, profile, blur, &mut slopes),
        abducted: tick(
            blur.above(arm.upper_arm_abduction_deg, profile.abducted_deg),
            &mut slopes.abducted,
        ),
        elbow_flex_deg: arm.elbow_flex_deg,
        across_or_out: across_or_out(arm, profile, blur.in_metres(), &mut slopes),
        wrist_flex_deg: arm.wrist_flex_deg,
        deviated: tick(
            blur.outside(arm.wrist_deviation_deg, profile.wrist_deviated_deg),
            &mut slopes.deviation,
        ),
        twist_end: tick(
            blur.outside(arm.wrist_twist_deg, profile.wrist_twist_deg),
            &mut slopes.wrist_twist,
        ),
        neck_flex_deg: body.neck_flex_deg,
        neck_twisted: tick(
            blur.outside(body.neck_twist_deg, profile.neck_twist_deg),
            &mut slopes.neck_twist,
        ),
        neck_side: tick(
            blur.outside(body.neck_side_deg, profile.neck_side_deg),
            &mut slopes.neck_side,
        ),
        trunk_flex_deg: body.trunk_flex_deg,
        trunk_twisted: tick(
            blur.outside(body.trunk_twist_deg, profile.trunk_twist_deg),
            &mut slopes.trunk_twist,
        ),
        trunk_side: tick(
            blur.outside(body.trunk_side_deg, profile.trunk_side_deg),
            &mut slopes.trunk_side,
        ),
        seated_supported: if task.sitting && task.trunk_supported {
            let reclined = blur.below(body.trunk_flex_deg, profile.trunk_upright_deg);
            tick(reclined, &mut slopes.seated_trunk_flex)
        } else {
            0.0
        },
        knee_flex_deg: task.knee_flex_deg,
    };
    (boxes, slopes)
}

/// Takes a step apart into the box's value and the slope kept beside it.
fn tick(step: Soft, slope: &mut f64) -> f64 {
    *slope = step.slope;
    step.value
}

/// Class 1-4 of the upper arm at a flexion, deg; the same steps in RULA and REBA.
fn class_of(flexion: f64, blur: Blur) -> Soft {
    Soft { value: 1.0, slope: 0.0 }
        + blur.below(flexion, -20.0)
        + blur.above(flexion, 20.0)
        + blur.above(flexion, 45.0)
        + blur.above(flexion, 90.0)
}

/// Class 1-4 by the arm's direction. Above 90 deg of elevation the elevation's class fades in.
fn upper_arm_class(arm: &ArmAngles, rule: UpperArmRule, blur: Blur, slopes: &mut Slopes) -> f64 {
    let (flexion, elevation) = (arm.upper_arm_flex_deg, arm.upper_arm_elevation_deg);
    let high = class_of(elevation, blur);
    let guard = blur.above(elevation, 90.0);
    let (low, by_flexion, by_elevation) = match rule {
        UpperArmRule::Literal => {
            let class = class_of(flexion, blur);
            (class.value, class.slope, 0.0)
        }
        UpperArmRule::Elevation => {
            let back = class_of(-elevation, blur);
            let backward = blur.below(flexion + 0.5 * elevation, 0.0);
            let drop = back.value - high.value;
            (
                high.value + backward.value * drop,
                backward.slope * drop,
                high.slope * (1.0 - backward.value) - backward.value * back.slope
                    + 0.5 * backward.slope * drop,
            )
        }
    };
    slopes.class_flex = by_flexion * (1.0 - guard.value);
    slopes.class_elevation = by_elevation * (1.0 - guard.value)
        + guard.slope * (high.value - low)
        + guard.value * high.slope;
    low + guard.value * (high.value - low)
}

fn raised(arm: &ArmAngles, profile: &Profile, blur: Blur, slopes: &mut Slopes) -> f64 {
    let rhythm = blur.excess(arm.upper_arm_elevation_deg, 30.0).times(profile.girdle_rhythm);
    let lifted = blur.above(arm.girdle_elevation_deg - rhythm.value, profile.shoulder_raised_deg);
    slopes.raised_girdle = lifted.slope;
    slopes.raised_elevation = -lifted.slope * rhythm.slope;
    lifted.value
}

fn across_or_out(arm: &ArmAngles, profile: &Profile, metres: Blur, slopes: &mut Slopes) -> f64 {
    let across = metres.below(arm.wrist_lateral_m, -profile.midline_tolerance_m);
    let out = metres.above(arm.wrist_beyond_shoulder_m, profile.out_margin_m);
    slopes.across_lateral = across.slope * (1.0 - out.value);
    slopes.out_beyond = out.slope * (1.0 - across.value);
    either(across.value, out.value)
}

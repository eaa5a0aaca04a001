//! Smooth RULA and REBA: continuous stand-ins for the official scores, with exact gradients.
//!
//! ```text
//! threshold at t   ─►  logistic step  1 / (1 + exp(-(x - t) / s))        s = width / (2 ln 9)
//! tables A, B, C   ─►  multilinear interpolation between their cells, clamped as the tables are
//! ```
//! The width is that between 10 and 90 % of a step, in deg; steps in metres (where the wrist is) use
//! [`METRES_PER_DEG`]. As the width goes to 0 the official score of the same profile is met wherever no
//! angle is on a threshold. What is ticked or told rather than measured (load, coupling, support,
//! repetition, legs) scores as officially.
//!
//! - Two boxes of which either adds the one point (REBA's twist and side bend, the forearm across or
//!   out) combine as `1 - (1 - p)(1 - q)`.
//! - The guard on the upper arm's class above 90 deg of elevation fades in by a step of the same
//!   width, so that it too is exact in the limit.
//! - A neutral band of 0 deg has no inside: the step next to zero counts everywhere, where the
//!   official score makes an exception for exactly 0.
//!
//! The scores are continuous everywhere. Their gradient jumps where a step score passes a whole number
//! (an edge between two cells of a table) and at the floor of 1 under a supported arm; there it is the
//! gradient of one side. An angle that is not a number gives a score that is not a number.

mod boxes;
mod grid;
mod logistic;
mod reba;
mod rula;
mod steps;
#[cfg(test)]
mod tests;

pub use logistic::{DEFAULT_WIDTH_DEG, METRES_PER_DEG};
pub use reba::SmoothRebaSteps;
pub use rula::SmoothRulaSteps;

use super::angles::{ArmAngles, TrunkNeckAngles};
use super::assess::{TaskInputs, worksheet};
use super::profile::Profile;
use super::worksheet::Worksheet;
use boxes::{Boxes, Slopes, from_angles, from_sheet};
use logistic::Blur;
use serde::Serialize;

/// A smooth score, step by step, and the gradient of its last number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Smooth<Steps, Gradient> {
    /// Every number of the sheet.
    pub steps: Steps,
    /// Partial derivatives of the grand (RULA) or final (REBA) score.
    pub gradient: Gradient,
}

/// Partial derivatives with respect to body angles: each field stands for the angle of its name, per
/// deg, or per m for the two that are lengths.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct AngleGradient {
    /// With respect to trunk and neck.
    pub body: TrunkNeckAngles,
    /// With respect to the arm.
    pub arm: ArmAngles,
    /// With respect to the knee's flexion, which is a task input.
    pub knee_flex_deg: f64,
}

impl AngleGradient {
    /// Rate of the score where the angles change at these rates (deg/s and m/s give 1/s).
    pub fn along(&self, body: &TrunkNeckAngles, arm: &ArmAngles) -> f64 {
        let (b, a) = (&self.body, &self.arm);
        b.trunk_flex_deg * body.trunk_flex_deg
            + b.trunk_side_deg * body.trunk_side_deg
            + b.trunk_twist_deg * body.trunk_twist_deg
            + b.neck_flex_deg * body.neck_flex_deg
            + b.neck_side_deg * body.neck_side_deg
            + b.neck_twist_deg * body.neck_twist_deg
            + a.upper_arm_flex_deg * arm.upper_arm_flex_deg
            + a.upper_arm_abduction_deg * arm.upper_arm_abduction_deg
            + a.upper_arm_elevation_deg * arm.upper_arm_elevation_deg
            + a.girdle_elevation_deg * arm.girdle_elevation_deg
            + a.elbow_flex_deg * arm.elbow_flex_deg
            + a.wrist_flex_deg * arm.wrist_flex_deg
            + a.wrist_deviation_deg * arm.wrist_deviation_deg
            + a.wrist_twist_deg * arm.wrist_twist_deg
            + a.wrist_lateral_m * arm.wrist_lateral_m
            + a.wrist_beyond_shoulder_m * arm.wrist_beyond_shoulder_m
    }
}

/// Partial derivatives with respect to the angles of a worksheet, per deg; its boxes are given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SheetGradient {
    /// Upper arm flexion.
    pub upper_arm_flex_deg: f64,
    /// Elbow flexion.
    pub elbow_flex_deg: f64,
    /// Wrist flexion.
    pub wrist_flex_deg: f64,
    /// Neck flexion.
    pub neck_flex_deg: f64,
    /// Trunk flexion.
    pub trunk_flex_deg: f64,
    /// Knee flexion.
    pub knee_flex_deg: f64,
}

/// Smooth RULA of one posture of one side, with steps of `width_deg`.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{
///     ArmAngles, DEFAULT_WIDTH_DEG, Profile, TaskInputs, TrunkNeckAngles, smooth_rula,
/// };
/// let body = TrunkNeckAngles { trunk_flex_deg: 19.7, ..TrunkNeckAngles::default() };
/// let arm = ArmAngles { elbow_flex_deg: 80.0, wrist_lateral_m: 0.2, ..ArmAngles::default() };
/// let task = TaskInputs::default();
/// let smooth = smooth_rula(&body, &arm, &task, &Profile::default(), DEFAULT_WIDTH_DEG);
/// // Bending on towards 20 deg raises the trunk's step.
/// assert!(smooth.steps.trunk > 2.1 && smooth.gradient.body.trunk_flex_deg > 0.0);
/// ```
pub fn smooth_rula(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    task: &TaskInputs,
    profile: &Profile,
    width_deg: f64,
) -> Smooth<SmoothRulaSteps, AngleGradient> {
    let blur = Blur::new(width_deg);
    let (boxes, slopes) = from_angles(body, arm, task, profile, blur);
    let sheet = worksheet(body, arm, task, profile);
    let (steps, partials) = rula::rula_steps(&boxes, &sheet, profile, blur);
    Smooth { steps, gradient: angle_gradient(&partials, &slopes) }
}

/// Smooth REBA of one posture of one side, with steps of `width_deg`; see [`smooth_rula`].
pub fn smooth_reba(
    body: &TrunkNeckAngles,
    arm: &ArmAngles,
    task: &TaskInputs,
    profile: &Profile,
    width_deg: f64,
) -> Smooth<SmoothRebaSteps, AngleGradient> {
    let blur = Blur::new(width_deg);
    let (boxes, slopes) = from_angles(body, arm, task, profile, blur);
    let sheet = worksheet(body, arm, task, profile);
    let (steps, partials) = reba::reba_steps(&boxes, &sheet, profile, blur);
    Smooth { steps, gradient: angle_gradient(&partials, &slopes) }
}

/// Smooth RULA of a filled-in worksheet: its angles are blurred by `width_deg`, its boxes stand.
pub fn smooth_rula_sheet(
    sheet: &Worksheet,
    profile: &Profile,
    width_deg: f64,
) -> Smooth<SmoothRulaSteps, SheetGradient> {
    let blur = Blur::new(width_deg);
    let (boxes, class_slope) = from_sheet(sheet, blur);
    let (steps, partials) = rula::rula_steps(&boxes, sheet, profile, blur);
    Smooth { steps, gradient: sheet_gradient(&partials, class_slope) }
}

/// Smooth REBA of a filled-in worksheet: its angles are blurred by `width_deg`, its boxes stand.
pub fn smooth_reba_sheet(
    sheet: &Worksheet,
    profile: &Profile,
    width_deg: f64,
) -> Smooth<SmoothRebaSteps, SheetGradient> {
    let blur = Blur::new(width_deg);
    let (boxes, class_slope) = from_sheet(sheet, blur);
    let (steps, partials) = reba::reba_steps(&boxes, sheet, profile, blur);
    Smooth { steps, gradient: sheet_gradient(&partials, class_slope) }
}

fn sheet_gradient(partials: &Boxes, class_slope: f64) -> SheetGradient {
    SheetGradient {
        upper_arm_flex_deg: partials.upper_arm_class * class_slope,
        elbow_flex_deg: partials.elbow_flex_deg,
        wrist_flex_deg: partials.wrist_flex_deg,
        neck_flex_deg: partials.neck_flex_deg,
        trunk_flex_deg: partials.trunk_flex_deg,
        knee_flex_deg: partials.knee_flex_deg,
    }
}

fn angle_gradient(p: &Boxes, s: &Slopes) -> AngleGradient {
    AngleGradient {
        body: TrunkNeckAngles {
            trunk_flex_deg: p.trunk_flex_deg + p.seated_supported * s.seated_trunk_flex,
            trunk_side_deg: p.trunk_side * s.trunk_side,
            trunk_twist_deg: p.trunk_twisted * s.trunk_twist,
            neck_flex_deg: p.neck_flex_deg,
            neck_side_deg: p.neck_side * s.neck_side,
            neck_twist_deg: p.neck_twisted * s.neck_twist,
        },
        arm: ArmAngles {
            upper_arm_flex_deg: p.upper_arm_class * s.class_flex,
            upper_arm_abduction_deg: p.abducted * s.abducted,
            upper_arm_elevation_deg: p.upper_arm_class * s.class_elevation
                + p.raised * s.raised_elevation,
            girdle_elevation_deg: p.raised * s.raised_girdle,
            elbow_flex_deg: p.elbow_flex_deg,
            wrist_flex_deg: p.wrist_flex_deg,
            wrist_deviation_deg: p.deviated * s.deviation,
            wrist_twist_deg: p.twist_end * s.wrist_twist,
            wrist_lateral_m: p.across_or_out * s.across_lateral,
            wrist_beyond_shoulder_m: p.across_or_out * s.out_beyond,
        },
        knee_flex_deg: p.knee_flex_deg,
    }
}

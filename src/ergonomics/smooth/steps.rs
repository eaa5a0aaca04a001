//! What the smooth steps of both methods share.

use super::boxes::Boxes;
use super::logistic::{Blur, Soft};
use crate::ergonomics::worksheet::Worksheet;

/// The lowest class.
pub(super) const LOWEST: Soft = Soft { value: 1.0, slope: 0.0 };

/// Upper arm score, and 1 or 0: whether it follows its class and boxes or is held at 1.
pub(super) fn upper_arm(boxes: &Boxes, sheet: &Worksheet) -> (f64, f64) {
    let raised = boxes.upper_arm_class + boxes.raised + boxes.abducted;
    let score = raised - f64::from(sheet.arm_supported);
    if score < 1.0 { (1.0, 0.0) } else { (score, 1.0) }
}

/// Lower arm class by the elbow, 1-2.
pub(super) fn lower_arm(boxes: &Boxes, blur: Blur) -> Soft {
    LOWEST + blur.below(boxes.elbow_flex_deg, 60.0) + blur.above(boxes.elbow_flex_deg, 100.0)
}

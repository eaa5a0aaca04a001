//! The mirror image of a body: left for right.
//!
//! Bodies are their own mirror images about the x-y plane of the rest frame. Angles about X and Y
//! and displacements to the right change their sign, everything else only its side.

use crate::math::{Pose, Vec3};
use nalgebra::UnitQuaternion;

/// The joint on the other side; joints on the midline are their own.
pub fn other_side_joint(joint: &str) -> String {
    if joint.contains("Right") {
        joint.replacen("Right", "Left", 1)
    } else {
        joint.replacen("Left", "Right", 1)
    }
}

/// Sign that the value of a joint takes in the mirror image.
pub fn mirror_sign(joint: &str) -> f64 {
    let keeps = joint.ends_with("_Z") || joint == "pelvis_forward" || joint == "pelvis_up";
    if keeps { 1.0 } else { -1.0 }
}

/// A grip in the rest frame as the other hand's grip in the mirror image.
///
/// The left grip's axes are those of the right one but for x and z, which point the other way on the arm:
/// its z along the bar to the thumb and y to the wrist mirror, x = y cross z follows.
pub fn mirrored_pose(grip: &Pose) -> Pose {
    let p = grip.translation.vector;
    // Mirroring turns the axis of a rotation about: x and y parts change sign.
    let q = grip.rotation.quaternion();
    let mirrored = nalgebra::Quaternion::new(q.w, -q.i, -q.j, q.k);
    // M R M has its z axis turned round; half a turn about y makes y and z the mirrored axes again.
    let turn = UnitQuaternion::new_unchecked(mirrored)
        * UnitQuaternion::from_scaled_axis(Vec3::y() * std::f64::consts::PI);
    Pose::from_parts(Vec3::new(p.x, p.y, -p.z).into(), turn)
}

//! Rigid-body poses and the exponential map of rotations.
//!
//! A pose `X_AB` maps coordinates in frame B to frame A; letters cancel: `X_AC = X_AB * X_BC`.

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3, Vector6};

/// A vector in three dimensions, m unless said otherwise.
pub type Vec3 = Vector3<f64>;
/// A twist or pose error: linear part first, then angular.
pub type Vec6 = Vector6<f64>;
/// A rigid-body pose.
pub type Pose = Isometry3<f64>;
/// A rotation matrix.
pub type Rotation = Rotation3<f64>;

/// Rotation vector (rad) that turns `from` into `to`, in the axes in which both are given.
///
/// Norm at most pi.
pub fn rotation_between(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> Vec3 {
    (to * from.inverse()).scaled_axis()
}

/// Error that takes `from` to `to`: translation (m), then rotation vector (rad), in base axes.
pub fn pose_error(from: &Pose, to: &Pose) -> Vec6 {
    let p = to.translation.vector - from.translation.vector;
    let r = rotation_between(&from.rotation, &to.rotation);
    Vec6::new(p.x, p.y, p.z, r.x, r.y, r.z)
}

/// Interpolates position linearly and orientation along the shortest rotation; `s` in [0, 1].
///
/// Unlike a plain slerp this has a defined answer for opposite orientations.
pub fn interpolate(a: &Pose, b: &Pose, s: f64) -> Pose {
    let p = a.translation.vector.lerp(&b.translation.vector, s);
    let turn = rotation_between(&a.rotation, &b.rotation);
    Pose::from_parts(p.into(), UnitQuaternion::from_scaled_axis(turn * s) * a.rotation)
}

/// Angles (rad) about Z, X and Y in that order, of a rotation `R_z R_x R_y`.
pub fn zxy(rotation: &nalgebra::Matrix3<f64>) -> [f64; 3] {
    let r = rotation;
    let x = r[(2, 1)].clamp(-1.0, 1.0).asin();
    [(-r[(0, 1)]).atan2(r[(1, 1)]), x, (-r[(2, 0)]).atan2(r[(2, 2)])]
}

/// The rotation whose columns are the given orthonormal, right-handed axes.
pub fn rotation_from_axes(x: Vec3, y: Vec3, z: Vec3) -> UnitQuaternion<f64> {
    let matrix = nalgebra::Matrix3::from_columns(&[x, y, z]);
    UnitQuaternion::from_rotation_matrix(&Rotation::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn error_takes_one_pose_to_the_other() {
        let a = Pose::new(Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.3, -0.4, 0.5));
        let b = Pose::new(Vec3::new(-0.4, 0.1, 0.9), Vec3::new(-1.0, 0.2, 0.1));
        let e = pose_error(&a, &b);
        let turn = UnitQuaternion::from_scaled_axis(Vec3::new(e[3], e[4], e[5]));
        assert_relative_eq!((turn * a.rotation).angle_to(&b.rotation), 0.0, epsilon = 1e-12);
        assert_relative_eq!(interpolate(&a, &b, 1.0), b, epsilon = 1e-12);
        assert_relative_eq!(interpolate(&a, &b, 0.0), a, epsilon = 1e-12);
    }
}

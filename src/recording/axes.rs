//! The constant rotations that bring each format's segment axes into ISB anatomical axes.

use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use nalgebra::UnitQuaternion;
use std::f64::consts::FRAC_PI_2;

/// The segments a recording can hold, in the order in which it holds them.
pub const SEGMENT_NAMES: [&str; 23] = [
    "Pelvis",
    "L5",
    "L3",
    "T12",
    "T8",
    "Neck",
    "Head",
    "RightShoulder",
    "RightUpperArm",
    "RightForeArm",
    "RightHand",
    "LeftShoulder",
    "LeftUpperArm",
    "LeftForeArm",
    "LeftHand",
    "RightUpperLeg",
    "RightLowerLeg",
    "RightFoot",
    "RightToe",
    "LeftUpperLeg",
    "LeftLowerLeg",
    "LeftFoot",
    "LeftToe",
];

/// A segment and the one that follows it on the main chain.
pub(super) const NEXT: [(&str, &str); 18] = [
    ("Pelvis", "L5"),
    ("L5", "L3"),
    ("L3", "T12"),
    ("T12", "T8"),
    ("T8", "Neck"),
    ("Neck", "Head"),
    ("RightShoulder", "RightUpperArm"),
    ("RightUpperArm", "RightForeArm"),
    ("RightForeArm", "RightHand"),
    ("LeftShoulder", "LeftUpperArm"),
    ("LeftUpperArm", "LeftForeArm"),
    ("LeftForeArm", "LeftHand"),
    ("RightUpperLeg", "RightLowerLeg"),
    ("RightLowerLeg", "RightFoot"),
    ("RightFoot", "RightToe"),
    ("LeftUpperLeg", "LeftLowerLeg"),
    ("LeftLowerLeg", "LeftFoot"),
    ("LeftFoot", "LeftToe"),
];

/// The segment on which another hangs.
pub(super) fn before(name: &str) -> Option<&'static str> {
    match name {
        "RightShoulder" | "LeftShoulder" => Some("T8"),
        "RightUpperLeg" | "LeftUpperLeg" => Some("Pelvis"),
        _ => NEXT.iter().find(|(_, next)| *next == name).map(|(segment, _)| *segment),
    }
}

/// Lengths of segments (m) by the distance between two joint centres: from each to the next of the main chain,
/// across the shoulders and across the hips, where both centres are known. Hands have none.
pub(super) fn lengths_between(
    distance_m: impl Fn(&str, &str) -> Option<f64>,
) -> Vec<(String, f64)> {
    let across = [
        ("ShoulderToShoulder", "RightUpperArm", "LeftUpperArm"),
        ("HipToHip", "RightUpperLeg", "LeftUpperLeg"),
    ];
    let along = NEXT.iter().map(|(segment, next)| (*segment, *segment, *next));
    along
        .chain(across)
        .filter_map(|(name, from, to)| Some((name.to_owned(), distance_m(from, to)?)))
        .collect()
}

/// MVNX segment axes (x forward, y left, z up) from ISB axes (x forward, y up, z right).
///
/// The zero of MVNX v3 is already the anatomical pose with palms forward: in the calibration frame
/// with arms sideways and palms down the hand's x axis points down (palmar), the upper arm's
/// forward, the radial styloid lies on +z (ISB) of the right forearm and the little finger on -z.
pub(super) fn mvnx_from_isb() -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(FRAC_PI_2, 0.0, 0.0)
}

/// From a file's world axes to those of a recording: turned in a cycle until the vertical one (0, 1, 2:
/// x, y, z) is z.
pub(super) fn upright(vertical: usize) -> UnitQuaternion<f64> {
    let mut images = [Vec3::zeros(); 3];
    for (i, image) in [Vec3::x(), Vec3::y(), Vec3::z()].into_iter().enumerate() {
        images[(vertical + 1 + i) % 3] = image;
    }
    let [x, y, z] = images;
    rotation_from_axes(x, y, z)
}

/// Axes of a limb that lies along a unit vector: y against it, z as near as can be to the one given;
/// none where that one tells nothing.
pub(super) fn along_limb(along: &Vec3, near_z: &Vec3) -> Option<UnitQuaternion<f64>> {
    let y = -along;
    let z = square(near_z, &y)?;
    Some(rotation_from_axes(y.cross(&z), y, z))
}

/// The part of a vector that is square to a unit axis, made a unit; none where little is left.
pub(super) fn square(vector: &Vec3, axis: &Vec3) -> Option<Vec3> {
    let unit = vector.try_normalize(0.0)?;
    (unit - axis * axis.dot(&unit)).try_normalize(0.1)
}

/// Angles (rad) `[z, x, y]` of `R = Rz Rx Ry` for the rotation of a child segment in its parent.
///
/// At a right elbow: flexion, carrying angle, pronation; at a left one x and y change sign. The
/// split is singular where x reaches +-90 degrees.
pub fn zxy_angles(child_in_parent: &UnitQuaternion<f64>) -> [f64; 3] {
    crate::math::pose::zxy(child_in_parent.to_rotation_matrix().matrix())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_axes_of_mvnx_are_turned_upright() {
        assert_relative_eq!(mvnx_from_isb() * Vec3::y(), Vec3::z(), epsilon = 1e-12);
        assert_relative_eq!(mvnx_from_isb() * Vec3::z(), -Vec3::y(), epsilon = 1e-12);
    }

    #[test]
    fn every_segment_but_the_pelvis_hangs_on_one_that_comes_earlier() {
        let place = |name: &str| SEGMENT_NAMES.iter().position(|n| *n == name).unwrap();
        assert_eq!(before("Pelvis"), None);
        for name in &SEGMENT_NAMES[1..] {
            assert!(place(before(name).unwrap()) < place(name), "{name}");
        }
    }

    #[test]
    fn zxy_angles_undo_the_product() {
        let (z, x, y) = (1.1, -0.4, 2.0);
        let q = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), z)
            * UnitQuaternion::from_axis_angle(&Vec3::x_axis(), x)
            * UnitQuaternion::from_axis_angle(&Vec3::y_axis(), y);
        let found = zxy_angles(&q);
        for (a, b) in found.iter().zip([z, x, y]) {
            assert_relative_eq!(*a, b, epsilon = 1e-12);
        }
    }
}

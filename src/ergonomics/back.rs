//! Cumulative back angle, in two readings; the literature that uses the name does not define it.
//!
//! - [`back_angle`]: of one posture, the rotations of the four spine joints L5/S1, L4/L3, L1/T12 and
//!   T9/T8 added up, deg. How bent the back is now, wherever the pelvis points.
//! - [`back_exposure`]: over a movement, the time integral of the trunk's inclination, deg s, and its
//!   mean. How long it was bent how far, to the vertical.

use crate::math::Rotation;
use serde::Serialize;

/// Spine joints that count: jL5S1, jL4L3, jL1T12, jT9T8.
pub const SPINE_JOINTS: usize = 4;

/// Rotations of the spine's joints added up, deg.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct BackAngle {
    /// Sum of the rotation angles, whatever their axes; never negative. Bends of two joints that
    /// cancel still count.
    pub rotation_deg: f64,
    /// Sum of the flexion components of the rotation vectors; forward positive. Extension takes
    /// away.
    pub flexion_deg: f64,
}

/// Cumulative back angle of one posture.
///
/// `joints` are the rotations of the upper segment in the lower one's axes (ISB: x forward, y up, z
/// right), one for each spine joint. At a rotation of exactly 180 deg, which no spine joint makes, the
/// sign of the axis and so of the flexion is open.
pub fn back_angle(joints: &[Rotation; SPINE_JOINTS]) -> BackAngle {
    joints.iter().fold(BackAngle::default(), |sum, joint| {
        let vector = nalgebra::UnitQuaternion::from_rotation_matrix(joint).scaled_axis();
        BackAngle {
            rotation_deg: sum.rotation_deg + vector.norm().to_degrees(),
            // Flexion turns about -z.
            flexion_deg: sum.flexion_deg - vector.z.to_degrees(),
        }
    })
}

/// Inclination of the trunk over a movement.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct BackExposure {
    /// Time integral of the inclination's magnitude, deg s.
    pub integral_deg_s: f64,
    /// The integral by the duration, deg; without a duration, the mean of the samples.
    pub mean_deg: f64,
}

/// Time integral and mean of |inclination|; `samples` are (time s, inclination deg) in order of time.
///
/// Between two samples the inclination is taken to run straight, through zero where it changes sign,
/// so the integral is exact for such a course. Nothing sampled gives 0.
pub fn back_exposure(samples: &[(f64, f64)]) -> BackExposure {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return BackExposure::default();
    };
    let integral_deg_s =
        samples.windows(2).map(|w| (w[1].0 - w[0].0) * mean_magnitude(w[0].1, w[1].1)).sum();
    let duration = last.0 - first.0;
    let mean_deg = if duration > 0.0 {
        integral_deg_s / duration
    } else {
        samples.iter().map(|s| s.1.abs()).sum::<f64>() / samples.len() as f64
    };
    BackExposure { integral_deg_s, mean_deg }
}

/// Mean of |x| as x runs straight from a to b.
fn mean_magnitude(a: f64, b: f64) -> f64 {
    if a * b >= 0.0 { 0.5 * (a.abs() + b.abs()) } else { 0.5 * (a * a + b * b) / (a - b).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn about(axis: Vec3, deg: f64) -> Rotation {
        Rotation::from_scaled_axis(axis.normalize() * deg.to_radians())
    }

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn a_straight_back_has_no_angle() {
        assert_eq!(back_angle(&[Rotation::identity(); 4]), BackAngle::default());
    }

    #[test]
    fn flexion_of_each_joint_adds_up() {
        let back = back_angle(&[10.0, 15.0, 20.0, 5.0].map(|deg| about(-Vec3::z(), deg)));
        near(back.rotation_deg, 50.0);
        near(back.flexion_deg, 50.0);
    }

    #[test]
    fn opposite_bends_add_as_rotation_and_cancel_as_flexion() {
        let back = back_angle(&[25.0, -25.0, 10.0, -10.0].map(|deg| about(-Vec3::z(), deg)));
        near(back.rotation_deg, 70.0);
        near(back.flexion_deg, 0.0);
    }

    #[test]
    fn a_slanted_axis_shares_its_angle() {
        // Axis between flexion (-z) and twist (+y) at 60 deg from flexion: half of it is flexion.
        let axis = Vec3::new(0.0, 60.0f64.to_radians().sin(), -60.0f64.to_radians().cos());
        let still = Rotation::identity();
        let back = back_angle(&[about(axis, 40.0), still, still, about(Vec3::x(), 12.0)]);
        near(back.rotation_deg, 52.0);
        near(back.flexion_deg, 20.0);
    }

    #[test]
    fn a_constant_bend_integrates_to_angle_times_time() {
        for angle in [30.0, -30.0] {
            let samples: Vec<(f64, f64)> = (0..=20).map(|k| (0.1 * f64::from(k), angle)).collect();
            let back = back_exposure(&samples);
            near(back.integral_deg_s, 60.0);
            near(back.mean_deg, 30.0);
        }
    }

    #[test]
    fn a_ramp_through_zero_is_integrated_exactly() {
        // From -30 to 60 deg in 3 s: two triangles, 30 * 1 / 2 + 60 * 2 / 2, for any sampling.
        for times in [vec![0.0, 3.0], vec![0.0, 0.7, 1.1, 3.0]] {
            let samples: Vec<(f64, f64)> =
                times.iter().map(|t| (5.0 + t, -30.0 + 30.0 * t)).collect();
            near(back_exposure(&samples).integral_deg_s, 75.0);
            near(back_exposure(&samples).mean_deg, 25.0);
        }
    }

    #[test]
    fn a_half_sine_converges_to_its_integral() {
        // 40 sin(pi t / T) over T = 2 s integrates to 2 T 40 / pi; the rule is of second order.
        let error = |n: i32| {
            let samples: Vec<(f64, f64)> = (0..=n)
                .map(|k| f64::from(k) / f64::from(n))
                .map(|s| (2.0 * s, 40.0 * (std::f64::consts::PI * s).sin()))
                .collect();
            (back_exposure(&samples).integral_deg_s - 160.0 / std::f64::consts::PI).abs()
        };
        assert!(error(1000) < 1e-4);
        assert!((error(100) / error(200) - 4.0).abs() < 0.01);
    }

    #[test]
    fn no_time_has_a_mean_but_no_integral() {
        assert_eq!(back_exposure(&[]), BackExposure::default());
        let once = back_exposure(&[(1.0, -12.0)]);
        assert_eq!((once.integral_deg_s, once.mean_deg), (0.0, 12.0));
    }
}

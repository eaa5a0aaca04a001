//! What a TCP path may not exceed.

use super::refusal::InputFault;
use crate::math::Vec3;
use serde::{Deserialize, Serialize};

/// An axis-aligned box in the world, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Box3 {
    /// Least x, y, z.
    pub min: Vec3,
    /// Greatest x, y, z.
    pub max: Vec3,
}

/// A face of a box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Face {
    /// The axis on which it stands: 0 to 2.
    pub axis: usize,
    /// Whether it bounds that coordinate from above.
    pub is_upper: bool,
    /// Where, m.
    pub at_m: f64,
}

impl Box3 {
    /// How far a point is outside the face of `axis` (0 to 2) on its upper or lower side, m;
    /// negative inside.
    pub fn excess(&self, point: &Vec3, axis: usize, is_upper: bool) -> f64 {
        if is_upper { point[axis] - self.max[axis] } else { self.min[axis] - point[axis] }
    }

    /// The face of `axis` (0 to 2) on its upper or lower side.
    pub fn face(&self, axis: usize, is_upper: bool) -> Face {
        let at_m = if is_upper { self.max[axis] } else { self.min[axis] };
        Face { axis, is_upper, at_m }
    }

    /// The six faces: axis and whether it is the upper one.
    pub fn faces() -> impl Iterator<Item = (usize, bool)> {
        (0..3).flat_map(|axis| [(axis, false), (axis, true)])
    }
}

/// Limits of a TCP path. The defaults are planning values, assumed and no certification: 0.25 m/s is
/// the reduced speed of manual operation, the others are comfort proposals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PathLimits {
    /// Greatest speed, m/s.
    pub speed_m_s: f64,
    /// Greatest acceleration, m/s^2.
    pub acceleration_m_s2: f64,
    /// Greatest jerk along each axis of the world, m/s^3.
    pub jerk_m_s3: f64,
    /// Greatest angular speed, rad/s.
    pub angular_speed_rad_s: f64,
    /// Greatest angular acceleration, rad/s^2.
    pub angular_acceleration_rad_s2: f64,
    /// Where the TCP must stay, if anywhere.
    pub workspace: Option<Box3>,
    /// Distance that the TCP keeps from obstacles, m: the room of the tool, the handle and the hand
    /// on it. Where start or goal are nearer to an obstacle than that, their distance counts.
    pub clearance_m: f64,
    /// How far the TCP may be from the reference at equal times, m, if that is limited.
    pub corridor_m: Option<f64>,
}

impl Default for PathLimits {
    fn default() -> Self {
        Self {
            speed_m_s: 0.25,
            acceleration_m_s2: 1.0,
            jerk_m_s3: 10.0,
            angular_speed_rad_s: 0.8,
            angular_acceleration_rad_s2: 3.0,
            workspace: None,
            clearance_m: 0.03,
            corridor_m: None,
        }
    }
}

impl PathLimits {
    /// The first limit that is no positive finite number, or a box that holds no point.
    pub fn fault(&self) -> Option<InputFault> {
        let named = [
            ("speed_m_s", self.speed_m_s),
            ("acceleration_m_s2", self.acceleration_m_s2),
            ("jerk_m_s3", self.jerk_m_s3),
            ("angular_speed_rad_s", self.angular_speed_rad_s),
            ("angular_acceleration_rad_s2", self.angular_acceleration_rad_s2),
        ];
        if let Some((name, value)) = named.iter().find(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            return Some(InputFault::Limit { name: (*name).into(), value: *value });
        }
        if !(self.clearance_m >= 0.0 && self.clearance_m.is_finite()) {
            return Some(InputFault::Clearance { value: self.clearance_m });
        }
        if let Some(value) = self.corridor_m.filter(|r| !(*r > 0.0 && r.is_finite())) {
            return Some(InputFault::Limit { name: "corridor_m".into(), value });
        }
        let inner = self.workspace?;
        // An open side (infinite) is fine, NaN is not.
        let is_box = (0..3).all(|i| inner.min[i] <= inner.max[i]);
        (!is_box).then_some(InputFault::Box)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_named() {
        assert_eq!(PathLimits::default().fault(), None);
        let broken = PathLimits { jerk_m_s3: f64::NAN, ..PathLimits::default() };
        assert!(broken.fault().unwrap().to_string().contains("jerk_m_s3"));
        let narrow = PathLimits { corridor_m: Some(0.0), ..PathLimits::default() };
        assert!(narrow.fault().unwrap().to_string().contains("corridor_m"));
        let near = PathLimits { clearance_m: -1.0, ..PathLimits::default() };
        assert_eq!(near.fault(), Some(InputFault::Clearance { value: -1.0 }));
        let mut inner = Box3 { min: Vec3::zeros(), max: Vec3::new(1.0, 1.0, -1.0) };
        let with = |b: Box3| PathLimits { workspace: Some(b), ..PathLimits::default() };
        assert_eq!(with(inner).fault(), Some(InputFault::Box));
        inner.max.z = f64::INFINITY;
        assert_eq!(with(inner).fault(), None);
        inner.max.z = f64::NAN;
        assert!(with(inner).fault().is_some());
    }

    #[test]
    fn faces_have_signed_distances_and_places() {
        let inner = Box3 { min: Vec3::zeros(), max: Vec3::new(0.8, 1.0, 2.0) };
        let point = Vec3::new(0.9, 0.5, 1.0);
        assert!((inner.excess(&point, 0, true) - 0.1).abs() < 1e-12);
        assert!((inner.excess(&point, 1, false) + 0.5).abs() < 1e-12);
        assert_eq!(inner.face(0, true), Face { axis: 0, is_upper: true, at_m: 0.8 });
        assert_eq!(inner.face(2, false), Face { axis: 2, is_upper: false, at_m: 0.0 });
        assert_eq!(Box3::faces().count(), 6);
    }
}

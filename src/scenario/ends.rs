//! Does a path of the user's begin and end where the scenario's movement does?
//!
//! A place that may be chosen (`[free]`) counts as a whole: the nearest of the equivalent places, the
//! box around it, and every turn about the vertical and about the held bar that is free.

use super::check::Scenario;
use super::freedom::Freedom;
use crate::math::{Pose, Vec3};
use crate::trajectory::TimedPath;
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fmt;

/// How far an end may be off and still be the same: what a robot's teaching by hand repeats.
pub const END_TOLERANCE_M: f64 = 0.005;
/// The same for its orientation, deg.
pub const END_TOLERANCE_DEG: f64 = 2.0;

/// Turns about the vertical that are tried before the best is refined.
const YAWS: usize = 181;
const REFINEMENTS: usize = 40;

/// How far a path's ends are from start and goal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EndMismatch {
    /// First position from the start, m.
    pub start_m: f64,
    /// First orientation from the start's, deg.
    pub start_deg: f64,
    /// Last position from the goal, m.
    pub goal_m: f64,
    /// Last orientation from the goal's, deg.
    pub goal_deg: f64,
}

impl fmt::Display for EndMismatch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let end = |m: f64, deg: f64, begins: &str, place: &str| {
            (m > END_TOLERANCE_M || deg > END_TOLERANCE_DEG)
                .then(|| format!("{begins} {:.0} mm and {deg:.1} deg from the {place}", 1e3 * m))
        };
        let ends = [
            end(self.start_m, self.start_deg, "begins", "start"),
            end(self.goal_m, self.goal_deg, "ends", "goal"),
        ];
        f.write_str(&ends.into_iter().flatten().collect::<Vec<_>>().join(" and "))
    }
}

/// The free numbers of one end.
struct Region<'a> {
    places: &'a [Pose],
    half_m: Vec3,
    yaw: [f64; 2],
    roll: [f64; 2],
}

impl Scenario {
    /// How far a path is from beginning at the start and ending at the goal; none where it does,
    /// within [`END_TOLERANCE_M`] and [`END_TOLERANCE_DEG`].
    pub fn end_mismatch(&self, path: &TimedPath) -> Option<EndMismatch> {
        let [first, last] = [path.poses.first()?, path.poses.last()?];
        let range = |f: Freedom| self.free.range(f).unwrap_or_default();
        let half = |of: fn(usize) -> Freedom| Vec3::from_fn(|i, _| range(of(i))[1]);
        let start = Region {
            places: &self.free.starts,
            half_m: half(Freedom::StartOffset),
            yaw: range(Freedom::StartYaw),
            roll: range(Freedom::StartRoll),
        };
        let goal = Region {
            places: &self.free.goals,
            half_m: half(Freedom::GoalOffset),
            yaw: range(Freedom::GoalYaw),
            roll: range(Freedom::GoalRoll),
        };
        let (start_m, start_deg) = start.off(first, &self.grip);
        let (goal_m, goal_deg) = goal.off(last, &self.grip);
        let is_off =
            start_m.max(goal_m) > END_TOLERANCE_M || start_deg.max(goal_deg) > END_TOLERANCE_DEG;
        is_off.then_some(EndMismatch { start_m, start_deg, goal_m, goal_deg })
    }
}

impl Region<'_> {
    /// Distance (m) and angle (deg) of a pose from the nearest of the places.
    fn off(&self, pose: &Pose, grip: &Pose) -> (f64, f64) {
        let of = |place: &Pose| {
            let apart = pose.translation.vector - place.translation.vector;
            let outside = apart.abs() - self.half_m;
            (outside.map(|x| x.max(0.0)).norm(), self.angle(place, pose, grip).to_degrees())
        };
        // How badly an end fits, in tolerances.
        let size = |(m, deg): &(f64, f64)| (m / END_TOLERANCE_M).max(deg / END_TOLERANCE_DEG);
        let all = self.places.iter().map(of);
        all.min_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or_default()
    }

    /// Least angle (rad) to `pose` of the place's orientation under all free turns.
    fn angle(&self, place: &Pose, pose: &Pose, grip: &Pose) -> f64 {
        let at = |yaw: f64| {
            let turned = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), yaw) * place.rotation;
            // What is left to turn, in the axes of the grip: its z is the held bar.
            let left = (turned * grip.rotation).inverse() * pose.rotation * grip.rotation;
            let roll = nearest(2.0 * left.k.atan2(left.w), self.roll);
            UnitQuaternion::from_axis_angle(&Vec3::z_axis(), roll).angle_to(&left)
        };
        let [low, high] = self.yaw;
        if high <= low {
            return at(low);
        }
        let step = (high - low) / (YAWS - 1) as f64;
        let tried = (0..YAWS).map(|i| low + step * i as f64);
        let best = tried.min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(low);
        let (mut a, mut b) = ((best - step).max(low), (best + step).min(high));
        for _ in 0..REFINEMENTS {
            let (left, right) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
            if at(left) < at(right) { b = right } else { a = left }
        }
        at(f64::midpoint(a, b)).min(at(best))
    }
}

/// The angle of a range that is nearest to another, turns of 2 pi aside.
fn nearest(angle: f64, [low, high]: [f64; 2]) -> f64 {
    let turned = angle - 2.0 * PI * ((angle - f64::midpoint(low, high)) / (2.0 * PI)).round();
    turned.clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn pose(x: f64, yaw: f64) -> Pose {
        Pose::from_parts(
            Vec3::new(x, 0.0, 1.0).into(),
            UnitQuaternion::from_euler_angles(PI, 0.0, yaw),
        )
    }

    #[test]
    fn free_regions_count_as_a_whole() {
        let grip = Pose::from_parts(
            Vec3::zeros().into(),
            UnitQuaternion::from_euler_angles(PI / 2.0, 0.3, 0.0),
        );
        let places = [pose(0.0, 0.0), pose(0.5, 1.0)];
        let fixed =
            Region { places: &places, half_m: Vec3::zeros(), yaw: [0.0; 2], roll: [0.0; 2] };
        let (m, deg) = fixed.off(&pose(0.51, 1.1), &grip);
        assert_relative_eq!(m, 0.01, epsilon = 1e-12);
        assert_relative_eq!(deg, 0.1f64.to_degrees(), epsilon = 1e-6);
        let wide = Region {
            places: &places,
            half_m: Vec3::new(0.02, 0.0, 0.0),
            yaw: [-0.5, 0.5],
            roll: [-1.0, 1.0],
        };
        let (m, deg) = wide.off(&pose(0.515, 1.37), &grip);
        assert!(m == 0.0 && deg < 1e-3, "{m} {deg}");
        // A turn about the bar and one about the vertical together.
        let about_bar = Pose::from_parts(
            Vec3::zeros().into(),
            UnitQuaternion::from_axis_angle(&Vec3::z_axis(), 0.7),
        );
        let rolled = pose(0.5, 1.2) * grip * about_bar * grip.inverse();
        let (_, deg) = wide.off(&rolled, &grip);
        assert!(deg < 1e-3, "{deg}");
        let (_, deg) = wide.off(&pose(0.5, 2.0), &grip);
        assert!(deg > 5.0, "{deg}");
    }
}

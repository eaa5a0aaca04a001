//! The robot's motion as ROS controllers take it: `trajectory_msgs/JointTrajectory`.
//!
//! Velocities and accelerations come from the cubic spline through the postures that starts and ends
//! at rest. Controllers join positions, velocities and accelerations of neighbouring points by quintic
//! polynomials; [`JointTrajectory::check`] looks at those, ten times as finely as the points.

mod message;

use super::Robot;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Looks between two points.
const FINER: usize = 10;
/// Names in this struct are those of the ROS message.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointTrajectory {
    /// Stamp and frame; a controller starts a trajectory of stamp 0 at once.
    #[serde(default)]
    pub header: Header,
    /// Joints in the order of the values.
    pub joint_names: Vec<String>,
    /// The postures in time.
    pub points: Vec<Point>,
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Time of the start.
    #[serde(default)]
    pub stamp: Duration,
    /// Unused for joints.
    #[serde(default)]
    pub frame_id: String,
}

/// `builtin_interfaces/Time` and `Duration`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds (ROS 1 calls them `secs`).
    #[serde(alias = "secs")]
    pub sec: i64,
    /// And nanoseconds.
    #[serde(alias = "nsecs")]
    pub nanosec: u32,
}

/// `trajectory_msgs/JointTrajectoryPoint`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// rad, or m for sliding joints.
    pub positions: Vec<f64>,
    /// rad/s or m/s.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// rad/s^2 or m/s^2.
    #[serde(default)]
    pub accelerations: Vec<f64>,
    /// N m or N; none are given.
    #[serde(default)]
    pub effort: Vec<f64>,
    /// Since the start.
    pub time_from_start: Duration,
}

/// Why a text is no trajectory for a robot.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct TrajectoryFault(String);

/// How near a trajectory comes to one joint's limits between its points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointMargin {
    /// The joint.
    pub joint: String,
    /// Smallest distance to the limits of position, rad or m; none without limits.
    pub position_margin: Option<f64>,
    /// Largest speed over its limit.
    pub velocity_share: Option<f64>,
    /// Largest acceleration over its limit.
    pub acceleration_share: Option<f64>,
}

impl JointMargin {
    /// Whether every limit is kept, to rounding.
    pub fn is_kept(&self) -> bool {
        let share = |s: Option<f64>| s.is_none_or(|s| s <= 1.0 + 1e-9);
        self.position_margin.is_none_or(|m| m >= -1e-9)
            && share(self.velocity_share)
            && share(self.acceleration_share)
    }
}

impl Duration {
    fn of_seconds(seconds: f64) -> Self {
        let nanoseconds = (seconds * 1e9).round() as i64;
        let sec = nanoseconds.div_euclid(1_000_000_000);
        Self { sec, nanosec: nanoseconds.rem_euclid(1_000_000_000) as u32 }
    }

    /// In seconds.
    pub fn seconds(self) -> f64 {
        self.sec as f64 + 1e-9 * f64::from(self.nanosec)
    }
}

impl JointTrajectory {
    /// Through K postures `q` (n values each) at K rising times (s), at rest at both ends. Times count
    /// from the first.
    pub fn through(joint_names: Vec<String>, time_s: &[f64], q: &[Vec<f64>]) -> Self {
        let n = joint_names.len();
        let columns: Vec<Vec<f64>> = (0..n).map(|j| q.iter().map(|row| row[j]).collect()).collect();
        let slopes: Vec<Vec<f64>> = columns.iter().map(|c| slopes(time_s, c)).collect();
        let bends: Vec<Vec<f64>> =
            columns.iter().zip(&slopes).map(|(c, v)| bends(time_s, c, v)).collect();
        let at = |all: &[Vec<f64>], k: usize| all.iter().map(|c| c[k]).collect();
        let points = (0..q.len())
            .map(|k| Point {
                positions: q[k].clone(),
                velocities: at(&slopes, k),
                accelerations: at(&bends, k),
                effort: Vec::new(),
                time_from_start: Duration::of_seconds(time_s[k] - time_s[0]),
            })
            .collect();
        Self { header: Header::default(), joint_names, points }
    }

    /// Times (s) and postures in the order of a robot's joints.
    ///
    /// # Errors
    /// Where a joint is missing, a point has another number of values, or a number is not finite.
    pub fn postures(&self, robot: &Robot) -> Result<(Vec<f64>, Vec<Vec<f64>>), TrajectoryFault> {
        let fault = |message: String| Err(TrajectoryFault(message));
        let mut order = Vec::new();
        for joint in robot.joint_names() {
            match self.joint_names.iter().position(|n| n == joint) {
                Some(i) => order.push(i),
                None => {
                    return fault(format!(
                        "joint `{joint}` of the robot is missing; the trajectory has {}",
                        self.joint_names.join(", ")
                    ));
                }
            }
        }
        let mut rows = Vec::with_capacity(self.points.len());
        for (k, point) in self.points.iter().enumerate() {
            let (have, want) = (point.positions.len(), self.joint_names.len());
            if have != want {
                return fault(format!("point {} has {have} positions for {want} joints", k + 1));
            }
            let kinds = [
                ("position", &point.positions),
                ("velocity", &point.velocities),
                ("acceleration", &point.accelerations),
            ];
            for (what, values) in kinds {
                if !values.is_empty() && values.len() != want {
                    let have = values.len();
                    return fault(format!(
                        "point {}: {have} values of {what} for {want} joints",
                        k + 1
                    ));
                }
                if let Some(j) = values.iter().position(|v| !v.is_finite()) {
                    let (joint, value) = (&self.joint_names[j], values[j]);
                    return fault(format!(
                        "point {}, joint `{joint}`: the {what} is {value}, not a finite number",
                        k + 1
                    ));
                }
            }
            rows.push(order.iter().map(|&i| point.positions[i]).collect());
        }
        let times = self.points.iter().map(|p| p.time_from_start.seconds()).collect();
        Ok((times, rows))
    }

    /// Margins of every joint of the quintic polynomials between the points, ten looks in each.
    pub fn check(&self, robot: &Robot) -> Vec<JointMargin> {
        let limits = &robot.limits;
        let names = robot.joint_names();
        names
            .enumerate()
            .filter_map(|(i, joint)| {
                let column = self.joint_names.iter().position(|n| n == joint)?;
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                let (mut speed, mut acceleration) = (0.0f64, 0.0f64);
                for pair in self.points.windows(2) {
                    for look in 0..=FINER {
                        let [q, v, a] =
                            quintic(&pair[0], &pair[1], column, look as f64 / FINER as f64)?;
                        (low, high) = (low.min(q), high.max(q));
                        let most = limits.velocity_at(i, q, v);
                        let share = if v == 0.0 { 0.0 } else { v.abs() / most };
                        speed = speed.max(share);
                        acceleration = acceleration.max(a.abs());
                    }
                }
                let margin = (low - limits.lower[i]).min(limits.upper[i] - high);
                let share = |value: f64, limit: f64| {
                    (limit.is_finite() && limit > 0.0).then_some(value / limit)
                };
                Some(JointMargin {
                    joint: joint.to_owned(),
                    position_margin: margin.is_finite().then_some(margin),
                    velocity_share: (limits.velocity[i].is_finite()).then_some(speed),
                    acceleration_share: share(acceleration, limits.acceleration[i]),
                })
            })
            .collect()
    }
}

/// Position, speed and acceleration of the quintic between two points, at a share of the way.
pub(super) fn quintic(a: &Point, b: &Point, joint: usize, share: f64) -> Option<[f64; 3]> {
    let h = b.time_from_start.seconds() - a.time_from_start.seconds();
    let state = |p: &Point| {
        Some([
            *p.positions.get(joint)?,
            h * p.velocities.get(joint)?,
            h * h * p.accelerations.get(joint)?,
        ])
    };
    let ([q0, v0, a0], [q1, v1, a1]) = (state(a)?, state(b)?);
    let d = q1 - q0;
    let c = [
        q0,
        v0,
        a0 / 2.0,
        10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
        -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
        6.0 * d - 3.0 * (v0 + v1) - 0.5 * (a0 - a1),
    ];
    let (mut q, mut v, mut acc) = (0.0, 0.0, 0.0);
    for c in c.iter().rev() {
        acc = acc * share + 2.0 * v;
        v = v * share + q;
        q = q * share + c;
    }
    Some([q, v / h, acc / (h * h)])
}

/// Slopes of the cubic spline through values at times, at rest at both ends.
fn slopes(t: &[f64], x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut slope = vec![0.0; n];
    if n < 3 {
        return slope;
    }
    // Equal bending on both sides of each inner knot; eliminated forwards, then backwards.
    let mut upper = vec![0.0; n];
    for k in 1..n - 1 {
        let (h0, h1) = (t[k] - t[k - 1], t[k + 1] - t[k]);
        let right = 3.0 * ((x[k + 1] - x[k]) * h0 / h1 + (x[k] - x[k - 1]) * h1 / h0);
        let pivot = 2.0 * (h0 + h1) - h1 * upper[k - 1];
        upper[k] = h0 / pivot;
        slope[k] = (right - h1 * slope[k - 1]) / pivot;
    }
    for k in (1..n - 1).rev() {
        slope[k] -= upper[k] * slope[k + 1];
    }
    slope
}

/// Second derivatives of that spline at the knots; zero at both ends, where the robot rests.
fn bends(t: &[f64], x: &[f64], slope: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut bend = vec![0.0; n];
    for k in 1..n.saturating_sub(1) {
        let h = t[k + 1] - t[k];
        bend[k] = (6.0 * (x[k + 1] - x[k]) / h - 4.0 * slope[k] - 2.0 * slope[k + 1]) / h;
    }
    bend
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Minimum jerk from 0 to 1 in 2 s: position, speed, acceleration.
    fn smooth(t: f64) -> [f64; 3] {
        let s = t / 2.0;
        [
            s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
            30.0 * s * s * (1.0 - s) * (1.0 - s) / 2.0,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / 4.0,
        ]
    }

    fn sampled(count: usize) -> JointTrajectory {
        let times: Vec<f64> = (0..=count).map(|k| 2.0 * k as f64 / count as f64).collect();
        let q: Vec<Vec<f64>> = times.iter().map(|t| vec![smooth(*t)[0]]).collect();
        JointTrajectory::through(vec!["a".to_owned()], &times, &q)
    }

    #[test]
    fn derivatives_are_those_of_the_motion() {
        let made = sampled(100);
        for p in &made.points {
            let [_, v, a] = smooth(p.time_from_start.seconds());
            assert_relative_eq!(p.velocities[0], v, epsilon = 1e-4);
            assert_relative_eq!(p.accelerations[0], a, epsilon = 2e-2);
        }
        let (first, last) = (&made.points[0], &made.points[100]);
        for end in [first, last] {
            assert_eq!((end.velocities[0], end.accelerations[0]), (0.0, 0.0));
        }
    }

    #[test]
    fn the_quintic_meets_its_ends_and_finite_differences() {
        let made = sampled(10);
        let (a, b) = (&made.points[3], &made.points[4]);
        for (end, share) in [(a, 0.0), (b, 1.0)] {
            let [q, v, acc] = quintic(a, b, 0, share).unwrap();
            assert_relative_eq!(q, end.positions[0], epsilon = 1e-12);
            assert_relative_eq!(v, end.velocities[0], epsilon = 1e-12);
            assert_relative_eq!(acc, end.accelerations[0], epsilon = 1e-10);
        }
        let at = |s: f64| quintic(a, b, 0, s).unwrap();
        let (h, d) = (0.2, 1e-5);
        let [before, middle, after] = [at(0.4 - d), at(0.4), at(0.4 + d)];
        assert_relative_eq!(middle[1], (after[0] - before[0]) / (2.0 * d * h), epsilon = 1e-8);
        assert_relative_eq!(middle[2], (after[1] - before[1]) / (2.0 * d * h), epsilon = 1e-7);
    }

    #[test]
    fn the_check_sees_what_lies_between_the_points() {
        let robot = Robot::preset("panda").unwrap();
        let names: Vec<String> = robot.joint_names().map(str::to_owned).collect();
        let still: Vec<f64> = (0..names.len())
            .map(|i| 0.5 * (robot.limits.lower[i] + robot.limits.upper[i]))
            .collect();
        let moved: Vec<f64> = still.iter().map(|q| q + 0.2).collect();
        let slow = JointTrajectory::through(
            names.clone(),
            &[0.0, 1.0, 2.0],
            &[still.clone(), moved.clone(), moved.clone()],
        );
        assert!(slow.check(&robot).iter().all(JointMargin::is_kept));
        let fast = JointTrajectory::through(
            names,
            &[0.0, 0.02, 0.04],
            &[still.clone(), moved.clone(), moved],
        );
        let check = fast.check(&robot);
        assert!(check.iter().all(|m| !m.is_kept() && m.velocity_share.unwrap() > 1.0));
    }

    #[test]
    fn both_texts_read_back_and_joints_may_come_in_any_order() {
        let robot = Robot::preset("panda").unwrap();
        let mut names: Vec<String> = robot.joint_names().map(str::to_owned).collect();
        names.reverse();
        let q: Vec<Vec<f64>> = (0..3)
            .map(|k| (0..names.len()).map(|j| j as f64 + 0.1 * f64::from(k)).collect())
            .collect();
        let made = JointTrajectory::through(names, &[0.0, 0.1, 0.25], &q);
        let json = serde_json::to_string(&made).unwrap();
        assert_eq!(serde_json::from_str::<JointTrajectory>(&json).unwrap(), made);
        let yaml = serde_saphyr::to_string(&made).unwrap();
        assert_eq!(serde_saphyr::from_str::<JointTrajectory>(&yaml).unwrap(), made);
        let (times, rows) = made.postures(&robot).unwrap();
        assert_eq!(times, [0.0, 0.1, 0.25]);
        assert_eq!(rows[1][0], q[1][q[1].len() - 1]);
        // As `ros2 topic echo` and MoveIt write it.
        for text in [
            format!("{yaml}---\n"),
            format!("---\n{yaml}"),
            format!("{{\"joint_trajectory\": {json}, \"multi_dof_joint_trajectory\": {{}}}}"),
            format!("{{\"trajectory\": [{{\"joint_trajectory\": {json}}}]}}"),
            format!("{{\"goal\": {{\"trajectory\": {json}}}}}"),
        ] {
            let is_json = text.starts_with('{');
            assert_eq!(JointTrajectory::from_text(&text, is_json).unwrap(), made, "{text}");
        }
        let refused = |text: &str, is_json| {
            JointTrajectory::from_text(text, is_json).unwrap_err().to_string()
        };
        assert!(refused(&format!("{yaml}---\n{yaml}---\n"), false).contains("holds 2 messages"));
        let two = format!("{{\"trajectory\": [{{\"joint_trajectory\": {json}}}, {{}}]}}");
        assert!(refused(&two, true).contains("of 2 parts"));
        assert!(refused("a: 1\n", false).contains("no `joint_names` with `points`"));
        assert!(refused("---\n", false).contains("empty"));
        let mut short = made.clone();
        short.joint_names[0] = "other".to_owned();
        assert!(short.postures(&robot).unwrap_err().to_string().contains("is missing"));
    }

    #[test]
    fn a_value_that_is_no_number_is_named() {
        let robot = Robot::preset("panda").unwrap();
        let names: Vec<String> = robot.joint_names().map(str::to_owned).collect();
        let still = vec![vec![0.1; names.len()]; 3];
        let mut broken = JointTrajectory::through(names, &[0.0, 1.0, 2.0], &still);
        broken.points[1].velocities[2] = f64::NAN;
        let words = broken.postures(&robot).unwrap_err().to_string();
        assert!(words.contains("point 2, joint `panda_joint3`: the velocity is NaN"), "{words}");
    }
}

//! Does a joint path keep the limits, and by how much?
//!
//! ```text
//! velocity between knots k, k+1:   v_k = (q_{k+1} - q_k) / h_k            (central at mid-way)
//! acceleration at knot k:          a_k = (v_k - v_{k-1}) / ((h_k + h_{k-1}) / 2)   (central)
//! ```
//! A mean speed above the limit proves that the limit is broken: the joint had that speed somewhere
//! in the interval.

use super::body::{Nearest, min_singular_value};
use super::collide::SelfNearest;
use super::description::Robot;
use crate::files::null_as_nan;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Share of a limit by which rounding may exceed it.
const ROUNDING: f64 = 1e-9;

/// Where along a path a joint is at its worst.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Extreme {
    /// Name of the joint.
    pub joint: String,
    /// When, s.
    pub time_s: f64,
    /// Share of a limit (1 is at the limit), or the distance to a limit (rad or m).
    #[serde(deserialize_with = "null_as_nan")]
    pub value: f64,
}

/// A joint path and how near it comes to the robot's limits.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotMotion {
    /// Postures, K of n values, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Largest speed as a share of its limit.
    pub qd_share: Extreme,
    /// Largest acceleration as a share of its limit. The ends count as they are: a motion that
    /// should start and end at rest must say so in its knots.
    pub qdd_share: Extreme,
    /// Smallest distance to a position limit, rad or m; negative outside. Infinite when no joint
    /// has limits.
    pub position_margin: Extreme,
    /// Smallest singular value of the TCP Jacobian, angular rows scaled by 0.3 m; m/rad.
    pub min_singular_value: f64,
    /// When the arm is nearest to a singular posture, s.
    pub min_singular_time_s: f64,
    /// Largest distance from the wanted TCP positions, m; 0 for a given joint path.
    pub max_residual_m: f64,
    /// Largest angle from the wanted TCP orientations, rad; 0 for a given joint path.
    pub max_residual_rad: f64,
    /// How hard the motion is for the arm: the largest of the speed's share of its limit and the
    /// position's share of its half range (0 in the middle, 1 at a limit), over joints and time.
    pub strain: f64,
    /// What it lacks of the wanted distance from singular postures, obstacles and the arm itself; 0 is
    /// enough of all. Set by following, as the two below.
    pub lacking: f64,
    /// Where the arm is nearest to itself; none when nothing is checked.
    pub self_nearest: Option<Box<SelfNearest>>,
    /// Where it is nearest to an obstacle; none without obstacles.
    pub obstacle_nearest: Option<Box<Nearest>>,
}

/// Which limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitKind {
    /// Range of positions.
    Position,
    /// Speed.
    Velocity,
    /// Acceleration.
    Acceleration,
}

/// A broken limit: the worst of one joint and kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// Which limit.
    pub kind: LimitKind,
    /// Name of the joint.
    pub joint: String,
    /// True for a joint that slides.
    pub is_prismatic: bool,
    /// When it is worst, s.
    pub time_s: f64,
    /// The value there: rad, rad/s or rad/s^2 (m for sliding joints).
    pub value: f64,
    /// The limit, in the same unit.
    pub limit: f64,
    /// True when the limit is a stand-in.
    pub is_assumed: bool,
}

/// Why poses or postures over time are no path.
#[derive(Debug, Clone, PartialEq, Error, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum PathError {
    /// No knots, or not as many times.
    #[error("the path has {knots} knots and {times} times")]
    Count {
        /// Poses or postures.
        knots: usize,
        /// Times.
        times: usize,
    },
    /// A time is no finite number.
    #[error("time number {number} is not finite")]
    Time {
        /// From 1.
        number: usize,
    },
    /// Times that do not rise.
    #[error("the times do not rise after t = {time_s:.2} s")]
    NotRising {
        /// The last one that is in order, s.
        time_s: f64,
    },
    /// A posture for another arm.
    #[error("posture at t = {time_s:.2} s has {values} values, not {joints}")]
    Values {
        /// When, s.
        time_s: f64,
        /// Numbers in the posture.
        values: usize,
        /// Joints of the arm.
        joints: usize,
    },
    /// A posture that holds a number that is not finite.
    #[error("the posture at t = {time_s:.2} s is not finite")]
    Posture {
        /// When, s.
        time_s: f64,
    },
    /// A pose that holds a number that is not finite.
    #[error("the TCP pose at t = {time_s:.2} s is not finite")]
    Pose {
        /// When, s.
        time_s: f64,
    },
}

impl PathError {
    /// When, s; 0 if it is not about one moment.
    pub fn time_s(&self) -> f64 {
        match self {
            Self::Count { .. } | Self::Time { .. } => 0.0,
            Self::NotRising { time_s }
            | Self::Values { time_s, .. }
            | Self::Posture { time_s }
            | Self::Pose { time_s } => *time_s,
        }
    }
}

/// What [`check_joint_path`] finds.
#[derive(Debug, Clone, PartialEq)]
pub struct PathCheck {
    /// The path and its margins.
    pub motion: RobotMotion,
    /// Broken limits: positions first, then by share of the limit, worst first. Empty when the
    /// robot can follow.
    pub violations: Vec<Violation>,
}

/// Checks a joint path, K postures of n values (rad or m) at K times (s), against all limits.
///
/// Refused: no knots, times that are not finite or do not rise, postures of another length, values
/// that are not finite.
pub fn check_joint_path(
    robot: &Robot,
    time_s: &[f64],
    q: &[Vec<f64>],
) -> Result<PathCheck, PathError> {
    check_times(time_s, q.len())?;
    for (posture, &time_s) in q.iter().zip(time_s) {
        if posture.len() != robot.dof() {
            let (values, joints) = (posture.len(), robot.dof());
            return Err(PathError::Values { time_s, values, joints });
        }
        if !posture.iter().all(|v| v.is_finite()) {
            return Err(PathError::Posture { time_s });
        }
    }
    Ok(assess(robot, time_s, q.to_vec()))
}

/// Why these are no `count` times.
pub(super) fn check_times(time_s: &[f64], count: usize) -> Result<(), PathError> {
    if count == 0 || time_s.len() != count {
        return Err(PathError::Count { knots: count, times: time_s.len() });
    }
    if let Some(k) = time_s.iter().position(|t| !t.is_finite()) {
        return Err(PathError::Time { number: k + 1 });
    }
    match time_s.windows(2).find(|w| w[1] <= w[0]) {
        Some(w) => Err(PathError::NotRising { time_s: w[0] }),
        None => Ok(()),
    }
}

/// The worst of each kind so far, and every joint's worst.
struct Tally<'r> {
    robot: &'r Robot,
    kind: LimitKind,
    /// Per joint: share of the limit, time, value, limit.
    worst: Vec<(f64, f64, f64, f64)>,
}

impl<'r> Tally<'r> {
    fn new(robot: &'r Robot, kind: LimitKind) -> Self {
        let worst = vec![(f64::NEG_INFINITY, 0.0, 0.0, f64::INFINITY); robot.dof()];
        Self { robot, kind, worst }
    }

    fn note(&mut self, joint: usize, share: f64, time: f64, value: f64, limit: f64) {
        if share > self.worst[joint].0 {
            self.worst[joint] = (share, time, value, limit);
        }
    }

    /// The joint with the largest share.
    fn extreme(&self) -> (usize, f64, f64) {
        let mut best = (0, f64::NEG_INFINITY, 0.0);
        for (i, &(share, time, ..)) in self.worst.iter().enumerate() {
            if share > best.1 {
                best = (i, share, time);
            }
        }
        best
    }

    fn name(&self, joint: usize) -> String {
        self.robot.linkage.joints()[joint].name.clone()
    }

    fn violations(&self) -> impl Iterator<Item = (f64, Violation)> + '_ {
        let allowed = match self.kind {
            // Here the share is minus the distance to the limit, rad or m.
            LimitKind::Position => ROUNDING,
            _ => 1.0 + ROUNDING,
        };
        let limits = &self.robot.limits;
        let broken = self.worst.iter().enumerate().filter(move |(_, w)| w.0 > allowed);
        broken.map(move |(i, &(share, time_s, value, limit))| {
            let is_assumed = match self.kind {
                LimitKind::Position => false,
                LimitKind::Velocity => limits.velocity_assumed[i],
                LimitKind::Acceleration => limits.acceleration_assumed[i],
            };
            let is_prismatic = self.robot.linkage.joints()[i].is_prismatic;
            let (kind, joint) = (self.kind, self.name(i));
            (share, Violation { kind, joint, is_prismatic, time_s, value, limit, is_assumed })
        })
    }
}

/// Margins and broken limits of a joint path whose form has been checked.
pub(super) fn assess(robot: &Robot, time_s: &[f64], q: Vec<Vec<f64>>) -> PathCheck {
    let limits = &robot.limits;
    let mut position = Tally::new(robot, LimitKind::Position);
    let mut speed = Tally::new(robot, LimitKind::Velocity);
    let mut acceleration = Tally::new(robot, LimitKind::Acceleration);
    let mut strain = 0.0f64;
    let mut singular = (f64::INFINITY, 0.0);
    for (k, (posture, &t)) in q.iter().zip(time_s).enumerate() {
        let sigma = min_singular_value(robot, posture);
        if sigma < singular.0 {
            singular = (sigma, t);
        }
        for (i, &at) in posture.iter().enumerate() {
            let (low, high) = (limits.lower[i], limits.upper[i]);
            let (beyond, limit) =
                if low - at > at - high { (low - at, low) } else { (at - high, high) };
            position.note(i, beyond, t, at, limit);
            if let Some(middle) = limits.middle(i) {
                strain = strain.max((at - middle).abs() / (0.5 * (high - low)).max(1e-9));
            }
            let Some(next) = q.get(k + 1).map(|p| p[i]) else { continue };
            let h = time_s[k + 1] - t;
            let v = (next - at) / h;
            let most = limits.velocity_at(i, 0.5 * (at + next), v);
            speed.note(i, v.abs() / most, t + 0.5 * h, v.abs(), most);
            if k > 0 {
                let h0 = t - time_s[k - 1];
                let a = ((v - (at - q[k - 1][i]) / h0) / (0.5 * (h + h0))).abs();
                acceleration.note(i, a / limits.acceleration[i], t, a, limits.acceleration[i]);
            }
        }
    }
    let share = |tally: &Tally| {
        let (i, value, time) = tally.extreme();
        // A path of one knot has no speed; of two, no acceleration.
        let time_s = if value.is_finite() { time } else { time_s[0] };
        Extreme { joint: tally.name(i), time_s, value: value.max(0.0) }
    };
    let (i, beyond, time) = position.extreme();
    let position_margin = Extreme { joint: position.name(i), time_s: time, value: -beyond };
    let (qd_share, qdd_share) = (share(&speed), share(&acceleration));
    let mut violations: Vec<(f64, Violation)> =
        [&position, &speed, &acceleration].into_iter().flat_map(Tally::violations).collect();
    let is_later = |v: &Violation| v.kind != LimitKind::Position;
    violations.sort_by(|a, b| is_later(&a.1).cmp(&is_later(&b.1)).then(b.0.total_cmp(&a.0)));
    let motion = RobotMotion {
        strain: strain.max(qd_share.value),
        qd_share,
        qdd_share,
        position_margin,
        min_singular_value: singular.0,
        min_singular_time_s: singular.1,
        max_residual_m: 0.0,
        max_residual_rad: 0.0,
        lacking: 0.0,
        self_nearest: None,
        obstacle_nearest: None,
        q,
    };
    PathCheck { motion, violations: violations.into_iter().map(|(_, v)| v).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_users_program_is_marked_not_mended() {
        let robot = Robot::preset("panda").unwrap();
        let time: Vec<f64> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        let path = |rate: f64| -> Vec<Vec<f64>> {
            let at = |t: &f64| {
                let mut q = robot.home.clone();
                q[1] += rate * t;
                q
            };
            time.iter().map(at).collect()
        };
        let good = check_joint_path(&robot, &time, &path(0.5)).unwrap();
        assert!(good.violations.is_empty(), "{:?}", good.violations);
        assert_eq!(good.motion.qd_share.joint, "panda_joint2");
        assert!((good.motion.qd_share.value - 0.5 / 2.175).abs() < 1e-9);
        assert!(good.motion.qdd_share.value < 1e-9);

        let bad = check_joint_path(&robot, &time, &path(4.0)).unwrap();
        let [range, speed] = &bad.violations[..] else { panic!("{:?}", bad.violations) };
        assert_eq!((range.kind, range.joint.as_str()), (LimitKind::Position, "panda_joint2"));
        assert!((range.value - (robot.home[1] + 4.0)).abs() < 1e-9);
        assert!((range.limit - 1.7628).abs() < 1e-9, "{range:?}");
        assert_eq!((speed.kind, speed.joint.as_str()), (LimitKind::Velocity, "panda_joint2"));
        assert!((speed.value - 4.0).abs() < 1e-9 && (speed.limit - 2.175).abs() < 1e-9);
        assert!(bad.motion.position_margin.value < -1.0);
    }

    #[test]
    fn acceleration_is_the_second_derivative_on_uneven_grids() {
        let robot = Robot::preset("ur5e").unwrap();
        let time = [0.0, 0.1, 0.15, 0.3, 0.32];
        let at = |t: &f64| {
            let mut q = robot.home.clone();
            q[5] += 0.5 * 6.0 * t * t;
            q
        };
        let q: Vec<Vec<f64>> = time.iter().map(at).collect();
        let check = check_joint_path(&robot, &time, &q).unwrap();
        assert_eq!(check.violations.len(), 1);
        let v = &check.violations[0];
        assert!((v.value - 6.0).abs() < 1e-9 && v.kind == LimitKind::Acceleration, "{v:?}");
        assert!(v.is_assumed);
    }

    #[test]
    fn malformed_paths_are_refused() {
        let robot = Robot::preset("ur5e").unwrap();
        let home = robot.home.clone();
        let refusal = |time: &[f64], q: &[Vec<f64>]| check_joint_path(&robot, time, q).unwrap_err();
        let time_s = 0.0;
        assert_eq!(refusal(&[], &[]), PathError::Count { knots: 0, times: 0 });
        let twice = [home.clone(), home.clone()];
        assert_eq!(refusal(&[0.0, 0.0], &twice), PathError::NotRising { time_s });
        let short = PathError::Values { time_s, values: 5, joints: 6 };
        assert_eq!(refusal(&[0.0], &[vec![0.0; 5]]), short);
        assert_eq!(refusal(&[0.0], &[vec![f64::NAN; 6]]), PathError::Posture { time_s });
        let timeless = refusal(&[f64::NAN], std::slice::from_ref(&home));
        assert_eq!(timeless, PathError::Time { number: 1 });
        let one = check_joint_path(&robot, &[0.0], &[home]).unwrap();
        assert!(one.violations.is_empty() && one.motion.qd_share.value.abs() < 1e-12);
    }
}

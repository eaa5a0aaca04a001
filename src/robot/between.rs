//! A joint path between its knots: what a controller that interpolates smoothly would do.
//!
//! The knots are joined by the clamped cubic spline, at rest at both ends. Its acceleration is linear
//! between knots; position and speed are evaluated on a finer grid, and the TCP by forward kinematics,
//! not by the code that found the knots.

use super::body::tcp_pose;
use super::check::Extreme;
use super::description::Robot;
use crate::math::Pose;
use crate::math::pose::rotation_between;

/// The worst of a joint path between its knots.
#[derive(Debug, Clone, PartialEq)]
pub struct Between {
    /// Largest joint speed as a share of its limit.
    pub speed: Extreme,
    /// Largest joint acceleration as a share of its limit.
    pub acceleration: Extreme,
    /// Farthest a joint is beyond its range, rad or m; negative inside.
    pub range: Extreme,
    /// Largest distance of the TCP from the path, m, and when, s.
    pub distance_m: (f64, f64),
    /// Largest angle between the TCP and the path, rad, and when, s.
    pub angle_rad: (f64, f64),
}

/// Measures a joint path (K knots of n values at K rising times, s) on a grid `finer` times as fine as
/// its knots, against the robot's limits and the wanted pose of the TCP (world) at a time. `None` for
/// fewer than two knots, or numbers that do not fit.
pub fn between(
    robot: &Robot,
    time_s: &[f64],
    q: &[Vec<f64>],
    finer: usize,
    wanted: impl Fn(f64) -> Pose,
) -> Option<Between> {
    let is_sound = q.len() == time_s.len() && q.len() >= 2;
    if !is_sound || !q.iter().all(|posture| posture.len() == robot.dof()) {
        return None;
    }
    let names: Vec<&str> = robot.joint_names().collect();
    let rates: Vec<Vec<f64>> = (0..robot.dof()).map(|i| knot_rates(time_s, q, i)).collect();
    let nothing = || Extreme { joint: String::new(), time_s: 0.0, value: f64::NEG_INFINITY };
    let (mut speed, mut acceleration, mut range) = (nothing(), nothing(), nothing());
    let (mut distance_m, mut angle_rad) = ((0.0, 0.0), (0.0, 0.0));
    let note = |worst: &mut Extreme, i: usize, time_s: f64, value: f64| {
        if value > worst.value {
            *worst = Extreme { joint: names[i].to_owned(), time_s, value };
        }
    };
    let limits = &robot.limits;
    let mut posture = vec![0.0; robot.dof()];
    for k in 0..q.len() - 1 {
        let h = time_s[k + 1] - time_s[k];
        for piece in 0..=finer {
            let s = piece as f64 / finer as f64;
            let t = time_s[k] + s * h;
            for i in 0..robot.dof() {
                let ends = [q[k][i], q[k + 1][i], rates[i][k], rates[i][k + 1]];
                let [at, rate, bend] = hermite(ends, h, s);
                posture[i] = at;
                note(&mut speed, i, t, rate.abs() / limits.velocity_at(i, at, rate));
                note(&mut acceleration, i, t, bend.abs() / limits.acceleration[i]);
                note(&mut range, i, t, (limits.lower[i] - at).max(at - limits.upper[i]));
            }
            let (there, here) = (wanted(t), tcp_pose(robot, &posture));
            let far = (there.translation.vector - here.translation.vector).norm();
            let turned = rotation_between(&here.rotation, &there.rotation).norm();
            distance_m = if far > distance_m.0 { (far, t) } else { distance_m };
            angle_rad = if turned > angle_rad.0 { (turned, t) } else { angle_rad };
        }
    }
    Some(Between { speed, acceleration, range, distance_m, angle_rad })
}

/// Postures at other times on the clamped cubic spline through knots (K of n values at K >= 2 rising
/// times, s); before the first and after the last they stay.
pub(super) fn spline_at(time_s: &[f64], q: &[Vec<f64>], wanted: &[f64]) -> Vec<Vec<f64>> {
    let n = q.first().map_or(0, Vec::len);
    let rates: Vec<Vec<f64>> = (0..n).map(|i| knot_rates(time_s, q, i)).collect();
    let at = |t: &f64| {
        let k = time_s.partition_point(|s| s <= t).clamp(1, time_s.len() - 1) - 1;
        let h = time_s[k + 1] - time_s[k];
        let s = ((t - time_s[k]) / h).clamp(0.0, 1.0);
        let joint =
            |i: usize| hermite([q[k][i], q[k + 1][i], rates[i][k], rates[i][k + 1]], h, s)[0];
        (0..n).map(joint).collect()
    };
    wanted.iter().map(at).collect()
}

/// Position, speed and acceleration at a share `s` of a step of `h` seconds, from both ends' positions
/// and speeds.
fn hermite([a, b, va, vb]: [f64; 4], h: f64, s: f64) -> [f64; 3] {
    let (chord, da, db) = (b - a, va * h, vb * h);
    // a + da s + c2 s^2 + c3 s^3
    let (c2, c3) = (3.0 * chord - 2.0 * da - db, da + db - 2.0 * chord);
    [
        a + s * (da + s * (c2 + s * c3)),
        (da + s * (2.0 * c2 + 3.0 * c3 * s)) / h,
        (2.0 * c2 + 6.0 * c3 * s) / (h * h),
    ]
}

/// Speeds of joint `i` at the knots of the clamped cubic spline, by elimination in the tridiagonal
/// system of its continuous acceleration.
fn knot_rates(time_s: &[f64], q: &[Vec<f64>], i: usize) -> Vec<f64> {
    let n = q.len();
    let mut rates = vec![0.0; n];
    if n < 3 {
        return rates;
    }
    let h: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let slope = |k: usize| (q[k + 1][i] - q[k][i]) / (h[k] * h[k]);
    let (mut above, mut right) = (vec![0.0; n], vec![0.0; n]);
    for k in 1..n - 1 {
        let pivot = 2.0 / h[k - 1] + 2.0 / h[k] - above[k - 1] / h[k - 1];
        above[k] = 1.0 / (h[k] * pivot);
        right[k] = (3.0 * (slope(k - 1) + slope(k)) - right[k - 1] / h[k - 1]) / pivot;
    }
    for k in (1..n - 1).rev() {
        rates[k] = right[k] - above[k] * rates[k + 1];
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_from_rest_to_rest_is_met_between_the_knots() {
        let robot = Robot::preset("ur5e").unwrap();
        let time: Vec<f64> = (0..=60).map(|k| (f64::from(k) / 60.0).powf(1.1)).collect();
        let at = |t: f64| {
            let mut q = robot.home.clone();
            q[2] += 0.8 * t * t * (3.0 - 2.0 * t);
            q
        };
        let q: Vec<Vec<f64>> = time.iter().map(|t| at(*t)).collect();
        let found = between(&robot, &time, &q, 10, |t| tcp_pose(&robot, &at(t))).unwrap();
        // 0.8 (6 t - 6 t^2) peaks at 1.2 rad/s in the middle, its slope at 4.8 rad/s^2 at the ends.
        let limits = &robot.limits;
        assert!((found.speed.value - 1.2 / limits.velocity[2]).abs() < 1e-3);
        assert!((found.acceleration.value - 4.8 / limits.acceleration[2]).abs() < 1e-6);
        assert!(found.distance_m.0 < 1e-6, "{found:?}");
        assert!(found.range.value < 0.0);
        assert!(between(&robot, &time[..1], &q[..1], 10, |_| Pose::identity()).is_none());
    }
}

//! A motion of a robot as a controller takes it that asks for a posture in each of its cycles.

use super::body::tcp_pose;
use super::description::Robot;
use super::joint_trajectory::{JointMargin, JointTrajectory, quintic};

/// Postures at even times, from the start of a motion to rest at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    /// Time between two rows, s.
    pub period_s: f64,
    /// Joint values of each row, as they are written, rad or m.
    pub rows: Vec<Vec<f64>>,
    /// Largest distance of the TCP from the planned motion at the times of its points, m.
    pub deviation_m: f64,
    /// Position, speed and acceleration of each joint, by differences of the rows as they are written.
    pub margins: Vec<JointMargin>,
}

impl Stream {
    /// Rows along the quintic polynomials between the points of a motion, their values rounded to `unit`
    /// (rad or m); none where a point lacks velocities or accelerations.
    pub fn of(robot: &Robot, motion: &JointTrajectory, period_s: f64, unit: f64) -> Option<Self> {
        let time = |k: usize| motion.points.get(k).map(|p| p.time_from_start.seconds());
        let end = time(motion.points.len().checked_sub(1)?)?;
        let count = (end / period_s - 1e-6).ceil().max(0.0) as usize;
        let mut rows = Vec::with_capacity(count + 1);
        let mut k = 0;
        for row in 0..=count {
            let now = (row as f64 * period_s).min(end);
            while k + 2 < motion.points.len() && time(k + 1)? < now {
                k += 1;
            }
            let (a, b) = (motion.points.get(k)?, motion.points.get(k + 1)?);
            let share = ((now - time(k)?) / (time(k + 1)? - time(k)?)).clamp(0.0, 1.0);
            let at = |j| quintic(a, b, j, share).map(|[q, ..]| (q / unit).round() * unit);
            rows.push((0..robot.dof()).map(at).collect::<Option<Vec<f64>>>()?);
        }
        let deviation_m =
            motion.points.iter().map(|p| apart(robot, &rows, period_s, p)).fold(0.0, f64::max);
        let margins = margins(robot, &rows, period_s);
        Some(Self { period_s, rows, deviation_m, margins })
    }
}

/// Distance of the TCP at a point of the motion from the rows at that time.
fn apart(robot: &Robot, rows: &[Vec<f64>], period_s: f64, point: &super::Point) -> f64 {
    let place = (point.time_from_start.seconds() / period_s).min((rows.len() - 1) as f64);
    let (before, share) = (place.floor() as usize, place.fract());
    let after = (before + 1).min(rows.len() - 1);
    let q: Vec<f64> =
        rows[before].iter().zip(&rows[after]).map(|(a, b)| a + share * (b - a)).collect();
    let [a, b] = [&q, &point.positions].map(|q| tcp_pose(robot, q).translation.vector);
    (a - b).norm()
}

/// By differences: what lies between the rows is the controller's.
fn margins(robot: &Robot, rows: &[Vec<f64>], period_s: f64) -> Vec<JointMargin> {
    let limits = &robot.limits;
    let one = |(i, joint): (usize, &str)| {
        let at: Vec<f64> = rows.iter().map(|r| r[i]).collect();
        let low = at.iter().copied().fold(f64::INFINITY, f64::min);
        let high = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let speeds: Vec<f64> = at.windows(2).map(|w| (w[1] - w[0]) / period_s).collect();
        let share = |(q, v): (&f64, &f64)| {
            if *v == 0.0 { 0.0 } else { v.abs() / limits.velocity_at(i, *q, *v) }
        };
        // At rest before and after.
        let all: Vec<f64> =
            std::iter::once(0.0).chain(speeds.iter().copied()).chain([0.0]).collect();
        let most = all.windows(2).map(|w| (w[1] - w[0]).abs() / period_s).fold(0.0, f64::max);
        let limit = limits.acceleration[i];
        let margin = (low - limits.lower[i]).min(limits.upper[i] - high);
        JointMargin {
            joint: joint.to_owned(),
            position_margin: margin.is_finite().then_some(margin),
            velocity_share: limits.velocity[i]
                .is_finite()
                .then(|| at.iter().zip(&speeds).map(share).fold(0.0, f64::max)),
            acceleration_share: (limit.is_finite() && limit > 0.0).then_some(most / limit),
        }
    };
    robot.joint_names().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_the_motion_and_the_check_sees_a_jump() {
        let robot = Robot::preset("fr3").unwrap();
        let names: Vec<String> = robot.joint_names().map(str::to_owned).collect();
        let middle: Vec<f64> =
            (0..robot.dof()).map(|i| robot.limits.middle(i).unwrap_or(0.0)).collect();
        let time: Vec<f64> = (0..=40).map(|k| f64::from(k) * 0.05).collect();
        let at = |t: f64| {
            let s = t / 2.0;
            s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        };
        let q: Vec<Vec<f64>> =
            time.iter().map(|t| middle.iter().map(|m| m + 0.2 * at(*t)).collect()).collect();
        let motion = JointTrajectory::through(names, &time, &q);
        let made = Stream::of(&robot, &motion, 1e-3, 1e-9).unwrap();
        assert_eq!(made.rows.len(), 2001);
        assert!(made.deviation_m < 1e-6, "{}", made.deviation_m);
        for (k, row) in q.iter().enumerate() {
            let written = &made.rows[50 * k];
            assert!(row.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-8));
        }
        assert!(made.margins.iter().all(|m| m.is_kept() && m.acceleration_share.is_some()));
        let mut jump = motion.clone();
        jump.points[20].positions[3] += 0.05;
        let made = Stream::of(&robot, &jump, 1e-3, 1e-9).unwrap();
        assert!(!made.margins[3].is_kept() && made.margins[2].is_kept());
        let mut bare = motion;
        bare.points[3].velocities.clear();
        assert_eq!(Stream::of(&robot, &bare, 1e-3, 1e-9), None);
    }
}

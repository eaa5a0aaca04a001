//! A motion of a robot as the programs of controllers hold it: few moves, each straight in the joints and
//! with a duration, and rests between them.

use super::body::tcp_pose;
use super::description::Robot;
use super::joint_trajectory::{JointMargin, JointTrajectory};
use thiserror::Error;

/// Joints that differ by no more stand still, rad or m.
const STILL: f64 = 1e-6;
/// Durations are whole multiples of this, s.
pub const TICK_S: f64 = 1e-4;

/// One order to the controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Move {
    /// To a posture, all joints together.
    To {
        /// Joint values, rad or m, as they are written.
        q: Vec<f64>,
        /// Duration, s.
        seconds: f64,
        /// Way of the TCP, m.
        way_m: f64,
    },
    /// Nothing moves.
    Rest {
        /// Duration, s.
        seconds: f64,
    },
}

/// A motion as moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Moves {
    /// Where it starts: joint values as they are written.
    pub start: Vec<f64>,
    /// What follows.
    pub moves: Vec<Move>,
    /// Points of the motion that was made into moves.
    pub points: usize,
    /// Largest distance of the TCP from the planned motion at equal times, m, where the joints move evenly
    /// from one written posture to the next.
    pub deviation_m: f64,
    /// By how much the duration differs from the planned one, s.
    pub duration_off_s: f64,
    /// Position and speed of each joint in the moves as they are written; accelerations are the
    /// controller's.
    pub margins: Vec<JointMargin>,
}

/// Why a motion cannot be made into moves.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NoMoves {
    /// Fewer than two points.
    #[error("the path has fewer than two points of the robot's motion")]
    TooShort,
}

impl Moves {
    /// The fewest moves, found from the start on, that stay within `tolerance_m` of the planned motion at
    /// equal times. Each written posture is one of the motion, its values rounded to `unit` (rad or m).
    ///
    /// # Errors
    /// Where there is no motion.
    pub fn of(
        robot: &Robot,
        motion: &JointTrajectory,
        tolerance_m: f64,
        unit: f64,
    ) -> Result<Self, NoMoves> {
        let time: Vec<f64> = motion.points.iter().map(|p| p.time_from_start.seconds()).collect();
        let planned: Vec<&[f64]> = motion.points.iter().map(|p| p.positions.as_slice()).collect();
        if planned.len() < 2 {
            return Err(NoMoves::TooShort);
        }
        let q: Vec<Vec<f64>> =
            planned.iter().map(|q| q.iter().map(|v| (v / unit).round() * unit).collect()).collect();
        let tcp: Vec<_> = planned.iter().map(|q| tcp_pose(robot, q).translation.vector).collect();
        let apart = |from: usize, to: usize| {
            let span = time[to] - time[from];
            let at = |k: usize| {
                let share = (time[k] - time[from]) / span;
                let even: Vec<f64> =
                    q[from].iter().zip(&q[to]).map(|(a, b)| a + share * (b - a)).collect();
                (tcp_pose(robot, &even).translation.vector - tcp[k]).norm()
            };
            (from..=to).map(at).fold(0.0, f64::max)
        };
        let mut kept = vec![0];
        let mut deviation_m: f64 = 0.0;
        while let Some(&from) = kept.last().filter(|k| **k + 1 < q.len()) {
            // Steps of twice the length while they are good, then back: few looks along long motions.
            let (mut good, mut bad) = (from + 1, q.len());
            let mut step = 1;
            while good + 1 < bad {
                let next = (good + step).min(bad - 1);
                if apart(from, next) <= tolerance_m {
                    good = next;
                    step *= 2;
                } else {
                    bad = next;
                    step = ((bad - good) / 2).max(1);
                }
            }
            deviation_m = deviation_m.max(apart(from, good));
            kept.push(good);
        }
        let ticks: Vec<f64> = time.iter().map(|t| ((t - time[0]) / TICK_S).round()).collect();
        let mut moves: Vec<Move> = Vec::new();
        for pair in kept.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let seconds = (ticks[to] - ticks[from]) * TICK_S;
            let is_still =
                q[from].iter().zip(&q[to]).all(|(a, b)| (a - b).abs() <= STILL.max(unit));
            match moves.last_mut() {
                Some(Move::Rest { seconds: rest }) if is_still => *rest += seconds,
                _ if is_still => moves.push(Move::Rest { seconds }),
                _ => {
                    let way_m = (from..to).map(|k| (tcp[k + 1] - tcp[k]).norm()).sum();
                    moves.push(Move::To { q: q[to].clone(), seconds, way_m });
                }
            }
        }
        let written = (ticks[ticks.len() - 1]) * TICK_S;
        let duration_off_s = written - (time[time.len() - 1] - time[0]);
        let margins = margins(robot, &q[0], &moves);
        Ok(Self {
            start: q[0].clone(),
            moves,
            points: q.len(),
            deviation_m,
            duration_off_s,
            margins,
        })
    }

    /// Number of moves without the rests.
    pub fn count(&self) -> usize {
        self.moves.iter().filter(|m| matches!(m, Move::To { .. })).count()
    }
}

/// How near the moves come to the limits of position, and their even speed to that of speed.
fn margins(robot: &Robot, start: &[f64], moves: &[Move]) -> Vec<JointMargin> {
    let limits = &robot.limits;
    let one = |(i, joint): (usize, &str)| {
        let (mut low, mut high, mut share): (f64, f64, f64) = (start[i], start[i], 0.0);
        let mut at = start[i];
        for step in moves {
            let Move::To { q, seconds, .. } = step else { continue };
            let speed = (q[i] - at) / seconds;
            for place in [at, q[i]] {
                let most = limits.velocity_at(i, place, speed);
                share = share.max(if speed == 0.0 { 0.0 } else { speed.abs() / most });
            }
            at = q[i];
            (low, high) = (low.min(at), high.max(at));
        }
        let margin = (low - limits.lower[i]).min(limits.upper[i] - high);
        JointMargin {
            joint: joint.to_owned(),
            position_margin: margin.is_finite().then_some(margin),
            velocity_share: limits.velocity[i].is_finite().then_some(share),
            acceleration_share: None,
        }
    };
    robot.joint_names().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All joints of a robot from its middle by `by`, by minimum jerk in 2 s, then at rest for 1 s.
    fn motion(robot: &Robot, by: f64) -> JointTrajectory {
        let time: Vec<f64> = (0..=90).map(|k| f64::from(k) / 30.0).collect();
        let at = |t: f64| {
            let s = (t / 2.0).min(1.0);
            s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        };
        let middle = |i: usize| robot.limits.middle(i).unwrap_or(0.0);
        let q: Vec<Vec<f64>> = time
            .iter()
            .map(|t| (0..robot.dof()).map(|i| middle(i) + by * at(*t)).collect())
            .collect();
        JointTrajectory::through(robot.joint_names().map(str::to_owned).collect(), &time, &q)
    }

    #[test]
    fn fewer_moves_stay_as_near_as_asked() {
        let robot = Robot::preset("ur5e").unwrap();
        let planned = motion(&robot, 0.4);
        let mut last = usize::MAX;
        for tolerance in [1e-4, 1e-3, 1e-2] {
            let made = Moves::of(&robot, &planned, tolerance, 1e-6).unwrap();
            assert!(made.deviation_m <= tolerance && made.count() < last, "{made:?}");
            last = made.count();
            // The rest is one, at the end, less what the last move takes of it within the tolerance; all
            // together take as long.
            let Some(Move::Rest { seconds }) = made.moves.last() else { panic!("{made:?}") };
            assert!((0.6..1.1).contains(seconds), "{seconds}");
            let whole: f64 = made
                .moves
                .iter()
                .map(|m| match m {
                    Move::To { seconds, .. } | Move::Rest { seconds } => *seconds,
                })
                .sum();
            assert!((whole - 3.0).abs() < TICK_S);
            assert!(made.margins.iter().all(JointMargin::is_kept));
        }
        assert!(last < 20, "{last}");
    }

    #[test]
    fn limits_are_those_of_what_is_written() {
        let robot = Robot::preset("ur5e").unwrap();
        let mut fast = motion(&robot, 0.4);
        for p in &mut fast.points {
            let t = p.time_from_start.seconds() / 20.0;
            p.time_from_start =
                super::super::Duration { sec: 0, nanosec: (t * 1e9).round() as u32 };
        }
        let made = Moves::of(&robot, &fast, 1e-3, 1e-6).unwrap();
        assert!(made.margins.iter().all(|m| m.velocity_share.unwrap() > 1.0), "{made:?}");
        let short = JointTrajectory { points: fast.points[..1].to_vec(), ..fast };
        assert_eq!(Moves::of(&robot, &short, 1e-3, 1e-6), Err(NoMoves::TooShort));
    }
}

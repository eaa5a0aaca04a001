//! How good a motion is among those that follow the same path: limits, singular postures, clearance.
//!
//! ```text
//! cost = strain + gate(sigma, 0.05) + gate(own links, 20 mm) + gate(obstacles, 30 mm)
//! gate(x, wanted) = max(0, 1 - x / wanted)         0 where there is enough of it
//! ```

use super::body::{Nearest, Placer, min_singular_value};
use super::check::RobotMotion;
use super::clearance::Obstacle;
use super::collide::SelfNearest;
use super::description::Robot;

/// Smallest singular value that is wanted, m/rad (rotation scaled by 0.3 m).
pub(super) const WANTED_SIGMA: f64 = 0.05;
/// Distance that is wanted between links of the arm, and between links and obstacles, m.
pub(super) const WANTED_SELF_M: f64 = 0.02;
pub(super) const WANTED_OBSTACLE_M: f64 = 0.03;
/// Where the field begins, somewhat before motions count as lacking: singular value (m/rad), m, m.
const FIELD: (f64, f64, f64) = (0.09, 0.06, 0.08);
/// What a motion may lack before it is tried to find a better one.
const POOR: f64 = 0.5;
/// What touching costs: more than any strain.
const TOUCHING: f64 = 100.0;

pub(super) fn gate(x: f64, wanted: f64) -> f64 {
    (1.0 - x / wanted).max(0.0)
}

/// What a posture lacks: 0 with enough room and far enough from singular postures.
#[derive(Debug)]
pub(super) struct Judge<'r> {
    pub(super) placer: Placer<'r>,
    obstacles: &'r [(String, Obstacle)],
}

impl<'r> Judge<'r> {
    pub(super) fn new(robot: &'r Robot, obstacles: &'r [(String, Obstacle)]) -> Self {
        Self { placer: Placer::new(robot), obstacles }
    }

    /// Distances to the own links and to obstacles, as far as they are below what is given (m), and
    /// the smallest singular value.
    pub(super) fn room(&mut self, q: &[f64], below: (f64, f64)) -> (f64, f64, f64) {
        self.placer.place(q);
        let own = self.placer.nearest_self(below.0).map_or(below.0, |b| b.0);
        let obstacle = self.placer.nearest_obstacle(self.obstacles, below.1);
        let sigma = min_singular_value(self.placer.robot, q);
        (own, obstacle.map_or(below.1, |b| b.0), sigma)
    }

    /// How uncomfortable a posture is: 0 where there is room on all sides; `None` where it touches.
    pub(super) fn field(&mut self, q: &[f64]) -> Option<f64> {
        let room = self.room(q, (FIELD.1, FIELD.2));
        (room.0 > 0.0 && room.1 > 0.0).then(|| self.value(q, room))
    }

    /// The same without a refusal, for slopes.
    pub(super) fn slope_field(&mut self, q: &[f64]) -> f64 {
        let room = self.room(q, (FIELD.1, FIELD.2));
        self.value(q, room)
    }

    fn value(&self, q: &[f64], (own, obstacle, sigma): (f64, f64, f64)) -> f64 {
        let limits = &self.placer.robot.limits;
        let at_limits = q.iter().enumerate().filter_map(|(i, at)| {
            let middle = limits.middle(i)?;
            let share = (at - middle).abs() / (limits.upper[i] - middle).max(1e-9);
            Some(((share - 0.8) / 0.2).max(0.0).powi(2))
        });
        let room = [(sigma, FIELD.0), (own, FIELD.1), (obstacle, FIELD.2)];
        at_limits.sum::<f64>() + room.map(|(x, wanted)| gate(x, wanted).powi(2)).iter().sum::<f64>()
    }

    /// Sets the clearances of a motion, and what it lacks.
    pub(super) fn grade(&mut self, time_s: &[f64], motion: &mut RobotMotion) {
        let robot = self.placer.robot;
        let mut own: Option<(f64, (usize, usize), f64)> = None;
        let mut obstacle: Option<(f64, usize, usize)> = None;
        for (q, &t) in motion.q.iter().zip(time_s) {
            self.placer.place(q);
            let below = own.map_or(f64::INFINITY, |b| b.0);
            if let Some((d, pair)) = self.placer.nearest_self(below) {
                own = Some((d, pair, t));
            }
            let below = obstacle.map_or(f64::INFINITY, |b| b.0);
            obstacle = self.placer.nearest_obstacle(self.obstacles, below).or(obstacle);
        }
        let link = |i: usize| robot.parts[i].link.clone();
        motion.self_nearest = own.map(|(distance_m, (i, j), time_s)| {
            Box::new(SelfNearest { distance_m, links: [link(i), link(j)], time_s })
        });
        motion.obstacle_nearest = obstacle.map(|(distance_m, i, k)| {
            let obstacle = self.obstacles[k].0.clone();
            Box::new(Nearest { distance_m, link: link(i), obstacle })
        });
        // An arm with fewer than six joints is singular always: that says nothing about a motion.
        motion.lacking =
            if robot.dof() < 6 { 0.0 } else { gate(motion.min_singular_value, WANTED_SIGMA) };
        for (distance, wanted) in
            [(own.map(|b| b.0), WANTED_SELF_M), (obstacle.map(|b| b.0), WANTED_OBSTACLE_M)]
        {
            let Some(d) = distance else { continue };
            motion.lacking += gate(d, wanted) + if d <= 0.0 { TOUCHING } else { 0.0 };
        }
    }
}

impl RobotMotion {
    /// Whether it lacks so much that looking for another motion is worth its time.
    pub fn is_poor(&self) -> bool {
        self.lacking > POOR
    }

    /// What the choice among motions makes small.
    pub(super) fn cost(&self) -> f64 {
        self.strain + self.lacking
    }

    /// Where the arm hits itself, if it does.
    pub fn self_collision(&self) -> Option<&SelfNearest> {
        self.self_nearest.as_deref().filter(|n| n.distance_m <= 0.0)
    }
}

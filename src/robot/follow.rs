//! Can the robot follow a path of its TCP? If so, by which joint path; if not, why not.
//!
//! An arm reaches a pose in several ways, and which one it starts in decides whether it can finish.
//! So the path is tracked from several distinct start postures, and the motion with the least
//! strain and the most room among those that keep all limits is taken. A poor one is tried again in
//! the null space, and on request by the global choice of [`super::resolve`].

use super::body::min_singular_value;
use super::check::{PathCheck, PathError, RobotMotion, assess, check_times};
use super::clearance::Obstacle;
use super::collide::random_posture;
use super::description::Robot;
use super::ease::Ease;
use super::grade::Judge;
use super::ik::{BEFORE_STOP_M, Residual, Solver};
use super::refusal::{AtLimit, NoMotion};
use super::resolve::resolve;
use super::track::{Track, track, track_eased};
use crate::kinematics::JointLimit;
use crate::math::Pose;
use std::f64::consts::TAU;

/// Postures that differ by less in every joint count as the same start, rad or m.
const DISTINCT: f64 = 0.3;
/// Singular value below which a broken speed limit is put down to the singular posture.
const NEARLY_SINGULAR: f64 = 0.005;
/// Distance to a limit at which a joint is said to stand there, rad or m.
const AT_LIMIT: f64 = 1e-6;
/// Start postures that are tried in the null space when none was good.
const EASED_STARTS: usize = 2;
/// Steps of inverse kinematics from a far start.
const COLD_STEPS: usize = 120;

/// How hard to try.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowSettings {
    /// Seed of the random start postures.
    pub seed: u64,
    /// Start postures tried: the home posture, then random ones.
    pub restarts: u32,
    /// Largest number of distinct start postures from which the path is tracked.
    pub starts: usize,
    /// Tolerance of positions, m.
    pub tolerance_m: f64,
    /// Tolerance of orientations, rad.
    pub tolerance_rad: f64,
    /// What the links must not touch: kept away from where the choice among motions allows it.
    pub obstacles: Vec<(String, Obstacle)>,
    /// Where tracking fails or ends poorly, choose branch and redundancy globally. Takes some tens of
    /// milliseconds.
    pub is_thorough: bool,
}

impl Default for FollowSettings {
    fn default() -> Self {
        Self {
            seed: 0,
            restarts: 24,
            starts: 8,
            tolerance_m: 1e-8,
            tolerance_rad: 1e-8,
            obstacles: Vec::new(),
            is_thorough: false,
        }
    }
}

/// Whether the robot can follow.
#[derive(Debug, Clone, PartialEq)]
pub enum Follow {
    /// It can, like this.
    Feasible(RobotMotion),
    /// It cannot.
    Infeasible {
        /// Why not.
        why: NoMotion,
    },
}

/// Postures that put the TCP at one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Starts {
    /// Distinct postures within the limits, rad or m; empty when the pose is out of reach.
    pub postures: Vec<Vec<f64>>,
    /// The nearest posture found.
    pub nearest: Vec<f64>,
    /// Its distance from the wanted position, m.
    pub residual_m: f64,
    /// Its angle from the wanted orientation, rad.
    pub residual_rad: f64,
}

/// Distinct postures that put the TCP at `pose` (world), found from the home posture and then from
/// random ones; at most `settings.starts`. The same settings give the same postures.
pub fn start_postures(robot: &Robot, pose: &Pose, settings: &FollowSettings) -> Starts {
    let mut starts = Starts {
        postures: Vec::new(),
        nearest: robot.home.clone(),
        residual_m: f64::INFINITY,
        residual_rad: f64::INFINITY,
    };
    if !is_finite(pose) {
        return starts;
    }
    let target = robot.base.inv_mul(pose);
    let mut solver = Solver::new(robot, settings.tolerance_m, settings.tolerance_rad);
    let mut least = f64::INFINITY;
    for restart in 0..settings.restarts.max(1) {
        let mut q = first_guess(robot, settings.seed, restart);
        let residual = solver.solve(&target, &mut q, COLD_STEPS);
        to_nearest_turns(robot, &mut q);
        if residual.size() < least {
            least = residual.size();
            (starts.residual_m, starts.residual_rad) = (residual.m, residual.rad);
            starts.nearest.clone_from(&q);
        }
        let is_new = |q: &[f64], other: &Vec<f64>| {
            q.iter().zip(other).any(|(a, b)| (a - b).abs() > DISTINCT)
        };
        if residual.is_within(settings.tolerance_m, settings.tolerance_rad)
            && starts.postures.iter().all(|p| is_new(&q, p))
        {
            starts.postures.push(q);
        }
        if starts.postures.len() >= settings.starts.max(1) {
            break;
        }
    }
    starts
}

/// Turns joints without end by whole turns to the values nearest to zero, where people expect them.
fn to_nearest_turns(robot: &Robot, q: &mut [f64]) {
    for (i, joint) in robot.linkage.joints().iter().enumerate() {
        let has_end = robot.limits.lower[i].is_finite() || robot.limits.upper[i].is_finite();
        if !joint.is_prismatic && !has_end {
            q[i] -= TAU * (q[i] / TAU).round();
        }
    }
}

/// Home, or a random posture within the limits.
fn first_guess(robot: &Robot, seed: u64, restart: u32) -> Vec<f64> {
    if restart == 0 { robot.home.clone() } else { random_posture(&robot.limits, seed, 0, restart) }
}

/// Follows a path of the TCP: K poses in the world at K times (s).
///
/// Each knot is reached within the tolerances; position, speed and acceleration limits hold (see
/// [`super::check_joint_path`] for how they are checked), and the arm does not touch itself. Among the
/// motions that allow this, the one with the least strain and the most room is returned; an obstacle
/// that it touches all the same is in [`RobotMotion::obstacle_nearest`]. Deterministic: the same input and
/// seed give the same result. Never panics: a pose that is not finite is infeasible.
pub fn follow(robot: &Robot, time_s: &[f64], poses: &[Pose], settings: &FollowSettings) -> Follow {
    if let Some(refusal) = malformed(time_s, poses) {
        return refusal;
    }
    let starts = start_postures(robot, &poses[0], settings);
    if starts.postures.is_empty() {
        let residual = Residual { m: starts.residual_m, rad: starts.residual_rad };
        let why = out_of_reach(robot, time_s[0], &starts.nearest, &residual);
        return Follow::Infeasible { why };
    }
    follow_from(robot, time_s, poses, &starts.postures, settings)
}

/// Like [`follow`], from given start postures: for many paths with one start pose, whose postures
/// are found once by [`start_postures`].
pub fn follow_from(
    robot: &Robot,
    time_s: &[f64],
    poses: &[Pose],
    starts: &[Vec<f64>],
    settings: &FollowSettings,
) -> Follow {
    if let Some(refusal) = malformed(time_s, poses) {
        return refusal;
    }
    let targets: Vec<Pose> = poses.iter().map(|p| robot.base.inv_mul(p)).collect();
    let mut search = Search::new(robot, (time_s, &targets), settings);
    let is_usable = |s: &&Vec<f64>| s.len() == robot.dof() && s.iter().all(|q| q.is_finite());
    let starts: Vec<&Vec<f64>> = starts.iter().filter(is_usable).collect();
    for start in &starts {
        search.track(start);
    }
    if search.is_poor() {
        search.ease(&starts);
    }
    if search.is_poor() && settings.is_thorough {
        let starts: Vec<Vec<f64>> = starts.into_iter().cloned().collect();
        let found = resolve(robot, time_s, &targets, &starts, settings);
        if let Some(motion) = found {
            search.note(motion);
        }
    }
    let touching = search.touching.as_ref().and_then(RobotMotion::self_collision).cloned();
    match (search.best, touching, search.too_hard, search.farthest) {
        (Some(motion), ..) => Follow::Feasible(motion),
        (None, Some(nearest), ..) => {
            Follow::Infeasible { why: NoMotion::TouchesItself { nearest } }
        }
        (None, None, Some(check), _) => too_hard_because(robot, time_s, check),
        (None, None, None, Some(track)) => stopped_because(robot, time_s, poses, &track, settings),
        (None, None, None, None) => Follow::Infeasible { why: NoMotion::NoStart },
    }
}

/// The motions found for one path so far.
struct Search<'r> {
    robot: &'r Robot,
    time_s: &'r [f64],
    /// In the base link's frame.
    targets: &'r [Pose],
    settings: &'r FollowSettings,
    solver: Solver<'r>,
    judge: Judge<'r>,
    /// Keeps the limits.
    best: Option<RobotMotion>,
    /// Keeps the limits, but touches itself.
    touching: Option<RobotMotion>,
    /// Breaks limits.
    too_hard: Option<PathCheck>,
    /// Stops on the way.
    farthest: Option<Track>,
}

impl<'r> Search<'r> {
    fn new(
        robot: &'r Robot,
        (time_s, targets): (&'r [f64], &'r [Pose]),
        settings: &'r FollowSettings,
    ) -> Self {
        let solver = Solver::new(robot, settings.tolerance_m, settings.tolerance_rad);
        let judge = Judge::new(robot, &settings.obstacles);
        let (best, touching, too_hard, farthest) = (None, None, None, None);
        Self { robot, time_s, targets, settings, solver, judge, best, touching, too_hard, farthest }
    }

    fn tolerance(&self) -> (f64, f64) {
        (self.settings.tolerance_m, self.settings.tolerance_rad)
    }

    /// Nothing, or nothing with room enough.
    fn is_poor(&self) -> bool {
        self.best.as_ref().is_none_or(RobotMotion::is_poor)
    }

    fn track(&mut self, start: &[f64]) {
        // Centring the joints costs speed: where that is too much, once more without.
        for centring in [1.0, 0.0] {
            self.solver.centring = centring;
            let tolerance = self.tolerance();
            let tracked = track(&mut self.solver, self.targets, start, tolerance);
            if self.take(tracked) {
                return;
            }
        }
    }

    /// Once more in the null space, from the start of what was found, else from the first starts.
    fn ease(&mut self, starts: &[&Vec<f64>]) {
        let Some(mut ease) = Ease::new(self.robot, &self.settings.obstacles) else { return };
        let known = self.best.as_ref().or(self.touching.as_ref()).map(|m| m.q[0].clone());
        let first = starts.iter().take(EASED_STARTS).map(|s| (*s).clone());
        let from: Vec<Vec<f64>> = known.map_or_else(|| first.collect(), |q| vec![q]);
        for start in from {
            let tolerance = self.tolerance();
            self.solver.centring = 0.0;
            let at = (self.time_s, self.targets);
            let tracked = track_eased(&mut self.solver, at, &start, tolerance, &mut ease);
            self.take(tracked);
        }
    }

    /// Whether another try from the same start is of no use.
    fn take(&mut self, tracked: Track) -> bool {
        if tracked.stop.is_some() {
            if self.farthest.as_ref().is_none_or(|f| tracked.q.len() > f.q.len()) {
                self.farthest = Some(tracked);
            }
            return true;
        }
        let mut check = assess(self.robot, self.time_s, tracked.q);
        check.motion.max_residual_m = tracked.worst.m;
        check.motion.max_residual_rad = tracked.worst.rad;
        if check.violations.is_empty() {
            self.judge.grade(self.time_s, &mut check.motion);
            self.note(check.motion);
            return true;
        }
        if self.too_hard.as_ref().is_none_or(|c| check.motion.strain < c.motion.strain) {
            self.too_hard = Some(check);
        }
        false
    }

    /// A motion that keeps the limits and is graded.
    fn note(&mut self, motion: RobotMotion) {
        let is_touching = motion.self_collision().is_some();
        let slot = if is_touching { &mut self.touching } else { &mut self.best };
        if slot.as_ref().is_none_or(|b| motion.cost() < b.cost()) {
            *slot = Some(motion);
        }
    }
}

fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite())
}

fn malformed(time_s: &[f64], poses: &[Pose]) -> Option<Follow> {
    let refusal = |fault| Follow::Infeasible { why: NoMotion::Malformed { fault } };
    if let Err(fault) = check_times(time_s, poses.len()) {
        return Some(refusal(fault));
    }
    let k = poses.iter().position(|p| !is_finite(p))?;
    Some(refusal(PathError::Pose { time_s: time_s[k] }))
}

/// The whole path was tracked, but a limit is broken.
fn too_hard_because(robot: &Robot, time_s: &[f64], mut check: PathCheck) -> Follow {
    let worst = check.violations.swap_remove(0);
    let near = time_s.iter().zip(&check.motion.q).filter(|(t, _)| {
        // The knots on either side of the worst moment.
        let step = time_s.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        (**t - worst.time_s).abs() <= step
    });
    let sigma = near.map(|(_, q)| min_singular_value(robot, q)).fold(f64::INFINITY, f64::min);
    let is_nearly_singular = sigma < NEARLY_SINGULAR;
    Follow::Infeasible { why: NoMotion::OverLimit { violation: worst, is_nearly_singular } }
}

/// Tracking stopped: is the pose out of reach, or only out of reach from where the arm comes?
fn stopped_because(
    robot: &Robot,
    time_s: &[f64],
    poses: &[Pose],
    track: &Track,
    settings: &FollowSettings,
) -> Follow {
    let k = track.q.len();
    let t = time_s[k];
    let starts =
        start_postures(robot, &poses[k], &FollowSettings { starts: 1, ..settings.clone() });
    let (stopped, left) = match &track.stop {
        Some((q, residual)) => (q.as_slice(), *residual),
        None => (starts.nearest.as_slice(), Residual { m: 0.0, rad: 0.0 }),
    };
    let cold = Residual { m: starts.residual_m, rad: starts.residual_rad };
    let why = if !starts.postures.is_empty() {
        NoMotion::Jump { time_s: t, at_limits: at_limits(robot, stopped) }
    } else if cold.size() < left.size() {
        out_of_reach(robot, t, &starts.nearest, &cold)
    } else {
        out_of_reach(robot, t, stopped, &left)
    };
    Follow::Infeasible { why }
}

fn out_of_reach(robot: &Robot, time_s: f64, q: &[f64], left: &Residual) -> NoMotion {
    let (residual_m, residual_rad) = (left.m, left.rad);
    NoMotion::OutOfReach { time_s, residual_m, residual_rad, at_limits: at_limits(robot, q) }
}

/// The joints that stand at a limit.
fn at_limits(robot: &Robot, q: &[f64]) -> Vec<AtLimit> {
    let of = |(i, joint): (usize, &JointLimit)| {
        let ends = [robot.limits.lower[i], robot.limits.upper[i]].into_iter();
        // A slide is held a little before its stop.
        let room = if joint.is_prismatic { BEFORE_STOP_M + AT_LIMIT } else { AT_LIMIT };
        let near = ends.filter(move |limit| (q[i] - limit).abs() < room);
        let (joint, is_prismatic) = (joint.name.clone(), joint.is_prismatic);
        near.map(move |limit| AtLimit { joint: joint.clone(), limit, is_prismatic })
    };
    robot.linkage.joints().iter().enumerate().flat_map(of).collect()
}

#[cfg(test)]
mod tests;

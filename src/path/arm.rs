//! Bends and slows a path until the robot can follow it, where that is possible.
//!
//! The path is projected first and followed by inverse kinematics. Where joints are too fast, the
//! robot's limits enter the program as rows at the knots around, linearised at the traced motion:
//!
//! ```text
//! qd_i  ~ qd_i(traced)  + g_i . (v - v_traced)     |qd_i|  <= share of its limit
//! qdd_i ~ qdd_i(traced) + g_i . (a - a_traced)     |qdd_i| <= share of its limit
//! n . p <= n . p_reached - margin                  where the pose is out of reach, n towards it
//! ```
//! `g_i` are the rows of the pseudo-inverse of the Jacobian for the linear velocity. What the turn of
//! the tool costs is part of the traced speeds: the orientation keeps its law. Solved, followed and
//! linearised again, a few times.

use super::change::Change;
use super::limits::PathLimits;
use super::project::{Projection, ProjectionSettings, infeasible, project_within};
use super::refusal::NoPath;
use super::scene::{Condition, Order, Scene};
use super::smooth::SmoothPath;
use crate::math::Vec3;
use crate::robot::{
    Between, Extreme, Follow, FollowSettings, LimitKind, NoMotion, PathError, Robot, RobotMotion,
    between, check_joint_path, follow_from, joint_rates, tcp_pose, trace,
};
use crate::trajectory::TimedPath;
use std::collections::BTreeSet;

/// Passes with rows of the robot.
const PASSES: usize = 4;
/// Share of a joint's limit that rows ask for, less in each pass.
const SHARES: [f64; PASSES] = [0.97, 0.94, 0.9, 0.85];
/// Share above which a joint gets rows at a knot.
const NEAR: f64 = 0.8;
/// Knots on either side of a broken limit that get rows.
const AROUND: usize = 4;
/// How far inside the reach rows ask the path to be, m, times the number of the pass.
const INSIDE_M: f64 = 5e-3;
/// Distance at which a pose counts as reached, m.
const REACHED_M: f64 = 1e-6;
/// Start postures tried before all.
const FEW: usize = 2;
/// How much finer than its knots a joint path is measured.
const FINER: usize = 10;

/// The robot and how it starts.
#[derive(Debug, Clone, Copy)]
pub struct Arm<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Postures in which it can start, one value per joint.
    pub starts: &'a [Vec<f64>],
    /// How hard to try.
    pub settings: &'a FollowSettings,
}

/// What came of it.
#[derive(Debug, Clone)]
pub enum Followed {
    /// A path that keeps every limit, and the robot's motion along it.
    Feasible {
        /// The projection; feasible.
        projection: Projection,
        /// Joints at the knots.
        motion: Box<RobotMotion>,
        /// The motion between the knots.
        between: Between,
        /// Passes with rows of the robot.
        passes: usize,
    },
    /// No path at all: why not.
    NoPath(Projection),
    /// A path, but the robot cannot follow it.
    NoMotion {
        /// The path that it was to follow.
        path: SmoothPath,
        /// Why not; infeasible.
        refusal: Projection,
    },
}

/// Projects a reference so that the robot can follow. `scene` holds no conditions: they come from the
/// robot.
pub fn project_for_arm(
    reference: &TimedPath,
    limits: &PathLimits,
    scene: &Scene,
    settings: &ProjectionSettings,
    arm: &Arm,
) -> Followed {
    let mut first: Option<(SmoothPath, NoPath)> = None;
    let mut conditions: Vec<Condition> = Vec::new();
    let mut knots = BTreeSet::new();
    for pass in 0..=PASSES {
        let with = Scene { conditions: &conditions, ..*scene };
        let projection = project_within(reference, limits, &with, settings);
        let Projection::Feasible { path, .. } = &projection else {
            return match first {
                Some((path, why)) => arm.refuse(path, why),
                None => Followed::NoPath(projection),
            };
        };
        let path = path.clone();
        // The global choice is made along the path as it was wanted, not along what is bent for the arm.
        let why = match arm.follow(&path, pass == 0) {
            Ok((motion, between)) => {
                let motion = Box::new(motion);
                return Followed::Feasible { projection, motion, between, passes: pass };
            }
            Err(why) => why,
        };
        if pass < PASSES {
            conditions = arm.conditions(&path, pass, &mut knots);
        }
        if first.is_none() {
            first = Some((path, why));
        }
        if conditions.is_empty() {
            break;
        }
    }
    match first {
        Some((path, why)) => arm.refuse(path, why),
        None => Followed::NoPath(infeasible(NoMotion::NoStart.into(), Vec::new())),
    }
}

impl Arm<'_> {
    /// The motion along a path, checked between the knots too; or why there is none.
    fn follow(
        &self,
        path: &SmoothPath,
        may_be_thorough: bool,
    ) -> Result<(RobotMotion, Between), NoPath> {
        let timed = path.timed(path.steps())?;
        let is_thorough = may_be_thorough && self.settings.is_thorough;
        let with = |starts: &[Vec<f64>], is_thorough: bool| {
            let settings = FollowSettings { is_thorough, ..self.settings.clone() };
            follow_from(self.robot, &timed.time_s, &timed.poses, starts, &settings)
        };
        // Few starts first: most paths need no more, and tracking is the cost.
        let few = self.starts.len().min(FEW);
        let follow = match with(&self.starts[..few], is_thorough && self.starts.len() == few) {
            Follow::Infeasible { .. } if self.starts.len() > few => with(self.starts, is_thorough),
            Follow::Feasible(motion) if self.starts.len() > few && motion.is_poor() => {
                with(self.starts, is_thorough)
            }
            done => done,
        };
        let motion = match follow {
            Follow::Feasible(motion) => motion,
            Follow::Infeasible { why } => return Err(why.into()),
        };
        let found = between(self.robot, &timed.time_s, &motion.q, FINER, |t| path.pose_at(t));
        let Some(found) = found else {
            let fault = PathError::Count { knots: motion.q.len(), times: timed.time_s.len() };
            return Err(NoMotion::Malformed { fault }.into());
        };
        let (v, a) = (&found.speed, &found.acceleration);
        for (worst, of, most) in [
            (v, LimitKind::Velocity, 1.0),
            (a, LimitKind::Acceleration, 1.0),
            (&found.range, LimitKind::Position, 1e-9),
        ] {
            if worst.value > most {
                let Extreme { joint, time_s, value } = worst.clone();
                return Err(NoMotion::BetweenKnots { joint, of, value, time_s }.into());
            }
        }
        Ok((motion, found))
    }

    /// The traced motion with the least excess, from the start postures.
    fn best_trace(&self, timed: &TimedPath) -> Option<Traced> {
        let of = |start: &Vec<f64>| Traced::new(self.robot, timed, start);
        let all = self.starts.iter().filter_map(of);
        all.min_by(|a, b| a.excess().total_cmp(&b.excess()))
    }

    /// Rows for the knots at which the traced motion breaks limits, now or in a pass before.
    fn conditions(
        &self,
        path: &SmoothPath,
        pass: usize,
        knots: &mut BTreeSet<usize>,
    ) -> Vec<Condition> {
        let Ok(timed) = path.timed(path.steps()) else { return Vec::new() };
        let Some(traced) = self.best_trace(&timed) else { return Vec::new() };
        let mut found = Vec::new();
        let last = path.steps();
        for k in 1..last {
            if traced.share(self.robot, k) > SHARES[pass] {
                knots.extend(k.saturating_sub(AROUND).max(1)..(k + AROUND + 1).min(last));
            }
            if let Some((normal, reached)) = traced.out_of_reach(k) {
                let margin = INSIDE_M * (pass + 1) as f64;
                let bound = normal.dot(&reached) - margin;
                found.push(Condition { knot: k, order: Order::Position, normal, bound });
            }
        }
        for &k in knots.iter() {
            let rates = joint_rates(self.robot, &traced.q[k]);
            for (i, g) in rates.iter().enumerate() {
                let limits = &self.robot.limits;
                let kinds = [
                    (
                        Order::Velocity,
                        traced.qd[k][i],
                        limits.velocity_at(i, traced.q[k][i], traced.qd[k][i]),
                        path.velocity[k],
                    ),
                    (
                        Order::Acceleration,
                        traced.qdd[k][i],
                        limits.acceleration[i],
                        path.acceleration[k],
                    ),
                ];
                for (order, value, limit, state) in kinds {
                    if value.abs() < NEAR * limit || g.norm() < 1e-9 {
                        continue;
                    }
                    let sign = value.signum();
                    let bound = SHARES[pass] * limit - value.abs() + sign * g.dot(&state);
                    found.push(Condition { knot: k, order, normal: g * sign, bound });
                }
            }
        }
        found
    }

    /// The refusal for a path that the robot cannot follow: by how much, and what would help.
    fn refuse(&self, path: SmoothPath, why: NoPath) -> Followed {
        let changes = self.changes(&path);
        Followed::NoMotion { path, refusal: infeasible(why, changes) }
    }

    fn changes(&self, path: &SmoothPath) -> Vec<Change> {
        let Ok(timed) = path.timed(path.steps()) else { return Vec::new() };
        let Some(traced) = self.best_trace(&timed) else { return Vec::new() };
        if traced.far.0 > REACHED_M {
            return vec![Change::RobotReach { by_m: traced.far.0, at_s: traced.far.1 }];
        }
        let Ok(check) = check_joint_path(self.robot, &timed.time_s, &traced.q) else {
            return Vec::new();
        };
        // The same way on a slower clock: joint speeds fall with it, accelerations with its square.
        let slower = |v: &crate::robot::Violation| match v.kind {
            LimitKind::Velocity => v.value / v.limit,
            LimitKind::Acceleration => (v.value / v.limit).sqrt(),
            LimitKind::Position => f64::INFINITY,
        };
        let factor = check.violations.iter().map(slower).fold(1.0, f64::max);
        let from_s = path.duration_s();
        let mut changes = Vec::new();
        if factor > 1.0 && factor.is_finite() {
            changes.push(Change::Duration { from_s, to_s: from_s * factor });
        }
        if let [v] = &check.violations[..] {
            let (joint, of, is_prismatic) = (v.joint.clone(), v.kind, v.is_prismatic);
            changes.push(Change::JointLimit {
                joint,
                of,
                is_prismatic,
                from: v.limit,
                to: v.value,
            });
        }
        changes
    }
}

/// A derivative of a joint from three consecutive postures.
type Difference<'a> = &'a dyn Fn(&[f64], &[f64], &[f64], usize) -> f64;

/// A traced motion with its joint speeds and accelerations at the knots.
struct Traced {
    q: Vec<Vec<f64>>,
    qd: Vec<Vec<f64>>,
    qdd: Vec<Vec<f64>>,
    /// Where the TCP is, and where it should be.
    reached: Vec<(Vec3, Vec3)>,
    /// Largest distance between the two, m, and when, s.
    far: (f64, f64),
    /// Largest share of a limit.
    worst_share: f64,
}

impl Traced {
    fn new(robot: &Robot, timed: &TimedPath, start: &[f64]) -> Option<Self> {
        if start.len() != robot.dof() || timed.time_s.len() < 3 {
            return None;
        }
        let q = trace(robot, &timed.poses, start);
        let (last, h) = (q.len() - 1, timed.time_s[1] - timed.time_s[0]);
        let difference = |k: usize, of: Difference| -> Vec<f64> {
            if k == 0 || k == last {
                return vec![0.0; robot.dof()];
            }
            (0..robot.dof()).map(|i| of(&q[k - 1], &q[k], &q[k + 1], i)).collect()
        };
        // The faster of the two chords: that is what is checked.
        let speed = |a: &[f64], b: &[f64], c: &[f64], i: usize| {
            let (before, after) = ((b[i] - a[i]) / h, (c[i] - b[i]) / h);
            if before.abs() > after.abs() { before } else { after }
        };
        let bend = |a: &[f64], b: &[f64], c: &[f64], i: usize| (a[i] - 2.0 * b[i] + c[i]) / (h * h);
        let qd: Vec<_> = (0..=last).map(|k| difference(k, &speed)).collect();
        let qdd: Vec<_> = (0..=last).map(|k| difference(k, &bend)).collect();
        let place = |(q, pose): (&Vec<f64>, &crate::math::Pose)| {
            (tcp_pose(robot, q).translation.vector, pose.translation.vector)
        };
        let reached: Vec<(Vec3, Vec3)> = q.iter().zip(&timed.poses).map(place).collect();
        let distances = reached.iter().zip(&timed.time_s).map(|((a, b), t)| ((a - b).norm(), *t));
        let far = distances.fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        let mut traced = Self { q, qd, qdd, reached, far, worst_share: 0.0 };
        traced.worst_share = (0..=last).map(|k| traced.share(robot, k)).fold(0.0, f64::max);
        Some(traced)
    }

    /// One number for comparison: distance out of reach first.
    fn excess(&self) -> f64 {
        if self.far.0 > REACHED_M { 1e6 + self.far.0 } else { self.worst_share }
    }

    /// Largest share of a limit at a knot.
    fn share(&self, robot: &Robot, k: usize) -> f64 {
        let limits = &robot.limits;
        let at = |i: usize| limits.velocity_at(i, self.q[k][i], self.qd[k][i]);
        let speed = self.qd[k].iter().enumerate().map(|(i, v)| v.abs() / at(i));
        let acceleration = self.qdd[k].iter().zip(&limits.acceleration).map(|(a, l)| a.abs() / l);
        // Still at the very end of the range: 0 of 0.
        speed.chain(acceleration).filter(|s| !s.is_nan()).fold(0.0, f64::max)
    }

    /// Towards a pose out of reach, and where the TCP is instead.
    fn out_of_reach(&self, k: usize) -> Option<(Vec3, Vec3)> {
        let (reached, wanted) = &self.reached[k];
        let way = wanted - reached;
        (way.norm() > REACHED_M).then(|| (way.normalize(), *reached))
    }
}

#[cfg(test)]
mod tests;

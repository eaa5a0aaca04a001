//! From a candidate to a path that can be simulated: QP, robot, obstacles; or the reason why not.

use super::along::hand_motion;
use super::near::{ArmAlong, Care};
use super::objective::Figures;
use super::preset::Preset;
use super::refusal::{Refusal, RefusedBy, Status};
use super::result::{HandMotion, PathData};
use crate::human::reach_ball;
use crate::math::{Pose, Vec3};
use crate::path::{
    Arm, Candidate, Change, Check, Family, Followed, NoAnswer, NoPath, Projection,
    ProjectionSettings, Reach, Scene, SmoothPath, Verification, project_for_arm, reference_path,
    verify, verify_motion, verify_optimality, verify_samples, verify_samples_within, verify_scene,
};
use crate::robot::{
    Follow, FollowSettings, JointMargin, JointTrajectory, Nearest, NoMotion, Robot, RobotMotion,
    Starts, check_joint_path, follow_from, measure_room, start_postures,
};
use crate::scenario::{EndMismatch, Scenario, UserPath, Variant};
use crate::trajectory::TimedPath;

/// Longest steps in which a path of the user's is looked at, s and m, and most steps.
const LONGEST_STEP_S: f64 = 0.25;
const LONGEST_STEP_M: f64 = 0.02;
const MOST_STEPS: f64 = 3000.0;
/// Distance to obstacles below which a path is refused, m.
const SMALLEST_CLEARANCE_M: f64 = 0.0;

/// A path with everything that does not depend on the worker.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub id: String,
    /// Where it starts and ends, who stands where.
    pub variant: Variant,
    pub family: Family,
    pub vias_m: Vec<[f64; 3]>,
    pub status: Status,
    /// The candidate before the limits; none for the user's own.
    pub reference: Option<TimedPath>,
    /// TCP in the world on the uniform grid; none when refused before that.
    pub path: Option<TimedPath>,
    pub checks: Vec<Check>,
    pub robot: Option<RobotMotion>,
    pub moved_m: f64,
    /// How far it is from being feasible, to order what is refused: m of an obstacle's depth, or by
    /// the stage that refused it.
    pub severity: f64,
    /// What would help a path that is refused, each alone.
    pub changes: Vec<Change>,
    /// Given by the user: kept and marked rather than refused.
    pub is_users: bool,
    /// The user's own, from somewhere else or to somewhere else than the others: compared with none.
    pub ends: Option<EndMismatch>,
}

/// What all candidates of a scenario share.
pub(super) struct Workshop<'a> {
    scenario: &'a Scenario,
    preset: &'a Preset,
    follow: FollowSettings,
    /// The same with the global choice where tracking fails.
    thorough: FollowSettings,
    robot_starts: Starts,
    reaches: Vec<Reach>,
}

impl<'a> Workshop<'a> {
    pub(super) fn new(scenario: &'a Scenario, preset: &'a Preset, seed: u64) -> Self {
        let obstacles = scenario.obstacles.clone();
        let follow = FollowSettings { seed, obstacles, ..FollowSettings::default() };
        let thorough = FollowSettings { is_thorough: true, ..follow.clone() };
        let robot_starts = start_postures(&scenario.robot, &scenario.start, &follow);
        let reaches = reaches(scenario);
        Self { scenario, preset, follow, thorough, robot_starts, reaches }
    }

    /// What the TCP's path has to mind.
    pub(super) fn scene(&self) -> Scene<'_> {
        Scene { obstacles: &self.scenario.obstacles, reaches: &self.reaches, ..Scene::default() }
    }

    pub(super) fn scenario(&self) -> &'a Scenario {
        self.scenario
    }

    pub(super) fn projection_settings(&self) -> ProjectionSettings {
        ProjectionSettings { steps: self.preset.steps, ..Default::default() }
    }

    /// The robot where a variant puts it.
    pub(super) fn robot_of(&self, variant: &Variant) -> Robot {
        let mut robot = self.scenario.robot.clone();
        robot.base = variant.base;
        robot
    }

    /// A planned candidate: projected to feasibility, or refused with the reason.
    pub(super) fn candidate(&self, candidate: &Candidate, variant: &Variant) -> Prepared {
        self.candidate_with(candidate, variant, &self.follow)
    }

    /// The same, choosing branch and redundancy of the arm globally where tracking fails: for the few
    /// paths that matter, as it takes some tens of milliseconds.
    pub(super) fn candidate_thoroughly(
        &self,
        candidate: &Candidate,
        variant: &Variant,
    ) -> Prepared {
        self.candidate_with(candidate, variant, &self.thorough)
    }

    fn candidate_with(
        &self,
        candidate: &Candidate,
        variant: &Variant,
        follow: &FollowSettings,
    ) -> Prepared {
        let mut prepared = Prepared {
            id: candidate.id.clone(),
            variant: variant.clone(),
            family: candidate.family,
            vias_m: candidate.vias.iter().map(|v| (*v).into()).collect(),
            status: Status::Feasible,
            reference: None,
            path: None,
            checks: Vec::new(),
            robot: None,
            moved_m: 0.0,
            severity: 0.0,
            changes: Vec::new(),
            is_users: false,
            ends: None,
        };
        let s = self.scenario;
        let reference = reference_path(
            candidate,
            &variant.start,
            &variant.goal,
            variant.whole_s(),
            self.preset.steps,
        );
        let reference = match reference {
            Ok(reference) => reference,
            Err(e) => return prepared.refused(NoPath::from(e)),
        };
        prepared.reference = Some(reference.clone());
        let (moved, new_starts);
        let is_moved = variant.base != s.robot.base || variant.start != s.start;
        let (robot, starts) = if is_moved {
            moved = self.robot_of(variant);
            new_starts = start_postures(&moved, &variant.start, &self.follow);
            (&moved, &new_starts)
        } else {
            (&s.robot, &self.robot_starts)
        };
        if starts.postures.is_empty() {
            return prepared.refused(no_start(starts));
        }
        let starts = &starts.postures;
        // A ball about a shoulder that has moved with the worker would be another one.
        let is_walked = variant.at_m != s.worker.at_m || variant.facing != s.worker.facing;
        let most = s.free.turn_rad.unwrap_or(0.0);
        let turning = candidate.turning(&variant.start, &variant.goal, most);
        let reaches = if is_walked { &[] } else { &self.reaches[..] };
        let scene = Scene { reaches, turning: turning.as_ref(), ..self.scene() };
        let arm = Arm { robot, starts, settings: follow };
        let settings = self.projection_settings();
        match project_for_arm(&reference, &s.limits, &scene, &settings, &arm) {
            Followed::Feasible { projection, motion, between, .. } => {
                let Projection::Feasible { path, moved_m, optimality, .. } = projection else {
                    return prepared.refused(NoPath::Unsolved { answer: NoAnswer::NotSettled });
                };
                prepared.moved_m = moved_m;
                prepared.checks = verify(&path, &s.limits).checks;
                prepared.checks.extend(verify_scene(&path, &s.limits, &scene, &reference).checks);
                prepared.checks.extend(verify_optimality(&optimality).checks);
                prepared.checks.extend(verify_motion(&between).checks);
                let knots = path.timed(self.preset.steps).ok();
                let broken = knots.and_then(|p| between_knots(robot, &p, &motion));
                prepared.robot = Some(*motion);
                match broken {
                    Some(margin) => prepared.refused(Refusal::BetweenKnots(margin)),
                    None => self.kept(prepared, &path),
                }
            }
            Followed::NoPath(refusal) => prepared.because(refusal),
            Followed::NoMotion { path, refusal } => {
                prepared.path = path.timed(self.preset.steps).ok();
                prepared.because(refusal)
            }
        }
    }

    /// A path with all its checks: refused if one is broken or a link touches an obstacle.
    fn kept(&self, mut prepared: Prepared, path: &SmoothPath) -> Prepared {
        match path.timed(self.preset.steps) {
            Ok(timed) => prepared.path = Some(timed),
            Err(e) => return prepared.refused(NoPath::from(e)),
        }
        // A path that keeps its limits is one, even if a nearer one might exist.
        let broken = prepared.checks.iter().find(|c| !c.is_met() && !c.quantity.is_optimality());
        if let Some(check) = broken.copied() {
            return prepared.refused(Refusal::Limit(check));
        }
        match prepared.touched() {
            Some(refusal) => prepared.refused(refusal),
            None => prepared,
        }
    }

    /// The user's own path: as it is, marked where it breaks a limit, never repaired.
    pub(super) fn users(&self, user: &UserPath) -> Prepared {
        let s = self.scenario;
        let Verification { mut checks } = verify_samples(&user.path, &s.limits);
        checks.extend(verify_samples_within(&user.path, &s.limits, &self.scene()).checks);
        let broken = checks.iter().filter(|c| !c.is_met()).copied();
        let mut violations: Vec<Refusal> = broken.map(Refusal::Limit).collect();
        let mut prepared = Prepared {
            id: user.name.clone(),
            variant: s.nominal(),
            family: Family::Drawn,
            vias_m: Vec::new(),
            status: Status::Feasible,
            reference: None,
            path: None,
            checks,
            robot: None,
            moved_m: 0.0,
            severity: 0.0,
            changes: Vec::new(),
            is_users: true,
            ends: s.end_mismatch(&user.path),
        };
        let path = match user.path.resample(user.path.duration_s() / self.samples_of(&user.path)) {
            Ok(path) => path,
            Err(e) => return prepared.refused(NoPath::from(e)),
        };
        match &user.joints {
            Some(q) => match check_joint_path(&s.robot, &user.path.time_s, q) {
                Ok(mut check) => {
                    violations.extend(check.violations.iter().cloned().map(Refusal::JointLimit));
                    let time_s = &user.path.time_s;
                    measure_room(&s.robot, time_s, &mut check.motion, &s.obstacles);
                    let touching = check.motion.self_collision().cloned();
                    let own = touching.map(|nearest| NoMotion::TouchesItself { nearest });
                    violations.extend(own.map(Refusal::Robot));
                    let q = at_times(time_s, q, &path.time_s);
                    prepared.robot = Some(RobotMotion { q, ..check.motion });
                }
                Err(fault) => {
                    violations.push(Refusal::Robot(NoMotion::Malformed { fault }));
                }
            },
            None => match self.follow_users(&path) {
                Follow::Feasible(motion) => prepared.robot = Some(motion),
                Follow::Infeasible { why } => violations.push(Refusal::Robot(why)),
            },
        }
        violations.extend(prepared.touched());
        prepared.path = Some(path);
        if !violations.is_empty() {
            prepared.status = Status::Marked { violations };
        }
        prepared
    }

    /// Steps in which a path of the user's is looked at: as many as ours have, and more where it is long
    /// in time or way. What the scenario says of the duration does not matter.
    fn samples_of(&self, path: &TimedPath) -> f64 {
        let apart = |w: &[Pose]| (w[1].translation.vector - w[0].translation.vector).norm();
        let travel_m: f64 = path.poses.windows(2).map(apart).sum();
        let wanted = (path.duration_s() / LONGEST_STEP_S).max(travel_m / LONGEST_STEP_M);
        wanted.ceil().clamp(self.preset.steps as f64, MOST_STEPS)
    }

    fn follow_users(&self, path: &TimedPath) -> Follow {
        let robot = &self.scenario.robot;
        let starts = start_postures(robot, &path.poses[0], &self.follow);
        follow_from(robot, &path.time_s, &path.poses, &starts.postures, &self.thorough)
    }
}

impl Prepared {
    /// Length of the way of the TCP, m; none without a path.
    pub(super) fn length_m(&self) -> Option<f64> {
        let poses = &self.path.as_ref()?.poses;
        let chord = |w: &[Pose]| (w[1].translation.vector - w[0].translation.vector).norm();
        Some(poses.windows(2).map(chord).sum())
    }

    /// The smallest clearance to an obstacle; none without a motion, shapes or obstacles.
    pub(super) fn clearance(&self) -> Option<&Nearest> {
        self.robot.as_ref()?.obstacle_nearest.as_deref()
    }

    /// The refusal for an obstacle that a link touches.
    fn touched(&self) -> Option<Refusal> {
        let near = self.clearance().filter(|n| n.distance_m <= SMALLEST_CLEARANCE_M)?;
        let (link, obstacle) = (near.link.clone(), near.obstacle.clone());
        Some(Refusal::Obstacle { link, obstacle, depth_m: -near.distance_m })
    }

    fn refused(mut self, refusal: impl Into<Refusal>) -> Self {
        let refusal = refusal.into();
        self.severity = match (refusal.by(), &refusal) {
            (_, Refusal::Obstacle { depth_m, .. }) => *depth_m,
            (RefusedBy::Worker, _) => 1.0,
            (RefusedBy::Robot, _) => 2.0,
            _ => 3.0,
        };
        self.status = Status::Infeasible { refusal };
        self
    }

    fn because(mut self, refusal: Projection) -> Self {
        match refusal {
            Projection::Infeasible { why, changes } => {
                self.changes = changes;
                self.refused(why)
            }
            Projection::Feasible { .. } => self,
        }
    }

    /// A path that nobody of some body size can follow to the end is no path; the user's own is only
    /// marked.
    pub(super) fn refuse_if_nobody_reaches(&mut self, bodies: &[&str], figures: &[Figures]) {
        let all_lost = |f: &Figures| !f.lost.is_empty() && f.lost.iter().all(|l| *l > 0.0);
        let Some((body, lost)) = bodies.iter().zip(figures).find(|(_, f)| all_lost(f)) else {
            return;
        };
        let (body, from_s) = ((*body).to_owned(), lost.lost_from_s.unwrap_or(0.0));
        self.status.refuse(self.is_users, Refusal::Worker { body, from_s });
    }

    /// The arm along the path, to be compared with the worker; none without shapes or motion.
    pub(super) fn arm<'r>(&self, robot: &'r Robot, care: Care) -> Option<ArmAlong<'r>> {
        let steps = self.path.as_ref()?.time_s.len();
        let motion = self.robot.as_ref().filter(|m| m.q.len() == steps)?;
        ArmAlong::new(robot, &motion.q, care)
    }

    /// Whether it can be simulated.
    pub(super) fn is_feasible(&self) -> bool {
        self.path.is_some() && !matches!(self.status, Status::Infeasible { .. })
    }

    fn hand_motion(&self, path: &TimedPath) -> HandMotion {
        let hand: Vec<Vec3> =
            path.poses.iter().map(|tcp| (tcp * self.variant.grip).translation.vector).collect();
        hand_motion(&hand, path.duration_s() / (hand.len().max(2) - 1) as f64)
    }

    /// As data for the result, with the robot's joints at the path's times.
    pub(super) fn data(&self, scenario: &Scenario) -> Option<PathData> {
        let path = self.path.as_ref()?;
        let q = self.robot.as_ref().map(|m| m.q.clone()).filter(|q| q.len() == path.time_s.len());
        let robot = &scenario.robot;
        let names = || robot.joint_names().map(str::to_owned).collect();
        let trajectory = q.as_ref().map(|q| JointTrajectory::through(names(), &path.time_s, q));
        Some(PathData {
            time_s: path.time_s.clone(),
            tcp: path.poses.iter().map(seven).collect(),
            robot_joints: scenario.robot.joint_names().map(str::to_owned).collect(),
            joint_margins: trajectory.as_ref().map(|t| t.check(robot)).unwrap_or_default(),
            joint_trajectory: trajectory,
            robot_q: q.unwrap_or_default(),
            checks: self.checks.clone(),
            robot_margins: self.robot.as_ref().map(RobotMotion::margins),
            clearance: robot.obstacle_clearance(self.robot.as_ref(), scenario.obstacles.len()),
            self_clearance: robot.self_clearance(self.robot.as_ref()),
            moved_m: self.moved_m,
            hand: self.hand_motion(path),
        })
    }
}

/// The refusal of a start that the robot does not reach.
fn no_start(starts: &Starts) -> Refusal {
    let known = |x: f64| x.is_finite().then_some(x);
    Refusal::Start {
        residual_m: known(starts.residual_m),
        residual_rad: known(starts.residual_rad),
    }
}

/// A joint whose limit is broken between the knots, as a controller would run them.
fn between_knots(robot: &Robot, path: &TimedPath, motion: &RobotMotion) -> Option<JointMargin> {
    if motion.q.len() != path.time_s.len() {
        return None;
    }
    let names = robot.joint_names().map(str::to_owned).collect();
    let margins = JointTrajectory::through(names, &path.time_s, &motion.q).check(robot);
    margins.into_iter().find(|m| !m.is_kept())
}

/// Joint angles at other times, interpolated linearly.
fn at_times(time_s: &[f64], q: &[Vec<f64>], wanted: &[f64]) -> Vec<Vec<f64>> {
    let at = |t: f64| -> Vec<f64> {
        let high = time_s.partition_point(|s| *s < t).clamp(1, time_s.len() - 1);
        let (a, b) = (time_s[high - 1], time_s[high]);
        let part = ((t - a) / (b - a)).clamp(0.0, 1.0);
        q[high - 1].iter().zip(&q[high]).map(|(x, y)| x + part * (y - x)).collect()
    };
    wanted.iter().map(|t| at(*t)).collect()
}

fn seven(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation);
    // One sign for each orientation, so that equal paths give equal bytes.
    let s = if q.w < 0.0 { -1.0 } else { 1.0 };
    [p.x, p.y, p.z, s * q.w, s * q.i, s * q.j, s * q.k]
}

/// Where each body's hand can be led: a ball about the shoulder, widened by the offset between the
/// grip and the TCP, which the hand's turn may put anywhere.
fn reaches(scenario: &Scenario) -> Vec<Reach> {
    let w = &scenario.worker;
    let of = |body: &crate::human::Body| {
        let (center, radius) = reach_ball(body, w.hands.lead(), w.pelvis).ok()?;
        let pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance);
        Some(Reach {
            body: body.name.clone(),
            center: (pelvis * nalgebra::Point3::from(center)).coords,
            radius_m: radius + scenario.grip.translation.vector.norm(),
        })
    };
    w.bodies.iter().filter_map(of).collect()
}

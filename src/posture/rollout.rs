//! Closed-loop rollouts: the posture that follows a hand path, one sampled person at a time.
//!
//! ```text
//! xdot = (x_d(t+h) - f(q)) / h           closed on the path (paper, section V-C)
//! z    = lambda c(x) (m(x) - q) + gp(q, xdot) + e(t)
//! qdot = z + J_W^+ (xdot - J z)          under limits, by lock and resolve
//! ```
//! Steps are at most 8 mm and 2 deg of hand travel. All poses are of the grip in the pelvis frame.

use super::model::PostureModel;
use super::noise::NoisePath;
use super::start::Start;
use super::step::{ReachExceeded, StepSolver};
use crate::files::InputError;
use crate::human::{Body, PostureLimits, Side};
use crate::kinematics::{Frames, Linkage};
use crate::math::pose::{interpolate, pose_error};
use crate::math::{Pose, Vec3, Vec6};
use nalgebra::{DMatrix, DVector, Matrix6xX, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Longest step of the hand, m and rad (2 deg).
const STEP_M: f64 = 0.008;
const STEP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Residual of the hand beyond which Newton corrections are made, and beyond which the rollout ends.
const CORRECT_BEYOND_M: f64 = 2e-4;
const END_BEYOND_M: f64 = 1e-3;
/// Largest change of a joint in one step, rad; more means the arm is about to lose the path.
const LARGEST_JOINT_STEP: f64 = 0.6;

/// Which motions of the hand the robot prescribes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Position and orientation: 6 rows.
    Rigid,
    /// All but the rotation about the held bar (grip z): 5 rows.
    FreeRoll,
    /// Position only: 3 rows.
    Point,
}

impl Hold {
    /// Number of task rows.
    pub fn rows(self) -> usize {
        match self {
            Self::Rigid => 6,
            Self::FreeRoll => 5,
            Self::Point => 3,
        }
    }
}

/// A body whose hand is coupled to the robot.
#[derive(Debug, Clone)]
pub struct Coupling {
    arm: Linkage,
    limits: PostureLimits,
    hold: Hold,
    stature_m: f64,
}

/// Where the hand is and how the joints move it.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Grip pose in the pelvis frame.
    pub pose: Pose,
    /// Task Jacobian, m x n.
    pub jacobian: DMatrix<f64>,
}

impl Coupling {
    /// Couples a body's hand.
    pub fn new(body: &Body, side: Side, hold: Hold) -> Result<Self, InputError> {
        let arm = body.arm(side)?;
        let limits = body.limits(&arm);
        Ok(Self { arm, limits, hold, stature_m: body.size.stature_m })
    }

    /// Number of joints of the chain, n.
    pub fn dof(&self) -> usize {
        self.arm.dof()
    }

    /// Names of the joints, in order.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.arm.joints().iter().map(|j| j.name.as_str())
    }

    /// Limits of the chain.
    pub fn limits(&self) -> &PostureLimits {
        &self.limits
    }

    /// Stature of the body, m.
    pub fn stature_m(&self) -> f64 {
        self.stature_m
    }

    /// Pose of the grip and the task Jacobian at `q` (n, rad).
    pub fn observe(&self, q: &DVector<f64>, frames: &mut Frames) -> Observation {
        self.arm.forward(q.as_slice(), frames);
        let full = self.arm.jacobian(frames, 0);
        let pose = self.arm.tip_pose(frames, 0);
        Observation { jacobian: self.task_rows(&full, &pose), pose }
    }

    fn task_rows(&self, full: &Matrix6xX<f64>, pose: &Pose) -> DMatrix<f64> {
        let mut rows = DMatrix::zeros(self.hold.rows(), full.ncols());
        rows.rows_mut(0, 3).copy_from(&full.fixed_rows::<3>(0));
        match self.hold {
            Hold::Rigid => rows.rows_mut(3, 3).copy_from(&full.fixed_rows::<3>(3)),
            Hold::FreeRoll => {
                let angular = full.fixed_rows::<3>(3);
                for (i, axis) in grip_cross_axes(pose).iter().enumerate() {
                    rows.row_mut(3 + i).copy_from(&(axis.transpose() * angular));
                }
            }
            Hold::Point => {}
        }
        rows
    }

    /// What the task prescribes of a twist or pose error given in base axes.
    fn task_part(&self, twist: &Vec6, pose: &Pose) -> DVector<f64> {
        let mut part = vec![twist[0], twist[1], twist[2]];
        let angular = Vec3::new(twist[3], twist[4], twist[5]);
        match self.hold {
            Hold::Rigid => part.extend_from_slice(angular.as_slice()),
            Hold::FreeRoll => part.extend(grip_cross_axes(pose).iter().map(|a| a.dot(&angular))),
            Hold::Point => {}
        }
        DVector::from_vec(part)
    }

    /// Error from one grip pose to another in task rows: m, then rad.
    ///
    /// With a free roll the angular part is the rotation that aligns the grip's z axes.
    pub fn task_error(&self, from: &Pose, to: &Pose) -> DVector<f64> {
        let mut error = pose_error(from, to);
        if self.hold == Hold::FreeRoll {
            let (a, b) = (from.rotation * Vec3::z(), to.rotation * Vec3::z());
            let turn =
                UnitQuaternion::rotation_between(&a, &b).map_or(Vec3::zeros(), |r| r.scaled_axis());
            error.fixed_rows_mut::<3>(3).copy_from(&turn);
        }
        self.task_part(&error, from)
    }
}

/// The grip's x and y axes, about which the bar prescribes the rotation.
fn grip_cross_axes(pose: &Pose) -> [Vec3; 2] {
    [pose.rotation * Vec3::x(), pose.rotation * Vec3::y()]
}

/// One sampled person along one path.
#[derive(Debug, Clone, PartialEq)]
pub struct Rollout {
    /// Joint angles at every path sample, T+1 of n, rad. After the reach is exceeded the last
    /// posture is repeated.
    pub q: Vec<DVector<f64>>,
    /// Index of the first sample that could not be reached.
    pub reach_exceeded_at: Option<usize>,
    /// Largest distance of the hand from the path at the samples that were reached, m.
    pub max_residual_m: f64,
    /// Root mean square of that distance, m.
    pub rms_residual_m: f64,
    /// Largest angle between hand and path, rad (of the prescribed rotations).
    pub max_residual_rad: f64,
    /// Share of the samples at which the training data do not support the posture model (confidence
    /// below one half); 0 without an attraction.
    pub extrapolation_share: f64,
}

/// Walks one person along a path of grip poses (pelvis frame) at times `time_s`.
///
/// `noise` holds `F u` at the path samples, so that candidates of one duration share it.
pub fn roll_out(
    coupling: &Coupling,
    model: &PostureModel,
    (time_s, targets): (&[f64], &[Pose]),
    start: &Start,
    noise: Option<&NoisePath>,
) -> Rollout {
    let mut walk = Walk {
        coupling,
        model,
        solver: StepSolver::new(model.weight.clone()),
        frames: Frames::default(),
        q: start.q.clone().unwrap_or_else(|| model.postures.mean.clone()),
        low_confidence: 0,
    };
    let mut q = vec![walk.q.clone()];
    let mut reach_exceeded_at = start.q.is_none().then_some(0);
    let (mut max_m, mut sum_sq, mut max_rad) = (0.0f64, 0.0, 0.0f64);
    for k in 1..targets.len() {
        if reach_exceeded_at.is_none() {
            let span = time_s[k] - time_s[k - 1];
            let leg = Leg { from: targets[k - 1], to: targets[k], span, index: k - 1 };
            match walk.advance(&leg, noise) {
                Ok(error) => {
                    let metres = error.rows(0, 3).norm();
                    max_m = max_m.max(metres);
                    sum_sq += metres * metres;
                    max_rad = max_rad.max(error.rows_range(3..).norm());
                }
                Err(ReachExceeded) => reach_exceeded_at = Some(k),
            }
        }
        q.push(walk.q.clone());
    }
    let reached = reach_exceeded_at.unwrap_or(targets.len()).max(1);
    Rollout {
        q,
        reach_exceeded_at,
        max_residual_m: max_m,
        rms_residual_m: (sum_sq / reached as f64).sqrt(),
        max_residual_rad: max_rad,
        extrapolation_share: f64::from(walk.low_confidence) / reached as f64,
    }
}

/// From one path sample to the next.
struct Leg {
    from: Pose,
    to: Pose,
    span: f64,
    index: usize,
}

struct Walk<'a> {
    coupling: &'a Coupling,
    model: &'a PostureModel,
    solver: StepSolver,
    frames: Frames,
    q: DVector<f64>,
    low_confidence: u32,
}

impl Walk<'_> {
    /// Moves to the end of a leg; the task error there.
    fn advance(
        &mut self,
        leg: &Leg,
        noise: Option<&NoisePath>,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let travel = pose_error(&leg.from, &leg.to);
        let steps = (travel.fixed_rows::<3>(0).norm() / STEP_M)
            .max(travel.fixed_rows::<3>(3).norm() / STEP_RAD)
            .ceil()
            .clamp(1.0, 200.0) as usize;
        let h = leg.span / steps as f64;
        let mut error = DVector::zeros(0);
        for step in 0..steps {
            let part = (step + 1) as f64 / steps as f64;
            let target = interpolate(&leg.from, &leg.to, part);
            let now = self.coupling.observe(&self.q, &mut self.frames);
            let twist = pose_error(&now.pose, &target) / h;
            let task = self.coupling.task_error(&now.pose, &target) / h;
            let mut preferred = DVector::zeros(self.q.len());
            if let Some(attraction) = &self.model.attraction {
                let usual = attraction.usual_posture(&now.pose, self.coupling.stature_m);
                preferred = (usual.posture - &self.q) * (attraction.rate() * usual.confidence);
                self.low_confidence += u32::from(step == 0 && usual.confidence < 0.5);
            }
            if let Some(gp) = &self.model.gp {
                preferred += gp.mean(self.q.as_slice(), twist.as_slice());
            }
            if let Some(noise) = noise {
                let at = noise.at(leg.index, step as f64 / steps as f64);
                preferred += at * self.model.noise.speed(twist.as_slice());
            }
            self.step(&now.jacobian, &task, &preferred, h)?;
            error = self.correct(&target)?;
        }
        Ok(error)
    }

    fn step(
        &mut self,
        jacobian: &DMatrix<f64>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        h: f64,
    ) -> Result<(), ReachExceeded> {
        let limits = self.coupling.limits();
        let qdot = self.solver.solve(&self.q, jacobian, task, preferred, limits, h)?;
        if qdot.amax() * h > LARGEST_JOINT_STEP {
            return Err(ReachExceeded);
        }
        self.q.axpy(h, &qdot, 1.0);
        Ok(())
    }

    /// Newton corrections when the curvature of the step has taken the hand off the path.
    fn correct(&mut self, target: &Pose) -> Result<DVector<f64>, ReachExceeded> {
        for _ in 0..4 {
            let now = self.coupling.observe(&self.q, &mut self.frames);
            let error = self.coupling.task_error(&now.pose, target);
            let metres = error.rows(0, 3).norm();
            let radians = error.rows_range(3..).norm();
            if metres <= CORRECT_BEYOND_M && radians <= 4.0 * CORRECT_BEYOND_M {
                return Ok(error);
            }
            let still = DVector::zeros(self.q.len());
            self.step(&now.jacobian, &error, &still, 1.0)?;
        }
        let now = self.coupling.observe(&self.q, &mut self.frames);
        let error = self.coupling.task_error(&now.pose, target);
        if error.rows(0, 3).norm() > END_BEYOND_M { Err(ReachExceeded) } else { Ok(error) }
    }
}

//! Closed-loop rollouts: the posture that follows a hand path, one sampled person at a time.
//!
//! ```text
//! xdot = (x_d(t+h) - f(q)) / h           closed on the path (paper, section V-C)
//! z    = lambda c(x)^2 (m(x) - q) + process(q, xdot) + e(t)
//! qdot = z + J_W^+ (xdot - J z)          under limits, by lock and resolve
//! ```
//! Steps are at most 8 mm and 2 deg of hand travel. All poses are of the grip in the pelvis frame.

use super::attraction::UsualPosture;
use super::coupling::{Coupling, Observation};
use super::law::{Person, PostureLaw, Query};
use super::start::Start;
use super::step::{ReachExceeded, StepSolver};
use crate::kinematics::Frames;
use crate::math::pose::{interpolate, pose_error};
use crate::math::{Pose, Vec6};
use nalgebra::{DMatrix, DVector};

/// Longest step of the hand, m and rad (2 deg).
const STEP_M: f64 = 0.008;
const STEP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Residual of the hand beyond which Newton corrections are made, and beyond which the rollout ends.
const CORRECT_BEYOND_M: f64 = 2e-4;
const END_BEYOND_M: f64 = 1e-3;
/// Largest change of a joint in one step, rad; more means the arm is about to lose the path.
const LARGEST_JOINT_STEP: f64 = 0.6;

/// A hand path as a person meets it: grip poses in the pelvis frame, and the usual posture at each.
///
/// The usual posture depends on the path and the model only, so all rollouts share it.
#[derive(Debug, Clone)]
pub struct HandPath {
    time_s: Vec<f64>,
    targets: Vec<Pose>,
    usual: Vec<UsualPosture>,
}

impl HandPath {
    /// For times (s) and as many grip poses in the pelvis frame.
    pub fn new(
        coupling: &Coupling,
        law: &PostureLaw,
        time_s: Vec<f64>,
        targets: Vec<Pose>,
    ) -> Self {
        let usual = law.attraction.as_ref().map_or_else(Vec::new, |a| {
            let at = |t: &Pose| {
                a.usual_posture(&coupling.looked_up(t, a.usual_orientation()), coupling.stature_m())
            };
            targets.iter().map(at).collect()
        });
        Self { time_s, targets, usual }
    }

    /// The grip at the start.
    pub fn start(&self) -> &Pose {
        &self.targets[0]
    }

    /// Grip poses in the pelvis frame, T+1.
    pub fn targets(&self) -> &[Pose] {
        &self.targets
    }

    /// The usual posture at a sample, n, rad; none without a pull.
    pub fn usual_posture(&self, index: usize) -> Option<&DVector<f64>> {
        self.usual.get(index).map(|u| &u.posture)
    }

    /// From the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().map_or(0.0, |t| t - self.time_s[0])
    }

    /// Number of samples, T+1.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Never true: a path has a start.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// Share of the samples that the training data do not support (confidence below one half); 0
    /// without an attraction.
    pub fn extrapolation_share(&self) -> f64 {
        let low = self.usual.iter().filter(|u| u.confidence < 0.5).count();
        low as f64 / self.usual.len().max(1) as f64
    }
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
}

/// Walks one person along a path of grip poses (pelvis frame) at times `time_s`; without a person,
/// the law's mean.
///
/// A person's noise is drawn for the samples of the path, so that candidates of one duration share it.
pub fn roll_out(
    coupling: &Coupling,
    law: &PostureLaw,
    path: &HandPath,
    start: &Start,
    person: Option<&Person>,
) -> Rollout {
    let first = start.q.clone().unwrap_or_else(|| DVector::zeros(law.dof()));
    let mut frames = Frames::default();
    let mut walk = Walk {
        coupling,
        law,
        usual: &path.usual,
        solver: StepSolver::new(law.weight.clone()),
        seen: coupling.observe(&first, &mut frames),
        frames,
        q: first,
    };
    let HandPath { time_s, targets, .. } = path;
    let linear = coupling.hold().linear_rows();
    let mut q = vec![walk.q.clone()];
    let mut reach_exceeded_at = start.q.is_none().then_some(0);
    let (mut max_m, mut sum_sq, mut max_rad) = (0.0f64, 0.0, 0.0f64);
    for k in 1..targets.len() {
        if reach_exceeded_at.is_none() {
            let span = time_s[k] - time_s[k - 1];
            let phase = (k - 1) as f64 / (targets.len() - 1) as f64;
            let leg = Leg { from: targets[k - 1], to: targets[k], span, index: k - 1, phase };
            match walk.advance(&leg, person) {
                Ok(error) => {
                    let metres = error.rows(0, linear).norm();
                    max_m = max_m.max(metres);
                    sum_sq += metres * metres;
                    max_rad = max_rad.max(error.rows_range(linear..).norm());
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
    }
}

/// From one path sample to the next.
struct Leg {
    from: Pose,
    to: Pose,
    span: f64,
    index: usize,
    phase: f64,
}

struct Walk<'a> {
    coupling: &'a Coupling,
    law: &'a PostureLaw,
    usual: &'a [UsualPosture],
    solver: StepSolver,
    frames: Frames,
    q: DVector<f64>,
    /// Of `q`.
    seen: Observation,
}

impl Walk<'_> {
    /// Moves to the end of a leg; the task error there.
    fn advance(
        &mut self,
        leg: &Leg,
        person: Option<&Person>,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let travel = pose_error(&leg.from, &leg.to);
        let mut steps = travel.fixed_rows::<3>(0).norm() / STEP_M;
        if self.coupling.hold().rows() > 3 {
            steps = steps.max(travel.fixed_rows::<3>(3).norm() / STEP_RAD);
        }
        let steps = steps.ceil().clamp(1.0, 200.0) as usize;
        let h = leg.span / steps as f64;
        // The path's own velocity: the hand's may differ in what the robot does not prescribe.
        let twist = self.law_twist(&(travel / leg.span));
        let primitive = self.law.primitive.as_ref().map(|p| p.at(leg.phase));
        if let Some((_, weight)) = &primitive {
            self.solver.set_weight(weight.clone());
        }
        let mut error = DVector::zeros(0);
        for step in 0..steps {
            let part = (step + 1) as f64 / steps as f64;
            let is_last = step + 1 == steps;
            let target = if is_last { leg.to } else { interpolate(&leg.from, &leg.to, part) };
            let mut task = self.coupling.task_error(&self.seen.pose, &target);
            task /= h;
            let done = step as f64 / steps as f64;
            let jacobian = &self.seen.jacobian;
            let at = Query { q: &self.q, xdot: &twist, jacobian, phase: leg.phase };
            let mut preferred = match person {
                Some(person) => person.preferred(self.law, &at, leg.index, done),
                None => self.law.preferred(at.q, at.xdot),
            };
            if let Some((mean, _)) = &primitive {
                preferred += mean;
            }
            self.pull(&mut preferred, leg.index, done);
            if self.law.is_direct {
                // A step that does not look at the hand: joints stop at their limits.
                let none = DMatrix::zeros(0, self.q.len());
                self.step(Some(&none), &DVector::zeros(0), &preferred, h)?;
                error = self.coupling.task_error(&self.seen.pose, &target);
            } else {
                self.step(None, &task, &preferred, h)?;
                error = self.correct(&target)?;
            }
        }
        Ok(error)
    }

    /// A twist as the law was trained: its rows, and speeds over stature.
    fn law_twist(&self, twist: &Vec6) -> DVector<f64> {
        let scale = self.law.stature_m / self.coupling.stature_m();
        let mut own = DVector::from_column_slice(&twist.as_slice()[..self.law.task_rows.min(6)]);
        let linear = own.len().min(3);
        own.rows_mut(0, linear).scale_mut(scale);
        own
    }

    /// Adds lambda c(x)^2 (m(x) - q), between two samples of the path, to a velocity (n, rad/s).
    fn pull(&self, velocity: &mut DVector<f64>, index: usize, part: f64) {
        let (Some(attraction), Some(a)) = (&self.law.attraction, self.usual.get(index)) else {
            return;
        };
        let b = self.usual.get(index + 1).unwrap_or(a);
        let rate = attraction.rate() * (a.trust() + part * (b.trust() - a.trust()));
        let usual = a.posture.iter().zip(&b.posture);
        for ((v, (a, b)), q) in velocity.iter_mut().zip(usual).zip(&self.q) {
            *v += rate * (a * (1.0 - part) + b * part - q);
        }
    }

    /// Moves for a time h (s) and looks where the hand is; `jacobian` in the place of the task's.
    fn step(
        &mut self,
        jacobian: Option<&DMatrix<f64>>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        h: f64,
    ) -> Result<(), ReachExceeded> {
        let limits = self.coupling.limits();
        let jacobian = jacobian.unwrap_or(&self.seen.jacobian);
        let qdot = self.solver.solve(&self.q, jacobian, task, preferred, limits, h)?;
        if qdot.amax() * h > LARGEST_JOINT_STEP {
            return Err(ReachExceeded);
        }
        self.q.axpy(h, &qdot, 1.0);
        self.coupling.observe_again(&self.q, &mut self.frames, &mut self.seen);
        Ok(())
    }

    /// Newton corrections when the curvature of the step has taken the hand off the path.
    fn correct(&mut self, target: &Pose) -> Result<DVector<f64>, ReachExceeded> {
        let linear = self.coupling.hold().linear_rows();
        for _ in 0..4 {
            let error = self.coupling.task_error(&self.seen.pose, target);
            let metres = error.rows(0, linear).norm();
            let radians = error.rows_range(linear..).norm();
            if metres <= CORRECT_BEYOND_M && radians <= 4.0 * CORRECT_BEYOND_M {
                return Ok(error);
            }
            let still = DVector::zeros(self.q.len());
            self.step(None, &error, &still, 1.0)?;
        }
        let error = self.coupling.task_error(&self.seen.pose, target);
        if error.rows(0, linear).norm() > END_BEYOND_M { Err(ReachExceeded) } else { Ok(error) }
    }
}

//! How any simulated person keeps the hand on its path: small steps, each closed on the path.
//!
//! A [`Law`] says by how much the joints would move if left alone and how easily each gives way; the
//! hand's constraint is met by the same conditioned step as in a rollout of a model. A step has no unit
//! of time: a law may count metres of hand travel, seconds, or both. Written without the learner's
//! rollouts, so that a change there does not change the truth.

use crate::kinematics::Frames;
use crate::math::Pose;
use crate::math::pose::{interpolate, pose_error};
use crate::posture::{Coupling, Rollout, Start, StepSolver};
use nalgebra::{DMatrix, DVector};

/// Longest step of the hand, m; a turn counts with [`TURN_LENGTH_M`].
const STEP_M: f64 = 0.008;
/// Length by which a turn of the hand counts like a displacement, m/rad.
const TURN_LENGTH_M: f64 = 0.3;
/// Residual of the hand beyond which it is corrected, and beyond which the path is lost, m.
const CORRECT_BEYOND_M: f64 = 1e-4;
const LOST_BEYOND_M: f64 = 1e-3;
/// Largest change of a joint in one step, rad: more means that the arm is about to lose the path.
const LARGEST_JOINT_STEP: f64 = 0.6;
const CORRECTIONS: usize = 6;

/// Where somebody is within a movement: a small step of the hand.
#[derive(Debug)]
pub(super) struct Moment<'a> {
    /// Joint angles before the step, n, rad.
    pub q: &'a DVector<f64>,
    /// Grip before and after the step, pelvis frame.
    pub from: Pose,
    pub to: Pose,
    /// How far the hand goes, m, turns included.
    pub travel_m: f64,
    /// How long it takes, s.
    pub span_s: f64,
}

/// How somebody uses the freedom that the hand leaves.
pub(super) trait Law {
    /// Called before the small steps of each leg, from one sample of the path to the next, of
    /// `travel_m` (m) and `span_s` (s): draws what chance adds. The number of draws must not depend on
    /// the path, so that the same repetition meets every path alike.
    fn begin_leg(&mut self, travel_m: f64, span_s: f64);

    /// Change of the joints that the person would like in a step, n, rad.
    fn wish(&mut self, at: &Moment) -> DVector<f64>;

    /// How easily the joints give way to the hand, n x n, positive definite, in any unit.
    fn ease(&self) -> &DMatrix<f64>;

    /// Where the person would be at the start with the hand at `hand` (n, rad), given the drawn start.
    fn settled(&mut self, start: &DVector<f64>, hand: &Pose) -> DVector<f64>;
}

/// One repetition along grip poses (pelvis frame) at times (s).
pub(super) fn follow(
    coupling: &Coupling,
    (time_s, targets): (&[f64], &[Pose]),
    start: &Start,
    law: &mut dyn Law,
) -> Rollout {
    let mut walk = Walk::new(coupling, start, law, &targets[0]);
    let mut q = vec![walk.q.clone()];
    let mut lost = start.q.is_none().then_some(0);
    let (mut largest, mut squares) = (0.0f64, 0.0);
    for k in 1..targets.len() {
        let leg = (targets[k - 1], targets[k], time_s[k] - time_s[k - 1]);
        law.begin_leg(travel_m(&leg.0, &leg.1), leg.2);
        if lost.is_none() {
            match walk.advance(leg, law) {
                Some(residual) => {
                    largest = largest.max(residual);
                    squares += residual * residual;
                }
                None => lost = Some(k),
            }
        }
        q.push(walk.q.clone());
    }
    let reached = lost.unwrap_or(targets.len()).max(1) as f64;
    Rollout {
        q,
        reach_exceeded_at: lost,
        max_residual_m: largest,
        rms_residual_m: (squares / reached).sqrt(),
        max_residual_rad: 0.0,
    }
}

/// Travel of the hand between two poses, m, turns included.
fn travel_m(from: &Pose, to: &Pose) -> f64 {
    let way = pose_error(from, to);
    let turn = way.fixed_rows::<3>(3).norm() * TURN_LENGTH_M;
    way.fixed_rows::<3>(0).norm().hypot(turn)
}

struct Walk<'a> {
    coupling: &'a Coupling,
    solver: StepSolver,
    frames: Frames,
    q: DVector<f64>,
}

impl<'a> Walk<'a> {
    /// Takes the drawn start and settles in the person's own way, the hand staying where it is.
    fn new(coupling: &'a Coupling, start: &Start, law: &mut dyn Law, hand: &Pose) -> Self {
        let q = start.q.clone().unwrap_or_else(|| DVector::zeros(coupling.dof()));
        let solver = StepSolver::new(law.ease().clone());
        let mut walk = Self { coupling, solver, frames: Frames::default(), q };
        if let Some(drawn) = &start.q {
            let aim = law.settled(drawn, hand);
            for left in (1..=4).rev() {
                let wish = (&aim - &walk.q) / f64::from(left);
                if walk.step(hand, &wish).and_then(|()| walk.correct(hand)).is_none() {
                    walk.q.clone_from(drawn);
                    break;
                }
            }
        }
        walk
    }

    /// Moves to the end of a leg; the residual of the hand there (m), none where it is lost.
    fn advance(&mut self, (from, to, span_s): (Pose, Pose, f64), law: &mut dyn Law) -> Option<f64> {
        let whole = travel_m(&from, &to);
        let steps = (whole / STEP_M).ceil().clamp(1.0, 200.0) as usize;
        let mut before = from;
        for step in 1..=steps {
            let part = step as f64 / steps as f64;
            let target = if step == steps { to } else { interpolate(&from, &to, part) };
            let wish = law.wish(&Moment {
                q: &self.q,
                from: before,
                to: target,
                travel_m: whole / steps as f64,
                span_s: span_s / steps as f64,
            });
            self.solver.set_weight(law.ease().clone());
            self.step(&target, &wish)?;
            before = target;
        }
        self.correct(&to)
    }

    fn step(&mut self, target: &Pose, wish: &DVector<f64>) -> Option<()> {
        let seen = self.coupling.observe(&self.q, &mut self.frames);
        let error = self.coupling.task_error(&seen.grips, &target.into());
        let limits = self.coupling.limits();
        let change = self.solver.solve(&self.q, &seen.jacobian, &error, wish, limits, 1.0).ok()?;
        if change.amax() > LARGEST_JOINT_STEP {
            return None;
        }
        self.q += change;
        Some(())
    }

    /// Newton corrections at the end of a leg; what is left of the hand's error, m.
    fn correct(&mut self, to: &Pose) -> Option<f64> {
        let still = DVector::zeros(self.q.len());
        let linear = self.coupling.linear_rows();
        for _ in 0..CORRECTIONS {
            let seen = self.coupling.observe(&self.q, &mut self.frames);
            let error = self.coupling.task_error(&seen.grips, &to.into());
            if error.amax() <= CORRECT_BEYOND_M {
                return Some(error.rows(0, linear).norm());
            }
            self.step(to, &still)?;
        }
        let seen = self.coupling.observe(&self.q, &mut self.frames);
        let left = self.coupling.task_error(&seen.grips, &to.into()).rows(0, linear).norm();
        (left <= LOST_BEYOND_M).then_some(left)
    }
}

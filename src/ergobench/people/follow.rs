//! How any simulated person keeps the hands on their path: small steps, each closed on the path.
//!
//! A [`Law`] says by how much the joints would move if left alone and how easily each gives way; the
//! hands' constraint, and what legs and balance of somebody who stands allow, are met by the same
//! conditioned step as in a rollout of a model. A step has no unit of time: a law may count metres of hand
//! travel, seconds, or both. Written without the learner's rollouts, so that a change there does not
//! change the truth.

use crate::kinematics::Frames;
use crate::math::pose::{interpolate, pose_error};
use crate::posture::{Allowed, Bounds, Coupling, Grips, Rollout, Start, StepSolver};
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
/// By how much a leg may be beyond its range before it is corrected, and before the path is lost, rad.
const CORRECT_LEG_BEYOND: f64 = 0.005;
const LOST_LEG_BEYOND: f64 = 0.017;
/// Bounds of legs and balance that one step can come to, m or rad.
const STEPWISE: f64 = 0.08;

/// Where somebody is within a movement: a small step of the hand.
#[derive(Debug)]
pub(super) struct Moment<'a> {
    /// Joint angles before the step, n, rad.
    pub q: &'a DVector<f64>,
    /// Grips before and after the step, rest frame.
    pub from: Grips,
    pub to: Grips,
    /// How far the hands go, m, turns included.
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

    /// How easily the joints give way to the hands, n x n, positive definite, in any unit.
    fn ease(&self) -> &DMatrix<f64>;

    /// Where the person would be at the start with the hands at `grips` (n, rad), given the drawn start.
    fn settled(&mut self, start: &DVector<f64>, grips: &Grips) -> DVector<f64>;
}

/// One repetition along grips (rest frame) at times (s).
pub(super) fn follow(
    coupling: &Coupling,
    (time_s, targets): (&[f64], &[Grips]),
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

/// Travel of the hands between two places, m, turns included; of two hands the root mean square.
fn travel_m(from: &Grips, to: &Grips) -> f64 {
    let (mut sum, mut hands) = (0.0f64, 0.0f64);
    for (from, to) in from.iter().zip(to.iter()) {
        let way = pose_error(from, to);
        let turn = way.fixed_rows::<3>(3).norm() * TURN_LENGTH_M;
        sum = sum.hypot(way.fixed_rows::<3>(0).norm().hypot(turn));
        hands += 1.0;
    }
    sum / hands.sqrt()
}

/// The grips part of the way from one place to another.
fn between(from: &Grips, to: &Grips, part: f64) -> Grips {
    from.zip(to, |a, b| interpolate(a, b, part))
}

struct Walk<'a> {
    coupling: &'a Coupling,
    solver: StepSolver,
    frames: Frames,
    bounds: Bounds,
    q: DVector<f64>,
}

impl<'a> Walk<'a> {
    /// Takes the drawn start and settles in the person's own way, the hands staying where they are.
    fn new(coupling: &'a Coupling, start: &Start, law: &mut dyn Law, hand: &Grips) -> Self {
        let q = start.q.clone().unwrap_or_else(|| DVector::zeros(coupling.dof()));
        let solver = StepSolver::new(law.ease().clone());
        let (frames, bounds) = (Frames::default(), Bounds::default());
        let mut walk = Self { coupling, solver, frames, bounds, q };
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
    fn advance(
        &mut self,
        (from, to, span_s): (Grips, Grips, f64),
        law: &mut dyn Law,
    ) -> Option<f64> {
        let whole = travel_m(&from, &to);
        let steps = (whole / STEP_M).ceil().clamp(1.0, 200.0) as usize;
        let mut before = from;
        for step in 1..=steps {
            let part = step as f64 / steps as f64;
            let target = if step == steps { to } else { between(&from, &to, part) };
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

    fn step(&mut self, target: &Grips, wish: &DVector<f64>) -> Option<()> {
        let seen = self.coupling.observe(&self.q, &mut self.frames);
        let error = self.coupling.task_error(&seen.grips, target);
        self.coupling.bounds(&self.frames, STEPWISE, &mut self.bounds);
        let allowed = Allowed { limits: self.coupling.limits(), bounds: &self.bounds };
        let change = self.solver.solve(&self.q, &seen.jacobian, &error, wish, allowed, 1.0).ok()?;
        if change.amax() > LARGEST_JOINT_STEP {
            return None;
        }
        self.q += change;
        Some(())
    }

    /// Newton corrections at the end of a leg; what is left of the hands' error, m.
    fn correct(&mut self, to: &Grips) -> Option<f64> {
        let still = DVector::zeros(self.q.len());
        let linear = self.coupling.linear_rows();
        for _ in 0..CORRECTIONS {
            let (error, (short_m, leg)) = self.left(to);
            if error.amax().max(short_m) <= CORRECT_BEYOND_M && leg <= CORRECT_LEG_BEYOND {
                return Some(error.rows(0, linear).norm());
            }
            self.step(to, &still)?;
        }
        let (error, (short_m, leg)) = self.left(to);
        let left = error.rows(0, linear).norm();
        (left.max(short_m) <= LOST_BEYOND_M && leg <= LOST_LEG_BEYOND).then_some(left)
    }

    /// What is left of the hands' error (rows of the task), and by how much legs are too short (m) and
    /// beyond their ranges (rad).
    fn left(&mut self, to: &Grips) -> (DVector<f64>, (f64, f64)) {
        let seen = self.coupling.observe(&self.q, &mut self.frames);
        let beyond = self.coupling.bounds(&self.frames, STEPWISE, &mut self.bounds);
        (self.coupling.task_error(&seen.grips, to), beyond)
    }
}

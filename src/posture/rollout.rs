//! Closed-loop rollouts: the posture that follows a hand path, one repetition at a time.
//!
//! ```text
//! dx   = x_d(next) - f(q)                closed on the path (paper, section V-C)
//! dz   = (process(q, dx / h) + e) h + pull over the step
//! dq   = dz + J_W^+ (dx - c - J dz)      under limits, by lock and resolve
//! ```
//! c is what the step itself bends away from the path, to second order.
//! h is the time of a step by the clock of the law ([`HandPath`] lays the steps out). By the hand's own
//! clock a posture depends on how far the hand has come and not on when: samples are read off between
//! two steps, and there the drift in true time comes on top, in the null space.
//! All poses are of the grips in the rest frame. Legs and balance bound the steps of a body that stands.

use super::coupling::{Coupling, Observation};
use super::grips::Grips;
use super::hand_path::{HandPath, Knot};
use super::law::{Draw, PostureLaw, Query};
use super::start::Start;
use super::step::{Allowed, Bounds, ReachExceeded, StepSolver};
use crate::kinematics::Frames;
use crate::math::Vec6;
use crate::math::pose::pose_error;
use nalgebra::{DMatrix, DVector};

/// Residual of the hand beyond which Newton corrections are made, and beyond which the rollout ends.
const CORRECT_BEYOND_M: f64 = 2e-4;
const END_BEYOND_M: f64 = 1e-3;
/// By how much a leg may be beyond its range (rad) before it is corrected, and before the rollout ends. It
/// may be too short by what the hand may be off.
const CORRECT_LEG_BEYOND: f64 = 0.005;
const END_LEG_BEYOND: f64 = 0.017;
/// Largest change of a joint in one step, rad; more means the arm is about to lose the path.
const LARGEST_JOINT_STEP: f64 = 0.6;

/// Bounds that one step can come to, m or rad.
const STEPWISE: f64 = 0.08;

/// One repetition of one person along one path.
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

/// One repetition along a path; without a draw, the law's mean.
pub fn roll_out(
    coupling: &Coupling,
    law: &PostureLaw,
    path: &HandPath,
    start: &Start,
    draw: Option<&Draw>,
) -> Rollout {
    let mut seen = Seen::new(path, coupling.linear_rows());
    let Some(first) = &start.q else {
        return seen.finish(&DVector::zeros(law.dof()), Some(0));
    };
    let mut frames = Frames::default();
    let here = Spot {
        seen: coupling.observe(first, &mut frames),
        q: first.clone(),
        number: 0,
        frames,
        bounds: Bounds::default(),
        beyond: None,
    };
    let mut state = State {
        coupling,
        law,
        path,
        draw,
        solver: StepSolver::new(law.weight.clone()),
        looks: 0,
        aside: here.clone(),
        here,
        before: first.clone(),
        error: DVector::zeros(coupling.rows()),
    };
    // Samples before the hand has moved, then those of each step.
    let mut lost = seen.read(&mut state, 0, true).is_err();
    for step in 0..path.knots().len() - 1 {
        if lost {
            break;
        }
        lost = state.advance(step).and_then(|()| seen.read(&mut state, step, false)).is_err();
    }
    let exceeded_at = lost.then_some(seen.q.len());
    seen.finish(first, exceeded_at)
}

/// The samples of a path that were reached.
struct Seen<'a> {
    path: &'a HandPath,
    linear: usize,
    q: Vec<DVector<f64>>,
    max_m: f64,
    sum_sq: f64,
    max_rad: f64,
}

impl<'a> Seen<'a> {
    fn new(path: &'a HandPath, linear: usize) -> Self {
        let q = Vec::with_capacity(path.len());
        Self { path, linear, q, max_m: 0.0, sum_sq: 0.0, max_rad: 0.0 }
    }

    /// Reads off the samples of a step, or those before it.
    fn read(&mut self, state: &mut State, step: usize, before: bool) -> Result<(), ReachExceeded> {
        while let Some((own, part)) = self.path.place(self.q.len()) {
            if own != step || (before && part > 0.0) {
                break;
            }
            let (q, error) = state.sample(self.q.len(), part)?;
            let metres = error.rows(0, self.linear).norm();
            self.max_m = self.max_m.max(metres);
            self.sum_sq += metres * metres;
            self.max_rad = self.max_rad.max(error.rows_range(self.linear..).norm());
            self.q.push(q);
        }
        Ok(())
    }

    fn finish(mut self, first: &DVector<f64>, exceeded_at: Option<usize>) -> Rollout {
        let reached = self.q.len().max(1);
        let last = self.q.last().unwrap_or(first).clone();
        self.q.resize(self.path.len(), last);
        Rollout {
            q: self.q,
            reach_exceeded_at: exceeded_at,
            max_residual_m: self.max_m,
            rms_residual_m: (self.sum_sq / reached as f64).sqrt(),
            max_residual_rad: self.max_rad,
        }
    }
}

/// A posture and what is known there.
#[derive(Clone)]
struct Spot {
    q: DVector<f64>,
    /// Another one whenever it is looked at.
    number: u64,
    seen: Observation,
    frames: Frames,
    /// What legs and balance allow, where it was looked at.
    bounds: Bounds,
    /// By how much legs are beyond it, m and rad; none where it was not looked at.
    beyond: Option<(f64, f64)>,
}

impl Spot {
    fn look(&mut self, coupling: &Coupling, looks: &mut u64) {
        *looks += 1;
        self.number = *looks;
        coupling.observe_again(&self.q, &mut self.frames, &mut self.seen);
        self.beyond = None;
    }

    fn bound(&mut self, coupling: &Coupling) -> (f64, f64) {
        let Self { beyond, frames, bounds, .. } = self;
        *beyond.get_or_insert_with(|| coupling.bounds(frames, STEPWISE, bounds))
    }
}

struct State<'a> {
    coupling: &'a Coupling,
    law: &'a PostureLaw,
    path: &'a HandPath,
    draw: Option<&'a Draw<'a>>,
    solver: StepSolver,
    /// How often a posture was looked at.
    looks: u64,
    /// At the knots before and after the step.
    before: DVector<f64>,
    here: Spot,
    /// How far the hand is from the knot.
    error: DVector<f64>,
    /// Scratch, for samples between knots.
    aside: Spot,
}

impl State<'_> {
    /// Steps from one knot to the next.
    fn advance(&mut self, step: usize) -> Result<(), ReachExceeded> {
        let [a, b] = [&self.path.knots()[step], &self.path.knots()[step + 1]];
        self.before.copy_from(&self.here.q);
        let primitive = self.law.primitive.as_ref().map(|p| p.at(a.phase));
        if let Some((_, weight)) = &primitive {
            self.solver.set_weight(weight.clone());
        }
        let mean = primitive.as_ref().map(|(mean, _)| mean);
        let wish = self.wish(a, b, mean);
        if self.law.is_direct {
            // A step that does not look at the hand: joints stop at their limits.
            let none = DMatrix::zeros(0, self.here.q.len());
            self.step(Some(&none), &DVector::zeros(0), &wish)?;
            self.error = self.coupling.task_error(&self.here.seen.grips, &b.target);
        } else {
            let task = self.coupling.task_error(&self.here.seen.grips, &b.target);
            self.step(None, &task, &wish)?;
            self.error = self.correct(&b.target, Spot::bound)?;
        }
        Ok(())
    }

    /// How the posture would move from knot `a` to `b` if the task let it, n, rad.
    fn wish(&self, a: &Knot, b: &Knot, primitive: Option<&DVector<f64>>) -> DVector<f64> {
        let h = b.clock_s - a.clock_s;
        // The path's own velocity: the hand's may differ in what the robot does not prescribe.
        let twist = self.law_twist(&(pose_error(&a.target.first, &b.target.first) / h));
        let at = Query {
            q: &self.here.q,
            xdot: &twist,
            jacobian: &self.here.seen.jacobian,
            phase: a.phase,
        };
        let mut wish = match self.draw {
            Some(draw) => draw.preferred(self.law, &at, a.noise, a.gains.as_ref()),
            None => self.law.preferred(at.q, at.xdot),
        };
        if let Some(mean) = primitive {
            wish += mean;
        }
        wish *= h;
        if let (Some(pull), Some(from), Some(to)) = (&self.law.attraction, &a.usual, &b.usual) {
            let own = |knot: &Knot| self.draw.and_then(|draw| draw.own_at(knot.height));
            pull.add_pull(
                &mut wish,
                (from, to),
                (&self.here.q, own(a).as_deref(), own(b).as_deref()),
                (b.travel_m - a.travel_m, h),
            );
        }
        wish
    }

    /// The posture (n, rad) at a sample, `part` of the step behind, and the task error there.
    fn sample(
        &mut self,
        index: usize,
        part: f64,
    ) -> Result<(DVector<f64>, DVector<f64>), ReachExceeded> {
        let drift = self.draw.and_then(|d| d.drifted(self.path.time_s(index)));
        let is_knot = part == 1.0 || self.path.knots().len() < 2;
        if index == 0 || (is_knot && drift.is_none()) {
            return Ok((self.here.q.clone(), self.error.clone()));
        }
        let target = &self.path.targets()[index];
        // From the knot, which is less than a step away: back along the step, and aside by the drift.
        let mut change =
            if is_knot { DVector::zeros(self.before.len()) } else { &self.before - &self.here.q };
        change *= 1.0 - part;
        let task = if self.law.is_direct {
            &self.here.seen.jacobian * &change
        } else {
            self.coupling.task_error(&self.here.seen.grips, target)
        };
        if let Some(drift) = drift {
            change += drift;
        }
        let change = self.change(None, &task, &change)?;
        // Look from there, and come back to the knot.
        std::mem::swap(&mut self.here, &mut self.aside);
        self.here.q = &self.aside.q + change;
        self.here.look(self.coupling, &mut self.looks);
        let error = if self.law.is_direct {
            Ok(self.coupling.task_error(&self.here.seen.grips, target))
        } else {
            // The bounds are needed only where a step follows.
            self.correct(target, |here, coupling| coupling.legs_beyond(&here.frames))
        };
        let q = self.here.q.clone();
        std::mem::swap(&mut self.here, &mut self.aside);
        error.map(|e| (q, e))
    }

    /// A twist as the law was trained: its rows, and speeds over stature.
    fn law_twist(&self, twist: &Vec6) -> DVector<f64> {
        let scale = self.law.stature_m / self.coupling.stature_m();
        let mut own = DVector::from_column_slice(&twist.as_slice()[..self.law.task_rows.min(6)]);
        let linear = own.len().min(3);
        own.rows_mut(0, linear).scale_mut(scale);
        own
    }

    /// Moves on and looks where the hand is; `jacobian` in the place of the task's.
    fn step(
        &mut self,
        jacobian: Option<&DMatrix<f64>>,
        task: &DVector<f64>,
        wish: &DVector<f64>,
    ) -> Result<(), ReachExceeded> {
        let moved = self.change(jacobian, task, wish)?;
        if moved.amax() > LARGEST_JOINT_STEP {
            return Err(ReachExceeded);
        }
        self.here.q += moved;
        self.here.look(self.coupling, &mut self.looks);
        Ok(())
    }

    /// The change of the posture (n, rad) that does the task from here; `jacobian` in the place of the task's.
    fn change(
        &mut self,
        jacobian: Option<&DMatrix<f64>>,
        task: &DVector<f64>,
        wish: &DVector<f64>,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let Self { coupling, solver, here, .. } = self;
        here.bound(coupling);
        let allowed = Allowed { limits: coupling.limits(), bounds: &here.bounds };
        if self.law.is_direct {
            let jacobian = jacobian.unwrap_or(&here.seen.jacobian);
            return solver.solve(&here.q, jacobian, task, wish, allowed, 1.0);
        }
        let beyond = |change: &DVector<f64>| coupling.curvature(&here.frames, &here.seen, change);
        let from = (&here.q, here.number);
        solver.solve_curved(from, (&here.seen.jacobian, beyond), task, wish, allowed)
    }

    /// Newton corrections when the curvature of the step has taken the hand off the path, or a leg that it
    /// stretched beyond its range.
    fn correct(
        &mut self,
        target: &Grips,
        legs_beyond: fn(&mut Spot, &Coupling) -> (f64, f64),
    ) -> Result<DVector<f64>, ReachExceeded> {
        let linear = self.coupling.linear_rows();
        for left in (0..5).rev() {
            let error = self.coupling.task_error(&self.here.seen.grips, target);
            let metres = error.rows(0, linear).norm();
            let radians = error.rows_range(linear..).norm();
            let (short_m, leg) = legs_beyond(&mut self.here, self.coupling);
            let metres = metres.max(short_m);
            if metres <= CORRECT_BEYOND_M
                && radians <= 4.0 * CORRECT_BEYOND_M
                && leg <= CORRECT_LEG_BEYOND
            {
                return Ok(error);
            }
            if left == 0 {
                let is_lost = metres > END_BEYOND_M || leg > END_LEG_BEYOND;
                return if is_lost { Err(ReachExceeded) } else { Ok(error) };
            }
            let still = DVector::zeros(self.here.q.len());
            self.step(None, &error, &still)?;
        }
        Err(ReachExceeded)
    }
}

//! The nearest path that keeps all limits: programs of growing sets of rows, until nothing is broken.
//!
//! Rows enter only where a limit is in play: the speed at the steps where the reference or a solution comes
//! near it, acceleration, jerk and faces of the box when the reference or a solution breaks them, corridor
//! and reach at the steps that leave them, half-spaces at the steps that come near an obstacle, linearised
//! again at each solution. A path that keeps what was left out is the nearest all the same. Of each
//! solution the jerks are integrated exactly, the gap at the goal is closed, and the limits are
//! measured on hulls, so that what is handed out keeps them between the knots too.

use super::hull::{breaks_acceleration, breaks_jerk, closing, crossed_faces, integrated, too_fast};
use super::keepout::{Hulls, planes};
use super::limits::{Box3, PathLimits};
use super::project::ProjectionSettings;
use super::refusal::NoAnswer;
use super::scene::{Order, Scene};
use super::smooth::SmoothPath;
use super::stencil::position_hull;
use super::transcription::{Ball, Plane, ROBOT, Rows, SLACK_COST, Task, at_knot};
use crate::math::Vec3;
use crate::qp::{Culprit, Outcome, Problem, Residuals, residuals, solve};
use std::collections::BTreeSet;

/// Shares below the limits that are tried; the second only if rounding ate the first.
const MARGINS: [f64; 2] = [1e-6, 1e-4];
/// Largest excess that counts as rounding, m.
const ROUNDING_M: f64 = 5e-10;
/// Balls are smaller than asked by this, for the rounding of the solution, m.
const HAIR_M: f64 = 1e-6;
/// Programs solved at most.
const MOST_PASSES: usize = 14;
/// Passes after which a path that keeps its distances is good enough.
const PATIENCE: usize = 4;
/// Share of the speed limit from which a step of the reference has a row, and steps on either side that get
/// one too.
const NEAR_SPEED: f64 = 0.9;
const AROUND: usize = 2;
/// Change of the path (m) below which a new linearisation is not worth a pass.
const SETTLED_M: f64 = 1e-3;
/// How much dearer the slack is of what is not being relaxed.
const DEARER: f64 = 30.0;

/// What is asked.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    /// Reference positions at the T + 1 knots, m.
    pub(super) reference: &'a [Vec3],
    pub(super) step_s: f64,
    pub(super) limits: &'a PathLimits,
    pub(super) scene: &'a Scene<'a>,
    pub(super) settings: &'a ProjectionSettings,
    /// One slack for each elastic thing, and this one cheaper than the others: how much would it
    /// have to give?
    pub(super) relaxed: Option<Elastic>,
}

/// A thing whose rows are elastic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Elastic {
    /// Obstacle by index.
    Obstacle(usize),
    /// The corridor about the reference.
    Corridor,
    /// Reach by index.
    Reach(usize),
}

/// By how much an elastic thing is not kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shortfall {
    pub(super) of: Elastic,
    pub(super) by_m: f64,
    pub(super) step: usize,
}

/// A path within the limits.
pub(super) struct Answer {
    pub(super) jerk: Vec<Vec3>,
    pub(super) iterations: u32,
    pub(super) optimality: Residuals,
    /// Size of the multipliers, at least 1: what the residuals are compared with.
    pub(super) multipliers: f64,
}

/// Why the programs gave no path.
pub(super) enum Refusal {
    /// Limits that are not elastic contradict each other.
    Contradiction(Vec<Culprit>),
    /// A path exists only if these give way.
    Elastic(Vec<Shortfall>),
    /// No answer.
    NoAnswer(NoAnswer),
}

/// The rows in play, and the slacks behind them.
struct Play<'a> {
    question: Question<'a>,
    rows: Rows,
    clearances: Vec<f64>,
    /// Steps of corridor and reaches that have rows.
    balls: BTreeSet<(Elastic, usize)>,
    /// A solution was too fast where no row said so.
    was_too_fast: bool,
    /// What each slack stands for: the thing, and the step unless it has one slack.
    slacks: Vec<(Elastic, usize)>,
}

/// Solves for the jerks.
pub(super) fn solve_within(question: &Question) -> Result<Answer, Refusal> {
    let mut play = Play::new(*question);
    let mut curve = Hulls::of(&play.reference_coefficients());
    let mut margins = MARGINS.iter();
    let mut margin = *margins.next().unwrap_or(&0.0);
    let mut spent = 0;
    let mut shortfalls = Vec::new();
    for pass in 1..=MOST_PASSES {
        play.refresh(&curve);
        let (task_rows, settings) = (&play.rows, question.settings);
        let task = Task {
            reference: question.reference,
            step_s: question.step_s,
            limits: question.limits,
            jerk_weight: settings.jerk_weight,
            margin,
            rows: task_rows,
        };
        let problem = task.problem();
        let (x, z, iterations) = solution(&problem)?;
        spent += iterations;
        let (first, last) =
            (question.reference[0], question.reference[question.reference.len() - 1]);
        let jerk = closing(&first, &last, question.step_s, task.jerks(&x));
        let given = play.given(&task.slacks(&x));
        let path = integrated(&first, question.step_s, jerk);
        let before = std::mem::replace(&mut curve, Hulls::of(&coefficients(&path)));
        let moved = (0..curve.steps()).map(|k| (curve.hull(k)[3] - before.hull(k)[3]).norm());
        let is_settled = moved.fold(0.0, f64::max) < SETTLED_M;
        let hard = play.add_broken_limits(&path);
        if hard == Broken::New {
            continue;
        }
        if hard == Broken::Again {
            match margins.next() {
                Some(next) => margin = *next,
                None => {
                    return Err(Refusal::NoAnswer(NoAnswer::Inaccurate));
                }
            }
            continue;
        }
        let (is_new, found) = play.measure_elastic(&curve);
        let has_obstacles = !play.rows.planes.iter().all(|p| p.slack.is_none());
        if question.relaxed.is_some() && !is_new && (is_settled || pass > 2 * PATIENCE) {
            return Err(Refusal::Elastic(given));
        }
        if found.is_empty() && (!has_obstacles || is_settled || pass >= PATIENCE) {
            let optimality = residuals(&problem, &x, &z).unwrap_or_default();
            let multipliers = z.iter().map(|v| v.abs()).fold(1.0, f64::max);
            return Ok(Answer { jerk: path.jerk, iterations: spent, optimality, multipliers });
        }
        if !found.is_empty() && !is_new && is_settled && pass > 2 {
            return Err(Refusal::Elastic(found));
        }
        shortfalls = found;
    }
    Err(if shortfalls.is_empty() {
        Refusal::NoAnswer(NoAnswer::NotSettled)
    } else {
        Refusal::Elastic(shortfalls)
    })
}

/// Whether a reference breaks the limits of acceleration and jerk, by differences: the nearest path
/// is then likely to need their rows, and a program without them would be solved in vain.
fn hurries(reference: &[Vec3], step_s: f64, limits: &PathLimits) -> [bool; 2] {
    let chords: Vec<Vec3> = reference.windows(2).map(|w| (w[1] - w[0]) / step_s).collect();
    let changes: Vec<Vec3> = chords.windows(2).map(|w| (w[1] - w[0]) / step_s).collect();
    let mut jerks = changes.windows(2).map(|w| (w[1] - w[0]).amax() / step_s);
    [
        changes.iter().any(|a| a.norm() > limits.acceleration_m_s2),
        jerks.any(|j| j > limits.jerk_m_s3),
    ]
}

/// A step and its neighbours.
fn around(step: usize, steps: usize) -> std::ops::Range<usize> {
    step.saturating_sub(AROUND)..(step + AROUND + 1).min(steps)
}

/// Whether limits that are not elastic are broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Broken {
    Not,
    /// And rows for them have been added.
    New,
    /// Although they have rows.
    Again,
}

fn solution(problem: &Problem) -> Result<(Vec<f64>, Vec<f64>, u32), Refusal> {
    match solve(problem) {
        Outcome::Solved { x, z, iterations, .. } => Ok((x, z, iterations)),
        Outcome::PrimalInfeasible { culprits } => Err(Refusal::Contradiction(culprits)),
        Outcome::DualInfeasible => Err(Refusal::NoAnswer(NoAnswer::Unbounded)),
        Outcome::NotConverged { status } => {
            let status = format!("{status:?}");
            Err(Refusal::NoAnswer(NoAnswer::Stopped { status }))
        }
    }
}

/// Spline coefficients of a path: the knot, less a sixth of the change of the chord there.
fn coefficients(path: &SmoothPath) -> Vec<Vec3> {
    let (h, steps) = (path.step_s, path.steps());
    let at = |k: usize| path.position[k] - path.acceleration[k] * (h * h / 6.0);
    let mut all = vec![at(0) - path.velocity[0] * h];
    all.extend((0..=steps).map(at));
    all.push(at(steps) + path.velocity[steps] * h);
    all
}

impl<'a> Play<'a> {
    fn new(question: Question<'a>) -> Self {
        let Question { reference, limits, scene, .. } = question;
        let ends = [&reference[0], &reference[reference.len() - 1]];
        let clearances =
            (0..scene.obstacles.len()).map(|i| scene.clearance_m(i, limits, ends)).collect();
        let is_outside = |&(axis, is_upper): &(usize, bool)| {
            let inner = limits.workspace.as_ref();
            inner.is_some_and(|b| reference.iter().any(|p| b.excess(p, axis, is_upper) > 0.0))
        };
        let faces = Box3::faces().filter(is_outside).collect();
        let [acceleration, jerk] = hurries(reference, question.step_s, limits);
        let near = NEAR_SPEED * limits.speed_m_s * question.step_s;
        let is_fast = |k: &usize| (reference[k + 1] - reference[*k]).norm() > near;
        let steps = reference.len() - 1;
        let speed = Some((0..steps).filter(is_fast).flat_map(|k| around(k, steps)).collect());
        let rows = Rows { speed, acceleration, jerk, faces, ..Rows::default() };
        let (balls, slacks) = (BTreeSet::new(), Vec::new());
        Self { question, rows, clearances, balls, was_too_fast: false, slacks }
    }

    /// Spline coefficients that rest on the reference.
    fn reference_coefficients(&self) -> Vec<Vec3> {
        let r = self.question.reference;
        let last = r.len() - 1;
        let at = |i: usize| match i {
            0..=2 => r[0],
            i if i >= last => r[last],
            i => r[i - 1],
        };
        (0..last + 3).map(at).collect()
    }

    /// Rows at the present curve.
    fn refresh(&mut self, curve: &Hulls) {
        self.rows.planes.clear();
        self.rows.balls.clear();
        self.rows.slacks.clear();
        self.slacks.clear();
        let scene = self.question.scene;
        for (i, clearance) in self.clearances.clone().into_iter().enumerate() {
            for (step, plane) in planes(scene, i, clearance, curve) {
                let slack = Some(self.slack(Elastic::Obstacle(i), step));
                self.rows.planes.push(Plane { slack, ..plane });
            }
        }
        // Corridor and reach are nearly as many rows as the speed: without it nothing is gained, and the solver
        // was seen to stop less exactly.
        if !self.balls.is_empty() {
            self.rows.speed = None;
        }
        for (of, step) in self.balls.clone() {
            let slack = self.slack(of, step);
            self.push_balls(of, step, slack);
        }
        let last = self.question.reference.len() - 1;
        for c in scene.conditions.iter().filter(|c| (1..last).contains(&c.knot)) {
            let (at, label) = (at_knot(c.order, c.knot), ROBOT.to_owned());
            let (order, normal, bound) = (c.order, c.normal, c.bound);
            self.rows.planes.push(Plane { label, at, order, normal, bound, slack: None });
        }
    }

    /// The slack of a thing at a step; one for all its steps when something is relaxed.
    fn slack(&mut self, of: Elastic, step: usize) -> usize {
        let key = (of, if self.question.relaxed.is_some() { 0 } else { step });
        if let Some(i) = self.slacks.iter().rposition(|s| *s == key) {
            return i;
        }
        self.slacks.push(key);
        let is_dear = self.question.relaxed.is_some_and(|r| r != of);
        self.rows.slacks.push(if is_dear { DEARER * SLACK_COST } else { SLACK_COST });
        self.slacks.len() - 1
    }

    fn push_balls(&mut self, of: Elastic, step: usize, slack: usize) {
        let Question { reference, limits, scene, .. } = self.question;
        let chord = (reference[step], reference[step + 1]);
        for (at, s) in position_hull(step).into_iter().zip([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]) {
            let (label, center, radius) = if let Elastic::Reach(i) = of {
                let reach = &scene.reaches[i];
                (format!("reach of `{}`", reach.body), reach.center, reach.radius_m)
            } else {
                let radius = limits.corridor_m.unwrap_or(f64::INFINITY);
                ("corridor".to_owned(), chord.0.lerp(&chord.1, s), radius)
            };
            let radius = (radius - HAIR_M).max(0.0);
            self.rows.balls.push(Ball { label, at, center, radius, slack });
        }
    }

    /// What each elastic thing gives way by, from the slacks of a solution.
    fn given(&self, slacks: &[f64]) -> Vec<Shortfall> {
        let with = self.slacks.iter().zip(slacks);
        with.filter(|(_, by)| **by > HAIR_M)
            .map(|(&(of, step), &by_m)| Shortfall { of, by_m, step })
            .collect()
    }

    fn add_broken_limits(&mut self, path: &SmoothPath) -> Broken {
        let limits = self.question.limits;
        let crossed = crossed_faces(path, limits);
        let is_known = |f: &(usize, bool)| self.rows.faces.contains(f);
        let new: Vec<_> = crossed.iter().filter(|f| !is_known(f)).copied().collect();
        let (acceleration, jerk) = (breaks_acceleration(path, limits), breaks_jerk(path, limits));
        let adds_acceleration = acceleration && !self.rows.acceleration;
        let adds_jerk = jerk && !self.rows.jerk;
        let fast = too_fast(path, limits);
        let adds_speed = self.add_speed(&fast, path.steps());
        if !new.is_empty() || adds_acceleration || adds_jerk || adds_speed {
            self.rows.faces.extend(new);
            self.rows.acceleration |= acceleration;
            self.rows.jerk |= jerk;
            return Broken::New;
        }
        let is_broken = !crossed.is_empty() || acceleration || jerk || !fast.is_empty();
        if is_broken || !self.keeps_conditions(path) { Broken::Again } else { Broken::Not }
    }

    /// Rows for steps that are too fast, the second time for all; true when there are new ones.
    fn add_speed(&mut self, fast: &[usize], steps: usize) -> bool {
        let Some(speed) = &mut self.rows.speed else { return false };
        if fast.iter().all(|k| speed.contains(k)) {
            return false;
        }
        if self.was_too_fast {
            self.rows.speed = None;
        } else {
            speed.extend(fast.iter().flat_map(|k| around(*k, steps)));
        }
        self.was_too_fast = true;
        true
    }

    /// The robot's conditions, to a millionth.
    fn keeps_conditions(&self, path: &SmoothPath) -> bool {
        self.question.scene.conditions.iter().all(|c| {
            let state = match c.order {
                Order::Position => &path.position,
                Order::Velocity => &path.velocity,
                Order::Acceleration => &path.acceleration,
            };
            let is_end = c.knot == 0 || c.knot >= path.steps();
            is_end || c.normal.dot(&state[c.knot]) <= c.bound + 1e-6 * (1.0 + c.bound.abs())
        })
    }

    /// What elastic thing the curve breaks, the worst of each; true when rows have been added.
    fn measure_elastic(&mut self, curve: &Hulls) -> (bool, Vec<Shortfall>) {
        let Question { reference, limits, scene, .. } = self.question;
        let mut found = Vec::new();
        for (i, (_, obstacle)) in scene.obstacles.iter().enumerate() {
            let (by_m, step) = curve.intrusion(obstacle, self.clearances[i]);
            found.push(Shortfall { of: Elastic::Obstacle(i), by_m, step });
        }
        let mut is_new = false;
        let mut ball = |of: Elastic, radius: f64, center: &dyn Fn(usize, f64) -> Vec3| {
            let mut worst = Shortfall { of, by_m: f64::NEG_INFINITY, step: 0 };
            for step in 0..curve.steps() {
                let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
                let far =
                    curve.hull(step).iter().zip(thirds).map(|(p, s)| (p - center(step, s)).norm());
                let by_m = far.fold(0.0, f64::max) - radius;
                if by_m > ROUNDING_M {
                    // The neighbours too: they are where the curve is pushed to.
                    for near in step.saturating_sub(1)..(step + 2).min(curve.steps()) {
                        is_new |= self.balls.insert((of, near));
                    }
                }
                if by_m > worst.by_m {
                    worst = Shortfall { of, by_m, step };
                }
            }
            found.push(worst);
        };
        if let Some(radius) = limits.corridor_m {
            ball(Elastic::Corridor, radius, &|k, s| reference[k].lerp(&reference[k + 1], s));
        }
        for (i, reach) in scene.reaches.iter().enumerate() {
            ball(Elastic::Reach(i), reach.radius_m, &|_, _| reach.center);
        }
        found.retain(|s| s.by_m > ROUNDING_M);
        (is_new, found)
    }
}

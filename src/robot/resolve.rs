//! The global choice of redundancy and branch by dynamic programming.
//!
//! ```text
//! layers   some knots of the path; at each a set of postures that hold the pose there: every branch
//!          that random starts find, carried to the neighbours, and steps along the self-motion
//! edges    joint motions that the speed limits allow between two layers
//! cost     per posture: limits, singular values, clearance;  per edge: (dq / (qd_max dt))^2
//! refine   the cheapest chain, smoothed, as first guesses of inverse kinematics at every knot
//! ```
//! The usual check decides. Where it refuses, the edge there is struck out and the next best chain is
//! tried. Deterministic: random postures are named by layer and number.

use super::between::spline_at;
use super::check::{RobotMotion, assess};
use super::collide::random_posture;
use super::description::Robot;
use super::ease::Ease;
use super::follow::FollowSettings;
use super::grade::Judge;
use super::ik::{Residual, Solver};
use crate::math::Pose;

/// Layers, random starts at each, and most postures of one.
const LAYERS: usize = 17;
const SEEDS: u32 = 20;
const NODES: usize = 200;
/// Steps of inverse kinematics from far and from near.
const COLD_STEPS: usize = 60;
const WARM_STEPS: usize = 20;
/// Length of a step along the self-motion, rad, and most of them in one direction.
const STRIDE: f64 = 0.15;
const STRIDES: usize = 40;
/// Distance below which two postures are the same, rad.
const SAME: f64 = 0.08;
/// Chains that are refined before giving up, and how often each is smoothed.
const CHAINS: usize = 8;
const SMOOTHED: [usize; 3] = [3, 0, 10];
/// Block of random numbers of the first layer.
const BLOCK: u32 = 1 << 21;

/// A posture at a layer.
#[derive(Debug, Clone)]
struct Node {
    q: Vec<f64>,
    cost: f64,
}

/// The graph of one path.
struct Graph<'r> {
    robot: &'r Robot,
    /// Index of the knot of each layer.
    knots: Vec<usize>,
    /// Times of the layers, s.
    time_s: Vec<f64>,
    /// Poses of the layers, base frame.
    targets: Vec<Pose>,
    layers: Vec<Vec<Node>>,
    /// Edges that the check has refused: layer, from, to.
    struck: Vec<(usize, usize, usize)>,
}

/// A motion along poses of the TCP (base frame) that keeps all limits and does not touch the arm
/// itself, if the graph holds one.
pub(super) fn resolve(
    robot: &Robot,
    time_s: &[f64],
    targets: &[Pose],
    starts: &[Vec<f64>],
    settings: &FollowSettings,
) -> Option<RobotMotion> {
    if targets.len() < 3 {
        return None;
    }
    let mut solver = Solver::new(robot, settings.tolerance_m, settings.tolerance_rad);
    let mut graph = Graph::new(robot, time_s, targets);
    graph.sample(&mut solver, starts, settings);
    let mut judge = Judge::new(robot, &settings.obstacles);
    for _ in 0..CHAINS {
        let chain = graph.cheapest()?;
        let mut fault = 0.0;
        for smoothed in SMOOTHED {
            let postures = graph.smooth(&mut solver, &chain, smoothed, settings);
            let refined =
                refine(&mut solver, &graph.time_s, &postures, (time_s, targets), settings);
            match refined {
                Ok((q, worst)) => {
                    let mut check = assess(robot, time_s, q);
                    (check.motion.max_residual_m, check.motion.max_residual_rad) =
                        (worst.m, worst.rad);
                    judge.grade(time_s, &mut check.motion);
                    match (check.violations.first(), &check.motion.self_nearest) {
                        (Some(v), _) => fault = v.time_s,
                        (None, Some(near)) if near.distance_m <= 0.0 => fault = near.time_s,
                        (None, _) => return Some(check.motion),
                    }
                }
                Err(t) => fault = t,
            }
        }
        graph.strike(&chain, fault);
    }
    None
}

impl<'r> Graph<'r> {
    fn new(robot: &'r Robot, time_s: &[f64], targets: &[Pose]) -> Self {
        let last = targets.len() - 1;
        let count = LAYERS.min(targets.len());
        let knots: Vec<usize> = (0..count).map(|l| l * last / (count - 1)).collect();
        Self {
            robot,
            time_s: knots.iter().map(|&k| time_s[k]).collect(),
            targets: knots.iter().map(|&k| targets[k]).collect(),
            layers: vec![Vec::new(); count],
            struck: Vec::new(),
            knots,
        }
    }

    /// Fills the layers.
    fn sample(&mut self, solver: &mut Solver, starts: &[Vec<f64>], settings: &FollowSettings) {
        let count = self.knots.len();
        let is_there = |r: &Residual| r.is_within(settings.tolerance_m, settings.tolerance_rad);
        // Branches at each layer: random ones, and those of the neighbours carried over.
        let mut branches: Vec<Vec<Vec<f64>>> = vec![Vec::new(); count];
        let add = |all: &mut Vec<Vec<f64>>, q: Vec<f64>| {
            if all.iter().all(|other| distance(other, &q) > SAME) {
                all.push(q);
            }
        };
        solver.centring = 1.0;
        for (l, target) in self.targets.iter().enumerate() {
            let random = (0..SEEDS)
                .map(|i| random_posture(&self.robot.limits, settings.seed, BLOCK + l as u32, i));
            let known = if l == 0 { starts } else { &[] };
            for mut q in known.iter().cloned().chain(random) {
                if q.len() == self.robot.dof()
                    && is_there(&solver.solve(target, &mut q, COLD_STEPS))
                {
                    add(&mut branches[l], q);
                }
            }
        }
        solver.centring = 0.0;
        let forward = (1..count).map(|l| (l - 1, l));
        let backward = (1..count).rev().map(|l| (l, l - 1));
        for (from, to) in forward.chain(backward) {
            for mut q in branches[from].clone() {
                if branches[to].len() < NODES
                    && is_there(&solver.solve(&self.targets[to], &mut q, WARM_STEPS))
                {
                    add(&mut branches[to], q);
                }
            }
        }
        let mut ease = Ease::new(self.robot, &settings.obstacles);
        let mut judge = Judge::new(self.robot, &settings.obstacles);
        for (l, found) in branches.into_iter().enumerate() {
            let mut all: Vec<Vec<f64>> = Vec::new();
            for q in found {
                if all.len() >= NODES || all.iter().any(|other| distance(other, &q) <= SAME) {
                    continue;
                }
                all.push(q.clone());
                if let Some(ease) = &mut ease {
                    for way in [1.0, -1.0] {
                        let walked = self.walk(solver, ease, (l, &q, way), settings);
                        all.extend(walked.into_iter().take(NODES.saturating_sub(all.len())));
                    }
                }
            }
            let node = |q: Vec<f64>| judge.field(&q).map(|cost| Node { q, cost });
            self.layers[l] = all.into_iter().filter_map(node).collect();
        }
    }

    /// Postures along the self-motion from `q`, one way.
    fn walk(
        &self,
        solver: &mut Solver,
        ease: &mut Ease,
        (l, q, way): (usize, &[f64], f64),
        settings: &FollowSettings,
    ) -> Vec<Vec<f64>> {
        let mut walked: Vec<Vec<f64>> = Vec::new();
        let (mut at, limits) = (q.to_vec(), &self.robot.limits);
        let mut before: Option<nalgebra::DVector<f64>> = None;
        for step in 0..STRIDES {
            let Some(mut direction) = ease.null_space(&at).into_iter().next() else { break };
            // The basis has no sign of its own.
            let along = before
                .as_ref()
                .map_or_else(|| direction[direction.iamax()] * way, |b| b.dot(&direction));
            if along < 0.0 {
                direction.neg_mut();
            }
            for (i, x) in at.iter_mut().enumerate() {
                *x += STRIDE * direction[i];
            }
            before = Some(direction);
            let is_out = |(i, x): (usize, &f64)| *x < limits.lower[i] || *x > limits.upper[i];
            if at.iter().enumerate().any(is_out) {
                break;
            }
            let residual = solver.solve(&self.targets[l], &mut at, WARM_STEPS);
            let is_there = residual.is_within(settings.tolerance_m, settings.tolerance_rad);
            // Once round.
            if !is_there || (step > 3 && distance(&at, q) < 0.7 * STRIDE) {
                break;
            }
            walked.push(at.clone());
        }
        walked
    }

    /// The cheapest chain of nodes from the first layer to the last.
    fn cheapest(&self) -> Option<Vec<usize>> {
        let mut reached: Vec<Vec<(f64, usize)>> =
            vec![self.layers[0].iter().map(|n| (n.cost, 0)).collect()];
        for l in 1..self.layers.len() {
            let reach: Vec<f64> = {
                let dt = self.time_s[l] - self.time_s[l - 1];
                self.robot.limits.velocity.iter().map(|v| v * dt).collect()
            };
            let to = self.layers[l].iter().enumerate();
            let row = to.map(|(j, node)| {
                let mut best = (f64::INFINITY, 0);
                for (i, (from, (so_far, _))) in
                    self.layers[l - 1].iter().zip(&reached[l - 1]).enumerate()
                {
                    if *so_far >= best.0 || self.struck.contains(&(l, i, j)) {
                        continue;
                    }
                    let Some(edge) = edge(&from.q, &node.q, &reach) else { continue };
                    if so_far + edge < best.0 {
                        best = (so_far + edge, i);
                    }
                }
                (best.0 + node.cost, best.1)
            });
            reached.push(row.collect());
        }
        let last = reached.last()?;
        let end = (0..last.len()).min_by(|&a, &b| last[a].0.total_cmp(&last[b].0))?;
        if !last[end].0.is_finite() {
            return None;
        }
        let mut chain = vec![end];
        for l in (1..reached.len()).rev() {
            chain.push(reached[l][chain[chain.len() - 1]].1);
        }
        chain.reverse();
        Some(chain)
    }

    /// The chain's postures with its kinks taken out, still on their poses.
    fn smooth(
        &self,
        solver: &mut Solver,
        chain: &[usize],
        passes: usize,
        settings: &FollowSettings,
    ) -> Vec<Vec<f64>> {
        let mut q: Vec<Vec<f64>> =
            chain.iter().zip(&self.layers).map(|(&i, layer)| layer[i].q.clone()).collect();
        solver.centring = 0.0;
        for _ in 0..passes {
            let old = q.clone();
            for (l, posture) in q.iter_mut().enumerate() {
                let (before, after) = (&old[l.saturating_sub(1)], &old[(l + 1).min(old.len() - 1)]);
                let mut mean: Vec<f64> = (0..posture.len())
                    .map(|i| 0.25 * before[i] + 0.5 * old[l][i] + 0.25 * after[i])
                    .collect();
                let residual = solver.solve(&self.targets[l], &mut mean, WARM_STEPS);
                if residual.is_within(settings.tolerance_m, settings.tolerance_rad) {
                    *posture = mean;
                }
            }
        }
        q
    }

    /// Strikes out the chain's edge at a time.
    fn strike(&mut self, chain: &[usize], time_s: f64) {
        let later = self.time_s.partition_point(|t| *t <= time_s);
        let l = later.clamp(1, self.time_s.len() - 1);
        self.struck.push((l, chain[l - 1], chain[l]));
    }
}

/// Largest difference of two postures, rad or m.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Cost of a joint motion; `None` where a joint would be too fast. `reach`: how far each may go.
fn edge(a: &[f64], b: &[f64], reach: &[f64]) -> Option<f64> {
    let mut sum = 0.0;
    for ((a, b), reach) in a.iter().zip(b).zip(reach) {
        let share = (a - b).abs() / reach;
        if share > 1.0 {
            return None;
        }
        sum += share * share;
    }
    Some(sum)
}

/// Inverse kinematics at every knot from the spline through the layers' postures; the time at which it
/// fails otherwise.
fn refine(
    solver: &mut Solver,
    layer_s: &[f64],
    postures: &[Vec<f64>],
    (time_s, targets): (&[f64], &[Pose]),
    settings: &FollowSettings,
) -> Result<(Vec<Vec<f64>>, Residual), f64> {
    let guesses = spline_at(layer_s, postures, time_s);
    let mut worst = Residual { m: 0.0, rad: 0.0 };
    solver.centring = 0.0;
    let mut all = Vec::with_capacity(targets.len());
    for ((mut q, target), &t) in guesses.into_iter().zip(targets).zip(time_s) {
        let residual = solver.solve(target, &mut q, WARM_STEPS);
        if !residual.is_within(settings.tolerance_m, settings.tolerance_rad) {
            return Err(t);
        }
        worst.m = worst.m.max(residual.m);
        worst.rad = worst.rad.max(residual.rad);
        all.push(q);
    }
    Ok((all, worst))
}

//! The projection of a reference onto the limits as a conic quadratic program in state form.
//!
//! ```text
//! minimise  w_d int |p - r|^2 dt + w_j int |j|^2 dt + w_s sum s
//! p' = p + v dt + a dt^2/2 + j dt^3/6,  v' = v + a dt + j dt^2/2,  a' = a + j dt   (exact)
//! p_0 = r_0,  p_T = r_T,  v and a zero at both ends
//! |v| <= v_max,  |a| <= a_max,  -j_max <= j_axis <= j_max,  lo <= p <= hi
//! n . p >= h - s,  |p - m| <= rho + s,  s >= 0        (obstacles, corridor, reach: elastic)
//! n . (p, v or a) <= h                                (what the robot asks for: not elastic)
//! ```
//! The state at every knot is written in the spline coefficients of [`super::stencil`], which satisfy
//! the dynamics exactly; with the jerks they are the variables: a third of those that the states
//! themselves would be, and no rows for dynamics but the definition of the jerk, which keeps the
//! conditioning of the state form (without the jerks as variables it takes twice the iterations).
//!
//! Units: time is counted in steps, lengths in `v_max dt`, velocity, acceleration and jerk in their
//! limits, and coefficients are deviations from the reference, so that the numbers are of size one
//! whatever the duration. Limits are put on Bezier points, so that they hold at every time and not
//! only at the knots.

use super::limits::{Box3, PathLimits};
use super::scene::Order;
use super::stencil::{
    Stencil, acceleration, jerk, position, position_inner, velocity, velocity_middle,
};
use crate::math::Vec3;
use crate::qp::{Cone, Problem};
use std::collections::BTreeSet;

/// Labels of the blocks of rows that stand for limits.
pub(super) const SPEED: &str = "speed";
pub(super) const ACCELERATION: &str = "acceleration";
pub(super) const JERK: &str = "jerk";
pub(super) const ROBOT: &str = "robot";

/// Cost of one unit (`v_max dt`) of slack. Above the multipliers of any path that can be kept, which
/// grow to some 1e3, the penalty is exact: slack is zero unless it must be more.
pub(super) const SLACK_COST: f64 = 1e5;

/// `normal . x <= bound` at one place, SI; with a slack, `<= bound + s` (m, unit normal).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    pub(super) label: String,
    pub(super) at: Stencil,
    pub(super) order: Order,
    pub(super) normal: Vec3,
    pub(super) bound: f64,
    pub(super) slack: Option<usize>,
}

/// `|p - center| <= radius + s` at one place, m.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ball {
    pub(super) label: String,
    pub(super) at: Stencil,
    pub(super) center: Vec3,
    pub(super) radius: f64,
    pub(super) slack: usize,
}

/// The rows beyond start, goal and speed.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Rows {
    /// Steps whose speed is bounded; none for all.
    pub(super) speed: Option<BTreeSet<usize>>,
    /// Whether the acceleration is bounded.
    pub(super) acceleration: bool,
    /// Whether the jerk is bounded.
    pub(super) jerk: bool,
    /// Faces of the workspace box that are constrained: axis, whether upper.
    pub(super) faces: Vec<(usize, bool)>,
    /// Half-spaces.
    pub(super) planes: Vec<Plane>,
    /// Balls.
    pub(super) balls: Vec<Ball>,
    /// The slacks: cost of one unit of length each.
    pub(super) slacks: Vec<f64>,
}

/// What a projection is asked to do.
pub(super) struct Task<'a> {
    /// Reference positions at the T + 1 knots, m.
    pub(super) reference: &'a [Vec3],
    /// Time between knots, s.
    pub(super) step_s: f64,
    pub(super) limits: &'a PathLimits,
    /// Weight of the squared jerk against the squared distance, `w_j / w_d`, s^6.
    pub(super) jerk_weight: f64,
    /// Share by which speed, acceleration and jerk stay below their limits.
    pub(super) margin: f64,
    pub(super) rows: &'a Rows,
}

/// One linear combination of variables, and a constant.
type Line = (Vec<(usize, f64)>, f64);

impl Task<'_> {
    /// Number of steps T.
    fn steps(&self) -> usize {
        self.reference.len() - 1
    }

    /// One unit of length, m.
    fn unit(&self) -> f64 {
        self.limits.speed_m_s * self.step_s
    }

    /// Coefficients that rest on the reference, in units of length from the start.
    fn base(&self) -> Vec<Vec3> {
        let (steps, start) = (self.steps(), self.reference[0]);
        let at = |i: usize| match i {
            0..=2 => Vec3::zeros(),
            i if i >= steps => (self.reference[steps] - start) / self.unit(),
            i => (self.reference[i - 1] - start) / self.unit(),
        };
        (0..steps + 3).map(at).collect()
    }

    /// Column of the free coefficient `i`, none for those that start and goal fix.
    fn coefficient(&self, i: usize, axis: usize) -> Option<usize> {
        (3..self.steps()).contains(&i).then(|| (i - 3) * 3 + axis)
    }

    fn jerk_column(&self, k: usize, axis: usize) -> usize {
        (self.steps() - 3 + k) * 3 + axis
    }

    fn slack_column(&self, i: usize) -> usize {
        (2 * self.steps() - 3) * 3 + i
    }

    /// Jerks (m/s^3) of a solution.
    pub(super) fn jerks(&self, x: &[f64]) -> Vec<Vec3> {
        let scale = self.limits.jerk_m_s3;
        let axis = |k: usize, i: usize| x[self.jerk_column(k, i)] * scale;
        (0..self.steps()).map(|k| Vec3::new(axis(k, 0), axis(k, 1), axis(k, 2))).collect()
    }

    /// Slacks (m) of a solution.
    pub(super) fn slacks(&self, x: &[f64]) -> Vec<f64> {
        let unit = self.unit();
        (0..self.rows.slacks.len()).map(|i| x[self.slack_column(i)].max(0.0) * unit).collect()
    }

    /// `normal . stencil` in units of length: entries of the free coefficients, and the rest.
    fn line(&self, base: &[Vec3], at: &Stencil, normal: &Vec3) -> Line {
        let mut entries = Vec::with_capacity(12);
        for (n, weight) in at.weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            for axis in (0..3).filter(|axis| normal[*axis] != 0.0) {
                if let Some(column) = self.coefficient(at.first + n, axis) {
                    entries.push((column, weight * normal[axis]));
                }
            }
        }
        (entries, normal.dot(&at.of(base)))
    }

    /// The program.
    pub(super) fn problem(&self) -> Problem {
        let (steps, base) = (self.steps(), self.base());
        let mut problem = Problem::new((2 * steps - 3) * 3 + self.rows.slacks.len());
        self.push_cost(&mut problem, &base);
        self.push_jerks(&mut problem, &base);
        if self.rows.jerk {
            for column in self.jerk_column(0, 0)..self.jerk_column(steps, 0) {
                let limit = 1.0 - self.margin;
                let rows: [(&[(usize, f64)], f64); 2] =
                    [(&[(column, 1.0)], limit), (&[(column, -1.0)], limit)];
                problem.push_block(JERK, Cone::Nonnegative, &rows);
            }
        }
        // In the first two and the last two steps the middle of the velocity is fixed or shared.
        let is_bounded = |k: &usize| self.rows.speed.as_ref().is_none_or(|s| s.contains(k));
        for k in (1..steps - 1).filter(is_bounded) {
            self.push_ball(&mut problem, &base, SPEED, &velocity_middle(k), 1.0);
        }
        if self.rows.acceleration {
            let unit = self.limits.acceleration_m_s2 * self.step_s / self.limits.speed_m_s;
            for k in 1..steps {
                self.push_ball(&mut problem, &base, ACCELERATION, &acceleration(k), unit);
            }
        }
        if let Some(inner) = &self.limits.workspace {
            for face in &self.rows.faces {
                self.push_face(&mut problem, &base, inner, *face);
            }
        }
        self.push_planes(&mut problem, &base);
        self.push_reaches(&mut problem, &base);
        for (i, cost) in self.rows.slacks.iter().enumerate() {
            let column = self.slack_column(i);
            problem.linear[column] = *cost;
            problem.push_block("slack", Cone::Nonnegative, &[(&[(column, -1.0)], 0.0)]);
        }
        problem
    }

    /// Both integrals divided by `w_d dt (v_max dt)^2`.
    fn push_cost(&self, problem: &mut Problem, base: &[Vec3]) {
        let steps = self.steps();
        let start = self.reference[0];
        for k in 1..steps {
            let at = position(k);
            let wanted = (self.reference[k] - start) / self.unit();
            for axis in 0..3 {
                let (entries, rest) = self.line(base, &at, &Vec3::ith(axis, 1.0));
                for (i, (column, weight)) in entries.iter().enumerate() {
                    problem.linear[*column] += 2.0 * weight * (rest - wanted[axis]);
                    for (other, other_weight) in &entries[i..] {
                        problem.quadratic.push((*column, *other, 2.0 * weight * other_weight));
                    }
                }
            }
        }
        let cost = self.jerk_weight * (self.limits.jerk_m_s3 / self.unit()).powi(2);
        for column in self.jerk_column(0, 0)..self.jerk_column(steps, 0) {
            problem.quadratic.push((column, column, 2.0 * cost));
        }
    }

    /// The jerks as differences of the coefficients.
    fn push_jerks(&self, problem: &mut Problem, base: &[Vec3]) {
        let unit = self.limits.jerk_m_s3 * self.step_s.powi(3) / self.unit();
        for k in 0..self.steps() {
            for axis in 0..3 {
                let (mut entries, rest) = self.line(base, &jerk(k), &Vec3::ith(axis, 1.0));
                for entry in &mut entries {
                    entry.1 /= unit;
                }
                entries.push((self.jerk_column(k, axis), -1.0));
                problem.push_block("dynamics", Cone::Zero, &[(&entries, -rest / unit)]);
            }
        }
    }

    /// `|stencil| <= unit`, less the margin.
    fn push_ball(
        &self,
        problem: &mut Problem,
        base: &[Vec3],
        label: &'static str,
        at: &Stencil,
        unit: f64,
    ) {
        let lines: [Line; 3] = std::array::from_fn(|axis| {
            let (mut entries, rest) = self.line(base, at, &Vec3::ith(axis, 1.0));
            for entry in &mut entries {
                entry.1 /= -unit;
            }
            (entries, rest / unit)
        });
        // Start and goal alone: nothing to choose.
        if lines.iter().all(|(entries, _)| entries.is_empty()) {
            return;
        }
        let [x, y, z] = &lines;
        let rows: [(&[(usize, f64)], f64); 4] =
            [(&[], 1.0 - self.margin), (&x.0, x.1), (&y.0, y.1), (&z.0, z.1)];
        problem.push_block(label, Cone::SecondOrder, &rows);
    }

    /// One face of the box, for the inner Bezier points of each step; the knots are their means.
    fn push_face(
        &self,
        problem: &mut Problem,
        base: &[Vec3],
        inner: &Box3,
        (axis, is_upper): (usize, bool),
    ) {
        // A hair inside, for the rounding of the solution; less in a thin box.
        let width = inner.max[axis] - inner.min[axis];
        let hair = (width / 4.0).min(1e-7);
        let label = face_label(inner, (axis, is_upper));
        let outward = Vec3::ith(axis, if is_upper { 1.0 } else { -1.0 });
        let room = (-inner.excess(&self.reference[0], axis, is_upper) - hair) / self.unit();
        for at in (1..self.steps() - 1).flat_map(position_inner) {
            let (entries, rest) = self.line(base, &at, &outward);
            if !entries.is_empty() {
                let row: (&[(usize, f64)], f64) = (&entries, room - rest);
                problem.push_block(label.clone(), Cone::Nonnegative, &[row]);
            }
        }
    }

    fn push_planes(&self, problem: &mut Problem, base: &[Vec3]) {
        for plane in &self.rows.planes {
            let size = plane.normal.norm();
            let normal = plane.normal / size;
            let unit = match plane.order {
                Order::Position => self.unit(),
                Order::Velocity => self.unit() / self.step_s,
                Order::Acceleration => self.unit() / self.step_s.powi(2),
            };
            let (mut entries, rest) = self.line(base, &plane.at, &normal);
            let origin = match plane.order {
                Order::Position => normal.dot(&self.reference[0]),
                _ => 0.0,
            };
            if size == 0.0 || entries.is_empty() {
                continue;
            }
            entries.extend(plane.slack.map(|i| (self.slack_column(i), -1.0)));
            let bound = (plane.bound / size - origin) / unit - rest;
            problem.push_block(plane.label.clone(), Cone::Nonnegative, &[(&entries, bound)]);
        }
    }

    fn push_reaches(&self, problem: &mut Problem, base: &[Vec3]) {
        for ball in &self.rows.balls {
            let middle = (ball.center - self.reference[0]) / self.unit();
            let lines: [Line; 3] = std::array::from_fn(|axis| {
                let (mut entries, rest) = self.line(base, &ball.at, &Vec3::ith(axis, 1.0));
                for entry in &mut entries {
                    entry.1 = -entry.1;
                }
                (entries, rest - middle[axis])
            });
            if lines.iter().all(|(entries, _)| entries.is_empty()) {
                continue;
            }
            let [x, y, z] = &lines;
            let widened = [(self.slack_column(ball.slack), -1.0)];
            let rows: [(&[(usize, f64)], f64); 4] =
                [(&widened, ball.radius / self.unit()), (&x.0, x.1), (&y.0, y.1), (&z.0, z.1)];
            problem.push_block(ball.label.clone(), Cone::SecondOrder, &rows);
        }
    }
}

/// The place of a condition at a knot.
pub(super) fn at_knot(order: Order, knot: usize) -> Stencil {
    match order {
        Order::Position => position(knot),
        Order::Velocity => velocity(knot),
        Order::Acceleration => acceleration(knot),
    }
}

/// The label of a face of the box.
pub(super) fn face_label(inner: &Box3, (axis, is_upper): (usize, bool)) -> String {
    let face = inner.face(axis, is_upper);
    let sign = if face.is_upper { "<=" } else { ">=" };
    format!("workspace box ({} {sign} {} m)", ["x", "y", "z"][face.axis], face.at_m)
}

#[cfg(test)]
mod tests;

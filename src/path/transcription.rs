//! The projection of a reference onto the limits as a conic quadratic program in state form.
//!
//! ```text
//! minimise  w_d int |p - r|^2 dt + w_j int |j|^2 dt
//! p' = p + v dt + a dt^2/2 + j dt^3/6,  v' = v + a dt + j dt^2/2,  a' = a + j dt   (exact)
//! p_0 = r_0,  p_T = r_T,  v and a zero at both ends
//! |v| <= v_max,  |a| <= a_max,  -j_max <= j_axis <= j_max,  lo <= p <= hi
//! ```
//! Units: every quantity is divided by its limit, positions by `v_max dt`, and the position is the
//! deviation `d = (p - r) / (v_max dt)` from the reference, so that the numbers are of size one
//! whatever the duration. Between knots `v` is a parabola and `p` a cubic; they lie in the convex
//! hull of their Bezier points, and the limits are put on those, so that they hold at every time and
//! not only at the knots. Acceleration is linear between knots and needs nothing more.

use super::limits::{Box3, PathLimits};
use crate::math::Vec3;
use crate::qp::{Cone, Problem};

/// Labels of the blocks of rows that stand for limits.
pub(super) const SPEED: &str = "speed";
pub(super) const ACCELERATION: &str = "acceleration";
pub(super) const JERK: &str = "jerk";

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
    /// Faces of the workspace box that are constrained: axis, whether upper.
    pub(super) faces: &'a [(usize, bool)],
}

/// Places of the variables: per knot d, v, a (three axes each) and, but for the last, j.
const PER_KNOT: usize = 12;

fn d(knot: usize, axis: usize) -> usize {
    knot * PER_KNOT + axis
}
fn v(knot: usize, axis: usize) -> usize {
    knot * PER_KNOT + 3 + axis
}
fn a(knot: usize, axis: usize) -> usize {
    knot * PER_KNOT + 6 + axis
}
fn j(knot: usize, axis: usize) -> usize {
    knot * PER_KNOT + 9 + axis
}

/// The unit-free ratios of the dynamics.
struct Ratios {
    /// `a_max dt / v_max`.
    av: f64,
    /// `j_max dt^2 / v_max`.
    jv: f64,
    /// `j_max dt / a_max`.
    ja: f64,
    /// Length of one unit of position, `v_max dt`, m.
    length: f64,
}

impl Task<'_> {
    /// Number of steps T.
    fn steps(&self) -> usize {
        self.reference.len() - 1
    }

    fn ratios(&self) -> Ratios {
        let (h, l) = (self.step_s, self.limits);
        Ratios {
            av: l.acceleration_m_s2 * h / l.speed_m_s,
            jv: l.jerk_m_s3 * h * h / l.speed_m_s,
            ja: l.jerk_m_s3 * h / l.acceleration_m_s2,
            length: l.speed_m_s * h,
        }
    }

    /// Jerks (m/s^3) of a solution.
    pub(super) fn jerks(&self, x: &[f64]) -> Vec<Vec3> {
        let scale = self.limits.jerk_m_s3;
        let axis = |k: usize, i: usize| x[j(k, i)] * scale;
        (0..self.steps()).map(|k| Vec3::new(axis(k, 0), axis(k, 1), axis(k, 2))).collect()
    }

    /// The program.
    pub(super) fn problem(&self) -> Problem {
        let steps = self.steps();
        let ratios = self.ratios();
        let mut problem = Problem::new(steps * PER_KNOT + 9);
        // Both integrals divided by w_d dt (v_max dt)^2.
        let jerk_cost = self.jerk_weight * (self.limits.jerk_m_s3 / ratios.length).powi(2);
        for axis in 0..3 {
            for k in 0..=steps {
                problem.quadratic.push((d(k, axis), d(k, axis), 2.0));
            }
            for k in 0..steps {
                problem.quadratic.push((j(k, axis), j(k, axis), 2.0 * jerk_cost));
            }
        }
        for axis in 0..3 {
            for (label, k) in [("start at rest", 0), ("goal at rest", steps)] {
                for place in [d(k, axis), v(k, axis), a(k, axis)] {
                    problem.push_block(label, Cone::Zero, &[(&[(place, 1.0)], 0.0)]);
                }
            }
            for k in 0..steps {
                self.push_dynamics(&mut problem, &ratios, k, axis);
            }
        }
        self.push_balls(&mut problem, &ratios);
        for k in 0..steps {
            for place in (0..3).map(|axis| j(k, axis)) {
                let limit = 1.0 - self.margin;
                let rows: [(&[(usize, f64)], f64); 2] =
                    [(&[(place, 1.0)], limit), (&[(place, -1.0)], limit)];
                problem.push_block(JERK, Cone::Nonnegative, &rows);
            }
        }
        if let Some(inner) = &self.limits.workspace {
            for face in self.faces {
                self.push_face(&mut problem, &ratios, inner, *face);
            }
        }
        problem
    }

    /// The state after step `k` from the state before.
    fn push_dynamics(&self, problem: &mut Problem, r: &Ratios, k: usize, axis: usize) {
        let moved = (self.reference[k + 1][axis] - self.reference[k][axis]) / r.length;
        let to_d: [(usize, f64); 5] = [
            (d(k, axis), 1.0),
            (v(k, axis), 1.0),
            (a(k, axis), r.av / 2.0),
            (j(k, axis), r.jv / 6.0),
            (d(k + 1, axis), -1.0),
        ];
        let to_v = [
            (v(k, axis), 1.0),
            (a(k, axis), r.av),
            (j(k, axis), r.jv / 2.0),
            (v(k + 1, axis), -1.0),
        ];
        let to_a = [(a(k, axis), 1.0), (j(k, axis), r.ja), (a(k + 1, axis), -1.0)];
        let rows: [(&[(usize, f64)], f64); 3] = [(&to_d, moved), (&to_v, 0.0), (&to_a, 0.0)];
        problem.push_block("dynamics", Cone::Zero, &rows);
    }

    /// Speed at the knots and at the middle Bezier points `v + a dt/2`; acceleration at the knots.
    /// At both ends these are zero, and so are the middle points of the first and the last step.
    fn push_balls(&self, problem: &mut Problem, r: &Ratios) {
        let steps = self.steps();
        let limit = 1.0 - self.margin;
        for k in 1..steps {
            push_ball(problem, SPEED, limit, |axis| [(v(k, axis), -1.0), (a(k, axis), 0.0)]);
            if k + 1 < steps {
                let half = -r.av / 2.0;
                push_ball(problem, SPEED, limit, |axis| [(v(k, axis), -1.0), (a(k, axis), half)]);
            }
            push_ball(problem, ACCELERATION, limit, |axis| [(a(k, axis), -1.0), (v(k, axis), 0.0)]);
        }
    }

    /// One face of the box, for the knots and the two inner Bezier points `p + v dt/3` and
    /// `p + 2 v dt/3 + a dt^2/6` of each step. The first and the last step's are start and goal.
    fn push_face(&self, problem: &mut Problem, r: &Ratios, inner: &Box3, face: (usize, bool)) {
        let (axis, is_upper) = face;
        // A hair inside, for the rounding of the solution; less in a thin box.
        let width = inner.max[axis] - inner.min[axis];
        let hair = (width / 4.0).min(1e-7);
        let sign = if is_upper { 1.0 } else { -1.0 };
        let label = face_label(inner, face);
        let steps = self.steps();
        for k in 1..steps {
            let point = self.reference[k];
            let room = (-inner.excess(&point, axis, is_upper) - hair) / r.length;
            let knot = [(d(k, axis), sign)];
            let first = [(d(k, axis), sign), (v(k, axis), sign / 3.0)];
            let second = [
                (d(k, axis), sign),
                (v(k, axis), sign * 2.0 / 3.0),
                (a(k, axis), sign * r.av / 6.0),
            ];
            let rows: [(&[(usize, f64)], f64); 3] =
                [(&knot, room), (&first, room), (&second, room)];
            let count = if k + 1 < steps { 3 } else { 1 };
            problem.push_block(label.clone(), Cone::Nonnegative, &rows[..count]);
        }
    }
}

/// The label of a face of the box.
pub(super) fn face_label(inner: &Box3, (axis, is_upper): (usize, bool)) -> String {
    format!("workspace box ({})", inner.face(axis, is_upper))
}

/// `|sum of two entries per axis| <= limit`; entries of value zero are left out.
fn push_ball(
    problem: &mut Problem,
    label: &'static str,
    limit: f64,
    entries: impl Fn(usize) -> [(usize, f64); 2],
) {
    let axes = [entries(0), entries(1), entries(2)];
    let used = |axis: usize| -> &[(usize, f64)] {
        let count = if axes[axis][1].1 == 0.0 { 1 } else { 2 };
        &axes[axis][..count]
    };
    let rows: [(&[(usize, f64)], f64); 4] =
        [(&[], limit), (used(0), 0.0), (used(1), 0.0), (used(2), 0.0)];
    problem.push_block(label, Cone::SecondOrder, &rows);
}

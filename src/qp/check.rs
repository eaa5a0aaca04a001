//! Optimality of a claimed solution, from the definitions alone.
//!
//! With `s = b - A x`: `s` in K, `z` in K*, `P x + q + A^T z = 0`, `s^T z = 0`.

use super::{Cone, Problem};
use serde::Serialize;

/// How far a pair `(x, z)` is from optimal; all are zero at a solution.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Residuals {
    /// Largest `|b - A x|` over the equality rows.
    pub equality: f64,
    /// Largest distance by which a slack leaves its inequality or second-order cone.
    pub cone: f64,
    /// The same for the multipliers and the dual cones.
    pub dual_cone: f64,
    /// Largest component of `|P x + q + A^T z|`.
    pub stationarity: f64,
    /// `|s^T z|`.
    pub complementarity: f64,
}

/// Residuals of `x` (n numbers) and `z` (m numbers); `None` where the sizes do not fit.
pub fn residuals(problem: &Problem, x: &[f64], z: &[f64]) -> Option<Residuals> {
    if problem.fault().is_some() || x.len() != problem.variables || z.len() != problem.rows() {
        return None;
    }
    let mut slack = problem.offset.clone();
    let mut gradient = problem.linear.clone();
    for (row, column, value) in &problem.matrix {
        slack[*row] -= value * x[*column];
        gradient[*column] += value * z[*row];
    }
    for (row, column, value) in &problem.quadratic {
        gradient[*row] += value * x[*column];
        if row != column {
            gradient[*column] += value * x[*row];
        }
    }
    let mut found = Residuals {
        stationarity: largest(&gradient),
        complementarity: slack.iter().zip(z).map(|(s, z)| s * z).sum::<f64>().abs(),
        ..Residuals::default()
    };
    let mut row = 0;
    for block in &problem.blocks {
        let rows = row..row + block.rows;
        row = rows.end;
        if block.cone == Cone::Zero {
            found.equality = found.equality.max(largest(&slack[rows]));
        } else {
            found.cone = found.cone.max(outside(block.cone, &slack[rows.clone()]));
            found.dual_cone = found.dual_cone.max(outside(block.cone, &z[rows]));
        }
    }
    Some(found)
}

/// Largest absolute value; NaN counts as infinite.
fn largest(values: &[f64]) -> f64 {
    values.iter().map(|v| if v.is_nan() { f64::INFINITY } else { v.abs() }).fold(0.0, f64::max)
}

/// How far a vector is outside its (self-dual) cone.
fn outside(cone: Cone, s: &[f64]) -> f64 {
    let excess = match cone {
        Cone::Zero => 0.0,
        Cone::Nonnegative => s.iter().map(|v| -v).fold(0.0, f64::max),
        Cone::SecondOrder => match s.split_first() {
            Some((first, rest)) => rest.iter().map(|v| v * v).sum::<f64>().sqrt() - first,
            None => 0.0,
        },
    };
    excess.max(0.0)
}

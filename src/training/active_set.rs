//! Convex quadratic programmes inside joint and sum limits, by a primal active set.
//!
//! ```text
//! min over d   1/2 d^T H d + g^T d     such that   sign_i * sum of (q + d) over columns_i <= bound_i
//! ```
//! It starts at `d = 0` and stays feasible throughout, so that no posture ever has to be clamped.

use crate::human::PostureLimits;
use nalgebra::{DMatrix, DVector};

/// Passes after which the search stops with the feasible point reached; never met in practice.
const MAX_PASSES: usize = 300;

/// One inequality `sign * sum of x over columns <= bound`.
#[derive(Debug, Clone)]
struct Row {
    columns: Vec<usize>,
    sign: f64,
    bound: f64,
}

impl Row {
    fn value(&self, x: &DVector<f64>) -> f64 {
        self.sign * self.columns.iter().map(|&c| x[c]).sum::<f64>()
    }
}

/// The limits of a chain as rows of inequalities.
#[derive(Debug, Clone)]
pub(super) struct ActiveSet {
    rows: Vec<Row>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl ActiveSet {
    pub(super) fn new(limits: &PostureLimits) -> Self {
        let mut rows = Vec::new();
        let mut both = |columns: Vec<usize>, lower: f64, upper: f64| {
            rows.push(Row { columns: columns.clone(), sign: 1.0, bound: upper });
            rows.push(Row { columns, sign: -1.0, bound: -lower });
        };
        for (i, (&lower, &upper)) in limits.lower.iter().zip(&limits.upper).enumerate() {
            both(vec![i], lower, upper);
        }
        for sum in &limits.sums {
            both(sum.columns.clone(), sum.lower, sum.upper);
        }
        rows.retain(|r| r.bound.is_finite());
        Self { rows, lower: limits.lower.clone(), upper: limits.upper.clone() }
    }

    /// The minimiser `q + d`; `q` (n) must be feasible, `hessian` (n x n) positive definite. `None`
    /// where it is not.
    pub(super) fn minimise(
        &self,
        hessian: &DMatrix<f64>,
        gradient: &DVector<f64>,
        q: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        let factor = hessian.clone().cholesky()?;
        let mut x = q.clone();
        let mut active = self.pushed_bounds(gradient, q);
        for _ in 0..MAX_PASSES {
            let slope = gradient + hessian * (&x - q);
            let free = factor.solve(&slope);
            let (direction, multipliers) = self.on_active(&factor, &free, &active)?;
            let (length, blocking) = self.longest_step(&x, &direction, &active);
            x += direction * length;
            self.settle(&mut x, &active);
            if let Some(row) = blocking {
                active.push(row);
                continue;
            }
            // At the minimum on the active rows: done unless one of them holds the point back.
            let worst = multipliers.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
            match worst {
                Some((i, &value)) if value < -1e-10 => {
                    active.swap_remove(i);
                }
                _ => break,
            }
        }
        Some(x)
    }

    /// Bounds of single joints that `q` touches and the slope pushes against: a start that saves
    /// passes and, holding one column each, is surely independent.
    fn pushed_bounds(&self, gradient: &DVector<f64>, q: &DVector<f64>) -> Vec<usize> {
        let pushed = |r: &Row| {
            r.columns.len() == 1 && r.value(q) >= r.bound && r.sign * gradient[r.columns[0]] < 0.0
        };
        (0..self.rows.len()).filter(|&i| pushed(&self.rows[i])).collect()
    }

    /// Newton direction along the active rows, and their multipliers (negative: let go).
    fn on_active(
        &self,
        factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>,
        free: &DVector<f64>,
        active: &[usize],
    ) -> Option<(DVector<f64>, Vec<f64>)> {
        if active.is_empty() {
            return Some((-free, Vec::new()));
        }
        let mut normals = DMatrix::zeros(free.len(), active.len());
        for (k, &row) in active.iter().enumerate() {
            for &c in &self.rows[row].columns {
                normals[(c, k)] = self.rows[row].sign;
            }
        }
        let solved = factor.solve(&normals);
        let schur = (normals.transpose() * &solved).cholesky()?;
        let multipliers = schur.solve(&(normals.transpose() * free * -1.0));
        let direction = -(free + solved * &multipliers);
        Some((direction, multipliers.iter().copied().collect()))
    }

    /// Share of the direction that stays feasible, and the row that ends it.
    fn longest_step(
        &self,
        x: &DVector<f64>,
        direction: &DVector<f64>,
        active: &[usize],
    ) -> (f64, Option<usize>) {
        let mut longest = (1.0, None);
        for (i, row) in self.rows.iter().enumerate() {
            let speed = row.value(direction);
            if speed <= 1e-13 || active.contains(&i) {
                continue;
            }
            let share = (row.bound - row.value(x)).max(0.0) / speed;
            if share < longest.0 {
                longest = (share, Some(i));
            }
        }
        longest
    }

    /// Removes rounding: joints on an active bound lie on it exactly, none is beyond by an ulp.
    fn settle(&self, x: &mut DVector<f64>, active: &[usize]) {
        for &i in active {
            if let [column] = self.rows[i].columns[..] {
                x[column] = self.rows[i].sign * self.rows[i].bound;
            }
        }
        for (i, value) in x.iter_mut().enumerate() {
            *value = value.clamp(self.lower[i], self.upper[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::SumRow;
    use crate::math::stream::{Purpose, normals, stream};

    fn limits(n: usize) -> PostureLimits {
        let sum = SumRow { name: "s".into(), columns: vec![0, 1, 2], lower: -0.9, upper: 1.2 };
        PostureLimits { lower: vec![-0.5; n], upper: vec![0.7; n], sums: vec![sum] }
    }

    /// Karush, Kuhn, Tucker: feasible, and no feasible neighbour is lower.
    #[test]
    fn no_feasible_neighbour_is_better() {
        let n = 6;
        let limits = limits(n);
        let set = ActiveSet::new(&limits);
        for seed in 0..60 {
            let mut rng = stream(seed, Purpose::Simulation, 0, 0);
            let a = DMatrix::from_vec(n, n, normals(&mut rng, n * n));
            let h = &a * a.transpose() + DMatrix::identity(n, n) * 0.05;
            let g = DVector::from_vec(normals(&mut rng, n)) * 3.0;
            let q = DVector::zeros(n);
            let x = set.minimise(&h, &g, &q).unwrap();
            assert!(limits.violation(x.as_slice()) < 1e-12);
            let cost = |x: &DVector<f64>| 0.5 * x.dot(&(&h * x)) + g.dot(x);
            let best = cost(&x);
            for _ in 0..300 {
                let towards = DVector::from_vec(normals(&mut rng, n)) * 0.3;
                // Pulled into the limits through the feasible origin.
                let mut other = &x + towards;
                while limits.violation(other.as_slice()) > 0.0 {
                    other *= 0.9;
                }
                let near = &x + (other - &x) * 1e-3;
                assert!(cost(&near) >= best - 1e-12, "{seed}: {} < {best}", cost(&near));
            }
        }
    }

    #[test]
    fn starts_on_a_bound_can_leave_it() {
        let limits = limits(3);
        let set = ActiveSet::new(&limits);
        let q = DVector::from_vec(vec![0.7, 0.5, 0.0]);
        let goal = DVector::from_vec(vec![0.1, 0.2, 0.3]);
        let x = set.minimise(&DMatrix::identity(3, 3), &(&q - &goal), &q).unwrap();
        assert!((x - goal).norm() < 1e-12);
    }
}

//! One step of a posture under limits: lock and resolve.
//!
//! Solve the conditioned Gaussian; if a joint would leave its range, lock it at the limit (its weight
//! becomes zero, its velocity is given) and solve again; if a bounded *sum* of joints would leave its
//! range, it becomes an equality row of the task. The hand stays on its path while a solution exists.
//! Clamping after the step would take the hand off the path; rejecting would bias the distribution.

use crate::human::PostureLimits;
use nalgebra::{DMatrix, DVector};

/// Ratio of pivots of `J W J^T` (in units of its diagonal) below which the task is out of reach.
const RANK_TOLERANCE: f64 = 1e-10;
/// Violations smaller than this (rad) are rounding.
const LIMIT_TOLERANCE: f64 = 1e-10;
const MOST_PASSES: usize = 48;

/// The limits or the geometry leave no joint velocity that meets the task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReachExceeded;

/// Solves steps for one weight matrix; keeps its scratch between steps.
#[derive(Debug, Clone)]
pub struct StepSolver {
    weight: DMatrix<f64>,
    locked: Vec<Option<f64>>,
    sums: Vec<Option<f64>>,
}

impl StepSolver {
    /// For a symmetric positive definite weight, n x n.
    pub fn new(weight: DMatrix<f64>) -> Self {
        let n = weight.nrows();
        Self { weight, locked: vec![None; n], sums: Vec::new() }
    }

    /// Takes another weight of the same size.
    pub fn set_weight(&mut self, weight: DMatrix<f64>) {
        self.weight = weight;
    }

    /// Joint velocity (n, rad/s) that meets `jacobian` (m x n) `qdot = task` (m), is otherwise the
    /// conditioned mean for the `preferred` velocity, and keeps `q + dt qdot` within the limits.
    pub fn solve(
        &mut self,
        q: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        limits: &PostureLimits,
        dt: f64,
    ) -> Result<DVector<f64>, ReachExceeded> {
        // Locking all violators at once is fast; one at a time locks no more than needed.
        self.passes(q, jacobian, task, preferred, limits, (dt, false))
            .or_else(|_| self.passes(q, jacobian, task, preferred, limits, (dt, true)))
    }

    fn passes(
        &mut self,
        q: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        limits: &PostureLimits,
        (dt, one_at_a_time): (f64, bool),
    ) -> Result<DVector<f64>, ReachExceeded> {
        self.locked.fill(None);
        self.sums.clear();
        self.sums.resize(limits.sums.len(), None);
        for _ in 0..MOST_PASSES {
            let velocity = self.conditioned(jacobian, task, preferred, limits)?;
            let mut found = self.violations(q, &velocity, limits, dt);
            if found.is_empty() {
                return Ok(velocity);
            }
            if one_at_a_time {
                found.sort_by(|a, b| b.excess.total_cmp(&a.excess));
                found.truncate(1);
            }
            for v in found {
                match v.place {
                    Place::Joint(i) => self.locked[i] = Some(v.rate),
                    Place::Sum(i) => self.sums[i] = Some(v.rate),
                }
            }
        }
        Err(ReachExceeded)
    }

    /// The conditioned mean with locked joints and sums.
    fn conditioned(
        &self,
        jacobian: &DMatrix<f64>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        limits: &PostureLimits,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let (m, n) = jacobian.shape();
        let mut s = preferred.clone();
        for (i, rate) in self.locked.iter().enumerate() {
            if let Some(rate) = rate {
                s[i] = *rate;
            }
        }
        let held: Vec<(usize, f64)> =
            self.sums.iter().enumerate().filter_map(|(i, r)| r.map(|r| (i, r))).collect();
        let mut rows = DMatrix::zeros(m + held.len(), n);
        rows.rows_mut(0, m).copy_from(jacobian);
        let mut missing = DVector::zeros(m + held.len());
        missing.rows_mut(0, m).copy_from(task);
        for (k, (sum, rate)) in held.iter().enumerate() {
            for &c in &limits.sums[*sum].columns {
                rows[(m + k, c)] = 1.0;
            }
            missing[m + k] = *rate;
        }
        missing -= &rows * &s;
        // Free joints only: locked ones keep their given rate.
        for (i, rate) in self.locked.iter().enumerate() {
            if rate.is_some() {
                rows.column_mut(i).fill(0.0);
            }
        }
        let mut across = &self.weight * rows.transpose();
        for (i, rate) in self.locked.iter().enumerate() {
            if rate.is_some() {
                across.row_mut(i).fill(0.0);
            }
        }
        let mut gram = &rows * &across;
        // Rows of metres and of radians: scale to a unit diagonal before judging the rank.
        let scale = gram.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
        if scale.iter().any(|s| *s == 0.0 || !s.is_finite()) {
            return Err(ReachExceeded);
        }
        for i in 0..gram.nrows() {
            for j in 0..gram.ncols() {
                gram[(i, j)] *= scale[i] * scale[j];
            }
        }
        let factor = gram.cholesky().ok_or(ReachExceeded)?;
        if factor.l_dirty().diagonal().iter().any(|p| p * p < RANK_TOLERANCE) {
            return Err(ReachExceeded);
        }
        let multipliers = factor.solve(&missing.component_mul(&scale)).component_mul(&scale);
        let velocity = s + across * multipliers;
        if velocity.iter().all(|v| v.is_finite()) { Ok(velocity) } else { Err(ReachExceeded) }
    }

    fn violations(
        &self,
        q: &DVector<f64>,
        velocity: &DVector<f64>,
        limits: &PostureLimits,
        dt: f64,
    ) -> Vec<Violation> {
        let check = |place, at: f64, rate: f64, lower: f64, upper: f64| {
            let next = at + dt * rate;
            let (excess, bound) =
                if next < lower { (lower - next, lower) } else { (next - upper, upper) };
            (excess > LIMIT_TOLERANCE).then(|| Violation { place, excess, rate: (bound - at) / dt })
        };
        let joints = (0..q.len()).filter(|&i| self.locked[i].is_none()).filter_map(|i| {
            check(Place::Joint(i), q[i], velocity[i], limits.lower[i], limits.upper[i])
        });
        let sums = limits.sums.iter().enumerate().filter(|(i, _)| self.sums[*i].is_none());
        let sums = sums.filter_map(|(i, s)| {
            let total = |v: &DVector<f64>| s.columns.iter().map(|&c| v[c]).sum::<f64>();
            check(Place::Sum(i), total(q), total(velocity), s.lower, s.upper)
        });
        joints.chain(sums).collect()
    }
}

struct Violation {
    place: Place,
    excess: f64,
    rate: f64,
}

enum Place {
    Joint(usize),
    Sum(usize),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::SumRow;
    use crate::math::stream::{Purpose, normals, stream};
    use crate::posture::condition;
    use proptest::prelude::*;

    fn random(r: usize, c: usize, seed: u64) -> DMatrix<f64> {
        let mut rng = stream(seed, Purpose::Simulation, 1, 0);
        DMatrix::from_vec(r, c, normals(&mut rng, r * c))
    }

    fn wide(n: usize) -> PostureLimits {
        PostureLimits { lower: vec![-1e3; n], upper: vec![1e3; n], sums: Vec::new() }
    }

    proptest! {
        #[test]
        fn without_limits_it_is_the_conditioned_mean(seed in 0u64..50) {
            let (j, a) = (random(4, 9, seed), random(9, 9, seed + 100));
            let w = &a * a.transpose() + DMatrix::identity(9, 9) * 0.1;
            let z = random(9, 1, seed + 200).column(0).into_owned();
            let x = random(4, 1, seed + 300).column(0).into_owned();
            let q = DVector::zeros(9);
            let own = StepSolver::new(w.clone()).solve(&q, &j, &x, &z, &wide(9), 0.1).unwrap();
            let reference = condition(&j, &w, &z, &x).unwrap().mean;
            prop_assert!((own - reference).norm() < 1e-7);
        }

        #[test]
        fn limits_hold_and_the_task_is_met(seed in 0u64..200) {
            let (j, a) = (random(3, 10, seed), random(10, 10, seed + 100));
            let w = &a * a.transpose() + DMatrix::identity(10, 10) * 0.1;
            let z = random(10, 1, seed + 200).column(0).into_owned();
            let x = random(3, 1, seed + 300).column(0) * 0.3;
            let q = DVector::zeros(10);
            let limits = PostureLimits {
                lower: vec![-0.06; 10],
                upper: vec![0.05; 10],
                sums: vec![SumRow { name: "s".into(), columns: vec![0, 1, 2], lower: -0.04, upper: 0.04 }],
            };
            if let Ok(v) = StepSolver::new(w).solve(&q, &j, &x, &z, &limits, 0.1) {
                prop_assert!((&j * &v - &x).norm() < 1e-8);
                let next: Vec<f64> = (q + v * 0.1).iter().copied().collect();
                prop_assert!(limits.violation(&next) < 1e-9);
            }
        }
    }

    #[test]
    fn an_impossible_task_is_reported() {
        let j = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let limits = PostureLimits { lower: vec![0.0; 2], upper: vec![0.1; 2], sums: Vec::new() };
        let mut solver = StepSolver::new(DMatrix::identity(2, 2));
        let task = DVector::from_element(1, 3.0);
        let zero = DVector::zeros(2);
        assert!(solver.solve(&zero, &j, &task, &zero, &limits, 0.1).is_err());
        let task = DVector::from_element(1, 1.5);
        let v = solver.solve(&zero, &j, &task, &DVector::from_vec(vec![2.0, 0.0]), &limits, 0.1);
        assert!((v.unwrap() - DVector::from_vec(vec![1.0, 0.5])).norm() < 1e-9);
    }
}

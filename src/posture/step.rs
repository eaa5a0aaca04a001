//! One step of a posture under limits: lock and resolve.
//!
//! Solve the conditioned Gaussian; if a joint would leave its range, lock it at the limit (its weight
//! becomes zero, its velocity is given) and solve again; if a bounded *sum* of joints would leave its
//! range, or what follows from the joints (a leg, the centre of mass) would leave its own, it becomes an
//! equality row of the task. The hand stays on its path while a solution exists.
//! Clamping after the step would take the hand off the path; rejecting would bias the distribution.

use crate::human::PostureLimits;
use crate::math::simd::wide;
use nalgebra::{DMatrix, DVector};

/// Ratio of pivots of `J W J^T` (in units of its diagonal) below which the task is out of reach.
const RANK_TOLERANCE: f64 = 1e-10;
/// Violations smaller than this (rad) are rounding.
const LIMIT_TOLERANCE: f64 = 1e-10;
const MOST_PASSES: usize = 48;
/// Rows of the task that are treated together, and joints.
const LANES: usize = 8;
const ABREAST: usize = 4;

/// Eight rows of the task at one joint; those that the task does not have are zero.
type Lanes = [f64; LANES];

/// Bounds that hold near one posture only: each on a weighted sum of the leading columns.
#[derive(Debug, Clone, Default)]
pub struct Bounds {
    coefficients: Vec<f64>,
    rows: Vec<Bound>,
}

/// One of them: its coefficients from here, and as many; its value now and its range.
#[derive(Debug, Clone, Copy)]
struct Bound {
    from: usize,
    count: usize,
    at: f64,
    lower: f64,
    upper: f64,
}

/// Everything that a posture may not leave.
#[derive(Debug, Clone, Copy)]
pub struct Allowed<'a> {
    /// Ranges of the joints and of sums of them.
    pub limits: &'a PostureLimits,
    /// What holds near the posture.
    pub bounds: &'a Bounds,
}

static NO_BOUNDS: Bounds = Bounds { coefficients: Vec::new(), rows: Vec::new() };

impl<'a> From<&'a PostureLimits> for Allowed<'a> {
    fn from(limits: &'a PostureLimits) -> Self {
        Self { limits, bounds: &NO_BOUNDS }
    }
}

impl Bounds {
    pub(super) fn clear(&mut self) {
        self.coefficients.clear();
        self.rows.clear();
    }

    /// Adds `lower <= at + coefficients . change <= upper`.
    pub(super) fn push(&mut self, coefficients: &[f64], at: f64, (lower, upper): (f64, f64)) {
        let (from, count) = (self.coefficients.len(), coefficients.len());
        self.coefficients.extend_from_slice(coefficients);
        self.rows.push(Bound { from, count, at, lower, upper });
    }
}

impl Bound {
    fn of<'a>(&self, all: &'a [f64]) -> &'a [f64] {
        &all[self.from..self.from + self.count]
    }

    fn along(&self, all: &[f64], v: &DVector<f64>) -> f64 {
        self.of(all).iter().zip(v.iter()).map(|(c, v)| c * v).sum()
    }
}

/// The limits or the geometry leave no joint velocity that meets the task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReachExceeded;

/// Solves steps for one weight matrix; keeps its scratch between steps.
#[derive(Debug, Clone)]
pub struct StepSolver {
    weight: DMatrix<f64>,
    locked: Vec<Option<f64>>,
    sums: Vec<Option<f64>>,
    /// Of the bounds.
    bound: Vec<Option<f64>>,
    system: System,
    /// That of the posture of this number with nothing held: all that is asked there shares it.
    free: System,
    free_at: Option<u64>,
    /// Whether it was solved last.
    is_free: bool,
}

/// The equations of one pass: m rows of the task and of held sums, in blocks of eight; n joints.
#[derive(Debug, Clone, Default)]
struct System {
    /// Rows, m.
    count: usize,
    /// Blocks of rows, b.
    blocks: usize,
    /// Joint by joint the rows of the task, zero where the joint is locked: n x b.
    rows: Vec<Lanes>,
    /// Joint by joint `W J^T`, n x b.
    across: Vec<Lanes>,
    /// Row by row `J W J^T`, m x b.
    gram: Vec<Lanes>,
    /// Its Cholesky factor in units of its diagonal, m x m, with inverse pivots; then those units, m.
    factor: Vec<f64>,
    /// What the preferred velocity leaves of the task, b; m/s, rad/s.
    missing: Vec<Lanes>,
}

impl StepSolver {
    /// For a symmetric positive definite weight, n x n.
    pub fn new(weight: DMatrix<f64>) -> Self {
        let n = weight.nrows();
        Self {
            weight,
            locked: vec![None; n],
            sums: Vec::new(),
            bound: Vec::new(),
            system: System::default(),
            free: System::default(),
            free_at: None,
            is_free: false,
        }
    }

    /// Takes another weight of the same size.
    pub fn set_weight(&mut self, weight: DMatrix<f64>) {
        self.weight = weight;
        self.free_at = None;
    }

    /// Joint velocity (n, rad/s) that meets `jacobian` (m x n) `qdot = task` (m), is otherwise the
    /// conditioned mean for the `preferred` velocity, and keeps `q + dt qdot` within what is allowed.
    pub fn solve<'a>(
        &mut self,
        q: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        allowed: impl Into<Allowed<'a>>,
        dt: f64,
    ) -> Result<DVector<f64>, ReachExceeded> {
        self.solve_at(q, (jacobian, None), task, preferred, allowed.into(), dt)
    }

    /// The same at a posture with a number, which says that its `jacobian` is the same as when it was seen last.
    fn solve_at(
        &mut self,
        q: &DVector<f64>,
        jacobian: (&DMatrix<f64>, Option<u64>),
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        allowed: Allowed,
        dt: f64,
    ) -> Result<DVector<f64>, ReachExceeded> {
        // Locking all violators at once is fast; one at a time locks no more than needed.
        self.passes(q, jacobian, task, preferred, allowed, (dt, false))
            .or_else(|_| self.passes(q, jacobian, task, preferred, allowed, (dt, true)))
    }

    /// The same where the task follows the velocity along a curve: `beyond` (m) is what a velocity brings of it
    /// that `jacobian` does not show. One correction, with the same joints at their limits, unless others would
    /// then leave theirs. `number` names the posture: asked again under the same one, the Jacobian is taken to be
    /// the same.
    pub(super) fn solve_curved<'a>(
        &mut self,
        (q, number): (&DVector<f64>, u64),
        (jacobian, beyond): (&DMatrix<f64>, impl Fn(&DVector<f64>) -> DVector<f64>),
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        allowed: impl Into<Allowed<'a>>,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let allowed = allowed.into();
        let there = (jacobian, Some(number));
        let straight = self.solve_at(q, there, task, preferred, allowed, 1.0)?;
        let solved = if self.is_free { &mut self.free } else { &mut self.system };
        let curved = solved.also(&straight, &-beyond(&straight));
        let is_allowed = self.violations(q, &curved, allowed, 1.0).is_empty();
        Ok(if is_allowed { curved } else { straight })
    }

    fn passes(
        &mut self,
        q: &DVector<f64>,
        jacobian: (&DMatrix<f64>, Option<u64>),
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        allowed: Allowed,
        (dt, one_at_a_time): (f64, bool),
    ) -> Result<DVector<f64>, ReachExceeded> {
        self.locked.fill(None);
        for (list, count) in [
            (&mut self.sums, allowed.limits.sums.len()),
            (&mut self.bound, allowed.bounds.rows.len()),
        ] {
            list.clear();
            list.resize(count, None);
        }
        for _ in 0..MOST_PASSES {
            let velocity = self.conditioned(jacobian, task, preferred, allowed)?;
            let mut found = self.violations(q, &velocity, allowed, dt);
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
                    Place::Bound(i) => self.bound[i] = Some(v.rate),
                }
            }
        }
        Err(ReachExceeded)
    }

    /// The conditioned mean with locked joints, sums and bounds.
    fn conditioned(
        &mut self,
        (jacobian, number): (&DMatrix<f64>, Option<u64>),
        task: &DVector<f64>,
        preferred: &DVector<f64>,
        Allowed { limits, bounds }: Allowed,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let is_held = |list: &[Option<f64>]| list.iter().any(Option::is_some);
        let holds = [&self.locked, &self.sums, &self.bound].into_iter().any(|l| is_held(l));
        self.is_free = number.is_some() && !holds;
        if self.is_free {
            return self.conditioned_freely((jacobian, number), task, preferred);
        }
        let Self { weight, locked, sums, bound, system, .. } = self;
        let mut velocity = preferred.clone();
        for (v, rate) in velocity.iter_mut().zip(locked.iter()) {
            *v = rate.unwrap_or(*v);
        }
        let (sums, bound) = (held(sums), held(bound));
        let count = task.len() + sums.clone().count() + bound.clone().count();
        system.fill(count, jacobian);
        system.ask(task);
        let mut row = task.len();
        for (sum, rate) in sums {
            for &column in &limits.sums[sum].columns {
                system.set(row, column, 1.0);
            }
            system.missing[row / LANES][row % LANES] = rate;
            row += 1;
        }
        for (i, rate) in bound {
            for (column, c) in bounds.rows[i].of(&bounds.coefficients).iter().enumerate() {
                system.set(row, column, *c);
            }
            system.missing[row / LANES][row % LANES] = rate;
            row += 1;
        }
        let is_solved = wide(
            #[inline(always)]
            || {
                system.subtract(velocity.as_slice());
                system.release(locked);
                system.multiply(weight.as_slice(), locked);
                system.factorise() && {
                    system.substitute();
                    system.add_to(velocity.as_mut_slice());
                    true
                }
            },
        );
        if is_solved && velocity.iter().all(|v| v.is_finite()) {
            Ok(velocity)
        } else {
            Err(ReachExceeded)
        }
    }

    /// The same with nothing held: the system is made once for a posture.
    fn conditioned_freely(
        &mut self,
        (jacobian, number): (&DMatrix<f64>, Option<u64>),
        task: &DVector<f64>,
        preferred: &DVector<f64>,
    ) -> Result<DVector<f64>, ReachExceeded> {
        let Self { weight, locked, free, free_at, .. } = self;
        let is_known = *free_at == number;
        if !is_known {
            free.fill(jacobian.nrows(), jacobian);
            *free_at = None;
        }
        free.ask(task);
        let mut velocity = preferred.clone();
        let is_solved = wide(
            #[inline(always)]
            || {
                free.subtract(velocity.as_slice());
                if !is_known {
                    free.multiply(weight.as_slice(), locked);
                }
                (is_known || free.factorise()) && {
                    free.substitute();
                    free.add_to(velocity.as_mut_slice());
                    true
                }
            },
        );
        if !is_solved {
            return Err(ReachExceeded);
        }
        *free_at = number;
        if velocity.iter().all(|v| v.is_finite()) { Ok(velocity) } else { Err(ReachExceeded) }
    }

    fn violations(
        &self,
        q: &DVector<f64>,
        velocity: &DVector<f64>,
        Allowed { limits, bounds }: Allowed,
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
        let bounds =
            bounds.rows.iter().enumerate().filter(|(i, _)| self.bound[*i].is_none()).filter_map(
                |(i, b)| {
                    let rate = b.along(&bounds.coefficients, velocity);
                    check(Place::Bound(i), b.at, rate, b.lower, b.upper)
                },
            );
        joints.chain(sums).chain(bounds).collect()
    }
}

#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
impl System {
    /// Sizes everything for `count` rows, of which the task gives the first.
    fn fill(&mut self, count: usize, jacobian: &DMatrix<f64>) {
        let (m, n) = jacobian.shape();
        self.count = count;
        self.blocks = count.div_ceil(LANES);
        for (list, length) in [
            (&mut self.rows, n * self.blocks),
            (&mut self.across, n * self.blocks),
            (&mut self.gram, count * self.blocks),
        ] {
            list.clear();
            list.resize(length, [0.0; LANES]);
        }
        if m == 0 {
            return;
        }
        let columns = jacobian.as_slice().chunks_exact(m);
        for (own, column) in self.rows.chunks_exact_mut(self.blocks).zip(columns) {
            own.as_flattened_mut()[..m].copy_from_slice(column);
        }
    }

    /// What the first rows are to come to.
    fn ask(&mut self, task: &DVector<f64>) {
        self.missing.clear();
        self.missing.resize(self.blocks, [0.0; LANES]);
        self.missing.as_flattened_mut()[..task.len()].copy_from_slice(task.as_slice());
    }

    fn set(&mut self, row: usize, column: usize, value: f64) {
        self.rows[column * self.blocks + row / LANES][row % LANES] = value;
    }

    /// Takes away from the task what a joint velocity (n, rad/s) does already.
    #[inline(always)]
    fn subtract(&mut self, velocity: &[f64]) {
        for (column, v) in self.rows.chunks_exact(self.blocks.max(1)).zip(velocity) {
            for (missing, row) in self.missing.iter_mut().zip(column) {
                for (m, r) in missing.iter_mut().zip(row) {
                    *m = r.mul_add(-v, *m);
                }
            }
        }
    }

    /// Locked joints keep their given rate: they no longer serve the task.
    #[inline(always)]
    fn release(&mut self, locked: &[Option<f64>]) {
        for (column, rate) in self.rows.chunks_exact_mut(self.blocks.max(1)).zip(locked) {
            if rate.is_some() {
                column.fill([0.0; LANES]);
            }
        }
    }

    /// `W J^T` of the free joints and `J W J^T`, for a symmetric W, n x n.
    #[inline(always)]
    fn multiply(&mut self, weight: &[f64], locked: &[Option<f64>]) {
        let Self { count, blocks, rows, across, gram, .. } = self;
        let (count, blocks, n) = (*count, *blocks, locked.len());
        for b in 0..blocks {
            // Several joints at a time: their sums do not wait for each other.
            for first in (0..n).step_by(ABREAST) {
                let mut sums = [[0.0; LANES]; ABREAST];
                let weights: [&[f64]; ABREAST] =
                    std::array::from_fn(|a| &weight[(first + a).min(n - 1) * n..][..n]);
                let [w0, w1, w2, w3] = weights;
                let own = rows.iter().skip(b).step_by(blocks);
                for ((((row, a), b), c), d) in own.zip(w0).zip(w1).zip(w2).zip(w3) {
                    for (sum, w) in sums.iter_mut().zip([a, b, c, d]) {
                        add_multiple(sum, *w, row);
                    }
                }
                for (i, sum) in (first..n).zip(sums) {
                    if locked[i].is_none() {
                        across[i * blocks + b] = sum;
                    }
                }
            }
            // Some rows of the product at a time, so that they stay in registers; only its lower triangle is
            // looked at.
            for from in (b * LANES..count).step_by(ABREAST) {
                let mut sums = [[0.0; LANES]; ABREAST];
                let left = rows.iter().skip(from / LANES).step_by(blocks);
                for (left, right) in left.zip(across.iter().skip(b).step_by(blocks)) {
                    let (halves, _) = left.as_chunks::<ABREAST>();
                    for (sum, l) in sums.iter_mut().zip(&halves[from % LANES / ABREAST]) {
                        add_multiple(sum, *l, right);
                    }
                }
                for (row, sum) in (from..count).zip(sums) {
                    gram[row * blocks + b] = sum;
                }
            }
        }
    }

    /// False where a row depends on others.
    #[inline(always)]
    fn factorise(&mut self) -> bool {
        let Self { count, blocks, gram, factor, .. } = self;
        let count = *count;
        let gram = gram.as_flattened();
        let stride = *blocks * LANES;
        // Rows of metres and of radians: scale to a unit diagonal before judging the rank.
        factor.clear();
        factor.resize(count * count + count, 0.0);
        let (factor, scale) = factor.split_at_mut(count * count);
        for (i, s) in scale.iter_mut().enumerate() {
            *s = 1.0 / gram[i * stride + i].sqrt();
            if !s.is_finite() {
                return false;
            }
        }
        for i in 0..count {
            for j in 0..=i {
                let mut sum = gram[i * stride + j] * scale[i] * scale[j];
                for k in 0..j {
                    sum = factor[i * count + k].mul_add(-factor[j * count + k], sum);
                }
                if i > j {
                    factor[i * count + j] = sum * factor[j * count + j];
                } else if sum >= RANK_TOLERANCE {
                    // The inverse of the pivot's root: it is only ever divided by.
                    factor[i * count + i] = 1.0 / sum.sqrt();
                } else {
                    return false;
                }
            }
        }
        true
    }

    /// Replaces the missing part of the task by the multipliers.
    #[inline(always)]
    fn substitute(&mut self) {
        let Self { count, missing, factor, .. } = self;
        let count = *count;
        let missing = missing.as_flattened_mut();
        let (factor, scale) = factor.split_at(count * count);
        for i in 0..count {
            let mut sum = missing[i] * scale[i];
            for k in 0..i {
                sum = factor[i * count + k].mul_add(-missing[k], sum);
            }
            missing[i] = sum * factor[i * count + i];
        }
        for i in (0..count).rev() {
            let mut sum = missing[i];
            for k in i + 1..count {
                sum = factor[k * count + i].mul_add(-missing[k], sum);
            }
            missing[i] = sum * factor[i * count + i];
        }
        missing.iter_mut().zip(scale).for_each(|(m, s)| *m *= *s);
    }

    /// A velocity (n) of the system that was solved last, with some more of the task done.
    fn also(&mut self, velocity: &DVector<f64>, task: &DVector<f64>) -> DVector<f64> {
        self.missing.fill([0.0; LANES]);
        self.missing.as_flattened_mut()[..task.len()].copy_from_slice(task.as_slice());
        let mut more = velocity.clone();
        wide(
            #[inline(always)]
            || {
                self.substitute();
                self.add_to(more.as_mut_slice());
            },
        );
        more
    }

    /// Adds `W J^T` times the multipliers to a joint velocity, n, rad/s.
    #[inline(always)]
    fn add_to(&self, velocity: &mut [f64]) {
        for (v, column) in velocity.iter_mut().zip(self.across.chunks_exact(self.blocks.max(1))) {
            let terms = column.as_flattened().iter().zip(self.missing.as_flattened());
            *v += terms.fold(0.0, |sum: f64, (a, m)| a.mul_add(*m, sum));
        }
    }
}

#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
fn add_multiple(sum: &mut Lanes, factor: f64, lanes: &Lanes) {
    for (s, l) in sum.iter_mut().zip(lanes) {
        *s = factor.mul_add(*l, *s);
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
    Bound(usize),
}

/// Those that are held, with their rates.
fn held(list: &[Option<f64>]) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
    list.iter().enumerate().filter_map(|(i, r)| r.map(|r| (i, r)))
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
        fn without_limits_it_is_the_conditioned_mean(seed in 0u64..50, m in 1usize..11) {
            let (j, a) = (random(m, 14, seed), random(14, 14, seed + 100));
            let w = &a * a.transpose() + DMatrix::identity(14, 14) * 0.1;
            let z = random(14, 1, seed + 200).column(0).into_owned();
            let x = random(m, 1, seed + 300).column(0).into_owned();
            let q = DVector::zeros(14);
            let own = StepSolver::new(w.clone()).solve(&q, &j, &x, &z, &wide(14), 0.1).unwrap();
            let reference = condition(&j, &w, &z, &x).unwrap().mean;
            prop_assert!((&j * &own - &x).norm() < 1e-8);
            prop_assert!((own - reference).norm() < 1e-6);
        }

        #[test]
        fn what_is_asked_at_one_posture_is_answered_as_by_one_who_asks_once(seed in 0u64..60) {
            let random = |r: usize, c: usize, k: u64| random(r, c, 10 * seed + k);
            let (j, a) = ([random(3, 10, 1), random(3, 10, 2)], random(10, 10, 3));
            let w = &a * a.transpose() + DMatrix::identity(10, 10) * 0.1;
            let q = DVector::zeros(10);
            let limits = PostureLimits {
                lower: vec![-0.9; 10],
                upper: vec![0.9; 10],
                sums: Vec::new(),
            };
            let straight = |_: &DVector<f64>| DVector::zeros(3);
            let mut solver = StepSolver::new(w.clone());
            // The same posture three times, another one, and the first under a new number.
            for (k, (which, number)) in [(0, 1), (0, 1), (0, 1), (1, 2), (0, 3)].into_iter().enumerate() {
                let z = random(10, 1, 4 + k as u64).column(0).into_owned();
                let x = random(3, 1, 9 + k as u64).column(0) * 0.3;
                let own = solver.solve_curved((&q, number), (&j[which], straight), &x, &z, &limits);
                let once = StepSolver::new(w.clone()).solve(&q, &j[which], &x, &z, &limits, 1.0);
                prop_assert_eq!(own, once);
            }
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

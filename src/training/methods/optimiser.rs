//! Minimisation: argmin's L-BFGS and BIPOP-CMA-ES of the crate cmaes behind two plain calls.
//!
//! Both return the best point that was ever evaluated, so that a line search that gives up at the
//! limit of rounding costs nothing.

use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use cmaes::restart::{RestartOptions, RestartStrategy};
use std::cell::RefCell;
use std::collections::VecDeque;

/// Steps that L-BFGS remembers.
const MEMORY: usize = 10;
/// Norm of the scaled gradient below which the search ends.
const GRADIENT_TOLERANCE: f64 = 1e-9;

/// Value and gradient at a point.
pub(super) type ValueAndGradient = (f64, Vec<f64>);

/// Points that are remembered: those of one line search.
const REMEMBERED: usize = 8;

struct Seen {
    /// The newest last.
    recent: VecDeque<(Vec<f64>, ValueAndGradient)>,
    best: Option<(Vec<f64>, f64)>,
}

impl Seen {
    fn keep(&mut self, x: &[f64], found: &ValueAndGradient) {
        if found.0.is_finite() && self.best.as_ref().is_none_or(|(_, b)| found.0 < *b) {
            self.best = Some((x.to_vec(), found.0));
        }
        if self.recent.len() == REMEMBERED {
            self.recent.pop_front();
        }
        self.recent.push_back((x.to_vec(), found.clone()));
    }
}

/// A function whose last values are kept, because solvers ask for value and gradient apart, and line
/// searches return to points they have seen.
struct Remembered<'a, F> {
    function: &'a F,
    seen: &'a RefCell<Seen>,
}

impl<F: Fn(&[f64]) -> ValueAndGradient> Remembered<'_, F> {
    fn at(&self, x: &[f64]) -> ValueAndGradient {
        if let Some((_, found)) = self.seen.borrow().recent.iter().rev().find(|(p, _)| p == x) {
            return found.clone();
        }
        let found = (self.function)(x);
        self.seen.borrow_mut().keep(x, &found);
        found
    }
}

impl<F: Fn(&[f64]) -> ValueAndGradient> CostFunction for Remembered<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.at(x).0)
    }
}

impl<F: Fn(&[f64]) -> ValueAndGradient> Gradient for Remembered<'_, F> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.at(x).1)
    }
}

/// L-BFGS from `start`, until an iteration gains less than `tolerance`; the best point and its value.
///
/// The function is scaled by its gradient at the start, because the first step of the line search is
/// as long as the gradient: sums of log-likelihoods would leave the range of floats.
pub(super) fn descend(
    function: &impl Fn(&[f64]) -> ValueAndGradient,
    start: &[f64],
    iterations: u64,
    tolerance: f64,
) -> (Vec<f64>, f64) {
    let seen = RefCell::new(Seen { recent: VecDeque::new(), best: None });
    let first = function(start);
    let steep = first.1.iter().map(|g| g * g).sum::<f64>().sqrt();
    let scale = if steep.is_finite() { 1.0 / steep.max(1.0) } else { 1.0 };
    let rescaled = |(value, gradient): ValueAndGradient| -> ValueAndGradient {
        (value * scale, gradient.into_iter().map(|g| g * scale).collect())
    };
    let scaled = |x: &[f64]| rescaled(function(x));
    seen.borrow_mut().keep(start, &rescaled(first));
    let problem = Remembered { function: &scaled, seen: &seen };
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY)
        .with_tolerance_cost((tolerance * scale).max(1e-14))
        .and_then(|solver| solver.with_tolerance_grad(GRADIENT_TOLERANCE))
        .map(|solver| {
            Executor::new(problem, solver)
                .configure(|state| state.param(start.to_vec()).max_iters(iterations))
                .timer(false)
                .run()
                .map(|_| ())
        });
    let (x, value) = finish(solver, seen, start);
    (x, value / scale)
}

/// BIPOP-CMA-ES, the paper's optimiser: runs started anywhere within `range` of each coordinate, at
/// most `evaluations` in all; the best point and its value.
pub(super) fn evolve(
    function: &impl Fn(&[f64]) -> f64,
    dimensions: usize,
    range: std::ops::RangeInclusive<f64>,
    evaluations: usize,
    seed: u64,
) -> Option<(Vec<f64>, f64)> {
    // An infinite value would end the search, and a runaway coordinate helps nobody.
    let bounded = |x: &cmaes::DVector<f64>| {
        let value = function(x.as_slice());
        let beyond: f64 = x.iter().map(|v| (v.abs() - 6.0).max(0.0).powi(2)).sum();
        if value.is_finite() { value + 1e3 * beyond } else { 1e12 + 1e9 * beyond }
    };
    let strategy = RestartStrategy::BIPOP(cmaes::restart::BIPOP::default());
    let search = RestartOptions::new(dimensions, range, strategy)
        .max_function_evals(evaluations)
        .seed(seed)
        .build()
        .ok()?;
    let best = search.run(|| &bounded).best?;
    Some((best.point.as_slice().to_vec(), best.value))
}

/// A search that stopped early is judged by the best it saw, whatever the reason.
fn finish<T>(_outcome: T, seen: RefCell<Seen>, start: &[f64]) -> (Vec<f64>, f64) {
    seen.into_inner().best.unwrap_or_else(|| (start.to_vec(), f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valley(x: &[f64]) -> ValueAndGradient {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        (a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x[0] * b, 200.0 * b])
    }

    #[test]
    fn both_find_the_floor_of_the_valley() {
        let (x, value) = descend(&valley, &[-1.2, 1.0], 200, 1e-10);
        assert!((x[0] - 1.0).abs() < 1e-4 && value < 1e-8, "{x:?} {value}");
        let seek = |seed| evolve(&|x: &[f64]| valley(x).0, 2, -2.0..=2.0, 3000, seed).unwrap();
        let (x, _) = seek(5);
        assert!((x[0] - 1.0).abs() < 1e-3, "{x:?}");
        assert_eq!(seek(5), seek(5));
    }
}

//! CMA-ES with ask and tell: the search distribution is handed out and takes back an *order*, so
//! that the caller may judge a generation in its own way (together, with few or many samples each).
//!
//! Strategy parameters and update rules of N. Hansen, The CMA Evolution Strategy: A Tutorial
//! (arXiv 1604.00772, table 1), with positive weights only.

use crate::math::stream::normals;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Condition number of the covariance from which on a run has nothing left to adapt.
const WORST_CONDITION: f64 = 1e14;

/// A search distribution `N(mean, sigma^2 C)` over n numbers and its memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cma {
    mean: DVector<f64>,
    sigma: f64,
    covariance: DMatrix<f64>,
    /// `C = B diag(d^2) B^T`: columns of B, and d.
    axes: DMatrix<f64>,
    lengths: DVector<f64>,
    path_c: DVector<f64>,
    path_sigma: DVector<f64>,
    population: usize,
    generation: usize,
    /// Standard deviation above which the distribution does not grow.
    widest: f64,
}

/// The strategy parameters for n numbers and a population.
struct Rates {
    weights: Vec<f64>,
    mu_eff: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// E |N(0, I)|.
    chi: f64,
}

impl Rates {
    fn of(n: usize, population: usize) -> Self {
        let n = n as f64;
        let half = population as f64 / 2.0;
        let parents = population / 2;
        let raw: Vec<f64> = (1..=parents).map(|i| (half + 0.5).ln() - (i as f64).ln()).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        let c_mu =
            (2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / ((n + 2.0).powi(2) + mu_eff)).min(1.0 - c_1);
        Self {
            weights,
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu,
            chi: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

impl Cma {
    /// Starts at `mean` with standard deviation `sigma` along every axis; `None` without numbers, for
    /// a population below 4, or for a start that is not finite.
    pub fn new(mean: Vec<f64>, sigma: f64, population: usize) -> Option<Self> {
        let n = mean.len();
        let is_usable = n > 0 && population >= 4 && sigma > 0.0 && sigma.is_finite();
        if !is_usable || mean.iter().any(|x| !x.is_finite()) {
            return None;
        }
        Some(Self {
            mean: DVector::from_vec(mean),
            sigma,
            covariance: DMatrix::identity(n, n),
            axes: DMatrix::identity(n, n),
            lengths: DVector::from_element(n, 1.0),
            path_c: DVector::zeros(n),
            path_sigma: DVector::zeros(n),
            population,
            generation: 0,
            widest: f64::INFINITY,
        })
    }

    /// Why one that was read cannot go on; none where it can.
    pub fn fault(&self) -> Option<&'static str> {
        let n = self.mean.len();
        let vectors = [&self.mean, &self.lengths, &self.path_c, &self.path_sigma];
        let matrices = [&self.covariance, &self.axes];
        if n == 0
            || self.population < 4
            || vectors.iter().any(|v| v.len() != n)
            || matrices.iter().any(|m| m.shape() != (n, n) || m.len() != n * n)
        {
            return Some("its sizes do not agree");
        }
        let is_finite = vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && matrices.iter().all(|m| m.iter().all(|x| x.is_finite()));
        let is_wide = self.sigma.is_finite() && self.sigma > 0.0 && self.widest > 0.0;
        let is_long = self.lengths.iter().all(|l| *l > 0.0);
        (!(is_finite && is_wide && is_long)).then_some("a number of it cannot be")
    }

    /// The same, its standard deviation never above `widest`: where the numbers are white, larger
    /// steps leave what is likely.
    #[must_use]
    pub fn not_wider_than(self, widest: f64) -> Self {
        Self { sigma: self.sigma.min(widest), widest, ..self }
    }

    /// The next generation, as many points as the population, n numbers each.
    pub fn ask(&self, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let n = self.mean.len();
        (0..self.population)
            .map(|_| {
                let z = DVector::from_vec(normals(rng, n));
                // The symmetric root: it does not hang on the signs and order of the axes.
                let turned = self.axes.tr_mul(&z).component_mul(&self.lengths);
                (&self.mean + &self.axes * turned * self.sigma).as_slice().to_vec()
            })
            .collect()
    }

    /// Learns from a generation in order, best first. Fewer points than half the population, or ones
    /// of another length, teach nothing.
    pub fn tell(&mut self, ordered: &[Vec<f64>]) {
        let n = self.mean.len();
        let r = Rates::of(n, self.population);
        let parents = r.weights.len();
        if ordered.len() < parents || ordered.iter().any(|x| x.len() != n) {
            return;
        }
        let steps: Vec<DVector<f64>> = ordered[..parents]
            .iter()
            .map(|x| (DVector::from_column_slice(x) - &self.mean) / self.sigma)
            .collect();
        let step: DVector<f64> =
            steps.iter().zip(&r.weights).fold(DVector::zeros(n), |sum, (y, w)| sum + y * *w);
        self.mean += &step * self.sigma;
        self.generation += 1;
        self.lengthen_paths(&r, &step);
        self.turn(&r, &steps);
    }

    /// Evolution paths, and the step size from the length of one of them.
    fn lengthen_paths(&mut self, r: &Rates, step: &DVector<f64>) {
        let n = step.len() as f64;
        // C^(-1/2) step.
        let mut white = self.axes.tr_mul(step).component_div(&self.lengths);
        white = &self.axes * white;
        self.path_sigma *= 1.0 - r.c_sigma;
        self.path_sigma += white * (r.c_sigma * (2.0 - r.c_sigma) * r.mu_eff).sqrt();
        let length = self.path_sigma.norm();
        let decayed = 1.0 - (1.0 - r.c_sigma).powf(2.0 * self.generation as f64);
        let is_stalled = length / decayed.sqrt() / r.chi >= 1.4 + 2.0 / (n + 1.0);
        self.path_c *= 1.0 - r.c_c;
        if is_stalled {
            // The missing variance of a path that was held back.
            self.covariance *= 1.0 + r.c_1 * r.c_c * (2.0 - r.c_c);
        } else {
            self.path_c += step * (r.c_c * (2.0 - r.c_c) * r.mu_eff).sqrt();
        }
        self.sigma *= ((r.c_sigma / r.d_sigma) * (length / r.chi - 1.0)).exp();
        self.sigma = self.sigma.min(self.widest);
    }

    /// The covariance from the path (rank one) and the generation (rank mu), and its axes.
    fn turn(&mut self, r: &Rates, steps: &[DVector<f64>]) {
        self.covariance *= 1.0 - r.c_1 - r.c_mu;
        self.covariance.ger(r.c_1, &self.path_c, &self.path_c, 1.0);
        for (y, w) in steps.iter().zip(&r.weights) {
            self.covariance.ger(r.c_mu * w, y, y, 1.0);
        }
        let symmetric = (&self.covariance + self.covariance.transpose()) * 0.5;
        let eigen = symmetric.clone().symmetric_eigen();
        self.covariance = symmetric;
        let floor = eigen.eigenvalues.max() / WORST_CONDITION;
        self.lengths = eigen.eigenvalues.map(|v| v.max(floor).sqrt());
        self.axes = eigen.eigenvectors;
    }

    /// The centre of the distribution, n numbers.
    pub fn mean(&self) -> &[f64] {
        self.mean.as_slice()
    }

    /// The largest standard deviation along any direction.
    pub fn spread(&self) -> f64 {
        self.sigma * self.lengths.max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};

    /// Evaluations until `f` is below `goal`, by our search.
    fn ours(f: impl Fn(&[f64]) -> f64, n: usize, seed: u64, goal: f64) -> usize {
        let mut cma = Cma::new(vec![1.0; n], 0.5, 4 + (3.0 * (n as f64).ln()) as usize).unwrap();
        let mut count = 0;
        for generation in 0..3000 {
            let mut rng = stream(seed, Purpose::Search, generation, 0);
            let mut all = cma.ask(&mut rng);
            all.sort_by(|a, b| f(a).total_cmp(&f(b)));
            count += all.len();
            if f(&all[0]) < goal {
                return count;
            }
            cma.tell(&all);
        }
        usize::MAX
    }

    /// The same by the crate `cmaes`, at the same start, step size and population.
    fn theirs(f: impl Fn(&[f64]) -> f64 + 'static, n: usize, seed: u64, goal: f64) -> usize {
        let wrapped = move |x: &cmaes::DVector<f64>| f(x.as_slice());
        let mut state = cmaes::CMAESOptions::new(vec![1.0; n], 0.5)
            .seed(seed)
            .weights(cmaes::Weights::Positive)
            .fun_target(goal)
            .max_function_evals(60_000)
            .build(wrapped)
            .unwrap();
        let _ = state.run();
        state.function_evals()
    }

    fn ellipsoid(x: &[f64]) -> f64 {
        let n = x.len() as f64;
        x.iter().enumerate().map(|(i, v)| 1e4f64.powf(i as f64 / (n - 1.0)) * v * v).sum()
    }

    fn rosenbrock(x: &[f64]) -> f64 {
        x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
    }

    #[test]
    fn as_many_evaluations_as_another_implementation() {
        type Function = fn(&[f64]) -> f64;
        for f in
            [ellipsoid as Function, |x| rosenbrock(&x.iter().map(|v| v - 2.0).collect::<Vec<_>>())]
        {
            let mean = |counts: Vec<usize>| counts.iter().sum::<usize>() as f64 / 6.0;
            let own = mean((0..6).map(|s| ours(f, 6, s, 1e-9)).collect());
            let other = mean((0..6).map(|s| theirs(f, 6, s, 1e-9)).collect());
            assert!(own < 1.25 * other && other < 1.25 * own, "{own} against {other}");
        }
    }

    #[test]
    fn the_same_stream_makes_the_same_search() {
        assert_eq!(ours(ellipsoid, 4, 3, 1e-6), ours(ellipsoid, 4, 3, 1e-6));
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(Cma::new(vec![], 1.0, 8).is_none());
        assert!(Cma::new(vec![0.0], 0.0, 8).is_none());
        assert!(Cma::new(vec![f64::NAN], 1.0, 8).is_none());
        let mut cma = Cma::new(vec![0.0; 3], 1.0, 8).unwrap();
        let before = cma.clone();
        cma.tell(&[vec![1.0; 3]]);
        cma.tell(&vec![vec![1.0; 2]; 8]);
        assert_eq!(cma, before);
    }
}

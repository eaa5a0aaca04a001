//! Inducing centres: which samples stand for many, and how many of them are enough.
//!
//! Centres are chosen by greedy variance selection (a pivoted Cholesky factorisation of the kernel): each
//! is the candidate about which those before it say least, so a shorter list begins a longer one. Their
//! number is the smallest whose likelihood on held-out blocks is close to that of the next larger one.
//! The more samples there are the more centres pay, so that is judged on many more samples than those
//! among which centres are chosen.

use super::process::Inputs;
use crate::posture::{GpHyper, Process, cross_kernel, reduced};
use crate::training::dataset::at_most;
use crate::training::settings::TrainSettings;
use nalgebra::{DMatrix, DVectorView};
use rayon::prelude::*;

/// Candidates among which centres are chosen, and samples on which their number is judged.
const CANDIDATES: usize = 6000;
const JUDGED: usize = 20_000;
/// Most held-out samples of that judgement.
const TESTED: usize = 2000;
const NUMBERS: [usize; 4] = [128, 256, 512, 1024];
/// Gain of likelihood (nats per sample and joint) below which more centres are not worth it.
const WORTH: f64 = 0.005;
/// Variance below which no candidate adds anything.
const NOTHING: f64 = 1e-6;

/// Standardised centres, M x D; `None` where a kernel matrix is singular.
pub(super) fn centres(
    inputs: &Inputs,
    targets: &DMatrix<f64>,
    hyper: &GpHyper,
    settings: &TrainSettings,
) -> Option<DMatrix<f64>> {
    let all: Vec<usize> = (0..inputs.rows.nrows()).collect();
    let rows = inputs.rows.select_rows(&at_most(&all, CANDIDATES));
    let most = settings.inducing.unwrap_or(with_held_out(NUMBERS[NUMBERS.len() - 1]));
    let mut greedy = Greedy::new(reduced(&rows, &inputs.scale.reduction(hyper)), most);
    let number = if let Some(number) = settings.inducing {
        number
    } else {
        let judged = at_most(&all, JUDGED);
        let own = inputs.rows.select_rows(&judged);
        let targets = targets.select_rows(&judged);
        // A process is surer than it should be about inputs that it knows as centres: none of them
        // may come from blocks that test.
        let mut first = |number: usize| {
            let order = greedy.first(with_held_out(number)).iter().copied();
            let own: Vec<usize> =
                order.filter(|&i| !is_test(i, rows.nrows())).take(number).collect();
            rows.select_rows(&own)
        };
        enough(inputs, (&own, &targets), &mut first, hyper)?
    };
    Some(rows.select_rows(greedy.first(number)))
}

/// So many candidates hold about `number` outside the blocks that test.
fn with_held_out(number: usize) -> usize {
    number * 5 / 4
}

/// Whether item `i` of `count` in order of time belongs to a block that tests: every fifth tenth.
fn is_test(i: usize, count: usize) -> bool {
    i * 10 / count % 5 == 4
}

/// Candidates in the order of what they tell, found as far as asked for.
struct Greedy {
    /// Reduced candidates, N x D.
    rows: DMatrix<f64>,
    /// Variance that the chosen ones leave open, N.
    open: Vec<f64>,
    /// Most that can be chosen, and the rows of the Cholesky factor, that many numbers each.
    most: usize,
    factor: Vec<f64>,
    order: Vec<usize>,
}

impl Greedy {
    fn new(rows: DMatrix<f64>, most: usize) -> Self {
        let count = rows.nrows();
        let most = most.min(count);
        Self {
            rows,
            open: vec![1.0; count],
            most,
            factor: vec![0.0; count * most],
            order: Vec::new(),
        }
    }

    /// The first `number` candidates, or as many as tell anything.
    fn first(&mut self, number: usize) -> &[usize] {
        while self.order.len() < number.min(self.most) && self.choose() {}
        &self.order[..number.min(self.order.len())]
    }

    /// Adds a candidate; false where none tells anything more.
    fn choose(&mut self) -> bool {
        // Ties go to the earlier row, whatever the processor.
        let (best, largest) = self
            .open
            .iter()
            .enumerate()
            .fold((0, f64::NEG_INFINITY), |b, (i, v)| if *v > b.1 { (i, *v) } else { b });
        if largest < NOTHING {
            return false;
        }
        let (root, done) = (largest.sqrt(), self.order.len());
        let kernel = cross_kernel(&self.rows, &self.rows.rows(best, 1).into_owned());
        let at = best * self.most;
        let own = self.factor[at..at + done].to_vec();
        let own = DVectorView::from_slice(&own, done);
        self.factor
            .par_chunks_exact_mut(self.most)
            .zip(&mut self.open)
            .zip(kernel.as_slice())
            .with_min_len(256)
            .for_each(|((row, open), k)| {
                let value = (k - DVectorView::from_slice(&row[..done], done).dot(&own)) / root;
                row[done] = value;
                *open -= value * value;
            });
        self.open[best] = f64::NEG_INFINITY;
        self.order.push(best);
        true
    }
}

/// The number of centres that held-out blocks of the judged rows and targets ask for.
fn enough(
    inputs: &Inputs,
    (rows, targets): (&DMatrix<f64>, &DMatrix<f64>),
    first: &mut dyn FnMut(usize) -> DMatrix<f64>,
    hyper: &GpHyper,
) -> Option<usize> {
    let count = rows.nrows();
    let (test, train): (Vec<usize>, Vec<usize>) = (0..count).partition(|&i| is_test(i, count));
    let test = at_most(&test, TESTED);
    let (train_rows, train_targets) = (rows.select_rows(&train), targets.select_rows(&train));
    let outputs: Vec<usize> = (0..targets.ncols()).collect();
    let mut before: Option<f64> = None;
    let mut chosen = NUMBERS[0];
    for number in NUMBERS {
        let centres = first(number);
        // The candidates are used up.
        let is_last = centres.nrows() < number / 2;
        let process = Process::inducing(
            *hyper,
            inputs.scale.clone(),
            &train_rows,
            outputs.clone(),
            &train_targets,
            centres,
        )?;
        let score = likelihood(&process, inputs, rows, targets, &test, hyper)?;
        if before.is_some_and(|b| score - b < WORTH) {
            break;
        }
        chosen = number;
        before = Some(score);
        if is_last {
            break;
        }
    }
    Some(chosen)
}

/// Mean log-likelihood per sample and joint, the variance of each joint profiled, nats.
fn likelihood(
    process: &Process,
    inputs: &Inputs,
    rows: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    test: &[usize],
    hyper: &GpHyper,
) -> Option<f64> {
    let posterior = process.posterior()?;
    let reduction = inputs.scale.reduction(hyper);
    let x_of = |&i: &usize| rows.row(i).iter().zip(&reduction).map(|(v, r)| v * r).collect();
    let xs: Vec<Vec<f64>> = test.iter().map(x_of).collect();
    let mut squares = vec![0.0; targets.ncols()];
    let mut logs = 0.0;
    for ((&i, x), inflation) in test.iter().zip(&xs).zip(posterior.inflations(&xs)) {
        logs += inflation.ln();
        for (c, (s, m)) in squares.iter_mut().zip(process.mean(x)).enumerate() {
            *s += (targets[(i, c)] - m).powi(2) / inflation;
        }
    }
    let count = test.len() as f64;
    let variances: f64 = squares.iter().map(|s| (s / count).max(1e-12).ln()).sum();
    Some(-0.5 * (variances / targets.ncols() as f64 + logs / count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn greedy_centres_leave_the_least_open() {
        let mut rng = stream(2, Purpose::Simulation, 0, 0);
        let rows = DMatrix::from_vec(60, 2, normals(&mut rng, 120));
        let order = Greedy::new(rows.clone(), 12).first(12).to_vec();
        let mut steps = Greedy::new(rows.clone(), 12);
        assert_eq!(order[..5], *steps.first(5));
        assert_eq!(order, steps.first(12));
        // The open variance by the definition, for the greedy set and for the first twelve rows.
        let open = |set: &[usize]| -> f64 {
            let z = rows.select_rows(set);
            let k = cross_kernel(&z, &z) + DMatrix::identity(set.len(), set.len()) * 1e-9;
            let cross = cross_kernel(&rows, &z);
            let inverse = k.try_inverse().unwrap();
            let said = &cross * inverse * cross.transpose();
            (0..60).map(|i| 1.0 - said[(i, i)]).sum()
        };
        assert!(open(&order) < open(&(0..12).collect::<Vec<_>>()));
    }
}

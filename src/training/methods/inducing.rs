//! Inducing centres: which samples stand for many, and how many of them are enough.
//!
//! Centres are chosen by greedy variance selection (a pivoted Cholesky factorisation of the kernel): each
//! is the candidate about which those before it say least, so a shorter list begins a longer one. Their
//! number is the smallest whose likelihood on held-out blocks is close to that of the next larger one.

use super::process::Inputs;
use crate::posture::{GpHyper, Process, cross_kernel, reduced};
use crate::training::dataset::at_most;
use crate::training::settings::TrainSettings;
use nalgebra::DMatrix;

/// Candidates among which centres are chosen, and samples on which their number is judged.
const CANDIDATES: usize = 6000;
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
    let kept = at_most(&all, CANDIDATES);
    let rows = inputs.rows.select_rows(&kept);
    let most = settings.inducing.unwrap_or(NUMBERS[NUMBERS.len() - 1]);
    let order = greedy(&reduced(&rows, &inputs.scale.reduction(hyper)), most);
    let number = match settings.inducing {
        Some(number) => number,
        None => enough(inputs, &rows, &targets.select_rows(&kept), &order, hyper)?,
    };
    Some(rows.select_rows(&order[..number.min(order.len())]))
}

/// Indices of reduced rows (N x D), the most telling first.
fn greedy(rows: &DMatrix<f64>, most: usize) -> Vec<usize> {
    let count = rows.nrows();
    let mut open = vec![1.0; count];
    let mut factor: Vec<Vec<f64>> = Vec::new();
    let mut order = Vec::new();
    while order.len() < most.min(count) {
        // Ties go to the earlier row, whatever the processor.
        let (best, largest) = open
            .iter()
            .enumerate()
            .fold((0, f64::NEG_INFINITY), |b, (i, v)| if *v > b.1 { (i, *v) } else { b });
        if largest < NOTHING {
            break;
        }
        let root = largest.sqrt();
        let kernel = cross_kernel(rows, &rows.rows(best, 1).into_owned());
        let mut column: Vec<f64> = kernel.as_slice().to_vec();
        for row in &factor {
            let at = row[best];
            for (c, r) in column.iter_mut().zip(row) {
                *c -= at * r;
            }
        }
        for (c, v) in column.iter_mut().zip(&mut open) {
            *c /= root;
            *v -= *c * *c;
        }
        open[best] = f64::NEG_INFINITY;
        order.push(best);
        factor.push(column);
    }
    order
}

/// The number of centres that held-out blocks ask for.
fn enough(
    inputs: &Inputs,
    rows: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    order: &[usize],
    hyper: &GpHyper,
) -> Option<usize> {
    let count = rows.nrows();
    // Every fifth tenth of the time tests.
    let is_test = |i: usize| i * 10 / count % 5 == 4;
    let train: Vec<usize> = (0..count).filter(|&i| !is_test(i)).collect();
    let test: Vec<usize> = (0..count).filter(|&i| is_test(i)).step_by(3).collect();
    let own: Vec<usize> = order.iter().copied().filter(|&i| !is_test(i)).collect();
    let outputs: Vec<usize> = (0..targets.ncols()).collect();
    let mut before: Option<f64> = None;
    let mut chosen = NUMBERS[0];
    for number in NUMBERS {
        let centres = rows.select_rows(&own[..number.min(own.len())]);
        let process = Process::inducing(
            *hyper,
            inputs.scale.clone(),
            &rows.select_rows(&train),
            outputs.clone(),
            &targets.select_rows(&train),
            centres,
        )?;
        let score = likelihood(&process, inputs, rows, targets, &test, hyper)?;
        if before.is_some_and(|b| score - b < WORTH) {
            break;
        }
        chosen = number;
        before = Some(score);
        if number >= own.len() {
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
        let order = greedy(&rows, 12);
        assert_eq!(order[..5], greedy(&rows, 5)[..]);
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

//! What inducing centres need of the samples: two sums, whatever the number of samples.
//!
//! ```text
//! gram   K_zx K_xz / rho   M x M         moment   K_zx S / rho   M x p
//! ```

use super::kernel::{GpHyper, InputScale, cross_kernel, reduced};
use crate::math::dense::transposed_product;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Samples that are treated together, so that N x M never stands in memory at once.
const BLOCK: usize = 2048;
/// Blocks whose parts stand in memory together.
const AT_ONCE: usize = 4;

/// Gram (M x M) and moment (M x p) of standardised `rows` (N x D) and targets (N x p, rad/s) about
/// standardised `centres` (M x D).
///
/// The parts are added in the order of the samples: any number of threads gives the same bits.
pub(super) fn sums(
    hyper: &GpHyper,
    scale: &InputScale,
    rows: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    centres: &DMatrix<f64>,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let reduction = scale.reduction(hyper);
    let z = reduced(centres, &reduction);
    let part = |from: usize| {
        let size = BLOCK.min(rows.nrows() - from);
        let x = reduced(&rows.rows(from, size).into_owned(), &reduction);
        let k = cross_kernel(&x, &z);
        let own = targets.rows(from, size).into_owned();
        (transposed_product(&k, &k), transposed_product(&k, &own))
    };
    let count = centres.nrows();
    let mut gram = DMatrix::zeros(count, count);
    let mut moment = DMatrix::zeros(count, targets.ncols());
    let blocks: Vec<usize> = (0..rows.nrows()).step_by(BLOCK).collect();
    for some in blocks.chunks(AT_ONCE) {
        let parts: Vec<_> = some.par_iter().map(|&from| part(from)).collect();
        for (g, m) in parts {
            gram += g;
            moment += m;
        }
    }
    (gram / hyper.noise_ratio, moment / hyper.noise_ratio)
}

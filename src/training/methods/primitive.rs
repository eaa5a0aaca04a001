//! Movement primitives from demonstrations.

use crate::posture::{Primitive, basis};
use crate::training::dataset::Frame;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Basis functions over the phase.
const FUNCTIONS: usize = 10;
/// Ridge on the weights of one demonstration.
const RIDGE: f64 = 1e-3;
/// Part of the mean variance added to the noise.
const FLOOR_SHARE: f64 = 1e-3;

/// Fits a primitive to frames that carry their demonstration and phase.
pub(super) fn primitive(frames: &[&Frame]) -> Primitive {
    let n = frames.first().map_or(0, |f| f.qdot.len());
    let mut demonstrations: BTreeMap<usize, Vec<&Frame>> = BTreeMap::new();
    for &f in frames {
        demonstrations.entry(f.demonstration).or_default().push(f);
    }
    let mut noise = DMatrix::zeros(n, n);
    let weights: Vec<DMatrix<f64>> = demonstrations
        .values()
        .filter_map(|rows| {
            let psi = DMatrix::from_rows(
                &rows.iter().map(|f| basis(FUNCTIONS, f.phase).transpose()).collect::<Vec<_>>(),
            );
            let values = DMatrix::from_fn(rows.len(), n, |i, c| rows[i].qdot[c]);
            let gram = psi.tr_mul(&psi) + DMatrix::identity(FUNCTIONS, FUNCTIONS) * RIDGE;
            let w = gram.cholesky()?.solve(&psi.tr_mul(&values));
            let left = values - psi * &w;
            noise += left.tr_mul(&left);
            Some(w)
        })
        .collect();
    let count = weights.len().max(1) as f64;
    let mean = weights.iter().fold(DMatrix::zeros(FUNCTIONS, n), |sum, w| sum + w) / count;
    let spread = (count - 1.0).max(1.0).sqrt();
    let root = (0..FUNCTIONS)
        .map(|b| {
            let columns: Vec<DVector<f64>> =
                weights.iter().map(|w| (w.row(b) - mean.row(b)).transpose() / spread).collect();
            if columns.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&columns) }
        })
        .collect();
    noise /= frames.len().max(1) as f64;
    let square: f64 = frames.iter().map(|f| f.qdot.norm_squared()).sum();
    let floor = FLOOR_SHARE * square / (frames.len().max(1) * n.max(1)) as f64;
    noise += DMatrix::identity(n, n) * floor;
    Primitive { mean, root, noise }
}

//! The kernel of the null-space process, and its inputs.
//!
//! ```text
//! k((q,v),(q',v')) = exp(-|dq|^2 / (2 n l_q^2) - |dv|^2 / (2 m l_v^2))     inputs standardised
//! ```
//! Dividing each input by its standard deviation, by the length-scale of its group and by the root of
//! the group's size leaves `exp(-|a - b|^2 / 2)`: *reduced* inputs.

use crate::math::simd::{exp, wide};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Samples that are treated together. With twice as many, a kernel row of a thousand samples takes
/// 9.5 us instead of 3.7 us.
const PANEL: usize = 16;
/// A coordinate so far away that the kernel with it is zero: fills incomplete panels.
const NOWHERE: f64 = 1e9;

/// Kernel parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GpHyper {
    /// Length-scale of the posture group, standard deviations per dimension.
    pub length_posture: f64,
    /// Length-scale of the velocity group.
    pub length_velocity: f64,
    /// Noise variance over signal variance.
    pub noise_ratio: f64,
}

/// Centre and spread of each input: n postures (rad), then m task velocities (m/s, rad/s).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputScale {
    /// Number of posture inputs, n.
    pub posture_count: usize,
    /// Mean of each input.
    pub mean: Vec<f64>,
    /// Standard deviation of each input.
    pub spread: Vec<f64>,
}

impl InputScale {
    /// Standardises raw inputs, N x (n + m), and keeps how.
    pub fn fit(raw: &DMatrix<f64>, posture_count: usize) -> (Self, DMatrix<f64>) {
        let mut rows = raw.clone();
        let (mut mean, mut spread) = (Vec::new(), Vec::new());
        for mut column in rows.column_iter_mut() {
            let centre = column.mean();
            let scale = column.variance().sqrt().max(1e-6);
            column.iter_mut().for_each(|v| *v = (*v - centre) / scale);
            mean.push(centre);
            spread.push(scale);
        }
        (Self { posture_count, mean, spread }, rows)
    }

    /// Factor of each standardised input that makes it a reduced one.
    pub fn reduction(&self, hyper: &GpHyper) -> Vec<f64> {
        let n = self.posture_count;
        let m = self.mean.len() - n;
        let of = |count: usize, length: f64| 1.0 / ((count.max(1) as f64).sqrt() * length);
        let (q, v) = (of(n, hyper.length_posture), of(m, hyper.length_velocity));
        (0..n + m).map(|i| if i < n { q } else { v }).collect()
    }
}

/// Reduced inputs of N samples in panels of sixteen: coordinate by coordinate, sixteen samples each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Panels {
    count: usize,
    dimensions: usize,
    values: Vec<f64>,
}

impl Panels {
    /// From standardised rows, N x D, and the factor of each column.
    pub(super) fn new(rows: &DMatrix<f64>, reduction: &[f64]) -> Self {
        let (count, dimensions) = rows.shape();
        let mut values = vec![NOWHERE; count.div_ceil(PANEL) * PANEL * dimensions];
        for i in 0..count {
            let at = (i / PANEL) * PANEL * dimensions + i % PANEL;
            for d in 0..dimensions {
                values[at + d * PANEL] = rows[(i, d)] * reduction[d];
            }
        }
        Self { count, dimensions, values }
    }

    /// Number of inputs, D.
    pub(super) fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// `k(x, .)` for a reduced input x (D): N values.
    pub(super) fn row(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.count];
        self.row_from(x, 0, &mut out);
        out
    }

    /// `k(x, .)` of all samples from panel `first` on, written over `out`.
    fn row_from(&self, x: &[f64], first: usize, out: &mut [f64]) {
        wide(
            #[inline(always)]
            || {
                let panels = self.values.chunks_exact(PANEL * self.dimensions).skip(first);
                for (panel, k) in panels.zip(out.chunks_mut(PANEL)) {
                    let own = panel_kernel(panel, x);
                    k.copy_from_slice(&own[..k.len()]);
                }
            },
        );
    }

    /// Adds `k(x, .) V` to `out` (n), for V row by row, N rows of n numbers.
    pub(super) fn apply(&self, x: &[f64], rows: &[f64], out: &mut [f64]) {
        let n = out.len();
        wide(
            #[inline(always)]
            || {
                let panels = self.values.chunks_exact(PANEL * self.dimensions);
                for (panel, block) in panels.zip(rows.chunks(PANEL * n)) {
                    let k = panel_kernel(panel, x);
                    let fours = block.chunks_exact(4 * n);
                    let rest = fours.remainder();
                    for (four, k) in fours.zip(k.chunks_exact(4)) {
                        let (a, b) = four.split_at(2 * n);
                        let ((a, b), (c, d)) = (a.split_at(n), b.split_at(n));
                        let terms = a.iter().zip(b).zip(c.iter().zip(d));
                        for (o, ((a, b), (c, d))) in out.iter_mut().zip(terms) {
                            let low = k[0].mul_add(*a, k[1] * b);
                            let high = k[2].mul_add(*c, k[3] * d);
                            *o += low + high;
                        }
                    }
                    let done = block.len() / (4 * n) * 4;
                    for (row, k) in rest.chunks_exact(n).zip(&k[done..]) {
                        for (o, v) in out.iter_mut().zip(row) {
                            *o = k.mul_add(*v, *o);
                        }
                    }
                }
            },
        );
    }
}

/// Kernel of one panel with x.
#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
fn panel_kernel(panel: &[f64], x: &[f64]) -> [f64; PANEL] {
    let mut squared = [0.0; PANEL];
    for (coordinates, x) in panel.chunks_exact(PANEL).zip(x) {
        for (s, c) in squared.iter_mut().zip(coordinates) {
            let d = c - x;
            *s = d.mul_add(d, *s);
        }
    }
    for s in &mut squared {
        *s = exp(-0.5 * *s);
    }
    squared
}

/// `k(A, B)` of reduced rows (N x D, M x D), N x M.
pub fn cross_kernel(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let panels = Panels::new(a, &vec![1.0; a.ncols()]);
    let mut out = DMatrix::zeros(a.nrows(), b.nrows());
    let mut x = vec![0.0; b.ncols()];
    for (j, mut column) in out.column_iter_mut().enumerate() {
        x.iter_mut().zip(b.row(j).iter()).for_each(|(x, v)| *x = *v);
        column.copy_from_slice(&panels.row(&x));
    }
    out
}

/// Lower triangle of `k(A, A)` of reduced rows (N x D), N x N; what stands above it means nothing.
pub fn lower_kernel(a: &DMatrix<f64>) -> DMatrix<f64> {
    let panels = Panels::new(a, &vec![1.0; a.ncols()]);
    let points = a.transpose();
    let mut out = DMatrix::zeros(a.nrows(), a.nrows());
    for (j, mut column) in out.column_iter_mut().enumerate() {
        let first = j / PANEL;
        let own = &mut column.as_mut_slice()[first * PANEL..];
        panels.row_from(points.column(j).as_slice(), first, own);
    }
    out
}

/// Standardised rows times their reduction.
pub fn reduced(rows: &DMatrix<f64>, reduction: &[f64]) -> DMatrix<f64> {
    let mut out = rows.clone();
    for (mut column, r) in out.column_iter_mut().zip(reduction) {
        column *= *r;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn panels_agree_with_the_formula() {
        let (count, n, m) = (37, 4, 2);
        let mut rng = stream(3, Purpose::Simulation, 0, 0);
        let raw = DMatrix::from_vec(count, n + m, normals(&mut rng, count * (n + m)));
        let (scale, rows) = InputScale::fit(&raw, n);
        let hyper = GpHyper { length_posture: 0.8, length_velocity: 1.5, noise_ratio: 0.2 };
        let panels = Panels::new(&rows, &scale.reduction(&hyper));
        let x = normals(&mut rng, n + m);
        let reduced: Vec<f64> = x.iter().zip(scale.reduction(&hyper)).map(|(x, r)| x * r).collect();
        let naive: Vec<f64> = (0..count)
            .map(|i| {
                let square = |d: usize| (rows[(i, d)] - x[d]).powi(2);
                let dq: f64 = (0..n).map(square).sum();
                let dv: f64 = (n..n + m).map(square).sum();
                (-dq / (2.0 * 4.0 * 0.64) - dv / (2.0 * 2.0 * 2.25)).exp()
            })
            .collect();
        for (a, b) in panels.row(&reduced).iter().zip(&naive) {
            assert!((a - b).abs() < 1e-14);
        }
        let z = super::reduced(&rows, &scale.reduction(&hyper));
        let (lower, full) = (lower_kernel(&z), cross_kernel(&z, &z));
        assert_eq!(lower.lower_triangle(), full.lower_triangle());
        let values = normals(&mut rng, count * 5);
        let mut out = vec![0.0; 5];
        panels.apply(&reduced, &values, &mut out);
        for (c, own) in out.iter().enumerate() {
            let sum: f64 = (0..count).map(|i| naive[i] * values[i * 5 + c]).sum();
            assert!((own - sum).abs() < 1e-12, "{own} {sum}");
        }
    }
}

//! Large dense algebra: faer's kernels behind nalgebra's matrices, without copying inputs.
//!
//! One thread each, so that the same inputs give the same bits with any number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::inverse::{inverse, inverse_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use nalgebra::DMatrix;

fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

fn view_mut(m: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = m.shape();
    MatMut::from_column_major_slice_mut(m.as_mut_slice(), rows, columns)
}

/// Copies the lower triangle to the upper one, in blocks that stay in the cache.
fn mirror(m: &mut DMatrix<f64>) {
    const BLOCK: usize = 32;
    let n = m.nrows();
    for from in (0..n).step_by(BLOCK) {
        for to in (0..=from).step_by(BLOCK) {
            for i in from..(from + BLOCK).min(n) {
                for j in to..(to + BLOCK).min(i) {
                    m[(j, i)] = m[(i, j)];
                }
            }
        }
    }
}

fn owned(m: &Mat<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(m.nrows(), m.ncols());
    for (c, mut column) in out.column_iter_mut().enumerate() {
        for (r, value) in column.iter_mut().enumerate() {
            *value = m[(r, c)];
        }
    }
    out
}

/// Cholesky factor of a symmetric positive definite matrix, N x N; the lower triangle is read.
#[derive(Debug, Clone)]
pub struct Factor {
    llt: Llt<f64>,
}

impl Factor {
    /// `None` where the matrix is not positive definite.
    pub fn new(matrix: &DMatrix<f64>) -> Option<Self> {
        Llt::new(view(matrix), Side::Lower).ok().map(|llt| Self { llt })
    }

    /// `A^-1 B`, N x p.
    pub fn solve(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        owned(&self.llt.solve(view(rhs)))
    }

    /// `A^-1`, symmetric.
    pub fn inverse(&self) -> DMatrix<f64> {
        let mut out = self.lower_inverse();
        mirror(&mut out);
        out
    }

    /// Lower triangle of `A^-1`; above it stand zeros.
    pub fn lower_inverse(&self) -> DMatrix<f64> {
        let l = self.llt.L();
        let n = l.nrows();
        let mut out = DMatrix::zeros(n, n);
        let mut memory = MemBuffer::new(inverse_scratch::<f64>(n, Par::Seq));
        inverse(view_mut(&mut out), l, Par::Seq, MemStack::new(&mut memory));
        out
    }

    /// `log det A`.
    pub fn log_det(&self) -> f64 {
        let l = self.llt.L();
        2.0 * (0..l.nrows()).map(|i| l[(i, i)].ln()).sum::<f64>()
    }

    /// `L^-1 B`, N x p.
    pub fn solve_lower(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = rhs.clone();
        self.llt.L().solve_lower_triangular_in_place(view_mut(&mut out));
        out
    }

    /// `L^-T B`, N x p.
    pub fn solve_lower_transposed(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = rhs.clone();
        self.llt.L().transpose().solve_upper_triangular_in_place(view_mut(&mut out));
        out
    }
}

/// `A B`.
pub fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.nrows(), b.ncols());
    add_product(&mut out, view(a), view(b));
    out
}

/// `A^T B`.
pub fn transposed_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(a.ncols(), b.ncols());
    add_product(&mut out, view(a).transpose(), view(b));
    out
}

/// `L B` for the lower triangle L of a matrix, N x p.
pub fn lower_product(lower: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(lower.nrows(), b.ncols());
    triangular::matmul(
        view_mut(&mut out),
        BlockStructure::Rectangular,
        Accum::Replace,
        view(lower),
        BlockStructure::TriangularLower,
        view(b),
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    out
}

/// Adds `factor A A^T` to the lower triangle of a matrix, N x N, for A of N x p.
pub fn add_lower_square(lower: &mut DMatrix<f64>, a: &DMatrix<f64>, factor: f64) {
    triangular::matmul(
        view_mut(lower),
        BlockStructure::TriangularLower,
        Accum::Add,
        view(a),
        BlockStructure::Rectangular,
        view(a).transpose(),
        BlockStructure::Rectangular,
        factor,
        Par::Seq,
    );
}

fn add_product(out: &mut DMatrix<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(view_mut(out), Accum::Replace, a, b, 1.0, Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};
    use approx::assert_relative_eq;

    #[test]
    fn agrees_with_nalgebra() {
        let n = 60;
        let mut rng = stream(9, Purpose::Simulation, 0, 0);
        let mut random = |r: usize, c: usize| DMatrix::from_vec(r, c, normals(&mut rng, r * c));
        let (a, b) = (random(n, n), random(n, 7));
        let spd = &a * a.transpose() + DMatrix::identity(n, n);
        let own = Factor::new(&spd).unwrap();
        let reference = spd.clone().cholesky().unwrap();
        assert_relative_eq!(own.solve(&b), reference.solve(&b), epsilon = 1e-10);
        assert_relative_eq!(own.inverse(), reference.inverse(), epsilon = 1e-10);
        assert_relative_eq!(own.log_det(), spd.determinant().ln(), epsilon = 1e-8);
        let l = reference.l();
        assert_relative_eq!(&l * own.solve_lower(&b), b, epsilon = 1e-10);
        assert_relative_eq!(l.transpose() * own.solve_lower_transposed(&b), b, epsilon = 1e-10);
        assert_relative_eq!(product(&spd, &b), &spd * &b, epsilon = 1e-10);
        assert_relative_eq!(transposed_product(&a, &b), a.tr_mul(&b), epsilon = 1e-10);
        assert_relative_eq!(own.lower_inverse(), own.inverse().lower_triangle(), epsilon = 1e-12);
        assert_relative_eq!(lower_product(&a, &b), a.lower_triangle() * &b, epsilon = 1e-10);
        let mut lower = a.clone();
        add_lower_square(&mut lower, &b, -0.5);
        let full = &a - 0.5 * &b * b.transpose();
        assert_relative_eq!(lower.lower_triangle(), full.lower_triangle(), epsilon = 1e-10);
        assert!(Factor::new(&-spd).is_none());
    }
}

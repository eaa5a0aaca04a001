//! Large dense algebra: faer's kernels behind nalgebra's matrices, without copying inputs.
//!
//! One thread each, so that the same inputs give the same bits with any number of threads.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use nalgebra::DMatrix;

fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
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
        let mut inverse = owned(&self.llt.inverse());
        inverse.fill_upper_triangle_with_lower_triangle();
        inverse
    }

    /// `log det A`.
    pub fn log_det(&self) -> f64 {
        let l = self.llt.L();
        2.0 * (0..l.nrows()).map(|i| l[(i, i)].ln()).sum::<f64>()
    }

    /// `L^-1 B`, N x p.
    pub fn solve_lower(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = rhs.clone();
        let (rows, columns) = out.shape();
        let target = MatMut::from_column_major_slice_mut(out.as_mut_slice(), rows, columns);
        self.llt.L().solve_lower_triangular_in_place(target);
        out
    }

    /// `L^-T B`, N x p.
    pub fn solve_lower_transposed(&self, rhs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = rhs.clone();
        let (rows, columns) = out.shape();
        let target = MatMut::from_column_major_slice_mut(out.as_mut_slice(), rows, columns);
        self.llt.L().transpose().solve_upper_triangular_in_place(target);
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

fn add_product(out: &mut DMatrix<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    let (rows, columns) = out.shape();
    let target = MatMut::from_column_major_slice_mut(out.as_mut_slice(), rows, columns);
    matmul(target, Accum::Replace, a, b, 1.0, Par::Seq);
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
        assert!(Factor::new(&-spd).is_none());
    }
}

//! Resolution of redundancy: the weighted pseudo-inverse and a null-space basis that does not jump.
//!
//! ```text
//! J_W^+ = W J^T (J W J^T)^-1          N_W = I - J_W^+ J  (oblique projector)
//! ```
//! `J` m x n of full row rank, `W` n x n symmetric positive definite. Scaling `W` changes nothing.

use nalgebra::{DMatrix, DVector};

/// Smallest ratio of the pivots of `J W J^T` below which the task counts as out of reach.
const RANK_TOLERANCE: f64 = 1e-6;

/// `J_W^+`, n x m; `None` where `J W J^T` has lost rank.
pub fn weighted_pseudo_inverse(
    jacobian: &DMatrix<f64>,
    weight: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let w_jt = weight * jacobian.transpose();
    let a = jacobian * &w_jt;
    let factor = a.cholesky()?;
    let pivots = factor.l_dirty().diagonal();
    if pivots.min() < RANK_TOLERANCE * pivots.max() {
        return None;
    }
    Some(factor.solve(&w_jt.transpose()).transpose())
}

/// The oblique projector `I - J_W^+ J`, n x n, onto the null space of `J`.
pub fn oblique_projector(jacobian: &DMatrix<f64>, pseudo_inverse: &DMatrix<f64>) -> DMatrix<f64> {
    let n = jacobian.ncols();
    DMatrix::identity(n, n) - pseudo_inverse * jacobian
}

/// Some orthonormal basis of the null space of `J`, n x (n - m).
///
/// It is defined only up to an orthogonal factor, which may jump from one posture to the next; use
/// [`NullSpaceFrame`] wherever coordinates of different postures are compared.
pub fn null_space_basis(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let (m, n) = jacobian.shape();
    // Householder QR of J^T next to the identity: the columns of Q after the first m.
    let mut wide = DMatrix::zeros(n, n + m);
    wide.columns_mut(0, m).copy_from(&jacobian.transpose());
    wide.columns_mut(m, n).fill_with_identity();
    let q = wide.qr().q();
    q.columns(m, n - m).into_owned()
}

/// A reference basis that makes the null-space basis of nearby postures a smooth function of `q`.
///
/// `V(q) = P V_ref (V_ref^T P V_ref)^(-1/2)` with the orthogonal projector `P` of the posture: the
/// basis of null(J) that is nearest to the reference (the polar factor). It is smooth wherever
/// `V_ref^T P V_ref` has full rank; [`NullSpaceFrame::basis`] says how far it is from losing it.
#[derive(Debug, Clone)]
pub struct NullSpaceFrame {
    reference: DMatrix<f64>,
}

/// A basis aligned to a reference.
#[derive(Debug, Clone)]
pub struct AlignedBasis {
    /// Orthonormal columns that span null(J), n x k.
    pub basis: DMatrix<f64>,
    /// Cosine of the largest angle between the null space and the reference, in [0, 1]; below about
    /// 0.1 the alignment is close to its singular set and another reference is needed.
    pub alignment: f64,
}

impl NullSpaceFrame {
    /// Takes the null space of one Jacobian as the reference.
    pub fn at(jacobian: &DMatrix<f64>) -> Self {
        Self { reference: null_space_basis(jacobian) }
    }

    /// The aligned basis for the Jacobian of another posture; `None` where `J` has lost rank or the
    /// alignment is singular.
    pub fn basis(&self, jacobian: &DMatrix<f64>) -> Option<AlignedBasis> {
        let jjt = (jacobian * jacobian.transpose()).cholesky()?;
        let along = jacobian.transpose() * jjt.solve(&(jacobian * &self.reference));
        let projected = &self.reference - along;
        // Polar factor by the thin SVD: exact orthonormality even near the singular set.
        let svd = projected.svd(true, true);
        let alignment = svd.singular_values.min();
        if alignment < 1e-6 {
            return None;
        }
        Some(AlignedBasis { basis: svd.u? * svd.v_t?, alignment })
    }
}

/// Joint velocity that meets the task exactly and is otherwise as close to `preferred` as the weight
/// says: `z + J_W^+ (xdot - J z)`.
pub fn resolve(
    jacobian: &DMatrix<f64>,
    pseudo_inverse: &DMatrix<f64>,
    task_velocity: &DVector<f64>,
    preferred: &DVector<f64>,
) -> DVector<f64> {
    preferred + pseudo_inverse * (task_velocity - jacobian * preferred)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn random(rows: usize, cols: usize, seed: u64) -> DMatrix<f64> {
        let mut rng = stream(seed, Purpose::Simulation, 0, 0);
        DMatrix::from_vec(rows, cols, normals(&mut rng, rows * cols))
    }

    fn random_spd(n: usize, seed: u64) -> DMatrix<f64> {
        let a = random(n, n, seed);
        &a * a.transpose() + DMatrix::identity(n, n) * 0.1
    }

    proptest! {
        #[test]
        fn pseudo_inverse_meets_its_axioms(seed in 0u64..200, m in 1usize..6, extra in 1usize..7) {
            let n = m + extra;
            let (j, w) = (random(m, n, seed), random_spd(n, seed + 1000));
            let pinv = weighted_pseudo_inverse(&j, &w).unwrap();
            prop_assert!((&j * &pinv - DMatrix::identity(m, m)).norm() < 1e-8);
            let projector = oblique_projector(&j, &pinv);
            prop_assert!((&j * &projector).norm() < 1e-8);
            prop_assert!((&projector * &projector - &projector).norm() < 1e-8);
            // Optimality: W^-1 J_W^+ x lies in the row space, so null-space moves gain nothing.
            let v = null_space_basis(&j);
            let wi = w.clone().try_inverse().unwrap();
            prop_assert!((v.transpose() * wi * &pinv).norm() < 1e-7);
            // Scale of W is irrelevant.
            let scaled = weighted_pseudo_inverse(&j, &(w * 7.0)).unwrap();
            prop_assert!((scaled - pinv).norm() < 1e-8);
        }

        #[test]
        fn null_space_bases_are_orthonormal_and_null(seed in 0u64..100, m in 1usize..6, extra in 1usize..7) {
            let n = m + extra;
            let j = random(m, n, seed);
            let frame = NullSpaceFrame::at(&random(m, n, seed + 500));
            for v in [null_space_basis(&j), frame.basis(&j).unwrap().basis] {
                prop_assert!((&j * &v).norm() < 1e-9);
                prop_assert!((v.transpose() * &v - DMatrix::identity(extra, extra)).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn aligned_basis_moves_smoothly_where_the_raw_one_may_jump() {
        // J(t) turns slowly; steps of the aligned basis must shrink with the step of t.
        let (a, b) = (random(3, 8, 3), random(3, 8, 4));
        let j = |t: f64| &a * t.cos() + &b * t.sin();
        let frame = NullSpaceFrame::at(&j(0.3));
        let largest_step = |count: usize| -> f64 {
            let bases: Vec<_> = (0..=count)
                .map(|i| frame.basis(&j(0.6 * i as f64 / count as f64)).unwrap().basis)
                .collect();
            bases.windows(2).map(|p| (&p[1] - &p[0]).norm()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (largest_step(50), largest_step(500));
        assert!(coarse < 0.2, "{coarse}");
        assert_relative_eq!(fine / coarse, 0.1, max_relative = 0.1);
    }

    #[test]
    fn lost_rank_is_reported() {
        let mut j = random(3, 6, 1);
        let row = j.row(0) * 2.0;
        j.row_mut(2).copy_from(&row);
        assert!(weighted_pseudo_inverse(&j, &DMatrix::identity(6, 6)).is_none());
    }
}

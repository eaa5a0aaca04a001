//! The Gaussian of joint velocities conditioned on the task velocity.

use crate::math::redundancy::{resolve, weighted_pseudo_inverse};
use nalgebra::{DMatrix, DVector};

/// Mean (rad/s) and covariance (rad/s)^2 of the joint velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditional {
    /// `z + J_W^+ (xdot - J z)`, n.
    pub mean: DVector<f64>,
    /// `W - W J^T (J W J^T)^-1 J W`, n x n, of rank n - m.
    pub covariance: DMatrix<f64>,
}

/// Conditions `N(z, W)` on `J qdot = xdot`; `None` where `J W J^T` has lost rank.
///
/// `jacobian` m x n, `weight` n x n symmetric positive definite, `preferred` n (rad/s), `task` m.
pub fn condition(
    jacobian: &DMatrix<f64>,
    weight: &DMatrix<f64>,
    preferred: &DVector<f64>,
    task: &DVector<f64>,
) -> Option<Conditional> {
    let pinv = weighted_pseudo_inverse(jacobian, weight)?;
    let mean = resolve(jacobian, &pinv, task, preferred);
    let covariance = weight - &pinv * jacobian * weight;
    Some(Conditional { mean, covariance })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn equals_the_limit_of_a_nearly_exact_observation() {
        // Kalman update with observation noise eps -> 0 is the textbook form of conditioning.
        let (n, m) = (7, 3);
        let mut rng = stream(5, Purpose::Simulation, 0, 0);
        let mut random = |r: usize, c: usize| DMatrix::from_vec(r, c, normals(&mut rng, r * c));
        let (j, a, z, x) = (random(m, n), random(n, n), random(n, 1), random(m, 1));
        let w = &a * a.transpose() + DMatrix::identity(n, n);
        let (z, x) = (z.column(0).into_owned(), x.column(0).into_owned());
        let own = condition(&j, &w, &z, &x).unwrap();
        let s = &j * &w * j.transpose() + DMatrix::identity(m, m) * 1e-10;
        let gain = &w * j.transpose() * s.try_inverse().unwrap();
        let mean = &z + &gain * (&x - &j * &z);
        let covariance = &w - &gain * &j * &w;
        assert!((mean - &own.mean).norm() < 1e-7);
        assert!((covariance - &own.covariance).norm() < 1e-7);
        assert!((&j * &own.mean - x).norm() < 1e-9);
        assert!((&j * own.covariance).norm() < 1e-8);
    }
}

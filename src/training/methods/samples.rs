//! Frames as the search for weights needs them: fixed sizes, one after another.
//!
//! Tasks of fewer than six rows are filled up with rows that every joint velocity meets.

use crate::training::dataset::Frame;
use nalgebra::{Cholesky, Const, DMatrix, DVector, Matrix6, Matrix6xX, Vector6};

/// One frame.
#[derive(Debug, Clone)]
struct Sample {
    jacobian: Matrix6xX<f64>,
    xdot: Vector6<f64>,
    qdot: DVector<f64>,
}

/// Frames of one chain and one task.
#[derive(Debug, Clone)]
pub(super) struct Samples {
    items: Vec<Sample>,
    /// Joints, n, and task rows, m.
    pub n: usize,
    pub m: usize,
}

impl Samples {
    pub(super) fn new(frames: &[&Frame]) -> Self {
        let n = frames.first().map_or(0, |f| f.qdot.len());
        let m = frames.first().map_or(0, |f| f.xdot.len());
        let items = frames
            .iter()
            .map(|f| {
                let mut jacobian = Matrix6xX::zeros(n);
                jacobian.rows_mut(0, m).copy_from(&f.jacobian);
                let mut xdot = Vector6::zeros();
                xdot.rows_mut(0, m).copy_from(&f.xdot);
                Sample { jacobian, xdot, qdot: f.qdot.clone() }
            })
            .collect();
        Self { items, n, m }
    }

    pub(super) fn len(&self) -> usize {
        self.items.len()
    }

    /// Dimensions of the null space, k = n - m.
    pub(super) fn redundancy(&self) -> usize {
        self.n - self.m
    }

    /// All samples under one diagonal weight (n); `None` where `J W J^T` has lost rank.
    pub(super) fn resolve(&self, weights: &[f64]) -> Option<Resolved<'_>> {
        let each: Option<Vec<Solved>> =
            self.items.iter().map(|s| Solved::new(s, self.m, weights)).collect();
        Some(Resolved { samples: self, each: each? })
    }
}

/// One sample under one diagonal weight.
struct Solved {
    gram: Cholesky<f64, Const<6>>,
    /// u = J^T A^-1 xdot, n.
    u: DVector<f64>,
}

impl Solved {
    fn new(sample: &Sample, m: usize, weights: &[f64]) -> Option<Self> {
        let j = &sample.jacobian;
        let mut a = Matrix6::zeros();
        for (c, w) in weights.iter().enumerate() {
            let column = j.fixed_view::<6, 1>(0, c);
            a += column * column.transpose() * *w;
        }
        for i in m..6 {
            a[(i, i)] = 1.0;
        }
        let gram = a.cholesky()?;
        let lambda = gram.solve(&sample.xdot);
        let u = DVector::from_fn(weights.len(), |c, _| j.fixed_view::<6, 1>(0, c).dot(&lambda));
        Some(Self { gram, u })
    }
}

/// All samples under one diagonal weight.
pub(super) struct Resolved<'a> {
    samples: &'a Samples,
    each: Vec<Solved>,
}

impl Resolved<'_> {
    /// `s = qdot - J_W^+ xdot = qdot - W u`, N x n, rad/s.
    pub(super) fn residuals(&self, weights: &[f64]) -> DMatrix<f64> {
        DMatrix::from_fn(self.each.len(), self.samples.n, |t, c| {
            self.samples.items[t].qdot[c] - weights[c] * self.each[t].u[c]
        })
    }

    /// Gradient of `sum_t c_t^T s_t` with respect to log w, n, for c row by row (N x n).
    ///
    /// `dJ_W^+ / dw_i = (I - J_W^+ J) e_i (e_i^T J^T (J W J^T)^-1)`.
    pub(super) fn gradient(&self, weights: &[f64], c: &DMatrix<f64>) -> Vec<f64> {
        let mut gradient = vec![0.0; self.samples.n];
        for (t, solved) in self.each.iter().enumerate() {
            let j = &self.samples.items[t].jacobian;
            let mut jwc = Vector6::zeros();
            for (i, w) in weights.iter().enumerate() {
                jwc += j.fixed_view::<6, 1>(0, i) * (w * c[(t, i)]);
            }
            let mu = solved.gram.solve(&jwc);
            for (i, g) in gradient.iter_mut().enumerate() {
                let along = j.fixed_view::<6, 1>(0, i).dot(&mu);
                *g -= weights[i] * solved.u[i] * (c[(t, i)] - along);
            }
        }
        gradient
    }
}

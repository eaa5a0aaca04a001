//! The law of one person: z and W of the conditioned Gaussian, and what surrounds them.
//!
//! ```text
//! z(q, xdot) = offset + process(q, xdot) (+ pull)        qdot = z + e,  e ~ N(0, C g^2 v)
//! mean        z + J_W^+ (xdot - J z)
//! covariance  N_W C N_W^T g^2 v + floor^2 V V^T + J_W^+ S_x J_W^+^T     N_W = I - J_W^+ J
//! ```
//! `C = F F^T` of the noise, g its gain with the hand speed, v the inflation by what the process does
//! not know (paper eq. 7 and 8, with one projector throughout). Two methods differ: the direct process
//! ignores the task, and the primitive has a W and z for each phase and sees the task with its noise.

use super::attraction::Attraction;
use super::hand_path::HandPath;
use super::model::OwnPosture;
use super::noise::{Clock, DriftPath, Noise, NoisePath};
use super::pair::Pair;
use super::primitive::Primitive;
use super::process::{FunctionDraw, Posterior, Process, add_means};
use crate::math::redundancy::{resolve, weighted_pseudo_inverse};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

/// z, W, the pull and the noise.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PostureLaw {
    /// W, n x n, (rad/s)^2.
    pub weight: DMatrix<f64>,
    /// Constant part of z, n, rad/s.
    pub offset: Option<DVector<f64>>,
    /// Processes for z; each serves some of the joints.
    pub processes: Vec<Process>,
    /// A movement primitive in the place of W and z.
    pub primitive: Option<Primitive>,
    /// The process predicts the joint velocity itself and the task is ignored.
    pub is_direct: bool,
    /// The pull towards the person's own postures.
    pub attraction: Option<Attraction>,
    /// How two hands are made of the one that was learned; none for one hand. Never stored.
    #[serde(skip)]
    pub pair: Option<Pair>,
    /// What differs between repetitions.
    pub noise: Noise,
    /// Stature of the body on which it was learned, m: hand speeds are compared over stature.
    pub stature_m: f64,
    /// Number of rows of the task velocity on which it was learned, m.
    pub task_rows: usize,
}

/// Where a joint velocity is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Query<'a> {
    /// Joint angles, n, rad.
    pub q: &'a DVector<f64>,
    /// Task velocity, m: m/s, rad/s.
    pub xdot: &'a DVector<f64>,
    /// Jacobian, m x n.
    pub jacobian: &'a DMatrix<f64>,
    /// Phase of the movement, in [0, 1].
    pub phase: f64,
}

/// Mean (n, rad/s) and covariance (n x n) of a joint velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Mean.
    pub mean: DVector<f64>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
}

/// Variances that no residual tells.
#[derive(Debug, Clone, PartialEq)]
pub struct Floors {
    /// Variance of each row of the task velocity (`S_x`), m: (m/s)^2, (rad/s)^2.
    pub task: DVector<f64>,
    /// Standard deviation in every null direction, rad/s.
    pub null_rad_s: f64,
}

impl PostureLaw {
    /// W alone: no process, no pull, no noise.
    pub fn of_weight(weight: DMatrix<f64>, stature_m: f64, task_rows: usize) -> Self {
        let n = weight.nrows();
        Self {
            weight,
            offset: None,
            processes: Vec::new(),
            primitive: None,
            is_direct: false,
            attraction: None,
            pair: None,
            noise: Noise::none(n),
            stature_m,
            task_rows,
        }
    }

    /// Number of joints, n.
    pub fn dof(&self) -> usize {
        self.weight.nrows()
    }

    /// z without the pull, n, rad/s.
    pub fn preferred(&self, q: &DVector<f64>, xdot: &DVector<f64>) -> DVector<f64> {
        let mut z = self.offset.clone().unwrap_or_else(|| DVector::zeros(self.dof()));
        add_means(&self.processes, q.as_slice(), xdot.as_slice(), &mut z);
        z
    }

    /// Expected joint velocity with an additional preferred velocity `pull`, n, rad/s; `None` where
    /// `J W J^T` has lost rank.
    pub fn expected(&self, at: &Query, pull: &DVector<f64>) -> Option<DVector<f64>> {
        let z = self.preferred(at.q, at.xdot) + pull;
        if self.is_direct {
            return Some(z);
        }
        if let Some(primitive) = &self.primitive {
            let (mean, weight) = primitive.at(at.phase);
            let pinv = weighted_pseudo_inverse(at.jacobian, &weight)?;
            return Some(resolve(at.jacobian, &pinv, at.xdot, &(mean + pull)));
        }
        let pinv = weighted_pseudo_inverse(at.jacobian, &self.weight)?;
        Some(resolve(at.jacobian, &pinv, at.xdot, &z))
    }

    /// The processes with their factors; `None` where a kernel matrix is not positive definite.
    pub fn posteriors(&self) -> Option<Vec<Posterior<'_>>> {
        self.processes.iter().map(Process::posterior).collect()
    }

    /// Factors by which the noise's standard deviation grows for what the processes do not know, n
    /// for each query.
    pub fn growth(&self, posteriors: &[Posterior], at: &[Query]) -> Vec<DVector<f64>> {
        let mut factors = vec![DVector::from_element(self.dof(), 1.0); at.len()];
        for (process, posterior) in self.processes.iter().zip(posteriors) {
            let reduce = |q: &Query| process.reduce(q.q.as_slice(), q.xdot.as_slice());
            let inputs: Vec<Vec<f64>> = at.iter().map(reduce).collect();
            for (factor, inflation) in factors.iter_mut().zip(posterior.inflations(&inputs)) {
                for &o in process.outputs() {
                    factor[o] = inflation.sqrt();
                }
            }
        }
        factors
    }

    /// Mean and covariance, with the [`growth`](Self::growth) of the noise there; `None` where the
    /// task has lost rank.
    pub fn predict(
        &self,
        at: &Query,
        pull: &DVector<f64>,
        growth: &DVector<f64>,
        floors: &Floors,
    ) -> Option<Prediction> {
        let n = self.dof();
        if let Some(primitive) = &self.primitive {
            let (z, weight) = primitive.at(at.phase);
            let z = z + pull;
            let across = &weight * at.jacobian.transpose();
            let seen = at.jacobian * &across + DMatrix::from_diagonal(&floors.task);
            let gain = seen.cholesky()?.solve(&across.transpose()).transpose();
            let mean = &z + &gain * (at.xdot - at.jacobian * &z);
            let covariance = &weight - &gain * across.transpose();
            let covariance =
                symmetric(&covariance) + null_projector(at.jacobian)? * floors.null_rad_s.powi(2);
            return Some(Prediction { mean, covariance });
        }
        let z = self.preferred(at.q, at.xdot) + pull;
        let growth = growth * self.noise.gain(at.xdot.as_slice());
        let mut root = self.noise.factor.clone();
        for (mut row, g) in root.row_iter_mut().zip(growth.iter()) {
            row *= *g;
        }
        if self.is_direct {
            let covariance =
                &root * root.transpose() + DMatrix::identity(n, n) * floors.null_rad_s.powi(2);
            return Some(Prediction { mean: z, covariance });
        }
        let pinv = weighted_pseudo_inverse(at.jacobian, &self.weight)?;
        let mean = resolve(at.jacobian, &pinv, at.xdot, &z);
        let inside = &root - &pinv * (at.jacobian * &root);
        let mut by_task = pinv;
        for (mut column, variance) in by_task.column_iter_mut().zip(floors.task.iter()) {
            column *= variance.sqrt();
        }
        let covariance = &inside * inside.transpose()
            + null_projector(at.jacobian)? * floors.null_rad_s.powi(2)
            + &by_task * by_task.transpose();
        Some(Prediction { mean, covariance })
    }
}

fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// `V V^T`, the orthogonal projector on null(J).
fn null_projector(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = jacobian.ncols();
    let pinv = weighted_pseudo_inverse(jacobian, &DMatrix::identity(n, n))?;
    Some(DMatrix::identity(n, n) - pinv * jacobian)
}

/// How repetitions differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// One posterior function and one path of white, correlated and lasting noise for each rollout.
    #[default]
    Pathwise,
    /// The paper's: a fresh joint velocity at each sample. Its spread depends on the time step.
    Independent,
}

/// Draws repetitions from a law.
#[derive(Debug, Clone)]
pub struct Sampler<'a> {
    law: &'a PostureLaw,
    posteriors: Vec<Posterior<'a>>,
    sampling: Sampling,
}

/// What is drawn for one repetition.
#[derive(Debug, Clone)]
pub struct Draw<'a> {
    noise: NoisePath,
    drift: Option<DriftPath>,
    functions: Arc<[FunctionDraw]>,
    /// What the person has of their own; none where that is not known.
    own: Option<OwnPosture>,
    /// Of independent sampling: by what the noise grows.
    posteriors: Option<&'a [Posterior<'a>]>,
}

impl<'a> Sampler<'a> {
    /// `None` where a kernel matrix is not positive definite.
    pub fn new(law: &'a PostureLaw, sampling: Sampling) -> Option<Self> {
        Some(Self { law, posteriors: law.posteriors()?, sampling })
    }

    /// One posterior function of each process; none for independent sampling. A draw costs far more
    /// than its use and does not depend on the path, so that candidates can share it.
    pub fn functions(&self, rng: &mut ChaCha8Rng) -> Arc<[FunctionDraw]> {
        match self.sampling {
            Sampling::Pathwise => {
                self.posteriors.iter().map(|p| p.draw(&self.law.noise.factor, rng)).collect()
            }
            Sampling::Independent => Arc::new([]),
        }
    }

    /// What is drawn for one repetition along a path.
    pub fn draw_with(
        &self,
        functions: Arc<[FunctionDraw]>,
        rng: &mut ChaCha8Rng,
        path: &HandPath,
    ) -> Draw<'_> {
        let (count, dt) = path.noise_grid();
        let (noise, posteriors) = match self.sampling {
            Sampling::Pathwise => (self.law.noise.path(rng, count, dt), None),
            Sampling::Independent => {
                (self.law.noise.independent(rng, count), Some(self.posteriors.as_slice()))
            }
        };
        let drift = self.law.noise.drift(rng);
        Draw { noise, drift, functions, own: None, posteriors }
    }

    /// The same with functions of its own.
    pub fn draw(&self, rng: &mut ChaCha8Rng, path: &HandPath) -> Draw<'_> {
        let functions = self.functions(rng);
        self.draw_with(functions, rng, path)
    }
}

impl Draw<'_> {
    /// The same of a person with usual postures of their own.
    #[must_use]
    pub fn by(self, own: Option<OwnPosture>) -> Self {
        Self { own, ..self }
    }

    /// By what the person's usual posture differs at a height of the hand (rest frame, over stature), n, rad.
    pub(super) fn own_at(&self, height: f64) -> Option<Cow<'_, DVector<f64>>> {
        Some(self.own.as_ref()?.at(height))
    }

    /// How far the posture has drifted in true time, n, rad.
    pub(super) fn drifted(&self, time_s: f64) -> Option<DVector<f64>> {
        self.drift.as_ref().map(|d| d.at(time_s))
    }

    /// Preferred velocity in this repetition without the pull, n, rad/s of the clock: part of the way from
    /// place `index` of the noise to the next, which is `gains` times (n) what it is on average.
    pub(super) fn preferred(
        &self,
        law: &PostureLaw,
        at: &Query,
        (index, part): (usize, f64),
        gains: Option<&DVector<f64>>,
    ) -> DVector<f64> {
        let mut z = if self.functions.is_empty() {
            law.preferred(at.q, at.xdot)
        } else {
            let mut z = law.offset.clone().unwrap_or_else(|| DVector::zeros(law.dof()));
            for (process, draw) in law.processes.iter().zip(self.functions.iter()) {
                let x = process.reduce(at.q.as_slice(), at.xdot.as_slice());
                let mut out = vec![0.0; process.outputs().len()];
                process.add_draw(draw, &x, &mut out);
                for (o, v) in process.outputs().iter().zip(out) {
                    z[*o] += v;
                }
            }
            z
        };
        // By the hand's own clock it always moves at its usual speed.
        let gain = match law.noise.clock {
            Clock::Hand { .. } => 1.0,
            Clock::Seconds { .. } => law.noise.gain(at.xdot.as_slice()),
        };
        if let Some(posteriors) = self.posteriors {
            let mut noise = self.noise.at(index, part) * gain;
            if let Some(gains) = gains {
                noise.component_mul_assign(gains);
            }
            for growth in law.growth(posteriors, std::slice::from_ref(at)) {
                noise.component_mul_assign(&growth);
            }
            z += noise;
        } else {
            self.noise.add_to(&mut z, (index, part), gain, gains);
        }
        z
    }
}

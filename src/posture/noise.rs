//! What differs from one repetition to the next: correlated noise in the joint velocities.
//!
//! ```text
//! e(t) = F u(t) sqrt(|v|^2 + v0^2)     u: Ornstein-Uhlenbeck, unit variance, correlation time tau
//! |v|^2 = |linear|^2 + (0.3 m |angular|)^2
//! ```
//! `F F^T` is the residual covariance per unit of hand speed. The process is exact for any time step
//! (AR(1) with factor exp(-dt/tau)), so the spread of postures does not depend on the step.

use crate::math::stream::normals;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Length by which an angular speed counts like a linear one, m/rad.
const ROTATION_LENGTH_M: f64 = 0.3;

/// Parameters of the noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// F, n x r: joint velocity (rad/s) per unit of u and of hand speed (m/s).
    pub factor: DMatrix<f64>,
    /// Correlation time, s.
    pub correlation_time_s: f64,
    /// v0: hand speed below which the noise no longer shrinks, m/s.
    pub speed_floor_m_s: f64,
}

impl Noise {
    /// No noise at all, for n joints.
    pub fn none(n: usize) -> Self {
        Self { factor: DMatrix::zeros(n, 0), correlation_time_s: 1.0, speed_floor_m_s: 0.0 }
    }

    /// The speed that scales the noise, m/s. `task` holds linear and angular velocity (or less).
    pub fn speed(&self, task: &[f64]) -> f64 {
        effective_speed(task, self.speed_floor_m_s)
    }

    /// One sample path of u at times `dt` apart, r values for each of `count` times.
    pub fn path(&self, rng: &mut ChaCha8Rng, count: usize, dt: f64) -> NoisePath {
        let r = self.factor.ncols();
        let keep = (-dt / self.correlation_time_s).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        let mut u = DVector::from_vec(normals(rng, r));
        let mut samples = Vec::with_capacity(count);
        for _ in 0..count {
            samples.push(&self.factor * &u);
            let kick = DVector::from_vec(normals(rng, r));
            u = u * keep + kick * fresh;
        }
        NoisePath { samples }
    }
}

/// Hand speed with a floor: `sqrt(|linear|^2 + (0.3 m |angular|)^2 + floor^2)`, m/s.
pub fn effective_speed(task: &[f64], floor: f64) -> f64 {
    let linear: f64 = task.iter().take(3).map(|v| v * v).sum();
    let angular: f64 = task.iter().skip(3).map(|w| (ROTATION_LENGTH_M * w).powi(2)).sum();
    (linear + angular + floor * floor).sqrt()
}

/// `F u` at the samples of a path, before scaling by the speed.
#[derive(Debug, Clone)]
pub struct NoisePath {
    samples: Vec<DVector<f64>>,
}

impl NoisePath {
    /// Interpolates between sample `index` and the next; `part` in [0, 1].
    pub fn at(&self, index: usize, part: f64) -> DVector<f64> {
        let last = self.samples.len() - 1;
        let (a, b) = (&self.samples[index.min(last)], &self.samples[(index + 1).min(last)]);
        a.lerp(b, part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::std_dev;
    use crate::math::stream::{Purpose, stream};

    #[test]
    fn spread_and_correlation_do_not_depend_on_the_step() {
        let noise = Noise {
            factor: DMatrix::from_element(1, 1, 2.0),
            correlation_time_s: 0.3,
            speed_floor_m_s: 0.0,
        };
        for (dt, steps) in [(0.1, 10), (0.02, 50)] {
            // Displacement over 1 s has variance 2 s^2 tau (T - tau (1 - exp(-T/tau))).
            let ends: Vec<f64> = (0..4000)
                .map(|i| {
                    let mut rng = stream(1, Purpose::Posture, 0, i);
                    let path = noise.path(&mut rng, steps + 1, dt);
                    (0..steps).map(|k| path.at(k, 0.5)[0] * dt).sum()
                })
                .collect();
            let (s, tau, t) = (2.0f64, 0.3, 1.0);
            let exact = (2.0 * s * s * tau * (t - tau * (1.0 - f64::exp(-t / tau)))).sqrt();
            let ratio = std_dev(&ends) / exact;
            assert!((ratio - 1.0).abs() < 0.05, "dt {dt}: {ratio}");
        }
    }
}

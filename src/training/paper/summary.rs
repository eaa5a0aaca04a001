//! The paper's tables: methods over all held-out movements.

use super::result::{MovementScore, SetResult};
use crate::math::stats::mean;
use crate::posture::Method;
use crate::training::{Bands, Percentiles};
use serde::Serialize;

/// One method over all held-out movements of all sets: median with 5th and 95th percentile.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodSummary {
    /// The method.
    pub method: Method,
    /// Held-out movements.
    pub movements: usize,
    /// Log-likelihood of the joint velocity, nats per frame.
    pub ll_q: Percentiles,
    /// RMSE of the joint velocity, rad/s.
    pub rmse_q: Percentiles,
    /// The same over the rms of the joint velocity.
    pub relative_rmse_q: Percentiles,
    /// Log-likelihood of the task velocity, nats per frame.
    pub ll_x: Percentiles,
    /// RMSE of the task velocity, m/s and rad/s.
    pub rmse_x: Percentiles,
    /// Squared residual in units of its predicted variance, by dimension of the null space.
    pub surprise: Percentiles,
    /// Share of joint velocities inside the central 50 and 90 % band, over all frames.
    pub velocity_coverage: [f64; 2],
    /// What bands of repetitions held, mean over sets; none where it was not asked.
    pub bands: Option<Bands>,
}

/// Of the `m`-th method.
pub(super) fn summary(sets: &[SetResult], m: usize) -> Option<MethodSummary> {
    let own: Vec<_> = sets.iter().filter_map(|s| s.methods.get(m)).collect();
    let method = own.first()?.method;
    let movements: Vec<&MovementScore> = own.iter().flat_map(|o| &o.movements).collect();
    let spread = |pick: fn(&MovementScore) -> f64| {
        Percentiles::of(&movements.iter().map(|s| pick(s)).collect::<Vec<_>>())
    };
    let frames: f64 = movements.iter().map(|s| s.frames as f64).sum();
    let covered = |level: usize| {
        let sum = movements.iter().map(|s| s.velocity_coverage[level] * s.frames as f64);
        sum.sum::<f64>() / frames
    };
    Some(MethodSummary {
        method,
        movements: movements.len(),
        ll_q: spread(|s| s.ll_q),
        rmse_q: spread(|s| s.rmse_q),
        relative_rmse_q: spread(|s| s.relative_rmse_q),
        ll_x: spread(|s| s.ll_x),
        rmse_x: spread(|s| s.rmse_x),
        surprise: spread(|s| s.surprise),
        velocity_coverage: [covered(0), covered(1)],
        bands: mean_bands(&own.iter().filter_map(|o| o.bands).collect::<Vec<_>>()),
    })
}

fn mean_bands(all: &[Bands]) -> Option<Bands> {
    let of = |pick: fn(&Bands) -> f64| mean(&all.iter().map(pick).collect::<Vec<_>>());
    (!all.is_empty()).then(|| Bands {
        coverage_50: of(|b| b.coverage_50),
        coverage_90: of(|b| b.coverage_90),
        end_coverage_90: of(|b| b.end_coverage_90),
        width_90_deg: of(|b| b.width_90_deg),
    })
}

//! The noise that explains residuals of laws that have not seen the frame.
//!
//! ```text
//! r = qdot - mean = g(v) N_W e        N_W = I - J_W^+ J: what the task leaves of the noise
//! s   share of the variance that grows with the hand speed: maximum likelihood
//! C   cov e: expectation maximisation of eta = V^T r / g ~ N(0, A C A^T), A = V^T N_W
//! a_b, a_u, tau, a_w   the pooled autocorrelation of r / g against a_b + a_u exp(-lag / tau);
//!     what is missing to 1 at lag zero is white
//! ```
//! Residuals of frames that a process knows less about are divided by the growth of its spread first.

use super::dataset::{Frame, at_most};
use super::spread::Residual;
use crate::math::redundancy::{null_space_basis, weighted_pseudo_inverse};
use crate::posture::{Noise, NoiseShares, PostureLaw, gain, speed_squared};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Shares of the variance that may grow with the speed.
const SPEED_SHARES: [f64; 8] = [0.0, 0.25, 0.5, 0.7, 0.85, 0.93, 0.97, 0.99];
/// Directions with less than this part of the largest variance are left out of the noise.
const SMALLEST_VARIANCE: f64 = 1e-3;
/// Share of the diagonal in the covariance.
const SHRINKAGE: f64 = 0.05;
/// Frames and passes of the expectation maximisation.
const FRAMES: usize = 400;
const PASSES: usize = 15;
/// Longest lag of the autocorrelation, s, and as a part of the longest movement.
const LONGEST_LAG_S: f64 = 3.0;
const LONGEST_LAG_PART: f64 = 0.6;
/// Correlation times that are tried, as multiples of the time step.
const TIMES: [f64; 14] =
    [0.75, 1.0, 1.5, 2.0, 3.0, 4.5, 6.0, 9.0, 13.0, 20.0, 30.0, 45.0, 65.0, 100.0];

/// The noise of a law from residuals that it had not seen.
pub fn learn_noise(law: &PostureLaw, residuals: &[Residual]) -> Noise {
    let n = law.dof();
    if residuals.is_empty() {
        return Noise::none(n);
    }
    let squares: f64 = residuals.iter().map(|r| speed_squared(r.frame.xdot.as_slice())).sum();
    let rms = (squares / residuals.len() as f64).sqrt().max(1e-9);
    let plain: Vec<DVector<f64>> =
        residuals.iter().map(|r| r.value.component_div(&r.growth)).collect();
    let share = speed_share(residuals, &plain, rms);
    let unit: Vec<DVector<f64>> = residuals
        .iter()
        .zip(&plain)
        .map(|(r, v)| v / gain(share, rms, r.frame.xdot.as_slice()))
        .collect();
    let frames: Vec<&Frame> = residuals.iter().map(|r| r.frame).collect();
    let (shares, time, step) = shares(&frames, &unit);
    Noise {
        factor: factor(&projected_covariance(law, &frames, &unit)),
        shares,
        correlation_time_s: time,
        white_interval_s: step,
        speed_share: share,
        speed_rms_m_s: rms,
    }
}

/// The share with the largest likelihood of isotropic residuals.
fn speed_share(residuals: &[Residual], plain: &[DVector<f64>], rms: f64) -> f64 {
    let likelihood = |share: f64| {
        let (mut logs, mut sum) = (0.0, 0.0);
        for (r, v) in residuals.iter().zip(plain) {
            let g = gain(share, rms, r.frame.xdot.as_slice());
            logs += g.ln();
            sum += v.norm_squared() / (g * g);
        }
        -logs - 0.5 * residuals.len() as f64 * sum.max(f64::MIN_POSITIVE).ln()
    };
    SPEED_SHARES
        .into_iter()
        .max_by(|a, b| likelihood(*a).total_cmp(&likelihood(*b)))
        .unwrap_or(SPEED_SHARES[0])
}

/// The covariance C of noise of which only `N_W e` is seen.
fn projected_covariance(
    law: &PostureLaw,
    frames: &[&Frame],
    unit: &[DVector<f64>],
) -> DMatrix<f64> {
    let n = law.dof();
    let every: Vec<usize> = (0..frames.len()).collect();
    let seen: Vec<(DVector<f64>, DMatrix<f64>)> = at_most(&every, FRAMES)
        .into_iter()
        .filter_map(|i| {
            if law.is_direct {
                return Some((unit[i].clone(), DMatrix::identity(n, n)));
            }
            let j = &frames[i].jacobian;
            let pinv = match &law.primitive {
                Some(p) => weighted_pseudo_inverse(j, &p.at(frames[i].phase).1)?,
                None => weighted_pseudo_inverse(j, &law.weight)?,
            };
            let vt = null_space_basis(j).transpose();
            let a = &vt - &vt * pinv * j;
            Some((vt * &unit[i], a))
        })
        .collect();
    let count = seen.len().max(1) as f64;
    let mut moment = DMatrix::zeros(n, n);
    for (eta, a) in &seen {
        let back = a.transpose() * eta;
        moment.ger(1.0 / count, &back, &back, 1.0);
    }
    let ridge = (1e-6 * moment.trace() / n as f64).max(1e-12);
    let mut c = moment + DMatrix::identity(n, n) * ridge;
    for _ in 0..PASSES {
        let mut next = DMatrix::zeros(n, n);
        for (eta, a) in &seen {
            let across = &c * a.transpose();
            let k = eta.len();
            let inner = a * &across + DMatrix::identity(k, k) * ridge;
            let Some(inner) = inner.cholesky() else { return c };
            let gained = inner.solve(&across.transpose());
            let mean = gained.transpose() * eta;
            next += &c - &across * &gained;
            next.ger(1.0, &mean, &mean, 1.0);
        }
        c = next / count;
    }
    let diagonal = DMatrix::from_diagonal(&c.diagonal());
    c * (1.0 - SHRINKAGE) + diagonal * SHRINKAGE
}

/// F with `F F^T` the covariance without its smallest directions; columns by falling variance, the
/// first large entry of each positive: joints that share a motion tie for the largest, and rounding
/// must not choose between them.
fn factor(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len())
        .filter(|&i| eigen.eigenvalues[i] > SMALLEST_VARIANCE * largest)
        .collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let columns: Vec<DVector<f64>> = order
        .iter()
        .map(|&i| {
            let v = eigen.eigenvectors.column(i);
            let large = 0.5 * v.amax();
            let sign = v.iter().find(|e| e.abs() > large).map_or(1.0, |e| e.signum());
            v * (sign * eigen.eigenvalues[i].sqrt())
        })
        .collect();
    if columns.is_empty() {
        return DMatrix::zeros(covariance.nrows(), 0);
    }
    DMatrix::from_columns(&columns)
}

/// Lag in steps, correlation, and the number of pairs behind it.
type Curve = Vec<(usize, f64, f64)>;

/// Pooled autocorrelation of rows at frames: (lag in steps, correlation, pairs), not centred, so
/// that what lasts a whole movement shows at every lag; and the time step, s.
fn autocorrelation(frames: &[&Frame], rows: &[DVector<f64>]) -> Option<(Curve, f64)> {
    let mut trials: BTreeMap<usize, BTreeMap<usize, usize>> = BTreeMap::new();
    for (i, f) in frames.iter().enumerate() {
        trials.entry(f.trial).or_default().insert(f.index, i);
    }
    let mut steps: Vec<f64> = Vec::new();
    let mut longest = 0;
    for members in trials.values() {
        let own: Vec<(&usize, &usize)> = members.iter().collect();
        for w in own.windows(2) {
            let apart = (w[1].0 - w[0].0) as f64;
            steps.push((frames[*w[1].1].time_s - frames[*w[0].1].time_s) / apart);
        }
        if let (Some((first, _)), Some((last, _))) = (own.first(), own.last()) {
            longest = longest.max(*last - *first);
        }
    }
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().filter(|s| *s > 0.0)?;
    let most = ((LONGEST_LAG_S / step) as usize).min((LONGEST_LAG_PART * longest as f64) as usize);
    let power = rows.iter().map(DVector::norm_squared).sum::<f64>() / rows.len().max(1) as f64;
    if power <= 0.0 || most == 0 {
        return None;
    }
    let at = |lag: usize| {
        let (mut sum, mut pairs) = (0.0, 0.0);
        for members in trials.values() {
            for (index, i) in members {
                if let Some(j) = members.get(&(index + lag)) {
                    sum += rows[*i].dot(&rows[*j]);
                    pairs += 1.0;
                }
            }
        }
        (lag, if pairs > 0.0 { sum / pairs / power } else { 0.0 }, pairs)
    };
    Some(((1..=most).map(at).filter(|p| p.2 > 0.0).collect(), step))
}

/// First lag (s) at which the correlation falls below 1/e, and the time step (s); none where rows
/// hold no pairs.
pub(super) fn autocorrelation_time(frames: &[&Frame], rows: &[DVector<f64>]) -> Option<(f64, f64)> {
    let (curve, step) = autocorrelation(frames, rows)?;
    let level = (-1.0f64).exp();
    let mut before = (0.0, 1.0);
    for (lag, value, _) in &curve {
        let here = (*lag as f64, *value);
        if here.1 < level {
            let part = (before.1 - level) / (before.1 - here.1).max(1e-12);
            return Some(((before.0 + part * (here.0 - before.0)) * step, step));
        }
        before = here;
    }
    Some((before.0.max(1.0) * step, step))
}

/// Shares of the variance, correlation time (s) and time step (s).
fn shares(frames: &[&Frame], unit: &[DVector<f64>]) -> (NoiseShares, f64, f64) {
    let white = NoiseShares { white: 1.0, correlated: 0.0, lasting: 0.0 };
    let Some((curve, step)) = autocorrelation(frames, unit) else {
        let correlated = NoiseShares { white: 0.0, correlated: 1.0, lasting: 0.0 };
        return (correlated, 0.1, 0.1);
    };
    let mut trials: Vec<usize> = frames.iter().map(|f| f.trial).collect();
    trials.sort_unstable();
    trials.dedup();
    // What lasts a whole movement is not identifiable from a single one.
    let may_last = trials.len() > 2;
    let mut best = (f64::INFINITY, white, step);
    for multiple in TIMES {
        let time = multiple * step;
        let decay = |lag: usize| (-(lag as f64) * step / time).exp();
        for share in solve_shares(&curve, &decay, may_last) {
            let (lasting, correlated) = share;
            let error: f64 = curve
                .iter()
                .map(|(lag, value, pairs)| {
                    pairs * (value - lasting - correlated * decay(*lag)).powi(2)
                })
                .sum();
            if error < best.0 {
                let white = 1.0 - lasting - correlated;
                best = (error, NoiseShares { white, correlated, lasting }, time);
            }
        }
    }
    (best.1, best.2, step)
}

/// Least-squares shares (lasting, correlated) on the simplex: the free solution where it is inside,
/// and the best on each edge.
fn solve_shares(
    curve: &[(usize, f64, f64)],
    decay: &dyn Fn(usize) -> f64,
    may_last: bool,
) -> Vec<(f64, f64)> {
    let (mut s11, mut s1d, mut sdd, mut s1v, mut sdv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (lag, value, pairs) in curve {
        let d = decay(*lag);
        s11 += pairs;
        s1d += pairs * d;
        sdd += pairs * d * d;
        s1v += pairs * value;
        sdv += pairs * d * value;
    }
    let mut found = vec![(0.0, (sdv / sdd).clamp(0.0, 1.0)), (0.0, 0.0)];
    if may_last {
        found.push(((s1v / s11).clamp(0.0, 1.0), 0.0));
        // lasting + correlated = 1: lasting a, correlated 1 - a.
        let numerator = (s1v - s1d) - (sdv - sdd);
        let a = (numerator / (s11 - 2.0 * s1d + sdd).max(1e-12)).clamp(0.0, 1.0);
        found.push((a, 1.0 - a));
        let det = s11 * sdd - s1d * s1d;
        if det > 1e-9 * s11 * sdd {
            let (a, u) = ((s1v * sdd - sdv * s1d) / det, (sdv * s11 - s1v * s1d) / det);
            if a >= 0.0 && u >= 0.0 && a + u <= 1.0 {
                found.push((a, u));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use crate::training::dataset::runs;
    use crate::training::dataset::tests::made_up;

    #[test]
    fn known_noise_is_found_again() {
        // Seen only through the null space, with a speed gain and all three parts in time.
        let data = made_up(60, 8.0, 30.0);
        let moment =
            DMatrix::from_fn(24, 24, |i, j| if i == j { 1.0 + 0.1 * i as f64 } else { 0.0 });
        let law = PostureLaw::of_weight(moment, 1.6, 6);
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let squares: f64 = frames.iter().map(|f| speed_squared(f.xdot.as_slice())).sum();
        let factor = DMatrix::from_fn(24, 24, |i, j| {
            let own = if i == j { 0.3 } else { 0.0 };
            own + if j < 3 { ((i * (j + 2)) as f64).sin() / (1.0 + j as f64) } else { 0.0 }
        });
        let truth = Noise {
            factor,
            shares: NoiseShares { white: 0.2, correlated: 0.5, lasting: 0.3 },
            correlation_time_s: 0.3,
            white_interval_s: 1.0 / 30.0,
            speed_share: 0.5,
            speed_rms_m_s: (squares / frames.len() as f64).sqrt(),
        };
        let mut residuals = Vec::new();
        for (r, run) in runs(&frames).iter().enumerate() {
            let mut rng = stream(5, Purpose::Simulation, 0, r as u32);
            let path = truth.path(&mut rng, run.len(), 1.0 / 30.0);
            residuals.extend(run.iter().enumerate().map(|(k, &frame)| {
                let e = path.at(k, 0.0) * truth.gain(frame.xdot.as_slice());
                let pinv = weighted_pseudo_inverse(&frame.jacobian, &law.weight).unwrap();
                let value = &e - pinv * (&frame.jacobian * &e);
                Residual { frame, value, growth: DVector::from_element(24, 1.0) }
            }));
        }
        let found = learn_noise(&law, &residuals);
        assert!((found.speed_share - 0.5).abs() < 0.26, "{}", found.speed_share);
        assert!((found.shares.white - 0.2).abs() < 0.08, "{:?}", found.shares);
        assert!((found.shares.correlated - 0.5).abs() < 0.15, "{:?}", found.shares);
        assert!((found.correlation_time_s - 0.3).abs() < 0.11, "{}", found.correlation_time_s);
        // What can be seen of the covariance: through the null space.
        let seen = |c: &DMatrix<f64>| {
            frames.iter().step_by(97).fold(DMatrix::zeros(24, 24), |sum, f| {
                let pinv = weighted_pseudo_inverse(&f.jacobian, &law.weight).unwrap();
                let a = DMatrix::identity(24, 24) - pinv * &f.jacobian;
                sum + &a * c * a.transpose()
            })
        };
        let (own, planted) = (seen(&found.covariance()), seen(&truth.covariance()));
        let error = (&own - &planted).norm() / planted.norm();
        assert!(error < 0.25, "covariance off by {error}");
    }
}

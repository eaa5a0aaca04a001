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
//! By the hand's clock lags are hand travel over the usual speed; the drift is what joints do in frames
//! in which the hand rests.

use super::dataset::{Frame, at_most};
use super::spread::{Residual, planted_of};
use crate::math::redundancy::{null_space_basis, weighted_pseudo_inverse};
use crate::posture::{
    Clock, Drift, LowNoise, Lowness, Noise, NoiseShares, PostureLaw, gain, speed_squared,
};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Shares of the variance that may grow with the speed.
const SPEED_SHARES: [f64; 8] = [0.0, 0.25, 0.5, 0.7, 0.85, 0.93, 0.97, 0.99];
/// Ratios of the noise at low hands to that at others.
const LOW_RATIOS: [f64; 11] = [0.35, 0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0, 2.8, 4.0, 5.6];
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

/// A hand rests where it is slower than this for so long, m/s and s: where it turns or sets out, the
/// joints still move.
const REST_M_S: f64 = 0.02;
const REST_S: f64 = 0.3;
/// Joint speed (rms, rad/s) and time (s) of the drift where no recorded hand rests: those of a
/// recorded hand-over.
const ASSUMED_SPEED_RAD_S: f64 = 1.6 * std::f64::consts::PI / 180.0;
const ASSUMED_TIME_S: f64 = 0.3;
/// Lag over T at which the speed of a drift is correlated by 1/e.
const DRIFT_LAG: f64 = 0.726;

/// The noise of a law from residuals that it had not seen; with `goes_with_hand` by the hand's clock.
///
/// Where a hand can be low the noise goes by that too.
pub fn learn_noise(
    law: &PostureLaw,
    residuals: &[Residual],
    (goes_with_hand, lowness): (bool, Option<Lowness>),
) -> Noise {
    let n = law.dof();
    if residuals.is_empty() {
        return no_noise(&[], n, goes_with_hand);
    }
    // A step moves the pelvis as nothing does in a plan.
    let residuals = planted_of(residuals, |r| r.frame);
    let residuals = residuals.as_slice();
    let frames: Vec<&Frame> = residuals.iter().map(|r| r.frame).collect();
    let rms = usual_speed(&frames);
    let plain: Vec<DVector<f64>> =
        residuals.iter().map(|r| r.value.component_div(&r.growth)).collect();
    let share = speed_share(residuals, &plain, rms);
    let unit: Vec<DVector<f64>> = residuals
        .iter()
        .zip(&plain)
        .map(|(r, v)| v / gain(share, rms, r.frame.xdot.as_slice()))
        .collect();
    let low = lowness.map(|lowness| low_noise(lowness, &frames, &unit, law.stature_m));
    let unit: Vec<DVector<f64>> = match &low {
        Some(low) => {
            let here = |f: &Frame| low.gains(f.hand.translation.y / law.stature_m);
            unit.iter().zip(&frames).map(|(v, f)| v.component_div(&here(f))).collect()
        }
        None => unit,
    };
    let own = goes_with_hand.then(|| hand_times(&frames, rms));
    let (shares, time, step) = shares(&frames, &unit, own.as_deref());
    let factor = factor(&projected_covariance(law, &frames, &unit));
    let clock = if goes_with_hand {
        Clock::Hand { speed_m_s: rms, drift: drift(law, residuals, &factor) }
    } else {
        Clock::Seconds { speed_share: share, speed_rms_m_s: rms }
    };
    Noise { factor, shares, correlation_time_s: time, white_interval_s: step, clock, low }
}

/// The clock of a law without noise of n joints.
pub(super) fn no_noise(frames: &[&Frame], n: usize, goes_with_hand: bool) -> Noise {
    let plain = Noise::none(n);
    let by_hand = Clock::Hand { speed_m_s: usual_speed(frames), drift: Drift::NONE };
    Noise { clock: if goes_with_hand { by_hand } else { plain.clock }, ..plain }
}

/// Rms hand speed, m/s.
fn usual_speed(frames: &[&Frame]) -> f64 {
    let squares: f64 = frames.iter().map(|f| speed_squared(f.xdot.as_slice())).sum();
    (squares / frames.len().max(1) as f64).sqrt().max(1e-9)
}

/// Time by the hand's clock of each frame since the start of its trial, s.
pub(super) fn hand_times(frames: &[&Frame], usual_m_s: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by_key(|&i| (frames[i].trial, frames[i].index));
    let mut times = vec![0.0; frames.len()];
    for pair in order.windows(2) {
        let [a, b] = [frames[pair[0]], frames[pair[1]]];
        if a.trial == b.trial {
            let speed = |f: &Frame| speed_squared(f.xdot.as_slice()).sqrt();
            let travel = 0.5 * (speed(a) + speed(b)) * (b.time_s - a.time_s);
            times[pair[1]] = times[pair[0]] + travel / usual_m_s;
        }
    }
    times
}

/// Which of the frames are ones in which the hand rests.
pub(super) fn at_rest(frames: &[&Frame]) -> Vec<bool> {
    let is_slow = |f: &Frame| f.xdot.iter().take(3).map(|v| v * v).sum::<f64>() < REST_M_S.powi(2);
    let mut found = vec![false; frames.len()];
    let mut from = 0;
    for at in 0..frames.len() {
        let [first, here] = [frames[from], frames[at]];
        if !is_slow(here) {
            from = at + 1;
        } else if first.trial != here.trial || here.index - first.index != at - from {
            from = at;
        } else if here.time_s - first.time_s >= REST_S {
            found[from..=at].fill(true);
        }
    }
    found
}

/// The drift, with the directions of the noise: such that what the task leaves of it is what joints do
/// in frames in which the hand rests, or what they are assumed to do where there are none.
fn drift(law: &PostureLaw, residuals: &[Residual], factor: &DMatrix<f64>) -> Drift {
    let frames: Vec<&Frame> = residuals.iter().map(|r| r.frame).collect();
    let rests = residuals.iter().zip(at_rest(&frames)).filter(|(_, rests)| *rests);
    let still: Vec<&Residual> = rests.map(|(r, _)| r).collect();
    let n = law.dof() as f64;
    let (mut speed, mut time_s) = (ASSUMED_SPEED_RAD_S, ASSUMED_TIME_S);
    if !still.is_empty() {
        let values: Vec<DVector<f64>> = still.iter().map(|r| r.value.clone()).collect();
        let squares: f64 = values.iter().map(DVector::norm_squared).sum();
        speed = (squares / (n * values.len() as f64)).sqrt();
        let frames: Vec<&Frame> = still.iter().map(|r| r.frame).collect();
        if let Some((lag_s, _)) = autocorrelation_time(&frames, &values) {
            time_s = lag_s / DRIFT_LAG;
        }
    }
    // The part of the noise that the task leaves, at these frames.
    let left: Vec<f64> = at_most(&frames, FRAMES)
        .into_iter()
        .filter_map(|f| {
            let pinv = weighted_pseudo_inverse(&f.jacobian, &law.weight)?;
            Some((factor - pinv * (&f.jacobian * factor)).norm_squared())
        })
        .collect();
    let share = crate::math::stats::mean(&left) / factor.norm_squared();
    let speed_rad_s = if share > 0.0 { speed / share.sqrt() } else { 0.0 };
    Drift { speed_rad_s, time_s }
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

/// For each joint the ratio of the noise at low hands to that at others with the largest likelihood.
fn low_noise(
    lowness: Lowness,
    frames: &[&Frame],
    unit: &[DVector<f64>],
    stature_m: f64,
) -> LowNoise {
    let lows: Vec<f64> =
        frames.iter().map(|f| lowness.of(f.hand.translation.y / stature_m)).collect();
    let gain = |ratio: f64, low: f64| 1.0 + (ratio - 1.0) * low;
    let likelihood = |joint: usize, ratio: f64| {
        let (mut logs, mut sum) = (0.0, 0.0);
        for (low, v) in lows.iter().zip(unit) {
            let g = gain(ratio, *low);
            logs += g.ln();
            sum += (v[joint] / g).powi(2);
        }
        -logs - 0.5 * lows.len() as f64 * sum.max(f64::MIN_POSITIVE).ln()
    };
    let n = unit.first().map_or(0, DVector::len);
    let best = |joint: usize| {
        let by = |a: &f64, b: &f64| likelihood(joint, *a).total_cmp(&likelihood(joint, *b));
        LOW_RATIOS.into_iter().max_by(by).unwrap_or(1.0)
    };
    let ratios = DVector::from_fn(n, |joint, _| best(joint));
    let size = |ratio: f64| {
        crate::math::stats::mean(&lows.iter().map(|l| gain(ratio, *l).powi(2)).collect::<Vec<_>>())
            .sqrt()
    };
    let (high, low) = (ratios.map(|r| 1.0 / size(r)), ratios.map(|r| r / size(r)));
    LowNoise { lowness, high, low }
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

/// The same over lags of given times (s) of the frames, in bins of a time step.
fn autocorrelation_by(
    frames: &[&Frame],
    rows: &[DVector<f64>],
    times: &[f64],
) -> Option<(Curve, f64)> {
    let (curve, step) = autocorrelation(frames, rows)?;
    let most = curve.last().map_or(0, |c| c.0);
    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by_key(|&i| (frames[i].trial, frames[i].index));
    let power = rows.iter().map(DVector::norm_squared).sum::<f64>() / rows.len().max(1) as f64;
    let mut bins = vec![(0.0, 0.0); most + 1];
    for (at, &i) in order.iter().enumerate() {
        for &j in &order[at + 1..] {
            let lag = ((times[j] - times[i]) / step).round();
            if frames[j].trial != frames[i].trial || lag > most as f64 {
                break;
            }
            let bin = &mut bins[lag as usize];
            bin.0 += rows[i].dot(&rows[j]);
            bin.1 += 1.0;
        }
    }
    let curve = bins.iter().enumerate().skip(1).filter(|(_, b)| b.1 > 0.0);
    Some((curve.map(|(lag, b)| (lag, b.0 / b.1 / power, b.1)).collect(), step))
}

/// Shares of the variance, correlation time (s) and time step (s), by times of the frames (s) other
/// than true time where they are given.
fn shares(
    frames: &[&Frame],
    unit: &[DVector<f64>],
    times: Option<&[f64]>,
) -> (NoiseShares, f64, f64) {
    let white = NoiseShares { white: 1.0, correlated: 0.0, lasting: 0.0 };
    let curve = match times {
        Some(times) => autocorrelation_by(frames, unit, times),
        None => autocorrelation(frames, unit),
    };
    let Some((curve, step)) = curve else {
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
    fn only_a_hand_that_stays_slow_rests() {
        let mut data = made_up(2, 2.0, 30.0);
        for f in &mut data.frames {
            // 0.33 s, then 0.27 s, then a rest that begins in the next trial.
            let slow = match f.trial {
                0 => (10..=20).contains(&f.index) || (30..=38).contains(&f.index) || f.index >= 55,
                _ => f.index < 6 || f.index >= 40,
            };
            f.xdot[0] = if slow { 0.01 } else { 0.5 };
            f.xdot[1] = 0.0;
            f.xdot[2] = 0.0;
        }
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let found: Vec<(usize, usize)> = frames
            .iter()
            .zip(at_rest(&frames))
            .filter(|(_, rests)| *rests)
            .map(|(f, _)| (f.trial, f.index))
            .collect();
        let wanted: Vec<(usize, usize)> =
            (10..=20).map(|i| (0, i)).chain((40..60).map(|i| (1, i))).collect();
        assert_eq!(found, wanted);
    }

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
            clock: Clock::Seconds {
                speed_share: 0.5,
                speed_rms_m_s: (squares / frames.len() as f64).sqrt(),
            },
            low: None,
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
        let found = learn_noise(&law, &residuals, (false, None));
        let Clock::Seconds { speed_share, .. } = found.clock else { panic!("{:?}", found.clock) };
        assert!((speed_share - 0.5).abs() < 0.26, "{speed_share}");
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

    #[test]
    fn noise_at_low_hands_is_found() {
        let data = made_up(1, 20.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().collect();
        let mut heights: Vec<f64> = frames.iter().map(|f| f.hand.translation.y / 1.6).collect();
        heights.sort_by(f64::total_cmp);
        let lowness = Lowness::linear(heights[heights.len() * 3 / 4], heights[heights.len() / 4]);
        let truth = |joint: usize, height: f64| match joint {
            0..12 => 1.0 + lowness.of(height),
            _ => 1.0,
        };
        let mut rng = stream(9, Purpose::Simulation, 0, 0);
        let heights: Vec<f64> = frames.iter().map(|f| f.hand.translation.y / 1.6).collect();
        let unit: Vec<DVector<f64>> = heights
            .iter()
            .map(|h| {
                let draws = crate::math::stream::normals(&mut rng, 24);
                DVector::from_fn(24, |joint, _| draws[joint] * truth(joint, *h))
            })
            .collect();
        let two = low_noise(lowness, &frames, &unit, 1.6);
        let ratio = |joint: usize| two.low[joint] / two.high[joint];
        // Neighbours on the grid count.
        assert!((0..12).all(|j| (1.4..=2.8).contains(&ratio(j))), "{two:?}");
        assert!((12..24).all(|j| (0.84..=1.21).contains(&ratio(j))), "{two:?}");
        let middle = |joints: std::ops::Range<usize>| {
            crate::math::stats::quantile(&joints.map(ratio).collect::<Vec<_>>(), 0.5)
        };
        assert!((middle(0..12) - 2.0).abs() < 1e-9 && (middle(12..24) - 1.0).abs() < 1e-9);
        for joint in [0, 20] {
            let squares: Vec<f64> = heights.iter().map(|h| two.gains(*h)[joint].powi(2)).collect();
            assert!((crate::math::stats::mean(&squares) - 1.0).abs() < 1e-9);
        }
    }
}

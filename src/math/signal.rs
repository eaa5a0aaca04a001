//! Filtering and differentiation of uniformly sampled signals.

use std::f64::consts::{PI, SQRT_2};

/// Low-pass filter without phase lag: a second-order Butterworth run forward and backward (fourth
/// order in all, as is usual in biomechanics).
///
/// `cutoff_hz` is the frequency at which the *combined* gain is 1/sqrt(2) (Winter's correction for
/// two passes). Ends are padded by odd reflection. Signals of fewer than four samples, and cut-offs
/// at or above a quarter of the rate (where a filter would do nothing sensible), come back unchanged.
pub fn low_pass_zero_phase(signal: &[f64], rate_hz: f64, cutoff_hz: f64) -> Vec<f64> {
    if signal.len() < 4 || cutoff_hz >= 0.25 * rate_hz {
        return signal.to_vec();
    }
    let pad = ((3.0 * rate_hz / cutoff_hz) as usize).clamp(3, signal.len() - 1);
    let (first, last) = (signal[0], signal[signal.len() - 1]);
    let mut x: Vec<f64> = (1..=pad).rev().map(|i| 2.0 * first - signal[i]).collect();
    x.extend_from_slice(signal);
    x.extend((1..=pad).map(|i| 2.0 * last - signal[signal.len() - 1 - i]));
    let coefficients = Biquad::butterworth_for_two_passes(cutoff_hz / rate_hz);
    coefficients.run(&mut x);
    x.reverse();
    coefficients.run(&mut x);
    x.reverse();
    x[pad..pad + signal.len()].to_vec()
}

struct Biquad {
    a: [f64; 3],
    b: [f64; 2],
}

impl Biquad {
    /// `f` is the cut-off as a fraction of the sampling rate.
    fn butterworth_for_two_passes(f: f64) -> Self {
        let one_pass = (SQRT_2 - 1.0).powf(0.25);
        let c = (PI * f).tan() / one_pass;
        let (k1, k2) = (SQRT_2 * c, c * c);
        let a0 = k2 / (1.0 + k1 + k2);
        let k3 = 2.0 * a0 / k2;
        Self { a: [a0, 2.0 * a0, a0], b: [-2.0 * a0 + k3, 1.0 - 2.0 * a0 - k3] }
    }

    /// Filters in place, started in the steady state of the first sample.
    fn run(&self, x: &mut [f64]) {
        let (mut x1, mut x2, mut y1, mut y2) = (x[0], x[0], x[0], x[0]);
        for value in x {
            let y = self.a[0] * *value
                + self.a[1] * x1
                + self.a[2] * x2
                + self.b[0] * y1
                + self.b[1] * y2;
            (x2, x1, y2, y1) = (x1, *value, y1, y);
            *value = y;
        }
    }
}

/// Derivative by central differences, one-sided at the two ends; `dt` in s.
pub fn differentiate(signal: &[f64], dt: f64) -> Vec<f64> {
    let n = signal.len();
    if n < 2 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|i| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (signal[high] - signal[low]) / ((high - low) as f64 * dt)
        })
        .collect()
}

/// Removes jumps of 2 pi between neighbouring samples (rad), in place.
pub fn unwrap_angles(signal: &mut [f64]) {
    for i in 1..signal.len() {
        let jump = signal[i] - signal[i - 1];
        signal[i] -= (jump / (2.0 * PI)).round() * 2.0 * PI;
    }
}

/// First lag (s) at which the autocorrelation, pooled over `series`, falls below 1/e, interpolated
/// linearly; the longest lag examined when it never does. Each series has mean zero by assumption.
pub fn correlation_time(series: &[Vec<f64>], dt: f64) -> f64 {
    let longest = series.iter().map(Vec::len).max().unwrap_or(0) / 2;
    let at = |lag: usize| -> f64 {
        let sums = series.iter().filter(|s| s.len() > lag).map(|s| {
            let products: f64 = (0..s.len() - lag).map(|i| s[i] * s[i + lag]).sum();
            products / (s.len() - lag) as f64
        });
        sums.sum()
    };
    let variance = at(0);
    if variance <= 0.0 {
        return dt;
    }
    let level = (-1.0f64).exp();
    let mut before = 1.0;
    for lag in 1..=longest {
        let now = at(lag) / variance;
        if now < level {
            let part = (before - level) / (before - now);
            return ((lag - 1) as f64 + part) * dt;
        }
        before = now;
    }
    longest.max(1) as f64 * dt
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};
    use approx::assert_relative_eq;

    fn amplitude_after(f_hz: f64) -> f64 {
        let rate = 120.0;
        let wave: Vec<f64> =
            (0..2400).map(|i| (2.0 * PI * f_hz * f64::from(i) / rate).sin()).collect();
        let out = low_pass_zero_phase(&wave, rate, 6.0);
        // Whole periods: the amplitude from the mean square, not from samples that miss the peak.
        (out[600..1800].iter().map(|v| v * v).sum::<f64>() / 600.0).sqrt()
    }

    #[test]
    fn gain_follows_the_squared_butterworth() {
        // Two passes of second order: gain 1 / (1 + (w / wc1)^4), bilinear warping included.
        let warp = |f: f64| (PI * f / 120.0).tan();
        for f in [0.5, 2.0, 6.0, 12.0] {
            let r = warp(f) / (warp(6.0) / (SQRT_2 - 1.0).powf(0.25));
            assert_relative_eq!(amplitude_after(f), 1.0 / (1.0 + r.powi(4)), epsilon = 2e-3);
        }
        assert_relative_eq!(amplitude_after(6.0), 1.0 / SQRT_2, epsilon = 2e-3);
    }

    #[test]
    fn straight_lines_pass_unchanged() {
        let line: Vec<f64> = (0..100).map(|i| 0.3 + 0.01 * f64::from(i)).collect();
        let out = low_pass_zero_phase(&line, 60.0, 6.0);
        for (a, b) in line.iter().zip(&out) {
            assert_relative_eq!(a, b, epsilon = 1e-6);
        }
        assert!(differentiate(&line, 0.1).iter().all(|d| (d - 0.1).abs() < 1e-12));
    }

    #[test]
    fn unwrapping_undoes_wrapping() {
        let truth: Vec<f64> = (0..50).map(|i| 0.3 * f64::from(i)).collect();
        let mut wrapped: Vec<f64> = truth.iter().map(|a| a.sin().atan2(a.cos())).collect();
        unwrap_angles(&mut wrapped);
        for (a, b) in truth.iter().zip(&wrapped) {
            assert_relative_eq!(a, b, epsilon = 1e-9);
        }
    }

    #[test]
    fn correlation_time_of_a_known_process() {
        let (dt, tau) = (0.02, 0.3);
        let a = f64::exp(-dt / tau);
        let mut rng = stream(1, Purpose::Simulation, 0, 0);
        let mut x = 0.0;
        let series: Vec<f64> = normals(&mut rng, 60_000)
            .into_iter()
            .map(|e| {
                x = a * x + (1.0 - a * a).sqrt() * e;
                x
            })
            .collect();
        assert_relative_eq!(correlation_time(&[series], dt), tau, max_relative = 0.1);
    }
}

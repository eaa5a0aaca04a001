//! When a path is where: its time law, quicker in some parts and slower in others.
//!
//! ```text
//! s(t) = minimum jerk(tau(t / T)),   tau(u_k) = k / m,   u_k - u_(k-1) = exp(l_k) / sum_j exp(l_j)
//! l = spread H x                     (H: m orthonormal columns that sum to nothing, m - 1 rows)
//! ```
//! `x` in R^(m-1) is white; at 0 the law is the minimum-jerk one. `tau` is the monotone cubic of
//! F. N. Fritsch and R. E. Carlson (SIAM J. Numer. Anal. 17, 1980), with the harmonic slopes of
//! F. N. Fritsch and J. Butland.

use serde::Serialize;

/// The shares of the time at which each equal part of the minimum-jerk law ends.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pace {
    /// `u_0 = 0` to `u_m = 1`, strictly increasing.
    ends: Vec<f64>,
}

impl Pace {
    /// The pace at white numbers, as many as parts less one. `spread` is the standard deviation of the
    /// logarithm of a part's duration.
    pub fn of_white(x: &[f64], spread: f64) -> Self {
        let m = x.len() + 1;
        // Row j of Helmert's matrix: j ones, then -j, over sqrt(j (j + 1)).
        let logarithm = |k: usize| {
            let row = |(i, x): (usize, &f64)| {
                let j = i + 1;
                let weight = if k < j { 1.0 } else { -(j as f64) * f64::from(u8::from(k == j)) };
                x * weight / ((j * (j + 1)) as f64).sqrt()
            };
            spread * x.iter().enumerate().map(row).sum::<f64>()
        };
        let parts: Vec<f64> = (0..m).map(|k| logarithm(k).clamp(-3.0, 3.0).exp()).collect();
        let whole: f64 = parts.iter().sum();
        let mut ends = vec![0.0];
        ends.extend(parts.iter().scan(0.0, |sum, part| {
            *sum += part / whole;
            Some(*sum)
        }));
        ends[m] = 1.0;
        Self { ends }
    }

    /// tau(u) for u in [0, 1].
    pub fn at(&self, u: f64) -> f64 {
        let m = self.ends.len() - 1;
        let k = self.ends.partition_point(|e| *e <= u).clamp(1, m) - 1;
        let (h, rise) = (self.ends[k + 1] - self.ends[k], 1.0 / m as f64);
        let p = ((u - self.ends[k]) / h).clamp(0.0, 1.0);
        let (a, b) = (h * self.slope(k), h * self.slope(k + 1));
        // The cubic with these ends and slopes.
        let cubic = (a + b - 2.0 * rise) * p + (3.0 * rise - 2.0 * a - b);
        (k as f64 * rise + (cubic * p + a) * p).clamp(0.0, 1.0)
    }

    /// The slope at an end of a part: the harmonic mean of those beside it, which keeps the cubic
    /// monotone; at the first and last end that of the part.
    fn slope(&self, k: usize) -> f64 {
        let m = self.ends.len() - 1;
        let of_part = |k: usize| 1.0 / (m as f64 * (self.ends[k + 1] - self.ends[k]));
        if k == 0 {
            return of_part(0);
        }
        if k == m {
            return of_part(m - 1);
        }
        let (a, b) = (of_part(k - 1), of_part(k));
        2.0 * a * b / (a + b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn without_numbers_time_is_as_it_was() {
        for pace in [Pace::of_white(&[], 0.5), Pace::of_white(&[0.0; 3], 0.5)] {
            for i in 0..=100 {
                let u = f64::from(i) / 100.0;
                assert!((pace.at(u) - u).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn time_never_runs_back_and_parts_end_where_they_should() {
        for trial in 0..200 {
            let mut rng = stream(1, Purpose::Search, 9, trial);
            let x = normals(&mut rng, 3);
            let pace = Pace::of_white(&x, 1.0);
            let all: Vec<f64> = (0..=1000).map(|i| pace.at(f64::from(i) / 1000.0)).collect();
            assert!(all.windows(2).all(|w| w[1] >= w[0] - 1e-12), "{x:?}");
            assert!(all[0] == 0.0 && (all[1000] - 1.0).abs() < 1e-12);
            for (k, end) in pace.ends.iter().enumerate() {
                assert!((pace.at(*end) - k as f64 / 4.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn each_part_has_the_same_law() {
        // Orthonormal rows: the logarithms' covariance is spread^2 (I - 1/m).
        for k in 0..3 {
            let mut x = [0.0; 3];
            x[k] = 1.0;
            let pace = Pace::of_white(&x, 0.7);
            let parts: Vec<f64> = pace.ends.windows(2).map(|w| (w[1] - w[0]).ln()).collect();
            let mean = parts.iter().sum::<f64>() / 4.0;
            let square: f64 = parts.iter().map(|l| (l - mean).powi(2)).sum();
            assert!((square - 0.49).abs() < 1e-12, "{square}");
        }
    }
}

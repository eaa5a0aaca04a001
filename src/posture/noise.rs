//! What differs from one repetition to the next: noise in the preferred joint velocity.
//!
//! ```text
//! e(t) = g F (sqrt(a_w) w(t) + sqrt(a_u) u(t) + sqrt(a_b) b)       a_w + a_u + a_b = 1
//! u    Ornstein-Uhlenbeck, unit variance, correlation time tau
//! b    one draw for the whole movement (between movements of one person)
//! w    white: its integral over a time t has variance dt_0 t, dt_0 the interval of the data
//! ```
//! The integral of every part is that of a process in continuous time, so the spread of postures does
//! not depend on the time step. What `t` is, the [`Clock`] says:
//!
//! ```text
//! hand     t = hand travel / usual speed, g = 1: a resting hand brings no noise, and the spread along
//!          a path does not depend on its duration. Beside it a drift in true time, of small extent:
//!          d(t) = F' (a cos wt + b sin wt),  w ~ N(0, 1 / T^2) for each direction
//! seconds  t is time,  g^2 = 1 - s + s |v|^2 / v_rms^2,   |v|^2 = |linear|^2 + (0.3 m |angular|)^2
//! ```
//! `F F^T` is the covariance of the residuals at the usual (rms) hand speed.

use super::lowness::Lowness;
use crate::math::simd::{sin_cos, wide};
use crate::math::stream::normals;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Length by which an angular speed counts like a linear one, m/rad.
pub(super) const ROTATION_LENGTH_M: f64 = 0.3;

/// Shares of the variance of the noise; they sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseShares {
    /// Independent from one sample of the data to the next.
    pub white: f64,
    /// Correlated over the correlation time.
    pub correlated: f64,
    /// The same for a whole movement.
    pub lasting: f64,
}

/// What makes a movement go on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "by", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Clock {
    /// The hand: own time is its travel over its usual speed.
    Hand {
        /// Usual (rms) hand speed, m/s, rotations counted at 0.3 m/rad.
        speed_m_s: f64,
        /// What remains while the hand rests.
        drift: Drift,
    },
    /// True time.
    Seconds {
        /// s: share of the variance that grows with the square of the hand speed.
        speed_share: f64,
        /// Rms hand speed of the data, m/s.
        speed_rms_m_s: f64,
    },
}

/// How joints drift while the hand rests: a stationary process in time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Joint speed, rms over joints and time, rad/s.
    pub speed_rad_s: f64,
    /// Time T in which it turns round, s.
    pub time_s: f64,
}

impl Drift {
    /// A posture that does not drift.
    pub const NONE: Self = Self { speed_rad_s: 0.0, time_s: 1.0 };
}

/// Parameters of the noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// F, n x r, rad/s at usual hand speed.
    pub factor: DMatrix<f64>,
    /// How the variance is shared out in time.
    pub shares: NoiseShares,
    /// Correlation time tau, s of the clock.
    pub correlation_time_s: f64,
    /// Interval of the samples from which the white share was estimated, s of the clock.
    pub white_interval_s: f64,
    /// What its time is.
    pub clock: Clock,
    /// How much of it there is where the hand is low; none where it is alike everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<LowNoise>,
}

/// Noise that goes by the height of the hand. Over the training data the mean square of each factor is 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowNoise {
    /// Where a hand is low.
    pub lowness: Lowness,
    /// Factors of the standard deviation in each coordinate for hands that are not low, n.
    pub high: DVector<f64>,
    /// The same for hands that are.
    pub low: DVector<f64>,
}

impl LowNoise {
    /// The factors at a height (rest frame, over stature), n.
    pub fn gains(&self, height: f64) -> DVector<f64> {
        self.high.lerp(&self.low, self.lowness.of(height))
    }
}

impl Noise {
    /// No noise at all, for n joints.
    pub fn none(n: usize) -> Self {
        Self::correlated(DMatrix::zeros(n, 0), 1.0)
    }

    /// Correlated noise that does not depend on the hand speed.
    pub fn correlated(factor: DMatrix<f64>, correlation_time_s: f64) -> Self {
        Self {
            factor,
            shares: NoiseShares { white: 0.0, correlated: 1.0, lasting: 0.0 },
            correlation_time_s,
            white_interval_s: 1.0,
            clock: Clock::Seconds { speed_share: 0.0, speed_rms_m_s: 1.0 },
            low: None,
        }
    }

    /// g: the factor by which the hand's velocity (linear, then angular) scales the noise in seconds.
    pub fn gain(&self, task: &[f64]) -> f64 {
        match self.clock {
            Clock::Hand { speed_m_s, .. } => gain(1.0, speed_m_s, task),
            Clock::Seconds { speed_share, speed_rms_m_s } => gain(speed_share, speed_rms_m_s, task),
        }
    }

    /// `F F^T`, n x n, (rad/s)^2.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.factor * self.factor.transpose()
    }

    /// Correlation of the noise of two samples `lag_s` apart; 1 for the same sample.
    pub fn correlation(&self, lag_s: f64) -> f64 {
        let white = if lag_s == 0.0 { self.shares.white } else { 0.0 };
        let decay = (-lag_s.abs() / self.correlation_time_s).exp();
        self.shares.lasting + self.shares.correlated * decay + white
    }

    /// What a drift adds to the correlation of the noise of two samples `lag_s` of true time apart, in
    /// units of `F F^T`.
    pub fn drift_correlation(&self, lag_s: f64) -> f64 {
        let Clock::Hand { drift, .. } = self.clock else { return 0.0 };
        let size = drift.speed_rad_s.powi(2) * self.factor.nrows() as f64
            / self.factor.norm_squared().max(f64::MIN_POSITIVE);
        let x = (lag_s / drift.time_s).powi(2);
        size * (1.0 - x) * (-0.5 * x).exp()
    }

    /// One sample path at `count` times `dt` (s of the clock) apart, before the gain. Longer paths begin
    /// like shorter ones.
    pub fn path(&self, rng: &mut ChaCha8Rng, count: usize, dt: f64) -> NoisePath {
        let r = self.factor.ncols();
        let mut draw = || DVector::from_vec(normals(rng, r));
        let keep = (-dt / self.correlation_time_s).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        let lasting = draw() * self.shares.lasting.sqrt();
        let mut u = draw();
        let white = (self.shares.white * self.white_interval_s / dt).sqrt();
        let (mut smooth, mut held) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            smooth.push(&self.factor * (&u * self.shares.correlated.sqrt() + &lasting));
            u = u * keep + draw() * fresh;
            // Drawn even where it does not count, so that the shares do not change the rest.
            let own = draw() * white;
            held.push(if white == 0.0 {
                DVector::zeros(self.factor.nrows())
            } else {
                &self.factor * own
            });
        }
        NoisePath { smooth, held }
    }

    /// One drift of the posture in time; none where the clock is true time.
    pub fn drift(&self, rng: &mut ChaCha8Rng) -> Option<DriftPath> {
        let Clock::Hand { drift, .. } = self.clock else { return None };
        let (n, r) = self.factor.shape();
        // sd of the angle: that of the speed times T.
        let size = drift.speed_rad_s * drift.time_s * (n as f64).sqrt() / self.factor.norm();
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        let mut waves = || {
            let draws = DVector::from_vec(normals(rng, r));
            &self.factor * DMatrix::from_diagonal(&(draws * size))
        };
        let (cosines, sines) = (waves(), waves());
        let rates = normals(rng, r).into_iter().map(|w| w / drift.time_s).collect();
        Some(DriftPath { cosines, sines, rates })
    }

    /// The published sampler: independent at each of `count` samples, whatever their distance.
    pub fn independent(&self, rng: &mut ChaCha8Rng, count: usize) -> NoisePath {
        let (n, r) = self.factor.shape();
        let held = (0..count).map(|_| &self.factor * DVector::from_vec(normals(rng, r))).collect();
        NoisePath { smooth: vec![DVector::zeros(n); count], held }
    }
}

/// `sqrt(1 - s + s |v|^2 / v_rms^2)`.
pub fn gain(speed_share: f64, speed_rms_m_s: f64, task: &[f64]) -> f64 {
    let relative = speed_squared(task) / (speed_rms_m_s * speed_rms_m_s);
    (1.0 - speed_share + speed_share * relative).sqrt()
}

/// `|linear|^2 + (0.3 m |angular|)^2`, (m/s)^2. `task` holds linear and angular velocity (or less).
pub fn speed_squared(task: &[f64]) -> f64 {
    let linear: f64 = task.iter().take(3).map(|v| v * v).sum();
    let angular: f64 = task.iter().skip(3).map(|w| (ROTATION_LENGTH_M * w).powi(2)).sum();
    linear + angular
}

/// The noise at the samples of a path, before the gain, n each (rad/s).
#[derive(Debug, Clone)]
pub struct NoisePath {
    /// Interpolated between samples.
    smooth: Vec<DVector<f64>>,
    /// Held from one sample to the next.
    held: Vec<DVector<f64>>,
}

impl NoisePath {
    /// Between sample `index` and the next; `part` in [0, 1].
    pub fn at(&self, index: usize, part: f64) -> DVector<f64> {
        let mut sum = DVector::zeros(self.smooth[0].len());
        self.add_to(&mut sum, (index, part), 1.0, None);
        sum
    }

    /// Adds `gain` times the noise there to `out` (n, rad/s), in each coordinate by a factor of its own where
    /// there are `gains`.
    pub(super) fn add_to(
        &self,
        out: &mut DVector<f64>,
        (index, part): (usize, f64),
        gain: f64,
        gains: Option<&DVector<f64>>,
    ) {
        let last = self.smooth.len() - 1;
        let (a, b) = (&self.smooth[index.min(last)], &self.smooth[(index + 1).min(last)]);
        let terms = a.iter().zip(b).zip(&self.held[index.min(last)]);
        let terms = out.iter_mut().zip(terms);
        let Some(gains) = gains else {
            for (o, ((a, b), held)) in terms {
                *o += gain * (a * (1.0 - part) + b * part + held);
            }
            return;
        };
        for ((o, ((a, b), held)), own) in terms.zip(gains) {
            *o += gain * own * (a * (1.0 - part) + b * part + held);
        }
    }
}

/// How far a posture has drifted, as a function of time.
#[derive(Debug, Clone)]
pub struct DriftPath {
    /// n x r, rad.
    cosines: DMatrix<f64>,
    sines: DMatrix<f64>,
    /// r, rad/s.
    rates: Vec<f64>,
}

impl DriftPath {
    /// Angles since time 0, n, rad.
    pub fn at(&self, time_s: f64) -> DVector<f64> {
        let mut sum = DVector::zeros(self.cosines.nrows());
        wide(
            #[inline(always)]
            || {
                for (j, rate) in self.rates.iter().enumerate() {
                    let (sine, cosine) = sin_cos(rate * time_s);
                    let both = self.cosines.column(j).into_iter().zip(self.sines.column(j));
                    for (sum, (c, s)) in sum.iter_mut().zip(both) {
                        *sum = c.mul_add(cosine - 1.0, s.mul_add(sine, *sum));
                    }
                }
            },
        );
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::std_dev;
    use crate::math::stream::{Purpose, stream};

    #[test]
    fn spread_does_not_depend_on_the_step() {
        let parts = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.3, 0.5, 0.2)];
        for (white, correlated, lasting) in parts {
            let noise = Noise {
                factor: DMatrix::from_element(1, 1, 2.0),
                shares: NoiseShares { white, correlated, lasting },
                white_interval_s: 0.2,
                ..Noise::correlated(DMatrix::zeros(1, 1), 0.3)
            };
            for (dt, steps) in [(0.1, 10), (0.02, 50)] {
                let ends: Vec<f64> = (0..6000)
                    .map(|i| {
                        let mut rng = stream(1, Purpose::Posture, 0, i);
                        let path = noise.path(&mut rng, steps + 1, dt);
                        (0..steps).map(|k| path.at(k, 0.5)[0] * dt).sum()
                    })
                    .collect();
                // Displacement over 1 s.
                let (tau, t) = (0.3, 1.0);
                let ou = 2.0 * tau * (t - tau * (1.0 - f64::exp(-t / tau)));
                let exact = 2.0 * (white * 0.2 * t + correlated * ou + lasting * t * t).sqrt();
                let ratio = std_dev(&ends) / exact;
                assert!((ratio - 1.0).abs() < 0.04, "dt {dt}, {white} {correlated}: {ratio}");
            }
        }
    }

    #[test]
    fn smooth_parts_are_interpolated_and_white_ones_held() {
        let noise = Noise {
            shares: NoiseShares { white: 0.4, correlated: 0.6, lasting: 0.0 },
            ..Noise::correlated(DMatrix::identity(3, 3), 0.3)
        };
        let path = noise.path(&mut stream(1, Purpose::Posture, 0, 7), 5, 0.1);
        let expected = path.smooth[2].lerp(&path.smooth[3], 0.3) + &path.held[2];
        assert_eq!(path.at(2, 0.3), expected);
        let last = &path.smooth[4] + &path.held[4];
        assert!((path.at(9, 0.3) - last).norm() < 1e-12);
    }

    #[test]
    fn a_drift_has_its_speed_and_stays_near() {
        let drift = Drift { speed_rad_s: 0.03, time_s: 0.4 };
        let noise = Noise {
            clock: Clock::Hand { speed_m_s: 0.3, drift },
            ..Noise::correlated(DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 1.0])), 0.3)
        };
        let (mut speeds, mut far) = (Vec::new(), Vec::new());
        for r in 0..4000 {
            let path = noise.drift(&mut stream(1, Purpose::Posture, 0, r)).unwrap();
            assert_eq!(path.at(0.0).amax(), 0.0);
            speeds.push(((path.at(7.001) - path.at(7.0)) / 1e-3).norm_squared() / 2.0);
            far.push(path.at(500.0).norm_squared() / 2.0);
        }
        let rms = |v: &[f64]| crate::math::stats::mean(v).sqrt();
        assert!((rms(&speeds) / 0.03 - 1.0).abs() < 0.05, "{}", rms(&speeds));
        let extent = 0.03 * 0.4 * f64::sqrt(2.0);
        assert!((rms(&far) / extent - 1.0).abs() < 0.05, "{}", rms(&far));
        assert!(Noise::none(2).drift(&mut stream(1, Purpose::Posture, 0, 0)).is_none());
    }

    #[test]
    fn gain_is_one_at_rms_speed() {
        assert!((gain(0.7, 0.5, &[0.3, 0.4, 0.0]) - 1.0).abs() < 1e-12);
        assert!((gain(0.75, 0.5, &[0.0; 6]) - 0.5).abs() < 1e-12);
    }
}

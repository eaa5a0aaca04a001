//! Somebody who relaxes as time passes, moving or not: waiting changes the posture.
//!
//! ```text
//! dq = lambda dt (m(x) - q) + chance in time, as strong as the hand is fast
//! ```
//! What the first posture models took everybody for. Recorded people hold their posture while the hand
//! rests; this one tests a learner that counts on it.

use super::Frame;
use super::follow::{Law, Moment};
use super::places::Places;
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::Grips;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Rate of relaxing, 1/s, and how it differs between people (standard deviation of its logarithm).
const RATE_PER_S: f64 = 3.0;
const RATE_DIFFERS: f64 = 0.3;
/// Time over which chance forgets, s, and its size per metre of hand travel, in standard deviations of
/// the usual posture.
const FORGETS_S: f64 = 0.35;
const CHANCE_PER_M: f64 = 2.5;
const WHIM: f64 = 0.3;

/// A person.
#[derive(Debug, Clone)]
pub(super) struct Relaxer {
    places: Places,
    ease: DMatrix<f64>,
    spread: DMatrix<f64>,
    rate_per_s: f64,
}

impl Relaxer {
    /// `None` where the body reaches too little.
    pub(super) fn draw(frame: &Frame, number: u64) -> Option<Self> {
        let spread = frame.spread()?;
        let z = normals(&mut stream(number, Purpose::Simulation, 12, 0), 1)[0];
        Some(Self {
            places: Places::draw(frame, &frame.ease, &(&spread * WHIM), number)?,
            ease: frame.ease.clone(),
            spread,
            rate_per_s: RATE_PER_S * (RATE_DIFFERS * z).exp(),
        })
    }

    /// The law of one repetition.
    pub(super) fn repetition(&self, mut rng: ChaCha8Rng) -> impl Law + '_ {
        let state = DVector::from_vec(normals(&mut rng, self.spread.ncols()));
        Repetition { person: self, rng, state }
    }
}

struct Repetition<'a> {
    person: &'a Relaxer,
    rng: ChaCha8Rng,
    /// Ornstein-Uhlenbeck, unit variance.
    state: DVector<f64>,
}

impl Law for Repetition<'_> {
    fn begin_leg(&mut self, _travel_m: f64, span_s: f64) {
        let keep = (-span_s / FORGETS_S).exp();
        let z = DVector::from_vec(normals(&mut self.rng, self.state.len()));
        self.state = &self.state * keep + z * (1.0 - keep * keep).sqrt();
    }

    fn wish(&mut self, at: &Moment) -> DVector<f64> {
        let part = 1.0 - (-self.person.rate_per_s * at.span_s).exp();
        (self.person.places.at(&at.to) - at.q) * part
            + &self.person.spread * &self.state * (CHANCE_PER_M * at.travel_m)
    }

    fn ease(&self) -> &DMatrix<f64> {
        &self.person.ease
    }

    fn settled(&mut self, start: &DVector<f64>, _: &Grips) -> DVector<f64> {
        start.clone()
    }
}

//! Somebody with two habits and a memory: the posture depends on the way by which it was come to.
//!
//! A low hand is moved by one habit, a high one by the other, and between two heights the present habit
//! stays: going up and coming down the same path differ. The usual posture shifts with the direction of
//! travel, and is mixed with where the body has been of late. A repetition that starts between the two
//! heights keeps the habit of its neighbours.

use super::follow::{Law, Moment};
use super::places::Places;
use super::{Frame, middle};
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::Grips;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Middle of the two heights at which habits change, over stature above the pelvis, half of what lies
/// between them, and how the middle differs between people.
const CHANGE_AT: f64 = 0.08;
const HALF_GAP: f64 = 0.045;
const CHANGE_DIFFERS: f64 = 0.02;
/// Hand travel over which a habit gives way to the other, over which directions are felt, over which the
/// past is forgotten, and over which deviations are corrected, m.
const CHANGE_OVER_M: f64 = 0.15;
const DIRECTION_M: f64 = 0.10;
const PAST_M: f64 = 0.35;
const RETURN_M: f64 = 0.3;
/// Share of the past in what the person returns to, and size of the shift by direction, in standard
/// deviations of the usual posture.
const PAST_SHARE: f64 = 0.3;
const SHIFT: f64 = 0.3;
/// Whim of the grid points, deviation of a repetition and chance after a metre, likewise.
const WHIM: f64 = 0.4;
const REPETITION: f64 = 0.3;
const CHANCE_PER_ROOT_M: f64 = 0.15;

/// A person.
#[derive(Debug, Clone)]
pub(super) struct Habits {
    /// Low and high.
    places: [Places; 2],
    eases: [DMatrix<f64>; 2],
    /// n, rad: added going up, taken off coming down.
    shift: DVector<f64>,
    spread: DMatrix<f64>,
    stature_m: f64,
    change_at: f64,
}

impl Habits {
    /// From two people's usual postures; `None` where the body reaches too little.
    pub(super) fn draw(low: &Frame, high: &Frame, number: u64) -> Option<Self> {
        let spread = high.spread()?;
        let mut rng = stream(number, Purpose::Simulation, 11, 0);
        let shift = &spread * DVector::from_vec(normals(&mut rng, spread.ncols())) * SHIFT;
        let change_at = CHANGE_AT + CHANGE_DIFFERS * normals(&mut rng, 1)[0];
        let places = [
            Places::draw(low, &low.ease, &(low.spread()? * WHIM), 2 * number)?,
            Places::draw(high, &high.ease, &(&spread * WHIM), 2 * number + 1)?,
        ];
        let eases = [low.ease.clone(), high.ease.clone()];
        let stature_m = high.coupling.stature_m();
        Some(Self { places, eases, shift, spread, stature_m, change_at })
    }

    /// The law of one repetition; `keeps_high`: which habit its neighbours have between the heights.
    pub(super) fn repetition(&self, mut rng: ChaCha8Rng, keeps_high: bool) -> impl Law + '_ {
        let n = self.shift.len();
        let offset = &self.spread * DVector::from_vec(normals(&mut rng, n)) * REPETITION;
        let part = if keeps_high { 1.0 } else { 0.0 };
        let [chance, past] = [DVector::zeros(n), DVector::zeros(n)];
        let ease = self.eases[usize::from(keeps_high)].clone();
        let direction = 0.0;
        Repetition {
            person: self,
            rng,
            is_high: keeps_high,
            part,
            direction,
            past,
            offset,
            chance,
            ease,
        }
    }
}

struct Repetition<'a> {
    person: &'a Habits,
    rng: ChaCha8Rng,
    is_high: bool,
    /// 0: the low habit, 1: the high one.
    part: f64,
    /// -1 down to 1 up.
    direction: f64,
    past: DVector<f64>,
    offset: DVector<f64>,
    /// What chance adds on this leg, rad per metre of hand travel.
    chance: DVector<f64>,
    ease: DMatrix<f64>,
}

impl Repetition<'_> {
    fn usual(&self, hand: &Grips) -> DVector<f64> {
        let [low, high] = &self.person.places;
        low.at(hand) * (1.0 - self.part)
            + high.at(hand) * self.part
            + &self.person.shift * self.direction
            + &self.offset
    }

    /// Changes the habit beyond the heights.
    fn look(&mut self, hand: &Grips) {
        let up = middle(hand).y / self.person.stature_m - self.person.change_at;
        if up.abs() > HALF_GAP {
            self.is_high = up > 0.0;
        }
    }
}

impl Law for Repetition<'_> {
    fn begin_leg(&mut self, travel_m: f64, _span_s: f64) {
        let z = DVector::from_vec(normals(&mut self.rng, self.offset.len()));
        let rate = CHANCE_PER_ROOT_M / travel_m.sqrt().max(1e-6);
        self.chance = &self.person.spread * z * rate;
    }

    fn wish(&mut self, at: &Moment) -> DVector<f64> {
        let before = self.usual(&at.from);
        self.look(&at.to);
        let aim = if self.is_high { 1.0 } else { 0.0 };
        let most = at.travel_m / CHANGE_OVER_M;
        self.part += (aim - self.part).clamp(-most, most);
        if at.travel_m > 0.0 {
            let slope = (middle(&at.to).y - middle(&at.from).y) / at.travel_m;
            self.direction += (slope - self.direction) * (at.travel_m / DIRECTION_M).min(1.0);
        }
        let [low, high] = &self.person.eases;
        self.ease = low * (1.0 - self.part) + high * self.part;
        self.past += (at.q - &self.past) * (at.travel_m / PAST_M).min(1.0);
        let usual = self.usual(&at.to);
        let back = &usual * (1.0 - PAST_SHARE) + &self.past * PAST_SHARE - at.q;
        (usual - before) + back * (at.travel_m / RETURN_M) + &self.chance * at.travel_m
    }

    fn ease(&self) -> &DMatrix<f64> {
        &self.ease
    }

    fn settled(&mut self, start: &DVector<f64>, hand: &Grips) -> DVector<f64> {
        self.look(hand);
        self.part = if self.is_high { 1.0 } else { 0.0 };
        self.ease = self.person.eases[usize::from(self.is_high)].clone();
        let settled = (start + self.usual(hand)) * 0.5;
        self.past.clone_from(&settled);
        settled
    }
}

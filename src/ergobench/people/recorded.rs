//! Somebody whose movements have the statistics of recorded people.
//!
//! ```text
//! dq = dm(x) + (ds / ell) beyond(m(x) + b - q) + chance            ds: metres of hand travel
//! ```
//! The joints move in a few synergies of the arm, quickly and with the trunk almost still, as in the
//! two recorded hand-overs (participation rank of the joint velocities 3.0 and 3.2, 18 and 25 deg/s root
//! mean square). Outside the learner's class: usual postures on a grid with kinks, deviations within a
//! few degrees that nobody corrects, offsets of heavy-tailed size, and weights of few synergies.

use super::follow::{Law, Moment};
use super::places::Places;
use super::{Frame, parts};
use crate::human::PELVIS_JOINTS;
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::Grips;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Joints that move together, deg for a right hand: (joint without side, axis of Z, X, Y, amount).
const SYNERGIES: [&[(&str, usize, f64)]; 5] = [
    // Reaching out, turning the arm, opening it, and the little that the trunk adds.
    &[("Shoulder", 0, 26.0), ("Elbow", 0, -34.0), ("C7Shoulder", 2, 3.0), ("Wrist", 0, 8.0)],
    &[("Shoulder", 2, 30.0), ("Elbow", 2, -26.0), ("Wrist", 0, 14.0)],
    &[("Shoulder", 1, -18.0), ("Wrist", 1, 12.0), ("Elbow", 2, 12.0)],
    &[("L5S1", 0, -0.6), ("L4L3", 0, -0.4), ("L1T12", 0, -0.3), ("T9T8", 0, -0.3)],
    &[("L5S1", 2, 0.4), ("L4L3", 2, 0.3), ("L1T12", 2, 0.3), ("T9T8", 2, 0.3)],
];
/// The same of somebody who bends down and carries: squatting, stooping and turning, pelvis first; each
/// coordinate by name, displacements in leg lengths.
const WHOLE: [&[(&str, f64)]; 3] = [
    &[("pelvis_up", -0.09), ("pelvis_forward", -0.03), ("jPelvis_Z", -9.0), ("jL5S1_Z", -2.0)],
    &[
        ("jPelvis_Z", -15.0),
        ("pelvis_forward", -0.04),
        ("jL5S1_Z", -4.0),
        ("jL4L3_Z", -2.5),
        ("jL1T12_Z", -2.0),
        ("jT9T8_Z", -1.5),
    ],
    &[("jPelvis_Y", 5.0), ("pelvis_right", 0.02), ("jL5S1_Y", 3.0), ("jL1T12_Y", 2.0)],
];
/// How the size of these differs between people: who rather squats, and who stoops.
const WAY_DIFFERS: f64 = 0.4;
/// What every joint gives way beside them, deg; a pelvis that moves, leg lengths and deg.
const FLOOR_ARM_DEG: f64 = 4.0;
const FLOOR_TRUNK_DEG: f64 = 0.3;
const FLOOR_PELVIS: f64 = 0.004;
const FLOOR_PELVIS_DEG: f64 = 0.6;
/// How synergies differ between people: standard deviation of the logarithm of a whole one's size,
/// and of each joint's share relative to it.
const SIZE_DIFFERS: f64 = 0.2;
const SHARE_DIFFERS: f64 = 0.25;
/// Size of a grid point's whim, in standard deviations of the usual posture.
const WHIM: f64 = 0.2;
/// Hand travel over which half-way corrections are made, m, and deviations that are left alone, rad.
const RETURN_M: f64 = 0.5;
const SLACK_RAD: f64 = 0.04;
/// What is kept of the drawn start's deviation, and chance after a metre, in
/// standard deviations of the usual posture.
const KEPT: f64 = 0.5;
const CHANCE_PER_ROOT_M: f64 = 0.2;

/// A person.
#[derive(Debug, Clone)]
pub(super) struct Recorded {
    places: Places,
    ease: DMatrix<f64>,
    /// A root of the usual postures' covariance, n x n, rad.
    spread: DMatrix<f64>,
}

impl Recorded {
    /// `None` where the body reaches too little.
    pub(super) fn draw(frame: &Frame, number: u64) -> Option<Self> {
        let synergies = synergies(frame, number);
        let floor = frame.joints.iter().map(|j| {
            let is_arm = ["Shoulder", "Elbow", "Wrist"].contains(&parts(j).0);
            let floor = match PELVIS_JOINTS.iter().position(|p| p == j) {
                Some(p) if p < 3 => FLOOR_PELVIS,
                Some(_) => FLOOR_PELVIS_DEG.to_radians(),
                None => if is_arm { FLOOR_ARM_DEG } else { FLOOR_TRUNK_DEG }.to_radians(),
            };
            floor.powi(2)
        });
        let floor = DVector::from_iterator(frame.joints.len(), floor);
        let ease = &synergies * synergies.transpose() + DMatrix::from_diagonal(&floor);
        let spread = frame.spread()?;
        let places = Places::draw(frame, &ease, &(&spread * WHIM), number)?;
        Some(Self { places, ease, spread })
    }

    /// The law of one repetition.
    pub(super) fn repetition(&self, mut rng: ChaCha8Rng) -> impl Law + '_ {
        let z = normals(&mut rng, 4);
        // Student's t with three degrees of freedom.
        let tail = z[0].abs() / ((z[1] * z[1] + z[2] * z[2] + z[3] * z[3]) / 3.0).sqrt().max(0.2);
        let chance = DVector::zeros(self.ease.nrows());
        let (size, offset) = (0.5 + 0.5 * tail.min(4.0), chance.clone());
        Repetition { person: self, rng, size, offset, chance }
    }
}

/// n x r, rad and leg lengths. Two arms do as mirror images do.
fn synergies(frame: &Frame, number: u64) -> DMatrix<f64> {
    let mut rng = stream(number, Purpose::Simulation, 9, 0);
    let whole = if frame.contacts.is_whole() { &WHOLE[..] } else { &[] };
    let mut all = DMatrix::zeros(frame.joints.len(), SYNERGIES.len() + whole.len());
    for (k, synergy) in SYNERGIES.iter().enumerate() {
        let z = normals(&mut rng, synergy.len() + 1);
        for (i, (joint, axis, deg)) in synergy.iter().enumerate() {
            let share = 1.0 + SHARE_DIFFERS * z[i + 1];
            let rows = frame.joints.iter().enumerate();
            for (row, own) in rows.filter(|(_, j)| parts(j) == (joint, *axis)) {
                let mirror = if *axis > 0 { frame.outward_of(own) } else { 1.0 };
                all[(row, k)] = mirror * deg.to_radians() * share * (SIZE_DIFFERS * z[0]).exp();
            }
        }
    }
    for (k, way) in whole.iter().enumerate() {
        let z = normals(&mut rng, way.len() + 1);
        for (i, (joint, amount)) in way.iter().enumerate() {
            let size = (1.0 + SHARE_DIFFERS * z[i + 1]) * (WAY_DIFFERS * z[0]).exp();
            let is_place = PELVIS_JOINTS[..3].contains(joint);
            let amount = if is_place { *amount } else { amount.to_radians() };
            if let Some(row) = frame.joints.iter().position(|j| j == joint) {
                all[(row, SYNERGIES.len() + k)] = amount * size;
            }
        }
    }
    all
}

struct Repetition<'a> {
    person: &'a Recorded,
    rng: ChaCha8Rng,
    /// By how much more or less this repetition deviates than usual.
    size: f64,
    offset: DVector<f64>,
    /// What chance adds on this leg, rad per metre of hand travel.
    chance: DVector<f64>,
}

impl Law for Repetition<'_> {
    fn begin_leg(&mut self, travel_m: f64, _span_s: f64) {
        let z = DVector::from_vec(normals(&mut self.rng, self.person.spread.ncols()));
        let rate = self.size * CHANCE_PER_ROOT_M / travel_m.sqrt().max(1e-6);
        self.chance = &self.person.spread * z * rate;
    }

    fn wish(&mut self, at: &Moment) -> DVector<f64> {
        let (before, usual) = (self.person.places.at(&at.from), self.person.places.at(&at.to));
        let away = &usual + &self.offset - at.q;
        let beyond = away.map(|d| d - d.clamp(-SLACK_RAD, SLACK_RAD));
        (usual - before) + beyond * (at.travel_m / RETURN_M) + &self.chance * at.travel_m
    }

    fn ease(&self) -> &DMatrix<f64> {
        &self.person.ease
    }

    fn settled(&mut self, start: &DVector<f64>, hand: &Grips) -> DVector<f64> {
        let usual = self.person.places.at(hand);
        self.offset = (start - &usual) * (KEPT * self.size);
        usual + &self.offset
    }
}

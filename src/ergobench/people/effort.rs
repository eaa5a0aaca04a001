//! Somebody who spares themselves: at every step a little less effort, as far as the hand allows.
//!
//! ```text
//! E(q) = 1/2 sum ((q - c)/s)^2 + 1/2 a |M_shoulder / M_s|^2 + 1/2 b |M_back / M_b|^2
//! dq   = -(ds / ell) s^2 dE/dq + chance                          ds: metres of hand travel
//! ```
//! `c` is the comfortable posture, `s` how far a joint strays from it willingly, `M` the horizontal lever
//! arms of the segments' weights about shoulder and L5/S1; a, b, c, s are the person's own. There is no
//! usual posture for a place, so that nothing of the learner's pull is in it.

use super::Frame;
use super::follow::{Law, Moment};
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use nalgebra::{DMatrix, DVector, Matrix6xX};
use rand_chacha::ChaCha8Rng;

/// Weights relative to the body: upper arm, forearm with hand, trunk with head and the arm left out.
const UPPER_ARM: f64 = 0.028;
const FOREARM: f64 = 0.022;
const TRUNK: f64 = 0.50;
/// Lever arm over stature, times relative weight, at which a moment counts like a joint that strays by
/// its willing distance: an arm stretched out level, and a trunk bent by about 30 deg.
const SHOULDER_MOMENT: f64 = 0.007;
const BACK_MOMENT: f64 = 0.05;
/// Hand travel over which the effort falls to a third of what can be saved, m.
const SAVE_M: f64 = 0.15;
/// How people differ: standard deviation of the logarithm of weights and of willing distances.
const WEIGHT_DIFFERS: f64 = 0.5;
const STRAY_DIFFERS: f64 = 0.3;
/// How the comfortable posture differs between repetitions, and chance after a metre, in willing
/// distances.
const REPETITION: f64 = 0.35;
const CHANCE_PER_ROOT_M: f64 = 0.15;

/// A person.
#[derive(Debug, Clone)]
pub(super) struct Effort {
    chain: Linkage,
    stature_m: f64,
    comfort: DVector<f64>,
    /// s^2, n, rad^2.
    stray_squared: DVector<f64>,
    ease: DMatrix<f64>,
    shoulder: f64,
    back: f64,
}

/// Tips of the chain, in their order.
const SHOULDER: usize = 1;
const ELBOW: usize = 2;
const CHEST: usize = 3;
const HAND: usize = 0;

impl Effort {
    /// A person of a number.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub(super) fn draw(
        body: &Body,
        side: Side,
        frame: &Frame,
        number: u64,
    ) -> Result<Self, InputError> {
        let of = |link: &str| Tip::link(&format!("{}{link}", side.prefix()));
        let tips = [Tip::link(side.grip()), of("UpperArm"), of("ForeArm"), Tip::link("T8")];
        let chain = Linkage::new(&body.model, "Pelvis", &tips)
            .map_err(|e| InputError::new(&body.name, e.to_string()))?;
        let n = frame.joints.len();
        let mut rng = stream(number, Purpose::Simulation, 10, 0);
        let z = normals(&mut rng, n + 2);
        let stray_squared = DVector::from_fn(n, |i, _| {
            frame.usual.covariance[(i, i)] * (2.0 * STRAY_DIFFERS * z[i]).exp()
        });
        Ok(Self {
            chain,
            stature_m: body.size.stature_m,
            comfort: frame.usual.mean.clone(),
            ease: DMatrix::from_diagonal(&stray_squared),
            stray_squared,
            shoulder: (WEIGHT_DIFFERS * z[n]).exp() / SHOULDER_MOMENT.powi(2),
            back: (WEIGHT_DIFFERS * z[n + 1]).exp() / BACK_MOMENT.powi(2),
        })
    }

    /// The law of one repetition.
    pub(super) fn repetition(&self, mut rng: ChaCha8Rng) -> impl Law + '_ {
        let z = DVector::from_vec(normals(&mut rng, self.comfort.len()));
        let stray = self.stray_squared.map(f64::sqrt);
        let comfort = &self.comfort + stray.component_mul(&z) * REPETITION;
        let chance = DVector::zeros(comfort.len());
        Repetition { person: self, rng, stray, comfort, chance, frames: Frames::default() }
    }

    /// Gradient of the effort at `q`, for a comfortable posture, n, 1/rad.
    fn gradient(
        &self,
        q: &DVector<f64>,
        comfort: &DVector<f64>,
        frames: &mut Frames,
    ) -> DVector<f64> {
        self.chain.forward(q.as_slice(), frames);
        let at =
            |tip: usize| (self.chain.tip_frame(frames, tip).0, self.chain.jacobian(frames, tip));
        let ((hand, j_hand), (shoulder, j_shoulder)) = (at(HAND), at(SHOULDER));
        let ((elbow, j_elbow), (chest, j_chest)) = (at(ELBOW), at(CHEST));
        // Middles of upper arm and forearm; the trunk's weight at the chest.
        let upper = ((shoulder + elbow) * 0.5, (&j_shoulder + &j_elbow) * 0.5);
        let fore = ((elbow + hand) * 0.5, (&j_elbow + &j_hand) * 0.5);
        let arm =
            (upper.0 * UPPER_ARM + fore.0 * FOREARM, &upper.1 * UPPER_ARM + &fore.1 * FOREARM);
        let about_shoulder = (
            arm.0 - shoulder * (UPPER_ARM + FOREARM),
            &arm.1 - &j_shoulder * (UPPER_ARM + FOREARM),
        );
        let about_back = (arm.0 + chest * TRUNK, &arm.1 + &j_chest * TRUNK);
        let mut gradient = (q - comfort).component_div(&self.stray_squared);
        gradient += level(&about_shoulder) * (self.shoulder / self.stature_m.powi(2));
        gradient += level(&about_back) * (self.back / self.stature_m.powi(2));
        gradient
    }
}

/// Gradient of half the squared horizontal part of a moment (pelvis frame, y up), n.
fn level((moment, jacobian): &(Vec3, Matrix6xX<f64>)) -> DVector<f64> {
    (jacobian.row(0) * moment.x + jacobian.row(2) * moment.z).transpose()
}

struct Repetition<'a> {
    person: &'a Effort,
    rng: ChaCha8Rng,
    stray: DVector<f64>,
    comfort: DVector<f64>,
    /// What chance adds on this leg, rad per metre of hand travel.
    chance: DVector<f64>,
    frames: Frames,
}

impl Law for Repetition<'_> {
    fn begin_leg(&mut self, travel_m: f64, _span_s: f64) {
        let z = DVector::from_vec(normals(&mut self.rng, self.comfort.len()));
        let rate = CHANCE_PER_ROOT_M / travel_m.sqrt().max(1e-6);
        self.chance = self.stray.component_mul(&z) * rate;
    }

    fn wish(&mut self, at: &Moment) -> DVector<f64> {
        let gradient = self.person.gradient(at.q, &self.comfort, &mut self.frames);
        let saved = gradient.component_mul(&self.person.stray_squared);
        &self.chance * at.travel_m - saved * (at.travel_m / SAVE_M)
    }

    fn ease(&self) -> &DMatrix<f64> {
        &self.person.ease
    }

    fn settled(&mut self, start: &DVector<f64>, _hand: &Pose) -> DVector<f64> {
        // A few steps downhill from where they were drawn.
        let mut q = start.clone();
        for _ in 0..6 {
            let gradient = self.person.gradient(&q, &self.comfort, &mut self.frames);
            q -= gradient.component_mul(&self.person.stray_squared) * 0.2;
        }
        q
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_that_of_the_effort() {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let frame = Frame::draw(&body, Side::Right, 4).unwrap();
        let person = Effort::draw(&body, Side::Right, &frame, 4).unwrap();
        let mut frames = Frames::default();
        let mut effort = |q: &DVector<f64>| {
            person.chain.forward(q.as_slice(), &mut frames);
            let at = |tip: usize| person.chain.tip_frame(&frames, tip).0;
            let (u, f) = (at(SHOULDER) + at(ELBOW), at(ELBOW) + at(HAND));
            let arm = u * (0.5 * UPPER_ARM) + f * (0.5 * FOREARM);
            let shoulder = arm - at(SHOULDER) * (UPPER_ARM + FOREARM);
            let back = arm + at(CHEST) * TRUNK;
            let squared = |m: Vec3| (m.x * m.x + m.z * m.z) / person.stature_m.powi(2);
            let strayed = (q - &person.comfort).component_div(&person.stray_squared.map(f64::sqrt));
            0.5 * (strayed.norm_squared()
                + person.shoulder * squared(shoulder)
                + person.back * squared(back))
        };
        let q =
            &person.comfort + DVector::from_fn(24, |i, _| 0.02 * f64::from(i as u32 % 7) - 0.05);
        let gradient = person.gradient(&q, &person.comfort, &mut Frames::default());
        for i in 0..24 {
            let moved = |h: f64| {
                let mut near = q.clone();
                near[i] += h;
                near
            };
            let slope = (effort(&moved(1e-5)) - effort(&moved(-1e-5))) / 2e-5;
            assert!((slope - gradient[i]).abs() < 1e-5 * (1.0 + slope.abs()), "{i}: {slope}");
        }
    }
}

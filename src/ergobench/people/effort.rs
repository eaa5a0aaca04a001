//! Somebody who spares themselves: at every step a little less effort, as far as the hands allow.
//!
//! ```text
//! E(q) = 1/2 sum ((q - c)/s)^2 + 1/2 a |M_shoulder / M_s|^2 + 1/2 b |M_back / M_b|^2
//!        + 1/2 e sin^2(k/2) / sin^2(30 deg)            legs that bend: sin^2(k/2) = 2 d - d^2
//! dq   = -(ds / ell) s^2 dE/dq + chance                          ds: metres of hand travel
//! ```
//! `c` is the comfortable posture, `s` how far a joint strays from it willingly, `M` the horizontal lever
//! arms of the segments' weights, and of a load in the hands, about each shoulder and about the pelvis;
//! `k` the flexion of the knees of somebody whose hips are `d` leg lengths lower than upright. a, b, c, e,
//! s are the person's own: one stoops, another squats. There is no usual posture for a place, so that
//! nothing of the learner's pull is in it.

use super::Frame;
use super::follow::{Law, Moment};
use crate::files::InputError;
use crate::human::{Body, PELVIS_JOINTS, Pelvis};
use crate::kinematics::{Frames, Linkage};
use crate::math::Vec3;
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::Grips;
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
/// Squared sine of half the flexion of knees that counts like one, too: bent by 60 deg.
const KNEES_BENT: f64 = 0.25;
/// Where among the joints the height of the hips is, of somebody whose pelvis moves.
const UP: usize = 1;
/// How far a pelvis that moves strays willingly: forward, up, right (leg lengths), then its turns, deg.
const PELVIS_STRAYS: [f64; 6] = [0.04, 0.08, 0.03, 14.0, 4.0, 6.0];
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
    /// Arms that hold on; in the chain's tips come their hands, then shoulder and elbow of each, the
    /// chest, and the pelvis where it moves.
    arms: usize,
    is_whole: bool,
    /// What each hand carries, over the body's weight.
    load: f64,
    shoulder: f64,
    back: f64,
    knees: f64,
}

/// A point and its Jacobian, 6 x n, weighted alike.
type Point = (Vec3, Matrix6xX<f64>);

impl Effort {
    /// A person of a number.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub(super) fn draw(body: &Body, frame: &Frame, number: u64) -> Result<Self, InputError> {
        let coupled = frame.contacts.coupled;
        let sides = coupled.hands.sides();
        let is_whole = coupled.pelvis == Pelvis::Moves;
        let mut links = Vec::new();
        for side in sides {
            links.extend(["UpperArm", "ForeArm"].map(|link| format!("{}{link}", side.prefix())));
        }
        links.push("T8".to_owned());
        if is_whole {
            links.push("Pelvis".to_owned());
        }
        let chain = body.chain(coupled, &links.iter().map(String::as_str).collect::<Vec<_>>())?;
        let n = frame.joints.len();
        let mut rng = stream(number, Purpose::Simulation, 10, 0);
        let z = normals(&mut rng, n + 3);
        let variance = |i: usize| match PELVIS_JOINTS.iter().position(|p| *p == frame.joints[i]) {
            Some(p) if p < 3 => PELVIS_STRAYS[p].powi(2),
            Some(p) => PELVIS_STRAYS[p].to_radians().powi(2),
            None => frame.usual.covariance[(i, i)],
        };
        let stray_squared =
            DVector::from_fn(n, |i, _| variance(i) * (2.0 * STRAY_DIFFERS * z[i]).exp());
        Ok(Self {
            chain,
            stature_m: body.size.stature_m,
            comfort: frame.usual.mean.clone(),
            ease: DMatrix::from_diagonal(&stray_squared),
            stray_squared,
            arms: sides.len(),
            is_whole,
            load: frame.contacts.load_kg / body.size.mass_kg / sides.len() as f64,
            shoulder: (WEIGHT_DIFFERS * z[n]).exp() / SHOULDER_MOMENT.powi(2),
            back: (WEIGHT_DIFFERS * z[n + 1]).exp() / BACK_MOMENT.powi(2),
            knees: (WEIGHT_DIFFERS * z[n + 2]).exp() / KNEES_BENT,
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
        let mut gradient = (q - comfort).component_div(&self.stray_squared);
        let mut about_back: Option<Point> = None;
        for hand in 0..self.arms {
            let [shoulder, elbow] = self.arm(hand);
            let (arm, about_shoulder) = self.moments([at(hand), at(shoulder), at(elbow)]);
            gradient += level(&about_shoulder) * (self.shoulder / self.stature_m.powi(2));
            about_back = Some(match about_back {
                None => arm,
                Some(other) => (other.0 + arm.0, other.1 + arm.1),
            });
        }
        if let Some(arms) = about_back {
            let (chest, j_chest) = at(self.chest());
            let trunk = self.trunk();
            let mut about_back = (arms.0 + chest * trunk, &arms.1 + &j_chest * trunk);
            if self.is_whole {
                let (pelvis, j_pelvis) = at(self.chest() + 1);
                let all = trunk + self.arms as f64 * self.arm_weight();
                about_back = (about_back.0 - pelvis * all, about_back.1 - j_pelvis * all);
            }
            gradient += level(&about_back) * (self.back / self.stature_m.powi(2));
        }
        if self.is_whole {
            gradient[UP] -= self.knees * (1.0 - lower(q)) * f64::from(u8::from(lower(q) > 0.0));
        }
        gradient
    }

    /// Tips of the shoulder and the elbow of the arm of a hand.
    fn arm(&self, hand: usize) -> [usize; 2] {
        let shoulder = self.arms + 2 * hand;
        [shoulder, shoulder + 1]
    }

    fn chest(&self) -> usize {
        3 * self.arms
    }

    /// Weight of the trunk with what hangs on it, over the body's.
    fn trunk(&self) -> f64 {
        TRUNK - (self.arms - 1) as f64 * (UPPER_ARM + FOREARM)
    }

    /// The same of an arm with what its hand carries.
    fn arm_weight(&self) -> f64 {
        UPPER_ARM + FOREARM + self.load
    }

    /// Moments of an arm's weights about the origin and about its shoulder, from hand, shoulder and elbow.
    fn moments(
        &self,
        [(hand, j_hand), (shoulder, j_shoulder), (elbow, j_elbow)]: [Point; 3],
    ) -> (Point, Point) {
        // Middles of upper arm and forearm.
        let upper = ((shoulder + elbow) * 0.5, (&j_shoulder + &j_elbow) * 0.5);
        let fore = ((elbow + hand) * 0.5, (&j_elbow + &j_hand) * 0.5);
        let mut arm =
            (upper.0 * UPPER_ARM + fore.0 * FOREARM, &upper.1 * UPPER_ARM + &fore.1 * FOREARM);
        if self.load > 0.0 {
            arm = (arm.0 + hand * self.load, arm.1 + j_hand * self.load);
        }
        let weight = self.arm_weight();
        let about_shoulder = (arm.0 - shoulder * weight, &arm.1 - &j_shoulder * weight);
        (arm, about_shoulder)
    }
}

/// How much lower than upright the hips are, leg lengths.
fn lower(q: &DVector<f64>) -> f64 {
    (-q[UP]).clamp(0.0, 1.0)
}

/// Gradient of half the squared horizontal part of a moment (rest frame, y up), n.
fn level((moment, jacobian): &Point) -> DVector<f64> {
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

    fn settled(&mut self, start: &DVector<f64>, _: &Grips) -> DVector<f64> {
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
    use super::super::Contacts;
    use super::*;
    use crate::human::{Hands, Side};

    /// The effort written down from points alone.
    fn effort(person: &Effort, q: &DVector<f64>) -> f64 {
        let mut frames = Frames::default();
        person.chain.forward(q.as_slice(), &mut frames);
        let at = |tip: usize| person.chain.tip_frame(&frames, tip).0;
        let squared = |m: Vec3| (m.x * m.x + m.z * m.z) / person.stature_m.powi(2);
        let strayed = (q - &person.comfort).component_div(&person.stray_squared.map(f64::sqrt));
        let mut sum = 0.5 * strayed.norm_squared();
        let hips = if person.is_whole { at(person.chest() + 1) } else { Vec3::zeros() };
        let mut back = (at(person.chest()) - hips) * person.trunk();
        for hand in 0..person.arms {
            let [shoulder, elbow] = person.arm(hand).map(at);
            let arm = |from: Vec3| {
                (shoulder + elbow - from * 2.0) * (0.5 * UPPER_ARM)
                    + (elbow + at(hand) - from * 2.0) * (0.5 * FOREARM)
                    + (at(hand) - from) * person.load
            };
            sum += 0.5 * person.shoulder * squared(arm(shoulder));
            back += arm(hips);
        }
        let knees = if person.is_whole { lower(q) * (2.0 - lower(q)) } else { 0.0 };
        sum + 0.5 * person.back * squared(back) + 0.5 * person.knees * knees
    }

    #[test]
    fn the_gradient_is_that_of_the_effort() {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        for contacts in [
            Contacts::arm(Side::Right),
            Contacts::whole(Hands::Right, 1.0),
            Contacts::whole(Hands::Both, 3.0),
        ] {
            let frame = Frame::draw(&body, contacts, 4).unwrap();
            let person = Effort::draw(&body, &frame, 4).unwrap();
            let n = frame.joints.len();
            let strayed = DVector::from_fn(n, |i, _| 0.02 * f64::from(i as u32 % 7) - 0.05);
            let mut q = &person.comfort + strayed;
            if person.is_whole {
                q[UP] = -0.2;
            }
            let gradient = person.gradient(&q, &person.comfort, &mut Frames::default());
            for i in 0..n {
                let moved = |h: f64| {
                    let mut near = q.clone();
                    near[i] += h;
                    effort(&person, &near)
                };
                let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let error = (slope - gradient[i]).abs();
                assert!(error < 1e-5 * (1.0 + slope.abs()), "{i} of {n}: {slope}");
            }
        }
    }
}

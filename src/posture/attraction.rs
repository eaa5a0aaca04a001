//! The pull towards the person's own postures: where the hand is, which posture is usual there?
//!
//! ```text
//! m(x) = mu + k(x, X) (K + s I)^-1 (Q - mu)
//! c(x) = k(x, X) (K + s I)^-1 k(X, x)   (share of the prior variance that the data explain)
//! ```
//! `x` is the hand pose relative to the pelvis, `Q` the training postures, `k` a squared exponential
//! on standardised features. Of several people `mu` is a trend (universal kriging): linear in the place of the
//! hand, with another slope below the hips, so that somebody at a bench does not stoop because most recorded
//! postures are those of people who reach down; and the variance about `m` grows with what is not known,
//!
//! ```text
//! mu(x) = B' f(x)       f = (1, x, low, low x ahead, low x right)      B by generalised least squares
//! g(x)  = (1 + o + s - c(x)) / (o + s)       o: what people and movements have of their own, over the signal
//! ```
//! Far from the training data `c` goes to 0 and the pull fades: t = c^2. Over
//! a step in which the hand goes from x to x+ by ds metres, in h seconds, it moves the posture by
//!
//! ```text
//! per metre    t (m(x+) - m(x)) + (1 - exp(-t ds / ell)) (m(x) - q)      a resting hand is left alone
//! per second   (1 - exp(-t lambda h)) (m(x) - q)
//! ```
//! exactly, whatever the size of the step.

use super::lowness::Lowness;
use super::noise::speed_squared;
use crate::math::dense::{Factor, transposed_product};
use crate::math::pose::rotation_between;
use crate::math::simd::{exp, wide};
use crate::math::{Pose, Vec3};
use crate::physical::{OVER_STATURE, POSITIVE, Range, STATURE_M, shown};
use nalgebra::{DMatrix, DVector, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Length by which a rotation of the hand counts like a displacement, m/rad.
const ROTATION_LENGTH_M: f64 = 0.3;
/// Spread of the hand's orientation below which it counts as one, rad.
const ONE_ORIENTATION_RAD: f64 = 0.25;
/// Every so many of the places of a path it is looked up how well the posture is known there.
const ALONG: usize = 4;
/// Length-scale of neighbouring places over that of the regression.
const NEAR: f64 = 0.3;
/// What a standardised feature of a hand that somebody held somewhere can be.
const STANDARDISED: Range = Range { low: -1e3, high: 1e3, unit: "" };
/// Smallest spread of a feature (m): directions in which the hand hardly moved are not blown up.
const SMALLEST_SPREAD_M: f64 = 0.02;

/// Variance of what one person has of their own, and of what one movement has, over that of what all share.
/// Assumed: values that served five recorded people in a prototype; others were not tried here.
const PERSON: f64 = 0.2;
const MOVEMENT: f64 = 0.5;

/// Fewest movements that a trend is learned from, three for each of its coefficients: fewer tell one person's
/// habits, and what people do elsewhere is the mean of all postures.
const LEAST_TREND_MOVEMENTS: usize = 21;

/// Variance of the coefficients of a trend is not bounded; this, over their mean precision, keeps those that the
/// data do not tell at zero.
const TREND_RIDGE: f64 = 1e-6;

/// Features of a hand pose: position over stature and rotation from a reference, standardised.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HandFeatures {
    reference: UnitQuaternion<f64>,
    stature_m: f64,
    mean: Vec<f64>,
    spread: Vec<f64>,
}

impl HandFeatures {
    /// Fits centre and spread to training poses of a person of `stature_m`.
    pub fn fit(poses: &[Pose], stature_m: f64) -> Self {
        // The chordal mean orientation: the dominant eigenvector of the sum of outer products.
        let outer = poses.iter().fold(nalgebra::Matrix4::zeros(), |sum, p| {
            let c = p.rotation.coords;
            sum + c * c.transpose()
        });
        let eigen = outer.symmetric_eigen();
        let top = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
        let reference = UnitQuaternion::new_normalize(nalgebra::Quaternion::from(top));
        let mut features = Self { reference, stature_m, mean: vec![0.0; 6], spread: vec![1.0; 6] };
        let raw: Vec<[f64; 6]> = poses.iter().map(|p| features.of(p, stature_m)).collect();
        for i in 0..6 {
            let column: Vec<f64> = raw.iter().map(|r| r[i]).collect();
            features.mean[i] = crate::math::stats::mean(&column);
            let spread = crate::math::stats::std_dev(&column);
            features.spread[i] = spread.max(SMALLEST_SPREAD_M / stature_m);
        }
        features
    }

    /// Places alone, and one length (of a stature) as the unit in all directions: how people of several
    /// recordings turn their hands is told in as many conventions.
    pub fn of_places(poses: &[Pose], stature_m: f64, unit: f64) -> Self {
        /// So much larger is what does not count.
        const AWAY: f64 = 1e6;
        let mut features = Self::fit(poses, stature_m);
        features.spread = [[unit; 3], [AWAY; 3]].concat();
        features
    }

    /// Features of a hand pose (pelvis frame) of a body of `stature_m`.
    pub fn of(&self, hand: &Pose, stature_m: f64) -> [f64; 6] {
        let p: Vec3 = hand.translation.vector / stature_m;
        let turn = rotation_between(&self.reference, &hand.rotation);
        let r = turn * (ROTATION_LENGTH_M / self.stature_m);
        let raw = [p.x, p.y, p.z, r.x, r.y, r.z];
        std::array::from_fn(|i| (raw[i] - self.mean[i]) / self.spread[i])
    }
}

/// How strong the pull is, and what it goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "per", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Pull {
    /// By the hand's travel (rotations counted at 0.3 m/rad), along the usual postures.
    Metre {
        /// ell: travel after which 1/e of a departure is left, m.
        length_m: f64,
    },
    /// By time.
    Second {
        /// lambda, 1/s.
        rate_per_s: f64,
    },
}

/// Kernel regression of the posture on the hand pose, and the pull.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Attraction {
    pull: Pull,
    length_scale: f64,
    noise: f64,
    features: HandFeatures,
    inputs: Vec<[f64; 6]>,
    origins: Vec<Origin>,
    postures: DMatrix<f64>,
    mean: Mean,
    coefficients: DMatrix<f64>,
    factor: Option<Factor>,
    /// Whose postures are asked for; none for somebody else than those it was learned from.
    person: Option<usize>,
}

/// mu: what is expected where nobody was recorded.
#[derive(Debug, Clone)]
enum Mean {
    /// The mean posture, n, rad.
    Constant(DVector<f64>),
    /// By the place of the hand.
    Trend(Trend),
}

/// Linear in the place of the hand, and in another way below the hips.
#[derive(Debug, Clone)]
struct Trend {
    bend: Bend,
    /// The places in which it was learned, standardised: beyond them it stays as at their edge.
    range: [(f64, f64); 3],
    /// B, 7 x n, rad.
    slopes: DMatrix<f64>,
}

/// From which height (over stature, rest frame) on a hand is low, and over what distance the slope counts as one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bend {
    from: f64,
    per: f64,
}

impl Trend {
    /// By generalised least squares over postures (N x n) whose kernel has this factor.
    fn fit(
        bend: Bend,
        (features, inputs): (&HandFeatures, &[[f64; 6]]),
        factor: &Factor,
        postures: &DMatrix<f64>,
    ) -> Option<Self> {
        let range = std::array::from_fn(|i| {
            let places = inputs.iter().map(|x| x[i]);
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        });
        let mut trend = Self { bend, range, slopes: DMatrix::zeros(7, postures.ncols()) };
        let basis = trend.basis(features, inputs);
        let white = factor.solve_lower(&basis);
        let mut precision = white.tr_mul(&white);
        let ridge = TREND_RIDGE * precision.trace() / 7.0;
        precision += DMatrix::identity(7, 7) * ridge;
        let wanted = white.tr_mul(&factor.solve_lower(postures));
        trend.slopes = precision.cholesky()?.solve(&wanted);
        Some(trend)
    }

    /// f of places, N x 7.
    fn basis(&self, features: &HandFeatures, inputs: &[[f64; 6]]) -> DMatrix<f64> {
        let rows = inputs.iter().map(|x| {
            let [ahead, up, right] =
                std::array::from_fn(|i| x[i].clamp(self.range[i].0, self.range[i].1));
            let height = up * features.spread[1] + features.mean[1];
            let low = ((self.bend.from - height) / self.bend.per).max(0.0);
            nalgebra::RowDVector::from_row_slice(&[
                1.0,
                ahead,
                up,
                right,
                low,
                low * ahead,
                low * right,
            ])
        });
        DMatrix::from_rows(&rows.collect::<Vec<_>>())
    }
}

impl Mean {
    fn bend(&self) -> Option<Bend> {
        match self {
            Self::Constant(_) => None,
            Self::Trend(trend) => Some(trend.bend),
        }
    }

    /// At places, N x n, rad.
    fn at(&self, features: &HandFeatures, inputs: &[[f64; 6]]) -> DMatrix<f64> {
        match self {
            Self::Constant(mean) => {
                DMatrix::from_fn(inputs.len(), mean.len(), |_, joint| mean[joint])
            }
            Self::Trend(trend) => trend.basis(features, inputs) * &trend.slopes,
        }
    }
}

/// Whose a training posture is, and of which of their movements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Person.
    pub person: usize,
    /// Movement.
    pub movement: usize,
}

/// What the model file holds; the rest is recomputed.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    pull: Pull,
    length_scale: f64,
    noise_variance: f64,
    features: HandFeatures,
    inputs: Vec<[f64; 6]>,
    /// Of each posture; empty of one person, whose movements are taken together.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    origins: Vec<Origin>,
    /// Which of the people is the worker; none where that is somebody else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    person: Option<usize>,
    /// Where the trend of several people bends; none where the mean posture is expected elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bend: Option<Bend>,
    postures_rad: DMatrix<f64>,
}

impl TryFrom<Stored> for Attraction {
    type Error = String;
    fn try_from(s: Stored) -> Result<Self, String> {
        s.prove().map_err(|e| format!("attraction: {e}"))?;
        let of_all = Self::assemble(
            s.pull,
            s.length_scale,
            s.noise_variance,
            (s.features, s.bend),
            (s.inputs, s.origins),
            s.postures_rad,
        );
        if of_all.factor.is_none() {
            return Err("attraction: its kernel is not positive definite".to_owned());
        }
        Ok(Self { person: s.person, ..of_all })
    }
}

impl Stored {
    /// Whether it can be taken apart: sizes agree, and every number is one that it can be.
    fn prove(&self) -> Result<(), String> {
        let count = self.inputs.len();
        let same = |what: &str, found: usize, wanted: usize| {
            if found == wanted {
                return Ok(());
            }
            Err(format!("{what} has {found} values, not {wanted}"))
        };
        if count == 0 {
            return Err("has no inputs".to_owned());
        }
        same("postures_rad", self.postures_rad.nrows(), count)?;
        let entries = self.postures_rad.nrows().checked_mul(self.postures_rad.ncols());
        same("postures_rad", self.postures_rad.len(), entries.unwrap_or_default())?;
        if !self.origins.is_empty() {
            same("origins", self.origins.len(), count)?;
        }
        let f = &self.features;
        same("features.mean", f.mean.len(), 6)?;
        same("features.spread", f.spread.len(), 6)?;
        let checks: [(&str, Range, Vec<f64>); 8] = [
            ("length_scale", POSITIVE, vec![self.length_scale]),
            ("noise_variance", POSITIVE, vec![self.noise_variance]),
            ("features.stature_m", STATURE_M, vec![f.stature_m]),
            ("features.mean", STANDARDISED, f.mean.clone()),
            ("features.spread", POSITIVE, f.spread.clone()),
            ("inputs", STANDARDISED, self.inputs.iter().flatten().copied().collect()),
            ("bend.from", OVER_STATURE, self.bend.iter().map(|b| b.from).collect()),
            ("bend.per", POSITIVE, self.bend.iter().map(|b| b.per).collect()),
        ];
        for (what, range, values) in checks {
            if let Some(value) = range.outside(values) {
                return Err(format!("{what}: {} is outside {range}", shown(value)));
            }
        }
        if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&f.reference.norm()) {
            return Err("features.reference is no unit quaternion".to_owned());
        }
        let is_own = |p: usize| self.origins.iter().any(|o| o.person == p);
        match self.person {
            Some(person) if !is_own(person) => {
                Err(format!("person {person} has no postures among them"))
            }
            _ => Ok(()),
        }
    }
}

impl From<Attraction> for Stored {
    fn from(a: Attraction) -> Self {
        Self {
            pull: a.pull,
            length_scale: a.length_scale,
            noise_variance: a.noise,
            features: a.features,
            inputs: a.inputs,
            origins: a.origins,
            person: a.person,
            bend: a.mean.bend(),
            postures_rad: a.postures,
        }
    }
}

/// The usual posture at a hand pose, and how far the data support it.
#[derive(Debug, Clone, PartialEq)]
pub struct UsualPosture {
    /// m(x), n, rad.
    pub posture: DVector<f64>,
    /// c(x) in [0, 1].
    pub confidence: f64,
    /// g(x): by how much the variance about it exceeds that at a place of which everything is known; none where
    /// the postures of all places are what is left to expect.
    pub growth: Option<f64>,
}

impl UsualPosture {
    /// The part of the full rate at which to pull there. The square, because the regression is already
    /// wrong by several degrees where its confidence is one half: on the hand-over's taker (last 30 %
    /// of the time, the hand 0.08 to 0.13 m from any training hand) the path error with the pull is
    /// 3.4 deg with c, 3.1 with c^2 and 2.0 with c^4; inside the training region c is the best and c^4
    /// the worst by 0.1 deg.
    pub fn trust(&self) -> f64 {
        self.confidence * self.confidence
    }
}

impl Attraction {
    /// Fits the regression. `hands` are poses in the pelvis frame, `postures` N x n (rad);
    /// `length_scale` in standard deviations of the features, `noise` relative to the signal's variance.
    ///
    /// # Panics
    /// When hands and postures differ in number.
    pub fn fit(
        hands: &[Pose],
        postures: DMatrix<f64>,
        stature_m: f64,
        pull: Pull,
        length_scale: f64,
        noise: f64,
    ) -> Self {
        assert_eq!(hands.len(), postures.nrows(), "one hand pose for each posture");
        let features = HandFeatures::fit(hands, stature_m);
        let inputs = hands.iter().map(|h| features.of(h, stature_m)).collect();
        Self::assemble(pull, length_scale, noise, (features, None), (inputs, Vec::new()), postures)
    }

    /// The same of several people, by the hand's place alone: what one person, or one movement, has of its
    /// own is common to all of its postures, and none of it is expected of somebody else. `unit` is the
    /// length-scale over the stature; the trend bends where hands begin to be low, and is the mean posture where
    /// that is not known.
    ///
    /// # Panics
    /// When hands, postures and origins differ in number.
    pub fn of_people(
        hands: &[Pose],
        postures: DMatrix<f64>,
        origins: Vec<Origin>,
        stature_m: f64,
        (pull, unit, noise): (Pull, f64, f64),
        lowness: Option<Lowness>,
    ) -> Self {
        assert_eq!(hands.len(), postures.nrows(), "one hand pose for each posture");
        assert_eq!(hands.len(), origins.len(), "one origin for each posture");
        let features = HandFeatures::of_places(hands, stature_m, unit);
        let inputs = hands.iter().map(|h| features.of(h, stature_m)).collect();
        let bend = lowness.map(|Lowness { from, to, .. }| Bend { from, per: from - to });
        Self::assemble(pull, 1.0, noise, (features, bend), (inputs, origins), postures)
    }

    fn assemble(
        pull: Pull,
        length_scale: f64,
        noise: f64,
        (features, bend): (HandFeatures, Option<Bend>),
        (inputs, origins): (Vec<[f64; 6]>, Vec<Origin>),
        postures: DMatrix<f64>,
    ) -> Self {
        let count = inputs.len();
        let own = |i: usize, j: usize| match (origins.get(i), origins.get(j)) {
            (Some(a), Some(b)) if a.person == b.person => {
                PERSON + if a.movement == b.movement { MOVEMENT } else { 0.0 }
            }
            _ => 0.0,
        };
        let kernel = DMatrix::from_fn(count, count, |i, j| {
            let k = squared_exponential(&inputs[i], &inputs[j], length_scale) * (1.0 + own(i, j));
            if i == j { k + noise } else { k }
        });
        let factor = Factor::new(&kernel);
        let movements: BTreeSet<usize> = origins.iter().map(|o| o.movement).collect();
        let trend = bend
            .filter(|_| movements.len() >= LEAST_TREND_MOVEMENTS)
            .zip(factor.as_ref())
            .and_then(|(bend, factor)| Trend::fit(bend, (&features, &inputs), factor, &postures));
        let mean =
            trend.map_or_else(|| Mean::Constant(postures.row_mean().transpose()), Mean::Trend);
        let centred = &postures - mean.at(&features, &inputs);
        let coefficients = factor
            .as_ref()
            .map_or_else(|| DMatrix::zeros(count, postures.ncols()), |f| f.solve(&centred));
        Self {
            pull,
            length_scale,
            noise,
            features,
            inputs,
            origins,
            postures,
            mean,
            coefficients,
            factor,
            person: None,
        }
    }

    /// The usual postures of one more person: those of all, as far as this person's own (M x n, rad, with their
    /// hands in a body of `stature_m` and the movement of each) do not say otherwise. None of a regression over
    /// the postures of one person.
    pub fn of_one_more(
        &self,
        hands: &[Pose],
        postures: &DMatrix<f64>,
        movements: &[usize],
        stature_m: f64,
    ) -> Option<Self> {
        let person = 1 + self.origins.iter().map(|o| o.person).max()?;
        let Self { pull, length_scale, noise, features, mut inputs, mut origins, .. } =
            self.clone();
        let before = 1 + origins.iter().map(|o| o.movement).max()?;
        inputs.extend(hands.iter().map(|h| features.of(h, stature_m)));
        origins.extend(movements.iter().map(|m| Origin { person, movement: before + m }));
        let rows: Vec<_> = self.postures.row_iter().chain(postures.row_iter()).collect();
        let all = DMatrix::from_rows(&rows);
        let features = (features, self.mean.bend());
        let own = Self::assemble(pull, length_scale, noise, features, (inputs, origins), all);
        Some(Self { person: Some(person), ..own })
    }

    /// The same regression on other postures, made from its own row by row: N x n, rad.
    #[must_use]
    pub fn regressed(&self, change: impl FnOnce(&DMatrix<f64>) -> DMatrix<f64>) -> Self {
        let Self { pull, length_scale, noise, features, inputs, origins, postures, person, .. } =
            self.clone();
        let (features, places) = ((features, self.mean.bend()), (inputs, origins));
        let all = Self::assemble(pull, length_scale, noise, features, places, change(&postures));
        Self { person, ..all }
    }

    /// What the pull goes by.
    pub fn pull(&self) -> Pull {
        self.pull
    }

    /// Number of joints, n.
    pub(super) fn dof(&self) -> usize {
        self.postures.ncols()
    }

    /// The training postures, N x n, rad.
    pub(super) fn postures(&self) -> &DMatrix<f64> {
        &self.postures
    }

    /// Adds to `out` (n, rad) what the pull does to a posture `q` while the hand goes from where `a` is
    /// usual to where `b` is: by `travel_m` in `time_s`. What is usual of this person differs by `own_a` and
    /// `own_b` (n, rad).
    pub(super) fn add_pull(
        &self,
        out: &mut DVector<f64>,
        (a, b): (&UsualPosture, &UsualPosture),
        (q, own_a, own_b): (&DVector<f64>, Option<&DVector<f64>>, Option<&DVector<f64>>),
        (travel_m, time_s): (f64, f64),
    ) {
        let trust = 0.5 * (a.trust() + b.trust());
        let (along, gone) = match self.pull {
            Pull::Metre { length_m } => (trust, travel_m / length_m),
            Pull::Second { rate_per_s } => (0.0, rate_per_s * time_s),
        };
        let back = -(-trust * gone).exp_m1();
        let usual = a.posture.iter().zip(&b.posture);
        for ((o, (a, b)), q) in out.iter_mut().zip(usual).zip(q) {
            *o += along * (b - a) + back * (a - q);
        }
        if let (Some(a), Some(b)) = (own_a, own_b) {
            for (o, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
                *o += along * (b - a) + back * a;
            }
        }
    }

    /// The velocity of the pull, n, rad/s, at a posture `q` while the hand (pelvis frame, of a body of
    /// `stature_m`) moves with `twist` (m/s, rad/s; linear first, base axes).
    pub fn pull_velocity(
        &self,
        hand: &Pose,
        twist: &[f64],
        q: &DVector<f64>,
        stature_m: f64,
    ) -> DVector<f64> {
        /// Short enough for a difference quotient, s.
        const MOMENT_S: f64 = 1e-5;
        let rows = |from: usize| {
            Vec3::from_fn(|i, _| twist.get(from + i).copied().unwrap_or(0.0) * MOMENT_S)
        };
        let turned = UnitQuaternion::from_scaled_axis(rows(3)) * hand.rotation;
        let next = Pose::from_parts((hand.translation.vector + rows(0)).into(), turned);
        let usual = self.usual_postures(&[*hand, next], stature_m);
        let mut moved = DVector::zeros(q.len());
        let travel_m = speed_squared(twist).sqrt() * MOMENT_S;
        self.add_pull(&mut moved, (&usual[0], &usual[1]), (q, None, None), (travel_m, MOMENT_S));
        moved / MOMENT_S
    }

    /// How the person usually turns the hand at a place (rest frame, m) of a body of `stature_m`: as the
    /// recorded hands near there did. A person whose hand kept one orientation has that one everywhere.
    pub fn usual_orientation(&self, place: &Vec3, stature_m: f64) -> UnitQuaternion<f64> {
        let f = &self.features;
        let turned = f.spread[3..].iter().map(|s| s * f.stature_m / ROTATION_LENGTH_M);
        if turned.fold(0.0, f64::max) < ONE_ORIENTATION_RAD {
            return f.reference;
        }
        let at = f.of(&Pose::from_parts((*place).into(), f.reference), stature_m);
        let mut near = vec![0.0; self.inputs.len()];
        squared_exponentials::<3>(&self.inputs, &at, self.length_scale * NEAR, &mut near);
        let (mut sum, mut weights) = (Vec3::zeros(), 0.0);
        for (input, w) in self.inputs.iter().zip(near) {
            let w = w + f64::MIN_POSITIVE;
            sum += w * Vec3::new(input[3], input[4], input[5]);
            weights += w;
        }
        let mean = sum / weights;
        let turn = Vec3::from_fn(|i, _| mean[i] * f.spread[3 + i] + f.mean[3 + i])
            * (f.stature_m / ROTATION_LENGTH_M);
        UnitQuaternion::from_scaled_axis(turn) * f.reference
    }

    /// The usual postures at all places where it was learned, n each, rad.
    pub(super) fn where_learned(&self) -> Vec<DVector<f64>> {
        self.usual_at(&self.inputs, 1).into_iter().map(|usual| usual.posture).collect()
    }

    /// Number of training postures behind the regression.
    pub fn sample_count(&self) -> usize {
        self.inputs.len()
    }

    /// The usual posture for a hand pose (pelvis frame) of a body of `stature_m`.
    pub fn usual_posture(&self, hand: &Pose, stature_m: f64) -> UsualPosture {
        self.usual_postures(std::slice::from_ref(hand), stature_m).swap_remove(0)
    }

    /// The usual postures for many hand poses, which is faster than one by one.
    pub fn usual_postures(&self, hands: &[Pose], stature_m: f64) -> Vec<UsualPosture> {
        let x: Vec<[f64; 6]> = hands.iter().map(|h| self.features.of(h, stature_m)).collect();
        self.usual_at(&x, 1)
    }

    /// The same for the hand poses of a path, some millimetres apart: how well its postures are known is looked up
    /// at every few of them, and is linear in between.
    pub(super) fn usual_along(&self, hands: &[Pose], stature_m: f64) -> Vec<UsualPosture> {
        let x: Vec<[f64; 6]> = hands.iter().map(|h| self.features.of(h, stature_m)).collect();
        self.usual_at(&x, ALONG)
    }

    /// The usual postures, their confidence exactly at every n-th place and at the last.
    fn usual_at(&self, x: &[[f64; 6]], every: usize) -> Vec<UsualPosture> {
        let common = |i: usize| {
            let is_own =
                self.person.is_some() && self.origins.get(i).map(|o| o.person) == self.person;
            if is_own { 1.0 + PERSON } else { 1.0 }
        };
        let common: Vec<f64> = (0..self.inputs.len()).map(common).collect();
        let mut near = DMatrix::zeros(self.inputs.len(), x.len());
        if !common.is_empty() {
            let columns = near.as_mut_slice().chunks_exact_mut(common.len());
            for (column, x) in columns.zip(x) {
                squared_exponentials::<6>(&self.inputs, x, self.length_scale, column);
                column.iter_mut().zip(&common).for_each(|(near, common)| *near *= common);
            }
        }
        let off = transposed_product(&self.coefficients, &near);
        let explained = self.explained(&near, every);
        let mean = self.mean.at(&self.features, x);
        let own = PERSON + MOVEMENT + self.noise;
        let usual = |j: usize| {
            let confidence = explained[j].clamp(0.0, 1.0);
            UsualPosture {
                posture: mean.row(j).transpose() + off.column(j),
                confidence,
                growth: self.mean.bend().map(|_| (1.0 + own - confidence) / own),
            }
        };
        (0..x.len()).map(usual).collect()
    }

    /// `k^T K^-1 k = |L^-1 k|^2` of each column, exactly at every n-th and at the last.
    fn explained(&self, near: &DMatrix<f64>, every: usize) -> Vec<f64> {
        let count = near.ncols();
        let Some(factor) = self.factor.as_ref().filter(|_| count > 0) else {
            return vec![0.0; count];
        };
        let mut looked_at: Vec<usize> = (0..count).step_by(every.max(1)).collect();
        if looked_at.last() != Some(&(count - 1)) {
            looked_at.push(count - 1);
        }
        let white = factor.solve_lower(&near.select_columns(&looked_at));
        let known: Vec<f64> = white.column_iter().map(|w| w.norm_squared()).collect();
        let between = |j: usize| {
            let after = looked_at.partition_point(|at| *at < j);
            let (b, end) = (looked_at[after], known[after]);
            if b == j {
                return end;
            }
            let (a, start) = (looked_at[after - 1], known[after - 1]);
            start + (end - start) * (j - a) as f64 / (b - a) as f64
        };
        (0..count).map(between).collect()
    }
}

/// Those of many places to one, by their first `N` numbers.
fn squared_exponentials<const N: usize>(
    all: &[[f64; 6]],
    at: &[f64; 6],
    length_scale: f64,
    near: &mut [f64],
) {
    let scale = -0.5 / (length_scale * length_scale);
    wide(
        #[inline(always)]
        || {
            for (near, input) in near.iter_mut().zip(all) {
                let mut distance = 0.0;
                for i in 0..N {
                    let apart = input[i] - at[i];
                    distance = apart.mul_add(apart, distance);
                }
                *near = scale * distance;
            }
            for near in near.iter_mut() {
                *near = exp(*near);
            }
        },
    );
}

fn squared_exponential(a: &[f64; 6], b: &[f64; 6], length_scale: f64) -> f64 {
    let distance: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
    (-0.5 * distance / (length_scale * length_scale)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn trained() -> (Vec<Pose>, DMatrix<f64>, Attraction) {
        let hands: Vec<Pose> = (0..40)
            .map(|i| {
                let t = f64::from(i) / 39.0;
                Pose::new(Vec3::new(0.3 + 0.2 * t, 0.1 * t, 0.2), Vec3::new(0.0, 0.4 * t, 0.1))
            })
            .collect();
        let postures = DMatrix::from_fn(40, 3, |i, j| (i as f64 / 39.0 + j as f64).sin());
        let model = Attraction::fit(
            &hands,
            postures.clone(),
            1.7,
            Pull::Metre { length_m: 0.2 },
            1.0,
            1e-4,
        );
        (hands, postures, model)
    }

    #[test]
    fn recalls_training_postures_and_fades_far_away() {
        let (hands, postures, model) = trained();
        let at = model.usual_posture(&hands[17], 1.7);
        assert_relative_eq!(at.posture, postures.row(17).transpose(), epsilon = 2e-2);
        assert!(at.confidence > 0.99, "{}", at.confidence);
        let far = model.usual_posture(&Pose::translation(3.0, 0.0, 0.0), 1.7);
        assert!(far.confidence < 1e-3);
        assert_relative_eq!(far.posture, postures.row_mean().transpose(), epsilon = 1e-3);
    }

    #[test]
    fn along_a_path_postures_are_the_same_and_their_confidence_nearly() {
        let (_, _, model) = trained();
        for count in [1, 2, 9, 60] {
            let at = |k: usize| Pose::translation(0.3 + 0.008 * k as f64, 0.05, 0.2);
            let hands: Vec<Pose> = (0..count).map(at).collect();
            let exact = model.usual_postures(&hands, 1.7);
            for (a, b) in exact.iter().zip(model.usual_along(&hands, 1.7)) {
                assert_eq!(a.posture, b.posture);
                assert!((a.confidence - b.confidence).abs() < 0.03);
            }
        }
    }

    #[test]
    fn a_taller_body_meets_the_same_posture_at_a_scaled_place() {
        let (hands, _, model) = trained();
        let mut scaled = hands[9];
        scaled.translation.vector *= 1.9 / 1.7;
        let (a, b) = (model.usual_posture(&hands[9], 1.7), model.usual_posture(&scaled, 1.9));
        assert_relative_eq!(a.posture, b.posture, epsilon = 1e-12);
    }

    #[test]
    fn a_pull_is_exact_whatever_the_steps() {
        // One joint, a usual posture that rises by 2 rad/m, a start 0.5 rad off it.
        let (_, _, mut model) = trained();
        let usual = |x: f64| UsualPosture {
            posture: DVector::from_element(1, 2.0 * x),
            confidence: 1.0,
            growth: None,
        };
        let walk = |model: &Attraction, steps: usize, (length_m, time_s): (f64, f64)| {
            let mut q = DVector::from_element(1, 0.5);
            for k in 0..steps {
                let at = |k: usize| usual(length_m * k as f64 / steps as f64);
                let mut moved = DVector::zeros(1);
                let step = (length_m / steps as f64, time_s / steps as f64);
                model.add_pull(&mut moved, (&at(k), &at(k + 1)), (&q, None, None), step);
                q += moved;
            }
            q[0]
        };
        for steps in [1, 7, 100] {
            for time_s in [1.0, 300.0] {
                let end = walk(&model, steps, (0.6, time_s));
                assert_relative_eq!(end, 1.2 + 0.5 * f64::exp(-0.6 / 0.2), epsilon = 1e-12);
                assert_relative_eq!(walk(&model, steps, (0.0, time_s)), 0.5, epsilon = 1e-15);
            }
        }
        model.pull = Pull::Second { rate_per_s: 4.0 };
        for steps in [1, 10] {
            let end = walk(&model, steps, (0.0, 2.0));
            assert_relative_eq!(end, 0.5 * f64::exp(-8.0), epsilon = 1e-12);
        }
    }

    #[test]
    fn the_velocity_of_a_pull_is_that_of_short_steps() {
        let (hands, _, model) = trained();
        let q = DVector::from_vec(vec![0.3, 0.1, -0.2]);
        let velocity = |twist: [f64; 6]| model.pull_velocity(&hands[20], &twist, &q, 1.7);
        let twist = [0.1, 0.05, 0.0, 0.0, 0.2, 0.0];
        assert_eq!(velocity([0.0; 6]).amax(), 0.0, "a hand that rests");
        let slow = velocity(twist.map(|v| 0.1 * v));
        assert_relative_eq!(velocity(twist), slow * 10.0, max_relative = 1e-3);
    }

    /// Three people, eight movements each, who go ahead with the hand, and bend where it is below the hips; nobody
    /// was seen with the hand between 0.1 and 0.5 m above them.
    fn people(people: usize) -> Attraction {
        let heights = [-0.7, -0.55, -0.4, -0.25, -0.1, 0.0, 0.1, 0.5, 0.6, 0.7];
        let (mut hands, mut rows, mut origins) = (Vec::new(), Vec::new(), Vec::new());
        for movement in 0..8 * people {
            for (k, height) in heights.iter().enumerate() {
                let place = Vec3::new(
                    0.2 + 0.04 * ((3 * k + movement) % 10) as f64,
                    *height,
                    0.03 * ((7 * k + 2 * movement) % 9) as f64,
                );
                hands.push(Pose::from_parts(place.into(), UnitQuaternion::identity()));
                rows.push(nalgebra::RowDVector::from_row_slice(&usual_of_people(&place)));
                origins.push(Origin { person: movement / 8, movement });
            }
        }
        let pull = (Pull::Metre { length_m: 0.4 }, 0.15, 0.05);
        let lowness = Some(Lowness::linear(0.0, -0.2));
        Attraction::of_people(&hands, DMatrix::from_rows(&rows), origins, 1.7, pull, lowness)
    }

    fn usual_of_people(place: &Vec3) -> [f64; 2] {
        [0.5 * place.x, -1.2 * (-place.y).max(0.0) + 0.1]
    }

    #[test]
    fn people_go_on_beyond_what_was_seen_as_they_did_beside_it() {
        let model = people(3);
        let at = |x: f64, y: f64, z: f64| model.usual_posture(&Pose::translation(x, y, z), 1.7);
        // In the gap, and far to the side: upright, and not bent like most of the recorded postures.
        for (x, y, z) in [(0.4, 0.3, 0.1), (0.3, 0.2, 2.0), (0.3, -0.4, 2.0)] {
            let place = Vec3::new(x, y, z);
            let found = at(x, y, z);
            let off = found.posture - DVector::from_row_slice(&usual_of_people(&place));
            assert!(off.amax() < 0.01, "{place:?}: {off}");
        }
        // Beyond the places that were seen as at their edge.
        let (edge, beyond) = (at(0.56, 3.0, 0.1), at(5.0, 9.0, 0.1));
        assert_relative_eq!(edge.posture, beyond.posture, epsilon = 1e-9);
        // The variance as of a Gaussian process: all that is unknown far away, and what people have of their own
        // where nothing is.
        let (own, far) = (PERSON + MOVEMENT + 0.05, at(0.3, 0.2, 3.0));
        assert!(far.confidence < 1e-6);
        assert_relative_eq!(far.growth.unwrap(), (1.0 + own) / own, epsilon = 1e-5);
        let known = at(0.3, -0.4, 0.1);
        assert_relative_eq!(
            known.growth.unwrap(),
            (1.0 + own - known.confidence) / own,
            epsilon = 1e-12
        );
        // Too few movements tell no trend.
        let few = people(2).usual_posture(&Pose::translation(0.3, 0.2, 3.0), 1.7);
        assert!(few.growth.is_none() && few.posture[1] < -0.05, "{few:?}");
        let back: Attraction =
            serde_json::from_str(&serde_json::to_string(&model).unwrap()).unwrap();
        let hand = Pose::translation(0.4, 0.3, 0.1);
        assert_eq!(model.usual_posture(&hand, 1.7), back.usual_posture(&hand, 1.7));
    }

    #[test]
    fn the_trend_is_that_of_generalised_least_squares() {
        // Against the normal equations with the inverse of the kernel, on postures that no trend explains.
        let model = people(3);
        let noisy = model.regressed(|q| q.map(|v| v + (37.0 * v).sin()));
        let Mean::Trend(trend) = &noisy.mean else { panic!("no trend") };
        let count = noisy.inputs.len();
        let kernel = DMatrix::from_fn(count, count, |i, j| {
            let (a, b) = (noisy.origins[i], noisy.origins[j]);
            let own = if a.person == b.person { PERSON } else { 0.0 }
                + if a.movement == b.movement { MOVEMENT } else { 0.0 };
            let k = squared_exponential(&noisy.inputs[i], &noisy.inputs[j], 1.0) * (1.0 + own);
            if i == j { k + 0.05 } else { k }
        });
        let inverse = kernel.try_inverse().unwrap();
        let basis = trend.basis(&noisy.features, &noisy.inputs);
        let left = basis.transpose() * &inverse * &basis;
        let right = basis.transpose() * inverse * &noisy.postures;
        let exact = left.try_inverse().unwrap() * right;
        assert_relative_eq!(trend.slopes, exact, epsilon = 1e-3);
    }

    #[test]
    fn survives_the_file() {
        let (hands, _, model) = trained();
        let text = serde_json::to_string(&model).unwrap();
        let back: Attraction = serde_json::from_str(&text).unwrap();
        assert_eq!(model.usual_posture(&hands[3], 1.7), back.usual_posture(&hands[3], 1.7));
    }
}

//! Legs of a person whose feet stay where they are: hip, knee and ankle follow from the pelvis.
//!
//! A planted foot leaves a leg with six joints (hip 3, knee 1, ankle 2) as many constraints, so that
//! the pelvis alone decides its posture, in closed form. With `r` the hip seen from the ankle in the axes
//! of the foot, `d = |r|`, thigh `a` and shank `s`:
//!
//! ```text
//! knee     cos k = (d^2 - a^2 - s^2) / (2 a s)             law of cosines; k flexion
//! ankle X  tan b = -r_z / r_y                               the shank's plane holds the hip
//! ankle Z  t = atan2(r_x, |r_yz|) + atan2(a sin k, s + a cos k)
//! hip      Z, X, Y of  R_pelvis^T R_foot R_x(-b) R_z(k - t)
//! ```
//! Where the ankle would be bent beyond its range, the heel rises about the ball of the foot, as little as
//! is needed.

use super::body::{Body, Stance};
use super::pelvis::PELVIS;
use super::side::Side;
use crate::files::InputError;
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::pose::zxy;
use crate::math::{Pose, Vec3};
use nalgebra::{Matrix3, Matrix6, Vector6};

/// Feet of an upright body point outward by this, rad (assumed).
const TOE_OUT: f64 = 7.0 * std::f64::consts::PI / 180.0;
/// Part of the length between heel and ankle, and between heel and ball, over the foot's (as bodies are
/// made), and half the breadth of the sole at the ball over the foot's length (ANSUR II).
const HEEL_TO_ANKLE: f64 = 0.25;
const HEEL_TO_BALL: f64 = 0.72;
const HALF_BREADTH: f64 = 0.19;
/// Offsets that count as a straight leg, m.
const STRAIGHT_M: f64 = 1e-4;
/// How far feet may be above what they stand on before they hang, m: shoes and a raised heel.
const HANG_M: f64 = 0.06;
/// Sole of a shoe on a foot that hangs, m (assumed).
const SHOE_M: f64 = 0.03;
/// Knee flexion below which a leg counts as straight, rad.
const STRAIGHT_RAD: f64 = 0.1;
/// What is added to the squares of a straight leg's Jacobian (m and rad).
const STRAIGHT_DAMPING: f64 = 1e-5;
/// How exactly the heel's rise is found, rad, in at most so many tries.
const SETTLED: f64 = 1e-10;
const MOST_TRIES: usize = 60;

/// Halvings of a leg's length: to rounding.
const BISECTIONS: usize = 44;

/// Angles of one leg, rad.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LegPosture {
    /// Hip about Z (flexion), X and Y.
    pub hip: [f64; 3],
    /// Knee about Z: flexion is negative.
    pub knee: f64,
    /// Ankle about Z (to the shin) and X.
    pub ankle: [f64; 2],
    /// How far the heel is raised about the ball of the foot.
    pub heel: f64,
    /// By how much the leg is too short to reach its foot, m; 0 where it does.
    pub short_m: f64,
}

/// One leg on its foot.
#[derive(Debug, Clone, PartialEq)]
struct Leg {
    /// Hip in the pelvis frame, m.
    hip: Vec3,
    thigh_m: f64,
    shank_m: f64,
    /// Ankle in the rest frame with the foot flat, and the foot's axes there.
    ankle: Vec3,
    foot: Matrix3<f64>,
    /// From the ankle to the ball, in the foot's axes, m.
    ball: Vec3,
    /// Ranges of hip Z, X, Y, knee, ankle Z, X and of the heel, rad.
    ranges: [(f64, f64); 7],
}

/// Both legs of a body on planted feet, right first.
#[derive(Debug, Clone, PartialEq)]
pub struct Legs {
    sides: [Leg; 2],
    foot_m: f64,
    /// Ankles above the soles, m.
    sole_m: f64,
    /// Feet of somebody who sits that do not reach the floor.
    hang: bool,
    is_standing: bool,
}

/// Where a shoe is around the ankle of a flat foot (x forward, y up), m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shoe {
    /// Back of the heel.
    pub heel_m: f64,
    /// The ball's joint.
    pub ball: Vec3,
    /// Tip of the toes.
    pub toe_m: f64,
    /// Ankle above the sole.
    pub sole_m: f64,
}

/// A linear bound on the pelvis' six coordinates: `lower <= at + coefficients . change <= upper`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PelvisRow {
    /// For each coordinate.
    pub coefficients: [f64; 6],
    /// Value now, m or rad.
    pub at: f64,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
}

/// Both legs of one posture, right first.
#[derive(Debug, Clone)]
pub struct Bending([Bent; 2]);

/// Where a leg is between its ground and its pelvis.
#[derive(Debug, Clone)]
struct Bent {
    posture: LegPosture,
    /// Axes of foot, shank and thigh in the rest frame.
    foot: Matrix3<f64>,
    shank: Matrix3<f64>,
    thigh: Matrix3<f64>,
    ankle: Vec3,
    knee: Vec3,
    hip: Vec3,
}

impl Legs {
    /// For a body that stands with its feet under its hips in the upright posture, toes a little out, or
    /// sits with its shanks upright.
    ///
    /// # Errors
    /// Where the body's legs are no straight columns at zero angles, as those of made bodies are.
    pub fn new(body: &Body, stance: Stance) -> Result<Self, InputError> {
        let mut legs = [Leg::new(body, Side::Right)?, Leg::new(body, Side::Left)?];
        let foot_m = legs[0].ball.x / (HEEL_TO_BALL - HEEL_TO_ANKLE);
        let mut hang = false;
        let bare_m = body.standing_pelvis_height_m + legs[0].ankle.y;
        let mut sole_m = match stance {
            Stance::Standing { shoe_m } => bare_m + shoe_m,
            Stance::Seated { .. } => bare_m,
        };
        if let Stance::Seated { seat_height_m, footrest_m } = stance {
            let hips_m = seat_height_m + body.seat_to_hip_m - footrest_m;
            for leg in &mut legs {
                let ankle_m = body.standing_pelvis_height_m - leg.longest_m();
                // Thighs level on the seat: feet that do not get down to the floor hang.
                let down = hips_m - ankle_m;
                let gap_m = (down - leg.shank_m).max(0.0);
                hang |= gap_m > HANG_M;
                sole_m = bare_m + if hang { SHOE_M } else { gap_m };
                leg.ankle = leg.hip + Vec3::new(leg.thigh_m, -down.min(leg.shank_m), 0.0);
            }
        }
        Ok(Self {
            sides: legs,
            foot_m,
            sole_m,
            hang,
            is_standing: matches!(stance, Stance::Standing { .. }),
        })
    }

    /// Whether the feet of somebody who sits do not reach what they should stand on.
    pub fn hang(&self) -> bool {
        self.hang
    }

    /// Whether the feet carry the body.
    pub fn is_standing(&self) -> bool {
        self.is_standing
    }

    /// Both legs for a pelvis in the rest frame, right first.
    pub fn postures(&self, pelvis: &Pose) -> [LegPosture; 2] {
        let turn = *pelvis.rotation.to_rotation_matrix().matrix();
        let Bending(legs) = self.bending(&pelvis.translation.vector, &turn);
        legs.map(|b| b.posture)
    }

    /// The same for place and axes of the pelvis, for what else follows.
    pub fn bending(&self, at: &Vec3, turn: &Matrix3<f64>) -> Bending {
        Bending([0, 1].map(|i| self.sides[i].solve(at, turn)))
    }

    /// Hip, knee, ankle and ball of each leg in the rest frame, m; right first.
    pub(super) fn centres(&self, bending: &Bending) -> [[Vec3; 4]; 2] {
        [0, 1].map(|i| {
            let b = &bending.0[i];
            [b.hip, b.knee, b.ankle, b.ankle + b.foot * self.sides[i].ball]
        })
    }

    /// Where flat feet may carry: corners of the soles in the rest frame (x forward, z right), m.
    pub fn soles(&self) -> Vec<[f64; 2]> {
        let half = HALF_BREADTH * self.foot_m;
        let ahead = |share: f64| (share - HEEL_TO_ANKLE) * self.foot_m;
        let corners = [
            (ahead(0.0), -0.6 * half),
            (ahead(0.0), 0.6 * half),
            (ahead(HEEL_TO_BALL), -half),
            (ahead(HEEL_TO_BALL), half),
            (ahead(1.0), -0.5 * half),
            (ahead(1.0), 0.5 * half),
        ];
        let of = |leg: &Leg| {
            corners.map(|(x, z)| {
                let at = leg.ankle + leg.foot * Vec3::new(x, 0.0, z);
                [at.x, at.z]
            })
        };
        self.sides.iter().flat_map(of).collect()
    }

    /// How far back heels and ankles are in the rest frame, m.
    pub fn heels_and_ankles_m(&self) -> [f64; 2] {
        let ankle = self.sides[0].ankle.x;
        [ankle - HEEL_TO_ANKLE * self.foot_m, ankle]
    }

    /// The shoes.
    pub(super) fn shoe(&self) -> Shoe {
        let ball = self.sides[0].ball;
        let ahead = |share: f64| (share - HEEL_TO_ANKLE) * self.foot_m;
        Shoe { heel_m: ahead(0.0), ball, toe_m: ahead(1.0), sole_m: self.sole_m }
    }

    /// Ankles with the feet flat, rest frame, m; right first.
    pub fn ankles(&self) -> [Vec3; 2] {
        [self.sides[0].ankle, self.sides[1].ankle]
    }

    /// Bounds on the pelvis' coordinates that the legs set within `near` (m or rad) of now; `columns`: twist
    /// of the pelvis (m, rad; of its origin, rest axes) by each coordinate. Nobody goes on tiptoe to reach
    /// higher: a straight leg ends with the foot flat.
    pub fn rows(
        &self,
        (at, bending): (&Vec3, &Bending),
        columns: &Matrix6<f64>,
        near: f64,
        rows: &mut Vec<PelvisRow>,
    ) {
        for (leg, bent) in self.sides.iter().zip(&bending.0) {
            leg.rows((at, bent), columns, near, rows);
        }
    }

    /// Rise of the lower heel, rad.
    pub fn heel(bending: &Bending) -> f64 {
        bending.0.iter().map(|b| b.posture.heel).fold(f64::INFINITY, f64::min)
    }

    /// By how much the legs are too short (m) and any angle is beyond its range (rad); 0 where all is
    /// kept.
    pub fn excess(&self, bending: &Bending) -> (f64, f64) {
        let (mut short_m, mut beyond) = (0.0f64, 0.0f64);
        for (leg, bent) in self.sides.iter().zip(&bending.0) {
            short_m = short_m.max(bent.posture.short_m);
            for (v, (lower, upper)) in bent.posture.all().iter().zip(&leg.ranges) {
                beyond = beyond.max(lower - v).max(v - upper);
            }
        }
        (short_m, beyond)
    }

    /// From hip to ankle of a straight leg, m.
    pub fn length_m(&self) -> f64 {
        0.5 * (self.sides[0].longest_m() + self.sides[1].longest_m())
    }

    /// Midway between the hips, in the pelvis frame, m.
    pub fn between_hips(&self) -> Vec3 {
        0.5 * (self.sides[0].hip + self.sides[1].hip)
    }

    /// Midway between the ankles, or between the balls of the feet, at the height of the ankles; feet flat,
    /// rest frame, m.
    pub fn between_feet(&self, at_balls: bool) -> Vec3 {
        let stands = |leg: &Leg| {
            let ball = if at_balls { leg.foot * leg.ball } else { Vec3::zeros() };
            leg.ankle + Vec3::new(ball.x, 0.0, ball.z)
        };
        0.5 * (stands(&self.sides[0]) + stands(&self.sides[1]))
    }

    /// How far a pelvis in the rest frame must come down for both legs to reach their flat feet, m.
    pub fn too_high_m(&self, pelvis: &Pose) -> f64 {
        let of = |leg: &Leg| {
            let r = pelvis * nalgebra::Point3::from(leg.hip) - nalgebra::Point3::from(leg.ankle);
            let level = r.x.hypot(r.z);
            r.y - (leg.longest_m().powi(2) - level * level).max(0.0).sqrt()
        };
        self.sides.iter().map(of).fold(0.0, f64::max)
    }

    /// A pelvis in the rest frame raised or lowered until the knees are bent so far on average, rad; as far as legs
    /// reach.
    pub fn bent_so(&self, pelvis: &Pose, knees: f64) -> Pose {
        let at = |up_m: f64| {
            let mut moved = *pelvis;
            moved.translation.vector.y += up_m;
            moved
        };
        let bend = |up_m: f64| -> f64 {
            let [right, left] = self.postures(&at(up_m));
            -0.5 * (right.knee + left.knee)
        };
        if !knees.is_finite() {
            return at(f64::NAN);
        }
        // From where both legs reach their feet downwards knees bend more and more.
        let top = -self.too_high_m(&at(self.length_m())) + self.length_m();
        let (mut low, mut high) = (top - self.length_m(), top);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if bend(middle) > knees { low = middle } else { high = middle }
        }
        at(0.5 * (low + high))
    }

    /// [`Self::excess`] for a pelvis in the rest frame.
    pub fn excess_at(&self, pelvis: &Pose) -> (f64, f64) {
        let turn = *pelvis.rotation.to_rotation_matrix().matrix();
        self.excess(&self.bending(&pelvis.translation.vector, &turn))
    }
}

impl LegPosture {
    /// Hip Z, X, Y, knee, ankle Z, X and heel, rad.
    fn all(&self) -> [f64; 7] {
        let [z, x, y] = self.hip;
        [z, x, y, self.knee, self.ankle[0], self.ankle[1], self.heel]
    }
}

/// Sine and cosine of an angle.
#[derive(Debug, Clone, Copy)]
struct Turn {
    sin: f64,
    cos: f64,
}

impl Turn {
    fn of(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }

    /// The other way round.
    fn back(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    fn angle(self) -> f64 {
        self.sin.atan2(self.cos)
    }
}

/// How far a heel is raised, rad.
#[derive(Debug, Clone, Copy)]
struct Rise {
    heel: f64,
    turn: Turn,
}

impl Rise {
    const NONE: Self = Self { heel: 0.0, turn: Turn { sin: 0.0, cos: 1.0 } };

    fn of(heel: f64) -> Self {
        Self { heel, turn: Turn::of(heel) }
    }

    /// What is seen from a foot with its heel down, seen from this one.
    fn turned(&self, v: &Vec3) -> Vec3 {
        let Turn { sin, cos } = self.turn;
        Vec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
    }
}

/// A hip seen from the ankle, in the axes of the foot.
#[derive(Debug, Clone, Copy)]
struct HipSeen {
    /// m.
    r: Vec3,
    /// Length of its part across x, m.
    yz: f64,
    /// Flexion.
    knee: Turn,
    /// Sine and cosine of the angle between the shank and the way to the hip, times its length, m.
    gamma: (f64, f64),
}

impl HipSeen {
    /// The shank's plane holds the hip.
    fn roll(&self) -> Turn {
        if self.yz > 0.0 {
            Turn { sin: -self.r.z / self.yz, cos: self.r.y / self.yz }
        } else {
            Turn { sin: 0.0, cos: 1.0 }
        }
    }

    /// The shank's own.
    fn lean(&self) -> Turn {
        let (a, b) = self.gamma;
        let (sin, cos) = (self.r.x * b + self.yz * a, self.yz * b - self.r.x * a);
        let length = (sin * sin + cos * cos).sqrt();
        if length > 0.0 { Turn { sin: sin / length, cos: cos / length } } else { Turn::of(0.0) }
    }
}

impl Leg {
    /// With the foot under the hip.
    fn new(body: &Body, side: Side) -> Result<Self, InputError> {
        let names = ["UpperLeg", "LowerLeg", "Foot", "Toe"];
        let tips = names.map(|n| Tip::link(&format!("{}{n}", side.prefix())));
        let chain = Linkage::new(&body.model, PELVIS, &tips)
            .map_err(|e| InputError::new(&body.name, format!("is no ergopath body: {e}")))?;
        let mut frames = Frames::default();
        chain.forward(&vec![0.0; chain.dof()], &mut frames);
        let [hip, knee, ankle, ball] = [0, 1, 2, 3].map(|i| chain.tip_frame(&frames, i).0);
        let (thigh, shank) = (knee - hip, ankle - knee);
        let is_column = |v: &Vec3| v.y < 0.0 && v.x.abs().max(v.z.abs()) < STRAIGHT_M;
        if !is_column(&thigh) || !is_column(&shank) {
            let message = "has legs that are not straight at zero angles";
            return Err(
                InputError::new(&body.name, message).remedy("make the body with `ergopath body`")
            );
        }
        let range = |joint: &str| {
            let name = format!("j{}{joint}", side.prefix());
            let found = chain.joints().iter().find(|j| j.name == name);
            found.map_or((0.0, 0.0), |j| (j.lower, j.upper))
        };
        let joints = ["Hip_Z", "Hip_X", "Hip_Y", "Knee_Z", "Ankle_Z", "Ankle_X", "BallFoot_Z"];
        let mut ranges = joints.map(range);
        // A heel does not sink into the floor.
        ranges[6].0 = 0.0;
        Ok(Self {
            hip,
            thigh_m: -thigh.y,
            shank_m: -shank.y,
            ankle,
            foot: about_y(Turn::of(if side == Side::Right { -TOE_OUT } else { TOE_OUT })),
            ball: ball - ankle,
            ranges,
        })
    }

    fn longest_m(&self) -> f64 {
        self.thigh_m + self.shank_m
    }

    /// Where the hip is for a foot with the heel down, and the least rise of the heel with which the ankle
    /// stays within its range.
    fn footing(&self, hip: &Vec3) -> (Rise, HipSeen) {
        let flat = self.seen(self.foot.tr_mul(&(hip - self.ankle)));
        let most = self.ranges[4].1;
        if flat.lean().angle() <= most {
            return (Rise::NONE, flat);
        }
        // From the ball the hip turns against the foot: r = R_z(heel) p + ball.
        let p = flat.r - self.ball;
        let seen = |rise: &Rise| self.seen(rise.turned(&p) + self.ball);
        let (mut low, mut high) = (0.0, self.ranges[6].1);
        let highest = Rise::of(high);
        let at_highest = seen(&highest);
        if at_highest.lean().angle() > most {
            return (highest, at_highest);
        }
        let (sin, cos) = most.sin_cos();
        let mut heel = low;
        for _ in 0..MOST_TRIES {
            let rise = Rise::of(heel);
            let here = seen(&rise);
            let (beyond, slope) = self.beyond(&here, (sin, cos));
            if beyond > 0.0 {
                low = heel;
            } else {
                high = heel;
            }
            let next = heel - beyond / slope;
            let is_inside = slope < 0.0 && next > low && next < high;
            let next = if is_inside { next } else { 0.5 * (low + high) };
            if (next - heel).abs() < SETTLED {
                return (rise, here);
            }
            heel = next;
        }
        (Rise::of(high), seen(&Rise::of(high)))
    }

    /// Something that is positive where the ankle is bent beyond an angle (its sine and cosine), and its
    /// slope over the rise of the heel: how far the hip is from where that ankle and a bent knee hold it.
    /// The slope is of no use (positive) where the hip is ahead of a leg stretched at that angle.
    ///
    /// ```text
    /// a^2 - |hip - knee|^2      knee at s (sin t, cos t) of the shank's plane
    /// ```
    fn beyond(&self, seen: &HipSeen, (sin, cos): (f64, f64)) -> (f64, f64) {
        let HipSeen { r, yz, .. } = seen;
        if r.x * cos - yz * sin >= 0.0 {
            return (1.0, 1.0);
        }
        let (du, dy) = (self.ball.y - r.y, r.x - self.ball.x);
        let dv = if *yz > 0.0 { r.y * dy / yz } else { 0.0 };
        let (a, s) = (self.thigh_m, self.shank_m);
        let at = 2.0 * s * (r.x * sin + yz * cos) - r.norm_squared() - s * s + a * a;
        let slope = 2.0 * s * (du * sin + dv * cos) - 2.0 * (r.x * du + yz * dv);
        (at, slope)
    }

    /// A leg to a hip at `r` from the ankle, in the axes of the foot.
    fn seen(&self, r: Vec3) -> HipSeen {
        let (a, s) = (self.thigh_m, self.shank_m);
        let cos = ((r.norm_squared() - a * a - s * s) / (2.0 * a * s)).clamp(-1.0, 1.0);
        let knee = Turn { sin: (1.0 - cos * cos).sqrt(), cos };
        HipSeen { r, yz: (r.y * r.y + r.z * r.z).sqrt(), knee, gamma: (a * knee.sin, s + a * cos) }
    }

    fn solve(&self, at: &Vec3, turn: &Matrix3<f64>) -> Bent {
        let hip = at + turn * self.hip;
        let (rise, seen) = self.footing(&hip);
        let (mut ankle, mut foot) = (self.ankle, self.foot);
        if rise.heel > 0.0 {
            foot *= about_z(Turn { sin: -rise.turn.sin, cos: rise.turn.cos });
            ankle += self.foot * self.ball - foot * self.ball;
        }
        let (roll, lean) = (seen.roll(), seen.lean());
        let upright = foot * about_x(roll.back());
        let shank = upright * about_z(lean.back());
        let thigh = shank * about_z(seen.knee);
        let posture = LegPosture {
            hip: zxy(&turn.tr_mul(&thigh)),
            knee: -seen.knee.angle(),
            ankle: [lean.angle(), roll.angle()],
            heel: rise.heel,
            short_m: (seen.r.norm() - self.longest_m()).max(0.0),
        };
        let knee = ankle + shank.column(1) * self.shank_m;
        Bent { posture, foot, shank, thigh, ankle, knee, hip }
    }

    fn rows(
        &self,
        (at, bent): (&Vec3, &Bent),
        columns: &Matrix6<f64>,
        near: f64,
        rows: &mut Vec<PelvisRow>,
    ) {
        // The leg is no longer than straight: how the hip moves away from the ankle.
        let longest = self.longest_m();
        let to = bent.hip - self.ankle;
        let length = to.norm();
        if length > longest - near {
            let u = to / length;
            let turning = (bent.hip - at).cross(&u);
            let by = |c: usize| {
                let (v, w) = (columns.fixed_view::<3, 1>(0, c), columns.fixed_view::<3, 1>(3, c));
                u.dot(&v) + turning.dot(&w)
            };
            let coefficients = std::array::from_fn(by);
            rows.push(PelvisRow {
                coefficients,
                at: length,
                lower: f64::NEG_INFINITY,
                upper: longest,
            });
        }
        // A straight knee has its end above; where the shin has its own, the heel rises.
        let angles = bent.posture.all();
        let bounds = |i: usize| match (i, self.ranges[i]) {
            (3 | 4, (lower, _)) => (lower, f64::INFINITY),
            (6, (_, upper)) => (f64::NEG_INFINITY, upper),
            (_, range) => range,
        };
        let is_close = |i: usize| {
            let (lower, upper) = bounds(i);
            angles[i] < lower + near || angles[i] > upper - near
        };
        if !(0..7).any(is_close) {
            return;
        }
        let Some(rates) = self.rates(bent, at, columns) else { return };
        for i in (0..7).filter(|&i| is_close(i)) {
            let (lower, upper) = bounds(i);
            let coefficients = std::array::from_fn(|c| rates[i][c]);
            rows.push(PelvisRow { coefficients, at: angles[i], lower, upper });
        }
    }

    /// How each angle of the leg changes with the pelvis' coordinates; none where that is singular.
    fn rates(&self, bent: &Bent, at: &Vec3, columns: &Matrix6<f64>) -> Option<[Vector6<f64>; 7]> {
        let p = &bent.posture;
        let [_, x, y] = p.hip.map(|angle| Turn::of(-angle));
        let pelvis_z = bent.thigh * about_y(y) * about_x(x);
        let hip_x = pelvis_z.column(0).into_owned();
        let axis = |m: &Matrix3<f64>, i: usize| -> Vec3 { m.column(i).into_owned() };
        let ball = bent.ankle + bent.foot * self.ball;
        let all = [
            // About the pelvis' own z axis: the axes after Z share it.
            (axis(&pelvis_z, 2), bent.hip),
            (hip_x, bent.hip),
            (axis(&bent.thigh, 1), bent.hip),
            (axis(&bent.thigh, 2), bent.knee),
            (axis(&bent.shank, 2), bent.ankle),
            (axis(&bent.foot, 0), bent.ankle),
            (axis(&bent.foot, 2), ball),
        ];
        // Which six joints carry the pelvis: a raised heel takes the place of a shin at its limit.
        let used: [usize; 6] = if p.heel == 0.0 { [0, 1, 2, 3, 4, 5] } else { [0, 1, 2, 3, 5, 6] };
        let mut chain = Matrix6::zeros();
        for (c, &j) in used.iter().enumerate() {
            let (a, o) = all[j];
            // From the pelvis to the ground: the ground moves by a x (ground - o).
            chain.fixed_view_mut::<3, 1>(0, c).copy_from(&a.cross(&(at - o)));
            chain.fixed_view_mut::<3, 1>(3, c).copy_from(&a);
        }
        // A straight leg cannot follow every motion of the pelvis: the nearest that it can.
        let rates = if p.knee.abs() < STRAIGHT_RAD {
            let gram = chain * chain.transpose() + Matrix6::identity() * STRAIGHT_DAMPING;
            chain.transpose() * gram.lu().solve(&(-columns))?
        } else {
            chain.lu().solve(&(-columns))?
        };
        let mut out = [Vector6::zeros(); 7];
        for (r, &j) in used.iter().enumerate() {
            out[j] = rates.row(r).transpose();
        }
        Some(out)
    }
}

fn about_x(Turn { sin: s, cos: c }: Turn) -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

fn about_y(Turn { sin: s, cos: c }: Turn) -> Matrix3<f64> {
    Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

fn about_z(Turn { sin: s, cos: c }: Turn) -> Matrix3<f64> {
    Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Coupled, Hands, Pelvis, pelvis_in_rest};

    #[test]
    fn bounds_change_with_the_pelvis_as_finite_differences_say() {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let legs = Legs::new(&body, Stance::Standing { shoe_m: 0.03 }).unwrap();
        let coupled = Coupled { hands: Hands::Right, pelvis: Pelvis::Moves };
        let chain = body.chain(coupled, &["Pelvis"]).unwrap();
        let rows = |six: &[f64; 6]| {
            let mut q = vec![0.0; chain.dof()];
            q[..6].copy_from_slice(six);
            let mut frames = Frames::default();
            chain.forward(&q, &mut frames);
            let (at, turn) = chain.tip_frame(&frames, 1);
            let pose = pelvis_in_rest(six, body.leg_m());
            assert!((pose.translation.vector - at).norm() < 1e-12);
            let mut rows = Vec::new();
            let columns = chain.leading_columns(&frames, 1, 6);
            legs.rows((&at, &legs.bending(&at, &turn)), &columns, 9.0, &mut rows);
            rows
        };
        // Flat feet, and shins at their limit with raised heels.
        for six in [[-0.22, -0.15, 0.04, -0.6, 0.1, 0.2], [-0.05, -0.42, 0.02, -0.4, 0.05, -0.1]] {
            let here = rows(&six);
            assert!(here.len() >= 14, "{}", here.len());
            for c in 0..6 {
                let step = 1e-6;
                let (mut up, mut down) = (six, six);
                up[c] += step;
                down[c] -= step;
                let pairs = rows(&up).into_iter().zip(rows(&down));
                for (i, (row, (up, down))) in here.iter().zip(pairs).enumerate() {
                    let slope = (up.at - down.at) / (2.0 * step);
                    let found = row.coefficients[c];
                    assert!(
                        (slope - found).abs() < 1e-2 * (1.0 + slope.abs()),
                        "{six:?} row {i} column {c}: {slope} {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_heel_rises_as_little_as_the_ankle_needs() {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let legs = Legs::new(&body, Stance::Standing { shoe_m: 0.03 }).unwrap();
        let leg = &legs.sides[0];
        let most = leg.ranges[4].1;
        let (mut flat, mut raised) = (0, 0);
        for i in 0..400 {
            // Forward, up and right of where the hip is upright, m.
            let part = |step: i32| f64::from(i * step % 400) / 400.0;
            let hip =
                leg.hip + Vec3::new(0.5 * part(7) - 0.3, -0.6 * part(13), 0.2 * part(19) - 0.1);
            let turn = Matrix3::identity();
            let bent = leg.solve(&(hip - leg.hip), &turn);
            let posture = bent.posture;
            if posture.heel == 0.0 {
                assert!(posture.ankle[0] <= most, "{i}: {posture:?}");
                flat += 1;
            } else if posture.heel < leg.ranges[6].1 {
                assert!((posture.ankle[0] - most).abs() < 1e-8, "{i}: {posture:?}");
                // Any less bends the ankle too far, told by the angles of the triangle.
                for less in [0.0, 0.5 * posture.heel, 0.99 * posture.heel] {
                    let foot = leg.foot * about_z(Turn::of(-less));
                    let ankle = leg.ankle + leg.foot * leg.ball - foot * leg.ball;
                    let r = foot.tr_mul(&(hip - ankle));
                    let (a, s, d) = (leg.thigh_m, leg.shank_m, r.norm());
                    let inner = ((d * d + s * s - a * a) / (2.0 * d * s)).clamp(-1.0, 1.0).acos();
                    assert!(r.x.atan2(r.y.hypot(r.z)) + inner > most, "{i}: {less}");
                }
                raised += 1;
            }
        }
        assert!(flat > 50 && raised > 50, "{flat} {raised}");
    }

    #[test]
    fn feet_of_who_sits_stand_on_floor_or_rest_or_hang() {
        let body = Body::load("female_p05", std::path::Path::new(".")).unwrap();
        let seated = |seat_height_m: f64, footrest_m: f64| {
            Legs::new(&body, Stance::Seated { seat_height_m, footrest_m }).unwrap()
        };
        let (low, high, rest) = (seated(0.38, 0.0), seated(0.55, 0.0), seated(0.55, 0.2));
        assert!(!low.hang() && high.hang() && !rest.hang());
        for legs in [&low, &high, &rest] {
            let [right, left] = legs.postures(&Pose::identity());
            assert!(right.short_m == 0.0 && right.heel == 0.0);
            assert!((right.knee - left.knee).abs() < 1e-9);
            assert!((60.0..115.0).contains(&-right.knee.to_degrees()), "{right:?}");
        }
    }
}

//! Where people stand for what their hand does, and when they step.
//!
//! The place of the hand seen from the feet, ahead and to the right over stature, is Gaussian, with a mean that
//! goes by the height `y` of the hand (both in the rest frame, over stature):
//!
//! ```text
//! place = at + by_height y + p + m       p ~ N(0, of_people),  m ~ N(0, of_movements)
//! ```
//! `p` is a person's own, `m` differs from one standing place to the next. Where the hand goes farther from what
//! is usual than recorded people let it (Mahalanobis distance by `of_movements`), the feet are set anew, so that
//! the hand is where it usually is: for the end of its way, or as far on that way as one stride and the place at
//! which the hand is then allow. They turn with the hand as far as the robot turns it about the vertical.
//!
//! The recorded places are those of the movement's far ends; nothing was recorded of the way there, so that
//! stride, duration, and the turn that makes a person step are assumed.

use super::coupling::Hold;
use super::grips::Grips;
use crate::math::stream::normals;
use crate::math::{Pose, Vec3};
use crate::physical::OVER_STATURE;
use nalgebra::{Matrix2, UnitQuaternion, Vector2};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Duration of a step, s (assumed).
pub const STEP_S: f64 = 0.5;
/// Longest way of the feet in one step over stature (assumed: 0.7 m of somebody who is 1.75 m tall).
const STRIDE: f64 = 0.4;
/// Turn of the hand beyond which the feet turn with it, rad (assumed).
const TURN: f64 = std::f64::consts::FRAC_PI_4;
/// Ways of the feet that are no step: over stature, and rad.
const SHUFFLE: f64 = 0.03;
const SHUFFLE_RAD: f64 = 0.1;
/// 90 % quantile of chi-squared with two degrees of freedom.
const CHI_SQUARED_90: f64 = 4.605_170_186;
/// A bar is near upright where less of it than this is level: it tells nothing of a turn.
const LEVEL: f64 = 0.3;

/// Where recorded people stood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StandingPlace {
    /// Mean place of the hand (ahead, to the right) at height 0, over stature.
    pub at: [f64; 2],
    /// Its change with the height.
    pub by_height: [f64; 2],
    /// Lowest and highest recorded place, over stature: beyond, the mean is that of the nearest.
    pub heights: [f64; 2],
    /// Covariance of people's own means, 2 x 2.
    pub of_people: [[f64; 2]; 2],
    /// Covariance of movements about their person's mean, 2 x 2, positive definite.
    pub of_movements: [[f64; 2]; 2],
    /// Distance from the person's mean within which 95 % of the movements were.
    pub farthest: f64,
    /// How many movements it was learned from.
    pub movements: usize,
    /// How many people these are of.
    pub people: usize,
}

impl StandingPlace {
    /// Mean place at a height, over stature.
    fn mean(&self, height: f64) -> Vector2<f64> {
        let y = height.clamp(self.heights[0], self.heights[1]);
        Vector2::from_fn(|i, _| self.at[i] + self.by_height[i] * y)
    }

    /// How far a place of the hand (ahead, to the right) is from where people have it at a height, all over
    /// stature; and whether it is within what 90 % of the movements of anybody are.
    pub fn off(&self, place: Vector2<f64>, height: f64) -> (Vector2<f64>, bool) {
        let off = place - self.mean(height);
        let anybody = matrix(self.of_people) + matrix(self.of_movements);
        let square =
            anybody.try_inverse().map_or(f64::INFINITY, |inverse| (inverse * off).dot(&off));
        (off, square <= CHI_SQUARED_90)
    }

    /// Why a model with it cannot be used; none where it can.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let [people, movements] = [self.of_people, self.of_movements].map(matrix);
        let places = [self.at, self.by_height, self.heights].concat();
        // Of people it may be singular, but no variance is negative.
        let least = people.symmetric_eigen().eigenvalues.min();
        let is_fine = OVER_STATURE.outside(places).is_none()
            && [people, movements]
                .iter()
                .all(|m| OVER_STATURE.outside(m.iter().copied()).is_none())
            && self.of_people[0][1] == self.of_people[1][0]
            && self.of_movements[0][1] == self.of_movements[1][0]
            && least >= -1e-6
            && self.heights[0] <= self.heights[1]
            && (1e-3..1e3).contains(&self.farthest)
            && self.people > 0
            && self.movements > 0
            && movements.cholesky().is_some();
        (!is_fine).then_some("the standing place holds a range or covariance that cannot be")
    }
}

fn matrix(rows: [[f64; 2]; 2]) -> Matrix2<f64> {
    Matrix2::new(rows[0][0], rows[0][1], rows[1][0], rows[1][1])
}

/// A factor `F` with `F F^T` the covariance, which may be singular.
fn root(covariance: Matrix2<f64>) -> Matrix2<f64> {
    let eigen = covariance.symmetric_eigen();
    let scales = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    eigen.eigenvectors * Matrix2::from_diagonal(&scales)
}

/// Where the feet are, seen from where the scenario has them (rest frame).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Footing {
    /// Ahead, m.
    pub ahead_m: f64,
    /// To the right, m.
    pub right_m: f64,
    /// Turn to the left, rad.
    pub turn: f64,
}

impl Footing {
    /// The rest frame there, seen from the scenario's.
    pub fn pose(&self) -> Pose {
        let turn = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), self.turn);
        Pose::from_parts(Vec3::new(self.ahead_m, 0.0, self.right_m).into(), turn)
    }

    /// In the mirror image.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { right_m: -self.right_m, turn: -self.turn, ..self }
    }

    /// Mean of some; where there are none, the scenario's.
    pub fn mean(all: impl Iterator<Item = Self>) -> Self {
        let (mut sum, mut count) = (Self::default(), 0.0);
        for f in all {
            sum.ahead_m += f.ahead_m;
            sum.right_m += f.right_m;
            sum.turn += f.turn;
            count += 1.0;
        }
        let count = f64::max(count, 1.0);
        Self { ahead_m: sum.ahead_m / count, right_m: sum.right_m / count, turn: sum.turn / count }
    }

    /// Part of the way to another.
    fn on_the_way(&self, to: &Self, part: f64) -> Self {
        let between = |a: f64, b: f64| a + part * (b - a);
        Self {
            ahead_m: between(self.ahead_m, to.ahead_m),
            right_m: between(self.right_m, to.right_m),
            turn: between(self.turn, to.turn),
        }
    }

    fn distance_m(&self, other: &Self) -> f64 {
        (self.ahead_m - other.ahead_m).hypot(self.right_m - other.right_m)
    }
}

/// The feet of one repetition.
#[derive(Debug, Clone, PartialEq)]
pub struct Feet {
    /// At each sample of the path.
    pub at: Vec<Footing>,
    /// When each step begins, s since the start of the path.
    pub steps_s: Vec<f64>,
    /// How far the feet go in all steps together, m.
    pub way_m: f64,
}

impl Feet {
    /// Whether they are on their way at a time since the start, s.
    pub fn steps_at(&self, time_s: f64) -> bool {
        self.steps_s.iter().any(|from| (*from..from + STEP_S).contains(&time_s))
    }

    /// Whether they are elsewhere than the scenario has them when the movement starts.
    pub fn start_elsewhere(&self) -> bool {
        self.at.first().is_some_and(|f| *f != Footing::default())
    }
}

/// Somebody who steps.
#[derive(Debug, Clone)]
pub struct Stepper<'a> {
    place: &'a StandingPlace,
    inverse: Matrix2<f64>,
    stature_m: f64,
    /// Both hands are led: what counts is midway between them.
    is_both: bool,
}

/// What one repetition draws of its standing places.
#[derive(Debug, Clone)]
pub struct StandingDraw {
    own: Vector2<f64>,
    /// Of the standing places one after the other; the last serves all others.
    places: Vec<Vector2<f64>>,
}

/// Standing places that are drawn for a repetition.
const PLACES: usize = 8;

impl<'a> Stepper<'a> {
    /// Somebody of a stature (m); none where the movements do not tell the spread of the place.
    pub fn new(place: &'a StandingPlace, stature_m: f64, is_both: bool) -> Option<Self> {
        let inverse = matrix(place.of_movements).try_inverse()?;
        Some(Self { place, inverse, stature_m, is_both })
    }

    /// Of how many movements and people the standing place was learned.
    pub fn learned_from(&self) -> (usize, usize) {
        (self.place.movements, self.place.people)
    }

    /// The mean of all people, without chance.
    pub fn surely(&self) -> StandingDraw {
        StandingDraw { own: Vector2::zeros(), places: vec![Vector2::zeros()] }
    }

    /// What differs in one repetition, by a person who draws what is their own from another stream; none where
    /// every repetition is by somebody else.
    pub fn draw(&self, rng: &mut ChaCha8Rng, person: Option<&mut ChaCha8Rng>) -> StandingDraw {
        let [people, movements] =
            [self.place.of_people, self.place.of_movements].map(|c| root(matrix(c)));
        let normal = |rng: &mut ChaCha8Rng| {
            let z = normals(rng, 2);
            Vector2::new(z[0], z[1])
        };
        let alone = normal(rng);
        let own = people * person.map_or(alone, normal);
        StandingDraw { own, places: (0..PLACES).map(|_| movements * normal(rng)).collect() }
    }

    /// Place (ahead, right) and height of what the robot leads, seen from some feet; over stature.
    fn seen(&self, hand: &Vec3, feet: &Footing) -> (Vector2<f64>, f64) {
        let there = feet.pose().inverse() * nalgebra::Point3::from(*hand);
        (Vector2::new(there.x, there.z) / self.stature_m, there.y / self.stature_m)
    }

    /// Where the hand usually is seen from the feet; of both hands what is midway is in the middle.
    fn usual(&self, height: f64) -> Vector2<f64> {
        let mean = self.place.mean(height);
        if self.is_both { Vector2::new(mean.x, 0.0) } else { mean }
    }

    /// How far the hand is from where this person usually has it.
    fn distance(&self, hand: &Vec3, feet: &Footing, drawn: &StandingDraw) -> f64 {
        let (place, height) = self.seen(hand, feet);
        let off = place - self.usual(height) - drawn.own;
        (self.inverse * off).dot(&off).max(0.0).sqrt()
    }

    /// The feet, turned so, for a hand.
    fn feet_for(&self, hand: &Vec3, turn: f64, drawn: &StandingDraw, number: usize) -> Footing {
        let last = drawn.places.len() - 1;
        let place =
            self.usual(hand.y / self.stature_m) + drawn.own + drawn.places[number.min(last)];
        let away = Footing { turn, ..Footing::default() }.pose()
            * Vec3::new(place.x, 0.0, place.y)
            * self.stature_m;
        Footing { ahead_m: hand.x - away.x, right_m: hand.z - away.z, turn }
    }

    /// Where the feet are along times (s) and as many grips in the rest frame of the scenario's standing
    /// place; none where they stay there. Steps are also made at the times in `forced`, s since the start.
    pub fn feet(
        &self,
        (time_s, grips): (&[f64], &[Grips]),
        hold: Hold,
        drawn: &StandingDraw,
        forced: &[f64],
    ) -> Option<Feet> {
        let last = grips.len().checked_sub(1)?;
        let way = Way {
            since: time_s.iter().map(|t| t - time_s[0]).collect(),
            hands: grips.iter().map(led).collect(),
            turns: turns(grips, hold),
        };
        let mut found = Feet { at: Vec::new(), steps_s: Vec::new(), way_m: 0.0 };
        let mut feet = Footing::default();
        let mut placed = 0;
        let mut forced = forced.iter().copied().peekable();
        let at_once = forced.next_if(|t| *t <= 0.0).is_some();
        // Nobody starts from where nobody would stand.
        if at_once || self.distance(&way.hands[0], &feet, drawn) > self.place.farthest {
            feet = self.feet_for(&way.hands[0], 0.0, drawn, placed);
            placed += 1;
        }
        let mut k = 0;
        while k <= last {
            let is_forced = forced.next_if(|t| *t <= way.since[k]).is_some();
            let next = (k < last && (is_forced || !self.stays(&way, k, &feet, drawn)))
                .then(|| self.next(&way, k, &feet, (drawn, placed)))
                .filter(|(next, _)| self.is_step(&feet, next));
            let Some((next, done)) = next else {
                found.at.push(feet);
                k += 1;
                continue;
            };
            placed += 1;
            found.steps_s.push(way.since[k]);
            found.way_m += next.distance_m(&feet);
            for i in k..done {
                let s = ((way.since[i] - way.since[k]) / STEP_S).clamp(0.0, 1.0);
                // Minimum jerk.
                let part = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
                found.at.push(feet.on_the_way(&next, part));
            }
            (feet, k) = (next, done);
        }
        (!found.steps_s.is_empty() || found.start_elsewhere()).then_some(found)
    }

    /// Where the mean person's feet are with some grips, having come from others at the start.
    pub fn stands(&self, start: &Grips, there: &Grips, hold: Hold) -> Footing {
        let (drawn, feet) = (self.surely(), Footing::default());
        let way = Way {
            since: vec![0.0; 2],
            hands: vec![led(start), led(there)],
            turns: turns(&[*start, *there], hold),
        };
        if self.stays(&way, 1, &feet, &drawn) {
            return feet;
        }
        self.feet_for(&way.hands[1], way.turns[1], &drawn, 0)
    }

    /// Whether somebody with the feet there would leave them there at a sample.
    fn stays(&self, way: &Way, k: usize, feet: &Footing, drawn: &StandingDraw) -> bool {
        self.distance(&way.hands[k], feet, drawn) <= self.place.farthest
            && (way.turns[k] - feet.turn).abs() <= TURN
    }

    /// Where a step from sample `k` leads, and the sample at which it is done.
    fn next(
        &self,
        way: &Way,
        k: usize,
        feet: &Footing,
        (drawn, placed): (&StandingDraw, usize),
    ) -> (Footing, usize) {
        let last = way.hands.len() - 1;
        let is_done = |i: &usize| way.since[*i] >= way.since[k] + STEP_S;
        let done = (k + 1..=last).find(is_done).unwrap_or(last);
        let to = |i: usize| self.feet_for(&way.hands[i], way.turns[i], drawn, placed);
        let serves = |next: &Footing| {
            next.distance_m(feet) <= STRIDE * self.stature_m && self.stays(way, done, next, drawn)
        };
        let next = (done..=last).rev().map(to).find(serves).unwrap_or_else(|| to(done));
        (next, done)
    }

    fn is_step(&self, from: &Footing, to: &Footing) -> bool {
        to.distance_m(from) >= SHUFFLE * self.stature_m
            || (to.turn - from.turn).abs() >= SHUFFLE_RAD
    }
}

/// What the robot leads along a path.
struct Way {
    /// Since the start, s.
    since: Vec<f64>,
    /// Rest frame, m.
    hands: Vec<Vec3>,
    /// About the vertical since the start, to the left, rad.
    turns: Vec<f64>,
}

/// What the robot leads: the hand, or midway between both.
fn led(grips: &Grips) -> Vec3 {
    let first = grips.first.translation.vector;
    grips.second.map_or(first, |second| 0.5 * (first + second.translation.vector))
}

/// Turn of the hand about the vertical since the start, to the left, rad; 0 where the robot does not
/// prescribe it.
fn turns(grips: &[Grips], hold: Hold) -> Vec<f64> {
    let mut sum = 0.0;
    let step = |from: &Grips, to: &Grips| match (hold, from.second, to.second) {
        (_, Some(a), Some(b)) => level_turn(across(from, &a), across(to, &b)),
        (Hold::Rigid, ..) => {
            let turn = to.first.rotation * from.first.rotation.inverse();
            2.0 * turn.j.atan2(turn.w)
        }
        (Hold::FreeRoll, ..) => level_turn(bar(from), bar(to)),
        (Hold::Point | Hold::Planar, ..) => 0.0,
    };
    let mut all = vec![0.0; grips.len().min(1)];
    for pair in grips.windows(2) {
        let by = step(&pair[0], &pair[1]);
        // A quaternion and its negative are one turn.
        sum += (by + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        all.push(sum);
    }
    all
}

/// From one hand to the other.
fn across(grips: &Grips, second: &Pose) -> Vec3 {
    let across = second.translation.vector - grips.first.translation.vector;
    across.try_normalize(1e-6).unwrap_or_else(Vec3::zeros)
}

fn bar(grips: &Grips) -> Vec3 {
    grips.first.rotation * Vec3::z()
}

/// Turn about the vertical from one direction to another; 0 where they are not level enough to tell.
fn level_turn(from: Vec3, to: Vec3) -> f64 {
    if from.x.hypot(from.z) < LEVEL || to.x.hypot(to.z) < LEVEL {
        return 0.0;
    }
    // About y up: x turns towards -z.
    (-to.z).atan2(to.x) - (-from.z).atan2(from.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};

    /// A hand usually 0.2 statures ahead, more when it is high; 5 cm of spread ahead and 15 to the side.
    fn place() -> StandingPlace {
        StandingPlace {
            at: [0.2, 0.1],
            by_height: [0.3, 0.0],
            heights: [-0.5, 0.5],
            of_people: [[4e-4, 0.0], [0.0, 1e-4]],
            of_movements: [[9e-4, 0.0], [0.0, 4e-3]],
            farthest: 2.4,
            movements: 60,
            people: 5,
        }
    }

    /// A hand on a level line at the height of the hips, in 4 s; `turn` at its end, to the left.
    fn line(from: [f64; 2], to: [f64; 2], turn: f64) -> (Vec<f64>, Vec<Grips>) {
        let at = |i: usize| {
            let s = i as f64 / 80.0;
            let place =
                Vec3::new(from[0] + s * (to[0] - from[0]), 0.0, from[1] + s * (to[1] - from[1]));
            let turned = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), s * turn);
            (4.0 * s, Grips::from(Pose::from_parts(place.into(), turned)))
        };
        (0..=80).map(at).unzip()
    }

    fn feet(
        path: &(Vec<f64>, Vec<Grips>),
        number: Option<u32>,
        forced: &[f64],
    ) -> (Option<Feet>, StandingDraw) {
        let place = place();
        let stepper = Stepper::new(&place, 1.75, false).unwrap();
        let drawn = match number {
            Some(r) => stepper.draw(&mut stream(7, Purpose::Posture, 0, r), None),
            None => stepper.surely(),
        };
        (stepper.feet((&path.0, &path.1), Hold::Rigid, &drawn, forced), drawn)
    }

    #[test]
    fn feet_stay_while_the_hand_is_where_people_have_it() {
        let path = line([0.35, 0.1], [0.35, 0.3], 0.0);
        assert_eq!(feet(&path, None, &[]).0, None);
    }

    #[test]
    fn a_hand_that_goes_far_is_followed_and_ends_where_it_usually_is() {
        let path = line([0.35, 0.175], [0.35, 1.4], 0.0);
        let (found, _) = feet(&path, None, &[]);
        let found = found.unwrap();
        assert!(!found.start_elsewhere() && found.at.len() == 81);
        // 1.2 m are two strides of 0.7 m.
        assert_eq!(found.steps_s.len(), 2, "{found:?}");
        let end = found.at[80];
        assert!((end.ahead_m - 0.0).abs() < 1e-9 && (end.right_m - 1.225).abs() < 1e-9, "{end:?}");
        // Nobody draws feet through space: between samples they go less than a stride at its fastest.
        let fastest = 0.7 * 1.875 / STEP_S * 0.05;
        for pair in found.at.windows(2) {
            assert!(pair[0].distance_m(&pair[1]) <= fastest + 1e-9);
        }
    }

    #[test]
    fn outside_steps_the_hand_is_never_farther_than_recorded_people_let_it() {
        let place = place();
        let stepper = Stepper::new(&place, 1.75, false).unwrap();
        for r in 0..40 {
            let path = line([0.35, 0.175], [0.9, -0.8], 0.0);
            let (found, drawn) = feet(&path, Some(r), &[]);
            let found = found.unwrap();
            let stepping =
                |t: f64| found.steps_s.iter().any(|s| (*s..s + STEP_S + 0.05).contains(&t));
            for (k, (t, hand)) in path.0.iter().zip(&path.1).enumerate().take(80) {
                let off = stepper.distance(&led(hand), &found.at[k], &drawn);
                assert!(stepping(*t) || off <= place.farthest, "{r}: {off} at {t} s");
            }
        }
    }

    #[test]
    fn feet_turn_with_the_hand_only_where_the_robot_turns_it() {
        let path = line([0.35, 0.175], [0.35, 0.175], 1.4);
        let turned = feet(&path, None, &[]).0.unwrap();
        assert!((turned.at[80].turn - 1.4).abs() < 1e-9, "{turned:?}");
        let place = place();
        let stepper = Stepper::new(&place, 1.75, false).unwrap();
        let free = stepper.feet((&path.0, &path.1), Hold::Point, &stepper.surely(), &[]);
        assert_eq!(free, None);
        // A bar that is turned about itself turns nobody; one that is turned across does.
        let across = |pose: &Grips| {
            let lying = UnitQuaternion::rotation_between(&Vec3::z(), &Vec3::x()).unwrap();
            pose.map(|p| Pose::from_parts(p.translation, p.rotation * lying))
        };
        let bar: Vec<Grips> = path.1.iter().map(across).collect();
        let by_bar = turns(&bar, Hold::FreeRoll);
        assert!((by_bar[80] - 1.4).abs() < 1e-9, "{by_bar:?}");
    }

    #[test]
    fn who_would_not_stand_there_starts_elsewhere_and_is_forced_to_step() {
        let path = line([1.2, 0.175], [1.2, 0.175], 0.0);
        let found = feet(&path, None, &[]).0.unwrap();
        assert!(found.start_elsewhere() && found.steps_s.is_empty());
        assert!((found.at[0].ahead_m - 0.85).abs() < 1e-9, "{:?}", found.at[0]);
        // Within what people let it, but out of reach at 2 s, as somebody found out.
        let path = line([0.35, 0.175], [0.35, 0.4], 0.0);
        let found = feet(&path, None, &[1.5]).0.unwrap();
        assert_eq!(found.steps_s, [1.5]);
    }

    #[test]
    fn the_draws_spread_as_the_model_says() {
        let place = place();
        let stepper = Stepper::new(&place, 1.75, false).unwrap();
        let drawn: Vec<StandingDraw> =
            (0..4000).map(|r| stepper.draw(&mut stream(1, Purpose::Posture, 3, r), None)).collect();
        let variance = |of: &dyn Fn(&StandingDraw) -> f64| {
            drawn.iter().map(|d| of(d).powi(2)).sum::<f64>() / drawn.len() as f64
        };
        for (found, wanted) in [
            (variance(&|d| d.own.x), 4e-4),
            (variance(&|d| d.own.y), 1e-4),
            (variance(&|d| d.places[1].x), 9e-4),
            (variance(&|d| d.places[0].y), 4e-3),
        ] {
            assert!((found / wanted - 1.0).abs() < 0.1, "{found} {wanted}");
        }
    }
}

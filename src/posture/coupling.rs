//! A body whose hands hold on to the robot: chain, contacts, limits, and the rows of the task.

use super::grips::Grips;
use super::noise::ROTATION_LENGTH_M;
use super::step::Bounds;
use crate::files::InputError;
use crate::human::{Balance, Body, Coupled, Legs, Pelvis, PostureLimits, Side, Stance};
use crate::kinematics::{Frames, Linkage};
use crate::math::pose::pose_error;
use crate::math::{Pose, Vec3, Vec6};
use nalgebra::{DMatrix, DVector, Matrix6, Matrix6xX, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// How fast somebody who is out of balance comes back, m of the centre of mass in one step.
const RECOVERY_M: f64 = 0.004;

/// Which motions of the hand the robot prescribes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// Position and orientation: 6 rows.
    Rigid,
    /// All but the rotation about the held bar (grip z): 5 rows.
    FreeRoll,
    /// Position only: 3 rows.
    Point,
    /// Position in the base's x-y plane: 2 rows. For planar chains; not for scenarios.
    #[serde(skip)]
    Planar,
}

impl Hold {
    /// Number of task rows.
    pub fn rows(self) -> usize {
        match self {
            Self::Rigid => 6,
            Self::FreeRoll => 5,
            Self::Point => 3,
            Self::Planar => 2,
        }
    }

    /// How many of the rows are displacements; the others are rotations.
    pub fn linear_rows(self) -> usize {
        self.rows().min(3)
    }
}

/// A body whose hands are coupled to the robot, and what holds the rest of it.
///
/// Every contact prescribes something. What the hands prescribe are the rows of the task; feet and a seat
/// leave less of the body to be predicted: the legs follow from the pelvis, and a pelvis on a seat only
/// turns.
#[derive(Debug, Clone)]
pub struct Coupling {
    chain: Linkage,
    limits: PostureLimits,
    /// Of each hand, in the order of the chain's tips.
    holds: Vec<Hold>,
    /// Legs on their feet under a pelvis that moves or turns.
    ground: Option<Ground>,
    stature_m: f64,
}

/// What the feet ask of the pelvis.
#[derive(Debug, Clone)]
struct Ground {
    legs: Legs,
    pelvis: Pelvis,
    /// Tip that is the pelvis.
    tip: usize,
    /// Of somebody who stands.
    balance: Option<Balance>,
}

/// Where the hands are and how the joints move them.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Grips in the rest frame.
    pub grips: Grips,
    /// Task Jacobian, m x n: the displacements of all hands, then their rotations.
    pub jacobian: DMatrix<f64>,
    /// Scratch: all six rows of one hand.
    full: Matrix6xX<f64>,
}

impl Coupling {
    /// Couples one hand of a body whose pelvis rests.
    pub fn new(body: &Body, side: Side, hold: Hold) -> Result<Self, InputError> {
        let chain = body.arm(side)?;
        let limits = body.limits(&chain);
        let (holds, stature_m) = (vec![hold], body.size.stature_m);
        Ok(Self { chain, limits, holds, ground: None, stature_m })
    }

    /// Couples the hands of a body: one hold for each, the leading hand first. `load_kg` is carried in the
    /// grips together.
    ///
    /// # Errors
    /// Where the body's legs are not straight at zero angles.
    ///
    /// # Panics
    /// When there are not as many holds as hands.
    pub fn of_person(
        body: &Body,
        coupled: Coupled,
        holds: &[Hold],
        (stance, load_kg): (Stance, f64),
    ) -> Result<Self, InputError> {
        assert_eq!(holds.len(), coupled.hands.sides().len(), "one hold for each hand");
        let (holds, stature_m) = (holds.to_vec(), body.size.stature_m);
        if coupled.pelvis == Pelvis::Rests {
            let chain = body.chain(coupled, &[])?;
            let limits = body.limits(&chain);
            return Ok(Self { chain, limits, holds, ground: None, stature_m });
        }
        let links = Balance::links(coupled);
        let names: Vec<&str> = links.iter().map(String::as_str).collect();
        let chain = body.chain(coupled, &names)?;
        let limits = body.limits(&chain);
        let legs = Legs::new(body, stance)?;
        let balance = if legs.is_standing() {
            Some(Balance::new(body, coupled, (&chain, &legs), load_kg)?)
        } else {
            None
        };
        let ground = Ground { legs, pelvis: coupled.pelvis, tip: holds.len(), balance };
        Ok(Self { chain, limits, holds, ground: Some(ground), stature_m })
    }

    /// A chain on its own, with the joint limits of its model.
    ///
    /// Lengths are compared as they are: the stature is 1.
    pub fn of_chain(chain: Linkage, hold: Hold) -> Self {
        let limits = PostureLimits {
            lower: chain.joints().iter().map(|j| j.lower).collect(),
            upper: chain.joints().iter().map(|j| j.upper).collect(),
            sums: Vec::new(),
        };
        Self { chain, limits, holds: vec![hold], ground: None, stature_m: 1.0 }
    }

    /// Which motions of the leading hand are prescribed.
    pub fn hold(&self) -> Hold {
        self.holds[0]
    }

    /// Number of rows of the task, m.
    pub fn rows(&self) -> usize {
        self.holds.iter().map(|h| h.rows()).sum()
    }

    /// How many of the rows are displacements; they come first.
    pub fn linear_rows(&self) -> usize {
        self.holds.iter().map(|h| h.linear_rows()).sum()
    }

    /// Whether somebody who stands is in balance at the posture of `frames`; others are.
    pub(super) fn is_balanced(&self, frames: &Frames) -> bool {
        self.margin_at(frames).is_none_or(|m| m > 0.0)
    }

    /// How far the centre of mass of somebody who stands is inside the feet at `q` (n, rad, leg lengths), m;
    /// negative outside.
    pub fn margin_m(&self, q: &DVector<f64>, frames: &mut Frames) -> Option<f64> {
        self.chain.forward(q.as_slice(), frames);
        self.margin_at(frames)
    }

    fn margin_at(&self, frames: &Frames) -> Option<f64> {
        let ground = self.ground.as_ref()?;
        let balance = ground.balance.as_ref()?;
        let (at, turn) = self.chain.tip_frame(frames, ground.tip);
        let bending = ground.legs.bending(&at, &turn);
        let centre = balance.centre((&self.chain, frames), (&ground.legs, &bending));
        Some(balance.margin_m(&centre, Legs::heel(&bending)))
    }

    /// Number of joints of the chain, n: with the free coordinates of the pelvis.
    pub fn dof(&self) -> usize {
        self.chain.dof()
    }

    /// Names of the joints, in order.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.chain.joints().iter().map(|j| j.name.as_str())
    }

    /// Limits of the chain.
    pub fn limits(&self) -> &PostureLimits {
        &self.limits
    }

    /// Stature of the body, m.
    pub fn stature_m(&self) -> f64 {
        self.stature_m
    }

    /// Pose of the grips and the task Jacobian at `q` (n, rad, leg lengths).
    pub fn observe(&self, q: &DVector<f64>, frames: &mut Frames) -> Observation {
        let n = self.dof();
        let none = Pose::identity();
        let mut seen = Observation {
            grips: Grips { first: none, second: (self.holds.len() > 1).then_some(none) },
            jacobian: DMatrix::zeros(self.rows(), n),
            full: Matrix6xX::zeros(n),
        };
        self.observe_again(q, frames, &mut seen);
        seen
    }

    /// The same written over another observation of this chain.
    pub(super) fn observe_again(
        &self,
        q: &DVector<f64>,
        frames: &mut Frames,
        seen: &mut Observation,
    ) {
        self.chain.forward(q.as_slice(), frames);
        let Observation { grips, jacobian: rows, full } = seen;
        let (mut linear_at, mut angular_at) = (0, self.linear_rows());
        for (tip, hold) in self.holds.iter().enumerate() {
            self.chain.jacobian_into(frames, tip, full);
            let pose = self.chain.tip_pose(frames, tip);
            let linear = hold.linear_rows();
            match hold {
                Hold::Rigid if self.holds.len() == 1 => {
                    rows.as_mut_slice().copy_from_slice(full.as_slice());
                }
                Hold::Rigid => {
                    rows.rows_mut(linear_at, 3).copy_from(&full.fixed_rows::<3>(0));
                    rows.rows_mut(angular_at, 3).copy_from(&full.fixed_rows::<3>(3));
                }
                Hold::FreeRoll => {
                    rows.rows_mut(linear_at, linear).copy_from(&full.rows(0, linear));
                    let angular = full.fixed_rows::<3>(3);
                    for (i, axis) in grip_cross_axes(&pose).iter().enumerate() {
                        rows.row_mut(angular_at + i).copy_from(&(axis.transpose() * angular));
                    }
                }
                Hold::Point | Hold::Planar => {
                    rows.rows_mut(linear_at, linear).copy_from(&full.rows(0, linear));
                }
            }
            linear_at += linear;
            angular_at += hold.rows() - linear;
            if tip == 0 {
                grips.first = pose;
            } else {
                grips.second = Some(pose);
            }
        }
    }

    /// How far the grips go when the posture of `frames` changes by `change` (n, rad, leg lengths), beyond
    /// `jacobian . change` and to second order: m and rad in task rows.
    pub(super) fn curvature(
        &self,
        frames: &Frames,
        seen: &Observation,
        change: &DVector<f64>,
    ) -> DVector<f64> {
        let of = |((tip, pose), hold): ((usize, &Pose), &Hold)| {
            let (bias, turn) = self.chain.bias_acceleration(frames, tip, change.as_slice());
            let mut beyond = 0.5 * bias;
            if *hold == Hold::FreeRoll {
                // The bar's direction alone is compared, and it is carried on by what rolls about it.
                let bar = pose.rotation * Vec3::z();
                let carried = 0.5 * turn.dot(&bar) * bar.cross(&turn);
                for i in 0..3 {
                    beyond[3 + i] += carried[i];
                }
            }
            (beyond, *pose)
        };
        let hands: Vec<(Vec6, Pose)> =
            seen.grips.iter().enumerate().zip(&self.holds).map(of).collect();
        self.task_part(&hands)
    }

    /// Bounds of legs and balance within `near` (m or rad) of the posture of `frames`, and by how much the
    /// legs are beyond theirs (m, rad).
    pub fn bounds(&self, frames: &Frames, near: f64, bounds: &mut Bounds) -> (f64, f64) {
        bounds.clear();
        let Some(ground) = &self.ground else { return (0.0, 0.0) };
        let (at, turn) = self.chain.tip_frame(frames, ground.tip);
        let free = ground.pelvis.free();
        let columns = ground.columns(&self.chain, frames);
        let mut legs = Vec::new();
        let bending = ground.legs.bending(&at, &turn);
        ground.legs.rows((&at, &bending), &columns, near, &mut legs);
        for row in &legs {
            bounds.push(&row.coefficients[6 - free..], row.at, (row.lower, row.upper));
        }
        if let Some(balance) = &ground.balance {
            let centre = balance.centre((&self.chain, frames), (&ground.legs, &bending));
            let edge = (Legs::heel(&bending), 0.25 * near);
            for row in balance.rows((&self.chain, frames), &centre, edge) {
                // Who is out of balance comes back step by step.
                let upper = row.upper.max(row.at - RECOVERY_M);
                bounds.push(&row.coefficients, row.at, (f64::NEG_INFINITY, upper));
            }
        }
        ground.legs.excess(&bending)
    }

    /// By how much the legs are beyond their bounds at the posture of `frames`, m and rad.
    pub(super) fn legs_beyond(&self, frames: &Frames) -> (f64, f64) {
        let Some(ground) = &self.ground else { return (0.0, 0.0) };
        let (at, turn) = self.chain.tip_frame(frames, ground.tip);
        ground.legs.excess(&ground.legs.bending(&at, &turn))
    }

    /// What the task prescribes of a twist or pose error of each hand given in base axes.
    fn task_part(&self, errors: &[(Vec6, Pose)]) -> DVector<f64> {
        let mut part = Vec::with_capacity(self.rows());
        for ((twist, _), hold) in errors.iter().zip(&self.holds) {
            part.extend_from_slice(&twist.as_slice()[..hold.linear_rows()]);
        }
        for ((twist, pose), hold) in errors.iter().zip(&self.holds) {
            let angular = Vec3::new(twist[3], twist[4], twist[5]);
            match hold {
                Hold::Rigid => part.extend_from_slice(angular.as_slice()),
                Hold::FreeRoll => {
                    part.extend(grip_cross_axes(pose).iter().map(|a| a.dot(&angular)));
                }
                Hold::Point | Hold::Planar => {}
            }
        }
        DVector::from_vec(part)
    }

    /// The hand pose at which the person's usual posture is looked up: what the robot does not
    /// prescribe of the orientation is taken as near to `usual` (the person's own) as it may be.
    pub(super) fn looked_up(
        &self,
        hand: usize,
        target: &Pose,
        usual: impl FnOnce() -> UnitQuaternion<f64>,
    ) -> Pose {
        let rotation = match self.holds[hand] {
            Hold::Rigid => target.rotation,
            Hold::FreeRoll => {
                // The twist about the bar of the rotation from the target to the usual orientation.
                let between = target.rotation.inverse() * usual();
                let roll = 2.0 * between.k.atan2(between.w);
                target.rotation * UnitQuaternion::from_axis_angle(&Vec3::z_axis(), roll)
            }
            Hold::Point | Hold::Planar => usual(),
        };
        Pose::from_parts(target.translation, rotation)
    }

    /// How far the hands travel from one place to another, m: what is prescribed of them, rotations
    /// counted at 0.3 m/rad; of two hands the root mean square.
    pub(super) fn travel_m(&self, from: &Grips, to: &Grips) -> f64 {
        let error = self.task_error(from, to);
        let linear = self.linear_rows();
        let both = error
            .rows(0, linear)
            .norm()
            .hypot(ROTATION_LENGTH_M * error.rows_range(linear..).norm());
        both / (self.holds.len() as f64).sqrt()
    }

    /// Error from some grips to others in task rows: m of all hands, then rad.
    ///
    /// With a free roll the angular part is the rotation that aligns the grip's z axes.
    pub fn task_error(&self, from: &Grips, to: &Grips) -> DVector<f64> {
        let of = |((from, to), hold): ((&Pose, &Pose), &Hold)| {
            let mut error = pose_error(from, to);
            if *hold == Hold::FreeRoll {
                let (a, b) = (from.rotation * Vec3::z(), to.rotation * Vec3::z());
                let turn = UnitQuaternion::rotation_between(&a, &b)
                    .map_or(Vec3::zeros(), |r| r.scaled_axis());
                error.fixed_rows_mut::<3>(3).copy_from(&turn);
            }
            (error, *from)
        };
        let errors: Vec<(Vec6, Pose)> =
            from.iter().zip(to.iter()).zip(&self.holds).map(of).collect();
        self.task_part(&errors)
    }
}

impl Ground {
    /// Twist of the pelvis by each of its six coordinates; zero for those that are not free.
    fn columns(&self, chain: &Linkage, frames: &Frames) -> Matrix6<f64> {
        let free = self.pelvis.free();
        let found = chain.leading_columns(frames, self.tip, free);
        let mut all = Matrix6::zeros();
        all.columns_mut(6 - free, free).copy_from(&found.columns(0, free));
        all
    }
}

/// The grip's x and y axes, about which the bar prescribes the rotation.
fn grip_cross_axes(pose: &Pose) -> [Vec3; 2] {
    [pose.rotation * Vec3::x(), pose.rotation * Vec3::y()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::Hands;
    use crate::math::stream::{Purpose, normals, stream};

    #[test]
    fn hands_bend_away_from_the_jacobian_as_differences_say() {
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        for hold in [Hold::Rigid, Hold::FreeRoll, Hold::Point] {
            let coupled = Coupled { hands: Hands::Both, pelvis: Pelvis::Moves };
            let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
            let coupling = Coupling::of_person(&body, coupled, &[hold, hold], standing).unwrap();
            let n = coupling.dof();
            let mut rng = stream(3, Purpose::Simulation, 9, 0);
            let q = DVector::from_vec(normals(&mut rng, n)) * 0.3;
            let along = DVector::from_vec(normals(&mut rng, n));
            let mut frames = Frames::default();
            let seen = coupling.observe(&q, &mut frames);
            // What is left is of third order: an eighth of it at half the way.
            let left = |h: f64| {
                let change = &along * h;
                let bent = coupling.curvature(&frames, &seen, &change);
                let there = coupling.observe(&(&q + &change), &mut Frames::default()).grips;
                let moved = coupling.task_error(&seen.grips, &there);
                let straight = &moved - &seen.jacobian * &change;
                ((&straight - &bent).norm(), straight.norm())
            };
            let ((far, bend), (near, _)) = (left(0.02), left(0.01));
            assert!(far < 0.15 * bend, "{hold:?}: {far} of {bend}");
            assert!((far / near - 8.0).abs() < 0.5, "{hold:?}: {far} {near}");
        }
    }
}

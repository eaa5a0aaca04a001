//! A body whose hand holds on to the robot: chain, limits, and the rows of the task.

use super::noise::ROTATION_LENGTH_M;
use crate::files::InputError;
use crate::human::{Body, PostureLimits, Side};
use crate::kinematics::{Frames, Linkage};
use crate::math::pose::pose_error;
use crate::math::{Pose, Vec3, Vec6};
use nalgebra::{DMatrix, DVector, Matrix6xX, UnitQuaternion};
use serde::{Deserialize, Serialize};

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

/// A body whose hand is coupled to the robot.
#[derive(Debug, Clone)]
pub struct Coupling {
    arm: Linkage,
    limits: PostureLimits,
    hold: Hold,
    stature_m: f64,
}

/// Where the hand is and how the joints move it.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Grip pose in the pelvis frame.
    pub pose: Pose,
    /// Task Jacobian, m x n.
    pub jacobian: DMatrix<f64>,
    /// Scratch: all six rows.
    full: Matrix6xX<f64>,
}

impl Coupling {
    /// Couples a body's hand.
    pub fn new(body: &Body, side: Side, hold: Hold) -> Result<Self, InputError> {
        let arm = body.arm(side)?;
        let limits = body.limits(&arm);
        Ok(Self { arm, limits, hold, stature_m: body.size.stature_m })
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
        Self { arm: chain, limits, hold, stature_m: 1.0 }
    }

    /// Which motions of the hand are prescribed.
    pub fn hold(&self) -> Hold {
        self.hold
    }

    /// Number of joints of the chain, n.
    pub fn dof(&self) -> usize {
        self.arm.dof()
    }

    /// Names of the joints, in order.
    pub fn joints(&self) -> impl Iterator<Item = &str> {
        self.arm.joints().iter().map(|j| j.name.as_str())
    }

    /// Limits of the chain.
    pub fn limits(&self) -> &PostureLimits {
        &self.limits
    }

    /// Stature of the body, m.
    pub fn stature_m(&self) -> f64 {
        self.stature_m
    }

    /// Pose of the grip and the task Jacobian at `q` (n, rad).
    pub fn observe(&self, q: &DVector<f64>, frames: &mut Frames) -> Observation {
        let n = self.dof();
        let mut seen = Observation {
            pose: Pose::identity(),
            jacobian: DMatrix::zeros(self.hold.rows(), n),
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
        self.arm.forward(q.as_slice(), frames);
        self.arm.jacobian_into(frames, 0, &mut seen.full);
        seen.pose = self.arm.tip_pose(frames, 0);
        let Observation { pose, jacobian: rows, full } = seen;
        let linear = self.hold.linear_rows();
        match self.hold {
            Hold::Rigid => rows.as_mut_slice().copy_from_slice(full.as_slice()),
            Hold::FreeRoll => {
                rows.rows_mut(0, linear).copy_from(&full.rows(0, linear));
                let angular = full.fixed_rows::<3>(3);
                for (i, axis) in grip_cross_axes(pose).iter().enumerate() {
                    rows.row_mut(3 + i).copy_from(&(axis.transpose() * angular));
                }
            }
            Hold::Point | Hold::Planar => rows.copy_from(&full.rows(0, linear)),
        }
    }

    /// What the task prescribes of a twist or pose error given in base axes.
    fn task_part(&self, twist: &Vec6, pose: &Pose) -> DVector<f64> {
        let mut part = Vec::with_capacity(self.hold.rows());
        part.extend_from_slice(&twist.as_slice()[..self.hold.linear_rows()]);
        let angular = Vec3::new(twist[3], twist[4], twist[5]);
        match self.hold {
            Hold::Rigid => part.extend_from_slice(angular.as_slice()),
            Hold::FreeRoll => part.extend(grip_cross_axes(pose).iter().map(|a| a.dot(&angular))),
            Hold::Point | Hold::Planar => {}
        }
        DVector::from_vec(part)
    }

    /// The hand pose at which the person's usual posture is looked up: what the robot does not
    /// prescribe of the orientation is taken as near to `usual` (the person's own) as it may be.
    pub(super) fn looked_up(&self, target: &Pose, usual: &UnitQuaternion<f64>) -> Pose {
        let rotation = match self.hold {
            Hold::Rigid => target.rotation,
            Hold::FreeRoll => {
                // The twist about the bar of the rotation from the target to the usual orientation.
                let between = target.rotation.inverse() * usual;
                let roll = 2.0 * between.k.atan2(between.w);
                target.rotation * UnitQuaternion::from_axis_angle(&Vec3::z_axis(), roll)
            }
            Hold::Point | Hold::Planar => *usual,
        };
        Pose::from_parts(target.translation, rotation)
    }

    /// How far the hand travels from one grip pose to another, m: what is prescribed of it, rotations
    /// counted at 0.3 m/rad.
    pub(super) fn travel_m(&self, from: &Pose, to: &Pose) -> f64 {
        let error = self.task_error(from, to);
        let linear = self.hold.linear_rows();
        error.rows(0, linear).norm().hypot(ROTATION_LENGTH_M * error.rows_range(linear..).norm())
    }

    /// Error from one grip pose to another in task rows: m, then rad.
    ///
    /// With a free roll the angular part is the rotation that aligns the grip's z axes.
    pub fn task_error(&self, from: &Pose, to: &Pose) -> DVector<f64> {
        let mut error = pose_error(from, to);
        if self.hold == Hold::FreeRoll {
            let (a, b) = (from.rotation * Vec3::z(), to.rotation * Vec3::z());
            let turn =
                UnitQuaternion::rotation_between(&a, &b).map_or(Vec3::zeros(), |r| r.scaled_axis());
            error.fixed_rows_mut::<3>(3).copy_from(&turn);
        }
        self.task_part(&error, from)
    }
}

/// The grip's x and y axes, about which the bar prescribes the rotation.
fn grip_cross_axes(pose: &Pose) -> [Vec3; 2] {
    [pose.rotation * Vec3::x(), pose.rotation * Vec3::y()]
}

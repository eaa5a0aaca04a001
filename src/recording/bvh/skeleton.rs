//! A skeleton of joints, and where they are under given values.
//!
//! All joints are parallel to the world in the zero pose, and a joint's place and turn are told from its
//! parent's:
//! ```text
//! G = G_parent M_1 M_2 M_3      start = start_parent + G_parent offset
//! ```
//! M: the turns about x, y and z in the order of the channels, so that the last one is done first.

use crate::math::Vec3;
use nalgebra::UnitQuaternion;

/// What one value of a frame does; 0, 1, 2 are x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    Move(usize),
    Turn(usize),
}

/// A joint, or the end of the last bone of a limb, which has neither name nor channels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Joint {
    pub name: String,
    /// Index of the joint before it; none of the root.
    pub parent: Option<usize>,
    /// From its parent in the zero pose, in the file's unit.
    pub offset: Vec3,
    /// What its values do, in their order.
    pub channels: Vec<Channel>,
    /// Place of its first value among those of a frame.
    pub first: usize,
    /// Whether its moves go on from the offset, rather than take its place.
    pub is_shift: bool,
}

/// Where a joint is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// In the file's unit.
    pub start: Vec3,
    /// Turn since the zero pose (G).
    pub turn: UnitQuaternion<f64>,
}

/// Joints, every one after its parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Skeleton {
    pub joints: Vec<Joint>,
}

impl Skeleton {
    /// Number of values in a frame.
    pub(super) fn dof(&self) -> usize {
        self.joints.iter().map(|j| j.channels.len()).sum()
    }

    /// A joint and those before it, up to the root.
    pub(super) fn upwards(&self, joint: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(joint), |j| self.joints[*j].parent)
    }

    /// Whether a joint hangs on another, or is that one.
    pub(super) fn hangs_on(&self, joint: usize, other: usize) -> bool {
        self.upwards(joint).any(|j| j == other)
    }

    /// Joints and ends that follow a joint at once.
    pub(super) fn children(&self, joint: usize) -> impl Iterator<Item = usize> {
        (joint + 1..self.joints.len()).filter(move |j| self.joints[*j].parent == Some(joint))
    }

    /// Every joint in the zero pose.
    pub(super) fn zero_pose(&self) -> Vec<Placed> {
        self.posed(|joint| (joint.offset, UnitQuaternion::identity()))
    }

    /// Every joint under the values of a frame: lengths in the file's unit, angles in rad.
    pub(super) fn place(&self, values: &[f64]) -> Vec<Placed> {
        self.posed(|joint| joint.moved(&values[joint.first..]))
    }

    /// Every joint, by its place and turn in its parent.
    fn posed(&self, local: impl Fn(&Joint) -> (Vec3, UnitQuaternion<f64>)) -> Vec<Placed> {
        let mut placed: Vec<Placed> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            let (offset, turn) = local(joint);
            placed.push(match joint.parent.map(|p| placed[p]) {
                Some(p) => Placed { start: p.start + p.turn * offset, turn: p.turn * turn },
                None => Placed { start: offset, turn },
            });
        }
        placed
    }
}

impl Joint {
    /// Place and turn in the parent under the joint's values.
    fn moved(&self, values: &[f64]) -> (Vec3, UnitQuaternion<f64>) {
        let axes = [Vec3::x_axis(), Vec3::y_axis(), Vec3::z_axis()];
        let mut offset = self.offset;
        let mut turn = UnitQuaternion::identity();
        for (channel, value) in self.channels.iter().zip(values) {
            match channel {
                Channel::Move(axis) if self.is_shift => offset[*axis] += value,
                Channel::Move(axis) => offset[*axis] = *value,
                Channel::Turn(axis) => {
                    turn *= UnitQuaternion::from_axis_angle(&axes[*axis], *value);
                }
            }
        }
        (offset, turn)
    }

    /// How far its moves lie from zero in a frame.
    pub(super) fn shift(&self, values: &[f64]) -> f64 {
        let values = self.channels.iter().zip(&values[self.first..]);
        let moves = values.filter(|(channel, _)| matches!(channel, Channel::Move(_)));
        moves.map(|(_, value)| value * value).sum::<f64>().sqrt()
    }
}

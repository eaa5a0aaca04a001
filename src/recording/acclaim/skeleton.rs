//! A skeleton of bones at rest, and where they are under given angles.
//!
//! The rest pose is given in world axes, so that the turn G of every bone is the identity there:
//! ```text
//! G = G_parent C M C^-1      start = start_parent + G_parent along_parent
//! ```
//! C: axes of the joint, `axis` of the bone. M: its turns about x, y and z, the one listed first done
//! first.

use crate::math::Vec3;
use nalgebra::UnitQuaternion;

/// What one value of the motion does; 0, 1, 2 are x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    Move(usize),
    Turn(usize),
}

/// A rigid bone and the joint at its proximal end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bone {
    pub name: String,
    /// Index of the bone before it; the root is its own.
    pub parent: usize,
    /// From its proximal to its distal end at rest, m.
    pub along: Vec3,
    /// Axes of its joint at rest (C).
    pub axes: UnitQuaternion<f64>,
    /// What its values do, in their order.
    pub channels: Vec<Channel>,
    /// Place of its first value among those of a frame.
    pub first: usize,
}

/// Where a bone is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// Proximal end, m.
    pub start: Vec3,
    /// Turn since the rest pose (G).
    pub turn: UnitQuaternion<f64>,
}

/// Bones, the root first and every other one after its parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Skeleton {
    pub bones: Vec<Bone>,
    /// Length of the file's unit, m.
    pub unit_m: f64,
    /// Whether angles are in degrees unless a motion says otherwise.
    pub is_degrees: bool,
}

impl Skeleton {
    /// Index of a bone.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|b| b.name == name)
    }

    /// Number of values in a frame.
    pub(super) fn dof(&self) -> usize {
        self.bones.iter().map(|b| b.channels.len()).sum()
    }

    /// Every bone under the values of one frame: lengths in the file's unit, angles in rad.
    pub(super) fn place(&self, values: &[f64]) -> Vec<Placed> {
        let mut placed: Vec<Placed> = Vec::with_capacity(self.bones.len());
        for bone in &self.bones {
            let (mut start, before) = match placed.get(bone.parent) {
                Some(p) => (p.start + p.turn * self.bones[bone.parent].along, p.turn),
                None => (Vec3::zeros(), UnitQuaternion::identity()),
            };
            let mut turns = Vec::with_capacity(3);
            for (channel, value) in bone.channels.iter().zip(&values[bone.first..]) {
                match channel {
                    Channel::Move(axis) => start[*axis] += value * self.unit_m,
                    Channel::Turn(axis) => turns.push((*axis, *value)),
                }
            }
            let turn = before * bone.axes * turned(&turns) * bone.axes.inverse();
            placed.push(Placed { start, turn });
        }
        placed
    }
}

/// Turns by angles (rad) about the fixed axes x, y, z (0, 1, 2), the first listed done first.
pub(super) fn turned(turns: &[(usize, f64)]) -> UnitQuaternion<f64> {
    turns.iter().fold(UnitQuaternion::identity(), |done, (axis, angle)| {
        let axes = [Vec3::x_axis(), Vec3::y_axis(), Vec3::z_axis()];
        UnitQuaternion::from_axis_angle(&axes[*axis], *angle) * done
    })
}

//! The moving part of a model between a base link and one or more tip frames.
//!
//! A chain is a linkage with one tip; two hands, or planted feet, are several tips whose Jacobians
//! are stacked. Fixed joints are merged away, so that a step of the recursion is one moving joint:
//!
//! ```text
//! R_i = R_parent R_fixed Rot(axis, q)     o_i = o_parent + R_parent p_fixed
//! J column of a revolute joint at tip T:  [ a x (p_T - o) ; a ],  a = R_i axis
//! ```

use super::model::{Joint, JointKind, Model};
use crate::files::suggest;
use crate::math::simd::{sin_cos, wide};
use crate::math::{Pose, Vec3, Vec6};
use nalgebra::{DMatrix, Matrix3, Matrix6, Matrix6xX, UnitQuaternion};
use thiserror::Error;

/// Up to this a joint's sine is found with all others at once, rad.
const LARGEST_TURN: f64 = 1e3;

/// A frame that a task or a drawing refers to: a link with a rigid offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Tip {
    /// Name of the link.
    pub link: String,
    /// Pose of the frame in the link's frame.
    pub offset: Pose,
}

impl Tip {
    /// The link's own frame.
    pub fn link(name: &str) -> Self {
        Self { link: name.to_owned(), offset: Pose::identity() }
    }
}

/// A column of the Jacobian: one independent joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLimit {
    /// Name in the model.
    pub name: String,
    /// True for a joint that slides (m), false for one that turns (rad).
    pub is_prismatic: bool,
    /// Lower limit, rad or m.
    pub lower: f64,
    /// Upper limit, rad or m.
    pub upper: f64,
    /// Velocity limit, rad/s or m/s.
    pub velocity: f64,
    /// Acceleration limit, rad/s^2 or m/s^2; infinity if the file gives none.
    pub acceleration: f64,
}

/// Why a linkage cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LinkageError {
    /// No link has this name.
    #[error("there is no link `{name}`{}", hint.as_ref().map(|h| format!("; {h}")).unwrap_or_default())]
    UnknownLink {
        /// The name asked for.
        name: String,
        /// "did you mean ...?"
        hint: Option<String>,
    },
    /// The tip does not hang below the base.
    #[error("link `{base}` is not an ancestor of `{tip}`; the links above `{tip}` are: {above}")]
    NotAnAncestor {
        /// The base asked for.
        base: String,
        /// The tip asked for.
        tip: String,
        /// The tip's ancestors, nearest first.
        above: String,
    },
    /// A joint on the way is floating or planar.
    #[error("joint `{joint}` between `{base}` and `{tip}` is of a kind that chains cannot use")]
    UnsupportedJoint {
        /// The joint.
        joint: String,
        /// The base.
        base: String,
        /// The tip.
        tip: String,
    },
}

/// Rotation axes that need two columns of work instead of three.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Axis {
    X(f64),
    Y(f64),
    Z(f64),
    General,
}

#[derive(Debug, Clone, PartialEq)]
struct Node {
    parent: Option<usize>,
    /// Fixed rotation from the parent's moved frame; none when it is the identity.
    rotation: Option<Matrix3<f64>>,
    /// The same of the translation; none for joints at one place.
    translation: Option<Vec3>,
    axis: Vec3,
    kind: Axis,
    is_prismatic: bool,
    /// Column, or none for a mimic joint whose source is not part of the linkage.
    column: Option<usize>,
    multiplier: f64,
    offset: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct TipNode {
    tip: Tip,
    node: Option<usize>,
    /// Of the tip in the last moved frame; none where it is that frame turned or moved by nothing.
    rotation: Option<Matrix3<f64>>,
    translation: Option<Vec3>,
    /// Moving joints above the tip, base first.
    path: Vec<usize>,
}

/// Joints between a base link and tip frames, flattened for speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Linkage {
    base: String,
    joints: Vec<JointLimit>,
    nodes: Vec<Node>,
    tips: Vec<TipNode>,
    /// Remarks, such as a mimic joint that had to be frozen.
    pub warnings: Vec<String>,
}

/// Where every joint of a linkage is, for one posture; scratch that is reused between postures.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    joints: Vec<Placed>,
    /// Positions of the joints, and their sines and cosines.
    position: Vec<f64>,
    sine: Vec<f64>,
    cosine: Vec<f64>,
}

/// A vector in base axes, with a fourth number that nobody reads: read and written in one go, which a row of
/// joints that wait for each other feels.
type Four = [f64; 4];

/// A joint in base axes.
#[derive(Debug, Clone, Copy, Default)]
struct Placed {
    /// Columns of the rotation of the moved frame.
    turned: [Four; 3],
    origin: Four,
    axis: Four,
}

/// The base itself.
const BASE: Placed = Placed {
    turned: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    origin: [0.0; 4],
    axis: [0.0; 4],
};

impl Placed {
    fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&self.turned.map(vec3))
    }

    fn origin(&self) -> Vec3 {
        vec3(self.origin)
    }

    fn axis(&self) -> Vec3 {
        vec3(self.axis)
    }
}

fn vec3([x, y, z, _]: Four) -> Vec3 {
    Vec3::new(x, y, z)
}

/// `a p + b q`.
#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
fn sum((a, p): (&Four, f64), (b, q): (&Four, f64)) -> Four {
    std::array::from_fn(|i| a[i].mul_add(p, b[i] * q))
}

/// `[x y z] v + start`.
#[inline(always)]
#[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
fn along([x, y, z]: &[Four; 3], v: &Vec3, start: &Four) -> Four {
    std::array::from_fn(|i| x[i].mul_add(v.x, y[i].mul_add(v.y, z[i].mul_add(v.z, start[i]))))
}

impl Linkage {
    /// The chain from `base` to the frame of the link `tip`.
    pub fn chain(model: &Model, base: &str, tip: &str) -> Result<Self, LinkageError> {
        Self::new(model, base, &[Tip::link(tip)])
    }

    /// All joints between `base` and the tips. Columns come in the order in which the tips first
    /// meet them, base to tip, so that the first tip's chain has the leading columns.
    pub fn new(model: &Model, base: &str, tips: &[Tip]) -> Result<Self, LinkageError> {
        let base_index = find_link(model, base)?;
        let mut linkage = Self {
            base: base.to_owned(),
            joints: Vec::new(),
            nodes: Vec::new(),
            tips: Vec::new(),
            warnings: Vec::new(),
        };
        let mut node_of_joint: Vec<Option<usize>> = vec![None; model.joints.len()];
        let paths: Result<Vec<Vec<usize>>, LinkageError> =
            tips.iter().map(|t| path_down(model, base, base_index, &t.link)).collect();
        let paths = paths?;
        for (i, joint) in paths.iter().flatten().map(|&j| (j, &model.joints[j])) {
            let known = linkage.joints.iter().any(|l| l.name == joint.name);
            if joint.mimic.is_none() && joint.kind != JointKind::Fixed && !known {
                linkage.joints.push(limit_of(&model.joints[i]));
            }
        }
        for (tip, path) in tips.iter().zip(&paths) {
            linkage.add_tip(model, tip, path, &mut node_of_joint);
        }
        Ok(linkage)
    }

    fn add_tip(
        &mut self,
        model: &Model,
        tip: &Tip,
        path: &[usize],
        node_of_joint: &mut [Option<usize>],
    ) {
        let mut parent: Option<usize> = None;
        let mut fixed = Pose::identity();
        let mut above = Vec::new();
        for &j in path {
            let joint = &model.joints[j];
            if joint.kind == JointKind::Fixed {
                fixed *= joint.origin;
                continue;
            }
            let node = node_of_joint[j].unwrap_or_else(|| {
                self.nodes.push(self.node(joint, parent, &(fixed * joint.origin)));
                self.nodes.len() - 1
            });
            if node_of_joint[j].is_none() && self.nodes[node].column.is_none() {
                self.warnings.push(format!(
                    "joint `{}` follows a joint outside the chain and is held at its offset",
                    joint.name
                ));
            }
            node_of_joint[j] = Some(node);
            above.push(node);
            parent = Some(node);
            fixed = Pose::identity();
        }
        fixed *= tip.offset;
        self.tips.push(TipNode {
            tip: tip.clone(),
            node: parent,
            rotation: some_rotation(&fixed),
            translation: some_translation(&fixed),
            path: above,
        });
    }

    fn node(&self, joint: &Joint, parent: Option<usize>, fixed: &Pose) -> Node {
        let (source, multiplier, offset) = match &joint.mimic {
            None => (joint.name.as_str(), 1.0, 0.0),
            Some(m) => (m.source.as_str(), m.multiplier, m.offset),
        };
        Node {
            parent,
            rotation: some_rotation(fixed),
            translation: some_translation(fixed),
            axis: joint.axis,
            kind: axis_kind(&joint.axis),
            is_prismatic: joint.kind == JointKind::Prismatic,
            column: self.joints.iter().position(|l| l.name == source),
            multiplier,
            offset,
        }
    }

    /// Name of the base link.
    pub fn base(&self) -> &str {
        &self.base
    }

    /// Number of independent joints, n.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The independent joints, in column order.
    pub fn joints(&self) -> &[JointLimit] {
        &self.joints
    }

    /// The tip frames.
    pub fn tips(&self) -> impl Iterator<Item = &Tip> {
        self.tips.iter().map(|t| &t.tip)
    }

    /// Places all joints for the posture `q` (n values, rad or m).
    ///
    /// # Panics
    /// When `q` is shorter than [`Linkage::dof`].
    pub fn forward(&self, q: &[f64], frames: &mut Frames) {
        let n = self.nodes.len();
        frames.joints.resize(n, BASE);
        for all in [&mut frames.position, &mut frames.sine, &mut frames.cosine] {
            all.resize(n, 0.0);
        }
        let Frames { joints, position, sine, cosine } = frames;
        for (node, position) in self.nodes.iter().zip(&mut *position) {
            *position = node.column.map_or(0.0, |c| q[c]) * node.multiplier + node.offset;
        }
        let is_usual = position.iter().all(|p| p.abs() < LARGEST_TURN);
        wide(
            #[inline(always)]
            || {
                for ((p, s), c) in position.iter().zip(&mut *sine).zip(&mut *cosine) {
                    (*s, *c) = sin_cos(*p);
                }
                if !is_usual {
                    for ((p, s), c) in position.iter().zip(&mut *sine).zip(&mut *cosine) {
                        (*s, *c) = p.sin_cos();
                    }
                }
                for (i, node) in self.nodes.iter().enumerate() {
                    let here = node.placed(joints, position[i], (sine[i], cosine[i]));
                    let joint = &mut joints[i];
                    (joint.turned[0], joint.turned[1], joint.turned[2]) =
                        (here.turned[0], here.turned[1], here.turned[2]);
                    (joint.origin, joint.axis) = (here.origin, here.axis);
                }
            },
        );
    }

    /// Position (m) and rotation matrix of a tip in base axes.
    pub fn tip_frame(&self, frames: &Frames, tip: usize) -> (Vec3, Matrix3<f64>) {
        let t = &self.tips[tip];
        let Some(n) = t.node else {
            return (
                t.translation.unwrap_or_default(),
                t.rotation.unwrap_or_else(Matrix3::identity),
            );
        };
        let above = &frames.joints[n];
        let rotation = above.rotation();
        (self.tip_position(frames, tip), t.rotation.map_or(rotation, |fixed| rotation * fixed))
    }

    /// Its position alone.
    fn tip_position(&self, frames: &Frames, tip: usize) -> Vec3 {
        let t = &self.tips[tip];
        let Some(n) = t.node else { return t.translation.unwrap_or_default() };
        let above = &frames.joints[n];
        // Outside the vectorised loop a fused product would be a call.
        let moved = |by: &Vec3| {
            let [x, y, z] = &above.turned;
            std::array::from_fn(|i| above.origin[i] + x[i] * by.x + y[i] * by.y + z[i] * by.z)
        };
        vec3(t.translation.as_ref().map_or(above.origin, moved))
    }

    /// Pose of a tip in the base frame.
    pub fn tip_pose(&self, frames: &Frames, tip: usize) -> Pose {
        let (p, r) = self.tip_frame(frames, tip);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(r);
        Pose::from_parts(p.into(), UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// Geometric Jacobian of a tip, 6 x n, written over `jacobian`.
    ///
    /// # Panics
    /// When `jacobian` does not have n columns.
    pub fn jacobian_into(&self, frames: &Frames, tip: usize, jacobian: &mut Matrix6xX<f64>) {
        jacobian.fill(0.0);
        let p = self.tip_position(frames, tip);
        for &i in &self.tips[tip].path {
            let node = &self.nodes[i];
            let Some(column) = node.column else { continue };
            let a = frames.joints[i].axis() * node.multiplier;
            let mut target = jacobian.column_mut(column);
            if node.is_prismatic {
                target[0] += a.x;
                target[1] += a.y;
                target[2] += a.z;
            } else {
                let v = a.cross(&(p - frames.joints[i].origin()));
                target[0] += v.x;
                target[1] += v.y;
                target[2] += v.z;
                target[3] += a.x;
                target[4] += a.y;
                target[5] += a.z;
            }
        }
    }

    /// Adds `weight` times the velocity of a point (base axes, m) that is fixed to a tip, by each column.
    ///
    /// # Panics
    /// When `velocities` has not n values.
    pub fn add_point_velocity(
        &self,
        frames: &Frames,
        tip: usize,
        point: &Vec3,
        weight: f64,
        velocities: &mut [Vec3],
    ) {
        for &i in &self.tips[tip].path {
            let node = &self.nodes[i];
            let Some(column) = node.column else { continue };
            let a = frames.joints[i].axis() * (node.multiplier * weight);
            velocities[column] +=
                if node.is_prismatic { a } else { a.cross(&(point - frames.joints[i].origin())) };
        }
    }

    /// `dJ/dt qdot` of a tip (m/s^2, rad/s^2, base axes) while the joints move at the even rates `qdot` (n), and
    /// the angular velocity of the tip (rad/s).
    pub fn bias_acceleration(&self, frames: &Frames, tip: usize, qdot: &[f64]) -> (Vec6, Vec3) {
        let p = self.tip_position(frames, tip);
        let (mut linear, mut angular, mut turning) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        for &i in &self.tips[tip].path {
            let node = &self.nodes[i];
            let Some(column) = node.column else { continue };
            let a = frames.joints[i].axis() * (node.multiplier * qdot[column]);
            if node.is_prismatic {
                linear += 2.0 * turning.cross(&a);
            } else {
                let v = a.cross(&(p - frames.joints[i].origin()));
                linear += (2.0 * turning + a).cross(&v);
                angular += turning.cross(&a);
                turning += a;
            }
        }
        (Vec6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z), turning)
    }

    /// Twist of a tip by each of the first `count` columns, six at most: velocity of its origin over angular
    /// velocity, 6 x 6 with zeros behind.
    pub fn leading_columns(&self, frames: &Frames, tip: usize, count: usize) -> Matrix6<f64> {
        let mut columns = Matrix6::zeros();
        let p = self.tip_position(frames, tip);
        for &i in self.tips[tip].path.iter().take(count) {
            let node = &self.nodes[i];
            let Some(c) = node.column.filter(|c| *c < count.min(6)) else { continue };
            let a = frames.joints[i].axis() * node.multiplier;
            if node.is_prismatic {
                columns.fixed_view_mut::<3, 1>(0, c).copy_from(&a);
            } else {
                columns
                    .fixed_view_mut::<3, 1>(0, c)
                    .copy_from(&a.cross(&(p - frames.joints[i].origin())));
                columns.fixed_view_mut::<3, 1>(3, c).copy_from(&a);
            }
        }
        columns
    }

    /// Geometric Jacobian of a tip, 6 x n.
    pub fn jacobian(&self, frames: &Frames, tip: usize) -> Matrix6xX<f64> {
        let mut jacobian = Matrix6xX::zeros(self.dof());
        self.jacobian_into(frames, tip, &mut jacobian);
        jacobian
    }

    /// The Jacobians of all tips, one above the other, (6 tips) x n.
    pub fn stacked_jacobian(&self, frames: &Frames) -> DMatrix<f64> {
        let mut stacked = DMatrix::zeros(6 * self.tips.len(), self.dof());
        for tip in 0..self.tips.len() {
            stacked.rows_mut(6 * tip, 6).copy_from(&self.jacobian(frames, tip));
        }
        stacked
    }
}

/// The rotation of a pose; none where it turns nothing.
fn some_rotation(pose: &Pose) -> Option<Matrix3<f64>> {
    let rotation = *pose.rotation.to_rotation_matrix().matrix();
    (rotation != Matrix3::identity()).then_some(rotation)
}

/// The translation of a pose; none where it moves nothing.
fn some_translation(pose: &Pose) -> Option<Vec3> {
    (pose.translation.vector != Vec3::zeros()).then_some(pose.translation.vector)
}

fn axis_kind(axis: &Vec3) -> Axis {
    match (axis.x, axis.y, axis.z) {
        (x, 0.0, 0.0) => Axis::X(x),
        (0.0, y, 0.0) => Axis::Y(y),
        (0.0, 0.0, z) => Axis::Z(z),
        _ => Axis::General,
    }
}

impl Node {
    /// The joint at a position with its sine and cosine, all joints above it being placed.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "must be compiled inside the vectorised loop")]
    fn placed(&self, joints: &[Placed], position: f64, (sine, cosine): (f64, f64)) -> Placed {
        // Vector by vector: copied as a whole, a joint would pass through memory.
        let above = self.parent.map_or(&BASE, |p| &joints[p]);
        let mut origin = match &self.translation {
            Some(moved) => along(&above.turned, moved, &above.origin),
            None => above.origin,
        };
        let columns = |of: &[Four; 3], by: &Matrix3<f64>| {
            [0, 1, 2].map(|c| along(of, &by.column(c).into_owned(), &[0.0; 4]))
        };
        let [mut x, mut y, mut z] = match &self.rotation {
            Some(fixed) => columns(&above.turned, fixed),
            None => above.turned,
        };
        let axis = match self.kind {
            Axis::X(s) => x.map(|v| v * s),
            Axis::Y(s) => y.map(|v| v * s),
            Axis::Z(s) => z.map(|v| v * s),
            Axis::General => along(&[x, y, z], &self.axis, &[0.0; 4]),
        };
        if self.is_prismatic {
            origin = sum((&axis, position), (&origin, 1.0));
            return Placed { turned: [x, y, z], origin, axis };
        }
        let turned = |a: &Four, b: &Four, sign: f64| {
            let sine = sign * sine;
            (sum((a, cosine), (b, sine)), sum((b, cosine), (a, -sine)))
        };
        match self.kind {
            Axis::X(s) => (y, z) = turned(&y, &z, s),
            Axis::Y(s) => (z, x) = turned(&z, &x, s),
            Axis::Z(s) => (x, y) = turned(&x, &y, s),
            Axis::General => {
                [x, y, z] = columns(&[x, y, z], &rodrigues(&self.axis, (sine, cosine)));
            }
        }
        Placed { turned: [x, y, z], origin, axis }
    }
}

/// The rotation about an axis by an angle.
fn rodrigues(axis: &Vec3, (sine, cosine): (f64, f64)) -> Matrix3<f64> {
    Matrix3::identity() * cosine
        + axis.cross_matrix() * sine
        + (axis * axis.transpose()) * (1.0 - cosine)
}

fn limit_of(joint: &Joint) -> JointLimit {
    JointLimit {
        name: joint.name.clone(),
        is_prismatic: joint.kind == JointKind::Prismatic,
        lower: joint.lower,
        upper: joint.upper,
        velocity: joint.velocity,
        acceleration: joint.acceleration,
    }
}

fn find_link(model: &Model, name: &str) -> Result<usize, LinkageError> {
    model.link_index(name).ok_or_else(|| LinkageError::UnknownLink {
        name: name.to_owned(),
        hint: suggest(name, model.links.iter().map(|l| l.name.as_str())),
    })
}

/// Indices of the joints from `base` down to the link `tip`.
fn path_down(
    model: &Model,
    base: &str,
    base_index: usize,
    tip: &str,
) -> Result<Vec<usize>, LinkageError> {
    let mut at = find_link(model, tip)?;
    let mut path = Vec::new();
    let mut above = Vec::new();
    while at != base_index {
        let Some(j) = model.links[at].parent_joint else {
            return Err(LinkageError::NotAnAncestor {
                base: base.to_owned(),
                tip: tip.to_owned(),
                above: if above.is_empty() { "none".to_owned() } else { above.join(", ") },
            });
        };
        if model.joints[j].kind == JointKind::Unsupported {
            return Err(LinkageError::UnsupportedJoint {
                joint: model.joints[j].name.clone(),
                base: base.to_owned(),
                tip: tip.to_owned(),
            });
        }
        path.push(j);
        at = model.joints[j].parent;
        above.push(model.links[at].name.clone());
    }
    path.reverse();
    Ok(path)
}

//! The pelvis as six coordinates, so that it is part of a chain like any joint.
//!
//! ```text
//! rest frame    where the pelvis of the upright body is: over the point between the feet, or on the seat
//! pelvis        forward, up and right of it (in leg lengths), then turned about Z, X and Y (rad)
//! ```
//! A leg length, the height of the hips of the barefoot upright body, counts like one radian, and makes
//! the same coordinates mean the same posture in a body of another size. All zero is the pelvis at rest.
//! Tilting forward is negative, as flexion of the spine is.

use super::body::Body;
use super::limits::Ranges;
use crate::kinematics::{Joint, JointKind, Link, Model, ModelError};
use crate::math::pose::zxy;
use crate::math::{Pose, Vec3};
use nalgebra::{UnitQuaternion, Vector6};

/// Link whose frame is the rest frame.
pub(super) const REST: &str = "Rest";
pub(super) const PELVIS: &str = "Pelvis";
/// Link between its displacements and its turns.
pub(super) const SEATED: &str = "Pelvis_3";

/// Names of the six coordinates, in order.
pub const PELVIS_JOINTS: [&str; 6] =
    ["pelvis_forward", "pelvis_up", "pelvis_right", "jPelvis_Z", "jPelvis_X", "jPelvis_Y"];

/// How far a pelvis may be from rest, leg lengths: wide, as legs and seats set the true bounds.
const PLACES: Ranges = [(-0.5, 0.5), (-0.8, 0.2), (-0.4, 0.4)];
/// How far it may be turned, deg.
const TURNS: Ranges = [(-85.0, 30.0), (-25.0, 25.0), (-45.0, 45.0)];

/// The model on a pelvis that moves.
pub(super) fn on_moving_pelvis(model: &Model, leg_m: f64) -> Result<Model, ModelError> {
    let (mut links, mut joints) = (model.links.clone(), model.joints.clone());
    for link in &mut links {
        link.parent_joint = None;
    }
    let frame = |name: &str| Link {
        name: name.to_owned(),
        mass_kg: 0.0,
        shapes: Vec::new(),
        mass_center: Vec3::zeros(),
        meshes: Vec::new(),
        parent_joint: None,
    };
    let Some(pelvis) = model.link_index(PELVIS) else {
        return Err(ModelError::NotATree(format!("there is no link `{PELVIS}`")));
    };
    let rest = links.len();
    links.push(frame(REST));
    for joint in joints.iter_mut().filter(|j| j.child == pelvis) {
        joint.child = rest;
    }
    let mut parent = rest;
    for (i, name) in PELVIS_JOINTS.iter().enumerate() {
        let child = if i == 5 { pelvis } else { links.len() };
        if child == links.len() {
            links.push(frame(&format!("{PELVIS}_{}", i + 1)));
        }
        let is_place = i < 3;
        let axis = [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::z(), Vec3::x(), Vec3::y()][i];
        let (low, high) = if is_place { PLACES[i] } else { TURNS[i - 3] };
        let unit = if is_place { 1.0 } else { std::f64::consts::PI / 180.0 };
        joints.push(Joint {
            name: (*name).to_owned(),
            kind: if is_place { JointKind::Prismatic } else { JointKind::Revolute },
            parent,
            child,
            origin: Pose::identity(),
            axis: if is_place { axis * leg_m } else { axis },
            lower: low * unit,
            upper: high * unit,
            velocity: f64::INFINITY,
            acceleration: f64::INFINITY,
            mimic: None,
        });
        parent = child;
    }
    Model::new(model.name.clone(), links, joints, model.warnings.clone())
}

/// Columns of where the feet of somebody who steps are, seen from the scenario's standing place: ahead, to the
/// right, and turned to the left. The pelvis is told from the feet.
pub const FEET_COLUMNS: [&str; 3] = ["feet_ahead_m", "feet_right_m", "feet_turn_rad"];

/// Name of a coordinate as a column of a file: displacements in m, angles in rad.
pub fn column_of(joint: &str) -> String {
    let unit = if PELVIS_JOINTS[..3].contains(&joint) { "m" } else { "rad" };
    format!("{joint}_{unit}")
}

/// What a coordinate of one is in its column: metres of a leg length, or 1.
pub fn column_unit(joint: &str, body: &Body) -> f64 {
    if PELVIS_JOINTS[..3].contains(&joint) { body.leg_m() } else { 1.0 }
}

/// Pelvis in the rest frame from its six coordinates, of a body with legs of `leg_m`.
pub fn pelvis_in_rest(coordinates: &[f64], leg_m: f64) -> Pose {
    let [x, y, z] = [0, 1, 2].map(|i| coordinates[i] * leg_m);
    let turn = |axis: Vec3, i: usize| UnitQuaternion::from_scaled_axis(axis * coordinates[i]);
    let rotation = turn(Vec3::z(), 3) * turn(Vec3::x(), 4) * turn(Vec3::y(), 5);
    Pose::from_parts(Vec3::new(x, y, z).into(), rotation)
}

/// The six coordinates of a pelvis in the rest frame.
pub fn pelvis_coordinates(pelvis: &Pose, leg_m: f64) -> Vector6<f64> {
    let place = pelvis.translation.vector / leg_m;
    let [z, x, y] = zxy(pelvis.rotation.to_rotation_matrix().matrix());
    Vector6::new(place.x, place.y, place.z, z, x, y)
}

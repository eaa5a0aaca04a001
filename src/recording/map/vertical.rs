//! Which axis of a file points up: stated, or the one along which the person stands.

use crate::files::InputError;
use crate::math::Vec3;
use crate::recording::axes::upright;
use nalgebra::UnitQuaternion;
use std::f64::consts::PI;
use std::path::Path;

/// Share of a person's mean direction along an axis beyond which that axis is the vertical.
const MOSTLY: f64 = 0.8;
pub(super) const SAY_UP: &str = "say which axis is up: up = \"z\" under [map]";

/// From the file's axes to those of a recording.
pub(in crate::recording) struct Up {
    pub turn: UnitQuaternion<f64>,
    pub word: String,
}

/// The vertical as stated, or else by the mean over time of the direction in which the trunk points.
pub(in crate::recording) fn vertical(
    path: &Path,
    stated: Option<(usize, bool)>,
    trunk: Vec3,
) -> Result<Up, InputError> {
    if let Some((axis, backwards)) = stated {
        return Ok(Up {
            turn: towards(axis, backwards),
            word: format!("the map says that {} is up", named(axis, backwards)),
        });
    }
    let axis = trunk.abs().imax();
    let backwards = trunk[axis] < 0.0;
    if trunk[axis].abs() < MOSTLY || trunk[axis].is_nan() {
        return Err(InputError::new(path, "stoops too much to tell what is up").remedy(SAY_UP));
    }
    let word = format!(
        "{} is taken as up: the trunk points along it, {:.0} deg off on average",
        named(axis, backwards),
        trunk[axis].abs().min(1.0).acos().to_degrees()
    );
    Ok(Up { turn: towards(axis, backwards), word })
}

/// Turns an axis of the file upwards.
fn towards(axis: usize, backwards: bool) -> UnitQuaternion<f64> {
    let turn = upright(axis);
    if backwards { UnitQuaternion::from_axis_angle(&Vec3::x_axis(), PI) * turn } else { turn }
}

fn named(axis: usize, backwards: bool) -> String {
    format!("{}{}", if backwards { "-" } else { "" }, ["x", "y", "z"][axis])
}

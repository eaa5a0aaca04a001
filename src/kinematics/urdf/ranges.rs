//! Every number of a URDF is one that it can be, also those that nothing here uses: a file with one number that
//! is nonsense is not to be trusted with the others.
//!
//! Looked at is what URDF itself defines; elements of other programs (gazebo, transmissions, sensors, ROS 2
//! control, prefixed ones) are not read.

use super::Source;
use super::plain::{named, owner};
use crate::files::InputError;
use crate::physical::{
    AXIS, COLOUR, EFFORT, GAIN, INERTIA, JOINT_LIMIT, LINK_KG, LINK_M, LINK_RAD, MESH_SCALE, MIMIC,
    RATE, Range, SHAPE_M, shown as number,
};
use roxmltree::Node;

/// Where a file that has another unit goes wrong.
const METRES: &str = "URDF is in metres: is the file in millimetres?";
const RADIANS: &str = "URDF is in radians: is the file in degrees?";
const CHECK: &str = "check the number; URDF is in metres, radians, kilograms and seconds";
/// How a joint that turns without end is written, and limits from which on they say the same: no degrees.
const ENDLESS: &str =
    "is the file in degrees? A joint that turns without end is type=\"continuous\"";
const ENDLESS_RAD: f64 = 1e3;

/// Whether limits say that a joint has none, as files do that stay with `revolute`: the same large number both
/// ways.
pub(super) fn is_endless(lower: f64, upper: f64) -> bool {
    upper >= ENDLESS_RAD && upper.is_finite() && lower.to_bits() == (-upper).to_bits()
}

impl Source<'_> {
    /// Refuses an XML declaration of a version that there is not.
    pub(super) fn refuse_version(&self) -> Result<(), InputError> {
        let Some(declared) = self.text.trim_start().strip_prefix("<?xml") else { return Ok(()) };
        let declared = declared.split("?>").next().unwrap_or_default();
        let version = declared.split(['"', '\'']).nth(1).unwrap_or_default();
        if !declared.trim_start().starts_with("version") || ["1.0", "1.1"].contains(&version) {
            return Ok(());
        }
        Err(InputError::new(self.path, format!("is XML of a version `{}`", shown(version)))
            .remedy("XML has version 1.0: <?xml version=\"1.0\"?>"))
    }

    /// Refuses a number of a link or joint that cannot be.
    pub(super) fn refuse_impossible(&self, robot: Node) -> Result<(), InputError> {
        for top in ["link", "joint", "material"] {
            for element in named(robot, top) {
                for node in element.descendants().filter(Node::is_element) {
                    self.refuse_impossible_in(node, element)?;
                }
            }
        }
        Ok(())
    }

    fn refuse_impossible_in(&self, node: Node, top: Node) -> Result<(), InputError> {
        if node.tag_name().namespace() != top.tag_name().namespace() {
            return Ok(());
        }
        for attribute in node.attributes() {
            let (element, name) = (node.tag_name().name(), attribute.name());
            let Some((range, remedy)) = range_of(element, name, top) else { continue };
            let text = attribute.value();
            if is_unlimited(element, name, top) {
                continue;
            }
            for word in text.split_whitespace() {
                let value = word.parse::<f64>();
                let what = || format!("{}: {element} {name} = \"{}\"", owner(node), shown(text));
                let Ok(value) = value else {
                    return Err(self
                        .error(node, format!("{} is not a number", what()))
                        .remedy("give numbers, with points and spaces, no commas"));
                };
                if !value.is_finite() {
                    return Err(self
                        .error(node, format!("{} is no number: it is not finite", what()))
                        .remedy(remedy));
                }
                if !range.holds(value) {
                    return Err(self
                        .error(node, format!("{}: {} is outside {range}", what(), number(value)))
                        .remedy(remedy));
                }
            }
        }
        Ok(())
    }
}

/// The limits of a joint that turns and has, by the convention of [`is_endless`], none.
fn is_unlimited(element: &str, name: &str, top: Node) -> bool {
    if element != "limit" || !matches!(name, "lower" | "upper") {
        return false;
    }
    let limit = named(top, "limit").next();
    let of = |name| limit.and_then(|l| l.attribute(name)?.trim().parse::<f64>().ok());
    match (of("lower"), of("upper")) {
        (Some(lower), Some(upper)) => {
            top.attribute("type") == Some("revolute") && is_endless(lower, upper)
        }
        _ => false,
    }
}

/// What an attribute that URDF defines can hold, and what to do where it does not.
fn range_of(element: &str, name: &str, top: Node) -> Option<(Range, &'static str)> {
    // Degrees and millimetres are asked about where a robot is made of the joints.
    let slides = matches!(top.attribute("type"), Some("prismatic"));
    let position = (JOINT_LIMIT, if slides { METRES } else { ENDLESS });
    Some(match (element, name) {
        ("axis", "xyz") => (AXIS, "give a direction, for example <axis xyz=\"0 0 1\"/>"),
        ("origin", "xyz") => (LINK_M, METRES),
        ("origin", "rpy") => (LINK_RAD, RADIANS),
        ("box", "size") | ("cylinder" | "capsule", "radius" | "length") | ("sphere", "radius") => {
            (SHAPE_M, METRES)
        }
        ("mesh", "scale") => (MESH_SCALE, CHECK),
        ("mass", "value") => (LINK_KG, CHECK),
        ("inertia", "ixx" | "ixy" | "ixz" | "iyy" | "iyz" | "izz") => (INERTIA, CHECK),
        ("color", "rgba") => (COLOUR, "colours are shares from 0 to 1"),
        ("limit", "lower" | "upper")
        | ("safety_controller", "soft_lower_limit" | "soft_upper_limit") => position,
        ("limit", "velocity" | "acceleration" | "deceleration" | "jerk") => {
            (RATE, "give the greatest value, which is positive, or leave it out")
        }
        ("limit", "effort") => (EFFORT, "give the greatest value, which is positive"),
        ("mimic", "multiplier" | "offset") => (MIMIC, CHECK),
        ("dynamics", "damping" | "friction")
        | ("safety_controller", "k_position" | "k_velocity")
        | ("calibration", "rising" | "falling") => (GAIN, CHECK),
        _ => return None,
    })
}

/// A value as shown in errors: garbage can be long.
fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

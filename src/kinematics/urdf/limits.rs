//! Limits of joints and sizes of collision shapes, with what URDF parsers let through: speeds below 0,
//! accelerations (URDF 1.2), soft limits of a `safety_controller`, radii that are no numbers.

use super::Source;
use crate::files::InputError;
use crate::physical::SHAPE_M;
use roxmltree::Node;
use std::path::Path;

impl Source<'_> {
    /// The number in an attribute of a joint's element, such as `limit`.
    fn number(
        &self,
        node: Node,
        name: &str,
        (element, attribute): (&str, &str),
    ) -> Result<Option<f64>, InputError> {
        let Some(found) = node.children().find(|c| c.has_tag_name(element)) else {
            return Ok(None);
        };
        let Some(text) = found.attribute(attribute) else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(value) if !value.is_nan() => Ok(Some(value)),
            _ => Err(self
                .error(found, format!("joint `{name}`: {attribute} = \"{text}\" is no number"))
                .remedy("give a number, or leave the attribute out")),
        }
    }

    /// A limit of speed or acceleration; infinity where none is given. 0 is what exporters write for
    /// that, too.
    pub(super) fn rate_limit(
        &self,
        node: Node,
        name: &str,
        attribute: &str,
        warnings: &mut Vec<String>,
    ) -> Result<f64, InputError> {
        match self.number(node, name, ("limit", attribute))? {
            Some(value) if value < 0.0 => Err(self
                .error(node, format!("joint `{name}`: {attribute} limit {value} is negative"))
                .remedy("give the greatest value, which is positive, or leave it out")),
            Some(0.0) => {
                warnings
                    .push(format!("joint `{name}`: a {attribute} limit of 0 counts as none given"));
                Ok(f64::INFINITY)
            }
            Some(value) => Ok(value),
            None => Ok(f64::INFINITY),
        }
    }

    /// The range within the soft limits of a `safety_controller`, if there is one: beyond them the
    /// controller brakes.
    pub(super) fn soft_limits(
        &self,
        node: Node,
        name: &str,
        (lower, upper): (f64, f64),
        warnings: &mut Vec<String>,
    ) -> Result<(f64, f64), InputError> {
        let of = |attribute| self.number(node, name, ("safety_controller", attribute));
        let soft_lower = of("soft_lower_limit")?.unwrap_or(f64::NEG_INFINITY).max(lower);
        let soft_upper = of("soft_upper_limit")?.unwrap_or(f64::INFINITY).min(upper);
        let is_same =
            soft_lower.to_bits() == lower.to_bits() && soft_upper.to_bits() == upper.to_bits();
        if is_same {
            return Ok((lower, upper));
        }
        if soft_lower >= soft_upper {
            warnings.push(format!(
                "joint `{name}`: the soft limits of its safety_controller leave no range and are not used"
            ));
            return Ok((lower, upper));
        }
        warnings.push(format!(
            "joint `{name}`: the soft limits of its safety_controller count, {soft_lower} to {soft_upper}"
        ));
        Ok((soft_lower, soft_upper))
    }
}

/// Sizes of collision shapes are finite and not negative: with others every distance would be kept.
pub(super) fn check_shapes(path: &Path, robot: &urdf_rs::Robot) -> Result<(), InputError> {
    for link in &robot.links {
        for collision in &link.collision {
            let sizes = match &collision.geometry {
                urdf_rs::Geometry::Cylinder { radius, length }
                | urdf_rs::Geometry::Capsule { radius, length } => vec![*radius, *length],
                urdf_rs::Geometry::Sphere { radius } => vec![*radius],
                urdf_rs::Geometry::Box { size } => size.0.to_vec(),
                urdf_rs::Geometry::Mesh { .. } => Vec::new(),
            };
            if let Some(size) = sizes.iter().find(|s| !SHAPE_M.holds(**s)) {
                let message =
                    format!("link `{}`: a collision shape has a size of {size} m", link.name);
                return Err(InputError::new(path, message)
                    .remedy("radii, lengths and sizes are in metres and not negative"));
            }
        }
    }
    Ok(())
}

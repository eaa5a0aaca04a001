//! Reads URDF, with the checks that the parser crate does not make.
//!
//! `urdf-rs` accepts silently: unknown links, loops, axes of any length, missing, NaN or reversed
//! limits, xacro macros that were not expanded, and text or tags that do not belong. Each of these
//! would give wrong kinematics, so each is an error here that names the line; what is only odd
//! becomes a warning of the model.

mod limits;
mod plain;
mod ranges;

use super::model::{Joint, JointKind, Link, LinkMesh, Mimic, Model, Shape};
use crate::files::{InputError, read_text, suggest};
use crate::math::{Pose, Vec3};
use nalgebra::UnitQuaternion;
use roxmltree::{Document, Node};
use std::path::Path;

/// Tags that URDF or its common users define at robot level and that kinematics does not need.
const KNOWN_TAGS: &[&str] = &[
    "link",
    "joint",
    "material",
    "transmission",
    "gazebo",
    "sensor",
    "ros2_control",
    "safety",
    "mujoco",
    "drake",
    "self_collision_checking",
    "origin",
    "static",
    "group",
    "disable_collisions",
];
/// How far an axis may be from unit length before it is normalised with a warning.
const AXIS_TOLERANCE: f64 = 1e-4;

/// Reads and checks a URDF file.
pub fn read_urdf(path: &Path) -> Result<Model, InputError> {
    parse_urdf(path, &read_text(path)?)
}

/// Parses and checks URDF text; `path` is only named in errors.
pub fn parse_urdf(path: &Path, text: &str) -> Result<Model, InputError> {
    let text = plain::with_prefixes(text);
    let text = text.as_ref();
    let document = Document::parse(text).map_err(|e| xml_error(path, text, &e))?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        let found = robot.tag_name().name();
        return Err(InputError::new(path, format!("is not URDF: the root element is `{found}`"))
            .remedy("the root element of a URDF file is `robot`")
            .at(text, robot.range()));
    }
    let source = Source { path, text };
    let mut warnings = Vec::new();
    source.refuse_version()?;
    source.check_macros(&document)?;
    source.check_top_level(robot, &mut warnings)?;
    let plain = source.plain(robot, &mut warnings)?;
    source.refuse_impossible(robot)?;
    let parsed = urdf_rs::read_from_string(&plain).map_err(|e| {
        InputError::new(path, format!("is not valid URDF: {e}"))
            .remedy("check the file with a URDF validator; xacro files must be expanded first")
    })?;
    limits::check_shapes(path, &parsed)?;
    let joint_nodes: Vec<Node> = plain::named(robot, "joint").collect();
    let mut links: Vec<Link> = parsed.links.iter().map(convert_link).collect();
    let massless = parsed.links.iter().filter(|l| l.inertial.mass.value <= 0.0).count();
    if massless > 0 {
        warnings.push(format!("{massless} links have no mass and count as frames only"));
    }
    let spaced = parsed.links.iter().map(|l| &l.name).chain(parsed.joints.iter().map(|j| &j.name));
    let spaced = spaced.filter(|n| n.contains(char::is_whitespace)).count();
    if spaced > 0 {
        warnings.push(format!("{spaced} names hold spaces; quote them on the command line"));
    }
    for link in &mut links {
        if !link.mass_kg.is_finite() || link.mass_kg < 0.0 {
            warnings.push(format!("link `{}` has mass {}; taken as 0", link.name, link.mass_kg));
            link.mass_kg = 0.0;
        }
    }
    let joints: Result<Vec<Joint>, InputError> = parsed
        .joints
        .iter()
        .zip(joint_nodes)
        .map(|(joint, node)| source.joint(joint, node, &links, &mut warnings))
        .collect();
    Model::new(parsed.name.clone(), links, joints?, warnings)
        .map_err(|e| InputError::new(path, e.to_string()))
}

struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn error(&self, node: Node, message: String) -> InputError {
        // Point at the opening tag, not at the whole element.
        let range = node.range();
        let end = self.text[range.clone()].find('>').map_or(range.end, |i| range.start + i + 1);
        InputError::new(self.path, message).at(self.text, range.start..end)
    }

    fn check_macros(&self, document: &Document) -> Result<(), InputError> {
        for node in document.descendants().filter(Node::is_element) {
            let namespace = node.tag_name().namespace().unwrap_or_default();
            let has_macro = node.attributes().any(|a| a.value().contains("${"));
            if namespace.contains("xacro") || has_macro {
                return Err(self
                    .error(node, "holds xacro macros that are not expanded".to_owned())
                    .remedy("expand it first: xacro FILE.xacro > FILE.urdf"));
            }
        }
        Ok(())
    }

    fn check_top_level(&self, robot: Node, warnings: &mut Vec<String>) -> Result<(), InputError> {
        for child in robot.children() {
            if child.is_text() && !child.text().unwrap_or_default().trim().is_empty() {
                let shown: String =
                    child.text().unwrap_or_default().trim().chars().take(20).collect();
                warnings.push(format!("stray text `{shown}` between the elements is ignored"));
            }
            let tag = child.tag_name().name();
            let is_own = child.tag_name().namespace() == robot.tag_name().namespace();
            if child.is_element() && !is_own {
                warnings.push(format!("element `{tag}` of another program is ignored"));
            } else if child.is_element() && !KNOWN_TAGS.contains(&tag) {
                if let Some(hint) = suggest(tag, ["link", "joint", "material"]) {
                    return Err(self.error(child, format!("unknown element `{tag}`")).remedy(hint));
                }
                warnings.push(format!("element `{tag}` is ignored"));
            }
        }
        Ok(())
    }

    fn joint(
        &self,
        joint: &urdf_rs::Joint,
        node: Node,
        links: &[Link],
        warnings: &mut Vec<String>,
    ) -> Result<Joint, InputError> {
        let name = &joint.name;
        let link = |end: &str, wanted: &str| {
            links.iter().position(|l| l.name == wanted).ok_or_else(|| {
                let error = self
                    .error(node, format!("joint `{name}`: {end} link `{wanted}` does not exist"));
                match suggest(wanted, links.iter().map(|l| l.name.as_str())) {
                    Some(hint) => error.remedy(hint),
                    None => error.remedy("add the link, or correct the name"),
                }
            })
        };
        let origin = convert_pose(&joint.origin);
        if !(origin.translation.vector.iter().all(|v| v.is_finite())
            && origin.rotation.coords.iter().all(|v| v.is_finite()))
        {
            return Err(self.error(node, format!("joint `{name}`: origin is not finite")));
        }
        let kind = match joint.joint_type {
            urdf_rs::JointType::Revolute | urdf_rs::JointType::Continuous => JointKind::Revolute,
            urdf_rs::JointType::Prismatic => JointKind::Prismatic,
            urdf_rs::JointType::Fixed => JointKind::Fixed,
            _ => JointKind::Unsupported,
        };
        let mut axis = Vec3::from(joint.axis.xyz.0);
        let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut velocity, mut acceleration) = (f64::INFINITY, f64::INFINITY);
        if matches!(kind, JointKind::Revolute | JointKind::Prismatic) {
            axis = self.unit_axis(node, name, axis, warnings)?;
            let (from, to) = (joint.limit.lower, joint.limit.upper);
            let turns = joint.joint_type == urdf_rs::JointType::Revolute;
            if turns && ranges::is_endless(from, to) {
                warnings.push(format!(
                    "joint `{name}`: limits of {from} to {to} rad count as none: it turns without end"
                ));
            } else if joint.joint_type != urdf_rs::JointType::Continuous {
                (lower, upper) = self.limits(node, name, joint)?;
                (lower, upper) = self.soft_limits(node, name, (lower, upper), warnings)?;
            }
            velocity = self.rate_limit(node, name, "velocity", warnings)?;
            acceleration = self.rate_limit(node, name, "acceleration", warnings)?;
        }
        let mimic = joint.mimic.as_ref().map(|m| Mimic {
            source: m.joint.clone(),
            multiplier: m.multiplier.unwrap_or(1.0),
            offset: m.offset.unwrap_or(0.0),
        });
        Ok(Joint {
            name: name.clone(),
            kind,
            parent: link("parent", &joint.parent.link)?,
            child: link("child", &joint.child.link)?,
            origin,
            axis,
            lower,
            upper,
            velocity,
            acceleration,
            mimic,
        })
    }

    fn unit_axis(
        &self,
        node: Node,
        name: &str,
        axis: Vec3,
        warnings: &mut Vec<String>,
    ) -> Result<Vec3, InputError> {
        let norm = axis.norm();
        if !norm.is_finite() || norm < 1e-9 {
            return Err(self
                .error(node, format!("joint `{name}`: the axis has length {norm}"))
                .remedy("give a direction, for example <axis xyz=\"0 0 1\"/>"));
        }
        if (norm - 1.0).abs() > AXIS_TOLERANCE {
            warnings.push(format!("joint `{name}`: axis of length {norm} is normalised"));
        }
        // Leave exact unit axes untouched, bit by bit.
        Ok(if norm == 1.0 { axis } else { axis / norm })
    }

    fn limits(
        &self,
        node: Node,
        name: &str,
        joint: &urdf_rs::Joint,
    ) -> Result<(f64, f64), InputError> {
        let remedy = "give <limit lower=\"..\" upper=\"..\" velocity=\"..\" effort=\"..\"/>, or use \
                      type=\"continuous\" for a joint that turns without end";
        let Some(limit) = node.children().find(|c| c.has_tag_name("limit")) else {
            return Err(self.error(node, format!("joint `{name}` has no limit")).remedy(remedy));
        };
        let (lower, upper) = (joint.limit.lower, joint.limit.upper);
        if !lower.is_finite() || !upper.is_finite() {
            let message = format!("joint `{name}`: limits {lower} to {upper} are not finite");
            return Err(self.error(limit, message).remedy(remedy));
        }
        if lower > upper {
            let message =
                format!("joint `{name}`: lower limit {lower} is above the upper, {upper}");
            return Err(self.error(limit, message).remedy("exchange the two"));
        }
        Ok((lower, upper))
    }
}

fn xml_error(path: &Path, text: &str, error: &roxmltree::Error) -> InputError {
    let at = error.pos();
    let start = text
        .split_inclusive('\n')
        .take((at.row as usize).saturating_sub(1))
        .map(str::len)
        .sum::<usize>()
        + (at.col as usize).saturating_sub(1);
    let start = (0..=start.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
    let error = InputError::new(path, format!("is not well-formed XML: {error}"));
    if text.contains("xacro:") {
        return error
            .remedy("this looks like a xacro file; expand it: xacro FILE.xacro > FILE.urdf");
    }
    error.remedy("is the file complete?").at(text, start..start)
}

fn convert_pose(pose: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = pose.rpy.0;
    Pose::from_parts(
        Vec3::from(pose.xyz.0).into(),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// A mesh, of what is a mesh.
fn mesh(origin: &urdf_rs::Pose, geometry: &urdf_rs::Geometry) -> Option<LinkMesh> {
    let urdf_rs::Geometry::Mesh { filename, scale } = geometry else { return None };
    let scale = scale.as_ref().map_or(Vec3::repeat(1.0), |s| Vec3::from(s.0));
    Some(LinkMesh { file: filename.clone(), pose: convert_pose(origin), scale })
}

fn convert_link(link: &urdf_rs::Link) -> Link {
    let shapes = link.collision.iter().filter_map(|c| {
        let shape = match &c.geometry {
            urdf_rs::Geometry::Cylinder { radius, length }
            | urdf_rs::Geometry::Capsule { radius, length } => {
                Shape::Capsule { radius: *radius, length: *length }
            }
            urdf_rs::Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
            urdf_rs::Geometry::Box { size } => Shape::Cuboid { size: Vec3::from(size.0) },
            urdf_rs::Geometry::Mesh { .. } => return None,
        };
        Some((convert_pose(&c.origin), shape))
    });
    let collision = link.collision.iter().filter_map(|c| mesh(&c.origin, &c.geometry));
    let visual = link.visual.iter().filter_map(|v| mesh(&v.origin, &v.geometry));
    let center = convert_pose(&link.inertial.origin).translation.vector;
    Link {
        name: link.name.clone(),
        mass_kg: link.inertial.mass.value,
        mass_center: if center.iter().all(|v| v.is_finite()) { center } else { Vec3::zeros() },
        shapes: shapes.collect(),
        meshes: if link.collision.is_empty() { visual.collect() } else { collision.collect() },
        parent_joint: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic;
    use proptest::prelude::*;

    const GOOD: &str = r#"<?xml version="1.0"?>
<robot name="two">
  <link name="base"/><link name="arm"/><link name="hand"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0  0   1" rpy="0 0 0"/><axis xyz="0. 0. 1."/>
    <limit lower="-1" upper="1" velocity="2" effort="3"/></joint>
  <joint name="b" type="continuous"><parent link="arm"/><child link="hand"/>
    <origin xyz="1 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"#;

    fn parse(text: &str) -> Result<Model, InputError> {
        parse_urdf(Path::new("r.urdf"), text)
    }

    fn refusal(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from), "{from}");
        let error = parse(&GOOD.replace(from, to)).unwrap_err();
        let help = error.help().map(|h| h.to_string()).unwrap_or_default();
        format!("{error} / {help}")
    }

    #[test]
    fn reads_a_good_file() {
        let model = parse(GOOD).unwrap();
        assert_eq!(model.joints.len(), 2);
        assert_eq!(model.joints[1].upper, f64::INFINITY);
        assert_eq!(model.root(), "base");
    }

    #[test]
    fn refuses_each_silent_mistake() {
        assert!(refusal("child link=\"arm\"", "child link=\"arn\"").contains("did you mean `arm`"));
        assert!(refusal("lower=\"-1\"", "lower=\"nan\"").contains("not finite"));
        assert!(refusal("lower=\"-1\"", "lower=\"3\"").contains("above the upper"));
        let limit = "<limit lower=\"-1\" upper=\"1\" velocity=\"2\" effort=\"3\"/>";
        assert!(refusal(limit, "").contains("has no limit"));
        assert!(refusal("0. 0. 1.", "0 0 0").contains("axis has length 0"));
        assert!(refusal("<link name=\"hand\"/>", "<lnk name=\"hand\"/>").contains("`link`"));
        assert!(refusal("name=\"b\"", "name=\"a\"").contains("defined twice"));
        assert!(refusal("xyz=\"1 0 0\"", "xyz=\"${x} 0 0\"").contains("xacro"));
        assert!(refusal("<parent link=\"base\"/>", "<parent link=\"hand\"/>").contains("loop"));
        assert!(refusal("</robot>", "").contains("well-formed"));
        assert!(refusal("robot", "sdf").contains("root element"));
        let extra = "<link name=\"lost\"/></robot>";
        assert!(refusal("</robot>", extra).contains("no parent joint"));
    }

    #[test]
    fn every_limit_of_the_file_is_used_or_named() {
        let limit = "<limit lower=\"-1\" upper=\"1\" velocity=\"2\" effort=\"3\"/>";
        let with = |to: &str| GOOD.replace(limit, to);
        let model = parse(&with(
            "<limit lower=\"-1\" upper=\"1\" velocity=\"2\" effort=\"3\" acceleration=\"1.5\"/>\
             <safety_controller soft_lower_limit=\"-0.8\" soft_upper_limit=\"0.9\" k_velocity=\"1\"/>",
        ))
        .unwrap();
        let joint = &model.joints[0];
        assert_eq!((joint.lower, joint.upper), (-0.8, 0.9));
        assert_eq!((joint.velocity, joint.acceleration), (2.0, 1.5));
        assert!(model.warnings.join(" ").contains("soft limits"), "{:?}", model.warnings);
        assert_eq!(parse(GOOD).unwrap().joints[0].acceleration, f64::INFINITY);
        let zero = parse(&GOOD.replace("velocity=\"2\"", "velocity=\"0\"")).unwrap();
        assert_eq!(zero.joints[0].velocity, f64::INFINITY);
        assert!(zero.warnings.join(" ").contains("joint `a`: a velocity limit of 0"));
        assert!(refusal("velocity=\"2\"", "velocity=\"-1\"").contains("is negative"));
        assert!(refusal("velocity=\"2\"", "velocity=\"nan\"").contains("no number"));
        assert!(refusal("xyz=\"1 0 0\"", "xyz=\"333 0 0\"").contains("millimetres?"));
        for size in ["nan", "-1", "1e308", "inf"] {
            let link = format!(
                "<link name=\"arm\"><collision><geometry><sphere radius=\"{size}\"/></geometry>\
                 </collision></link>"
            );
            assert!(refusal("<link name=\"arm\"/>", &link).contains("link `arm`"), "{size}");
        }
    }

    #[test]
    fn warns_of_what_it_mends() {
        let odd = GOOD
            .replace("0. 0. 1.", "0 0 3")
            .replace("<link name=\"arm\"/>", "<link name=\"arm\"/> --&gt;");
        let model = parse(&odd).unwrap();
        assert_eq!(model.joints[0].axis, Vec3::z());
        let all = model.warnings.join(" | ");
        assert!(all.contains("length 3") && all.contains("stray text"), "{all}");
    }

    #[test]
    fn what_other_programs_write_is_read_past() {
        let link = "<link name=\"arm\"/>";
        let odd = "<!-- a --><link name=\"arm\">stray<visual><geometry><sphere radius=\"1\"/></geometry>\
             <material name=\"a\"/><!-- b --><material name=\"b\"/></visual>\
             <collision><geometry><plane/></geometry></collision><inertial/>\
             <sim:friction mu=\"1\"/></link><other:link other:name=\"x\"/>";
        let model = parse(&GOOD.replace(link, odd).replace(
            "<axis xyz=\"0 1 0\"/>",
            "<axis xyz=\"0 1 0\"/>\
             <safety_controller soft_upper_limit=\"1\"/><limit velocity=\"2\"/>stray<!-- c -->",
        ))
        .unwrap();
        assert_eq!((model.links.len(), model.joints.len()), (3, 2));
        assert_eq!(model.joints[1].velocity, 2.0);
        let all = model.warnings.join(" | ");
        assert!(all.contains("link `arm`: a collision shape of `plane` is left out"), "{all}");
        assert!(all.contains("link `arm`: its inertial has no mass"), "{all}");
        assert!(all.contains("element `link` of another program"), "{all}");
        let twice = parse(
            &GOOD.replace("<axis xyz=\"0. 0. 1.\"/>", "<axis xyz=\"0 0 1\"/><axis xyz=\"1 0 0\"/>"),
        );
        assert!(
            twice.unwrap().warnings.join(" ").contains("joint `a`: of several `axis` the first")
        );
    }

    #[test]
    fn faults_are_named_with_element_and_owner() {
        for (from, to, said) in [
            (
                "xyz=\"0. 0. 1.\"",
                "xyz=\"0 1\"",
                "joint `a`: axis xyz = \"0 1\" is not three numbers",
            ),
            (
                "xyz=\"1 0 0\"",
                "xyz=\"1,0 0 0\"",
                "joint `b`: origin xyz = \"1,0 0 0\" is not three numbers / give three numbers, with points",
            ),
            ("lower=\"-1\"", "lower=\"low\"", "joint `a`: limit lower = \"low\" is not a number"),
            (
                "type=\"continuous\"",
                "type=\"continous\"",
                "joint `b`: there is no type `continous` / did you mean `continuous`?",
            ),
            ("type=\"continuous\"", "", "joint `b`: joint has no `type`"),
            ("<parent link=\"arm\"/>", "", "joint `b` has no <parent link=\"..\"/>"),
            ("<parent link=\"arm\"/>", "<parent/>", "joint `b`: parent has no `link`"),
            ("<link name=\"arm\"/>", "<link/>", "a link: link has no `name`"),
            (
                "<link name=\"arm\"/>",
                "<link name=\"arm\"><collision><geometry><box/></geometry></collision></link>",
                "link `arm`: box has no `size`",
            ),
            (
                "<link name=\"arm\"/>",
                "<link name=\"arm\"><inertial><mass value=\"1 kg\"/></inertial></link>",
                "link `arm`: mass value = \"1 kg\" is not a number",
            ),
            (
                "<link name=\"arm\"/>",
                "<link name=\"arm\"><visual><geometry><mesh filename=\"a\" scale=\"0 1 1\"/></geometry></visual></link>",
                "link `arm`: the scale of a mesh is \"0 1 1\"",
            ),
        ] {
            let found = refusal(from, to);
            assert!(found.contains(said), "{found}");
        }
    }

    proptest! {
        #[test]
        fn no_mutilated_file_panics(cut in 0usize..600, at in 0usize..600, with in "[<>/\"a-z0-9 .-]{0,6}") {
            let cut = cut.min(GOOD.len());
            let at = at.min(cut);
            let _ = parse(&format!("{}{}{}", &GOOD[..at], with, &GOOD[at..cut]));
        }
    }
}

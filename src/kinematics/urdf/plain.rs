//! A URDF reduced to what kinematics and shapes need, for the parser crate.
//!
//! Makers' files hold more than the parser takes: second materials, elements of other programs with
//! prefixes that nobody declared, text and comments anywhere, limits or inertias in part. What is
//! needed is written anew, each number looked at, so that a fault is named with its element, and with
//! the link or joint that it is in.

use super::Source;
use crate::files::InputError;
use roxmltree::{Document, Error, Node};
use std::borrow::Cow;
use std::fmt::Write as _;

/// Most prefixes that are declared for a file.
const MOST_PREFIXES: usize = 32;
/// Kinds of joints that URDF has, and of shapes with their attributes.
const JOINT_KINDS: [&str; 7] =
    ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];
const SHAPES: [(&str, &[(&str, Kind)]); 5] = [
    ("box", &[("size", Kind::Three)]),
    ("cylinder", &[("radius", Kind::One), ("length", Kind::One)]),
    ("capsule", &[("radius", Kind::One), ("length", Kind::One)]),
    ("sphere", &[("radius", Kind::One)]),
    ("mesh", &[("filename", Kind::Text)]),
];

/// What an attribute holds.
#[derive(Clone, Copy)]
enum Kind {
    Text,
    One,
    Three,
}

/// The text with every prefix declared that is used: what belongs to other programs is left out
/// later, but XML with undeclared prefixes cannot be read at all.
pub(super) fn with_prefixes(text: &str) -> Cow<'_, str> {
    let mut text = Cow::Borrowed(text);
    for _ in 0..MOST_PREFIXES {
        let Err(Error::UnknownNamespace(prefix, _)) = Document::parse(&text) else { break };
        let Some(at) = text.find("<robot").map(|i| i + "<robot".len()) else { break };
        let mut declared = text.into_owned();
        declared.insert_str(at, &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""));
        text = Cow::Owned(declared);
    }
    text
}

/// The children of a node with this name that belong to URDF itself.
pub(super) fn named<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    let own = node.document().root_element().tag_name().namespace();
    node.children().filter(move |n| {
        n.is_element() && n.tag_name().name() == name && n.tag_name().namespace() == own
    })
}

impl Source<'_> {
    /// The same robot with links, joints, shapes and masses only.
    pub(super) fn plain(
        &self,
        robot: Node,
        warnings: &mut Vec<String>,
    ) -> Result<String, InputError> {
        let name = robot.attribute("name").unwrap_or("robot");
        let mut out = format!("<robot name=\"{}\">", escaped(name));
        for link in named(robot, "link") {
            self.link(link, &mut out, warnings)?;
        }
        for joint in named(robot, "joint") {
            self.plain_joint(joint, &mut out, warnings)?;
        }
        out.push_str("</robot>");
        Ok(out)
    }

    fn link(
        &self,
        link: Node,
        out: &mut String,
        warnings: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let name = self.needed(link, "name")?;
        let _ = write!(out, "<link name=\"{}\">", escaped(name));
        if let Some(inertial) = only(link, "inertial", warnings) {
            let mass = only(inertial, "mass", warnings);
            match mass.map(|m| (m, m.attribute("value"))) {
                Some((mass, Some(_))) => {
                    out.push_str("<inertial>");
                    self.element(
                        inertial,
                        ("origin", &[("xyz", Kind::Three), ("rpy", Kind::Three)]),
                        out,
                        warnings,
                    )?;
                    let value = self.checked(mass, "value", Kind::One)?.unwrap_or_default();
                    let _ = write!(
                        out,
                        "<mass value=\"{value}\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" \
                         iyz=\"0\" izz=\"0\"/></inertial>"
                    );
                }
                _ => warnings
                    .push(format!("link `{name}`: its inertial has no mass, and counts as none")),
            }
        }
        for kind in ["visual", "collision"] {
            for shape in named(link, kind) {
                self.shape(shape, kind, out, warnings)?;
            }
        }
        out.push_str("</link>");
        Ok(())
    }

    fn shape(
        &self,
        shape: Node,
        kind: &str,
        out: &mut String,
        warnings: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let geometry = only(shape, "geometry", warnings);
        let found = geometry.and_then(|g| {
            SHAPES.iter().find_map(|(name, attributes)| Some((named(g, name).next()?, attributes)))
        });
        let Some((node, attributes)) = found else {
            let first = geometry.and_then(|g| g.first_element_child());
            let what = first.map_or("nothing", |n| n.tag_name().name()).to_owned();
            warnings.push(format!("{}: a {kind} shape of `{what}` is left out", owner(shape)));
            return Ok(());
        };
        let _ = write!(out, "<{kind}>");
        self.element(
            shape,
            ("origin", &[("xyz", Kind::Three), ("rpy", Kind::Three)]),
            out,
            warnings,
        )?;
        let _ = write!(out, "<geometry><{}", node.tag_name().name());
        for (attribute, kind) in *attributes {
            self.needed(node, attribute)?;
            self.attribute(node, attribute, *kind, out)?;
        }
        self.scale(node, out)?;
        let _ = write!(out, "/></geometry></{kind}>");
        Ok(())
    }

    /// The scale of a mesh; one number is that of all axes.
    fn scale(&self, mesh: Node, out: &mut String) -> Result<(), InputError> {
        let Some(text) = mesh.attribute("scale") else { return Ok(()) };
        let one = text.trim().parse::<f64>().map(|s| format!("{s} {s} {s}"));
        let scale = match one {
            Ok(scale) => scale,
            Err(_) => self.checked(mesh, "scale", Kind::Three)?.unwrap_or_default(),
        };
        let is_usable =
            scale.split(' ').all(|s| s.parse::<f64>().is_ok_and(|s| s.is_finite() && s != 0.0));
        if !is_usable {
            let message = format!("{}: the scale of a mesh is \"{text}\"", owner(mesh));
            return Err(self.error(mesh, message).remedy("give three factors that are not 0"));
        }
        let _ = write!(out, " scale=\"{scale}\"");
        Ok(())
    }

    fn plain_joint(
        &self,
        joint: Node,
        out: &mut String,
        warnings: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let name = self.needed(joint, "name")?;
        let kind = self.needed(joint, "type")?;
        if !JOINT_KINDS.contains(&kind) {
            let remedy = crate::files::suggest(kind, JOINT_KINDS)
                .unwrap_or_else(|| format!("kinds of joints: {}", JOINT_KINDS.join(", ")));
            let message = format!("joint `{name}`: there is no type `{kind}`");
            return Err(self.error(joint, message).remedy(remedy));
        }
        let _ = write!(out, "<joint name=\"{}\" type=\"{kind}\">", escaped(name));
        for end in ["parent", "child"] {
            let Some(node) = only(joint, end, warnings) else {
                let message = format!("joint `{name}` has no <{end} link=\"..\"/>");
                return Err(self.error(joint, message).remedy("name the links that it joins"));
            };
            let link = self.needed(node, "link")?;
            let _ = write!(out, "<{end} link=\"{}\"/>", escaped(link));
        }
        self.element(
            joint,
            ("origin", &[("xyz", Kind::Three), ("rpy", Kind::Three)]),
            out,
            warnings,
        )?;
        self.element(joint, ("axis", &[("xyz", Kind::Three)]), out, warnings)?;
        if let Some(limit) = only(joint, "limit", warnings) {
            out.push_str("<limit");
            for attribute in ["lower", "upper", "effort", "velocity"] {
                let value = self.checked(limit, attribute, Kind::One)?;
                let _ = write!(out, " {attribute}=\"{}\"", value.unwrap_or_else(|| "0".to_owned()));
            }
            out.push_str("/>");
        }
        if let Some(mimic) = only(joint, "mimic", warnings) {
            let leader = self.needed(mimic, "joint")?;
            let _ = write!(out, "<mimic joint=\"{}\"", escaped(leader));
            self.attribute(mimic, "multiplier", Kind::One, out)?;
            self.attribute(mimic, "offset", Kind::One, out)?;
            out.push_str("/>");
        }
        out.push_str("</joint>");
        Ok(())
    }

    /// Writes the only child of a name with its attributes.
    fn element(
        &self,
        node: Node,
        (name, attributes): (&'static str, &[(&str, Kind)]),
        out: &mut String,
        warnings: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let Some(child) = only(node, name, warnings) else { return Ok(()) };
        let _ = write!(out, "<{name}");
        for (attribute, kind) in attributes {
            self.attribute(child, attribute, *kind, out)?;
        }
        out.push_str("/>");
        Ok(())
    }

    fn attribute(
        &self,
        node: Node,
        attribute: &str,
        kind: Kind,
        out: &mut String,
    ) -> Result<(), InputError> {
        if let Some(value) = self.checked(node, attribute, kind)? {
            let _ = write!(out, " {attribute}=\"{}\"", escaped(&value));
        }
        Ok(())
    }

    /// The value of an attribute, if it is what it should be.
    fn checked(
        &self,
        node: Node,
        attribute: &str,
        kind: Kind,
    ) -> Result<Option<String>, InputError> {
        let Some(text) = node.attribute(attribute) else { return Ok(None) };
        let words: Vec<&str> = text.split_whitespace().collect();
        let is_number = |w: &&str| w.parse::<f64>().is_ok();
        let wanted = match kind {
            Kind::Text => return Ok(Some(text.to_owned())),
            Kind::One => "a number",
            Kind::Three => "three numbers",
        };
        let count = if matches!(kind, Kind::One) { 1 } else { 3 };
        if words.len() == count && words.iter().all(is_number) {
            return Ok(Some(words.join(" ")));
        }
        let element = node.tag_name().name();
        let message =
            format!("{}: {element} {attribute} = \"{text}\" is not {wanted}", owner(node));
        let comma = if text.contains(',') { ", with points and spaces, no commas" } else { "" };
        Err(self.error(node, message).remedy(format!("give {wanted}{comma}")))
    }

    fn needed<'n>(&self, node: Node<'n, '_>, attribute: &str) -> Result<&'n str, InputError> {
        node.attribute(attribute).ok_or_else(|| {
            let element = node.tag_name().name();
            let message = format!("{}: {element} has no `{attribute}`", owner(node));
            self.error(node, message).remedy(format!("add {attribute}=\"..\""))
        })
    }
}

/// The first child of a name; that there are more is told.
fn only<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    name: &'static str,
    warnings: &mut Vec<String>,
) -> Option<Node<'a, 'i>> {
    let mut found = named(node, name);
    let first = found.next()?;
    if found.next().is_some() {
        warnings.push(format!("{}: of several `{name}` the first counts", owner(first)));
    }
    Some(first)
}

/// The link or joint that a node belongs to, as one speaks of it.
pub(super) fn owner(node: Node) -> String {
    let is_owner = |n: &Node| matches!(n.tag_name().name(), "link" | "joint");
    let named =
        |n: &Node| is_owner(n) && n.parent_element().is_some_and(|p| p.has_tag_name("robot"));
    match node.ancestors().find(named) {
        Some(n) => match n.attribute("name") {
            Some(name) => format!("{} `{name}`", n.tag_name().name()),
            None => format!("a {}", n.tag_name().name()),
        },
        None => "the robot".to_owned(),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

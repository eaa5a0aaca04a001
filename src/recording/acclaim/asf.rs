//! The text of a skeleton (`.asf`), checked.
//!
//! Only what a recording needs is kept: `:units`, `:root`, `:bonedata` and `:hierarchy`. Names of
//! people, documentation, masses, limits and skins are passed over.

use super::skeleton::{Bone, Channel, Skeleton, turned};
use crate::math::Vec3;
use crate::recording::lines::{Fault, Line, lines, shown};
use nalgebra::UnitQuaternion;

/// The unit of length before it is divided by `length`, m.
const INCH_M: f64 = 0.0254;
/// Departure of the norm of a direction from one beyond which it is refused.
const NORM_TOLERANCE: f64 = 0.05;

const REPAIR: &str = "repair the skeleton, or export it again";

#[derive(Debug, Clone, Copy, PartialEq)]
enum Section {
    Units,
    Root,
    Bones,
    Hierarchy,
    Other,
}

/// A bone while it is being read; angles in the file's unit.
#[derive(Debug, Default)]
struct Entry {
    line: usize,
    name: Option<String>,
    direction: Option<Vec3>,
    length: Option<f64>,
    axes: Option<([f64; 3], [usize; 3])>,
    channels: Vec<Channel>,
}

#[derive(Debug)]
struct Parser {
    section: Section,
    per_inch: f64,
    is_degrees: bool,
    root: Option<Vec<Channel>>,
    /// Bones that are read to their end.
    entries: Vec<Entry>,
    open: Option<Entry>,
    /// Line, parent and child.
    links: Vec<(usize, String, String)>,
}

/// Reads a skeleton to its end.
pub(super) fn parse(text: &str) -> Result<Skeleton, Fault> {
    let mut parser = Parser {
        section: Section::Other,
        per_inch: 1.0,
        is_degrees: true,
        root: None,
        entries: Vec::new(),
        open: None,
        links: Vec::new(),
    };
    for mut line in lines(text) {
        if let Some(section) = line.first.strip_prefix(':') {
            parser.section = match section {
                "units" => Section::Units,
                "root" => Section::Root,
                "bonedata" => Section::Bones,
                "hierarchy" => Section::Hierarchy,
                _ => Section::Other,
            };
            continue;
        }
        match parser.section {
            Section::Units => parser.units(&mut line)?,
            Section::Root => parser.root(&mut line)?,
            Section::Bones => parser.bone(&mut line)?,
            Section::Hierarchy => parser.link(&mut line),
            Section::Other => {}
        }
    }
    if let Some(entry) = &parser.open {
        let message = "the bone that begins here has no `end`: the file is cut off or damaged";
        return Err(Fault::at(entry.line, message, REPAIR));
    }
    parser.finish()
}

impl Parser {
    fn units(&mut self, line: &mut Line) -> Result<(), Fault> {
        match line.first {
            "length" => {
                self.per_inch = line.number(REPAIR)?;
                if self.per_inch <= 0.0 {
                    let message = format!("a length scale of {} is not positive", self.per_inch);
                    return Err(line.fault(message, REPAIR));
                }
            }
            "angle" => match line.rest.next() {
                Some("deg") => self.is_degrees = true,
                Some("rad") => self.is_degrees = false,
                other => {
                    let message = format!("`{}` is no unit of angles", shown(other.unwrap_or("")));
                    return Err(line.fault(message, "known are `angle deg` and `angle rad`"));
                }
            },
            _ => {}
        }
        Ok(())
    }

    fn root(&mut self, line: &mut Line) -> Result<(), Fault> {
        let first = line.first;
        match first {
            "order" => self.root = Some(channels(line)?),
            "position" | "orientation" if line.three(REPAIR)?.iter().any(|v| *v != 0.0) => {
                let message = format!("the root has a {} of its own", line.first);
                return Err(line.fault(message, "export it with `0 0 0` there"));
            }
            _ => {}
        }
        Ok(())
    }

    fn bone(&mut self, line: &mut Line) -> Result<(), Fault> {
        match (line.first, &mut self.open) {
            ("begin", None) => {
                self.open = Some(Entry { line: line.number, ..Entry::default() });
            }
            ("end", open @ Some(_)) => self.entries.extend(open.take()),
            ("begin" | "end", _) => {
                let message = format!("`{}` is out of place", line.first);
                return Err(line.fault(message, REPAIR));
            }
            ("name", Some(entry)) => entry.name = line.rest.next().map(str::to_owned),
            ("direction", Some(entry)) => {
                entry.direction = Some(Vec3::from(line.three(REPAIR)?));
            }
            ("length", Some(entry)) => entry.length = Some(line.number(REPAIR)?),
            ("axis", Some(entry)) => entry.axes = Some((line.three(REPAIR)?, order(line)?)),
            ("dof", Some(entry)) => {
                entry.channels = channels(line)?;
                if entry.channels.iter().any(|c| matches!(c, Channel::Move(_))) {
                    return Err(line.fault("a bone that moves along an axis is not read", REPAIR));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn link(&mut self, line: &mut Line) {
        if !matches!(line.first, "begin" | "end") {
            let parent = line.first.to_owned();
            let links = line.rest.by_ref().map(|c| (line.number, parent.clone(), c.to_owned()));
            self.links.extend(links);
        }
    }

    /// Brings the bones into an order in which every one follows its parent.
    fn finish(mut self) -> Result<Skeleton, Fault> {
        let Some(root) = self.root.take() else {
            return Err(Fault::whole("has no `order` of the values of the root", REPAIR));
        };
        let full = |kind: fn(usize) -> Channel| (0..3).all(|axis| root.contains(&kind(axis)));
        if root.len() != 6 || !full(Channel::Move) || !full(Channel::Turn) {
            let message = "the `order` of the root does not hold each of TX TY TZ RX RY RZ once";
            return Err(Fault::whole(message, REPAIR));
        }
        let mut bones = vec![Bone {
            name: "root".to_owned(),
            parent: 0,
            along: Vec3::zeros(),
            axes: UnitQuaternion::identity(),
            channels: root,
            first: 0,
        }];
        let mut first = 6;
        let mut at = 0;
        while at < bones.len() {
            let parent = bones[at].name.clone();
            for (line, _, child) in self.links.iter().filter(|l| l.1 == parent) {
                if bones.iter().any(|b| b.name == *child) {
                    let message = format!("`{}` follows more than one bone", shown(child));
                    return Err(Fault::at(*line, message, REPAIR));
                }
                let is_it = |e: &&Entry| e.name.as_ref() == Some(child);
                let Some(entry) = self.entries.iter().find(is_it) else {
                    let message = format!("`{}` is no bone of :bonedata", shown(child));
                    return Err(Fault::at(*line, message, REPAIR));
                };
                bones.push(self.built(entry, child, at, first)?);
                first += entry.channels.len();
            }
            at += 1;
        }
        // A name that is missing or given twice, or a bone without a place in the hierarchy.
        for (i, entry) in self.entries.iter().enumerate() {
            let name = entry.name.as_deref().unwrap_or_default();
            let twice = self.entries[..i].iter().any(|e| e.name == entry.name);
            if twice || name.is_empty() || !bones.iter().any(|b| b.name == name) {
                let why = if twice { "is listed twice" } else { "does not hang on the root" };
                let message = format!("the bone `{}` {why}", shown(name));
                return Err(Fault::at(entry.line, message, REPAIR));
            }
        }
        Ok(Skeleton { bones, unit_m: INCH_M / self.per_inch, is_degrees: self.is_degrees })
    }

    fn built(&self, entry: &Entry, name: &str, parent: usize, first: usize) -> Result<Bone, Fault> {
        let fault = |what: &str| {
            let message = format!("the bone `{}` {what}", shown(name));
            Fault::at(entry.line, message, REPAIR)
        };
        let direction = entry.direction.ok_or_else(|| fault("has no direction"))?;
        let length = entry.length.ok_or_else(|| fault("has no length"))?;
        if length < 0.0 {
            return Err(fault("has a negative length"));
        }
        if length > 0.0 && (direction.norm() - 1.0).abs() > NORM_TOLERANCE {
            return Err(fault("has a direction that is no unit vector"));
        }
        let along = direction.try_normalize(0.0).unwrap_or_default();
        let (angles, order) = entry.axes.ok_or_else(|| fault("has no axis"))?;
        let scale = if self.is_degrees { 1_f64.to_radians() } else { 1.0 };
        let turns = order.map(|axis| (axis, scale * angles[axis]));
        Ok(Bone {
            name: name.to_owned(),
            parent,
            along: along * length * INCH_M / self.per_inch,
            axes: turned(&turns),
            channels: entry.channels.clone(),
            first,
        })
    }
}

/// The channels that a line lists.
fn channels(line: &mut Line) -> Result<Vec<Channel>, Fault> {
    let mut found = Vec::new();
    while let Some(word) = line.rest.next() {
        let channel = match word.to_ascii_lowercase().as_str() {
            "tx" => Channel::Move(0),
            "ty" => Channel::Move(1),
            "tz" => Channel::Move(2),
            "rx" => Channel::Turn(0),
            "ry" => Channel::Turn(1),
            "rz" => Channel::Turn(2),
            _ => {
                let message = format!("`{}`: `{}` is not known", line.first, shown(word));
                return Err(line.fault(message, "known are tx ty tz rx ry rz"));
            }
        };
        if found.contains(&channel) {
            let message = format!("`{}` lists `{}` twice", line.first, shown(word));
            return Err(line.fault(message, REPAIR));
        }
        found.push(channel);
    }
    Ok(found)
}

/// The order of the turns about x, y and z, such as XYZ: the first is done first.
fn order(line: &mut Line) -> Result<[usize; 3], Fault> {
    let word = line.rest.next().unwrap_or("");
    let places = ["X", "Y", "Z"].map(|axis| word.to_ascii_uppercase().find(axis));
    match places {
        [Some(x), Some(y), Some(z)] if word.len() == 3 => {
            let mut order = [0, 1, 2];
            order.sort_by_key(|axis| [x, y, z][*axis]);
            Ok(order)
        }
        _ => {
            let message = format!("`{}` is no order of axes", shown(word));
            Err(line.fault(message, "an axis ends with an order such as XYZ"))
        }
    }
}

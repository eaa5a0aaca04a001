//! Segments that columns of a table tell: poses in the world, or turns of a segment in the one before it.

use super::file::{General, Text, TypedPart, three};
use super::file::{MOST_OFFSET_MM, MOST_TURN_DEG};
use crate::files::InputError;
use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use nalgebra::UnitQuaternion;
use serde::Deserialize;
use toml::Spanned;

/// What stands for a segment's own part of the names of columns and files.
pub(in crate::recording) const BODY: &str = "{body}";
/// Between a column and its axis.
const ABOUT: &str = " about ";
const AXIS_NAMES: [[&str; 2]; 3] = [["x", "ahead"], ["y", "up"], ["z", "right"]];
const KNOWN_AXES: &str = "give x, y or z (ahead, up or right of a segment), with - for the other way round, or three numbers";

/// How a segment is told by columns.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording) struct ColumnPart {
    pub name: String,
    /// The name of its body in the names of files.
    pub body: Option<String>,
    /// Columns of its place in the world; none: it hangs on the segment before it.
    pub place: Option<[String; 3]>,
    pub rotation: ByColumns,
    /// From the place to the joint centre, in the segment's axes, m.
    pub offset_m: Vec3,
    /// Turn from the axes that the columns tell to those of the segment, about the former.
    pub turn: UnitQuaternion<f64>,
    /// Whether it is left out where a table lacks its columns.
    pub optional: bool,
    /// Whether it goes straight on from the segment before where a table lacks its columns.
    pub straight: bool,
}

/// Columns of a rotation.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording) enum ByColumns {
    /// w, x, y, z.
    Quaternion([String; 4]),
    /// Axis times angle.
    Vector([String; 3]),
    /// One after the other, each about the axes as the ones before have turned them.
    Turns(Vec<Turn>),
}

/// A turn about a constant axis.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::recording) struct Turn {
    pub column: String,
    /// Unit vector.
    pub about: Vec3,
    /// Added to what the column says, rad.
    pub offset: f64,
    /// Whether the direction of counting is the one in which most of it is positive.
    pub mostly_positive: bool,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "no turn: give \"COLUMN about AXIS\" or { by = \"COLUMN\", about = \"AXIS\" }"
)]
pub(super) enum TypedTurn {
    Short(String),
    Long(LongTurn),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LongTurn {
    by: String,
    about: TypedAxis,
    #[serde(default)]
    offset_deg: f64,
    #[serde(default)]
    mostly_positive: bool,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "no axis")]
enum TypedAxis {
    Named(String),
    Vector([f64; 3]),
}

impl ColumnPart {
    /// Columns that it is made of: of the place, then of the rotation.
    pub(in crate::recording) fn columns(&self) -> impl Iterator<Item = &str> {
        self.place.iter().flatten().map(String::as_str).chain(self.rotation.columns())
    }
}

impl ByColumns {
    pub(in crate::recording) fn columns(&self) -> Box<dyn Iterator<Item = &str> + '_> {
        match self {
            Self::Quaternion(names) => Box::new(names.iter().map(String::as_str)),
            Self::Vector(names) => Box::new(names.iter().map(String::as_str)),
            Self::Turns(turns) => Box::new(turns.iter().map(|t| t.column.as_str())),
        }
    }
}

/// Reads how a segment is told by columns, with what the map says of all of them.
pub(super) fn column_part(
    file: &Text,
    general: &General,
    name: &Spanned<String>,
    typed: &TypedPart,
) -> Result<ColumnPart, InputError> {
    let fault = |message: &str, remedy: &str| {
        file.fault(format!("{}: {message}", name.as_ref()), name.span(), remedy)
    };
    if let Some(key) = typed.keys_of_markers().next() {
        return Err(fault(
            &format!("`{key}` is told by markers, and other keys by columns"),
            "tell a segment by one or the other",
        ));
    }
    let body = typed.body.as_deref();
    let filled = |names: &[String]| -> Result<Vec<String>, InputError> {
        names
            .iter()
            .map(|column| match body {
                Some(body) => Ok(column.replace(BODY, body)),
                None if column.contains(BODY) => {
                    Err(fault("`{body}` stands for nothing", "add body = \"..\" to the segment"))
                }
                None => Ok(column.clone()),
            })
            .collect()
    };
    // What is said of all counts for segments that name their body.
    let common = |own: bool| body.is_some() && !own;
    let place = typed.place.as_ref().or(general.place.as_ref().filter(|_| common(false)));
    let is_told = typed.rotation_vector.is_some() || typed.turns.is_some();
    let quaternion =
        typed.quaternion.as_ref().or(general.quaternion.as_ref().filter(|_| common(is_told)));
    let rotation = match (quaternion, &typed.rotation_vector, &typed.turns) {
        (Some(names), None, None) => ByColumns::Quaternion(four(filled(names)?)),
        (None, Some(names), None) => ByColumns::Vector(triple(filled(names)?)),
        (None, None, Some(turns)) => {
            let turns = turns.iter().map(|turn| self::turn(file, turn, &filled));
            ByColumns::Turns(turns.collect::<Result<_, _>>()?)
        }
        (None, None, None) => {
            return Err(fault(
                "nothing tells how it is turned",
                "give `quaternion`, `rotation_vector` or `turns`; [] for a segment that goes straight on",
            ));
        }
        _ => {
            return Err(fault("several keys tell how it is turned", "give one of them"));
        }
    };
    let offset = three(file, typed.offset_mm.as_ref(), MOST_OFFSET_MM, "offset_mm")?;
    let turn = three(file, typed.turn_deg.as_ref(), MOST_TURN_DEG, "turn_deg")?;
    let axes = typed.axes.as_ref().map(|axes| self::axes(file, axes)).transpose()?;
    Ok(ColumnPart {
        name: name.as_ref().clone(),
        body: typed.body.clone(),
        place: place.map(|names| filled(names)).transpose()?.map(triple),
        rotation,
        offset_m: 1e-3 * offset,
        turn: axes.unwrap_or_default()
            * UnitQuaternion::from_scaled_axis(turn.map(f64::to_radians)),
        optional: typed.optional,
        straight: typed.straight,
    })
}

fn triple(names: Vec<String>) -> [String; 3] {
    names.try_into().unwrap_or_default()
}

fn four(names: Vec<String>) -> [String; 4] {
    names.try_into().unwrap_or_default()
}

fn turn(
    file: &Text,
    typed: &Spanned<TypedTurn>,
    filled: &impl Fn(&[String]) -> Result<Vec<String>, InputError>,
) -> Result<Turn, InputError> {
    let fault = |message: String, remedy: &str| file.fault(message, typed.span(), remedy);
    let (column, about, offset_deg, mostly_positive) = match typed.as_ref() {
        TypedTurn::Short(words) => {
            let Some((column, axis)) = words.rsplit_once(ABOUT) else {
                let message = format!("`{words}` is no turn");
                return Err(fault(message, "give \"COLUMN about AXIS\""));
            };
            (column.trim(), TypedAxis::Named(axis.to_owned()), 0.0, false)
        }
        TypedTurn::Long(t) => (t.by.as_str(), t.about.clone(), t.offset_deg, t.mostly_positive),
    };
    let about = match &about {
        TypedAxis::Named(word) => axis(word),
        TypedAxis::Vector(v) => Vec3::from(*v).try_normalize(1e-6).filter(|v| v.norm().is_finite()),
    };
    let about = about.ok_or_else(|| fault("names no axis".to_owned(), KNOWN_AXES))?;
    if offset_deg.abs() > MOST_TURN_DEG || !offset_deg.is_finite() {
        let message = format!("offset_deg = {offset_deg} is too large");
        return Err(fault(message, "give -180 to 180 degrees"));
    }
    let column = filled(&[column.to_owned()])?.pop().unwrap_or_default();
    Ok(Turn { column, about, offset: offset_deg.to_radians(), mostly_positive })
}

/// The unit vector that a word such as `x` or `-up` names.
fn axis(word: &str) -> Option<Vec3> {
    let word = word.trim();
    let (name, sign) = word.strip_prefix('-').map_or((word, 1.0), |rest| (rest, -1.0));
    let i = AXIS_NAMES.iter().position(|names| names.contains(&name))?;
    Some(Vec3::ith(i, sign))
}

/// The turn to axes of which a map says what points ahead, up and right.
fn axes(file: &Text, typed: &Spanned<[String; 3]>) -> Result<UnitQuaternion<f64>, InputError> {
    let fault = |message: &str, remedy: &str| file.fault(message, typed.span(), remedy);
    let named = typed.as_ref().each_ref().map(|word| axis(word));
    let [Some(x), Some(y), Some(z)] = named else {
        return Err(fault("axes name no axis", KNOWN_AXES));
    };
    // A turn exactly where the third is square to the first two, by the right hand.
    if (x.cross(&y) - z).norm() > 1e-9 {
        return Err(fault(
            "these axes are those of no turn: they are not square, or left-handed",
            "say which axes of the columns point ahead, up and right of the segment",
        ));
    }
    Ok(rotation_from_axes(x, y, z))
}

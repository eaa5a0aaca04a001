//! The mapping file: TOML, checked as a whole before any recording is read.

use super::columns::{BODY, ColumnPart, TypedTurn, column_part};
use super::{AS, AXES, Direction, JOINT_OF, Mean, Part, Point, Source};
use crate::files::{InputError, parse_toml, read_text, suggest};
use crate::math::Vec3;
use crate::recording::SEGMENT_NAMES;
use crate::recording::markers::{KNOWN_UNITS, unit_m};
use nalgebra::UnitQuaternion;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// What stands for a person in names of files.
pub(in crate::recording) const PERSON: &str = "{person}";
/// Version of the format.
pub const MAP_SCHEMA: &str = "ergopath/map/1";
/// Longest gap that is filled unless a map says otherwise, s.
const LONGEST_GAP_S: f64 = 0.2;
/// Longest gap that a map may ask to fill, s: a hand goes 1 m in it.
const MOST_GAP_S: f64 = 1.0;
/// Largest offset of a joint centre from its markers, mm.
pub(super) const MOST_OFFSET_MM: f64 = 500.0;
/// Largest turn about an axis, deg.
pub(super) const MOST_TURN_DEG: f64 = 180.0;
const UPS: [&str; 6] = ["x", "y", "z", "-x", "-y", "-z"];
/// The maps that ship, by name. Owner of `models/maps`.
const SHIPPED: [(&str, &str); 4] = [
    ("opensim", include_str!("../../../models/maps/opensim.toml")),
    ("rigid_bodies", include_str!("../../../models/maps/rigid_bodies.toml")),
    ("plug_in_gait", include_str!("../../../models/maps/plug_in_gait.toml")),
    ("qualisys_sports", include_str!("../../../models/maps/qualisys_sports.toml")),
];

/// Which markers, points or columns of a table make the segments of a person.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// File name, without its path.
    pub name: String,
    /// The axis of the file (0, 1, 2) that points up, and whether it does so backwards; none where the
    /// trunk tells it.
    pub(super) up: Option<(usize, bool)>,
    /// Longest gap that is filled, s.
    pub(super) longest_gap_s: f64,
    /// What tables do not say of themselves.
    table: TableMap,
    /// Segments made of markers, each after those that it needs; or else
    pub(super) parts: Vec<Part>,
    /// segments told by columns, from the pelvis outwards.
    columns: Vec<ColumnPart>,
}

/// What a table does not say of itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::recording) struct TableMap {
    /// Names of the points, three columns each.
    pub points: Vec<String>,
    /// Length of the unit, m.
    pub unit_m: Option<f64>,
    pub rate_hz: Option<f64>,
    /// Size of the unit of angles, rad.
    pub angle_rad: Option<f64>,
    /// Names of the files of a folder, with [`PERSON`] and a body.
    pub files: Option<String>,
}

impl Map {
    /// A map that ships, by its name.
    ///
    /// # Errors
    /// Where there is none of that name.
    pub fn shipped(name: &str) -> Result<Self, InputError> {
        let Some((name, text)) = SHIPPED.iter().find(|(n, _)| *n == name) else {
            let names = || SHIPPED.iter().map(|(n, _)| *n);
            let listed = format!("shipped maps: {}", names().collect::<Vec<_>>().join(", "));
            return Err(InputError::new(name, "there is no shipped map of that name")
                .remedy(suggest(name, names()).unwrap_or(listed)));
        };
        parse_map(Path::new(name), text)
    }

    pub(in crate::recording) fn table(&self) -> &TableMap {
        &self.table
    }

    /// Segments that are told by columns of a table; none where they are made of markers.
    pub(in crate::recording) fn columns(&self) -> &[ColumnPart] {
        &self.columns
    }

    /// The axis that the map says to point up.
    pub(in crate::recording) fn up(&self) -> Option<(usize, bool)> {
        self.up
    }

    /// Whether it maps columns of a table, and not markers.
    pub fn is_of_columns(&self) -> bool {
        self.parts.is_empty()
    }

    /// The segments that it makes.
    pub fn segments(&self) -> impl Iterator<Item = &str> {
        let columns = self.columns.iter().map(|p| p.name.as_str());
        self.parts.iter().map(|p| p.name.as_str()).chain(columns)
    }

    /// The markers, or columns, that it is made of, each once, in order of their names.
    pub fn markers(&self) -> Vec<&str> {
        let columns = self.columns.iter().flat_map(ColumnPart::columns);
        let mut names: Vec<&str> =
            self.parts.iter().flat_map(Part::markers).chain(columns).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Typed {
    schema: Spanned<String>,
    #[serde(default)]
    map: General,
    #[serde(default)]
    segment: BTreeMap<Spanned<String>, TypedPart>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct General {
    base: Option<Spanned<String>>,
    up: Option<Spanned<String>>,
    longest_gap_s: Option<Spanned<f64>>,
    #[serde(default)]
    points: Vec<Spanned<String>>,
    unit: Option<Spanned<String>>,
    angle_unit: Option<Spanned<String>>,
    rate_hz: Option<Spanned<f64>>,
    files: Option<Spanned<String>>,
    pub place: Option<[String; 3]>,
    pub quaternion: Option<[String; 4]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TypedPart {
    joint: Option<Spanned<Names>>,
    #[serde(default)]
    pub offset_mm: Option<Spanned<[f64; 3]>>,
    offset_in: Option<Spanned<String>>,
    offset_along: Option<Spanned<TypedAlong>>,
    pub turn_deg: Option<Spanned<[f64; 3]>>,
    end: Option<Spanned<Names>>,
    ahead: Option<Spanned<TypedDirection>>,
    up: Option<Spanned<TypedDirection>>,
    right: Option<Spanned<TypedDirection>>,
    exact: Option<Spanned<String>>,
    #[serde(default)]
    pub optional: bool,
    pub body: Option<String>,
    pub place: Option<[String; 3]>,
    pub quaternion: Option<[String; 4]>,
    pub rotation_vector: Option<[String; 3]>,
    pub turns: Option<Vec<Spanned<TypedTurn>>>,
    pub axes: Option<Spanned<[String; 3]>>,
    #[serde(default)]
    pub straight: bool,
}

impl TypedPart {
    /// Keys of a segment that is made of markers.
    pub(super) fn keys_of_markers(&self) -> impl Iterator<Item = &'static str> {
        let keys = [
            ("joint", self.joint.is_some()),
            ("offset_in", self.offset_in.is_some()),
            ("offset_along", self.offset_along.is_some()),
            ("end", self.end.is_some()),
            ("ahead", self.ahead.is_some()),
            ("up", self.up.is_some()),
            ("right", self.right.is_some()),
            ("exact", self.exact.is_some()),
        ];
        keys.into_iter().filter(|(_, is_there)| *is_there).map(|(key, _)| key)
    }

    /// Whether columns tell it.
    fn is_of_columns(&self) -> bool {
        self.body.is_some()
            || self.place.is_some()
            || self.quaternion.is_some()
            || self.rotation_vector.is_some()
            || self.turns.is_some()
            || self.axes.is_some()
            || self.straight
    }
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "not the name of a marker, nor a list of such names")]
enum Names {
    One(String),
    Several(Vec<String>),
}

#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "no direction: give two places, [\"FROM\", \"TO\"], or \"as SEGMENT\", or { hinge = [\"A\", \"B\", \"C\"] }"
)]
enum TypedDirection {
    As(String),
    Between([Names; 2]),
    Hinge(TypedHinge),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedAlong {
    direction: TypedDirection,
    mm: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedHinge {
    hinge: [Names; 3],
}

/// A file with its text, for errors that show the place.
pub(super) struct Text<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Text<'_> {
    pub(super) fn fault(
        &self,
        message: impl Into<String>,
        at: Range<usize>,
        remedy: &str,
    ) -> InputError {
        InputError::new(self.path, message).at(self.text, at).remedy(remedy.to_owned())
    }
}

/// Reads a map, or takes the one that ships under a name.
///
/// # Errors
/// Where the file is no map, a segment is not one of [`SEGMENT_NAMES`], lacks a direction, or is made of
/// itself.
pub fn read_map(path: &Path) -> Result<Map, InputError> {
    if path.components().count() == 1 && path.extension().is_none() && !path.exists() {
        return Map::shipped(&path.to_string_lossy());
    }
    let text = read_text(path)?;
    parse_map(path, &text)
}

pub(super) fn parse_map(path: &Path, text: &str) -> Result<Map, InputError> {
    let typed: Typed = parse_toml(path, text)?;
    let file = Text { path, text };
    if typed.schema.as_ref() != MAP_SCHEMA {
        let message = format!("schema `{}` is not `{MAP_SCHEMA}`", typed.schema.as_ref());
        return Err(file.fault(message, typed.schema.span(), "give the version of this format"));
    }
    let general = &typed.map;
    let base = match &general.base {
        None => None,
        Some(name) => Some(
            Map::shipped(name.as_ref()).map_err(|e| e.named_in(path, "base", text, name.span()))?,
        ),
    };
    if typed.segment.is_empty() && base.is_none() {
        return Err(InputError::new(path, "maps no segment").remedy(format!(
            "add [segment.Pelvis] and others; known are {}",
            SEGMENT_NAMES.join(", ")
        )));
    }
    let (mut parts, mut columns) = (Vec::new(), Vec::new());
    for (name, part) in &typed.segment {
        self::segment(&file, name.as_ref(), name.span())?;
        let is_of_columns = part.is_of_columns();
        if is_of_columns {
            columns.push(column_part(&file, general, name, part)?);
        } else {
            parts.push((self::part(&file, name, part)?, name.span()));
        }
        let is_other = |base: &Map| base.is_of_columns() != is_of_columns;
        if (!columns.is_empty() && !parts.is_empty()) || base.as_ref().is_some_and(is_other) {
            let message = format!("{} is told in another way than other segments", name.as_ref());
            return Err(file.fault(
                message,
                name.span(),
                "tell all segments by markers (`joint` and directions) or all by columns",
            ));
        }
    }
    let own_table = table(&file, general)?;
    let own_up = general.up.as_ref().map(|up| self::up(&file, up)).transpose()?;
    let own_gap = general.longest_gap_s.as_ref().map(|gap| longest_gap(&file, gap)).transpose()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let Some(base) = base else {
        columns.sort_by_key(|c| SEGMENT_NAMES.iter().position(|n| *n == c.name));
        return Ok(Map {
            name,
            up: own_up,
            longest_gap_s: own_gap.unwrap_or(LONGEST_GAP_S),
            table: own_table,
            parts: ordered(&file, parts)?,
            columns,
        });
    };
    // What the map says itself goes before what its base says.
    let at = general.base.as_ref().map(Spanned::span).unwrap_or_default();
    let is_new = |name: &str| !typed.segment.keys().any(|own| own.as_ref() == name);
    parts.extend(base.parts.into_iter().filter(|p| is_new(&p.name)).map(|p| (p, at.clone())));
    columns.extend(base.columns.into_iter().filter(|c| is_new(&c.name)));
    columns.sort_by_key(|c| SEGMENT_NAMES.iter().position(|n| *n == c.name));
    Ok(Map {
        name,
        up: own_up.or(base.up),
        longest_gap_s: own_gap.unwrap_or(base.longest_gap_s),
        table: own_table.or(base.table),
        parts: ordered(&file, parts)?,
        columns,
    })
}

impl TableMap {
    /// What is said here, and else there.
    fn or(self, other: Self) -> Self {
        Self {
            points: if self.points.is_empty() { other.points } else { self.points },
            unit_m: self.unit_m.or(other.unit_m),
            rate_hz: self.rate_hz.or(other.rate_hz),
            angle_rad: self.angle_rad.or(other.angle_rad),
            files: self.files.or(other.files),
        }
    }
}

fn up(file: &Text, up: &Spanned<String>) -> Result<(usize, bool), InputError> {
    let place = UPS.iter().position(|u| u == up.as_ref());
    place.map(|i| (i % 3, i >= 3)).ok_or_else(|| {
        let message = format!("up = `{}` is no axis", up.as_ref());
        file.fault(message, up.span(), "give x, y, z, -x, -y or -z, or leave it to the trunk")
    })
}

fn longest_gap(file: &Text, gap: &Spanned<f64>) -> Result<f64, InputError> {
    if (0.0..=MOST_GAP_S).contains(gap.as_ref()) {
        return Ok(*gap.as_ref());
    }
    let message = format!("longest_gap_s = {} is no length of a gap", gap.as_ref());
    Err(file.fault(
        message,
        gap.span(),
        "gaps of 0 to 1 s can be filled; longer ones cut a recording",
    ))
}

fn table(file: &Text, general: &General) -> Result<TableMap, InputError> {
    let mut points: Vec<String> = Vec::new();
    for point in &general.points {
        let name = point.as_ref();
        if name.trim().is_empty() || (name != "-" && points.contains(name)) {
            let message = format!("point `{name}` is there twice or has no name");
            return Err(file.fault(message, point.span(), "name each point once; `-` skips one"));
        }
        points.push(name.clone());
    }
    let unit_m = match &general.unit {
        None => None,
        Some(unit) => Some(unit_m(unit.as_ref()).ok_or_else(|| {
            let message = format!("unit `{}` is unknown", unit.as_ref());
            file.fault(message, unit.span(), KNOWN_UNITS)
        })?),
    };
    let is_rate = |hz: f64| hz > 0.0 && hz <= crate::recording::markers::HIGHEST_RATE_HZ;
    if let Some(rate) = general.rate_hz.as_ref().filter(|r| !is_rate(*r.as_ref())) {
        let message = format!("{} is no rate in Hz", rate.as_ref());
        return Err(file.fault(message, rate.span(), "rates lie between 0 and 10000 Hz"));
    }
    let angle_rad = match &general.angle_unit {
        None => None,
        Some(unit) => Some(match unit.as_ref().as_str() {
            "rad" => 1.0,
            "deg" => 1f64.to_radians(),
            other => {
                let message = format!("angle_unit `{other}` is unknown");
                return Err(file.fault(message, unit.span(), "give \"deg\" or \"rad\""));
            }
        }),
    };
    if let Some(files) = &general.files {
        let marks = [PERSON, BODY].map(|mark| files.as_ref().match_indices(mark).count());
        if marks != [1, 1] {
            let message = format!("files = `{}` names no files", files.as_ref());
            return Err(file.fault(
                message,
                files.span(),
                "give a name with {person} and {body} in it, once each",
            ));
        }
    }
    Ok(TableMap {
        points,
        unit_m,
        rate_hz: general.rate_hz.as_ref().map(|r| *r.as_ref()),
        angle_rad,
        files: general.files.as_ref().map(|f| f.as_ref().clone()),
    })
}

fn part(file: &Text, name: &Spanned<String>, typed: &TypedPart) -> Result<Part, InputError> {
    let fault = |message: &str, remedy: &str| {
        file.fault(format!("{}: {message}", name.as_ref()), name.span(), remedy)
    };
    let Some(joint) = &typed.joint else {
        return Err(fault(
            "nothing tells where it is",
            "give `joint` and two directions for markers, or `turns` or `quaternion` for columns of a table",
        ));
    };
    let joint = mean(file, joint.as_ref(), joint.span())?;
    let mut directions: Vec<Direction> = Vec::new();
    for (axis, typed) in [&typed.ahead, &typed.up, &typed.right].into_iter().enumerate() {
        if let Some(typed) = typed {
            let source = source(file, typed.as_ref(), typed.span())?;
            directions.push(Direction { axis, source });
        }
    }
    if let Some(end) = &typed.end {
        if directions.iter().any(|d| d.axis == 1) {
            return Err(fault("`end` and `up` both say where it points", "give one of the two"));
        }
        let to = [mean(file, end.as_ref(), end.span())?, joint.clone()];
        directions.push(Direction { axis: 1, source: Source::Between(to) });
    }
    let [a, b] = directions.try_into().map_err(|found: Vec<Direction>| {
        let message = format!("{} directions tell its axes, and it takes two", found.len());
        fault(&message, "give two of `end` (or `up`), `ahead` and `right`")
    })?;
    let first = exact(file, typed.exact.as_ref(), [a.axis, b.axis])?;
    let (exact, near) = if a.axis == first { (a, b) } else { (b, a) };
    let offset = three(file, typed.offset_mm.as_ref(), MOST_OFFSET_MM, "offset_mm")?;
    let turn = three(file, typed.turn_deg.as_ref(), MOST_TURN_DEG, "turn_deg")?;
    let offset_in = typed.offset_in.as_ref().map(|s| segment(file, s.as_ref(), s.span()));
    let offset_along = match &typed.offset_along {
        None => None,
        Some(along) => {
            let TypedAlong { direction, mm } = along.as_ref();
            let from = source(file, direction, along.span())?;
            if mm.abs() > MOST_OFFSET_MM || mm.is_nan() {
                let message = format!("offset_along: {mm} mm are too many");
                let remedy = format!("give at most {MOST_OFFSET_MM}");
                return Err(file.fault(message, along.span(), &remedy));
            }
            if matches!(from, Source::As(_)) {
                let remedy = "give offset_in = \"SEGMENT\" and offset_mm instead";
                return Err(file.fault("offset_along names a segment", along.span(), remedy));
            }
            Some((from, 1e-3 * mm))
        }
    };
    Ok(Part {
        name: name.as_ref().clone(),
        joint,
        offset_m: 1e-3 * offset,
        offset_in: offset_in.transpose()?.filter(|s| s != name.as_ref()),
        offset_along,
        turn: UnitQuaternion::from_scaled_axis(turn.map(f64::to_radians)),
        exact,
        near,
        optional: typed.optional,
    })
}

/// The axis that is kept: as stated, or else the long one, or that to the right.
fn exact(
    file: &Text,
    stated: Option<&Spanned<String>>,
    given: [usize; 2],
) -> Result<usize, InputError> {
    let Some(stated) = stated else {
        return Ok(if given.contains(&1) { 1 } else { 2 });
    };
    let axis = match stated.as_ref().as_str() {
        "end" => Some(1),
        word => AXES.iter().position(|a| *a == word),
    };
    axis.filter(|a| given.contains(a)).ok_or_else(|| {
        let message = format!("exact = `{}` is no direction given here", stated.as_ref());
        let remedy = format!("name one of {}", given.map(|a| AXES[a]).join(" and "));
        file.fault(message, stated.span(), &remedy)
    })
}

/// Three numbers about ahead, up and right, none larger than `most`; zero where nothing is stated.
pub(super) fn three(
    file: &Text,
    stated: Option<&Spanned<[f64; 3]>>,
    most: f64,
    key: &str,
) -> Result<Vec3, InputError> {
    let Some(stated) = stated else { return Ok(Vec3::zeros()) };
    let value = *stated.as_ref();
    if value.iter().all(|v| v.abs() <= most) {
        return Ok(value.into());
    }
    let message = format!("{key} = {value:?} is too large");
    let remedy = format!("give ahead, up and right, none larger than {most}");
    Err(file.fault(message, stated.span(), &remedy))
}

fn source(file: &Text, typed: &TypedDirection, at: Range<usize>) -> Result<Source, InputError> {
    match typed {
        TypedDirection::As(word) => {
            let Some(name) = word.strip_prefix(AS) else {
                let message = format!("`{word}` is no direction");
                return Err(file.fault(
                    message,
                    at,
                    "give two places, [\"FROM\", \"TO\"], or \"as SEGMENT\" for the axis of another segment",
                ));
            };
            Ok(Source::As(segment(file, name, at)?))
        }
        TypedDirection::Between([from, to]) => {
            Ok(Source::Between([mean(file, from, at.clone())?, mean(file, to, at)?]))
        }
        TypedDirection::Hinge(TypedHinge { hinge: [a, b, c] }) => Ok(Source::Hinge([
            mean(file, a, at.clone())?,
            mean(file, b, at.clone())?,
            mean(file, c, at)?,
        ])),
    }
}

fn mean(file: &Text, names: &Names, at: Range<usize>) -> Result<Mean, InputError> {
    let names = match names {
        Names::One(name) => std::slice::from_ref(name),
        Names::Several(names) => names.as_slice(),
    };
    if names.is_empty() || names.iter().any(|n| n.trim().is_empty()) {
        return Err(file.fault("names no marker", at, "give at least one name"));
    }
    names
        .iter()
        .map(|name| match name.strip_prefix(JOINT_OF) {
            Some(joint) => Ok(Point::Joint(segment(file, joint, at.clone())?)),
            None => Ok(Point::Marker(name.clone())),
        })
        .collect()
}

fn segment(file: &Text, name: &str, at: Range<usize>) -> Result<String, InputError> {
    if SEGMENT_NAMES.contains(&name) {
        return Ok(name.to_owned());
    }
    let near = suggest(name, SEGMENT_NAMES);
    let remedy = near.unwrap_or_else(|| format!("known are {}", SEGMENT_NAMES.join(", ")));
    Err(file.fault(format!("`{name}` is no segment"), at, &remedy))
}

/// The segments, each after those that it is made of.
fn ordered(file: &Text, parts: Vec<(Part, Range<usize>)>) -> Result<Vec<Part>, InputError> {
    let names: Vec<String> = parts.iter().map(|(p, _)| p.name.clone()).collect();
    for (part, at) in &parts {
        if let Some(lost) = part.needs().find(|n| !names.iter().any(|k| k == n)) {
            let message = format!("{} needs the segment {lost}, which is not mapped", part.name);
            let remedy = format!("add [segment.{lost}]; mapped are {}", names.join(", "));
            return Err(file.fault(message, at.clone(), &remedy));
        }
    }
    let mut rest = parts;
    let mut done: Vec<Part> = Vec::new();
    while !rest.is_empty() {
        let is_ready = |part: &Part| part.needs().all(|n| done.iter().any(|d| d.name == n));
        let Some(next) = rest.iter().position(|(part, _)| is_ready(part)) else {
            let circle: Vec<&str> = rest.iter().map(|(p, _)| p.name.as_str()).collect();
            let message = format!("{} are made of each other", circle.join(", "));
            return Err(file.fault(
                message,
                rest[0].1.clone(),
                "make one of them of markers alone",
            ));
        };
        done.push(rest.remove(next).0);
    }
    Ok(done)
}

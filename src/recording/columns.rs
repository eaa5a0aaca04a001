//! Segments told by columns of tables: poses in the world, or turns of one segment in the one before it, which are
//! put on a body as the table holds no lengths.
//!
//! ```text
//! placed     R = R_columns C           p = p_columns + R offset
//! hung       R = R_before R_columns C  p along the body's joint centres from the segment before
//! ```
//! C brings the axes of the columns to those of the segment. Where segments between two that are told are not told
//! themselves, they take their usual share of the turn, for the place of what hangs on them only.

use super::axes::{NEXT, SEGMENT_NAMES, before};
use super::checks::{make_continuous, note_oddities, unit};
use super::map::{ByColumns, ColumnPart, Map, Origin, vertical};
use super::{Recording, Remark, SegmentTrack};
use crate::files::{InputError, NumericTable, suggest};
use crate::human::{Body, SPINE_SHARES};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::{Vec3, stats};
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

/// A remark of this size is one that changes what is learned.
const LOUD: f64 = 1.0;
/// Range of a column that is counted in an unknown direction and tells it, rad.
const TELLING: f64 = 0.17;
/// Departure of the height of the hips from that of the body that is worth a word.
const HEIGHT_DIFFERS: f64 = 0.03;
/// Height of a pelvis that nobody has, m.
const TOO_HIGH_M: f64 = 3.0;
/// The body of whom nobody says how tall he is.
const DEFAULT_BODY: &str = "male_p50";
/// Names of columns that are told at once.
const FEW: usize = 8;

/// A table of numbers over time.
pub(super) struct OneTable {
    pub path: PathBuf,
    /// The body whose own file it is.
    pub body: Option<String>,
    pub table: NumericTable,
}

/// Tables of as many rows: one of all segments, or one for each.
pub(super) struct Tables {
    pub all: Vec<OneTable>,
    pub rate_hz: f64,
    /// Length of the unit of places, m, and size of that of angles, rad.
    pub unit_m: f64,
    pub angle: Angle,
    /// What a reader should know of them.
    pub remarks: Vec<Remark>,
}

/// The unit of angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Angle {
    /// Size, rad; none where nothing tells it.
    pub rad: Option<f64>,
    /// Whether a file says it, which may be wrong, and not the map.
    pub is_doubtful: bool,
}

/// A part with the columns that its table has.
struct Found<'a> {
    part: &'a ColumnPart,
    from: &'a OneTable,
    /// None where a column is missing, and taken as zero.
    place: Option<[Option<usize>; 3]>,
    rotation: Vec<Option<usize>>,
}

/// Makes a recording of what a map says of tables.
///
/// # Errors
/// Where a column is missing that is not optional, nothing tells what is up or which unit is meant.
pub(super) fn record(
    origin: &Origin,
    tables: &Tables,
    map: &Map,
    body: Option<&Body>,
) -> Result<Recording, InputError> {
    let (found, lost) = find(origin, tables, map)?;
    let signs = sign(&found, tables);
    refuse_doubtful_unit(&found, tables)?;
    let own;
    let body = if let Some(body) = body {
        body
    } else {
        own = Body::load(DEFAULT_BODY, "".as_ref())?;
        &own
    };
    let mut made: BTreeMap<&str, SegmentTrack> = BTreeMap::new();
    for one in &found {
        let turns = turns(one, tables, signs.factor)?;
        let track = match &one.place {
            Some(columns) => placed(one, *columns, turns, tables.unit_m),
            None => hung(one, turns, &made, body)?,
        };
        made.insert(&one.part.name, track);
    }
    let trunk = made.get("T8").or_else(|| made.get("Pelvis"));
    let trunk = trunk.map(|t| {
        t.rotation.iter().map(|r| r * Vec3::y()).sum::<Vec3>() / t.rotation.len().max(1) as f64
    });
    let up = vertical(origin.path, map.up(), trunk.unwrap_or_default())?;
    let mut segments: Vec<SegmentTrack> = Vec::with_capacity(made.len());
    for name in SEGMENT_NAMES {
        let Some(mut track) = made.remove(name) else { continue };
        track.position.iter_mut().for_each(|p| *p = up.turn * *p);
        track.rotation.iter_mut().for_each(|r| *r = up.turn * *r);
        make_continuous(&mut track.rotation);
        segments.push(track);
    }
    let mut recording = Recording {
        source: origin.source.clone(),
        format: origin.format,
        sha256: origin.sha256.clone(),
        rate_hz: tables.rate_hz,
        segments,
        segment_lengths_m: Vec::new(),
        remarks: tables.remarks.clone(),
    };
    let is_placed = |name: &str| found.iter().any(|f| f.part.name == name && f.place.is_some());
    recording.segment_lengths_m = lengths(&recording, is_placed);
    let told = [
        unknown(&found),
        lost_ones(&found, &lost),
        on_body(&found, body),
        height(&recording, &found, body),
        signs.remark,
    ];
    recording.remarks.extend(told.into_iter().flatten());
    recording.remarks.push(Remark::new("vertical", up.word));
    recording.remarks.extend(unused(&found, tables, map));
    note_oddities(&mut recording);
    Ok(recording)
}

/// The parts whose columns are there, from the pelvis outwards, and those that are left out.
fn find<'a>(
    origin: &Origin,
    tables: &'a Tables,
    map: &'a Map,
) -> Result<(Vec<Found<'a>>, Vec<&'a ColumnPart>), InputError> {
    let (mut found, mut lost): (Vec<Found>, Vec<&ColumnPart>) = (Vec::new(), Vec::new());
    for part in map.columns() {
        let table = tables.all.iter().find(|t| t.body.is_none() || t.body == part.body);
        // A folder may lack the file of a body.
        let Some(from) = table else {
            lost.push(part);
            continue;
        };
        let at = |name: &str| from.table.columns.iter().position(|c| c == name);
        let place = part.place.as_ref().map(|names| names.each_ref().map(|name| at(name)));
        let rotation: Vec<Option<usize>> = part.rotation.columns().map(at).collect();
        let missing = part.columns().find(|name| at(name).is_none());
        let may_lack_some = matches!(part.rotation, ByColumns::Turns(_)) && part.optional;
        let is_empty = rotation.iter().all(Option::is_none) && !part.straight;
        if let Some(name) = missing.filter(|_| !part.optional) {
            let known = || from.table.columns.iter().map(String::as_str);
            let listed = format!("its columns are: {}", few(known()));
            let message =
                format!("has no column `{name}`, by which {} tells {}", map.name, part.name);
            return Err(InputError::new(&from.path, message)
                .remedy(suggest(name, known()).unwrap_or(listed)));
        }
        let hangs_on = part.place.is_none().then(|| told_before(map, &part.name)).flatten();
        let is_loose = part.place.is_none() && part.name != "Pelvis" && hangs_on.is_none();
        if is_loose {
            let message = format!("{} has no place, and no segment before it is mapped", part.name);
            return Err(InputError::new(origin.path, message)
                .remedy("map the Pelvis too, or give the columns of its place"));
        }
        let hangs_on_lost = hangs_on.is_some_and(|name| lost.iter().any(|l| l.name == name));
        if (missing.is_some() && (!may_lack_some || is_empty)) || hangs_on_lost {
            lost.push(part);
        } else {
            found.push(Found { part, from, place, rotation });
        }
    }
    if found.is_empty() {
        let known = tables.all.iter().flat_map(|t| t.table.columns.iter().map(String::as_str));
        let message = format!("holds nothing that the map `{}` names", map.name);
        return Err(InputError::new(origin.path, message)
            .remedy(format!("its columns are: {}; say with --map what they are", few(known))));
    }
    Ok((found, lost))
}

/// The nearest segment before one that the map tells.
fn told_before<'a>(map: &'a Map, name: &str) -> Option<&'a str> {
    let mut at = before(name);
    while let Some(name) = at {
        if let Some(part) = map.columns().iter().find(|p| p.name == name) {
            return Some(&part.name);
        }
        at = before(name);
    }
    None
}

/// The turn of a segment at every row, with what brings it to the segment's axes.
fn turns(
    found: &Found,
    tables: &Tables,
    mostly: f64,
) -> Result<Vec<UnitQuaternion<f64>>, InputError> {
    let OneTable { path, table, .. } = found.from;
    let angle = tables.angle.rad.unwrap_or(1.0);
    let mut turns = Vec::with_capacity(table.rows.len());
    for (i, row) in table.rows.iter().enumerate() {
        let value = |k: usize| found.rotation.get(k).copied().flatten().map_or(0.0, |c| row[c]);
        let told = match &found.part.rotation {
            ByColumns::Quaternion(_) => {
                let [w, x, y, z] = [0, 1, 2, 3].map(value);
                unit(w, x, y, z).map_err(|norm| {
                    InputError::new(
                        path,
                        format!(
                            "row {} (frame {i}): the quaternion has norm {norm:.3}, not 1",
                            i + 1
                        ),
                    )
                    .remedy("remove the row from the files of all bodies, or repair it")
                })?
            }
            ByColumns::Vector(_) => {
                UnitQuaternion::from_scaled_axis(angle * Vec3::from([0, 1, 2].map(value)))
            }
            ByColumns::Turns(turns) => turns
                .iter()
                .enumerate()
                .map(|(k, turn)| {
                    let sign = if turn.mostly_positive { mostly } else { 1.0 };
                    let by = sign * angle * value(k) + turn.offset;
                    UnitQuaternion::from_scaled_axis(by * turn.about)
                })
                .fold(UnitQuaternion::identity(), |all, next| all * next),
        };
        turns.push(told * found.part.turn);
    }
    Ok(turns)
}

fn placed(
    found: &Found,
    columns: [Option<usize>; 3],
    rotation: Vec<UnitQuaternion<f64>>,
    unit_m: f64,
) -> SegmentTrack {
    let offset = found.part.offset_m;
    let position = found.from.table.rows.iter().zip(&rotation).map(|(row, turn)| {
        let at = columns.map(|c| c.map_or(0.0, |c| row[c]));
        unit_m * Vec3::from(at) + turn * offset
    });
    SegmentTrack { name: found.part.name.clone(), position: position.collect(), rotation }
}

/// A segment that hangs on the one before it, at the joint centres of a body.
fn hung(
    found: &Found,
    turns: Vec<UnitQuaternion<f64>>,
    made: &BTreeMap<&str, SegmentTrack>,
    body: &Body,
) -> Result<SegmentTrack, InputError> {
    let name = found.part.name.as_str();
    // From the segment that is known to this one.
    let mut way = vec![name];
    let mut at = before(name);
    let known = loop {
        match at.map(|name| (name, made.get(name))) {
            Some((_, Some(track))) => break Some(track),
            Some((name, None)) => way.push(name),
            None => break None,
        }
        at = at.and_then(before);
    };
    let Some(known) = known else {
        // A pelvis without a place stands where it is.
        let position = vec![Vec3::zeros(); turns.len()];
        return Ok(SegmentTrack { name: name.to_owned(), position, rotation: turns });
    };
    way.reverse();
    let steps = steps(&known.name, &way, body)?;
    let (mut position, mut rotation) = (Vec::new(), Vec::new());
    for (i, turn) in turns.iter().enumerate() {
        let (from, whole) = (known.rotation[i], turn.scaled_axis());
        let (mut p, mut r) = (known.position[i], from);
        for (step, share) in &steps {
            p += r * step;
            r = from * UnitQuaternion::from_scaled_axis(*share * whole);
        }
        position.push(p + r * found.part.offset_m);
        rotation.push(from * turn);
    }
    Ok(SegmentTrack { name: name.to_owned(), position, rotation })
}

/// From joint centre to joint centre in the zero pose of a body, and the share of the whole turn there.
fn steps(from: &str, way: &[&str], body: &Body) -> Result<Vec<(Vec3, f64)>, InputError> {
    let tips: Vec<Tip> = std::iter::once(from).chain(way.iter().copied()).map(Tip::link).collect();
    let chain = Linkage::new(&body.model, "Pelvis", &tips)
        .map_err(|e| InputError::fault(&body.name, e.to_string()))?;
    let mut frames = Frames::default();
    chain.forward(&vec![0.0; chain.dof()], &mut frames);
    let place = |tip: usize| chain.tip_frame(&frames, tip).0;
    let weight = |name: &str| {
        let spine = ["L5", "L3", "T12", "T8"].iter().position(|n| *n == name);
        match spine {
            Some(i) => SPINE_SHARES[i],
            // Collar bones go with the trunk unless they are told.
            None if name.ends_with("Shoulder") && way.len() > 1 => 0.0,
            None => 1.0,
        }
    };
    let whole: f64 = way.iter().map(|n| weight(n)).sum();
    let mut sum = 0.0;
    Ok(way
        .iter()
        .enumerate()
        .map(|(i, name)| {
            sum += weight(name);
            (place(i + 1) - place(i), sum / whole)
        })
        .collect())
}

/// Median over time of the place of one joint centre in the axes of another segment: solved skeletons stretch a
/// little.
fn offset(recording: &Recording, from: &str, to: &str) -> Option<Vec3> {
    let (a, b) = (recording.segment(from)?, recording.segment(to)?);
    let local: Vec<Vec3> = (0..recording.frames())
        .map(|i| a.rotation[i].inverse() * (b.position[i] - a.position[i]))
        .collect();
    let middle =
        |axis: usize| stats::quantile(&local.iter().map(|v| v[axis]).collect::<Vec<_>>(), 0.5);
    Some(Vec3::new(middle(0), middle(1), middle(2)))
}

/// Lengths along the chain from each segment to the next that is there, across the shoulders and the hips, of
/// segments that were placed: others have those of the body.
fn lengths(recording: &Recording, is_placed: impl Fn(&str) -> bool) -> Vec<(String, f64)> {
    let offset = |from: &str, to: &str| {
        (is_placed(from) && is_placed(to)).then(|| offset(recording, from, to)).flatten()
    };
    let next = |name: &str| NEXT.iter().find(|(from, _)| *from == name).map(|(_, to)| *to);
    let mut lengths = Vec::new();
    for track in &recording.segments {
        let mut to = next(&track.name);
        while let Some(name) = to.filter(|name| recording.segment(name).is_none()) {
            to = next(name);
        }
        let length = to.and_then(|to| offset(&track.name, to));
        lengths.extend(length.map(|v| (track.name.clone(), v.norm())));
    }
    // Collar bones are parallel to the trunk in the zero pose, so that offsets add up.
    let shoulder = |side: &str| {
        let [collar, arm] = ["Shoulder", "UpperArm"].map(|part| format!("{side}{part}"));
        let on_collar = || Some(offset("T8", &collar)? + offset(&collar, &arm)?);
        on_collar().or_else(|| offset("T8", &arm))
    };
    let hip = |side: &str| offset("Pelvis", &format!("{side}UpperLeg"));
    for (name, right, left) in [
        ("ShoulderToShoulder", shoulder("Right"), shoulder("Left")),
        ("HipToHip", hip("Right"), hip("Left")),
    ] {
        lengths.extend(right.zip(left).map(|(r, l)| (name.to_owned(), (r - l).norm())));
    }
    lengths
}

/// The direction in which columns are counted whose direction differs between models.
struct Signs {
    factor: f64,
    remark: Option<Remark>,
}

fn sign(found: &[Found], tables: &Tables) -> Signs {
    let angle = tables.angle.rad.unwrap_or(1.0);
    let (mut least, mut most) = (0.0f64, 0.0f64);
    let mut names = Vec::new();
    for one in found {
        let ByColumns::Turns(turns) = &one.part.rotation else { continue };
        for (turn, column) in turns.iter().zip(&one.rotation) {
            let Some(column) = column.filter(|_| turn.mostly_positive) else { continue };
            names.push(turn.column.as_str());
            for row in &one.from.table.rows {
                least = least.min(angle * row[column]);
                most = most.max(angle * row[column]);
            }
        }
    }
    let factor = if most >= -least { 1.0 } else { -1.0 };
    let remark = (!names.is_empty() && most - least > TELLING).then(|| {
        let text = format!(
            "{} from {:.0} to {:.0} deg: most of it is taken as bending, so bending is counted {}",
            names.join(" and "),
            least.to_degrees(),
            most.to_degrees(),
            if factor > 0.0 { "positive" } else { "negative" }
        );
        Remark::new("counted", text)
    });
    Signs { factor, remark }
}

/// Refuses angles whose unit is not told, or cannot be the one that is told.
fn refuse_doubtful_unit(found: &[Found], tables: &Tables) -> Result<(), InputError> {
    const SAY: &str = "say which under [map]: angle_unit = \"deg\" or \"rad\"";
    let of_angles =
        |f: &&Found| !matches!(f.part.rotation, ByColumns::Quaternion(_)) && !f.rotation.is_empty();
    let Some(first) = found.iter().find(of_angles) else { return Ok(()) };
    let Some(angle) = tables.angle.rad else {
        let message = "does not say whether its angles are degrees or radians";
        return Err(InputError::new(&first.from.path, message).remedy(SAY));
    };
    if !tables.angle.is_doubtful {
        return Ok(());
    }
    let mut largest = (0.0f64, first, 0, 0);
    for one in found.iter().filter(of_angles) {
        for column in one.rotation.iter().flatten() {
            for (i, row) in one.from.table.rows.iter().enumerate() {
                if row[*column].abs() > largest.0 {
                    largest = (row[*column].abs(), one, *column, i);
                }
            }
        }
    }
    let (value, one, column, row) = largest;
    let OneTable { path, table, .. } = one.from;
    let name = &table.columns[column];
    if angle == 1.0 && value > TAU {
        let message = format!(
            "line {}, column `{name}`: {} would be {:.0} deg, as the header says that angles are not in degrees; \
             are they?",
            table.line(row),
            table.rows[row][column],
            value.to_degrees()
        );
        return Err(InputError::new(path, message).remedy(SAY));
    }
    // Nobody keeps all joints within 3 deg of the zero pose.
    if angle < 1.0 && value > 0.0 && value <= PI && table.rows.len() > 1 {
        let message = format!(
            "no angle is larger than {value:.2} (line {}, column `{name}`), and the header says that angles are in \
             degrees; are they in radians?",
            table.line(row)
        );
        return Err(InputError::new(path, message).remedy(SAY));
    }
    let high = found.iter().find(|f| f.part.name == "Pelvis");
    let height = high.and_then(|f| Some((f, f.place?[1]?)));
    if let Some((f, column)) = height {
        let heights: Vec<f64> = f.from.table.rows.iter().map(|r| r[column].abs()).collect();
        let middle = tables.unit_m * stats::quantile(&heights, 0.5);
        if middle > TOO_HIGH_M {
            let message = format!(
                "column `{}`: a pelvis at {middle:.0} m; are its places in another unit?",
                f.from.table.columns[column]
            );
            return Err(InputError::new(&f.from.path, message)
                .remedy("say which under [map]: unit = \"mm\", or \"cm\", \"m\""));
        }
    }
    Ok(())
}

/// Turns that no column tells, of segments that are there.
fn unknown(found: &[Found]) -> Option<Remark> {
    let mut told = Vec::new();
    for one in found {
        let names: Vec<&str> = one.part.rotation.columns().collect();
        let missing: Vec<&str> =
            names.iter().zip(&one.rotation).filter(|(_, c)| c.is_none()).map(|(n, _)| *n).collect();
        if names.is_empty() || missing.is_empty() {
            continue;
        }
        let what = if missing.len() == names.len() {
            "taken as in line with the segment before it"
        } else {
            "taken as zero"
        };
        told.push(format!("{} ({}: {what})", missing.join(", "), one.part.name));
    }
    let axes: Vec<&str> = found
        .iter()
        .filter_map(|f| Some((f.part.place.as_ref()?, f.place?)))
        .flat_map(|(names, found)| {
            names.iter().zip(found).filter(|(_, c)| c.is_none()).map(|(n, _)| n.as_str())
        })
        .collect();
    if !axes.is_empty() {
        told.push(format!("{} (taken as zero)", axes.join(", ")));
    }
    (!told.is_empty()).then(|| {
        let text = format!("not in the file, so unknown: {}", told.join("; "));
        Remark::new("unknown turns", text).of_size(LOUD)
    })
}

/// Segments that are left out.
fn lost_ones(found: &[Found], lost: &[&ColumnPart]) -> Option<Remark> {
    (!lost.is_empty() && !found.is_empty()).then(|| {
        let names: Vec<&str> = lost.iter().map(|l| l.name.as_str()).collect();
        let text = format!("not in the file, left out: {}", names.join(", "));
        Remark::new("lost segments", text).of_size(lost.len() as f64)
    })
}

/// On whose body segments without a place were put.
fn on_body(found: &[Found], body: &Body) -> Option<Remark> {
    let hangs = found.iter().any(|f| f.place.is_none());
    hangs.then(|| {
        let text = format!(
            "the file holds angles and no lengths: put on the body `{}` of {:.2} m (--body gives another)",
            body.name, body.size.stature_m
        );
        Remark::new("lengths", text).of_size(LOUD)
    })
}

/// Whether the hips are as high over the floor as those of the body would be.
fn height(recording: &Recording, found: &[Found], body: &Body) -> Option<Remark> {
    let is_hung = |name: &str| found.iter().any(|f| f.part.name == name && f.place.is_none());
    let pelvis = recording.segment("Pelvis")?;
    let feet = ["Right", "Left"].map(|side| recording.segment(&format!("{side}Foot")));
    let [Some(right), Some(left)] = feet else { return None };
    let legs = ["RightUpperLeg", "RightLowerLeg", "RightFoot"];
    if is_hung("Pelvis") || !legs.iter().all(|name| is_hung(name)) {
        return None;
    }
    let steps = steps("Pelvis", &legs, body).ok()?;
    let leg = -steps.iter().map(|(step, _)| step.y).sum::<f64>();
    // Ankles of a body that stands are so high.
    let ankle = body.standing_pelvis_height_m - leg;
    let ratios: Vec<f64> = (0..recording.frames())
        .map(|i| {
            let lower = right.position[i].z.min(left.position[i].z);
            pelvis.position[i].z / (pelvis.position[i].z - lower + ankle)
        })
        .collect();
    let ratio = stats::quantile(&ratios, 0.5);
    ((ratio - 1.0).abs() > HEIGHT_DIFFERS && ratio.is_finite()).then(|| {
        let text = format!(
            "the hips are {:.0} % {} than those of the body `{}` would be: is the person about {:.2} m tall, or the \
             floor not at height zero?",
            100.0 * (ratio - 1.0).abs(),
            if ratio > 1.0 { "higher" } else { "lower" },
            body.name,
            ratio * body.size.stature_m
        );
        Remark::new("height of the hips", text).of_size(LOUD)
    })
}

/// Columns that no segment is told by.
fn unused(found: &[Found], tables: &Tables, map: &Map) -> Option<Remark> {
    // A file for each segment holds its own columns alone.
    let [OneTable { table, .. }] = tables.all.as_slice() else { return None };
    let used = |c: &str| found.iter().any(|f| f.part.columns().any(|own| own == c));
    let is_time = |c: &str| c.eq_ignore_ascii_case("time") || c.eq_ignore_ascii_case("time_s");
    let rest: Vec<&str> =
        table.columns.iter().map(String::as_str).filter(|c| !used(c) && !is_time(c)).collect();
    (!rest.is_empty()).then(|| {
        let text = format!(
            "{} columns are not used by the map `{}`: {}",
            rest.len(),
            map.name,
            few(rest.iter().copied())
        );
        Remark::new("unused columns", text)
    })
}

/// The first few of some names, and how many more there are.
fn few<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let shown = names[..names.len().min(FEW)].join(", ");
    match names.len().saturating_sub(FEW) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

#[cfg(test)]
mod tests;

//! C3D files of Intel numbers: a header, parameters, and frames of points and analogue values.
//!
//! Blocks are of 512 bytes and counted from 1. A frame holds four numbers for each point (x, y, z, and a
//! residual that is negative where the point was not seen), all 32-bit floats or all 16-bit integers to
//! be scaled, and then its analogue values of the same size. The description of the format is public
//! (c3d.org).

use super::{HIGHEST_RATE_HZ, KNOWN_UNITS, Markers, unit_m, without_people};
use crate::files::{InputError, read_bytes};
use crate::math::Vec3;
use std::path::Path;

const BLOCK: usize = 512;
/// The second byte of every file.
const KEY: u8 = 0x50;
/// The processor whose numbers are read.
const INTEL: u8 = 84;
/// Lists of what are no places although they stand among the points.
const NO_PLACES: [&str; 5] = ["ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS"];
/// What no coordinate reaches, m.
const LARGEST_M: f64 = 1e4;

const AGAIN: &str = "copy or export the file again";

/// What is wrong, and what to do.
#[derive(Debug)]
struct Fault(String, &'static str);

fn fault<T>(message: impl Into<String>, remedy: &'static str) -> Result<T, Fault> {
    Err(Fault(message.into(), remedy))
}

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<Markers, InputError> {
    let bytes = read_bytes(path)?;
    parse(&bytes).map_err(|Fault(message, remedy)| InputError::new(path, message).remedy(remedy))
}

fn parse(bytes: &[u8]) -> Result<Markers, Fault> {
    let file = Bytes(bytes);
    let header = Header::read(file)?;
    let parameters = Parameters::read(file, header.parameters)?;
    let rate_hz = parameters.number("POINT", "RATE").unwrap_or(header.rate_hz);
    if !(rate_hz > 0.0 && rate_hz <= HIGHEST_RATE_HZ) {
        return fault(format!("{rate_hz} is no rate of frames, Hz"), AGAIN);
    }
    let unit = parameters.text("POINT", "UNITS").unwrap_or_default();
    let Some(unit_m) = unit_m(&unit) else {
        let shown: String = unit.chars().take(20).collect();
        return fault(
            format!("its parameter POINT:UNITS, `{shown}`, is no unit of length"),
            KNOWN_UNITS,
        );
    };
    let labels = parameters.labels(header.points);
    let kept = places(&parameters, &labels);
    let frames = parameters.frames(&header)?;
    let positions = positions(file, &header, frames, unit_m, &kept)?;
    let labels: Vec<String> = kept.iter().map(|i| labels[*i].clone()).collect();
    Ok(Markers { rate_hz, names: without_people(&labels), positions })
}

/// The points that are places: all but those that the program worked out of them.
fn places(parameters: &Parameters, labels: &[String]) -> Vec<usize> {
    let computed: Vec<String> =
        NO_PLACES.iter().flat_map(|name| parameters.texts("POINT", name)).collect();
    (0..labels.len()).filter(|i| labels[*i].is_empty() || !computed.contains(&labels[*i])).collect()
}

/// The bytes of a file, read where they are.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    fn byte(self, at: usize) -> Option<u8> {
        self.0.get(at).copied()
    }

    fn word(self, at: usize) -> Option<u16> {
        self.take(at).map(u16::from_le_bytes)
    }

    fn float(self, at: usize) -> Option<f64> {
        self.take(at).map(f32::from_le_bytes).map(f64::from)
    }

    fn slice(self, at: usize, length: usize) -> Option<&'a [u8]> {
        self.0.get(at..at.checked_add(length)?)
    }
}

/// What the first block says of the frames.
struct Header {
    parameters: usize,
    points: usize,
    /// Analogue values in each frame.
    analogues: usize,
    first: u16,
    last: u16,
    /// Negative where numbers are floats; otherwise the unit of integers.
    scale: f64,
    /// Byte at which the frames begin.
    data: usize,
    rate_hz: f64,
}

impl Header {
    fn read(file: Bytes) -> Result<Self, Fault> {
        if file.byte(1) != Some(KEY) {
            return fault("is no C3D file: its second byte is not 0x50", "give a .c3d file");
        }
        let header = || {
            Some(Self {
                parameters: usize::from(file.byte(0)?),
                points: usize::from(file.word(2)?),
                analogues: usize::from(file.word(4)?),
                first: file.word(6)?,
                last: file.word(8)?,
                scale: file.float(12)?,
                data: usize::from(file.word(16)?),
                rate_hz: file.float(20)?,
            })
        };
        let Some(mut header) = header().filter(|_| file.0.len() >= BLOCK) else {
            return fault("is cut off within its header", AGAIN);
        };
        let blocks = [header.parameters, header.data].map(|block| block.checked_sub(1));
        let [Some(parameters), Some(data)] = blocks else {
            return fault("its header names no block of parameters or frames", AGAIN);
        };
        (header.parameters, header.data) = (parameters * BLOCK, data * BLOCK);
        if header.points == 0 {
            return fault("holds no markers", "export it with the marker trajectories");
        }
        if header.scale == 0.0 || !header.scale.is_finite() {
            return fault(format!("its header has a scale of {}", header.scale), AGAIN);
        }
        Ok(header)
    }
}

/// A parameter: its group's number, its name, and its values.
struct Parameter<'a> {
    group: i8,
    name: String,
    /// -1: text, 1: bytes, 2: integers, 4: floats.
    kind: i8,
    dimensions: Vec<usize>,
    data: Bytes<'a>,
}

/// The parameters of a file, and the names of their groups.
struct Parameters<'a> {
    groups: Vec<(i8, String)>,
    all: Vec<Parameter<'a>>,
}

impl<'a> Parameters<'a> {
    fn read(file: Bytes<'a>, start: usize) -> Result<Self, Fault> {
        match file.byte(start + 3) {
            Some(INTEL) => {}
            Some(85 | 86) => {
                return fault(
                    "holds numbers of a DEC or MIPS processor, which are not read",
                    "export it with Intel (PC) numbers",
                );
            }
            _ => return fault("has no section of parameters", AGAIN),
        }
        let mut found = Self { groups: Vec::new(), all: Vec::new() };
        let mut at = start + 4;
        // Every record says where the next one begins, behind itself.
        loop {
            match found.record(file, at) {
                Some(0) => return Ok(found),
                Some(next) => at = next,
                None => {
                    return fault(format!("its parameters are damaged at byte {at}"), AGAIN);
                }
            }
        }
    }

    /// Reads the record at a byte: where the next one begins, 0 behind the last; nothing where the
    /// record is damaged.
    fn record(&mut self, file: Bytes<'a>, at: usize) -> Option<usize> {
        let [length, group] = file.take(at)?.map(|b: u8| b.cast_signed());
        if length == 0 {
            return Some(0);
        }
        let name_length = usize::from(length.unsigned_abs());
        let name = text(file.slice(at + 2, name_length)?).to_ascii_uppercase();
        let pointer = at + 2 + name_length;
        let step = usize::from(file.word(pointer)?);
        if group < 0 {
            self.groups.push((group.checked_neg()?, name));
        } else {
            let kind = file.byte(pointer + 2)?.cast_signed();
            let count = usize::from(file.byte(pointer + 3)?);
            let dimensions = file.slice(pointer + 4, count)?;
            let dimensions: Vec<usize> = dimensions.iter().map(|d| usize::from(*d)).collect();
            let size = dimensions.iter().try_fold(1_usize, |size, d| size.checked_mul(*d))?;
            let size = size.checked_mul(usize::from(kind.unsigned_abs()))?;
            let data = Bytes(file.slice(pointer + 4 + count, size)?);
            self.all.push(Parameter { group, name, kind, dimensions, data });
        }
        Some(if step > 0 { pointer + step } else { 0 })
    }

    fn find(&self, group: &str, name: &str) -> Option<&Parameter<'a>> {
        let (number, _) = self.groups.iter().find(|(_, n)| n == group)?;
        self.all.iter().find(|p| p.group == *number && p.name == name)
    }

    /// The first number of a parameter.
    fn number(&self, group: &str, name: &str) -> Option<f64> {
        let parameter = self.find(group, name)?;
        match parameter.kind {
            2 => parameter.data.word(0).map(f64::from),
            4 => parameter.data.float(0),
            _ => None,
        }
    }

    fn text(&self, group: &str, name: &str) -> Option<String> {
        self.find(group, name).filter(|p| p.kind == -1).map(|p| text(p.data.0))
    }

    /// The texts of a parameter, one after the other.
    fn texts(&self, group: &str, name: &str) -> Vec<String> {
        let parameter = self.find(group, name).filter(|p| p.kind == -1);
        let width =
            parameter.and_then(|p| p.dimensions.first()).copied().filter(|width| *width > 0);
        match (parameter, width) {
            (Some(parameter), Some(width)) => parameter.data.0.chunks(width).map(text).collect(),
            _ => Vec::new(),
        }
    }

    /// Labels of all points; those beyond the 255th stand in lists of their own.
    fn labels(&self, count: usize) -> Vec<String> {
        let mut labels = self.texts("POINT", "LABELS");
        for list in 2.. {
            let more = self.texts("POINT", &format!("LABELS{list}"));
            if more.is_empty() {
                break;
            }
            labels.extend(more);
        }
        labels.resize(count, String::new());
        labels
    }

    /// Number of frames: the header's numbers end at 65535, and longer files say more elsewhere.
    fn frames(&self, header: &Header) -> Result<usize, Fault> {
        let field = |name: &str| {
            let data = self.find("TRIAL", name).filter(|p| p.kind == 2)?.data;
            Some(usize::from(data.word(0)?) + (usize::from(data.word(2)?) << 16))
        };
        let (first, last) = match (field("ACTUAL_START_FIELD"), field("ACTUAL_END_FIELD")) {
            (Some(first), Some(last)) if last > 0 => (first, last),
            _ => (usize::from(header.first), usize::from(header.last)),
        };
        match (last + 1).checked_sub(first) {
            Some(frames) if frames > 0 => Ok(frames),
            _ => fault(format!("its frames go from {first} to {last}"), AGAIN),
        }
    }
}

/// Text without the blanks that fill it up.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_matches([' ', '\0']).to_owned()
}

fn positions(
    file: Bytes,
    header: &Header,
    frames: usize,
    unit_m: f64,
    kept: &[usize],
) -> Result<Vec<Vec<Option<Vec3>>>, Fault> {
    let is_float = header.scale < 0.0;
    let size = if is_float { 4 } else { 2 };
    let stride = (4 * header.points + header.analogues) * size;
    let wanted = stride.checked_mul(frames).and_then(|all| all.checked_add(header.data));
    if wanted.is_none_or(|wanted| wanted > file.0.len()) {
        let found = file.0.len().saturating_sub(header.data) / stride;
        return fault(format!("is cut off: {found} of {frames} frames are there"), AGAIN);
    }
    let number = |at: usize| {
        if is_float {
            return file.float(at).map(|v| v * unit_m);
        }
        file.word(at).map(|v| f64::from(v.cast_signed()) * header.scale * unit_m)
    };
    let place = |start: usize| {
        let [x, y, z] = [0, 1, 2].map(|k| number(start + k * size));
        let is_seen = number(start + 3 * size)? >= 0.0;
        let place = Vec3::new(x?, y?, z?);
        // Where a marker was not seen some programs write nothing but zeros.
        let is_sane = place.iter().all(|v| v.abs() < LARGEST_M) && place != Vec3::zeros();
        (is_seen && is_sane).then_some(place)
    };
    let frame = |f: usize| {
        let start = header.data + f * stride;
        kept.iter().map(|i| place(start + i * 4 * size)).collect()
    };
    Ok((0..frames).map(frame).collect())
}

#[cfg(test)]
mod tests;

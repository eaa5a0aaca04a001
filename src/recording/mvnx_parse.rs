//! The MVNX text as a stream: segments, points and frames, checked number by number.
//!
//! Only what a recording needs is kept. Names, dates, file names and comments are never read.

use super::axes::SEGMENT_NAMES;
use super::checks::unit;
use crate::math::Vec3;
use nalgebra::UnitQuaternion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::io::BufRead;

const EXPORT_AGAIN: &str = "export the recording again, with position and orientation of segments";

/// What is wrong, and the byte at which it was found.
#[derive(Debug)]
pub(super) struct Fault {
    pub byte: u64,
    pub message: String,
    pub remedy: &'static str,
}

/// The content of an MVNX file in the file's own axes.
#[derive(Debug, Default)]
pub(super) struct Export {
    pub version: u8,
    pub rate_hz: f64,
    /// Labels of the segments in file order.
    pub labels: Vec<String>,
    /// (segment index, label, position in m) of the points on the segments.
    pub points: Vec<(usize, String, Vec3)>,
    /// Per segment, per frame of motion.
    pub position: Vec<Vec<Vec3>>,
    /// Per segment, per frame of motion: segment to world.
    pub rotation: Vec<Vec<UnitQuaternion<f64>>>,
    /// Orientations of the calibration frame `tpose`, if the version needs them.
    pub tpose: Option<Vec<UnitQuaternion<f64>>>,
    /// Orientations of the calibration frame `tpose-isb`, if the version needs them.
    pub tpose_isb: Option<Vec<UnitQuaternion<f64>>>,
    /// Types of the frames that are no motion.
    pub skipped: Vec<String>,
    /// First and last time stamp of the motion (ms), where frames carry them.
    pub times_ms: Option<(f64, f64)>,
    /// Step of the frame numbers.
    pub index_step: i64,
}

/// A frame while it is being read.
#[derive(Debug, Default)]
struct Frame {
    byte: u64,
    kind: String,
    index: Option<i64>,
    time_ms: Option<f64>,
    orientation: Option<String>,
    position: Option<String>,
}

#[derive(Debug, Default)]
struct Parser {
    export: Export,
    stack: Vec<String>,
    text: String,
    byte: u64,
    is_closed: bool,
    has_subject: bool,
    segment_count: Option<usize>,
    point: Option<String>,
    frame: Option<Frame>,
    last_index: Option<i64>,
}

/// Reads an MVNX text to its end.
pub(super) fn parse(input: impl BufRead) -> Result<Export, Fault> {
    let mut reader = Reader::from_reader(input);
    reader.config_mut().expand_empty_elements = true;
    let mut parser = Parser::default();
    let mut buffer = Vec::new();
    loop {
        parser.byte = reader.buffer_position();
        let event = match reader.read_event_into(&mut buffer) {
            Ok(event) => event,
            Err(e) => return Err(broken(&e, reader.error_position().max(parser.byte))),
        };
        match event {
            Event::Start(tag) => parser.open(&tag)?,
            Event::End(_) => parser.close()?,
            Event::Text(t) if parser.wants_text() => parser.text.push_str(&t.into_inner()),
            Event::CData(t) if parser.wants_text() => parser.text.push_str(&t.into_inner()),
            // No number holds a reference; the ampersand makes it fail as a number below.
            Event::GeneralRef(_) if parser.wants_text() => parser.text.push('&'),
            Event::Eof => break,
            _ => {}
        }
        buffer.clear();
    }
    parser.finish()
}

fn broken(error: &quick_xml::Error, byte: u64) -> Fault {
    let copy = "copy or export the file again";
    let (message, remedy) = match error {
        // Every syntax error is something that is not closed before the end.
        quick_xml::Error::Syntax(e) => (format!("is cut off or damaged: {e}"), copy),
        quick_xml::Error::Encoding(e) => (format!("is not UTF-8 text: {e}"), "save it as UTF-8"),
        quick_xml::Error::Io(e) => (format!("cannot be read further: {e}"), copy),
        other => (format!("is not well-formed XML: {other}"), copy),
    };
    Fault { byte, message, remedy }
}

fn attribute(tag: &BytesStart, name: &str) -> Option<String> {
    tag.try_get_attribute(name).ok().flatten().map(|a| a.value.trim().to_owned())
}

/// A value as shown in errors: garbage can be long.
fn shown(value: &str) -> String {
    value.chars().take(40).collect()
}

impl Parser {
    fn fault<T>(&self, message: impl Into<String>, remedy: &'static str) -> Result<T, Fault> {
        Err(Fault { byte: self.byte, message: message.into(), remedy })
    }

    fn innermost(&self) -> &str {
        self.stack.last().map_or("", String::as_str)
    }

    fn wants_text(&self) -> bool {
        matches!(self.innermost(), "pos_s" | "pos_b" | "orientation" | "position")
    }

    fn open(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        let name = tag.local_name().into_inner().to_owned();
        match (self.innermost(), name.as_str()) {
            ("", _) => self.open_root(&name, tag)?,
            ("mvnx", "subject") => self.open_subject(tag)?,
            ("segments", "segment") => {
                let Some(label) = attribute(tag, "label").filter(|l| !l.is_empty()) else {
                    return self.fault("a segment has no label", EXPORT_AGAIN);
                };
                if self.export.labels.contains(&label) {
                    let label = shown(&label);
                    return self.fault(format!("segment `{label}` is listed twice"), EXPORT_AGAIN);
                }
                self.export.labels.push(label);
                self.export.position.push(Vec::new());
                self.export.rotation.push(Vec::new());
            }
            ("points", "point") => self.point = attribute(tag, "label"),
            ("frames", "frame") => {
                if self.export.labels.is_empty() {
                    return self.fault("lists no segments before its frames", EXPORT_AGAIN);
                }
                self.frame = Some(Frame {
                    byte: self.byte,
                    kind: attribute(tag, "type").unwrap_or_default(),
                    index: attribute(tag, "index").and_then(|v| v.parse().ok()),
                    time_ms: attribute(tag, "time").and_then(|v| v.parse().ok()),
                    ..Frame::default()
                });
            }
            _ => {}
        }
        self.stack.push(name);
        self.text.clear();
        Ok(())
    }

    fn open_root(&mut self, name: &str, tag: &BytesStart) -> Result<(), Fault> {
        let remedy = "give an .mvnx file of version 3 or 4";
        if self.is_closed {
            return self.fault("goes on after the end of <mvnx>", EXPORT_AGAIN);
        }
        if name != "mvnx" {
            return self.fault(format!("root element is <{}>, not <mvnx>", shown(name)), remedy);
        }
        self.export.version = match attribute(tag, "version").as_deref() {
            Some("3") => 3,
            Some("4") => 4,
            Some(other) => {
                return self.fault(format!("MVNX version `{}` is unknown", shown(other)), remedy);
            }
            None => return self.fault("<mvnx> states no version", remedy),
        };
        Ok(())
    }

    fn open_subject(&mut self, tag: &BytesStart) -> Result<(), Fault> {
        if self.has_subject {
            return self.fault("holds more than one subject", "export each person on their own");
        }
        self.has_subject = true;
        let rate = attribute(tag, "frameRate").unwrap_or_default();
        self.export.rate_hz = match rate.parse::<f64>() {
            Ok(value) if value > 0.0 && value <= 10_000.0 => value,
            _ => {
                let message = format!("frameRate `{}` is no rate in Hz", shown(&rate));
                return self.fault(message, EXPORT_AGAIN);
            }
        };
        self.segment_count = attribute(tag, "segmentCount").and_then(|v| v.parse().ok());
        Ok(())
    }

    fn close(&mut self) -> Result<(), Fault> {
        // The reader has checked that the names of the two tags agree.
        let name = self.stack.pop().unwrap_or_default();
        match (self.innermost(), name.as_str()) {
            ("", "mvnx") => self.is_closed = true,
            ("point", "pos_s" | "pos_b") => self.take_point()?,
            ("frame", "orientation" | "position") => {
                let text = std::mem::take(&mut self.text);
                if let Some(frame) = &mut self.frame {
                    if name == "position" {
                        frame.position = Some(text);
                    } else {
                        frame.orientation = Some(text);
                    }
                }
            }
            ("segments", "segment") => self.point = None,
            ("frames", "frame") => {
                if let Some(frame) = self.frame.take() {
                    self.take_frame(&frame)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn take_point(&mut self) -> Result<(), Fault> {
        let (Some(label), Some(segment)) =
            (self.point.clone(), self.export.labels.len().checked_sub(1))
        else {
            return Ok(());
        };
        let values: Option<Vec<f64>> = self.text.split_whitespace().map(finite).collect();
        if let Some([x, y, z]) = values.as_deref() {
            self.export.points.push((segment, label, Vec3::new(*x, *y, *z)));
            return Ok(());
        }
        let (label, text) = (shown(&label), shown(self.text.trim()));
        self.fault(format!("point `{label}`: `{text}` is no position"), EXPORT_AGAIN)
    }

    fn take_frame(&mut self, frame: &Frame) -> Result<(), Fault> {
        // Faults are shown at the line on which the frame begins.
        self.byte = frame.byte;
        let is_motion = frame.kind == "normal";
        let is_needed = self.export.version == 4 && matches!(&*frame.kind, "tpose" | "tpose-isb");
        if !is_motion {
            self.export.skipped.push(shown(&frame.kind));
            if !is_needed {
                return Ok(());
            }
        }
        let place = if is_motion {
            let count = self.export.position.first().map_or(0, Vec::len);
            let number = frame.index.unwrap_or(i64::try_from(count).unwrap_or(i64::MAX));
            format!("frame {number}")
        } else {
            format!("calibration frame `{}`", frame.kind)
        };
        let turned = self.numbers(&place, "orientation", 4, frame.orientation.as_deref())?;
        let mut rotations = Vec::with_capacity(self.export.labels.len());
        for (q, label) in turned.chunks_exact(4).zip(&self.export.labels) {
            match unit(q[0], q[1], q[2], q[3]) {
                Ok(rotation) => rotations.push(rotation),
                Err(norm) => {
                    let label = shown(label);
                    let message =
                        format!("{place}: the quaternion of {label} has norm {norm:.3}, not 1");
                    return self.fault(message, EXPORT_AGAIN);
                }
            }
        }
        match frame.kind.as_str() {
            "tpose" => self.export.tpose = Some(rotations),
            "tpose-isb" => self.export.tpose_isb = Some(rotations),
            _ => {
                self.check_order(&place, frame)?;
                let placed = self.numbers(&place, "position", 3, frame.position.as_deref())?;
                for (i, p) in placed.chunks_exact(3).enumerate() {
                    self.export.position[i].push(Vec3::new(p[0], p[1], p[2]));
                    self.export.rotation[i].push(rotations[i]);
                }
            }
        }
        Ok(())
    }

    /// The numbers of one element of a frame, `each` for every segment.
    fn numbers(
        &self,
        place: &str,
        element: &str,
        each: usize,
        text: Option<&str>,
    ) -> Result<Vec<f64>, Fault> {
        let Some(text) = text else {
            return self.fault(format!("{place}: <{element}> is missing"), EXPORT_AGAIN);
        };
        let labels = &self.export.labels;
        let mut values = Vec::with_capacity(each * labels.len());
        for (i, word) in text.split_whitespace().enumerate() {
            let Some(value) = finite(word) else {
                let label = shown(labels.get(i / each).map_or("no segment", String::as_str));
                let word = shown(word);
                let message =
                    format!("{place}: <{element}> of {label}: `{word}` is not a finite number");
                return self.fault(message, "remove or fill the gap, then export again");
            };
            values.push(value);
        }
        if values.len() != each * labels.len() {
            let message = format!(
                "{place}: <{element}> holds {} numbers, not {} ({each} for each of {} segments)",
                values.len(),
                each * labels.len(),
                labels.len()
            );
            return self.fault(message, EXPORT_AGAIN);
        }
        Ok(values)
    }

    /// Frames must be numbered evenly: a gap would become a false velocity.
    fn check_order(&mut self, place: &str, frame: &Frame) -> Result<(), Fault> {
        if let (Some(last), Some(now)) = (self.last_index, frame.index) {
            let step = now.saturating_sub(last);
            if self.export.index_step == 0 {
                self.export.index_step = step;
            }
            if step <= 0 || step != self.export.index_step {
                return self.fault(
                    format!("{place} follows frame {last}: frames are missing or out of order"),
                    "export the recording again without gaps, or cut it at the gap",
                );
            }
        }
        self.last_index = frame.index;
        if let Some(time) = frame.time_ms {
            let first = self.export.times_ms.map_or(time, |(first, _)| first);
            self.export.times_ms = Some((first, time));
        }
        Ok(())
    }

    fn finish(self) -> Result<Export, Fault> {
        if self.stack.is_empty() && !self.is_closed {
            return self.fault("holds no <mvnx> element", "give an .mvnx file of version 3 or 4");
        }
        if !self.is_closed {
            let message = format!("ends inside <{}>: it is cut off", shown(self.innermost()));
            return self.fault(message, "copy or export the file again");
        }
        if !self.has_subject {
            return self.fault("holds no <subject>", EXPORT_AGAIN);
        }
        let export = &self.export;
        if export.labels.is_empty() {
            return self.fault("lists no segments", EXPORT_AGAIN);
        }
        if let Some(count) = self.segment_count.filter(|n| *n != export.labels.len()) {
            let message =
                format!("segmentCount is {count}, but {} are listed", export.labels.len());
            return self.fault(message, EXPORT_AGAIN);
        }
        if !export.labels.iter().any(|l| SEGMENT_NAMES.contains(&l.as_str())) {
            return self.fault("none of its segments is known by name", EXPORT_AGAIN);
        }
        if export.position.iter().all(Vec::is_empty) {
            return self.fault("holds no motion: no frame of type \"normal\"", EXPORT_AGAIN);
        }
        if export.version == 4 && (export.tpose.is_none() || export.tpose_isb.is_none()) {
            return self.fault(
                "lacks the calibration frames `tpose` and `tpose-isb`, which MVNX 4 needs",
                EXPORT_AGAIN,
            );
        }
        Ok(self.export)
    }
}

fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|v: &f64| v.is_finite())
}

//! MVNX files, versions 3 and 4: from the file's own axes to a recording.

use super::axes::{NEXT, SEGMENT_NAMES, mvnx_from_isb};
use super::checks::{make_continuous, note_oddities, sort_segments};
use super::mvnx_parse::{Export, parse};
use super::{Recording, Remark, SegmentTrack, bare_name};
use crate::files::{InputError, note_input, read_bytes};
use crate::math::Vec3;
use nalgebra::UnitQuaternion;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Passes bytes on and hashes them, so that a file is read once and never held whole.
struct Hashing<R> {
    inner: R,
    hash: Sha256,
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}

/// Reads an MVNX file as a stream.
pub(super) fn read(path: &Path) -> Result<Recording, InputError> {
    let Ok(file) = File::open(path) else {
        // The house's own words for a file that cannot be opened.
        return Err(read_bytes(path).err().unwrap_or_else(|| {
            InputError::new(path, "cannot be opened").remedy("check its permissions")
        }));
    };
    note_input(path);
    let mut input = BufReader::new(Hashing { inner: file, hash: Sha256::new() });
    let export = parse(&mut input).map_err(|fault| {
        let line = line_of(path, fault.byte);
        InputError::new(path, format!("line {line}: {}", fault.message)).remedy(fault.remedy)
    })?;
    let hash = input.into_inner().hash.finalize();
    let sha256 = hash.iter().fold(String::new(), |mut hex, b| {
        let _ = write!(hex, "{b:02x}");
        hex
    });
    Ok(assemble(export, bare_name(path), sha256))
}

/// Line number (from 1) of a byte; read again only after a fault.
fn line_of(path: &Path, byte: u64) -> usize {
    let Ok(file) = File::open(path) else { return 1 };
    let breaks = BufReader::new(file.take(byte)).bytes().map_while(Result::ok);
    1 + breaks.filter(|b| *b == b'\n').count()
}

/// Turns the file's segment axes into ISB axes and drops segments of unknown convention.
fn assemble(mut export: Export, source: String, sha256: String) -> Recording {
    let mut remarks = conventions(&export);
    let lengths = segment_lengths(&export);
    let mut segments = Vec::new();
    let positions = std::mem::take(&mut export.position);
    let rotations = std::mem::take(&mut export.rotation);
    let mut unknown = 0;
    for (i, (position, mut rotation)) in positions.into_iter().zip(rotations).enumerate() {
        let Some(name) = SEGMENT_NAMES.iter().find(|n| **n == export.labels[i]) else {
            unknown += 1;
            continue;
        };
        let constant = anatomical(&export, i) * mvnx_from_isb();
        for r in &mut rotation {
            *r *= constant;
        }
        make_continuous(&mut rotation);
        segments.push(SegmentTrack { name: (*name).to_owned(), position, rotation });
    }
    if unknown > 0 {
        let text = format!("{unknown} segments with unknown labels (props?) were left out");
        remarks.push(Remark::new("unknown segments", text).of_size(f64::from(unknown)));
    }
    sort_segments(&mut segments);
    let mut recording = Recording {
        source,
        format: if export.version == 3 { "MVNX v3" } else { "MVNX v4" },
        sha256,
        rate_hz: export.rate_hz,
        segments,
        segment_lengths_m: lengths,
        remarks,
    };
    note_oddities(&mut recording);
    recording
}

/// Rotation from the file's segment axes to anatomical ones: nothing in version 3; in version 4,
/// whose segment axes are parallel in the T-pose, `R_tpose^T R_tpose-isb`.
fn anatomical(export: &Export, segment: usize) -> UnitQuaternion<f64> {
    let of = |frame: &Option<Vec<UnitQuaternion<f64>>>| {
        frame.as_ref().and_then(|f| f.get(segment)).copied()
    };
    match (of(&export.tpose), of(&export.tpose_isb)) {
        (Some(tpose), Some(isb)) if export.version == 4 => tpose.inverse() * isb,
        _ => UnitQuaternion::identity(),
    }
}

fn conventions(export: &Export) -> Vec<Remark> {
    let frames = export.position.first().map_or(0, Vec::len);
    let axes = match export.version {
        3 => {
            "segment axes taken as anatomical (zero: arms hanging, palms forward), as MVNX 3 has them"
        }
        _ => {
            "segment axes turned from the T-pose to the anatomical zero (arms hanging, palms \
             forward) by the calibration frames `tpose` and `tpose-isb`"
        }
    };
    let mut remarks = vec![Remark::new("axes", axes)];
    if !export.skipped.is_empty() {
        let count = export.skipped.len();
        let text = format!(
            "{count} frames are no motion and were skipped: {}",
            export.skipped.iter().take(5).map(String::as_str).collect::<Vec<_>>().join(", ")
        );
        remarks.push(Remark::new("skipped frames", text).of_size(count as f64));
    }
    if export.index_step > 1 {
        let text = format!(
            "frame numbers step by {}; frameRate is taken as the rate of the frames in the file",
            export.index_step
        );
        remarks.push(Remark::new("frame numbers", text));
    }
    if let Some((first, last)) = export.times_ms {
        let expected = (frames.saturating_sub(1)) as f64 * 1000.0 / export.rate_hz;
        if ((last - first) - expected).abs() > 2.0 + 0.02 * expected {
            let text = format!(
                "time stamps span {:.0} ms, but {frames} frames at {} Hz span {expected:.0} ms; \
                 frameRate is used",
                last - first,
                export.rate_hz
            );
            remarks.push(Remark::new("time stamps", text).of_size((last - first - expected).abs()));
        }
    }
    remarks
}

/// Distances between joint centres. Points need no rotation for this: both versions give them in
/// axes that are parallel for all segments in the T-pose.
fn segment_lengths(export: &Export) -> Vec<(String, f64)> {
    let point = |segment: &str, label: &str| -> Option<Vec3> {
        let found = |(i, l, _): &&(usize, String, Vec3)| export.labels[*i] == segment && l == label;
        export.points.iter().find(found).map(|(_, _, p)| *p)
    };
    // The joint that two segments share: same label on both, position seen from the first.
    let shared = |first: &str, second: &str| -> Option<Vec3> {
        let joints = export
            .points
            .iter()
            .filter(|(i, label, _)| export.labels[*i] == first && label.starts_with('j'));
        joints.filter(|(_, label, _)| point(second, label).is_some()).map(|(_, _, p)| *p).next()
    };
    let mut lengths: Vec<(String, f64)> = NEXT
        .iter()
        .filter_map(|(segment, next)| Some(((*segment).to_owned(), shared(segment, next)?.norm())))
        .collect();
    for side in ["Right", "Left"] {
        let hand = format!("{side}Hand");
        if let Some(tip) = point(&hand, &format!("p{side}TopOfHand")) {
            lengths.push((hand, tip.norm()));
        }
    }
    let shoulder = |side: &str| -> Option<Vec3> {
        let clavicle = format!("{side}Shoulder");
        Some(shared("T8", &clavicle)? + shared(&clavicle, &format!("{side}UpperArm"))?)
    };
    if let (Some(right), Some(left)) = (shoulder("Right"), shoulder("Left")) {
        lengths.push(("ShoulderToShoulder".to_owned(), (right - left).norm()));
    }
    if let (Some(right), Some(left)) =
        (shared("Pelvis", "RightUpperLeg"), shared("Pelvis", "LeftUpperLeg"))
    {
        lengths.push(("HipToHip".to_owned(), (right - left).norm()));
    }
    lengths
}

#[cfg(test)]
mod tests;

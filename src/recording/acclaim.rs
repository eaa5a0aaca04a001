//! Acclaim motion capture: a skeleton (`.asf`) and its motion (`.amc`), from bones to a recording.

mod amc;
mod anatomy;
mod asf;
mod skeleton;

use self::anatomy::Anatomy;
use self::skeleton::Skeleton;
use super::axes::lengths_between;
use super::checks::{make_continuous, note_oddities, still_collar_bones, turned_leg};
use super::{Recording, Remark, SegmentTrack, bare_name};
use crate::files::{InputError, read_bytes, sha256_hex};
use crate::math::Vec3;
use std::path::{Path, PathBuf};

/// Rate (Hz) of a motion whose name does not end with one; the files do not hold it.
const USUAL_RATE_HZ: f64 = 120.0;
/// Hip to ankle at rest (m) outside of which lengths are in another unit.
const LEG_M: std::ops::RangeInclusive<f64> = 0.4..=1.3;
/// Reads a motion and the skeleton beside it.
pub(super) fn read(path: &Path) -> Result<Recording, InputError> {
    let motion = read_bytes(path)?;
    let skeleton_path = skeleton_of(path)?;
    let mut bytes = read_bytes(&skeleton_path)?;
    // Latin letters in comments are common, and no word that counts holds any.
    let skeleton = asf::parse(&String::from_utf8_lossy(&bytes))
        .and_then(|skeleton| Ok((Anatomy::new(&skeleton)?, skeleton)));
    let (anatomy, skeleton) = skeleton.map_err(|fault| fault.of(&skeleton_path))?;
    let frames =
        amc::parse(&String::from_utf8_lossy(&motion), &skeleton).map_err(|fault| fault.of(path))?;
    bytes.extend_from_slice(&motion);
    let (rate_hz, is_named) = rate(path);
    let lengths = segment_lengths(&anatomy, &skeleton);
    let leg_m = leg(&lengths);
    if !LEG_M.contains(&leg_m) {
        let message = format!("its legs are {leg_m:.3} m long, from hip to ankle");
        return Err(InputError::new(&skeleton_path, message).remedy(
            "lengths are inches over the scale `length` of :units: correct the scale to inches per m",
        ));
    }
    let mut segments = tracks(&anatomy, &skeleton, &frames);
    let mut remarks = conventions(rate_hz, is_named, &bare_name(&skeleton_path), leg_m);
    remarks.extend(still_collar_bones(&segments));
    remarks.extend(["Right", "Left"].into_iter().filter_map(|s| turned_leg(&mut segments, s)));
    let mut recording = Recording {
        source: bare_name(path),
        format: "Acclaim ASF/AMC",
        sha256: sha256_hex(&bytes),
        rate_hz,
        segments,
        segment_lengths_m: lengths,
        remarks,
    };
    note_oddities(&mut recording);
    Ok(recording)
}

/// The skeleton of a motion: of the same name, or else the only one in the folder whose name the
/// motion's begins with.
fn skeleton_of(motion: &Path) -> Result<PathBuf, InputError> {
    let folder = match motion.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let io = |e: std::io::Error| InputError::new(folder, format!("cannot be read: {e}"));
    let stem = |p: &Path| p.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let wanted = stem(motion);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let is_skeleton = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("asf"));
        let ends = |c: char| !c.is_alphanumeric();
        match wanted.strip_prefix(&stem(&path)).filter(|_| is_skeleton) {
            Some("") => return Ok(path),
            // 02.asf is not the skeleton of 021_05.amc.
            Some(rest) if rest.starts_with(ends) => found.push(path),
            _ => {}
        }
    }
    found.sort();
    match found.as_slice() {
        [one] => Ok(one.clone()),
        [] => {
            let message = format!(
                "has no skeleton: no {wanted}.asf beside it, and no .asf whose name it begins with"
            );
            Err(InputError::new(motion, message)
                .remedy(format!("put the person's skeleton beside it as {wanted}.asf")))
        }
        several => {
            let names: Vec<String> = several.iter().map(|p| bare_name(p)).collect();
            let message = format!("may belong to several skeletons: {}", names.join(", "));
            Err(InputError::new(motion, message)
                .remedy(format!("name the right one {wanted}.asf, or move the others away")))
        }
    }
}

/// Frames per second, and whether the name says so: it does where it ends with `_` and three digits
/// of which the first is not zero.
fn rate(motion: &Path) -> (f64, bool) {
    let stem = motion.file_stem().unwrap_or_default().to_string_lossy();
    let last = stem.rsplit_once('_').map_or("", |(_, last)| last);
    let is_rate = last.len() == 3 && !last.starts_with('0');
    match last.bytes().all(|b| b.is_ascii_digit()).then(|| last.parse()) {
        Some(Ok(rate)) if is_rate => (rate, true),
        _ => (USUAL_RATE_HZ, false),
    }
}

fn conventions(rate_hz: f64, is_named: bool, skeleton: &str, leg_m: f64) -> Vec<Remark> {
    let rate = if is_named {
        format!("rate of {rate_hz} Hz taken from the end of the file's name")
    } else {
        format!("rate taken as {rate_hz} Hz: neither the file nor its name holds it")
    };
    vec![
        Remark::new("rate", rate),
        Remark::new(
            "bones",
            format!(
                "bones of {skeleton}, lengths taken as inches over its length scale: from hip to ankle \
                 {leg_m:.2} m"
            ),
        )
        .of_size(leg_m),
        Remark::new("axes", "segment axes follow from the rest pose: trunk upright, limbs along their bones, knees and \
         elbows about their hinges, palms by the thumbs; axial rotations are of the skeleton's own \
         calibration"),
        Remark::new("trunk segments", "`lowerback` is taken as L5, `upperback` as T12, `thorax` as T8, and L3 as halfway between \
         the first two; the neck is halfway between `lowerneck` and `upperneck`"),
    ]
}

/// One track for every segment.
fn tracks(anatomy: &Anatomy, skeleton: &Skeleton, frames: &[Vec<f64>]) -> Vec<SegmentTrack> {
    let empty = |name: &str| SegmentTrack {
        name: name.to_owned(),
        position: Vec::with_capacity(frames.len()),
        rotation: Vec::with_capacity(frames.len()),
    };
    let mut tracks: Vec<SegmentTrack> = anatomy.parts.iter().map(|p| empty(p.name)).collect();
    for values in frames {
        let placed = skeleton.place(values);
        for (part, track) in anatomy.parts.iter().zip(&mut tracks) {
            let (position, rotation) = anatomy.pose(part, skeleton, &placed);
            track.position.push(position);
            track.rotation.push(rotation);
        }
    }
    for track in &mut tracks {
        make_continuous(&mut track.rotation);
    }
    tracks
}

/// Distances between joint centres in the rest pose. Hands have none: their bones end at markers on
/// the knuckles and fingers.
fn segment_lengths(anatomy: &Anatomy, skeleton: &Skeleton) -> Vec<(String, f64)> {
    let rest = skeleton.place(&vec![0.0; skeleton.dof()]);
    let start = |name: &str| -> Option<Vec3> {
        let part = anatomy.parts.iter().find(|p| p.name == name)?;
        Some(anatomy.pose(part, skeleton, &rest).0)
    };
    lengths_between(|from, to| Some((start(to)? - start(from)?).norm()))
}

/// Mean length of the legs from hip to ankle, m.
fn leg(lengths: &[(String, f64)]) -> f64 {
    let parts = ["RightUpperLeg", "RightLowerLeg", "LeftUpperLeg", "LeftLowerLeg"];
    lengths.iter().filter(|(name, _)| parts.contains(&name.as_str())).map(|(_, l)| l / 2.0).sum()
}

#[cfg(test)]
mod tests;

//! BVH files: joints and their turns, from any program's skeleton to a recording.

mod anatomy;
mod names;
mod parse;
mod rest;
mod skeleton;

use self::anatomy::{Anatomy, Part};
use self::names::Joints;
use self::parse::Motion;
use self::rest::Rest;
use self::skeleton::{Placed, Skeleton};
use super::axes::lengths_between;
use super::checks::{
    make_continuous, note_oddities, sort_segments, still_collar_bones, turned_leg,
};
use super::lines::Fault;
use super::{Recording, Remark, SEGMENT_NAMES, SegmentTrack, bare_name};
use crate::files::{InputError, read_bytes, sha256_hex};
use crate::math::Vec3;
use std::path::Path;

/// Shoulder to wrist (m) within which the arms of grown-up people lie.
const ARM_M: std::ops::RangeInclusive<f64> = 0.40..=0.72;
const ARM: [&str; 2] = ["UpperArm", "ForeArm"];
const LEG: [&str; 2] = ["UpperLeg", "LowerLeg"];
/// Units of length in m, so far apart that an arm fits one of them only.
const UNITS: [(&str, f64); 5] = [
    ("m", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("inches", 0.0254),
    ("inches over 0.45, as in the CMU database", 0.0254 / 0.45),
];
/// Share of a person's mean direction along an axis beyond which that axis is the vertical.
const MOSTLY: f64 = 0.8;
/// How far arms point down in a rest pose (sine) beyond which it is no T-pose.
const HANGS: f64 = 0.5;
/// Turn (rad) of a segment in the pelvis below which a first frame may be the rest pose.
const AT_REST: f64 = 0.5;
/// Turn (rad) from the first frame to the second that nobody makes,
const LEAP: f64 = 0.5;
/// and how many times as large it is as the next one.
const LEAP_RATIO: f64 = 5.0;

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<Recording, InputError> {
    let bytes = read_bytes(path)?;
    let name = bare_name(path);
    // Latin letters in names are common, and no word that counts holds any.
    assemble(&String::from_utf8_lossy(&bytes), name, sha256_hex(&bytes)).map_err(|f| f.of(path))
}

/// Makes a recording of a file's text.
fn assemble(text: &str, source: String, sha256: String) -> Result<Recording, Fault> {
    let motion = parse::parse(text)?;
    let skeleton = &motion.skeleton;
    let joints = Joints::new(skeleton)?;
    let (rest, is_zero) = rest(&motion, &joints)?;
    let vertical = vertical(&motion, &joints).unwrap_or(rest.vertical);
    let mut anatomy = Anatomy::new(skeleton, &joints, &rest, vertical)?;
    let mut lengths = segment_lengths(&anatomy, &rest);
    let (unit, unit_m) = unit(&lengths)?;
    anatomy.unit_m = unit_m;
    for (_, length) in &mut lengths {
        *length *= unit_m;
    }

    let mut remarks = vec![
        rate(&motion),
        size(unit, &lengths),
        axes(&rest, is_zero, rest.hanging(&joints), vertical),
        thumbs(&anatomy),
        trunk_segments(joints.spine.len()),
    ];
    remarks.extend(left_out(&anatomy));
    let mut frames = motion.frames.as_slice();
    if begins_at_rest(&anatomy, &rest, &motion) {
        frames = &frames[1..];
        let text = "the first frame is the rest pose, from which no one comes to the second that fast: skipped";
        remarks.push(Remark::new("skipped frames", text).of_size(1.0));
    }
    let mut segments = tracks(&anatomy, skeleton, frames);
    sort_segments(&mut segments);
    remarks.extend(still_collar_bones(&segments));
    remarks.extend(["Right", "Left"].into_iter().filter_map(|s| turned_leg(&mut segments, s)));
    let mut recording = Recording {
        source,
        format: "BVH",
        sha256,
        rate_hz: motion.rate_hz,
        segments,
        segment_lengths_m: lengths,
        remarks,
    };
    note_oddities(&mut recording);
    Ok(recording)
}

/// The pose from which the axes of segments follow, and whether it is the zero pose: that one, or else
/// the first frame where a person stands in it.
fn rest(motion: &Motion, joints: &Joints) -> Result<(Rest, bool), Fault> {
    let skeleton = &motion.skeleton;
    let fault = match Rest::new(skeleton, joints, skeleton.zero_pose()) {
        Ok(rest) => return Ok((rest, true)),
        Err(fault) => fault,
    };
    let first = motion.frames.first().map(|frame| skeleton.place(frame)).unwrap_or_default();
    match Rest::new(skeleton, joints, first).ok().filter(|r| r.has_straight_arms(joints)) {
        Some(rest) => Ok((rest, false)),
        None => Err(fault),
    }
}

/// The axis of the world along which the person stands, or without feet the trunk, in most frames, if
/// there is one.
fn vertical(motion: &Motion, joints: &Joints) -> Option<usize> {
    let lowest = match (joints.right.foot, joints.left.foot) {
        (Some(right), Some(left)) => [right, left],
        _ => [joints.pelvis; 2],
    };
    let tall = |frame: &Vec<f64>| {
        let placed = motion.skeleton.place(frame);
        let [right, left] = lowest.map(|joint| placed[joint].start);
        let tall = placed[joints.top()].start - 0.5 * (right + left);
        tall.try_normalize(0.0).unwrap_or_default()
    };
    let mean = motion.frames.iter().map(tall).sum::<Vec3>() / motion.frames.len().max(1) as f64;
    Some(mean.imax()).filter(|axis| mean[*axis] > MOSTLY)
}

/// Distances between joint centres in the rest pose, in the unit of the anatomy. Hands have none: what
/// their ends stand for differs from program to program.
fn segment_lengths(anatomy: &Anatomy, rest: &Rest) -> Vec<(String, f64)> {
    let start = |name: &str| -> Option<Vec3> {
        let part = anatomy.parts.iter().find(|p| p.name == name)?;
        Some(anatomy.pose(part, &rest.placed).0)
    };
    lengths_between(|from, to| Some((start(to)? - start(from)?).norm()))
}

/// Sum of two lengths on a side that has both, mean of the sides.
fn limb(lengths: &[(String, f64)], parts: [&str; 2]) -> Option<f64> {
    let length = |name: String| lengths.iter().find(|(n, _)| *n == name).map(|(_, length)| *length);
    let side = |side: &str| {
        let [upper, lower] = parts.map(|part| length(format!("{side}{part}")));
        Some(upper? + lower?)
    };
    match (side("Right"), side("Left")) {
        (Some(right), Some(left)) => Some(0.5 * (right + left)),
        (one, other) => one.or(other),
    }
}

/// Name and length (m) of the file's unit, by the arms.
fn unit(lengths: &[(String, f64)]) -> Result<(&'static str, f64), Fault> {
    let Some(arm) = limb(lengths, ARM) else {
        let message = "has no arm with joints at elbow and wrist";
        return Err(Fault::whole(message, "export the skeleton with forearms and hands"));
    };
    UNITS.into_iter().find(|(_, unit_m)| ARM_M.contains(&(arm * unit_m))).ok_or_else(|| {
        let message = format!(
            "its arms are {arm:.4} long from shoulder to wrist, which no arm is in any unit"
        );
        Fault::whole(message, "export it in cm, m, mm or inches, with the size of the person")
    })
}

fn rate(motion: &Motion) -> Remark {
    let (time, rate) = (motion.frame_time_s, motion.rate_hz);
    Remark::new("rate", format!("frame time of {time} s taken as {rate} Hz"))
}

fn size(unit: &str, lengths_m: &[(String, f64)]) -> Remark {
    let arm_m = limb(lengths_m, ARM).unwrap_or_default();
    let leg = limb(lengths_m, LEG)
        .map_or_else(String::new, |leg| format!(", from hip to ankle {leg:.2} m"));
    let text =
        format!("lengths taken as {unit}, by the arms: from shoulder to wrist {arm_m:.2} m{leg}");
    Remark::new("unit", text).of_size(arm_m)
}

fn axes(rest: &Rest, is_zero: bool, hanging: f64, vertical: usize) -> Remark {
    let pose = if is_zero {
        "the zero pose"
    } else {
        "the first frame, as nobody stands in the zero pose"
    };
    let arms = if hanging > HANGS { "arms hanging" } else { "arms sideways" };
    let letter = |axis: usize| ["x", "y", "z"][axis.min(2)];
    let turned = if vertical == rest.vertical {
        String::new()
    } else {
        format!(", but {} is up there", letter(rest.vertical))
    };
    let text = format!(
        "segment axes follow from {pose}: trunk upright, {arms}, limbs along their bones; {} is up in \
         the movement{turned}",
        letter(vertical)
    );
    Remark::new("axes", text)
}

fn thumbs(anatomy: &Anatomy) -> Remark {
    let side = |quarters: u8| match quarters {
        0 => "forwards".to_owned(),
        n => {
            format!("{} deg from forwards, as the thumb of the skeleton has it", 90 * u16::from(n))
        }
    };
    let [right, left] = anatomy.quarters.map(side);
    let text = if right == left {
        format!("thumbs taken to point {right} in that pose")
    } else {
        format!("the right thumb taken to point {right} in that pose, the left {left}")
    };
    Remark::new("thumbs", text)
}

fn trunk_segments(count: usize) -> Remark {
    let text = match count {
        1 => "the one joint of the spine is taken as T8".to_owned(),
        2 => "the two joints of the spine are taken as L3 and T8".to_owned(),
        3 => "the three joints of the spine are taken as L5, T12 and T8, and L3 as halfway between the \
              first two"
            .to_owned(),
        4 => "the four joints of the spine are taken as L5, L3, T12 and T8".to_owned(),
        n => format!(
            "of the {n} joints of the spine those nearest to L5, L3 and T12 are taken, and the last one \
             as T8"
        ),
    };
    Remark::new("trunk segments", text)
}

/// A note on segments that have no joint.
fn left_out(anatomy: &Anatomy) -> Option<Remark> {
    let is_absent = |name: &&&str| anatomy.parts.iter().all(|p| p.name != **name);
    let absent: Vec<&str> = SEGMENT_NAMES.iter().filter(is_absent).copied().collect();
    (!absent.is_empty()).then(|| {
        let text = format!("the skeleton has no joint for {}", absent.join(", "));
        Remark::new("missing segments", text).of_size(absent.len() as f64)
    })
}

/// Whether the first frame is a rest pose that was put before the movement.
fn begins_at_rest(anatomy: &Anatomy, rest: &Rest, motion: &Motion) -> bool {
    let [first, second, third, ..] = motion.frames.as_slice() else { return false };
    let [first, second, third] = [first, second, third].map(|frame| motion.skeleton.place(frame));
    // Largest turn of a segment in the pelvis from one frame to another.
    let largest = |from: &[Placed], to: &[Placed]| {
        let turns = anatomy.in_pelvis(from).into_iter().zip(anatomy.in_pelvis(to));
        turns.map(|(from, to)| from.angle_to(&to)).fold(0.0, f64::max)
    };
    let leap = largest(&first, &second);
    largest(&rest.placed, &first) < AT_REST
        && leap > LEAP
        && leap > LEAP_RATIO * largest(&second, &third)
}

/// One track for every segment that has a joint.
fn tracks(anatomy: &Anatomy, skeleton: &Skeleton, frames: &[Vec<f64>]) -> Vec<SegmentTrack> {
    let empty = |part: &Part| SegmentTrack {
        name: part.name.clone(),
        position: Vec::with_capacity(frames.len()),
        rotation: Vec::with_capacity(frames.len()),
    };
    let mut tracks: Vec<SegmentTrack> = anatomy.parts.iter().map(empty).collect();
    for values in frames {
        let placed = skeleton.place(values);
        for (part, track) in anatomy.parts.iter().zip(&mut tracks) {
            let (position, rotation) = anatomy.pose(part, &placed);
            track.position.push(position);
            track.rotation.push(rotation);
        }
    }
    for track in &mut tracks {
        make_continuous(&mut track.rotation);
    }
    tracks
}

#[cfg(test)]
mod tests;

//! The text of a motion (`.amc`), checked against its skeleton.

use super::skeleton::{Channel, Skeleton};
use crate::recording::lines::{Fault, Line, lines, shown};

const WHOLE: &str = "copy or export the motion again, with every bone in every frame";
const PAIR: &str = "does the motion belong to this skeleton?";

/// A frame while it is being read.
struct Open {
    line: usize,
    number: u64,
    values: Vec<f64>,
    is_given: Vec<bool>,
}

/// Values of every frame, T x dof, in the order of the bones: lengths in the file's unit, angles in
/// rad.
pub(super) fn parse(text: &str, skeleton: &Skeleton) -> Result<Vec<Vec<f64>>, Fault> {
    let mut is_degrees = skeleton.is_degrees;
    let mut frames = Vec::new();
    let mut open: Option<Open> = None;
    for mut line in lines(text) {
        if let Some(key) = line.first.strip_prefix(':') {
            match key.to_ascii_uppercase().as_str() {
                "DEGREES" => is_degrees = true,
                "RADIANS" => is_degrees = false,
                _ => {}
            }
            continue;
        }
        if let Some(number) = frame_number(&line) {
            let next = begun(&line, number, open.as_ref(), skeleton)?;
            if let Some(done) = open.replace(next) {
                frames.push(closed(done, skeleton)?);
            }
            continue;
        }
        let Some(frame) = &mut open else {
            let message = format!("`{}` stands before the first frame number", shown(line.first));
            return Err(line.fault(message, "is it an .amc file?"));
        };
        fill(frame, &mut line, skeleton)?;
    }
    match open {
        Some(last) => frames.push(closed(last, skeleton)?),
        None => return Err(Fault::whole("holds no frames", WHOLE)),
    }
    if is_degrees {
        to_radians(&mut frames, skeleton);
    }
    Ok(frames)
}

/// The number of a frame, which stands alone on its line.
fn frame_number(line: &Line) -> Option<u64> {
    let number = line.first.parse().ok()?;
    line.rest.clone().next().is_none().then_some(number)
}

fn begun(
    line: &Line,
    number: u64,
    before: Option<&Open>,
    skeleton: &Skeleton,
) -> Result<Open, Fault> {
    if let Some(before) = before.filter(|b| b.number.checked_add(1) != Some(number)) {
        let message = format!("frame {number} follows frame {}", before.number);
        return Err(line.fault(message, WHOLE));
    }
    let values = vec![0.0; skeleton.dof()];
    let is_given = vec![false; skeleton.bones.len()];
    Ok(Open { line: line.number, number, values, is_given })
}

/// Puts the values of one bone into its frame.
fn fill(frame: &mut Open, line: &mut Line, skeleton: &Skeleton) -> Result<(), Fault> {
    let name = shown(line.first);
    let Some(i) = skeleton.find(line.first) else {
        let message = format!("frame {}: the skeleton has no bone `{name}`", frame.number);
        return Err(line.fault(message, PAIR));
    };
    let bone = &skeleton.bones[i];
    let wanted = bone.channels.len();
    let found = line.rest.clone().count();
    if found != wanted {
        let message =
            format!("frame {}: `{name}` holds {found} values, not {wanted}", frame.number);
        return Err(line.fault(message, PAIR));
    }
    if frame.is_given[i] {
        let message = format!("frame {}: `{name}` is given twice", frame.number);
        return Err(line.fault(message, WHOLE));
    }
    frame.is_given[i] = true;
    for value in &mut frame.values[bone.first..bone.first + wanted] {
        *value = line.number(WHOLE)?;
    }
    Ok(())
}

/// The values of a frame that holds every bone that can move.
fn closed(frame: Open, skeleton: &Skeleton) -> Result<Vec<f64>, Fault> {
    let mut bones = skeleton.bones.iter().zip(&frame.is_given);
    match bones.find(|(bone, is_given)| !bone.channels.is_empty() && !**is_given) {
        None => Ok(frame.values),
        Some((bone, _)) => {
            let message = format!("frame {} lacks `{}`", frame.number, shown(&bone.name));
            Err(Fault::at(frame.line, message, WHOLE))
        }
    }
}

fn to_radians(frames: &mut [Vec<f64>], skeleton: &Skeleton) {
    let channels = skeleton.bones.iter().flat_map(|b| &b.channels);
    let turns: Vec<usize> = channels
        .enumerate()
        .filter(|(_, channel)| matches!(channel, Channel::Turn(_)))
        .map(|(i, _)| i)
        .collect();
    for frame in frames {
        for i in &turns {
            frame[*i] = frame[*i].to_radians();
        }
    }
}

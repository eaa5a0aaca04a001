//! What a reader should know of a recording that was made of markers, and what no person is.

use super::Map;
use super::fill::Filled;
use super::parts::Made;
use crate::files::InputError;
use crate::recording::{BORDERS, Remark};
use std::collections::BTreeMap;
use std::path::Path;

/// Shoulder to wrist (m) within which the arms of grown-up people lie.
const ARM_M: std::ops::RangeInclusive<f64> = 0.40..=0.72;
/// Hip to ankle (m) within which their legs lie.
const LEG_M: std::ops::RangeInclusive<f64> = 0.55..=1.15;
/// Units that a file may hold in truth, m.
const UNITS: [(&str, f64); 4] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("inches", 0.0254)];
/// A remark of this size is one that changes what is learned: it is told first.
const LOUD: f64 = 1.0;

/// What of a file was taken, and how.
pub(super) struct Taken<'a> {
    pub map: &'a Map,
    /// Optional segments that the file cannot tell.
    pub lost: &'a [&'a str],
    pub filled: &'a [(&'a str, Filled)],
    pub left_out: usize,
    pub runs: usize,
    pub frames: usize,
    pub rate_hz: f64,
    /// The marker that is missing longest, and in how many frames.
    pub worst: Option<(&'a str, usize)>,
}

pub(super) fn all(
    taken: &Taken,
    made: &BTreeMap<String, Made>,
    up: &str,
    (span, lengths): ((usize, usize), &[(String, f64)]),
) -> Vec<Remark> {
    let mut remarks = Vec::new();
    remarks.extend(borders(taken, span));
    remarks.extend(gaps(taken));
    remarks.push(Remark::new("vertical", up));
    remarks.push(Remark::new(
        "segments",
        format!("{} segments placed by {}", made.len(), taken.map.name),
    ));
    if !taken.lost.is_empty() {
        let text = format!("not in the file, left out: {}", taken.lost.join(", "));
        remarks.push(Remark::new("lost segments", text));
    }
    for (name, own) in made.iter().filter(|(_, m)| m.straight > 0) {
        let text = format!(
            "{name}: its points are too much in one line in {} of {} frames to tell its turn about itself, which \
             is taken from the frames around them",
            own.straight,
            own.joint.len()
        );
        remarks.push(Remark::new(format!("straight {name}"), text));
    }
    let arms: Vec<String> = ["Right", "Left"]
        .into_iter()
        .filter_map(|side| {
            let arm = limb(lengths, side, ["UpperArm", "ForeArm"])?;
            Some(format!("{} {arm:.3} m", side.to_lowercase()))
        })
        .collect();
    if !arms.is_empty() {
        let text = format!("from shoulder to wrist {} (medians)", arms.join(", "));
        remarks.push(Remark::new("arms", text));
    }
    remarks
}

fn borders(taken: &Taken, (from, to): (usize, usize)) -> Option<Remark> {
    let (name, missing) = taken.worst?;
    let seconds = |frames: usize| frames as f64 / taken.rate_hz;
    let others = match taken.runs - 1 {
        0 => String::new(),
        1 => "; one other run is not in it".to_owned(),
        more => format!("; {more} other runs are not in it"),
    };
    let text = format!(
        "frames {from} to {} of {}: gaps over {} s are borders ({name} is missing in {missing} frames, {:.2} s of \
         the file are left out){others}",
        to - 1,
        taken.frames,
        taken.map.longest_gap_s,
        seconds(taken.left_out)
    );
    Some(Remark::new(BORDERS, text).of_size(LOUD))
}

fn gaps(taken: &Taken) -> Option<Remark> {
    let all = taken.filled.iter().map(|(_, f)| *f).reduce(Filled::and)?;
    if all.gaps == 0 {
        return None;
    }
    let mut names: Vec<&(&str, Filled)> = taken.filled.iter().filter(|(_, f)| f.gaps > 0).collect();
    names.sort_by_key(|(_, f)| std::cmp::Reverse(f.frames));
    let listed: Vec<String> =
        names.iter().map(|(name, f)| format!("{name} {} frames", f.frames)).collect();
    let text = format!(
        "{} gaps of up to {:.2} s filled along a smooth path: {}",
        all.gaps,
        all.longest as f64 / taken.rate_hz,
        listed.join(", ")
    );
    Some(Remark::new("gaps", text).of_size(0.5))
}

/// Length of a limb of two segments, m.
fn limb(lengths: &[(String, f64)], side: &str, parts: [&str; 2]) -> Option<f64> {
    let of = |part: &str| {
        lengths.iter().find(|(n, _)| *n == format!("{side}{part}")).map(|(_, length)| *length)
    };
    Some(of(parts[0])? + of(parts[1])?)
}

/// Refuses arms and legs that nobody has: the unit is another, or the markers are.
pub(super) fn refuse_wrong_unit(path: &Path, lengths: &[(String, f64)]) -> Result<(), InputError> {
    let limbs = [
        ("arm from shoulder to wrist", ["UpperArm", "ForeArm"], ARM_M),
        ("leg from hip to ankle", ["UpperLeg", "LowerLeg"], LEG_M),
    ];
    for (what, parts, usual) in limbs {
        for side in ["Right", "Left"] {
            let Some(length) = limb(lengths, side, parts) else { continue };
            if usual.contains(&length) {
                continue;
            }
            let message = format!("the {} {what} is {length:.4} m long", side.to_lowercase());
            let fits =
                UNITS.into_iter().flat_map(|(from, a)| UNITS.map(|(to, b)| (from, to, b / a)));
            let unit = fits
                .filter(|(from, to, _)| from != to)
                .find(|(_, _, scale)| usual.contains(&(length * scale)));
            let remedy = match unit {
                Some((from, to, _)) => {
                    format!("is the unit {to}, and not {from}? Tables: unit = \"..\" under [map]")
                }
                None => "are these the markers of that limb?".to_owned(),
            };
            return Err(InputError::new(path, message).remedy(remedy));
        }
    }
    Ok(())
}

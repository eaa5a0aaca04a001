//! The parts of a file in which everything that is mapped was seen, each a recording.

use super::fill::{Filled, fill};
use super::parts::{Made, Places, Unmade, make};
use super::remarks::{self, Taken};
use super::vertical::{SAY_UP, Up, vertical};
use super::{Map, Part};
use crate::files::{InputError, suggest};
use crate::math::{Vec3, stats};
use crate::recording::axes::lengths_between;
use crate::recording::checks::{make_continuous, note_oddities, sort_segments};
use crate::recording::{Markers, Recording, SegmentTrack};
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;
use std::path::Path;

/// Shortest run that is kept, s, and frames: less is no movement.
const SHORTEST_S: f64 = 0.25;
const FEWEST_FRAMES: usize = 8;

/// A part of a file without gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What was recorded in it.
    pub recording: Recording,
    /// Its first frame in the file.
    pub first_frame: usize,
    /// Gaps of single markers that were filled in the file.
    pub gaps_filled: usize,
    /// Frames of the file that are in no run.
    pub frames_left_out: usize,
}

/// What of a file is the same for all its runs.
pub(in crate::recording) struct Origin<'a> {
    pub path: &'a Path,
    pub source: String,
    pub format: &'static str,
    pub sha256: String,
}

/// Cuts places of markers into runs without gaps and makes the segments of each.
///
/// # Errors
/// Where the file lacks a marker of the map, no run is long enough, or nothing tells what is up.
pub(in crate::recording) fn runs(
    origin: &Origin,
    markers: &Markers,
    map: &Map,
) -> Result<Vec<Run>, InputError> {
    let (parts, lost) = present(origin.path, markers, map)?;
    let mut tracks: Tracks = BTreeMap::new();
    for name in parts.iter().flat_map(|p| p.markers()) {
        if let Some(track) = markers.track(name) {
            tracks.insert(name, track.collect());
        }
    }
    let longest = (map.longest_gap_s * markers.rate_hz).floor() as usize;
    let mut filled: Vec<(&str, Filled)> = Vec::new();
    for (name, track) in &mut tracks {
        filled.push((*name, fill(track, longest)));
    }
    let frames = markers.positions.len();
    let spans = spans(&tracks, frames, markers.rate_hz);
    if spans.is_empty() {
        return Err(never_whole(origin.path, &tracks, frames, markers.rate_hz));
    }
    let left_out = frames - spans.iter().map(|(from, to)| to - from).sum::<usize>();
    let taken = Taken {
        map,
        lost: &lost,
        filled: &filled,
        left_out,
        runs: spans.len(),
        frames,
        rate_hz: markers.rate_hz,
        worst: worst(&tracks),
    };
    let up = up(origin, map, &parts, &tracks, &spans)?;
    spans
        .iter()
        .map(|span| {
            let recording = record(origin, &parts, (&tracks, *span), &up, &taken)?;
            let gaps_filled = filled.iter().map(|(_, f)| f.gaps).sum();
            Ok(Run { recording, first_frame: span.0, gaps_filled, frames_left_out: left_out })
        })
        .collect()
}

/// The segments that the file can tell, and those that are optional and it cannot.
fn present<'a>(
    path: &Path,
    markers: &Markers,
    map: &'a Map,
) -> Result<(Vec<&'a Part>, Vec<&'a str>), InputError> {
    let (mut parts, mut lost): (Vec<&Part>, Vec<&str>) = (Vec::new(), Vec::new());
    for part in &map.parts {
        let missing = part.markers().find(|m| !markers.names.iter().any(|n| n == m));
        let lacks = part.needs().find(|n| lost.contains(n));
        match missing {
            None if lacks.is_none() => parts.push(part),
            Some(marker) if !part.optional => {
                let known = || markers.names.iter().map(String::as_str);
                let listed = format!("in the file: {}", known().collect::<Vec<_>>().join(", "));
                let near = suggest(marker, known());
                let message = format!(
                    "holds no marker `{marker}`, of which {} makes {}",
                    map.name, part.name
                );
                return Err(InputError::new(path, message)
                    .remedy(near.map_or_else(|| listed.clone(), |n| format!("{n} {listed}"))));
            }
            None if !part.optional => {
                let message = format!(
                    "lacks {}, of which {} makes {}",
                    lacks.unwrap_or_default(),
                    map.name,
                    part.name
                );
                return Err(InputError::new(path, message)
                    .remedy("mark the segment as optional too, or map what it needs"));
            }
            _ => lost.push(&part.name),
        }
    }
    Ok((parts, lost))
}

/// From and to (exclusive) of the runs in which every track is known.
fn spans(tracks: &Tracks, frames: usize, rate_hz: f64) -> Vec<(usize, usize)> {
    let fewest = FEWEST_FRAMES.max((SHORTEST_S * rate_hz).ceil() as usize);
    let is_whole = |i: usize| tracks.values().all(|track| track[i].is_some());
    let mut spans = Vec::new();
    let mut from = None;
    for i in 0..=frames {
        match (i < frames && is_whole(i), from) {
            (true, None) => from = Some(i),
            (false, Some(start)) => {
                if i - start >= fewest {
                    spans.push((start, i));
                }
                from = None;
            }
            _ => {}
        }
    }
    spans
}

/// The marker that is missing longest, and in how many frames.
fn worst<'a>(tracks: &Tracks<'a>) -> Option<(&'a str, usize)> {
    let missing = tracks.iter().map(|(n, t)| (*n, t.iter().filter(|p| p.is_none()).count()));
    missing.filter(|(_, count)| *count > 0).max_by_key(|(_, count)| *count)
}

fn never_whole(path: &Path, tracks: &Tracks, frames: usize, rate_hz: f64) -> InputError {
    let (name, count) = worst(tracks).unwrap_or_default();
    let message = if count == 0 {
        format!("holds {frames} frames at {rate_hz} Hz, too few for a movement")
    } else {
        format!(
            "has no {SHORTEST_S} s in which all mapped markers are seen; `{name}` is missing in {count} of \
             {frames} frames"
        )
    };
    InputError::new(path, message)
        .remedy("map other markers, leave out the segment, or fill gaps in the capture program")
}

/// The vertical: stated, or the axis along which the trunk stands.
fn up(
    origin: &Origin,
    map: &Map,
    parts: &[&Part],
    tracks: &Tracks,
    spans: &[(usize, usize)],
) -> Result<Up, InputError> {
    if map.up.is_some() {
        return vertical(origin.path, map.up, Vec3::zeros());
    }
    let mut sum = Vec3::zeros();
    let mut count = 0;
    for (from, to) in spans {
        let places = slice(tracks, (*from, *to), &UnitQuaternion::identity());
        let mut made = BTreeMap::new();
        for part in parts {
            match make(part, &places, &made, to - from) {
                Ok(own) => drop(made.insert(part.name.clone(), own)),
                Err(why) => return Err(unmade(origin, part, *from, &why)),
            }
        }
        let (Some(pelvis), Some(thorax)) = (made.get("Pelvis"), made.get("T8")) else {
            return Err(InputError::new(
                origin.path,
                "holds no pelvis and T8 that tell what is up",
            )
            .remedy(SAY_UP));
        };
        let tall = thorax.joint.iter().zip(&pelvis.joint).map(|(t, p)| t - p);
        sum += tall.map(|v| v.try_normalize(0.0).unwrap_or_default()).sum::<Vec3>();
        count += to - from;
    }
    vertical(origin.path, None, sum / count.max(1) as f64)
}

/// Places of markers over time by their names, none where they were not seen.
type Tracks<'a> = BTreeMap<&'a str, Vec<Option<Vec3>>>;

/// The places of all markers in a run, turned.
fn slice<'a>(
    tracks: &Tracks<'a>,
    (from, to): (usize, usize),
    turn: &UnitQuaternion<f64>,
) -> Places<'a> {
    let cut = |track: &Vec<Option<Vec3>>| -> Vec<Vec3> {
        track[from..to].iter().flatten().map(|p| turn * p).collect()
    };
    tracks.iter().map(|(name, track)| (*name, cut(track))).collect()
}

fn record(
    origin: &Origin,
    parts: &[&Part],
    (tracks, span): (&Tracks, (usize, usize)),
    up: &Up,
    taken: &Taken,
) -> Result<Recording, InputError> {
    let places = slice(tracks, span, &up.turn);
    let frames = span.1 - span.0;
    let mut made: BTreeMap<String, Made> = BTreeMap::new();
    for part in parts {
        let own =
            make(part, &places, &made, frames).map_err(|why| unmade(origin, part, span.0, &why))?;
        made.insert(part.name.clone(), own);
    }
    let segment_lengths_m = lengths(&made);
    remarks::refuse_wrong_unit(origin.path, &segment_lengths_m)?;
    let mut remarks = remarks::all(taken, &made, &up.word, (span, &segment_lengths_m));
    let mut segments: Vec<SegmentTrack> = made
        .into_iter()
        .map(|(name, Made { joint, mut rotation, .. })| {
            make_continuous(&mut rotation);
            SegmentTrack { name, position: joint, rotation }
        })
        .collect();
    sort_segments(&mut segments);
    remarks.sort_by(|a, b| b.size.total_cmp(&a.size));
    let mut recording = Recording {
        source: origin.source.clone(),
        format: origin.format,
        sha256: origin.sha256.clone(),
        rate_hz: taken.rate_hz,
        segments,
        segment_lengths_m,
        remarks,
    };
    note_oddities(&mut recording);
    Ok(recording)
}

fn unmade(origin: &Origin, part: &Part, first: usize, why: &Unmade) -> InputError {
    let (message, remedy) = match why {
        Unmade::Parallel(frame) => (
            format!(
                "frame {}: the two directions of {} are parallel or have no length",
                first + frame,
                part.name
            ),
            "map the segment by other markers: one direction along it, and one square to that",
        ),
        Unmade::Straight => (
            format!(
                "the hinge of {} is straight in all frames, so that nothing tells its axis",
                part.name
            ),
            "map its direction by markers on both sides of the joint",
        ),
    };
    InputError::new(origin.path, message).remedy(remedy)
}

/// Medians over time of the distances between joint centres: markers move on the skin.
fn lengths(made: &BTreeMap<String, Made>) -> Vec<(String, f64)> {
    let between = |from: &str, to: &str| -> Option<f64> {
        let (from, to) = (&made.get(from)?.joint, &made.get(to)?.joint);
        let lengths: Vec<f64> = from.iter().zip(to).map(|(a, b)| (b - a).norm()).collect();
        Some(stats::quantile(&lengths, 0.5))
    };
    lengths_between(between)
}

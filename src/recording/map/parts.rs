//! From places of points to poses of segments.

use super::{Direction, Mean, Part, Point, Source};
use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use crate::recording::axes::square;
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;

/// Least sine of the bend of a hinge that tells its axis: 6 deg.
const BENT: f64 = 0.1;

/// Markers without a gap over the frames of a run, in the world of a recording (z up), m.
pub(super) type Places<'a> = BTreeMap<&'a str, Vec<Vec3>>;

/// The poses of a segment.
#[derive(Debug, Clone)]
pub(super) struct Made {
    pub joint: Vec<Vec3>,
    pub rotation: Vec<UnitQuaternion<f64>>,
    /// Frames in which a hinge was too straight to tell its axis, or the directions were parallel.
    pub straight: usize,
}

/// Why a segment is not made.
#[derive(Debug)]
pub(super) enum Unmade {
    /// The directions are parallel, or one has no length, and no frame before tells better.
    Parallel(usize),
    /// A limb is straight in every frame, so that its hinge tells nothing.
    Straight,
}

/// Makes one segment; `made` holds those that it needs, `frames` is the length of the run.
pub(super) fn make(
    part: &Part,
    places: &Places,
    made: &BTreeMap<String, Made>,
    frames: usize,
) -> Result<Made, Unmade> {
    let mut joint = mean(&part.joint, places, made, frames);
    if let Some(other) = part.offset_in.as_ref().and_then(|name| made.get(name)) {
        for (at, turn) in joint.iter_mut().zip(&other.rotation) {
            *at += turn * part.offset_m;
        }
    }
    let mut straight = 0;
    if let Some((source, by)) = &part.offset_along {
        let (axes, unknown) = along(source, 0, (part, &joint), places, made, frames)?;
        straight = unknown;
        for (at, axis) in joint.iter_mut().zip(&axes) {
            *at += *by * axis.try_normalize(1e-9).unwrap_or_default();
        }
    }
    let mut of = |direction: &Direction| -> Result<Vec<Vec3>, Unmade> {
        let own = (part, joint.as_slice());
        let (axes, unknown) = along(&direction.source, direction.axis, own, places, made, frames)?;
        straight = straight.max(unknown);
        Ok(axes)
    };
    let exact = of(&part.exact)?;
    let near = of(&part.near)?;
    let mut rotation: Vec<UnitQuaternion<f64>> = Vec::with_capacity(frames);
    let near_axis = Vec3::ith(part.near.axis, 1.0);
    let mut before: Option<Vec3> = None;
    for (i, (a, b)) in exact.iter().zip(&near).enumerate() {
        let along = |near: &Vec3| axes((part.exact.axis, a), (part.near.axis, near));
        let turn = along(b).or_else(|| {
            straight += 1;
            along(&before?)
        });
        let turn = turn.ok_or(Unmade::Parallel(i))?;
        before = Some(turn * near_axis);
        rotation.push(turn * part.turn);
    }
    if part.offset_in.is_none() {
        for (at, turn) in joint.iter_mut().zip(&rotation) {
            *at += turn * part.offset_m;
        }
    }
    Ok(Made { joint, rotation, straight })
}

/// A direction over time, and in how many frames a hinge was too straight to tell it; `axis` is the one of another
/// segment that is taken.
fn along(
    source: &Source,
    axis: usize,
    (part, joint): (&Part, &[Vec3]),
    places: &Places,
    made: &BTreeMap<String, Made>,
    frames: usize,
) -> Result<(Vec<Vec3>, usize), Unmade> {
    let at = |m: &Mean| ends(m, part, joint, places, made, frames);
    Ok(match source {
        Source::Between([from, to]) => {
            (at(to).iter().zip(at(from)).map(|(to, from)| to - from).collect(), 0)
        }
        Source::As(name) => {
            let turns = made.get(name).map(|m| m.rotation.as_slice()).unwrap_or_default();
            (turns.iter().map(|turn| turn * Vec3::ith(axis, 1.0)).collect(), 0)
        }
        Source::Hinge(means) => {
            let [a, b, c] = means.each_ref().map(at);
            let bends: Vec<Vec3> = (0..frames).map(|i| bend(a[i], b[i], c[i])).collect();
            steady(&bends).ok_or(Unmade::Straight)?
        }
    })
}

/// The place at one end of a direction. Where that is what the joint is told from, it is the joint, with
/// the offset in another segment's axes: a long axis runs from joint to joint.
fn ends(
    points: &Mean,
    part: &Part,
    joint: &[Vec3],
    places: &Places,
    made: &BTreeMap<String, Made>,
    frames: usize,
) -> Vec<Vec3> {
    if *points == part.joint { joint.to_vec() } else { mean(points, places, made, frames) }
}

fn mean(points: &Mean, places: &Places, made: &BTreeMap<String, Made>, frames: usize) -> Vec<Vec3> {
    let tracks: Vec<&[Vec3]> = points
        .iter()
        .filter_map(|point| match point {
            Point::Marker(name) => places.get(name.as_str()).map(Vec::as_slice),
            Point::Joint(name) => made.get(name).map(|m| m.joint.as_slice()),
        })
        .collect();
    let share = 1.0 / tracks.len() as f64;
    (0..frames).map(|i| share * tracks.iter().map(|t| t[i]).sum::<Vec3>()).collect()
}

/// Unit axis about which a limb bends forwards, times the sine of the bend.
fn bend(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let [first, second] = [b - a, c - b].map(|v| v.try_normalize(0.0).unwrap_or_default());
    first.cross(&second)
}

/// Axes of a hinge, those of straight frames taken from the bent ones around them; how many. None where
/// no frame is bent.
fn steady(bends: &[Vec3]) -> Option<(Vec<Vec3>, usize)> {
    let known: Vec<usize> = (0..bends.len()).filter(|i| bends[*i].norm() >= BENT).collect();
    let (first, last) = (*known.first()?, *known.last()?);
    let unit = |i: usize| bends[i].normalize();
    let mut axes = vec![Vec3::zeros(); bends.len()];
    axes[..=first].fill(unit(first));
    axes[last..].fill(unit(last));
    for pair in known.windows(2) {
        let (from, to) = (unit(pair[0]), unit(pair[1]));
        let apart = pair[1] - pair[0];
        for (k, axis) in axes[pair[0]..=pair[1]].iter_mut().enumerate() {
            *axis = from.lerp(&to, k as f64 / apart as f64);
        }
    }
    Some((axes, bends.len() - known.len()))
}

/// Axes with one as given and another as near as can be; none where they do not tell.
fn axes(exact: (usize, &Vec3), near: (usize, &Vec3)) -> Option<UnitQuaternion<f64>> {
    let kept = exact.1.try_normalize(1e-9)?;
    let turned = square(near.1, &kept)?;
    let third = 3 - exact.0 - near.0;
    let mut columns = [Vec3::zeros(); 3];
    columns[exact.0] = kept;
    columns[near.0] = turned;
    columns[third] = columns[(third + 1) % 3].cross(&columns[(third + 2) % 3]);
    let [x, y, z] = columns;
    Some(rotation_from_axes(x, y, z))
}

//! What every reader does alike: unit quaternions, continuous signs, and notes on what looks odd.

use super::axes::{SEGMENT_NAMES, zxy_angles};
use super::{Recording, Remark, SegmentTrack};
use crate::files::InputError;
use crate::math::Vec3;
use crate::math::pose::rotation_between;
use crate::physical::{RECORDED_M, RECORDED_SPEED_M_S, shown};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::PI;
use std::path::Path;

/// Deviation of a quaternion's norm from one beyond which it is refused.
const NORM_TOLERANCE: f64 = 0.05;
/// Speed of a joint centre (m/s) above which a step counts as a jump; kicks stay below.
const JUMP_SPEED: f64 = 25.0;
/// Angular speed of a segment (rad/s) above which a step counts as a jump.
const JUMP_TURN: f64 = 60.0;
/// Carrying angle (deg) above which an elbow is no longer close to a hinge.
const CARRYING_LIMIT_DEG: f64 = 30.0;
/// Extension (rad) beyond which a knee bends forwards rather than is straight.
const FORWARDS: f64 = 0.5;
/// Largest turn of a collar bone in the trunk (rad) that counts as none.
const STILL: f64 = 1e-3;

/// A unit quaternion from its four numbers; the norm in error where it is not near one.
pub(super) fn unit(w: f64, x: f64, y: f64, z: f64) -> Result<UnitQuaternion<f64>, f64> {
    let q = Quaternion::new(w, x, y, z);
    let norm = q.norm();
    // Written so that a norm that is no number fails too.
    if (norm - 1.0).abs() <= NORM_TOLERANCE {
        Ok(UnitQuaternion::new_normalize(q))
    } else {
        Err(norm)
    }
}

/// Chooses the sign of each quaternion nearest to its predecessor: q and -q are one rotation, but
/// only one of them interpolates.
pub(super) fn make_continuous(rotations: &mut [UnitQuaternion<f64>]) {
    for i in 1..rotations.len() {
        if rotations[i - 1].coords.dot(&rotations[i].coords) < 0.0 {
            rotations[i] = UnitQuaternion::new_unchecked(-rotations[i].into_inner());
        }
    }
}

/// Brings the tracks into the documented order.
pub(super) fn sort_segments(segments: &mut [SegmentTrack]) {
    segments.sort_by_key(|s| SEGMENT_NAMES.iter().position(|n| *n == s.name));
}

/// Refuses places where no recorded person is, and ways between two frames that no body goes: what is left after
/// a broken number.
pub(super) fn refuse_impossible(path: &Path, recording: &Recording) -> Result<(), InputError> {
    let refused = |track: &SegmentTrack, frame: usize, what: String| {
        let name = &track.name;
        Err(InputError::new(path, format!("{name}, frame {frame}: {what}")).remedy(
            "mend or leave out the frame; positions are in metres once the unit of the file counts",
        ))
    };
    for track in &recording.segments {
        for (frame, place) in track.position.iter().enumerate() {
            if let Some(value) = RECORDED_M.outside(place.iter().copied()) {
                return refused(
                    track,
                    frame,
                    format!("a place of {} m is outside {RECORDED_M}", shown(value)),
                );
            }
            let Some(before) = frame.checked_sub(1).map(|i| track.position[i]) else { continue };
            let speed = (place - before).norm() * recording.rate_hz;
            if !RECORDED_SPEED_M_S.holds(speed) {
                let way = (place - before).norm();
                return refused(
                    track,
                    frame,
                    format!("it is {way:.1} m away from the frame before"),
                );
            }
        }
        let turned = |q: &UnitQuaternion<f64>| q.coords.iter().all(|v| v.is_finite());
        if let Some(frame) = track.rotation.iter().position(|q| !turned(q)) {
            return refused(track, frame, "its orientation is no number".to_owned());
        }
    }
    Ok(())
}

/// Adds notes on jumps and on elbows that bend out of their hinge plane.
pub(super) fn note_oddities(recording: &mut Recording) {
    let jumps: Vec<Remark> =
        recording.segments.iter().filter_map(|s| jumps(s, recording.rate_hz)).collect();
    let elbows: Vec<Remark> =
        ["Right", "Left"].iter().filter_map(|side| elbow(recording, side)).collect();
    recording.remarks.extend(jumps.into_iter().chain(elbows));
}

fn jumps(track: &SegmentTrack, rate_hz: f64) -> Option<Remark> {
    let is_jump = |i: &usize| {
        let step = (track.position[*i] - track.position[i - 1]).norm() * rate_hz;
        let turn = rotation_between(&track.rotation[i - 1], &track.rotation[*i]).norm() * rate_hz;
        step > JUMP_SPEED || turn > JUMP_TURN
    };
    let found: Vec<usize> = (1..track.position.len()).filter(is_jump).collect();
    let first = found.first()?;
    let name = &track.name;
    let text = format!(
        "{name} jumps {} times (faster than {JUMP_SPEED} m/s or {JUMP_TURN} rad/s), first at frame \
         {first}: tracking errors are likely there",
        found.len()
    );
    Some(Remark::new(format!("jumps of {name}"), text).of_size(found.len() as f64))
}

fn elbow(recording: &Recording, side: &str) -> Option<Remark> {
    let upper = recording.segment(&format!("{side}UpperArm"))?;
    let fore = recording.segment(&format!("{side}ForeArm"))?;
    let carrying: Vec<f64> = upper
        .rotation
        .iter()
        .zip(&fore.rotation)
        .map(|(u, f)| zxy_angles(&(u.inverse() * f))[1].to_degrees().abs())
        .collect();
    let worst = carrying.iter().copied().fold(0.0, f64::max);
    let beyond = carrying.iter().filter(|a| **a > CARRYING_LIMIT_DEG).count();
    (beyond > 0).then(|| {
        let side = side.to_lowercase();
        let text = format!(
            "the {side} elbow bends out of its hinge plane by more than {CARRYING_LIMIT_DEG} deg in \
             {beyond} of {} frames (at most {worst:.0} deg): the upper arm's axial rotation is \
             uncertain there",
            carrying.len()
        );
        Remark::new(format!("{side} elbow"), text).of_size(worst)
    })
}

/// A note where the collar bones take no part in the movement.
pub(super) fn still_collar_bones(segments: &[SegmentTrack]) -> Option<Remark> {
    let track = |name: &str| segments.iter().find(|s| s.name == name);
    let trunk = track("T8")?;
    let is_still = |collar: &SegmentTrack| {
        trunk.rotation.iter().zip(&collar.rotation).all(|(t, c)| t.angle_to(c) < STILL)
    };
    let (right, left) = (track("RightShoulder")?, track("LeftShoulder")?);
    (is_still(right) && is_still(left)).then(|| {
        Remark::new(
            "collar bones",
            "the collar bones stand still in the skeleton: shoulders that rise or come forward are \
             not seen",
        )
    })
}

/// Turns a leg back that a recording holds half a turn round about its own length.
///
/// Thigh and shank turned by half a turn about their own axes, and a knee that bends as much the other
/// way, leave every joint where it was: what solves markers for angles may end in either, mostly in
/// deep squats. A knee that bends forwards tells which.
pub(super) fn turned_leg(segments: &mut [SegmentTrack], side: &str) -> Option<Remark> {
    let place = |part: &str| segments.iter().position(|s| s.name == format!("{side}{part}"));
    let (thigh, shank) = (place("UpperLeg")?, place("LowerLeg")?);
    let half = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), PI);
    let mut count = 0;
    for frame in 0..segments[thigh].rotation.len() {
        let knee = segments[thigh].rotation[frame].inverse() * segments[shank].rotation[frame];
        // ISB: a knee flexes by turning against z.
        if zxy_angles(&knee)[0] < FORWARDS {
            continue;
        }
        for part in [thigh, shank] {
            segments[part].rotation[frame] *= half;
        }
        count += 1;
    }
    for part in [thigh, shank] {
        make_continuous(&mut segments[part].rotation);
    }
    (count > 0).then(|| {
        let side = side.to_lowercase();
        let text = format!(
            "the {side} knee bends forwards in {count} frames: thigh and shank were turned half round \
             about their own lengths there, which moves no joint"
        );
        Remark::new(format!("{side} knee forwards"), text).of_size(f64::from(count))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_far_from_one_and_no_numbers_are_refused() {
        assert!(unit(1.04, 0.0, 0.0, 0.0).is_ok());
        assert!(unit(0.9, 0.0, 0.0, 0.0).is_err());
        assert!(unit(0.0, 0.0, 0.0, 0.0).is_err());
        assert!(unit(f64::NAN, 0.0, 0.0, 0.0).is_err());
    }

    #[test]
    fn signs_become_continuous_without_changing_the_rotation() {
        let q = UnitQuaternion::from_scaled_axis(Vec3::new(0.3, 0.2, 0.1));
        let flipped = UnitQuaternion::new_unchecked(-q.into_inner());
        let mut rotations = [q, flipped, q, flipped];
        make_continuous(&mut rotations);
        assert!(rotations.iter().all(|r| r.coords.dot(&q.coords) > 0.99));
    }

    #[test]
    fn a_broken_number_in_one_frame_is_refused() {
        let of = |position: Vec<Vec3>| Recording {
            source: "r".into(),
            format: "made up",
            sha256: String::new(),
            rate_hz: 100.0,
            segments: vec![SegmentTrack {
                name: "Head".into(),
                rotation: vec![UnitQuaternion::identity(); position.len()],
                position,
            }],
            segment_lengths_m: Vec::new(),
            remarks: Vec::new(),
        };
        let still = vec![Vec3::new(0.0, 0.0, 1.6); 5];
        let check = |r: &Recording| refuse_impossible(Path::new("r.mvnx"), r);
        check(&of(still.clone())).unwrap();
        for (value, words) in [
            (1e308, "outside -10000 to 10000 m"),
            (-1e9, "outside -10000 to 10000 m"),
            (40.0, "40.0 m away from the frame before"),
            (f64::NAN, "outside -10000 to 10000 m"),
        ] {
            let mut broken = still.clone();
            broken[3].x = value;
            let error = check(&of(broken)).unwrap_err().to_string();
            assert!(error.contains("Head, frame 3") && error.contains(words), "{error}");
        }
    }

    #[test]
    fn jumps_are_reported_with_their_frame() {
        let mut track = SegmentTrack {
            name: "Head".into(),
            position: vec![Vec3::zeros(); 5],
            rotation: vec![UnitQuaternion::identity(); 5],
        };
        assert!(jumps(&track, 100.0).is_none());
        track.position[3].x = 0.6;
        let found = jumps(&track, 100.0).unwrap();
        assert!(found.text.contains("2 times") && found.text.contains("frame 3"), "{found:?}");
        assert_eq!((found.about.as_str(), found.size), ("jumps of Head", 2.0));
    }
}

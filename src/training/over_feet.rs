//! Where the pelvis of a recorded person is over the feet: the six coordinates that a body has besides its
//! joints.
//!
//! ```text
//! feet frame   midway between the balls of the feet, on the floor; x ahead (mean of the feet), y up
//! pelvis       hips seen from there, over the recorded leg, less where they are upright; then its turn
//! height       so that the knees of the body, its feet side by side, bend as the recorded ones on average, seen
//!              from where the person stands upright
//! ```
//! With the recorded height, feet that stand apart or walk would bend the knees of a body whose feet stand side by
//! side by 20 deg for 2 cm; the hips are off by these few centimetres instead.
//!
//! The frame goes with feet that step, so that hand and pelvis are always told from where the person stands.
//! Leg lengths take the place of metres: the pelvis of a body of another size bends its knees as much.

use super::upright::{LegTracks, Upright, stepping};
use crate::files::InputError;
use crate::human::{Body, Legs, Side, Stance, pelvis_coordinates, pelvis_in_rest};
use crate::math::pose::{rotation_from_axes, zxy};
use crate::math::signal::low_pass_zero_phase;
use crate::math::{Pose, Vec3, stats};
use crate::recording::{Recording, SegmentTrack};
use nalgebra::UnitQuaternion;

/// Share of the frames whose lower ankle is below what counts as an ankle on the floor.
const ON_FLOOR: f64 = 0.05;

/// A recorded pelvis over its feet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OverFeet {
    /// The six coordinates of the pelvis, T x 6, leg lengths and rad: filtered.
    pub pelvis: Vec<[f64; 6]>,
    /// Recorded leg from hip to ankle, m.
    pub leg_m: f64,
    /// Whether a foot steps, T.
    pub stepping: Vec<bool>,
    /// Largest change of the height of the pelvis that the knees asked for, leg lengths.
    pub shifted: f64,
}

/// The pelvis of a recorded person over the feet, in a body; none where a recording holds no legs.
///
/// # Errors
/// Where the body's legs are not straight at zero angles, or a recorded leg is not finite.
pub(super) fn over_feet(
    recording: &Recording,
    body: &Body,
    upright: Upright,
    cutoff_hz: f64,
) -> Result<Option<OverFeet>, InputError> {
    let legs = [Side::Right, Side::Left].map(|side| LegTracks::of(recording, side));
    let (Some(pelvis), [Some(right), Some(left)]) = (recording.segment("Pelvis"), &legs) else {
        return Ok(None);
    };
    let sides = [right, left];
    let count = recording.frames();
    let own = Legs::new(body, Stance::Standing { shoe_m: 0.0 })?;
    let stand = own.between_feet(right.ball.is_some() && left.ball.is_some());
    let lengths: Vec<f64> =
        (0..count).map(|i| 0.5 * (right.length_m(i) + left.length_m(i))).collect();
    let leg_m = stats::quantile(&lengths, 0.5);
    let scale = own.length_m() / leg_m;
    let lower = |i: usize| right.foot.position[i].z.min(left.foot.position[i].z);
    let floor_m = stats::quantile(&(0..count).map(lower).collect::<Vec<_>>(), ON_FLOOR);
    let in_feet = |i: usize| {
        let between = |at: &dyn Fn(&LegTracks) -> Vec3| 0.5 * (at(right) + at(left));
        let mut origin = between(&|leg| leg.stands_at(i));
        origin.z = floor_m;
        let axes = ahead(sides, pelvis, i);
        let turn = rotation_from_axes(axes, Vec3::z(), axes.cross(&Vec3::z())).inverse();
        let hip = turn * (between(&|leg| leg.hip.position[i]) - origin) * scale;
        let rotation = turn * pelvis.rotation[i];
        // Where the body's pelvis is when its spine, and so its weight, is there.
        let hips = own.between_hips() + Vec3::x() * (upright.hips_ahead * own.length_m());
        let at = stand + hip - rotation * hips;
        Pose::from_parts(at.into(), rotation)
    };
    let mut shifted = 0.0f64;
    let mut raw = Vec::with_capacity(count);
    for i in 0..count {
        let there = in_feet(i);
        let [one, other] = upright.knees_rad(sides.map(|leg| leg.points(i)));
        let pelvis = own.bent_so(&there, 0.5 * (one + other));
        let by_m = pelvis.translation.y - there.translation.y;
        shifted = shifted.max(by_m.abs() / body.leg_m());
        raw.push(pelvis_coordinates(&pelvis, body.leg_m()));
    }
    if let Some(i) = raw.iter().position(|row| row.iter().any(|v| !v.is_finite())) {
        let message = format!("frame {i} holds a leg that is nowhere or has no length");
        return Err(InputError::new(&recording.source, message)
            .remedy("cut the recording where tracking was lost, or leave the pelvis at rest"));
    }
    let columns: Vec<Vec<f64>> = (0..6)
        .map(|c| {
            let column: Vec<f64> = raw.iter().map(|row| row[c]).collect();
            low_pass_zero_phase(&column, recording.rate_hz, cutoff_hz)
        })
        .collect();
    let pelvis = (0..count)
        .map(|i| {
            let mut row: [f64; 6] = std::array::from_fn(|c| columns[c][i]);
            // A filter may straighten legs beyond straight.
            row[1] -= own.too_high_m(&pelvis_in_rest(&row, body.leg_m())) / body.leg_m();
            row
        })
        .collect();
    let stepping = stepping(sides, recording.rate_hz);
    Ok(Some(OverFeet { pelvis, leg_m, stepping, shifted }))
}

/// How a recorded pelvis is turned, seen from where it faces (about Z, X, Y), T, rad: filtered. Empty where a
/// recording does not hold it.
pub(super) fn turns_where_it_faces(recording: &Recording, cutoff_hz: f64) -> Vec<[f64; 3]> {
    let Some(pelvis) = recording.segment("Pelvis") else { return Vec::new() };
    let turn = |rotation: &UnitQuaternion<f64>| {
        let axes = facing(rotation);
        let level = rotation_from_axes(axes, Vec3::z(), axes.cross(&Vec3::z())).inverse();
        zxy((level * rotation).to_rotation_matrix().matrix())
    };
    let raw: Vec<[f64; 3]> = pelvis.rotation.iter().map(turn).collect();
    let columns: [Vec<f64>; 3] = std::array::from_fn(|c| {
        let column: Vec<f64> = raw.iter().map(|row| row[c]).collect();
        low_pass_zero_phase(&column, recording.rate_hz, cutoff_hz)
    });
    (0..raw.len()).map(|i| std::array::from_fn(|c| columns[c][i])).collect()
}

/// Where a pelvis faces, level: its right side stays level however far it bends.
fn facing(pelvis: &UnitQuaternion<f64>) -> Vec3 {
    let ahead = Vec3::z().cross(&(pelvis * Vec3::z()));
    Vec3::new(ahead.x, ahead.y, 0.0).try_normalize(1e-9).unwrap_or_else(Vec3::x)
}

/// Where the person faces: level, the mean of the feet that do not point backwards, or else as the pelvis.
fn ahead(sides: [&LegTracks; 2], pelvis: &SegmentTrack, i: usize) -> Vec3 {
    let facing = facing(&pelvis.rotation[i]);
    let level = |v: Vec3| Vec3::new(v.x, v.y, 0.0);
    let mut sum = Vec3::zeros();
    for leg in sides {
        let foot = level(leg.foot.rotation[i] * Vec3::x());
        if foot.dot(&facing) > 0.0 {
            sum += foot.normalize();
        }
    }
    if sum.norm() > 1e-6 { sum.normalize() } else { facing }
}

impl OverFeet {
    /// Share of the frames in which a foot steps.
    pub(super) fn stepping_share(&self) -> f64 {
        let count = self.stepping.iter().filter(|s| **s).count();
        count as f64 / self.stepping.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Coupled, Head, Pelvis, Skeleton};
    use std::path::Path;

    const PARTS: [&str; 10] = [
        "Pelvis",
        "RightUpperLeg",
        "RightLowerLeg",
        "RightFoot",
        "RightToe",
        "LeftUpperLeg",
        "LeftLowerLeg",
        "LeftFoot",
        "LeftToe",
        "T8",
    ];
    /// Pelvis forward, up, right, and turned about Z, X, Y; heels stay down.
    const STOOPED: [f64; 6] = [-0.08, -0.05, 0.03, -0.6, 0.05, -0.1];

    /// What a perfect system would record of a body that keeps a posture, somewhere in the world.
    fn record(body: &Body, pelvis: [f64; 6], frames: usize) -> Recording {
        let standing = Stance::Standing { shoe_m: 0.0 };
        let coupled = Coupled { hands: Side::Right.into(), pelvis: Pelvis::Moves };
        let skeleton = Skeleton::new(body, coupled, standing, true).unwrap();
        let mut q = vec![0.0; 30];
        q[..6].copy_from_slice(&pelvis);
        let posed = skeleton.whole(&q, Head::default());
        let posed = skeleton.pose(&posed);
        let rest = body.pelvis_pose([3.0, -2.0], 2.1, standing);
        let at = |name: &str| rest * posed.at(skeleton.segment(name).unwrap());
        let segments = PARTS.iter().map(|name| SegmentTrack {
            name: (*name).to_owned(),
            position: vec![at(name).translation.vector; frames],
            rotation: vec![at(name).rotation; frames],
        });
        Recording {
            source: "made up".into(),
            format: "MVNX v4",
            sha256: String::new(),
            rate_hz: 60.0,
            segments: segments.collect(),
            segment_lengths_m: Vec::new(),
            remarks: Vec::new(),
        }
    }

    fn body(name: &str) -> Body {
        Body::load(name, Path::new(".")).unwrap()
    }

    fn found(recording: &Recording, body: &Body) -> OverFeet {
        over_feet(recording, body, Upright::AS_RECORDED, 6.0).unwrap().unwrap()
    }

    fn departure(a: &[f64; 6], b: &[f64; 6]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_pelvis_is_found_where_it_was() {
        let own = body("female_p50");
        let seen = found(&record(&own, STOOPED, 30), &own);
        assert!(departure(&seen.pelvis[17], &STOOPED) < 1e-9, "{:?}", seen.pelvis[17]);
        assert_eq!((seen.pelvis.len(), seen.stepping_share()), (30, 0.0));
        // In leg lengths a body of another size stands alike; only feet are not quite in proportion.
        assert!(seen.shifted < 1e-6, "{}", seen.shifted);
        let other = found(&record(&body("male_p95"), STOOPED, 30), &own);
        assert!(departure(&other.pelvis[17], &STOOPED) < 0.01, "{:?}", other.pelvis[17]);
    }

    #[test]
    fn a_pelvis_alone_tells_how_it_is_turned_from_where_it_faces() {
        let own = body("female_p50");
        // Feet point ahead and the pelvis faces there: no turn about the vertical.
        let straight = [-0.08, -0.05, 0.03, -0.6, 0.0, 0.0];
        let seen = turns_where_it_faces(&record(&own, straight, 30), 6.0);
        assert!((seen[17][0] + 0.6).abs() < 1e-9 && seen[17][1].hypot(seen[17][2]) < 1e-9);
        // Turned on feet that stay, its bend and lean are told as before.
        let turned = [-0.08, -0.05, 0.03, -0.6, 0.05, -0.1];
        let seen = turns_where_it_faces(&record(&own, turned, 30), 6.0);
        let up = |turn: &[f64]| {
            let all = [0.0, 0.0, 0.0, turn[0], turn[1], turn[2]];
            pelvis_in_rest(&all, 1.0).rotation.inverse() * Vec3::y()
        };
        assert!((up(&seen[17]) - up(&turned[3..])).norm() < 1e-9);
        let mut none = record(&own, straight, 30);
        none.segments.retain(|t| t.name != "Pelvis");
        assert!(turns_where_it_faces(&none, 6.0).is_empty());
    }

    #[test]
    fn feet_that_step_take_the_frame_along() {
        let own = body("female_p50");
        let mut recording = record(&own, STOOPED, 30);
        for track in &mut recording.segments {
            for (i, at) in track.position.iter_mut().enumerate() {
                at.x += 0.02 * i as f64;
            }
        }
        let seen = found(&recording, &own);
        assert!(departure(&seen.pelvis[17], &STOOPED) < 1e-9);
        assert!(seen.stepping_share() > 0.9);
    }

    #[test]
    fn a_foot_that_is_turned_backwards_does_not_turn_the_person() {
        let own = body("female_p50");
        let mut recording = record(&own, STOOPED, 30);
        let back = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), std::f64::consts::PI);
        for track in recording.segments.iter_mut().filter(|t| t.name == "LeftFoot") {
            track.rotation.iter_mut().for_each(|r| *r = back * *r);
        }
        let seen = found(&recording, &own);
        // The other foot alone points outward by 7 deg.
        assert!(departure(&seen.pelvis[17], &STOOPED) < 0.13, "{:?}", seen.pelvis[17]);
    }

    #[test]
    fn knees_bend_as_recorded_however_far_apart_the_feet_are() {
        let own = body("female_p50");
        let legs = Legs::new(&own, Stance::Standing { shoe_m: 0.0 }).unwrap();
        let bent = |seen: &OverFeet| {
            let [right, left] = legs.postures(&pelvis_in_rest(&seen.pelvis[17], own.leg_m()));
            -0.5 * (right.knee + left.knee)
        };
        for apart_m in [0.0, 0.1, 0.2] {
            let mut recording = record(&own, STOOPED, 30);
            let upright = found(&record(&own, [0.0; 6], 30), &own);
            assert!(bent(&upright) < 0.02 && upright.shifted < 1e-6, "{}", bent(&upright));
            for track in recording.segments.iter_mut().filter(|t| t.name.starts_with("RightFoot")) {
                track.position.iter_mut().for_each(|at| at.x += apart_m);
            }
            let recorded = mean_knee(&recording, Upright::AS_RECORDED);
            let seen = found(&recording, &own);
            assert!((bent(&seen) - recorded).abs() < 1e-4, "{} {recorded}", bent(&seen));
        }
    }

    /// Mean flexion of both knees, rad.
    fn mean_knee(recording: &Recording, stood: Upright) -> f64 {
        let legs = [Side::Right, Side::Left].map(|s| LegTracks::of(recording, s).unwrap());
        stood.knees_rad(legs.map(|leg| leg.points(17))).iter().sum::<f64>() / 2.0
    }

    #[test]
    fn who_stands_on_knees_that_look_bent_stands_on_straight_ones() {
        let own = body("female_p50");
        let bent = |down: f64| record(&own, [0.0, -down, 0.0, 0.0, 0.0, 0.0], 30);
        let as_it_is = |recording: &Recording| mean_knee(recording, Upright::AS_RECORDED);
        let (upright, crouched) = (bent(0.02), bent(0.2));
        let straight = Upright::of(&[crouched.clone(), upright.clone()]);
        let twice = Upright::of(&[crouched.clone(), upright.clone(), upright.clone()]);
        assert_eq!(straight, twice);
        assert!((straight.look_bent_deg() - as_it_is(&upright).to_degrees()).abs() < 1.0);
        assert!(as_it_is(&upright) > 0.35 && mean_knee(&upright, straight) < 1e-3);
        // The law of cosines with legs that are shorter by what straight ones look short.
        let less = as_it_is(&crouched) - mean_knee(&crouched, straight);
        assert!((0.03..0.2).contains(&less), "{less}");
        let told = over_feet(&upright, &own, straight, 6.0).unwrap().unwrap();
        let legs = Legs::new(&own, Stance::Standing { shoe_m: 0.0 }).unwrap();
        let [right, _] = legs.postures(&pelvis_in_rest(&told.pelvis[17], own.leg_m()));
        assert!(right.knee.abs() < 0.02, "{}", right.knee);
        // One recording alone may be of somebody who never stood upright, and nobody stands on such knees.
        assert_eq!(Upright::of(&[upright]), Upright::AS_RECORDED);
        let never = Upright::of(&[crouched.clone(), crouched.clone()]);
        assert!((never.look_bent_deg() - 32.5).abs() < 0.1, "{}", never.look_bent_deg());
        assert!(mean_knee(&crouched, never) > 0.5);
    }

    #[test]
    fn hips_that_were_recorded_ahead_of_the_spine_are_put_below_it() {
        let own = body("female_p50");
        let ahead_m = 0.05;
        let of = |pelvis: [f64; 6]| {
            let mut recording = record(&own, pelvis, 60);
            let turn = recording.segment("Pelvis").unwrap().rotation[0];
            for track in &mut recording.segments {
                if track.name.ends_with("UpperLeg") || track.name == "Pelvis" {
                    track.position.iter_mut().for_each(|at| *at += turn * Vec3::x() * ahead_m);
                }
            }
            recording
        };
        let all = [[0.0; 6], [0.01, 0.0, 0.0, 0.0, 0.0, 0.0], STOOPED].map(of);
        let stood = Upright::of(&all);
        let leg_m = Legs::new(&own, Stance::Standing { shoe_m: 0.0 }).unwrap().length_m();
        assert!((stood.hips_ahead - ahead_m / leg_m).abs() < 1e-3, "{stood:?}");
        let seen = over_feet(&stood.levelled(&all[2]), &own, stood, 6.0).unwrap().unwrap();
        // But for its height, which the knees tell; these are of legs that hips elsewhere make longer by a hundredth.
        let off = |seen: &OverFeet, i: usize| (seen.pelvis[17][i] - STOOPED[i]).abs();
        for i in [0, 2, 3, 4, 5] {
            assert!(off(&seen, i) < 0.012, "{i}: {:?}", seen.pelvis[17]);
        }
        assert!(off(&found(&all[2], &own), 0) > 3.0 * off(&seen, 0));
        // Somebody who was only seen to stoop may have the hips there.
        assert_eq!(Upright::of(&[of(STOOPED), of(STOOPED)]).hips_ahead, 0.0);
        assert_eq!(Upright::of(&[of([0.0; 6])]), Upright::AS_RECORDED);
    }

    #[test]
    fn a_pelvis_that_never_looks_level_is_level_where_the_person_stands_erect() {
        let own = body("female_p50");
        let inclined = UnitQuaternion::from_euler_angles(0.1, 0.0, -0.2);
        let of = |pelvis: [f64; 6]| {
            let mut recording = record(&own, pelvis, 60);
            for track in recording.segments.iter_mut().filter(|t| t.name == "Pelvis") {
                track.rotation.iter_mut().for_each(|r| *r *= inclined);
            }
            recording
        };
        let all = [[0.0; 6], [0.01, 0.0, 0.0, 0.0, 0.0, 0.0], STOOPED].map(of);
        let stood = Upright::of(&all);
        assert!((stood.looks_inclined_deg() - inclined.angle().to_degrees()).abs() < 0.1);
        assert!(stood.hips_ahead.abs() < 1e-3, "{stood:?}");
        let seen = over_feet(&stood.levelled(&all[2]), &own, stood, 6.0).unwrap().unwrap();
        assert!(departure(&seen.pelvis[17], &STOOPED) < 0.03, "{:?}", seen.pelvis[17]);
    }

    #[test]
    fn what_holds_no_legs_or_lost_them_tells_no_pelvis() {
        let own = body("female_p50");
        let mut recording = record(&own, [0.0; 6], 30);
        let mut lost = recording.clone();
        lost.segments[1].position[9].x = f64::NAN;
        let error = over_feet(&lost, &own, Upright::AS_RECORDED, 6.0).unwrap_err();
        assert!(error.message().contains("holds a leg"), "{error}");
        recording.segments.retain(|t| t.name != "LeftFoot");
        assert_eq!(over_feet(&recording, &own, Upright::AS_RECORDED, 6.0).unwrap(), None);
    }
}

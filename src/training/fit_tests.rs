//! Fits of made-up recordings whose true posture is known: q -> segment poses -> fit -> q.

use super::fit::{FitSettings, fit};
use crate::human::{Body, Side};
use crate::kinematics::Frames;
use crate::kinematics::{Linkage, Tip};
use crate::math::Vec3;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, pose::rotation_between};
use crate::recording::Recording;
use crate::recording::{SEGMENT_NAMES, SegmentTrack};
use std::f64::consts::TAU;
use std::path::Path;

const RATE_HZ: f64 = 60.0;

/// Smooth random angles inside all limits, T x n.
fn smooth_motion(body: &Body, side: Side, seed: u64, count: usize) -> Vec<Vec<f64>> {
    let arm = body.arm(side).unwrap();
    let limits = body.limits(&arm);
    let draws = normals(&mut stream(seed, Purpose::Simulation, 0, 0), 2 * arm.dof());
    let angle = |c: usize, t: f64| {
        let (lower, upper) = (limits.lower[c], limits.upper[c]);
        // The spine stays inside its sums, the shoulder away from its singular posture.
        let name = &arm.joints()[c].name;
        let reach = if name.contains("Shoulder_X") || c < 12 { 0.3 } else { 0.9 };
        let rate = TAU * (0.2 + 0.1 * draws[2 * c].sin());
        let middle = if name.ends_with("tShoulder_X") { 0.0 } else { 0.5 * (lower + upper) };
        let half = (upper - middle).min(middle - lower);
        middle + reach * half * (rate * t + 6.0 * draws[2 * c + 1]).sin()
    };
    let q: Vec<Vec<f64>> = (0..count)
        .map(|i| (0..arm.dof()).map(|c| angle(c, i as f64 / RATE_HZ)).collect())
        .collect();
    assert!(q.iter().all(|q| limits.violation(q) == 0.0));
    q
}

/// What a perfect system would record of it, in a moving pelvis, without the segments `absent`.
fn record(body: &Body, side: Side, q: &[Vec<f64>], absent: &[&str]) -> Recording {
    let part = |s: &str| format!("{}{s}", side.prefix());
    let mut names = vec!["L5".to_owned(), "L3".to_owned(), "T12".to_owned(), "T8".to_owned()];
    names.extend(["Shoulder", "UpperArm", "ForeArm", "Hand"].map(part));
    let mut tips = vec![Tip::link(side.grip())];
    tips.extend(names.iter().map(|n| Tip::link(n)));
    let linkage = Linkage::new(&body.model, "Pelvis", &tips).unwrap();
    let mut frames = Frames::default();
    let pelvis: Vec<Pose> = (0..q.len())
        .map(|i| {
            let t = i as f64 / RATE_HZ;
            Pose::new(Vec3::new(t, 0.2 * t.sin(), 1.0), Vec3::new(1.5, 0.3 * t, 0.2))
        })
        .collect();
    let mut tracks: Vec<Vec<Pose>> = vec![Vec::new(); names.len()];
    for (q, base) in q.iter().zip(&pelvis) {
        linkage.forward(q, &mut frames);
        for (tip, track) in tracks.iter_mut().enumerate() {
            track.push(base * linkage.tip_pose(&frames, tip + 1));
        }
    }
    names.insert(0, "Pelvis".to_owned());
    tracks.insert(0, pelvis);
    let segments = names.into_iter().zip(tracks).filter(|(n, _)| !absent.contains(&n.as_str()));
    let segments: Vec<SegmentTrack> = segments
        .map(|(name, poses)| SegmentTrack {
            name,
            position: poses.iter().map(|p| p.translation.vector).collect(),
            rotation: poses.iter().map(|p| p.rotation).collect(),
        })
        .collect();
    assert!(segments.iter().all(|s| SEGMENT_NAMES.contains(&s.name.as_str())));
    Recording {
        source: "made up".into(),
        format: "MVNX v4",
        sha256: String::new(),
        rate_hz: RATE_HZ,
        segments,
        segment_lengths_m: Vec::new(),
        notes: Vec::new(),
    }
}

/// Nothing but the observations counts, and nothing is filtered.
fn plain() -> FitSettings {
    FitSettings {
        sharing_sd_deg: 1e6,
        previous_sd_deg: 1e6,
        cutoff_hz: 1e3,
        ..FitSettings::default()
    }
}

fn body() -> Body {
    Body::load("female_p50", Path::new(".")).unwrap()
}

#[test]
fn gives_back_a_movement_of_its_own_body() {
    let body = body();
    for (seed, side) in [(1, Side::Right), (2, Side::Left), (3, Side::Right)] {
        let q = smooth_motion(&body, side, seed, 150);
        let motion = fit(&record(&body, side, &q, &[]), &body, side, &plain()).unwrap();
        let report = &motion.report;
        assert!(report.hand_residual_mm.max < 0.01, "{:?}", report.hand_residual_mm);
        for (name, turn) in &report.orientation_residual_deg {
            assert!(*turn < 0.01, "{name}: {turn} deg");
        }
        assert!(Vec3::from(report.pelvis_offset_mm).norm() < 0.01);
        assert_eq!((motion.joints.len(), motion.q.len(), motion.qdot.len()), (24, 150, 150));
        for (found, truth) in motion.q.iter().zip(&q) {
            for (name, (a, b)) in motion.joints.iter().zip(found.iter().zip(truth)) {
                assert!((a - b).abs() < 2e-4, "{name}: {a} for {b}");
            }
        }
    }
}

#[test]
fn without_the_lower_spine_it_shares_the_turn() {
    let body = body();
    let side = Side::Right;
    let limits = body.limits(&body.arm(side).unwrap());
    let mut q = smooth_motion(&body, side, 4, 90);
    for q in &mut q {
        // Shares of flexion as documented, of the other axes by range; the girdle at rest.
        for axis in 0..3 {
            let columns = [0, 3, 6, 9].map(|c| c + axis);
            let shares = match axis {
                0 => [1.0, 0.44, 0.44, 0.33],
                _ => columns.map(|c| limits.upper[c] - limits.lower[c]),
            };
            let sum: f64 = shares.iter().sum();
            let total = columns.iter().map(|&c| q[c]).sum::<f64>() * 0.5;
            for (c, share) in columns.iter().zip(shares) {
                q[*c] = total * share / sum;
            }
        }
        q[12..15].fill(0.0);
        assert!(limits.violation(q) == 0.0);
    }
    let recording = record(&body, side, &q, &["L5", "L3", "T12", "RightShoulder"]);
    let settings = FitSettings { sharing_sd_deg: 60.0, ..plain() };
    let motion = fit(&recording, &body, side, &settings).unwrap();
    assert!(motion.report.notes.iter().any(|n| n.contains("L5, L3, T12, RightShoulder")));
    assert!(motion.report.hand_residual_mm.max < 0.01, "{:?}", motion.report.hand_residual_mm);
    for (found, truth) in motion.q.iter().zip(&q) {
        for (name, (a, b)) in motion.joints.iter().zip(found.iter().zip(truth)) {
            assert!((a - b).abs() < 1e-3, "{name}: {a} for {b}");
        }
    }
}

#[test]
fn an_offset_of_the_hand_is_found_and_taken_out() {
    let body = body();
    let side = Side::Right;
    let q = smooth_motion(&body, side, 5, 120);
    let mut recording = record(&body, side, &q, &[]);
    let shift = Vec3::new(0.03, -0.02, 0.015);
    let turns = recording.segments[0].rotation.clone();
    let hand = recording.segments.iter_mut().find(|s| s.name == "RightHand").unwrap();
    for (p, turn) in hand.position.iter_mut().zip(&turns) {
        *p += turn * shift;
    }
    let motion = fit(&recording, &body, side, &plain()).unwrap();
    assert!((Vec3::from(motion.report.pelvis_offset_mm) - shift * 1e3).norm() < 0.01);
    assert!(motion.report.hand_residual_mm.max < 0.01);
    assert!(motion.report.coupling_error_m_s < 2e-3, "{}", motion.report.coupling_error_m_s);
}

#[test]
fn rotations_beyond_the_limits_end_on_them() {
    let body = body();
    let side = Side::Right;
    let q = smooth_motion(&body, side, 6, 60);
    let mut recording = record(&body, side, &q, &[]);
    // A forearm that bends sideways by 40 deg: no elbow does.
    let hand = recording.segments.len() - 1;
    let bend = nalgebra::UnitQuaternion::from_scaled_axis(Vec3::new(0.7, 0.0, 0.0));
    let before = recording.segments[hand - 1].rotation[0];
    for i in [hand - 1, hand] {
        for turn in &mut recording.segments[i].rotation {
            *turn *= bend;
        }
    }
    let turned = rotation_between(&before, &recording.segments[hand - 1].rotation[0]);
    assert!((turned.norm() - 0.7).abs() < 1e-9);
    let motion = fit(&recording, &body, side, &FitSettings::default()).unwrap();
    let limits = body.limits(&body.arm(side).unwrap());
    assert!(motion.q.iter().all(|q| limits.violation(q) < 1e-9));
    assert!(motion.report.frames_at_limit_share > 0.5);
    assert!(motion.report.joints_at_limit.iter().any(|(n, _)| n == "jRightElbow_X"));
    assert!(motion.report.notes.iter().any(|n| n.contains("jRightElbow_X")));
}

#[test]
fn what_cannot_be_fitted_is_said() {
    let body = body();
    let q = smooth_motion(&body, Side::Right, 7, 5);
    let run = |r: &Recording, side, s: &FitSettings| {
        fit(r, &body, side, s).unwrap_err().message().to_owned()
    };
    let good = record(&body, Side::Right, &q, &[]);
    let settings = FitSettings::default();
    assert!(run(&good, Side::Left, &settings).contains("LeftHand"));
    let no_chest = record(&body, Side::Right, &q, &["T8"]);
    assert!(run(&no_chest, Side::Right, &settings).contains("`T8`"));
    let short = record(&body, Side::Right, &q[..3], &[]);
    assert!(run(&short, Side::Right, &settings).contains("3 frames"));
    let mut lost = good.clone();
    lost.segments[3].rotation[2].as_mut_unchecked().coords.x = f64::NAN;
    assert!(run(&lost, Side::Right, &settings).contains("frame 2"));
    let zero = FitSettings { hand_sd_mm: 0.0, ..settings };
    assert!(run(&good, Side::Right, &zero).contains("hand_sd_mm"));
}

//! Fits of made-up recordings whose true posture is known: q -> segment poses -> fit -> q.

use super::fit::{FitSettings, fit};
use crate::human::{Body, Side};
use crate::kinematics::Frames;
use crate::kinematics::{Linkage, Tip};
use crate::math::Pose;
use crate::math::Vec3;
use crate::math::stream::{Purpose, normals, stream};
use crate::recording::Recording;
use crate::recording::{SEGMENT_NAMES, SegmentTrack};
use nalgebra::UnitQuaternion;
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
        remarks: Vec::new(),
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
    assert!(motion.report.remarks.iter().any(|n| n.text.contains("L5, L3, T12, RightShoulder")));
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

/// Turns a recorded segment about its own axes.
fn turn(recording: &mut Recording, segment: &str, by: impl Fn(usize) -> Vec3) {
    let track = recording.segments.iter_mut().find(|s| s.name == segment).unwrap();
    for (i, rotation) in track.rotation.iter_mut().enumerate() {
        *rotation *= UnitQuaternion::from_scaled_axis(by(i));
    }
}

#[test]
fn rotations_beyond_the_limits_end_on_them() {
    let body = body();
    let side = Side::Right;
    let mut recording = record(&body, side, &bending(&body, side, 0.0, 120), &[]);
    // A pronated forearm that swings sideways by 60 deg and more to either side: no elbow does, and no
    // constant explains it.
    for name in ["RightForeArm", "RightHand"] {
        turn(&mut recording, name, |i| {
            let angle = 1.2 * (TAU * i as f64 / 120.0).sin();
            Vec3::new(0.0, 0.0, angle)
        });
    }
    let settings = FitSettings::default();
    let motion = fit(&recording, &body, side, &settings).unwrap();
    let limits = body.limits(&body.arm(side).unwrap());
    let slack = settings.limit_slack_deg.to_radians();
    assert!(motion.q.iter().all(|q| limits.widened(slack).violation(q) < 1e-9));
    let report = &motion.report;
    assert!(report.joints_at_limit.iter().any(|(n, share)| n == "jRightElbow_X" && *share > 0.02));
    let elbow = report.beyond_range.iter().find(|b| b.joint == "jRightElbow_X").unwrap();
    assert!((elbow.largest_deg - settings.limit_slack_deg).abs() < 0.1, "{elbow:?}");
    assert!(
        report
            .remarks
            .iter()
            .any(|n| n.text.contains("presses") && n.text.contains("jRightElbow_X"))
    );
    assert!(
        report.remarks.iter().any(|n| n.text.contains("beyond the body's range: jRightElbow_X"))
    );
    // Without slack the body's own limits hold.
    let strict = FitSettings { limit_slack_deg: 0.0, ..settings };
    let motion = fit(&recording, &body, side, &strict).unwrap();
    assert!(motion.q.iter().all(|q| limits.violation(q) < 1e-9));
    assert!(motion.report.beyond_range.is_empty());
}

/// An arm that bends by 30 to 90 deg while the shoulder moves, and sideways by `sideways` deg.
fn bending(body: &Body, side: Side, sideways: f64, count: usize) -> Vec<Vec<f64>> {
    let joints = body.arm(side).unwrap();
    let at = |i: usize| {
        let phase = TAU * i as f64 / 60.0;
        let angle = |name: &str| match name {
            "jRightShoulder_Z" => 30.0 + 20.0 * (phase * 0.7).sin(),
            "jRightShoulder_X" => -25.0 + 8.0 * (phase * 1.3).sin(),
            "jRightShoulder_Y" => 15.0 * (phase * 0.9).sin(),
            "jRightElbow_Z" => 60.0 + 30.0 * phase.sin(),
            "jRightElbow_X" => sideways * (phase * 1.7).sin(),
            "jRightElbow_Y" => 90.0 + 20.0 * (phase * 1.1).cos(),
            _ => 0.0,
        };
        joints.joints().iter().map(|j| f64::to_radians(angle(&j.name))).collect()
    };
    (0..count).map(at).collect()
}

#[test]
fn a_planted_misalignment_is_found_and_nothing_presses() {
    let body = body();
    let side = Side::Right;
    // A movement that uses the whole range of the elbow: any other turn would leave it.
    let q = bending(&body, side, 19.0, 150);
    let clean = fit(&record(&body, side, &q, &[]), &body, side, &FitSettings::default()).unwrap();
    for (name, turn) in &clean.report.calibration_deg {
        assert!(Vec3::from(*turn).norm() < 0.1, "{name}: {turn:?} deg for nothing");
    }
    // A cluster that sits 25 deg turned about the upper arm: the elbow seems to bend further sideways.
    let mut recording = record(&body, side, &q, &[]);
    turn(&mut recording, "RightUpperArm", |_| Vec3::new(0.0, -25f64.to_radians(), 0.0));
    let motion = fit(&recording, &body, side, &FitSettings::default()).unwrap();
    let report = &motion.report;
    let found = |name: &str| {
        let (_, turn) = report.calibration_deg.iter().find(|(n, _)| n == name).unwrap();
        Vec3::from(*turn)
    };
    let upper_arm = found("RightUpperArm");
    // The prior (15 deg) holds a part of it back.
    assert!((upper_arm - Vec3::new(0.0, 25.0, 0.0)).norm() < 10.0, "{upper_arm:?}");
    assert_eq!(report.frames_at_limit_share, 0.0, "{:?}", report.joints_at_limit);
    assert!(report.beyond_range.iter().all(|b| b.largest_deg < 8.0), "{:?}", report.beyond_range);
    // With neither calibration nor slack it presses.
    let stiff = FitSettings {
        tilt_sd_deg: 0.01,
        axial_sd_deg: 0.01,
        limit_slack_deg: 0.0,
        ..FitSettings::default()
    };
    let pressed = fit(&recording, &body, side, &stiff).unwrap().report;
    assert!(pressed.frames_at_limit_share > 0.2, "{}", pressed.frames_at_limit_share);
}

#[test]
fn an_arm_that_stretches_is_trusted_less() {
    let body = body();
    let side = Side::Right;
    let q = bending(&body, side, 0.0, 120);
    let mut recording = record(&body, side, &q, &[]);
    let rigid = fit(&recording, &body, side, &FitSettings::default()).unwrap().report;
    assert!(rigid.stretch_mm < 1e-6, "{}", rigid.stretch_mm);
    let forearm = recording.segment("RightForeArm").unwrap().rotation.clone();
    let hand = recording.segments.iter_mut().find(|s| s.name == "RightHand").unwrap();
    for (i, (p, turn)) in hand.position.iter_mut().zip(&forearm).enumerate() {
        *p += turn * Vec3::new(0.0, 0.03 * (TAU * i as f64 / 40.0).sin(), 0.0);
    }
    let report = fit(&recording, &body, side, &FitSettings::default()).unwrap().report;
    assert!((report.stretch_mm - 30.0 / 2f64.sqrt()).abs() < 0.5, "{}", report.stretch_mm);
    // The hand leaves its place rather than the arm its turns.
    for (name, turn) in &report.orientation_residual_deg {
        assert!(*turn < 2.0, "{name}: {turn} deg");
    }
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

//! Real recordings, where they are at hand: the axes of every format against the files' own figures.

use ergopath::math::Vec3;
use ergopath::math::stats::quantile;
use ergopath::recording::{Recording, read, zxy_angles};
use std::path::{Path, PathBuf};

/// A file or folder of recordings.
fn shared(name: &str) -> Option<PathBuf> {
    crate::skips::shared(&format!("recordings/{name}"))
}

/// ZXY angles (deg) of a child segment in its parent over time: `[z, x, y]` series.
fn angles(r: &Recording, parent: &str, child: &str) -> [Vec<f64>; 3] {
    let (p, c) = (r.segment(parent).unwrap(), r.segment(child).unwrap());
    let all: Vec<[f64; 3]> = p
        .rotation
        .iter()
        .zip(&c.rotation)
        .map(|(p, c)| zxy_angles(&(p.inverse() * c)).map(f64::to_degrees))
        .collect();
    [0, 1, 2].map(|i| all.iter().map(|a| a[i]).collect())
}

/// Joints of the file's `jointAngle` in file order, with the signs of its (X, Y, Z).
const JOINTS: [(&str, &str, [f64; 3]); 14] = [
    ("Pelvis", "L5", [1.0, 1.0, -1.0]),
    ("L5", "L3", [1.0, 1.0, -1.0]),
    ("L3", "T12", [1.0, 1.0, -1.0]),
    ("T12", "T8", [1.0, 1.0, -1.0]),
    ("T8", "Neck", [1.0, 1.0, -1.0]),
    ("Neck", "Head", [1.0, 1.0, -1.0]),
    ("T8", "RightShoulder", [-1.0, 1.0, 1.0]),
    ("RightShoulder", "RightUpperArm", [-1.0, 1.0, 1.0]),
    ("RightUpperArm", "RightForeArm", [-1.0, 1.0, 1.0]),
    ("RightForeArm", "RightHand", [-1.0, 1.0, 1.0]),
    ("T8", "LeftShoulder", [1.0, -1.0, 1.0]),
    ("LeftShoulder", "LeftUpperArm", [1.0, -1.0, 1.0]),
    ("LeftUpperArm", "LeftForeArm", [1.0, -1.0, 1.0]),
    ("LeftForeArm", "LeftHand", [1.0, -1.0, 1.0]),
];

/// The numbers of `<jointAngle>` of every frame, found without an XML reader of any kind.
fn joint_angles_of_file(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let parts = text.split("<jointAngle>").skip(1);
    parts
        .map(|p| {
            p.split('<').next().unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect()
        })
        .collect()
}

#[test]
fn mvnx_joint_angles_are_those_of_the_file() {
    for (name, format, frames) in [
        ("v3_4frames", "MVNX v3", 4),
        ("v3_kick_240hz", "MVNX v3", 540),
        ("v4_upper_body_60hz", "MVNX v4", 112),
    ] {
        let Some(path) = shared(&format!("xsens_mvnx/{name}.mvnx")) else { return };
        let r = read(&path, None).unwrap();
        assert_eq!((r.format, r.frames(), r.segments.len()), (format, frames, 23));
        let file = joint_angles_of_file(&path);
        assert_eq!(file.len(), frames);
        let mut worst: f64 = 0.0;
        for (j, (parent, child, signs)) in JOINTS.iter().enumerate() {
            let [z, x, y] = angles(&r, parent, child);
            for i in 0..frames {
                for (k, mine) in [x[i], y[i], z[i]].iter().enumerate() {
                    let gap =
                        (signs[k] * mine - file[i][3 * j + k] + 540.0).rem_euclid(360.0) - 180.0;
                    worst = worst.max(gap.abs());
                }
            }
        }
        println!(
            "{name}: largest difference {worst:.5} deg; {:?}; {:?}",
            r.segment_lengths_m, r.remarks
        );
        assert!(worst < 0.01, "{name}: {worst} deg");
    }
}

/// Largest turn between a joint of two recordings and its 95th percentile over time, deg; the second lacks
/// the first frames of the first.
fn apart(a: &Recording, b: &Recording, parent: &str, child: &str) -> [f64; 2] {
    let late = a.frames() - b.frames();
    let turn = |r: &Recording, i: usize| {
        let [p, c] = [parent, child].map(|n| r.segment(n).unwrap().rotation[i]);
        p.inverse() * c
    };
    let gap = |i: usize| turn(a, i + late).angle_to(&turn(b, i)).to_degrees();
    let gaps: Vec<f64> = (0..b.frames()).map(gap).collect();
    [1.0, 0.95].map(|p| quantile(&gaps, p))
}

const LEGS: [(&str, &str); 8] = [
    ("Pelvis", "RightUpperLeg"),
    ("RightUpperLeg", "RightLowerLeg"),
    ("RightLowerLeg", "RightFoot"),
    ("RightFoot", "RightToe"),
    ("Pelvis", "LeftUpperLeg"),
    ("LeftUpperLeg", "LeftLowerLeg"),
    ("LeftLowerLeg", "LeftFoot"),
    ("LeftFoot", "LeftToe"),
];

#[test]
fn one_take_has_the_same_joint_angles_as_mvnx_and_as_bvh() {
    let Some(path) = shared("xsens_mvnx/v4_upper_body_60hz.mvnx") else { return };
    let Some(same) = shared("xsens_mvnx/v4_upper_body_60hz.bvh") else { return };
    let (mvnx, bvh) = (read(&path, None).unwrap(), read(&same, None).unwrap());
    assert_eq!((bvh.format, bvh.rate_hz, bvh.segments.len()), ("BVH", 60.0, 23));
    // The first frame of the BVH is the rest pose.
    assert_eq!((mvnx.frames(), bvh.frames()), (112, 111));
    println!("{:?}", bvh.remarks);
    let arms_and_trunk = JOINTS.iter().map(|(parent, child, _)| (*parent, *child));
    for (parent, child) in arms_and_trunk.chain(LEGS) {
        let [largest, p95] = apart(&mvnx, &bvh, parent, child);
        println!("{child:14} in {parent:14}: at most {largest:.4}, p95 {p95:.4} deg");
        assert!(p95 < 0.5, "{child} in {parent}: {p95} deg");
        // Only bones that lie a little askew in the zero pose differ.
        assert!(largest < 0.06, "{child} in {parent}: {largest} deg");
    }
    for (name, length) in &bvh.segment_lengths_m {
        let there = mvnx.length_m(name).unwrap();
        assert!((length - there).abs() < 1.2e-3, "{name}: {length} m, there {there} m");
    }
    // From the pelvis, the wrists of rigid bones are where the shoulders shift in the MVNX.
    for hand in ["RightHand", "LeftHand"] {
        let from_pelvis = |r: &Recording, i: usize| {
            let [p, h] = ["Pelvis", hand].map(|n| r.segment(n).unwrap());
            p.rotation[i].inverse() * (h.position[i] - p.position[i])
        };
        let gap = |i: usize| (from_pelvis(&mvnx, i + 1) - from_pelvis(&bvh, i)).norm();
        let worst = (0..bvh.frames()).map(gap).fold(0.0, f64::max);
        println!("{hand}: {:.2} mm", worst * 1e3);
        assert!(worst < 3e-3, "{hand}: {worst} m");
    }
}

/// The zero of MVNX 3 is palms forward: with its axes turned to ISB and nothing else, thumb sides
/// point outwards (right: +z) and little fingers inwards, as in the anatomical pose.
#[test]
fn mvnx_zero_is_palms_forward() {
    let Some(path) = shared("xsens_mvnx/v3_4frames.mvnx") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let after = |from: &str, tag: &str| -> Vec<f64> {
        let rest = text.split_once(from).unwrap().1.split_once(tag).unwrap().1;
        rest.split('<').next().unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect()
    };
    let npose = after("type=\"npose\"", "<orientation>");
    for (point, segment, outwards) in [
        ("pRightRadialStyloid", 9, 1.0),
        ("pRightPinky", 10, -1.0),
        ("pLeftRadialStyloid", 13, -1.0),
        ("pLeftPinky", 14, 1.0),
    ] {
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| npose[4 * segment + k]);
        let q = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
        let p = after(point, "<pos_s>");
        let local = q.inverse() * Vec3::new(p[0], p[1], p[2]);
        let isb = Vec3::new(local.x, local.z, -local.y);
        assert!(isb.z * outwards > 0.02 && isb.x.abs() < 1e-3 && isb.y < -0.09, "{point}: {isb:?}");
    }
}

#[test]
fn mvnx_lengths_are_plausible() {
    let Some(path) = shared("xsens_mvnx/v3_kick_240hz.mvnx") else { return };
    let r = read(&path, None).unwrap();
    for (name, wanted) in [
        ("RightUpperArm", 0.2923),
        ("RightForeArm", 0.2397),
        ("ShoulderToShoulder", 0.3584),
        ("T8", 0.1431),
    ] {
        assert!(
            (r.length_m(name).unwrap() - wanted).abs() < 1e-3,
            "{name}: {:?}",
            r.length_m(name)
        );
    }
    // The points agree with the motion: the next joint centre is one length away in every frame.
    let (upper, fore) = (r.segment("LeftUpperArm").unwrap(), r.segment("LeftForeArm").unwrap());
    for (a, b) in upper.position.iter().zip(&fore.position) {
        assert!(((a - b).norm() - r.length_m("LeftUpperArm").unwrap()).abs() < 2e-3);
    }
}

/// Asserts that the share `inside` of the samples lies within the bounds, and shows the quantiles.
fn within(what: &str, samples: &[f64], low: f64, high: f64, inside: f64) {
    let q = [0.0, 0.05, 0.5, 0.95, 1.0].map(|p| quantile(samples, p).round());
    let share =
        samples.iter().filter(|v| (low..=high).contains(*v)).count() as f64 / samples.len() as f64;
    println!("{what:40} {q:?} deg, {:.1} % in {low}..{high}", 100.0 * share);
    assert!(share >= inside, "{what}: only {share} of the samples lie in {low}..{high}");
}

#[test]
fn handover_bodies_move_like_a_person() {
    let Some(path) = shared("kth_handover") else { return };
    let error = read(&path, None).unwrap_err();
    assert!(miette_help(&error).unwrap().contains("giver, taker"), "{error}");
    // Facing: giver and taker stand on either side of the origin and look at each other.
    for (person, side) in [("giver", 1.0), ("taker", -1.0)] {
        let r = read(&path, Some(person)).unwrap();
        assert_eq!((r.frames(), r.segments.len(), r.rate_hz), (801, 13, 120.0));
        println!("{person}: {:?}\n{:?}", r.segment_lengths_m, r.remarks);
        for name in ["Pelvis", "L3", "T8"] {
            let track = r.segment(name).unwrap();
            let tilt: Vec<f64> = track
                .rotation
                .iter()
                .map(|q| (q * Vec3::y()).z.clamp(-1.0, 1.0).acos().to_degrees())
                .collect();
            within(&format!("{person} {name} tilt"), &tilt, 0.0, 30.0, 1.0);
            let forward = |q: &nalgebra::UnitQuaternion<f64>| (q * Vec3::x()).x * side;
            assert!(track.rotation.iter().all(|q| forward(q) > 0.8));
        }
        for (arm, mirror) in [("Right", 1.0), ("Left", -1.0)] {
            let part = |name: &str| format!("{arm}{name}");
            let label = |what: &str| format!("{person} {arm} {what}");
            let mirrored = |v: &[f64]| v.iter().map(|a| mirror * a).collect::<Vec<_>>();
            let [z, x, y] = angles(&r, &part("Shoulder"), &part("UpperArm"));
            within(&label("shoulder flexion"), &z, -30.0, 90.0, 1.0);
            within(&label("shoulder adduction"), &mirrored(&x), -60.0, 10.0, 1.0);
            within(&label("shoulder axial rotation"), &mirrored(&y), -60.0, 60.0, 1.0);
            let [z, x, y] = angles(&r, &part("UpperArm"), &part("ForeArm"));
            within(&label("elbow flexion"), &z, -10.0, 150.0, 1.0);
            within(&label("elbow carrying angle"), &mirrored(&x), -37.0, 37.0, 1.0);
            within(&label("pronation"), &mirrored(&y), 45.0, 135.0, 1.0);
            let [z, x, y] = angles(&r, &part("ForeArm"), &part("Hand"));
            within(&label("wrist flexion"), &z, -80.0, 80.0, 1.0);
            within(&label("wrist deviation"), &mirrored(&x), -40.0, 40.0, 1.0);
            within(&label("wrist axial"), &mirrored(&y), -40.0, 40.0, 1.0);
        }
        // The arm that hands over bends far enough to tell: nearly a hinge about z.
        let [z, x, _] = angles(&r, "RightUpperArm", "RightForeArm");
        within(&format!("{person} right elbow, hinge"), &x, -25.0, 25.0, 0.6);
        within(&format!("{person} right elbow, flexed"), &z, 0.0, 150.0, 0.95);
        let bent: Vec<f64> =
            x.iter().zip(&z).filter(|(_, z)| **z > 45.0).map(|(x, _)| *x).collect();
        within(&format!("{person} right elbow, bent"), &bent, -30.0, 30.0, 0.95);
    }
}

fn miette_help(error: &ergopath::files::InputError) -> Option<String> {
    miette::Diagnostic::help(error).map(|h| h.to_string())
}

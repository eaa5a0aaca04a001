//! A made-up person with markers put on by forward kinematics is met again, and so are its joint angles.

use super::fit::{FitSettings, fit};
use crate::human::{Body, Side};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::{Pose, Vec3};
use crate::recording::{Reading, Recording, read_map, read_with};
use nalgebra::UnitQuaternion;
use std::fmt::Write as _;
use std::path::Path;

const PARTS: [&str; 13] = [
    "L5",
    "L3",
    "T12",
    "T8",
    "Head",
    "RightShoulder",
    "RightUpperArm",
    "RightForeArm",
    "RightHand",
    "RightUpperLeg",
    "RightLowerLeg",
    "RightFoot",
    "LeftUpperLeg",
];
/// Joint, angle (deg) and how far it goes from it (deg): the spine as people share its turn.
const MOVES: [(&str, f64, f64); 13] = [
    ("jL5S1_Z", -10.0, 5.0),
    ("jL4L3_Z", -4.4, 2.2),
    ("jL1T12_Z", -4.4, 2.2),
    ("jT9T8_Z", -3.3, 1.65),
    ("jRightC7Shoulder_X", -5.0, 3.0),
    ("jRightShoulder_Z", 40.0, 20.0),
    ("jRightShoulder_X", -20.0, 10.0),
    ("jRightShoulder_Y", 10.0, 8.0),
    ("jRightElbow_Z", 70.0, 25.0),
    ("jRightElbow_Y", 60.0, 15.0),
    ("jRightWrist_Z", 10.0, 8.0),
    ("jRightHip_Z", 20.0, 10.0),
    ("jRightKnee_Z", -30.0, 15.0),
];
const FRAMES: usize = 120;
const RATE_HZ: f64 = 60.0;
/// From a marker to the joint centre in the segment's axes, mm.
const OFFSET_MM: [f64; 3] = [-20.0, 35.0, 15.0];

struct Posed {
    /// Chain and posture of each frame.
    chain: Linkage,
    q: Vec<Vec<f64>>,
    /// Pose of the pelvis and of each part in the world, by frame.
    poses: Vec<Vec<Pose>>,
}

fn posed(body: &Body) -> Posed {
    let chain = Linkage::new(&body.model, "Pelvis", &PARTS.map(Tip::link)).unwrap();
    let (mut all, mut poses) = (Vec::new(), Vec::new());
    let mut frames = Frames::default();
    for i in 0..FRAMES {
        let phase = 0.4 * std::f64::consts::TAU * i as f64 / RATE_HZ;
        let mut q = vec![0.0; chain.dof()];
        for (joint, middle, by) in MOVES {
            let c = chain.joints().iter().position(|j| j.name == joint).unwrap();
            q[c] = (middle + by * phase.sin()).to_radians();
        }
        chain.forward(&q, &mut frames);
        let turn = UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.4);
        let pelvis = Pose::from_parts(Vec3::new(1.0, -0.5, 0.95).into(), turn);
        let parts = (0..PARTS.len()).map(|tip| pelvis * chain.tip_pose(&frames, tip));
        poses.push(std::iter::once(pelvis).chain(parts).collect());
        all.push(q);
    }
    Posed { chain, q: all, poses }
}

fn names() -> impl Iterator<Item = &'static str> {
    std::iter::once("Pelvis").chain(PARTS)
}

/// Three markers on each segment, in a file whose y axis is up.
fn table(posed: &Posed) -> String {
    let mut text = String::from("time_s");
    for name in names() {
        for marker in ["o", "a", "r"] {
            for axis in ["x", "y", "z"] {
                let _ = write!(text, ",{name}{marker}_{axis}");
            }
        }
    }
    for (i, frame) in posed.poses.iter().enumerate() {
        let _ = write!(text, "\n{}", i as f64 / RATE_HZ);
        for pose in frame {
            let on = |at: Vec3| {
                let offset = 1e-3 * Vec3::from(OFFSET_MM);
                pose.translation.vector + pose.rotation * (at - offset)
            };
            for at in [Vec3::zeros(), Vec3::new(0.1, 0.0, 0.03), Vec3::new(0.0, 0.0, 0.08)] {
                let p = 1e3 * on(at);
                let _ = write!(text, ",{},{},{}", p.y, p.z, p.x);
            }
        }
    }
    text.push('\n');
    text
}

fn map() -> String {
    let mut text = String::from("schema = \"ergopath/map/1\"\n[map]\nunit = \"mm\"\n");
    for name in names() {
        let _ = write!(
            text,
            "[segment.{name}]\njoint = \"{name}o\"\noffset_mm = {OFFSET_MM:?}\n\
             right = [\"{name}o\", \"{name}r\"]\n"
        );
        // An arm is told by its ends.
        let _ = match name {
            "RightUpperArm" => {
                writeln!(text, "end = \"RightForeArmo\"\noffset_in = \"RightUpperArm\"")
            }
            _ => writeln!(text, "ahead = [\"{name}o\", \"{name}a\"]"),
        };
    }
    text
}

fn read(text: &str, map: &str) -> Recording {
    let room = tempfile::tempdir().unwrap();
    let (file, map_file) = (room.path().join("places.csv"), room.path().join("map.toml"));
    std::fs::write(&file, text).unwrap();
    std::fs::write(&map_file, map).unwrap();
    let map = read_map(&map_file).unwrap();
    read_with(&file, &Reading { map: Some(&map), ..Reading::default() }).unwrap()
}

fn body() -> Body {
    Body::load("female_p50", Path::new(".")).unwrap()
}

#[test]
fn markers_on_a_person_give_its_poses() {
    let body = body();
    let posed = posed(&body);
    let recording = read(&table(&posed), &map());
    assert_eq!((recording.rate_hz, recording.frames()), (RATE_HZ, FRAMES));
    for (k, name) in names().enumerate() {
        let track = recording.segment(name).unwrap();
        for (i, poses) in posed.poses.iter().enumerate() {
            // Its long axis is drawn between markers off the joints: the other test has it from joint to joint.
            if name == "RightUpperArm" {
                continue;
            }
            let away = (track.position[i] - poses[k].translation.vector).norm();
            assert!(away < 1e-6, "{name} at {i}: {away} m");
            let turn = track.rotation[i].angle_to(&poses[k].rotation);
            assert!(turn < 1e-6, "{name} at {i}: {turn} rad");
        }
    }
}

#[test]
fn a_long_axis_from_joint_to_joint_is_met_and_so_are_the_angles() {
    let body = body();
    let posed = posed(&body);
    let joints = map().replace(
        "end = \"RightForeArmo\"\noffset_in = \"RightUpperArm\"",
        "end = \"joint of RightForeArm\"\noffset_in = \"RightShoulder\"",
    );
    // The marker of the upper arm sits on the collar bone then.
    let mut moved = posed.poses.clone();
    let (collar, arm) = (6, 7);
    for frame in &mut moved {
        let at = frame[arm].translation;
        frame[arm] = Pose::from_parts(at, frame[collar].rotation);
    }
    let onto = Posed { poses: moved, chain: posed.chain.clone(), q: posed.q.clone() };
    let mut text = String::new();
    // The markers for the turn of the arm stay on the arm.
    let (own, collar_bone) = (table(&posed), table(&onto));
    let header = own.lines().next().unwrap();
    let place = header.split(',').position(|c| c == "RightUpperArmo_x").unwrap();
    let right = header.split(',').position(|c| c == "RightUpperArmr_x").unwrap();
    for (a, b) in own.lines().zip(collar_bone.lines()) {
        let (a, b): (Vec<&str>, Vec<&str>) = (a.split(',').collect(), b.split(',').collect());
        let cells = (0..a.len()).map(|c| if (place..place + 3).contains(&c) { b[c] } else { a[c] });
        text.push_str(&cells.collect::<Vec<_>>().join(","));
        // Where the marker of the arm itself is: the right one is told from there.
        for c in 0..3 {
            let value = a[place + c];
            let name = ["RightUpperArmp_x", "RightUpperArmp_y", "RightUpperArmp_z"][c];
            let _ = write!(text, ",{}", if value.starts_with('R') { name } else { value });
        }
        text.push('\n');
    }
    assert!(right > place);
    let joints = joints.replace("right = [\"RightUpperArmo\"", "right = [\"RightUpperArmp\"");
    let recording = read(&text, &joints);
    let track = recording.segment("RightUpperArm").unwrap();
    for (i, poses) in posed.poses.iter().enumerate() {
        let away = (track.position[i] - poses[arm].translation.vector).norm();
        let turn = track.rotation[i].angle_to(&poses[arm].rotation);
        assert!(away < 1e-6 && turn < 1e-6, "{i}: {away} m, {turn} rad");
    }
    let motion = fit(&recording, &body, Side::Right, &FitSettings::default()).unwrap();
    assert!(motion.report.hand_residual_mm.max < 1.0, "{:?}", motion.report.hand_residual_mm);
    for (c, joint) in motion.joints.iter().enumerate() {
        let own = posed.chain.joints().iter().position(|j| j.name == *joint).unwrap();
        // The filter bends the ends of a movement.
        for i in 10..FRAMES - 10 {
            let off = (motion.q[i][c] - posed.q[i][own]).to_degrees();
            assert!(off.abs() < 0.5, "{joint} at {i}: {off} deg");
        }
    }
}

//! Shipped maps on made-up people: markers where the sets ask for them give the poses of both sides again.

use crate::human::Body;
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::{Pose, Vec3};
use crate::recording::{Map, Reading, read_with};
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A marker: its name (`*` is R or L), the segment in whose axes it lies, the one at whose joint it is, and how far
/// ahead, up and outwards of there, m.
type Marker = (&'static str, &'static str, &'static str, [f64; 3]);

const PLUG_IN_GAIT: [Marker; 20] = [
    ("*ASI", "Pelvis", "Pelvis", [0.047, 0.074, 0.123]),
    ("*PSI", "Pelvis", "Pelvis", [-0.1095, 0.1073, 0.05]),
    ("C7", "T8", "T8", [-0.08, 0.2, 0.0]),
    ("CLAV", "T8", "T8", [0.08, 0.2, 0.0]),
    ("T10", "T8", "T8", [-0.1, 0.0, 0.0]),
    ("STRN", "T8", "T8", [0.1, 0.0, 0.0]),
    ("*FHD", "Head", "Head", [0.09, 0.1, 0.07]),
    ("*BHD", "Head", "Head", [-0.07, 0.1, 0.07]),
    ("*SHO", "T8", "*UpperArm", [0.0, 0.04, 0.01]),
    ("*ELB", "*UpperArm", "*ForeArm", [0.0, 0.0, 0.042]),
    ("*WRA", "*ForeArm", "*Hand", [0.0, 0.0, 0.035]),
    ("*WRB", "*ForeArm", "*Hand", [0.0, 0.0, -0.035]),
    ("*FIN", "*Hand", "*Hand", [0.0, -0.08, 0.0]),
    ("*THI", "*UpperLeg", "*UpperLeg", [0.0, -0.2, 0.09]),
    ("*KNE", "*UpperLeg", "*LowerLeg", [0.0, 0.0, 0.052]),
    ("*TIB", "*LowerLeg", "*LowerLeg", [0.0, -0.2, 0.06]),
    ("*ANK", "*LowerLeg", "*Foot", [0.0, 0.0, 0.042]),
    ("*HEE", "*Foot", "*Toe", [-0.2, 0.0, 0.0]),
    ("*TOE", "*Foot", "*Toe", [0.0, 0.0, 0.0]),
    ("*UPA", "*UpperArm", "*UpperArm", [0.0, -0.15, 0.05]),
];

const QUALISYS_SPORTS: [Marker; 21] = [
    ("Waist*Front", "Pelvis", "Pelvis", [0.047, 0.074, 0.123]),
    ("WaistBack", "Pelvis", "Pelvis", [-0.1095, 0.1073, 0.0]),
    ("SpineThoracic12", "T8", "T8", [-0.06, -0.06, 0.0]),
    ("SpineThoracic2", "T8", "T8", [-0.06, 0.2, 0.0]),
    ("Chest", "T8", "T8", [0.1, 0.15, 0.0]),
    ("HeadFront", "Head", "Head", [0.1, 0.08, 0.0]),
    ("Head*", "Head", "Head", [0.0, 0.08, 0.08]),
    ("*ShoulderTop", "T8", "*UpperArm", [0.0, 0.04, 0.01]),
    ("*ElbowOut", "*UpperArm", "*ForeArm", [0.0, 0.0, 0.042]),
    ("*ElbowIn", "*UpperArm", "*ForeArm", [0.0, 0.0, -0.042]),
    ("*WristIn", "*ForeArm", "*Hand", [0.0, 0.0, 0.035]),
    ("*WristOut", "*ForeArm", "*Hand", [0.0, 0.0, -0.035]),
    ("*Hand2", "*Hand", "*Hand", [0.0, -0.08, 0.0]),
    ("*KneeOut", "*UpperLeg", "*LowerLeg", [0.0, 0.0, 0.052]),
    ("*KneeIn", "*UpperLeg", "*LowerLeg", [0.0, 0.0, -0.052]),
    ("*AnkleOut", "*LowerLeg", "*Foot", [0.0, 0.0, 0.042]),
    ("*HeelBack", "*Foot", "*Toe", [-0.2, 0.0, 0.0]),
    // The foot points from the heel to the second toe.
    ("*Forefoot2", "*Foot", "*Toe", [0.0, 0.0, 0.0]),
    ("*Forefoot5", "*Foot", "*Toe", [0.0, 0.0, 0.04]),
    ("*ShinFrontHigh", "*LowerLeg", "*LowerLeg", [0.05, -0.1, 0.0]),
    ("*ThighFrontLow", "*UpperLeg", "*UpperLeg", [0.06, -0.3, 0.0]),
];

/// Joint, angle (deg) and how far it goes from it; turns about up and ahead are mirrored on the left.
const MOVES: [(&str, f64, f64); 12] = [
    ("jL5S1_Z", -10.0, 5.0),
    ("jT9T8_Y", 5.0, 4.0),
    ("j*Shoulder_Z", 40.0, 20.0),
    ("j*Shoulder_X", -20.0, 10.0),
    ("j*Shoulder_Y", 10.0, 8.0),
    ("j*Elbow_Z", 70.0, 25.0),
    ("j*Elbow_Y", 60.0, 15.0),
    ("j*Wrist_Z", 10.0, 8.0),
    ("j*Hip_Z", 25.0, 20.0),
    ("j*Hip_X", -6.0, 3.0),
    ("j*Knee_Z", -35.0, 30.0),
    ("j*Ankle_Z", 8.0, 5.0),
];
const FRAMES: usize = 60;

type Poses = BTreeMap<String, Vec<Pose>>;

/// Right and left, as in names of segments and of markers, and the sign of what points outwards.
const SIDES: [(&str, &str, f64); 2] = [("Right", "R", 1.0), ("Left", "L", -1.0)];

fn both(name: &str, parts: [&str; 2]) -> Vec<String> {
    if name.contains('*') {
        parts.map(|p| name.replace('*', p)).to_vec()
    } else {
        vec![name.to_owned()]
    }
}

fn poses(body: &Body, markers: &[Marker]) -> Poses {
    let mut names: Vec<String> = Vec::new();
    for (_, turned, placed, _) in markers {
        names.extend([turned, placed].iter().flat_map(|n| both(n, ["Right", "Left"])));
    }
    names.sort();
    names.dedup();
    names.retain(|n| n != "Pelvis");
    let tips: Vec<Tip> = names.iter().map(|n| Tip::link(n)).collect();
    let chain = Linkage::new(&body.model, "Pelvis", &tips).unwrap();
    let mut frames = Frames::default();
    let mut all: Poses = BTreeMap::new();
    for i in 0..FRAMES {
        let phase = std::f64::consts::TAU * i as f64 / FRAMES as f64;
        let mut q = vec![0.0; chain.dof()];
        for (joint, middle, by) in MOVES {
            for name in both(joint, ["Right", "Left"]) {
                let is_mirrored = name.contains("Left") && !name.ends_with('Z');
                let c = chain.joints().iter().position(|j| j.name == name).unwrap();
                let angle = middle + by * phase.sin();
                q[c] = if is_mirrored { -angle } else { angle }.to_radians();
            }
        }
        chain.forward(&q, &mut frames);
        let turn = UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.4);
        let pelvis = Pose::from_parts(Vec3::new(1.0, -0.5, 0.95).into(), turn);
        all.entry("Pelvis".to_owned()).or_default().push(pelvis);
        for (tip, name) in names.iter().enumerate() {
            let pose = pelvis * chain.tip_pose(&frames, tip);
            all.entry(name.clone()).or_default().push(pose);
        }
    }
    all
}

/// An export of Qualisys: millimetres, with a header.
fn export(markers: &[Marker], poses: &Poses) -> String {
    let mut tracks: Vec<(String, Vec<Vec3>)> = Vec::new();
    for (name, turned, placed, at) in markers {
        for (side, short, out) in SIDES {
            let is_both = name.contains('*');
            if !is_both && out < 0.0 {
                continue;
            }
            let pose = |n: &str| &poses[&n.replace('*', side)];
            let off = Vec3::new(at[0], at[1], if is_both { out * at[2] } else { at[2] });
            let places = pose(turned)
                .iter()
                .zip(pose(placed))
                .map(|(t, p)| 1e3 * (p.translation.vector + t.rotation * off));
            tracks.push((name.replace('*', short), places.collect()));
        }
    }
    let names: Vec<&str> = tracks.iter().map(|(n, _)| n.as_str()).collect();
    let mut text = format!("FREQUENCY\t60\nMARKER_NAMES\t{}\n", names.join("\t"));
    for i in 0..FRAMES {
        let cells = tracks.iter().map(|(_, t)| format!("{}\t{}\t{}", t[i].x, t[i].y, t[i].z));
        let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("\t"));
    }
    text
}

#[test]
fn shipped_maps_meet_the_person_under_the_markers() {
    let body = Body::load("male_p50", "".as_ref()).unwrap();
    for (map, markers) in
        [("plug_in_gait", &PLUG_IN_GAIT[..]), ("qualisys_sports", &QUALISYS_SPORTS[..])]
    {
        let poses = poses(&body, markers);
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("a.tsv");
        std::fs::write(&file, export(markers, &poses)).unwrap();
        let map = Map::shipped(map).unwrap();
        let recording =
            read_with(&file, &Reading { map: Some(&map), ..Reading::default() }).unwrap();
        assert_eq!(recording.segments.len(), map.segments().count(), "{}", map.name);
        for track in &recording.segments {
            for (i, pose) in poses[&track.name].iter().enumerate() {
                let away = (track.position[i] - pose.translation.vector).norm();
                let turn = track.rotation[i].angle_to(&pose.rotation).to_degrees();
                let what = format!("{}, {} at {i}", map.name, track.name);
                assert!(away < 0.02, "{what}: {away} m");
                assert!(turn < 3.0, "{what}: {turn} deg");
            }
        }
    }
}

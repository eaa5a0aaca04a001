//! Postures by the coordinates of `OpenSim` and by poses in tables, and what is refused or told of them.

use crate::files::InputError;
use crate::math::Vec3;
use crate::recording::{Map, Reading, Recording, read_map, read_with, zxy_angles};
use nalgebra::UnitQuaternion;
use std::fmt::Write as _;

/// A motion of ten frames in which nothing moves.
fn motion(header: &str, columns: &[(&str, f64)]) -> String {
    let mut text = format!("Coordinates\nnRows=10\n{header}\nendheader\ntime");
    for (name, _) in columns {
        let _ = write!(text, "\t{name}");
    }
    for i in 0..10 {
        let _ = write!(text, "\n{}", f64::from(i) / 50.0);
        for (_, value) in columns {
            let _ = write!(text, "\t{value}");
        }
    }
    text + "\n"
}

fn read_as(name: &str, text: &str, map: Option<&str>) -> Result<Recording, InputError> {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join(name);
    std::fs::write(&file, text).unwrap();
    let map_file = room.path().join("own.toml");
    let map = map.map(|map| {
        std::fs::write(&map_file, format!("schema = \"ergopath/map/1\"\n{map}")).unwrap();
        read_map(&map_file).unwrap()
    });
    read_with(&file, &Reading { map: map.as_ref(), ..Reading::default() })
}

fn mot(columns: &[(&str, f64)]) -> Recording {
    read_as("a.mot", &motion("inDegrees=yes", columns), None).unwrap()
}

fn told(error: Result<Recording, InputError>) -> String {
    let shown = format!("{:?}", miette::Report::new(error.unwrap_err())).replace(['\n', '│'], " ");
    shown.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn remark(recording: &Recording, about: &str) -> String {
    recording.remarks.iter().filter(|r| r.about == about).map(|r| r.text.clone()).collect()
}

const STANDING: [(&str, f64); 6] = [
    ("pelvis_tilt", 0.0),
    ("pelvis_list", 0.0),
    ("pelvis_rotation", 0.0),
    ("pelvis_tx", 0.2),
    ("pelvis_ty", 1.0),
    ("pelvis_tz", 0.1),
];

fn with(more: &[(&'static str, f64)]) -> Vec<(&'static str, f64)> {
    let mut all: Vec<(&str, f64)> =
        STANDING.iter().filter(|(n, _)| !more.iter().any(|(m, _)| m == n)).copied().collect();
    all.extend(more);
    all
}

/// Degrees about right, ahead and up from one segment to another in the first frame.
fn between(recording: &Recording, from: &str, to: &str) -> [f64; 3] {
    let turn = |name: &str| recording.segment(name).unwrap().rotation[0];
    zxy_angles(&(turn(from).inverse() * turn(to))).map(f64::to_degrees)
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-9, "{found:?} {expected:?}");
    }
}

const ARM: [(&str, f64); 5] = [
    ("arm_flex_r", 60.0),
    ("arm_add_r", -20.0),
    ("arm_rot_r", 10.0),
    ("elbow_flex_r", 0.0),
    ("pro_sup_r", 0.0),
];
const TRUNK: [(&str, f64); 3] =
    [("lumbar_extension", -30.0), ("lumbar_bending", 5.0), ("lumbar_rotation", 8.0)];

#[test]
fn coordinates_turn_segments_as_their_models_do() {
    let mut all = with(&TRUNK);
    all.extend(ARM);
    all.extend([("hip_flexion_r", 40.0), ("hip_adduction_r", 6.0), ("hip_rotation_r", -7.0)]);
    all.extend([("knee_angle_r", -50.0), ("hip_flexion_l", 20.0), ("knee_angle_l", -4.0)]);
    let r = mot(&all);
    assert_eq!((r.format, r.rate_hz, r.frames()), ("OpenSim", 50.0, 10));
    close(between(&r, "Pelvis", "T8"), [-30.0, 5.0, 8.0]);
    close(between(&r, "T8", "RightUpperArm"), [60.0, -20.0, 10.0]);
    close(between(&r, "Pelvis", "RightUpperLeg"), [40.0, 6.0, -7.0]);
    // A knee that bends turns backwards about the right.
    close(between(&r, "RightUpperLeg", "RightLowerLeg"), [-50.0, 0.0, 0.0]);
    close(between(&r, "LeftUpperLeg", "LeftLowerLeg"), [-4.0, 0.0, 0.0]);
    assert!(remark(&r, "counted").contains("from -50 to 0 deg"), "{}", remark(&r, "counted"));
    // The same person by a model that counts the other way.
    let other: Vec<(&str, f64)> =
        all.iter().map(|(n, v)| (*n, if n.starts_with("knee") { -v } else { *v })).collect();
    assert_eq!(mot(&other).segments, r.segments);
    // And in radians.
    let rad: Vec<(&str, f64)> = all
        .iter()
        .map(|(n, v)| (*n, if n.contains("_t") && n.len() == 9 { *v } else { v.to_radians() }))
        .collect();
    let rad = read_as("a.sto", &motion("inDegrees=no", &rad), None).unwrap();
    for (a, b) in rad.segments.iter().zip(&r.segments) {
        assert!(a.rotation[3].angle_to(&b.rotation[3]) < 1e-7, "{}", a.name);
    }
}

#[test]
fn the_vertical_of_opensim_is_y_and_both_sides_are_mirrored() {
    let r = mot(&with(&[
        ("pelvis_rotation", 90.0),
        ("hip_flexion_r", 10.0),
        ("hip_adduction_r", 12.0),
        ("hip_rotation_r", 14.0),
        ("hip_flexion_l", 10.0),
        ("hip_adduction_l", 12.0),
        ("hip_rotation_l", 14.0),
    ]));
    let pelvis = r.segment("Pelvis").unwrap();
    assert!((pelvis.rotation[0] * Vec3::y() - Vec3::z()).norm() < 1e-12);
    // Turned to the left by a quarter, where it faced x of the file, which is y here.
    assert!((pelvis.rotation[0] * Vec3::x() + Vec3::x()).norm() < 1e-12);
    let hips = pelvis.position[0];
    assert!((hips.z - (1.0 - 0.072)).abs() < 1e-12, "{hips}");
    let right = between(&r, "Pelvis", "RightUpperLeg");
    close(between(&r, "Pelvis", "LeftUpperLeg"), [right[0], -right[1], -right[2]]);
}

#[test]
fn places_are_those_of_the_body() {
    let mut all = with(&TRUNK);
    all.extend(ARM);
    let r = mot(&all);
    // They are not recorded.
    assert!(r.segment_lengths_m.is_empty());
    let forearm = |r: &Recording| {
        let at = |name: &str| r.segment(name).unwrap().position[0];
        (at("RightHand") - at("RightForeArm")).norm()
    };
    assert!((0.2..0.35).contains(&forearm(&r)), "{}", forearm(&r));
    let body = crate::human::Body::load("male_p50", "".as_ref()).unwrap();
    let other = {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("a.mot");
        std::fs::write(&file, motion("inDegrees=yes", &all)).unwrap();
        let body = crate::human::Body::load("female_p05", "".as_ref()).unwrap();
        read_with(&file, &Reading { body: Some(&body), ..Reading::default() }).unwrap()
    };
    assert!(forearm(&other) < forearm(&r) - 0.02);
    assert!(remark(&r, "lengths").contains(&body.name));
    assert!(remark(&other, "lengths").contains("female_p05"));
    // A trunk that bends 30 deg at several joints comes less far than one at a single joint.
    let (pelvis, thorax) = (r.segment("Pelvis").unwrap(), r.segment("T8").unwrap());
    let up = pelvis.rotation[0].inverse() * (thorax.position[0] - pelvis.position[0]);
    let lean = up.x.atan2(up.y).to_degrees();
    assert!((8.0..26.0).contains(&lean), "{lean}");
}

#[test]
fn what_is_not_there_is_told() {
    let mut all = with(&[("lumbar_extension", -30.0), ("knee_angle_r_beta", 3.0), ("fx", 1.0)]);
    all.extend(&ARM[..4]);
    let r = mot(&all);
    let unknown = remark(&r, "unknown turns");
    for expected in [
        "lumbar_bending, lumbar_rotation (T8: taken as zero)",
        "pro_sup_r (RightForeArm: taken as zero)",
        "wrist_flex_r, wrist_dev_r (RightHand: taken as in line",
    ] {
        assert!(unknown.contains(expected), "{unknown}");
    }
    let lost = remark(&r, "lost segments");
    assert!(lost.contains("LeftUpperArm, LeftForeArm, LeftHand"), "{lost}");
    assert!(lost.contains("RightUpperLeg"), "{lost}");
    let unused = remark(&r, "unused columns");
    assert!(unused.contains("2 columns") && unused.contains("knee_angle_r_beta, fx"), "{unused}");
    // An arm on a trunk that nobody told is left out.
    let r = mot(&with(&ARM));
    assert!(remark(&r, "lost segments").contains("T8, RightUpperArm, RightForeArm, RightHand"));
    // A pelvis that nobody placed.
    let placeless: Vec<(&str, f64)> = with(&[("pelvis_tilt", 9.0)])
        .into_iter()
        .filter(|(n, _)| !n.contains("_t") || n.len() > 9)
        .collect();
    let r = mot(&placeless);
    assert!(remark(&r, "unknown turns").contains("pelvis_tx, pelvis_ty, pelvis_tz"));
    // Forces are no posture.
    let error = told(read_as("f.mot", &motion("inDegrees=no", &[("ground_force_vx", 3.0)]), None));
    assert!(
        error.contains("nothing that the map `opensim` names") && error.contains("ground_force_vx"),
        "{error}"
    );
}

#[test]
fn doubtful_units_are_questions_that_a_map_answers() {
    let bent = with(&[("hip_flexion_r", 40.0), ("pelvis_ty", 1.0)]);
    let error = told(read_as("a.mot", &motion("inDegrees=no", &bent), None));
    for expected in ["line 6, column `hip_flexion_r`: 40", "2292 deg", "are they?", "angle_unit"] {
        assert!(error.contains(expected), "`{expected}` is missing in {error}");
    }
    let small = with(&[("hip_flexion_r", 0.7)]);
    let error = told(read_as("a.mot", &motion("inDegrees=yes", &small), None));
    assert!(
        error.contains("no angle is larger than 0.70") && error.contains("radians?"),
        "{error}"
    );
    let error = told(read_as("a.mot", &motion("version=1", &bent), None));
    assert!(error.contains("degrees or radians"), "{error}");
    let own = "[map]\nbase = \"opensim\"\nangle_unit = \"rad\"\n";
    let r = read_as("a.mot", &motion("inDegrees=yes", &small), Some(own)).unwrap();
    assert!((between(&r, "Pelvis", "RightUpperLeg")[0] - 0.7_f64.to_degrees()).abs() < 1e-9);
    assert!(remark(&r, "unit of angles").contains("in radians, as the map says"));
    let high = with(&[("hip_flexion_r", 40.0), ("pelvis_ty", 950.0)]);
    let error = told(read_as("a.mot", &motion("inDegrees=yes", &high), None));
    assert!(
        error.contains("`pelvis_ty`: a pelvis at 950 m") && error.contains("\"mm\""),
        "{error}"
    );
    let own = "[map]\nbase = \"opensim\"\nunit = \"mm\"\n";
    let r = read_as("a.mot", &motion("inDegrees=yes", &high), Some(own)).unwrap();
    assert!((r.segment("Pelvis").unwrap().position[0].z - 0.878).abs() < 1e-9);
}

#[test]
fn other_names_signs_and_offsets_are_told_by_a_map() {
    let own = r#"
[map]
base = "opensim"
[segment.RightUpperLeg]
turns = [{ by = "HipFlexR", about = "-right", offset_deg = 5 }, "HipAddR about ahead"]
"#;
    let all = with(&[("HipFlexR", -30.0), ("HipAddR", 4.0)]);
    let text = motion("inDegrees=yes", &all);
    let r = read_as("a.mot", &text, Some(own)).unwrap();
    // The offset is added to what the column says, before its direction.
    close(between(&r, "Pelvis", "RightUpperLeg"), [25.0, 4.0, 0.0]);
    let error = told(read_as("a.mot", &text.replace("HipAddR", "HipAbdR"), Some(own)));
    assert!(
        error.contains("no column `HipAddR`, by which own.toml tells RightUpperLeg")
            && error.contains("did you mean `HipAbdR`?"),
        "{error}"
    );
}

/// A wide table of poses of three segments, by one way to tell a turn.
fn poses(
    header: impl Fn(&str) -> String,
    cells: impl Fn(&UnitQuaternion<f64>) -> String,
) -> String {
    let mut text = String::from("time_s");
    for name in ["p", "t", "h"] {
        let _ = write!(text, ";{name}.x;{name}.y;{name}.z;{}", header(name));
    }
    for i in 0..20 {
        let _ = write!(text, "\n{}", f64::from(i) / 100.0);
        for (k, turn) in pose_turns(i).iter().enumerate() {
            let _ = write!(text, ";{};{};{};{}", 10 * i, 0, 900 + 300 * k, cells(turn));
        }
    }
    text + "\n"
}

fn pose_turns(i: i32) -> [UnitQuaternion<f64>; 3] {
    [0.0, 0.3, 0.5]
        .map(|by| UnitQuaternion::from_euler_angles(0.1, 0.2 * by, by + 0.01 * f64::from(i)))
}

fn pose_map(turn: &str) -> String {
    let mut text = String::from(
        "[map]\nup = \"z\"\nunit = \"mm\"\nangle_unit = \"deg\"\nplace = [\"{body}.x\", \"{body}.y\", \"{body}.z\"]\n",
    );
    for (segment, body) in [("Pelvis", "p"), ("T8", "t"), ("RightHand", "h")] {
        let _ = write!(
            text,
            "[segment.{segment}]\nbody = \"{body}\"\naxes = [\"-y\", \"z\", \"-x\"]\n{turn}\n"
        );
    }
    text
}

#[test]
fn poses_are_read_however_their_turns_are_told() {
    let by_quaternion = read_as(
        "a.csv",
        &poses(
            |b| format!("{b}.qx;{b}.qy;{b}.qz;{b}.qw"),
            |q| format!("{};{};{};{}", q.i, q.j, q.k, q.w),
        ),
        Some(&pose_map(r#"quaternion = ["{body}.qw", "{body}.qx", "{body}.qy", "{body}.qz"]"#)),
    )
    .unwrap();
    let r = &by_quaternion;
    assert_eq!((r.format, r.rate_hz, r.frames()), ("table of poses", 100.0, 20));
    let hand = r.segment("RightHand").unwrap();
    assert!((hand.position[7] - Vec3::new(0.07, 0.0, 1.5)).norm() < 1e-12);
    // The body's -y points ahead.
    assert!((hand.rotation[7] * Vec3::x() + pose_turns(7)[2] * Vec3::y()).norm() < 1e-12);
    let vector = read_as(
        "a.csv",
        &poses(
            |b| format!("{b}.rx;{b}.ry;{b}.rz"),
            |q| {
                let v = q.scaled_axis() * 1f64.to_degrees();
                format!("{};{};{}", v.x, v.y, v.z)
            },
        ),
        Some(&pose_map(r#"rotation_vector = ["{body}.rx", "{body}.ry", "{body}.rz"]"#)),
    )
    .unwrap();
    let euler = read_as(
        "a.csv",
        &poses(
            |b| format!("{b}.roll;{b}.pitch;{b}.yaw"),
            |q| {
                let (roll, pitch, yaw) = q.euler_angles();
                let [a, b, c] = [roll, pitch, yaw].map(f64::to_degrees);
                format!("{a};{b};{c}")
            },
        ),
        Some(&pose_map(
            r#"turns = ["{body}.yaw about z", "{body}.pitch about y", "{body}.roll about x"]"#,
        )),
    )
    .unwrap();
    for other in [&vector, &euler] {
        for (a, b) in other.segments.iter().zip(&r.segments) {
            assert_eq!(a.name, b.name);
            for i in 0..20 {
                assert!((a.position[i] - b.position[i]).norm() < 1e-9);
                assert!(a.rotation[i].angle_to(&b.rotation[i]) < 1e-7, "{}", a.name);
            }
        }
    }
}

#[test]
fn what_a_table_of_poses_lacks_is_told() {
    let text = poses(
        |b| format!("{b}.qx;{b}.qy;{b}.qz;{b}.qw"),
        |q| format!("{};{};{};{}", q.i, q.j, q.k, q.w),
    );
    let map = pose_map(r#"quaternion = ["{body}.qw", "{body}.qx", "{body}.qy", "{body}.qz"]"#);
    let said = |text: &str, map: &str| told(read_as("a.csv", text, Some(map)));
    for (text, map, expected) in [
        (text.replace("h.qw", "h.q"), map.clone(), "no column `h.qw`"),
        (text.replace("time_s", "n"), map.clone(), "does not say its rate"),
        (text.clone(), map.replace("unit = \"mm\"\nangle", "angle"), "does not say its unit"),
        (text.replacen(";900;", ";;", 1), map.clone(), "line 2, column `p.z`"),
        (
            text.replacen(";0.9987", ";0.5", 1),
            map.clone(),
            "row 1 (frame 0): the quaternion has norm",
        ),
    ] {
        let shown = said(&text, &map);
        assert!(shown.contains(expected), "`{expected}` is missing in {shown}");
    }
    // Nothing says what is up: the trunk does.
    let open = map.replace("up = \"z\"\n", "");
    let r = read_as("a.csv", &text, Some(&open)).unwrap();
    assert!(remark(&r, "vertical").contains("z is taken as up"));
    // Angles of a table need their unit.
    let turns = pose_map(r#"turns = ["{body}.qx about x"]"#).replace("angle_unit = \"deg\"\n", "");
    assert!(said(&text, &turns).contains("degrees or radians"));
    // Markers are no columns, and columns no markers.
    let error = told(read_as("a.trc", "x", Some(&map)));
    assert!(error.contains("holds markers, and the map tells columns"), "{error}");
    let points = "[segment.Pelvis]\njoint = \"a\"\nup = [\"a\", \"b\"]\nright = [\"a\", \"c\"]\n";
    let error = told(read_as("a.mot", "x", Some(points)));
    assert!(error.contains("holds no markers"), "{error}");
    assert_eq!(
        Map::shipped("rigid_body").unwrap_err().message(),
        "there is no shipped map of that name"
    );
}

//! Tests of the Acclaim reader on a made-up skeleton whose joint centres follow by hand.
//!
//! It stands in a T-pose with palms down, y up, facing +z, in units of a metre. The world of a
//! recording is (z, x, y) of that.

use super::*;
use crate::recording::zxy_angles;
use approx::assert_relative_eq;
use miette::Diagnostic as _;
use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::fs;

/// Name, parent, from end to end (m), angles of the axes (deg), axes of turning.
type Row = (&'static str, &'static str, [f64; 3], [f64; 3], &'static [usize]);
const XYZ: &[usize] = &[0, 1, 2];
const NONE: [f64; 3] = [0.0; 3];
const BONES: [Row; 28] = [
    ("lhipjoint", "root", [0.075, -0.1, 0.0], NONE, &[]),
    ("lfemur", "lhipjoint", [0.0, -0.4, 0.0], NONE, XYZ),
    ("ltibia", "lfemur", [0.0, -0.4, 0.0], NONE, &[0]),
    ("lfoot", "ltibia", [0.0, -0.05, 0.12], NONE, &[0, 2]),
    ("ltoes", "lfoot", [0.0, 0.0, 0.06], NONE, &[0]),
    ("rhipjoint", "root", [-0.075, -0.1, 0.0], NONE, &[]),
    ("rfemur", "rhipjoint", [0.0, -0.4, 0.0], NONE, XYZ),
    ("rtibia", "rfemur", [0.0, -0.4, 0.0], NONE, &[0]),
    ("rfoot", "rtibia", [0.0, -0.05, 0.12], NONE, &[0, 2]),
    ("rtoes", "rfoot", [0.0, 0.0, 0.06], NONE, &[0]),
    ("lowerback", "root", [0.0, 0.12, 0.0], NONE, XYZ),
    ("upperback", "lowerback", [0.0, 0.12, 0.0], NONE, XYZ),
    ("thorax", "upperback", [0.0, 0.12, 0.0], NONE, XYZ),
    ("lowerneck", "thorax", [0.0, 0.05, 0.0], NONE, XYZ),
    ("upperneck", "lowerneck", [0.0, 0.05, 0.0], NONE, XYZ),
    ("head", "upperneck", [0.0, 0.1, 0.0], NONE, XYZ),
    ("lclavicle", "thorax", [0.15, 0.0, 0.0], NONE, &[1, 2]),
    ("lhumerus", "lclavicle", [0.3, 0.0, 0.0], NONE, XYZ),
    ("lradius", "lhumerus", [0.2, 0.0, 0.0], [0.0, 0.0, -90.0], &[0]),
    ("lwrist", "lradius", [0.05, 0.0, 0.0], [0.0, 0.0, 90.0], &[1]),
    ("lhand", "lwrist", [0.08, 0.0, 0.0], NONE, &[0, 2]),
    ("lthumb", "lwrist", [0.06, 0.0, 0.06], NONE, &[]),
    ("rclavicle", "thorax", [-0.15, 0.0, 0.0], NONE, &[1, 2]),
    ("rhumerus", "rclavicle", [-0.3, 0.0, 0.0], NONE, XYZ),
    ("rradius", "rhumerus", [-0.2, 0.0, 0.0], [0.0, 0.0, 90.0], &[0]),
    ("rwrist", "rradius", [-0.05, 0.0, 0.0], [0.0, 0.0, -90.0], &[1]),
    ("rhand", "rwrist", [-0.08, 0.0, 0.0], NONE, &[0, 2]),
    ("rthumb", "rwrist", [-0.06, 0.0, 0.06], NONE, &[]),
];

/// The skeleton with its axes moved on by `shift` (0: y up), lengths over `unit_m`, in degrees or not.
fn asf(shift: usize, unit_m: f64, is_degrees: bool) -> String {
    let name = |axis: &usize| ["x", "y", "z"][(axis + shift) % 3];
    let words = |v: [f64; 3]| {
        let moved = [0, 1, 2].map(|i| v[(i + 3 - shift) % 3].to_string());
        moved.join(" ")
    };
    let order: String = [0, 1, 2].iter().map(name).collect::<String>().to_uppercase();
    let values =
        |letter: &str| [0, 1, 2].map(|a| format!("{letter}{}", name(&a).to_uppercase())).join(" ");
    let scale = if is_degrees { 1.0 } else { 1_f64.to_radians() };
    let mut text = format!(
        "# made up\n:version 1.10\n:name Secret Name\n:units\n  mass 1.0\n  length {}\n  angle {}\n\
         :documentation\n  Secret Name\n:root\n  order {} {}\n  axis {order}\n  position 0 0 0\n  \
         orientation 0 0 0\n:bonedata\n",
        0.0254 / unit_m,
        if is_degrees { "deg" } else { "rad" },
        values("T"),
        values("R"),
    );
    let mut links = String::new();
    for (i, (bone, parent, along, axis, dof)) in BONES.iter().enumerate() {
        let length = Vec3::from(*along).norm();
        let _ = write!(
            text,
            "  begin\n  id {i}\n  name {bone}\n  direction {}\n  length {}\n  axis {} {order}\n",
            words(along.map(|v| v / length)),
            length / unit_m,
            words(axis.map(|v| v * scale)),
        );
        if !dof.is_empty() {
            let dof: Vec<String> = dof.iter().map(|a| format!("r{}", name(a))).collect();
            let _ = write!(text, "  dof {}\n  limits (-1 1)\n  (-2 2)\n", dof.join(" "));
        }
        text += "  end\n";
        let _ = writeln!(links, "  {parent} {bone}");
    }
    text + ":hierarchy\n  begin\n" + &links + "  end\n"
}

/// A frame for each list of bones with values; what is not listed rests. The root stands at 1 m.
fn amc(frames: &[&[(&str, &str)]]) -> String {
    let mut text = "#!from somewhere\n:FULLY-SPECIFIED\n:DEGREES\n".to_owned();
    for (i, given) in frames.iter().enumerate() {
        let of = |name: &str| given.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
        let root = of("root").unwrap_or("0 1 0 0 0 0");
        let _ = write!(text, "{}\nroot {root}\n", i + 1);
        for (bone, .., dof) in BONES.iter().filter(|r| !r.4.is_empty()) {
            let rest = vec!["0"; dof.len()].join(" ");
            let _ = writeln!(text, "{bone} {}", of(bone).unwrap_or(&rest));
        }
    }
    text
}

fn load(asf: &str, amc: &str) -> Result<Recording, InputError> {
    let room = tempfile::tempdir().unwrap();
    fs::write(room.path().join("a.asf"), asf).unwrap();
    fs::write(room.path().join("a_b_120.amc"), amc).unwrap();
    read(&room.path().join("a_b_120.amc"))
}

/// The made-up person in one posture.
fn posed(given: &[(&str, &str)]) -> Recording {
    load(&asf(0, 1.0, true), &amc(&[given])).unwrap()
}

fn assert_at(r: &Recording, segment: &str, wanted: [f64; 3]) {
    let found = r.segment(segment).unwrap().position[0];
    assert!((found - Vec3::from(wanted)).norm() < 1e-9, "{segment}: {found:?}, not {wanted:?}");
}

/// ZXY angles (deg) of a child segment in its parent.
fn assert_angles(r: &Recording, parent: &str, child: &str, wanted: [f64; 3]) {
    let [p, c] = [parent, child].map(|n| r.segment(n).unwrap().rotation[0]);
    let found = zxy_angles(&(p.inverse() * c)).map(f64::to_degrees);
    let gap = (Vec3::from(found) - Vec3::from(wanted)).norm();
    assert!(gap < 1e-5, "{child} in {parent}: {found:?}, not {wanted:?}");
}

#[test]
fn the_rest_pose_is_a_t_pose_with_palms_down() {
    let r = posed(&[]);
    assert_eq!((r.frames(), r.rate_hz, r.source.as_str()), (1, 120.0, "a_b_120.amc"));
    let names: Vec<&str> = r.segments.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, crate::recording::SEGMENT_NAMES);
    let pelvis = r.segment("Pelvis").unwrap().rotation[0];
    assert_relative_eq!(pelvis * Vec3::x(), Vec3::x(), epsilon = 1e-12);
    assert_relative_eq!(pelvis * Vec3::y(), Vec3::z(), epsilon = 1e-12);
    for (segment, place) in [
        ("Pelvis", [0.0, 0.0, 0.9]),
        ("L5", [0.0, 0.0, 1.0]),
        ("L3", [0.0, 0.0, 1.08]),
        ("T12", [0.0, 0.0, 1.16]),
        ("T8", [0.0, 0.0, 1.24]),
        ("Neck", [0.0, 0.0, 1.36]),
        ("Head", [0.0, 0.0, 1.46]),
        ("RightUpperArm", [0.0, -0.15, 1.36]),
        ("RightForeArm", [0.0, -0.45, 1.36]),
        ("RightHand", [0.0, -0.7, 1.36]),
        ("LeftHand", [0.0, 0.7, 1.36]),
        ("RightUpperLeg", [0.0, -0.075, 0.9]),
        ("LeftLowerLeg", [0.0, 0.075, 0.5]),
        ("LeftFoot", [0.0, 0.075, 0.1]),
        ("RightToe", [0.12, -0.075, 0.05]),
    ] {
        assert_at(&r, segment, place);
    }
    for segment in ["T8", "Head", "LeftShoulder", "RightUpperLeg", "LeftLowerLeg", "LeftToe"] {
        assert_angles(&r, "Pelvis", segment, [0.0; 3]);
    }
    for (side, sign) in [("Right", 1.0), ("Left", -1.0)] {
        let part = |name: &str| format!("{side}{name}");
        let [shoulder, upper, fore] = ["Shoulder", "UpperArm", "ForeArm"].map(part);
        // Abducted by 90 degrees about x, where the split into angles is singular.
        let [p, c] = [&shoulder, &upper].map(|n| r.segment(n).unwrap().rotation[0]);
        let abducted = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), -sign * FRAC_PI_2);
        assert_relative_eq!((p.inverse() * c).angle_to(&abducted), 0.0, epsilon = 1e-7);
        assert_angles(&r, &upper, &fore, [0.0, 0.0, 90.0 * sign]);
        assert_angles(&r, &fore, &part("Hand"), [0.0; 3]);
    }
    for (name, wanted) in [
        ("RightUpperArm", 0.3),
        ("RightForeArm", 0.25),
        ("LeftLowerLeg", 0.4),
        ("ShoulderToShoulder", 0.3),
        ("HipToHip", 0.15),
        ("T8", 0.12),
    ] {
        assert_relative_eq!(r.length_m(name).unwrap(), wanted, epsilon = 1e-9);
    }
    assert!(!format!("{r:?}").contains("Secret"));
    assert!(
        r.remarks.iter().any(|n| n.text.contains("collar bones stand still")),
        "{:?}",
        r.remarks
    );
    assert!(posed(&[("lclavicle", "0 5")]).remarks.iter().all(|n| !n.text.contains("stand still")));
}

#[test]
fn bent_joints_are_where_they_belong() {
    let r = posed(&[("rtibia", "90"), ("lfemur", "-90 0 0")]);
    assert_at(&r, "RightFoot", [-0.4, -0.075, 0.5]);
    assert_angles(&r, "RightUpperLeg", "RightLowerLeg", [-90.0, 0.0, 0.0]);
    assert_at(&r, "LeftLowerLeg", [0.4, 0.075, 0.9]);
    assert_angles(&r, "Pelvis", "LeftUpperLeg", [90.0, 0.0, 0.0]);
    let r = posed(&[("rradius", "90"), ("lradius", "60"), ("lwrist", "90")]);
    assert_at(&r, "RightHand", [0.25, -0.45, 1.36]);
    assert_angles(&r, "RightUpperArm", "RightForeArm", [90.0, 0.0, 90.0]);
    assert_at(&r, "LeftHand", [0.25 * 0.75_f64.sqrt(), 0.45 + 0.125, 1.36]);
    assert_angles(&r, "LeftUpperArm", "LeftForeArm", [60.0, 0.0, 0.0]);
    // Arms that hang: the pose is the anatomical zero but for the palms.
    let r = posed(&[("rhumerus", "0 0 90"), ("lhumerus", "0 0 -90"), ("rwrist", "-90")]);
    assert_at(&r, "RightHand", [0.0, -0.15, 0.81]);
    assert_angles(&r, "Pelvis", "RightHand", [0.0; 3]);
    assert_angles(&r, "Pelvis", "LeftHand", [0.0, 0.0, -90.0]);
    // The root turns about itself: facing left, its place given.
    let r = posed(&[("root", "0.5 1 0.2 0 90 0")]);
    assert_at(&r, "RightFoot", [0.2 + 0.075, 0.5, 0.1]);
}

#[test]
fn the_spine_bends_where_its_joints_are() {
    let r = posed(&[("upperback", "30 0 0"), ("upperneck", "20 0 0")]);
    for (segment, bend) in [("L5", 0.0), ("L3", -15.0), ("T12", -30.0), ("T8", -30.0)] {
        assert_angles(&r, "Pelvis", segment, [bend, 0.0, 0.0]);
    }
    assert_angles(&r, "T8", "Neck", [-10.0, 0.0, 0.0]);
    assert_angles(&r, "T8", "Head", [-20.0, 0.0, 0.0]);
    // L3 is the chord of a bend between its ends, along its own axis.
    let [l3, t12] = ["L3", "T12"].map(|n| r.segment(n).unwrap());
    let chord = l3.rotation[0].inverse() * (t12.position[0] - l3.position[0]);
    assert_relative_eq!(chord, Vec3::y() * 0.08 * 15_f64.to_radians().cos(), epsilon = 1e-9);
}

#[test]
fn limbs_that_are_askew_at_rest_were_swung_there() {
    let skew = asf(0, 1.0, true)
        .replace("name lfemur\n  direction 0 -1 0", "name lfemur\n  direction 0.5 -0.866025404 0")
        .replace("name ltibia\n  direction 0 -1 0", "name ltibia\n  direction 0.5 -0.866025404 0")
        .replace(
            "length 0.4\n  axis 0 0 0 XYZ\n  dof rx\n",
            "length 0.4\n  axis 0 0 30 XYZ\n  dof rx\n",
        );
    // The hinge of an elbow tells how the upper arm is turned about itself: here by 25 degrees.
    let skew = skew.replace("length 0.2\n  axis 0 0 90 XYZ", "length 0.2\n  axis 0 25 90 XYZ");
    let r = load(&skew, &amc(&[&[("ltibia", "40"), ("rradius", "50")]])).unwrap();
    assert_angles(&r, "Pelvis", "LeftUpperLeg", [0.0, 30.0, 0.0]);
    assert_angles(&r, "LeftUpperLeg", "LeftLowerLeg", [-40.0, 0.0, 0.0]);
    let [z, x, y] = {
        let [p, c] = ["RightShoulder", "RightUpperArm"].map(|n| r.segment(n).unwrap().rotation[0]);
        let turn = p.inverse() * c;
        let axis = turn * Vec3::y();
        assert_relative_eq!(axis, -Vec3::z(), epsilon = 1e-9);
        let hinge = turn * Vec3::z();
        [hinge.z, hinge.x.abs(), hinge.y]
    };
    assert_relative_eq!(z, 0.0, epsilon = 1e-9);
    assert_relative_eq!(x, 25_f64.to_radians().sin(), epsilon = 1e-9);
    assert_relative_eq!(y, 25_f64.to_radians().cos(), epsilon = 1e-9);
    let [p, c] = ["RightUpperArm", "RightForeArm"].map(|n| r.segment(n).unwrap().rotation[0]);
    let [z, x, _] = zxy_angles(&(p.inverse() * c)).map(f64::to_degrees);
    assert_relative_eq!(z, 50.0, epsilon = 1e-5);
    assert_relative_eq!(x, 0.0, epsilon = 1e-5);
}

#[test]
fn turns_are_done_in_the_order_in_which_they_are_listed() {
    let skeleton = asf(0, 1.0, true);
    let arm = &amc(&[&[("rhumerus", "90 90 0")]]);
    assert_at(&load(&skeleton, arm).unwrap(), "RightForeArm", [0.3, -0.15, 1.36]);
    let (before, after) = skeleton.split_once("name rhumerus").unwrap();
    let swapped = format!("{before}name rhumerus{}", after.replacen("rx ry rz", "ry rx rz", 1));
    assert_at(&load(&swapped, arm).unwrap(), "RightForeArm", [0.0, -0.15, 1.06]);

    let root = &amc(&[&[("root", "0 1 0 90 90 0")]]);
    assert_at(&load(&skeleton, root).unwrap(), "Head", [0.0, 0.46, 1.0]);
    let swapped = skeleton.replace("RX RY RZ", "RY RX RZ");
    assert_at(&load(&swapped, root).unwrap(), "Head", [0.46, 0.0, 1.0]);
    let moved = skeleton.replace("TX TY TZ RX RY RZ", "RZ RY RX TZ TY TX");
    let root = &amc(&[&[("root", "0 90 0 0.2 1 0.5")]]);
    assert_at(&load(&moved, root).unwrap(), "RightFoot", [0.2 + 0.075, 0.5, 0.1]);

    // The axis of a joint: about -z where x goes first, about y where y does.
    let knee = &amc(&[&[("rtibia", "90")]]);
    let (before, after) = skeleton.split_once("name rtibia").unwrap();
    for (order, place) in [("XYZ", [0.0, -0.475, 0.5]), ("YXZ", [0.0, -0.075, 0.1])] {
        let after = after.replacen("axis 0 0 0 XYZ", &format!("axis 90 90 0 {order}"), 1);
        assert_at(&load(&format!("{before}name rtibia{after}"), knee).unwrap(), "RightFoot", place);
    }
}

#[test]
fn units_and_the_vertical_do_not_matter() {
    let angles = [("rhumerus", "10 20 30"), ("lwrist", "40"), ("upperback", "5 6 7")];
    let wanted = posed(&[&angles[..], &[("root", "0.1 1 0.2 10 20 30")]].concat());
    for (shift, unit_m, is_degrees) in [(1, 1.0, true), (2, 0.5, true), (0, 0.0254 / 0.45, false)] {
        let place = [0.1, 1.0, 0.2].map(|v| (v / unit_m).to_string()).join(" ");
        let root = format!("{place} 10 20 30");
        let text = amc(&[&[&angles[..], &[("root", root.as_str())]].concat()]);
        let found = load(&asf(shift, unit_m, is_degrees), &text).unwrap();
        for (a, b) in found.segments.iter().zip(&wanted.segments) {
            assert_relative_eq!(a.position[0], b.position[0], epsilon = 1e-9);
            assert_relative_eq!(a.rotation[0].angle_to(&b.rotation[0]), 0.0, epsilon = 1e-6);
        }
    }
    let radians = amc(&[&[("rtibia", "1.5707963267948966")]]).replace(":DEGREES", ":RADIANS");
    let r = load(&asf(0, 1.0, true), &radians).unwrap();
    assert_at(&r, "RightFoot", [-0.4, -0.075, 0.5]);
    let unsaid = radians.replace(":RADIANS\n", "");
    assert_eq!(load(&asf(0, 1.0, false), &unsaid).unwrap().segments, r.segments);
}

mod real;
mod refusals;

/// A leg turned half round about its thigh, whose knee bends as much the other way, is one posture.
#[test]
fn a_leg_that_was_solved_half_a_turn_round_is_turned_back() {
    let usual = posed(&[("lfemur", "-90 0 0"), ("ltibia", "120")]);
    let turned = posed(&[("lfemur", "-90 0 180"), ("ltibia", "240")]);
    let told =
        |r: &Recording| r.remarks.iter().any(|n| n.text.contains("left knee bends forwards in 1"));
    assert!(!told(&usual) && told(&turned), "{:?}", turned.remarks);
    for (a, b) in usual.segments.iter().zip(&turned.segments) {
        // A foot follows its shank in the file, and the toes the foot.
        let is_after = a.name == "LeftToe";
        assert!(is_after || (a.position[0] - b.position[0]).norm() < 1e-9, "{}", a.name);
        let is_leg = a.name == "LeftUpperLeg" || a.name == "LeftLowerLeg";
        assert!(!is_leg || a.rotation[0].angle_to(&b.rotation[0]) < 1e-9, "{}", a.name);
    }
}

//! Tests of the BVH reader on a made-up skeleton whose joint centres follow by hand.
//!
//! It stands in a T-pose, y up, facing +z, x to its left, in units of a metre. The world of a recording
//! is (z, x, y) of that.

use super::*;
use crate::recording::zxy_angles;
use approx::assert_relative_eq;
use miette::Diagnostic as _;
use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::fs;

/// Name, parent and offset (m) of a joint; an end has no name.
type Row = (String, String, [f64; 3]);

/// The joints of the made-up skeleton.
fn rows() -> Vec<Row> {
    let mut rows: Vec<(&str, &str, [f64; 3])> = vec![
        ("Hips", "", [0.0, 0.0, 0.0]),
        ("Spine", "Hips", [0.0, 0.1, 0.0]),
        ("Spine1", "Spine", [0.0, 0.12, 0.0]),
        ("Spine2", "Spine1", [0.0, 0.12, 0.0]),
        ("Neck", "Spine2", [0.0, 0.2, 0.0]),
        ("Head", "Neck", [0.0, 0.1, 0.0]),
        ("", "Head", [0.0, 0.15, 0.0]),
    ];
    let limbs = [
        ("Shoulder", "Spine2", [0.03, 0.15, 0.0]),
        ("Arm", "Shoulder", [0.13, 0.0, 0.0]),
        ("ForeArm", "Arm", [0.3, 0.0, 0.0]),
        ("Hand", "ForeArm", [0.25, 0.0, 0.0]),
        ("", "Hand", [0.08, 0.0, 0.0]),
        ("UpLeg", "Hips", [0.09, -0.02, 0.0]),
        ("Leg", "UpLeg", [0.0, -0.42, 0.0]),
        ("Foot", "Leg", [0.0, -0.42, 0.0]),
        ("ToeBase", "Foot", [0.0, -0.06, 0.14]),
        ("", "ToeBase", [0.0, 0.0, 0.06]),
    ];
    let mut all: Vec<Row> =
        rows.drain(..).map(|(n, p, o)| (n.to_owned(), p.to_owned(), o)).collect();
    for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
        for (name, parent, [x, y, z]) in limbs {
            let on_trunk = matches!(parent, "Hips" | "Spine2");
            let parent = if on_trunk { parent.to_owned() } else { format!("{side}{parent}") };
            let name = if name.is_empty() { String::new() } else { format!("{side}{name}") };
            all.push((name, parent, [sign * x, y, z]));
        }
    }
    all
}

/// How the skeleton is written.
struct Style {
    rows: Vec<Row>,
    /// The file's axes are moved on by this (0: y up).
    shift: usize,
    unit_m: f64,
    /// Order of the turns.
    order: [usize; 3],
    /// Whether all joints have places of their own in a frame, not only the root.
    moves_all: bool,
}

impl Default for Style {
    fn default() -> Self {
        Self { rows: rows(), shift: 0, unit_m: 0.01, order: [2, 0, 1], moves_all: false }
    }
}

impl Style {
    /// The same with the joints that a function gives other names, without those that it gives none.
    fn named(mut self, name: impl Fn(&str) -> Option<String>) -> Self {
        let new = |old: &String| if old.is_empty() { Some(String::new()) } else { name(old) };
        self.rows.retain(|(name, parent, _)| new(name).is_some() && new(parent).is_some());
        for (name, parent, _) in &mut self.rows {
            (*name, *parent) = (new(name).unwrap(), new(parent).unwrap());
        }
        self
    }

    fn offset(mut self, name: &str, offset: [f64; 3]) -> Self {
        self.rows.iter_mut().find(|r| r.0 == name).unwrap().2 = offset;
        self
    }

    fn with(mut self, name: &str, parent: &str, offset: [f64; 3]) -> Self {
        self.rows.push((name.to_owned(), parent.to_owned(), offset));
        self
    }

    fn letter(&self, axis: usize) -> &'static str {
        ["X", "Y", "Z"][(axis + self.shift) % 3]
    }

    fn moves(&self, row: &Row) -> bool {
        self.moves_all || row.1.is_empty()
    }

    fn words(&self, v: [f64; 3]) -> String {
        [0, 1, 2].map(|i| (v[(i + 3 - self.shift) % 3] / self.unit_m).to_string()).join(" ")
    }

    /// A joint with all that hangs on it; their places in the list are noted in the order written.
    fn joint(&self, i: usize, text: &mut String, written: &mut Vec<usize>) {
        let row = &self.rows[i];
        let head = match (row.0.as_str(), row.1.as_str()) {
            ("", _) => "End Site".to_owned(),
            (name, "") => format!("ROOT {name}"),
            (name, _) => format!("JOINT {name}"),
        };
        let _ = writeln!(text, "{head}\n{{\n  OFFSET {}", self.words(row.2));
        if !row.0.is_empty() {
            let place = if self.moves(row) { "Xposition Yposition Zposition " } else { "" };
            let turns = self.order.map(|a| format!("{}rotation", self.letter(a))).join(" ");
            let count = if self.moves(row) { 6 } else { 3 };
            let _ = writeln!(text, "  CHANNELS {count} {place}{turns}");
            written.push(i);
            for (k, child) in self.rows.iter().enumerate() {
                if !child.1.is_empty() && child.1 == row.0 {
                    self.joint(k, text, written);
                }
            }
        }
        *text += "}\n";
    }

    /// A file with a frame for each list of joints and their turns (deg) about x, y, z, and the place of
    /// the root (m) under its own name with a colon; what is not listed rests.
    fn text(&self, frames: &[&[(&str, [f64; 3])]]) -> String {
        let mut text = "HIERARCHY\n".to_owned();
        let mut written = Vec::new();
        self.joint(0, &mut text, &mut written);
        let _ = write!(text, "MOTION\nFrames: {}\nFrame Time: 0.008333\n", frames.len());
        for given in frames {
            let of = |name: &str| given.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
            let mut words = Vec::new();
            for row in written.iter().map(|i| &self.rows[*i]) {
                if self.moves(row) {
                    words.push(self.words(of(&format!("{}:", row.0)).unwrap_or(row.2)));
                }
                let turns = of(&row.0).unwrap_or_default();
                words.extend(self.order.map(|a| turns[a].to_string()));
            }
            let _ = writeln!(text, "{}", words.join(" "));
        }
        text
    }

    /// The person in one posture.
    fn posed(&self, given: &[(&str, [f64; 3])]) -> Recording {
        load(&self.text(&[given])).unwrap()
    }
}

fn load(text: &str) -> Result<Recording, InputError> {
    let room = tempfile::tempdir().unwrap();
    fs::write(room.path().join("a.bvh"), text).unwrap();
    read(&room.path().join("a.bvh"))
}

fn posed(given: &[(&str, [f64; 3])]) -> Recording {
    Style::default().posed(given)
}

fn assert_at(r: &Recording, segment: &str, wanted: [f64; 3]) {
    let found = r.segment(segment).unwrap().position[0];
    assert!((found - Vec3::from(wanted)).norm() < 1e-9, "{segment}: {found:?}, not {wanted:?}");
}

/// Turn of a child segment in its parent.
fn turn(r: &Recording, parent: &str, child: &str) -> UnitQuaternion<f64> {
    let [p, c] = [parent, child].map(|n| r.segment(n).unwrap().rotation[0]);
    p.inverse() * c
}

/// ZXY angles (deg) of a child segment in its parent.
fn assert_angles(r: &Recording, parent: &str, child: &str, wanted: [f64; 3]) {
    let found = zxy_angles(&turn(r, parent, child)).map(f64::to_degrees);
    let gap = (Vec3::from(found) - Vec3::from(wanted)).norm();
    assert!(gap < 1e-5, "{child} in {parent}: {found:?}, not {wanted:?}");
}

fn says(r: &Recording, what: &str) -> bool {
    r.remarks.iter().any(|remark| remark.text.contains(what))
}

fn assert_same_poses(a: &Recording, b: &Recording) {
    assert_eq!(a.segments.len(), b.segments.len());
    for (a, b) in a.segments.iter().zip(&b.segments) {
        assert_eq!(a.name, b.name);
        for i in 0..a.position.len() {
            assert_relative_eq!(a.position[i], b.position[i], epsilon = 1e-9);
            assert_relative_eq!(a.rotation[i].angle_to(&b.rotation[i]), 0.0, epsilon = 1e-6);
        }
    }
}

/// What both kinds of rest pose hold when arms hang with palms inwards.
fn assert_hanging(r: &Recording) {
    for (side, sign) in [("Right", 1.0), ("Left", -1.0)] {
        let part = |name: &str| format!("{side}{name}");
        let [shoulder, upper, fore] = ["Shoulder", "UpperArm", "ForeArm"].map(part);
        assert_angles(r, &shoulder, &upper, [0.0; 3]);
        assert_angles(r, &upper, &fore, [0.0, 0.0, 90.0 * sign]);
        assert_angles(r, &fore, &part("Hand"), [0.0; 3]);
        assert_at(r, &part("Hand"), [0.0, -0.16 * sign, 0.49 - 0.55]);
    }
}

#[test]
fn a_zero_pose_may_be_a_t_pose_with_palms_down() {
    let r = posed(&[]);
    assert_eq!((r.frames(), r.rate_hz, r.format, r.source.as_str()), (1, 120.0, "BVH", "a.bvh"));
    let names: Vec<&str> = r.segments.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, SEGMENT_NAMES);
    let pelvis = r.segment("Pelvis").unwrap().rotation[0];
    assert_relative_eq!(pelvis * Vec3::x(), Vec3::x(), epsilon = 1e-12);
    assert_relative_eq!(pelvis * Vec3::y(), Vec3::z(), epsilon = 1e-12);
    for (segment, place) in [
        ("Pelvis", [0.0, 0.0, -0.02]),
        ("L5", [0.0, 0.0, 0.1]),
        ("L3", [0.0, 0.0, 0.18]),
        ("T12", [0.0, 0.0, 0.26]),
        ("T8", [0.0, 0.0, 0.34]),
        ("Neck", [0.0, 0.0, 0.54]),
        ("Head", [0.0, 0.0, 0.64]),
        ("RightUpperArm", [0.0, -0.16, 0.49]),
        ("RightForeArm", [0.0, -0.46, 0.49]),
        ("RightHand", [0.0, -0.71, 0.49]),
        ("LeftHand", [0.0, 0.71, 0.49]),
        ("RightUpperLeg", [0.0, -0.09, -0.02]),
        ("LeftFoot", [0.0, 0.09, -0.86]),
        ("RightToe", [0.14, -0.09, -0.92]),
    ] {
        assert_at(&r, segment, place);
    }
    for segment in ["L5", "T8", "Head", "LeftShoulder", "RightUpperLeg", "LeftLowerLeg", "LeftToe"]
    {
        assert_angles(&r, "Pelvis", segment, [0.0; 3]);
    }
    for (side, sign) in [("Right", 1.0), ("Left", -1.0)] {
        // Abducted by 90 degrees about x, where the split into angles is singular.
        let abducted = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), -sign * FRAC_PI_2);
        let arm = turn(&r, &format!("{side}Shoulder"), &format!("{side}UpperArm"));
        assert_relative_eq!(arm.angle_to(&abducted), 0.0, epsilon = 1e-7);
    }
    for (name, wanted) in [
        ("RightUpperArm", 0.3),
        ("RightForeArm", 0.25),
        ("LeftLowerLeg", 0.42),
        ("ShoulderToShoulder", 0.32),
        ("HipToHip", 0.18),
        ("T8", 0.2),
    ] {
        assert_relative_eq!(r.length_m(name).unwrap(), wanted, epsilon = 1e-9);
    }
    assert!(says(
        &r,
        "taken as cm, by the arms: from shoulder to wrist 0.55 m, from hip to ankle 0.84"
    ));
    assert!(says(&r, "arms sideways") && says(&r, "point forwards") && says(&r, "y is up"));
    assert!(says(&r, "collar bones stand still"), "{:?}", r.remarks);
    assert!(!says(&posed(&[("LeftShoulder", [0.0, 0.0, 5.0])]), "stand still"));
}

#[test]
fn arms_hang_alike_from_either_zero_pose() {
    let from_t_pose = posed(&[("LeftArm", [0.0, 0.0, -90.0]), ("RightArm", [0.0, 0.0, 90.0])]);
    assert_hanging(&from_t_pose);
    let mut style = Style::default();
    for row in &mut style.rows {
        if ["ForeArm", "Hand"].iter().any(|n| row.0.ends_with(n)) || row.1.ends_with("Hand") {
            row.2 = [0.0, -row.2[0].abs(), 0.0];
        }
    }
    let hanging = style.posed(&[]);
    assert_hanging(&hanging);
    assert!(says(&hanging, "arms hanging"), "{:?}", hanging.remarks);
}

/// Legs apart at zero, with the feet swung along, as in the CMU database.
#[test]
fn legs_that_are_apart_at_zero_were_swung_there() {
    let angle = 20_f64.to_radians();
    let mut style = Style::default();
    for row in &mut style.rows {
        let [x, y, z] = row.2;
        if ["Leg", "Foot", "ToeBase"]
            .iter()
            .any(|n| row.0.ends_with(n) && !row.0.ends_with("UpLeg"))
        {
            let out = if row.0.starts_with("Left") { angle } else { -angle };
            row.2 = [x * out.cos() - y * out.sin(), x * out.sin() + y * out.cos(), z];
        }
    }
    let r = style.posed(&[("LeftUpLeg", [0.0, 0.0, -20.0]), ("RightUpLeg", [0.0, 0.0, 20.0])]);
    for segment in ["UpperLeg", "LowerLeg", "Foot", "Toe"] {
        for side in ["Right", "Left"] {
            assert_angles(&r, "Pelvis", &format!("{side}{segment}"), [0.0; 3]);
        }
    }
    assert_at(&r, "LeftToe", [0.14, 0.09, -0.92]);
}

#[test]
fn bent_joints_are_where_they_belong() {
    let r = posed(&[("RightLeg", [90.0, 0.0, 0.0]), ("LeftUpLeg", [-90.0, 0.0, 0.0])]);
    assert_at(&r, "RightFoot", [-0.42, -0.09, -0.44]);
    assert_angles(&r, "RightUpperLeg", "RightLowerLeg", [-90.0, 0.0, 0.0]);
    assert_at(&r, "LeftLowerLeg", [0.42, 0.09, -0.02]);
    assert_angles(&r, "Pelvis", "LeftUpperLeg", [90.0, 0.0, 0.0]);
    // Elbows bend about the vertical in a T-pose with palms down.
    let r = posed(&[
        ("RightForeArm", [0.0, 90.0, 0.0]),
        ("LeftForeArm", [0.0, -60.0, 0.0]),
        ("LeftHand", [-20.0, 0.0, 0.0]),
    ]);
    assert_at(&r, "RightHand", [0.25, -0.46, 0.49]);
    assert_angles(&r, "RightUpperArm", "RightForeArm", [90.0, 0.0, 90.0]);
    assert_angles(&r, "LeftUpperArm", "LeftForeArm", [60.0, 0.0, -90.0]);
    assert_angles(&r, "LeftForeArm", "LeftHand", [0.0, 0.0, 20.0]);
    // The trunk bends in its middle joint: half of it at L3.
    let r = posed(&[("Spine1", [30.0, 0.0, 0.0]), ("Neck", [20.0, 0.0, 0.0])]);
    for (segment, bend) in [("L5", 0.0), ("L3", -15.0), ("T12", -30.0), ("T8", -30.0)] {
        assert_angles(&r, "Pelvis", segment, [bend, 0.0, 0.0]);
    }
    assert_angles(&r, "T8", "Head", [-20.0, 0.0, 0.0]);
    // The root turns about itself: facing left, its place given.
    let r = posed(&[("Hips", [0.0, 90.0, 0.0]), ("Hips:", [0.5, 1.0, 0.2])]);
    assert_at(&r, "RightFoot", [0.2 + 0.09, 0.5, 1.0 - 0.86]);
}

#[test]
fn turns_are_done_in_the_order_of_the_channels_from_the_last_on() {
    let arm: &[(&str, [f64; 3])] = &[("RightArm", [90.0, 90.0, 0.0])];
    for (order, place) in [
        ([0, 1, 2], [0.0, -0.16, 0.19]),
        ([1, 0, 2], [0.3, -0.16, 0.49]),
        ([2, 0, 1], [0.0, -0.16, 0.19]),
    ] {
        let style = Style { order, ..Style::default() };
        assert_at(&style.posed(arm), "RightForeArm", place);
    }
    // Turns before places, and a joint with one turn only.
    let text =
        Style::default().text(&[&[("Hips:", [0.5, 1.0, 0.2]), ("RightForeArm", [0.0, 90.0, 0.0])]]);
    let wanted = load(&text).unwrap();
    let text = text.replacen(
        "Xposition Yposition Zposition Zrotation Xrotation Yrotation",
        "Zrotation Xrotation Yrotation Zposition Yposition Xposition",
        1,
    );
    let text = text.replacen("\n50 100 20 0 0 0 ", "\n0 0 0 20 100 50 ", 1);
    let (head, tail) = text.split_once("JOINT RightForeArm").unwrap();
    let tail = tail.replacen("CHANNELS 3 Zrotation Xrotation Yrotation", "CHANNELS 1 Yrotation", 1);
    let tail = tail.replacen(" 0 0 90 ", " 90 ", 1);
    assert_same_poses(&load(&format!("{head}JOINT RightForeArm{tail}")).unwrap(), &wanted);
}

#[test]
fn units_and_the_vertical_do_not_matter() {
    let given: &[(&str, [f64; 3])] = &[
        ("Hips", [10.0, 0.0, 0.0]),
        ("Hips:", [0.1, 1.0, 0.2]),
        ("RightArm", [0.0, 0.0, 40.0]),
        ("LeftHand", [0.0, 30.0, 0.0]),
    ];
    let wanted = posed(given);
    for (shift, unit_m, unit, up) in [
        (0, 1.0, "as m,", "y is up"),
        (1, 0.001, "as mm,", "z is up"),
        (2, 0.0254, "as inches,", "x is up"),
        (1, 0.0254 / 0.45, "as inches over 0.45", "z is up"),
    ] {
        let r = Style { shift, unit_m, ..Style::default() }.posed(given);
        assert_same_poses(&r, &wanted);
        assert!(says(&r, unit) && says(&r, up), "{unit}, {up}: {:?}", r.remarks);
    }
    // The zero pose has y up, the movement z.
    let r = posed(&[("Hips", [90.0, 0.0, 0.0]), ("Hips:", [0.0, 0.0, 1.0])]);
    assert!(says(&r, "z is up in the movement, but y is up there"), "{:?}", r.remarks);
    assert_at(&r, "Head", [0.0, 0.0, 1.64]);
}

/// The same joints under the names of several programs.
#[test]
fn joints_are_known_by_the_names_of_many_programs() {
    let given = |name: &dyn Fn(&str) -> Option<String>| {
        let turns = [("LeftForeArm", [0.0, -60.0, 0.0]), ("RightLeg", [50.0, 0.0, 0.0])];
        let style = Style::default().named(name);
        let turns = turns.map(|(joint, turn)| (name(joint).unwrap(), turn));
        let turns: Vec<(&str, [f64; 3])> = turns.iter().map(|(n, t)| (n.as_str(), *t)).collect();
        style.posed(&turns)
    };
    let limbs = ["Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase"];
    let spine = ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head"];
    let programs: [(&str, [&str; 6], [&str; 8]); 6] = [
        (
            "{s}{n}",
            ["Hips", "Chest", "Chest2", "Chest3", "Neck", "Head"],
            ["Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Toe"],
        ),
        (
            "{s}{n}",
            ["Pelvis", "L5", "T12", "T8", "Neck", "Head"],
            ["Shoulder", "UpperArm", "ForeArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toe"],
        ),
        ("mixamorig:{s}{n}", spine, limbs),
        (
            "{n}_{i}",
            ["pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "head"],
            ["clavicle", "upperarm", "lowerarm", "hand", "thigh", "calf", "foot", "ball"],
        ),
        (
            "Bip01 {I} {n}",
            [
                "Bip01 Pelvis",
                "Bip01 Spine",
                "Bip01 Spine1",
                "Bip01 Spine2",
                "Bip01 Neck",
                "Bip01 Head",
            ],
            ["Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0"],
        ),
        (
            "{i}{n}",
            ["root", "lowerback", "upperback", "thorax", "lowerneck", "head"],
            ["clavicle", "humerus", "radius", "hand", "femur", "tibia", "foot", "toes"],
        ),
    ];
    let wanted = given(&|name| Some(name.to_owned()));
    for (pattern, trunk, names) in programs {
        let rename = |name: &str| {
            if let Some(i) = spine.iter().position(|n| *n == name) {
                return Some(trunk[i].to_owned());
            }
            let side = if name.starts_with("Left") { "Left" } else { "Right" };
            let i = limbs.iter().position(|n| name.strip_prefix(side) == Some(n)).unwrap();
            let initial = &side[..1];
            let pattern = pattern.replace("{s}", side).replace("{I}", initial);
            Some(pattern.replace("{i}", &initial.to_lowercase()).replace("{n}", names[i]))
        };
        assert_same_poses(&given(&rename), &wanted);
    }
}

#[test]
fn what_has_no_joint_is_left_out_and_said() {
    let without = |gone: &[&str]| {
        Style::default().named(|n| (!gone.iter().any(|g| n.contains(g))).then(|| n.to_owned()))
    };
    let upper = without(&["UpLeg", "Leg", "Foot", "Toe"]).posed(&[]);
    assert_eq!(upper.segments.len(), 15);
    assert!(says(&upper, "no joint for RightUpperLeg, RightLowerLeg"), "{:?}", upper.remarks);
    assert_at(&upper, "Pelvis", [0.0; 3]);
    assert!(upper.length_m("HipToHip").is_none());
    let bare = without(&["Neck", "Head", "Toe", "LeftHand"]);
    let cut = bare.posed(&[]);
    assert!(
        says(&cut, "no joint for Neck, Head, LeftForeArm, LeftHand, RightToe"),
        "{:?}",
        cut.remarks
    );
    let bare = bare.with("", "LeftForeArm", [0.25, 0.0, 0.0]).posed(&[]);
    assert!(
        says(&bare, "no joint for Neck, Head, LeftHand, RightToe, LeftToe"),
        "{:?}",
        bare.remarks
    );
    assert_angles(&bare, "Pelvis", "LeftFoot", [0.0; 3]);
    assert_relative_eq!(bare.length_m("RightForeArm").unwrap(), 0.25, epsilon = 1e-9);
}

#[test]
fn the_spine_may_have_any_number_of_joints() {
    let spine = |heights: &[f64]| {
        let mut style = Style::default();
        style.rows.retain(|r| !r.0.starts_with("Spine"));
        let mut before = ("Hips".to_owned(), 0.0);
        for (i, height) in heights.iter().enumerate() {
            let name = format!("Back{i}");
            style = style.with(&name, &before.0, [0.0, height - before.1, 0.0]);
            before = (name, *height);
        }
        for row in style.rows.iter_mut().filter(|r| r.1 == "Spine2") {
            row.1.clone_from(&before.0);
            row.2[1] += 0.34 - before.1;
        }
        style.posed(&[("Back0", [10.0, 0.0, 0.0])])
    };
    let names = |r: &Recording| {
        let trunk = r.segments.iter().map(|s| s.name.clone()).skip(1).take_while(|n| n != "Neck");
        trunk.collect::<Vec<_>>().join(" ")
    };
    for (heights, wanted) in [
        (&[0.2][..], "T8"),
        (&[0.1, 0.3], "L3 T8"),
        (&[0.1, 0.2, 0.3], "L5 L3 T12 T8"),
        (&[0.1, 0.2, 0.3, 0.34], "L5 L3 T12 T8"),
        (&[0.02, 0.1, 0.15, 0.2, 0.3, 0.34], "L5 L3 T12 T8"),
    ] {
        let r = spine(heights);
        assert_eq!(names(&r), wanted);
        assert_angles(&r, "Pelvis", "T8", [-10.0, 0.0, 0.0]);
    }
    // Nearest to 19, 39 and 57 % of 0.54 m.
    let r = spine(&[0.02, 0.1, 0.15, 0.2, 0.3, 0.34]);
    let place = |name: &str| r.segment(name).unwrap().position[0].z;
    for (name, along) in [("L5", 0.08), ("L3", 0.18), ("T12", 0.28), ("T8", 0.32)] {
        let wanted = 0.02 + along * 10_f64.to_radians().cos();
        assert_relative_eq!(place(name), wanted, epsilon = 1e-9);
    }
}

#[test]
fn a_first_frame_may_be_the_rest_pose_where_nobody_could_stand_in_zero() {
    // Legs ahead at zero, as on a chair.
    let mut style = Style::default();
    for side in ["Left", "Right"] {
        style = style
            .offset(&format!("{side}Leg"), [0.0, 0.0, 0.42])
            .offset(&format!("{side}Foot"), [0.0, 0.0, 0.42])
            .offset(&format!("{side}ToeBase"), [0.0, 0.14, 0.06]);
    }
    let down = [("LeftUpLeg", [90.0, 0.0, 0.0]), ("RightUpLeg", [90.0, 0.0, 0.0])];
    let bent = [&down[..], &[("LeftLeg", [30.0, 0.0, 0.0])]].concat();
    let r = load(&style.text(&[&down, &bent])).unwrap();
    let wanted = load(&Style::default().text(&[&[], &[("LeftLeg", [30.0, 0.0, 0.0])]])).unwrap();
    assert_same_poses(&r, &wanted);
    assert!(says(&r, "from the first frame, as nobody stands in the zero pose"), "{:?}", r.remarks);
    let error = load(&style.text(&[&[]])).unwrap_err();
    assert!(error.message().contains("leg does not stand upright in its zero pose"), "{error}");
    assert!(error.help().unwrap().to_string().contains("first frame"));
    // Bent elbows do not tell how forearms are turned.
    let bent = [&down[..], &[("LeftForeArm", [0.0, -60.0, 0.0])]].concat();
    assert!(load(&style.text(&[&bent])).is_err());
}

#[test]
fn a_rest_pose_before_the_movement_is_skipped() {
    let lap: &[(&str, [f64; 3])] =
        &[("LeftArm", [0.0, 0.0, -70.0]), ("RightArm", [0.0, 0.0, 70.0])];
    let r = load(&Style::default().text(&[&[], lap, lap])).unwrap();
    assert_eq!(r.frames(), 2);
    assert!(says(&r, "the first frame is the rest pose"), "{:?}", r.remarks);
    // A movement that begins there is kept, and so is a first frame that is no rest pose.
    let little: &[(&str, [f64; 3])] = &[("LeftArm", [0.0, 0.0, -5.0])];
    assert_eq!(load(&Style::default().text(&[&[], little, lap])).unwrap().frames(), 3);
    assert_eq!(load(&Style::default().text(&[lap, &[], &[]])).unwrap().frames(), 3);
    assert_eq!(load(&Style::default().text(&[&[], lap])).unwrap().frames(), 2);
}

#[test]
fn joints_with_places_of_their_own_are_there() {
    let style = Style { moves_all: true, ..Style::default() };
    let given: &[(&str, [f64; 3])] = &[("RightArm", [0.0, 0.0, 40.0]), ("Hips:", [0.0, 1.0, 0.0])];
    assert_same_poses(&style.posed(given), &posed(given));
    // The shoulder has come up by 2 cm.
    let raised = style.posed(&[("RightArm:", [-0.13, 0.02, 0.0])]);
    assert_at(&raised, "RightUpperArm", [0.0, -0.16, 0.51]);
    // Places that are all zero go on from the offsets.
    let zeros: Vec<(String, [f64; 3])> =
        rows().iter().map(|r| (format!("{}:", r.0), [0.0; 3])).collect();
    let zeros: Vec<(&str, [f64; 3])> = zeros.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    assert_same_poses(&style.posed(&zeros), &posed(&[]));
}

#[test]
fn thumbs_tell_quarter_turns_and_roll_joints_pronate() {
    let r = Style::default().with("RightHandThumb1", "RightHand", [-0.03, -0.03, 0.04]).posed(&[]);
    assert_angles(&r, "RightUpperArm", "RightForeArm", [0.0, 0.0, 90.0]);
    assert!(says(&r, "thumbs taken to point forwards"), "{:?}", r.remarks);
    // Palms ahead: the thumb points up, and the forearm is in its anatomical zero.
    let r = Style::default().with("RightHandThumb1", "RightHand", [-0.03, 0.04, 0.02]).posed(&[]);
    assert_angles(&r, "RightUpperArm", "RightForeArm", [0.0; 3]);
    assert_angles(&r, "RightForeArm", "RightHand", [0.0; 3]);
    assert_angles(&r, "LeftUpperArm", "LeftForeArm", [0.0, 0.0, -90.0]);
    assert!(says(&r, "the right thumb taken to point") && says(&r, "the left forwards"));

    let mut style = Style::default().with("RightForeArmRoll", "RightForeArm", [-0.1, 0.0, 0.0]);
    let hand = style.rows.iter_mut().find(|r| r.0 == "RightHand").unwrap();
    (hand.1, hand.2) = ("RightForeArmRoll".to_owned(), [-0.15, 0.0, 0.0]);
    let r = style.posed(&[("RightForeArmRoll", [-30.0, 0.0, 0.0])]);
    assert_angles(&r, "RightUpperArm", "RightForeArm", [0.0, 0.0, 60.0]);
    assert_angles(&r, "RightForeArm", "RightHand", [0.0; 3]);
    assert_relative_eq!(r.length_m("RightForeArm").unwrap(), 0.25, epsilon = 1e-9);
}

#[test]
fn nothing_of_a_persons_name_is_kept() {
    let style = Style::default().named(|name| Some(format!("Ann Smith:{name}")));
    let r = style.posed(&[("Ann Smith:LeftLeg", [20.0, 0.0, 0.0])]);
    assert_same_poses(&r, &posed(&[("LeftLeg", [20.0, 0.0, 0.0])]));
    assert!(!format!("{r:?}").contains("Smith"));
}

mod refusals;

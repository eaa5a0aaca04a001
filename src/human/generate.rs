//! Writes the URDF of a body of given size, and the file beside it for what URDF cannot hold.

use super::limits::{SumLimit, ranges, trunk_sums};
use super::proportions::{
    ANKLE_HEIGHT, BodySize, CLAVICLE_ROOT, HIP_HALF_BREADTH, MASS_FRACTIONS, NECK, Proportions,
    SPINE_ABOVE_HIP, proportions,
};
use crate::math::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

/// The two files of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyFiles {
    /// URDF text.
    pub urdf: String,
    /// TOML text with sizes and bounds on sums of joints.
    pub sheet: String,
}

/// What belongs to a body beside its URDF.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BodySheet {
    pub schema: String,
    pub name: String,
    pub size: BodySize,
    /// Hip joint centres above the floor, standing barefoot with straight legs.
    pub standing_pelvis_height_m: f64,
    /// Hip joint centres above the seat.
    pub seat_to_hip_m: f64,
    pub hand_length_m: f64,
    pub sum_limit: Vec<SumLimit>,
}

pub(super) const BODY_SCHEMA: &str = "ergopath/body/1";

/// One segment: how it hangs on its parent, and its extent for mass and shape.
struct Segment {
    name: String,
    parent: String,
    /// Xsens joint name.
    joint: String,
    /// Joint name without side, for the ranges.
    kind: &'static str,
    is_left: bool,
    /// Joint centre in the parent's frame, m.
    at: Vec3,
    /// From the joint centre to the far end, m.
    extent: Vec3,
    radius: f64,
}

/// Makes the files of a body.
///
/// # Errors
/// A sentence, when the size is implausible.
pub fn generate(name: &str, size: BodySize) -> Result<BodyFiles, String> {
    generate_with(name, size, &proportions(size.sex))
}

/// The same with other proportions than the mean of its sex.
pub(super) fn generate_with(
    name: &str,
    size: BodySize,
    p: &Proportions,
) -> Result<BodyFiles, String> {
    let size = size.check()?;
    let h = size.stature_m;
    let sheet = BodySheet {
        schema: BODY_SCHEMA.to_owned(),
        name: name.to_owned(),
        size,
        standing_pelvis_height_m: rounded(p.hip_height * h),
        // Sitting, the head is lower by what the legs no longer carry.
        seat_to_hip_m: rounded((p.hip_height - (1.0 - p.sitting_height)) * h),
        hand_length_m: rounded(p.hand * h),
        sum_limit: trunk_sums(),
    };
    let comment = "# Belongs to the URDF of the same name: sizes, and bounds on sums of joints.\n";
    let text = toml::to_string(&sheet).map_err(|e| e.to_string())?;
    Ok(BodyFiles { urdf: urdf(name, size, p), sheet: format!("{comment}{text}") })
}

/// To a tenth of a millimetre, so that the same size gives the same text everywhere.
fn rounded(x: f64) -> f64 {
    (x * 1e4).round() / 1e4
}

fn urdf(name: &str, size: BodySize, p: &Proportions) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    let _ = writeln!(
        out,
        "<!-- Digital human made by `ergopath body`: {}, stature {} m, mass {} kg.\n     \
         Licence MIT OR Apache-2.0. Proportions: ANSUR II means; ranges of motion: AAOS.\n     \
         ISB axes (x forward, y up, z right), joint order Z, X, Y; zero: standing, palms forward.\n     \
         Root link `Body` has z up; `Pelvis` lies between the hip joint centres. -->",
        size.sex, size.stature_m, size.mass_kg
    );
    let _ = writeln!(out, "<robot name=\"{name}\">");
    out.push_str("  <link name=\"Body\"/>\n");
    let breadth = Vec3::new(0.0, 0.0, HIP_HALF_BREADTH * size.stature_m);
    link(&mut out, "Pelvis", mass("Pelvis", size), &breadth, 0.06 * size.stature_m, true);
    fixed(&mut out, "jPelvis", "Body", "Pelvis", &Vec3::zeros(), [FRAC_PI_2, 0.0, 0.0]);
    for segment in segments(size, p) {
        spherical(&mut out, &segment);
        let Segment { name, extent, radius, .. } = &segment;
        link(&mut out, name, mass(name, size), extent, *radius, false);
    }
    for (side, turn) in [("Right", 0.0), ("Left", PI)] {
        let grip = format!("{side}Grip");
        let _ = writeln!(out, "  <link name=\"{grip}\"/>");
        let at = Vec3::new(0.0, -0.5 * p.hand * size.stature_m, 0.0);
        fixed(&mut out, &format!("j{grip}"), &format!("{side}Hand"), &grip, &at, [0.0, turn, 0.0]);
    }
    out.push_str("</robot>\n");
    out
}

fn mass(segment: &str, size: BodySize) -> f64 {
    let bare = segment.trim_start_matches("Right").trim_start_matches("Left");
    MASS_FRACTIONS.iter().find(|(n, _)| *n == bare).map_or(0.0, |(_, f)| f * size.mass_kg)
}

/// All segments but the pelvis, parents first.
fn segments(size: BodySize, p: &Proportions) -> Vec<Segment> {
    let mut all = trunk(size.stature_m, p);
    for side in ["Right", "Left"] {
        all.extend(limbs(size.stature_m, p, side));
    }
    all
}

fn trunk(h: f64, p: &Proportions) -> Vec<Segment> {
    let [l5, l3, t12, t8] = SPINE_ABOVE_HIP;
    let c7 = p.c7_height - p.hip_height;
    let segment =
        |name: &str, parent: &str, kind: &'static str, at: f64, up: f64, r: f64| Segment {
            name: name.to_owned(),
            parent: parent.to_owned(),
            joint: format!("j{kind}"),
            kind,
            is_left: false,
            at: Vec3::new(0.0, at * h, 0.0),
            extent: Vec3::new(0.0, up * h, 0.0),
            radius: r * h,
        };
    vec![
        segment("L5", "Pelvis", "L5S1", l5, l3 - l5, 0.06),
        segment("L3", "L5", "L4L3", l3 - l5, t12 - l3, 0.06),
        segment("T12", "L3", "L1T12", t12 - l3, t8 - t12, 0.065),
        segment("T8", "T12", "T9T8", t8 - t12, c7 - t8 - 0.03, 0.07),
        segment("Neck", "T8", "T1C7", c7 - t8, NECK, 0.03),
        segment("Head", "Neck", "C1Head", NECK, 1.0 - p.c7_height - NECK - 0.055, 0.055),
    ]
}

fn limbs(h: f64, p: &Proportions, side: &str) -> Vec<Segment> {
    let z = if side == "Right" { h } else { -h };
    let limb = |name: &str, parent: &str, kind: &'static str, at: [f64; 3], to: [f64; 3], r| {
        let is_trunk = parent == "T8" || parent == "Pelvis";
        Segment {
            name: format!("{side}{name}"),
            parent: if is_trunk { parent.to_owned() } else { format!("{side}{parent}") },
            joint: format!("j{side}{kind}"),
            kind,
            is_left: side == "Left",
            at: Vec3::new(at[0] * h, at[1] * h, at[2] * z),
            extent: Vec3::new(to[0] * h, to[1] * h, to[2] * z),
            radius: r * h,
        }
    };
    let girdle = p.shoulder_height - p.hip_height - SPINE_ABOVE_HIP[3];
    let clavicle = p.shoulder_half_breadth - CLAVICLE_ROOT;
    let hip = HIP_HALF_BREADTH;
    let thigh = p.hip_height - p.knee_height;
    let shank = p.knee_height - ANKLE_HEIGHT;
    // Heel a quarter of the foot behind the ankle, ball at 0.72 of its length.
    let ball = (0.72 - 0.25) * p.foot;
    let down = |length: f64| [0.0, -length, 0.0];
    let out = |length: f64| [0.0, 0.0, length];
    let (to_ball, to_toe) = ([ball, 0.018 - ANKLE_HEIGHT, 0.0], [0.28 * p.foot, 0.0, 0.0]);
    vec![
        limb("Shoulder", "T8", "C7Shoulder", [0.0, girdle, CLAVICLE_ROOT], out(clavicle), 0.025),
        limb("UpperArm", "Shoulder", "Shoulder", out(clavicle), down(p.upper_arm), 0.026),
        limb("ForeArm", "UpperArm", "Elbow", down(p.upper_arm), down(p.forearm), 0.022),
        limb("Hand", "ForeArm", "Wrist", down(p.forearm), down(0.8 * p.hand), 0.018),
        limb("UpperLeg", "Pelvis", "Hip", out(hip), down(thigh), 0.045),
        limb("LowerLeg", "UpperLeg", "Knee", down(thigh), down(shank), 0.032),
        limb("Foot", "LowerLeg", "Ankle", down(shank), to_ball, 0.018),
        limb("Toe", "Foot", "BallFoot", to_ball, to_toe, 0.012),
    ]
}

fn xyz(v: &Vec3) -> String {
    let [x, y, z] = [v.x, v.y, v.z].map(|c| rounded(c) + 0.0);
    format!("{x} {y} {z}")
}

/// A link with mass, the inertia of a solid cylinder, and a capsule: a cylinder with balls at its
/// ends, which every URDF reader understands. `centred` puts the middle at the origin.
fn link(out: &mut String, name: &str, mass: f64, extent: &Vec3, radius: f64, centred: bool) {
    let length = if centred { 2.0 } else { 1.0 } * extent.norm();
    let (from, to) = if centred { (-extent, *extent) } else { (Vec3::zeros(), *extent) };
    let middle = (from + to) * 0.5;
    let across = mass * (3.0 * radius * radius + length * length) / 12.0;
    let along = 0.5 * mass * radius * radius;
    let axis = extent.abs();
    let inertia = if axis.x > axis.y.max(axis.z) {
        [along, across, across]
    } else if axis.y > axis.z {
        [across, along, across]
    } else {
        [across, across, along]
    };
    // Roll and pitch that turn the cylinder's z axis onto the extent.
    let d = extent.normalize();
    let rpy = format!("{:.6} {:.6} 0", (-d.y).asin() + 0.0, d.x.atan2(d.z) + 0.0);
    let _ = writeln!(out, "  <link name=\"{name}\">");
    let _ = writeln!(
        out,
        "    <inertial><origin xyz=\"{}\"/><mass value=\"{:.4}\"/><inertia ixx=\"{:.6}\" ixy=\"0\" \
         ixz=\"0\" iyy=\"{:.6}\" iyz=\"0\" izz=\"{:.6}\"/></inertial>",
        xyz(&middle),
        mass,
        inertia[0],
        inertia[1],
        inertia[2]
    );
    let _ = writeln!(
        out,
        "    <collision><origin xyz=\"{}\" rpy=\"{rpy}\"/><geometry><cylinder radius=\"{}\" \
         length=\"{}\"/></geometry></collision>",
        xyz(&middle),
        rounded(radius),
        rounded(length)
    );
    for end in [from, to] {
        let _ = writeln!(
            out,
            "    <collision><origin xyz=\"{}\"/><geometry><sphere radius=\"{}\"/></geometry></collision>",
            xyz(&end),
            rounded(radius)
        );
    }
    out.push_str("  </link>\n");
}

fn fixed(out: &mut String, name: &str, parent: &str, child: &str, at: &Vec3, rpy: [f64; 3]) {
    let [r, p, y] = rpy;
    let _ = writeln!(
        out,
        "  <joint name=\"{name}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"{}\" rpy=\"{r} {p} {y}\"/></joint>",
        xyz(at)
    );
}

/// Three revolutes about Z, X and Y with two frames between.
fn spherical(out: &mut String, s: &Segment) {
    let limits = ranges(s.kind);
    let links =
        [s.parent.clone(), format!("{}_1", s.name), format!("{}_2", s.name), s.name.clone()];
    let axes = [("Z", "0 0 1"), ("X", "1 0 0"), ("Y", "0 1 0")];
    for (i, (axis, direction)) in axes.into_iter().enumerate() {
        // The left side mirrors rotations about X and Y.
        let (low, high) = limits[i];
        let (low, high) = if s.is_left && i > 0 { (-high, -low) } else { (low, high) };
        let at = if i == 0 { s.at } else { Vec3::zeros() };
        if i < 2 {
            let _ = writeln!(out, "  <link name=\"{}\"/>", links[i + 1]);
        }
        let _ = writeln!(
            out,
            "  <joint name=\"{}_{axis}\" type=\"revolute\"><parent link=\"{}\"/><child link=\"{}\"/>\
             <origin xyz=\"{}\"/><axis xyz=\"{direction}\"/><limit lower=\"{:.6}\" upper=\"{:.6}\" \
             velocity=\"20\" effort=\"200\"/></joint>",
            s.joint,
            links[i],
            links[i + 1],
            xyz(&at),
            low.to_radians() + 0.0,
            high.to_radians() + 0.0,
        );
    }
}

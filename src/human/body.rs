//! A body as the rest of the program uses it: model, sizes, limits, and where its pelvis stands.

use super::generate::{BODY_SCHEMA, BodySheet, generate, generate_with};
use super::limits::{PostureLimits, SumLimit, trunk_limit};
use super::pelvis::{PELVIS, REST, SEATED, on_moving_pelvis};
use super::proportions::{BodySize, Proportions, Sex, proportions};
use super::side::{Coupled, Pelvis, Side};
use super::workforce::POPULATION;
use crate::files::{InputError, Memo, is_formula, parse_toml, read_text, suggest};
use crate::kinematics::{Linkage, Model, Tip, parse_urdf};
use crate::math::pose::rotation_from_axes;
use crate::math::{Pose, Vec3};
use crate::physical::{HAND_M, JOINT_DEG, JOINT_RAD, LEG_OVER_STATURE, SEAT_TO_HIP_M};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The bodies that ship: percentiles of ANSUR II (stature and mass of the same percentile).
pub const PRESETS: &[(&str, BodySize)] = &[
    ("female_p05", BodySize { sex: Sex::Female, stature_m: 1.525, mass_kg: 51.3 }),
    ("female_p50", BodySize { sex: Sex::Female, stature_m: 1.626, mass_kg: 66.8 }),
    ("male_p50", BodySize { sex: Sex::Male, stature_m: 1.755, mass_kg: 84.6 }),
    ("male_p95", BodySize { sex: Sex::Male, stature_m: 1.870, mass_kg: 110.7 }),
];

/// How the worker is placed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "stance", rename_all = "snake_case")]
pub enum Stance {
    /// On straight legs, with shoes of this sole thickness (m).
    Standing {
        /// Sole thickness, m.
        shoe_m: f64,
    },
    /// On a seat of this height (m).
    Seated {
        /// Height of the seat, m.
        seat_height_m: f64,
        /// Height of what the feet stand on, m; 0 is the floor.
        #[serde(default)]
        footrest_m: f64,
    },
}

/// A digital human of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name: of the preset, or of the file.
    pub name: String,
    /// What sized it.
    pub size: BodySize,
    /// Links and joints.
    pub model: Model,
    /// Hip joint centres above the floor, standing barefoot, m.
    pub standing_pelvis_height_m: f64,
    /// Hip joint centres above the seat, m.
    pub seat_to_hip_m: f64,
    /// Hand length, m.
    pub hand_length_m: f64,
    /// Bounds on sums of joints.
    pub sums: Vec<SumLimit>,
    /// The same links and joints on a pelvis that moves.
    moving: Model,
    /// Text of URDF and sheet, for hashes.
    source: String,
    /// Whether both are as the generator writes them.
    is_generated: bool,
}

impl Body {
    /// A shipped body by name, or a URDF file with its `.body.toml` beside it.
    pub fn load(name_or_path: &str, folder: &Path) -> Result<Self, InputError> {
        if let Some((name, size)) = PRESETS.iter().find(|(n, _)| *n == name_or_path) {
            return Self::of_size(name, *size);
        }
        let path = folder.join(name_or_path);
        if !path.is_file() && !name_or_path.contains(['/', '.']) {
            let names: Vec<&str> = PRESETS.iter().map(|(n, _)| *n).collect();
            let known = names.iter().copied().chain([POPULATION]);
            let help = suggest(name_or_path, known).unwrap_or_else(|| {
                format!(
                    "shipped bodies: {}; in a scenario also `{POPULATION}`; or the path of a body URDF",
                    names.join(", ")
                )
            });
            let message = format!("there is no shipped body `{name_or_path}`");
            return Err(InputError::new(name_or_path, message).remedy(help));
        }
        Self::read(&path)
    }

    /// A body of the given size, made in memory.
    pub fn of_size(name: &str, size: BodySize) -> Result<Self, InputError> {
        Self::of_proportions(name, size, &proportions(size.sex))
    }

    /// The same with other proportions than the mean of its sex.
    pub(super) fn of_proportions(
        name: &str,
        size: BodySize,
        shape: &Proportions,
    ) -> Result<Self, InputError> {
        let files = generate_with(name, size, shape).map_err(|e| InputError::new(name, e))?;
        let path = PathBuf::from(format!("{name}.urdf"));
        Self::parse(&path, &files.urdf, &sheet_path(&path), &files.sheet)
    }

    /// Reads `FILE.urdf` and the `FILE.body.toml` beside it.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let sheet = sheet_path(path);
        if path.is_file() && !sheet.is_file() {
            let message = "has no body sheet beside it";
            return Err(InputError::new(path, message).remedy(format!(
                "`{}` must hold size and trunk limits; `ergopath body` writes both files",
                sheet.display()
            )));
        }
        let body = Self::parse(path, &read_text(path)?, &sheet, &read_text(&sheet)?)?;
        let is_generated = generate(&body.name, body.size)
            .is_ok_and(|made| format!("{}{}", made.urdf, made.sheet) == body.source);
        Ok(Self { is_generated, ..body })
    }

    fn parse(path: &Path, urdf: &str, sheet_path: &Path, sheet: &str) -> Result<Self, InputError> {
        static KNOWN: Memo<Body> = Memo::new();
        let texts = [&path.to_string_lossy(), urdf, sheet];
        KNOWN.of(&texts, || Self::parse_anew(path, urdf, sheet_path, sheet))
    }

    fn parse_anew(
        path: &Path,
        urdf: &str,
        sheet_path: &Path,
        sheet: &str,
    ) -> Result<Self, InputError> {
        let model = parse_urdf(path, urdf)?;
        let parsed: BodySheet = parse_toml(sheet_path, sheet)?;
        if parsed.schema != BODY_SCHEMA {
            let message = format!("schema `{}` is not `{BODY_SCHEMA}`", parsed.schema);
            return Err(InputError::new(sheet_path, message)
                .remedy("make the body again with this version of ergopath"));
        }
        let size = parsed.size.check().map_err(|e| InputError::new(sheet_path, e).remedy(AGAIN))?;
        // It becomes part of the names of files.
        let is_plain = |c: char| c.is_alphanumeric() || "-_. (),+".contains(c);
        if parsed.name.is_empty()
            || parsed.name.len() > 80
            || is_formula(&parsed.name)
            || !parsed.name.chars().all(is_plain)
        {
            let message = format!("name {:?} is not plain", parsed.name);
            return Err(InputError::new(sheet_path, message)
                .remedy("use letters, digits, spaces and .,()+-_ only, a letter or digit first, 80 characters at most"));
        }
        prove(&parsed, &model).map_err(|e| InputError::new(sheet_path, e).remedy(AGAIN))?;
        for side in [Side::Right, Side::Left] {
            Linkage::chain(&model, PELVIS, side.grip())
                .map_err(|e| InputError::new(path, format!("is no ergopath body: {e}")))?;
        }
        let joint_names = || model.joints.iter().map(|j| j.name.as_str());
        for name in parsed.sum_limit.iter().flat_map(|s| &s.joints) {
            if !joint_names().any(|n| n == name) {
                let error = InputError::new(sheet_path, format!("there is no joint `{name}`"));
                let hint = suggest(name, joint_names()).unwrap_or_default();
                return Err(error.remedy(hint));
            }
        }
        let moving = on_moving_pelvis(&model, parsed.standing_pelvis_height_m)
            .map_err(|e| InputError::new(path, format!("is no ergopath body: {e}")))?;
        Ok(Self {
            name: parsed.name,
            size,
            model,
            moving,
            standing_pelvis_height_m: parsed.standing_pelvis_height_m,
            seat_to_hip_m: parsed.seat_to_hip_m,
            hand_length_m: parsed.hand_length_m,
            sums: parsed.sum_limit,
            source: format!("{urdf}{sheet}"),
            is_generated: true,
        })
    }

    /// Whether its files are not what the generator makes of its name and size: somebody, or another version,
    /// left other figures in them.
    pub fn is_other(&self) -> bool {
        !self.is_generated
    }

    /// SHA-256 of the two files.
    pub fn sha256(&self) -> String {
        crate::files::sha256_hex(self.source.as_bytes())
    }

    /// The chain from the pelvis to a grip: 24 joints.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub fn arm(&self, side: Side) -> Result<Linkage, InputError> {
        self.chain(Coupled::arm(side), &[])
    }

    /// The joints that are predicted together, to the grips and to further links on the way: the free
    /// coordinates of the pelvis first.
    ///
    /// # Errors
    /// Where there is no such link.
    pub fn chain(&self, coupled: Coupled, links: &[&str]) -> Result<Linkage, InputError> {
        let grips = coupled.hands.sides().iter().map(|s| Tip::link(s.grip()));
        let tips: Vec<Tip> = grips.chain(links.iter().map(|l| Tip::link(l))).collect();
        let linkage = match coupled.pelvis {
            Pelvis::Rests => Linkage::new(&self.model, PELVIS, &tips),
            Pelvis::Turns => Linkage::new(&self.moving, SEATED, &tips),
            Pelvis::Moves => Linkage::new(&self.moving, REST, &tips),
        };
        linkage.map_err(|e| InputError::new(&self.name, e.to_string()))
    }

    /// All joints to some links, the six coordinates of the pelvis first.
    ///
    /// # Errors
    /// Where there is no such link.
    pub(super) fn whole_linkage(&self, links: &[String]) -> Result<Linkage, InputError> {
        let tips: Vec<Tip> = links.iter().map(|l| Tip::link(l)).collect();
        Linkage::new(&self.moving, REST, &tips)
            .map_err(|e| InputError::new(&self.name, format!("is no ergopath body: {e}")))
    }

    /// Metres of a pelvis coordinate of one.
    pub fn leg_m(&self) -> f64 {
        self.standing_pelvis_height_m
    }

    /// Height of the floor in the rest frame, m: below zero.
    pub fn floor_m(&self, stance: Stance) -> f64 {
        -self.rest_height_m(stance)
    }

    /// Mass of a segment, kg.
    pub fn segment_kg(&self, segment: &str) -> f64 {
        self.model.links.iter().find(|l| l.name == segment).map_or(0.0, |l| l.mass_kg)
    }

    /// Limits of a linkage of this body.
    pub fn limits(&self, linkage: &Linkage) -> PostureLimits {
        PostureLimits::new(linkage, &self.sums)
    }

    /// The same body with joints that move at least over the given ranges (rad), by name. Files and
    /// hash stay those of the body.
    #[must_use]
    pub fn admitting<'a>(&self, ranges: impl IntoIterator<Item = (&'a str, f64, f64)>) -> Self {
        let mut wider = self.clone();
        for (name, lower, upper) in ranges {
            let joints = wider.model.joints.iter_mut().chain(&mut wider.moving.joints);
            for joint in joints.filter(|j| j.name == name) {
                joint.lower = joint.lower.min(lower);
                joint.upper = joint.upper.max(upper);
            }
        }
        wider
    }

    /// Height of the resting pelvis above the floor, m.
    fn rest_height_m(&self, stance: Stance) -> f64 {
        match stance {
            Stance::Standing { shoe_m } => self.standing_pelvis_height_m + shoe_m,
            Stance::Seated { seat_height_m, .. } => seat_height_m + self.seat_to_hip_m,
        }
    }

    /// Pose of the resting pelvis (ISB axes) in the world, the rest frame: over the floor point `at_m`,
    /// facing `facing` (rad about world z, 0 = world x).
    pub fn pelvis_pose(&self, at_m: [f64; 2], facing: f64, stance: Stance) -> Pose {
        let height = self.rest_height_m(stance);
        let forward = Vec3::new(facing.cos(), facing.sin(), 0.0);
        let right = forward.cross(&Vec3::z());
        let rotation = rotation_from_axes(forward, Vec3::z(), right);
        Pose::from_parts(Vec3::new(at_m[0], at_m[1], height).into(), rotation)
    }
}

fn sheet_path(urdf: &Path) -> PathBuf {
    urdf.with_extension("body.toml")
}

const AGAIN: &str = "check the value, or make the body again: ergopath body --sex f --stature-m 1.65 --mass-kg 65 \
                     -o FILE.urdf";
/// How far the masses of the links may be from that of the body together, of it.
const MASS: f64 = 0.05;

/// Whether sheet and links are of a person of that size.
fn prove(sheet: &BodySheet, model: &Model) -> Result<(), String> {
    let stature_m = sheet.size.stature_m;
    let lengths = [
        ("hand_length_m", HAND_M, sheet.hand_length_m),
        ("seat_to_hip_m", SEAT_TO_HIP_M, sheet.seat_to_hip_m),
        (
            "standing_pelvis_height_m over stature_m:",
            LEG_OVER_STATURE,
            sheet.standing_pelvis_height_m / stature_m,
        ),
    ];
    if let Some(fault) = lengths.iter().find_map(|(key, range, v)| range.fault(key, *v)) {
        return Err(fault);
    }
    for sum in &sheet.sum_limit {
        let (lower, upper) = (sum.lower_deg, sum.upper_deg);
        // Upright is zero, and everybody can stand so.
        if !(JOINT_DEG.holds(lower) && JOINT_DEG.holds(upper) && lower <= 0.0 && upper >= 0.0)
            || lower >= upper
        {
            return Err(format!(
                "sum_limit `{}`: {lower} to {upper} deg is no range about upright",
                sum.name
            ));
        }
        let [least, most] = trunk_limit(&sum.name).unwrap_or([JOINT_DEG.low, JOINT_DEG.high]);
        if lower < least || upper > most {
            return Err(format!(
                "sum_limit `{}`: {lower} to {upper} deg is more than {least} to {most}, which no trunk does",
                sum.name
            ));
        }
    }
    let mut joints = model.joints.iter().filter(|j| j.lower.is_finite() || j.upper.is_finite());
    if let Some(joint) =
        joints.find(|j| JOINT_RAD.outside([j.lower, j.upper]).is_some() || j.lower > j.upper)
    {
        let (name, lower, upper) = (&joint.name, joint.lower, joint.upper);
        return Err(format!(
            "joint `{name}`: {lower} to {upper} rad is no range of a person's joint"
        ));
    }
    let all: f64 = model.links.iter().map(|l| l.mass_kg).sum();
    let mass_kg = sheet.size.mass_kg;
    if (all - mass_kg).abs() > MASS * mass_kg {
        return Err(format!("mass_kg is {mass_kg}, but its links are {all:.1} kg together"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Frames;
    use approx::assert_relative_eq;

    fn posed(body: &Body, side: Side, set: &[(&str, f64)]) -> Pose {
        let arm = body.arm(side).unwrap();
        let mut q = vec![0.0; arm.dof()];
        for (name, deg) in set {
            let column = arm.joints().iter().position(|j| j.name == *name).unwrap();
            q[column] = deg.to_radians();
        }
        let mut frames = Frames::default();
        arm.forward(&q, &mut frames);
        arm.tip_pose(&frames, 0)
    }

    #[test]
    fn shipped_files_are_what_the_generator_writes() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/human");
        for (name, size) in PRESETS {
            let files = super::super::generate(name, *size).unwrap();
            let read = |ext: &str| std::fs::read_to_string(folder.join(format!("{name}.{ext}")));
            assert_eq!(read("urdf").unwrap(), files.urdf, "{name}: run `ergopath body` again");
            assert_eq!(read("body.toml").unwrap(), files.sheet, "{name}");
        }
    }

    #[test]
    fn has_the_joints_and_the_mass_of_a_person() {
        for (name, size) in PRESETS {
            let body = Body::load(name, Path::new(".")).unwrap();
            let moving = body.model.joints.iter().filter(|j| j.lower.is_finite()).count();
            assert_eq!(moving, 66);
            assert_eq!(Linkage::chain(&body.model, "Pelvis", "RightHand").unwrap().dof(), 24);
            let mass: f64 = body.model.links.iter().map(|l| l.mass_kg).sum();
            assert_relative_eq!(mass, size.mass_kg, max_relative = 1e-4);
        }
    }

    #[test]
    fn standing_heights_match_the_survey() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, Stance::Standing { shoe_m: 0.0 });
        let linkage = Linkage::new(
            &body.model,
            "Pelvis",
            &["RightUpperArm", "RightHand", "RightToe", "Neck"].map(Tip::link),
        )
        .unwrap();
        let mut frames = Frames::default();
        linkage.forward(&vec![0.0; linkage.dof()], &mut frames);
        let height = |i| (pelvis * linkage.tip_pose(&frames, i)).translation.z;
        // ANSUR II, men, means: acromial height 1440.7 of 1756.2 mm.
        assert_relative_eq!(height(0), 1.4407 - 0.020 * 1.755, epsilon = 2e-3);
        // Wrist height 0.485 of stature (Drillis and Contini): arms hang to there.
        assert_relative_eq!(height(1), 0.485 * 1.755, epsilon = 0.03);
        assert!(height(2) > 0.0 && height(2) < 0.05);
        assert_relative_eq!(height(3), 1.5173 - 0.020 * 1.755, epsilon = 2e-3);
    }

    #[test]
    fn pronation_is_zero_with_the_palm_forward() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        // Grip x leaves the palm, z points to the thumb (right hand, arm hanging).
        let zero = posed(&body, Side::Right, &[]);
        assert_relative_eq!(zero.rotation * Vec3::x(), Vec3::x(), epsilon = 1e-9);
        assert_relative_eq!(zero.rotation * Vec3::z(), Vec3::z(), epsilon = 1e-9);
        // Mid-prone: thumb forward, palm to the thigh.
        let mid = posed(&body, Side::Right, &[("jRightElbow_Y", 90.0)]);
        assert_relative_eq!(mid.rotation * Vec3::z(), Vec3::x(), epsilon = 1e-9);
        assert_relative_eq!(mid.rotation * Vec3::x(), -Vec3::z(), epsilon = 1e-9);
        // Left: the thumb points left at zero, forward at -90.
        let left = posed(&body, Side::Left, &[]);
        assert_relative_eq!(left.rotation * Vec3::z(), -Vec3::z(), epsilon = 1e-9);
        let left = posed(&body, Side::Left, &[("jLeftElbow_Y", -90.0)]);
        assert_relative_eq!(left.rotation * Vec3::z(), Vec3::x(), epsilon = 1e-9);
    }

    #[test]
    fn signs_follow_the_documentation() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let zero = posed(&body, Side::Right, &[]).translation.vector;
        let moved = |joint: &str, deg: f64| {
            posed(&body, Side::Right, &[(joint, deg)]).translation.vector - zero
        };
        assert!(moved("jRightShoulder_Z", 30.0).x > 0.1, "shoulder flexion lifts the arm forward");
        assert!(moved("jRightShoulder_X", -30.0).z > 0.1, "abduction takes the arm out");
        assert!(moved("jRightElbow_Z", 60.0).x > 0.1, "elbow flexion lifts the hand forward");
        let raised =
            |deg: f64| posed(&body, Side::Right, &[("jRightShoulder_Z", 180.0), ("jL5S1_Z", deg)]);
        let forward = raised(-30.0).translation.x - raised(0.0).translation.x;
        assert!(forward > 0.2, "trunk flexion takes a raised hand forward");
        assert!(moved("jRightC7Shoulder_X", -20.0).y > 0.02, "the girdle rises");
        assert!(moved("jRightC7Shoulder_Y", 20.0).x > 0.02, "the girdle protracts");
    }

    #[test]
    fn the_body_is_its_own_mirror_image() {
        let body = Body::load("male_p95", Path::new(".")).unwrap();
        let right = [
            ("jL5S1_Z", -20.0),
            ("jRightC7Shoulder_X", -9.0),
            ("jRightShoulder_Z", 40.0),
            ("jRightShoulder_X", -30.0),
            ("jRightShoulder_Y", 15.0),
            ("jRightElbow_Z", 70.0),
            ("jRightElbow_Y", 80.0),
            ("jRightWrist_X", 10.0),
        ];
        let left = right.map(|(name, deg)| {
            let flips = name.contains("Right") && !name.ends_with("_Z");
            (name.replace("Right", "Left"), if flips { -deg } else { deg })
        });
        let left: Vec<(&str, f64)> = left.iter().map(|(n, d)| (n.as_str(), *d)).collect();
        let (r, l) = (posed(&body, Side::Right, &right), posed(&body, Side::Left, &left));
        let mirror = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
        assert_relative_eq!(mirror(r.translation.vector), l.translation.vector, epsilon = 1e-9);
        // The thumb and the wrist mirror; x = y cross z then points the other way.
        for axis in [Vec3::y(), Vec3::z()] {
            assert_relative_eq!(mirror(r.rotation * axis), l.rotation * axis, epsilon = 1e-9);
        }
    }

    #[test]
    fn misspelt_bodies_get_a_suggestion() {
        let error = Body::load("female_50", Path::new(".")).unwrap_err();
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert!(help.contains("female_p50"), "{help}");
    }

    #[test]
    fn a_wider_range_is_admitted_and_nothing_narrowed() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let wider = body.admitting([("jRightElbow_X", -0.1, 0.6)]);
        assert_eq!(body.sha256(), wider.sha256());
        let limits = |b: &Body| b.limits(&b.arm(Side::Right).unwrap());
        let (before, after) = (limits(&body), limits(&wider));
        let elbow = body.arm(Side::Right).unwrap();
        let c = elbow.joints().iter().position(|j| j.name == "jRightElbow_X").unwrap();
        assert_eq!((after.lower[c], after.upper[c]), (before.lower[c], 0.6));
        assert_eq!(before.lower, after.lower);
    }
}

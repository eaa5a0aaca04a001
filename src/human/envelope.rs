//! How much room a body takes: capsules around its segments, for clearance between robot and person.
//!
//! Radii follow from the body's own masses and lengths: a limb is as thick as the cylinder of its mass
//! between its joints, the trunk has one cross-section, two half circles with a rectangle between,
//! that holds its mass. Density and the trunk's depth to breadth are assumed. Muscles bulge by up to
//! about 10 mm beyond the mean, chest and belly by about 30 mm; clothes and hair are not included.

use super::body::{Body, Stance};
use super::side::{Coupled, Hands, Side};
use super::skeleton::{Head, Segment, Skeleton};
use crate::files::InputError;
use crate::kinematics::Frames;
use crate::math::{Pose, Vec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// Density of limbs and head, and of the trunk with its lungs, kg/m^3 (assumed).
const LIMB_DENSITY: f64 = 1050.0;
const TRUNK_DENSITY: f64 = 950.0;
/// Depth of the trunk over its breadth (assumed).
const TRUNK_DEPTH: f64 = 0.7;
/// Share of the stature by which the trunk reaches below the hip joints (assumed).
const BELOW_HIPS: f64 = 0.05;
/// Share of the hand's length that a closed hand takes up (assumed).
const CLOSED_HAND: f64 = 0.6;

/// One capsule of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPart {
    /// In words, such as "right forearm".
    pub name: String,
    /// Radius, m.
    pub radius_m: f64,
    /// True for hand and forearm of a side that holds on to the robot.
    pub is_coupled: bool,
    segment: Segment,
    /// Ends of the axis in that frame, m.
    ends: [Vec3; 2],
}

/// The capsules of one body with its hands on the robot.
#[derive(Debug, Clone)]
pub struct Envelope {
    skeleton: Skeleton,
    parts: Vec<BodyPart>,
}

/// Scratch for placing an envelope.
#[derive(Debug, Clone, Default)]
pub struct EnvelopeScratch {
    q: Vec<f64>,
    frames: Frames,
}

impl Envelope {
    /// For a body whose coupled hands hold on to the robot.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub fn new(body: &Body, coupled: Coupled, stance: Stance) -> Result<Self, InputError> {
        let skeleton = Skeleton::new(body, coupled, stance, true)?;
        let segments = Segments::new(body, &skeleton);
        let part = |sketch: Sketch| {
            let Sketch { name, segment, radius_m, is_coupled, ends } = sketch;
            let segment = skeleton.segment(&segment)?;
            Ok(BodyPart { name, radius_m, is_coupled, segment, ends })
        };
        let sketches = segments.sketches(coupled.hands)?;
        let parts: Result<Vec<BodyPart>, InputError> = sketches.into_iter().map(part).collect();
        let parts = parts?;
        Ok(Self { skeleton, parts })
    }

    /// The capsules, in the order of [`Envelope::place`].
    pub fn parts(&self) -> &[BodyPart] {
        &self.parts
    }

    /// Ends of the capsules' axes in the world (m), for the rest frame there and the joints of the coupled
    /// chain (rad, leg lengths). The head is in line with the trunk.
    ///
    /// # Panics
    /// When `q` has not as many values as the coupled chain has joints.
    pub fn place(
        &self,
        rest: &Pose,
        q: &[f64],
        scratch: &mut EnvelopeScratch,
        ends: &mut Vec<[Vec3; 2]>,
    ) {
        self.place_with(rest, q, Head::default(), scratch, ends);
    }

    /// The same with the head held somehow.
    pub fn place_with(
        &self,
        rest: &Pose,
        q: &[f64],
        head: Head,
        scratch: &mut EnvelopeScratch,
        ends: &mut Vec<[Vec3; 2]>,
    ) {
        scratch.q.resize(self.skeleton.dof(), 0.0);
        self.skeleton.whole_into(q, head, &mut scratch.q);
        self.skeleton.forward(&scratch.q, &mut scratch.frames);
        let turn = *rest.rotation.to_rotation_matrix().matrix();
        let at = rest.translation.vector;
        ends.clear();
        ends.extend(self.parts.iter().map(|part| {
            let (p, r) = self.skeleton.frame(&scratch.frames, part.segment);
            let (p, r) = (at + turn * p, turn * r);
            part.ends.map(|x| p + r * x)
        }));
    }
}

/// One capsule before it is bound to a linkage.
struct Sketch {
    name: String,
    segment: String,
    ends: [Vec3; 2],
    radius_m: f64,
    is_coupled: bool,
}

/// Where segments are on the upright body, and what they weigh.
struct Segments<'a> {
    body: &'a Body,
    skeleton: &'a Skeleton,
}

impl<'a> Segments<'a> {
    fn new(body: &'a Body, skeleton: &'a Skeleton) -> Self {
        Self { body, skeleton }
    }

    /// Origins of segments in the pelvis frame; all frames are parallel there.
    fn at(&self, name: &str) -> Result<Vec3, InputError> {
        let posed = self.skeleton.pose(&vec![0.0; self.skeleton.dof()]);
        Ok(posed.at(self.skeleton.segment(name)?).translation.vector)
    }

    fn mass(&self, name: &str) -> f64 {
        self.body.segment_kg(name)
    }

    /// A limb from its joint along `axis`.
    fn limb(&self, name: String, segment: String, axis: Vec3, is_coupled: bool) -> Sketch {
        let volume = self.mass(&segment) / LIMB_DENSITY;
        let radius_m = (volume / (PI * axis.norm().max(0.02))).sqrt();
        Sketch { name, segment, ends: [Vec3::zeros(), axis], radius_m, is_coupled }
    }

    fn sketches(&self, coupled: Hands) -> Result<Vec<Sketch>, InputError> {
        let way = |from: &str, to: &str| Ok::<_, InputError>(self.at(to)? - self.at(from)?);
        let mut all = self.trunk()?;
        all.push(self.limb("neck".into(), "Neck".into(), way("Neck", "Head")?, false));
        all.push(self.head()?);
        for side in [Side::Right, Side::Left] {
            let prefix = side.prefix();
            let low = prefix.to_lowercase();
            let of = |segment: &str| format!("{prefix}{segment}");
            let way = |from: &str, to: &str| way(&of(from), &of(to));
            let is_coupled = coupled.hold(side);
            let hand = Vec3::new(0.0, -CLOSED_HAND * self.body.hand_length_m, 0.0);
            all.extend([
                self.limb(
                    format!("{low} upper arm"),
                    of("UpperArm"),
                    way("UpperArm", "ForeArm")?,
                    false,
                ),
                self.limb(
                    format!("{low} forearm"),
                    of("ForeArm"),
                    way("ForeArm", "Hand")?,
                    is_coupled,
                ),
                self.limb(format!("{low} hand"), of("Hand"), hand, is_coupled),
                self.limb(
                    format!("{low} thigh"),
                    of("UpperLeg"),
                    way("UpperLeg", "LowerLeg")?,
                    false,
                ),
                self.limb(format!("{low} shank"), of("LowerLeg"), way("LowerLeg", "Foot")?, false),
                self.limb(format!("{low} foot"), of("Foot"), way("Foot", "Toe")?, false),
            ]);
        }
        Ok(all)
    }

    /// A ball-ended head from the joint to the crown that holds its mass.
    fn head(&self) -> Result<Sketch, InputError> {
        let crown = self.body.size.stature_m - self.body.standing_pelvis_height_m;
        let length = crown - self.at("Head")?.y;
        let volume = self.mass("Head") / LIMB_DENSITY;
        let held = |r: f64| PI * r * r * (length - 2.0 * r) + 4.0 / 3.0 * PI * r.powi(3);
        let (mut low, mut high) = (0.0, 0.5 * length);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if held(middle) < volume { low = middle } else { high = middle }
        }
        let ends = [low, length - low].map(|y| Vec3::new(0.0, y, 0.0));
        let (name, segment) = ("head".to_owned(), "Head".to_owned());
        Ok(Sketch { name, segment, ends, radius_m: low, is_coupled: false })
    }

    /// Pelvis to chest: pairs of capsules side by side.
    fn trunk(&self) -> Result<Vec<Sketch>, InputError> {
        let masses = ["Pelvis", "L5", "L3", "T12", "T8", "RightShoulder", "LeftShoulder"];
        let mass: f64 = masses.iter().map(|m| self.mass(m)).sum();
        let length = self.at("Neck")?.y + BELOW_HIPS * self.body.size.stature_m;
        let area = mass / TRUNK_DENSITY / length;
        // pi d^2 / 4 + d (b - d), with b = d / ratio.
        let depth = (area / (FRAC_PI_4 + 1.0 / TRUNK_DEPTH - 1.0)).sqrt();
        let (radius_m, aside) = (0.5 * depth, 0.5 * depth * (1.0 / TRUNK_DEPTH - 1.0));
        let y = |name: &str| self.at(name).map(|p| p.y);
        let [l5, l3, t12, t8, neck] = [y("L5")?, y("L3")?, y("T12")?, y("T8")?, y("Neck")?];
        let pieces = [
            ("pelvis", "Pelvis", radius_m - BELOW_HIPS * self.body.size.stature_m, l5),
            ("abdomen", "L3", l5 - l3, t12 - l3),
            ("lower chest", "T12", 0.0, t8 - t12),
            ("chest", "T8", 0.0, neck - t8 - 0.5 * radius_m),
        ];
        let both = |(name, segment, low, high): (&str, &str, f64, f64)| {
            [aside, -aside].map(|z| Sketch {
                name: name.to_owned(),
                segment: segment.to_owned(),
                ends: [Vec3::new(0.0, low.min(high), z), Vec3::new(0.0, high, z)],
                radius_m,
                is_coupled: false,
            })
        };
        Ok(pieces.into_iter().flat_map(both).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn standing(name: &str) -> (Body, Envelope, Vec<[Vec3; 2]>) {
        let body = Body::load(name, std::path::Path::new(".")).unwrap();
        let stance = Stance::Standing { shoe_m: 0.03 };
        let envelope = Envelope::new(&body, Coupled::arm(Side::Right), stance).unwrap();
        let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
        let mut ends = Vec::new();
        let q = vec![0.0; body.arm(Side::Right).unwrap().dof()];
        envelope.place(&pelvis, &q, &mut EnvelopeScratch::default(), &mut ends);
        (body, envelope, ends)
    }

    #[test]
    fn is_as_large_as_the_person() {
        for (name, size) in super::super::PRESETS {
            let (_, envelope, ends) = standing(name);
            let reach = |axis: usize, sign: f64| {
                let of = |(p, e): (&BodyPart, &[Vec3; 2])| {
                    p.radius_m + (sign * e[0][axis]).max(sign * e[1][axis])
                };
                envelope.parts().iter().zip(&ends).map(of).fold(f64::NEG_INFINITY, f64::max)
            };
            // Crown and soles.
            assert!((reach(2, 1.0) - size.stature_m - 0.03).abs() < 0.01, "{name}");
            assert!(reach(2, -1.0).abs() < 0.06, "{name}: {}", reach(2, -1.0));
            // Across the upper arms (bideltoid breadth is about 0.28 of stature), all but the feet
            // within the depth of a chest.
            let across = reach(1, 1.0) + reach(1, -1.0);
            assert!((0.24..0.34).contains(&(across / size.stature_m)), "{name}: {across}");
            let radius = |part: &str| {
                envelope.parts().iter().find(|p| p.name == part).unwrap().radius_m / size.stature_m
            };
            for (part, low, high) in [
                ("chest", 0.055, 0.08),
                ("head", 0.04, 0.06),
                ("right forearm", 0.018, 0.026),
                ("left upper arm", 0.022, 0.032),
                ("left thigh", 0.04, 0.06),
            ] {
                assert!((low..high).contains(&radius(part)), "{name} {part}: {}", radius(part));
            }
        }
    }

    #[test]
    fn hand_and_forearm_of_one_side_are_coupled() {
        let (_, envelope, _) = standing("male_p50");
        let coupled: Vec<&str> =
            envelope.parts().iter().filter(|p| p.is_coupled).map(|p| p.name.as_str()).collect();
        assert_eq!(coupled, ["right forearm", "right hand"]);
    }

    #[test]
    fn capsules_follow_the_posture() {
        let (body, envelope, before) = standing("male_p50");
        let arm = body.arm(Side::Right).unwrap();
        let mut q = vec![0.0; arm.dof()];
        let column = arm.joints().iter().position(|j| j.name == "jRightShoulder_Z").unwrap();
        q[column] = FRAC_PI_2;
        let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, Stance::Standing { shoe_m: 0.03 });
        let mut after = Vec::new();
        envelope.place(&pelvis, &q, &mut EnvelopeScratch::default(), &mut after);
        for ((part, a), b) in envelope.parts().iter().zip(&before).zip(&after) {
            let moved = (a[1] - b[1]).norm();
            let is_arm = part.name.starts_with("right") && part.name.contains("arm")
                || part.name == "right hand";
            assert_eq!(moved > 0.1, is_arm, "{}: {moved}", part.name);
        }
        // Seated, the knees are as far forward as the thighs are long.
        let seat = Stance::Seated { seat_height_m: 0.45, footrest_m: 0.0 };
        let seated = Envelope::new(&body, Coupled::arm(Side::Right), seat);
        let mut ends = Vec::new();
        seated.unwrap().place(
            &pelvis,
            &vec![0.0; arm.dof()],
            &mut EnvelopeScratch::default(),
            &mut ends,
        );
        let thigh = envelope.parts().iter().position(|p| p.name == "left thigh").unwrap();
        assert!((ends[thigh][1] - ends[thigh][0]).x > 0.3);
    }
}

//! How tall a recorded person is by each part of the body, beside the people of a survey.

use crate::files::InputError;
use crate::human::{Body, PRESETS, Sex, Side};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::{Vec3, stats};
use crate::recording::Recording;
use serde::Serialize;

/// Statures by arm and by legs that differ more than this are a conflict, as a share of the stature.
const APART: f64 = 0.06;
/// Bodies of middle size: man and woman.
const MIDDLE: [&str; 2] = ["male_p50", "female_p50"];

/// A part of the body: its segments, and how much it varies among men and women (standard deviation, m; ANSUR
/// II, 2012: acromion-radiale, radiale-stylion, their root of squares, trochanterion height and biacromial
/// breadth).
const PARTS: [(&str, &[&str], [f64; 2]); 5] = [
    ("upper arm", &["UpperArm"], [0.0175, 0.0172]),
    ("forearm", &["ForeArm"], [0.0154, 0.0152]),
    ("arm", &["UpperArm", "ForeArm"], [0.0233, 0.0230]),
    ("leg", &["UpperLeg", "LowerLeg"], [0.0492, 0.0447]),
    ("shoulder breadth", &["ShoulderToShoulder"], [0.0192, 0.0183]),
];

/// Length of a part of a person.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartSize {
    /// Name of the part.
    pub part: &'static str,
    /// As recorded, m.
    pub length_m: f64,
    /// Stature of a man of usual proportions with such a part, m.
    pub stature_m: f64,
    /// Share of men, and of women, whose part is shorter.
    pub shorter: [f64; 2],
}

/// What recordings of one file tell of the size of a person.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sizes {
    /// Parts that were recorded.
    pub parts: Vec<PartSize>,
}

impl Sizes {
    pub(super) fn of<'a>(
        recordings: impl Iterator<Item = &'a Recording>,
        side: Side,
    ) -> Result<Self, InputError> {
        let recordings: Vec<&Recording> = recordings.collect();
        let bodies = [Body::load(MIDDLE[0], "".as_ref())?, Body::load(MIDDLE[1], "".as_ref())?];
        let mut parts = Vec::new();
        for (part, segments, spread) in PARTS {
            let lengths: Vec<f64> =
                recordings.iter().filter_map(|r| length(r, segments, side)).collect();
            if lengths.is_empty() {
                continue;
            }
            let length_m = stats::mean(&lengths);
            let [man, woman] = [own(&bodies[0], part, side)?, own(&bodies[1], part, side)?];
            let shorter = |middle: f64, sd: f64| stats::normal_cdf((length_m - middle) / sd);
            parts.push(PartSize {
                part,
                length_m,
                stature_m: stature(Sex::Male) * length_m / man,
                shorter: [shorter(man, spread[0]), shorter(woman, spread[1])],
            });
        }
        Ok(Self { parts })
    }

    /// A part by its name.
    pub fn part(&self, name: &str) -> Option<&PartSize> {
        self.parts.iter().find(|p| p.part == name)
    }

    /// Statures by arm and by legs, where they disagree.
    pub fn conflict(&self) -> Option<[f64; 2]> {
        let [arm, leg] = [self.part("arm")?.stature_m, self.part("leg")?.stature_m];
        ((arm / leg - 1.0).abs() > APART).then_some([arm, leg])
    }
}

fn stature(sex: Sex) -> f64 {
    let of = PRESETS.iter().find(|(n, s)| MIDDLE.contains(n) && s.sex == sex);
    of.map_or(f64::NAN, |(_, size)| size.stature_m)
}

/// Recorded length of segments in a row; legs of the side, as arms.
fn length(recording: &Recording, segments: &[&str], side: Side) -> Option<f64> {
    let one = |segment: &str| {
        let own = format!("{}{segment}", side.prefix());
        recording.length_m(&own).or_else(|| recording.length_m(segment))
    };
    segments.iter().map(|s| one(s)).sum()
}

/// The same length in a body.
fn own(body: &Body, part: &str, side: Side) -> Result<f64, InputError> {
    let side = |name: &str| format!("{}{name}", side.prefix());
    let names: Vec<String> = match part {
        "upper arm" => vec![side("UpperArm"), side("ForeArm")],
        "forearm" => vec![side("ForeArm"), side("Hand")],
        "arm" => vec![side("UpperArm"), side("ForeArm"), side("Hand")],
        "leg" => vec![side("UpperLeg"), side("LowerLeg"), side("Foot")],
        _ => vec!["RightUpperArm".to_owned(), "LeftUpperArm".to_owned()],
    };
    let points = points_of(body, &names)?;
    Ok(points.windows(2).map(|w: &[Vec3]| (w[1] - w[0]).norm()).sum())
}

/// Joint centres of segments of a body that stands upright, from its pelvis, m.
fn points_of(body: &Body, segments: &[String]) -> Result<Vec<Vec3>, InputError> {
    let tips: Vec<Tip> = segments.iter().map(|s| Tip::link(s)).collect();
    let chain = Linkage::new(&body.model, "Pelvis", &tips)
        .map_err(|e| InputError::fault(&body.name, e.to_string()))?;
    let mut frames = Frames::default();
    chain.forward(&vec![0.0; chain.dof()], &mut frames);
    Ok((0..tips.len()).map(|tip| chain.tip_frame(&frames, tip).0).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::BodySize;
    use approx::assert_relative_eq;

    /// A recording of the lengths of a body, with a leg of another one.
    fn recorded(stature_m: f64, legs_of_m: f64) -> Recording {
        let body = |stature_m| {
            let size = BodySize { sex: Sex::Male, stature_m, mass_kg: 80.0 };
            Body::of_size("x", size).unwrap()
        };
        let (arms, legs) = (body(stature_m), body(legs_of_m));
        let between = |body: &Body, from: &str, to: &str| {
            let points = points_of(body, &[from.to_owned(), to.to_owned()]).unwrap();
            (from.to_owned(), (points[1] - points[0]).norm())
        };
        Recording {
            source: "x".into(),
            format: "BVH",
            sha256: String::new(),
            rate_hz: 100.0,
            segments: Vec::new(),
            segment_lengths_m: vec![
                between(&arms, "RightUpperArm", "RightForeArm"),
                between(&arms, "RightForeArm", "RightHand"),
                between(&legs, "RightUpperLeg", "RightLowerLeg"),
                between(&legs, "RightLowerLeg", "RightFoot"),
            ],
            remarks: Vec::new(),
        }
    }

    #[test]
    fn every_part_tells_the_stature_of_a_usual_man() {
        let r = recorded(1.9, 1.9);
        let sizes = Sizes::of([&r].into_iter(), Side::Right).unwrap();
        assert_eq!(sizes.parts.len(), 4);
        for part in &sizes.parts {
            assert_relative_eq!(part.stature_m, 1.9, epsilon = 2e-3);
            assert!(part.shorter[0] > 0.85 && part.shorter[1] > part.shorter[0], "{part:?}");
        }
        assert_eq!(sizes.conflict(), None);
        let middle = recorded(1.755, 1.755);
        let sizes = Sizes::of([&middle].into_iter(), Side::Right).unwrap();
        assert_relative_eq!(sizes.part("arm").unwrap().shorter[0], 0.5, epsilon = 0.01);
    }

    #[test]
    fn long_arms_on_short_legs_are_a_conflict() {
        let r = recorded(1.9, 1.7);
        let [arm, leg] = Sizes::of([&r].into_iter(), Side::Right).unwrap().conflict().unwrap();
        assert_relative_eq!(arm, 1.9, epsilon = 2e-3);
        assert_relative_eq!(leg, 1.7, epsilon = 2e-3);
        assert_eq!(Sizes::of([&r].into_iter(), Side::Left).unwrap().conflict(), None);
    }
}

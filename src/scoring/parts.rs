//! The body parts of the sheets: their angles, their step scores, and when a hold of them counts.

use super::frames::Frame;
use crate::ergonomics::PartTimeline;

/// What rounding may move, deg.
const LEAST_DEG: f64 = 1e-3;

/// One angle of a body part.
#[derive(Debug, Clone, Copy)]
pub struct Angle {
    /// Name as a key, without its unit.
    pub key: &'static str,
    /// Name in words.
    pub name: &'static str,
    /// Its value, deg.
    pub of: fn(&Frame) -> f64,
}

/// A step score and its largest value.
pub type Step = (fn(&Frame) -> u8, u8);

/// One body part.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    /// Name in words.
    pub name: &'static str,
    /// Its angles.
    pub angles: &'static [Angle],
    /// Its step of RULA.
    pub rula: Option<Step>,
    /// Its step of REBA.
    pub reba: Option<Step>,
    /// Whether a long hold of it alone is static muscle use.
    bears: bool,
    /// Whether rapid large changes of it count for REBA.
    pub is_large: bool,
}

/// All parts.
pub const PARTS: &[Part] = &[
    Part {
        name: "upper arm",
        angles: &[
            Angle { key: "upper_arm_flexion", name: "flexion", of: |f| f.arm.upper_arm_flex_deg },
            Angle {
                key: "upper_arm_abduction",
                name: "abduction",
                of: |f| f.arm.upper_arm_abduction_deg,
            },
        ],
        rula: Some((|f| f.rula.upper_arm, 6)),
        reba: Some((|f| f.reba.upper_arm, 6)),
        bears: true,
        is_large: true,
    },
    Part {
        name: "shoulder girdle",
        angles: &[Angle {
            key: "shoulder_elevation",
            name: "elevation",
            of: |f| f.arm.girdle_elevation_deg,
        }],
        rula: None,
        reba: None,
        bears: false,
        is_large: false,
    },
    Part {
        name: "lower arm",
        angles: &[Angle { key: "elbow_flexion", name: "flexion", of: |f| f.arm.elbow_flex_deg }],
        rula: Some((|f| f.rula.lower_arm, 3)),
        reba: Some((|f| f.reba.lower_arm, 2)),
        bears: false,
        is_large: false,
    },
    Part {
        name: "wrist",
        angles: &[
            Angle { key: "wrist_flexion", name: "flexion", of: |f| f.arm.wrist_flex_deg },
            Angle { key: "wrist_deviation", name: "deviation", of: |f| f.arm.wrist_deviation_deg },
        ],
        rula: Some((|f| f.rula.wrist, 4)),
        reba: Some((|f| f.reba.wrist, 3)),
        bears: false,
        is_large: false,
    },
    Part {
        name: "forearm twist",
        angles: &[Angle {
            key: "forearm_pronation",
            name: "pronation",
            of: |f| f.arm.wrist_twist_deg,
        }],
        rula: Some((|f| f.rula.wrist_twist, 2)),
        reba: None,
        bears: false,
        is_large: false,
    },
    Part {
        name: "neck",
        angles: &[
            Angle { key: "neck_flexion", name: "flexion", of: |f| f.body.neck_flex_deg },
            Angle { key: "neck_side_bend", name: "side bend", of: |f| f.body.neck_side_deg },
            Angle { key: "neck_twist", name: "twist", of: |f| f.body.neck_twist_deg },
        ],
        rula: Some((|f| f.rula.neck, 6)),
        reba: Some((|f| f.reba.neck, 3)),
        bears: true,
        is_large: false,
    },
    Part {
        name: "trunk",
        angles: &[
            Angle { key: "trunk_flexion", name: "flexion", of: |f| f.body.trunk_flex_deg },
            Angle { key: "trunk_side_bend", name: "side bend", of: |f| f.body.trunk_side_deg },
            Angle { key: "trunk_twist", name: "twist", of: |f| f.body.trunk_twist_deg },
        ],
        rula: Some((|f| f.rula.trunk, 6)),
        reba: Some((|f| f.reba.trunk, 5)),
        bears: true,
        is_large: true,
    },
    Part {
        name: "legs",
        angles: &[Angle { key: "knee_flexion", name: "knee flexion", of: |f| f.knee_deg }],
        rula: Some((|f| f.rula.legs, 2)),
        reba: Some((|f| f.reba.legs, 4)),
        bears: false,
        is_large: false,
    },
];

impl Part {
    /// Whether a long hold of the part is static muscle use: upper arm, neck or trunk, held outside
    /// the lowest class of RULA in most of the hold's frames. An arm that hangs for minutes, or an
    /// upright trunk, rests. A choice of this project; Maurer-Grubinger et al. (2021) ask for the
    /// hand above L5 instead.
    pub(super) fn is_held_up(&self, over_time: &PartTimeline, frames: &[Frame]) -> bool {
        let (Some(hold), Some((step, _))) = (over_time.longest_hold, self.rula) else {
            return false;
        };
        let within =
            frames.iter().filter(|f| (hold.from_s..=hold.to_s).contains(&f.time_s)).map(step);
        let (mut high, mut all) = (0, 0);
        for score in within {
            all += 1;
            high += usize::from(score > 1);
        }
        self.bears && 2 * high > all
    }

    /// Whether the part moves at all: a neck or knee that is set by a rule does not, and says nothing
    /// about time.
    pub(super) fn is_measured(&self, frames: &[Frame]) -> bool {
        let Some(first) = frames.first() else { return false };
        let moves = |f: &Frame, a: &Angle| ((a.of)(f) - (a.of)(first)).abs() > LEAST_DEG;
        self.angles.iter().any(|a| frames.iter().any(|f| moves(f, a)))
            || !["neck", "legs"].contains(&self.name)
    }
}

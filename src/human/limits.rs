//! Ranges of motion: of single joints, and of sums of joints (the trunk as a whole).
//!
//! Ranges are AAOS normative values (deg), widened a little where recorded people went beyond them
//! (axial and lateral L5/S1, depression of the girdle, deviation and axial play of the wrist). Over the four spine joints they are split after White and
//! Panjabi's proportions and then widened by half, because Xsens-like spine models put up to 45 % of
//! the flexion into one joint; the *sums* keep the AAOS totals.

use crate::kinematics::Linkage;
use serde::{Deserialize, Serialize};

/// Flexion of the spine joints from the pelvis up, relative to the first: measured slopes of
/// inertial motion-capture systems.
pub const SPINE_SHARES: [f64; 4] = [1.0, 0.44, 0.44, 0.33];
/// How much wider a single spine joint may move than its share of the total.
const SPINE_WIDENING: f64 = 1.5;

/// A bound on the sum of joint angles, which a URDF cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SumLimit {
    /// What is bounded, in words.
    pub name: String,
    /// The joints whose angles are added.
    pub joints: Vec<String>,
    /// Lower bound, deg.
    pub lower_deg: f64,
    /// Upper bound, deg.
    pub upper_deg: f64,
}

/// Bounds on the columns of a linkage, rad.
#[derive(Debug, Clone, PartialEq)]
pub struct PostureLimits {
    /// Lower bounds, n.
    pub lower: Vec<f64>,
    /// Upper bounds, n.
    pub upper: Vec<f64>,
    /// Bounds on sums of columns.
    pub sums: Vec<SumRow>,
}

/// One bounded sum.
#[derive(Debug, Clone, PartialEq)]
pub struct SumRow {
    /// What is bounded.
    pub name: String,
    /// The columns that are added.
    pub columns: Vec<usize>,
    /// Lower bound, rad.
    pub lower: f64,
    /// Upper bound, rad.
    pub upper: f64,
}

impl PostureLimits {
    /// The limits of a linkage; a sum applies when all of its joints are columns.
    pub fn new(linkage: &Linkage, sums: &[SumLimit]) -> Self {
        let column = |name: &String| linkage.joints().iter().position(|j| &j.name == name);
        let rows = sums.iter().filter_map(|s| {
            let columns: Option<Vec<usize>> = s.joints.iter().map(column).collect();
            Some(SumRow {
                name: s.name.clone(),
                columns: columns?,
                lower: s.lower_deg.to_radians(),
                upper: s.upper_deg.to_radians(),
            })
        });
        Self {
            lower: linkage.joints().iter().map(|j| j.lower).collect(),
            upper: linkage.joints().iter().map(|j| j.upper).collect(),
            sums: rows.collect(),
        }
    }

    /// The limits with `by` (rad) more for every joint on either side; sums stay.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        Self {
            lower: self.lower.iter().map(|v| v - by).collect(),
            upper: self.upper.iter().map(|v| v + by).collect(),
            sums: self.sums.clone(),
        }
    }

    /// Largest violation of any bound by `q`, rad; 0 when all are met.
    pub fn violation(&self, q: &[f64]) -> f64 {
        let single = q.iter().zip(self.lower.iter().zip(&self.upper));
        let single = single.map(|(v, (lo, hi))| (lo - v).max(v - hi));
        let sums = self.sums.iter().map(|s| {
            let total: f64 = s.columns.iter().map(|&c| q[c]).sum();
            (s.lower - total).max(total - s.upper)
        });
        single.chain(sums).fold(0.0, f64::max)
    }
}

/// Ranges about Z, X and Y of a joint on the right side or the midline, deg.
pub(super) type Ranges = [(f64, f64); 3];

/// Ranges of every joint by Xsens name without the side.
pub(super) fn ranges(joint: &str) -> Ranges {
    let spine = |flexion: f64, extension: f64, lateral: f64, axial: f64| {
        let w = SPINE_WIDENING;
        [(-flexion * w, extension * w), (-lateral * w, lateral * w), (-axial * w, axial * w)]
    };
    match joint {
        "L5S1" => spine(24.0, 8.0, 6.0, 5.0),
        "L4L3" => spine(22.0, 7.0, 11.0, 5.0),
        "L1T12" => spine(18.0, 5.0, 10.0, 8.0),
        "T9T8" => spine(16.0, 5.0, 10.0, 30.0),
        "T1C7" => [(-30.0, 30.0), (-30.0, 30.0), (-30.0, 30.0)],
        "C1Head" => [(-20.0, 30.0), (-15.0, 15.0), (-50.0, 50.0)],
        // Axial roll, depression(+)/elevation(-), retraction(-)/protraction(+) of the clavicle.
        "C7Shoulder" => [(-15.0, 15.0), (-35.0, 15.0), (-20.0, 25.0)],
        // Extension/flexion, abduction/adduction, external/internal rotation. The axial range is
        // wider than AAOS (90/70): about a raised arm the Z-X-Y split moves part of the plane of
        // elevation into it.
        "Shoulder" => [(-60.0, 180.0), (-170.0, 50.0), (-100.0, 100.0)],
        // Flexion, carrying angle, pronation from full supination: 90 to each side of mid-prone, the
        // upper end of measured people (71 to 96 and 74 to 93), so that the zero is admissible.
        "Elbow" => [(-10.0, 155.0), (-20.0, 20.0), (0.0, 180.0)],
        // Recorded hands turn by up to 30 deg against the forearm's own frame, because skin-mounted
        // frames follow only part of the pronation.
        "Wrist" => [(-70.0, 80.0), (-35.0, 40.0), (-30.0, 30.0)],
        "Hip" => [(-30.0, 120.0), (-45.0, 30.0), (-45.0, 45.0)],
        "Knee" => [(-135.0, 5.0), (-5.0, 5.0), (-10.0, 10.0)],
        "Ankle" => [(-50.0, 20.0), (-20.0, 20.0), (-10.0, 10.0)],
        _ => [(-10.0, 60.0), (-5.0, 5.0), (-5.0, 5.0)],
    }
}

/// The most of a sum of the trunk that anybody does, deg: the widest ranges of supple young people. Bending
/// forward and back are of another size, so that an exchange of the two is seen.
pub(super) fn trunk_limit(name: &str) -> Option<[f64; 2]> {
    let is = |word: &str| name.contains(word);
    match () {
        () if is("flexion") => Some([-140.0, 60.0]),
        () if is("side bending") => Some([-70.0, 70.0]),
        () if is("rotation") => Some([-90.0, 90.0]),
        () => None,
    }
}

/// The trunk as a whole: AAOS thoracolumbar totals, deg.
pub(super) fn trunk_sums() -> Vec<SumLimit> {
    let joints = |axis: &str| -> Vec<String> {
        ["jL5S1", "jL4L3", "jL1T12", "jT9T8"].iter().map(|j| format!("{j}_{axis}")).collect()
    };
    let sum = |name: &str, axis: &str, lower_deg: f64, upper_deg: f64| SumLimit {
        name: name.to_owned(),
        joints: joints(axis),
        lower_deg,
        upper_deg,
    };
    vec![
        sum("trunk extension (+) and flexion (-)", "Z", -80.0, 25.0),
        sum("trunk side bending", "X", -35.0, 35.0),
        sum("trunk rotation", "Y", -45.0, 45.0),
    ]
}

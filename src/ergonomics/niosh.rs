//! The revised NIOSH lifting equation: how heavy a load two hands may lift, and the lifting index.
//!
//! Waters, Putz-Anderson, Garg and Fine, Ergonomics 36:749-776, 1993; Applications Manual for the
//! Revised NIOSH Lifting Equation, DHHS (NIOSH) 94-110, 1994, revised 2021 ("the manual"). Lengths in
//! cm and loads in kg, as the metric half of the manual has them:
//!
//! `RWL = 23 kg x HM x VM x DM x AM x FM x CM`, lifting index `= load / RWL`.
//!
//! The equation is for manual lifting with *both hands*. A hand that guides a part held by a robot is
//! outside it; [`LiftCondition`]s say so beside every figure, the figure is not withheld.

mod composite;
mod path;

pub use composite::{CompositeLift, CompositeStep, LiftShare, composite_lift};
pub use path::{PathLift, lift_from_path};

use serde::{Deserialize, Serialize};

/// Where formulas, tables and worked examples were checked; for reports.
pub const NIOSH_PROVENANCE: &str = "Revised NIOSH lifting equation (Waters et al. 1993; manual 94-110): \
     formulas, limits and rules checked against a page-by-page summary of the 2021 manual, tables 5 \
     and 7 against two independent transcriptions, not against the printed pages.";

/// Load constant, kg.
pub const LOAD_CONSTANT_KG: f64 = 23.0;

/// Where the hands are at one end of a lift.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LiftPoint {
    /// `H`: horizontal distance of the hands from the point midway between the ankles, cm.
    pub horizontal_cm: f64,
    /// `V`: height of the hands above the floor, cm.
    pub vertical_cm: f64,
    /// `A`: angle from the mid-sagittal plane to the line from ankles to hands, deg, 0-180.
    pub asymmetry_deg: f64,
}

/// How long lifting goes on before light work (manual, section 1.3.5.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftDuration {
    /// Up to 1 h, then as much recovery as work.
    Short,
    /// Up to 2 h, then recovery of 0.3 of the work.
    Moderate,
    /// Up to 8 h with the usual breaks.
    Long,
}

impl LiftDuration {
    /// The class of a duration in hours; `None` above 8 h, for which there are no limits, or for a
    /// number that is no duration.
    pub fn from_hours(hours: f64) -> Option<Self> {
        match hours {
            h if h < 0.0 => None,
            h if h <= 1.0 => Some(Self::Short),
            h if h <= 2.0 => Some(Self::Moderate),
            h if h <= 8.0 => Some(Self::Long),
            _ => None,
        }
    }
}

/// Quality of the grip (manual, table 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftCoupling {
    /// Optimal handles, or a loose part that the hand wraps around.
    Good,
    /// Handles less than optimal, or fingers bent 90 deg under the box.
    Fair,
    /// Bulky, slippery, hard to hold.
    Poor,
}

impl LiftCoupling {
    /// By REBA's class, 0 good to 3 unacceptable.
    pub fn from_reba_class(class: u8) -> Self {
        match class {
            0 => Self::Good,
            1 => Self::Fair,
            _ => Self::Poor,
        }
    }
}

/// What the path does not show.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LiftTask {
    /// Load on the hands, kg.
    pub load_kg: f64,
    /// Lifts a minute, averaged over 15 min; below 0.2 counts as 0.2.
    pub lifts_per_min: f64,
    /// How long lifting goes on.
    pub duration: LiftDuration,
    /// Quality of the grip.
    pub coupling: LiftCoupling,
    /// The load is placed with care, held or gripped anew at the destination: then that end counts
    /// too.
    pub control_at_destination: bool,
}

/// The six multipliers, each 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LiftMultipliers {
    /// `HM = 25 / H`.
    pub horizontal: f64,
    /// `VM = 1 - 0.003 |V - 75|`.
    pub vertical: f64,
    /// `DM = 0.82 + 4.5 / D`.
    pub distance: f64,
    /// `AM = 1 - 0.0032 A`.
    pub asymmetry: f64,
    /// `FM`, table 5.
    pub frequency: f64,
    /// `CM`, table 7.
    pub coupling: f64,
}

impl LiftMultipliers {
    /// Their product.
    pub fn product(&self) -> f64 {
        self.horizontal
            * self.vertical
            * self.distance
            * self.asymmetry
            * self.frequency
            * self.coupling
    }
}

/// The limit at one end of the lift.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LiftLimit {
    /// Where the hands are.
    pub point: LiftPoint,
    /// The multipliers there.
    pub multipliers: LiftMultipliers,
    /// Recommended weight limit, kg.
    pub recommended_kg: f64,
    /// Load over limit; `None` where the limit is 0: no load is acceptable.
    pub lifting_index: Option<f64>,
}

/// A lift by the equation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LiftAssessment {
    /// At the start.
    pub origin: LiftLimit,
    /// At the end; it counts only with control at the destination.
    pub destination: LiftLimit,
    /// Vertical travel `D`, cm, before it is held to 25 cm or more.
    pub distance_cm: f64,
    /// The limit that counts, kg: the lower one of those that do.
    pub recommended_kg: f64,
    /// Load over the limit that counts; `None` where the limit is 0.
    pub lifting_index: Option<f64>,
    /// What the equation does not see or was bent to.
    pub notes: Vec<LiftNote>,
}

/// Why the equation does not apply (manual, section 1.2), or less than it seems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftCondition {
    /// One hand lifts.
    OneHanded,
    /// Sitting or kneeling.
    SeatedOrKneeling,
    /// A machine carries part of the load: no manual lifting.
    MechanicalHelp,
    /// Carrying, pushing or pulling at the same time.
    CarryingPushingPulling,
    /// Little room for the body.
    RestrictedSpace,
    /// The load's centre moves.
    UnstableLoad,
    /// Faster than 76 cm/s (30 in/s).
    HighSpeed,
}

impl LiftCondition {
    /// What is so, as a clause.
    pub fn why(self) -> &'static str {
        match self {
            Self::OneHanded => "one hand lifts",
            Self::SeatedOrKneeling => "the person sits or kneels",
            Self::MechanicalHelp => "a machine carries part of the load",
            Self::CarryingPushingPulling => "the load is carried, pushed or pulled as well",
            Self::RestrictedSpace => "the work space is restricted",
            Self::UnstableLoad => "the load is unstable",
            Self::HighSpeed => "the hands are faster than 76 cm/s",
        }
    }
}

/// A remark on a lift.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "note", content = "value", rename_all = "snake_case")]
pub enum LiftNote {
    /// The equation does not apply.
    NotApplicable(LiftCondition),
    /// `H` above 63 cm: `HM` is 0. Value: cm.
    TooFar(f64),
    /// `H` below 25 cm counts as 25 cm. Value: cm.
    NearCountsAs25(f64),
    /// `V` above 175 cm or below the floor: `VM` is 0. Value: cm.
    HeightOutside(f64),
    /// `D` above 175 cm: `DM` is 0. Value: cm.
    TooLong(f64),
    /// `D` below 25 cm counts as 25 cm. Value: cm.
    ShortCountsAs25(f64),
    /// `A` above 135 deg: `AM` is 0. Value: deg.
    TooAsymmetric(f64),
    /// More lifts a minute than table 5 has: `FM` is 0. Value: lifts/min.
    TooFrequent(f64),
    /// The hands pass this far above the higher end, or below the lower one; only the ends count.
    /// Value: cm.
    PassesBeyondEnds(f64),
}

impl LiftNote {
    /// The remark in one sentence.
    pub fn words(&self) -> String {
        match *self {
            Self::NotApplicable(condition) => {
                format!("The NIOSH equation does not apply: {}.", condition.why())
            }
            Self::TooFar(cm) => format!("Hands {cm:.0} cm from the ankles, above 63 cm: no load."),
            Self::NearCountsAs25(cm) => {
                format!("Hands {cm:.0} cm from the ankles count as 25 cm.")
            }
            Self::HeightOutside(cm) => {
                format!("Hands at {cm:.0} cm above the floor, outside 0 to 175 cm: no load.")
            }
            Self::TooLong(cm) => format!("Vertical travel of {cm:.0} cm, above 175 cm: no load."),
            Self::ShortCountsAs25(cm) => {
                format!("Vertical travel of {cm:.0} cm counts as 25 cm.")
            }
            Self::TooAsymmetric(deg) => {
                format!("Hands {deg:.0} deg out of the mid-sagittal plane, above 135 deg: no load.")
            }
            Self::TooFrequent(f) => format!("{f:.1} lifts a minute are beyond table 5: no load."),
            Self::PassesBeyondEnds(cm) => format!(
                "The hands pass {cm:.0} cm beyond the heights of the two ends, which alone count."
            ),
        }
    }
}

/// Assesses a lift (or a lowering, which counts alike) from its two ends.
///
/// `FM` goes by the height at the *origin* at both ends (manual, section 1.3.5.3), `CM` by the height
/// of the end itself, as in the manual's example 4. `conditions` are passed on as notes. What is not
/// a number makes its multiplier 0.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{LiftCoupling, LiftDuration, LiftPoint, LiftTask, assess_lift};
/// let point = |v| LiftPoint { horizontal_cm: 25.0, vertical_cm: v, asymmetry_deg: 0.0 };
/// let task = LiftTask {
///     load_kg: 11.5,
///     lifts_per_min: 0.2,
///     duration: LiftDuration::Short,
///     coupling: LiftCoupling::Good,
///     control_at_destination: false,
/// };
/// let lift = assess_lift(point(75.0), point(100.0), &task, &[]);
/// assert_eq!(lift.recommended_kg, 23.0);
/// assert_eq!(lift.lifting_index, Some(0.5));
/// ```
pub fn assess_lift(
    origin: LiftPoint,
    destination: LiftPoint,
    task: &LiftTask,
    conditions: &[LiftCondition],
) -> LiftAssessment {
    let distance_cm = (destination.vertical_cm - origin.vertical_cm).abs();
    let frequency =
        frequency_multiplier(task.lifts_per_min, task.duration, origin.vertical_cm >= 75.0);
    let limit = |point: LiftPoint| limit(point, distance_cm, frequency, task);
    let (at_origin, at_destination) = (limit(origin), limit(destination));
    let mut recommended_kg = at_origin.recommended_kg;
    let mut ends = vec![origin];
    if task.control_at_destination {
        recommended_kg = recommended_kg.min(at_destination.recommended_kg);
        ends.push(destination);
    }
    let mut notes: Vec<LiftNote> = conditions.iter().map(|c| LiftNote::NotApplicable(*c)).collect();
    notes.extend(ends.iter().flat_map(point_notes));
    notes.extend(travel_notes(distance_cm, frequency, task.lifts_per_min));
    LiftAssessment {
        origin: at_origin,
        destination: at_destination,
        distance_cm,
        recommended_kg,
        lifting_index: index(task.load_kg, recommended_kg),
        notes,
    }
}

fn limit(point: LiftPoint, distance_cm: f64, frequency: f64, task: &LiftTask) -> LiftLimit {
    let multipliers = LiftMultipliers {
        horizontal: horizontal_multiplier(point.horizontal_cm),
        vertical: vertical_multiplier(point.vertical_cm),
        distance: distance_multiplier(distance_cm),
        asymmetry: asymmetry_multiplier(point.asymmetry_deg),
        frequency,
        coupling: coupling_multiplier(task.coupling, point.vertical_cm >= 75.0),
    };
    let recommended_kg = LOAD_CONSTANT_KG * multipliers.product();
    LiftLimit {
        point,
        multipliers,
        recommended_kg,
        lifting_index: index(task.load_kg, recommended_kg),
    }
}

fn index(load_kg: f64, recommended_kg: f64) -> Option<f64> {
    (recommended_kg > 0.0).then(|| load_kg / recommended_kg)
}

fn point_notes(point: &LiftPoint) -> Vec<LiftNote> {
    let &LiftPoint { horizontal_cm: h, vertical_cm: v, asymmetry_deg: a } = point;
    let mut notes = Vec::new();
    if h < 25.0 {
        notes.push(LiftNote::NearCountsAs25(h));
    } else if horizontal_multiplier(h) == 0.0 {
        notes.push(LiftNote::TooFar(h));
    }
    if vertical_multiplier(v) == 0.0 {
        notes.push(LiftNote::HeightOutside(v));
    }
    if asymmetry_multiplier(a) == 0.0 {
        notes.push(LiftNote::TooAsymmetric(a));
    }
    notes
}

fn travel_notes(distance_cm: f64, frequency: f64, lifts_per_min: f64) -> Vec<LiftNote> {
    let mut notes = Vec::new();
    if distance_cm < 25.0 {
        notes.push(LiftNote::ShortCountsAs25(distance_cm));
    } else if distance_multiplier(distance_cm) == 0.0 {
        notes.push(LiftNote::TooLong(distance_cm));
    }
    if frequency == 0.0 {
        notes.push(LiftNote::TooFrequent(lifts_per_min));
    }
    notes
}

// In the multipliers below a value that is not a number ends up at 0.

fn horizontal_multiplier(h_cm: f64) -> f64 {
    if h_cm <= 63.0 { 25.0 / h_cm.max(25.0) } else { 0.0 }
}

fn vertical_multiplier(v_cm: f64) -> f64 {
    if (0.0..=175.0).contains(&v_cm) { 1.0 - 0.003 * (v_cm - 75.0).abs() } else { 0.0 }
}

fn distance_multiplier(d_cm: f64) -> f64 {
    if d_cm <= 175.0 { 0.82 + 4.5 / d_cm.max(25.0) } else { 0.0 }
}

fn asymmetry_multiplier(a_deg: f64) -> f64 {
    if a_deg.abs() <= 135.0 { 1.0 - 0.0032 * a_deg.abs() } else { 0.0 }
}

fn coupling_multiplier(coupling: LiftCoupling, is_high: bool) -> f64 {
    match (coupling, is_high) {
        (LiftCoupling::Good, _) | (LiftCoupling::Fair, true) => 1.0,
        (LiftCoupling::Fair, false) => 0.95,
        (LiftCoupling::Poor, _) => 0.9,
    }
}

/// Lifts a minute of the rows of table 5.
const FREQUENCIES: [f64; 17] =
    [0.2, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// Table 5 without its zeros. Each column first holds the rows for all heights, then those for hands
/// at 75 cm or above only.
const SHORT: [f64; 17] = [
    1.0, 0.97, 0.94, 0.91, 0.88, 0.84, 0.80, 0.75, 0.70, 0.60, 0.52, 0.45, 0.41, 0.37, 0.34, 0.31,
    0.28,
];
const MODERATE: [f64; 14] =
    [0.95, 0.92, 0.88, 0.84, 0.79, 0.72, 0.60, 0.50, 0.42, 0.35, 0.30, 0.26, 0.23, 0.21];
const LONG: [f64; 12] = [0.85, 0.81, 0.75, 0.65, 0.55, 0.45, 0.35, 0.27, 0.22, 0.18, 0.15, 0.13];

/// Table 5, linear between its rows (manual, section 1.3); 0 beyond the last row that is not 0.
fn frequency_multiplier(per_min: f64, duration: LiftDuration, is_high: bool) -> f64 {
    let (column, low_rows): (&[f64], usize) = match duration {
        LiftDuration::Short => (&SHORT, 14),
        LiftDuration::Moderate => (&MODERATE, 12),
        LiftDuration::Long => (&LONG, 10),
    };
    let rows = if is_high { column.len() } else { low_rows };
    let per_min = if per_min < FREQUENCIES[0] { FREQUENCIES[0] } else { per_min };
    let Some(upper) = FREQUENCIES[..rows].iter().position(|f| per_min <= *f) else { return 0.0 };
    let lower = upper.saturating_sub(1);
    let span = FREQUENCIES[upper] - FREQUENCIES[lower];
    let along = if span > 0.0 { (per_min - FREQUENCIES[lower]) / span } else { 1.0 };
    column[lower] + along * (column[upper] - column[lower])
}

#[cfg(test)]
mod tests;

//! Posture scores of ergonomics: RULA and REBA from body angles, and their distribution over sampled
//! postures.
//!
//! ```text
//! angles    body poses (rotations, points)  ─► TrunkNeckAngles, ArmAngles   (deg)
//! assess    angles + task + Profile         ─► Worksheet ─► RulaSteps, RebaSteps
//! exposure  scores of many rollouts         ─► ScoreDistribution, ActionLevelShare
//! method    the scores that rank and are reported: RULA, REBA
//! paired    two paths, the same people      ─► PairedDifference
//! unpaired  two groups of other people      ─► UnpairedDifference
//! drivers   sheets of many rollouts         ─► StepShare: which step drives the score
//! luba      angles                          ─► LubaScore: discomfort points
//! iso11226, en1005_4  angles                ─► PartZone ─► zones: PartTimes over a series
//! niosh     hands at both ends of a lift    ─► LiftAssessment: recommended weight, lifting index
//! sensitivity  thresholds moved by degrees  ─► ThresholdSensitivity
//! ```
//!
//! RULA: Applied Ergonomics 24(2):91-99, 1993. REBA: Applied Ergonomics 31:201-205, 2000. Both leave
//! angles open (what counts as "abducted", "twisted", "raised"); a [`Profile`] names every such
//! choice, so that a score can be reproduced. Everything here is a pure function; scoring one posture
//! allocates nothing.

mod action_levels;
mod angles;
mod assess;
mod back;
mod drivers;
mod duet;
mod en1005_4;
mod exposure;
mod iso11226;
mod luba;
mod method;
mod niosh;
mod paired;
mod people;
mod profile;
mod reba;
mod rula;
mod rula_continuous;
mod sensitivity;
mod sheets;
mod tables;
mod timeline;
mod unpaired;
mod worksheet;
mod zones;

pub use action_levels::ActionLevelShare;
pub use angles::{
    ArmAngles, ArmPose, BodyPose, Side, TrunkNeckAngles, arm_angles, trunk_neck_angles,
};
pub use assess::{Assessment, TaskInputs, assess, worksheet};
pub use back::{BackAngle, BackExposure, SPINE_JOINTS, back_angle, back_exposure};
pub use drivers::{
    Driver, RebaDriver, RebaStep, RulaStep, StepShare, drivers, reba_drivers, reba_step_courses,
    reba_step_shares, rula_step_courses, rula_step_shares,
};
pub use duet::{DUET_PROVENANCE, duet_damage, duet_probability};
pub use en1005_4::{EN_1005_4_PROVENANCE, PostureUse, en_1005_4};
pub use exposure::{
    BandOverTime, P_AT_LEAST_S, ScoreDistribution, exposure_by_rollout, score_distribution,
    time_means,
};
pub use iso11226::{ISO_11226_PROVENANCE, iso_11226};
pub use luba::{
    LUBA_PROVENANCE, LUBA_REST_DEG, LubaJoint, LubaMotion, LubaPart, LubaPosture, LubaScore, luba,
    luba_category, luba_category_words,
};
pub use method::{PerMethod, ScoringMethod};
pub use niosh::{
    CompositeLift, CompositeStep, LOAD_CONSTANT_KG, LiftAssessment, LiftCondition, LiftCoupling,
    LiftDuration, LiftLimit, LiftMultipliers, LiftNote, LiftPoint, LiftShare, LiftTask,
    NIOSH_PROVENANCE, PathLift, assess_lift, composite_lift, lift_from_path,
};
pub(crate) use paired::t_critical_975;
pub use paired::{FEW_PAIRS, PairedDifference, paired_difference, paired_median_difference};
pub use people::{PeopleSpread, SizeSplit, by_person};
pub use profile::{Profile, UpperArmRule};
pub use reba::{
    REBA_WORST, RebaScores, RebaSteps, reba, reba_action_level, reba_action_words, reba_from_scores,
};
pub use rula::{
    RULA_WORST, RulaScores, RulaSteps, rula, rula_action_level, rula_action_words, rula_from_scores,
};
pub use rula_continuous::{CONTINUOUS_JOINTS, RULA_CONTINUOUS, rula_continuous};
pub use sensitivity::{
    BodyPart, THRESHOLD_MOVE_DEG, ThresholdBand, ThresholdSensitivity, ThresholdShift,
    threshold_sensitivity,
};
pub use sheets::{Sheet, StepOverTime, steps_over_time};
pub use tables::{
    RulaTableA, reba_table_a, reba_table_b, reba_table_c, rula_table_a, rula_table_b, rula_table_c,
};
pub use timeline::{Clock, Hold, PartTimeline, Shown, TimeRules};
pub use unpaired::{UnpairedDifference, unpaired_difference};
pub use worksheet::Worksheet;
pub use zones::{
    PartTimes, PartZone, PostureZone, STATIC_FROM_S, ZoneHold, ZonePart, ZoneSettings, zone_times,
};

//! Posture scores of ergonomics: RULA and REBA from body angles, and their distribution over sampled
//! postures.
//!
//! ```text
//! angles    body poses (rotations, points)  ─► TrunkNeckAngles, ArmAngles   (deg)
//! assess    angles + task + Profile         ─► Worksheet ─► RulaSteps, RebaSteps
//! exposure  scores of many rollouts         ─► ScoreDistribution, PairedDifference
//! ```
//!
//! RULA: Applied Ergonomics 24(2):91-99, 1993. REBA: Applied Ergonomics 31:201-205, 2000. Both leave
//! angles open (what counts as "abducted", "twisted", "raised"); a [`Profile`] names every such
//! choice, so that a score can be reproduced. Everything here is a pure function; scoring one posture
//! allocates nothing.

mod angles;
mod assess;
mod drivers;
mod exposure;
mod profile;
mod reba;
mod rula;
mod tables;
mod timeline;
mod worksheet;

pub use angles::{
    ArmAngles, ArmPose, BodyPose, Side, TrunkNeckAngles, arm_angles, trunk_neck_angles,
};
pub use assess::{Assessment, TaskInputs, assess, worksheet};
pub use drivers::{Driver, RulaStep, drivers};
pub use exposure::{
    BandOverTime, P_AT_LEAST_S, PairedDifference, ScoreDistribution, paired_difference,
    score_distribution,
};
pub use profile::{Profile, UpperArmRule};
pub use reba::{
    REBA_WORST, RebaScores, RebaSteps, reba, reba_action_level, reba_action_words, reba_from_scores,
};
pub use rula::{
    RULA_WORST, RulaScores, RulaSteps, rula, rula_action_level, rula_action_words, rula_from_scores,
};
pub use tables::{
    RulaTableA, reba_table_a, reba_table_b, reba_table_c, rula_table_a, rula_table_b, rula_table_c,
};
pub use timeline::{Clock, Hold, PartTimeline, Shown, TimeRules};
pub use worksheet::Worksheet;

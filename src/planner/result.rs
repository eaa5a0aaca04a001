//! What a run finds, as it is written to `result.json` and shown in the report.
//!
//! Every figure of the report is here. Nothing here depends on time, date, threads or folders.

use super::preset::Preset;
use super::scene::Scene;
use crate::ergonomics::{
    ActionLevelShare, PairedDifference, ScoreDistribution, ThresholdSensitivity,
};
use crate::files::null_as_nan;
use crate::path::{Change, Check, Family};
use crate::posture::MethodQuality;
use crate::robot::{JointMargin, JointTrajectory};
use crate::scenario::{EndMismatch, Origin, Task};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Schema id and version of `result.json`.
pub const RESULT_SCHEMA: &str = "ergopath/result/1";

/// A finished run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunResult {
    /// [`RESULT_SCHEMA`].
    pub schema: Cow<'static, str>,
    /// Where it comes from.
    pub provenance: RunProvenance,
    /// The decision in words.
    pub verdict: Verdict,
    /// All paths: ranked first, then those that are not feasible.
    pub candidates: Vec<CandidateResult>,
    /// The best path against others, on the same people.
    pub comparisons: Vec<Comparison>,
    /// Inputs of the scores and where they come from.
    pub inputs: Vec<InputOrigin>,
    /// The best path's expected scores with the angle thresholds moved, for the body of the verdict.
    pub threshold_sensitivity: Option<ThresholdSensitivity>,
    /// Robot, worker, task and cell in words.
    pub setting: Setting,
    /// The posture model.
    pub posture_model: ModelSummary,
    /// Postures of the best path that a reader wants to see, of the body of the verdict.
    pub moments: Vec<Moment>,
    /// What would lower the score of the best path; none without one.
    pub recommendations: Option<Recommendations>,
    /// What the reader should know.
    pub warnings: Vec<String>,
    /// What is not part of the model.
    pub not_modelled: Vec<String>,
    /// The planner's settings.
    pub planner: Preset,
    /// What was searched.
    pub search: Vec<SearchSummary>,
    /// How far the best path's figures can be trusted; none without a feasible path.
    pub certificate: Option<Certificate>,
    /// The cell, the robot and the people over time, to be looked at.
    pub scene: Scene,
    /// The sampled postures themselves, on request; written to files of their own.
    #[serde(skip)]
    pub rollouts: Vec<RolloutTable>,
}

/// One search of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SearchSummary {
    /// Its name.
    pub name: String,
    /// Paths that it tried.
    pub paths: usize,
    /// Of these, paths that were refused.
    pub infeasible: usize,
}

/// The best path among people that another seed draws (worst body).
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Certificate {
    /// Expected RULA among the reported people.
    #[serde(deserialize_with = "null_as_nan")]
    pub expected_rula: f64,
    /// Expected RULA among as many people of the next seed.
    #[serde(deserialize_with = "null_as_nan")]
    pub expected_rula_other_seed: f64,
    /// Half width of the 95 % interval of their difference.
    #[serde(deserialize_with = "null_as_nan")]
    pub half_width95: f64,
    /// People of each.
    pub people: usize,
}

/// The sampled postures of one body along one path.
#[derive(Debug, Clone)]
pub struct RolloutTable {
    /// Rank of the path.
    pub rank: usize,
    /// Body; none for the first one of the scenario.
    pub other_body: Option<String>,
    /// Joints of the chain, n names.
    pub joints: Vec<String>,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Joint angles, rad: rollouts, times, n. A rollout ends where its reach is exceeded.
    pub q: Vec<Vec<DVector<f64>>>,
}

/// How to make the run again.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunProvenance {
    /// Version of ergopath.
    pub program_version: Cow<'static, str>,
    /// The canonical command.
    pub command: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// (name, SHA-256) of every input.
    pub inputs: Vec<(String, String)>,
    /// The scoring convention.
    pub score_profile: String,
}

/// The decision.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Verdict {
    /// One sentence.
    pub headline: String,
    /// Two to five more.
    pub lines: Vec<String>,
    /// Id of the best feasible path, if there is one.
    pub best: Option<String>,
    /// Where no path is feasible: the smallest change of each kind that would help, alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// "demonstration model, not your workers", when that applies.
    pub caveat: Option<String>,
}

/// One path.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct CandidateResult {
    /// 1 is best; none for a path that is not feasible.
    pub rank: Option<usize>,
    /// Unique name.
    pub id: String,
    /// How it was made.
    pub family: Family,
    /// Feasible, marked (the user's own, over a limit), or why not.
    pub status: Status,
    /// Stage up to which it was evaluated.
    pub evaluated: Evaluated,
    /// What would make a path that is not feasible possible, each alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Via-points, m, world.
    pub vias_m: Vec<[f64; 3]>,
    /// What was chosen besides the path, where the scenario leaves anything free.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub chosen: Vec<String>,
    /// The objective on the block that ranked it.
    pub objective: Option<f64>,
    /// Scores of each body.
    pub bodies: Vec<BodyScores>,
    /// The path itself; only for paths of the selection.
    pub path: Option<PathData>,
    /// Pictures of the mean posture; only for paths of the selection.
    pub poses: Vec<PosePicture>,
    /// The user's own, and not from the scenario's start to its goal: scored, but compared with no
    /// other and neither best nor worst.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<EndMismatch>,
}

/// Whether a path can be used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "kebab-case")]
pub enum Status {
    /// All limits are kept.
    Feasible,
    /// The user's own path breaks a limit; it is scored all the same.
    Marked {
        /// One sentence for each limit.
        violations: Vec<String>,
    },
    /// It cannot be used.
    Infeasible {
        /// "path", "robot", "obstacle", "worker" (out of reach) or "person" (too near).
        stage: String,
        /// Why, in one sentence.
        reason: String,
    },
}

/// How far a path came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evaluated {
    /// Refused before any rollout.
    None,
    /// Scored in the search only: few people, and the figures that chose it.
    Search,
    /// Scored on the reported block.
    Reported,
}

/// Scores of one body along one path.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BodyScores {
    /// Name of the body.
    pub body: String,
    /// How near the robot comes to this person; none without shapes or motion of the robot.
    pub person_clearance: Option<PersonClearance>,
    /// Number of rollouts.
    pub rollouts: usize,
    /// RULA of the coupled side.
    pub rula: ScoreDistribution,
    /// REBA of the coupled side.
    pub reba: ScoreDistribution,
    /// Time and probability at each action level of RULA, 1-4.
    pub rula_levels: Vec<ActionLevelShare>,
    /// Time and probability at each action level of REBA, 0-4.
    pub reba_levels: Vec<ActionLevelShare>,
    /// Time means of RULA of each rollout, in order: for paired comparisons.
    pub rula_by_rollout: Vec<f64>,
    /// Shares of time at RULA 5 or more, by rollout: mean, 5th and 95th percentile.
    pub exposure_rula_5_band: [f64; 3],
    /// RULA of the other side where the scenario gives that arm.
    pub other_side_rula: Option<ScoreDistribution>,
    /// Share of rollouts whose reach was exceeded.
    pub reach_exceeded: f64,
    /// Earliest time at which a reach was exceeded, s.
    pub reach_exceeded_from_s: Option<f64>,
    /// Largest distance of the hand from the path over all rollouts, mm.
    pub hand_residual_max_mm: f64,
    /// Root mean square of that distance, mm.
    #[serde(deserialize_with = "null_as_nan")]
    pub hand_residual_rms_mm: f64,
    /// Largest angle between hand and path, deg.
    pub hand_residual_max_deg: f64,
    /// Share of the samples that the training data do not support.
    pub extrapolation_share: f64,
    /// Share of start postures beyond the 99 % quantile of the training postures.
    pub unusual_starts: f64,
    /// Mean Mahalanobis distance of the start postures.
    #[serde(deserialize_with = "null_as_nan")]
    pub start_distance: f64,
    /// The steps of RULA over people and time.
    pub parts: Vec<PartScore>,
    /// The steps of REBA over people and time.
    pub reba_parts: Vec<PartScore>,
}

/// How near the robot comes to one person over the repetitions, the coupled hand and forearm at the
/// robot's wrist excepted. A planning margin, not a safety function.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PersonClearance {
    /// Repetitions that were looked at.
    pub repetitions: usize,
    /// Distance that is to be kept, m.
    pub margin_m: f64,
    /// Share of repetitions that may come nearer.
    pub share_allowed: f64,
    /// Share that does, at any moment.
    pub share_below: f64,
    /// Least distance over repetitions and time, m; below zero the capsules overlap.
    pub min_m: f64,
    /// 5th percentile over repetitions of the least distance over time, m.
    pub p05_m: f64,
    /// Link of the robot at the least distance.
    pub link: String,
    /// Body part there.
    pub body_part: String,
    /// When, s.
    pub time_s: f64,
}

impl PersonClearance {
    /// Whether the constraint is kept.
    pub fn is_kept(&self) -> bool {
        self.share_below <= self.share_allowed
    }

    /// All of it in one sentence.
    pub fn sentence(&self) -> String {
        format!(
            "nearest {:.0} mm (link `{}` and the {} at {:.2} s), 5th percentile {:.0} mm; {:.1} % of {} \
             repetitions nearer than {:.0} mm, {:.1} % allowed",
            1e3 * self.min_m,
            self.link,
            self.body_part,
            self.time_s,
            1e3 * self.p05_m,
            100.0 * self.share_below,
            self.repetitions,
            1e3 * self.margin_m,
            100.0 * self.share_allowed
        )
    }
}

/// One body part's share in the score.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PartScore {
    /// Name of the step.
    pub part: Cow<'static, str>,
    /// Mean step score.
    pub mean: f64,
    /// Drop of the expected total if this step alone were at its lowest.
    pub drives: f64,
    /// Monte Carlo standard error of `drives`; none for a single rollout.
    pub drives_se: Option<f64>,
    /// Share of the time at which the total would be lower with this step at its lowest.
    pub drives_share: f64,
    /// Mean score at each time of the path, to three decimals; of RULA only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub over_time: Vec<f64>,
}

/// A path over time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PathData {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// TCP in the world: x, y, z (m), qw, qx, qy, qz.
    pub tcp: Vec<[f64; 7]>,
    /// Names of the robot's joints.
    pub robot_joints: Vec<String>,
    /// Robot joint angles, rad; empty when the robot cannot follow.
    pub robot_q: Vec<Vec<f64>>,
    /// Limits of the TCP with value and margin.
    pub checks: Vec<Check>,
    /// The robot's closest approaches to its limits, in words.
    pub robot_checks: Vec<String>,
    /// Margins of the robot's joints between the points of the exported trajectory.
    pub joint_margins: Vec<JointMargin>,
    /// The robot's motion for its controller; written to files of its own.
    #[serde(skip)]
    pub joint_trajectory: Option<JointTrajectory>,
    /// Smallest clearance to an obstacle, m, with what meets what.
    pub clearance: Option<(f64, String)>,
    /// Smallest distance of the arm to itself in words, or why it was not checked.
    pub self_clearance: String,
    /// How far the QP moved the path, m.
    pub moved_m: f64,
}

/// The mean posture and the robot at one moment, as line segments in the world, m.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PosePicture {
    /// Body.
    pub body: String,
    /// Time, s.
    pub time_s: f64,
    /// Bones of the person.
    pub bones: Vec<[[f64; 3]; 2]>,
    /// Joint origins of the robot, base to TCP.
    pub robot: Vec<[f64; 3]>,
}

/// The best path against another, paired over people.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Comparison {
    /// Id of the best path.
    pub best: String,
    /// Id of the other.
    pub other: String,
    /// Body.
    pub body: String,
    /// Difference of the expected RULA, best minus other.
    pub rula: PairedDifference,
    /// The same in one sentence.
    pub words: String,
}

/// One input of the scores.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct InputOrigin {
    /// What.
    pub input: String,
    /// Where from.
    pub origin: Origin,
    /// Its value in words.
    pub value: String,
    /// What "one class worse" would be, and the change of expected RULA and REBA.
    pub if_changed: Option<IfChanged>,
}

/// Sensitivity to an assumed input.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct IfChanged {
    /// The other value.
    pub to: String,
    /// Change of the expected RULA.
    pub rula: f64,
    /// Change of the expected REBA.
    pub reba: f64,
}

/// The cell in words and numbers.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Setting {
    /// Scenario name.
    pub name: String,
    /// Scenario description.
    pub description: String,
    /// Bodies: name, sex, stature (m), mass (kg).
    pub bodies: Vec<String>,
    /// Side, stance, place, hold.
    pub worker: Vec<String>,
    /// Robot and what is assumed of it.
    pub robot: Vec<String>,
    /// Limits that are defaults.
    pub assumed_limits: Vec<String>,
    /// The task.
    pub task: Task,
    /// Duration, s.
    pub duration_s: f64,
    /// Where the TCP starts, world, m.
    pub start_m: [f64; 3],
    /// Where it ends, world, m.
    pub goal_m: [f64; 3],
    /// Forward direction of the worker in the world (x, y), for drawings.
    pub facing: [f64; 2],
    /// Obstacles as boxes that bound them, for drawings: name, lower and upper corner, m.
    pub obstacles: Vec<(String, [f64; 3], [f64; 3])>,
}

/// The posture model in words and numbers.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ModelSummary {
    /// Its name.
    pub name: String,
    /// Its method.
    pub method: Cow<'static, str>,
    /// Simulated operator?
    pub simulated: bool,
    /// The body on which it was learned, and those to which it is applied.
    pub learned_on: String,
    /// Share of W by joint group.
    pub weight_by_group: Vec<(String, f64)>,
    /// Held-out quality.
    pub quality: Vec<MethodQuality>,
    /// Remarks of the training.
    pub notes: Vec<String>,
}

/// One posture of one repetition.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Moment {
    /// What it shows.
    pub what: String,
    /// Body.
    pub body: String,
    /// Number of the repetition, from 0.
    pub repetition: usize,
    /// When, s.
    pub time_s: f64,
    /// For how long it is held, s; of the longest hold only.
    pub held_s: Option<f64>,
    /// RULA at that moment.
    pub rula: u8,
    /// REBA at that moment.
    pub reba: u8,
    /// Body angles by name, deg.
    pub angles_deg: Vec<(String, f64)>,
    /// Bones of the person, world, m.
    pub bones: Vec<[[f64; 3]; 2]>,
}

/// Changes that were tried on the best path, its body of the verdict and the same people.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recommendations {
    /// Number of changes that were tried.
    pub tried: usize,
    /// People behind each.
    pub people: usize,
    /// Those that clearly lower expected RULA, best first; of each direction the best step.
    pub clear: Vec<Recommendation>,
}

/// A change with its effect.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recommendation {
    /// What to do.
    pub what: String,
    /// Expected RULA with the change minus without.
    pub rula: PairedDifference,
    /// Expected RULA without and with it.
    pub expected_rula: [f64; 2],
    /// Expected REBA without and with it.
    pub expected_reba: [f64; 2],
    /// Share of time at RULA 5 or more without and with it.
    pub exposure_rula_5: [f64; 2],
}

//! What a run finds, as it is written to `result.json` and shown in the report.
//!
//! Every figure of the report is here. Nothing here depends on time, date, threads or folders.

use super::checked::Checked;
use super::findings::{Figure, Finding};
use super::preset::Preset;
use super::refusal::{Hint, RefusedGroup, Status};
use super::scene::{PosedMannequin, Scene};
use crate::ergonomics::{
    ActionLevelShare, LiftAssessment, PairedDifference, PeopleSpread, PerMethod, ScoreDistribution,
    ScoringMethod, SizeSplit, ThresholdSensitivity, by_person, paired_difference,
};
use crate::files::null_as_nan;
use crate::human::{BodySize, Hands, Stance};
use crate::path::{Change, Check, End, Family};
use crate::posture::{Hold, MethodQuality};
use crate::robot::{
    JointMargin, JointTrajectory, ObstacleClearance, RobotFacts, RobotMargins, SelfClearance,
};
use crate::scenario::{Chosen, EndMismatch, MeshFacts, Origin, OtherArm, Task, Warning};
use crate::survey::NeckRule;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Schema id and version of `result.json`.
pub const RESULT_SCHEMA: &str = "ergopath/result/2";

/// A finished run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RunResult {
    /// [`RESULT_SCHEMA`].
    pub schema: Cow<'static, str>,
    /// Where it comes from.
    pub provenance: RunProvenance,
    /// The decision.
    pub verdict: Verdict,
    /// All paths: ranked first, then those that are not feasible.
    pub candidates: Vec<CandidateResult>,
    /// The best path against others, on the same repetitions.
    pub comparisons: Vec<Comparison>,
    /// Inputs of the scores and where they come from.
    pub inputs: Vec<InputOrigin>,
    /// The best path's expected scores with the angle thresholds moved, for the body of the verdict.
    pub threshold_sensitivity: Option<ThresholdSensitivity>,
    /// Robot, worker, task and cell.
    pub setting: Setting,
    /// The posture model.
    pub posture_model: ModelSummary,
    /// Postures of the best path that a reader wants to see, of the body of the verdict.
    pub moments: Vec<Moment>,
    /// What would lower the score of the best path; none without one.
    pub recommendations: Option<Recommendations>,
    /// What the reader should know.
    pub warnings: Vec<Warning>,
    /// What is not part of the model.
    pub not_modelled: Vec<NotModelled>,
    /// The planner's settings.
    pub planner: Preset,
    /// What was searched.
    pub search: Vec<SearchSummary>,
    /// The cell, the robot and the worker over time, to be looked at.
    pub scene: Scene,
    /// Where no path was scored: the first body and the robot at start and goal, to be looked at.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ends: Vec<PosePicture>,
    /// The sampled postures themselves, on request; written to files of their own.
    #[serde(skip)]
    pub rollouts: Vec<RolloutTable>,
}

impl RunResult {
    /// Whether there is a best path that by a method of the objective is lower than the straight one beyond chance, or
    /// is that one itself.
    pub fn has_clear_best(&self) -> bool {
        let objective = &self.planner.objective;
        let is_lowered = |m: ScoringMethod| objective.weights(m).all() != [0.0; 4];
        let is_lower = |g: &Gain| {
            let parts = g.scores.iter().filter(|(m, _)| is_lowered(*m));
            parts.map(|(_, s)| &s.together).any(|d| d.clear && d.mean > 0.0)
        };
        let verdict = &self.verdict;
        verdict.outcome == Decision::Best && verdict.gain.as_ref().is_none_or(is_lower)
    }
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

/// The sampled postures of one body along one path.
#[derive(Debug, Clone)]
pub struct RolloutTable {
    /// Rank of the path.
    pub rank: usize,
    /// Body; none for the first one of the scenario.
    pub other_body: Option<String>,
    /// Columns of the whole body: place (m) and turn of the pelvis from rest, joint angles (rad).
    pub columns: Vec<String>,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Their values: rollouts, times, columns. A rollout ends where its reach is exceeded.
    pub q: Vec<Vec<Vec<f64>>>,
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

/// The decision, as facts.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Verdict {
    /// What kind of decision it is.
    pub outcome: Decision,
    /// Id of the best feasible path; none where there is no feasible one, or where the recordings do
    /// not support a decision.
    pub best: Option<String>,
    /// Id of the path that the figures are about: the best, or else the first that was scored.
    pub lead: Option<String>,
    /// Name of the body that the figures are about: the one that is worst in the objective on the
    /// lead.
    pub body: Option<String>,
    /// What the best path gains over the straight one.
    pub gain: Option<Gain>,
    /// What else was found, in the order of its weight.
    pub findings: Vec<Finding>,
    /// Where no path is feasible: the smallest change of each kind that would help, alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Where no path is feasible: the refusals by kind, the most frequent first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<RefusedGroup>,
    /// Where no path is feasible: what may help, and what the reader should know.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<Hint>,
    /// What the posture model is not.
    pub caveat: Option<Caveat>,
}

impl Verdict {
    /// Whether the figures of the lead may be used: there is a best path, or a feasible one of the
    /// user's was assessed.
    pub fn is_decided(&self) -> bool {
        matches!(self.outcome, Decision::Best | Decision::Assessed)
    }
}

/// Kinds of decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    /// There is a best path.
    Best,
    /// The user's own paths were scored, and none was searched.
    Assessed,
    /// Paths are feasible, but the recordings support no statement about the worker along them.
    NotSupported,
    /// No path keeps all limits.
    NothingFeasible,
}

/// Why a posture model does not speak of the worker concerned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Caveat {
    /// Made from simulated movements.
    DemonstrationModel,
    /// Learned from several people, who are not the workers.
    RecordedPeople {
        /// How many.
        count: usize,
    },
    /// Learned from several people, and adapted to one worker.
    Adapted {
        /// How many people.
        count: usize,
        /// How long the worker was recorded, s.
        seconds: f64,
    },
    /// Learned from one person whose hips and knees were not recorded but filled in from several others.
    FilledLegs {
        /// How many others.
        count: usize,
    },
    /// Learned from one person of another size.
    OtherBody,
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
    pub chosen: Vec<Chosen>,
    /// Where it departs most from the straight line; none without a path.
    pub bend: Option<Bend>,
    /// How its timing differs from that of the straight path; none without one.
    pub timing: Option<TimingDifference>,
    /// It keeps another timing than the straight path although the timing is not free, so that a lower
    /// mean may be for that reason alone: it is not the best.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub other_timing: bool,
    /// Why a path with a lower objective than the best is not the best.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bought: Vec<Bought>,
    /// The objective on the block that ranked it.
    pub objective: Option<f64>,
    /// Scores of each body.
    pub bodies: Vec<BodyScores>,
    /// What it was checked for; only for paths of the selection.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checklist: Vec<Checked>,
    /// The path itself; only for paths of the selection.
    pub path: Option<PathData>,
    /// Pictures of the mean posture; only for paths of the selection.
    pub poses: Vec<PosePicture>,
    /// The user's own, and not from the scenario's start to its goal: scored, but compared with no
    /// other and neither best nor worst.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<EndMismatch>,
}

/// Where a path departs most from the straight line between its ends, as the worker sees it, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bend {
    /// Horizontally towards the worker.
    pub toward_body_m: f64,
    /// To the worker's left, facing the path.
    pub left_m: f64,
    /// Upwards.
    pub up_m: f64,
}

/// What a lower mean score is bought with: it is clearly worse than on the straight path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bought {
    /// Which figure.
    pub with: Price,
    /// By which method.
    pub method: ScoringMethod,
    /// This path minus the straight one.
    pub difference: PairedDifference,
}

/// A figure in which the best path may not be worse than the straight one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Price {
    /// The peak over time.
    Peak,
    /// The mean over hand travel.
    PerMetre,
}

/// How far a path came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Evaluated {
    /// Refused before any rollout.
    None,
    /// Scored in the search only: few repetitions, and the figures that chose it.
    Search,
    /// Scored on the reported block.
    Reported,
}

impl Figure {
    /// The figure of one body.
    pub fn of(self, scores: &MethodScores) -> f64 {
        match self {
            Self::Expected => scores.distribution.expected,
            Self::High => scores.high_band[0],
            Self::Peak => scores.peak,
        }
    }
}

/// Scores of one body along one path.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BodyScores {
    /// Name of the body.
    pub body: String,
    /// The part of the objective that differs between bodies.
    pub objective: f64,
    /// How near the robot comes to this person; none without shapes or motion of the robot.
    pub person_clearance: Option<PersonClearance>,
    /// Who is worst off among people who repeat; none where nobody does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_off: Option<WorstOff>,
    /// Of a population: how people's mean RULA goes with the size of their bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_size: Option<OfSize>,
    /// What the whole body does; none where no repetition begins.
    #[serde(default)]
    pub strain: Option<BodyStrain>,
    /// Number of rollouts.
    pub rollouts: usize,
    /// Scores of the coupled side.
    #[serde(flatten)]
    pub scores: PerMethod<MethodScores>,
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
}

impl BodyScores {
    /// RULA of the coupled side, which leads the verdict.
    pub fn rula(&self) -> &MethodScores {
        &self.scores[ScoringMethod::Rula]
    }

    /// REBA of the coupled side.
    pub fn reba(&self) -> &MethodScores {
        &self.scores[ScoringMethod::Reba]
    }
}

/// How people's mean RULA goes with the size of their bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OfSize {
    /// Rank correlation with their statures.
    pub with_stature: f64,
    /// What of the spread goes with stature, mass and sex, and what remains.
    #[serde(flatten)]
    pub split: SizeSplit,
}

/// The person with the highest mean RULA among those who repeat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstOff {
    /// Number of the person, from 1.
    pub person: usize,
    /// Of a population: this person's size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<BodySize>,
    /// Mean RULA of this person's repetitions.
    pub score: f64,
    /// Mean angles that differ most from those of all people: which, and by how many degrees.
    pub departs: Vec<(Moved, f64)>,
}

/// What people do more or less of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Moved {
    /// Bend the trunk forward.
    Trunk,
    /// Raise the upper arm.
    UpperArm,
    /// Bend the elbow.
    Elbow,
    /// Bend the neck forward.
    Neck,
    /// Bend the knees.
    Knees,
}

impl Moved {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Trunk, Self::UpperArm, Self::Elbow, Self::Neck, Self::Knees];
}

/// Scores of one body along one path by one method.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MethodScores {
    /// Over repetitions and time.
    #[serde(flatten)]
    pub distribution: ScoreDistribution,
    /// Time and probability at each action level.
    pub levels: Vec<ActionLevelShare>,
    /// How people differ; none where nobody repeats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub people: Option<PeopleSpread>,
    /// Shares of time at action level 3 or above, by repetition: mean, 5th and 95th percentile.
    pub high_band: [f64; 3],
    /// Mean over hand travel and repetitions; it does not depend on the timing.
    pub per_metre: f64,
    /// 95th percentile over time, median over repetitions.
    pub peak: f64,
    /// Time mean of each repetition, in order: for paired comparisons.
    pub by_rollout: Vec<f64>,
    /// Mean over hand travel of each repetition.
    pub per_metre_by_rollout: Vec<f64>,
    /// 95th percentile over time of each repetition.
    pub peak_by_rollout: Vec<f64>,
    /// The steps of the method over repetitions and time.
    pub parts: Vec<PartScore>,
}

impl MethodScores {
    /// How many people repeat in turn; none where every repetition counts alone.
    pub fn persons(&self) -> Option<usize> {
        self.people.as_ref().map(|p| p.persons)
    }

    /// Less those of another path on the same repetitions, by what is picked.
    pub fn less(&self, other: &Self, pick: fn(&Self) -> &Vec<f64>) -> PairedDifference {
        let of = |s: &Self| by_person(pick(s), self.persons());
        paired_difference(&of(self), &of(other))
    }
}

/// What the whole body does along a path; each figure over repetitions.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BodyStrain {
    /// Largest flexion of the trunk to the vertical, deg.
    pub trunk_flexion_deg: Spread,
    /// Largest flexion of a knee, deg; none where the pelvis rests, as the other figures of the legs.
    pub knee_flexion_deg: Option<Spread>,
    /// Ways of doing it that are told apart; empty where there is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<ModeShare>,
    /// Share of repetitions in which a knee passes 60 deg.
    pub bent_knees_share: Option<f64>,
    /// Share of repetitions in which both heels rise.
    pub raised_heels_share: Option<f64>,
    /// Least distance of the centre of mass from the edge of the feet, m.
    pub balance_margin_m: Option<Spread>,
    /// Largest static moment about L5/S1 by the body above it and the load, N m.
    pub l5s1_peak_nm: Spread,
    /// Mean of that moment over time, N m.
    pub l5s1_mean_nm: Spread,
    /// The revised NIOSH lifting equation; none but for both hands.
    pub niosh: Option<LiftAssessment>,
    /// Share of repetitions that reach only just, or not at all: the hand does not follow, the centre of mass
    /// comes to the edge of the feet, or the hand goes where recorded people would not have it from their feet.
    /// People step there. None where the feet may be set anew, and of a pelvis that does not move.
    pub stretched_share: Option<f64>,
    /// How the feet are set anew; none where they must stay.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<StepsTaken>,
    /// The body against the obstacles; none where there are none.
    pub furniture: Option<FurnitureClearance>,
}

/// How the feet are set anew, over the repetitions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepsTaken {
    /// Share of repetitions that step during the movement.
    pub share: f64,
    /// Share that do not even start where the scenario has the feet.
    pub elsewhere_share: f64,
    /// Number of steps.
    pub number: Spread,
    /// How far the feet go in all steps together, m.
    pub way_m: Spread,
    /// How many recorded movements tell where people stand.
    pub movements: usize,
    /// Of how many people.
    pub people: usize,
}

/// How often people go about it in one way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeShare {
    /// Mean inclination of the trunk of recorded people where their hand was lowest, deg.
    pub trunk_deg: f64,
    /// Mean flexion of their knees there, deg.
    pub knees_deg: f64,
    /// Share of people's movements there.
    pub share: f64,
    /// Its 5 and 95 % quantile, by how many recorded movements speak of it.
    pub share_90: [f64; 2],
    /// Share of the repetitions.
    pub of_repetitions: f64,
    /// How many recorded movements with the hand near there this rests on.
    pub movements_near: f64,
    /// Of how many low ones in all, and of how many people.
    pub movements: [usize; 2],
}

/// How near the body, but hand and forearm on the handle, comes to the obstacles over the repetitions. The
/// posture model knows no furniture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FurnitureClearance {
    /// Least distance over time, m; negative inside.
    pub distance_m: Spread,
    /// Depth that cushions and clothes explain, m.
    pub soft_m: f64,
    /// Share of repetitions in which a part is deeper inside than that.
    pub share_inside: f64,
    /// Part of the body that comes nearest.
    pub body_part: String,
    /// Obstacle to which.
    pub obstacle: String,
    /// When, s.
    pub time_s: f64,
}

/// A figure over repetitions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 5th percentile.
    pub p05: f64,
    /// 95th percentile.
    pub p95: f64,
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
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
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
    /// The robot's closest approaches to its limits; none when it cannot follow.
    pub robot_margins: Option<RobotMargins>,
    /// Margins of the robot's joints between the points of the exported trajectory.
    pub joint_margins: Vec<JointMargin>,
    /// The robot's motion for its controller; written to files of its own.
    #[serde(skip)]
    pub joint_trajectory: Option<JointTrajectory>,
    /// Smallest clearance to an obstacle, or why it was not checked.
    pub clearance: ObstacleClearance,
    /// Smallest distance of the arm to itself, or why it was not checked.
    pub self_clearance: SelfClearance,
    /// How far the QP moved the path, m.
    pub moved_m: f64,
    /// How the hand moves along it.
    pub hand: HandMotion,
}

/// How the hand (the origin of its grip) moves along a path.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HandMotion {
    /// Length of its way, m.
    pub travel_m: f64,
    /// Greatest speed, m/s.
    pub speed_m_s: f64,
    /// Greatest acceleration, m/s^2; none where the path does not begin and end at rest, so that it
    /// cannot be told.
    pub acceleration_m_s2: Option<f64>,
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

/// The lead against another path, on the same repetitions.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Comparison {
    /// Id of the lead: the best path, or the user's own that is assessed.
    pub lead: String,
    /// Id of the other.
    pub other: String,
    /// Body.
    pub body: String,
    /// Lead minus other, by scoring method.
    #[serde(flatten)]
    pub scores: PerMethod<Difference>,
    /// Whether both keep the same timing; where they do not, only the scores per metre say which route
    /// is better.
    pub timing: TimingDifference,
}

/// Lead minus other of one scoring method; lower is better.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Difference {
    /// Of the means over time.
    pub time_mean: PairedDifference,
    /// Of the means over hand travel, which do not depend on the timing.
    pub per_metre: PairedDifference,
    /// Of the peaks.
    pub peak: PairedDifference,
}

impl Difference {
    /// Of one body's scores by one method along two paths.
    pub fn between(a: &MethodScores, b: &MethodScores) -> Self {
        Self {
            time_mean: a.less(b, |s| &s.by_rollout),
            per_metre: a.less(b, |s| &s.per_metre_by_rollout),
            peak: a.less(b, |s| &s.peak_by_rollout),
        }
    }
}

/// How the timing of two paths differs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimingDifference {
    /// Largest difference of the share of the way that is covered at equal shares of the time.
    pub progress: f64,
    /// Duration of the one over that of the other.
    pub duration_ratio: f64,
    /// Largest distance of the two routes from each other, m.
    pub route_apart_m: f64,
}

impl TimingDifference {
    /// Largest differences that count as the same timing: what limits and obstacles bend the
    /// minimum-jerk law by (constant speed differs from it by 0.15), and 2 % of the duration.
    pub(super) const PROGRESS: f64 = 0.1;
    const DURATION: f64 = 0.02;
    /// Largest distance of routes that count as one, m.
    const ROUTE_M: f64 = 0.005;

    /// Whether time means of scores may be compared.
    pub fn is_same(&self) -> bool {
        self.progress <= Self::PROGRESS && (self.duration_ratio - 1.0).abs() <= Self::DURATION
    }

    /// Whether both lead the hand along the same line.
    pub fn is_same_route(&self) -> bool {
        self.route_apart_m <= Self::ROUTE_M
    }
}

/// What the best path gains over the straight one, for the body of the verdict: straight minus other,
/// so that more is better.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Gain {
    /// Body.
    pub body: String,
    /// By scoring method.
    #[serde(flatten)]
    pub scores: PerMethod<GainParts>,
}

/// The parts of a gain, each alone against the straight path.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct GainParts {
    /// Of the best path.
    pub together: PairedDifference,
    /// Of the best path that keeps the straight one's timing; none where it was not searched or is not
    /// feasible.
    pub route: Option<PairedDifference>,
    /// Of the straight path with its timing chosen by the same search; none where the timing is not
    /// free.
    pub timing: Option<PairedDifference>,
}

/// One input of the scores.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct InputOrigin {
    /// What.
    pub input: ScoreInput,
    /// Where from.
    pub origin: Origin,
    /// What "one class worse" would be, and what it would change.
    pub if_changed: Option<IfChanged>,
}

/// An input of the scores with its value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "input", content = "value", rename_all = "snake_case")]
pub enum ScoreInput {
    /// Arms of the coupled hands, shoulder girdles and trunk.
    ArmAndTrunk(Hands),
    /// Pelvis and legs: whether they are predicted.
    Legs(bool),
    /// Pelvis and legs, on feet that may be set elsewhere.
    LegsThatStep,
    /// The other arm.
    OtherArm(OtherArm),
    /// How the head is held.
    Neck(NeckRule),
    /// Whether the worker sits with supported feet; else stands on both.
    Seated(bool),
    /// Whether the arm's weight is supported.
    ArmSupported(bool),
    /// Load in the hand, kg, and what it is made of: part, share, extra.
    Load([f64; 4]),
    /// The worker's share of the load.
    LoadShare(f64),
    /// Whether the task is repeated more than four times a minute or held over a minute.
    MuscleUse(bool),
    /// Class of REBA's coupling, 0 good to 3 unacceptable.
    Coupling(u8),
    /// Whether the load is shocking or builds up fast.
    Shock(bool),
}

/// Sensitivity to an assumed input.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct IfChanged {
    /// The other value.
    pub to: Alternative,
    /// Change of the expected score, by method.
    #[serde(flatten)]
    pub change: PerMethod<f64>,
}

/// Another value of an input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "to", content = "value", rename_all = "snake_case")]
pub enum Alternative {
    /// The head held by the other rule.
    Neck(NeckRule),
    /// The weight on one leg.
    OneLeg,
    /// A load in the next class, kg.
    Load(f64),
    /// Repeated more than four times a minute.
    Repeated,
    /// The next class of coupling.
    Coupling(u8),
}

/// The cell.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Setting {
    /// Scenario name.
    pub name: String,
    /// Scenario description.
    pub description: String,
    /// Bodies, the main one first.
    pub bodies: Vec<BodyFacts>,
    /// Who works where.
    pub worker: WorkerFacts,
    /// Robot and what is assumed of it.
    pub robot: RobotFacts,
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
    /// Obstacles that are meshes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<MeshFacts>,
}

/// A body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyFacts {
    /// Name.
    pub name: String,
    /// Size.
    #[serde(flatten)]
    pub size: BodySize,
    /// Sizes of the people for whom it stands; empty where it stands for itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<BodySize>,
}

/// Who works where, and how the hand is led.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorkerFacts {
    /// The coupled hands.
    pub hands: Hands,
    /// Whether the pelvis moves as predicted.
    pub pelvis_moves: bool,
    /// Whether the feet may be set elsewhere.
    #[serde(default)]
    pub may_step: bool,
    /// Standing or seated.
    pub stance: Stance,
    /// Floor point between the feet, below the upright pelvis, world, m.
    pub at_m: [f64; 2],
    /// Forward direction of the pelvis at rest about world z, rad.
    pub facing: f64,
    /// What the robot prescribes of the hand.
    pub hold: Hold,
    /// Where start postures come from.
    pub start: StartKind,
}

/// Where start postures come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// Drawn from the person's own.
    Sampled,
    /// The person's mean.
    Mean,
    /// Given.
    Given,
}

/// What no figure of a run takes into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NotModelled {
    /// Motion of pelvis and legs.
    Legs,
    /// Steps.
    Steps,
    /// How a step is made.
    HowToStep,
    /// Dynamics of body and robot.
    Forces,
    /// Contact: distances are between capsules.
    Contact,
    /// Fatigue and recovery.
    Fatigue,
    /// The time between movements.
    Between,
    /// Conformity with safety standards.
    Safety,
    /// The arm that does not hold on to the robot.
    OtherArm,
}

/// The posture model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ModelSummary {
    /// Its name.
    pub name: String,
    /// Its method.
    pub method: Cow<'static, str>,
    /// Simulated operator?
    pub simulated: bool,
    /// The body on which it was learned.
    pub learned_on: BodyFacts,
    /// Names of the bodies to which it is applied.
    pub applied_to: Vec<String>,
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
    pub what: MomentKind,
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
    /// The person in shape.
    pub mannequin: PosedMannequin,
}

/// What a posture to look at shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MomentKind {
    /// Of the repetition that is nearest to the mean, at the moment of the highest mean score.
    TypicalAtHardest,
    /// The posture that a typical repetition holds longest.
    HeldLongest,
    /// The highest score of all repetitions.
    Hardest,
}

/// Changes that were tried on the best path, its body of the verdict and the same repetitions.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recommendations {
    /// Number of changes that were tried.
    pub tried: usize,
    /// Repetitions behind each.
    pub repetitions: usize,
    /// Those that clearly lower expected RULA and clearly raise no other score, best first; of each direction the best step.
    pub clear: Vec<Recommendation>,
    /// Another standing place, where people would step.
    pub standing: Option<StandingPlace>,
}

/// A standing place from which fewer repetitions reach only just.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StandingPlace {
    /// Which way the worker would step.
    pub way: Way,
    /// How far, m.
    pub by_m: f64,
    /// Share of repetitions that reach only just, now and there.
    pub stretched_share: [f64; 2],
}

/// A change with its effect, by scoring method.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recommendation {
    /// What to do.
    pub what: CellChange,
    /// Its effect.
    #[serde(flatten)]
    pub effect: PerMethod<Effect>,
    /// Largest static moment about L5/S1 without and with it, mean over repetitions, N m; none where the
    /// load changes.
    pub l5s1_peak_nm: Option<[f64; 2]>,
}

/// What a change does to one score.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Effect {
    /// Expected score with the change minus without.
    pub change: PairedDifference,
    /// Expected score without and with it.
    pub expected: [f64; 2],
    /// Share of time at action level 3 or above without and with it.
    pub high: [f64; 2],
}

/// A small change of the cell with path and robot as they are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "change", rename_all = "snake_case")]
pub enum CellChange {
    /// Another place of the worker, as the worker sees it.
    MoveWorker {
        /// Which way.
        way: Way,
        /// How far, m.
        by_m: f64,
        /// Whether the worker sits.
        seated: bool,
    },
    /// The worker (or the seat) higher over the floor; negative: the cell higher, or the seat lower.
    RaiseWorker {
        /// By how much, m.
        by_m: f64,
        /// Whether the worker sits.
        seated: bool,
    },
    /// An end of the movement higher; negative: lower. The path is bent with it.
    RaiseEnd {
        /// Which end.
        end: End,
        /// By how much, m.
        by_m: f64,
    },
    /// The worker turned about the vertical; positive to the left.
    TurnWorker {
        /// By how much, rad.
        by_rad: f64,
    },
    /// The handle turned about its bar.
    TurnHandle {
        /// By how much, rad.
        by_rad: f64,
    },
    /// Half of the load carried by the robot.
    HalveLoad {
        /// The load now, kg.
        load_kg: f64,
    },
}

/// A direction as the worker sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Forward.
    Nearer,
    /// Backward.
    Farther,
    /// To the left.
    Left,
    /// To the right.
    Right,
}

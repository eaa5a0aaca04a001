//! What a shift comes to, as it is written to `shift.json` and shown.

use super::exertion::ExertionDose;
use super::file::Order;
use super::lifting::LiftingDose;
use crate::ergonomics::PerMethod;
use crate::human::{BodySize, Hands};
use crate::planner::{Apart, Caveat};
use serde::Serialize;

/// Schema id and version of `shift.json`.
pub const SHIFT_RESULT_SCHEMA: &str = "ergopath/shift-result/1";

/// A shift in figures.
#[derive(Debug, Clone, Serialize)]
pub struct ShiftResult {
    /// [`SHIFT_RESULT_SCHEMA`].
    pub schema: &'static str,
    /// Version of the program.
    pub program_version: &'static str,
    /// Name of the shift.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// How the tasks follow each other, if given.
    pub order: Option<Order>,
    /// Where the time goes.
    pub time: ShiftTime,
    /// The tasks as they stand in the file.
    pub tasks: Vec<TaskFacts>,
    /// The dose of each body that all tasks know.
    pub bodies: Vec<BodyDose>,
    /// Index of the body with the most time at RULA action level 3 or above.
    pub worst: usize,
    /// Bodies that some tasks know and others do not.
    pub left_out: Vec<String>,
    /// Tasks whose people are not those of the first task with people.
    pub apart: Vec<TaskApart>,
    /// Lifting, for the worst body.
    pub lifting: LiftingDose,
    /// Hand exertions; none where no task is rated.
    pub exertion: Option<ExertionDose>,
    /// What was assumed, and what the reader should know.
    pub notes: Vec<ShiftNote>,
    /// (name, SHA-256) of the shift file and every result.
    pub inputs: Vec<(String, String)>,
}

/// Where the time of a shift goes, min.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShiftTime {
    /// All of it.
    pub shift_min: f64,
    /// Breaks.
    pub breaks_min: f64,
    /// In the movements that were scored.
    pub scored_min: f64,
    /// On the tasks, between their movements: not scored.
    pub between_min: f64,
    /// Working time that no task takes: not scored.
    pub other_min: f64,
}

impl ShiftTime {
    /// Share of the shift that is a break.
    pub fn break_share(&self) -> f64 {
        self.breaks_min / self.shift_min
    }

    /// Working time that was not scored, min.
    pub fn unscored_min(&self) -> f64 {
        self.between_min + self.other_min
    }
}

/// One task.
#[derive(Debug, Clone, Serialize)]
pub struct TaskFacts {
    /// Its name.
    pub name: String,
    /// The result as it was typed.
    pub result: String,
    /// Id of the path; none of a scored motion.
    pub path: Option<String>,
    /// Scenario, or the file of a scored motion.
    pub source: String,
    /// What was scored.
    pub kind: TaskKind,
    /// The hands at work.
    pub hands: Hands,
    /// Load on the hands, kg; none of a scored motion.
    pub load_kg: Option<f64>,
    /// Duration of one movement, s.
    pub duration_s: f64,
    /// How often it is made.
    pub cycles: f64,
    /// Time that goes to the task, min.
    pub minutes: f64,
    /// Of it in the movement, min.
    pub moving_min: f64,
    /// What the posture model is not.
    pub caveat: Option<Caveat>,
}

/// What was scored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    /// A path that was planned or assessed.
    Path,
    /// One recorded or given motion.
    Motion,
    /// Sampled postures.
    Sampled,
}

/// The dose of one body.
#[derive(Debug, Clone, Serialize)]
pub struct BodyDose {
    /// Its name.
    pub body: String,
    /// What the bands are over.
    pub units: Units,
    /// By scoring method.
    #[serde(flatten)]
    pub methods: PerMethod<MethodDose>,
    /// Who is worst off; none where people do not repeat, or are not the same in all tasks.
    pub worst_person: Option<WorstPerson>,
}

/// What a band is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "over", content = "count")]
pub enum Units {
    /// The same people in all tasks, each with the mean of their repetitions.
    People(usize),
    /// Repetitions of one person, the same in all tasks, as if each was kept up all shift.
    Repetitions(usize),
    /// Different people or repetitions in the tasks, in any combination.
    Independent,
    /// Nothing: every task was measured once.
    Nothing,
}

/// The person with the most time at RULA action level 3 or above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorstPerson {
    /// Number of the person, from 1.
    pub person: usize,
    /// Of how many.
    pub of: usize,
    /// Of a population: this person's size.
    pub size: Option<BodySize>,
    /// Time at that level or above, min.
    pub high_min: f64,
}

/// Time by the action levels of one method.
#[derive(Debug, Clone, Serialize)]
pub struct MethodDose {
    /// The levels from the lowest.
    pub levels: Vec<LevelDose>,
    /// Time at action level 3 or above.
    pub high: Dose,
    /// What each task gives of it, in the order of the tasks.
    pub tasks: Vec<TaskDose>,
    /// Index of the task that gives most; none where there is no such time.
    pub most: Option<usize>,
}

/// Time at one action level.
#[derive(Debug, Clone, Serialize)]
pub struct LevelDose {
    /// The level.
    pub level: u8,
    /// What it asks for.
    pub words: &'static str,
    /// Time at exactly this level, mean, min.
    pub at_min: f64,
    /// Time at this level or above.
    pub at_least: Dose,
}

/// Minutes with their spread.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Dose {
    /// Mean.
    pub mean_min: f64,
    /// 95 % interval of the mean; none where nothing is known of the spread.
    pub interval95_min: Option<[f64; 2]>,
    /// 5th and 95th percentile over people or repetitions; none where nothing is known of the spread.
    pub band90_min: Option<[f64; 2]>,
}

/// One task's part of a body's time at action level 3 or above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TaskDose {
    /// Minutes.
    pub high: Dose,
    /// Share of the movement's time.
    pub share_of_movement: f64,
    /// Share of the shift's time at that level; 0 where there is none.
    pub share_of_high: f64,
    /// Mean minutes at each level from the lowest.
    pub at_min: [f64; 5],
}

/// A task whose people are not those of another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TaskApart {
    /// Index of the task.
    pub task: usize,
    /// Index of the other.
    pub other: usize,
    /// Why.
    pub why: WhyApart,
}

/// Why the people of two tasks are not the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WhyApart {
    /// The runs differ.
    Runs(Apart),
    /// The runs have different numbers of repetitions.
    Counts([usize; 2]),
    /// Sampled postures do not say whose they are.
    Sampled,
}

/// What was assumed, and what the reader should know.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "note", rename_all = "snake_case")]
pub enum ShiftNote {
    /// The movement is repeated without a pause, as nobody said how often it is made.
    WithoutPause {
        /// The task.
        task: usize,
    },
    /// In the shift it is made more than four times a minute, but it was not scored so.
    RepeatedMore {
        /// The task.
        task: usize,
        /// Times a minute in the shift.
        per_min: f64,
        /// Times a minute in the scenario, if given.
        scored_per_min: Option<f64>,
    },
    /// It was scored as made more than four times a minute, which it is not in the shift.
    RepeatedLess {
        /// The task.
        task: usize,
        /// Times a minute in the shift.
        per_min: f64,
    },
    /// A motion that was measured once: nothing is known of its spread.
    MeasuredOnce {
        /// The task.
        task: usize,
        /// Body on which it was scored.
        body: String,
    },
    /// In some repetitions the hand cannot follow: they count as the worst score from there.
    OutOfReach {
        /// The task.
        task: usize,
        /// Share of repetitions.
        share: f64,
    },
    /// Part of the path is beyond the recordings.
    Beyond {
        /// The task.
        task: usize,
        /// Share of the samples.
        share: f64,
    },
    /// The path keeps not all limits.
    LimitsBroken {
        /// The task.
        task: usize,
    },
    /// The file of its scores carries no checksum, so that edits of it cannot be seen.
    NoChecksum {
        /// The task.
        task: usize,
    },
    /// The tasks are scored for different hands.
    OtherHands,
    /// Nobody repeats: bands are over single repetitions.
    OnePerson,
    /// Time on the tasks between movements, and other work, is not scored.
    NotScored,
    /// Recovery, fatigue and the order of tasks do not enter the scores.
    NoFatigue,
}

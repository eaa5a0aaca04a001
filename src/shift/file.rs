//! The shift file as typed: keys and defaults.

use crate::ergonomics::LiftCondition;
use crate::files::toml_schema;
use crate::human::Side;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Schema id and version of shift files.
pub const SHIFT_SCHEMA: &str = "ergopath/shift/1";

/// How the tasks follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// They alternate within each quarter of an hour.
    Mixed,
    /// Each is done for a longer time before the next.
    Blocks,
}

/// A worker's shift: tasks with their results and their time. File names are relative to this file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ShiftFile {
    /// Version of this format: `ergopath/shift/1`.
    #[schemars(with = "String", extend("const" = SHIFT_SCHEMA))]
    pub schema: Spanned<String>,
    /// The shift itself.
    pub shift: ShiftTable,
    /// The tasks.
    #[schemars(length(min = 1))]
    pub task: Vec<TaskTable>,
    /// Breaks: time of rest.
    #[serde(default, rename = "break")]
    pub breaks: Vec<BreakTable>,
}

/// The shift itself.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ShiftTable {
    /// Short name, shown on the page.
    pub name: String,
    /// What it is about.
    #[serde(default)]
    pub description: String,
    /// Length of the shift with its breaks, min.
    #[schemars(with = "f64")]
    pub minutes: Spanned<f64>,
    /// How the tasks follow each other: `"mixed"` within each quarter of an hour, or in `"blocks"`. Without it no composite lifting index is given.
    pub order: Option<Order>,
}

/// A break.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BreakTable {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// How long, min.
    #[schemars(with = "f64")]
    pub minutes: Spanned<f64>,
}

/// A task: a finished run or a scored motion, and how much of the shift it takes.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskTable {
    /// Name, one for each task.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// Folder that `ergopath plan`, `assess`, `batch` or `score` has written.
    #[schemars(with = "String")]
    pub result: Spanned<String>,
    /// Id of the path of the run; without it the best path, or the one that was assessed.
    #[schemars(with = "Option<String>")]
    pub path: Option<Spanned<String>>,
    /// Side of a scored motion: `"right"` or `"left"`. Needed where both were scored.
    #[schemars(with = "Option<Side>")]
    pub side: Option<Spanned<Side>>,
    /// Share of the working time (the shift without its breaks) that goes to the task, 0 to 1.
    #[schemars(with = "Option<f64>")]
    pub share: Option<Spanned<f64>>,
    /// Time that goes to the task, min; instead of `share`.
    #[schemars(with = "Option<f64>")]
    pub minutes: Option<Spanned<f64>>,
    /// How often the movement is made in the shift. Alone, the task takes as long as the movements do.
    #[schemars(with = "Option<f64>")]
    pub cycles: Option<Spanned<f64>>,
    /// What of the lift the lifting equation excludes: `"unstable_load"`, `"restricted_space"`, `"carrying_pushing_pulling"`, `"seated_or_kneeling"`, `"mechanical_help"`, `"high_speed"`, `"one_handed"`.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub excluded: Vec<LiftCondition>,
    /// How hard the hand works in one exertion, OMNI-RES scale: 0 extremely easy, 2 easy, 4 somewhat easy, 6 somewhat hard, 8 hard, 10 extremely hard; a whole number, or the lowest and the highest. For the hand tool DUET.
    #[schemars(with = "Option<Ratings>")]
    pub omni_res: Option<Spanned<Ratings>>,
    /// Exertions of the hand in each cycle. Default 1.
    #[schemars(with = "Option<f64>")]
    pub exertions: Option<Spanned<f64>>,
}

/// One rating or a range.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Ratings {
    /// One.
    One(u8),
    /// The lowest and the highest.
    Range([u8; 2]),
}

impl Ratings {
    /// The lowest and the highest.
    pub(super) fn range(self) -> [u8; 2] {
        match self {
            Self::One(rating) => [rating; 2],
            Self::Range(range) => range,
        }
    }
}

/// JSON Schema (draft 7) of shift files.
pub fn shift_schema() -> serde_json::Value {
    toml_schema::<ShiftFile>()
}

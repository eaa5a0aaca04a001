//! What a cell found, small enough to keep for every cell: `cell.json` in the folder of the cell.

use super::columns::{Found, Value, columns};
use crate::ergonomics::by_person;
use crate::files::{InputError, Seal, sealed_json, sha256_hex, take_seal};
use crate::planner::{Decision, Evaluated, RunResult, inputs_of};
use crate::scenario::Scenario;
use crate::words;
use serde::{Deserialize, Serialize};
use std::path::Path;

const RECORD_SCHEMA: &str = "ergopath/cell/1";
/// Name of the file in the folder of a cell.
pub(super) const RECORD_FILE: &str = "cell.json";

/// How a cell ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellState {
    /// With a path that keeps all limits, or one of the user's own that was assessed.
    Ok,
    /// The recordings support no statement about the worker.
    NotSupported,
    /// No path keeps all limits.
    NoFeasiblePath,
    /// The run could not be made.
    Failed,
}

impl CellState {
    /// As it stands in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NotSupported => "not_supported",
            Self::NoFeasiblePath => "no_feasible_path",
            Self::Failed => "failed",
        }
    }
}

/// What a cell found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CellRecord {
    schema: String,
    /// Its key.
    pub key: String,
    /// Version of ergopath.
    pub program_version: String,
    /// How it ended.
    pub state: CellState,
    /// Why it has no path that may be used.
    pub reason: Option<String>,
    /// What the posture model is not, in words.
    pub caveat: Option<String>,
    /// One for each body along each path, paths by rank.
    pub rows: Vec<PathRow>,
}

/// One body along one path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathRow {
    /// By the columns of the results.
    pub values: Vec<Value>,
    /// Rows with the same are of the same people: repetition r is the same simulated repetition.
    pub people: String,
    /// Mean RULA of each repetition, or of each person where people repeat; of the lead only.
    pub rula: Vec<f64>,
}

impl PathRow {
    /// The value of a column; none for a name that is no column.
    pub fn value(&self, name: &str) -> &Value {
        let at = columns().iter().position(|c| c.name == name);
        at.and_then(|i| self.values.get(i)).unwrap_or(&Value::None)
    }

    /// The same as a number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.value(name).number()
    }

    /// The same as text.
    pub fn text(&self, name: &str) -> &str {
        if let Value::Text(text) = self.value(name) { text } else { "" }
    }

    /// Whether the cell's verdict is about this path.
    pub fn is_lead(&self) -> bool {
        *self.value("is_lead") == Value::Flag(true)
    }
}

impl CellRecord {
    /// Of a finished run.
    pub fn of(key: &str, scenario: &Scenario, result: &RunResult) -> Self {
        let state = match result.verdict.outcome {
            Decision::Best | Decision::Assessed => CellState::Ok,
            Decision::NotSupported => CellState::NotSupported,
            Decision::NothingFeasible => CellState::NoFeasiblePath,
        };
        let reported = result.candidates.iter().filter(|c| c.evaluated == Evaluated::Reported);
        let found = reported
            .flat_map(|path| path.bodies.iter().map(move |body| Found { result, path, body }));
        let reason = match state {
            CellState::Ok | CellState::Failed => None,
            CellState::NotSupported => Some(words::verdict::headline(result)),
            CellState::NoFeasiblePath => words::refused::lines(result).into_iter().next(),
        };
        Self {
            state,
            reason,
            caveat: result.verdict.caveat.map(|c| words::verdict::caveat(c).into_owned()),
            rows: found.map(|f| row(&f, scenario)).collect(),
            ..Self::failed(key, String::new())
        }
    }

    /// Of a run that could not be made.
    pub fn failed(key: &str, reason: String) -> Self {
        Self {
            schema: RECORD_SCHEMA.to_owned(),
            key: key.to_owned(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            state: CellState::Failed,
            reason: Some(reason),
            caveat: None,
            rows: Vec::new(),
        }
    }

    /// The rows of the path that the cell's verdict is about, one for each body.
    pub fn lead(&self) -> impl Iterator<Item = &PathRow> {
        self.rows.iter().filter(|r| r.is_lead())
    }

    /// As a file: name and bytes.
    ///
    /// # Errors
    /// None but of the machine.
    pub fn file(&self) -> Result<(String, Vec<u8>), InputError> {
        let text = sealed_json(self);
        let text = text.map_err(|e| InputError::fault(RECORD_FILE, e.to_string()))?;
        Ok((RECORD_FILE.to_owned(), text.into_bytes()))
    }

    /// Reads the record in a folder; none where there is none, or one of another key or format.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(folder: &Path, key: &str) -> Result<Option<Self>, InputError> {
        let file = folder.join(RECORD_FILE);
        if !file.is_file() {
            return Ok(None);
        }
        // One that is no longer what was written is made again, like one that is not there.
        let sealed = |text: &str| {
            let mut value = serde_json::from_str(text).ok()?;
            let seal = take_seal(&file, &mut value, "").ok()?;
            serde_json::from_value(value).ok().filter(|_| seal == Seal::Whole)
        };
        let record: Option<Self> = sealed(&kept(&file)?);
        let fits = |r: &Self| {
            let whole = |row: &PathRow| row.values.len() == columns().len();
            r.schema == RECORD_SCHEMA && r.key == key && r.rows.iter().all(whole)
        };
        Ok(record.filter(fits))
    }
}

/// The text of a file of the batch's own: no input, as it may be written anew.
pub(super) fn kept(file: &Path) -> Result<String, InputError> {
    let unread = |e: std::io::Error| InputError::new(file, format!("cannot be read: {e}"));
    std::fs::read_to_string(file).map_err(unread)
}

fn row(found: &Found, scenario: &Scenario) -> PathRow {
    let rula = found.body.rula();
    // What draws a repetition: seed, posture model and body, by the same program.
    let mut drawn = format!("{}\n{}\n", found.result.provenance.seed, scenario.worker.model_sha256);
    let bodies = inputs_of(scenario).into_iter().skip(2).take(scenario.worker.bodies.len());
    drawn.extend(bodies.filter(|(name, _)| *name == found.body.body).map(|(_, hash)| hash));
    PathRow {
        values: columns().iter().map(|c| (c.of)(found)).collect(),
        people: sha256_hex(drawn.as_bytes())[..16].to_owned(),
        rula: if found.is_lead() {
            by_person(&rula.by_rollout, rula.persons())
        } else {
            Vec::new()
        },
    }
}

//! What an interrupted run keeps, so that it can go on where it stood.

use super::pipeline::{PlanError, Request, inputs_of};
use super::preset::Preset;
use super::search::SearchState;
use crate::files::{InputError, read_text};
use crate::scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::path::Path;

const SCHEMA: &str = "ergopath/unfinished/1";

/// An interrupted run: its inputs, and every search as far as it came.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    schema: String,
    seed: u64,
    inputs: Vec<(String, String)>,
    preset: Preset,
    searches: Vec<(String, SearchState)>,
}

impl Checkpoint {
    pub(super) fn new(
        scenario: &Scenario,
        request: &Request,
        searches: Vec<(String, SearchState)>,
    ) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            seed: request.seed,
            inputs: inputs_of(scenario),
            preset: request.preset.clone(),
            searches,
        }
    }

    /// Number of paths that were tried.
    pub fn tried(&self) -> usize {
        self.searches.iter().map(|(_, s)| s.tried.len()).sum()
    }

    /// Reads the file of an interrupted run.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let fault = |message: String| {
            InputError::new(path, message).remedy("run without --resume to start afresh")
        };
        let checkpoint: Self = serde_json::from_str(&read_text(path)?)
            .map_err(|e| fault(format!("is not an unfinished run: {e}")))?;
        if checkpoint.schema != SCHEMA {
            return Err(fault(format!("schema is not `{SCHEMA}`")));
        }
        Ok(checkpoint)
    }

    /// As the text of that file.
    pub fn text(&self) -> Result<String, InputError> {
        serde_json::to_string(self).map_err(|e| InputError::new("unfinished run", e.to_string()))
    }

    /// The searches, if they are those of the same run.
    pub(super) fn searches_for(
        &self,
        scenario: &Scenario,
        request: &Request,
    ) -> Result<Vec<(String, SearchState)>, PlanError> {
        let differs = if self.seed != request.seed {
            Some("another seed".to_owned())
        } else if self.preset != request.preset {
            Some("another planner".to_owned())
        } else {
            let inputs = inputs_of(scenario);
            let changed = inputs.iter().find(|i| !self.inputs.contains(i));
            changed.map(|(name, _)| format!("another `{name}`"))
        };
        match differs {
            None => Ok(self.searches.clone()),
            Some(what) => {
                Err(InputError::new("--resume", format!("the unfinished run has {what}"))
                    .remedy("run without --resume to start afresh")
                    .into())
            }
        }
    }
}

//! What is asked of a run, where it stands, and what it keeps when it is interrupted.

use super::preset::Preset;
use super::tried::SearchState;
use crate::files::{InputError, Seal, read_text, sealed_json, sha256_hex, take_seal};
use crate::human::Body;
use crate::scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::path::Path;
use thiserror::Error;

const SCHEMA: &str = "ergopath/unfinished/2";

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
        let broken = |e: serde_json::Error| fault(format!("is not an unfinished run: {e}"));
        let mut value = serde_json::from_str(&read_text(path)?).map_err(broken)?;
        let seal = take_seal(path, &mut value, "run without --resume to start afresh")?;
        let checkpoint: Self = serde_json::from_value(value).map_err(broken)?;
        if checkpoint.schema != SCHEMA {
            return Err(fault(format!("schema is not `{SCHEMA}`")));
        }
        // Nobody edits one, and what it holds is drawn and counted on.
        if seal == Seal::Missing {
            return Err(fault("carries no checksum".to_owned()));
        }
        let faults = checkpoint.searches.iter().filter_map(|(name, s)| Some((name, s.fault()?)));
        if let Some((name, why)) = faults.into_iter().next() {
            return Err(fault(format!("its search `{name}` cannot go on: {why}")));
        }
        Ok(checkpoint)
    }

    /// As the text of that file.
    pub fn text(&self) -> Result<String, InputError> {
        sealed_json(self).map_err(|e| InputError::fault("unfinished run", e.to_string()))
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

/// What to run.
#[derive(Debug, Clone)]
pub struct Request {
    /// The canonical command, for the record.
    pub command: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// The planner's settings.
    pub preset: Preset,
    /// Keep the sampled postures of the reported paths.
    pub keeps_rollouts: bool,
    /// A run that was interrupted, to go on with.
    pub resume: Option<Checkpoint>,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// What is being done.
    pub stage: &'static str,
    /// Items done.
    pub done: usize,
    /// Items in all.
    pub total: usize,
    /// The best objective so far, in a search.
    pub best: Option<f64>,
}

/// Told where a run stands; answers whether to go on.
pub type Stage<'a> = &'a (dyn Fn(Step) -> bool + Sync);

/// Why a run could not be made at all. A run whose paths are all infeasible is a result, not an error.
#[derive(Debug, Error)]
pub enum PlanError {
    /// The input does not fit together.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The user interrupted; with what it takes to go on.
    #[error("interrupted; nothing was written")]
    Interrupted(Option<Box<Checkpoint>>),
}

/// (name, SHA-256) of every input of a run.
pub fn inputs_of(scenario: &Scenario) -> Vec<(String, String)> {
    let mut inputs = vec![(scenario.file.clone(), scenario.sha256.clone())];
    inputs.push((scenario.worker.model.name.clone(), scenario.worker.model_sha256.clone()));
    let worker = &scenario.worker;
    let body = |(body, members): (&Body, &Vec<Body>)| {
        let all: String = std::iter::once(body).chain(members).map(Body::sha256).collect();
        let hash = if members.is_empty() { all } else { sha256_hex(all.as_bytes()) };
        (body.name.clone(), hash)
    };
    inputs.extend(worker.bodies.iter().zip(&worker.members).map(body));
    inputs.extend(scenario.paths.iter().map(|p| (p.name.clone(), p.sha256.clone())));
    inputs.extend(scenario.meshes.iter().map(|m| (m.facts.file.clone(), m.facts.sha256.clone())));
    inputs.extend(scenario.robot.files().cloned());
    inputs
}

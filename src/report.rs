//! The files of a run: everything the reader sees, made from one finished [`RunResult`].

use crate::planner::RunResult;
use thiserror::Error;

/// A file could not be made.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A value could not be written as JSON.
    #[error("result.json: {0}")]
    Json(#[from] serde_json::Error),
}

/// All files of a run, as (name, bytes).
pub fn files(result: &RunResult) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    Ok(vec![("result.json".to_owned(), result_json(result)?.into_bytes())])
}

/// `result.json` as text.
pub fn result_json(result: &RunResult) -> Result<String, ReportError> {
    Ok(serde_json::to_string_pretty(result)? + "\n")
}

//! A finished run read back from its `result.json`, and whether its inputs are still the same.

use super::proof::prove;
use super::request::inputs_of;
use super::result::{RESULT_SCHEMA, RunResult};
use crate::files::{
    InputError, Seal, read_bytes, read_text, refuse_incomplete, sha256_hex, take_seal,
};
use crate::robot::JointTrajectory;
use crate::scenario::{Warning, read_scenario};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Name of the file in a folder of results.
const RESULT_FILE: &str = "result.json";
const REMEDY: &str =
    "name a folder that `ergopath plan`, `assess` or `batch` has written, or the result.json in it";

/// The file of a result: itself, or the one in the folder.
pub fn result_file(place: &Path) -> PathBuf {
    if place.is_dir() { place.join(RESULT_FILE) } else { place.to_owned() }
}

/// Reads a run back from a folder of results or its `result.json`. Everything is as the run left it,
/// except the sampled postures of `--rollouts`, which have files of their own.
pub fn read_result(place: &Path) -> Result<RunResult, InputError> {
    let path = result_file(place);
    if place.is_dir() && !path.is_file() {
        let message = format!("is a folder without {RESULT_FILE}");
        return Err(InputError::new(place, message).remedy(REMEDY));
    }
    refuse_incomplete(path.parent().unwrap_or(Path::new("")))?;
    parse_result(&path, &read_text(&path)?)
}

/// Parses the text of a `result.json`; `path` is only named in errors.
pub fn parse_result(path: &Path, text: &str) -> Result<RunResult, InputError> {
    #[derive(Deserialize)]
    struct Head {
        schema: Option<String>,
    }
    let broken = |e: serde_json::Error| {
        if e.is_eof() {
            InputError::new(path, "ends in the middle: the file was cut off")
                .remedy("copy the file again, or make the run again")
        } else {
            InputError::new(path, format!("is not a result of ergopath: {e}")).remedy(REMEDY)
        }
    };
    let head: Head = serde_json::from_str(text).map_err(broken)?;
    match head.schema.as_deref() {
        Some(RESULT_SCHEMA) => {}
        Some(other) => {
            let message = format!("schema is `{other}`; this program reads `{RESULT_SCHEMA}`");
            let remedy =
                "make the run again with this program, or read it with the one that wrote it";
            return Err(InputError::new(path, message).remedy(remedy));
        }
        None => {
            let message = format!("has no schema; `{RESULT_SCHEMA}` is expected");
            return Err(InputError::new(path, message).remedy(REMEDY));
        }
    }
    let incomplete = |e: serde_json::Error| {
        let message = format!("is a result, but not as this version of ergopath writes it: {e}");
        InputError::new(path, message)
            .remedy("make the run again with this program, or read it with the one that wrote it")
    };
    let mut result: RunResult = serde_json::from_str(text).map_err(incomplete)?;
    let mut value: serde_json::Value = serde_json::from_str(text).map_err(broken)?;
    let again = "make the run again";
    let seal = take_seal(path, &mut value, again)?;
    prove(&result, &value).map_err(|e| {
        InputError::new(path, format!("holds what no run finds: {e}")).remedy(again)
    })?;
    if seal == Seal::Missing {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        result.warnings.push(Warning::NoChecksum { file });
    }
    for path in result.candidates.iter_mut().filter_map(|c| c.path.as_mut()) {
        if path.robot_q.len() == path.time_s.len() && !path.robot_q.is_empty() {
            let names = path.robot_joints.clone();
            path.joint_trajectory =
                Some(JointTrajectory::through(names, &path.time_s, &path.robot_q));
        }
    }
    Ok(result)
}

/// Whether the inputs of a run are still what they were.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Freshness {
    /// All inputs have the recorded SHA-256; the scenario that was compared.
    Current(PathBuf),
    /// Some have not.
    OutOfDate {
        /// The scenario that was compared.
        scenario: PathBuf,
        /// Names of the inputs that have changed.
        changed: Vec<String>,
    },
    /// The scenario could not be found, by this name.
    NotFound(String),
}

/// Compares the inputs of a run with the files as they are now. Without `scenario` a file of the
/// recorded name is looked for beside the result, in the folder above, in the working folder and in
/// its `scenarios`.
pub fn freshness(
    result: &RunResult,
    place: &Path,
    scenario: Option<&Path>,
) -> Result<Freshness, InputError> {
    let inputs = &result.provenance.inputs;
    let Some((name, recorded)) = inputs.first() else {
        return Ok(Freshness::NotFound("scenario".to_owned()));
    };
    let hash = |p: &Path| read_bytes(p).map(|b| sha256_hex(&b));
    let path = if let Some(path) = scenario {
        path.to_owned()
    } else {
        let found = places(place).into_iter().map(|f| f.join(name)).filter(|p| p.is_file());
        let found: Vec<PathBuf> = found.collect();
        let same = found.iter().find(|p| hash(p).is_ok_and(|h| h == *recorded));
        match same.or(found.first()) {
            Some(path) => path.clone(),
            None => return Ok(Freshness::NotFound(name.clone())),
        }
    };
    let mut changed = Vec::new();
    if hash(&path)? != *recorded {
        changed.push(name.clone());
    }
    match read_scenario(&path) {
        Ok(now) => {
            let now = inputs_of(&now);
            // Paths given to `assess` on the command line are not in the scenario.
            let moved = |(name, hash): &&(String, String)| {
                now.iter().any(|(n, h)| n == name && h != hash)
                    && !now.contains(&(name.clone(), hash.clone()))
            };
            changed.extend(inputs.iter().skip(1).filter(moved).map(|(n, _)| n.clone()));
        }
        // A scenario as it was can only fail to be read because a file that it names has changed.
        Err(e) if changed.is_empty() => changed.push(format!("a file that {name} names ({e})")),
        Err(_) => {}
    }
    Ok(if changed.is_empty() {
        Freshness::Current(path)
    } else {
        Freshness::OutOfDate { scenario: path, changed }
    })
}

/// Folders in which the scenario of a result may lie.
fn places(result: &Path) -> Vec<PathBuf> {
    let file = result_file(result);
    let folder = match file.parent() {
        Some(f) if !f.as_os_str().is_empty() => f.to_owned(),
        _ => PathBuf::from("."),
    };
    let above = folder.join("..");
    let here = PathBuf::from(".");
    vec![folder, above, here.clone(), here.join("scenarios")]
}

//! The scenario: a workstation as its designer describes it, checked and with its files read.
//!
//! ```text
//! TOML text ─ file ─► ScenarioFile (as typed, unknown keys refused)
//!           ─ check ─► Scenario (bodies, robot, poses, limits, task: everything resolved)
//! ```
//! Owner of `scenarios/`.

mod cell;
mod check;
mod defaults;
mod ends;
mod file;
mod freedom;
mod held;
mod mesh;
mod orientation;
mod paths;
mod plausible;
mod sketch;
mod source;
mod task;
mod warning;
mod worker;

pub use cell::PersonMargin;
pub use check::{FacesAway, LowHand, Scenario};
pub use defaults::defaults_in_force;
pub use ends::{END_TOLERANCE_DEG, END_TOLERANCE_M, EndMismatch};
pub use file::{MeshUnits, OtherArm, PosturePick};
pub use freedom::{Chosen, Freedom, Freedoms, PACE_SPREAD, TIMING, TURN_ON_THE_WAY, Variant};
pub use held::SecondHand;
pub use mesh::{MeshFacts, ObstacleMesh};
pub use paths::{UserPath, read_user_path};
pub use plausible::Doubt;
pub use sketch::{Sketch, SketchRobot, ToolWay};
pub use task::{Origin, Task};
pub use warning::Warning;
pub use worker::{Adaptation, Worker};

use crate::files::{InputError, parse_toml, read_text, sha256_hex, toml_schema};
use std::cell::RefCell;
use std::path::Path;

/// Schema id and version of scenario files.
pub const SCENARIO_SCHEMA: &str = "ergopath/scenario/1";

/// JSON Schema (draft 7) of scenario files.
pub fn scenario_schema() -> serde_json::Value {
    toml_schema::<file::ScenarioFile>()
}

/// Reads and resolves a scenario; paths in it are relative to its folder.
pub fn read_scenario(path: &Path) -> Result<Scenario, InputError> {
    parse_scenario(path, &read_text(path)?)
}

/// Resolves the text of a scenario that is, or will be, at a path.
pub fn parse_scenario(path: &Path, text: &str) -> Result<Scenario, InputError> {
    let file: file::ScenarioFile = parse_toml(path, text)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let source = source::Source { path, text, folder, doubts: RefCell::default() };
    check::resolve(&source, file, sha256_hex(text.as_bytes()))
}

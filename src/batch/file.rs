//! The batch file as typed: keys and defaults.

use crate::files::toml_schema;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Spanned;

/// Schema id and version of batch files.
pub const BATCH_SCHEMA: &str = "ergopath/batch/1";

/// What is done with each cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Paths are planned and ranked, as by `ergopath plan`.
    #[default]
    Plan,
    /// Your own paths are scored as they are, as by `ergopath assess`.
    Assess,
}

impl Mode {
    /// The command that does the same for one scenario.
    pub fn verb(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Assess => "assess",
        }
    }

    /// Whether nothing is searched.
    pub fn is_assess(self) -> bool {
        self == Self::Assess
    }
}

type AnyTable = BTreeMap<String, serde_json::Value>;
type VariantTable = BTreeMap<String, BTreeMap<String, AnyTable>>;

/// Many runs in one file: every combination of scenarios, fields, variants, planners and seeds is a cell. File names are relative to this file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BatchFile {
    /// Version of this format: `ergopath/batch/1`.
    #[schemars(with = "String", extend("const" = BATCH_SCHEMA))]
    pub schema: Spanned<String>,
    /// Short name, shown on the page.
    pub name: String,
    /// The question that the batch answers.
    #[serde(default)]
    pub description: String,
    /// `"plan"` searches for paths; `"assess"` scores your own paths as they are. Default `"plan"`.
    #[serde(default)]
    pub mode: Mode,
    /// Scenario files. They are one factor, `scenario`.
    #[schemars(with = "Vec<String>", length(min = 1))]
    pub scenarios: Vec<Spanned<String>>,
    /// Planners by name, or planner files. They are one factor, `planner`; default `["default"]`.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub planners: Vec<Spanned<String>>,
    /// Seeds. They are one factor, `seed`; without them each scenario keeps its own seed.
    #[serde(default)]
    #[schemars(with = "Vec<u64>")]
    pub seeds: Vec<Spanned<u64>>,
    /// Path files that every cell scores, besides those that the scenario names.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    pub paths: Vec<Spanned<String>>,
    /// Fields of the scenario, as in the scenario file, each with the list of its values: `task.part_mass_kg = [1.5, 3.0]`. Each is one factor.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub matrix: toml::Table,
    /// `[variant.layout.nearer]` is the level `nearer` of the factor `layout`: fields of the scenario that are set together. `remove = ["robot.preset"]` takes fields away first.
    #[serde(default)]
    #[schemars(with = "VariantTable")]
    pub variant: BTreeMap<String, BTreeMap<String, toml::Table>>,
    /// Cells that are left out: those that have all of these levels. A list stands for any of its levels.
    #[serde(default)]
    #[schemars(with = "Vec<AnyTable>")]
    pub exclude: Vec<toml::Table>,
    /// Further cells, one each: levels of factors, new values of fields among them. A factor that is left out has its first level.
    #[serde(default)]
    #[schemars(with = "Vec<AnyTable>")]
    pub include: Vec<toml::Table>,
}

/// JSON Schema (draft 7) of batch files.
pub fn batch_schema() -> serde_json::Value {
    toml_schema::<BatchFile>()
}

//! From the batch file to factors, levels and cells.

use super::file::{BATCH_SCHEMA, BatchFile, Mode};
use super::places::{Step, place};
use crate::files::{InputError, parse_toml, read_text};
use crate::planner::Preset;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Value;

/// What a factor changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FactorKind {
    /// The scenario file.
    Scenario,
    /// One field of it.
    Field,
    /// Several fields at once.
    Variant,
    /// The planner.
    Planner,
    /// The seed of all randomness.
    Seed,
}

/// What is varied.
#[derive(Debug, Clone)]
pub struct Factor {
    /// Name: that of its column.
    pub name: String,
    /// What it changes.
    pub kind: FactorKind,
    /// Its levels, those of the matrix first.
    pub levels: Vec<Level>,
}

/// One value of a factor.
#[derive(Debug, Clone)]
pub struct Level {
    /// As it is shown.
    pub label: String,
    /// As it was written; the name of a variant.
    pub(super) value: Value,
    /// Fields that are taken away first, and those that are set.
    pub(super) remove: Vec<String>,
    pub(super) set: Vec<(String, Value)>,
    /// Where it stands in the file.
    pub(super) at: Range<usize>,
}

impl Level {
    /// The number, of a level that is one.
    pub fn number(&self) -> Option<f64> {
        match self.value {
            Value::Integer(n) => Some(n as f64),
            Value::Float(v) => Some(v),
            _ => None,
        }
    }
}

/// A batch with every value in place; what the scenarios say of the values is not asked yet.
#[derive(Debug, Clone)]
pub struct Batch {
    /// Short name.
    pub name: String,
    /// The question that it answers.
    pub description: String,
    /// Planned or assessed.
    pub mode: Mode,
    /// What is varied: scenario, fields and variants as written, planner, seed.
    pub factors: Vec<Factor>,
    /// Of each cell the level of each factor.
    pub cells: Vec<Vec<usize>>,
    /// The settings of each level of the factor `planner`.
    pub presets: Vec<Preset>,
    pub(super) path: PathBuf,
    pub(super) text: String,
    pub(super) own_paths: Vec<(PathBuf, Range<usize>)>,
}

/// Whether a TOML text says that it is a batch file, by its schema, even where it is not valid otherwise.
pub fn is_batch(text: &str) -> bool {
    let id = BATCH_SCHEMA.trim_end_matches(char::is_numeric);
    let value = |line: &str| {
        let (key, value) = line.split_once('=')?;
        (key.trim() == "schema").then(|| value.trim().trim_start_matches(['"', '\'']).to_owned())
    };
    text.lines().filter_map(value).any(|v| v.starts_with(id))
}

/// Reads a batch file: its own keys, levels and cells.
///
/// # Errors
/// Where a key, a level or a combination cannot be used; with its place in the file.
pub fn read_batch(path: &Path) -> Result<Batch, InputError> {
    let text = read_text(path)?;
    let file: BatchFile = parse_toml(path, &text)?;
    let reader = Reader { path, text: &text, folder: path.parent().unwrap_or(Path::new("")) };
    if file.schema.get_ref() != BATCH_SCHEMA {
        return Err(reader
            .error(file.schema.span(), format!("schema is not `{BATCH_SCHEMA}`"))
            .remedy("this program reads that version only"));
    }
    let (mut factors, mut presets) = reader.factors(&file)?;
    let mut cells = reader.product(&factors)?;
    let excluded = reader.excluded(&file, &factors)?;
    cells.retain(|cell| {
        !excluded.iter().any(|rule| rule.iter().all(|(f, l)| l.contains(&cell[*f])))
    });
    for (k, entry) in file.include.iter().enumerate() {
        let cell = reader.included((k, entry), &mut factors, &mut presets)?;
        if cells.contains(&cell) {
            let at = reader.place(&[Step::Key("include"), Step::Index(k)]);
            return Err(reader
                .error(at, "this cell is in the batch already")
                .remedy("take it out, or give another level"));
        }
        cells.push(cell);
    }
    if cells.is_empty() {
        let at = reader.place(&[Step::Key("exclude")]);
        return Err(reader.error(at, "no cell is left").remedy("exclude fewer levels"));
    }
    let in_folder = |p: &toml::Spanned<String>| (reader.folder.join(p.get_ref()), p.span());
    let own_paths = file.paths.iter().map(in_folder).collect();
    let BatchFile { name, description, mode, .. } = file;
    let path = path.to_owned();
    Ok(Batch { name, description, mode, factors, cells, presets, path, text, own_paths })
}

/// The text behind a batch, for errors that show the place.
pub(super) struct Reader<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub folder: &'a Path,
}

impl Reader<'_> {
    pub(super) fn error(&self, at: Range<usize>, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message).at(self.text, at)
    }

    pub(super) fn place(&self, steps: &[Step]) -> Range<usize> {
        place(self.text, steps).unwrap_or(0..0)
    }
}

impl Factor {
    pub(super) fn new(name: &str, kind: FactorKind, levels: Vec<Level>) -> Self {
        Self { name: name.to_owned(), kind, levels }
    }

    /// The level that a value names: as it was written, or by its label.
    pub(super) fn level(&self, value: &Value) -> Option<usize> {
        let is = |l: &Level| l.value == *value || value.as_str() == Some(&l.label);
        self.levels.iter().position(is)
    }
}

impl Level {
    pub(super) fn new(label: String, value: Value, at: Range<usize>) -> Self {
        Self { label, value, remove: Vec::new(), set: Vec::new(), at }
    }

    pub(super) fn of_field(field: &str, value: &Value, at: Range<usize>) -> Self {
        let set = vec![(field.to_owned(), value.clone())];
        Self { set, ..Self::new(label(value), value.clone(), at) }
    }
}

/// A value as it is shown: text without quotes, a list by its parts.
pub(super) fn label(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(all) => all.iter().map(label).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

pub(super) fn stem(file: &str) -> String {
    Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Files of one name are shown as they are written.
pub(super) fn tell_apart(levels: &mut [Level]) {
    let labels: Vec<String> = levels.iter().map(|l| l.label.clone()).collect();
    for level in levels {
        if labels.iter().filter(|l| **l == level.label).count() > 1 {
            level.label = label(&level.value);
        }
    }
}

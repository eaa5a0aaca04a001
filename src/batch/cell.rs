//! A cell: the scenario with its fields set, and the key by which its result is known.
//!
//! Scenarios are edited as values, not as text, so that comments and the order of keys are no part of a key.

use super::manifest::Station;
use super::matrix::{Batch, FactorKind, Level};
use crate::files::{InputError, files_read, parse_toml, read_bytes, read_text, sha256_hex};
use crate::planner::{Preset, inputs_of};
use crate::scenario::{Scenario, parse_scenario, read_scenario};
use miette::Diagnostic as _;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};
use toml::{Table, Value};

/// Version of what a key covers and of what a cell stores: older cells are computed again.
const KEY_VERSION: &str = "ergopath/cell/1";

/// What is run for one cell.
#[derive(Debug)]
pub struct Job {
    /// The scenario with the fields of the cell; its seed is that of the run.
    pub scenario: Scenario,
    /// The planner's settings.
    pub preset: Preset,
    /// The planner as it was named.
    pub planner: String,
}

/// What a cell reads besides the planner.
struct Read {
    /// A line each: names and hashes, no places.
    lines: String,
    /// The part of it by which a change during the run is noticed.
    state: String,
    station: Station,
}

/// Makes the jobs of a batch.
#[derive(Debug)]
pub struct Jobs<'a> {
    batch: &'a Batch,
    /// Of each level of the factor `scenario`.
    scenarios: Vec<(PathBuf, Table)>,
    planner: usize,
    hashes: Mutex<BTreeMap<PathBuf, String>>,
    /// What cells read when they were checked, by their levels without the planner.
    checked: OnceLock<BTreeMap<Vec<usize>, String>>,
}

impl<'a> Jobs<'a> {
    /// Reads the scenarios as they are.
    ///
    /// # Errors
    /// Where one is refused.
    pub fn of(batch: &'a Batch) -> Result<Self, InputError> {
        let folder = batch.path.parent().unwrap_or(Path::new(""));
        let mut scenarios = Vec::new();
        for level in &batch.factors[0].levels {
            let path = folder.join(level.value.as_str().unwrap_or_default());
            let in_batch =
                |e: InputError| e.named_in(&batch.path, "scenarios", &batch.text, level.at.clone());
            let text = read_text(&path).map_err(in_batch)?;
            let table: Table = parse_toml(&path, &text).map_err(in_batch)?;
            scenarios.push((path, table));
        }
        let planner = batch.factors.iter().position(|f| f.kind == FactorKind::Planner);
        let planner = planner.unwrap_or(0);
        let (hashes, checked) = (Mutex::default(), OnceLock::new());
        Ok(Self { batch, scenarios, planner, hashes, checked })
    }

    /// Cells that differ in the planner only read the same.
    fn without_planner(&self, cell: &[usize]) -> Vec<usize> {
        let mut cell = cell.to_vec();
        cell[self.planner] = 0;
        cell
    }

    fn levels<'b>(&'b self, cell: &'b [usize]) -> impl Iterator<Item = (&'b str, &'b Level)> {
        let factors = self.batch.factors.iter().zip(cell);
        factors.map(|(f, l)| (f.name.as_str(), &f.levels[*l]))
    }

    /// The scenario of a cell with the fields of its first factors; `last` is the last that is set.
    fn scenario(&self, cell: &[usize], last: usize) -> Result<Scenario, InputError> {
        let (path, table) = &self.scenarios[cell[0]];
        let mut table = table.clone();
        for (_, level) in self.levels(cell).take(last + 1) {
            level.apply(&mut table).map_err(|message| InputError::new(path, message))?;
        }
        let text = toml::to_string(&table).map_err(|e| InputError::fault(path, e.to_string()))?;
        parse_scenario(path, &text)
    }

    /// The run of a cell.
    ///
    /// # Errors
    /// Where the scenario or a path is refused; with the place of the level that is at fault.
    pub fn job(&self, cell: &[usize]) -> Result<Job, InputError> {
        let whole = self.scenario(cell, cell.len());
        let mut scenario = whole.map_err(|e| self.at_fault(cell, &e))?;
        for (path, at) in &self.batch.own_paths {
            scenario.add_path(path).map_err(|e| {
                let key = format!("paths, in {}", self.in_words(cell));
                e.named_in(&self.batch.path, &key, &self.batch.text, at.clone())
            })?;
        }
        let checked = self.checked.get().and_then(|c| c.get(&self.without_planner(cell)));
        if checked.is_some_and(|before| *before != state(&scenario)) {
            let message = format!(
                "a file that is read in {} has changed since the batch began",
                self.in_words(cell)
            );
            return Err(InputError::new(&self.batch.path, message)
                .remedy("run the same command again: cells that are not concerned are kept"));
        }
        let planner = &self.batch.factors[self.planner].levels[cell[self.planner]];
        let planner = planner.value.as_str().unwrap_or_default().to_owned();
        let preset = self.batch.presets[cell[self.planner]].clone();
        Ok(Job { scenario, preset, planner })
    }

    /// A refusal of the scenario's reader, at the first level with which it comes.
    fn at_fault(&self, cell: &[usize], whole: &InputError) -> InputError {
        let first = (0..cell.len()).find_map(|k| Some((k, self.scenario(cell, k).err()?)));
        let (k, error) = first.as_ref().map_or((0, whole), |(k, e)| (*k, e));
        let at = self.batch.factors[k].levels[cell[k]].at.clone();
        if k == 0 {
            // The file itself: its own text shows the place.
            let own = read_scenario(&self.scenarios[cell[0]].0).err();
            let own = own.unwrap_or_else(|| InputError::new(&self.batch.path, error.message()));
            return own.named_in(&self.batch.path, "scenarios", &self.batch.text, at);
        }
        let message = format!("in {}: {}", self.in_words(&cell[..=k]), error.message());
        let refused = InputError::new(&self.batch.path, message).at(&self.batch.text, at);
        match error.help() {
            Some(help) => refused.remedy(help.to_string()),
            None => refused,
        }
    }

    fn in_words(&self, cell: &[usize]) -> String {
        let each = self.levels(cell).map(|(name, level)| format!("{name} = {}", level.label));
        each.collect::<Vec<_>>().join(", ")
    }

    /// Checks every cell and gives their keys and stations, in order. Not from within a pool of threads: what is read
    /// is known by the thread that reads it.
    ///
    /// # Errors
    /// The refusal of the first cell that cannot be run.
    pub(super) fn keys(&self) -> Result<Vec<(String, Station)>, InputError> {
        let mut order: Vec<&Vec<usize>> = Vec::new();
        let mut index: BTreeMap<Vec<usize>, usize> = BTreeMap::new();
        for cell in &self.batch.cells {
            index.entry(self.without_planner(cell)).or_insert_with(|| {
                order.push(cell);
                order.len() - 1
            });
        }
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let share = order.len().div_ceil(threads).max(1);
        let read: Vec<Result<Read, InputError>> = std::thread::scope(|scope| {
            let parts: Vec<_> = order
                .chunks(share)
                .map(|part| scope.spawn(|| part.iter().map(|c| self.read(c)).collect::<Vec<_>>()))
                .collect();
            let failed = |_| vec![Err(InputError::fault("batch", "a cell could not be read"))];
            parts.into_iter().flat_map(|p| p.join().unwrap_or_else(failed)).collect()
        });
        let read = read.into_iter().collect::<Result<Vec<Read>, _>>()?;
        let checked = index.iter().map(|(cell, k)| (cell.clone(), read[*k].state.clone()));
        let _ = self.checked.set(checked.collect());
        let mut keys = Vec::new();
        for cell in &self.batch.cells {
            let preset = &self.batch.presets[cell[self.planner]];
            let preset = serde_json::to_string(preset)
                .map_err(|e| InputError::fault(&self.batch.path, e.to_string()))?;
            let version = env!("CARGO_PKG_VERSION");
            let (verb, inputs) =
                (self.batch.mode.verb(), &read[index[&self.without_planner(cell)]]);
            let whole = format!("{KEY_VERSION}\n{version}\n{verb}\n{preset}\n{}", inputs.lines);
            keys.push((sha256_hex(whole.as_bytes()), inputs.station.clone()));
        }
        Ok(keys)
    }

    /// All that a cell reads besides the planner.
    fn read(&self, cell: &[usize]) -> Result<Read, InputError> {
        let (job, files) = files_read(|| self.job(cell));
        let job = job?;
        let scenario = &job.scenario;
        if self.batch.mode.is_assess() && scenario.paths.is_empty() && scenario.drawn.is_empty() {
            let at = self.batch.factors[0].levels[cell[0]].at.clone();
            return Err(InputError::new(&self.batch.path, "names no path to assess")
                .at(&self.batch.text, at)
                .remedy("write paths = [\"today.csv\"], or a [[path]] in the scenario"));
        }
        let mut all: BTreeSet<(String, String)> = inputs_of(scenario).into_iter().collect();
        for file in files {
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            all.insert((name, self.hash(&file)?));
        }
        let mut lines = format!("seed {}\n", scenario.seed);
        for (name, hash) in all {
            let _ = writeln!(lines, "{hash} {name}");
        }
        let station = Station {
            scenario: cell[0],
            name: scenario.name.clone(),
            load_kg: scenario.task.load_kg,
            duration_s: scenario.duration_s,
        };
        Ok(Read { lines, state: state(scenario), station })
    }

    fn hash(&self, file: &Path) -> Result<String, InputError> {
        let known = || self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(hash) = known().get(file) {
            return Ok(hash.clone());
        }
        let hash = sha256_hex(&read_bytes(file)?);
        known().insert(file.to_owned(), hash.clone());
        Ok(hash)
    }
}

/// The inputs of a scenario as one hash.
fn state(scenario: &Scenario) -> String {
    let lines: Vec<String> =
        inputs_of(scenario).into_iter().map(|(name, hash)| format!("{hash} {name}")).collect();
    sha256_hex(lines.join("\n").as_bytes())
}

impl Level {
    /// Changes a scenario as the level says; the error is a message.
    fn apply(&self, scenario: &mut Table) -> Result<(), String> {
        for field in &self.remove {
            let steps: Vec<&str> = field.split('.').collect();
            remove(scenario, &steps).ok_or_else(|| format!("there is no `{field}` to remove"))?;
        }
        for (field, value) in &self.set {
            let steps: Vec<&str> = field.split('.').collect();
            set(scenario, &steps, value).map_err(|why| format!("`{field}`: {why}"))?;
        }
        Ok(())
    }
}

/// Sets a field. In a list of tables such as `[[obstacle]]` a step is the `name` of one of them.
fn set(table: &mut Table, steps: &[&str], value: &Value) -> Result<(), String> {
    let [first, rest @ ..] = steps else { return Ok(()) };
    if rest.is_empty() {
        table.insert((*first).to_owned(), value.clone());
        return Ok(());
    }
    let inner = table.entry(*first).or_insert_with(|| Value::Table(Table::new()));
    match (inner, rest) {
        (Value::Table(inner), _) => set(inner, rest, value),
        (Value::Array(all), [name, field @ ..]) if !field.is_empty() => {
            let inner =
                named(all, name).ok_or_else(|| format!("no `{first}` is named `{name}`"))?;
            set(inner, field, value)
        }
        _ => Err(format!("`{first}` has no fields")),
    }
}

/// Takes a field away; none where it is not there.
fn remove(table: &mut Table, steps: &[&str]) -> Option<()> {
    let [first, rest @ ..] = steps else { return None };
    if rest.is_empty() {
        return table.remove(*first).map(drop);
    }
    match (table.get_mut(*first)?, rest) {
        (Value::Table(inner), _) => remove(inner, rest),
        (Value::Array(all), [name]) => {
            let at = all.iter().position(|v| is_named(v, name))?;
            all.remove(at);
            Some(())
        }
        (Value::Array(all), [name, field @ ..]) => remove(named(all, name)?, field),
        _ => None,
    }
}

fn is_named(value: &Value, name: &str) -> bool {
    value.get("name").and_then(Value::as_str) == Some(name)
}

fn named<'a>(all: &'a mut [Value], name: &str) -> Option<&'a mut Table> {
    all.iter_mut().find(|v| is_named(v, name))?.as_table_mut()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_set_and_removed_also_in_lists_by_name() {
        let text = "a = 1\n[robot]\npreset = \"x\"\n[[obstacle]]\nname = \"b\"\nz = 1\n\
                    [[obstacle]]\nname = \"c\"\n";
        let mut table: Table = text.parse().unwrap();
        set(&mut table, &["robot", "base", "x_m"], &Value::Float(0.5)).unwrap();
        set(&mut table, &["obstacle", "b", "z"], &Value::Integer(2)).unwrap();
        assert_eq!(table["robot"]["base"]["x_m"].as_float(), Some(0.5));
        assert_eq!(table["obstacle"][0]["z"].as_integer(), Some(2));
        assert!(set(&mut table, &["a", "b"], &Value::Integer(1)).is_err());
        assert!(set(&mut table, &["obstacle", "d", "z"], &Value::Integer(1)).is_err());
        remove(&mut table, &["robot", "preset"]).unwrap();
        remove(&mut table, &["obstacle", "b"]).unwrap();
        assert!(table["robot"].get("preset").is_none());
        assert_eq!(table["obstacle"].as_array().unwrap().len(), 1);
        assert!(remove(&mut table, &["robot", "preset"]).is_none());
    }
}

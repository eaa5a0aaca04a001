//! The plan of a batch in its folder: what the cells are, so that shards can be joined without the batch
//! file, and the records of the cells by it.

use super::cell::Jobs;
use super::file::Mode;
use super::matrix::{Batch, FactorKind};
use super::record::{CellRecord, RECORD_FILE, kept};
use crate::files::InputError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const MANIFEST_SCHEMA: &str = "ergopath/batch-run/1";
/// Hexadecimal digits of a key, which is a SHA-256.
const HASH_DIGITS: usize = 64;
/// Digits of a key that name a folder.
const SHORT: usize = 16;

/// What is varied.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedFactor {
    /// Name: that of its column.
    pub name: String,
    /// What it changes.
    pub kind: FactorKind,
    /// Its levels as they are shown.
    pub levels: Vec<String>,
    /// The numbers of its levels, where all are numbers.
    pub numbers: Option<Vec<f64>>,
}

/// One cell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellPlan {
    /// The level of each factor.
    pub levels: Vec<usize>,
    /// Its key.
    pub key: String,
    /// Its station, by its place in the plan.
    pub station: usize,
}

/// Work that can be laid out in several ways: cells of one station are alike in scenario file, load and the
/// duration that the scenario gives, so that their scores say which layout is better. Those of others do not.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Station {
    /// Level of the factor `scenario`.
    pub scenario: usize,
    /// The scenario's own name for it.
    pub name: String,
    /// Load on the hand, kg.
    pub load_kg: f64,
    /// Duration of the movement, s.
    pub duration_s: f64,
}

impl CellPlan {
    /// Its folder in that of the batch.
    pub fn folder(&self) -> PathBuf {
        Path::new(Manifest::CELLS).join(self.short())
    }

    /// The file of what it found, in that of the batch.
    pub fn record(&self) -> PathBuf {
        self.folder().join(RECORD_FILE)
    }

    /// The beginning of its key.
    pub fn short(&self) -> &str {
        &self.key[..SHORT.min(self.key.len())]
    }
}

/// The plan of a batch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    schema: String,
    /// Name.
    pub name: String,
    /// The question.
    pub description: String,
    /// Planned or assessed.
    pub mode: Mode,
    /// What is varied.
    pub factors: Vec<PlannedFactor>,
    /// The stations, in the order of the cells.
    pub stations: Vec<Station>,
    /// The cells in order.
    pub cells: Vec<CellPlan>,
}

/// A plan and what each of its cells found.
#[derive(Debug)]
pub struct Finished {
    /// The plan.
    pub plan: Manifest,
    /// By the cells of the plan.
    pub records: Vec<CellRecord>,
}

impl Manifest {
    /// Folder of the cells, in that of the batch.
    pub const CELLS: &'static str = "cells";
    /// Name of its file in the folder of the batch.
    pub const FILE: &'static str = "batch.json";

    /// Of a batch; every cell is checked.
    ///
    /// # Errors
    /// Where a cell is refused.
    pub fn of(batch: &Batch, jobs: &Jobs) -> Result<Self, InputError> {
        let (mut stations, mut cells) = (Vec::<Station>::new(), Vec::new());
        let mut known: BTreeMap<(usize, u64, u64), usize> = BTreeMap::new();
        for (levels, (key, own)) in batch.cells.iter().cloned().zip(jobs.keys()?) {
            // The scenario may be renamed by a field: that alone makes no other work of it.
            let alike = (own.scenario, own.load_kg.to_bits(), own.duration_s.to_bits());
            let station = *known.entry(alike).or_insert_with(|| {
                stations.push(own);
                stations.len() - 1
            });
            cells.push(CellPlan { levels, key, station });
        }
        let factors = batch.factors.iter().map(|f| PlannedFactor {
            name: f.name.clone(),
            kind: f.kind,
            levels: f.levels.iter().map(|l| l.label.clone()).collect(),
            numbers: f.levels.iter().map(super::matrix::Level::number).collect(),
        });
        Ok(Self {
            schema: MANIFEST_SCHEMA.to_owned(),
            name: batch.name.clone(),
            description: batch.description.clone(),
            mode: batch.mode,
            factors: factors.collect(),
            stations,
            cells,
        })
    }

    #[cfg(test)]
    pub(super) fn made(factors: Vec<PlannedFactor>, cells: Vec<CellPlan>) -> Self {
        let (schema, name) = (MANIFEST_SCHEMA.to_owned(), "made".to_owned());
        let (description, mode, stations) = (String::new(), Mode::Plan, Vec::new());
        Self { schema, name, description, mode, factors, stations, cells }
    }

    /// As a file: name and bytes.
    ///
    /// # Errors
    /// None but of the machine.
    pub fn file(&self) -> Result<(String, Vec<u8>), InputError> {
        let text = serde_json::to_string(self);
        let text = text.map_err(|e| InputError::fault(Self::FILE, e.to_string()))?;
        Ok((Self::FILE.to_owned(), (text + "\n").into_bytes()))
    }

    /// Reads the plan in the folder of a batch.
    ///
    /// # Errors
    /// Where there is none.
    pub fn read(folder: &Path) -> Result<Self, InputError> {
        let file = folder.join(Self::FILE);
        let remedy =
            "name the folder that `ergopath batch BATCH.toml -o DIR --shard i/n` has written to";
        if !file.is_file() {
            let message = format!("is no folder of a batch: it has no {}", Self::FILE);
            return Err(InputError::new(folder, message).remedy(remedy));
        }
        let broken = |what: String| InputError::new(&file, what).remedy(remedy);
        let plan: Self = serde_json::from_str(&kept(&file)?)
            .map_err(|e| broken(format!("is not the plan of a batch: {e}")))?;
        let in_range = |c: &CellPlan| {
            c.station < plan.stations.len()
                && c.levels.len() == plan.factors.len()
                && c.levels.iter().zip(&plan.factors).all(|(l, f)| *l < f.levels.len())
        };
        // Keys name folders: what is no hash could name any place.
        let is_hash = |c: &CellPlan| {
            c.key.len() == HASH_DIGITS && c.key.bytes().all(|b| b.is_ascii_hexdigit())
        };
        let is_sound = |c: &CellPlan| is_hash(c) && in_range(c);
        if plan.schema != MANIFEST_SCHEMA || !plan.cells.iter().all(is_sound) {
            return Err(broken(format!("is not a plan of `{MANIFEST_SCHEMA}`")));
        }
        Ok(plan)
    }

    /// The level of a cell in a factor, as it is shown.
    pub fn label(&self, cell: usize, factor: usize) -> &str {
        &self.factors[factor].levels[self.cells[cell].levels[factor]]
    }

    /// Indices of the factors with more than one level in the cells.
    pub fn varied(&self) -> Vec<usize> {
        let of = |f: &usize| {
            let mut levels = self.cells.iter().map(|c| c.levels[*f]);
            let first = levels.next();
            levels.any(|l| Some(l) != first)
        };
        (0..self.factors.len()).filter(of).collect()
    }

    /// The records of all cells; none of the result where any is missing, of which the numbers are given.
    ///
    /// # Errors
    /// Where a record cannot be read.
    pub fn records(self, folder: &Path) -> Result<Result<Finished, Vec<usize>>, InputError> {
        let (mut records, mut missing) = (Vec::new(), Vec::new());
        for (k, cell) in self.cells.iter().enumerate() {
            match CellRecord::read(&folder.join(cell.folder()), &cell.key)? {
                Some(record) => records.push(record),
                None => missing.push(k),
            }
        }
        Ok(if missing.is_empty() { Ok(Finished { plan: self, records }) } else { Err(missing) })
    }
}

//! Batches: a matrix of scenarios, fields, planners and seeds, each cell of which is run once.
//!
//! ```text
//! batch file ─ file, factors, expand on places ─► Batch (factors, levels, cells)
//! Batch      ─ cell      ─► Job (the scenario with its fields set, planner), and the keys
//! RunResult  ─ record    ─► CellRecord (what a cell found: written whole, read back)
//! Manifest + CellRecords ─ columns, table ─► cells.csv, cells.parquet, columns.csv
//!                        ─ effects        ─► main effects, Pareto front, stations that are alike
//!                        ─ gate           ─► kept or not, cell by cell
//! Manifest, missing cells ─ cost, slurm   ─► the scripts of a job array over the shards
//! ```
//! A cell is known by its key, a hash of all that it reads, so that it is never computed twice.

mod cell;
mod columns;
mod cost;
mod effects;
mod expand;
mod factors;
mod file;
mod gate;
mod manifest;
mod matrix;
mod places;
mod record;
mod slurm;
mod table;

pub use cell::{Job, Jobs};
pub use columns::{Column, Value, columns};
pub use cost::core_seconds;
pub use effects::{Effect, LevelEffect, Point, front, main_effects};
pub use file::{BATCH_SCHEMA, Mode, batch_schema};
pub use gate::{Gate, GateRow, Kept};
pub use manifest::{CellPlan, Finished, Manifest, PlannedFactor, Station};
pub use matrix::{Batch, Factor, FactorKind, Level, is_batch, read_batch};
pub use record::{CellRecord, CellState, PathRow};
pub use slurm::{Bundles, QUEUE_FORMAT, Queued, SlurmJobs, largest_index, reasons, submitted_job};
pub use table::{TableError, tables};

//! `ErgoBench`: planners judged by people whose true behaviour is known.
//!
//! Workstations of six families, bodies, and simulated people are drawn by seed. The planner knows a
//! person only from demonstrations of *other* movements; every path is then walked by the person
//! themselves, so that no planner is judged by its own model. The oracle plans with the truth and
//! bounds what could be reached. Nobody was recorded: the figures compare planners, not workplaces.
//!
//! Seeds 0 to 99 are for tuning, the table uses 1000 and up.

mod cell;
mod families;
mod people;
mod table;

pub use cell::{Cell, Outcome};
pub use families::{Family, Station, draw};
pub use people::{Kind, TruePerson};
pub use table::{Gain, Row, Table, table};

use crate::files::InputError;
use crate::human::Body;
use crate::planner::{PlanError, Preset, Stage};
use cell::{Draft, run_cell};
use std::path::Path;

/// First seed of published tables.
pub const TABLE_SEED: u64 = 1000;
/// The bodies, from small to large.
const BODIES: [&str; 3] = ["female_p05", "male_p50", "male_p95"];

/// What is run.
#[derive(Debug, Clone)]
pub struct Question {
    /// Seed of workstations, people and searches.
    pub seed: u64,
    /// Families.
    pub families: Vec<Family>,
    /// Workstations of each family.
    pub instances: usize,
    /// Kinds of people at each workstation.
    pub kinds: Vec<Kind>,
    /// Movements from which the planner learns each person.
    pub demonstrations: usize,
    /// Repetitions by which a path is judged.
    pub repetitions: usize,
    /// The planner's settings.
    pub preset: Preset,
}

/// Runs all cells, each in a folder of its own under `folder`; `told` hears of every cell.
///
/// # Errors
/// Where a workstation cannot be drawn or the run is interrupted.
pub fn run(
    question: &Question,
    folder: &Path,
    stage: Stage,
    mut told: impl FnMut(usize, usize, &Cell),
) -> Result<Vec<Cell>, PlanError> {
    let bodies: Result<Vec<Body>, InputError> =
        BODIES.iter().map(|b| Body::load(b, Path::new("."))).collect();
    let bodies = bodies?;
    let total = question.families.len() * question.instances * question.kinds.len();
    let mut cells: Vec<Cell> = Vec::with_capacity(total);
    for (f, family) in question.families.iter().enumerate() {
        for instance in 0..question.instances {
            for (k, kind) in question.kinds.iter().enumerate() {
                let number = (f * question.instances + instance) * question.kinds.len() + k;
                let draft = Draft {
                    family: *family,
                    number: instance as u64,
                    body: &bodies[(f + instance + k) % bodies.len()],
                    kind: *kind,
                    person_number: question.seed * 1000 + number as u64,
                };
                let own = folder.join(format!("cell_{number:03}"));
                std::fs::create_dir_all(&own).map_err(|e| InputError::unwritable(&own, &e))?;
                let cell = run_cell(&draft, question, &own, stage)?;
                told(number, total, &cell);
                cells.push(cell);
            }
        }
    }
    Ok(cells)
}

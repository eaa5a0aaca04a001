//! `ErgoBench`: planners judged by people whose true behaviour is known.
//!
//! Workstations of nine families, bodies, and simulated people are drawn by seed. In six of them an arm
//! on a pelvis that rests moves; in three, where hands go low, a whole person does, with one hand or with
//! both. The planner knows a person only from demonstrations of *other* movements; every path is then
//! walked by the person themselves, so that no planner is judged by its own model. The oracle plans with
//! the truth and bounds what could be reached. Nobody was recorded: the figures compare planners, not
//! workplaces.
//!
//! ```text
//! people     five kinds, each with a law of its own; statistics: how their joints move
//! families   workstations        demonstrate   what the learner sees of a person
//! cell       one workstation, body and person: learn, plan, judge
//! table      gains by family and kind           bootstrap     their intervals, by cells
//! reliability  predicted against true risk
//! performers the people at the work of the paper's experiments, for training
//! ```
//!
//! Seeds 0 to 99 are for tuning, the table uses 1000 and up.

mod bootstrap;
mod cell;
mod demonstrate;
mod families;
mod people;
mod performers;
mod reliability;
mod statistics;
mod table;

pub use bootstrap::Gain;
pub use cell::{Cell, Outcome};
pub use families::{Family, Station, draw};
pub use people::{Kind, TruePerson};
pub use performers::performers;
pub use reliability::ReliabilityBin;
pub use statistics::Statistics;
pub use table::{MISJUDGED, OUT_OF_REACH, Row, Table, Weak, table};

use crate::files::InputError;
use crate::human::Body;
use crate::planner::{PlanError, Preset, Stage};
use cell::{Draft, run_cell};
use std::path::Path;

/// First seed of published tables.
pub const TABLE_SEED: u64 = 1000;
/// Name of our planner, and of ours with the pace of paths free.
pub const OURS: &str = "ergopath";
/// See [`OURS`].
pub const PACED: &str = "ergopath_paced";
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
    /// Whether paths with a free pace are planned beside those that keep the minimum-jerk law.
    pub pace: bool,
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
    // A cell is the same whatever else is run: its numbers are those of the full benchmark.
    let place = |kind: &Kind| Kind::ALL.iter().position(|k| k == kind).unwrap_or(0);
    for family in &question.families {
        for instance in 0..question.instances {
            for kind in &question.kinds {
                let (f, k) = (*family as usize, place(kind));
                let count = Kind::ALL.len();
                let number = (f * question.instances + instance) * count + k;
                let draft = Draft {
                    family: *family,
                    number: (instance * count + k) as u64,
                    body: &bodies[(f + instance + k) % bodies.len()],
                    kind: *kind,
                    person_number: question.seed * 100_000 + (instance * 100 + f * 10 + k) as u64,
                };
                let own = folder.join(format!("cell_{number:03}"));
                std::fs::create_dir_all(&own).map_err(|e| InputError::unwritable(&own, &e))?;
                let cell = run_cell(&draft, question, &own, stage)?;
                told(cells.len(), total, &cell);
                cells.push(cell);
            }
        }
    }
    Ok(cells)
}

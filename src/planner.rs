//! The pipeline from a scenario to ranked, explained paths.
//!
//! ```text
//! candidates ─ prepare (QP, robot, obstacles) ─► feasible paths | why not
//!            ─ evaluate on the search block   ─► shortlist
//!            ─ evaluate on a fresh block      ─► rank
//!            ─ evaluate on one more block     ─► the figures that are reported
//! ```
//! All paths meet the same people: the randomness of a rollout depends on (seed, block, rollout),
//! never on the path. Blocks are not shared between choosing and reporting, so the winner's figures
//! are not flattered by having been chosen.

mod causes;
mod evaluate;
mod explain;
mod finalists;
mod lens;
mod objective;
mod pipeline;
mod prepare;
mod preset;
mod result;
mod resume;
mod search;
mod searches;
mod space;

pub use objective::Figures;
pub use pipeline::{PlanError, Request, Stage, Step, assess, judge_truly, plan, plan_knowing};
pub use preset::{Objective, Preset, load_preset, preset_names};
pub use result::*;
pub use resume::Checkpoint;
pub use search::{SearchState, Tried};

//! The pipeline from a scenario to ranked, explained paths.
//!
//! ```text
//! space      white numbers              ─► via-points, and start, goal, base ... where they are free
//! prepare    QP, robot, obstacles       ─► feasible path | why not, and what would help (causes)
//! near       robot against people       ─► share of repetitions nearer than the margin
//! search     CMA-ES, a generation judged together by the same people (searches: ours, baselines)
//! finalists  the best on fresh people by successive halving, every baseline, the user's own
//! pipeline   one more block of people   ─► the figures that are reported
//! filming    some of their walks        ─► scene, what a viewer plays
//! ```
//! All paths meet the same people: the randomness of a rollout depends on (seed, block, rollout),
//! never on the path. Blocks are not shared between choosing and reporting, so the winner's figures
//! are not flattered by having been chosen.

mod along;
mod apart;
mod causes;
mod cell_findings;
mod cell_look;
mod cell_sensitivity;
mod evaluate;
mod explain;
mod filming;
mod finalists;
mod findings;
mod guard;
mod lens;
mod moments;
mod near;
mod objective;
mod pipeline;
mod prepare;
mod preset;
mod recommend;
mod refusal;
mod result;
mod resume;
mod scene;
mod scored;
mod search;
mod searches;
mod space;
mod stored;
mod timing;
mod verdict;

pub use cell_findings::{CellFinding, HangingFeet, Intrusion, OutsideBox};
pub use cell_look::{CellLook, HandAlong, HandReach, RobotAlong, RobotReach, look_at_cell};
pub use cell_sensitivity::{CellSensitivity, FixedPath, Outcome, Quantity, cell_sensitivity};
pub use findings::{Figure, Finding, Severity, Subject, Why};
pub use objective::Figures;
pub use pipeline::{PlanError, Request, Stage, Step, assess, judge_truly, plan, plan_knowing};
pub use preset::{MethodWeights, Objective, Preset, load_preset, planner_schema, preset_names};
pub use refusal::{Hint, Refusal, RefusalKind, RefusedBy, RefusedGroup};
pub use result::*;
pub use resume::Checkpoint;
pub use scene::*;
pub use scored::MethodFigures;
pub use search::{SearchState, Tried};
pub use stored::{Freshness, freshness, parse_result, read_result, result_file};

//! The pipeline from a scenario to ranked, explained paths.
//!
//! ```text
//! space      white numbers              ─► via-points, and start, goal, base ... where they are free
//! prepare    QP, robot, obstacles       ─► feasible path | why not, and what would help (causes)
//! person     a body and its behaviour   ─► repetitions, scored (scored) for ranking and report alike
//! near       robot against the worker   ─► share of repetitions nearer than the margin
//! guard      against the straight path  ─► what a lower mean was bought with: peak, score per metre
//! search     CMA-ES, a generation judged on the same repetitions (searches: ours, baselines)
//! finalists  the best on fresh repetitions by successive halving, every baseline, the user's own
//! reporting  one more block             ─► the figures that are reported, and their scene (filming)
//! pipeline   the stages in order, and the verdict: findings as facts
//! ```
//! All paths get the same repetitions: the randomness of a rollout depends on (seed, block, rollout),
//! never on the path. Blocks are not shared between choosing and reporting, so the winner's figures
//! are not flattered by having been chosen.

mod along;
mod apart;
mod causes;
mod cell_findings;
mod cell_look;
mod cell_sensitivity;
mod checked;
mod checklist;
mod environment;
mod explain;
mod filming;
mod finalists;
mod findings;
mod guard;
mod known_starts;
mod layout;
mod lens;
mod moments;
mod near;
mod objective;
mod pairing;
mod people;
mod person;
mod pipeline;
mod prepare;
mod preset;
mod proof;
mod recommend;
mod refusal;
mod repetitions;
mod reporting;
mod request;
mod result;
mod scene;
mod scored;
mod search;
mod searches;
mod space;
mod stored;
mod strain;
mod summary;
mod timing;
mod tried;
mod verdict;
mod walking;

pub use cell_findings::CellFinding;
pub use cell_look::{
    CellLook, HandAlong, HandReach, HangingFeet, Intrusion, OutsideBox, RobotAlong, RobotReach,
    look_at_cell,
};
pub use cell_sensitivity::{CellSensitivity, FixedPath, Outcome, Quantity, cell_sensitivity};
pub use checked::{CheckState, Checked, Subject, Why};
pub use findings::{Figure, Finding, Severity};
pub use layout::{Wanted, lay_out};
pub use objective::Figures;
pub use pairing::{Apart, apart};
pub use pipeline::{assess, judge_truly, plan, plan_knowing};
pub use preset::{MethodWeights, Objective, Preset, load_preset, planner_schema, preset_names};
pub use refusal::{Hint, Refusal, RefusalKind, RefusedBy, RefusedGroup, Status};
pub use request::{Checkpoint, PlanError, Request, Stage, Step, inputs_of};
pub use result::*;
pub use scene::*;
pub use scored::MethodFigures;
pub use stored::{Freshness, freshness, parse_result, read_result, result_file};
pub use tried::{SearchState, Tried};

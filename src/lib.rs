//! Plans the path of a collaborative robot so that the person holding on to it works in a
//! healthy posture.
//!
//! The hand follows the robot, but the body is redundant: one hand path admits many postures, and
//! every person resolves that freedom in their own way. ergopath therefore treats the posture as a
//! *distribution*, learned from recorded movements, and ranks robot paths by the distribution of
//! ergonomic scores that they would cause.
//!
//! # Data flow
//!
//! ```text
//! train:  recording file ─ recording          ─► Recording          (segment poses over time)
//!         ─ training::fit (human, kinematics)  ─► JointMotion        (joint angles of one body)
//!         ─ training::read_person               ─► Sources, Dataset   (q, xdot = J qdot, qdot)
//!         ─ training::methods                  ─► PostureModel       ─ posture::file ─► models/posture/
//!
//! plan:   scenario file ─ scenario             ─► Scenario           (worker, robot, task, limits)
//!         ─ path::candidate                    ─► Vec<Candidate>     (via-points -> TCP paths)
//!         ─ path::project_for_arm (qp, robot)  ─► SmoothPath | why not
//!         ─ robot                              ─► RobotMotion | why not
//!         ─ posture::Behaviour (roll_out)      ─► Repeated           (sampled postures over time)
//!         ─ survey (human), ergonomics         ─► BodyScores         (RULA, REBA as distributions)
//!         ─ planner                            ─► RunResult          (ranked, compared, explained)
//!         ─ words                              ─► the same facts in plain English
//!         ─ report                             ─► result.json, CSV, PNG, report.html
//!
//! score:  worksheets, recording or rollouts ─ scoring (survey, ergonomics) ─► sheets and sums
//! batch:  batch file ─ batch ─► jobs, each planned or assessed once ─► tables, effects, gate ─ report ─► page
//! shift:  shift file and finished runs ─ shift ─► ShiftResult ─ words, report ─► page and table
//! bench:  ergobench draws stations and people, trains, plans, and judges by the people's truth
//! ```
//!
//! # From a program
//!
//! A posture by its RULA score:
//!
//! ```
//! use ergopath::ergonomics::{Profile, Worksheet, rula};
//!
//! let posture = Worksheet { trunk_flex_deg: 30.0, elbow_flex_deg: 80.0, ..Worksheet::default() };
//! assert_eq!(rula(&posture, &Profile::default()).trunk, 3);
//! ```
//!
//! A scenario by its best path, and how sure that is:
//!
//! ```
//! use ergopath::planner::{Request, load_preset, plan};
//! use ergopath::scenario::read_scenario;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scenario = read_scenario("scenarios/bench_pick_and_place.toml".as_ref())?;
//! let preset = load_preset("quick")?;
//! let request =
//!     Request { command: String::new(), seed: 0, preset, keeps_rollouts: false, resume: None };
//! let result = plan(&scenario, &request, &|_step| true)?;
//! let best = result.verdict.best.as_deref().ok_or("no path keeps all limits")?;
//! let path = result.candidates.iter().find(|c| c.id == best).ok_or("the best is listed")?;
//! let rula = &path.bodies[0].rula().distribution;
//! assert!(rula.p05 <= rula.expected && rula.expected <= rula.p95);
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! SI units and radians inside; degrees appear only at the edge, in names that end in `_deg`.
//! The world is right-handed with z up. Twists and task velocities are stacked linear first, then
//! angular. Symbols: `n` joints, `m` task rows, `q` joint angles, `J` the m x n Jacobian, `W` the
//! symmetric positive definite n x n weight matrix of the pseudo-inverse
//! `J_W^+ = W J^T (J W J^T)^-1`.
//!
//! Modules import only modules on lower floors; `tests/suite/layers.rs` holds the list and the guard.

pub mod batch;
pub mod cli;
pub mod ergobench;
pub mod ergonomics;
pub mod files;
pub mod human;
pub mod kinematics;
pub mod math;
pub mod mesh;
pub mod path;
pub mod physical;
pub mod planner;
pub mod posture;
pub mod qp;
pub mod recording;
pub mod report;
pub mod robot;
pub mod scenario;
pub mod scoring;
pub mod shift;
pub mod survey;
pub mod training;
pub mod trajectory;
pub mod words;

#[cfg(test)]
#[path = "../tests/suite/skips.rs"]
mod skips;

//! All tests from outside the crate, in one program: compiled and linked once.
//!
//! A new file of tests is one `mod` line here; `common` holds what several files share.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests may panic, and say what they skip and which figures they judge"
)]

mod common;
mod skips;

mod agreement;
mod batch_cli;
#[cfg(target_os = "linux")]
mod batch_slurm;
mod bvh_cli;
mod check_cli;
mod checks;
mod compare_cli;
mod docs;
mod ergobench_cli;
mod ergonomics_golden;
mod ergonomics_properties;
mod ergonomics_tables;
mod evaluate_cli;
mod fit_real;
mod fuzz;
mod import_cli;
mod inputs_cli;
#[cfg(feature = "peers")]
mod kinematics_peer;
mod layers;
mod licences;
mod mesh_cli;
mod moved_worlds;
mod new_cli;
mod numerics;
#[cfg(unix)]
mod outputs_cli;
mod paper_cli;
mod people_cli;
mod plan_cli;
mod planner;
mod program_cli;
mod prose;
mod recordings_real;
mod report_cli;
mod schema_cli;
mod score_cli;
mod shift_cli;
mod shipped;
mod threads;
mod train_cli;
mod train_real;
mod trust;
mod verdict;
mod watch_cli;
mod whole_worker;

//! The readers that are fuzzed: those of the tests, which hold them on the stable toolchain too.

#[path = "../../tests/suite/fuzz/made.rs"]
mod made;
#[path = "../../tests/suite/fuzz/targets.rs"]
pub mod targets;

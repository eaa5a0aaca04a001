//! Facts in plain English, for terminal, page and tables alike.
//!
//! Lower floors produce typed values; whoever shows them takes the words from here, so that the same
//! fact reads the same everywhere. Nothing here decides anything.

pub mod cell;
pub mod checklist;
pub mod decision;
pub mod finding;
pub mod hand;
pub mod look;
pub mod number;
pub mod pairing;
pub mod path;
pub mod paths;
pub mod program;
pub mod refusal;
pub mod refused;
pub mod robot;
pub mod setting;
pub mod shift;
pub mod strain;
pub mod verdict;

use crate::path::End;

/// "start" or "goal".
pub fn end(end: End) -> &'static str {
    match end {
        End::Start => "start",
        End::Goal => "goal",
    }
}

//! Facts in plain English, for terminal, page and tables alike.
//!
//! Lower floors produce typed values; whoever shows them takes the words from here, so that the same
//! fact reads the same everywhere. Nothing here decides anything.

pub mod cell;
pub mod finding;
pub mod number;
pub mod paths;
pub mod verdict;

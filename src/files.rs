//! Files at the edge: reading with errors that name the place, and writing whole or not at all.
//!
//! [`Outputs`] is the door for everything that a command writes; the readers note what is read, so that
//! no output lands on an input.

mod delimited;
mod error;
mod exact;
mod folder;
mod inputs;
mod marker;
mod memo;
mod memory;
mod number;
mod output;
#[cfg(test)]
mod output_tests;
mod place;
mod schema;
mod seal;
mod signature;
mod spreadsheet;
mod sweep;
mod table;
mod text;

pub use delimited::CsvText;
pub use error::{InputError, suggest};
pub use inputs::{files_read, note_input, take_named_inputs};
pub use marker::refuse_incomplete;
pub use memo::Memo;
pub use memory::{peak_memory_mib, restart_peak_memory};
pub use number::null_as_nan;
pub use output::{Outputs, remove_state};
pub use place::write_whole;
pub use schema::toml_schema;
pub use seal::{CHECKSUM, Seal, sealed, sealed_json, sealed_pretty_json, take_seal};
pub use sweep::sweep_killed;
pub use table::NumericTable;
pub use text::{is_formula, parse_toml, read_bytes, read_text, sha256_hex};

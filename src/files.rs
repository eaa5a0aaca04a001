//! Files at the edge: reading with errors that name the place, and writing whole or not at all.

mod delimited;
mod error;
mod exact;
mod memory;
mod number;
mod output;
mod schema;
mod table;
mod text;

pub use delimited::CsvText;
pub use error::{InputError, suggest};
pub use memory::{peak_memory_mib, restart_peak_memory};
pub use number::null_as_nan;
pub use output::{OutputFolder, write_whole};
pub use schema::toml_schema;
pub use table::NumericTable;
pub use text::{parse_toml, read_bytes, read_text, sha256_hex};

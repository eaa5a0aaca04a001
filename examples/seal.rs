//! Gives JSON files of ergopath (posture models, results) the checksum over their content, and changes no other
//! byte: for files that were written by a version without. Whoever seals a file vouches for it.
//!
//! ```sh
//! cargo run --release --features peers --example seal -- models/posture/people.json
//! ```

#![allow(clippy::print_stderr, reason = "a program says what it did")]

use ergopath::files::{CHECKSUM, sealed, write_whole};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&name)?;
        let value: serde_json::Value = serde_json::from_str(&text)?;
        if value.get(CHECKSUM).is_some() {
            eprintln!("{name}: carries a checksum already; left as it is");
            continue;
        }
        write_whole(Path::new(&name), sealed(&text)?.as_bytes())?;
        eprintln!("{name}: sealed");
    }
    Ok(())
}

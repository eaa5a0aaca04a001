//! Draws the named grips and the keys of poses, for the guide:
//!
//! ```text
//! cargo run --release --features peers --example grips -- docs/pictures
//! ```

use ergopath::report::{directions_figure, grips_figure};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));
    std::fs::write(folder.join("grips.png"), grips_figure()?)?;
    Ok(std::fs::write(folder.join("directions.png"), directions_figure()?)?)
}

//! Packs the script that draws the moving scene, so that the program carries a third of it and packs nothing when a
//! page is written.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::error::Error;
use std::io::Write as _;
use std::path::Path;

/// plotly.js, without the typesetting of formulae that the crate puts beside it.
fn library(all: &str) -> Option<&str> {
    let (_, rest) = all.split_once("<script type=\"text/javascript\">")?;
    let (script, _) = rest.split_once("</script>")?;
    (script.contains("plotly.js v3") && script.len() < 5_500_000).then_some(script)
}

fn main() -> Result<(), Box<dyn Error>> {
    let all = plotly::Plot::offline_js_sources();
    let script = library(&all).ok_or("the plotly crate holds its script in another form")?;
    // The header holds no time, so that the bytes are always the same.
    let mut encoder = GzEncoder::new(Vec::new(), Compression::new(6));
    encoder.write_all(script.as_bytes())?;
    let packed = STANDARD.encode(encoder.finish()?);
    let folder = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    std::fs::write(Path::new(&folder).join("plotly.js.gz.base64"), packed)?;
    let mut out = std::io::stdout();
    writeln!(out, "cargo::rerun-if-changed=build.rs")?;
    Ok(())
}

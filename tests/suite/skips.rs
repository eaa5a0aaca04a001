//! Tests that lack something say so out loud and are counted; the crate's own tests use this file too.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Where `.ci/run` finds what was skipped, in the target folder: a line each.
const LIST: &str = "skipped_tests.txt";

/// Says on the terminal that the running test is skipped, or a part of it, and notes it in the list.
pub(crate) fn skip(want: &str) {
    let thread = std::thread::current();
    let test = thread.name().filter(|n| *n != "main").unwrap_or("a test");
    let line = format!("SKIPPED {test}: no {want}\n");
    // Not by a macro, whose output a passing test swallows.
    std::io::stderr().write_all(line.as_bytes()).unwrap();
    // target/release/deps/program
    let program = std::env::current_exe().unwrap();
    let target = program.ancestors().nth(3).unwrap();
    let list = std::fs::OpenOptions::new().create(true).append(true).open(target.join(LIST));
    list.unwrap().write_all(line.as_bytes()).unwrap();
}

/// A file or folder of the reference material beside the checkout; without it, a skip.
#[allow(dead_code, reason = "the test in the browser needs none")]
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(path);
    if place.exists() {
        return Some(place);
    }
    skip(&format!("../shared/{path}"));
    None
}

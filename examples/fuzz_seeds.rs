//! Writes seeds and dictionaries for the programs in `fuzz/`, made from what ships and what is made up.
//!
//! ```text
//! cargo run --release --features peers --example fuzz_seeds -- fuzz
//! ```
//! writes `corpus/TARGET/NAME` and `dictionaries/TARGET.dict` into the folder. A dictionary holds the words of the
//! seeds, the keys of the schemas of `ergopath schema`, and numbers that programs stumble over.

#![allow(clippy::print_stderr, reason = "a program says what went wrong")]
#![allow(clippy::unwrap_used, reason = "the seeds are known to be valid")]

#[path = "../tests/suite/fuzz/made.rs"]
mod made;
#[path = "../tests/suite/fuzz/seeds.rs"]
mod seeds;
#[path = "../tests/suite/fuzz/targets.rs"]
mod targets;

use ergopath::batch::batch_schema;
use ergopath::planner::planner_schema;
use ergopath::scenario::scenario_schema;
use ergopath::shift::shift_schema;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Shortest and longest word that a dictionary holds, bytes, and most words of one.
const WORD: std::ops::RangeInclusive<usize> = 2..=40;
const MOST_WORDS: usize = 600;
const NUMBERS: [&str; 9] =
    ["nan", "inf", "-1", "1e308", "-1e308", "1e-320", "0x10", "4294967295", "9223372036854775808"];

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("name the folder to write to");
        return ExitCode::from(2);
    };
    match write_all(&folder) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{}: {e}", folder.display());
            ExitCode::FAILURE
        }
    }
}

fn write_all(folder: &Path) -> std::io::Result<()> {
    let dictionaries = folder.join("dictionaries");
    std::fs::create_dir_all(&dictionaries)?;
    for target in targets::TARGETS {
        let (_, seeds) = seeds::seeds(target.name);
        let corpus = folder.join("corpus").join(target.name);
        std::fs::create_dir_all(&corpus)?;
        let mut words: BTreeSet<String> = NUMBERS.map(str::to_owned).into();
        for (name, bytes) in &seeds {
            std::fs::write(corpus.join(name), bytes)?;
            words.extend(words_of(bytes).take(MOST_WORDS));
        }
        words.extend(schema_words(target.name));
        let lines = words.iter().fold(String::new(), |mut text, word| {
            let _ = writeln!(text, "\"{}\"", escaped(word));
            text
        });
        std::fs::write(dictionaries.join(format!("{}.dict", target.name)), lines)?;
    }
    Ok(())
}

/// Keys, elements and other words of a seed, but no numbers.
fn words_of(bytes: &[u8]) -> impl Iterator<Item = String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_:#-".contains(c);
    let text = String::from_utf8_lossy(bytes).into_owned();
    let words: BTreeSet<String> = text
        .split(|c| !is_part(c))
        .filter(|w| WORD.contains(&w.len()) && w.parse::<f64>().is_err())
        .map(str::to_owned)
        .collect();
    words.into_iter()
}

fn schema_words(target: &str) -> BTreeSet<String> {
    let schema = match target {
        "scenario" | "scenario_plan" => scenario_schema(),
        "planner" => planner_schema(),
        "batch" => batch_schema(),
        "shift" => shift_schema(),
        _ => return BTreeSet::new(),
    };
    let mut words = BTreeSet::new();
    collect(&schema, &mut words);
    words
}

/// Keys and values of enumerations, wherever a schema has them.
fn collect(schema: &Value, words: &mut BTreeSet<String>) {
    match schema {
        Value::Object(members) => {
            if let Some(Value::Object(keys)) = members.get("properties") {
                words.extend(keys.keys().cloned());
            }
            for (key, inner) in members {
                match (key.as_str(), inner) {
                    ("const", Value::String(word)) => drop(words.insert(word.clone())),
                    ("enum", Value::Array(all)) => {
                        words.extend(all.iter().filter_map(|v| v.as_str().map(str::to_owned)));
                    }
                    _ => collect(inner, words),
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|v| collect(v, words)),
        _ => {}
    }
}

/// As a dictionary of libFuzzer has it.
fn escaped(word: &str) -> String {
    word.bytes().fold(String::new(), |mut text, b| {
        let _ = match b {
            b'"' | b'\\' => write!(text, "\\{}", char::from(b)),
            b' '..=b'~' => write!(text, "{}", char::from(b)),
            _ => write!(text, "\\x{b:02X}"),
        };
        text
    })
}

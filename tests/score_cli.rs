//! `ergopath score` from outside: worksheets, motions, sampled postures, and what it refuses.

#![allow(clippy::unwrap_used, reason = "tests may panic")]
#![allow(clippy::print_stdout, reason = "says what it skips")]

use assert_cmd::Command;
use std::path::{Path, PathBuf};

fn score() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ergopath"));
    command.arg("score");
    command
}

/// A file of the reference material; `None`, and a word about it, where it is absent.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {name} is not here");
    None
}

/// Header and rows of a CSV file.
fn read(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|r| r.unwrap().iter().map(str::to_owned).collect()).collect();
    (header, rows)
}

/// Standard error without line breaks and margins, for comparing messages that are wrapped.
fn complaint(command: &mut Command) -> String {
    let run = command.assert().code(2);
    assert!(run.get_output().stdout.is_empty());
    let shown = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    let flat: Vec<&str> = shown.split(['\n', '│', ' ']).filter(|w| !w.is_empty()).collect();
    flat.join(" ")
}

#[test]
fn a_table_of_known_postures_is_scored_as_expected() {
    let Some(postures) = shared("ergonomics/postures.csv") else { return };
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("scored.csv");
    let mut command = score();
    command.arg("--worksheet").arg(&postures).arg("-o").arg(&out).args(["--profile", "reference"]);
    command.assert().success();
    let (expected_header, expected) = read(&postures);
    let (header, rows) = read(&out);
    assert_eq!((rows.len(), expected.len()), (266, 266));
    let mut compared = 0;
    for (own, theirs) in rows.iter().zip(&expected) {
        let kind = &theirs[expected_header.iter().position(|c| c == "kind").unwrap()];
        for (column, cell) in header.iter().zip(own) {
            let at = expected_header.iter().position(|c| c == column).unwrap();
            if kind != "convention" || !column.contains('_') {
                assert_eq!(cell, &theirs[at], "row {} {column}", own[0]);
                compared += 1;
            }
        }
    }
    assert!(compared > 250 * 50, "{compared}");
    // Without -o the same table is printed.
    let mut command = score();
    command.arg("--worksheet").arg(&postures).args(["--profile", "reference"]);
    let printed = command.assert().success().get_output().stdout.clone();
    assert_eq!(printed, std::fs::read(&out).unwrap());
}

#[test]
fn a_faulty_table_ends_with_one_message_and_no_file() {
    let room = tempfile::tempdir().unwrap();
    let columns = ergopath::ergonomics::Worksheet::COLUMNS;
    let good = format!("{}\n{}\n", columns.join(","), ["0"; 26].join(","));
    let table = room.path().join("t.csv");
    let out = room.path().join("out.csv");
    let cases = [
        (good.replacen("\n0,", "\nNaN,", 1), "line 2, column `upper_arm_flex`: `NaN` is not"),
        (good.replace("knee_flex,", ""), "input column `knee_flex` is missing"),
        (good.replace("knee_flex,", "knee_flx,"), "input column `knee_flex` is missing"),
        (good[..good.len() - 9].to_owned(), "cells, but the header has 26"),
        (good.replace(",0\n", ",7\n"), "`7` is no coupling class"),
    ];
    for (text, expected) in cases {
        std::fs::write(&table, text).unwrap();
        let shown = complaint(score().arg("--worksheet").arg(&table).arg("-o").arg(&out));
        assert!(shown.contains(expected), "{expected}: {shown}");
        assert!(!out.exists());
    }
    let shown = complaint(score().args(["--worksheet", "none.csv"]));
    assert!(shown.contains("no such file"), "{shown}");
    let shown = complaint(score().args(["--worksheet", "t.csv", "--profile", "referense"]));
    assert!(shown.contains("did you mean `reference`?"), "{shown}");
}

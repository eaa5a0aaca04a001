//! Every cell of every table against another transcription, where that is at hand.

use ergopath::ergonomics::{
    RulaTableA, reba_table_a, reba_table_b, reba_table_c, rula_table_a, rula_table_b, rula_table_c,
};
use std::collections::BTreeMap;
use std::path::Path;

/// Rows of numbers by the number they stand under.
type Rows = BTreeMap<u8, Vec<u8>>;

fn transcription() -> Option<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/ergonomics/README.md");
    if !file.is_file() {
        eprintln!("skipped: no file {}", file.display());
        return None;
    }
    Some(std::fs::read_to_string(file).unwrap())
}

/// The text from a heading up to the end of its block.
fn block<'a>(text: &'a str, heading: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(heading).unwrap_or_else(|| panic!("no {heading}"));
    rest.split_once('\n').unwrap().1.trim_start_matches("```\n").split(end).next().unwrap()
}

/// Rows that begin with a label such as `3:` or `1.2`, several to a line; bars are decoration.
fn rows(block: &str, label: impl Fn(&str) -> Option<u8>) -> Rows {
    let mut found = Rows::new();
    for line in block.lines() {
        let mut row = None;
        for word in line.split_whitespace().filter(|w| *w != "|") {
            if let Some(number) = label(word) {
                row = Some(number);
                found.insert(number, Vec::new());
            } else if let (Some(row), Ok(score)) = (row, word.parse()) {
                found.entry(row).or_default().push(score);
            }
        }
    }
    found
}

fn colon(word: &str) -> Option<u8> {
    word.strip_suffix(':')?.parse().ok()
}

/// `4.2` as 42.
fn dotted(word: &str) -> Option<u8> {
    let (upper, lower) = word.split_once('.')?;
    Some(upper.parse::<u8>().ok()? * 10 + lower.parse::<u8>().ok()?)
}

/// Compares a table with its rows; the look-up is given the row's label and the column from 0.
fn same(rows: &Rows, count: usize, width: usize, look_up: impl Fn(u8, u8) -> u8) {
    assert_eq!(rows.len(), count, "{rows:?}");
    for (label, row) in rows {
        assert_eq!(row.len(), width, "row {label}");
        for (column, score) in (0..).zip(row) {
            assert_eq!(look_up(*label, column), *score, "row {label}, column {column}");
        }
    }
}

#[test]
fn every_cell_of_rula() {
    let Some(text) = transcription() else { return };
    let a = rows(block(&text, "**Table A** (rows upper arm", "```"), dotted);
    same(&a, 18, 8, |row, column| {
        rula_table_a(RulaTableA::Paper1993, row / 10, row % 10, column / 2 + 1, column % 2 + 1)
    });
    let b = rows(block(&text, "**Table B** (rows neck", "```"), colon);
    same(&b, 6, 12, |neck, column| rula_table_b(neck, column / 2 + 1, column % 2 + 1));
    let c = rows(block(&text, "**Table C** (rows score C", "```"), colon);
    same(&c, 8, 7, |score_c, column| rula_table_c(score_c, column + 1));
}

#[test]
fn every_cell_of_the_cornell_printing() {
    let Some(text) = transcription() else { return };
    let paper = rows(block(&text, "**Table A** (rows upper arm", "```"), dotted);
    let mut cornell = paper.clone();
    // "4.1 and 4.2 w1t1 4>3, w3t2 5>4; ...": cells wait for the change that follows them.
    let changes = text.split_once("paper>Cornell) ").unwrap().1.split('|').next().unwrap();
    let (mut labels, mut waiting, mut joined, mut count) = (Vec::new(), Vec::new(), false, 0);
    for word in changes.split([' ', ',', ';']).filter(|w| !w.is_empty()) {
        if let Some(label) = dotted(word) {
            if !joined {
                labels.clear();
            }
            labels.push(label);
        } else if let Some((from, to)) = word.split_once('>') {
            for (label, column) in
                labels.iter().flat_map(|l| waiting.iter().map(move |c: &usize| (l, *c)))
            {
                let cell = &mut cornell.get_mut(label).unwrap()[column];
                assert_eq!(*cell, from.parse::<u8>().unwrap(), "{label} {word}");
                *cell = to.parse().unwrap();
                count += 1;
            }
            waiting.clear();
        } else if let Some((wrist, twist)) = word.trim_start_matches('w').split_once('t') {
            let [wrist, twist]: [usize; 2] = [wrist, twist].map(|n| n.parse().unwrap());
            waiting.push(2 * (wrist - 1) + twist - 1);
        }
        joined = word == "and";
    }
    assert_eq!(count, 31);
    same(&cornell, 18, 8, |row, column| {
        rula_table_a(RulaTableA::Cornell2001, row / 10, row % 10, column / 2 + 1, column % 2 + 1)
    });
}

#[test]
fn every_cell_of_reba() {
    let Some(text) = transcription() else { return };
    // Tables A and B stand side by side: A's rows have no colon.
    let both = block(&text, "Table A  rows trunk", "Table C");
    let mut a = Rows::new();
    for line in both.lines() {
        let left = line.split(|c: char| c.is_whitespace() || c == '|').filter(|w| !w.is_empty());
        let left: Vec<u8> = left.map_while(|w| w.parse().ok()).collect();
        if let [trunk, row @ ..] = left.as_slice() {
            a.insert(*trunk, row.to_vec());
        }
    }
    same(&a, 5, 12, |trunk, column| reba_table_a(column / 4 + 1, trunk, column % 4 + 1));
    let b = rows(both, colon);
    same(&b, 6, 6, |upper, column| reba_table_b(upper, column / 3 + 1, column % 3 + 1));
    let mut c = rows(block(&text, "Table C  rows score A", "```"), colon);
    assert_eq!(c.insert(12, vec![12; 12]), Some(vec![12]), "the last row reads `all 12`");
    same(&c, 12, 12, |score_a, column| reba_table_c(score_a, column + 1));
}

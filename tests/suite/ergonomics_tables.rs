//! Every cell of every score table against a transcription of our own, made apart from the program's,
//! and that one against the reference material, where it is at hand.
//!
//! Sources of the cells: Applied Ergonomics 24(2):91-99, 1993 (RULA), the sheet of Cornell 2001 (its RULA
//! table A), Applied Ergonomics 31:201-205, 2000 (REBA). The program keeps rows; here stand columns, so
//! that one slip is hardly made twice. A digit is a score; `a`, `b`, `c` are 10, 11, 12.

use crate::skips::shared;
use ergopath::ergonomics::{
    RulaTableA, reba_table_a, reba_table_b, reba_table_c, rula_table_a, rula_table_b, rula_table_c,
};
use std::collections::BTreeMap;

/// RULA table A: a line for each wrist 1-4 with twist 1 and 2; in it upper arm 1-6, lower arm 1-3.
const RULA_A: [&str; 8] = [
    "122 233 334 444 556 789",
    "223 334 344 444 566 789",
    "223 334 444 444 566 789",
    "223 334 444 445 567 789",
    "233 334 444 445 567 789",
    "333 444 445 555 677 899",
    "334 445 555 556 677 899",
    "334 445 555 556 778 999",
];

/// The same as printed by Cornell in 2001, in 31 cells lower.
const RULA_A_CORNELL: [&str; 8] = [
    "122 222 222 333 556 779",
    "223 223 333 444 566 789",
    "222 223 333 444 566 789",
    "223 333 334 445 567 789",
    "233 333 444 445 567 789",
    "333 334 444 445 677 899",
    "334 444 555 556 677 899",
    "334 445 555 556 778 999",
];

/// RULA table B: a line for each trunk 1-6 with legs 1 and 2; in it neck 1-6.
const RULA_B: [&str; 12] = [
    "123578", "333578", "223578", "334678", "344678", "455788", "555788", "556789", "666789",
    "677789", "777889", "777889",
];

/// RULA table C: a line for each score D 1-7; in it score C 1-8.
const RULA_C: [&str; 7] =
    ["12334455", "22334455", "33334566", "34445667", "44456677", "55567777", "55667777"];

/// REBA table A: a line for each neck 1-3 with legs 1-4; in it trunk 1-5.
const REBA_A: [&str; 12] = [
    "12234", "23456", "34567", "45678", "13456", "24567", "35678", "46789", "34567", "35678",
    "56789", "67899",
];

/// REBA table B: a line for each lower arm 1-2 with wrist 1-3; in it upper arm 1-6.
const REBA_B: [&str; 6] = ["113467", "224578", "235588", "124578", "235689", "345789"];

/// REBA table C: a line for each score B 1-12; in it score A 1-12.
const REBA_C: [&str; 12] = [
    "112346789abc",
    "123446789abc",
    "123446789abc",
    "23345789abbc",
    "3445689aabcc",
    "3456789aabcc",
    "4567899abbcc",
    "567889aabccc",
    "66789aaabccc",
    "77899abbcccc",
    "77899abbcccc",
    "78899abbcccc",
];

/// The scores of a table, `[line][place in it]`, all lines with `length` of them.
fn lines(table: &[&str], length: usize) -> Vec<Vec<u8>> {
    let digits = |line: &&str| -> Vec<u8> {
        let signs = line.chars().filter(|c| *c != ' ');
        signs.map(|c| u8::try_from(c.to_digit(16).unwrap()).unwrap()).collect()
    };
    let lines: Vec<Vec<u8>> = table.iter().map(digits).collect();
    assert!(lines.iter().all(|line| line.len() == length));
    lines
}

/// Every cell of the program's table, looked up by line and place from 0, against ours.
fn every_cell(table: &[&str], length: usize, look_up: impl Fn(u8, u8) -> u8) {
    for (line, scores) in (0..).zip(lines(table, length)) {
        for (place, score) in (0..).zip(scores) {
            assert_eq!(look_up(line, place), score, "line {line}, place {place}");
        }
    }
}

#[test]
fn every_cell_of_rula() {
    for (printing, table) in
        [(RulaTableA::Paper1993, RULA_A), (RulaTableA::Cornell2001, RULA_A_CORNELL)]
    {
        every_cell(&table, 18, |line, place| {
            rula_table_a(printing, place / 3 + 1, place % 3 + 1, line / 2 + 1, line % 2 + 1)
        });
    }
    every_cell(&RULA_B, 6, |line, place| rula_table_b(place + 1, line / 2 + 1, line % 2 + 1));
    every_cell(&RULA_C, 8, |line, place| rula_table_c(place + 1, line + 1));
}

#[test]
fn every_cell_of_reba() {
    every_cell(&REBA_A, 5, |line, place| reba_table_a(line / 4 + 1, place + 1, line % 4 + 1));
    every_cell(&REBA_B, 6, |line, place| reba_table_b(place + 1, line / 3 + 1, line % 3 + 1));
    every_cell(&REBA_C, 12, |line, place| reba_table_c(place + 1, line + 1));
}

/// Rows of numbers by the number they stand under.
type Rows = BTreeMap<u8, Vec<u8>>;

fn reference() -> Option<String> {
    Some(std::fs::read_to_string(shared("ergonomics/README.md")?).unwrap())
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

/// The rows of the reference, in the order of their labels, against our lines.
fn same(rows: &Rows, table: &[&str]) {
    let lines = lines(table, rows.len());
    for (place, (label, row)) in rows.iter().enumerate() {
        let own: Vec<u8> = lines.iter().map(|line| line[place]).collect();
        assert_eq!(&own, row, "row {label}");
    }
}

#[test]
fn our_transcription_of_rula_is_that_of_the_reference() {
    let Some(text) = reference() else { return };
    same(&rows(block(&text, "**Table A** (rows upper arm", "```"), dotted), &RULA_A);
    same(&rows(block(&text, "**Table B** (rows neck", "```"), colon), &RULA_B);
    same(&rows(block(&text, "**Table C** (rows score C", "```"), colon), &RULA_C);
}

#[test]
fn our_transcription_of_the_cornell_printing_is_that_of_the_reference() {
    let Some(text) = reference() else { return };
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
    same(&cornell, &RULA_A_CORNELL);
}

#[test]
fn our_transcription_of_reba_is_that_of_the_reference() {
    let Some(text) = reference() else { return };
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
    same(&a, &REBA_A);
    let b = rows(both, colon);
    same(&b, &REBA_B);
    let mut c = rows(block(&text, "Table C  rows score A", "```"), colon);
    assert_eq!(c.insert(12, vec![12; 12]), Some(vec![12]), "the last row reads `all 12`");
    same(&c, &REBA_C);
}

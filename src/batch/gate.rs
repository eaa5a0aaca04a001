//! A gate: bounds that every cell has to keep, `p_rula_ge_5 < 0.1 and reach_exceeded_share <= 0.05`.
//!
//! A value that is not known keeps no bound: what was not checked is not kept.

use super::columns::{Kind, columns};
use super::manifest::Finished;
use super::record::PathRow;
use crate::files::{InputError, suggest};
use std::ops::Range;

const WHERE: &str = "--gate";
const EXAMPLE: &str = "write bounds on columns, such as 'p_rula_ge_5 < 0.1 and rula_peak <= 6'";

/// Whether a value keeps a bound.
type Keeps = fn(f64, f64) -> bool;

/// How a value is compared with its bound; the longer signs first.
const SIGNS: [(&str, Keeps); 5] = [
    ("<=", |v, b| v <= b),
    (">=", |v, b| v >= b),
    ("==", |v, b| v == b),
    ("<", |v, b| v < b),
    (">", |v, b| v > b),
];

/// A bound on one column.
#[derive(Debug, Clone)]
struct Bound {
    column: &'static str,
    sign: &'static str,
    keeps: Keeps,
    limit: f64,
}

/// All bounds.
#[derive(Debug, Clone)]
pub struct Gate {
    bounds: Vec<Bound>,
}

/// Whether a bound is kept.
#[derive(Debug, Clone, PartialEq)]
pub enum Kept {
    /// It is.
    Yes,
    /// It is not; by this value of this column.
    No {
        /// The bound, as it was written.
        bound: String,
        /// The value.
        value: f64,
    },
    /// Nothing is known; of this bound, or of the whole cell.
    Unknown {
        /// The bound; none where the cell has no path.
        bound: Option<String>,
    },
}

/// What the gate says of one body of a cell's lead, or of a cell without a path.
#[derive(Debug, Clone, PartialEq)]
pub struct GateRow {
    /// The cell.
    pub cell: usize,
    /// Body and path; none without a path.
    pub of: Option<(String, String)>,
    /// Each bound that is not shown to be kept.
    pub broken: Vec<Kept>,
}

impl Gate {
    /// Reads the bounds.
    ///
    /// # Errors
    /// Where the text is not such a list, or a column is not known or no number.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let bounds = split_by_and(text).into_iter().map(|(at, part)| bound(text, at, part));
        Ok(Self { bounds: bounds.collect::<Result<_, _>>()? })
    }

    /// Asks every cell: every body along its lead.
    pub fn ask(&self, finished: &Finished) -> Vec<GateRow> {
        let mut all = Vec::new();
        for (cell, record) in finished.records.iter().enumerate() {
            let mut rows = record.lead().peekable();
            if rows.peek().is_none() {
                all.push(GateRow { cell, of: None, broken: vec![Kept::Unknown { bound: None }] });
            }
            all.extend(rows.map(|row| GateRow {
                cell,
                of: Some((row.text("body").to_owned(), row.text("path").to_owned())),
                broken: self.bounds.iter().map(|b| b.of(row)).filter(|k| *k != Kept::Yes).collect(),
            }));
        }
        all
    }
}

impl Bound {
    fn shown(&self) -> String {
        format!("{} {} {}", self.column, self.sign, self.limit)
    }

    fn of(&self, row: &PathRow) -> Kept {
        match row.number(self.column) {
            None => Kept::Unknown { bound: Some(self.shown()) },
            Some(value) if (self.keeps)(value, self.limit) => Kept::Yes,
            Some(value) => Kept::No { bound: self.shown(), value },
        }
    }
}

/// The parts between the words `and`, each with its place.
fn split_by_and(text: &str) -> Vec<(usize, &str)> {
    let mut parts = Vec::new();
    let trimmed = |from: usize, to: usize| {
        let part = &text[from..to];
        (from + part.len() - part.trim_start().len(), part.trim())
    };
    let (mut from, mut at) = (0, 0);
    for word in text.split_inclusive(char::is_whitespace) {
        if word.trim().eq_ignore_ascii_case("and") {
            parts.push(trimmed(from, at));
            from = at + word.len();
        }
        at += word.len();
    }
    parts.push(trimmed(from, text.len()));
    parts
}

fn bound(text: &str, at: usize, part: &str) -> Result<Bound, InputError> {
    let error =
        |message: String, range: Range<usize>| InputError::new(WHERE, message).at(text, range);
    let whole = at..at + part.len();
    let found = SIGNS.iter().find_map(|(sign, keeps)| Some((sign, keeps, part.split_once(sign)?)));
    let Some((sign, keeps, (name, value))) = found else {
        return Err(error(format!("`{part}` is no bound"), whole).remedy(EXAMPLE));
    };
    let numbers = || columns().iter().filter(|c| matches!(c.kind, Kind::Number | Kind::Whole));
    let name = name.trim();
    let Some(column) = numbers().find(|c| c.name == name) else {
        let help = suggest(name, numbers().map(|c| c.name));
        let help =
            help.unwrap_or_else(|| "columns.csv in the folder of a batch lists them".to_owned());
        let message = format!("`{name}` is no column of numbers");
        return Err(error(message, at..at + name.len()).remedy(help));
    };
    let value = value.trim();
    let number = value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
        let from = at + part.len() - value.len();
        error(format!("`{value}` is no number"), from..at + part.len()).remedy(EXAMPLE)
    })?;
    Ok(Bound { column: column.name, sign, keeps: *keeps, limit: number })
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic as _;

    #[test]
    fn bounds_are_read_as_written() {
        let gate = Gate::parse("p_rula_ge_5<0.1 and  rula_peak <= 6 AND rank == 1").unwrap();
        let shown: Vec<String> = gate.bounds.iter().map(Bound::shown).collect();
        assert_eq!(shown, ["p_rula_ge_5 < 0.1", "rula_peak <= 6", "rank == 1"]);
        assert!((gate.bounds[0].keeps)(0.09, 0.1) && !(gate.bounds[0].keeps)(0.1, 0.1));
        assert!((gate.bounds[1].keeps)(6.0, 6.0) && !(gate.bounds[1].keeps)(6.1, 6.0));
    }

    #[test]
    fn what_is_no_bound_is_shown_with_its_place() {
        for (text, words, at) in [
            ("p_rula_ge5 < 0.1", "is no column of numbers", 0),
            ("rula_peak <= 6 and body < 3", "`body` is no column", 19),
            ("rula_peak <= six", "`six` is no number", 13),
            ("rula_peak", "is no bound", 0),
            ("rula_peak < 6 and", "is no bound", 17),
            ("", "is no bound", 0),
        ] {
            let error = Gate::parse(text).unwrap_err();
            assert!(error.to_string().contains(words), "{text}: {error}");
            assert_eq!(error.labels().unwrap().next().unwrap().offset(), at, "{text}");
        }
        let error = Gate::parse("p_rula_ge5 < 0.1").unwrap_err();
        assert_eq!(error.help().unwrap().to_string(), "did you mean `p_rula_ge_5`?");
    }
}

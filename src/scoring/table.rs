//! A table of worksheets, scored row by row: what `ergopath score --worksheet` does.
//!
//! ```text
//! input columns (Worksheet::COLUMNS, any order) ─► Worksheet ─► RulaSteps, RebaSteps
//! output = other columns as they were, then RulaSteps::COLUMNS, RebaSteps::COLUMNS
//! ```
//! Angles in deg, loads in kg, boxes 0 or 1. Rows keep their order; a column named like an output is
//! replaced. Nothing is guessed: a cell that cannot be read stops the whole table.

use crate::ergonomics::{Profile, RebaSteps, RulaSteps, Worksheet, reba, rula};
use crate::files::{CsvText, InputError, suggest};
use std::path::Path;

/// The largest angle that is taken for one, deg.
const LARGEST_ANGLE_DEG: f64 = 360.0;

/// A scored table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScoredTable {
    /// CSV text.
    pub csv: Vec<u8>,
    /// Number of rows.
    pub rows: usize,
}

/// Scores every row of a CSV table of worksheets; `path` is only named in errors.
///
/// # Errors
/// Where an input column is missing or named twice, a row has another length than the header, or a
/// cell is no finite number, a negative load, a box other than 0 or 1, or a coupling outside 0 to 3.
pub fn score_table(
    path: &Path,
    bytes: &[u8],
    profile: &Profile,
) -> Result<ScoredTable, InputError> {
    let text = CsvText::of(path, bytes)?;
    let mut reader = text.verbatim();
    let header = reader.headers().map_err(|e| text.broken(path, &e))?.clone();
    let inputs = input_columns(path, &header)?;
    let copied: Vec<usize> =
        (0..header.len()).filter(|&i| !outputs().any(|o| o == header[i].trim())).collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = |e: csv::Error| InputError::new(path, format!("cannot be copied: {e}"));
    writer
        .write_record(
            copied.iter().map(|&i| header[i].to_owned()).chain(outputs().map(str::to_owned)),
        )
        .map_err(written)?;
    let mut rows = 0;
    for row in text.rows(path, &mut reader) {
        let (line, record) = row?;
        let mut values = [0.0; 26];
        for (k, &column) in inputs.iter().enumerate() {
            values[k] = value(path, line, Worksheet::COLUMNS[k], record[column].trim(), &text)?;
        }
        let sheet = Worksheet::from_values(&values);
        let scores = rula(&sheet, profile).values().into_iter();
        let scores = scores.chain(reba(&sheet, profile).values()).map(|v| v.to_string());
        let cells = copied.iter().map(|&i| record[i].to_owned());
        writer.write_record(cells.chain(scores)).map_err(written)?;
        rows += 1;
    }
    if rows == 0 {
        return Err(InputError::new(path, "holds a header but no rows")
            .remedy("add one row for each posture and side"));
    }
    let csv = writer.into_inner().map_err(|e| written(e.into_error().into()))?;
    Ok(ScoredTable { csv, rows })
}

/// Names of all output columns.
fn outputs() -> impl Iterator<Item = &'static str> {
    RulaSteps::COLUMNS.into_iter().chain(RebaSteps::COLUMNS)
}

/// Where each input stands in the file.
fn input_columns(path: &Path, header: &csv::StringRecord) -> Result<[usize; 26], InputError> {
    let names: Vec<&str> = header.iter().map(str::trim).collect();
    let mut found = [0; 26];
    for (k, wanted) in Worksheet::COLUMNS.iter().enumerate() {
        let mut places = (0..names.len()).filter(|&i| names[i] == *wanted);
        found[k] = places.next().ok_or_else(|| missing(path, wanted, &names))?;
        if places.next().is_some() {
            return Err(InputError::new(path, format!("column `{wanted}` appears twice"))
                .remedy("keep one of them"));
        }
    }
    Ok(found)
}

fn missing(path: &Path, wanted: &str, names: &[&str]) -> InputError {
    // A neighbour that is itself an input is no misspelling of this one.
    let strange = names.iter().copied().filter(|n| !Worksheet::COLUMNS.contains(n));
    let help = suggest(wanted, strange).map_or_else(
        || format!("a worksheet has the columns {}", Worksheet::COLUMNS.join(", ")),
        |found| found.replace("did you mean", "is it the column") + " Rename it",
    );
    InputError::new(path, format!("input column `{wanted}` is missing")).remedy(help)
}

/// What a cell of a column may hold.
fn value(
    path: &Path,
    line: u64,
    column: &str,
    cell: &str,
    text: &CsvText,
) -> Result<f64, InputError> {
    let refuse = |what: &str, remedy: &str| {
        InputError::new(path, format!("line {line}, column `{column}`: `{cell}` {what}"))
            .remedy(remedy)
    };
    let Some(value) = text.number(cell) else {
        return Err(refuse(
            "is not a finite number",
            "fill the cell or remove the row; ergopath does not guess values",
        ));
    };
    match column {
        "load_kg" if value < 0.0 => {
            Err(refuse("is a negative load", "give the load on the hand in kg, 0 or more"))
        }
        "coupling" if ![0.0, 1.0, 2.0, 3.0].contains(&value) => Err(refuse(
            "is no coupling class",
            "use 0 good, 1 fair, 2 poor or 3 unacceptable (REBA)",
        )),
        "load_kg" | "coupling" => Ok(value),
        c if is_angle(c) && value.abs() > LARGEST_ANGLE_DEG => {
            Err(refuse("is no angle in degrees", "angles are in deg, flexion positive"))
        }
        c if is_angle(c) => Ok(value),
        _ if value == 0.0 || value == 1.0 => Ok(value),
        _ => Err(refuse("is neither 0 nor 1", "use 1 where the box is ticked, else 0")),
    }
}

fn is_angle(column: &str) -> bool {
    column.ends_with("_flex")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(text: &str) -> Result<String, InputError> {
        let table = score_table(Path::new("t.csv"), text.as_bytes(), &Profile::default())?;
        Ok(String::from_utf8(table.csv).unwrap())
    }

    /// A table of one neutral posture with one cell changed.
    fn table(column: &str, cell: &str) -> String {
        let cells = Worksheet::COLUMNS.map(|c| match c {
            _ if c == column => cell,
            "elbow_flex" => "80",
            _ => "0",
        });
        format!("id,{},rula_grand\nP-1,{},99\n", Worksheet::COLUMNS.join(","), cells.join(","))
    }

    #[test]
    fn other_columns_are_copied_and_outputs_replaced() {
        let text = scored(&table("", "")).unwrap();
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap().split(',').collect();
        let row: Vec<&str> = lines.next().unwrap().split(',').collect();
        assert_eq!((header.len(), row.len()), (1 + 26 + 30, 57));
        assert_eq!((header[0], row[0]), ("id", "P-1"));
        let grand = header.iter().position(|c| *c == "rula_grand").unwrap();
        assert_eq!((row[grand], header.iter().filter(|c| **c == "rula_grand").count()), ("1", 1));
        // Its own output can be scored again.
        assert_eq!(scored(&text).unwrap(), text);
    }

    #[test]
    fn each_fault_names_line_column_value_and_remedy() {
        for (column, cell, what) in [
            ("neck_flex", "NaN", "not a finite number"),
            ("neck_flex", "", "not a finite number"),
            ("neck_flex", "12,5", "29 cells, but the header has 28"),
            ("trunk_flex", "4000", "no angle"),
            ("load_kg", "-1", "negative load"),
            ("coupling", "4", "no coupling"),
            ("coupling", "1.5", "no coupling"),
            ("sitting", "2", "neither 0 nor 1"),
        ] {
            let error = scored(&table(column, cell)).unwrap_err();
            assert!(error.message().contains(what), "{error}");
            assert!(error.message().contains("line 2"), "{error}");
            assert!(miette::Diagnostic::help(&error).is_some(), "{error}");
        }
        let error = scored(&table("", "").replace("knee_flex", "knee_flx")).unwrap_err();
        assert!(error.message().contains("`knee_flex` is missing"), "{error}");
        assert!(miette::Diagnostic::help(&error).unwrap().to_string().contains("knee_flx"));
        // Written with semicolons it is the same table.
        let semicolons = table("", "").replace(',', ";");
        assert_eq!(scored(&semicolons).unwrap(), scored(&table("", "")).unwrap());
        assert!(scored(&Worksheet::COLUMNS.join(",")).unwrap_err().message().contains("no rows"));
    }
}

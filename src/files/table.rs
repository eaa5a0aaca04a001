//! CSV tables of finite numbers with a header.

use super::error::{InputError, suggest};
use super::text::read_bytes;
use std::path::Path;

/// A table of finite numbers; every row is as long as the header.
#[derive(Debug, Clone, PartialEq)]
pub struct NumericTable {
    file: String,
    /// Column names, in file order.
    pub columns: Vec<String>,
    /// Rows of values, in file order.
    pub rows: Vec<Vec<f64>>,
}

impl NumericTable {
    /// Reads a CSV file. Refused: a cell that is no finite number, a row of another length, a column
    /// named twice, no rows.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(path, &read_bytes(path)?)
    }

    /// Parses CSV bytes; `path` is only named in errors.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
        let broken = |e: csv::Error| {
            InputError::new(path, format!("is not a table: {e}"))
                .remedy("every row needs as many comma-separated cells as the header")
        };
        let columns: Vec<String> =
            reader.headers().map_err(broken)?.iter().map(str::to_owned).collect();
        for (i, name) in columns.iter().enumerate() {
            if columns[..i].contains(name) {
                return Err(InputError::new(path, format!("column `{name}` appears twice")));
            }
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, csv::Position::line);
            let row: Result<Vec<f64>, InputError> = record
                .iter()
                .zip(&columns)
                .map(|(cell, column)| match cell.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => Err(InputError::new(
                        path,
                        format!("line {line}, column `{column}`: `{cell}` is not a finite number"),
                    )
                    .remedy("remove the row or fill the gap; ergopath does not guess values")),
                })
                .collect();
            rows.push(row?);
        }
        if rows.is_empty() {
            return Err(InputError::new(path, "holds a header but no rows"));
        }
        Ok(Self { file: path.display().to_string(), columns, rows })
    }

    /// Index of a column.
    pub fn index(&self, name: &str) -> Result<usize, InputError> {
        self.columns.iter().position(|c| c == name).ok_or_else(|| {
            let known = self.columns.iter().map(String::as_str);
            let help = suggest(name, known.clone()).unwrap_or_else(|| {
                format!("the file has: {}", known.collect::<Vec<_>>().join(", "))
            });
            InputError::new(&self.file, format!("column `{name}` is missing")).remedy(help)
        })
    }

    /// The values of one column.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, InputError> {
        let i = self.index(name)?;
        Ok(self.rows.iter().map(|r| r[i]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<NumericTable, InputError> {
        NumericTable::parse(Path::new("t.csv"), text.as_bytes())
    }

    #[test]
    fn reads_columns_by_name() {
        let t = parse("a, b\n1,2\n3, 4.5\n").unwrap();
        assert_eq!(t.column("b").unwrap(), [2.0, 4.5]);
        assert!(t.column("bb").is_err());
    }

    #[test]
    fn refuses_what_is_not_a_finite_number() {
        let e = parse("a,b\n1,2\n3,nan\n").unwrap_err().to_string();
        assert!(e.contains("line 3") && e.contains("`b`") && e.contains("nan"), "{e}");
        assert!(parse("a,b\n1\n").is_err());
        assert!(parse("a,b\n").is_err());
        assert!(parse("a,a\n1,2\n").is_err());
        assert!(parse("").is_err());
    }
}

//! CSV tables of finite numbers with a header.

use super::delimited::CsvText;
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
    lines: Vec<u64>,
}

impl NumericTable {
    /// Reads a CSV file. Refused: a cell that is no finite number, a row of another length, a column
    /// named twice, no rows.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(path, &read_bytes(path)?)
    }

    /// Parses CSV bytes, written in any way that [`CsvText`] reads; `path` is only named in errors. Empty
    /// rows, and empty columns without a name at the end, are left out: spreadsheets write them.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        let text = CsvText::of(path, bytes)?;
        let mut reader = text.reader();
        let header = reader.headers().map_err(|e| text.broken(path, &e))?;
        let mut columns: Vec<String> = header.iter().map(str::to_owned).collect();
        while columns.len() > 1 && columns.last().is_some_and(String::is_empty) {
            columns.pop();
        }
        for (i, name) in columns.iter().enumerate() {
            if columns[..i].contains(name) {
                return Err(InputError::new(path, format!("column `{name}` appears twice"))
                    .remedy("keep one of the two, or rename one"));
            }
        }
        let (mut rows, mut lines) = (Vec::new(), Vec::new());
        for row in text.rows(path, &mut reader) {
            let (line, record) = row?;
            if let Some(cell) = record.iter().skip(columns.len()).find(|c| !c.is_empty()) {
                let message = format!("line {line}: `{cell}` stands in a column without a name");
                return Err(InputError::new(path, message).remedy("name the column, or empty it"));
            }
            let row: Result<Vec<f64>, InputError> = record
                .iter()
                .zip(&columns)
                .map(|(cell, column)| {
                    text.number(cell).ok_or_else(|| {
                        InputError::new(
                            path,
                            format!(
                                "line {line}, column `{column}`: `{cell}` is not a finite number"
                            ),
                        )
                        .remedy("remove the row or fill the gap; ergopath does not guess values")
                    })
                })
                .collect();
            rows.push(row?);
            lines.push(line);
        }
        if rows.is_empty() {
            return Err(
                InputError::new(path, "holds a header but no rows").remedy("is the file complete?")
            );
        }
        Ok(Self { file: path.display().to_string(), columns, rows, lines })
    }

    /// A table that was read otherwise; `lines` holds the line of each row.
    pub fn of(path: &Path, columns: Vec<String>, rows: Vec<Vec<f64>>, lines: Vec<u64>) -> Self {
        Self { file: path.display().to_string(), columns, rows, lines }
    }

    /// Line of the file on which a row stands, from 1.
    pub fn line(&self, row: usize) -> u64 {
        self.lines.get(row).copied().unwrap_or_default()
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
        let late = parse("# from a logger\n\na,b\n\n1,2\n3,4\n").unwrap();
        assert_eq!((late.line(0), late.line(1)), (5, 6));
    }

    #[test]
    fn what_spreadsheets_leave_empty_is_left_out() {
        let t = parse("a;b;;\n1;2;;\n;;;\n3;4,5;;\n;;;\n").unwrap();
        assert_eq!((t.columns.len(), &t.rows), (2, &vec![vec![1.0, 2.0], vec![3.0, 4.5]]));
        assert_eq!(t.line(1), 4);
        let e = parse("a;b;\n1;2;3\n").unwrap_err().to_string();
        assert!(e.contains("`3` stands in a column without a name"), "{e}");
        assert!(parse("a;b\n1;\n").is_err());
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

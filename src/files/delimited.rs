//! CSV as programs write it: separated by commas, semicolons or tabs, with decimal points or commas,
//! in UTF-8 or UTF-16. One reader and one set of messages for all tables.

use super::error::InputError;
use std::path::Path;

const SAVE_AS: &str = "save the table as comma-separated UTF-8 (CSV UTF-8), with points in numbers";

/// The text of a table and how it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CsvText {
    text: String,
    delimiter: u8,
    /// Lines before the text that are no part of the table.
    skipped: u64,
}

impl CsvText {
    /// Finds out how a table is written; `path` is only named in errors. The separator is that of the
    /// header, or the one that a first line `sep=;` names; numbers may have decimal commas where the
    /// separator is another.
    ///
    /// # Errors
    /// Where the bytes are no UTF-8 or UTF-16, or decimal commas and points stand in one table.
    pub fn of(path: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        let mut text = decoded(bytes)
            .ok_or_else(|| InputError::new(path, "is not UTF-8 text").remedy(SAVE_AS))?;
        let (mut named, mut skipped) = (None, 0);
        if let Some(rest) =
            text.get(..4).filter(|s| s.eq_ignore_ascii_case("sep=")).map(|_| &text[4..])
        {
            let (separator, table) = rest.split_once('\n').unwrap_or((rest, ""));
            named = separator.bytes().next().filter(|b| b",;\t".contains(b));
            (text, skipped) = (table.to_owned(), 1);
        }
        let header = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#'));
        let header = header.unwrap_or_default();
        let in_header = |c: &u8| header.as_bytes().contains(c);
        let delimiter = named.or_else(|| b",;\t".iter().copied().find(in_header)).unwrap_or(b',');
        let table = Self { text, delimiter, skipped };
        table.refuse_both_marks(path)?;
        Ok(table)
    }

    /// A reader of the records; spaces around cells are cut, lines that begin with `#` are left out.
    pub fn reader(&self) -> csv::Reader<&[u8]> {
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).comment(Some(b'#')).delimiter(self.delimiter);
        builder.from_reader(self.text.as_bytes())
    }

    /// A reader of every record as it is.
    pub fn verbatim(&self) -> csv::Reader<&[u8]> {
        let mut builder = csv::ReaderBuilder::new();
        builder.delimiter(self.delimiter).from_reader(self.text.as_bytes())
    }

    /// Line of a record in the file.
    pub fn line(&self, record: &csv::StringRecord) -> u64 {
        let Some(position) = record.position() else { return 0 };
        // The reader counts from the end of the record before; empty lines and comments come first.
        let rest = self.text.get(position.byte() as usize..).unwrap_or_default();
        let before = rest.lines().take_while(|l| l.trim().is_empty() || l.starts_with('#')).count();
        position.line() + before as u64 + self.skipped
    }

    /// The finite number in a cell.
    pub fn number(&self, cell: &str) -> Option<f64> {
        let value = if self.delimiter != b',' && has_decimal_comma(cell) {
            cell.replacen(',', ".", 1).parse::<f64>()
        } else {
            cell.parse::<f64>()
        };
        value.ok().filter(|v| v.is_finite())
    }

    /// What the error of a reader means.
    pub fn broken(&self, path: &Path, error: &csv::Error) -> InputError {
        let line = error
            .position()
            .map_or_else(String::new, |p| format!(": line {}", p.line() + self.skipped));
        let csv::ErrorKind::UnequalLengths { expected_len, len, .. } = error.kind() else {
            return InputError::new(path, format!("is not a table{line}: {error}")).remedy(SAVE_AS);
        };
        let found = if *len == 1 { "1 cell".to_owned() } else { format!("{len} cells") };
        let message = format!("is not a table{line}: {found}, but the header has {expected_len}");
        InputError::new(path, message).remedy(if len > expected_len && self.delimiter == b',' {
            "every row needs as many cells as the header; if numbers have decimal commas, save the \
             table as comma-separated UTF-8 with points in numbers"
        } else {
            "every row needs as many cells as the header"
        })
    }

    /// A table with `0,5` in one cell and `0.5` in another cannot be read without guessing.
    fn refuse_both_marks(&self, path: &Path) -> Result<(), InputError> {
        if self.delimiter == b',' || !self.text.contains(',') {
            return Ok(());
        }
        let separator = char::from(self.delimiter);
        let cells = || self.text.lines().flat_map(|l| l.split(separator)).map(str::trim);
        let comma = cells().find(|c| has_decimal_comma(c));
        let point = cells().find(|c| c.contains('.') && c.parse::<f64>().is_ok());
        let thousands = cells().find(|c| {
            c.contains(',')
                && c.contains('.')
                && c.bytes().all(|b| b"+-0123456789,.eE".contains(&b))
        });
        match (comma, point, thousands) {
            (_, _, Some(cell)) => Err(InputError::new(
                path,
                format!("holds `{cell}`: is the comma or the point the decimal mark?"),
            )
            .remedy(SAVE_AS)),
            (Some(a), Some(b), None) => Err(InputError::new(
                path,
                format!("holds both decimal commas (`{a}`) and decimal points (`{b}`)"),
            )
            .remedy(SAVE_AS)),
            _ => Ok(()),
        }
    }
}

/// Whether a cell is a number with one decimal comma.
fn has_decimal_comma(cell: &str) -> bool {
    cell.matches(',').count() == 1
        && !cell.contains('.')
        && cell.replacen(',', ".", 1).parse::<f64>().is_ok()
}

/// UTF-8 with or without its mark, or UTF-16 (what "Unicode text" of spreadsheets is).
fn decoded(bytes: &[u8]) -> Option<String> {
    let wide = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = rest.chunks_exact(2).map(|b| unit([b[0], b[1]])).collect();
        String::from_utf16(&units).ok()
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => wide(rest, u16::from_be_bytes),
        [a, 0, ..] if *a != 0 => wide(bytes, u16::from_le_bytes),
        [0, a, ..] if *a != 0 => wide(bytes, u16::from_be_bytes),
        [0xEF, 0xBB, 0xBF, rest @ ..] => std::str::from_utf8(rest).ok().map(str::to_owned),
        _ => std::str::from_utf8(bytes).ok().map(str::to_owned),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number of a table, by rows.
    fn numbers(bytes: &[u8]) -> Result<Vec<Vec<f64>>, InputError> {
        let path = Path::new("t.csv");
        let table = CsvText::of(path, bytes)?;
        let mut reader = table.reader();
        let rows = reader.records().map(|r| {
            let record = r.map_err(|e| table.broken(path, &e))?;
            Ok(record.iter().map(|c| table.number(c).unwrap_or(f64::NAN)).collect())
        });
        rows.collect()
    }

    #[test]
    fn the_same_table_in_every_dialect_is_the_same() {
        let comma = "a,b\n1.5,-2e-3\n3,4.25\n";
        let semicolon = "a;b\n1,5;-2e-3\n3;4,25\n";
        let right = vec![vec![1.5, -2e-3], vec![3.0, 4.25]];
        let wide = |text: &str, mark: &[u8], unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.iter().copied().chain(text.encode_utf16().flat_map(unit)).collect()
        };
        for bytes in [
            comma.as_bytes().to_vec(),
            semicolon.as_bytes().to_vec(),
            semicolon.replace(';', "\t").into_bytes(),
            format!("sep=;\r\n{semicolon}").into_bytes(),
            comma.replace(',', ";").into_bytes(),
            [b"\xEF\xBB\xBF", comma.as_bytes()].concat(),
            wide(&semicolon.replace(';', "\t"), &[0xFF, 0xFE], u16::to_le_bytes),
            wide(comma, &[0xFE, 0xFF], u16::to_be_bytes),
            wide(comma, &[], u16::to_le_bytes),
        ] {
            assert_eq!(numbers(&bytes).unwrap(), right, "{}", String::from_utf8_lossy(&bytes));
        }
    }

    #[test]
    fn what_cannot_be_told_is_asked() {
        let refused = |bytes: &[u8]| numbers(bytes).unwrap_err().to_string();
        assert!(refused(b"a;b\n1,5;2.5\n").contains("both decimal commas (`1,5`)"));
        assert!(refused(b"a;b\n1.234,5;2\n").contains("is the comma or the point"));
        assert!(refused(b"a,b\n1,5,2,5\n").contains("line 2: 4 cells, but the header has 2"));
        assert!(refused(b"sep=;\na;b\n1\n").contains("line 3: 1 cell, but the header has 2"));
        assert!(refused(b"a,b\n\xE4,1\n").contains("is not UTF-8 text"));
    }
}

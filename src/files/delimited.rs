//! CSV as programs write it: separated by commas, semicolons or tabs, with decimal points or commas,
//! in UTF-8 or UTF-16. One reader and one set of messages for all tables.

use super::error::InputError;
use std::path::Path;

/// What may part the cells of a table, and how a sentence names it.
const DELIMITERS: [(u8, &str); 3] = [(b',', "commas"), (b';', "semicolons"), (b'\t', "tabs")];
/// How workbooks of spreadsheets begin: zip archives, and the binary files of before.
const WORKBOOKS: [&[u8]; 2] = [b"PK\x03\x04", b"\xD0\xCF\x11\xE0"];

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
    /// header, or the one that a first line `sep=;` names. Numbers may have decimal commas where another
    /// sign separates the cells, or where such cells are quoted.
    ///
    /// # Errors
    /// Where the bytes are a workbook, or no UTF-8 or UTF-16; and where the separator or the decimal mark
    /// would have to be guessed: decimal commas and points in one table, or no other commas in numbers than
    /// such as in `1,234`.
    pub fn of(path: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        if WORKBOOKS.iter().any(|head| bytes.starts_with(head)) {
            return Err(InputError::new(path, "is a workbook, not a table as text").remedy(SAVE_AS));
        }
        let mut text = decoded(bytes)
            .ok_or_else(|| InputError::new(path, "is not UTF-8 text").remedy(SAVE_AS))?;
        let (mut named, mut skipped) = (None, 0);
        if let Some(rest) =
            text.get(..4).filter(|s| s.eq_ignore_ascii_case("sep=")).map(|_| &text[4..])
        {
            let (separator, table) = rest.split_once('\n').unwrap_or((rest, ""));
            let separator = separator.trim_matches(['"', '\r']).bytes().next();
            named = separator.filter(|b| DELIMITERS.iter().any(|(d, _)| d == b));
            (text, skipped) = (table.to_owned(), 1);
        }
        let delimiter = match named {
            Some(delimiter) => delimiter,
            None => delimiter_of(path, &text)?,
        };
        let table = Self { text, delimiter, skipped };
        table.refuse_doubtful_numbers(path)?;
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

    /// The rows below the header, with their lines in the file. Rows whose cells are all empty are left
    /// out: spreadsheets write them.
    pub fn rows<'r>(
        &'r self,
        path: &'r Path,
        reader: &'r mut csv::Reader<&'r [u8]>,
    ) -> impl Iterator<Item = Result<(u64, csv::StringRecord), InputError>> + 'r {
        reader.records().filter_map(move |record| match record {
            Ok(row) if row.iter().all(|cell| cell.trim().is_empty()) => None,
            Ok(row) => Some(Ok((self.line(&row), row))),
            Err(e) => Some(Err(self.broken(path, &e))),
        })
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
        // A comma in a cell separates nothing: it is quoted, or another sign separates.
        let value = if has_decimal_comma(cell) {
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

    /// Numbers that cannot be read without guessing: `0,5` in one cell and `0.5` in another; `1.234,5`; and
    /// `1,234` where no other number says whether the comma groups thousands.
    fn refuse_doubtful_numbers(&self, path: &Path) -> Result<(), InputError> {
        let mark = if self.delimiter == b',' { '"' } else { ',' };
        if !self.text.contains(mark) || !self.text.contains(',') {
            return Ok(());
        }
        let refused = |message: String| Err(InputError::new(path, message).remedy(SAVE_AS));
        let (mut comma, mut point, mut sure) = (None, None, false);
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).comment(Some(b'#')).has_headers(false).flexible(true);
        let mut reader = builder.delimiter(self.delimiter).from_reader(self.text.as_bytes());
        // What is no table is refused where it is read.
        for record in reader.records().map_while(Result::ok) {
            for cell in &record {
                let is_number = cell.bytes().all(|b| b"+-0123456789,.eE".contains(&b));
                let commas = cell.matches(',').count();
                if is_number && (commas > 1 || (commas == 1 && cell.contains('.'))) {
                    return refused(format!(
                        "holds `{cell}`: is the comma or the point the decimal mark?"
                    ));
                }
                if has_decimal_comma(cell) {
                    sure |= !may_group_thousands(cell);
                    comma.get_or_insert_with(|| cell.to_owned());
                } else if cell.contains('.') && cell.parse::<f64>().is_ok() {
                    point.get_or_insert_with(|| cell.to_owned());
                }
            }
        }
        match (comma, point) {
            (Some(a), Some(b)) => {
                refused(format!("holds both decimal commas (`{a}`) and decimal points (`{b}`)"))
            }
            (Some(a), None) if !sure => refused(format!(
                "holds `{a}`, and no number in it tells whether the comma is the decimal mark or \
                 groups thousands"
            )),
            _ => Ok(()),
        }
    }
}

/// The separator of a table that does not name it: the one in its header, outside of quotes. Where the
/// header holds several, the one that parts the first row into as many cells.
fn delimiter_of(path: &Path, text: &str) -> Result<u8, InputError> {
    let mut lines = text.lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
    let (header, row) = (lines.next().unwrap_or_default(), lines.next());
    let there: Vec<(u8, &str)> =
        DELIMITERS.into_iter().filter(|(d, _)| marks(header, *d) > 0).collect();
    let fits = |(d, _): &&(u8, &str)| row.is_some_and(|r| marks(r, *d) == marks(header, *d));
    let fitting: Vec<_> = there.iter().filter(fits).collect();
    match (&there[..], &fitting[..]) {
        ([], _) => Ok(b','),
        ([(only, _)], _) | (_, [(only, _)]) => Ok(*only),
        ([(a, first), (b, second), ..], _) => {
            let message = format!(
                "its header holds {first} and {second}: which of them separate the columns?"
            );
            let remedy = format!(
                "write sep={} or sep={} as its first line, or {SAVE_AS}",
                char::from(*a),
                char::from(*b)
            );
            Err(InputError::new(path, message).remedy(remedy))
        }
    }
}

/// How often a sign stands in a line outside of quotes.
fn marks(line: &str, sign: u8) -> usize {
    let mut is_quoted = false;
    let is_mark = |b: &u8| {
        is_quoted ^= *b == b'"';
        *b == sign && !is_quoted
    };
    line.as_bytes().iter().copied().filter(is_mark).count()
}

/// Whether a number with one comma may as well be a whole number of thousands: `1,234` or `-12,000`.
fn may_group_thousands(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    digits.split_once(',').is_some_and(|(head, tail)| {
        let all = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
        (1..=3).contains(&head.len())
            && tail.len() == 3
            && all(head)
            && all(tail)
            && !head.starts_with('0')
    })
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
    use proptest::prelude::*;

    /// A table as a program writes it: separator, decimal mark, ending of lines; quoted where it must be.
    fn written(rows: &[Vec<f64>], (separator, mark, end): (char, char, &str)) -> String {
        let cell = |text: String| {
            let text = text.replace('.', &mark.to_string());
            if text.contains(separator) { format!("\"{text}\"") } else { text }
        };
        let line = |cells: Vec<String>| cells.join(&separator.to_string()) + end;
        let header = (0..rows[0].len()).map(|i| format!("c{i}")).collect();
        let rows = rows.iter().map(|r| line(r.iter().map(|v| cell(v.to_string())).collect()));
        std::iter::once(line(header)).chain(rows).collect()
    }

    proptest! {
        #[test]
        fn a_table_is_the_same_in_all_dialects(
            rows in (2usize..5).prop_flat_map(|n| prop::collection::vec(
                prop::collection::vec(prop_oneof![-1e6..1e6f64, (-9999..9999i32).prop_map(|v| f64::from(v) / 1e3)], n), 1..6)),
            separator in prop::sample::select(vec![',', ';', '\t']),
            mark in prop::sample::select(vec!['.', ',']),
            end in prop::sample::select(vec!["\n", "\r\n"]),
            coding in 0..5u8,
            names_it in any::<bool>(),
        ) {
            let mut text = written(&rows, (separator, mark, end));
            if names_it {
                text = format!("sep={separator}{end}{text}");
            }
            let wide = |unit: fn(u16) -> [u8; 2], first: &[u8]| -> Vec<u8> {
                first.iter().copied().chain(text.encode_utf16().flat_map(unit)).collect()
            };
            let bytes = match coding {
                0 => text.clone().into_bytes(),
                1 => [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
                2 => wide(u16::to_le_bytes, &[0xFF, 0xFE]),
                3 => wide(u16::to_be_bytes, &[0xFE, 0xFF]),
                _ => wide(u16::to_le_bytes, &[]),
            };
            match numbers(&bytes) {
                Ok(read) => prop_assert_eq!(read, rows),
                // Only where each comma may group thousands.
                Err(e) => {
                    let cells = rows.iter().flatten().map(|v| v.to_string().replace('.', ","));
                    let doubtful = cells.filter(|c| c.contains(',')).all(|c| may_group_thousands(&c));
                    prop_assert!(mark == ',' && doubtful, "{}", e);
                }
            }
        }
    }

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
        for doubtful in ["a;b\n1,234;2\n", "a\tb\n1\t-12,000\n", "a,b\n\"1,234\",2\n"] {
            assert!(refused(doubtful.as_bytes()).contains("groups thousands"), "{doubtful}");
        }
        assert!(refused(b"a,b\n\"1,234,567\",2\n").contains("is the comma or the point"));
        assert!(refused(b"x, m;y\n1,5;2\n").contains("holds commas and semicolons"));
        assert!(refused(b"PK\x03\x04 and more").contains("is a workbook"));
    }

    #[test]
    fn one_number_tells_what_the_commas_of_all_are() {
        let right = vec![vec![1.234, 0.25]];
        for told in ["a;b\n1,234;0,250\n", "a,b\n\"1,234\",\"0,25\"\n"] {
            assert_eq!(numbers(told.as_bytes()).unwrap(), right, "{told}");
        }
        // Signs in the names of columns separate nothing where the rows have others.
        assert_eq!(numbers(b"x, m;y, m;z\n0,5;1;2\n").unwrap(), [[0.5, 1.0, 2.0]]);
        assert_eq!(numbers(b"\"x; m\",y\n0.5,1\n").unwrap(), [[0.5, 1.0]]);
        assert_eq!(numbers(b"sep=;\nx, m;y\n1,5;2\n").unwrap(), [[1.5, 2.0]]);
    }
}

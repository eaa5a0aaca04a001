//! Tables that a spreadsheet opens as text and numbers: no cell is run as a formula.
//!
//! Names come from files of strangers (a robot's joints, markers, people), and a spreadsheet runs a cell that
//! begins as a formula does, which may start programs and send data away. Such a cell gets an apostrophe in front,
//! as OWASP advises ("CSV Injection").

use super::text::is_formula;
use std::path::Path;

/// The bytes of a file as they may be written: a CSV table without formulas, anything else as it is.
pub(super) fn without_formulas(name: &Path, bytes: Vec<u8>) -> Vec<u8> {
    let is_table = name.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    if !is_table || !may_hold_formula(&bytes) {
        return bytes;
    }
    defused(&bytes).unwrap_or(bytes)
}

/// Whether some cell begins with a sign and not as a number does: a quick look that misses none.
fn may_hold_formula(bytes: &[u8]) -> bool {
    let mut is_start = true;
    for (i, byte) in bytes.iter().enumerate() {
        match byte {
            b'=' | b'@' if is_start => return true,
            b'+' | b'-' if is_start => {
                // `-1+...` begins as a number and is none.
                let cell = bytes[i..].split(|b| b",\n\r\"".contains(b)).next();
                let number = cell.and_then(|c| std::str::from_utf8(c).ok()?.parse::<f64>().ok());
                if number.is_none() {
                    return true;
                }
                is_start = false;
            }
            b',' | b'\n' | b'\r' | b'"' => is_start = true,
            byte if byte.is_ascii_whitespace() => {}
            _ => is_start = false,
        }
    }
    false
}

/// The table with an apostrophe before every formula; none where it is no table.
fn defused(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for record in reader.records() {
        let record = record.ok()?;
        let cells = record
            .iter()
            .map(|cell| if is_formula(cell) { format!("'{cell}") } else { cell.to_owned() });
        writer.write_record(cells).ok()?;
    }
    writer.into_inner().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(table: &str) -> String {
        String::from_utf8(without_formulas(Path::new("a.csv"), table.as_bytes().to_vec())).unwrap()
    }

    #[test]
    fn a_formula_becomes_a_text_and_numbers_stay() {
        let plain = "time_s,x_m\n0,-0.5\n1,+2e-3\n2,-inf\n";
        assert_eq!(written(plain), plain);
        assert_eq!(written("name,x\n=cmd|' /C calc'!A0,-1\n"), "name,x\n'=cmd|' /C calc'!A0,-1\n");
        assert_eq!(written("a\n\"=HYPERLINK(1,2)\"\n"), "a\n\"'=HYPERLINK(1,2)\"\n");
        assert_eq!(written("a,b\n @x,-y\n"), "a,b\n' @x,'-y\n");
        assert_eq!(written("a,b\n-2+3+cmd|'x'!A0,-2\n"), "a,b\n'-2+3+cmd|'x'!A0,-2\n");
        // Other files are none of its business.
        let other = without_formulas(Path::new("a.json"), b"=1,\n".to_vec());
        assert_eq!(other, b"=1,\n");
    }
}

//! Reading text and TOML.

use super::error::{InputError, suggest};
use super::exact::Exact;
use super::inputs::note_input;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Largest file that is read at all, and largest TOML, bytes: what is larger is something else.
const LARGEST_FILE: u64 = 2 << 30;
const LARGEST_TOML: usize = 4 << 20;

/// Reads a file whole. Refused: what is no regular file (a pipe would hang, a device has no end), and
/// more than 2 GiB.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    note_input(path);
    let unread = |e: &std::io::Error| {
        let error = InputError::new(path, format!("cannot be read: {}", plain(e)));
        match e.kind() {
            std::io::ErrorKind::NotFound => error.remedy(
                "check the path; paths inside a scenario are relative to the scenario file",
            ),
            _ => error,
        }
    };
    let about = std::fs::metadata(path).map_err(|e| unread(&e))?;
    if about.is_dir() {
        return Err(InputError::new(path, "is a folder, not a file").remedy("name a file in it"));
    }
    if !about.is_file() {
        return Err(InputError::new(path, "is a pipe or a device, not a file")
            .remedy("save the data to a file and name that"));
    }
    if about.len() > LARGEST_FILE {
        let size = about.len() as f64 / f64::from(1u32 << 30);
        return Err(InputError::new(path, format!("is {size:.1} GiB large; at most 2 are read"))
            .remedy("is it the right file? Otherwise cut it into parts"));
    }
    std::fs::read(path).map_err(|e| unread(&e))
}

/// Reads a UTF-8 text file whole.
pub fn read_text(path: &Path) -> Result<String, InputError> {
    String::from_utf8(read_bytes(path)?).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        InputError::new(path, format!("is not UTF-8 text (byte {at})"))
            .remedy("save the file as UTF-8; if it is a binary recording, this is not its reader")
    })
}

/// Parses TOML into a type that refuses unknown keys; the error shows line, caret and suggestion.
/// Arrays of fixed length must have it, and a text of more than 4 MiB is refused.
pub fn parse_toml<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, InputError> {
    if text.len() > LARGEST_TOML {
        return Err(InputError::new(path, "is more than 4 MiB of TOML")
            .remedy("is it the right file? Scenarios, planners and body sheets are a few kB"));
    }
    let parsed = toml::Deserializer::parse(text).and_then(|d| T::deserialize(Exact(d)));
    let parsed = parsed.map_err(|e| {
        let message = e.message().to_owned();
        let mut error = InputError::new(path, shortened(&message));
        if let Some(help) = help_for(&message) {
            error = error.remedy(help);
        }
        match e.span() {
            Some(span) => error.at(text, span),
            None => error,
        }
    })?;
    refuse_odd_numbers(path, text)?;
    Ok(parsed)
}

/// Refuses numbers that TOML allows and nobody means in such a file: `0x10`, `0o7`, `0b1` and `1_0`, of which the
/// last is more often a slip for `1.0` than ten.
fn refuse_odd_numbers(path: &Path, text: &str) -> Result<(), InputError> {
    let Ok(table) = DeTable::parse(text) else { return Ok(()) };
    let mut values: Vec<&toml::Spanned<DeValue>> = table.get_ref().values().collect();
    let mut odd: Option<(std::ops::Range<usize>, &str)> = None;
    while let Some(value) = values.pop() {
        match value.get_ref() {
            DeValue::Array(inner) => values.extend(inner.iter()),
            DeValue::Table(inner) => values.extend(inner.values()),
            DeValue::Integer(_) | DeValue::Float(_) => {
                let span = value.span();
                let written = text.get(span.clone()).unwrap_or_default();
                let digits = written.trim_start_matches(['+', '-']);
                let is_odd = written.contains('_')
                    || ["0x", "0o", "0b"].iter().any(|radix| digits.starts_with(radix));
                // The first in the file is told.
                if is_odd && odd.as_ref().is_none_or(|(first, _)| span.start < first.start) {
                    odd = Some((span, written));
                }
            }
            _ => {}
        }
    }
    let Some((span, written)) = odd else { return Ok(()) };
    let message = format!("`{written}` is a number as programs write it, and may be a slip");
    Err(InputError::new(path, message)
        .remedy("write it with digits and a point only, such as 16 or 1.5")
        .at(text, span))
}

/// The first line, without the list of all known keys (the remedy names the nearest).
fn shortened(message: &str) -> String {
    let line = message.lines().next().unwrap_or_default();
    wrong_length(line)
        .unwrap_or_else(|| line.split(", expected one of").next().unwrap_or_default().to_owned())
}

/// serde's "invalid length 3, expected an array of length 2" as one would say it.
fn wrong_length(line: &str) -> Option<String> {
    let (found, wanted) =
        line.strip_prefix("invalid length ")?.split_once(", expected an array of length ")?;
    let values = if found == "1" { "value" } else { "values" };
    Some(format!("the list has {found} {values} where exactly {wanted} are expected"))
}

/// For serde's "unknown field `x`, expected one of `a`, `b`": the nearest of them.
fn help_for(message: &str) -> Option<String> {
    let is_unknown = message.starts_with("unknown field") || message.starts_with("unknown variant");
    let mut words = message.split('`').skip(1).step_by(2);
    match (is_unknown, words.next()) {
        (true, Some(word)) => {
            let options: Vec<&str> = words.collect();
            suggest(word, options.iter().copied())
                .or_else(|| Some(format!("known here: {}", options.join(", "))))
        }
        _ => None,
    }
}

fn plain(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "no such file".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => e.to_string(),
    }
}

/// Whether a spreadsheet takes a cell of a table for a formula, which may do anything, and not for a text or a
/// number.
pub fn is_formula(cell: &str) -> bool {
    let cell = cell.trim_start();
    cell.starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err()
}

/// SHA-256 of some bytes, in lower-case hexadecimal.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut hex, b| {
        let _ = write!(hex, "{b:02x}");
        hex
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only parsed")]
    struct Worker {
        stature_m: f64,
    }

    #[test]
    fn a_misspelt_key_is_refused_with_a_suggestion() {
        let text = "stature_m = 1.7\nstatur_m = 1.8\n";
        let error = parse_toml::<Worker>(Path::new("w.toml"), text).unwrap_err();
        assert!(error.to_string().contains("unknown field `statur_m`"), "{error}");
        assert_eq!(error.help().unwrap().to_string(), "did you mean `stature_m`?");
        assert_eq!(error.labels().unwrap().next().unwrap().offset(), 16);
    }

    #[test]
    fn an_array_has_its_length_however_deep_it_lies() {
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "only parsed")]
        struct Cell {
            at_m: Option<toml::Spanned<[f64; 2]>>,
            #[serde(default)]
            vias_m: Vec<[f64; 3]>,
            shape: Option<Shape>,
            inner: Option<Box<Cell>>,
        }
        #[derive(Debug, serde::Deserialize)]
        #[serde(tag = "kind", rename_all = "lowercase")]
        #[expect(dead_code, reason = "only parsed")]
        enum Shape {
            Box { size_m: [f64; 3] },
        }
        let parse = |text: &str| parse_toml::<Cell>(Path::new("c.toml"), text);
        parse(
            "at_m = [1, 2]\nvias_m = [[1, 2, 3]]\nshape = { kind = \"box\", size_m = [1, 2, 3] }",
        )
        .unwrap();
        for (text, found, wanted, at) in [
            ("at_m = [1, 2, 3]", 3, 2, 7),
            ("at_m = [1]", 1, 2, 7),
            ("vias_m = [[1, 2, 3], [1, 2, 3, 4, 5]]", 5, 3, 21),
            ("[inner]\nat_m = [1, 2, 3]", 3, 2, 15),
        ] {
            let error = parse(text).unwrap_err();
            let words = format!("the list has {found} value");
            assert!(error.to_string().contains(&words), "{text}: {error}");
            assert!(error.to_string().contains(&format!("exactly {wanted}")), "{text}: {error}");
            assert_eq!(error.labels().unwrap().next().unwrap().offset(), at, "{text}");
        }
        assert!(parse("shape = { kind = \"box\", size_m = [1, 2, 3, 4] }").is_err());
    }

    #[test]
    fn numbers_are_written_with_digits_and_a_point() {
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "only parsed")]
        struct Cell {
            name: String,
            duration_s: f64,
            vias_m: Vec<[f64; 3]>,
            seed: u64,
        }
        let parse = |duration: &str, via: &str, seed: &str| {
            let text = format!(
                "name = \"0x10 1_0\"\nduration_s = {duration}\nvias_m = [[0, 1, {via}]]\nseed = {seed}\n"
            );
            parse_toml::<Cell>(Path::new("c.toml"), &text).map_err(|e| (e.to_string(), text, e))
        };
        for (duration, via, seed) in [("4.0", "-1e-3", "7"), ("+4", "2", "18446744073709551615")] {
            parse(duration, via, seed).unwrap();
        }
        for (duration, via, seed, odd) in [
            ("1_0", "1", "1", "1_0"),
            ("4", "1_0.5", "1", "1_0.5"),
            ("4", "1", "0x10", "0x10"),
            ("0o7", "1", "0b1", "0o7"),
        ] {
            let (words, text, error) = parse(duration, via, seed).unwrap_err();
            assert!(words.contains(&format!("`{odd}` is a number")), "{words}");
            let at = error.labels().unwrap().next().unwrap().offset();
            assert!(text[at..].starts_with(odd), "{words}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn pipes_devices_and_folders_are_refused_at_once() {
        let error = read_bytes(Path::new("/dev/zero")).unwrap_err();
        assert!(error.to_string().contains("a pipe or a device"), "{error}");
        let error = read_bytes(Path::new("/dev")).unwrap_err();
        assert!(error.to_string().contains("is a folder"), "{error}");
    }

    #[test]
    fn formulas_of_spreadsheets_are_no_names() {
        for cell in ["=cmd|' /C calc'!A0", "@SUM(1)", "+1+1", "-a", " =1", "-"] {
            assert!(is_formula(cell), "{cell}");
        }
        for cell in ["-0.1", "+2", "a = b", "2-1", "today", "", "<script>"] {
            assert!(!is_formula(cell), "{cell}");
        }
    }

    #[test]
    fn hash_of_the_empty_input() {
        assert!(sha256_hex(b"").starts_with("e3b0c44298fc1c149afbf4c8996fb924"));
    }
}

//! The checksum that a JSON file of ergopath carries over its own content: an edited figure is told.
//!
//! It is the SHA-256 of the canonical form (RFC 8785, JSON Canonicalization Scheme) of the file's object without
//! the member `checksum`. So spaces, the order of members and the way in which a number is written do not count,
//! and every digit of every number does (of whole numbers above 2^53 those that a double holds).
//!
//! It tells of slips, broken copies and edits; it is no signature. Who means an edit removes the member, and is
//! warned from then on that edits cannot be seen.

use super::error::InputError;
use super::text::sha256_hex;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// Name of the member.
pub const CHECKSUM: &str = "checksum";

/// Whether a file can say that nobody changed it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Seal {
    /// Its checksum fits.
    #[default]
    Whole,
    /// It carries none, so that nothing is known.
    Missing,
}

/// A value as the text of a file that carries a checksum, on one line.
pub fn sealed_json<T: Serialize>(value: &T) -> Result<String, serde_json::Error> {
    sealed(&(serde_json::to_string(value)? + "\n"))
}

/// The same on as many lines as it has members.
pub fn sealed_pretty_json<T: Serialize>(value: &T) -> Result<String, serde_json::Error> {
    sealed(&(serde_json::to_string_pretty(value)? + "\n"))
}

/// The text of a JSON object with its checksum as the last member and no other byte changed. What is no object
/// stays as it is, and a checksum that is there already is replaced.
pub fn sealed(text: &str) -> Result<String, serde_json::Error> {
    let mut value: Value = serde_json::from_str(text)?;
    let Some(object) = value.as_object_mut() else { return Ok(text.to_owned()) };
    if object.remove(CHECKSUM).is_some() {
        return sealed(&(serde_json::to_string(&value)? + "\n"));
    }
    let is_empty = object.is_empty();
    let sum = checksum(&value)?;
    let Some(inside) = text.trim_end().strip_suffix('}') else { return Ok(text.to_owned()) };
    let members = inside.trim_end();
    let comma = if is_empty { "" } else { "," };
    Ok(if inside.ends_with('\n') {
        format!("{members}{comma}\n  \"{CHECKSUM}\": \"{sum}\"\n}}\n")
    } else {
        format!("{members}{comma}\"{CHECKSUM}\":\"{sum}\"}}\n")
    })
}

/// Takes the checksum out of an object and compares it with the rest.
///
/// # Errors
/// Where it does not fit: the file was changed since it was written. `remedy` says how it is made anew.
pub fn take_seal(path: &Path, value: &mut Value, remedy: &str) -> Result<Seal, InputError> {
    let Some(found) = value.as_object_mut().and_then(|o| o.remove(CHECKSUM)) else {
        return Ok(Seal::Missing);
    };
    let sum = checksum(value).map_err(|e| InputError::new(path, e.to_string()))?;
    if found.as_str() == Some(&sum) {
        return Ok(Seal::Whole);
    }
    let message = "was changed since it was written: its content does not fit its checksum";
    Err(InputError::new(path, message).remedy(format!(
        "{remedy}, or restore the file; if the change is meant, remove the member `{CHECKSUM}`: the file is then \
         used with a warning"
    )))
}

fn checksum(value: &Value) -> Result<String, serde_json::Error> {
    Ok(sha256_hex(&serde_json_canonicalizer::to_vec(value)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "{\"schema\":\"x/1\",\"a\":[1.5,0.1,1e-7,100.0],\"b\":{\"d\":null,\"c\":\"\u{e4}\"}}\n";

    fn take(text: &str) -> Result<Seal, String> {
        let mut value: Value = serde_json::from_str(text).unwrap();
        let taken = take_seal(Path::new("m.json"), &mut value, "train it again");
        assert!(value.get(CHECKSUM).is_none());
        taken.map_err(|e| e.to_string())
    }

    #[test]
    fn the_checksum_is_that_of_the_canonical_form() {
        // What RFC 8785 makes of it, typed by hand.
        let canonical =
            "{\"a\":[1.5,0.1,1e-7,100],\"b\":{\"c\":\"\u{e4}\",\"d\":null},\"schema\":\"x/1\"}";
        let wanted = format!(",\"checksum\":\"{}\"}}\n", sha256_hex(canonical.as_bytes()));
        let text = sealed(TEXT).unwrap();
        assert!(text.ends_with(&wanted), "{text} {wanted}");
        assert_eq!(text.replace(&wanted, "}\n"), TEXT);
        assert_eq!(take(&text), Ok(Seal::Whole));
        assert_eq!(sealed(&text).map(|t| take(&t)).unwrap(), Ok(Seal::Whole));
    }

    #[test]
    fn spaces_order_and_spelling_do_not_count_and_every_digit_does() {
        let text = sealed(TEXT).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        let pretty = serde_json::to_string_pretty(&value).unwrap();
        assert_eq!(take(&pretty), Ok(Seal::Whole));
        assert_eq!(take(&text.replace("100.0", "1e2").replace("1.5", "1.50")), Ok(Seal::Whole));
        for (from, to) in [
            ("0.1,", "0.10000000000000002,"),
            ("null", "0"),
            ("[1.5,", "[1.5,1.5,"),
            ("\"c\"", "\"e\""),
            ("\u{e4}", "a"),
            ("\"a\":[", "\"extra\":1,\"a\":["),
        ] {
            let error = take(&text.replacen(from, to, 1)).unwrap_err();
            assert!(error.contains("m.json: was changed since it was written"), "{error}");
        }
        // A checksum that is none does not pass for one that is missing.
        let sum = value[CHECKSUM].as_str().unwrap();
        for broken in ["null", "7", "\"\"", "\"x\""] {
            assert!(take(&text.replace(&format!("\"{sum}\""), broken)).is_err(), "{broken}");
        }
        assert_eq!(take(TEXT), Ok(Seal::Missing));
    }

    #[test]
    fn many_lines_stay_many_lines() {
        let text = sealed("{\n  \"a\": 1\n}\n").unwrap();
        assert!(
            text.starts_with("{\n  \"a\": 1,\n  \"checksum\": \"") && text.ends_with("\"\n}\n")
        );
        assert_eq!(take(&text), Ok(Seal::Whole));
        assert_eq!(take(&sealed("{}").unwrap()), Ok(Seal::Whole));
        assert_eq!(sealed("[1]\n").unwrap(), "[1]\n");
    }
}

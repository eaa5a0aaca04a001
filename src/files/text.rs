//! Reading text and TOML.

use super::error::{InputError, suggest};
use super::inputs::note_input;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::Path;

/// Reads a file whole.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    note_input(path);
    std::fs::read(path).map_err(|e| {
        let error = InputError::new(path, format!("cannot be read: {}", plain(&e)));
        match e.kind() {
            std::io::ErrorKind::NotFound => error.remedy(
                "check the path; paths inside a scenario are relative to the scenario file",
            ),
            _ => error,
        }
    })
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
pub fn parse_toml<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, InputError> {
    toml::from_str(text).map_err(|e| {
        let message = e.message().to_owned();
        let mut error = InputError::new(path, shortened(&message));
        if let Some(help) = help_for(&message) {
            error = error.remedy(help);
        }
        match e.span() {
            Some(span) => error.at(text, span),
            None => error,
        }
    })
}

/// The first line, without the list of all known keys (the remedy names the nearest).
fn shortened(message: &str) -> String {
    let line = message.lines().next().unwrap_or_default();
    line.split(", expected one of").next().unwrap_or_default().to_owned()
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
    fn hash_of_the_empty_input() {
        assert!(sha256_hex(b"").starts_with("e3b0c44298fc1c149afbf4c8996fb924"));
    }
}

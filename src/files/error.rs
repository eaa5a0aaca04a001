//! The one error for input that a person can mend: file, place, value, remedy.

use miette::{Diagnostic, NamedSource, SourceSpan};
use std::io;
use std::path::Path;
use thiserror::Error;

/// What is wrong with an input, where, and what to do about it.
///
/// Shown with the offending line and a caret when the place is known.
#[derive(Debug, Error, Diagnostic)]
#[error("{file}: {message}")]
pub struct InputError {
    file: String,
    message: String,
    #[source_code]
    text: Option<NamedSource<String>>,
    #[label("here")]
    span: Option<SourceSpan>,
    #[help]
    help: Option<String>,
    is_fault: bool,
}

impl InputError {
    /// An error in the file (or other named input) as a whole.
    pub fn new(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self {
            file: file.as_ref().display().to_string(),
            message: message.into(),
            text: None,
            span: None,
            help: None,
            is_fault: false,
        }
    }

    /// What no other input would mend: the program or the machine failed.
    pub fn fault(what: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self { is_fault: true, ..Self::new(what, message) }
    }

    /// A place that could not be written: a name that cannot work is the caller's to mend, a full or
    /// broken disk is a fault of the machine.
    pub fn unwritable(place: impl AsRef<Path>, error: &io::Error) -> Self {
        use io::ErrorKind as Kind;
        // The words of the kind, where there are any: those of the system name temporary files.
        let why = match error.kind().to_string() {
            kind if kind.starts_with("uncategorized") || kind.starts_with("other") => {
                error.to_string()
            }
            kind => kind,
        };
        let message = format!("cannot be written: {why}");
        match error.kind() {
            Kind::PermissionDenied
            | Kind::ReadOnlyFilesystem
            | Kind::NotADirectory
            | Kind::IsADirectory
            | Kind::NotFound
            | Kind::AlreadyExists
            | Kind::InvalidFilename
            | Kind::InvalidInput => Self::new(place, message).remedy("write to another place"),
            Kind::StorageFull | Kind::QuotaExceeded | Kind::FileTooLarge => {
                Self::fault(place, message).remedy("make room, or write to another place")
            }
            _ => Self::fault(place, message),
        }
    }

    /// Whether the program or the machine failed, and not the input.
    pub fn is_fault(&self) -> bool {
        self.is_fault
    }

    /// Adds the remedy.
    #[must_use]
    pub fn remedy(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds the place: a byte range of the text, shown with line, column and caret.
    #[must_use]
    pub fn at(mut self, text: &str, range: std::ops::Range<usize>) -> Self {
        let start = range.start.min(text.len());
        let end = range.end.clamp(start, text.len());
        self.text = Some(NamedSource::new(&self.file, text.to_owned()));
        self.span = Some((start, end - start).into());
        self
    }

    /// Adds the place, unless there is one already.
    #[must_use]
    pub fn or_at(self, text: &str, range: std::ops::Range<usize>) -> Self {
        if self.span.is_some() { self } else { self.at(text, range) }
    }

    /// The error of an input that another file names: with that file and place in front, and its own
    /// remedy kept. Where it shows a place of its own, that stays.
    #[must_use]
    pub fn named_in(
        self,
        file: &Path,
        key: &str,
        text: &str,
        range: std::ops::Range<usize>,
    ) -> Self {
        if self.span.is_some() {
            let message = format!("{} ({key} in {})", self.message, file.display());
            return Self { message, ..self };
        }
        let error = Self::new(file, format!("{key}: {}: {}", self.file, self.message));
        Self { help: self.help, ..error }.at(text, range)
    }

    /// What is wrong, without file and remedy.
    pub fn message(&self) -> &str {
        &self.message
    }
}

/// "did you mean `x`?" for a misspelt word, if one of the options is near enough.
pub fn suggest<'a>(word: &str, options: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let near = |o: &&str| strsim::damerau_levenshtein(&word.to_lowercase(), &o.to_lowercase());
    let best = options.into_iter().min_by_key(near)?;
    let limit = (word.len().max(best.len()) / 3).max(1);
    (near(&best) <= limit).then(|| format!("did you mean `{best}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_are_near_or_absent() {
        let keys = ["stature_m", "mass_kg", "facing_deg"];
        assert_eq!(suggest("statur_m", keys).unwrap(), "did you mean `stature_m`?");
        assert_eq!(
            suggest("facing_degrees", ["facing_deg"]).unwrap(),
            "did you mean `facing_deg`?"
        );
        assert!(suggest("colour", keys).is_none());
    }
}

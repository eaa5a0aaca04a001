//! The one error for input that a person can mend: file, place, value, remedy.

use miette::{Diagnostic, NamedSource, SourceSpan};
use std::io;
use std::path::Path;
use thiserror::Error;

/// Longest line that is shown whole, bytes. Columns beyond some ten thousand cannot be drawn at all.
const LONGEST_LINE: usize = 1000;
/// Longest message and longest remedy, bytes.
const LONGEST_MESSAGE: usize = 4000;
/// Longest word for which a like one is looked for, bytes.
const LONGEST_WORD: usize = 100;

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
            message: within(message.into()),
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
        self.help = Some(within(help.into()));
        self
    }

    /// Adds the place: a byte range of the text, shown with line, column and caret. In a line that is too long to
    /// be shown, it is told in words.
    #[must_use]
    pub fn at(mut self, text: &str, range: std::ops::Range<usize>) -> Self {
        let start = text.floor_char_boundary(range.start);
        let end = text.floor_char_boundary(range.end).max(start);
        let line = text[..start].rfind('\n').map_or(0, |i| i + 1);
        if start - line > LONGEST_LINE {
            let number = 1 + text[..line].matches('\n').count();
            let column = 1 + text[line..start].chars().count();
            self.message = format!("{} (line {number}, column {column})", self.message);
            return self;
        }
        let (text, [start, end]) = with_short_lines(text, [start, end]);
        self.text = Some(NamedSource::new(&self.file, text));
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

/// Words of an error that can be shown: names in them may be of any length.
fn within(mut words: String) -> String {
    if words.len() > LONGEST_MESSAGE {
        words.truncate(words.floor_char_boundary(LONGEST_MESSAGE));
        words.push_str(" ...");
    }
    words
}

/// A text with its long lines cut, and where its places are then.
fn with_short_lines(text: &str, places: [usize; 2]) -> (String, [usize; 2]) {
    let (mut short, mut moved) = (String::with_capacity(text.len()), places);
    let mut from = 0;
    for line in text.split_inclusive('\n') {
        let whole = line.strip_suffix('\n').unwrap_or(line);
        let kept = &whole[..whole.floor_char_boundary(LONGEST_LINE)];
        for (place, moved) in places.iter().zip(&mut moved) {
            if (from..=from + line.len()).contains(place) {
                *moved = short.len() + (place - from).min(kept.len());
            }
        }
        short.push_str(kept);
        if kept.len() < whole.len() {
            short.push_str(" ...");
        }
        if whole.len() < line.len() {
            short.push('\n');
        }
        from += line.len();
    }
    (short, moved)
}

/// "did you mean `x`?" for a misspelt word, if one of the options is near enough.
pub fn suggest<'a>(word: &str, options: impl IntoIterator<Item = &'a str>) -> Option<String> {
    if word.len() > LONGEST_WORD {
        return None;
    }
    let near = |o: &&str| strsim::damerau_levenshtein(&word.to_lowercase(), &o.to_lowercase());
    let best = options.into_iter().min_by_key(near)?;
    let limit = (word.len().max(best.len()) / 3).max(1);
    (near(&best) <= limit).then(|| format!("did you mean `{best}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error as a terminal shows it.
    fn drawn(error: &InputError) -> String {
        let mut text = String::new();
        let theme = miette::GraphicalTheme::unicode_nocolor();
        miette::GraphicalReportHandler::new_themed(theme).render_report(&mut text, error).unwrap();
        text
    }

    #[test]
    fn a_place_in_a_long_line_is_told_however_long_it_is() {
        let long = "\u{e9}".repeat(100_000);
        let text = format!("{long}\na = 1 # {long}\nb = {long}\n");
        let at = |range| InputError::new("t.toml", "is odd").at(&text, range);
        let a = text.find("a = ").unwrap();
        let near = drawn(&at(a..a + 1));
        assert!(near.contains("[t.toml:2:1]") && near.contains("a = 1 #"), "{near}");
        assert!(near.len() < 20_000, "{}", near.len());
        // A label that ends beyond what is shown, and one that begins there.
        let whole = drawn(&at(a..text.len()));
        assert!(whole.contains("t.toml:2:1"), "{whole}");
        let far = at(text.len() - 3..text.len() - 1);
        assert_eq!(far.to_string(), "t.toml: is odd (line 3, column 100004)");
        assert!(!drawn(&far).contains("here"));
        assert!(drawn(&at(text.len()..text.len())).contains("t.toml"));
        assert!(suggest(&long, ["a"]).is_none());
        let long = InputError::new("t.toml", format!("no `{long}`")).remedy(long);
        assert!(drawn(&long).len() < 40_000);
    }

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

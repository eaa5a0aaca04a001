//! Motion files that are lines of words, and what is wrong in one of them.

use crate::files::InputError;
use std::path::Path;
use std::str::SplitWhitespace;

/// What no angle and no length of a person reaches in any unit.
const LARGEST: f64 = 1e9;

/// What is wrong in a text, and on which line (from 1) where it is one line.
#[derive(Debug)]
pub(super) struct Fault {
    pub line: Option<usize>,
    pub message: String,
    pub remedy: &'static str,
}

impl Fault {
    /// A fault of one line.
    pub(super) fn at(line: usize, message: impl Into<String>, remedy: &'static str) -> Self {
        Self { line: Some(line), message: message.into(), remedy }
    }

    /// A fault of the whole text.
    pub(super) fn whole(message: impl Into<String>, remedy: &'static str) -> Self {
        Self { line: None, message: message.into(), remedy }
    }

    /// The fault as an error of a file.
    pub(super) fn of(self, path: &Path) -> InputError {
        let message = match self.line {
            Some(line) => format!("line {line}: {}", self.message),
            None => self.message,
        };
        InputError::new(path, message).remedy(self.remedy)
    }
}

/// A line that is not empty: its number from 1, its first word, and the words after it.
pub(super) struct Line<'a> {
    pub number: usize,
    pub first: &'a str,
    pub rest: SplitWhitespace<'a>,
}

impl Line<'_> {
    /// A fault of this line.
    pub(super) fn fault(&self, message: impl Into<String>, remedy: &'static str) -> Fault {
        Fault::at(self.number, message, remedy)
    }

    /// The next word as a number of a sane size.
    pub(super) fn number(&mut self, remedy: &'static str) -> Result<f64, Fault> {
        let Some(word) = self.rest.next() else {
            return Err(self.fault(format!("`{}` lacks a number", shown(self.first)), remedy));
        };
        number(word).ok_or_else(|| {
            let message = format!("`{}`: `{}` is no number", shown(self.first), shown(word));
            self.fault(message, remedy)
        })
    }

    /// The next three words as such numbers.
    pub(super) fn three(&mut self, remedy: &'static str) -> Result<[f64; 3], Fault> {
        Ok([self.number(remedy)?, self.number(remedy)?, self.number(remedy)?])
    }
}

/// The lines that hold words; `#` begins a comment.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let mut rest = line.split('#').next().unwrap_or_default().split_whitespace();
        Some(Line { number: i + 1, first: rest.next()?, rest })
    })
}

/// A word as shown in errors: garbage can be long.
pub(super) fn shown(word: &str) -> String {
    word.chars().take(40).collect()
}

/// A word as a number of a sane size.
pub(super) fn number(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|value| value.abs() <= LARGEST)
}

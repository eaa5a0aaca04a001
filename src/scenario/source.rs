//! The text behind a scenario: refusals that show the place, and the values that every part needs.

use super::plausible::Doubt;
use crate::files::InputError;
use crate::physical::{COORDINATE_M, GRIP_M, shown};
use std::cell::RefCell;
use std::path::Path;
use toml::Spanned;

/// The text behind a scenario, for errors that show the place.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub folder: &'a Path,
    /// What looks odd and may be meant.
    pub doubts: RefCell<Vec<Doubt>>,
}

impl Source<'_> {
    pub(super) fn error<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message).at(self.text, at.span())
    }

    /// The error of another file that a value names.
    pub(super) fn named<T>(&self, at: &Spanned<T>, key: &str, error: InputError) -> InputError {
        error.named_in(self.path, key, self.text, at.span())
    }

    /// A refusal that asks.
    pub(super) fn question(&self, doubt: &Doubt) -> InputError {
        doubt.question(self.path)
    }

    /// Keeps a doubt as a warning.
    pub(super) fn doubt(&self, doubt: Option<Doubt>) {
        self.doubts.borrow_mut().extend(doubt);
    }

    /// The place in the text of an error, for values whose own place is not kept.
    pub(super) fn at<T>(&self, at: &Spanned<T>, error: InputError) -> InputError {
        error.at(self.text, at.span())
    }

    pub(super) fn plain(&self, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message)
    }

    /// A finite number in a range.
    pub(super) fn number(
        &self,
        at: &Spanned<f64>,
        key: &str,
        low: f64,
        high: f64,
    ) -> Result<f64, InputError> {
        let value = *at.get_ref();
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(self
            .error(at, format!("{key} = {} is outside {low} to {high}", shown(value)))
            .remedy("check value and unit: metres, seconds, kilograms; degrees only in keys that end in _deg"))
    }

    /// The same for errors that may know a nearer place.
    pub(super) fn beside<T>(&self, at: &Spanned<T>, error: InputError) -> InputError {
        error.or_at(self.text, at.span())
    }

    /// Refuses coordinates that no cell has.
    pub(super) fn refuse_far(&self, key: &str, position_m: &[f64]) -> Result<(), InputError> {
        match COORDINATE_M.outside(position_m.iter().copied()) {
            Some(value) => Err(self.question(&Doubt::Millimetres { place: key.to_owned(), value })),
            None => Ok(()),
        }
    }

    /// Refuses a place of a hand on the tool that no hand reaches from there.
    pub(super) fn refuse_off_tool(&self, key: &str, place_m: &[f64; 3]) -> Result<(), InputError> {
        self.refuse_far(key, place_m)?;
        match GRIP_M.outside(place_m.iter().copied()) {
            Some(value) => Err(self
                .plain(format!(
                    "{key} holds {} m: no hand is held so far from the tool",
                    shown(value)
                ))
                .remedy(format!("give metres from the TCP, {GRIP_M}"))),
            None => Ok(()),
        }
    }
}

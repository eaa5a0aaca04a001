//! Questions on the terminal: what options leave open is asked where somebody can answer, and takes its
//! default elsewhere.

use crate::files::InputError;
use dialoguer::Input;
use std::io::{IsTerminal, stderr, stdin};

/// Asks a question with a default, and gives the answer as it was typed.
pub(super) type Asker<'a> = Box<dyn FnMut(&str, &str) -> Result<String, InputError> + 'a>;

/// The terminal, where standard input and the questions are on one.
pub(super) fn terminal() -> Option<Asker<'static>> {
    if !stdin().is_terminal() || !stderr().is_terminal() {
        return None;
    }
    Some(Box::new(|words, default| {
        let input = Input::<String>::new().with_prompt(words).default(default.to_owned());
        input.interact_text().map_err(|e| InputError::new("terminal", e.to_string()))
    }))
}

/// Answers from options, a person and defaults.
pub(super) struct Answers<'a> {
    asker: Option<Asker<'a>>,
    /// Defaults that nobody was asked about, in words.
    pub taken: Vec<String>,
}

impl<'a> Answers<'a> {
    pub(super) fn new(asker: Option<Asker<'a>>) -> Self {
        Self { asker, taken: Vec::new() }
    }

    /// What was given, or the answer to a question (key, words), asked again until it can be read.
    pub(super) fn of<T>(
        &mut self,
        given: Option<T>,
        (key, words): (&str, &str),
        default: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, InputError> {
        if let Some(given) = given {
            return Ok(given);
        }
        let Some(ask) = &mut self.asker else {
            self.taken.push(format!("{key} = {default}"));
            return read(default).map_err(|e| InputError::fault(key, e));
        };
        loop {
            match read(ask(words, default)?.trim()) {
                Ok(value) => return Ok(value),
                Err(why) => complain!("  {why}"),
            }
        }
    }
}

/// A list in words.
pub(super) fn names(all: &[&str]) -> String {
    all.join(", ")
}

/// A finite number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| v.is_finite());
    value.ok_or_else(|| format!("`{text}` is no number; use a point as decimal mark"))
}

/// A place: three numbers.
pub(super) fn place(text: &str) -> Result<[f64; 3], String> {
    let text = text.trim_matches(['[', ']', '(', ')']);
    let numbers: Result<Vec<f64>, String> = text.split(',').map(|t| number(t.trim())).collect();
    numbers?.try_into().map_err(|_| "give three numbers, such as 0.4, -0.25, 1.0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_cannot_be_read_is_asked_for_again() {
        let mut all = ["many", "0.4, 0.1", "[0.4, -0.1, 1]"].into_iter();
        let ask = |_: &str, _: &str| Ok(all.next().unwrap_or_default().to_owned());
        let mut answers = Answers::new(Some(Box::new(ask)));
        let read = answers.of(None, ("from", "Where"), "0, 0, 0", place).unwrap();
        assert_eq!(read, [0.4, -0.1, 1.0]);
        assert!(place("nan, 0, 0").is_err() && place("0,4; 1").is_err());
    }
}

//! What was assumed of a recording, or looks odd in it; and how many recordings are told of at once.

use serde::Serialize;

/// What remarks on long gaps are about.
pub const BORDERS: &str = "borders";

/// Something that a reader should know of one recording; in JSON its text.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct Remark {
    /// What it is about: remarks of several recordings about the same are told once, so those of one
    /// recording differ in it.
    pub about: String,
    /// How much it weighs among those about the same, in a unit of its own.
    pub size: f64,
    /// For people to read.
    pub text: String,
}

impl From<Remark> for String {
    fn from(remark: Remark) -> Self {
        remark.text
    }
}

impl Remark {
    /// A remark that weighs nothing.
    pub fn new(about: impl Into<String>, text: impl Into<String>) -> Self {
        Self { about: about.into(), size: 0.0, text: text.into() }
    }

    /// The same, of a size.
    #[must_use]
    pub fn of_size(self, size: f64) -> Self {
        Self { size, ..self }
    }
}

/// One line for each thing that remarks are about, in the order in which they come up: of the recording
/// where it weighs most, and of how many it holds.
pub fn grouped(recordings: &[(&str, &[Remark])]) -> Vec<String> {
    let mut groups: Vec<(&Remark, &str, Vec<&str>, bool)> = Vec::new();
    for (name, remarks) in recordings {
        for remark in *remarks {
            match groups.iter_mut().find(|(largest, ..)| largest.about == remark.about) {
                None => groups.push((remark, name, vec![name], true)),
                Some((largest, where_largest, names, is_same)) => {
                    *is_same &= remark.text == largest.text;
                    if !names.contains(name) {
                        names.push(name);
                    }
                    if remark.size > largest.size {
                        (*largest, *where_largest) = (remark, name);
                    }
                }
            }
        }
    }
    let all = recordings.len();
    let line = |(remark, name, names, is_same): (&Remark, &str, Vec<&str>, bool)| {
        let text = &remark.text;
        let of = if names.len() == all {
            format!("in all {all} recordings")
        } else {
            format!("in {} of {all} recordings", names.len())
        };
        match (names.len(), is_same) {
            (1, _) => format!("{name}: {text}"),
            (n, true) if n == all => format!("{of}: {text}"),
            (_, true) => format!("{of}, first in {name}: {text}"),
            (_, false) => format!("{of}, most in {name}: {text}"),
        }
    };
    groups.into_iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_several_recordings_share_is_told_once_with_the_worst() {
        let rate = || Remark::new("rate", "rate taken as 120 Hz");
        let steps = |share: f64| Remark::new("steps", format!("steps {share}")).of_size(share);
        let [a, b, c] = [vec![rate(), steps(2.0)], vec![rate(), steps(7.0)], vec![rate()]];
        let told = grouped(&[("a", &a), ("b", &b), ("c", &c)]);
        assert_eq!(
            told,
            [
                "in all 3 recordings: rate taken as 120 Hz",
                "in 2 of 3 recordings, most in b: steps 7"
            ]
        );
    }

    #[test]
    fn a_single_recording_is_named() {
        let remarks = [Remark::new("jumps of Head", "jumps"), Remark::new("feet", "steps")];
        assert_eq!(grouped(&[("a", &remarks)]), ["a: jumps", "a: steps"]);
    }
}

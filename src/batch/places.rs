//! Where things stand in a TOML text, for carets and for the order in which they were written.

use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// A step into a TOML document.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// The byte range of a value; that of the last part on the way that is there where it is not, and none
/// where the text cannot be parsed.
pub(super) fn place(text: &str, steps: &[Step]) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut found = None;
    let mut table = Some(document.get_ref());
    let mut value: Option<&DeValue> = None;
    for step in steps {
        let next = match step {
            Step::Key(key) => table.and_then(|t| t.get(*key)),
            Step::Index(k) => value.and_then(|v| v.as_array()).and_then(|a| a.get(*k)),
        };
        let Some(next) = next else { break };
        found = Some(next.span());
        value = Some(next.get_ref());
        table = next.get_ref().as_table();
    }
    found
}

/// Leaves of a table, each with its way: tables are gone into, everything else is a leaf.
pub(super) fn leaves(table: &toml::Table) -> Vec<(Vec<String>, &toml::Value)> {
    let mut all = Vec::new();
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => all.extend(leaves(inner).into_iter().map(|(way, v)| {
                let way = std::iter::once(key.clone()).chain(way).collect();
                (way, v)
            })),
            _ => all.push((vec![key.clone()], value)),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_text() {
        let text = "[matrix]\nworker.at_m = [[0.0, 0.1], [0.2, 0.3]]\n\"a.b\" = 1\n";
        let at = |steps: &[Step]| place(text, steps).map(|r| &text[r]);
        let way = [Step::Key("matrix"), Step::Key("worker"), Step::Key("at_m")];
        assert_eq!(at(&way), Some("[[0.0, 0.1], [0.2, 0.3]]"));
        assert_eq!(at(&[&way[..], &[Step::Index(1)]].concat()), Some("[0.2, 0.3]"));
        assert_eq!(at(&[Step::Key("matrix"), Step::Key("a.b")]), Some("1"));
        assert_eq!(at(&[Step::Key("nothing")]), None);
        assert_eq!(place("a = ", &[Step::Key("a")]), None);
    }

    #[test]
    fn leaves_are_told_with_their_ways() {
        let table: toml::Table = "a.b = [1]\nc = 2\n[d]\n".parse().unwrap();
        let found: Vec<String> = leaves(&table).into_iter().map(|(w, _)| w.join(".")).collect();
        assert_eq!(found, ["a.b", "c"]);
    }
}

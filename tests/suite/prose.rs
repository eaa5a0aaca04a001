//! House law: what decides is a typed fact, never the sentence that is made of it.

use crate::layers::source_files;
use std::fs;
use std::path::Path;

/// Where sentences are made or shown; below, nothing may read them.
const SPEAKERS: &[&str] = &["words", "report", "cli"];
/// Searches of text.
const SEARCHES: &[&str] = &[
    ".contains(",
    ".starts_with(",
    ".ends_with(",
    ".split(",
    ".split_once(",
    ".strip_prefix(",
    ".strip_suffix(",
    ".find(",
    ".rfind(",
    ".matches(",
    "== ",
    "!= ",
];
/// Text of other programs, or names that happen to hold a space: file, what stands on the line, and why
/// it may.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("files/text.rs", ", expected one of", "the message of a parser, made shorter"),
    ("files/text.rs", "unknown field", "a parser tells the kind of its error by its message only"),
    ("files/text.rs", "invalid length", "the same"),
    ("scenario/plausible.rs", "without ", "the prefix of names of ours that a path may not have"),
    ("training/toy5r_experiment.rs", "MI in-sample", "the name of a method in the paper's figure"),
    ("training/toy5r_experiment.rs", "MI leave-one-out", "the same"),
];

/// Whether a string literal reads as words rather than as a key or a sign.
fn is_prose(literal: &str) -> bool {
    let is_word = |w: &str| w.chars().any(char::is_alphabetic);
    literal.split(' ').filter(|w| is_word(w)).count() > 1
        || literal.contains('`')
        || (literal.contains(' ') && literal.split(' ').any(is_word))
}

/// Lines outside tests on which a decision is read from a sentence.
fn read_prose(shown: &str, text: &str) -> Vec<String> {
    let is_tests = |(at, mark): &(usize, &str)| {
        text[at + mark.len()..].lines().next().is_some_and(|l| l.ends_with('{'))
    };
    let tests = text.match_indices("#[cfg(test)]\n").find(is_tests).map_or(text.len(), |t| t.0);
    let code = &text[..tests];
    let mut found = Vec::new();
    for (n, line) in code.lines().enumerate() {
        let line = line.split("//").next().unwrap_or_default();
        let is_read = SEARCHES.iter().any(|search| {
            line.split(search).skip(1).any(|rest| {
                let rest = rest.trim_start_matches(['&', '*', '(']);
                let literal = rest.strip_prefix('"').and_then(|r| r.split('"').next());
                literal.is_some_and(is_prose)
            })
        });
        let is_allowed =
            ALLOWED.iter().any(|(file, part, _)| *file == shown && line.contains(part));
        if is_read && !is_allowed {
            found.push(format!("{shown}:{}: {}", n + 1, line.trim()));
        }
    }
    found
}

#[test]
fn nothing_below_the_words_reads_a_sentence() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    for file in source_files(&src) {
        let shown = file.strip_prefix(&src).unwrap().display().to_string();
        let module = shown.split('/').next().unwrap().trim_end_matches(".rs");
        let is_test = shown.ends_with("tests.rs") || shown.contains("/tests/");
        if !SPEAKERS.contains(&module) && !is_test {
            found.extend(read_prose(&shown, &fs::read_to_string(&file).unwrap()));
        }
    }
    assert!(found.is_empty(), "typed facts decide, not their words:\n{}", found.join("\n"));
}

#[test]
fn every_exception_is_still_needed() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (file, part, why) in ALLOWED {
        let text = fs::read_to_string(src.join(file)).unwrap();
        assert!(text.contains(part) && !why.is_empty(), "{file} no longer says `{part}`");
    }
}

#[test]
fn the_guard_of_sentences_sees_what_it_forbids() {
    for line in [
        r#"if reason.contains("the robot comes nearer than") {"#,
        r#"let cause = reason.split("; what would help").next();"#,
        r#"lines.retain(|l| l.starts_with("Its timing"));"#,
        r#"let is_close = stage == "too near";"#,
        r#"let joint = text.find("joint `");"#,
    ] {
        assert_eq!(read_prose("planner/causes.rs", line).len(), 1, "{line}");
    }
    for line in [
        r#"if joint.contains("Shoulder") {"#,
        r#"let parts = text.split(", ");"#,
        r#"let said = format!("{} is {} in words", a == b, c); // a.contains("two words")"#,
        "let x = 1;\n#[cfg(test)]\nmod tests {\n    assert!(said.contains(\"two words\"));\n}",
    ] {
        assert!(read_prose("planner/causes.rs", line).is_empty(), "{line}");
    }
}

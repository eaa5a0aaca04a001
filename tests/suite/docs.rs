//! The guide says what is so: links lead somewhere, commands have the options that they are shown with,
//! and the tables of keys are those of the formats.

use crate::common::ergopath;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Headings of `docs/scenarios.md` and the parts of the schema that their tables hold.
const SCENARIO_TABLES: [(&str, &str); 13] = [
    ("The top of the file", ""),
    ("Poses", "PoseFile"),
    ("`[worker]`", "WorkerFile"),
    ("`[grip]`", "GripFile"),
    ("`[robot]`", "RobotFile"),
    ("`[[robot.limit]]`", "JointLimitFile"),
    ("`[motion]`", "MotionFile"),
    ("`[limits]`", "LimitsFile"),
    ("`[workspace]`", "WorkspaceFile"),
    ("`[[obstacle]]`", "ObstacleFile"),
    ("`[task]`", "TaskFile"),
    ("`[[path]]`", "PathFile"),
    ("`[free]`", "FreeFile"),
];

/// The same for `docs/planners.md`.
const PLANNER_TABLES: [(&str, &str); 2] = [("The file", ""), ("`[objective]`", "Objective")];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The README and all pages of the guide, in order of their names.
fn pages() -> Vec<PathBuf> {
    let all = root().join("docs").read_dir().unwrap().map(|e| e.unwrap().path());
    let mut pages: Vec<PathBuf> =
        all.filter(|p| p.extension().is_some_and(|x| x == "md")).collect();
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// The lines of a page outside of code, and those of its `sh` blocks.
fn split(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut prose, mut shell) = (Vec::new(), Vec::new());
    let mut block: Option<&str> = None;
    for line in text.lines() {
        let fence = line.trim_start().strip_prefix("```");
        match (block, fence) {
            (None, Some(kind)) => block = Some(kind.trim()),
            (Some(_), Some(_)) => block = None,
            (None, None) => prose.push(line),
            (Some("sh"), None) => shell.push(line),
            (Some(_), None) => {}
        }
    }
    (prose, shell)
}

/// Where the links and pictures of a line lead to.
fn targets(line: &str) -> Vec<&str> {
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect()
}

/// A heading as the anchor that hosts of Markdown make of it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(text: &str) -> BTreeSet<String> {
    let (prose, _) = split(text);
    let headings = prose.iter().filter(|l| l.starts_with('#'));
    headings.map(|l| anchor(l.trim_start_matches('#'))).collect()
}

#[test]
fn every_link_and_picture_leads_somewhere() {
    let mut seen = 0;
    for page in pages() {
        let text = read(&page);
        for target in split(&text).0.into_iter().flat_map(targets) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (file, place) = target.split_once('#').unwrap_or((target, ""));
            let at = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(at.exists(), "{}: `{target}` does not exist", page.display());
            if !place.is_empty() {
                let known = anchors(&read(&at));
                assert!(known.contains(place), "{}: `{target}` has no heading", page.display());
            }
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
}

/// The words of each call of `ergopath` in a line, without the program's name.
fn calls(line: &str) -> Vec<Vec<&str>> {
    let line = line.split('#').next().unwrap_or_default();
    let mut calls = Vec::new();
    let mut call: Option<Vec<&str>> = None;
    for word in line.split_whitespace() {
        if ["|", "||", "&&", ";", ">"].contains(&word) {
            calls.extend(call.take());
        } else if let Some(words) = call.as_mut() {
            words.push(word);
        } else if word == "ergopath" {
            call = Some(Vec::new());
        }
    }
    calls.extend(call);
    calls
}

/// What `--help` of a subcommand says; none where there is no such subcommand.
fn help(sub: &[&str]) -> Option<String> {
    let output = ergopath().args(sub).arg("--help").output().unwrap();
    output.status.success().then(|| String::from_utf8(output.stdout).unwrap())
}

/// The long options in a help text.
fn long_options(help: &str) -> BTreeSet<String> {
    let words = help.split(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    words.filter(|w| w.starts_with("--") && w.len() > 2).map(str::to_owned).collect()
}

#[test]
fn commands_have_the_options_that_they_are_shown_with() {
    let texts: Vec<(PathBuf, String)> =
        pages().into_iter().map(|p| (p.clone(), read(&p))).collect();
    let mut known: BTreeMap<Vec<&str>, BTreeSet<String>> = BTreeMap::new();
    let mut seen = 0;
    for (page, text) in &texts {
        for line in split(text).1 {
            for call in calls(line) {
                // `experiment` has subcommands of its own.
                let depth = 1 + usize::from(call.first() == Some(&"experiment"));
                let sub: Vec<&str> = call.iter().take(depth).copied().collect();
                let place = format!("{}: `{line}`", page.display());
                assert!(!sub.is_empty() && !sub[0].starts_with('-'), "{place}: no subcommand");
                let options = known.entry(sub.clone()).or_insert_with(|| {
                    let text = help(&sub).unwrap_or_else(|| panic!("{place}: {sub:?} is unknown"));
                    long_options(&text)
                });
                for word in call.iter().filter(|w| w.starts_with("--")) {
                    let option = word.split('=').next().unwrap_or_default();
                    assert!(options.contains(option), "{place}: {sub:?} has no {option}");
                }
                seen += 1;
            }
        }
    }
    assert!(seen > 40, "{seen}");
    assert!(help(&["plna"]).is_none());
}

/// The keys in the first columns of a page's tables, by heading.
fn documented(page: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = read(&root().join("docs").join(page));
    let mut keys: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut heading = String::new();
    for line in split(&text).0 {
        if let Some(title) = line.strip_prefix("## ") {
            title.trim().clone_into(&mut heading);
        }
        let key = line.strip_prefix("| `").and_then(|rest| rest.split('`').next());
        if let Some(key) = key {
            let is_new = keys.entry(heading.clone()).or_default().insert(key.to_owned());
            assert!(is_new, "{page}: `{key}` stands twice under {heading}");
        }
    }
    keys
}

/// The keys of a part of a schema, those of all its variants together.
fn schema_keys(part: &Value) -> BTreeSet<String> {
    let variants = part["oneOf"].as_array().into_iter().flatten();
    let objects = variants.chain([part]).filter_map(|o| o["properties"].as_object());
    objects.flat_map(|o| o.keys().cloned()).collect()
}

fn assert_tables(kind: &str, page: &str, tables: &[(&str, &str)]) {
    let output = ergopath().args(["schema", kind]).assert().success().get_output().stdout.clone();
    let schema: Value = serde_json::from_slice(&output).unwrap();
    let documented = documented(page);
    for (heading, part) in tables {
        let part = if part.is_empty() { &schema } else { &schema["definitions"][*part] };
        let (is, said) = (schema_keys(part), documented.get(*heading));
        assert!(!is.is_empty(), "{heading}: the schema has no such part");
        assert_eq!(said, Some(&is), "{page}, {heading}: keys of page and schema");
    }
    // No part of the format is left out.
    for (name, part) in schema["definitions"].as_object().unwrap() {
        let is_told = tables.iter().any(|(_, told)| told == name);
        assert!(is_told || schema_keys(part).is_empty(), "{page} says nothing of {name}");
    }
}

#[test]
fn the_tables_of_keys_are_those_of_the_formats() {
    assert_tables("scenario", "scenarios.md", &SCENARIO_TABLES);
    assert_tables("planner", "planners.md", &PLANNER_TABLES);
}

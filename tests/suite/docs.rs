//! The guide says what is so: links lead somewhere, commands have the options that they are shown with,
//! the tables of keys are those of the formats, and figures are those that the program showed
//! (`docs/figures.json`; `docs/figures.py` measures them again).

use crate::common::ergopath;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Headings of `docs/scenarios.md` and the parts of the schema that their tables hold.
const SCENARIO_TABLES: [(&str, &str); 15] = [
    ("The top of the file", ""),
    ("Poses", "TcpFile"),
    ("`[worker]`", "WorkerFile"),
    ("`[grip]`", "GripFile"),
    ("`[grip.right]` and `[grip.left]`", "HandGripFile"),
    ("`[robot]`", "RobotFile"),
    ("`base` of the robot", "BaseFile"),
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

/// The same for `docs/batches.md`.
const BATCH_TABLES: [(&str, &str); 1] = [("The batch file", "")];

/// The same for `docs/shift.md`.
const SHIFT_TABLES: [(&str, &str); 4] = [
    ("The top of the file", ""),
    ("`[shift]`", "ShiftTable"),
    ("`[[break]]`", "BreakTable"),
    ("`[[task]]`", "TaskTable"),
];

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
    assert_tables("batch", "batches.md", &BATCH_TABLES);
    assert_tables("shift", "shift.md", &SHIFT_TABLES);
}

/// What `docs/figures.py` measured: groups of steps, values and transcripts.
fn figures() -> Value {
    serde_json::from_str(&read(&root().join("docs/figures.json"))).unwrap()
}

/// Names and texts of the figures of a page: `<!--f:NAME-->TEXT<!--/f-->`.
fn marked(text: &str) -> Vec<(&str, &str)> {
    let of = |rest| {
        let (figure, _) = str::split_once(rest, "<!--/f-->")?;
        figure.split_once("-->")
    };
    let parts = text.split("<!--f:").skip(1);
    parts.map(|rest| of(rest).unwrap_or_else(|| panic!("{rest}: a figure without end"))).collect()
}

/// Names and lines of the transcripts of a page: the fence below `<!--out:NAME-->`.
fn transcripts(text: &str) -> Vec<(&str, Vec<&str>)> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let inner = line.trim().strip_prefix("<!--out:");
        let Some(name) = inner.and_then(|rest| rest.strip_suffix("-->")) else { continue };
        let indent = line.len() - line.trim_start().len();
        assert_eq!(lines.next().map(str::trim), Some("```text"), "{name}: no fence below it");
        let within = lines.by_ref().take_while(|l| l.trim() != "```");
        found.push((name, within.map(|l| l.get(indent..).unwrap_or_default()).collect()));
    }
    found
}

/// The strings of a list.
fn strings(list: &Value) -> Vec<&str> {
    list.as_array().into_iter().flatten().map(|s| s.as_str().unwrap()).collect()
}

/// The entry of a figure or transcript, `GROUP.NAME`.
fn entry<'a>(figures: &'a Value, kind: &str, name: &str) -> &'a Value {
    let (group, key) = name.split_once('.').unwrap_or_else(|| panic!("{name} has no group"));
    &figures[group][kind][key]
}

#[test]
fn figures_of_the_guide_are_those_that_were_measured() {
    let figures = figures();
    let mut used = BTreeSet::new();
    for page in pages() {
        let (text, at) = (read(&page), page.display());
        for (name, shown) in marked(&text) {
            let measured = &entry(&figures, "values", name)["text"];
            assert_eq!(measured.as_str(), Some(shown), "{at}: {name}");
            used.insert(name.to_owned());
        }
        for (name, shown) in transcripts(&text) {
            let measured = strings(&entry(&figures, "transcripts", name)["text"]);
            assert_eq!(measured, shown, "{at}: {name}");
            used.insert(name.to_owned());
        }
    }
    let known: BTreeSet<String> = figures
        .as_object()
        .unwrap()
        .iter()
        .flat_map(|(group, parts)| {
            let kinds = ["values", "transcripts"].into_iter();
            let kinds = kinds.filter_map(move |kind| parts[kind].as_object());
            kinds.flat_map(serde_json::Map::keys).map(move |key| format!("{group}.{key}"))
        })
        .collect();
    assert_eq!(used, known, "figures on the pages, and those that were measured");
    assert!(used.len() > 60, "{}", used.len());
}

/// Runs a step of a group in a folder: a call of the program, or a file with other words in it.
fn make(step: &Value, room: &Path) {
    let placed = |name: &str| name.replace("REPO/", &format!("{}/", root().display()));
    let call = strings(&step["run"]);
    if call.is_empty() {
        let mut text = read(&room.join(placed(step["from"].as_str().unwrap())));
        for pair in step["replace"].as_array().unwrap() {
            let [old, new] = strings(pair)[..] else { panic!("{pair} is no pair") };
            assert!(text.contains(old), "{step}: `{old}` is missing");
            text = text.replacen(old, new, 1);
        }
        std::fs::write(room.join(step["to"].as_str().unwrap()), text).unwrap();
        return;
    }
    let words = call.into_iter().map(placed);
    let done = ergopath().current_dir(room).args(words).assert().success();
    if let Some(file) = step["stdout"].as_str() {
        std::fs::write(room.join(file), &done.get_output().stdout).unwrap();
    }
}

/// What a pointer leads to; a part `key=value` picks the entry of a list.
fn found<'a>(value: &'a Value, at: &str) -> &'a Value {
    at.trim_start_matches('/').split('/').fold(value, |value, part| {
        let Some(entries) = value.as_array() else { return &value[part] };
        let entry = match part.split_once('=') {
            Some((key, wanted)) => entries.iter().find(|e| plain(&e[key]) == wanted),
            None => part.parse::<usize>().ok().and_then(|i| entries.get(i)),
        };
        entry.unwrap_or_else(|| panic!("{at}: there is no {part}"))
    })
}

/// A number, or a text without its quotation marks.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// A figure is what the program says now, to a unit of its last digit: another processor may round
/// differently, which can move a frame over a threshold.
fn assert_fresh(name: &str, rule: &Value, room: &Path) {
    let file = read(&room.join(rule["file"].as_str().unwrap()));
    let source: Value = serde_json::from_str(&file).unwrap();
    let (fresh, said) = (found(&source, rule["at"].as_str().unwrap()), plain(&rule["text"]));
    let Some(digits) = rule["digits"].as_i64() else {
        assert_eq!(plain(fresh), said, "{name}");
        return;
    };
    let fresh = fresh.as_f64().unwrap() * rule["times"].as_f64().unwrap_or(1.0);
    let unit = 10_f64.powi(-i32::try_from(digits).unwrap());
    let off = (fresh - said.parse::<f64>().unwrap()).abs();
    assert!(off < 1.01 * unit, "{name}: {said} became {fresh}; run docs/figures.py");
}

/// The lines of an output that a transcript keeps.
fn kept(rule: &Value, output: &str) -> Vec<String> {
    let mut lines = output.lines();
    let mut next = |prefix: &str| {
        let line = lines.find(|l| l.starts_with(prefix));
        line.unwrap_or_else(|| panic!("no further line begins with `{prefix}`")).to_owned()
    };
    let prefixes = strings(&rule["keep"]).into_iter();
    prefixes.map(|p| if p.is_empty() { String::new() } else { next(p) }).collect()
}

/// The words of a line, without figures and bars.
fn shape(line: &str) -> Vec<&str> {
    let is_figure = |w: &str| w.chars().any(|c| c.is_ascii_digit() || c == '█' || c == '·');
    line.split_whitespace().map(|w| if is_figure(w) { "#" } else { w }).collect()
}

#[test]
fn cheap_figures_are_still_those_of_the_program() {
    let room = tempfile::tempdir().unwrap();
    let figures = figures();
    let (mut values, mut texts) = (0, 0);
    for (group, parts) in figures.as_object().unwrap() {
        if parts["cheap"].as_bool() != Some(true) {
            continue;
        }
        for step in parts["steps"].as_array().unwrap() {
            make(step, room.path());
        }
        for (name, rule) in parts["values"].as_object().into_iter().flatten() {
            assert_fresh(&format!("{group}.{name}"), rule, room.path());
            values += 1;
        }
        for (name, rule) in parts["transcripts"].as_object().into_iter().flatten() {
            let output = read(&room.path().join(rule["file"].as_str().unwrap()));
            let fresh = kept(rule, &output.replace('\u{a0}', " "));
            let said = strings(&rule["text"]);
            assert_eq!(fresh.len(), said.len(), "{group}.{name}");
            for (now, then) in fresh.iter().zip(said) {
                assert_eq!(shape(now), shape(then), "{group}.{name}; run docs/figures.py");
            }
            texts += 1;
        }
    }
    assert!(values > 20 && texts > 4, "{values} values, {texts} transcripts");
}

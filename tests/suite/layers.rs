//! House law: imports between modules run downward only, and every file says what it is for.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules from the ground up; a module may import only modules on lower floors.
const FLOORS: &[&[&str]] = &[
    &["math", "skips"],
    &["qp", "trajectory", "files"],
    &["kinematics"],
    &["human", "robot", "ergonomics"],
    &["posture", "path", "recording", "survey"],
    &["scenario", "training"],
    &["planner", "scoring"],
    &["report", "ergobench"],
    &["cli"],
];
/// The hall and the door may name any module.
const OPEN: &[&str] = &["lib", "main"];

fn source_files(dir: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(source_files(&path));
        } else if path.extension().is_some_and(|x| x == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn floor(module: &str) -> Option<usize> {
    FLOORS.iter().position(|modules| modules.contains(&module))
}

/// The modules that one line of code reaches through `crate::`, `ergopath::` or `super::`.
fn reached(code: &str) -> Vec<String> {
    let word = |s: &str| -> String {
        s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut found: Vec<String> = Vec::new();
    for prefix in ["crate::", "ergopath::"] {
        for rest in code.split(prefix).skip(1) {
            if let Some(group) = rest.strip_prefix('{') {
                found.extend(group.split(',').map(|s| word(s.trim())).filter(|s| !s.is_empty()));
            } else {
                found.push(word(rest));
            }
        }
    }
    found.extend(code.split("super::").skip(1).map(word).filter(|s| floor(s).is_some()));
    found
}

/// What is wrong with one file's imports and heading, a line each.
fn faults(module: &str, shown: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    if !text.starts_with("//!") {
        faults.push(format!("{shown}: no //! line that says what it is for"));
    }
    if OPEN.contains(&module) {
        return faults;
    }
    let Some(own) = floor(module) else {
        faults.push(format!("{shown}: module `{module}` is on no floor"));
        return faults;
    };
    for (n, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        for target in reached(code) {
            if target != module && floor(&target).is_none_or(|f| f >= own) {
                faults.push(format!("{shown}:{}: {module} may not reach `{target}`", n + 1));
            }
        }
    }
    faults
}

#[test]
fn imports_run_downward_only() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    for file in source_files(&src) {
        let shown = file.strip_prefix(&src).unwrap().display().to_string();
        let module = shown.split('/').next().unwrap().trim_end_matches(".rs");
        found.extend(faults(module, &shown, &fs::read_to_string(&file).unwrap()));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn the_guard_sees_what_it_forbids() {
    for line in [
        "use crate::planner::Ranking;",
        "use crate::{planner, math};",
        "let x = super::cli::run();",
        "use crate::unheard_of::Thing;",
        "use crate::recording::Recording; // a neighbour",
    ] {
        assert_eq!(faults("posture", "posture.rs", &format!("//! x\n{line}\n")).len(), 1, "{line}");
    }
    let clean = "//! x\nuse crate::math::Pose; // not crate::planner\nuse crate::posture::Model;\n";
    assert!(faults("posture", "posture.rs", clean).is_empty());
}

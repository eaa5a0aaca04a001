//! House law: imports between modules run downward only, and every file says what it is for.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Modules from the ground up; a module may import only modules on lower floors. `skips` is what the
/// tests say when they skip.
const FLOORS: &[&[&str]] = &[
    &["math", "physical", "skips"],
    &["qp", "trajectory", "files"],
    &["kinematics", "mesh"],
    &["human", "robot", "ergonomics"],
    &["posture", "path", "recording", "survey"],
    &["scenario", "training"],
    &["planner", "scoring"],
    &["shift"],
    &["words"],
    &["batch"],
    &["report", "ergobench"],
    &["cli"],
];
/// The hall and the door may name any module.
const OPEN: &[&str] = &["lib", "main"];

pub(crate) fn source_files(dir: &Path) -> Vec<PathBuf> {
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

fn word(token: Option<&TokenTree>) -> Option<String> {
    let Some(TokenTree::Ident(word)) = token else { return None };
    Some(word.to_string())
}

fn is_sign(token: Option<&TokenTree>, sign: char) -> bool {
    matches!(token, Some(TokenTree::Punct(p)) if p.as_char() == sign)
}

/// Whether the tokens from `i` on begin with `::`.
fn is_joint(tokens: &[TokenTree], i: usize) -> bool {
    is_sign(tokens.get(i), ':') && is_sign(tokens.get(i + 1), ':')
}

/// All paths that a tree such as `a::{b, c::*}` names, each after `before`.
fn branches(tokens: &[TokenTree], before: &[String]) -> Vec<Vec<String>> {
    let mut path = before.to_vec();
    let mut i = 0;
    loop {
        match tokens.get(i) {
            Some(TokenTree::Ident(word)) => path.push(word.to_string()),
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                let parts = inner.split(|t| is_sign(Some(t), ','));
                return parts.filter(|p| !p.is_empty()).flat_map(|p| branches(p, &path)).collect();
            }
            Some(TokenTree::Punct(p)) if p.as_char() == '*' => path.push("*".to_owned()),
            _ => return vec![path],
        }
        if !is_joint(tokens, i + 1) {
            return vec![path];
        }
        i += 3;
    }
}

/// A path from the root of the crate, for one that begins with `crate`, `self` or `super` in the
/// module `at`; `None` for what climbs higher.
fn absolute(path: &[String], at: &[String]) -> Option<Vec<String>> {
    let mut from = at.to_vec();
    let mut rest = path;
    while let [first, after @ ..] = rest {
        match first.as_str() {
            "crate" | "ergopath" => from.clear(),
            "super" => drop(from.pop()?),
            "self" => {}
            _ => break,
        }
        rest = after;
    }
    from.extend_from_slice(rest);
    Some(from)
}

/// The top-level modules that code in the module `at` names, and what is wrong with how it does so.
struct Reach {
    at: Vec<String>,
    modules: BTreeSet<String>,
    /// Files of the own module, outside of tests.
    neighbours: BTreeSet<String>,
    faults: Vec<String>,
}

impl Reach {
    fn of(text: &str, at: &[String]) -> Self {
        let (modules, neighbours) = (BTreeSet::new(), BTreeSet::new());
        let mut reach = Self { at: at.to_vec(), modules, neighbours, faults: Vec::new() };
        let tokens: TokenStream = text.parse().unwrap_or_else(|e| panic!("{at:?}: {e}"));
        reach.walk(tokens);
        reach
    }

    fn walk(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for i in 0..tokens.len() {
            let is_inside_path = i > 1 && is_joint(&tokens, i - 2);
            match &tokens[i] {
                // What stands in braces behind `::` belongs to the path before it.
                TokenTree::Group(_) if is_inside_path => {}
                TokenTree::Group(group) => {
                    let name = i.checked_sub(2).and_then(|m| {
                        let is_module = word(tokens.get(m)).is_some_and(|w| w == "mod");
                        word(tokens.get(m + 1)).filter(|_| is_module)
                    });
                    self.at.extend(name.clone());
                    self.walk(group.stream());
                    self.at.truncate(self.at.len() - usize::from(name.is_some()));
                }
                TokenTree::Ident(root) => {
                    let root = root.to_string();
                    let is_start = ["crate", "super", "self"].contains(&root.as_str());
                    if root == "ergopath" || (is_start && !is_inside_path) {
                        self.start(&tokens[i..]);
                    }
                }
                _ => {}
            }
        }
    }

    /// At a word that may begin a path.
    fn start(&mut self, tokens: &[TokenTree]) {
        let is_renamed = word(tokens.get(1)).is_some_and(|w| w == "as");
        if !is_joint(tokens, 1) && !is_renamed {
            return;
        }
        for path in branches(tokens, &[]) {
            let shown = path.join("::");
            match absolute(&path, &self.at).as_deref() {
                Some([]) => self.faults.push(format!("`{shown}` is the whole crate")),
                Some([module, rest @ ..]) => {
                    let is_test = self.at.iter().any(|m| m == "tests");
                    if *module == self.at[0] && !is_test {
                        self.neighbours.extend(rest.first().cloned());
                    }
                    self.modules.insert(module.clone());
                }
                None => self.faults.push(format!("`{shown}` leaves the crate")),
            }
        }
    }
}

/// What is wrong with the imports and the heading of the file `shown`, a line each.
fn faults(shown: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    if !text.starts_with("//!") {
        faults.push(format!("{shown}: no //! line that says what it is for"));
    }
    let at: Vec<String> = shown.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    let module = at[0].as_str();
    if OPEN.contains(&module) {
        return faults;
    }
    let Some(own) = floor(module) else {
        faults.push(format!("{shown}: module `{module}` is on no floor"));
        return faults;
    };
    if text.contains("#[path") {
        faults.push(format!("{shown}: a module by `path` is not where its name says"));
    }
    let reach = Reach::of(text, &at);
    faults.extend(reach.faults.iter().map(|f| format!("{shown}: {f}")));
    for target in reach.modules {
        if target != module && floor(&target).is_none_or(|f| f >= own) {
            faults.push(format!("{shown}: {module} may not reach `{target}`"));
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
        found.extend(faults(&shown, &fs::read_to_string(&file).unwrap()));
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// A circle among names that each reach others, from a name back to itself; none where there is none.
fn circle(reach: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn back(
        reach: &BTreeMap<String, BTreeSet<String>>,
        way: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> bool {
        let here = way[way.len() - 1].clone();
        for next in reach.get(&here).into_iter().flatten().filter(|n| **n != here) {
            if let Some(at) = way.iter().position(|w| w == next) {
                way.drain(..at);
                way.push(next.clone());
                return true;
            }
            way.push(next.clone());
            if !done.contains(next) && back(reach, way, done) {
                return true;
            }
            way.pop();
        }
        done.insert(here);
        false
    }
    let mut done = BTreeSet::new();
    reach.keys().find_map(|start| {
        let mut way = vec![start.clone()];
        back(reach, &mut way, &mut done).then_some(way)
    })
}

#[test]
fn files_of_the_planner_import_in_no_circle() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/planner");
    let of = |file: &PathBuf| {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let at = ["planner".to_owned(), name.clone()];
        let reach = Reach::of(&fs::read_to_string(file).unwrap(), &at);
        (name, reach.neighbours)
    };
    let reach: BTreeMap<_, _> = source_files(&folder).iter().map(of).collect();
    assert!(reach["pipeline"].contains("reporting") && reach["search"].contains("environment"));
    assert_eq!(circle(&reach), None);
    // A circle is seen.
    let of = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<BTreeSet<_>>();
    let mut small = BTreeMap::from([("a".to_owned(), of(&["b"])), ("b".to_owned(), of(&["c"]))]);
    assert_eq!(circle(&small), None);
    small.insert("c".to_owned(), of(&["c", "b"]));
    assert_eq!(circle(&small).unwrap(), ["b", "c", "b"]);
}

#[test]
fn the_guard_sees_what_it_forbids() {
    for (file, code) in [
        ("posture.rs", "use crate::planner::Ranking;"),
        ("posture.rs", "use crate::{planner, math};"),
        (
            "posture.rs",
            "use crate::{\n    math::Pose,\n    planner::{\n        Ranking, rank,\n    },\n};",
        ),
        ("posture.rs", "use {std::fmt, crate::planner::Ranking};"),
        ("posture.rs", "let x = super::cli::run();"),
        ("posture.rs", "use crate::unheard_of::Thing;"),
        ("posture.rs", "use crate::recording::Recording; // a neighbour"),
        ("posture.rs", "use crate::*;"),
        ("posture.rs", "use crate as all;"),
        ("posture.rs", "use super as all;"),
        ("posture.rs", "use crate::{self as all};"),
        ("posture.rs", "mod tests {\n    use super::super::planner::plan;\n}"),
        ("posture.rs", "macro_rules! plan { () => { $crate::planner::plan() }; }"),
        ("posture.rs", "fn f() { assert_eq!(crate\n    ::cli::run(), 0); }"),
        ("posture.rs", "fn f(x: impl Into<crate::planner::Plan>) {}"),
        ("posture.rs", "#[path = \"elsewhere.rs\"]\nmod here;"),
        ("posture.rs", "use super::super::math::Pose;"),
        ("posture/law.rs", "use super::super::planner::plan;"),
        ("posture/law.rs", "use super::{Law, super::planner::plan};"),
        ("posture/law.rs", "use self::super::super::{math::Pose, planner::plan};"),
    ] {
        assert_eq!(faults(file, &format!("//! x\n{code}\n")).len(), 1, "{code}");
    }
    assert_eq!(faults("posture.rs", "use crate::math::Pose;\n").len(), 1, "no heading");
    assert_eq!(faults("novel.rs", "//! x\n").len(), 1, "a module on no floor");
}

#[test]
fn the_guard_lets_pass_what_is_allowed() {
    for (file, code) in [
        ("posture.rs", "use crate::math::Pose; // not crate::planner"),
        ("posture.rs", "/// Unlike [`crate::planner::plan`].\nuse crate::posture::Model;"),
        ("posture.rs", "const WORDS: &str = \"use crate::planner\";"),
        ("posture.rs", "mod tests {\n    use super::*;\n    use super::super::math::Pose;\n}"),
        ("posture.rs", "fn f<'a>(&'a self) -> &'a str { self.planner.name() }"),
        ("posture/law.rs", "use super::planner::Thing;\nuse super::super::{math, posture::Law};"),
        ("posture/law.rs", "pub(crate) fn f() { crate::{math::x, files::y} }"),
        ("posture/law.rs", "pub(super) use self::planner::Thing;"),
    ] {
        assert_eq!(faults(file, &format!("//! x\n{code}\n")), Vec::<String>::new(), "{code}");
    }
}

//! What the program is built from: licences that may be passed on, and nothing from outside the registry.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Licences that ask for no more than a notice.
const ALLOWED: [&str; 12] = [
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Packages for this platform: only these are sure to be on the machine.
fn metadata() -> Value {
    let told = Command::new("rustc").arg("-vV").output().unwrap().stdout;
    let told = String::from_utf8(told).unwrap();
    let host = told.lines().find_map(|l| l.strip_prefix("host: ")).unwrap();
    let words = ["metadata", "--offline", "--locked", "--format-version", "1", "--filter-platform"];
    let mut command = Command::new(env!("CARGO"));
    let command = command.args(words).arg(host).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// All packages that end up in the program: what it needs, and what that needs.
fn built_in(metadata: &Value) -> BTreeSet<&str> {
    let nodes: BTreeMap<&str, &Value> = metadata["resolve"]["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| (text(n, "id"), n))
        .collect();
    let mut open = vec![text(&metadata["resolve"], "root")];
    let mut found = BTreeSet::new();
    while let Some(id) = open.pop() {
        if !found.insert(id) {
            continue;
        }
        let is_normal = |d: &&Value| {
            d["dep_kinds"].as_array().unwrap().iter().any(|kind| kind["kind"].is_null())
        };
        let needs = nodes[id]["deps"].as_array().unwrap().iter().filter(is_normal);
        open.extend(needs.map(|d| text(d, "pkg")));
    }
    found
}

#[test]
fn all_that_is_built_in_may_be_passed_on() {
    let metadata = metadata();
    let built_in = built_in(&metadata);
    assert!(built_in.len() > 100);
    let own = text(&metadata["resolve"], "root");
    for package in metadata["packages"].as_array().unwrap() {
        let (id, name) = (text(package, "id"), text(package, "name"));
        if id == own || !built_in.contains(id) {
            continue;
        }
        let licence = text(package, "license");
        let parsed = spdx::Expression::parse_mode(licence, spdx::ParseMode::LAX);
        let parsed = parsed.unwrap_or_else(|e| panic!("{name}: `{licence}`: {e}"));
        let is_allowed = |wanted: &spdx::LicenseReq| {
            wanted.license.id().is_some_and(|id| ALLOWED.contains(&id.name))
        };
        assert!(parsed.evaluate(is_allowed), "{name} is under `{licence}`");
        assert!(
            text(package, "source").starts_with("registry+"),
            "{name} is not from the registry"
        );
    }
}

#[test]
fn the_lowest_version_of_rust_is_told_alike_everywhere() {
    let metadata = metadata();
    let own = text(&metadata["resolve"], "root");
    let package = metadata["packages"].as_array().unwrap().iter().find(|p| text(p, "id") == own);
    let lowest = text(package.unwrap(), "rust_version");
    for page in ["README.md", "docs/README.md", "docs/releases.md"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
        let page_text = std::fs::read_to_string(path).unwrap();
        assert!(page_text.contains(&format!("Rust {lowest}")), "{page} does not say Rust {lowest}");
    }
    // No package that is built in asks for a later one.
    let built_in = built_in(&metadata);
    let number = |v: &str| -> Vec<u32> { v.split('.').filter_map(|p| p.parse().ok()).collect() };
    for package in metadata["packages"].as_array().unwrap() {
        let needs = text(package, "rust_version");
        let is_in = built_in.contains(text(package, "id"));
        assert!(!is_in || number(needs) <= number(lowest) || needs == lowest, "{package:?}");
    }
}

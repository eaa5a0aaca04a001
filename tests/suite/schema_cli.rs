//! Schemas, completions and man pages.

use crate::common::ergopath;
use predicates::str::contains;
use serde_json::Value;
use std::path::Path;

pub(crate) fn schema(kind: &str) -> jsonschema::Validator {
    let output = ergopath().args(["schema", kind]).assert().success().get_output().stdout.clone();
    let schema: Value = serde_json::from_slice(&output).unwrap();
    jsonschema::validator_for(&schema).unwrap()
}

pub(crate) fn as_json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap();
    serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap()
}

/// The shipped files of a folder.
fn shipped(folder: &str) -> Vec<std::path::PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let all = folder.read_dir().unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<_> = all.filter(|p| p.extension().is_some_and(|x| x == "toml")).collect();
    files.sort();
    files
}

#[test]
fn shipped_files_are_valid_and_misspelt_ones_are_not() {
    for (kind, folder) in [("scenario", "scenarios"), ("planner", "planners")] {
        let validator = schema(kind);
        let files = shipped(folder);
        assert!(files.len() >= 3);
        for file in files {
            let value = as_json(&file);
            let errors: Vec<String> = validator
                .iter_errors(&value)
                .map(|e| format!("{e} at {}", e.instance_path()))
                .collect();
            assert!(errors.is_empty(), "{}: {errors:?}", file.display());
            // A key that nobody knows, at the top and in every table.
            let mut strange = value.clone();
            strange["colour"] = Value::from("red");
            assert!(!validator.is_valid(&strange));
            for (key, inner) in value.as_object().unwrap() {
                if inner.is_object() {
                    let mut strange = value.clone();
                    strange[key]["colour"] = Value::from("red");
                    assert!(!validator.is_valid(&strange), "{key}");
                }
            }
            let mut other = value.clone();
            other["schema"] = Value::from("ergopath/other/1");
            assert!(!validator.is_valid(&other));
            let mut missing = value.clone();
            missing.as_object_mut().unwrap().remove("name");
            assert!(!validator.is_valid(&missing));
        }
    }
}

#[test]
fn the_shipped_batch_is_valid_and_a_misspelt_one_is_not() {
    let validator = schema("batch");
    let files = shipped("scenarios/batch");
    let is_batch = |v: &Value| v["schema"] == "ergopath/batch/1";
    let batches: Vec<Value> = files.iter().map(|f| as_json(f)).filter(is_batch).collect();
    assert!(!batches.is_empty());
    for value in batches {
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{errors:?}");
        let broken = [
            ("colour", "red".into()),
            ("mode", "guess".into()),
            ("scenarios", Value::Array(vec![])),
        ];
        for (key, wrong) in broken {
            let mut strange = value.clone();
            strange[key] = wrong;
            assert!(!validator.is_valid(&strange), "{key}");
        }
    }
}

#[test]
fn a_schema_tells_units_and_choices() {
    let output = ergopath().args(["schema", "scenario"]).assert().get_output().stdout.clone();
    let schema: Value = serde_json::from_slice(&output).unwrap();
    // Everything that can be written has words.
    let mut open = vec![("top".to_owned(), &schema)];
    let definitions = schema["definitions"].as_object().unwrap();
    open.extend(definitions.iter().map(|(n, d)| (n.clone(), d)));
    let mut seen = 0;
    for (name, place) in open {
        let variants = place["oneOf"].as_array().cloned().unwrap_or_default();
        for object in variants.iter().chain([place]) {
            for (key, property) in object["properties"].as_object().into_iter().flatten() {
                assert!(property["description"].is_string() || key == "shape", "{name}.{key}");
                seen += 1;
            }
        }
    }
    assert!(seen > 70, "{seen}");
    let text = String::from_utf8(output).unwrap();
    for words in
        ["palm_down_bar", "ur20", "free_roll", "cornell2001", "ur10e", "unacceptable", "\"seated\""]
    {
        assert!(text.contains(words), "{words}");
    }
}

#[test]
fn schemas_completions_and_manuals_are_written() {
    let room = tempfile::tempdir().unwrap();
    ergopath().args(["schema", "-o"]).arg(room.path()).assert().success();
    for kind in ["scenario", "planner", "batch", "shift"] {
        let text =
            std::fs::read_to_string(room.path().join(format!("{kind}.schema.json"))).unwrap();
        serde_json::from_str::<Value>(&text).unwrap();
    }
    ergopath().args(["schema", "scenarios"]).assert().code(2).stderr(contains("scenario"));
    ergopath().arg("schema").assert().code(2);
    for (shell, words) in
        [("bash", "complete -F"), ("zsh", "#compdef ergopath"), ("fish", "complete -c")]
    {
        ergopath().args(["completions", shell]).assert().success().stdout(contains(words));
    }
    ergopath().args(["completions", "cmd"]).assert().code(2);
    ergopath().args(["man", "-o"]).arg(room.path()).assert().success();
    let page = |name: &str| std::fs::read_to_string(room.path().join(name)).unwrap();
    assert!(page("ergopath.1").contains(".TH ergopath 1"));
    assert!(
        page("ergopath-plan.1").contains("ergopath\\-plan")
            && page("ergopath-check.1").contains("sensitivity")
    );
}

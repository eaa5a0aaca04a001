//! Finished runs: the report made again, with what has changed since.

use crate::common::{assert_refused, ergopath, files, plan, unsealed, workplace};
use predicates::prelude::*;
use predicates::str::contains;

#[test]
fn a_report_made_again_has_the_same_bytes() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let before = files(&out);
    assert!(before.keys().any(|n| n.ends_with("joint_trajectory.yaml")));
    // All but the result and the list of what is ours.
    for name in before.keys().filter(|n| *n != "result.json" && !n.starts_with('.')) {
        std::fs::remove_file(out.join(name)).unwrap();
    }
    ergopath().arg("report").arg(&out).assert().success().stdout(contains("up to date"));
    let differ = |after: &std::collections::BTreeMap<String, Vec<u8>>| -> Vec<String> {
        assert!(before.keys().eq(after.keys()));
        before.keys().filter(|n| before[*n] != after[*n]).cloned().collect()
    };
    assert!(differ(&files(&out)).is_empty());
    // Into another folder, from the file itself, somewhere else.
    let copy = room.path().join("copy");
    let from = out.join("result.json");
    ergopath().arg("report").arg(&from).arg("-o").arg(&copy).assert().success();
    assert!(differ(&files(&copy)).is_empty());
}

#[test]
fn what_has_changed_since_is_told() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let report = || {
        let mut command = ergopath();
        command.arg("report").arg(&out);
        command
    };
    // The worker's model, which the scenario names.
    let model = room.path().join("operator.json");
    let kept = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, format!("{kept}\n")).unwrap();
    report().assert().success().stderr(contains("out of date"));
    std::fs::write(&model, kept).unwrap();
    report().assert().success().stderr(contains("out of date").not());
    // The scenario itself.
    let text = std::fs::read_to_string(&scenario).unwrap();
    std::fs::write(&scenario, text.replace("duration_s = 4.0", "duration_s = 4.5")).unwrap();
    report().assert().success().stderr(contains("`bench.toml` has changed since"));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Out of date"));
    // Elsewhere, the scenario is not found, and is found by its name.
    let moved = tempfile::tempdir().unwrap();
    let place = moved.path().join("a/b");
    std::fs::create_dir_all(&place).unwrap();
    std::fs::copy(out.join("result.json"), place.join("result.json")).unwrap();
    let elsewhere = || {
        let mut command = ergopath();
        command.current_dir(moved.path()).arg("report").arg(&place);
        command
    };
    elsewhere().assert().success().stdout(contains("bench.toml was not found"));
    let page = std::fs::read_to_string(place.join("report.html")).unwrap();
    assert!(!page.contains("Out of date"));
    elsewhere().arg("--scenario").arg(&scenario).assert().success().stderr(contains("out of date"));
}

#[test]
fn what_is_no_result_is_refused() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let file = out.join("result.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let refused = |text: &str, words: &str| {
        std::fs::write(&file, text).unwrap();
        let before = files(&out);
        assert_refused(ergopath().arg("report").arg(&out), words);
        assert_eq!(files(&out), before);
    };
    refused(&text[..text.len() / 2], "cut off");
    refused("{\"schema\": \"ergopath/result/9\"}", "ergopath/result/9");
    refused("{}", "has no schema");
    refused("{\"schema\": \"ergopath/result/1\"}", "make the run again");
    refused("{\"schema\": \"ergopath/result/2\"}", "not as this version of ergopath writes it");
    refused("[1, 2]", "is not a result");
    // A robot posture with a joint missing.
    let mut edited: serde_json::Value = serde_json::from_str(&text).unwrap();
    let ranked = edited["candidates"].as_array_mut().unwrap();
    let with_robot = ranked.iter_mut().find(|c| c["path"]["robot_q"][0].is_array()).unwrap();
    with_robot["path"]["robot_q"][0].as_array_mut().unwrap().pop();
    refused(&edited.to_string(), "was changed since it was written");
    refused(&unsealed(&edited), "a robot posture of 6 values for 7 joints");
    assert_refused(ergopath().arg("report").arg(room.path()), "is a folder without result.json");
    assert_refused(ergopath().arg("report").arg("nowhere"), "no such file");
}

/// The workbook holds what the tables beside it hold: numbers as numbers, texts as texts, no formulas.
#[test]
fn the_workbook_holds_the_tables() {
    use calamine::{Data, Reader, Xlsx, open_workbook};
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let name = text.lines().find(|l| l.starts_with("name = ")).unwrap();
    std::fs::write(&scenario, text.replace(name, "name = \"1+1\"")).unwrap();
    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let mut book: Xlsx<_> = open_workbook(out.join("report.xlsx")).unwrap();
    let names = book.sheet_names();
    assert_eq!(names[..3], ["About", "Paths", "Path 1"]);
    let about = book.worksheet_range("About").unwrap();
    assert_eq!(about.get_value((0, 0)), Some(&Data::String("1+1".to_owned())));
    let mut numbers = 0;
    for name in &names[1..] {
        assert!(book.worksheet_formula(name).unwrap().is_empty(), "{name}");
        let file = match name.strip_prefix("Path ") {
            Some(rank) => format!("paths/{rank}.csv"),
            None => "candidates.csv".to_owned(),
        };
        let sheet = book.worksheet_range(name).unwrap();
        let mut csv =
            csv::ReaderBuilder::new().has_headers(false).from_path(out.join(&file)).unwrap();
        let mut rows = 0;
        for (r, record) in csv.records().enumerate() {
            for (c, cell) in record.unwrap().iter().enumerate() {
                match sheet.get_value((r as u32, c as u32)).unwrap_or(&Data::Empty) {
                    Data::Empty => assert_eq!(cell, "", "{file} {r} {c}"),
                    Data::String(text) => {
                        assert_eq!(text, cell, "{file} {r} {c}");
                        assert!(r == 0 || cell.parse::<f64>().is_err(), "{file} {r} {c}: {cell}");
                    }
                    Data::Float(value) => {
                        assert_eq!(*value, cell.parse::<f64>().unwrap(), "{file} {r} {c}");
                        numbers += 1;
                    }
                    other => panic!("{file} {r} {c}: {other:?}"),
                }
            }
            rows += 1;
        }
        assert_eq!(sheet.height(), rows, "{file}");
    }
    assert!(numbers > 500, "{numbers}");
}

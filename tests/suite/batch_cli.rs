//! `ergopath batch BATCH.toml`: every value checked first, every cell computed once, the same tables whatever
//! happened on the way.

use crate::common::{assert_refused, cells_done, ergopath, files, workplace};
use crate::skips::skip;
use assert_cmd::Command;
use ergopath::batch::{Jobs, Manifest, read_batch};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use tempfile::TempDir;

const HEAD: &str =
    "schema = \"ergopath/batch/1\"\nname = \"Two by two\"\nscenarios = [\"bench.toml\"]\n";
const PLANNER: &str = "planners = [\"tiny.toml\"]\n";
const TWO_BY_TWO: &str = "[matrix]\nworker.bodies = [[\"female_p50\"], [\"male_p50\"]]\n\
                          [variant.layout.as_built]\n[variant.layout.nearer]\nworker.at_m = [0.1, 0.0]\n";

/// A workplace with a batch of four cells.
fn batch_place(rest: &str) -> (TempDir, PathBuf) {
    let (room, _) = workplace();
    let file = room.path().join("batch.toml");
    std::fs::write(&file, format!("{HEAD}{PLANNER}{rest}")).unwrap();
    (room, file)
}

fn batch(file: &Path, output: &str) -> Command {
    let mut command = ergopath();
    command.arg("batch").arg(file).arg("-o").arg(file.with_file_name(output));
    command
}

/// The tables and the page: the files at the top of a batch's folder.
fn top(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    files(folder).into_iter().filter(|(name, _)| !name.contains('/')).collect()
}

fn rows(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let mut table = csv::Reader::from_path(folder.join("cells.csv")).unwrap();
    table.deserialize().map(Result::unwrap).collect()
}

fn keys(file: &Path) -> Vec<String> {
    let batch = read_batch(file).unwrap();
    let plan = Manifest::of(&batch, &Jobs::of(&batch).unwrap()).unwrap();
    plan.cells.into_iter().map(|c| c.key).collect()
}

#[test]
fn every_cell_is_computed_once_and_described() {
    let (room, file) = batch_place(TWO_BY_TWO);
    batch(&file, "out").assert().success();
    let out = room.path().join("out");
    let table = rows(&out);
    let cells: Vec<[&str; 4]> = table
        .iter()
        .filter(|r| r["is_lead"] == "true")
        .map(|r| ["cell", "layout", "worker.bodies", "body"].map(|c| r[c].as_str()))
        .collect();
    assert_eq!(
        cells,
        [
            ["1", "as_built", "female_p50", "female_p50"],
            ["2", "nearer", "female_p50", "female_p50"],
            ["3", "as_built", "male_p50", "male_p50"],
            ["4", "nearer", "male_p50", "male_p50"]
        ]
    );
    // Within a cell by rank; several paths each.
    for cell in ["1", "2", "3", "4"] {
        let ranks: Vec<u32> = table
            .iter()
            .filter(|r| r["cell"] == cell)
            .filter_map(|r| r["rank"].parse().ok())
            .collect();
        assert!(ranks.len() > 2 && ranks.is_sorted(), "{ranks:?}");
    }
    for row in &table {
        let of = |c: &str| row[c].parse::<f64>().unwrap();
        let levels: f64 = (1..=4).map(|n| of(&format!("time_share_rula_level_{n}"))).sum();
        assert!((levels - 1.0).abs() < 1e-9 && (1.0..=7.0).contains(&of("rula_expected")));
        let high = of("time_share_rula_level_3") + of("time_share_rula_level_4");
        assert!((high - of("time_share_rula_ge_5")).abs() < 1e-9);
        assert!(of("rula_p05") <= of("rula_p95") && row["key"].len() == 64);
    }
    // Every column is described, in the order of the table.
    let mut described = csv::Reader::from_path(out.join("columns.csv")).unwrap();
    let described: Vec<csv::StringRecord> = described.records().map(Result::unwrap).collect();
    let names: Vec<&str> = described.iter().map(|r| &r[0]).collect();
    let header = std::fs::read_to_string(out.join("cells.csv")).unwrap();
    assert_eq!(names.join(","), header.lines().next().unwrap());
    assert!(described.iter().all(|r| r[3].len() > 5));

    // Again, with other threads: nothing is computed, and nothing changes.
    let before = files(&out);
    let record = |name: &String| name.ends_with("cell.json");
    let times = |out: &Path| -> Vec<std::time::SystemTime> {
        let names = before.keys().filter(|n| record(n));
        names.map(|n| out.join(n).metadata().unwrap().modified().unwrap()).collect()
    };
    let first = times(&out);
    assert_eq!(first.len(), 4);
    batch(&file, "out").args(["--threads", "1"]).assert().success();
    assert!(files(&out) == before && times(&out) == first);
    batch(&file, "one").args(["--threads", "1"]).assert().success();
    assert!(files(&room.path().join("one")) == before, "another number of threads");

    // One page by itself: of the cell that scores lowest; then of all, or of none.
    let pages = |out: &Path| files(out).keys().filter(|n| n.ends_with("report.html")).count();
    assert_eq!(pages(&out), 1);
    batch(&file, "out").args(["--pages", "all"]).assert().success();
    assert_eq!(pages(&out), 4);
    assert!(top(&out)["cells.csv"] == before["cells.csv"]);
    batch(&file, "none").args(["--pages", "none"]).assert().success();
    assert_eq!(pages(&room.path().join("none")), 0);
    let page = String::from_utf8(top(&out)["batch.html"].clone()).unwrap();
    for words in ["Two by two", "/report.html\">4</a>", "Main effects", "paired", "demonstration"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains(&room.path().display().to_string()));
}

#[test]
fn a_cell_is_known_by_all_that_it_reads() {
    let path =
        "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0.42,-0.35,0.95,0,1,0,0\n4,0.45,0.25,1.25,0,1,0,0\n";
    let rest = format!("seeds = [1]\npaths = [\"own.csv\"]\n{TWO_BY_TWO}");
    let (room, file) = batch_place(&rest);
    let place = |name: &str| room.path().join(name);
    let change = |name: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(place(name)).unwrap();
        assert!(text.contains(from), "{name}: {from}");
        std::fs::write(place(name), text.replacen(from, to, 1)).unwrap();
    };
    std::fs::write(place("own.csv"), path).unwrap();
    // A body and a robot of the user's own, by file.
    ergopath()
        .args(["body", "--sex", "f", "--stature-m", "1.58", "--mass-kg", "61", "-o"])
        .arg(place("anna.urdf"))
        .assert()
        .success();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/robot/panda.urdf");
    std::fs::copy(shipped, place("robot.urdf")).unwrap();
    change("batch.toml", "[\"male_p50\"]", "[\"anna.urdf\"]");
    change(
        "bench.toml",
        "preset = \"panda\"",
        "urdf = \"robot.urdf\"\nbase_link = \"panda_link0\"\ntcp = \"panda_hand_tcp\"",
    );
    let first = keys(&file);
    assert_eq!(first.iter().collect::<std::collections::BTreeSet<_>>().len(), 4, "{first:?}");
    assert_eq!(keys(&file), first, "the same inputs");
    change("bench.toml", "# A worker", "# Somebody");
    assert_eq!(keys(&file), first, "words for people are no input");
    change("batch.toml", "Two by two", "Four");
    assert_eq!(keys(&file), first, "nor is the name of the batch");

    for (name, from, to) in [
        ("bench.toml", "duration_s = 4.0", "duration_s = 4.1"),
        ("tiny.toml", "generations = 2", "generations = 3"),
        ("operator.json", "{\"schema\":", "{ \"schema\":"),
        ("own.csv", "4,0.45", "4.5,0.45"),
        ("robot.urdf", "</robot>", "<!-- changed -->\n</robot>"),
        ("batch.toml", "seeds = [1]", "seeds = [2]"),
        ("batch.toml", "planners", "mode = \"assess\"\nplanners"),
    ] {
        let before = keys(&file);
        change(name, from, to);
        let after = keys(&file);
        assert!(before.iter().zip(&after).all(|(a, b)| a != b), "{name}: {from} -> {to}");
    }
    // What only some cells read changes these alone.
    let before = keys(&file);
    change("batch.toml", "[0.1, 0.0]", "[0.12, 0.0]");
    let after = keys(&file);
    let changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
    assert_eq!(changed, [false, true, false, true]);
    let before = keys(&file);
    ergopath()
        .args(["--overwrite", "body", "--sex", "f", "--stature-m", "1.59", "--mass-kg", "61", "-o"])
        .arg(place("anna.urdf"))
        .assert()
        .success();
    let after = keys(&file);
    let changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
    assert_eq!(changed, [false, false, true, true]);
}

#[test]
fn killed_batches_and_shards_end_in_the_same_tables() {
    let (room, file) = batch_place(TWO_BY_TWO);
    batch(&file, "plain").assert().success();
    let plain = top(&room.path().join("plain"));
    assert!(plain.contains_key("cells.parquet") && plain.contains_key("batch.html"));

    // Killed at once, and each time when one more cell is there.
    let killed = room.path().join("killed");
    for cells in [0, 1, 2] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_ergopath"))
            .args(["batch", "--threads", "1", "-o"])
            .args([&killed, &file])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        while cells_done(&killed) < cells && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(!killed.join("cells.csv").exists(), "it was not killed in time");
    batch(&file, "killed").assert().success();
    assert!(top(&killed) == plain, "after kills");

    // Shards in any order, the second twice.
    let shared = room.path().join("shared");
    batch(&file, "shared").args(["--shard", "2/2"]).assert().success();
    let merge = || {
        let mut command = ergopath();
        command.args(["batch", "--merge"]).arg(&shared);
        command
    };
    assert_refused(&mut merge(), "2 of 4 cells have no result yet: 1, 3");
    batch(&file, "shared").args(["--shard", "1/2"]).assert().success();
    batch(&file, "shared").args(["--shard", "2/2"]).assert().success();
    merge().assert().success();
    // Shards do not know which cell is best, and so make no page of it.
    let tables = |all: &BTreeMap<String, Vec<u8>>| {
        let mut all = all.clone();
        all.retain(|name, _| {
            ["cells.csv", "cells.parquet", "columns.csv", "batch.json"].contains(&name.as_str())
        });
        all
    };
    assert_eq!(tables(&plain).len(), 4);
    assert!(tables(&top(&shared)) == tables(&plain), "after shards");
    for wrong in ["0/2", "3/2", "1", "a/b"] {
        batch(&file, "shared").args(["--shard", wrong]).assert().code(2);
    }
    assert_refused(
        ergopath().args(["batch", "--merge"]).arg(room.path()),
        "is no folder of a batch",
    );
}

#[cfg(unix)]
#[test]
fn the_line_for_gnu_parallel_gives_the_same_table() {
    let there = std::process::Command::new("parallel").arg("--version").output();
    if !there.is_ok_and(|o| String::from_utf8_lossy(&o.stdout).starts_with("GNU parallel")) {
        skip("GNU parallel (apt-get install parallel)");
        return;
    }
    let (room, file) = batch_place("seeds = [1, 2, 3]\n");
    batch(&file, "plain").args(["--pages", "none"]).assert().success();
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/batches.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let line = guide.lines().find(|l| l.starts_with("parallel ")).unwrap();
    let line = line
        .replace("scenarios/batch/layouts.toml", "batch.toml")
        .replace("ergopath", env!("CARGO_BIN_EXE_ergopath"));
    assert!(line.contains("--shard {}/8 ::: $(seq 8)"), "{line}");
    let run = |line: &str| {
        let mut shell = std::process::Command::new("bash");
        shell.args(["-c", line]).current_dir(room.path()).env("HOME", room.path());
        let run = shell.output().unwrap();
        assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    };
    run(&line);
    ergopath().args(["batch", "--merge"]).arg(room.path().join("shared")).assert().success();
    assert!(top(&room.path().join("shared")) == top(&room.path().join("plain")));
}

#[cfg(unix)]
#[test]
fn the_shipped_snakefile_gives_the_same_table() {
    use std::process::Command;
    if !Command::new("snakemake").arg("--version").output().is_ok_and(|o| o.status.success()) {
        skip("Snakemake (pip install snakemake)");
        return;
    }
    let (room, file) = batch_place("seeds = [1, 2, 3]\n");
    batch(&file, "plain").args(["--pages", "none"]).assert().success();
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = Path::new(env!("CARGO_BIN_EXE_ergopath")).parent().unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    let mut snakemake = Command::new("snakemake");
    snakemake.arg("-s").arg(project.join("scenarios/batch/Snakefile")).args(["--cores", "2"]);
    snakemake.args(["--config", "batch=batch.toml", "out=cells", "shards=2"]);
    snakemake.current_dir(room.path()).env("XDG_CACHE_HOME", room.path().join("cache"));
    let run = snakemake.env("PATH", format!("{}:{path}", program.display())).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert!(top(&room.path().join("cells")) == top(&room.path().join("plain")));
}

#[cfg(unix)]
#[test]
fn an_interrupted_batch_keeps_its_cells_and_goes_on() {
    use crate::outputs_cli::has;
    use std::time::{Duration, SystemTime};
    let (room, file) = batch_place(TWO_BY_TWO);
    batch(&file, "plain").assert().success();
    let plain = top(&room.path().join("plain"));
    let out = room.path().join("out");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_ergopath"))
        .args(["batch", "--threads", "1", "-o"])
        .args([&out, &file])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let records = || cells_done(&out);
    while records() == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    // Started in the background of a script, a program is told to ignore Ctrl-C.
    let signal = if has("self", "SigIgn:", 2) { "-TERM" } else { "-INT" };
    let sent = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
    let run = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(130), "{said}");
    assert!(said.contains("interrupted; cells that were finished are kept"), "{said}");
    assert!((1..4).contains(&records()) && !out.join("cells.csv").exists(), "{}", records());

    // What a killed run left goes once it is old; what is not known to be ours stays.
    let long_ago = SystemTime::now() - Duration::from_hours(2);
    for name in [".ergopath-aB3dE9", ".ergopath-notes"] {
        let folder = out.join("cells").join(name);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("cell.json"), "{}").unwrap();
        for at in [folder.join("cell.json"), folder] {
            std::fs::File::open(at).unwrap().set_modified(long_ago).unwrap();
        }
    }
    batch(&file, "out").assert().success();
    assert!(top(&out) == plain, "after an interruption");
    assert!(!out.join("cells/.ergopath-aB3dE9").exists());
    assert!(out.join("cells/.ergopath-notes/cell.json").exists());
}

#[test]
fn a_plan_whose_keys_are_no_hashes_is_refused() {
    let (room, file) = batch_place("");
    batch(&file, "out").args(["--pages", "none"]).assert().success();
    let plan = room.path().join("out/batch.json");
    let text = std::fs::read_to_string(&plan).unwrap();
    let key = keys(&file).remove(0);
    assert_eq!(key.len(), 64);
    let merge = || {
        let mut command = ergopath();
        command.args(["batch", "--merge"]).arg(room.path().join("out"));
        command
    };
    merge().assert().success();
    let leads_out = format!("../../{}", &key[6..]);
    for wrong in ["", &key[..63], &format!("{key}0"), &leads_out, &key.replace(&key[..1], "g")] {
        std::fs::write(&plan, text.replace(&key, wrong)).unwrap();
        assert_refused(&mut merge(), "is not a plan of `ergopath/batch-run/1`");
    }
    std::fs::write(&plan, &text).unwrap();
    merge().assert().success();
}

#[test]
fn a_failed_cell_is_recorded_and_kept() {
    let rest = "[matrix]\nworker.bodies = [[\"female_p50\"], [\"strange.urdf\"]]\n";
    let (room, file) = batch_place(rest);
    // A body whose joints have other names than those of the posture model.
    let human = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/human");
    for ending in ["urdf", "body.toml"] {
        let text = std::fs::read_to_string(human.join(format!("female_p50.{ending}"))).unwrap();
        assert!(text.contains("\"jL5S1_Z\""));
        let text =
            text.replace("\"jL5S1_Z\"", "\"jOther_Z\"").replace("\"female_p50\"", "\"strange\"");
        std::fs::write(room.path().join(format!("strange.{ending}")), text).unwrap();
    }
    let run = batch(&file, "out").assert().code(4);
    let shown = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(shown.contains("2 cells: 1 with a path, 1 failed"), "{shown}");
    let out = room.path().join("out");
    let table = rows(&out);
    let failed: Vec<_> = table.iter().filter(|r| r["state"] == "failed").collect();
    assert_eq!(failed.len(), 1);
    assert!(failed[0]["reason"].contains("other joints") && failed[0]["rula_expected"].is_empty());
    assert!(table.iter().any(|r| r["state"] == "ok"));
    let page = std::fs::read_to_string(out.join("batch.html")).unwrap();
    assert!(page.contains("other joints") && page.contains("no path"));
    // Kept, and tried again only on demand.
    let record = files(&out)
        .into_iter()
        .find(|(n, b)| n.ends_with("cell.json") && String::from_utf8_lossy(b).contains("failed"));
    let record = out.join(record.unwrap().0);
    let time = || record.metadata().unwrap().modified().unwrap();
    let before = time();
    batch(&file, "out").assert().code(4);
    assert_eq!(time(), before);
    batch(&file, "out").arg("--retry-failed").assert().code(4);
    assert_ne!(time(), before);
    // What failed keeps no bound.
    batch(&file, "out").args(["--gate", "rula_peak <= 7"]).assert().code(5);
}

#[test]
fn a_gate_decides_and_is_a_file_of_tests() {
    let (room, file) = batch_place(TWO_BY_TWO);
    let gate = |bounds: &str| {
        let mut command = batch(&file, "out");
        command.args(["--gate", bounds]);
        command
    };
    gate("rula_expected <= 7 and reach_exceeded_share < 2").assert().success();
    let xml = || std::fs::read_to_string(room.path().join("out/gate.xml")).unwrap();
    let kept = xml();
    assert!(kept.contains("tests=\"4\"") && kept.contains("failures=\"0\""), "{kept}");
    assert!(!kept.contains("timestamp") && !kept.contains(" time="), "{kept}");
    let out = gate("rula_expected < 1 and niosh_lifting_index < 1").assert().code(5);
    let shown = String::from_utf8(out.get_output().stdout.clone()).unwrap();
    assert!(
        shown.contains("kept by 0 of 4")
            && shown.contains("is not kept")
            && shown.contains("is not checked"),
        "{shown}"
    );
    assert!(xml().contains("failures=\"4\""));
    // Joined shards are asked the same.
    let mut merge = ergopath();
    merge
        .args(["batch", "--merge"])
        .arg(room.path().join("out"))
        .args(["--gate", "rula_expected < 1"]);
    merge.assert().code(5);
    assert_refused(&mut gate("p_rula_ge5 < 0.1"), "did you mean `p_rula_ge_5`?");
}

#[test]
fn the_parquet_holds_what_the_csv_holds() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    let (room, file) = batch_place("seeds = [1, 2]\n");
    batch(&file, "out").args(["--pages", "none"]).assert().success();
    let out = room.path().join("out");
    let place = out.join("cells.parquet");
    let reader = SerializedFileReader::new(std::fs::File::open(&place).unwrap()).unwrap();
    let table = rows(&out);
    let mut count = 0;
    for (row, said) in reader.get_row_iter(None).unwrap().map(Result::unwrap).zip(&table) {
        for (name, field) in row.get_column_iter() {
            let shown = match field {
                Field::Null => String::new(),
                Field::Str(text) => text.clone(),
                Field::Double(v) => v.to_string(),
                Field::Long(v) => v.to_string(),
                Field::Bool(v) => v.to_string(),
                other => panic!("{name}: {other}"),
            };
            assert_eq!(shown, said[name], "{name}");
        }
        assert_eq!(row.get_column_iter().count(), said.len());
        count += 1;
    }
    assert_eq!(count, table.len());
    let about = reader.metadata().file_metadata().key_value_metadata().unwrap();
    assert_eq!(about.len(), table[0].len());

    let python = "import sys, pandas\nt = pandas.read_parquet(sys.argv[1])\nc = pandas.read_csv(sys.argv[2])\n\
                  assert list(t.columns) == list(c.columns) and len(t) == len(c)\n\
                  assert abs(t['rula_expected'] - c['rula_expected']).max() == 0\n";
    let polars = "import sys, polars\nt = polars.read_parquet(sys.argv[1])\n\
                  c = polars.read_csv(sys.argv[2], infer_schema_length=None)\n\
                  assert t.columns == c.columns and len(t) == len(c) > 0\n\
                  assert (t['rula_expected'] - c['rula_expected']).abs().max() == 0\n\
                  assert t['is_lead'].dtype == polars.Boolean and t['key'].str.len_chars().min() == 64\n";
    for (packages, script) in [("pandas, pyarrow", python), ("polars", polars)] {
        let has = std::process::Command::new("python3")
            .args(["-c", &format!("import {packages}")])
            .stderr(Stdio::null())
            .status();
        if !has.is_ok_and(|s| s.success()) {
            skip(&format!("python3 with {packages}"));
            continue;
        }
        let opened = std::process::Command::new("python3")
            .args(["-c", script])
            .arg(&place)
            .arg(out.join("cells.csv"))
            .status();
        assert!(opened.unwrap().success(), "{packages}");
    }
}

#[test]
fn own_paths_are_assessed_and_unlike_stations_not_ranked_together() {
    let (room, file) = batch_place("");
    let heavy = std::fs::read_to_string(room.path().join("bench.toml")).unwrap();
    let heavy = heavy
        .replace("part_mass_kg = 1.5", "part_mass_kg = 9.0")
        .replace("Bench pick and place", "Heavy bench");
    std::fs::write(room.path().join("heavy.toml"), heavy).unwrap();
    let path = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0.42,-0.35,0.95,0,1,0,0\n2,0.43,-0.05,1.1,0,1,0,0\n4,0.45,0.25,1.25,0,1,0,0\n";
    std::fs::write(room.path().join("own.csv"), path).unwrap();
    let text = "schema = \"ergopath/batch/1\"\nname = \"Own\"\nmode = \"assess\"\npaths = [\"own.csv\"]\n\
                scenarios = [\"bench.toml\", \"heavy.toml\"]\nplanners = [\"tiny.toml\"]\n\
                [matrix]\nworker.at_m = [[0.0, 0.0], [0.1, 0.0]]\n\
                [[exclude]]\nscenario = \"heavy\"\nworker.at_m = [0.1, 0.0]\n\
                [[include]]\nscenario = \"heavy\"\nworker.at_m = [0.05, 0.0]\n";
    std::fs::write(&file, text).unwrap();
    batch(&file, "out").assert().success();
    let table = rows(&room.path().join("out"));
    let cells: Vec<(&str, &str)> = table
        .iter()
        .filter(|r| r["path"] == "own")
        .map(|r| (r["scenario"].as_str(), r["worker.at_m"].as_str()))
        .collect();
    assert_eq!(
        cells,
        [
            ("bench", "0.0, 0.0"),
            ("bench", "0.1, 0.0"),
            ("heavy", "0.0, 0.0"),
            ("heavy", "0.05, 0.0")
        ]
    );
    let page = std::fs::read_to_string(room.path().join("out/batch.html")).unwrap();
    assert!(
        page.contains("Other stations are other work") && page.contains("Heavy bench"),
        "{page}"
    );
    // Without a path there is nothing to assess.
    std::fs::write(&file, text.replace("paths = [\"own.csv\"]\n", "")).unwrap();
    assert_refused(&mut batch(&file, "none"), "names no path to assess");
    assert!(!room.path().join("none").exists());
}

#[test]
fn every_value_is_checked_before_anything_runs() {
    let (room, file) = batch_place("");
    let refused = |rest: &str, words: &str, marked: &str| {
        std::fs::write(&file, format!("{HEAD}{rest}")).unwrap();
        assert_refused(&mut batch(&file, "out"), words);
        let shown = batch(&file, "out").output().unwrap().stderr;
        let shown = String::from_utf8(shown).unwrap();
        assert!(shown.contains(marked) && shown.contains("batch.toml:"), "`{marked}` in {shown}");
        assert!(!room.path().join("out").exists());
    };
    refused("plannners = []\n", "did you mean `planners`?", "plannners");
    refused("planners = [\"quik\"]\n", "did you mean `quick`?", "quik");
    refused("planners = [\"none.toml\"]\n", "no such file", "none.toml");
    refused("seeds = [1, 1]\n", "`1` is there twice", "seeds");
    refused("[matrix]\nrobot.preset = [\"panda\", \"ur5f\"]\n", "did you mean `ur5e`?", "ur5f");
    refused("[matrix]\nrobot.presets = [\"panda\"]\n", "unknown field `presets`", "robot.presets");
    refused(
        "[matrix]\ntask.part_mass_kg = 3\n",
        "`task.part_mass_kg` needs a list of values",
        "part_mass_kg = 3",
    );
    refused("[matrix]\ntask.part_mass_kg = [1.5, 1500]\n", "1500", "1500]");
    refused("[matrix]\nworker.at_m = [[0.0, 0.0], [0.1]]\n", "exactly 2 are expected", "[0.1]");
    refused("[matrix]\nworker.bodies = [[\"female_p50\"], [\"nobody\"]]\n", "nobody", "nobody");
    refused("[matrix]\nseed = [1, 2]\n", "write seeds = [1, 2]", "seed = [1");
    refused(
        "[matrix]\nobstacle.shelf.size_m = [[1, 1, 1]]\n",
        "no `obstacle` is named `shelf`",
        "shelf",
    );
    refused("[variant.rank.a]\n", "cannot be the name of a factor", "rank");
    refused(
        "[variant.layout.a]\nremove = [\"robot.base_link\"]\n",
        "there is no `robot.base_link` to remove",
        "layout",
    );
    refused(
        "[matrix]\nworker.at_m = [[0.0, 0.0]]\n[variant.layout.a]\nworker.at_m = [0.1, 0.0]\n",
        "is set by `worker.at_m` as well",
        "layout",
    );
    let layout = "[variant.layout.a]\n[variant.layout.b]\nworker.at_m = [0.1, 0.0]\n";
    refused(&format!("{layout}[[exclude]]\nlayuot = \"a\"\n"), "did you mean `layout`?", "layuot");
    refused(&format!("{layout}[[exclude]]\nlayout = \"c\"\n"), "`layout` has no level", "\"c\"");
    refused(
        &format!("{layout}[[exclude]]\nlayout = [\"a\", \"b\"]\n"),
        "no cell is left",
        "exclude",
    );
    refused(
        &format!("{layout}[[include]]\nlayout = \"b\"\n"),
        "is in the batch already",
        "include",
    );
    let many: Vec<String> = (0..400).map(|k| k.to_string()).collect();
    let many = many.join(", ");
    std::fs::write(&file, format!("{HEAD}seeds = [{many}]\n[matrix]\ntask.hold_s = [{many}]\n"))
        .unwrap();
    assert_refused(&mut batch(&file, "out"), "more than 100000 cells");
    std::fs::write(&file, HEAD.replace("bench.toml", "nowhere.toml")).unwrap();
    assert_refused(&mut batch(&file, "out"), "no such file");

    // Options of lists are not those of batch files.
    std::fs::write(&file, format!("{HEAD}{PLANNER}")).unwrap();
    assert_refused(batch(&file, "out").args(["--seed", "1"]), "write seeds");
    assert_refused(batch(&file, "out").args(["--planner", "quick"]), "write planners");
    assert_refused(
        batch(&file, "out").arg(room.path().join("bench.toml")),
        "a call runs one of these alone",
    );
    let mut list = batch(&room.path().join("bench.toml"), "out");
    assert_refused(list.args(["--shard", "1/2"]), "needs a batch file");
    ergopath()
        .arg("check")
        .arg(&file)
        .assert()
        .success()
        .stdout(predicates::str::contains("a batch of 1 cells"));
}

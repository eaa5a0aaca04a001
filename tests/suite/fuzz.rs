//! A bounded run of the readers of `fuzz/` on the stable toolchain: valid files, changed the same way each time.
//!
//! The files go through a process of their own, so that a reader that hangs, needs too much memory or overflows the
//! stack is told by target, seed and change like one that panics. Longer runs, and others:
//!
//! ```text
//! ERGOPATH_FUZZ_TIMES=20 ERGOPATH_FUZZ_SEED=7 ERGOPATH_FUZZ_ONLY=mvnx,robot \
//!   cargo test --release --features peers --test suite -- fuzz --nocapture
//! ```

pub(crate) mod made;
mod mutate;
mod seeds;
mod targets;

use ergopath::files::{peak_memory_mib, restart_peak_memory};
use ergopath::math::stream::{Purpose, stream};
use ergopath::planner::parse_result;
use mutate::{Mutant, some, whole};
use std::collections::BTreeSet;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use targets::{TARGETS, Target};

const TEST: &str = "fuzz::no_reader_falls_over_a_changed_file";
/// Where the process of its own tells which file is being read.
const TOLD: &str = "ERGOPATH_FUZZ_TOLD";
/// Longest time that one file may take, s; in a build that is not optimised, on a machine that does more.
const HANGS_S: u64 = 120;
/// Most memory that a reader may need for files of some 100 kB, MiB.
const MOST_MIB: f64 = 1500.0;

/// What was done to a seed that is not changed.
const VALID: &str = "as it is";

fn setting(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|v| !v.is_empty())
}

/// Files with small changes of each target; those that are planned or drawn take long.
fn count(target: &str) -> usize {
    let once = match target {
        "scenario_plan" | "unfinished" => 6,
        "result" => 10,
        "scenario" | "shift" | "model" | "robot" => 60,
        _ => 150,
    };
    times(once)
}

/// So many, or as many more as are asked for.
fn times(once: u32) -> usize {
    let times: f64 = setting("ERGOPATH_FUZZ_TIMES").map_or(1.0, |t| t.parse().unwrap());
    (f64::from(once) * times) as usize
}

fn first_seed() -> u64 {
    setting("ERGOPATH_FUZZ_SEED").map_or(1, |s| s.parse().unwrap())
}

#[test]
fn no_reader_falls_over_a_changed_file() {
    if let Some(told) = setting(TOLD) {
        return campaign(Path::new(&told));
    }
    let room = tempfile::tempdir().unwrap();
    let [told, out, err] = ["told", "out", "err"].map(|name| room.path().join(name));
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args([TEST, "--exact", "--nocapture", "--test-threads=1"])
        .env(TOLD, &told)
        .stdout(Stdio::from(File::create(&out).unwrap()))
        .stderr(Stdio::from(File::create(&err).unwrap()))
        .spawn()
        .unwrap();
    let read = |path: &Path| {
        String::from_utf8_lossy(&std::fs::read(path).unwrap_or_default()).into_owned()
    };
    let (mut last, mut since) = (String::new(), Instant::now());
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        let now = read(&told);
        if now != last {
            (last, since) = (now, Instant::now());
        } else if since.elapsed() > Duration::from_secs(HANGS_S) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("still reading after {HANGS_S} s: {last}");
        }
        std::thread::sleep(Duration::from_millis(100));
    };
    println!("{}", read(&out));
    let end = read(&err);
    assert!(status.success(), "{status}, while reading: {}\n{end}", read(&told));
}

/// What panics say, with their place.
static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn campaign(told: &Path) {
    std::panic::set_hook(Box::new(|info| {
        let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
        said.push(info.to_string().replace('\n', " "));
    }));
    let only = setting("ERGOPATH_FUZZ_ONLY");
    let is_asked = |t: &&Target| only.as_ref().is_none_or(|o| o.split(',').any(|n| n == t.name));
    let faults: Vec<String> =
        TARGETS.iter().filter(is_asked).flat_map(|t| one_target(t, told)).collect();
    let _ = std::panic::take_hook();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

fn one_target(target: &Target, told: &Path) -> Vec<String> {
    let from = Instant::now();
    restart_peak_memory();
    let (kind, seeds) = seeds::seeds(target.name);
    let mut faults = Vec::new();
    let (mut read, mut accepted, mut slowest) = (0, 0, (0.0, String::new()));
    let mut meet = |seed: &str, mutant: &Mutant| {
        let case = format!("{}, `{seed}`: {}", target.name, mutant.what);
        std::fs::write(told, &case).unwrap();
        let start = Instant::now();
        let met = catch_unwind(AssertUnwindSafe(|| (target.run)(&mutant.bytes)));
        let took = start.elapsed().as_secs_f64();
        read += 1;
        if took > slowest.0 {
            slowest = (took, mutant.what.clone());
        }
        if let Ok(is_accepted) = met {
            accepted += usize::from(is_accepted);
            if !is_accepted && mutant.what == VALID {
                faults.push(format!("{case}: refused\n{}", targets::why_refused()));
            }
            return;
        }
        let said = std::mem::take(&mut *SAID.lock().unwrap_or_else(PoisonError::into_inner));
        let kept = keep(target.name, read, &mutant.bytes);
        faults.push(format!("{case}\n    {}\n    {}", said.join("; "), kept.display()));
    };
    for (k, (name, bytes)) in seeds.iter().enumerate() {
        let valid = Mutant { what: VALID.to_owned(), bytes: bytes.clone() };
        meet(name, &valid);
        if k == 0 {
            for mutant in whole(kind, bytes) {
                meet(name, &mutant);
            }
        }
        let mut rng = stream(first_seed(), Purpose::Simulation, k as u32, 0);
        for _ in 0..count(target.name).div_ceil(seeds.len()) {
            meet(name, &some(kind, bytes, &mut rng));
        }
    }
    let most = peak_memory_mib().unwrap_or_default();
    if most > MOST_MIB {
        faults.push(format!("{}: needed {most:.0} MiB", target.name));
    }
    println!(
        "{:16} {read:5} files, {accepted:4} accepted, {:6.1} s, {most:5.0} MiB, slowest {:.2} s: {}",
        target.name,
        from.elapsed().as_secs_f64(),
        slowest.0,
        slowest.1
    );
    faults
}

/// Keeps what was fallen over, to read it again.
fn keep(target: &str, number: usize, bytes: &[u8]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(format!("{target}_{number}"));
    std::fs::write(&file, bytes).unwrap();
    file
}

/// The name under which `check` knows the file of a target, and whether it needs a map; none where it does not.
fn file_name(target: &str) -> Option<(&'static str, bool)> {
    Some(match target {
        "scenario" | "planner" | "batch" | "shift" | "people" | "map" => ("own.toml", false),
        "model" | "result" | "unfinished" | "manifest" | "trajectory_json" => ("own.json", false),
        "trajectory_yaml" => ("own.yaml", false),
        "body_sheet" => ("person.body.toml", false),
        "body_urdf" | "robot" => ("person.urdf", false),
        "mvnx" => ("own.mvnx", false),
        "bvh" => ("own.bvh", false),
        "asf" => ("own.asf", false),
        "amc" => ("own.amc", false),
        "c3d" => ("own.c3d", true),
        "trc" => ("own.trc", true),
        "points" => ("own.tsv", true),
        "opensim" => ("own.mot", false),
        "path_csv" | "motion_csv" | "data_csv" | "quality_csv" | "worksheets" => ("own.csv", false),
        _ => return None,
    })
}

/// What the program itself says of changed files: it ends by itself, with a code that is documented.
#[test]
fn check_ends_in_words_whatever_is_in_the_file() {
    let room = tempfile::tempdir().unwrap();
    let map = room.path().join("map.toml");
    std::fs::write(&map, made::MAP).unwrap();
    for (name, text) in [("bench.toml", made::BENCH), ("tiny.toml", made::TINY)] {
        std::fs::write(room.path().join(name), text).unwrap();
    }
    let mut runs = 0;
    for target in TARGETS {
        let Some((name, needs_map)) = file_name(target.name) else { continue };
        let (kind, seeds) = seeds::seeds(target.name);
        for (k, (seed, bytes)) in
            seeds.iter().enumerate().skip(usize::from(target.name == "scenario"))
        {
            let mut rng = stream(first_seed(), Purpose::Simulation, k as u32, 1);
            let some = (0..times(6)).map(|_| some(kind, bytes, &mut rng));
            let long =
                Mutant { what: "long".into(), bytes: [bytes, &vec![b'7'; 1 << 17][..]].concat() };
            for mutant in some.chain([long]) {
                let file = room.path().join(name);
                std::fs::write(&file, &mutant.bytes).unwrap();
                let mut command = crate::common::ergopath();
                command.arg("check").arg(&file).timeout(Duration::from_secs(HANGS_S));
                if needs_map {
                    command.arg("--map").arg(&map);
                }
                let done = command.assert();
                let done = done.get_output();
                let said = String::from_utf8_lossy(&done.stderr);
                let is_told = match done.status.code() {
                    Some(0 | 3) => true,
                    Some(2) => !said.trim().is_empty() && !said.contains("panicked"),
                    _ => false,
                };
                let case = format!("{}, `{seed}`: {}", target.name, mutant.what);
                assert!(is_told, "{case}: {}\n{said}", done.status);
                runs += 1;
            }
        }
    }
    assert!(runs > 150, "{runs}");
}

#[test]
fn a_result_whose_mannequin_lacks_a_point_is_refused() {
    let mut value: serde_json::Value = serde_json::from_str(&made::RAN.result).unwrap();
    let points = value.pointer_mut("/moments/0/mannequin/points_m").unwrap();
    points.as_array_mut().unwrap().pop();
    let found = parse_result(Path::new("result.json"), &value.to_string()).map(|_| ());
    let error = found.unwrap_err().to_string();
    assert!(error.contains("moments[0]: a piece of the mannequin has no point"), "{error}");
}

#[test]
fn every_reader_has_a_program_of_its_own() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let programs: BTreeSet<String> = folder
        .join("fuzz_targets")
        .read_dir()
        .unwrap()
        .map(|e| e.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    let names: BTreeSet<String> = TARGETS.iter().map(|t| t.name.to_owned()).collect();
    assert_eq!(programs, names);
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let table: toml::Table = manifest.parse().unwrap();
    let listed = table["bin"].as_array().unwrap().iter();
    let listed: BTreeSet<String> = listed.map(|b| b["name"].as_str().unwrap().to_owned()).collect();
    assert_eq!(listed, names);
}

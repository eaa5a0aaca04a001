//! Nothing is destroyed: outputs never land on inputs or on what somebody else wrote, are whole or
//! absent, and leave devices and links what they are.

use crate::common::{assert_refused, ergopath, files, plan, workplace};
use ergopath::ergonomics::Worksheet;
use predicates::str::contains;
use std::fs;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::{Command, Stdio};

/// A worksheet of one neutral posture.
fn worksheet() -> String {
    let zeros = vec!["0"; Worksheet::COLUMNS.len()];
    format!("{}\n{}\n", Worksheet::COLUMNS.join(","), zeros.join(","))
}

#[test]
fn a_folder_keeps_whatever_ergopath_did_not_write() {
    let (room, scenario) = workplace();
    let theirs = room.path().join("proj");
    fs::create_dir_all(theirs.join(".git")).unwrap();
    fs::write(theirs.join("summary.json"), "{\"other\": \"tool\"}").unwrap();
    fs::write(theirs.join("main.c"), "x").unwrap();
    let before = files(&theirs);
    for option in [&[][..], &["--overwrite"]] {
        assert_refused(
            plan(&room, &scenario, "proj").args(option),
            "not an ergopath output folder",
        );
    }
    assert_eq!(files(&theirs), before);
    assert!(theirs.join(".git").is_dir());

    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let first = files(&out);
    // Notes, the scenario itself and its model in our folder survive a run from there.
    for name in ["bench.toml", "operator.json"] {
        fs::copy(room.path().join(name), out.join(name)).unwrap();
    }
    fs::write(out.join("figures/notes.txt"), "mine").unwrap();
    plan(&room, &out.join("bench.toml"), "out").assert().success();
    let mut after = files(&out);
    assert_eq!(after.remove("figures/notes.txt").unwrap(), b"mine");
    assert_eq!(after.remove("bench.toml").unwrap(), fs::read(&scenario).unwrap());
    after.remove("operator.json").unwrap();
    assert_eq!(after, first, "the same seed gives the same bytes, the list of files too");

    // A table that was edited is not lost, and a path of the run is no input of the next into it.
    fs::write(out.join("candidates.csv"), "with my remarks").unwrap();
    assert_refused(&mut plan(&room, &scenario, "out"), "`candidates.csv` in it was changed since");
    assert_refused(ergopath().arg("report").arg(&out).args(["-q"]), "was changed since");
    assert_eq!(fs::read(out.join("candidates.csv")).unwrap(), b"with my remarks");
    plan(&room, &scenario, "out").arg("--overwrite").assert().success();
    let mut assess = ergopath();
    assess.arg("assess").arg(&scenario).arg("--path").arg(out.join("paths/1.csv"));
    assert_refused(assess.arg("-o").arg(&out), "is an input of this run");
}

#[test]
fn no_output_lands_on_an_input() {
    let (room, scenario) = workplace();
    let at = |name: &str| room.path().join(name).display().to_string();
    fs::write(at("w.csv"), worksheet()).unwrap();
    fs::hard_link(&scenario, at("hard.toml")).unwrap();
    symlink(&scenario, at("soft.toml")).unwrap();
    let data = at("data.csv");
    let movements = "scenarios/demonstrations/simulated_operator.csv";
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(movements), &data).unwrap();
    let before = files(room.path());
    let (bench, planner, model) = (at("bench.toml"), at("tiny.toml"), at("operator.json"));
    let (hard, soft, sheet, out) = (at("hard.toml"), at("soft.toml"), at("w.csv"), at("out"));
    let plan = |timings: &str| {
        let mut command = ergopath();
        command.args(["plan", &bench, "--planner", &planner, "-o", &out, "--timings", timings]);
        command
    };
    for target in [&bench, &hard, &soft, &planner, &model] {
        for option in [&[][..], &["--overwrite"]] {
            assert_refused(plan(target).args(option), "is an input of this call");
        }
    }
    for target in [&bench, &hard, &soft, &model] {
        let mut check = ergopath();
        check.args(["check", &bench, "--overwrite", "--figure", target]);
        assert_refused(&mut check, "is an input of this call");
    }
    let mut score = ergopath();
    score.args(["score", "--overwrite", "--worksheet", &sheet, "-o", &sheet]);
    assert_refused(&mut score, "is an input of this call");
    let mut train = ergopath();
    train.args(["train", &data, "--body", "female_p50", "--overwrite", "-o", &data]);
    assert_refused(&mut train, "is an input of this call");
    assert_eq!(files(room.path()), before);
    // A file of somebody that is no input needs a word.
    assert_refused(ergopath().args(["check", &bench, "--figure", &sheet]), "--overwrite");
    let mut body = ergopath();
    body.args(["body", "--sex", "f", "--stature-m", "1.6", "--mass-kg", "60", "-o", &at("b.urdf")]);
    body.assert().success();
    body.assert().success();
    fs::write(at("b.urdf"), "my own limits").unwrap();
    assert_refused(&mut body, "--overwrite");
    assert_eq!(fs::read(at("b.urdf")).unwrap(), b"my own limits");
    // Twice the same picture, and once more after it was another cell.
    for _ in 0..2 {
        ergopath().args(["check", &bench, "--figure", &at("cell.png")]).assert().success();
    }
    let text = fs::read_to_string(&bench).unwrap();
    fs::write(&bench, text.replace("[0.45, 0.25, 1.25]", "[0.45, 0.25, 1.15]")).unwrap();
    ergopath().args(["check", &bench, "--figure", &at("cell.png")]).assert().success();
    // Two outputs in one place.
    assert_refused(&mut plan(&at("out/result.json")), "would be written twice");
    assert!(!Path::new(&out).exists());
}

#[test]
fn devices_and_links_stay_what_they_are() {
    let (room, scenario) = workplace();
    let at = |name: &str| room.path().join(name);
    let figure = |target: &Path| {
        let mut command = ergopath();
        command.arg("check").arg(&scenario).arg("--json").arg("--figure").arg(target);
        command
    };
    figure(Path::new("/dev/null")).assert().success();
    assert!(Path::new("/dev/null").metadata().unwrap().file_type().is_char_device());
    let shown = figure(Path::new("/dev/stdout")).assert().success().get_output().stdout.clone();
    assert!(shown.starts_with(b"\x89PNG") && shown.ends_with(b"}\n"));
    // Standard output that is a file: both are in it.
    let file = fs::File::create(at("both")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_ergopath"));
    command.arg("check").arg(&scenario).args(["--json", "--figure", "/dev/stdout"]).stdout(file);
    assert!(command.status().unwrap().success());
    assert_eq!(fs::read(at("both")).unwrap(), shown);

    let pipe = at("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe).unwrap()
    });
    figure(&pipe).assert().success();
    assert!(reader.join().unwrap().starts_with(b"\x89PNG"));
    assert!(pipe.symlink_metadata().unwrap().file_type().is_fifo());

    fs::create_dir(at("far")).unwrap();
    symlink("far/cell.png", at("link.png")).unwrap();
    for _ in 0..2 {
        figure(&at("link.png")).assert().success();
        assert!(at("link.png").is_symlink() && at("far/cell.png").is_file());
    }
    assert_eq!(files(&at("far")).len(), 1);
}

/// Runs the program where no file may be larger than some KiB, as on a disk that fills up.
fn with_room_for(kib: u32, arguments: &[&str]) -> std::process::Output {
    let mut command = Command::new("bash");
    command.arg("-c").arg(format!("trap '' XFSZ; ulimit -f {kib}; exec \"$0\" \"$@\""));
    command.arg(env!("CARGO_BIN_EXE_ergopath")).args(arguments);
    command.output().unwrap()
}

#[test]
fn a_full_disk_leaves_all_as_it_was() {
    if Command::new("bash").arg("-c").arg("exit 0").status().is_err() {
        eprintln!("SKIPPED: no bash, so no disk can be made full");
        return;
    }
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    plan(&room, &scenario, "more").args(["--seed", "5"]).assert().success();
    let at = |name: &str| room.path().join(name).display().to_string();
    let (bench, planner, out, more) = (at("bench.toml"), at("tiny.toml"), at("out"), at("more"));
    let before = files(room.path());
    let (new, page, urdf, png) =
        (at("new/deep"), at("new/c.html"), at("new/b.urdf"), at("new/c.png"));
    let size = ["--sex", "f", "--stature-m", "1.6", "--mass-kg", "60", "-o", &urdf];
    let body = [&["body"][..], &size].concat();
    let calls: [&[&str]; 8] = [
        &["plan", &bench, "--planner", &planner, "-o", &new],
        &["plan", &bench, "--planner", &planner, "--seed", "7", "-o", &out],
        &["assess", &bench, "--planner", &planner, "-o", &out, "--path", &at("more/paths/1.csv")],
        &["report", &out],
        &["report", &out, "-o", &new],
        &["compare", &out, &more, "-o", &page],
        &["check", &bench, "--figure", &png],
        &body,
    ];
    for call in calls {
        let run = with_room_for(4, call);
        let shown = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{call:?}: {shown}");
        assert!(shown.contains("cannot be written"), "{call:?}: {shown}");
        assert_eq!(files(room.path()), before, "{call:?}");
        assert!(!room.path().join("new").exists(), "{call:?}");
    }
}

#[test]
fn lost_standard_output_is_told_and_a_closed_pipe_is_quiet() {
    let (_room, scenario) = workplace();
    let full = || fs::File::options().write(true).open("/dev/full");
    if full().is_err() {
        eprintln!("SKIPPED: no /dev/full here");
        return;
    }
    let scenario = scenario.display().to_string();
    for call in
        [&["check", &scenario][..], &["schema", "planner"], &["completions", "bash"], &["--help"]]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ergopath"));
        let run = command.args(call).stdout(full().unwrap()).output().unwrap();
        assert_eq!(run.status.code(), Some(1), "{call:?}");
        let mut command = Command::new(env!("CARGO_BIN_EXE_ergopath"));
        command.args(call).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let run = child.wait_with_output().unwrap();
        assert_eq!((run.status.code(), run.stderr.len()), (Some(0), 0), "{call:?}");
    }
}

/// Whether a signal is in a mask of a process.
pub(crate) fn has(process: &str, mask: &str, signal: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix(mask));
    mask.is_some_and(|m| (u64::from_str_radix(m.trim(), 16).unwrap() >> (signal - 1)) & 1 == 1)
}

#[test]
fn every_signal_that_asks_for_an_end_is_an_interruption() {
    if !Path::new("/proc/self/status").exists() {
        eprintln!("SKIPPED: no /proc, so it is not known when a program listens to signals");
        return;
    }
    let (room, scenario) = workplace();
    let scenario = scenario.display().to_string();
    let out = room.path().join("out");
    for (verb, name, number) in [("plan", "HUP", 1), ("batch", "INT", 2), ("plan", "TERM", 15)] {
        if has("self", "SigIgn:", number) {
            eprintln!(
                "SKIPPED: SIG{name} is ignored here, and a program that inherits that keeps it"
            );
            continue;
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_ergopath"));
        command.args([verb, &scenario, "--planner", "careful", "-o"]).arg(&out);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        while !has(&child.id().to_string(), "SigCgt:", number) {
            assert!(child.try_wait().unwrap().is_none(), "{verb} ended by itself");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        Command::new("kill").arg(format!("-{name}")).arg(child.id().to_string()).status().unwrap();
        let run = child.wait_with_output().unwrap();
        let shown = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(130), "{verb} {name}: {shown}");
        let told = if verb == "plan" { shown } else { String::from_utf8(run.stdout).unwrap() };
        assert!(told.contains("interrupted"), "{verb} {name}: {told}");
        assert_eq!(out.exists(), verb == "batch", "{verb} {name}");
        let _ = fs::remove_dir_all(&out);
    }
}

#[test]
fn a_run_that_was_killed_while_it_replaced_files_is_told() {
    let (room, scenario) = workplace();
    plan(&room, &scenario, "out").assert().success();
    let list = room.path().join("out/.ergopath-output.json");
    let text = fs::read_to_string(&list).unwrap();
    let between = text.replacen(
        '{',
        "{\"coming\": {\"staging\": \".ergopath-gone\", \"files\": {\"new.csv\": \"0\"}},",
        1,
    );
    fs::write(&list, between).unwrap();
    for command in ["report", "check"] {
        assert_refused(ergopath().arg(command).arg(room.path().join("out")), "is incomplete");
    }
    plan(&room, &scenario, "out").assert().success();
    assert_eq!(fs::read_to_string(&list).unwrap(), text);
    ergopath()
        .arg("report")
        .arg(room.path().join("out"))
        .assert()
        .success()
        .stdout(contains("up to date"));
    // A list that points elsewhere is followed nowhere.
    fs::write(room.path().join("victim"), "mine").unwrap();
    fs::write(&list, text.replacen("\"candidates.csv\"", "\"../victim\"", 1)).unwrap();
    assert_refused(&mut plan(&room, &scenario, "out"), "which is no file of this folder");
    assert_eq!(fs::read(room.path().join("victim")).unwrap(), b"mine");
}

#[test]
fn a_name_from_a_strangers_file_is_no_formula_in_a_table() {
    let (room, scenario) = workplace();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/robot/panda.urdf");
    let robot = std::fs::read_to_string(shipped).unwrap();
    let formula = "=HYPERLINK(0)";
    let robot = robot.replace("\"panda_joint1\"", &format!("\"{formula}\""));
    assert!(robot.contains(formula));
    std::fs::write(room.path().join("robot.urdf"), robot).unwrap();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let own = "urdf = \"robot.urdf\"\nbase_link = \"panda_link0\"\ntcp = \"panda_hand_tcp\"";
    std::fs::write(&scenario, text.replace("preset = \"panda\"", own)).unwrap();
    plan(&room, &scenario, "out").assert().success();
    let table = std::fs::read_to_string(room.path().join("out/paths/1.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(header.contains(&format!(",'{formula}")), "{header}");
    for (name, bytes) in files(&room.path().join("out")) {
        let is_table = Path::new(&name).extension().is_some_and(|e| e == "csv");
        let text = String::from_utf8_lossy(&bytes);
        assert!(!is_table || !text.contains(&format!(",{formula}")), "{name}");
    }
}

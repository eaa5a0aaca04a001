//! Programs for controllers, read again by parsers of their own: every written posture is on the planned path,
//! at its time, and what the program says of itself is so.

use crate::common::{assert_refused, ergopath, plan, workplace};
use ergopath::math::Vec3;
use ergopath::robot::{Robot, tcp_poses};
use ergopath::scenario::read_scenario;
use predicates::str::contains;
use std::path::{Path, PathBuf};

/// A run of a robot with six joints.
fn run(preset: &str) -> (tempfile::TempDir, PathBuf, Robot) {
    let (room, scenario) = workplace();
    if preset != "panda" {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hand_over.toml");
        std::fs::copy(shipped, &scenario).unwrap();
    }
    plan(&room, &scenario, "out").assert().success();
    let out = room.path().join("out");
    let robot = read_scenario(&scenario).unwrap().robot;
    assert_eq!(robot.name, preset);
    (room, out, robot)
}

/// Times and places of the TCP of the best path, as planned.
fn planned(out: &Path) -> Vec<(f64, Vec3)> {
    let text = std::fs::read_to_string(out.join("paths/1.csv")).unwrap();
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        (v[0], Vec3::new(v[1], v[2], v[3]))
    };
    text.lines().skip(1).map(row).collect()
}

/// What a program does: a posture (rad) reached at a time (s), in order, from the start on.
type Read = Vec<(f64, Vec<f64>)>;
/// A language, a name of a file, and its parser.
type Language = (&'static str, &'static str, fn(&str) -> Read);

/// All numbers in a text, whatever stands between them.
fn numbers(text: &str) -> Vec<f64> {
    let part = |c: char| !(c.is_ascii_digit() || ['.', '-', '+'].contains(&c));
    text.split(part).filter_map(|w| w.parse().ok()).collect()
}

/// Between two signs.
fn within<'a>(line: &'a str, open: &str, close: &str) -> &'a str {
    line.split_once(open).unwrap().1.split_once(close).unwrap().0
}

fn hold(read: &mut Read, seconds: f64) {
    let (t, q) = read.last().unwrap().clone();
    read.push((t + seconds, q));
}

fn urscript(text: &str) -> Read {
    let mut read = Read::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("movej(") {
            let q = numbers(within(line, "[", "]"));
            match line.split_once("t=") {
                None => read.push((0.0, q)),
                Some((_, rest)) => {
                    let t = rest.split(',').next().unwrap().parse::<f64>().unwrap();
                    let before = read.last().unwrap().0;
                    read.push((before + t, q));
                }
            }
        } else if line.starts_with("sleep(") {
            hold(&mut read, within(line, "(", ")").parse().unwrap());
        }
    }
    read
}

fn krl(text: &str) -> Read {
    let mut read = Read::new();
    // Postures of the open block with their shares of its time.
    let mut block: Vec<(Vec<f64>, f64)> = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("PTP {") || line.starts_with("SPTP {") {
            let axes = within(line, "{", "}").split(',').map(str::trim);
            let q: Vec<f64> = axes
                .enumerate()
                .map(|(i, a)| {
                    let value = a.strip_prefix(&format!("A{} ", i + 1)).unwrap();
                    value.parse::<f64>().unwrap().to_radians()
                })
                .collect();
            if line.starts_with('P') { read.push((0.0, q)) } else { block.push((q, f64::NAN)) }
        } else if let Some(part) = line.strip_prefix("TIME_BLOCK PART = ") {
            block.last_mut().unwrap().1 = part.parse().unwrap();
        } else if let Some(end) = line.strip_prefix("TIME_BLOCK END = ") {
            let (end, start): (f64, f64) = (end.parse().unwrap(), read.last().unwrap().0);
            let whole: f64 = block.iter().map(|b| b.1).sum();
            let mut done = 0.0;
            for (q, part) in block.drain(..) {
                done += part;
                read.push((start + end * done / whole, q));
            }
        } else if let Some(seconds) = line.strip_prefix("WAIT SEC ") {
            hold(&mut read, seconds.parse().unwrap());
        }
    }
    read
}

fn rapid(text: &str) -> Read {
    let mut read = Read::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with("MoveAbsJ ") {
            let q = numbers(within(line, "[[", "]")).into_iter().map(f64::to_radians).collect();
            let before = read.last().map_or(0.0, |r| r.0);
            let t = line
                .split_once("\\T:=")
                .map_or(0.0, |(_, rest)| rest.split(',').next().unwrap().parse().unwrap());
            read.push((before + t, q));
        } else if let Some(seconds) = line.strip_prefix("WaitTime ") {
            hold(&mut read, seconds.trim_end_matches(';').parse().unwrap());
        }
    }
    read
}

fn franka(text: &str) -> Read {
    let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1);
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
        (v[0], v[1..].to_vec())
    };
    rows.map(row).collect()
}

/// The posture of a program at a time, where joints move evenly between its points.
fn at(read: &Read, t: f64) -> Vec<f64> {
    let k = read.iter().position(|r| r.0 >= t - 1e-9).unwrap_or(read.len() - 1).max(1);
    let ((t0, a), (t1, b)) = (&read[k - 1], &read[k]);
    let share = if t1 > t0 { ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { 1.0 };
    a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect()
}

fn place(robot: &Robot, q: &[f64]) -> Vec3 {
    tcp_poses(robot, &[q.to_vec()])[0].translation.vector
}

/// The planned place at a time, between its points evenly.
fn place_at(planned: &[(f64, Vec3)], t: f64) -> Vec3 {
    let k = planned.iter().position(|p| p.0 >= t).unwrap_or(planned.len() - 1).max(1);
    let ((t0, a), (t1, b)) = (planned[k - 1], planned[k]);
    a + ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) * (b - a)
}

/// What a text says of itself in "at most X mm".
fn stated_m(text: &str) -> f64 {
    let line = text.lines().find(|l| l.contains("from the planned path")).unwrap();
    numbers(line.split_once("at most ").unwrap().1)[0] / 1e3
}

fn check(text: &str, read: &Read, robot: &Robot, planned: &[(f64, Vec3)]) {
    assert!(text.contains("NOT RUN ON A CONTROLLER"), "{text}");
    assert!(text.is_ascii() && text.contains("limits of joint positions: kept"), "{text}");
    assert_eq!(read[0].0, 0.0);
    let (end, last) = (planned.last().unwrap().0, read.last().unwrap().0);
    assert!((last - end).abs() < 2e-3, "{last} s of {end} s");
    // Every posture is on the path to 0.1 mm, at its time.
    for (t, q) in read {
        let nearest = planned.iter().min_by(|a, b| (a.0 - t).abs().total_cmp(&(b.0 - t).abs()));
        let (at, right) = *nearest.unwrap();
        let right = if (at - t).abs() < 1e-4 { right } else { place_at(planned, *t) };
        let off = (place(robot, q) - right).norm();
        assert!(off < 1e-4, "{off} m at {t} s");
    }
    // Between them it stays as near as it says.
    let apart = planned.iter().map(|(t, p)| (place(robot, &at(read, *t)) - p).norm());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart <= stated_m(text) + 2e-5, "{apart} m, but {}", stated_m(text));
}

#[test]
fn programs_of_moves_are_the_path() {
    let (room, out, robot) = run("ur5e");
    let planned = planned(&out);
    let readers: [Language; 3] = [
        ("urscript", "path.script", urscript),
        ("krl", "path.src", krl),
        ("rapid", "path.mod", rapid),
    ];
    for (language, name, reader) in readers {
        let file = room.path().join(name);
        let write = |more: &[&str], file: &Path| {
            let mut command = ergopath();
            command.arg("program").arg(&out).args(["--for", language, "-o"]).arg(file).args(more);
            command
        };
        write(&[], &file).assert().success().stdout(contains("NOT RUN ON A CONTROLLER"));
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("limits of joint accelerations: not checked"), "{text}");
        let read = reader(&text);
        check(&text, &read, &robot, &planned);
        assert!(
            stated_m(&text) <= 5e-4 && read.len() < planned.len(),
            "{language}: {}",
            read.len()
        );
        // Coarser has fewer; the same has the same bytes; a file of the user's stays.
        let coarse = room.path().join(format!("coarse_{name}"));
        write(&["--deviation-mm", "5"], &coarse).assert().success();
        let coarse = std::fs::read_to_string(coarse).unwrap();
        check(&coarse, &reader(&coarse), &robot, &planned);
        assert!(reader(&coarse).len() < read.len() && stated_m(&coarse) <= 5e-3);
        write(&[], &file).assert().success();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        std::fs::write(&file, "mine").unwrap();
        assert_refused(&mut write(&[], &file), "does not look like a file that ergopath wrote");
    }
    let file = room.path().join("rows.csv");
    let mut command = ergopath();
    command.arg("program").arg(&out).args(["--for", "franka", "-o"]).arg(&file);
    assert_refused(&mut command, "is written for robots of 7 turning joints");
    assert!(!file.exists());
    let call = |more: &[&str]| {
        let mut command = ergopath();
        let to = room.path().join("other.script");
        command.arg("program").arg(&out).args(["--for", "urscript", "-o"]).arg(to).args(more);
        command
    };
    assert_refused(&mut call(&["--path", "strait"]), "did you mean `straight`?");
    assert_refused(&mut call(&["--deviation-mm", "0"]), "give 0.01 to 10 mm");
    call(&["--path", "2"]).assert().success();
    // Other limits than those of the run.
    let scenario = room.path().join("bench.toml");
    let text = std::fs::read_to_string(&scenario).unwrap();
    std::fs::write(&scenario, format!("{text}\n")).unwrap();
    assert_refused(&mut call(&[]), "is out of date");
}

#[test]
fn rows_for_every_millisecond_are_the_path() {
    let (room, out, robot) = run("panda");
    let planned = planned(&out);
    let file = room.path().join("rows.csv");
    let write = |language: &str, file: &Path| {
        let mut command = ergopath();
        command.arg("program").arg(&out).args(["--for", language, "-o"]).arg(file);
        command
    };
    write("franka", &file).assert().success();
    let text = std::fs::read_to_string(&file).unwrap();
    let read = franka(&text);
    assert!(text.contains("limits of joint accelerations: kept"), "{text}");
    assert!(read.windows(2).all(|w| (w[1].0 - w[0].0 - 1e-3).abs() < 1e-9));
    for (t, p) in &planned {
        let off = (place(&robot, &at(&read, *t)) - p).norm();
        assert!(off < 1e-4, "{off} m at {t} s");
    }
    assert!(stated_m(&text) < 1e-4);
    // The message of ROS is read by `assess` and is the same path.
    let yaml = room.path().join("best.yaml");
    write("ros", &yaml).assert().success();
    assert!(std::fs::read_to_string(&yaml).unwrap().contains("# NOT RUN ON A CONTROLLER"));
    let mut assess = ergopath();
    assess.arg("assess").arg(room.path().join("bench.toml")).arg("--path").arg(&yaml);
    assess.arg("-o").arg(room.path().join("assessed")).arg("--planner");
    assess.arg(room.path().join("tiny.toml")).assert().success();
    assert_refused(
        &mut write("rapid", &room.path().join("x.mod")),
        "turning joints; `panda` has 7",
    );
}

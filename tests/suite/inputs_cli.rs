//! Inputs that look like another unit, another order or a slip of the pen: refused with a question or
//! told as a warning, by `plan`, `assess` and `check` alike; and what `check` finds before planning.

use crate::common::{assert_refused, ergopath, plan, workplace};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const START: [f64; 3] = [0.42, -0.35, 0.95];
const GOAL: [f64; 3] = [0.45, 0.25, 1.25];
/// Orientation of both ends: roll 180 deg, w first.
const DOWN: [f64; 4] = [0.0, 1.0, 0.0, 0.0];

/// The straight path of the shared workplace in 21 rows, each changed by `edit`.
fn path_text(edit: impl Fn(f64, &mut [f64; 8])) -> String {
    let mut text = "time_s,x_m,y_m,z_m,qw,qx,qy,qz\n".to_owned();
    for k in 0..=20 {
        let s = f64::from(k) / 20.0;
        let p = |i: usize| START[i] + s * (GOAL[i] - START[i]);
        let mut row = [4.0 * s, p(0), p(1), p(2), DOWN[0], DOWN[1], DOWN[2], DOWN[3]];
        edit(s, &mut row);
        let cells: Vec<String> = row.iter().map(ToString::to_string).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

fn assess(room: &TempDir, scenario: &Path, path: &Path) -> assert_cmd::Command {
    let mut command = ergopath();
    command.arg("assess").arg(scenario).arg("--path").arg(path);
    command.arg("-o").arg(room.path().join("assessed"));
    command.arg("--planner").arg(room.path().join("tiny.toml"));
    command
}

fn written(room: &TempDir, name: &str, text: &str) -> PathBuf {
    let path = room.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// The scenario with one piece of its text replaced.
fn edited(room: &TempDir, scenario: &Path, from: &str, to: &str) -> PathBuf {
    let text = std::fs::read_to_string(scenario).unwrap();
    assert!(text.contains(from), "{from}");
    written(room, "edited.toml", &text.replacen(from, to, 1))
}

fn check_json(scenario: &Path) -> (Value, i32) {
    let output = ergopath().arg("check").arg(scenario).arg("--json").output().unwrap();
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    let value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {shown}"));
    (value, output.status.code().unwrap())
}

/// All lines of one list of `check --json`.
fn lines(value: &Value, list: &str) -> String {
    let all = value[list].as_array().unwrap().iter().map(|l| l.as_str().unwrap());
    all.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_path_in_other_units_is_asked_about() {
    let (room, scenario) = workplace();
    let ask = |text: &str, words: &str| {
        let path = written(&room, "today.csv", text);
        assert_refused(&mut assess(&room, &scenario, &path), words);
    };
    ask(
        &path_text(|_, r| r[1..4].iter_mut().for_each(|x| *x *= 1e3)),
        "line 2, column `x_m`: 420 m is far outside any cell. Is it in millimetres?",
    );
    ask(&path_text(|_, r| r[0] *= 1e3), "line 22, column `time_s`: 4000 s");
    ask(&path_text(|_, r| r[0] *= 1e3), "Is it in milliseconds?");
    // x, y, z, w under the names w, x, y, z; and the other way round.
    ask(&path_text(|_, r| r[4..].rotate_left(1)), "scalar last (x, y, z, w)?");
    ask(&path_text(|_, r| r[4..].rotate_right(1)), "scalar first (w, x, y, z)?");
    let joints: Vec<String> = (1..=7).map(|j| format!("panda_joint{j}")).collect();
    let degrees =
        format!("time_s,{}\n0,0,-45,0,-135,0,90,45\n4,10,-45,0,-135,0,90,45\n", joints.join(","));
    ask(&degrees, "line 2, column `panda_joint2`: -45 rad is 43.24 rad beyond the joint's limit.");
    ask(&degrees, "-45 deg are -0.7854 rad");
    let trajectory = |velocity: &str| {
        format!(
            "joint_names: [{}]\npoints:\n- positions: [0, -0.8, 0, -2.4, 0, 1.6, 0.8]\n  velocities: [{velocity}, \
             0, 0, 0, 0, 0, 0]\n  time_from_start: {{sec: 0, nanosec: 0}}\n- positions: [0.1, -0.8, 0, -2.4, 0, \
             1.6, 0.8]\n  velocities: [0, 0, 0, 0, 0, 0, 0]\n  time_from_start: {{sec: 4, nanosec: 0}}\n---\n",
            joints.join(", ")
        )
    };
    let path = written(&room, "run.yaml", &trajectory(".nan"));
    let words = "point 1, joint `panda_joint1`: the velocity is NaN";
    assert_refused(&mut assess(&room, &scenario, &path), words);
    let path = written(&room, "run.yaml", &trajectory("0").replace("-2.4", "-137"));
    assert_refused(&mut assess(&room, &scenario, &path), "point 1, joint `panda_joint4`: -137 rad");
    // Velocities that are not those of the positions are told, and the positions count.
    let path = written(&room, "run.yaml", &trajectory("3"));
    let output = assess(&room, &scenario, &path).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("the file gives a velocity of 3.000, but the positions move at"),
        "{told}"
    );
}

#[test]
fn a_path_that_takes_long_or_is_saved_by_a_spreadsheet_is_read() {
    let (room, scenario) = workplace();
    let kind = |name: &str, bytes: &[u8]| {
        let path = room.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let output = ergopath().arg("check").arg(&path).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().replace(name, "")
    };
    let plain = path_text(|_, _| ());
    let right = kind("plain.csv", plain.as_bytes());
    assert!(right.contains("21 samples over 4.00 s, 0.671 m"), "{right}");
    let german = plain.replace(',', ";").replace('.', ",");
    let wide: Vec<u8> =
        [0xFF, 0xFE].into_iter().chain(german.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(kind("german.csv", german.as_bytes()), right);
    assert_eq!(kind("sep.csv", format!("sep=;\n{german}").as_bytes()), right);
    assert_eq!(kind("tabs.csv", german.replace(';', "\t").as_bytes()), right);
    assert_eq!(kind("wide.csv", &wide), right);
    let slow = written(&room, "slow.csv", &path_text(|_, r| r[0] *= 75.0));
    assess(&room, &scenario, &slow).assert().success();
}

#[test]
fn a_path_to_elsewhere_is_scored_but_compared_with_nothing() {
    let (room, scenario) = workplace();
    let result = |text: &str| -> Value {
        let path = written(&room, "today.csv", text);
        assess(&room, &scenario, &path).assert().success();
        let bytes = std::fs::read(room.path().join("assessed/result.json")).unwrap();
        serde_json::from_slice(&bytes).unwrap()
    };
    let own = |r: &Value| {
        let all = r["candidates"].as_array().unwrap();
        all.iter().find(|c| c["id"] == "today").unwrap().clone()
    };
    let compared = |r: &Value| {
        let mut all = r["comparisons"].as_array().unwrap().iter();
        all.any(|c| c["other"] == "today" || c["lead"] == "today")
    };
    let same = result(&path_text(|_, _| ()));
    assert!(own(&same)["ends"].is_null() && compared(&same));
    // It stops half way: the lower, easier half.
    let half = result(&path_text(|s, r| {
        for i in 0..3 {
            r[1 + i] = START[i] + 0.5 * s * (GOAL[i] - START[i]);
        }
    }));
    let path = own(&half);
    assert!((path["ends"]["goal_m"].as_f64().unwrap() - 0.3357).abs() < 1e-3, "{path}");
    assert!(path["ends"]["start_m"].as_f64().unwrap() < 1e-9);
    assert!(path["bodies"][0]["rula"]["expected"].is_number(), "it is scored");
    assert!(!compared(&half));
    assert!(half["verdict"]["best"].is_null() && path["rank"].is_null());
    let mut found = half["verdict"]["findings"].as_array().unwrap().iter();
    assert!(found.any(|f| f["finding"] == "other_ends" && f["path"] == "today"), "{half}");
}

#[test]
fn a_scenario_with_a_slip_of_the_pen_is_refused_at_its_place() {
    let (room, scenario) = workplace();
    let refuse = |from: &str, to: &str, words: &str| {
        let path = edited(&room, &scenario, from, to);
        assert_refused(ergopath().arg("check").arg(&path), words);
    };
    let head = "[motion]";
    let before = |text: &str| format!("{text}\n{head}");
    refuse("at_m = [0.0, 0.0]", "at_m = [0, 0, 0.9]", "3 values where exactly 2 are expected");
    refuse(head, &before("[free]\nduration_s = [1, 2, 3]"), "3 values where exactly 2");
    refuse(
        "[0.45, 0.25, 1.25]\nrpy_deg = [180, 0, 0]",
        "[0.45, 0.25, 1.25]\nquaternion_wxyz = [0, 1, 0, 0, 0]",
        "5 values where exactly 4",
    );
    refuse("position_m = [0.42,", "position_m = [420,", "420 m is far outside any cell.");
    refuse("duration_s = 4.0", "duration_s = 4000", "Is it in milliseconds?");
    refuse(
        "part_mass_kg = 1.5",
        "part_mass_kg = 180",
        "180 kg is no load for a hand. Is it in grams?",
    );
    refuse("part_mass_kg = 1.5", "part_mass_kg = 1500", "1500 g are 1.5 kg");
    let far = "[free]\ngoal_places = [{ position_m = [9.45, 0.25, 1.25] }]";
    refuse(head, &before(far), "a place 9.00 m from the first one");
    refuse(head, &before("[free]\nworker_at_m = [5, 5]"), "free.worker_at_m holds 5");
    refuse("at_m = [0.0, 0.0]", "at_m = [0.75, 0.0]", "the worker stands inside obstacle `bench`");
    refuse("[0.45, 0.25, 1.25]", "[0.42, -0.35, 0.95]", "the goal is the start");
    let wire = "[[obstacle]]\nname = \"post\"\nshape = \"sphere\"\nposition_m = [2, 0, 1]\nradius_m = 1e-320";
    refuse(head, &before(wire), "obstacle `post`: sizes must be 0.001 to 100 m");
    let twin = "[[obstacle]]\nname = \"bench\"\nshape = \"sphere\"\nposition_m = [2, 0, 1]\nradius_m = 0.1";
    refuse(head, &before(twin), "there are two obstacles named `bench`");
    let limit = "[[robot.limit]]\njoint = \"panda_joint1\"\nvelocity_rad_s = 1";
    refuse(head, &before(&format!("{limit}\n{limit}")), "`panda_joint1` has two [[robot.limit]]");
    refuse(head, &before(&limit.replace("joint1", "joint9")), "edited.toml: robot.limit:");
    refuse("preset = \"panda\"", "preset = \"panda\"\ntcp = \"x\"", "robot.tcp are both given");
    refuse("preset = \"panda\"", "preset = \"pandaa\"", "edited.toml: robot.preset:");
    refuse("\"female_p50\"", "\"female_p51\"", "edited.toml: worker.bodies:");
    let bodies = "bodies = [\"female_p50\"]";
    refuse(bodies, "bodies = \"female_p51\"", "edited.toml: worker.bodies:");
    refuse(bodies, "bodies = 50", "the name of a body, or a list of names");
    let women = |bodies: &str, share: &str| format!("bodies = {bodies}\nwomen_share = {share}");
    refuse(bodies, &women("\"male_p50\"", "0.5"), "but no body of the scenario is a population");
    refuse(bodies, &women("\"population\"", "40"), "worker.women_share = 40");
    refuse(bodies, &women("[\"male_p50\", \"population\"]", "nan"), "worker.women_share = NaN");
    refuse("\"operator.json\"", "\"none.json\"", "edited.toml: worker.posture_model:");
    refuse("side = \"right\"", "side = \"right\"\ntrunk_supported = true", "but the worker stands");
    let steps = "side = \"right\"\nsteps = \"allowed\"";
    refuse("side = \"right\"", steps, "worker.steps is \"allowed\", but the pelvis does not move");
    refuse("name = \"Bench pick and place\"", "name = \"a\\nb\"", "a control character");
    let path = |name: &str| format!("[[path]]\nname = \"{name}\"\nvia_m = [[0.4, 0.0, 1.1]]\n");
    refuse(head, &before(&path("straight")), "one of its own paths");
    refuse(head, &before(&path("a/b")), "holds a slash");
    refuse(head, &before(&path("\\u001b[31m")), "a control character");
    refuse(head, &before(&path(&"x".repeat(10_000))), "has 10000 characters");
    refuse(head, &before(&(path("today") + &path("today"))), "two paths named `today`");
    let straight = written(&room, "straight.csv", &path_text(|_, _| ()));
    assert_refused(&mut assess(&room, &scenario, &straight), "one of its own paths");
    assert_refused(
        plan(&room, &scenario, "out").args(["--threads", "100000"]),
        "100000 threads are not possible",
    );
    assert_refused(ergopath().args(["check", "/dev/zero"]), "a pipe or a device");
}

#[test]
fn what_may_be_meant_is_a_warning_of_plan_and_check() {
    let (room, scenario) = workplace();
    let path = edited(
        &room,
        &scenario,
        "[0.45, 0.25, 1.25]\nrpy_deg = [180, 0, 0]",
        "[0.45, 0.25, 1.25]\nrpy_deg = [3.1416, 0, 1.5708]",
    );
    let words = "goal.rpy_deg = [3.1416, 0.0, 1.5708] is read as degrees, but is round in radians";
    let (value, _) = check_json(&path);
    assert!(lines(&value, "warnings").contains(words), "{value}");
    let output = plan(&room, &path, "out").output().unwrap();
    assert!(String::from_utf8(output.stderr).unwrap().contains(words));
    assert!(!lines(&check_json(&scenario).0, "warnings").contains("radians"));
    for (from, to, words) in [
        (
            "cycles_per_min = 5",
            "cycles_per_min = 60",
            "leaves 1.00 s for a cycle, but the movement alone takes 4 s",
        ),
        (
            "hold_s = 2",
            "hold_s = 30",
            "leaves 12.00 s for a cycle, but task.hold_s alone takes 30 s",
        ),
    ] {
        let (value, code) = check_json(&edited(&room, &scenario, from, to));
        assert!(code == 0 && lines(&value, "warnings").contains(words), "{value}");
    }
}

#[test]
fn a_free_duration_is_kept_and_no_bend_is_a_straight_path() {
    let (room, scenario) = workplace();
    let of = |out: &str| -> Value {
        let bytes = std::fs::read(room.path().join(out).join("result.json")).unwrap();
        serde_json::from_slice(&bytes).unwrap()
    };
    // The shortest possible is 1.92 s.
    let path = edited(&room, &scenario, "[motion]", "[free]\nduration_s = [2.5, 3.0]\n[motion]");
    plan(&room, &path, "quick").assert().success();
    let quick = of("quick");
    for c in quick["candidates"].as_array().unwrap() {
        let Some(times) = c["path"]["time_s"].as_array() else { continue };
        let last = times.last().unwrap().as_f64().unwrap();
        assert!((2.5 - 1e-9..=3.0 + 1e-9).contains(&last), "{} {last}", c["id"]);
    }
    assert_eq!(quick["warnings"][0]["doubt"]["kind"], "duration_outside_range");
    let tiny = std::fs::read_to_string(room.path().join("tiny.toml")).unwrap();
    let tiny = tiny.replace("sampled_offset_m = 0.1", "sampled_offset_m = 0");
    std::fs::write(room.path().join("tiny.toml"), tiny).unwrap();
    plan(&room, &scenario, "flat").assert().success();
    let flat = of("flat");
    assert!(flat["candidates"].as_array().unwrap().iter().any(|c| c["id"] == "straight"));
}

#[test]
fn check_finds_what_plan_would() {
    let (room, scenario) = workplace();
    let (fine, code) = check_json(&scenario);
    assert_eq!((lines(&fine, "errors").as_str(), code), ("", 0));
    let shortest = fine["cell"]["shortest_s"].as_f64().unwrap();
    assert!((1.88..2.0).contains(&shortest), "{shortest}");

    let of = |from: &str, to: &str| check_json(&edited(&room, &scenario, from, to));
    let (quick, code) = of("duration_s = 4.0", "duration_s = 0.4");
    assert_eq!(code, 3);
    assert!(lines(&quick, "errors").contains("0.4 s is too short for this movement"), "{quick}");
    let (away, _) = of("facing_deg = 0 ", "facing_deg = 173 ");
    assert!(lines(&away, "warnings").contains("away from the middle of the task"), "{away}");
    let (outside, code) = of("min_m = [0.25, -0.60, 0.80]", "min_m = [0.25, -0.30, 0.80]");
    assert_eq!(code, 3);
    let said = lines(&outside, "errors");
    assert!(said.contains("the start is 50 mm outside the workspace (y >= -0.30 m)"), "{said}");
    // A shelf through the legs, but not where the worker's middle is.
    let shelf = "[[obstacle]]\nname = \"shelf\"\nshape = \"box\"\nposition_m = [0.0, 0.18, 0.4]\n\
                 size_m = [0.3, 0.32, 0.4]\n[motion]";
    let (shelf, code) = of("[motion]", shelf);
    assert_eq!(code, 3);
    let said = lines(&shelf, "errors");
    assert!(said.contains("obstacle `shelf` stands") && said.contains("left"), "{said}");
    // Seated so high that the feet hang.
    let (seated, _) = of("stance = \"standing\"", "stance = \"seated\"\nseat_height_m = 0.62");
    let feet = seated["cell"]["hanging_feet"][0]["above_m"].as_f64().unwrap();
    assert!((0.05..0.35).contains(&feet), "{seated}");
    assert!(lines(&seated, "warnings").contains("hang"), "{seated}");
    // Overhead, where nobody was recorded.
    let text = std::fs::read_to_string(&scenario).unwrap();
    let overhead = text
        .replace("\"operator.json\"", "\"demo_operator\"")
        .replace("[0.42, -0.35, 0.95]", "[0.35, -0.15, 1.75]")
        .replace("[0.45, 0.25, 1.25]", "[0.35, 0.15, 1.75]")
        .replace("max_m = [0.80, 0.60, 1.60]", "max_m = [0.80, 0.60, 1.90]");
    let (overhead, _) = check_json(&written(&room, "overhead.toml", &overhead));
    let along = &overhead["cell"]["along"][0];
    assert!(along["unsupported"].as_f64().unwrap() > 0.5, "{along}");
    assert!(lines(&overhead, "warnings").contains("beyond what the posture model"), "{overhead}");

    let shown = |path: &Path| {
        String::from_utf8(ergopath().arg("check").arg(path).output().unwrap().stdout).unwrap()
    };
    let text = shown(&room.path().join("overhead.toml"));
    assert!(text.contains("\nWarnings\n") && text.contains("\nDefaults used\n"), "{text}");
    assert!(!text.contains("No problems found"), "{text}");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bench_pick_and_place.toml");
    let text = shown(&shipped);
    assert!(text.contains("No problems found.") && !text.contains("\nWarnings"), "{text}");
}

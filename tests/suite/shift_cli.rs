//! `ergopath shift` from outside: what tasks come to, what is paired, what is refused.

use crate::common::{assert_refused, ergopath, files, plan, unsealed, workplace};
use crate::schema_cli::{as_json, schema};
use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

fn shift(file: &Path, out: &Path) -> Command {
    let mut command = ergopath();
    command.arg("shift").arg(file).arg("-o").arg(out);
    command
}

fn write(room: &TempDir, text: &str) -> PathBuf {
    let file = room.path().join("day.toml");
    std::fs::write(&file, text).unwrap();
    file
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Two runs of the same people with the goal at two heights, the first with its sampled postures, and one run of
/// others; planned once for all tests.
static RUNS: LazyLock<TempDir> = LazyLock::new(|| {
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let lower = room.path().join("lower.toml");
    let changed = text
        .replace("[0.45, 0.25, 1.25]", "[0.45, 0.25, 1.10]")
        .replace("cycles_per_min = 5", "cycles_per_min = 3");
    std::fs::write(&lower, changed).unwrap();
    plan(&room, &scenario, "high").arg("--rollouts").assert().success();
    plan(&room, &lower, "low").assert().success();
    plan(&room, &scenario, "others").args(["--seed", "5"]).assert().success();
    room
});

/// Their results in a folder of one's own.
fn runs() -> TempDir {
    let room = tempfile::tempdir().unwrap();
    for name in ["high", "low", "others"] {
        let (from, to) = (RUNS.path().join(name), room.path().join(name));
        std::fs::create_dir(&to).unwrap();
        std::fs::copy(from.join("result.json"), to.join("result.json")).unwrap();
    }
    room
}

const HEAD: &str = "schema = \"ergopath/shift/1\"\n[shift]\nname = \"Day\"\nminutes = 480\n";
const LUNCH: &str = "[[break]]\nname = \"lunch\"\nminutes = 30\n";

fn task(name: &str, result: &str, rest: &str) -> String {
    format!("[[task]]\nname = \"{name}\"\nresult = \"{result}\"\n{rest}\n")
}

/// The scores of each repetition of the best path: time at a level or above.
fn by_rollout(room: &TempDir, run: &str, method: &str, level: usize) -> Vec<f64> {
    let result = json(&room.path().join(run).join("result.json"));
    let all = result["candidates"].as_array().unwrap();
    let best = all.iter().find(|c| c["id"] == result["verdict"]["best"]).unwrap();
    let level = best["bodies"][0][method]["levels"]
        .as_array()
        .unwrap()
        .iter()
        .find(|l| l["level"] == level)
        .unwrap();
    level["by_rollout"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn near(a: &Value, b: f64) {
    let a = a.as_f64().unwrap();
    assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
}

#[test]
fn minutes_add_up_over_the_same_people() {
    let room = runs();
    // 450 min of work: 180 min with 5 cycles of 4 s a minute, 900 cycles of 4 s in 90 min, and other work.
    let text = format!(
        "{HEAD}{LUNCH}{}{}",
        task("above", "high", "share = 0.4"),
        task("below", "low", "minutes = 90\ncycles = 900")
    );
    let file = write(&room, &text);
    let out = room.path().join("out");
    let shown = shift(&file, &out).assert().success().get_output().stdout.clone();
    let shown = String::from_utf8(shown).unwrap();
    assert!(shown.starts_with("RULA action level 3 or above for"), "{shown}");
    assert!(
        shown.contains("demonstration model, not your workers") && shown.contains("no fatigue")
    );
    let result = json(&out.join("shift.json"));
    let time = &result["time"];
    for (key, minutes) in [
        ("shift_min", 480.0),
        ("breaks_min", 30.0),
        ("scored_min", 60.0 + 60.0),
        ("between_min", 120.0 + 30.0),
        ("other_min", 180.0),
    ] {
        near(&time[key], minutes);
    }
    let body = &result["bodies"][0];
    assert_eq!(body["units"]["over"], "repetitions");
    assert!(result["apart"].as_array().unwrap().is_empty());
    for method in ["rula", "reba"] {
        let (high, low) =
            (by_rollout(&room, "high", method, 3), by_rollout(&room, "low", method, 3));
        assert_eq!(high.len(), low.len());
        let sums: Vec<f64> = high.iter().zip(&low).map(|(a, b)| 60.0 * a + 60.0 * b).collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        near(&body[method]["high"]["mean_min"], mean);
        // The ends of the band are those of the sums, repetition by repetition.
        let mut sorted = sums.clone();
        sorted.sort_by(f64::total_cmp);
        let at = 0.95 * (sorted.len() - 1) as f64;
        let (k, part) = (at.floor() as usize, at.fract());
        let p95 = sorted[k] + part * (sorted[(k + 1).min(sorted.len() - 1)] - sorted[k]);
        near(&body[method]["high"]["band90_min"][1], p95);
        let levels = body[method]["levels"].as_array().unwrap();
        near(
            &Value::from(levels.iter().map(|l| l["at_min"].as_f64().unwrap()).sum::<f64>()),
            120.0,
        );
        // Tasks give all of it.
        let parts = body[method]["tasks"].as_array().unwrap();
        let given: f64 = parts.iter().map(|t| t["high"]["mean_min"].as_f64().unwrap()).sum();
        near(&Value::from(given), mean);
    }
    // Twice the same bytes; printed as written; the table holds the same minutes.
    let before = files(&out);
    let printed = shift(&file, &out).arg("--json").assert().success().get_output().stdout.clone();
    assert_eq!(files(&out), before);
    assert_eq!(serde_json::from_slice::<Value>(&printed).unwrap(), result);
    let mut rows = csv::Reader::from_path(out.join("shift.csv")).unwrap();
    let headers = rows.headers().unwrap().clone();
    let [method, part, level, above] = ["method", "part", "level", "at_or_above_min"]
        .map(|name| headers.iter().position(|c| c == name).unwrap());
    let found: Vec<String> = rows
        .records()
        .map(Result::unwrap)
        .filter(|r| &r[method] == "rula" && &r[part] == "shift" && &r[level] == "3")
        .map(|r| r[above].to_owned())
        .collect();
    near(&body["rula"]["high"]["mean_min"], found[0].parse().unwrap());
    let page = std::fs::read_to_string(out.join("shift.html")).unwrap();
    for words in ["one hand lifts", "not scored", "Caution", "no fatigue"] {
        assert!(page.contains(words), "{words}");
    }
    // `check` explains both files.
    let mut check = ergopath();
    check.arg("check").arg(&file);
    check.assert().success().stdout(contains("a shift of 2 tasks"));
    let mut check = ergopath();
    check.arg("check").arg(out.join("shift.json"));
    check.assert().success().stdout(contains("written by `ergopath shift`"));
}

#[test]
fn other_people_are_combined_as_independent_and_what_does_not_fit_is_said() {
    let room = runs();
    let text = format!(
        "{HEAD}{}{}",
        task("above", "high", "cycles = 900\nomni_res = 4\nexertions = 1.5"),
        task(
            "others",
            "others/result.json",
            "path = \"straight\"\nminutes = 120\ncycles = 300\nomni_res = [2, 3]"
        )
    );
    let file = write(&room, &text);
    let out = room.path().join("out");
    shift(&file, &out).assert().success().stdout(contains("seeds 1 and 5"));
    let result = json(&out.join("shift.json"));
    assert_eq!(result["bodies"][0]["units"]["over"], "independent");
    assert_eq!(result["tasks"][1]["path"], "straight");
    // 900 cycles of 4 s fill an hour of their own.
    near(&result["tasks"][0]["minutes"], 60.0);
    let notes = result["notes"].as_array().unwrap();
    let has =
        |kind: &str, task: usize| notes.iter().any(|n| n["note"] == kind && n["task"] == task);
    // 300 cycles in 120 min are not the 5 a minute of the scenario.
    assert!(has("repeated_less", 1) && !has("repeated_more", 0), "{notes:?}");
    // DUET by hand: 1350 exertions of rating 4 and 300 of 2 to 3, exertions to failure of table 1.
    let hand = &result["exertion"]["hands"][0];
    assert_eq!(hand["side"], "right");
    for (end, second) in [(0, 729_651.0), (1, 242_301.0)] {
        let damage = 1350.0 / 79_223.0 + 300.0 / second;
        let ours = hand["damage"][end].as_f64().unwrap();
        assert!((ours - damage).abs() < 1e-4 * damage, "{ours} {damage}");
        let y: f64 = 0.573 + 0.747 * damage.log10();
        let p = hand["probability"][end].as_f64().unwrap();
        assert!((p - 1.0 / (1.0 + (-y).exp())).abs() < 1e-4, "{p}");
    }
    // Below the scenario's 5 a minute nothing is added; above the 3 of the other a point is missing.
    let text = format!("{HEAD}{}", task("quick", "low", "minutes = 60\ncycles = 600"));
    shift(&write(&room, &text), &out).assert().success().stdout(contains("which is missing here"));
    // Sampled postures of a plan, scored: their spread counts, but nobody knows whose they are.
    let mut score = ergopath();
    score.arg("score").arg(RUNS.path().join("high/rollouts/1.csv"));
    score.arg("--scenario").arg(RUNS.path().join("bench.toml"));
    score.arg("-o").arg(room.path().join("scored"));
    score.assert().success();
    let text = format!(
        "{HEAD}{}{}",
        task("planned", "high", "cycles = 450"),
        task("scored", "scored", "cycles = 450\nside = \"right\"")
    );
    let open = write(&room, &text.replace("side = \"right\"", ""));
    assert_refused(&mut shift(&open, &out), "both sides of this motion were scored");
    let file = write(&room, &text);
    shift(&file, &out).assert().success().stdout(contains("do not say whose they are"));
    let both = json(&out.join("shift.json"));
    let tasks = both["bodies"][0]["rula"]["tasks"].as_array().unwrap();
    near(&tasks[1]["high"]["mean_min"], tasks[0]["high"]["mean_min"].as_f64().unwrap());
}

#[test]
fn a_motion_that_was_measured_once_has_no_spread() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("motion.csv");
    std::fs::write(&file, crate::score_cli::motion(600, 20.0, 6.0)).unwrap();
    let mut score = ergopath();
    score.arg("score").arg(&file).args(["--body", "female_p50", "--load-kg", "6"]);
    score.arg("-o").arg(room.path().join("scored")).assert().success();
    let summary = json(&room.path().join("scored/summary.json"));
    let levels = summary["sides"][0]["over_time"]["reba"]["levels"].as_array().unwrap().clone();
    // 30 s each: 120 of them are an hour.
    let text = format!("{HEAD}{}", task("seen", "scored", "cycles = 120"));
    let out = room.path().join("out");
    let day = write(&room, &text);
    shift(&day, &out).assert().success().stdout(contains("nothing is known of its spread"));
    let body = json(&out.join("shift.json"))["bodies"][0].clone();
    assert_eq!(body["units"]["over"], "nothing");
    for (own, theirs) in body["reba"]["levels"].as_array().unwrap().iter().zip(&levels) {
        let share = theirs["share"].as_f64().unwrap();
        assert!((own["at_min"].as_f64().unwrap() - 60.0 * share).abs() < 0.2, "{own} {theirs}");
        assert!(own["at_least"]["band90_min"].is_null());
    }
    let wrong = format!("{HEAD}{}", task("seen", "scored", "cycles = 120\nside = \"left\""));
    assert_refused(&mut shift(&write(&room, &wrong), &out), "the left side was not scored");
    let wrong = format!("{HEAD}{}", task("seen", "scored", "cycles = 9\npath = \"straight\""));
    assert_refused(&mut shift(&write(&room, &wrong), &out), "a scored motion has no paths");
}

#[test]
fn what_contradicts_itself_is_refused_and_nothing_is_written() {
    let room = runs();
    let out = room.path().join("out");
    let one = |rest: &str| format!("{HEAD}{}", task("above", "high", rest));
    let two = |a: &str, b: &str| {
        format!("{HEAD}{LUNCH}{}{}", task("above", "high", a), task("below", "low", b))
    };
    let mut old = json(&room.path().join("low/result.json"));
    for c in old["candidates"].as_array_mut().unwrap() {
        for b in c["bodies"].as_array_mut().unwrap() {
            for l in b["reba"]["levels"].as_array_mut().unwrap() {
                l.as_object_mut().unwrap().remove("by_rollout");
            }
        }
    }
    let place = room.path().join("old");
    std::fs::create_dir(&place).unwrap();
    std::fs::write(place.join("result.json"), unsealed(&old)).unwrap();
    let cases = [
        (
            two("share = 0.6", "share = 0.6"),
            "the tasks up to `below` take 540.0 min; the shift has 450.0 min",
        ),
        (one("share = 35"), "`share` is 35, above 1"),
        (one("share = -0.1"), "`share` is -0.1, not a number above 0"),
        (one("cycles = nan"), "`cycles` is NaN, not a number above 0"),
        (one("share = 0.2\nminutes = 40"), "both `share` and `minutes`"),
        (one(""), "`above` has no time"),
        (
            one("minutes = 10\ncycles = 1000"),
            "1000 cycles of 4.00 s take 66.7 min, but `above` has 10.0 min",
        ),
        (one("cycles = 10000"), "the shift has 480.0 min"),
        (one("minutes = 60\nexertions = 2"), "`exertions` without `omni_res`"),
        (one("minutes = 60\nomni_res = 11"), "`omni_res` is 11 to 11"),
        (one("minutes = 60\nomni_res = [5, 3]"), "`omni_res` is 5 to 3"),
        (one("minutes = 60\npath = \"strait\""), "the run has no scored path `strait`"),
        (one("minutes = 60\nside = \"left\""), "`side` is for scored motions"),
        (one("minutes = 60\nexcluded = [\"unstable\"]"), "unknown variant `unstable`"),
        (one("minuts = 60"), "unknown field `minuts`"),
        (
            two("share = 0.1", "share = 0.1").replace("below", "above"),
            "there are two tasks named `above`",
        ),
        (
            two("share = 0.1", "share = 0.1").replace("minutes = 30", "minutes = 480"),
            "leave nothing of a shift of 480 min",
        ),
        (one("share = 0.1").replace("480", "28800"), "longer than a day"),
        (one("share = 0.1").replace("shift/1", "shift/2"), "schema is not `ergopath/shift/1`"),
        (format!("{HEAD}{}", task("a", "nowhere", "share = 0.1")), "no such file"),
        (
            format!("{HEAD}{}", task("a", "old", "share = 0.1")),
            "does not hold the time at each action level",
        ),
        (HEAD.to_owned(), "missing field `task`"),
        (format!("task = []\n{HEAD}"), "a shift needs at least one [[task]]"),
    ];
    for (text, words) in cases {
        let file = write(&room, &text);
        assert_refused(&mut shift(&file, &out), words);
        assert!(!out.exists(), "{words}");
    }
    // The same file is refused by `check`.
    let file = write(&room, &one("share = 35"));
    let mut check = ergopath();
    assert_refused(check.arg("check").arg(&file), "above 1");
    // A run without a feasible path has nothing to add.
    let mut edited = json(&room.path().join("low/result.json"));
    edited["verdict"]["outcome"] = "nothing_feasible".into();
    std::fs::write(place.join("result.json"), unsealed(&edited)).unwrap();
    let file = write(&room, &format!("{HEAD}{}", task("a", "old", "share = 0.1")));
    assert_refused(&mut shift(&file, &out), "`old` has no best path");
    // Another body is another worker.
    let mut edited = json(&room.path().join("low/result.json"));
    for c in edited["candidates"].as_array_mut().unwrap() {
        for b in c["bodies"].as_array_mut().unwrap() {
            b["body"] = "male_p95".into();
        }
    }
    edited["setting"]["bodies"][0]["name"] = "male_p95".into();
    edited["verdict"]["body"] = "male_p95".into();
    for c in edited["comparisons"].as_array_mut().unwrap() {
        c["body"] = "male_p95".into();
    }
    std::fs::write(place.join("result.json"), unsealed(&edited)).unwrap();
    let text =
        format!("{HEAD}{}{}", task("a", "old", "share = 0.1"), task("b", "high", "share = 0.1"));
    assert_refused(&mut shift(&write(&room, &text), &out), "no body is in all tasks");
}

/// Two hands lift all of the crate: the composite index of one task in two parts is that of the task at the sum of
/// both rates, by table 5 of the manual.
#[test]
fn lifts_that_alternate_have_a_composite_index_and_others_are_refused() {
    let (room, _) = workplace();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("scenarios/low_bin.toml")).unwrap();
    let scenario = room.path().join("bin.toml");
    let text = text
        .replace("human_load_share = 0.4", "human_load_share = 1.0")
        .replace("bodies = [\"female_p50\", \"male_p50\"]", "bodies = [\"male_p50\"]");
    std::fs::write(&scenario, text).unwrap();
    plan(&room, &scenario, "lift").assert().success();
    let run = json(&room.path().join("lift/result.json"));
    let lead = run["verdict"]["lead"].clone();
    let all = run["candidates"].as_array().unwrap();
    let best = all.iter().find(|c| c["id"] == lead).unwrap();
    let lift = &best["bodies"][0]["strain"]["niosh"];
    // The limit without frequency, from the multipliers of the run.
    let free = ["origin", "destination"]
        .map(|end| {
            let m = &lift[end]["multipliers"];
            let of = |key: &str| m[key].as_f64().unwrap();
            23.0 * of("horizontal")
                * of("vertical")
                * of("distance")
                * of("asymmetry")
                * of("coupling")
        })
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let load = run["setting"]["task"]["load_kg"].as_f64().unwrap();
    assert!(free > 0.0 && load > 0.0, "{lift}");
    let head = |order: &str| format!("{}{order}\n", HEAD.replace("480", "400"));
    // 400 and 800 in 400 min: 1 and 2 lifts a minute, 3 in all; up to 8 h table 5 says 0.75, 0.65 and 0.55.
    let tasks = format!(
        "{}{}",
        task("first", "lift", "cycles = 400\nminutes = 200"),
        task("second", "lift", "cycles = 800\nminutes = 200")
    );
    let out = room.path().join("out");
    let mixed = write(&room, &format!("{}{tasks}", head("order = \"mixed\"")));
    shift(&mixed, &out).assert().success().stdout(contains("Composite lifting index"));
    let found = json(&out.join("shift.json"))["lifting"].clone();
    near(&found["composite"]["index"], load / free / 0.55);
    near(&found["tasks"][0]["index"], load / free / 0.75);
    near(&found["tasks"][1]["index"], load / free / 0.65);
    assert_eq!(found["composite"]["steps"][0]["task"], 1);
    assert_eq!(found["duration"], "long");
    for (order, words) in [("order = \"blocks\"", "in blocks"), ("", "say `order = \"mixed\"`")] {
        let file = write(&room, &format!("{}{tasks}", head(order)));
        shift(&file, &out).assert().success().stdout(contains(words));
        let found = json(&out.join("shift.json"))["lifting"].clone();
        assert!(found["composite"].is_null(), "{found}");
        // Each block by its own rate: 2 and 4 lifts a minute.
        near(&found["tasks"][0]["index"], load / free / 0.65);
        near(&found["tasks"][1]["index"], load / free / 0.45);
    }
    // What the manual excludes has no number.
    let excluded = task("first", "lift", "cycles = 400\nexcluded = [\"unstable_load\"]");
    let file = write(&room, &format!("{}{excluded}", head("order = \"mixed\"")));
    let words = "`first`: the lifting equation does not apply because the load is unstable";
    shift(&file, &out).assert().success().stdout(contains(words));
    let found = json(&out.join("shift.json"))["lifting"].clone();
    assert!(found["composite"].is_null() && found["tasks"][0]["index"].is_null(), "{found}");
    // More than 8 h of work have no limits.
    let file = write(&room, &format!("{}{tasks}", head("").replace("400\n", "500\n")));
    shift(&file, &out).assert().success().stdout(contains("above 8 h"));
}

#[test]
fn the_shipped_shift_is_valid_and_a_misspelt_one_is_not() {
    let validator = schema("shift");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/shift/day.toml");
    let value = as_json(&file);
    let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
    assert!(errors.is_empty(), "{errors:?}");
    for (table, key, wrong) in [
        ("shift", "colour", Value::from("red")),
        ("shift", "minutes", "eight hours".into()),
        ("shift", "order", "any".into()),
    ] {
        let mut strange = value.clone();
        strange[table][key] = wrong;
        assert!(!validator.is_valid(&strange), "{table}.{key}");
    }
    let mut strange = value.clone();
    strange["task"][0]["omni_res"] = "hard".into();
    assert!(!validator.is_valid(&strange));
    let mut strange = value;
    strange["task"] = Value::Array(Vec::new());
    assert!(!validator.is_valid(&strange));
}

//! `ergopath experiment exp1`, `exp2` and `exp3` from outside: simulated people, and recorded ones.

use crate::common::{assert_refused, ergopath, people_file};
use serde_json::Value;

fn run(args: &[&str]) -> Value {
    let run = ergopath().arg("experiment").args(args).arg("--json").assert().code(0);
    serde_json::from_slice(&run.get_output().stdout).unwrap()
}

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap()
}

#[test]
fn simulated_people_repeat_the_papers_experiments() {
    let room = tempfile::tempdir().unwrap();
    let few = ["--operators", "2", "--methods", "plain-ik,full-w,gp"];
    for (experiment, chains) in [("exp1", 2), ("exp2", 2), ("exp3", 1)] {
        let folder = room.path().join(experiment);
        let bands = if experiment == "exp3" { "full-w" } else { "none" };
        let out = folder.to_str().unwrap();
        let args = [&[experiment], &few[..], &["--bands", bands, "-o", out]].concat();
        let found = run(&args);
        assert_eq!((&found["experiment"], &found["simulated"]), (&experiment.into(), &true.into()));
        assert_eq!(found["chains"].as_array().unwrap().len(), chains, "{experiment}");
        for chain in found["chains"].as_array().unwrap() {
            assert_eq!(chain["sets"].as_array().unwrap().len(), 2);
            let taught = if experiment == "exp2" { 10 } else { 5 };
            assert_eq!(chain["sets"][0]["train"]["movements"], taught);
            assert_eq!(chain["sets"][0]["test"]["movements"], 5);
            let of = |m: usize| number(&chain["methods"][m]["relative_rmse_q"]["median"]);
            assert!(of(1) < of(0), "{experiment}: full-w {} plain {}", of(1), of(0));
            // A law that does not look at the hand loses it.
            let hand = |m: usize| number(&chain["horizon"][m]["points"][5]["hand_mm"]);
            assert!(hand(1) < 10.0 && hand(2) > 2.0 * hand(1), "{} {}", hand(1), hand(2));
        }
        let key = found["chains"][0]["chain"].as_str().unwrap();
        let mut pictures = vec!["methods", "coverage", "horizon", "weights"];
        pictures.extend((bands == "full-w").then_some("spread-full-w"));
        for picture in pictures {
            let png = std::fs::read(folder.join(format!("{key}/{picture}.png"))).unwrap();
            assert_eq!(&png[1..4], b"PNG", "{picture}");
        }
        let table = std::fs::read_to_string(folder.join(format!("{key}/scores.csv"))).unwrap();
        assert!(table.starts_with("# simulated people: nobody was recorded\n"));
        assert_eq!(table.lines().count(), 2 + 2 * 5 * 3, "{table}");
        let kept = std::fs::read(folder.join(format!("{experiment}.json"))).unwrap();
        assert_eq!(serde_json::from_slice::<Value>(&kept).unwrap(), found);
    }
}

#[test]
fn the_terminal_says_who_taught_and_that_nobody_was_recorded() {
    let args = ["exp3", "--operators", "2", "--methods", "mi-nsgp,full-w", "--bands", "none"];
    let said = ergopath().arg("experiment").args(args).assert().code(0);
    let said = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
    for part in [
        "nobody was recorded",
        "other bodies, seated",
        "24 joints",
        "mi-nsgp against full-w: relative RMSE smaller in",
        "W of mi-nsgp",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn recorded_people_repeat_the_papers_experiments() {
    let room = tempfile::tempdir().unwrap();
    let Some(file) = people_file(&["bk", "tr"], [4, 4], room.path()) else { return };
    let file = file.to_str().unwrap();
    let with = |experiment: &str| {
        let few = ["--methods", "plain-ik,full-w", "--bands", "none", "--chain", "arm"];
        run(&[&[experiment, "--recordings", file], &few[..]].concat())
    };
    for (experiment, taught) in [("exp1", (1, 2)), ("exp2", (1, 4)), ("exp3", (1, 4))] {
        let found = with(experiment);
        assert_eq!(found["simulated"], false);
        assert_eq!(found["taught_by_others"], experiment == "exp3");
        let [chain] = &found["chains"].as_array().unwrap()[..] else { panic!("{found}") };
        let sets = chain["sets"].as_array().unwrap();
        assert_eq!(sets.len(), 4, "two people, two tasks");
        let size = |key: &str| sets[0]["train"][key].as_u64().unwrap();
        assert_eq!((size("people"), size("movements")), taught, "{experiment}");
        let tested = if experiment == "exp3" { 4 } else { 2 };
        assert_eq!(sets[0]["test"]["movements"], tested);
        let of = |m: usize| number(&chain["methods"][m]["relative_rmse_q"]["median"]);
        assert!(of(1) < of(0), "{experiment}: full-w {} plain {}", of(1), of(0));
    }
}

#[test]
fn what_does_not_make_an_experiment_is_refused() {
    let refuse = |args: &[&str], said: &str| {
        assert_refused(ergopath().arg("experiment").args(args), said);
    };
    refuse(&["exp1", "--recordings", "nobody.toml"], "nobody.toml");
    refuse(&["exp1", "--methods", "ful-w"], "there is no method `ful-w`");
    refuse(&["exp3", "--operators", "1", "--chain", "whole"], "do not all hold both legs");
    let room = tempfile::tempdir().unwrap();
    let Some(file) = people_file(&["bk"], [2, 2], room.path()) else { return };
    let file = file.to_str().unwrap();
    refuse(&["exp1", "--recordings", file], "nobody repeated a task 4 times");
    refuse(&["exp3", "--recordings", file], "no two people did the same task");
}

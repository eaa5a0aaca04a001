//! Several people from outside: `ergopath train` and `validate` of a people file.

use crate::common::{assert_refused, ergopath, people_file};
use crate::skips::shared;
use ergopath::posture::load_model;
use serde_json::Value;
use std::path::Path;

#[test]
fn recorded_people_teach_a_whole_person_and_are_predicted() {
    let room = tempfile::tempdir().unwrap();
    let Some(file) = people_file(&["bk", "mm", "tr"], [2, 1], room.path()) else { return };
    let run = ergopath().arg("validate").arg(&file).arg("--json").assert().code(0);
    let found: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(said.contains("the pelvis is told from the feet"), "{said}");
    assert_eq!(found["persons"].as_array().unwrap().len(), 3);
    let median = |of: &Value| of["posture_error_deg"]["median"].as_f64().unwrap();
    let baseline = |name: &str| {
        let all = found["baselines"].as_array().unwrap();
        median(all.iter().find(|b| b["name"] == name).unwrap())
    };
    assert!(median(&found) < 20.0);
    for name in ["plain-ik", "mean-posture", "nearest-neighbour"] {
        assert!(median(&found) < baseline(name), "{name}");
    }
    let [pooled, worst] = ["pooled", "worst"].map(|k| found["coverage90"][k].as_f64().unwrap());
    assert!((0.5..1.0).contains(&pooled) && worst < pooled, "{pooled} {worst}");
    // Scores of the real movement against those from the path of the hand alone.
    for method in ["rula", "reba"] {
        let own = &found[method];
        for key in ["mae", "rank_correlation", "inside90", "inside50", "bias"] {
            assert!(own[key].as_f64().is_some_and(f64::is_finite), "{method} {key}: {own}");
        }
        assert_eq!(own["movements"], 9);
        for baseline in found["baselines"].as_array().unwrap() {
            assert!(baseline[method]["mae"].as_f64().unwrap() > 0.0, "{baseline}");
        }
        let risk = &found["persons"][0]["movements"][0]["risk"][method];
        let [low, high] = [0, 1].map(|i| risk["band_90"][i].as_f64().unwrap());
        let predicted = risk["predicted"].as_f64().unwrap();
        assert!(low < predicted && predicted < high, "{risk}");
        assert!((1.0..=15.0).contains(&risk["recorded"].as_f64().unwrap()), "{risk}");
    }
    let rula = |of: &Value| of["rula"]["mae"].as_f64().unwrap();
    let all = found["baselines"].as_array().unwrap();
    let still = all.iter().find(|b| b["name"] == "mean-posture").unwrap();
    assert!(rula(&found) < rula(still), "{} {}", rula(&found), rula(still));
    assert!(found["centres_cm"]["shoulder"].as_f64().unwrap() < 20.0);
    assert!(found["crps"]["trunk"].as_f64().unwrap() > 0.0);
    // The fitted body is near what was recorded, whatever is predicted of it.
    for movement in found["persons"][0]["movements"].as_array().unwrap() {
        let fit: Vec<f64> =
            movement["fit_rms"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        // Its knees bend as recorded, so that feet that stood apart cost some centimetres at the hips; but both can
        // be straight on a level pelvis only: 3 mm between the hips are ten degrees of a knee.
        assert!(fit[0] < 4.0 && fit[4] < 4.0, "{fit:?}");
        assert!(fit[1..4].iter().all(|f| *f < 15.0), "{fit:?}");
    }

    let Some(file) = people_file(&["bk", "tr"], [2, 1], room.path()) else { return };
    let check = ergopath().arg("check").arg(&file).assert().code(0);
    let said = String::from_utf8_lossy(&check.get_output().stdout).into_owned();
    assert!(said.contains("2 recorded people") && said.contains("`tr`: 3 recordings"), "{said}");
    let model = room.path().join("two.json");
    ergopath()
        .arg("train")
        .arg(&file)
        .args(["--body", "male_p50", "-o"])
        .arg(&model)
        .assert()
        .code(0);
    let (model, _) = load_model(model.to_str().unwrap(), Path::new(".")).unwrap();
    assert_eq!((model.joints.len(), model.joints[1].as_str()), (30, "pelvis_up"));
    assert!(model.postures.about_usual.is_some() && !model.provenance.simulated);
    assert!(model.provenance.notes.iter().any(|n| n.contains("whole people held out, 2 in all")));
    assert_eq!(model.provenance.recordings.len(), 6);
}

#[test]
fn a_model_that_is_there_is_judged_on_one_person() {
    let room = tempfile::tempdir().unwrap();
    let Some(file) = people_file(&["bk"], [2, 1], room.path()) else { return };
    let judged = |model: &str| {
        let folder = room.path().join(model);
        let run = ergopath()
            .arg("validate")
            .arg(&file)
            .args(["--model", model, "--json", "-o"])
            .arg(&folder)
            .assert();
        let output = run.code(0).get_output().clone();
        let found: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(found["persons"][0]["movements"].as_array().unwrap().len(), 3);
        // What needs the movements that a model was learned from is not there.
        let baselines = found["baselines"].as_array().unwrap();
        assert!(baselines.iter().all(|b| b["name"] != "nearest-neighbour"), "{baselines:?}");
        assert!(baselines.iter().any(|b| b["name"] == "plain-ik"));
        let energy_deg = found["energy_score_deg"].as_f64().unwrap();
        assert_eq!(found["recordings"], 3);
        // The folder holds the same figures, a page and its pictures.
        let kept = std::fs::read(folder.join("validation.json")).unwrap();
        assert_eq!(serde_json::from_slice::<Value>(&kept).unwrap(), found);
        let page = std::fs::read_to_string(folder.join("validation.html")).unwrap();
        assert!(page.contains("Are the scores of a plan those of the person who does the work?"));
        assert_eq!(page.contains("was learned from 3 of these 3"), model == "people");
        for picture in ["scores", "coverage", "movement"] {
            let png = std::fs::read(folder.join(format!("figures/{picture}.png"))).unwrap();
            assert_eq!(&png[1..4], b"PNG", "{picture}");
        }
        assert_eq!(found["learned_recordings"], if model == "people" { 3 } else { 0 });
        (energy_deg, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (own, warned) = judged("people");
    assert!(warned.contains("was learned from 3 of these 3 recordings"), "{warned}");
    let (simulated, unwarned) = judged("whole_operator");
    assert!(!unwarned.contains("was learned from"), "{unwarned}");
    assert!(own < simulated, "{own} {simulated}");
    let refuse = |args: &[&str], said: &str| {
        assert_refused(ergopath().arg("validate").arg(&file).args(args), said);
    };
    refuse(&["--model", "demo_operator"], "learned over a pelvis that rests");
    refuse(&["--model", "peopel"], "there is no shipped posture model `peopel`");
}

#[test]
fn what_is_no_group_of_people_is_refused() {
    let room = tempfile::tempdir().unwrap();
    let Some(file) = people_file(&["bk"], [2, 1], room.path()) else { return };
    let one = file.to_str().unwrap();
    let out = room.path().join("m.json");
    let out = out.to_str().unwrap();
    let train = ["train", one, "--body", "male_p50", "-o", out];
    let refused = |words: &[&str], said: &str| assert_refused(ergopath().args(words), said);
    refused(&["validate", one], "only one person");
    refused(&[&train[..], &["--pelvis", "rests"]].concat(), "learned as a whole");
    refused(&[&["train", "x.mvnx"][..], &train[1..]].concat(), "names several people");
    refused(&["validate", "no_such.toml"], "no_such.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let own = text
        .split_once("[[person]]")
        .unwrap()
        .1
        .replace("bk", "again")
        .replace("HDM_again", "HDM_bk");
    std::fs::write(&file, format!("{text}[[person]]{own}")).unwrap();
    refused(&["validate", one], "is given twice");
    assert!(!room.path().join("m.json").exists());
}

#[test]
fn a_model_of_people_becomes_that_of_one_worker() {
    let room = tempfile::tempdir().unwrap();
    let adapt = |model: &str| {
        let mut command = ergopath();
        command.current_dir(room.path()).args(["adapt", model]);
        command
    };
    let Some(recordings) = shared("recordings/hdm05") else { return };
    let clip = recordings.join("HDM_bk_depositFloorR_007_120.amc");
    let run = adapt("people").arg(&clip).args(["-o", "anna.json"]).assert().code(0);
    let told = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
    assert!(told.contains("`people` adapted to one worker by 1 movement"), "{told}");
    let (people, _) = load_model("people", Path::new(".")).unwrap();
    let (anna, _) = load_model("anna.json", room.path()).unwrap();
    assert!(people.postures.population.is_some() && anna.postures.population.is_none());
    assert!(anna.provenance.adapted_s.is_some_and(|s| s > 1.0));
    assert_eq!(anna.provenance.recordings.len(), people.provenance.recordings.len() + 1);
    // Neither a model of one person, nor one of the other hand, nor what is not there.
    assert_refused(
        adapt("demo_operator").arg(&clip).args(["-o", "b.json"]),
        "is not a model of several people",
    );
    assert_refused(
        adapt("people").arg(&clip).args(["--side", "left", "-o", "b.json"]),
        "leads with the right hand",
    );
    assert_refused(adapt("nobody").arg(&clip).args(["-o", "b.json"]), "nobody");
    assert!(!room.path().join("b.json").exists());
}

//! Tests of the whole set of files, on a small run made once.

use super::*;
use crate::ergonomics::{PairedDifference, PerMethod, ScoringMethod};
use crate::planner::{Gain, GainParts, Request, load_preset, plan};
use crate::scenario::read_scenario;
use crate::words::number;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

const SCENARIO: &str = r#"
schema = "ergopath/scenario/1"
name = "A <b>&"
[worker]
bodies = ["female_p50", "male_p50"]
posture_model = "demo_operator"
side = "right"
stance = "standing"
at_m = [0.0, 0.0]
facing_deg = 0
[grip]
rpy_deg = [180, 0, -90]
hold = "rigid"
[robot]
preset = "panda"
base = { position_m = [0.95, 0.0, 0.75], rpy_deg = [0, 0, 180] }
[start]
position_m = [0.42, -0.35, 0.95]
rpy_deg = [180, 0, 0]
[goal]
position_m = [0.45, 0.25, 1.25]
rpy_deg = [180, 0, 0]
[motion]
duration_s = 4.0
[workspace]
min_m = [0.25, -0.60, 0.80]
max_m = [0.80, 0.60, 1.60]
[limits]
speed_m_s = SPEED
[[obstacle]]
name = "bench"
shape = "box"
position_m = [0.75, 0.0, 0.36]
size_m = [0.8, 1.6, 0.72]
[task]
part_mass_kg = 1.5
human_load_share = 0.3
coupling = "good"
"#;

/// The scenario as a file, with all that it needs beside it.
pub(super) fn scenario_file(speed: &str, with_own_path: bool) -> (TempDir, PathBuf) {
    let room = tempfile::tempdir().unwrap();
    let mut text = SCENARIO.replace("SPEED", speed);
    if with_own_path {
        text += "[[path]]\nname = \"today\"\nfile = \"today.csv\"\n";
        let mut rows = String::from("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n");
        for i in 0..=80 {
            let u = f64::from(i) / 80.0;
            let s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            let (x, y, z) = (0.42 + 0.03 * s, -0.35 + 0.6 * s, 0.95 + 0.3 * s);
            writeln!(rows, "{},{x:.6},{y:.6},{z:.6},0,1,0,0", 4.0 * u).unwrap();
        }
        std::fs::write(room.path().join("today.csv"), rows).unwrap();
    }
    let file = room.path().join("scenario.toml");
    std::fs::write(&file, text).unwrap();
    (room, file)
}

fn run(speed: &str, with_own_path: bool) -> RunResult {
    let (_room, file) = scenario_file(speed, with_own_path);
    let mut preset = load_preset("quick").unwrap();
    (preset.population, preset.generations, preset.steps) = (5, 2, 40);
    (preset.rollouts_first, preset.rollouts_most, preset.rollouts_final) = (2, 3, 12);
    (preset.shortlist, preset.reported, preset.baseline_generations) = (3, 2, 1);
    let request = Request {
        command: "ergopath plan scenario.toml".into(),
        seed: 1,
        preset,
        keeps_rollouts: false,
        resume: None,
    };
    plan(&read_scenario(&file).unwrap(), &request, &|_| true).unwrap()
}

pub(super) fn feasible() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| run("0.5", true))
}

fn impossible() -> &'static RunResult {
    static RUN: OnceLock<RunResult> = OnceLock::new();
    RUN.get_or_init(|| run("0.05", false))
}

type Files = Vec<(String, Vec<u8>)>;

fn made() -> &'static Files {
    static FILES: OnceLock<Files> = OnceLock::new();
    FILES.get_or_init(|| files(feasible()).unwrap())
}

fn text(files: &Files, name: &str) -> String {
    let (_, bytes) = files.iter().find(|(n, _)| n == name).unwrap();
    String::from_utf8(bytes.clone()).unwrap()
}

/// What is left for a reader whose browser runs no scripts.
fn without_scripts(page: &str) -> String {
    let mut parts = page.split("<script");
    let first = parts.next().unwrap().to_owned();
    parts.fold(first, |text, part| text + part.split_once("</script>").unwrap().1)
}

fn assert_self_contained(page: &str) {
    for start in ["src=\"", "href=\""] {
        for rest in page.split(start).skip(1) {
            assert!(
                rest.starts_with('#') || rest.starts_with("data:image/png;base64,"),
                "{start}{}",
                &rest[..40]
            );
        }
    }
    for word in ["<link", "@import", "url(", "<iframe", "<object", " onclick="] {
        assert!(!without_scripts(page).contains(word), "{word}");
    }
    // Scripts stand in the page, and the page's own ones ask nobody for anything. What the library
    // does is watched in a browser, by `tests/browser`.
    for script in page.split("<script").skip(1) {
        assert!(!script.split('>').next().unwrap().contains("src"));
        let text = script.split("</script>").next().unwrap();
        for word in ["fetch(", "XMLHttpRequest", "import ", "WebSocket", "http:", "https:"] {
            assert!(!text.contains(word), "{word}");
        }
    }
    for word in ["<html lang=\"en\">", "<title>", "href=\"#main\"", "id=\"main\""] {
        assert!(page.contains(word), "{word}");
    }
    assert_eq!(page.matches("<img").count(), page.matches(" alt=\"").count());
    assert!(
        page.split("<th").skip(1).filter(|t| !t.starts_with("ead")).all(|t| t
            .split('>')
            .next()
            .unwrap()
            .contains("scope="))
    );
}

#[test]
fn the_page_needs_nothing_else() {
    let page = text(made(), "report.html");
    assert_self_contained(&page);
    let figures = made().iter().filter(|(name, _)| name.starts_with("figures/")).count();
    assert_eq!(page.matches("<img").count(), figures);
    for words in ["McAtamney &amp; Corlett 1993", "Hignett &amp; McAtamney 2000"] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn names_are_escaped_and_the_caveat_is_in_the_verdict() {
    let page = text(made(), "report.html");
    assert!(page.contains("A &lt;b&gt;&amp;") && !page.contains("<b>"));
    assert!(page.len() < 8_000_000 && without_scripts(&page).contains("The scene needs scripts"));
    let verdict = page.split("<section").nth(1).unwrap();
    assert!(verdict.contains("demonstration model, not your workers"));
}

/// Every figure is a PNG of the stated width with more than paper on it.
fn assert_figures(files: &Files, count: usize) {
    let figures: Vec<_> = files.iter().filter(|(n, _)| n.starts_with("figures/")).collect();
    assert_eq!(figures.len(), count);
    for (name, bytes) in figures {
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let width = if name == "figures/still.png" { 1000 } else { 1600 };
        assert_eq!(info.width, width, "{name}");
        assert!(info.height >= 200, "{name}");
        let inked = pixels.chunks(3).filter(|p| *p != [255, 255, 255]).count();
        assert!(inked > 1500, "{name}: {inked}");
    }
}

/// The robot's last point and the person's hand stay with the path; the page has what the result has.
#[test]
fn the_scene_follows_the_path() {
    let result = feasible();
    assert_eq!(
        result.scene.motions.len(),
        result.candidates.iter().filter(|c| c.rank.is_some()).count()
    );
    for motion in &result.scene.motions {
        let candidate = result.candidates.iter().find(|c| c.id == motion.candidate).unwrap();
        let path = candidate.path.as_ref().unwrap();
        let robot = motion.robot.as_ref().unwrap();
        let robot_points = robot.track.points_mm(motion.samples.len());
        for person in &motion.people {
            let typical = person.typical.as_ref().unwrap();
            assert_eq!(person.ghosts.len(), 8);
            let points = typical.track.points_mm(typical.rula.len());
            for (k, &sample) in motion.samples.iter().enumerate() {
                let tcp: Vec<f64> = path.tcp[sample][..3].iter().map(|v| 1e3 * v).collect();
                let nearest = |points: &[[i64; 3]], ends: [usize; 2], radius: u32| {
                    let [a, b] = ends.map(|e| nalgebra::Vector3::from(points[e].map(|v| v as f64)));
                    let t = nalgebra::Vector3::from_column_slice(&tcp);
                    let s =
                        ((t - a).dot(&(b - a)) / (b - a).norm_squared().max(1.0)).clamp(0.0, 1.0);
                    (t - a.lerp(&b, s)).norm() - f64::from(radius)
                };
                let least = |points: &[[i64; 3]], capsules: &[crate::planner::SceneCapsule]| {
                    let far = capsules.iter().map(|c| nearest(points, c.ends, c.radii_mm[0]));
                    far.fold(f64::INFINITY, f64::min)
                };
                let (hand, tool) =
                    (least(&points[k], &person.capsules), least(&robot_points[k], &robot.capsules));
                assert!(
                    hand < 15.0 && tool < 60.0,
                    "{}: hand {hand} mm, tool {tool} mm",
                    motion.candidate
                );
            }
        }
    }
    let page = text(made(), "report.html");
    let data = page.split_once("id=\"scene-data\">").unwrap().1.split_once("</script>").unwrap().0;
    let data: Value = serde_json::from_str(data).unwrap();
    let whole: Value = serde_json::from_str(&text(made(), "result.json")).unwrap();
    for (shown, meant) in data["motions"]
        .as_array()
        .unwrap()
        .iter()
        .zip(whole["scene"]["motions"].as_array().unwrap())
    {
        assert_eq!(shown["people"], meant["people"]);
        assert_eq!(shown["robot"], meant["robot"]);
        let path = whole["candidates"]
            .as_array()
            .unwrap()
            .iter()
            .find(|c| c["id"] == meant["candidate"])
            .unwrap();
        for (k, sample) in meant["samples"].as_array().unwrap().iter().enumerate() {
            let sample = sample.as_u64().unwrap() as usize;
            assert_eq!(shown["time_s"][k], path["path"]["time_s"][sample]);
            for (of, b) in
                shown["scores"].as_array().unwrap().iter().zip(path["bodies"].as_array().unwrap())
            {
                assert_eq!(of["rula"]["mean"][k], b["rula"]["band"]["mean"][sample]);
                assert_eq!(of["reba"]["p95"][k], b["reba"]["band"]["p95"][sample]);
            }
        }
    }
}

/// The still shows the moment at which RULA is highest on average, with the score of the person shown.
#[test]
fn the_still_shows_the_hardest_moment() {
    let view = View::of(feasible());
    let (_, shown) = figure_still::still(&view).unwrap().unwrap();
    let lead = view.lead.unwrap();
    let motion = feasible().scene.motions.iter().find(|m| m.candidate == lead.id).unwrap();
    let mean = &view.scores(lead).unwrap().rula().distribution.band.mean;
    let time_s = &lead.path.as_ref().unwrap().time_s;
    let index = motion.samples.iter().position(|&k| time_s[k] == shown.time_s).unwrap();
    let there = mean[motion.samples[index]];
    assert!(motion.samples.iter().all(|&k| mean[k] <= there + 1e-9), "{there}");
    let people = motion.people.iter().find(|p| Some(p.body.as_str()) == view.body).unwrap();
    assert_eq!(shown.rula, people.typical.as_ref().unwrap().rula[index]);
    assert!((6..=8).contains(&shown.ghosts));
    assert!(figure_still::still(&View::of(impossible())).unwrap().is_none());
}

#[test]
fn the_first_screen_tells_before_and_after_once() {
    let page = text(made(), "report.html");
    let decision = page.split("class=\"decision\"").nth(1).unwrap();
    let decision = decision.split("class=\"keys\"").next().unwrap();
    let view = View::of(feasible());
    let own = view.own[0];
    let share = |c| crate::words::number::percent(view.scores(c).unwrap().rula().high_band[0]);
    let told = format!("{} \u{2192} {}", share(own), share(view.lead.unwrap()));
    assert!(decision.contains(&told), "{told}");
    assert_eq!(decision.matches("class=\"levelbar\"").count(), 2);
    let role = crate::words::verdict::role(feasible());
    let once = ["Settle first", "demonstration model", role, "who is worst off of the 2 bodies"];
    for words in once {
        assert_eq!(decision.matches(words).count(), 1, "{words}");
    }
    // What is to be settled first is not told again among what is to be minded.
    let settled = crate::words::decision::settle(feasible());
    let changed = settled.split("RULA").nth(1).unwrap().split(" instead").next().unwrap();
    let minded = page.split("To mind").nth(1).map_or("", |m| m.split("</ul>").next().unwrap());
    assert!(!minded.contains(changed.trim()), "{changed}: {minded}");
}

#[test]
fn the_lowest_path_is_the_best_only_where_it_is_lower_beyond_chance() {
    let mut result = feasible().clone();
    let gain = result.verdict.gain.clone().unwrap();
    let known = gain.scores[ScoringMethod::Rula].together;
    let mut role = |mean: f64, clear: bool| {
        let together = PairedDifference { mean, clear, ..known };
        let parts = GainParts { together, route: None, timing: None };
        let scores = PerMethod::of(|_| parts);
        result.verdict.gain = Some(Gain { scores, ..gain.clone() });
        crate::words::verdict::role(&result)
    };
    assert_eq!(role(0.2, true), "Best path");
    let lowest = "No path is clearly better than the straight one. Lowest";
    assert_eq!(role(0.2, false), lowest);
    assert_eq!(role(-0.2, true), lowest);
    // What the objective does not ask for does not make it the best.
    assert_eq!(result.planner.objective.weights(ScoringMethod::Reba).all(), [0.0; 4]);
    let gain = result.verdict.gain.as_mut().unwrap();
    gain.scores = PerMethod::of(|m| GainParts {
        together: PairedDifference { mean: 0.2, clear: m == ScoringMethod::Reba, ..known },
        route: None,
        timing: None,
    });
    assert_eq!(crate::words::verdict::role(&result), lowest);
}

#[test]
fn one_page_holds_the_decision_and_needs_nothing_else() {
    for result in [feasible(), impossible()] {
        let (name, bytes) = one_page(result, None).unwrap();
        assert_eq!(name, "one_page.html");
        let page = String::from_utf8(bytes).unwrap();
        assert!(!page.contains("<script") && page.contains("A &lt;b&gt;&amp;"));
        assert!(page.contains("Reviewed by") && page.contains("Not modelled: "));
        assert_eq!(page.matches("<img").count(), 1);
        assert!(page.contains(&result.provenance.inputs[0].1[..16]));
    }
}

#[test]
fn figures_are_drawn() {
    assert_figures(made(), 9);
}

#[test]
fn tables_have_their_columns() {
    let table = text(made(), "candidates.csv");
    assert_eq!(
        table.lines().next().unwrap(),
        "rank,id,name,family,state,evaluated,objective,body,expected_rula,se_expected_rula,p05_rula,p95_rula,\
         cvar90_rula,exposure_rula_5,rula_per_metre,peak_rula,expected_reba,se_expected_reba,p05_reba,p95_reba,\
         cvar90_reba,exposure_reba_8,reba_per_metre,peak_reba,reach_exceeded,hand_travel_m,hand_speed_max_m_s,\
         hand_acceleration_max_m_s2,not_best_because,reason"
    );
    assert_eq!(table.lines().count(), feasible().candidates.len() + 1);
    let path = text(made(), "paths/1.csv");
    let header = path.lines().next().unwrap();
    assert!(header.starts_with("time_s,x_m,y_m,z_m,qw,qx,qy,qz,panda_joint1_rad,"), "{header}");
    let best = feasible().candidates[0].path.as_ref().unwrap();
    let last: Vec<f64> =
        path.lines().last().unwrap().split(',').map(|v| v.parse().unwrap()).collect();
    assert_eq!(last[1..8], best.tcp.last().unwrap()[..]);
}

#[test]
fn the_same_result_gives_the_same_bytes() {
    assert_eq!(&files(feasible()).unwrap(), made());
}

#[test]
fn numbers_of_the_page_are_those_of_the_result() {
    let page = text(made(), "report.html");
    let result: Value = serde_json::from_str(&text(made(), "result.json")).unwrap();
    let table = page.split("aria-label=\"Paths compared\"").nth(1).unwrap();
    let mut seen = 0;
    for c in
        result["candidates"].as_array().unwrap().iter().filter(|c| c["evaluated"] == "reported")
    {
        let id = c["id"].as_str().unwrap();
        let row = table.split("<tr").find(|r| r.contains(&format!("<code>{id}</code>"))).unwrap();
        let bodies = c["bodies"].as_array().unwrap();
        let body = bodies.iter().find(|b| b["body"] == result["verdict"]["body"]).unwrap();
        for (score, value) in [
            ("rula", "expected"),
            ("rula", "p05"),
            ("rula", "p95"),
            ("rula", "cvar90"),
            ("rula", "per_metre"),
            ("rula", "peak"),
            ("reba", "expected"),
        ] {
            let shown = format!("{:.2}", body[score][value].as_f64().unwrap());
            assert!(row.contains(&shown), "{id} {score} {value} {shown}");
            seen += 1;
        }
        let shown = crate::words::number::percent(body["rula"]["high_band"][0].as_f64().unwrap());
        assert!(row.contains(&shown.replace('<', "&lt;").replace('>', "&gt;")), "{id} {shown}");
    }
    assert!(seen >= 15);
    for check in result["candidates"][0]["path"]["checks"].as_array().unwrap() {
        assert!(page.contains(&number::value(check["value"].as_f64().unwrap())), "{check}");
    }
    for input in result["provenance"]["inputs"].as_array().unwrap() {
        assert!(page.contains(input[1].as_str().unwrap()));
    }
}

#[test]
fn without_a_feasible_path_the_report_says_why() {
    let files = files(impossible()).unwrap();
    assert!(impossible().verdict.best.is_none());
    let page = text(&files, "report.html");
    assert_self_contained(&page);
    assert!(page.contains("No path keeps all limits") && page.contains("cannot be used"));
    assert_figures(&files, 1);
    // Nothing stands there to say that nothing stands there.
    assert!(!page.contains("No path was scored") && !page.contains("id=\"scene\""));
    // The cell is drawn with the worker and the robot in it.
    assert_eq!(impossible().ends.len(), 2);
    assert!(impossible().ends.iter().all(|p| !p.bones.is_empty() && !p.robot.is_empty()));
    assert!(!files.iter().any(|(n, _)| n.starts_with("paths/")));
}

fn comparison_file(runs: &[NamedRun], against: Option<&str>, ending: &str) -> String {
    let files = comparison(&Comparison::of(runs, against), runs).unwrap();
    let (_, bytes) = files.into_iter().find(|(e, _)| *e == ending).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The same run with every person's mean RULA raised.
fn raised(by: f64) -> RunResult {
    let mut other = feasible().clone();
    for b in other.candidates.iter_mut().flat_map(|c| &mut c.bodies) {
        let rula = &mut b.scores[ScoringMethod::Rula];
        rula.by_rollout.iter_mut().for_each(|v| *v += by);
        rula.distribution.expected += by;
    }
    other
}

#[test]
fn runs_are_compared_best_first() {
    let runs: Vec<NamedRun> = vec![
        ("broken".into(), Err("scenario.toml: <key> is unknown".into())),
        ("none".into(), Ok(impossible().clone())),
        ("worse".into(), Ok(raised(0.25))),
        ("first".into(), Ok(feasible().clone())),
    ];
    let compared = Comparison::of(&runs, Some("first"));
    let names: Vec<&str> = compared.ranked().iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["first", "worse", "broken", "none"]);
    let best = compared.ranked()[0].best().unwrap().clone();
    let body = view::worst_body(&feasible().candidates[0]).unwrap();
    assert_eq!(best.expected_rula, body.rula().distribution.expected);
    assert!(matches!(compared.runs[1].state, RowState::NoFeasiblePath(_)));
    let page = comparison_file(&runs, Some("first"), "html");
    assert_self_contained(&page);
    assert!(page.contains("&lt;key&gt; is unknown") && page.contains("A &lt;b&gt;&amp;"));
    assert_eq!(page.matches("<img").count(), 1);
    let table = comparison_file(&runs, None, "csv");
    assert!(table.lines().nth(1).unwrap().starts_with("first,A <b>&,ok,"), "{table}");
    // Two bodies with best, straight and own path of both runs, and two runs without a path.
    assert_eq!(table.lines().count(), 1 + 2 * 2 * 3 + 2, "{table}");
}

/// Something that makes the people of a run others.
type ChangeOf = fn(&mut RunResult);

#[test]
fn people_are_paired_only_where_they_are_the_same() {
    let against = |other: RunResult| {
        let runs: Vec<NamedRun> =
            vec![("a".into(), Ok(feasible().clone())), ("b".into(), Ok(other))];
        let compared = Comparison::of(&runs, None);
        assert_eq!(compared.against.as_deref(), Some("a"));
        assert!(compared.runs[0].bodies.iter().all(|b| b.against.is_none()));
        compared.runs[1].worst_body().unwrap().against.clone().unwrap()
    };
    let paired = against(raised(0.25));
    assert_eq!(paired.unpaired_because, None);
    // Everybody scores 0.25 more: certain for the same people, not for two groups.
    assert!((paired.mean - 0.25).abs() < 1e-9 && paired.high95 - paired.low95 < 1e-9);
    assert!(paired.clear);
    let changes: [(ChangeOf, &str); 4] = [
        (|r| r.provenance.seed += 1, "seeds"),
        (|r| r.provenance.inputs[1].1 = "0".into(), "posture models"),
        (|r| r.provenance.inputs[2..4].iter_mut().for_each(|i| i.1 = "0".into()), "two bodies"),
        (|r| r.provenance.program_version = "9.9".into(), "ergopath"),
    ];
    for (change, why) in changes {
        let mut other = raised(0.25);
        change(&mut other);
        let d = against(other);
        assert!(d.unpaired_because.as_ref().unwrap().starts_with(why), "{d:?}");
        assert!((d.mean - 0.25).abs() < 1e-9 && d.high95 - d.low95 > 1e-3, "{d:?}");
    }
    // Other bodies: the worst of the one against the worst of the other.
    let mut other = raised(0.25);
    for b in other.candidates.iter_mut().flat_map(|c| &mut c.bodies) {
        b.body.push_str("_tall");
    }
    other.verdict.body = other.verdict.body.map(|b| b + "_tall");
    assert!(against(other).unpaired_because.unwrap().starts_with("bodies"));
}

#[test]
fn a_result_that_was_read_back_gives_the_same_files() {
    for result in [feasible(), impossible()] {
        let text = result_json(result).unwrap();
        let back = crate::planner::parse_result(Path::new("result.json"), &text).unwrap();
        assert_eq!(files(&back).unwrap(), files(result).unwrap());
    }
    // What is not finite is null in JSON, and is shown alike.
    let mut odd = feasible().clone();
    odd.comparisons[0].scores[ScoringMethod::Rula].time_mean.low95 = f64::NEG_INFINITY;
    let path = odd.candidates[0].path.as_mut().unwrap();
    path.checks[0].value = f64::INFINITY;
    let text = result_json(&odd).unwrap();
    let back = crate::planner::parse_result(Path::new("result.json"), &text).unwrap();
    assert_eq!(files(&back).unwrap(), files(&odd).unwrap());
}

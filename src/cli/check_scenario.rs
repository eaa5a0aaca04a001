//! A scenario in words: what is in reach, what is assumed, how it looks, and what to measure well.

use super::bars::table;
use super::check::{Args, Explained, outcome, print, print_json};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, read_text};
use crate::math::{Pose, Vec3};
use crate::planner::{
    CellLook, CellSensitivity, FixedPath, Freshness, cell_sensitivity, freshness, look_at_cell,
    read_result,
};
use crate::report::cell_figure;
use crate::scenario::{Scenario, Warning, defaults_in_force, read_scenario};
use crate::trajectory::TimedPath;
use crate::words;
use crate::words::number::percent;
use nalgebra::{Quaternion, UnitQuaternion};
use serde::Serialize;
use std::path::Path;

/// Whether a file calls itself a scenario, or has no other way to be one.
pub(super) fn is_scenario(path: &Path) -> Result<bool, InputError> {
    let is_toml = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("toml"));
    if !is_toml || path.is_dir() {
        return Ok(false);
    }
    let text = read_text(path)?;
    let table = text.parse::<toml::Table>();
    Ok(match table {
        Ok(t) => t
            .get("schema")
            .and_then(toml::Value::as_str)
            .is_some_and(|s| s.starts_with("ergopath/scenario/")),
        // Broken TOML: the line that names the schema tells for whom the error is.
        Err(_) => text.contains("ergopath/scenario/"),
    })
}

#[derive(Serialize)]
struct AsJson<'a> {
    #[serde(flatten)]
    explained: &'a Explained,
    cell: &'a CellLook,
    sensitivity: Option<&'a CellSensitivity>,
}

/// Explains a scenario.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let scenario = read_scenario(&args.file)?;
    let look = look_at_cell(&scenario)?;
    let mut explained = in_words(&scenario, &look, &read_text(&args.file)?);
    if let Some(file) = &args.figure {
        let png = cell_figure(&look).map_err(|e| InputError::fault(file, e.to_string()))?;
        outputs.file(file, png)?;
    }
    let sensitivity =
        if args.sensitivity { Some(measured(args, &scenario, &mut explained)?) } else { None };
    outputs.write()?;
    if args.json {
        print_json(&AsJson {
            explained: &explained,
            cell: &look,
            sensitivity: sensitivity.as_ref(),
        })?;
    } else {
        print(args, &explained);
        if let Some(s) = &sensitivity {
            print_sensitivity(s);
        }
        if let Some(file) = &args.figure {
            say!("\n{}", file.display());
        }
    }
    Ok(outcome(&explained))
}

pub(super) fn in_words(scenario: &Scenario, look: &CellLook, text: &str) -> Explained {
    let s = &look.setting;
    let mut explained = Explained::new(format!("a scenario, \"{}\"", scenario.name));
    let says = &mut explained.says;
    says.extend(words::setting::bodies(s).iter().map(|b| format!("body {b}")));
    says.extend(words::setting::worker(&s.worker));
    says.push(format!("posture model `{}`", scenario.worker.model.name));
    says.push(format!(
        "robot {} with its base at ({:.3}, {:.3}, {:.3}) m",
        scenario.robot.name, look.base_m[0], look.base_m[1], look.base_m[2]
    ));
    let [a, b] = [s.start_m, s.goal_m];
    let way = (Vec3::from(b) - Vec3::from(a)).norm();
    says.push(format!(
        "from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3}) m: {way:.3} m in {} s",
        a[0], a[1], a[2], b[0], b[1], b[2], s.duration_s
    ));
    says.extend(words::hand::at_the_start(scenario));
    says.push(format!("load on the hand {:.2} kg", scenario.task.load_kg));
    for (name, low, high) in &s.obstacles {
        let size: Vec<String> = (0..3).map(|i| format!("{:.2}", high[i] - low[i])).collect();
        says.push(format!("obstacle `{name}`, {} m", size.join(" x ")));
    }
    says.extend(s.meshes.iter().map(words::setting::mesh));
    for p in &scenario.paths {
        says.push(format!("your path `{}`, {:.2} s", p.name, p.path.duration_s()));
    }
    if !scenario.free.all.is_empty() {
        says.push(format!("the planner may choose: {}", scenario.free.names().join(", ")));
    }
    says.extend(words::look::lines(look));
    explained.defaults = defaults_in_force(text);
    explained.defaults.extend(s.assumed_limits.iter().map(|l| format!("limits.{l}")));
    explained.defaults.extend(
        scenario.robot.assumed().iter().map(|a| format!("robot: {}", words::robot::assumed(a))),
    );
    if scenario.worker.model.provenance.simulated {
        explained
            .notes
            .push("the posture model is that of a simulated operator, not of your workers".into());
    }
    explained
        .notes
        .extend(scenario.robot.notes.iter().map(|n| format!("robot: {}", words::robot::note(n))));
    explained.warnings.extend(scenario.warnings.iter().map(words::setting::warning));
    let elsewhere = scenario.paths.iter().filter_map(|p| {
        scenario.end_mismatch(&p.path).map(|e| words::setting::other_movement(&p.name, &e))
    });
    explained.warnings.extend(elsewhere);
    for finding in look.findings() {
        let list = if finding.is_error() { &mut explained.errors } else { &mut explained.warnings };
        list.push(words::look::sentence(&finding));
    }
    explained
}

/// The path of a run, or the straight one, in cells that differ a little.
fn measured(
    args: &Args,
    scenario: &Scenario,
    explained: &mut Explained,
) -> Result<CellSensitivity, InputError> {
    let path =
        args.result.as_deref().map(|r| best_path(r, &args.file, explained)).transpose()?.flatten();
    if path.is_some() && !scenario.free.all.is_empty() {
        explained.warnings.push(
            "the scenario leaves something to the planner; here the cell stands as the scenario says, not as the \
             planner may have chosen"
                .into(),
        );
    }
    let progress = Progress::new();
    let told = |done, total| progress.tell("measuring", done, total);
    cell_sensitivity(scenario, scenario.seed, usize::from(args.repetitions), path.as_ref(), &told)
}

/// The best path of a run; none where that is the straight one.
fn best_path(
    place: &Path,
    scenario: &Path,
    explained: &mut Explained,
) -> Result<Option<FixedPath>, InputError> {
    let result = read_result(place)?;
    if let Freshness::OutOfDate { changed, .. } = freshness(&result, place, Some(scenario))? {
        explained.warnings.push(format!(
            "the run is out of date: {} changed since; its path is taken as it is",
            changed.join(", ")
        ));
    }
    let unsealed = result.warnings.iter().filter(|w| matches!(w, Warning::NoChecksum { .. }));
    explained.warnings.extend(unsealed.map(crate::words::setting::warning));
    let best = crate::words::verdict::lead(&result).filter(|_| result.verdict.is_decided());
    let Some(best) = best else {
        return Err(InputError::new(place, "is a run without a feasible path")
            .remedy("leave --result out to assess the straight path"));
    };
    let Some(path) = best.path.as_ref().filter(|_| best.id != "straight") else { return Ok(None) };
    let pose = |t: &[f64; 7]| {
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(t[3], t[4], t[5], t[6]));
        Pose::from_parts(Vec3::new(t[0], t[1], t[2]).into(), rotation)
    };
    let timed = TimedPath::new(path.time_s.clone(), path.tcp.iter().map(pose).collect());
    let timed = timed.map_err(|e| InputError::new(place, format!("holds a broken path: {e}")))?;
    Ok(Some(FixedPath { name: best.id.clone(), path: timed }))
}

fn print_sensitivity(s: &CellSensitivity) {
    say!(
        "\nWhat to measure well: path `{}`, body {}, the same {} repetitions each time",
        s.path,
        s.body,
        s.repetitions
    );
    say!(
        "  as the scenario says: RULA {:.2}, time at 3+ {}",
        s.nominal.expected_rula,
        percent(s.nominal.exposure_rula_5)
    );
    if let Some(d) = &s.nominal.against_straight {
        let clear = if d.clear { "" } else { " (no clear difference)" };
        say!("  against the straight path: {:+.2}{clear}", d.mean);
    }
    say!();
    let mut table = table(
        &[
            "quantity",
            "by",
            "RULA with less",
            "with more",
            "time at 3+ with less",
            "with more",
            "verdict",
        ],
        &[1, 2, 3, 4, 5],
    );
    let n = &s.nominal;
    for q in &s.quantities {
        let rula = |v: f64| signed(v - n.expected_rula);
        let exposure = |v: f64| signed_percent(v - n.exposure_rula_5);
        let verdict = match (n.against_straight, q.changes_verdict) {
            (None, _) => "",
            (_, true) => "changes",
            (_, false) => "same",
        };
        table.add_row([
            q.key.clone(),
            format!("± {}", q.by),
            rula(q.less.expected_rula),
            rula(q.more.expected_rula),
            exposure(q.less.exposure_rula_5),
            exposure(q.more.exposure_rula_5),
            verdict.to_owned(),
        ]);
    }
    say!("{}", table.trim_fmt());
    if let Some(first) = s.quantities.first() {
        say!(
            "\nMost depends on {} ({}): {} RULA for {}.",
            first.key,
            first.what,
            signed(first.rula_change),
            first.by
        );
    }
    say!(
        "With robot.base the whole path moves along; with start or goal its ends do. Whether the robot still \
         keeps its limits is not asked."
    );
}

/// A change of a share with its sign; what rounds to nothing has none.
fn signed_percent(change: f64) -> String {
    let text = format!("{:+.1} %", 100.0 * change);
    if ["-0.0 %", "+0.0 %"].contains(&text.as_str()) { "0.0 %".to_owned() } else { text }
}

/// A change with its sign; what rounds to nothing has none.
fn signed(change: f64) -> String {
    let text = format!("{change:+.2}");
    if text == "-0.00" || text == "+0.00" { "0.00".to_owned() } else { text }
}

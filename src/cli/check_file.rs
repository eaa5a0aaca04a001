//! Which kind of file a file is, and every kind but scenarios and tables in words.

use super::check::Explained;
use super::check_table::table;
use super::plan::unfinished_words;
use crate::files::{InputError, Seal, parse_toml, read_bytes, read_text};
use crate::human::{Body, Side};
use crate::kinematics::{JointKind, read_urdf};
use crate::planner::{Checkpoint, Status, load_preset, parse_result, read_result};
use crate::posture::load_model;
use crate::recording::{MAP_SCHEMA, Map, Reading, Recording, read_map, read_with};
use crate::robot::{JointTrajectory, PRESETS, Robot};
use crate::scenario::Warning;
use crate::shift::read_shift;
use crate::training::people::{PeopleFile, read_people_file};
use crate::words::number::percent;
use crate::words::setting;
use std::path::Path;

const KNOWN: &str = "known are scenarios, planners, batches, shifts, people and maps (TOML), bodies and robots (URDF), posture models and results \
                     (JSON), recordings (MVNX, BVH, AMC, OpenSim, folders, and with --map C3D, TRC and tables), JointTrajectory \
                     (YAML, JSON) and tables (CSV)";

/// A file in words.
pub(super) fn explain(path: &Path, map: Option<&Map>) -> Result<Explained, InputError> {
    let how = Reading { map, ..Reading::default() };
    if path.is_dir() {
        return folder(path, &how);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "toml" => toml(path, &name),
        "json" => json(path),
        "yaml" | "yml" => trajectory(path),
        "urdf" => urdf(path),
        "csv" if map.is_none() => table(path),
        "csv" | "txt" if map.is_some() => Ok(recording(&read_with(path, &how)?)),
        "mvnx" | "mvn" | "bvh" | "amc" | "asf" | "c3d" | "trc" | "tsv" | "mot" | "sto" => {
            Ok(recording(&read_with(path, &how)?))
        }
        _ => {
            read_bytes(path)?;
            Err(InputError::new(path, "is no kind of file that ergopath knows").remedy(KNOWN))
        }
    }
}

fn folder(path: &Path, how: &Reading) -> Result<Explained, InputError> {
    if path.join("result.json").is_file() {
        return Ok(result(&read_result(path)?));
    }
    read_with(path, how).map(|r| recording(&r))
}

fn toml(path: &Path, name: &str) -> Result<Explained, InputError> {
    let text = read_text(path)?;
    let table: ::toml::Table = parse_toml(path, &text)?;
    let schema = table.get("schema").and_then(::toml::Value::as_str).unwrap_or_default();
    if name.ends_with(".body.toml") || schema.starts_with("ergopath/body/") {
        let urdf = path.with_file_name(
            path.file_name().unwrap_or_default().to_string_lossy().replace(".body.toml", ".urdf"),
        );
        return Ok(body(&Body::read(&urdf)?));
    }
    if schema.starts_with("ergopath/planner/") {
        return planner(path);
    }
    if schema.starts_with("ergopath/batch/") {
        return super::check_batch::batch(path);
    }
    if schema.starts_with("ergopath/shift/") {
        return shift(path);
    }
    if schema.starts_with("ergopath/people/") {
        return Ok(people(&read_people_file(path)?));
    }
    if schema.starts_with("ergopath/map/") {
        return Ok(self::map(&read_map(path)?));
    }
    let found =
        if schema.is_empty() { "no schema".to_owned() } else { format!("schema `{schema}`") };
    let message = format!("has {found}, so it cannot be told what it is");
    Err(InputError::new(path, message).remedy(
        "a scenario begins with schema = \"ergopath/scenario/1\", a planner with schema = \"ergopath/planner/1\", \
         a batch with schema = \"ergopath/batch/1\", a shift with schema = \"ergopath/shift/1\", a list of people with schema = \"ergopath/people/1\", a map of markers with schema = \"ergopath/map/1\"",
    ))
}

/// A shift; its results are read and added up.
fn shift(path: &Path) -> Result<Explained, InputError> {
    let shift = read_shift(path)?;
    let result = shift.assess(path)?;
    let count = shift.tasks.len();
    let mut explained = Explained::new(format!("a shift of {count} tasks, `{}`", shift.name))
        .saying(crate::words::shift::headline(&result));
    for task in &shift.tasks {
        let minutes = crate::words::shift::minutes(task.minutes);
        let line =
            format!("`{}`: {minutes}, {:.0} cycles, from {}", task.name, task.cycles, task.result);
        explained = explained.saying(line);
    }
    explained.notes.extend(crate::words::shift::notes(&result));
    Ok(explained)
}

fn map(map: &Map) -> Explained {
    let segments: Vec<&str> = map.segments().collect();
    let markers = map.markers();
    let what = if map.is_of_columns() { "columns" } else { "markers" };
    Explained::new(format!("a map from {what} to segments ({MAP_SCHEMA})"))
        .saying(format!("{} segments: {}", segments.len(), segments.join(", ")))
        .saying(format!("of {} {what}: {}", markers.len(), markers.join(", ")))
}

fn people(file: &PeopleFile) -> Explained {
    let mut explained = Explained::new(format!("a list of {} recorded people", file.count()));
    for (name, recordings, side, body) in file.people() {
        let side = side.name();
        let body = body.map_or_else(
            || "in a body as the recorded arm asks for".to_owned(),
            |b| format!("in the body {}", b.name),
        );
        explained.says.push(format!("`{name}`: {recordings} recordings, {side} hand, {body}"));
    }
    explained
}

fn planner(path: &Path) -> Result<Explained, InputError> {
    let p = load_preset(&path.display().to_string())?;
    let o = &p.objective;
    Ok(Explained::new(format!("a planner, `{}`", p.name))
        .saying(format!("objective: {}", crate::words::verdict::objective(o)))
        .saying(format!(
            "search: {} paths in {} generations, {} via-points each; each judged on {} to {} repetitions",
            p.population * p.generations,
            p.generations,
            p.vias,
            p.rollouts_first,
            p.rollouts_most
        ))
        .saying(format!("baselines that search: {} generations each", p.baseline_generations))
        .saying(format!(
            "the best {} are compared on {} fresh repetitions, and {} are reported",
            p.shortlist, p.rollouts_final, p.reported
        ))
        .saying(format!("time steps of a path: {}", p.steps)))
}

fn json(path: &Path) -> Result<Explained, InputError> {
    let text = read_text(path)?;
    let broken = |e: serde_json::Error| {
        let what =
            if e.is_eof() { "ends in the middle".to_owned() } else { format!("is no JSON: {e}") };
        InputError::new(path, what).remedy("copy or make the file again")
    };
    let value: serde_json::Value = serde_json::from_str(&text).map_err(broken)?;
    let schema = value["schema"].as_str().unwrap_or_default();
    let kind = schema.split('/').nth(1).unwrap_or_default();
    match kind {
        "result" => return Ok(result(&parse_result(path, &text)?)),
        "posture-model" => return model(path),
        "unfinished" => {
            let kept = Checkpoint::read(path)?;
            return Ok(Explained::new("an interrupted run").saying(unfinished_words(&kept)));
        }
        "output" => {
            let files = value["files"].as_object().map_or(0, serde_json::Map::len);
            return Ok(Explained::new("the list of what ergopath wrote in this folder").saying(
                format!("{files} files, each with its SHA-256: only these may be replaced"),
            ));
        }
        "score" => {
            return Ok(Explained::new("scores of a motion, written by `ergopath score`")
                .saying(format!("program version {}", value["program_version"])));
        }
        "shift-result" => {
            return Ok(Explained::new("a shift, written by `ergopath shift`")
                .saying(format!("program version {}", value["program_version"])));
        }
        "batch-run" => return super::check_batch::plan(path),
        "cell" => {
            return Ok(Explained::new("what one cell of a batch found").saying(format!(
                "state {}, {} rows",
                value["state"],
                value["rows"].as_array().map_or(0, Vec::len)
            )));
        }
        _ if value.get("joint_names").is_some() => return trajectory(path),
        _ => {}
    }
    let message = format!("has schema `{schema}`, which ergopath does not know");
    Err(InputError::new(path, message).remedy(KNOWN))
}

fn result(r: &crate::planner::RunResult) -> Explained {
    let p = &r.provenance;
    let feasible = r.candidates.iter().filter(|c| c.status == Status::Feasible).count();
    let mut explained = Explained::new("a finished run")
        .saying(format!("{}: {}", r.setting.name, crate::words::verdict::headline(r)))
        .saying(format!("{} paths, {feasible} of them feasible", r.candidates.len()))
        .saying(format!("made by: {} (ergopath {})", p.command, p.program_version));
    for (name, hash) in &p.inputs {
        explained =
            explained.saying(format!("input {name}: SHA-256 {}…", &hash[..hash.len().min(16)]));
    }
    explained.notes.extend(r.verdict.caveat.map(|c| crate::words::verdict::caveat(c).into_owned()));
    explained.warnings.extend(r.warnings.iter().map(setting::warning));
    explained
}

/// What a model was learned from: each recording, or how many where they fill more than a line.
fn recordings(all: &[(String, String)], people: usize) -> String {
    const FEW: usize = 6;
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    match names.as_slice() {
        [first, .., last] if names.len() > FEW => {
            let whose = if people > 1 { format!(" of {people} people") } else { String::new() };
            format!("{} recordings{whose}, {first} to {last}", names.len())
        }
        few => few.join(", "),
    }
}

fn model(path: &Path) -> Result<Explained, InputError> {
    let (model, _) = load_model(&path.display().to_string(), Path::new(""))?;
    let p = &model.provenance;
    let mut explained = Explained::new(format!("a posture model, `{}`", model.name))
        .saying(format!(
            "method {}, {} arm, {} joints; learned on body `{}` ({}, {} m, {} kg)",
            model.method.name(),
            model.side.prefix().to_lowercase(),
            model.joints.len(),
            p.body.0,
            model.size.sex,
            model.size.stature_m,
            model.size.mass_kg
        ))
        .saying(format!("from {}", recordings(&p.recordings, p.people)));
    let groups: Vec<String> = model
        .weight_by_group()
        .iter()
        .map(|(group, share)| format!("{group} {}", percent(*share)))
        .collect();
    explained = explained.saying(format!("who moves: {}", groups.join(", ")));
    if let Some(own) = model.quality.iter().find(|q| q.method == model.method) {
        let path = own.path_error_deg.map_or_else(String::new, |(_, with)| {
            format!(", {with:.1} deg joint error along held-out paths")
        });
        explained = explained.saying(format!(
            "on held-out movement: error {:.2} of the rms joint speed{path}",
            own.relative_rmse
        ));
    }
    if p.simulated {
        explained
            .notes
            .push("made from a simulated operator: a demonstration, not your workers".into());
    }
    explained.notes.extend(p.notes.iter().cloned());
    if model.seal == Seal::Missing {
        let file = path.display().to_string();
        explained.warnings.push(setting::warning(&Warning::NoChecksum { file }));
    }
    Ok(explained)
}

fn body(body: &Body) -> Explained {
    let mut explained = Explained::new(format!("a body, `{}`", body.name))
        .saying(format!(
            "{}, stature {} m, mass {} kg",
            body.size.sex, body.size.stature_m, body.size.mass_kg
        ))
        .saying(format!("hips {:.3} m above the floor barefoot", body.standing_pelvis_height_m))
        .saying(format!(
            "{} links, {} joints, {} bounds on sums of joints",
            body.model.links.len(),
            body.model.joints.len(),
            body.sums.len()
        ));
    if body.is_other() {
        explained.warnings.push(setting::warning(&Warning::OtherBody { body: body.name.clone() }));
    }
    explained
}

fn urdf(path: &Path) -> Result<Explained, InputError> {
    let model = read_urdf(path)?;
    let is_body = [Side::Right, Side::Left].iter().all(|s| model.link_index(s.grip()).is_some());
    if is_body {
        return Ok(self::body(&Body::read(path)?));
    }
    let moving = model.joints.iter().filter(|j| j.kind != JointKind::Fixed);
    let names: Vec<&str> = moving.map(|j| j.name.as_str()).collect();
    let parents: Vec<usize> = model.joints.iter().map(|j| j.parent).collect();
    let tips: Vec<&str> = (0..model.links.len())
        .filter(|i| !parents.contains(i))
        .map(|i| model.links[i].name.as_str())
        .collect();
    let mut explained = Explained::new("a chain of links (URDF), no body of ergopath")
        .saying(format!(
            "{} links from `{}`; ends: {}",
            model.links.len(),
            model.root(),
            tips.join(", ")
        ))
        .saying(format!("{} joints that move: {}", names.len(), names.join(", ")));
    for j in &model.joints {
        if j.kind != JointKind::Fixed && j.mimic.is_none() && j.velocity.is_infinite() {
            explained.warnings.push(format!("joint `{}` has no velocity limit", j.name));
        }
    }
    explained.warnings.extend(model.warnings.iter().cloned());
    Ok(explained)
}

fn recording(r: &Recording) -> Explained {
    let mut explained = Explained::new(format!("a recording ({})", r.format))
        .saying(format!(
            "{} frames at {} Hz: {:.1} s of one person",
            r.frames(),
            r.rate_hz,
            r.frames() as f64 / r.rate_hz
        ))
        .saying(format!(
            "{} segments: {}",
            r.segments.len(),
            r.segments.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ")
        ));
    explained.notes.extend(r.remarks.iter().map(|r| r.text.clone()));
    explained
}

fn trajectory(path: &Path) -> Result<Explained, InputError> {
    let text = read_text(path)?;
    let is_json = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("json"));
    let t = JointTrajectory::from_text(&text, is_json).map_err(|e| {
        InputError::new(path, e.to_string()).remedy(
            "joint_names, and points with positions and time_from_start, as ROS writes them",
        )
    })?;
    let end = t.points.last().map_or(0.0, |p| p.time_from_start.seconds());
    let mut explained = Explained::new("the motion of a robot (ROS JointTrajectory)")
        .saying(format!("{} points over {end:.2} s", t.points.len()))
        .saying(format!("joints: {}", t.joint_names.join(", ")));
    for (odd, what, rest) in [
        (t.odd_velocity(), "a velocity", "the positions move at"),
        (t.odd_acceleration(), "an acceleration", "the velocities change a second by"),
    ] {
        explained.warnings.extend(odd.map(|odd| {
            let (point, joint) = (odd.point + 1, odd.joint);
            format!(
                "point {point}, joint `{joint}`: the file gives {what} of {:.3}, but {rest} {:.3}",
                odd.given, odd.moved
            )
        }));
    }
    let fits = |name: &&&str| Robot::preset(name).is_ok_and(|r| t.postures(&r).is_ok());
    match PRESETS.iter().find(fits) {
        Some(name) => {
            let robot = Robot::preset(name)?;
            let broken: Vec<String> = t
                .check(&robot)
                .into_iter()
                .filter(|m| !m.is_kept())
                .map(|m| format!("joint `{}` of {name} leaves its limits between the points", m.joint))
                .collect();
            explained = explained.saying(format!("the joints are those of the preset `{name}`"));
            explained.warnings.extend(broken);
        }
        None => explained.notes.push(
            "the joints are of no preset: whether it keeps a robot's limits is seen with a scenario (`ergopath assess`)"
                .into(),
        ),
    }
    Ok(explained)
}

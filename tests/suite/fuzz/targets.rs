//! Every reader of a file of a user as a function of bytes: it may refuse them, and may do nothing else.
//!
//! The same functions are run by cargo-fuzz (`fuzz/`) and, on seeds that are changed in a fixed way, by the tests.
//! What is accepted is used as the program uses it: a robot is looked at in a cell, a result is reported. Each tells
//! whether the bytes were accepted.

#![allow(dead_code, unreachable_pub, reason = "programs that share this file use parts of it")]

use super::made;
use ergopath::batch::{CellRecord, Gate, Jobs, Manifest, is_batch, read_batch};
use ergopath::ergonomics::Profile;
use ergopath::files::{InputError, sealed, take_named_inputs};
use ergopath::human::{Body, Side, Stance};
use ergopath::kinematics::{Linkage, parse_urdf};
use ergopath::mesh::{convex_parts, fit_capsules, read_mesh};
use ergopath::planner::{Checkpoint, RunResult, load_preset, look_at_cell, parse_result, plan};
use ergopath::recording::{Map, Reading, Recording, read_map, read_rigid_bodies, read_runs};
use ergopath::report::{
    Comparison, Language, NamedRun, comparison, files, one_page, program, shift_files,
};
use ergopath::robot::{JointTrajectory, Robot};
use ergopath::scenario::{Scenario, defaults_in_force, parse_scenario, read_user_path};
use ergopath::scoring::{read_angles, score_table};
use ergopath::shift::read_shift;
use ergopath::training::people::read_people_file;
use ergopath::training::{FitSettings, fit, read_data, read_motion, read_quality};
use ergopath::words;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// A reader and its name, which is also that of its program in `fuzz/`.
#[derive(Clone, Copy)]
pub struct Target {
    pub name: &'static str,
    /// Whether the bytes were accepted.
    pub run: fn(&[u8]) -> bool,
}

macro_rules! targets {
    ($($name:ident),* $(,)?) => {
        /// All readers.
        pub const TARGETS: &[Target] = &[$(Target { name: stringify!($name), run: $name }),*];
    };
}

targets![
    scenario,
    scenario_plan,
    planner,
    batch,
    shift,
    people,
    map,
    gate,
    model,
    result,
    unfinished,
    manifest,
    summary,
    body_sheet,
    body_urdf,
    robot,
    mvnx,
    bvh,
    asf,
    amc,
    c3d,
    trc,
    opensim,
    points,
    rigid_body,
    path_csv,
    motion_csv,
    data_csv,
    quality_csv,
    worksheets,
    trajectory_json,
    trajectory_yaml,
    stl,
    obj,
    gltf,
    glb,
    dae,
];

/// Longest file that is used further than it is read, bytes: what is large only takes long.
const USED: usize = 200_000;
/// Most cells of a batch, frames of a recording, triangles of a mesh that are used.
const FEW: usize = 64;
const FEW_TRIANGLES: usize = 400;
const STANDING: Stance = Stance::Standing { shoe_m: 0.03 };

/// A folder with what files may name, of this thread.
struct Room(TempDir);

impl Room {
    fn new() -> Self {
        let room = Self(tempfile::tempdir().expect("a folder"));
        let body = ergopath::human::generate(
            "anna",
            ergopath::human::BodySize {
                sex: ergopath::human::Sex::Female,
                stature_m: 1.63,
                mass_kg: 66.0,
            },
        );
        let body = body.expect("a body");
        for (name, bytes) in [
            ("bench.toml", made::BENCH.into()),
            ("tiny.toml", made::TINY.into()),
            ("part.stl", made::stl()),
            ("today.csv", made::tcp_csv().into_bytes()),
            ("arm.urdf", made::ARM.into()),
            ("anna.urdf", body.urdf.clone().into_bytes()),
            ("anna.body.toml", body.sheet.clone().into_bytes()),
            ("map.toml", made::MAP.into()),
            ("lift.tsv", made::tsv().into_bytes()),
            ("lift.bvh", made::bvh().into_bytes()),
            ("skeleton.asf", made::asf().into_bytes()),
            ("motion.amc", made::amc().into_bytes()),
            ("person.urdf", body.urdf.into_bytes()),
            ("person.body.toml", body.sheet.into_bytes()),
        ] {
            room.write(name, &bytes);
        }
        room
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).expect("a folder");
        }
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

thread_local! {
    static ROOM: Room = Room::new();
    static REFUSED: Cell<String> = const { Cell::new(String::new()) };
}

/// Reads bytes as a file of this name.
fn as_file<T>(
    name: &str,
    bytes: &[u8],
    read: impl FnOnce(&Path) -> Result<T, InputError>,
) -> Option<T> {
    let read = ROOM.with(|room| read(&room.write(name, bytes)));
    // A list that would grow for ever.
    take_named_inputs();
    read.map_err(|e| shown(&e)).ok()
}

/// A refusal is drawn as on a terminal, with its place in the file.
fn shown(error: &InputError) {
    use miette::Diagnostic as _;
    let mut text = String::new();
    let drawn = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
    drawn.render_report(&mut text, error).expect("drawn");
    assert!(!text.trim().is_empty() && !error.to_string().trim().is_empty());
    let _ = error.help();
    REFUSED.set(text);
}

/// Why this thread last refused something.
pub fn why_refused() -> String {
    REFUSED.take()
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// The scenario in words and pictures, as `check` has it.
fn checked(scenario: &Scenario, text: &str) -> bool {
    for warning in &scenario.warnings {
        let _ = words::setting::warning(warning);
    }
    let _ = (words::hand::at_the_start(scenario), defaults_in_force(text));
    match look_at_cell(scenario) {
        Ok(look) => {
            let _ = words::look::lines(&look);
            look.findings().iter().for_each(|f| drop(words::look::sentence(f)));
        }
        Err(e) => shown(&e),
    }
    true
}

/// A scenario, and what `check` says of it.
pub fn scenario(bytes: &[u8]) -> bool {
    let found = as_file("scenario.toml", bytes, |path| {
        parse_scenario(path, text(bytes).unwrap_or_default())
    });
    found.is_some_and(|s| checked(&s, text(bytes).unwrap_or_default()))
}

/// A scenario, planned by a tiny planner and reported.
pub fn scenario_plan(bytes: &[u8]) -> bool {
    let read = |path: &Path| parse_scenario(path, text(bytes).unwrap_or_default());
    let Some(found) = as_file("scenario.toml", bytes, read) else { return false };
    if found.worker.bodies.len() > 1 || found.duration_s > 60.0 {
        return true;
    }
    match plan(&found, &made::request(), &|_| true) {
        Ok(result) => reported(&result),
        Err(e) => drop(e.to_string()),
    }
    true
}

/// A run in words, pages and programs.
fn reported(result: &RunResult) {
    let _ = words::verdict::headline(result);
    let drawn = files(result).and_then(|_| one_page(result, Some("`a` has changed")));
    drop(drawn.map_err(|e| e.to_string()));
    let Ok(panda) = Robot::preset("panda") else { return };
    for path in result.candidates.iter().filter_map(|c| c.path.as_ref()) {
        for language in [Language::Franka, Language::Ros, Language::UrScript] {
            let written = program(language, "a", path, &panda, 1e-3);
            drop(written.map_err(|e| e.to_string()));
        }
    }
    let run = |name: &str| -> NamedRun { (name.to_owned(), Ok(result.clone())) };
    let runs = [run("a"), run("b")];
    drop(comparison(&Comparison::of(&runs, Some("a")), &runs).map_err(|e| e.to_string()));
}

/// A planner's settings.
pub fn planner(bytes: &[u8]) -> bool {
    as_file("own.toml", bytes, |path| load_preset(&path.to_string_lossy())).is_some()
}

/// A batch with its cells.
pub fn batch(bytes: &[u8]) -> bool {
    let _ = is_batch(text(bytes).unwrap_or_default());
    let all = |path: &Path| {
        let batch = read_batch(path)?;
        if batch.cells.len() <= FEW {
            Manifest::of(&batch, &Jobs::of(&batch)?)?;
        }
        Ok(())
    };
    as_file("batch.toml", bytes, all).is_some()
}

/// A shift of a run and a scored motion.
pub fn shift(bytes: &[u8]) -> bool {
    let all = |path: &Path| {
        beside(path, "run/result.json", made::RAN.result.as_bytes());
        beside(path, "scored/summary.json", made::SUMMARY.as_bytes());
        let shift = read_shift(path)?;
        let result = shift.assess(path)?;
        let _ = (words::shift::headline(&result), words::shift::notes(&result));
        drop(shift_files(&result).map_err(|e| e.to_string()));
        Ok(())
    };
    as_file("shift.toml", bytes, all).is_some()
}

fn beside(path: &Path, name: &str, bytes: &[u8]) {
    let file = path.with_file_name(name);
    std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
    std::fs::write(file, bytes).expect("written");
}

/// People and where their recordings are.
pub fn people(bytes: &[u8]) -> bool {
    // Patterns from the root walk through the whole machine, as they should.
    if bytes.windows(2).any(|w| w == b"\"/" || w == b"'/" || w == b"..") {
        return false;
    }
    as_file("people.toml", bytes, read_people_file).is_some()
}

/// A map, and a table read with it.
pub fn map(bytes: &[u8]) -> bool {
    let Some(map) = as_file("own_map.toml", bytes, read_map) else { return false };
    let _ = (map.segments().count(), map.markers());
    let (name, table) =
        if map.is_of_columns() { ("mapped.mot", made::mot()) } else { ("mapped.tsv", made::tsv()) };
    recorded(name, table.as_bytes(), Some(&map));
    true
}

/// The bounds of `--gate`.
pub fn gate(bytes: &[u8]) -> bool {
    let Some(text) = text(bytes) else { return false };
    Gate::parse(text).map_err(|e| shown(&e)).is_ok()
}

/// A posture model, with which a cell is looked at.
pub fn model(bytes: &[u8]) -> bool {
    let cell = made::BENCH.replace("\"demo_operator\"", "\"model.json\"");
    let read = |path: &Path| parse_scenario(&path.with_file_name("scenario.toml"), &cell);
    let Some(found) = as_file("model.json", bytes, read) else { return false };
    let _ = found.worker.model.weight_by_group();
    checked(&found, &cell)
}

/// A result, with all that is made of one.
pub fn result(bytes: &[u8]) -> bool {
    let text = text(bytes).unwrap_or_default();
    let found = parse_result(Path::new("result.json"), text).map_err(|e| shown(&e));
    found.is_ok_and(|r| {
        reported(&r);
        true
    })
}

/// An interrupted run with a checksum that fits, which goes on.
pub fn unfinished(bytes: &[u8]) -> bool {
    static CELL: LazyLock<Scenario> = LazyLock::new(made::bench);
    let Some(text) = text(bytes).and_then(|t| sealed(t).ok()) else { return false };
    let Some(kept) = as_file("unfinished.json", text.as_bytes(), Checkpoint::read) else {
        return false;
    };
    let _ = (kept.tried(), kept.text().is_ok());
    let mut request = made::request();
    request.resume = Some(kept);
    drop(plan(&CELL, &request, &|_| true).map_err(|e| e.to_string()));
    true
}

/// The plan of a batch with records of its cells.
pub fn manifest(bytes: &[u8]) -> bool {
    let read = |path: &Path| {
        let folder = path.parent().expect("a folder");
        let plan = Manifest::read(folder)?;
        let _ = plan.varied();
        for cell in plan.cells.iter().take(FEW) {
            let _ = (cell.folder(), cell.short());
            // A record of another key is none.
            let record = CellRecord::failed("other", "made up".to_owned()).file()?;
            beside(path, &format!("cell/{}", record.0), &record.1);
            let found = CellRecord::read(&folder.join("cell"), &cell.key)?;
            assert!(found.is_none());
        }
        plan.records(folder).map(drop)
    };
    as_file("batch_run/batch.json", bytes, read).is_some()
}

/// Scores of a motion, as a shift reads them.
pub fn summary(bytes: &[u8]) -> bool {
    as_file("summary.json", bytes, ergopath::scoring::read_score).is_some()
}

fn used(body: &Body) {
    for side in [Side::Right, Side::Left] {
        let Ok(arm) = body.arm(side) else { continue };
        let _ = body.limits(&arm);
    }
    let _ = (body.leg_m(), body.floor_m(STANDING), body.is_other(), body.sha256());
    let _ = body.pelvis_pose([0.0, 0.0], 0.0, STANDING);
    drop(ergopath::survey::WholeSurveyor::new(body).map_err(|e| shown(&e)));
}

/// The sheet of a body beside its URDF.
pub fn body_sheet(bytes: &[u8]) -> bool {
    let read = |path: &Path| Body::read(&path.with_file_name("anna.urdf"));
    as_file("anna.body.toml", bytes, read).inspect(used).is_some()
}

/// The URDF of a body beside its sheet.
pub fn body_urdf(bytes: &[u8]) -> bool {
    as_file("person.urdf", bytes, Body::read).inspect(used).is_some()
}

/// A robot from its root to the last link that is named, moved and looked at in a cell.
pub fn robot(bytes: &[u8]) -> bool {
    let model = text(bytes).map(|t| parse_urdf(Path::new("robot.urdf"), t).map_err(|e| shown(&e)));
    let Some(Ok(model)) = model else { return false };
    let (base, tip) = (model.root().to_owned(), model.links.last().map(|l| l.name.clone()));
    let tip = tip.unwrap_or_default();
    let read = |path: &Path| Robot::from_urdf(path, &base, &tip);
    let Some(robot) = as_file("robot.urdf", bytes, read) else { return false };
    robot.notes.iter().for_each(|n| drop(words::robot::note(n)));
    let _ = robot.assumed();
    if robot.dof() > 12 || bytes.len() > USED {
        return true;
    }
    let quoted = |name: &str| toml::Value::String(name.to_owned()).to_string();
    let cell = made::BENCH.replace(
        "preset = \"panda\"",
        &format!("urdf = \"robot.urdf\"\nbase_link = {}\ntcp = {}", quoted(&base), quoted(&tip)),
    );
    scenario(cell.as_bytes());
    true
}

/// A recording with the body fitted to it.
fn recorded(name: &str, bytes: &[u8], map: Option<&Map>) -> bool {
    let how = Reading { map, ..Reading::default() };
    let Some(runs) = as_file(name, bytes, |path| read_runs(path, &how)) else { return false };
    for run in &runs {
        fitted(&run.recording);
    }
    true
}

fn fitted(recording: &Recording) {
    static BODY: LazyLock<Body> =
        LazyLock::new(|| Body::load("male_p50", Path::new("")).expect("shipped"));
    if recording.frames() <= FEW {
        drop(fit(recording, &BODY, Side::Right, &FitSettings::default()).map_err(|e| shown(&e)));
    }
}

/// A movement of inertial sensors.
pub fn mvnx(bytes: &[u8]) -> bool {
    recorded("motion.mvnx", bytes, None)
}

/// A movement of a skeleton.
pub fn bvh(bytes: &[u8]) -> bool {
    recorded("motion.bvh", bytes, None)
}

/// A skeleton beside a motion.
pub fn asf(bytes: &[u8]) -> bool {
    let read = |path: &Path| {
        let motion = path.with_file_name("posed.amc");
        std::fs::write(&motion, made::amc()).expect("written");
        read_runs(&motion, &Reading::default())
    };
    let Some(runs) = as_file("posed.asf", bytes, read) else { return false };
    for run in &runs {
        fitted(&run.recording);
    }
    true
}

/// A motion beside its skeleton.
pub fn amc(bytes: &[u8]) -> bool {
    ROOM.with(|room| room.write("moved.asf", made::asf().as_bytes()));
    recorded("moved.amc", bytes, None)
}

fn marked(name: &str, bytes: &[u8]) -> bool {
    static MAP: LazyLock<Map> = LazyLock::new(|| {
        let room = tempfile::tempdir().expect("a folder");
        let file = room.path().join("map.toml");
        std::fs::write(&file, made::MAP).expect("written");
        read_map(&file).expect("a map")
    });
    recorded(name, bytes, Some(&MAP))
}

/// Markers, binary.
pub fn c3d(bytes: &[u8]) -> bool {
    marked("markers.c3d", bytes)
}

/// Markers, as text.
pub fn trc(bytes: &[u8]) -> bool {
    marked("markers.trc", bytes)
}

/// Markers in a table.
pub fn points(bytes: &[u8]) -> bool {
    marked("markers.tsv", bytes)
}

/// Joint angles of a musculoskeletal model.
pub fn opensim(bytes: &[u8]) -> bool {
    recorded("motion.mot", bytes, None) | recorded("motion.sto", bytes, None)
}

/// One of the tables of a folder of rigid bodies.
pub fn rigid_body(bytes: &[u8]) -> bool {
    let name = |body: &str| format!("rigid/ann_{body}_pose_saved.csv");
    for (i, body) in made::rigid_bodies().enumerate() {
        ROOM.with(|room| room.write(&name(body), made::rigid_body(i).as_bytes()));
    }
    let read = |path: &Path| read_rigid_bodies(path.parent().expect("a folder"), None, 100.0);
    as_file(&name("chest"), bytes, read).inspect(fitted).is_some()
}

fn panda() -> &'static Robot {
    static PANDA: LazyLock<Robot> = LazyLock::new(|| Robot::preset("panda").expect("shipped"));
    &PANDA
}

/// A path of today, of the tool or of the joints.
pub fn path_csv(bytes: &[u8]) -> bool {
    let read = |path: &Path| read_user_path("today", path, panda(), None);
    let Some(found) = as_file("own.csv", bytes, read) else { return false };
    let _ = (found.path.length_m(), found.path.velocities().len());
    true
}

/// Joint angles of a body, to learn from and to score.
pub fn motion_csv(bytes: &[u8]) -> bool {
    static BODY: LazyLock<Body> =
        LazyLock::new(|| Body::load("female_p50", Path::new("")).expect("shipped"));
    let learned = as_file("motion.csv", bytes, |path| read_motion(path, &BODY, Side::Right));
    let scored = as_file("motion.csv", bytes, |path| read_angles(path, &BODY, STANDING, None));
    learned.is_some() | scored.is_some()
}

/// Rows of joints and task of a chain.
pub fn data_csv(bytes: &[u8]) -> bool {
    static CHAIN: LazyLock<Linkage> = LazyLock::new(|| {
        let model = parse_urdf(Path::new("arm.urdf"), made::ARM).expect("an arm");
        Linkage::chain(&model, "base", "l3").expect("a chain")
    });
    as_file("data.csv", bytes, |path| read_data(path, &CHAIN, None, None)).is_some()
}

/// How good an import was.
pub fn quality_csv(bytes: &[u8]) -> bool {
    as_file("quality.csv", bytes, read_quality).is_some()
}

/// Filled-in worksheets.
pub fn worksheets(bytes: &[u8]) -> bool {
    let read = |path: &Path| score_table(path, bytes, &Profile::default());
    as_file("sheets.csv", bytes, read).is_some()
}

fn trajectory(bytes: &[u8], ending: &str) -> bool {
    let found = text(bytes).and_then(|t| JointTrajectory::from_text(t, ending == "json").ok());
    if let Some(found) = found {
        let _ = found.postures(panda()).map_err(|e| e.to_string());
        let _ = words::program::limits(&found.check(panda()));
    }
    let read = |path: &Path| read_user_path("today", path, panda(), None);
    as_file(&format!("trajectory.{ending}"), bytes, read).is_some()
}

/// A `JointTrajectory` as JSON.
pub fn trajectory_json(bytes: &[u8]) -> bool {
    trajectory(bytes, "json")
}

/// A `JointTrajectory` as YAML.
pub fn trajectory_yaml(bytes: &[u8]) -> bool {
    trajectory(bytes, "yaml")
}

fn mesh(name: &str, bytes: &[u8]) -> bool {
    let Some(found) = as_file(name, bytes, read_mesh) else { return false };
    if found.mesh.triangles.len() <= FEW_TRIANGLES {
        let _ = (convex_parts(&found.mesh), fit_capsules(&found.mesh));
    }
    true
}

/// A mesh, text or binary.
pub fn stl(bytes: &[u8]) -> bool {
    mesh("mesh.stl", bytes)
}

/// A mesh as text.
pub fn obj(bytes: &[u8]) -> bool {
    mesh("mesh.obj", bytes)
}

/// A mesh with nodes, as JSON.
pub fn gltf(bytes: &[u8]) -> bool {
    mesh("mesh.gltf", bytes)
}

/// A mesh with nodes, binary.
pub fn glb(bytes: &[u8]) -> bool {
    mesh("mesh.glb", bytes)
}

/// A mesh with nodes, as XML.
pub fn dae(bytes: &[u8]) -> bool {
    mesh("mesh.dae", bytes)
}

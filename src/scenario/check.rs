//! From the file as typed to a scenario with everything resolved: each refusal names key and remedy.

use super::SCENARIO_SCHEMA;
use super::cell::{
    NAME, Named, PersonMargin, resolve_limits, resolve_obstacle, resolve_person_margin,
    resolve_robot,
};
use super::file::{ObstacleFile, PathFile, ScenarioFile, TaskFile};
use super::freedom::{Freedom, Freedoms, resolve_free};
use super::held::{Held, SecondHand};
use super::mesh::ObstacleMesh;
use super::paths::{UserPath, read_user_path};
use super::plausible::{self, Doubt, LONGEST_S, name_fault, path_name_fault};
use super::source::Source;
use super::task::Task;
use super::warning::Warning;
use super::worker::{Adaptation, Worker, resolve_worker};
use crate::ergonomics::Profile;
use crate::files::{InputError, Seal, suggest};
use crate::human::{Pelvis, Stance};
use crate::math::{Pose, Vec3};
use crate::path::{Candidate, End, PathLimits, drawn};
use crate::physical::{DURATION_S, SAME_CELL_M};
use crate::posture::Hold;
use crate::robot::{Obstacle, Robot};
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// Angle between the worker's facing and the task from which it is told.
const MOST_TURNED_DEG: f64 = 60.0;
/// Distance of the task from the worker's axis below which it has no direction, m.
const LEAST_AHEAD_M: f64 = 0.1;
/// What all cycles of a minute may take together; a hair more for rounding, s.
const MOST_OF_A_MINUTE_S: f64 = 60.0 + 1e-6;
/// Places between floor (or seat) and hip where nothing solid may be.
const AXIS_LOOKS: i32 = 20;
/// Way and turn below which goal and start are one.
const LEAST_WAY_M: f64 = 1e-3;
const LEAST_TURN_DEG: f64 = 0.5;
/// Longest description, characters: some pages.
const LONGEST_DESCRIPTION: usize = 10_000;
/// Characters of a name that cannot be used which are shown.
const SHOWN_OF_NAME: usize = 30;

/// A workstation, resolved.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Short name.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Seed of all randomness, unless the command line gives another.
    pub seed: u64,
    /// Convention for what RULA and REBA leave open.
    pub score_profile: Profile,
    /// Who works.
    pub worker: Worker,
    /// Pose of the grip in the TCP's frame.
    pub grip: Pose,
    /// Which motions of the hand the robot prescribes.
    pub hold: Hold,
    /// The other hand where both hold on.
    pub second_hand: Option<SecondHand>,
    /// The robot.
    pub robot: Robot,
    /// TCP at the start, world.
    pub start: Pose,
    /// TCP at the goal, world.
    pub goal: Pose,
    /// Duration of the movement, s.
    pub duration_s: f64,
    /// Limits of the TCP.
    pub limits: PathLimits,
    /// How near the robot may come to the person.
    pub person_margin: PersonMargin,
    /// Limits that are defaults, in words.
    pub assumed_limits: Vec<String>,
    /// What the robot must not touch.
    pub obstacles: Vec<(String, Obstacle)>,
    /// Those of them that are meshes; of each, the parts stand in `obstacles` under its name.
    pub meshes: Vec<ObstacleMesh>,
    /// Load, repetition, coupling.
    pub task: Task,
    /// The designer's own recorded paths.
    pub paths: Vec<UserPath>,
    /// The designer's own via-points.
    pub drawn: Vec<Candidate>,
    /// What the planner may choose besides the path.
    pub free: Freedoms,
    /// What the reader should know.
    pub warnings: Vec<Warning>,
}

pub(super) fn resolve(
    source: &Source,
    file: ScenarioFile,
    sha256: String,
) -> Result<Scenario, InputError> {
    if file.schema.get_ref() != SCENARIO_SCHEMA {
        return Err(source
            .error(&file.schema, format!("schema is not `{SCENARIO_SCHEMA}`"))
            .remedy("this program reads that version only"));
    }
    let mut warnings = Vec::new();
    let robot = resolve_robot(source, &file.robot)?;
    let (limits, mut assumed_limits) =
        resolve_limits(source, &file.limits, file.workspace.as_ref())?;
    let person_margin = resolve_person_margin(source, &file.limits, &mut assumed_limits)?;
    if file.description.chars().count() > LONGEST_DESCRIPTION {
        let message = format!("description has more than {LONGEST_DESCRIPTION} characters");
        return Err(source.plain(message).remedy("say in a paragraph what the scenario is about"));
    }
    if let Some(fault) = name_fault(file.name.get_ref()) {
        return Err(source.error(&file.name, format!("the scenario's name {fault}")).remedy(NAME));
    }
    let worker = resolve_worker(source, &file.worker)?;
    let held = Held::resolve(source, (&file.grip, &file.start), (worker.hands, worker.facing))?;
    let (start, goal) = (held.start, held.pose(source, &file.goal, "goal")?);
    let score_profile = resolve_profile(source, file.score_profile.as_ref())?;
    let free = resolve_free(source, &file.free, &held, &goal)?;
    refuse_no_movement(source, &file, [&start, &goal], &free)?;
    let duration_s = resolve_duration(source, &file.motion.duration_s, &free)?;
    let (paths, drawn_paths) = resolve_paths(source, &file.path, &robot, [&start, &goal])?;
    let task = resolve_task(source, &file.task, &free, duration_s)?;
    if task.part_mass_kg > 0.0 && file.task.human_load_share.is_none() {
        warnings.push(Warning::WholeLoad { mass_kg: task.part_mass_kg });
    }
    let (obstacles, meshes) = resolve_obstacles(source, &file.obstacle)?;
    let doubtful = |doubt: Doubt| Warning::Doubtful { path: None, doubt };
    warnings.extend(source.doubts.take().into_iter().map(doubtful));
    warnings.extend(paths.iter().flat_map(UserPath::warnings));
    let mut scenario = Scenario {
        name: file.name.into_inner(),
        description: file.description,
        file: source.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        sha256,
        seed: file.seed,
        score_profile,
        worker,
        grip: held.grip,
        hold: held.hold,
        second_hand: held.second_hand,
        robot,
        start,
        goal,
        duration_s,
        limits,
        person_margin,
        assumed_limits,
        obstacles,
        meshes,
        task,
        paths,
        drawn: drawn_paths,
        free,
        warnings,
    };
    scenario.refuse_worker_inside(source, &file.worker.at_m)?;
    scenario.warnings.extend(scenario.faces_away().map(Warning::FacesAway));
    if scenario.worker.model.modes.is_some() && scenario.free.moves_worker() {
        scenario.worker.adaptations.push(Adaptation::OneWay);
    }
    let adapted = scenario.worker.adaptations.iter().copied().map(Warning::Adapted);
    scenario.warnings.extend(adapted);
    if scenario.worker.model.seal == Seal::Missing {
        let file = file.worker.posture_model.get_ref().clone();
        scenario.warnings.push(Warning::NoChecksum { file });
    }
    let others = scenario.worker.bodies.iter().filter(|b| b.is_other());
    let others: Vec<Warning> =
        others.map(|b| Warning::OtherBody { body: b.name.clone() }).collect();
    scenario.warnings.extend(others);
    Ok(scenario)
}

/// A worker who faces away from the task, as one does with a wrong sign in the file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FacesAway {
    /// Angle past the middle of the task, deg.
    pub off_deg: f64,
    /// `worker.facing_deg` that looks at it.
    pub wanted_deg: f64,
}

/// An end of the movement so low that a standing worker bends the legs for it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LowHand {
    /// The lower end.
    pub end: End,
    /// Its height over the floor, m.
    pub height_m: f64,
}

/// Height of the hand below which a standing worker bends the legs, m.
const LOW_HAND_M: f64 = 0.55;

impl Scenario {
    /// The lower end, where it is too low for straight legs.
    pub fn low_hand(&self) -> Option<LowHand> {
        let is_standing = matches!(self.worker.stance, Stance::Standing { .. })
            && self.worker.pelvis == Pelvis::Rests;
        let ends = [(End::Start, &self.start), (End::Goal, &self.goal)];
        let heights = ends.map(|(end, tcp)| LowHand { end, height_m: tcp.translation.vector.z });
        let [start, goal] = heights;
        let lowest = if goal.height_m < start.height_m { goal } else { start };
        (is_standing && lowest.height_m < LOW_HAND_M).then_some(lowest)
    }

    /// Whether the worker looks past the task.
    pub fn faces_away(&self) -> Option<FacesAway> {
        let w = &self.worker;
        let middle = (self.start.translation.vector + self.goal.translation.vector) * 0.5;
        let (x, y) = (middle.x - w.at_m[0], middle.y - w.at_m[1]);
        let wanted = y.atan2(x);
        let off = (wanted - w.facing).sin().atan2((wanted - w.facing).cos()).abs();
        let away = FacesAway { off_deg: off.to_degrees(), wanted_deg: wanted.to_degrees() };
        (x.hypot(y) > LEAST_AHEAD_M && away.off_deg > MOST_TURNED_DEG).then_some(away)
    }

    /// Something solid where the worker's legs and pelvis are: nobody can stand or sit there.
    fn refuse_worker_inside(
        &self,
        source: &Source,
        at: &Spanned<[f64; 2]>,
    ) -> Result<(), InputError> {
        let w = &self.worker;
        let Some(body) = w.bodies.first() else { return Ok(()) };
        let hip = body.pelvis_pose(w.at_m, w.facing, w.stance).translation.vector;
        // Standing the whole leg, seated what is above the seat.
        let low = match w.stance {
            Stance::Standing { .. } => 0.1,
            Stance::Seated { .. } => hip.z,
        };
        let places = (0..=AXIS_LOOKS).map(|i| {
            let z = low + (hip.z - low) * f64::from(i) / f64::from(AXIS_LOOKS);
            Vec3::new(hip.x, hip.y, z)
        });
        let places: Vec<Vec3> = places.collect();
        for (name, obstacle) in &self.obstacles {
            if places.iter().any(|p| obstacle.signed_distance(p) < 0.0) {
                let what =
                    if matches!(w.stance, Stance::Seated { .. }) { "sits" } else { "stands" };
                let message = format!("the worker {what} inside obstacle `{name}`");
                return Err(source.error(at, message).remedy(
                    "move worker.at_m, or the obstacle: position_m is its middle, size_m its whole widths",
                ));
            }
        }
        Ok(())
    }
}

fn resolve_profile(source: &Source, name: Option<&Spanned<String>>) -> Result<Profile, InputError> {
    let Some(name) = name else { return Ok(Profile::default()) };
    Profile::by_name(name.get_ref()).ok_or_else(|| {
        let known = Profile::names();
        let help = suggest(name.get_ref(), known.iter().copied())
            .unwrap_or_else(|| format!("profiles: {}", known.join(", ")));
        let message = format!("score_profile = \"{}\" is not known", name.get_ref());
        source.error(name, message).remedy(help)
    })
}

/// Start and goal at one place and turned alike, with nothing free that could part them.
fn refuse_no_movement(
    source: &Source,
    file: &ScenarioFile,
    [start, goal]: [&Pose; 2],
    free: &Freedoms,
) -> Result<(), InputError> {
    let way = (goal.translation.vector - start.translation.vector).norm();
    let turn = goal.rotation.angle_to(&start.rotation).to_degrees();
    let may_part = free.all.iter().any(|(f, _)| {
        !matches!(
            f,
            Freedom::Duration | Freedom::Dwell | Freedom::WorkerOffset(_) | Freedom::WorkerFacing
        )
    });
    if way >= LEAST_WAY_M || turn >= LEAST_TURN_DEG || may_part {
        return Ok(());
    }
    Err(source
        .error(&file.goal, "the goal is the start: there is no movement")
        .remedy("give the goal another position_m or orientation"))
}

/// The duration, moved into the range that is free.
fn resolve_duration(
    source: &Source,
    given: &Spanned<f64>,
    free: &Freedoms,
) -> Result<f64, InputError> {
    let value = *given.get_ref();
    if value > LONGEST_S {
        let doubt = Doubt::Milliseconds { place: "motion.duration_s".to_owned(), value };
        return Err(source.at(given, source.question(&doubt)));
    }
    let given_s = source.number(given, "motion.duration_s", DURATION_S.low, LONGEST_S)?;
    let Some([low, high]) = free.range(Freedom::Duration) else { return Ok(given_s) };
    let taken_s = given_s.clamp(low, high);
    if taken_s.to_bits() != given_s.to_bits() {
        source.doubt(Some(Doubt::DurationOutsideRange { given_s, taken_s }));
    }
    Ok(taken_s)
}

/// The designer's own paths: those in files and those drawn by via-points.
fn resolve_paths(
    source: &Source,
    entries: &[Spanned<PathFile>],
    robot: &Robot,
    ends: [&Pose; 2],
) -> Result<(Vec<UserPath>, Vec<Candidate>), InputError> {
    let (mut paths, mut drawn_paths) = (Vec::new(), Vec::new());
    for (i, entry) in entries.iter().enumerate() {
        let path = entry.get_ref();
        if let Some(fault) = path_name_fault(&path.name) {
            let shown: String =
                path.name.chars().filter(|c| !c.is_control()).take(SHOWN_OF_NAME).collect();
            let message = format!("path `{shown}`: the name {fault}");
            return Err(source.error(entry, message).remedy(NAME));
        }
        if entries[..i].iter().any(|e| e.get_ref().name == path.name) {
            let message = format!("there are two paths named `{}`", path.name);
            return Err(source.error(entry, message).remedy("rename one of them"));
        }
        match (&path.file, &path.via_m) {
            (Some(name), None) => {
                let read = read_user_path(&path.name, &source.folder.join(name), robot, Some(ends));
                paths.push(read.map_err(|e| source.named(entry, "path.file", e))?);
            }
            (None, Some(via)) => {
                for point in via {
                    source.refuse_far("path.via_m", point).map_err(|e| source.at(entry, e))?;
                    let from = |end: &Pose| (Vec3::from(*point) - end.translation.vector).norm();
                    let value = from(ends[0]).min(from(ends[1]));
                    if !SAME_CELL_M.holds(value) {
                        let doubt = Doubt::FarPlace { place: "path.via_m".to_owned(), value };
                        return Err(source.at(entry, source.question(&doubt)));
                    }
                }
                let via: Vec<Vec3> = via.iter().map(|v| Vec3::from(*v)).collect();
                let candidate = drawn(&path.name, &via, ends[0], ends[1])
                    .map_err(|e| source.error(entry, format!("path `{}`: {e}", path.name)))?;
                drawn_paths.push(candidate);
            }
            _ => {
                let message = format!("path `{}` needs either file or via_m", path.name);
                return Err(source.error(entry, message).remedy("keep one of them"));
            }
        }
    }
    Ok((paths, drawn_paths))
}

fn resolve_obstacles(
    source: &Source,
    entries: &[Spanned<ObstacleFile>],
) -> Result<(Named, Vec<ObstacleMesh>), InputError> {
    let mut all = Named::new();
    let mut meshes = Vec::new();
    for entry in entries {
        let (own, mesh) = resolve_obstacle(source, entry)?;
        if let Some((name, _)) = own.first().filter(|(name, _)| all.iter().any(|(n, _)| n == name))
        {
            let message = format!("there are two obstacles named `{name}`");
            return Err(source.error(entry, message).remedy("rename one of them"));
        }
        all.extend(own);
        meshes.extend(mesh);
    }
    Ok((all, meshes))
}

fn resolve_task(
    source: &Source,
    file: &TaskFile,
    free: &Freedoms,
    duration_s: f64,
) -> Result<Task, InputError> {
    let task = Task::new(file);
    let at = file.part_mass_kg.as_ref().or(file.extra_load_kg.as_ref());
    if let (Some(at), Some(doubt)) =
        (at, plausible::load(task.part_mass_kg, task.load_kg, task.extra_load_kg))
    {
        match doubt {
            Doubt::HeavyPart { .. } => source.doubt(Some(doubt)),
            _ => return Err(source.at(at, source.question(&doubt))),
        }
    }
    check_task(source, file)?;
    // The quickest movement that may be chosen, and the hold, have to fit into a cycle.
    let least_s = free.range(Freedom::Duration).map_or(duration_s, |[low, _]| low);
    let parts = [("the movement", least_s), ("task.hold_s", task.hold_s.unwrap_or(0.0))];
    for (place, needed_s) in parts {
        if let Some(cycles_per_min) =
            task.cycles_per_min.filter(|c| c * needed_s > MOST_OF_A_MINUTE_S)
        {
            let place = place.to_owned();
            source.doubt(Some(Doubt::Cycles { cycles_per_min, place, needed_s }));
        }
    }
    Ok(task)
}

fn check_task(source: &Source, task: &TaskFile) -> Result<(), InputError> {
    let checks = [
        (&task.part_mass_kg, "task.part_mass_kg", 200.0),
        (&task.human_load_share, "task.human_load_share", 1.0),
        (&task.extra_load_kg, "task.extra_load_kg", 200.0),
        (&task.cycles_per_min, "task.cycles_per_min", 600.0),
        (&task.hold_s, "task.hold_s", 86_400.0),
    ];
    for (value, key, high) in checks {
        if let Some(value) = value {
            source.number(value, key, 0.0, high)?;
        }
    }
    Ok(())
}

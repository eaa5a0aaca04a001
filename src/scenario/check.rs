//! From the file as typed to a scenario with everything resolved: each refusal names key and remedy.

use super::SCENARIO_SCHEMA;
use super::cell::{
    PersonMargin, resolve_grip, resolve_limits, resolve_obstacle, resolve_person_margin,
    resolve_robot,
};
use super::file::{ScenarioFile, TaskFile};
use super::freedom::{Freedoms, resolve_free};
use super::paths::{UserPath, read_user_path};
use super::source::Source;
use super::task::Task;
use super::worker::{Worker, resolve_worker};
use crate::ergonomics::Profile;
use crate::files::{InputError, suggest};
use crate::math::{Pose, Vec3};
use crate::path::{Candidate, PathLimits, drawn};
use crate::posture::Hold;
use crate::robot::{Obstacle, Robot};
use toml::Spanned;

/// Angle between the worker's facing and the task from which it is told.
const MOST_TURNED_DEG: f64 = 60.0;

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
    /// Load, repetition, coupling.
    pub task: Task,
    /// The designer's own recorded paths.
    pub paths: Vec<UserPath>,
    /// The designer's own via-points.
    pub drawn: Vec<Candidate>,
    /// What the planner may choose besides the path.
    pub free: Freedoms,
    /// What the reader should know, one sentence each.
    pub warnings: Vec<String>,
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
    let duration_s = source.number(&file.motion.duration_s, "motion.duration_s", 0.05, 600.0)?;
    let (start, goal) = (source.pose(&file.start, "start")?, source.pose(&file.goal, "goal")?);
    let score_profile = resolve_profile(source, file.score_profile.as_ref())?;
    let free = resolve_free(source, &file.free, &start, &goal)?;
    let (mut paths, mut drawn_paths) = (Vec::new(), Vec::new());
    for entry in &file.path {
        let path = entry.get_ref();
        match (&path.file, &path.via_m) {
            (Some(name), None) => {
                paths.push(read_user_path(&path.name, &source.folder.join(name), &robot)?);
            }
            (None, Some(via)) => {
                let via: Vec<Vec3> = via.iter().map(|v| Vec3::from(*v)).collect();
                let candidate = drawn(&path.name, &via, &start, &goal)
                    .map_err(|e| source.error(entry, format!("path `{}`: {e}", path.name)))?;
                drawn_paths.push(candidate);
            }
            _ => {
                let message = format!("path `{}` needs either file or via_m", path.name);
                return Err(source.error(entry, message));
            }
        }
    }
    check_task(source, &file.task)?;
    let task = Task::new(&file.task);
    if task.part_mass_kg > 0.0 && file.task.human_load_share.is_none() {
        warnings.push(format!(
            "task.human_load_share is not given: the worker is taken to carry the whole {} kg",
            task.part_mass_kg
        ));
    }
    let worker = resolve_worker(source, &file.worker)?;
    warnings.extend(looks_away(&worker, &start, &goal));
    warnings.extend(paths.iter().filter_map(UserPath::warning));
    let grip = resolve_grip(source, &file.grip)?;
    let obstacles: Result<Vec<_>, InputError> =
        file.obstacle.iter().map(|o| resolve_obstacle(source, o)).collect();
    Ok(Scenario {
        name: file.name,
        description: file.description,
        file: source.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        sha256,
        seed: file.seed,
        score_profile,
        worker,
        grip,
        hold: file.grip.hold,
        robot,
        start,
        goal,
        duration_s,
        limits,
        person_margin,
        assumed_limits,
        obstacles: obstacles?,
        task,
        paths,
        drawn: drawn_paths,
        free,
        warnings,
    })
}

/// Whether the worker looks past the task, as one does with a wrong sign in the file.
fn looks_away(worker: &Worker, start: &Pose, goal: &Pose) -> Option<String> {
    let middle = (start.translation.vector + goal.translation.vector) * 0.5;
    let to = (middle.x - worker.at_m[0], middle.y - worker.at_m[1]);
    let wanted = to.1.atan2(to.0);
    let off = (wanted - worker.facing).sin().atan2((wanted - worker.facing).cos());
    (to.0.hypot(to.1) > 0.1 && off.abs().to_degrees() > MOST_TURNED_DEG).then(|| {
        format!(
            "the worker looks {:.0} deg past the middle of the task; worker.facing_deg = {:.0} would look at it",
            off.abs().to_degrees(),
            wanted.to_degrees()
        )
    })
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

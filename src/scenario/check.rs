//! From the file as typed to a scenario with everything resolved: each refusal names key and remedy.

use super::SCENARIO_SCHEMA;
use super::file::{
    GripFile, LimitsFile, NeckRule, ObstacleFile, OtherArm, PoseFile, RobotFile, ScenarioFile,
    StanceFile, TaskFile, WorkerFile, WorkspaceFile,
};
use super::paths::{UserPath, read_user_path};
use super::task::Task;
use crate::files::{InputError, NumericTable};
use crate::human::{Body, Side, Stance};
use crate::math::{Pose, Vec3};
use crate::path::{Box3, Candidate, PathLimits, drawn};
use crate::posture::{Hold, PostureModel, StartRule, load_model};
use crate::robot::{Obstacle, Robot};
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;
use toml::Spanned;

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
    /// What the reader should know, one sentence each.
    pub warnings: Vec<String>,
}

/// The worker of a scenario.
#[derive(Debug, Clone)]
pub struct Worker {
    /// Bodies, the first is the main one.
    pub bodies: Vec<Body>,
    /// The posture model.
    pub model: PostureModel,
    /// SHA-256 of the model's file.
    pub model_sha256: String,
    /// The coupled side.
    pub side: Side,
    /// Standing or seated.
    pub stance: Stance,
    /// Floor point below the pelvis, m.
    pub at_m: [f64; 2],
    /// Facing, rad about world z.
    pub facing: f64,
    /// A backrest supports the trunk.
    pub trunk_supported: bool,
    /// The arm is supported.
    pub arm_supported: bool,
    /// How the start posture is chosen.
    pub start_rule: StartRule,
    /// How the head is held.
    pub neck: NeckRule,
    /// What is known of the other arm.
    pub other_arm: OtherArm,
}

/// The text behind a scenario, for errors that show the place.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub folder: &'a Path,
}

impl Source<'_> {
    fn error<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message).at(self.text, at.span())
    }

    fn plain(&self, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message)
    }

    /// A finite number in a range.
    fn number(&self, at: &Spanned<f64>, key: &str, low: f64, high: f64) -> Result<f64, InputError> {
        let value = *at.get_ref();
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(self
            .error(at, format!("{key} = {value} is outside {low} to {high}"))
            .remedy("check value and unit: metres, seconds, kilograms; degrees only in keys that end in _deg"))
    }

    fn pose(&self, at: &Spanned<PoseFile>, key: &str) -> Result<Pose, InputError> {
        self.pose_of(at.get_ref(), key).map_err(|e| e.at(self.text, at.span()))
    }

    fn pose_of(&self, pose: &PoseFile, key: &str) -> Result<Pose, InputError> {
        let position = Vec3::from(pose.position_m);
        if !position.iter().all(|v| v.abs() < 100.0) {
            let message = format!("{key}.position_m = {:?} is not plausible", pose.position_m);
            return Err(self.plain(message).remedy("positions are in metres"));
        }
        let rotation = self.rotation(pose.rpy_deg, pose.quaternion_wxyz, key)?;
        Ok(Pose::from_parts(position.into(), rotation))
    }

    fn rotation(
        &self,
        rpy_deg: Option<[f64; 3]>,
        quaternion: Option<[f64; 4]>,
        key: &str,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        match (rpy_deg, quaternion) {
            (Some(_), Some(_)) => Err(self
                .plain(format!("{key} has both rpy_deg and quaternion_wxyz"))
                .remedy("keep one of them")),
            (Some(rpy), None) => {
                if !rpy.iter().all(|v| v.abs() <= 720.0) {
                    let message = format!("{key}.rpy_deg = {rpy:?} is not plausible");
                    return Err(self.plain(message).remedy("angles are in degrees"));
                }
                let [r, p, y] = rpy.map(f64::to_radians);
                Ok(UnitQuaternion::from_euler_angles(r, p, y))
            }
            (None, Some([w, x, y, z])) => {
                let q = Quaternion::new(w, x, y, z);
                if !(0.99..=1.01).contains(&q.norm()) {
                    let message = format!("{key}.quaternion_wxyz has norm {:.4}, not 1", q.norm());
                    return Err(self.plain(message).remedy("the scalar part w comes first"));
                }
                Ok(UnitQuaternion::new_normalize(q))
            }
            (None, None) => Ok(UnitQuaternion::identity()),
        }
    }
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
    let (limits, assumed_limits) = resolve_limits(source, &file.limits, file.workspace.as_ref())?;
    let duration_s = source.number(&file.motion.duration_s, "motion.duration_s", 0.05, 600.0)?;
    let (start, goal) = (source.pose(&file.start, "start")?, source.pose(&file.goal, "goal")?);
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
    let grip = resolve_grip(source, &file.grip)?;
    let obstacles: Result<Vec<_>, InputError> =
        file.obstacle.iter().map(|o| resolve_obstacle(source, o)).collect();
    Ok(Scenario {
        name: file.name,
        description: file.description,
        file: source.path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        sha256,
        seed: file.seed,
        worker,
        grip,
        hold: file.grip.hold,
        robot,
        start,
        goal,
        duration_s,
        limits,
        assumed_limits,
        obstacles: obstacles?,
        task,
        paths,
        drawn: drawn_paths,
        warnings,
    })
}

fn resolve_worker(source: &Source, file: &WorkerFile) -> Result<Worker, InputError> {
    let names = file.bodies.get_ref();
    if names.is_empty() {
        return Err(source
            .error(&file.bodies, "worker.bodies is empty")
            .remedy("name at least one"));
    }
    let bodies: Result<Vec<Body>, InputError> =
        names.iter().map(|n| Body::load(n, source.folder)).collect();
    let bodies = bodies?;
    let (model, model_sha256) = load_model(&file.posture_model, source.folder)?;
    if model.side != file.side {
        return Err(source
            .plain(format!(
                "posture model `{}` was learned on the {:?} arm, the scenario couples the {:?} hand",
                file.posture_model, model.side, file.side
            ))
            .remedy("set worker.side, or train a model for this side"));
    }
    let stance = match (file.stance, file.seat_height_m) {
        (StanceFile::Standing, None) => {
            if !(0.0..=0.3).contains(&file.shoe_m) {
                let message = format!("worker.shoe_m = {} is outside 0 to 0.3", file.shoe_m);
                return Err(source.plain(message));
            }
            Stance::Standing { shoe_m: file.shoe_m }
        }
        (StanceFile::Seated, Some(h)) if (0.1..=1.2).contains(&h) => {
            Stance::Seated { seat_height_m: h }
        }
        (StanceFile::Seated, Some(h)) => {
            return Err(source.plain(format!("worker.seat_height_m = {h} is outside 0.1 to 1.2")));
        }
        (StanceFile::Seated, None) => {
            return Err(source
                .plain("worker.stance is seated, but worker.seat_height_m is missing")
                .remedy(
                    "give the height of the seat in metres, for example seat_height_m = 0.45",
                ));
        }
        (StanceFile::Standing, Some(_)) => {
            return Err(source
                .plain("worker.seat_height_m is given, but worker.stance is standing")
                .remedy("remove it, or set stance = \"seated\""));
        }
    };
    let at = file.at_m.get_ref();
    if !at.iter().all(|v| v.abs() < 100.0) {
        return Err(source.error(&file.at_m, format!("worker.at_m = {at:?} is not plausible")));
    }
    let facing = source.number(&file.facing_deg, "worker.facing_deg", -720.0, 720.0)?;
    let start_rule = match file.start_posture.0.as_str() {
        "sampled" => StartRule::Sampled,
        "mean" => StartRule::Mean,
        name => given_posture(source, &bodies, file.side, name)?,
    };
    Ok(Worker {
        bodies,
        model,
        model_sha256,
        side: file.side,
        stance,
        at_m: *at,
        facing: facing.to_radians(),
        trunk_supported: file.trunk_supported,
        arm_supported: file.arm_supported,
        start_rule,
        neck: file.neck,
        other_arm: file.other_arm,
    })
}

/// A start posture from a CSV with one row of joint angles (rad), named as the joints.
fn given_posture(
    source: &Source,
    bodies: &[Body],
    side: Side,
    name: &str,
) -> Result<StartRule, InputError> {
    if !Path::new(name).extension().is_some_and(|x| x.eq_ignore_ascii_case("csv")) {
        return Err(source
            .plain(format!("worker.start_posture = \"{name}\" is not known"))
            .remedy("use \"sampled\", \"mean\", or the name of a CSV file of joint angles"));
    }
    let table = NumericTable::read(&source.folder.join(name))?;
    let arm = bodies[0].arm(side)?;
    let values: Result<Vec<f64>, InputError> = arm
        .joints()
        .iter()
        .map(|j| {
            let with_unit = format!("{}_rad", j.name);
            let key = if table.columns.contains(&with_unit) { &with_unit } else { &j.name };
            Ok(table.rows[0][table.index(key)?])
        })
        .collect();
    Ok(StartRule::Given(values?))
}

fn resolve_grip(source: &Source, file: &GripFile) -> Result<Pose, InputError> {
    let pose = PoseFile {
        position_m: file.position_m.unwrap_or_default(),
        rpy_deg: file.rpy_deg,
        quaternion_wxyz: file.quaternion_wxyz,
    };
    source.pose_of(&pose, "grip")
}

fn resolve_robot(source: &Source, file: &RobotFile) -> Result<Robot, InputError> {
    let mut robot = match (&file.preset, &file.urdf) {
        (Some(preset), None) => Robot::preset(preset)?,
        (None, Some(urdf)) => {
            let (Some(base), Some(tcp)) = (&file.base_link, &file.tcp) else {
                return Err(source
                    .plain("robot.urdf needs robot.base_link and robot.tcp")
                    .remedy("name the first and the last link of the robot's chain"));
            };
            Robot::from_urdf(&source.folder.join(urdf), base, tcp)?
        }
        _ => {
            return Err(source
                .plain("robot needs either preset or urdf")
                .remedy("for example preset = \"panda\""));
        }
    };
    robot.base = source.pose(&file.base, "robot.base")?;
    for limit in &file.limit {
        let joint = &limit.joint;
        if limit.lower_rad.is_some() || limit.upper_rad.is_some() {
            let i = robot.joint_index(joint)?;
            let lower = limit.lower_rad.unwrap_or(robot.limits.lower[i]);
            let upper = limit.upper_rad.unwrap_or(robot.limits.upper[i]);
            robot.set_position_limit(joint, lower, upper)?;
        }
        if let Some(v) = limit.velocity_rad_s {
            robot.set_velocity_limit(joint, v)?;
        }
        if let Some(a) = limit.acceleration_rad_s2 {
            robot.set_acceleration_limit(joint, a)?;
        }
    }
    Ok(robot)
}

fn resolve_limits(
    source: &Source,
    file: &LimitsFile,
    workspace: Option<&Spanned<WorkspaceFile>>,
) -> Result<(PathLimits, Vec<String>), InputError> {
    let mut limits = PathLimits::default();
    let mut assumed = Vec::new();
    let mut take = |given: &Option<Spanned<f64>>,
                    key: &str,
                    high: f64,
                    scale: f64,
                    slot: &mut f64,
                    unit: &str| {
        match given {
            Some(value) => {
                *slot = source.number(value, &format!("limits.{key}"), 1e-3, high)? * scale;
            }
            None => assumed.push(format!("{key} = {:.4} {unit}", *slot / scale)),
        }
        Ok::<(), InputError>(())
    };
    let rad = std::f64::consts::PI / 180.0;
    take(&file.speed_m_s, "speed_m_s", 5.0, 1.0, &mut limits.speed_m_s, "m/s")?;
    take(
        &file.acceleration_m_s2,
        "acceleration_m_s2",
        50.0,
        1.0,
        &mut limits.acceleration_m_s2,
        "m/s^2",
    )?;
    take(&file.jerk_m_s3, "jerk_m_s3", 1e4, 1.0, &mut limits.jerk_m_s3, "m/s^3")?;
    take(
        &file.angular_speed_deg_s,
        "angular_speed_deg_s",
        720.0,
        rad,
        &mut limits.angular_speed_rad_s,
        "deg/s",
    )?;
    take(
        &file.angular_acceleration_deg_s2,
        "angular_acceleration_deg_s2",
        5000.0,
        rad,
        &mut limits.angular_acceleration_rad_s2,
        "deg/s^2",
    )?;
    if let Some(at) = workspace {
        let WorkspaceFile { min_m, max_m } = at.get_ref();
        let is_box = (0..3).all(|i| min_m[i] < max_m[i] && max_m[i] - min_m[i] < 100.0);
        if !is_box {
            let message = format!("workspace: min_m {min_m:?} must be below max_m {max_m:?}");
            return Err(source.error(at, message));
        }
        limits.workspace = Some(Box3 { min: Vec3::from(*min_m), max: Vec3::from(*max_m) });
    }
    Ok((limits, assumed))
}

fn resolve_obstacle(
    source: &Source,
    at: &Spanned<ObstacleFile>,
) -> Result<(String, Obstacle), InputError> {
    let pose = |position: &[f64; 3], rpy: &[f64; 3], name: &str| {
        let file = PoseFile { position_m: *position, rpy_deg: Some(*rpy), quaternion_wxyz: None };
        source.pose_of(&file, &format!("obstacle `{name}`"))
    };
    let positive = |values: &[f64], name: &str| {
        if values.iter().all(|v| *v > 0.0 && *v < 100.0) {
            return Ok(());
        }
        Err(source
            .error(at, format!("obstacle `{name}`: sizes must be above 0 m, found {values:?}")))
    };
    Ok(match at.get_ref() {
        ObstacleFile::Box { name, position_m, rpy_deg, size_m } => {
            positive(size_m, name)?;
            let pose = pose(position_m, rpy_deg, name)?;
            (name.clone(), Obstacle::Box { pose, size: Vec3::from(*size_m) })
        }
        ObstacleFile::Sphere { name, position_m, radius_m } => {
            positive(&[*radius_m], name)?;
            let center = pose(position_m, &[0.0; 3], name)?.translation.vector;
            (name.clone(), Obstacle::Sphere { center, radius: *radius_m })
        }
        ObstacleFile::Capsule { name, from_m, to_m, radius_m } => {
            positive(&[*radius_m], name)?;
            let a = pose(from_m, &[0.0; 3], name)?.translation.vector;
            let b = pose(to_m, &[0.0; 3], name)?.translation.vector;
            (name.clone(), Obstacle::Capsule { a, b, radius: *radius_m })
        }
        ObstacleFile::Cylinder { name, position_m, rpy_deg, radius_m, length_m } => {
            positive(&[*radius_m, *length_m], name)?;
            let pose = pose(position_m, rpy_deg, name)?;
            (name.clone(), Obstacle::Cylinder { pose, radius: *radius_m, length: *length_m })
        }
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

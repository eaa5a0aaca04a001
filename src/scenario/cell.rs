//! Robot, grip, limits and obstacles of the cell.

use super::file::{
    BaseFile, Direction, JointLimitFile, LimitsFile, ObstacleFile, RobotFile, WorkspaceFile,
};
use super::mesh::ObstacleMesh;
use super::orientation::{About, Turned};
use super::plausible::name_fault;
use super::source::Source;
use crate::files::InputError;
use crate::math::{Pose, Vec3};
use crate::mesh::Polytope;
use crate::path::{Box3, PathLimits};
use crate::physical::OBSTACLE_M;
use crate::robot::{Obstacle, Robot};
use std::sync::Arc;
use toml::Spanned;

/// Remedy for a name.
pub(super) const NAME: &str = "use a short name of letters, digits, spaces, `-` and `_`";

pub(super) fn resolve_robot(source: &Source, file: &RobotFile) -> Result<Robot, InputError> {
    let mut robot = match (&file.preset, &file.urdf) {
        (Some(preset), None) => {
            for (key, other) in [("base_link", &file.base_link), ("tcp", &file.tcp)] {
                if other.is_some() {
                    let message = format!("robot.preset and robot.{key} are both given");
                    return Err(source
                        .error(preset, message)
                        .remedy("a preset has its own links: remove one of the two"));
                }
            }
            Robot::preset(preset.get_ref()).map_err(|e| source.named(preset, "robot.preset", e))?
        }
        (None, Some(urdf)) => {
            let (Some(base), Some(tcp)) = (&file.base_link, &file.tcp) else {
                return Err(source
                    .error(urdf, "robot.urdf needs robot.base_link and robot.tcp")
                    .remedy("name the first and the last link of the robot's chain"));
            };
            Robot::from_urdf(&source.folder.join(urdf.get_ref()), base, tcp)
                .map_err(|e| source.named(urdf, "robot.urdf", e))?
        }
        _ => {
            return Err(source
                .plain("robot needs either preset or urdf")
                .remedy("for example preset = \"panda\""));
        }
    };
    robot.base = base(source, &file.base)?;
    for (i, at) in file.limit.iter().enumerate() {
        if file.limit[..i].iter().any(|l| l.get_ref().joint == at.get_ref().joint) {
            let message = format!("joint `{}` has two [[robot.limit]]", at.get_ref().joint);
            return Err(source.error(at, message).remedy("keep one, with all its limits"));
        }
        set_limit(&mut robot, at.get_ref())
            .map_err(|e| e.named_in(source.path, "robot.limit", source.text, at.span()))?;
    }
    Ok(robot)
}

/// Where the robot stands.
fn base(source: &Source, at: &Spanned<BaseFile>) -> Result<Pose, InputError> {
    let file = at.get_ref();
    let refused = |message: &str, remedy: &str| Err(source.error(at, message).remedy(remedy));
    let place = match (file.position_m, file.at_m, file.mount_height_m) {
        (Some(place), None, None) => place,
        (None, Some([x, y]), Some(z)) => [x, y, z],
        (Some(_), ..) => {
            return refused(
                "robot.base has position_m, and at_m or mount_height_m",
                "keep position_m, or at_m with mount_height_m",
            );
        }
        (None, Some(_), None) => {
            return refused(
                "robot.base has at_m without mount_height_m",
                "give the height of the robot's mounting face above the floor, in metres",
            );
        }
        (None, None, _) => {
            return refused(
                "robot.base has no place",
                "give position_m, or at_m and mount_height_m: for example at_m = [0.9, 0.0], mount_height_m = 0.75",
            );
        }
    };
    source.refuse_far("robot.base", &place).map_err(|e| source.at(at, e))?;
    let mut turned = Turned::from(file);
    // What stands upright needs one direction only.
    let up = Spanned::new(turned.x_along.map_or(0..0, Spanned::span), [0.0, 0.0, 1.0]);
    if turned.x_along.is_some() && turned.pointing.is_none() {
        turned.pointing = Some(&up);
    }
    let about = About::Said("x_along, where the base's x axis points");
    let turn = source.rotation(&turned, "robot.base", about).map_err(|e| source.beside(at, e))?;
    Ok(Pose::from_parts(Vec3::from(place).into(), turn.unwrap_or_default()))
}

/// Another limit of one joint.
fn set_limit(robot: &mut Robot, limit: &JointLimitFile) -> Result<(), InputError> {
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
    Ok(())
}

pub(super) fn resolve_limits(
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
    match &file.clearance_m {
        Some(value) => limits.clearance_m = source.number(value, "limits.clearance_m", 0.0, 1.0)?,
        None => assumed.push(format!("clearance_m = {:.4} m", limits.clearance_m)),
    }
    if let Some(value) = &file.corridor_m {
        limits.corridor_m = Some(source.number(value, "limits.corridor_m", 1e-3, 10.0)?);
    }
    if let Some(at) = workspace {
        let WorkspaceFile { min_m, max_m } = at.get_ref();
        source.refuse_far("workspace.min_m", min_m).map_err(|e| source.at(at, e))?;
        source.refuse_far("workspace.max_m", max_m).map_err(|e| source.at(at, e))?;
        let is_box = (0..3).all(|i| min_m[i] < max_m[i]);
        if !is_box {
            let message = format!("workspace: min_m {min_m:?} must be below max_m {max_m:?}");
            return Err(source.error(at, message));
        }
        limits.workspace = Some(Box3 { min: Vec3::from(*min_m), max: Vec3::from(*max_m) });
    }
    Ok((limits, assumed))
}

/// How near the robot may come to the person: a planning margin, not a safety function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PersonMargin {
    /// Distance that is kept, m.
    pub margin_m: f64,
    /// Share of the repetitions in which it may be broken.
    pub share: f64,
}

impl Default for PersonMargin {
    fn default() -> Self {
        Self { margin_m: 0.05, share: 0.05 }
    }
}

/// The margin to the person; what is left out is assumed.
pub(super) fn resolve_person_margin(
    source: &Source,
    file: &LimitsFile,
    assumed: &mut Vec<String>,
) -> Result<PersonMargin, InputError> {
    let mut person = PersonMargin::default();
    match &file.person_clearance_m {
        Some(at) => {
            person.margin_m = source.number(at, "limits.person_clearance_m", 0.0, 1.0)?;
        }
        None => assumed.push(format!(
            "person_clearance_m = {} m (a planning margin, not a safety distance)",
            person.margin_m
        )),
    }
    match &file.person_clearance_share {
        Some(at) => {
            person.share = source.number(at, "limits.person_clearance_share", 0.0, 1.0)?;
        }
        None => assumed.push(format!(
            "person_clearance_share = {} of the repetitions may come nearer",
            person.share
        )),
    }
    Ok(person)
}

/// Obstacles by name.
pub(super) type Named = Vec<(String, Obstacle)>;

/// An obstacle, or the convex parts of one that is a mesh, under one name.
pub(super) fn resolve_obstacle(
    source: &Source,
    at: &Spanned<ObstacleFile>,
) -> Result<(Named, Option<ObstacleMesh>), InputError> {
    let place = |position: &[f64; 3], name: &str| {
        let key = format!("obstacle `{name}`.position_m");
        source.refuse_far(&key, position).map_err(|e| source.at(at, e))?;
        Ok::<_, InputError>(Vec3::from(*position))
    };
    let direction = |given: &Option<[f64; 3]>| given.map(|d| Direction::new(at.span(), d));
    let turn = |rpy_deg: Option<[f64; 3]>, along: [Option<Direction>; 2], about, name: &str| {
        let [pointing, x_along] = &along;
        let (pointing, x_along) = (pointing.as_ref(), x_along.as_ref());
        let turned = Turned { rpy_deg, pointing, x_along, ..Turned::default() };
        let turn = source.rotation(&turned, &format!("obstacle `{name}`"), about);
        Ok::<_, InputError>(turn.map_err(|e| source.beside(at, e))?.unwrap_or_default())
    };
    let positive = |values: &[f64], name: &str| {
        if OBSTACLE_M.outside(values.iter().copied()).is_none() {
            return Ok(());
        }
        let message = format!("obstacle `{name}`: sizes must be {OBSTACLE_M}, found {values:?}");
        Err(source.error(at, message).remedy("give whole widths, lengths and radii in metres"))
    };
    let name = match at.get_ref() {
        ObstacleFile::Box { name, .. }
        | ObstacleFile::Sphere { name, .. }
        | ObstacleFile::Capsule { name, .. }
        | ObstacleFile::Cylinder { name, .. }
        | ObstacleFile::Mesh { name, .. } => name,
    };
    if let Some(fault) = name_fault(name) {
        return Err(source.error(at, format!("the name of an obstacle {fault}")).remedy(NAME));
    }
    let simple = match at.get_ref() {
        ObstacleFile::Mesh { name, file, units, position_m, rpy_deg, pointing, x_along } => {
            let about = About::Said("x_along, where the x axis of the mesh points");
            let turn = turn(*rpy_deg, [direction(pointing), direction(x_along)], about, name)?;
            let origin = place(&position_m.unwrap_or_default(), name)?;
            let pose = Pose::from_parts(origin.into(), turn);
            let mesh = ObstacleMesh::read(source, at, (name, file), (*units, &pose))?;
            let part = |p: &Polytope| (name.clone(), Obstacle::Hull(Arc::new(p.clone())));
            return Ok((mesh.parts.iter().map(part).collect(), Some(mesh)));
        }
        ObstacleFile::Box { name, position_m, rpy_deg, pointing, x_along, size_m } => {
            positive(size_m, name)?;
            let about = About::Said("x_along, where the box's x axis points");
            let turn = turn(*rpy_deg, [direction(pointing), direction(x_along)], about, name)?;
            let pose = Pose::from_parts(place(position_m, name)?.into(), turn);
            (name.clone(), Obstacle::Box { pose, size: Vec3::from(*size_m) })
        }
        ObstacleFile::Sphere { name, position_m, radius_m } => {
            positive(&[*radius_m], name)?;
            let center = place(position_m, name)?;
            (name.clone(), Obstacle::Sphere { center, radius: *radius_m })
        }
        ObstacleFile::Capsule { name, from_m, to_m, radius_m } => {
            positive(&[*radius_m], name)?;
            let (a, b) = (place(from_m, name)?, place(to_m, name)?);
            (name.clone(), Obstacle::Capsule { a, b, radius: *radius_m })
        }
        ObstacleFile::Cylinder { name, position_m, rpy_deg, pointing, radius_m, length_m } => {
            positive(&[*radius_m, *length_m], name)?;
            // A cylinder looks the same however it is turned about its own axis.
            let turn = turn(*rpy_deg, [direction(pointing), None], About::Ahead(Vec3::x()), name)?;
            let pose = Pose::from_parts(place(position_m, name)?.into(), turn);
            (name.clone(), Obstacle::Cylinder { pose, radius: *radius_m, length: *length_m })
        }
    };
    Ok((vec![simple], None))
}

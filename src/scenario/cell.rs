//! Robot, grip, limits and obstacles of the cell.

use super::file::{
    GripFile, HandGripFile, JointLimitFile, LimitsFile, ObstacleFile, PoseFile, RobotFile,
    WorkspaceFile,
};
use super::plausible::name_fault;
use super::source::Source;
use crate::files::InputError;
use crate::human::Hands;
use crate::math::{Pose, Vec3};
use crate::path::{Box3, PathLimits};
use crate::posture::Hold;
use crate::robot::{Obstacle, Robot};
use toml::Spanned;

/// Remedy for a name.
pub(super) const NAME: &str = "use a short name of letters, digits, spaces, `-` and `_`";
/// Smallest size of an obstacle, m: a wire.
const SMALLEST_M: f64 = 1e-3;

/// The other hand where both hold on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondHand {
    /// Its grip in the frame of the leading hand's grip.
    pub between: Pose,
    /// What the robot prescribes of it.
    pub hold: Hold,
}

/// The leading hand's grip and hold, and the other hand's where both hold on.
pub(super) fn resolve_grip(
    source: &Source,
    file: &GripFile,
    hands: Hands,
) -> Result<(Pose, Hold, Option<SecondHand>), InputError> {
    let pose = |position: Option<[f64; 3]>, rpy_deg, quaternion_wxyz, name: &str| {
        let position_m = position.unwrap_or_default();
        source.pose_of(&PoseFile { position_m, rpy_deg, quaternion_wxyz }, name)
    };
    let of = |hand: &HandGripFile, name: &str| {
        pose(hand.position_m, hand.rpy_deg, hand.quaternion_wxyz, name)
    };
    let has_own =
        file.position_m.is_some() || file.rpy_deg.is_some() || file.quaternion_wxyz.is_some();
    match (hands, &file.right, &file.left) {
        (Hands::Both, Some(right), Some(left)) => {
            if has_own || file.hold.is_some() {
                return Err(source
                    .plain("worker.hands is \"both\", and [grip] has keys of its own")
                    .remedy("keep [grip.right] and [grip.left] only"));
            }
            let (first, second) = (of(right, "grip.right")?, of(left, "grip.left")?);
            let between = first.inverse() * second;
            Ok((first, right.hold, Some(SecondHand { between, hold: left.hold })))
        }
        (Hands::Both, ..) => Err(source
            .plain("worker.hands is \"both\", but [grip.right] or [grip.left] is missing")
            .remedy("give the pose of each hand in the frame of the TCP, and its hold")),
        (_, None, None) => {
            let Some(hold) = file.hold else {
                return Err(source
                    .plain("grip.hold is missing")
                    .remedy("use \"rigid\", \"free_roll\" or \"point\""));
            };
            Ok((pose(file.position_m, file.rpy_deg, file.quaternion_wxyz, "grip")?, hold, None))
        }
        _ => Err(source
            .plain("[grip.right] and [grip.left] are for worker.hands = \"both\"")
            .remedy("set worker.hands = \"both\", or give the one hand's pose in [grip]")),
    }
}

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
    robot.base = source.pose(&file.base, "robot.base")?;
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
        let is_box = (0..3).all(|i| min_m[i] < max_m[i] && max_m[i] - min_m[i] < 100.0);
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

pub(super) fn resolve_obstacle(
    source: &Source,
    at: &Spanned<ObstacleFile>,
) -> Result<(String, Obstacle), InputError> {
    let pose = |position: &[f64; 3], rpy: &[f64; 3], name: &str| {
        let file = PoseFile { position_m: *position, rpy_deg: Some(*rpy), quaternion_wxyz: None };
        let pose = source.pose_of(&file, &format!("obstacle `{name}`"));
        pose.map_err(|e| source.at(at, e))
    };
    let positive = |values: &[f64], name: &str| {
        if values.iter().all(|v| (SMALLEST_M..100.0).contains(v)) {
            return Ok(());
        }
        let message = format!(
            "obstacle `{name}`: sizes must be {SMALLEST_M} m or more and below 100 m, found {values:?}"
        );
        Err(source.error(at, message).remedy("give whole widths, lengths and radii in metres"))
    };
    let name = match at.get_ref() {
        ObstacleFile::Box { name, .. }
        | ObstacleFile::Sphere { name, .. }
        | ObstacleFile::Capsule { name, .. }
        | ObstacleFile::Cylinder { name, .. } => name,
    };
    if let Some(fault) = name_fault(name) {
        return Err(source.error(at, format!("the name of an obstacle {fault}")).remedy(NAME));
    }
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

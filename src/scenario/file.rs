//! The scenario file as typed: keys, units and defaults.

use crate::human::Side;
use crate::posture::Hold;
use crate::survey::NeckRule;
use serde::{Deserialize, Serialize};
use toml::Spanned;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScenarioFile {
    pub schema: Spanned<String>,
    pub name: String,
    #[serde(default)]
    pub description: String,
    #[serde(default)]
    pub seed: u64,
    pub score_profile: Option<Spanned<String>>,
    pub worker: WorkerFile,
    pub grip: GripFile,
    pub robot: RobotFile,
    pub start: Spanned<PoseFile>,
    pub goal: Spanned<PoseFile>,
    pub motion: MotionFile,
    #[serde(default)]
    pub limits: LimitsFile,
    pub workspace: Option<Spanned<WorkspaceFile>>,
    #[serde(default)]
    pub obstacle: Vec<Spanned<ObstacleFile>>,
    #[serde(default)]
    pub task: TaskFile,
    #[serde(default)]
    pub path: Vec<Spanned<PathFile>>,
    #[serde(default)]
    pub free: FreeFile,
}

/// What the planner may choose besides the path. Boxes are half widths about the scenario's value.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FreeFile {
    pub start_places: Vec<PoseFile>,
    pub start_box_m: Option<[f64; 3]>,
    pub start_yaw_deg: Option<[f64; 2]>,
    pub start_roll_deg: Option<[f64; 2]>,
    pub goal_places: Vec<PoseFile>,
    pub goal_box_m: Option<[f64; 3]>,
    pub goal_yaw_deg: Option<[f64; 2]>,
    pub goal_roll_deg: Option<[f64; 2]>,
    pub grip_roll_deg: Option<[f64; 2]>,
    pub robot_base_m: Option<[f64; 3]>,
    pub robot_base_yaw_deg: Option<[f64; 2]>,
    pub worker_at_m: Option<[f64; 2]>,
    pub worker_facing_deg: Option<[f64; 2]>,
    pub duration_s: Option<[f64; 2]>,
    pub dwell_s: Option<[f64; 2]>,
    pub turn_on_the_way_deg: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkerFile {
    /// Shipped bodies or URDF files.
    pub bodies: Spanned<Vec<String>>,
    /// A shipped posture model or a file.
    pub posture_model: String,
    #[serde(default = "right")]
    pub side: Side,
    #[serde(default)]
    pub stance: StanceFile,
    pub at_m: Spanned<[f64; 2]>,
    pub facing_deg: Spanned<f64>,
    #[serde(default = "shoe")]
    pub shoe_m: f64,
    pub seat_height_m: Option<f64>,
    #[serde(default)]
    pub trunk_supported: bool,
    #[serde(default)]
    pub arm_supported: bool,
    /// "sampled", "mean", or a CSV of joint angles.
    #[serde(default = "sampled")]
    pub start_posture: PosturePick,
    #[serde(default)]
    pub neck: NeckRule,
    #[serde(default)]
    pub other_arm: OtherArm,
}

fn right() -> Side {
    Side::Right
}

fn shoe() -> f64 {
    0.03
}

fn sampled() -> PosturePick {
    PosturePick("sampled".to_owned())
}

/// Which posture the worker starts in: "sampled", "mean" or a file name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PosturePick(pub String);

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum StanceFile {
    #[default]
    Standing,
    Seated,
}

/// What is known of the arm that does not hold the robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OtherArm {
    /// Nothing: it is not scored.
    #[default]
    Unknown,
    /// Hanging at the side.
    Hanging,
}

/// A pose: position and one of two orientations.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseFile {
    pub position_m: [f64; 3],
    pub rpy_deg: Option<[f64; 3]>,
    pub quaternion_wxyz: Option<[f64; 4]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GripFile {
    pub position_m: Option<[f64; 3]>,
    pub rpy_deg: Option<[f64; 3]>,
    pub quaternion_wxyz: Option<[f64; 4]>,
    pub hold: Hold,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    pub preset: Option<String>,
    pub urdf: Option<String>,
    pub base_link: Option<String>,
    pub tcp: Option<String>,
    pub base: Spanned<PoseFile>,
    #[serde(default)]
    pub limit: Vec<JointLimitFile>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointLimitFile {
    pub joint: String,
    pub lower_rad: Option<f64>,
    pub upper_rad: Option<f64>,
    pub velocity_rad_s: Option<f64>,
    pub acceleration_rad_s2: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionFile {
    pub duration_s: Spanned<f64>,
}

/// Limits of the TCP; what is left out takes the planning default.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsFile {
    pub speed_m_s: Option<Spanned<f64>>,
    pub acceleration_m_s2: Option<Spanned<f64>>,
    pub jerk_m_s3: Option<Spanned<f64>>,
    pub angular_speed_deg_s: Option<Spanned<f64>>,
    pub angular_acceleration_deg_s2: Option<Spanned<f64>>,
    /// Distance of the TCP from obstacles.
    pub clearance_m: Option<Spanned<f64>>,
    /// Distance between robot and person, the coupled hand and forearm at the wrist excepted.
    pub person_clearance_m: Option<Spanned<f64>>,
    /// Share of the repetitions that may come nearer than that.
    pub person_clearance_share: Option<Spanned<f64>>,
    /// How far the path may be from the candidate it was made from.
    pub corridor_m: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkspaceFile {
    pub min_m: [f64; 3],
    pub max_m: [f64; 3],
}

/// A body in the cell that the robot must not touch.
#[derive(Debug, Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum ObstacleFile {
    Box {
        name: String,
        position_m: [f64; 3],
        #[serde(default)]
        rpy_deg: [f64; 3],
        size_m: [f64; 3],
    },
    Sphere {
        name: String,
        position_m: [f64; 3],
        radius_m: f64,
    },
    Capsule {
        name: String,
        from_m: [f64; 3],
        to_m: [f64; 3],
        radius_m: f64,
    },
    Cylinder {
        name: String,
        position_m: [f64; 3],
        #[serde(default)]
        rpy_deg: [f64; 3],
        radius_m: f64,
        length_m: f64,
    },
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskFile {
    pub part_mass_kg: Option<Spanned<f64>>,
    pub human_load_share: Option<Spanned<f64>>,
    pub extra_load_kg: Option<Spanned<f64>>,
    pub cycles_per_min: Option<Spanned<f64>>,
    pub hold_s: Option<Spanned<f64>>,
    #[serde(default)]
    pub shock: bool,
    pub coupling: Option<CouplingFile>,
}

/// Quality of the hold on the part (REBA).
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum CouplingFile {
    Good,
    Fair,
    Poor,
    Unacceptable,
}

/// A path that the designer has, as a file or drawn by via-points.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathFile {
    pub name: String,
    pub file: Option<String>,
    pub via_m: Option<Vec<[f64; 3]>>,
}

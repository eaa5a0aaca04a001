//! The scenario file as typed: keys, units and defaults.

use super::SCENARIO_SCHEMA;
use crate::human::{Hands, Side};
use crate::posture::Hold;
use crate::survey::NeckRule;
use schemars::JsonSchema;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use toml::Spanned;

/// A workstation: worker, robot, task and limits. World: right-handed, z up, origin on the floor; metres, seconds, kilograms; degrees only in keys that end in `_deg`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ScenarioFile {
    /// Version of this format: `ergopath/scenario/1`.
    #[schemars(with = "String", extend("const" = SCENARIO_SCHEMA))]
    pub schema: Spanned<String>,
    /// Short name, shown in reports.
    #[schemars(with = "String")]
    pub name: Spanned<String>,
    /// What the scenario is about.
    #[serde(default)]
    pub description: String,
    /// Seed of all randomness, unless the command line gives another; default 0.
    #[serde(default)]
    pub seed: u64,
    /// Convention for what RULA and REBA leave open.
    #[schemars(with = "Option<String>", extend("enum" = crate::ergonomics::Profile::names()))]
    pub score_profile: Option<Spanned<String>>,
    /// Who works.
    pub worker: WorkerFile,
    /// How the hand holds the tool.
    pub grip: GripFile,
    /// Who leads.
    pub robot: RobotFile,
    /// TCP, or hand, at the start, world.
    #[schemars(with = "TcpFile")]
    pub start: Spanned<TcpFile>,
    /// TCP, or hand, at the goal, world.
    #[schemars(with = "TcpFile")]
    pub goal: Spanned<TcpFile>,
    /// How long the movement takes.
    pub motion: MotionFile,
    /// Limits of the TCP.
    #[serde(default)]
    pub limits: LimitsFile,
    /// The box that the TCP must not leave.
    #[schemars(with = "Option<WorkspaceFile>")]
    pub workspace: Option<Spanned<WorkspaceFile>>,
    /// What the robot must not touch.
    #[serde(default)]
    #[schemars(with = "Vec<ObstacleFile>")]
    pub obstacle: Vec<Spanned<ObstacleFile>>,
    /// Load, repetition and hold.
    #[serde(default)]
    pub task: TaskFile,
    /// Your own paths: planned paths are compared with them.
    #[serde(default)]
    #[schemars(with = "Vec<PathFile>")]
    pub path: Vec<Spanned<PathFile>>,
    /// What the planner may choose besides the path.
    #[serde(default)]
    pub free: FreeFile,
}

/// What the planner may choose besides the path. Boxes are half widths about the scenario's value.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FreeFile {
    /// Equivalent starts besides the one above.
    #[schemars(with = "Vec<TcpFile>")]
    pub start_places: Vec<Spanned<TcpFile>>,
    /// Half widths along world x, y, z within which the start may move, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub start_box_m: Option<Spanned<[f64; 3]>>,
    /// Least and greatest turn of the start about the vertical, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub start_yaw_deg: Option<Spanned<[f64; 2]>>,
    /// Least and greatest turn of the start about the held bar, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub start_roll_deg: Option<Spanned<[f64; 2]>>,
    /// Equivalent goals besides the one above.
    #[schemars(with = "Vec<TcpFile>")]
    pub goal_places: Vec<Spanned<TcpFile>>,
    /// Half widths along world x, y, z within which the goal may move, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub goal_box_m: Option<Spanned<[f64; 3]>>,
    /// Least and greatest turn of the goal about the vertical, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub goal_yaw_deg: Option<Spanned<[f64; 2]>>,
    /// Least and greatest turn of the goal about the held bar, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub goal_roll_deg: Option<Spanned<[f64; 2]>>,
    /// Least and greatest turn of the handle on the tool about its bar, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub grip_roll_deg: Option<Spanned<[f64; 2]>>,
    /// Half widths along world x, y, z within which the robot's base may move, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub robot_base_m: Option<Spanned<[f64; 3]>>,
    /// Least and greatest turn of the robot's base about the vertical, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub robot_base_yaw_deg: Option<Spanned<[f64; 2]>>,
    /// Half widths along world x, y within which the worker's place may move, m.
    #[schemars(with = "Option<[f64; 2]>")]
    pub worker_at_m: Option<Spanned<[f64; 2]>>,
    /// Least and greatest turn of the worker about the vertical, deg.
    #[schemars(with = "Option<[f64; 2]>")]
    pub worker_facing_deg: Option<Spanned<[f64; 2]>>,
    /// Least and greatest duration, s.
    #[schemars(with = "Option<[f64; 2]>")]
    pub duration_s: Option<Spanned<[f64; 2]>>,
    /// Least and greatest rest at the middle of the way, besides the duration, s.
    #[schemars(with = "Option<[f64; 2]>")]
    pub dwell_s: Option<Spanned<[f64; 2]>>,
    /// How far the tool may turn on its way besides the turn from start to goal, deg.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub turn_on_the_way_deg: Option<f64>,
    /// Parts of the path may be quicker or slower than by the minimum-jerk law, in the same time; default false.
    pub pace: Option<bool>,
    /// How much: standard deviation of the logarithm of a part's duration; default 1.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub pace_spread: Option<f64>,
}

/// Who works, where, and in which posture.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkerFile {
    /// Shipped bodies (`female_p05`, `female_p50`, `male_p50`, `male_p95`), `population`, or URDF files made by `ergopath body`; the first is the main one. A name alone will do for one.
    #[schemars(with = "BodyNames")]
    pub bodies: Spanned<BodyNames>,
    /// Share of women in a population, 0 to 1; default 0.5.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 1.0))]
    pub women_share: Option<Spanned<f64>>,
    /// A shipped posture model (`people`, `whole_operator`, `demo_operator`) or a file that `ergopath train` wrote.
    #[schemars(with = "String")]
    pub posture_model: Spanned<String>,
    /// The hands on the robot: `right` (default), `left`, or `both`.
    pub hands: Option<Hands>,
    /// The hand on the robot; `hands` says the same, and more.
    pub side: Option<Side>,
    /// Default standing.
    #[serde(default)]
    pub stance: StanceFile,
    /// Floor point between the feet, below the upright pelvis; seated, below the pelvis: x, y, world, m.
    #[schemars(with = "[f64; 2]")]
    pub at_m: Spanned<[f64; 2]>,
    /// Forward direction of the pelvis about world z, deg; 0 is world x.
    #[schemars(with = "f64", range(min = -720.0, max = 720.0))]
    pub facing_deg: Spanned<f64>,
    /// Thickness of the soles, m, standing; default 0.03.
    #[serde(default = "shoe")]
    #[schemars(range(min = 0.0, max = 0.3))]
    pub shoe_m: f64,
    /// Height of the seat, m; needed when seated.
    #[schemars(range(min = 0.1, max = 1.2))]
    pub seat_height_m: Option<f64>,
    /// Height of what the feet of somebody who sits stand on, m; default 0, the floor.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub footrest_m: Option<f64>,
    /// Whether the pelvis moves as predicted (default; on a seat it only turns), or is fixed.
    #[serde(default)]
    pub pelvis: PelvisFile,
    /// Whether the feet stay where they are (`none`, default), or are set anew as recorded people stood
    /// (`allowed`).
    #[schemars(with = "Option<StepsFile>")]
    pub steps: Option<Spanned<StepsFile>>,
    /// A backrest supports the trunk.
    #[schemars(with = "Option<bool>")]
    pub trunk_supported: Option<Spanned<bool>>,
    /// The weight of the arm is supported.
    #[serde(default)]
    pub arm_supported: bool,
    /// `sampled` (default), `mean`, or a CSV of joint angles.
    #[serde(default = "sampled")]
    pub start_posture: PosturePick,
    /// How the head is held; default as predicted.
    #[serde(default)]
    pub neck: NeckRule,
    /// What the task needs the eyes on: the head follows as far as they ask; default nothing.
    pub look_at: Option<LookAt>,
    /// What is known of the arm that does not hold the robot; default as predicted.
    #[serde(default)]
    pub other_arm: OtherArm,
}

/// Names of bodies: one, or a list.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(super) enum BodyNames {
    /// One.
    One(String),
    /// The first is the main one.
    Several(#[schemars(with = "Vec<String>", length(min = 1))] Vec<Spanned<String>>),
}

/// By hand, as a list must keep the place of each name in the text.
impl<'de> Deserialize<'de> for BodyNames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Names;
        impl<'de> Visitor<'de> for Names {
            type Value = BodyNames;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a body, or a list of names")
            }

            fn visit_str<E>(self, name: &str) -> Result<BodyNames, E> {
                Ok(BodyNames::One(name.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, names: A) -> Result<BodyNames, A::Error> {
                let names = Vec::deserialize(SeqAccessDeserializer::new(names));
                names.map(BodyNames::Several)
            }
        }
        deserializer.deserialize_any(Names)
    }
}

fn shoe() -> f64 {
    0.03
}

fn sampled() -> PosturePick {
    PosturePick("sampled".to_owned())
}

/// Whether the pelvis moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum PelvisFile {
    /// As the posture model predicts it.
    #[default]
    Predicted,
    /// It stays upright where it is, on straight legs or on the seat.
    Fixed,
}

/// Whether the worker steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum StepsFile {
    /// The feet stay where they are.
    None,
    /// They are set anew where recorded people would not let the hand go.
    Allowed,
}

/// What a task needs the eyes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum LookAt {
    /// The part in the hand.
    Part,
}

/// Which posture the worker starts in: "sampled", "mean" or a file name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PosturePick(pub String);

/// How the worker is placed.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum StanceFile {
    /// On straight legs.
    #[default]
    Standing,
    /// On a seat of `seat_height_m`.
    Seated,
}

/// What is known of the arm that does not hold the robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OtherArm {
    /// As predicted: it hangs under its shoulder, whatever the trunk does.
    #[default]
    Predicted,
    /// Hanging at the side, as the scenario says.
    Hanging,
    /// Nothing: it is not scored.
    Unknown,
}

/// A direction in the frame that a pose is given in; its length does not count.
pub(super) type Direction = Spanned<[f64; 3]>;

/// The tool at a place: where its TCP or the hand is, and how it is turned.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TcpFile {
    /// Place of the TCP: x, y, z, m.
    pub position_m: Option<[f64; 3]>,
    /// Place of the hand (of both hands: of the middle between them) instead of the TCP's: x, y, z, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub hand_at_m: Option<Direction>,
    /// Orientation: roll, pitch, yaw about fixed axes, deg.
    pub rpy_deg: Option<[f64; 3]>,
    /// Orientation instead of `rpy_deg`; w first, norm 1.
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// Orientation instead of both: where the tool's z axis points.
    #[schemars(with = "Option<[f64; 3]>")]
    pub pointing: Option<Direction>,
    /// With `pointing`: where the held bar runs, towards the thumb; with a named grip either way.
    #[schemars(with = "Option<[f64; 3]>")]
    pub bar_along: Option<Direction>,
    /// With `pointing`: where the tool's x axis points.
    #[schemars(with = "Option<[f64; 3]>")]
    pub x_along: Option<Direction>,
}

/// Where the robot stands, and how it is turned.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BaseFile {
    /// Middle of the mounting face: x, y, z, m.
    pub position_m: Option<[f64; 3]>,
    /// The floor point below it: x, y, m; together with `mount_height_m` instead of `position_m`.
    pub at_m: Option<[f64; 2]>,
    /// Height of the mounting face above the floor, m.
    pub mount_height_m: Option<f64>,
    /// Orientation: roll, pitch, yaw about fixed axes, deg. Without any orientation: not turned.
    pub rpy_deg: Option<[f64; 3]>,
    /// Orientation instead of `rpy_deg`; w first, norm 1.
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// Orientation instead of both: where the base's z axis points; up if `x_along` stands alone.
    #[schemars(with = "Option<[f64; 3]>")]
    pub pointing: Option<Direction>,
    /// Where the base's x axis points.
    #[schemars(with = "Option<[f64; 3]>")]
    pub x_along: Option<Direction>,
}

/// The hand in the TCP's frame: z along the held bar towards the thumb, y towards the wrist, x out of the palm (right hand). For both hands a table for each: `[grip.right]` and `[grip.left]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GripFile {
    /// A named grip: how the hand is turned at the start, as the worker sees it.
    #[schemars(with = "Option<String>", extend("enum" = crate::human::NamedGrip::names()))]
    pub grip: Option<Spanned<String>>,
    /// With a named grip: the hand's place from the TCP at the start, as the worker sees it: ahead, to the left, up, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub from_tcp_m: Option<Direction>,
    /// Origin of the grip in the frame of the TCP, m; default 0, 0, 0.
    pub position_m: Option<[f64; 3]>,
    /// Orientation in the frame of the TCP: roll, pitch, yaw about fixed axes, deg.
    pub rpy_deg: Option<[f64; 3]>,
    /// Orientation instead of `rpy_deg`; w first, norm 1.
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// Orientation instead of both: where the bar runs towards the thumb, in the frame of the TCP.
    #[schemars(with = "Option<[f64; 3]>")]
    pub pointing: Option<Direction>,
    /// With `pointing`: where the hand's x axis points, out of the palm of a right hand.
    #[schemars(with = "Option<[f64; 3]>")]
    pub x_along: Option<Direction>,
    /// What the robot prescribes of the hand; needed for one hand without a named grip.
    pub hold: Option<Hold>,
    /// The right hand, where both hold on.
    pub right: Option<HandGripFile>,
    /// The left hand, where both hold on.
    pub left: Option<HandGripFile>,
}

impl GripFile {
    /// The keys of one hand.
    pub(super) fn own(&self) -> HandGripFile {
        HandGripFile {
            grip: self.grip.clone(),
            from_tcp_m: self.from_tcp_m.clone(),
            position_m: self.position_m,
            rpy_deg: self.rpy_deg,
            quaternion_wxyz: self.quaternion_wxyz,
            pointing: self.pointing.clone(),
            x_along: self.x_along.clone(),
            hold: self.hold,
        }
    }
}

/// One of two hands in the TCP's frame.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct HandGripFile {
    /// A named grip: how the hand is turned at the start, as the worker sees it.
    #[schemars(with = "Option<String>", extend("enum" = crate::human::NamedGrip::names()))]
    pub grip: Option<Spanned<String>>,
    /// With a named grip: the hand's place from the TCP at the start, as the worker sees it: ahead, to the left, up, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub from_tcp_m: Option<Direction>,
    /// Origin of the grip in the frame of the TCP, m; default 0, 0, 0.
    pub position_m: Option<[f64; 3]>,
    /// Orientation in the frame of the TCP: roll, pitch, yaw about fixed axes, deg.
    pub rpy_deg: Option<[f64; 3]>,
    /// Orientation instead of `rpy_deg`; w first, norm 1.
    pub quaternion_wxyz: Option<[f64; 4]>,
    /// Orientation instead of both: where the bar runs towards the thumb, in the frame of the TCP.
    #[schemars(with = "Option<[f64; 3]>")]
    pub pointing: Option<Direction>,
    /// With `pointing`: where the hand's x axis points, out of the palm of a right hand.
    #[schemars(with = "Option<[f64; 3]>")]
    pub x_along: Option<Direction>,
    /// What the robot prescribes of the hand; needed without a named grip.
    pub hold: Option<Hold>,
}

/// The robot: a preset, or a URDF with its base and TCP links.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    /// A robot that is shipped: `panda`, `fr3`, `ur3e`, `ur5e`, `ur10e`, `ur20`,
    /// `crb15000` (ABB's `GoFa` 5/0.95), `crx10ial` (FANUC CRX-10iA/L).
    #[schemars(with = "Option<String>", extend("enum" = crate::robot::PRESETS))]
    pub preset: Option<Spanned<String>>,
    /// URDF file instead of a preset.
    #[schemars(with = "Option<String>")]
    pub urdf: Option<Spanned<String>>,
    /// Link of the URDF that stands on `base`.
    pub base_link: Option<String>,
    /// Link of the URDF whose frame is the TCP.
    pub tcp: Option<String>,
    /// Base of the robot, world.
    #[schemars(with = "BaseFile")]
    pub base: Spanned<BaseFile>,
    /// Other limits of single joints.
    #[serde(default)]
    #[schemars(with = "Vec<JointLimitFile>")]
    pub limit: Vec<Spanned<JointLimitFile>>,
}

/// Another limit of one joint of the robot; what is left out stays.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct JointLimitFile {
    /// Name of the joint.
    pub joint: String,
    /// Least position, rad (m for a sliding joint).
    pub lower_rad: Option<f64>,
    /// Greatest position, rad.
    pub upper_rad: Option<f64>,
    /// Greatest speed, rad/s.
    pub velocity_rad_s: Option<f64>,
    /// Greatest acceleration, rad/s^2.
    pub acceleration_rad_s2: Option<f64>,
}

/// How long the movement takes.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionFile {
    /// Duration of the movement, s.
    #[schemars(with = "f64", range(min = 0.05, max = 600.0))]
    pub duration_s: Spanned<f64>,
}

/// Limits of the TCP; what is left out takes the planning default.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsFile {
    /// Greatest speed, m/s.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 5.0))]
    pub speed_m_s: Option<Spanned<f64>>,
    /// Greatest acceleration, m/s^2.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 50.0))]
    pub acceleration_m_s2: Option<Spanned<f64>>,
    /// Greatest component of the jerk, m/s^3.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 10000.0))]
    pub jerk_m_s3: Option<Spanned<f64>>,
    /// Greatest angular speed, deg/s.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 720.0))]
    pub angular_speed_deg_s: Option<Spanned<f64>>,
    /// Greatest angular acceleration, deg/s^2.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 5000.0))]
    pub angular_acceleration_deg_s2: Option<Spanned<f64>>,
    /// Distance of the TCP from obstacles, m; default 0.03.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 1.0))]
    pub clearance_m: Option<Spanned<f64>>,
    /// Distance between robot and person, the coupled hand and forearm at the wrist excepted, m;
    /// default 0.05.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 1.0))]
    pub person_clearance_m: Option<Spanned<f64>>,
    /// Share of the repetitions that may come nearer than that; default 0.05.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 1.0))]
    pub person_clearance_share: Option<Spanned<f64>>,
    /// How far the path may be from the candidate it was made from, m; without it anywhere.
    #[schemars(with = "Option<f64>", range(min = 0.001, max = 10.0))]
    pub corridor_m: Option<Spanned<f64>>,
}

/// The box that the TCP must not leave, world, m.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkspaceFile {
    /// Lower corner: x, y, z, world, m.
    pub min_m: [f64; 3],
    /// Upper corner: x, y, z, world, m.
    pub max_m: [f64; 3],
}

/// A body in the cell that the robot must not touch.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum ObstacleFile {
    /// A box about its middle.
    Box {
        /// Name in reports.
        name: String,
        /// Middle: x, y, z, world, m.
        position_m: [f64; 3],
        /// Roll, pitch, yaw about fixed axes, deg.
        rpy_deg: Option<[f64; 3]>,
        /// Orientation instead of `rpy_deg`: where its own z axis points.
        pointing: Option<[f64; 3]>,
        /// With `pointing`: where its own x axis points.
        x_along: Option<[f64; 3]>,
        /// Whole widths along its own x, y, z, m.
        size_m: [f64; 3],
    },
    /// A sphere.
    Sphere {
        /// Name in reports.
        name: String,
        /// Middle: x, y, z, world, m.
        position_m: [f64; 3],
        /// Radius, m.
        radius_m: f64,
    },
    /// All points within a radius of a line.
    Capsule {
        /// Name in reports.
        name: String,
        /// One end of the line, world, m.
        from_m: [f64; 3],
        /// The other end, world, m.
        to_m: [f64; 3],
        /// Radius, m.
        radius_m: f64,
    },
    /// A cylinder along its own z axis, about its middle.
    Cylinder {
        /// Name in reports.
        name: String,
        /// Middle: x, y, z, world, m.
        position_m: [f64; 3],
        /// Roll, pitch, yaw about fixed axes, deg.
        rpy_deg: Option<[f64; 3]>,
        /// Orientation instead of `rpy_deg`: where its own z axis points.
        pointing: Option<[f64; 3]>,
        /// Radius, m.
        radius_m: f64,
        /// Whole length, m.
        length_m: f64,
    },
    /// A mesh from CAD; convex parts that hold it are what the robot must not touch.
    Mesh {
        /// Name in reports.
        name: String,
        /// STL, glTF (`.gltf`, `.glb`) or OBJ file.
        file: String,
        /// Unit of its numbers: needed for STL and OBJ; glTF is in metres.
        units: Option<MeshUnits>,
        /// Where the origin of the mesh is: x, y, z, world, m; default 0, 0, 0.
        position_m: Option<[f64; 3]>,
        /// Roll, pitch, yaw about fixed axes, deg.
        rpy_deg: Option<[f64; 3]>,
        /// Orientation instead of `rpy_deg`: where the z axis of the mesh points.
        pointing: Option<[f64; 3]>,
        /// With `pointing`: where the x axis of the mesh points.
        x_along: Option<[f64; 3]>,
    },
}

/// Unit of the numbers of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MeshUnits {
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetres,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetres,
    /// Metres.
    #[serde(rename = "m")]
    Metres,
    /// Inches.
    #[serde(rename = "in")]
    Inches,
}

/// Load, repetition and hold: what no path shows.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskFile {
    /// Mass of the part, kg; default 0.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 200.0))]
    pub part_mass_kg: Option<Spanned<f64>>,
    /// Share of the part's weight that the worker carries, 0 to 1; default 1, with a warning.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 1.0))]
    pub human_load_share: Option<Spanned<f64>>,
    /// Load besides the part, such as a tool, kg; default 0.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 200.0))]
    pub extra_load_kg: Option<Spanned<f64>>,
    /// How often the movement is made, per minute.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 600.0))]
    pub cycles_per_min: Option<Spanned<f64>>,
    /// Longest static hold, s.
    #[schemars(with = "Option<f64>", range(min = 0.0, max = 86_400.0))]
    pub hold_s: Option<Spanned<f64>>,
    /// Shock or rapid build-up of force.
    #[serde(default)]
    pub shock: bool,
    /// Quality of the hold on the part (REBA); default good.
    pub coupling: Option<CouplingFile>,
}

/// Quality of the hold on the part (REBA).
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum CouplingFile {
    /// A handle that fits; a power grip.
    Good,
    /// Acceptable, not ideal; or held with another part of the body.
    Fair,
    /// Not acceptable, though possible.
    Poor,
    /// Awkward, unsafe, no handle.
    Unacceptable,
}

/// A path that the designer has, as a file or drawn by via-points.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PathFile {
    /// Name in reports.
    pub name: String,
    /// CSV of `time_s, x_m, y_m, z_m, qw, qx, qy, qz`, or of `time_s` and the joints of the robot, or a ROS `JointTrajectory` (YAML, JSON).
    pub file: Option<String>,
    /// Via-points between start and goal instead of a file: x, y, z, world, m.
    pub via_m: Option<Vec<[f64; 3]>>,
}

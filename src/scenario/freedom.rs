//! What the planner may choose besides the path: where the part is taken and put, how it is gripped,
//! where robot and worker stand, how long the movement takes.

use super::check::Scenario;
use super::file::FreeFile;
use super::held::Held;
use super::plausible::{self, Doubt};
use super::source::Source;
use crate::files::InputError;
use crate::math::{Pose, Vec3};
use crate::physical::{DURATION_S, MOVED_M, SAME_CELL_M};
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};
use toml::Spanned;

/// One number that may be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Freedom {
    /// Which of the equivalent places is the start.
    StartPlace,
    /// Offset of the start along world x, y or z, m.
    StartOffset(usize),
    /// Turn of the start about the vertical, rad.
    StartYaw,
    /// Turn of the start about the bar that is held, rad.
    StartRoll,
    /// Which of the equivalent places is the goal.
    GoalPlace,
    /// Offset of the goal along world x, y or z, m.
    GoalOffset(usize),
    /// Turn of the goal about the vertical, rad.
    GoalYaw,
    /// Turn of the goal about the bar that is held, rad.
    GoalRoll,
    /// Turn of the handle on the tool about its bar, rad.
    GripRoll,
    /// Offset of the robot's base along world x, y or z, m.
    BaseOffset(usize),
    /// Turn of the robot's base about the vertical, rad.
    BaseYaw,
    /// Offset of the worker's standing place along world x or y, m.
    WorkerOffset(usize),
    /// Turn of the worker about the vertical, rad.
    WorkerFacing,
    /// Duration, s.
    Duration,
    /// Rest at the middle via-point, s.
    Dwell,
}

impl Freedom {
    /// The freedom in words; its coordinates together are one freedom.
    pub fn name(self) -> &'static str {
        match self {
            Self::StartPlace => "choice of the start",
            Self::StartOffset(_) => "start position",
            Self::StartYaw => "start yaw",
            Self::StartRoll => "start roll about the bar",
            Self::GoalPlace => "choice of the goal",
            Self::GoalOffset(_) => "goal position",
            Self::GoalYaw => "goal yaw",
            Self::GoalRoll => "goal roll about the bar",
            Self::GripRoll => "grip on the tool",
            Self::BaseOffset(_) => "place of the robot",
            Self::BaseYaw => "yaw of the robot",
            Self::WorkerOffset(_) => "place of the worker",
            Self::WorkerFacing => "facing of the worker",
            Self::Duration => "duration",
            Self::Dwell => "rest on the way",
        }
    }
}

/// One choice of everything that may be free.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// TCP at the start, world.
    pub start: Pose,
    /// TCP at the goal, world.
    pub goal: Pose,
    /// Pose of the grip in the TCP's frame.
    pub grip: Pose,
    /// Base of the robot, world.
    pub base: Pose,
    /// Floor point below the pelvis, m.
    pub at_m: [f64; 2],
    /// Height of what the worker stands on, or by which a seat is raised, m.
    pub floor_m: f64,
    /// Facing of the worker, rad about world z.
    pub facing: f64,
    /// Duration of the movement, s.
    pub duration_s: f64,
    /// How long the hand rests on its way, s; besides the duration.
    pub dwell_s: f64,
}

impl Variant {
    /// From start to goal with the rest, s.
    pub fn whole_s(&self) -> f64 {
        self.duration_s + self.dwell_s
    }
}

/// The free numbers with their bounds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Freedoms {
    /// Each number with least and greatest value (indices of places from 0).
    pub all: Vec<(Freedom, [f64; 2])>,
    /// Equivalent starts; the first is the scenario's.
    pub starts: Vec<Pose>,
    /// Equivalent goals; the first is the scenario's.
    pub goals: Vec<Pose>,
    /// How far the tool may turn on its way besides the turn from start to goal, rad.
    pub turn_rad: Option<f64>,
    /// How much parts of the path may be quicker or slower than by the minimum-jerk law, in the same
    /// time: standard deviation of the logarithm of a part's duration.
    pub pace_spread: Option<f64>,
}

/// Name of the freedom of the pace.
pub const TIMING: &str = "timing";
/// Spread of the pace where the scenario does not say.
pub const PACE_SPREAD: f64 = 1.0;

/// Name of the freedom to turn on the way.
pub const TURN_ON_THE_WAY: &str = "turn on the way";

impl Scenario {
    /// Everything as the scenario says, nothing chosen.
    pub fn nominal(&self) -> Variant {
        Variant {
            start: self.start,
            goal: self.goal,
            grip: self.grip,
            base: self.robot.base,
            at_m: self.worker.at_m,
            floor_m: 0.0,
            facing: self.worker.facing,
            duration_s: self.duration_s,
            // A rest that may be longer is at least as long as asked.
            dwell_s: self.free.range(Freedom::Dwell).map_or(0.0, |[least, _]| least),
        }
    }

    /// The share in [0, 1] of a free range at which the scenario's own value lies.
    pub fn own_share(&self, (freedom, [low, high]): &(Freedom, [f64; 2])) -> f64 {
        let own = match freedom {
            // In the middle of the first place's part.
            Freedom::StartPlace | Freedom::GoalPlace => 0.5,
            Freedom::Duration => self.duration_s,
            Freedom::Dwell => *low,
            // Offsets and turns are counted from the scenario's.
            _ => 0.0,
        };
        if high > low { ((own - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 }
    }

    /// Names of the bodies, in order.
    pub fn body_names(&self) -> Vec<&str> {
        self.worker.bodies.iter().map(|b| b.name.as_str()).collect()
    }

    /// The variant at the given shares in [0, 1] of the free ranges, in their order; `None` keeps the
    /// scenario's value.
    pub fn variant(&self, shares: &[Option<f64>]) -> Variant {
        let mut v = self.nominal();
        let chosen = self.free.all.iter().zip(shares);
        for ((freedom, [low, high]), share) in chosen {
            if let Some(share) = share {
                self.free.set(&mut v, *freedom, low + share.clamp(0.0, 1.0) * (high - low));
            }
        }
        v
    }
}

/// Something that a variant chooses otherwise than the scenario says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "chosen", content = "value", rename_all = "snake_case")]
pub enum Chosen {
    /// Where the movement starts, world, m.
    StartAt([f64; 3]),
    /// By how much the start is turned, rad.
    StartTurned(f64),
    /// Where it ends, world, m.
    GoalAt([f64; 3]),
    /// By how much the goal is turned, rad.
    GoalTurned(f64),
    /// Where the robot's base stands, world, m.
    BaseAt([f64; 3]),
    /// By how much the robot's base is turned, rad.
    BaseTurned(f64),
    /// By how much the grip is turned, rad.
    GripTurned(f64),
    /// Where the worker stands, m.
    WorkerAt([f64; 2]),
    /// Where the worker faces, rad about world z.
    WorkerFacing(f64),
    /// Duration, s.
    Duration(f64),
    /// Rest on the way, s.
    Rest(f64),
}

/// How a place and a turn of something are told.
type PlaceAndTurn = (fn([f64; 3]) -> Chosen, fn(f64) -> Chosen);

impl Scenario {
    /// What a variant chooses besides the path; empty where nothing is free.
    pub fn chosen(&self, v: &Variant) -> Vec<Chosen> {
        let from = self.nominal();
        let turned = |a: &Pose, b: &Pose| a.rotation.angle_to(&b.rotation);
        let ends: [(PlaceAndTurn, &Pose, &Pose); 3] = [
            ((Chosen::StartAt, Chosen::StartTurned), &v.start, &from.start),
            ((Chosen::GoalAt, Chosen::GoalTurned), &v.goal, &from.goal),
            ((Chosen::BaseAt, Chosen::BaseTurned), &v.base, &from.base),
        ];
        let mut all = Vec::new();
        for ((at, by), now, was) in ends {
            if (now.translation.vector - was.translation.vector).norm() > 5e-4 {
                all.push(at(now.translation.vector.into()));
            }
            if turned(now, was) > 1e-3 {
                all.push(by(turned(now, was)));
            }
        }
        if turned(&v.grip, &from.grip) > 1e-3 {
            all.push(Chosen::GripTurned(turned(&v.grip, &from.grip)));
        }
        if v.at_m.iter().zip(from.at_m).any(|(a, b)| (a - b).abs() > 5e-4) {
            all.push(Chosen::WorkerAt(v.at_m));
        }
        if (v.facing - from.facing).abs() > 1e-3 {
            all.push(Chosen::WorkerFacing(v.facing));
        }
        all.extend(self.free.range(Freedom::Duration).map(|_| Chosen::Duration(v.duration_s)));
        all.extend(self.free.range(Freedom::Dwell).map(|_| Chosen::Rest(v.dwell_s)));
        all
    }
}

impl Freedoms {
    /// Names of the freedoms, each once, in order.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = self.all.iter().map(|(f, _)| f.name()).collect();
        names.dedup();
        names.extend(self.turn_rad.map(|_| TURN_ON_THE_WAY));
        names.extend(self.pace_spread.map(|_| TIMING));
        names
    }

    /// Whether the planner chooses where or how the worker stands.
    pub fn moves_worker(&self) -> bool {
        let moves = |f: Freedom| matches!(f, Freedom::WorkerOffset(_) | Freedom::WorkerFacing);
        self.all.iter().any(|(f, _)| moves(*f))
    }

    /// The range of one free number.
    pub fn range(&self, freedom: Freedom) -> Option<[f64; 2]> {
        self.all.iter().find(|(f, _)| *f == freedom).map(|(_, range)| *range)
    }

    fn set(&self, v: &mut Variant, freedom: Freedom, value: f64) {
        let pick = |places: &[Pose], now: Pose| {
            places.get((value as usize).min(places.len().saturating_sub(1))).copied().unwrap_or(now)
        };
        match freedom {
            Freedom::StartPlace => v.start = pick(&self.starts, v.start),
            Freedom::GoalPlace => v.goal = pick(&self.goals, v.goal),
            Freedom::StartOffset(axis) => v.start.translation.vector[axis] += value,
            Freedom::GoalOffset(axis) => v.goal.translation.vector[axis] += value,
            Freedom::StartYaw => yaw(&mut v.start, value),
            Freedom::GoalYaw => yaw(&mut v.goal, value),
            Freedom::StartRoll => v.start = rolled(&v.start, &v.grip, value),
            Freedom::GoalRoll => v.goal = rolled(&v.goal, &v.grip, value),
            Freedom::GripRoll => v.grip *= about_z(value),
            Freedom::BaseOffset(axis) => v.base.translation.vector[axis] += value,
            Freedom::BaseYaw => yaw(&mut v.base, value),
            Freedom::WorkerOffset(axis) => v.at_m[axis] += value,
            Freedom::WorkerFacing => v.facing += value,
            Freedom::Duration => v.duration_s = value,
            Freedom::Dwell => v.dwell_s = value,
        }
    }
}

fn about_z(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vec3::z_axis(), angle)
}

/// Turned about the vertical through its own origin.
fn yaw(pose: &mut Pose, angle: f64) {
    pose.rotation = about_z(angle) * pose.rotation;
}

/// A TCP pose turned about the bar of the grip.
fn rolled(tcp: &Pose, grip: &Pose, angle: f64) -> Pose {
    tcp * grip * about_z(angle) * grip.inverse()
}

/// The freedom along an axis.
type OfAxis = fn(usize) -> Freedom;

/// Reads and checks `[free]`.
pub(super) fn resolve_free(
    source: &Source,
    file: &FreeFile,
    held: &Held,
    goal: &Pose,
) -> Result<Freedoms, InputError> {
    let mut free = Freedoms {
        all: Vec::new(),
        starts: vec![held.start],
        goals: vec![*goal],
        turn_rad: turn_on_the_way(source, file)?,
        pace_spread: pace_spread(source, file)?,
    };
    for (places, list, freedom, key) in [
        (&file.start_places, &mut free.starts, Freedom::StartPlace, "free.start_places"),
        (&file.goal_places, &mut free.goals, Freedom::GoalPlace, "free.goal_places"),
    ] {
        let first = list[0].translation.vector;
        for place in places {
            let pose = held.pose(source, place, key)?;
            let value = (pose.translation.vector - first).norm();
            if !SAME_CELL_M.holds(value) {
                let doubt = Doubt::FarPlace { place: key.to_owned(), value };
                return Err(source.at(place, source.question(&doubt)));
            }
            list.push(pose);
        }
        if !places.is_empty() {
            // Half open, so that each place has the same share.
            free.all.push((freedom, [0.0, list.len() as f64 - 1e-9]));
        }
    }
    let boxes: [(_, OfAxis, &str); 3] = [
        (&file.start_box_m, Freedom::StartOffset, "free.start_box_m"),
        (&file.goal_box_m, Freedom::GoalOffset, "free.goal_box_m"),
        (&file.robot_base_m, Freedom::BaseOffset, "free.robot_base_m"),
    ];
    for (half, freedom, key) in boxes {
        if let Some(half) = half {
            push_halves(source, &mut free.all, freedom, half, key)?;
        }
    }
    if let Some(half) = &file.worker_at_m {
        push_halves(source, &mut free.all, Freedom::WorkerOffset, half, "free.worker_at_m")?;
    }
    let turns = [
        (&file.start_yaw_deg, Freedom::StartYaw, "free.start_yaw_deg"),
        (&file.start_roll_deg, Freedom::StartRoll, "free.start_roll_deg"),
        (&file.goal_yaw_deg, Freedom::GoalYaw, "free.goal_yaw_deg"),
        (&file.goal_roll_deg, Freedom::GoalRoll, "free.goal_roll_deg"),
        (&file.grip_roll_deg, Freedom::GripRoll, "free.grip_roll_deg"),
        (&file.robot_base_yaw_deg, Freedom::BaseYaw, "free.robot_base_yaw_deg"),
        (&file.worker_facing_deg, Freedom::WorkerFacing, "free.worker_facing_deg"),
    ];
    for (range, freedom, key) in turns {
        if let Some(range) = range {
            source.doubt(plausible::radians(key, range.get_ref()));
            let [low, high] = checked_range(source, range, key, [-180.0, 180.0])?;
            free.all.push((freedom, [low.to_radians(), high.to_radians()]));
        }
    }
    if let Some(range) = &file.duration_s {
        let range =
            checked_range(source, range, "free.duration_s", [DURATION_S.low, DURATION_S.high])?;
        free.all.push((Freedom::Duration, range));
    }
    if let Some(range) = &file.dwell_s {
        let range = checked_range(source, range, "free.dwell_s", [0.0, DURATION_S.high])?;
        free.all.push((Freedom::Dwell, range));
    }
    Ok(free)
}

fn turn_on_the_way(source: &Source, file: &FreeFile) -> Result<Option<f64>, InputError> {
    let Some(most) = file.turn_on_the_way_deg else { return Ok(None) };
    if most > 0.0 && most <= 90.0 {
        return Ok(Some(most.to_radians()));
    }
    Err(source
        .plain(format!("free.turn_on_the_way_deg = {most} is not within 0 to 90"))
        .remedy("give the largest angle by which the tool may turn besides, in degrees"))
}

fn pace_spread(source: &Source, file: &FreeFile) -> Result<Option<f64>, InputError> {
    let spread = file.pace_spread.unwrap_or(PACE_SPREAD);
    if !file.pace.unwrap_or(false) {
        if let Some(spread) = file.pace_spread {
            return Err(source
                .plain(format!("free.pace_spread = {spread} without free.pace = true"))
                .remedy(
                    "set pace = true to let the planner choose the timing, or leave both out",
                ));
        }
        return Ok(None);
    }
    if file.dwell_s.is_some() {
        return Err(source
            .plain("free.pace and free.dwell_s are both given")
            .remedy("let the planner choose either the pace or a rest on the way, not both"));
    }
    if spread > 0.0 && spread <= 3.0 {
        return Ok(Some(spread));
    }
    Err(source
        .plain(format!("free.pace_spread = {spread} is not within 0 to 3"))
        .remedy("1 is usual: parts of the path take up to some three times as long, or as short"))
}

fn push_halves<const N: usize>(
    source: &Source,
    all: &mut Vec<(Freedom, [f64; 2])>,
    freedom: OfAxis,
    halves: &Spanned<[f64; N]>,
    key: &str,
) -> Result<(), InputError> {
    for (axis, half) in halves.get_ref().iter().enumerate() {
        if !MOVED_M.holds(*half) {
            let message = format!("{key} holds {half}, which is outside {MOVED_M}");
            return Err(source.error(halves, message).remedy(
                "give half the width along x, y and z in metres: how far the place may move",
            ));
        }
        if *half > 0.0 {
            all.push((freedom(axis), [-half, *half]));
        }
    }
    Ok(())
}

fn checked_range(
    source: &Source,
    range: &Spanned<[f64; 2]>,
    key: &str,
    [least, most]: [f64; 2],
) -> Result<[f64; 2], InputError> {
    let [low, high] = *range.get_ref();
    if low < high && low >= least && high <= most {
        return Ok([low, high]);
    }
    Err(source
        .error(range, format!("{key} = [{low}, {high}] is no range within {least} to {most}"))
        .remedy("give the least and then the greatest value"))
}

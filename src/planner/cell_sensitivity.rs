//! What an error of the tape measure would change: the same repetitions along the same path in a cell that is
//! a little different from the scenario.
//!
//! The path is carried along with what is moved: with the start or the goal its ends move and everything
//! between by its share of the way; with the robot's base all of it moves, because the robot plays its
//! motion in its own frame. The robot itself is not asked again.

use super::lens::lens;
use super::objective::Figures;
use super::person::{Person, modelled};
use crate::ergonomics::PairedDifference;
use crate::files::InputError;
use crate::human::Stance;
use crate::math::stats::mean;
use crate::math::{Pose, Vec3};
use crate::scenario::Scenario;
use crate::trajectory::{TimedPath, minimum_jerk_line};
use nalgebra::UnitQuaternion;
use serde::Serialize;

/// How far a length is moved, m.
const LENGTH_M: f64 = 0.02;
/// How far an angle is turned, deg.
const ANGLE_DEG: f64 = 5.0;
/// How much a mass, a share or a time is changed.
const SHARE: f64 = 0.1;
/// Steps of the straight path where no run gives one.
const STEPS: usize = 100;
/// Block of repetitions: others than those that chose and reported a path.
const BLOCK: u32 = 3;

/// What each measured quantity of a cell is worth.
#[derive(Debug, Clone, Serialize)]
pub struct CellSensitivity {
    /// Body for which the path scores worst.
    pub body: String,
    /// People along each path.
    pub repetitions: usize,
    /// Name of the path that is assessed.
    pub path: String,
    /// With everything as the scenario says.
    pub nominal: Outcome,
    /// One quantity at a time, the one that moves expected RULA most first.
    pub quantities: Vec<Quantity>,
}

/// One quantity, less and more.
#[derive(Debug, Clone, Serialize)]
pub struct Quantity {
    /// Key of the scenario.
    pub key: String,
    /// What it is.
    pub what: String,
    /// By how much it is changed, with unit.
    pub by: String,
    /// With less of it.
    pub less: Outcome,
    /// With more of it.
    pub more: Outcome,
    /// Largest change of expected RULA.
    pub rula_change: f64,
    /// Largest change of the share of time at RULA 5 or more.
    pub exposure_change: f64,
    /// Whether the verdict on the path against the straight one would be another.
    pub changes_verdict: bool,
}

/// What a path causes in one state of the cell.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// Expected RULA.
    pub expected_rula: f64,
    /// Share of time at RULA 5 or more.
    pub exposure_rula_5: f64,
    /// Share of repetitions whose hand cannot follow.
    pub reach_exceeded: f64,
    /// The path minus the straight one, the same repetitions; none where the path is the straight one.
    pub against_straight: Option<PairedDifference>,
}

/// The path to assess: its name and itself, and whether it is the straight one.
#[derive(Debug, Clone)]
pub struct FixedPath {
    /// Its name.
    pub name: String,
    /// TCP over time.
    pub path: TimedPath,
}

impl Outcome {
    /// -1: the path is clearly better than the straight one, 1: clearly worse, 0: neither.
    fn verdict(&self) -> i8 {
        match self.against_straight {
            Some(d) if d.clear => d.mean.signum() as i8,
            _ => 0,
        }
    }
}

/// One change of the cell: the scenario as it would be, and where a pose of the path would be then, by
/// its share of the way.
type Change = (Scenario, Box<dyn Fn(&Pose, f64) -> Pose>);
type Make = Box<dyn Fn(&Scenario, f64) -> Change>;

struct Asked {
    key: String,
    what: String,
    by: String,
    make: Make,
}

/// Assesses a path (without one, the straight path) in cells that differ a little. `told` is called with
/// the changes done and in all, and answers whether to go on.
pub fn cell_sensitivity(
    scenario: &Scenario,
    seed: u64,
    repetitions: usize,
    path: Option<&FixedPath>,
    told: &dyn Fn(usize, usize) -> bool,
) -> Result<CellSensitivity, InputError> {
    let straight = minimum_jerk_line(&scenario.start, &scenario.goal, scenario.duration_s, STEPS)
        .map_err(|e| InputError::new(&scenario.file, e.to_string()))?;
    let (name, path) = path.map_or(("straight", None), |p| (p.name.as_str(), Some(&p.path)));
    let paths = (path.unwrap_or(&straight), path.is_some().then_some(&straight));
    let run = |(cell, moved): &Change, body: usize| {
        let slower = cell.duration_s / scenario.duration_s;
        outcome(cell, (seed, repetitions, body), paths, (slower, moved.as_ref()))
    };
    let unchanged: Change = (scenario.clone(), Box::new(|p, _| *p));
    let mut worst: Option<(usize, Outcome)> = None;
    for body in 0..scenario.worker.bodies.len() {
        let found = run(&unchanged, body)?;
        if worst.as_ref().is_none_or(|(_, o)| found.expected_rula > o.expected_rula) {
            worst = Some((body, found));
        }
    }
    let Some((body, nominal)) = worst else {
        return Err(InputError::new(&scenario.file, "names no body"));
    };
    let asked = asked(scenario);
    let mut quantities = Vec::new();
    for (i, a) in asked.iter().enumerate() {
        if !told(i, asked.len()) {
            return Err(InputError::new("check", "interrupted; nothing was written"));
        }
        let [less, more] = [-1.0, 1.0].map(|sign| run(&(a.make)(scenario, sign), body));
        let (less, more) = (less?, more?);
        let change = |f: fn(&Outcome) -> f64| {
            let of = |o: &Outcome| f(o) - f(&nominal);
            let (l, m) = (of(&less), of(&more));
            if l.abs() > m.abs() { l } else { m }
        };
        quantities.push(Quantity {
            key: a.key.clone(),
            what: a.what.clone(),
            by: a.by.clone(),
            rula_change: change(|o| o.expected_rula),
            exposure_change: change(|o| o.exposure_rula_5),
            changes_verdict: [&less, &more].iter().any(|o| o.verdict() != nominal.verdict()),
            less,
            more,
        });
    }
    quantities.sort_by(|a, b| b.rula_change.abs().total_cmp(&a.rula_change.abs()));
    Ok(CellSensitivity {
        body: scenario.worker.bodies[body].name.clone(),
        repetitions,
        path: name.to_owned(),
        nominal,
        quantities,
    })
}

/// A path, and the straight one to hold it against.
type Paths<'a> = (&'a TimedPath, Option<&'a TimedPath>);

/// Where a change puts a pose of the path, by its share of the way.
type Moved<'a> = &'a dyn Fn(&Pose, f64) -> Pose;

fn outcome(
    cell: &Scenario,
    (seed, repetitions, body): (u64, usize, usize),
    (path, straight): Paths,
    (slower, moved): (f64, Moved),
) -> Result<Outcome, InputError> {
    let modelled = modelled(cell)?;
    let all = Person::all(cell, &modelled)?;
    let lens = lens(cell);
    let nominal = cell.nominal();
    let walk = |path: &TimedPath| {
        let path = carried(path, slower, moved);
        let which = ((seed, BLOCK), 0..repetitions);
        Figures::of(&all[body].scored(&path, &nominal, which, &lens), &lens)
    };
    let own = walk(path);
    let against = straight.map(|s| own.rula().less(walk(s).rula(), |f| &f.time_mean));
    Ok(Outcome {
        expected_rula: mean(&own.rula().time_mean),
        exposure_rula_5: mean(&own.rula().high),
        reach_exceeded: mean(&own.lost),
        against_straight: against,
    })
}

/// A path on a slower clock, with every pose where a change puts it.
fn carried(path: &TimedPath, slower: f64, moved: Moved) -> TimedPath {
    let way = path.arc_length_m();
    let all = path.length_m();
    let poses = path.poses.iter().zip(&way);
    let poses = poses.map(|(p, w)| moved(p, if all > 0.0 { w / all } else { 0.0 })).collect();
    let start = path.start_s();
    TimedPath { time_s: path.time_s.iter().map(|t| (t - start) * slower).collect(), poses }
}

fn about_z(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vec3::z_axis(), angle)
}

fn shifted(pose: &Pose, by: &Vec3) -> Pose {
    Pose::from_parts((pose.translation.vector + by).into(), pose.rotation)
}

/// A pose turned about the vertical, by a share of the angle.
fn turned(pose: &Pose, angle: f64) -> Pose {
    Pose::from_parts(pose.translation, about_z(angle) * pose.rotation)
}

/// Everything that is measured in a cell.
fn asked(scenario: &Scenario) -> Vec<Asked> {
    let mut all = Vec::new();
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        all.push(length(
            format!("start.position_m {letter}"),
            "place of the start",
            move |s, d| {
                let by = along(axis, d);
                s.start = shifted(&s.start, &by);
                Box::new(move |p, u| shifted(p, &(by * (1.0 - u))))
            },
        ));
        all.push(length(format!("goal.position_m {letter}"), "place of the goal", move |s, d| {
            let by = along(axis, d);
            s.goal = shifted(&s.goal, &by);
            Box::new(move |p, u| shifted(p, &(by * u)))
        }));
        all.push(length(
            format!("robot.base.position_m {letter}"),
            "place of the robot",
            move |s, d| {
                let by = along(axis, d);
                s.robot.base = shifted(&s.robot.base, &by);
                Box::new(move |p, _| shifted(p, &by))
            },
        ));
        if axis < 2 {
            all.push(length(
                format!("worker.at_m {letter}"),
                "place of the worker",
                move |s, d| {
                    s.worker.at_m[axis] += d;
                    Box::new(|p, _| *p)
                },
            ));
        }
    }
    all.push(length(
        match scenario.worker.stance {
            Stance::Standing { .. } => "worker.shoe_m",
            Stance::Seated { .. } => "worker.seat_height_m",
        },
        "height of the worker",
        |s, d| {
            match &mut s.worker.stance {
                Stance::Standing { shoe_m } => *shoe_m += d,
                Stance::Seated { seat_height_m, .. } => *seat_height_m += d,
            }
            Box::new(|p, _| *p)
        },
    ));
    all.push(angle("start yaw", "turn of the start", |s, a| {
        s.start = turned(&s.start, a);
        Box::new(move |p, u| turned(p, a * (1.0 - u)))
    }));
    all.push(angle("goal yaw", "turn of the goal", |s, a| {
        s.goal = turned(&s.goal, a);
        Box::new(move |p, u| turned(p, a * u))
    }));
    all.push(angle("robot.base yaw", "turn of the robot", |s, a| {
        let base = s.robot.base;
        s.robot.base = turned(&base, a);
        let moved = s.robot.base * base.inverse();
        Box::new(move |p, _| moved * p)
    }));
    all.push(angle("worker.facing_deg", "facing of the worker", |s, a| {
        s.worker.facing += a;
        Box::new(|p, _| *p)
    }));
    all.push(angle("grip roll", "handle on the tool, about its bar", |s, a| {
        s.grip *= about_z(a);
        Box::new(|p, _| *p)
    }));
    all.extend(shares(scenario));
    all
}

fn shares(scenario: &Scenario) -> Vec<Asked> {
    let t = &scenario.task;
    let mut all = vec![share("motion.duration_s", "duration", |s, f| s.duration_s *= f)];
    if t.part_mass_kg > 0.0 {
        all.push(share("task.part_mass_kg", "mass of the part", |s, f| {
            s.task.load_kg += s.task.part_mass_kg * s.task.human_load_share * (f - 1.0);
            s.task.part_mass_kg *= f;
        }));
        all.push(share("task.human_load_share", "share of the load", |s, f| {
            s.task.load_kg += s.task.part_mass_kg * s.task.human_load_share * (f - 1.0);
            s.task.human_load_share *= f;
        }));
    }
    if t.extra_load_kg > 0.0 {
        all.push(share("task.extra_load_kg", "load besides the part", |s, f| {
            s.task.load_kg += s.task.extra_load_kg * (f - 1.0);
            s.task.extra_load_kg *= f;
        }));
    }
    all
}

fn along(axis: usize, by: f64) -> Vec3 {
    Vec3::from_fn(|i, _| if i == axis { by } else { 0.0 })
}

type Carry = Box<dyn Fn(&Pose, f64) -> Pose>;

fn length(
    key: impl Into<String>,
    what: &str,
    set: impl Fn(&mut Scenario, f64) -> Carry + 'static,
) -> Asked {
    asked_by(key.into(), what, format!("{:.0} cm", 100.0 * LENGTH_M), LENGTH_M, set)
}

fn angle(key: &str, what: &str, set: impl Fn(&mut Scenario, f64) -> Carry + 'static) -> Asked {
    asked_by(key.to_owned(), what, format!("{ANGLE_DEG} deg"), ANGLE_DEG.to_radians(), set)
}

fn share(key: &str, what: &str, set: impl Fn(&mut Scenario, f64) + 'static) -> Asked {
    asked_by(key.to_owned(), what, format!("{:.0} %", 100.0 * SHARE), SHARE, move |s, by| {
        set(s, 1.0 + by);
        Box::new(|p, _| *p)
    })
}

fn asked_by(
    key: String,
    what: &str,
    by: String,
    size: f64,
    set: impl Fn(&mut Scenario, f64) -> Carry + 'static,
) -> Asked {
    let make: Make = Box::new(move |scenario, sign| {
        let mut cell = scenario.clone();
        let carry = set(&mut cell, sign * size);
        (cell, carry)
    });
    Asked { key, what: what.to_owned(), by, make }
}

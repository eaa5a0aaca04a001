//! A look at the cell without planning: who reaches start, goal and the straight path between them,
//! how near the robot comes to obstacles, what stands in the worker, and what to draw.
//!
//! Facts only; [`CellLook::findings`] says which of them are faults. The words are the command's.

use super::explain::setting;
use super::person::{Person, modelled};
use super::result::{PosePicture, Setting};
use crate::files::InputError;
use crate::human::reach_gap;
use crate::math::Pose;
use crate::path::Face;
use crate::path::{ProjectionSettings, shortest_duration_s};
use crate::robot::{
    Follow, FollowSettings, NoMotion, Starts, follow_from, min_clearance, start_postures,
};
use crate::scenario::{FacesAway, Freedom, LowHand, Scenario};
use crate::trajectory::minimum_jerk_line;
use serde::Serialize;

/// Start postures with which each end, and the straight path, is tried.
const TRIES: usize = 16;
/// Time steps of the straight path.
const STEPS: usize = 60;
/// How much longer than the shortest possible the straight minimum-jerk movement has to take at least:
/// its peaks of speed and acceleration are higher.
const SLOWER: f64 = 2.0;

/// An end of the movement outside the workspace.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutsideBox {
    /// "start" or "goal".
    pub end: &'static str,
    /// The face, such as `x <= 0.80 m`.
    pub face: Face,
    /// By how much, m.
    pub by_m: f64,
}

/// An obstacle in the worker.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intrusion {
    /// Body.
    pub body: String,
    /// Part of the body.
    pub part: String,
    /// The obstacle.
    pub obstacle: String,
    /// How deep, m.
    pub depth_m: f64,
}

/// A seated body whose feet do not get to the floor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HangingFeet {
    /// Body.
    pub body: String,
    /// Height of the soles above the floor, m.
    pub above_m: f64,
}

/// The cell as it would be at start and goal, and on the straight path between them.
#[derive(Debug, Clone, Serialize)]
pub struct CellLook {
    /// Everything in words and numbers.
    pub setting: Setting,
    /// The workspace box, lower and upper corner, m.
    pub workspace: Option<[[f64; 3]; 2]>,
    /// Base of the robot, world, m.
    pub base_m: [f64; 3],
    /// Floor point below the pelvis, m.
    pub worker_at_m: [f64; 2],
    /// Ends of the movement that are outside the workspace.
    pub outside: Vec<OutsideBox>,
    /// Longest duration that the scenario allows, s.
    pub duration_s: f64,
    /// Shortest duration of the straight movement under the limits of the TCP, s; none where an end
    /// is outside the workspace.
    pub shortest_s: Option<f64>,
    /// Each body's hand at start and goal.
    pub hands: Vec<HandReach>,
    /// Each body's hand along the straight path.
    pub along: Vec<HandAlong>,
    /// The robot at start and goal.
    pub robot: [RobotReach; 2],
    /// The robot along the straight path; none where it does not reach the start.
    pub robot_along: Option<RobotAlong>,
    /// Obstacles that stand in the worker.
    pub intrusions: Vec<Intrusion>,
    /// Seated bodies whose feet do not get to the floor.
    pub hanging_feet: Vec<HangingFeet>,
    /// An end too low for straight legs.
    pub low_hand: Option<LowHand>,
    /// The worker faces away from the task; said among the scenario's warnings.
    pub away: Option<FacesAway>,
    /// Person (first body, mean posture moved on to the pose) and robot at start and goal.
    pub pictures: [PosePicture; 2],
}

/// Whether a body's hand gets to an end of the movement.
#[derive(Debug, Clone, Serialize)]
pub struct HandReach {
    /// Body.
    pub body: String,
    /// "start" or "goal".
    pub end: &'static str,
    /// Start postures, drawn from the posture model, that get there with the grip turned as asked.
    pub reached: usize,
    /// Of so many.
    pub tries: usize,
    /// How much nearer it would have to be for the hand to get there turned in any way, m; about 0 where
    /// it does.
    pub gap_m: f64,
}

/// How a body's hand follows the straight path.
#[derive(Debug, Clone, Serialize)]
pub struct HandAlong {
    /// Body.
    pub body: String,
    /// Repetitions that set out.
    pub tries: usize,
    /// Repetitions that follow to the goal.
    pub followed: usize,
    /// Share of the duration after which the first of the others is left behind.
    pub lost_from: Option<f64>,
    /// Share of the way that the training data do not support.
    pub unsupported: f64,
    /// Share of the start postures beyond the 99 % quantile of the training postures.
    pub unusual_starts: f64,
}

/// Whether the robot gets to an end of the movement.
#[derive(Debug, Clone, Serialize)]
pub struct RobotReach {
    /// "start" or "goal".
    pub end: &'static str,
    /// Distinct postures within the joint limits that were found; none: out of reach.
    pub postures: usize,
    /// Distance of the nearest posture from the place, m.
    pub residual_m: f64,
    /// Its angle from the orientation, rad.
    pub residual_rad: f64,
    /// Largest clearance that one of the postures has from obstacles, m; negative when all touch, none
    /// without postures, obstacles or shapes.
    pub clearance_m: Option<f64>,
    /// What meets what there.
    pub nearest: Option<String>,
}

/// Whether the robot can follow the straight path, slowly enough for the limits of the TCP.
#[derive(Debug, Clone, Serialize)]
pub struct RobotAlong {
    /// Why not, and after which share of the duration; none where it can.
    pub stopped: Option<(NoMotion, f64)>,
    /// Least clearance from obstacles where it can, m.
    pub clearance_m: Option<f64>,
    /// What meets what there.
    pub nearest: Option<String>,
}

/// Looks at a scenario.
///
/// # Errors
/// Where bodies and posture model do not fit together.
pub fn look_at_cell(scenario: &Scenario) -> Result<CellLook, InputError> {
    let modelled = modelled(scenario)?;
    let people = Person::all(scenario, &modelled)?;
    let nominal = scenario.nominal();
    let ends = [("start", &scenario.start), ("goal", &scenario.goal)];
    let mut hands = Vec::new();
    for (person, body) in people.iter().zip(&scenario.worker.bodies) {
        let w = &scenario.worker;
        for (end, tcp) in ends {
            let to_rest = person.rest_for(tcp, &nominal).inverse();
            let grip = (to_rest * tcp * scenario.grip).translation.vector;
            hands.push(HandReach {
                body: person.name.clone(),
                end,
                reached: person.reaching(tcp, &nominal, TRIES),
                tries: TRIES,
                gap_m: reach_gap(body, w.hands.lead(), w.pelvis, &grip)?,
            });
        }
    }
    let settings = follow_settings(scenario);
    let robot = ends.map(|(end, tcp)| {
        let starts = start_postures(&scenario.robot, tcp, &settings);
        let (reach, best) = robot_at(scenario, end, &starts);
        (reach, best, starts)
    });
    let shortest_s = shortest(scenario);
    let (along, robot_along) =
        straight_way(scenario, &people, (&robot[0].2, &settings), shortest_s);
    let pictures = pictures(scenario, &people, [0, 1].map(|i| robot[i].1.as_deref()));
    let workspace = scenario.limits.workspace.as_ref().map(|b| [b.min.into(), b.max.into()]);
    Ok(CellLook {
        setting: setting(scenario),
        workspace,
        base_m: scenario.robot.base.translation.vector.into(),
        worker_at_m: scenario.worker.at_m,
        outside: OutsideBox::of(scenario),
        duration_s: scenario.free.range(Freedom::Duration).map_or(scenario.duration_s, |r| r[1]),
        shortest_s,
        hands,
        along,
        intrusions: people.iter().flat_map(|p| Intrusion::of(scenario, p)).collect(),
        hanging_feet: HangingFeet::of(scenario)?,
        low_hand: scenario.low_hand(),
        away: scenario.faces_away(),
        robot: robot.map(|(reach, ..)| reach),
        robot_along,
        pictures,
    })
}

fn follow_settings(scenario: &Scenario) -> FollowSettings {
    FollowSettings {
        seed: scenario.seed,
        obstacles: scenario.obstacles.clone(),
        ..FollowSettings::default()
    }
}

/// The first body, in its mean posture moved on to the pose, and the robot at start and goal.
fn pictures(
    scenario: &Scenario,
    people: &[Person],
    robot: [Option<&[f64]>; 2],
) -> [PosePicture; 2] {
    let nominal = scenario.nominal();
    let at = |tcp: &Pose, q: Option<&[f64]>| {
        people.first().map_or_else(
            || PosePicture {
                body: String::new(),
                time_s: 0.0,
                bones: Vec::new(),
                robot: Vec::new(),
            },
            |p| p.picture_at(tcp, &nominal, (&scenario.robot, q)),
        )
    };
    [at(&scenario.start, robot[0]), at(&scenario.goal, robot[1])]
}

/// The same where nothing else is known of the robot.
pub(super) fn cell_pictures(scenario: &Scenario, people: &[Person]) -> [PosePicture; 2] {
    let settings = follow_settings(scenario);
    let robot = [&scenario.start, &scenario.goal].map(|tcp| {
        let starts = start_postures(&scenario.robot, tcp, &settings);
        robot_at(scenario, "start", &starts).1
    });
    pictures(scenario, people, [0, 1].map(|i| robot[i].as_deref()))
}

/// Shortest duration of the straight movement, s.
fn shortest(scenario: &Scenario) -> Option<f64> {
    let settings = ProjectionSettings { steps: STEPS, ..ProjectionSettings::default() };
    shortest_duration_s(&scenario.start, &scenario.goal, &scenario.limits, &settings)
}

/// People and robot along the straight path, no quicker than the limits of the TCP allow.
fn straight_way(
    scenario: &Scenario,
    people: &[Person],
    (starts, settings): (&Starts, &FollowSettings),
    shortest_s: Option<f64>,
) -> (Vec<HandAlong>, Option<RobotAlong>) {
    let nominal = scenario.nominal();
    let duration_s = nominal.duration_s.max(SLOWER * shortest_s.unwrap_or(0.0));
    let path = minimum_jerk_line(&nominal.start, &nominal.goal, duration_s, STEPS);
    let Ok(path) = path else { return (Vec::new(), None) };
    let along = people.iter().map(|person| {
        let repetitions = person.repeat(&path, &nominal, (scenario.seed, 0), 0..TRIES);
        let lost: Vec<usize> =
            repetitions.all.iter().filter_map(|w| w.rollout.reach_exceeded_at).collect();
        let unusual = repetitions.all.iter().filter(|w| w.start.is_unusual).count();
        HandAlong {
            body: person.name.clone(),
            tries: TRIES,
            followed: TRIES - lost.len(),
            lost_from: lost.iter().min().map(|k| *k as f64 / STEPS as f64),
            unsupported: repetitions.extrapolation_share,
            unusual_starts: unusual as f64 / TRIES as f64,
        }
    });
    let robot = (!starts.postures.is_empty()).then(|| {
        let follow = |s: &FollowSettings| {
            follow_from(&scenario.robot, &path.time_s, &path.poses, &starts.postures, s)
        };
        let followed = match follow(settings) {
            Follow::Infeasible { .. } => {
                follow(&FollowSettings { is_thorough: true, ..settings.clone() })
            }
            done @ Follow::Feasible(_) => done,
        };
        match followed {
            Follow::Feasible(motion) => RobotAlong {
                stopped: None,
                clearance_m: motion.obstacle_nearest.as_ref().map(|n| n.distance_m),
                nearest: motion
                    .obstacle_nearest
                    .map(|n| format!("link `{}` and obstacle `{}`", n.link, n.obstacle)),
            },
            Follow::Infeasible { why } => RobotAlong {
                stopped: Some((why.clone(), why.time_s() / duration_s)),
                clearance_m: None,
                nearest: None,
            },
        }
    });
    (along.collect(), robot)
}

/// The robot at one end, and its posture there with the most room.
fn robot_at(
    scenario: &Scenario,
    end: &'static str,
    starts: &Starts,
) -> (RobotReach, Option<Vec<f64>>) {
    let room = |q: &Vec<f64>| min_clearance(&scenario.robot, q, &scenario.obstacles);
    let distance = |q: &Vec<f64>| room(q).map_or(f64::INFINITY, |n| n.distance_m);
    // The first of equals, so that the choice depends on nothing else.
    let best = starts.postures.iter().rev().max_by(|a, b| distance(a).total_cmp(&distance(b)));
    let nearest = best.and_then(room);
    let reach = RobotReach {
        end,
        postures: starts.postures.len(),
        residual_m: starts.residual_m,
        residual_rad: starts.residual_rad,
        clearance_m: nearest.as_ref().map(|n| n.distance_m),
        nearest: nearest.map(|n| format!("link `{}` and obstacle `{}`", n.link, n.obstacle)),
    };
    (reach, best.cloned())
}

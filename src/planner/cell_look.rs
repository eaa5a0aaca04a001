//! A look at the cell without planning: who reaches start and goal, how near the robot comes to
//! obstacles there, and what to draw.

use super::evaluate::Person;
use super::explain::setting;
use super::result::{PosePicture, Setting};
use crate::files::InputError;
use crate::human::reach_gap;
use crate::math::Pose;
use crate::robot::{FollowSettings, min_clearance, start_postures};
use crate::scenario::Scenario;
use serde::Serialize;

/// Start postures with which each end is tried.
const TRIES: usize = 16;

/// The cell as it would be at start and goal.
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
    /// Each body's hand at start and goal.
    pub hands: Vec<HandReach>,
    /// The robot at start and goal.
    pub robot: [RobotReach; 2],
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
    /// without postures or obstacles.
    pub clearance_m: Option<f64>,
    /// What meets what there.
    pub nearest: Option<String>,
}

impl CellLook {
    /// What keeps the movement from being possible at all, in sentences; empty if nothing was found.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        for r in &self.robot {
            if r.postures == 0 {
                faults.push(format!(
                    "the robot does not reach the {}: the nearest posture is {:.0} mm and {:.1} deg off",
                    r.end,
                    1e3 * r.residual_m,
                    r.residual_rad.to_degrees()
                ));
            }
            if let (Some(clearance), Some(what)) = (r.clearance_m, &r.nearest)
                && clearance <= 0.0
            {
                faults.push(format!("at the {} {what} touch in every posture found", r.end));
            }
        }
        for h in self.hands.iter().filter(|h| h.reached == 0) {
            let nearer = if h.gap_m > 1e-3 {
                format!("it would have to be {:.0} mm nearer", 1e3 * h.gap_m)
            } else {
                "the place is within reach, but not with the grip turned like that".to_owned()
            };
            faults
                .push(format!("the hand of `{}` does not get to the {}: {nearer}", h.body, h.end));
        }
        faults
    }
}

/// Looks at a scenario.
pub fn look_at_cell(scenario: &Scenario) -> Result<CellLook, InputError> {
    let people = Person::all(scenario, None)?;
    let nominal = scenario.nominal();
    let ends = [("start", &scenario.start), ("goal", &scenario.goal)];
    let mut hands = Vec::new();
    for (person, body) in people.iter().zip(&scenario.worker.bodies) {
        let w = &scenario.worker;
        let to_pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance).inverse();
        for (end, tcp) in ends {
            let grip = (to_pelvis * tcp * scenario.grip).translation.vector;
            hands.push(HandReach {
                body: person.name.clone(),
                end,
                reached: person.reaching(tcp, &nominal, TRIES),
                tries: TRIES,
                gap_m: reach_gap(body, w.side, &grip)?,
            });
        }
    }
    let robot = ends.map(|(end, tcp)| robot_at(scenario, end, tcp));
    let person = people.first();
    let pictures = [0, 1].map(|i| {
        let q = &robot[i].1;
        person.map_or_else(
            || PosePicture {
                body: String::new(),
                time_s: 0.0,
                bones: Vec::new(),
                robot: Vec::new(),
            },
            |p| p.picture_at(ends[i].1, &nominal, (&scenario.robot, q.as_deref())),
        )
    });
    let workspace = scenario.limits.workspace.as_ref().map(|b| [b.min.into(), b.max.into()]);
    Ok(CellLook {
        setting: setting(scenario),
        workspace,
        base_m: scenario.robot.base.translation.vector.into(),
        worker_at_m: scenario.worker.at_m,
        hands,
        robot: robot.map(|(reach, _)| reach),
        pictures,
    })
}

/// The robot at one end, and its posture there with the most room.
fn robot_at(scenario: &Scenario, end: &'static str, tcp: &Pose) -> (RobotReach, Option<Vec<f64>>) {
    let settings = FollowSettings { seed: scenario.seed, ..FollowSettings::default() };
    let starts = start_postures(&scenario.robot, tcp, &settings);
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

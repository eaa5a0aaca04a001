//! Which facts of a cell's look are faults: what keeps the movement from being possible, and what a
//! designer should look at before planning.

use super::cell_look::{
    CellLook, HandAlong, HandReach, HangingFeet, Intrusion, OutsideBox, RobotReach,
};
use super::person::Person;
use crate::files::InputError;
use crate::human::{Body, Coupled, Segment, Side, Skeleton, Stance};
use crate::path::Box3;
use crate::robot::{AssumedShapes, NoMotion};
use crate::scenario::{LowHand, Scenario};

/// Share of the start postures that has to get to an end, and of the repetitions that has to follow.
const ENOUGH: f64 = 0.75;
/// Share of the way, and of the starts, from which the recordings count as not supporting it.
const MOST_UNSUPPORTED: f64 = 0.5;
/// Depth of an obstacle in a body that cushions, clothes and the capsules' roundness explain, m.
pub(super) const SOFT_M: f64 = 0.02;
/// Depth from which an obstacle goes through the body, m; toes below a bench are less deep.
const THROUGH_M: f64 = 0.10;
/// Soles of a seated worker, and height of the feet that a raised heel explains, m.
const SHOE_M: f64 = 0.03;
const RAISED_HEEL_M: f64 = 0.03;

/// A fault of a cell.
#[derive(Debug, Clone, Copy)]
pub enum CellFinding<'a> {
    /// An end of the movement is outside the workspace.
    Outside(&'a OutsideBox),
    /// The duration is below the shortest possible.
    TooQuick {
        /// Longest that the scenario allows, s.
        duration_s: f64,
        /// Shortest possible, s.
        shortest_s: f64,
    },
    /// The robot does not get to an end.
    RobotOutOfReach(&'a RobotReach),
    /// The robot touches an obstacle at an end in every posture found.
    RobotTouches(&'a RobotReach),
    /// There are obstacles, but the robot has no shapes to measure distances from.
    ObstaclesUnchecked,
    /// Links of the robot whose shapes are not known, and that are checked as assumed capsules.
    AssumedShapes(&'a AssumedShapes),
    /// The robot cannot follow the straight path: why, and after which share of the duration.
    RobotStopped(&'a NoMotion, f64),
    /// The robot touches an obstacle on the straight path.
    RobotTouchesOnTheWay(&'a str),
    /// A body's hand does not get to an end at all.
    HandOutOfReach(&'a HandReach),
    /// Few start postures get there.
    HandAtItsEnd(&'a HandReach),
    /// Many repetitions cannot follow the straight path.
    HandLeftBehind(&'a HandAlong),
    /// The training data do not support most of the straight path.
    Unsupported(&'a HandAlong),
    /// Most start postures are unlike those of the training data.
    UnusualStarts(&'a HandAlong),
    /// An obstacle stands in the worker.
    Intrusion(&'a Intrusion),
    /// Feet above the floor.
    HangingFeet(&'a HangingFeet),
    /// An end too low for straight legs.
    LowHand(&'a LowHand),
}

impl CellFinding<'_> {
    /// Whether it keeps the movement from being possible, whatever path is planned.
    pub fn is_error(&self) -> bool {
        matches!(
            self,
            Self::Outside(_)
                | Self::TooQuick { .. }
                | Self::RobotOutOfReach(_)
                | Self::RobotTouches(_)
                | Self::HandOutOfReach(_)
        ) || matches!(self, Self::Intrusion(i) if i.depth_m > THROUGH_M)
    }
}

impl CellLook {
    /// All faults, errors first.
    pub fn findings(&self) -> Vec<CellFinding<'_>> {
        use CellFinding as F;
        let mut all: Vec<F> = self.outside.iter().map(F::Outside).collect();
        if let Some(shortest_s) = self.shortest_s.filter(|s| *s > self.duration_s) {
            all.push(F::TooQuick { duration_s: self.duration_s, shortest_s });
        }
        for r in &self.robot {
            if r.postures == 0 {
                all.push(F::RobotOutOfReach(r));
            } else if r.clearance_m.is_some_and(|c| c <= 0.0) {
                all.push(F::RobotTouches(r));
            }
        }
        let is_blind = |r: &RobotReach| r.postures > 0 && r.clearance_m.is_none();
        if !self.setting.obstacles.is_empty() && self.robot.iter().any(is_blind) {
            all.push(F::ObstaclesUnchecked);
        }
        all.extend(self.setting.robot.assumed_shapes.iter().map(F::AssumedShapes));
        for h in &self.hands {
            let share = h.reached as f64 / h.tries.max(1) as f64;
            if h.reached == 0 {
                all.push(F::HandOutOfReach(h));
            } else if share < ENOUGH {
                all.push(F::HandAtItsEnd(h));
            }
        }
        all.extend(self.along_findings());
        all.extend(self.intrusions.iter().map(F::Intrusion));
        all.extend(self.hanging_feet.iter().map(F::HangingFeet));
        all.extend(self.low_hand.iter().map(F::LowHand));
        all.sort_by_key(|f| !f.is_error());
        all
    }

    /// Faults on the straight path; what is lost at the start already is told there.
    fn along_findings(&self) -> Vec<CellFinding<'_>> {
        use CellFinding as F;
        let mut all = Vec::new();
        if let Some(robot) = &self.robot_along {
            if let Some((why, at)) = &robot.stopped {
                all.push(F::RobotStopped(why, *at));
            }
            let touches_at_end = self.robot.iter().any(|r| r.clearance_m.is_some_and(|c| c <= 0.0));
            if let (Some(clearance), Some(what)) = (robot.clearance_m, &robot.nearest)
                && clearance <= 0.0
                && !touches_at_end
            {
                all.push(F::RobotTouchesOnTheWay(what));
            }
        }
        for h in &self.along {
            let at_ends = self.hands.iter().filter(|e| e.body == h.body);
            let fewest = at_ends.map(|e| e.reached).min().unwrap_or(h.tries);
            if (h.followed as f64) < ENOUGH * h.tries as f64 && h.followed < fewest {
                all.push(F::HandLeftBehind(h));
            }
            if h.unsupported > MOST_UNSUPPORTED {
                all.push(F::Unsupported(h));
            }
            if h.unusual_starts > MOST_UNSUPPORTED {
                all.push(F::UnusualStarts(h));
            }
        }
        all
    }
}

impl OutsideBox {
    pub(super) fn of(scenario: &Scenario) -> Vec<Self> {
        let Some(workspace) = &scenario.limits.workspace else { return Vec::new() };
        let mut all = Vec::new();
        for (end, tcp) in [("start", &scenario.start), ("goal", &scenario.goal)] {
            for (axis, is_upper) in Box3::faces() {
                let by_m = workspace.excess(&tcp.translation.vector, axis, is_upper);
                if by_m > 0.0 {
                    all.push(Self { end, face: workspace.face(axis, is_upper), by_m });
                }
            }
        }
        all
    }
}

impl Intrusion {
    /// The deepest part in each obstacle but hand and forearm of the coupled side, with the mean posture at the start (or at the goal where the
    /// hand does not get to the start).
    pub(super) fn of(scenario: &Scenario, person: &Person) -> Vec<Self> {
        let nominal = scenario.nominal();
        let placed = [&scenario.start, &scenario.goal]
            .into_iter()
            .find_map(|tcp| person.placed_at(tcp, &nominal));
        let ends = placed.unwrap_or_else(|| person.placed_upright(&nominal));
        let deepest = |(name, obstacle): &(String, crate::robot::Obstacle)| {
            let parts = person.parts().iter().zip(&ends).filter(|(part, _)| !part.is_coupled);
            let depth = parts
                .map(|(part, [a, b])| (part, -obstacle.distance_to_capsule(a, b, part.radius_m)));
            let (part, depth_m) = depth.max_by(|a, b| a.1.total_cmp(&b.1))?;
            (depth_m > SOFT_M).then(|| Self {
                body: person.name.clone(),
                part: part.name.clone(),
                obstacle: name.clone(),
                depth_m,
            })
        };
        scenario.obstacles.iter().filter_map(deepest).collect()
    }
}

impl HangingFeet {
    pub(super) fn of(scenario: &Scenario) -> Result<Vec<Self>, InputError> {
        let worker = &scenario.worker;
        let Stance::Seated { footrest_m, .. } = worker.stance else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        // Of a population the shortest stands for those whose feet hang.
        for (body, members) in worker.bodies.iter().zip(&worker.members) {
            let by_stature = |a: &&Body, b: &&Body| a.size.stature_m.total_cmp(&b.size.stature_m);
            let body = members.iter().min_by(by_stature).unwrap_or(body);
            let skeleton = Skeleton::new(body, Coupled::arm(Side::Right), worker.stance, true)?;
            let upright = skeleton.pose(&vec![0.0; skeleton.dof()]);
            let [thigh, shank] = ["RightUpperLeg", "RightLowerLeg"].map(|s| skeleton.segment(s));
            let height = |segment: Segment| upright.at(segment).translation.vector.y;
            // Thighs level and shanks upright: the knee is as high as the hip.
            let pelvis = body.pelvis_pose(worker.at_m, worker.facing, worker.stance);
            let hip_m = pelvis.translation.vector.z + height(thigh?);
            let knee_to_sole_m = body.standing_pelvis_height_m + height(shank?);
            let above_m = hip_m - knee_to_sole_m - SHOE_M - footrest_m;
            if above_m > RAISED_HEEL_M {
                all.push(Self { body: body.name.clone(), above_m });
            }
        }
        Ok(all)
    }
}

//! The list of all checks of a path: each kept, broken or not checked.

use super::checked::{CheckState, Checked, Subject, Why};
use super::prepare::Prepared;
use super::refusal::{Refusal, Status};
use super::result::{BodyScores, CandidateResult};
use crate::path::{LimitName, NoPath};
use crate::robot::{NoMotion, NotChecked, ObstacleClearance, SelfClearance};
use crate::scenario::Scenario;

/// Rows from which the acceleration along a path of the user's can be told.
const FEWEST_ROWS: usize = 4;

/// All checks of a path, in the order of [`Subject::ALL`]. What the scenario gives no limit for is not among
/// them.
pub(super) fn checklist(
    scenario: &Scenario,
    prepared: &Prepared,
    result: &CandidateResult,
) -> Vec<Checked> {
    let list = List { scenario, prepared, result };
    Subject::ALL.into_iter().flat_map(|s| list.of(s)).collect()
}

struct List<'a> {
    scenario: &'a Scenario,
    prepared: &'a Prepared,
    result: &'a CandidateResult,
}

impl List<'_> {
    fn of(&self, subject: Subject) -> Vec<Checked> {
        if !self.is_asked(subject) {
            return Vec::new();
        }
        let one = |state| vec![Checked { subject, body: None, state }];
        let each = |of: &dyn Fn(&str) -> CheckState| {
            let bodies = self.scenario.worker.bodies.iter();
            let check =
                |name: &str| Checked { subject, body: Some(name.to_owned()), state: of(name) };
            bodies.map(|b| check(&b.name)).collect()
        };
        match subject {
            Subject::Joints => one(self.joints()),
            Subject::Obstacles => one(self.obstacles()),
            Subject::Itself => one(self.itself()),
            Subject::Person => each(&|body| self.person(body)),
            Subject::Hand => each(&|body| self.hand(body)),
            _ => one(self.measured(subject)),
        }
    }

    /// Whether there is a limit to be kept.
    fn is_asked(&self, subject: Subject) -> bool {
        let limits = &self.scenario.limits;
        match subject {
            Subject::Workspace => limits.workspace.is_some(),
            Subject::ToolClearance | Subject::Obstacles => !self.scenario.obstacles.is_empty(),
            Subject::Corridor => limits.corridor_m.is_some() && !self.prepared.is_users,
            Subject::Continuity => !self.prepared.is_users,
            _ => true,
        }
    }

    fn refusals(&self) -> &[Refusal] {
        match &self.result.status {
            Status::Feasible => &[],
            Status::Marked { violations } => violations,
            Status::Infeasible { refusal } => std::slice::from_ref(refusal),
        }
    }

    /// Whether the path was refused for this.
    fn is_refused(&self, subject: Subject, body: Option<&str>) -> bool {
        self.refusals().iter().any(|r| {
            let (subjects, whose) = about(r);
            subjects.contains(&subject) && (body.is_none() || whose == body)
        })
    }

    /// Broken if refused for it, else as it was found; a path that was refused for something else was not
    /// looked at further.
    fn state(&self, subject: Subject, body: Option<&str>, found: Option<CheckState>) -> CheckState {
        let is_out = matches!(self.result.status, Status::Infeasible { .. });
        if self.is_refused(subject, body) {
            return CheckState::Broken;
        }
        found.unwrap_or(CheckState::NotChecked {
            why: if is_out { Why::Refused } else { Why::Robot(NotChecked::NoMotion) },
        })
    }

    /// Quantities of the tool's movement.
    fn measured(&self, subject: Subject) -> CheckState {
        let mut checks = self
            .prepared
            .checks
            .iter()
            .filter(|c| Subject::of(c.quantity) == Some(subject))
            .peekable();
        let is_known = checks.peek().is_some();
        if checks.any(|c| !c.is_met()) {
            return CheckState::Broken;
        }
        let users = self.scenario.paths.iter().find(|p| p.name == self.prepared.id);
        let few = users
            .filter(|_| self.prepared.is_users)
            .is_some_and(|p| p.path.time_s.len() < FEWEST_ROWS);
        let is_rate =
            matches!(subject, Subject::Acceleration | Subject::Jerk | Subject::AngularAcceleration);
        let too_few = CheckState::NotChecked { why: Why::TooFewRows };
        let found = if is_known && !(few && is_rate) {
            Some(CheckState::Kept)
        } else {
            self.prepared.is_users.then_some(too_few)
        };
        self.state(subject, None, found)
    }

    fn joints(&self) -> CheckState {
        let of_joints = |c: &&crate::path::Check| Subject::of(c.quantity) == Some(Subject::Joints);
        let is_broken = self.prepared.checks.iter().filter(of_joints).any(|c| !c.is_met());
        let found = self.prepared.robot.as_ref().map(|_| kept(!is_broken));
        self.state(Subject::Joints, None, found)
    }

    fn obstacles(&self) -> CheckState {
        let (robot, motion) = (&self.scenario.robot, self.prepared.robot.as_ref());
        let found = match robot.obstacle_clearance(motion, self.scenario.obstacles.len()) {
            ObstacleClearance::Least { nearest, .. } => Some(kept(nearest.distance_m > 0.0)),
            ObstacleClearance::NotChecked { why } => Self::unknown(why),
            ObstacleClearance::NoObstacle => None,
        };
        self.state(Subject::Obstacles, None, found)
    }

    fn itself(&self) -> CheckState {
        let found = match self.scenario.robot.self_clearance(self.prepared.robot.as_ref()) {
            SelfClearance::Least { nearest, .. } => Some(kept(nearest.distance_m > 0.0)),
            SelfClearance::NotChecked { why } => Self::unknown(why),
        };
        self.state(Subject::Itself, None, found)
    }

    fn person(&self, body: &str) -> CheckState {
        let scores = self.scores(body);
        let found = match scores.map(|b| b.person_clearance.as_ref()) {
            Some(Some(clearance)) => Some(kept(clearance.is_kept())),
            Some(None) => match self.scenario.robot.not_checked() {
                Some(why) => Self::unknown(why),
                None if self.prepared.robot.is_some() => {
                    Some(CheckState::NotChecked { why: Why::NobodyFollows })
                }
                None => None,
            },
            None => None,
        };
        self.state(Subject::Person, Some(body), found)
    }

    fn hand(&self, body: &str) -> CheckState {
        let found = self.scores(body).map(|b| kept(b.reach_exceeded == 0.0));
        self.state(Subject::Hand, Some(body), found)
    }

    fn scores(&self, body: &str) -> Option<&BodyScores> {
        self.result.bodies.iter().find(|b| b.body == body)
    }

    /// Not checked for what is known of the robot; nothing where there is no motion because the path was
    /// refused.
    fn unknown(why: NotChecked) -> Option<CheckState> {
        let is_open = why == NotChecked::NoMotion;
        (!is_open).then_some(CheckState::NotChecked { why: Why::Robot(why) })
    }
}

fn kept(is_kept: bool) -> CheckState {
    if is_kept { CheckState::Kept } else { CheckState::Broken }
}

/// What a refusal is about, and whose body it concerns.
fn about(refusal: &Refusal) -> (Vec<Subject>, Option<&str>) {
    match refusal {
        Refusal::Path(why) => (of_path(why), None),
        Refusal::Robot(NoMotion::TouchesItself { .. }) => (vec![Subject::Itself], None),
        Refusal::Robot(_)
        | Refusal::Start { .. }
        | Refusal::BetweenKnots(_)
        | Refusal::JointLimit(_) => (vec![Subject::Joints], None),
        Refusal::Limit(check) => (Subject::of(check.quantity).into_iter().collect(), None),
        Refusal::Obstacle { .. } => (vec![Subject::Obstacles], None),
        Refusal::Worker { body, .. } => (vec![Subject::Hand], Some(body)),
        Refusal::Person { body, .. } => (vec![Subject::Person], Some(body)),
    }
}

fn of_path(why: &NoPath) -> Vec<Subject> {
    let of_limit = |limit: &LimitName| match limit {
        LimitName::Speed => Subject::Speed,
        LimitName::Acceleration => Subject::Acceleration,
        LimitName::Jerk => Subject::Jerk,
        LimitName::Face(_) => Subject::Workspace,
    };
    match why {
        NoPath::OutsideBox { .. } => vec![Subject::Workspace],
        NoPath::InsideObstacle { .. } | NoPath::Blocked { .. } => vec![Subject::ToolClearance],
        NoPath::BeyondReach { .. } | NoPath::LeavesReach { .. } => vec![Subject::ReachBall],
        NoPath::TooShortToTurn { .. } => vec![Subject::AngularSpeed, Subject::AngularAcceleration],
        NoPath::TooShort { .. } => vec![Subject::Speed, Subject::Acceleration, Subject::Jerk],
        NoPath::JointsTooSlow | NoPath::NoMotion { .. } => vec![Subject::Joints],
        NoPath::Contradiction { limits } => limits.iter().map(of_limit).collect(),
        NoPath::Corridor { .. } => vec![Subject::Corridor],
        NoPath::Input { .. } | NoPath::Unsolved { .. } => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Check, Family, Quantity};
    use crate::planner::Evaluated;
    use crate::scenario::read_scenario;
    use std::path::Path;

    /// What the list says of one quantity of a planned path with these checks and this status.
    fn state(subject: Subject, checks: &[Check], status: Status) -> CheckState {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        let mut scenario = read_scenario(&folder.join("bench_pick_and_place.toml")).unwrap();
        scenario.limits.corridor_m = Some(0.3);
        let prepared = Prepared {
            id: "made".to_owned(),
            variant: scenario.nominal(),
            family: Family::Straight,
            vias_m: Vec::new(),
            status,
            reference: None,
            path: None,
            checks: checks.to_vec(),
            robot: None,
            moved_m: 0.0,
            severity: 0.0,
            changes: Vec::new(),
            is_users: false,
            ends: None,
        };
        let result = super::super::reporting::bare(&prepared, Evaluated::None);
        let list = checklist(&scenario, &prepared, &result);
        list.iter().find(|c| c.subject == subject).unwrap().state
    }

    #[test]
    fn a_fault_of_the_projection_is_broken_and_not_unseen() {
        for (subject, quantity) in
            [(Subject::Continuity, Quantity::Continuity), (Subject::Corridor, Quantity::Corridor)]
        {
            let of = |value| Check { quantity, value, limit: 0.0, at_s: 1.0 };
            let refused = |value| Status::Infeasible { refusal: Refusal::Limit(of(value)) };
            assert_eq!(state(subject, &[of(-0.1)], Status::Feasible), CheckState::Kept);
            assert_eq!(state(subject, &[of(0.1)], refused(0.1)), CheckState::Broken);
            let open = Status::Infeasible { refusal: Refusal::Path(NoPath::JointsTooSlow) };
            assert_eq!(state(subject, &[], open), CheckState::NotChecked { why: Why::Refused });
            // A value that is no number is no kept limit.
            let nothing = of(f64::INFINITY);
            assert_eq!(state(subject, &[nothing], refused(1.0)), CheckState::Broken);
        }
    }
}

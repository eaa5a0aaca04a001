//! When every path is refused: the cause once, and the smallest change of each kind that would help.

use super::person::Person;
use super::prepare::{Prepared, Workshop};
use super::refusal::{Hint, RefusedBy, RefusedGroup, Status};
use super::result::{CandidateResult, Caveat, Decision, Verdict};
use crate::human::reach_gap;
use crate::path::{Change, End, Family, smallest_changes};
use crate::scenario::Scenario;

/// Start postures by which an end of the movement is tried.
const TRIES: usize = 8;
/// Distance below which a place counts as reached, m.
const REACHED_M: f64 = 1e-3;

/// The verdict of a run without a feasible path: each kind of cause once, with its first case.
pub(super) fn nothing_feasible(candidates: &[CandidateResult], caveat: Option<Caveat>) -> Verdict {
    let refusals = candidates.iter().filter_map(|c| match &c.status {
        Status::Infeasible { refusal } => Some(refusal),
        Status::Feasible | Status::Marked { .. } => None,
    });
    let refused = RefusedGroup::of(refusals);
    Verdict { refused, ..Verdict::of(Decision::NothingFeasible, caveat) }
}

impl Workshop<'_> {
    /// Puts into the verdict of a run without a feasible path what would help.
    pub(super) fn explain(&self, prepared: &[&Prepared], verdict: &mut Verdict) {
        let refused: Vec<(&Prepared, RefusedBy)> =
            prepared.iter().filter_map(|p| Some((*p, p.status.refused_by()?))).collect();
        // The straight path is the plainest; without it the first.
        let is_plain = |p: &Prepared| p.family == Family::Straight;
        let plain = refused.iter().find(|(p, _)| is_plain(p)).or(refused.first());
        let Some((plain, by)) = plain else { return };
        verdict.changes = match by {
            RefusedBy::Path => plain.reference.as_ref().map_or_else(Vec::new, |reference| {
                let settings = self.projection_settings();
                smallest_changes(reference, &self.scenario().limits, &self.scene(), &settings)
            }),
            RefusedBy::Worker => self.nearer_hands(plain),
            RefusedBy::Robot | RefusedBy::Obstacle | RefusedBy::Person => plain.changes.clone(),
        };
        if verdict.changes.is_empty() && *by == RefusedBy::Worker {
            verdict.hints.push(Hint::HandTurned { hold: self.scenario().hold });
        }
        if !verdict.changes.is_empty() {
            verdict.hints.push(Hint::Changes { changes: verdict.changes.clone() });
        }
    }

    /// For each body, how much nearer the path would have to be for its hand to get to every place.
    fn nearer_hands(&self, prepared: &Prepared) -> Vec<Change> {
        let (scenario, w) = (self.scenario(), &self.scenario().worker);
        let Some(path) = &prepared.path else { return Vec::new() };
        let gap = |body: &crate::human::Body| {
            let to_pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance).inverse();
            let of = |tcp: &crate::math::Pose| {
                let grip = (to_pelvis * tcp * scenario.grip).translation.vector;
                reach_gap(body, w.hands.lead(), w.pelvis, &grip).unwrap_or(0.0)
            };
            // A few places along the path tell as much as all.
            let stride = (path.poses.len() / 8).max(1);
            let by_m = path.poses.iter().rev().step_by(stride).map(of).fold(0.0, f64::max);
            (by_m > REACHED_M).then(|| Change::ExtendReach { body: body.name.clone(), by_m })
        };
        w.bodies.iter().filter_map(gap).collect()
    }
}

/// Which ends of the movement a body's hand does not get to, whatever else refused the paths.
pub(super) fn unreached_ends(scenario: &Scenario, people: &[Person]) -> Vec<Hint> {
    let mut hints = Vec::new();
    for person in people {
        for (end, tcp) in [(End::Start, &scenario.start), (End::Goal, &scenario.goal)] {
            let reached = person.reaching(tcp, &scenario.nominal(), TRIES);
            if 2 * reached < TRIES {
                let (body, failed) = (person.name.clone(), TRIES - reached);
                hints.push(Hint::Unreached { body, end, failed, tries: TRIES });
            }
        }
    }
    if !hints.is_empty() && scenario.low_hand().is_some() {
        hints.push(Hint::NeedsBentLegs);
    }
    hints
}

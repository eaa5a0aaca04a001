//! When every path is refused: the cause once, and the smallest change of each kind that would help.

use super::evaluate::Person;
use super::prepare::{Prepared, Workshop};
use super::result::{CandidateResult, Caveat, Decision, Status, Verdict};
use crate::human::{Stance, reach_ball, reach_gap};
use crate::path::{Change, Reach, smallest_changes};
use crate::scenario::Scenario;

/// Start postures by which an end of the movement is tried.
const TRIES: usize = 8;
/// Height of the hand below which people bend their legs, m.
const LOW_HAND_M: f64 = 0.55;
const NEEDS_BENT_LEGS: &str =
    "The low end needs bent legs: ergopath keeps them straight, so it cannot judge this station.";
/// Distance below which a place counts as reached, m.
const REACHED_M: f64 = 1e-3;

/// Where each body's hand can be led: a ball about the shoulder, widened by the offset between the
/// grip and the TCP, which the hand's turn may put anywhere.
pub(super) fn reaches(scenario: &Scenario) -> Vec<Reach> {
    let w = &scenario.worker;
    let of = |body: &crate::human::Body| {
        let (center, radius) = reach_ball(body, w.side).ok()?;
        let pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance);
        Some(Reach {
            body: body.name.clone(),
            center: (pelvis * nalgebra::Point3::from(center)).coords,
            radius_m: radius + scenario.grip.translation.vector.norm(),
        })
    };
    w.bodies.iter().filter_map(of).collect()
}

/// The verdict of a run without a feasible path: each kind of cause once, with its first case.
pub(super) fn nothing_feasible(candidates: &[CandidateResult], caveat: Option<Caveat>) -> Verdict {
    // Stage and kind of sentence, the first sentence of that kind, how many, whether all are equal.
    let mut reasons: Vec<(String, String, usize, bool)> = Vec::new();
    let mut marked = Vec::new();
    for c in candidates {
        match &c.status {
            Status::Infeasible { stage, reason } => {
                let kind = format!("{stage}: {}", without_numbers(reason));
                let text = format!("{stage}: {reason}");
                match reasons.iter_mut().find(|r| r.0 == kind) {
                    Some((_, first, n, is_same)) => {
                        *n += 1;
                        *is_same &= *first == text;
                    }
                    None => reasons.push((kind, text, 1, true)),
                }
            }
            Status::Marked { violations } => {
                marked.push(format!("`{}` is over a limit: {}", c.id, violations.join("; ")));
            }
            Status::Feasible => {}
        }
    }
    reasons.sort_by(|a, b| b.2.cmp(&a.2).then(a.0.cmp(&b.0)));
    let mut lines: Vec<String> = reasons
        .into_iter()
        .take(5)
        .map(|(_, text, n, is_same)| {
            let like = if is_same { "" } else { "for example " };
            format!("{n} of {}: {like}{text}", candidates.len())
        })
        .collect();
    lines.extend(marked);
    Verdict { lines, ..Verdict::of(Decision::NothingFeasible, caveat) }
}

/// The sentence up to what would help, without its numbers: equal for equal causes.
fn without_numbers(reason: &str) -> String {
    let cause = reason.split("; what would help").next().unwrap_or(reason);
    let mut is_quoted = false;
    let keep = |c: &char| {
        is_quoted ^= *c == '`';
        is_quoted || !(c.is_ascii_digit() || ".-".contains(*c))
    };
    cause.chars().filter(keep).collect()
}

impl Workshop<'_> {
    /// Puts into the verdict of a run without a feasible path what would help.
    pub(super) fn explain(&self, prepared: &[&Prepared], verdict: &mut Verdict) {
        let refused: Vec<(&Prepared, &str)> = prepared
            .iter()
            .filter_map(|p| match &p.status {
                Status::Infeasible { stage, .. } => Some((*p, stage.as_str())),
                _ => None,
            })
            .collect();
        // The straight path is the plainest; without it the first.
        let plain = refused.iter().find(|(p, _)| p.id == "straight").or(refused.first());
        let Some((plain, stage)) = plain else { return };
        verdict.changes = match *stage {
            "path" => plain.reference.as_ref().map_or_else(Vec::new, |reference| {
                let settings = self.projection_settings();
                smallest_changes(reference, &self.scenario().limits, &self.scene(), &settings)
            }),
            "worker" => self.nearer_hands(plain),
            _ => plain.changes.clone(),
        };
        if verdict.changes.is_empty() && *stage == "worker" {
            verdict.lines.push(
                "Every place of the path can be reached by the hand, but not with the hand turned and \
                 led like this: another start posture, hold = \"free_roll\" or \"point\", or a shorter \
                 way may help."
                    .to_owned(),
            );
        }
        if !verdict.changes.is_empty() {
            let all: Vec<String> = verdict.changes.iter().map(ToString::to_string).collect();
            verdict.lines.push(format!("What would help, each alone: {}.", all.join("; ")));
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
                reach_gap(body, w.side, &grip).unwrap_or(0.0)
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
pub(super) fn unreached_ends(scenario: &Scenario, people: &[Person]) -> Vec<String> {
    let mut lines = Vec::new();
    for person in people {
        for (name, tcp) in [("start", &scenario.start), ("goal", &scenario.goal)] {
            let reached = person.reaching(tcp, &scenario.nominal(), TRIES);
            if 2 * reached < TRIES {
                lines.push(format!(
                    "The hand of body `{}` does not get to the {name} with the grip turned as asked ({} of \
                     {TRIES} start postures fail).",
                    person.name,
                    TRIES - reached
                ));
            }
        }
    }
    let lowest = scenario.start.translation.vector.z.min(scenario.goal.translation.vector.z);
    let is_standing = matches!(scenario.worker.stance, Stance::Standing { .. });
    if !lines.is_empty() && is_standing && lowest < LOW_HAND_M {
        lines.push(NEEDS_BENT_LEGS.to_owned());
    }
    lines
}

//! Why no path is feasible, and what may help, in words.

use super::end;
use super::path::change;
use super::refusal::{all, key, refusal};
use crate::path::Change;
use crate::planner::{Decision, Hint, RefusedGroup, RunResult, Status};
use crate::posture::Hold;

/// Kinds of refusals that are told.
const MOST_TOLD: usize = 5;

/// All of it, a sentence each; nothing where a path is feasible.
pub fn lines(result: &RunResult) -> Vec<String> {
    let verdict = &result.verdict;
    let mut lines = Vec::new();
    if verdict.outcome == Decision::NothingFeasible {
        let count = result.candidates.len();
        let groups = verdict.refused.iter().take(MOST_TOLD);
        lines.extend(groups.map(|g| group(g, count)));
        lines.extend(result.candidates.iter().filter_map(|c| match &c.status {
            Status::Marked { violations } => {
                Some(format!("`{}` is over a limit: {}", c.id, all(violations)))
            }
            Status::Feasible | Status::Infeasible { .. } => None,
        }));
    }
    lines.extend(verdict.hints.iter().map(hint));
    lines
}

/// Refused paths of one kind, of `count` paths.
pub fn group(group: &RefusedGroup, count: usize) -> String {
    let like = if group.all_equal { "" } else { "for example " };
    let RefusedGroup { first, count: refused, .. } = group;
    format!("{refused} of {count}: {like}{}: {}", key(first.by()), refusal(first))
}

/// A hint as a sentence.
pub fn hint(hint: &Hint) -> String {
    match hint {
        Hint::HandTurned { hold } => {
            let looser = match hold {
                Hold::Rigid => ", hold = \"free_roll\" or \"point\",",
                Hold::FreeRoll => ", hold = \"point\",",
                Hold::Point | Hold::Planar => "",
            };
            format!(
                "The hand can reach every place of the path, but not in this orientation and with this start: \
                 another start posture{looser} or a shorter path may help."
            )
        }
        Hint::Changes { changes } => {
            format!("What would help, each alone: {}.", listed(changes))
        }
        Hint::NearestToFeasible { id, missing_m } => format!(
            "Nearest to feasible is `{id}`: {:.0} mm of the margin to the person are missing.",
            (1e3 * missing_m).ceil()
        ),
        Hint::Apart { changes, tried_m } if changes.is_empty() => format!(
            "Neither the robot's base nor the worker up to {:.0} mm farther away makes the straight path \
             feasible; another place or mounting of the robot, or a smaller person_clearance_m, may.",
            1e3 * tried_m
        ),
        Hint::Apart { changes, .. } => {
            format!("What would help the straight path, each alone and tried: {}.", listed(changes))
        }
        Hint::Unreached { body, end: which, failed, tries } => format!(
            "The hand of body `{body}` does not reach the {} with the grip turned as asked ({failed} of \
             {tries} start postures fail).",
            end(*which)
        ),
        Hint::NeedsBentLegs => {
            "The low end needs bent legs: ergopath keeps them straight, so it cannot judge this station."
                .to_owned()
        }
    }
}

fn listed(changes: &[Change]) -> String {
    changes.iter().map(change).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{End, Mover};
    use crate::planner::Refusal;

    #[test]
    fn groups_and_hints_read_as_sentences() {
        let first = Refusal::Worker { body: "she".to_owned(), from_s: 1.25 };
        let mut of = RefusedGroup { first, count: 3, all_equal: false };
        assert_eq!(
            group(&of, 98),
            "3 of 98: for example worker: body `she` cannot follow: the reach is exceeded from 1.25 s on \
             in every repetition"
        );
        of.all_equal = true;
        assert!(group(&of, 98).starts_with("3 of 98: worker: body"));
        let changes = vec![Change::MoveApart { what: Mover::Robot, by_m: 0.05 }];
        assert_eq!(
            hint(&Hint::Apart { changes, tried_m: 0.3 }),
            "What would help the straight path, each alone and tried: the robot's base 50 mm farther from \
             the worker."
        );
        let unreached =
            Hint::Unreached { body: "she".to_owned(), end: End::Goal, failed: 7, tries: 8 };
        assert_eq!(
            hint(&unreached),
            "The hand of body `she` does not reach the goal with the grip turned as asked (7 of 8 start \
             postures fail)."
        );
    }
}

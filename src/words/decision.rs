//! The decision as the first screen of the page tells it: in parts, each told once.

use super::cell::{alternative, input};
use super::number::score;
use super::paths::path_and_id;
use super::verdict::{headline, lead, lead_scores, role};
use crate::ergonomics::ScoringMethod;
use crate::planner::{Decision, Finding, InputOrigin, RunResult, ScoreInput};
use crate::scenario::Origin;

/// Change of expected RULA from which an assumed input is worth settling.
const WORTH_SETTLING: f64 = 0.05;

/// Which path; without a decision, why there is none.
pub fn which(result: &RunResult) -> String {
    match (result.verdict.outcome, lead(result)) {
        (Decision::Best | Decision::Assessed, Some(lead)) => {
            format!("{}: {}", role(result), path_and_id(lead))
        }
        _ => headline(result),
    }
}

/// The assumed input that changes expected RULA most, by its index; none where all change little.
pub fn to_settle(result: &RunResult) -> Option<(usize, &InputOrigin)> {
    let assumed = result.inputs.iter().enumerate().filter(|(_, i)| i.origin == Origin::Assumed);
    let by = |i: &InputOrigin| i.if_changed.as_ref().map(|c| c.change[ScoringMethod::Rula].abs());
    let weighed = assumed.filter_map(|(n, i)| Some((n, i, by(i)?)));
    let most = weighed.reduce(|a, b| if b.2 > a.2 { b } else { a })?;
    (most.2 >= WORTH_SETTLING).then_some((most.0, most.1))
}

/// What to settle first, in a sentence or two.
pub fn settle(result: &RunResult) -> String {
    let found = to_settle(result).and_then(|(_, i)| Some((i, i.if_changed.as_ref()?)));
    let Some((origin, changed)) = found else {
        return format!(
            "No input that was assumed changes expected RULA by {WORTH_SETTLING} or more."
        );
    };
    let (name, value) = input(&origin.input);
    let to = alternative(&changed.to);
    let by = changed.change[ScoringMethod::Rula];
    let now = lead_scores(result).map(|b| b.rula().distribution.expected);
    let then = now.map_or_else(String::new, |now| {
        format!(" would be {} instead of {}", score(now + by), score(now))
    });
    format!("{name}: {value} is assumed. With {to}, expected RULA{then}.")
}

/// Whether a finding says what [`settle`] says.
pub fn is_settled(result: &RunResult, finding: &Finding) -> bool {
    let Some((index, i)) = to_settle(result) else { return false };
    match finding {
        Finding::Assumption { input, .. } => *input == index,
        Finding::MuscleUseOpen { .. } => matches!(i.input, ScoreInput::MuscleUse(_)),
        _ => false,
    }
}

/// Whose figures these are, where there is more than one body.
pub fn whose(result: &RunResult) -> Option<String> {
    let body = lead_scores(result)?;
    let count = result.setting.bodies.len();
    (count > 1).then(|| format!("For `{}`, who is worst off of the {count} bodies.", body.body))
}

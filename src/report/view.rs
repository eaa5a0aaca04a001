//! What of a result is shown, and in which words: the leading path, those beside it, names of
//! families, numbers as text.

use crate::ergonomics::PairedDifference;
use crate::path::{Family, Quantity};
use crate::planner::{BodyScores, CandidateResult, Evaluated, RunResult, Status};

/// The paths of a result in the roles in which they are shown.
#[derive(Debug, Clone)]
pub(super) struct View<'a> {
    pub result: &'a RunResult,
    /// The best feasible path; without one, the first path that was scored at all.
    pub lead: Option<&'a CandidateResult>,
    /// The body for which the lead scores worst.
    pub body: Option<&'a str>,
    /// The straight path, unless it leads.
    pub straight: Option<&'a CandidateResult>,
    /// The user's own paths, unless they lead.
    pub own: Vec<&'a CandidateResult>,
    /// What has changed since the run, if anything has.
    pub out_of_date: Option<&'a str>,
    /// All paths of the report, by rank.
    pub reported: Vec<&'a CandidateResult>,
}

impl<'a> View<'a> {
    pub(super) fn of(result: &'a RunResult) -> Self {
        let reported: Vec<_> = result
            .candidates
            .iter()
            .filter(|c| c.evaluated == Evaluated::Reported && !c.bodies.is_empty())
            .collect();
        let best = result.verdict.best.as_deref();
        let lead =
            reported.iter().find(|c| Some(c.id.as_str()) == best).or(reported.first()).copied();
        let is_lead = |c: &CandidateResult| lead.is_some_and(|l| l.id == c.id);
        let beside = |family: Family| {
            reported.iter().filter(move |c| c.family == family && !is_lead(c)).copied()
        };
        Self {
            result,
            lead,
            body: lead.and_then(worst_body).map(|b| b.body.as_str()),
            straight: beside(Family::Straight).next(),
            own: beside(Family::Drawn).collect(),
            out_of_date: None,
            reported: reported.clone(),
        }
    }

    /// The scores of a path for the shown body.
    pub(super) fn scores(&self, candidate: &'a CandidateResult) -> Option<&'a BodyScores> {
        candidate.bodies.iter().find(|b| Some(b.body.as_str()) == self.body)
    }

    /// What the lead is called in legends.
    pub(super) fn lead_name(&self, lead: &CandidateResult) -> String {
        if self.result.verdict.best.is_some() {
            format!("best path ({})", lead.id)
        } else {
            format!("{} (over a limit)", lead.id)
        }
    }

    /// Best minus another path, for the shown body.
    pub(super) fn difference(&self, other: &str) -> Option<&'a PairedDifference> {
        self.result
            .comparisons
            .iter()
            .find(|c| c.other == other && Some(c.body.as_str()) == self.body)
            .map(|c| &c.rula)
    }
}

/// Words with a capital letter at their head.
pub(super) fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}

/// The body with the highest expected RULA.
pub(super) fn worst_body(candidate: &CandidateResult) -> Option<&BodyScores> {
    candidate.bodies.iter().max_by(|a, b| a.rula.expected.total_cmp(&b.rula.expected))
}

/// How a path was made.
pub(super) fn family_words(family: Family) -> &'static str {
    match family {
        Family::Straight => "straight line",
        Family::Lifted => "over the straight line",
        Family::Lowered => "under the straight line",
        Family::TowardBody => "nearer to the body",
        Family::Away => "farther from the body",
        Family::Sampled => "found by the search",
        Family::Drawn => "your own",
        Family::ExpertArc => "an expert's arc",
        Family::Shortest => "shortest feasible",
        Family::BestRandom => "best of random paths",
        Family::SinglePosturePlain => "planned with one posture, plain pseudo-inverse",
        Family::SinglePostureLearned => "planned with one posture, learned",
        Family::Held => "searched with less freedom",
    }
}

/// A path's state in words.
pub(super) fn state_words(status: &Status) -> &'static str {
    match status {
        Status::Feasible => "kept",
        Status::Marked { .. } => "over a limit",
        Status::Infeasible { .. } => "not feasible",
    }
}

/// A quantity's name and unit.
pub(super) fn quantity_words(quantity: Quantity) -> (&'static str, &'static str) {
    match quantity {
        Quantity::Speed => ("speed of the tool", "m/s"),
        Quantity::Acceleration => ("acceleration", "m/s²"),
        Quantity::Jerk => ("jerk, largest component", "m/s³"),
        Quantity::Workspace => ("distance outside the workspace box (negative: inside)", "m"),
        Quantity::AngularSpeed => ("angular speed", "rad/s"),
        Quantity::AngularAcceleration => ("angular acceleration", "rad/s²"),
        Quantity::Rest => ("speed at start and goal (at rest)", "m/s"),
        Quantity::Continuity => ("largest jump between steps", "SI"),
        Quantity::KeepOut => ("depth inside an obstacle's clearance (negative: clear)", "m"),
        Quantity::Corridor => ("distance outside the corridor (negative: inside)", "m"),
        Quantity::Reach => ("distance outside a hand's reach (negative: inside)", "m"),
        Quantity::JointSpeed => ("robot joint speed, share of its limit", ""),
        Quantity::JointAcceleration => ("robot joint acceleration, share of its limit", ""),
        Quantity::JointRange => ("robot joint beyond its range (negative: inside)", "rad"),
        Quantity::Tracking => ("robot beside the path, between knots too", "m"),
        Quantity::Equality => ("projection: residual of the equalities", ""),
        Quantity::Cone => ("projection: distance from the cones", ""),
        Quantity::Stationarity => ("projection: gradient at the optimum", ""),
        Quantity::Complementarity => ("projection: duality gap", ""),
    }
}

/// A share as percent: whole numbers from 10 %, one decimal below; number and sign stay together.
pub(super) fn percent(share: f64) -> String {
    let text = match 100.0 * share {
        p if p.is_nan() => return "unknown".to_owned(),
        0.0 => "0".to_owned(),
        p if p < 0.1 => "<0.1".to_owned(),
        p if p < 9.95 => format!("{p:.1}"),
        // All but a few: never rounded up to certainty.
        p if p > 99.5 && share < 1.0 => ">99".to_owned(),
        p => format!("{p:.0}"),
    };
    text + "\u{a0}%"
}

/// A score or a mean of scores.
pub(super) fn score(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "unknown".to_owned() }
}

/// A change, always with its sign.
pub(super) fn change(value: f64) -> String {
    let text = format!("{:.2}", value.abs());
    match text.as_str() {
        "0.00" => "0.00".to_owned(),
        _ if !value.is_finite() => "unknown".to_owned(),
        _ if value < 0.0 => format!("\u{2212}{text}"),
        _ => format!("+{text}"),
    }
}

/// A physical value: four decimals, or powers of ten where these would show nothing.
pub(super) fn value(value: f64) -> String {
    if !value.is_finite() {
        "unknown".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if value.abs() < 1e-4 {
        format!("{value:.1e}").replace('-', "\u{2212}")
    } else {
        format!("{value:.4}").replace('-', "\u{2212}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let percents = [0.0, 0.0003, 0.071, 0.384, 0.9999, 1.0].map(percent);
        assert_eq!(percents.join(" ").replace('\u{a0}', ""), "0% <0.1% 7.1% 38% >99% 100%");
        assert_eq!(change(-0.396), "\u{2212}0.40");
        assert_eq!(change(-0.001), "0.00");
        assert_eq!(value(-0.113_832), "\u{2212}0.1138");
    }
}

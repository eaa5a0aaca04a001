//! What of a result is shown, and in which words: the leading path, those beside it, names of
//! families, numbers as text.

use crate::ergonomics::PairedDifference;
use crate::path::Family;
use crate::planner::{BodyScores, CandidateResult, Evaluated, RunResult};

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

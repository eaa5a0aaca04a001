//! What of a result is shown, and in which words: the leading path, those beside it, names of
//! families, numbers as text.

use crate::ergonomics::{PairedDifference, ScoringMethod};
use crate::path::Family;
use crate::planner::{BodyScores, CandidateResult, Caveat, Decision, Evaluated, RunResult, Status};
pub(super) use crate::words::paths::family as family_words;

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
    /// Whether repetitions differ as several people do.
    pub(super) fn shows_people(&self) -> bool {
        let caveat = self.result.verdict.caveat;
        matches!(caveat, Some(Caveat::RecordedPeople { .. } | Caveat::Adapted { .. }))
    }

    /// Whether the lead is followed in more than one way of reaching down.
    pub(super) fn has_modes(&self) -> bool {
        let strains = self.lead.iter().flat_map(|l| &l.bodies).filter_map(|b| b.strain.as_ref());
        strains.into_iter().any(|s| !s.modes.is_empty())
    }

    pub(super) fn of(result: &'a RunResult) -> Self {
        let reported: Vec<_> = result
            .candidates
            .iter()
            .filter(|c| c.evaluated == Evaluated::Reported && !c.bodies.is_empty())
            .collect();
        let id = result.verdict.lead.as_deref();
        let lead = reported.iter().find(|c| Some(c.id.as_str()) == id).copied();
        let is_lead = |c: &CandidateResult| lead.is_some_and(|l| l.id == c.id);
        let beside = |family: Family| {
            reported.iter().filter(move |c| c.family == family && !is_lead(c)).copied()
        };
        Self {
            result,
            lead,
            body: result.verdict.body.as_deref(),
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
        match (self.result.verdict.outcome, &lead.status) {
            (Decision::Best, _) => format!("best path ({})", lead.id),
            (_, Status::Marked { .. }) => format!("{} (over a limit)", lead.id),
            _ => lead.id.clone(),
        }
    }

    /// Best minus another path, for the shown body.
    pub(super) fn difference(&self, other: &str) -> Option<&'a PairedDifference> {
        self.result
            .comparisons
            .iter()
            .find(|c| c.other == other && Some(c.body.as_str()) == self.body)
            .map(|c| &c.scores[ScoringMethod::Rula].time_mean)
    }
}

/// The body that is worst in the objective.
pub(super) fn worst_body(candidate: &CandidateResult) -> Option<&BodyScores> {
    candidate.bodies.iter().max_by(|a, b| a.objective.total_cmp(&b.objective))
}

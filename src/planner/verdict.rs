//! The decision as facts: comparisons on the same repetitions, what the gain is made of, and what the
//! reader has to know with it.

use super::along::timing_difference;
use super::causes::nothing_feasible;
use super::checked::{CheckState, Subject, Why};
use super::findings::{Figure, Finding, Severity};
use super::refusal::Status;
use super::result::{
    BodyScores, CandidateResult, Caveat, Comparison, Decision, Difference, Evaluated, Gain,
    GainParts, InputOrigin, ScoreInput, Verdict,
};
use super::space::{ANY_FREEDOM, WITHOUT, held};
use super::timing::lingering;
use crate::ergonomics::{PairedDifference, PerMethod, ScoringMethod};
use crate::path::Family;
use crate::scenario::{Origin, Scenario, TIMING};

/// Share of a path, or of the starts, beyond the training data from which nothing can be decided, and
/// from which it is told.
const UNSUPPORTED: f64 = 0.5;
const DOUBTFUL: f64 = 0.1;
/// Change of an expected score by an assumption from which it is told.
const WORTH_TELLING: f64 = 0.3;
/// Share of repetitions by which a path must have fewer at action level 3 to be told.
const CLEARLY_FEWER: f64 = 0.1;
/// Differences between bodies up to which neither is told to be the worse: of scores, and of shares of time.
const SAME_SCORE: f64 = 0.05;
const SAME_SHARE: f64 = 0.02;

/// Whether a reported path may be called the best.
pub(super) fn is_eligible(c: &CandidateResult) -> bool {
    c.status == Status::Feasible
        && c.evaluated == Evaluated::Reported
        && c.bought.is_empty()
        && c.ends.is_none()
        && !c.other_timing
}

/// The path that the figures are about: the best, or the user's own where these are only assessed;
/// failing that the first that was scored.
pub(super) fn lead(
    candidates: &[CandidateResult],
    is_assessment: bool,
) -> Option<&CandidateResult> {
    let scored = || candidates.iter().filter(|c| !c.bodies.is_empty());
    let chosen = if is_assessment {
        scored().find(|c| c.family == Family::Drawn)
    } else {
        candidates.iter().find(|c| is_eligible(c))
    };
    chosen.or_else(|| scored().next())
}

/// Index of the body that is worst in the objective.
pub(super) fn worst_index(bodies: &[BodyScores]) -> Option<usize> {
    (0..bodies.len()).max_by(|a, b| bodies[*a].objective.total_cmp(&bodies[*b].objective))
}

/// The lead against every other path of the report that joins the same ends, for every body.
pub(super) fn comparisons(
    candidates: &[CandidateResult],
    lead: Option<&CandidateResult>,
) -> Vec<Comparison> {
    let Some(best) = lead.filter(|l| l.ends.is_none()) else { return Vec::new() };
    let others = candidates
        .iter()
        .filter(|c| c.id != best.id && c.evaluated == Evaluated::Reported && c.ends.is_none());
    let mut all = Vec::new();
    for other in others {
        let paths = best.path.as_ref().zip(other.path.as_ref());
        let Some(timing) = paths.and_then(|(a, b)| timing_difference(a, b)) else { continue };
        for (a, b) in best.bodies.iter().zip(&other.bodies) {
            all.push(Comparison {
                lead: best.id.clone(),
                other: other.id.clone(),
                body: a.body.clone(),
                scores: PerMethod::of(|m| Difference::between(&a.scores[m], &b.scores[m])),
                timing,
            });
        }
    }
    all
}

pub(super) fn verdict(
    scenario: &Scenario,
    candidates: &[CandidateResult],
    comparisons: &[Comparison],
    inputs: &[InputOrigin],
    is_assessment: bool,
) -> Verdict {
    let caveat = caveat(scenario);
    let is_feasible = |c: &CandidateResult| c.rank.is_some() && c.status == Status::Feasible;
    let lead = lead(candidates, is_assessment);
    let decision = match lead {
        Some(_) if is_assessment && candidates.iter().any(is_feasible) => Decision::Assessed,
        Some(l) if is_eligible(l) => Decision::Best,
        _ => Decision::NothingFeasible,
    };
    let body = lead.and_then(|l| worst_index(&l.bodies).map(|i| (l, &l.bodies[i])));
    let Some((lead, body)) = body else {
        let mut verdict = nothing_feasible(candidates, caveat);
        // What was in the way may have been assumed to be there.
        let assumed = scenario.robot.assumed_shapes().cloned();
        verdict.findings.extend(assumed.map(Finding::AssumedShapes));
        return verdict;
    };
    let all = Known { scenario, candidates, comparisons, inputs, lead, body };
    let mut verdict = match decision {
        Decision::NothingFeasible => nothing_feasible(candidates, caveat),
        decided => Verdict::of(decided, caveat),
    };
    verdict.lead = Some(lead.id.clone());
    verdict.body = Some(body.body.clone());
    verdict.findings = all.findings();
    if decision != Decision::NothingFeasible {
        let is_unsupported = |f: &Finding| matches!(f, Finding::NotSupported { .. });
        if verdict.findings.iter().any(is_unsupported) {
            verdict.outcome = Decision::NotSupported;
        } else {
            verdict.best = (decision == Decision::Best).then(|| lead.id.clone());
            verdict.gain = gain(candidates, lead, body);
        }
    }
    verdict
}

impl Verdict {
    /// Without anything found yet.
    pub(super) fn of(outcome: Decision, caveat: Option<Caveat>) -> Self {
        Self {
            outcome,
            best: None,
            lead: None,
            body: None,
            gain: None,
            findings: Vec::new(),
            changes: Vec::new(),
            refused: Vec::new(),
            hints: Vec::new(),
            caveat,
        }
    }
}

/// What the lead gains over the straight path, and which part of it is its route's and its timing's.
fn gain(candidates: &[CandidateResult], lead: &CandidateResult, body: &BodyScores) -> Option<Gain> {
    let usable = |c: &&CandidateResult| c.rank.is_some();
    let of_body = |c: &CandidateResult| c.bodies.iter().find(|b| b.body == body.body).cloned();
    let by_family =
        |f: Family| candidates.iter().filter(usable).find(|c| c.family == f).and_then(of_body);
    let straight = by_family(Family::Straight)?;
    let retimed = by_family(Family::StraightRetimed);
    let without = format!("{WITHOUT}{TIMING}");
    let unpaced = candidates.iter().filter(usable).find(|c| c.id == without).and_then(of_body);
    let is_timed = retimed.is_some() || unpaced.is_some();
    let scores = PerMethod::of(|m| {
        let over =
            |other: &BodyScores| straight.scores[m].less(&other.scores[m], |s| &s.by_rollout);
        let together = over(body);
        GainParts {
            together,
            route: if is_timed { unpaced.as_ref().map(&over) } else { Some(together) },
            timing: retimed.as_ref().map(&over),
        }
    });
    (lead.family != Family::Straight && lead.ends.is_none() && !lead.other_timing)
        .then(|| Gain { body: body.body.clone(), scores })
}

/// All that findings are made of.
struct Known<'a> {
    scenario: &'a Scenario,
    candidates: &'a [CandidateResult],
    comparisons: &'a [Comparison],
    inputs: &'a [InputOrigin],
    /// The path that the figures are about.
    lead: &'a CandidateResult,
    /// The body that they are about.
    body: &'a BodyScores,
}

impl Known<'_> {
    /// Everything, what weighs most first.
    fn findings(&self) -> Vec<Finding> {
        let mut all = self.support();
        all.extend(self.scenario.low_hand().map(Finding::LowHand));
        all.extend(self.not_checked());
        all.extend(self.users());
        all.extend(self.reach());
        all.extend(self.standing());
        all.extend(self.other_bodies());
        all.extend(self.timing());
        all.extend(self.assumptions());
        all.extend(self.fewer_reach_level_3());
        all.extend(self.bought());
        all.extend(self.lead.path.as_ref().and_then(lingering));
        all.extend(self.worth());
        all.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        all
    }

    /// How far the recordings support the figures, of each body.
    fn support(&self) -> Vec<Finding> {
        let of = |b: &BodyScores| {
            let body = b.body.clone();
            let (beyond, unusual_starts) = (b.extrapolation_share, b.unusual_starts);
            if beyond > UNSUPPORTED || unusual_starts > UNSUPPORTED {
                return vec![Finding::NotSupported { body, beyond, unusual_starts }];
            }
            let mut found = Vec::new();
            if beyond > DOUBTFUL {
                found.push(Finding::BeyondData { body: body.clone(), share: beyond });
            }
            if unusual_starts > DOUBTFUL {
                found.push(Finding::UnusualStarts { body, share: unusual_starts });
            }
            found
        };
        self.lead.bodies.iter().flat_map(of).collect()
    }

    /// What could not be looked at along the lead. Of what too few rows do not tell the acceleration stands
    /// for all.
    fn not_checked(&self) -> Vec<Finding> {
        let mut found: Vec<Finding> = Vec::new();
        for check in &self.lead.checklist {
            let CheckState::NotChecked { why } = check.state else { continue };
            let is_told = match why {
                Why::Robot(_) => true,
                Why::TooFewRows => check.subject == Subject::Acceleration,
                // Told as out of reach.
                Why::Refused | Why::NobodyFollows => false,
            };
            let finding = Finding::NotChecked { subject: check.subject, why };
            if is_told && !found.contains(&finding) {
                found.push(finding);
            }
        }
        if self.lead.path.as_ref().is_some_and(|p| !p.robot_q.is_empty()) {
            let assumed = self.scenario.robot.assumed_shapes().cloned();
            found.extend(assumed.map(Finding::AssumedShapes));
        }
        found
    }

    /// What is to be said of the user's own paths.
    fn users(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        for c in self.candidates {
            let path = c.id.clone();
            if let Some(off) = c.ends {
                found.push(Finding::OtherEnds { path: path.clone(), off });
            }
            if matches!(c.status, Status::Marked { .. }) {
                found.push(Finding::BreaksLimits { path });
            }
        }
        found
    }

    fn reach(&self) -> Vec<Finding> {
        let of = |b: &BodyScores| Finding::OutOfReach {
            body: b.body.clone(),
            share: b.reach_exceeded,
            from_s: b.reach_exceeded_from_s.unwrap_or(0.0),
        };
        self.lead.bodies.iter().filter(|b| b.reach_exceeded > 0.0).map(of).collect()
    }

    /// Where people would step, and where their bodies are in the furniture.
    fn standing(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        for b in &self.lead.bodies {
            let (body, strain) = (b.body.clone(), b.strain.as_ref());
            if let Some(share) = strain.and_then(|s| s.stretched_share).filter(|s| *s > SELDOM) {
                found.push(Finding::StepNeeded { body: body.clone(), share });
            }
            let furniture = strain.and_then(|s| s.furniture.as_ref());
            if let Some(f) = furniture.filter(|f| f.share_inside > SELDOM) {
                found.push(Finding::InFurniture {
                    body,
                    share: f.share_inside,
                    part: f.body_part.clone(),
                    obstacle: f.obstacle.clone(),
                    depth_m: -f.distance_m.p05,
                });
            }
        }
        found
    }

    /// Figures in which another body than that of the verdict is the worst.
    fn other_bodies(&self) -> Vec<Finding> {
        let mut found = Vec::new();
        for method in ScoringMethod::ALL {
            for figure in Figure::ALL {
                let of = |b: &BodyScores| figure.of(&b.scores[method]);
                let own = of(self.body);
                let same = if figure == Figure::High { SAME_SHARE } else { SAME_SCORE };
                let worst = self.lead.bodies.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
                if let Some(b) = worst
                    && of(b) > own + same
                {
                    let (body, value) = (b.body.clone(), of(b));
                    let verdict_value = own;
                    found.push(Finding::OtherBodyWorse {
                        body,
                        method,
                        figure,
                        value,
                        verdict_value,
                    });
                }
            }
        }
        found
    }

    /// The straight path and the user's own, where they keep another timing.
    fn timing(&self) -> Vec<Finding> {
        let is_told = |c: &&Comparison| {
            let family = self.candidates.iter().find(|x| x.id == c.other).map(|x| x.family);
            let is_own = [Some(Family::Straight), Some(Family::Drawn)].contains(&family);
            c.body == self.body.body
                && !c.timing.is_same()
                && (is_own || self.lead.family == Family::Drawn)
        };
        let of = |c: &Comparison| Finding::TimingDiffers {
            path: c.other.clone(),
            same_route: c.timing.is_same_route(),
            per_metre: c.scores[ScoringMethod::Rula].per_metre,
        };
        self.comparisons.iter().filter(is_told).map(of).collect()
    }

    fn assumptions(&self) -> Vec<Finding> {
        let rula = self.body.rula().distribution.expected;
        let mut found = Vec::new();
        for (input, i) in self.inputs.iter().enumerate().filter(|i| i.1.origin == Origin::Assumed) {
            let Some(changed) = &i.if_changed else { continue };
            let body = self.body.body.clone();
            if matches!(i.input, ScoreInput::MuscleUse(_)) {
                let scores = PerMethod::of(|m| {
                    self.body.scores[m].distribution.expected + changed.change[m]
                });
                found.push(Finding::MuscleUseOpen { body, scores });
            } else if changed.change[ScoringMethod::Rula].abs() >= WORTH_TELLING {
                let score = rula + changed.change[ScoringMethod::Rula];
                found.push(Finding::Assumption { input, body, score });
            }
        }
        found
    }

    /// A path with clearly fewer repetitions at action level 3 than the best, if there is one.
    fn fewer_reach_level_3(&self) -> Option<Finding> {
        let of_body = |c: &CandidateResult| {
            let scores = c.bodies.iter().find(|b| b.body == self.body.body)?.rula();
            scores.distribution.p_at_least.get(usize::from(ScoringMethod::Rula.high())).copied()
        };
        let here = of_body(self.lead)?;
        let others = self
            .candidates
            .iter()
            .filter(|c| c.status == Status::Feasible && c.id != self.lead.id && c.ends.is_none());
        let shares = others.filter_map(|c| Some((c, of_body(c)?)));
        let (fewest, there) = shares.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let path = fewest.id.clone();
        (here - there >= CLEARLY_FEWER).then_some(Finding::FewerReachLevel3 { path, there, here })
    }

    /// Paths with a lower objective than the best that are not the best for what they cost.
    fn bought(&self) -> Vec<Finding> {
        let before = self.candidates.iter().take_while(|c| c.id != self.lead.id);
        let bought = before.filter(|c| !c.bought.is_empty() || c.other_timing);
        bought.map(|c| Finding::LowerMeanNotBest { path: c.id.clone() }).collect()
    }

    /// What each freedom is worth: the best path against the best that was found without it.
    fn worth(&self) -> Vec<Finding> {
        let of = |name: &str| {
            let id = format!("{WITHOUT}{name}");
            let body = self.body.body.clone();
            let freedom = (name != ANY_FREEDOM).then(|| name.to_owned());
            if id == self.lead.id {
                return Some(Finding::Worth { freedom, body, gain: None });
            }
            let found = self.comparisons.iter().find(|c| c.other == id && c.body == body)?;
            let gain = Some(turned(&found.scores[ScoringMethod::Rula].time_mean));
            Some(Finding::Worth { freedom, body, gain })
        };
        held(&self.scenario.free).into_iter().filter_map(of).collect()
    }
}

/// Share of repetitions up to which a rare one is not told.
const SELDOM: f64 = 0.05;

/// `b - a` from `a - b`.
fn turned(d: &PairedDifference) -> PairedDifference {
    PairedDifference { mean: -d.mean, low95: -d.high95, high95: -d.low95, ..*d }
}

fn caveat(scenario: &Scenario) -> Option<Caveat> {
    let model = &scenario.worker.model;
    let other_body = scenario.worker.bodies.iter().any(|b| b.size != model.size);
    let count = model.provenance.people;
    if model.provenance.simulated {
        Some(Caveat::DemonstrationModel)
    } else if let Some(seconds) = model.provenance.adapted_s {
        Some(Caveat::Adapted { count, seconds })
    } else if count > 1 {
        Some(Caveat::RecordedPeople { count })
    } else if let Some((_, count)) = model.provenance.filled_from {
        Some(Caveat::FilledLegs { count })
    } else {
        other_body.then_some(Caveat::OtherBody)
    }
}

impl Finding {
    /// Whether it makes the figures doubtful.
    pub fn is_doubt(&self) -> bool {
        self.severity() == Severity::Doubt
    }
}

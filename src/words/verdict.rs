//! The decision in words.

use super::finding::finding;
use super::number::{change, percent, score};
use super::paths::path_and_id;
use crate::ergonomics::{PairedDifference, ScoringMethod};
use crate::path::Family;
use crate::planner::{
    BodyScores, CandidateResult, Caveat, Comparison, Decision, Finding, GainParts, Objective,
    RunResult, Severity,
};
use std::borrow::Cow;

/// The path that the figures are about.
pub fn lead(result: &RunResult) -> Option<&CandidateResult> {
    let id = result.verdict.lead.as_ref()?;
    result.candidates.iter().find(|c| c.id == *id)
}

/// The scores that they are about: of the lead for the body of the verdict.
pub fn lead_scores(result: &RunResult) -> Option<&BodyScores> {
    let body = result.verdict.body.as_ref()?;
    lead(result)?.bodies.iter().find(|b| b.body == *body)
}

/// One sentence.
pub fn headline(result: &RunResult) -> String {
    let nothing = || "No path keeps all limits".to_owned();
    let (Some(lead), Some(body)) = (lead(result), lead_scores(result)) else { return nothing() };
    match result.verdict.outcome {
        Decision::NothingFeasible => nothing(),
        Decision::NotSupported => {
            let unsupported = result.verdict.findings.iter().find_map(|f| match f {
                Finding::NotSupported { body, beyond, unusual_starts } => {
                    Some((body, *beyond, *unusual_starts))
                }
                _ => None,
            });
            let (body, beyond, starts) = unsupported.unwrap_or((&body.body, 1.0, 1.0));
            let why = if beyond >= starts {
                format!("{} of the path lies beyond what was recorded", percent(beyond))
            } else {
                format!(
                    "{} of the start postures are hardly ever seen in the recordings",
                    percent(starts)
                )
            };
            format!(
                "Not supported by the recordings: for {body}, {why}. No path is called the best"
            )
        }
        Decision::Best | Decision::Assessed => {
            let method = ScoringMethod::Rula;
            let [share, low, high] = body.scores[method].high_band;
            format!(
                "{}: {}. {} at action level 3 or above for {} of the time (90 % of repetitions: {} to {}){}",
                role(result),
                path_and_id(lead),
                method.name(),
                percent(share),
                percent(low),
                percent(high),
                for_body(result, &body.body),
            )
        }
    }
}

/// What the lead is called. The lowest of all is not called the best where chance alone may have made it lower
/// than the straight path.
pub fn role(result: &RunResult) -> &'static str {
    match result.verdict.outcome {
        Decision::Best if result.has_clear_best() => "Best path",
        Decision::Best => "No path is clearly better than the straight one. Lowest",
        Decision::Assessed | Decision::NotSupported | Decision::NothingFeasible => "Assessed",
    }
}

/// ", for BODY" where there are several.
fn for_body(result: &RunResult, body: &str) -> String {
    if result.setting.bodies.len() > 1 { format!(", for {body}") } else { String::new() }
}

/// The expected scores of the lead with their bands, a sentence for each method.
pub fn expected(result: &RunResult) -> Vec<String> {
    let Some(body) = lead_scores(result) else { return Vec::new() };
    let of = |method: ScoringMethod| {
        let s = &body.scores[method];
        let d = &s.distribution;
        let level = method.level(d.expected.round() as u8);
        format!(
            "Expected {} {} (90 % band {} to {}), near action level {level}: {}. Per metre of hand travel {}, peak {}.",
            method.name(),
            score(d.expected),
            score(d.p05),
            score(d.p95),
            method.level_words(level),
            score(s.per_metre),
            score(s.peak),
        )
    };
    ScoringMethod::ALL.into_iter().map(of).collect()
}

/// What the best path gains over the straight one, and what the gain is made of.
pub fn gain(result: &RunResult) -> Option<String> {
    let gain = result.verdict.gain.as_ref()?;
    let method = ScoringMethod::Rula;
    let GainParts { together, route, timing } = gain.scores[method];
    let all =
        format!("Against the straight path, expected {} is {}", method.name(), lower(&together));
    let body = for_body(result, &gain.body);
    let parts = match (route, timing) {
        (Some(_), None) if !same_timing(result) => String::new(),
        (Some(_), None) if !together.clear => "; both keep the same timing".to_owned(),
        (Some(_), None) => {
            "; all of the difference comes from the route, as both keep the same timing".to_owned()
        }
        (route, Some(timing)) => {
            let route = route.map_or_else(|| "not known".to_owned(), |r| lower(&r));
            format!(". The route alone: {route}. The timing alone: {}", lower(&timing))
        }
        (None, None) => String::new(),
    };
    Some(format!("{all}{body}{parts}."))
}

/// Whether the lead and the straight path keep the same timing.
fn same_timing(result: &RunResult) -> bool {
    let of_straight = |c: &&Comparison| {
        let path = result.candidates.iter().find(|p| p.id == c.other);
        path.is_some_and(|p| p.family == Family::Straight)
    };
    result.comparisons.iter().find(of_straight).is_some_and(|c| c.timing.is_same())
}

/// A gain (positive: lower score) with its interval.
pub fn lower(d: &PairedDifference) -> String {
    let [low, high] = [d.low95, d.high95];
    if [d.mean, low, high].iter().all(|v| v.abs() < 0.005) {
        return "the same".to_owned();
    }
    if !d.clear {
        let [mean, low, high] = [-d.mean, -high, -low].map(change);
        return format!("not clearly different ({mean}, 95 % interval {low} to {high})");
    }
    if d.mean > 0.0 {
        format!("{:.2} lower (95 % interval {low:.2} to {high:.2})", d.mean)
    } else {
        format!("{:.2} higher (95 % interval {:.2} to {:.2})", -d.mean, -high, -low)
    }
}

/// What was chosen with the lead besides its route.
pub fn chosen(result: &RunResult) -> Option<String> {
    let all: Vec<String> = lead(result)?.chosen.iter().map(super::paths::chosen).collect();
    (!all.is_empty()).then(|| format!("Chosen with it: {}.", all.join("; ")))
}

/// All weights of a planner's objective that are not zero.
pub fn objective(o: &Objective) -> String {
    let mut terms = Vec::new();
    for method in ScoringMethod::ALL {
        let (w, name) = (o.weights(method), method.name());
        terms.extend([
            (w.expected, format!("expected {name}")),
            (w.cvar90, format!("{name}, mean of the worst tenth of repetitions")),
            (w.exposure, format!("share of time at {name} action level 3 or above")),
            (w.p_high, format!("share of repetitions at {name} action level 3 or above for 0.5 s")),
        ]);
    }
    terms.extend([
        (o.effort, "rms joint speed of the person (rad/s)".to_owned()),
        (o.duration, "duration over the scenario's".to_owned()),
        (
            o.clearance,
            format!("missing share of {} m clearance from obstacles", o.clearance_wanted_m),
        ),
    ]);
    let shown =
        terms.into_iter().filter(|(w, _)| *w != 0.0).map(|(w, name)| format!("{w} x {name}"));
    shown.collect::<Vec<_>>().join(" + ")
}

/// What the posture model is not.
pub fn caveat(c: Caveat) -> Cow<'static, str> {
    match c {
        Caveat::DemonstrationModel => "demonstration model, not your workers".into(),
        Caveat::RecordedPeople { count } => {
            format!("{count} recorded people, not your workers").into()
        }
        Caveat::Adapted { count, seconds } => format!(
            "{count} recorded people and {seconds:.1} s of one worker, not your other workers"
        )
        .into(),
        Caveat::FilledLegs { count } => format!(
            "hips and knees were not recorded but filled in from {count} recorded people, not your workers"
        )
        .into(),
        Caveat::OtherBody => "learned from one person of another size, not your workers".into(),
    }
}

/// All findings of a severity.
pub fn findings(result: &RunResult, severity: Severity) -> Vec<String> {
    let of = result.verdict.findings.iter().filter(|f| f.severity() == severity);
    of.map(|f| finding(f, result)).collect()
}

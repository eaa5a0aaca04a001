//! Findings in words, a sentence or two each.

use super::cell::{alternative, input};
use super::checklist;
use super::number::{capital, percent, score};
use super::paths::{bought, named};
use super::refusal;
use super::robot;
use super::verdict::lower;
use crate::ergonomics::{PairedDifference, PerMethod, ScoringMethod};
use crate::planner::{Figure, Finding, RunResult, Status, Subject, Why};
use crate::scenario::LowHand;

/// A finding of a result.
pub fn finding(f: &Finding, result: &RunResult) -> String {
    match f {
        Finding::NotSupported { body, beyond, unusual_starts } => format!(
            "The recordings do not support these figures for {body}: {} of the path lies beyond them, and {} of \
             the start postures are rarer than one in a hundred.",
            percent(*beyond),
            percent(*unusual_starts)
        ),
        Finding::BeyondData { body, share } => format!(
            "{} of the path lies beyond the posture model's recordings for {body}; there it extrapolates.",
            percent(*share)
        ),
        Finding::LowHand(low) => low_hand(low),
        Finding::UnusualStarts { body, share } => format!(
            "{} of the start postures are unusual for {body} (rarer than one in a hundred): is the worker in the \
             right place?",
            percent(*share)
        ),
        Finding::NotChecked { subject, why } => not_checked(*subject, *why),
        Finding::AssumedShapes(shapes) => {
            format!("The robot's real shape is not checked: {}.", robot::assumed_shapes(shapes))
        }
        Finding::OutOfReach { body, share, from_s } => format!(
            "For {body}, the hand cannot follow in {} of the repetitions (first at {from_s:.2} s); from then on \
             they count as the worst score.",
            percent(*share)
        ),
        Finding::StepNeeded { body, share } => format!(
            "In {} of the repetitions {body} reaches only just, at the edge of balance or beyond, or stands where people \
             would not stand for this: people step there. Here the feet stay where they are.",
            percent(*share)
        ),
        Finding::InFurniture { body, share, part, obstacle, depth_m } => format!(
            "In {} of the repetitions a part of {body} is inside an obstacle, the {part} in `{obstacle}` by \
             {:.0} cm: the posture model does not know furniture, so this posture is not possible there.",
            percent(*share),
            100.0 * depth_m
        ),
        Finding::OtherBodyWorse { body, method, figure, value, verdict_value } => {
            other_body(body, *method, *figure, [*value, *verdict_value])
        }
        Finding::Lingers { from_s, to_s, at_m: [x, y, z], below_m_s, up_to_m_s } => format!(
            "Slow parts are part of this plan: below {below_m_s:.2} m/s from {from_s:.1} to {to_s:.1} s near \
             ({x:.2}, {y:.2}, {z:.2}) m, and up to {up_to_m_s:.2} m/s elsewhere."
        ),
        Finding::Worth { freedom, gain, .. } => worth(freedom.as_deref(), gain.as_ref()),
        Finding::MuscleUseOpen { scores, .. } => muscle_use(scores),
        Finding::Assumption { input: index, score: then, .. } => assumption(result, *index, *then),
        Finding::FewerReachLevel3 { path, there, here } => format!(
            "On {}, fewer repetitions spend half a second at RULA action level 3 or above: {} instead of \
             {}. The ranking follows the planner's objective.",
            named(result, path),
            percent(*there),
            percent(*here)
        ),
        Finding::BreaksLimits { path } => breaks_limits(result, path),
        Finding::LowerMeanNotBest { path } => lower_mean(result, path),
        Finding::TimingDiffers { path, same_route, per_metre } => {
            timing_differs(result, path, *same_route, per_metre)
        }
        Finding::OtherEnds { path, off } => format!(
            "`{path}` does not join the scenario's start and goal: it begins {:.0} mm and {:.1} deg from the start \
             and ends {:.0} mm and {:.1} deg from the goal. It is scored, and compared with nothing.",
            1e3 * off.start_m,
            off.start_deg,
            1e3 * off.goal_m,
            off.goal_deg
        ),
    }
}

fn not_checked(subject: Subject, why: Why) -> String {
    format!("Not checked: {} ({}).", checklist::subject(subject), checklist::why(why))
}

fn other_body(body: &str, method: ScoringMethod, figure: Figure, values: [f64; 2]) -> String {
    let (name, [there, here]) = match figure {
        Figure::Expected => (format!("expected {}", method.name()), values.map(score)),
        Figure::High => {
            (format!("time at {} action level 3 or above", method.name()), values.map(percent))
        }
        Figure::Peak => (format!("peak {}", method.name()), values.map(score)),
    };
    format!("{body} is worse in one figure: {name} {there} instead of {here}.")
}

/// That an end is too low for straight legs.
pub(super) fn low_hand(low: &LowHand) -> String {
    format!(
        "The {} is {:.2} m above the floor. People bend their legs for that; here they stay straight, so the back \
         and its scores are worse than a worker's who squats.",
        super::end(low.end),
        low.height_m
    )
}

fn worth(freedom: Option<&str>, gain: Option<&PairedDifference>) -> String {
    let what = match freedom {
        None => "All freedoms together".to_owned(),
        Some(name) => format!("Freedom of the {name}"),
    };
    match gain {
        None => format!("{what}: this search found no use for it."),
        Some(d) => format!("{what}: expected RULA {}.", lower(d)),
    }
}

fn muscle_use(scores: &PerMethod<f64>) -> String {
    let all: Vec<String> =
        scores.iter().map(|(m, s)| format!("{} {}", m.name(), score(*s))).collect();
    format!(
        "cycles_per_min and hold_s are not both given. If the task repeats more than 4 times a minute or a posture \
         is held for over a minute: {}.",
        all.join(", ")
    )
}

fn assumption(result: &RunResult, index: usize, then: f64) -> String {
    let Some(i) = result.inputs.get(index) else { return String::new() };
    let (name, value) = input(&i.input);
    let to = i.if_changed.as_ref().map(|c| alternative(&c.to)).unwrap_or_default();
    format!(
        "Assumed, not predicted: {name} ({value}). With {to} instead, expected RULA would be {}.",
        score(then)
    )
}

fn breaks_limits(result: &RunResult, path: &str) -> String {
    let found = result.candidates.iter().find(|c| c.id == path);
    let violations = match found.map(|c| &c.status) {
        Some(Status::Marked { violations }) => refusal::all(violations),
        _ => String::new(),
    };
    format!("`{path}` exceeds limits: {violations}.")
}

fn lower_mean(result: &RunResult, path: &str) -> String {
    let found = result.candidates.iter().find(|c| c.id == path);
    let mut why: Vec<String> =
        found.map(|c| c.bought.iter().map(bought).collect()).unwrap_or_default();
    if found.is_some_and(|c| c.other_timing) {
        why.push(
            "its timing is not that of the straight path, and the timing is not free".to_owned(),
        );
    }
    format!(
        "{} has a lower objective but is not called the best: {}.",
        capital(&named(result, path)),
        why.join("; ")
    )
}

fn timing_differs(
    result: &RunResult,
    path: &str,
    same_route: bool,
    per_metre: &PairedDifference,
) -> String {
    let other = named(result, path);
    if same_route {
        return format!(
            "Same route as {other}; timing differs. Means over time differ for that reason alone and say nothing \
             about the route."
        );
    }
    let towards = PairedDifference {
        mean: -per_metre.mean,
        low95: -per_metre.high95,
        high95: -per_metre.low95,
        ..*per_metre
    };
    format!(
        "Timing differs from that of {other}, so means over time do not compare the routes. Per metre of hand \
         travel, RULA is {}.",
        lower(&towards)
    )
}

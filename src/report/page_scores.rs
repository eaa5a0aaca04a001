//! Sections of the page that hold scores as tables: paths compared, body parts, body sizes.

use super::page::ticked;
use super::view::{View, family_words, worst_body};
use crate::ergonomics::P_AT_LEAST_S;
use crate::planner::{BodyScores, CandidateResult, Status};
use crate::words::number::{change, percent, score};
use crate::words::refusal;
use maud::{Markup, html};

/// The table of paths.
pub(super) fn variants(view: &View) -> Markup {
    if view.reported.is_empty() {
        return html! { p { "No path was scored." } };
    }
    let several = view.reported.iter().any(|c| c.bodies.len() > 1);
    let searched = view
        .result
        .candidates
        .iter()
        .filter(|c| c.evaluated == crate::planner::Evaluated::Search)
        .count();
    html! {
        div.scroll tabindex="0" role="region" aria-label="Paths compared" {
            table {
                caption {
                    "Paths of the report, best first"
                    @if several { "; figures of the body size that scores worst" }
                    ". Scores are means of ordinal scores, over people and time: they rank, they do not measure."
                }
                thead { tr {
                    th.n scope="col" { "Rank" }
                    th scope="col" { "Path" }
                    th.n scope="col" { "Time at action level 3+" span.small { "90 % band" } }
                    th.n scope="col" { "Expected RULA" span.small { "90 % band; standard error" } }
                    th.n scope="col" { "Expected REBA" span.small { "90 % band" } }
                    th.n scope="col" { "RULA, mean of the worst tenth" }
                    th.n scope="col" { "RULA 5+ for at least " (P_AT_LEAST_S) " s" span.small { "share of repetitions" } }
                    th.n scope="col" { "RULA, difference to the best" span.small { "95 % interval" } }
                    th.n scope="col" { "Out of reach" }
                    th scope="col" { "Limits" }
                } }
                tbody { @for c in &view.reported { @if let Some(b) = worst_body(c) { (variant(view, c, b)) } } }
            }
        }
        p.note {
            "Mean of the worst tenth (CVaR90): the mean over the one repetition in ten that scores highest. \
             95 % interval: where the true mean difference lies, as far as the number of repetitions tells; both paths \
             are walked by the same simulated people. Out of reach: share of repetitions in which the hand cannot follow; these count as \
             the worst score from there on."
            " Ranked on other simulated people than those of these figures, so that neighbours may stand the other way \
             round. "
            @if searched > 0 {
                (searched) " more paths were scored on few people in the search and not shortlisted; they \
                 stand in " code { "candidates.csv" } "."
            }
        }
    }
}

fn variant(view: &View, c: &CandidateResult, b: &BodyScores) -> Markup {
    let [exposure, low, high] = b.exposure_rula_5_band;
    let leads = view.lead.is_some_and(|l| l.id == c.id);
    let is_best = view.result.verdict.best.as_deref() == Some(c.id.as_str());
    html! {
        tr.best[is_best] {
            td.n { (c.rank.map_or_else(String::new, |r| r.to_string())) }
            th scope="row" {
                (c.id)
                span.small { (family_words(c.family)) }
                @if let Some(end) = c.path.as_ref().and_then(|p| p.time_s.last()) { span.small { (format!("{end:.2} s")) } }
            }
            td.n { (percent(exposure)) span.small { (percent(low)) " to " (percent(high)) } }
            td.n {
                (score(b.rula.expected))
                span.small { (score(b.rula.p05)) " to " (score(b.rula.p95)) }
                span.small { "s.e. " (error(b.rula.standard_error)) }
            }
            td.n { (score(b.reba.expected)) span.small { (score(b.reba.p05)) " to " (score(b.reba.p95)) } }
            td.n { (score(b.rula.cvar90)) }
            td.n { (percent(b.rula.p_at_least.get(5).copied().unwrap_or(0.0))) }
            td.n { @if leads { "–" } @else { (difference(view, c)) } }
            td.n { (percent(b.reach_exceeded)) }
            td {
                (refusal::state(&c.status))
                @if let Status::Marked { violations } = &c.status {
                    @for v in violations { span.small { (ticked(&refusal::refusal(v))) } }
                }
            }
        }
    }
}

/// A standard error, to three decimals.
pub(super) fn error(value: Option<f64>) -> String {
    value.map_or_else(|| "unknown".to_owned(), |v| format!("{v:.3}"))
}

/// The other path minus the best.
fn difference(view: &View, c: &CandidateResult) -> Markup {
    let Some(d) = view.difference(&c.id) else { return html! { "unknown" } };
    html! {
        @if d.clear { (change(-d.mean)) } @else { "no clear difference" }
        span.small { (change(-d.high95)) " to " (change(-d.low95)) }
    }
}

/// Step scores of the lead and the straight path.
pub(super) fn parts(view: &View) -> Markup {
    let Some(lead) = view.lead.and_then(|l| view.scores(l)) else { return html! {} };
    let straight = view.straight.and_then(|s| view.scores(s));
    html! {
        h3 { "The same as numbers" }
        div.scroll tabindex="0" role="region" aria-label="Body parts" {
            table {
                thead { tr {
                    th scope="col" { "Step of RULA" }
                    th.n scope="col" { "Mean score" }
                    th.n scope="col" { "Drives the total by" }
                    @if straight.is_some() {
                        th.n scope="col" { "Straight path: mean score" }
                        th.n scope="col" { "Straight path: drives by" }
                    }
                } }
                tbody {
                    @for (i, part) in lead.parts.iter().enumerate() {
                        tr {
                            th scope="row" { (part.part) }
                            td.n { (score(part.mean)) }
                            td.n { (score(part.drives)) }
                            @if let Some(s) = straight {
                                @if let Some(p) = s.parts.get(i) {
                                    td.n { (score(p.mean)) }
                                    td.n { (score(p.drives)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The lead for each body size.
pub(super) fn bodies(view: &View) -> Markup {
    let setting = &view.result.setting;
    let Some(lead) = view.lead else {
        return html! { (super::page::list(&setting.bodies)) };
    };
    if lead.bodies.len() < 2 {
        return html! {
            p { "One body size was used: " (setting.bodies.join("; ")) ". Others may score differently." }
        };
    }
    html! {
        div.scroll tabindex="0" role="region" aria-label="Body sizes" {
            table {
                caption { "Path " (lead.id) " for each body size." }
                thead { tr {
                    th scope="col" { "Body" }
                    th.n scope="col" { "Time at action level 3+" span.small { "90 % band" } }
                    th.n scope="col" { "Expected RULA" span.small { "90 % band" } }
                    th.n scope="col" { "Expected REBA" span.small { "90 % band" } }
                    th.n scope="col" { "Out of reach" }
                } }
                tbody {
                    @for b in &lead.bodies {
                        tr {
                            th scope="row" {
                                (b.body)
                                @if Some(b.body.as_str()) == view.body { span.small { "scores worst" } }
                                @if let Some(words) = words(setting.bodies.as_slice(), &b.body) { span.small { (words) } }
                            }
                            td.n {
                                (percent(b.exposure_rula_5_band[0]))
                                span.small { (percent(b.exposure_rula_5_band[1])) " to " (percent(b.exposure_rula_5_band[2])) }
                            }
                            td.n { (score(b.rula.expected)) span.small { (score(b.rula.p05)) " to " (score(b.rula.p95)) } }
                            td.n { (score(b.reba.expected)) span.small { (score(b.reba.p05)) " to " (score(b.reba.p95)) } }
                            td.n { (percent(b.reach_exceeded)) }
                        }
                    }
                }
            }
        }
    }
}

/// What the setting says of a body after its name.
fn words<'a>(bodies: &'a [String], name: &str) -> Option<&'a str> {
    bodies.iter().find_map(|b| b.strip_prefix(name)?.strip_prefix(": "))
}

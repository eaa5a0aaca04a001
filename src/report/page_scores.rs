//! Sections of the page that hold scores as tables: paths compared, body parts, body sizes.

use super::page::ticked;
use super::view::View;
use crate::ergonomics::{P_AT_LEAST_S, ScoringMethod};
use crate::planner::{BodyScores, CandidateResult, HandMotion, Status};
use crate::words;
use crate::words::number::{change, percent, score};
use maud::{Markup, html};

/// The table of paths.
pub(super) fn variants(view: &View) -> Markup {
    if view.reported.is_empty() {
        return html! { p { "No path was scored." } };
    }
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
                    @if let Some(body) = view.body { "; figures for " (body) }
                    ". Scores are means of ordinal scores, over repetitions and time: they rank, they do not measure."
                }
                thead { tr {
                    th.n scope="col" { "Rank" span.small { "objective" } }
                    th scope="col" { "Path" }
                    th.n scope="col" { "Time at RULA action level 3+" span.small { "90 % band" } }
                    @for m in ScoringMethod::ALL {
                        th.n scope="col" { "Expected " (m.name()) span.small { "90 % band; standard error; per metre; peak" } }
                    }
                    th.n scope="col" { "RULA, worst tenth" span.small { "5+ for " (P_AT_LEAST_S) " s" } }
                    th.n scope="col" { "RULA, difference to the best" span.small { "95 % interval" } }
                    th.n scope="col" { "Hand speed (m/s)" span.small { "acceleration (m/s²)" } }
                    th.n scope="col" { "Out of reach" }
                    th scope="col" { "Limits" }
                } }
                tbody { @for c in &view.reported { @if let Some(b) = view.scores(c) { (variant(view, c, b)) } } }
            }
        }
        p.note {
            "Ranked by the planner's objective on other repetitions than those of the figures, so that the winner's figures \
             are not flattered by having been chosen; adjacent ranks may therefore swap. Per metre: mean over hand travel \
             instead of time, which does not depend on the timing. Peak: exceeded for 5 % of the time, median over repetitions. \
             Worst tenth (CVaR90): the mean over the one repetition in ten that scores highest; below it the share of \
             repetitions at RULA 5 or more for half a second in total. 95 % interval: \
             where the true mean difference lies, as far as the number of repetitions tells; all paths meet the same \
             repetitions. Out of reach: share of repetitions in which the hand cannot follow; from then on these count as the \
             worst score. "
            @if searched > 0 {
                (searched) " more paths were scored in the search, on few repetitions, and not shortlisted; they are in "
                code { "candidates.csv" } "."
            }
        }
    }
}

fn variant(view: &View, c: &CandidateResult, b: &BodyScores) -> Markup {
    let [exposure, low, high] = b.rula().high_band;
    let leads = view.lead.is_some_and(|l| l.id == c.id);
    let is_best = view.result.verdict.best.as_deref() == Some(c.id.as_str());
    let rula = &b.rula().distribution;
    html! {
        tr.best[is_best] {
            td.n {
                (c.rank.map_or_else(String::new, |r| r.to_string()))
                @if let Some(value) = c.objective { span.small { (score(value)) } }
            }
            th scope="row" {
                (words::paths::path_name(c))
                span.small { code { (c.id) } }
                @if let Some(end) = c.path.as_ref().and_then(|p| p.time_s.last()) { span.small { (format!("{end:.2} s")) } }
            }
            td.n { (percent(exposure)) span.small { (percent(low)) " to " (percent(high)) } }
            @for (_, s) in b.scores.iter() {
                td.n {
                    (score(s.distribution.expected))
                    span.small { (score(s.distribution.p05)) " to " (score(s.distribution.p95)) }
                    span.small { "s.e. " (error(s.distribution.standard_error)) }
                    span.small { (score(s.per_metre)) "; " (score(s.peak)) }
                }
            }
            td.n {
                (score(rula.cvar90))
                span.small { (percent(rula.p_at_least.get(5).copied().unwrap_or(0.0))) }
            }
            td.n { @if leads { "–" } @else { (difference(view, c)) } }
            td.n { @if let Some(p) = &c.path { (hand(&p.hand)) } }
            td.n { (percent(b.reach_exceeded)) }
            td {
                (words::refusal::state(&c.status))
                @if let Status::Marked { violations } = &c.status {
                    @for v in violations { span.small { (ticked(&words::refusal::refusal(v))) } }
                }
                @if c.other_timing { span.small { "another timing" } }
                @for b in &c.bought { span.small { "not the best: " (words::paths::bought(b)) } }
            }
        }
    }
}

/// Greatest speed and acceleration of the hand.
fn hand(h: &HandMotion) -> Markup {
    html! {
        (format!("{:.2}", h.speed_m_s))
        span.small { (h.acceleration_m_s2.map_or_else(|| "not at rest at its ends".to_owned(), |a| format!("{a:.2}"))) }
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
        details {
        summary { "The same as numbers" }
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
                    @for (i, part) in lead.rula().parts.iter().enumerate() {
                        tr {
                            th scope="row" { (part.part) }
                            td.n { (score(part.mean)) }
                            td.n { (score(part.drives)) }
                            @if let Some(s) = straight {
                                @if let Some(p) = s.rula().parts.get(i) {
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
}

/// The lead for each body size.
pub(super) fn bodies(view: &View) -> Markup {
    let setting = &view.result.setting;
    let Some(lead) = view.lead else {
        return html! { (super::page::list(&words::setting::bodies(setting))) };
    };
    if lead.bodies.len() < 2 {
        return html! {
            p { "One body size was used: " (words::setting::bodies(setting).join("; ")) ". Others may score differently." }
        };
    }
    html! {
        div.scroll tabindex="0" role="region" aria-label="Body sizes" {
            table {
                caption { "Path " (lead.id) " for each body size." }
                thead { tr {
                    th scope="col" { "Body" }
                    th.n scope="col" { "Time at action level 3+" span.small { "90 % band" } }
                    @for m in ScoringMethod::ALL {
                        th.n scope="col" { "Expected " (m.name()) span.small { "90 % band" } }
                        th.n scope="col" { (m.name()) " per metre" span.small { "peak" } }
                    }
                    th.n scope="col" { "Out of reach" }
                } }
                tbody {
                    @for b in &lead.bodies {
                        tr {
                            th scope="row" {
                                (b.body)
                                @if Some(b.body.as_str()) == view.body { span.small { "the verdict is for this body" } }
                                @if let Some(own) = setting.bodies.iter().find(|x| x.name == b.body) { span.small { (words::setting::who(own)) } }
                            }
                            td.n {
                                (percent(b.rula().high_band[0]))
                                span.small { (percent(b.rula().high_band[1])) " to " (percent(b.rula().high_band[2])) }
                            }
                            @for (_, s) in b.scores.iter() {
                                td.n {
                                    (score(s.distribution.expected))
                                    span.small { (score(s.distribution.p05)) " to " (score(s.distribution.p95)) }
                                }
                                td.n { (score(s.per_metre)) span.small { (score(s.peak)) } }
                            }
                            td.n { (percent(b.reach_exceeded)) }
                        }
                    }
                }
            }
        }
    }
}

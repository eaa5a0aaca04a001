//! `one_page.html`: the decision on one sheet of A4 for the file.

use super::figure_still;
use super::page::{CSS, Figures, list, ticked};
use super::page_decision as decision;
use super::view::View;
use super::{ReportError, figure_paths};
use crate::ergonomics::ScoringMethod;
use crate::planner::{Severity, Status};
use crate::words;
use crate::words::number::{capital, percent, score};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// What differs from the style of the other pages.
const SHEET_CSS: &str = include_str!("one_page.css");
/// Rows that fit on the sheet.
const MOST_PATHS: usize = 4;
const MOST_CHANGES: usize = 3;
const MOST_CAUTIONS: usize = 3;

/// The sheet.
pub(super) fn one_page(view: &View) -> Result<String, ReportError> {
    let figures = Figures {
        still: figure_still::still(view)?,
        paths: figure_paths::paths(view)?,
        scores: None,
    };
    let setting = &view.result.setting;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                // By this a page is known as one that may be replaced (`files::signature`).
                meta name="generator" content="ergopath";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (setting.name) " – ergopath, one page" }
                style { (PreEscaped(CSS)) (PreEscaped(SHEET_CSS)) }
            }
            body.sheet {
                header {
                    h1 { (setting.name) }
                    p.small { (about(view)) }
                    @if let Some(what) = view.out_of_date { p.caveat { strong { "Out of date: " } (ticked(what)) } }
                }
                main {
                    (decision::first_screen(view, &figures))
                    @if let Some(body) = words::verdict::lead_scores(view.result) { (decision::keys(body)) }
                    (paths(view))
                    div.columns {
                        div { (changes(view)) (checked(view)) }
                        div { (cautions(view)) }
                    }
                }
                footer { (provenance(view)) }
            }
        }
    };
    Ok(page.into_string())
}

/// Who, with what, how.
fn about(view: &View) -> String {
    let s = &view.result.setting;
    let bodies: Vec<String> = words::setting::bodies(s);
    format!(
        "{}. Robot {}. {}. Load {:.1} kg in the part, the worker's share {}. Movement of {:.1} s.",
        bodies.join("; "),
        s.robot.name,
        capital(words::setting::hands(s.worker.hands)) + " on the robot",
        s.task.part_mass_kg,
        percent(s.task.human_load_share),
        s.duration_s
    )
}

/// The compared paths, best first.
fn paths(view: &View) -> Markup {
    if view.reported.is_empty() {
        return html! {};
    }
    html! {
        table {
            thead { tr {
                th.n scope="col" { "Rank" }
                th scope="col" { "Path" }
                th.n scope="col" { "Time at RULA action level 3+" }
                @for m in ScoringMethod::ALL { th.n scope="col" { "Expected " (m.name()) " (90 % band)" } }
                th scope="col" { "Limits" }
            } }
            tbody {
                @for c in view.reported.iter().take(MOST_PATHS) {
                    @if let Some(b) = view.scores(c) {
                        tr.best[view.result.verdict.best.as_deref() == Some(c.id.as_str())] {
                            td.n { (c.rank.map_or_else(String::new, |r| r.to_string())) }
                            th scope="row" { (words::paths::path_name(c)) " " code { (c.id) } }
                            td.n { (percent(b.rula().high_band[0])) }
                            @for (_, s) in b.scores.iter() {
                                @let d = &s.distribution;
                                td.n { (score(d.expected)) " (" (score(d.p05)) " to " (score(d.p95)) ")" }
                            }
                            td { (words::refusal::state(&c.status)) }
                        }
                    }
                }
            }
        }
    }
}

/// The changes that help most.
fn changes(view: &View) -> Markup {
    let Some(found) = &view.result.recommendations else { return html! {} };
    html! {
        h2 { "Small changes that help, each alone" }
        @if found.clear.is_empty() {
            p { "None of " (found.tried) " that were tried clearly lowers expected RULA." }
        } @else {
            ul { @for r in found.clear.iter().take(MOST_CHANGES) {
                @let rula = &r.effect[ScoringMethod::Rula];
                li { (capital(&words::cell::cell_change(&r.what))) ": RULA " (score(rula.expected[0])) " \u{2192} " (score(rula.expected[1])) }
            } }
        }
    }
}

/// What to mind, the weightiest first, with the number of those that are left out.
fn cautions(view: &View) -> Markup {
    let all = decision::cautions(view);
    let left = all.len().saturating_sub(MOST_CAUTIONS);
    html! {
        @if !all.is_empty() {
            h2 { "To mind" }
            (list(&all[..all.len() - left]))
            @if left > 0 { p.small { "And " (left) " more in report.html." } }
        }
    }
}

/// What was checked of the lead, what was not, and what is no part of the model.
fn checked(view: &View) -> Markup {
    let not_modelled: Vec<&str> =
        view.result.not_modelled.iter().map(|n| words::setting::not_modelled(*n)).collect();
    let not_modelled: Vec<&str> =
        not_modelled.iter().map(|w| w.split([':', ';']).next().unwrap_or(w)).collect();
    let lines = view.lead.and_then(|l| l.path.as_ref().map(|p| (l, p)));
    html! {
        h2 { "Checked, and not modelled" }
        ul {
            @if let Some((lead, path)) = lines {
                li {
                    (capital(&words::checklist::summary(&lead.checklist)))
                    @if let Status::Marked { .. } = lead.status { "; the path is over a limit" }
                    "."
                }
                li { (ticked(&capital(&words::robot::obstacle_clearance(&path.clearance)))) "." }
                li { (ticked(&capital(&words::robot::self_clearance(&path.self_clearance)))) "." }
            }
            li { "Not modelled: " (not_modelled.join("; ")) "." }
        }
    }
}

fn provenance(view: &View) -> Markup {
    let p = &view.result.provenance;
    let findings = words::verdict::findings(view.result, Severity::Note).len();
    html! {
        p {
            "ergopath " (p.program_version) ", " code { (p.command) } ", scores by RULA and REBA with profile " code { (p.score_profile) } "."
            @if let Some((name, hash)) = p.inputs.first() { " SHA-256 of " (name) ": " code { (hash.get(..16).unwrap_or(hash)) } "\u{2026}" }
            @if findings > 0 { " Notes and all figures: report.html." }
        }
        p.sign { "Reviewed by" span {} "Date" span {} }
    }
}

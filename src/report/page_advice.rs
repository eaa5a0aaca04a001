//! Sections of the page about what to look at and what to change: postures, recommendations.

use super::page::figure;
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::planner::{Recommendation, Recommendations};
use crate::words;
use crate::words::number::{capital, change, percent, score};
use maud::{Markup, html};

/// The postures that matter, with a table that says what the figure shows.
pub(super) fn postures(view: &View, png: Option<&Vec<u8>>) -> Markup {
    let moments = &view.result.moments;
    let Some(png) = png else { return html! { p { "No path was scored." } } };
    let names: Vec<&str> = moments[0].angles_deg.iter().map(|a| a.0.as_str()).collect();
    html! {
        (figure(
            png,
            "Stick figures from the side with their body angles; the table below holds the same numbers.",
            "Postures along the best path, seen from the worker's right. Typical: the repetition whose joint angles \
             are nearest to the mean of all at that moment. Held: trunk and arm move less than 7.5\u{b0} from \
             where they were and slower than 10\u{b0}/s.",
        ))
        @if moments.iter().all(|m| m.held_s.is_none()) {
            p.note { "No posture is held along this path: trunk and arm never rest." }
        }
        details {
        summary { "The same as numbers" }
        div.scroll tabindex="0" role="region" aria-label="Postures" {
            table {
                thead { tr {
                    th scope="col" { "Angle (\u{b0})" }
                    @for m in moments { th.n scope="col" { (words::cell::moment(m.what)) span.small { (format!("{:.2} s", m.time_s)) } } }
                } }
                tbody {
                    tr { th scope="row" { "RULA; REBA" } @for m in moments { td.n { (m.rula) "; " (m.reba) } } }
                    @for (i, name) in names.iter().enumerate() {
                        tr {
                            th scope="row" { (name) }
                            @for m in moments { td.n { (m.angles_deg.get(i).map_or_else(String::new, |a| format!("{:.0}", a.1.round() + 0.0))) } }
                        }
                    }
                }
            }
        }
        }
    }
}

/// What to change, with its effect.
pub(super) fn recommendations(view: &View) -> Markup {
    let drivers = html! {
        @if let Some(words) = driver_words(view) { p { (words) } }
    };
    let Some(found) = &view.result.recommendations else {
        return html! { (drivers) p { "No path was scored." } };
    };
    html! {
        (drivers)
        @if let Some(place) = &found.standing { p { (words::cell::standing_place(place)) } }
        @if found.clear.is_empty() {
            p { (tried(found)) " None clearly lowers expected RULA by 0.02 or more without clearly raising another score." }
        } @else {
            p { (tried(found)) " These clearly lower expected RULA and clearly raise no other score; the best step in each direction:" }
            div.scroll tabindex="0" role="region" aria-label="Recommendations" {
                table {
                    thead { tr {
                        th scope="col" { "Change" }
                        @for m in ScoringMethod::ALL {
                            th.n scope="col" { "Expected " (m.name()) span.small { "change, 95 % interval" } }
                            th.n scope="col" { "Time at " (m.name()) " level 3+" }
                        }
                        th.n scope="col" { "Peak moment about L5/S1" span.small { "N m" } }
                    } }
                    tbody { @for r in &found.clear { (row(r)) } }
                }
            }
        }
        p.note {
            "Each change is made alone, with path and robot unchanged and on the same repetitions; where an end is raised, the path is bent with it and \
             the robot is not checked again. Changes that cost reach or \
             bring the worker too close to the robot are left out. Check that your cell has room for them. Use " code { "[free]" } " \
             to let the planner combine several."
        }
    }
}

fn tried(found: &Recommendations) -> String {
    format!(
        "{} small changes of the worker's place, of the heights of start and goal, of the handle and the load were tried on the best path ({} repetitions \
         each).",
        found.tried, found.repetitions
    )
}

fn row(r: &Recommendation) -> Markup {
    html! {
        tr {
            th scope="row" { (capital(&words::cell::cell_change(&r.what))) }
            @for (_, e) in r.effect.iter() {
                td.n {
                    (score(e.expected[1]))
                    span.small { (change(e.change.mean)) " (" (change(e.change.low95)) " to " (change(e.change.high95)) ")" }
                }
                td.n { (percent(e.high[0])) " \u{2192} " (percent(e.high[1])) }
            }
            td.n { @if let Some([now, then]) = r.l5s1_peak_nm { (format!("{now:.0} \u{2192} {then:.0}")) } @else { "\u{2013}" } }
        }
    }
}

/// The body part that drives the total most.
fn driver_words(view: &View) -> Option<String> {
    let body = view.lead.and_then(|l| view.scores(l))?;
    let most = body.rula().parts.iter().max_by(|a, b| a.drives.total_cmp(&b.drives))?;
    (most.drives > 0.0).then(|| {
        format!(
            "The step that drives RULA most is \u{201c}{}\u{201d}: if it were at its lowest all the time, expected RULA would \
             be {} lower.",
            most.part,
            score(most.drives)
        )
    })
}

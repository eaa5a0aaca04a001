//! `shift.html`: how long at which action level, what gives it, who is worst off; then tasks, bodies, lifting and
//! what was assumed.

use super::ReportError;
use super::page::{document, list, ticked};
use super::shift_table::table;
use super::style::{css, method_levels};
use crate::ergonomics::{DUET_PROVENANCE, NIOSH_PROVENANCE, ScoringMethod};
use crate::shift::{BodyDose, Dose, ShiftResult};
use crate::words;
use crate::words::number::percent;
use crate::words::shift::minutes;
use maud::{Markup, html};

/// Share of a bar from which it holds its own number.
const NUMBERED: f64 = 0.09;
/// Grounds of the time in movements, of working time that was not scored, and of breaks.
const MOVING: &str = "background:#9fc5dd";
const UNSCORED: &str = "background:#c9ced6";
const OTHER: &str = "background:#e6e9ee";
const BREAK: &str =
    "background:repeating-linear-gradient(45deg,#fff,#fff 5px,#c9ced6 5px,#c9ced6 7px)";

/// All files of a shift, as (name, bytes).
pub fn shift_files(result: &ShiftResult) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let json = serde_json::to_string_pretty(result)? + "\n";
    Ok(vec![
        ("shift.json".to_owned(), json.into_bytes()),
        ("shift.csv".to_owned(), table(result)?),
        ("shift.html".to_owned(), page(result).into_bytes()),
    ])
}

fn page(result: &ShiftResult) -> String {
    let intro = html! {
        h1 { (result.name) }
        @if !result.description.is_empty() { p.about { (result.description) } }
    };
    let body = html! {
        section.verdict aria-labelledby="h-shift" {
            h2 id="h-shift" { "The shift" }
            @if let Some(body) = words::shift::worst_body(result) { (first_screen(result, body)) }
        }
        section aria-labelledby="h-tasks" {
            h2 id="h-tasks" { "Tasks" }
            @if let Some(body) = words::shift::worst_body(result) { (tasks(result, body)) }
        }
        section aria-labelledby="h-bodies" { h2 id="h-bodies" { "Bodies" } (bodies(result)) }
        section aria-labelledby="h-lifting" { h2 id="h-lifting" { "Lifting" } (lifting(result)) }
        @if result.exertion.is_some() {
            section aria-labelledby="h-hands" { h2 id="h-hands" { "Hand exertions" } (hands(result)) }
        }
        section aria-labelledby="h-assumed" {
            h2 id="h-assumed" { "What was assumed, and what is not modelled" }
            (list(&words::shift::notes(result)))
        }
        section aria-labelledby="h-from" { h2 id="h-from" { "Where the figures come from" } (origins(result)) }
    };
    document(&format!("{} – ergopath shift", result.name), &intro, &body, &html! {})
}

fn first_screen(result: &ShiftResult, body: &BodyDose) -> Markup {
    let lead = ScoringMethod::ALL[0];
    let high = &body.methods[lead].high;
    let time = &result.time;
    html! {
        div.decision {
            div.answer {
                @if let Some(most) = words::shift::most(result) { p.headline { (ticked(&most)) } }
                div.exposure {
                    span.what { "Time at " (lead.name()) " action level 3 or above (change soon)" }
                    span.big { (minutes(high.mean_min)) " of " (minutes(time.shift_min)) ", " (percent(high.mean_min / time.shift_min)) }
                    span.small {
                        @match words::shift::spread(high, body.units) {
                            Some(spread) => { (spread) "." }
                            None => { "Nothing is known of the spread: every task was measured once." }
                        }
                    }
                }
                @if let Some(whose) = words::shift::whose(result) { p { (ticked(&whose)) } }
                @if time.unscored_min() > 0.0 {
                    p { "The " (minutes(time.unscored_min())) " of work that were not scored may add to it." }
                }
                @for caveat in words::shift::caveats(result) { p.caveat { "Caution: " (ticked(&caveat)) } }
            }
            div.seen { (bars(result, body)) }
        }
    }
}

/// Where the time of the shift goes, and the scored part of it by level, of the shift and of each task.
fn bars(result: &ShiftResult, body: &BodyDose) -> Markup {
    let time = &result.time;
    let lead = ScoringMethod::ALL[0];
    let whole = [
        ("in scored movements", time.scored_min, MOVING),
        ("between movements, not scored", time.between_min, UNSCORED),
        ("other work, not scored", time.other_min, OTHER),
        ("breaks", time.breaks_min, BREAK),
    ];
    let there = || whole.iter().filter(|(_, minutes, _)| *minutes > 0.0);
    let parts: Vec<(f64, String)> = there().map(|(_, m, s)| (*m, (*s).to_owned())).collect();
    let of_shift = |m: ScoringMethod| -> Vec<f64> {
        body.methods[m].levels.iter().map(|l| l.at_min).collect()
    };
    html! {
        h3 { "Where the " (minutes(time.shift_min)) " go" }
        div.levelbars role="img" aria-label="Where the time of the shift goes, in minutes." {
            span.name { "Shift" }
            (bar(&parts, time.shift_min))
        }
        p.small.levelkey {
            @for (name, m, style) in there() { span { span.swatch style=(*style) {} (name) " " (percent(m / time.shift_min)) } }
        }
        h3 { "The scored movements by action level" }
        div.levelbars role="img" aria-label="Minutes of the scored movements at each action level; the same numbers stand in the tables below." {
            @for m in ScoringMethod::ALL {
                span.name { strong { "All, " (m.name()) } }
                (bar(&by_level(m, &of_shift(m)), time.scored_min))
            }
            @for (t, facts) in body.methods[lead].tasks.iter().zip(&result.tasks) {
                span.name { (facts.name) ", " (lead.name()) }
                (bar(&by_level(lead, &t.at_min), facts.moving_min))
            }
        }
        p.small.levelkey {
            "Action level: "
            @for level in method_levels(ScoringMethod::Reba) {
                span { span.swatch style={ "background:" (css(level.color)) } {} (level.number) }
            }
        }
        p.small {
            "Numbers in the bars are minutes. RULA has levels 1 to 4, REBA 0 to 4; 3 asks for a change soon, 4 now."
        }
    }
}

fn by_level(method: ScoringMethod, at_min: &[f64]) -> Vec<(f64, String)> {
    let levels = method_levels(method);
    at_min.iter().zip(&levels).map(|(m, l)| (*m, format!("background:{}", css(l.color)))).collect()
}

fn bar(parts: &[(f64, String)], all: f64) -> Markup {
    let number = |min: f64| if min < 9.95 { format!("{min:.1}") } else { format!("{min:.0}") };
    html! {
        div.levelbar {
            @for (min, style) in parts {
                @if *min > 0.0 {
                    span style={ "width:" (format!("{:.2}", 100.0 * min / all)) "%;" (style) } {
                        @if min / all >= NUMBERED { (number(*min)) }
                    }
                }
            }
        }
    }
}

fn of_spread(pair: Option<[f64; 2]>) -> String {
    pair.map_or_else(|| "not known".to_owned(), words::shift::range)
}

fn dose_cell(d: &Dose) -> Markup {
    html! { td.n { (minutes(d.mean_min)) span.small { (of_spread(d.band90_min)) } } }
}

fn tasks(result: &ShiftResult, body: &BodyDose) -> Markup {
    html! {
        p.note {
            "For the body " code { (body.body) } ". Movement: the time in the movements that were scored. Level 3+: time at action level 3 or "
            "above, with the 90 % band over people or repetitions of this task alone."
        }
        div.scroll tabindex="0" role="region" aria-label="Tasks" { table {
            thead { tr {
                th scope="col" { "Task" }
                th scope="col" { "Result" span.small { "path" } }
                th scope="col" { "Hands" span.small { "load" } }
                th.n scope="col" { "Cycles" span.small { "each" } }
                th.n scope="col" { "Time" span.small { "in movement" } }
                @for m in ScoringMethod::ALL {
                    th.n scope="col" { (m.name()) " level 3+" span.small { "90 % band" } }
                    th.n scope="col" { "Of the movement" span.small { "part of the shift's" } }
                }
            } }
            tbody { @for (k, t) in result.tasks.iter().enumerate() { tr {
                th scope="row" { (t.name) span.small { (words::shift::kind(t.kind)) } }
                td { code { (t.result) } span.small { @match &t.path { Some(p) => { (p) } None => { (t.source) } } } }
                td { (words::shift::hands(t.hands)) span.small { @if let Some(kg) = t.load_kg { (format!("{kg:.1} kg")) } } }
                td.n { (format!("{:.0}", t.cycles)) span.small { (format!("{:.2} s", t.duration_s)) } }
                td.n { (minutes(t.minutes)) span.small { (minutes(t.moving_min)) } }
                @for m in ScoringMethod::ALL {
                    @if let Some(d) = body.methods[m].tasks.get(k) {
                        (dose_cell(&d.high))
                        td.n { (percent(d.share_of_movement)) span.small { (percent(d.share_of_high)) } }
                    }
                }
            } } }
        } }
    }
}

fn bodies(result: &ShiftResult) -> Markup {
    html! {
        p.note {
            "Minutes of the shift at each action level, mean over people and repetitions. Band: "
            @if let Some(body) = words::shift::worst_body(result) { (words::shift::over(body.units)) } ". Interval: where the true mean lies."
        }
        @for m in ScoringMethod::ALL {
            h3 { (m.name()) }
            div.scroll tabindex="0" role="region" aria-label=(m.name()) { table {
                thead { tr {
                    th scope="col" { "Body" }
                    @for level in method_levels(m) { th.n scope="col" { "Level " (level.number) span.small { (level.words) } } }
                    th.n scope="col" { "Level 3+" span.small { "90 % band" } }
                    th.n scope="col" { "95 % interval" span.small { "of the mean" } }
                    th.n scope="col" { "Of the shift" }
                } }
                tbody { @for (k, b) in result.bodies.iter().enumerate() { tr class=[(k == result.worst).then_some("best")] {
                    th scope="row" { (b.body) @if k == result.worst && result.bodies.len() > 1 { span.small { "most time at RULA level 3+" } } }
                    @for l in &b.methods[m].levels { td.n { (minutes(l.at_min)) } }
                    (dose_cell(&b.methods[m].high))
                    td.n { (of_spread(b.methods[m].high.interval95_min)) }
                    td.n { (percent(b.methods[m].high.mean_min / result.time.shift_min)) }
                } } }
            } }
        }
    }
}

fn lifting(result: &ShiftResult) -> Markup {
    let dose = &result.lifting;
    let name = |k: usize| result.tasks.get(k).map_or("", |t| t.name.as_str());
    let number = |v: Option<f64>, digits: usize| {
        v.map_or_else(|| "no load".to_owned(), |v| format!("{v:.digits$}"))
    };
    html! {
        (list(&words::shift::lifting(result)))
        @if let Some(composite) = &dose.composite {
            p.note {
                "Tasks in order of their own index (STLI). Added: what each adds to the composite index, FILI x (1 / FM of the lifts so far "
                "- 1 / FM of those before). "
                @if let Some(d) = dose.duration { "Duration class: " (words::shift::lift_duration(d)) "." }
            }
            div.scroll tabindex="0" role="region" aria-label="Lifting" { table.slim {
                thead { tr {
                    th scope="col" { "Task" } th.n scope="col" { "Load" } th.n scope="col" { "Lifts a minute" span.small { "with those before" } }
                    th.n scope="col" { "FIRWL" span.small { "limit for rare lifts" } } th.n scope="col" { "STRWL" span.small { "limit of the task alone" } }
                    th.n scope="col" { "FILI" } th.n scope="col" { "STLI" } th.n scope="col" { "Added" }
                } }
                tbody { @for s in &composite.steps {
                    @let task = dose.applies_to.get(s.task).copied().unwrap_or_default();
                    tr {
                        th scope="row" { (name(task)) }
                        td.n { @if let Some(kg) = result.tasks.get(task).and_then(|t| t.load_kg) { (format!("{kg:.1} kg")) } }
                        td.n { @if let Some(f) = dose.tasks.get(task).and_then(|t| t.lifts_per_min) { (format!("{f:.2}")) } span.small { (format!("{:.2}", s.lifts_per_min)) } }
                        td.n { (format!("{:.1} kg", s.frequency_free_limit_kg)) }
                        td.n { (format!("{:.1} kg", s.limit_kg)) }
                        td.n { (number(s.frequency_free_index, 2)) } td.n { (number(s.index, 2)) } td.n { (number(s.adds, 2)) }
                    }
                } }
            } }
        }
        @if dose.refusal.is_some() {
            ul { @for t in &dose.tasks { @if t.refused.is_empty() {
                li { (name(t.task)) ": " @if let Some(f) = t.lifts_per_min { (format!("{f:.2} lifts a minute, ")) } "lifting index " (number(t.index, 2)) }
            } } }
        }
        p.note { (NIOSH_PROVENANCE) " The way of the hands is the prescribed one, so the index has no spread over people." }
    }
}

fn hands(result: &ShiftResult) -> Markup {
    html! {
        (list(&words::shift::exertion(result)))
        @if let Some(dose) = &result.exertion {
            div.scroll tabindex="0" role="region" aria-label="Hand exertions" { table.slim {
                thead { tr { th scope="col" { "Task" } th.n scope="col" { "Rating" span.small { "OMNI-RES" } } th.n scope="col" { "Exertions" } th.n scope="col" { "Damage" } } }
                tbody { @for t in &dose.tasks { tr {
                    th scope="row" { (result.tasks.get(t.task).map_or("", |f| f.name.as_str())) }
                    td.n { @if t.omni_res[0] == t.omni_res[1] { (t.omni_res[0]) } @else { (t.omni_res[0]) " to " (t.omni_res[1]) } }
                    td.n { (format!("{:.0}", t.exertions)) }
                    td.n { (format!("{:.4}", t.damage[0])) @if t.damage[0] < t.damage[1] { " to " (format!("{:.4}", t.damage[1])) } }
                } } }
            } }
        }
        p.note {
            "Ratings are yours, not predicted; posture does not enter. The share is that of 1022 people in plants of car makers, no forecast "
            "for a person. " (DUET_PROVENANCE)
        }
    }
}

fn origins(result: &ShiftResult) -> Markup {
    html! {
        p { "Order of work: " (words::shift::order(result.order)) "." }
        table.slim {
            thead { tr { th scope="col" { "File" } th scope="col" { "SHA-256" } } }
            tbody { @for (name, hash) in &result.inputs { tr { th scope="row" { (name) } td { code { (hash) } } } } }
        }
        p.note {
            "ergopath " (result.program_version) ". Scores: RULA (McAtamney & Corlett 1993) and REBA (Hignett & McAtamney 2000). Minutes add up over "
            "tasks; no published method says how posture scores combine over a shift, so no shift score is given."
        }
    }
}

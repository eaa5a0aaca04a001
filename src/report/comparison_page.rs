//! `comparison.html`: the runs ranked, compared with one of them, by body size and path, and drawn.

use super::comparison::{ComparedPath, ComparedRun, Comparison, Role, RowState, RunDifference};
use super::page::{document, ticked};
use super::style::{css, method_levels};
use crate::ergonomics::ScoringMethod;
use crate::words::number::{change, percent, score};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// The page; `drawn` is the picture of the cells.
pub(super) fn page(comparison: &Comparison, drawn: Option<&[u8]>) -> String {
    let ranked = comparison.ranked();
    let (done, without): (Vec<&ComparedRun>, Vec<_>) =
        ranked.iter().partition(|r| r.state == RowState::Ok);
    let mut caveats: Vec<&str> = done.iter().filter_map(|r| r.caveat.as_deref()).collect();
    caveats.sort_unstable();
    caveats.dedup();
    let intro = html! {
        h1 { "Comparison of " (ranked.len()) " runs" }
        p { (done.len()) " with a path that keeps all limits, " (without.len()) " without." }
        @for caveat in caveats {
            @let n = done.iter().filter(|r| r.caveat.as_deref() == Some(caveat)).count();
            p.caveat { "Caution, " (n) " of " (done.len()) " runs: " (caveat) }
        }
    };
    let body = html! {
        @if !done.is_empty() {
            section.verdict aria-labelledby="h-runs" {
                h2 id="h-runs" { "Best path of each run" }
                (headline(comparison, &done))
                (runs(comparison, &done))
            }
            section aria-labelledby="h-bodies" { h2 id="h-bodies" { "By body size and path" } (bodies(comparison, &done)) }
        }
        @if let Some(png) = drawn {
            section aria-labelledby="h-cells" {
                h2 id="h-cells" { "The cells" }
                figure {
                    img src={ "data:image/png;base64," (STANDARD.encode(png)) }
                        alt="Every run's paths, person and robot from the side and from above, all at one scale.";
                    figcaption {
                        "All runs at one scale: best path (thick), straight path (dashed), the user's own (dotted), \
                         mean posture and robot at start and, lighter, at the goal."
                    }
                }
            }
        }
        @if !without.is_empty() {
            section aria-labelledby="h-without" { h2 id="h-without" { "Runs without a path" } (failures(&without)) }
        }
        section aria-labelledby="h-from" { h2 id="h-from" { "Where the runs come from" } (origins(&ranked)) }
    };
    document("Comparison of runs – ergopath", &intro, &body, &html! {})
}

/// Which run scores lowest, and how sure that is.
fn headline(comparison: &Comparison, done: &[&ComparedRun]) -> Markup {
    let Some(against) = &comparison.against else { return html! {} };
    let of = |r: &ComparedRun| r.worst_body().and_then(|b| b.against.clone());
    let first = done[0];
    html! {
        p.headline {
            (first.name) " scores lowest"
            @if differs(comparison, first) { ", for another load or duration" }
            @if let Some(d) = of(first) {
                @if d.clear { ": expected RULA " (change(d.mean)) " against " (against) "." }
                @else { ", but not clearly lower than " (against) "." }
            } @else if done.len() > 1 { "; the others are compared with it." } @else { "; there is nothing to compare it with." }
        }
        @for run in done { @if differs(comparison, run) { p.warning {
            strong { "Not like for like: " } (run.name) " has another load or duration than " (against)
            "; its scores say what that task causes, not which arrangement is better."
        } } }
    }
}

/// Whether a run's task is another than that of the run it is held against.
fn differs(comparison: &Comparison, run: &ComparedRun) -> bool {
    let reference = comparison.runs.iter().find(|r| Some(&r.name) == comparison.against.as_ref());
    reference.is_some_and(|r| r.load_kg != run.load_kg || r.duration_s != run.duration_s)
}

fn runs(comparison: &Comparison, rows: &[&ComparedRun]) -> Markup {
    let against = comparison.against.as_deref().unwrap_or("–");
    let ends = rows.iter().filter_map(|r| r.worst_body()?.against.as_ref());
    let widest = ends
        .map(|d| d.low95.abs().max(d.high95.abs()))
        .filter(|w| w.is_finite())
        .fold(0.1, f64::max);
    html! {
        p.note {
            "Sorted by expected RULA of the body size that scores worst. 90 % band: nine of ten repetitions lie within. "
            "95 % interval: where the true mean difference lies. Paired: the same repetitions were simulated on both paths; \
             unpaired: two sets of repetitions, which give a wider interval."
        }
        p.note {
            "Bars, RULA action levels from left to right: "
            @for l in method_levels(ScoringMethod::Rula) { (l.number) " " (l.words) @if l.number < 4 { ", " } @else { "." } }
        }
        div.scroll tabindex="0" role="region" aria-label="Runs" { table {
            thead { tr {
                th scope="col" { "Run" }
                th scope="col" { "Best path" }
                th scope="col" { "Time at each action level" }
                th.n scope="col" { "Level 3+" span.small { "90 % band" } }
                th.n scope="col" { "Expected RULA" span.small { "90 % band" } }
                th.n scope="col" { "Expected REBA" }
                th.n scope="col" { "RULA against " (against) span.small { "95 % interval; left of the line is lower" } }
                th.n scope="col" { "Out of reach" }
            } }
            tbody { @for r in rows { @if let (Some(body), Some(best)) = (r.worst_body(), r.best()) {
                @let [exposure, low, high] = best.exposure_rula_5;
                tr {
                    th scope="row" { (r.name) span.small { (r.scenario) } }
                    td { (best.id) span.small { (body.body) } }
                    td { (bar(best)) }
                    td.n { (percent(exposure)) span.small { (percent(low)) " to " (percent(high)) } }
                    td.n { (score(best.expected_rula)) span.small { (score(best.p05_rula)) " to " (score(best.p95_rula)) } }
                    td.n { (score(best.expected_reba)) }
                    td.n {
                        (against_words(body.against.as_ref()))
                        @if let Some(d) = &body.against { (whisker(d.mean, [d.low95, d.high95], widest)) }
                    }
                    td.n { (percent(best.reach_exceeded)) }
                }
            } } }
        } }
    }
}

fn against_words(difference: Option<&RunDifference>) -> Markup {
    let Some(d) = difference else { return html! { "–" } };
    html! {
        @if d.clear { (change(d.mean)) } @else { "no clear difference" }
        span.small { (change(d.low95)) " to " (change(d.high95)) }
        span.small {
            @match &d.unpaired_because {
                None => { "paired, " (d.repetitions[0]) " repetitions" }
                Some(why) => { "unpaired: " (why) }
            }
        }
    }
}

/// The interval of a difference about a line at zero, `widest` at each end.
pub(super) fn whisker(mean: f64, [low, high]: [f64; 2], widest: f64) -> Markup {
    let at = |v: f64| format!("{:.1}", 70.0 + 64.0 * (v / widest).clamp(-1.0, 1.0));
    let (low, high, mean) = (at(low), at(high), at(mean));
    html! {
        svg width="140" height="22" viewBox="0 0 140 22" aria-hidden="true" {
            line x1="70" y1="1" x2="70" y2="21" stroke="#a0a8b4" stroke-width="1" {}
            line x1=(low) y1="11" x2=(high) y2="11" stroke="#1a202c" stroke-width="2" {}
            line x1=(low) y1="6" x2=(low) y2="16" stroke="#1a202c" stroke-width="2" {}
            line x1=(high) y1="6" x2=(high) y2="16" stroke="#1a202c" stroke-width="2" {}
            circle cx=(mean) cy="11" r="4" fill="#0072b2" {}
        }
    }
}

fn bar(path: &ComparedPath) -> Markup {
    let levels = method_levels(ScoringMethod::Rula);
    level_bar(|n| {
        levels.iter().find(|l| l.number == n).map_or(0.0, |l| l.share(&path.rula_at_least))
    })
}

/// A stacked bar of the shares of time by RULA action level, with its numbers as text.
pub(super) fn level_bar(share: impl Fn(u8) -> f64) -> Markup {
    let levels = method_levels(ScoringMethod::Rula);
    let shares: Vec<_> = levels.iter().map(|l| (l, share(l.number))).collect();
    html! {
        div.bar aria-hidden="true" {
            @for (level, share) in &shares {
                @if *share > 0.0 {
                    span style={ "width:" (format!("{:.2}", 100.0 * share)) "%;background:" (css(level.color)) } {}
                }
            }
        }
        span.small {
            @for (level, share) in &shares { (level.number) ": " (percent(*share)) @if level.number < 4 { ", " } }
        }
    }
}

fn bodies(comparison: &Comparison, rows: &[&ComparedRun]) -> Markup {
    let against = comparison.against.as_deref().unwrap_or("–");
    html! {
        div.scroll tabindex="0" role="region" aria-label="Bodies and paths" { table {
            thead { tr {
                th scope="col" { "Run" }
                th scope="col" { "Body" }
                th scope="col" { "Path" }
                th.n scope="col" { "Level 3+" }
                th.n scope="col" { "Expected RULA" span.small { "90 % band" } }
                th.n scope="col" { "Expected REBA" }
                th.n scope="col" { "Run's best against this" span.small { "95 % interval, paired" } }
                th.n scope="col" { "Best against that of " (against) span.small { "95 % interval" } }
            } }
            tbody { @for r in rows { @for b in &r.bodies { @for (k, p) in b.paths.iter().enumerate() { tr {
                @if k == 0 { th scope="row" { (r.name) } td { (b.body) } } @else { td {} td {} }
                td { (p.id) span.small { (role_words(p.role)) } }
                td.n { (percent(p.exposure_rula_5[0])) }
                td.n { (score(p.expected_rula)) span.small { (score(p.p05_rula)) " to " (score(p.p95_rula)) } }
                td.n { (score(p.expected_reba)) }
                td.n {
                    @if let Some(d) = p.best_minus_this {
                        @if d.clear { (change(d.mean)) } @else { "no clear difference" }
                        span.small { (change(d.low95)) " to " (change(d.high95)) }
                    } @else { "–" }
                }
                td.n {
                    @if p.role == Role::Best { (against_words(b.against.as_ref())) } @else { "–" }
                }
            } } } } }
        } }
    }
}

fn role_words(role: Role) -> &'static str {
    match role {
        Role::Best => "best",
        Role::Straight => "straight line",
        Role::Own => "your own",
    }
}

fn failures(rows: &[&ComparedRun]) -> Markup {
    html! {
        table {
            thead { tr { th scope="col" { "Run" } th scope="col" { "State" } th scope="col" { "Reason" } } }
            tbody { @for r in rows {
                @let (state, reason) = r.state_words();
                tr { th scope="row" { (r.name) } td { (state) } td { (ticked(reason)) } }
            } }
        }
    }
}

fn origins(rows: &[&ComparedRun]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Origins" { table {
            thead { tr {
                th scope="col" { "Run" } th scope="col" { "Robot" } th scope="col" { "Posture model" }
                th.n scope="col" { "Duration (s)" } th.n scope="col" { "Load (kg)" }
                th scope="col" { "ergopath" } th.n scope="col" { "Seed" }
                th scope="col" { "SHA-256 of the scenario" }
            } }
            tbody { @for r in rows { tr {
                th scope="row" { (r.name) }
                td { (r.robot) }
                td { (r.posture_model) }
                td.n { (r.duration_s.map_or_else(String::new, |v| format!("{v:.2}"))) }
                td.n { (r.load_kg.map_or_else(String::new, |v| format!("{v:.2}"))) }
                td { (r.program_version) }
                td.n { (r.seed.map_or_else(String::new, |s| s.to_string())) }
                td { @if !r.scenario_sha256.is_empty() { code { (r.scenario_sha256) } } }
            } } }
        } }
        p.note { "Scores: RULA (McAtamney & Corlett 1993) and REBA (Hignett & McAtamney 2000)." }
    }
}

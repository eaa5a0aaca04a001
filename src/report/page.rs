//! `report.html`: the frame of the page, the verdict and the figures.

use super::ReportError;
use super::page_advice as advice;
use super::page_evidence as evidence;
use super::page_scene as scene;
use super::page_scores as scores;
use super::style::{css, method_levels};
use super::view::View;
use crate::ergonomics::{P_AT_LEAST_S, ScoringMethod};
use crate::planner::{BodyScores, MethodScores, Severity};
use crate::words;
use crate::words::number::{change, percent, score};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The style sheet of all pages.
pub(super) const CSS: &str = include_str!("page.css");

/// Makes tables sortable; part of all pages.
const SORT_SCRIPT: &str = include_str!("sort.js");

/// The figures of the page as PNG.
#[derive(Debug, Clone)]
pub(super) struct Figures {
    pub paths: Vec<u8>,
    pub scores: Option<ScoreFigures>,
}

/// The figures that need a scored path.
#[derive(Debug, Clone)]
pub(super) struct ScoreFigures {
    pub over_time: Vec<u8>,
    pub levels: Vec<u8>,
    pub parts: Vec<u8>,
    pub parts_over_time: Option<Vec<u8>>,
    pub postures: Option<Vec<u8>>,
    pub distributions: Vec<u8>,
    pub population: Option<Vec<u8>>,
}

/// The sections in their order: id and heading.
const SECTIONS: [(&str, &str); 16] = [
    ("verdict", "Verdict"),
    ("levels", "Time at each action level"),
    ("variants", "Paths compared"),
    ("scene", "The scene in motion"),
    ("paths", "The paths"),
    ("parts", "Body parts"),
    ("curves", "Scores over time"),
    ("postures", "Postures to look at"),
    ("bodies", "Body sizes"),
    ("recommendations", "Small changes that help"),
    ("inputs", "Inputs and where they come from"),
    ("assumptions", "Assumptions and what is not modelled"),
    ("verification", "Verification"),
    ("infeasible", "Paths that are not feasible"),
    ("model", "Posture model"),
    ("provenance", "Provenance"),
];

/// The page.
pub(super) fn report(view: &View, figures: &Figures) -> Result<String, ReportError> {
    let setting = &view.result.setting;
    let title = format!("{} – ergopath report", setting.name);
    let scored = figures.scores.as_ref();
    let contents: [Markup; 16] = [
        verdict(view),
        levels(view, figures),
        variants(view, figures),
        scene::section(view),
        paths(view, figures),
        parts(view, figures),
        curves(figures),
        advice::postures(view, scored.and_then(|f| f.postures.as_ref())),
        bodies(view, figures),
        advice::recommendations(view),
        evidence::inputs(view),
        evidence::assumptions(view),
        evidence::verification(view),
        evidence::infeasible(view),
        evidence::model(view),
        evidence::provenance(view),
    ];
    let intro = html! {
        h1 { (setting.name) }
        @if !setting.description.is_empty() { p { (setting.description) } }
        @if let Some(what) = view.out_of_date { p.caveat { strong { "Out of date: " } (ticked(what)) } }
        nav.contents aria-label="Contents" {
            ul {
                @for (id, heading) in SECTIONS { li { a href={ "#" (id) } { (heading) } } }
            }
        }
    };
    let body = html! {
        @for ((id, heading), content) in SECTIONS.into_iter().zip(contents) {
            section id=(id) class=[(id == "verdict").then_some("verdict")] aria-labelledby={ "h-" (id) } {
                h2 id={ "h-" (id) } { (heading) }
                (content)
            }
        }
    };
    Ok(document(&title, &intro, &body, &scene::scripts(view)?))
}

/// A whole page around its content; scripts of its own come last.
pub(super) fn document(title: &str, intro: &Markup, body: &Markup, scripts: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                // By this a page is known as one that may be replaced (`files::signature`).
                meta name="generator" content="ergopath";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(CSS)) }
            }
            body {
                a.skip href="#main" { "Skip to the content" }
                header.top { (intro) }
                main id="main" { (body) }
                footer { "Made by ergopath. The same numbers are in the files beside this page." }
                script { (PreEscaped(SORT_SCRIPT)) }
                (scripts)
            }
        }
    }
    .into_string()
}

/// Text in which words between backticks are names.
pub(super) fn ticked(text: &str) -> Markup {
    html! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

/// A list of sentences.
pub(super) fn list(lines: &[String]) -> Markup {
    html! { ul { @for line in lines { li { (ticked(line)) } } } }
}

pub(super) fn figure(png: &[u8], alt: &str, caption: &str) -> Markup {
    html! {
        figure {
            img src={ "data:image/png;base64," (STANDARD.encode(png)) } alt=(alt);
            figcaption { (caption) }
        }
    }
}

fn verdict(view: &View) -> Markup {
    let result = view.result;
    let is_decided = result.verdict.is_decided();
    html! {
        p.headline { (ticked(&words::verdict::headline(result))) }
        @if let Some(caveat) = result.verdict.caveat {
            p.caveat { "Caution: " (words::verdict::caveat(caveat)) }
        }
        @for doubt in words::verdict::findings(result, Severity::Doubt) {
            p.warning { strong { "Warning: " } (ticked(&doubt)) }
        }
        @if let (true, Some(body)) = (is_decided, words::verdict::lead_scores(result)) { (keys(view, body)) }
        @if let Some(gain) = words::verdict::gain(result) { p { (ticked(&gain)) } }
        (list(&words::verdict::expected(result)))
        @if let Some(chosen) = words::verdict::chosen(result) { p { (chosen) } }
        (list(&words::verdict::findings(result, Severity::Note)))
        (list(&words::refused::lines(result)))
        @for caution in words::verdict::findings(result, Severity::Caution) {
            p.warning { strong { "Caution: " } (ticked(&caution)) }
        }
        @for warning in &result.warnings { p.warning { strong { "Warning: " } (ticked(&words::setting::warning(warning))) } }
        @if view.lead.is_some() { p.note {
            "90 % band: nine out of ten repetitions lie within it. Standard error: how far the mean itself may be \
             off because only " (rollouts(view)) " repetitions were simulated. A repetition is one draw of "
            (if view.shows_people() { "somebody like the recorded people, and of how they move" } else { "how this one person moves" })
            ". Scores are means of ordinal scores: they rank, they do not measure. Action level 3 of RULA \
             (score 5 or more) means: investigate and change soon. Peak: the score that is exceeded for 5 % of the time, \
             median over repetitions, interpolated within whole scores."
        } }
    }
}

fn rollouts(view: &View) -> String {
    let body = view.lead.and_then(|l| view.scores(l));
    body.map_or_else(|| "few".to_owned(), |b| b.rollouts.to_string())
}

/// The numbers that decide, large.
fn keys(view: &View, body: &BodyScores) -> Markup {
    let lead = ScoringMethod::Rula;
    let leading = &body.scores[lead];
    let [exposure, low, high] = leading.high_band;
    let at_least =
        leading.distribution.p_at_least.get(usize::from(lead.high())).copied().unwrap_or(0.0);
    html! {
        dl.keys {
            div.key {
                dt { "Time at " (lead.name()) " action level 3 or above" }
                dd.big { (percent(exposure)) }
                dd.small { "90 % band " (percent(low)) " to " (percent(high)) }
            }
            @for (method, s) in body.scores.iter() { (score_key(method, s)) }
            @if let Some(d) = view.straight.and_then(|s| view.difference(&s.id)) {
                div.key {
                    dt { (lead.name()) " against the straight path" }
                    dd.big { @if d.clear { (change(d.mean)) } @else { "no clear difference" } }
                    dd.small { "95 % interval " (change(d.low95)) " to " (change(d.high95)) }
                }
            }
            div.key {
                dt { (lead.name()) " " (lead.high()) " or more for at least " (P_AT_LEAST_S) " s" }
                dd.big { (percent(at_least)) }
                dd.small { "share of repetitions" }
            }
        }
    }
}

fn score_key(method: ScoringMethod, scores: &MethodScores) -> Markup {
    let d = &scores.distribution;
    let level = method.level(d.expected.round() as u8);
    let color = css(method_levels(method)[usize::from(level - method.level(1))].color);
    html! {
        div.key {
            dt { "Expected " (method.name()) }
            dd.big { (score(d.expected)) }
            dd.small { "90 % band " (score(d.p05)) " to " (score(d.p95)) }
            dd.small { "per metre " (score(scores.per_metre)) ", peak " (score(scores.peak)) }
            dd { span.badge style={ "background:" (color) } { "action level " (level) } }
            dd.small { (method.level_words(level)) }
        }
    }
}

fn levels(view: &View, figures: &Figures) -> Markup {
    let (Some(lead), Some(figures)) = (view.lead, &figures.scores) else {
        return html! { p { "No path was scored, so there is nothing to compare." } };
    };
    let described = view.scores(lead).map_or_else(String::new, |b| {
        let levels = method_levels(ScoringMethod::Rula);
        let shares = levels.iter().map(|l| {
            let share = l.share(&b.rula().distribution.exposure);
            format!("level {} {}", l.number, percent(share))
        });
        shares.collect::<Vec<_>>().join(", ")
    });
    figure(
        &figures.levels,
        &format!(
            "Stacked bars of the share of time at each RULA action level. {}: {described}.",
            lead.id
        ),
        "Each bar is one path for one body, best first: the share of time, over all repetitions, at each RULA action \
         level. For 0.5 s: the share of repetitions that spend at least half a second in total at level 3 or above.",
    )
}

fn paths(view: &View, figures: &Figures) -> Markup {
    let caption = if view.has_modes() {
        "The mean posture over all repetitions at start and goal, with the robot as a line through its \
         joints. Single repetitions differ from it: people reach down in two ways, and where they do it lies \
         between both. Obstacles are drawn as the boxes that bound them."
    } else if view.lead.is_some() {
        "The mean posture over all repetitions at start and goal, with the robot as a line through its \
         joints. Single repetitions differ from it. Obstacles are drawn as the boxes that bound them."
    } else {
        "No path was scored: start, goal and obstacles only."
    };
    figure(
        &figures.paths,
        "Paths from the side, from the front and from above, with the person and the robot as stick figures at start and goal.",
        caption,
    )
}

fn variants(view: &View, figures: &Figures) -> Markup {
    html! {
        (scores::variants(view))
        @if let Some(figures) = &figures.scores {
            (figure(
                &figures.distributions,
                "Box plots of the time mean of RULA over repetitions, one for each path of the table.",
                "How much one repetition differs from another: time mean of RULA of every simulated repetition.",
            ))
        }
    }
}

fn bodies(view: &View, figures: &Figures) -> Markup {
    let chart = figures.scores.as_ref().and_then(|f| f.population.as_ref());
    html! {
        @if let Some(chart) = chart {
            (figure(
                chart,
                "Expected RULA and REBA of the best path for each body size, with bands; the table below holds the same numbers.",
                "Dot: expected score. Bar: nine of ten repetitions. The shares of time stand in the table.",
            ))
        }
        (scores::bodies(view))
    }
}

fn curves(figures: &Figures) -> Markup {
    let Some(figures) = &figures.scores else {
        return html! { p { "No path was scored." } };
    };
    figure(
        &figures.over_time,
        "RULA and REBA score over time of the compared paths, on a ground coloured by action level. The \
         table of paths gives the same scores as numbers.",
        "Line: mean over repetitions at each moment. Band: from the 5th to the 95th percentile; a score is \
         a whole number, so the band moves in steps. Where the lines coincide, the paths score alike.",
    )
}

fn parts(view: &View, figures: &Figures) -> Markup {
    let Some(figures) = &figures.scores else {
        return html! { p { "No path was scored." } };
    };
    html! {
        (figure(
            &figures.parts,
            "Bars of the mean RULA step score of each body part and of how much each drives the total; the \
             table below holds the same numbers.",
            "Left: mean score of each step of RULA. Right: how much lower the RULA total would be on \
             average if this step alone were at its lowest. The right column shows where a change would pay off.",
        ))
        (scores::parts(view))
        @if let Some(map) = &figures.parts_over_time {
            (figure(
                map,
                "Map of the mean RULA step score of each body part over time along the best path.",
                "When each body part is loaded: the mean step score over repetitions at each moment, darker is higher.",
            ))
        }
    }
}

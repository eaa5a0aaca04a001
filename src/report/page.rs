//! `report.html`: the frame of the page, the verdict and the figures.

use super::ReportError;
use super::figure_still::Shown;
use super::page_advice as advice;
use super::page_decision as decision;
use super::page_evidence as evidence;
use super::page_scene as scene;
use super::page_scores as scores;
use super::style::method_levels;
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::words::number::percent;
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
    /// The cell in three dimensions, and what it shows of it.
    pub still: Option<(Vec<u8>, Shown)>,
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

/// A section of the page: id, word of the navigation, heading, content.
type Section = (&'static str, &'static str, &'static str, Markup);

/// The sections in their order; those without anything to say are left out.
fn sections(view: &View, figures: &Figures) -> Vec<Section> {
    let is_scored = view.lead.is_some();
    let scored = figures.scores.as_ref();
    let always = |section: Section| Some(section);
    let if_scored = |id, word, heading, content: &dyn Fn() -> Markup| {
        is_scored.then(|| (id, word, heading, content()))
    };
    let all = [
        always(("verdict", "Decision", "Decision", verdict(view, figures))),
        if_scored("variants", "Paths", "Paths compared", &|| variants(view, figures)),
        if_scored("scene", "Scene", "The scene in motion", &|| {
            html! { (scene::section(view)) (paths(view, figures)) }
        }),
        if_scored("parts", "Body parts", "Body parts and scores over time", &|| {
            html! { (parts(view, figures)) (curves(figures)) }
        }),
        if_scored("postures", "Postures", "Postures to look at", &|| {
            advice::postures(view, scored.and_then(|f| f.postures.as_ref()))
        }),
        if_scored("bodies", "People", "Body sizes", &|| bodies(view, figures)),
        if_scored("recommendations", "Changes", "Small changes that help", &|| {
            advice::recommendations(view)
        }),
        always((
            "inputs",
            "Inputs",
            "Inputs, assumptions, and what is not modelled",
            html! {
                (evidence::inputs(view))
                (evidence::assumptions(view))
            },
        )),
        always((
            "verification",
            "Checks",
            "Checks, and paths that were refused",
            html! {
                @if is_scored { (evidence::verification(view)) }
                h3 { "Paths that are not feasible" }
                (evidence::infeasible(view))
            },
        )),
        always((
            "model",
            "Model",
            "Posture model and provenance",
            html! {
                (evidence::model(view))
                (evidence::provenance(view))
            },
        )),
    ];
    all.into_iter().flatten().collect()
}

/// The page.
pub(super) fn report(view: &View, figures: &Figures) -> Result<String, ReportError> {
    let setting = &view.result.setting;
    let title = format!("{} – ergopath report", setting.name);
    let sections = sections(view, figures);
    let intro = html! {
        h1 { (setting.name) }
        @if !setting.description.is_empty() { p.about { (setting.description) } }
        @if let Some(what) = view.out_of_date { p.caveat { strong { "Out of date: " } (ticked(what)) } }
        nav.contents aria-label="Contents" {
            ul { @for (id, word, ..) in &sections { li { a href={ "#" (id) } { (word) } } } }
        }
    };
    let body = html! {
        @for (id, _, heading, content) in &sections {
            section id=(id) class=[(*id == "verdict").then_some("verdict")] aria-labelledby={ "h-" (id) } {
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
    picture(png, alt, &html! { (caption) })
}

/// A figure whose caption is more than words.
pub(super) fn picture(png: &[u8], alt: &str, caption: &Markup) -> Markup {
    html! {
        figure {
            img src={ "data:image/png;base64," (STANDARD.encode(png)) } alt=(alt);
            figcaption { (caption) }
        }
    }
}

fn verdict(view: &View, figures: &Figures) -> Markup {
    html! {
        (decision::first_screen(view, figures))
        (decision::beside(view))
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
        (levels(view, figures))
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

//! The first screen of the page: which path, how much better, how sure, for whom, what to mind and
//! what to settle. What it tells is not told again below.

use super::page::{Figures, list, picture, ticked};
use super::style::{css, method_levels};
use super::view::View;
use crate::ergonomics::{P_AT_LEAST_S, ScoringMethod};
use crate::planner::{BodyScores, CandidateResult, Decision, MethodScores, Severity};
use crate::words;
use crate::words::number::{percent, score};
use maud::{Markup, html};

/// Share of a bar from which it holds its own number.
const NUMBERED: f64 = 0.14;

/// The picture and the answer beside it.
pub(super) fn first_screen(view: &View, figures: &Figures) -> Markup {
    let result = view.result;
    html! {
        div.decision {
            div.seen { (still(figures)) }
            div.answer {
                p.headline { (ticked(&words::decision::which(result))) }
                @if let (true, Some(body)) = (result.verdict.is_decided(), words::verdict::lead_scores(result)) {
                    (exposure(view, body))
                    @if let Some(gain) = words::verdict::gain(result) { p { (ticked(&gain)) } }
                    (whose(view, body))
                    (bars(view, body))
                }
                @if view.lead.is_none() { (list(&words::refused::lines(result))) }
                (caution(view))
                @if view.lead.is_some() {
                    p.settle { strong { "Settle first: " } (ticked(&words::decision::settle(result))) }
                }
            }
        }
    }
}

/// The cell in three dimensions; where nothing was scored, the drawing of it.
fn still(figures: &Figures) -> Markup {
    let Some((png, shown)) = &figures.still else {
        return picture(
            &figures.paths,
            "The cell from the side, from the front and from above, with start, goal and obstacles.",
            &html! { "The cell as the scenario describes it." },
        );
    };
    let levels = method_levels(ScoringMethod::Rula);
    let level = ScoringMethod::Rula.level(shown.rula);
    let color =
        levels.iter().find(|l| l.number == level).map_or_else(String::new, |l| css(l.color));
    picture(
        png,
        "The worker with the robot in the cell, in three dimensions, at the hardest moment of the path.",
        &html! {
            "The hardest moment on average, at " (format!("{:.2}", shown.time_s)) " s: a typical repetition"
            @if shown.ghosts > 0 { ", and " (shown.ghosts) " others as shadows of it" }
            ". The shirt has the colour of its action level: "
            span.swatch style={ "background:" (color) } {} "RULA " (shown.rula) ". Blue: the path; dashed: the straight one."
        },
    )
}

/// The path that the lead is shown against: the user's own, else the straight one.
fn before<'a>(view: &View<'a>) -> Option<(String, &'a CandidateResult, &'a BodyScores)> {
    let own =
        view.own.iter().find_map(|c| Some((format!("your path `{}`", c.id), *c, view.scores(c)?)));
    let straight =
        || view.straight.and_then(|c| Some(("straight path".to_owned(), c, view.scores(c)?)));
    own.or_else(straight)
}

/// What the lead is called beside the path before it.
fn own_name(view: &View) -> String {
    match (view.result.verdict.outcome, view.lead) {
        (Decision::Assessed, Some(lead)) => format!("`{}`", lead.id),
        _ if !view.result.has_clear_best() => "lowest path".to_owned(),
        _ => "best path".to_owned(),
    }
}

/// Time at action level 3 or above, before and after.
fn exposure(view: &View, body: &BodyScores) -> Markup {
    let lead = ScoringMethod::Rula;
    let [share, low, high] = body.scores[lead].high_band;
    html! {
        div.exposure {
            span.what { "Time at " (lead.name()) " action level 3 or above" }
            @if let Some((name, _, scores)) = before(view) {
                span.big { (percent(scores.scores[lead].high_band[0])) " \u{2192} " (percent(share)) }
                span.small { (ticked(&name)) " \u{2192} " (ticked(&own_name(view))) "; in nine of ten repetitions " (percent(low)) " to " (percent(high)) }
            } @else {
                span.big { (percent(share)) }
                span.small { "in nine of ten repetitions " (percent(low)) " to " (percent(high)) }
            }
        }
    }
}

/// For whom, and who is worst off.
fn whose(view: &View, body: &BodyScores) -> Markup {
    let worst =
        words::strain::lines(body).into_iter().find(|(name, _)| *name == words::strain::WORST_OFF);
    html! {
        @if let Some(whose) = words::decision::whose(view.result) { p { (ticked(&whose)) } }
        @if let Some((_, sentence)) = worst { p { "Worst off is " (sentence) "." } }
    }
}

/// A bar of the time at each action level for the path before and the lead.
fn bars(view: &View, body: &BodyScores) -> Markup {
    let levels = method_levels(ScoringMethod::Rula);
    let mut rows: Vec<(String, &BodyScores)> = Vec::new();
    rows.extend(before(view).map(|(name, _, scores)| (name, scores)));
    rows.push((own_name(view), body));
    html! {
        div.levelbars role="img" aria-label="Share of the time at each RULA action level; the same numbers stand under Paths." {
            @for (name, scores) in rows {
                span.name { (ticked(&name)) }
                div.levelbar {
                    @for level in &levels {
                        @let share = level.share(&scores.rula().distribution.exposure);
                        @if share > 0.0 {
                            span style={ "width:" (format!("{:.2}", 100.0 * share)) "%;background:" (css(level.color)) } {
                                @if share >= NUMBERED { (percent(share)) }
                            }
                        }
                    }
                }
            }
        }
        p.small.levelkey {
            "RULA action level: "
            @for level in &levels { span { span.swatch style={ "background:" (css(level.color)) } {} (level.number) " " (level.words) } }
        }
    }
}

/// The one caution that matters most, and what the posture model is not.
fn caution(view: &View) -> Markup {
    let result = view.result;
    let doubts = words::verdict::findings(result, Severity::Doubt);
    let caveat = result.verdict.caveat.map(words::verdict::caveat);
    html! {
        @if let Some(doubt) = doubts.first() { p.warning { strong { "Warning: " } (ticked(doubt)) } }
        @if let Some(caveat) = caveat { p.caveat { "Caution: " (caveat) } }
    }
}

/// What is to be minded besides, the weightiest first.
pub(super) fn cautions(view: &View) -> Vec<String> {
    let result = view.result;
    let of = |severity: Severity| {
        result.verdict.findings.iter().filter(move |f| f.severity() == severity)
    };
    // The first doubt and what is to be settled first are told beside the picture.
    let found = of(Severity::Doubt).skip(1).chain(of(Severity::Caution));
    let new = found.filter(|f| !words::decision::is_settled(result, f));
    let warnings = result.warnings.iter().map(words::setting::warning);
    new.map(|f| words::finding::finding(f, result)).chain(warnings).collect()
}

/// What else is to be known for the decision.
pub(super) fn beside(view: &View) -> Markup {
    let result = view.result;
    let notes = result.verdict.findings.iter().filter(|f| f.severity() == Severity::Note);
    let notes: Vec<String> = notes.map(|f| words::finding::finding(f, result)).collect();
    let cautions = cautions(view);
    let is_decided = result.verdict.is_decided();
    html! {
        @if let (true, Some(body)) = (is_decided, words::verdict::lead_scores(result)) { (keys(body)) }
        @if let Some(chosen) = words::verdict::chosen(result) { p { (chosen) } }
        (list(&notes))
        @if view.lead.is_some() { (list(&words::refused::lines(result))) }
        @if !cautions.is_empty() {
            h3 { "To mind" }
            (list(&cautions))
        }
        @if view.lead.is_some() { p.note {
            "90 % band: nine out of ten repetitions lie within it. A repetition is one draw of "
            (if view.shows_people() { "somebody like the recorded people, and of how they move" } else { "how this one person moves" })
            ". Scores are means of ordinal scores: they rank, they do not measure. Action level 3 of RULA \
             (score 5 or more) means: investigate and change soon. Peak: the score that is exceeded for 5 % of the time, \
             median over repetitions, interpolated within whole scores."
        } }
    }
}

/// The scores themselves.
pub(super) fn keys(body: &BodyScores) -> Markup {
    let lead = ScoringMethod::Rula;
    let leading = &body.scores[lead];
    let at_least =
        leading.distribution.p_at_least.get(usize::from(lead.high())).copied().unwrap_or(0.0);
    html! {
        dl.keys {
            @for (method, s) in body.scores.iter() { (score_key(method, s)) }
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

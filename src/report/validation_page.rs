//! `validation.html`: how well people are predicted whom the model has not seen.

use super::page::{document, figure, ticked};
use super::validation::Drawings;
use crate::ergonomics::{BodyPart, ScoringMethod};
use crate::math::stats::quantile;
use crate::training::people::{
    Agreement, CENTRES, FEATURES, Known, LeftOut, Predictor, REPETITIONS, coverage,
};
use crate::words::number::{change, percent, score};
use maud::{Markup, html};

/// The page; `remarks` are those on the model that was judged.
pub(super) fn page(
    found: &LeftOut,
    judged: Option<&str>,
    remarks: &[String],
    drawings: &Drawings,
) -> String {
    let movements = found.movements().len();
    let people = match found.people.len() {
        1 => "1 person".to_owned(),
        count => format!("{count} people"),
    };
    let intro = html! {
        h1 { "How well " (people) " are predicted" }
        p {
            (movements) " recorded movements, "
            @match judged {
                Some(name) => { "predicted by the model " code { (name) } "." }
                None => { "each person left out in turn and predicted by a model of the others." }
            }
        }
        @for remark in remarks { p.caveat { (remark) } }
    };
    let body = html! {
        section.verdict aria-labelledby="h-scores" {
            h2 id="h-scores" { "Are the scores of a plan those of the person who does the work?" }
            p.headline { (headline(found)) }
            p.note {
                "The prediction knows the path of the hand from the feet and the size of the body, as in a plan. A score is \
                 the mean over time of a movement; both sides are scored with free hands, no load and no muscle use. Trunk and \
                 arm of the recorded person are those of the fitted body; head, knees and heels are the recorded ones, head \
                 and heels from the person's own upright neutral."
            }
            (scores(found))
            (figure(
                &drawings.scores,
                "Predicted against recorded RULA and REBA of each movement with the bands of the repetitions.",
                "Each movement once: recorded across, predicted up, with the bands of the repetitions. Nine of ten movements should \
                 have the dashed line in their thin band.",
            ))
            (parts(found))
            (entered(found))
        }
        section aria-labelledby="h-bands" {
            h2 id="h-bands" { "Do the bands hold what they promise?" }
            (bands(found))
            (figure(
                &drawings.coverage,
                "Share of the recorded frames inside the 90 % band for each person and part of the body.",
                "Frames of one movement are alike: a person with few movements can be far from 90 % by chance.",
            ))
        }
        @if let Some(png) = &drawings.movement {
            section aria-labelledby="h-movement" {
                h2 id="h-movement" { "One movement" }
                (figure(
                    png,
                    "Recorded angles and RULA of one movement over time in the bands of the repetitions.",
                    "The movement whose energy score is the median of all: neither the best nor the worst.",
                ))
            }
        }
        section aria-labelledby="h-postures" {
            h2 id="h-postures" { "How far off is a single posture?" }
            (postures(found))
        }
    };
    document("Validation – ergopath", &intro, &body, &html! {})
}

fn headline(found: &LeftOut) -> String {
    let risk = found.risk(ScoringMethod::Rula);
    let ranks = risk.agreement.rank_correlation.map_or_else(String::new, |r| {
        format!(", ranks movements with a correlation of {}", score(r))
    });
    format!(
        "Predicted RULA is {} off on average{ranks}, and {} of the movements are inside its 90 % band.",
        score(risk.agreement.mae),
        percent(risk.inside90)
    )
}

fn cells(agreement: Option<Agreement>) -> Markup {
    let Some(a) = agreement else { return html! { td.n { "–" } td.n { "–" } td.n { "–" } } };
    html! {
        td.n { (score(a.mae)) }
        td.n { (change(a.bias)) }
        td.n { (a.rank_correlation.map_or_else(|| "–".to_owned(), score)) }
    }
}

fn scores(found: &LeftOut) -> Markup {
    let name = |p: Predictor| match p {
        Predictor::FullW => "full-w, without chance",
        other => other.name(),
    };
    html! {
        div.scroll tabindex="0" role="region" aria-label="Scores" { table {
            thead { tr {
                th scope="col" { "From the hand path alone" }
                @for method in ScoringMethod::ALL {
                    th.n scope="col" { (method.name()) " error" span.small { "mean, absolute" } }
                    th.n scope="col" { "Bias" span.small { "predicted less recorded" } }
                    th.n scope="col" { "Ranks" span.small { "Spearman" } }
                }
                th.n scope="col" { "RULA error" span.small { "start known" } }
            } }
            tbody {
                tr.best {
                    th scope="row" { "full-w, " (REPETITIONS) " repetitions" span.small { "as in a plan" } }
                    @for method in ScoringMethod::ALL { (cells(Some(found.risk(method).agreement))) }
                    td.n { "–" }
                }
                @for p in found.predictors() { tr {
                    th scope="row" { (name(p)) }
                    @for method in ScoringMethod::ALL { (cells(found.risk_of(method, p, Known::HandPath))) }
                    td.n {
                        @let known = found.risk_of(ScoringMethod::Rula, p, Known::Start).filter(|_| p.needs_start());
                        (known.map_or_else(|| "–".to_owned(), |a| score(a.mae)))
                    }
                } }
            }
        } }
        p.note {
            "Rows below the first have no chance in them. Those that follow the hand begin in the usual posture at its first \
             place; in the last column in the recorded one."
        }
    }
}

fn parts(found: &LeftOut) -> Markup {
    html! {
        h3 { "Where the error comes from" }
        div.scroll tabindex="0" role="region" aria-label="Parts of the body" { table.slim {
            thead { tr {
                th scope="col" { "As it was recorded" }
                @for method in ScoringMethod::ALL { th.n scope="col" { (method.name()) " error" } }
            } }
            tbody {
                tr {
                    th scope="row" { "nothing" }
                    @for m in ScoringMethod::ALL { td.n { (score(found.risk(m).agreement.mae)) } }
                }
                @for part in BodyPart::ALL { tr {
                    th scope="row" { (part.name()) }
                    @for m in ScoringMethod::ALL { td.n { (score(found.risk_with(m, part).mae)) } }
                } }
            }
        } }
        p.note { "The same repetitions with one part of the body put where it was recorded: the lower, the more that part matters." }
    }
}

/// What the sheets hold on both sides: a part that is predicted well enough can still tick other boxes.
fn entered(found: &LeftOut) -> Markup {
    html! {
        h3 { "What is entered in the sheets" }
        div.scroll tabindex="0" role="region" aria-label="Entries of the sheets" { table.slim {
            thead { tr {
                th scope="col" { "Mean over movements" }
                th.n scope="col" { "Recorded" }
                th.n scope="col" { "Predicted" }
            } }
            tbody { @for e in found.entered() {
                @let shown = |v: f64| if e.is_angle() { format!("{v:.0} deg") } else { percent(v) };
                tr {
                    th scope="row" { (e.column.replace('_', " ")) }
                    td.n { (shown(e.recorded)) }
                    td.n { (shown(e.predicted)) }
                }
            } }
        } }
        p.note { "Angles, and the share of the time for which a box is ticked." }
    }
}

fn bands(found: &LeftOut) -> Markup {
    let all = found.movements();
    html! {
        p {
            "The 90 % bands hold " (percent(found.pooled(1))) " of the recorded frames, and " (percent(found.worst(1)))
            " for the worst person and part; the 50 % bands " (percent(found.pooled(0))) " and " (percent(found.worst(0))) "."
        }
        div.scroll tabindex="0" role="region" aria-label="Bands" { table {
            thead { tr {
                th scope="col" { "Everybody" }
                @for (i, f) in FEATURES.iter().enumerate() { th.n scope="col" { (f) span.small { @if i == 0 { "cm" } @else { "deg" } } } }
            } }
            tbody {
                tr { th scope="row" { "90 % band holds" } @for f in 0..FEATURES.len() { td.n { (percent(coverage(&all, f, 1))) } } }
                tr { th scope="row" { "50 % band holds" } @for f in 0..FEATURES.len() { td.n { (percent(coverage(&all, f, 0))) } } }
                tr { th scope="row" { "continuous ranked probability score" } @for f in 0..FEATURES.len() { td.n { (format!("{:.1}", found.crps(f))) } } }
            }
        } }
    }
}

fn postures(found: &LeftOut) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Postures" { table {
            thead { tr {
                th scope="col" { "From the recorded first posture" span.small { "rms over time, mean over movements" } }
                @for (i, f) in FEATURES.iter().enumerate() { th.n scope="col" { (f) span.small { @if i == 0 { "cm" } @else { "deg" } } } }
                @for c in CENTRES { th.n scope="col" { (c) span.small { "cm" } } }
                th.n scope="col" { "Angles" span.small { "median person, deg" } }
            } }
            tbody { @for p in found.predictors() { tr {
                th scope="row" { (p.name()) }
                @for f in 0..FEATURES.len() { td.n { (format!("{:.1}", found.rms(p, f))) } }
                @for c in found.centres_cm(p) { td.n { (format!("{c:.1}")) } }
                td.n { (format!("{:.1}", quantile(&found.angle_errors_deg(p), 0.5))) }
            } } }
        } }
        p.note { (ticked("Joint centres of the side that leads are held against those of the fitted body. `ergopath validate --help` says more; the figures of each movement are in `validation.json`.")) }
    }
}

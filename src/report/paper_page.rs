//! `experiment.html`: one of the paper's experiments on one page.

use super::page::{document, figure};
use crate::posture::Method;
use crate::training::Percentiles;
use crate::training::paper::{
    Chain, ChainResult, MethodSummary, PaperExperiment, PaperResult, paper_table,
};
use maud::{Markup, html};

/// The pictures of one chain, PNG.
pub(super) struct ChainDrawings {
    pub methods: Vec<u8>,
    pub coverage: Vec<u8>,
    pub horizon: Vec<u8>,
    pub weights: Option<Vec<u8>>,
    /// By method.
    pub spreads: Vec<(Method, Vec<u8>)>,
}

/// The page; `drawings` in the order of the chains.
pub(super) fn page(result: &PaperResult, drawings: &[ChainDrawings]) -> String {
    let name = result.experiment.name().to_uppercase();
    let intro = html! {
        h1 { "The paper's " (name) " repeated" }
        p { (who(result)) " " (how(result)) }
        @if result.simulated { p.caveat { "Simulated people: nobody was recorded." } }
    };
    let body = html! {
        @for (chain, pictures) in result.chains.iter().zip(drawings) {
            (one(result.experiment, chain, pictures))
        }
    };
    document(&format!("{name} – ergopath"), &intro, &body, &html! {})
}

fn who(result: &PaperResult) -> String {
    let sets = result.chains.first().map_or(0, |c| c.sets.len());
    let people = if result.simulated { "simulated people" } else { "recorded people" };
    format!("{sets} training sets of {people}, seed {}.", result.seed)
}

/// What teaches and what tests.
fn how(result: &PaperResult) -> &'static str {
    match (result.experiment, result.simulated) {
        (PaperExperiment::Exp1, _) => {
            "The same movement: the first half of its repetitions teaches, the second half tests."
        }
        (PaperExperiment::Exp2, true) => {
            "Random movements teach; the second half of the repetitions of a primitive tests."
        }
        (PaperExperiment::Exp2, false) => {
            "A person's other tasks teach; the second half of a task's repetitions tests."
        }
        (PaperExperiment::Exp3, true) => {
            "Other bodies, seated: the first half of the repetitions teaches, the second half tests."
        }
        (PaperExperiment::Exp3, false) => {
            "Another body: all other people's repetitions of a task teach, a person's own test."
        }
    }
}

fn one(experiment: PaperExperiment, chain: &ChainResult, pictures: &ChainDrawings) -> Markup {
    let key = chain.chain.name();
    let n = chain.joints.len();
    let title = match chain.chain {
        Chain::Arm => format!("From a pelvis that rests to the hand: {n} joints"),
        Chain::Whole => format!("Whole body: {n} coordinates"),
    };
    html! {
        section aria-labelledby=(format!("h-{key}")) {
            h2 id=(format!("h-{key}")) { (title) }
            (table(experiment, chain))
            ul { @for a in &chain.against { li {
                "MI-NsGP against " (a.other.name()) ": relative RMSE smaller in " (a.rmse_better) " of " (a.sets)
                " sets (median ratio " (format!("{:.2}", a.rmse_ratio)) "), likelihood higher in " (a.ll_better)
                ", and in " (a.ll_rescaled_better) " were each law's sureness put right in hindsight."
            } } }
            (figure(&pictures.methods, "Box plots of likelihoods and errors by method.", "Held-out movements of all sets."))
            (figure(
                &pictures.coverage,
                "Box plots of the shares inside the bands by method.",
                "50 and 90 % would be right. Joint angles: bands of repetitions that begin in the recorded posture.",
            ))
            (figure(
                &pictures.horizon,
                "Error of hand and joints over the horizon by method.",
                "The paper's Fig. 6b for all methods.",
            ))
            @if let Some(png) = &pictures.weights {
                (figure(png, "Weights of each joint over the training sets.", "Does the same W come out of every set?"))
            }
            @for (method, png) in &pictures.spreads {
                (figure(
                    png,
                    "Sampled postures on the body, and four scores over time.",
                    &format!("The paper's Fig. 5, by {}.", method.name()),
                ))
            }
        }
    }
}

fn spread(p: Percentiles, digits: usize) -> String {
    format!("{:.digits$} [{:.digits$}, {:.digits$}]", p.median, p.p05, p.p95)
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn table(experiment: PaperExperiment, chain: &ChainResult) -> Markup {
    let paper = paper_table(experiment);
    let printed = |m: &MethodSummary| paper.iter().find(|p| p.method == m.method);
    let of = |v: [f64; 3]| Percentiles { median: v[0], p05: v[1], p95: v[2] };
    html! {
        div.scroll tabindex="0" role="region" aria-label="Methods" { table {
            thead { tr {
                th scope="col" { "Method" span.small { "median [5th, 95th percentile] over movements" } }
                th.n scope="col" { "Likelihood" span.small { "nats per frame" } }
                th.n scope="col" { "Relative RMSE" }
                th.n scope="col" { "Surprise" span.small { "1 is right" } }
                th.n scope="col" { "Inside 50, 90 %" span.small { "joint velocities" } }
                th.n scope="col" { "Inside 90 %" span.small { "joint angles; width" } }
                th.n scope="col" { "Paper: likelihood" }
                th.n scope="col" { "Paper: root of RMSE" span.small { "1e-3" } }
            } }
            tbody { @for m in &chain.methods { tr {
                th scope="row" { (m.method.name()) }
                td.n { (spread(m.ll_q, 1)) }
                td.n { (spread(m.relative_rmse_q, 3)) }
                td.n { (format!("{:.1}", m.surprise.median)) }
                td.n { (percent(m.velocity_coverage[0])) ", " (percent(m.velocity_coverage[1])) }
                td.n { (m.bands.map_or_else(|| "–".to_owned(), |b| format!("{}; {:.1} deg", percent(b.coverage_90), b.width_90_deg))) }
                td.n { (printed(m).map_or_else(|| "–".to_owned(), |p| spread(of(p.ll_q), 2))) }
                td.n { (printed(m).map_or_else(|| "–".to_owned(), |p| spread(of(p.rmse_q_if_squared().map(|v| 1e3 * v)), 0))) }
            } } }
        } }
        p.note {
            "The paper's columns are of another chain and other people; its RMSE behaves like a mean of squares, so the root \
             is shown: compare order and ratios. Surprise is the squared residual in the null space over its predicted variance."
        }
    }
}

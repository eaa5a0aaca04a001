//! `batch.html`: which cell for whom, what each factor changes, and every cell with its distribution.
//!
//! Cells of one station (scenario, load, duration) are ranked among each other; other stations never among them.

use super::batch_charts::{bar_of_levels, heat_maps, pareto, scripts, whisker_of};
use super::page::{document, ticked};
use super::style::method_levels;
use crate::batch::{
    CellState, Effect, FactorKind, Finished, LevelEffect, PathRow, Station, front, main_effects,
};
use crate::ergonomics::ScoringMethod;
use crate::words::number::{capital, change, percent, score};
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The page; `pages` tells which cells have a page of their own.
pub fn batch_page(finished: &Finished, pages: &[bool]) -> String {
    let plan = &finished.plan;
    let stations = Stations::of(finished);
    let count = |state: CellState| finished.records.iter().filter(|r| r.state == state).count();
    let done = count(CellState::Ok);
    let intro = html! {
        h1 { (plan.name) }
        @if !plan.description.is_empty() { p { (plan.description) } }
        p {
            (plan.cells.len()) " cells: " (done) " with a path that may be used, " (count(CellState::NoFeasiblePath))
            " without a feasible path, " (count(CellState::NotSupported)) " not supported by the recordings, "
            (count(CellState::Failed)) " failed. "
            @if plan.mode.is_assess() { "Your own paths were scored as they are." }
            @else { "Paths were planned; a cell is known by its best path." }
        }
        @for (caveat, n) in caveats(finished) { p.caveat { "Caution, " (n) " of " (plan.cells.len()) " cells: " (caveat) } }
    };
    let effects = main_effects(finished);
    let body = html! {
        @if done > 0 {
            section.verdict aria-labelledby="h-best" {
                h2 id="h-best" { "Lowest in each workstation" }
                (verdict(finished, &stations))
            }
            section aria-labelledby="h-map" { h2 id="h-map" { "Two factors at a time" } (heat_maps(finished, &stations)) }
            @if !effects.is_empty() {
                section aria-labelledby="h-effects" { h2 id="h-effects" { "What each factor changes" } (effects_table(finished, &effects)) }
            }
            section aria-labelledby="h-front" { h2 id="h-front" { "Risk against duration" } (pareto(finished, &stations, &front(finished))) }
        }
        section aria-labelledby="h-cells" { h2 id="h-cells" { "All cells" } (cells(finished, &stations, pages)) }
    };
    document(&format!("{} – ergopath", plan.name), &intro, &body, &scripts(finished, &stations))
}

/// Which cells are layouts of one workstation, and how they rank in it.
pub(super) struct Stations {
    /// By cell.
    pub of: Vec<usize>,
    /// By cell, from 1; none without a path that may be used.
    pub rank: Vec<Option<usize>>,
    /// Their names.
    pub names: Vec<String>,
}

impl Stations {
    fn of(finished: &Finished) -> Self {
        let of: Vec<usize> = finished.plan.cells.iter().map(|c| c.station).collect();
        let rula = |k: &usize| finished.row(*k).and_then(|r| r.number("rula_expected"));
        let mut rank = vec![None; of.len()];
        let mut own: Vec<Vec<(f64, usize)>> = vec![Vec::new(); finished.plan.stations.len()];
        for (k, station) in of.iter().enumerate() {
            own[*station].extend(rula(&k).map(|v| (v, k)));
        }
        for mut ranked in own {
            ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (place, (_, k)) in ranked.iter().enumerate() {
                rank[*k] = Some(place + 1);
            }
        }
        Self { of, rank, names: names(finished) }
    }

    pub(super) fn numbers(&self) -> std::ops::Range<usize> {
        0..self.names.len()
    }
}

/// Stations in words; the file where two have the same.
fn names(finished: &Finished) -> Vec<String> {
    let plan = &finished.plan;
    let name = |s: &Station| format!("{}, {:.2} kg, {:.1} s", s.name, s.load_kg, s.duration_s);
    let all: Vec<String> = plan.stations.iter().map(name).collect();
    let scenario = plan.factors.iter().find(|f| f.kind == FactorKind::Scenario);
    let mut times: BTreeMap<&String, usize> = BTreeMap::new();
    for name in &all {
        *times.entry(name).or_default() += 1;
    }
    let told = |(s, name): (&Station, &String)| match scenario {
        Some(f) if times[name] > 1 => {
            format!("{name} ({})", f.levels[s.scenario])
        }
        _ => name.clone(),
    };
    plan.stations.iter().zip(&all).map(told).collect()
}

fn caveats(finished: &Finished) -> Vec<(String, usize)> {
    let mut all: Vec<(String, usize)> = Vec::new();
    for caveat in finished.records.iter().filter_map(|r| r.caveat.as_ref()) {
        match all.iter_mut().find(|(c, _)| c == caveat) {
            Some((_, n)) => *n += 1,
            None => all.push((caveat.clone(), 1)),
        }
    }
    all
}

/// The levels of a cell in what varies, in words.
pub(super) fn levels_in_words(finished: &Finished, cell: usize) -> String {
    let plan = &finished.plan;
    let each = plan.varied().into_iter();
    let parts: Vec<String> =
        each.map(|f| format!("{} {}", plan.factors[f].name, plan.label(cell, f))).collect();
    parts.join(", ")
}

fn verdict(finished: &Finished, stations: &Stations) -> Markup {
    let first = (0..stations.of.len()).filter(|k| stations.rank[*k] == Some(1));
    let best: BTreeMap<usize, usize> = first.map(|k| (stations.of[k], k)).collect();
    html! {
        @for station in stations.numbers() {
            @if let Some((k, row)) = best.get(&station).and_then(|k| Some((*k, finished.row(*k)?))) {
                p.headline {
                    (stations.names[station]) ": lowest for " (levels_in_words(finished, k)) ". RULA at action level 3 or above for "
                    (share(row, "time_share_rula_ge_5")) " of the time (90 % of repetitions: " (share(row, "time_share_rula_ge_5_p05"))
                    " to " (share(row, "time_share_rula_ge_5_p95")) ")."
                }
            } @else { p { (stations.names[station]) ": no cell has a path that may be used." } }
        }
        p.note {
            "Lowest by expected RULA, for the body that is worst on the path of the cell. That the first cell differs from the \
             next is not shown by its rank: see what each factor changes, with its interval."
        }
        @if stations.names.len() > 1 { p.note {
            "Cells are compared only where scenario, load and the duration that the scenario gives are the same. Other \
             stations are other work, and their scores say what that work causes, not which layout is better."
        } }
    }
}

fn share(row: &PathRow, column: &str) -> String {
    row.number(column).map_or_else(|| "unknown".to_owned(), percent)
}

fn effects_table(finished: &Finished, effects: &[Effect]) -> Markup {
    let plan = &finished.plan;
    let all = || effects.iter().flat_map(|e| &e.levels).filter_map(|l| l.difference);
    let widest = all().flat_map(|[_, l, h]| [l.abs(), h.abs()]).filter(|w| w.is_finite());
    let widest = widest.fold(0.1, f64::max);
    html! {
        p.note {
            "Expected RULA of a level minus that of the first level, over all pairs of cells that are alike in every other \
             factor. Paired: both cells of each pair are of the same simulated people, so that chance cancels. The 95 % interval \
             is for other repetitions in these very cells; it says nothing of other layouts, tasks or workers."
        }
        div.scroll tabindex="0" role="region" aria-label="Main effects" { table {
            thead { tr {
                th scope="col" { "Factor" } th scope="col" { "Level" } th scope="col" { "Against" }
                th.n scope="col" { "Change of expected RULA" span.small { "95 % interval; left of the line is lower" } }
                th.n scope="col" { "Pairs of cells" }
            } }
            tbody { @for effect in effects { @for level in &effect.levels {
                @let factor = &plan.factors[effect.factor];
                tr {
                    th scope="row" { (factor.name) }
                    td { (factor.levels[level.level]) }
                    td { (factor.levels[effect.against]) }
                    td.n { (effect_words(level, factor.kind, &factor.name)) @if let Some(d) = level.difference { (whisker_of(d, widest)) } }
                    td.n { (level.pairs[0]) @if level.pairs[0] < level.pairs[1] { span.small { "of " (level.pairs[1]) "; the others have no path" } } }
                }
            } } }
        } }
    }
}

fn effect_words(level: &LevelEffect, kind: FactorKind, name: &str) -> Markup {
    let Some([mean, low, high]) = level.difference else { return html! { "not known" } };
    let why = match kind {
        FactorKind::Seed => "other draws",
        _ if name == "worker.bodies" => "other bodies",
        _ => "other people",
    };
    html! {
        @if level.is_clear() { (change(mean)) } @else { "no clear difference" }
        span.small { (change(low)) " to " (change(high)) ", " @if level.is_paired { "paired" } @else { "unpaired: " (why) } }
    }
}

fn cells(finished: &Finished, stations: &Stations, pages: &[bool]) -> Markup {
    let plan = &finished.plan;
    let varied = plan.varied();
    html! {
        p.note {
            "Bars, RULA action levels from left to right: "
            @for l in method_levels(ScoringMethod::Rula) { (l.number) " " (l.words) @if l.number < 4 { ", " } @else { ". " } }
            "90 % band: nine of ten repetitions lie within. Of several bodies the row is of the one that is worst. Ranks count within a workstation. "
            "All columns, paths and bodies are in cells.csv and cells.parquet; columns.csv says what each means."
        }
        div.controls.scripted id="batch-filters" {}
        p.note.scripted id="batch-count" role="status" {}
        div.scroll tabindex="0" role="region" aria-label="Cells" { table id="batch-cells" {
            thead { tr {
                th.n scope="col" { "Cell" }
                @if stations.names.len() > 1 { th scope="col" { "Workstation" } }
                @for f in &varied { th scope="col" { (capital(&plan.factors[*f].name)) } }
                th.n scope="col" { "Rank" }
                th scope="col" { "Time at each action level" }
                th.n scope="col" { "Level 3+" span.small { "90 % band" } }
                th.n scope="col" { "Expected RULA" span.small { "90 % band" } }
                th.n scope="col" { "Expected REBA" span.small { "90 % band" } }
                th.n scope="col" { "Duration (s)" }
                th.n scope="col" { "Out of reach" }
                th scope="col" { "State" }
            } }
            tbody { @for k in 0..plan.cells.len() {
                @let record = &finished.records[k];
                @let row = finished.row(k);
                tr data-cell=(k) {
                    th.n scope="row" {
                        @if pages[k] { a href=(format!("cells/{}/report.html", plan.cells[k].short())) { (k + 1) } } @else { (k + 1) }
                    }
                    @if stations.names.len() > 1 { td { (stations.names[stations.of[k]]) } }
                    @for f in &varied { td { (plan.label(k, *f)) } }
                    td.n { @if let Some(rank) = stations.rank[k] { (rank) } @else { "–" } }
                    @if let Some(row) = row {
                        td { (bar_of_levels(row)) }
                        td.n { (share(row, "time_share_rula_ge_5")) span.small { (share(row, "time_share_rula_ge_5_p05")) " to " (share(row, "time_share_rula_ge_5_p95")) } }
                        td.n { (banded(row, "rula")) }
                        td.n { (banded(row, "reba")) }
                        td.n { (row.number("duration_s").map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"))) }
                        td.n { (share(row, "reach_exceeded_share")) }
                    } @else { td { "–" } td.n { "–" } td.n { "–" } td.n { "–" } td.n { "–" } td.n { "–" } }
                    td {
                        (state_words(record.state))
                        @if let Some(row) = row.filter(|r| r.text("status") == "over_a_limit") { span.small { (row.text("path")) " is over a limit" } }
                        @if let Some(reason) = &record.reason { span.small { (ticked(reason)) } }
                    }
                }
            } }
        } }
    }
}

fn banded(row: &PathRow, method: &str) -> Markup {
    let number = |what: &str| score(row.number(&format!("{method}_{what}")).unwrap_or(f64::NAN));
    html! { (number("expected")) span.small { (number("p05")) " to " (number("p95")) } }
}

fn state_words(state: CellState) -> &'static str {
    match state {
        CellState::Ok => "ok",
        CellState::NotSupported => "not supported by the recordings",
        CellState::NoFeasiblePath => "no feasible path",
        CellState::Failed => "failed",
    }
}

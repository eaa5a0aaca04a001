//! The drawings of `batch.html`: heat maps, risk against duration, and the data of its script.

use super::batch_page::{Stations, levels_in_words};
use super::comparison_page::{level_bar, whisker};
use super::panel::{number, ticks};
use super::style::{VERMILION, css, tint};
use crate::batch::{FactorKind, Finished, PathRow, Point};
use crate::words::number::percent;
use maud::{Markup, PreEscaped, html};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};

const SCRIPT: &str = include_str!("batch.js");
/// Stations that are drawn; the table has all.
const MOST_STATIONS: usize = 8;
/// The share at which the colour of a map is full.
const FULL: f64 = 0.85;

/// The bar of the action levels with its numbers.
pub(super) fn bar_of_levels(row: &PathRow) -> Markup {
    let share = |n: u8| row.number(&format!("time_share_rula_level_{n}")).unwrap_or(0.0);
    level_bar(share)
}

/// A mean with its interval.
pub(super) fn whisker_of([mean, low, high]: [f64; 3], widest: f64) -> Markup {
    whisker(mean, [low, high], widest)
}

/// The factors of the map without scripts: variants and fields before planners and seeds.
fn first_two(finished: &Finished) -> Vec<usize> {
    let plan = &finished.plan;
    let mut varied: Vec<usize> = plan
        .varied()
        .into_iter()
        .filter(|f| plan.factors[*f].kind != FactorKind::Scenario)
        .collect();
    varied.sort_by_key(|f| match plan.factors[*f].kind {
        FactorKind::Variant => 0,
        FactorKind::Field => 1,
        _ => 2,
    });
    varied.truncate(2);
    varied
}

/// One map for each station.
pub(super) fn heat_maps(finished: &Finished, stations: &Stations) -> Markup {
    let shown = first_two(finished);
    html! {
        p.note {
            "Share of the time at RULA action level 3 or above, of the body that is worst in each cell; a mean where several cells \
             stand behind a field, with their number. The darker, the more. Other factors may hide behind a mean: filter the cells below, and the map follows."
        }
        div.controls.scripted id="batch-map-controls" {}
        div id="batch-maps" {
            @for station in stations.numbers().take(MOST_STATIONS) {
                h3 { (stations.names[station]) }
                (heat_map(finished, stations, station, &shown))
            }
        }
    }
}

fn heat_map(finished: &Finished, stations: &Stations, station: usize, shown: &[usize]) -> Markup {
    let plan = &finished.plan;
    let (down, across) = (shown.first().copied(), shown.get(1).copied());
    let mut fields: BTreeMap<[Option<usize>; 2], Vec<usize>> = BTreeMap::new();
    for k in (0..plan.cells.len()).filter(|k| stations.of[*k] == station) {
        let place = [down, across].map(|f| f.map(|f| plan.cells[k].levels[f]));
        fields.entry(place).or_default().push(k);
    }
    // Those of the station, in the order of the batch file.
    let used = |side: usize| fields.keys().map(|at| at[side]).collect::<BTreeSet<_>>();
    let label = |f: Option<usize>, l: Option<usize>| match f.zip(l) {
        Some((f, l)) => plan.factors[f].levels[l].clone(),
        None => "all cells".to_owned(),
    };
    let title = |f: Option<usize>| f.map_or("", |f| plan.factors[f].name.as_str());
    html! {
        div.scroll tabindex="0" role="region" aria-label="Map of two factors" { table.map {
            thead { tr {
                th scope="col" { (title(down)) @if across.is_some() { " \u{2193}, " (title(across)) " \u{2192}" } }
                @for l in used(1) { th.n scope="col" { (label(across, l)) } }
            } }
            tbody { @for d in used(0) { tr {
                th scope="row" { (label(down, d)) }
                @for a in used(1) { (field(finished, fields.get(&[d, a]).map_or(&[], Vec::as_slice))) }
            } } }
        } }
    }
}

/// One field of a map: the mean over its cells.
fn field(finished: &Finished, cells: &[usize]) -> Markup {
    let values: Vec<f64> =
        cells.iter().filter_map(|k| finished.row(*k)?.number("time_share_rula_ge_5")).collect();
    if values.is_empty() {
        return html! { td.n { @if cells.is_empty() { "–" } @else { "no path" } } };
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let color = css(tint(VERMILION, FULL * mean.clamp(0.0, 1.0)));
    html! {
        td.n style={ "background:" (color) } {
            (percent(mean))
            @if cells.len() > 1 { span.small { "of " (values.len()) " cells" @if values.len() < cells.len() { ", " (cells.len() - values.len()) " without a path" } } }
        }
    }
}

/// Risk against duration, a drawing for each station.
pub(super) fn pareto(finished: &Finished, stations: &Stations, points: &[Point]) -> Markup {
    html! {
        p.note {
            "Each point is a cell: its duration, and the share of the time at RULA action level 3 or above, of its worst body. Full points, with the \
             number of the cell: no other cell of the workstation is better in one and as good in the other. The mean shares of neighbours may differ \
             by chance alone."
        }
        @for station in stations.numbers().take(MOST_STATIONS) {
            @let own: Vec<&Point> = points.iter().filter(|p| p.station == station).collect();
            @if !own.is_empty() {
                h3 { (stations.names[station]) }
                (drawing(&own))
                ul { @for p in own.iter().filter(|p| p.is_on_front).take(10) { li {
                    "Cell " (p.cell + 1) ": " (levels_in_words(finished, p.cell)) ": " (percent(p.risk)) " in " (format!("{:.2}", p.duration_s)) " s"
                } } }
            }
        }
    }
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 64.0;
const BOTTOM: f64 = 48.0;

fn drawing(points: &[&Point]) -> Markup {
    let all = |pick: fn(&Point) -> f64| points.iter().map(move |p| pick(p));
    let (low, high) = all(|p| p.duration_s)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let room = (0.1 * (high - low)).max(0.25);
    let (low, high) = ((low - room).max(0.0), high + room);
    let x = |v: f64| LEFT + (WIDTH - LEFT - 20.0) * (v - low) / (high - low);
    let y = |v: f64| 14.0 + (HEIGHT - BOTTOM - 14.0) * (1.0 - v);
    let at = |v: f64| format!("{v:.1}");
    html! {
        svg width="100%" viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) style="max-width:760px" role="img"
            aria-label="Duration and share of the time at action level 3 or above of every cell." font-size="13" {
            @for t in ticks((0.0, 1.0), 4) {
                line x1=(at(LEFT)) x2=(at(WIDTH - 20.0)) y1=(at(y(t))) y2=(at(y(t))) stroke="#dee2e8" {}
                text x=(at(LEFT - 8.0)) y=(at(y(t) + 4.0)) text-anchor="end" { (percent(t)) }
            }
            @for t in ticks((low, high), 8) {
                line x1=(at(x(t))) x2=(at(x(t))) y1=(at(y(0.0))) y2=(at(y(0.0) + 5.0)) stroke="#545e6e" {}
                text x=(at(x(t))) y=(at(y(0.0) + 20.0)) text-anchor="middle" { (number(t)) }
            }
            text x=(at(0.5 * (LEFT + WIDTH))) y=(at(HEIGHT - 8.0)) text-anchor="middle" { "duration (s)" }
            @for p in points {
                circle cx=(at(x(p.duration_s))) cy=(at(y(p.risk))) r="5" stroke="#005a8c" stroke-width="1.5"
                    fill=(if p.is_on_front { "#005a8c" } else { "none" }) {}
                @if p.is_on_front { text x=(at(x(p.duration_s) + 9.0)) y=(at(y(p.risk) + 4.0)) { (p.cell + 1) } }
            }
        }
    }
}

/// Data and script: filters of the cells, and maps of chosen factors.
pub(super) fn scripts(finished: &Finished, stations: &Stations) -> Markup {
    let plan = &finished.plan;
    let factors: Vec<_> = plan
        .varied()
        .into_iter()
        .map(|f| {
            json!({ "index": f, "name": plan.factors[f].name, "levels": plan.factors[f].levels,
            "is_scenario": plan.factors[f].kind == FactorKind::Scenario })
        })
        .collect();
    let number = |row: Option<&PathRow>, name: &str| row.and_then(|r| r.number(name));
    let cells: Vec<_> = (0..plan.cells.len())
        .map(|k| {
            let row = finished.row(k);
            json!({ "levels": plan.cells[k].levels, "station": stations.of[k], "state": finished.records[k].state.name(),
                "values": [number(row, "time_share_rula_ge_5"), number(row, "p_rula_ge_5"), number(row, "rula_expected"),
                    number(row, "reba_expected"), number(row, "reach_exceeded_share")] })
        })
        .collect();
    // Of each measure: its name, whether it is a share, and the values from white to the full colour.
    let measures = json!([
        ["Time at RULA action level 3 or above", true, 0, 1],
        ["Repetitions with half a second there", true, 0, 1],
        ["Expected RULA", false, 1, 7],
        ["Expected REBA", false, 1, 11],
        ["Out of reach", true, 0, 1],
    ]);
    let data = json!({ "factors": factors, "cells": cells, "stations": stations.names, "measures": measures,
        "shown": first_two(finished), "full": css(tint(VERMILION, FULL)) });
    // No text of the data may end the element.
    let data = data.to_string().replace('<', "\\u003c");
    html! {
        script type="application/json" id="batch-data" { (PreEscaped(data)) }
        script { (PreEscaped(SCRIPT)) }
    }
}

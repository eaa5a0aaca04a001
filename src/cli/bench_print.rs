//! What `ergopath bench` prints and draws.

use crate::ergobench::{Cell, Gain, Question, Row, Table};
use crate::files::InputError;
use crate::report::{ForestPanel, ForestRow, forest_plots};
use comfy_table::{CellAlignment, presets};

/// The table in words.
pub(super) fn print(question: &Question, cells: &[Cell], table: &Table) {
    say!(
        "ErgoBench, seed {}: {} cells, planner `{}`, each path walked {} times by a simulated person whose\n\
         true behaviour the planner knows from {} other movements only. Nobody was recorded.",
        question.seed,
        cells.len(),
        question.preset.name,
        question.repetitions,
        question.demonstrations
    );
    let planners: Vec<&str> =
        table.all().map_or_else(Vec::new, |r| r.expected.iter().map(|e| e.0.as_str()).collect());
    say!("\nExpected RULA under the truth (means over cells)");
    scores(table, &planners, |r| &r.expected);
    say!("\nCVaR90: mean RULA of the worst tenth of repetitions under the truth");
    scores(table, &planners, |r| &r.cvar90);
    say!(
        "\nGain of ergopath over the others, points of expected RULA [95 % interval over repetitions]"
    );
    let others: Vec<&str> =
        planners.iter().copied().filter(|p| !["ergopath", "oracle"].contains(p)).collect();
    gains(table, &others);
    tails(table, &others);
    if let Some(gap) = table.all().and_then(|all| all.calibration_gap) {
        say!("\nTruth minus prediction of our paths' expected RULA: {gap:+.2} on average.");
        say!("The intervals take workstations and people as they are; other draws may differ.");
    }
    for c in cells.iter().filter(|c| c.failure.is_some()) {
        let why = c.failure.as_deref().unwrap_or_default();
        say!("  no path: {} ({}, {}): {why}", c.station, c.body, c.kind.name());
    }
}

/// One figure of all planners, a line for each row.
fn scores(table: &Table, planners: &[&str], pick: fn(&Row) -> &Vec<(String, f64)>) {
    let mut shown = comfy_table::Table::new();
    shown.load_style(presets::NOTHING);
    let header = ["", "cells"].into_iter().map(str::to_owned);
    shown.set_header(header.chain(planners.iter().map(|p| short(p))));
    for row in &table.rows {
        let mut line = vec![name(row), count(row)];
        line.extend(planners.iter().map(|p| value(pick(row), p)));
        shown.add_row(line);
    }
    right(&mut shown, 1);
    say!("{}", shown.trim_fmt());
}

fn gains(table: &Table, others: &[&str]) {
    let mut shown = comfy_table::Table::new();
    shown.load_style(presets::NOTHING);
    let header = [String::new()].into_iter().chain(others.iter().map(|p| short(p)));
    shown.set_header(header.chain(["of oracle's gain".to_owned(), "oracle gains".to_owned()]));
    for row in &table.rows {
        let mut line = vec![name(row)];
        line.extend(others.iter().map(|p| interval(&row.gains, p)));
        line.push(row.share_of_oracle.map_or_else(String::new, |s| {
            format!("{:.0} % [{:.0}, {:.0}]", 100.0 * s.mean, 100.0 * s.low95, 100.0 * s.high95)
        }));
        line.push(row.oracle_gain.map_or_else(String::new, |g| format!("{:.1} %", 100.0 * g)));
        shown.add_row(line);
    }
    right(&mut shown, 1);
    say!("{}", shown.trim_fmt());
}

fn tails(table: &Table, others: &[&str]) {
    let Some(all) = table.all() else { return };
    let of = |p: &&str| format!("{} {}", short(p), interval(&all.cvar90_gains, p));
    let told: Vec<String> = others.iter().map(of).collect();
    say!("\nGain in CVaR90, all cells [95 %, resampled]: {}", told.join("; "));
}

fn interval(gains: &[(String, Gain)], planner: &str) -> String {
    let found = gains.iter().find(|g| g.0 == planner);
    found.map_or_else(String::new, |(_, g)| {
        format!("{:+.2} [{:+.2}, {:+.2}]", g.mean, g.low95, g.high95)
    })
}

/// Gains over each baseline, and shares of the oracle's gain, as PNG by name.
pub(super) fn figures(table: &Table) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
    let fault = |e: crate::report::ReportError| InputError::fault("figure", e.to_string());
    let ends = |g: &Gain| [g.mean, g.low95, g.high95];
    let rows = |of: &dyn Fn(&Row) -> Option<[f64; 3]>, with_kinds: bool| -> Vec<ForestRow> {
        let is_shown = |r: &&Row| with_kinds || r.kind.is_none();
        let row = |r: &Row| ForestRow {
            label: name(r),
            value: of(r),
            is_total: r.family.is_none() && r.kind.is_none(),
        };
        table.rows.iter().filter(is_shown).map(row).collect()
    };
    let others = table.all().map_or_else(Vec::new, |r| r.gains.clone());
    let panels: Vec<ForestPanel> = others
        .iter()
        .filter(|(p, _)| p != "oracle")
        .map(|(p, _)| ForestPanel {
            title: format!("over: {}", short(p)),
            axis: "gain, points of expected RULA".to_owned(),
            reference: 0.0,
            rows: rows(&|r| r.gains.iter().find(|g| g.0 == *p).map(|g| ends(&g.1)), false),
        })
        .collect();
    let share = ForestPanel {
        title: "share of the oracle's gain".to_owned(),
        axis: "% of the gain over the straight path".to_owned(),
        reference: 100.0,
        rows: rows(&|r| r.share_of_oracle.as_ref().map(|g| ends(g).map(|v| 100.0 * v)), true),
    };
    let key = "simulated people; dot: mean over cells; bar: 95 % interval over repetitions";
    Ok(vec![
        ("gains.png", forest_plots(&panels, key).map_err(fault)?),
        ("oracle_share.png", forest_plots(&[share], key).map_err(fault)?),
    ])
}

fn short(planner: &str) -> String {
    match planner {
        "expert_arc" => "expert".to_owned(),
        "best_random" => "random".to_owned(),
        "single_posture_plain" => "one plain".to_owned(),
        "single_posture_learned" => "one learned".to_owned(),
        other => other.to_owned(),
    }
}

fn name(row: &Row) -> String {
    match (row.family, row.kind) {
        (Some(family), _) => family.name().to_owned(),
        (None, Some(kind)) => format!("person: {}", kind.name()),
        (None, None) => "all".to_owned(),
    }
}

fn count(row: &Row) -> String {
    match row.cells {
        (done, 0) => done.to_string(),
        (done, failed) => format!("{done} + {failed} failed"),
    }
}

fn value(all: &[(String, f64)], planner: &str) -> String {
    all.iter().find(|v| v.0 == planner).map_or_else(String::new, |v| format!("{:.2}", v.1))
}

fn right(table: &mut comfy_table::Table, from: usize) {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

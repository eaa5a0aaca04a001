//! What `ergopath bench` prints.

use crate::ergobench::{
    Cell, Gain, Kind, MISJUDGED, OURS, OUT_OF_REACH, PACED, Question, Row, Table, Weak,
};
use crate::math::stats::mean;
use comfy_table::{CellAlignment, presets};

/// Cells that fail and are named on the terminal; all of them are in result.json.
const NAMED: usize = 8;

/// The table in words.
pub(super) fn print(question: &Question, cells: &[Cell], table: &Table) {
    say!(
        "ErgoBench, seed {}: {} cells, planner `{}`. A cell is a workstation, a body and a simulated person;\n\
         the planner knows the person from {} other movements only, and every path is then scored on {}\n\
         repetitions by the person themselves (\"true\" scores). No real person was recorded.",
        question.seed,
        cells.len(),
        question.preset.name,
        question.demonstrations,
        question.repetitions,
    );
    people(cells);
    let planners: Vec<&str> =
        table.all().map_or_else(Vec::new, |r| r.expected.iter().map(|e| e.0.as_str()).collect());
    say!("\nTrue expected RULA, mean over cells (lower is better)");
    scores(table, &planners, |r| &r.expected);
    say!("\nTrue CVaR90: mean RULA of the worst tenth of repetitions");
    scores(table, &planners, |r| &r.cvar90);
    say!(
        "\nHow much lower ergopath's true expected RULA is than each other planner's [95 % interval]"
    );
    let others: Vec<&str> =
        planners.iter().copied().filter(|p| ![OURS, "oracle"].contains(p)).collect();
    gains(table, &others);
    tails(table, &others);
    say!(
        "\nIntervals hold for other workstations and people drawn in the same way: whole cells are drawn\n\
         again, and repetitions within them. A row has as many independent values as it has cells; below\n\
         about 10 cells its interval is rough, and a single cell has none."
    );
    weaknesses(table);
    for c in cells.iter().filter(|c| c.failure.is_some()) {
        let why = c.failure.as_deref().unwrap_or_default();
        say!("  no path: {} ({}, {}): {why}", c.station, c.body, c.kind.name());
    }
}

/// How each kind of person moves, beside recorded people.
fn people(cells: &[Cell]) {
    let mut shown = comfy_table::Table::new();
    shown.load_style(presets::NOTHING);
    shown.set_header(["", "cells", "participation rank", "rms joint speed"]);
    for (kind, is_whole) in [false, true].into_iter().flat_map(|w| Kind::ALL.map(|k| (k, w))) {
        let own = cells.iter().filter(|c| c.kind == kind && c.family.is_whole() == is_whole);
        let own: Vec<_> = own.filter_map(|c| c.demonstrated).collect();
        if own.is_empty() {
            continue;
        }
        let rank = mean(&own.iter().map(|d| d.participation_rank).collect::<Vec<_>>());
        let speed = mean(&own.iter().map(|d| d.joint_speed_deg_s).collect::<Vec<_>>());
        let count = own.len().to_string();
        let (rank, speed) = (format!("{rank:.1}"), format!("{speed:.0} deg/s"));
        let name = if is_whole { "whole, " } else { "" }.to_owned() + kind.name();
        shown.add_row([name, count, rank, speed]);
    }
    right(&mut shown, 1);
    say!(
        "\nPeople: joint velocities in their demonstrations (recorded arms: 3.0 to 3.2, 18 to 25 deg/s; of whole\n\
         people with the pelvis, a leg length counting like a radian)"
    );
    say!("{}", shown.trim_fmt());
}

/// Where our path is worse than the straight one, cannot be followed, or was misjudged.
fn weaknesses(table: &Table) {
    let Some(all) = table.all() else { return };
    say!("\nWhere it fails");
    if let Some(gap) = &all.calibration_gap {
        say!(
            "  True minus predicted expected RULA of ergopath's paths: {} on average.",
            with_interval(gap)
        );
    }
    reliability(table);
    let share = 100.0 * all.out_of_reach.unwrap_or(0.0);
    say!(
        "  The hand cannot follow ergopath's path to its end in {share:.1} % of the repetitions.\n  \
         Worse than the straight path in {} of {} cells.",
        all.worse_than_straight,
        all.cells.0
    );
    if table.failures.is_empty() {
        say!(
            "  No cell is worse than the straight path, predicted wrong by more than {MISJUDGED}, or out of\n  \
             reach in more than {:.0} % of the repetitions.",
            100.0 * OUT_OF_REACH
        );
        return;
    }
    let mut shown = comfy_table::Table::new();
    shown.load_style(presets::NOTHING);
    shown.set_header([
        "workstation",
        "body",
        "person",
        "predicted",
        "true",
        "straight, true",
        "out of reach",
        "",
    ]);
    for w in table.failures.iter().take(NAMED) {
        shown.add_row([
            w.station.clone(),
            w.body.clone(),
            w.kind.name().to_owned(),
            format!("{:.2}", w.predicted),
            format!("{:.2}", w.truth),
            format!("{:.2}", w.straight),
            format!("{:.0} %", 100.0 * w.out_of_reach),
            reasons(w),
        ]);
    }
    for column in shown.column_iter_mut().skip(3).take(4) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{}", shown.trim_fmt());
    let more = table.failures.len().saturating_sub(NAMED);
    if more > 0 {
        say!("  and {more} more, in result.json");
    }
}

/// "1 cell", "2 cells".
fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Whether the risk that plans predict is the true one.
fn reliability(table: &Table) {
    let percent = |v: f64| format!("{:.0} %", 100.0 * v);
    for b in &table.reliability {
        let ends = match (b.truth.low95, b.truth.high95) {
            (Some(low), Some(high)) => format!(" [{} to {}]", percent(low), percent(high)),
            _ => String::new(),
        };
        say!(
            "  Time at RULA 5 or more: predicted {}, true {}{ends}; {} in {}.",
            percent(b.predicted),
            percent(b.truth.mean),
            counted(b.paths, "path"),
            counted(b.truth.cells, "cell")
        );
    }
}

fn reasons(w: &Weak) -> String {
    let mut all = Vec::new();
    if w.is_worse_than_straight() {
        all.push("worse than straight");
    }
    if w.out_of_reach > OUT_OF_REACH {
        all.push("out of reach");
    }
    if w.truth - w.predicted > MISJUDGED {
        all.push("predicted too low");
    }
    if w.predicted - w.truth > MISJUDGED {
        all.push("predicted too high");
    }
    all.join(", ")
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
    let header =
        ["", "cells"].into_iter().map(str::to_owned).chain(others.iter().map(|p| short(p)));
    shown.set_header(
        header.chain(["share of oracle's gain".to_owned(), "oracle's gain".to_owned()]),
    );
    for row in &table.rows {
        let mut line = vec![name(row), row.cells.0.to_string()];
        line.extend(others.iter().map(|p| interval(&row.gains, p)));
        line.push(row.share_of_oracle.map_or_else(String::new, |s| percent(&s)));
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
    say!("\nThe same for CVaR90, all cells: {}", told.join("; "));
}

fn interval(gains: &[(String, Gain)], planner: &str) -> String {
    let found = gains.iter().find(|g| g.0 == planner);
    found.map_or_else(String::new, |(_, g)| with_interval(g))
}

fn with_interval(g: &Gain) -> String {
    match (g.low95, g.high95) {
        (Some(low), Some(high)) => format!("{:+.2} [{low:+.2}, {high:+.2}]", g.mean),
        _ => format!("{:+.2}", g.mean),
    }
}

fn percent(g: &Gain) -> String {
    match (g.low95, g.high95) {
        (Some(low), Some(high)) => {
            format!("{:.0} % [{:.0}, {:.0}]", 100.0 * g.mean, 100.0 * low, 100.0 * high)
        }
        _ => format!("{:.0} %", 100.0 * g.mean),
    }
}

pub(super) fn short(planner: &str) -> String {
    match planner {
        PACED => "pace free".to_owned(),
        "expert_arc" => "expert".to_owned(),
        "best_random" => "random".to_owned(),
        "single_posture_plain" => "single plain".to_owned(),
        "single_posture_learned" => "single learned".to_owned(),
        other => other.to_owned(),
    }
}

pub(super) fn name(row: &Row) -> String {
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

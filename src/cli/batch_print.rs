//! What a batch found, in short on the terminal, and the gate as `JUnit` XML.

use super::batch_file::Shard;
use crate::batch::{CellState, Finished, GateRow, Kept};
use crate::words::number::percent;
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::path::Path;

/// Cells and stations that are named on the terminal; the files name all.
const MOST_SHOWN: usize = 10;

/// Counts, the best cell of each station, and where the rest is.
pub(super) fn print(finished: &Finished, gate: Option<&[GateRow]>, folder: &Path) {
    let count = |state: CellState| finished.records.iter().filter(|r| r.state == state).count();
    let states = [
        (CellState::Ok, "with a path"),
        (CellState::NotSupported, "not supported by the recordings"),
        (CellState::NoFeasiblePath, "without a feasible path"),
        (CellState::Failed, "failed"),
    ];
    let parts: Vec<String> = states
        .iter()
        .filter(|(s, _)| *s == CellState::Ok || count(*s) > 0)
        .map(|(s, words)| format!("{} {words}", count(*s)))
        .collect();
    say!("{} cells: {}", finished.records.len(), parts.join(", "));
    best(finished);
    let failed =
        || finished.records.iter().enumerate().filter(|(_, r)| r.state == CellState::Failed);
    for (k, record) in failed().take(MOST_SHOWN) {
        say!(
            "  failed: {}: {}",
            name(finished, k),
            record.reason.as_deref().unwrap_or("no reason")
        );
    }
    let more = failed().count().saturating_sub(MOST_SHOWN);
    if more > 0 {
        say!("  and {more} more failed: cells.csv");
    }
    if let Some(rows) = gate {
        let broken: Vec<&GateRow> = rows.iter().filter(|r| !r.broken.is_empty()).collect();
        say!("Gate: kept by {} of {}", rows.len() - broken.len(), rows.len());
        for row in broken.iter().take(MOST_SHOWN) {
            say!("  {}: {}", case(finished, row), in_words(row));
        }
        if broken.len() > MOST_SHOWN {
            say!("  and {} more: {}", broken.len() - MOST_SHOWN, folder.join("gate.xml").display());
        }
    }
    say!("\n{}", folder.join("batch.html").display());
}

/// Of each station the cell with the smallest share of time at action level 3 or above.
fn best(finished: &Finished) {
    let mut best: Vec<Option<(f64, usize)>> = vec![None; finished.plan.stations.len()];
    for (k, cell) in finished.plan.cells.iter().enumerate() {
        let share = finished.row(k).and_then(|r| r.number("time_share_rula_ge_5"));
        if let Some(share) = share
            && best[cell.station].is_none_or(|(least, _)| share < least)
        {
            best[cell.station] = Some((share, k));
        }
    }
    for (least, k) in best.iter().flatten().copied().take(MOST_SHOWN) {
        let Some(row) = finished.row(k) else { continue };
        let band = |end: &str| row.number(end).map_or_else(|| "unknown".to_owned(), percent);
        say!(
            "  {}: least time at RULA action level 3 or above in {}: {} (90 % of repetitions: {} to {})",
            row.text("station"),
            name(finished, k),
            percent(least),
            band("time_share_rula_ge_5_p05"),
            band("time_share_rula_ge_5_p95")
        );
    }
    let more = best.iter().flatten().count().saturating_sub(MOST_SHOWN);
    if more > 0 {
        say!("  and {more} more workstations: batch.html");
    }
}

/// A cell by the levels of what varies.
fn name(finished: &Finished, cell: usize) -> String {
    let plan = &finished.plan;
    let each = plan.varied().into_iter();
    let parts: Vec<String> =
        each.map(|f| format!("{} {}", plan.factors[f].name, plan.label(cell, f))).collect();
    format!("cell {} ({})", cell + 1, parts.join(", "))
}

fn case(finished: &Finished, row: &GateRow) -> String {
    let of = row.of.as_ref().map_or_else(String::new, |(body, path)| format!(", {body} on {path}"));
    format!("{}{of}", name(finished, row.cell))
}

fn in_words(row: &GateRow) -> String {
    let one = |kept: &Kept| match kept {
        Kept::Yes => None,
        Kept::No { bound, value } => Some(format!("{bound} is not kept: {value}")),
        Kept::Unknown { bound: Some(bound) } => {
            Some(format!("{bound} is not checked: there is no value"))
        }
        Kept::Unknown { bound: None } => {
            Some("not checked: the cell has no path that may be used".to_owned())
        }
    };
    row.broken.iter().filter_map(one).collect::<Vec<_>>().join("; ")
}

/// A share of the cells is done.
pub(super) fn print_shard(shard: Shard, cells: usize, failed: usize, folder: &Path) {
    say!("shard {}/{}: {cells} cells, {failed} failed", shard.number, shard.of);
    say!("when all shards are done: ergopath batch --merge {}", folder.display());
}

/// The gate as `JUnit` XML: a test for each body of each cell. It holds no time and no place.
pub(super) fn junit(finished: &Finished, rows: &[GateRow]) -> Result<Vec<u8>, String> {
    let mut suite = TestSuite::new("gate");
    for row in rows {
        let status = if row.broken.is_empty() {
            TestCaseStatus::success()
        } else {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(in_words(row));
            status
        };
        let mut test = TestCase::new(case(finished, row), status);
        test.set_classname(finished.plan.name.as_str());
        suite.add_test_case(test);
    }
    let mut report = Report::new(finished.plan.name.as_str());
    report.add_test_suite(suite);
    report.to_string().map(String::into_bytes).map_err(|e| e.to_string())
}

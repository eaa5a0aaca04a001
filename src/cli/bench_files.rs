//! Files of `ergopath bench`: cells and gains as CSV, and the figures.

use super::bench_print::{name, short};
use crate::ergobench::{Cell, Gain, Row, Table};
use crate::files::InputError;
use crate::report::{ForestPanel, ForestRow, ReliabilityPoint, forest_plots, reliability_curve};

/// Every planner's figures in every cell.
pub(super) fn cells_csv(cells: &[Cell]) -> Result<Vec<u8>, InputError> {
    let header = [
        "station",
        "family",
        "body",
        "person",
        "planner",
        "expected_rula",
        "cvar90_rula",
        "exposure_rula_5",
        "expected_reba",
        "reach_exceeded",
        "predicted_rula",
        "predicted_exposure_rula_5",
        "demonstrated_participation_rank",
        "demonstrated_joint_speed_deg_s",
    ];
    let mut rows = Vec::new();
    for c in cells {
        let shown = c.demonstrated.map(|d| [d.participation_rank, d.joint_speed_deg_s]);
        for o in &c.outcomes {
            let mut row = vec![
                c.station.clone(),
                c.family.name().to_owned(),
                c.body.clone(),
                c.kind.name().to_owned(),
                o.planner.clone(),
            ];
            let figures = [
                o.expected_rula,
                o.cvar90_rula,
                o.exposure_rula_5,
                o.expected_reba,
                o.reach_exceeded,
            ];
            row.extend(figures.map(|v| v.to_string()));
            row.extend([number(o.predicted_rula), number(o.predicted_exposure_rula_5)]);
            row.extend([number(shown.map(|s| s[0])), number(shown.map(|s| s[1]))]);
            rows.push(row);
        }
    }
    csv_of("cells.csv", &header, rows)
}

/// Every gain with its interval: one line for each line and column of the table.
pub(super) fn gains_csv(table: &Table) -> Result<Vec<u8>, InputError> {
    let header = ["row", "figure", "against", "cells", "value", "low95", "high95"];
    let mut rows = Vec::new();
    for r in &table.rows {
        let mut add = |figure: &str, against: &str, g: &Gain| {
            rows.push(vec![
                name(r),
                figure.to_owned(),
                against.to_owned(),
                g.cells.to_string(),
                g.mean.to_string(),
                number(g.low95),
                number(g.high95),
            ]);
        };
        for (planner, g) in &r.gains {
            add("gain_expected_rula", planner, g);
        }
        for (planner, g) in &r.cvar90_gains {
            add("gain_cvar90_rula", planner, g);
        }
        if let Some(g) = &r.share_of_oracle {
            add("share_of_oracle_gain", "oracle", g);
        }
        if let Some(g) = &r.calibration_gap {
            add("truth_minus_prediction", "prediction", g);
        }
    }
    csv_of("gains.csv", &header, rows)
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn csv_of(file: &str, header: &[&str], rows: Vec<Vec<String>>) -> Result<Vec<u8>, InputError> {
    let fault = |e: String| InputError::fault(file, e);
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(header).map_err(|e| fault(e.to_string()))?;
    for row in rows {
        table.write_record(row).map_err(|e| fault(e.to_string()))?;
    }
    table.into_inner().map_err(|e| fault(e.to_string()))
}

/// Gains over each baseline, and shares of the oracle's gain, as PNG by name.
pub(super) fn figures(table: &Table) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
    let fault = |e: crate::report::ReportError| InputError::fault("figure", e.to_string());
    // A single cell has no interval: a dot alone.
    let ends = |g: &Gain| [g.mean, g.low95.unwrap_or(g.mean), g.high95.unwrap_or(g.mean)];
    let rows = |of: &dyn Fn(&Row) -> Option<[f64; 3]>, with_kinds: bool| -> Vec<ForestRow> {
        let is_shown = |r: &&Row| with_kinds || r.kind.is_none();
        let row = |r: &Row| ForestRow {
            label: name(r).split(" (").next().unwrap_or_default().to_owned(),
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
    let key = "simulated people; dot: mean over cells; bar: 95 % interval by cells";
    let points: Vec<ReliabilityPoint> = table
        .reliability
        .iter()
        .map(|b| ReliabilityPoint {
            predicted: b.predicted,
            observed: ends(&b.truth),
            paths: b.paths,
        })
        .collect();
    let title = "Time at RULA 5 or more: predicted, and true";
    let of =
        "dot: paths of about the same prediction, with their number; bar: 95 % interval by cells";
    Ok(vec![
        ("reliability.png", reliability_curve(&points, title, of).map_err(fault)?),
        ("gains.png", forest_plots(&panels, key).map_err(fault)?),
        ("oracle_share.png", forest_plots(&[share], key).map_err(fault)?),
    ])
}

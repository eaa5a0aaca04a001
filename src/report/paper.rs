//! The files of the paper's experiments: tables, figures and JSON.

use super::ReportError;
use super::figure_box::{BoxPanel, box_plots};
use crate::training::paper::{ChainResult, MovementScore, PaperResult};

const COLUMNS: [&str; 14] = [
    "person",
    "task",
    "method",
    "movement",
    "frames",
    "ll_q_nats",
    "ll_null_nats",
    "rmse_q_rad_s",
    "relative_rmse_q",
    "ll_x_nats",
    "rmse_x_m_s",
    "inside_50",
    "inside_90",
    "taught_by_movements",
];

/// Tables, figures and `<experiment>.json`, as (name, bytes).
///
/// # Errors
/// Where a file cannot be made.
pub fn paper_files(result: &PaperResult) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let name = result.experiment.name();
    let json = serde_json::to_string_pretty(result)? + "\n";
    let mut files = vec![(format!("{name}.json"), json.into_bytes())];
    for chain in &result.chains {
        let key = chain.chain.name();
        let said = |bytes: Vec<u8>| told(result.simulated, bytes);
        files.push((format!("{key}/scores.csv"), said(scores(chain)?)));
        files.push((format!("{key}/weights.csv"), said(weights(chain)?)));
        files.push((format!("{key}/horizon.csv"), said(horizon(chain)?)));
        files.push((format!("{key}/methods.png"), box_plots(&panels(chain))?));
    }
    Ok(files)
}

/// Whoever reads a table of simulated people is told.
fn told(simulated: bool, table: Vec<u8>) -> Vec<u8> {
    let mark: &[u8] = if simulated { b"# simulated people: nobody was recorded\n" } else { b"" };
    [mark, &table].concat()
}

/// The four panels of the paper's figure, over held-out movements, and the relative error.
fn panels(chain: &ChainResult) -> Vec<BoxPanel> {
    let panel = |title: &str, unit: &str, is_error: bool, pick: fn(&MovementScore) -> f64| {
        let of = |m: usize| {
            let movements = chain.sets.iter().flat_map(|s| &s.methods[m].movements);
            movements.map(pick).collect::<Vec<f64>>()
        };
        let methods = chain.methods.iter().enumerate();
        BoxPanel {
            title: title.to_owned(),
            unit: unit.to_owned(),
            is_error,
            methods: methods.map(|(m, s)| (s.method.name().to_owned(), of(m))).collect(),
        }
    };
    vec![
        panel("Log-likelihood of the joint velocity", "nats per frame", false, |s| s.ll_q),
        panel("RMSE of the joint velocity, relative", "over its rms", true, |s| s.relative_rmse_q),
        panel("Log-likelihood of the task velocity", "nats per frame", false, |s| s.ll_x),
        panel("RMSE of the task velocity", "m/s, rad/s", true, |s| s.rmse_x),
    ]
}

fn finished(table: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, ReportError> {
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

/// A row for each method and held-out movement.
fn scores(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for set in &chain.sets {
        for own in &set.methods {
            for s in &own.movements {
                let numbers = [
                    s.ll_q,
                    s.ll_null,
                    s.rmse_q,
                    s.relative_rmse_q,
                    s.ll_x,
                    s.rmse_x,
                    s.velocity_coverage[0],
                    s.velocity_coverage[1],
                ];
                let mut row = vec![
                    set.who.clone(),
                    set.task.clone(),
                    own.method.name().to_owned(),
                    s.movement.clone(),
                    s.frames.to_string(),
                ];
                row.extend(numbers.iter().map(f64::to_string));
                row.push(set.train.movements.to_string());
                table.write_record(row)?;
            }
        }
    }
    finished(table)
}

/// The diagonal of W over its geometric mean: a row for each set and method, a column for each joint.
fn weights(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let joints = chain.joints.iter().map(String::as_str);
    table.write_record(["person", "task", "method"].into_iter().chain(joints))?;
    for set in &chain.sets {
        for own in &set.methods {
            let Some(weights) = &own.weights else { continue };
            let mut row = vec![set.who.clone(), set.task.clone(), own.method.name().to_owned()];
            row.extend(weights.iter().map(f64::to_string));
            table.write_record(row)?;
        }
    }
    finished(table)
}

fn horizon(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["method", "horizon_s", "movements", "hand_mm", "joints_deg"])?;
    for curve in &chain.horizon {
        for p in &curve.points {
            table.write_record([
                curve.method.to_owned(),
                p.horizon_s.to_string(),
                p.movements.to_string(),
                p.hand_mm.to_string(),
                p.joints_deg.to_string(),
            ])?;
        }
    }
    finished(table)
}

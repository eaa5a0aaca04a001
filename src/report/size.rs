//! The files of the experiment on the number of frames: table, figure and JSON.

use super::ReportError;
use super::figure_growth::{GrowthLine, GrowthNote, GrowthPoint, noted_growth_plot};
use crate::training::SizeExperiment;

const COLUMNS: [&str; 9] = [
    "samples",
    "method",
    "inducing_centres",
    "training_s",
    "prediction_us",
    "ll_nats_per_row",
    "rmse_rad_s",
    "relative_rmse",
    "peak_memory_mib",
];

/// `size.json`, `size.csv` and `size.png`, as (name, bytes).
///
/// # Errors
/// Where a file cannot be made.
pub fn size_files(result: &SizeExperiment) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let json = serde_json::to_string_pretty(result)? + "\n";
    Ok(vec![
        ("size.json".to_owned(), json.into_bytes()),
        ("size.csv".to_owned(), table(result)?),
        ("size.png".to_owned(), noted_growth_plot(&lines(result), &note(result))?),
    ])
}

/// One line for each method, in the order of the first N.
fn lines(result: &SizeExperiment) -> Vec<GrowthLine> {
    let mut lines: Vec<GrowthLine> = Vec::new();
    for row in &result.rows {
        let point =
            GrowthPoint { samples: row.samples, log_likelihood: row.ll_q, training_s: row.train_s };
        match lines.iter_mut().find(|l| l.method == row.method) {
            Some(line) => line.points.push(point),
            None => lines.push(GrowthLine { method: row.method.to_owned(), points: vec![point] }),
        }
    }
    lines
}

fn note(result: &SizeExperiment) -> GrowthNote {
    GrowthNote {
        text: format!(
            "Simulated operator: made-up reaches at {:.0} Hz, nobody was recorded. Judged on {} frames \
             that no law has seen.",
            result.rate_hz, result.test_frames
        ),
        exact_to: Some(result.exact_samples),
    }
}

fn table(result: &SizeExperiment) -> Result<Vec<u8>, ReportError> {
    let mut bytes = b"# simulated operator: nobody was recorded\n".to_vec();
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for r in &result.rows {
        table.write_record([
            r.samples.to_string(),
            r.method.to_owned(),
            r.centres.map_or_else(String::new, |c| c.to_string()),
            r.train_s.to_string(),
            (1e6 * r.predict_s).to_string(),
            r.ll_q.to_string(),
            r.rmse_q.to_string(),
            r.relative_rmse_q.to_string(),
            r.peak_mib.map_or_else(String::new, |m| m.to_string()),
        ])?;
    }
    bytes.extend(table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))?);
    Ok(bytes)
}

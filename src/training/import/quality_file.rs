//! `quality.csv` of an import: written, and read again beside its motions.

use super::{Import, Residuals, SegmentQuality};
use crate::files::{InputError, read_bytes};
use serde::Deserialize;
use std::path::Path;

/// Its name in the folder of an import.
pub const QUALITY_FILE: &str = "quality.csv";
/// Its columns: a constant part, and what it leaves.
const COLUMNS: [&str; 10] = [
    "motion",
    "file",
    "run",
    "segment",
    "constant_mm",
    "scatter_median_mm",
    "scatter_p95_mm",
    "constant_deg",
    "scatter_median_deg",
    "scatter_p95_deg",
];

/// A segment of a run of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityRow {
    /// File of the motion.
    pub motion: String,
    /// Name of the recording.
    pub file: String,
    /// Which run of it, from 1.
    pub run: usize,
    /// How near the body comes to it.
    pub quality: SegmentQuality,
}

/// A row as it stands in the file.
#[derive(Deserialize)]
struct Typed {
    motion: String,
    file: String,
    run: usize,
    segment: String,
    constant_mm: f64,
    scatter_median_mm: f64,
    scatter_p95_mm: f64,
    constant_deg: f64,
    scatter_median_deg: f64,
    scatter_p95_deg: f64,
}

impl Import {
    /// The quality of every segment of every run as CSV; `motions` names the file of each motion.
    ///
    /// # Errors
    /// Only where the table cannot be held in memory.
    pub fn quality_csv(&self, motions: &[String]) -> Result<Vec<u8>, InputError> {
        let fault = |e: String| InputError::fault(QUALITY_FILE, e);
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(COLUMNS).map_err(|e| fault(e.to_string()))?;
        for (file, motion) in self.files.iter().zip(motions) {
            for (i, run) in file.runs.iter().enumerate() {
                for segment in &run.segments {
                    let mut cells = vec![
                        motion.clone(),
                        file.name.clone(),
                        (i + 1).to_string(),
                        segment.segment.clone(),
                    ];
                    let [mm, deg] = [&segment.place_mm, &segment.turn_deg];
                    for part in [mm, deg] {
                        let figures = [part.constant, part.median, part.p95];
                        cells.extend(figures.map(|v| format!("{v:.6}")));
                    }
                    table.write_record(cells).map_err(|e| fault(e.to_string()))?;
                }
            }
        }
        table.into_inner().map_err(|e| fault(e.to_string()))
    }
}

/// The rows of a `quality.csv`.
///
/// # Errors
/// Where it cannot be read, or is no such table.
pub fn read_quality(path: &Path) -> Result<Vec<QualityRow>, InputError> {
    let bytes = read_bytes(path)?;
    let mut table = csv::Reader::from_reader(bytes.as_slice());
    let rows = table.deserialize().map(|row: Result<Typed, csv::Error>| {
        let row = row.map_err(|e| {
            let line = e.position().map_or(0, csv::Position::line);
            InputError::new(path, format!("line {line} is no row of the quality of an import: {e}"))
                .remedy("import the recordings again, into another folder")
        })?;
        let residuals = |constant, median, p95| Residuals { constant, median, p95 };
        Ok(QualityRow {
            motion: row.motion,
            file: row.file,
            run: row.run,
            quality: SegmentQuality {
                segment: row.segment,
                place_mm: residuals(row.constant_mm, row.scatter_median_mm, row.scatter_p95_mm),
                turn_deg: residuals(row.constant_deg, row.scatter_median_deg, row.scatter_p95_deg),
            },
        })
    });
    rows.collect()
}

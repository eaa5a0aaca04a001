//! `quality.csv` of an import: written, and read again beside its motions.

use super::{Import, Residuals, SegmentQuality};
use crate::files::{CsvText, InputError, read_bytes};
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
    let text = CsvText::of(path, &read_bytes(path)?)?;
    let mut reader = text.reader();
    let header = reader.headers().map_err(|e| text.broken(path, &e))?.clone();
    let again = "import the recordings again, into another folder";
    let mut places = [0; COLUMNS.len()];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        let found = header.iter().position(|h| h == name);
        *place = found.ok_or_else(|| {
            let message =
                format!("holds no row of the quality of an import: column `{name}` is missing");
            InputError::new(path, message).remedy(again)
        })?;
    }
    let rows = text.rows(path, &mut reader).map(|row| {
        let (line, record) = row?;
        let cell = |i: usize| record.get(places[i]).unwrap_or_default().to_owned();
        let unread = |i: usize| {
            let column = COLUMNS[i];
            let message = format!("line {line}, column `{column}`: `{}` is no number", cell(i));
            InputError::new(path, message).remedy(again)
        };
        let residuals = |first: usize| -> Result<Residuals, InputError> {
            let number = |i: usize| text.number(&cell(i)).ok_or_else(|| unread(i));
            let (constant, median, p95) = (number(first)?, number(first + 1)?, number(first + 2)?);
            Ok(Residuals { constant, median, p95 })
        };
        Ok(QualityRow {
            motion: cell(0),
            file: cell(1),
            run: cell(2).parse().map_err(|_| unread(2))?,
            quality: SegmentQuality {
                segment: cell(3),
                place_mm: residuals(4)?,
                turn_deg: residuals(7)?,
            },
        })
    });
    rows.collect()
}

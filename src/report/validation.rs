//! The files of a validation: page, pictures and figures.

use super::ReportError;
use super::figure_agreement::scores;
use super::figure_coverage::coverages;
use super::figure_movement::{movement, typical};
use super::validation_page::page;
use crate::training::people::LeftOut;

/// The pictures, PNG.
pub(super) struct Drawings {
    pub scores: Vec<u8>,
    pub coverage: Vec<u8>,
    /// None where no movement has repetitions.
    pub movement: Option<Vec<u8>>,
}

/// Page and pictures of people who were left out, or on whom a model (`judged`) was judged, as (name, bytes);
/// `remarks` go to the head of the page.
///
/// # Errors
/// Where a picture cannot be drawn.
pub fn validation_files(
    found: &LeftOut,
    judged: Option<&str>,
    remarks: &[String],
) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let drawings = Drawings {
        scores: scores(found)?,
        coverage: coverages(found)?,
        movement: typical(found).map(movement).transpose()?,
    };
    let html = page(found, judged, remarks, &drawings);
    let mut files = vec![("validation.html".to_owned(), html.into_bytes())];
    let Drawings { scores, coverage, movement } = drawings;
    let pictures = [("scores", Some(scores)), ("coverage", Some(coverage)), ("movement", movement)];
    for (name, png) in pictures {
        files.extend(png.map(|png| (format!("figures/{name}.png"), png)));
    }
    Ok(files)
}

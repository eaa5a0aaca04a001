//! The files of a run: everything the reader sees, made from one finished [`RunResult`].
//!
//! ```text
//! RunResult ─► view    which paths are shown, and in which words
//!           ─► tables  candidates.csv, paths/<rank>.csv;  with workbook   report.xlsx
//!           ─► figure_* on sheet, panel, style, mannequin   figures/*.png
//!           ─► figure_still on raster, solid   figures/still.png
//!           ─► page*   report.html, with scene.js and sort.js in it
//!           ─► one_page   one_page.html on page_decision
//! several RunResults ─► comparison (_table, _page, _figure)   comparison.csv, comparison.html
//! Finished (batch) ─► batch_page, batch_charts, with batch.js in it   batch.html
//! CellLook ─► figure_cell   the cell before planning, PNG
//! NamedGrip ─► figure_grips, figure_directions   how hands and tools are described, PNG
//! scores of methods over repeats ─► figure_box, figure_growth on value_axis   PNG
//! gains with their intervals     ─► figure_forest                             PNG
//! WeightSpread, HeldOutCurves ─► figure_weights, figure_held_out             PNG
//! MotionLook, SegmentQuality ─► figure_import   the picture of an import, PNG
//! a scored frame ─► filled, filled_page   worksheets/*.html, *.csv
//! LeftOut ─► validation, validation_page on figure_agreement, figure_coverage, figure_movement   page, PNG
//! SizeExperiment ─► size          size.png, size.csv, size.json
//! PathData, Robot ─► program   a path as a program for a controller
//! how a watched scenario stands ─► watch_page, with watch.js in it   the page of `watch` around report.html
//! PaperResult ─► paper, paper_page on figure_box, figure_horizon, figure_spread, figure_weight_sets   page, PNG, CSV, JSON
//! ```
//!
//! Bytes out, nothing else: no disk, no clock. The same result gives the same bytes.

mod batch_charts;
mod batch_page;
mod comparison;
mod comparison_figure;
mod comparison_page;
mod comparison_table;
#[cfg(test)]
mod drawn;
#[cfg(test)]
mod drawn_tests;
mod figure_agreement;
mod figure_box;
mod figure_cell;
mod figure_coverage;
mod figure_directions;
mod figure_forest;
mod figure_grips;
mod figure_growth;
mod figure_heat;
mod figure_held_out;
mod figure_horizon;
mod figure_import;
mod figure_movement;
mod figure_paths;
mod figure_population;
mod figure_postures;
mod figure_reliability;
mod figure_scores;
mod figure_spread;
mod figure_still;
mod figure_weight_sets;
mod figure_weights;
mod filled;
mod filled_page;
mod mannequin;
mod one_page;
mod page;
mod page_advice;
mod page_decision;
mod page_evidence;
mod page_scene;
mod page_scores;
mod panel;
mod paper;
mod paper_page;
mod program;
mod raster;
mod sheet;
mod shift_page;
mod shift_table;
mod size;
mod solid;
mod style;
mod tables;
#[cfg(test)]
mod tests;
mod validation;
mod validation_page;
mod value_axis;
mod view;
mod watch_page;
mod workbook;

pub use batch_page::batch_page;
pub use comparison::{
    ComparedBody, ComparedPath, ComparedRun, Comparison, NamedRun, Role, RowState, RunDifference,
    comparison,
};
pub use figure_box::{BoxPanel, box_plots};
pub use figure_cell::cell_figure;
pub use figure_directions::directions_figure;
pub use figure_forest::{ForestPanel, ForestRow, forest_plots};
pub use figure_grips::grips_figure;
pub use figure_growth::{GrowthLine, GrowthNote, GrowthPoint, growth_plot, noted_growth_plot};
pub use figure_held_out::held_out_figure;
pub use figure_import::{ImportPicture, import_figure};
pub use figure_reliability::{ReliabilityPoint, reliability_curve};
pub use figure_weights::{Learned, weights_figure};
pub use filled_page::{Picked, sheet_files};
pub use paper::paper_files;
pub use program::{Language, Program, ProgramError, program};
pub use shift_page::shift_files;
pub use size::size_files;
pub use validation::validation_files;
pub use watch_page::{Watched, WatchedCheck, WatchedPhase, watch_page, watch_status};

use crate::files::sealed_pretty_json;
use crate::planner::RunResult;
use thiserror::Error;
use view::View;

/// A file could not be made.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A value could not be written as JSON.
    #[error("result.json: {0}")]
    Json(#[from] serde_json::Error),
    /// A value could not be written as YAML.
    #[error("joint trajectory: {0}")]
    Yaml(#[from] serde_saphyr::ser::Error),
    /// A table could not be written.
    #[error("table: {0}")]
    Table(#[from] csv::Error),
    /// The workbook could not be written.
    #[error("report.xlsx: {0}")]
    Workbook(#[from] rust_xlsxwriter::XlsxError),
    /// A figure could not be drawn.
    #[error("figure `{name}`: {message}")]
    Figure {
        /// Its name.
        name: String,
        /// Why.
        message: String,
    },
}

/// All files of a run, as (name, bytes).
pub fn files(result: &RunResult) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    files_again(result, None)
}

/// The same, of a run that was read back; with what has changed since, if anything has.
pub fn files_again(
    result: &RunResult,
    out_of_date: Option<&str>,
) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let view = View { out_of_date, ..View::of(result) };
    let candidates = tables::candidates(&view);
    let mut files = vec![
        ("result.json".to_owned(), result_json(result)?.into_bytes()),
        ("candidates.csv".to_owned(), candidates.csv()?),
    ];
    let mut sheets = vec![workbook::Sheet::candidates(candidates)];
    for candidate in &view.reported {
        if let (Some(rank), Some(path)) = (candidate.rank, &candidate.path) {
            let table = tables::path(path);
            files.push((format!("paths/{rank}.csv"), table.csv()?));
            sheets.push(workbook::Sheet::path(rank, candidate, table));
            if let Some(motion) = &path.joint_trajectory {
                let name = |end: &str| format!("paths/{rank}.joint_trajectory.{end}");
                files.push((name("json"), (serde_json::to_string_pretty(motion)? + "\n").into()));
                files.push((name("yaml"), serde_saphyr::to_string(motion)?.into()));
                let check = serde_json::to_string_pretty(&path.joint_margins)? + "\n";
                files.push((format!("paths/{rank}.joint_limits.json"), check.into()));
            }
        }
    }
    files.push(("report.xlsx".to_owned(), workbook::workbook(&view, &sheets)?));
    for table in &result.rollouts {
        let body = table
            .other_body
            .as_ref()
            .map_or_else(String::new, |b| format!("-{}", b.replace(' ', "_")));
        files.push((format!("rollouts/{}{body}.csv", table.rank), tables::rollouts(table)?));
    }
    // Without a scored path there is only the cell to draw.
    let scores = view.lead.map(|_| -> Result<_, ReportError> {
        Ok(page::ScoreFigures {
            over_time: figure_scores::over_time(&view)?,
            levels: figure_scores::levels(&view)?,
            parts: figure_scores::parts(&view)?,
            parts_over_time: figure_heat::heat(&view)?,
            postures: figure_postures::postures(&view)?,
            distributions: figure_population::distributions(&view)?,
            population: figure_population::population(&view)?,
        })
    });
    let figures = page::Figures {
        still: figure_still::still(&view)?,
        paths: figure_paths::paths(&view)?,
        scores: scores.transpose()?,
    };
    files.push(("report.html".to_owned(), page::report(&view, &figures)?.into_bytes()));
    files.extend(figures.still.map(|(png, _)| ("figures/still.png".to_owned(), png)));
    files.push(("figures/paths.png".to_owned(), figures.paths));
    if let Some(scores) = figures.scores {
        files.push(("figures/rula_over_time.png".to_owned(), scores.over_time));
        files.push(("figures/levels.png".to_owned(), scores.levels));
        files.push(("figures/parts.png".to_owned(), scores.parts));
        files.push(("figures/distributions.png".to_owned(), scores.distributions));
        for (name, figure) in [
            ("parts_over_time", scores.parts_over_time),
            ("postures", scores.postures),
            ("population", scores.population),
        ] {
            files.extend(figure.map(|png| (format!("figures/{name}.png"), png)));
        }
    }
    Ok(files)
}

/// The decision on one sheet of A4, as (name, bytes); with what has changed since the run, if anything has.
pub fn one_page(
    result: &RunResult,
    out_of_date: Option<&str>,
) -> Result<(String, Vec<u8>), ReportError> {
    let view = View { out_of_date, ..View::of(result) };
    Ok(("one_page.html".to_owned(), one_page::one_page(&view)?.into_bytes()))
}

/// `result.json` as text, with a checksum over its content.
pub fn result_json(result: &RunResult) -> Result<String, ReportError> {
    Ok(sealed_pretty_json(result)?)
}

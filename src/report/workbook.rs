//! `report.xlsx`: the tables of a run as sheets of a workbook, numbers as numbers, after a sheet that says
//! what they are. No formulas: a text stays a text, whatever it begins with.

use super::ReportError;
use super::tables::{Cell, Table};
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::planner::CandidateResult;
use crate::words;
use rust_xlsxwriter::{DocProperties, ExcelDateTime, Format, Workbook, Worksheet};

/// The day that stands in every workbook as that of its making, so that the same run gives the same bytes.
const DAY: (u16, u8, u8) = (2000, 1, 1);
/// Most characters that a cell holds.
const LONGEST: usize = 32_767;
/// Widest column, px.
const WIDEST: u32 = 360;

/// A table as a sheet.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    name: String,
    file: String,
    what: String,
    table: Table,
}

impl Sheet {
    /// All paths of the run.
    pub(super) fn candidates(table: Table) -> Self {
        Self {
            name: "Paths".to_owned(),
            file: "candidates.csv".to_owned(),
            what: "all paths of the run, a row for each, with the scores of the body that the report is about"
                .to_owned(),
            table,
        }
    }

    /// A path over time.
    pub(super) fn path(rank: usize, candidate: &CandidateResult, table: Table) -> Self {
        Self {
            name: format!("Path {rank}"),
            file: format!("paths/{rank}.csv"),
            what: format!(
                "{}, over time: the TCP in the world and the robot's joints",
                words::paths::path_name(candidate)
            ),
            table,
        }
    }
}

/// The workbook.
pub(super) fn workbook(view: &View, sheets: &[Sheet]) -> Result<Vec<u8>, ReportError> {
    let (year, month, day) = DAY;
    let mut book = Workbook::new();
    let day = ExcelDateTime::from_ymd(year, month, day)?;
    book.set_properties(
        &DocProperties::new()
            .set_title(text(&view.result.setting.name))
            .set_comment("Made by ergopath")
            .set_creation_datetime(&day),
    );
    about(book.add_worksheet(), view, sheets)?;
    for sheet in sheets {
        fill(book.add_worksheet(), sheet)?;
    }
    Ok(book.save_to_buffer()?)
}

/// The first sheet: the verdict, what the sheets are, and what the columns hold.
fn about(page: &mut Worksheet, view: &View, sheets: &[Sheet]) -> Result<(), ReportError> {
    let bold = Format::new().set_bold();
    page.set_name("About")?;
    page.set_column_width(0, 30)?;
    page.set_column_width(1, 110)?;
    let result = view.result;
    let provenance = &result.provenance;
    let mut lines = vec![(result.setting.name.clone(), words::verdict::headline(result))];
    if let Some(caveat) = result.verdict.caveat {
        lines.push(("Caution".to_owned(), words::verdict::caveat(caveat).into_owned()));
    }
    lines.extend(view.out_of_date.map(|what| ("Out of date".to_owned(), what.to_owned())));
    lines.push((
        "Made by".to_owned(),
        format!("{} (ergopath {})", provenance.command, provenance.program_version),
    ));
    lines.push((
        "Sheets".to_owned(),
        "each holds the same numbers as the file of tables beside this workbook".to_owned(),
    ));
    lines.extend(sheets.iter().map(|s| (s.name.clone(), format!("{} ({})", s.what, s.file))));
    lines.push(("Columns of Paths".to_owned(), "scores are means of whole numbers on the scale of the method: they rank, they do not measure".to_owned()));
    lines.extend(columns());
    lines.push(("Columns of a path".to_owned(), "the endings are the units: _s seconds, _m metres, _rad radians (metres for a joint that slides)".to_owned()));
    lines.push((
        "x_m, y_m, z_m".to_owned(),
        "place of the TCP in the world, m; z upwards from the floor".to_owned(),
    ));
    lines.push((
        "qw, qx, qy, qz".to_owned(),
        "its orientation as a quaternion, qw the scalar part".to_owned(),
    ));
    for (row, (what, words)) in (0..).zip(lines) {
        page.write_string_with_format(row, 0, text(&what), &bold)?;
        page.write_string(row, 1, text(&words))?;
    }
    Ok(())
}

/// What the columns of all paths hold.
fn columns() -> Vec<(String, String)> {
    let of = |name: String, what: String| (name, what);
    let mut all = vec![
        of("rank".into(), "1 is best; empty for a path that is not feasible".into()),
        of(
            "state".into(),
            "feasible; marked (yours, over a limit); infeasible (why: the last column)".into(),
        ),
        of(
            "evaluated".into(),
            "how far it came: reported (fresh repetitions), search (few repetitions), none".into(),
        ),
        of("objective".into(), "what the search made small".into()),
    ];
    for method in ScoringMethod::ALL {
        let (key, name, high) = (method.key(), method.name(), method.high());
        all.extend([
            of(
                format!("expected_{key}"),
                format!("{name}, mean over repetitions and time; se_ its standard error"),
            ),
            of(
                format!("p05_{key}, p95_{key}"),
                "nine of ten repetitions lie between them (time means)".into(),
            ),
            of(format!("cvar90_{key}"), "mean of the worst tenth of the repetitions".into()),
            of(
                format!("exposure_{key}_{high}"),
                format!("share of the time (0 to 1) with {name} {high} or more"),
            ),
            of(
                format!("{key}_per_metre"),
                "mean with each piece of hand travel counting the same".into(),
            ),
            of(
                format!("peak_{key}"),
                "exceeded for 5 % of the time, median over repetitions".into(),
            ),
        ]);
    }
    all.extend([
        of(
            "reach_exceeded".into(),
            "share of repetitions (0 to 1) in which the hand does not follow".into(),
        ),
        of("hand_travel_m".into(), "length of the hand's way, m".into()),
        of("hand_speed_max_m_s".into(), "its greatest speed, m/s".into()),
        of("hand_acceleration_max_m_s2".into(), "its greatest acceleration, m/s^2".into()),
    ]);
    all
}

fn fill(page: &mut Worksheet, sheet: &Sheet) -> Result<(), ReportError> {
    let bold = Format::new().set_bold();
    page.set_name(&sheet.name)?;
    page.set_freeze_panes(1, 0)?;
    for (column, name) in (0..).zip(&sheet.table.columns) {
        page.write_string_with_format(0, column, text(name), &bold)?;
    }
    for (row, cells) in (1..).zip(&sheet.table.rows) {
        for (column, cell) in (0..).zip(cells) {
            match cell {
                Cell::Text(words) => {
                    page.write_string(row, column, text(words))?;
                }
                Cell::Number(value) if value.is_finite() => {
                    page.write_number(row, column, *value)?;
                }
                Cell::Number(_) | Cell::Empty => {}
            }
        }
    }
    page.set_autofit_max_width(WIDEST);
    page.autofit();
    Ok(())
}

/// As much as a cell holds, without the signs that a workbook cannot hold.
fn text(words: &str) -> String {
    words.chars().filter(|c| !c.is_control() || *c == '\n').take(LONGEST).collect()
}

//! Forest plots: one value with its interval for each row, one panel for each comparison.

use super::ReportError;
use super::panel::{Panel, Words};
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{BLUE, GRID, INK, MUTED, Pen, Stroke, TICK};

/// Least width of a panel with its labels and of a figure, height of a row, room above and below a
/// panel, px.
const WIDE: f64 = 640.0;
const LEAST: f64 = 1600.0;
const ROW: f64 = 40.0;
const ROOM: (f64, f64) = (72.0, 84.0);
/// Room for the labels at the left, free room at the right, px.
const SIDES: (f64, f64) = (210.0, 30.0);
/// Panels beside each other.
const COLUMNS: usize = 3;

/// A row of a forest plot.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestRow {
    /// What it is about.
    pub label: String,
    /// Value, lower and upper end of its interval; none where there is none.
    pub value: Option<[f64; 3]>,
    /// Drawn heavier: the sum of the others.
    pub is_total: bool,
}

/// A panel of a forest plot.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestPanel {
    /// What is compared.
    pub title: String,
    /// What the axis shows, with its unit.
    pub axis: String,
    /// Where the reference line stands.
    pub reference: f64,
    /// The rows from the top.
    pub rows: Vec<ForestRow>,
}

/// Panels of rows with intervals, all on one axis, as PNG; `key` says what dots and bars are.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn forest_plots(panels: &[ForestPanel], key: &str) -> Result<Vec<u8>, ReportError> {
    let columns = panels.len().clamp(1, COLUMNS);
    let lines = panels.iter().map(|p| p.rows.len()).max().unwrap_or(0).max(1);
    let high = ROOM.0 + ROW * lines as f64 + ROOM.1;
    let height = high * panels.len().div_ceil(columns).max(1) as f64 + 44.0;
    let range = range(panels);
    let wide = WIDE.max(LEAST / columns as f64);
    png("forest", ((wide * columns as f64) as u32, height as u32), |sheet| {
        for (i, panel) in panels.iter().enumerate() {
            let left = wide * (i % columns) as f64;
            let top = high * (i / columns) as f64 + ROOM.0;
            let on = Panel {
                x_px: (left + SIDES.0, left + wide - SIDES.1),
                y_px: (top, top + ROW * lines as f64),
                x: range,
                y: (lines as f64, 0.0),
            };
            draw(sheet, panel, &on)?;
        }
        let muted = Type::plain(18.0).colored(MUTED);
        sheet.text(key, (24.0, height - 26.0), muted, Anchor::Left)
    })
}

/// From the smallest to the largest value, with the reference and some room.
fn range(panels: &[ForestPanel]) -> (f64, f64) {
    let values = panels.iter().flat_map(|p| {
        let rows = p.rows.iter().filter_map(|r| r.value).flatten();
        rows.chain([p.reference]).filter(|v| v.is_finite())
    });
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let room = 0.06 * (high - low).max(1e-3);
    if low <= high { (low - room, high + room) } else { (0.0, 1.0) }
}

fn draw(sheet: &Sheet, panel: &ForestPanel, on: &Panel) -> Drawn {
    let thin = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
    for i in 0..panel.rows.len() {
        let y = i as f64 + 0.5;
        sheet.line(&[on.at(on.x.0, y), on.at(on.x.1, y)], thin)?;
    }
    let dashed = Pen { color: INK, width: 2.0, stroke: Stroke::Dashed };
    sheet.line(&[on.at(panel.reference, on.y.0), on.at(panel.reference, on.y.1)], dashed)?;
    on.axes(sheet, Words { title: &panel.title, x: &panel.axis, y: "" }, &[])?;
    for (i, row) in panel.rows.iter().enumerate() {
        let y = i as f64 + 0.5;
        let (_, at) = on.at(on.x.0, y);
        let kind = if row.is_total { Type::bold(TICK) } else { Type::plain(TICK) };
        sheet.text(&row.label, (on.x_px.0 - 14.0, at), kind, Anchor::Right)?;
        let Some([value, low, high]) = row.value else {
            let muted = Type::plain(16.0).colored(MUTED);
            sheet.text("no value", (0.5 * (on.x_px.0 + on.x_px.1), at), muted, Anchor::Middle)?;
            continue;
        };
        let pen =
            Pen { color: BLUE, width: if row.is_total { 4.0 } else { 2.5 }, stroke: Stroke::Solid };
        sheet.line(&[on.at(low, y), on.at(high, y)], pen)?;
        for end in [low, high] {
            let (x, y) = on.at(end, y);
            sheet.line(&[(x, y - 7.0), (x, y + 7.0)], pen)?;
        }
        sheet.disc(on.at(value, y), if row.is_total { 7.5 } else { 5.5 }, pen.color)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_values_and_no_panels_are_drawn() {
        let row = |label: &str, value| ForestRow {
            label: label.to_owned(),
            value,
            is_total: label == "all",
        };
        let panel = ForestPanel {
            title: "against the straight path".to_owned(),
            axis: "points of expected RULA".to_owned(),
            reference: 0.0,
            rows: vec![
                row("bench pick and place", Some([0.4, 0.3, 0.5])),
                row("floor-to-shelf lift", None),
                row("all", Some([0.3, 0.28, 0.32])),
            ],
        };
        let twice = [panel.clone(), panel.clone(), panel.clone(), panel];
        let drawn = forest_plots(&twice, "dot: mean; bar: 95 % interval").unwrap();
        assert!(drawn.starts_with(b"\x89PNG"));
        assert!(forest_plots(&[], "").unwrap().starts_with(b"\x89PNG"));
        let (low, high) = range(&twice);
        assert!(low < 0.0 && high > 0.5 && high < 0.6);
    }
}

//! `coverage.png` of a validation: how much of the record each band held, for each person and part of the body.

use super::ReportError;
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{BLUE, GRID, LABEL, MUTED, ORANGE, TICK, TITLE, WHITE, tint};
use crate::training::people::{FEATURES, LeftOut, MovementScore, coverage};
use crate::words::number::percent;
use plotters::style::RGBColor;

/// Left end of the first cell, its size, and the top of the first row, px.
const LEFT: f64 = 220.0;
const CELL: (f64, f64) = (180.0, 46.0);
const TOP: f64 = 146.0;
/// Room below the last row, px.
const BELOW: f64 = 74.0;
/// By how much a band may miss what it promises before its cell has a colour.
const FAIR: f64 = 0.05;

/// A table of coloured cells as PNG: people down, parts across, all people last.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn coverages(found: &LeftOut) -> Result<Vec<u8>, ReportError> {
    let rows = found.people.len() + 1;
    let size = (LEFT + CELL.0 * FEATURES.len() as f64 + 40.0, TOP + CELL.1 * rows as f64 + BELOW);
    png("coverage", (size.0 as u32, size.1 as u32), |sheet| {
        let title = "Share of the recorded frames inside the 90 % band of strangers";
        sheet.text(title, (40.0, 36.0), Type::bold(TITLE), Anchor::Left)?;
        for (f, feature) in FEATURES.iter().enumerate() {
            let x = LEFT + CELL.0 * (f as f64 + 0.5);
            sheet.text(feature, (x, TOP - 28.0), Type::plain(LABEL), Anchor::Middle)?;
        }
        let everybody = ("all", found.movements());
        let people = found.people.iter().map(|p| (p.person.as_str(), p.own()));
        for (i, (name, movements)) in people.chain([everybody]).enumerate() {
            row(sheet, (i, i + 1 == rows), name, &movements)?;
        }
        let note = "90 % would be right. Blue: more, the band is too wide; orange: less, it is too narrow; white: within 5 points.";
        let at = (40.0, TOP + CELL.1 * rows as f64 + 40.0);
        sheet.text(note, at, Type::plain(TICK).colored(MUTED), Anchor::Left)
    })
}

fn row(sheet: &Sheet, (i, is_all): (usize, bool), name: &str, own: &[&MovementScore]) -> Drawn {
    let top = TOP + CELL.1 * i as f64;
    let middle = top + 0.5 * CELL.1;
    let kind = if is_all { Type::bold(LABEL) } else { Type::plain(LABEL) };
    let name = sheet.shortened(name, LEFT - 60.0, kind);
    sheet.text(&name, (LEFT - 16.0, middle), kind, Anchor::Right)?;
    for f in 0..FEATURES.len() {
        let held = coverage(own, f, 1);
        let left = LEFT + CELL.0 * f as f64;
        let (a, b) = ((left, top), (left + CELL.0, top + CELL.1));
        sheet.fill(a, b, cell_color(held))?;
        sheet.outline(a, b, GRID, 1.0)?;
        sheet.text(&percent(held), (left + 0.5 * CELL.0, middle), kind, Anchor::Middle)?;
    }
    Ok(())
}

/// The further from what was promised, the stronger.
fn cell_color(held: f64) -> RGBColor {
    let off = held - 0.9;
    if off.abs() <= FAIR {
        WHITE
    } else if off > 0.0 {
        tint(BLUE, 4.0 * off.min(0.1))
    } else {
        tint(ORANGE, (0.15 + 2.0 * -off).min(0.9))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_promised_has_no_colour() {
        assert!([0.86, 0.9, 0.94].iter().all(|held| cell_color(*held) == WHITE));
        assert!(cell_color(0.6) != cell_color(0.8) && cell_color(0.8) != WHITE);
        assert!(cell_color(1.0) != WHITE);
    }
}

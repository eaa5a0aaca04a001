//! Figure: the steps of RULA over time, as a map of rows and columns.

use super::ReportError;
use super::panel::ticks;
use super::sheet::{Anchor, Sheet, Type, png};
use super::style::{INK, LABEL, MUTED, Pen, Stroke, TICK, TITLE, VERMILION, tint};
use super::view::View;
use crate::planner::PartScore;
use plotters::style::RGBColor;

const WIDTH: f64 = 1600.0;
const ROW: f64 = 56.0;
const TOP: f64 = 110.0;
/// Moments whose number is written into the map.
const WRITTEN: usize = 9;
/// Highest step score of the scale: that of the upper arm, the neck and the trunk.
const HIGHEST: f64 = 6.0;

/// `figures/parts_over_time.png`; nothing where it is not known.
pub(super) fn heat(view: &View) -> Result<Option<Vec<u8>>, ReportError> {
    let Some(lead) = view.lead else { return Ok(None) };
    let parts: &[PartScore] = view.scores(lead).map_or(&[], |b| &b.rula().parts);
    let frames = parts.iter().map(|p| p.over_time.len()).max().unwrap_or(0);
    let end = lead.path.as_ref().and_then(|p| p.time_s.last().copied());
    let (Some(end), true) = (end, frames > 1) else { return Ok(None) };
    let height = TOP + ROW * parts.len() as f64 + 130.0;
    let drawn = png("parts_over_time", (WIDTH as u32, height as u32), |sheet| {
        let title =
            format!("RULA step scores over time, {}: mean over repetitions", view.lead_name(lead));
        sheet.text(&title, (230.0, 40.0), Type::bold(TITLE), Anchor::Left)?;
        let (left, right) = (230.0, WIDTH - 40.0);
        let x = |k: usize| left + (right - left) * k as f64 / frames as f64;
        for (i, part) in parts.iter().enumerate() {
            let y = TOP + ROW * i as f64;
            sheet.text(
                &part.part,
                (left - 16.0, y + 0.5 * ROW),
                Type::plain(LABEL),
                Anchor::Right,
            )?;
            for (k, value) in part.over_time.iter().enumerate() {
                sheet.fill((x(k), y), (x(k + 1) + 0.6, y + ROW - 4.0), color(*value))?;
            }
            for n in 0..WRITTEN {
                let k = (2 * n + 1) * frames / (2 * WRITTEN);
                let Some(value) = part.over_time.get(k) else { continue };
                let at = (x(k), y + 0.5 * (ROW - 4.0));
                sheet.text(&format!("{value:.1}"), at, Type::plain(TICK), Anchor::Middle)?;
            }
            sheet.outline((left, y), (right, y + ROW - 4.0), MUTED, 1.0)?;
        }
        let bottom = TOP + ROW * parts.len() as f64;
        for t in ticks((0.0, end), 8) {
            let at = left + (right - left) * t / end;
            let pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
            sheet.line(&[(at, bottom), (at, bottom + 7.0)], pen)?;
            let text = format!("{t:.1}");
            sheet.text(&text, (at, bottom + 24.0), Type::plain(TICK), Anchor::Middle)?;
        }
        let middle = 0.5 * (left + right);
        sheet.text("time (s)", (middle, bottom + 56.0), Type::plain(LABEL), Anchor::Middle)?;
        scale(sheet, (left, bottom + 92.0))
    });
    drawn.map(Some)
}

fn color(value: f64) -> RGBColor {
    tint(VERMILION, 0.9 * ((value - 1.0) / (HIGHEST - 1.0)).clamp(0.0, 1.0))
}

/// The scale of the colours with its numbers.
fn scale(sheet: &Sheet, (left, y): (f64, f64)) -> super::sheet::Drawn {
    sheet.text("step score", (left, y), Type::plain(TICK), Anchor::Left)?;
    for value in 0..=6_u8 {
        let at = left + 140.0 + 66.0 * f64::from(value);
        sheet.fill((at, y - 15.0), (at + 62.0, y + 15.0), color(f64::from(value)))?;
        sheet.outline((at, y - 15.0), (at + 62.0, y + 15.0), INK, 1.0)?;
        sheet.text(&value.to_string(), (at + 31.0, y), Type::plain(TICK), Anchor::Middle)?;
    }
    Ok(())
}

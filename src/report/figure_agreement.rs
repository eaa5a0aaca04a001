//! `scores.png` of a validation: predicted against recorded scores, one point for each movement.

use super::ReportError;
use super::panel::{Key, Panel, Words, legend};
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{BLUE, FAINT, INK, MUTED, Pen, Stroke, TICK, TITLE, VERMILION};
use crate::ergonomics::ScoringMethod;
use crate::training::people::{LeftOut, RiskScore};
use crate::words::number::{percent, score};

/// Size of the figure, px.
const SIZE: (f64, f64) = (1600.0, 880.0);
/// Left ends of the panels, and the length of their edges, px.
const LEFT: [f64; 2] = [120.0, 920.0];
const TOP: f64 = 190.0;
const EDGE: f64 = 600.0;
/// Least room beyond the values, points of the score.
const ROOM: f64 = 0.25;

const BAND_90: f64 = 1.6;
const BAND_50: f64 = 5.0;
const SAME: Pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Dashed };

/// Two panels, RULA and REBA, as PNG: of each movement the mean over repetitions with its bands.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn scores(found: &LeftOut) -> Result<Vec<u8>, ReportError> {
    png("scores", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let title = "Predicted from the hand path alone, against the recorded person";
        sheet.text(title, (40.0, 36.0), Type::bold(TITLE), Anchor::Left)?;
        let line = |color, width| Pen { color, width, stroke: Stroke::Solid };
        let keys = [
            Key::Line(line(BLUE, BAND_90), "90 % band of the repetitions".to_owned()),
            Key::Line(line(BLUE, BAND_50), "50 % band, and the mean".to_owned()),
            Key::Line(
                line(VERMILION, BAND_90),
                "recorded outside the 90 % band (crossed)".to_owned(),
            ),
            Key::Line(SAME, "predicted as recorded".to_owned()),
        ];
        legend(sheet, (40.0, 84.0), SIZE.0 - 80.0, &keys)?;
        for (method, left) in ScoringMethod::ALL.into_iter().zip(LEFT) {
            draw(sheet, found, method, left)?;
        }
        Ok(())
    })
}

fn draw(sheet: &Sheet, found: &LeftOut, method: ScoringMethod, left: f64) -> Drawn {
    let movements = found.movements();
    let all: Vec<&RiskScore> =
        movements.iter().filter_map(|m| m.risk.as_ref()).map(|r| &r[method]).collect();
    let values = all.iter().flat_map(|s| [s.recorded, s.predicted, s.band_90[0], s.band_90[1]]);
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let range =
        if low < high { (low - ROOM, high + ROOM) } else { (1.0, f64::from(method.worst())) };
    let panel = Panel { x_px: (left, left + EDGE), y_px: (TOP, TOP + EDGE), x: range, y: range };
    panel.grid(sheet)?;
    sheet.line(&[panel.at(range.0, range.0), panel.at(range.1, range.1)], SAME)?;
    for s in &all {
        let is_inside = s.is_inside(s.band_90);
        let color = if is_inside { BLUE } else { VERMILION };
        for ([from, to], width) in [(s.band_90, BAND_90), (s.band_50, BAND_50)] {
            let ends = [panel.at(s.recorded, from), panel.at(s.recorded, to)];
            sheet.line(&ends, Pen { color, width, stroke: Stroke::Solid })?;
        }
    }
    for s in &all {
        let (x, y) = panel.at(s.recorded, s.predicted);
        if s.is_inside(s.band_90) {
            sheet.disc((x, y), 6.0, BLUE)?;
        } else {
            let pen = Pen { color: VERMILION, width: 3.5, stroke: Stroke::Solid };
            sheet.line(&[(x - 7.0, y - 7.0), (x + 7.0, y + 7.0)], pen)?;
            sheet.line(&[(x - 7.0, y + 7.0), (x + 7.0, y - 7.0)], pen)?;
        }
    }
    let name = method.name();
    let (x, y) = (format!("{name} recorded, mean over time"), format!("{name} predicted"));
    let words = Words { title: "", x: &x, y: &y };
    panel.axes(sheet, words, &panel.y_ticks())?;
    sheet.text(
        &figures(found, method),
        (left, TOP - 24.0),
        Type::plain(TICK).colored(INK),
        Anchor::Left,
    )?;
    if all.is_empty() {
        let middle = (left + 0.5 * EDGE, TOP + 0.5 * EDGE);
        sheet.text(
            "no movement was predicted",
            middle,
            Type::plain(TICK).colored(FAINT),
            Anchor::Middle,
        )?;
    }
    Ok(())
}

/// Error, rank correlation and coverage in words.
fn figures(found: &LeftOut, method: ScoringMethod) -> String {
    let risk = found.risk(method);
    let ranks = risk.agreement.rank_correlation.map_or_else(|| "unknown".to_owned(), score);
    format!(
        "mean error {}, rank correlation {ranks}, {} in the 90 % band",
        score(risk.agreement.mae),
        percent(risk.inside90)
    )
}

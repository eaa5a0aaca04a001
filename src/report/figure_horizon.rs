//! How far hand and joints are off as the horizon of a prediction grows: the paper's Fig. 6b, for all methods.

use super::ReportError;
use super::figure_growth::end_names;
use super::panel::{Panel, Words, ticks};
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{GRID, LABEL, MUTED, Pen, Stroke, TICK, TITLE};
use super::value_axis::{Axis, method_color};
use crate::training::paper::{ChainResult, HorizonPoint};

/// Size of the figure, px.
const SIZE: (f64, f64) = (1500.0, 690.0);
/// Left ends of the panels and their width; top and bottom, px.
const LEFT: [f64; 2] = [110.0, 860.0];
const WIDE: f64 = 470.0;
const Y_PX: (f64, f64) = (84.0, 496.0);

type Pick = fn(&HorizonPoint) -> f64;

/// Error of the hand (mm, logarithmic) and of the joint angles (deg) over the horizon (s), a line per method, as PNG.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn horizon_figure(
    chain: &ChainResult,
    is_simulated: bool,
) -> Result<Vec<u8>, ReportError> {
    png("horizon", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let halves: [(&str, &str, Pick); 2] = [
            ("Error of the hand", "distance (mm), logarithmic", |p| p.hand_mm),
            ("Error of the joint angles", "rms over joints (deg)", |p| p.joints_deg),
        ];
        for (i, (title, unit, pick)) in halves.into_iter().enumerate() {
            draw(sheet, chain, (LEFT[i], i == 0), (title, unit), pick)?;
        }
        let who = if is_simulated { "Simulated people: nobody was recorded. " } else { "" };
        let note = format!(
            "{who}Root mean square over held-out movements that are as long (at least a quarter of them). From the recorded \
             posture, by the paper's own step without noise: the law's joint velocity, asked for the hand's way to the next \
             recorded place, times the time step. Nothing brings a lost hand back or keeps a limit."
        );
        let muted = Type::plain(TICK).colored(MUTED);
        sheet.paragraph(&note, (36.0, 590.0), SIZE.0 - 72.0, muted)
    })
}

fn draw(
    sheet: &Sheet,
    chain: &ChainResult,
    (left, is_log): (f64, bool),
    (title, unit): (&str, &str),
    pick: Pick,
) -> Drawn {
    let points = || chain.horizon.iter().flat_map(|c| &c.points);
    let values: Vec<f64> = points().map(pick).filter(|v| v.is_finite()).collect();
    let y = if is_log { Axis::logarithmic(&values) } else { Axis::errors(&values) };
    let longest = points().map(|p| p.horizon_s).fold(0.5, f64::max);
    let panel = Panel { x_px: (left, left + WIDE), y_px: Y_PX, x: (0.0, longest), y: y.range };
    let (top, bottom) = Y_PX;
    y.draw_left(sheet, &panel)?;
    for at in ticks(panel.x, 6) {
        let (x, _) = panel.at(at, 0.0);
        let thin = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
        sheet.line(&[(x, top), (x, bottom)], thin)?;
        sheet.text(&format!("{at}"), (x, bottom + 22.0), Type::plain(TICK), Anchor::Middle)?;
    }
    sheet.outline((left, top), (left + WIDE, bottom), MUTED, 1.5)?;
    let words = Words { title, x: "horizon (s)", y: unit };
    sheet.text(words.title, (left, top - 28.0), Type::bold(TITLE), Anchor::Left)?;
    let middle = (left + 0.5 * WIDE, bottom + 54.0);
    sheet.text(words.x, middle, Type::plain(LABEL), Anchor::Middle)?;
    sheet.upward(words.y, (left - 76.0, 0.5 * (top + bottom)), Type::plain(LABEL))?;
    let mut ends: Vec<(At, usize)> = Vec::new();
    for (k, curve) in chain.horizon.iter().enumerate() {
        let pen = Pen { color: method_color(k), width: 3.0, stroke: Stroke::Solid };
        let shown = curve.points.iter().filter(|p| pick(p).is_finite());
        let line: Vec<At> = shown.map(|p| panel.at(p.horizon_s, y.place(pick(p)))).collect();
        if line.len() > 1 {
            sheet.line(&line, pen)?;
        }
        ends.extend(line.last().map(|end| (*end, k)));
    }
    let names: Vec<&str> = chain.horizon.iter().map(|c| c.method).collect();
    end_names(sheet, &names, &panel, ends)
}

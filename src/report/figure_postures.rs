//! Figure: postures of the best path that matter, each with its body angles.

use super::ReportError;
use super::figure_paths::Look;
use super::mannequin;
use super::panel::Panel;
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{FAINT, GRID, INK, LABEL, MUTED, Pen, Stroke, TICK};
use super::view::View;
use crate::planner::Moment;
use crate::words;
use crate::words::number::capital;

const WIDTH: f64 = 1600.0;
const HEIGHT: f64 = 640.0;
/// Room for the headings, px.
const TOP: f64 = 150.0;
/// Joint centres and the lines between them, over the person in shape.
pub(super) const BONE: Pen = Pen { color: INK, width: 1.5, stroke: Stroke::Solid };
/// Part of a column that shows the person.
const SHARE: f64 = 0.46;

/// `figures/postures.png`; nothing without postures.
pub(super) fn postures(view: &View) -> Result<Option<Vec<u8>>, ReportError> {
    let moments = &view.result.moments;
    if moments.is_empty() {
        return Ok(None);
    }
    let look = Look::Side(view.result.setting.facing);
    let size = (WIDTH as u32, HEIGHT as u32);
    let drawn = png("postures", size, |sheet| {
        let wide = WIDTH / moments.len() as f64;
        for (i, moment) in moments.iter().enumerate() {
            let left = wide * i as f64;
            if i > 0 {
                let pen = Pen { color: GRID, width: 2.0, stroke: Stroke::Solid };
                sheet.line(&[(left, 24.0), (left, HEIGHT - 24.0)], pen)?;
            }
            column(sheet, moment, look, (left + 20.0, left + wide - 16.0))?;
        }
        Ok(())
    });
    drawn.map(Some)
}

/// One posture between two pixels.
fn column(sheet: &Sheet, moment: &Moment, look: Look, (left, right): (f64, f64)) -> Drawn {
    let room = right - left;
    let mut line = 34.0;
    for words in broken(sheet, &capital(words::cell::moment(moment.what)), room) {
        sheet.text(&words, (left, line), Type::bold(LABEL), Anchor::Left)?;
        line += 28.0;
    }
    let held = moment.held_s.map_or_else(String::new, |s| format!(", held {s:.1} s"));
    let scores = format!(
        "at {:.2} s{held}: RULA {}, REBA {} (repetition {})",
        moment.time_s, moment.rula, moment.reba, moment.repetition
    );
    sheet.text(&scores, (left, line), Type::plain(18.0).colored(MUTED), Anchor::Left)?;

    let Some((low, high)) = mannequin::extent(&moment.mannequin, look) else { return Ok(()) };
    let panel = Panel {
        x_px: (left, left + SHARE * room),
        y_px: (TOP, HEIGHT - 30.0),
        x: (low[0] - 0.06, high[0] + 0.06),
        y: (low[1].min(0.0), high[1] + 0.06),
    };
    let panel = panel.equalised(panel.px_per_unit());
    let floor = Pen { color: FAINT, width: 2.0, stroke: Stroke::Solid };
    sheet.line(&[panel.at(panel.x.0, 0.0), panel.at(panel.x.1, 0.0)], floor)?;
    mannequin::draw(sheet, &moment.mannequin, look, &panel)?;
    let at = |p: [f64; 3]| {
        let [x, y] = look.flat(p);
        panel.at(x, y)
    };
    for [a, b] in &moment.bones {
        sheet.line(&[at(*a), at(*b)], BONE)?;
    }
    for [_, b] in &moment.bones {
        sheet.disc(at(*b), 2.0, INK)?;
    }
    let text = left + (SHARE + 0.03) * room;
    for (i, (name, deg)) in moment.angles_deg.iter().enumerate() {
        let y = TOP + 20.0 + 36.0 * i as f64;
        sheet.text(name, (text, y), Type::plain(18.0), Anchor::Left)?;
        // No minus before a zero.
        let value = format!("{:.0}\u{b0}", deg.round() + 0.0).replace('-', "\u{2212}");
        sheet.text(&value, (right, y), Type::bold(TICK), Anchor::Right)?;
    }
    Ok(())
}

/// Words in lines no wider than `room`.
fn broken(sheet: &Sheet, words: &str, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split(' ') {
        match lines.last_mut() {
            Some(line) if sheet.width(&format!("{line} {word}"), Type::bold(LABEL)) <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

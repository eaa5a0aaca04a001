//! How methods grow with the number of samples: what they reach, and how long they take.

use super::ReportError;
use super::panel::Panel;
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{LABEL, MUTED, Pen, Stroke, TICK, TITLE};
use super::value_axis::{Axis, method_color};

/// Size of the figure, px.
const SIZE: (f64, f64) = (1400.0, 600.0);
/// Top and bottom of the panels, px.
const Y_PX: (f64, f64) = (84.0, 496.0);
/// Room for a note, px.
const NOTE: f64 = 30.0;
/// Left ends of the panels, px.
const LEFT: [f64; 2] = [96.0, 796.0];
/// Free room between a line's end and its name, px.
const GAP: f64 = 26.0;
/// Least distance between the middles of two names, px.
const ROW: f64 = 25.0;

/// What a method reached with some number of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrowthPoint {
    /// Number of samples, N.
    pub samples: usize,
    /// Mean held-out log-likelihood per row, nats.
    pub log_likelihood: f64,
    /// Training time, s.
    pub training_s: f64,
}

/// One method over the number of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowthLine {
    /// Its name.
    pub method: String,
    /// In the order of N.
    pub points: Vec<GrowthPoint>,
}

/// What has to be said with the lines.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GrowthNote {
    /// A line of text below the panels.
    pub text: String,
    /// Largest number of samples with exact processes, marked where the axis reaches beyond it.
    pub exact_to: Option<usize>,
}

type Pick = fn(&GrowthPoint) -> f64;

/// Held-out log-likelihood and training time over the number of samples, a line per method named at
/// its end, as PNG. Values that are not finite are left out, and times of zero.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn growth_plot(lines: &[GrowthLine]) -> Result<Vec<u8>, ReportError> {
    noted_growth_plot(lines, &GrowthNote::default())
}

/// [`growth_plot`] with a note.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn noted_growth_plot(lines: &[GrowthLine], note: &GrowthNote) -> Result<Vec<u8>, ReportError> {
    let height = SIZE.1 + if note.text.is_empty() { 0.0 } else { NOTE };
    png("growth", (SIZE.0 as u32, height as u32), |sheet| {
        let place = (LEFT[0], SIZE.1);
        sheet.text(&note.text, place, Type { color: MUTED, ..Type::plain(TICK) }, Anchor::Left)?;
        let name_room = lines.iter().map(|l| sheet.width(&l.method, Type::plain(TICK)));
        let name_room = GAP + 16.0 + name_room.fold(40.0, f64::max).min(200.0);
        let samples = |p: &GrowthPoint| p.samples as f64;
        let halves: [(&str, bool, Pick); 2] = [
            ("Held-out log-likelihood (nats per row)", false, |p| p.log_likelihood),
            ("Training time (s)", true, |p| p.training_s),
        ];
        for (i, (title, is_log, pick)) in halves.into_iter().enumerate() {
            let end = if i == 0 { LEFT[1] - 76.0 } else { SIZE.0 };
            let x_px = (LEFT[i], end - name_room);
            let shown = |p: &&GrowthPoint| {
                pick(p).is_finite() && p.samples > 0 && (pick(p) > 0.0 || !is_log)
            };
            let points = || lines.iter().flat_map(|l| &l.points).filter(shown);
            let x = Axis::logarithmic(&points().map(samples).collect::<Vec<_>>());
            let values: Vec<f64> = points().map(pick).collect();
            let y = if is_log { Axis::logarithmic(&values) } else { Axis::linear(&values) };
            let panel = Panel { x_px, y_px: Y_PX, x: x.range, y: y.range };
            frame(sheet, &panel, title, (&x, &y))?;
            if let Some(limit) = note.exact_to {
                border(sheet, &panel, x.place(limit as f64))?;
            }
            let mut ends = Vec::new();
            for (k, line) in lines.iter().enumerate() {
                let pen = Pen { color: method_color(k), width: 3.0, stroke: Stroke::Solid };
                let at = |p: &GrowthPoint| panel.at(x.place(samples(p)), y.place(pick(p)));
                let drawn: Vec<_> = line.points.iter().filter(shown).map(at).collect();
                if drawn.len() > 1 {
                    sheet.line(&drawn, pen)?;
                }
                for point in &drawn {
                    sheet.disc(*point, 5.0, pen.color)?;
                }
                ends.extend(drawn.last().map(|end| (*end, k)));
            }
            let methods: Vec<&str> = lines.iter().map(|l| l.method.as_str()).collect();
            end_names(sheet, &methods, &panel, ends)?;
        }
        Ok(())
    })
}

/// A dashed line between exact processes and inducing centres, named at the foot of the panel.
fn border(sheet: &Sheet, panel: &Panel, at: f64) -> Drawn {
    if at <= panel.x.0 || at >= panel.x.1 {
        return Ok(());
    }
    let (px, _) = panel.at(at, 0.0);
    let (top, bottom) = panel.y_px;
    let pen = Pen { color: MUTED, width: 1.0, stroke: Stroke::Dashed };
    sheet.line(&[(px, top), (px, bottom)], pen)?;
    let kind = Type { color: MUTED, ..Type::plain(TICK - 2.0) };
    sheet.text("exact", (px - 8.0, bottom - 14.0), kind, Anchor::Right)?;
    sheet.text("inducing centres", (px + 8.0, bottom - 14.0), kind, Anchor::Left)
}

/// Title, grid, ticks and the x axis.
fn frame(sheet: &Sheet, panel: &Panel, title: &str, (x, y): (&Axis, &Axis)) -> Drawn {
    let ((left, right), (top, bottom)) = (panel.x_px, panel.y_px);
    sheet.text(title, (left, top - 28.0), Type::bold(TITLE - 2.0), Anchor::Left)?;
    y.draw_left(sheet, panel)?;
    sheet.outline((left, top), (right, bottom), MUTED, 1.5)?;
    let pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
    for mark in x.marks(((right - left) / 90.0) as usize) {
        let (px, _) = panel.at(mark.at, 0.0);
        let long = if mark.label.is_empty() { 4.0 } else { 7.0 };
        sheet.line(&[(px, bottom), (px, bottom + long)], pen)?;
        sheet.text(&mark.label, (px, bottom + 24.0), Type::plain(TICK), Anchor::Middle)?;
    }
    let middle = (0.5 * (left + right), bottom + 62.0);
    sheet.text("number of samples N", middle, Type::plain(LABEL), Anchor::Middle)
}

/// The names of lines (pixel of the end, index) at their ends, moved apart where these meet.
pub(super) fn end_names(
    sheet: &Sheet,
    names: &[&str],
    panel: &Panel,
    mut ends: Vec<((f64, f64), usize)>,
) -> Drawn {
    ends.sort_by(|a, b| a.0.1.total_cmp(&b.0.1));
    let places = moved_apart(&ends.iter().map(|e| e.0.1).collect::<Vec<_>>(), panel.y_px);
    let x = panel.x_px.1 + GAP;
    for ((end, k), y) in ends.into_iter().zip(places) {
        let pen = Pen { color: method_color(k), width: 2.0, stroke: Stroke::Solid };
        sheet.line(&[(end.0 + 7.0, end.1), (panel.x_px.1 + 4.0, end.1), (x - 4.0, y)], pen)?;
        sheet.text(names[k], (x, y), Type::plain(TICK), Anchor::Left)?;
    }
    Ok(())
}

/// Ascending places moved as little as keeps [`ROW`] between them, within `low..high` if there is
/// room: neighbours that are too near are centred about their mean as one block.
fn moved_apart(places: &[f64], (low, high): (f64, f64)) -> Vec<f64> {
    // Blocks of (sum of places, number).
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    let top = |(sum, count): (f64, usize)| {
        let half = 0.5 * ROW * (count - 1) as f64;
        let middle = sum / count as f64;
        middle.min(high - half).max(low + half) - half
    };
    for place in places {
        let mut block = (*place, 1);
        while let Some(above) = blocks.last().copied() {
            if top(above) + ROW * above.1 as f64 <= top(block) {
                break;
            }
            block = (block.0 + above.0, block.1 + above.1);
            blocks.pop();
        }
        blocks.push(block);
    }
    let spread = |block: (f64, usize)| (0..block.1).map(move |k| top(block) + ROW * k as f64);
    blocks.into_iter().flat_map(spread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_move_apart_as_little_as_possible() {
        let room = (0.0, 500.0);
        assert_eq!(moved_apart(&[100.0, 200.0], room), [100.0, 200.0]);
        assert_eq!(moved_apart(&[100.0, 101.0], room), [88.0, 113.0]);
        let crowded = moved_apart(&[100.0, 100.0, 120.0, 499.0], room);
        assert!(crowded.windows(2).all(|p| p[1] - p[0] >= ROW - 1e-9), "{crowded:?}");
        assert_eq!(crowded[3], 499.0);
        assert_eq!(moved_apart(&[499.0, 499.0], room), [475.0, 500.0]);
    }

    #[test]
    fn it_is_drawn_even_without_lines() {
        let point = |samples, training_s| GrowthPoint { samples, log_likelihood: 15.0, training_s };
        let line = |points| GrowthLine { method: "MI-NsGP".to_owned(), points };
        let odd = [line(vec![point(100, 0.0), point(200, f64::NAN)]), line(Vec::new())];
        for lines in [&[][..], &odd] {
            assert!(growth_plot(lines).unwrap().starts_with(b"\x89PNG"));
            let note = GrowthNote { text: "made up".to_owned(), exact_to: Some(150) };
            assert!(noted_growth_plot(lines, &note).unwrap().starts_with(b"\x89PNG"));
        }
    }
}

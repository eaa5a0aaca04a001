//! A panel with two axes on a [`Sheet`]: ticks, grid, descriptions and the mapping to pixels.

use super::sheet::{Anchor, At, Drawn, Sheet, Type};
use super::style::{GRID, INK, LABEL, MUTED, Pen, Stroke, TICK, TITLE, WHITE};

/// A rectangle of the sheet with the values that its edges stand for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    /// Left, right in px.
    pub x_px: (f64, f64),
    /// Top, bottom in px.
    pub y_px: (f64, f64),
    /// Values at left and right.
    pub x: (f64, f64),
    /// Values at bottom and top.
    pub y: (f64, f64),
}

/// What is written around a panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
}

impl Panel {
    /// The pixel of a value.
    pub(super) fn at(&self, x: f64, y: f64) -> At {
        let along =
            |v: f64, (a, b): (f64, f64), (p, q): (f64, f64)| p + (v - a) / (b - a) * (q - p);
        (along(x, self.x, self.x_px), along(y, self.y, (self.y_px.1, self.y_px.0)))
    }

    /// Widens the values about their middle until one metre is as long on both axes, at
    /// `px_per_unit`.
    pub(super) fn equalised(mut self, px_per_unit: f64) -> Self {
        let widened = |(a, b): (f64, f64), px: f64| {
            let (middle, half) = (0.5 * (a + b), 0.5 * px / px_per_unit);
            (middle - half, middle + half)
        };
        self.x = widened(self.x, self.x_px.1 - self.x_px.0);
        self.y = widened(self.y, self.y_px.1 - self.y_px.0);
        self
    }

    /// Pixels per unit if the panel just shows its values.
    pub(super) fn px_per_unit(&self) -> f64 {
        let of = |(a, b): (f64, f64), (p, q): (f64, f64)| (q - p) / (b - a).max(1e-9);
        of(self.x, self.x_px).min(of(self.y, self.y_px))
    }

    /// The rectangle between two values, clipped to the panel; none if it is outside.
    pub(super) fn clipped(&self, a: [f64; 2], b: [f64; 2]) -> Option<(At, At)> {
        let low = [a[0].max(self.x.0), a[1].max(self.y.0)];
        let high = [b[0].min(self.x.1), b[1].min(self.y.1)];
        (low[0] < high[0] && low[1] < high[1])
            .then(|| (self.at(low[0], high[1]), self.at(high[0], low[1])))
    }

    /// Grid lines at the ticks of both axes.
    pub(super) fn grid(&self, sheet: &Sheet) -> Drawn {
        self.grid_at(sheet, &self.y_ticks())
    }

    /// The same with ticks of one's own along y.
    pub(super) fn grid_at(&self, sheet: &Sheet, y_ticks: &[f64]) -> Drawn {
        let pen = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
        for x in self.x_ticks() {
            sheet.line(&[self.at(x, self.y.0), self.at(x, self.y.1)], pen)?;
        }
        for &y in y_ticks {
            sheet.line(&[self.at(self.x.0, y), self.at(self.x.1, y)], pen)?;
        }
        Ok(())
    }

    /// Frame, ticks with numbers, and words.
    pub(super) fn axes(&self, sheet: &Sheet, words: Words, y_ticks: &[f64]) -> Drawn {
        let (left, right) = self.x_px;
        let (top, bottom) = self.y_px;
        sheet.outline((left, top), (right, bottom), MUTED, 1.5)?;
        let pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
        for x in self.x_ticks() {
            let (px, _) = self.at(x, 0.0);
            sheet.line(&[(px, bottom), (px, bottom + 6.0)], pen)?;
            sheet.text(&number(x), (px, bottom + 22.0), Type::plain(TICK), Anchor::Middle)?;
        }
        for &y in y_ticks {
            let (_, py) = self.at(0.0, y);
            sheet.line(&[(left - 6.0, py), (left, py)], pen)?;
            sheet.text(&number(y), (left - 12.0, py), Type::plain(TICK), Anchor::Right)?;
        }
        let middle = 0.5 * (left + right);
        sheet.text(words.x, (middle, bottom + 54.0), Type::plain(LABEL), Anchor::Middle)?;
        sheet.upward(words.y, (left - 74.0, 0.5 * (top + bottom)), Type::plain(LABEL))?;
        sheet.text(words.title, (left, top - 24.0), Type::bold(TITLE), Anchor::Left)
    }

    /// The ticks that suit the panel's y axis.
    pub(super) fn y_ticks(&self) -> Vec<f64> {
        ticks(self.y, room(self.y_px))
    }

    fn x_ticks(&self) -> Vec<f64> {
        ticks(self.x, room(self.x_px))
    }
}

/// How many ticks have room along an edge.
fn room((from, to): (f64, f64)) -> usize {
    ((to - from) / 84.0).max(2.0) as usize
}

/// Round values within a range, at most about `most` of them.
pub(super) fn ticks((low, high): (f64, f64), most: usize) -> Vec<f64> {
    let rough = (high - low) / most as f64;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let decade = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|f| f * decade).find(|s| *s >= rough * 0.999);
    let step = step.unwrap_or(10.0 * decade);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

/// A tick's number without needless zeros.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.replace('-', "\u{2212}") }
}

/// One entry of a legend.
#[derive(Debug, Clone)]
pub(super) enum Key {
    /// A line.
    Line(Pen, String),
    /// A line over a band.
    Band(Pen, String),
    /// A filled field.
    Field(plotters::style::RGBColor, String),
}

/// A legend in rows from `at` (left end, middle of the first row), no wider than `width`; answers
/// the height that it took.
pub(super) fn legend(
    sheet: &Sheet,
    at: At,
    width: f64,
    keys: &[Key],
) -> Result<f64, Box<dyn std::error::Error>> {
    const SAMPLE: f64 = 56.0;
    const ROW: f64 = 34.0;
    let (mut x, mut y) = at;
    for key in keys {
        let (Key::Line(_, text) | Key::Band(_, text) | Key::Field(_, text)) = key;
        let wide = SAMPLE + 10.0 + sheet.width(text, Type::plain(TICK));
        if x > at.0 && x + wide > at.0 + width {
            (x, y) = (at.0, y + ROW);
        }
        let (a, b) = ((x, y), (x + SAMPLE, y));
        match key {
            Key::Line(pen, _) => sheet.line(&[a, b], *pen)?,
            Key::Band(pen, _) => {
                let band = [(a.0, y - 9.0), (b.0, y - 9.0), (b.0, y + 9.0), (a.0, y + 9.0)];
                sheet.shape(&band, WHITE, 1.0)?;
                sheet.shape(&band, pen.color, 0.25)?;
                sheet.line(&[a, b], *pen)?;
            }
            Key::Field(color, _) => {
                sheet.fill((a.0 + 16.0, y - 10.0), (b.0, y + 10.0), *color)?;
                sheet.outline((a.0 + 16.0, y - 10.0), (b.0, y + 10.0), INK, 1.0)?;
            }
        }
        sheet.text(text, (b.0 + 10.0, y), Type::plain(TICK), Anchor::Left)?;
        x += wide + 36.0;
    }
    Ok(y - at.1 + ROW)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 4.0), 8), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        assert_eq!(ticks((-0.31, 0.29), 4), [-0.2, 0.0, 0.2]);
        assert!(ticks((1.0, 1.0), 8).is_empty());
        assert_eq!(number(-0.0), "0");
        assert_eq!(number(0.2 * 3.0), "0.6");
    }
}

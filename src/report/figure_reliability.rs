//! Predicted risk against observed risk, one dot for each bin, with the line on which both are the same.

use super::ReportError;
use super::panel::{Panel, Words};
use super::sheet::{Anchor, Sheet, Type, png};
use super::style::{BLUE, INK, MUTED, Pen, Stroke, TICK, TITLE};

/// Size of the figure, and place and edge of its panel, px.
const SIZE: (u32, u32) = (1000, 960);
const LEFT: f64 = 130.0;
const TOP: f64 = 130.0;
const EDGE: f64 = 700.0;

const SAME: Pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Dashed };
const CURVE: Pen = Pen { color: BLUE, width: 2.5, stroke: Stroke::Solid };

/// Paths of about the same predicted risk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliabilityPoint {
    /// Mean predicted share, 0 to 1.
    pub predicted: f64,
    /// Mean observed share, lower and upper end of its interval.
    pub observed: [f64; 3],
    /// How many paths.
    pub paths: usize,
}

/// A reliability curve as PNG; `title` says of what, `key` what dots and bars are.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn reliability_curve(
    points: &[ReliabilityPoint],
    title: &str,
    key: &str,
) -> Result<Vec<u8>, ReportError> {
    png("reliability", SIZE, |sheet: &Sheet| {
        sheet.text(title, (40.0, 36.0), Type::bold(TITLE), Anchor::Left)?;
        sheet.text(key, (40.0, 76.0), Type::plain(TICK).colored(MUTED), Anchor::Left)?;
        let range = (0.0, 100.0);
        let panel =
            Panel { x_px: (LEFT, LEFT + EDGE), y_px: (TOP, TOP + EDGE), x: range, y: range };
        panel.grid(sheet)?;
        sheet.line(&[panel.at(0.0, 0.0), panel.at(100.0, 100.0)], SAME)?;
        let at = |p: &ReliabilityPoint, share: f64| panel.at(100.0 * p.predicted, 100.0 * share);
        let means: Vec<(f64, f64)> = points.iter().map(|p| at(p, p.observed[0])).collect();
        if means.len() > 1 {
            sheet.line(&means, CURVE)?;
        }
        for p in points {
            let ends = [at(p, p.observed[1]), at(p, p.observed[2])];
            sheet.line(&ends, Pen { width: 2.0, ..CURVE })?;
            let (x, y) = at(p, p.observed[0]);
            sheet.disc((x, y), 7.0, BLUE)?;
            let count = p.paths.to_string();
            sheet.text(
                &count,
                (x + 14.0, y + 14.0),
                Type::plain(TICK).colored(INK),
                Anchor::Left,
            )?;
        }
        let words = Words { title: "", x: "predicted, %", y: "true, %" };
        panel.axes(sheet, words, &panel.y_ticks())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_drawn_also_of_one_bin_and_of_none() {
        let point = ReliabilityPoint { predicted: 0.5, observed: [0.4, 0.3, 0.5], paths: 3 };
        let [none, one] = [&[][..], &[point]].map(|p| reliability_curve(p, "t", "k").unwrap());
        assert!(one != none);
    }
}

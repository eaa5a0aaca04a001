//! Value axes of comparisons: linear or logarithmic, with a floor for values that are exact but for
//! rounding, and colours that stay with a method from figure to figure.

use super::panel::{Panel, ticks};
use super::sheet::{Anchor, Drawn, Sheet, Type};
use super::style::{BLUE, GREEN, GRID, INK, MUTED, ORANGE, OWN, Pen, SKY, Stroke, TICK, VERMILION};
use plotters::style::RGBColor;

/// Errors below this are those of rounding, in any unit used here: an exact hit.
pub(super) const EXACT: f64 = 1e-12;
/// Errors that differ by more than this factor are shown on a logarithmic scale.
const WIDE: f64 = 30.0;
/// Where exact values stand below the smallest other one, and where the panel ends, in parts of the
/// range.
const FLOOR: (f64, f64) = (0.13, 0.2);

/// A colour for the i-th method.
pub(super) fn method_color(i: usize) -> RGBColor {
    const ALL: [RGBColor; 8] = [MUTED, ORANGE, SKY, GREEN, VERMILION, BLUE, OWN.color, INK];
    ALL[i % ALL.len()]
}

/// How values become places along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Whether places are decimal logarithms.
    pub is_log: bool,
    /// First and last place.
    pub range: (f64, f64),
    /// The place of exact values below a logarithmic scale.
    pub floor: Option<f64>,
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mark {
    /// Its place.
    pub at: f64,
    /// What is written beside it; nothing beside marks between decades.
    pub label: String,
}

impl Axis {
    /// A logarithmic axis for positive values.
    pub(super) fn logarithmic(values: &[f64]) -> Self {
        let positive = values.iter().copied().filter(|v| *v > 0.0).map(f64::log10);
        let range = padded(span(positive).unwrap_or((0.0, 1.0)), 0.06, 0.05);
        Self { is_log: true, range, floor: None }
    }

    /// A linear axis.
    pub(super) fn linear(values: &[f64]) -> Self {
        let range = span(values.iter().copied()).unwrap_or((0.0, 1.0));
        let least = 1e-3 * range.0.abs().max(range.1.abs()).max(1e-9);
        Self { is_log: false, range: padded(range, 0.08, least), floor: None }
    }

    /// An axis for errors: from zero, or logarithmic where they differ widely, then with a floor for
    /// exact ones.
    pub(super) fn errors(values: &[f64]) -> Self {
        let inexact: Vec<f64> = values.iter().copied().filter(|v| *v > EXACT).collect();
        let Some((low, high)) = span(inexact.iter().copied()) else {
            return Self { is_log: false, range: (0.0, 1.0), floor: None };
        };
        if high / low <= WIDE {
            return Self { is_log: false, range: (0.0, 1.08 * high), floor: None };
        }
        let mut axis = Self::logarithmic(&inexact);
        if inexact.len() < values.len() {
            let (from, to) = axis.range;
            axis.floor = Some(from - FLOOR.0 * (to - from));
            axis.range.0 = from - FLOOR.1 * (to - from);
        }
        axis
    }

    /// The place of a value.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.floor {
            Some(floor) if value <= EXACT => floor,
            _ if self.is_log => value.max(f64::MIN_POSITIVE).log10().max(self.range.0),
            _ => value,
        }
    }

    /// Marks with room for about `most` labels.
    pub(super) fn marks(&self, most: usize) -> Vec<Mark> {
        if !self.is_log {
            let at = ticks(self.range, most);
            let step = at.get(1).map_or(1.0, |b| b - at[0]);
            let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
            return at.into_iter().map(|at| Mark { at, label: plain(at, digits) }).collect();
        }
        let mut marks: Vec<Mark> =
            self.floor.into_iter().map(|at| Mark { at, label: "exact".to_owned() }).collect();
        let from = self.floor.map_or(self.range.0, |f| 0.5 * (f + self.data_from()));
        marks.extend(decades((from, self.range.1), most));
        marks
    }

    /// Where the scale proper begins above a floor.
    fn data_from(&self) -> f64 {
        let (low, high) = self.range;
        if self.floor.is_some() { (low + FLOOR.1 * high) / (1.0 + FLOOR.1) } else { low }
    }

    /// Draws the grid across a panel whose y is this axis, ticks and their labels at the left.
    pub(super) fn draw_left(&self, sheet: &Sheet, panel: &Panel) -> Drawn {
        let (left, right) = panel.x_px;
        let thin = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
        let tick = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
        for mark in self.marks(((panel.y_px.1 - panel.y_px.0) / 46.0) as usize) {
            let (_, y) = panel.at(0.0, mark.at);
            if self.floor == Some(mark.at) {
                let dashes = Pen { color: MUTED, stroke: Stroke::Dashed, ..thin };
                sheet.line(&[(left, y), (right, y)], dashes)?;
            } else if !mark.label.is_empty() {
                sheet.line(&[(left, y), (right, y)], thin)?;
            }
            let long = if mark.label.is_empty() { 4.0 } else { 7.0 };
            sheet.line(&[(left - long, y), (left, y)], tick)?;
            sheet.text(&mark.label, (left - 12.0, y), Type::plain(TICK), Anchor::Right)?;
        }
        Ok(())
    }

    /// Draws the sign for a gap in the axis between the floor and the scale.
    pub(super) fn draw_gap(&self, sheet: &Sheet, panel: &Panel) -> Drawn {
        let Some(floor) = self.floor else { return Ok(()) };
        let (_, y) = panel.at(0.0, 0.5 * (floor + self.data_from()));
        let x = panel.x_px.0;
        sheet.fill((x - 3.0, y - 4.0), (x + 3.0, y + 4.0), super::style::WHITE)?;
        for dy in [-4.0, 4.0] {
            let pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
            sheet.line(&[(x - 9.0, y + dy + 4.0), (x + 9.0, y + dy - 4.0)], pen)?;
        }
        Ok(())
    }
}

/// Least and largest finite value.
fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).map(|v| (v, v)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn padded((low, high): (f64, f64), share: f64, least: f64) -> (f64, f64) {
    let by = (share * (high - low)).max(least);
    (low - by, high + by)
}

/// Marks of a logarithmic axis: 1, 2, 5 over a short range, decades over a long one, and then every
/// second or third.
fn decades((low, high): (f64, f64), most: usize) -> Vec<Mark> {
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let is_inside = |at: f64| at >= low - 1e-9 && at <= high + 1e-9;
    let is_short = high - low < 2.2;
    let whole: i32 = (first..=last).map(|e| i32::from(is_inside(f64::from(e)))).sum();
    let every = (whole - 1).max(0) / i32::try_from(most.max(1)).unwrap_or(i32::MAX) + 1;
    let superscript = low < -3.2 || high > 5.2;
    let mut marks = Vec::new();
    for exponent in first..=last {
        for factor in [1_u8, 2, 5] {
            let at = f64::from(exponent) + f64::from(factor).log10();
            let is_labelled = if factor == 1 { exponent % every == 0 } else { is_short };
            if !is_inside(at) || (factor > 1 && every > 1) {
                continue;
            }
            let label = match is_labelled {
                false => String::new(),
                true if superscript && factor == 1 => format!("10{}", raised(exponent)),
                true if superscript => format!("{factor}\u{b7}10{}", raised(exponent)),
                true => plain(10_f64.powf(at), (-exponent).max(0) as usize),
            };
            marks.push(Mark { at, label });
        }
    }
    marks
}

/// A number with some decimals and a true minus sign.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    if is_zero { "0".to_owned() } else { text.replace('-', "\u{2212}") }
}

/// An exponent in raised digits.
fn raised(exponent: i32) -> String {
    let digit = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    exponent.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_choose_their_scale() {
        let near = Axis::errors(&[0.01, 0.2]);
        assert!(!near.is_log && near.range.0 == 0.0);
        let wide = Axis::errors(&[1e-4, 0.2]);
        assert!(wide.is_log && wide.floor.is_none());
        let exact = Axis::errors(&[0.0, 7e-17, 4e-5, 0.2]);
        let floor = exact.floor.unwrap();
        assert_eq!((exact.place(0.0), exact.place(7e-17)), (floor, floor));
        assert!(exact.range.0 < floor && floor < exact.place(4e-5));
        assert_eq!(exact.marks(8)[0].label, "exact");
        assert!(!Axis::errors(&[0.0, 0.0]).is_log);
        assert!(!Axis::errors(&[]).is_log);
    }

    #[test]
    fn marks_are_readable() {
        let labels = |axis: Axis| -> Vec<String> {
            axis.marks(8).into_iter().map(|m| m.label).filter(|l| !l.is_empty()).collect()
        };
        let log = |low, high| Axis { is_log: true, range: (low, high), floor: None };
        assert_eq!(labels(log(1.9, 3.1)), ["100", "200", "500", "1000"]);
        assert_eq!(labels(log(-5.1, -2.5)), ["10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert_eq!(labels(log(-2.1, 0.5)), ["0.01", "0.1", "1"]);
        let linear = Axis::linear(&[-2.0, 16.0]);
        assert_eq!(labels(linear), ["0", "5", "10", "15"]);
        assert_eq!(labels(Axis::errors(&[0.01, 0.1]))[..2], ["0", "0.02"]);
    }
}

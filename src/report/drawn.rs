//! For tests: what a figure consists of, noted while a [`super::sheet::Sheet`] draws it.

use super::ReportError;
use super::sheet::At;
use super::style::{MUTED, Pen, Stroke};
use plotters::style::RGBColor;
use std::cell::RefCell;

/// One thing on a sheet, places in px.
#[derive(Debug, Clone)]
pub(super) enum Mark {
    Line(Vec<At>, Pen),
    /// A filled shape by its corners.
    Area(Vec<At>, RGBColor),
    Disc(At, RGBColor),
    Text(String),
}

thread_local! {
    static NOTED: RefCell<Vec<Mark>> = const { RefCell::new(Vec::new()) };
}

pub(super) fn note(mark: Mark) {
    NOTED.with_borrow_mut(|noted| noted.push(mark));
}

/// Draws a figure, which must be a PNG, and tells what is on it.
pub(super) fn drawn(figure: impl FnOnce() -> Result<Vec<u8>, ReportError>) -> Figure {
    NOTED.take();
    let bytes = figure().unwrap();
    assert!(bytes.starts_with(b"\x89PNG"));
    Figure(NOTED.take())
}

/// Everything on a figure in the order in which it was drawn.
#[derive(Debug)]
pub(super) struct Figure(pub Vec<Mark>);

impl Figure {
    /// How often exactly these words stand on it.
    pub(super) fn says(&self, words: &str) -> usize {
        self.0.iter().filter(|m| matches!(m, Mark::Text(text) if text == words)).count()
    }

    /// How many texts contain these words.
    pub(super) fn mentions(&self, words: &str) -> usize {
        self.0.iter().filter(|m| matches!(m, Mark::Text(text) if text.contains(words))).count()
    }

    /// The lines of a pen.
    pub(super) fn lines(&self, of: Pen) -> Vec<&[At]> {
        let line = |m: &'_ Mark| matches!(m, Mark::Line(_, pen) if *pen == of);
        self.0.iter().filter(|m| line(m)).filter_map(points).collect()
    }

    /// The lines of a pen with more points than a key of the legend has.
    pub(super) fn curves(&self, of: Pen) -> Vec<&[At]> {
        self.lines(of).into_iter().filter(|line| line.len() > 2).collect()
    }

    /// The filled shapes of a colour.
    pub(super) fn areas(&self, of: RGBColor) -> Vec<&[At]> {
        let area = |m: &'_ Mark| matches!(m, Mark::Area(_, color) if *color == of);
        self.0.iter().filter(|m| area(m)).filter_map(points).collect()
    }

    /// Middles of the discs of a colour.
    pub(super) fn discs(&self, of: RGBColor) -> Vec<At> {
        let disc = |m: &Mark| match m {
            Mark::Disc(at, color) if *color == of => Some(*at),
            _ => None,
        };
        self.0.iter().filter_map(disc).collect()
    }

    /// The words of each key of the legend that shows this pen: they follow on its sample.
    pub(super) fn keys_of_line(&self, of: Pen) -> Vec<&str> {
        let of_pair = |pair: &'_ [Mark]| matches!(pair, [Mark::Line(points, pen), Mark::Text(_)] if *pen == of && points.len() == 2);
        self.0.windows(2).filter(|p| of_pair(p)).filter_map(|p| text(&p[1])).collect()
    }

    /// Asserts that so many panels have a frame and numbers, and how often each word stands beside axes.
    pub(super) fn assert_axes(&self, panels: usize, words: &[(&str, usize)]) {
        let frame = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
        let frames = self.lines(frame).into_iter().filter(|line| line.len() == 5).count();
        let is_number = |t: &str| t.replace('\u{2212}', "-").parse::<f64>().is_ok();
        let numbers = self.0.iter().filter_map(text).filter(|t| is_number(t)).count();
        assert!(frames >= panels && numbers >= 4 * panels, "{frames} frames, {numbers} numbers");
        for (word, count) in words {
            assert_eq!(self.says(word), *count, "{word}");
        }
    }
}

fn points(mark: &Mark) -> Option<&[At]> {
    match mark {
        Mark::Line(points, _) | Mark::Area(points, _) => Some(points),
        _ => None,
    }
}

fn text(mark: &Mark) -> Option<&str> {
    match mark {
        Mark::Text(text) => Some(text),
        _ => None,
    }
}

/// Whether places along one axis are those of values: one straight line maps all, upwards (`way` -1:
/// towards smaller px) or to the right (1).
pub(super) fn is_scaled(px: &[f64], values: &[f64], way: f64) -> bool {
    let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    let ends = (0..values.len()).min_by(by).zip((0..values.len()).max_by(by));
    let Some((low, high)) = ends else { return false };
    let slope = (px[high] - px[low]) / (values[high] - values[low]).max(1e-12);
    let straight = |(p, v): (&f64, &f64)| (p - px[low] - slope * (v - values[low])).abs() < 1e-6;
    px.len() == values.len() && slope * way >= 0.0 && px.iter().zip(values).all(straight)
}

/// Whether a curve is that of values over others.
pub(super) fn is_graph(curve: &[At], x: &[f64], y: &[f64]) -> bool {
    let (right, down): (Vec<f64>, Vec<f64>) = curve.iter().copied().unzip();
    is_scaled(&right, x, 1.0) && is_scaled(&down, y, -1.0)
}

//! The look of every figure and of the bars in the pages: colours, sizes, names of levels.
//!
//! Colours are those of Okabe and Ito, which people with the common forms of colour blindness tell
//! apart; wherever colour carries meaning, a label, a line style or a marker carries it too.

use crate::ergonomics::ScoringMethod;
use crate::human::SegmentKind;
use plotters::style::RGBColor;

/// Name under which the embedded font is registered.
pub(super) const FONT: &str = "ergopath";

pub(super) const WHITE: RGBColor = RGBColor(255, 255, 255);
pub(super) const INK: RGBColor = RGBColor(26, 32, 44);
pub(super) const MUTED: RGBColor = RGBColor(84, 94, 110);
pub(super) const GRID: RGBColor = RGBColor(222, 226, 232);
pub(super) const FAINT: RGBColor = RGBColor(160, 168, 180);
pub(super) const OBSTACLE: RGBColor = RGBColor(214, 218, 224);

pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const SKY: RGBColor = RGBColor(86, 180, 233);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const YELLOW: RGBColor = RGBColor(240, 228, 66);
pub(super) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(super) const VERMILION: RGBColor = RGBColor(213, 94, 0);

/// The mannequin's shirt where it has not the colour of a score.
pub(super) const SHIRT: RGBColor = RGBColor(150, 168, 192);

/// Colour of a mannequin's segments; none for the shirt, which may show a score.
pub(super) fn segment_color(kind: SegmentKind) -> Option<RGBColor> {
    use SegmentKind as K;
    match kind {
        K::Head | K::Hand => Some(RGBColor(222, 192, 165)),
        K::Hair => Some(RGBColor(92, 78, 70)),
        K::Trunk | K::UpperArm | K::Forearm => None,
        K::Pelvis | K::Thigh | K::Shank => Some(RGBColor(92, 106, 128)),
        K::Stool => Some(RGBColor(176, 182, 192)),
        K::Foot => Some(RGBColor(48, 55, 68)),
    }
}

/// Sizes of text, px of the finished figure.
pub(super) const TITLE: f64 = 26.0;
pub(super) const LABEL: f64 = 22.0;
pub(super) const TICK: f64 = 20.0;

/// One action level of a score.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// Its number.
    pub number: u8,
    /// Lowest and highest score of the level.
    pub scores: (u8, u8),
    /// Colour of its bars; mixed with white it is the ground of curves.
    pub color: RGBColor,
    /// What it asks for, in a word or two.
    pub words: &'static str,
}

/// The action levels of a scoring method, from the lowest.
pub(super) fn method_levels(method: ScoringMethod) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for score in 1..=method.worst() {
        let number = method.level(score);
        match levels.last_mut().filter(|l| l.number == number) {
            Some(level) => level.scores.1 = score,
            None => levels.push(Level {
                number,
                scores: (score, score),
                color: LEVEL_COLORS[usize::from(number).min(LEVEL_COLORS.len() - 1)],
                words: method.level_short(number),
            }),
        }
    }
    levels
}

/// By the number of an action level: the same colour asks for the same haste, whatever the method.
const LEVEL_COLORS: [RGBColor; 5] = [SKY, GREEN, YELLOW, ORANGE, VERMILION];

impl Level {
    /// Its scores as text: `5-6`, or `7`.
    pub(super) fn range(&self) -> String {
        let (low, high) = self.scores;
        if low == high { low.to_string() } else { format!("{low}-{high}") }
    }

    /// Share of the time in this level, from the shares at `k` or above.
    pub(super) fn share(&self, at_least: &[f64]) -> f64 {
        let of = |k: u8| at_least.get(usize::from(k)).copied().unwrap_or(0.0);
        let from = if self.scores.0 <= 1 { 1.0 } else { of(self.scores.0) };
        (from - of(self.scores.1 + 1)).max(0.0)
    }
}

/// A colour mixed with white: `strength` 1 leaves it, 0 is white.
pub(super) fn tint(color: RGBColor, strength: f64) -> RGBColor {
    let mix = |c: u8| (255.0 + (f64::from(c) - 255.0) * strength).round() as u8;
    RGBColor(mix(color.0), mix(color.1), mix(color.2))
}

/// A colour as CSS.
pub(super) fn css(color: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", color.0, color.1, color.2)
}

/// How a line is broken, px of the finished figure: drawn, left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stroke {
    /// Unbroken.
    Solid,
    /// Dashes.
    Dashed,
    /// Short dashes.
    Dotted,
}

impl Stroke {
    /// As the style of a border in CSS.
    pub(super) fn css(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::Dashed => "dashed",
            Self::Dotted => "dotted",
        }
    }
}

/// How one path is drawn wherever it appears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pen {
    pub color: RGBColor,
    pub width: f64,
    pub stroke: Stroke,
}

/// The best path.
pub(super) const BEST: Pen = Pen { color: BLUE, width: 5.0, stroke: Stroke::Solid };
/// The straight path.
pub(super) const STRAIGHT: Pen = Pen { color: INK, width: 3.5, stroke: Stroke::Dashed };
/// The user's own path.
pub(super) const OWN: Pen =
    Pen { color: RGBColor(166, 64, 122), width: 4.0, stroke: Stroke::Dotted };
/// Other paths of the report.
pub(super) const OTHER: Pen = Pen { color: FAINT, width: 1.8, stroke: Stroke::Solid };

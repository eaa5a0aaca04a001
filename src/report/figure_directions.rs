//! Figure: the keys that say where tool, hand and robot are and which way they point.

use super::ReportError;
use super::figure_grips::flat;
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{BLUE, GRID, INK, LABEL, MUTED, ORANGE, Pen, Stroke, TICK, VERMILION};
use crate::math::Vec3;
use plotters::style::RGBColor;

const SIZE: (u32, u32) = (1600, 560);
const STEEL: RGBColor = RGBColor(120, 130, 145);
/// Length of an arrow, m.
const ARROW_M: f64 = 0.15;
/// How far before the tool the hand is, m.
const BEFORE_M: f64 = 0.12;

/// The keys of poses as PNG.
pub fn directions_figure() -> Result<Vec<u8>, ReportError> {
    png("directions", SIZE, |sheet| {
        tool_from_above(&Picture { sheet, middle: (270.0, 270.0) })?;
        tool_at_worker(&Picture { sheet, middle: (800.0, 330.0) })?;
        base(&Picture { sheet, middle: (1310.0, 390.0) })?;
        let kind = Type::plain(TICK).colored(MUTED);
        let words =
            "Seen from behind the worker, from the right and from above; the worker looks ahead.";
        sheet.text(words, (800.0, 535.0), kind, Anchor::Middle)
    })
}

/// One drawing about a point of the sheet.
struct Picture<'a, 's> {
    sheet: &'a Sheet<'s>,
    middle: At,
}

impl Picture<'_, '_> {
    fn at(&self, p: Vec3) -> At {
        let (x, y) = flat(&p);
        (self.middle.0 + x, self.middle.1 + y)
    }

    fn title(&self, words: &str) -> Drawn {
        self.sheet.text(words, (self.middle.0, 36.0), Type::bold(LABEL), Anchor::Middle)
    }

    fn line(&self, points: &[Vec3], width: f64, color: RGBColor) -> Drawn {
        let points: Vec<At> = points.iter().map(|p| self.at(*p)).collect();
        self.sheet.line(&points, Pen { color, width, stroke: Stroke::Solid })
    }

    /// A flat round face across an axis.
    fn face(&self, middle: Vec3, across: [Vec3; 2], radius_m: f64) -> Drawn {
        let corner = |i: u32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 40.0).sin_cos();
            self.at(middle + radius_m * (cos * across[0] + sin * across[1]))
        };
        let corners: Vec<At> = (0..40).map(corner).collect();
        self.sheet.shape(&corners, STEEL, 1.0)
    }

    /// An arrow with its key at the tip.
    fn arrow(
        &self,
        (from, way): (Vec3, Vec3),
        (key, color): (&str, RGBColor),
        anchor: Anchor,
    ) -> Drawn {
        let (a, b) = (self.at(from), self.at(from + ARROW_M * way));
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        let (ux, uy) = ((b.0 - a.0) / length, (b.1 - a.1) / length);
        let end = (b.0 - 14.0 * ux, b.1 - 14.0 * uy);
        self.sheet.line(&[a, end], Pen { color, width: 5.0, stroke: Stroke::Solid })?;
        let wing =
            |side: f64| (b.0 - 20.0 * ux - side * 9.0 * uy, b.1 - 20.0 * uy + side * 9.0 * ux);
        self.sheet.shape(&[b, wing(1.0), wing(-1.0)], color, 1.0)?;
        let off = (b.0 + 12.0 * ux, b.1 + 20.0 * uy);
        self.sheet.label(key, off, Type::bold(TICK).colored(color), anchor)
    }

    /// A place with its key.
    fn place(&self, p: Vec3, key: &str, color: RGBColor, (dx, dy): At, anchor: Anchor) -> Drawn {
        let (x, y) = self.at(p);
        self.sheet.disc((x, y), 9.0, color)?;
        self.sheet.label(key, (x + dx, y + dy), Type::bold(TICK).colored(color), anchor)
    }
}

fn tool_from_above(p: &Picture) -> Drawn {
    p.title("A tool that points down, a bar across")?;
    let hand = -BEFORE_M * Vec3::z();
    p.line(&[0.2 * Vec3::z(), Vec3::zeros()], 16.0, STEEL)?;
    p.face(0.2 * Vec3::z(), [Vec3::x(), Vec3::y()], 0.045)?;
    p.arrow((hand, 1.25 * Vec3::y()), ("bar_along", ORANGE), Anchor::Right)?;
    p.line(&[hand - 0.1 * Vec3::y(), hand + 0.1 * Vec3::y()], 16.0, ORANGE)?;
    p.line(&[Vec3::zeros(), hand], 6.0, STEEL)?;
    p.arrow((Vec3::zeros(), 1.2 * Vec3::x()), ("x_along", BLUE), Anchor::Left)?;
    p.arrow((hand - 0.02 * Vec3::z(), -0.8 * Vec3::z()), ("pointing", VERMILION), Anchor::Middle)?;
    p.place(Vec3::zeros(), "position_m (TCP)", INK, (-20.0, -26.0), Anchor::Right)?;
    p.place(hand, "hand_at_m", INK, (26.0, 34.0), Anchor::Left)
}

fn tool_at_worker(p: &Picture) -> Drawn {
    p.title("A tool that points at the worker, an upright handle")?;
    let hand = -BEFORE_M * Vec3::x();
    p.line(&[0.2 * Vec3::x(), Vec3::zeros()], 16.0, STEEL)?;
    p.face(0.2 * Vec3::x(), [Vec3::z(), Vec3::y()], 0.045)?;
    p.line(&[Vec3::zeros(), hand], 6.0, STEEL)?;
    p.line(&[hand - 0.1 * Vec3::z(), hand + 0.1 * Vec3::z()], 16.0, ORANGE)?;
    p.arrow((hand + 0.1 * Vec3::z(), 0.5 * Vec3::z()), ("bar_along", ORANGE), Anchor::Right)?;
    p.arrow((Vec3::zeros(), 1.1 * Vec3::z()), ("x_along", BLUE), Anchor::Left)?;
    p.arrow((hand - 0.02 * Vec3::x(), -0.8 * Vec3::x()), ("pointing", VERMILION), Anchor::Right)?;
    p.place(Vec3::zeros(), "position_m (TCP)", INK, (18.0, 16.0), Anchor::Left)?;
    p.place(hand, "hand_at_m", INK, (-18.0, -10.0), Anchor::Right)
}

fn base(p: &Picture) -> Drawn {
    p.title("The base of the robot")?;
    let (floor, top) = (Vec3::zeros(), 0.22 * Vec3::z());
    for i in -2..=2 {
        let along = 0.08 * f64::from(i);
        let ends = |a: Vec3, b: Vec3| [a * along - 0.16 * b, a * along + 0.16 * b];
        p.line(&ends(Vec3::x(), Vec3::y()), 2.0, GRID)?;
        p.line(&ends(Vec3::y(), Vec3::x()), 2.0, GRID)?;
    }
    p.line(&[floor, top], 34.0, STEEL)?;
    p.face(top, [Vec3::x(), Vec3::y()], 0.06)?;
    p.arrow((top, 1.1 * Vec3::z()), ("pointing (up without it)", VERMILION), Anchor::Middle)?;
    p.arrow((top, -1.2 * Vec3::x()), ("x_along", BLUE), Anchor::Right)?;
    let side = 0.1 * Vec3::x() - 0.06 * Vec3::y();
    p.line(&[floor + side, top + side], 2.0, MUTED)?;
    let (x, y) = p.at(0.5 * top + side);
    let kind = Type::bold(TICK).colored(INK);
    p.sheet.label("mount_height_m", (x + 10.0, y), kind, Anchor::Left)?;
    p.place(top, "position_m", INK, (-40.0, -22.0), Anchor::Right)?;
    p.place(floor, "at_m", INK, (-22.0, 20.0), Anchor::Right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::drawn::drawn;

    #[test]
    fn every_key_is_shown() {
        let figure = drawn(directions_figure);
        for key in ["bar_along", "x_along", "hand_at_m", "mount_height_m", "at_m"] {
            assert!(figure.says(key) > 0, "{key}");
        }
        assert_eq!(figure.mentions("pointing"), 3);
    }
}

//! Figure: the named grips, each as a pair of hands on what they hold, seen over the worker's right shoulder.

use super::ReportError;
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{GRID, INK, LABEL, MUTED, Pen, SHIRT, Stroke, TICK, segment_color};
use crate::human::{NamedGrip, SegmentKind, Side};
use crate::math::Vec3;
use plotters::style::RGBColor;

const SIZE: (u32, u32) = (1600, 900);
/// Pictures in a row.
const COLUMNS: usize = 4;
const CELL: (f64, f64) = (400.0, 430.0);
/// Pixels of a metre.
const SCALE: f64 = 620.0;
/// How far apart the hands are drawn, m.
const APART_M: f64 = 0.27;
/// What is held.
const HELD: RGBColor = RGBColor(150, 110, 60);
/// Width of the dark rim around pieces, and how far behind them it lies.
const RIM_PX: f64 = 2.0;
const RIM_BEHIND_M: f64 = 0.025;
/// Length of the pieces by which near and far are told, m.
const PIECE_M: f64 = 0.004;

/// A thick line in space.
struct Stroke3 {
    from: Vec3,
    to: Vec3,
    width_m: f64,
    color: RGBColor,
}

/// The grips as PNG.
pub fn grips_figure() -> Result<Vec<u8>, ReportError> {
    png("grips", SIZE, |sheet| {
        for (i, grip) in NamedGrip::ALL.into_iter().enumerate() {
            let corner = (CELL.0 * (i % COLUMNS) as f64, CELL.1 * (i / COLUMNS) as f64);
            pair(sheet, grip, corner)?;
        }
        let last = NamedGrip::ALL.len();
        let corner = (CELL.0 * (last % COLUMNS) as f64, CELL.1 * (last / COLUMNS) as f64);
        directions(sheet, corner)
    })
}

/// A point of the worker's frame (x ahead, y left, z up) in px from a picture's middle: seen from behind, from
/// the right and from above.
pub(super) fn flat(p: &Vec3) -> At {
    let (right, up) = axes();
    (SCALE * right.dot(p), -SCALE * up.dot(p))
}

/// Directions to the right and upwards in the pictures.
fn axes() -> (Vec3, Vec3) {
    let towards_eye = Vec3::new(-0.62, -0.52, 0.59).normalize();
    let right = Vec3::z().cross(&towards_eye).normalize();
    (right, towards_eye.cross(&right))
}

fn pair(sheet: &Sheet, grip: NamedGrip, corner: At) -> Drawn {
    let mut strokes = Vec::new();
    for side in [Side::Right, Side::Left] {
        let left = match side {
            Side::Right => -0.5,
            Side::Left => 0.5,
        };
        strokes.extend(hand(grip, side, Vec3::y() * left * APART_M));
    }
    let middle = (corner.0 + 0.5 * CELL.0, corner.1 + 0.58 * CELL.1);
    draw(sheet, &strokes, middle)?;
    let title = Type::bold(LABEL);
    sheet.text(grip.name(), (corner.0 + 0.5 * CELL.0, corner.1 + 34.0), title, Anchor::Middle)?;
    let words = match grip {
        NamedGrip::PalmDownBar => "bar across, from above",
        NamedGrip::PalmUpBar => "bar across, from below",
        NamedGrip::VerticalHandle => "upright bar, thumb up",
        NamedGrip::SuitcaseHandle => "bar that runs ahead, arm hanging",
        NamedGrip::OverheadBar => "bar across, above the head",
        NamedGrip::BoxSide => "flat on the sides, fingers 30 deg down",
        NamedGrip::PinchFromAbove => "fingertips, from above and behind",
    };
    let kind = Type::plain(TICK).colored(MUTED);
    sheet.text(words, (corner.0 + 0.5 * CELL.0, corner.1 + 64.0), kind, Anchor::Middle)
}

/// A hand with its forearm and what it holds.
fn hand(grip: NamedGrip, side: Side, at: Vec3) -> Vec<Stroke3> {
    let turn = grip.turn(side);
    // Drawn as a right hand whose x axis is out of the palm.
    let out = match side {
        Side::Right => 1.0,
        Side::Left => -1.0,
    };
    let skin = segment_color(SegmentKind::Hand).unwrap_or(SHIRT);
    let mut all = Vec::new();
    let mut line = |points: &[[f64; 3]], width_m: f64, color: RGBColor| {
        let placed = |p: &[f64; 3]| at + turn * Vec3::new(out * p[0], p[1], p[2]);
        for two in points.windows(2) {
            all.push(Stroke3 { from: placed(&two[0]), to: placed(&two[1]), width_m, color });
        }
    };
    // Forearm and palm; the wrist is 0.09 m from the middle of the grip.
    line(&[[-0.03, 0.10, 0.0], [-0.035, 0.27, 0.0]], 0.056, SHIRT);
    for z in [-0.028, -0.009, 0.009, 0.028] {
        line(&[[-0.03, 0.10, 0.4 * z], [-0.032, 0.055, 0.9 * z], [-0.032, 0.005, z]], 0.0215, skin);
    }
    let curled =
        [[-0.032, 0.005], [-0.026, -0.026], [0.004, -0.036], [0.028, -0.018], [0.026, 0.008]];
    let flat = [[-0.032, 0.005], [-0.028, -0.035], [-0.022, -0.065], [-0.018, -0.085]];
    let pinching = [[-0.032, 0.005], [-0.022, -0.035], [0.004, -0.06], [0.024, -0.072]];
    let (finger, thumb): (&[[f64; 2]], [[f64; 3]; 4]) = match grip {
        NamedGrip::BoxSide => (
            &flat,
            [
                [-0.03, 0.075, 0.02],
                [-0.024, 0.05, 0.045],
                [-0.02, 0.025, 0.066],
                [-0.016, 0.0, 0.076],
            ],
        ),
        NamedGrip::PinchFromAbove => (
            &pinching,
            [
                [-0.03, 0.075, 0.02],
                [-0.005, 0.04, 0.036],
                [0.02, 0.0, 0.026],
                [0.033, -0.04, 0.012],
            ],
        ),
        _ => (
            &curled,
            [
                [-0.03, 0.075, 0.02],
                [-0.008, 0.05, 0.042],
                [0.018, 0.028, 0.04],
                [0.032, 0.004, 0.034],
            ],
        ),
    };
    for z in [-0.028, -0.009, 0.009, 0.028] {
        let points: Vec<[f64; 3]> = finger.iter().map(|[x, y]| [*x, *y, z]).collect();
        line(&points, 0.0155, skin);
    }
    line(&thumb, 0.02, skin);
    match grip {
        NamedGrip::BoxSide => {
            let (y, z) = (0.10, 0.09);
            let rim = [[0.0, -y, -z], [0.0, y, -z], [0.0, y, z], [0.0, -y, z], [0.0, -y, -z]];
            line(&rim, 0.012, HELD);
        }
        NamedGrip::PinchFromAbove => line(&[[0.03, -0.05, 0.0], [0.03, -0.10, 0.0]], 0.02, HELD),
        _ => line(&[[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]], 0.026, HELD),
    }
    all
}

/// Draws far pieces first, about the middle of a picture.
fn draw(sheet: &Sheet, strokes: &[Stroke3], middle: At) -> Drawn {
    let (right, up) = axes();
    let towards_eye = right.cross(&up);
    let ends: Vec<At> = strokes.iter().flat_map(|s| [flat(&s.from), flat(&s.to)]).collect();
    let range = |of: fn(&At) -> f64| {
        let (low, high) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(of(p)), high.max(of(p)))
        });
        f64::midpoint(low, high)
    };
    let corner = (middle.0 - range(|p| p.0), middle.1 - range(|p| p.1));
    // A rim lies farther than its piece, so that it parts a piece from what is behind, not from its neighbour.
    let mut discs: Vec<(f64, At, f64, RGBColor)> = Vec::new();
    for s in strokes {
        let count = ((s.to - s.from).norm() / PIECE_M).ceil().max(1.0) as usize;
        for k in 0..=count {
            let p = s.from.lerp(&s.to, k as f64 / count as f64);
            let (x, y) = flat(&p);
            let at = (corner.0 + x, corner.1 + y);
            let (depth, radius) = (towards_eye.dot(&p), 0.5 * SCALE * s.width_m);
            discs.push((depth - RIM_BEHIND_M, at, radius + RIM_PX, INK));
            discs.push((depth, at, radius, s.color));
        }
    }
    discs.sort_by(|a, b| a.0.total_cmp(&b.0));
    discs
        .iter()
        .try_for_each(|(_, at, radius, color)| sheet.shape(&circle(*at, *radius), *color, 1.0))
}

fn circle((x, y): At, radius: f64) -> Vec<At> {
    let corner = |i: u32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 20.0).sin_cos();
        (x + radius * cos, y + radius * sin)
    };
    (0..20).map(corner).collect()
}

/// Which way is which.
fn directions(sheet: &Sheet, corner: At) -> Drawn {
    let middle = (corner.0 + 0.45 * CELL.0, corner.1 + 0.6 * CELL.1);
    for (way, words) in [(Vec3::x(), "ahead"), (Vec3::y(), "left"), (Vec3::z(), "up")] {
        let (x, y) = flat(&(0.14 * way));
        let pen = Pen { color: INK, width: 3.0, stroke: Stroke::Solid };
        sheet.line(&[middle, (middle.0 + x, middle.1 + y)], pen)?;
        let at = (middle.0 + 1.3 * x, middle.1 + 1.3 * y);
        sheet.text(words, at, Type::plain(LABEL), Anchor::Middle)?;
    }
    sheet.disc(middle, 5.0, GRID)?;
    let kind = Type::plain(TICK).colored(MUTED);
    sheet.paragraph(
        "The worker looks ahead; forearms are blue, what is held is brown. Seen from behind, from the right and from above.",
        (corner.0 + 40.0, corner.1 + 0.82 * CELL.1),
        CELL.0 - 70.0,
        kind,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::drawn::{Mark, drawn};

    #[test]
    fn every_grip_is_drawn_and_named() {
        let figure = drawn(grips_figure);
        for name in NamedGrip::names() {
            assert_eq!(figure.says(name), 1, "{name}");
        }
        // Nothing leaves the sheet.
        let inside = |(x, y): &At| (0.0..=1600.0).contains(x) && (0.0..=900.0).contains(y);
        let areas = figure.0.iter().filter_map(|m| match m {
            Mark::Area(corners, _) => Some(corners),
            _ => None,
        });
        assert!(areas.flatten().all(inside));
    }
}

//! A person in shape on a sheet: the outline of every piece, far ones first.

use super::figure_paths::Look;
use super::panel::Panel;
use super::sheet::{At, Drawn, Sheet};
use super::style::{Pen, SHIRT, Stroke, WHITE, segment_color};
use crate::human::SegmentKind;
use crate::math::Vec3;
use crate::planner::{PosedMannequin, SceneCapsule};
use plotters::style::RGBColor;
use std::f64::consts::TAU;

/// Corners of an outline.
const CORNERS: usize = 36;
/// Around pieces of one colour, so that an arm is told from the trunk behind it.
const RIM: Pen = Pen { color: WHITE, width: 2.0, stroke: Stroke::Solid };

/// Draws a mannequin.
pub(super) fn draw(sheet: &Sheet, person: &PosedMannequin, look: Look, panel: &Panel) -> Drawn {
    let points: Vec<Vec3> = person.points_m.iter().map(|p| Vec3::from(*p)).collect();
    let outlined = |c: &SceneCapsule| -> Vec<At> {
        let at = |p: Vec3| {
            let [x, y] = look.flat(p.into());
            panel.at(x, y)
        };
        outline(c, &points, look).map(at).collect()
    };
    for run in layers(person, &points, look).chunk_by(|a, b| a.0 == b.0) {
        let outlines: Vec<Vec<At>> = run.iter().map(|(_, c)| outlined(c)).collect();
        for outline in &outlines {
            sheet.line(outline, RIM)?;
        }
        for (outline, (_, piece)) in outlines.iter().zip(run) {
            sheet.shape(outline, color(piece), 1.0)?;
        }
    }
    Ok(())
}

fn color(piece: &SceneCapsule) -> RGBColor {
    piece.kind.and_then(segment_color).unwrap_or(SHIRT)
}

/// Which of two pieces hides the other: limbs behind the trunk, the trunk upwards, limbs before it, each
/// with its sleeves over the hands and its trousers over the shoes.
type Layer = (i8, u8);

/// The pieces with their layers, the hidden ones first.
fn layers<'a>(
    person: &'a PosedMannequin,
    points: &[Vec3],
    look: Look,
) -> Vec<(Layer, &'a SceneCapsule)> {
    use SegmentKind as K;
    let near = look.near();
    let depth = |c: &SceneCapsule| c.ends.map(|e| points[e].dot(&near)).iter().sum::<f64>();
    let pelvis = person.capsules.iter().find(|c| c.kind == Some(K::Pelvis)).map_or(0.0, depth);
    let layer = |c: &SceneCapsule| -> Layer {
        let side = if depth(c) < pelvis { -1 } else { 1 };
        match c.kind {
            Some(K::Stool) => (-2, 0),
            Some(K::Foot) => (side, 0),
            Some(K::Thigh | K::Shank) => (side, 1),
            Some(K::Hand) => (side, 2),
            Some(K::UpperArm | K::Forearm) => (side, 3),
            Some(K::Pelvis) => (0, 0),
            Some(K::Head) => (0, 1),
            Some(K::Trunk) | None => (0, 2),
            Some(K::Hair) => (0, 3),
        }
    };
    let mut pieces: Vec<_> = person.capsules.iter().map(|c| (layer(c), c)).collect();
    pieces.sort_by_key(|(layer, _)| *layer);
    pieces
}

/// Lowest and highest corner of a mannequin in a view, m.
pub(super) fn extent(person: &PosedMannequin, look: Look) -> Option<([f64; 2], [f64; 2])> {
    let points: Vec<Vec3> = person.points_m.iter().map(|p| Vec3::from(*p)).collect();
    let all = person.capsules.iter().flat_map(|c| outline(c, &points, look).collect::<Vec<_>>());
    super::figure_paths::extent(all.map(|p| look.flat(p.into())))
}

/// The points of a piece that are farthest in each direction of the view, all the way round.
fn outline<'a>(
    piece: &'a SceneCapsule,
    points: &'a [Vec3],
    look: Look,
) -> impl Iterator<Item = Vec3> + 'a {
    let outline = Outline::of(piece, points);
    let [right, up] = look.axes();
    (0..=CORNERS).map(move |i| {
        let (sin, cos) = (TAU * i as f64 / CORNERS as f64).sin_cos();
        outline.farthest(&(right * cos + up * sin))
    })
}

/// A piece as the hull of an ellipsoid at each end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    /// Middle and half axes; the first axis leads to the point towards which the piece is wide.
    ellipsoids: [(Vec3, [Vec3; 3]); 2],
    is_foot: bool,
}

impl Outline {
    /// Of a piece between its points.
    pub(super) fn of(piece: &SceneCapsule, points: &[Vec3]) -> Self {
        let [a, b] = piece.ends.map(|e| points[e]);
        let along = (b - a).try_normalize(1e-9).unwrap_or_else(Vec3::z);
        let ellipsoids = [0, 1].map(|e| {
            let middle = points[piece.ends[e]];
            let radius = 1e-3 * f64::from(piece.radii_mm[e]);
            let (toward, wide) = match &piece.wide {
                Some(w) => (points[w.toward[e]] - middle, 1e-3 * f64::from(w.radii_mm[e])),
                None => (along.cross(&Vec3::x()) + 1e-3 * along.cross(&Vec3::y()), radius),
            };
            let square = toward - along * toward.dot(&along);
            let u = square.try_normalize(1e-9).unwrap_or_else(|| along.cross(&Vec3::y()));
            (middle, [u * wide, along.cross(&u) * radius, along * radius.min(wide)])
        });
        Self { ellipsoids, is_foot: piece.kind == Some(SegmentKind::Foot) }
    }

    /// The point that is farthest in a direction.
    pub(super) fn farthest(&self, toward: &Vec3) -> Vec3 {
        let [a, b] = self.ellipsoids.map(|(middle, axes)| {
            let reach = axes.map(|a| a.dot(toward));
            let mut off = axes[0] * reach[0] + axes[1] * reach[1] + axes[2] * reach[2];
            off /= reach.iter().map(|r| r * r).sum::<f64>().sqrt().max(1e-9);
            if self.is_foot {
                // Nothing is below a sole.
                let normal = axes[0].normalize();
                off -= normal * off.dot(&normal).min(0.0);
            }
            middle + off
        });
        if a.dot(toward) > b.dot(toward) { a } else { b }
    }
}

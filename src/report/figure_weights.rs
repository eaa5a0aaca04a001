//! `weights.png` of a training: the learned weight of every joint with its jackknife interval.

use super::ReportError;
use super::panel::Panel;
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{BLUE, GRID, INK, LABEL, MUTED, Pen, Stroke, TICK, TITLE};
use super::value_axis::Axis;
use crate::training::{JointWeight, WeightSpread};

/// Width of the figure, left and right edge of the panel, px.
const WIDE: f64 = 1400.0;
const X_PX: (f64, f64) = (460.0, 1360.0);
/// Top of the panel, height of a row, room between groups of joints, room below the panel, px.
const TOP: f64 = 84.0;
const ROW: f64 = 31.0;
const GAP: f64 = 14.0;
const BELOW: f64 = 270.0;
/// Left end of the groups' names and of the notes, px.
const LEFT: f64 = 40.0;

/// Whose training a figure shows.
#[derive(Debug, Clone, Copy)]
pub struct Learned<'a> {
    /// Name of the posture model.
    pub model: &'a str,
    /// Whether the movements are those of a simulated operator.
    pub is_simulated: bool,
}

impl Learned<'_> {
    /// The model in words.
    pub(super) fn words(&self) -> String {
        let Self { model, is_simulated } = self;
        let is_said = !is_simulated || model.contains("simulated");
        format!("`{model}`{}", if is_said { "" } else { " (simulated operator)" })
    }
}

/// A row for each joint in the order of the chain: dot and interval on a logarithmic axis, as PNG.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn weights_figure(spread: &WeightSpread, whose: &Learned) -> Result<Vec<u8>, ReportError> {
    let rows = rows(&spread.joints);
    let bottom = rows.last().map_or(TOP + ROW, |(y, _)| y + 0.5 * ROW);
    png("weights", (WIDE as u32, (bottom + BELOW) as u32), |sheet| {
        let axis = axis(&spread.joints);
        let panel = Panel { x_px: X_PX, y_px: (TOP, bottom), x: axis.range, y: (0.0, 1.0) };
        let title =
            format!("Weight W of each joint with its 95 % interval ({})", spread.method.name());
        sheet.text(&title, (LEFT, 36.0), Type::bold(TITLE), Anchor::Left)?;
        scale(sheet, &panel, &axis)?;
        names(sheet, &rows)?;
        for (y, joint) in &rows {
            draw(sheet, &panel, &axis, (*y, joint))?;
        }
        let muted = Type::plain(TICK).colored(MUTED);
        sheet.paragraph(&note(spread, whose), (LEFT, bottom + 108.0), WIDE - 2.0 * LEFT, muted)
    })
}

/// Middle of each joint's row, px.
fn rows(joints: &[JointWeight]) -> Vec<(f64, &JointWeight)> {
    let mut y = TOP + 0.5 * ROW;
    let mut rows: Vec<(f64, &JointWeight)> = Vec::new();
    for joint in joints {
        if let Some((last, above)) = rows.last() {
            y = last + ROW + if above.group == joint.group { 0.0 } else { GAP };
        }
        rows.push((y, joint));
    }
    rows
}

/// Reaches over all dots and intervals, and 1.
fn axis(joints: &[JointWeight]) -> Axis {
    let ends = joints.iter().filter_map(|j| j.interval).flat_map(|(low, high)| [low, high]);
    let values = joints.iter().map(|j| j.weight).chain(ends).chain([1.0]);
    Axis::logarithmic(&values.filter(|v| v.is_finite()).collect::<Vec<_>>())
}

/// Frame, grid, marks and words of the axis; a dashed line at the geometric mean.
fn scale(sheet: &Sheet, panel: &Panel, axis: &Axis) -> Drawn {
    let ((left, right), (top, bottom)) = (panel.x_px, panel.y_px);
    let thin = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
    let tick = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
    for mark in axis.marks(((right - left) / 90.0) as usize) {
        let (x, _) = panel.at(mark.at, 0.0);
        if !mark.label.is_empty() {
            sheet.line(&[(x, top), (x, bottom)], thin)?;
        }
        let long = if mark.label.is_empty() { 4.0 } else { 7.0 };
        sheet.line(&[(x, bottom), (x, bottom + long)], tick)?;
        sheet.text(&mark.label, (x, bottom + 24.0), Type::plain(TICK), Anchor::Middle)?;
    }
    let (one, _) = panel.at(axis.place(1.0), 0.0);
    let dashed = Pen { color: INK, width: 1.5, stroke: Stroke::Dashed };
    sheet.line(&[(one, top), (one, bottom)], dashed)?;
    sheet.outline((left, top), (right, bottom), MUTED, 1.5)?;
    let words = "diagonal of W over its geometric mean (no unit, logarithmic)";
    sheet.text(words, (0.5 * (left + right), bottom + 60.0), Type::plain(LABEL), Anchor::Middle)
}

/// Names of joints beside their rows, of groups further left, with a line between groups.
fn names(sheet: &Sheet, rows: &[(f64, &JointWeight)]) -> Drawn {
    let mut group = "";
    for (y, joint) in rows {
        if joint.group != group {
            let bold = Type::bold(TICK);
            sheet.text(joint.group, (LEFT, *y), bold, Anchor::Left)?;
            if !group.is_empty() {
                let pen = Pen { color: GRID, width: 1.5, stroke: Stroke::Solid };
                let between = y - 0.5 * (ROW + GAP);
                sheet.line(&[(LEFT, between), (X_PX.1, between)], pen)?;
            }
            group = joint.group;
        }
        let plain = Type::plain(TICK);
        let name = sheet.shortened(&joint.joint, X_PX.0 - LEFT - 130.0, plain);
        sheet.text(&name, (X_PX.0 - 14.0, *y), plain, Anchor::Right)?;
    }
    Ok(())
}

/// Interval and dot of one joint.
fn draw(sheet: &Sheet, panel: &Panel, axis: &Axis, (y, joint): (f64, &JointWeight)) -> Drawn {
    if !joint.weight.is_finite() || joint.weight <= 0.0 {
        let middle = 0.5 * (panel.x_px.0 + panel.x_px.1);
        let muted = Type::plain(TICK).colored(MUTED);
        return sheet.text("no value", (middle, y), muted, Anchor::Middle);
    }
    let x = |value: f64| panel.at(axis.place(value), 0.0).0.clamp(panel.x_px.0, panel.x_px.1);
    let pen = Pen { color: BLUE, width: 2.5, stroke: Stroke::Solid };
    if let Some((low, high)) = joint.interval.filter(|(a, b)| !a.is_nan() && !b.is_nan()) {
        sheet.line(&[(x(low), y), (x(high), y)], pen)?;
        for end in [x(low), x(high)] {
            sheet.line(&[(end, y - 7.0), (end, y + 7.0)], pen)?;
        }
    }
    sheet.disc((x(joint.weight), y), 5.5, pen.color)
}

/// What dots and bars are.
fn note(spread: &WeightSpread, whose: &Learned) -> String {
    let WeightSpread { blocks, trials, .. } = spread;
    let left_out = if *trials <= 1 {
        format!("each of {blocks} equal parts of the time")
    } else if trials > blocks {
        format!("each of {blocks} groups of the {trials} movements")
    } else {
        format!("each of the {trials} movements")
    };
    let bars = if spread.joints.iter().any(|j| j.interval.is_some()) {
        format!(
            "Bar: jackknife 95 % interval of its logarithm, from learning W again without {left_out} in \
             turn; joints whose bars overlap widely cannot be told apart."
        )
    } else {
        "No interval: there are too few data to leave some out.".to_owned()
    };
    format!(
        "Model {}. Dot: W learned on all frames. The larger, the more of the hand's movement the joint \
         takes over; W is known only up to its scale, so that 1 (dashed) is the joints' geometric mean. \
         {bars} Order from the pelvis to the hand; Z: flexion and extension, X: to the side, Y: turning \
         about the long axis.",
        whose.words()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::Method;

    fn spread(joints: Vec<JointWeight>) -> WeightSpread {
        WeightSpread { method: Method::FullW, joints, blocks: 5, trials: 16 }
    }

    fn joint(group: &'static str, weight: f64, interval: Option<(f64, f64)>) -> JointWeight {
        JointWeight { joint: format!("jRight{group}_Z"), group, weight, interval }
    }

    #[test]
    fn groups_stand_apart_and_in_order() {
        let joints =
            [joint("spine", 1.0, None), joint("spine", 2.0, None), joint("wrist", 3.0, None)];
        let rows: Vec<f64> = rows(&joints).into_iter().map(|r| r.0).collect();
        assert_eq!([rows[1] - rows[0], rows[2] - rows[1]], [ROW, ROW + GAP]);
        let range = axis(&[joint("spine", 2.0, Some((0.5, 8.0)))]).range;
        assert!(range.0 < 0.5_f64.log10() && range.1 > 8.0_f64.log10());
    }

    #[test]
    fn the_note_says_what_was_left_out() {
        let of = |blocks, trials| {
            let own = spread(vec![joint("spine", 2.0, Some((1.0, 4.0)))]);
            let whose = Learned { model: "anna", is_simulated: true };
            note(&WeightSpread { blocks, trials, ..own }, &whose)
        };
        assert!(of(5, 16).contains("5 groups of the 16 movements"));
        assert!(of(3, 3).contains("each of the 3 movements"));
        assert!(of(5, 1).contains("5 equal parts of the time"));
        assert!(of(5, 1).contains("`anna` (simulated operator)"));
        assert!(
            note(&spread(vec![]), &Learned { model: "a", is_simulated: false }).contains("too few")
        );
    }

    #[test]
    fn odd_weights_are_drawn() {
        let whose = Learned { model: "", is_simulated: false };
        let odd = vec![
            joint("spine", f64::NAN, Some((f64::NAN, f64::NAN))),
            joint("spine", 0.0, None),
            joint("wrist", 1.0, Some((0.0, f64::INFINITY))),
            joint("wrist", 1e9, Some((f64::NAN, 1.0))),
        ];
        for joints in [odd, Vec::new(), vec![joint("elbow", 1.0, None)]] {
            let drawn = weights_figure(&spread(joints.clone()), &whose).unwrap();
            assert!(drawn.starts_with(b"\x89PNG"));
            assert_eq!(drawn, weights_figure(&spread(joints), &whose).unwrap());
        }
    }
}

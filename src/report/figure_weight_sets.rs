//! W over training sets: does the same come out, whoever is learned from and whatever they do?

use super::ReportError;
use super::panel::Panel;
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{GRID, INK, LABEL, MUTED, Pen, Stroke, TICK, TITLE};
use super::value_axis::{Axis, method_color};
use crate::math::stats::quantile;
use crate::posture::{Method, joint_group};
use crate::training::paper::ChainResult;

/// The methods that are shown.
const SHOWN: [Method; 2] = [Method::MiNsgp, Method::FullW];
/// Left ends of the panels and their width; top, height of a row, px.
const LEFT: [f64; 2] = [330.0, 960.0];
const WIDE: f64 = 560.0;
const TOP: f64 = 96.0;
const ROW: f64 = 29.0;
const GAP: f64 = 12.0;
/// Width of the figure and room below the panels, px.
const WIDTH: f64 = 1560.0;
const BELOW: f64 = 190.0;

/// A row for each joint, a dot for each training set in the colour of its person, a bar at their median, as PNG; none
/// without methods that learn W.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn weights_over_sets(
    chain: &ChainResult,
    is_simulated: bool,
) -> Result<Option<Vec<u8>>, ReportError> {
    let columns: Vec<usize> = SHOWN
        .iter()
        .filter_map(|m| chain.methods.iter().position(|own| own.method == *m))
        .collect();
    if columns.is_empty() {
        return Ok(None);
    }
    let rows = rows(&chain.joints);
    let bottom = rows.last().map_or(TOP + ROW, |y| y + 0.5 * ROW);
    let size = (WIDTH as u32, (bottom + BELOW) as u32);
    let drawn = png("weights", size, |sheet| {
        for (joint, y) in chain.joints.iter().zip(&rows) {
            let name = sheet.shortened(joint, LEFT[0] - 50.0, Type::plain(TICK));
            sheet.text(&name, (LEFT[0] - 14.0, *y), Type::plain(TICK), Anchor::Right)?;
        }
        for (m, left) in columns.iter().zip(LEFT) {
            draw(sheet, chain, *m, left, (&rows, bottom))?;
        }
        sheet.paragraph(
            &note(chain, is_simulated),
            (36.0, bottom + 96.0),
            WIDTH - 72.0,
            Type::plain(TICK).colored(MUTED),
        )
    });
    drawn.map(Some)
}

/// Middle of each joint's row, px; groups stand apart.
fn rows(joints: &[String]) -> Vec<f64> {
    let mut y = TOP + 0.5 * ROW;
    let mut rows = Vec::new();
    for (i, joint) in joints.iter().enumerate() {
        if i > 0 {
            let is_same = joint_group(joint) == joint_group(&joints[i - 1]);
            y += ROW + if is_same { 0.0 } else { GAP };
        }
        rows.push(y);
    }
    rows
}

fn draw(
    sheet: &Sheet,
    chain: &ChainResult,
    m: usize,
    left: f64,
    (rows, bottom): (&[f64], f64),
) -> Drawn {
    let name = chain.methods[m].method.name();
    sheet.text(name, (left, TOP - 34.0), Type::bold(TITLE), Anchor::Left)?;
    let all: Vec<(&str, &[f64])> = chain
        .sets
        .iter()
        .filter_map(|s| Some((s.who.as_str(), s.methods[m].weights.as_deref()?)))
        .collect();
    let axis = axis(chain);
    let panel =
        Panel { x_px: (left, left + WIDE), y_px: (TOP, bottom), x: axis.range, y: (0.0, 1.0) };
    let tick = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
    for mark in axis.marks(7) {
        let (x, _) = panel.at(mark.at, 0.0);
        if !mark.label.is_empty() {
            let thin = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
            sheet.line(&[(x, TOP), (x, bottom)], thin)?;
        }
        sheet.line(&[(x, bottom), (x, bottom + 6.0)], tick)?;
        sheet.text(&mark.label, (x, bottom + 24.0), Type::plain(TICK), Anchor::Middle)?;
    }
    sheet.outline((left, TOP), (left + WIDE, bottom), MUTED, 1.5)?;
    let words = "diagonal of W over its geometric mean (no unit)";
    sheet.text(words, (left + 0.5 * WIDE, bottom + 56.0), Type::plain(LABEL), Anchor::Middle)?;
    let people = people(chain);
    for (j, y) in rows.iter().enumerate() {
        let x = |w: f64| panel.at(axis.place(w), 0.0).0.clamp(left, left + WIDE);
        for (k, (who, weights)) in all.iter().enumerate() {
            let person = people.iter().position(|p| p == who).unwrap_or(0);
            // Side by side in an order that looks random and is not.
            let beside = (0.618 * (k as f64 + 1.0)).fract() - 0.5;
            let at = (x(weights[j]), y + 0.6 * ROW * beside);
            sheet.disc(at, 3.6, method_color(person))?;
        }
        let own: Vec<f64> = all.iter().map(|(_, w)| w[j]).collect();
        let middle = x(quantile(&own, 0.5));
        let pen = Pen { color: INK, width: 3.0, stroke: Stroke::Solid };
        sheet.line(&[(middle, y - 0.42 * ROW), (middle, y + 0.42 * ROW)], pen)?;
    }
    Ok(())
}

/// Of all methods that are shown, so that they can be compared.
fn axis(chain: &ChainResult) -> Axis {
    let shown = chain.sets.iter().flat_map(|s| &s.methods).filter(|m| SHOWN.contains(&m.method));
    let values = shown.filter_map(|m| m.weights.as_ref()).flatten().copied();
    Axis::logarithmic(&values.filter(|v| v.is_finite()).collect::<Vec<_>>())
}

/// In the order of the sets.
fn people(chain: &ChainResult) -> Vec<&str> {
    let mut people: Vec<&str> = Vec::new();
    for set in &chain.sets {
        if !people.contains(&set.who.as_str()) {
            people.push(&set.who);
        }
    }
    people
}

fn note(chain: &ChainResult, is_simulated: bool) -> String {
    let who = if is_simulated { "Simulated people: nobody was recorded. " } else { "" };
    format!(
        "{who}A dot for each of {} training sets, {} people by colour; bar: median. The larger, the more of the hand's \
         movement the joint takes over. If W were a fact about people, the dots of a row would lie close together beside \
         the distance between rows. Order from the pelvis to the hand.",
        chain.sets.len(),
        people(chain).len()
    )
}

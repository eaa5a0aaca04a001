//! Box plots that compare methods over repeats, one panel per measure.

use super::ReportError;
use super::panel::Panel;
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{INK, MUTED, Pen, Stroke, TICK, TITLE, tint};
use super::value_axis::{Axis, EXACT, method_color};
use crate::math::stats::quantile;

/// Width of the figure, px.
const WIDTH: f64 = 1600.0;
/// Height of a panel and of what stands above and below it, px.
const HEIGHT: (f64, f64, f64) = (380.0, 72.0, 78.0);
/// Room for tick labels at a panel's left, and free room at its right, px.
const SIDES: (f64, f64) = (96.0, 18.0);
/// Most repeats that are drawn one by one.
const MOST_POINTS: usize = 20;
/// Widest box, px.
const WIDEST_BOX: f64 = 64.0;
/// From a panel's lower edge to the middle of a name's first line, px; from line to line, in sizes of
/// the type.
const NAME: f64 = 24.0;
const LINE: f64 = 1.15;
/// Smallest type of a method's name, px.
const SMALLEST: f64 = 14.0;

/// One measure of all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxPanel {
    /// What is measured.
    pub title: String,
    /// Its unit.
    pub unit: String,
    /// Whether it is an error: shown from zero, or on a logarithmic scale where values differ by more
    /// than a factor of 30, with those below 1e-12 on a line of their own, "exact".
    pub is_error: bool,
    /// Name of each method with its value in each repeat.
    pub methods: Vec<(String, Vec<f64>)>,
}

/// Panels of box plots, two in a row, as PNG: median, quartiles, whiskers to the 5th and 95th
/// percentile, and the repeats themselves if they are few. Values that are not finite are left out.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn box_plots(panels: &[BoxPanel]) -> Result<Vec<u8>, ReportError> {
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns).max(1);
    let (high, above, below) = HEIGHT;
    let height = rows as f64 * (high + above + below) + 56.0;
    png("box_plots", (WIDTH as u32, height as u32), |sheet| {
        let wide = WIDTH / columns as f64;
        let titles: Vec<String> =
            panels.iter().map(|p| format!("{} ({})", p.title, p.unit)).collect();
        let kind = Type::bold(TITLE);
        let room = wide - SIDES.0 - SIDES.1;
        let widest = titles.iter().map(|t| sheet.width(t, kind)).fold(1.0, f64::max);
        let kind = Type { size: TITLE * (room / widest).min(1.0), ..kind };
        for (i, (panel, title)) in panels.iter().zip(&titles).enumerate() {
            let left = wide * (i % columns) as f64;
            let top = (i / columns) as f64 * (high + above + below) + above;
            let x_px = (left + SIDES.0, left + wide - SIDES.1);
            sheet.text(title, (x_px.0, top - 28.0), kind, Anchor::Left)?;
            draw(sheet, panel, x_px, (top, top + high))?;
        }
        let few = panels.iter().flat_map(|p| &p.methods).all(|(_, v)| v.len() <= MOST_POINTS);
        let key = "box: quartiles and median; whiskers: 5th and 95th percentile";
        let key = if few { format!("{key}; points: single repeats") } else { key.to_owned() };
        let muted = Type::plain(18.0).colored(MUTED);
        sheet.text(&key, (SIDES.0, height - 28.0), muted, Anchor::Left)
    })
}

fn draw(sheet: &Sheet, panel: &BoxPanel, x_px: (f64, f64), y_px: (f64, f64)) -> Drawn {
    let finite = |v: &[f64]| v.iter().copied().filter(|v| v.is_finite()).collect::<Vec<_>>();
    let methods: Vec<Vec<f64>> = panel.methods.iter().map(|(_, v)| finite(v)).collect();
    let all = shown(&methods);
    let axis = if panel.is_error { Axis::errors(&all) } else { Axis::linear(&all) };
    let count = methods.len().max(1);
    let on = Panel { x_px, y_px, x: (0.0, count as f64), y: axis.range };
    axis.draw_left(sheet, &on)?;
    sheet.outline((x_px.0, y_px.0), (x_px.1, y_px.1), MUTED, 1.5)?;
    axis.draw_gap(sheet, &on)?;
    let slot = (x_px.1 - x_px.0) / count as f64;
    let half = 0.5 * (0.62 * slot).min(WIDEST_BOX);
    for (i, values) in methods.iter().enumerate() {
        let (x, _) = on.at(i as f64 + 0.5, 0.0);
        let pen = Pen { color: method_color(i), width: 2.0, stroke: Stroke::Solid };
        let tick = [(x, y_px.1), (x, y_px.1 + 7.0)];
        sheet.line(&tick, Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid })?;
        if values.is_empty() {
            let middle = (x, 0.5 * (y_px.0 + y_px.1));
            sheet.text("no value", middle, Type::plain(16.0).colored(MUTED), Anchor::Middle)?;
            continue;
        }
        one_box(sheet, (x, half), pen, values, |v| on.at(0.0, axis.place(v)).1)?;
        if panel.is_error && axis.floor.is_none() && values.iter().all(|v| *v <= EXACT) {
            let at = (x, on.at(0.0, 0.0).1 - 20.0);
            sheet.text("exact", at, Type::plain(18.0).colored(MUTED), Anchor::Middle)?;
        }
    }
    names(sheet, panel, &on, slot)
}

/// What the axis must hold: all repeats where they are drawn one by one, else the ends of the whiskers.
fn shown(methods: &[Vec<f64>]) -> Vec<f64> {
    if methods.iter().all(|v| v.len() <= MOST_POINTS) {
        return methods.concat();
    }
    let ends = |v: &Vec<f64>| [0.05, 0.95].map(|p| quantile(v, p));
    methods.iter().filter(|v| !v.is_empty()).flat_map(ends).collect()
}

/// One box about `x`, `half` wide to each side; `down` says where a value stands.
fn one_box(
    sheet: &Sheet,
    (x, half): (f64, f64),
    pen: Pen,
    values: &[f64],
    down: impl Fn(f64) -> f64,
) -> Drawn {
    let [low, first, median, third, high] =
        [0.05, 0.25, 0.5, 0.75, 0.95].map(|p| down(quantile(values, p)));
    for (from, to) in [(first, low), (third, high)] {
        sheet.line(&[(x, from), (x, to)], pen)?;
        sheet.line(&[(x - 0.4 * half, to), (x + 0.4 * half, to)], pen)?;
    }
    let (a, b) = ((x - half, third), (x + half, first));
    sheet.fill(a, b, tint(pen.color, 0.25))?;
    sheet.outline(a, b, pen.color, pen.width)?;
    let is_flat = (high - low).abs() < 6.0;
    if values.len() <= MOST_POINTS && !is_flat {
        for (k, value) in values.iter().enumerate() {
            // Side by side in an order that looks random and is not.
            let beside = (0.618 * (k as f64 + 1.0)).fract() - 0.5;
            sheet.disc((x + 1.3 * half * beside, down(*value)), 3.2, pen.color)?;
        }
    }
    let middle: [At; 2] = [(x - half, median), (x + half, median)];
    sheet.line(&middle, Pen { color: INK, width: 3.5, stroke: Stroke::Solid })
}

/// The methods' names below a panel, in as many lines and as small as they need.
fn names(sheet: &Sheet, panel: &BoxPanel, on: &Panel, slot: f64) -> Drawn {
    let room = slot - 8.0;
    let split = |(size, at_hyphens): (f64, bool)| -> Vec<Vec<String>> {
        let lines = |name: &String| wrapped(sheet, name, room, Type::plain(size), at_hyphens);
        panel.methods.iter().map(|(name, _)| lines(name)).collect()
    };
    let fits = |way: &(f64, bool)| {
        let is_narrow = |l: &String| sheet.width(l, Type::plain(way.0)) <= room;
        let is_low = |lines: usize| NAME + LINE * way.0 * (lines as f64 - 0.5) < HEIGHT.2;
        split(*way).iter().all(|lines| is_low(lines.len()) && lines.iter().all(is_narrow))
    };
    let sizes = [TICK, 18.0, 16.0, SMALLEST];
    let mut ways = [false, true].into_iter().flat_map(|h| sizes.map(|s| (s, h)));
    let (size, at_hyphens) = ways.find(fits).unwrap_or((SMALLEST, true));
    for (i, lines) in split((size, at_hyphens)).iter().enumerate() {
        let (x, _) = on.at(i as f64 + 0.5, 0.0);
        for (k, line) in lines.iter().enumerate() {
            let at = (x, on.y_px.1 + NAME + LINE * size * k as f64);
            sheet.text(line, at, Type::plain(size), Anchor::Middle)?;
        }
    }
    Ok(())
}

/// A name broken at its spaces, or also behind its hyphens, into lines no wider than `room` where
/// that is possible.
fn wrapped(sheet: &Sheet, name: &str, room: f64, kind: Type, at_hyphens: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let is_break = |c: char| c == ' ' || (at_hyphens && c == '-');
    for part in name.split_inclusive(is_break) {
        match lines.last_mut() {
            Some(line) if sheet.width(format!("{line}{part}").trim_end(), kind) <= room => {
                line.push_str(part);
            }
            _ => lines.push(part.to_owned()),
        }
    }
    lines.into_iter().map(|l| l.trim_end().to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    /// Made-up repeats: (name, middle, spread) with `exact` for a hit but for rounding.
    fn panel(title: &str, unit: &str, is_error: bool, methods: &[(&str, f64, f64)]) -> BoxPanel {
        let repeats = |k: usize, middle: f64, spread: f64| {
            let mut rng = stream(k as u64, Purpose::Simulation, 0, 0);
            let draw = normals(&mut rng, 10);
            let of = |n: f64| {
                if is_error { middle * (spread * n).exp() } else { middle + spread * n }
            };
            draw.into_iter().map(of).collect()
        };
        BoxPanel {
            title: title.to_owned(),
            unit: unit.to_owned(),
            is_error,
            methods: methods
                .iter()
                .enumerate()
                .map(|(k, (name, middle, spread))| {
                    ((*name).to_owned(), repeats(k, *middle, *spread))
                })
                .collect(),
        }
    }

    fn example() -> [BoxPanel; 4] {
        let likelihood = [
            ("GP", 7.6, 0.4),
            ("W-IK", 15.6, 0.3),
            ("Sb-M", 14.0, 0.5),
            ("ProMP", 14.7, 0.7),
            ("NsGP", 15.4, 0.3),
            ("MI-NsGP", 16.5, 0.2),
        ];
        let error = [
            ("GP", 0.093, 0.2),
            ("W-IK", 0.048, 0.1),
            ("Sb-M", 0.085, 0.3),
            ("ProMP", 0.071, 0.2),
            ("NsGP", 0.056, 0.2),
            ("MI-NsGP", 0.04, 0.05),
        ];
        let task = [
            ("GP", 3.5, 0.2),
            ("W-IK", 11.65, 0.0),
            ("Sb-M", 11.65, 0.0),
            ("ProMP", 11.4, 0.1),
            ("NsGP", 11.65, 0.0),
            ("MI-NsGP", 11.65, 0.0),
        ];
        let task_error = [
            ("GP", 0.022, 0.3),
            ("W-IK", 7e-17, 0.2),
            ("Sb-M", 8e-17, 0.2),
            ("ProMP", 5e-5, 0.6),
            ("NsGP", 9e-17, 0.2),
            ("MI-NsGP", 0.0, 0.2),
        ];
        [
            panel("Mean log-likelihood of joint velocity", "nats", false, &likelihood),
            panel("RMSE of joint velocity", "rad/s", true, &error),
            panel("Mean log-likelihood of task velocity", "nats", false, &task),
            panel("RMSE of task velocity", "m/s", true, &task_error),
        ]
    }

    #[test]
    fn every_kind_of_value_is_drawn() {
        let four = box_plots(&example()).unwrap();
        assert!(four.starts_with(b"\x89PNG"));
        assert_eq!(four, box_plots(&example()).unwrap());
        let mut odd = panel("Error", "m/s", true, &[("all exact", 0.0, 1.0), ("none", 1.0, 0.0)]);
        odd.methods[1].1 = vec![f64::NAN, f64::INFINITY];
        odd.methods.push((String::new(), vec![]));
        assert!(box_plots(&[odd]).unwrap().starts_with(b"\x89PNG"));
        assert!(box_plots(&[]).unwrap().starts_with(b"\x89PNG"));
    }
}

//! `movement.png` of a validation: one movement over time, recorded and in the bands of strangers.

use super::ReportError;
use super::panel::{Key, Panel, Words, legend, ticks};
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{BLUE, INK, MUTED, Pen, Stroke, TICK, TITLE, tint};
use crate::training::people::{Curve, Curves, FEATURES, LeftOut};

/// Size of the figure, px.
const SIZE: (f64, f64) = (1700.0, 1130.0);
const COLUMNS: usize = 3;
/// Left end of the first panel, from one to the next, its width; the same downwards, px.
const ACROSS: (f64, f64, f64) = (120.0, 545.0, 430.0);
const DOWN: (f64, f64, f64) = (196.0, 472.0, 300.0);
const LEFT: f64 = 40.0;
/// Most marks along an axis of values, about.
const MOST_TICKS: usize = 7;
/// An axis spans at least this, in its own unit.
const LEAST: [f64; 6] = [0.1, 5.0, 5.0, 5.0, 5.0, 1.0];

pub(super) const RECORDED: Pen = Pen { color: INK, width: 3.0, stroke: Stroke::Solid };
pub(super) const MIDDLE: Pen = Pen { color: BLUE, width: 3.0, stroke: Stroke::Dashed };
/// Strength of the colours of the 90 % and the 50 % band.
pub(super) const BANDS: [f64; 2] = [0.18, 0.42];

/// Person, movement and curves of the movement whose energy score is the median of all that have curves: neither
/// the best nor the worst.
pub(super) fn typical(found: &LeftOut) -> Option<(&str, &str, &Curves)> {
    let all = found.people.iter().flat_map(|p| {
        p.movements.iter().filter_map(|m| {
            Some((m.bands.energy_deg, p.person.as_str(), m.movement.as_str(), m.curves.as_ref()?))
        })
    });
    let mut all: Vec<_> = all.collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (_, person, movement, curves) = all.get(all.len() / 2)?;
    Some((person, movement, curves))
}

/// Six panels: what is compared of a posture, and RULA, over time (s), as PNG.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn movement(
    (person, name, curves): (&str, &str, &Curves),
) -> Result<Vec<u8>, ReportError> {
    png("movement", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let title =
            format!("A movement of {person} that is predicted about as well as most ({name})");
        let kind = Type::bold(TITLE);
        let title = sheet.shortened(&title, SIZE.0 - 2.0 * LEFT, kind);
        sheet.text(&title, (LEFT, 36.0), kind, Anchor::Left)?;
        let keys = [
            Key::Line(RECORDED, "recorded".to_owned()),
            Key::Line(MIDDLE, "median of the repetitions; of RULA their mean".to_owned()),
            Key::Field(tint(BLUE, BANDS[1]), "50 % band".to_owned()),
            Key::Field(tint(BLUE, BANDS[0]), "90 % band".to_owned()),
        ];
        legend(sheet, (LEFT, 84.0), SIZE.0 - 2.0 * LEFT, &keys)?;
        let titles = FEATURES.iter().copied().chain(["RULA"]);
        let all = curves.features.iter().chain([&curves.rula]);
        for (i, (title, curve)) in titles.zip(all).enumerate() {
            let left = ACROSS.0 + ACROSS.1 * (i % COLUMNS) as f64;
            let top = DOWN.0 + DOWN.1 * (i / COLUMNS) as f64;
            let panel = Panel {
                x_px: (left, left + ACROSS.2),
                y_px: (top, top + DOWN.2),
                x: times(&curves.time_s),
                y: values(curve, LEAST[i.min(LEAST.len() - 1)]),
            };
            let unit = match i {
                0 => "leg lengths",
                i if i < FEATURES.len() => "deg",
                _ => "score",
            };
            let middle = if i < FEATURES.len() { &curve.quantiles[2] } else { &curve.mean };
            draw(sheet, &panel, (&curves.time_s, curve, middle), (title, unit))?;
        }
        let note = "Strangers who know nothing of this person but the path of the hand from the feet and the size of the body.";
        let at = (LEFT, DOWN.0 + DOWN.1 + DOWN.2 + 112.0);
        sheet.text(note, at, Type::plain(TICK).colored(MUTED), Anchor::Left)
    })
}

/// From the first to the last time; a second where there is none.
pub(super) fn times(time_s: &[f64]) -> (f64, f64) {
    let (from, to) =
        (time_s.first().copied().unwrap_or(0.0), time_s.last().copied().unwrap_or(0.0));
    if to > from { (from, to) } else { (from, from + 1.0) }
}

/// What an axis spans.
pub(super) fn values(curve: &Curve, least: f64) -> (f64, f64) {
    let all = curve.quantiles.iter().flatten().chain(&curve.recorded).chain(&curve.mean);
    let (low, high) = all
        .copied()
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return (0.0, least);
    }
    let half = f64::max(0.54 * (high - low), 0.5 * least);
    let middle = 0.5 * (low + high);
    (middle - half, middle + half)
}

/// Bands, the middle of the repetitions and what was recorded over time.
pub(super) fn draw(
    sheet: &Sheet,
    panel: &Panel,
    (time_s, curve, middle): (&[f64], &Curve, &[f64]),
    (title, unit): (&str, &str),
) -> Drawn {
    let y_ticks = ticks(panel.y, MOST_TICKS);
    panel.grid_at(sheet, &y_ticks)?;
    let points = |values: &[f64]| -> Vec<At> {
        let both = time_s.iter().zip(values).filter(|(_, v)| v.is_finite());
        both.map(|(t, v)| panel.at(*t, *v)).collect()
    };
    let [p05, p25, _, p75, p95] = &curve.quantiles;
    for ((low, high), strength) in [(p05, p95), (p25, p75)].into_iter().zip(BANDS) {
        let around: Vec<At> =
            points(low).into_iter().chain(points(high).into_iter().rev()).collect();
        if around.len() > 2 {
            sheet.shape(&around, tint(BLUE, strength), 1.0)?;
        }
    }
    for (values, pen) in [(middle, MIDDLE), (curve.recorded.as_slice(), RECORDED)] {
        let line = points(values);
        if line.len() > 1 {
            sheet.line(&line, pen)?;
        }
    }
    panel.axes(sheet, Words { title, x: "time (s)", y: unit }, &y_ticks)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(values: &[f64]) -> Curve {
        Curve {
            recorded: values.to_vec(),
            quantiles: [-2.0, -1.0, 0.0, 1.0, 2.0].map(|d| values.iter().map(|v| v + d).collect()),
            mean: values.to_vec(),
        }
    }

    #[test]
    fn odd_curves_are_drawn() {
        for (values, time_s) in [
            (vec![1.0, 4.0, 2.0], vec![0.0, 0.1, 0.2]),
            (vec![f64::NAN, f64::INFINITY], vec![0.0, 0.1]),
            (vec![3.0], vec![0.0]),
            (Vec::new(), Vec::new()),
        ] {
            let own = curve(&values);
            let curves = Curves { time_s, features: vec![own.clone(); 5], rula: own };
            let drawn = movement(("p01", "a.amc", &curves)).unwrap();
            assert!(drawn.starts_with(b"\x89PNG"));
            assert_eq!(drawn, movement(("p01", "a.amc", &curves)).unwrap());
        }
    }

    #[test]
    fn an_axis_holds_all_curves_and_is_never_too_narrow() {
        let (low, high) = values(&curve(&[1.0, 9.0]), 5.0);
        assert!(low < -1.0 && high > 11.0);
        let still = Curve { quantiles: Default::default(), ..curve(&[3.0]) };
        let (low, high) = values(&still, 5.0);
        assert!((high - low - 5.0).abs() < 1e-12 && low < 3.0 && high > 3.0);
    }
}

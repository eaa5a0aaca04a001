//! `held_out.png` of a training: recorded joint angles of a held-out movement in the bands of people
//! who follow its hand path.

use super::ReportError;
use super::figure_weights::Learned;
use super::panel::{Key, Panel, Words, legend, ticks};
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{BLUE, INK, MUTED, Pen, Stroke, TICK, TITLE, tint};
use crate::training::{HeldOutCurves, JointCurves};

/// Size of the figure, px.
const SIZE: (f64, f64) = (1700.0, 1240.0);
/// Joints that are shown, and panels beside each other.
const SHOWN: usize = 6;
const COLUMNS: usize = 3;
/// Left end of the first panel, from one to the next, its width; the same downwards, px.
const ACROSS: (f64, f64, f64) = (120.0, 545.0, 440.0);
const DOWN: (f64, f64, f64) = (196.0, 472.0, 300.0);
/// Left end of title and notes, px.
const LEFT: f64 = 40.0;
/// The axis of angles spans at least this, deg.
const LEAST_DEG: f64 = 2.0;
/// Most marks along it, about.
const MOST_TICKS: usize = 7;

const RECORDED: Pen = Pen { color: INK, width: 3.0, stroke: Stroke::Solid };
const MEDIAN: Pen = Pen { color: BLUE, width: 3.0, stroke: Stroke::Dashed };
/// Strength of the colours of the 90 % and the 50 % band.
const BANDS: [f64; 2] = [0.18, 0.42];

/// Six panels of joint angles (deg) over time (s) of the piece of `recording` that was held out, as PNG:
/// the joints with the largest recorded range, in the order of the chain.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn held_out_figure(
    curves: &HeldOutCurves,
    recording: &str,
    whose: &Learned,
) -> Result<Vec<u8>, ReportError> {
    png("held_out", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let method = curves.method.name();
        let title = format!("A movement that was held out: recorded and predicted ({method})");
        sheet.text(&title, (LEFT, 36.0), Type::bold(TITLE), Anchor::Left)?;
        let keys = [
            Key::Line(RECORDED, "recorded".to_owned()),
            Key::Line(MEDIAN, "median of the repetitions".to_owned()),
            Key::Field(tint(BLUE, BANDS[1]), "50 % band of the repetitions".to_owned()),
            Key::Field(tint(BLUE, BANDS[0]), "90 % band of the repetitions".to_owned()),
        ];
        legend(sheet, (LEFT, 84.0), SIZE.0 - 2.0 * LEFT, &keys)?;
        for (i, joint) in curves.moving_most(SHOWN).into_iter().enumerate() {
            let left = ACROSS.0 + ACROSS.1 * (i % COLUMNS) as f64;
            let top = DOWN.0 + DOWN.1 * (i / COLUMNS) as f64;
            let panel = Panel {
                x_px: (left, left + ACROSS.2),
                y_px: (top, top + DOWN.2),
                x: span(&curves.time_s),
                y: angles_deg(joint),
            };
            draw(sheet, &panel, &curves.time_s, joint)?;
        }
        let muted = Type::plain(TICK).colored(MUTED);
        let at = (LEFT, DOWN.0 + DOWN.1 + DOWN.2 + 112.0);
        sheet.paragraph(&note(curves, recording, whose), at, SIZE.0 - 2.0 * LEFT, muted)
    })
}

/// From the first to the last time; a second where there is none.
fn span(time_s: &[f64]) -> (f64, f64) {
    let (from, to) =
        (time_s.first().copied().unwrap_or(0.0), time_s.last().copied().unwrap_or(0.0));
    if to > from { (from, to) } else { (from, from + 1.0) }
}

/// What the axis of a joint spans, deg.
fn angles_deg(joint: &JointCurves) -> (f64, f64) {
    let all = joint.quantiles.iter().flatten().chain(&joint.recorded);
    let all = all.copied().filter(|v| v.is_finite()).map(f64::to_degrees);
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if low > high {
        return (0.0, LEAST_DEG);
    }
    let half = f64::max(0.54 * (high - low), 0.5 * LEAST_DEG);
    let middle = 0.5 * (low + high);
    (middle - half, middle + half)
}

fn draw(sheet: &Sheet, panel: &Panel, time_s: &[f64], joint: &JointCurves) -> Drawn {
    let y_ticks = ticks(panel.y, MOST_TICKS);
    panel.grid_at(sheet, &y_ticks)?;
    let points = |values: &[f64]| -> Vec<At> {
        let both = time_s.iter().zip(values).filter(|(_, v)| v.is_finite());
        both.map(|(t, v)| panel.at(*t, v.to_degrees())).collect()
    };
    let [p05, p25, p50, p75, p95] = &joint.quantiles;
    for ((low, high), strength) in [(p05, p95), (p25, p75)].into_iter().zip(BANDS) {
        let around: Vec<At> =
            points(low).into_iter().chain(points(high).into_iter().rev()).collect();
        if around.len() > 2 {
            sheet.shape(&around, tint(BLUE, strength), 1.0)?;
        }
    }
    for (values, pen) in [(p50, MEDIAN), (&joint.recorded, RECORDED)] {
        let line = points(values);
        if line.len() > 1 {
            sheet.line(&line, pen)?;
        }
    }
    let words = Words { title: "", x: "time (s)", y: "joint angle (deg)" };
    panel.axes(sheet, words, &y_ticks)?;
    let ((left, right), (top, _)) = (panel.x_px, panel.y_px);
    let muted = Type::plain(TICK).colored(MUTED);
    let held = format!("90 % band covers {:.0} %", 100.0 * joint.held_90);
    sheet.text(&held, (right, top - 20.0), muted, Anchor::Right)?;
    // Not bold: the bold j of this font runs into the letter after it.
    let plain = Type::plain(TICK);
    let name =
        sheet.shortened(&joint.joint, right - left - sheet.width(&held, muted) - 16.0, plain);
    sheet.text(&name, (left, top - 20.0), plain, Anchor::Left)
}

/// What is shown.
fn note(curves: &HeldOutCurves, recording: &str, whose: &Learned) -> String {
    let (from, to) = span(&curves.time_s);
    let pull = if curves.is_pulled { "with" } else { "without" };
    format!(
        "{recording}, {from:.2} to {to:.2} s: the longest uninterrupted piece of the first part held out \
         for judging {}. The law here was learned without that part ({}, {pull} the pull towards the \
         person's own postures). {} repetitions drawn from it follow the recorded hand path, all \
         from the recorded posture at the start. Shown are the joints with the largest recorded range, each on a \
         scale of its own, with the share of the times after the start at which the 90 % band covers the \
         recorded angle; 90 % would be right on average.",
        whose.words(),
        curves.method.name(),
        curves.rollouts
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::Method;

    fn curves(joints: Vec<JointCurves>, time_s: Vec<f64>) -> HeldOutCurves {
        HeldOutCurves {
            method: Method::FullW,
            is_pulled: true,
            rollouts: 100,
            trial: 0,
            time_s,
            joints,
        }
    }

    fn joint(values: &[f64]) -> JointCurves {
        JointCurves {
            joint: "jRightShoulder_Z".to_owned(),
            recorded: values.to_vec(),
            quantiles: [-0.2, -0.1, 0.0, 0.1, 0.2].map(|d| values.iter().map(|v| v + d).collect()),
            held_90: 1.0,
        }
    }

    #[test]
    fn odd_curves_are_drawn() {
        let whose = Learned { model: "anna", is_simulated: false };
        let still = JointCurves { quantiles: Default::default(), ..joint(&[0.0, 0.0]) };
        for (joints, time_s) in [
            (vec![joint(&[0.1, 0.2, 0.4]); 9], vec![0.0, 0.1, 0.2]),
            (vec![joint(&[f64::NAN, 0.2, f64::INFINITY])], vec![0.0, 0.1, 0.2]),
            (vec![still, joint(&[])], vec![1.0, 1.0]),
            (Vec::new(), Vec::new()),
        ] {
            let own = curves(joints, time_s);
            let drawn = held_out_figure(&own, "a.csv", &whose).unwrap();
            assert!(drawn.starts_with(b"\x89PNG"));
            assert_eq!(drawn, held_out_figure(&own, "a.csv", &whose).unwrap());
        }
    }

    #[test]
    fn the_axis_holds_all_curves() {
        let (low, high) = angles_deg(&joint(&[0.5, 1.0]));
        assert!(low < 0.3_f64.to_degrees() && high > 1.2_f64.to_degrees());
        let (low, high) =
            angles_deg(&JointCurves { quantiles: Default::default(), ..joint(&[0.5]) });
        assert!((high - low - LEAST_DEG).abs() < 1e-9);
    }
}

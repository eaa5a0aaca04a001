//! The spread of sampled postures drawn on the body, and four scores over sampled trajectories: the paper's Fig. 5.

use super::ReportError;
use super::figure_movement::{BANDS, MIDDLE, RECORDED, draw, times, values};
use super::figure_paths::{Look, extent};
use super::mannequin;
use super::panel::{Key, Panel, legend};
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{BLUE, FAINT, INK, LABEL, MUTED, Pen, SKY, Stroke, TICK, TITLE, tint};
use crate::human::{Head, Mannequin};
use crate::math::Pose;
use crate::planner::PosedMannequin;
use crate::survey::Surveyor;
use crate::training::paper::{PostureSpread, SCORES};
use nalgebra::DVector;

/// Size of the figure, px.
const SIZE: (f64, f64) = (1760.0, 1330.0);
const LEFT: f64 = 40.0;
/// Views of postures: top and bottom, and what shares of the movement are behind each.
const POSTURES: (f64, f64) = (190.0, 680.0);
const SHARES: [f64; 3] = [0.33, 0.66, 1.0];
/// Score panels: left end of the first, from one to the next, width; top, bottom.
const ACROSS: (f64, f64, f64) = (110.0, 420.0, 300.0);
const DOWN: (f64, f64) = (800.0, 1090.0);
/// Sampled postures that are drawn.
const DRAWN: usize = 30;
/// An axis of a score spans at least this.
const LEAST: [f64; 4] = [2.0, 2.0, 2.0, 10.0];

/// Three moments from the side, the last also from the front, and the scores over time (s), as PNG.
///
/// # Errors
/// Where the picture cannot be drawn.
pub(super) fn spread_figure(
    spread: &PostureSpread,
    is_simulated: bool,
) -> Result<Vec<u8>, ReportError> {
    let fault = |message: String| ReportError::Figure { name: "spread".to_owned(), message };
    let body = Drawable::new(spread).map_err(|e| fault(e.to_string()))?;
    png("spread", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let title = format!(
            "Sampled trajectories along a held-out hand path: {} ({})",
            spread.task,
            spread.method.name()
        );
        let kind = Type::bold(TITLE);
        let title = sheet.shortened(&title, SIZE.0 - 2.0 * LEFT, kind);
        sheet.text(&title, (LEFT, 36.0), kind, Anchor::Left)?;
        let keys = [
            Key::Line(RECORDED, "recorded".to_owned()),
            Key::Line(MIDDLE, "mean of the samples".to_owned()),
            Key::Field(tint(BLUE, BANDS[1]), "50 % band".to_owned()),
            Key::Field(tint(BLUE, BANDS[0]), "90 % band".to_owned()),
            Key::Line(SAMPLE, "sampled postures".to_owned()),
        ];
        legend(sheet, (LEFT, 84.0), SIZE.0 - 2.0 * LEFT, &keys)?;
        body.postures(sheet)?;
        for (k, (title, curve)) in SCORES.iter().zip(&spread.scores).enumerate() {
            let left = ACROSS.0 + ACROSS.1 * k as f64;
            let panel = Panel {
                x_px: (left, left + ACROSS.2),
                y_px: DOWN,
                x: times(&spread.time_s),
                y: values(curve, LEAST[k]),
            };
            let unit = if k == 3 { "deg" } else { "points" };
            draw(sheet, &panel, (&spread.time_s, curve, &curve.mean), (title, unit))?;
        }
        let muted = Type::plain(TICK).colored(MUTED);
        sheet.paragraph(&note(spread, is_simulated), (LEFT, 1196.0), SIZE.0 - 2.0 * LEFT, muted)
    })
}

fn note(spread: &PostureSpread, is_simulated: bool) -> String {
    let who = if is_simulated { "Simulated people: nobody was recorded. " } else { "" };
    format!(
        "{who}{}, {}: the training set whose relative error is the median of all. {} trajectories drawn by the law begin in \
         the recorded posture and follow the recorded hand; {DRAWN} are drawn over the recorded person. Recorded and sampled \
         postures are scored alike: free hands, no load, the head as recorded people hold it on average. RULA continuous is \
         a sum of polynomials, not RULA; the back angle adds up the rotations of the spine's joints.",
        spread.who,
        spread.movement,
        spread.samples.len()
    )
}

const SAMPLE: Pen = Pen { color: SKY, width: 1.2, stroke: Stroke::Solid };

/// A body that can be posed and drawn.
struct Drawable<'a> {
    spread: &'a PostureSpread,
    surveyor: Surveyor,
    mannequin: Mannequin,
    rest: Pose,
}

impl<'a> Drawable<'a> {
    fn new(spread: &'a PostureSpread) -> Result<Self, crate::files::InputError> {
        let PostureSpread { body, coupled, stance, .. } = spread;
        let rest = body.pelvis_pose([0.0; 2], 0.0, *stance);
        Ok(Self {
            spread,
            surveyor: Surveyor::new(body, *coupled, rest, (*stance, 0.0))?,
            mannequin: Mannequin::new(body, *coupled, *stance)?,
            rest,
        })
    }

    fn bones(&self, q: &DVector<f64>) -> Vec<[[f64; 3]; 2]> {
        self.surveyor.bones_at(&self.rest, q, Head::default())
    }

    fn postures(&self, sheet: &Sheet) -> Drawn {
        let facing = [1.0, 0.0];
        let last = self.spread.recorded.len() - 1;
        let moments = SHARES.map(|s| (s * last as f64).round() as usize);
        let views = moments.iter().map(|k| (*k, Look::Side(facing)));
        let views: Vec<(usize, Look)> = views.chain([(last, Look::Front(facing))]).collect();
        let ranges: Vec<_> = views.iter().map(|(k, look)| self.range(*k, *look)).collect();
        // One scale for all.
        let wide = (SIZE.0 - 2.0 * LEFT) / views.len() as f64;
        let scale = ranges
            .iter()
            .map(|(low, high)| {
                let across = (wide - 30.0) / (high[0] - low[0]).max(0.1);
                across.min((POSTURES.1 - POSTURES.0) / (high[1] - low[1]).max(0.1))
            })
            .fold(f64::INFINITY, f64::min);
        for (i, ((k, look), (low, high))) in views.into_iter().zip(ranges).enumerate() {
            let left = LEFT + wide * i as f64;
            let from = if matches!(look, Look::Front(_)) { ", from the front" } else { "" };
            let words = format!("{:.2} s{from}", self.spread.time_s[k] - self.spread.time_s[0]);
            sheet.text(&words, (left, POSTURES.0 - 34.0), Type::bold(LABEL), Anchor::Left)?;
            let panel = Panel {
                x_px: (left, left + wide - 30.0),
                y_px: POSTURES,
                x: (low[0], high[0]),
                y: (low[1], high[1]),
            };
            self.posture(sheet, k, look, &panel.equalised(scale))?;
        }
        Ok(())
    }

    /// What a view must show, m.
    fn range(&self, k: usize, look: Look) -> ([f64; 2], [f64; 2]) {
        let samples = self.spread.samples.iter().take(DRAWN).map(|s| &s[k]);
        let all = samples.chain([&self.spread.recorded[k]]).flat_map(|q| self.bones(q));
        let points =
            all.flatten().map(|p| look.flat(p)).filter(|p| p.iter().all(|v| v.is_finite()));
        let (low, high) = extent(points.chain([[0.0, 0.0]])).unwrap_or_default();
        ([low[0] - 0.14, low[1].min(0.0)], [high[0] + 0.14, high[1] + 0.08])
    }

    fn posture(&self, sheet: &Sheet, k: usize, look: Look, panel: &Panel) -> Drawn {
        let floor = Pen { color: FAINT, width: 2.0, stroke: Stroke::Solid };
        sheet.line(&[panel.at(panel.x.0, 0.0), panel.at(panel.x.1, 0.0)], floor)?;
        let recorded = &self.spread.recorded[k];
        let posed =
            PosedMannequin::of(&self.mannequin, &self.rest, recorded.as_slice(), Head::default());
        mannequin::draw(sheet, &posed, look, panel)?;
        let at = |p: [f64; 3]| -> At {
            let [x, y] = look.flat(p);
            panel.at(x, y)
        };
        let lines = |q: &DVector<f64>, pen: Pen| -> Drawn {
            for [a, b] in self.bones(q) {
                sheet.line(&[at(a), at(b)], pen)?;
            }
            Ok(())
        };
        for sample in self.spread.samples.iter().take(DRAWN) {
            lines(&sample[k], SAMPLE)?;
        }
        lines(recorded, Pen { color: INK, width: 3.0, stroke: Stroke::Solid })
    }
}

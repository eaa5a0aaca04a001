//! Figures of scores: over time on a ground of action levels, shares of time by level, body parts.

use super::ReportError;
use super::panel::{Key, Panel, Words, legend, ticks};
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{
    BEST, BLUE, GRID, INK, LABEL, Level, MUTED, OWN, Pen, STRAIGHT, Stroke, TICK, TITLE,
    method_levels, tint,
};
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::planner::{BodyScores, CandidateResult};
use crate::words::number::{percent, score};

/// The paths that are compared curve by curve, with pen and name.
fn compared<'a>(view: &View<'a>) -> Vec<(Pen, String, &'a CandidateResult)> {
    let mut all = Vec::new();
    if let Some(straight) = view.straight {
        all.push((STRAIGHT, "straight path".to_owned(), straight));
    }
    for own in &view.own {
        all.push((OWN, format!("your path ({})", own.id), *own));
    }
    if let Some(lead) = view.lead {
        all.push((BEST, view.lead_name(lead), lead));
    }
    all
}

/// `figures/rula_over_time.png`.
pub(super) fn over_time(view: &View) -> Result<Vec<u8>, ReportError> {
    png("rula_over_time", (1600, 1300), |sheet| {
        let compared = compared(view);
        let keys: Vec<Key> = compared
            .iter()
            .rev()
            .map(|(pen, name, c)| {
                if view.lead.is_some_and(|l| l.id == c.id) {
                    Key::Band(*pen, format!("{name}: mean, 5th to 95th percentile"))
                } else {
                    Key::Line(*pen, format!("{name}: mean; thin: 5th, 95th"))
                }
            })
            .collect();
        let top = legend(sheet, (110.0, 36.0), 1460.0, &keys)? + 86.0;
        let ends = compared.iter().filter_map(|(_, _, c)| c.path.as_ref()?.time_s.last().copied());
        let end = ends.fold(0.0, f64::max);
        let end = if end > 0.0 { end } else { view.result.setting.duration_s };
        let bottom = 1300.0 - 84.0;
        let count = ScoringMethod::ALL.len() as f64;
        let height = (bottom - top - 150.0 * (count - 1.0)) / count;
        for (i, method) in ScoringMethod::ALL.into_iter().enumerate() {
            let top = top + i as f64 * (height + 150.0);
            let (name, worst) = (method.name(), method.worst());
            let panel = Panel {
                x_px: (110.0, 1290.0),
                y_px: (top, top + height),
                x: (0.0, end),
                y: (0.5, f64::from(worst) + 0.5),
            };
            ground(sheet, &panel, &method_levels(method))?;
            for (pen, _, candidate) in &compared {
                curve(sheet, &panel, view, (*pen, candidate), method)?;
            }
            let title = format!("{name} over time, mean over repetitions");
            let side = format!("{name} score");
            let words = Words { title: &title, x: "time (s)", y: &side };
            let ticks: Vec<f64> =
                (1..=worst).filter(|k| worst < 10 || k % 2 == 1).map(f64::from).collect();
            panel.axes(sheet, words, &ticks)?;
        }
        Ok(())
    })
}

/// The coloured ground with the levels in words at the right.
fn ground(sheet: &Sheet, panel: &Panel, levels: &[Level]) -> Drawn {
    let (left, right) = panel.x_px;
    for level in levels {
        let (low, high) = (f64::from(level.scores.0) - 0.5, f64::from(level.scores.1) + 0.5);
        let (_, top) = panel.at(0.0, high);
        let (_, bottom) = panel.at(0.0, low);
        sheet.fill((left, top), (right, bottom), tint(level.color, 0.28))?;
        sheet.fill((right + 8.0, top + 1.0), (right + 18.0, bottom - 1.0), level.color)?;
        let text = format!("level {}: {}", level.number, level.words);
        let at = (right + 28.0, 0.5 * (top + bottom));
        sheet.text(&text, at, Type::plain(TICK), Anchor::Left)?;
    }
    Ok(())
}

fn curve(
    sheet: &Sheet,
    panel: &Panel,
    view: &View,
    (pen, candidate): (Pen, &CandidateResult),
    method: ScoringMethod,
) -> Drawn {
    let scores = candidate.bodies.iter().find(|b| Some(b.body.as_str()) == view.body);
    let (Some(scores), Some(path)) = (scores, &candidate.path) else { return Ok(()) };
    let band = &scores.scores[method].distribution.band;
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        path.time_s.iter().zip(values).map(|(t, v)| panel.at(*t, *v)).collect()
    };
    let (low, high) = (points(&band.p05), points(&band.p95));
    // Only the lead's band is filled: several filled bands on one ground cannot be told apart.
    let around: Vec<_> = low.iter().chain(high.iter().rev()).copied().collect();
    if around.len() > 2 && view.lead.is_some_and(|l| l.id == candidate.id) {
        sheet.shape(&around, pen.color, 0.22)?;
    }
    for edge in [low, high] {
        sheet.line(&edge, Pen { width: 1.3, ..pen })?;
    }
    sheet.line(&points(&band.mean), pen)
}

/// `figures/levels.png`.
pub(super) fn levels(view: &View) -> Result<Vec<u8>, ReportError> {
    let bars = level_rows(view);
    let rows = bars.len().max(1);
    let (top, row) = (150.0, 62.0);
    let height = (top + row * rows as f64 + 96.0) as u32;
    png("levels", (1600, height), |sheet| {
        let title = match view.body.filter(|_| bars.len() > view.reported.len()) {
            Some(body) => {
                format!("Share of time at each RULA action level, for {body} where none is named")
            }
            None => "Share of time at each RULA action level".to_owned(),
        };
        sheet.text(&title, (30.0, 36.0), Type::bold(TITLE), Anchor::Left)?;
        let keys: Vec<Key> = method_levels(ScoringMethod::Rula)
            .iter()
            .map(|l| {
                Key::Field(l.color, format!("level {} (RULA {}): {}", l.number, l.range(), l.words))
            })
            .collect();
        legend(sheet, (14.0, 84.0), 1570.0, &keys)?;
        let (left, right) = (330.0, 1250.0);
        for (x, words) in [(1400.0, "time at 3+"), (1580.0, "for 0.5 s")] {
            sheet.text(words, (x, top - 22.0), Type::bold(TICK), Anchor::Right)?;
        }
        let along = |share: f64| left + share * (right - left);
        let bottom = top + row * rows as f64;
        for k in 0..=5 {
            let x = along(f64::from(k) / 5.0);
            let pen = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
            sheet.line(&[(x, top), (x, bottom + 8.0)], pen)?;
            let text = (20 * k).to_string();
            sheet.text(&text, (x, bottom + 24.0), Type::plain(TICK), Anchor::Middle)?;
        }
        let middle = 0.5 * (left + right);
        sheet.text("share (%)", (middle, bottom + 58.0), Type::plain(LABEL), Anchor::Middle)?;
        for (i, (candidate, body)) in bars.iter().enumerate() {
            let y = top + row * (i as f64 + 0.5);
            let is_verdicts = Some(body.body.as_str()) == view.body;
            level_bar(sheet, (candidate, body, is_verdicts), y, &along)?;
        }
        Ok(())
    })
}

/// The bars: every path for the body of the verdict; the lead, the straight path and the user's own for
/// the other bodies too.
pub(super) fn level_rows<'a>(view: &View<'a>) -> Vec<(&'a CandidateResult, &'a BodyScores)> {
    let is_verdicts = |b: &BodyScores| Some(b.body.as_str()) == view.body;
    let is_shown_whole = |c: &CandidateResult| {
        let beside = view.lead.iter().chain(&view.straight).chain(&view.own);
        beside.into_iter().any(|s| s.id == c.id)
    };
    let of = |c: &&'a CandidateResult| {
        let c: &'a CandidateResult = c;
        let shown = move |b: &&BodyScores| is_verdicts(b) || is_shown_whole(c);
        let mut rows: Vec<_> = c.bodies.iter().filter(shown).map(|b| (c, b)).collect();
        rows.sort_by_key(|(_, b)| !is_verdicts(b));
        rows
    };
    view.reported.iter().flat_map(of).collect()
}

fn level_bar(
    sheet: &Sheet,
    (candidate, body, is_verdicts): (&CandidateResult, &BodyScores, bool),
    y: f64,
    along: &dyn Fn(f64) -> f64,
) -> Drawn {
    let rank = candidate.rank.map_or_else(String::new, |r| format!("{r}. "));
    // Other bodies stand below that of the verdict.
    let name =
        if is_verdicts { format!("{rank}{}", candidate.id) } else { format!("for {}", body.body) };
    let name = sheet.shortened(&name, 290.0, Type::bold(LABEL));
    let bold = Type { bold: candidate.rank == Some(1), ..Type::plain(LABEL) };
    sheet.text(&name, (along(0.0) - 16.0, y), bold, Anchor::Right)?;
    let mut from = 0.0;
    for level in method_levels(ScoringMethod::Rula) {
        let share = level.share(&body.rula().distribution.exposure);
        let (a, b) = (along(from), along(from + share));
        from += share;
        if b - a < 0.5 {
            continue;
        }
        sheet.fill((a, y - 21.0), (b, y + 21.0), level.color)?;
        sheet.outline((a, y - 21.0), (b, y + 21.0), INK, 1.0)?;
        let text = percent(share);
        if sheet.width(&text, Type::plain(TICK)) + 16.0 < b - a {
            sheet.text(&text, (0.5 * (a + b), y), Type::bold(TICK), Anchor::Middle)?;
        }
    }
    let above = percent(body.rula().distribution.exposure.get(5).copied().unwrap_or(0.0));
    sheet.text(&above, (1400.0, y), bold, Anchor::Right)?;
    let lasting = percent(body.rula().distribution.p_at_least.get(5).copied().unwrap_or(0.0));
    sheet.text(&lasting, (1580.0, y), bold, Anchor::Right)
}

/// `figures/parts.png`.
pub(super) fn parts(view: &View) -> Result<Vec<u8>, ReportError> {
    let lead = view.lead.and_then(|l| view.scores(l));
    let straight = view.straight.and_then(|s| view.scores(s));
    let rows = lead.map_or(1, |l| l.rula().parts.len().max(1));
    let (top, row) = (150.0, 66.0);
    let height = (top + row * rows as f64 + 90.0) as u32;
    png("parts", (1600, height), |sheet| {
        let mut keys = Vec::new();
        if let Some(l) = view.lead {
            keys.push(Key::Field(BLUE, view.lead_name(l)));
        }
        if straight.is_some() {
            keys.push(Key::Field(tint(MUTED, 0.35), "straight path".into()));
        }
        legend(sheet, (230.0, 36.0), 1300.0, &keys)?;
        let Some(lead) = lead else { return Ok(()) };
        for (i, part) in lead.rula().parts.iter().enumerate() {
            let y = top + row * (i as f64 + 0.5);
            sheet.text(&part.part, (232.0, y), Type::plain(LABEL), Anchor::Right)?;
        }
        let means = |b: &BodyScores| b.rula().parts.iter().map(|p| p.mean).collect::<Vec<_>>();
        let drives = |b: &BodyScores| b.rula().parts.iter().map(|p| p.drives).collect::<Vec<_>>();
        let left = Bars {
            x_px: (250.0, 840.0),
            titles: ["Mean RULA step score", "step score"],
            values: [means(lead), straight.map(means).unwrap_or_default()],
        };
        let right = Bars {
            x_px: (970.0, 1540.0),
            titles: ["What drives the total", "drop of the total if at its lowest (points)"],
            values: [drives(lead), straight.map(drives).unwrap_or_default()],
        };
        left.draw(sheet, top, row)?;
        right.draw(sheet, top, row)
    })
}

/// One column of paired bars.
struct Bars {
    x_px: (f64, f64),
    titles: [&'static str; 2],
    values: [Vec<f64>; 2],
}

impl Bars {
    fn draw(&self, sheet: &Sheet, top: f64, row: f64) -> Drawn {
        let rows = self.values[0].len() as f64;
        let bottom = top + row * rows;
        // Room at the right for the number beside the longest bar.
        let most = self.values.iter().flatten().copied().fold(0.1, f64::max) * 1.18;
        let (left, right) = self.x_px;
        let along = |v: f64| left + v / most * (right - left);
        sheet.text(self.titles[0], (left, top - 28.0), Type::bold(TITLE), Anchor::Left)?;
        for v in ticks((0.0, most), 6) {
            let x = along(v);
            let pen = Pen { color: GRID, width: 1.0, stroke: Stroke::Solid };
            sheet.line(&[(x, top), (x, bottom + 6.0)], pen)?;
            let text = format!("{v:.2}");
            let text = text.trim_end_matches('0').trim_end_matches('.');
            sheet.text(text, (x, bottom + 22.0), Type::plain(TICK), Anchor::Middle)?;
        }
        let middle = 0.5 * (left + right);
        sheet.text(self.titles[1], (middle, bottom + 56.0), Type::plain(LABEL), Anchor::Middle)?;
        let pair = if self.values[1].is_empty() { 1 } else { 2 };
        for (series, values) in self.values.iter().enumerate() {
            let color = if series == 0 { BLUE } else { tint(MUTED, 0.35) };
            for (i, value) in values.iter().enumerate() {
                let y = top + row * i as f64 + 8.0 + series as f64 * 26.0;
                let y = if pair == 1 { y + 13.0 } else { y };
                sheet.fill((left, y), (along(*value), y + 22.0), color)?;
                sheet.outline((left, y), (along(*value), y + 22.0), INK, 1.0)?;
                let at = (along(*value) + 8.0, y + 11.0);
                sheet.text(&score(*value), at, Type::plain(18.0), Anchor::Left)?;
            }
        }
        let pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };
        sheet.line(&[(left, top), (left, bottom)], pen)
    }
}

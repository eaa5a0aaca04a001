//! The picture of an imported movement: the person at five moments, the angles over time, and how near the body
//! comes to each recorded segment.

use super::ReportError;
use super::figure_paths::Look;
use super::mannequin;
use super::panel::{Key, Panel, Words, legend, ticks};
use super::sheet::{Anchor, At, Drawn, Sheet, Type, png};
use super::style::{
    BLUE, FAINT, GREEN, GRID, INK, LABEL, MUTED, Pen, Stroke, TICK, TITLE, VERMILION, WHITE,
};
use crate::human::{Body, Head, Mannequin, Pelvis, Side, Stance};
use crate::math::{Pose, Vec3};
use crate::planner::PosedMannequin;
use crate::training::{MotionLook, Residuals, SegmentQuality};
use nalgebra::Point3;

/// Size of the figure, px.
const SIZE: (f64, f64) = (1700.0, 1250.0);
const LEFT: f64 = 40.0;
/// Moments at which the person is drawn, and between which pixels down.
const MOMENTS: usize = 5;
const PEOPLE: (f64, f64) = (176.0, 640.0);
/// Panels of the second row, px.
const ANGLES: ((f64, f64), (f64, f64)) = ((120.0, 900.0), (780.0, 1090.0));
const NAMES: f64 = 1150.0;
const NEARNESS: [(f64, f64); 2] = [(1166.0, 1400.0), (1430.0, 1664.0)];
/// Most rows of segments.
const MOST_ROWS: usize = 10;
/// Most marks along an axis, about.
const MOST_TICKS: usize = 6;
/// Axes of residuals span at least so much, mm and deg.
const LEAST: [f64; 2] = [10.0, 5.0];

/// The way of the wrist: all of it, and before a moment.
const WHOLE_WAY: Pen = Pen { color: FAINT, width: 1.5, stroke: Stroke::Solid };
const LAST_WAY: Pen = Pen { color: VERMILION, width: 3.5, stroke: Stroke::Solid };
const LAST_S: f64 = 0.5;
const ANGLE_PENS: [Pen; 4] = [
    Pen { color: BLUE, width: 3.0, stroke: Stroke::Solid },
    Pen { color: VERMILION, width: 3.0, stroke: Stroke::Dashed },
    Pen { color: INK, width: 3.0, stroke: Stroke::Dotted },
    Pen { color: GREEN, width: 3.0, stroke: Stroke::Solid },
];
const MOMENT: Pen = Pen { color: FAINT, width: 1.5, stroke: Stroke::Dotted };
const SCATTER: Pen = Pen { color: BLUE, width: 8.0, stroke: Stroke::Solid };

/// What is drawn, and of whom.
#[derive(Debug, Clone, Copy)]
pub struct ImportPicture<'a> {
    /// Over the picture.
    pub title: &'a str,
    /// In which the movement is told.
    pub body: &'a Body,
    /// The movement.
    pub look: &'a MotionLook,
    /// How near the body comes to each segment; none where that is not known.
    pub quality: &'a [SegmentQuality],
}

impl ImportPicture<'_> {
    /// The hand that is followed, from whose side the person is seen.
    fn side(&self) -> Side {
        self.look.coupled.hands.lead()
    }
}

/// The person from the side at five moments with the way of the hand, main angles over time, and residuals, as
/// PNG.
///
/// # Errors
/// Where the picture cannot be drawn.
pub fn import_figure(picture: &ImportPicture) -> Result<Vec<u8>, ReportError> {
    png("import", (SIZE.0 as u32, SIZE.1 as u32), |sheet| {
        let kind = Type::bold(TITLE);
        let title = sheet.shortened(picture.title, SIZE.0 - 2.0 * LEFT, kind);
        sheet.text(&title, (LEFT, 36.0), kind, Anchor::Left)?;
        let moments = moments(picture.look.q.len());
        people(sheet, picture, &moments)?;
        angles(sheet, picture.look, &moments)?;
        nearness(sheet, picture.quality)?;
        let kind = Type::plain(TICK).colored(MUTED);
        sheet.paragraph(&note(picture), (LEFT, 1196.0), SIZE.0 - 2.0 * LEFT, kind)
    })
}

/// Rows at even distances from the first to the last.
fn moments(rows: usize) -> Vec<usize> {
    let mut at: Vec<usize> =
        (0..MOMENTS).map(|i| i * rows.saturating_sub(1) / (MOMENTS - 1)).collect();
    at.dedup();
    at.retain(|i| *i < rows);
    at
}

fn note(picture: &ImportPicture) -> String {
    let legs = match picture.look.coupled.pelvis {
        Pelvis::Rests | Pelvis::Turns => {
            "the pelvis rests, and legs are drawn as of people who stand"
        }
        Pelvis::Moves => "the view goes along with the feet where they step",
    };
    format!(
        "Body `{}`, {:.2} m, seen from its {}; {legs}. The head and the other arm are not those of the recording.",
        picture.body.name,
        picture.body.size.stature_m,
        picture.side().name()
    )
}

fn people(sheet: &Sheet, picture: &ImportPicture, moments: &[usize]) -> Drawn {
    let ahead = if picture.side() == Side::Right { 1.0 } else { -1.0 };
    let (look, body) = (Look::Side([ahead, 0.0]), picture.body);
    let stance = Stance::Standing { shoe_m: 0.0 };
    let mannequin =
        Mannequin::new(body, picture.look.coupled, stance).map_err(|e| e.to_string())?;
    // Facing world x.
    let rest = body.pelvis_pose([0.0, 0.0], 0.0, stance);
    let posed =
        |i: &usize| PosedMannequin::of(&mannequin, &rest, &picture.look.q[*i], Head::default());
    let posed: Vec<PosedMannequin> = moments.iter().map(posed).collect();
    let hand: Vec<[f64; 2]> =
        picture.look.hand.iter().map(|p| look.flat(in_world(&rest, p).into())).collect();
    let corners = posed.iter().filter_map(|p| mannequin::extent(p, look));
    let corners = corners.flat_map(|(low, high)| [low, high]);
    let finite = hand.iter().copied().filter(|p| p.iter().all(|v| v.is_finite()));
    let Some((low, high)) = super::figure_paths::extent(corners.chain(finite)) else {
        return Ok(());
    };
    let keys = [
        Key::Line(LAST_WAY, format!("way of the wrist in the last {LAST_S} s")),
        Key::Line(WHOLE_WAY, "in the whole movement".to_owned()),
    ];
    legend(sheet, (LEFT, 84.0), SIZE.0 - 2.0 * LEFT, &keys)?;
    let wide = (SIZE.0 - 2.0 * LEFT) / MOMENTS as f64;
    for (k, (person, i)) in posed.iter().zip(moments).enumerate() {
        let left = LEFT + wide * k as f64;
        if k > 0 {
            let pen = Pen { color: GRID, width: 2.0, stroke: Stroke::Solid };
            sheet.line(&[(left, 124.0), (left, PEOPLE.1 + 8.0)], pen)?;
        }
        let time = format!("{:.1} s", picture.look.time_s[*i]);
        sheet.text(&time, (left + 16.0, 138.0), Type::bold(LABEL), Anchor::Left)?;
        let panel = Panel {
            x_px: (left + 12.0, left + wide - 12.0),
            y_px: PEOPLE,
            x: (low[0] - 0.05, high[0] + 0.05),
            y: (low[1].min(0.0), high[1] + 0.05),
        };
        let panel = panel.equalised(panel.px_per_unit());
        let floor = Pen { color: FAINT, width: 2.0, stroke: Stroke::Solid };
        sheet.line(&[panel.at(panel.x.0, 0.0), panel.at(panel.x.1, 0.0)], floor)?;
        mannequin::draw(sheet, person, look, &panel)?;
        let line: Vec<At> = hand.iter().map(|[x, y]| panel.at(*x, *y)).collect();
        let now = picture.look.time_s[*i];
        let from = picture.look.time_s.partition_point(|t| *t < now - LAST_S);
        for (line, pen) in [(&line[..], WHOLE_WAY), (&line[from..=*i], LAST_WAY)] {
            if line.len() > 1 {
                sheet.line(line, pen)?;
            }
        }
        sheet.disc(line[*i], 7.0, VERMILION)?;
    }
    Ok(())
}

fn in_world(rest: &Pose, p: &Vec3) -> Vec3 {
    rest.transform_point(&Point3::from(*p)).coords
}

/// From the first to the last time; a second where there is none.
fn times(time_s: &[f64]) -> (f64, f64) {
    let to = time_s.last().copied().unwrap_or(0.0);
    (0.0, if to > 0.0 { to } else { 1.0 })
}

fn angles(sheet: &Sheet, look: &MotionLook, moments: &[usize]) -> Drawn {
    let (x_px, y_px) = ANGLES;
    let all = look.angles_deg.iter().flat_map(|(_, deg)| deg).copied().filter(|v| v.is_finite());
    let high = all.fold(10.0, f64::max);
    let panel = Panel { x_px, y_px, x: times(&look.time_s), y: (0.0, 1.06 * high) };
    let y_ticks = ticks(panel.y, MOST_TICKS);
    panel.grid_at(sheet, &y_ticks)?;
    for i in moments {
        let x = look.time_s[*i];
        sheet.line(&[panel.at(x, panel.y.0), panel.at(x, panel.y.1)], MOMENT)?;
    }
    let mut keys = Vec::new();
    for ((name, deg), pen) in look.angles_deg.iter().zip(ANGLE_PENS) {
        let line: Vec<At> = look.time_s.iter().zip(deg).map(|(t, v)| panel.at(*t, *v)).collect();
        if line.len() > 1 {
            sheet.line(&line, pen)?;
        }
        keys.push(Key::Line(pen, (*name).to_owned()));
    }
    panel.axes(sheet, Words { title: "", x: "time (s)", y: "angle (deg)" }, &y_ticks)?;
    sheet.text("Angles of the body", (x_px.0, y_px.0 - 68.0), Type::bold(TITLE), Anchor::Left)?;
    legend(sheet, (x_px.0, y_px.0 - 26.0), x_px.1 - x_px.0, &keys)?;
    Ok(())
}

fn nearness(sheet: &Sheet, quality: &[SegmentQuality]) -> Drawn {
    let top = ANGLES.1.0;
    let heading = (NEARNESS[0].0 - 200.0, top - 68.0);
    sheet.text("Recorded segments from the body", heading, Type::bold(TITLE), Anchor::Left)?;
    let muted = Type::plain(TICK).colored(MUTED);
    if quality.is_empty() {
        let at = (heading.0, top + 20.0);
        return sheet.text("not known: no quality.csv beside the motion", at, muted, Anchor::Left);
    }
    // The segments nearest to the hand are last, and stay where there are many.
    let shown = &quality[quality.len().saturating_sub(MOST_ROWS)..];
    let count = shown.len() as f64;
    let sides: [fn(&SegmentQuality) -> &Residuals; 2] = [|s| &s.place_mm, |s| &s.turn_deg];
    for (side, (of, x_px)) in sides.into_iter().zip(NEARNESS).enumerate() {
        let all = shown.iter().flat_map(|s| [of(s).constant, of(s).p95]);
        let high = all.filter(|v| v.is_finite()).fold(LEAST[side], f64::max);
        let panel = Panel { x_px, y_px: ANGLES.1, x: (0.0, 1.08 * high), y: (0.0, count) };
        let unit = ["joint centre (mm)", "axes (deg)"][side];
        panel.grid_at(sheet, &[])?;
        panel.axes(sheet, Words { title: "", x: unit, y: "" }, &[])?;
        for (i, segment) in shown.iter().enumerate() {
            let y = count - i as f64 - 0.5;
            let r = of(segment);
            if side == 0 {
                let at = (NAMES, panel.at(0.0, y).1);
                sheet.text(&segment.segment, at, Type::plain(TICK), Anchor::Right)?;
            }
            sheet.line(&[panel.at(r.median, y), panel.at(r.p95, y)], SCATTER)?;
            sheet.disc(panel.at(r.median, y), 6.0, BLUE)?;
            let (cx, cy) = panel.at(r.constant, y + 0.22);
            sheet.fill((cx - 6.0, cy - 6.0), (cx + 6.0, cy + 6.0), WHITE)?;
            sheet.outline((cx - 6.0, cy - 6.0), (cx + 6.0, cy + 6.0), VERMILION, 2.5)?;
        }
    }
    key_of_marks(sheet, (heading.0, top - 26.0))
}

fn key_of_marks(sheet: &Sheet, (x, y): At) -> Drawn {
    let kind = Type::plain(TICK);
    sheet.outline((x, y - 6.0), (x + 12.0, y + 6.0), VERMILION, 2.5)?;
    let text = "constant part";
    sheet.text(text, (x + 24.0, y), kind, Anchor::Left)?;
    let next = x + 24.0 + sheet.width(text, kind) + 36.0;
    sheet.line(&[(next + 8.0, y), (next + 56.0, y)], SCATTER)?;
    sheet.disc((next + 8.0, y), 6.0, BLUE)?;
    let text = "scatter about it: median to 95 %";
    sheet.text(text, (next + 68.0, y), kind, Anchor::Left)
}

#[cfg(test)]
mod tests {
    use super::super::drawn::drawn;
    use super::*;
    use crate::human::{Coupled, Side};
    use crate::training::Trial;

    fn body() -> Body {
        Body::load("female_p50", "".as_ref()).unwrap()
    }

    fn look(pelvis: Pelvis, rows: usize) -> MotionLook {
        let coupled = Coupled { hands: Side::Left.into(), pelvis };
        let dof = body().chain(coupled, &[]).unwrap().dof();
        let row = |i: usize| (0..dof).map(|c| 0.01 * ((i + c) as f64).sin()).collect::<Vec<_>>();
        let q: Vec<Vec<f64>> = (0..rows).map(row).collect();
        let trial = Trial {
            source: "a".into(),
            rate_hz: 50.0,
            qdot: q.clone(),
            q,
            stepping: Vec::new(),
            turn: Vec::new(),
        };
        MotionLook::new(&body(), Side::Left, &trial).unwrap()
    }

    fn quality(segment: &str) -> SegmentQuality {
        let place_mm = Residuals { constant: 12.0, median: 3.0, p95: 8.0 };
        SegmentQuality { segment: segment.to_owned(), place_mm, turn_deg: place_mm }
    }

    #[test]
    fn people_angles_and_residuals_are_drawn() {
        let body = body();
        let quality = ["T8", "LeftForeArm", "LeftHand"].map(quality);
        let look = look(Pelvis::Moves, 101);
        let picture =
            ImportPicture { title: "lift.csv", body: &body, look: &look, quality: &quality };
        let figure = drawn(|| import_figure(&picture));
        for (words, times) in [
            ("lift.csv", 1),
            ("0.0 s", 1),
            ("2.0 s", 1),
            ("LeftForeArm", 1),
            ("axes (deg)", 1),
            ("knees", 1),
        ] {
            assert_eq!(figure.says(words), times, "{words}");
        }
        assert_eq!(figure.lines(WHOLE_WAY).iter().filter(|l| l.len() == 101).count(), 5);
        // In the first moment there is nothing before it.
        assert_eq!(figure.lines(LAST_WAY).iter().filter(|l| l.len() == 26).count(), 4);
        assert_eq!(import_figure(&picture).unwrap(), import_figure(&picture).unwrap());
    }

    #[test]
    fn odd_movements_are_drawn() {
        let body = body();
        for rows in [1, 2, 3] {
            let look = look(Pelvis::Rests, rows);
            let picture = ImportPicture { title: "", body: &body, look: &look, quality: &[] };
            let figure = drawn(|| import_figure(&picture));
            assert_eq!(figure.mentions("no quality.csv"), 1);
            assert_eq!((figure.says("knees"), figure.says("trunk")), (0, 1));
        }
        assert_eq!(moments(0), [0usize; 0]);
        assert_eq!(moments(9), [0, 2, 4, 6, 8]);
        let many: Vec<SegmentQuality> = (0..12).map(|i| quality(&format!("S{i}"))).collect();
        let mut broken = many.clone();
        broken[11].place_mm.p95 = f64::NAN;
        let look = look(Pelvis::Rests, 20);
        for quality in [&many, &broken] {
            let picture = ImportPicture { title: "", body: &body, look: &look, quality };
            let figure = drawn(|| import_figure(&picture));
            assert_eq!((figure.says("S1"), figure.says("S2")), (0, 1));
        }
    }
}

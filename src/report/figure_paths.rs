//! Figure: the paths with person, robot and obstacles, from the side, the front and above.

use super::ReportError;
use super::panel::{Key, Panel, Words, legend};
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{
    BEST, FAINT, LABEL, MUTED, OBSTACLE, ORANGE, OTHER, OWN, Pen, STRAIGHT, Stroke, TICK, VERMILION,
};
use super::view::View;
use crate::math::Vec3;
use crate::planner::{CandidateResult, PosePicture, Setting};
use plotters::style::RGBColor;

const SIZE: (u32, u32) = (1600, 900);
/// Room for numbers at a panel's left, free room at the right end, px.
const LEFT: f64 = 112.0;
const RIGHT: f64 = 26.0;
/// Room around what is drawn, m.
const ROOM_M: f64 = 0.12;
const PERSON: RGBColor = RGBColor(60, 68, 82);
const ROBOT: RGBColor = RGBColor(0, 120, 88);

/// A way to look at the world: from the side or from above.
#[derive(Debug, Clone, Copy)]
pub(super) enum Look {
    Side([f64; 2]),
    /// Towards the worker, whose left is at the right.
    Front([f64; 2]),
    Top,
}

impl Look {
    /// The point in the plane of the view.
    pub(super) fn flat(self, p: [f64; 3]) -> [f64; 2] {
        match self {
            Self::Side([fx, fy]) => [fx * p[0] + fy * p[1], p[2]],
            Self::Front([fx, fy]) => [fx * p[1] - fy * p[0], p[2]],
            Self::Top => [p[0], p[1]],
        }
    }

    /// Directions in the world to the right and upwards in the view.
    pub(super) fn axes(self) -> [Vec3; 2] {
        match self {
            Self::Side([fx, fy]) => [Vec3::new(fx, fy, 0.0), Vec3::z()],
            Self::Front([fx, fy]) => [Vec3::new(-fy, fx, 0.0), Vec3::z()],
            Self::Top => [Vec3::x(), Vec3::y()],
        }
    }

    /// Direction towards the eye.
    pub(super) fn near(self) -> Vec3 {
        let [right, up] = self.axes();
        right.cross(&up)
    }

    /// The rectangle that bounds a box in the view.
    pub(super) fn bounds(self, low: [f64; 3], high: [f64; 3]) -> ([f64; 2], [f64; 2]) {
        let corners = (0..8).map(|i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
            self.flat([pick(0), pick(1), pick(2)])
        });
        extent(corners).unwrap_or_default()
    }
}

/// Lower and upper corner of points; none without any.
pub(super) fn extent(points: impl Iterator<Item = [f64; 2]>) -> Option<([f64; 2], [f64; 2])> {
    points.fold(None, |so_far, p| {
        let (low, high) = so_far.unwrap_or((p, p));
        Some(([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]))
    })
}

/// `figures/paths.png`.
pub(super) fn paths(view: &View) -> Result<Vec<u8>, ReportError> {
    png("paths", SIZE, |sheet| {
        let keys = keys(view);
        let took = legend(sheet, (110.0, 36.0), 1440.0, &keys)?;
        let y_px = (took + 76.0, f64::from(SIZE.1) - 84.0);
        let facing = view.result.setting.facing;
        let looks = [Look::Side(facing), Look::Front(facing), Look::Top];
        let ranges = looks.map(|look| shown(view, look));
        // The widths share the sheet as the views share the metres, so that one scale fits all.
        let wide = ranges.map(|(low, high)| high[0] - low[0]);
        let room = f64::from(SIZE.0) - 3.0 * LEFT - RIGHT;
        let mut left = 0.0;
        let mut panels = Vec::new();
        for ((low, high), wide_m) in ranges.into_iter().zip(wide) {
            let across = room * wide_m / wide.iter().sum::<f64>();
            let x_px = (left + LEFT, left + LEFT + across);
            panels.push(Panel { x_px, y_px, x: (low[0], high[0]), y: (low[1], high[1]) });
            left = x_px.1;
        }
        let scale = panels.iter().map(Panel::px_per_unit).fold(f64::INFINITY, f64::min);
        let panels = panels.into_iter().map(|p| p.equalised(scale));
        let [fx, fy] = view.result.setting.facing;
        let [along, across] = if fy.abs() < 1e-9 && fx > 0.0 {
            ["x, worker's forward (m)", "y, worker's left (m)"]
        } else {
            ["worker's forward (m)", "worker's left (m)"]
        };
        let words = [
            Words { title: "From the side", x: along, y: "height z (m)" },
            Words { title: "From the front", x: across, y: "height z (m)" },
            Words { title: "From above", x: "x (m)", y: "y (m)" },
        ];
        for ((look, panel), words) in looks.into_iter().zip(panels).zip(words) {
            draw(sheet, view, look, &panel)?;
            panel.axes(sheet, words, &panel.y_ticks())?;
        }
        Ok(())
    })
}

/// Everything that must be inside the picture; obstacles only where nothing else is known.
pub(super) fn shown(view: &View, look: Look) -> ([f64; 2], [f64; 2]) {
    let setting = &view.result.setting;
    let mut points: Vec<[f64; 3]> = vec![setting.start_m, setting.goal_m];
    for c in &view.reported {
        points.extend(c.path.iter().flat_map(|p| p.tcp.iter().map(|t| [t[0], t[1], t[2]])));
    }
    for pose in pictures(view).into_iter().flatten() {
        points.extend(pose.bones.iter().flatten());
        points.extend(&pose.robot);
    }
    if view.lead.is_none() && view.result.ends.is_empty() {
        points.extend(setting.obstacles.iter().flat_map(|(_, low, high)| [*low, *high]));
    }
    let flat = points.into_iter().filter(|p| p.iter().all(|v| v.is_finite()));
    let (low, high) = extent(flat.map(|p| look.flat(p))).unwrap_or(([0.0; 2], [1.0; 2]));
    ([low[0] - ROOM_M, low[1] - ROOM_M], [high[0] + ROOM_M, high[1] + ROOM_M])
}

/// The lead's pictures at start and goal, of the shown body; without a lead those of the cell.
fn pictures<'a>(view: &View<'a>) -> [Option<&'a PosePicture>; 2] {
    let Some(lead) = view.lead else { return [0, 1].map(|i| view.result.ends.get(i)) };
    let mut of = lead.poses.iter().filter(|p| Some(p.body.as_str()) == view.body);
    let first = of.next();
    [first, of.next_back()]
}

/// How far in front a path is drawn, and with which pen.
pub(super) fn role(view: &View, c: &CandidateResult) -> (u8, Pen) {
    if view.lead.is_some_and(|l| l.id == c.id) {
        (3, BEST)
    } else if view.straight.is_some_and(|s| s.id == c.id) {
        (1, STRAIGHT)
    } else if view.own.iter().any(|o| o.id == c.id) {
        (2, OWN)
    } else {
        (0, OTHER)
    }
}

/// The pen and the name of every kind of path, faint ones first.
fn lines<'a>(view: &View<'a>) -> Vec<(Pen, &'a CandidateResult)> {
    let mut all: Vec<(Pen, &CandidateResult)> = Vec::new();
    let mut order: Vec<_> = view.reported.iter().map(|c| (role(view, c), *c)).collect();
    order.sort_by_key(|((depth, _), _)| *depth);
    all.extend(order.into_iter().map(|((_, pen), c)| (pen, c)));
    all
}

fn keys(view: &View) -> Vec<Key> {
    let mut keys = Vec::new();
    if let Some(lead) = view.lead {
        keys.push(Key::Line(BEST, view.lead_name(lead)));
    }
    if view.straight.is_some() {
        keys.push(Key::Line(STRAIGHT, "straight path".into()));
    }
    for own in &view.own {
        keys.push(Key::Line(OWN, format!("your path ({})", own.id)));
    }
    if lines(view).iter().any(|(pen, _)| pen.color == FAINT) {
        keys.push(Key::Line(OTHER, "other paths of the report".into()));
    }
    let [start, goal] = pictures(view);
    if start.is_some_and(|p| !p.bones.is_empty()) {
        keys.push(Key::Line(bone_pen(false), "person at the start (mean posture)".into()));
    }
    if goal.is_some_and(|p| !p.bones.is_empty()) {
        keys.push(Key::Line(bone_pen(true), "person at the goal".into()));
    }
    if start.is_some_and(|p| !p.robot.is_empty()) {
        keys.push(Key::Line(robot_pen(false), "robot at the start".into()));
        keys.push(Key::Line(robot_pen(true), "robot at the goal".into()));
    }
    if !view.result.setting.obstacles.is_empty() {
        keys.push(Key::Field(OBSTACLE, "obstacle (bounding box)".into()));
    }
    keys
}

pub(super) fn bone_pen(lighter: bool) -> Pen {
    let color = if lighter { super::style::tint(PERSON, 0.45) } else { PERSON };
    Pen { color, width: if lighter { 3.5 } else { 5.0 }, stroke: Stroke::Solid }
}

pub(super) fn robot_pen(lighter: bool) -> Pen {
    let color = if lighter { super::style::tint(ROBOT, 0.5) } else { ROBOT };
    Pen { color, width: if lighter { 3.0 } else { 4.0 }, stroke: Stroke::Dashed }
}

/// The cell, the people and the paths in a panel.
pub(super) fn draw(sheet: &Sheet, view: &View, look: Look, panel: &Panel) -> Drawn {
    let setting = &view.result.setting;
    let at = |p: [f64; 3]| {
        let [x, y] = look.flat(p);
        panel.at(x, y)
    };
    ground(sheet, setting, look, panel)?;
    for (picture, lighter) in pictures(view).into_iter().zip([false, true]).rev() {
        if let Some(picture) = picture {
            figures(sheet, picture, look, panel, lighter)?;
        }
    }
    for (pen, candidate) in lines(view) {
        if let Some(path) = &candidate.path {
            let points: Vec<_> = path.tcp.iter().map(|t| at([t[0], t[1], t[2]])).collect();
            sheet.line(&points, pen)?;
        }
    }
    ends(sheet, at(setting.start_m), at(setting.goal_m))
}

/// Obstacles with their names, the grid, and the floor.
pub(super) fn ground(sheet: &Sheet, setting: &Setting, look: Look, panel: &Panel) -> Drawn {
    for (_, low, high) in &setting.obstacles {
        let (low, high) = look.bounds(*low, *high);
        if let Some((a, b)) = panel.clipped(low, high) {
            // See-through, so that one box in front of another stays visible.
            sheet.shape(&[a, (b.0, a.1), b, (a.0, b.1)], FAINT, 0.4)?;
            sheet.outline(a, b, MUTED, 1.5)?;
        }
    }
    panel.grid(sheet)?;
    for (name, low, high) in &setting.obstacles {
        let (low, high) = look.bounds(*low, *high);
        if let Some((a, b)) = panel.clipped(low, high) {
            let kind = Type::plain(TICK).colored(MUTED);
            // Inside the box near its lower edge, if it is wide enough for its name.
            if sheet.width(name, kind) + 20.0 < b.0 - a.0 && b.1 - a.1 > 36.0 {
                sheet.text(name, (b.0 - 10.0, b.1 - 20.0), kind, Anchor::Right)?;
            } else if a.1 - 30.0 > panel.y_px.0 {
                sheet.text(name, (0.5 * (a.0 + b.0), a.1 - 16.0), kind, Anchor::Middle)?;
            }
        }
    }
    if !matches!(look, Look::Top) && panel.y.0 < 0.0 {
        let floor = Pen { color: MUTED, width: 2.0, stroke: Stroke::Solid };
        sheet.line(&[panel.at(panel.x.0, 0.0), panel.at(panel.x.1, 0.0)], floor)?;
    }
    Ok(())
}

/// Person and robot in one posture.
pub(super) fn figures(
    sheet: &Sheet,
    picture: &PosePicture,
    look: Look,
    panel: &Panel,
    lighter: bool,
) -> Drawn {
    let at = |p: [f64; 3]| {
        let [x, y] = look.flat(p);
        panel.at(x, y)
    };
    let robot: Vec<_> = picture.robot.iter().map(|p| at(*p)).collect();
    if robot.len() > 1 {
        sheet.line(&robot, robot_pen(lighter))?;
    }
    for [a, b] in &picture.bones {
        sheet.line(&[at(*a), at(*b)], bone_pen(lighter))?;
    }
    for [_, b] in &picture.bones {
        sheet.disc(at(*b), 3.5, bone_pen(lighter).color)?;
    }
    Ok(())
}

/// Start and goal with their names, on the sides that face away from each other.
pub(super) fn ends(sheet: &Sheet, start: (f64, f64), goal: (f64, f64)) -> Drawn {
    let up = if start.1 >= goal.1 { 1.0 } else { -1.0 };
    let r = 8.0;
    sheet.disc(start, r, ORANGE)?;
    let corner = (goal.0 - r, goal.1 - r);
    sheet.fill(
        (corner.0 - 1.5, corner.1 - 1.5),
        (goal.0 + r + 1.5, goal.1 + r + 1.5),
        super::style::WHITE,
    )?;
    sheet.fill(corner, (goal.0 + r, goal.1 + r), VERMILION)?;
    let kind = Type::bold(LABEL);
    sheet.label("start", (start.0, start.1 + up * 30.0), kind, Anchor::Middle)?;
    sheet.label("goal", (goal.0, goal.1 - up * 30.0), kind, Anchor::Middle)
}

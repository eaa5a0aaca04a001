//! Figure: the cell as the scenario says it is, before any planning, with the measures that matter.

use super::ReportError;
use super::figure_paths::{Look, bone_pen, ends, extent, figures, ground, robot_pen};
use super::panel::{Key, Panel, Words, legend};
use super::sheet::{Anchor, Drawn, Sheet, Type, png};
use super::style::{BLUE, MUTED, OBSTACLE, Pen, Stroke, TICK};
use crate::planner::CellLook;

const SIZE: (u32, u32) = (1600, 1160);
/// Room around what is drawn, m.
const ROOM_M: f64 = 0.15;
const WORKSPACE: Pen = Pen { color: BLUE, width: 2.0, stroke: Stroke::Dotted };
const MEASURE: Pen = Pen { color: MUTED, width: 1.5, stroke: Stroke::Solid };

/// The cell from the side and from above as PNG.
pub fn cell_figure(look: &CellLook) -> Result<Vec<u8>, ReportError> {
    png("cell", SIZE, |sheet| {
        let took = legend(sheet, (110.0, 36.0), 1440.0, &keys(look))?;
        let y_px = (took + 76.0, f64::from(SIZE.1) - 84.0);
        let looks =
            [(Look::Side(look.setting.facing), (110.0, 780.0)), (Look::Top, (900.0, 1570.0))];
        let panels = looks.map(|(way, x_px)| {
            let (low, high) = shown(look, way);
            Panel { x_px, y_px, x: (low[0], high[0]), y: (low[1], high[1]) }
        });
        let scale = panels.iter().map(Panel::px_per_unit).fold(f64::INFINITY, f64::min);
        let words = [
            Words {
                title: "From the side",
                x: "distance along the worker's forward direction (m)",
                y: "height z (m)",
            },
            Words { title: "From above", x: "x (m)", y: "y (m)" },
        ];
        for (((way, _), panel), words) in looks.into_iter().zip(panels).zip(words) {
            let panel = panel.equalised(scale);
            draw(sheet, look, way, &panel)?;
            panel.axes(sheet, words, &panel.y_ticks())?;
        }
        Ok(())
    })
}

fn keys(look: &CellLook) -> Vec<Key> {
    let [start, goal] = &look.pictures;
    let mut keys = Vec::new();
    if !start.bones.is_empty() {
        keys.push(Key::Line(
            bone_pen(false),
            format!("{} at the start (mean posture)", start.body),
        ));
    }
    if !goal.bones.is_empty() {
        keys.push(Key::Line(bone_pen(true), format!("{} at the goal", goal.body)));
    }
    if !start.robot.is_empty() {
        keys.push(Key::Line(robot_pen(false), "robot at the start".into()));
    }
    if !goal.robot.is_empty() {
        keys.push(Key::Line(robot_pen(true), "robot at the goal".into()));
    }
    if look.workspace.is_some() {
        keys.push(Key::Line(WORKSPACE, "workspace of the TCP".into()));
    }
    if !look.setting.obstacles.is_empty() {
        keys.push(Key::Field(OBSTACLE, "obstacle (bounding box)".into()));
    }
    keys.push(Key::Line(MEASURE, "measures in metres".into()));
    keys
}

/// Everything but far obstacles; the floor from the side.
fn shown(look: &CellLook, way: Look) -> ([f64; 2], [f64; 2]) {
    let [x, y] = look.worker_at_m;
    let mut points = vec![look.setting.start_m, look.setting.goal_m, look.base_m, [x, y, 0.0]];
    points.extend(look.workspace.iter().flatten());
    for picture in &look.pictures {
        points.extend(picture.bones.iter().flatten());
        points.extend(&picture.robot);
    }
    let flat = points.into_iter().filter(|p| p.iter().all(|v| v.is_finite()));
    let (low, high) = extent(flat.map(|p| way.flat(p))).unwrap_or(([0.0; 2], [1.0; 2]));
    ([low[0] - ROOM_M, low[1] - ROOM_M], [high[0] + ROOM_M, high[1] + ROOM_M])
}

fn draw(sheet: &Sheet, look: &CellLook, way: Look, panel: &Panel) -> Drawn {
    let setting = &look.setting;
    let at = |p: [f64; 3]| {
        let [x, y] = way.flat(p);
        panel.at(x, y)
    };
    ground(sheet, setting, way, panel)?;
    if let Some([low, high]) = look.workspace {
        let (low, high) = way.bounds(low, high);
        let corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
        let around: Vec<_> =
            corners.iter().chain([&corners[0]]).map(|c| panel.at(c[0], c[1])).collect();
        sheet.line(&around, WORKSPACE)?;
    }
    measures(sheet, look, way, panel)?;
    for (picture, lighter) in look.pictures.iter().zip([false, true]).rev() {
        figures(sheet, picture, way, panel, lighter)?;
    }
    let base = at(look.base_m);
    sheet.fill(
        (base.0 - 9.0, base.1 - 9.0),
        (base.0 + 9.0, base.1 + 9.0),
        robot_pen(false).color,
    )?;
    let kind = Type::plain(TICK).colored(robot_pen(false).color);
    sheet.label("robot base", (base.0, base.1 + 28.0), kind, Anchor::Middle)?;
    ends(sheet, at(setting.start_m), at(setting.goal_m))
}

/// From the side: heights above the floor and ways forward from the worker. From above: the ways from
/// the worker to start, goal and robot, and between start and goal.
fn measures(sheet: &Sheet, look: &CellLook, way: Look, panel: &Panel) -> Drawn {
    let s = &look.setting;
    let [x, y] = look.worker_at_m;
    match way {
        Look::Side(_) | Look::Front(_) => {
            for p in [s.start_m, s.goal_m, look.base_m] {
                let [along, height] = way.flat(p);
                measure(sheet, panel, [along, 0.0], [along, height])?;
            }
            Ok(())
        }
        Look::Top => {
            let worker = [x, y];
            let flat = |p: [f64; 3]| [p[0], p[1]];
            measure(sheet, panel, worker, flat(s.start_m))?;
            measure(sheet, panel, worker, flat(s.goal_m))?;
            measure(sheet, panel, worker, flat(look.base_m))?;
            // Where the worker stands and looks.
            let place = panel.at(x, y);
            sheet.disc(place, 9.0, bone_pen(false).color)?;
            let nose = panel.at(x + 0.12 * s.facing[0], y + 0.12 * s.facing[1]);
            sheet.line(&[place, nose], Pen { width: 5.0, ..bone_pen(false) })
        }
    }
}

/// A line with its length at two fifths of it; nothing where it is shorter than its own words.
fn measure(sheet: &Sheet, panel: &Panel, a: [f64; 2], b: [f64; 2]) -> Drawn {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let (from, to) = (panel.at(a[0], a[1]), panel.at(b[0], b[1]));
    if (to.0 - from.0).hypot(to.1 - from.1) < 70.0 {
        return Ok(());
    }
    sheet.line(&[from, to], MEASURE)?;
    let middle = (from.0 + 0.6 * (to.0 - from.0), from.1 + 0.6 * (to.1 - from.1));
    let kind = Type::plain(TICK).colored(MUTED);
    sheet.label(&format!("{length:.2}"), middle, kind, Anchor::Middle)
}

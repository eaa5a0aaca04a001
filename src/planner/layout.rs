//! A first place for the robot of a sketched cell: the first of a few usual ones from which it reaches and
//! follows the straight path.

use super::cell_findings::CellFinding;
use super::cell_look::{CellLook, look_at_cell};
use crate::files::InputError;
use crate::human::Hands;
use crate::scenario::{Sketch, ToolWay, parse_scenario};
use std::path::Path;

/// How far behind the tool the robot stands, m.
const BEHIND_M: [f64; 7] = [0.6, 0.5, 0.7, 0.8, 0.4, 0.35, 0.3];
/// Height of its mount above the middle of the tool's way, m.
const ABOVE_M: [f64; 5] = [-0.3, -0.1, -0.5, 0.1, 0.3];
/// Heights of the hand between which a tool from above is usual, m.
const FROM_ABOVE_M: [f64; 2] = [0.7, 1.3];
/// To what places are rounded, 1/m: 5 cm.
const ROUND: f64 = 20.0;

/// What of a sketch is as its designer wants it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
    /// Where the tool points.
    pub tool: Option<ToolWay>,
    /// Floor point below the robot's mount, m.
    pub robot_at_m: Option<[f64; 2]>,
    /// Height of the mount, m.
    pub mount_height_m: Option<f64>,
}

/// The sketch with a place for its robot and a way for its tool, and the look of that cell at `path`.
/// Where no place serves, the one with the fewest faults.
pub fn lay_out(
    path: &Path,
    sketch: &Sketch,
    wanted: &Wanted,
) -> Result<(Sketch, CellLook), InputError> {
    let mut best: Option<(usize, Sketch, CellLook)> = None;
    for sketch in usual(sketch, wanted) {
        let look = look_at_cell(&parse_scenario(path, &sketch.text())?)?;
        let faults = faults_of_the_robot(&look);
        if best.as_ref().is_none_or(|b| faults < b.0) {
            best = Some((faults, sketch, look));
        }
        if faults == 0 {
            break;
        }
    }
    let (_, sketch, look) =
        best.ok_or_else(|| InputError::fault(path, "there is no usual place of a robot"))?;
    Ok((sketch, look))
}

/// The layouts that are tried, in order.
fn usual(sketch: &Sketch, wanted: &Wanted) -> Vec<Sketch> {
    let heights = [sketch.start_m[2], sketch.goal_m[2]];
    let is_from_above = sketch.hands != Hands::Both
        && heights.iter().all(|h| (FROM_ABOVE_M[0]..=FROM_ABOVE_M[1]).contains(h));
    let tools = match (wanted.tool, is_from_above) {
        (Some(tool), _) => vec![tool],
        (None, true) => vec![ToolWay::Down, ToolWay::AtWorker],
        (None, false) => vec![ToolWay::AtWorker, ToolWay::Down],
    };
    let rounded = |v: f64| (v * ROUND).round() / ROUND;
    let mut all: Vec<Sketch> = Vec::new();
    for tool in tools {
        let sketch = Sketch { tool, ..sketch.clone() };
        let off = sketch.tcp_from_hand_m();
        let middle: [f64; 3] =
            std::array::from_fn(|i| f64::midpoint(sketch.start_m[i], sketch.goal_m[i]) + off[i]);
        for above in ABOVE_M {
            for behind in BEHIND_M {
                let at = [rounded(middle[0] + behind), rounded(middle[1])];
                let layout = Sketch {
                    robot_at_m: wanted.robot_at_m.unwrap_or(at),
                    mount_height_m: wanted
                        .mount_height_m
                        .unwrap_or_else(|| rounded(middle[2] + above).max(0.0)),
                    ..sketch.clone()
                };
                if !all.contains(&layout) {
                    all.push(layout);
                }
            }
        }
    }
    all
}

/// How far from serving a layout is.
fn faults_of_the_robot(look: &CellLook) -> usize {
    let weight = |finding: &CellFinding| match finding {
        CellFinding::RobotOutOfReach(_) => 10,
        CellFinding::RobotTouches(_) => 5,
        CellFinding::RobotStopped(..) | CellFinding::RobotTouchesOnTheWay(_) => 1,
        _ => 0,
    };
    look.findings().iter().map(weight).sum()
}

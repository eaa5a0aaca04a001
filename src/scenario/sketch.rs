//! A cell in a designer's few words, and the scenario file that they make: commented, so that it teaches
//! the keys that matter.

use super::SCENARIO_SCHEMA;
use super::held::usual_hold;
use crate::human::{Hands, NamedGrip, Side};
use crate::path::PathLimits;
use crate::posture::Hold;
use std::fmt::Write as _;

/// Half the width of what both hands hold, m.
const HALF_WIDTH_M: f64 = 0.19;
/// How far before the tool, or below it, one hand holds on, and how far both do, m.
const BEFORE_M: f64 = 0.12;
const BOTH_BEFORE_M: f64 = 0.17;
/// Height of a seat that needs no footrest, m.
const LOW_SEAT_M: f64 = 0.38;
/// A minimum-jerk movement's greatest speed over its mean.
const PEAK: f64 = 1.875;
/// Room for other limits than that of the speed.
const LEEWAY: f64 = 1.15;

/// Which robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SketchRobot {
    /// A preset.
    Preset(String),
    /// A URDF, relative to the scenario, with its first link and the link of its TCP.
    Urdf {
        /// File.
        file: String,
        /// Link on the mount.
        base_link: String,
        /// Link of the TCP.
        tcp: String,
    },
}

/// Where the tool points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolWay {
    /// Down: the robot comes from above.
    Down,
    /// At the worker: the robot stands on the far side.
    AtWorker,
}

/// A cell as it is asked for. The worker stands or sits at the origin and looks along x.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketch {
    /// Name of the scenario.
    pub name: String,
    /// The robot.
    pub robot: SketchRobot,
    /// Who works.
    pub bodies: Vec<String>,
    /// The hands on the robot.
    pub hands: Hands,
    /// Height of the seat of somebody who sits, m.
    pub seat_height_m: Option<f64>,
    /// How each hand holds on.
    pub grip: NamedGrip,
    /// Place of the hand (the middle of both) at the start: ahead, left, up, m.
    pub start_m: [f64; 3],
    /// The same at the goal.
    pub goal_m: [f64; 3],
    /// Mass of the part, kg.
    pub part_mass_kg: f64,
    /// Share of its weight that the worker carries.
    pub load_share: f64,
    /// Where the tool points.
    pub tool: ToolWay,
    /// Floor point below the robot's mount, m.
    pub robot_at_m: [f64; 2],
    /// Height of the mount, m.
    pub mount_height_m: f64,
}

impl Sketch {
    /// Where the TCP is from the hand (the middle of both) at the start: ahead, left, up, m.
    pub fn tcp_from_hand_m(&self) -> [f64; 3] {
        match (self.tool, self.hands) {
            (ToolWay::AtWorker, Hands::Both) => [BOTH_BEFORE_M, 0.0, 0.0],
            (ToolWay::AtWorker, _) => [BEFORE_M, 0.0, 0.0],
            (ToolWay::Down, _) => [0.0, 0.0, BEFORE_M],
        }
    }

    /// Half a second or more above what the speed allows.
    fn duration_s(&self) -> f64 {
        let way = (0..3).map(|i| (self.goal_m[i] - self.start_m[i]).powi(2)).sum::<f64>().sqrt();
        let least = LEEWAY * PEAK * way / PathLimits::default().speed_m_s;
        ((2.0 * least).ceil() / 2.0).max(2.0)
    }

    /// The scenario file.
    pub fn text(&self) -> String {
        let mut text = format!(
            "# A cell for ergopath. Metres, seconds, kilograms; the world's x runs ahead of the worker, y to the\n\
             # left, z up from the floor. Every number here is one to check with a tape. Then:\n\
             #   ergopath check FILE --figure cell.png             what a plan would run into, and a drawing\n\
             #   ergopath plan FILE --planner quick -o out         a first look; open out/report.html\n\
             schema = \"{SCENARIO_SCHEMA}\"\nname = {}\nseed = 1\n",
            quoted(&self.name)
        );
        self.worker(&mut text);
        self.grip(&mut text);
        self.robot(&mut text);
        self.ends(&mut text);
        self.rest(&mut text);
        text
    }

    fn worker(&self, text: &mut String) {
        let bodies: Vec<String> = self.bodies.iter().map(|b| quoted(b)).collect();
        let hands = match self.hands {
            Hands::Right => "right",
            Hands::Left => "left",
            Hands::Both => "both",
        };
        let _ = write!(
            text,
            "\n# Who works: one or more bodies (`ergopath body` makes others), and whose movements they have.\n\
             # \"people\" are five recorded people, not yours; the guide's page on recordings says how to train your own.\n\
             [worker]\nbodies = [{}]\nposture_model = \"people\"\n{}",
            bodies.join(", "),
            noted(&format!("hands = \"{hands}\""), "right, left or both")
        );
        match self.seat_height_m {
            Some(seat) => {
                let footrest = ((seat - LOW_SEAT_M) * 100.0).round() / 100.0;
                let _ = writeln!(text, "stance = \"seated\"\nseat_height_m = {seat}");
                if footrest > 0.0 {
                    let key = format!("footrest_m = {footrest}");
                    text.push_str(&noted(&key, "without it shorter legs hang from this seat"));
                }
            }
            None => text.push_str("stance = \"standing\"\n"),
        }
        text.push_str(&noted("at_m = [0.0, 0.0]", "floor point between the feet, below the hips"));
        text.push_str(&noted("facing_deg = 0", "0 looks along x, 90 along y"));
    }

    fn grip(&self, text: &mut String) {
        let others = NamedGrip::names().join(", ");
        let mut comment = String::from(
            "# How the hand holds on at the start, as the worker sees it, and where it is from the tool's centre\n\
             # point: ahead, to the left, up.",
        );
        let mut line = String::from("\n# Grips:");
        for word in others.split(' ') {
            if line.len() + word.len() > 108 {
                comment.push_str(&line);
                line = String::from("\n#  ");
            }
            line.push(' ');
            line.push_str(word);
        }
        comment.push_str(&line);
        let hold = match usual_hold(self.grip) {
            Hold::FreeRoll => noted(
                "hold = \"free_roll\"",
                "the hand may turn about the bar; \"rigid\": it may not; \"point\": as it likes",
            ),
            _ => noted("hold = \"rigid\"", "the hand turns with the tool; \"point\": as it likes"),
        };
        let away = self.tcp_from_hand_m().map(|v| if v == 0.0 { 0.0 } else { -v });
        let of = |table: &str, left: f64| {
            let [x, y, z] = [away[0], away[1] + left, away[2]];
            format!(
                "[{table}]\ngrip = \"{}\"\nfrom_tcp_m = [{x:?}, {y:?}, {z:?}]\n{hold}",
                self.grip.name()
            )
        };
        let tables = match self.hands {
            Hands::Both => [Side::Right, Side::Left]
                .map(|side| {
                    let left = match side {
                        Side::Right => -HALF_WIDTH_M,
                        Side::Left => HALF_WIDTH_M,
                    };
                    of(&format!("grip.{}", side.name()), left)
                })
                .join("\n"),
            _ => of("grip", 0.0),
        };
        let _ = write!(text, "\n{comment}\n{tables}");
    }

    fn robot(&self, text: &mut String) {
        text.push_str("\n# The robot: the floor point below its mount, the mount's height, and where its x axis points.\n[robot]\n");
        match &self.robot {
            SketchRobot::Preset(name) => {
                let _ = writeln!(text, "preset = {}", quoted(name));
            }
            SketchRobot::Urdf { file, base_link, tcp } => {
                let _ = writeln!(
                    text,
                    "urdf = {}\nbase_link = {}\ntcp = {}",
                    quoted(file),
                    quoted(base_link),
                    quoted(tcp)
                );
            }
        }
        let [x, y] = self.robot_at_m;
        let _ = writeln!(
            text,
            "base = {{ at_m = [{x:?}, {y:?}], mount_height_m = {:?}, x_along = [-1, 0, 0] }}",
            self.mount_height_m
        );
    }

    fn ends(&self, text: &mut String) {
        let whose =
            if self.hands == Hands::Both { "the middle between the hands" } else { "the hand" };
        let pointing = match self.tool {
            ToolWay::Down => noted("pointing = [0, 0, -1]", "the tool points down"),
            ToolWay::AtWorker => noted("pointing = [-1, 0, 0]", "the tool points at the worker"),
        };
        let _ = write!(
            text,
            "\n# Where {whose} is, and where the tool points.\n\
             [start]\nhand_at_m = {:?}\n{pointing}\n[goal]\nhand_at_m = {:?}\n{pointing}",
            self.start_m, self.goal_m
        );
    }

    fn rest(&self, text: &mut String) {
        let duration = noted(
            &format!("duration_s = {:?}", self.duration_s()),
            &format!(
                "from rest to rest; the tool keeps below limits.speed_m_s = {}",
                PathLimits::default().speed_m_s
            ),
        );
        let share = noted(
            &format!("human_load_share = {:?}", self.load_share),
            "1: the worker carries all of it",
        );
        let _ = write!(
            text,
            "\n[motion]\n{duration}\n\
             # What no path shows: the load, how much of it the robot leaves to the worker, how often and how long.\n\
             [task]\npart_mass_kg = {:?}\n{share}cycles_per_min = 2\nhold_s = 2\n\n\
             # What the robot must not touch; one table each. For example a bench, by its middle and its widths:\n\
             # [[obstacle]]\n# name = \"bench\"\n# shape = \"box\"\n# position_m = [1.0, 0.0, 0.36]\n# size_m = [0.8, 1.6, 0.72]\n\n\
             # What the planner may choose besides the path. For example the goal's height by 5 cm either way:\n\
             # [free]\n# goal_box_m = [0, 0, 0.05]\n",
            self.part_mass_kg
        );
    }
}

/// A line with a remark, all remarks in one column.
fn noted(line: &str, remark: &str) -> String {
    format!("{line:<30}# {remark}\n")
}

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

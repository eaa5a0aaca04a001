//! Six families of workstations, drawn by seed and written as scenario files.

use crate::math::Vec3;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::fmt::Write as _;

/// A kind of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A part from a tray to a fixture.
    Bench,
    /// A part up to a joint overhead.
    Overhead,
    /// A part out of a bin between walls; raised to where straight legs do.
    LowBin,
    /// From one side to the other.
    LateralHandOver,
    /// Over a table, seated.
    SeatedTable,
    /// A load from low to a shelf; raised to where straight legs do.
    ShelfLift,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 6] = [
        Self::Bench,
        Self::Overhead,
        Self::LowBin,
        Self::LateralHandOver,
        Self::SeatedTable,
        Self::ShelfLift,
    ];

    /// Name in words; what differs from the family's own heights is said.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bench => "bench pick and place",
            Self::Overhead => "overhead assembly",
            Self::LowBin => "low bin (z 0.55 to 0.7 m)",
            Self::LateralHandOver => "lateral hand-over",
            Self::SeatedTable => "seated table",
            Self::ShelfLift => "shelf lift (z 0.7 to 1.4 m)",
        }
    }

    fn key(self) -> &'static str {
        match self {
            Self::Bench => "bench",
            Self::Overhead => "overhead",
            Self::LowBin => "low_bin",
            Self::LateralHandOver => "lateral",
            Self::SeatedTable => "seated",
            Self::ShelfLift => "shelf",
        }
    }
}

/// One drawn workstation.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Its family.
    pub family: Family,
    /// Short name of the scenario.
    pub name: String,
    /// TCP at the start and at the goal, world, m.
    pub ends: [Vec3; 2],
    /// Box in which demonstrations start and end, world, m.
    pub demonstrated: [Vec3; 2],
    /// Mass of the part, kg.
    pub mass_kg: f64,
}

/// Draws a workstation; `is_low` at the heights for which legs would have to bend.
pub fn draw(family: Family, number: u64, is_low: bool, rng: &mut ChaCha8Rng) -> Station {
    let mut about = |centre: [f64; 3], half: [f64; 3]| {
        Vec3::from_fn(|i, _| {
            let u: f64 = rng.random();
            round(centre[i] + half[i] * (2.0 * u - 1.0))
        })
    };
    let (start, goal) = match family {
        Family::Bench => (
            about([0.42, -0.35, 0.98], [0.05, 0.08, 0.06]),
            about([0.44, 0.12, 1.15], [0.05, 0.08, 0.10]),
        ),
        Family::Overhead => (
            about([0.40, -0.25, 1.05], [0.05, 0.08, 0.06]),
            about([0.36, -0.06, 1.52], [0.04, 0.08, 0.06]),
        ),
        Family::LowBin if is_low => (
            about([0.50, -0.25, 0.35], [0.05, 0.06, 0.05]),
            about([0.42, 0.05, 1.05], [0.05, 0.08, 0.05]),
        ),
        Family::LowBin => (
            about([0.42, -0.25, 0.66], [0.04, 0.06, 0.04]),
            about([0.42, 0.05, 1.05], [0.05, 0.08, 0.05]),
        ),
        Family::LateralHandOver => (
            about([0.36, -0.50, 1.05], [0.04, 0.04, 0.06]),
            about([0.38, 0.33, 1.08], [0.04, 0.05, 0.06]),
        ),
        Family::SeatedTable => (
            about([0.38, -0.30, 0.90], [0.05, 0.08, 0.05]),
            about([0.44, 0.10, 1.02], [0.04, 0.08, 0.08]),
        ),
        Family::ShelfLift if is_low => (
            about([0.42, -0.20, 0.32], [0.03, 0.05, 0.02]),
            about([0.42, -0.10, 1.38], [0.04, 0.08, 0.03]),
        ),
        Family::ShelfLift => (
            about([0.40, -0.22, 0.72], [0.03, 0.05, 0.02]),
            about([0.42, -0.10, 1.38], [0.04, 0.08, 0.03]),
        ),
    };
    let mass_kg = match family {
        Family::ShelfLift => round(2.2 + 2.8 * rng.random::<f64>()),
        _ => 0.5,
    };
    let margin = Vec3::new(0.04, 0.08, 0.08);
    let demonstrated = [start.inf(&goal) - margin, start.sup(&goal) + margin];
    let name = format!("{}_{number}{}", family.key(), if is_low { "_low" } else { "" });
    Station { family, name, ends: [start, goal], demonstrated, mass_kg }
}

/// To a millimetre: a file that people can read.
fn round(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

/// Seat height of the seated family, m.
const SEAT_M: f64 = 0.45;

impl Station {
    /// The scenario file, for a body and a posture model by name. Room between robot and person is not
    /// asked for: the robot stands where it does without regard to it.
    pub fn scenario(&self, body: &str, model: &str, seed: u64) -> String {
        let is_seated = self.family == Family::SeatedTable;
        let stance = if is_seated {
            format!("stance = \"seated\"\nseat_height_m = {SEAT_M}")
        } else {
            "stance = \"standing\"".to_owned()
        };
        let [start, goal] = self.ends.map(|p| format!("[{}, {}, {}]", p.x, p.y, p.z));
        let mut text = format!(
            "schema = \"ergopath/scenario/1\"\nname = \"{}\"\ndescription = \"{}, drawn by ErgoBench\"\n\
             seed = {seed}\n\n[worker]\nbodies = [\"{body}\"]\nposture_model = \"{model}\"\nhands = \"right\"\n\
             neck = \"neutral\"\n             {stance}\nat_m = [0.0, 0.0]\nfacing_deg = 0\n\n[grip]\nrpy_deg = [180, 0, -90]\nhold = \"rigid\"\n\n\
             [robot]\npreset = \"panda\"\nbase = {{ position_m = [0.85, 0.0, {}], rpy_deg = [0, 0, 180] }}\n\n\
             [start]\nposition_m = {start}\nrpy_deg = [180, 0, 0]\n\n[goal]\nposition_m = {goal}\n\
             rpy_deg = [180, 0, 0]\n\n[motion]\nduration_s = 4.0\n\n[workspace]\nmin_m = [0.22, -0.70, 0.25]\n\
             max_m = [0.80, 0.60, 1.75]\n\n[limits]\nspeed_m_s = 0.6\nperson_clearance_share = 1.0\n\n[task]\npart_mass_kg = {}\n\
             human_load_share = 1.0\ncycles_per_min = 3\nhold_s = 0\ncoupling = \"good\"\n",
            self.name,
            self.family.name(),
            self.base_height_m(),
            self.mass_kg,
        );
        for (name, centre, size) in self.obstacles() {
            let _ = write!(
                text,
                "\n[[obstacle]]\nname = \"{name}\"\nshape = \"box\"\nposition_m = [{}, {}, {}]\n\
                 size_m = [{}, {}, {}]\n",
                centre.x, centre.y, centre.z, size.x, size.y, size.z
            );
        }
        text
    }

    /// Height of the robot's base, m: where it reaches both ends.
    fn base_height_m(&self) -> f64 {
        let low = self.ends[0].z.min(self.ends[1].z);
        match self.family {
            Family::Overhead => 1.0,
            _ if low < 0.5 => 0.4,
            _ => 0.75,
        }
    }

    fn obstacles(&self) -> Vec<(&'static str, Vec3, Vec3)> {
        match self.family {
            // A table under the hands, short of the worker's own place.
            Family::SeatedTable => {
                vec![("table", Vec3::new(0.70, 0.0, 0.36), Vec3::new(0.8, 1.4, 0.72))]
            }
            // Two walls of the bin, a hand's breadth on each side of the part.
            Family::LowBin => {
                let at = self.ends[0];
                let wall =
                    |side: f64| Vec3::new(at.x, round(at.y + 0.17 * side), round(at.z - 0.22));
                let size = Vec3::new(0.36, 0.02, 0.20);
                vec![("bin wall right", wall(-1.0), size), ("bin wall left", wall(1.0), size)]
            }
            _ => Vec::new(),
        }
    }
}

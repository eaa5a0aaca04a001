//! Nine families of workstations, drawn by seed and written as scenario files.
//!
//! Six are for an arm on a pelvis that rests. Three ask for legs that bend, and are for a whole person.

use super::people::{Contacts, HALF_CRATE_M, LEAN};
use crate::human::{Hands, Side};
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
    /// A part out of a bin on the floor, by a whole person.
    DeepBin,
    /// A load from the floor to a shelf, by a whole person.
    FloorLift,
    /// A crate from low to a table with both hands, by a whole person; the robot carries a part of it.
    TwoHandedLift,
}

/// Share of a crate's weight that is left to the person.
const CRATE_SHARE: f64 = 0.4;

impl Family {
    /// All families.
    pub const ALL: [Self; 9] = [
        Self::Bench,
        Self::Overhead,
        Self::LowBin,
        Self::LateralHandOver,
        Self::SeatedTable,
        Self::ShelfLift,
        Self::DeepBin,
        Self::FloorLift,
        Self::TwoHandedLift,
    ];

    /// Whether a whole person is needed: pelvis, trunk and arms move, and the legs follow.
    pub fn is_whole(self) -> bool {
        self.contacts().is_whole()
    }

    /// How its people take part; whole ones expect the weight that is usual here.
    pub(super) fn contacts(self) -> Contacts {
        match self {
            Self::DeepBin => Contacts::whole(Hands::Right, 0.5),
            Self::FloorLift => Contacts::whole(Hands::Right, 3.6),
            Self::TwoHandedLift => Contacts::whole(Hands::Both, 7.0 * CRATE_SHARE),
            _ => Contacts::arm(Side::Right),
        }
    }

    /// The shipped posture model that stands in for a person's before it is learned.
    pub(super) fn stand_in(self) -> &'static str {
        if self.is_whole() { "whole_operator" } else { "demo_operator" }
    }

    /// Name in words; what differs from the family's own heights is said.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bench => "bench pick and place",
            Self::Overhead => "overhead assembly",
            Self::LowBin => "low bin (z 0.55 to 0.7 m)",
            Self::LateralHandOver => "lateral hand-over",
            Self::SeatedTable => "seated table",
            Self::ShelfLift => "shelf lift (z 0.7 to 1.4 m)",
            Self::DeepBin => "deep bin (z 0.3 to 0.4 m)",
            Self::FloorLift => "floor lift (z 0.3 to 1.4 m)",
            Self::TwoHandedLift => "two-handed lift (z 0.35 to 1.15 m)",
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
            Self::DeepBin => "deep_bin",
            Self::FloorLift => "floor_lift",
            Self::TwoHandedLift => "two_handed",
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

/// Draws a workstation.
pub fn draw(family: Family, number: u64, rng: &mut ChaCha8Rng) -> Station {
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
        Family::DeepBin => (
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
        Family::FloorLift => (
            about([0.42, -0.20, 0.32], [0.03, 0.05, 0.02]),
            about([0.42, -0.10, 1.38], [0.04, 0.08, 0.03]),
        ),
        Family::ShelfLift => (
            about([0.40, -0.22, 0.72], [0.03, 0.05, 0.02]),
            about([0.42, -0.10, 1.38], [0.04, 0.08, 0.03]),
        ),
        Family::TwoHandedLift => (
            about([0.64, 0.0, 0.45], [0.03, 0.04, 0.10]),
            about([0.60, 0.0, 1.02], [0.03, 0.06, 0.12]),
        ),
    };
    let mass_kg = match family {
        Family::ShelfLift | Family::FloorLift => round(2.2 + 2.8 * rng.random::<f64>()),
        Family::TwoHandedLift => round(4.0 + 6.0 * rng.random::<f64>()),
        _ => 0.5,
    };
    let margin = Vec3::new(0.04, 0.08, 0.08);
    let demonstrated = [start.inf(&goal) - margin, start.sup(&goal) + margin];
    let name = format!("{}_{number}", family.key());
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
        let (robot, base) = self.robot();
        let is_crate = self.family == Family::TwoHandedLift;
        let hands = if is_crate { "both" } else { "right" };
        let share = if is_crate { format!("{CRATE_SHARE}") } else { "1.0".to_owned() };
        // The TCP points down, or at the worker with the crate before it.
        let turn = if is_crate { "[0, -90, 0]" } else { "[180, 0, 0]" };
        let grip = self.grip();
        let mut text = format!(
            "schema = \"ergopath/scenario/1\"\nname = \"{}\"\ndescription = \"{}, drawn by ErgoBench\"\n\
             seed = {seed}\n\n[worker]\nbodies = [\"{body}\"]\nposture_model = \"{model}\"\nhands = \"{hands}\"\n\
             neck = \"neutral\"\n             {stance}\nat_m = [0.0, 0.0]\nfacing_deg = 0\n\n{grip}\n\
             [robot]\npreset = \"{robot}\"\nbase = {{ position_m = {base}, rpy_deg = [0, 0, 180] }}\n\n\
             [start]\nposition_m = {start}\nrpy_deg = {turn}\n\n[goal]\nposition_m = {goal}\n\
             rpy_deg = {turn}\n\n[motion]\nduration_s = 4.0\n\n[workspace]\nmin_m = [0.22, -0.70, 0.25]\n\
             max_m = [0.80, 0.60, 1.75]\n\n[limits]\nspeed_m_s = 0.6\nperson_clearance_share = 1.0\n\n[task]\npart_mass_kg = {}\n\
             human_load_share = {share}\ncycles_per_min = 3\nhold_s = 0\ncoupling = \"good\"\n",
            self.name,
            self.family.name(),
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

    /// Who holds what: an upright bar on the TCP; a bar that leans forward and may turn in the hand; or two
    /// of them on the sides of a crate.
    fn grip(&self) -> String {
        let lean = round(LEAN.to_degrees());
        if !self.family.is_whole() {
            return "[grip]\nrpy_deg = [180, 0, -90]\nhold = \"rigid\"\n".to_owned();
        }
        if self.family != Family::TwoHandedLift {
            let about_x = 180.0 + lean;
            return format!("[grip]\nrpy_deg = [{about_x}, 0, -90]\nhold = \"free_roll\"\n");
        }
        let hand = |name: &str, sideways: f64| {
            let about_x = 90.0 + lean;
            format!(
                "[grip.{name}]\nposition_m = [0.0, {sideways}, 0.17]\nrpy_deg = [{about_x}, 0, 90]\n\
                 hold = \"free_roll\"\n"
            )
        };
        format!("{}\n{}", hand("right", -HALF_CRATE_M), hand("left", HALF_CRATE_M))
    }

    /// The robot and where its base is, m: where it reaches both ends.
    fn robot(&self) -> (&'static str, &'static str) {
        match self.family {
            Family::Overhead => ("panda", "[0.85, 0.0, 1]"),
            Family::DeepBin | Family::FloorLift => ("ur10e", "[1.15, 0.0, 0.6]"),
            Family::TwoHandedLift => ("ur10e", "[1.4, 0.0, 0.4]"),
            _ => ("panda", "[0.85, 0.0, 0.75]"),
        }
    }

    fn obstacles(&self) -> Vec<(&'static str, Vec3, Vec3)> {
        match self.family {
            // A table under the hands, short of the worker's own place.
            Family::SeatedTable => {
                vec![("table", Vec3::new(0.70, 0.0, 0.36), Vec3::new(0.8, 1.4, 0.72))]
            }
            // Two walls of the bin, a hand's breadth on each side of the part.
            Family::LowBin | Family::DeepBin => {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::Body;
    use crate::math::stream::{Purpose, stream};
    use crate::scenario::read_scenario;

    #[test]
    fn scenarios_have_the_hands_and_bars_that_their_people_know() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("scenario.toml");
        let body = Body::load("female_p50", room.path()).unwrap();
        for (f, family) in Family::ALL.into_iter().enumerate() {
            let mut rng = stream(3, Purpose::Simulation, 20, f as u32);
            let station = draw(family, 0, &mut rng);
            let text = station.scenario(&body.name, family.stand_in(), 3);
            std::fs::write(&file, text).unwrap();
            let s = read_scenario(&file).unwrap();
            let contacts = family.contacts();
            assert_eq!(s.worker.coupled(), contacts.coupled, "{}", family.name());
            assert_eq!(s.hold, contacts.hold, "{}", family.name());
            // The grips at the start, as the scenario has them and as the person thinks of them there.
            let w = &s.worker;
            let rest = body.pelvis_pose(w.at_m, w.facing, w.stance).inverse();
            let first = rest * s.start * s.grip;
            let second = s.second_hand.map(|other| first * other.between);
            let at = |a: &crate::math::Pose| a.translation.vector;
            let middle = second.map_or(at(&first), |b| (at(&first) + at(&b)) * 0.5);
            let known = contacts.grips(middle);
            for (own, seen) in known.iter().zip([Some(first), second].into_iter().flatten()) {
                assert!((at(own) - at(&seen)).norm() < 1e-9, "{}", family.name());
                assert!(own.rotation.angle_to(&seen.rotation) < 1e-6, "{}", family.name());
            }
            assert_eq!(known.second.is_some(), second.is_some());
        }
    }

    #[test]
    fn crates_come_from_low_and_are_carried_together() {
        for number in 0..40 {
            let mut rng = stream(4, Purpose::Simulation, 20, number);
            let s = draw(Family::TwoHandedLift, 0, &mut rng);
            assert!((0.35..=0.55).contains(&s.ends[0].z) && (0.9..=1.14).contains(&s.ends[1].z));
            assert!((4.0..=10.0).contains(&s.mass_kg), "{} kg", s.mass_kg);
        }
    }
}

//! What a simulated person shows of themselves: movements at the workstation, never the planned one. Who
//! works with both hands shows both; the learner takes from it, as from recordings, trunk and leading arm.

use super::families::Station;
use super::people::{Manner, TruePerson};
use crate::files::InputError;
use crate::human::{Body, Coupled};
use crate::math::pose::interpolate;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{Behaviour, Coupling, Grips, Hold, Start, StartRule};
use crate::scenario::Scenario;
use crate::training::{Trial, trial_of};
use nalgebra::UnitQuaternion;
use rand::RngExt as _;

/// Samples per second of a demonstration.
const RATE_HZ: f64 = 30.0;
/// Block of chance.
const BLOCK: u32 = 100_000;
/// Repetitions that must reach both ends of a workstation.
const LOOKS: usize = 16;
/// Movements that are tried for each that is wanted.
const TRIES: u32 = 40;

/// A person at a workstation, showing movements.
pub(super) struct Demonstrator<'a> {
    scenario: &'a Scenario,
    coupling: Coupling,
    person: &'a TruePerson,
    world_to_rest: Pose,
    /// Joints up to the leading hand, which come first.
    led: usize,
}

impl<'a> Demonstrator<'a> {
    pub(super) fn new(
        scenario: &'a Scenario,
        body: &Body,
        person: &'a TruePerson,
    ) -> Result<Self, InputError> {
        let w = &scenario.worker;
        let rest = body.pelvis_pose(w.at_m, w.facing, w.stance);
        let second = scenario.second_hand.map(|s| s.hold);
        let holds: Vec<Hold> = std::iter::once(scenario.hold).chain(second).collect();
        let held = (w.stance, scenario.task.load_kg);
        let coupling = Coupling::of_person(body, w.coupled(), &holds, held)?;
        let leading = Coupled { hands: w.hands.lead().into(), pelvis: w.pelvis };
        let led = body.chain(leading, &[])?.dof();
        Ok(Self { scenario, coupling, person, world_to_rest: rest.inverse(), led })
    }

    fn grips(&self, tcp: &Pose) -> Grips {
        let first = self.world_to_rest * tcp * self.scenario.grip;
        Grips { first, second: self.scenario.second_hand.map(|s| first * s.between) }
    }

    fn starts(&self, grips: &Grips, block: (u64, u32), count: usize) -> Vec<Start> {
        let rule = StartRule::Sampled;
        self.person.starts(&self.coupling, grips, None, &rule, block, 0..count)
    }

    /// Whether every repetition gets the hands to a TCP pose.
    pub(super) fn reaches(&self, tcp: &Pose) -> bool {
        self.starts(&self.grips(tcp), (0, 0), LOOKS).iter().all(|s| s.q.is_some())
    }

    /// Movements between random places about the workstation's: never the path that is planned.
    pub(super) fn demonstrate(&self, station: &Station, seed: u64, count: usize) -> Vec<Trial> {
        let mut trials = Vec::new();
        for draw in 0..TRIES * count as u32 {
            if trials.len() == count {
                break;
            }
            trials.extend(self.movement(station, seed, draw));
        }
        trials
    }

    fn movement(&self, station: &Station, seed: u64, number: u32) -> Option<Trial> {
        let mut rng = stream(seed, Purpose::Simulation, 21, number);
        let Manner { tilt_rad, turn_rad, tempo } = self.person.manner();
        let [low, high] = station.demonstrated;
        let longest = (high - low).imax();
        let mut place = || {
            let part = Vec3::from_fn(|_, _| rng.random::<f64>());
            let at = low + (high - low).component_mul(&part);
            // Outwards to the right, and up.
            let along = (2.0 * part[longest] - 1.0) * if longest == 1 { -1.0 } else { 1.0 };
            let tilt = Vec3::from_vec(normals(&mut rng, 3)) * tilt_rad;
            let turn = tilt + Vec3::x() * (turn_rad * along);
            let turned = UnitQuaternion::from_scaled_axis(turn) * self.scenario.start.rotation;
            Pose::from_parts(at.into(), turned)
        };
        let (from, to) = (place(), place());
        let distance = (from.translation.vector - to.translation.vector).norm();
        if distance < 0.2 {
            return None;
        }
        // A bend across the way: not all of life is straight.
        let bend = Vec3::from_vec(normals(&mut rng, 3)) * (0.12 * distance);
        let duration = (1.6 + rng.random::<f64>()) / tempo;
        let count = (duration * RATE_HZ).round() as usize;
        let times: Vec<f64> = (0..=count).map(|i| i as f64 / RATE_HZ).collect();
        let grips: Vec<Grips> = (0..=count)
            .map(|i| {
                let [s, ..] = crate::trajectory::minimum_jerk(i as f64 / count as f64);
                let mut tcp = interpolate(&from, &to, s);
                tcp.translation.vector += bend * (4.0 * s * (1.0 - s));
                self.grips(&tcp)
            })
            .collect();
        let block = (seed, BLOCK + number);
        let starts = self.starts(&grips[0], block, 1);
        if starts.iter().any(|s| s.q.is_none()) {
            return None;
        }
        // The repetition's number decides between habits.
        let way = (&times[..], &grips[..]);
        let repeated = self.person.repeat(&self.coupling, way, &starts, block, number as usize);
        let rollout =
            repeated.rollouts.into_iter().next().filter(|r| r.reach_exceeded_at.is_none())?;
        let angles: Vec<Vec<f64>> =
            (0..self.led).map(|c| rollout.q.iter().map(|q| q[c]).collect()).collect();
        Some(trial_of(format!("demonstration {number}"), RATE_HZ, &angles))
    }
}

#[cfg(test)]
mod tests {
    use super::super::families::{Family, draw};
    use super::super::people::Kind;
    use super::super::statistics::Statistics;
    use super::*;
    use crate::math::stats::mean;
    use crate::scenario::read_scenario;
    use std::path::Path;

    /// Two people of a kind in each of some families, from seeds for tuning.
    fn shown(kind: Kind, is_whole: bool) -> Vec<Statistics> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scenario.toml");
        let mut all = Vec::new();
        let families = Family::ALL.into_iter().enumerate();
        for (f, family) in families.filter(|(_, f)| f.is_whole() == is_whole) {
            for i in 0..2 {
                let name = ["female_p05", "male_p50", "male_p95"][(f + i) % 3];
                let body = Body::load(name, Path::new(".")).unwrap();
                let number = (10 * f + i) as u64;
                let person = TruePerson::new(&body, family.contacts(), kind, number).unwrap();
                let mut rng = stream(3, Purpose::Simulation, 20, number as u32);
                let station = draw(family, number, &mut rng);
                let text = station.scenario(name, family.stand_in(), 3);
                std::fs::write(&file, text).unwrap();
                let scenario = read_scenario(&file).unwrap();
                let them = Demonstrator::new(&scenario, &body, &person).unwrap();
                let trials = them.demonstrate(&station, number, 12);
                assert!(trials.iter().all(|t| t.q[0].len() == if is_whole { 30 } else { 24 }));
                assert!(trials.len() >= 6, "{} {}: {}", station.name, name, trials.len());
                all.push(Statistics::of(&trials));
            }
        }
        all
    }

    #[test]
    fn people_as_recorded_move_as_the_recorded_people_do() {
        let all = shown(Kind::AsRecorded, false);
        let rank = mean(&all.iter().map(|s| s.participation_rank).collect::<Vec<_>>());
        let speed = mean(&all.iter().map(|s| s.joint_speed_deg_s).collect::<Vec<_>>());
        assert!((2.9..3.3).contains(&rank), "participation rank {rank}");
        assert!((18.0..25.0).contains(&speed), "{speed} deg/s");
        let in_class = shown(Kind::InClass, false);
        let speed = mean(&in_class.iter().map(|s| s.joint_speed_deg_s).collect::<Vec<_>>());
        assert!(speed < 15.0, "{speed} deg/s in class");
    }

    #[test]
    fn whole_people_show_trunk_and_leading_arm() {
        for kind in Kind::ALL {
            for s in shown(kind, true) {
                let (rank, speed) = (s.participation_rank, s.joint_speed_deg_s);
                assert!((1.5..8.0).contains(&rank), "{}: rank {rank}", kind.name());
                assert!((3.0..40.0).contains(&speed), "{}: {speed} deg/s", kind.name());
            }
        }
    }
}

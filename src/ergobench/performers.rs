//! Simulated people who repeat what the paper's people did: pick and place along a path that a robot imposes.
//!
//! Ten repetitions of one path (four pick-and-place movements by somebody who stands, three by somebody who
//! sits before a table), or ten paths between random places. Person by person the kind changes, and the body.
//! Nobody was recorded.

use super::people::{Contacts, Kind, TruePerson};
use crate::files::InputError;
use crate::human::{Body, Hands, Side, Stance};
use crate::math::pose::interpolate;
use crate::math::stream::{Purpose, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{Behaviour, Coupling, Grips, StartRule};
use crate::training::paper::{PaperExperiment, Performer, Task};
use crate::training::{Trial, trial_of};
use rand::RngExt as _;
use rayon::prelude::*;
use std::path::Path;

/// Repetitions, as in the paper.
const REPETITIONS: usize = 10;
/// Samples per second, Hz.
const RATE_HZ: f64 = 30.0;
/// Mean speed of the hand on a way, m/s, and the shortest time for one, s.
const SPEED_M_S: f64 = 0.35;
const SHORTEST_S: f64 = 0.9;
/// Bodies in turn: of those who stand, and of those who sit.
const BODIES: [[&str; 4]; 2] = [
    ["male_p50", "female_p50", "male_p95", "female_p05"],
    ["female_p05", "male_p95", "female_p50", "male_p50"],
];
/// Where things are picked, then where they are placed: forward, up from the hips and to the right, over stature.
type At = [f64; 3];
const STANDING: (At, &[At]) = (
    [0.27, -0.22, 0.10],
    &[[0.25, 0.20, 0.04], [0.28, 0.08, 0.20], [0.22, 0.14, -0.04], [0.26, 0.0, 0.14]],
);
const SEATED: (At, &[At]) =
    ([0.24, 0.02, 0.03], &[[0.27, 0.02, 0.19], [0.22, 0.15, 0.07], [0.26, 0.06, -0.04]]);
/// Least and greatest of random places, places of a path, and how far apart they are at least, over stature.
const RANDOM: [At; 2] = [[0.20, -0.24, -0.05], [0.29, 0.22, 0.20]];
const PLACES: usize = 8;
const APART: f64 = 0.12;
/// A workplace that is out of reach is made smaller, by this much and so often.
const SMALLER: f64 = 0.94;
const TRIES: u32 = 6;
/// Paths that are tried for one that is wanted.
const DRAWS: u32 = 20;

/// Simulated people at the work of one of the paper's experiments: standing as whole persons, in exp3 seated.
///
/// # Errors
/// Where somebody cannot reach the workplace.
pub fn performers(
    experiment: PaperExperiment,
    count: usize,
    seed: u64,
) -> Result<Vec<Performer>, InputError> {
    (0..count).into_par_iter().map(|i| performer(experiment, i, seed)).collect()
}

fn performer(experiment: PaperExperiment, i: usize, seed: u64) -> Result<Performer, InputError> {
    let is_seated = experiment == PaperExperiment::Exp3;
    let kind = Kind::ALL[i % Kind::ALL.len()];
    let bodies = BODIES[usize::from(is_seated)];
    let body = Body::load(bodies[(i + i / Kind::ALL.len()) % bodies.len()], Path::new("."))?;
    let contacts =
        if is_seated { Contacts::arm(Side::Right) } else { Contacts::whole(Hands::Right, 0.0) };
    // Other people than in the other posture.
    let number = 1000 * seed + 2 * i as u64 + u64::from(is_seated);
    let person = TruePerson::new(&body, contacts, kind, number)?;
    let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
    let coupling = Coupling::of_person(&body, contacts.coupled, &[contacts.hold], standing)?;
    let worker = Worker { person, contacts, coupling, seed: number };
    let name = format!("{} ({}, {})", i + 1, kind.name(), body.name);
    let mut tasks = vec![worker.primitive(&name, is_seated)?];
    if experiment == PaperExperiment::Exp2 {
        tasks.push(worker.random(&name)?);
    }
    Ok(Performer { name, body, side: Side::Right, is_seated, tasks })
}

struct Worker {
    person: TruePerson,
    contacts: Contacts,
    coupling: Coupling,
    seed: u64,
}

impl Worker {
    /// The same path again and again.
    fn primitive(&self, name: &str, is_seated: bool) -> Result<Task, InputError> {
        let (pick, places) = if is_seated { SEATED } else { STANDING };
        let there: Vec<At> = places.iter().flat_map(|place| [pick, *place]).collect();
        let mut smaller = 1.0;
        for _ in 0..TRIES {
            let at: Vec<Vec3> = there.iter().map(|p| self.place(*p, smaller)).collect();
            let trials = self.repetitions(&at, 0, REPETITIONS);
            if trials.len() == REPETITIONS {
                return Ok(Task {
                    name: "pick and place".into(),
                    is_primitive: true,
                    repetitions: trials,
                });
            }
            smaller *= SMALLER;
        }
        Err(InputError::new(name, "cannot reach the simulated workplace"))
    }

    /// Paths between random places.
    fn random(&self, name: &str) -> Result<Task, InputError> {
        let mut trials = Vec::new();
        for draw in 1..=DRAWS * REPETITIONS as u32 {
            if trials.len() == REPETITIONS {
                break;
            }
            trials.extend(self.repetitions(&self.random_places(draw), draw, 1));
        }
        if trials.len() < REPETITIONS {
            return Err(InputError::new(name, "cannot reach the simulated workplace"));
        }
        Ok(Task { name: "random".into(), is_primitive: false, repetitions: trials })
    }

    fn random_places(&self, draw: u32) -> Vec<Vec3> {
        let mut rng = stream(self.seed, Purpose::Simulation, 30, draw);
        let mut places: Vec<At> = Vec::new();
        let [low, high] = RANDOM;
        while places.len() < PLACES {
            let at = [0, 1, 2].map(|i| low[i] + (high[i] - low[i]) * rng.random::<f64>());
            let far = |p: &At| (Vec3::from(*p) - Vec3::from(at)).norm() >= APART;
            if places.last().is_none_or(far) {
                places.push(at);
            }
        }
        places.into_iter().map(|p| self.place(p, 1.0)).collect()
    }

    /// m in the rest frame; a smaller workplace shrinks towards a place before the person.
    fn place(&self, at: At, smaller: f64) -> Vec3 {
        let middle = Vec3::new(0.22, 0.05, 0.08);
        (middle + (Vec3::from(at) - middle) * smaller) * self.coupling.stature_m()
    }

    /// The repetitions of a path that keep the hand on it to the end.
    fn repetitions(&self, places: &[Vec3], block: u32, count: usize) -> Vec<Trial> {
        let tempo = self.person.manner().tempo;
        let (times, grips) =
            path(&places.iter().map(|p| self.contacts.grips(*p)).collect::<Vec<_>>(), tempo);
        let block = (self.seed, block);
        let starts = self.person.starts(
            &self.coupling,
            &grips[0],
            None,
            &StartRule::Sampled,
            block,
            0..2 * count,
        );
        // Whose start is out of reach is not recorded.
        let starts: Vec<_> = starts.into_iter().filter(|s| s.q.is_some()).collect();
        let walked = self.person.repeat(&self.coupling, (&times, &grips), &starts, block, 0);
        let kept = walked.rollouts.into_iter().filter(|r| r.reach_exceeded_at.is_none());
        kept.take(count)
            .enumerate()
            .map(|(r, walk)| {
                let angles: Vec<Vec<f64>> = (0..self.coupling.dof())
                    .map(|c| walk.q.iter().map(|q| q[c]).collect())
                    .collect();
                trial_of(format!("path {} repetition {}", block.1, r + 1), RATE_HZ, &angles)
            })
            .collect()
    }
}

/// Times (s) and grips of minimum-jerk ways from place to place.
fn path(places: &[Grips], tempo: f64) -> (Vec<f64>, Vec<Grips>) {
    let mut grips = vec![places[0]];
    for pair in places.windows(2) {
        let [from, to]: [Pose; 2] = [pair[0].first, pair[1].first];
        let distance = (to.translation.vector - from.translation.vector).norm();
        let duration = (distance / SPEED_M_S).max(SHORTEST_S) / tempo;
        let count = (duration * RATE_HZ).round() as usize;
        grips.extend((1..=count).map(|k| {
            let [s, ..] = crate::trajectory::minimum_jerk(k as f64 / count as f64);
            Grips::from(interpolate(&from, &to, s))
        }));
    }
    ((0..grips.len()).map(|k| k as f64 / RATE_HZ).collect(), grips)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everybody_repeats_the_same_path_and_differs() {
        for experiment in [PaperExperiment::Exp1, PaperExperiment::Exp2, PaperExperiment::Exp3] {
            let people = performers(experiment, 5, 1).unwrap();
            assert_eq!(people.len(), 5);
            for person in &people {
                let task = &person.tasks[0];
                assert!(task.is_primitive && task.repetitions.len() == REPETITIONS);
                let width = if experiment == PaperExperiment::Exp3 { 24 } else { 30 };
                let lengths: Vec<usize> = task.repetitions.iter().map(|t| t.q.len()).collect();
                assert!(lengths.iter().all(|l| *l == lengths[0] && *l > 60), "{lengths:?}");
                assert!(task.repetitions.iter().all(|t| t.q[0].len() == width));
                assert_ne!(task.repetitions[0].q, task.repetitions[1].q);
                assert_eq!(
                    person.tasks.len(),
                    if experiment == PaperExperiment::Exp2 { 2 } else { 1 }
                );
            }
            let again = performers(experiment, 2, 1).unwrap();
            for (a, b) in again.iter().zip(&people) {
                assert_eq!((&a.name, &a.tasks), (&b.name, &b.tasks));
            }
        }
    }
}

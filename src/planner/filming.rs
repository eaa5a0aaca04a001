//! Makes the moving scene from robot motions and sampled postures.

use super::environment::Environment;
use super::person::Person;
use super::prepare::Prepared;
use super::repetitions::{Repetition, Repetitions};
use super::result::CandidateResult;
use super::scene::{
    Points, Scene, SceneMotion, SceneObstacle, ScenePeople, SceneRobot, SceneShape, Walker, joined,
};
use crate::math::{Pose, Vec3};
use crate::robot::{Obstacle, Robot, capsules, stick};
use crate::scenario::{Scenario, Variant};
use crate::survey::{Lens, Scorable};
use nalgebra::DVector;

/// Moments that are kept of a motion; a viewer draws the frames between them.
const MOMENTS: usize = 26;
/// Repetitions that are shown beside the typical one.
const GHOSTS: usize = 8;
/// Radius of a robot's stick figure where its description has no capsules, m.
const STICK_RADIUS_M: f64 = 0.03;

/// The cell, and the motions along the reported paths.
pub(super) fn scene(scenario: &Scenario, motions: Vec<SceneMotion>) -> Scene {
    let workspace = scenario.limits.workspace.as_ref();
    Scene {
        workspace_m: workspace.map(|b| [b.min.into(), b.max.into()]),
        obstacles: scenario.obstacles.iter().filter_map(obstacle).chain(meshes(scenario)).collect(),
        motions,
    }
}

/// Most triangles of all meshes together that a page draws.
const MOST_TRIANGLES: usize = 16_000;

/// The meshes as they look, not the parts by which distances are measured.
fn meshes(scenario: &Scenario) -> impl Iterator<Item = SceneObstacle> {
    let most = MOST_TRIANGLES / scenario.meshes.len().max(1);
    scenario.meshes.iter().map(move |m| {
        let (points, triangles) = m.drawn.thinned(most).0.indexed();
        let millimetres = |p: &Vec3| [p.x, p.y, p.z].map(|v| (1e3 * v).round() as i32);
        let points_mm = points.iter().map(millimetres).collect();
        SceneObstacle {
            name: m.facts.name.clone(),
            shape: SceneShape::Mesh { points_mm, triangles },
        }
    })
}

/// A simple obstacle; none for a part of a mesh.
fn obstacle((name, obstacle): &(String, Obstacle)) -> Option<SceneObstacle> {
    let center = |pose: &Pose| pose.translation.vector.into();
    let turn = |pose: &Pose| {
        let q = pose.rotation.quaternion();
        [q.w, q.i, q.j, q.k]
    };
    let shape = match obstacle {
        Obstacle::Hull(_) => return None,
        Obstacle::Box { pose, size } => SceneShape::Box {
            center_m: center(pose),
            quaternion_wxyz: turn(pose),
            size_m: (*size).into(),
        },
        Obstacle::Sphere { center, radius } => {
            SceneShape::Sphere { center_m: (*center).into(), radius_m: *radius }
        }
        Obstacle::Capsule { a, b, radius } => {
            SceneShape::Capsule { ends_m: [(*a).into(), (*b).into()], radius_m: *radius }
        }
        Obstacle::Cylinder { pose, radius, length } => SceneShape::Cylinder {
            center_m: center(pose),
            quaternion_wxyz: turn(pose),
            radius_m: *radius,
            length_m: *length,
        },
    };
    Some(SceneObstacle { name: name.clone(), shape })
}

/// Robot and worker along a reported path.
pub(super) fn film(
    environment: &Environment,
    prepared: &Prepared,
    result: &CandidateResult,
    repetitions: &[Repetitions],
) -> Option<SceneMotion> {
    let path = prepared.path.as_ref()?;
    let last = path.time_s.len() - 1;
    let count = MOMENTS.min(last + 1);
    let samples: Vec<usize> = (0..count).map(|i| i * last / (count - 1).max(1)).collect();
    let robot_q = result.path.as_ref().map(|p| &p.robot_q);
    let robot = robot_q.filter(|q| q.len() > last).map(|q| {
        let postures: Vec<&[f64]> = samples.iter().map(|&k| q[k].as_slice()).collect();
        filmed_robot(&environment.workshop.robot_of(&prepared.variant), &postures)
    });
    let people = environment.people.iter().zip(repetitions).zip(&result.bodies).map(
        |((person, repetitions), b)| {
            let variant = &prepared.variant;
            Filming { person, variant, samples: &samples, lens: environment.lens }
                .people(repetitions, &b.rula().by_rollout)
        },
    );
    Some(SceneMotion { candidate: prepared.id.clone(), people: people.collect(), samples, robot })
}

/// The capsules of a robot, or its stick figure, in each posture.
fn filmed_robot(robot: &Robot, postures: &[&[f64]]) -> SceneRobot {
    let mut radii: Vec<f64> = postures
        .first()
        .map_or_else(Vec::new, |q| capsules(robot, q).iter().map(|c| c.radius).collect());
    let is_stick = radii.is_empty();
    let ends = |q: &&[f64]| -> Vec<Vec3> {
        if is_stick {
            stick(robot, q).windows(2).flat_map(|w| [w[0], w[1]]).collect()
        } else {
            capsules(robot, q).iter().flat_map(|c| [c.a, c.b]).collect()
        }
    };
    let moments: Vec<Vec<Vec3>> = postures.iter().map(ends).collect();
    if is_stick {
        radii = vec![STICK_RADIUS_M; moments.first().map_or(0, |m| m.len() / 2)];
    }
    let (capsules, mut tracks) = joined(&[Points::of(&moments)], &radii);
    SceneRobot { capsules, track: tracks.pop().unwrap_or_default() }
}

/// One body along one path.
struct Filming<'a> {
    person: &'a Person<'a>,
    variant: &'a Variant,
    samples: &'a [usize],
    lens: &'a Lens,
}

impl Filming<'_> {
    fn people(&self, repetitions: &Repetitions, rula: &[f64]) -> ScenePeople {
        let typical = self.typical(&repetitions.all);
        let shown: Vec<usize> =
            typical.into_iter().chain(self.ghosts(&repetitions.all, rula)).collect();
        let place = |repetition: &Repetition, k: usize| {
            let head = repetition.angles[k].head(self.lens.neck);
            let rest = self.person.rest_at(self.variant, repetition, k);
            let mannequin = &self.person.of(repetition).mannequin;
            mannequin.place(&rest, repetition.rollout.q[k].as_slice(), head)
        };
        let mut walkers = shown.iter().map(|&rollout| {
            let repetition = &repetitions.all[rollout];
            let moments = self.reached(repetition).iter().map(|&k| place(repetition, k));
            let track = Points::of(&moments.collect::<Vec<_>>()).whole();
            let scores =
                self.reached(repetition).iter().map(|&k| repetition.angles[k].score(self.lens));
            let (rula, reba) = scores.map(|s| (s.rula.grand, s.reba.total)).unzip();
            Walker { rollout, rula, reba, track }
        });
        // Of a population all have the thickness of the typical one, and each its own lengths.
        let shape = typical.map_or(self.person, |r| self.person.of(&repetitions.all[r]));
        let typical = typical.and_then(|_| walkers.next());
        let body = self.person.name.clone();
        let capsules = shape.mannequin.pieces().iter().map(Into::into).collect();
        ScenePeople { body, capsules, typical, ghosts: walkers.collect() }
    }

    /// The samples at which the hand was where it should be.
    fn reached(&self, repetition: &Repetition) -> &[usize] {
        let end = repetition.rollout.reach_exceeded_at.unwrap_or(usize::MAX);
        &self.samples[..self.samples.partition_point(|&k| k < end)]
    }

    /// The repetition nearest to the mean posture, among those that come farthest. A posture made of
    /// mean angles would not hold the hand on the path; this one does.
    fn typical(&self, all: &[Repetition]) -> Option<usize> {
        let far = all.iter().map(|w| self.reached(w).len()).max().filter(|n| *n > 0)?;
        let whole: Vec<usize> =
            (0..all.len()).filter(|&r| self.reached(&all[r]).len() == far).collect();
        let q = |r: usize, k: usize| &all[r].rollout.q[k];
        let samples = &self.samples[..far];
        let mean_at = |&k: &usize| {
            let zero = DVector::zeros(q(whole[0], k).len());
            whole.iter().fold(zero, |sum, &r| sum + q(r, k)) / whole.len() as f64
        };
        let means: Vec<DVector<f64>> = samples.iter().map(mean_at).collect();
        let off = |r: usize| -> f64 {
            samples.iter().zip(&means).map(|(&k, mean)| (q(r, k) - mean).norm_squared()).sum()
        };
        whole.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }

    /// Repetitions spread evenly over their ranking by RULA.
    fn ghosts(&self, all: &[Repetition], rula: &[f64]) -> Vec<usize> {
        let mut ranked: Vec<usize> =
            (0..all.len().min(rula.len())).filter(|&r| !self.reached(&all[r]).is_empty()).collect();
        ranked.sort_by(|&a, &b| rula[a].total_cmp(&rula[b]).then(a.cmp(&b)));
        let count = GHOSTS.min(ranked.len());
        (0..count).map(|i| ranked[(2 * i + 1) * ranked.len() / (2 * count)]).collect()
    }
}

//! A person at the workstation: a body, where it stands, and its way of moving.

use super::near::{ArmAlong, Closest};
use super::repetitions::{Repetition, Repetitions};
use super::result::{PosePicture, RolloutTable};
use crate::files::InputError;
use crate::human::{Body, BodyPart, Envelope, EnvelopeScratch};
use crate::math::{Pose, Vec3};
use crate::posture::{
    Behaviour, Certain, Coupling, Modelled, PostureLaw, StartRule, start_postures,
};
use crate::robot::{Robot, stick};
use crate::scenario::{Scenario, Variant};
use crate::survey::Surveyor;
use crate::trajectory::TimedPath;
use nalgebra::DVector;
use std::ops::Range;

/// How the workers of a scenario move: as its posture model says.
pub(super) fn modelled(scenario: &Scenario) -> Result<Modelled<'_>, InputError> {
    let model = &scenario.worker.model;
    Modelled::new(model).ok_or_else(|| {
        InputError::new(&model.name, "holds a process whose kernel matrix is not positive definite")
            .remedy("train the model again")
    })
}

/// One body in the scenario, with its way of moving.
pub(super) struct Person<'a> {
    pub name: String,
    scenario: &'a Scenario,
    coupling: Coupling,
    body: &'a Body,
    pub(super) surveyor: Surveyor,
    pub(super) envelope: Envelope,
    behaviour: &'a dyn Behaviour,
}

impl<'a> Person<'a> {
    /// The bodies of a scenario, who move in a way.
    pub(super) fn all(
        scenario: &'a Scenario,
        behaviour: &'a dyn Behaviour,
    ) -> Result<Vec<Self>, InputError> {
        let w = &scenario.worker;
        let of = |body: &'a Body| {
            let pelvis = body.pelvis_pose(w.at_m, w.facing, w.stance);
            let coupling = Coupling::new(body, w.side, scenario.hold)?;
            check_chain(&coupling, scenario)?;
            Ok(Self {
                name: body.name.clone(),
                scenario,
                coupling,
                surveyor: Surveyor::new(body, w.side, pelvis, w.stance)?,
                envelope: Envelope::new(body, w.side, w.stance)?,
                body,
                behaviour,
            })
        };
        w.bodies.iter().map(of).collect()
    }

    /// Pelvis in the world.
    pub(super) fn pelvis(&self, variant: &Variant) -> Pose {
        let stance = self.scenario.worker.stance;
        let mut pelvis = self.body.pelvis_pose(variant.at_m, variant.facing, stance);
        pelvis.translation.vector.z += variant.floor_m;
        pelvis
    }

    /// The grip in the pelvis frame along a TCP path.
    fn hand(&self, path: &TimedPath, variant: &Variant) -> Vec<Pose> {
        let to_pelvis = self.pelvis(variant).inverse();
        path.poses.iter().map(|tcp| to_pelvis * tcp * variant.grip).collect()
    }

    /// Where each repetition comes nearest to the arm; `numbers`: theirs.
    pub(super) fn closest(
        &self,
        repetitions: &Repetitions,
        numbers: &Range<usize>,
        (arm, variant): (&ArmAlong, &Variant),
    ) -> Vec<Option<Closest>> {
        arm.closest(repetitions, numbers, (&self.envelope, &self.pelvis(variant)))
    }

    /// Ends of the capsules' axes (world, m) with the mean posture moved on to a TCP pose; none where the
    /// hand does not get there.
    pub(super) fn placed_at(&self, tcp: &Pose, variant: &Variant) -> Option<Vec<[Vec3; 2]>> {
        let pelvis = self.pelvis(variant);
        let hand = pelvis.inverse() * tcp * variant.grip;
        let postures = self.behaviour.postures();
        let rule = StartRule::Mean;
        let starts = start_postures(&self.coupling, postures, &rule, &hand, (0, 0), 0..1);
        let q = starts.into_iter().next()?.q?;
        Some(self.placed(&pelvis, q.as_slice()))
    }

    /// The same with all joints of the coupled chain at zero.
    pub(super) fn placed_upright(&self, variant: &Variant) -> Vec<[Vec3; 2]> {
        self.placed(&self.pelvis(variant), &vec![0.0; self.coupling.dof()])
    }

    fn placed(&self, pelvis: &Pose, q: &[f64]) -> Vec<[Vec3; 2]> {
        let mut ends = Vec::new();
        self.envelope.place(pelvis, q, &mut EnvelopeScratch::default(), &mut ends);
        ends
    }

    /// The capsules of the body.
    pub(super) fn parts(&self) -> &[BodyPart] {
        self.envelope.parts()
    }

    /// Repetitions `numbers` of a block along a path. The same (seed, block) means the same
    /// repetitions on every path.
    pub(super) fn repeat(
        &self,
        path: &TimedPath,
        variant: &Variant,
        block: (u64, u32),
        numbers: Range<usize>,
    ) -> Repetitions {
        let rule = &self.scenario.worker.start_rule;
        self.along(path, variant, (self.behaviour, rule), (block, numbers))
    }

    /// One repetition without any chance in it: from the person's mean posture, by the mean of a law,
    /// the model's own or another one on the same chain.
    pub(super) fn repeat_surely(
        &self,
        path: &TimedPath,
        variant: &Variant,
        law: &PostureLaw,
    ) -> Repetitions {
        let postures = self.behaviour.postures();
        let rule = match &self.scenario.worker.start_rule {
            StartRule::Sampled => &StartRule::Mean,
            other => other,
        };
        self.along(path, variant, (&Certain { law, postures }, rule), ((0, 0), 0..1))
    }

    fn along(
        &self,
        path: &TimedPath,
        variant: &Variant,
        (behaviour, rule): (&dyn Behaviour, &StartRule),
        (block, numbers): ((u64, u32), Range<usize>),
    ) -> Repetitions {
        let hand = self.hand(path, variant);
        let at = (&path.time_s[..], &hand[..]);
        let first = numbers.start;
        let postures = behaviour.postures();
        let starts = start_postures(&self.coupling, postures, rule, &hand[0], block, numbers);
        let repeated = behaviour.repeat(&self.coupling, at, &starts, block, first);
        Repetitions::measured(&self.surveyor, repeated, starts, at)
    }

    /// How many of some start postures get the hand to a TCP pose.
    pub(super) fn reaching(&self, tcp: &Pose, variant: &Variant, tries: usize) -> usize {
        let hand = self.pelvis(variant).inverse() * tcp * variant.grip;
        let postures = self.behaviour.postures();
        let rule = StartRule::Sampled;
        let starts = start_postures(&self.coupling, postures, &rule, &hand, (0, 0), 0..tries);
        starts.iter().filter(|s| s.q.is_some()).count()
    }

    /// The repetitions as a table; each ends where its reach is exceeded.
    pub(super) fn table(
        &self,
        repetitions: &Repetitions,
        path: &TimedPath,
        rank: usize,
        is_first: bool,
    ) -> RolloutTable {
        let reached = |w: &Repetition| {
            let end = w.rollout.reach_exceeded_at.unwrap_or(w.rollout.q.len());
            w.rollout.q[..end].to_vec()
        };
        RolloutTable {
            rank,
            other_body: (!is_first).then(|| self.name.clone()),
            joints: self.coupling.joints().map(str::to_owned).collect(),
            time_s: path.time_s.clone(),
            q: repetitions.all.iter().map(reached).collect(),
        }
    }

    /// The person's mean posture moved on to a TCP pose, with the robot in a posture, for drawings;
    /// without bones where the hand does not get there.
    pub(super) fn picture_at(
        &self,
        tcp: &Pose,
        variant: &Variant,
        (robot, robot_q): (&Robot, Option<&[f64]>),
    ) -> PosePicture {
        let pelvis = self.pelvis(variant);
        let hand = pelvis.inverse() * tcp * variant.grip;
        let postures = self.behaviour.postures();
        let rule = StartRule::Mean;
        let starts = start_postures(&self.coupling, postures, &rule, &hand, (0, 0), 0..1);
        let q = starts.into_iter().next().and_then(|s| s.q);
        PosePicture {
            body: self.name.clone(),
            time_s: 0.0,
            bones: q.map_or_else(Vec::new, |q| self.surveyor.bones_at(&pelvis, &q)),
            robot: robot_q
                .map_or_else(Vec::new, |q| stick(robot, q).into_iter().map(Into::into).collect()),
        }
    }

    /// The mean posture and the robot at a few moments, for drawings.
    pub(super) fn pictures(
        &self,
        repetitions: &Repetitions,
        (path, variant): (&TimedPath, &Variant),
        (robot, robot_q): (&Robot, &[Vec<f64>]),
        moments: usize,
    ) -> Vec<PosePicture> {
        let last = path.time_s.len() - 1;
        let pelvis = self.pelvis(variant);
        (0..moments)
            .map(|i| {
                let k = i * last / (moments - 1).max(1);
                let reached: Vec<&DVector<f64>> = repetitions
                    .all
                    .iter()
                    .filter(|w| w.rollout.reach_exceeded_at.is_none_or(|at| at > k))
                    .map(|w| &w.rollout.q[k])
                    .collect();
                let bones = match reached.len() {
                    0 => Vec::new(),
                    n => {
                        let sum =
                            reached.iter().fold(DVector::zeros(reached[0].len()), |s, q| s + *q);
                        self.surveyor.bones_at(&pelvis, &(sum / n as f64))
                    }
                };
                let robot = robot_q.get(k).map_or_else(Vec::new, |q| {
                    stick(robot, q).into_iter().map(Into::into).collect()
                });
                PosePicture { body: self.name.clone(), time_s: path.time_s[k], bones, robot }
            })
            .collect()
    }
}

fn check_chain(coupling: &Coupling, scenario: &Scenario) -> Result<(), InputError> {
    let model = &scenario.worker.model;
    if coupling.joints().eq(model.joints.iter().map(String::as_str)) {
        return Ok(());
    }
    Err(InputError::new(&model.name, "was learned on a chain with other joints than the body's")
        .remedy("train the model with a body made by `ergopath body`"))
}

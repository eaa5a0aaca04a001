//! A person at the workstation: a body, where it stands, and its way of moving.

use super::known_starts::KnownStarts;
use super::near::{ArmAlong, Closest};
use super::repetitions::{Look, Repetition, Repetitions, Walked, in_full};
use super::result::{PosePicture, RolloutTable};
use super::walking::{Walk, seen_from};
use crate::files::InputError;
use crate::human::{
    Body, BodyPart, BodySize, Envelope, EnvelopeScratch, FEET_COLUMNS, Hands, Head, Mannequin,
    Pelvis, Stance, column_of, column_unit, mirror_sign, mirrored_pose,
};
use crate::kinematics::Frames;
use crate::math::{Pose, Vec3};
use crate::posture::{
    Behaviour, Certain, Coupling, Feet, Footing, Grips, Hold, Mixture, Modelled, PostureLaw, Start,
    StartRule, Stepper, low_place, start_postures,
};
use crate::robot::{Robot, stick};
use crate::scenario::{Scenario, Variant};
use crate::survey::{HeadDraw, Lens, ScoredAngles, Surveyor};
use crate::trajectory::TimedPath;
use nalgebra::DVector;
use rayon::prelude::*;
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
    pub(super) scenario: &'a Scenario,
    pub(super) coupling: Coupling,
    /// Signs of the coupling's coordinates in the mirror image, where the model is of the other hand.
    mirror: Option<Vec<f64>>,
    body: &'a Body,
    pub(super) surveyor: Surveyor,
    pub(super) envelope: Envelope,
    pub(super) mannequin: Mannequin,
    behaviour: &'a dyn Behaviour,
    /// Of that behaviour, by the rule of the scenario.
    known: KnownStarts,
    /// The people for whom this body stands, who make its repetitions; none where it stands for itself.
    crowd: Vec<Person<'a>>,
}

/// By how much the first person of a block is further on in the crowd than that of the block before, so that
/// searches, whose blocks are short, meet everybody.
const NEXT_BLOCK: usize = 11;

impl<'a> Person<'a> {
    /// The bodies of a scenario, who move in a way.
    pub(super) fn all(
        scenario: &'a Scenario,
        behaviour: &'a dyn Behaviour,
    ) -> Result<Vec<Self>, InputError> {
        let w = &scenario.worker;
        let of = |body: &'a Body, crowd: Vec<Self>| {
            let rest = body.pelvis_pose(w.at_m, w.facing, w.stance);
            let second = scenario.second_hand.map(|s| s.hold);
            let holds: Vec<Hold> = std::iter::once(scenario.hold).chain(second).collect();
            let held = (w.stance, scenario.task.load_kg);
            let coupling = Coupling::of_person(body, w.modelled(), &holds, held)?;
            check_chain(&coupling, scenario)?;
            Ok(Self {
                name: body.name.clone(),
                scenario,
                mirror: w.is_mirrored().then(|| coupling.joints().map(mirror_sign).collect()),
                coupling,
                surveyor: Surveyor::new(body, w.coupled(), rest, held)?,
                envelope: Envelope::new(body, w.coupled(), w.stance)?,
                mannequin: Mannequin::new(body, w.coupled(), w.stance)?,
                body,
                behaviour,
                known: KnownStarts::default(),
                crowd,
            })
        };
        let with_crowd = |(body, members): (&'a Body, &'a Vec<Body>)| {
            let crowd = members.par_iter().map(|m| of(m, Vec::new())).collect::<Result<_, _>>()?;
            of(body, crowd)
        };
        w.bodies.iter().zip(&w.members).map(with_crowd).collect()
    }

    /// Number of the one of the crowd who makes a repetition; none where the body stands for itself.
    fn member(&self, (_, block): (u64, u32), repetition: usize) -> Option<usize> {
        let count = Some(self.crowd.len()).filter(|n| *n > 0)?;
        Some((repetition + NEXT_BLOCK * (block as usize % count)) % count)
    }

    /// Whose body it is in a repetition.
    pub(super) fn of<A>(&self, repetition: &Repetition<A>) -> &Person<'a> {
        self.crowd.get(repetition.member).unwrap_or(self)
    }

    /// The size of the one of a population who makes a repetition; none where the body stands for itself.
    pub(super) fn member_size(&self, repetition: &Repetition) -> Option<BodySize> {
        Some(self.crowd.get(repetition.member)?.body.size)
    }

    /// The rest frame in the world: the pelvis of the upright body.
    pub(super) fn pelvis(&self, variant: &Variant) -> Pose {
        let stance = self.scenario.worker.stance;
        let mut pelvis = self.body.pelvis_pose(variant.at_m, variant.facing, stance);
        pelvis.translation.vector.z += variant.floor_m;
        pelvis
    }

    /// The grips in the rest frame with the TCP somewhere.
    fn grips(&self, tcp: &Pose, to_rest: &Pose, variant: &Variant) -> Grips {
        let first = to_rest * tcp * variant.grip;
        Grips { first, second: self.scenario.second_hand.map(|s| first * s.between) }
    }

    /// The grips as the model's own side meets them.
    fn asked(&self, grips: &Grips) -> Grips {
        if self.mirror.is_some() { grips.map(mirrored_pose) } else { *grips }
    }

    /// A posture of the model's side as the worker's.
    fn own(&self, q: &mut DVector<f64>) {
        if let Some(signs) = &self.mirror {
            q.iter_mut().zip(signs).for_each(|(q, s)| *q *= s);
        }
    }

    /// Feet of the model's side as the worker's.
    fn on_own_side(&self, footing: Footing) -> Footing {
        if self.mirror.is_some() { footing.mirrored() } else { footing }
    }

    /// The rest frame in the world at a sample of a repetition: where the feet are then.
    pub(super) fn rest_at<A>(
        &self,
        variant: &Variant,
        repetition: &Repetition<A>,
        k: usize,
    ) -> Pose {
        let given = self.of(repetition).pelvis(variant);
        if repetition.feet.is_none() { given } else { given * repetition.footing(k).pose() }
    }

    /// The same for the mean person with the TCP somewhere, seen from the given rest frame.
    fn footing_for(&self, tcp: &Pose, to_rest: &Pose, variant: &Variant) -> Footing {
        let asked = |tcp: &Pose| self.asked(&self.grips(tcp, to_rest, variant));
        self.stepper().map_or_else(Footing::default, |stepper| {
            stepper.stands(&asked(&variant.start), &asked(tcp), self.coupling.hold())
        })
    }

    /// The rest frame of the mean person with the TCP somewhere, in the world.
    pub(super) fn rest_for(&self, tcp: &Pose, variant: &Variant) -> Pose {
        let given = self.pelvis(variant);
        let footing = self.footing_for(tcp, &given.inverse(), variant);
        given * self.on_own_side(footing).pose()
    }

    /// Start postures with the TCP somewhere, and the rest frame in the world that they are told in.
    fn starts(
        &self,
        tcp: &Pose,
        variant: &Variant,
        rule: &StartRule,
        numbers: Range<usize>,
    ) -> (Pose, Vec<Option<DVector<f64>>>) {
        let rest = self.rest_for(tcp, variant);
        let grips = self.asked(&self.grips(tcp, &rest.inverse(), variant));
        let postures = self.behaviour.postures_at(&self.coupling, &grips);
        let starts = start_postures(&self.coupling, &postures, rule, grips, (0, 0), numbers);
        let own = |start: Start| {
            start.q.map(|mut q| {
                self.own(&mut q);
                q
            })
        };
        (rest, starts.into_iter().map(own).collect())
    }

    /// Somebody who steps as recorded people stood; none where the scenario keeps the feet in their place.
    pub(super) fn stepper(&self) -> Option<Stepper<'_>> {
        self.standing().filter(|_| self.scenario.worker.may_step)
    }

    /// Where recorded people would stand; none of who sits or rests, or where it was not recorded.
    fn standing(&self) -> Option<Stepper<'_>> {
        let worker = &self.scenario.worker;
        let stands = matches!(worker.stance, Stance::Standing { .. });
        let moves = worker.pelvis == Pelvis::Moves;
        let place = worker.model.standing.as_ref().filter(|_| stands && moves)?;
        Stepper::new(place, self.coupling.stature_m(), worker.hands == Hands::Both)
    }

    /// Grips along a path as the mean person's feet see them.
    pub(super) fn seen_on_average(&self, time_s: &[f64], grips: &[Grips]) -> Vec<Grips> {
        let feet = self.stepper().and_then(|stepper| {
            stepper.feet((time_s, grips), self.coupling.hold(), &stepper.surely(), &[])
        });
        feet.map_or_else(|| grips.to_vec(), |feet| seen_from(&feet, grips))
    }

    /// Where each repetition comes nearest to the arm; `numbers`: theirs.
    pub(super) fn closest<A: Sync>(
        &self,
        repetitions: &Repetitions<A>,
        numbers: &Range<usize>,
        (arm, variant): (&ArmAlong, &Variant),
    ) -> Vec<Option<Closest>> {
        let body = |repetition: &Repetition<A>| &self.of(repetition).envelope;
        let rest = |repetition: &Repetition<A>, k: usize| self.rest_at(variant, repetition, k);
        arm.closest(repetitions, numbers, (&body, &rest))
    }

    /// Ends of the capsules' axes (world, m) with the mean posture moved on to a TCP pose; none where the
    /// hand does not get there.
    pub(super) fn placed_at(&self, tcp: &Pose, variant: &Variant) -> Option<Vec<[Vec3; 2]>> {
        let (rest, mut postures) = self.starts(tcp, variant, &StartRule::Mean, 0..1);
        let q = postures.pop()??;
        Some(self.placed(&rest, q.as_slice()))
    }

    /// The same with all joints of the coupled chain at zero.
    pub(super) fn placed_upright(&self, variant: &Variant) -> Vec<[Vec3; 2]> {
        self.placed(&self.pelvis(variant), &vec![0.0; self.coupling.dof()])
    }

    /// The same for any posture and rest frame.
    pub(super) fn placed(&self, pelvis: &Pose, q: &[f64]) -> Vec<[Vec3; 2]> {
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
        self.repeat_looking(path, variant, (block, numbers), &in_full)
    }

    /// The same with what a lens looks at, and nothing else.
    pub(super) fn scored(
        &self,
        path: &TimedPath,
        variant: &Variant,
        which: ((u64, u32), Range<usize>),
        lens: &Lens,
    ) -> Repetitions<ScoredAngles> {
        self.repeat_looking(path, variant, which, &through(lens))
    }

    fn repeat_looking<A: Send>(
        &self,
        path: &TimedPath,
        variant: &Variant,
        (block, numbers): ((u64, u32), Range<usize>),
        look: &Look<A>,
    ) -> Repetitions<A> {
        let rule = &self.scenario.worker.start_rule;
        let of = |person: &Self, numbers: Range<usize>| {
            let how = (person.behaviour, rule, Some(&person.known));
            person.along(path, variant, how, (block, numbers), look)
        };
        let one = |r: usize| {
            let member = self.member(block, r)?;
            Some((member, of(&self.crowd[member], r..r + 1)))
        };
        let by_members: Vec<_> = numbers.clone().into_par_iter().filter_map(one).collect();
        let Some(whole) = Repetitions::of_members(by_members) else { return of(self, numbers) };
        let persons = whole.persons.or(Some(self.crowd.len()));
        Repetitions { mixture: self.mixture(path, self.behaviour), persons, ..whole }
    }

    /// One repetition without any chance in it: from the person's mean posture, by the mean of a law,
    /// the model's own or another one on the same chain.
    pub(super) fn scored_surely(
        &self,
        path: &TimedPath,
        variant: &Variant,
        law: &PostureLaw,
        lens: &Lens,
    ) -> Repetitions<ScoredAngles> {
        let postures = self.behaviour.postures();
        let rule = match &self.scenario.worker.start_rule {
            StartRule::Sampled => &StartRule::Mean,
            other => other,
        };
        let how: (&dyn Behaviour, _, _) = (&Certain { law, postures }, rule, None);
        self.along(path, variant, how, ((0, 0), 0..1), &through(lens))
    }

    fn along<A: Send>(
        &self,
        path: &TimedPath,
        variant: &Variant,
        (behaviour, rule, known): (&dyn Behaviour, &StartRule, Option<&KnownStarts>),
        (block, numbers): ((u64, u32), Range<usize>),
        look: &Look<A>,
    ) -> Repetitions<A> {
        let to_rest = self.pelvis(variant).inverse();
        let hands: Vec<Grips> =
            path.poses.iter().map(|tcp| self.grips(tcp, &to_rest, variant)).collect();
        let asked: Vec<Grips> = hands.iter().map(|g| self.asked(g)).collect();
        let mirrored = self.mirrored_rule(rule);
        let is_sure = numbers.len() == 1 && block == (0, 0);
        let heads = numbers.clone().map(|r| self.head(block, r, is_sure)).collect();
        let mixture = self.mixture(path, behaviour);
        let walk = Walk {
            coupling: &self.coupling,
            stepper: self.standing().map(|s| (s, self.scenario.worker.may_step)),
            behaviour,
            rule: mirrored.as_ref().unwrap_or(rule),
            time_s: &path.time_s,
            grips: &asked,
            mixture: mixture.as_ref(),
            block,
            known,
        };
        let Walked { mut starts, mut repeated, feet, would_step } = walk.repeat(numbers, is_sure);
        for q in repeated.rollouts.iter_mut().flat_map(|r| &mut r.q) {
            self.own(q);
        }
        for q in starts.iter_mut().filter_map(|s| s.q.as_mut()) {
            self.own(q);
        }
        let on_own_side = |feet: Option<Feet>| {
            feet.map(|feet| Feet {
                at: feet.at.into_iter().map(|f| self.on_own_side(f)).collect(),
                ..feet
            })
        };
        let feet = feet.into_iter().map(on_own_side).collect();
        let led: Vec<Pose> = hands.iter().map(|g| g.first).collect();
        let walked = Walked { starts, repeated, feet, would_step };
        let looked = (&self.surveyor, look);
        let measured = Repetitions::measured(looked, walked, heads, (&path.time_s, &led));
        Repetitions { mixture, persons: behaviour.persons(), ..measured }
    }

    /// How often each mode occurs on a path, by where its lowest place is from the feet of the scenario. Where
    /// the planner chooses the standing place nothing is known of that: people in recordings stood as they
    /// were used to.
    fn mixture(&self, path: &TimedPath, behaviour: &dyn Behaviour) -> Option<Mixture> {
        if self.scenario.free.moves_worker() {
            return None;
        }
        let given = self.scenario.nominal();
        let to_rest = self.pelvis(&given).inverse();
        let asked = |tcp| self.asked(&self.grips(tcp, &to_rest, &given));
        let grips: Vec<Grips> = path.poses.iter().map(asked).collect();
        let seen = self.seen_on_average(&path.time_s, &grips);
        let hands = seen.iter().map(|g| &g.first);
        behaviour.mixture(low_place(hands, self.coupling.stature_m()))
    }

    /// A given start posture as the model's side.
    fn mirrored_rule(&self, rule: &StartRule) -> Option<StartRule> {
        match (rule, &self.mirror) {
            (StartRule::Given(q), Some(signs)) => {
                Some(StartRule::Given(q.iter().zip(signs).map(|(q, s)| q * s).collect()))
            }
            _ => None,
        }
    }

    /// How repetition `r` of a block holds its head.
    fn head(&self, block: (u64, u32), r: usize, is_sure: bool) -> HeadDraw {
        let hands = self.scenario.worker.hands;
        let mean = HeadDraw::mean((hands != Hands::Both).then(|| hands.lead()));
        if is_sure { mean } else { mean.of_repetition(block, r, self.behaviour.persons()) }
    }

    /// How many of some start postures get the hand to a TCP pose.
    pub(super) fn reaching(&self, tcp: &Pose, variant: &Variant, tries: usize) -> usize {
        let of = |person: &Self, numbers: Range<usize>| {
            let starts = person.starts(tcp, variant, &StartRule::Sampled, numbers).1;
            starts.iter().flatten().count()
        };
        if self.crowd.is_empty() {
            return of(self, 0..tries);
        }
        (0..tries).into_par_iter().map(|r| of(&self.crowd[r % self.crowd.len()], r..r + 1)).sum()
    }

    /// The repetitions as a table; each ends where its reach is exceeded.
    pub(super) fn table(
        &self,
        repetitions: &Repetitions,
        path: &TimedPath,
        rank: usize,
        is_first: bool,
    ) -> RolloutTable {
        let units = |body: &Body| -> Vec<f64> {
            self.surveyor.joints().map(|j| column_unit(j, body)).collect()
        };
        let neck = self.scenario.worker.neck;
        let steps = self.stepper().is_some();
        let feet = FEET_COLUMNS.into_iter().filter(|_| steps).map(str::to_owned);
        let reached = |w: &Repetition| -> Vec<Vec<f64>> {
            let end = w.rollout.reach_exceeded_at.unwrap_or(w.rollout.q.len());
            let frames = w.rollout.q[..end].iter().zip(&w.angles).enumerate();
            let Person { surveyor, body, .. } = self.of(w);
            let units = units(body);
            frames
                .map(|(k, (q, a))| {
                    let whole = surveyor.whole(q, a.head(neck));
                    let Footing { ahead_m, right_m, turn } = w.footing(k);
                    let feet = [ahead_m, right_m, turn].into_iter().filter(|_| steps);
                    whole.iter().zip(&units).map(|(v, unit)| v * unit).chain(feet).collect()
                })
                .collect()
        };
        RolloutTable {
            rank,
            other_body: (!is_first).then(|| self.name.clone()),
            columns: self.surveyor.joints().map(column_of).chain(feet).collect(),
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
        let (rest, mut postures) = self.starts(tcp, variant, &StartRule::Mean, 0..1);
        let bones = postures.pop().flatten().map_or_else(Vec::new, |q| {
            let head = self.mean_head(&q);
            self.surveyor.bones_at(&rest, &q, head)
        });
        PosePicture {
            body: self.name.clone(),
            time_s: 0.0,
            bones,
            robot: robot_q
                .map_or_else(Vec::new, |q| stick(robot, q).into_iter().map(Into::into).collect()),
        }
    }

    /// The head as it is held on average in a posture.
    fn mean_head(&self, q: &DVector<f64>) -> Head {
        let draw = self.head((0, 0), 0, true);
        self.surveyor.measure(q, &draw).head(self.scenario.worker.neck)
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
        (0..moments)
            .map(|i| {
                let k = i * last / (moments - 1).max(1);
                let reached: Vec<&Repetition> = repetitions
                    .all
                    .iter()
                    .filter(|w| w.rollout.reach_exceeded_at.is_none_or(|at| at > k))
                    .collect();
                let bones = match reached.len() {
                    0 => Vec::new(),
                    n => {
                        let zero = DVector::zeros(reached[0].rollout.q[k].len());
                        let mean = reached.iter().fold(zero, |s, w| s + &w.rollout.q[k]) / n as f64;
                        let feet = reached.iter().map(|w| w.footing(k));
                        let rest = self.pelvis(variant) * Footing::mean(feet).pose();
                        self.surveyor.bones_at(&rest, &mean, self.mean_head(&mean))
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

/// Looks at what a lens scores.
fn through(
    lens: &Lens,
) -> impl Fn(&Surveyor, (&DVector<f64>, &HeadDraw), bool, &mut Frames) -> ScoredAngles + Sync {
    |surveyor, (q, head), _, frames| surveyor.scored(q, head, lens, frames)
}

fn check_chain(coupling: &Coupling, scenario: &Scenario) -> Result<(), InputError> {
    let model = &scenario.worker.model;
    if coupling.joints().eq(model.joints.iter().map(String::as_str)) {
        return Ok(());
    }
    Err(InputError::new(&model.name, "was learned on a chain with other joints than the body's")
        .remedy("train the model with a body made by `ergopath body`"))
}

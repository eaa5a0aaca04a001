//! Sends people along paths and scores them.

use super::near::{ArmAlong, Closest};
use super::result::{BodyScores, PartScore, PosePicture, RolloutTable};
use super::scored::{Scored, Sheets, travel_shares};
use crate::ergonomics::{
    P_AT_LEAST_S, PerMethod, RulaSteps, ScoringMethod, StepShare, THRESHOLD_MOVE_DEG,
    ThresholdSensitivity, ThresholdShift, reba, reba_step_shares, rula, rula_step_courses,
    rula_step_shares, score_distribution, threshold_sensitivity,
};
use crate::files::InputError;
use crate::human::{Body, BodyPart, Envelope, EnvelopeScratch};
use crate::math::stats::mean;
use crate::math::stream::{Purpose, stream};
use crate::math::{Pose, Vec3};
use crate::posture::{
    Behaviour, Coupling, FunctionDraw, HandPath, PostureLaw, Rollout, Sampler, Sampling, Start,
    StartRule, roll_out, start_postures,
};
use crate::robot::{Robot, stick};
use crate::scenario::{OtherArm, Scenario, Variant};
use crate::survey::{Lens, PostureAngles, Surveyor};
use crate::trajectory::TimedPath;
use nalgebra::DVector;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// Offset of the block number for the noise stream, so that start and noise draw from other streams.
const NOISE_BLOCK: u32 = 1 << 16;
/// The same for the posterior functions.
const FUNCTION_BLOCK: u32 = 1 << 17;

/// Blocks of functions that are kept at a time.
const KEPT_BLOCKS: usize = 4;

fn broken_process(model: &str) -> InputError {
    InputError::new(model, "holds a process whose kernel matrix is not positive definite")
        .remedy("train the model again")
}

/// One body in the scenario.
pub(super) struct Person<'a> {
    pub name: String,
    scenario: &'a Scenario,
    coupling: Coupling,
    body: &'a Body,
    pub(super) surveyor: Surveyor,
    pub(super) envelope: Envelope,
    sampler: Sampler<'a>,
    /// Posterior functions of the people of a (seed, block): all candidates meet the same people.
    functions: Mutex<BTreeMap<(u64, u32), Functions>>,
    /// Somebody whose way of moving is known, in the place of the model.
    truth: Option<&'a dyn Behaviour>,
}

type Functions = Arc<Vec<Arc<[FunctionDraw]>>>;

/// One walk of one person, with the angles of every frame.
pub(super) struct Walk {
    pub rollout: Rollout,
    pub angles: Vec<PostureAngles>,
    pub start: Start,
}

/// The walks of one person along one path.
pub(super) struct Walks {
    pub all: Vec<Walk>,
    /// Interval of the samples, s.
    pub dt: f64,
    /// Each sample's share of the hand travel.
    pub travel: Vec<f64>,
    pub extrapolation_share: f64,
}

impl<'a> Person<'a> {
    /// The bodies of a scenario, who move as its posture model says, or as somebody does.
    pub(super) fn all(
        scenario: &'a Scenario,
        truth: Option<&'a dyn Behaviour>,
    ) -> Result<Vec<Self>, InputError> {
        let w = &scenario.worker;
        w.bodies
            .iter()
            .map(|body| {
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
                    sampler: Sampler::new(&w.model.law, Sampling::Pathwise)
                        .ok_or_else(|| broken_process(&w.model.name))?,
                    functions: Mutex::default(),
                    truth,
                })
            })
            .collect()
    }

    /// Pelvis in the world.
    pub(super) fn pelvis(&self, variant: &Variant) -> Pose {
        let stance = self.scenario.worker.stance;
        let mut pelvis = self.body.pelvis_pose(variant.at_m, variant.facing, stance);
        pelvis.translation.vector.z += variant.floor_m;
        pelvis
    }

    /// The grip in the pelvis frame along a TCP path, as the law sees it.
    fn hand(&self, path: &TimedPath, variant: &Variant, law: &PostureLaw) -> HandPath {
        let to_pelvis = self.pelvis(variant).inverse();
        let targets = path.poses.iter().map(|tcp| to_pelvis * tcp * variant.grip).collect();
        HandPath::new(&self.coupling, law, path.time_s.clone(), targets)
    }

    /// Where people come nearest to the arm; `people`: the numbers of these walks.
    pub(super) fn closest(
        &self,
        walks: &Walks,
        people: &Range<usize>,
        (arm, variant): (&ArmAlong, &Variant),
    ) -> Vec<Option<Closest>> {
        arm.closest(walks, people, (&self.envelope, &self.pelvis(variant)))
    }

    /// Ends of the capsules' axes (world, m) with the mean posture moved on to a TCP pose; none where the
    /// hand does not get there.
    pub(super) fn placed_at(&self, tcp: &Pose, variant: &Variant) -> Option<Vec<[Vec3; 2]>> {
        let pelvis = self.pelvis(variant);
        let hand = pelvis.inverse() * tcp * variant.grip;
        let postures = &self.scenario.worker.model.postures;
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

    /// People `from..to` of a block along a path. The same (seed, block) means the same people on
    /// every path.
    pub(super) fn walk(
        &self,
        path: &TimedPath,
        variant: &Variant,
        (seed, block): (u64, u32),
        people: Range<usize>,
    ) -> Walks {
        let model = &self.scenario.worker.model;
        let hand = self.hand(path, variant, &model.law);
        let dt = path.duration_s() / (path.time_s.len() - 1) as f64;
        let starts = start_postures(
            &self.coupling,
            self.truth.map_or(&model.postures, Behaviour::postures),
            &self.scenario.worker.start_rule,
            hand.start(),
            (seed, block),
            people.clone(),
        );
        if let Some(truth) = self.truth {
            return self.walk_truly(path, truth, &hand, starts, (seed, block), people.start);
        }
        let functions = self.functions((seed, block), people.end);
        let walks = starts
            .into_par_iter()
            .zip(people)
            .map(|(start, r)| {
                let mut rng = stream(seed, Purpose::Posture, NOISE_BLOCK + block, r as u32);
                let person = self.sampler.person(functions[r].clone(), &mut rng, &hand);
                let rollout = roll_out(&self.coupling, &model.law, &hand, &start, Some(&person));
                let angles = rollout.q.iter().map(|q| self.surveyor.measure(q)).collect();
                Walk { rollout, angles, start }
            })
            .collect();
        Walks::along(&hand, dt, walks)
    }

    /// How many of some start postures get the hand to a TCP pose.
    pub(super) fn reaching(&self, tcp: &Pose, variant: &Variant, tries: usize) -> usize {
        let w = &self.scenario.worker;
        let hand = self.pelvis(variant).inverse() * tcp * variant.grip;
        let postures = &w.model.postures;
        let rule = StartRule::Sampled;
        let starts = start_postures(&self.coupling, postures, &rule, &hand, (0, 0), 0..tries);
        starts.iter().filter(|s| s.q.is_some()).count()
    }

    fn walk_truly(
        &self,
        path: &TimedPath,
        truth: &dyn Behaviour,
        hand: &HandPath,
        starts: Vec<Start>,
        block: (u64, u32),
        first: usize,
    ) -> Walks {
        let at = (&path.time_s[..], hand.targets());
        let rollouts = truth.walk(&self.coupling, at, &starts, block, first);
        let all = rollouts
            .into_par_iter()
            .zip(starts)
            .map(|(rollout, start)| {
                let angles = rollout.q.iter().map(|q| self.surveyor.measure(q)).collect();
                Walk { rollout, angles, start }
            })
            .collect();
        let dt = path.duration_s() / (path.time_s.len() - 1) as f64;
        Walks::along(hand, dt, all)
    }

    /// One walk without any chance in it: from the person's mean posture, by the law's mean. With
    /// `law` the model's own or another one on the same chain.
    pub(super) fn walk_surely(
        &self,
        path: &TimedPath,
        variant: &Variant,
        law: &PostureLaw,
    ) -> Walks {
        let hand = self.hand(path, variant, law);
        let postures = &self.scenario.worker.model.postures;
        let rule = match &self.scenario.worker.start_rule {
            StartRule::Sampled => &StartRule::Mean,
            other => other,
        };
        let all = start_postures(&self.coupling, postures, rule, hand.start(), (0, 0), 0..1)
            .into_iter()
            .map(|start| {
                let rollout = roll_out(&self.coupling, law, &hand, &start, None);
                let angles = rollout.q.iter().map(|q| self.surveyor.measure(q)).collect();
                Walk { rollout, angles, start }
            })
            .collect();
        let dt = path.duration_s() / (path.time_s.len() - 1) as f64;
        Walks::along(&hand, dt, all)
    }

    /// At least `count` people's functions of a block.
    fn functions(&self, (seed, block): (u64, u32), count: usize) -> Functions {
        // A poisoned lock holds whole entries all the same.
        let mut known = self.functions.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.get(&(seed, block)).filter(|f| f.len() >= count) {
            return found.clone();
        }
        let draw = |r: usize| {
            let mut rng = stream(seed, Purpose::Posture, FUNCTION_BLOCK + block, r as u32);
            self.sampler.functions(&mut rng)
        };
        // Searches move on from block to block.
        while known.len() >= KEPT_BLOCKS {
            known.pop_first();
        }
        let drawn: Functions = Arc::new((0..count).into_par_iter().map(draw).collect());
        known.insert((seed, block), drawn.clone());
        drawn
    }

    /// The walks as a table; each ends where its reach is exceeded.
    pub(super) fn table(
        &self,
        walks: &Walks,
        path: &TimedPath,
        rank: usize,
        is_first: bool,
    ) -> RolloutTable {
        let reached = |w: &Walk| {
            let end = w.rollout.reach_exceeded_at.unwrap_or(w.rollout.q.len());
            w.rollout.q[..end].to_vec()
        };
        RolloutTable {
            rank,
            other_body: (!is_first).then(|| self.name.clone()),
            joints: self.coupling.joints().map(str::to_owned).collect(),
            time_s: path.time_s.clone(),
            q: walks.all.iter().map(reached).collect(),
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
        let postures = &self.scenario.worker.model.postures;
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
        walks: &Walks,
        (path, variant): (&TimedPath, &Variant),
        (robot, robot_q): (&Robot, &[Vec<f64>]),
        moments: usize,
    ) -> Vec<PosePicture> {
        let last = path.time_s.len() - 1;
        let pelvis = self.pelvis(variant);
        (0..moments)
            .map(|i| {
                let k = i * last / (moments - 1).max(1);
                let reached: Vec<&DVector<f64>> = walks
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

impl Walks {
    fn along(hand: &HandPath, dt: f64, all: Vec<Walk>) -> Self {
        let travel = travel_shares(hand.targets());
        Self { all, dt, travel, extrapolation_share: hand.extrapolation_share() }
    }

    /// Expected scores under a lens.
    pub(super) fn expected(&self, lens: &Lens) -> PerMethod<f64> {
        Sheets::of(self, |a| a.score(lens)).expected()
    }

    /// Expected scores with the angle thresholds moved.
    pub(super) fn sensitivity(&self, lens: &Lens) -> ThresholdSensitivity {
        let task = &lens.task;
        threshold_sensitivity(THRESHOLD_MOVE_DEG, |shift: &ThresholdShift| {
            let scored = |a: &PostureAngles| {
                let sheet = shift.worksheet(a.trunk_neck(lens.neck), &a.arm, task, &lens.profile);
                (rula(&sheet, &lens.profile), reba(&sheet, &lens.profile))
            };
            Sheets::of(self, scored).expected()
        })
    }

    /// Everything the report shows of one body.
    pub(super) fn summary(
        &self,
        body: &str,
        lens: &Lens,
        other_arm: OtherArm,
    ) -> Option<BodyScores> {
        let sheets = Sheets::of(self, |a| a.score(lens));
        let scored = Scored::from_sheets(self, &sheets);
        let scores = PerMethod::all(|m| {
            let parts = match m {
                ScoringMethod::Rula => rula_parts(&sheets.rula_steps(), lens),
                ScoringMethod::Reba => parts(&reba_step_shares(&sheets.reba_steps())),
            };
            scored.report(m, parts)
        })?;
        let exceeded: Vec<usize> =
            self.all.iter().filter_map(|w| w.rollout.reach_exceeded_at).collect();
        let count = self.all.len() as f64;
        let of = |f: fn(&Rollout) -> f64| -> Vec<f64> {
            self.all.iter().map(|w| f(&w.rollout)).collect()
        };
        let largest = |v: Vec<f64>| v.into_iter().fold(0.0, f64::max);
        let squares: Vec<f64> = of(|r| r.rms_residual_m.powi(2));
        let starts: Vec<f64> =
            self.all.iter().map(|w| w.start.distance).filter(|d| d.is_finite()).collect();
        Some(BodyScores {
            body: body.to_owned(),
            objective: 0.0,
            person_clearance: None,
            rollouts: self.all.len(),
            scores,
            other_side_rula: match other_arm {
                OtherArm::Unknown => None,
                OtherArm::Hanging => score_distribution(
                    &self.other_scores(lens),
                    self.dt,
                    ScoringMethod::Rula.worst(),
                    P_AT_LEAST_S,
                ),
            },
            reach_exceeded: exceeded.len() as f64 / count,
            reach_exceeded_from_s: exceeded.iter().min().map(|&k| k as f64 * self.dt),
            hand_residual_max_mm: 1e3 * largest(of(|r| r.max_residual_m)),
            hand_residual_rms_mm: 1e3 * mean(&squares).sqrt(),
            hand_residual_max_deg: largest(of(|r| r.max_residual_rad)).to_degrees(),
            extrapolation_share: self.extrapolation_share,
            unusual_starts: self.all.iter().filter(|w| w.start.is_unusual).count() as f64 / count,
            start_distance: if starts.is_empty() { 0.0 } else { mean(&starts) },
        })
    }

    fn other_scores(&self, lens: &Lens) -> Vec<Vec<u8>> {
        let score = |w: &Walk| w.angles.iter().map(|a| a.other_rula(lens).grand).collect();
        self.all.iter().map(score).collect()
    }
}

fn rula_parts(steps: &[Vec<Option<RulaSteps>>], lens: &Lens) -> Vec<PartScore> {
    let shares = parts(&rula_step_shares(steps, lens.profile.rula_table_a));
    let rounded = |course: Vec<f64>| course.iter().map(|v| (1e3 * v).round() / 1e3).collect();
    let with = |(part, course)| PartScore { over_time: rounded(course), ..part };
    shares.into_iter().zip(rula_step_courses(steps)).map(with).collect()
}

fn parts(shares: &[StepShare]) -> Vec<PartScore> {
    let part = |s: &StepShare| PartScore {
        part: s.step.into(),
        mean: s.mean,
        drives: s.drop,
        drives_se: s.drop_se,
        drives_share: s.drives_share,
        over_time: Vec::new(),
    };
    shares.iter().map(part).collect()
}

//! How near the robot comes to the worker, in every repetition: a chance constraint.
//!
//! ```text
//! d_r = least distance of repetition r between the arm's and the body's capsules, over time
//! feasible:  share of repetitions with d_r < margin  <=  share allowed
//! ```
//! The hand and forearm that hold on to the robot are meant to be at its wrist: these pairs do not
//! count. The search looks at few repetitions and moments, the selection at all repetitions at some
//! moments, the report at every step near the closest one as well. A planning margin, not a safety function.

use super::repetitions::{Repetition, Repetitions};
use super::result::PersonClearance;
use crate::human::{BodyPart, Envelope, EnvelopeScratch};
use crate::math::segment::segment_distance;
use crate::math::stats::quantile;
use crate::math::{Pose, Vec3};
use crate::robot::{ArmPart, Robot, arm_parts, arm_places};
use crate::scenario::PersonMargin;
use rayon::prelude::*;
use std::ops::Range;

/// Repetitions of a search that are looked at.
const MOST_IN_SEARCH: usize = 16;

/// How closely it is looked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// Nobody: only the scores are wanted.
    Blind,
    /// The repetitions that the best of a generation meet, at a few moments.
    Search,
    /// All repetitions at some moments.
    Selection,
    /// All repetitions, and every step about the closest moment.
    Report,
}

impl Care {
    /// Intervals between the moments that are looked at first.
    fn intervals(self) -> usize {
        match self {
            Self::Blind | Self::Search => 8,
            Self::Selection | Self::Report => 24,
        }
    }

    /// Number of repetitions that are looked at.
    pub(super) fn repetitions(self) -> usize {
        match self {
            Self::Blind => 0,
            Self::Search => MOST_IN_SEARCH,
            Self::Selection | Self::Report => usize::MAX,
        }
    }
}

/// Where one repetition comes nearest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Closest {
    pub distance_m: f64,
    /// Indices of the arm's and the body's capsule.
    pub arm: usize,
    pub part: usize,
    /// Step of the path.
    pub step: usize,
}

/// A capsule with the ball around it.
#[derive(Debug, Clone, Copy)]
struct Placed {
    ends: [Vec3; 2],
    middle: Vec3,
    reach: f64,
}

impl Placed {
    fn new(ends: &[Vec3; 2], radius: f64) -> Self {
        let [a, b] = ends;
        Self { ends: *ends, middle: 0.5 * (a + b), reach: 0.5 * (b - a).norm() + radius }
    }
}

/// Whose body it is in a repetition.
pub(super) type BodyOf<'a, A> = dyn Fn(&Repetition<A>) -> &'a Envelope + Sync + 'a;
/// The rest frame of a body in the world at a step of a repetition.
pub(super) type RestAt<'a, A> = dyn Fn(&Repetition<A>, usize) -> Pose + Sync + 'a;

/// An arm at the steps of a path.
pub(super) struct ArmAlong<'r> {
    parts: Vec<ArmPart<'r>>,
    /// Steps that are looked at first, rising; the last of the path among them.
    first: Vec<usize>,
    /// By step; empty where it is not looked.
    places: Vec<Vec<Placed>>,
    care: Care,
}

impl<'r> ArmAlong<'r> {
    /// `None` for an arm without shapes or motion.
    pub(super) fn new(robot: &'r Robot, q: &[Vec<f64>], care: Care) -> Option<Self> {
        let parts = arm_parts(robot);
        let last = q.len().checked_sub(1).filter(|_| !parts.is_empty())?;
        let count = care.intervals().min(last.max(1));
        let mut first: Vec<usize> = (0..=count).map(|i| i * last / count).collect();
        first.dedup();
        let wanted: Vec<usize> =
            if care == Care::Report { (0..=last).collect() } else { first.clone() };
        let mut places = vec![Vec::new(); q.len()];
        let ends = arm_places(robot, wanted.iter().map(|&k| &q[k]));
        for (k, ends) in wanted.into_iter().zip(ends) {
            let placed = ends.iter().zip(&parts).map(|(e, p)| Placed::new(e, p.radius));
            places[k] = placed.collect();
        }
        Some(Self { parts, first, places, care })
    }

    /// Where each repetition comes nearest; none for one that does not even start. `numbers`: theirs.
    pub(super) fn closest<A: Sync>(
        &self,
        repetitions: &Repetitions<A>,
        numbers: &Range<usize>,
        (body, rest): (&BodyOf<A>, &RestAt<A>),
    ) -> Vec<Option<Closest>> {
        let count =
            self.care.repetitions().saturating_sub(numbers.start).min(repetitions.all.len());
        repetitions.all[..count]
            .par_iter()
            .map_with(Scratch::default(), |scratch, repetition| {
                self.along(repetition, (body(repetition), rest), scratch)
            })
            .collect()
    }

    fn along<A>(
        &self,
        repetition: &Repetition<A>,
        (envelope, rest): (&Envelope, &RestAt<A>),
        scratch: &mut Scratch,
    ) -> Option<Closest> {
        let end = repetition.rollout.reach_exceeded_at.unwrap_or(usize::MAX);
        let mut best: Option<Closest> = None;
        let mut look = |k: usize, best: &mut Option<Closest>| {
            if k < end && k < repetition.rollout.q.len() {
                let body = (envelope, &rest(repetition, k));
                self.at(k, repetition.rollout.q[k].as_slice(), body, scratch, best);
            }
        };
        for &k in &self.first {
            look(k, &mut best);
        }
        if self.care == Care::Report
            && let Some(step) = best.map(|b| b.step)
        {
            let at = self.first.partition_point(|&k| k < step);
            let low = self.first[at.saturating_sub(1)];
            let high = self.first[(at + 1).min(self.first.len() - 1)];
            for k in (low + 1..high).filter(|&k| k != step) {
                look(k, &mut best);
            }
        }
        best
    }

    /// The pairs of one moment against the best so far.
    fn at(
        &self,
        step: usize,
        q: &[f64],
        (envelope, pelvis): (&Envelope, &Pose),
        scratch: &mut Scratch,
        best: &mut Option<Closest>,
    ) {
        envelope.place(pelvis, q, &mut scratch.body, &mut scratch.ends);
        let parts = envelope.parts().iter();
        for (part, (shape, ends)) in parts.zip(&scratch.ends).enumerate() {
            let body = Placed::new(ends, shape.radius_m);
            for (arm, (limb, placed)) in self.parts.iter().zip(&self.places[step]).enumerate() {
                if is_excepted(shape, limb) {
                    continue;
                }
                let least = best.map_or(f64::INFINITY, |b| b.distance_m);
                let bound = least + body.reach + placed.reach;
                if (body.middle - placed.middle).norm_squared() >= bound * bound {
                    continue;
                }
                let [a, b] = [&body.ends, &placed.ends];
                let distance_m =
                    segment_distance([&a[0], &a[1]], [&b[0], &b[1]]) - shape.radius_m - limb.radius;
                if distance_m < least {
                    *best = Some(Closest { distance_m, arm, part, step });
                }
            }
        }
    }

    /// What comes near what: link of the robot, body part.
    pub(super) fn between(&self, closest: &Closest, parts: &[BodyPart]) -> [String; 2] {
        [self.parts[closest.arm].link.to_owned(), parts[closest.part].name.clone()]
    }

    /// The figures of one body for the report; none without repetitions.
    pub(super) fn summary(
        &self,
        closest: &[Option<Closest>],
        (parts, time_s): (&[BodyPart], &[f64]),
        margin: &PersonMargin,
    ) -> Option<PersonClearance> {
        let found: Vec<&Closest> = closest.iter().flatten().collect();
        let nearest = found.iter().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))?;
        let distances: Vec<f64> = found.iter().map(|c| c.distance_m).collect();
        let below = distances.iter().filter(|d| **d < margin.margin_m).count();
        Some(PersonClearance {
            repetitions: found.len(),
            margin_m: margin.margin_m,
            share_allowed: margin.share,
            share_below: below as f64 / found.len() as f64,
            min_m: nearest.distance_m,
            p05_m: quantile(&distances, 0.05),
            link: self.parts[nearest.arm].link.to_owned(),
            body_part: parts[nearest.part].name.clone(),
            time_s: time_s[nearest.step],
        })
    }
}

/// The hand and forearm on the handle may be where the wrist is.
fn is_excepted(part: &BodyPart, limb: &ArmPart) -> bool {
    part.is_coupled && limb.is_wrist
}

#[derive(Debug, Clone, Default)]
struct Scratch {
    body: EnvelopeScratch,
    ends: Vec<[Vec3; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::person::{Person, modelled};
    use crate::planner::prepare::Workshop;
    use crate::planner::preset::load_preset;
    use crate::planner::space::Space;
    use crate::scenario::read_scenario;
    use std::path::Path;

    /// Plain loop over every repetition, step and pair.
    fn naively(
        repetitions: &Repetitions,
        (envelope, pelvis): (&Envelope, &Pose),
        (robot, q): (&Robot, &[Vec<f64>]),
    ) -> Vec<f64> {
        let (parts, places) = (arm_parts(robot), arm_places(robot, q));
        let mut body = Vec::new();
        let of = |repetition: &Repetition| {
            let mut least = f64::INFINITY;
            for (posture, arm) in repetition.rollout.q.iter().zip(&places) {
                let scratch = &mut EnvelopeScratch::default();
                envelope.place(pelvis, posture.as_slice(), scratch, &mut body);
                for (shape, x) in envelope.parts().iter().zip(&body) {
                    for (limb, y) in parts.iter().zip(arm) {
                        if !(shape.is_coupled && limb.is_wrist) {
                            let d = segment_distance([&x[0], &x[1]], [&y[0], &y[1]]);
                            least = least.min(d - shape.radius_m - limb.radius);
                        }
                    }
                }
            }
            least
        };
        repetitions.all.iter().map(of).collect()
    }

    #[test]
    fn the_chance_is_that_of_a_plain_loop() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        for name in ["bench_pick_and_place", "seated_table"] {
            let scenario = read_scenario(&folder.join(format!("{name}.toml"))).unwrap();
            let preset = load_preset("quick").unwrap();
            let workshop = Workshop::new(&scenario, &preset, 1);
            let space = Space::new(&scenario, &preset);
            let choice = space.named().remove(0);
            let prepared = workshop.candidate(&choice.candidate, &choice.variant);
            assert!(prepared.path.is_some(), "{name}: {:?}", prepared.status);
            let (path, motion) =
                (prepared.path.as_ref().unwrap(), prepared.robot.as_ref().unwrap());
            let modelled = modelled(&scenario).unwrap();
            let people = Person::all(&scenario, &modelled).unwrap();
            let person = &people[0];
            let repetitions = person.repeat(path, &prepared.variant, (1, 7), 0..12);
            let w = &scenario.worker;
            let envelope = Envelope::new(&w.bodies[0], w.coupled(), w.stance).unwrap();
            let pelvis = w.bodies[0].pelvis_pose(w.at_m, w.facing, w.stance);
            let plain = naively(&repetitions, (&envelope, &pelvis), (&scenario.robot, &motion.q));
            let found = |care: Care| -> Vec<f64> {
                let arm = prepared.arm(&scenario.robot, care).unwrap();
                let closest = person.closest(&repetitions, &(8..20), (&arm, &prepared.variant));
                closest.into_iter().map(|c| c.unwrap().distance_m).collect()
            };
            let (report, coarse, few) =
                (found(Care::Report), found(Care::Selection), found(Care::Search));
            assert_eq!((report.len(), coarse.len(), few.len()), (12, 12, 8));
            for (own, plain) in report.iter().zip(&plain) {
                // Never below; above by what happens between two moments at most.
                assert!(*own >= plain - 1e-12 && own - plain < 2e-3, "{name}: {own} {plain}");
            }
            for (own, plain) in coarse.iter().zip(&plain) {
                assert!(*own >= plain - 1e-12 && own - plain < 0.01, "{name}: {own} {plain}");
            }
            let margin = PersonMargin { margin_m: quantile(&plain, 0.5), share: 0.3 };
            let arm = prepared.arm(&scenario.robot, Care::Report).unwrap();
            let closest = person.closest(&repetitions, &(0..12), (&arm, &prepared.variant));
            let body = (person.parts(), &path.time_s[..]);
            let summary = arm.summary(&closest, body, &margin).unwrap();
            let below = report.iter().filter(|d| **d < margin.margin_m).count();
            assert!((summary.share_below - below as f64 / 12.0).abs() < 1e-12);
            assert!(!summary.is_kept() && summary.min_m <= summary.p05_m);
        }
    }
}

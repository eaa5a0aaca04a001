//! What the whole body does along a path besides its scores: how far trunk and knees bend, how safely it
//! stands, what the low back bears, and what the lifting equation says of a lift with both hands.

use super::cell_findings::SOFT_M;
use super::person::Person;
use super::repetitions::{AT_EDGE_M, Repetition, Repetitions};
use super::result::{BodyStrain, FurnitureClearance, ModeShare, Spread, StepsTaken};
use crate::ergonomics::{
    LiftAssessment, LiftCondition, LiftCoupling, LiftDuration, LiftTask, assess_lift,
    lift_from_path,
};
use crate::human::{Hands, Pelvis, Stance};
use crate::math::stats::{mean, quantile};
use crate::math::{Pose, Vec3};
use crate::posture::{Feet, Footing, Mode};
use crate::scenario::{Scenario, Variant, Worker};
use crate::survey::{Lens, PostureAngles};
use crate::trajectory::TimedPath;
use rayon::prelude::*;

/// Knee flexion from which a repetition counts as one with bent knees, deg (REBA's second class).
const BENT_DEG: f64 = 60.0;
/// Lifts a minute where nothing is given: seldom.
const SELDOM_PER_MIN: f64 = 0.2;
/// Moments of a movement at which the body is held against the obstacles.
const MOMENTS: usize = 32;

impl Repetitions {
    /// The strain of the repetitions that begin; none where there are none.
    pub(super) fn strain(
        &self,
        scenario: &Scenario,
        lens: &Lens,
        (path, variant): (&TimedPath, &Variant),
        person: &Person,
    ) -> Option<BodyStrain> {
        let begun: Vec<&[PostureAngles]> =
            self.all.iter().map(Repetition::reached).filter(|a| !a.is_empty()).collect();
        if begun.is_empty() {
            return None;
        }
        let most = |of: &dyn Fn(&PostureAngles) -> f64| -> Vec<f64> {
            let largest = |a: &&[PostureAngles]| a.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
            begun.iter().map(largest).collect()
        };
        let knees = most(&|a| a.legs.knees_deg[0].max(a.legs.knees_deg[1]));
        let bent = knees.iter().filter(|k| **k > BENT_DEG).count();
        let raised = most(&|a| a.legs.heels_deg).iter().filter(|h| **h > 1.0).count();
        let share = |count: usize| count as f64 / begun.len() as f64;
        let moves = scenario.worker.pelvis == Pelvis::Moves;
        let margins = most(&|a| -a.margin_m.unwrap_or(f64::INFINITY));
        let moments: Vec<f64> = begun
            .iter()
            .map(|a| mean(&a.iter().map(|a| a.l5s1_nm).collect::<Vec<f64>>()))
            .collect();
        Some(BodyStrain {
            trunk_flexion_deg: spread(&most(&|a| a.trunk_neck(lens.neck).trunk_flex_deg)),
            knee_flexion_deg: moves.then(|| spread(&knees)),
            modes: self.mode_shares(scenario),
            bent_knees_share: moves.then(|| share(bent)),
            raised_heels_share: moves.then(|| share(raised)),
            balance_margin_m: moves.then(|| spread(&margins).negative()),
            l5s1_peak_nm: spread(&self.l5s1_peaks_nm()),
            l5s1_mean_nm: spread(&moments),
            steps: self.steps(person),
            niosh: self.lift(scenario, path, (variant, person)),
            stretched_share: self.stretched_share(&scenario.worker),
            furniture: self.furniture(scenario, (path, variant), person),
        })
    }

    /// How often each mode occurs.
    fn mode_shares(&self, scenario: &Scenario) -> Vec<ModeShare> {
        let (Some(mixture), Some(modes)) = (&self.mixture, &scenario.worker.model.modes) else {
            return Vec::new();
        };
        let of = |(k, mode): (usize, &Mode)| {
            let own = self.all.iter().filter(|r| r.start.mode == Some(k)).count();
            ModeShare {
                trunk_deg: mode.trunk_deg,
                knees_deg: mode.knees_deg,
                share: mixture.shares[k],
                share_90: [0.05, 0.95].map(|p| mixture.quantile(k, p)),
                of_repetitions: own as f64 / self.all.len() as f64,
                movements_near: mixture.near,
                movements: [modes.low.len(), modes.people],
            }
        };
        modes.all.iter().enumerate().map(of).collect()
    }

    /// Share of repetitions that reach only just or not at all; none of feet that step, and on a pelvis that does
    /// not move.
    pub(super) fn stretched_share(&self, worker: &Worker) -> Option<f64> {
        let is_stretched = |r: &Repetition| {
            let at_edge = |a: &PostureAngles| a.margin_m.is_some_and(|m| m < AT_EDGE_M);
            r.would_step || r.rollout.reach_exceeded_at.is_some() || r.reached().iter().any(at_edge)
        };
        let count = self.all.iter().filter(|r| is_stretched(r)).count() as f64;
        let must_stay = worker.pelvis == Pelvis::Moves && !worker.may_step;
        (must_stay && !self.all.is_empty()).then(|| count / self.all.len() as f64)
    }

    /// How often the feet are set anew; none where they must stay.
    fn steps(&self, person: &Person) -> Option<StepsTaken> {
        let stepper = person.stepper()?;
        let feet = || self.all.iter().map(|r| r.feet.as_ref());
        let share = |of: &dyn Fn(&Feet) -> bool| {
            feet().flatten().filter(|f| of(f)).count() as f64 / self.all.len() as f64
        };
        let each =
            |of: &dyn Fn(&Feet) -> f64| -> Vec<f64> { feet().map(|f| f.map_or(0.0, of)).collect() };
        let (movements, people) = stepper.learned_from();
        Some(StepsTaken {
            share: share(&|f| !f.steps_s.is_empty()),
            elsewhere_share: share(&Feet::start_elsewhere),
            number: spread(&each(&|f| f.steps_s.len() as f64)),
            way_m: spread(&each(&|f| f.way_m)),
            movements,
            people,
        })
    }

    /// The lifting equation for both hands: the prescribed path of the point midway between them, and the
    /// feet, where they are on average.
    fn lift(
        &self,
        scenario: &Scenario,
        path: &TimedPath,
        (variant, person): (&Variant, &Person),
    ) -> Option<LiftAssessment> {
        let given = person.pelvis(variant);
        // As if the feet had stayed and the hands had come to them.
        let seen = |(k, tcp): (usize, &Pose)| {
            let feet = Footing::mean(self.all.iter().map(|r| r.footing(k))).pose();
            given * feet.inverse() * given.inverse() * tcp
        };
        let seen = path.poses.iter().enumerate().map(seen).collect();
        lift(scenario, &TimedPath { poses: seen, ..path.clone() }, variant)
    }

    /// Largest moment about L5/S1 of each repetition that begins, N m.
    pub(super) fn l5s1_peaks_nm(&self) -> Vec<f64> {
        let begun = self.all.iter().map(Repetition::reached).filter(|a| !a.is_empty());
        begun.map(|a| a.iter().map(|a| a.l5s1_nm).fold(f64::NEG_INFINITY, f64::max)).collect()
    }

    /// The body against the obstacles; none without obstacles.
    fn furniture(
        &self,
        scenario: &Scenario,
        (path, variant): (&TimedPath, &Variant),
        person: &Person,
    ) -> Option<FurnitureClearance> {
        let nearest = |r: &Repetition| {
            let steps = r.reached().len();
            let last = steps.checked_sub(1)?;
            let mut moments: Vec<usize> = (0..=MOMENTS).map(|i| i * last / MOMENTS).collect();
            moments.dedup();
            let mut best: Option<Touch> = None;
            let (own, parts) = (person.of(r), person.of(r).parts());
            for k in moments {
                let ends = own.placed(&person.rest_at(variant, r, k), r.rollout.q[k].as_slice());
                for (part, [a, b]) in parts.iter().zip(&ends).filter(|(p, _)| !p.is_coupled) {
                    let (middle, reach) = (a.lerp(b, 0.5), 0.5 * (b - a).norm() + part.radius_m);
                    for (name, obstacle) in &scenario.obstacles {
                        // Distances change no faster than places: most pairs are too far for more.
                        let least_m = obstacle.least_distance(&middle) - reach;
                        if best.is_some_and(|b| least_m >= b.distance_m) {
                            continue;
                        }
                        let distance_m = obstacle.distance_to_capsule(a, b, part.radius_m);
                        if best.is_none_or(|b| distance_m < b.distance_m) {
                            best = Some(Touch { distance_m, part: &part.name, name, step: k });
                        }
                    }
                }
            }
            best
        };
        let found: Vec<Touch> = self.all.par_iter().filter_map(nearest).collect();
        let least = found.iter().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))?;
        let distances: Vec<f64> = found.iter().map(|t| t.distance_m).collect();
        let inside = distances.iter().filter(|d| **d < -SOFT_M).count();
        Some(FurnitureClearance {
            distance_m: spread(&distances),
            soft_m: SOFT_M,
            share_inside: inside as f64 / found.len() as f64,
            body_part: least.part.to_owned(),
            obstacle: least.name.to_owned(),
            time_s: path.time_s[least.step],
        })
    }
}

/// Where a body comes nearest to an obstacle.
#[derive(Clone, Copy)]
struct Touch<'a> {
    distance_m: f64,
    part: &'a str,
    name: &'a str,
    step: usize,
}

fn spread(values: &[f64]) -> Spread {
    Spread {
        median: quantile(values, 0.5),
        p05: quantile(values, 0.05),
        p95: quantile(values, 0.95),
    }
}

impl Spread {
    /// Of the values with their signs changed.
    fn negative(self) -> Self {
        Self { median: -self.median, p05: -self.p95, p95: -self.p05 }
    }
}

/// The lifting equation for both hands: the prescribed path of the point midway between them, and the feet.
fn lift(scenario: &Scenario, path: &TimedPath, variant: &Variant) -> Option<LiftAssessment> {
    let (worker, task) = (&scenario.worker, &scenario.task);
    let second = scenario.second_hand.filter(|_| worker.hands == Hands::Both)?;
    let middle = |tcp: &Pose| {
        let first = tcp * variant.grip;
        0.5 * (first.translation.vector + (first * second.between).translation.vector)
            - Vec3::z() * variant.floor_m
    };
    let hands: Vec<Vec3> = path.poses.iter().map(middle).collect();
    let ankles = Vec3::new(variant.at_m[0], variant.at_m[1], 0.0);
    let facing = Vec3::new(variant.facing.cos(), variant.facing.sin(), 0.0);
    let way = lift_from_path(&path.time_s, &hands, &ankles, &facing)?;
    let asked = LiftTask {
        load_kg: task.load_kg,
        lifts_per_min: task.cycles_per_min.unwrap_or(SELDOM_PER_MIN),
        duration: LiftDuration::Long,
        coupling: LiftCoupling::from_reba_class(task.coupling),
        control_at_destination: true,
    };
    let mut conditions: Vec<LiftCondition> = way.condition().into_iter().collect();
    if matches!(worker.stance, Stance::Seated { .. }) {
        conditions.push(LiftCondition::SeatedOrKneeling);
    }
    if task.human_load_share < 1.0 {
        conditions.push(LiftCondition::MechanicalHelp);
    }
    let mut found = assess_lift(way.origin, way.destination, &asked, &conditions);
    found.notes.extend(way.note());
    Some(found)
}

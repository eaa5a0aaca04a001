//! What the whole body does along a path besides its scores: how far trunk and knees bend, how safely it
//! stands, what the low back bears, and what the lifting equation says of a lift with both hands.

use super::repetitions::{Repetition, Repetitions};
use super::result::{BodyStrain, Spread};
use crate::ergonomics::{
    LiftAssessment, LiftCondition, LiftCoupling, LiftDuration, LiftTask, assess_lift,
    lift_from_path,
};
use crate::human::{Hands, Pelvis, Stance};
use crate::math::Vec3;
use crate::math::stats::{mean, quantile};
use crate::scenario::{Scenario, Variant};
use crate::survey::{Lens, PostureAngles};
use crate::trajectory::TimedPath;

/// Knee flexion from which a repetition counts as one with bent knees, deg (REBA's second class).
const BENT_DEG: f64 = 60.0;
/// Lifts a minute where nothing is given: seldom.
const SELDOM_PER_MIN: f64 = 0.2;

impl Repetitions {
    /// The strain of the repetitions that begin; none where there are none.
    pub(super) fn strain(
        &self,
        scenario: &Scenario,
        lens: &Lens,
        (path, variant): (&TimedPath, &Variant),
    ) -> Option<BodyStrain> {
        let begun: Vec<&[PostureAngles]> =
            self.all.iter().map(reached).filter(|a| !a.is_empty()).collect();
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
            bent_knees_share: moves.then(|| share(bent)),
            raised_heels_share: moves.then(|| share(raised)),
            balance_margin_m: moves.then(|| spread(&margins).negative()),
            l5s1_peak_nm: spread(&most(&|a| a.l5s1_nm)),
            l5s1_mean_nm: spread(&moments),
            niosh: lift(scenario, path, variant),
        })
    }
}

/// The frames before the reach is exceeded.
fn reached(repetition: &Repetition) -> &[PostureAngles] {
    let end = repetition.rollout.reach_exceeded_at.unwrap_or(repetition.angles.len());
    &repetition.angles[..end.min(repetition.angles.len())]
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
    let middle = |tcp: &crate::math::Pose| {
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
        coupling: match task.coupling {
            0 => LiftCoupling::Good,
            1 => LiftCoupling::Fair,
            _ => LiftCoupling::Poor,
        },
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

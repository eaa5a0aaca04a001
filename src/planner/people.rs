//! Who of the people who repeat is worst off, and what this person does otherwise than the others.

use super::repetitions::{Repetition, Repetitions};
use super::result::{Moved, WorstOff};
use crate::ergonomics::PeopleSpread;
use crate::math::stats::mean;
use crate::survey::{Lens, PostureAngles};

/// Difference of a mean angle from which it is told, deg.
const LEAST_DEG: f64 = 3.0;
/// Most angles that are told.
const MOST: usize = 3;

impl Repetitions {
    /// The person with the highest mean score among people who differ as `spread` says.
    pub(super) fn worst_off(&self, lens: &Lens, spread: &PeopleSpread) -> WorstOff {
        let person = spread.worst();
        let angle = |moved: Moved, a: &PostureAngles| match moved {
            Moved::Trunk => a.trunk_neck(lens.neck).trunk_flex_deg,
            Moved::UpperArm => a.arm.upper_arm_elevation_deg,
            Moved::Elbow => a.arm.elbow_flex_deg,
            Moved::Neck => a.trunk_neck(lens.neck).neck_flex_deg,
            Moved::Knees => a.legs.knees_deg[0].max(a.legs.knees_deg[1]),
        };
        let of = |moved: Moved, who: &mut dyn Iterator<Item = &Repetition>| {
            let own = |r: &Repetition| {
                mean(&r.reached().iter().map(|a| angle(moved, a)).collect::<Vec<f64>>())
            };
            mean(&who.map(own).filter(|v| v.is_finite()).collect::<Vec<f64>>())
        };
        let mut departs: Vec<(Moved, f64)> = Moved::ALL
            .into_iter()
            .map(|moved| {
                let own = of(moved, &mut self.all.iter().skip(person).step_by(spread.persons));
                (moved, own - of(moved, &mut self.all.iter()))
            })
            .filter(|(_, by)| by.abs() >= LEAST_DEG)
            .collect();
        departs.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        departs.truncate(MOST);
        WorstOff { person: person + 1, score: spread.by_person[person], departs }
    }
}

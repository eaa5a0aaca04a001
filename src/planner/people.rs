//! Who of the people who repeat is worst off, and what this person does otherwise than the others.

use super::person::Person;
use super::repetitions::{Repetition, Repetitions};
use super::result::{Moved, OfSize, WorstOff};
use crate::ergonomics::PeopleSpread;
use crate::human::{BodySize, Sex};
use crate::math::stats::{mean, rank_correlation};
use crate::survey::{Lens, PostureAngles};

/// Difference of a mean angle from which it is told, deg.
const LEAST_DEG: f64 = 3.0;
/// Most angles that are told.
const MOST: usize = 3;

impl Repetitions {
    /// How people's means go with their sizes; none where all have one body.
    pub(super) fn of_size(&self, spread: &PeopleSpread, person: &Person) -> Option<OfSize> {
        let size = |r: &Repetition| person.member_size(r);
        let sizes: Vec<BodySize> = self.all[..spread.persons].iter().map_while(size).collect();
        let column = |of: fn(&BodySize) -> f64| -> Vec<f64> { sizes.iter().map(of).collect() };
        let is_woman = |s: &BodySize| f64::from(u8::from(s.sex == Sex::Female));
        let statures = column(|s| s.stature_m);
        let columns = [statures.clone(), column(|s| s.mass_kg), column(is_woman)];
        let split = spread.split(&columns, self.all.len())?;
        Some(OfSize { with_stature: rank_correlation(&statures, &spread.by_person)?, split })
    }

    /// The person with the highest mean score among people who differ as `spread` says.
    pub(super) fn worst_off(
        &self,
        lens: &Lens,
        spread: &PeopleSpread,
        person: &Person,
    ) -> WorstOff {
        let worst = spread.worst();
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
                let own = of(moved, &mut self.all.iter().skip(worst).step_by(spread.persons));
                (moved, own - of(moved, &mut self.all.iter()))
            })
            .filter(|(_, by)| by.abs() >= LEAST_DEG)
            .collect();
        departs.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        departs.truncate(MOST);
        let size = self.all.get(worst).and_then(|r| person.member_size(r));
        WorstOff { person: worst + 1, size, score: spread.by_person[worst], departs }
    }
}

#[cfg(test)]
mod tests {
    use crate::ergonomics::ScoringMethod;
    use crate::human::Sex;
    use crate::planner::lens::lens;
    use crate::planner::person::{Person, modelled};
    use crate::planner::prepare::Workshop;
    use crate::planner::preset::load_preset;
    use crate::planner::space::Space;
    use crate::scenario::{Scenario, read_scenario};
    use std::path::Path;

    /// The shipped bench with 32 people of whom three in eight are women.
    fn bench() -> Scenario {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        let text = std::fs::read_to_string(folder.join("bench_pick_and_place.toml")).unwrap();
        let line = |l: &str| match l.split_once(" = ") {
            Some(("bodies", _)) => "bodies = \"population\"\nwomen_share = 0.375".to_owned(),
            Some(("posture_model", _)) => "posture_model = \"people\"".to_owned(),
            _ => l.to_owned(),
        };
        let text: Vec<String> = text.lines().map(line).collect();
        let file = tempfile::tempdir().unwrap();
        let path = file.path().join("population.toml");
        std::fs::write(&path, text.join("\n")).unwrap();
        read_scenario(&path).unwrap()
    }

    #[test]
    fn people_of_a_population_move_as_each_would_alone() {
        let scenario = bench();
        let members = scenario.worker.members[0].clone();
        let women = members.iter().filter(|m| m.size.sex == Sex::Female).count();
        assert_eq!((members.len(), women), (32, 12));
        let preset = load_preset("quick").unwrap();
        let workshop = Workshop::new(&scenario, &preset, 1);
        let choice = Space::new(&scenario, &preset).named().remove(0);
        let prepared = workshop.candidate(&choice.candidate, &choice.variant);
        let path = prepared.path.as_ref().expect("the straight path is one");
        let people_move = modelled(&scenario).unwrap();
        let all = Person::all(&scenario, &people_move).unwrap();
        let block = (1, 3);
        let repetitions = all[0].repeat(path, &prepared.variant, block, 0..70);
        assert_eq!((repetitions.all.len(), repetitions.persons), (70, Some(32)));
        for r in [0, 5, 40, 69] {
            let repetition = &repetitions.all[r];
            assert_eq!(repetition.member, (r + 3 * 11) % 32);
            let mut alone = scenario.clone();
            alone.worker.bodies = vec![members[repetition.member].clone()];
            alone.worker.members = vec![Vec::new()];
            let one = Person::all(&alone, &people_move).unwrap();
            let own = one[0].repeat(path, &prepared.variant, block, r..r + 1);
            assert_eq!(own.all[0].rollout, repetition.rollout, "repetition {r}");
            let rest = |p: &Person| p.rest_at(&prepared.variant, repetition, 0);
            assert_eq!(rest(&one[0]), rest(&all[0]));
        }
        // Who is worst off has a size, and the hand is where the path has it, whoever it is.
        let scores = repetitions.summary(&all[0], &lens(&scenario), scenario.worker.other_arm);
        let scores = scores.unwrap();
        let worst = scores.worst_off.unwrap();
        let size = members[repetitions.all[worst.person - 1].member].size;
        assert_eq!(worst.size, Some(size));
        let of_size = scores.of_size.unwrap();
        assert!(of_size.with_stature.abs() <= 1.0);
        let between = scores.scores[ScoringMethod::Rula].people.as_ref().unwrap().between_sd;
        let whole = of_size.split.size_sd.hypot(of_size.split.way_sd);
        assert!(whole <= between + 0.1, "{whole} of {between}");
        assert!(scores.hand_residual_max_mm < 1.0, "{}", scores.hand_residual_max_mm);
    }
}

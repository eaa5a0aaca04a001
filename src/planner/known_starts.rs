//! Start postures that were found before: paths of a search mostly begin at the same place, and every path meets
//! the same people there.

use crate::posture::{Grips, Start};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Mutex, PoisonError};

/// Places and blocks whose starts are kept at a time: searches move on from block to block.
const KEPT: usize = 32;

/// Start postures of one person by one way of moving, by the rule of the scenario.
#[derive(Debug, Default)]
pub(super) struct KnownStarts(Mutex<BTreeMap<Place, HashMap<Who, Start>>>);

/// The block first, so that the oldest goes first.
type Place = ((u64, u32), Vec<u64>);
/// Number of a repetition, and its mode.
type Who = (usize, Option<usize>);

impl KnownStarts {
    /// Starts of some repetitions of a block, those that are not known by `find`.
    pub(super) fn of(
        &self,
        grips: &Grips,
        block: (u64, u32),
        who: &[Who],
        find: impl FnOnce(&[Who]) -> Vec<Start>,
    ) -> Vec<Start> {
        let place = (block, bits(grips));
        // A poisoned lock holds whole entries all the same.
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut found: HashMap<Who, Start> = HashMap::new();
        if let Some(known) = lock().get(&place) {
            found.extend(who.iter().filter_map(|w| Some((*w, known.get(w)?.clone()))));
        }
        let missing: Vec<Who> = who.iter().filter(|w| !found.contains_key(w)).copied().collect();
        if !missing.is_empty() {
            // Found without the lock: two paths may both look for the same, and find the same.
            let new: Vec<(Who, Start)> = missing.iter().copied().zip(find(&missing)).collect();
            let mut known = lock();
            while known.len() >= KEPT && !known.contains_key(&place) {
                known.pop_first();
            }
            known.entry(place).or_default().extend(new.iter().cloned());
            found.extend(new);
        }
        who.iter().filter_map(|w| found.get(w).cloned()).collect()
    }
}

/// Grips bit by bit.
fn bits(grips: &Grips) -> Vec<u64> {
    let of = |pose: &crate::math::Pose| {
        let (at, turn) = (pose.translation.vector, pose.rotation.coords);
        [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w].map(f64::to_bits)
    };
    grips.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use std::cell::RefCell;

    #[test]
    fn what_was_found_before_is_not_looked_for_again() {
        let known = KnownStarts::default();
        let asked = RefCell::new(Vec::new());
        let start =
            |&(r, mode): &Who| Start { q: None, distance: r as f64, is_unusual: false, mode };
        let get = |grips: &Grips, block: u32, who: &[Who]| {
            let find = |missing: &[Who]| {
                asked.borrow_mut().push(missing.len());
                missing.iter().map(start).collect()
            };
            let found = known.of(grips, (1, block), who, find);
            assert_eq!(found, who.iter().map(start).collect::<Vec<_>>());
            asked.borrow_mut().drain(..).sum::<usize>()
        };
        let here = Grips::from(Pose::identity());
        let there = Grips::from(Pose::translation(0.0, 0.0, 1e-9));
        let who: Vec<Who> = (0..4).map(|r| (r, (r % 2 == 0).then_some(0))).collect();
        assert_eq!(get(&here, 0, &who[..2]), 2);
        assert_eq!(get(&here, 0, &who), 2);
        assert_eq!(get(&here, 0, &who[1..]), 0);
        assert_eq!(get(&here, 0, &[(0, Some(1))]), 1);
        assert_eq!(get(&there, 0, &who), 4);
        // The oldest are forgotten, not the newest.
        for block in 1..=KEPT as u32 {
            assert_eq!(get(&here, block, &who), 4);
        }
        assert_eq!(get(&here, KEPT as u32, &who), 0);
        assert_eq!(get(&here, 0, &who), 4);
    }
}

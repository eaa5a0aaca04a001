//! What all stages of a run share, and what they ask of it.

use super::near::{ArmAlong, Care};
use super::objective::{Figures, PathTerms};
use super::person::Person;
use super::prepare::{Prepared, Workshop};
use super::preset::Preset;
use super::repetitions::Repetitions;
use super::request::{PlanError, Stage, Step};
use crate::scenario::{Freedom, Scenario};
use crate::survey::Lens;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Block of repetitions of the selection. The searches take theirs from 16 on.
pub(super) const SELECTION_BLOCK: u32 = 1;

/// Figures of the straight path's first repetitions of the block that was asked for last, by their number.
pub(super) type StraightKnown = Mutex<Option<((u64, u32), BTreeMap<usize, Vec<Figures>>)>>;

/// What all stages of a run share.
pub(super) struct Environment<'a> {
    pub scenario: &'a Scenario,
    pub preset: &'a Preset,
    pub workshop: &'a Workshop<'a>,
    pub people: &'a [Person<'a>],
    pub lens: &'a Lens,
    /// The straight path, against which others are guarded; none where it is not feasible.
    pub straight: Option<Prepared>,
    pub straight_known: StraightKnown,
    pub seed: u64,
    pub stage: Stage<'a>,
}

impl Environment<'_> {
    /// Figures of repetitions `range` of a block along a path, for each body.
    pub(super) fn figures(
        &self,
        p: &Prepared,
        block: (u64, u32),
        range: std::ops::Range<usize>,
        care: Care,
    ) -> Vec<Figures> {
        let Some(path) = &p.path else { return Vec::new() };
        let robot = self.workshop.robot_of(&p.variant);
        let arm = (range.start < care.repetitions()).then(|| p.arm(&robot, care)).flatten();
        let of = |person: &Person| {
            let repetitions = person.scored(path, &p.variant, (block, range.clone()), self.lens);
            let (near_m, nearest) = near(person, &repetitions, &range, (arm.as_ref(), p));
            let nearest = nearest.filter(|_| care != Care::Search);
            Figures { near_m, nearest, ..Figures::of(&repetitions, self.lens) }
        };
        self.people.iter().map(of).collect()
    }

    /// Figures of the first repetitions of a block along the straight path, for each body; nothing where it is not
    /// feasible.
    pub(super) fn straight_figures(&self, block: (u64, u32), count: usize) -> Vec<Figures> {
        let Some(straight) = &self.straight else { return Vec::new() };
        let before = {
            let known = self.straight_known.lock().unwrap_or_else(PoisonError::into_inner);
            let of_block = known.as_ref().filter(|(of, _)| *of == block);
            of_block
                .and_then(|(_, by_count)| by_count.range(..=count).next_back())
                .map(|(n, figures)| (*n, figures.clone()))
        };
        let (from, mut all) =
            before.unwrap_or_else(|| (0, vec![Figures::default(); self.people.len()]));
        if from < count {
            let more = self.figures(straight, block, from..count, Care::Blind);
            all.iter_mut().zip(more).for_each(|(f, m)| f.extend(m));
            let mut known = self.straight_known.lock().unwrap_or_else(PoisonError::into_inner);
            if known.as_ref().is_none_or(|(of, _)| *of != block) {
                *known = Some((block, BTreeMap::new()));
            }
            if let Some((_, by_count)) = known.as_mut() {
                by_count.insert(count, all.clone());
            }
        }
        all
    }

    /// What of the path itself enters the objective.
    pub(super) fn terms(&self, p: &Prepared) -> PathTerms {
        let free = &self.scenario.free;
        let is_free = [Freedom::Duration, Freedom::Dwell].iter().any(|f| free.range(*f).is_some());
        let nominal_s = self.scenario.nominal().whole_s();
        PathTerms {
            time_share: is_free.then_some(p.variant.whole_s() / nominal_s),
            clearance_m: p.clearance().map(|c| c.distance_m),
            person: None,
        }
    }

    /// The same with the margin to the person, which a search only weighs.
    pub(super) fn terms_in_search(&self, p: &Prepared) -> PathTerms {
        PathTerms { person: Some(self.scenario.person_margin), ..self.terms(p) }
    }
}

/// Least distances of one person's repetitions to the arm, m, and the least of all with what is there.
pub(super) fn near<A: Sync>(
    person: &Person,
    repetitions: &Repetitions<A>,
    numbers: &std::ops::Range<usize>,
    (arm, p): (Option<&ArmAlong>, &Prepared),
) -> (Vec<f64>, Option<(f64, [String; 2])>) {
    let Some(arm) = arm else { return (Vec::new(), None) };
    let closest = person.closest(repetitions, numbers, (arm, &p.variant));
    let least = closest.iter().flatten().min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let nearest = least.map(|c| (c.distance_m, arm.between(c, person.parts())));
    (closest.into_iter().flatten().map(|c| c.distance_m).collect(), nearest)
}

/// Parallel map in order, with progress; ends early when the user interrupts.
pub(super) fn counted<T: Sync, R: Send>(
    environment: &Environment,
    stage: &'static str,
    (before, total, best): (usize, usize, Option<f64>),
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Result<Vec<R>, PlanError> {
    let done = std::sync::atomic::AtomicUsize::new(before);
    let go_on = |done: usize| {
        let step = Step { stage, done, total, best };
        (environment.stage)(step).then_some(()).ok_or(PlanError::Interrupted(None))
    };
    go_on(before)?;
    items
        .par_iter()
        .map(|item| {
            go_on(done.load(std::sync::atomic::Ordering::Relaxed))?;
            let result = work(item);
            go_on(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1)?;
            Ok(result)
        })
        .collect()
}

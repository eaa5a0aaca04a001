//! Repetitions of one body along one path, on feet that stay or that step.
//!
//! The law speaks of hand and pelvis as they are seen from the feet. Who steps therefore meets another path of
//! the hand: the same one, seen from where the feet then are. Where reach or balance end all the same, the
//! repetition is tried again with a step shortly before that.

use super::known_starts::KnownStarts;
use super::repetitions::{AT_EDGE_M, Walked};
use crate::kinematics::Frames;
use crate::math::stream::{Purpose, stream};
use crate::posture::{
    Behaviour, Coupling, Feet, Grips, Mixture, Repeated, Rollout, STEP_S, StandingDraw, Start,
    StartRule, Stepper,
};
use rayon::prelude::*;
use std::ops::Range;

/// Offset of the block number for the feet, so that they draw from other streams than the postures.
const FEET_BLOCK: u32 = 1 << 20;
/// How often a repetition is tried again with one more step.
const MOST_TRIES: usize = 3;

/// A hand path of the model's side, and who follows it how.
pub(super) struct Walk<'a> {
    pub coupling: &'a Coupling,
    /// Where recorded people would stand, and whether these may go there; none where nothing is known of that.
    pub stepper: Option<(Stepper<'a>, bool)>,
    pub behaviour: &'a dyn Behaviour,
    pub rule: &'a StartRule,
    pub time_s: &'a [f64],
    /// In the rest frame of the scenario's standing place.
    pub grips: &'a [Grips],
    pub mixture: Option<&'a Mixture>,
    pub block: (u64, u32),
    /// Starts that this way of moving had by this rule before.
    pub known: Option<&'a KnownStarts>,
}

/// One repetition.
struct One {
    start: Start,
    rollout: Rollout,
    extrapolation_share: f64,
    feet: Option<Feet>,
}

impl One {
    /// How many samples were reached.
    fn reached(&self) -> usize {
        self.rollout.reach_exceeded_at.unwrap_or(self.rollout.q.len())
    }

    /// The first sample at which the hand is lost, or the body at the edge of balance over feet that stand.
    fn trouble(&self, coupling: &Coupling, time_s: &[f64]) -> Option<usize> {
        let mut frames = Frames::default();
        let stands = |k: &usize| {
            let since = time_s[*k] - time_s[0];
            self.feet.as_ref().is_none_or(|f| !f.steps_at(since))
        };
        let is_at_edge = |k: &usize| {
            let margin = coupling.margin_m(&self.rollout.q[*k], &mut frames);
            margin.is_some_and(|m| m < AT_EDGE_M)
        };
        (0..self.reached()).filter(stands).find(is_at_edge).or(self.rollout.reach_exceeded_at)
    }
}

impl Walk<'_> {
    /// Repetitions with these numbers; `is_sure`: the one without chance.
    pub(super) fn repeat(&self, numbers: Range<usize>, is_sure: bool) -> Walked {
        let drawn = |stepper: &Stepper| -> Vec<StandingDraw> {
            numbers.clone().map(|r| self.drawn(stepper, r, is_sure)).collect()
        };
        let would_step = match &self.stepper {
            Some((stepper, true)) => {
                return self.stepping(stepper, numbers.clone(), &drawn(stepper));
            }
            Some((stepper, false)) => {
                let would = |d: &StandingDraw| self.feet(stepper, d, &[]).is_some();
                drawn(stepper).par_iter().map(would).collect()
            }
            None => vec![false; numbers.len()],
        };
        let feet = vec![None; numbers.len()];
        let (starts, repeated) = self.follow(self.grips, numbers);
        Walked { starts, repeated, feet, would_step }
    }

    /// What a repetition draws of where it stands.
    fn drawn(&self, stepper: &Stepper, r: usize, is_sure: bool) -> StandingDraw {
        if is_sure {
            return stepper.surely();
        }
        let (seed, block) = self.block;
        let block = FEET_BLOCK.wrapping_add(block);
        let person = self.behaviour.persons().map(|persons| (r % persons) as u32);
        let mut own = person.map(|p| stream(seed, Purpose::Person, block, p));
        stepper.draw(&mut stream(seed, Purpose::Posture, block, r as u32), own.as_mut())
    }

    /// Repetitions along some grips, the feet where these are seen from.
    fn follow(&self, grips: &[Grips], numbers: Range<usize>) -> (Vec<Start>, Repeated) {
        let coupling = self.coupling;
        let first = numbers.start;
        let (mixture, rule) = (self.mixture, self.rule);
        let modes = self.behaviour.modes(mixture, self.block, numbers.clone());
        let who: Vec<_> = numbers.zip(modes).collect();
        let find = |who: &[_]| -> Vec<Start> {
            let found = self.behaviour.starts_of(coupling, &grips[0], rule, self.block, who);
            found.into_iter().map(|s| s.among(self.behaviour.postures())).collect()
        };
        let starts = match self.known {
            Some(known) => known.of(&grips[0], self.block, &who, find),
            None => find(&who),
        };
        let path = (self.time_s, grips);
        let repeated = self.behaviour.repeat(coupling, path, &starts, self.block, first);
        (starts, repeated)
    }

    fn stepping(&self, stepper: &Stepper, numbers: Range<usize>, drawn: &[StandingDraw]) -> Walked {
        let feet: Vec<Option<Feet>> =
            drawn.par_iter().map(|d| self.feet(stepper, d, &[])).collect();
        // Neighbours whose feet stay share their path.
        let runs: Vec<&[Option<Feet>]> = feet.chunk_by(|a, b| a.is_none() && b.is_none()).collect();
        let ends = runs.iter().scan(numbers.start, |end, run| {
            *end += run.len();
            Some(*end)
        });
        let parts: Vec<(Range<usize>, Option<&Feet>)> = runs
            .iter()
            .zip(ends)
            .map(|(run, end)| (end - run.len()..end, run[0].as_ref()))
            .collect();
        let tried: Vec<One> =
            parts.into_par_iter().flat_map_iter(|(part, feet)| self.part(part, feet)).collect();
        let all: Vec<One> = tried
            .into_par_iter()
            .zip(drawn)
            .zip(numbers)
            .map(|((one, drawn), r)| self.tried_again(one, r, (stepper, drawn)))
            .collect();
        let share = all.iter().map(|o| o.extrapolation_share).sum::<f64>();
        let extrapolation_share = share / all.len().max(1) as f64;
        let mut walked = Walked {
            starts: Vec::new(),
            repeated: Repeated { rollouts: Vec::new(), extrapolation_share },
            feet: Vec::new(),
            would_step: vec![false; drawn.len()],
        };
        for one in all {
            walked.starts.push(one.start);
            walked.repeated.rollouts.push(one.rollout);
            walked.feet.push(one.feet);
        }
        walked
    }

    fn feet(&self, stepper: &Stepper, drawn: &StandingDraw, forced: &[f64]) -> Option<Feet> {
        let hold = self.coupling.hold();
        stepper.feet((self.time_s, self.grips), hold, drawn, forced)
    }

    /// Repetitions that all have their feet there.
    fn part(&self, numbers: Range<usize>, feet: Option<&Feet>) -> Vec<One> {
        let (starts, repeated) = match feet {
            Some(feet) => self.follow(&seen_from(feet, self.grips), numbers),
            None => self.follow(self.grips, numbers),
        };
        let extrapolation_share = repeated.extrapolation_share;
        let all = repeated.rollouts.into_iter().zip(starts);
        all.map(|(rollout, start)| One { start, rollout, extrapolation_share, feet: feet.cloned() })
            .collect()
    }

    /// With a step before reach or balance end, as long as they then last longer.
    fn tried_again(&self, mut one: One, r: usize, who: (&Stepper, &StandingDraw)) -> One {
        let trouble = |one: &One| one.trouble(self.coupling, self.time_s);
        let mut forced: Vec<f64> = Vec::new();
        let mut ends = trouble(&one);
        for _ in 0..MOST_TRIES {
            let Some(end) = ends else { break };
            let at = self.time_s[end.min(self.time_s.len() - 1)] - self.time_s[0];
            // After the step before it is done.
            let done = one.feet.iter().flat_map(|f| &f.steps_s).map(|s| s + STEP_S);
            let earliest = done.filter(|t| *t <= at).fold(0.0, f64::max);
            forced.push((at - STEP_S).max(earliest));
            forced.sort_by(f64::total_cmp);
            let Some(feet) = self.feet(who.0, who.1, &forced) else { break };
            let Some(next) = self.part(r..r + 1, Some(&feet)).pop() else { break };
            let then = trouble(&next);
            if then.is_some_and(|then| then <= end) {
                break;
            }
            (one, ends) = (next, then);
        }
        one
    }
}

/// A path as it is seen from feet that step.
pub(super) fn seen_from(feet: &Feet, grips: &[Grips]) -> Vec<Grips> {
    let seen = |(at, grips): (&crate::posture::Footing, &Grips)| {
        let to = at.pose().inverse();
        grips.map(|g| to * g)
    };
    feet.at.iter().zip(grips).map(seen).collect()
}

#[cfg(test)]
mod tests {
    use crate::planner::person::{Person, modelled};
    use crate::planner::prepare::Workshop;
    use crate::planner::preset::load_preset;
    use crate::planner::repetitions::Repetitions;
    use crate::planner::space::Space;
    use crate::posture::{Footing, Grips};
    use crate::scenario::{Scenario, Variant, read_scenario};
    use crate::trajectory::TimedPath;
    use std::path::Path;

    fn scenario() -> Scenario {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        read_scenario(&folder.join("along_the_bench.toml")).unwrap()
    }

    fn straight(scenario: &Scenario) -> (TimedPath, Variant) {
        let preset = load_preset("quick").unwrap();
        let workshop = Workshop::new(scenario, &preset, 1);
        let choice = Space::new(scenario, &preset).named().remove(0);
        let prepared = workshop.candidate(&choice.candidate, &choice.variant);
        (prepared.path.expect("the straight path is one"), prepared.variant)
    }

    fn repeated(scenario: &Scenario, (path, variant): &(TimedPath, Variant)) -> Repetitions {
        let modelled = modelled(scenario).unwrap();
        let people = Person::all(scenario, &modelled).unwrap();
        people[0].repeat(path, variant, (1, 7), 0..16)
    }

    #[test]
    fn hands_stay_on_the_path_of_the_world_while_feet_go() {
        let scenario = scenario();
        let modelled = modelled(&scenario).unwrap();
        let people = Person::all(&scenario, &modelled).unwrap();
        let (path, variant) = straight(&scenario);
        let mut far = 0;
        for person in &people {
            let repetitions = person.repeat(&path, &variant, (1, 7), 0..16);
            for w in &repetitions.all {
                let end = w.rollout.reach_exceeded_at.unwrap_or(w.rollout.q.len());
                for k in 0..end {
                    let mut frames = crate::kinematics::Frames::default();
                    let Grips { first, .. } =
                        person.coupling.observe(&w.rollout.q[k], &mut frames).grips;
                    let hand = person.rest_at(&variant, w, k) * first;
                    let wanted = path.poses[k] * variant.grip;
                    let off = (hand.translation.vector - wanted.translation.vector).norm();
                    assert!(off < 1e-3, "{off} m at sample {k}");
                }
                let feet = w.feet.as_ref().expect("1.2 m is farther than anybody reaches");
                for pair in feet.at.windows(2).zip(&path.time_s) {
                    let ([a, b], t) = (pair.0, pair.1) else { continue };
                    assert!(a == b || feet.steps_at(*t), "feet slide at {t} s");
                }
                far += usize::from(end == w.rollout.q.len() && feet.at[end - 1].right_m < -0.6);
            }
        }
        assert!(far > 28, "{far} of 32 end on the other side");
    }

    #[test]
    fn who_need_not_step_moves_as_if_nobody_could() {
        let mut scenario = scenario();
        let (path, variant) = straight(&scenario);
        // The first quarter: within what all let the hand go.
        let count = path.time_s.len() / 8;
        let part = TimedPath {
            time_s: path.time_s[..count].to_vec(),
            poses: path.poses[..count].to_vec(),
        };
        let near = (part, variant);
        let may = repeated(&scenario, &near);
        scenario.worker.may_step = false;
        let must_stay = repeated(&scenario, &near);
        let mut same = 0;
        for (a, b) in may.all.iter().zip(&must_stay.all) {
            if a.feet.is_none() {
                assert_eq!(a.rollout, b.rollout);
                assert_eq!(a.footing(3), Footing::default());
                same += 1;
            }
            assert!(a.feet.is_some() || !b.would_step);
        }
        assert!(same > 8, "{same} of 16 stay");
    }
}

//! A person's way of moving: the only door through which the planner sees one. Behind it are a posture
//! model, a law without chance, or somebody whose way of moving is known, for simulations.

use super::coupling::Coupling;
use super::grips::Grips;
use super::hand_path::{HandPath, postures_at};
use super::law::{PostureLaw, Sampler, Sampling};
use super::model::{PostureDistribution, PostureModel};
use super::modes::{Mixture, Modes};
use super::process::FunctionDraw;
use super::rollout::{Rollout, roll_out};
use super::start::{Start, StartRule, start_posture};
use crate::math::stream::{Purpose, stream};
use rand::RngExt;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// How somebody follows a hand path. All chance depends on the stream's name only, so that the same
/// repetition meets every path alike.
pub trait Behaviour: std::fmt::Debug + Sync {
    /// From which postures movements start.
    fn postures(&self) -> &PostureDistribution;

    /// From which of them movements start with the grips (rest frame) at a place.
    fn postures_at(&self, _: &Coupling, _: &Grips) -> Cow<'_, PostureDistribution> {
        Cow::Borrowed(self.postures())
    }

    /// How often each mode occurs where the hand is lowest at a place
    /// ([`low_place`](super::modes::low_place)); none without modes.
    fn mixture(&self, _: [f64; 3]) -> Option<Mixture> {
        None
    }

    /// Of which modes of a mixture repetitions are; none where there are none.
    fn modes(
        &self,
        _: Option<&Mixture>,
        _: (u64, u32),
        numbers: Range<usize>,
    ) -> Vec<Option<usize>> {
        vec![None; numbers.len()]
    }

    /// Start postures with the grips (rest frame) at the start of a path, of repetitions with these numbers
    /// and modes: of nothing else than of a repetition's own.
    fn starts_of(
        &self,
        coupling: &Coupling,
        grips: &Grips,
        rule: &StartRule,
        block: (u64, u32),
        who: &[(usize, Option<usize>)],
    ) -> Vec<Start> {
        let postures = self.postures_at(coupling, grips);
        let of =
            |&(r, _): &(usize, _)| start_posture(coupling, &postures, rule, grips, (block, r, r));
        who.par_iter().map(of).collect()
    }

    /// Start postures with the grips (rest frame) at the start of a path, of the modes of a mixture.
    fn starts(
        &self,
        coupling: &Coupling,
        grips: &Grips,
        mixture: Option<&Mixture>,
        rule: &StartRule,
        block: (u64, u32),
        numbers: Range<usize>,
    ) -> Vec<Start> {
        let modes = self.modes(mixture, block, numbers.clone());
        let who: Vec<_> = numbers.zip(modes).collect();
        self.starts_of(coupling, grips, rule, block, &who)
    }

    /// How many people repeat in turn, so that repetition `r` is of person `r` modulo their number; none where
    /// every repetition counts alone.
    fn persons(&self) -> Option<usize> {
        None
    }

    /// Repetitions along grips in the rest frame at times (s): one from each start, numbered
    /// from `first` on.
    fn repeat(
        &self,
        coupling: &Coupling,
        path: (&[f64], &[Grips]),
        starts: &[Start],
        block: (u64, u32),
        first: usize,
    ) -> Repeated;
}

/// What somebody does along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeated {
    /// One repetition from each start.
    pub rollouts: Vec<Rollout>,
    /// Share of the path that this behaviour was not learned on; 0 where it is not learned.
    pub extrapolation_share: f64,
}

/// Offset of the block number for the noise stream, so that start and noise draw from other streams.
const NOISE_BLOCK: u32 = 1 << 16;
/// The same for the posterior functions.
const FUNCTION_BLOCK: u32 = 1 << 17;

/// The same for the modes.
const MODE_BLOCK: u32 = 1 << 19;
/// The golden ratio's fractional part: its multiples spread evenly between 0 and 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// How many people repeat in turn where a model tells people apart.
pub const PERSONS: usize = 32;

/// Blocks of functions that are kept at a time.
const KEPT_BLOCKS: usize = 4;

/// Somebody who moves as a posture model says.
#[derive(Debug)]
pub struct Modelled<'a> {
    /// Of all together, then that of each mode.
    ways: Vec<Way<'a>>,
    modes: Option<&'a Modes>,
    /// How many people repeat in turn.
    persons: usize,
}

/// One law with its postures.
#[derive(Debug)]
struct Way<'a> {
    law: &'a PostureLaw,
    postures: &'a PostureDistribution,
    sampler: Sampler<'a>,
    /// Posterior functions of the repetitions of a (seed, block): they are the same on all paths.
    functions: Mutex<BTreeMap<(u64, u32), Functions>>,
}

/// By number of the repetition.
type Functions = BTreeMap<usize, Arc<[FunctionDraw]>>;

impl<'a> Way<'a> {
    fn new(law: &'a PostureLaw, postures: &'a PostureDistribution) -> Option<Self> {
        let sampler = Sampler::new(law, Sampling::Pathwise)?;
        Some(Self { law, postures, sampler, functions: Mutex::default() })
    }

    /// Functions of some repetitions of a block, in their order.
    fn functions(
        &self,
        (seed, block): (u64, u32),
        numbers: Range<usize>,
    ) -> Vec<Arc<[FunctionDraw]>> {
        // A poisoned lock holds whole entries all the same.
        let lock = || self.functions.lock().unwrap_or_else(PoisonError::into_inner);
        let found: Vec<Option<Arc<[FunctionDraw]>>> = {
            let known = lock();
            let here = known.get(&(seed, block));
            numbers.clone().map(|r| here?.get(&r).cloned()).collect()
        };
        // Drawn without the lock: two paths may both draw the same.
        let drawn = |(r, found): (usize, Option<Arc<[FunctionDraw]>>)| {
            found.unwrap_or_else(|| {
                let mut rng = stream(seed, Purpose::Posture, FUNCTION_BLOCK + block, r as u32);
                self.sampler.functions(&mut rng)
            })
        };
        let is_new = found.iter().any(Option::is_none);
        let all: Vec<_> = numbers.clone().into_par_iter().zip(found).map(drawn).collect();
        if is_new {
            let mut known = lock();
            // Searches move on from block to block.
            while known.len() >= KEPT_BLOCKS && !known.contains_key(&(seed, block)) {
                known.pop_first();
            }
            known.entry((seed, block)).or_default().extend(numbers.zip(all.iter().cloned()));
        }
        all
    }
}

impl<'a> Modelled<'a> {
    /// `None` where a kernel matrix of the model is not positive definite.
    pub fn new(model: &'a PostureModel) -> Option<Self> {
        Self::of((&model.law, &model.postures), model.modes.as_ref())
    }

    /// Of a law with its postures, and of what modes of it are told apart.
    pub fn of(
        (law, postures): (&'a PostureLaw, &'a PostureDistribution),
        modes: Option<&'a Modes>,
    ) -> Option<Self> {
        let mut ways = vec![Way::new(law, postures)?];
        for mode in modes.iter().flat_map(|m| &m.all) {
            ways.push(Way::new(&mode.law, &mode.postures)?);
        }
        Some(Self { ways, modes, persons: PERSONS })
    }

    /// The same with every repetition by somebody else.
    #[must_use]
    pub fn strangers(self) -> Self {
        Self { persons: usize::MAX, ..self }
    }

    /// Who makes a repetition.
    fn person(&self, repetition: usize) -> usize {
        repetition % self.persons
    }

    fn way(&self, mode: Option<usize>) -> &Way<'a> {
        &self.ways[mode.map_or(0, |m| m + 1)]
    }
}

impl Behaviour for Modelled<'_> {
    fn postures(&self) -> &PostureDistribution {
        self.way(None).postures
    }

    fn postures_at(&self, coupling: &Coupling, grips: &Grips) -> Cow<'_, PostureDistribution> {
        let way = self.way(None);
        postures_at((way.law, way.postures), coupling, grips)
    }

    fn mixture(&self, place: [f64; 3]) -> Option<Mixture> {
        self.modes?.at(place)
    }

    fn modes(
        &self,
        mixture: Option<&Mixture>,
        (seed, block): (u64, u32),
        numbers: Range<usize>,
    ) -> Vec<Option<usize>> {
        let Some(mixture) = mixture else { return vec![None; numbers.len()] };
        let population = self.postures().population.filter(|_| self.persons < usize::MAX);
        let levels: Vec<f64> = if let Some(population) = population {
            population.levels((seed, block), self.persons, numbers)
        } else {
            // Spread evenly, whatever the number of repetitions.
            let from: f64 = stream(seed, Purpose::Posture, MODE_BLOCK + block, 0).random();
            numbers.map(|r| (from + GOLDEN * r as f64).fract()).collect()
        };
        levels.into_iter().map(|level| Some(mixture.mode_at(level))).collect()
    }

    fn starts_of(
        &self,
        coupling: &Coupling,
        grips: &Grips,
        rule: &StartRule,
        block: (u64, u32),
        who: &[(usize, Option<usize>)],
    ) -> Vec<Start> {
        let used: BTreeSet<Option<usize>> = who.iter().map(|(_, mode)| *mode).collect();
        let here = |mode: Option<usize>| {
            let way = self.way(mode);
            (mode, postures_at((way.law, way.postures), coupling, grips))
        };
        let postures: BTreeMap<_, _> = used.into_iter().map(here).collect();
        let of = |&(r, mode): &(usize, Option<usize>)| {
            let who = (block, r, self.person(r));
            let start = start_posture(coupling, &postures[&mode], rule, grips, who);
            Start { mode, ..start }
        };
        who.par_iter().map(of).collect()
    }

    fn persons(&self) -> Option<usize> {
        self.way(None).postures.population.map(|_| self.persons)
    }

    fn repeat(
        &self,
        coupling: &Coupling,
        (time_s, targets): (&[f64], &[Grips]),
        starts: &[Start],
        (seed, block): (u64, u32),
        first: usize,
    ) -> Repeated {
        let laid = |way: &Way| {
            let hand = HandPath::new(coupling, way.law, time_s.to_vec(), targets.to_vec());
            (hand, way.functions((seed, block), first..first + starts.len()))
        };
        let used: BTreeSet<Option<usize>> = starts.iter().map(|s| s.mode).collect();
        let laid: BTreeMap<Option<usize>, _> =
            used.into_iter().map(|mode| (mode, laid(self.way(mode)))).collect();
        let one = |(i, start): (usize, &Start)| {
            let r = first + i;
            let (way, (hand, functions)) = (self.way(start.mode), &laid[&start.mode]);
            let mut rng = stream(seed, Purpose::Posture, NOISE_BLOCK + block, r as u32);
            let own = way.postures.own((seed, block), self.person(r));
            let draw = way.sampler.draw_with(functions[i].clone(), &mut rng, hand).by(own);
            roll_out(coupling, way.law, hand, start, Some(&draw))
        };
        let rollouts = starts.par_iter().enumerate().map(one).collect();
        let share = |(mode, (hand, _)): (&Option<usize>, &(HandPath, _))| {
            let own = starts.iter().filter(|s| s.mode == *mode).count() as f64;
            own / starts.len() as f64 * hand.extrapolation_share()
        };
        Repeated { rollouts, extrapolation_share: laid.iter().map(share).sum() }
    }
}

/// Somebody without chance, who always moves as the mean of a law.
#[derive(Debug, Clone, Copy)]
pub struct Certain<'a> {
    /// The law.
    pub law: &'a PostureLaw,
    /// From which postures movements start.
    pub postures: &'a PostureDistribution,
}

impl Behaviour for Certain<'_> {
    fn postures(&self) -> &PostureDistribution {
        self.postures
    }

    fn postures_at(&self, coupling: &Coupling, grips: &Grips) -> Cow<'_, PostureDistribution> {
        postures_at((self.law, self.postures), coupling, grips)
    }

    fn repeat(
        &self,
        coupling: &Coupling,
        (time_s, targets): (&[f64], &[Grips]),
        starts: &[Start],
        _: (u64, u32),
        _: usize,
    ) -> Repeated {
        let hand = HandPath::new(coupling, self.law, time_s.to_vec(), targets.to_vec());
        let one = |start| roll_out(coupling, self.law, &hand, start, None);
        let rollouts = starts.iter().map(one).collect();
        Repeated { rollouts, extrapolation_share: hand.extrapolation_share() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Coupled, Pelvis, Side, Stance};
    use crate::math::{Pose, Vec3};
    use crate::posture::{
        Hold, LowMovement, Mode, load_model, low_place, model_text, natural_grip, save_model,
        simulated_whole_operator,
    };
    use std::path::Path;

    /// The whole operator, and the same person with straighter legs, told apart by six low movements.
    fn of_two_modes(body: &Body) -> PostureModel {
        let mut model = simulated_whole_operator(body, Side::Right).unwrap();
        let mode = |shift: f64| {
            let mut postures = model.postures.clone();
            postures.mean[1] += shift;
            Mode { trunk_deg: 60.0, knees_deg: 60.0, law: model.law.clone(), postures }
        };
        let all = vec![mode(0.02), mode(-0.05)];
        let low = |right: f64, first: f64| LowMovement {
            place: [0.2, -0.3, right],
            memberships: vec![first, 1.0 - first],
        };
        let low = vec![
            low(0.0, 1.0),
            low(0.0, 1.0),
            low(0.0, 1.0),
            low(0.3, 0.0),
            low(0.3, 0.0),
            low(0.3, 0.0),
        ];
        model.modes = Some(Modes { all, low, people: 3, below: -0.2 });
        model
    }

    fn path(right_m: f64) -> (Vec<f64>, Vec<Grips>) {
        let at = |i: usize| {
            let up = -0.60 + 0.01 * i as f64;
            let place = Vec3::new(0.35, up, right_m);
            Pose::from_parts(place.into(), natural_grip(-0.3))
        };
        ((0..20).map(|i| 0.05 * f64::from(i)).collect(), (0..20).map(|i| at(i).into()).collect())
    }

    #[test]
    fn repetitions_are_of_the_modes_as_often_as_each_occurs() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let model = of_two_modes(&body);
        let modes = model.modes.as_ref().unwrap();
        let coupled = Coupled { hands: Side::Right.into(), pelvis: Pelvis::Moves };
        let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
        let coupling = Coupling::of_person(&body, coupled, &[Hold::Rigid], standing).unwrap();
        let people = Modelled::new(&model).unwrap();
        let (time_s, grips) = path(0.1);
        let hands: Vec<Pose> = grips.iter().map(|g| g.first).collect();
        let mixture = people.mixture(low_place(&hands, coupling.stature_m())).unwrap();
        assert!(mixture.shares[0] > 0.6, "{mixture:?}");
        let drawn = |people: &Modelled, numbers: Range<usize>| {
            let (rule, block) = (StartRule::Sampled, (5, 2));
            let mixed = Some(&mixture).filter(|_| people.modes.is_some());
            let first = numbers.start;
            let starts = people.starts(&coupling, &grips[0], mixed, &rule, block, numbers);
            let rollouts =
                people.repeat(&coupling, (&time_s, &grips), &starts, block, first).rollouts;
            (starts, rollouts)
        };
        let (starts, rollouts) = drawn(&people, 0..40);
        let first = starts.iter().filter(|s| s.mode == Some(0)).count() as f64;
        assert!((first - 40.0 * mixture.shares[0]).abs() < 1.5, "{first} {mixture:?}");
        // Each is what a person of that mode does, whoever else is drawn, and from whatever number on.
        let own =
            |k: usize| Modelled::of((&modes.all[k].law, &modes.all[k].postures), None).unwrap();
        let alone = [0, 1].map(|k| drawn(&own(k), 0..40).1);
        for (r, (start, rollout)) in starts.iter().zip(&rollouts).enumerate() {
            assert_eq!(rollout, &alone[start.mode.unwrap()][r], "repetition {r}");
        }
        assert_eq!(drawn(&people, 7..12).1, rollouts[7..12]);
        // Higher up nobody is told apart.
        assert!(people.mixture([0.2, -0.1, 0.0]).is_none());
        let (starts, _) = drawn(&Modelled::of((&model.law, &model.postures), None).unwrap(), 0..3);
        assert!(starts.iter().all(|s| s.mode.is_none()));
    }

    #[test]
    fn people_repeat_in_turn_and_stay_themselves() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let coupled = Coupled { hands: Side::Right.into(), pelvis: Pelvis::Moves };
        let standing = (Stance::Standing { shoe_m: 0.0 }, 0.0);
        let coupling = Coupling::of_person(&body, coupled, &[Hold::Rigid], standing).unwrap();
        let (mut model, _) = load_model("people", Path::new(".")).unwrap();
        let (times, grips) = path(0.15);
        let ends = |model: &PostureModel, persons: usize, count: usize| -> Vec<f64> {
            let people = Modelled { persons, ..Modelled::new(model).unwrap() };
            let starts =
                people.starts(&coupling, &grips[0], None, &StartRule::Sampled, (4, 0), 0..count);
            let walks = people.repeat(&coupling, (&times, &grips), &starts, (4, 0), 0).rollouts;
            walks.iter().map(|w| w.q.last().unwrap()[3]).collect()
        };
        // Repetitions of one person are nearer to each other than those of people are, the more the larger
        // the person's own part is.
        let mut share = |own_share: f64| {
            model.postures.population =
                Some(super::super::Population { own_share, people: 400, tail: 1.0 });
            let ends = ends(&model, 24, 96);
            let lasts = vec![0.0; ends.len()];
            let spread = crate::ergonomics::PeopleSpread::of(&ends, &lasts, Some(24)).unwrap();
            spread.between_sd.powi(2) / (spread.between_sd.powi(2) + spread.within_sd.powi(2))
        };
        let (small, large) = (share(0.1), share(0.8));
        assert!(small < 0.3 && large > 0.4, "{small} {large}");
        let people = Modelled::new(&model).unwrap();
        assert_eq!(people.persons(), Some(PERSONS));
        assert_eq!((people.person(3), people.person(3 + PERSONS)), (3, 3));
        assert_eq!(people.strangers().person(3 + PERSONS), 3 + PERSONS);
        model.postures.population = None;
        assert_eq!(Modelled::new(&model).unwrap().persons(), None);
    }

    #[test]
    fn modes_are_kept_in_files_and_with_both_hands_but_not_on_a_seat() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let model = of_two_modes(&body);
        let both = model.adapted(Pelvis::Moves, true).unwrap();
        let modes = both.modes.as_ref().unwrap();
        assert_eq!(modes.all[1].law.weight.shape(), both.law.weight.shape());
        assert_eq!(modes.all[1].postures.mean.len(), both.joints.len());
        assert!(modes.all[1].law.pair.is_some());
        assert!(model.adapted(Pelvis::Turns, false).unwrap().modes.is_none());
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("model.json");
        save_model(&model, &file).unwrap();
        let (read, _) = load_model("model.json", folder.path()).unwrap();
        assert_eq!(model_text(&read).unwrap(), model_text(&model).unwrap());
        let mut broken = of_two_modes(&body);
        broken.modes.as_mut().unwrap().low[0].memberships[0] = 0.5;
        save_model(&broken, &file).unwrap();
        let error = load_model("model.json", folder.path()).unwrap_err().to_string();
        assert!(error.contains("modes must be two or more"), "{error}");
    }
}

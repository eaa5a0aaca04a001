//! A person's way of moving: the only door through which the planner sees one. Behind it are a posture
//! model, a law without chance, or somebody whose way of moving is known, for simulations.

use super::coupling::Coupling;
use super::grips::Grips;
use super::hand_path::{HandPath, postures_at};
use super::law::{PostureLaw, Sampler, Sampling};
use super::model::{PostureDistribution, PostureModel};
use super::process::FunctionDraw;
use super::rollout::{Rollout, roll_out};
use super::start::Start;
use crate::math::stream::{Purpose, stream};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
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

/// Blocks of functions that are kept at a time.
const KEPT_BLOCKS: usize = 4;

/// Somebody who moves as a posture model says.
#[derive(Debug)]
pub struct Modelled<'a> {
    model: &'a PostureModel,
    sampler: Sampler<'a>,
    /// Posterior functions of the repetitions of a (seed, block): they are the same on all paths.
    functions: Mutex<BTreeMap<(u64, u32), Functions>>,
}

type Functions = Arc<Vec<Arc<[FunctionDraw]>>>;

impl<'a> Modelled<'a> {
    /// `None` where a kernel matrix of the model is not positive definite.
    pub fn new(model: &'a PostureModel) -> Option<Self> {
        let sampler = Sampler::new(&model.law, Sampling::Pathwise)?;
        Some(Self { model, sampler, functions: Mutex::default() })
    }

    /// At least `count` repetitions' functions of a block.
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
}

impl Behaviour for Modelled<'_> {
    fn postures(&self) -> &PostureDistribution {
        &self.model.postures
    }

    fn postures_at(&self, coupling: &Coupling, grips: &Grips) -> Cow<'_, PostureDistribution> {
        postures_at((&self.model.law, &self.model.postures), coupling, grips)
    }

    fn repeat(
        &self,
        coupling: &Coupling,
        (time_s, targets): (&[f64], &[Grips]),
        starts: &[Start],
        (seed, block): (u64, u32),
        first: usize,
    ) -> Repeated {
        let law = &self.model.law;
        let hand = HandPath::new(coupling, law, time_s.to_vec(), targets.to_vec());
        let functions = self.functions((seed, block), first + starts.len());
        let one = |(i, start): (usize, &Start)| {
            let r = first + i;
            let mut rng = stream(seed, Purpose::Posture, NOISE_BLOCK + block, r as u32);
            let draw = self.sampler.draw_with(functions[r].clone(), &mut rng, &hand);
            roll_out(coupling, law, &hand, start, Some(&draw))
        };
        let rollouts = starts.par_iter().enumerate().map(one).collect();
        Repeated { rollouts, extrapolation_share: hand.extrapolation_share() }
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

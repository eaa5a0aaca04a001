//! People of whom nothing is known: repetitions along a recorded hand path, drawn as in a plan.

use super::dataset::{Dataset, Frame};
use super::measurer::{Features, Measurer, energy_deg};
use super::rollout_check::timed_hands;
use crate::math::stats::mean;
use crate::posture::{Behaviour, Grips, Modelled, Rollout, StartRule, low_place};

/// Repetitions of strangers along the path of a run.
pub(super) struct Strangers {
    /// One for each; those that do not begin have lost the hand at once.
    pub walks: Vec<Rollout>,
    begun: Vec<bool>,
}

impl Strangers {
    /// From starts that the people draw.
    pub(super) fn along(
        people: &Modelled,
        own: &Dataset,
        run: &[&Frame],
        (seed, repetitions): (u64, usize),
    ) -> Self {
        let (time_s, hands) = timed_hands(run);
        let grips: Vec<Grips> = hands.iter().map(Grips::from).collect();
        let mixture = people.mixture(low_place(&hands, own.coupling.stature_m()));
        let (mixture, block) = (mixture.as_ref(), (seed, run[0].trial as u32));
        let (rule, numbers) = (StartRule::Sampled, 0..repetitions);
        let starts = people.starts(&own.coupling, &grips[0], mixture, &rule, block, numbers);
        let walks = people.repeat(&own.coupling, (&time_s, &grips), &starts, block, 0).rollouts;
        Self { walks, begun: starts.iter().map(|s| s.q.is_some()).collect() }
    }

    /// Share of them that ended early.
    pub(super) fn ended_share(&self) -> f64 {
        let ended = self.walks.iter().filter(|w| w.reach_exceeded_at.is_some()).count();
        ended as f64 / self.walks.len() as f64
    }

    /// Postures of those that begin at each frame, R x T.
    pub(super) fn features(&self, measurer: &Measurer) -> Vec<Vec<Features>> {
        let begun = self.walks.iter().zip(&self.begun).filter(|(_, begun)| **begun);
        begun.map(|(w, _)| w.q.iter().map(|q| measurer.measure(q.as_slice())).collect()).collect()
    }
}

/// Mean over time of the energy score of the angles of walks (R x T) against what was seen (T), deg; NaN for
/// fewer than two walks.
pub(super) fn mean_energy_deg(walks: &[Vec<Features>], seen: &[Features]) -> f64 {
    if walks.len() < 2 {
        return f64::NAN;
    }
    let at = |(t, seen): (usize, &Features)| {
        energy_deg(&walks.iter().map(|w| &w[t]).collect::<Vec<_>>(), seen)
    };
    mean(&seen.iter().enumerate().map(at).collect::<Vec<_>>())
}

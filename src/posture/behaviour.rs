//! A person whose way of moving is known, be it a posture model's or not: for simulations.

use super::coupling::Coupling;
use super::model::PostureDistribution;
use super::rollout::Rollout;
use super::start::Start;
use crate::math::Pose;

/// How somebody walks a hand path. All chance depends on the stream's name only, so that the same
/// repetition meets every path alike.
pub trait Behaviour: std::fmt::Debug + Sync {
    /// From which postures movements start.
    fn postures(&self) -> &PostureDistribution;

    /// Repetitions along grip poses in the pelvis frame at times (s): one from each start, numbered
    /// from `first` on.
    fn walk(
        &self,
        coupling: &Coupling,
        path: (&[f64], &[Pose]),
        starts: &[Start],
        block: (u64, u32),
        first: usize,
    ) -> Vec<Rollout>;
}

//! What the worker does besides posture: load, repetition, coupling, and where each input comes from.

use super::file::{CouplingFile, TaskFile};
use serde::{Deserialize, Serialize};

/// Where a score input comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// By a recording.
    Measured,
    /// By the posture model.
    Predicted,
    /// Given in the scenario.
    FromTheTask,
    /// A default of the program.
    Assumed,
    /// Nobody knows; not scored.
    Unknown,
}

/// The task, resolved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Load on the hand, kg: part mass x human share + extra load.
    pub load_kg: f64,
    /// Mass of the part, kg.
    pub part_mass_kg: f64,
    /// Share of the part's weight that the worker carries.
    pub human_load_share: f64,
    /// Where the share comes from.
    pub share_origin: Origin,
    /// Load besides the part, kg.
    pub extra_load_kg: f64,
    /// Whether any load was given.
    pub load_origin: Origin,
    /// Cycles a minute, if given.
    pub cycles_per_min: Option<f64>,
    /// Longest static hold, s, if given.
    pub hold_s: Option<f64>,
    /// Shock or rapid build-up of force.
    pub shock: bool,
    /// Coupling class of REBA, 0 good to 3 unacceptable.
    pub coupling: u8,
    /// Where the coupling comes from.
    pub coupling_origin: Origin,
}

impl Task {
    pub(super) fn new(file: &TaskFile) -> Self {
        let value = |v: &Option<toml::Spanned<f64>>| v.as_ref().map(|s| *s.get_ref());
        let origin = |given: bool| if given { Origin::FromTheTask } else { Origin::Assumed };
        let part_mass_kg = value(&file.part_mass_kg).unwrap_or(0.0);
        let human_load_share = value(&file.human_load_share).unwrap_or(1.0);
        let extra_load_kg = value(&file.extra_load_kg).unwrap_or(0.0);
        let coupling = file.coupling.map_or(0, |c| match c {
            CouplingFile::Good => 0,
            CouplingFile::Fair => 1,
            CouplingFile::Poor => 2,
            CouplingFile::Unacceptable => 3,
        });
        Self {
            load_kg: part_mass_kg * human_load_share + extra_load_kg,
            part_mass_kg,
            human_load_share,
            share_origin: origin(file.human_load_share.is_some()),
            extra_load_kg,
            load_origin: origin(file.part_mass_kg.is_some() || file.extra_load_kg.is_some()),
            cycles_per_min: value(&file.cycles_per_min),
            hold_s: value(&file.hold_s),
            shock: file.shock,
            coupling,
            coupling_origin: origin(file.coupling.is_some()),
        }
    }

    /// More than four times a minute (RULA and REBA).
    pub fn is_repeated(&self) -> bool {
        self.cycles_per_min.is_some_and(|c| c > 4.0)
    }

    /// Held for more than a minute (RULA and REBA).
    pub fn is_static(&self) -> bool {
        self.hold_s.is_some_and(|h| h > 60.0)
    }

    /// Whether muscle use follows from the scenario, or has to be shown for both cases.
    pub fn muscle_origin(&self) -> Origin {
        let settles = self.is_repeated() || self.is_static();
        if settles || (self.cycles_per_min.is_some() && self.hold_s.is_some()) {
            Origin::FromTheTask
        } else {
            Origin::Assumed
        }
    }
}

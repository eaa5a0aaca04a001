//! How a scenario's task and worker enter the score sheets.

use crate::ergonomics::TaskInputs;
use crate::human::{Hands, Stance};
use crate::scenario::Scenario;
use crate::survey::Lens;

/// As the scenario says; muscle use only where it follows from the task.
pub(super) fn lens(scenario: &Scenario) -> Lens {
    let t = &scenario.task;
    let w = &scenario.worker;
    let is_seated = matches!(w.stance, Stance::Seated { .. });
    Lens {
        task: TaskInputs {
            load_kg: t.load_kg,
            load_static_or_repeated: t.is_repeated() || t.is_static(),
            load_shock: t.shock,
            static_gt_1min: t.is_static(),
            repeated_gt_4min: t.is_repeated(),
            rapid_large_changes: false,
            coupling: t.coupling,
            sitting: is_seated,
            trunk_supported: w.trunk_supported,
            legs_unbalanced: false,
            knee_flex_deg: 0.0,
            arm_supported: w.arm_supported,
        },
        neck: w.neck,
        both_hands: w.hands == Hands::Both,
        profile: scenario.score_profile,
    }
}

//! Exertions of the hands over a shift by DUET, as the user rates them. Each hand for itself.

use super::read::ShiftTask;
use crate::ergonomics::{duet_damage, duet_probability};
use crate::human::Side;
use serde::Serialize;

/// Hand exertions of the shift.
#[derive(Debug, Clone, Serialize)]
pub struct ExertionDose {
    /// The rated tasks.
    pub tasks: Vec<TaskExertion>,
    /// Indices of the tasks without a rating: they add nothing.
    pub not_rated: Vec<usize>,
    /// Each hand with rated work.
    pub hands: Vec<HandDose>,
}

/// Exertions of one task.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct TaskExertion {
    /// Index of the task.
    pub task: usize,
    /// Lowest and highest rating.
    pub omni_res: [u8; 2],
    /// Exertions in the shift.
    pub exertions: f64,
    /// Damage at the lowest and the highest rating, to each hand of the task.
    pub damage: [f64; 2],
}

/// One hand.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct HandDose {
    /// Which.
    pub side: Side,
    /// Cumulative damage at the lowest and the highest ratings.
    pub damage: [f64; 2],
    /// Share of people with an injury and pain in the last year at that damage, in the study behind the tool.
    pub probability: [f64; 2],
}

/// Sums up the rated tasks; none where there are none.
pub(super) fn exertion(tasks: &[ShiftTask]) -> Option<ExertionDose> {
    let of = |(k, t): (usize, &ShiftTask)| {
        let omni_res = t.omni_res?;
        let exertions = t.cycles * t.exertions;
        let damage = |rating: u8| duet_damage(rating).map(|d| d * exertions);
        let [low, high] = omni_res;
        Some(TaskExertion { task: k, omni_res, exertions, damage: [damage(low)?, damage(high)?] })
    };
    let rated: Vec<TaskExertion> = tasks.iter().enumerate().filter_map(of).collect();
    if rated.is_empty() {
        return None;
    }
    let not_rated = (0..tasks.len()).filter(|k| rated.iter().all(|r| r.task != *k)).collect();
    let hand = |side: Side| {
        let own = || {
            rated.iter().filter(move |r| {
                tasks.get(r.task).is_some_and(|t| t.hands().sides().contains(&side))
            })
        };
        own().next()?;
        let damage = [0, 1].map(|end: usize| own().map(|r| r.damage[end]).sum::<f64>());
        Some(HandDose { side, damage, probability: damage.map(duet_probability) })
    };
    let hands = [Side::Right, Side::Left].into_iter().filter_map(hand).collect();
    Some(ExertionDose { tasks: rated, not_rated, hands })
}

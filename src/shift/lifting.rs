//! Lifting over a shift: the composite lifting index of the tasks to which the equation applies.

use super::file::Order;
use super::read::{Shift, ShiftTask, TaskSource};
use crate::ergonomics::{
    CompositeLift, LiftCondition, LiftCoupling, LiftDuration, LiftNote, LiftShare, LiftTask,
    composite_lift,
};
use crate::human::Hands;
use serde::Serialize;

/// Lifting in the shift.
#[derive(Debug, Clone, Serialize)]
pub struct LiftingDose {
    /// What the equation says of each task.
    pub tasks: Vec<TaskLift>,
    /// Indices of the tasks to which it applies, as the steps of `composite` count them.
    pub applies_to: Vec<usize>,
    /// How long lifting goes on, for table 5; none above 8 h.
    pub duration: Option<LiftDuration>,
    /// The composite index; of a single task its own index.
    pub composite: Option<CompositeLift>,
    /// Why there is none although tasks apply.
    pub refusal: Option<CompositeRefusal>,
}

/// The lifting equation and one task.
#[derive(Debug, Clone, Serialize)]
pub struct TaskLift {
    /// Index of the task.
    pub task: usize,
    /// Lifts a minute that counted; none where it does not apply.
    pub lifts_per_min: Option<f64>,
    /// Load over the limit of the task alone; none where it does not apply, or no load is acceptable.
    pub index: Option<f64>,
    /// Why it does not apply; empty where it does.
    pub refused: Vec<LiftRefusal>,
}

/// Why the lifting equation says nothing of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftRefusal {
    /// Its authors exclude the case.
    Condition(LiftCondition),
    /// Nothing is lifted.
    NoLoad,
    /// A scored motion does not tell the load's path.
    NotARun,
    /// More than 8 h of work, for which the equation has no limits.
    TooLong,
}

/// Why several lifting tasks have no composite index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CompositeRefusal {
    /// They follow each other in blocks; the index is for tasks that alternate.
    Blocks,
    /// It is not said whether they alternate.
    OrderUnknown,
}

/// The lifting equation for the tasks of a shift, for one body.
pub(super) fn lifting(shift: &Shift, body: &str) -> LiftingDose {
    let breaks: f64 = shift.breaks.iter().map(|(_, m)| m).sum();
    let working_min = shift.minutes - breaks;
    let duration = LiftDuration::from_hours(working_min / 60.0);
    let mut tasks = Vec::new();
    let mut shares = Vec::new();
    let mut applies_to = Vec::new();
    for (k, task) in shift.tasks.iter().enumerate() {
        let mut refused = refusals(task, body);
        if duration.is_none() {
            refused.push(LiftRefusal::TooLong);
        }
        let mut found = TaskLift { task: k, lifts_per_min: None, index: None, refused };
        if found.refused.is_empty()
            && let Some(duration) = duration
        {
            // Tasks that alternate are averaged over all of the working time, blocks over their own.
            let over_min = match (shift.order, task.time_is_given) {
                (Some(Order::Mixed), _) | (None, false) => working_min,
                _ => task.minutes,
            };
            let per_min = task.cycles / over_min;
            match share(task, body, per_min, duration) {
                Some(share) => {
                    found.lifts_per_min = Some(per_min);
                    found.index = composite_lift(&[share], duration).index;
                    shares.push(share);
                    applies_to.push(k);
                }
                None => found.refused.push(LiftRefusal::Condition(LiftCondition::OneHanded)),
            }
        }
        tasks.push(found);
    }
    let refusal = match (shares.len(), shift.order) {
        (0 | 1, _) | (_, Some(Order::Mixed)) => None,
        (_, Some(Order::Blocks)) => Some(CompositeRefusal::Blocks),
        (_, None) => Some(CompositeRefusal::OrderUnknown),
    };
    let composite = duration
        .filter(|_| refusal.is_none() && !shares.is_empty())
        .map(|duration| composite_lift(&shares, duration));
    LiftingDose { tasks, applies_to, duration, composite, refusal }
}

/// Why the equation does not apply to a task.
fn refusals(task: &ShiftTask, body: &str) -> Vec<LiftRefusal> {
    let TaskSource::Run { result, .. } = &task.source else {
        return vec![LiftRefusal::NotARun];
    };
    let mut all = Vec::new();
    let mut add = |why: LiftRefusal| {
        if !all.contains(&why) {
            all.push(why);
        }
    };
    if result.setting.worker.hands != Hands::Both {
        add(LiftRefusal::Condition(LiftCondition::OneHanded));
    }
    if matches!(result.setting.worker.stance, crate::human::Stance::Seated { .. }) {
        add(LiftRefusal::Condition(LiftCondition::SeatedOrKneeling));
    }
    if result.setting.task.human_load_share < 1.0 {
        add(LiftRefusal::Condition(LiftCondition::MechanicalHelp));
    }
    for note in stored(task, body).into_iter().flat_map(|l| &l.notes) {
        if let LiftNote::NotApplicable(condition) = note {
            add(LiftRefusal::Condition(*condition));
        }
    }
    for condition in &task.excluded {
        add(LiftRefusal::Condition(*condition));
    }
    if result.setting.task.load_kg <= 0.0 {
        add(LiftRefusal::NoLoad);
    }
    all
}

/// The lift of the run along the path of the task.
fn stored<'a>(task: &'a ShiftTask, body: &str) -> Option<&'a crate::ergonomics::LiftAssessment> {
    let (_, candidate) = task.source.candidate()?;
    let scores = candidate.bodies.iter().find(|b| b.body == body)?;
    scores.strain.as_ref()?.niosh.as_ref()
}

fn share(
    task: &ShiftTask,
    body: &str,
    lifts_per_min: f64,
    duration: LiftDuration,
) -> Option<LiftShare> {
    let (result, _) = task.source.candidate()?;
    let lift = stored(task, body)?;
    let asked = LiftTask {
        load_kg: result.setting.task.load_kg,
        lifts_per_min,
        duration,
        coupling: LiftCoupling::from_reba_class(result.setting.task.coupling),
        control_at_destination: true,
    };
    Some(LiftShare::of(lift.origin.point, lift.destination.point, &asked))
}

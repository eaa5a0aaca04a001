//! The composite lifting index: several lifting tasks that alternate.
//!
//! Manual, section 2.4 (2021 edition pp. 26-28; ties p. 57), a multi-task procedure:
//!
//! ```text
//! FIRWL_i   limit of task i with FM = 1, the lower one of its ends where both count
//! STRWL_i = FIRWL_i x FM(f_i)
//! FILI_i  = load / FIRWL_i,  STLI_i = load / STRWL_i
//! tasks in order of decreasing STLI; of equal ones the more frequent first
//! CLI = STLI_1 + sum over i > 1 of FILI_i x (1 / FM(f_1 + ... + f_i) - 1 / FM(f_1 + ... + f_(i-1)))
//! ```
//!
//! The manual does not say which column of table 5 the sums take where hands begin below 75 cm in some
//! tasks and above in others. Here it is the stricter one: low as soon as one task of the sum is.

use super::{LiftDuration, LiftPoint, LiftTask, assess_lift, frequency_multiplier, index};
use serde::Serialize;

/// One task of several.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LiftShare {
    /// Load on the hands, kg.
    pub load_kg: f64,
    /// Limit without regard to how often (`FIRWL`), kg.
    pub frequency_free_limit_kg: f64,
    /// Lifts a minute of this task, averaged over 15 min of the whole job.
    pub lifts_per_min: f64,
    /// Whether the hands begin at 75 cm or above.
    pub begins_high: bool,
}

impl LiftShare {
    /// Of a lift from its two ends.
    pub fn of(origin: LiftPoint, destination: LiftPoint, task: &LiftTask) -> Self {
        let lift = assess_lift(origin, destination, task, &[]);
        let free = |l: &super::LiftLimit| {
            let once = super::LiftMultipliers { frequency: 1.0, ..l.multipliers };
            super::LOAD_CONSTANT_KG * once.product()
        };
        let mut limit = free(&lift.origin);
        if task.control_at_destination {
            limit = limit.min(free(&lift.destination));
        }
        Self {
            load_kg: task.load_kg,
            frequency_free_limit_kg: limit,
            lifts_per_min: task.lifts_per_min,
            begins_high: origin.vertical_cm >= 75.0,
        }
    }
}

/// One task in the order of the composite index.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompositeStep {
    /// Index of the task as it was given.
    pub task: usize,
    /// `FIRWL`, kg.
    pub frequency_free_limit_kg: f64,
    /// `STRWL`, kg.
    pub limit_kg: f64,
    /// `FILI`; none where the limit is 0.
    pub frequency_free_index: Option<f64>,
    /// `STLI`; none where the limit is 0.
    pub index: Option<f64>,
    /// Lifts a minute of this task and of those before it.
    pub lifts_per_min: f64,
    /// What the task adds to the index; none where a limit is 0.
    pub adds: Option<f64>,
}

/// Several tasks that alternate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompositeLift {
    /// The tasks, the most stressful first.
    pub steps: Vec<CompositeStep>,
    /// `CLI`; none where a limit is 0: no load is acceptable.
    pub index: Option<f64>,
}

/// The composite index of tasks that alternate within each quarter of an hour.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::{LiftDuration, LiftShare, composite_lift};
/// let one = LiftShare {
///     load_kg: 10.0,
///     frequency_free_limit_kg: 20.0,
///     lifts_per_min: 1.0,
///     begins_high: true,
/// };
/// // The same task in two parts is the same job: 0.5 / FM(2 lifts a minute).
/// let job = composite_lift(&[one, one], LiftDuration::Short);
/// assert!((job.index.unwrap() - 0.5 / 0.91).abs() < 1e-12);
/// ```
pub fn composite_lift(tasks: &[LiftShare], duration: LiftDuration) -> CompositeLift {
    let multiplier = |per_min: f64, high: bool| frequency_multiplier(per_min, duration, high);
    let own =
        |t: &LiftShare| t.frequency_free_limit_kg * multiplier(t.lifts_per_min, t.begins_high);
    let mut order: Vec<usize> = (0..tasks.len()).collect();
    // Without a limit a task is the most stressful of all.
    let stress = |t: &LiftShare| index(t.load_kg, own(t)).unwrap_or(f64::INFINITY);
    order.sort_by(|a, b| {
        let (a, b) = (&tasks[*a], &tasks[*b]);
        stress(b).total_cmp(&stress(a)).then(b.lifts_per_min.total_cmp(&a.lifts_per_min))
    });
    let (mut sum, mut high, mut before) = (0.0, true, None);
    let mut steps = Vec::with_capacity(tasks.len());
    for k in order {
        let t = &tasks[k];
        sum += t.lifts_per_min;
        high &= t.begins_high;
        let so_far = Some(multiplier(sum, high)).filter(|m| *m > 0.0);
        let free = index(t.load_kg, t.frequency_free_limit_kg);
        let single = index(t.load_kg, own(t));
        let adds = if steps.is_empty() {
            single
        } else {
            let rise = so_far.zip(before).map(|(now, then): (f64, f64)| 1.0 / now - 1.0 / then);
            free.zip(rise).map(|(free, rise)| free * rise)
        };
        before = so_far;
        steps.push(CompositeStep {
            task: k,
            frequency_free_limit_kg: t.frequency_free_limit_kg,
            limit_kg: own(t),
            frequency_free_index: free,
            index: single,
            lifts_per_min: sum,
            adds,
        });
    }
    let total: Option<f64> = steps.iter().map(|s| s.adds).sum();
    CompositeLift { index: total.filter(|_| !steps.is_empty()), steps }
}

#[cfg(test)]
mod tests {
    use super::super::{LOAD_CONSTANT_KG, LiftCoupling};
    use super::*;
    use approx::assert_relative_eq;

    fn share(load: f64, limit: f64, per_min: f64) -> LiftShare {
        LiftShare {
            load_kg: load,
            frequency_free_limit_kg: limit,
            lifts_per_min: per_min,
            begins_high: true,
        }
    }

    /// Applications Manual, section 2.4, the hypothetical job of three tasks: loads 30, 20 and 10 lb at 1, 2 and
    /// 4 lifts a minute for less than an hour, FIRWL 20, 20 and 15 lb. Printed: STRWL 18.8, 18.2, 12.6; FILI
    /// 1.5, 1.0, .67; STLI 1.6, 1.1, .8; CLI = 1.60 + 1.0 (1/.88 - 1/.94) + .67 (1/.70 - 1/.88) =
    /// 1.60 + .07 + .20 = 1.9. The numbers are recalled, not read; they agree with each other and with table 5.
    #[test]
    fn the_three_tasks_of_the_manual() {
        let lb = LOAD_CONSTANT_KG / 51.0;
        let tasks = [
            share(30.0 * lb, 20.0 * lb, 1.0),
            share(20.0 * lb, 20.0 * lb, 2.0),
            share(10.0 * lb, 15.0 * lb, 4.0),
        ];
        let job = composite_lift(&tasks, LiftDuration::Short);
        let of = |f: fn(&CompositeStep) -> f64| -> Vec<f64> { job.steps.iter().map(f).collect() };
        assert_eq!(job.steps.iter().map(|s| s.task).collect::<Vec<_>>(), [0, 1, 2]);
        let near = |ours: Vec<f64>, printed: [f64; 3], within: f64| {
            for (a, b) in ours.iter().zip(printed) {
                assert!((a - b).abs() < within, "{ours:?} {printed:?}");
            }
        };
        near(of(|s| s.limit_kg / (LOAD_CONSTANT_KG / 51.0)), [18.8, 18.2, 12.6], 0.05);
        near(of(|s| s.frequency_free_index.unwrap()), [1.5, 1.0, 0.67], 0.005);
        near(of(|s| s.index.unwrap()), [1.6, 1.1, 0.8], 0.05);
        near(of(|s| s.adds.unwrap()), [1.6, 0.07, 0.2], 0.0065);
        near(of(|s| s.lifts_per_min), [1.0, 3.0, 7.0], 1e-12);
        assert_eq!((job.index.unwrap() * 10.0).round() / 10.0, 1.9);
    }

    #[test]
    fn in_any_order_and_in_any_parts_it_is_the_same_job() {
        let tasks = [share(6.0, 14.0, 2.0), share(9.0, 10.0, 1.0), share(3.0, 20.0, 4.0)];
        let mut turned = tasks;
        turned.reverse();
        let index = |tasks: &[LiftShare]| composite_lift(tasks, LiftDuration::Long).index.unwrap();
        assert_relative_eq!(index(&tasks), index(&turned), epsilon = 1e-12);
        // Never below the worst task alone, never above all tasks as hard as the hardest.
        let worst = composite_lift(&tasks, LiftDuration::Long).steps[0].index.unwrap();
        let hardest = 9.0 / 10.0 / frequency_multiplier(7.0, LiftDuration::Long, true);
        assert!(worst < index(&tasks) && index(&tasks) < hardest);
        // One task is its own single index.
        let one = composite_lift(&tasks[..1], LiftDuration::Long);
        assert_eq!(one.index, one.steps[0].index);
        assert_eq!(composite_lift(&[], LiftDuration::Long).index, None);
    }

    #[test]
    fn ties_go_to_the_more_frequent_and_low_hands_make_the_sum_low() {
        let low = LiftShare { begins_high: false, ..share(4.0, 20.0, 7.0) };
        let tasks = [share(10.0, 20.0, 0.1), share(10.0, 20.0, 0.2), low];
        let job = composite_lift(&tasks, LiftDuration::Long);
        // 4 / (20 x 0.22) is 0.91, above 10 / (20 x 0.85).
        assert_eq!(job.steps.iter().map(|s| s.task).collect::<Vec<_>>(), [2, 1, 0]);
        assert!(job.index.is_some());
        // 9 lifts a minute for 8 h: table 5 ends at 8 for low hands.
        let often = [low, share(1.0, 20.0, 2.0)];
        assert_eq!(composite_lift(&often, LiftDuration::Long).index, None);
        let high = [LiftShare { begins_high: true, ..low }, often[1]];
        assert!(composite_lift(&high, LiftDuration::Long).index.is_some());
        // Out of reach: no load is acceptable, and it stands first.
        let none = composite_lift(&[often[1], share(1.0, 0.0, 1.0)], LiftDuration::Long);
        assert_eq!((none.index, none.steps[0].task), (None, 1));
    }

    #[test]
    fn the_limit_without_frequency_is_that_of_one_rare_lift() {
        let point = |h, v| LiftPoint { horizontal_cm: h, vertical_cm: v, asymmetry_deg: 30.0 };
        let task = |per_min| LiftTask {
            load_kg: 8.0,
            lifts_per_min: per_min,
            duration: LiftDuration::Short,
            coupling: LiftCoupling::Fair,
            control_at_destination: true,
        };
        let (from, to) = (point(40.0, 30.0), point(55.0, 110.0));
        let share = LiftShare::of(from, to, &task(5.0));
        let rare = assess_lift(from, to, &task(0.2), &[]);
        assert_relative_eq!(share.frequency_free_limit_kg, rare.recommended_kg, epsilon = 1e-12);
        let often = assess_lift(from, to, &task(5.0), &[]);
        let job = composite_lift(&[share], LiftDuration::Short);
        assert_relative_eq!(job.index.unwrap(), often.lifting_index.unwrap(), epsilon = 1e-12);
        // Beyond table 5 there is still a limit for one lift.
        assert!(LiftShare::of(from, to, &task(40.0)).frequency_free_limit_kg > 0.0);
    }
}

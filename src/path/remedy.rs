//! The smallest changes that would make an infeasible task feasible, one kind at a time.
//!
//! Multipliers alone cannot tell: their size depends on the units of the rows. Each kind of change is
//! therefore tried by solving: how much more time, how much more speed, by how much one obstacle, the
//! corridor or a reach would have to give way, everything else as it is.

use super::bounds::{outside, shortest_turn_s};
use super::change::Change;
use super::limits::PathLimits;
use super::nearest::{Elastic, Question, solve_within};
use super::project::{Projection, ProjectionSettings, alone, project_within, sampled};
use super::refusal::Cause;
use super::scene::Scene;
use super::verify::Quantity;
use crate::trajectory::TimedPath;

/// Factors beyond this are no advice.
const LARGEST_FACTOR: f64 = 32.0;
/// Relative accuracy of a factor.
const ACCURACY: f64 = 2e-3;

/// The smallest change of each kind that would make a path near `reference` feasible, alone. Empty
/// when the path is feasible already, the input is malformed, or no single change is enough. Takes
/// some dozens of solves.
pub fn smallest_changes(
    reference: &TimedPath,
    limits: &PathLimits,
    scene: &Scene,
    settings: &ProjectionSettings,
) -> Vec<Change> {
    let projection = project_within(reference, limits, scene, settings);
    let Projection::Infeasible { why, changes } = projection else { return Vec::new() };
    let cause = why.cause();
    let (positions, start, goal) = sampled_or_empty(reference, settings, cause);
    // Start and goal themselves, or nothing to search with: what is known is exact.
    if positions.is_empty() || outside(&start, &goal, limits).is_some() || is_exact(&changes) {
        return changes;
    }
    let duration = reference.duration_s();
    let is_enough = |limits: &PathLimits, duration: f64| {
        let step_s = duration / settings.steps as f64;
        let reference = &positions;
        shortest_turn_s(&start, &goal, limits) <= duration
            && solve_within(&Question { reference, step_s, limits, scene, settings, relaxed: None })
                .is_ok()
    };
    let mut found = Vec::new();
    if let Some(factor) = least_factor(|f| is_enough(limits, duration * f)) {
        found.push(Change::Duration { from_s: duration, to_s: duration * factor });
    }
    for (of, from, set) in raised(limits) {
        if let Some(factor) = least_factor(|f| is_enough(&set(from * f), duration)) {
            found.push(Change::Limit { of, from, to: from * factor });
        }
    }
    let step_s = duration / settings.steps as f64;
    let question =
        Question { reference: &positions, step_s, limits, scene, settings, relaxed: None };
    let elastic = (0..scene.obstacles.len())
        .map(Elastic::Obstacle)
        .chain(limits.corridor_m.map(|_| Elastic::Corridor))
        .chain((0..scene.reaches.len()).map(Elastic::Reach));
    if [Cause::Obstacle, Cause::Corridor, Cause::Reach].contains(&cause) {
        found.extend(elastic.filter_map(|of| alone(&question, of)));
    }
    found
}

fn sampled_or_empty(
    reference: &TimedPath,
    settings: &ProjectionSettings,
    cause: Cause,
) -> (Vec<crate::math::Vec3>, crate::math::Pose, crate::math::Pose) {
    if cause == Cause::Input {
        let nowhere = crate::math::Pose::identity();
        return (Vec::new(), nowhere, nowhere);
    }
    sampled(reference, settings.steps)
}

/// Whether an end itself is at fault.
fn is_exact(changes: &[Change]) -> bool {
    changes.iter().any(|c| matches!(c, Change::MoveEnd { .. }))
}

type Raised<'a> = (Quantity, f64, Box<dyn Fn(f64) -> PathLimits + 'a>);

/// The limits that may be raised: of what, value, and the limits with another value.
fn raised(limits: &PathLimits) -> Vec<Raised<'_>> {
    let l = *limits;
    vec![
        (Quantity::Speed, l.speed_m_s, Box::new(move |v| PathLimits { speed_m_s: v, ..l })),
        (
            Quantity::Acceleration,
            l.acceleration_m_s2,
            Box::new(move |v| PathLimits { acceleration_m_s2: v, ..l }),
        ),
        (Quantity::Jerk, l.jerk_m_s3, Box::new(move |v| PathLimits { jerk_m_s3: v, ..l })),
        (
            Quantity::AngularSpeed,
            l.angular_speed_rad_s,
            Box::new(move |v| PathLimits { angular_speed_rad_s: v, ..l }),
        ),
        (
            Quantity::AngularAcceleration,
            l.angular_acceleration_rad_s2,
            Box::new(move |v| PathLimits { angular_acceleration_rad_s2: v, ..l }),
        ),
    ]
}

/// The least factor above 1 that is enough, a hair upward; none when even the largest is not.
fn least_factor(is_enough: impl Fn(f64) -> bool) -> Option<f64> {
    if !is_enough(LARGEST_FACTOR) {
        return None;
    }
    // In strides first: small factors are likely.
    let (mut low, mut high, mut stride) = (1.0, LARGEST_FACTOR, 1.1f64);
    while low * stride < high {
        if is_enough(low * stride) {
            high = low * stride;
            break;
        }
        low *= stride;
        stride = stride.powf(1.5);
    }
    while high > low * (1.0 + ACCURACY) {
        let middle = (low * high).sqrt();
        if is_enough(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

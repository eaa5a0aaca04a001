//! Reasons against a move that are exact and need no solver: start or goal outside the box, too
//! little time for the turn, too little time for the straight path.
//!
//! Straight rest-to-rest way `L` under speed `v`, acceleration `a` and jerk `j`: rising from rest to
//! a speed `u` takes `a/j + u/a` (or `2 sqrt(u/j)` if `a` is not reached) and covers half of `u`
//! times that; the rest of the way is covered at `v`.

use super::change::Change;
use super::hull::TOLERANCE;
use super::limits::{Box3, PathLimits};
use super::project::{Projection, infeasible};
use super::refusal::{End, NoPath};
use super::scene::Scene;
use crate::math::pose::rotation_between;
use crate::math::{Pose, Vec3};
use crate::trajectory::{MINIMUM_JERK_PEAK_ACCELERATION, MINIMUM_JERK_PEAK_SPEED};

/// The questions that need no solver.
pub(super) fn refuse_at_once(
    start: &Pose,
    goal: &Pose,
    duration: f64,
    limits: &PathLimits,
    scene: &Scene,
) -> Option<Projection> {
    if let Some(why) = outside(start, goal, limits) {
        return Some(infeasible(why, into_the_box(start, goal, limits)));
    }
    for (end, pose) in [(End::Start, start), (End::Goal, goal)] {
        if let Some(refusal) = misplaced(end, &pose.translation.vector, scene) {
            return Some(refusal);
        }
    }
    let turn = shortest_turn_s(start, goal, limits);
    if turn > duration * (1.0 + TOLERANCE) {
        let why = NoPath::TooShortToTurn {
            duration_s: duration,
            needed_s: turn,
            angle_rad: rotation_between(&start.rotation, &goal.rotation).norm(),
            angular_speed_rad_s: limits.angular_speed_rad_s,
            angular_acceleration_rad_s2: limits.angular_acceleration_rad_s2,
        };
        let change = Change::Duration { from_s: duration, to_s: turn };
        return Some(infeasible(why, vec![change]));
    }
    let straight = shortest_straight_s(start, goal, limits);
    (straight > duration).then(|| too_short(start, goal, duration, limits, straight))
}

/// A start or goal in an obstacle or out of reach.
fn misplaced(end: End, at: &Vec3, scene: &Scene) -> Option<Projection> {
    for (name, obstacle) in scene.obstacles {
        let (distance, normal) = obstacle.surface(at);
        if distance < 0.0 {
            let (obstacle, depth_m) = (name.clone(), -distance);
            let why = NoPath::InsideObstacle { end, obstacle, depth_m };
            let moved = Change::MoveEnd { end, by_m: depth_m, to_m: at - normal * distance };
            let smaller = Change::ShrinkObstacle { name: name.clone(), by_m: depth_m };
            return Some(infeasible(why, vec![moved, smaller]));
        }
    }
    for reach in scene.reaches {
        let way = at - reach.center;
        let by_m = way.norm() - reach.radius_m;
        if by_m > 0.0 {
            let why = NoPath::BeyondReach { end, body: reach.body.clone(), by_m };
            let moved = Change::MoveEnd { end, by_m, to_m: at - way.normalize() * by_m };
            let nearer = Change::ExtendReach { body: reach.body.clone(), by_m };
            return Some(infeasible(why, vec![moved, nearer]));
        }
    }
    None
}

/// The end that is outside moved to the nearest point of the box, or the faces moved to it.
fn into_the_box(start: &Pose, goal: &Pose, limits: &PathLimits) -> Vec<Change> {
    let Some(inner) = &limits.workspace else { return Vec::new() };
    let mut changes = Vec::new();
    let mut crossed = 0;
    for (end, pose) in [(End::Start, start), (End::Goal, goal)] {
        let at = pose.translation.vector;
        let to_m = Vec3::from_fn(|i, _| at[i].max(inner.min[i]).min(inner.max[i]));
        if to_m != at {
            crossed += 1;
            changes.push(Change::MoveEnd { end, by_m: (to_m - at).norm(), to_m });
        }
    }
    // Two ends outside: neither move is enough alone.
    if crossed > 1 {
        changes.clear();
    }
    let out = |face: &(usize, bool)| {
        let of = |pose: &Pose| inner.excess(&pose.translation.vector, face.0, face.1);
        of(start).max(of(goal))
    };
    let faces: Vec<_> = Box3::faces().filter(|f| out(f) > 0.0).collect();
    if let [face] = faces[..] {
        let by_m = out(&face);
        changes.push(Change::MoveFace { face: inner.face(face.0, face.1), by_m });
    }
    changes
}

/// The refusal for a duration below the `needed` one, s.
pub(super) fn too_short(
    start: &Pose,
    goal: &Pose,
    duration: f64,
    limits: &PathLimits,
    needed: f64,
) -> Projection {
    let why = NoPath::TooShort {
        duration_s: duration,
        needed_s: needed,
        distance_m: (goal.translation.vector - start.translation.vector).norm(),
        speed_m_s: limits.speed_m_s,
        acceleration_m_s2: limits.acceleration_m_s2,
        jerk_m_s3: limits.jerk_m_s3,
    };
    infeasible(why, vec![Change::Duration { from_s: duration, to_s: needed }])
}

/// The refusal of a start or goal outside the box.
pub(super) fn outside(start: &Pose, goal: &Pose, limits: &PathLimits) -> Option<NoPath> {
    let inner = limits.workspace.as_ref()?;
    let find = |end: End, pose: &Pose| {
        let p = pose.translation.vector;
        let (axis, is_upper) =
            Box3::faces().find(|(axis, up)| inner.excess(&p, *axis, *up) > 0.0)?;
        Some(NoPath::OutsideBox { end, face: inner.face(axis, is_upper), at_m: p[axis] })
    };
    find(End::Start, start).or_else(|| find(End::Goal, goal))
}

/// Shortest duration of the turn under the minimum-jerk law, s.
pub(super) fn shortest_turn_s(start: &Pose, goal: &Pose, limits: &PathLimits) -> f64 {
    let angle = rotation_between(&start.rotation, &goal.rotation).norm();
    let by_speed = MINIMUM_JERK_PEAK_SPEED * angle / limits.angular_speed_rad_s;
    let by_acceleration =
        (MINIMUM_JERK_PEAK_ACCELERATION * angle / limits.angular_acceleration_rad_s2).sqrt();
    by_speed.max(by_acceleration)
}

/// A duration (s) below which no rest-to-rest path from start to goal exists: the motion along the
/// straight line alone takes as long. The jerk box allows `j_max |e|_1` along a direction `e`.
pub(super) fn shortest_straight_s(start: &Pose, goal: &Pose, limits: &PathLimits) -> f64 {
    let way = goal.translation.vector - start.translation.vector;
    let distance = way.norm();
    if distance == 0.0 {
        return 0.0;
    }
    let (v, a) = (limits.speed_m_s, limits.acceleration_m_s2);
    let j = limits.jerk_m_s3 * way.abs().sum() / distance;
    // From rest to a speed u, reached at zero acceleration.
    let rise = |u: f64| if u * j >= a * a { a / j + u / a } else { 2.0 * (u / j).sqrt() };
    if distance >= v * rise(v) {
        return distance / v + rise(v);
    }
    // Up to the peak speed u with u rise(u) = distance, and down again.
    let ramp = a / j;
    let peak = a / 2.0 * ((ramp * ramp + 4.0 * distance / a).sqrt() - ramp);
    if peak * j >= a * a { 2.0 * rise(peak) } else { (32.0 * distance / j).cbrt() }
}

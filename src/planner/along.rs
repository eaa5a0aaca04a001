//! What a path is, seen from outside: where it bends, how the hand moves along it, how its timing
//! differs from that of another.

use super::result::{Bend, HandMotion, PathData, TimingDifference};
use crate::math::{Pose, Vec3};
use crate::trajectory::TimedPath;

/// Shares of time, and of the way, at which two paths are compared.
const PLACES: usize = 50;
/// Part of the greatest speed that a path may have at its ends and still count as at rest there.
const AT_REST: f64 = 0.25;

/// Where a path departs most from the straight line between its ends; `toward_body`: horizontal unit
/// vector to the worker.
pub(super) fn bend(poses: &[Pose], toward_body: &Vec3) -> Option<Bend> {
    let (first, last) = (poses.first()?.translation.vector, poses.last()?.translation.vector);
    let chord = last - first;
    let aside = |p: &Pose| {
        let from = p.translation.vector - first;
        let along =
            if chord.norm_squared() > 0.0 { from.dot(&chord) / chord.norm_squared() } else { 0.0 };
        from - chord * along.clamp(0.0, 1.0)
    };
    let most = poses.iter().map(aside).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let left = toward_body.cross(&Vec3::z());
    Some(Bend { toward_body_m: most.dot(toward_body), left_m: most.dot(&left), up_m: most.z })
}

/// How the hand moves: its positions (m) at equal steps `dt` (s).
pub(super) fn hand_motion(hand: &[Vec3], dt: f64) -> HandMotion {
    let velocity: Vec<Vec3> = hand.windows(2).map(|w| (w[1] - w[0]) / dt).collect();
    let speed_m_s = velocity.iter().map(Vec3::norm).fold(0.0, f64::max);
    let ends = [velocity.first(), velocity.last()].into_iter().flatten();
    let rests = ends.map(Vec3::norm).fold(0.0, f64::max) <= AT_REST * speed_m_s;
    let changes = velocity.windows(2).map(|w| (w[1] - w[0]).norm() / dt);
    HandMotion {
        travel_m: velocity.iter().map(|v| v.norm() * dt).sum(),
        speed_m_s,
        acceleration_m_s2: rests.then(|| changes.fold(0.0, f64::max)),
    }
}

/// A way with the share of it that is covered at each sample.
struct Progress {
    time: Vec<f64>,
    covered: Vec<f64>,
    points: Vec<Vec3>,
    /// s.
    duration: f64,
}

impl Progress {
    /// None for fewer than two samples.
    fn of(time_s: &[f64], points: Vec<Vec3>) -> Option<Self> {
        if points.len() < 2 || points.len() != time_s.len() {
            return None;
        }
        let mut covered = vec![0.0];
        for w in points.windows(2) {
            covered.push(covered.last()? + (w[1] - w[0]).norm());
        }
        let (whole, duration) = (*covered.last()?, time_s.last()? - time_s.first()?);
        let share = |x: f64, of: f64| if of > 0.0 { x / of } else { 0.0 };
        let time = time_s.iter().map(|t| share(t - time_s[0], duration)).collect();
        let covered = covered.into_iter().map(|c| share(c, whole)).collect();
        Some(Self { time, covered, points, duration })
    }

    /// Share of the way at a share of the time.
    fn at_time(&self, u: f64) -> f64 {
        let (i, part) = place(&self.time, u);
        self.covered[i] + part * (self.covered[i + 1] - self.covered[i])
    }

    /// Place at a share of the way.
    fn at_way(&self, s: f64) -> Vec3 {
        let (i, part) = place(&self.covered, s);
        self.points[i].lerp(&self.points[i + 1], part)
    }
}

/// The interval of a rising list in which a value lies, and how far into it.
fn place(rising: &[f64], at: f64) -> (usize, f64) {
    let high = rising.partition_point(|x| *x <= at).clamp(1, rising.len() - 1);
    let width = rising[high] - rising[high - 1];
    let part = if width > 0.0 { (at - rising[high - 1]) / width } else { 0.0 };
    (high - 1, part.clamp(0.0, 1.0))
}

/// How the timing of two paths differs; none for paths of fewer than two samples.
pub(super) fn timing_difference(a: &PathData, b: &PathData) -> Option<TimingDifference> {
    let of = |p: &PathData| {
        let points = p.tcp.iter().map(|t| Vec3::new(t[0], t[1], t[2])).collect();
        Progress::of(&p.time_s, points)
    };
    Some(between(&of(a)?, &of(b)?))
}

/// The same of paths that are not reported yet.
pub(super) fn timing_between(a: &TimedPath, b: &TimedPath) -> Option<TimingDifference> {
    let of = |p: &TimedPath| {
        Progress::of(&p.time_s, p.poses.iter().map(|x| x.translation.vector).collect())
    };
    Some(between(&of(a)?, &of(b)?))
}

fn between(a: &Progress, b: &Progress) -> TimingDifference {
    let shares = || (0..=PLACES).map(|i| i as f64 / PLACES as f64);
    TimingDifference {
        progress: shares().map(|u| (a.at_time(u) - b.at_time(u)).abs()).fold(0.0, f64::max),
        duration_ratio: a.duration / b.duration,
        route_apart_m: shares().map(|s| (a.at_way(s) - b.at_way(s)).norm()).fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::result::PathData;

    fn along(x: impl Fn(f64) -> Vec3, duration: f64) -> PathData {
        let time_s: Vec<f64> = (0..=100).map(|k| duration * f64::from(k) / 100.0).collect();
        let tcp =
            time_s.iter().map(|t| x(t / duration)).map(|p| [p.x, p.y, p.z, 1.0, 0.0, 0.0, 0.0]);
        PathData { tcp: tcp.collect(), time_s, ..PathData::default() }
    }

    fn ease(u: f64) -> f64 {
        u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
    }

    #[test]
    fn one_route_at_two_timings() {
        let bell = along(|u| Vec3::x() * ease(u), 4.0);
        let even = along(|u| Vec3::x() * u, 4.0);
        let slow = along(|u| Vec3::x() * ease(u), 8.0);
        let other = along(|u| Vec3::new(ease(u), 0.1 * (3.0 * ease(u)).sin(), 0.0), 4.0);
        let d = timing_difference(&bell, &even).unwrap();
        // The greatest distance between the minimum-jerk law and the constant speed.
        assert!((d.progress - 0.1467).abs() < 2e-3, "{}", d.progress);
        assert!(!d.is_same() && d.is_same_route());
        assert!(!timing_difference(&bell, &slow).unwrap().is_same());
        let d = timing_difference(&bell, &other).unwrap();
        assert!(d.is_same() && !d.is_same_route(), "{d:?}");
    }

    #[test]
    fn a_path_bends_where_it_is_farthest_from_the_line() {
        let arc: Vec<Pose> = (0..=20)
            .map(|k| {
                let u = f64::from(k) / 20.0;
                let aside = (std::f64::consts::PI * u).sin();
                Pose::translation(u, -0.08 * aside, 1.0 + 0.03 * aside)
            })
            .collect();
        // The worker stands at y < 0 and looks along +y: left is -x.
        let b = bend(&arc, &-Vec3::y()).unwrap();
        assert!((b.toward_body_m - 0.08).abs() < 1e-9 && (b.up_m - 0.03).abs() < 1e-9, "{b:?}");
        assert!(b.left_m.abs() < 1e-9);
        let sideways: Vec<Pose> =
            [0.0, -0.05, 0.0].iter().map(|x| Pose::translation(*x, 0.0, 1.0)).collect();
        assert!((bend(&sideways, &-Vec3::y()).unwrap().left_m - 0.05).abs() < 1e-9);
    }

    #[test]
    fn the_minimum_jerk_law_has_its_known_peaks() {
        let hand: Vec<Vec3> = (0..=1000).map(|k| Vec3::x() * ease(f64::from(k) / 1000.0)).collect();
        let m = hand_motion(&hand, 2.0 / 1000.0);
        assert!((m.travel_m - 1.0).abs() < 1e-9 && (m.speed_m_s - 1.875 / 2.0).abs() < 1e-4);
        assert!((m.acceleration_m_s2.unwrap() - 5.7735 / 4.0).abs() < 1e-2);
        let even: Vec<Vec3> = (0..=10).map(|k| Vec3::x() * f64::from(k)).collect();
        assert_eq!(hand_motion(&even, 1.0).acceleration_m_s2, None);
    }
}

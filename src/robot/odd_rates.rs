//! Velocities and accelerations in a trajectory's file that its own positions contradict.

use super::joint_trajectory::JointTrajectory;

/// How much faster than the mean pace beside a point a velocity may be, and the same of accelerations: a
/// spline overshoots by half.
const FASTER: f64 = 3.0;
/// What always may be, rad/s or m/s, and rad/s^2 or m/s^2: a sensor is noisy.
const SLACK: f64 = 0.1;
const SLACK_ACCELERATION: f64 = 1.0;

/// A velocity or an acceleration of a trajectory that the rest of it contradicts.
#[derive(Debug, Clone, PartialEq)]
pub struct OddRate {
    /// Index of the point.
    pub point: usize,
    /// The joint.
    pub joint: String,
    /// As given, rad/s or m/s, or these per second.
    pub given: f64,
    /// The nearest that the points before and after allow, in the same unit.
    pub moved: f64,
}

impl JointTrajectory {
    /// The first velocity that cannot belong to the positions: of another sign, or more than three
    /// times as fast as the positions move on both sides of the point. Rests at points are no
    /// contradiction.
    pub fn odd_velocity(&self) -> Option<OddRate> {
        let given = |k: usize, j: usize| self.points[k].velocities.get(j).copied();
        self.odd(given, |k, j| self.pace(k, j), SLACK)
    }

    /// The first acceleration that cannot belong to the velocities, or where the file has none to the
    /// positions, by the same rule.
    pub fn odd_acceleration(&self) -> Option<OddRate> {
        let given = |k: usize, j: usize| self.points[k].accelerations.get(j).copied();
        let speed = |k: usize, j: usize| {
            let own = self.points[k].velocities.get(j).copied();
            own.or_else(|| {
                let before = k.checked_sub(1).and_then(|k| self.pace(k, j));
                let [before, after] = [before, self.pace(k, j)];
                Some(0.5 * (before.or(after)? + after.or(before)?))
            })
        };
        let change = |k: usize, j: usize| {
            let step = self.step(k)?;
            Some((speed(k + 1, j)? - speed(k, j)?) / step)
        };
        self.odd(given, change, SLACK_ACCELERATION)
    }

    /// The first given value beyond what changes beside its point, with `slack`; `change` is from a point
    /// to the next.
    fn odd(
        &self,
        given: impl Fn(usize, usize) -> Option<f64>,
        change: impl Fn(usize, usize) -> Option<f64>,
        slack: f64,
    ) -> Option<OddRate> {
        for point in 0..self.points.len() {
            for (j, joint) in self.joint_names.iter().enumerate() {
                let Some(given) = given(point, j) else { continue };
                let before = point.checked_sub(1).and_then(|k| change(k, j));
                let after = change(point, j);
                let (Some(a), Some(b)) = (before.or(after), after.or(before)) else { continue };
                let (low, high) = (a.min(b).min(0.0), a.max(b).max(0.0));
                if !(FASTER * low - slack..=FASTER * high + slack).contains(&given) {
                    let moved = if given > 0.0 { high } else { low };
                    return Some(OddRate { point, joint: joint.clone(), given, moved });
                }
            }
        }
        None
    }

    /// Seconds from a point to the next.
    fn step(&self, k: usize) -> Option<f64> {
        let time = |k: usize| self.points.get(k).map(|p| p.time_from_start.seconds());
        Some(time(k + 1)? - time(k)?).filter(|step| *step > 0.0)
    }

    /// Mean velocity from a point to the next.
    fn pace(&self, k: usize, j: usize) -> Option<f64> {
        let at = |k: usize| self.points.get(k).and_then(|p| p.positions.get(j));
        Some((at(k + 1)? - at(k)?) / self.step(k)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Minimum jerk from 0 to 1 in 2 s.
    fn sampled(count: usize) -> JointTrajectory {
        let times: Vec<f64> = (0..=count).map(|k| 2.0 * k as f64 / count as f64).collect();
        let at = |t: f64| {
            let s = t / 2.0;
            vec![s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)]
        };
        let q: Vec<Vec<f64>> = times.iter().map(|t| at(*t)).collect();
        JointTrajectory::through(vec!["a".to_owned()], &times, &q)
    }

    #[test]
    fn velocities_that_are_not_those_of_the_positions_are_found() {
        let made = sampled(20);
        assert_eq!(made.odd_velocity(), None);
        // Resting at every point is a way to go, too.
        let mut rests = made.clone();
        rests.points.iter_mut().for_each(|p| p.velocities = vec![0.0]);
        assert_eq!(rests.odd_velocity(), None);
        for (factor, given) in [(-1.0, -0.9375), (10.0, 9.375)] {
            let mut odd = made.clone();
            odd.points[10].velocities[0] *= factor;
            let found = odd.odd_velocity().unwrap();
            assert_eq!((found.point, found.joint.as_str()), (10, "a"));
            assert_relative_eq!(found.given, given, epsilon = 1e-3);
            assert!(found.moved >= 0.0 && found.moved < 1.0, "{found:?}");
        }
    }

    #[test]
    fn accelerations_that_are_not_those_of_the_motion_are_found() {
        for count in [10, 20, 100] {
            assert_eq!(sampled(count).odd_acceleration(), None, "{count}");
        }
        let made = sampled(20);
        for (factor, has_velocities) in [(-2.0, true), (10.0, true), (-2.0, false), (10.0, false)] {
            let mut odd = made.clone();
            if !has_velocities {
                odd.points.iter_mut().for_each(|p| p.velocities.clear());
                assert_eq!(odd.odd_acceleration(), None);
            }
            odd.points[5].accelerations[0] *= factor;
            let found = odd.odd_acceleration().unwrap();
            assert_eq!((found.point, found.joint.as_str()), (5, "a"));
            assert_relative_eq!(found.given, factor * made.points[5].accelerations[0]);
            assert!(found.moved >= 0.0 && found.moved < 2.0, "{found:?}");
        }
    }
}

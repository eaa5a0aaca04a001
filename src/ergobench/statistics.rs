//! How somebody's joints move, in two figures that recordings give as well.

use crate::training::Trial;
use serde::Serialize;

/// Of joint velocities. The right arms of two recorded hand-overs have 3.2 and 25 deg/s, 3.0 and 18 deg/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// `(tr S)^2 / tr(S^2)` of the second moment S: in how many directions the joints move, from 1 to n.
    pub participation_rank: f64,
    /// Root mean square over joints and time, deg/s.
    pub joint_speed_deg_s: f64,
}

impl Statistics {
    /// Of the velocities of all trials.
    pub fn of(trials: &[Trial]) -> Self {
        let rows: Vec<&Vec<f64>> = trials.iter().flat_map(|t| &t.qdot).collect();
        let n = rows.first().map_or(0, |r| r.len());
        let moment = |i: usize, j: usize| {
            rows.iter().map(|r| r[i] * r[j]).sum::<f64>() / rows.len().max(1) as f64
        };
        let (mut trace, mut squares) = (0.0, 0.0);
        for i in 0..n {
            trace += moment(i, i);
            squares += (0..n).map(|j| moment(i, j).powi(2)).sum::<f64>();
        }
        Self {
            participation_rank: trace * trace / squares,
            joint_speed_deg_s: (trace / n as f64).sqrt().to_degrees(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_and_independent_directions_count_one_each() {
        let trial = |qdot: &[[f64; 3]]| Trial {
            stepping: Vec::new(),
            turn: Vec::new(),
            source: String::new(),
            rate_hz: 1.0,
            q: Vec::new(),
            qdot: qdot.iter().map(|r| r.to_vec()).collect(),
        };
        let two = [trial(&[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), trial(&[[0.0, 1.0, 1.0]; 1])];
        let s = Statistics::of(&two);
        // Second moment: 2/3 along x; 2/3 along (0, 1, 1)/sqrt 2.
        assert!((s.participation_rank - 2.0).abs() < 1e-12, "{}", s.participation_rank);
        let speed = (4.0f64 / 9.0).sqrt().to_degrees();
        assert!((s.joint_speed_deg_s - speed).abs() < 1e-9, "{}", s.joint_speed_deg_s);
    }
}

//! What is made small, from the figures of every rollout.

use super::apart::crowding;
use super::evaluate::Walks;
use super::preset::Objective;
use crate::ergonomics::{P_AT_LEAST_S, REBA_WORST, RULA_WORST};
use crate::math::stats::{cvar_upper, mean};
use crate::scenario::PersonMargin;
use crate::survey::Lens;

/// Figures of one body along one path, one entry for each rollout.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Time mean of RULA.
    pub rula: Vec<f64>,
    /// Time mean of REBA.
    pub reba: Vec<f64>,
    /// Share of time at RULA 5 or more.
    pub exposure_rula_5: Vec<f64>,
    /// 1 where RULA 5 or more lasts for at least half a second in total.
    pub level_3: Vec<f64>,
    /// 1 where the reach is exceeded.
    pub lost: Vec<f64>,
    /// Earliest time at which a reach was exceeded, s.
    pub lost_from_s: Option<f64>,
    /// Root mean square joint speed, rad/s.
    pub effort: Vec<f64>,
    /// Least distance to the robot, m, of the rollouts that were looked at.
    pub near_m: Vec<f64>,
    /// The least of these with link of the robot and body part there; not in a search.
    pub nearest: Option<(f64, [String; 2])>,
}

impl Figures {
    /// Of the rollouts of one body; after its reach is exceeded a rollout counts as the worst.
    pub(super) fn of(walks: &Walks, lens: &Lens) -> Self {
        let mut all = Self::default();
        for walk in &walks.all {
            let end = walk.rollout.reach_exceeded_at.unwrap_or(usize::MAX);
            let (mut rula, mut reba, mut high) = (0.0, 0.0, 0usize);
            for (k, angles) in walk.angles.iter().enumerate() {
                let (r, b) = if k >= end {
                    (RULA_WORST, REBA_WORST)
                } else {
                    let (r, b) = angles.score(lens);
                    (r.grand, b.total)
                };
                rula += f64::from(r);
                reba += f64::from(b);
                high += usize::from(r >= 5);
            }
            let count = walk.angles.len().max(1) as f64;
            all.rula.push(rula / count);
            all.reba.push(reba / count);
            all.exposure_rula_5.push(high as f64 / count);
            let lasts = high > 0 && high as f64 * walks.dt >= P_AT_LEAST_S - 1e-9;
            all.level_3.push(f64::from(u8::from(lasts)));
            if let Some(k) = walk.rollout.reach_exceeded_at {
                let at = k as f64 * walks.dt;
                all.lost_from_s = Some(all.lost_from_s.map_or(at, |t: f64| t.min(at)));
            }
            all.lost.push(f64::from(u8::from(walk.rollout.reach_exceeded_at.is_some())));
            all.effort.push(effort(&walk.rollout.q, walks.dt));
        }
        all
    }

    /// Appends further rollouts.
    pub(super) fn extend(&mut self, more: Self) {
        self.rula.extend(more.rula);
        self.reba.extend(more.reba);
        self.exposure_rula_5.extend(more.exposure_rula_5);
        self.level_3.extend(more.level_3);
        self.lost.extend(more.lost);
        self.lost_from_s = match (self.lost_from_s, more.lost_from_s) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        self.effort.extend(more.effort);
        self.near_m.extend(more.near_m);
        let both = self.nearest.take().into_iter().chain(more.nearest);
        self.nearest = both.min_by(|a, b| a.0.total_cmp(&b.0));
    }

    fn value(&self, o: &Objective, time: Option<f64>) -> f64 {
        // With a free duration the score-time over the cycle counts, never the time mean, which
        // dwelling at the good end would lower.
        let over_cycle = |score: f64| match time {
            Some(share) => 1.0 + (score - 1.0) * share,
            None => score,
        };
        o.expected_rula * over_cycle(mean(&self.rula))
            + o.expected_reba * over_cycle(mean(&self.reba))
            + o.cvar90_rula * over_cycle(cvar_upper(&self.rula, 0.1))
            + o.exposure_rula_5 * mean(&self.exposure_rula_5) * time.unwrap_or(1.0)
            + o.p_level_3 * mean(&self.level_3)
            + o.effort * mean(&self.effort)
    }
}

/// Root mean square joint speed, rad/s.
fn effort(q: &[nalgebra::DVector<f64>], dt: f64) -> f64 {
    let squares = q.windows(2).map(|w| (&w[1] - &w[0]).norm_squared()).sum::<f64>();
    let count = q.first().map_or(1, nalgebra::Matrix::len) * q.len().saturating_sub(1).max(1);
    (squares / count as f64).sqrt() / dt
}

/// What else enters, of the path itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathTerms {
    /// Duration over the scenario's; none when it is not free.
    pub time_share: Option<f64>,
    /// Smallest clearance of the robot, m.
    pub clearance_m: Option<f64>,
    /// The margin between robot and person, in a search; the selection refuses instead.
    pub person: Option<PersonMargin>,
}

/// The objective for the worst body.
pub(super) fn objective(o: &Objective, bodies: &[Figures], path: PathTerms) -> f64 {
    let short = o.clearance_wanted_m - path.clearance_m.unwrap_or(f64::INFINITY);
    let terms = o.duration * path.time_share.unwrap_or(1.0)
        + if o.clearance > 0.0 {
            o.clearance * (short / o.clearance_wanted_m).max(0.0)
        } else {
            0.0
        };
    let worst =
        bodies.iter().map(|b| b.value(o, path.time_share)).fold(f64::NEG_INFINITY, f64::max);
    let crowded = path
        .person
        .map_or(0.0, |margin| bodies.iter().map(|b| crowding(b, &margin)).fold(0.0, f64::max));
    worst + terms + crowded
}

//! Time and probability at every action level, with its words.

use super::exposure::ScoreDistribution;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// One action level in the distribution of a score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ActionLevelShare {
    /// The level: RULA 1-4, REBA 0-4.
    pub level: u8,
    /// Lowest score of the level.
    pub from_score: u8,
    /// Highest score of the level.
    pub to_score: u8,
    /// What it asks for.
    pub words: Cow<'static, str>,
    /// Share of the time at exactly this level, mean over rollouts; the levels add up to 1.
    pub share: f64,
    /// Share of the time at this level or above, mean over rollouts.
    pub exposure: f64,
    /// Monte Carlo standard error of `exposure` over rollouts; `None` for a single rollout.
    pub exposure_se: Option<f64>,
    /// Share of rollouts at this level or above for at least the duration that the distribution was
    /// made with (usually [`super::P_AT_LEAST_S`]).
    pub p_at_least: f64,
    /// Monte Carlo standard error of `p_at_least`; see [`ScoreDistribution::p_at_least_se`].
    pub p_at_least_se: Option<f64>,
    /// Share of the time at this level or above in each rollout, in order; empty where it was not kept, and for
    /// the lowest level, at which all of the time is spent or above it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_rollout: Vec<f64>,
}

/// A distribution by the action levels of a method: RULA 1-4 (1993 paper, p. 96), REBA 0-4 (2000 paper).
pub(super) fn levels(
    scores: &ScoreDistribution,
    worst: u8,
    level_of: impl Fn(u8) -> u8,
    words: impl Fn(u8) -> &'static str,
) -> Vec<ActionLevelShare> {
    // Scores start at 1 in both methods.
    (level_of(1)..=level_of(worst))
        .filter_map(|level| {
            let mut of_level = (1..=worst).filter(|s| level_of(*s) == level);
            let from_score = of_level.next()?;
            let to_score = of_level.next_back().unwrap_or(from_score);
            let at = |list: &[f64], k: u8| list.get(usize::from(k)).copied();
            let error = |list: &Option<Vec<f64>>| at(list.as_ref()?, from_score);
            let exposure = at(&scores.exposure, from_score).unwrap_or(0.0);
            let above = at(&scores.exposure, to_score + 1).unwrap_or(0.0);
            Some(ActionLevelShare {
                level,
                from_score,
                to_score,
                words: words(level).into(),
                share: exposure - above,
                exposure,
                exposure_se: error(&scores.exposure_se),
                p_at_least: at(&scores.p_at_least, from_score).unwrap_or(0.0),
                p_at_least_se: error(&scores.p_at_least_se),
                by_rollout: Vec::new(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::ergonomics::{
        P_AT_LEAST_S, REBA_WORST, RULA_WORST, ScoringMethod, score_distribution,
    };
    use approx::assert_relative_eq;

    #[test]
    fn rula_levels_of_a_small_case() {
        let scores = vec![vec![2, 3, 5, 7], vec![1, 1, 6, 6]];
        let d = score_distribution(&scores, 0.5, RULA_WORST, P_AT_LEAST_S, None).unwrap();
        let levels = ScoringMethod::Rula.levels(&d);
        let bounds: Vec<_> = levels.iter().map(|l| (l.level, l.from_score, l.to_score)).collect();
        assert_eq!(bounds, [(1, 1, 2), (2, 3, 4), (3, 5, 6), (4, 7, 7)]);
        let shares: Vec<f64> = levels.iter().map(|l| l.share).collect();
        assert_eq!(shares, [3.0 / 8.0, 1.0 / 8.0, 3.0 / 8.0, 1.0 / 8.0]);
        let exposures: Vec<f64> = levels.iter().map(|l| l.exposure).collect();
        assert_eq!(exposures, [1.0, 5.0 / 8.0, 0.5, 1.0 / 8.0]);
        // Half of both rollouts are at level 3 or above: no spread; level 4 is in one of two.
        assert_eq!(levels[2].exposure_se, Some(0.0));
        assert_relative_eq!(levels[3].exposure_se.unwrap(), 1.0 / 8.0);
        assert_eq!((levels[3].p_at_least, levels[3].p_at_least_se), (0.5, Some(0.5)));
        assert!(levels[3].words.ends_with("now"));
    }

    #[test]
    fn reba_levels_cover_all_scores_once() {
        let scores = vec![(1..=15).collect::<Vec<u8>>()];
        let d = score_distribution(&scores, 0.1, REBA_WORST, P_AT_LEAST_S, None).unwrap();
        let levels = ScoringMethod::Reba.levels(&d);
        assert_eq!(levels.len(), 5);
        assert_relative_eq!(levels.iter().map(|l| l.share).sum::<f64>(), 1.0, epsilon = 1e-12);
        let counts: Vec<f64> = levels.iter().map(|l| (l.share * 15.0).round()).collect();
        assert_eq!(counts, [1.0, 2.0, 4.0, 3.0, 5.0]);
        assert_eq!((levels[0].exposure, levels[0].exposure_se), (1.0, None));
    }
}

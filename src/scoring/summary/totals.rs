//! Scores over time, and over rollouts with the worst score where the hand could not follow.

use super::spread::Weighted;
use super::{LevelShare, OverRollouts, OverTime, RolloutFigures, TrackMean};
use crate::ergonomics::{
    P_AT_LEAST_S, REBA_WORST, RULA_WORST, exposure_by_rollout, reba_action_level,
    reba_action_words, rula_action_level, rula_action_words, score_distribution,
};
use crate::scoring::{Frame, ScoredSide, ScoredTrack};

/// Every frame of all tracks with the time that it stands for.
pub(super) fn weighted(scored: &ScoredSide, of: impl Fn(&Frame) -> f64) -> Weighted {
    let pairs = scored
        .tracks
        .iter()
        .flat_map(|t| t.frames.iter().zip(&t.weights_s))
        .map(|(f, w)| (of(f), *w));
    Weighted::new(pairs.collect())
}

/// Mean over time, and over rollouts with the worst score where the hand could not follow.
pub(super) fn mean_score(scored: &ScoredSide, worst: u8, of: fn(&Frame) -> u8) -> f64 {
    if scored.tracks.iter().all(|t| t.exceeded == 0) {
        return weighted(scored, |f| f64::from(of(f))).mean();
    }
    let all = rollout_scores(scored, worst, of);
    let means = all.iter().map(|s| s.iter().map(|v| f64::from(*v)).sum::<f64>() / s.len() as f64);
    means.sum::<f64>() / all.len().max(1) as f64
}

pub(super) fn over_time(scored: &ScoredSide) -> OverTime {
    let figures =
        |of: fn(&Frame) -> u8, level: fn(u8) -> u8, words: fn(u8) -> &'static str, worst| {
            let all = weighted(scored, |f| f64::from(of(f)));
            let starts = level_starts(level, worst);
            let levels = starts.iter().map(|(number, from)| LevelShare {
                level: *number,
                from_score: *from,
                share: all.share(|v| level(v as u8) == *number),
                words: words(*number),
            });
            TrackMean {
                mean: all.mean(),
                p05: all.quantile(0.05),
                p50: all.quantile(0.5),
                p95: all.quantile(0.95),
                levels: levels.collect(),
            }
        };
    OverTime {
        rula: figures(|f| f.rula.grand, rula_action_level, rula_action_words, RULA_WORST),
        reba: figures(|f| f.reba.total, reba_action_level, reba_action_words, REBA_WORST),
    }
}

/// Each action level and its lowest score.
fn level_starts(level: fn(u8) -> u8, worst: u8) -> Vec<(u8, u8)> {
    let mut starts: Vec<(u8, u8)> = Vec::new();
    for score in 1..=worst {
        if starts.last().is_none_or(|(number, _)| *number != level(score)) {
            starts.push((level(score), score));
        }
    }
    starts
}

fn rollout_scores(scored: &ScoredSide, worst: u8, of: fn(&Frame) -> u8) -> Vec<Vec<u8>> {
    let one = |t: &ScoredTrack| {
        let reached = t.frames.iter().map(of);
        reached.chain(std::iter::repeat_n(worst, t.exceeded)).collect()
    };
    scored.tracks.iter().map(one).collect()
}

pub(super) fn over_rollouts(scored: &ScoredSide) -> Option<OverRollouts> {
    let frames = scored.tracks.iter().map(|t| t.frames.len()).sum::<usize>();
    let dt = scored.tracks.iter().map(|t| t.observed_s).sum::<f64>() / frames.max(1) as f64;
    let figures = |of: fn(&Frame) -> u8, level: fn(u8) -> u8, worst| -> Option<RolloutFigures> {
        let scores = rollout_scores(scored, worst, of);
        let distribution = score_distribution(&scores, dt, worst, P_AT_LEAST_S, None)?;
        let starts = level_starts(level, worst);
        let levels = starts.iter().map(|(number, from)| {
            let k = usize::from(*from);
            (*number, *from, distribution.exposure[k], distribution.p_at_least[k])
        });
        let shares = starts.iter().map(|(_, from)| exposure_by_rollout(&scores, *from));
        Some(RolloutFigures {
            levels: levels.collect(),
            levels_by_rollout: shares.collect(),
            by_rollout: scores
                .iter()
                .map(|s| s.iter().map(|v| f64::from(*v)).sum::<f64>() / s.len() as f64)
                .collect(),
            distribution,
        })
    };
    let exceeded = scored.tracks.iter().filter(|t| t.exceeded > 0).count();
    Some(OverRollouts {
        rula: figures(|f| f.rula.grand, rula_action_level, RULA_WORST)?,
        reba: figures(|f| f.reba.total, reba_action_level, REBA_WORST)?,
        reach_exceeded: exceeded as f64 / scored.tracks.len() as f64,
    })
}

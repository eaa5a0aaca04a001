//! Scores of a motion read back from their `summary.json`: what a shift needs of them.

use super::summary::SCORE_SCHEMA;
use crate::ergonomics::{PerMethod, ScoringMethod};
use crate::files::{InputError, Seal, read_text, take_seal};
use crate::human::Side;
use serde::Deserialize;
use std::path::Path;

const REMEDY: &str = "name the folder that `ergopath score MOTION -o DIR` has written";

/// A scored motion.
#[derive(Debug, Clone)]
pub struct StoredScore {
    /// File that was scored.
    pub source: String,
    /// Body.
    pub body: String,
    /// Mean duration of a trial or rollout, s.
    pub duration_s: f64,
    /// Whether it holds sampled postures rather than one motion.
    pub is_sampled: bool,
    /// The sides that were scored.
    pub sides: Vec<StoredSide>,
    /// Whether its file can say that nobody changed it.
    pub seal: Seal,
}

/// One side of it.
#[derive(Debug, Clone)]
pub struct StoredSide {
    /// Which.
    pub side: Side,
    /// By method and action level from the lowest: shares of time at the level or above, a value for each rollout, or
    /// one value for a motion.
    pub at_least: PerMethod<Vec<Vec<f64>>>,
}

#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

#[derive(Deserialize)]
struct ScoreFile {
    source: String,
    body: String,
    frames: usize,
    tracks: usize,
    observed_s: f64,
    sides: Vec<SideFile>,
}

#[derive(Deserialize)]
struct SideFile {
    side: Side,
    over_time: Option<PerMethod<TimeFile>>,
    over_rollouts: Option<PerMethod<RolloutFile>>,
}

#[derive(Deserialize)]
struct TimeFile {
    levels: Vec<LevelFile>,
}

#[derive(Deserialize)]
struct LevelFile {
    share: f64,
}

#[derive(Deserialize)]
struct RolloutFile {
    levels_by_rollout: Vec<Vec<f64>>,
}

/// Reads scores back from the folder of `ergopath score` or its `summary.json`.
///
/// # Errors
/// Where there are none, or not as this version writes them.
pub fn read_score(place: &Path) -> Result<StoredScore, InputError> {
    let path = if place.is_dir() { place.join("summary.json") } else { place.to_owned() };
    let text = read_text(&path)?;
    let broken = |e: &serde_json::Error| {
        InputError::new(&path, format!("is no summary of scores: {e}")).remedy(REMEDY)
    };
    let head: Head = serde_json::from_str(&text).map_err(|e| broken(&e))?;
    if head.schema.as_deref() != Some(SCORE_SCHEMA) {
        let found = head.schema.as_deref().unwrap_or("none");
        let message = format!("schema is `{found}`; this program reads `{SCORE_SCHEMA}`");
        return Err(InputError::new(&path, message).remedy(REMEDY));
    }
    let old = |e: &serde_json::Error| {
        let message = format!("is not as this version of ergopath writes it: {e}");
        InputError::new(&path, message).remedy("score the motion again with this program")
    };
    let file: ScoreFile = serde_json::from_str(&text).map_err(|e| old(&e))?;
    let mut value = serde_json::from_str(&text).map_err(|e| broken(&e))?;
    let seal = take_seal(&path, &mut value, "score the motion again")?;
    let is_sampled = file.sides.iter().any(|s| s.over_rollouts.is_some());
    let sides = file.sides.iter().filter_map(|s| {
        let over_rollouts = s.over_rollouts.as_ref();
        let at_least = match (over_rollouts, &s.over_time) {
            (Some(rollouts), _) => PerMethod::of(|m| rollouts[m].levels_by_rollout.clone()),
            (None, Some(time)) => PerMethod::of(|m| at_least(&time[m].levels)),
            (None, None) => return None,
        };
        Some(StoredSide { side: s.side, at_least })
    });
    // Each frame counts with a whole step in the observed time, which is one step more than a track lasts.
    let (frames, tracks) = (file.frames as f64, file.tracks as f64);
    let duration_s = file.observed_s * (frames - tracks) / frames / tracks;
    let score = StoredScore {
        source: file.source,
        body: file.body,
        duration_s,
        is_sampled,
        sides: sides.collect(),
        seal,
    };
    let is_whole = |s: &StoredSide| {
        ScoringMethod::ALL.into_iter().all(|m| {
            let levels = &s.at_least[m];
            let count = levels.first().map_or(0, Vec::len);
            let is_share = |v: &f64| (0.0..=1.0 + 1e-9).contains(v);
            levels.len() == usize::from(m.level(m.worst()) - m.level(1)) + 1
                && count > 0
                && levels.iter().all(|l| l.len() == count && l.iter().all(is_share))
        })
    };
    let lasts = score.duration_s.is_finite() && score.duration_s > 0.0;
    if !lasts || score.sides.is_empty() || !score.sides.iter().all(is_whole) {
        let message = "holds no scores over time that could be used";
        return Err(InputError::new(&path, message).remedy("score the motion again"));
    }
    Ok(score)
}

/// From the shares at each level those at it or above.
fn at_least(levels: &[LevelFile]) -> Vec<Vec<f64>> {
    let mut sum = 0.0;
    let mut all: Vec<Vec<f64>> = levels
        .iter()
        .rev()
        .map(|l| {
            sum += l.share;
            vec![f64::min(sum, 1.0)]
        })
        .collect();
    all.reverse();
    all
}

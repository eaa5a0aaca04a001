//! A scored motion in figures: over time for one movement, over rollouts for sampled postures.

mod spread;
mod totals;

use super::frames::{Frame, ScoredSide};
use super::motion::{Motion, MotionKind};
use super::parts::PARTS;
use super::setup::{Declared, Input, Use, inputs};
use super::standards::{OtherMethods, other_methods};
use super::views::{View, views};
use crate::ergonomics::{
    Profile, REBA_WORST, RULA_WORST, RebaStep, RulaStep, ScoreDistribution, Shown, TimeRules,
    drivers, reba_drivers,
};
use crate::human::Side;
use serde::Serialize;
use spread::shares;
use totals::{mean_score, over_rollouts, over_time, weighted};

/// Schema id of `summary.json`.
pub const SCORE_SCHEMA: &str = "ergopath/score/1";

/// `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Schema id.
    pub schema: &'static str,
    /// Version of the program.
    pub program_version: &'static str,
    /// File that was scored.
    pub source: String,
    /// Its SHA-256.
    pub sha256: String,
    /// What it holds.
    pub kind: MotionKind,
    /// Body.
    pub body: String,
    /// Frames in all tracks.
    pub frames: usize,
    /// Trials or rollouts.
    pub tracks: usize,
    /// Observed time of all tracks, s; gaps left out.
    pub observed_s: f64,
    /// Number of gaps.
    pub gaps: usize,
    /// The convention with all its thresholds.
    pub profile: Profile,
    /// The rules of time.
    pub time_rules: TimeRules,
    /// The sides that could be scored.
    pub sides: Vec<SideSummary>,
    /// What was done to the data and what looks suspicious.
    pub notes: Vec<String>,
}

/// One side.
#[derive(Debug, Clone, Serialize)]
pub struct SideSummary {
    /// Which.
    pub side: Side,
    /// Scores over time; of sampled postures `None`.
    pub over_time: Option<OverTime>,
    /// Scores over rollouts; of a single movement `None`.
    pub over_rollouts: Option<OverRollouts>,
    /// The same where muscle use is open and the answer is yes: mean RULA and REBA.
    pub if_muscle_use: Option<[f64; 2]>,
    /// Body parts.
    pub parts: Vec<PartSummary>,
    /// What drives RULA, strongest first.
    pub drivers: Vec<DriverShare>,
    /// What drives REBA, strongest first.
    pub reba_drivers: Vec<DriverShare>,
    /// What other methods say.
    pub other_methods: OtherMethods,
    /// Frames worth a look.
    pub views: Vec<View>,
    /// Muscle use and activity.
    pub muscle: Use,
    /// Every input with its origin.
    pub inputs: Vec<Input>,
}

/// One score over time.
#[derive(Debug, Clone, Serialize)]
pub struct TrackMean {
    /// Time-weighted mean. A mean of an ordinal score: it ranks, it does not measure.
    pub mean: f64,
    /// Time-weighted 5th percentile.
    pub p05: f64,
    /// Time-weighted median.
    pub p50: f64,
    /// Time-weighted 95th percentile.
    pub p95: f64,
    /// Time in each action level.
    pub levels: Vec<LevelShare>,
}

/// RULA and REBA over time.
#[derive(Debug, Clone, Serialize)]
pub struct OverTime {
    /// RULA.
    pub rula: TrackMean,
    /// REBA.
    pub reba: TrackMean,
}

/// Share of the time in an action level.
#[derive(Debug, Clone, Serialize)]
pub struct LevelShare {
    /// The level.
    pub level: u8,
    /// Lowest score of the level.
    pub from_score: u8,
    /// Share of the time, 0 to 1.
    pub share: f64,
    /// What the level asks for.
    pub words: &'static str,
}

/// One score over rollouts; the distribution as in a plan, and the same by action level.
#[derive(Debug, Clone, Serialize)]
pub struct RolloutFigures {
    /// Expected score, its standard error, band, `CVaR90`, exposure and P by score.
    #[serde(flatten)]
    pub distribution: ScoreDistribution,
    /// Level, lowest score, exposure at or above it, P(at or above it for 0.5 s in total).
    pub levels: Vec<(u8, u8, f64, f64)>,
    /// Time mean of each rollout, for paired comparisons.
    pub by_rollout: Vec<f64>,
    /// Of each entry of `levels` the share of time at or above it in each rollout.
    pub levels_by_rollout: Vec<Vec<f64>>,
}

/// RULA and REBA over rollouts.
#[derive(Debug, Clone, Serialize)]
pub struct OverRollouts {
    /// RULA.
    pub rula: RolloutFigures,
    /// REBA.
    pub reba: RolloutFigures,
    /// Share of rollouts in which the hand could not follow; they count as the worst score from there.
    pub reach_exceeded: f64,
}

/// One body part.
#[derive(Debug, Clone, Serialize)]
pub struct PartSummary {
    /// Name.
    pub part: &'static str,
    /// Its angles.
    pub angles: Vec<AngleSpread>,
    /// Share of the time at each step score of RULA, from the lowest.
    pub rula_steps: Vec<f64>,
    /// Share of the time at each step score of REBA, from the lowest.
    pub reba_steps: Vec<f64>,
    /// Whether the angles are those of the motion, not of a rule.
    pub is_measured: bool,
    /// Longest hold, s.
    pub longest_hold_s: f64,
    /// Holds of at least 10 s.
    pub holds: usize,
    /// Movements, away and back, in all tracks.
    pub movements: usize,
    /// Movements a minute, away and back.
    pub movements_per_min: f64,
    /// Whether it is held for longer than a minute.
    pub held: Shown,
    /// Whether it moves more than four times a minute.
    pub repeated: Shown,
}

/// One angle over time, deg.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct AngleSpread {
    /// Name.
    pub angle: &'static str,
    /// Time-weighted 10th percentile.
    pub p10: f64,
    /// Time-weighted median.
    pub p50: f64,
    /// Time-weighted 90th percentile.
    pub p90: f64,
    /// The value farthest from zero.
    pub peak: f64,
}

/// A step of RULA and what it does to the total.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct DriverShare {
    /// The step.
    pub step: &'static str,
    /// Its mean score.
    pub mean: f64,
    /// Mean drop of RULA if the step alone were at its lowest.
    pub drop: f64,
}

/// Sums up the scored sides of a motion.
pub fn summarise(
    motion: &Motion,
    scored: &[ScoredSide],
    declared: &Declared,
    profile: &Profile,
    rules: TimeRules,
) -> Summary {
    let side = |s: &ScoredSide| side_summary(motion, s, declared, profile);
    let first = scored.first();
    let tracks = || first.into_iter().flat_map(|s| &s.tracks);
    Summary {
        schema: SCORE_SCHEMA,
        program_version: env!("CARGO_PKG_VERSION"),
        source: motion.source.clone(),
        sha256: motion.sha256.clone(),
        kind: motion.kind,
        body: motion.body.clone(),
        frames: motion.frames(),
        tracks: motion.tracks.len(),
        observed_s: tracks().map(|t| t.observed_s).sum(),
        gaps: tracks().map(|t| t.gaps).sum(),
        profile: *profile,
        time_rules: rules,
        sides: scored.iter().map(side).collect(),
        notes: motion.notes.clone(),
    }
}

fn side_summary(
    motion: &Motion,
    scored: &ScoredSide,
    declared: &Declared,
    profile: &Profile,
) -> SideSummary {
    let is_sampled = motion.kind == MotionKind::Rollouts;
    let open = scored.muscle.is_open().then(|| with_muscle_use(scored, profile));
    SideSummary {
        side: scored.side,
        over_time: (!is_sampled).then(|| over_time(scored)),
        over_rollouts: if is_sampled { over_rollouts(scored) } else { None },
        if_muscle_use: open.map(|o| {
            [
                mean_score(&o, RULA_WORST, |f| f.rula.grand),
                mean_score(&o, REBA_WORST, |f| f.reba.total),
            ]
        }),
        parts: parts(scored),
        drivers: driver_shares(scored, profile),
        reba_drivers: reba_driver_shares(scored, profile),
        other_methods: other_methods(motion, scored, declared),
        views: views(scored),
        muscle: scored.muscle,
        inputs: inputs(motion, declared, scored.side, &scored.muscle, profile),
    }
}

/// The same side with a posture held for longer than a minute.
fn with_muscle_use(scored: &ScoredSide, profile: &Profile) -> ScoredSide {
    let mut other = scored.clone();
    other.task.static_gt_1min = true;
    other.task.load_static_or_repeated = true;
    for frame in other.tracks.iter_mut().flat_map(|t| &mut t.frames) {
        frame.enter(&other.task, profile);
    }
    other
}

fn parts(scored: &ScoredSide) -> Vec<PartSummary> {
    let observed: f64 = scored.tracks.iter().map(|t| t.observed_s).sum();
    PARTS
        .iter()
        .enumerate()
        .map(|(i, part)| {
            let times = || scored.tracks.iter().map(|t| &t.parts[i]);
            let spread = |a: &super::Angle| {
                let all = weighted(scored, a.of);
                AngleSpread {
                    angle: a.name,
                    p10: all.quantile(0.1),
                    p50: all.quantile(0.5),
                    p90: all.quantile(0.9),
                    peak: all.farthest(),
                }
            };
            let steps = |step: Option<super::parts::Step>| {
                step.map_or_else(Vec::new, |(of, most)| {
                    shares(&weighted(scored, |f| f64::from(of(f))), most)
                })
            };
            let longest = times().filter_map(|t| t.longest_hold).map(|h| h.duration_s());
            let movements: usize = times().map(|t| t.movements).sum();
            PartSummary {
                part: part.name,
                angles: part.angles.iter().map(spread).collect(),
                rula_steps: steps(part.rula),
                reba_steps: steps(part.reba),
                is_measured: scored.tracks.iter().any(|t| part.is_measured(&t.frames)),
                movements,
                longest_hold_s: longest.fold(0.0, f64::max),
                holds: times().map(|t| t.holds.len()).sum(),
                movements_per_min: movements as f64 * 60.0 / observed.max(f64::MIN_POSITIVE),
                held: most_telling(times().map(|t| t.held)),
                repeated: most_telling(times().map(|t| t.repeated)),
            }
        })
        .collect()
}

/// Yes if any track says so, too short if none does and one is.
fn most_telling(all: impl Iterator<Item = Shown>) -> Shown {
    all.fold(Shown::No, |sum, s| match (sum, s) {
        (Shown::Yes, _) | (_, Shown::Yes) => Shown::Yes,
        (Shown::TooShort, _) | (_, Shown::TooShort) => Shown::TooShort,
        _ => Shown::No,
    })
}

fn driver_shares(scored: &ScoredSide, profile: &Profile) -> Vec<DriverShare> {
    let names = RulaStep::ALL.map(RulaStep::name);
    shares_of(scored, names, |frame| {
        drivers(&frame.sheet, profile).map(|d| (d.step.value(&frame.rula), d.drop))
    })
}

fn reba_driver_shares(scored: &ScoredSide, profile: &Profile) -> Vec<DriverShare> {
    let names = RebaStep::ALL.map(RebaStep::name);
    shares_of(scored, names, |frame| {
        reba_drivers(&frame.sheet, profile).map(|d| (d.step.value(&frame.reba), d.drop))
    })
}

/// Time-weighted means of (step score, drop of the total) of each step, largest drop first.
fn shares_of<const N: usize>(
    scored: &ScoredSide,
    names: [&'static str; N],
    of: impl Fn(&Frame) -> [(u8, u8); N],
) -> Vec<DriverShare> {
    let mut sums = [[0.0f64; 2]; N];
    let mut total = 0.0;
    for track in &scored.tracks {
        for (frame, weight) in track.frames.iter().zip(&track.weights_s) {
            for (sum, (step, drop)) in sums.iter_mut().zip(of(frame)) {
                sum[0] += weight * f64::from(step);
                sum[1] += weight * f64::from(drop);
            }
            total += weight;
        }
    }
    let share = |(step, [mean, drop]): (&'static str, [f64; 2])| DriverShare {
        step,
        mean: mean / total,
        drop: drop / total,
    };
    let mut all: Vec<DriverShare> = names.into_iter().zip(sums).map(share).collect();
    all.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    all
}

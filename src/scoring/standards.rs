//! What other methods say of the same frames: LUBA, ISO 11226, EN 1005-4, the cumulative back angle,
//! and the lifting equation for a lift.

use super::frames::{ScoredSide, ScoredTrack};
use super::motion::{Motion, MotionKind};
use super::setup::Declared;
use crate::ergonomics::{
    BackExposure, EN_1005_4_PROVENANCE, ISO_11226_PROVENANCE, LUBA_PROVENANCE, LiftAssessment,
    LiftCondition, LiftCoupling, LiftDuration, LiftTask, LubaPosture, NIOSH_PROVENANCE, PartTimes,
    PostureUse, ZoneHold, ZoneSettings, assess_lift, back_exposure, en_1005_4, iso_11226,
    lift_from_path, luba, zone_times,
};
use crate::human::Side;
use serde::Serialize;

/// Lifts a minute and hours of lifting where nothing is given: seldom, all day.
const SELDOM_PER_MIN: f64 = 0.2;

/// The other methods for one side.
#[derive(Debug, Clone, Serialize)]
pub struct OtherMethods {
    /// LUBA.
    pub luba: LubaTimes,
    /// ISO 11226, part by part.
    pub iso_11226: Vec<PartTimes>,
    /// EN 1005-4, part by part, each by how often it leaves its acceptable zone.
    pub en_1005_4: Vec<PartTimes>,
    /// Whether the rates of EN 1005-4 are assumed to be 2 a minute or more.
    pub en_1005_4_rate_assumed: bool,
    /// The cumulative back angle.
    pub back: BackTimes,
    /// The lifting equation, on request.
    pub lift: Option<LiftAssessment>,
    /// What was checked against which source.
    pub provenance: Vec<&'static str>,
}

/// LUBA over time.
#[derive(Debug, Clone, Serialize)]
pub struct LubaTimes {
    /// Time-weighted mean of the postural load index.
    pub mean: f64,
    /// Largest index.
    pub largest: u8,
    /// Share of the time in categories 1 to 4.
    pub categories: [f64; 4],
}

/// The back over time, in both readings of "cumulative".
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BackTimes {
    /// Mean sum of the spine joints' rotation angles, deg.
    pub rotation_deg: f64,
    /// Mean sum of their flexion components, deg.
    pub flexion_deg: f64,
    /// Time integral of the trunk's inclination over a track and its mean; means over tracks.
    pub exposure: BackExposure,
}

/// What a lift needs besides the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiftAsked {
    /// Hours a day.
    pub hours: f64,
}

/// All other methods for a scored side.
pub(super) fn other_methods(
    motion: &Motion,
    scored: &ScoredSide,
    declared: &Declared,
) -> OtherMethods {
    let settings = ZoneSettings {
        trunk_supported: declared.trunk_supported,
        arm_supported: declared.arm_supported,
        ..ZoneSettings::default()
    };
    let iso = pooled(scored, |t| {
        let zones: Vec<_> =
            t.frames.iter().map(|f| iso_11226(&f.body, &f.arm, &settings)).collect();
        zone_times(&zones, step(t))
    });
    let en = |used: PostureUse| {
        pooled(scored, |t| {
            let zones: Vec<_> =
                t.frames.iter().map(|f| en_1005_4(&f.body, &f.arm, used, &settings)).collect();
            zone_times(&zones, step(t))
        })
    };
    let (seldom, often) = (en(PostureUse::Below2PerMin), en(PostureUse::From2PerMin));
    let rate = declared.cycles_per_min.or_else(|| cycles_per_min(scored));
    let en_1005_4 = seldom
        .into_iter()
        .zip(often)
        .map(|(seldom, often)| {
            let per_track = seldom.departures.div_ceil(scored.tracks.len().max(1));
            let used = PostureUse::of_movement(per_track, rate.unwrap_or(f64::NAN));
            if used == PostureUse::Below2PerMin { seldom } else { often }
        })
        .collect();
    OtherMethods {
        luba: luba_times(scored, declared),
        iso_11226: iso,
        en_1005_4,
        en_1005_4_rate_assumed: rate.is_none(),
        back: back_times(scored),
        lift: declared.lift.and_then(|asked| lift(motion, scored, declared, asked)),
        provenance: vec![
            LUBA_PROVENANCE,
            ISO_11226_PROVENANCE,
            EN_1005_4_PROVENANCE,
            NIOSH_PROVENANCE,
        ],
    }
}

/// Tracks a minute, where one track is long enough to stand for the work.
fn cycles_per_min(scored: &ScoredSide) -> Option<f64> {
    let observed: f64 = scored.tracks.iter().map(|t| t.observed_s).sum();
    let mean = observed / scored.tracks.len().max(1) as f64;
    (mean >= 60.0).then(|| 60.0 / mean)
}

/// Mean time that a frame stands for, s.
fn step(track: &ScoredTrack) -> f64 {
    track.observed_s / track.frames.len().max(1) as f64
}

/// Times of all tracks together: shares weighted by time, departures added up, the longest holds.
fn pooled(scored: &ScoredSide, of: impl Fn(&ScoredTrack) -> Vec<PartTimes>) -> Vec<PartTimes> {
    let mut all: Vec<PartTimes> = Vec::new();
    let mut observed = 0.0;
    for track in &scored.tracks {
        let more = of(track);
        let weight = track.observed_s;
        if all.is_empty() {
            all = more;
            observed = weight;
            continue;
        }
        let (old, new) = (observed / (observed + weight), weight / (observed + weight));
        for (a, b) in all.iter_mut().zip(more) {
            a.acceptable = a.acceptable * old + b.acceptable * new;
            a.up_to = a.up_to * old + b.up_to * new;
            a.conditional = a.conditional * old + b.conditional * new;
            a.not_recommended = a.not_recommended * old + b.not_recommended * new;
            a.departures += b.departures;
            a.longest = larger(a.longest, b.longest, |h| h.duration_s);
            a.most_used = larger(a.most_used, b.most_used, |h| h.duration_s / h.allowed_s);
        }
        observed += weight;
    }
    all
}

fn larger(
    a: Option<ZoneHold>,
    b: Option<ZoneHold>,
    of: impl Fn(&ZoneHold) -> f64,
) -> Option<ZoneHold> {
    [a, b].into_iter().flatten().max_by(|a, b| of(a).total_cmp(&of(b)))
}

fn luba_times(scored: &ScoredSide, declared: &Declared) -> LubaTimes {
    let posture = if declared.seated { LubaPosture::Sitting } else { LubaPosture::Standing };
    let mut times = LubaTimes { mean: 0.0, largest: 0, categories: [0.0; 4] };
    let mut total = 0.0;
    for track in &scored.tracks {
        for (frame, weight) in track.frames.iter().zip(&track.weights_s) {
            let score = luba(&frame.body, &frame.arm, posture);
            times.mean += weight * f64::from(score.index);
            times.largest = times.largest.max(score.index);
            times.categories[usize::from(score.category.clamp(1, 4)) - 1] += weight;
            total += weight;
        }
    }
    times.mean /= total;
    times.categories = times.categories.map(|c| c / total);
    times
}

fn back_times(scored: &ScoredSide) -> BackTimes {
    let (mut rotation, mut flexion, mut total) = (0.0, 0.0, 0.0);
    let (mut integral, mut mean) = (0.0, 0.0);
    for track in &scored.tracks {
        for (frame, weight) in track.frames.iter().zip(&track.weights_s) {
            rotation += weight * frame.back.rotation_deg;
            flexion += weight * frame.back.flexion_deg;
            total += weight;
        }
        let course: Vec<(f64, f64)> =
            track.frames.iter().map(|f| (f.time_s, f.body.trunk_flex_deg)).collect();
        let exposure = back_exposure(&course);
        integral += exposure.integral_deg_s;
        mean += exposure.mean_deg;
    }
    let count = scored.tracks.len().max(1) as f64;
    BackTimes {
        rotation_deg: rotation / total,
        flexion_deg: flexion / total,
        exposure: BackExposure { integral_deg_s: integral / count, mean_deg: mean / count },
    }
}

/// The lift of the first track, from its first to its last frame.
fn lift(
    motion: &Motion,
    scored: &ScoredSide,
    declared: &Declared,
    asked: LiftAsked,
) -> Option<LiftAssessment> {
    let track = scored.tracks.first()?;
    let first = track.frames.first()?;
    let times: Vec<f64> = track.frames.iter().map(|f| f.time_s).collect();
    let hands: Vec<_> = track.frames.iter().map(|f| f.hand_m).collect();
    let path = lift_from_path(&times, &hands, &first.ankles_m, &first.facing)?;
    let task = LiftTask {
        load_kg: declared.load_kg.unwrap_or(0.0),
        lifts_per_min: declared.cycles_per_min.unwrap_or(SELDOM_PER_MIN),
        duration: LiftDuration::from_hours(asked.hours)?,
        coupling: match declared.coupling.unwrap_or(0) {
            0 => LiftCoupling::Good,
            1 => LiftCoupling::Fair,
            _ => LiftCoupling::Poor,
        },
        control_at_destination: true,
    };
    let other = match scored.side {
        Side::Right => Side::Left,
        Side::Left => Side::Right,
    };
    let mut conditions: Vec<LiftCondition> = path.condition().into_iter().collect();
    if !motion.has_arm(other) {
        conditions.push(LiftCondition::OneHanded);
    }
    if declared.seated {
        conditions.push(LiftCondition::SeatedOrKneeling);
    }
    if motion.kind == MotionKind::Rollouts {
        conditions.push(LiftCondition::MechanicalHelp);
    }
    let mut found = assess_lift(path.origin, path.destination, &task, &conditions);
    found.notes.extend(path.note());
    Some(found)
}

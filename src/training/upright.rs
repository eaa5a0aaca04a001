//! How a recorded person stands upright: what the joint centres of a system show of straight legs and of a trunk
//! above the hips, seen where the person usually stands tallest on both feet.
//!
//! The skeletons of some systems have the knee ahead of the line from hip to ankle, so that everybody who stands looks
//! bent by 20 deg and more, the hips some centimetres ahead of the spine, so that a body with its hips there would
//! lean on its toes, and a pelvis that is never level. The legs of somebody who walks do not tell it: hips that are
//! off by centimetres are nearer to the ankle or farther from it with the angle of the hip, and a leg that swings
//! ahead looks straight.

use crate::human::Side;
use crate::math::{Vec3, stats};
use crate::recording::{Recording, SegmentTrack};
use nalgebra::UnitQuaternion;

/// A foot whose ball goes faster than this steps, m/s.
const STEPPING_M_S: f64 = 0.15;
/// Share of the frames in which hips are no farther from the ankles than where legs are straight.
const TALLEST: f64 = 0.98;
/// Shortest time on both feet that tells how somebody stands, s.
const LEAST_STANDING_S: f64 = 0.25;
/// Smallest distance from hip to ankle, over the length of the leg, that straight legs may look like: knees bent by
/// 32 deg.
const LEAST_UPRIGHT: f64 = 0.96;
/// Cosine of the angle from the vertical, 20 deg, up to which a thorax is that of somebody erect.
const ERECT: f64 = 0.94;
/// The same of 30 deg: a pelvis that looks inclined by more is not level.
const LEVEL: f64 = 0.866;
/// Farthest that hips may lie from the spine, leg lengths.
const FARTHEST_AHEAD: f64 = 0.15;

/// One leg of a recording.
pub(super) struct LegTracks<'a> {
    pub hip: &'a SegmentTrack,
    knee: &'a SegmentTrack,
    pub foot: &'a SegmentTrack,
    pub ball: Option<&'a SegmentTrack>,
}

impl<'a> LegTracks<'a> {
    pub(super) fn of(recording: &'a Recording, side: Side) -> Option<Self> {
        let track = |part: &str| recording.segment(&format!("{}{part}", side.prefix()));
        Some(Self {
            hip: track("UpperLeg")?,
            knee: track("LowerLeg")?,
            foot: track("Foot")?,
            ball: track("Toe"),
        })
    }

    /// Hip, knee and ankle.
    pub(super) fn points(&self, frame: usize) -> [Vec3; 3] {
        [self.hip, self.knee, self.foot].map(|t| t.position[frame])
    }

    /// Hip to knee to ankle, m.
    pub(super) fn length_m(&self, frame: usize) -> f64 {
        let [hip, knee, ankle] = self.points(frame);
        (knee - hip).norm() + (ankle - knee).norm()
    }

    /// Hip to ankle over the length of the leg.
    fn span(&self, frame: usize) -> f64 {
        let [hip, _, ankle] = self.points(frame);
        (hip - ankle).norm() / self.length_m(frame)
    }

    /// The same while the person is as tall as in any of these frames.
    fn tallest(&self, frames: impl IntoIterator<Item = usize>) -> f64 {
        stats::quantile(&frames.into_iter().map(|i| self.span(i)).collect::<Vec<_>>(), TALLEST)
    }

    /// Ball of the foot, or the ankle where it is not recorded.
    pub(super) fn stands_at(&self, frame: usize) -> Vec3 {
        self.ball.unwrap_or(self.foot).position[frame]
    }
}

/// Whether the ball of a foot moves at each frame.
pub(super) fn stepping(sides: [&LegTracks; 2], rate_hz: f64) -> Vec<bool> {
    let count = sides[0].foot.position.len();
    let moves = |i: usize| {
        sides.iter().any(|leg| {
            let way = leg.stands_at(i + 1) - leg.stands_at(i - 1);
            0.5 * way.norm() * rate_hz > STEPPING_M_S
        })
    };
    (0..count).map(|i| i > 0 && i + 1 < count && moves(i)).collect()
}

/// What joint centres look like where a person stands upright.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Upright {
    /// How far apart hip and ankle of the right and the left leg are where the knees are straight, over the length
    /// of the leg.
    spans: [f64; 2],
    /// What is up in the axes of the pelvis.
    up: [f64; 3],
    /// How far the hips lie ahead of the spine, leg lengths.
    pub hips_ahead: f64,
}

/// One recording in which somebody stands.
struct Standing<'a> {
    recording: &'a Recording,
    legs: [LegTracks<'a>; 2],
    /// Frames in which both feet do; none where it is for too short a time.
    frames: Vec<usize>,
}

impl<'a> Standing<'a> {
    fn of(recording: &'a Recording) -> Option<Self> {
        let of = |side| LegTracks::of(recording, side);
        let legs = [of(Side::Right)?, of(Side::Left)?];
        let steps = stepping(legs.each_ref(), recording.rate_hz);
        // Nothing tells of the first and the last frame whether a foot moves.
        let mut frames: Vec<usize> =
            (1..steps.len().saturating_sub(1)).filter(|i| !steps[*i]).collect();
        if (frames.len() as f64) < LEAST_STANDING_S * recording.rate_hz {
            frames.clear();
        }
        Some(Self { recording, legs, frames })
    }

    /// The frames in which somebody stands erect; none where that is for too short a time.
    fn erect(&self) -> Vec<usize> {
        let Some(thorax) = self.recording.segment("T8") else { return Vec::new() };
        let is_erect = |i: &usize| {
            let is_tall = self.legs.iter().all(|leg| leg.span(*i) >= LEAST_UPRIGHT);
            is_tall && (thorax.rotation[*i] * Vec3::y()).z >= ERECT
        };
        let mut erect: Vec<usize> = self.frames.iter().copied().filter(is_erect).collect();
        if (erect.len() as f64) < LEAST_STANDING_S * self.recording.rate_hz {
            erect.clear();
        }
        erect
    }

    /// The median over erect frames of something that has a value in each.
    fn usual<const N: usize>(&self, of: impl Fn(usize) -> [f64; N]) -> Option<[f64; N]> {
        let all: Vec<[f64; N]> = self.erect().into_iter().map(of).collect();
        median(&all, 1)
    }

    /// What is up in the axes of the pelvis.
    fn up(&self) -> Option<[f64; 3]> {
        let pelvis = self.recording.segment("Pelvis")?;
        self.usual(|i| (pelvis.rotation[i].inverse() * Vec3::z()).into())
    }

    /// How far the hips lie ahead of the spine, leg lengths, above a pelvis in whose axes this is up.
    fn hips_ahead(&self, pelvis_up: [f64; 3]) -> Option<[f64; 1]> {
        let (pelvis, thorax) = (self.recording.segment("Pelvis")?, self.recording.segment("T8")?);
        self.usual(|i| {
            let hips = 0.5 * (self.legs[0].points(i)[0] + self.legs[1].points(i)[0]);
            let spine = thorax.position[i] - hips;
            let level = pelvis.rotation[i] * to_up(pelvis_up);
            // The spine of a body goes up from between the hips, and bends from the one direction to the other.
            let expected = level * Vec3::y() + thorax.rotation[i] * Vec3::y();
            let off = expected.normalize() * spine.norm() - spine;
            let leg_m = 0.5 * (self.legs[0].length_m(i) + self.legs[1].length_m(i));
            [(level.inverse() * off).x / leg_m]
        })
    }
}

/// Each component's median; none of fewer than so many, or where one is not a number.
fn median<const N: usize>(all: &[[f64; N]], fewest: usize) -> Option<[f64; N]> {
    let column = |c: usize| all.iter().map(|v| v[c]).collect::<Vec<f64>>();
    let median: [f64; N] = std::array::from_fn(|c| stats::quantile(&column(c), 0.5));
    (all.len() >= fewest && median.iter().all(|v| v.is_finite())).then_some(median)
}

/// The smallest turn that takes the upward axis to another.
fn to_up(up: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vec3::y(), &up.into()).unwrap_or_default()
}

impl Upright {
    /// As the joint centres say.
    pub(super) const AS_RECORDED: Self =
        Self { spans: [1.0; 2], up: [0.0, 1.0, 0.0], hips_ahead: 0.0 };

    /// Of a person in several recordings: as the person usually stands where tallest on both feet. Where that is
    /// seen less than twice, legs are as straight as they ever were, and pelvis and hips as they were recorded. As
    /// recorded where there is but one recording, where the person may have stood on bent knees all the time.
    pub(super) fn of(recordings: &[Recording]) -> Self {
        if recordings.len() < 2 {
            return Self::AS_RECORDED;
        }
        let standing: Vec<Standing> = recordings.iter().filter_map(Standing::of).collect();
        let span = |side: usize| {
            let stood = standing.iter().filter(|s| !s.frames.is_empty());
            let tallest = stood.map(|s| s.legs[side].tallest(s.frames.iter().copied()));
            let upright: Vec<f64> = tallest.filter(|span| *span >= LEAST_UPRIGHT).collect();
            let straight = if upright.len() < 2 {
                let ever = standing.iter().map(|s| s.legs[side].tallest(0..s.recording.frames()));
                ever.filter(|span| span.is_finite()).fold(0.0, f64::max)
            } else {
                stats::quantile(&upright, 0.5)
            };
            straight.clamp(LEAST_UPRIGHT, 1.0)
        };
        let ups: Vec<[f64; 3]> = standing.iter().filter_map(Standing::up).collect();
        let up = median(&ups, 2).filter(|up| up[1] >= LEVEL);
        let ahead = |up: [f64; 3]| {
            let all: Vec<_> = standing.iter().filter_map(|s| s.hips_ahead(up)).collect();
            median(&all, 2).map(|[ahead]| ahead.clamp(-FARTHEST_AHEAD, FARTHEST_AHEAD))
        };
        Self {
            spans: [span(0), span(1)],
            up: up.unwrap_or(Self::AS_RECORDED.up),
            hips_ahead: up.and_then(ahead).unwrap_or(0.0),
        }
    }

    /// The same recording with a pelvis that is level where the person stands erect.
    pub(super) fn levelled(&self, recording: &Recording) -> Recording {
        let mut levelled = recording.clone();
        let turn = to_up(self.up);
        for track in levelled.segments.iter_mut().filter(|t| t.name == "Pelvis") {
            track.rotation.iter_mut().for_each(|rotation| *rotation *= turn);
        }
        levelled
    }

    /// How far from level the pelvis looks, deg.
    pub(super) fn looks_inclined_deg(&self) -> f64 {
        to_up(self.up).angle().to_degrees()
    }

    /// How far straight knees look bent, of the side where they do so more, deg.
    pub(super) fn look_bent_deg(&self) -> f64 {
        let bend = |share: &f64| 2.0 * share.acos().to_degrees();
        self.spans.iter().map(bend).fold(0.0, f64::max)
    }

    /// Flexion of the right and the left knee from hip, knee and ankle, rad.
    pub(super) fn knees_rad(&self, legs: [[Vec3; 3]; 2]) -> [f64; 2] {
        [0, 1].map(|side| knee_rad(legs[side], self.spans[side]))
    }
}

/// Flexion of a knee from hip, knee and ankle, rad, of a leg that is straight where hip and ankle are `straight`
/// apart, over its length.
fn knee_rad([hip, knee, ankle]: [Vec3; 3], straight: f64) -> f64 {
    let (thigh, shank) = ((knee - hip).norm(), (ankle - knee).norm());
    let span = (ankle - hip).norm() / straight;
    // Law of cosines; what is not a number stays so.
    let cosine = (span * span - thigh * thigh - shank * shank) / (2.0 * thigh * shank);
    if cosine > 1.0 { 0.0 } else { cosine.acos() }
}

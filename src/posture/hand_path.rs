//! A hand path as a person meets it: where to step from, and what is usual there.
//!
//! ```text
//! hand clock      knots every 8 mm of hand travel at most, evenly, whatever samples and times are
//! true time       knots at the samples, and between them where the hand travels more than 8 mm
//! ```
//! Rotations count at 0.3 m/rad, so that a step also turns the hand by less than 2 deg.

use super::attraction::UsualPosture;
use super::coupling::Coupling;
use super::grips::Grips;
use super::law::PostureLaw;
use super::model::PostureDistribution;
use super::noise::Clock;
use crate::human::mirrored_pose;
use crate::math::Pose;
use crate::math::pose::interpolate;
use nalgebra::DVector;
use std::borrow::Cow;

/// Longest step of the hand, m.
const STEP_M: f64 = 0.008;
/// Travel of a hand that rests all the time, m.
const STILL_M: f64 = 1e-6;

/// A hand path: grips in the rest frame, and the knots between which a rollout steps.
///
/// The usual posture depends on the path and the model only, so all rollouts share it.
#[derive(Debug, Clone)]
pub struct HandPath {
    time_s: Vec<f64>,
    targets: Vec<Grips>,
    knots: Vec<Knot>,
    /// Of each sample: the step in which it lies, and the part of the step that is done there; a part
    /// of 0 only before the hand has moved.
    places: Vec<(usize, f64)>,
    /// Time by the law's clock from one noise value to the next, and their number.
    noise_grid: (usize, f64),
}

/// A place from which a rollout steps to the next.
#[derive(Debug, Clone)]
pub(super) struct Knot {
    pub target: Grips,
    pub usual: Option<UsualPosture>,
    /// Time by the law's clock, s.
    pub clock_s: f64,
    /// Hand travel since the start, m.
    pub travel_m: f64,
    /// Where the noise of the step from here is: after which of its values, and how far to the next.
    pub noise: (usize, f64),
    /// By how much the noise is larger here than on average, n; none where it is alike everywhere.
    pub gains: Option<DVector<f64>>,
    /// Of the leading hand in the rest frame, over stature.
    pub height: f64,
    /// Phase of the movement, in [0, 1].
    pub phase: f64,
}

impl HandPath {
    /// For times (s) and as many grips in the rest frame, by the clock of the law.
    pub fn new(
        coupling: &Coupling,
        law: &PostureLaw,
        time_s: Vec<f64>,
        targets: Vec<impl Into<Grips>>,
    ) -> Self {
        let targets: Vec<Grips> = targets.into_iter().map(Into::into).collect();
        let mut travel = vec![0.0];
        for pair in targets.windows(2) {
            travel.push(travel[travel.len() - 1] + coupling.travel_m(&pair[0], &pair[1]));
        }
        let (knots, places, noise_grid) = match law.noise.clock {
            Clock::Hand { speed_m_s, .. } => by_hand(&targets, &travel, speed_m_s),
            Clock::Seconds { .. } => by_time(&targets, &travel, &time_s),
        };
        let mut path = Self { time_s, targets, knots, places, noise_grid };
        let grips: Vec<Grips> = path.knots.iter().map(|k| k.target).collect();
        let usual = usual_postures(law, coupling, &grips);
        let usual = usual
            .map_or_else(|| vec![None; grips.len()], |all| all.into_iter().map(Some).collect());
        for (knot, usual) in path.knots.iter_mut().zip(usual) {
            knot.usual = usual;
            let low = law.noise.low.as_ref();
            knot.height = height(coupling, &knot.target);
            knot.gains = low.map(|low| low.gains(knot.height));
        }
        path
    }

    /// The grip at the start.
    pub fn start(&self) -> &Grips {
        &self.targets[0]
    }

    /// Grips in the rest frame, T+1.
    pub fn targets(&self) -> &[Grips] {
        &self.targets
    }

    /// The usual posture at a sample, n, rad; none without a pull.
    pub fn usual_posture(&self, index: usize) -> Option<DVector<f64>> {
        let (a, b, part) = self.around(index)?;
        Some(a.posture.lerp(&b.posture, part))
    }

    fn around(&self, index: usize) -> Option<(&UsualPosture, &UsualPosture, f64)> {
        let (step, part) = *self.places.get(index)?;
        let a = self.knots.get(step)?.usual.as_ref()?;
        let b = self.knots.get(step + 1).and_then(|k| k.usual.as_ref()).unwrap_or(a);
        Some((a, b, part))
    }

    /// From the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().map_or(0.0, |t| t - self.time_s[0])
    }

    /// Number of samples, T+1.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Never true: a path has a start.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// Share of the samples that the training data do not support (confidence below one half); 0
    /// without an attraction.
    pub fn extrapolation_share(&self) -> f64 {
        let confidence = |i: usize| {
            self.around(i)
                .map_or(1.0, |(a, b, part)| a.confidence + part * (b.confidence - a.confidence))
        };
        let low = (0..self.len()).filter(|&i| confidence(i) < 0.5).count();
        low as f64 / self.len().max(1) as f64
    }

    pub(super) fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// The step in which a sample lies, and the part of it that is done there.
    pub(super) fn place(&self, index: usize) -> Option<(usize, f64)> {
        self.places.get(index).copied()
    }

    /// Time of a sample since the start, s.
    pub(super) fn time_s(&self, index: usize) -> f64 {
        self.time_s[index] - self.time_s[0]
    }

    /// How many values of the noise a repetition needs, and how far they are apart, s of the clock.
    pub(super) fn noise_grid(&self) -> (usize, f64) {
        self.noise_grid
    }
}

/// The postures of a person with the grips (rest frame) at a place.
pub fn postures_at<'a>(
    (law, postures): (&PostureLaw, &'a PostureDistribution),
    coupling: &Coupling,
    grips: &Grips,
) -> Cow<'a, PostureDistribution> {
    match usual_postures(law, coupling, std::slice::from_ref(grips)).as_deref() {
        Some([usual, ..]) => postures.near(usual, height(coupling, grips)),
        _ => Cow::Borrowed(postures),
    }
}

/// Height of the leading hand in the rest frame, over stature.
fn height(coupling: &Coupling, grips: &Grips) -> f64 {
    grips.first.translation.y / coupling.stature_m()
}

/// The postures that are usual with the hands there; none without a pull.
fn usual_postures(
    law: &PostureLaw,
    coupling: &Coupling,
    grips: &[Grips],
) -> Option<Vec<UsualPosture>> {
    let attraction = law.attraction.as_ref()?;
    let h = coupling.stature_m();
    let of = |hand: usize, poses: Vec<Pose>| {
        let looked_up = |grip: &Pose| {
            coupling
                .looked_up(hand, grip, || attraction.usual_orientation(&grip.translation.vector, h))
        };
        attraction.usual_along(&poses.iter().map(looked_up).collect::<Vec<_>>(), h)
    };
    let first = of(0, grips.iter().map(|g| g.first).collect());
    // The second hand is looked up in the mirror image, where it is the first.
    let second: Option<Vec<Pose>> =
        grips.iter().map(|g| g.second.as_ref().map(mirrored_pose)).collect();
    let (Some(second), Some(pair)) = (second, &law.pair) else { return Some(first) };
    let both = first.iter().zip(of(1, second));
    Some(both.map(|(first, second)| pair.together(first, &second)).collect())
}

type Layout = (Vec<Knot>, Vec<(usize, f64)>, (usize, f64));

/// Even steps of hand travel.
fn by_hand(targets: &[Grips], travel: &[f64], speed_m_s: f64) -> Layout {
    let total = travel[travel.len() - 1];
    let steps = if total < STILL_M { 0 } else { (total / STEP_M).ceil() as usize };
    let step_m = total / steps.max(1) as f64;
    let mut leg = 0;
    let knots = (0..=steps)
        .map(|k| {
            let at = if k == steps { total } else { step_m * k as f64 };
            while leg + 2 < travel.len() && travel[leg + 1] < at {
                leg += 1;
            }
            let target = if k == 0 || targets.len() < 2 {
                targets[0]
            } else if k == steps {
                targets[targets.len() - 1]
            } else {
                let span = travel[leg + 1] - travel[leg];
                let part = if span > 0.0 { (at - travel[leg]) / span } else { 1.0 };
                targets[leg].zip(&targets[leg + 1], |a, b| interpolate(a, b, part))
            };
            Knot {
                target,
                usual: None,
                clock_s: at / speed_m_s,
                travel_m: at,
                noise: (k, 0.5),
                gains: None,
                height: 0.0,
                phase: k as f64 / steps.max(1) as f64,
            }
        })
        .collect();
    let place = |at: &f64| {
        if steps == 0 || *at <= 0.0 {
            return (0, 0.0);
        }
        let step = ((at / step_m).ceil() as usize).clamp(1, steps) - 1;
        (step, (at / step_m - step as f64).clamp(0.0, 1.0))
    };
    let apart = if steps == 0 { 1.0 } else { step_m / speed_m_s };
    (knots, travel.iter().map(place).collect(), (steps + 1, apart))
}

/// The samples, and steps between them where the hand travels far.
fn by_time(targets: &[Grips], travel: &[f64], time_s: &[f64]) -> Layout {
    let legs = targets.len() - 1;
    let knot = |leg: usize, part: f64| {
        let next = (leg + 1).min(legs);
        let between = |v: &[f64]| v[leg] + part * (v[next] - v[leg]);
        Knot {
            target: targets[leg].zip(&targets[next], |a, b| interpolate(a, b, part)),
            usual: None,
            clock_s: between(time_s),
            travel_m: between(travel),
            noise: (leg, part),
            gains: None,
            height: 0.0,
            phase: leg as f64 / legs.max(1) as f64,
        }
    };
    let (mut knots, mut places) = (Vec::new(), vec![(0, 0.0)]);
    for leg in 0..legs {
        let steps = ((travel[leg + 1] - travel[leg]) / STEP_M).ceil().clamp(1.0, 200.0) as usize;
        knots.extend((0..steps).map(|step| knot(leg, step as f64 / steps as f64)));
        places.push((knots.len() - 1, 1.0));
    }
    knots.push(knot(legs, 0.0));
    let span = time_s[legs] - time_s[0];
    let apart = if span > 0.0 { span / legs as f64 } else { 1.0 };
    (knots, places, (targets.len(), apart))
}

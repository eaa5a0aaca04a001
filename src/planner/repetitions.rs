//! Repetitions of one body along one path, with the angles of every frame.

use crate::kinematics::Frames;
use crate::math::Pose;
use crate::posture::{Feet, Footing, Mixture, Repeated, Rollout, Start};
use crate::survey::{HeadDraw, PostureAngles, Surveyor};
use nalgebra::DVector;
use rayon::prelude::*;

/// Length by which a rotation of the hand counts as travel, m/rad.
const ROTATION_LENGTH_M: f64 = 0.3;
/// Distance of the centre of mass from the edge of the feet at which a person is taken to stand at the edge, m;
/// the step solver holds it 1 cm inside.
pub(super) const AT_EDGE_M: f64 = 0.015;
/// Hand travel below which a path has no length to speak of, m.
const SHORTEST_M: f64 = 1e-6;

/// One repetition of one body, with what is known of each sample.
pub(super) struct Repetition<A = PostureAngles> {
    /// Whose body it is, of those for whom a body stands; 0 where it stands for itself.
    pub member: usize,
    pub rollout: Rollout,
    pub angles: Vec<A>,
    pub start: Start,
    /// None where the feet stay where the scenario has them.
    pub feet: Option<Feet>,
    /// Feet that must stay are where this person would not stand all the time.
    pub would_step: bool,
}

impl<A> Repetition<A> {
    /// The angles as far as the hand follows.
    pub(super) fn reached(&self) -> &[A] {
        let end = self.rollout.reach_exceeded_at.unwrap_or(self.angles.len());
        &self.angles[..end.min(self.angles.len())]
    }

    /// Where the feet are at a sample.
    pub(super) fn footing(&self, k: usize) -> Footing {
        let at = self.feet.as_ref().and_then(|feet| feet.at.get(k).or(feet.at.last()));
        at.copied().unwrap_or_default()
    }
}

/// What was repeated: one of each for each repetition.
pub(super) struct Walked {
    pub starts: Vec<Start>,
    pub repeated: Repeated,
    /// None where the feet stay where the scenario has them.
    pub feet: Vec<Option<Feet>>,
    /// Whether a person whose feet must stay would set them elsewhere.
    pub would_step: Vec<bool>,
}

/// From where a repetition starts, where its feet are, and whether they would be elsewhere.
type Stood = (Start, (Option<Feet>, bool));

/// One body measured along one path.
pub(super) struct Repetitions<A = PostureAngles> {
    pub all: Vec<Repetition<A>>,
    /// Interval of the samples, s.
    pub dt: f64,
    /// Each sample's share of the hand travel.
    pub travel: Vec<f64>,
    pub extrapolation_share: f64,
    /// How often each mode occurs; none where they are not told apart.
    pub mixture: Option<Mixture>,
    /// How many people repeat in turn; none where every repetition counts alone.
    pub persons: Option<usize>,
}

/// How a posture is looked at: the body, its posture and head, whether its feet are on their way, and scratch.
pub(super) type Look<'a, A> =
    dyn Fn(&Surveyor, (&DVector<f64>, &HeadDraw), bool, &mut Frames) -> A + Sync + 'a;

/// All that is measured of a posture.
pub(super) fn in_full(
    surveyor: &Surveyor,
    (q, head): (&DVector<f64>, &HeadDraw),
    is_stepping: bool,
    _: &mut Frames,
) -> PostureAngles {
    let mut angles = surveyor.measure(q, head);
    // Nobody balances over feet that are on their way.
    if is_stepping {
        angles.margin_m = None;
    }
    angles
}

impl<A: Send> Repetitions<A> {
    /// What was repeated from some starts with some ways of holding the head, along times (s) and as many
    /// poses of the leading grip.
    pub(super) fn measured(
        (surveyor, look): (&Surveyor, &Look<A>),
        Walked { starts, repeated, feet, would_step }: Walked,
        heads: Vec<HeadDraw>,
        (time_s, hand): (&[f64], &[Pose]),
    ) -> Self {
        let one = |((rollout, head), (start, (feet, would_step))): ((Rollout, HeadDraw), Stood)| {
            let mut frames = Frames::default();
            let of = |(q, t): (&DVector<f64>, &f64)| {
                let is_stepping = feet.as_ref().is_some_and(|f| f.steps_at(t - time_s[0]));
                look(surveyor, (q, &head), is_stepping, &mut frames)
            };
            let angles: Vec<A> = rollout.q.iter().zip(time_s).map(of).collect();
            Repetition { member: 0, rollout, angles, start, feet, would_step }
        };
        let stood: Vec<Stood> = starts.into_iter().zip(feet.into_iter().zip(would_step)).collect();
        let all = repeated.rollouts.into_par_iter().zip(heads).zip(stood).map(one).collect();
        let intervals = time_s.len().saturating_sub(1).max(1) as f64;
        let dt = (time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0)) / intervals;
        let extrapolation_share = repeated.extrapolation_share;
        let travel = travel_shares(hand);
        Self { all, dt, travel, extrapolation_share, mixture: None, persons: None }
    }
}

impl<A> Repetitions<A> {
    /// Single repetitions along the same path, each by the member of a number, as one.
    pub(super) fn of_members(all: Vec<(usize, Self)>) -> Option<Self> {
        let count = all.len() as f64;
        let extrapolation_share = all.iter().map(|(_, r)| r.extrapolation_share).sum::<f64>();
        let mut all = all.into_iter().map(|(member, mut one)| {
            one.all.iter_mut().for_each(|r| r.member = member);
            one
        });
        let mut whole = all.next()?;
        whole.all.extend(all.flat_map(|one| one.all));
        whole.extrapolation_share = extrapolation_share / count;
        Some(whole)
    }
}

/// Each sample's share of the hand travel of a path of grip poses (sums to 1): half of the way before
/// it and half of that after it. Of a hand that does not move, alike for all.
pub(super) fn travel_shares(hand: &[Pose]) -> Vec<f64> {
    let step = |w: &[Pose]| {
        let moved = (w[1].translation.vector - w[0].translation.vector).norm();
        moved.hypot(ROTATION_LENGTH_M * w[0].rotation.angle_to(&w[1].rotation))
    };
    let steps: Vec<f64> = hand.windows(2).map(step).collect();
    let whole: f64 = steps.iter().sum();
    if whole < SHORTEST_M {
        return vec![1.0 / hand.len() as f64; hand.len()];
    }
    let at = |k: usize| steps.get(k).copied().unwrap_or(0.0);
    (0..hand.len()).map(|k| 0.5 * (if k > 0 { at(k - 1) } else { 0.0 } + at(k)) / whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_that_only_turns_travels_too() {
        let turned = |a: f64| Pose::rotation(crate::math::Vec3::z() * a);
        let shares = travel_shares(&[turned(0.0), turned(0.1), turned(0.4)]);
        assert!((shares[0] - 0.125).abs() < 1e-12 && (shares[2] - 0.375).abs() < 1e-12);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(travel_shares(&[turned(0.0); 4]), [0.25; 4]);
    }
}

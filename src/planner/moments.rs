//! The postures of the best path that a reader wants to see: at the hardest moment, of the hardest
//! repetition, and the one that is held longest.

use super::person::Person;
use super::repetitions::{Repetition, Repetitions};
use super::result::{Moment, MomentKind};
use super::scene::PosedMannequin;
use crate::ergonomics::{Clock, Sheet, TimeRules};
use crate::scenario::Variant;
use crate::survey::{Lens, PostureAngles, Scorable};
use nalgebra::DVector;

/// The postures, by what they show; none where nobody reaches the start.
pub(super) fn moments(
    person: &Person,
    repetitions: &Repetitions,
    variant: &Variant,
    lens: &Lens,
) -> Vec<Moment> {
    let scores: Vec<Vec<(u8, u8)>> = repetitions.all.iter().map(|w| scored(w, lens)).collect();
    let at = Place { person, repetitions, variant, lens };
    let mut found = Vec::new();
    let hardest = hardest_time(&scores);
    let typical = hardest.and_then(|k| Some((nearest_to_mean(&repetitions.all, &scores, k)?, k)));
    if let Some((r, k)) = typical {
        found.push(at.moment(MomentKind::TypicalAtHardest, (r, k), None));
        if let Some((middle, held_s)) =
            longest_hold(&repetitions.all[r], scores[r].len(), repetitions.dt, lens)
        {
            found.push(at.moment(MomentKind::HeldLongest, (r, middle), Some(held_s)));
        }
    }
    let all = scores.iter().enumerate().flat_map(|(r, s)| {
        s.iter().enumerate().map(move |(k, score)| (*score, std::cmp::Reverse((r, k))))
    });
    if let Some((_, std::cmp::Reverse(place))) = all.max() {
        found.push(at.moment(MomentKind::Hardest, place, None));
    }
    found
}

/// RULA and REBA of the frames that the hand reached.
fn scored(repetition: &Repetition, lens: &Lens) -> Vec<(u8, u8)> {
    let end = repetition.rollout.reach_exceeded_at.unwrap_or(repetition.angles.len());
    let score = |a: &PostureAngles| {
        let sheet = a.score(lens);
        (sheet.rula.grand, sheet.reba.total)
    };
    repetition.angles[..end.min(repetition.angles.len())].iter().map(score).collect()
}

/// The frame with the highest mean RULA; the first of several.
fn hardest_time(scores: &[Vec<(u8, u8)>]) -> Option<usize> {
    let frames = scores.iter().map(Vec::len).max().filter(|n| *n > 0)?;
    let mean = |k: usize| {
        let there: Vec<f64> = scores.iter().filter_map(|s| s.get(k)).map(|s| s.0.into()).collect();
        crate::math::stats::mean(&there)
    };
    let mut best = (0, f64::NEG_INFINITY);
    for k in 0..frames {
        let value = mean(k);
        if value > best.1 {
            best = (k, value);
        }
    }
    Some(best.0)
}

/// The repetition whose joint angles are nearest to the mean of all at a frame.
fn nearest_to_mean(all: &[Repetition], scores: &[Vec<(u8, u8)>], k: usize) -> Option<usize> {
    let there: Vec<usize> = (0..all.len()).filter(|&r| scores[r].len() > k).collect();
    let q = |r: usize| &all[r].rollout.q[k];
    let zero = DVector::zeros(q(*there.first()?).len());
    let mean = there.iter().fold(zero, |sum, &r| sum + q(r)) / there.len() as f64;
    let off = |r: usize| (q(r) - &mean).norm_squared();
    there.into_iter().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// Middle frame and length (s) of the longest hold of trunk and arm together.
fn longest_hold(
    repetition: &Repetition,
    frames: usize,
    dt: f64,
    lens: &Lens,
) -> Option<(usize, f64)> {
    let of = |pick: fn(&PostureAngles, &Lens) -> f64| -> Vec<f64> {
        repetition.angles[..frames].iter().map(|a| pick(a, lens)).collect()
    };
    let angles = [
        of(|a, l| a.trunk_neck(l.neck).trunk_flex_deg),
        of(|a, l| a.trunk_neck(l.neck).trunk_side_deg),
        of(|a, l| a.trunk_neck(l.neck).trunk_twist_deg),
        of(|a, _| a.arm.upper_arm_flex_deg),
        of(|a, _| a.arm.upper_arm_abduction_deg),
        of(|a, _| a.arm.elbow_flex_deg),
    ];
    let angles: Vec<&[f64]> = angles.iter().map(Vec::as_slice).collect();
    let time: Vec<f64> = (0..frames).map(|k| k as f64 * dt).collect();
    let hold = Clock::new(&time, TimeRules::default()).part(&angles).longest_hold?;
    let middle = (0.5 * (hold.from_s + hold.to_s) / dt).round() as usize;
    Some((middle.min(frames.checked_sub(1)?), hold.duration_s()))
}

struct Place<'a> {
    person: &'a Person<'a>,
    repetitions: &'a Repetitions,
    variant: &'a Variant,
    lens: &'a Lens,
}

impl Place<'_> {
    fn moment(&self, what: MomentKind, (r, k): (usize, usize), held_s: Option<f64>) -> Moment {
        let repetition = &self.repetitions.all[r];
        let angles = &repetition.angles[k];
        let Sheet { rula, reba } = angles.score(self.lens);
        let (t, arm) = (angles.trunk_neck(self.lens.neck), &angles.arm);
        let (rest, q) =
            (self.person.rest_at(self.variant, repetition, k), &repetition.rollout.q[k]);
        let head = angles.head(self.lens.neck);
        let own = self.person.of(repetition);
        let named = [
            ("trunk flexion", t.trunk_flex_deg),
            ("trunk side bend", t.trunk_side_deg),
            ("trunk twist", t.trunk_twist_deg),
            ("neck flexion", t.neck_flex_deg),
            ("upper arm elevation", arm.upper_arm_elevation_deg),
            ("upper arm outward", arm.upper_arm_abduction_deg),
            ("elbow flexion", arm.elbow_flex_deg),
            ("wrist flexion", arm.wrist_flex_deg),
            ("wrist deviation", arm.wrist_deviation_deg),
            ("forearm twist", arm.wrist_twist_deg),
            ("right knee flexion", angles.legs.knees_deg[0]),
            ("left knee flexion", angles.legs.knees_deg[1]),
        ];
        Moment {
            what,
            body: self.person.name.clone(),
            repetition: r,
            time_s: k as f64 * self.repetitions.dt,
            held_s,
            rula: rula.grand,
            reba: reba.total,
            angles_deg: named.map(|(name, deg)| (name.to_owned(), deg)).to_vec(),
            bones: own.surveyor.bones_at(&rest, q, head),
            mannequin: PosedMannequin::of(&own.mannequin, &rest, q.as_slice(), head),
        }
    }
}

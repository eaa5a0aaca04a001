//! Sampled trajectories of one held-out movement: postures, and four scores over time (the paper's Fig. 5).
//!
//! Scores of recorded and sampled postures are made alike: free hands, no load, the head as recorded people hold it
//! on average with that trunk and hand. RULA continuous is the paper's sum of polynomials of trunk flexion, upper arm
//! flexion, elbow flexion, trunk twist and wrist flexion; the back angle adds up the spine's rotations.

use super::judge::Prepared;
use super::sets::TrainingSet;
use crate::ergonomics::{Profile, TaskInputs, rula_continuous};
use crate::files::InputError;
use crate::human::{Body, Coupled, PELVIS_JOINTS, Pelvis, Side, Stance};
use crate::posture::{Method, Sampler};
use crate::survey::{HeadDraw, Lens, NeckRule, Scorable, Surveyor};
use crate::training::TrainSettings;
use crate::training::methods::{learn_laws, singular};
use crate::training::people::Curve;
use crate::training::rollout_check::{ROLLOUTS, pieces, sampled_law, walks};
use nalgebra::DVector;
use rayon::prelude::*;

/// The scores, in the order of [`PostureSpread::scores`].
pub const SCORES: [&str; 4] = ["RULA", "REBA", "RULA continuous", "cumulative back angle"];
/// Seat of who sits, m.
const SEAT_M: f64 = 0.45;

/// Sampled trajectories of one held-out movement.
#[derive(Debug, Clone, PartialEq)]
pub struct PostureSpread {
    /// Whose law.
    pub method: Method,
    /// Whose movement.
    pub who: String,
    /// Of which task.
    pub task: String,
    /// Its name.
    pub movement: String,
    /// The person's body.
    pub body: Body,
    /// Which of it is predicted.
    pub coupled: Coupled,
    /// How it is carried.
    pub stance: Stance,
    /// Times, T, s.
    pub time_s: Vec<f64>,
    /// Recorded coordinates, T of n, rad and leg lengths.
    pub recorded: Vec<DVector<f64>>,
    /// Sampled ones, R x T of n.
    pub samples: Vec<Vec<DVector<f64>>>,
    /// Scores over time, in the order of [`SCORES`]: points, points, points, deg.
    pub scores: [Curve; 4],
}

/// Learns a method on what teaches in a set, and samples the first movement that tests.
///
/// # Errors
/// Where the chain is singular in the data, or no three frames in a row are held out.
pub(super) fn posture_spread(
    (set, own): (&TrainingSet, &Prepared),
    method: Method,
    settings: &TrainSettings,
) -> Result<PostureSpread, InputError> {
    let Prepared { dataset, fold, names } = own;
    let test = dataset.select(&fold.test);
    let pieces = pieces(&test);
    let run = pieces.first().ok_or_else(|| {
        InputError::new(&set.who, "holds no movement long enough to be predicted")
    })?;
    let train = dataset.select(&fold.train);
    let laws = learn_laws(&[method], &train, dataset.coupling.stature_m(), settings, None)?;
    let law = laws.first().ok_or_else(singular)?;
    let (law, _) = sampled_law(dataset, &fold.train, law, settings)?;
    let sampler = Sampler::new(&law, settings.sampling).ok_or_else(singular)?;
    let walked = walks(dataset, &law, &sampler, (0, run), (ROLLOUTS, settings.seed));
    let samples: Vec<Vec<DVector<f64>>> = walked.into_iter().map(|w| w.q).collect();
    let recorded: Vec<DVector<f64>> = run.iter().map(|f| f.q.clone()).collect();
    let is_whole = dataset.joints.iter().any(|j| j == PELVIS_JOINTS[0]);
    let pelvis = if is_whole { Pelvis::Moves } else { Pelvis::Rests };
    let coupled = Coupled { hands: set.side.into(), pelvis };
    let stance = if set.is_seated {
        Stance::Seated { seat_height_m: SEAT_M, footrest_m: 0.0 }
    } else {
        Stance::Standing { shoe_m: 0.0 }
    };
    let scorer = Scorer::new(&set.body, coupled, set.side, stance)?;
    Ok(PostureSpread {
        method,
        who: set.who.clone(),
        task: set.task.clone(),
        movement: names[run[0].trial].clone(),
        scores: scorer.curves(&recorded, &samples),
        body: set.body.clone(),
        coupled,
        stance,
        time_s: run.iter().map(|f| f.time_s).collect(),
        recorded,
        samples,
    })
}

struct Scorer {
    surveyor: Surveyor,
    head: HeadDraw,
    lens: Lens,
}

impl Scorer {
    fn new(body: &Body, coupled: Coupled, side: Side, stance: Stance) -> Result<Self, InputError> {
        let rest = body.pelvis_pose([0.0; 2], 0.0, stance);
        let sitting = matches!(stance, Stance::Seated { .. });
        let lens = Lens {
            task: TaskInputs { sitting, ..TaskInputs::default() },
            neck: NeckRule::Predicted,
            both_hands: false,
            profile: Profile::default(),
        };
        let surveyor = Surveyor::new(body, coupled, rest, (stance, 0.0))?;
        Ok(Self { surveyor, head: HeadDraw::mean(Some(side)), lens })
    }

    fn scores(&self, q: &DVector<f64>) -> [f64; 4] {
        let angles = self.surveyor.measure(q, &self.head);
        let sheet = angles.score(&self.lens);
        let (trunk, arm) = (angles.trunk_neck(self.lens.neck), &angles.arm);
        let (continuous, _) = rula_continuous(&[
            trunk.trunk_flex_deg,
            arm.upper_arm_flex_deg,
            arm.elbow_flex_deg,
            trunk.trunk_twist_deg,
            arm.wrist_flex_deg,
        ]);
        let back = self.surveyor.back(q).rotation_deg;
        [sheet.rula.grand.into(), sheet.reba.total.into(), continuous, back]
    }

    fn curves(&self, recorded: &[DVector<f64>], samples: &[Vec<DVector<f64>>]) -> [Curve; 4] {
        let over_time = |all: &[DVector<f64>]| -> Vec<[f64; 4]> {
            all.iter().map(|q| self.scores(q)).collect()
        };
        let own = over_time(recorded);
        let walked: Vec<Vec<[f64; 4]>> = samples.par_iter().map(|s| over_time(s)).collect();
        let pick = |all: &[[f64; 4]], k: usize| all.iter().map(|s| s[k]).collect::<Vec<f64>>();
        [0, 1, 2, 3].map(|k| {
            Curve::of(pick(&own, k), &walked.iter().map(|w| pick(w, k)).collect::<Vec<_>>())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_bent_back_scores_more_on_all_four() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        for (pelvis, n) in [(Pelvis::Rests, 24), (Pelvis::Moves, 30)] {
            let coupled = Coupled { hands: Side::Right.into(), pelvis };
            let stance = Stance::Standing { shoe_m: 0.0 };
            let scorer = Scorer::new(&body, coupled, Side::Right, stance).unwrap();
            let upright = DVector::zeros(n);
            let mut bent = upright.clone();
            // Flexion of the four spine joints, 15 deg each.
            for c in 0..4 {
                bent[n - 24 + 3 * c] = -15f64.to_radians();
            }
            let [a, b] = [&upright, &bent].map(|q| scorer.scores(q));
            assert!((0..4).all(|k| b[k] > a[k]), "{a:?} {b:?}");
            assert!(a[3].abs() < 1e-6 && (b[3] - 60.0).abs() < 1e-6, "{b:?}");
        }
    }
}

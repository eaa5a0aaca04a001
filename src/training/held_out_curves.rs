//! Joint angles of a held-out movement beside repetitions along its hand path.
//!
//! The law is learned on the training part of the first split of [`Dataset::held_out`], as it is for
//! the scores; the piece is the longest uninterrupted one of the part held out. Every repetition starts at the
//! recorded posture.

use super::dataset::{Dataset, Frame};
use super::methods::{learn_laws, singular};
use super::rollout_check::{ROLLOUTS, band_end, pieces, sampled_law, walks};
use super::settings::TrainSettings;
use crate::files::InputError;
use crate::posture::{Method, Rollout, Sampler};

/// One joint of the movement.
#[derive(Debug, Clone, PartialEq)]
pub struct JointCurves {
    /// Name of the joint.
    pub joint: String,
    /// Recorded angles, T, rad.
    pub recorded: Vec<f64>,
    /// Quantiles of the walks' angles at [`BAND_LEVELS`], T each, rad.
    pub quantiles: [Vec<f64>; 5],
    /// Share of the times after the start at which the 90 % band holds the recorded angle.
    pub held_90: f64,
}

/// Levels of the quantiles: the ends of the 90 % and 50 % band, and the median between them.
pub const BAND_LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// A held-out movement and what a law makes of its hand path.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutCurves {
    /// Method of the law.
    pub method: Method,
    /// Whether the walks are pulled towards the person's own postures.
    pub is_pulled: bool,
    /// Number of walks.
    pub rollouts: u32,
    /// Index of the trial.
    pub trial: usize,
    /// Times since the start of the trial, T, s.
    pub time_s: Vec<f64>,
    /// A row for each joint, in the order of the chain.
    pub joints: Vec<JointCurves>,
}

impl HeldOutCurves {
    /// The `count` joints with the largest recorded range, in the order of the chain.
    pub fn moving_most(&self, count: usize) -> Vec<&JointCurves> {
        let range = |j: &JointCurves| {
            let highest = j.recorded.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            highest - j.recorded.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let mut order: Vec<usize> = (0..self.joints.len()).collect();
        // Stable: of equal ranges the joint nearer to the pelvis comes first.
        order.sort_by(|a, b| range(&self.joints[*b]).total_cmp(&range(&self.joints[*a])));
        order.truncate(count);
        order.sort_unstable();
        order.into_iter().map(|j| &self.joints[j]).collect()
    }
}

/// Learns a method without the first held-out part and walks along the longest piece of that part.
///
/// # Errors
/// Where the chain is singular in the data, or no three frames in a row are held out.
pub fn held_out_curves(
    dataset: &Dataset,
    method: Method,
    settings: &TrainSettings,
) -> Result<HeldOutCurves, InputError> {
    settings.check()?;
    let too_short = || {
        InputError::new("recordings", "hold no movement long enough to be held out and drawn")
            .remedy("give longer movements, or leave out --figures")
    };
    let fold = dataset.held_out().into_iter().next().ok_or_else(too_short)?;
    let test = dataset.select(&fold.test);
    let pieces = pieces(&test);
    // The first of the longest.
    let longest = pieces.iter().enumerate().rev().max_by_key(|(_, p)| p.len());
    let (index, piece) = longest.ok_or_else(too_short)?;
    let train = dataset.select(&fold.train);
    let laws = learn_laws(&[method], &train, dataset.coupling.stature_m(), settings, None)?;
    let law = laws.first().ok_or_else(singular)?;
    let (law, repetitions) = sampled_law(dataset, &fold.train, law, settings)?;
    let sampler = Sampler::new(&law, settings.sampling).ok_or_else(singular)?;
    let how = (ROLLOUTS, settings.seed);
    let walks = walks(dataset, &law, &sampler, (index, piece), how);
    let names = dataset.joints.iter().enumerate();
    Ok(HeldOutCurves {
        method,
        is_pulled: repetitions.is_pulled,
        rollouts: ROLLOUTS,
        trial: piece[0].trial,
        time_s: piece.iter().map(|f| f.time_s).collect(),
        joints: names.map(|(j, name)| curves(name, j, piece, &walks)).collect(),
    })
}

fn curves(joint: &str, j: usize, piece: &[&Frame], walks: &[Rollout]) -> JointCurves {
    let recorded: Vec<f64> = piece.iter().map(|f| f.q[j]).collect();
    let mut quantiles: [Vec<f64>; 5] = Default::default();
    for k in 0..piece.len() {
        let mut values: Vec<f64> = walks.iter().map(|w| w.q[k][j]).collect();
        values.sort_by(f64::total_cmp);
        for (curve, level) in quantiles.iter_mut().zip(BAND_LEVELS) {
            curve.push(band_end(&values, level));
        }
    }
    let is_held = |k: &usize| quantiles[0][*k] <= recorded[*k] && recorded[*k] <= quantiles[4][*k];
    let times = 1..recorded.len();
    let held_90 = times.clone().filter(is_held).count() as f64 / times.len().max(1) as f64;
    JointCurves { joint: joint.to_owned(), recorded, quantiles, held_90 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::quantile;
    use crate::training::dataset::tests::made_up;
    use crate::training::{check_rollouts, rollout_check::Bands};
    use approx::assert_relative_eq;
    use nalgebra::DVector;

    /// Of ten walks around the recorded one, which leave it behind at the last time.
    fn shift(r: usize, k: usize) -> f64 {
        if k == 4 { 0.1 + r as f64 } else { (r as f64 * 7.3).sin() * k as f64 }
    }

    #[test]
    fn bands_are_those_of_a_plain_loop() {
        let data = made_up(1, 4.0, 30.0);
        let piece: Vec<&Frame> = data.frames.iter().take(5).collect();
        let walk = |r: usize| Rollout {
            q: (0..5).map(|k| &piece[k].q + DVector::from_element(24, shift(r, k))).collect(),
            reach_exceeded_at: None,
            max_residual_m: 0.0,
            rms_residual_m: 0.0,
            max_residual_rad: 0.0,
        };
        let walks: Vec<Rollout> = (0..10).map(walk).collect();
        let found = curves("elbow", 7, &piece, &walks);
        for k in 0..5 {
            let values: Vec<f64> = (0..10).map(|r| walks[r].q[k][7]).collect();
            for (level, curve) in BAND_LEVELS.iter().zip(&found.quantiles) {
                // The (R + 1) p-th value, between the first and the last of ten.
                let at = ((11.0 * level - 1.0) / 9.0).clamp(0.0, 1.0);
                assert_relative_eq!(curve[k], quantile(&values, at), max_relative = 1e-12);
            }
            assert_eq!(found.recorded[k], piece[k].q[7]);
        }
        assert_eq!(found.held_90, 0.75);
    }

    #[test]
    fn they_are_the_walks_that_are_judged() {
        // One held-out trial is one piece: the mean over joints is the coverage of the score.
        let data = made_up(3, 2.0, 30.0);
        let settings = TrainSettings::default();
        let curves = held_out_curves(&data, Method::FullW, &settings).unwrap();
        assert_eq!((curves.trial, curves.time_s.len(), curves.rollouts), (0, 60, 100));
        assert_eq!((curves.joints.len(), curves.time_s[0]), (24, 0.0));
        for joint in &curves.joints {
            for curve in &joint.quantiles {
                assert!((curve[0] - joint.recorded[0]).abs() < 1e-12, "the start is recorded");
            }
        }
        let fold = &data.held_out()[0];
        let train = data.select(&fold.train);
        let stature_m = data.coupling.stature_m();
        let laws = learn_laws(&[Method::FullW], &train, stature_m, &settings, None).unwrap();
        let floors = crate::posture::Floors {
            task: DVector::from_element(6, 1e-8),
            null_rad_s: settings.null_floor_rad_s,
        };
        let (score, _) = check_rollouts(&data, fold, &laws[0], &settings, &floors).unwrap();
        let Bands { coverage_90, width_90_deg, .. } = score.bands;
        let held: f64 = curves.joints.iter().map(|j| j.held_90).sum::<f64>() / 24.0;
        assert_relative_eq!(held, coverage_90, max_relative = 1e-9);
        let wide: f64 = curves
            .joints
            .iter()
            .flat_map(|j| (1..60).map(|k| j.quantiles[4][k] - j.quantiles[0][k]))
            .sum();
        assert_relative_eq!((wide / (24.0 * 59.0)).to_degrees(), width_90_deg, max_relative = 1e-9);
        assert_eq!(curves, held_out_curves(&data, Method::FullW, &settings).unwrap());
    }

    #[test]
    fn the_longest_piece_and_the_joints_that_move_most_are_taken() {
        let mut data = made_up(3, 2.0, 30.0);
        // A gap in the held-out trial: pieces of 20 and 39 frames.
        data.frames.remove(20);
        let mut curves =
            held_out_curves(&data, Method::PlainIk, &TrainSettings::default()).unwrap();
        assert_eq!((curves.time_s.len(), curves.time_s[0]), (39, 21.0 / 30.0));
        for (j, joint) in curves.joints.iter_mut().enumerate() {
            joint.recorded = vec![0.0, [0.1, 3.0, 1.0, 0.2, 2.0].get(j).copied().unwrap_or(0.0)];
        }
        let names = |count| -> Vec<&str> {
            curves.moving_most(count).iter().map(|j| j.joint.as_str()).collect()
        };
        assert_eq!(names(3), [&data.joints[1], &data.joints[2], &data.joints[4]]);
        assert_eq!(names(99).len(), 24);
    }
}

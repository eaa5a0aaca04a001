//! Which ways of reaching down recorded people have, and whether telling them apart predicts people better.
//!
//! ```text
//! low movements ─ two Gaussians of (trunk, knees) where the hand is lowest ─ whose movement is of which mode
//! each mode     ─ its low movements and all others ─ a law with its postures
//! kept where    energy score of repetitions of people (or movements) left out: modes < one law
//! ```
//! The mixture of two Gaussians is fitted by expectation and maximisation to the largest posterior, with a
//! prior of eight movements that scatter by 12 deg about each mean (`whole-body` prototype on five people).

use super::dataset::{Dataset, Fold, Frame, LOW_LEGS, runs};
use super::measurer::Features;
use super::methods::{Law, learn_laws, singular};
use super::rollout_check::{LearnedRepetitions, repetitions_of_part};
use super::settings::TrainSettings;
use super::strangers::{Strangers, mean_energy_deg};
use super::way::{learn_way, rounded};
use crate::files::InputError;
use crate::math::stats::mean;
use crate::posture::{
    LowMovement, Mode, Modelled, Modes, PostureDistribution, PostureLaw, low_place,
};
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Share of the frames that count as lowest.
const LOWEST: f64 = 0.1;
/// Fewest low movements that a mode is learned from.
const FEWEST: usize = 4;
/// Prior of the covariance of a mode: so many movements, and their scatter, deg.
const PRIOR_MOVEMENTS: f64 = 8.0;
const PRIOR_SD_DEG: f64 = 12.0;
const ITERATIONS: usize = 500;
/// By how much smaller the energy score must be, as a share: half of what the prototype found between any two
/// equally good models.
const LEAST_GAIN: f64 = 0.02;
/// Repetitions behind an energy score.
const REPETITIONS: usize = 40;
/// Significant digits kept of angles and places.
const DIGITS: i32 = 6;

/// Movements that are told apart.
#[derive(Debug, Clone)]
struct Found {
    low: Vec<LowMovement>,
    /// Mode of each low trial.
    of: BTreeMap<usize, usize>,
    /// Mean (trunk, knees) of each mode, deg.
    means: [Vector2<f64>; 2],
    people: usize,
    /// Height of the hand (rest frame, over stature) that is low.
    below: f64,
}

/// Learns the modes of a person or of several; none where they are not told apart, or where that does not
/// predict what was left out better.
///
/// # Errors
/// Where the chain is singular in the data.
pub(super) fn learn_modes(
    dataset: &Dataset,
    law: &Law,
    repetitions: &LearnedRepetitions,
    settings: &TrainSettings,
) -> Result<Option<Modes>, InputError> {
    if !repetitions.is_pulled || !law.law.processes.is_empty() || law.law.primitive.is_some() {
        return Ok(None);
    }
    let Some(found) = find(dataset) else { return Ok(None) };
    match left_out_energies(dataset, law, repetitions, settings)? {
        Some([one, told]) if told < (1.0 - LEAST_GAIN) * one => {
            found.learn(dataset, law, repetitions, settings).map(Some)
        }
        _ => Ok(None),
    }
}

/// What a model says of its modes.
pub(super) fn modes_note(modes: &Modes) -> String {
    let of = |k: usize| {
        let count: f64 = modes.low.iter().map(|m| m.memberships[k]).sum();
        let mode = &modes.all[k];
        format!(
            "trunk {:.0} and knees {:.0} deg ({count:.0} of {} low movements)",
            mode.trunk_deg,
            mode.knees_deg,
            modes.low.len()
        )
    };
    format!(
        "two ways of reaching down are told apart, as that predicts what was left out better: {}, and {}; \
         which one occurs goes by where the hand is from the feet, as it did in these recordings",
        of(0),
        of(1)
    )
}

impl Found {
    /// What one mode is learned from: its low movements and all that are not low.
    fn part(&self, dataset: &Dataset, k: usize) -> Dataset {
        let is_own = |f: &Frame| self.of.get(&f.trial).is_none_or(|m| *m == k);
        let frames = dataset.frames.iter().enumerate();
        dataset.part(&frames.filter(|(_, f)| is_own(f)).map(|(i, _)| i).collect::<Vec<_>>())
    }

    /// A law with its postures for each mode.
    fn learn(
        &self,
        dataset: &Dataset,
        law: &Law,
        repetitions: &LearnedRepetitions,
        settings: &TrainSettings,
    ) -> Result<Modes, InputError> {
        let mode = |k: usize| {
            let part = self.part(dataset, k);
            let (law, postures) = learn_part(&part, law, repetitions, settings)?;
            let [trunk_deg, knees_deg] = [0, 1].map(|i| rounded(self.means[k][i], DIGITS));
            Ok(Mode { trunk_deg, knees_deg, law, postures })
        };
        let all = (0..2).map(mode).collect::<Result<Vec<_>, InputError>>()?;
        let short = |m: &LowMovement| LowMovement {
            place: m.place.map(|x| rounded(x, DIGITS)),
            memberships: m.memberships.iter().map(|p| (p * 1e6).round() / 1e6).collect(),
        };
        let low = self.low.iter().map(short).collect();
        Ok(Modes { all, low, people: self.people, below: rounded(self.below, DIGITS) })
    }
}

/// Tells the low movements apart; none where a mode would have too few.
fn find(dataset: &Dataset) -> Option<Found> {
    let measurer = dataset.measurer.as_ref()?;
    let stature_m = dataset.coupling.stature_m();
    let below = measurer.height(LOW_LEGS) / stature_m;
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    let mut trials: BTreeMap<usize, Vec<&Frame>> = BTreeMap::new();
    for frame in all {
        trials.entry(frame.trial).or_default().push(frame);
    }
    let mut low = Vec::new();
    for (trial, frames) in trials {
        let place = low_place(frames.iter().map(|f| &f.hand), stature_m);
        if place[1] < below {
            low.push((
                trial,
                frames[0].person,
                place,
                at_lowest(&frames, |f| {
                    let seen = measurer.measure(f.q.as_slice());
                    Vector2::new(seen[1], seen[4])
                }),
            ));
        }
    }
    let points: Vec<Vector2<f64>> = low.iter().map(|l| l.3).collect();
    let (means, shares) = two_gaussians(&points)?;
    // The one with the straighter knees first.
    let order = if means[0][1] <= means[1][1] { [0, 1] } else { [1, 0] };
    let means = order.map(|k| means[k]);
    let shares: Vec<[f64; 2]> = shares.iter().map(|s| order.map(|k| s[k])).collect();
    let of: BTreeMap<usize, usize> =
        low.iter().zip(&shares).map(|((trial, ..), s)| (*trial, usize::from(s[1] > 0.5))).collect();
    let people: BTreeSet<usize> = low.iter().map(|l| l.1).collect();
    let enough = |k: usize| {
        let own = || low.iter().filter(|l| of[&l.0] == k);
        let theirs = own().map(|l| l.1).collect::<BTreeSet<_>>().len();
        own().count() >= FEWEST && theirs >= people.len().min(2)
    };
    let moved = |((_, _, place, _), shares): (&(usize, usize, [f64; 3], _), &[f64; 2])| {
        LowMovement { place: *place, memberships: shares.to_vec() }
    };
    let movements = low.iter().zip(&shares).map(moved).collect();
    (enough(0) && enough(1)).then_some(Found {
        low: movements,
        of,
        means,
        people: people.len(),
        below,
    })
}

/// Mean of something over the lowest tenth of the frames.
fn at_lowest(frames: &[&Frame], of: impl Fn(&Frame) -> Vector2<f64>) -> Vector2<f64> {
    let mut sorted = frames.to_vec();
    sorted.sort_by(|a, b| a.hand.translation.y.total_cmp(&b.hand.translation.y));
    let count = ((LOWEST * frames.len() as f64).ceil() as usize).max(1);
    sorted.iter().take(count).map(|f| of(f)).sum::<Vector2<f64>>() / count as f64
}

/// Means of two Gaussians, and the share that each has of every point.
type Mixed = ([Vector2<f64>; 2], Vec<[f64; 2]>);

/// Means of two Gaussians, and how much of each every point is; none for fewer than two points.
fn two_gaussians(points: &[Vector2<f64>]) -> Option<Mixed> {
    let count = points.len();
    if count < 2 {
        return None;
    }
    let centre: Vector2<f64> = points.iter().sum::<Vector2<f64>>() / count as f64;
    let scatter: Matrix2<f64> =
        points.iter().map(|p| (p - centre) * (p - centre).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let axis = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    let mut shares: Vec<[f64; 2]> = points
        .iter()
        .map(|p| if (p - centre).dot(&axis) > 0.0 { [1.0, 0.0] } else { [0.0, 1.0] })
        .collect();
    let mut means = [centre; 2];
    for _ in 0..ITERATIONS {
        let mut log_weights = [(0.0, Matrix2::identity()); 2];
        for k in 0..2 {
            let own: f64 = shares.iter().map(|s| s[k]).sum();
            let weighted = |p: (&Vector2<f64>, &[f64; 2])| p.0 * p.1[k];
            let sum: Vector2<f64> = points.iter().zip(&shares).map(weighted).sum();
            means[k] = (sum + centre * 1e-6) / (own + 1e-6);
            let outer = |(p, s): (&Vector2<f64>, &[f64; 2])| {
                (p - means[k]) * (p - means[k]).transpose() * s[k]
            };
            let spread: Matrix2<f64> = points.iter().zip(&shares).map(outer).sum();
            let prior = Matrix2::identity() * (PRIOR_MOVEMENTS * PRIOR_SD_DEG.powi(2));
            let covariance = (spread + prior) / (own + PRIOR_MOVEMENTS);
            let share: f64 = (own + 1.0) / (count as f64 + 2.0);
            log_weights[k] =
                (share.ln() - 0.5 * covariance.determinant().ln(), covariance.try_inverse()?);
        }
        let before = shares.clone();
        for (p, s) in points.iter().zip(&mut shares) {
            let log = [0, 1].map(|k| {
                let off = p - means[k];
                log_weights[k].0 - 0.5 * off.dot(&(log_weights[k].1 * off))
            });
            let second = 1.0 / (1.0 + (log[0] - log[1]).exp());
            *s = [1.0 - second, second];
        }
        if before.iter().zip(&shares).all(|(a, b)| (a[0] - b[0]).abs() < 1e-9) {
            break;
        }
    }
    Some((means, shares))
}

/// Mean energy scores (deg) of movements that were left out, by people or movements: of one law, and of modes;
/// repetitions are drawn as in a plan. None where nothing can be left out, or where modes are found not in all
/// parts of the data: then there are too few people to speak of any.
fn left_out_energies(
    dataset: &Dataset,
    law: &Law,
    repetitions: &LearnedRepetitions,
    settings: &TrainSettings,
) -> Result<Option<[f64; 2]>, InputError> {
    let Some(measurer) = &dataset.measurer else { return Ok(None) };
    let stature_m = dataset.coupling.stature_m();
    let judge = |fold: &Fold| -> Result<Option<Vec<[f64; 2]>>, InputError> {
        let train = dataset.part(&fold.train);
        let Some(found) = find(&train) else { return Ok(None) };
        let (one, postures) = learn_part(&train, law, repetitions, settings)?;
        let modes = found.learn(&train, law, repetitions, settings)?;
        let one = Modelled::of((&one, &postures), None).ok_or_else(singular)?.strangers();
        let told = Modelled::of((&modes.all[0].law, &modes.all[0].postures), Some(&modes));
        let told = told.ok_or_else(singular)?.strangers();
        let test = dataset.select(&fold.test);
        let of = |run: &Vec<&Frame>| -> [f64; 2] {
            let seen: Vec<Features> =
                run.iter().map(|f| measurer.measure(f.q.as_slice())).collect();
            let energy = |people: &Modelled| {
                let how = (settings.seed, REPETITIONS);
                let walks = Strangers::along(people, dataset, run, how).features(measurer);
                mean_energy_deg(&walks, &seen)
            };
            let plain = energy(&one);
            let is_low = modes.at(low_place(run.iter().map(|f| &f.hand), stature_m)).is_some();
            [plain, if is_low { energy(&told) } else { plain }]
        };
        Ok(Some(runs(&test).iter().filter(|run| run.len() > 2).map(of).collect()))
    };
    let judged: Result<Option<Vec<_>>, InputError> =
        dataset.held_out().par_iter().map(judge).collect();
    let Some(all) = judged?.map(|folds| folds.concat()) else { return Ok(None) };
    let means = [0, 1].map(|i| mean(&all.iter().map(|e| e[i]).collect::<Vec<f64>>()));
    Ok((!all.is_empty()).then_some(means))
}

/// The law and the postures of a part of the data.
fn learn_part(
    part: &Dataset,
    law: &Law,
    repetitions: &LearnedRepetitions,
    settings: &TrainSettings,
) -> Result<(PostureLaw, PostureDistribution), InputError> {
    let frames: Vec<&Frame> = part.frames.iter().collect();
    let known = Some(std::slice::from_ref(law));
    let own = learn_laws(&[law.method], &frames, part.coupling.stature_m(), settings, known)?;
    let own = own.into_iter().next().ok_or_else(singular)?;
    let repetitions = repetitions_of_part(part, &own, repetitions, settings)?;
    Ok(learn_way(part, own, &repetitions, settings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Side};
    use crate::math::Pose;
    use crate::math::stream::{Purpose, normals, stream};
    use crate::posture::{Method, StartRule, natural_grip, start_postures};
    use crate::training::dataset::Trial;
    use crate::training::motion_file::trial_of;
    use crate::training::rollout_check::learn_repetitions;
    use nalgebra::DVector;
    use std::path::Path;

    /// Mean of a way of reaching down by the names of joints.
    fn about(joints: &[String], wanted: &[(&str, f64)]) -> DVector<f64> {
        let of = |j: &String| wanted.iter().find(|(n, _)| j == n).map_or(0.0, |(_, v)| *v);
        DVector::from_iterator(joints.len(), joints.iter().map(of))
    }

    /// Angles that a way is about, and where its hand is: [ahead, to the right].
    type Way<'a> = (&'a [(&'a str, f64)], [f64; 2]);

    const STOOP: [(&str, f64); 5] = [
        ("pelvis_forward", -0.1),
        ("jPelvis_Z", -0.9),
        ("jL5S1_Z", -0.3),
        ("jL4L3_Z", -0.2),
        ("jRightElbow_Z", 0.3),
    ];
    const SQUAT: [(&str, f64); 5] = [
        ("pelvis_up", -0.45),
        ("pelvis_forward", -0.1),
        ("jPelvis_Z", -0.4),
        ("jL5S1_Z", -0.2),
        ("jRightElbow_Z", 0.3),
    ];

    /// People who reach down here and there, the first of each pair of movements in one way and the second in
    /// another.
    fn people(ways: [Way; 2]) -> Dataset {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let still = trial_of("still".to_owned(), 30.0, &vec![vec![0.0; 80]; 30]);
        let mut moved = still;
        for (t, row) in moved.q.iter_mut().enumerate() {
            row[28] = 0.01 * t as f64;
        }
        moved.qdot.iter_mut().for_each(|row| row[28] = 0.3);
        let coupling = Dataset::new(&[moved], &body, Side::Right).unwrap().coupling;
        let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
        let movement = |person: u64, number: usize| -> Trial {
            let (wanted, [ahead, right]) = ways[number % 2];
            let covariance = nalgebra::DMatrix::identity(30, 30) * 0.08f64.powi(2);
            let postures = PostureDistribution::anywhere(about(&joints, wanted), covariance);
            let mut rng = stream(person, Purpose::Simulation, number as u32, 0);
            let off = normals(&mut rng, 3);
            let hand = natural_grip(-0.35);
            let low = Pose::from_parts(
                nalgebra::Translation3::new(
                    ahead + 0.03 * off[0],
                    -0.72 + 0.03 * off[1],
                    right + 0.03 * off[2],
                ),
                hand,
            );
            let starts = start_postures(
                &coupling,
                &postures,
                &StartRule::Sampled,
                low,
                (person, number as u32),
                0..8,
            );
            let end = starts.into_iter().find_map(|s| s.q).unwrap();
            let rise: Vec<f64> = (0..30).map(|t| f64::from(t) / 29.0).collect();
            let columns: Vec<Vec<f64>> = (0..30)
                .map(|c| {
                    let share = |s: &f64| s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
                    rise.iter().map(|s| end[c] * share(s)).collect()
                })
                .collect();
            trial_of(format!("{person} {number}"), 30.0, &columns)
        };
        let groups: Vec<Vec<Trial>> =
            (1..=3).map(|p| (0..8).map(|n| movement(p, n)).collect()).collect();
        Dataset::of_people(&groups, &body, Side::Right).unwrap()
    }

    /// The law of all, and what repetitions of it need.
    fn all_together(dataset: &Dataset) -> (Law, LearnedRepetitions) {
        let settings = TrainSettings::default();
        let all: Vec<&Frame> = dataset.frames.iter().collect();
        let every: Vec<usize> = (0..all.len()).collect();
        let stature_m = dataset.coupling.stature_m();
        let law = learn_laws(&[Method::FullW], &all, stature_m, &settings, None).unwrap().remove(0);
        let repetitions = learn_repetitions(dataset, &every, &law, &settings).unwrap();
        // Straight lines of made-up postures need no pull; people do.
        (law, LearnedRepetitions { is_pulled: true, ..repetitions })
    }

    fn learned(dataset: &Dataset) -> Option<Modes> {
        let (law, repetitions) = all_together(dataset);
        learn_modes(dataset, &law, &repetitions, &TrainSettings::default()).unwrap()
    }

    #[test]
    fn who_stoops_and_squats_is_told_apart_and_learned_apart() {
        let dataset = people([(&STOOP, [0.45, 0.25]), (&SQUAT, [0.45, 0.45])]);
        let found = find(&dataset).expect("two modes");
        assert_eq!((found.low.len(), found.people), (24, 3));
        // Movements alternate, the straighter knees first.
        assert!(found.of.iter().all(|(trial, mode)| *mode == trial % 2), "{:?}", found.of);
        let [stoop, squat] = found.means;
        assert!(squat[1] > stoop[1] + 20.0 && stoop[0] > squat[0] + 15.0, "{stoop} {squat}");
        let (law, repetitions) = all_together(&dataset);
        let modes = found.learn(&dataset, &law, &repetitions, &TrainSettings::default()).unwrap();
        // Each mode's usual posture at a place where both were is its own.
        let (h, measurer) = (dataset.coupling.stature_m(), dataset.measurer.as_ref().unwrap());
        let low = dataset.frames.iter().filter(|f| f.hand.translation.y < -0.65);
        let knees_off = |k: usize, f: &Frame| {
            let usual = modes.all[k].law.attraction.as_ref().unwrap().usual_posture(&f.hand, h);
            (measurer.measure(usual.posture.as_slice())[4] - measurer.measure(f.q.as_slice())[4])
                .abs()
        };
        let (mut own, mut other) = (0.0, 0.0);
        for f in low {
            own += knees_off(f.trial % 2, f);
            other += knees_off(1 - f.trial % 2, f);
        }
        assert!(own < 0.5 * other, "{own} {other}");
        let at = |right: f64| modes.at([0.45 / h, -0.72 / h, right / h]).unwrap().shares[1];
        assert!(at(0.2) < 0.3 && at(0.5) > 0.7, "{} {}", at(0.2), at(0.5));
        // Nowhere near, half of them squat; a hand at the hips is not low.
        assert!((at(-3.0) - 0.5).abs() < 0.02);
        assert!(modes.at([0.3, 0.0, 0.1]).is_none());
    }

    #[test]
    fn modes_that_predict_nobody_better_are_not_used() {
        // The place of the hand tells all: one law knows it as well, from twice the movements.
        let by_place = people([(&STOOP, [0.45, 0.15]), (&SQUAT, [0.45, 0.5])]);
        assert!(find(&by_place).is_some());
        assert!(learned(&by_place).is_none());
        // Who always does the same has no modes.
        assert!(learned(&people([(&STOOP, [0.45, 0.15]), (&STOOP, [0.45, 0.5])])).is_none());
    }

    #[test]
    fn two_heaps_of_points_are_told_apart() {
        let heap = |x: f64, y: f64| {
            (0..10).map(move |i| {
                let a = f64::from(i) * 0.628;
                Vector2::new(x + 5.0 * a.cos(), y + 5.0 * a.sin())
            })
        };
        let points: Vec<Vector2<f64>> = heap(109.0, 64.0).chain(heap(69.0, 132.0)).collect();
        let (means, shares) = two_gaussians(&points).unwrap();
        let stoop = usize::from(shares[0][1] > 0.5);
        assert!((means[stoop] - Vector2::new(109.0, 64.0)).norm() < 0.1, "{means:?}");
        assert!(shares[..10].iter().all(|s| s[stoop] > 0.99));
        assert!(shares[10..].iter().all(|s| s[stoop] < 0.01));
        assert!(two_gaussians(&points[..1]).is_none());
    }
}

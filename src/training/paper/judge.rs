//! All methods on all training sets: learned on the same frames, judged on the same held-out movements.

use super::against::{against, weight_agreement};
use super::horizon::{Walk, curve, walk};
use super::result::{
    Chain, ChainResult, MethodOnSet, MovementScore, PaperResult, SetResult, SetSize,
};
use super::sets::{PaperExperiment, TrainingSet};
use super::spread::posture_spread;
use super::summary::summary;
use crate::files::InputError;
use crate::human::PELVIS_JOINTS;
use crate::math::redundancy::null_space_basis;
use crate::math::stats::{mean, normal_quantile};
use crate::posture::{Floors, Method, Prediction};
use crate::training::dataset::runs;
use crate::training::evaluate::{TASK_FLOOR, group, learn_with_noise, predictions};
use crate::training::methods::Law;
use crate::training::rollout_check::{ROLLOUTS, bands, pieces, sampled_law};
use crate::training::{Bands, Dataset, Fold, Frame, TrainSettings, Trial};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is asked of the training sets of an experiment.
#[derive(Debug, Clone)]
pub struct PaperQuestion {
    /// Which experiment.
    pub experiment: PaperExperiment,
    /// Whether nobody was recorded.
    pub simulated: bool,
    /// Whether other people teach.
    pub by_others: bool,
    /// What of the body is predicted.
    pub chains: Vec<Chain>,
    /// The methods.
    pub methods: Vec<Method>,
    /// Those of which bands of repetitions are asked, which costs most.
    pub banded: Vec<Method>,
}

/// Runs an experiment on its training sets; none when told to stop. `told` hears how many of how many methods
/// are done. A chain is left out where some movement does not hold it.
///
/// # Errors
/// Where a set is too short, nothing moves, or a chain is singular in the data.
pub fn run_paper(
    sets: &[TrainingSet],
    question: &PaperQuestion,
    settings: &TrainSettings,
    told: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Result<Option<PaperResult>, InputError> {
    settings.check()?;
    let done = AtomicUsize::new(0);
    let chains: Vec<Chain> =
        question.chains.iter().copied().filter(|c| sets.iter().all(|s| holds(s, *c))).collect();
    if chains.is_empty() {
        return Err(InputError::new("recordings", "do not all hold both legs")
            .remedy("leave out --chain whole, or the recordings without legs"));
    }
    let total = chains.len() * sets.len() * question.methods.len();
    let mut found = Vec::new();
    for chain in chains {
        let prepared: Result<Vec<Prepared>, InputError> =
            sets.par_iter().map(|set| Prepared::new(set, chain)).collect();
        let prepared = prepared?;
        let jobs: Vec<(usize, Method)> =
            (0..sets.len()).flat_map(|s| question.methods.iter().map(move |m| (s, *m))).collect();
        // The order in which they are worked off does not matter: each has random streams of its own.
        let judged: Result<Vec<Option<MethodOnSet>>, InputError> = jobs
            .into_par_iter()
            .map(|(s, method)| {
                if !told(done.load(Ordering::Relaxed), total) {
                    return Ok(None);
                }
                let is_banded = question.banded.contains(&method);
                let own = prepared[s].judged(method, is_banded, settings)?;
                done.fetch_add(1, Ordering::Relaxed);
                Ok(Some(own))
            })
            .collect();
        let Some(judged) = judged?.into_iter().collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let mut result = chain_result(chain, sets, &prepared, judged, question.methods.len());
        for (m, method) in question.methods.iter().enumerate() {
            if question.banded.contains(method) {
                let shown = middle_set(&result, m);
                let own = (&sets[shown], &prepared[shown]);
                result.spreads.push(posture_spread(own, *method, settings)?);
            }
        }
        found.push(result);
    }
    told(total, total);
    Ok(Some(PaperResult {
        experiment: question.experiment,
        simulated: question.simulated,
        taught_by_others: question.by_others,
        seed: settings.seed,
        chains: found,
    }))
}

fn chain_result(
    chain: Chain,
    sets: &[TrainingSet],
    prepared: &[Prepared],
    judged: Vec<MethodOnSet>,
    methods: usize,
) -> ChainResult {
    let mut judged = judged.into_iter();
    let results: Vec<SetResult> = sets
        .iter()
        .zip(prepared)
        .map(|(set, own)| SetResult {
            who: set.who.clone(),
            task: set.task.clone(),
            train: own.size(&own.fold.train),
            test: own.size(&own.fold.test),
            rank: participation_rank(&own.dataset.select(&own.fold.train)),
            methods: judged.by_ref().take(methods).collect(),
        })
        .collect();
    let walks = |m: usize| -> Vec<&Walk> {
        let movements = results.iter().flat_map(|s| &s.methods[m].movements);
        movements.filter_map(|s| s.walk.as_ref()).collect()
    };
    let name = |m: usize| results.first().map_or("", |s| s.methods[m].method.name());
    ChainResult {
        chain,
        joints: prepared.first().map_or_else(Vec::new, |p| p.dataset.joints.clone()),
        methods: (0..methods).filter_map(|m| summary(&results, m)).collect(),
        against: against(&results),
        weights: weight_agreement(&results),
        horizon: (0..methods).map(|m| curve(name(m), &walks(m))).collect(),
        spreads: Vec::new(),
        sets: results,
    }
}

/// The set whose relative RMSE is the median of all by the `m`-th method: neither the best nor the worst.
fn middle_set(result: &ChainResult, m: usize) -> usize {
    let mut order: Vec<usize> = (0..result.sets.len()).collect();
    let error = |s: usize| result.sets[s].methods[m].relative_rmse_q;
    order.sort_by(|a, b| error(*a).total_cmp(&error(*b)));
    order[order.len() / 2]
}

/// Whether all movements of a set hold a chain.
fn holds(set: &TrainingSet, chain: Chain) -> bool {
    let all = set.train.iter().flatten().chain(&set.test);
    chain == Chain::Arm || all.flat_map(|t| &t.q).all(|q| q.len() > arm_joints(set))
}

/// Joints between pelvis and hand.
fn arm_joints(set: &TrainingSet) -> usize {
    set.body.arm(set.side).map_or(usize::MAX, |arm| arm.dof())
}

/// A training set on a chain.
pub(super) struct Prepared {
    pub dataset: Dataset,
    pub fold: Fold,
    /// Names of the trials, those that teach first.
    pub names: Vec<String>,
}

impl Prepared {
    pub(super) fn new(set: &TrainingSet, chain: Chain) -> Result<Self, InputError> {
        let arm = arm_joints(set);
        let on_chain = |trial: &Trial| {
            let mut own = trial.clone();
            let is_whole = own.q.first().is_some_and(|q| q.len() == arm + PELVIS_JOINTS.len());
            if chain == Chain::Arm && is_whole {
                own.leave_pelvis();
            }
            own
        };
        let mut people: Vec<Vec<Trial>> =
            set.train.iter().map(|own| own.iter().map(on_chain).collect()).collect();
        let taught: usize = people.iter().map(Vec::len).sum();
        let test: Vec<Trial> = set.test.iter().map(on_chain).collect();
        let dataset = match &mut people[..] {
            // One person's own.
            [own] if !set.is_by_others => {
                own.extend(test);
                Dataset::new(own, &set.body, set.side)?
            }
            _ => {
                people.push(test);
                Dataset::of_people(&people, &set.body, set.side)?
            }
        };
        let names = people.iter().flatten().map(|t| t.source.clone()).collect();
        let part = |teaches: bool| -> Vec<usize> {
            let all = dataset.frames.iter().enumerate();
            all.filter(|(_, f)| (f.trial < taught) == teaches).map(|(i, _)| i).collect()
        };
        let fold = Fold { train: part(true), test: part(false) };
        Ok(Self { dataset, fold, names })
    }

    fn size(&self, part: &[usize]) -> SetSize {
        let frames = self.dataset.select(part);
        let distinct =
            |of: fn(&Frame) -> usize| frames.iter().map(|f| of(f)).collect::<BTreeSet<_>>().len();
        SetSize {
            people: distinct(|f| f.person),
            movements: distinct(|f| f.trial),
            frames: frames.len(),
        }
    }

    /// Learns a method and judges it.
    fn judged(
        &self,
        method: Method,
        is_banded: bool,
        settings: &TrainSettings,
    ) -> Result<MethodOnSet, InputError> {
        let Self { dataset, fold, .. } = self;
        let law = learn_with_noise(dataset, &fold.train, method, settings, false)?;
        let test = dataset.select(&fold.test);
        let floors = Floors {
            task: DVector::from_element(dataset.task_rows(), TASK_FLOOR * TASK_FLOOR),
            null_rad_s: settings.null_floor_rad_s,
        };
        let predicted = predictions(dataset, &test, &law, &floors)?;
        let trials: BTreeSet<usize> = test.iter().map(|f| f.trial).collect();
        let movements: Vec<MovementScore> = trials
            .into_iter()
            .map(|trial| {
                let rows = test.iter().copied().zip(&predicted).filter(|(f, _)| f.trial == trial);
                self.movement(trial, rows.collect(), &law, &floors)
            })
            .collect();
        let learns = method.identifies_weights();
        let surprise = over_frames(&movements, |s| s.surprise);
        let free = (dataset.joints.len() - dataset.task_rows()) as f64;
        let ll_null = over_frames(&movements, |s| s.ll_null);
        Ok(MethodOnSet {
            method,
            relative_rmse_q: relative_rmse(&movements),
            ll_q: over_frames(&movements, |s| s.ll_q),
            surprise,
            ll_rescaled: ll_null + 0.5 * free * (surprise - surprise.ln() - 1.0),
            weights: learns.then(|| over_geometric_mean(&law.law.weight)),
            bands: if is_banded { Some(self.banded(&law, settings)?) } else { None },
            movements,
        })
    }

    fn movement(
        &self,
        trial: usize,
        rows: Vec<(&Frame, &Prediction)>,
        law: &Law,
        floors: &Floors,
    ) -> MovementScore {
        let frames: Vec<&Frame> = rows.iter().map(|r| r.0).collect();
        let velocity_coverage = [0.5, 0.9].map(|share| covered(&rows, share));
        let surprise = mean(&rows.iter().map(surprise).collect::<Vec<_>>());
        let score = group(rows, floors);
        let longest = runs(&frames).into_iter().rev().max_by_key(Vec::len);
        MovementScore {
            movement: self.names[trial].clone(),
            frames: score.rows,
            ll_q: score.ll_q,
            ll_null: score.ll_null,
            surprise,
            rmse_q: score.rmse_q,
            relative_rmse_q: score.relative_rmse_q,
            ll_x: score.ll_x,
            rmse_x: score.rmse_x,
            velocity_coverage,
            walk: longest.and_then(|run| walk(&self.dataset.coupling, &law.law, &run)),
        }
    }

    /// What bands of repetitions along the held-out paths hold.
    fn banded(&self, law: &Law, settings: &TrainSettings) -> Result<Bands, InputError> {
        let Self { dataset, fold, .. } = self;
        let (sampled, _) = sampled_law(dataset, &fold.train, law, settings)?;
        let paths = pieces(&dataset.select(&fold.test));
        let how = (settings.seed, settings.sampling);
        Ok(bands(dataset, &sampled, &paths, ROLLOUTS, how)?.0)
    }
}

/// Squared residual of one frame within the null space in units of its variance, by dimension; NaN where that is
/// not positive definite.
fn surprise((frame, p): &(&Frame, &Prediction)) -> f64 {
    let v = null_space_basis(&frame.jacobian);
    let inside = v.tr_mul(&(&frame.qdot - &p.mean));
    let factor = v.tr_mul(&(&p.covariance * &v)).cholesky();
    factor.map_or(f64::NAN, |f| f.solve(&inside).dot(&inside) / inside.len() as f64)
}

/// Share of joint velocities inside the central band that should hold `share` of them.
fn covered(rows: &[(&Frame, &Prediction)], share: f64) -> f64 {
    let reach = normal_quantile(0.5 + 0.5 * share);
    let one = |(frame, p): &(&Frame, &Prediction)| {
        let off = &frame.qdot - &p.mean;
        let inside = |(i, d): (usize, &f64)| {
            f64::from(u8::from(d.abs() <= reach * p.covariance[(i, i)].sqrt()))
        };
        mean(&off.iter().enumerate().map(inside).collect::<Vec<_>>())
    };
    mean(&rows.iter().map(one).collect::<Vec<_>>())
}

/// Over all frames of some movements: root of the summed squares over those of the recorded velocities.
fn relative_rmse(movements: &[MovementScore]) -> f64 {
    let (mut off, mut size) = (0.0, 0.0);
    for s in movements {
        let square = s.frames as f64 * s.rmse_q.powi(2);
        off += square;
        size += square / s.relative_rmse_q.powi(2).max(f64::MIN_POSITIVE);
    }
    (off / size.max(f64::MIN_POSITIVE)).sqrt()
}

fn over_frames(movements: &[MovementScore], pick: fn(&MovementScore) -> f64) -> f64 {
    let frames: f64 = movements.iter().map(|s| s.frames as f64).sum();
    movements.iter().map(|s| s.frames as f64 * pick(s)).sum::<f64>() / frames
}

fn over_geometric_mean(weight: &DMatrix<f64>) -> Vec<f64> {
    let logs: Vec<f64> = weight.diagonal().iter().map(|w| w.ln()).collect();
    let middle = mean(&logs);
    logs.iter().map(|l| (l - middle).exp()).collect()
}

/// In how many directions joints move, roughly.
fn participation_rank(frames: &[&Frame]) -> f64 {
    let n = frames.first().map_or(0, |f| f.qdot.len());
    let mut moment = DMatrix::zeros(n, n);
    for f in frames {
        moment.ger(1.0, &f.qdot, &f.qdot, 1.0);
    }
    let square = moment.norm_squared();
    if square > 0.0 { moment.trace().powi(2) / square } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Side};
    use crate::training::SimulatedMovements;
    use crate::training::paper::{Performer, Task, training_sets};
    use std::path::Path;

    /// Somebody who reaches about, six times in each of two tasks.
    fn performer(name: &str, seed: u64) -> Performer {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let source = SimulatedMovements::new(&body, Side::Right, true, seed).unwrap();
        let mut reaches = source.first(8).unwrap().into_iter();
        let tasks = ["one", "two"].map(|name| Task {
            name: name.to_owned(),
            is_primitive: true,
            repetitions: (0..4)
                .filter_map(|i| Some(reaches.next()?.sparse_trial(format!("{name} {i}"))))
                .collect(),
        });
        let (side, tasks) = (Side::Right, tasks.to_vec());
        Performer { name: name.to_owned(), body, side, is_seated: false, tasks }
    }

    fn question(experiment: PaperExperiment) -> PaperQuestion {
        PaperQuestion {
            experiment,
            simulated: true,
            by_others: experiment == PaperExperiment::Exp3,
            chains: Chain::ALL.to_vec(),
            methods: vec![Method::PlainIk, Method::MiNsgp, Method::FullW, Method::Gp],
            banded: vec![Method::FullW],
        }
    }

    fn run(experiment: PaperExperiment) -> PaperResult {
        let people = [performer("a", 3), performer("b", 4)];
        let question = question(experiment);
        let sets = training_sets(experiment, &people, question.by_others).unwrap();
        let settings = TrainSettings { search_samples: 40, ..TrainSettings::default() };
        run_paper(&sets, &question, &settings, &|_, _| true).unwrap().unwrap()
    }

    #[test]
    fn all_experiments_are_run_on_both_chains() {
        for experiment in [PaperExperiment::Exp1, PaperExperiment::Exp2, PaperExperiment::Exp3] {
            let found = run(experiment);
            assert_eq!(found.chains.len(), 2);
            for (chain, joints) in found.chains.iter().zip([24, 30]) {
                assert_eq!((chain.joints.len(), chain.sets.len()), (joints, 4));
                let of = |m: Method| chain.methods.iter().find(|s| s.method == m).unwrap();
                let (plain, full) = (of(Method::PlainIk), of(Method::FullW));
                assert!(full.relative_rmse_q.median < plain.relative_rmse_q.median);
                assert!(full.rmse_x.median < 1e-9 && of(Method::Gp).rmse_x.median > 1e-3);
                let held = full.bands.unwrap();
                assert!(held.coverage_50 < held.coverage_90 && plain.bands.is_none());
                let [half, most] = full.velocity_coverage;
                assert!(0.2 < half && half < most && most <= 1.0, "{half} {most}");
                assert_eq!(chain.against.len(), 3);
                assert_eq!(chain.weights.len(), 2);
                let set = &chain.sets[0];
                let people = set.train.people;
                assert_eq!((people, set.methods.len()), (1, 4));
                assert!(set.rank > 1.0 && set.rank < joints as f64);
                for own in &set.methods {
                    // The best scale can only help, and 1 is one of the scales.
                    let size = set.test.frames as f64;
                    let null = own.movements.iter().map(|s| s.frames as f64 * s.ll_null);
                    let null = null.sum::<f64>() / size;
                    assert!(own.ll_rescaled >= null - 1e-9 && own.surprise > 0.0);
                }
                // Who does not look at the hand loses it.
                let far = |i: usize| chain.horizon[i].points.last().unwrap().hand_mm;
                assert!(far(2) < 20.0 && far(3) > 2.0 * far(2), "{} {}", far(2), far(3));
                assert!(chain.horizon[2].points[0].joints_deg > 0.0);
                let [shown] = &chain.spreads[..] else { panic!("one method has bands") };
                let frames = shown.time_s.len();
                assert_eq!((shown.method, shown.recorded.len()), (Method::FullW, frames));
                assert!(
                    shown.samples.iter().all(|s| s.len() == frames) && shown.samples.len() > 20
                );
                for curve in &shown.scores {
                    // All begin in the recorded posture.
                    assert!((curve.mean[0] - curve.recorded[0]).abs() < 1e-9);
                    assert!(curve.quantiles[0].last() <= curve.quantiles[4].last());
                }
            }
        }
    }

    #[test]
    fn the_same_whatever_the_number_of_threads_and_none_when_told_to_stop() {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(PaperExperiment::Exp1))
        };
        assert_eq!(with(1), with(3));
        let people = [performer("a", 3)];
        let sets = training_sets(PaperExperiment::Exp1, &people, false).unwrap();
        let settings = TrainSettings::default();
        let found = run_paper(&sets, &question(PaperExperiment::Exp1), &settings, &|_, _| false);
        assert!(found.unwrap().is_none());
    }

    #[test]
    fn a_chain_that_some_movement_does_not_hold_is_left_out() {
        let mut person = performer("a", 3);
        person.tasks[0].repetitions.iter_mut().for_each(Trial::leave_pelvis);
        let sets = training_sets(PaperExperiment::Exp1, &[person], false).unwrap();
        assert!(!holds(&sets[0], Chain::Whole) && holds(&sets[1], Chain::Whole));
        let whole = PaperQuestion { chains: vec![Chain::Whole], ..question(PaperExperiment::Exp1) };
        let refused = run_paper(&sets, &whole, &TrainSettings::default(), &|_, _| true);
        assert!(refused.unwrap_err().to_string().contains("both legs"));
        let arm = Prepared::new(&sets[1], Chain::Arm).unwrap();
        assert_eq!((arm.dataset.joints.len(), arm.names.len()), (24, 4));
        assert_eq!(arm.size(&arm.fold.train).movements, 2);
    }
}

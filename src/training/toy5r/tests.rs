//! The 5R problem against a reference data set made by another program, and its trajectories.

#![allow(clippy::print_stdout, reason = "says the figures it judges")]

use super::*;
use crate::files::{NumericTable, read_text};
use crate::kinematics::{Frames, Linkage, read_urdf};
use crate::math::redundancy::oblique_projector;
use crate::math::stats::{mean, std_dev};
use crate::skips::shared;

fn rms(x: &[f64]) -> f64 {
    mean(&x.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt()
}

/// The reference data set, where it is at hand.
fn reference() -> Option<ToyProblem> {
    let path = shared("toy5r/seed0.csv")?;
    let table = NumericTable::read(&path).unwrap();
    let about = read_text(&path.with_extension("json")).unwrap();
    let about: serde_json::Value = serde_json::from_str(&about).unwrap();
    let five = |row: &Vec<f64>, from: usize| std::array::from_fn(|i| row[from + i]);
    let q: Vec<[f64; JOINTS]> = table.rows.iter().map(|r| five(r, 0)).collect();
    Some(ToyProblem {
        constants: ToyConstants::default(),
        q0: q[0],
        q,
        xdot: table.rows.iter().map(|r| [r[5], r[6]]).collect(),
        qdot: table.rows.iter().map(|r| five(r, 7)).collect(),
        train: table.rows.iter().map(|r| r[12] > 0.5).collect(),
        w_true: serde_json::from_value(about["w_true"].clone()).unwrap(),
        restarts: 0,
    })
}

/// What a data set looks like in a few figures.
#[derive(Debug)]
struct Look {
    /// Rms of all joint velocities, rad/s.
    qdot: f64,
    /// Rms of all task velocities, m/s.
    xdot: f64,
    /// Standard deviation of the joint angles, mean over joints, rad.
    spread: f64,
    /// Smallest singular value of J over all rows, m/rad.
    singular: f64,
}

impl Look {
    fn of(problem: &ToyProblem) -> Self {
        let joint = |i: usize| problem.q.iter().map(|q| q[i]).collect::<Vec<_>>();
        let singular = problem
            .q
            .iter()
            .map(|q| smallest_singular_value(&planar_jacobian(&problem.constants.links, q)));
        Self {
            qdot: rms(problem.qdot.as_flattened()),
            xdot: rms(problem.xdot.as_flattened()),
            spread: mean(&(0..JOINTS).map(|i| std_dev(&joint(i))).collect::<Vec<_>>()),
            singular: singular.fold(f64::INFINITY, f64::min),
        }
    }
}

/// Largest |J qdot - xdot|, m/s, and what is left of the velocities when the law without its noise is
/// taken off, in units of the noise that the law lets through.
fn law_errors(problem: &ToyProblem) -> (f64, f64) {
    let law = Law::new(&problem.constants, &problem.w_true);
    let (mut worst, mut left, mut expected) = (0.0_f64, 0.0, 0.0);
    for ((q, xdot), qdot) in problem.q.iter().zip(&problem.xdot).zip(&problem.qdot) {
        let jacobian = planar_jacobian(&problem.constants.links, q);
        let moved = &jacobian * DVector::from_row_slice(qdot) - DVector::from_row_slice(xdot);
        worst = worst.max(moved.amax());
        let without = law.velocity(q, *xdot, &[0.0; JOINTS]).unwrap();
        left += (0..JOINTS).map(|i| (qdot[i] - without[i]).powi(2)).sum::<f64>();
        let inverse = weighted_pseudo_inverse(&jacobian, &law.weight).unwrap();
        let projector = oblique_projector(&jacobian, &inverse);
        expected += projector.norm_squared() * problem.constants.sigma_z.powi(2);
    }
    (worst, (left / expected).sqrt())
}

#[test]
fn the_law_explains_the_reference_and_our_own() {
    let own =
        [ToyConstants::default(), ToyConstants::low_noise()].map(|c| generate(0, &c).unwrap());
    let sets = own.map(Some).into_iter().chain([reference()]);
    for problem in sets.flatten() {
        assert_eq!(problem.q.len(), 1000);
        assert_eq!(problem.train.iter().filter(|t| **t).count(), 700);
        let (worst, noise) = law_errors(&problem);
        assert!(worst < 1e-12, "{worst}");
        assert!((noise - 1.0).abs() < 0.05, "{noise}");
        // The postures follow from the velocities, with the acceleration noise between them.
        let dt = problem.constants.dt_s;
        let push: Vec<f64> = (1..problem.q.len())
            .filter(|&t| problem.q[t] != problem.q0)
            .flat_map(|t| {
                let (q, was, qdot) = (problem.q[t], problem.q[t - 1], problem.qdot[t - 1]);
                std::array::from_fn::<f64, JOINTS, _>(|i| (q[i] - was[i] - qdot[i] * dt) / dt / dt)
            })
            .collect();
        assert!((rms(&push) / problem.constants.sigma_a - 1.0).abs() < 0.05, "{}", rms(&push));
    }
}

#[test]
fn ten_seeds_look_like_the_reference() {
    let constants = ToyConstants::default();
    let problems: Vec<ToyProblem> = (0..10).map(|s| generate(s, &constants).unwrap()).collect();
    let looks: Vec<Look> = problems.iter().map(Look::of).collect();
    for (look, problem) in looks.iter().zip(&problems) {
        println!("{look:?} restarts {} W {:.2?}", problem.restarts, problem.w_true);
        assert!(look.singular >= constants.singular_threshold);
        assert!(problem.restarts <= 10, "{}", problem.restarts);
        assert!(problem.w_true.iter().all(|w| (0.05..=1.95).contains(w)));
    }
    let more = (10..200).map(|s| generate(s, &constants).unwrap().restarts).sum::<usize>();
    println!("{more} restarts in 190 further data sets");
    assert!(more < 190);
    let Some(reference) = reference().map(|r| Look::of(&r)) else { return };
    println!("reference {reference:?}");
    let of = |pick: fn(&Look) -> f64| mean(&looks.iter().map(pick).collect::<Vec<_>>());
    assert!((of(|l| l.xdot) / reference.xdot - 1.0).abs() < 0.05);
    // Weights and start differ from seed to seed, so that these two are alike only roughly.
    assert!((0.6..1.6).contains(&(of(|l| l.qdot) / reference.qdot)));
    assert!((0.5..2.0).contains(&(of(|l| l.spread) / reference.spread)));
}

#[test]
fn seeds_name_problems() {
    let constants = ToyConstants::default();
    let first = generate(3, &constants).unwrap();
    assert_eq!(first, generate(3, &constants).unwrap());
    let other = generate(4, &constants).unwrap();
    assert!(first.w_true != other.w_true && first.q0 != other.q0 && first.train != other.train);
    assert!(generate(3, &ToyConstants { dt_s: -1.0, ..constants.clone() }).is_err());
    // A chain that cannot bend has no regular posture; this must end.
    let stiff = ToyConstants { q0_range_deg: 1e-3, ..constants };
    assert!(generate(3, &stiff).unwrap_err().to_string().contains("start posture"));
}

#[test]
fn singular_postures_start_again() {
    let constants = ToyConstants { singular_threshold: 0.18, ..ToyConstants::default() };
    let problem = generate(3, &constants).unwrap();
    let again = problem.q.iter().skip(1).filter(|q| **q == problem.q0).count();
    println!("{again} restarts");
    assert!(again > 0);
    assert_eq!(again, problem.restarts);
    assert!(Look::of(&problem).singular >= 0.18);
}

fn truth(noise: ToyNoise, dt_s: f64) -> TrajectoryTruth {
    TrajectoryTruth::draw(1, &ToyConstants::default(), noise, dt_s).unwrap()
}

const KINDS: [ToyNoise; 3] =
    [ToyNoise::White, ToyNoise::Correlated { tau_s: 0.4 }, ToyNoise::PersonalOffset];

#[test]
fn trajectories_follow_their_paths_away_from_singular_postures() {
    for seed in 0..5 {
        let constants = ToyConstants::default();
        for (noise, dt_s) in KINDS.into_iter().flat_map(|n| [(n, 0.2), (n, 0.04)]) {
            let truth = TrajectoryTruth::draw(seed, &constants, noise, dt_s).unwrap();
            let all = trajectories(seed + 100, &truth).unwrap();
            assert_eq!(all.len(), 70);
            let (mut miss, mut singular, mut speed) = (0.0_f64, f64::INFINITY, Vec::new());
            for t in &all {
                assert_eq!(t.q.len(), (4.0 / dt_s).round() as usize + 1);
                assert_eq!((t.time_s.len(), t.hand_path.len()), (t.q.len(), t.q.len()));
                assert_eq!((t.xdot.len() + 1, t.qdot.len() + 1), (t.q.len(), t.q.len()));
                for (q, goal) in t.q.iter().zip(&t.hand_path) {
                    let at = planar_hand(&constants.links, q);
                    miss = miss.max((at[0] - goal[0]).hypot(at[1] - goal[1]));
                    let jacobian = planar_jacobian(&constants.links, q);
                    singular = singular.min(smallest_singular_value(&jacobian));
                }
                speed.extend(t.xdot.iter().flatten());
            }
            let speed = rms(&speed);
            println!("{seed} {noise:?} {dt_s}: miss {miss:.1e} m, {singular:.2} m, {speed:.3} m/s");
            // The step's own curvature is all that the hand misses; the next step makes it good.
            assert!(miss < 2.0 * dt_s * dt_s, "{miss}");
            assert!(singular > 5.0 * constants.singular_threshold, "{singular}");
            assert!((0.1..0.25).contains(&speed), "{speed}");
        }
    }
}

#[test]
fn hand_paths_do_not_depend_on_noise_or_step() {
    let coarse = trajectories(7, &truth(KINDS[0], 0.2)).unwrap();
    let fine = trajectories(7, &truth(KINDS[2], 0.04)).unwrap();
    for (a, b) in coarse.iter().zip(&fine) {
        assert_eq!(a.q[0], b.q[0]);
        for (p, q) in a.hand_path.iter().zip(b.hand_path.iter().step_by(5)) {
            assert!((p[0] - q[0]).abs() + (p[1] - q[1]).abs() < 1e-12);
        }
    }
    let fewer = trajectories(7, &TrajectoryTruth { count: 3, ..truth(KINDS[0], 0.2) }).unwrap();
    assert_eq!(fewer[..], coarse[..3]);
}

#[test]
fn longer_noise_spreads_the_oracle_wider() {
    let mut widths = Vec::new();
    for (noise, dt_s) in KINDS.into_iter().flat_map(|n| [(n, 0.2), (n, 0.04)]) {
        let truth = truth(noise, dt_s);
        let one = &trajectories(7, &TrajectoryTruth { count: 1, ..truth.clone() }).unwrap()[0];
        let samples = oracle_rollouts(one, &truth, 400, 9).unwrap();
        let last = |i: usize| samples.iter().map(|q| q[q.len() - 1][i]).collect::<Vec<_>>();
        let sd = mean(&(0..JOINTS).map(|i| std_dev(&last(i))).collect::<Vec<_>>()).to_degrees();
        println!("{noise:?} dt {dt_s}: sd of the last posture {sd:.2} deg");
        widths.push(sd);
    }
    let [white, white_fine, ou, ou_fine, offset, offset_fine] = widths[..] else { panic!() };
    // White noise of a fixed standard deviation spreads as the root of the step.
    assert!((white / white_fine - 5.0_f64.sqrt()).abs() < 0.3, "{white} {white_fine}");
    assert!((ou / ou_fine - 1.0).abs() < 0.15, "{ou} {ou_fine}");
    assert!((offset / offset_fine - 1.0).abs() < 0.15, "{offset} {offset_fine}");
    assert!(white < ou && ou < offset);
}

#[test]
fn the_truth_lies_in_its_own_band() {
    // Share of joint angles inside the central 90 % band of the oracle: 0.9 by construction.
    for noise in KINDS {
        let truth = TrajectoryTruth { count: 30, ..truth(noise, 0.2) };
        let mut inside = Vec::new();
        for t in trajectories(11, &truth).unwrap() {
            let samples = oracle_rollouts(&t, &truth, 200, 12).unwrap();
            for k in 1..t.q.len() {
                for i in 0..JOINTS {
                    let all: Vec<f64> = samples.iter().map(|s| s[k][i]).collect();
                    let low = crate::math::stats::quantile(&all, 0.05);
                    let high = crate::math::stats::quantile(&all, 0.95);
                    inside.push(f64::from(u8::from((low..=high).contains(&t.q[k][i]))));
                }
            }
        }
        println!("{noise:?}: {:.3}", mean(&inside));
        assert!((mean(&inside) - 0.9).abs() < 0.07, "{noise:?} {}", mean(&inside));
    }
}

#[test]
fn the_reference_description_is_the_same_chain() {
    let Some(path) = shared("toy5r/planar5r.urdf") else { return };
    let linkage = Linkage::chain(&read_urdf(&path).unwrap(), BASE, TIP).unwrap();
    let problem = generate(2, &ToyConstants::default()).unwrap();
    let mut frames = Frames::default();
    for q in problem.q.iter().step_by(50) {
        linkage.forward(q, &mut frames);
        let own = planar_jacobian(&problem.constants.links, q);
        assert!((linkage.stacked_jacobian(&frames).rows(0, 2) - own).norm() < 1e-13);
    }
}

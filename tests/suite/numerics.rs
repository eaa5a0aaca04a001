//! What must hold whatever the numbers: random bodies, holds, postures and cells, and inputs that have no extent.

use crate::fuzz::made::{BENCH, request};
use ergopath::ergonomics::ScoringMethod;
use ergopath::human::{Body, BodySize, Sex, Side};
use ergopath::kinematics::Frames;
use ergopath::math::redundancy::{oblique_projector, weighted_pseudo_inverse};
use ergopath::math::stream::{Purpose, normals, stream};
use ergopath::math::{Pose, Vec3};
use ergopath::planner::{CandidateResult, RunResult, Status, plan};
use ergopath::posture::{
    Coupling, HandPath, Hold, PostureModel, Sampler, Sampling, Start, StartRule, condition,
    roll_out, simulated_person, start_postures,
};
use ergopath::robot::Robot;
use ergopath::scenario::{Scenario, parse_scenario, read_user_path};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use std::path::Path;

const HOLDS: [Hold; 3] = [Hold::Rigid, Hold::FreeRoll, Hold::Point];

/// Somebody of any size with habits of their own.
struct Somebody {
    body: Body,
    side: Side,
    model: PostureModel,
    coupling: Coupling,
}

fn somebody(number: u32) -> Somebody {
    let mut rng = stream(31, Purpose::Simulation, 0, number);
    let sex = if rng.random_bool(0.5) { Sex::Female } else { Sex::Male };
    let stature_m: f64 = rng.random_range(1.4..2.1);
    let mass_kg = rng.random_range(18.0..36.0) * stature_m * stature_m;
    let body = Body::of_size("somebody", BodySize { sex, stature_m, mass_kg }).unwrap();
    let side = if rng.random_bool(0.5) { Side::Right } else { Side::Left };
    let model = simulated_person(&body, side, Some(u64::from(number))).unwrap();
    let coupling = Coupling::new(&body, side, HOLDS[number as usize % 3]).unwrap();
    Somebody { body, side, model, coupling }
}

impl Somebody {
    /// A posture inside the limits.
    fn posture(&self, number: u32) -> DVector<f64> {
        let mut rng = stream(32, Purpose::Simulation, 0, number);
        let p = &self.model.postures;
        let factor = p.covariance.clone().cholesky().unwrap().l();
        loop {
            let q = &p.mean + &factor * DVector::from_vec(normals(&mut rng, p.mean.len()));
            if self.coupling.limits().violation(q.as_slice()) == 0.0 {
                return q;
            }
        }
    }

    /// The grip at a posture, by the chain of the body alone.
    fn grip(&self, q: &DVector<f64>) -> Pose {
        let arm = self.body.arm(self.side).unwrap();
        let mut frames = Frames::default();
        arm.forward(q.as_slice(), &mut frames);
        arm.tip_pose(&frames, 0)
    }

    /// How far a grip is from where it should be, m, and how far it is turned in what the hold prescribes, rad.
    fn off(&self, is: &Pose, wanted: &Pose) -> (f64, f64) {
        let metres = (is.translation.vector - wanted.translation.vector).norm();
        let turned = match self.coupling.hold() {
            Hold::Rigid => is.rotation.angle_to(&wanted.rotation),
            Hold::FreeRoll => (is.rotation * Vec3::z()).angle(&(wanted.rotation * Vec3::z())),
            Hold::Point | Hold::Planar => 0.0,
        };
        (metres, turned)
    }
}

#[test]
fn hands_of_anybody_stay_on_the_robot_within_the_limits_of_the_body() {
    let (mut rollouts, mut whole) = (0, 0);
    for number in 0..24 {
        let who = somebody(number);
        // From one posture to another, so that somebody can follow.
        let (a, b) = (who.posture(2 * number), who.posture(2 * number + 1));
        let smooth = |s: f64| s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        let hands: Vec<Pose> =
            (0..=40).map(|i| who.grip(&(&a + smooth(f64::from(i) / 40.0) * (&b - &a)))).collect();
        let time: Vec<f64> = (0..=40).map(|i| 0.1 * f64::from(i)).collect();
        let postures = &who.model.postures;
        let starts =
            start_postures(&who.coupling, postures, &StartRule::Sampled, hands[0], (7, 0), 0..4);
        let path = HandPath::new(&who.coupling, &who.model.law, time, hands.clone());
        let sampler = Sampler::new(&who.model.law, Sampling::Pathwise).unwrap();
        for (r, start) in starts.iter().enumerate().filter(|(_, s)| s.q.is_some()) {
            let mut rng = stream(33, Purpose::Posture, number, r as u32);
            let draw = sampler.draw(&mut rng, &path);
            let done = roll_out(&who.coupling, &who.model.law, &path, start, Some(&draw));
            let reached = done.reach_exceeded_at.unwrap_or(done.q.len());
            rollouts += 1;
            whole += usize::from(reached == done.q.len());
            for (k, q) in done.q.iter().enumerate() {
                assert!(q.iter().all(|v| v.is_finite()), "{number} {r} {k}");
                assert!(who.coupling.limits().violation(q.as_slice()) < 1e-9, "{number} {r} {k}");
            }
            for (k, (q, hand)) in done.q.iter().zip(&hands).take(reached).enumerate() {
                let (metres, turned) = who.off(&who.grip(q), hand);
                assert!(metres < 1e-3, "{number} {r} {k}: {metres} m");
                // What is reported is what is.
                assert!(metres <= done.max_residual_m + 1e-9, "{number} {r} {k}");
                assert!(turned <= done.max_residual_rad + 1e-6, "{number} {r} {k}: {turned}");
                assert!(turned < 0.02, "{number} {r} {k}: {turned} rad");
            }
            assert!(done.rms_residual_m <= done.max_residual_m + 1e-15);
        }
    }
    assert!(rollouts >= 80 && 10 * whole >= 8 * rollouts, "{whole} of {rollouts}");
}

#[test]
fn what_is_free_of_anybody_does_not_move_the_hand() {
    const STEP: f64 = 1e-5;
    let mut frames = Frames::default();
    for number in 0..60 {
        let who = somebody(number);
        let q = who.posture(number);
        let seen = who.coupling.observe(&q, &mut frames);
        let (j, w) = (&seen.jacobian, &who.model.law.weight);
        let (m, n) = j.shape();
        let inverse = weighted_pseudo_inverse(j, w).unwrap();
        let free = oblique_projector(j, &inverse);
        let scale = j.amax();
        assert!((j * &free).amax() < 1e-9 * scale, "{number}: J N");
        assert!((&free * &free - &free).amax() < 1e-8, "{number}: N N = N");
        assert!((j * &inverse - DMatrix::identity(m, m)).amax() < 1e-9, "{number}");
        // As many free motions as joints less rows.
        assert!((free.trace() - (n - m) as f64).abs() < 1e-8, "{number}: {}", free.trace());
        // Least in the metric of the weight: nothing is gained by adding a free motion.
        let mut rng = stream(34, Purpose::Simulation, 0, number);
        let asked = DVector::from_vec(normals(&mut rng, m));
        let least = &inverse * &asked;
        let any = &free * DVector::from_vec(normals(&mut rng, n));
        let by_weight = w.clone().cholesky().unwrap();
        let product = least.dot(&by_weight.solve(&any));
        let size = least.norm() * by_weight.solve(&any).norm();
        assert!(product.abs() < 1e-8 * size, "{number}: {product} of {size}");
        // The hand itself, by the chain alone: a free step leaves it, to second order.
        let step = &any * (STEP / any.norm());
        let (metres, turned) = who.off(&who.grip(&(&q + &step)), &who.grip(&q));
        assert!(metres < 1e-8 && turned < 1e-7, "{number}: {metres} m, {turned} rad");
        // While the same step without the projection does move it.
        let asked_step = &least * (STEP / least.norm());
        let (metres, turned) = who.off(&who.grip(&(&q + &asked_step)), &who.grip(&q));
        assert!(metres + turned > 1e-8, "{number}: {metres} m, {turned} rad");
    }
}

#[test]
fn what_the_hand_tells_leaves_less_spread_and_never_less_than_none() {
    let mut frames = Frames::default();
    for number in 0..60 {
        let who = somebody(number);
        let seen = who.coupling.observe(&who.posture(number), &mut frames);
        let (j, w) = (&seen.jacobian, &who.model.law.weight);
        let mut rng = stream(36, Purpose::Simulation, 0, number);
        let mut draw = |count: usize| DVector::from_vec(normals(&mut rng, count));
        let (preferred, task) = (draw(j.ncols()), draw(j.nrows()));
        let told = condition(j, w, &preferred, &task).unwrap();
        assert!((j * &told.mean - &task).norm() < 1e-9 * task.norm().max(1.0), "{number}");
        let size = w.amax();
        let least = |m: &DMatrix<f64>| (0.5 * (m + m.transpose())).symmetric_eigenvalues().min();
        assert!((&told.covariance - told.covariance.transpose()).amax() < 1e-12 * size, "{number}");
        assert!(least(&told.covariance) > -1e-10 * size, "{number}");
        assert!(least(&(w - &told.covariance)) > -1e-10 * size, "{number}: knowing adds no spread");
        // Of the hand itself nothing is left open.
        assert!((j * &told.covariance).amax() < 1e-9 * size * j.amax(), "{number}");
    }
    for name in ["demo_operator", "whole_operator", "people"] {
        let (model, _) = ergopath::posture::load_model(name, Path::new(".")).unwrap();
        let p = &model.postures;
        for spread in [Some(&p.covariance), p.about_usual.as_ref()].into_iter().flatten() {
            assert!(spread.clone().cholesky().is_some(), "{name}");
        }
        assert!(model.law.weight.clone().cholesky().is_some(), "{name}");
    }
}

#[test]
fn from_a_straight_arm_the_hand_is_followed_or_said_to_be_lost() {
    for number in 0..12 {
        let who = somebody(number);
        // Upright with the arm hanging straight down: the elbow and the rank of the arm are at their ends.
        let (lower, upper) = (&who.coupling.limits().lower, &who.coupling.limits().upper);
        let zero = lower.iter().zip(upper).map(|(low, high)| 0.0f64.max(*low).min(*high));
        let q = DVector::from_iterator(lower.len(), zero);
        assert!(who.coupling.limits().violation(q.as_slice()) < 1e-9);
        let here = who.grip(&q);
        let time: Vec<f64> = (0..=40).map(|i| 0.1 * f64::from(i)).collect();
        // The y axis of the rest frame is up; nobody's hand goes a metre down with the pelvis at rest.
        for (down_m, can_be) in [(0.0, true), (-0.05, true), (1.0, false)] {
            let hands: Vec<Pose> = (0..=40)
                .map(|i| {
                    let mut hand = here;
                    hand.translation.vector.y -= down_m * f64::from(i) / 40.0;
                    hand
                })
                .collect();
            let path = HandPath::new(&who.coupling, &who.model.law, time.clone(), hands.clone());
            let start = Start { q: Some(q.clone()), distance: 0.0, is_unusual: false, mode: None };
            let done = roll_out(&who.coupling, &who.model.law, &path, &start, None);
            let reached = done.reach_exceeded_at.unwrap_or(done.q.len());
            assert!(can_be || reached < done.q.len(), "{number}: {down_m} m down");
            assert!(down_m != 0.0 || reached == done.q.len(), "{number}: at rest");
            for (k, (q, hand)) in done.q.iter().zip(&hands).enumerate() {
                assert!(who.coupling.limits().violation(q.as_slice()) < 1e-9, "{number} {k}");
                assert!(k >= reached || who.off(&who.grip(q), hand).0 < 1e-3, "{number} {k}");
            }
        }
    }
}

/// The bench with other places, another duration, load and robot.
fn cell(number: u32) -> Scenario {
    let mut rng = stream(35, Purpose::Simulation, 0, number);
    let mut draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let place = |p: [f64; 3]| format!("position_m = {p:?}");
    let start = [draw(0.38, 0.5), draw(-0.45, -0.2), draw(0.9, 1.2)];
    let goal = [draw(0.38, 0.5), draw(0.1, 0.4), draw(0.95, 1.35)];
    let text = BENCH
        .replace("position_m = [0.42, -0.35, 0.95]", &place(start))
        .replace("position_m = [0.45, 0.25, 1.25]", &place(goal))
        .replace("duration_s = 4.0", &format!("duration_s = {:.2}", draw(3.0, 9.0)))
        .replace("part_mass_kg = 1.5", &format!("part_mass_kg = {:.2}", draw(0.0, 12.0)))
        .replace("\"panda\"", ["\"panda\"", "\"fr3\""][number as usize % 2]);
    parse_scenario(Path::new("cell.toml"), &text).unwrap()
}

#[test]
fn results_of_any_cell_are_within_bounds_and_add_up() {
    let mut scored = 0;
    for number in 0..6 {
        let scenario = cell(number);
        let result = plan(&scenario, &request(), &|_| true).unwrap();
        for candidate in &result.candidates {
            scored += usize::from(!candidate.bodies.is_empty());
            scores_are_sound(candidate, number);
            path_is_sound(candidate, &scenario, number);
        }
        best_is_least(&result, number);
    }
    assert!(scored >= 12, "{scored}");
}

fn scores_are_sound(candidate: &CandidateResult, number: u32) {
    let id = format!("{number}, `{}`", candidate.id);
    for body in &candidate.bodies {
        assert!((0.0..=1.0).contains(&body.reach_exceeded), "{id}");
        assert!((0.0..=1.0).contains(&body.extrapolation_share), "{id}");
        assert!(body.hand_residual_max_mm < 1.0, "{id}");
        for method in ScoringMethod::ALL {
            let s = &body.scores[method];
            let d = &s.distribution;
            let worst = f64::from(method.worst());
            for v in [d.expected, d.median, d.p05, d.p95, d.cvar90, s.per_metre, s.peak] {
                assert!((1.0 - 1e-9..=worst + 1e-9).contains(&v), "{id}: {v}");
            }
            assert!(d.p05 <= d.median && d.median <= d.p95, "{id}");
            // The mean of the worst tenth is no less than the mean.
            assert!(d.cvar90 >= d.expected - 1e-9, "{id}");
            let mean = s.by_rollout.iter().sum::<f64>() / s.by_rollout.len() as f64;
            assert!((mean - d.expected).abs() < 1e-9, "{id}: {mean} and {}", d.expected);
            let sum: f64 = s.levels.iter().map(|l| l.share).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{id}: shares of levels add up to {sum}");
            // Shares at a level or above are sums of those from it on, and fall.
            let mut above = 0.0;
            for level in s.levels.iter().rev() {
                above += level.share;
                assert!((above - level.exposure).abs() < 1e-9, "{id}: level {}", level.level);
            }
            for falling in [&d.exposure, &d.p_at_least] {
                assert!(falling.iter().all(|v| (0.0..=1.0 + 1e-9).contains(v)), "{id}");
                assert!(falling.windows(2).all(|w| w[1] <= w[0] + 1e-9), "{id}");
            }
            // The expected score is the sum of the shares of time at each score from 1 on or above.
            let expected: f64 = d.exposure[1..].iter().sum();
            assert!((expected - d.expected).abs() < 1e-9, "{id}: {expected}");
        }
    }
}

/// What is called feasible keeps its limits when speeds and distances are measured anew.
fn path_is_sound(candidate: &CandidateResult, scenario: &Scenario, number: u32) {
    let id = format!("{number}, `{}`", candidate.id);
    let (Some(path), Status::Feasible) = (&candidate.path, &candidate.status) else { return };
    let at = |t: &[f64; 7]| Vec3::new(t[0], t[1], t[2]);
    let (first, last) = (at(&path.tcp[0]), at(&path.tcp[path.tcp.len() - 1]));
    assert!((first - scenario.start.translation.vector).norm() < 1e-6, "{id}");
    assert!((last - scenario.goal.translation.vector).norm() < 1e-6, "{id}");
    let times = path.time_s.windows(2).zip(path.tcp.windows(2));
    for (t, p) in times {
        // The mean speed between two samples is no more than the greatest.
        let speed = (at(&p[1]) - at(&p[0])).norm() / (t[1] - t[0]);
        assert!(speed <= scenario.limits.speed_m_s * (1.0 + 1e-6), "{id}: {speed} m/s");
    }
    let space = scenario.limits.workspace.as_ref().unwrap();
    for t in &path.tcp {
        let inside = (0..3).all(|i| t[i] >= space.min[i] - 1e-6 && t[i] <= space.max[i] + 1e-6);
        assert!(inside, "{id}: {t:?}");
    }
    // The robot's joints are within their limits, and its tool is where the path says.
    let robot = &scenario.robot;
    for (q, t) in path.robot_q.iter().zip(&path.tcp) {
        for (i, v) in q.iter().enumerate() {
            let (low, high) = (robot.limits.lower[i], robot.limits.upper[i]);
            assert!((low - 1e-9..=high + 1e-9).contains(v), "{id}: joint {i} at {v}");
        }
        let tool = ergopath::robot::tcp_pose(robot, q);
        assert!((tool.translation.vector - at(t)).norm() < 1e-3, "{id}");
    }
}

/// No path of the search that is feasible has a lower objective than the best.
fn best_is_least(result: &RunResult, number: u32) {
    let Some(best) = &result.verdict.best else { return };
    let objective = |c: &CandidateResult| c.objective;
    let of_best = result.candidates.iter().find(|c| c.id == *best).map(objective).unwrap();
    let ranked = result.candidates.iter().filter(|c| c.rank == Some(1));
    assert!(ranked.map(objective).all(|o| o == of_best), "{number}");
}

#[test]
fn paths_without_extent_are_answered_or_refused_in_words() {
    let room = tempfile::tempdir().unwrap();
    let file = room.path().join("path.csv");
    let robot = Robot::preset("panda").unwrap();
    let read = |rows: &[&str]| {
        let text = format!("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n{}\n", rows.join("\n"));
        std::fs::write(&file, text).unwrap();
        read_user_path("path", &file, &robot, None).map_err(|e| e.to_string())
    };
    let here = "0.4,0,1,0,1,0,0";
    for (rows, words) in [
        (vec![], "no rows"),
        (vec![format!("0,{here}")], "at least two samples"),
        (vec![format!("0,{here}"), format!("0,{here}")], "not later"),
        (vec![format!("1,{here}"), format!("0,{here}")], "not later"),
        (vec!["0,0.4,0,1,0,0,0,0".to_owned(), "1,0.4,0,1,0,0,0,0".to_owned()], "norm"),
    ] {
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let error = read(&rows).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{rows:?}: {error}");
    }
    // A hand that rests has no length, no speed, and no place that is not a number.
    let [a, b, c] = [0, 1, 2].map(|t| format!("{t},{here}"));
    let rests = read(&[&a, &b, &c]).unwrap();
    assert_eq!((rests.path.length_m(), rests.path.duration_s()), (0.0, 2.0));
    assert!(rests.path.velocities().iter().all(|v| v.norm() == 0.0));
}

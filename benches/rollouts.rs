//! Posture steps per second: rollouts of 24 joints along a lift, with attraction and noise.
//!
//! One path sample is one step of integration: the hand moves 4.4 mm from one to the next, and only
//! beyond 8 mm a step is divided.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

mod common;

use common::{body, operator, sparse};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ergopath::human::{Coupled, Hands, Pelvis, Side, Stance, mirrored_pose};
use ergopath::kinematics::{Frames, Linkage};
use ergopath::math::stream::{Purpose, stream};
use ergopath::math::{Pose, Vec3};
use ergopath::posture::{
    Coupling, Grips, HandPath, Hold, Method, PostureLaw, Sampler, Sampling, Start, StartRule,
    natural_grip, roll_out, simulated_operator, simulated_whole_operator, start_postures,
};
use ergopath::training::{TrainSettings, learn_laws};
use nalgebra::UnitQuaternion;
use std::hint::black_box;

const STEPS: usize = 100;
const DT_S: f64 = 0.04;

/// A lift by 35 cm to the side and 25 cm up.
fn lift() -> Vec<Pose> {
    // Thumb up, wrist behind: z to y, y to -x of the pelvis frame.
    let turn = UnitQuaternion::from_basis_unchecked(&[-Vec3::z(), -Vec3::x(), Vec3::y()]);
    (0..=STEPS)
        .map(|i| {
            let s = i as f64 / STEPS as f64;
            let at = Vec3::new(0.38 + 0.06 * s, 0.02 + 0.35 * s, 0.02 + 0.25 * s);
            Pose::from_parts(at.into(), turn)
        })
        .collect()
}

/// The law of full-w-gp with an exact process of `count` samples.
fn with_process(law: &PostureLaw, count: usize) -> PostureLaw {
    let dataset = operator(count);
    let settings = TrainSettings::default();
    let stature = dataset.coupling.stature_m();
    let learned =
        learn_laws(&[Method::FullWGp], &sparse(&dataset), stature, &settings, None).unwrap();
    let processes = learned[0].law.processes.clone();
    assert_eq!(processes[0].centre_count(), count);
    PostureLaw { processes, ..law.clone() }
}

fn rollouts(c: &mut Criterion) {
    let body = body();
    let model = simulated_operator(&body, Side::Right).unwrap();
    let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
    let hands = lift();
    let time: Vec<f64> = (0..=STEPS).map(|i| DT_S * i as f64).collect();
    let rule = StartRule::Sampled;
    let starts = start_postures(&coupling, &model.postures, &rule, hands[0], (1, 0), 0..8);
    let learned = with_process(&model.law, 1000);

    let mut group = c.benchmark_group("posture");
    let mut draws = 0;
    for (name, law) in [("full-w", &model.law), ("full-w-gp of N = 1000", &learned)] {
        let path = HandPath::new(&coupling, law, time.clone(), hands.clone());
        let sampler = Sampler::new(law, Sampling::Pathwise).unwrap();
        let people: Vec<_> = (0..starts.len() as u32)
            .map(|r| sampler.draw(&mut stream(1, Purpose::Posture, 1, r), &path))
            .collect();
        // Who loses the path would walk fewer steps than are counted.
        let walkers: Vec<(&Start, _)> = starts
            .iter()
            .zip(&people)
            .filter(|(s, p)| {
                roll_out(&coupling, law, &path, s, Some(*p)).reach_exceeded_at.is_none()
            })
            .collect();
        assert!(walkers.len() > starts.len() / 2, "hardly anybody can follow the lift");
        group.throughput(Throughput::Elements(STEPS as u64));
        group.bench_function(format!("rollout of 100 steps, {name}, attraction, noise"), |b| {
            let mut r = 0;
            b.iter(|| {
                r = (r + 1) % walkers.len();
                let (start, person) = walkers[r];
                roll_out(&coupling, law, &path, start, Some(person))
            });
        });
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("one person's functions, {name}"), |b| {
            b.iter(|| {
                draws += 1;
                sampler.functions(&mut stream(1, Purpose::Posture, 2, draws))
            });
        });
    }
    group.bench_function("noise of one person, 101 samples", |b| {
        b.iter(|| model.law.noise.path(&mut stream(1, Purpose::Posture, 1, 0), STEPS + 1, DT_S));
    });
    let process = &learned.processes[0];
    let x = process.reduce(model.postures.mean.as_slice(), &[0.1; 6]);
    group.bench_function("mean of a process, N = 1000, D = 30, 24 joints", |b| {
        b.iter(|| process.mean(black_box(&x)));
    });
    group.bench_function("one start posture", |b| {
        b.iter(|| start_postures(&coupling, &model.postures, &rule, hands[0], (1, 0), 0..1));
    });
    group.finish();
}

/// One step of a whole standing person, with one hand and with both: pelvis, spine and arms; the legs follow.
fn whole_person(c: &mut Criterion) {
    let body = body();
    let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
    let one_handed = simulated_whole_operator(&body, Side::Right).unwrap();
    let mut group = c.benchmark_group("whole person");
    group.throughput(Throughput::Elements(STEPS as u64));
    for hands in [Hands::Right, Hands::Both] {
        let is_both = hands == Hands::Both;
        let model = one_handed.adapted(Pelvis::Moves, is_both).unwrap();
        let coupled = Coupled { hands, pelvis: Pelvis::Moves };
        let holds = vec![Hold::Rigid; hands.sides().len()];
        let coupling = Coupling::of_person(&body, coupled, &holds, standing).unwrap();
        let time: Vec<f64> = (0..=STEPS).map(|i| DT_S * i as f64).collect();
        let path: Vec<Grips> = (0..=STEPS)
            .map(|i| {
                let s = i as f64 / STEPS as f64;
                let at = Vec3::new(0.38 + 0.06 * s, 0.02 + 0.25 * s, 0.18 - 0.02 * s);
                let first = Pose::from_parts(at.into(), natural_grip(at.y));
                Grips { first, second: is_both.then(|| mirrored_pose(&first)) }
            })
            .collect();
        let starts =
            start_postures(&coupling, &model.postures, &StartRule::Sampled, path[0], (1, 0), 0..16);
        let hand = HandPath::new(&coupling, &model.law, time, path);
        let sampler = Sampler::new(&model.law, Sampling::Pathwise).unwrap();
        let draw = |r| sampler.draw(&mut stream(1, Purpose::Posture, 1, r), &hand);
        let walkers: Vec<_> = (0..)
            .zip(&starts)
            .map(|(r, s)| (s, draw(r)))
            .filter(|(s, p)| {
                roll_out(&coupling, &model.law, &hand, s, Some(p)).reach_exceeded_at.is_none()
            })
            .collect();
        assert!(walkers.len() > starts.len() / 2, "hardly anybody can follow the lift");
        group.bench_function(format!("rollout of 100 steps, full-w, {hands:?}"), |b| {
            let mut r = 0;
            b.iter(|| {
                r = (r + 1) % walkers.len();
                let (start, person) = &walkers[r];
                roll_out(&coupling, &model.law, &hand, start, Some(person))
            });
        });
    }
    group.finish();
}

fn kinematics(c: &mut Criterion) {
    let body = body();
    let arm = Linkage::chain(&body.model, "Pelvis", "RightGrip").unwrap();
    let q: Vec<f64> = (0..arm.dof()).map(|i| 0.02 * i as f64).collect();
    let mut frames = Frames::default();
    let mut jacobian = arm.jacobian(
        &{
            arm.forward(&q, &mut frames);
            frames.clone()
        },
        0,
    );
    let mut group = c.benchmark_group("kinematics");
    group.bench_function("FK and Jacobian of 24 joints", |b| {
        b.iter(|| {
            arm.forward(black_box(&q), &mut frames);
            arm.jacobian_into(&frames, 0, &mut jacobian);
            black_box(jacobian[(0, 0)])
        });
    });
    #[cfg(feature = "peers")]
    {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/human/female_p50.urdf");
        let chain = k::Chain::<f64>::from_urdf_file(file).unwrap();
        let serial = k::SerialChain::from_end(chain.find_link("RightGrip").unwrap());
        group.bench_function("the same by the crate k", |b| {
            b.iter(|| {
                serial.set_joint_positions_unchecked(black_box(&q));
                serial.update_transforms();
                k::jacobian(&serial)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, rollouts, whole_person, kinematics);
criterion_main!(benches);

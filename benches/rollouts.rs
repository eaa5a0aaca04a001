//! Posture steps per second: rollouts of 24 joints along a lift, with attraction and noise.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ergopath::human::{Body, Side};
use ergopath::kinematics::{Frames, Linkage};
use ergopath::math::stream::{Purpose, stream};
use ergopath::math::{Pose, Vec3};
use ergopath::posture::{
    Coupling, HandPath, Hold, StartRule, roll_out, simulated_operator, start_postures,
};
use nalgebra::UnitQuaternion;
use std::hint::black_box;
use std::path::Path;

const STEPS: usize = 100;

fn rollouts(c: &mut Criterion) {
    let body = Body::load("female_p50", Path::new(".")).unwrap();
    let model = simulated_operator(&body, Side::Right).unwrap();
    let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
    // Thumb up, wrist behind: z to y, y to -x of the pelvis frame.
    let turn = UnitQuaternion::from_basis_unchecked(&[-Vec3::z(), -Vec3::x(), Vec3::y()]);
    let hands: Vec<Pose> = (0..=STEPS)
        .map(|i| {
            let s = i as f64 / STEPS as f64;
            let at = Vec3::new(0.38 + 0.06 * s, 0.02 + 0.35 * s, 0.02 + 0.25 * s);
            Pose::from_parts(at.into(), turn)
        })
        .collect();
    let time: Vec<f64> = (0..=STEPS).map(|i| 0.04 * i as f64).collect();
    let rule = StartRule::Sampled;
    let starts = start_postures(&coupling, &model.postures, &rule, &hands[0], (1, 0), 8);
    let noise = model.noise.path(&mut stream(1, Purpose::Posture, 1, 0), STEPS + 1, 0.04);

    let path = HandPath::new(&coupling, &model, time, hands);
    let mut group = c.benchmark_group("posture");
    group.throughput(Throughput::Elements(STEPS as u64));
    group.bench_function("rollout of 100 steps, full W, attraction, noise", |b| {
        let mut r = 0;
        b.iter(|| {
            r = (r + 1) % starts.len();
            roll_out(&coupling, &model, &path, &starts[r], Some(&noise))
        });
    });
    group.throughput(Throughput::Elements(1));
    group.bench_function("one start posture", |b| {
        b.iter(|| start_postures(&coupling, &model.postures, &rule, path.start(), (1, 0), 1));
    });
    group.finish();
}

fn kinematics(c: &mut Criterion) {
    let body = Body::load("female_p50", Path::new(".")).unwrap();
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
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/human/female_p50.urdf");
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

criterion_group!(benches, rollouts, kinematics);
criterion_main!(benches);

//! How long RULA and REBA of one posture take: one thread, many different postures in turn.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use ergopath::ergonomics::{
    ArmAngles, ArmPose, BodyPose, Profile, Side, TaskInputs, TrunkNeckAngles, arm_angles, assess,
    trunk_neck_angles,
};
use ergopath::human::{Body, Coupled, Side as BodySide, Stance};
use ergopath::math::stream::{Purpose, stream};
use ergopath::math::{Rotation, Vec3};
use ergopath::survey::{HeadDraw, Lens, NeckRule, Scorable, Surveyor};
use nalgebra::DVector;
use rand::RngExt as _;
use std::hint::black_box;

/// Postures in one run, enough that no branch is learnt by heart.
const FRAMES: usize = 4096;

/// A rotation of up to `most` rad about a random axis, after `from`.
fn turned(from: &Rotation, most: f64, rng: &mut impl rand::Rng) -> Rotation {
    let by = Vec3::from_fn(|_, _| rng.random_range(-most..most) * 0.577);
    from * Rotation::from_scaled_axis(by)
}

fn poses() -> Vec<(BodyPose, ArmPose)> {
    let mut rng = stream(1, Purpose::Simulation, 910, 0);
    let upright = Rotation::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[
        Vec3::x(),
        Vec3::z(),
        -Vec3::y(),
    ]));
    let mut pose = || {
        let pelvis = turned(&upright, 0.3, &mut rng);
        let thorax = turned(&pelvis, 1.0, &mut rng);
        let head = turned(&thorax, 0.7, &mut rng);
        let upper_arm = turned(&thorax, 2.0, &mut rng);
        let forearm = turned(&upper_arm, 2.0, &mut rng);
        let hand = turned(&forearm, 0.7, &mut rng);
        let l5s1 = Vec3::new(0.0, 0.0, 1.0);
        let c7t1 = l5s1 + thorax * Vec3::new(0.0, 0.45, 0.0);
        let shoulder = c7t1 + thorax * Vec3::new(0.0, -0.05, 0.18);
        let elbow = shoulder + upper_arm * Vec3::new(0.0, -0.3, 0.0);
        let body = BodyPose { pelvis, thorax, head, l5s1, c7t1 };
        let arm = ArmPose {
            side: Side::Right,
            upper_arm,
            forearm,
            hand,
            shoulder,
            elbow,
            wrist: elbow + forearm * Vec3::new(0.0, -0.25, 0.0),
            sternoclavicular: c7t1 + thorax * Vec3::new(0.06, -0.06, 0.02),
            girdle_neutral_deg: 0.0,
            shoulder_lateral_m: 0.18,
        };
        (body, arm)
    };
    (0..FRAMES).map(|_| pose()).collect()
}

fn scores(c: &mut Criterion) {
    let poses = poses();
    let angles: Vec<(TrunkNeckAngles, ArmAngles)> =
        poses.iter().map(|(b, a)| (trunk_neck_angles(b), arm_angles(b, a))).collect();
    let task = TaskInputs { load_kg: 6.0, repeated_gt_4min: true, ..TaskInputs::default() };
    let profile = Profile::default();
    let mut group = c.benchmark_group("RULA and REBA of a frame");
    group.throughput(Throughput::Elements(FRAMES as u64));
    group.bench_function("from body angles", |b| {
        b.iter(|| {
            black_box(&angles)
                .iter()
                .map(|(body, arm)| {
                    let scored = assess(body, arm, &task, &profile);
                    u32::from(scored.rula.grand) + u32::from(scored.reba.total)
                })
                .sum::<u32>()
        });
    });
    group.bench_function("from rotations and points", |b| {
        b.iter(|| {
            black_box(&poses)
                .iter()
                .map(|(body, arm)| {
                    let (trunk, limb) = (trunk_neck_angles(body), arm_angles(body, arm));
                    let scored = assess(&trunk, &limb, &task, &profile);
                    u32::from(scored.rula.grand) + u32::from(scored.reba.total)
                })
                .sum::<u32>()
        });
    });
    group.finish();
}

fn joints(c: &mut Criterion) {
    let body = Body::load("male_p50", std::path::Path::new(".")).expect("a preset");
    let stance = Stance::Standing { shoe_m: 0.03 };
    let pelvis = body.pelvis_pose([0.0, 0.0], 0.0, stance);
    let surveyor =
        Surveyor::new(&body, Coupled::arm(BodySide::Right), pelvis, (stance, 0.0)).expect("a body");
    let chain = body.arm(BodySide::Right).expect("an arm");
    let mut rng = stream(2, Purpose::Simulation, 911, 0);
    let lens = Lens {
        task: TaskInputs::default(),
        neck: NeckRule::Gaze,
        both_hands: false,
        profile: Profile::default(),
    };
    let mut posture = || {
        let within = chain.joints().iter().map(|j| rng.random_range(j.lower..=j.upper));
        DVector::from_iterator(chain.dof(), within)
    };
    c.bench_function("RULA and REBA from joint angles, kinematics included", |b| {
        b.iter_batched(
            &mut posture,
            |q| surveyor.measure(&q, &HeadDraw::default()).score(&lens),
            BatchSize::SmallInput,
        );
    });
}

criterion_group!(group, scores, joints);
criterion_main!(group);

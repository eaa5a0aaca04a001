//! How long the Panda's kinematics and the following of a path take.

use criterion::{Criterion, criterion_group, criterion_main};
use ergopath::kinematics::Frames;
use ergopath::math::segment::segment_distance;
use ergopath::math::{Pose, Vec3};
use ergopath::robot::{
    Follow, FollowSettings, Obstacle, Robot, follow, follow_from, min_clearance, self_clearance,
    start_postures,
};
use nalgebra::{Matrix6xX, UnitQuaternion};
use std::hint::black_box;

fn line(reach: f64) -> (Vec<f64>, Vec<Pose>) {
    let down = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
    let at = |k: i32| {
        let s = f64::from(k) / 99.0;
        let s = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
        Pose::from_parts(Vec3::new(0.45 + reach * s, -0.2 + 0.4 * s, 0.4).into(), down)
    };
    ((0..100).map(|k| 3.0 * f64::from(k) / 99.0).collect(), (0..100).map(at).collect())
}

/// The gripper, pointing down, turns about the vertical.
fn turn(degrees: f64) -> (Vec<f64>, Vec<Pose>) {
    let down = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
    let at = |k: i32| {
        let s = f64::from(k) / 100.0;
        let s = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s) - 0.5;
        let about = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), degrees.to_radians() * s);
        Pose::from_parts(Vec3::new(0.45, 0.0, 0.4).into(), about * down)
    };
    ((0..=100).map(|k| 0.08 * f64::from(k)).collect(), (0..=100).map(at).collect())
}

fn benches(c: &mut Criterion) {
    let robot = Robot::preset("panda").expect("the preset is part of the crate");
    let mut frames = Frames::default();
    let mut jacobian = Matrix6xX::zeros(robot.dof());
    c.bench_function("panda forward kinematics and Jacobian", |b| {
        b.iter(|| {
            robot.linkage.forward(black_box(&robot.home), &mut frames);
            robot.linkage.jacobian_into(&frames, 0, &mut jacobian);
            jacobian[(0, 0)]
        });
    });
    let settings = FollowSettings::default();
    let (time, poses) = line(0.0);
    c.bench_function("panda follows 100 knots, start postures searched", |b| {
        b.iter(|| follow(&robot, &time, black_box(&poses), &settings));
    });
    let starts = start_postures(&robot, &poses[0], &settings).postures;
    c.bench_function("panda follows 100 knots, from one start posture", |b| {
        b.iter(|| follow_from(&robot, &time, black_box(&poses), &starts[..1], &settings));
    });
    let (time, far) = line(1.0);
    c.bench_function("panda refuses 100 knots out of reach", |b| {
        b.iter(|| follow(&robot, &time, black_box(&far), &settings));
    });
    let size = Vec3::new(1.0, 2.0, 0.1);
    let obstacles = [
        ("table".to_owned(), Obstacle::Box { pose: Pose::translation(0.9, 0.0, -0.05), size }),
        ("ball".to_owned(), Obstacle::Sphere { center: Vec3::new(0.3, 0.5, 0.6), radius: 0.1 }),
    ];
    let (time, poses) = line(0.0);
    let Follow::Feasible(motion) = follow(&robot, &time, &poses, &settings) else { return };
    c.bench_function("distance of two segments", |b| {
        let [p, q, r, s] =
            [[0.0, 0.0, 0.0], [0.1, 0.4, 0.2], [0.3, 0.1, 0.5], [-0.2, 0.6, 0.1]].map(Vec3::from);
        b.iter(|| segment_distance([black_box(&p), &q], [black_box(&r), &s]));
    });
    c.bench_function("panda to itself at 100 knots", |b| {
        b.iter(|| self_clearance(&robot, &time, black_box(&motion.q)));
    });
    let thorough = FollowSettings { is_thorough: true, ..FollowSettings::default() };
    let (slow, turning) = turn(320.0);
    c.bench_function("panda turns by 320 degrees, globally", |b| {
        b.iter(|| follow(&robot, &slow, black_box(&turning), &thorough));
    });
    c.bench_function("panda turns by 320 degrees, tracking", |b| {
        b.iter(|| follow(&robot, &slow, black_box(&turning), &settings));
    });
    c.bench_function("panda clearance to a box and a ball", |b| {
        b.iter(|| min_clearance(&robot, black_box(&robot.home), &obstacles));
    });
}

criterion_group!(group, benches);
criterion_main!(group);

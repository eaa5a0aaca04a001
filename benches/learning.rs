//! What learning a law costs: whole trainings, and the parts that they repeat.

#![allow(clippy::unwrap_used, reason = "a bench may panic")]

mod common;

use common::{operator, sparse};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ergopath::kinematics::{Linkage, parse_urdf};
use ergopath::math::dense::Factor;
use ergopath::math::stream::{Purpose, normals, stream};
use ergopath::posture::{Coupling, Hold, Method, cross_kernel};
use ergopath::training::toy5r::{BASE, TIP, ToyConstants, generate, planar_urdf};
use ergopath::training::{
    DataRow, Dataset, Frame, TrainSettings, learn_laws, with_kernel_search, with_weight_search,
};
use nalgebra::DMatrix;
use std::hint::black_box;
use std::path::Path;

/// The rows of the five-joint problem that train, N = 700.
fn toy() -> Dataset {
    let constants = ToyConstants::default();
    let problem = generate(0, &constants).unwrap();
    let rows: Vec<DataRow> = (0..problem.q.len())
        .filter(|&i| problem.train[i])
        .map(|i| DataRow {
            q: problem.q[i].to_vec(),
            xdot: problem.xdot[i].to_vec(),
            qdot: problem.qdot[i].to_vec(),
            trial: 0,
            time_s: constants.dt_s * i as f64,
        })
        .collect();
    let model = parse_urdf(Path::new("toy"), &planar_urdf(&constants)).unwrap();
    let chain = Linkage::chain(&model, BASE, TIP).unwrap();
    Dataset::of_rows("toy", &rows, Coupling::of_chain(chain, Hold::Planar)).unwrap()
}

fn whole(c: &mut Criterion) {
    let settings = TrainSettings::default();
    let mut group = c.benchmark_group("training");
    group.sample_size(10);
    for (name, dataset) in [("5 joints, N = 700", toy()), ("24 joints, N = 1000", operator(1000))] {
        let frames: Vec<&Frame> = dataset.frames.iter().collect();
        let stature = dataset.coupling.stature_m();
        for method in [Method::MiNsgp, Method::FullWGp] {
            group.bench_function(format!("{} of {name}", method.name()), |b| {
                b.iter(|| learn_laws(&[method], &frames, stature, &settings, None).unwrap());
            });
        }
    }
    group.finish();
}

fn parts(c: &mut Criterion) {
    let settings = TrainSettings::default();
    let mut group = c.benchmark_group("objective");
    group.sample_size(20);
    for (name, dataset) in [("5 joints, N = 700", toy()), ("24 joints, N = 1000", operator(1000))] {
        let frames = sparse(&dataset);
        with_kernel_search(&frames, &settings, |f, x| {
            group.bench_function(format!("marginal likelihood and gradient, {name}"), |b| {
                b.iter(|| f(black_box(x)));
            });
        })
        .unwrap();
        with_weight_search(&frames, &settings, |f, x| {
            group.bench_function(format!("weights and gradient, {name}"), |b| {
                b.iter(|| f(black_box(x)));
            });
        })
        .unwrap();
    }
    group.finish();
}

fn algebra(c: &mut Criterion) {
    const N: usize = 1000;
    const D: usize = 30;
    let mut rng = stream(1, Purpose::Simulation, 0, 0);
    let rows = DMatrix::from_vec(N, D, normals(&mut rng, N * D)) / (D as f64).sqrt();
    let mut group = c.benchmark_group("algebra");
    group.sample_size(20);
    group.throughput(Throughput::Elements(N as u64));
    group.bench_function("kernel rows, N = 1000, D = 30", |b| {
        b.iter(|| cross_kernel(black_box(&rows), &rows));
    });
    group.throughput(Throughput::Elements(1));
    let kernel = cross_kernel(&rows, &rows) + DMatrix::identity(N, N) * 0.1;
    group.bench_function("Cholesky, N = 1000", |b| b.iter(|| Factor::new(black_box(&kernel))));
    let factor = Factor::new(&kernel).unwrap();
    group.bench_function("inverse, N = 1000", |b| b.iter(|| black_box(&factor).inverse()));
    group.bench_function("Cholesky by nalgebra, N = 1000", |b| {
        b.iter(|| black_box(&kernel).clone().cholesky());
    });
    group.finish();
}

criterion_group!(benches, whole, parts, algebra);
criterion_main!(benches);

//! Time of one projection: a path within its limits, one whose speed is cut, one cut by the box, one
//! with joint-speed rows of a robot at every knot, one around an obstacle.

use criterion::{Criterion, criterion_group, criterion_main};
use ergopath::math::{Pose, Vec3};
use ergopath::path::{
    Box3, CandidateSettings, Condition, Order, PathLimits, ProjectionSettings, Scene, candidates,
    project, project_within, reference_path,
};
use ergopath::robot::Obstacle;
use std::hint::black_box;

fn projection(c: &mut Criterion) {
    let start = Pose::translation(0.5, -0.2, 1.0);
    let box_top = Box3 { min: Vec3::new(0.0, -1.0, 0.5), max: Vec3::new(1.0, 1.0, 1.05) };
    let open = PathLimits::default();
    let boxed = PathLimits { workspace: Some(box_top), ..open };
    let cases = [
        ("within its limits", 0.4, 50, open),
        ("within its limits", 0.4, 100, open),
        ("within its limits", 0.4, 200, open),
        ("cut in speed", 0.8, 100, open),
        ("cut by the box", 0.4, 100, boxed),
    ];
    for (name, distance, steps, limits) in cases {
        let goal = Pose::translation(0.5, -0.2 + distance, 1.0);
        let all = candidates(&CandidateSettings::default(), &start, &goal, &-Vec3::x(), 1);
        // The lifted one meets the top of the box; the straight one is fast enough to be cut.
        let candidate = &all[usize::from(limits.workspace.is_some())];
        let Ok(reference) = reference_path(candidate, &start, &goal, 4.0, steps) else { continue };
        let settings = ProjectionSettings { steps, ..ProjectionSettings::default() };
        c.bench_function(&format!("projection/{name}/{steps}"), |b| {
            b.iter(|| project(black_box(&reference), &limits, &settings));
        });
    }
}

/// Rows as seven joints would put them on velocity, at every knot and in both directions.
fn joint_rows(steps: usize, bound: f64) -> Vec<Condition> {
    let rows = (1..steps).flat_map(|knot| (0..7).map(move |joint| (knot, f64::from(joint))));
    rows.flat_map(|(knot, joint)| {
        let turn = joint + 0.01 * knot as f64;
        let normal = Vec3::new(turn.cos(), turn.sin(), (2.0 * turn).sin());
        [normal, -normal].map(|normal| Condition { knot, order: Order::Velocity, normal, bound })
    })
    .collect()
}

fn surroundings(c: &mut Criterion) {
    let (start, goal) = (Pose::translation(0.5, -0.2, 1.0), Pose::translation(0.5, 0.2, 1.0));
    let all = candidates(&CandidateSettings::default(), &start, &goal, &-Vec3::x(), 1);
    let Ok(reference) = reference_path(&all[0], &start, &goal, 4.0, 100) else { return };
    let (limits, settings) = (PathLimits::default(), ProjectionSettings::default());
    // The path alone peaks at 0.19 m/s.
    let conditions = joint_rows(100, 0.16);
    let block =
        Obstacle::Box { pose: Pose::translation(0.5, 0.0, 0.9), size: Vec3::new(0.3, 0.1, 0.22) };
    let obstacles = [("block".to_owned(), block)];
    let robot = Scene { conditions: &conditions, ..Scene::default() };
    let around = Scene { obstacles: &obstacles, ..Scene::default() };
    for (name, scene) in [("with robot rows", robot), ("around an obstacle", around)] {
        c.bench_function(&format!("projection/{name}/100"), |b| {
            b.iter(|| project_within(black_box(&reference), &limits, &scene, &settings));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = projection, surroundings
}
criterion_main!(benches);

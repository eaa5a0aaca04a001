//! Time of one projection: a path within its limits, one whose speed is cut, one cut by the box.

use criterion::{Criterion, criterion_group, criterion_main};
use ergopath::math::{Pose, Vec3};
use ergopath::path::{
    Box3, CandidateSettings, PathLimits, ProjectionSettings, candidates, project, reference_path,
};
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

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = projection
}
criterion_main!(benches);

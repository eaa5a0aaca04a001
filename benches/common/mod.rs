//! Data that several benches learn from.

use ergopath::human::{Body, Side};
use ergopath::math::stream::{Purpose, normals, stream};
use ergopath::training::{Dataset, Frame, Trial, read_motion};
use std::path::Path;

/// The shipped body on which the simulated operator was recorded.
pub(crate) fn body() -> Body {
    Body::load("female_p50", Path::new(".")).unwrap()
}

/// The simulated operator's movements (24 joints), repeated with noise until there are `count` frames
/// for everything fitted by likelihood.
pub(crate) fn operator(count: usize) -> Dataset {
    let body = body();
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios/demonstrations/simulated_operator.csv");
    let file = read_motion(&path, &body, Side::Right).unwrap();
    let mut trials: Vec<Trial> = Vec::new();
    for round in 0.. {
        for (i, trial) in file.trials.iter().enumerate() {
            let mut rng = stream(round, Purpose::Simulation, 900, i as u32);
            let mut noisy = |rows: &[Vec<f64>], sd: f64| -> Vec<Vec<f64>> {
                let sd = if round == 0 { 0.0 } else { sd };
                let one = |row: &Vec<f64>| {
                    row.iter().zip(normals(&mut rng, row.len())).map(|(v, e)| v + sd * e).collect()
                };
                rows.iter().map(one).collect()
            };
            let (q, qdot) = (noisy(&trial.q, 0.05), noisy(&trial.qdot, 0.03));
            trials.push(Trial { q, qdot, ..trial.clone() });
        }
        let mut dataset = Dataset::new(&trials, &body, Side::Right).unwrap();
        if sparse(&dataset).len() >= count {
            let mut kept = 0;
            dataset.frames.retain(|f| {
                kept += usize::from(f.is_sparse);
                kept <= count
            });
            return dataset;
        }
    }
    unreachable!("the loop has no end")
}

/// The frames for everything fitted by likelihood.
pub(crate) fn sparse(dataset: &Dataset) -> Vec<&Frame> {
    dataset.frames.iter().filter(|f| f.is_sparse).collect()
}

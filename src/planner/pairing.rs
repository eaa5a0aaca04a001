//! Whether repetition r of two runs is the same simulated repetition of the same person.

use super::result::RunResult;
use serde::Serialize;

/// Why it is not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "because", content = "values", rename_all = "snake_case")]
pub enum Apart {
    /// Two seeds.
    Seeds([u64; 2]),
    /// Two posture models; their names, which may be the same.
    Models([String; 2]),
    /// Bodies of two names.
    Bodies([String; 2]),
    /// Two bodies of one name.
    TwoBodies(String),
    /// Two versions of the program.
    Versions([String; 2]),
}

/// Why rollout r of one run and body is not the person of rollout r of the other; none if it is.
pub fn apart((a, body_a): (&RunResult, &str), (b, body_b): (&RunResult, &str)) -> Option<Apart> {
    let (pa, pb) = (&a.provenance, &b.provenance);
    // Inputs stand in this order: scenario, model, bodies, paths.
    let body = |r: &RunResult, name: &str| {
        let bodies = r.provenance.inputs.iter().skip(2).take(r.setting.bodies.len());
        let hash = bodies.filter(|(n, _)| n == name).map(|(_, h)| h.clone()).next();
        let facts = r.setting.bodies.iter().find(|b| b.name == name).cloned();
        (hash, facts)
    };
    let model = |r: &RunResult| r.provenance.inputs.get(1).map(|(_, h)| h.clone());
    let names = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
    if pa.seed != pb.seed {
        Some(Apart::Seeds([pa.seed, pb.seed]))
    } else if model(a) != model(b) {
        Some(Apart::Models(names(&a.posture_model.name, &b.posture_model.name)))
    } else if body_a != body_b {
        Some(Apart::Bodies(names(body_a, body_b)))
    } else if body(a, body_a) != body(b, body_b) {
        Some(Apart::TwoBodies(body_a.to_owned()))
    } else if pa.program_version != pb.program_version {
        Some(Apart::Versions(names(&pa.program_version, &pb.program_version)))
    } else {
        None
    }
}

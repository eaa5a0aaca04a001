//! The program against stored copies that another solver has solved, and against its own optimum.
//!
//! `tests/projection/*.json` hold programs of this transcription with the optimum of CVXOPT's
//! interior-point method (`solve.py` beside them). They are written again by running this test with
//! `ERGOPATH_WRITE_PROBLEMS=1`, and then solved again by the script.

use super::*;
use crate::path::stencil::position_hull;
use crate::qp::{Outcome, residuals, solve};
use serde::{Deserialize, Serialize};
use std::path::Path;

const STEPS: usize = 20;

#[derive(Serialize, Deserialize)]
struct Stored {
    problem: Problem,
    solver: Option<String>,
    objective: Option<f64>,
    x: Option<Vec<f64>>,
}

fn reference(distance: f64, lift: f64) -> Vec<Vec3> {
    let at = |k: usize| {
        let s = k as f64 / STEPS as f64;
        let along = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        let bump = (std::f64::consts::PI * s).sin().powi(2);
        Vec3::new(0.5 + 0.2 * lift * bump, distance * along, 1.0 + lift * bump)
    };
    (0..=STEPS).map(at).collect()
}

/// Small projections of every kind of row, with their unit of length, m.
fn problems() -> Vec<(&'static str, f64, Problem)> {
    let open = PathLimits::default();
    let all = Rows { acceleration: true, jerk: true, ..Rows::default() };
    let inner = Box3 { min: Vec3::new(0.0, -1.0, 0.5), max: Vec3::new(1.0, 1.0, 1.05) };
    let boxed = PathLimits { workspace: Some(inner), ..open };
    let over: Vec<Plane> = (7..13)
        .flat_map(|k| {
            position_hull(k).map(|at| Plane {
                label: "obstacle".to_owned(),
                at,
                order: Order::Position,
                normal: Vec3::new(0.0, 0.6, -0.8) * if k < 10 { 1.0 } else { 0.9 },
                bound: -0.72,
                slack: Some(k - 7),
            })
        })
        .collect();
    let slow: Vec<Plane> = (5..15)
        .map(|k| Plane {
            label: ROBOT.to_owned(),
            at: velocity(k),
            order: Order::Velocity,
            normal: Vec3::new(0.3, 1.0, -0.2),
            bound: 0.12,
            slack: None,
        })
        .collect();
    let near: Vec<Ball> = (4..16)
        .map(|k| Ball {
            label: "corridor".to_owned(),
            at: position(k),
            center: reference(0.8, 0.1)[k],
            radius: 0.06,
            slack: k - 4,
        })
        .collect();
    let slacks = |n: usize| vec![SLACK_COST; n];
    let cases: [(&str, Vec<Vec3>, f64, PathLimits, Rows); 6] = [
        ("free", reference(0.4, 0.05), 4.0, open, all.clone()),
        ("cut_in_speed", reference(0.8, 0.0), 4.2, open, all.clone()),
        ("all_limits", reference(0.45, 0.0), 2.4, open, all.clone()),
        ("box", reference(0.4, 0.12), 4.0, boxed, Rows { faces: vec![(2, true)], ..all.clone() }),
        (
            "obstacle_and_robot",
            reference(0.4, 0.1),
            4.0,
            open,
            Rows { planes: [over, slow].concat(), slacks: slacks(6), ..all.clone() },
        ),
        (
            "corridor",
            reference(0.8, 0.1),
            4.4,
            open,
            Rows { balls: near, slacks: slacks(12), ..all },
        ),
    ];
    let make =
        |(name, reference, duration, limits, rows): (_, Vec<Vec3>, f64, PathLimits, Rows)| {
            let task = Task {
                reference: &reference,
                step_s: duration / STEPS as f64,
                limits: &limits,
                jerk_weight: 1e-4,
                margin: 0.0,
                rows: &rows,
            };
            (name, task.unit(), task.problem())
        };
    cases.into_iter().map(make).collect()
}

#[test]
fn optima_are_those_of_another_solver() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/projection");
    for (name, unit, problem) in problems() {
        let file = folder.join(format!("{name}.json"));
        if std::env::var_os("ERGOPATH_WRITE_PROBLEMS").is_some() {
            let stored = Stored { problem, solver: None, objective: None, x: None };
            std::fs::write(&file, serde_json::to_string(&stored).unwrap()).unwrap();
            continue;
        }
        let stored: Stored =
            serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        // What is stored is what is made today, to the rounding of sines.
        assert_eq!(stored.problem.blocks, problem.blocks, "{name}");
        let numbers = |p: &Problem| -> Vec<f64> {
            let entries = p.quadratic.iter().chain(&p.matrix).map(|e| e.2);
            entries.chain(p.linear.iter().copied()).chain(p.offset.iter().copied()).collect()
        };
        for (a, b) in numbers(&stored.problem).iter().zip(numbers(&problem)) {
            assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{name}: {a} {b}");
        }
        let Outcome::Solved { x, z, objective, .. } = solve(&stored.problem) else {
            panic!("{name}")
        };
        let theirs = stored.objective.unwrap();
        assert!(
            (objective - theirs).abs() <= 1e-6 * (1.0 + theirs.abs()),
            "{name}: {objective} and {theirs}"
        );
        // Coefficients of the path, in m.
        let theirs = stored.x.unwrap();
        let pairs = x.iter().zip(&theirs).take(3 * (STEPS - 3));
        let far_m = pairs.map(|(a, b)| (a - b).abs() * unit).fold(0.0, f64::max);
        assert!(far_m <= 1e-6, "{name}: {far_m} m");
        let found = residuals(&stored.problem, &x, &z).unwrap();
        assert!(found.cone < 1e-6 && found.equality < 1e-6, "{name}: {found:?}");
    }
}

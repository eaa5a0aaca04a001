//! The solver against closed forms, a dense KKT solve and its own optimality conditions.

use super::*;
use crate::math::stream::{Purpose, normals, stream};
use approx::assert_relative_eq;
use nalgebra::{DMatrix, DVector};

fn solved(problem: &Problem) -> (Vec<f64>, Vec<f64>, f64) {
    match solve(problem) {
        Outcome::Solved { x, z, objective, iterations, is_reduced } => {
            assert!(iterations < 50 && !is_reduced);
            (x, z, objective)
        }
        other => panic!("{other:?}"),
    }
}

fn assert_optimal(problem: &Problem, x: &[f64], z: &[f64]) {
    let r = residuals(problem, x, z).unwrap();
    for value in [r.equality, r.cone, r.dual_cone, r.stationarity, r.complementarity] {
        assert!(value < 1e-6, "{r:?}");
    }
}

/// The point of the box [0, 1]^2 nearest to (2, 1/2) is (1, 1/2).
#[test]
fn nearest_point_of_a_box() {
    let mut p = Problem::new(2);
    p.quadratic = vec![(0, 0, 1.0), (1, 1, 0.25), (1, 1, 0.75)];
    p.linear = vec![-2.0, -0.5];
    for i in 0..2 {
        p.push_block("upper", Cone::Nonnegative, &[(&[(i, 1.0)], 1.0)]);
        p.push_block("lower", Cone::Nonnegative, &[(&[(i, -1.0)], 0.0)]);
    }
    let (x, z, objective) = solved(&p);
    assert_relative_eq!(x[0], 1.0, epsilon = 1e-6);
    assert_relative_eq!(x[1], 0.5, epsilon = 1e-6);
    assert_relative_eq!(z[0], 1.0, epsilon = 1e-6);
    assert_relative_eq!(objective, 0.5 - 2.0 - 0.125, epsilon = 1e-6);
    assert_optimal(&p, &x, &z);
    // The check sees what is wrong.
    let r = residuals(&p, &[1.5, 0.5], &z).unwrap();
    assert_relative_eq!(r.cone, 0.5);
    assert_relative_eq!(r.stationarity, 0.5, epsilon = 1e-6);
    assert!(residuals(&p, &[1.5], &z).is_none());
}

/// The point of the ball |x| <= 2 nearest to (3, 4) is (1.2, 1.6).
#[test]
fn nearest_point_of_a_ball() {
    let mut p = Problem::new(2);
    p.quadratic = vec![(0, 0, 1.0), (1, 1, 1.0)];
    p.linear = vec![-3.0, -4.0];
    let rows: [(&[(usize, f64)], f64); 3] = [(&[], 2.0), (&[(0, -1.0)], 0.0), (&[(1, -1.0)], 0.0)];
    p.push_block("ball", Cone::SecondOrder, &rows);
    let (x, z, _) = solved(&p);
    assert_relative_eq!(x[0], 1.2, epsilon = 1e-6);
    assert_relative_eq!(x[1], 1.6, epsilon = 1e-6);
    assert_optimal(&p, &x, &z);
}

#[test]
fn equality_constrained_problems_match_a_dense_kkt_solve() {
    for seed in 0..10 {
        let mut rng = stream(seed, Purpose::Simulation, 0, 0);
        let (n, m) = (8, 3);
        let root = DMatrix::from_vec(n, n, normals(&mut rng, n * n));
        let hessian = root.transpose() * &root + DMatrix::identity(n, n) * 0.1;
        let a = DMatrix::from_vec(m, n, normals(&mut rng, m * n));
        let (q, b) = (normals(&mut rng, n), normals(&mut rng, m));
        let mut p = Problem::new(n);
        p.linear.clone_from(&q);
        for column in 0..n {
            p.quadratic.extend((0..=column).map(|row| (row, column, hessian[(row, column)])));
        }
        for row in 0..m {
            let entries: Vec<_> = (0..n).map(|column| (column, a[(row, column)])).collect();
            p.push_block(format!("row {row}"), Cone::Zero, &[(&entries, b[row])]);
        }
        let mut kkt = DMatrix::zeros(n + m, n + m);
        kkt.view_mut((0, 0), (n, n)).copy_from(&hessian);
        kkt.view_mut((n, 0), (m, n)).copy_from(&a);
        kkt.view_mut((0, n), (n, m)).copy_from(&a.transpose());
        let rhs = DVector::from_iterator(n + m, q.iter().map(|v| -v).chain(b));
        let exact = kkt.lu().solve(&rhs).unwrap();
        let (x, z, _) = solved(&p);
        for (i, value) in x.iter().chain(&z).enumerate() {
            assert_relative_eq!(*value, exact[i], epsilon = 1e-6, max_relative = 1e-6);
        }
        assert_optimal(&p, &x, &z);
        assert_eq!(solve(&p), solve(&p));
    }
}

#[test]
fn contradictions_name_their_rows() {
    let mut p = Problem::new(2);
    p.quadratic = vec![(0, 0, 1.0), (1, 1, 1.0)];
    p.push_block("x at most 1", Cone::Nonnegative, &[(&[(0, 1.0)], 1.0)]);
    p.push_block("x at least 3", Cone::Nonnegative, &[(&[(0, -100.0)], -300.0)]);
    p.push_block("y at most 5", Cone::Nonnegative, &[(&[(1, 1.0)], 5.0)]);
    let Outcome::PrimalInfeasible { culprits } = solve(&p) else { panic!() };
    let labels: Vec<_> = culprits.iter().map(|c| c.label.as_str()).collect();
    assert_eq!(labels, ["x at least 3", "x at most 1"]);
    assert_relative_eq!(culprits[0].share, 0.75, epsilon = 1e-3);
    // A row with b = 0 is named although its share is zero.
    p.offset[0] = 0.0;
    let Outcome::PrimalInfeasible { culprits } = solve(&p) else { panic!() };
    assert!(culprits.iter().any(|c| c.label == "x at most 1" && c.share == 0.0));
}

#[test]
fn what_cannot_be_solved_is_a_status() {
    let mut p = Problem::new(1);
    p.linear = vec![1.0];
    p.push_block("x at most 1", Cone::Nonnegative, &[(&[(0, 1.0)], 1.0)]);
    assert_eq!(solve(&p), Outcome::DualInfeasible);
    let invalid = |p: &Problem| matches!(solve(p), Outcome::NotConverged { status: Stop::Invalid(reason) } if !reason.is_empty());
    let broken = |change: fn(&mut Problem)| {
        let mut q = p.clone();
        change(&mut q);
        invalid(&q)
    };
    assert!(broken(|p| p.linear[0] = f64::NAN));
    assert!(broken(|p| p.offset[0] = f64::INFINITY));
    assert!(broken(|p| p.linear.push(0.0)));
    assert!(broken(|p| p.offset.push(0.0)));
    assert!(broken(|p| p.matrix.push((0, 7, 1.0))));
    assert!(broken(|p| p.quadratic.push((1, 0, 1.0))));
    assert!(invalid(&Problem::default()));
}

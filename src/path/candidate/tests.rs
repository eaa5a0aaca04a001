//! Shapes, sizes and reproducibility of the candidates.

use super::*;
use approx::assert_relative_eq;

fn ends() -> (Pose, Pose) {
    let start = Pose::new(Vec3::new(0.5, -0.2, 1.0), Vec3::zeros());
    let goal = Pose::new(Vec3::new(0.6, 0.2, 1.1), Vec3::new(0.0, 0.0, 0.5));
    (start, goal)
}

fn made(seed: u64) -> Vec<Candidate> {
    let (start, goal) = ends();
    candidates(&CandidateSettings::default(), &start, &goal, &-Vec3::x(), seed)
}

fn path(candidate: &Candidate) -> TimedPath {
    let (start, goal) = ends();
    reference_path(candidate, &start, &goal, 4.0, 100).unwrap()
}

#[test]
fn the_straight_candidate_is_the_minimum_jerk_line() {
    let (start, goal) = ends();
    let line = crate::trajectory::minimum_jerk_line(&start, &goal, 4.0, 100).unwrap();
    for (a, b) in path(&made(1)[0]).poses.iter().zip(&line.poses) {
        assert_relative_eq!(a, b, epsilon = 1e-9);
    }
}

#[test]
fn named_families_move_mid_path_by_the_given_size() {
    let all = made(1);
    let names: Vec<&str> = all.iter().take(6).map(|c| c.id.as_str()).collect();
    assert_eq!(names, ["straight", "lifted", "lowered", "toward_body", "away", "s000"]);
    for (i, direction) in [(1, Vec3::z()), (2, -Vec3::z()), (3, -Vec3::x()), (4, Vec3::x())] {
        assert_relative_eq!(all[i].vias[1] - all[0].vias[1], direction * 0.12, epsilon = 1e-12);
        let straight = path(&all[0]);
        let nearest = path(&all[i]).poses.iter().fold(0.0f64, |far, p| {
            let to = |q: &Pose| (q.translation.vector - p.translation.vector).norm();
            far.max(straight.poses.iter().map(to).fold(f64::INFINITY, f64::min))
        });
        assert!((0.11..0.125).contains(&nearest), "{nearest}");
    }
    let (start, goal) = ends();
    let few = candidates(&CandidateSettings::default(), &start, &goal, &Vec3::zeros(), 1);
    assert_eq!(few.len(), all.len() - 2);
}

#[test]
fn samples_follow_the_seed_and_the_generation() {
    assert_eq!(made(3), made(3));
    assert_ne!(made(3)[5], made(4)[5]);
    let (start, goal) = ends();
    let later = CandidateSettings { generation: 1, ..CandidateSettings::default() };
    assert_ne!(candidates(&later, &start, &goal, &Vec3::x(), 3)[5], made(3)[5]);
}

#[test]
fn samples_have_the_asked_offset_and_are_whitened() {
    let (start, goal) = ends();
    let space = ViaSpace::new(3, &start, &goal, 0.15).unwrap();
    let count = 4000;
    let mut square = 0.0;
    for i in 0..count {
        let x = normals(&mut stream(5, Purpose::Search, 0, i), space.dimension());
        let candidate = space.decode("s", &x);
        square += (candidate.vias[1] - space.straight[1]).norm_squared();
        for (a, b) in x.iter().zip(space.encode(&candidate).unwrap()) {
            assert_relative_eq!(*a, b, epsilon = 1e-9);
        }
    }
    assert_relative_eq!((square / f64::from(count)).sqrt(), 0.15, max_relative = 0.03);
    // L L^T R = sigma^2 I.
    let gram = &space.factor * space.factor.transpose();
    let units: Vec<ClampedSpline> = (0..3)
        .map(|i| {
            let unit = (0..3).map(|k| if k == i { Vec3::x() } else { Vec3::zeros() });
            through(&space.parameters, unit, Vec3::zeros(), Vec3::zeros()).unwrap()
        })
        .collect();
    let stiffness = DMatrix::from_fn(3, 3, |i, j| units[i].bending(&units[j]));
    let product = gram * stiffness;
    let scale = product[(0, 0)];
    assert_relative_eq!(product / scale, DMatrix::identity(3, 3), epsilon = 1e-9);
}

#[test]
fn drawn_points_are_passed_and_repeats_ignored() {
    let (start, goal) = ends();
    let (a, b) = (Vec3::new(0.5, 0.0, 1.2), Vec3::new(0.55, 0.15, 1.3));
    let candidate = drawn("mine", &[a, a, b, goal.translation.vector], &start, &goal).unwrap();
    assert_eq!(candidate.vias, [a, b]);
    let fine = reference_path(&candidate, &start, &goal, 4.0, 4000).unwrap();
    for via in [a, b] {
        let near = fine.poses.iter().map(|p| (p.translation.vector - via).norm());
        assert!(near.fold(f64::INFINITY, f64::min) < 1e-3);
    }
    // Points on the line leave it straight.
    let middle = start.translation.vector.lerp(&goal.translation.vector, 0.3);
    let line = path(&drawn("line", &[middle], &start, &goal).unwrap());
    assert_relative_eq!(line.poses[50], path(&made(1)[0]).poses[50], epsilon = 1e-9);
    assert_relative_eq!(inverse_ease(ease(0.3)), 0.3, epsilon = 1e-12);
}

#[test]
fn what_makes_no_sense_makes_no_candidates_and_no_panic() {
    let (start, goal) = ends();
    let nan = Vec3::new(f64::NAN, 0.0, 0.0);
    for (vias, size) in [(0, 0.1), (3, f64::NAN), (3, -1.0), (3, 0.0), (1000, 0.1)] {
        assert!(ViaSpace::new(vias, &start, &goal, size).is_none());
    }
    assert_eq!(candidates(&CandidateSettings::default(), &start, &goal, &nan, 0).len(), 14);
    assert_eq!(drawn("d", &[nan], &start, &goal), Err(TrajectoryError::Pose(0)));
    // Start and goal in one place.
    let still = drawn("still", &[], &start, &start).unwrap();
    let path = reference_path(&still, &start, &start, 4.0, 10).unwrap();
    assert!(path.length_m() < 1e-12);
    let broken = Candidate { parameters: vec![0.5], ..still };
    assert!(reference_path(&broken, &start, &goal, 4.0, 10).is_err());
}

//! Projections are within every limit, near their reference, or refused with the right reason.

use super::*;
use crate::path::bounds::shortest_straight_s;
use crate::path::hull::integrated;
use crate::path::transcription::{Rows, Task};
use crate::path::{
    CandidateSettings, Cause, End, Face, Quantity, candidates, reference_path, verify,
};
use crate::qp::{Outcome, solve};
use crate::trajectory::minimum_jerk_line;
use approx::assert_relative_eq;
use proptest::prelude::*;

fn line(distance: f64, duration: f64) -> TimedPath {
    let start = Pose::translation(0.5, -0.2, 1.0);
    let goal = Pose::translation(0.5, -0.2 + distance, 1.0);
    minimum_jerk_line(&start, &goal, duration, 100).unwrap()
}

fn default_project(reference: &TimedPath, limits: &PathLimits) -> Projection {
    project(reference, limits, &ProjectionSettings::default())
}

fn feasible(projection: Projection) -> (SmoothPath, f64) {
    match projection {
        Projection::Feasible { path, moved_m, .. } => (path, moved_m),
        Projection::Infeasible { why, .. } => panic!("{why:?}"),
    }
}

fn refused(projection: Projection) -> NoPath {
    match projection {
        Projection::Infeasible { why, .. } => why,
        Projection::Feasible { .. } => panic!("feasible"),
    }
}

#[test]
fn a_path_within_its_limits_stays_where_it_is() {
    let limits = PathLimits::default();
    let (path, moved) = feasible(default_project(&line(0.4, 4.0), &limits));
    assert!(moved < 1e-3, "{moved}");
    let found = verify(&path, &limits);
    assert!(found.is_ok());
    assert_relative_eq!(found.of(Quantity::Speed).unwrap().value, 0.1875, max_relative = 0.01);
    assert_relative_eq!(path.position[100].y, 0.2, epsilon = 1e-12);
}

#[test]
fn a_path_that_is_too_fast_gets_a_flat_speed() {
    let limits = PathLimits::default();
    // Minimum jerk would peak at 0.375 m/s; 0.8 m in 4 s is 0.2 m/s in the mean.
    let (path, moved) = feasible(default_project(&line(0.8, 4.0), &limits));
    let found = verify(&path, &limits);
    assert!(found.is_ok(), "{:?}", found.violations().collect::<Vec<_>>());
    assert!(found.of(Quantity::Speed).unwrap().value > 0.2499);
    let at_limit = path.velocity.iter().filter(|v| v.norm() > 0.249).count();
    assert!(at_limit > 40, "{at_limit}");
    assert!((0.02..0.15).contains(&moved), "{moved}");
    assert_relative_eq!(path.position[100].y, 0.6, epsilon = 1e-12);
}

#[test]
fn too_little_time_is_refused_with_the_time_it_takes() {
    let limits = PathLimits::default();
    let why = refused(default_project(&line(0.7, 1.2), &limits));
    let NoPath::TooShort { duration_s, needed_s, speed_m_s, .. } = why else { panic!("{why:?}") };
    assert_eq!((duration_s, speed_m_s), (1.2, 0.25));
    // 0.7 / 0.25 + 0.25 / 1 + 1 / 10.
    assert_relative_eq!(needed_s, 3.15, epsilon = 1e-9);
    let settings = ProjectionSettings::default();
    let (a, b) = (line(0.7, 1.0).poses[0], line(0.7, 1.0).poses[100]);
    let shortest = shortest_duration_s(&a, &b, &limits, &settings).unwrap();
    assert!((3.149..3.3).contains(&shortest), "{shortest}");
    feasible(default_project(&line(0.7, shortest), &limits));
    // Between the exact bound and what the knots allow, the reason is still a time.
    if shortest > 3.15 {
        let why = refused(default_project(&line(0.7, 3.1501), &limits));
        let NoPath::TooShort { needed_s, .. } = why else { panic!("{why:?}") };
        assert!((3.15..4.0).contains(&needed_s), "{needed_s}");
    }
}

#[test]
fn the_bound_on_the_duration_covers_all_three_regimes() {
    let at = |distance: f64| {
        let path = line(distance, 1.0);
        shortest_straight_s(&path.poses[0], &path.poses[100], &PathLimits::default())
    };
    assert_relative_eq!(at(1.0), 4.35, epsilon = 1e-9); // cruise
    assert_relative_eq!(at(0.001), (32.0f64 * 1e-4).cbrt(), epsilon = 1e-9); // jerk only
    let peak: f64 = 0.15; // acceleration reached, speed not
    assert_relative_eq!(at(peak * (0.1 + peak)), 2.0 * (0.1 + peak), epsilon = 1e-9);
    assert_relative_eq!(at(0.0), 0.0);
}

#[test]
fn the_box_is_kept_or_named() {
    let inner = Box3 { min: Vec3::new(0.2, -0.2, 0.8), max: Vec3::new(0.8, 0.3, 1.05) };
    let limits = PathLimits { workspace: Some(inner), ..PathLimits::default() };
    let why = refused(default_project(&line(0.7, 4.0), &limits));
    let face = Face { axis: 1, is_upper: true, at_m: 0.3 };
    assert_eq!(why.cause(), Cause::Workspace);
    let NoPath::OutsideBox { end: End::Goal, face: found, at_m } = why else { panic!("{why:?}") };
    assert!(found == face && (at_m - 0.5).abs() < 1e-9, "{why:?}");
    // The start lies on a face; the lifted path would leave through the top.
    let (a, b) = (line(0.4, 4.0).poses[0], line(0.4, 4.0).poses[100]);
    let all = candidates(&CandidateSettings::default(), &a, &b, &-Vec3::x(), 1);
    for candidate in &all {
        let reference = reference_path(candidate, &a, &b, 4.0, 100).unwrap();
        let (path, moved) = feasible(default_project(&reference, &limits));
        let found = verify(&path, &limits);
        assert!(found.is_ok(), "{} {:?}", candidate.id, found.violations().collect::<Vec<_>>());
        if candidate.id == "lifted" {
            assert!(moved > 0.05, "{moved}");
            assert!(found.of(Quantity::Workspace).unwrap().value.abs() < 1e-5);
        }
    }
    // A box without height.
    let flat = Box3 { min: Vec3::new(0.2, -0.2, 1.0), max: Vec3::new(0.8, 0.3, 1.0) };
    let limits = PathLimits { workspace: Some(flat), ..PathLimits::default() };
    let reference = reference_path(&all[1], &a, &b, 4.0, 100).unwrap();
    let (path, _) = feasible(default_project(&reference, &limits));
    assert!(verify(&path, &limits).is_ok());
}

#[test]
fn turns_are_checked_in_closed_form() {
    let start = Pose::identity();
    let goal = Pose::new(Vec3::new(0.1, 0.0, 0.0), Vec3::new(0.0, 0.0, 2.0));
    let limits = PathLimits::default();
    let short = minimum_jerk_line(&start, &goal, 4.0, 50).unwrap();
    let why = refused(default_project(&short, &limits));
    let NoPath::TooShortToTurn { angle_rad, needed_s, .. } = why else { panic!("{why:?}") };
    assert_relative_eq!(angle_rad, 2.0, epsilon = 1e-9);
    // The peak of the minimum-jerk law, 1.875 times 2 rad in 4.6875 s, is 0.8 rad/s.
    assert_relative_eq!(needed_s, 4.6875, epsilon = 1e-9);
    let long = minimum_jerk_line(&start, &goal, 4.69, 50).unwrap();
    let (path, _) = feasible(default_project(&long, &limits));
    let found = verify(&path, &limits);
    assert!(found.is_ok());
    assert_relative_eq!(found.of(Quantity::AngularSpeed).unwrap().value, 0.8, max_relative = 1e-3);
}

#[test]
fn nonsense_is_refused_without_panic() {
    let reference = line(0.4, 4.0);
    let (limits, settings) = (PathLimits::default(), ProjectionSettings::default());
    let is_input = |p: Projection| refused(p).cause() == Cause::Input;
    let mut broken = reference.clone();
    broken.poses[7].translation.vector.x = f64::NAN;
    assert!(is_input(project(&broken, &limits, &settings)));
    let empty = TimedPath { time_s: Vec::new(), poses: Vec::new() };
    assert!(is_input(project(&empty, &limits, &settings)));
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let limits = PathLimits { speed_m_s: bad, ..limits };
        assert!(is_input(project(&reference, &limits, &settings)));
        assert!(is_input(project(
            &reference,
            &PathLimits::default(),
            &ProjectionSettings { jerk_weight: bad, ..settings }
        )));
    }
    for steps in [0, 3, 1_000_000] {
        assert!(is_input(project(&reference, &limits, &ProjectionSettings { steps, ..settings })));
    }
    // Extreme but legal numbers: any answer, no panic.
    let huge = PathLimits { speed_m_s: 1e12, jerk_m_s3: 1e-9, ..limits };
    let _ = project(&reference, &huge, &settings);
    let far = line(1e9, 4.0);
    assert_eq!(refused(project(&far, &limits, &settings)).cause(), Cause::Duration);
}

#[test]
fn the_solution_is_optimal_by_its_own_conditions() {
    let limits = PathLimits::default();
    for distance in [0.4, 0.8] {
        let path = line(distance, 4.0);
        let reference: Vec<Vec3> = path.poses.iter().map(|p| p.translation.vector).collect();
        let rows = Rows { acceleration: true, jerk: true, ..Rows::default() };
        let task = Task {
            reference: &reference,
            step_s: 0.04,
            limits: &limits,
            jerk_weight: 1e-4,
            margin: 1e-6,
            rows: &rows,
        };
        let problem = task.problem();
        let Outcome::Solved { x, z, .. } = solve(&problem) else { panic!() };
        let r = crate::qp::residuals(&problem, &x, &z).unwrap();
        for value in [r.equality, r.cone, r.dual_cone] {
            assert!(value < 1e-6, "{r:?}");
        }
        // Multipliers grow with the cost of the way that is cut off, some 1e3 here.
        let largest = z.iter().map(|v| v.abs()).fold(1.0, f64::max);
        assert!(r.stationarity < 1e-6 * largest && r.complementarity < 1e-6 * largest, "{r:?}");
    }
}

#[test]
fn rows_that_are_left_out_change_nothing() {
    // Peak speeds of the reference: 0.6, 0.95 and 1.02 times the limit.
    for share in [0.6, 0.95, 1.02] {
        let limits = PathLimits { speed_m_s: 0.5, ..PathLimits::default() };
        let duration = 4.0;
        let reference = line(share * limits.speed_m_s * duration / 1.875, duration);
        let (path, _) = feasible(default_project(&reference, &limits));
        let positions: Vec<Vec3> = reference.poses.iter().map(|p| p.translation.vector).collect();
        let rows = Rows { acceleration: true, jerk: true, ..Rows::default() };
        let task = Task {
            reference: &positions,
            step_s: duration / (positions.len() - 1) as f64,
            limits: &limits,
            jerk_weight: ProjectionSettings::default().jerk_weight,
            margin: 1e-6,
            rows: &rows,
        };
        assert_eq!(positions.len() - 1, path.steps());
        let Outcome::Solved { x, .. } = solve(&task.problem()) else { panic!() };
        let whole = integrated(&positions[0], task.step_s, task.jerks(&x));
        for (a, b) in path.position.iter().zip(&whole.position) {
            assert!((a - b).norm() < 2e-6, "{share}: {a} {b}");
        }
    }
}

#[test]
fn standing_still_is_feasible() {
    let (path, moved) = feasible(default_project(&line(0.0, 2.0), &PathLimits::default()));
    assert!(moved < 1e-9 && path.velocity.iter().all(|v| v.norm() < 1e-9));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn every_feasible_projection_passes_the_independent_check(
        seed in 0u64..1_000_000,
        goal in (-0.4f64..0.4, -0.5f64..0.5, -0.3f64..0.4),
        angle in 0.0f64..0.8,
        duration in 1.5f64..12.0,
        steps in prop::sample::select(vec![20usize, 50, 100, 160]),
        is_boxed in any::<bool>(),
        offset in 0.02f64..0.4,
    ) {
        each_passes_the_independent_check(seed, goal, angle, (duration, steps), is_boxed, offset)?;
    }
}

#[test]
fn what_once_gave_no_answer_is_projected() {
    let goal = (0.0, 0.152_970_381_878_651_78, -0.089_077_292_975_416_11);
    each_passes_the_independent_check(286_448, goal, 0.0, (1.5, 160), false, 0.02).unwrap();
    // Solved, but the path was over its limits by more than rounding.
    let goal = (-0.086_800_476_588_526_58, 0.0, 0.293_460_723_613_954);
    let steps = (1.563_993_430_829_263, 160);
    each_passes_the_independent_check(0, goal, 0.0, steps, false, 0.02).unwrap();
}

fn each_passes_the_independent_check(
    seed: u64,
    goal: (f64, f64, f64),
    angle: f64,
    (duration, steps): (f64, usize),
    is_boxed: bool,
    offset: f64,
) -> Result<(), TestCaseError> {
    let start = Pose::translation(0.5, 0.0, 1.0);
    let turn = Vec3::new(0.3, -0.5, 0.8).normalize() * angle;
    let goal = Pose::new(Vec3::new(0.5 + goal.0, goal.1, 1.0 + goal.2), turn);
    let inner = Box3 { min: Vec3::new(0.05, -0.55, 0.65), max: Vec3::new(0.95, 0.55, 1.45) };
    let limits = PathLimits { workspace: is_boxed.then_some(inner), ..PathLimits::default() };
    let settings = CandidateSettings { samples: 1, sampled_offset_m: offset, ..Default::default() };
    let projection = ProjectionSettings { steps, ..Default::default() };
    let shortest = shortest_straight_s(&start, &goal, &limits);
    for candidate in candidates(&settings, &start, &goal, &-Vec3::x(), seed).iter().skip(4) {
        let reference = reference_path(candidate, &start, &goal, duration, steps).unwrap();
        match project(&reference, &limits, &projection) {
            Projection::Feasible { path, .. } => {
                let found = verify(&path, &limits);
                let broken: Vec<_> = found.violations().collect();
                prop_assert!(broken.is_empty(), "{broken:?}");
                let end = path.position[steps] - goal.translation.vector;
                prop_assert!(end.norm() < 1e-10, "{end}");
            }
            Projection::Infeasible { why: why @ NoPath::TooShortToTurn { .. }, .. } => {
                // Peaks of the minimum-jerk law: 1.875 and 10 / sqrt 3.
                let speed = 1.875 * angle / duration;
                let acceleration = 10.0 / 3f64.sqrt() * angle / (duration * duration);
                let is_over = speed > limits.angular_speed_rad_s
                    || acceleration > limits.angular_acceleration_rad_s2;
                prop_assert!(is_over, "{why:?}");
            }
            Projection::Infeasible { why, .. } => {
                prop_assert!(why.cause() == Cause::Duration, "{why:?}");
                prop_assert!(duration < shortest * 1.3, "{why:?}");
            }
        }
    }
    Ok(())
}

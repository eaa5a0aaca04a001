//! Obstacles, corridor, reach and the robot's conditions: kept, or named with the smallest change.

use super::*;
use crate::path::{
    CandidateSettings, Cause, Condition, End, Order, Quantity, Reach, candidates, reference_path,
    smallest_changes, verify, verify_optimality, verify_scene,
};
use crate::robot::Obstacle;
use approx::assert_relative_eq;
use proptest::prelude::*;

fn ends(distance: f64) -> (Pose, Pose) {
    (Pose::translation(0.5, -0.2, 1.0), Pose::translation(0.5, -0.2 + distance, 1.0))
}

/// Named candidate over 0.4 m (or another distance) in `duration`.
fn named(index: usize, distance: f64, duration: f64) -> TimedPath {
    let (a, b) = ends(distance);
    let all = candidates(&CandidateSettings::default(), &a, &b, &-Vec3::x(), 1);
    reference_path(&all[index], &a, &b, duration, 100).unwrap()
}

fn post(radius: f64) -> (String, Obstacle) {
    let obstacle =
        Obstacle::Cylinder { pose: Pose::translation(0.5, 0.0, 0.9), radius, length: 0.3 };
    ("post".to_owned(), obstacle)
}

fn block(height: f64) -> (String, Obstacle) {
    let pose = Pose::translation(0.5, 0.0, 0.8);
    ("block".to_owned(), Obstacle::Box { pose, size: Vec3::new(0.6, 0.1, 2.0 * height) })
}

fn within(reference: &TimedPath, limits: &PathLimits, scene: &Scene) -> Projection {
    project_within(reference, limits, scene, &ProjectionSettings::default())
}

fn assert_kept(projection: &Projection, reference: &TimedPath, limits: &PathLimits, scene: &Scene) {
    let Projection::Feasible { path, optimality, .. } = projection else {
        panic!("{projection:?}");
    };
    for found in [
        verify(path, limits),
        verify_scene(path, limits, scene, reference),
        verify_optimality(optimality),
    ] {
        assert!(found.is_ok(), "{:?}", found.violations().collect::<Vec<_>>());
    }
}

fn refused(projection: Projection) -> (NoPath, Vec<Change>) {
    match projection {
        Projection::Infeasible { why, changes } => (why, changes),
        Projection::Feasible { .. } => panic!("feasible"),
    }
}

#[test]
fn a_path_goes_around_an_obstacle_on_the_candidates_side() {
    let limits = PathLimits::default();
    for obstacles in [[block(0.25)], [post(0.03)]] {
        let scene = Scene { obstacles: &obstacles, ..Scene::default() };
        // Straight through, lifted, lowered, toward the body, away.
        let reference = named(1, 0.4, 5.0);
        let projection = within(&reference, &limits, &scene);
        assert_kept(&projection, &reference, &limits, &scene);
        let Projection::Feasible { path, .. } = projection else { return };
        let middle = path.position[50];
        assert!(middle.z > 1.05, "lifted stays above: {middle}");
    }
    let obstacles = [post(0.03)];
    let scene = Scene { obstacles: &obstacles, ..Scene::default() };
    for (index, sign) in [(3, -1.0), (4, 1.0)] {
        let reference = named(index, 0.4, 5.0);
        let projection = within(&reference, &limits, &scene);
        assert_kept(&projection, &reference, &limits, &scene);
        let Projection::Feasible { path, .. } = projection else { return };
        assert!((path.position[50].x - 0.5) * sign > 0.05);
    }
    // Straight through the block: out by the nearest side across the travel, the top.
    let obstacles = [block(0.25)];
    let scene = Scene { obstacles: &obstacles, ..Scene::default() };
    let reference = named(0, 0.4, 5.0);
    let projection = within(&reference, &limits, &scene);
    assert_kept(&projection, &reference, &limits, &scene);
}

#[test]
fn an_obstacle_without_a_way_is_named_with_how_much_smaller_it_would_have_to_be() {
    // A ceiling and a block leave a gap of 20 mm; the tool needs 60.
    let ceiling =
        Obstacle::Box { pose: Pose::translation(0.5, 0.0, 1.17), size: Vec3::new(0.6, 0.1, 0.2) };
    let obstacles = [block(0.25), ("ceiling".to_owned(), ceiling)];
    let scene = Scene { obstacles: &obstacles, ..Scene::default() };
    let limits = PathLimits::default();
    let (why, changes) = refused(within(&named(0, 0.4, 5.0), &limits, &scene));
    let NoPath::Blocked { obstacle, clearance_m: 0.03, .. } = &why else { panic!("{why:?}") };
    assert!(obstacle == "block" || obstacle == "ceiling", "{why:?}");
    let smaller: Vec<f64> = changes
        .iter()
        .filter_map(|c| match c {
            Change::ShrinkObstacle { by_m, .. } => Some(*by_m),
            _ => None,
        })
        .collect();
    assert!(!smaller.is_empty(), "{why:?}");
    for by in smaller {
        // Never too little; a little more for the linearisation about the corners.
        assert!((0.04 - 1e-5..0.041).contains(&by), "{by}");
    }
    // What is named is enough.
    let slimmer = PathLimits { clearance_m: 0.0099, ..limits };
    let reference = named(0, 0.4, 5.0);
    assert_kept(&within(&reference, &slimmer, &scene), &reference, &slimmer, &scene);
    // A goal inside is told by itself.
    let inside = Obstacle::Sphere { center: Vec3::new(0.5, 0.2, 1.03), radius: 0.05 };
    let obstacles = [("ball".to_owned(), inside.clone())];
    let scene = Scene { obstacles: &obstacles, ..Scene::default() };
    let (why, changes) = refused(within(&named(0, 0.4, 5.0), &limits, &scene));
    assert_eq!(why.cause(), Cause::Obstacle);
    let NoPath::InsideObstacle { end: End::Goal, obstacle, depth_m } = &why else {
        panic!("{why:?}")
    };
    assert!(obstacle == "ball" && (depth_m - 0.02).abs() < 1e-9, "{why:?}");
    let Change::MoveEnd { end, by_m, to_m } = &changes[0] else { panic!("{changes:?}") };
    assert_eq!(*end, End::Goal);
    assert_relative_eq!(*by_m, 0.02, epsilon = 1e-9);
    assert_relative_eq!(inside.signed_distance(to_m), 0.0, epsilon = 1e-9);
}

#[test]
fn an_end_nearer_than_the_clearance_lowers_it() {
    let table =
        Obstacle::Box { pose: Pose::translation(0.5, 0.0, 0.94), size: Vec3::new(1.0, 1.0, 0.1) };
    let obstacles = [("table".to_owned(), table)];
    let scene = Scene { obstacles: &obstacles, ..Scene::default() };
    let limits = PathLimits::default();
    let reference = named(2, 0.4, 5.0);
    let projection = within(&reference, &limits, &scene);
    assert_kept(&projection, &reference, &limits, &scene);
}

#[test]
fn corridor_and_reach_bend_the_path_or_are_named() {
    // The reference is too fast, so that the path must fall behind it.
    let limits = PathLimits::default();
    let scene = Scene::default();
    let reference = named(0, 0.8, 4.0);
    let tight = PathLimits { corridor_m: Some(0.005), ..limits };
    let (why, changes) = refused(within(&reference, &tight, &scene));
    assert!(matches!(why, NoPath::Corridor { .. }), "{why:?}");
    let Some(Change::WidenCorridor { to_m, .. }) = changes.first() else { panic!("{why:?}") };
    let enough = PathLimits { corridor_m: Some(to_m * 1.01), ..limits };
    assert_kept(&within(&reference, &enough, &scene), &reference, &enough, &scene);
    let short = PathLimits { corridor_m: Some(to_m * 0.98), ..limits };
    assert_eq!(refused(within(&reference, &short, &scene)).0.cause(), Cause::Corridor);

    let reach = |height: f64, radius_m: f64| {
        [Reach { body: "she".to_owned(), center: Vec3::new(0.5, 0.0, height), radius_m }]
    };
    let limits = PathLimits::default();
    let lifted = named(1, 0.4, 5.0);
    let reaches = reach(0.6, 0.46);
    let scene = Scene { reaches: &reaches, ..Scene::default() };
    let free = within(&lifted, &limits, &Scene::default());
    let Projection::Feasible { path, .. } = &free else { panic!() };
    assert!(!verify_scene(path, &limits, &scene, &lifted).is_ok());
    assert_kept(&within(&lifted, &limits, &scene), &lifted, &limits, &scene);
    let reaches = reach(0.9, 0.2);
    let scene = Scene { reaches: &reaches, ..Scene::default() };
    let (why, _) = refused(within(&lifted, &limits, &scene));
    let NoPath::BeyondReach { end: End::Start, body, by_m } = &why else { panic!("{why:?}") };
    assert_eq!(body, "she");
    assert_relative_eq!(*by_m, 0.2f64.hypot(0.1) - 0.2, epsilon = 1e-9);
}

#[test]
fn conditions_of_the_robot_are_kept_at_their_knots() {
    let limits = PathLimits::default();
    let reference = named(0, 0.4, 5.0);
    let slow: Vec<Condition> = (30..70)
        .map(|knot| Condition { knot, order: Order::Velocity, normal: Vec3::y(), bound: 0.1 })
        .collect();
    let scene = Scene { conditions: &slow, ..Scene::default() };
    let projection = within(&reference, &limits, &scene);
    assert_kept(&projection, &reference, &limits, &scene);
    let Projection::Feasible { path, .. } = projection else { return };
    assert!((30..70).all(|k| path.velocity[k].y < 0.1 + 1e-6));
    let back: Vec<Condition> = (1..100)
        .map(|knot| Condition { knot, order: Order::Velocity, normal: Vec3::y(), bound: -0.1 })
        .collect();
    let scene = Scene { conditions: &back, ..Scene::default() };
    assert_eq!(refused(within(&reference, &limits, &scene)).0, NoPath::JointsTooSlow);
}

#[test]
fn the_smallest_changes_are_enough_and_smallest() {
    let limits = PathLimits::default();
    let settings = ProjectionSettings::default();
    let reference = named(0, 0.7, 3.0);
    let changes = smallest_changes(&reference, &limits, &Scene::default(), &settings);
    let is_feasible = |limits: &PathLimits, duration: f64| {
        let p = project(&named(0, 0.7, duration), limits, &settings);
        matches!(p, Projection::Feasible { .. })
    };
    let mut kinds = Vec::new();
    for change in &changes {
        match change {
            Change::Duration { to_s, .. } => {
                kinds.push("duration");
                assert!((3.15..3.3).contains(to_s), "{to_s}");
                assert!(is_feasible(&limits, *to_s) && !is_feasible(&limits, to_s * 0.99));
            }
            Change::Limit { of: Quantity::Speed, to, .. } => {
                kinds.push("speed");
                let with = |v: f64| PathLimits { speed_m_s: v, ..limits };
                assert!(is_feasible(&with(*to), 3.0) && !is_feasible(&with(to * 0.99), 3.0));
            }
            Change::Limit { .. } => {}
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(kinds, ["duration", "speed"]);
    assert!(matches!(changes[0], Change::Duration { from_s: 3.0, .. }), "{:?}", changes[0]);
    assert!(
        smallest_changes(&named(0, 0.4, 5.0), &limits, &Scene::default(), &settings).is_empty()
    );
}

#[test]
fn a_goal_outside_the_box_says_how_far() {
    let inner = super::super::limits::Box3 {
        min: Vec3::new(0.2, -0.3, 0.8),
        max: Vec3::new(0.8, 0.15, 1.2),
    };
    let limits = PathLimits { workspace: Some(inner), ..PathLimits::default() };
    let (why, changes) = refused(within(&named(0, 0.4, 5.0), &limits, &Scene::default()));
    assert_eq!(why.cause(), Cause::Workspace);
    let [Change::MoveEnd { end: End::Goal, by_m, to_m }, Change::MoveFace { face, by_m: out_m }] =
        &changes[..]
    else {
        panic!("{changes:?}")
    };
    assert_relative_eq!(*by_m, 0.05, epsilon = 1e-9);
    assert_relative_eq!(*to_m, Vec3::new(0.5, 0.15, 1.0), epsilon = 1e-9);
    assert_relative_eq!(*out_m, 0.05, epsilon = 1e-9);
    assert_eq!(*face, inner.face(1, true));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn among_random_obstacles_a_path_is_clear_or_refused(
        seed in 0u64..1_000_000,
        center in (0.35f64..0.65, -0.1f64..0.1, 0.85f64..1.15),
        size in (0.02f64..0.2, 0.02f64..0.2, 0.02f64..0.2),
        turn in (-1.5f64..1.5, -1.5f64..1.5, -1.5f64..1.5),
        shape in 0usize..4,
        duration in 4.0f64..8.0,
    ) {
        let middle = Vec3::new(center.0, center.1, center.2);
        let pose = Pose::new(middle, Vec3::new(turn.0, turn.1, turn.2));
        let size = Vec3::new(size.0, size.1, size.2);
        let obstacle = match shape {
            0 => Obstacle::Box { pose, size },
            1 => Obstacle::Sphere { center: middle, radius: size.x },
            2 => Obstacle::Capsule { a: middle - size, b: middle + size, radius: 0.03 },
            _ => Obstacle::Cylinder { pose, radius: size.x / 2.0, length: size.z },
        };
        let obstacles = [("thing".to_owned(), obstacle)];
        let scene = Scene { obstacles: &obstacles, ..Scene::default() };
        let limits = PathLimits::default();
        let (a, b) = ends(0.4);
        let settings = CandidateSettings { samples: 2, ..Default::default() };
        for candidate in candidates(&settings, &a, &b, &-Vec3::x(), seed).iter().skip(5) {
            let reference = reference_path(candidate, &a, &b, duration, 100).unwrap();
            match within(&reference, &limits, &scene) {
                Projection::Feasible { path, .. } => {
                    for found in [verify(&path, &limits), verify_scene(&path, &limits, &scene, &reference)] {
                        let broken: Vec<_> = found.violations().collect();
                        prop_assert!(broken.is_empty(), "{broken:?}");
                    }
                }
                Projection::Infeasible { why, .. } => {
                    let expected = [Cause::Obstacle, Cause::Duration];
                    prop_assert!(expected.contains(&why.cause()), "{why:?}");
                }
            }
        }
    }
}

//! Tests of path following: what is found, what is refused and why.

use super::super::body::{tcp_pose, tcp_poses};
use super::super::check::LimitKind;
use super::*;
use crate::math::Vec3;
use crate::math::pose::pose_error;
use nalgebra::UnitQuaternion;
use std::f64::consts::PI;

/// Smooth path from 0 to 1 with zero velocity and acceleration at both ends.
fn min_jerk(s: f64) -> f64 {
    s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// A straight line of the TCP, pointing down, in 100 intervals.
fn line(from: Vec3, to: Vec3, duration: f64) -> (Vec<f64>, Vec<Pose>) {
    let down = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), PI);
    let at = |k: i32| Pose::from_parts(from.lerp(&to, min_jerk(f64::from(k) / 100.0)).into(), down);
    ((0..=100).map(|k| duration * f64::from(k) / 100.0).collect(), (0..=100).map(at).collect())
}

fn refusal(robot: &Robot, path: &(Vec<f64>, Vec<Pose>)) -> NoMotion {
    match follow(robot, &path.0, &path.1, &FollowSettings::default()) {
        Follow::Infeasible { why } => why,
        Follow::Feasible(motion) => panic!("feasible: {:?}", motion.qd_share),
    }
}

#[test]
fn random_reachable_poses_are_recovered() {
    for name in super::super::PRESETS {
        let robot = Robot::preset(name).unwrap();
        let mut found = 0;
        for index in 1..=200 {
            let truth = first_guess(&robot, 77, index);
            let pose = tcp_pose(&robot, &truth);
            let settings = FollowSettings { starts: 1, ..FollowSettings::default() };
            let starts = start_postures(&robot, &pose, &settings);
            if let Some(q) = starts.postures.first() {
                found += 1;
                let e = pose_error(&tcp_pose(&robot, q), &pose);
                assert!(e.fixed_rows::<3>(0).norm() < 1e-8 && e.fixed_rows::<3>(3).norm() < 1e-8);
            }
        }
        assert!(found >= 198, "{name}: {found} of 200");
    }
}

#[test]
fn a_straight_path_in_front_of_the_arm_is_followed() {
    for name in super::super::PRESETS {
        let mut robot = Robot::preset(name).unwrap();
        robot.base = Pose::translation(0.0, 0.0, 0.8);
        // Peak speed of the minimum-jerk law is 1.875 times the mean.
        let duration = 1.875 * 0.4 / 0.25;
        // The shortest arm reaches half a metre.
        let (ahead, up) = if name == "ur3e" { (0.3, 1.0) } else { (0.45, 1.2) };
        let mut path = line(Vec3::new(ahead, -0.2, up), Vec3::new(ahead, 0.2, up), duration);
        // As the tool is turned at home: a turn about its axis may need a joint's last degree elsewhere.
        let turn = tcp_poses(&robot, std::slice::from_ref(&robot.home))[0].rotation;
        path.1.iter_mut().for_each(|p| p.rotation = turn);
        let followed = follow(&robot, &path.0, &path.1, &FollowSettings::default());
        let Follow::Feasible(motion) = followed else { panic!("{name}: {followed:?}") };
        assert!(
            motion.max_residual_m < 1e-12 && motion.max_residual_rad < 1e-12,
            "Newton finishes"
        );
        for (own, wanted) in tcp_poses(&robot, &motion.q).iter().zip(&path.1) {
            assert!(pose_error(own, wanted).norm() < 1e-8);
        }
        for pair in motion.q.windows(2) {
            let jump = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs());
            assert!(jump.fold(0.0, f64::max) < 0.05, "{name}: q is continuous");
        }
        assert!(motion.qd_share.value < 0.6, "{name}: {:?}", motion.qd_share);
        assert!(motion.qdd_share.value < 0.6, "{name}: {:?}", motion.qdd_share);
        let (margin, singular) = (motion.position_margin.value, motion.min_singular_value);
        assert!(margin > 0.05 && singular > 0.02, "{name}: {margin} {singular}");
        let again = follow(&robot, &path.0, &path.1, &FollowSettings::default());
        assert_eq!(again, Follow::Feasible(motion));
    }
}

#[test]
fn a_path_out_of_reach_is_refused_with_its_time() {
    let robot = Robot::preset("panda").unwrap();
    let path = line(Vec3::new(0.5, 0.0, 0.4), Vec3::new(1.2, 0.0, 0.4), 4.0);
    let why = refusal(&robot, &path);
    let NoMotion::OutOfReach { time_s, residual_m, .. } = &why else { panic!("{why:?}") };
    assert!((1.0..3.0).contains(time_s) && (1e-8..0.1).contains(residual_m), "{why:?}");
    let path = line(Vec3::new(1.5, 0.0, 0.4), Vec3::new(0.5, 0.0, 0.4), 4.0);
    let why = refusal(&robot, &path);
    assert!(matches!(why, NoMotion::OutOfReach { .. }) && why.time_s() == 0.0, "{why:?}");
}

#[test]
fn a_path_that_is_too_fast_names_joint_value_and_limit() {
    let mut robot = Robot::preset("panda").unwrap();
    let (from, to) = (Vec3::new(0.45, -0.3, 0.4), Vec3::new(0.45, 0.3, 0.4));
    let worst = |why: NoMotion| match why {
        NoMotion::OverLimit { violation, .. } => violation,
        other => panic!("{other:?}"),
    };
    let fast = worst(refusal(&robot, &line(from, to, 0.3)));
    assert!(fast.value > fast.limit && (0.0..0.3).contains(&fast.time_s), "{fast:?}");
    assert!(robot.joint_index(&fast.joint).is_ok());
    // At a leisurely pace only the tightened joint stands in the way.
    robot.set_velocity_limit("panda_joint1", 0.01).unwrap();
    let slow = worst(refusal(&robot, &line(from, to, 5.0)));
    assert_eq!((slow.kind, slow.joint.as_str()), (LimitKind::Velocity, "panda_joint1"));
    assert!(slow.value > slow.limit && slow.limit == 0.01 && !slow.is_assumed, "{slow:?}");
}

#[test]
fn a_joint_at_its_limit_is_named() {
    let mut robot = Robot::preset("ur5e").unwrap();
    // Without the wrist's other side there is one way to hold the tool, and it ends.
    for (joint, q) in ["shoulder_pan_joint", "wrist_2_joint", "wrist_3_joint"].iter().zip([0, 4, 5])
    {
        let at = robot.home[q];
        robot.set_position_limit(joint, at - 0.6, at + 0.6).unwrap();
    }
    let start = tcp_pose(&robot, &robot.home);
    let turn = |k: i32| {
        let about_z = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), 0.02 * f64::from(k));
        Pose::from_parts(start.translation, about_z * start.rotation)
    };
    let path = ((0..60).map(|k| 0.1 * f64::from(k)).collect(), (0..60).map(turn).collect());
    let why = refusal(&robot, &path);
    let (NoMotion::OutOfReach { at_limits, .. } | NoMotion::Jump { at_limits, .. }) = &why else {
        panic!("{why:?}")
    };
    assert!(at_limits.iter().any(|l| l.joint == "wrist_3_joint"), "{why:?}");
    assert!((2.9..3.2).contains(&why.time_s()), "{why:?}");
}

#[test]
fn malformed_paths_are_infeasible_and_never_panic() {
    let robot = Robot::preset("panda").unwrap();
    let good = line(Vec3::new(0.45, -0.2, 0.4), Vec3::new(0.45, 0.2, 0.4), 3.0);
    let mut nan = good.clone();
    nan.1[7].translation.vector.y = f64::NAN;
    let malformed = |fault| NoMotion::Malformed { fault };
    assert_eq!(refusal(&robot, &nan), malformed(PathError::Pose { time_s: nan.0[7] }));
    let mut spun = good.clone();
    spun.1[3].rotation.as_mut_unchecked().coords.x = f64::INFINITY;
    assert_eq!(refusal(&robot, &spun), malformed(PathError::Pose { time_s: spun.0[3] }));
    let mut huge = good.clone();
    huge.1[50].translation.vector.x = 1e300;
    assert!(matches!(refusal(&robot, &huge), NoMotion::OutOfReach { .. }));
    let count = |knots, times| malformed(PathError::Count { knots, times });
    assert_eq!(refusal(&robot, &(vec![], vec![])), count(0, 0));
    assert_eq!(refusal(&robot, &(good.0[1..].to_vec(), good.1.clone())), count(101, 100));
    let backwards: Vec<f64> = good.0.iter().rev().copied().collect();
    let why = refusal(&robot, &(backwards, good.1.clone()));
    assert_eq!(why, malformed(PathError::NotRising { time_s: 3.0 }));
    let none = follow_from(&robot, &good.0, &good.1, &[vec![0.0]], &FollowSettings::default());
    assert_eq!(none, Follow::Infeasible { why: NoMotion::NoStart });
    assert!(start_postures(&robot, &nan.1[7], &FollowSettings::default()).postures.is_empty());
}

#[test]
fn starts_are_distinct_and_depend_on_the_seed_alone() {
    let robot = Robot::preset("ur5e").unwrap();
    let pose = tcp_pose(&robot, &robot.home);
    let find = |seed| start_postures(&robot, &pose, &FollowSettings { seed, ..Default::default() });
    let starts = find(1);
    assert!(starts.postures.len() >= 4, "{}", starts.postures.len());
    assert_eq!(starts.postures[0], robot.home);
    assert_eq!(starts, find(1));
    assert_ne!(starts, find(2));
}

/// A smooth movement of 8 s between the poses of two random postures.
fn between_random(robot: &Robot, number: u32) -> (Vec<f64>, Vec<Pose>) {
    let pose = |index: u32| tcp_pose(robot, &first_guess(robot, 5, index));
    let (a, b) = (pose(2 * number + 1), pose(2 * number + 2));
    let at = |k: i32| crate::math::pose::interpolate(&a, &b, min_jerk(f64::from(k) / 100.0));
    ((0..=100).map(|k| 0.08 * f64::from(k)).collect(), (0..=100).map(at).collect())
}

type Is<'a> = &'a dyn Fn(&NoMotion) -> bool;

#[test]
fn the_global_choice_succeeds_where_tracking_from_every_start_fails() {
    // Over the joints' speed, through the arm itself, and past a limit.
    let accelerates = |why: &NoMotion| matches!(why, NoMotion::OverLimit { violation, .. } if violation.kind == LimitKind::Acceleration);
    let touches = |why: &NoMotion| matches!(why, NoMotion::TouchesItself { .. });
    let jumps = |why: &NoMotion| matches!(why, NoMotion::Jump { .. });
    let cases: [(&str, u32, Is); 3] =
        [("panda", 1, &accelerates), ("panda", 22, &touches), ("fr3", 3, &jumps)];
    for (name, number, is_so) in cases {
        let robot = Robot::preset(name).unwrap();
        let path = between_random(&robot, number);
        let why = refusal(&robot, &path);
        assert!(is_so(&why), "{name} {number}: {why:?}");
        let thorough = FollowSettings { is_thorough: true, ..FollowSettings::default() };
        let followed = follow(&robot, &path.0, &path.1, &thorough);
        let Follow::Feasible(motion) = followed else { panic!("{name} {number}: {followed:?}") };
        // Judged by what did not find it.
        let check = super::super::check_joint_path(&robot, &path.0, &motion.q).unwrap();
        assert!(check.violations.is_empty(), "{:?}", check.violations);
        for (own, wanted) in tcp_poses(&robot, &motion.q).iter().zip(&path.1) {
            assert!(pose_error(own, wanted).norm() < 2e-8);
        }
        let near = super::super::self_clearance(&robot, &path.0, &motion.q).unwrap();
        assert!(near.distance_m > 0.0, "{near:?}");
        assert_eq!(follow(&robot, &path.0, &path.1, &thorough), Follow::Feasible(motion));
    }
}

#[test]
fn the_global_choice_invents_nothing() {
    let robot = Robot::preset("panda").unwrap();
    let thorough = FollowSettings { is_thorough: true, ..FollowSettings::default() };
    let far = line(Vec3::new(0.5, 0.0, 0.4), Vec3::new(1.2, 0.0, 0.4), 4.0);
    let followed = follow(&robot, &far.0, &far.1, &thorough);
    assert!(matches!(followed, Follow::Infeasible { .. }), "{followed:?}");
}

#[test]
fn an_arm_keeps_off_an_obstacle_that_another_motion_avoids() {
    let robot = Robot::preset("panda").unwrap();
    let path = line(Vec3::new(0.45, -0.2, 0.4), Vec3::new(0.45, 0.2, 0.4), 4.0);
    let Follow::Feasible(free) = follow(&robot, &path.0, &path.1, &FollowSettings::default())
    else {
        panic!("it is free")
    };
    // A ball where the elbow of that motion is, half-way.
    let elbow = super::super::stick(&robot, &free.q[50])[4];
    let ball = Obstacle::Sphere { center: elbow + Vec3::z() * 0.08, radius: 0.06 };
    let obstacles = vec![("ball".to_owned(), ball)];
    let settings = FollowSettings { obstacles, is_thorough: true, ..FollowSettings::default() };
    let mut before = free.clone();
    super::super::measure_room(&robot, &path.0, &mut before, &settings.obstacles);
    assert!(before.obstacle_nearest.unwrap().distance_m < 0.0);
    let followed = follow(&robot, &path.0, &path.1, &settings);
    let Follow::Feasible(motion) = followed else { panic!("{followed:?}") };
    let near = motion.obstacle_nearest.unwrap();
    assert!(near.distance_m > 0.0, "{near:?}");
}

/// An arm on a rail across the way, which it uses up.
fn on_a_rail() -> Robot {
    let rail = r#"<link name="rail"/><joint name="slide" type="prismatic"><parent link="rail"/>
        <child link="base_link"/><axis xyz="0 1 0"/>
        <limit lower="-0.2" upper="0.2" velocity="0.5" effort="1"/></joint></robot>"#;
    let text = include_str!("../../../models/robot/ur10e.urdf").replace("</robot>", rail);
    let mut robot =
        Robot::from_text(std::path::Path::new("rail.urdf"), &text, "rail", "tool0").unwrap();
    robot.home[1..].copy_from_slice(&Robot::preset("ur10e").unwrap().home);
    robot
}

#[test]
fn a_slide_stays_in_its_range_between_the_knots() {
    let robot = on_a_rail();
    let start = tcp_pose(&robot, &robot.home);
    let at = |share: f64| {
        let mut pose = start;
        pose.translation.vector.y += 0.7 * share;
        pose
    };
    let share = |t: f64| min_jerk(t / 5.0);
    let time: Vec<f64> = (0..=60).map(|k| f64::from(k) / 12.0).collect();
    let poses: Vec<Pose> = time.iter().map(|t| at(share(*t))).collect();
    let found = follow(&robot, &time, &poses, &FollowSettings::default());
    let Follow::Feasible(motion) = found else { panic!("{found:?}") };
    let farthest = motion.q.iter().map(|q| q[0].abs()).fold(0.0, f64::max);
    assert!(farthest > 0.15, "the rail is used: {farthest}");
    let wanted = |t: f64| at(share(t));
    let between = super::super::between(&robot, &time, &motion.q, 10, wanted).unwrap();
    assert!(between.range.value <= 0.0, "{between:?}");
}

#[test]
fn joints_without_end_start_in_the_turn_nearest_to_zero() {
    let Some(file) = crate::skips::shared("models/robots/kinova.urdf") else { return };
    let (base, tcp) = ("j2s6s200_link_base", "j2s6s200_end_effector");
    let robot = Robot::from_urdf(&file, base, tcp).unwrap();
    let endless: Vec<usize> =
        (0..robot.dof()).filter(|&i| robot.limits.upper[i].is_infinite()).collect();
    assert!(!endless.is_empty());
    let mut seen = 0;
    for sample in 0..20 {
        let q = random_posture(&robot.limits, 7, 0, sample);
        let starts = start_postures(&robot, &tcp_pose(&robot, &q), &FollowSettings::default());
        for posture in &starts.postures {
            seen += 1;
            let most = endless.iter().map(|&i| posture[i].abs()).fold(0.0, f64::max);
            assert!(most <= std::f64::consts::PI + 1e-9, "{posture:?}");
        }
    }
    assert!(seen > 20);
}

//! A robot whose limits bind: the path gives way where it can, or the refusal says by how much.

use super::*;
use crate::math::Pose;
use crate::path::{Cause, Quantity, verify};
use crate::robot::start_postures;
use crate::trajectory::minimum_jerk_line;

fn setting(
    robot: &Robot,
    offset: Vec3,
    duration: f64,
) -> (TimedPath, Vec<Vec<f64>>, FollowSettings) {
    let start = tcp_pose(robot, &robot.home);
    let to = start.translation.vector + offset;
    let goal = Pose::from_parts(to.into(), start.rotation);
    let reference = minimum_jerk_line(&start, &goal, duration, 100).unwrap();
    let settings = FollowSettings::default();
    let starts = start_postures(robot, &start, &settings).postures;
    (reference, starts, settings)
}

fn quick() -> PathLimits {
    PathLimits { speed_m_s: 1.0, acceleration_m_s2: 4.0, jerk_m_s3: 60.0, ..PathLimits::default() }
}

fn run(robot: &Robot, offset: Vec3, duration: f64) -> Followed {
    let (reference, starts, settings) = setting(robot, offset, duration);
    // One way to stand, so that no other way around the limit is left.
    let arm = Arm { robot, starts: &starts[..1], settings: &settings };
    let scene = Scene::default();
    project_for_arm(&reference, &quick(), &scene, &ProjectionSettings::default(), &arm)
}

fn feasible(followed: Followed) -> (RobotMotion, usize) {
    match followed {
        Followed::Feasible { motion, passes, .. } => (*motion, passes),
        Followed::NoPath(refusal) | Followed::NoMotion { refusal, .. } => panic!("{refusal:?}"),
    }
}

#[test]
fn slow_joints_flatten_the_speed() {
    let mut robot = Robot::preset("panda").unwrap();
    let offset = Vec3::new(-0.05, 0.3, -0.05);
    let (motion, passes) = feasible(run(&robot, offset, 1.5));
    assert_eq!(passes, 0);
    // A little less than the fastest joint needs.
    let joint = motion.qd_share.joint.clone();
    let i = robot.joint_index(&joint).unwrap();
    let peak = motion.qd_share.value * robot.limits.velocity[i];
    robot.set_velocity_limit(&joint, 0.85 * peak).unwrap();
    let followed = run(&robot, offset, 1.5);
    let Followed::Feasible { projection, motion, between, passes } = followed else {
        panic!("{:?}", feasible(followed))
    };
    assert!(passes > 0 && motion.qd_share.value <= 1.0 && between.speed.value <= 1.0);
    let Projection::Feasible { path, .. } = projection else { panic!() };
    assert!(verify(&path, &quick()).is_ok());
    assert!(verify(&path, &quick()).of(Quantity::Speed).is_some());
}

#[test]
fn what_the_robot_cannot_do_says_how_much_longer_it_takes() {
    let mut robot = Robot::preset("panda").unwrap();
    let offset = Vec3::new(-0.05, 0.3, -0.05);
    let (motion, _) = feasible(run(&robot, offset, 1.5));
    let joint = motion.qd_share.joint.clone();
    let i = robot.joint_index(&joint).unwrap();
    let peak = motion.qd_share.value * robot.limits.velocity[i];
    robot.set_velocity_limit(&joint, 0.3 * peak).unwrap();
    let followed = run(&robot, offset, 1.5);
    let Followed::NoMotion { refusal, .. } = followed else { panic!("{followed:?}") };
    let Projection::Infeasible { why, changes } = refusal else { panic!() };
    assert_eq!(why.cause(), Cause::Robot);
    let NoPath::NoMotion { motion } = why else { panic!("{why:?}") };
    let NoMotion::OverLimit { violation, .. } = motion else { panic!("{motion:?}") };
    assert_eq!(violation.joint, joint);
    let longer = changes.iter().find_map(|c| match c {
        Change::Duration { to_s, .. } => Some(*to_s),
        _ => None,
    });
    let longer = longer.unwrap();
    assert!((3.0..8.0).contains(&longer), "{longer}");
    feasible(run(&robot, offset, longer * 1.05));
}

#[test]
fn a_goal_beyond_the_arm_says_how_far() {
    let robot = Robot::preset("panda").unwrap();
    let Followed::NoMotion { refusal, .. } = run(&robot, Vec3::new(0.8, 0.0, 0.0), 3.0) else {
        panic!()
    };
    let Projection::Infeasible { why, changes } = refusal else { panic!() };
    let Some(Change::RobotReach { by_m, at_s }) = changes.first() else { panic!("{why:?}") };
    assert!(*by_m > 0.1 && *by_m < 0.8 && *at_s > 2.0, "{by_m} {at_s}");
}

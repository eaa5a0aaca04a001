//! The measurement on paths whose derivatives are known in closed form.

use super::*;
use crate::math::Pose;
use crate::trajectory::{MINIMUM_JERK_PEAK_ACCELERATION, TimedPath, minimum_jerk_line};
use approx::assert_relative_eq;

fn ends(distance: f64, angle: f64) -> (Pose, Pose) {
    let start = Pose::translation(0.5, 0.0, 1.0);
    (start, Pose::new(Vec3::new(0.5, distance, 1.0), Vec3::new(0.0, 0.0, angle)))
}

fn value(v: &Verification, quantity: Quantity) -> f64 {
    v.of(quantity).unwrap().value
}

#[test]
fn samples_of_the_minimum_jerk_line_show_its_closed_form_peaks() {
    let (start, goal) = ends(0.4, 0.6);
    let path = minimum_jerk_line(&start, &goal, 4.0, 400).unwrap();
    let limits = PathLimits {
        workspace: Some(Box3 { min: Vec3::zeros(), max: Vec3::new(1.0, 0.39, 2.0) }),
        ..PathLimits::default()
    };
    let found = verify_samples(&path, &limits);
    assert_relative_eq!(value(&found, Quantity::Speed), 0.1875, max_relative = 1e-3);
    let peak = MINIMUM_JERK_PEAK_ACCELERATION / 16.0;
    assert_relative_eq!(value(&found, Quantity::Acceleration), peak * 0.4, max_relative = 1e-3);
    assert_relative_eq!(value(&found, Quantity::Jerk), 60.0 * 0.4 / 64.0, max_relative = 0.05);
    assert_relative_eq!(value(&found, Quantity::AngularSpeed), 0.28125, max_relative = 1e-3);
    let angular = value(&found, Quantity::AngularAcceleration);
    assert_relative_eq!(angular, peak * 0.6, max_relative = 1e-3);
    assert_relative_eq!(value(&found, Quantity::Workspace), 0.01, epsilon = 1e-9);
    let broken: Vec<_> = found.violations().map(|c| c.quantity).collect();
    assert_eq!(broken, [Quantity::Workspace]);
    let check = found.of(Quantity::Speed).unwrap();
    assert!((check.at_s - 2.0).abs() < 0.02 && check.margin() > 0.06);
    let outside = found.violations().next().unwrap();
    assert!(outside.limit == 0.0 && outside.margin() < 0.0, "{outside:?}");
}

#[test]
fn too_fast_and_not_at_rest_are_seen() {
    use Quantity::{Acceleration, AngularAcceleration, AngularSpeed, Jerk, Speed};
    let (start, goal) = ends(0.4, 2.0);
    let fast = minimum_jerk_line(&start, &goal, 1.0, 100).unwrap();
    let found = verify_samples(&fast, &PathLimits::default());
    let broken: Vec<_> = found.violations().map(|c| c.quantity).collect();
    assert_eq!(broken, [Speed, Acceleration, Jerk, AngularSpeed, AngularAcceleration]);
    // Constant speed from the first moment on, within every other limit but the jerk it takes.
    let moving = TimedPath::sample(4.0, 200, |t| Pose::translation(0.1 * t, 0.0, 0.0)).unwrap();
    let found = verify_samples(&moving, &PathLimits::default());
    let broken: Vec<_> = found.violations().map(|c| c.quantity).collect();
    assert_eq!(broken, [Quantity::Rest]);
}

#[test]
fn uneven_times_and_rounded_positions_do_no_harm() {
    let (start, goal) = ends(0.4, 0.6);
    let even = minimum_jerk_line(&start, &goal, 4.0, 2000).unwrap();
    let keep = |i: &usize| i.is_multiple_of(7) || i.is_multiple_of(3) || *i == 2000;
    let (mut time, mut poses) = (Vec::new(), Vec::new());
    for i in (0..=2000).filter(keep) {
        time.push(even.time_s[i]);
        let round = |x: f64| (x * 1e6).round() / 1e6;
        let mut pose = even.poses[i];
        pose.translation.vector.apply(|x| *x = round(*x));
        poses.push(pose);
    }
    let found = verify_samples(&TimedPath::new(time, poses).unwrap(), &PathLimits::default());
    assert!(found.is_ok(), "{:?}", found.violations().collect::<Vec<_>>());
    assert_relative_eq!(value(&found, Quantity::Speed), 0.1875, max_relative = 0.01);
}

fn smooth() -> SmoothPath {
    // Bang-bang jerk in y: rest to rest over 0.128 m in 1.6 s.
    let (start, goal) = ends(0.128, 0.3);
    let jerk = [1.0, -1.0, -1.0, 1.0].map(|j| Vec3::y() * j);
    SmoothPath::integrate(&start, &goal, 0.4, jerk.to_vec())
}

#[test]
fn a_smooth_path_is_measured_exactly_between_knots() {
    let path = smooth();
    let found = verify(&path, &PathLimits::default());
    assert!(found.is_ok(), "{:?}", found.violations().collect::<Vec<_>>());
    assert_relative_eq!(value(&found, Quantity::Speed), 0.16, epsilon = 1e-12);
    assert_relative_eq!(value(&found, Quantity::Acceleration), 0.4, epsilon = 1e-12);
    assert_relative_eq!(value(&found, Quantity::Jerk), 1.0);
    let tight = PathLimits { speed_m_s: 0.16 * (1.0 - 1e-8), ..PathLimits::default() };
    assert!(!verify(&path, &tight).is_ok());
    assert_relative_eq!(path.state_at(0.8)[0].y, 0.064, epsilon = 1e-12);
    assert_relative_eq!(path.twist_at(0.8)[1], 0.16, epsilon = 1e-12);
    assert_relative_eq!(path.twist_at(0.8)[5], 1.875 * 0.3 / 1.6, epsilon = 1e-12);
    assert_eq!(path.timed(16).unwrap().time_s.len(), 17);
}

#[test]
fn tampering_is_seen() {
    let limits = PathLimits::default();
    let broken = |change: fn(&mut SmoothPath)| {
        let mut path = smooth();
        change(&mut path);
        !verify(&path, &limits).is_ok()
    };
    assert!(broken(|p| p.position[2].x += 1e-6));
    assert!(broken(|p| p.velocity[4].x += 1e-6));
    assert!(broken(|p| p.jerk[1].x = f64::NAN));
    assert!(broken(|p| p.acceleration[0].z = f64::NAN));
    assert!(broken(|p| {
        p.jerk.pop();
    }));
    assert!(broken(|p| p.jerk.clear()));
    let nan = PathLimits { speed_m_s: f64::NAN, ..limits };
    assert!(!verify(&smooth(), &nan).is_ok());
    let empty = TimedPath { time_s: Vec::new(), poses: Vec::new() };
    assert!(!verify_samples(&empty, &limits).is_ok());
    let two = minimum_jerk_line(&Pose::identity(), &Pose::identity(), 1.0, 1).unwrap();
    assert!(verify_samples(&two, &limits).is_ok());
}

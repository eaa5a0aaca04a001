//! Which values are doubted, and which are not.

#![expect(clippy::approx_constant, reason = "as people type them")]

use super::*;
use crate::math::Vec3;

#[test]
fn angles_that_are_round_in_radians_are_doubted_and_small_degrees_are_not() {
    for values in [
        &[3.1416, 0.0, 1.5708][..],
        &[0.0, 0.0, 3.14],
        &[-1.57, 0.0, 0.3],
        &[0.785],
        &[PI],
        &[6.2832],
        &[3.1415, 0.0, 0.0],
    ] {
        assert!(radians("rpy_deg", values).is_some(), "{values:?}");
    }
    for values in [
        &[180.0, 0.0, -90.0][..],
        &[0.0, 0.0, 0.0],
        &[3.0, 0.0, 1.5],
        &[5.5],
        &[1.6, 0.8, 2.4],
        &[90.0, 0.0, 1.5708],
        &[1.0, 2.0, 3.0],
    ] {
        assert!(radians("rpy_deg", values).is_none(), "{values:?}");
    }
    let words = radians("start.rpy_deg", &[3.1416, 0.0, 1.5708]).unwrap().warning();
    assert!(words.contains("start.rpy_deg = [3.1416, 0.0, 1.5708]"), "{words}");
    assert!(words.contains("180.0, 0.0, 90.0"), "{words}");
}

#[test]
fn the_order_of_a_quaternion_is_told_from_the_ends() {
    let pose = |r, p, y| {
        Pose::from_parts(Vec3::zeros().into(), UnitQuaternion::from_euler_angles(r, p, y))
    };
    let (start, goal) = (pose(PI, 0.1, 0.4), pose(PI, 0.0, 0.9));
    let swapped = |p: &Pose, is_last: bool| {
        let q = p.rotation;
        let q = if is_last {
            Quaternion::new(q.i, q.j, q.k, q.w)
        } else {
            Quaternion::new(q.k, q.w, q.i, q.j)
        };
        Pose::from_parts(p.translation, UnitQuaternion::new_normalize(q))
    };
    let ends = [&start, &goal];
    assert_eq!(order("", ends, ends), None);
    for last in [true, false] {
        let (a, b) = (swapped(&start, last), swapped(&goal, last));
        let Some(Doubt::QuaternionOrder { off_deg, other_deg, is_last, .. }) =
            order("", [&a, &b], ends)
        else {
            panic!("{last}")
        };
        assert!(is_last == last && off_deg > 90.0 && other_deg < 1e-6, "{off_deg} {other_deg}");
    }
    // A path that is merely turned is no question of order.
    let turned = pose(PI, 0.1, 1.5);
    assert_eq!(order("", [&turned, &turned], ends), None);
}

#[test]
fn degrees_and_millimetres_of_joints_are_told_from_the_limits() {
    let panda = Robot::preset("panda").unwrap();
    let doubt = |value| of_joint(&panda, 0, value, || "here".to_owned());
    assert_eq!(doubt(3.5), None);
    assert_eq!(doubt(-9.0), None);
    assert!(matches!(doubt(45.0), Some(Doubt::Degrees { beyond: Some(b), .. }) if b > 40.0));
    assert!(matches!(doubt(-90.0), Some(Doubt::Degrees { .. })));
}

#[test]
fn names_that_cannot_be_shown_or_are_taken_are_refused() {
    for name in
        ["straight", "s012", "without duration", "a/b", "a\nb", "\u{1b}[31m", "  ", "=1+1", "@a"]
    {
        assert!(path_name_fault(name).is_some(), "{name:?}");
    }
    assert!(path_name_fault(&"x".repeat(10_000)).unwrap().contains("10000"));
    for name in ["today", "side", "s", "shift 2", "s12b", "vor Umbau", "-5"] {
        assert_eq!(path_name_fault(name), None, "{name}");
    }
}

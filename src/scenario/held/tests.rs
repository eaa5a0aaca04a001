//! Grips, directions and places as they are written, against what they mean.

use crate::human::{NamedGrip, Side, palm};
use crate::math::{Pose, Vec3};
use crate::posture::Hold;
use crate::scenario::{Scenario, read_scenario};
use approx::assert_relative_eq;
use nalgebra::UnitQuaternion;
use std::f64::consts::{FRAC_PI_2, PI};

/// A cell with these tables; a worker who faces `facing_deg`.
fn cell(worker: &str, grip: &str, start: &str, goal: &str) -> Result<Scenario, String> {
    cell_with_base("position_m = [0.95, 0, 0.75]", worker, grip, start, goal)
}

fn cell_with_base(
    base: &str,
    worker: &str,
    grip: &str,
    start: &str,
    goal: &str,
) -> Result<Scenario, String> {
    let text = format!(
        "schema = \"ergopath/scenario/1\"\nname = \"a\"\n[worker]\nbodies = [\"female_p50\"]\n\
         posture_model = \"people\"\nat_m = [0, 0]\n{worker}\n[robot]\npreset = \"panda\"\n\
         base = {{ {base} }}\n[motion]\nduration_s = 4\n[grip]\n{grip}\n[start]\n{start}\n[goal]\n{goal}\n"
    );
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("cell.toml");
    std::fs::write(&path, text).unwrap();
    read_scenario(&path).map_err(|e| {
        let shown = format!("{:?}", miette::Report::new(e));
        // However the message is wrapped.
        shown.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
    })
}

const RIGHT: &str = "facing_deg = 0";
const BOTH: &str = "facing_deg = 0\nhands = \"both\"";
const DOWN: &str = "position_m = [0.5, 0, 1]\npointing = [0, 0, -1]";

fn hand(s: &Scenario, tcp: &Pose) -> (Vec3, Vec3, Vec3) {
    let (side, grip) = s.hands_at(tcp)[0];
    (palm(side, &grip.rotation), grip.rotation * Vec3::z(), grip.rotation * Vec3::y())
}

#[test]
fn directions_say_what_angles_say() {
    // A tool that points down with its x axis ahead, and a vertical bar below it: as the shipped cells have it.
    let by_angles = cell(
        RIGHT,
        "rpy_deg = [180, 0, -90]\nhold = \"rigid\"",
        "position_m = [0.5, 0, 1]\nrpy_deg = [180, 0, 0]",
        "position_m = [0.5, 0.2, 1]\nrpy_deg = [0, -90, 0]",
    )
    .unwrap();
    let by_directions = cell(
        RIGHT,
        "pointing = [0, 0, -2]\nx_along = [0, -1, 0]\nhold = \"rigid\"",
        "position_m = [0.5, 0, 1]\npointing = [0, 0, -1]\nx_along = [5, 0, 0]",
        "position_m = [0.5, 0.2, 1]\npointing = [-1, 0, 0]\nx_along = [0, 0, 1]",
    )
    .unwrap();
    for (a, b) in [
        (by_angles.start, by_directions.start),
        (by_angles.goal, by_directions.goal),
        (by_angles.grip, by_directions.grip),
    ] {
        assert!(a.rotation.angle_to(&b.rotation) < 1e-7, "{a} {b}");
    }
}

#[test]
fn a_bar_turns_the_tool() {
    // The bar across the tool, along the TCP's y axis; the thumb ends at +y.
    let s = cell(
        RIGHT,
        "pointing = [0, 1, 0]\nx_along = [0, 0, 1]\nhold = \"free_roll\"",
        "position_m = [0.5, 0, 1]\npointing = [0, 0, -1]\nbar_along = [0, 1, 0]",
        "position_m = [0.5, 0, 1.2]\npointing = [0, 0, -1]\nbar_along = [1, 1, 0]",
    )
    .unwrap();
    assert_relative_eq!(s.start.rotation * Vec3::y(), Vec3::y(), epsilon = 1e-12);
    assert_relative_eq!(s.start.rotation * Vec3::z(), -Vec3::z(), epsilon = 1e-12);
    let across = Vec3::new(1.0, 1.0, 0.0).normalize();
    assert_relative_eq!(s.goal.rotation * Vec3::y(), across, epsilon = 1e-12);
}

#[test]
fn a_named_grip_is_as_the_worker_sees_it_whatever_the_tool() {
    for tool in ["pointing = [0, 0, -1]", "pointing = [-1, 0, 0.3]", "rpy_deg = [20, 30, 40]"] {
        for (facing, turn) in [(0.0, 0.0), (90.0, FRAC_PI_2), (200.0, 200.0 * PI / 180.0)] {
            let start = format!("hand_at_m = [0.3, 0.1, 1]\n{tool}");
            let s = cell(
                &format!("facing_deg = {facing}"),
                "grip = \"palm_down_bar\"\nposition_m = [0, 0.02, 0.1]",
                &start,
                &start.replace("1]\n", "1.2]\n"),
            )
            .unwrap();
            let facing = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), turn);
            for tcp in [&s.start, &s.goal] {
                let (palm, thumb, wrist) = hand(&s, tcp);
                assert_relative_eq!(palm, -Vec3::z(), epsilon = 1e-9);
                assert_relative_eq!(thumb, facing * Vec3::y(), epsilon = 1e-9);
                assert_relative_eq!(wrist, facing * -Vec3::x(), epsilon = 1e-9);
            }
            let at = s.hands_at(&s.start)[0].1.translation.vector;
            assert_relative_eq!(at, Vec3::new(0.3, 0.1, 1.0), epsilon = 1e-12);
            assert_relative_eq!(s.grip.translation.vector, Vec3::new(0.0, 0.02, 0.1));
            assert_eq!(s.hold, Hold::FreeRoll);
        }
    }
}

#[test]
fn a_tool_that_only_points_has_its_x_axis_ahead_or_up() {
    let turn = |pointing: &str, facing: &str| {
        let start = format!("position_m = [0.5, 0, 1]\npointing = {pointing}");
        let goal = start.replace("1]\n", "1.2]\n");
        let grip = "grip = \"vertical_handle\"";
        cell(&format!("facing_deg = {facing}"), grip, &start, &goal).unwrap().start.rotation
    };
    assert_relative_eq!(turn("[0, 0, -1]", "0") * Vec3::x(), Vec3::x(), epsilon = 1e-12);
    assert_relative_eq!(turn("[0, 0, -1]", "90") * Vec3::x(), Vec3::y(), epsilon = 1e-12);
    assert_relative_eq!(turn("[-1, 0, 0]", "0") * Vec3::x(), Vec3::z(), epsilon = 1e-12);
    assert_relative_eq!(turn("[0, 1, 0]", "0") * Vec3::x(), Vec3::x(), epsilon = 1e-12);
    // Pointing at the worker and down: across that, up and towards the worker.
    let x = turn("[-1, 0, -0.5]", "0") * Vec3::x();
    assert!(x.z > 0.8 && x.x < 0.0, "{x}");
}

#[test]
fn bar_along_turns_a_named_grip_about_the_vertical_and_the_goal_with_it() {
    let bar = "pointing = [0, 0, -1]\nbar_along = [1, -1, 0]";
    let s = cell(
        RIGHT,
        "grip = \"palm_down_bar\"",
        &format!("hand_at_m = [0.4, 0, 1]\n{bar}"),
        "hand_at_m = [0.4, 0, 1.2]\npointing = [0, 0, -1]\nbar_along = [0, 1, 0]",
    )
    .unwrap();
    // Either way along the bar is meant: the thumb stays on the left.
    let (palm, thumb, wrist) = hand(&s, &s.start);
    assert_relative_eq!(palm, -Vec3::z(), epsilon = 1e-9);
    assert_relative_eq!(thumb, Vec3::new(-0.5f64.sqrt(), 0.5f64.sqrt(), 0.0), epsilon = 1e-9);
    assert!(wrist.x < -0.7 && wrist.y < -0.7);
    // At the goal the bar runs across: the hand has turned by 45 deg, the short way, the tool with it.
    let (palm, thumb, _) = hand(&s, &s.goal);
    assert_relative_eq!(palm, -Vec3::z(), epsilon = 1e-9);
    assert_relative_eq!(thumb, Vec3::y(), epsilon = 1e-9);
    assert_relative_eq!(s.start.rotation.angle_to(&s.goal.rotation), PI / 4.0, epsilon = 1e-9);
    assert_relative_eq!(s.goal.rotation * Vec3::z(), -Vec3::z(), epsilon = 1e-9);
}

#[test]
fn both_hands_are_mirror_images_and_lie_about_the_place_that_is_given() {
    for name in NamedGrip::names() {
        let hand = |side: &str, left: f64| {
            format!("[grip.{side}]\ngrip = \"{name}\"\nfrom_tcp_m = [-0.17, {left}, 0.01]\n")
        };
        let s = cell(
            BOTH,
            &(hand("right", -0.19) + &hand("left", 0.19)),
            "hand_at_m = [0.47, 0.0, 0.35]\npointing = [-1, 0, 0]",
            "hand_at_m = [0.43, 0.0, 1.10]\npointing = [-1, 0, 0]",
        )
        .unwrap();
        let [(Side::Right, right), (Side::Left, left)] = s.hands_at(&s.start)[..] else { panic!() };
        let mirrored = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
        for axis in [Vec3::z(), Vec3::y()] {
            assert_relative_eq!(mirrored(right * axis), left * axis, epsilon = 1e-9);
        }
        assert_relative_eq!(right.translation.vector, Vec3::new(0.47, -0.19, 0.35), epsilon = 1e-9);
        assert_relative_eq!(left.translation.vector, Vec3::new(0.47, 0.19, 0.35), epsilon = 1e-9);
        assert_relative_eq!(s.start.translation.vector, Vec3::new(0.64, 0.0, 0.34), epsilon = 1e-9);
    }
}

#[test]
fn a_base_is_given_by_its_mount_too() {
    let start = "hand_at_m = [0.4, 0, 1]\npointing = [0, 0, -1]";
    let goal = "hand_at_m = [0.4, 0, 1.2]\npointing = [0, 0, -1]";
    let base = |text: &str| cell_with_base(text, RIGHT, "grip = \"vertical_handle\"", start, goal);
    let by_mount = base("at_m = [0.9, 0.1], mount_height_m = 0.75, x_along = [-1, 0, 0]").unwrap();
    let by_place = base("position_m = [0.9, 0.1, 0.75], rpy_deg = [0, 0, 180]").unwrap();
    let (a, b) = (by_mount.robot.base, by_place.robot.base);
    assert_eq!(a.translation, b.translation);
    assert!(a.rotation.angle_to(&b.rotation) < 1e-7);
    // From the ceiling.
    let hung =
        base("position_m = [0.9, 0, 2.4], pointing = [0, 0, -1], x_along = [0, 1, 0]").unwrap();
    assert_relative_eq!(hung.robot.base.rotation * Vec3::z(), -Vec3::z(), epsilon = 1e-12);
    let refused = |text: &str, words: &str| {
        let shown = base(text).unwrap_err();
        assert!(shown.contains(words), "`{words}` is missing in {shown}");
    };
    refused("at_m = [0.9, 0.1]", "at_m without mount_height_m");
    refused("mount_height_m = 0.7", "robot.base has no place");
    refused("position_m = [0, 0, 0], mount_height_m = 0.7", "keep position_m, or");
    refused("position_m = [0, 0, 0], pointing = [0, 0, -1]", "pointing alone leaves");
    refused("at_m = [900, 0], mount_height_m = 0.7", "Is it in millimetres?");
}

#[test]
fn what_is_open_or_contradicts_is_refused_with_a_remedy() {
    let own = "rpy_deg = [180, 0, -90]\nhold = \"rigid\"";
    let across = "pointing = [0, 1, 0]\nx_along = [0, 0, 1]\nhold = \"rigid\"";
    let named = "grip = \"palm_down_bar\"";
    let at = |turn: &str| format!("position_m = [0.5, 0, 1]\n{turn}");
    for (grip, turn, words) in [
        (own, "pointing = [0, 0, 0]\nx_along = [1, 0, 0]", "is no direction"),
        (own, "pointing = [nan, 0, 1]\nx_along = [1, 0, 0]", "is no direction"),
        (
            own,
            "pointing = [0, 0, -1]",
            "pointing alone leaves the turn about it open help: add bar_along",
        ),
        (own, "x_along = [0, 0, -1]", "x_along without pointing"),
        (own, "pointing = [0, 0, -1]\nx_along = [0, 0, 1]", "runs along pointing"),
        (
            own,
            "pointing = [0, 0, -1]\nx_along = [1, 0, -1]",
            "at 45 deg to pointing = [0.0, 0.0, -1.0], not at a right angle help: the nearest that fits: x_along = [1, 0, 0]",
        ),
        (own, "pointing = [0, 0, -1]\nbar_along = [0, 1, 0]", "lies along the tool's own axis"),
        (
            across,
            "pointing = [0, 0, -1]\nbar_along = [0, 1, -1]",
            "at 45 deg to pointing, but the held bar at 90 deg to the tool's axis help: the nearest that fits: bar_along = [0, 1, 0]",
        ),
        (
            across,
            "pointing = [0, 0, -1]\nbar_along = [0, 1, 0]\nx_along = [1, 0, 0]",
            "both x_along and bar_along",
        ),
        (
            own,
            "pointing = [0, 0, -1]\nrpy_deg = [0, 0, 0]",
            "both rpy_deg and pointing help: keep the angles or the directions",
        ),
        (
            own,
            "pointing = [0, 0, -1]\nquaternion_wxyz = [1, 0, 0, 0]",
            "both quaternion_wxyz and pointing",
        ),
        (own, "rpy_deg = [0, 0, 0]\nbar_along = [0, 0, 1]", "both rpy_deg and bar_along"),
        (own, "hand_at_m = [0, 0, 1]", "both position_m and hand_at_m"),
        (named, "", "start does not say how the tool is turned"),
        (
            named,
            "pointing = [0, 0, -1]\nbar_along = [1, 0.2, 0]",
            "is 79 deg from the bar of `palm_down_bar`",
        ),
        ("grip = \"palm_down\"", "pointing = [0, 0, -1]", "did you mean `palm_down_bar`?"),
        ("grip = \"glue\"", "pointing = [0, 0, -1]", "grips: palm_down_bar, palm_up_bar"),
        (
            "grip = \"box_side\"\nrpy_deg = [0, 0, 1]",
            "pointing = [0, 0, -1]",
            "a named grip and an orientation",
        ),
        (
            "grip = \"box_side\"\nposition_m = [0, 0, 1]\nfrom_tcp_m = [0, 0, 1]",
            "pointing = [0, 0, -1]",
            "both position_m and from_tcp_m",
        ),
        (
            "from_tcp_m = [0, 0, 1]\nhold = \"rigid\"",
            "rpy_deg = [0, 0, 1]",
            "goes with a named grip only",
        ),
        (
            "grip = \"box_side\"\nfrom_tcp_m = [0, 0, 170]",
            "pointing = [0, 0, -1]",
            "Is it in millimetres?",
        ),
        ("rpy_deg = [0, 0, 1]", "rpy_deg = [0, 0, 1]", "grip.hold is missing"),
        (
            "pointing = [0, 0, 1]\nhold = \"rigid\"",
            "rpy_deg = [0, 0, 1]",
            "add x_along: out of the palm of a right hand",
        ),
    ] {
        let shown = cell(RIGHT, grip, &at(turn), DOWN).unwrap_err();
        let flat = shown.replace(['│', '·', '╭', '╰', '─'], " ");
        let flat = flat.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in words.split(" help: ") {
            assert!(flat.contains(part), "`{part}` is missing in {flat}");
        }
        // A place in the text wherever a direction is at fault.
        if ["pointing", "along", "hand_at"].iter().any(|key| words.contains(key)) {
            assert!(shown.contains("here"), "{shown}");
        }
    }
    let mixed = "[grip.right]\ngrip = \"box_side\"\n[grip.left]\nhold = \"rigid\"";
    let shown = cell(BOTH, mixed, DOWN, DOWN).unwrap_err();
    assert!(shown.contains("has a named grip, the other has not"), "{shown}");
    let start = "pointing = [0, 0, -1]";
    let shown = cell(RIGHT, named, start, DOWN).unwrap_err();
    assert!(shown.contains("start has no place") && shown.contains("give hand_at_m"), "{shown}");
}
